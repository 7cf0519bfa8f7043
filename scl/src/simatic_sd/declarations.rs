//! What the declarations of documents have that those of SCL have not.

use super::Texts;
use crate::lexer::Kind;
use crate::parser::{Failed, Parsed, Parser};
use crate::syntax::{Attribute, Block, Member, Statement, StatementKind, attribute};

/// The attributes of members by which others see them, the word that hides the member, and what SCL writes for it.
const HIDING: [(&str, &str, &str); 2] =
    [("S7_VISIBILITY", "Hidden", "EXTERNALVISIBLE"), ("S7_ACCESS", "NoAccess", "EXTERNALACCESSIBLE")];

impl Parser<'_> {
    /// Takes `_.`, which stands before the name of a block, a type or a tag.
    pub fn takes_global(&mut self) -> bool {
        let is_global = self.document.is_some() && self.is_word("_") && self.symbol_ahead(1) == ".";
        if is_global {
            self.step();
            self.step();
        }
        is_global
    }

    /// Attributes and comment of a block, which stand before its first word, at byte `to`.
    pub fn document_head(&self, block: &mut Block, texts: &Texts, from: u32, to: u32) {
        block.attributes = self.attributes_within(from, to);
        block.comment = shown(&block.attributes, texts, &["S7_BLOCKTITLE", "S7_BLOCKCOMMENT"]);
    }

    /// Attributes and comment of a member, which stand before its name, at byte `to`.
    pub fn document_member(&self, member: &mut Member, texts: &Texts, from: u32, to: u32) {
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

    /// `a.b[1] := 5;` of a data block. `a[1] := ();` holds the place for a comment.
    pub fn document_starts(&mut self) -> Vec<Statement> {
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

/// The texts of attributes, a paragraph each.
pub fn shown(attributes: &[Attribute], texts: &Texts, keys: &[&str]) -> String {
    let of_key = |key: &&str| attribute(attributes, key).map(|id| texts.shown(id).to_string());
    keys.iter().filter_map(of_key).filter(|text| !text.is_empty()).collect::<Vec<_>>().join("\n")
}
