//! Reads a modelDescription.xml, or another FMI file, as elements.

use super::attributes::{Element, TWICE};
use super::lexical::{SPACES, Value, is_xml};
use crate::error::{Error, shortened};
use quick_xml::events::{BytesDecl, BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::borrow::Cow;

/// The limits for reading. Reading a file within them takes at most about ten times its size in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The maximum size of the file, in bytes.
    pub bytes: usize,
    /// The maximum number of variables.
    pub variables: usize,
    /// The maximum total number of elements.
    pub elements: usize,
    /// The maximum nesting depth of elements inside an annotation. The schema fixes all other depths.
    pub depth: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { bytes: 64 << 20, variables: 1_000_000, elements: 4_000_000, depth: 64 }
    }
}

/// What a document is expected to contain.
#[derive(Clone, Copy)]
pub(crate) struct Schema {
    /// The FMI version, as stated by `fmiVersion`.
    pub(crate) version: &'static str,
    /// The name of the root element, and the term for this kind of file.
    pub(crate) root: (&'static str, &'static str),
    /// The names of the elements that are variables.
    pub(crate) variables: &'static [&'static str],
    /// The name of an element that may occur inside any other and is skipped.
    pub(crate) skipped: Option<&'static str>,
}

/// The root of a modelDescription.xml.
pub(crate) const MODEL_DESCRIPTION: (&str, &str) = ("fmiModelDescription", "model description");

