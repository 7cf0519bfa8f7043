//! Finds the variables of an FMU for the rows of the table it was built from, regardless of its version and types.

use crate::arrays::Array;
use crate::description::{Description, Type, Variable};
use crate::names::Names;
use blocks::table::arrays::grouped;
use blocks::table::number::{of_exact, to_value};
use blocks::{Kind, Types, Value};
use std::collections::HashMap;

impl Description {
    /// The variable index of each row of a table; `None` if the FMU lacks the row. A row is given by its name and a key
    /// that all elements of an array have in common; the FMU may have flat [`Names`]. Array indices start at 1 here,
    /// regardless of their lower bound in the PLC. The description must be [`expanded`](Description::expanded).
    pub fn places<'a, K: PartialEq>(&self, rows: impl Iterator<Item = (&'a str, K)>) -> Vec<Option<usize>> {
        let rows: Vec<(&str, K)> = rows.collect();
        let names: HashMap<&str, usize> = self.variables.iter().map(|of| of.name.as_str()).zip(0..).collect();
        let arrays: HashMap<&str, &Array> = self.arrays.iter().map(|of| (of.name.as_str(), of)).collect();
        let mut places: Vec<Option<usize>> = rows.iter().map(|(name, _)| find(&names, name).copied()).collect();
        for group in grouped(rows.iter().map(|(name, of)| (*name, of)), !arrays.is_empty()) {
            let Some(array) = find(&arrays, &group.name).filter(|_| !group.bounds.is_empty()) else { continue };
            for (element, row) in group.rows.iter().enumerate() {
                places[*row] = (element < array.count).then(|| array.first + element);
            }
        }
        places
    }
}

/// Looks up an FMU's entry under a PLC name.
fn find<'a, T>(all: &'a HashMap<&str, T>, name: &str) -> Option<&'a T> {
    all.get(name).or_else(|| all.get(&*Names::Flat.convert(name)))
}

impl Variable {
    /// Whether it can hold the values of a PLC type.
    pub fn is_of(&self, kind: Kind) -> bool {
        let has_name = |types: Types| [false, true].map(|of| types.host_type(kind, of)).contains(&self.type_name);
        let is_real = kind != Kind::Time || self.unit.as_deref() == Some("s");
        match self.kind {
            Some(own) if own == Type::from_kind(kind) && is_real => true,
            _ => has_name(Types::Native) || has_name(Types::Wide),
        }
    }

    /// The value before initialization, converted to a PLC type; `None` if there is none.
    ///
    /// # Errors
    /// The value is not valid for the type; the error is a description of the permitted values.
    pub fn start_of(&self, kind: Kind) -> Result<Option<Value>, &'static str> {
        match self.exact.first() {
            Some(exact) => of_exact(*exact, kind).map(Some),
            None => self.start.map(|start| to_value(start, kind)).transpose(),
        }
    }
}
