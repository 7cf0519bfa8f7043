//! Reads tag tables in STEP 7's symbol table format: quoted strings separated by commas.
//!
//! TIA Portal writes name, address, type, three flags for panels, comment, and the value of a constant, whose address
//! is CONSTANT. STEP 7 writes name, address, type and comment.

use super::{Constant, Tag, Tags, Wrong, address_of, literal, one_line};
use crate::problem::quoted;

/// Reads the tags and constants of a table.
pub(super) fn read(text: &str) -> Result<Tags, Vec<Wrong>> {
    let mut tags = Tags::default();
    let mut wrong = Vec::new();
    let mut start = 0;
    while start < text.len() {
        let (cells, end) = row(text, start);
        let span = start..start + text[start..end].trim_end().len();
        start = end;
        match cells {
            Ok(cells) if cells.iter().all(|cell| cell.is_empty()) => {}
            Ok(cells) => {
                if let Err(message) = add(&mut tags, &cells) {
                    wrong.push((span, message));
                }
            }
            Err(message) => {
                wrong.push((span, message));
                break;
            }
        }
    }
    if wrong.is_empty() { Ok(tags) } else { Err(wrong) }
}

/// A row: its cells, unquoted and trimmed, and the offset of the next row.
fn row(text: &str, start: usize) -> (Result<Vec<String>, String>, usize) {
    let mut cells = vec![String::new()];
    let mut is_quoted = false;
    let mut characters = text[start..].char_indices().peekable();
    while let Some((at, character)) = characters.next() {
        let cell = cells.len() - 1;
        match character {
            // A doubled quotation mark represents a single one.
            '"' if is_quoted && characters.peek().is_some_and(|(_, next)| *next == '"') => {
                cells[cell].push('"');
                characters.next();
            }
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            '\n' if !is_quoted => return (Ok(trimmed(cells)), start + at + 1),
            character => cells[cell].push(character),
        }
    }
    let cells = if is_quoted { Err("the quotation mark is not closed".to_string()) } else { Ok(trimmed(cells)) };
    (cells, text.len())
}

fn trimmed(cells: Vec<String>) -> Vec<String> {
    cells.into_iter().map(|cell| cell.trim().to_string()).collect()
}

fn add(tags: &mut Tags, cells: &[String]) -> Result<(), String> {
    let cell = |number: usize| cells.get(number).map(String::as_str).unwrap_or_default();
    let (name, place, of) = (cell(0), cell(1), cell(2));
    if name.is_empty() || of.is_empty() || cells.len() < 3 {
        return Err(format!(
            "expected a name, an address and a type in quotation marks, found {}",
            quoted(&cells.join(","))
        ));
    }
    // TIA Portal writes nine cells, STEP 7 four.
    let (comment, value) = if cells.len() > 4 { (cell(6), cell(7)) } else { (cell(3), "") };
    if place.eq_ignore_ascii_case("CONSTANT") {
        if value.is_empty() {
            return Err(format!("the constant {} has no value", quoted(name)));
        }
        tags.constants.push(Constant { name: name.into(), value: literal(of, value) });
    } else if !is_block(place) {
        let of = of.trim_matches('"').to_string();
        tags.tags.push(Tag { name: name.into(), of, address: address_of(name, place)?, comment: one_line(comment) });
    }
    Ok(())
}

/// Whether the address of a STEP 7 symbol is a block, such as `FB 41`. The block's source has the same name, so the row
/// is not needed.
fn is_block(place: &str) -> bool {
    let kind: String = place.chars().take_while(|c| c.is_ascii_alphabetic()).collect();
    matches!(kind.to_ascii_uppercase().as_str(), "FB" | "FC" | "DB" | "OB" | "SFB" | "SFC" | "UDT" | "VAT")
}
