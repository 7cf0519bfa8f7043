//! The formats of a program's files, by what they hold.

use crate::report::Report;
use crate::syntax::Tree;

/// How a file of a program is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A source in SCL.
    Scl,
    /// A document of TIA Openness in XML.
    SimaticMl,
}

impl Format {
    /// The format of a text.
    pub fn of(text: &str) -> Format {
        if crate::simatic_ml::is_it(text) { Format::SimaticMl } else { Format::Scl }
    }

    /// The tree of a text in this format.
    pub fn parse(self, text: &str, file: u32, report: &mut Report) -> Tree {
        match self {
            Format::Scl => crate::parser::parse(text, file, report),
            Format::SimaticMl => crate::simatic_ml::parse(text, file, report),
        }
    }
}
