//! Parses XML into a tree with locations and limits: no DTD, and bounded depth, elements, attributes and memory.

use crate::problem::quoted;
use crate::report::Report;
use crate::source::Source;
use quick_xml::events::attributes::Attributes;
use quick_xml::events::{BytesStart, BytesText, Event};
use quick_xml::{Reader, Writer, XmlVersion};
use std::borrow::Cow;
use std::ops::Range;

/// The maximum nesting depth of elements.
const MOST_DEPTH: usize = 64;

/// The maximum number of elements in a file.
const MOST_ELEMENTS: usize = 500_000;

/// The maximum number of attributes of an element.
const MOST_ATTRIBUTES: usize = 64;

/// A document, which takes a few bytes per element: contents are read from the text on demand.
#[derive(Debug)]
pub struct Document<'t> {
    source: &'t str,
    /// The elements in document order, so that descendants follow their ancestor.
    nodes: Vec<Node>,
    texts: Vec<Text>,
    /// The attribute values that differ from the source text, in order.
    values: Vec<Value>,
    /// Texts and values that differ from the source text, resolved.
    resolved: String,
}

#[derive(Debug)]
struct Node {
    /// The byte range of the start tag.
    start: u32,
    end: u32,
    /// The index of the next element that is not a descendant.
    next: u32,
    /// The index of its text plus 1, or 0 if it has none.
    text: u32,
}

#[derive(Debug)]
struct Text {
    /// The byte range of its first part in the source, up to the next entity or tag.
    place: [u32; 2],
    /// The byte range of the whole text, in the source or in the resolved texts.
    bytes: [u32; 2],
    is_resolved: bool,
}

#[derive(Debug)]
struct Value {
    /// The position in the source.
    place: u32,
    /// The byte range in the resolved texts.
    bytes: [u32; 2],
}

/// An element. Names have no namespace prefix.
#[derive(Clone, Copy, Debug)]
pub struct Element<'d> {
    document: &'d Document<'d>,
    at: usize,
}

impl<'d> Element<'d> {
    fn node(self) -> &'d Node {
        &self.document.nodes[self.at]
    }

    /// Its name.
    pub fn name(self) -> &'d str {
        local(tag(self.document.source, self.span()).0)
    }

    /// The range of the start tag.
    pub fn span(self) -> Range<usize> {
        self.node().start as usize..self.node().end as usize
    }

    /// The value of an attribute.
    pub fn attribute(self, name: &str) -> Option<&'d str> {
        let source = self.document.source;
        let (own, content) = tag(source, self.span());
        let mut attributes = Attributes::new(content, own.len());
        let own = attributes.with_checks(false).flatten().find(|own| own.key.local_name().as_ref() == name)?;
        let place = offset(source, &own.value);
        let resolved = self.document.values.binary_search_by_key(&short(place), |value| value.place).ok();
        let value = match resolved {
            Some(number) => part(&self.document.resolved, self.document.values[number].bytes),
            None => &source[place..place + own.value.len()],
        };
        Some(value.trim())
    }

    /// The child elements.
    pub fn elements(self) -> impl Iterator<Item = Element<'d>> + Clone + use<'d> {
        let (document, end) = (self.document, self.node().next as usize);
        let first = Some(self.at + 1);
        let numbers = std::iter::successors(first, move |at| document.nodes.get(*at).map(|node| node.next as usize));
        numbers.take_while(move |at| *at < end).map(move |at| Element { document, at })
    }

    /// The first child with this name.
    pub fn child(self, name: &str) -> Option<Element<'d>> {
        self.elements().find(|child| child.name() == name)
    }

    /// All children with this name.
    pub fn children<'n>(self, name: &'n str) -> impl Iterator<Item = Element<'d>> + use<'d, 'n> {
        self.elements().filter(move |child| child.name() == name)
    }

    /// The text in the element, without the white space around it, and its location.
    pub fn text(self) -> (&'d str, Range<usize>) {
        let number = (self.node().text as usize).checked_sub(1);
        match number.and_then(|number| self.document.texts.get(number)) {
            Some(text) => {
                let source = if text.is_resolved { &self.document.resolved } else { self.document.source };
                (part(source, text.bytes).trim(), text.place[0] as usize..text.place[1] as usize)
            }
            None => ("", self.span()),
        }
    }
}