/// The index in `versions` of the version of a modelDescription.xml.
pub(crate) fn version(bytes: &[u8], versions: &[&'static str]) -> Result<usize, Error> {
    let limits = Limits::default();
    let schema = Schema { version: versions[0], root: MODEL_DESCRIPTION, variables: &[], skipped: None };
    version_among(versions, &Document::new(text(bytes, limits, schema)?, limits, schema).root()?)
}

/// The file's text.
fn text(bytes: &[u8], limits: Limits, schema: Schema) -> Result<&str, Error> {
    if bytes.len() > limits.bytes {
        let (what, size, most) = (schema.root.1, bytes.len(), limits.bytes);
        return Err(Error::new(format!("the {what} has {size} bytes: the limit is {most}")));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let place = error.valid_up_to();
        at_line(bytes, place, &format!("byte 0x{:02x} is not UTF-8: save the file as UTF-8", bytes[place]))
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// Reads a file. `contradiction` then checks the root element: it returns a sentence and the 0-based position of the
/// variable to blame, if any, whose line is added to the error.
pub(crate) fn read_root<T: Element>(
    bytes: &[u8],
    limits: Limits,
    schema: Schema,
    contradiction: impl FnOnce(&T) -> Option<(Option<usize>, String)>,
) -> Result<T, Error> {
    let mut document = Document::new(text(bytes, limits, schema)?, limits, schema);
    let root = document.root()?;
    version_among(&[schema.version], &root)?;
    let description = T::read(&mut document, &root)?;
    document.end()?;
    match contradiction(&description) {
        None => Ok(description),
        Some((None, sentence)) => Err(Error::new(sentence)),
        Some((Some(variable), sentence)) => {
            Err(at_line(document.text.as_bytes(), document.variables[variable], &sentence))
        }
    }
}

/// The XML reader's error, shortened because it may quote a name of any length.
fn not_xml(error: &impl std::fmt::Display) -> String {
    format!("this is not XML: {:.300}", error.to_string())
}

/// A sentence that starts with the line number.
fn at_line(bytes: &[u8], place: usize, sentence: &str) -> Error {
    let line = 1 + bytes.iter().take(place).filter(|byte| **byte == b'\n').count();
    Error::new(format!("line {line}: {sentence}"))
}

/// A start tag.
pub(crate) struct Tag<'a> {
    tag: BytesStart<'a>,
    /// Whether it is also the end tag: `<a/>`.
    is_empty: bool,
    /// The FMI version.
    version: &'static str,
    /// The whole document, and the byte position of the tag in it.
    text: &'a str,
    place: usize,
}

impl Tag<'_> {
    pub(crate) fn name(&self) -> &str {
        self.tag.name().0
    }

    pub(crate) fn refused(&self, sentence: &str) -> Error {
        at_line(self.text.as_bytes(), self.place, &format!("{}: {sentence}", shortened(self.name())))
    }

    /// The attributes with these names, in the order of the names; `None` for an absent one. Attributes of other
    /// namespaces are skipped; unknown ones are rejected.
    pub(crate) fn attributes<const COUNT: usize>(
        &self,
        names: &[&'static str],
    ) -> Result<[Option<Attribute<'_>>; COUNT], Error> {
        let mut attributes = [const { None }; COUNT];
        self.read_attributes(names, &mut attributes)?;
        Ok(attributes)
    }

    /// Stores the attributes with these names in `attributes`, in the order of the names.
    pub(crate) fn read_attributes<'e>(
        &'e self,
        names: &[&'static str],
        attributes: &mut [Option<Attribute<'e>>],
    ) -> Result<(), Error> {
        // Duplicates are detected below: the parser's own check, which compares all pairs of attributes, would be slow.
        for attribute in self.tag.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| self.refused(&format!("{error}: repair the tag")))?;
            let name = attribute.key.0;
            let Some(place) = names.iter().position(|known| *known == name) else {
                if name == "xmlns" || name.contains(':') {
                    continue;
                }
                let known = if names.is_empty() { "none".into() } else { names.join(", ") };
                return Err(self.refused(&format!(
                    "attribute {:?} is unknown: FMI {} defines {known}",
                    shortened(name),
                    self.version
                )));
            };
            let refused =
                |reason: &str| self.refused(&format!("{} = {:?}: {reason}", names[place], shortened(&attribute.value)));
            if attributes[place].is_some() {
                return Err(refused("the attribute occurs twice: remove one"));
            }
            if attribute.value.contains('<') {
                return Err(refused("write < as &lt;"));
            }
            let value = attribute.normalized_value(XmlVersion::Explicit1_0).map_err(|_| {
                refused(
                    "only &lt; &gt; &amp; &quot; &apos; and numbers such as &#10; may follow an &: write & itself as &amp;",
                )
            })?;
            if let Some(character) = value.chars().find(|character| !is_xml(*character)) {
                return Err(refused(&format!("XML cannot represent the character {character:?}: remove it")));
            }
            attributes[place] = Some(Attribute { tag: self, name: names[place], value });
        }
        Ok(())
    }
}

/// An attribute. In its value, entities are resolved and line breaks are replaced by spaces.
pub(crate) struct Attribute<'e> {
    tag: &'e Tag<'e>,
    name: &'static str,
    value: Cow<'e, str>,
}

impl Attribute<'_> {
    fn refused(&self, reason: &str) -> Error {
        self.tag.refused(&format!("{} = {:?}: {reason}", self.name, shortened(&self.value)))
    }

    /// The value, or an error that states the expected form.
    pub(crate) fn value<T: Value>(self) -> Result<T, Error> {
        T::parse(&self.value).ok_or_else(|| self.refused(&format!("expected {}", T::expected())))
    }
}

/// A part of a document.
enum Piece<'a> {
    Tag(Tag<'a>),
    EndTag,
    /// The byte position of a text that is not just white space.
    Text(usize),
    End,
}

/// The document, read once from start to end.
pub(crate) struct Document<'a> {
    reader: Reader<&'a [u8]>,
    text: &'a str,
    limits: Limits,
    schema: Schema,
    elements: usize,
    /// The byte position of each variable in the text.
    variables: Vec<usize>,
}

