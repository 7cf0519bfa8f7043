//! Parses tokens into a syntax tree. Any text yields a tree; errors, including excessive nesting, are reported.

mod declarations;
mod expressions;
mod fragments;
mod globals;
mod statements;
#[cfg(test)]
mod tests;

use crate::front::lexer::{Kind, Span, Token, Tokens, tokens};
use crate::front::simatic_sd::Texts;
use crate::front::syntax::{Attribute, Binary, ExpressionId, ExpressionKind, Name, Tree, key};
use crate::report::Report;
use std::collections::BTreeSet;

pub(crate) use fragments::Fragments;

/// The maximum nesting depth of statements, brackets, types and start values together.
const DEEPEST: usize = 100;

/// Parsing of a source stops at this many errors.
const MOST_ERRORS: usize = 100;

/// Advice for a file that is not text, or is UTF-16 without a byte order mark.
const SAVE: &str = "save the source as text in UTF-8";

/// Parses an SCL source.
pub(crate) fn parse(text: &str, file: u32, report: &mut Report) -> Tree {
    parse_source(text, file, None, report)
}

/// Parses an SCL source, or a SIMATIC SD document with its texts.
pub(crate) fn parse_source(text: &str, file: u32, document: Option<&Texts<'_>>, report: &mut Report) -> Tree {
    if let Some(at) = text.find('\0') {
        let at = at as u32;
        report.error(
            Span { file, start: at, end: at + 1 },
            "this is not text: it contains a null character",
            Some(SAVE),
        );
        return Tree::default();
    }
    let tree = Tree { may_set_eno: may_set_eno(text), ..Tree::default() };
    Parser { document, ..parser_of(text, 0, file, tree, report) }.source()
}

/// Whether a source mentions ENO or contains a RETURN with a value.
pub(crate) fn may_set_eno(text: &str) -> bool {
    let text = text.to_ascii_uppercase();
    let is_value = |rest: &str| rest.starts_with(|c: char| c.is_whitespace()) && !rest.trim_start().starts_with(';');
    text.contains("ENO") || text.split("RETURN").skip(1).any(is_value)
}

/// Creates a parser that starts at a byte offset of a text and adds to a tree.
fn parser_of<'a>(text: &'a str, from: usize, file: u32, tree: Tree, report: &'a mut Report) -> Parser<'a> {
    let Tokens { tokens, comments, attributes, unclosed, nested } = tokens(text, from, file);
    for span in nested {
        report.warning(span, "a nested comment: the text after its end is part of the outer comment", Some(NESTED));
    }
    if let Some(span) = unclosed {
        let (what, help) = match text[span.range()].as_bytes() {
            [b'{', ..] => ("this attribute", "close it with }"),
            [b'/', ..] => ("this comment", "close it with */"),
            [b'(', b'/', ..] => ("this comment", "close it with */)"),
            _ => ("this comment", "close it with *)"),
        };
        report.error(span, format!("{what} is not closed"), Some(help));
    }
    let most = report.errors() + MOST_ERRORS;
    Parser {
        text,
        tokens,
        comments,
        attributes,
        at: 0,
        depth: 0,
        gotos: BTreeSet::new(),
        is_data: false,
        document: None,
        is_end_told: unclosed.is_some(),
        tree,
        report,
        most,
    }
}

/// A syntax error, which has been reported.
pub(crate) struct Failed;

pub(crate) type Parsed<T> = Result<T, Failed>;

pub(crate) struct Parser<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    comments: Vec<Span>,
    attributes: Vec<Span>,
    pub at: usize,
    depth: usize,
    /// The labels that the block declares or jumps to; any other word before a colon in CASE is a value.
    gotos: BTreeSet<String>,
    /// Whether a data block is being parsed. In its body, `[1]` is an element of the data block itself.
    is_data: bool,
    /// The texts of a SIMATIC SD document; `None` in SCL.
    pub document: Option<&'a Texts<'a>>,
    /// Whether a premature end of file has been reported.
    is_end_told: bool,
    pub tree: Tree,
    pub report: &'a mut Report,
    most: usize,
}