/// An offset in a file, which has at most 4 GB.
fn short(place: usize) -> u32 {
    place as u32
}

fn part(text: &str, bytes: [u32; 2]) -> &str {
    &text[bytes[0] as usize..bytes[1] as usize]
}

/// The offset of a part within a text.
fn offset(text: &str, part: &str) -> usize {
    part.as_ptr() as usize - text.as_ptr() as usize
}

/// The name in a start tag, and everything between its brackets.
fn tag(source: &str, span: Range<usize>) -> (&str, &str) {
    let content = source[span].trim_start_matches('<').trim_end_matches('>');
    let content = content.strip_suffix('/').unwrap_or(content);
    let end = content.find(|character: char| character.is_ascii_whitespace()).unwrap_or(content.len());
    (&content[..end], content)
}

/// A name without its namespace prefix.
fn local(name: &str) -> &str {
    name.split_once(':').map_or(name, |(_, local)| local)
}

/// Parses a document; `None` if it is not XML within the limits, which is reported.
pub(crate) fn read<'t>(report: &mut Report, source: &'t Source) -> Option<Document<'t>> {
    match tree(&source.text) {
        Ok(document) => Some(document),
        Err((place, message)) => {
            report.wrong(place..place, message, None);
            None
        }
    }
}

/// An element whose end has not been reached, and its text so far.
struct Open {
    node: usize,
    text: Option<(Range<usize>, Written)>,
}

/// The text of an element.
enum Written {
    /// A range of the source.
    Source(Range<usize>),
    Resolved(String),
}

/// Parses the elements of a document.
///
/// # Errors
/// It is not XML within the limits: the byte offset, and the error there.
pub fn tree(source: &str) -> Result<Document<'_>, (usize, String)> {
    // The parser skips a byte order mark and does not count it.
    let first = source.len() - source.trim_start_matches('\u{feff}').len();
    let mut reader = Reader::from_str(&source[first..]);
    let mut document = Document::parse(source)?;
    let mut open: Vec<Open> = Vec::new();
    let at = |position: u64| usize::try_from(position).map_or(usize::MAX, |position| first + position);
    loop {
        let start = at(reader.buffer_position());
        let event =
            reader.read_event().map_err(|error| (at(reader.error_position()), format!("this is not XML: {error}")))?;
        let end = at(reader.buffer_position());
        let wrong = |message: String| Err((start, message));
        match event {
            Event::Start(_) | Event::Empty(_) if open.is_empty() && !document.nodes.is_empty() => {
                return wrong("a second root element: the document ends before it".into());
            }
            Event::Start(_) | Event::Empty(_) if document.nodes.len() == MOST_ELEMENTS => {
                return wrong(format!("the file has more than {MOST_ELEMENTS} elements"));
            }
            Event::Start(_) => {
                if open.len() == MOST_DEPTH {
                    return wrong(format!("elements are nested more than {MOST_DEPTH} deep"));
                }
                open.push(Open { node: document.element(start..end)?, text: None });
            }
            Event::Empty(_) => drop(document.element(start..end)?),
            // The parser has checked that the matching start tag exists.
            Event::End(_) => open.pop().into_iter().for_each(|element| document.close(element)),
            Event::Text(text) => document.add(&mut open, text.xml10_content(), start..end)?,
            Event::CData(text) => document.add(&mut open, text.xml10_content(), start..end)?,
            Event::GeneralRef(entity) => {
                let known = match entity.resolve_char_ref() {
                    Ok(Some(character)) => Some(character.to_string()),
                    _ => quick_xml::escape::resolve_xml_entity(&entity).map(str::to_string),
                };
                let Some(text) = known else {
                    return wrong(format!("the entity {} is unknown", quoted(&format!("&{};", &*entity))));
                };
                document.add(&mut open, text.into(), start..end)?;
            }
            Event::DocType(_) => return wrong("a document type definition (DTD) is not supported: remove it".into()),
            Event::Decl(_) | Event::PI(_) | Event::Comment(_) => {}
            Event::Eof => break,
        }
    }
    match open.last().map(|open| Element { document: &document, at: open.node }) {
        Some(open) => Err((open.span().start, format!("the element {} is not closed", quoted(open.name())))),
        None if document.nodes.is_empty() => Err((0, "the file has no XML element".into())),
        None => Ok(document),
    }
}

