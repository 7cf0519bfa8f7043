//! Tokens to a syntax tree. Whatever the text is, there is a tree and a list of errors; no text is too deep.

mod declarations;
mod expressions;
mod globals;
mod statements;
#[cfg(test)]
mod tests;

use crate::lexer::{Kind, Span, Token, Tokens, tokens};
use crate::report::Report;
use crate::syntax::{Attribute, Binary, ExpressionId, ExpressionKind, Name, Tree, key};
use std::collections::BTreeSet;

/// So deep statements, brackets, types and start values may be nested, all together.
const DEEPEST: usize = 100;

/// After this many errors the rest of a source is not read.
const MOST_ERRORS: usize = 100;

/// What to do with a file that is no text, or in UTF-16 without its byte order mark.
const SAVE: &str = "save the source as text in UTF-8";

/// The tree of a source.
pub fn parse(text: &str, file: u32, report: &mut Report) -> Tree {
    if let Some(at) = text.find('\0') {
        let at = at as u32;
        report.error(Span { file, start: at, end: at + 1 }, "this is no text: it has a character 0", Some(SAVE));
        return Tree::default();
    }
    let Tokens { tokens, comments, attributes, unclosed, nested } = tokens(text, file);
    for span in nested {
        report.warning(span, "a comment in a comment: what follows its end is read as comment, too", Some(NESTED));
    }
    if let Some(span) = unclosed {
        let (what, help) = match text[span.range()].as_bytes() {
            [b'{', ..] => ("this attribute", "close it with }"),
            [b'/', ..] => ("this comment", "close it with */"),
            [b'(', b'/', ..] => ("this comment", "close it with */)"),
            _ => ("this comment", "close it with *)"),
        };
        report.error(span, format!("{what} does not end"), Some(help));
    }
    let most = report.errors() + MOST_ERRORS;
    let parser = Parser {
        text,
        tokens,
        comments,
        attributes,
        at: 0,
        depth: 0,
        gotos: BTreeSet::new(),
        is_data: false,
        is_end_told: unclosed.is_some(),
        tree: Tree::default(),
        report,
        most,
    };
    parser.source()
}

/// What was expected is not there; a message says so.
struct Failed;

type Parsed<T> = Result<T, Failed>;

struct Parser<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    comments: Vec<Span>,
    attributes: Vec<Span>,
    at: usize,
    depth: usize,
    /// The labels to which the block jumps: what tells them from the values of CASE.
    gotos: BTreeSet<String>,
    /// Within a data block, whose own elements are written `[1]`.
    is_data: bool,
    /// The file ends too early, and a message has told it.
    is_end_told: bool,
    tree: Tree,
    report: &'a mut Report,
    most: usize,
}

impl<'a> Parser<'a> {
    fn token(&self) -> Token {
        self.ahead(0)
    }

    fn ahead(&self, by: usize) -> Token {
        self.tokens[(self.at + by).min(self.tokens.len() - 1)]
    }

