//! Reads the parts of declarations that exist in documents but not in SCL.

use super::Texts;
use crate::front::lexer::Kind;
use crate::front::parser::{Failed, Parsed, Parser};
use crate::front::syntax::{Attribute, Member, SourceBlock, Statement, StatementKind, attribute};

/// The attributes that control a member's visibility, each with the word that hides the member and the SCL attribute
/// that is set to False instead.
const HIDING: [(&str, &str, &str); 2] =
    [("S7_VISIBILITY", "Hidden", "EXTERNALVISIBLE"), ("S7_ACCESS", "NoAccess", "EXTERNALACCESSIBLE")];

impl Parser<'_> {
    /// Consumes `_.`, the prefix of global names: blocks, types and tags.
    pub(crate) fn takes_global(&mut self) -> bool {
        let is_global = self.document.is_some() && self.is_word("_") && self.symbol_ahead(1) == ".";
        if is_global {
            self.step();
            self.step();
        }
        is_global
    }

    /// Reads the attributes and comment of a block. They precede its first word, which is at byte offset `to`.
    pub(crate) fn document_head(&self, block: &mut SourceBlock, texts: &Texts, from: u32, to: u32) {
        block.attributes = self.attributes_within(from, to);
        block.comment = shown(&block.attributes, texts, &["S7_BLOCKTITLE", "S7_BLOCKCOMMENT"]);
    }

    /// Reads the attributes and comment of a member. They precede its name, which is at byte offset `to`.
    pub(crate) fn document_member(&self, member: &mut Member, texts: &Texts, from: u32, to: u32) {
        member.attributes.splice(..0, self.attributes_within(from, to));
        for (name, word, hiding) in HIDING {
            if attribute(&member.attributes, name).is_some_and(|value| value.contains(word)) {
                member.attributes.push(Attribute { key: hiding.to_string(), value: "False".to_string() });
            }
        }
        let comment = shown(&member.attributes, texts, &["S7_MLC"]);
        if !comment.is_empty() {
            member.comment = comment;
        }
    }

    /// Parses start values such as `a.b[1] := 5;` in a data block. `a[1] := ();` is only a placeholder for a comment.
    pub(crate) fn document_starts(&mut self) -> Vec<Statement> {
        let mut statements = Vec::new();
        while !self.is_end() && !self.is_statement_end() && !self.is_exhausted() {
            if self.takes(";") {
                continue;
            }
            let before = self.at;
            match self.document_start() {
                Ok(statement) => statements.extend(statement),
                Err(Failed) => {
                    while !self.is_end() && !self.is_statement_end() && !self.takes(";") {
                        self.step();
                    }
                }
            }
            if self.at == before {
                self.step();
            }
        }
        statements
    }

    fn document_start(&mut self) -> Parsed<Option<Statement>> {
        let start = self.span();
        if !matches!(self.token().kind, Kind::Word | Kind::Quoted | Kind::Local) && !self.is_symbol("[") {
            return self.fail("a start value such as a := 1;");
        }
        let target = self.expression()?;
        self.expect(":=")?;
        if self.is_symbol("(") && self.symbol_ahead(1) == ")" {
            self.step();
            self.step();
            return Ok(None);
        }
        let value = self.expression()?;
        if !self.is_statement_end() {
            self.expect(";")?;
        }
        let kind = StatementKind::Assign(vec![(target, None)], value);
        Ok(Some(Statement { kind, span: start.to(self.before()) }))
    }
}

/// The texts to which the attributes with these keys refer, one per line.
pub(super) fn shown(attributes: &[Attribute], texts: &Texts, keys: &[&str]) -> String {
    let of_key = |key: &&str| attribute(attributes, key).map(|id| texts.shown(id).to_string());
    keys.iter().filter_map(of_key).filter(|text| !text.is_empty()).collect::<Vec<_>>().join("\n")
}