impl<'t> Document<'t> {
    /// A document without elements, with capacity for the elements of the text.
    fn parse(source: &'t str) -> Result<Document<'t>, (usize, String)> {
        if u32::try_from(source.len()).is_err() {
            return Err((0, "the file is larger than 4 GB".into()));
        }
        let begins = |pair: &&[u8]| pair[0] == b'<' && !matches!(pair[1], b'/' | b'!' | b'?' | b'<');
        let count = source.as_bytes().windows(2).filter(begins).count();
        let nodes = Vec::with_capacity(count.min(MOST_ELEMENTS));
        Ok(Document { source, nodes, texts: Vec::new(), values: Vec::new(), resolved: String::new() })
    }

    /// The root element.
    pub fn root(&self) -> Element<'_> {
        Element { document: self, at: 0 }
    }

    /// Adds an element by its start tag; returns its index.
    fn element(&mut self, span: Range<usize>) -> Result<usize, (usize, String)> {
        let source = self.source;
        let (name, content) = tag(source, span.clone());
        let wrong = |message: String| (span.start, format!("{}: {message}", quoted(local(name))));
        for (count, attribute) in Attributes::new(content, name.len()).enumerate() {
            let attribute = attribute.map_err(|error| wrong(error.to_string()))?;
            let value =
                attribute.normalized_value(XmlVersion::Explicit1_0).map_err(|error| wrong(error.to_string()))?;
            if count == MOST_ATTRIBUTES {
                return Err(wrong(format!("the element has more than {MOST_ATTRIBUTES} attributes")));
            }
            if let Cow::Owned(value) = value {
                let place = short(offset(source, &attribute.value));
                let bytes = self.resolve(&value);
                self.values.push(Value { place, bytes });
            }
        }
        let number = self.nodes.len();
        self.nodes.push(Node { start: short(span.start), end: short(span.end), next: short(number + 1), text: 0 });
        Ok(number)
    }

    fn resolve(&mut self, text: &str) -> [u32; 2] {
        let start = self.resolved.len();
        self.resolved.push_str(text);
        [short(start), short(self.resolved.len())]
    }

    /// Appends text to the innermost open element. Outside the root element, only white space is allowed.
    fn add(&self, open: &mut [Open], text: Cow<'_, str>, span: Range<usize>) -> Result<(), (usize, String)> {
        match open.last_mut() {
            Some(Open { text: Some((_, before)), .. }) => {
                if let Written::Source(bytes) = before {
                    *before = Written::Resolved(self.source[bytes.clone()].to_string());
                }
                if let Written::Resolved(before) = before {
                    before.push_str(&text);
                }
                Ok(())
            }
            Some(open) => {
                // Leading white space is dropped: a large file has some before each element.
                let own = text.trim_start();
                if !own.is_empty() {
                    let place = span.start + (text.len() - own.len())..span.end;
                    let written = match text {
                        Cow::Borrowed(_) => {
                            let start = offset(self.source, own);
                            Written::Source(start..start + own.len())
                        }
                        Cow::Owned(_) => Written::Resolved(own.to_string()),
                    };
                    open.text = Some((place, written));
                }
                Ok(())
            }
            None if text.trim().is_empty() => Ok(()),
            None => Err((
                span.end - text.trim_start().len(),
                format!("text outside the root element: {}", quoted(text.trim())),
            )),
        }
    }

    /// Stores the text of an element whose end has been reached, and the index of the element after it.
    fn close(&mut self, element: Open) {
        if let Some((place, written)) = element.text {
            let (bytes, is_resolved) = match written {
                Written::Source(bytes) => ([short(bytes.start), short(bytes.end)], false),
                Written::Resolved(text) => (self.resolve(&text), true),
            };
            self.texts.push(Text { place: [short(place.start), short(place.end)], bytes, is_resolved });
            self.nodes[element.node].text = short(self.texts.len());
        }
        self.nodes[element.node].next = short(self.nodes.len());
    }
}

