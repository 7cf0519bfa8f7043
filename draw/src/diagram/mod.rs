//! Block diagrams: from a small text in a block's documentation to SVG.
//!
//! A block without such a text is drawn as a box with its [`pins`].
//!
//! # The text
//!
//! It stands between ` ```diagram ` and ` ``` ` in the documentation of the block:
//!
//! ```text
//! icon lag
//! input SP 0,3
//! input PV 0,8
//! output Y 40,3
//! sum ER 12,3 left + bottom -
//! box GAIN 20,3 multiply with GAIN
//! switch ON 30,4 TRUE upper constant FALSE 0.0
//! SP > ER > GAIN > x26 > ON.TRUE
//! PV > x12 > ER.bottom
//! ON > Y
//! ```
//!
//! Places are `x,y` in units of ten pixels, x to the right, y down; halves are allowed. A line is one of these:
//!
//! | line | meaning |
//! |---|---|
//! | `input NAME 0,3` | a variable that goes in; the place is the left end of its name |
//! | `output NAME 40,3` | a variable that comes out; the same |
//! | `box NAME 20,3 SYMBOL with A B` | a function with its symbol and the variables that act on it; the place is the middle of the symbol. Instead of a symbol: `"a text" "in lines"`, or `in A B out C` for a block inside, whose pins wires meet as NAME.A |
//! | `sum NAME 12,3 left + bottom -` | a summing point with the sign at each side |
//! | `switch NAME 30,4 TRUE upper` | a switch that the variable NAME throws; TRUE takes the upper or the `lower` contact. `constant FALSE 0.0`: that contact has a number and no wire; `below`: NAME stands below; `by B`: it is thrown by B. A second switch of a variable stands in the same column and is thrown with the first |
//! | `text 5,5 "e"` | words; `middle` or `end` selects which part of them is at the place |
//! | `value NAME 25,3` | the name of a variable inside above a wire, room for its value below it |
//! | `frame 10,1 30,9 "every call"` | a dashed border, with width and height |
//! | `A > x12 > B.top > C` | wires from the right of A to the top of B, from its right to the left of C. `x12` and `y7` are corners: the wire goes there level or upright. Ends are `NAME`, `NAME.top`, `NAME.left+1` (one unit below the middle), `NAME.TRUE` and `NAME.FALSE` (contacts of a switch), `NAME.PIN` (of a block inside) |
//! | `15,3 > y6 > ER` | a wire that branches off another one at this point |
//! | `PV: A > B` | wires that carry the variable PV, with all that branches off them |
//! | `dashed A > B` | wires that act in some states only, such as the tracking of an integrator in manual mode |
//! | `icon SYMBOL`, `icon "PI"` | the block's icon where there is little space |
//! | `// ...` | a remark |
//!
//! Symbols: [`symbol::SYMBOLS`]. Each input, parameter and output of the block has to be in the diagram once; elements must not overlap, and wires
//! must not lead through elements. An error names the line and what to do.
//!
//! # The drawing, for programs
//!
//! Each of these ids begins with the prefix that [`svg_with`] is given, so that a page may hold several diagrams. What belongs
//! to a variable has its name as `data-variable`.
//!
//! | id | what |
//! |---|---|
//! | `wire-NAME` | all wires of a signal. NAME is the variable that they carry, or `from-BOX` where they carry none |
//! | `switch-NAME` | a switch. Its blades have `data-value` FALSE and TRUE; the one that is not taken is hidden (`visibility`). A further switch of the variable has its own name in the id, the variable in `data-variable` |
//! | `terminal-NAME` | a terminal, or a variable in a box |
//! | `value-NAME` | a text element for the value. Settings show their start value in it, signals leave it empty; a variable that throws a switch has none: its switch shows it |
//! | `box-NAME` | a function |

mod check;
mod draw;
pub mod icon;
mod model;
pub mod net;
mod parse;
pub mod pins;
pub mod symbol;
#[cfg(test)]
mod tests;
mod wire;

use anyhow::{Context, Result};
use blocks::Role;
use check::Checked;
use modeldescription::{Row, Table};
use std::ops::Range;

/// The markers of a diagram's description in a block's documentation.
const FENCE: &str = "```";
const LANGUAGE: &str = "diagram";

/// The block's diagram as SVG, or its pins if its documentation has no diagram.
///
/// # Errors
/// The description of the diagram is faulty or does not match the table; the error names line, text and remedy.
pub fn svg(table: &Table) -> Result<String> {
    drawn(table, "", false)
}

/// Like [`svg`], with ids that start with `prefix`.
///
/// # Errors
/// As for [`svg`].
pub fn svg_with(table: &Table, prefix: &str) -> Result<String> {
    drawn(table, prefix, false)
}

/// Like [`svg`], for a page on which each variable has an anchor: variables in the diagram link to theirs.
///
/// # Errors
/// As for [`svg`].
pub fn linked(table: &Table) -> Result<String> {
    drawn(table, "", true)
}

fn drawn(table: &Table, prefix: &str, is_linked: bool) -> Result<String> {
    match read(table)? {
        Some(checked) => draw::svg(&checked, prefix, is_linked),
        None => pins::svg(table),
    }
}

/// The diagram in the block's documentation, if it has one.
fn read(table: &Table) -> Result<Option<Checked<'_>>> {
    let Some(text) = text(&table.docs) else { return Ok(None) };
    let diagram = parse::parse(&text, |name| check::start(table, name)).with_context(|| table.name.clone())?;
    Checked::check(diagram, &text, table).with_context(|| table.name.clone()).map(Some)
}

/// The range of the first description of a diagram in a documentation, including its fences.
pub fn find(docs: &str) -> Option<Range<usize>> {
    let mut place = 0;
    let mut begin = None;
    for line in docs.split_inclusive('\n') {
        let text = line.trim();
        match begin {
            None if text.strip_prefix(FENCE).is_some_and(|language| language.trim() == LANGUAGE) => begin = Some(place),
            Some(begin) if text == FENCE => return Some(begin..place + line.len()),
            _ => {}
        }
        place += line.len();
    }
    begin.map(|begin| begin..docs.len())
}

/// The first description of a diagram in a documentation, without its fences.
fn text(docs: &str) -> Option<String> {
    let lines = docs[find(docs)?].lines().skip(1);
    Some(lines.take_while(|line| line.trim() != FENCE).map(|line| format!("{}\n", line.trim())).collect())
}

/// The block's own variables with these roles.
pub fn terminals_of<'a>(table: &'a Table, roles: &[Role]) -> Vec<&'a Row> {
    let rows = table.rows.iter();
    rows.filter(|row| roles.contains(&row.role) && !row.name.contains('.')).collect()
}
