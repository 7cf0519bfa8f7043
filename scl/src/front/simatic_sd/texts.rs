//! The texts of documents: titles and comments by ID and language, as stored in `.s7res` files.

use crate::front::lexer::Span;
use crate::report::Report;
use saphyr_parser::{Event, Marker, Parser};
use std::borrow::Cow;

/// Advice for a malformed file.
const EXPORT: &str =
    "export the document from TIA Portal again, or leave the file out: it contains only titles and comments";

/// The texts of a document.
#[derive(Debug, Default)]
pub(crate) struct Texts<'a> {
    /// All texts in all languages; those with the same ID are consecutive, in file order.
    entries: Vec<Entry<'a>>,
}

/// A text in one language.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Entry<'a> {
    /// Its ID: `MLC_4kK`.
    pub id: Cow<'a, str>,
    /// Its language: `en-US`.
    pub language: Cow<'a, str>,
    pub text: Cow<'a, str>,
}

impl<'a> Texts<'a> {
    /// Reads the texts of a file and reports any error.
    pub(crate) fn read(text: &'a str, file: u32, report: &mut Report) -> Texts<'a> {
        // A document without texts comes with an empty file, or with one that contains `<root />`.
        if text.trim().is_empty() || text.trim_start().starts_with("<root") {
            return Texts::default();
        }
        let mut reader = Reader { events: Parser::new_from_str(text), texts: Texts::default() };
        if let Err((marker, message)) = reader.file() {
            let mut places = text.char_indices().map(|(at, character)| (at, at + character.len_utf8()));
            let (start, end) = places.nth(marker.index()).unwrap_or((text.len(), text.len()));
            report.error(Span { file, start: start as u32, end: end as u32 }, message, Some(EXPORT));
        }
        let mut texts = reader.texts;
        texts.entries.sort_by(|one, other| one.id.cmp(&other.id));
        texts
    }

    /// The texts with this ID in all languages.
    pub(crate) fn all(&self, id: &str) -> &[Entry<'a>] {
        let first = self.entries.partition_point(|entry| *entry.id < *id);
        let count = self.entries[first..].iter().take_while(|entry| entry.id == id).count();
        &self.entries[first..first + count]
    }

    /// The text to show for an ID: English if available, else the first that is not empty. A string that is not an ID
    /// is returned as it is.
    pub(crate) fn shown<'t>(&'t self, id: &'t str) -> &'t str {
        match self.all(id) {
            [] if id.starts_with("MLC_") => "",
            [] => id,
            all => {
                let mut texts = all.iter().filter(|entry| !entry.text.trim().is_empty());
                let english = texts.clone().find(|entry| entry.language.to_ascii_lowercase().starts_with("en"));
                english.or_else(|| texts.next()).map_or("", |entry| entry.text.trim())
            }
        }
    }
}

/// Where reading stopped, and why.
type Stopped = (Marker, String);

struct Reader<'a> {
    events: Parser<'a, saphyr_parser::StrInput<'a>>,
    texts: Texts<'a>,
}

impl<'a> Reader<'a> {
    fn next(&mut self) -> Result<(Event<'a>, Marker), Stopped> {
        match self.events.next_event() {
            Some(Ok((event, span))) => Ok((event, span.start)),
            Some(Err(error)) => Err((*error.marker(), format!("this is not YAML: {}", error.info()))),
            None => Ok((Event::StreamEnd, Marker::default())),
        }
    }

    /// Reads `MultiLingualTexts:` and its list. Aliases and deeper nesting are rejected where they occur.
    fn file(&mut self) -> Result<(), Stopped> {
        self.expect(|event| matches!(event, Event::StreamStart), "a file")?;
        match self.next()? {
            (Event::StreamEnd, _) => return Ok(()),
            (Event::DocumentStart(_), _) => {}
            other => return unexpected(&other, "MultiLingualTexts"),
        }
        self.expect(|event| matches!(event, Event::MappingStart(..)), "MultiLingualTexts")?;
        self.expect(
            |event| matches!(event, Event::Scalar(key, ..) if key == "MultiLingualTexts"),
            "MultiLingualTexts",
        )?;
        match self.next()? {
            (Event::Scalar(empty, ..), _) if matches!(&*empty, "" | "~" | "null") => {}
            (Event::SequenceStart(..), _) => while self.text()? {},
            other => return unexpected(&other, "a list"),
        }
        self.expect(|event| matches!(event, Event::MappingEnd), "the end of the file")?;
        self.expect(|event| matches!(event, Event::DocumentEnd), "the end of the file")?;
        self.expect(|event| matches!(event, Event::StreamEnd), "the end of the file")
    }

    fn expect(&mut self, is_it: impl Fn(&Event) -> bool, what: &str) -> Result<(), Stopped> {
        let next = self.next()?;
        if is_it(&next.0) { Ok(()) } else { unexpected(&next, what) }
    }

