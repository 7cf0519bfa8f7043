//! Reads tag tables from the sheets of a workbook.

use super::{Constant, Tag, Tags, address_of, literal, one_line};
use crate::problem::quoted;

/// The indices of a sheet's columns.
struct Columns {
    name: usize,
    of: usize,
    address: Option<usize>,
    value: Option<usize>,
    comment: Option<usize>,
}

/// Adds the tags or constants of a sheet, given as 1-based row numbers and cells. Skips a sheet whose first row has
/// other headings, and returns `false`.
///
/// # Errors
/// A row lacks a name, type or value, or has an address that a tag cannot have: a sentence with its number.
pub fn of_sheet(rows: &[(u32, Vec<String>)], tags: &mut Tags) -> Result<bool, String> {
    let Some(((_, headings), rows)) = rows.split_first() else { return Ok(false) };
    let column = |heading: &str| headings.iter().position(|cell| cell.trim().eq_ignore_ascii_case(heading));
    let columns = (|| {
        let (address, value) = (column("Logical Address"), column("Value"));
        address.or(value)?;
        Some(Columns { name: column("Name")?, of: column("Data Type")?, address, value, comment: column("Comment") })
    })();
    let Some(columns) = columns else { return Ok(false) };
    for (number, cells) in rows {
        let cell = |column: Option<usize>| column.and_then(|column| cells.get(column)).map_or("", |cell| cell.trim());
        if cells.iter().all(|cell| cell.trim().is_empty()) {
            continue;
        }
        let (name, of) = (cell(Some(columns.name)), cell(Some(columns.of)).trim_matches('"'));
        let missing = [(name, "name"), (of, "data type")].into_iter().find(|(text, _)| text.is_empty());
        if let Some((_, what)) = missing {
            return Err(format!("row {number} has no {what}: {}", quoted(&cells.join(" "))));
        }
        if columns.address.is_some() {
            let comment = one_line(cell(columns.comment));
            let address =
                address_of(name, cell(columns.address)).map_err(|message| format!("row {number}: {message}"))?;
            tags.tags.push(Tag { name: name.into(), of: of.into(), address, comment });
        } else if cell(columns.value).is_empty() {
            return Err(format!("row {number}: the constant {} has no value", quoted(name)));
        } else {
            tags.constants.push(Constant { name: name.into(), value: literal(of, cell(columns.value)) });
        }
    }
    Ok(true)
}
