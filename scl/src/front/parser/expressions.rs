//! Parses expressions by operator precedence.

use super::{Failed, Parsed, Parser, bare};
use crate::front::lexer::{Kind, Span};
use crate::front::syntax::{Argument, Binary, ExpressionId, ExpressionKind, Name, Scope, Unary, key};

/// The precedence of `**`, the highest of all operators.
const HIGHEST: u8 = 8;

/// The maximum number of operators in a chain.
const MOST_LEVELS: u32 = 300;

/// The reserved words: without quotation marks, they are not names in an expression.
const RESERVED: [&str; 41] = [
    "AND",
    "BEGIN",
    "BY",
    "CASE",
    "CONTINUE",
    "DIV",
    "DO",
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
    "END_STRUCT",
    "END_TYPE",
    "END_VAR",
    "END_WHILE",
    "EXIT",
    "FOR",
    "FUNCTION",
    "FUNCTION_BLOCK",
    "GOTO",
    "IF",
    "MOD",
    "NOT",
    "OF",
    "OR",
    "REPEAT",
    "RETURN",
    "THEN",
    "TO",
    "UNTIL",
    "VAR",
    "WHILE",
    "XOR",
    "DATA_BLOCK",
];

/// Whether an upper-case word is reserved.
pub(super) fn is_reserved(word: &str) -> bool {
    RESERVED.contains(&word)
}