    fn text_of(&self, token: Token) -> &'a str {
        &self.text[token.span.range()]
    }

    fn span(&self) -> Span {
        self.token().span
    }

    /// The span of what was read last.
    fn before(&self) -> Span {
        self.tokens[self.at.saturating_sub(1)].span
    }

    fn is_end(&self) -> bool {
        self.token().kind == Kind::End
    }

    fn step(&mut self) -> Token {
        let token = self.token();
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        token
    }

    fn symbol_ahead(&self, by: usize) -> &'a str {
        match self.ahead(by) {
            token if token.kind == Kind::Symbol => self.text_of(token),
            _ => "",
        }
    }

    /// The word in capitals, if the token is one.
    fn word_ahead(&self, by: usize) -> String {
        match self.ahead(by) {
            token if token.kind == Kind::Word => key(self.text_of(token)),
            _ => String::new(),
        }
    }

    fn is_symbol(&self, symbol: &str) -> bool {
        self.symbol_ahead(0) == symbol
    }

    fn is_word(&self, word: &str) -> bool {
        self.token().kind == Kind::Word && self.text_of(self.token()).eq_ignore_ascii_case(word)
    }

    fn takes(&mut self, symbol: &str) -> bool {
        let is_there = self.is_symbol(symbol);
        if is_there {
            self.step();
        }
        is_there
    }

    fn takes_word(&mut self, word: &str) -> bool {
        let is_there = self.is_word(word);
        if is_there {
            self.step();
        }
        is_there
    }

    fn expect(&mut self, symbol: &str) -> Parsed<()> {
        if self.takes(symbol) { Ok(()) } else { self.fail(&format!("`{symbol}`")) }
    }

    fn expect_word(&mut self, word: &str) -> Parsed<()> {
        if self.takes_word(word) { Ok(()) } else { self.fail(word) }
    }

    /// An error at the token: what was expected there.
    fn fail<T>(&mut self, expected: &str) -> Parsed<T> {
        self.fail_with(expected, None)
    }

    /// The same, with what to do.
    fn fail_with<T>(&mut self, expected: &str, help: Option<&str>) -> Parsed<T> {
        let token = self.token();
        let found = match token.kind {
            Kind::End if self.is_end_told => return Err(Failed),
            Kind::End => {
                self.is_end_told = true;
                "the end of the file".to_string()
            }
            Kind::Unknown if self.text_of(token).starts_with(['\'', '"', '#']) && token.span.range().len() > 1 => {
                return self.refuse(token.span, "this text or name does not end in its line", None);
            }
            Kind::Symbol if self.text_of(token) == "=" && &self.text[self.before().range()] == "=" => {
                return self.refuse(token.span, "there is no == in SCL", Some("= compares, := assigns"));
            }
            _ => parameters::problem::quoted(self.text_of(token)),
        };
        self.refuse(token.span, &format!("expected {expected}, found {found}"), help)
    }

    fn refuse<T>(&mut self, span: Span, message: &str, help: Option<&str>) -> Parsed<T> {
        if self.report.errors() < self.most {
            self.report.error(span, message, help);
        }
        Err(Failed)
    }

    fn is_exhausted(&self) -> bool {
        self.report.errors() >= self.most
    }

    /// Goes one level deeper.
    fn deeper<T>(&mut self, parse: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth == DEEPEST {
            let message = format!("more than {DEEPEST} levels are nested here");
            // What is written behind it is read at a wrong depth.
            self.most = self.report.errors() + 1;
            return self.refuse(self.span(), &message, Some("move the inner part to a variable or a function"));
        }
        self.depth += 1;
        let parsed = parse(self);
        self.depth -= 1;
        parsed
    }

    /// A name of any kind, without `#` and quotation marks.
    fn name(&mut self, what: &str) -> Parsed<Name> {
        match self.token().kind {
            Kind::Word | Kind::Local | Kind::Quoted => {
                let token = self.step();
                Ok(Name { text: bare(self.text_of(token)).to_string(), span: token.span })
            }
            _ => self.fail(what),
        }
    }

    /// The attributes between two bytes of the text.
    fn attributes_within(&self, from: u32, to: u32) -> Vec<Attribute> {
        let first = self.attributes.partition_point(|span| span.start < from);
        let within = self.attributes[first..].iter().take_while(|span| span.start < to);
        within.flat_map(|span| attributes(&self.text[span.range()])).collect()
    }

    /// The comments between two bytes of the text, without their marks.
    fn comments_within(&self, from: u32, to: u32) -> String {
        let first = self.comments.partition_point(|span| span.start < from);
        let within = self.comments[first..].iter().take_while(|span| span.start < to);
        within.map(|span| comment(&self.text[span.range()])).collect::<Vec<_>>().join("\n")
    }

    fn add(&mut self, kind: ExpressionKind, start: Span) -> ExpressionId {
        let span = start.to(self.before());
        self.tree.expressions.add(kind, span)
    }

    fn binary(&mut self, operator: Binary, left: ExpressionId, right: ExpressionId) -> ExpressionId {
        let span = self.tree.expressions[left].span.to(self.tree.expressions[right].span);
        self.tree.expressions.add(ExpressionKind::Binary(operator, left, right), span)
    }
}

/// What to do about a comment in a comment.
const NESTED: &str = "editions of TIA Portal differ here: end the first one before the second begins";

/// A name without `#` and quotation marks.
fn bare(name: &str) -> &str {
    name.trim_start_matches('#').trim_matches('"')
}

/// A comment without its marks.
fn comment(text: &str) -> &str {
    let text = ["//", "(/*", "(*", "/*"].iter().find_map(|open| text.strip_prefix(open)).unwrap_or(text);
    let text = ["*/)", "*)", "*/"].iter().find_map(|close| text.strip_suffix(close)).unwrap_or(text);
    text.trim()
}

/// `{ key := 'value'; ... }`; what has no value is TRUE.
fn attributes(text: &str) -> Vec<Attribute> {
    let part = |part: &str| {
        let (name, value) = part.split_once(":=").unwrap_or((part, "TRUE"));
        let value = value.trim().trim_matches(['\'', '"']).to_string();
        (!name.trim().is_empty()).then(|| Attribute { key: key(name.trim()), value })
    };
    text.trim_matches(['{', '}']).split(';').filter_map(part).collect()
}
