//! Reads SimaticML, the export format of TIA Portal Openness. Blocks in LAD, FBD and SCL, data blocks and types become
//! the same tree as SCL sources. Networks in STL and GRAPH are rejected; the error names the language.

mod interface;
mod network;
mod text;

use crate::front::lexer::Span;
use crate::front::parser::Fragments;
use crate::front::syntax::{Attribute, BlockKind, EVENT, Name, SourceBlock, Tree, Type, TypeKind};
use crate::ladder::Owner;
use crate::report::Report;
use parameters::problem::quoted;
use parameters::xml::{self, Element};
use text::Written;

/// Whether a source is XML.
pub(super) fn is_it(text: &str) -> bool {
    text.trim_start_matches('\u{feff}').trim_start().starts_with('<')
}

pub(super) fn parse(text: &str, file: u32, report: &mut Report) -> Tree {
    let document = match xml::tree(text) {
        Ok(document) => document,
        Err((at, message)) => {
            report.error(Span { file, start: at as u32, end: at as u32 }, message, Some("export the block again"));
            return Tree::default();
        }
    };
    let mut reader =
        Reader { file, tree: Tree { is_tia: true, ..Tree::default() }, report, written: Written::new(text.len()) };
    reader.document(document.root());
    reader.tree
}

struct Reader<'a> {
    file: u32,
    tree: Tree,
    report: &'a mut Report,
    written: Written,
}

impl Reader<'_> {
    fn span(&self, element: Element) -> Span {
        Span { file: self.file, start: element.span().start as u32, end: element.span().end as u32 }
    }

    /// The span from an element's start tag to the end of its last descendant.
    fn extent(&self, element: Element) -> Span {
        let mut last = element;
        let mut end = element.text().1.end.max(element.span().end);
        while let Some(child) = last.elements().last() {
            end = end.max(child.text().1.end).max(child.span().end);
            last = child;
        }
        Span { end: end as u32, ..self.span(element) }
    }

    fn fragments(&mut self) -> Fragments<'_> {
        Fragments { text: self.written.text(), file: self.file, tree: &mut self.tree, report: self.report }
    }

    fn document(&mut self, root: Element) {
        if root.name() != "Document" {
            let message =
                format!("the root element is {}, not Document: this is not a block export", quoted(root.name()));
            self.report.error(self.span(root), message, Some("export the block with Openness, or generate its source"));
            return;
        }
        for element in root.elements() {
            match element.name() {
                "SW.Blocks.FB" => self.block(element, BlockKind::FunctionBlock),
                "SW.Blocks.FC" => self.block(element, BlockKind::Function),
                "SW.Blocks.OB" => self.block(element, BlockKind::OrganizationBlock),
                "SW.Blocks.GlobalDB" | "SW.Blocks.InstanceDB" | "SW.Blocks.ArrayDB" => {
                    self.block(element, BlockKind::DataBlock);
                }
                "SW.Types.PlcStruct" => self.block(element, BlockKind::Type),
                name if name.starts_with("SW.") => {
                    let message = format!("{name} is skipped: it is not a block, data block or type");
                    self.report.warning(self.span(element), message, None);
                }
                _ => {}
            }
        }
    }

    /// The value of a block's attribute and its location; `None` if it is missing or empty.
    fn attribute<'e>(&self, block: Element<'e>, name: &str) -> Option<(&'e str, Span)> {
        let (text, range) = block.child("AttributeList")?.child(name)?.text();
        (!text.is_empty()).then(|| {
            let span = Span { file: self.file, start: range.start as u32, end: range.end as u32 };
            (text, span)
        })
    }

    fn block(&mut self, element: Element, kind: BlockKind) {
        let Some((name, span)) = self.attribute(element, "Name") else {
            self.report.error(self.span(element), "this block has no Name", Some("export it again"));
            return;
        };
        let name = Name { text: name.to_string(), span };
        let mut block = SourceBlock { comment: block_comment(element), ..SourceBlock::new(kind, name) };
        let extent = self.extent(element);
        self.report.locate(extent, block.title());
        if self.attribute(element, "MemoryLayout").is_some_and(|(layout, _)| layout == "Standard") {
            block.attributes.push(Attribute { key: "S7_OPTIMIZED_ACCESS".to_string(), value: "FALSE".to_string() });
        }
        if let Some((kind, _)) = self.attribute(element, "SecondaryType") {
            block.attributes.push(Attribute { key: EVENT.to_string(), value: kind.to_string() });
        }
        if let Some((of, span)) = self.attribute(element, "InstanceOfName") {
            // Instances of system blocks are written without quotation marks.
            let is_own = self.attribute(element, "InstanceOfType").is_none_or(|(of, _)| of != "SFB");
            let is_system = crate::library::is_system(of);
            let kind = TypeKind::Name { name: of.to_string(), is_quoted: is_own && !is_system };
            block.of = Some(Type { kind, span });
        }
        if let Some(Type { kind: TypeKind::Name { name: of, is_quoted: true }, span }) = &block.of {
            self.instantiated(element, extent, Name { text: of.clone(), span: *span });
        }
        self.interface(element, &mut block);
        let owner = Owner::new(&block);
        let statements = self.networks(element, &owner);
        block.body.extend(statements);
        self.tree.extents.push(extent);
        self.tree.blocks.push(block);
    }

    /// Adds the function block of an instance, with the interface that the instance's data block repeats.
    fn instantiated(&mut self, element: Element, extent: Span, name: Name) {
        let span = name.span;
        let mut block = SourceBlock::new(BlockKind::FunctionBlock, name);
        self.interface(element, &mut block);
        if block.sections.is_empty() {
            return;
        }
        let number = self.tree.blocks.len();
        self.tree.protected.push((number, span));
        self.tree.instantiated.push(number);
        self.tree.extents.push(extent);
        self.tree.blocks.push(block);
    }
}

/// The title and comment of a block.
fn block_comment(element: Element) -> String {
    let texts = ["Title", "Comment"].map(|name| multilingual(element, name));
    texts.iter().filter(|text| !text.is_empty()).map(String::as_str).collect::<Vec<_>>().join("\n")
}

/// A multilingual text: English if available, else the first that is not empty.
fn multilingual(element: Element, name: &str) -> String {
    let Some(list) = element.child("ObjectList") else { return String::new() };
    let texts = list.children("MultilingualText").filter(|text| text.attribute("CompositionName") == Some(name));
    let items =
        texts.filter_map(|text| text.child("ObjectList")).flat_map(|list| list.children("MultilingualTextItem"));
    let texts = items.filter_map(|item| item.child("AttributeList")).filter_map(|list| {
        let culture = list.child("Culture").map_or("", |culture| culture.text().0);
        let text = list.child("Text").map_or("", |text| text.text().0);
        (!text.is_empty()).then_some((culture, text))
    });
    shown(texts)
}

/// Selects the text to show from translations, each with its language.
fn shown<'e>(texts: impl Iterator<Item = (&'e str, &'e str)>) -> String {
    let all: Vec<(&str, &str)> = texts.collect();
    let english = all.iter().find(|(culture, _)| culture.to_ascii_lowercase().starts_with("en"));
    english.or(all.first()).map(|(_, text)| text.replace('\r', "")).unwrap_or_default()
}
