//! Splits a source text into tokens without loss: concatenated, they equal the text.

use std::ops::Range;

/// A token of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Token {
    pub(super) kind: TokenKind,
    /// Its byte range in the text.
    pub(super) span: Range<usize>,
    /// Whether only white space and comments precede it on its line.
    pub(super) begins_line: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TokenKind {
    /// Blanks and line ends.
    Space,
    /// `// ...`, `(* ... *)` or `/* ... */`.
    Comment,
    /// An unterminated comment.
    OpenComment,
    /// `TITLE = ...`, which extends to the end of the line, whatever its contents.
    Title,
    /// A keyword, a name or a literal: `BEGIN`, `GAIN`, `2.0e+000`, `T#20S`.
    Word,
    /// `"TIC101"`.
    QuotedName,
    /// `'text'`.
    Text,
    /// A name or string without a closing quote on its line.
    OpenQuote,
    /// `:=`.
    Assign,
    /// Any other character.
    Symbol,
}

impl TokenKind {
    /// Whether the parser skips it.
    pub(super) const fn is_trivia(self) -> bool {
        matches!(self, TokenKind::Space | TokenKind::Comment)
    }
}

/// Iterates over the tokens of a part of a text.
pub(super) struct Lexer<'a> {
    text: &'a str,
    at: usize,
    end: usize,
    begins_line: bool,
}

impl<'a> Lexer<'a> {
    /// Iterates over the tokens in a byte range.
    pub(super) fn new(text: &'a str, part: Range<usize>) -> Lexer<'a> {
        Lexer { text, at: part.start, end: part.end, begins_line: true }
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..self.end]
    }
}

impl Iterator for Lexer<'_> {
    type Item = Token;

    fn next(&mut self) -> Option<Token> {
        let rest = self.rest();
        let (kind, length) = token(rest)?;
        let title = if self.begins_line { title(rest, &rest[..length]) } else { None };
        let (kind, length) = title.map_or((kind, length), |length| (TokenKind::Title, length));
        let span = self.at..self.at + length;
        let begins_line = self.begins_line;
        self.begins_line = match kind {
            TokenKind::Space | TokenKind::Comment => begins_line || rest[..length].contains('\n'),
            _ => false,
        };
        self.at = span.end;
        Some(Token { kind, span, begins_line })
    }
}

/// The kind and length of the first token in a text.
fn token(rest: &str) -> Option<(TokenKind, usize)> {
    let first = rest.chars().next()?;
    let end_of_line = || rest.find('\n').unwrap_or(rest.len());
    let comment = |end: &str| match rest[2..].find(end) {
        Some(at) => (TokenKind::Comment, 2 + at + end.len()),
        None => (TokenKind::OpenComment, rest.len()),
    };
    Some(match first {
        _ if first.is_whitespace() => (TokenKind::Space, rest.find(|c: char| !c.is_whitespace()).unwrap_or(rest.len())),
        '/' if rest.starts_with("//") => (TokenKind::Comment, end_of_line()),
        '/' if rest.starts_with("/*") => comment("*/"),
        '(' if rest.starts_with("(*") => comment("*)"),
        '"' => match rest[1..].find(['"', '\n']) {
            Some(at) if rest.as_bytes()[1 + at] == b'"' => (TokenKind::QuotedName, at + 2),
            _ => (TokenKind::OpenQuote, end_of_line()),
        },
        '\'' => match text_length(rest) {
            Some(length) => (TokenKind::Text, length),
            None => (TokenKind::OpenQuote, end_of_line()),
        },
        ':' if rest.starts_with(":=") => (TokenKind::Assign, 2),
        _ if is_of_word(first) => (TokenKind::Word, word_length(rest)),
        _ => (TokenKind::Symbol, first.len_utf8()),
    })
}

fn is_of_word(character: char) -> bool {
    character.is_alphanumeric() || character == '_'
}

/// The length of a single-quoted string, in which `$` is the escape character.
fn text_length(rest: &str) -> Option<usize> {
    let mut is_escaped = false;
    for (at, byte) in rest.bytes().enumerate().skip(1) {
        match byte {
            b'\n' => return None,
            _ if is_escaped => is_escaped = false,
            b'$' => is_escaped = true,
            b'\'' => return Some(at + 1),
            _ => {}
        }
    }
    None
}

