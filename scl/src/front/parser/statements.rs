//! Parses statements. After an error, parsing resumes with the next statement.

use super::{Failed, Parsed, Parser};
use crate::front::lexer::{Kind, Span};
use crate::front::syntax::{Binary, Expression, ExpressionKind, Label, Name, Statement, StatementKind};

/// The words that end a list of statements.
const ENDS: [&str; 18] = [
    "ELSE",
    "ELSIF",
    "END_CASE",
    "END_DATA_BLOCK",
    "END_FOR",
    "END_FUNCTION",
    "END_FUNCTION_BLOCK",
    "END_IF",
    "END_NETWORK",
    "END_ORGANIZATION_BLOCK",
    "END_REPEAT",
    "END_TYPE",
    "END_WHILE",
    "UNTIL",
    "FUNCTION",
    "FUNCTION_BLOCK",
    "DATA_BLOCK",
    "ORGANIZATION_BLOCK",
];

/// The maximum number of IF and ELSIF branches in a statement.
const MOST_ARMS: usize = 300;

impl Parser<'_> {
    /// Whether a list of statements ends at the current token.
    pub(crate) fn is_statement_end(&self) -> bool {
        self.token().kind == Kind::Word && (ENDS.contains(&self.word_ahead(0).as_str()) || self.is_misspelt_elsif())
    }

    fn is_misspelt_elsif(&self) -> bool {
        (self.is_word("ELSEIF") || self.is_word("ELIF")) && !matches!(self.symbol_ahead(1), ":=" | "." | "[")
    }

    /// Consumes the word that closes the construct started at `begin`.
    pub(crate) fn close(&mut self, word: &str, begin: Span) -> Parsed<()> {
        if self.takes_word(word) {
            return Ok(());
        }
        let line = self.text[..begin.start as usize].matches('\n').count() + 1;
        let what = word.trim_start_matches("END_");
        self.fail_with(word, Some(&format!("the {what} on line {line} is not closed")))
    }

    /// Parses statements up to a word that ends them or, in CASE, to the next label.
    pub(crate) fn statements(&mut self, is_case: bool) -> Vec<Statement> {
        let mut statements = Vec::new();
        while !self.is_end() && !self.is_statement_end() && !self.is_exhausted() {
            if is_case && self.is_case_label() {
                break;
            }
            let before = self.at;
            if self.takes(";") {
                continue;
            }
            let start = self.span();
            match self.deeper(Parser::statement) {
                Ok(kind) => statements.push(Statement { kind, span: start.to(self.before()) }),
                Err(Failed) => self.recover(),
            }
            if self.at == before {
                self.step();
            }
        }
        statements
    }

    /// Skips to the end of the statement, or to the start of an inner IF, CASE or loop.
    fn recover(&mut self) {
        while !self.is_end() && !self.is_statement_end() {
            let is_last = self.is_symbol(";");
            if !is_last && matches!(self.word_ahead(0).as_str(), "IF" | "CASE" | "FOR" | "WHILE" | "REPEAT") {
                return;
            }
            self.step();
            if is_last {
                return;
            }
        }
    }

    /// Whether a CASE label starts at the current token: a value followed by a colon, a comma or a range symbol.
    fn is_case_label(&self) -> bool {
        if self.symbol_ahead(1) == ":" && self.token().kind == Kind::Word {
            return !self.gotos.contains(self.text_of(self.token()));
        }
        for by in 0.. {
            let token = self.ahead(by);
            match token.kind {
                Kind::Literal | Kind::Text | Kind::Local | Kind::Quoted => {}
                Kind::Word if !matches!(self.symbol_ahead(by + 1), ":=" | "(") || by > 0 => {
                    if super::expressions::is_reserved(&self.word_ahead(by)) {
                        return false;
                    }
                }
                Kind::Symbol => match self.text_of(token) {
                    ":" | "," | ".." | "..." => return by > 0,
                    "." | "+" | "-" | "*" | "/" => {}
                    _ => return false,
                },
                _ => return false,
            }
        }
        false
    }

    fn statement(&mut self) -> Parsed<StatementKind> {
        let begin = self.span();
        let kind = match self.word_ahead(0).as_str() {
            "IF" => self.conditional()?,
            "CASE" => self.case()?,
            "FOR" => self.counting()?,
            "WHILE" => {
                self.step();
                let condition = self.expression_or_wrong(|parser| parser.is_word("DO"));
                self.expect_word("DO")?;
                let body = self.statements(false);
                self.close("END_WHILE", begin)?;
                StatementKind::While(condition, body)
            }
            "REPEAT" => {
                self.step();
                let body = self.statements(false);
                self.expect_word("UNTIL")?;
                let condition = self.expression_or_wrong(|parser| parser.is_word("END_REPEAT"));
                self.takes(";");
                self.expect_word("END_REPEAT")?;
                StatementKind::Repeat(body, condition)
            }
            "EXIT" => {
                self.step();
                StatementKind::Exit
            }
            "CONTINUE" => {
                self.step();
                StatementKind::Continue
            }
            "RETURN" => {
                self.step();
                let is_bare = self.is_symbol(";") || self.is_statement_end() || self.is_end();
                StatementKind::Return(if is_bare { None } else { Some(self.expression()?) })
            }
            "GOTO" => {
                self.step();
                StatementKind::Goto(self.name("a label")?)
            }
            "NETWORK" if self.symbol_ahead(1) != ":=" => {
                let message = "this block is in STL or LAD, not in SCL";
                self.refuse(self.span(), message, Some("rewrite it in SCL, or leave its file out"))?
            }
            _ if self.symbol_ahead(1) == ":" && self.token().kind == Kind::Word => {
                let name: Name = self.name("a label")?;
                self.step();
                return Ok(StatementKind::Label(name));
            }
            _ => self.assignment()?,
        };
        // TIA Portal requires a semicolon after END_IF and similar words, but the source is unambiguous without it.
        let is_block = self.word_before().starts_with("END_");
        if !self.takes(";") && !is_block && !self.is_statement_end() {
            return self.fail("`;`");
        }
        Ok(kind)
    }

    fn word_before(&self) -> String {
        crate::front::syntax::key(&self.text[self.before().range()])
    }

    fn assignment(&mut self) -> Parsed<StatementKind> {
        let mut targets = Vec::new();
        loop {
            let value = self.expression()?;
            let operator = match self.symbol_ahead(0) {
                ":=" => None,
                "+=" => Some(Binary::Add),
                "-=" => Some(Binary::Subtract),
                "*=" => Some(Binary::Multiply),
                "/=" => Some(Binary::Divide),
                "?=" => {
                    let help = "pass the variable itself, or ARRAY[*]";
                    return self.refuse(self.span(), "assignment attempts (?=) are not supported", Some(help));
                }
                _ if targets.is_empty() && matches!(self.tree.expressions[value].kind, ExpressionKind::Call(..)) => {
                    return Ok(StatementKind::Call(value));
                }
                _ if targets.is_empty() => {
                    let Expression { kind, span, .. } = &self.tree.expressions[value];
                    let (span, is_equal) = (*span, matches!(kind, ExpressionKind::Binary(Binary::Equal, ..)));
                    if is_equal && (self.is_symbol(";") || self.is_statement_end()) {
                        let message = "this comparison has no effect";
                        return self.refuse(span, message, Some("write := to assign"));
                    }
                    return self.fail("`:=`");
                }
                _ => return Ok(StatementKind::Assign(targets, value)),
            };
            self.step();
            targets.push((value, operator));
        }
    }

    fn conditional(&mut self) -> Parsed<StatementKind> {
        let begin = self.span();
        let mut arms = Vec::new();
        loop {
            // Skip IF or ELSIF.
            self.step();
            let condition = self.expression_or_wrong(|parser| parser.is_word("THEN"));
            self.expect_word("THEN")?;
            arms.push((condition, self.statements(false)));
            if self.is_misspelt_elsif() {
                // Report the misspelling, but parse it as ELSIF.
                let message = format!("SCL has no {}", self.word_ahead(0));
                let _ = self.refuse::<()>(self.span(), &message, Some("write ELSIF"));
            } else if !self.is_word("ELSIF") {
                break;
            }
            if arms.len() == MOST_ARMS {
                return self.refuse(self.span(), &format!("more than {MOST_ARMS} ELSIF branches"), Some("use CASE"));
            }
        }
        let otherwise = if self.takes_word("ELSE") { self.statements(false) } else { Vec::new() };
        self.close("END_IF", begin)?;
        Ok(StatementKind::If(arms, otherwise))
    }

    fn case(&mut self) -> Parsed<StatementKind> {
        let begin = self.span();
        self.step();
        let selector = self.expression_or_wrong(|parser| parser.is_word("OF"));
        self.expect_word("OF")?;
        let mut arms = Vec::new();
        while !self.is_end() && !self.is_statement_end() && !self.is_exhausted() {
            let mut labels = Vec::new();
            loop {
                let low = self.expression()?;
                let is_range = self.takes("..") || self.takes("...");
                labels.push(Label { low, high: if is_range { Some(self.expression()?) } else { None } });
                if !self.takes(",") {
                    break;
                }
            }
            self.expect(":")?;
            arms.push((labels, self.statements(true)));
        }
        let otherwise = if self.takes_word("ELSE") {
            self.takes(":");
            self.statements(false)
        } else {
            Vec::new()
        };
        self.close("END_CASE", begin)?;
        Ok(StatementKind::Case(selector, arms, otherwise))
    }

    fn counting(&mut self) -> Parsed<StatementKind> {
        let begin = self.span();
        self.step();
        let variable = self.expression()?;
        self.expect(":=")?;
        let first = self.expression()?;
        self.expect_word("TO")?;
        let last = self.expression()?;
        let step = if self.takes_word("BY") { Some(self.expression()?) } else { None };
        self.expect_word("DO")?;
        let body = self.statements(false);
        self.close("END_FOR", begin)?;
        Ok(StatementKind::For { variable, first, last, step, body })
    }
}
