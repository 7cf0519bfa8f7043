//! Splits text into tokens.

use std::ops::Range;

/// A range of bytes in a source text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// The index of the source among the program's sources.
    pub file: u32,
    /// The start, as a byte offset.
    pub start: u32,
    /// The end, as an exclusive byte offset.
    pub end: u32,
}

impl Span {
    /// Whether another span starts within this one.
    pub fn holds(self, other: Span) -> bool {
        self.file == other.file && self.range().contains(&(other.start as usize))
    }

    pub fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }

    /// The span from the start of this one to the end of another.
    pub fn to(self, end: Span) -> Span {
        Span { end: end.end.max(self.start), ..self }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A keyword, or a name without quotation marks.
    Word,
    /// `#name` or `#"name"`.
    Local,
    /// `"name"`.
    Quoted,
    /// A number or typed literal: `1.5`, `16#FF`, `T#2S`, `STRING#'a'`.
    Literal,
    /// `'text'`.
    Text,
    /// `%I0.0`, `%X3`.
    Percent,
    /// An operator or a bracket.
    Symbol,
    /// An invalid character, or an unterminated string or name.
    Unknown,
    /// The end of the file.
    End,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Token {
    pub kind: Kind,
    pub span: Span,
}

/// The tokens of a source.
#[derive(Debug)]
pub(crate) struct Tokens {
    /// All tokens, without comments, attributes, titles and region lines. The last one is the end of the file.
    pub tokens: Vec<Token>,
    /// The comments, in source order.
    pub comments: Vec<Span>,
    /// The attributes in braces, in source order.
    pub attributes: Vec<Span>,
    /// The opening mark of an unterminated comment or attribute.
    pub unclosed: Option<Span>,
    /// The opening marks of comments that contain comments and therefore do not end at the first closing mark.
    pub nested: Vec<Span>,
}

/// The operators and brackets, longest first.
const SYMBOLS: [&str; 33] = [
    "...", "..", ":=", "=>", "+=", "-=", "*=", "/=", "**", "<=", ">=", "<>", "?=", "+", "-", "*", "/", "=", "<", ">",
    "&", "(", ")", "[", "]", ",", ";", ":", ".", "^", "}", "|", "@",
];

/// The type prefixes of literals, as in `INT#1`.
const PREFIXES: [&str; 40] = [
    "B",
    "BOOL",
    "BYTE",
    "C",
    "CHAR",
    "D",
    "DATE",
    "DATE_AND_TIME",
    "DINT",
    "DT",
    "DTL",
    "DW",
    "DWORD",
    "INT",
    "L",
    "LDT",
    "LINT",
    "LREAL",
    "LT",
    "LTIME",
    "LTIME_OF_DAY",
    "LTOD",
    "LW",
    "LWORD",
    "P",
    "REAL",
    "S5T",
    "S5TIME",
    "SINT",
    "STRING",
    "T",
    "TIME",
    "TIME_OF_DAY",
    "TOD",
    "UDINT",
    "UINT",
    "ULINT",
    "USINT",
    "W",
    "WORD",
];

/// The type prefixes of string and character literals, as in `STRING#'a'`.
const TEXTS: [&str; 4] = ["CHAR", "STRING", "WCHAR", "WSTRING"];

/// Splits text into tokens, starting at byte offset `from`.
pub(crate) fn tokens(text: &str, from: usize, file: u32) -> Tokens {
    let mut lexer = Lexer {
        text,
        file,
        at: from,
        line: from,
        is_head: false,
        declaring: 0,
        is_never_nested: false,
        found: Tokens {
            tokens: Vec::new(),
            comments: Vec::new(),
            attributes: Vec::new(),
            unclosed: None,
            nested: Vec::new(),
        },
    };
    while lexer.at < text.len() {
        lexer.next();
    }
    lexer.push(Kind::End, text.len());
    lexer.found
}

struct Lexer<'a> {
    text: &'a str,
    file: u32,
    at: usize,
    /// The byte offset at which the current line starts.
    line: usize,
    /// Whether the lexer is in a block's header, before its first section or BEGIN; there, a title takes up the line.
    is_head: bool,
    /// The number of open sections and structures. Inside them, `REGION` at the start of a line is a name.
    declaring: usize,
    /// Whether a nested comment was found to be unterminated; the search for its end is not repeated.
    is_never_nested: bool,
    found: Tokens,
}

