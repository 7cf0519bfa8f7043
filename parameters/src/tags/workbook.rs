//! Reads workbooks (`.xlsx`): the sheets, as rows of strings.

use crate::xml::{self, Document, Element};
use std::collections::HashMap;

/// The number of columns that are read; a tag table has ten.
const MOST_COLUMNS: usize = 50;

/// The maximum number of non-empty rows in a sheet.
const MOST_ROWS: usize = super::MOST + 1;

/// The non-empty rows of a sheet, with their 1-based row numbers.
pub type Rows = Vec<(u32, Vec<String>)>;

/// The sheets of a workbook, with their names. `part` returns the text of a part by its path, or `None` if the package
/// lacks it.
///
/// # Errors
/// A part is missing or damaged: a sentence with its path.
pub fn sheets(part: &mut dyn FnMut(&str) -> Result<Option<String>, String>) -> Result<Vec<(String, Rows)>, String> {
    let texts: Vec<String> = match part("xl/sharedStrings.xml")? {
        Some(text) => tree("xl/sharedStrings.xml", &text)?.root().children("si").map(text_of).collect(),
        None => Vec::new(),
    };
    let relations = part("xl/_rels/workbook.xml.rels")?.ok_or("xl/_rels/workbook.xml.rels is missing")?;
    let relations = tree("xl/_rels/workbook.xml.rels", &relations)?;
    let targets: HashMap<&str, &str> = relations
        .root()
        .children("Relationship")
        .filter_map(|of| Some((of.attribute("Id")?, of.attribute("Target")?)))
        .collect();
    let workbook = part("xl/workbook.xml")?.ok_or("xl/workbook.xml is missing")?;
    let workbook = tree("xl/workbook.xml", &workbook)?;
    let mut sheets = Vec::new();
    for sheet in workbook.root().child("sheets").into_iter().flat_map(|sheets| sheets.children("sheet")) {
        let (Some(name), Some(id)) = (sheet.attribute("name"), sheet.attribute("id")) else { continue };
        let Some(target) = targets.get(id) else { continue };
        // The target is relative to the root or to the workbook.
        let path = target.strip_prefix('/').map_or_else(|| format!("xl/{target}"), str::to_string);
        let Some(text) = part(&path)? else { return Err(format!("{path} is missing")) };
        let sheet = tree(&path, &text)?;
        sheets.push((name.to_string(), rows(sheet.root(), &texts).map_err(|wrong| format!("{path}: {wrong}"))?));
    }
    Ok(sheets)
}

fn tree<'t>(path: &str, text: &'t str) -> Result<Document<'t>, String> {
    xml::tree(text).map_err(|(_, wrong)| format!("{path}: {wrong}"))
}

fn rows(sheet: Element, texts: &[String]) -> Result<Rows, String> {
    let mut rows: Rows = Vec::new();
    let all = sheet.child("sheetData").into_iter().flat_map(|data| data.children("row"));
    for row in all {
        let after = rows.last().map_or(1, |(number, _)| number.saturating_add(1));
        let number = row.attribute("r").and_then(|number| number.parse().ok()).unwrap_or(after);
        let mut cells: Vec<String> = Vec::new();
        for cell in row.children("c") {
            let column = cell.attribute("r").map_or(Some(cells.len()), column);
            let Some(column) = column.filter(|column| *column < MOST_COLUMNS) else { continue };
            cells.resize(cells.len().max(column + 1), String::new());
            cells[column] = value(cell, texts)?;
        }
        if rows.len() == MOST_ROWS {
            return Err(format!("it has more than {MOST_ROWS} rows"));
        }
        rows.push((number, cells));
    }
    Ok(rows)
}

/// The 0-based index of a column: 2 for `C5`.
fn column(name: &str) -> Option<usize> {
    let letters = name.bytes().take_while(u8::is_ascii_alphabetic).take(4);
    let number = letters.fold(0, |number, letter| number * 26 + usize::from(letter.to_ascii_uppercase() - b'A') + 1);
    number.checked_sub(1)
}

/// The text of a cell: shared, inline, a Boolean, or a number as written.
fn value(cell: Element, texts: &[String]) -> Result<String, String> {
    let value = cell.child("v").map_or("", |value| value.text().0);
    Ok(match cell.attribute("t") {
        Some("s") => {
            let text = value.parse::<usize>().ok().and_then(|number| texts.get(number));
            text.ok_or_else(|| format!("no shared string {}", crate::problem::quoted(value)))?.clone()
        }
        Some("inlineStr") => cell.child("is").map_or_else(String::new, text_of),
        Some("b") => if value == "1" { "TRUE" } else { "FALSE" }.to_string(),
        _ => value.to_string(),
    })
}

/// The text of a string item: its own text, or the text of its runs.
fn text_of(item: Element) -> String {
    let runs = item.children("r").filter_map(|run| run.child("t"));
    item.children("t").chain(runs).map(|text| text.text().0).collect()
}
