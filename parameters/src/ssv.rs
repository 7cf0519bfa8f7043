//! Parameter sets of SSP (System Structure and Parameterization), which any SSP host can apply to FMUs.
//!
//! ```xml
//! <ssv:ParameterSet version="1.0" name="TIC101" xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
//!   <ssv:Parameters>
//!     <ssv:Parameter name="GAIN">
//!       <ssv:Real value="2.0"/>
//!     </ssv:Parameter>
//!   </ssv:Parameters>
//! </ssv:ParameterSet>
//! ```
//!
//! A set with one loop uses the names of the FMU; in a set of several, they are prefixed with the loop: `TIC101.GAIN`.
//! A TIME is in seconds. The file does not state the block of a loop, which is identified by its names.

use crate::block::BlockType;
use crate::loops::{Loop, MemberValue};
use crate::named::{self, Choice, Entry, Given};
use crate::problem::quoted;
use crate::report::{MOST_LOOPS, Report};
use crate::value;
use crate::xml::{self, Element, Xml};
use crate::{Options, Problems, Reading, Source};
use blocks::Class;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The namespace of SSP 1.0 and of all later versions.
const NAMESPACE: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";

/// Reads the loops of a parameter set.
///
/// # Errors
/// The file is malformed, or the block of a loop is ambiguous; [`Options::block`] resolves that.
pub fn read(source: &Source, blocks: &[Arc<BlockType>], options: &Options) -> Result<Reading, Problems> {
    let mut report = Report::new(source, options);
    let loops = loops(&mut report, source, blocks, options).unwrap_or_default();
    report.finish(loops)
}

fn loops(report: &mut Report, source: &Source, blocks: &[Arc<BlockType>], options: &Options) -> Option<Vec<Loop>> {
    let chosen = report.chosen(blocks, options).ok()?;
    let document = xml::read(report, source)?;
    let root = document.root();
    if root.name() != "ParameterSet" {
        let message = format!("expected the root element ParameterSet, found {}", quoted(root.name()));
        report.wrong(root.span(), message, None);
        return None;
    }
    let version = root.attribute("version").unwrap_or_default();
    if !matches!(version, "1.0" | "2.0") {
        let message = format!("expected a ParameterSet of version 1.0 or 2.0, found {}", quoted(version));
        report.wrong(root.span(), message, None);
        return None;
    }

    let mut named = Vec::new();
    for parameter in root.children("Parameters").flat_map(|parameters| parameters.children("Parameter")) {
        match parameter.attribute("name").filter(|name| !name.is_empty()) {
            Some(name) => named.push((name, parameter)),
            None => report.wrong(parameter.span(), "this Parameter has no name: add one", None),
        }
    }
    let is_listed = is_listed(blocks, named.iter().map(|(name, _)| *name));
    let mut order = Vec::new();
    let mut groups: BTreeMap<&str, Vec<Entry>> = BTreeMap::new();
    for (name, parameter) in named {
        let own = if is_listed { last(name) } else { member_name(blocks, name) };
        let Some(entry) = entry(report, blocks, parameter, own) else { continue };
        let group = name[..name.len() - own.len()].trim_end_matches('.');
        groups.entry(group).or_insert_with(|| {
            order.push((group, parameter.span()));
            Vec::new()
        });
        groups.entry(group).or_default().push(entry);
    }
    if order.len() > MOST_LOOPS {
        report.wrong(root.span(), format!("the file has more than {MOST_LOOPS} loops; split it"), None);
        return None;
    }
    let choice = Choice { block: chosen.as_ref(), is_for_one: order.len() == 1 };
    let mut loops = Vec::new();
    for (group, span) in order {
        let own = options.name.clone().or_else(|| root.attribute("name").map(str::to_string));
        let name = match group {
            "" => own.unwrap_or_else(|| report.loop_name(options)),
            prefix => prefix.to_string(),
        };
        let Some(entries) = groups.get(group) else { continue };
        loops.extend(named::read(report, blocks, choice, &name, span, entries));
    }
    Some(loops)
}

