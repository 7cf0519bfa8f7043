//! A file as it was read.

use crate::problem::Place;
use std::ops::Range;

/// A file: its name as the user gave it, its bytes and its text.
#[derive(Clone, Debug)]
pub struct Source {
    /// Its name, for messages.
    pub file: String,
    /// Its content.
    pub bytes: Vec<u8>,
    /// Its text; empty if it is a format of bytes.
    pub text: String,
}

impl Source {
    /// A file whose text is UTF-8. What is not is replaced by U+FFFD.
    pub fn new(file: impl Into<String>, bytes: Vec<u8>) -> Source {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        Source { file: file.into(), bytes, text }
    }

    /// Line and column of a range of the text.
    pub fn place(&self, span: Range<usize>) -> Place {
        let before = &self.text[..self.text.floor_char_boundary(span.start)];
        let line = before.matches('\n').count() + 1;
        let column = before[before.rfind('\n').map_or(0, |end| end + 1)..].chars().count() + 1;
        Place { line, column, span }
    }
}
