//! Parts of a text that are in SCL: what other formats write in its notation.

use super::{Parsed, Parser, parser_of};
use crate::lexer::Span;
use crate::report::Report;
use crate::syntax::{ExpressionId, ExpressionKind, Statement, Tree, Type, TypeKind};
use std::ops::Range;

/// Reads parts of a text; their spans are the bytes of the text.
pub struct Fragments<'a> {
    /// The text. A reader whose format is not SCL writes its fragments to the places in a text of blanks.
    pub text: &'a str,
    /// The number of the source.
    pub file: u32,
    /// The tree to which the fragments belong.
    pub tree: &'a mut Tree,
    /// What is wrong in them.
    pub report: &'a mut Report,
}

impl Fragments<'_> {
    /// An expression, a variable for example.
    pub fn expression(&mut self, range: Range<usize>) -> ExpressionId {
        let span = self.span(&range);
        let parsed = self.parse(range, |parser| parser.whole(Parser::expression));
        parsed.unwrap_or_else(|| self.tree.expressions.add(ExpressionKind::Wrong, span))
    }

    /// A type.
    pub fn type_of(&mut self, range: Range<usize>) -> Type {
        let span = self.span(&range);
        let parsed = self.parse(range, |parser| parser.whole(Parser::type_of));
        parsed.unwrap_or(Type { kind: TypeKind::Wrong, span })
    }

    /// Statements.
    pub fn statements(&mut self, range: Range<usize>) -> Vec<Statement> {
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
    /// The expression in a part of the text, such as the value of an attribute.
    pub fn expression_in(&mut self, range: Range<usize>) -> ExpressionId {
        let mut tree = std::mem::take(&mut self.tree);
        let file = self.span().file;
        let id = Fragments { text: self.text, file, tree: &mut tree, report: self.report }.expression(range);
        self.tree = tree;
        id
    }

    /// What is read, and nothing after it.
    fn whole<T>(&mut self, read: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        let read = read(self)?;
        if self.is_end() { Ok(read) } else { self.fail("nothing more") }
    }
}