impl<'a> Parser<'a> {
    pub(crate) fn token(&self) -> Token {
        self.ahead(0)
    }

    pub(crate) fn ahead(&self, by: usize) -> Token {
        self.tokens[(self.at + by).min(self.tokens.len() - 1)]
    }

    pub(crate) fn text_of(&self, token: Token) -> &'a str {
        &self.text[token.span.range()]
    }

    pub(crate) fn span(&self) -> Span {
        self.token().span
    }

    /// The span of the previous token.
    pub(crate) fn before(&self) -> Span {
        self.tokens[self.at.saturating_sub(1)].span
    }

    /// The end of the previous token; 0 at the start of the text.
    pub(crate) fn end_before(&self) -> u32 {
        if self.at == 0 { 0 } else { self.before().end }
    }

    pub(crate) fn is_end(&self) -> bool {
        self.token().kind == Kind::End
    }

    pub(crate) fn step(&mut self) -> Token {
        let token = self.token();
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        token
    }

    pub(crate) fn symbol_ahead(&self, by: usize) -> &'a str {
        match self.ahead(by) {
            token if token.kind == Kind::Symbol => self.text_of(token),
            _ => "",
        }
    }

    /// The word at a token in upper case; empty if it is not a word.
    pub(crate) fn word_ahead(&self, by: usize) -> String {
        match self.ahead(by) {
            token if token.kind == Kind::Word => key(self.text_of(token)),
            _ => String::new(),
        }
    }

    pub(crate) fn is_symbol(&self, symbol: &str) -> bool {
        self.symbol_ahead(0) == symbol
    }

    pub(crate) fn is_word(&self, word: &str) -> bool {
        self.token().kind == Kind::Word && self.text_of(self.token()).eq_ignore_ascii_case(word)
    }

    pub(crate) fn takes(&mut self, symbol: &str) -> bool {
        let is_there = self.is_symbol(symbol);
        if is_there {
            self.step();
        }
        is_there
    }

    pub(crate) fn takes_word(&mut self, word: &str) -> bool {
        let is_there = self.is_word(word);
        if is_there {
            self.step();
        }
        is_there
    }

    pub(crate) fn expect(&mut self, symbol: &str) -> Parsed<()> {
        if self.takes(symbol) { Ok(()) } else { self.fail(&format!("`{symbol}`")) }
    }

    pub(crate) fn expect_word(&mut self, word: &str) -> Parsed<()> {
        if self.takes_word(word) { Ok(()) } else { self.fail(word) }
    }

    /// Reports an error at the current token; `expected` describes the expected syntax.
    pub(crate) fn fail<T>(&mut self, expected: &str) -> Parsed<T> {
        self.fail_with(expected, None)
    }

    /// Like [`fail`](Self::fail), with advice.
    pub(crate) fn fail_with<T>(&mut self, expected: &str, help: Option<&str>) -> Parsed<T> {
        let token = self.token();
        let found = match token.kind {
            Kind::End if self.is_end_told => return Err(Failed),
            Kind::End => {
                self.is_end_told = true;
                "the end of the file".to_string()
            }
            Kind::Unknown if self.text_of(token).starts_with(['\'', '"', '#']) && token.span.range().len() > 1 => {
                return self.refuse(token.span, "this string or name is not closed on its line", None);
            }
            Kind::Symbol if self.text_of(token) == "=" && &self.text[self.before().range()] == "=" => {
                return self.refuse(token.span, "SCL has no ==", Some("= compares, := assigns"));
            }
            _ => parameters::problem::quoted(self.text_of(token)),
        };
        self.refuse(token.span, &format!("expected {expected}, found {found}"), help)
    }

    pub(crate) fn refuse<T>(&mut self, span: Span, message: &str, help: Option<&str>) -> Parsed<T> {
        if self.report.errors() < self.most {
            self.report.error(span, message, help);
        }
        Err(Failed)
    }

    pub(crate) fn is_exhausted(&self) -> bool {
        self.report.errors() >= self.most
    }

    /// Calls `parse` one nesting level deeper; reports an error if the nesting is too deep.
    pub(crate) fn deeper<T>(&mut self, parse: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth == DEEPEST {
            let message = format!("more than {DEEPEST} levels of nesting");
            // Stop after this error: what follows would be parsed at the wrong depth.
            self.most = self.report.errors() + 1;
            return self.refuse(self.span(), &message, Some("move the inner part to a variable or a function"));
        }
        self.depth += 1;
        let parsed = parse(self);
        self.depth -= 1;
        parsed
    }

    /// Parses a name of any kind, without `#` and quotation marks.
    pub(crate) fn name(&mut self, what: &str) -> Parsed<Name> {
        match self.token().kind {
            Kind::Word | Kind::Local | Kind::Quoted => {
                let token = self.step();
                Ok(Name { text: bare(self.text_of(token)).to_string(), span: token.span })
            }
            _ => self.fail(what),
        }
    }

    /// The attributes between two byte offsets.
    pub(crate) fn attributes_within(&self, from: u32, to: u32) -> Vec<Attribute> {
        let first = self.attributes.partition_point(|span| span.start < from);
        let within = self.attributes[first..].iter().take_while(|span| span.start < to);
        within.flat_map(|span| attributes(&self.text[span.range()])).collect()
    }

    /// The range of an attribute's value, without quotation marks, if the attribute is between two byte offsets.
    pub(crate) fn value_within(&self, from: u32, to: u32, name: &str) -> Option<std::ops::Range<usize>> {
        let first = self.attributes.partition_point(|span| span.start < from);
        let mut within = self.attributes[first..].iter().take_while(|span| span.start < to);
        within.find_map(|span| {
            let text = &self.text[span.range()];
            let at = text.to_ascii_uppercase().find(name)? + name.len();
            let open = at + text[at..].find('"')? + 1;
            let close = open + text[open..].find('"')?;
            Some(span.start as usize + open..span.start as usize + close)
        })
    }

    /// The comments between two byte offsets, without their delimiters.
    pub(crate) fn comments_within(&self, from: u32, to: u32) -> String {
        let first = self.comments.partition_point(|span| span.start < from);
        let within = self.comments[first..].iter().take_while(|span| span.start < to);
        within.map(|span| comment(&self.text[span.range()])).collect::<Vec<_>>().join("\n")
    }

    pub(crate) fn add(&mut self, kind: ExpressionKind, start: Span) -> ExpressionId {
        let span = start.to(self.before());
        self.tree.expressions.add(kind, span)
    }

    pub(crate) fn binary(&mut self, operator: Binary, left: ExpressionId, right: ExpressionId) -> ExpressionId {
        let span = self.tree.expressions[left].span.to(self.tree.expressions[right].span);
        self.tree.expressions.add(ExpressionKind::Binary(operator, left, right), span)
    }
}

/// Advice for a nested comment.
const NESTED: &str = "versions of TIA Portal differ here: close the outer comment before the inner one begins";

/// A name without `#` and quotation marks.
fn bare(name: &str) -> &str {
    name.trim_start_matches('#').trim_matches('"')
}

/// A comment without its delimiters.
fn comment(text: &str) -> &str {
    let text = ["//", "(/*", "(*", "/*"].iter().find_map(|open| text.strip_prefix(open)).unwrap_or(text);
    let text = ["*/)", "*)", "*/"].iter().find_map(|close| text.strip_suffix(close)).unwrap_or(text);
    text.trim()
}

/// Parses `{ key := 'value'; ... }`; an attribute without a value is TRUE.
fn attributes(text: &str) -> Vec<Attribute> {
    let part = |part: &str| {
        let (name, value) = part.split_once(":=").unwrap_or((part, "TRUE"));
        let value = value.trim().trim_matches(['\'', '"']).to_string();
        (!name.trim().is_empty()).then(|| Attribute { key: key(name.trim()), value })
    };
    text.trim_matches(['{', '}']).split(';').filter_map(part).collect()
}
