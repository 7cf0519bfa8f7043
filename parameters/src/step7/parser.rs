//! Finds the blocks in a source text: for a data block its name, type and the range of its values; for a function block
//! the members it declares. Everything else is skipped.

use super::lexer::{Lexer, Token, TokenKind};
use crate::problem::quoted;
use crate::report::Report;
use std::ops::Range;
use std::rc::Rc;

/// The maximum number of blocks in a file, so that a hostile file cannot exhaust memory. A PLC has at most 65535 of
/// each kind.
const MOST_BLOCKS: usize = 200_000;

/// The maximum number of members that all function blocks of a file declare.
const MOST_MEMBERS: usize = 1_000_000;

/// A name in the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Name {
    /// The name without quotes; `DB41` for `DB 41`.
    pub(super) text: String,
    pub(super) span: Range<usize>,
}

/// A block of the text.
#[derive(Debug)]
pub(super) enum Item {
    DataBlock(DataBlock),
    FunctionBlock(FunctionBlock),
    /// Any other block, which is skipped.
    Other(Name),
}

#[derive(Debug)]
pub(super) struct DataBlock {
    pub(super) name: Name,
    /// Its TITLE, unless empty.
    pub(super) title: Option<String>,
    /// The block type of the instance; `None` if it declares its own members.
    pub(super) block: Option<Name>,
    /// The range of its values, from BEGIN to END_DATA_BLOCK.
    pub(super) body: Range<usize>,
}

#[derive(Debug)]
pub(super) struct FunctionBlock {
    pub(super) name: Name,
    pub(super) members: Vec<Declaration>,
}

/// A member declared by a function block.
#[derive(Debug)]
pub(super) struct Declaration {
    pub(super) name: Name,
    /// Its type, if it is a name; for an array, the element type.
    pub(super) kind: Option<Rc<Name>>,
    /// The bounds of an array: `1..3` or `1..2, 0..7`.
    pub(super) array: Option<String>,
    pub(super) has_initial_value: bool,
}

/// The message for an unterminated comment.
pub(super) const OPEN_COMMENT: &str = "this comment is not closed";

/// The keywords that start and end a block.
const BLOCKS: [(&str, &str); 5] = [
    ("DATA_BLOCK", "END_DATA_BLOCK"),
    ("FUNCTION_BLOCK", "END_FUNCTION_BLOCK"),
    ("FUNCTION", "END_FUNCTION"),
    ("ORGANIZATION_BLOCK", "END_ORGANIZATION_BLOCK"),
    ("TYPE", "END_TYPE"),
];

/// The block properties that have a value after a colon.
const PROPERTIES: [&str; 4] = ["AUTHOR", "FAMILY", "NAME", "VERSION"];

/// The block properties that are a single word.
const FLAGS: [&str; 8] = [
    "KNOW_HOW_PROTECT",
    "NON_RETAIN",
    "RETAIN",
    "UNLINKED",
    "READ_ONLY",
    "STANDARD",
    "CODE_VERSION1",
    "MULTI_INSTANCE",
];

/// The prefixes of numbered blocks: `FB 41`.
const NUMBERED: [&str; 7] = ["DB", "FB", "SFB", "FC", "SFC", "OB", "UDT"];