/// The entry for a Parameter; `name` is its name without that of the loop. `None` if it has an error, which is
/// reported.
fn entry<'a>(
    report: &mut Report,
    blocks: &[Arc<BlockType>],
    parameter: Element<'a>,
    name: &'a str,
) -> Option<Entry<'a>> {
    let types = ["Real", "Integer", "Boolean", "Enumeration", "String", "Binary", "Float64", "Float32"];
    let Some(value) = parameter.elements().find(|child| types.contains(&child.name())) else {
        let message = format!("{}: expected a Real, an Integer or a Boolean, found none", quoted(name));
        report.wrong(parameter.span(), message, None);
        return None;
    };
    let text = value.attribute("value").unwrap_or_default();
    let given = match value.name() {
        "Real" | "Integer" | "Float64" | "Float32" => Given::Number(text),
        "Boolean" if matches!(text, "true" | "1") => Given::Bool(true),
        "Boolean" if matches!(text, "false" | "0") => Given::Bool(false),
        "Boolean" => Given::Other(text),
        _ => Given::Other(value.name()),
    };
    if let Some(unit) = value.attribute("unit") {
        let member = blocks.iter().find_map(|block| Some(&block.members[block.find(name)?]));
        let expected = member.and_then(|member| member.shown_unit());
        if let Some(expected) = expected.filter(|expected| *expected != unit) {
            let message = format!("{} is given in {}, but {expected} is expected", quoted(name), quoted(unit));
            report.wrong(value.span(), message, Some("convert the value: units are not converted here".into()));
            return None;
        }
    }
    Some(Entry { name, name_span: parameter.span(), given, span: value.span() })
}

/// The maximum length, in bytes, of a name that is searched for member names.
const LONGEST: usize = 1000;

/// The part after the last dot of a name.
fn last(full_name: &str) -> &str {
    full_name.rsplit('.').next().unwrap_or(full_name)
}

/// Whether the names form complete blocks if everything before the last dot is taken as the loop. In that case they are
/// read this way, because a loop may have the name of an instance inside another block.
fn is_listed<'a>(blocks: &[Arc<BlockType>], names: impl Iterator<Item = &'a str>) -> bool {
    let mut groups: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for name in names {
        let own = last(name);
        groups.entry(&name[..name.len() - own.len()]).or_default().push(own);
    }
    groups.values().all(|names| blocks.iter().any(|block| named::is_complete(block, names)))
}

/// The part of a name that is an input or parameter of a block, the longest one if there are several:
/// `TIC101.INNER.GAIN` is `INNER.GAIN` of a loop `TIC101` if a block has that. If no block does, the part after the
/// last dot.
fn member_name<'a>(blocks: &[Arc<BlockType>], full_name: &'a str) -> &'a str {
    if full_name.len() > LONGEST {
        return last(full_name);
    }
    let starts = std::iter::once(0).chain(full_name.match_indices('.').map(|(dot, _)| dot + 1));
    let mut parts = starts.map(|start| &full_name[start..]);
    let known = |name: &&str| blocks.iter().any(|block| named::is_settable(block, name));
    parts.find(known).unwrap_or(last(full_name))
}

/// Writes all settings of the loops, each loop's in the order of its block. If there is only one loop, its settings
/// have the same names as in the FMU; if there are several, the loop's name is prefixed.
///
/// # Errors
/// A value is not finite, two loops have the same name, or a name cannot be represented in XML.
pub fn write(loops: &[Loop]) -> Result<String, String> {
    named::check_names(loops)?;
    let [first, rest @ ..] = loops else { return Err("no loop to write".into()) };
    let mut parameters = Vec::new();
    for one in loops {
        xml::check(&one.name)?;
        for setting in &one.settings {
            let member = &one.block.members[setting.member];
            let name = if rest.is_empty() { member.name.clone() } else { format!("{}.{}", one.name, member.name) };
            let value = value::text(setting.value).map_err(|value| {
                format!("{}: {} is {value}: SSV files hold only finite numbers", one.name, member.name)
            })?;
            parameters.push((name, element(setting), value));
        }
    }
    let name = if rest.is_empty() { &first.name } else { "parameters" };
    let attributes = [("version", "1.0"), ("name", name), ("xmlns:ssv", NAMESPACE)];
    Ok(xml::document(|xml| {
        xml.element("ssv:ParameterSet", &attributes, |xml| {
            xml.element("ssv:Parameters", &[], |xml| {
                for (name, element, value) in &parameters {
                    parameter(xml, name, element, value);
                }
            });
        });
    }))
}

fn parameter(xml: &mut Xml, name: &str, element: &str, value: &str) {
    xml.element("ssv:Parameter", &[("name", name)], |xml| xml.empty(element, &[("value", value)]));
}

/// The element for a value, according to its FMI type.
fn element(setting: &MemberValue) -> &'static str {
    match setting.value.kind().class() {
        Class::Real => "ssv:Real",
        Class::Integer => "ssv:Integer",
        Class::Boolean => "ssv:Boolean",
    }
}
