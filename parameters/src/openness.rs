//! XML as TIA Portal Openness exports and imports instance data blocks (SimaticML).
//!
//! ```xml
//! <Document>
//!   <SW.Blocks.InstanceDB ID="0">
//!     <AttributeList>
//!       <InstanceOfName>PUMP</InstanceOfName>
//!       <Interface><Sections xmlns="http://www.siemens.com/automation/Openness/SW/Interface/v5">
//!         <Section Name="Input">
//!           <Member Name="GAIN" Datatype="Real"><StartValue>2.0</StartValue></Member>
//! ```
//!
//! A member without a start value has the block's start value. The version in the namespace is ignored. Files written
//! by this module have never been imported into TIA Portal.

use crate::block::BlockType;
use crate::literal;
use crate::loops::Loop;
use crate::named;
use crate::problem::quoted;
use crate::report::{MOST_LOOPS, Report, elements, list};
use crate::xml::{self, Element, Xml};
use crate::{Options, Problems, Reading, Source};
use blocks::{Kind, Row};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The prefixes of block elements. A controller is a technology object in TIA Portal.
const BLOCKS: [&str; 2] = ["SW.Blocks.", "SW.TechnologicalObjects."];

/// The namespace of the version written.
const NAMESPACE: &str = "http://www.siemens.com/automation/Openness/SW/Interface/v5";

/// Reads the instances in an exported document: instance data blocks, and the instances inside other data blocks, which
/// are named after their member.
///
/// # Errors
/// The document is not an Openness export, or an instance has a member, type or value that does not match its block.
pub fn read(source: &Source, blocks: &[Arc<BlockType>], options: &Options) -> Result<Reading, Problems> {
    let mut report = Report::new(source, options);
    let loops = loops(&mut report, source, blocks, options).unwrap_or_default();
    report.finish(loops)
}

fn loops(report: &mut Report, source: &Source, blocks: &[Arc<BlockType>], options: &Options) -> Option<Vec<Loop>> {
    let chosen = report.chosen(blocks, options).ok()?;
    let document = xml::read(report, source)?;
    let root = document.root();
    let is_block = |child: &Element| BLOCKS.iter().any(|begin| child.name().starts_with(begin));
    let mut exported = root.elements().filter(is_block).peekable();
    if root.name() != "Document" || exported.peek().is_none() {
        let message = "expected a TIA Portal Openness Document with an SW.Blocks.InstanceDB or a technology object";
        if root.name() == "Document" {
            report.wrong_file(format!("{message}, found none"), None);
        } else {
            report.wrong(root.span(), format!("{message}, found {}", quoted(root.name())), None);
        }
        return None;
    }
    let mut loops = Vec::new();
    let mut names = BTreeSet::new();
    let mut containers: Vec<String> = Vec::new();
    for block in exported {
        let text = |name: &str| block.child("AttributeList")?.child(name).map(|child| child.text().0.to_string());
        let number = text("Number").filter(|number| !number.is_empty()).map(|number| format!("DB{number}"));
        let name = text("Name").filter(|name| !name.is_empty()).or(number);
        let name = name.unwrap_or_else(|| report.loop_name(options));
        let is_known = |of: &String| blocks.iter().any(|block| block.is_called(of));
        // The type of a technology object is an element of the system library.
        let of_library = text("OfSystemLibElement").filter(is_known);
        let of = text("InstanceOfName").filter(|of| of_library.is_none() || is_known(of)).or(of_library);
        let of = of.unwrap_or_default();
        let Some(interface) = block.child("AttributeList").and_then(|list| list.child("Interface")) else {
            report.remark(Some(block.span()), format!("{} has no interface: skipped", quoted(&name)));
            continue;
        };
        if !block.name().ends_with("DB") {
            report.remark(Some(block.span()), format!("{} is not a data block: skipped", quoted(&name)));
            continue;
        }
        let before = loops.len();
        if !names.insert(name.clone()) {
            report.wrong(
                block.span(),
                format!("the data block {} appears twice: remove or rename one", quoted(&name)),
                None,
            );
            continue;
        }
        let types = Types { blocks, chosen: chosen.as_ref() };
        types.instances(report, interface, &Place { name: name.clone(), index: String::new() }, &of, &mut loops);
        // The name of the data block, for the instances inside it.
        containers.resize(loops.len(), name.clone());
        if loops.len() == before && !report.is_wrong() {
            let of = if of.is_empty() { String::new() } else { format!(" ({})", quoted(&of)) };
            let message = format!("{}{of} is not an instance of a known block: skipped", quoted(&name));
            report.remark(Some(block.span()), message);
        }
        if loops.len() > MOST_LOOPS {
            report.wrong(block.span(), format!("the file has more than {MOST_LOOPS} loops; split it"), None);
            break;
        }
    }
    if loops.is_empty() && !report.is_wrong() {
        report.wrong_file(
            "the file contains no instance of a known block",
            Some(format!("known blocks: {}", list(blocks)).into()),
        );
    }
    tell_apart(&mut loops, &containers);
    Some(loops)
}

