//! Assigns each signal the same colour in all pictures, on the pages and in the plots of a run.

use anyhow::{Context, Result};
use blocks::{Block, EachBlock};
use draw::response::Colors;
use modeldescription::Table;

/// The colours of the variables in a block's charts.
///
/// # Errors
/// The dialog in the block's documentation does not match its table.
pub fn assign(table: &Table) -> Result<Colors> {
    colors(table, known)
}

fn colors(table: &Table, known: impl Fn(&str) -> Option<usize>) -> Result<Colors> {
    let (roles, _) = run::dialog::read(table).context("the dialog of the block")?;
    Ok(Colors::new(table, roles.signals().map(|role| role.map(String::as_str)), known))
}

/// The colour of a variable with this name on the page of the first linked block or plant that draws it.
pub fn known(name: &str) -> Option<usize> {
    let mut search = Search { name, found: None };
    blocks::for_each_block(&mut search);
    plants::for_each_plant(&mut search);
    search.found
}

struct Search<'a> {
    name: &'a str,
    found: Option<usize>,
}

impl EachBlock for Search<'_> {
    fn block<B: Block>(&mut self) {
        if self.found.is_some() || B::TABLE.find(self.name).is_none() {
            return;
        }
        let table = Table::from(B::TABLE);
        // Variables of inner blocks have a dot in their names, and are never looked up.
        self.found = table.find(self.name).and_then(|row| colors(&table, |_| None).ok()?.of_row(row));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_controller_computes_has_the_colours_of_the_pictures_in_python() {
        // plot.py: black, blue, vermilion, purple, green, ochre; sky blue for what acts against.
        let names = ["SP_INT", "PV", "LMN", "LMN_P", "LMN_I", "LMN_D", "TEMP", "QLMNUP", "QLMNDN"];
        assert_eq!(names.map(known), [6, 0, 1, 3, 2, 4, 0, 1, 5].map(Some));
        assert_eq!(known("NO_SUCH_SIGNAL"), None);
    }

    #[test]
    fn a_block_inside_another_has_the_colours_of_its_own_page() {
        struct Inner(Vec<(String, Option<usize>)>);
        impl EachBlock for Inner {
            fn block<B: Block>(&mut self) {
                let table = Table::from(B::TABLE);
                let colors = assign(&table).unwrap();
                let rows = table.rows.iter().enumerate().filter(|(_, row)| row.name.contains('.'));
                self.0.extend(rows.map(|(at, row)| (row.name.clone(), colors.of_row(at))));
            }
        }
        let mut inner = Inner(Vec::new());
        blocks::for_each_block(&mut inner);
        let color = |end: &str| inner.0.iter().find(|(name, _)| name.ends_with(end)).unwrap().1;
        assert_eq!((color(".LMN"), color(".LMN_I"), color(".QNEG_P")), (Some(1), Some(2), Some(5)));
    }
}
