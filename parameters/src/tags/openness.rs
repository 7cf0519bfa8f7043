//! Reads tag tables in XML, as exported by TIA Portal Openness.

use super::{Constant, Tag, Tags, Wrong, address_of, literal, one_line};
use crate::problem::quoted;
use crate::source::Source;
use crate::xml::{self, Element};

/// Reads the tags and the user constants of all tables of a document.
pub(super) fn read(source: &Source) -> Result<Tags, Vec<Wrong>> {
    let document = xml::tree(&source.text).map_err(|(place, message)| vec![(place..place, message)])?;
    let root = document.root();
    let mut reading = Reading { tags: Tags::default(), wrong: Vec::new(), tables: 0 };
    reading.element(root);
    if reading.tables == 0 && reading.tags == Tags::default() {
        let message = format!("expected a Document with an SW.Tags.PlcTagTable, found {}", quoted(root.name()));
        reading.wrong.push((root.span(), message));
    }
    if reading.wrong.is_empty() { Ok(reading.tags) } else { Err(reading.wrong) }
}

struct Reading {
    tags: Tags,
    wrong: Vec<Wrong>,
    tables: usize,
}

impl Reading {
    /// Reads an element and its children; the XML reader limits the depth.
    fn element(&mut self, of: Element) {
        match of.name() {
            "SW.Tags.PlcTag" => self.tag(of),
            "SW.Tags.PlcUserConstant" | "SW.Tags.PlcConstant" => self.constant(of),
            // System constants are names of hardware, with numbers that are meaningless outside their PLC.
            "SW.Tags.PlcSystemConstant" => {}
            name => {
                self.tables += usize::from(name == "SW.Tags.PlcTagTable");
                of.elements().for_each(|child| self.element(child));
            }
        }
    }

    fn tag(&mut self, of: Element) {
        let Some(name) = self.text(of, "Name") else { return };
        let Some(ty) = self.text(of, "DataTypeName") else { return };
        let written = attribute(of, "LogicalAddress").unwrap_or_default();
        match address_of(&name, &written) {
            Ok(address) => {
                let of_type = ty.trim_matches('"').to_string();
                self.tags.tags.push(Tag { name, of: of_type, address, comment: comment(of) });
            }
            Err(message) => self.wrong.push((of.span(), message)),
        }
    }

    fn constant(&mut self, of: Element) {
        let Some(name) = self.text(of, "Name") else { return };
        let Some(value) = self.text(of, "Value") else { return };
        let ty = attribute(of, "DataTypeName").unwrap_or_default();
        self.tags.constants.push(Constant { name, value: literal(ty.trim_matches('"'), &value) });
    }

    /// The text of a mandatory attribute.
    fn text(&mut self, of: Element, name: &str) -> Option<String> {
        let text = attribute(of, name).filter(|text| !text.is_empty());
        if text.is_none() {
            let whose = attribute(of, "Name").map_or_else(String::new, |name| format!(" {}", quoted(&name)));
            self.wrong.push((of.span(), format!("{}{whose} has no {name}", of.name())));
        }
        text
    }
}

fn attribute(of: Element, name: &str) -> Option<String> {
    Some(of.child("AttributeList")?.child(name)?.text().0.to_string())
}

/// The English comment if there is one, otherwise the first that is not empty.
fn comment(of: Element) -> String {
    let is_comment = |text: &Element| text.attribute("CompositionName") == Some("Comment");
    let texts =
        of.child("ObjectList").into_iter().flat_map(|list| list.children("MultilingualText")).filter(is_comment);
    let items = texts.flat_map(|text| text.child("ObjectList")).flat_map(|list| list.children("MultilingualTextItem"));
    let texts: Vec<(String, String)> = items
        .map(|item| (attribute(item, "Culture").unwrap_or_default(), attribute(item, "Text").unwrap_or_default()))
        .filter(|(_, text)| !text.is_empty())
        .collect();
    let english = texts.iter().find(|(culture, _)| culture.starts_with("en"));
    english.or(texts.first()).map_or_else(String::new, |(_, text)| one_line(text))
}