/// Adds the name of the data block to the names of loops that would otherwise be equal: `Line.TIC`.
fn tell_apart(loops: &mut [Loop], containers: &[String]) {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for one in loops.iter() {
        *counts.entry(one.name.clone()).or_default() += 1;
    }
    for (one, container) in loops.iter_mut().zip(containers) {
        if counts[&one.name] > 1 && one.name != *container {
            one.name = format!("{container}.{}", one.name);
        }
    }
}

/// The known blocks, and the one chosen by the user for instances of unknown types.
struct Types<'a> {
    blocks: &'a [Arc<BlockType>],
    chosen: Option<&'a Arc<BlockType>>,
}

impl Types<'_> {
    /// Collects the instance whose sections are children of `parent`, or else the instances among its members.
    fn instances(&self, report: &mut Report, parent: Element, at: &Place, of: &str, loops: &mut Vec<Loop>) {
        let Some(sections) = parent.child("Sections") else { return };
        if let Some(block) = self.named(of).or_else(|| self.by_members(sections)) {
            loops.extend(instance(report, &block, at, sections));
            return;
        }
        for member in sections.children("Section").flat_map(|section| section.children("Member")) {
            let (name, of) =
                (member.attribute("Name").unwrap_or_default(), member.attribute("Datatype").unwrap_or_default());
            let (of, elements) = match array(of) {
                Some((elements, of)) => (of, elements),
                None => (of, vec![String::new()]),
            };
            for element in elements {
                if loops.len() > MOST_LOOPS {
                    return;
                }
                let own = element.trim_matches(['[', ']']);
                let index = if at.index.is_empty() || own.is_empty() { "" } else { "," };
                let place = Place { name: format!("{name}{element}"), index: format!("{}{index}{own}", at.index) };
                self.instances(report, member, &place, of, loops);
            }
        }
    }

    fn named(&self, of: &str) -> Option<Arc<BlockType>> {
        self.blocks.iter().find(|block| block.is_called(of)).cloned()
    }

    /// The block of an instance with an unknown type, for example after a migration: all inputs and parameters are
    /// present with their types, and there is no other input.
    fn by_members(&self, sections: Element) -> Option<Arc<BlockType>> {
        let inputs: Vec<(&str, &str)> = inputs(sections)
            .map(|member| {
                (member.attribute("Name").unwrap_or_default(), member.attribute("Datatype").unwrap_or_default())
            })
            .collect();
        let fits = |block: &&Arc<BlockType>| {
            let settable: Vec<&Row> =
                block.members.iter().filter(|member| member.role.is_settable() && !member.is_inner()).collect();
            let has = |member: &&Row| {
                inputs
                    .iter()
                    .any(|(name, datatype)| member.name.eq_ignore_ascii_case(name) && is_kind(datatype, member.kind))
            };
            !settable.is_empty() && inputs.len() == settable.len() && settable.iter().all(has)
        };
        if let Some(block) = self.chosen {
            // The user's choice applies if the instance has any of its members.
            let has_any = inputs.iter().any(|(name, _)| named::is_settable(block, name));
            return has_any.then(|| block.clone());
        }
        self.blocks.iter().find(fits).cloned()
    }
}

/// The position of an instance.
struct Place {
    /// Its name.
    name: String,
    /// The indices in the arrays around it, outermost first: `2` or `2,0`.
    index: String,
}

/// The indices of an array's elements, and the element type: `Array[1..3] of "PUMP"`.
fn array(datatype: &str) -> Option<(Vec<String>, &str)> {
    let rest =
        datatype.get(..5).filter(|word| word.eq_ignore_ascii_case("array")).map(|word| &datatype[word.len()..])?;
    let (bounds, of) = rest.trim_start().strip_prefix('[')?.split_once(']')?;
    let of = of.trim_start().get(2..)?.trim().trim_matches('"');
    Some((elements(bounds)?, of))
}