impl<'a> Document<'a> {
    fn new(text: &'a str, limits: Limits, schema: Schema) -> Document<'a> {
        Document { reader: Reader::from_str(text), text, limits, schema, elements: 0, variables: Vec::new() }
    }

    fn refused(&self, place: usize, sentence: &str) -> Error {
        at_line(self.text.as_bytes(), place, sentence)
    }

    /// The next tag or text. White space, comments and processing instructions are skipped.
    fn next(&mut self) -> Result<Piece<'a>, Error> {
        loop {
            let place = usize::try_from(self.reader.buffer_position()).unwrap_or(usize::MAX);
            let event = self.reader.read_event().map_err(|error| {
                let place = usize::try_from(self.reader.error_position()).unwrap_or(usize::MAX);
                self.refused(place, &not_xml(&error))
            })?;
            return Ok(match event {
                Event::Start(tag) => Piece::Tag(self.element(place, tag, false)?),
                Event::Empty(tag) => Piece::Tag(self.element(place, tag, true)?),
                Event::End(_) => Piece::EndTag,
                Event::Text(text) => match text.find(|character| !SPACES.contains(&character)) {
                    None => continue,
                    Some(spaces) => Piece::Text(place + spaces),
                },
                Event::CData(_) => Piece::Text(place),
                Event::GeneralRef(entity) => {
                    let is_known = matches!(&*entity, "lt" | "gt" | "amp" | "quot" | "apos");
                    if !is_known && !matches!(entity.resolve_char_ref(), Ok(Some(_))) {
                        let sentence =
                            format!("entity &{}; is not supported: write its text instead", shortened(&entity));
                        return Err(self.refused(place, &sentence));
                    }
                    Piece::Text(place)
                }
                Event::Comment(_) | Event::PI(_) => continue,
                Event::Decl(declaration) if place == 0 => {
                    self.check_declaration(&declaration)?;
                    continue;
                }
                Event::Decl(_) => {
                    let sentence = "the XML declaration is not at the start of the file: move it there";
                    return Err(self.refused(place, sentence));
                }
                Event::DocType(_) => {
                    let sentence = "a document type declaration (<!DOCTYPE) is not supported: remove it";
                    return Err(self.refused(place, sentence));
                }
                Event::Eof => Piece::End,
            });
        }
    }

    fn element(&mut self, place: usize, tag: BytesStart<'a>, is_empty: bool) -> Result<Tag<'a>, Error> {
        self.elements += 1;
        let most = self.limits.elements;
        if self.elements > most {
            return Err(self.refused(place, &format!("too many elements: the limit is {most}")));
        }
        Ok(Tag { tag, is_empty, version: self.schema.version, text: self.text, place })
    }

    fn check_declaration(&self, declaration: &BytesDecl<'_>) -> Result<(), Error> {
        let version = declaration.version().map_err(|error| self.refused(0, &not_xml(&error)))?;
        if version != "1.0" {
            return Err(self.refused(0, &format!("XML {:?} is not supported: FMI uses 1.0", shortened(&version))));
        }
        let encoding = declaration.encoding().transpose();
        let encoding = encoding.map_err(|error| self.refused(0, &not_xml(&error)))?;
        // ASCII text is the same in every encoding likely to occur here.
        if let Some(encoding) = encoding.filter(|encoding| !encoding.eq_ignore_ascii_case("utf-8"))
            && !self.text.is_ascii()
        {
            let encoding = shortened(&encoding).into_owned();
            return Err(self.refused(0, &format!("encoding = {encoding:?}: save the file as UTF-8")));
        }
        Ok(())
    }

    /// The start tag of the root element.
    fn root(&mut self) -> Result<Tag<'a>, Error> {
        let (name, what) = self.schema.root;
        match self.next()? {
            Piece::Tag(root) if root.name() == name => Ok(root),
            Piece::Tag(root) => Err(root.refused(&format!("this is not a {what}, which begins with <{name}"))),
            _ => Err(self.refused(0, &format!("this is not XML: a {what} begins with <{name}"))),
        }
    }