/// The length of a name or literal. A point is part of a number or a typed literal if a digit follows; a sign is part
/// of an exponent, or of a number after `#`.
fn word_length(rest: &str) -> usize {
    let is_number = rest.starts_with(|c: char| c.is_ascii_digit());
    let mut has_type = false;
    let mut previous = ' ';
    for (at, character) in rest.char_indices() {
        let digit_follows = || rest[at + 1..].starts_with(|c: char| c.is_ascii_digit());
        let belongs = match character {
            '#' if !has_type || previous.is_ascii_digit() => {
                has_type = true;
                true
            }
            '.' => (is_number || has_type) && previous.is_ascii_digit() && digit_follows(),
            '+' | '-' => previous == '#' || (is_number || has_type) && matches!(previous, 'e' | 'E') && digit_follows(),
            _ => is_of_word(character),
        };
        if !belongs {
            return at;
        }
        previous = character;
    }
    rest.len()
}

/// The length of the line if it starts with `TITLE =`.
fn title(rest: &str, word: &str) -> Option<usize> {
    let behind = &rest[word.len()..];
    let line =
        &behind[..if word.eq_ignore_ascii_case("TITLE") { behind.find('\n').unwrap_or(behind.len()) } else { 0 }];
    line.trim_start().starts_with('=').then_some(word.len() + line.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The tokens that the parser sees.
    fn tokens(text: &str) -> Vec<(TokenKind, &str)> {
        Lexer::new(text, 0..text.len())
            .filter(|token| !token.kind.is_trivia())
            .map(|token| (token.kind, &text[token.span]))
            .collect()
    }

    fn words(text: &str) -> Vec<&str> {
        tokens(text).into_iter().map(|(_, token)| token).collect()
    }

    #[test]
    fn numbers_and_literals_with_a_type_are_one_word() {
        for literal in
            ["2.000000e+001", "4.2E-1", "T#1.5S", "T#-20S", "W#16#6C00", "2#1010_0000", "REAL#-1.5e+3", "t#1m_30s"]
        {
            assert_eq!(tokens(literal), [(TokenKind::Word, literal)]);
        }
        assert_eq!(words("-4.2"), ["-", "4.2"]);
        assert_eq!(words("ARRAY[1..5]"), ["ARRAY", "[", "1", ".", ".", "5", "]"]);
        assert_eq!(words("A.GAIN:=2;"), ["A", ".", "GAIN", ":=", "2", ";"]);
        assert_eq!(words("1e+x"), ["1e", "+", "x"]);
        assert_eq!(words("#inst.GAIN"), ["#", "inst", ".", "GAIN"].map(|word| word));
    }

    #[test]
    fn comments_are_passed_over() {
        assert_eq!(words("a // b \" (*\nc (* d\n// e *) f /* g */ h"), ["a", "c", "f", "h"]);
        assert_eq!(tokens("a (* b"), [(TokenKind::Word, "a"), (TokenKind::OpenComment, "(* b")]);
    }

    #[test]
    fn a_title_goes_to_the_end_of_the_line() {
        assert_eq!(
            tokens("TITLE =50% \"of // it's (* all\r\nBEGIN"),
            [(TokenKind::Title, "TITLE =50% \"of // it's (* all\r"), (TokenKind::Word, "BEGIN")]
        );
        assert_eq!(words("TITLE := 5"), ["TITLE", ":=", "5"]);
        assert_eq!(words("title\n= 5"), ["title", "=", "5"]);
    }

    #[test]
    fn quotes_end_in_their_line() {
        assert_eq!(
            tokens("\"TIC 101\" 'it$'s'"),
            [(TokenKind::QuotedName, "\"TIC 101\""), (TokenKind::Text, "'it$'s'")]
        );
        assert_eq!(
            tokens("\"TIC\n'a\nb"),
            [(TokenKind::OpenQuote, "\"TIC"), (TokenKind::OpenQuote, "'a"), (TokenKind::Word, "b")]
        );
    }

    proptest! {
        #[test]
        fn the_tokens_of_any_text_are_the_text(text in "(?s).{0,200}|[ \n\"'#/(*)$:=;.TITLE12eä+-]{0,200}") {
            let mut end = 0;
            for token in Lexer::new(&text, 0..text.len()) {
                prop_assert_eq!(token.span.start, end);
                prop_assert!(token.span.end > end);
                end = token.span.end;
            }
            prop_assert_eq!(end, text.len());
        }
    }
}
