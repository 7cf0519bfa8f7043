//! Tag tables in workbooks (`.xlsx`), which are ZIP files.

use anyhow::{Error, Result, anyhow, ensure};
use host::package::archive::Archive;
use parameters::tags::workbook::{Rows, sheets};
use parameters::tags::{self, Tags};
use std::io::Cursor;

/// The maximum unpacked size of a part, in bytes: a hundred times that of a large plant.
const MOST_BYTES: u64 = 32 << 20;

/// The tags and constants of all sheets with the headings of a tag table.
///
/// # Errors
/// It is not a workbook, is too large when unpacked, or has a faulty row; the message does not name the file.
pub(super) fn read(bytes: Vec<u8>) -> Result<Tags> {
    let mut tags = Tags::default();
    let mut has_table = false;
    for (name, rows) in all(&bytes)? {
        has_table |= tags::of_sheet(&rows, &mut tags).map_err(|wrong| anyhow!("sheet {name:?}: {wrong}"))?;
        let count = tags.tags.len() + tags.constants.len();
        ensure!(count <= tags::MOST, "the workbook has more than {} tags", tags::MOST);
    }
    ensure!(
        has_table,
        "no sheet has the headings of a tag table: Name, Data Type, Logical Address, Comment; or Name, Data Type, Value"
    );
    Ok(tags)
}

/// Whether the file is a workbook with a tag table. Other workbooks in a program folder are ignored.
pub(super) fn is_table(bytes: &[u8]) -> bool {
    let names = ["PLC Tags", "Constants"];
    all(bytes)
        .is_ok_and(|sheets| sheets.iter().any(|(name, _)| names.iter().any(|known| name.eq_ignore_ascii_case(known))))
}

fn all(bytes: &[u8]) -> Result<Vec<(String, Rows)>> {
    let mut archive = Archive::open(Cursor::new(bytes))?;
    let mut part = |path: &str| {
        if archive.find(path).is_none() {
            return Ok(None);
        }
        let part = archive.read(path, MOST_BYTES).map_err(|error| format!("{error:#}"))?;
        String::from_utf8(part).map(Some).map_err(|_| format!("{path} is not UTF-8"))
    };
    sheets(&mut part).map_err(Error::msg)
}

#[cfg(test)]
mod tests;
