//! A program's texts, which a host reads and writes in addition to the rows of its table. Their value references follow
//! those of the rows.

use crate::cyclic::Cyclic;
use crate::host_type::Version;
use crate::instance::{Instance, no_variable, read_only};
use crate::messages;
use crate::refusal::Refusal;
use crate::state::State;
use blocks::{Table, TableText, Text};
use std::ffi::CStr;

/// The standard's name for the type of texts.
pub const TYPE: &str = "String";

/// The text with this value reference, and its index in the table.
pub fn text<S: TableText>(table: &Table<S>, reference: u32) -> Option<(usize, &Text<S>)> {
    let number = (reference as usize).checked_sub(table.rows.len())?;
    Some((number, table.texts.get(number)?))
}

impl<B: Cyclic> Instance<B> {
    /// Reads texts. For Initialization Mode, see [`Instance::get`].
    ///
    /// # Errors
    /// A reference is unknown or does not refer to a text.
    pub fn get_texts<V: Version>(&self, references: &[u32]) -> Result<Vec<String>, Refusal> {
        let table = self.session.block.table();
        let numbers: Vec<(usize, &Text<B::Text>)> =
            references.iter().map(|reference| found::<V, _>(table, *reference, "Get")).collect::<Result<_, _>>()?;
        let is_computed = |text: &Text<B::Text>| !text.role.is_settable();
        let is_restart_read =
            self.state == State::InitializationMode && numbers.iter().any(|(_, text)| is_computed(text));
        let restarted = if is_restart_read { self.session.restarted() } else { None };
        let read = |(number, text): &(usize, &Text<B::Text>)| {
            let block = restarted.as_ref().filter(|_| is_computed(text)).unwrap_or(&self.session.block);
            block.text(*number).unwrap_or_default()
        };
        Ok(numbers.iter().map(read).collect())
    }

    /// Writes texts passed as UTF-8; `None` means NULL. `values` is as long as `references`.
    ///
    /// # Errors
    /// A reference is unknown, is not a text, or cannot be set now; a value is NULL, is not UTF-8, is longer than the
    /// variable, or has a character outside its type. Nothing is written in these cases.
    pub fn set_texts<V: Version>(&mut self, references: &[u32], values: &[Option<&CStr>]) -> Result<(), Refusal> {
        let mut checked = Vec::with_capacity(references.len());
        for (reference, value) in references.iter().zip(values) {
            let (number, text) = found::<V, _>(self.session.block.table(), *reference, "Set")?;
            if !self.may_set(text.role) {
                return Err(read_only(&text.name, text.role, V::PREFIX));
            }
            let given = value.ok_or_else(|| messages::no_text(&text.name))?;
            let given = given.to_str().map_err(|wrong| messages::not_utf8(&text.name, wrong.valid_up_to()))?;
            let units = text.ty.units(given);
            let refused = |why: String| messages::out_of_range(&text.name, &format!("{given:?}"), &why);
            checked.push((number, units.map_err(refused)?));
        }
        for (number, units) in checked {
            self.session.block.set_text(number, &units);
        }
        Ok(())
    }
}

fn found<'a, V: Version, S: TableText>(
    table: &'a Table<S>,
    reference: u32,
    access: &str,
) -> Result<(usize, &'a Text<S>), Refusal> {
    text(table, reference).ok_or_else(|| no_variable::<V, _>(table, reference, access))
}
