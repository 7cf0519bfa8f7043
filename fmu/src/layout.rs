//! Arrays as single variables, in versions of the standard that have arrays: maps value references to rows and texts.

use blocks::table::arrays::{Group, grouped};
use blocks::{Table, TableText};

/// The variables to which value references refer: the rows, followed by the texts.
#[derive(Debug)]
pub struct Layout {
    parts: Vec<Referent>,
}

/// The variable to which a value reference refers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Referent {
    /// A single value.
    Single,
    /// An array, which has the value reference of its first element; contains the references of all elements.
    Array(Vec<u32>),
    /// An element other than the first of the array with this value reference.
    Inside(u32),
}

impl Layout {
    /// The arrays of a table; `None` if it has none.
    pub fn new<S: TableText>(table: &Table<S>) -> Option<Layout> {
        let rows = grouped(table.rows.iter().map(|row| (&*row.name, (row.kind, row.role))), true);
        let texts = grouped(table.texts.iter().map(|text| (&*text.name, (text.ty.name(), text.role))), true);
        let mut parts = vec![Referent::Single; table.rows.len() + table.texts.len()];
        let mut has_arrays = false;
        let first = table.rows.len();
        let mut add = |group: &Group, first: usize| {
            if group.bounds.is_empty() {
                return;
            }
            has_arrays = true;
            let references: Vec<u32> = group.rows.iter().map(|row| (first + row) as u32).collect();
            let whole = references[0];
            for reference in &references[1..] {
                parts[*reference as usize] = Referent::Inside(whole);
            }
            parts[whole as usize] = Referent::Array(references);
        };
        rows.iter().for_each(|group| add(group, 0));
        texts.iter().for_each(|group| add(group, first));
        has_arrays.then_some(Layout { parts })
    }

    /// The variable to which a value reference refers; a single value if it is not part of an array.
    pub fn part(&self, reference: u32) -> &Referent {
        self.parts.get(reference as usize).unwrap_or(&Referent::Single)
    }
}
