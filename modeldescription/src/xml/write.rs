//! Writes elements as XML.

use super::attributes::Element;
use super::lexical::is_xml;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use std::borrow::Cow;

/// Writes a document with this root.
pub(crate) fn write(root: &impl Element) -> Vec<u8> {
    let mut xml = Xml { writer: Writer::new_with_indent(Vec::new(), b' ', 2), start: None };
    xml.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
    root.write(&mut xml);
    let mut bytes = xml.writer.into_inner();
    bytes.push(b'\n');
    bytes
}

/// The document written so far.
pub(crate) struct Xml {
    writer: Writer<Vec<u8>>,
    /// The start tag of the current element, until its first child.
    start: Option<BytesStart<'static>>,
}

impl Xml {
    /// Writes an element: `content` writes its attributes, then its children.
    pub(crate) fn element(&mut self, name: &'static str, content: impl FnOnce(&mut Xml)) {
        self.end_start_tag();
        self.start = Some(BytesStart::new(name));
        content(self);
        match self.start.take() {
            Some(empty) => self.event(Event::Empty(empty)),
            None => self.event(Event::End(BytesEnd::new(name))),
        }
    }

    /// Writes an element with a start tag and an end tag, even if it has no children.
    pub(crate) fn list(&mut self, name: &'static str, items: impl FnOnce(&mut Xml)) {
        self.element(name, |xml| {
            xml.end_start_tag();
            items(xml);
        });
    }

    /// Adds an attribute to the current element, which must not have children yet.
    pub(crate) fn attribute(&mut self, name: &str, value: &str) {
        let value = if value.chars().all(is_xml) {
            Cow::Borrowed(value)
        } else {
            Cow::Owned(value.chars().map(|character| if is_xml(character) { character } else { '\u{fffd}' }).collect())
        };
        if let Some(tag) = &mut self.start {
            // Line breaks and tabs are escaped, too, because a reader would turn them into spaces.
            tag.push_attribute((name, value.as_ref()));
        }
    }

    fn end_start_tag(&mut self) {
        if let Some(tag) = self.start.take() {
            self.event(Event::Start(tag));
        }
    }

    fn event(&mut self, event: Event<'_>) {
        self.writer.write_event(event).expect("a Vec takes all bytes");
    }
}