/// The start value of a member or, in an array, of the element with this index.
fn start_value<'a>(member: Element<'a>, index: &str) -> Option<Element<'a>> {
    let is_own = |element: &Element| element.attribute("Path") == Some(index);
    let own = member.children("Subelement").find(is_own).and_then(|element| element.child("StartValue"));
    own.or_else(|| member.child("StartValue"))
}

/// The members of the input sections.
fn inputs(sections: Element<'_>) -> impl Iterator<Item = Element<'_>> {
    let is_input = |section: &Element| matches!(section.attribute("Name"), Some("Input" | "InOut"));
    sections.children("Section").filter(is_input).flat_map(|section| section.children("Member"))
}

/// Reads the loop of one instance; `None` if it has an error, which is reported.
fn instance(report: &mut Report, block: &Arc<BlockType>, at: &Place, sections: Element) -> Option<Loop> {
    let mut one = Loop::new(&at.name, block.clone());
    let mut given = vec![false; block.members.len()];
    let mut is_right = true;
    for element in inputs(sections) {
        let member_name = element.attribute("Name").unwrap_or_default();
        let index = match named::member(block, member_name) {
            Ok(index) => index,
            Err((message, help)) => {
                report.wrong(element.span(), message, help);
                is_right = false;
                continue;
            }
        };
        let member = &block.members[index];
        let datatype = element.attribute("Datatype").unwrap_or_default();
        if !is_kind(datatype, member.kind) {
            let message = format!(
                "{} of {}: expected the type {}, found {}",
                member.name,
                block.name,
                member.kind.name(),
                quoted(datatype)
            );
            report.wrong(element.span(), message, None);
            is_right = false;
            continue;
        }
        if std::mem::replace(&mut given[index], true) {
            report.wrong(element.span(), format!("{} appears twice: remove one", member.name), None);
            is_right = false;
            continue;
        }
        let Some((text, span)) =
            start_value(element, &at.index).map(Element::text).filter(|(text, _)| !text.is_empty())
        else {
            continue;
        };
        match literal::parse(text, member.kind) {
            Ok(value) => {
                let origin = report.origin(span);
                one.set(index, value, origin);
            }
            Err(message) => {
                report.wrong(span, format!("{}: {message}", member.name), None);
                is_right = false;
            }
        }
    }
    is_right.then_some(one)
}

fn is_kind(datatype: &str, kind: Kind) -> bool {
    datatype.eq_ignore_ascii_case(kind.name())
}

/// Writes an instance data block for each loop, with all inputs and parameters and without a number, which TIA Portal
/// assigns.
///
/// # Errors
/// A block contains other blocks, two loops have the same name, or a name cannot be represented in XML.
pub fn write(loops: &[Loop], origin: &str) -> Result<String, String> {
    named::check_names(loops)?;
    for one in loops {
        xml::check(&one.name)?;
        if let Some(inner) = one.block.members.iter().find(|member| member.is_inner()) {
            return Err(format!(
                "{} contains other blocks ({}), which cannot be written as Openness XML: use JSON or SSV",
                one.block.name, inner.name
            ));
        }
    }
    xml::check(origin)?;
    Ok(xml::document(|xml| {
        xml.comment(origin);
        xml.element("Document", &[], |xml| {
            for (number, one) in loops.iter().enumerate() {
                xml.element("SW.Blocks.InstanceDB", &[("ID", &format!("{number:X}"))], |xml| {
                    xml.element("AttributeList", &[], |xml| attributes(xml, one));
                });
            }
        });
    }))
}

fn attributes(xml: &mut Xml, one: &Loop) {
    xml.text("InstanceOfName", &one.block.name);
    xml.text("InstanceOfType", "FB");
    xml.element("Interface", &[], |xml| {
        xml.element("Sections", &[("xmlns", NAMESPACE)], |xml| {
            xml.element("Section", &[("Name", "Input")], |xml| {
                for setting in &one.settings {
                    let member = &one.block.members[setting.member];
                    let attributes = [("Name", member.name.as_str()), ("Datatype", member.kind.tia_name())];
                    xml.element("Member", &attributes, |xml| xml.text("StartValue", &literal::text(setting.value)));
                }
            });
            xml.element("Section", &[("Name", "Output")], |xml| {
                let all = one.block.members.iter().enumerate();
                for (_, member) in all.filter(|(index, of)| one.block.is_own(*index) && !of.role.is_settable()) {
                    xml.empty("Member", &[("Name", &member.name), ("Datatype", member.kind.tia_name())]);
                }
            });
        });
    });
    xml.text("MemoryLayout", "Standard");
    xml.text("Name", &one.name);
    xml.text("ProgrammingLanguage", "DB");
}
