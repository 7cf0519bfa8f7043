//! Source files as read.

use crate::encoding::Encoding;
use crate::problem::TextPosition;
use std::fs::File;
use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;

/// A file: its name as given by the user, its bytes and its text.
#[derive(Clone, Debug)]
pub struct Source {
    /// Its name, for messages.
    pub file: String,
    /// Its bytes, including a byte order mark.
    pub bytes: Vec<u8>,
    /// Its text, without a byte order mark; meaningless if the format is binary.
    pub text: String,
    pub(crate) encoding: Encoding,
    /// The length of the byte order mark in bytes; 0 if there is none.
    pub(crate) start: usize,
    /// The location of the first character in each stretch of [`STRETCH`] bytes of the text.
    stretches: Vec<TextPosition>,
}

/// The size of a stretch in bytes, which bounds the cost of locating a character.
const STRETCH: usize = 1024;

impl Source {
    /// The maximum size of a file in bytes. The sources of a whole plant take a hundredth of this.
    pub const LARGEST: u64 = 256 << 20;

    /// Creates a source. Its encoding is UTF-8 or UTF-16 if a byte order mark indicates that, UTF-8 if the bytes are
    /// valid UTF-8, and otherwise Windows-1252, which STEP 7 writes.
    pub fn new(file: impl Into<String>, bytes: Vec<u8>) -> Source {
        let is_utf_8 = std::str::from_utf8(&bytes).is_ok();
        Source::in_encoding(file.into(), bytes, if is_utf_8 { Encoding::Utf8 } else { Encoding::Windows1252 })
    }

    /// Creates a source in this encoding, unless it starts with the byte order mark of a different one.
    pub(crate) fn in_encoding(file: String, bytes: Vec<u8>, encoding: Encoding) -> Source {
        let (encoding, start) = Encoding::of_mark(&bytes).unwrap_or((encoding, 0));
        let text = encoding.decode(&bytes[start..]);
        let mut stretches = vec![TextPosition { line: 1, column: 1, span: 0..0 }];
        let mut place = stretches[0].clone();
        while place.span.start + STRETCH < text.len() {
            place = advanced(&text, &place, text.floor_char_boundary(place.span.start + STRETCH));
            stretches.push(place.clone());
        }
        Source { file, bytes, text, encoding, start, stretches }
    }

    /// Creates a source in the named encoding, unless it starts with the byte order mark of a different one. The names
    /// are as in browsers: `windows-1251`, `shift_jis`. Without the feature `encodings`, only UTF-8, UTF-16 and
    /// Windows-1252 are available.
    ///
    /// # Errors
    /// No encoding has this name.
    pub fn encoded(file: impl Into<String>, bytes: Vec<u8>, encoding: &str) -> Result<Source, String> {
        let Some(chosen) = Encoding::named(encoding) else {
            return Err(format!(
                "{encoding:?} is not an encoding; use utf-8, utf-16le, windows-1252 or windows-1251, for example"
            ));
        };
        Ok(Source::in_encoding(file.into(), bytes, chosen))
    }

    /// The file name that denotes standard input.
    pub const STANDARD_INPUT: &str = "-";

    /// The name, for messages, and the bytes of a file, or of standard input if it is named `-`.
    ///
    /// # Errors
    /// It cannot be read, or has more than `largest` bytes: a sentence with its name.
    pub fn load(path: &Path, largest: u64) -> Result<(String, Vec<u8>), String> {
        let is_file = path != Path::new(Source::STANDARD_INPUT);
        let name = if is_file { path.display().to_string() } else { "stdin".to_string() };
        let mut bytes = Vec::new();
        let file: io::Result<Box<dyn Read>> =
            if is_file { File::open(path).map(|file| Box::new(file) as _) } else { Ok(Box::new(io::stdin())) };
        // Reading one more byte reveals that the file is too large, even if it is not a regular file and has no size.
        file.and_then(|file| file.take(largest + 1).read_to_end(&mut bytes))
            .map_err(|error| format!("{name} cannot be read: {error}"))?;
        if bytes.len() as u64 > largest {
            return Err(format!("{name} is larger than {} MB; split it", largest >> 20));
        }
        Ok((name, bytes))
    }

