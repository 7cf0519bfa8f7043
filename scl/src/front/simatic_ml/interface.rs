//! Reads the sections and members of a block interface.

use super::{Reader, shown};
use crate::front::syntax::{
    Attribute, BlockKind, ExpressionId, ExpressionKind, Member, Name, PathStep, Scope, Section, SectionKind,
    SourceBlock, Start, Statement, StatementKind, Type, TypeKind,
};
use parameters::xml::Element;

/// The member attributes that are read, with their SCL names.
const ATTRIBUTES: [(&str, &str); 4] = [
    ("SetPoint", "S7_SETPOINT"),
    ("ExternalAccessible", "EXTERNALACCESSIBLE"),
    ("ExternalVisible", "EXTERNALVISIBLE"),
    ("ExternalWritable", "EXTERNALWRITABLE"),
];

impl Reader<'_> {
    /// Reads the interface of a block, data block or type; for an instance, only its start values.
    pub(super) fn interface(&mut self, element: Element, block: &mut SourceBlock) {
        let interface = element.child("AttributeList").and_then(|list| list.child("Interface"));
        let Some(sections) = interface.and_then(|interface| interface.child("Sections")) else {
            if block.kind != BlockKind::DataBlock {
                let message = format!("{} has no interface", block.name.text);
                self.report.error(self.span(element), message, Some("export it with its interface"));
            }
            return;
        };
        let is_instance = block.kind == BlockKind::DataBlock && element.name() == "SW.Blocks.InstanceDB";
        for section in sections.children("Section") {
            let name = section.attribute("Name").unwrap_or_default();
            let kind = match name {
                "Input" if block.kind == BlockKind::OrganizationBlock => SectionKind::Temp,
                "Input" => SectionKind::Input,
                "Output" => SectionKind::Output,
                "InOut" => SectionKind::InOut,
                "Static" | "None" => SectionKind::Static,
                "Temp" => SectionKind::Temp,
                "Constant" => SectionKind::Constant,
                "Return" => {
                    if let Some(value) = section.child("Member") {
                        block.of = self.type_of(value, false).filter(|of| !is_void(of));
                    }
                    continue;
                }
                _ => continue,
            };
            if is_instance {
                // The values exported with an instance of a system block are only a snapshot, not start values.
                if !is_system(block) {
                    self.starts_of_instance(section, block);
                }
                continue;
            }
            let mut kept: Vec<Member> = Vec::new();
            let mut retained: Vec<Member> = Vec::new();
            for element in section.children("Member") {
                let Some(member) = self.member(element, false) else { continue };
                let is_retained = element.attribute("Remanence") == Some("Retain");
                if is_retained { retained.push(member) } else { kept.push(member) }
            }
            // This may change the order of members, which matters only for absolute addresses in data blocks. Those
            // are rejected in SimaticML.
            for (members, is_retained) in [(kept, false), (retained, true)] {
                if !members.is_empty() {
                    block.sections.push(Section { kind, is_retained, members });
                }
            }
        }
    }

    /// Reads the start values of an instance from its data block.
    fn starts_of_instance(&mut self, section: Element, block: &mut SourceBlock) {
        for element in section.children("Member") {
            let mut parts = Vec::new();
            self.parts(element, &mut Vec::new(), &mut Vec::new(), &mut parts);
            let name = self.name(element);
            for (path, value) in parts {
                let span = name.span;
                let mut target = self.tree.expressions.add(ExpressionKind::Name(Scope::Bare, name.clone()), span);
                for part in path {
                    let kind = match part {
                        PathStep::Member(name) => ExpressionKind::Member(target, name),
                        PathStep::Element(indices) => {
                            let index = |index: i64| ExpressionKind::Literal(index.to_string());
                            let indices = indices.into_iter().map(|at| self.tree.expressions.add(index(at), span));
                            ExpressionKind::Index(target, indices.collect())
                        }
                    };
                    target = self.tree.expressions.add(kind, span);
                }
                block.body.push(Statement { kind: StatementKind::Assign(vec![(target, None)], value), span });
            }
        }
    }

    fn name(&self, element: Element) -> Name {
        Name { text: element.attribute("Name").unwrap_or_default().to_string(), span: self.span(element) }
    }

    /// Reads a member. If it is inside an array of structures, its values per element are read with the array instead.
    fn member(&mut self, element: Element, is_in_array: bool) -> Option<Member> {
        let name = self.name(element);
        if name.text.is_empty() {
            self.report.error(name.span, "a member has no name", Some("export the block again"));
            return None;
        }
        let of = self.type_of(element, is_in_array);
        let mut parts = Vec::new();
        if is_in_array {
            let value = element.child("StartValue").and_then(|value| self.start_value(value));
            parts.extend(value.map(|value| (Vec::new(), value)));
        } else {
            self.parts(element, &mut Vec::new(), &mut Vec::new(), &mut parts);
        }
        let start = match parts.as_slice() {
            [] => None,
            [(path, value)] if path.is_empty() => Some(Start::Value(*value)),
            _ => Some(Start::Parts(parts, name.span)),
        };
        Some(Member {
            names: vec![name],
            attributes: attributes(element),
            at: None,
            of,
            start,
            comment: comment(element),
        })
    }

    fn type_of(&mut self, element: Element, is_in_array: bool) -> Option<Type> {
        let written = element.attribute("Datatype").unwrap_or_default().to_string();
        let span = self.span(element);
        if written.is_empty() {
            let name = element.attribute("Name").unwrap_or_default();
            self.report.error(span, format!("the member {name} has no data type"), Some("export the block again"));
            return Some(Type { kind: TypeKind::Wrong, span });
        }
        let is_structure = |written: &str| written.trim().eq_ignore_ascii_case("Struct");
        if is_structure(&written) {
            return Some(self.structure(element, is_in_array));
        }
        let upper = written.to_ascii_uppercase();
        // `Array[0..3] of Struct`: the structure's members are children of this element.
        if upper.starts_with("ARRAY") && upper.trim_end().ends_with(" STRUCT") {
            let bounds = &written[..written.trim_end().len() - " Struct".len()];
            let range = self.fragment(element.span().start, &format!("{bounds} Bool"));
            let of = self.fragments().type_of(range);
            let TypeKind::Array(bounds, _) = of.kind else { return Some(of) };
            let structure = self.structure(element, true);
            return Some(Type { kind: TypeKind::Array(bounds, Box::new(structure)), span });
        }
        let range = self.fragment(element.span().start, &written);
        let mut of = self.fragments().type_of(range);
        of.span = span;
        Some(of)
    }

    fn structure(&mut self, element: Element, is_in_array: bool) -> Type {
        let members = element.children("Member").filter_map(|member| self.member(member, is_in_array)).collect();
        Type { kind: TypeKind::Struct(members), span: self.span(element) }
    }

    /// Collects the start values of a member and its descendants, each with its path. Members of a structure outside
    /// arrays are excluded; they are read with their own start values.
    fn parts(
        &mut self,
        element: Element,
        path: &mut Vec<PathStep>,
        arrays: &mut Vec<usize>,
        into: &mut Vec<(Vec<PathStep>, ExpressionId)>,
    ) {
        let written = element.attribute("Datatype").unwrap_or_default();
        let dimensions = dimensions(written);
        if arrays.is_empty()
            && let Some(value) = element.child("StartValue")
            && let Some(value) = self.start_value(value)
        {
            into.push((path.clone(), value));
        }
        if dimensions > 0 {
            arrays.push(path.len());
            path.push(PathStep::Element(vec![0; dimensions]));
        }
        for element in element.children("Subelement") {
            let Some(value) = element.child("StartValue") else { continue };
            let Some(filled) = element.attribute("Path").and_then(|indices| filled(path, arrays, indices)) else {
                let message = "the path of this start value is not a list of indices";
                self.report.error(self.span(element), message, Some("export the block again"));
                continue;
            };
            if let Some(value) = self.start_value(value) {
                into.push((filled, value));
            }
        }
        let is_structure = written.trim_end().to_ascii_uppercase().ends_with("STRUCT");
        let sections = element.children("Sections").flat_map(|sections| sections.children("Section"));
        let inner = sections.flat_map(|section| section.children("Member"));
        // The members of an array of structures specify their values per element.
        let own = element.children("Member").filter(|_| !is_structure || dimensions > 0);
        for member in inner.chain(own) {
            path.push(PathStep::Member(self.name(member)));
            self.parts(member, path, arrays, into);
            path.pop();
        }
        if dimensions > 0 {
            path.pop();
            arrays.pop();
        }
    }

    fn start_value(&mut self, value: Element) -> Option<ExpressionId> {
        let (text, range) = value.text();
        // The text may also be a symbolic constant: `"MAX"`.
        if text.is_empty() {
            return None;
        }
        let range = self.fragment(range.start.min(value.span().start), text);
        Some(self.fragments().expression(range))
    }
}

