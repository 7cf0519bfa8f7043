//! XML as a tree with places, bounded: no DTD, and limits for depth, elements and attributes.

use crate::problem::quoted;
use crate::report::Report;
use crate::source::Source;
use quick_xml::events::{BytesStart, BytesText, Event};
use quick_xml::{Reader, Writer, XmlVersion};
use std::ops::Range;

/// How deep elements may stand in each other.
const MOST_DEPTH: usize = 64;

/// The most elements of a file.
const MOST_ELEMENTS: usize = 500_000;

/// The most attributes of an element.
const MOST_ATTRIBUTES: usize = 64;

/// An element. Names have no namespace prefix.
#[derive(Debug)]
pub struct Element {
    /// Its name.
    pub name: String,
    /// The start tag.
    pub span: Range<usize>,
    attributes: Vec<(String, String)>,
    /// The elements in it.
    pub children: Vec<Element>,
    text: String,
    text_span: Range<usize>,
}

impl Element {
    /// The value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.trim())
    }

    /// The first child of this name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }

    /// All children of this name.
    pub fn children<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> + use<'a> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The text in the element, without the white space around it, and its place.
    pub fn text(&self) -> (&str, Range<usize>) {
        let is_there = !self.text.trim().is_empty();
        (self.text.trim(), if is_there { self.text_span.clone() } else { self.span.clone() })
    }
}

/// The root of a document; `None` if it is no XML document within the limits, which is reported.
pub(crate) fn read(report: &mut Report, source: &Source) -> Option<Element> {
    match tree(&source.text) {
        Ok(root) => Some(root),
        Err((place, message)) => {
            report.wrong(place..place, message, None);
            None
        }
    }
}

/// The root of a document.
///
/// # Errors
/// No XML document within the limits: a byte of the text, and what is wrong there.
pub fn tree(text: &str) -> Result<Element, (usize, String)> {
    let mut reader = Reader::from_str(text);
    let mut open: Vec<Element> = Vec::new();
    let mut root = None;
    let mut elements = 0;
    let at = |position: u64| usize::try_from(position).unwrap_or(usize::MAX);
    loop {
        let start = at(reader.buffer_position());
        let event =
            reader.read_event().map_err(|error| (at(reader.error_position()), format!("this is not XML: {error}")))?;
        let end = at(reader.buffer_position());
        let wrong = |message: String| Err((start, message));
        match event {
            Event::Start(_) | Event::Empty(_) if open.is_empty() && root.is_some() => {
                return wrong("a second root element: the document ends before it".into());
            }
            Event::Start(tag) => {
                elements += 1;
                if open.len() == MOST_DEPTH {
                    return wrong(format!("elements are nested more than {MOST_DEPTH} deep"));
                }
                open.push(element(&tag, start..end)?);
            }
            Event::Empty(tag) => {
                elements += 1;
                let element = element(&tag, start..end)?;
                match open.last_mut() {
                    Some(parent) => parent.children.push(element),
                    None => root = Some(element),
                }
            }
            Event::End(_) => {
                // The parser has checked that there is a start tag of this name.
                let element = open.pop();
                match open.last_mut() {
                    Some(parent) => parent.children.extend(element),
                    None => root = element,
                }
            }
            Event::Text(text) => add(&mut open, &text.xml10_content(), start..end)?,
            Event::CData(text) => add(&mut open, &text.xml10_content(), start..end)?,
            Event::GeneralRef(entity) => {
                let known = match entity.resolve_char_ref() {
                    Ok(Some(character)) => Some(character.to_string()),
                    _ => quick_xml::escape::resolve_xml_entity(&entity).map(str::to_string),
                };
                let Some(text) = known else {
                    return wrong(format!("the entity {} is unknown", quoted(&format!("&{};", &*entity))));
                };
                add(&mut open, &text, start..end)?;
            }
            Event::DocType(_) => return wrong("a document type definition (DTD) is not read: remove it".into()),
            Event::Decl(_) | Event::PI(_) | Event::Comment(_) => {}
            Event::Eof => break,
        }
        if elements > MOST_ELEMENTS {
            return wrong(format!("the file has more than {MOST_ELEMENTS} elements"));
        }
    }
    match (open.last(), root) {
        (Some(open), _) => Err((open.span.start, format!("the element {} is not closed", quoted(&open.name)))),
        (None, Some(root)) => Ok(root),
        (None, None) => Err((0, "the file has no XML element".into())),
    }
}

