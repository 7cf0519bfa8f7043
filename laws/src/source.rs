//! Source files and errors located in them.

use proc_macro2::Span;
use std::fmt;

/// Rust source files.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    pub(crate) files: Vec<File>,
}

#[derive(Clone, Debug)]
pub(crate) struct File {
    pub path: String,
    pub text: String,
}

/// The sources of the built-in blocks.
const BLOCKS: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/blocks.rs"));

/// Rust number functions without an equivalent operation in the typed program.
const LIBRARY: &str = include_str!("library.rs");

/// The path of [`LIBRARY`] in messages.
pub(crate) const LIBRARY_PATH: &str = "laws/src/library.rs";

impl Sources {
    /// The sources of the built-in blocks.
    pub fn of_blocks() -> Sources {
        let mut sources = Sources::default();
        sources.add(LIBRARY_PATH, LIBRARY);
        for (path, text) in BLOCKS {
            sources.add(*path, *text);
        }
        sources
    }

    /// Adds a file, for example the source of your own block.
    pub fn add(&mut self, path: impl Into<String>, text: impl Into<String>) {
        self.files.push(File { path: path.into(), text: text.into() });
    }
}

impl File {
    /// The comments on separate lines directly before a line (counted from 1).
    pub(crate) fn comments_before(&self, line: usize) -> Vec<String> {
        let lines: Vec<&str> = self.text.lines().take(line.saturating_sub(1)).collect();
        let mut comments: Vec<String> = lines.iter().rev().map_while(|line| comment(line.trim())).collect();
        comments.reverse();
        comments
    }

    /// The comment after the code on a line (counted from 1), at or after a column.
    pub(crate) fn comment_behind(&self, line: usize, column: usize) -> Option<String> {
        let rest: String = self.text.lines().nth(line.checked_sub(1)?)?.chars().skip(column).collect();
        comment(rest.trim_start_matches([';', ',']).trim())
    }
}

/// The text of a comment line; `None` for code and documentation.
fn comment(line: &str) -> Option<String> {
    let text = line.strip_prefix("//")?;
    (!text.starts_with(['/', '!'])).then(|| text.trim().to_string())
}

/// Why a law cannot be read, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// The path of the file.
    pub file: String,
    /// The 1-based line number.
    pub line: usize,
    /// The 1-based column.
    pub column: usize,
    /// What is unsupported or wrong and, where possible, the remedy.
    pub message: String,
}

impl fmt::Display for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}:{}:{}: {}", self.file, self.line, self.column, self.message)
    }
}

impl std::error::Error for Error {}

impl Error {
    pub(crate) fn at(file: &File, span: Span, message: impl Into<String>) -> Error {
        let start = span.start();
        Error { file: file.path.clone(), line: start.line, column: start.column + 1, message: message.into() }
    }
}
