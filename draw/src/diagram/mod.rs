//! Block diagrams: from a small text in a block's documentation to SVG.
//!
//! A block without such a text is drawn as a box with its [`pins`].
//!
//! # The text
//!
//! It is written between ` ```diagram ` and ` ``` ` in the block's documentation:
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
//! Positions are `x,y` in units of ten pixels, x to the right, y down; fractions are allowed. A line is one of these:
//!
//! | line | meaning |
//! |---|---|
//! | `input NAME 0,3` | an input; the position is the left end of its terminal |
//! | `output NAME 40,3` | an output; the position is the left end of its terminal |
//! | `box NAME 20,3 SYMBOL with A B` | a function with its symbol and the variables that act on it; the position is the middle of the symbol. Instead of a symbol: `"a text" "in lines"`, or `in A B out C` for an inner block, to whose pins wires connect as NAME.A |
//! | `sum NAME 12,3 left + bottom -` | a summing point with the sign at each side |
//! | `switch NAME 30,4 TRUE upper` | a switch controlled by the variable NAME; TRUE selects the upper or the `lower` contact. `constant FALSE 0.0`: this contact has a number and no wire; `below`: NAME is below the switch; `by B`: B controls the switch. A second switch of a variable must be in the same column and moves with the first |
//! | `text 5,5 "e"` | a text that starts at the position; with `middle` or `end`, its middle or end is there |
//! | `value NAME 25,3` | an inner variable: its name above a wire, space for its value below the wire |
//! | `frame 10,1 30,9 "every call"` | a dashed border, with width and height |
//! | `A > x12 > B.top > C` | wires from the right of A to the top of B, and from the right of B to the left of C. `x12` and `y7` are corners, which the wire reaches horizontally or vertically. Ends are `NAME`, `NAME.top`, `NAME.left+1` (one unit below the middle), `NAME.TRUE` and `NAME.FALSE` (contacts of a switch), `NAME.PIN` (of an inner block) |
//! | `15,3 > y6 > ER` | a wire that branches off another one at this point |
//! | `PV: A > B` | wires that carry the variable PV, including all branches |
//! | `dashed A > B` | wires that act only in some states, such as the tracking of an integrator in manual mode |
//! | `icon SYMBOL`, `icon "PI"` | the block's icon for small spaces |
//! | `// ...` | a comment |
//!
//! Symbols: [`symbol::SYMBOLS`]. Each input, parameter and output of the block must be in the diagram exactly once;
//! elements must not overlap, and wires must not pass through elements. An error names the line and the remedy.
//!
//! # The drawing, for programs
//!
//! Each of these ids begins with the prefix passed to [`svg_with`], so that a page can contain several diagrams.
//! Elements that belong to a variable have its name as `data-variable`.
//!
//! | id | element |
//! |---|---|
//! | `wire-NAME` | all wires of a signal. NAME is the variable that they carry, or `from-BOX` if they carry none |
//! | `switch-NAME` | a switch. Its blades have `data-value` FALSE and TRUE; the inactive one is hidden (`visibility`). Any other switch of the variable has its own name in the id and the variable in `data-variable` |
//! | `terminal-NAME` | a terminal, or a variable in a box |
//! | `value-NAME` | a text element for the value. Settings show their start value in it, signals leave it empty; a variable that controls a switch has none, because the switch shows the value |
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

/// The markers of a diagram description in a block's documentation.
const FENCE: &str = "```";
const LANGUAGE: &str = "diagram";

/// The block's diagram as SVG, or its pins if its documentation has no diagram.
///
/// # Errors
/// The description of the diagram is faulty or does not match the table; the error names the line, its text and the
/// remedy.
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

/// Like [`svg`], for a page on which each variable has an anchor: variables in the diagram link to their anchors.
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

/// The range of the first diagram description in a block's documentation, including its fences.
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

/// The first diagram description in a block's documentation, without its fences.
fn text(docs: &str) -> Option<String> {
    let lines = docs[find(docs)?].lines().skip(1);
    Some(lines.take_while(|line| line.trim() != FENCE).map(|line| format!("{}\n", line.trim())).collect())
}

/// The block's own variables with these roles.
pub fn terminals_of<'a>(table: &'a Table, roles: &[Role]) -> Vec<&'a Row> {
    let rows = table.rows.iter();
    rows.filter(|row| roles.contains(&row.role) && !row.name.contains('.')).collect()
}