/// The tokens of a text without white space and comments, with one token of lookahead.
pub(super) struct Tokens<'a> {
    text: &'a str,
    lexer: Lexer<'a>,
    next: Option<Token>,
    previous_end: usize,
    end: usize,
    is_in_comment: bool,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a str, part: Range<usize>) -> Tokens<'a> {
        let (start, end) = (part.start, part.end);
        let mut tokens =
            Tokens { text, lexer: Lexer::new(text, part), next: None, previous_end: start, end, is_in_comment: false };
        tokens.advance();
        tokens
    }

    fn advance(&mut self) {
        self.next = self.lexer.by_ref().find(|token| !token.kind.is_trivia());
    }

    pub(super) fn peek(&self) -> Option<&Token> {
        self.next.as_ref()
    }

    pub(super) fn take(&mut self) -> Option<Token> {
        let token = self.next.take()?;
        self.is_in_comment |= token.kind == TokenKind::OpenComment;
        self.previous_end = token.span.end;
        self.advance();
        Some(token)
    }

    /// Whether the text ended inside a comment, so that anything missing after it is not a separate error.
    pub(super) fn is_in_comment(&self) -> bool {
        self.is_in_comment
    }

    /// The end of the previous token.
    pub(super) fn previous_end(&self) -> usize {
        self.previous_end
    }

    /// The text of the next token; empty at the end.
    pub(super) fn next_text(&self) -> &'a str {
        self.next.as_ref().map_or("", |token| &self.text[token.span.clone()])
    }

    pub(super) fn next_kind(&self) -> Option<TokenKind> {
        self.next.as_ref().map(|token| token.kind)
    }

    /// The range of the next token; at the end, an empty range there.
    pub(super) fn next_span(&self) -> Range<usize> {
        self.next.as_ref().map_or(self.end..self.end, |token| token.span.clone())
    }

    pub(super) fn next_begins_line(&self) -> bool {
        self.next.as_ref().is_some_and(|token| token.begins_line)
    }

    pub(super) fn next_is_word(&self, word: &str) -> bool {
        self.next_kind() == Some(TokenKind::Word) && self.next_text().eq_ignore_ascii_case(word)
    }

    pub(super) fn next_is_symbol(&self, symbol: &str) -> bool {
        self.next_kind() == Some(TokenKind::Symbol) && self.next_text() == symbol
    }

    /// A description of the next token for messages.
    pub(super) fn found(&self) -> String {
        if self.next.is_some() { quoted(self.next_text()) } else { "the end".to_string() }
    }

    /// Parses a name, quoted or not, or a word with a number, such as `FB 41`.
    pub(super) fn name(&mut self) -> Option<Name> {
        let kind = self.next_kind().filter(|kind| matches!(kind, TokenKind::Word | TokenKind::QuotedName))?;
        let text = self.next_text();
        let mut span = self.take()?.span;
        if kind == TokenKind::QuotedName {
            return Some(Name { text: text[1..text.len() - 1].to_string(), span });
        }
        let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let is_numbered = |text: &str| NUMBERED.iter().any(|word| text.eq_ignore_ascii_case(word));
        let letters = text.trim_end_matches(|c: char| c.is_ascii_digit());
        let (letters, digits) = if is_numbered(text) && is_number(self.next_text()) {
            let digits = self.next_text();
            span.end = self.take()?.span.end;
            (text, digits)
        } else if is_numbered(letters) && letters.len() < text.len() {
            text.split_at(letters.len())
        } else {
            return Some(Name { text: text.to_string(), span });
        };
        let number = match digits.trim_start_matches('0') {
            "" => "0",
            number => number,
        };
        Some(Name { text: letters.to_ascii_uppercase() + number, span })
    }

    /// Skips attributes in braces, if any.
    ///
    /// # Errors
    /// The location of an opening brace that is not closed.
    pub(super) fn skip_attributes(&mut self) -> Result<(), Range<usize>> {
        if !self.next_is_symbol("{") {
            return Ok(());
        }
        let start = self.next_span();
        while !self.next_is_symbol("}") {
            self.take().ok_or(start.clone())?;
        }
        self.take();
        Ok(())
    }
}

/// The blocks of a text, in order. Structural errors go to the report.
pub(super) fn items(text: &str, report: &mut Report) -> Vec<Item> {
    let mut parser = Parser { tokens: Tokens::new(text, 0..text.len()), report, members: 0 };
    let mut items = Vec::new();
    while parser.tokens.peek().is_some() {
        if items.len() == MOST_BLOCKS || parser.members > MOST_MEMBERS {
            let message = format!("the file has more than {MOST_BLOCKS} blocks or {MOST_MEMBERS} members");
            parser.report.wrong(parser.tokens.next_span(), message, Some("split it".to_string()));
            break;
        }
        items.extend(parser.item());
    }
    items
}

struct Parser<'a, 'r, 's> {
    tokens: Tokens<'a>,
    report: &'r mut Report<'s>,
    members: usize,
}