fn element(tag: &BytesStart, span: Range<usize>) -> Result<Element, (usize, String)> {
    let name = tag.local_name().as_ref().to_string();
    let wrong = |message: String| (span.start, format!("{}: {message}", quoted(&name)));
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| wrong(error.to_string()))?;
        let value = attribute.normalized_value(XmlVersion::Explicit1_0).map_err(|error| wrong(error.to_string()))?;
        if attributes.len() == MOST_ATTRIBUTES {
            return Err(wrong(format!("the element has more than {MOST_ATTRIBUTES} attributes")));
        }
        attributes.push((attribute.key.local_name().as_ref().to_string(), value.into_owned()));
    }
    let text_span = span.clone();
    Ok(Element { name, span, attributes, children: Vec::new(), text: String::new(), text_span })
}

fn add(open: &mut [Element], text: &str, span: Range<usize>) -> Result<(), (usize, String)> {
    match open.last_mut() {
        Some(element) => {
            // White space before the text is none of it: in a large file there is some before each element.
            let own = if element.text.is_empty() { text.trim_start() } else { text };
            if element.text.is_empty() {
                element.text_span = span.start + (text.len() - own.len())..span.end;
            }
            element.text.push_str(own);
            Ok(())
        }
        None if text.trim().is_empty() => Ok(()),
        None => Err((
            span.end - text.trim_start().len(),
            format!("text outside of the root element: {}", quoted(text.trim())),
        )),
    }
}

/// What an XML file begins with.
const DECLARATION: &str = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n";

/// A document with line breaks and indentation.
pub(crate) fn document(write: impl FnOnce(&mut Xml)) -> String {
    let mut xml = Xml { writer: Writer::new_with_indent(Vec::new(), b' ', 2) };
    write(&mut xml);
    format!("{DECLARATION}{}\n", String::from_utf8_lossy(&xml.writer.into_inner()))
}

/// A document that is being written to memory.
pub(crate) struct Xml {
    writer: Writer<Vec<u8>>,
}

impl Xml {
    /// An element with children.
    pub(crate) fn element(&mut self, name: &str, attributes: &[(&str, &str)], children: impl FnOnce(&mut Xml)) {
        let tag = BytesStart::new(name).with_attributes(attributes.iter().copied());
        let end = tag.to_end().into_owned();
        self.event(Event::Start(tag));
        children(self);
        self.event(Event::End(end));
    }

    /// An element without content.
    pub(crate) fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.event(Event::Empty(BytesStart::new(name).with_attributes(attributes.iter().copied())));
    }

    /// An element with a text.
    pub(crate) fn text(&mut self, name: &str, text: &str) {
        self.element(name, &[], |xml| xml.event(Event::Text(BytesText::new(text))));
    }

    /// A comment. What would end it is taken apart.
    pub(crate) fn comment(&mut self, text: &str) {
        let text = format!(" {} ", text.replace("--", "- -"));
        self.event(Event::Comment(BytesText::from_escaped(text)));
    }

    fn event(&mut self, event: Event) {
        // Writing to memory does not fail.
        let _ = self.writer.write_event(event);
    }
}

/// Refuses a text that XML cannot hold.
pub(crate) fn check(text: &str) -> Result<(), String> {
    let is_xml = |character: char| matches!(character, '\t' | '\n' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..);
    match text.chars().find(|character| !is_xml(*character)) {
        Some(character) => Err(format!("XML cannot hold the character {character:?} of {}", quoted(text))),
        None => Ok(()),
    }
}