    /// Reads an ID and its text in each language; returns `false` at the end of the list.
    fn text(&mut self) -> Result<bool, Stopped> {
        match self.next()? {
            (Event::SequenceEnd, _) => return Ok(false),
            (Event::MappingStart(..), _) => {}
            other => return unexpected(&other, "a text ID"),
        }
        let first = self.texts.entries.len();
        let mut id = None;
        loop {
            let key = match self.next()? {
                (Event::MappingEnd, _) => break,
                (Event::Scalar(key, ..), _) => key,
                other => return unexpected(&other, "a language"),
            };
            let value = match self.next()? {
                (Event::Scalar(value, ..), _) => value,
                other => return unexpected(&other, "a string"),
            };
            if key == "id" {
                id = Some(value);
            } else {
                self.texts.entries.push(Entry { id: Cow::Borrowed(""), language: key, text: value });
            }
        }
        let id = id.unwrap_or_default();
        self.texts.entries[first..].iter_mut().for_each(|entry| entry.id = id.clone());
        Ok(true)
    }
}

fn unexpected<T>((event, at): &(Event, Marker), expected: &str) -> Result<T, Stopped> {
    let found = match event {
        Event::Alias(_) => "an alias",
        Event::Scalar(..) => "a string",
        Event::SequenceStart(..) => "a list",
        Event::MappingStart(..) => "a group",
        _ => "the end",
    };
    Err((*at, format!("expected {expected}, found {found}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use parameters::Source;

    fn read(text: &str) -> (Texts<'_>, String) {
        let mut report = Report::default();
        let texts = Texts::read(text, 0, &mut report);
        let (errors, _) = report.problems(&[Source::new("a.s7res", text.into())]);
        (texts, errors.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn each_text_is_kept_in_each_language_and_one_is_shown() {
        let text = "MultiLingualTexts:\n  - id: MLC_b\n    de-DE: Bereit\n    en-US: 'Ready: all doors'\n    fr-FR: Prêt\n  - id: MLC_d\n    en-US: ''\n    fr-FR: Fermé\n  - id: MLC_a\n    en-US: |-\n      One line\n      # and another\n";
        let (texts, errors) = read(text);
        assert_eq!(errors, "");
        let languages = |id: &str| texts.all(id).iter().map(|entry| entry.language.to_string()).collect::<Vec<_>>();
        assert_eq!(languages("MLC_b"), ["de-DE", "en-US", "fr-FR"]);
        assert_eq!(texts.shown("MLC_b"), "Ready: all doors");
        assert_eq!(texts.shown("MLC_a"), "One line\n# and another");
        assert_eq!(texts.shown("MLC_d"), "Fermé");
        assert_eq!((texts.shown("MLC_c"), texts.shown("Doors")), ("", "Doors"));
    }

    #[test]
    fn a_file_without_texts_has_none() {
        for text in ["", "\n", "<root />\n", "MultiLingualTexts:\n", "MultiLingualTexts: []\n"] {
            let (texts, errors) = read(text);
            assert_eq!((texts.entries.len(), errors.as_str()), (0, ""), "{text}");
        }
    }

    #[test]
    fn what_is_no_list_of_texts_is_told_with_its_place() {
        let cases = [
            ("Texts:\n", "a.s7res:1:1: expected MultiLingualTexts, found a string"),
            ("MultiLingualTexts:\n  - id: a\n    en-US: 1: 2\n", "a.s7res:3:13: this is not YAML: "),
            ("MultiLingualTexts:\n  - id: &x a\n    en-US: *x\n", "a.s7res:3:12: expected a string, found an alias"),
            (
                "MultiLingualTexts:\n  - id: a\n    en-US: [[[[[[]]]]]]\n",
                "a.s7res:3:12: expected a string, found a list",
            ),
            ("MultiLingualTexts:\n  - [a]\n", "a.s7res:2:5: expected a text ID, found a list"),
            ("MultiLingualTexts: []\nMore: 1\n", "a.s7res:2:1: expected the end of the file, found a string"),
        ];
        for (text, expected) in cases {
            let (_, errors) = read(text);
            assert!(errors.starts_with(expected), "{errors}");
        }
    }

    #[test]
    fn a_bomb_of_aliases_and_a_deep_file_are_refused_where_they_begin() {
        let mut bomb = "MultiLingualTexts:\n  - id: a\n    x: &a0 text\n".to_string();
        for level in 1..60 {
            bomb += &format!("    x{level}: &a{level} [*a{0}, *a{0}]\n", level - 1);
        }
        assert!(read(&bomb).1.starts_with("a.s7res:4:"), "{}", read(&bomb).1);
        let deep = format!("MultiLingualTexts: {}", "[".repeat(1_000_000));
        assert!(read(&deep).1.starts_with("a.s7res:1:"), "{}", read(&deep).1);
    }
}
