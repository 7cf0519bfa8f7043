//! What is wrong with a file, and where.

use crate::loops::Loop;
use std::fmt;
use std::ops::Range;

/// Where in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
    /// The bytes of the file's text ([`crate::Source::text`]), to be underlined.
    pub span: Range<usize>,
}

/// One thing that is wrong, or that the user should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Where; `None` if it concerns the file as a whole, or one that is no text.
    pub place: Option<Place>,
    /// What was found and what is expected: one sentence, without a full stop.
    pub message: String,
    /// What to do, where the message does not say it.
    pub help: Option<String>,
}

/// Everything that is wrong with a file, or that is to be said of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problems {
    /// The file's name, as the user gave it.
    pub file: String,
    /// The file's text, for drawing the places; empty if it has none.
    pub text: String,
    /// The problems, in the order of the file.
    pub problems: Vec<Problem>,
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The loops, in the order of the file.
    pub loops: Vec<Loop>,
    /// What the user should know of the file, though it can be read: other blocks that were skipped, what a dump does not
    /// prove.
    pub remarks: Problems,
}

impl fmt::Display for Problems {
    /// A line for each problem, `FILE:LINE:COLUMN: message`.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        for (number, problem) in self.problems.iter().enumerate() {
            if number > 0 {
                writeln!(formatter)?;
            }
            write!(formatter, "{}:", self.file)?;
            if let Some(Place { line, column, .. }) = problem.place {
                write!(formatter, "{line}:{column}:")?;
            }
            write!(formatter, " {}", problem.message)?;
            if let Some(help) = &problem.help {
                write!(formatter, "; {help}")?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// The text in backquotes for a message: shortened, without characters that would disturb a terminal.
pub(crate) fn quoted(text: &str) -> String {
    const MOST_CHARACTERS: usize = 40;
    let mut shown: String = text.chars().take(MOST_CHARACTERS).flat_map(escaped).collect();
    if text.chars().nth(MOST_CHARACTERS).is_some() {
        shown.push_str("...");
    }
    format!("`{shown}`")
}

/// A control character as an escape sequence, any other as it is.
fn escaped(character: char) -> Vec<char> {
    if character.is_control() { character.escape_default().collect() } else { vec![character] }
}
