//! Blocks, sections, members, types and start values.

use super::{Failed, Parsed, Parser};
use crate::front::lexer::{Kind, Span};
use crate::front::syntax::{
    Attribute, BlockKind, ExpressionKind, Member, Section, SectionKind, SourceBlock, Start, Tree, Type, TypeKind,
};

/// The keyword that starts a block, the block's kind, and the keyword that ends it.
const BLOCKS: [(&str, BlockKind, &str); 5] = [
    ("FUNCTION_BLOCK", BlockKind::FunctionBlock, "END_FUNCTION_BLOCK"),
    ("FUNCTION", BlockKind::Function, "END_FUNCTION"),
    ("DATA_BLOCK", BlockKind::DataBlock, "END_DATA_BLOCK"),
    ("TYPE", BlockKind::Type, "END_TYPE"),
    ("ORGANIZATION_BLOCK", BlockKind::OrganizationBlock, "END_ORGANIZATION_BLOCK"),
];

impl Parser<'_> {
    /// Parses the whole source: its blocks and its global variables.
    pub(crate) fn source(mut self) -> Tree {
        while !self.is_end() && !self.is_exhausted() {
            match self.block_kind() {
                Some((kind, end)) => self.block(kind, end),
                None if self.is_word("VAR_GLOBAL") => self.globals(),
                None => {
                    let _: Parsed<()> = self.fail("a block such as FUNCTION_BLOCK");
                    while !self.is_end() && self.block_kind().is_none() && !self.is_word("VAR_GLOBAL") {
                        self.step();
                    }
                }
            }
        }
        // Names with `#` or the attribute S7_Optimized_Access indicate TIA Portal's dialect.
        let has_mark = self.tokens.iter().any(|token| matches!(token.kind, Kind::Local));
        let has_attribute = self.attributes.iter().any(|span| self.text[span.range()].contains("S7_Optimized_Access"));
        let mut tree = self.tree;
        tree.is_tia = tree.is_tia || has_mark || has_attribute;
        tree
    }

    fn block_kind(&self) -> Option<(BlockKind, &'static str)> {
        let word = self.word_ahead(0);
        BLOCKS.iter().find(|(name, ..)| *name == word).map(|(_, kind, end)| (*kind, *end))
    }

    fn block(&mut self, kind: BlockKind, end: &str) {
        let from = self.end_before();
        let start = self.step().span;
        let is_quoted = self.token().kind == Kind::Quoted;
        self.gotos = self.jumps(end);
        let Ok(name) = self.numbered_name() else {
            return self.skip_block(end);
        };
        let mut block = SourceBlock::new(kind, name);
        let head = self.head(&mut block, start, is_quoted);
        if let Some(texts) = self.document {
            self.document_head(&mut block, texts, from, start.start);
        }
        let body = head.and_then(|protected| self.sections(&mut block, end).map(|()| protected));
        let Ok(protected) = body else {
            return self.skip_block(end);
        };
        self.takes_word("BEGIN");
        self.is_data = kind == BlockKind::DataBlock;
        block.body = match kind {
            _ if self.document.is_none() => self.statements(false),
            BlockKind::DataBlock | BlockKind::Type => self.document_starts(),
            _ => self.networks(&block),
        };
        let is_stray =
            |parser: &Self| parser.is_statement_end() && parser.block_kind().is_none() && !parser.is_word(end);
        while is_stray(self) && !self.is_exhausted() {
            let _: Parsed<()> = self.fail(&format!("a statement or {end}"));
            self.step();
            block.body.extend(self.statements(false));
        }
        if !self.is_exhausted() && !self.takes_word(end) {
            let _: Parsed<()> = self.fail(end);
        }
        self.takes(";");
        // A protected block has statements in its original source, but not in TIA Portal's export.
        let has_statements = !matches!(kind, BlockKind::DataBlock | BlockKind::Type);
        if let Some(span) = protected.filter(|_| has_statements && block.body.is_empty()) {
            self.tree.protected.push((self.tree.blocks.len(), span));
        }
        self.tree.extents.push(start.to(self.before()));
        self.tree.blocks.push(block);
    }

    fn skip_block(&mut self, end: &str) {
        while !self.is_end() && !self.is_word(end) && self.block_kind().is_none() {
            self.step();
        }
        self.takes_word(end);
        self.takes(";");
    }

    /// The labels of the GOTO statements between the current token and the word `end`.
    pub(crate) fn jumps(&self, end: &str) -> std::collections::BTreeSet<String> {
        let within = self.tokens[self.at..]
            .iter()
            .take_while(|token| token.kind != Kind::Word || !self.text_of(**token).eq_ignore_ascii_case(end));
        let words: Vec<&str> =
            within.filter(|token| token.kind == Kind::Word).map(|token| self.text_of(*token)).collect();
        words.windows(2).filter(|pair| pair[0].eq_ignore_ascii_case("GOTO")).map(|pair| pair[1].to_string()).collect()
    }

    /// Parses the header between the name and the first section; returns the location of KNOW_HOW_PROTECT, if present.
    fn head(&mut self, block: &mut SourceBlock, start: Span, is_quoted: bool) -> Parsed<Option<Span>> {
        let mut is_versioned = false;
        let mut protected = None;
        loop {
            let word = self.word_ahead(0);
            match (word.as_str(), self.symbol_ahead(1)) {
                ("AUTHOR" | "FAMILY" | "NAME", ":" | "=") => {
                    let line = self.line_of(self.span());
                    while !self.is_end() && self.line_of(self.span()) == line && !self.is_section() {
                        self.step();
                    }
                }
                ("VERSION" | "TITLE" | "CODE_VERSION1", ":" | "=") => {
                    is_versioned |= word == "VERSION";
                    self.step();
                    self.step();
                    self.step();
                    // `1.0.2`
                    while self.is_symbol(".") || self.token().kind == Kind::Literal {
                        self.step();
                    }
                    self.takes(";");
                }
                (
                    "NON_RETAIN" | "RETAIN" | "READ_ONLY" | "UNLINKED" | "STANDARD" | "CODE_VERSION1" | "DB_SPECIFIC",
                    _,
                ) => {
                    self.step();
                }
                ("KNOW_HOW_PROTECT", _) => protected = Some(self.step().span),
                _ if self.is_section() || self.is_end() || self.is_statement_end() => break,
                _ if self.is_symbol(":") && block.of.is_none() => {
                    self.step();
                    if block.kind != BlockKind::Type {
                        block.of = Some(self.type_of()?);
                    }
                }
                _ if self.is_symbol(";") => {
                    self.step();
                }
                _ if block.kind == BlockKind::DataBlock && block.of.is_none() => block.of = Some(self.type_of()?),
                // The type of a TYPE that is not a STRUCT.
                _ if block.kind == BlockKind::Type && block.of.is_none() => block.of = Some(self.type_of()?),
                // Statements without a preceding BEGIN.
                _ => break,
            }
        }
        let end = self.span().start;
        block.attributes = self.attributes_within(start.start, end);
        block.comment = self.comments_within(start.start, end);
        self.tree.is_tia |= is_versioned && is_quoted;
        Ok(protected)
    }

    fn line_of(&self, span: Span) -> usize {
        // A line is identified by its start offset.
        self.text[..span.start as usize].rfind('\n').map_or(0, |newline| newline + 1)
    }

    fn is_section(&self) -> bool {
        let word = self.word_ahead(0);
        let is_variable = word == "VAR" || word.starts_with("VAR_");
        is_variable || matches!(word.as_str(), "CONST" | "LABEL" | "BEGIN") || word == "STRUCT"
    }

    fn sections(&mut self, block: &mut SourceBlock, end: &str) -> Parsed<()> {
        while self.is_section() && !self.is_word("BEGIN") {
            let word = self.word_ahead(0);
            if word == "STRUCT" {
                let of = self.type_of()?;
                self.takes(";");
                match of.kind {
                    TypeKind::Struct(members) => {
                        block.sections.push(Section { kind: SectionKind::Static, is_retained: false, members });
                    }
                    _ => return Err(Failed),
                }
                continue;
            }
            let at = self.step().span;
            if word == "LABEL" {
                while !self.is_end() && !self.takes_word("END_LABEL") && !self.is_word(end) {
                    let token = self.step();
                    self.gotos.insert(self.text_of(token).to_string());
                }
                self.takes(";");
                continue;
            }
            let mut kind = match word.as_str() {
                "VAR_INPUT" => SectionKind::Input,
                "VAR_OUTPUT" => SectionKind::Output,
                "VAR_IN_OUT" => SectionKind::InOut,
                "VAR" | "VAR_STATIC" => SectionKind::Static,
                "VAR_TEMP" => SectionKind::Temp,
                "CONST" => SectionKind::Constant,
                "VAR_CONSTANT" if self.document.is_some() => SectionKind::Constant,
                _ => {
                    let message = format!("{word} is not a valid section of a block");
                    self.refuse(at, &message, Some("declare the variable in a data block"))?
                }
            };
            let mut is_retained = false;
            while matches!(self.word_ahead(0).as_str(), "RETAIN" | "NON_RETAIN" | "DB_SPECIFIC" | "CONSTANT")
                && self.symbol_ahead(1) != ":"
            {
                match self.word_ahead(0).as_str() {
                    "CONSTANT" => kind = SectionKind::Constant,
                    "RETAIN" => is_retained = true,
                    _ => {}
                }
                self.step();
            }
            let close = if word == "CONST" { "END_CONST" } else { "END_VAR" };
            let members = self.members(close);
            self.takes(";");
            block.sections.push(Section { kind, is_retained, members });
        }
        Ok(())
    }

    /// Parses members up to the closing word, which is consumed.
    pub(crate) fn members(&mut self, close: &str) -> Vec<Member> {
        let mut members = Vec::new();
        while !self.takes_word(close) {
            if self.is_end() || self.is_exhausted() || self.block_kind().is_some() && self.symbol_ahead(1) != ":" {
                let _: Parsed<()> = self.fail(close);
                break;
            }
            if self.takes(";") {
                continue;
            }
            let before = self.at;
            match self.deeper(|parser| parser.member(close)) {
                Ok(member) => members.push(member),
                Err(Failed) => {
                    while !self.is_end() && !self.is_word(close) && !self.is_word("END_VAR") && !self.takes(";") {
                        self.step();
                    }
                }
            }
            if self.at == before {
                if self.is_word("END_VAR") || self.is_word("END_STRUCT") {
                    break;
                }
                self.step();
            }
        }
        members
    }

    fn member(&mut self, close: &str) -> Parsed<Member> {
        let (from, start) = (self.end_before(), self.span());
        let mut names = vec![self.name("a name")?];
        while self.takes(",") {
            names.push(self.name("a name")?);
        }
        let at = if self.is_word("AT") { self.step_and(|parser| parser.place().map(Some))? } else { None };
        let mut attributes: Vec<Attribute> = self.attributes_within(start.start, self.span().start);
        let of = if self.takes(":") {
            Some(self.type_of()?)
        } else if close == "END_CONST" && self.is_symbol(":=") {
            None
        } else {
            return self.fail("`:`");
        };
        let is_started = self.takes(":=") || close == "END_CONST" && self.takes("=");
        let start_value = if is_started { Some(self.start_list()?) } else { None };
        attributes.extend(self.attributes_within(self.before().end, self.span().start));
        let end = self.before();
        if !self.takes(";") && !self.is_word(close) {
            return self.fail("`;`");
        }
        let line_end =
            self.text[end.end as usize..].find('\n').map_or(self.text.len(), |length| end.end as usize + length);
        // The members of a structure have their own comments.
        let is_structure = matches!(of, Some(Type { kind: TypeKind::Struct(_), .. }));
        let comment = self.comments_within(if is_structure { end.end } else { start.start }, line_end as u32);
        let mut member = Member { names, attributes, at, of, start: start_value, comment };
        if let Some(texts) = self.document {
            self.document_member(&mut member, texts, from, start.start);
        }
        Ok(member)
    }

    fn step_and<T>(&mut self, parse: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        self.step();
        parse(self)
    }

    pub(crate) fn type_of(&mut self) -> Parsed<Type> {
        let start = self.span();
        let kind = self.deeper(Parser::type_kind)?;
        Ok(Type { kind, span: start.to(self.before()) })
    }

    fn type_kind(&mut self) -> Parsed<TypeKind> {
        let is_quoted = self.takes_global() || self.token().kind == Kind::Quoted;
        match self.word_ahead(0).as_str() {
            "ARRAY" => {
                self.step();
                self.expect("[")?;
                let mut bounds = Vec::new();
                loop {
                    if self.takes("*") {
                        bounds.push(None);
                    } else {
                        let low = self.expression()?;
                        if !self.takes("..") && !self.takes("...") {
                            return self.fail("`..`");
                        }
                        bounds.push(Some([low, self.expression()?]));
                    }
                    if !self.takes(",") {
                        break;
                    }
                }
                self.expect("]")?;
                self.expect_word("OF")?;
                Ok(TypeKind::Array(bounds, Box::new(self.type_of()?)))
            }
            "STRUCT" => {
                self.step();
                Ok(TypeKind::Struct(self.members("END_STRUCT")))
            }
            word @ ("STRING" | "WSTRING") => {
                self.step();
                let length = if self.takes("[") {
                    let length = self.expression()?;
                    self.expect("]")?;
                    Some(length)
                } else {
                    None
                };
                Ok(TypeKind::Text { is_wide: word == "WSTRING", length })
            }
            "REF_TO" | "POINTER" if self.ahead(1).kind != Kind::Symbol => {
                self.step();
                self.takes_word("TO");
                self.type_of()?;
                Ok(TypeKind::Reference)
            }
            _ => {
                let name = self.numbered_name()?;
                Ok(TypeKind::Name { name: name.text, is_quoted })
            }
        }
    }

    /// Parses a start value. In STEP 7, the values of an array may be listed without brackets.
    fn start_list(&mut self) -> Parsed<Start> {
        let start = self.span();
        let first = self.start_value()?;
        if !self.is_symbol(",") {
            return Ok(first);
        }
        let mut list = vec![first];
        while self.takes(",") {
            list.push(self.start_value()?);
        }
        Ok(Start::List(list, start.to(self.before())))
    }

    fn start_value(&mut self) -> Parsed<Start> {
        self.deeper(|parser| match parser.symbol_ahead(0) {
            "[" => parser.bracketed("]"),
            "(" => parser.bracketed(")"),
            _ => parser.plain_start(),
        })
    }

    fn plain_start(&mut self) -> Parsed<Start> {
        let is_repeat = self.token().kind == Kind::Literal && self.symbol_ahead(1) == "(";
        if is_repeat {
            let token = self.step();
            let text = self.text_of(token).to_string();
            let count = self.add(ExpressionKind::Literal(text), self.before());
            return self.repeated(count);
        }
        let value = self.expression()?;
        if let ExpressionKind::Call(count, arguments) = &self.tree.expressions[value].kind {
            // `"N"(0)`: the constant is the number of repetitions.
            let is_repeat = arguments.len() == 1 && arguments[0].name.is_none();
            if let (true, ExpressionKind::Name(..)) = (is_repeat, &self.tree.expressions[*count].kind) {
                return Ok(Start::Repeat(*count, vec![Start::Value(arguments[0].value)]));
            }
        }
        Ok(Start::Value(value))
    }

    fn repeated(&mut self, count: crate::front::syntax::ExpressionId) -> Parsed<Start> {
        match self.bracketed(")")? {
            Start::List(list, _) => Ok(Start::Repeat(count, list)),
            other => Ok(Start::Repeat(count, vec![other])),
        }
    }

    /// Parses the values of an array or the members of a structure, in brackets. An expression in brackets becomes a
    /// list of one value.
    fn bracketed(&mut self, close: &str) -> Parsed<Start> {
        let start = self.step().span;
        let mut list = Vec::new();
        let mut members = Vec::new();
        while !self.takes(close) {
            if self.symbol_ahead(1) == ":=" {
                let name = self.name("a member")?;
                self.step();
                members.push((name, self.start_value()?));
            } else {
                list.push(self.start_value()?);
            }
            if !self.takes(",") && !self.is_symbol(close) {
                return self.fail(&format!("`,` or `{close}`"));
            }
        }
        let span = start.to(self.before());
        if !members.is_empty() {
            return Ok(Start::Members(members, span));
        }
        Ok(Start::List(list, span))
    }
}