    /// Reads a file or standard input; the user may name the encoding.
    ///
    /// # Errors
    /// It cannot be read, is larger than [`Source::LARGEST`], or the encoding does not exist: a sentence with the
    /// file's name.
    pub fn read(path: &Path, encoding: Option<&str>) -> Result<Source, String> {
        let (name, bytes) = Source::load(path, Source::LARGEST)?;
        match encoding {
            Some(encoding) => Source::encoded(name, bytes, encoding),
            None => Ok(Source::new(name, bytes)),
        }
    }

    /// The line and column at which a range of the text starts. The cost does not depend on the size of the file or the
    /// length of a line.
    pub fn place(&self, span: Range<usize>) -> TextPosition {
        let start = self.text.floor_char_boundary(span.start);
        let before = self.stretches.partition_point(|place| place.span.start <= start);
        let stretch = &self.stretches[before.saturating_sub(1)];
        TextPosition { span, ..advanced(&self.text, stretch, start) }
    }
}

/// The location of byte `to`, found by counting lines and characters from the earlier location `from`.
fn advanced(text: &str, from: &TextPosition, to: usize) -> TextPosition {
    let between = &text[from.span.start..to];
    let lines = between.bytes().filter(|byte| *byte == b'\n').count();
    let column = match between.rfind('\n') {
        Some(end) => between[end + 1..].chars().count() + 1,
        None => from.column + between.chars().count(),
    };
    TextPosition { line: from.line + lines, column, span: to..to }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TEXT: &str = "Füllstand\n";

    #[test]
    fn a_byte_order_mark_says_the_encoding() {
        let utf_8 = ["\u{feff}", TEXT].concat().into_bytes();
        let little = "\u{feff}Füllstand\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big = "\u{feff}Füllstand\n".encode_utf16().flat_map(u16::to_be_bytes).collect();
        for bytes in [utf_8, little, big] {
            assert_eq!(Source::new("a.awl", bytes).text, TEXT);
        }
    }

    #[test]
    fn without_a_mark_a_text_is_utf_8_if_it_can_be_and_else_windows_1252() {
        assert_eq!(Source::new("a.awl", TEXT.into()).text, TEXT);
        assert_eq!(Source::new("a.awl", b"F\xFCllstand\n".to_vec()).text, TEXT);
        assert_eq!(Source::new("a.awl", b"\x80".to_vec()).text, "€");
    }

    #[test]
    #[cfg(feature = "encodings")]
    fn another_encoding_can_be_named() {
        let cyrillic = Source::encoded("a.awl", b"\xcf\xc8\xc4".to_vec(), "windows-1251").unwrap();
        assert_eq!(cyrillic.text, "ПИД");
        let error = Source::encoded("a.awl", Vec::new(), "klingon").unwrap_err();
        assert!(error.contains("\"klingon\" is not an encoding"), "{error}");
    }

    #[test]
    fn a_column_counts_characters() {
        let source = Source::new("a.awl", "ä := 1;\n  öß := 2;".into());
        let at = source.text.find(":= 2").unwrap();
        let place = source.place(at..at + 2);
        assert_eq!((place.line, place.column, place.span), (2, 6, at..at + 2));
        assert_eq!(source.place(0..0).column, 1);
        assert_eq!(source.place(source.text.len()..source.text.len()).column, 11);
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let error = Source::read(Path::new("no/such.awl"), None).unwrap_err();
        assert!(error.starts_with("no/such.awl cannot be read: "), "{error}");
    }

    proptest! {
        #[test]
        fn places_are_those_that_counting_from_the_start_gives(lines in prop::collection::vec("[aä€𝄞]{0,700}", 1..20), at: prop::sample::Index) {
            let source = Source::new("a.awl", lines.join("\n").into_bytes());
            let start = source.text.floor_char_boundary(at.index(source.text.len() + 1));
            let before = &source.text[..start];
            let line = before.matches('\n').count() + 1;
            let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
            let place = source.place(start..start);
            prop_assert_eq!((place.line, place.column), (line, column));
        }
    }
}