const DECLARATION: &str = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n";

/// Writes a document with line breaks and indentation.
pub(crate) fn document(write: impl FnOnce(&mut Xml)) -> String {
    let mut xml = Xml { writer: Writer::new_with_indent(Vec::new(), b' ', 2) };
    write(&mut xml);
    format!("{DECLARATION}{}\n", String::from_utf8_lossy(&xml.writer.into_inner()))
}

/// A document being written to memory.
pub(crate) struct Xml {
    writer: Writer<Vec<u8>>,
}

impl Xml {
    /// Writes an element with children.
    pub(crate) fn element(&mut self, name: &str, attributes: &[(&str, &str)], children: impl FnOnce(&mut Xml)) {
        let tag = BytesStart::new(name).with_attributes(attributes.iter().copied());
        let end = tag.to_end().into_owned();
        self.event(Event::Start(tag));
        children(self);
        self.event(Event::End(end));
    }

    /// Writes an empty element.
    pub(crate) fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.event(Event::Empty(BytesStart::new(name).with_attributes(attributes.iter().copied())));
    }

    /// Writes an element that contains text.
    pub(crate) fn text(&mut self, name: &str, text: &str) {
        self.element(name, &[], |xml| xml.event(Event::Text(BytesText::new(text))));
    }

    /// Writes a comment; sequences that would end it are broken up.
    pub(crate) fn comment(&mut self, text: &str) {
        let text = format!(" {} ", text.replace("--", "- -"));
        self.event(Event::Comment(BytesText::from_escaped(text)));
    }

    fn event(&mut self, event: Event) {
        // Writing to memory never fails.
        let _ = self.writer.write_event(event);
    }
}

/// Rejects a string that XML cannot represent.
pub(crate) fn check(text: &str) -> Result<(), String> {
    let is_xml = |character: char| matches!(character, '\t' | '\n' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..);
    match text.chars().find(|character| !is_xml(*character)) {
        Some(character) => Err(format!("XML cannot represent the character {character:?} in {}", quoted(text))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(document: &Document) -> usize {
        document.nodes.capacity() * size_of::<Node>()
            + document.texts.capacity() * size_of::<Text>()
            + document.values.capacity() * size_of::<Value>()
            + document.resolved.capacity()
    }

    /// The smallest elements with text, an attribute or an entity: no file needs ten times its size in memory.
    #[test]
    fn a_file_of_tiny_elements_takes_little_memory() {
        for (element, count) in [
            ("<a/>", 20_000),
            ("<a></a>", 20_000),
            ("<a>x</a>", 10_000),
            ("<a>&lt;</a>", 10_000),
            ("<a b=\"&lt;\"/>", 10_000),
        ] {
            let text = format!("<r>{}</r>", element.repeat(count));
            let document = tree(&text).unwrap();
            assert_eq!(document.root().elements().count(), count);
            // While a growing vector is reallocated, its old and new memory coexist.
            let grown = bytes(&document) - document.nodes.capacity() * size_of::<Node>();
            let most = bytes(&document) + grown / 2;
            assert!(most < 9 * text.len(), "{element}: {most} bytes for {}", text.len());
        }
        // Only looks like elements.
        assert!(bytes(&Document::parse(&"<a".repeat(10_000)).unwrap()) <= 8 * 20_000);
    }

    #[test]
    fn values_and_texts_are_resolved_and_keep_their_places() {
        let text = "\u{feff}<x:r a=\"1\" q:b=\" &lt;2&#10;\"> one &amp; two<c/> three<![CDATA[ <&> ]]></x:r>";
        let document = tree(text).unwrap();
        let root = document.root();
        assert_eq!((root.name(), root.attribute("a"), root.attribute("b")), ("r", Some("1"), Some("<2")));
        assert_eq!((root.attribute("c"), &text[root.span()][..4]), (None, "<x:r"));
        assert_eq!(root.text().0, "one & two three <&>");
        assert_eq!(&text[root.text().1], "one ");
        let child = root.child("c").unwrap();
        assert_eq!((child.text(), child.elements().count()), (("", child.span()), 0));
    }
}
