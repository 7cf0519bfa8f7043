//! Reads the networks of a block.

use super::declarations::shown;
use super::graph::Variables;
use crate::front::lexer::Span;
use crate::front::parser::{Failed, Parsed, Parser};
use crate::front::syntax::{Attribute, SourceBlock, Statement, TypeKind, attribute, key};
use crate::ladder::{Network, Owner, comments, lint, lower, network_title};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Language {
    Scl,
    /// LAD or FBD, which have the same notation.
    Graph,
}

impl Parser<'_> {
    pub(crate) fn networks(&mut self, block: &SourceBlock) -> Vec<Statement> {
        let (owner, variables) = (Owner::new(block), variables(block));
        let mut statements = Vec::new();
        let mut graphs = Vec::new();
        let mut number = 0;
        while !self.is_exhausted() {
            let from = self.end_before();
            if !self.is_word("NETWORK") {
                break;
            }
            number += 1;
            let begin = self.step().span;
            let attributes = self.attributes_within(from, begin.start);
            let mut network = Network::new(number, begin);
            if let Some(texts) = self.document {
                network.title = shown(&attributes, texts, &["S7_NETWORKTITLE"]);
                network.comment = shown(&attributes, texts, &["S7_NETWORKCOMMENT"]);
            }
            let place = network_title(&owner, &network);
            let language = self.language(block, &attributes, begin);
            let read = language.map(|language| match language {
                Language::Scl => {
                    statements.extend(comments(&network));
                    statements.extend(self.statements(false));
                }
                Language::Graph => {
                    let before = self.report.errors();
                    let written = self.rungs();
                    // If part of a network cannot be read, there is little point in checking the rest.
                    if self.report.errors() == before {
                        let mut network = self.graph(written, network, &variables);
                        statements.extend(lower(&mut network, &owner, &mut self.tree, self.report));
                        graphs.push(network);
                    }
                }
            });
            if let Err(Failed) = read.and_then(|()| self.close("END_NETWORK", begin)) {
                while !self.is_end() && !self.is_word("END_NETWORK") && !self.is_word("NETWORK") {
                    self.step();
                }
                self.takes_word("END_NETWORK");
            }
            self.takes(";");
            self.report.locate(begin.to(self.before()), place);
        }
        lint(&graphs, &owner, &self.tree.expressions, self.report);
        let number = self.tree.blocks.len();
        self.tree.networks.extend(graphs.into_iter().map(|network| (number, network)));
        statements
    }

    /// The language of a network, once its keyword has been read: as declared for the network or block, otherwise as
    /// implied by the next word.
    fn language(&mut self, block: &SourceBlock, attributes: &[Attribute], begin: Span) -> Parsed<Language> {
        let of_block = || {
            let keys = ["S7_PREFERREDLANGUAGE", "S7_LANGUAGE", "S7_EDITORMODE"];
            keys.iter().find_map(|key| attribute(&block.attributes, key))
        };
        let is_graph = matches!(self.word_ahead(0).as_str(), "RUNG" | "LABEL");
        match attribute(attributes, "S7_LANGUAGE").or_else(of_block) {
            Some(name) if name.eq_ignore_ascii_case("SCL") => Ok(Language::Scl),
            Some(name) if matches!(name.to_ascii_uppercase().as_str(), "LAD" | "FBD" | "F_LAD" | "F_FBD") => {
                Ok(Language::Graph)
            }
            None if is_graph => Ok(Language::Graph),
            None => Ok(Language::Scl),
            Some(name) => {
                let message = format!("networks in {name} are not supported");
                self.refuse(begin, &message, Some("rewrite the network in LAD, FBD or SCL, or leave the file out"))
            }
        }
    }
}

/// The variables of a block and their type names; the type name is empty for arrays, strings and structures.
fn variables(block: &SourceBlock) -> Variables {
    let members = block.sections.iter().flat_map(|section| &section.members);
    let named = members.flat_map(|member| {
        let of = match member.of.as_ref().map(|of| &of.kind) {
            Some(TypeKind::Name { name, .. }) => key(name),
            _ => String::new(),
        };
        member.names.iter().map(move |name| (name.key(), of.clone()))
    });
    named.collect()
}
