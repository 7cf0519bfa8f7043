//! Parses the values of a data block: `GAIN := 2.0;`.

use super::lexer::TokenKind;
use super::parser::{OPEN_COMMENT, Tokens};
use crate::problem::quoted;
use std::ops::Range;

/// The maximum number of values in a data block, and of parts in a member's name.
const MOST_VALUES: usize = 10_000;
const MOST_PARTS: usize = 40;

/// The maximum number of errors collected from a data block, and of additional errors counted before parsing stops.
const MOST_ERRORS: usize = 50;
const MOST_COUNTED: usize = 10_000;

/// A value assigned to a member.
#[derive(Debug)]
pub(super) struct Assignment {
    /// The parts of the member's name, without quotes: two for `TIC.GAIN`; an element of an array is one part,
    /// `TIC[2]`.
    pub(super) path: Vec<String>,
    pub(super) path_span: Range<usize>,
    /// The value as written, including its sign.
    pub(super) literal: String,
    pub(super) literal_span: Range<usize>,
}

/// A syntax error.
#[derive(Debug)]
pub(super) struct SyntaxError {
    pub(super) span: Range<usize>,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

/// The errors in a data block.
#[derive(Debug, Default)]
pub(super) struct SyntaxErrors {
    pub(super) first: Vec<SyntaxError>,
    /// The number of errors not collected.
    pub(super) others: usize,
}

impl SyntaxErrors {
    fn push(&mut self, error: SyntaxError) {
        if self.first.len() < MOST_ERRORS {
            self.first.push(error);
        } else {
            self.others += 1;
        }
    }
}

/// Parses the values in a part of a text, and collects its errors.
pub(super) fn assignments(text: &str, part: Range<usize>) -> (Vec<Assignment>, SyntaxErrors) {
    let mut tokens = Tokens::new(text, part);
    let mut assignments = Vec::new();
    let mut errors = SyntaxErrors::default();
    while tokens.peek().is_some() && errors.others < MOST_COUNTED {
        if tokens.next_is_symbol(";") {
            tokens.take();
            continue;
        }
        if assignments.len() == MOST_VALUES {
            let message = format!("this data block has more than {MOST_VALUES} values");
            errors.push(SyntaxError { span: tokens.next_span(), message, help: None });
            break;
        }
        let start = tokens.next_span();
        let error = match assignment(text, &mut tokens) {
            Ok(assignment) => {
                assignments.push(assignment);
                end_of_statement(&mut tokens).err()
            }
            Err(error) => {
                if tokens.next_span() == start {
                    tokens.take();
                }
                Some(error)
            }
        };
        if let Some(error) = error {
            errors.push(error);
            // The next statement starts after the next `;`, or on the next line.
            while tokens.peek().is_some() && !tokens.next_is_symbol(";") && !tokens.next_begins_line() {
                tokens.take();
            }
        }
    }
    (assignments, errors)
}

/// Expects the `;` after a value.
fn end_of_statement(tokens: &mut Tokens) -> Result<(), SyntaxError> {
    if tokens.next_is_symbol(";") {
        tokens.take();
        return Ok(());
    }
    if tokens.peek().is_none() || tokens.next_begins_line() {
        let span = tokens.previous_end()..tokens.previous_end();
        return Err(SyntaxError { span, message: "expected `;` after this value".to_string(), help: None });
    }
    let help = tokens.next_is_symbol(",").then(|| "write a decimal point, not a comma".to_string());
    Err(SyntaxError { help, ..expected(tokens, "`;` after this value") })
}

fn assignment(text: &str, tokens: &mut Tokens) -> Result<Assignment, SyntaxError> {
    let (path, path_span) = path(text, tokens)?;
    let name = quoted(&text[path_span.clone()]);
    tokens.skip_attributes().map_err(|span| SyntaxError {
        span,
        message: "expected `}` after these attributes, found the end of the data block".to_string(),
        help: None,
    })?;
    if tokens.next_kind() != Some(TokenKind::Assign) {
        return Err(expected(tokens, &format!("`:=` after {name}")));
    }
    tokens.take();
    let sign = if tokens.next_is_symbol("-") {
        "-"
    } else if tokens.next_is_symbol("+") {
        "+"
    } else {
        ""
    };
    let start = tokens.next_span().start;
    if !sign.is_empty() {
        tokens.take();
    }
    let is_value = match tokens.next_kind() {
        // A name on the next line is the next member, not the value of this one.
        Some(TokenKind::Word) if tokens.next_begins_line() => is_literal(tokens.next_text()),
        Some(TokenKind::Word | TokenKind::Text | TokenKind::QuotedName) => true,
        _ => false,
    };
    if !is_value {
        return Err(expected(tokens, &format!("a value for {name}")));
    }
    let literal = format!("{sign}{}", tokens.next_text());
    let end = tokens.next_span().end;
    tokens.take();
    Ok(Assignment { path, path_span, literal, literal_span: start..end })
}

/// Whether a word can only be a value, not a name.
fn is_literal(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit())
        || word.contains('#')
        || word.eq_ignore_ascii_case("TRUE")
        || word.eq_ignore_ascii_case("FALSE")
}

/// Parses the name of a member, including the instances that contain it.
fn path(text: &str, tokens: &mut Tokens) -> Result<(Vec<String>, Range<usize>), SyntaxError> {
    if tokens.next_is_symbol("#") {
        tokens.take();
    }
    let mut span = tokens.next_span();
    let mut path = Vec::new();
    loop {
        let name = tokens.next_text();
        match tokens.next_kind() {
            Some(TokenKind::Word) => path.push(name.to_string()),
            Some(TokenKind::QuotedName) => path.push(name[1..name.len() - 1].to_string()),
            _ => return Err(expected(tokens, "a member name")),
        }
        if path.len() > MOST_PARTS {
            return Err(expected(tokens, &format!("a name of at most {MOST_PARTS} parts")));
        }
        span.end = tokens.next_span().end;
        tokens.take();
        if tokens.next_is_symbol("[") {
            let begin = tokens.next_span().end;
            while tokens.peek().is_some() && !tokens.next_is_symbol("]") && !tokens.next_is_symbol(";") {
                tokens.take();
            }
            if !tokens.next_is_symbol("]") {
                return Err(expected(tokens, "`]` after the index"));
            }
            let index: String = text[begin..tokens.next_span().start].split_whitespace().collect();
            if let Some(name) = path.last_mut() {
                *name = format!("{name}[{index}]");
            }
            span.end = tokens.next_span().end;
            tokens.take();
        }
        if !tokens.next_is_symbol(".") {
            return Ok((path, span));
        }
        tokens.take();
    }
}

fn expected(tokens: &Tokens, expected: &str) -> SyntaxError {
    if tokens.next_kind() == Some(TokenKind::OpenComment) {
        return SyntaxError { span: tokens.next_span(), message: OPEN_COMMENT.to_string(), help: None };
    }
    let found = match tokens.next_kind() {
        Some(TokenKind::OpenQuote) => format!("{}, which has no closing quote", tokens.found()),
        Some(_) => tokens.found(),
        None => "the end of the data block".to_string(),
    };
    SyntaxError { span: tokens.next_span(), message: format!("expected {expected}, found {found}"), help: None }
}
