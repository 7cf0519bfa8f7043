//! Parses fragments of SCL inside other formats.

use super::{Parsed, Parser, parser_of};
use crate::front::lexer::Span;
use crate::front::syntax::{ExpressionId, ExpressionKind, Statement, Tree, Type, TypeKind};
use crate::report::Report;
use std::ops::Range;

/// Parses fragments of a text. Their spans are byte offsets in that text.
pub(crate) struct Fragments<'a> {
    /// The text. For other formats, it is blank except for the fragments, each written at its offset in the source.
    pub text: &'a str,
    /// The index of the source.
    pub file: u32,
    /// The tree that receives the fragments.
    pub tree: &'a mut Tree,
    /// The report of errors in the fragments.
    pub report: &'a mut Report,
}

impl Fragments<'_> {
    /// Parses an expression, such as a variable.
    pub(crate) fn expression(&mut self, range: Range<usize>) -> ExpressionId {
        let span = self.span(&range);
        let parsed = self.parse(range, |parser| parser.whole(Parser::expression));
        parsed.unwrap_or_else(|| self.tree.expressions.add(ExpressionKind::Wrong, span))
    }

    pub(crate) fn type_of(&mut self, range: Range<usize>) -> Type {
        let span = self.span(&range);
        let parsed = self.parse(range, |parser| parser.whole(Parser::type_of));
        parsed.unwrap_or(Type { kind: TypeKind::Wrong, span })
    }

    pub(crate) fn statements(&mut self, range: Range<usize>) -> Vec<Statement> {
        let statements = self.parse(range, |parser| {
            parser.gotos = parser.jumps("");
            let mut all = parser.statements(false);
            while !parser.is_end() && !parser.is_exhausted() {
                let _: Parsed<()> = parser.fail("a statement");
                parser.step();
                all.extend(parser.statements(false));
            }
            Ok(all)
        });
        statements.unwrap_or_default()
    }

    fn span(&self, range: &Range<usize>) -> Span {
        Span { file: self.file, start: range.start as u32, end: range.end as u32 }
    }

    fn parse<T>(&mut self, range: Range<usize>, read: impl FnOnce(&mut Parser) -> Parsed<T>) -> Option<T> {
        let text = self.text.get(..range.end)?;
        let tree = std::mem::take(self.tree);
        let mut parser = parser_of(text, range.start, self.file, tree, self.report);
        let parsed = read(&mut parser);
        *self.tree = parser.tree;
        parsed.ok()
    }
}

impl Parser<'_> {
    /// Parses the expression in a part of the text, such as an attribute's value.
    pub(crate) fn expression_in(&mut self, range: Range<usize>) -> ExpressionId {
        let mut tree = std::mem::take(&mut self.tree);
        let file = self.span().file;
        let id = Fragments { text: self.text, file, tree: &mut tree, report: self.report }.expression(range);
        self.tree = tree;
        id
    }

    /// Parses with `read` and rejects anything that follows.
    fn whole<T>(&mut self, read: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        let read = read(self)?;
        if self.is_end() { Ok(read) } else { self.fail("the end") }
    }
}