/// A path with the indices of its arrays replaced by the given ones; `None` if there are too few or too many.
fn filled(path: &[PathStep], arrays: &[usize], indices: &str) -> Option<Vec<PathStep>> {
    let indices: Option<Vec<i64>> = indices.split(',').map(|index| index.trim().parse().ok()).collect();
    let mut indices = indices?.into_iter();
    let mut filled = path.to_vec();
    for at in arrays {
        if let Some(PathStep::Element(own)) = filled.get_mut(*at) {
            for index in own {
                *index = indices.next()?;
            }
        }
    }
    indices.next().is_none().then_some(filled)
}

/// The number of dimensions of an array type; 0 for any other type.
fn dimensions(of: &str) -> usize {
    let of = of.trim_start();
    let is_array = of.get(..5).is_some_and(|word| word.eq_ignore_ascii_case("Array"));
    match of.find(']') {
        Some(end) if is_array => of[..end].matches(',').count() + 1,
        _ => 0,
    }
}

/// Whether a data block is an instance of a system block.
fn is_system(block: &SourceBlock) -> bool {
    matches!(&block.of, Some(Type { kind: TypeKind::Name { is_quoted: false, .. }, .. }))
}

fn is_void(of: &Type) -> bool {
    matches!(&of.kind, TypeKind::Name { name, .. } if name.eq_ignore_ascii_case("Void"))
}

fn attributes(element: Element) -> Vec<Attribute> {
    let Some(list) = element.child("AttributeList") else { return Vec::new() };
    let attributes = list.children("BooleanAttribute").filter_map(|attribute| {
        let name = attribute.attribute("Name")?;
        let (_, key) = ATTRIBUTES.iter().find(|(own, _)| *own == name)?;
        Some(Attribute { key: (*key).to_string(), value: attribute.text().0.to_string() })
    });
    attributes.collect()
}

fn comment(element: Element) -> String {
    let texts = element.children("Comment").flat_map(|comment| comment.children("MultiLanguageText"));
    shown(
        texts
            .map(|text| (text.attribute("Lang").unwrap_or_default(), text.text().0))
            .filter(|(_, text)| !text.is_empty()),
    )
}