/// Whether a character may continue a name.
pub(crate) fn is_word(character: char) -> bool {
    character == '_' || character.is_alphanumeric()
}

impl Lexer<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    /// The byte offset of the first character, at or after `from`, that does not satisfy the predicate.
    fn end_of(&self, from: usize, is_part: impl Fn(char) -> bool) -> usize {
        self.text[from..].find(|character| !is_part(character)).map_or(self.text.len(), |length| from + length)
    }

    fn span(&self, end: usize) -> Span {
        Span { file: self.file, start: self.at as u32, end: end as u32 }
    }

    fn push(&mut self, kind: Kind, end: usize) {
        let span = self.span(end);
        self.found.tokens.push(Token { kind, span });
        self.at = end;
    }

    fn next(&mut self) {
        let rest = self.rest();
        let Some(first) = rest.chars().next() else { return };
        match first {
            '\n' => {
                self.at += 1;
                self.line = self.at;
            }
            _ if first.is_whitespace() || first == '\u{feff}' => self.at += first.len_utf8(),
            '/' if rest.starts_with("//") => {
                let end = self.end_of(self.at, |character| character != '\n');
                self.comment(end);
            }
            '(' if rest.starts_with("(*") => match self.nested() {
                Some(end) => {
                    self.found.nested.push(self.span(self.at + 2));
                    self.comment(end);
                }
                None => self.comment_to("*)", 2),
            },
            '(' if rest.starts_with("(/*") => self.comment_to("*/)", 3),
            '/' if rest.starts_with("/*") => self.comment_to("*/", 2),
            '{' => self.attribute(),
            '#' => self.local(),
            '"' => self.quoted(Kind::Quoted, self.at),
            '\'' => self.characters(self.at),
            '%' => self.percent(),
            '0'..='9' => self.number(self.at),
            _ if is_word(first) => self.word(),
            _ => match SYMBOLS.into_iter().find(|symbol| rest.starts_with(symbol)) {
                Some(symbol) => self.push(Kind::Symbol, self.at + symbol.len()),
                None => self.push(Kind::Unknown, self.at + first.len_utf8()),
            },
        }
    }

    fn comment(&mut self, end: usize) {
        let span = self.span(end);
        self.found.comments.push(span);
        self.at = end;
    }

    /// The end of a comment that contains comments, as in `(* a (* b *) c *)`; `None` if any of them is unterminated.
    fn nested(&mut self) -> Option<usize> {
        let from = self.at + 2;
        let first = self.text[from..].find("*)")?;
        if self.is_never_nested || !self.text[from..from + first].contains("(*") {
            return None;
        }
        let (mut depth, mut at, bytes) = (1, from, self.text.as_bytes());
        while let Some(pair) = bytes.get(at..at + 2) {
            match pair {
                b"(*" => (depth, at) = (depth + 1, at + 2),
                b"*)" => (depth, at) = (depth - 1, at + 2),
                _ => at += 1,
            }
            if depth == 0 {
                return Some(at);
            }
        }
        self.is_never_nested = true;
        None
    }

    fn comment_to(&mut self, close: &str, opening: usize) {
        let from = self.at + opening;
        match self.text[from..].find(close) {
            Some(length) => self.comment(from + length + close.len()),
            None => {
                self.found.unclosed.get_or_insert(self.span(from));
                self.at = self.text.len();
            }
        }
    }

    /// Reads `{ key := 'value'; ... }`, which ends at the first closing brace outside quotes.
    fn attribute(&mut self) {
        let mut quote = None;
        for (offset, character) in self.rest().char_indices() {
            match (quote, character) {
                (None, '}') => {
                    let span = self.span(self.at + offset + 1);
                    self.found.attributes.push(span);
                    self.at = span.end as usize;
                    return;
                }
                (None, '\'' | '"') => quote = Some(character),
                (Some(open), _) if open == character => quote = None,
                (Some(_), '\n') => quote = None,
                _ => {}
            }
        }
        self.found.unclosed.get_or_insert(self.span(self.at + 1));
        self.at = self.text.len();
    }

    fn local(&mut self) {
        let from = self.at + 1;
        match self.text[from..].chars().next() {
            Some('"') => self.quoted(Kind::Local, from),
            Some(first) if is_word(first) => self.push(Kind::Local, self.end_of(from, is_word)),
            _ => self.push(Kind::Unknown, from),
        }
    }

    /// Reads a name whose opening quotation mark is at byte offset `from`.
    fn quoted(&mut self, kind: Kind, from: usize) {
        let end = self.end_of(from + 1, |character| !matches!(character, '"' | '\n' | '\r'));
        match self.text[end..].starts_with('"') && end > from + 1 {
            true => self.push(kind, end + 1),
            false => self.push(Kind::Unknown, end),
        }
    }

    /// Reads a string whose opening single quote is at byte offset `from`; the prefix of a typed literal precedes it.
    fn characters(&mut self, from: usize) {
        let kind = if from == self.at { Kind::Text } else { Kind::Literal };
        let mut is_escaped = false;
        for (offset, character) in self.text[from + 1..].char_indices() {
            let at = from + 1 + offset;
            match character {
                '\n' | '\r' => return self.push(Kind::Unknown, at),
                _ if is_escaped => is_escaped = false,
                '$' => is_escaped = true,
                '\'' => return self.push(kind, at + 1),
                _ => {}
            }
        }
        self.push(Kind::Unknown, self.text.len());
    }

    fn percent(&mut self) {
        let mut end = self.end_of(self.at + 1, is_word);
        let mut parts = self.text[end..].char_indices();
        if let (Some((_, '.')), Some((_, '0'..='9' | 'D' | 'd'))) = (parts.next(), parts.next()) {
            end = self.end_of(end + 1, |character| is_word(character) || character == '.');
        }
        self.push(if end == self.at + 1 { Kind::Unknown } else { Kind::Percent }, end);
    }

    /// Reads a number whose digits start at byte offset `from`; the prefix of a typed literal precedes them.
    fn number(&mut self, from: usize) {
        let is_digit = |character: char| character.is_ascii_digit() || character == '_';
        let mut end = self.end_of(from, is_digit);
        let bytes = self.text.as_bytes();
        let digit_at = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
        if bytes.get(end) == Some(&b'#') {
            return self.push(Kind::Literal, self.end_of(end + 1, is_word));
        }
        if bytes.get(end) == Some(&b'.') && digit_at(end + 1) && !self.is_member_number() {
            end = self.end_of(end + 1, is_digit);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            if digit_at(end + 1 + sign) {
                end = self.end_of(end + 1 + sign, is_digit);
            }
        }
        // `10ms`: keep the suffix in the same token, so that only one error is reported.
        self.push(Kind::Literal, self.end_of(end, is_word));
    }

    /// Whether the number at the current offset follows a point, as the bit number in `DB5.DBX0.1` does.
    fn is_member_number(&self) -> bool {
        let Some(last) = self.found.tokens.last() else { return false };
        last.kind == Kind::Symbol && &self.text[last.span.range()] == "." && last.span.end as usize == self.at
    }

    fn word(&mut self) {
        let end = self.end_of(self.at, is_word);
        let word = self.text[self.at..end].to_ascii_uppercase();
        if self.text[end..].starts_with('#') && (PREFIXES.contains(&&*word) || TEXTS.contains(&&*word)) {
            return self.literal(&word, end + 1);
        }
        let is_first = self.text[self.line..self.at].trim_start_matches('\u{feff}').trim().is_empty();
        match &*word {
            "REGION" | "END_REGION" if is_first && self.declaring == 0 => {
                self.at = self.end_of(end, |character| character != '\n');
                return;
            }
            "TITLE" if self.is_head && self.text[end..].trim_start().starts_with('=') => {
                self.at = self.end_of(end, |character| character != '\n');
                return;
            }
            "FUNCTION_BLOCK" | "FUNCTION" | "DATA_BLOCK" | "TYPE" | "ORGANIZATION_BLOCK" => {
                self.is_head = true;
                self.declaring = 0;
            }
            "BEGIN" => (self.is_head, self.declaring) = (false, 0),
            "STRUCT" => self.declaring += 1,
            "END_VAR" | "END_STRUCT" => self.declaring = self.declaring.saturating_sub(1),
            _ if word == "VAR" || word.starts_with("VAR_") => {
                (self.is_head, self.declaring) = (false, self.declaring + 1);
            }
            _ => {}
        }
        self.push(Kind::Word, end);
    }

    /// Reads a typed literal, given its prefix and the byte offset after `#`.
    fn literal(&mut self, prefix: &str, from: usize) {
        let bytes = self.text.as_bytes();
        if bytes.get(from) == Some(&b'\'') {
            return self.characters(from);
        }
        let signed = from + usize::from(matches!(bytes.get(from), Some(b'+' | b'-')));
        match prefix {
            "P" => {
                let end = self.end_of(from, |character| is_word(character) || matches!(character, '.' | '#' | '"'));
                self.push(Kind::Literal, end);
            }
            "REAL" | "LREAL" if bytes.get(signed).is_some_and(u8::is_ascii_digit) => self.number(signed),
            "T" | "TIME" | "LT" | "LTIME" | "S5T" | "S5TIME" => {
                let is_part = |character| is_word(character) || character == '.';
                self.push(Kind::Literal, self.end_of(signed, is_part));
            }
            "D" | "DATE" | "TOD" | "TIME_OF_DAY" | "LTOD" | "LTIME_OF_DAY" | "DT" | "DATE_AND_TIME" | "LDT" | "DTL" => {
                let is_part = |character| is_word(character) || matches!(character, '.' | '-' | ':');
                self.push(Kind::Literal, self.end_of(from, is_part));
            }
            // A number with or without a base: `W#16#FF`, `INT#-5`, `BOOL#TRUE`.
            _ => {
                let end = self.end_of(signed, is_word);
                let end = if bytes.get(end) == Some(&b'#') { self.end_of(end + 1, is_word) } else { end };
                self.push(Kind::Literal, end);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> String {
        let found = tokens(text, 0, 0);
        found.tokens.iter().map(|token| format!("{:?}:{} ", token.kind, &text[token.span.range()])).collect()
    }

    #[test]
    fn literals_end_where_an_operator_begins() {
        assert_eq!(
            shown("T#1m_30s-INT#-5+1.5e-3*16#FFe-1"),
            "Literal:T#1m_30s Symbol:- Literal:INT#-5 Symbol:+ Literal:1.5e-3 Symbol:* Literal:16#FFe Symbol:- Literal:1 End: "
        );
        assert_eq!(shown("1..5"), "Literal:1 Symbol:.. Literal:5 End: ");
        assert_eq!(shown("DTL#2020-01-02-03:04:05.6;"), "Literal:DTL#2020-01-02-03:04:05.6 Symbol:; End: ");
        assert_eq!(shown("NOT#x"), "Word:NOT Local:#x End: ");
    }

    #[test]
    fn names_have_quotation_marks_a_hash_or_neither() {
        assert_eq!(
            shown("#\"a b\".%X3 := \"D B\".c[1]"),
            "Local:#\"a b\" Symbol:. Percent:%X3 Symbol::= Quoted:\"D B\" Symbol:. Word:c Symbol:[ Literal:1 Symbol:] End: "
        );
        assert_eq!(shown("%I0.0;%DB5.DBX1.2"), "Percent:%I0.0 Symbol:; Percent:%DB5.DBX1.2 End: ");
        assert_eq!(shown("DB5.DBX0.1"), "Word:DB5 Symbol:. Word:DBX0 Symbol:. Literal:1 End: ");
    }

    #[test]
    fn comments_attributes_and_regions_are_no_tokens() {
        let text = "REGION it's\n a { S7_X := '}' } (* 'b *) := /* \" */ 1; // '\nEND_REGION c\n(/* d */)";
        assert_eq!(shown(text), "Word:a Symbol::= Literal:1 Symbol:; End: ");
        assert_eq!(tokens(text, 0, 0).comments.len(), 4);
        assert_eq!(shown("VAR\n region : INT;"), "Word:VAR Word:region Symbol:: Word:INT Symbol:; End: ");
    }

    #[test]
    fn a_text_ends_in_its_line() {
        assert_eq!(shown("'it$'s' 'open\n1"), "Text:'it$'s' Unknown:'open Literal:1 End: ");
        assert_eq!(shown("STRING#'a'\"x\n"), "Literal:STRING#'a' Unknown:\"x End: ");
    }
}
