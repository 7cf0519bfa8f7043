//! Reads SIMATIC SD: blocks, types and data blocks as exported by TIA Portal V20 and later. A `.s7dcl` file contains
//! the declarations and networks; a `.s7res` file of the same name contains the texts. Declarations and expressions
//! are SCL apart from a few forms, so the SCL parser reads them.
//!
//! Format: Siemens, SIMATIC Source Documents, entry 109994073 (09/2025).

mod declarations;
mod graph;
mod networks;
mod rungs;
#[cfg(test)]
mod tests;
mod texts;

pub(crate) use texts::Texts;

use crate::front::parser;
use crate::front::syntax::Tree;
use crate::report::Report;

pub(crate) fn parse(text: &str, file: u32, texts: &Texts, report: &mut Report) -> Tree {
    let mut tree = parser::parse_source(text, file, Some(texts), report);
    tree.is_tia = true;
    tree
}