impl Parser<'_, '_, '_> {
    /// Parses the next block; `None` if it cannot be read.
    fn item(&mut self) -> Option<Item> {
        self.attributes();
        if self.tokens.next_is_symbol(";") {
            self.tokens.take();
        }
        self.tokens.peek()?;
        let Some((keyword, end)) = self.block_keyword() else {
            self.expected("DATA_BLOCK or another block");
            while self.tokens.peek().is_some() && self.block_keyword().is_none() {
                self.tokens.take();
            }
            return None;
        };
        self.tokens.take();
        let Some(name) = self.tokens.name().filter(|name| !name.text.is_empty()) else {
            self.expected(&format!("a name after {keyword}"));
            self.skip_behind(end);
            return None;
        };
        match keyword {
            "DATA_BLOCK" => self.data_block(name, end).map(Item::DataBlock),
            "FUNCTION_BLOCK" => Some(Item::FunctionBlock(self.function_block(name, end))),
            _ => {
                self.end_of_block(&name, end);
                Some(Item::Other(name))
            }
        }
    }

    fn attributes(&mut self) {
        if let Err(place) = self.tokens.skip_attributes() {
            self.report.wrong(place, "expected `}` after these attributes, found the end", None);
        }
    }

    fn expected(&mut self, expected: &str) {
        let found = self.tokens.found();
        let message = match self.tokens.next_kind() {
            Some(TokenKind::OpenComment) => OPEN_COMMENT.to_string(),
            Some(TokenKind::OpenQuote) => format!("expected {expected}, found {found}, which has no closing quote"),
            _ => format!("expected {expected}, found {found}"),
        };
        self.report.wrong(self.tokens.next_span(), message, None);
        if self.tokens.next_kind() == Some(TokenKind::OpenComment) {
            // It extends to the end of the file, and is reported once.
            self.tokens.take();
        }
    }

    /// The start and end keywords, if the next token starts a block.
    fn block_keyword(&self) -> Option<(&'static str, &'static str)> {
        BLOCKS.into_iter().find(|(begin, _)| self.tokens.next_is_word(begin))
    }

    /// Whether the next token starts another block before the end of this one. `TYPE` may also be the name of a member.
    fn is_other_block(&self) -> bool {
        self.tokens.next_begins_line() && self.block_keyword().is_some_and(|(begin, _)| begin != "TYPE")
    }

    /// Skips to the next token that is this word, or that starts another block.
    fn skip_to(&mut self, end: &str) {
        while self.tokens.peek().is_some() && !self.tokens.next_is_word(end) && !self.is_other_block() {
            if self.tokens.next_kind() == Some(TokenKind::OpenComment) {
                self.expected(end);
            }
            self.tokens.take();
        }
    }

    /// Skips past the next token that is this word, or to one that starts another block.
    fn skip_behind(&mut self, end: &str) {
        self.skip_to(end);
        if self.tokens.next_is_word(end) {
            self.tokens.take();
        }
    }

    /// Skips past the end of a block. Returns the offset of the end.
    fn end_of_block(&mut self, name: &Name, end: &str) -> usize {
        self.skip_to(end);
        let place = self.tokens.next_span().start;
        if self.tokens.next_is_word(end) {
            self.tokens.take();
        } else if !self.tokens.is_in_comment() {
            let message = format!("{} has no {end}", quoted(&name.text));
            self.report.wrong(name.span.clone(), message, None);
        }
        place
    }

    /// Parses a data block after its name.
    fn data_block(&mut self, name: Name, end: &str) -> Option<DataBlock> {
        let mut blocks = Vec::new();
        let mut declares = false;
        let mut title = None;
        loop {
            self.attributes();
            let word = self.tokens.next_text();
            let is = |words: &[&str]| words.iter().any(|known| word.eq_ignore_ascii_case(known));
            match self.tokens.next_kind() {
                Some(TokenKind::Title) => {
                    title = title_of(word);
                    self.tokens.take();
                }
                Some(TokenKind::Word) if is(&["BEGIN"]) => break,
                Some(TokenKind::Word) if is(&["STRUCT", "ARRAY"]) || is_section(word) => {
                    // A data block that declares its own members is not an instance.
                    declares = true;
                    while self.tokens.peek().is_some() && !self.tokens.next_is_word("BEGIN") && !self.ends_header(end) {
                        self.tokens.take();
                    }
                    if !self.tokens.next_is_word("BEGIN") {
                        break;
                    }
                }
                Some(TokenKind::Word) if is(&FLAGS) => {
                    self.tokens.take();
                }
                Some(TokenKind::Word) if is(&PROPERTIES) => self.property(),
                Some(TokenKind::Word | TokenKind::QuotedName) if !self.ends_header(end) => {
                    blocks.extend(self.tokens.name());
                }
                Some(TokenKind::Symbol) if word == ";" => {
                    self.tokens.take();
                }
                _ => {
                    self.expected(&format!("BEGIN in the data block {}", quoted(&name.text)));
                    self.skip_behind(end);
                    return None;
                }
            }
        }
        let begin = self.tokens.next_span().end;
        let body = begin..self.end_of_block(&name, end).max(begin);
        let block = blocks.pop();
        if let Some(first) = blocks.first().filter(|_| !declares) {
            let message = format!("expected one block as the type of {}, found several", quoted(&name.text));
            self.report.wrong(first.span.clone(), message, None);
            return None;
        }
        if block.is_none() && !declares {
            let message =
                format!("the data block {} does not state which block it is an instance of", quoted(&name.text));
            self.report.wrong(name.span.clone(), message, Some("specify the block before BEGIN".to_string()));
            return None;
        }
        Some(DataBlock { name, title, block: block.filter(|_| !declares), body })
    }

    fn ends_header(&self, end: &str) -> bool {
        self.tokens.next_is_word(end) || self.is_other_block()
    }

    /// Skips `AUTHOR : X`, with a value that contains no space.
    fn property(&mut self) {
        self.tokens.take();
        if !self.tokens.next_is_symbol(":") {
            self.expected("`:`");
            return;
        }
        self.tokens.take();
        if self.tokens.next_begins_line() {
            // A property may be empty.
            return;
        }
        let mut end = self.tokens.next_span().start;
        while self.tokens.next_span().start == end && self.tokens.peek().is_some() {
            end = self.tokens.next_span().end;
            self.tokens.take();
        }
    }

    /// Parses a function block after its name.
    fn function_block(&mut self, name: Name, end: &str) -> FunctionBlock {
        let mut members = Vec::new();
        while self.tokens.peek().is_some() && !self.ends_header(end) {
            if is_section(self.tokens.next_text()) {
                self.section(&mut members, end);
            } else {
                self.tokens.take();
            }
        }
        self.end_of_block(&name, end);
        self.members += members.len();
        FunctionBlock { name, members }
    }

    /// Parses a section of a declaration: `VAR ... END_VAR`.
    fn section(&mut self, members: &mut Vec<Declaration>, end: &str) {
        let start = self.tokens.next_span();
        // Temporary variables are not in the data block.
        let is_temporary = self.tokens.next_is_word("VAR_TEMP");
        self.tokens.take();
        loop {
            if self.tokens.next_is_word("END_VAR") {
                self.tokens.take();
                return;
            }
            if self.tokens.peek().is_none() || self.ends_header(end) {
                self.report.wrong(start, "this section has no END_VAR", None);
                return;
            }
            match self.tokens.name() {
                Some(name) if is_temporary || self.members + members.len() > MOST_MEMBERS => drop(name),
                Some(name) => self.declaration(name, members),
                None => {
                    self.tokens.take();
                }
            }
        }
    }

    /// Parses one or more members and their type, after the first name.
    fn declaration(&mut self, first: Name, members: &mut Vec<Declaration>) {
        let mut names = vec![first];
        loop {
            self.attributes();
            if !self.tokens.next_is_symbol(",") {
                break;
            }
            self.tokens.take();
            let name = self.tokens.name();
            names.extend(name.filter(|_| self.members + members.len() + names.len() <= MOST_MEMBERS));
        }
        if !self.tokens.next_is_symbol(":") {
            // `VAR RETAIN` and `AT`: words that declare nothing.
            return;
        }
        self.tokens.take();
        let mut array = None;
        if self.tokens.next_is_word("ARRAY") {
            let begin = self.tokens.next_span().end;
            while self.is_inside() && !self.tokens.next_is_word("OF") {
                self.tokens.take();
            }
            let bounds = self.tokens.text[begin..self.tokens.next_span().start.max(begin)].trim();
            array = Some(bounds.trim_start_matches('[').trim_end_matches(']').to_string());
            self.tokens.take();
        }
        if self.tokens.next_is_word("STRUCT") {
            self.skip_struct();
        }
        let kind = if self.is_inside() { self.tokens.name().map(Rc::new) } else { None };
        let mut has_initial_value = false;
        while self.is_inside() && !self.tokens.next_is_symbol(";") {
            has_initial_value |= self.tokens.next_kind() == Some(TokenKind::Assign);
            self.tokens.take();
        }
        let declaration = |name| Declaration { name, kind: kind.clone(), array: array.clone(), has_initial_value };
        members.extend(names.into_iter().map(declaration));
    }

    /// Whether the section continues.
    fn is_inside(&self) -> bool {
        self.tokens.peek().is_some() && !self.tokens.next_is_word("END_VAR") && !self.is_other_block()
    }

    /// Skips to the end of a structure, whose members are values, not instances.
    fn skip_struct(&mut self) {
        let mut depth = 0usize;
        while self.is_inside() {
            depth += usize::from(self.tokens.next_is_word("STRUCT"));
            depth -= usize::from(self.tokens.next_is_word("END_STRUCT"));
            self.tokens.take();
            if depth == 0 {
                return;
            }
        }
    }
}

/// The keywords that start a section of a declaration.
const SECTIONS: [&str; 7] = ["VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP", "VAR_GLOBAL", "VAR_EXTERNAL"];

/// The text after `TITLE =`, without quotation marks around it.
fn title_of(line: &str) -> Option<String> {
    let title = line.split_once('=')?.1.trim();
    let bare = title.strip_prefix('\'').and_then(|title| title.strip_suffix('\'')).unwrap_or(title);
    (!bare.is_empty()).then(|| bare.to_string())
}

fn is_section(word: &str) -> bool {
    SECTIONS.iter().any(|section| word.eq_ignore_ascii_case(section))
}