    /// Rejects anything after the root.
    fn end(&mut self) -> Result<(), Error> {
        match self.next()? {
            Piece::Tag(Tag { place, .. }) | Piece::Text(place) => {
                Err(self.refused(place, &format!("unexpected content after </{}>: remove it", self.schema.root.0)))
            }
            // The parser rejects an end tag without a start tag.
            Piece::EndTag | Piece::End => Ok(()),
        }
    }

    /// Reads all children of an element. `read` reads a child to its end, or returns false if the child is unknown.
    pub(crate) fn children(
        &mut self,
        parent: &Tag<'_>,
        mut read: impl FnMut(&mut Self, &Tag<'_>) -> Result<bool, Error>,
    ) -> Result<(), Error> {
        let mut is_skipped = false;
        while let Some(child) = self.child(parent)? {
            if self.schema.skipped == Some(child.name()) {
                self.skip(&child, &mut is_skipped)?;
            } else if !read(self, &child)? {
                let parent = parent.name();
                return Err(
                    child.refused(&format!("FMI {} has no such element inside {parent}: remove it", child.version))
                );
            }
        }
        Ok(())
    }

    /// The next child of an element; `None` at its end.
    fn child(&mut self, parent: &Tag<'_>) -> Result<Option<Tag<'a>>, Error> {
        if parent.is_empty {
            return Ok(None);
        }
        match self.next()? {
            Piece::Tag(child) => {
                if self.schema.variables.contains(&child.name()) {
                    self.count_variable(&child)?;
                }
                Ok(Some(child))
            }
            Piece::EndTag => Ok(None),
            Piece::Text(place) => {
                let sentence = format!(
                    "text inside {}, which FMI {} does not allow: remove it",
                    parent.name(),
                    self.schema.version
                );
                Err(self.refused(place, &sentence))
            }
            Piece::End => Err(cut_off(parent)),
        }
    }

    fn count_variable(&mut self, variable: &Tag<'_>) -> Result<(), Error> {
        let most = self.limits.variables;
        if self.variables.len() >= most {
            return Err(variable.refused(&format!("too many variables: the limit is {most}")));
        }
        self.variables.push(variable.place);
        Ok(())
    }

    /// Skips an annotation with its contents. Sets `is_repeated`, so that a second one is rejected.
    pub(crate) fn skip(&mut self, element: &Tag<'_>, is_repeated: &mut bool) -> Result<bool, Error> {
        if std::mem::replace(is_repeated, true) {
            return Err(element.refused(TWICE));
        }
        let most = self.limits.depth;
        let mut depth = usize::from(!element.is_empty);
        while depth > 0 {
            match self.next()? {
                Piece::Tag(_) if depth > most => {
                    return Err(
                        element.refused(&format!("the elements inside are nested too deeply: the limit is {most}"))
                    );
                }
                Piece::Tag(child) => depth += usize::from(!child.is_empty),
                Piece::EndTag => depth -= 1,
                Piece::Text(_) => {}
                Piece::End => return Err(cut_off(element)),
            }
        }
        Ok(true)
    }
}

fn cut_off(element: &Tag<'_>) -> Error {
    element.refused("the file ends inside this element: it is truncated")
}

/// The index in `versions` of the version stated by the root element. It is determined first because other FMI versions
/// have different attributes.
fn version_among(versions: &[&'static str], root: &Tag<'_>) -> Result<usize, Error> {
    let mut attributes = root.tag.attributes();
    let attributes = attributes.with_checks(false).filter_map(Result::ok);
    let Some(version) = attributes.into_iter().find(|attribute| attribute.key.0 == "fmiVersion") else {
        return Err(root.refused("attribute fmiVersion is missing: add fmiVersion=\"2.0\" if it is FMI 2.0"));
    };
    versions.iter().position(|known| version.value == *known).ok_or_else(|| {
        let (version, known) = (shortened(&version.value), versions.join(" or "));
        root.refused(&format!("fmiVersion = {version:?} is not supported: it must be {known}"))
    })
}