impl Parser<'_> {
    pub(crate) fn expression(&mut self) -> Parsed<ExpressionId> {
        self.above(0)
    }

    /// The operator at the current token, and its precedence.
    fn operator(&self) -> Option<(Binary, u8)> {
        let operator = match self.token().kind {
            Kind::Symbol => match self.symbol_ahead(0) {
                "**" => (Binary::Power, HIGHEST),
                "*" => (Binary::Multiply, 7),
                "/" => (Binary::Divide, 7),
                "+" => (Binary::Add, 6),
                "-" => (Binary::Subtract, 6),
                "<" => (Binary::Less, 5),
                ">" => (Binary::Greater, 5),
                "<=" => (Binary::LessOrEqual, 5),
                ">=" => (Binary::GreaterOrEqual, 5),
                "=" => (Binary::Equal, 4),
                "<>" => (Binary::NotEqual, 4),
                "&" => (Binary::And, 3),
                _ => return None,
            },
            Kind::Word => match self.word_ahead(0).as_str() {
                "MOD" => (Binary::Modulo, 7),
                "DIV" => (Binary::Divide, 7),
                "AND" => (Binary::And, 3),
                "XOR" => (Binary::Xor, 2),
                "OR" => (Binary::Or, 1),
                _ => return None,
            },
            _ => return None,
        };
        Some(operator)
    }

    /// Parses an expression whose operators have a precedence higher than `strength`.
    fn above(&mut self, strength: u8) -> Parsed<ExpressionId> {
        let is_signed = matches!(self.symbol_ahead(0), "-" | "+");
        let mut left = self.operand()?;
        while let Some((operator, own)) = self.operator().filter(|(_, own)| *own > strength) {
            if operator == Binary::Power && is_signed {
                let span = self.tree.expressions[left].span.to(self.span());
                let message = "a sign before `**` is ambiguous: manuals disagree on its precedence";
                return self.refuse(span, message, Some("write -(a ** b) or (-a) ** b"));
            }
            self.step();
            let right = self.deeper(|parser| parser.above(own))?;
            left = self.binary(operator, left, right);
            self.check_depth(left)?;
        }
        Ok(left)
    }

    /// Parses an operand with any signs and NOT before it.
    fn operand(&mut self) -> Parsed<ExpressionId> {
        let start = self.span();
        let unary = match self.symbol_ahead(0) {
            "-" => Unary::Minus,
            "+" => Unary::Plus,
            _ if self.is_word("NOT") => Unary::Not,
            _ => return self.primary(),
        };
        self.step();
        let operand = self.deeper(Parser::operand)?;
        Ok(self.add(ExpressionKind::Unary(unary, operand), start))
    }

    pub(crate) fn primary(&mut self) -> Parsed<ExpressionId> {
        let start = self.span();
        let is_global = self.takes_global();
        let token = self.token();
        let text = self.text_of(token);
        match token.kind {
            _ if is_global && !matches!(token.kind, Kind::Word | Kind::Quoted) => self.fail("a name"),
            Kind::Literal | Kind::Text => {
                self.step();
                Ok(self.add(ExpressionKind::Literal(text.to_string()), start))
            }
            Kind::Percent => {
                self.step();
                self.takes_peripheral();
                Ok(self.add(ExpressionKind::Address(text.to_string()), start))
            }
            Kind::Symbol if text == "(" => {
                self.step();
                let inner = self.deeper(Parser::expression)?;
                self.expect(")")?;
                Ok(inner)
            }
            Kind::Symbol if text == "[" && self.is_data => {
                let name = Name { text: "THIS".to_string(), span: start };
                let array = self.add(ExpressionKind::Name(Scope::Bare, name), start);
                self.steps_of(array, start, true)
            }
            Kind::Word if is_reserved(&self.word_ahead(0)) => self.fail("an expression"),
            Kind::Word | Kind::Local | Kind::Quoted => {
                let name = self.numbered_name()?;
                let scope = match token.kind {
                    _ if is_global => Scope::Global,
                    Kind::Local => Scope::Local,
                    Kind::Quoted => Scope::Global,
                    _ => Scope::Bare,
                };
                if scope == Scope::Global {
                    self.takes_peripheral();
                }
                let variable = self.add(ExpressionKind::Name(scope, name), start);
                self.steps_of(variable, start, true)
            }
            _ => self.fail("an expression"),
        }
    }

    /// Consumes `:P` in `"Tag":P`, which accesses the I/O directly. Without a process image, this is the tag itself.
    fn takes_peripheral(&mut self) {
        let [colon, word] = [self.ahead(0), self.ahead(1)];
        let is_close = colon.span.start == self.before().end && word.span.start == colon.span.end;
        if is_close && self.is_symbol(":") && self.word_ahead(1) == "P" {
            self.step();
            self.step();
        }
    }

    /// Parses a name; in STEP 7, a block may be named by its number: `FB 12`.
    pub(crate) fn numbered_name(&mut self) -> Parsed<Name> {
        let mut name = self.name("a name")?;
        let token = self.token();
        let is_kind = matches!(key(&name.text).as_str(), "FB" | "FC" | "DB" | "UDT" | "OB" | "SFB" | "SFC");
        if is_kind && token.kind == Kind::Literal && self.text_of(token).bytes().all(|byte| byte.is_ascii_digit()) {
            name.text.push_str(self.text_of(token));
            name.span = name.span.to(token.span);
            self.step();
        }
        Ok(name)
    }

    /// Parses the callee of an element: a name followed by members and indices, up to the bracket that opens the pins.
    /// Reserved words of SCL are valid names here.
    pub(crate) fn callee(&mut self) -> Parsed<ExpressionId> {
        let start = self.span();
        let is_global = self.takes_global();
        let scope = match self.token().kind {
            Kind::Local => Scope::Local,
            Kind::Word if !is_global => Scope::Bare,
            _ => Scope::Global,
        };
        let name = self.name("an element")?;
        let variable = self.add(ExpressionKind::Name(scope, name), start);
        self.steps_of(variable, start, false)
    }

    /// Parses the members, indices and, if allowed, calls that follow a variable.
    fn steps_of(&mut self, mut variable: ExpressionId, start: Span, may_call: bool) -> Parsed<ExpressionId> {
        loop {
            match self.symbol_ahead(0) {
                "." => {
                    self.step();
                    let token = self.token();
                    let name = match token.kind {
                        Kind::Word | Kind::Quoted | Kind::Percent | Kind::Literal | Kind::Local => self.step(),
                        _ => return self.fail("a member name"),
                    };
                    let name = Name { text: bare(self.text_of(name)).to_string(), span: name.span };
                    variable = self.add(ExpressionKind::Member(variable, name), start);
                }
                "[" => {
                    self.step();
                    let mut indices = vec![self.deeper(Parser::expression)?];
                    while self.takes(",") {
                        indices.push(self.deeper(Parser::expression)?);
                    }
                    self.expect("]")?;
                    variable = self.add(ExpressionKind::Index(variable, indices), start);
                }
                "(" if may_call => {
                    self.step();
                    let arguments = self.deeper(Parser::arguments)?;
                    variable = self.add(ExpressionKind::Call(variable, arguments), start);
                }
                "^" => {
                    self.step();
                    variable = self.add(ExpressionKind::Pointer(variable), start);
                }
                _ => return Ok(variable),
            }
            self.check_depth(variable)?;
        }
    }

    /// Rejects long chains: `a + b + c` nests one level deeper with each operator.
    fn check_depth(&mut self, id: ExpressionId) -> Parsed<()> {
        if self.tree.expressions[id].depth <= MOST_LEVELS {
            return Ok(());
        }
        let message = format!("this expression has more than {MOST_LEVELS} chained operators");
        self.refuse(self.before(), &message, Some("split it into several assignments"))
    }

    /// Parses the arguments of a call, including the closing bracket.
    fn arguments(&mut self) -> Parsed<Vec<Argument>> {
        let mut arguments = Vec::new();
        while !self.takes(")") {
            let start = self.span();
            let is_name = matches!(self.token().kind, Kind::Word | Kind::Quoted | Kind::Local);
            let named = matches!(self.symbol_ahead(1), ":=" | "=>") && is_name;
            let name = if named { Some(self.name("a parameter")?) } else { None };
            let is_output = self.symbol_ahead(0) == "=>";
            if named {
                self.step();
            }
            // `x := ,` and `x => )`: the parameter is listed but not connected.
            if named && matches!(self.symbol_ahead(0), "," | ")") {
                self.takes(",");
                continue;
            }
            let value = self.expression()?;
            arguments.push(Argument { name, is_output, value, span: start.to(self.before()) });
            if !self.takes(",") && !self.is_symbol(")") {
                return self.fail("`,` or `)`");
            }
        }
        Ok(arguments)
    }

    /// Parses an expression. After an error, skips to the semicolon or to where `is_end` holds, so that the rest of the
    /// statement can be parsed.
    pub(crate) fn expression_or_wrong(&mut self, is_end: impl Fn(&Self) -> bool) -> ExpressionId {
        let start = self.span();
        match self.expression() {
            Ok(expression) => expression,
            Err(Failed) => {
                while !self.is_end() && !self.is_symbol(";") && !is_end(self) && !self.is_statement_end() {
                    self.step();
                }
                self.add(ExpressionKind::Wrong, start)
            }
        }
    }
}
