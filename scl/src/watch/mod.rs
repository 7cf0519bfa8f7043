//! The watchable parts of a running program: the variables named in each line, the block that a line belongs to, its
//! networks as drawn, and the operands that decide a condition.
//!
//! This is derived from the source text alone, so it is available even for a program with errors. Paths have the form
//! of the FMU's variable names, `motors[1].fault`; an index that is not constant is replaced by the path of its
//! variable, `motors[i].fault`.

mod decide;
mod network;

pub(crate) use decide::terms;
pub use decide::{Decision, Influence, Logic};
pub use network::{Element, From, Input, Network, Operand, Output, Shape};

use crate::front::lexer::Span;
use crate::front::syntax::{
    Argument, Binary, BlockKind, ExpressionId, ExpressionKind, Expressions, Member, Scope, SectionKind, SourceBlock,
    Start, Statement, StatementKind, TypeKind, Unary,
};
use crate::front::{self, Format};
use crate::report::Report;
use parameters::{Source, literal};
use std::collections::HashMap;

/// The maximum depth to which the temporaries of networks are resolved.
const DEEPEST: usize = 20;

/// A block with code.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CodeBlock {
    /// The index of its source.
    pub file: usize,
    /// Its name.
    pub name: String,
    /// Whether it is an organization block.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub is_organization: bool,
    /// The comment in its header.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub comment: String,
    /// Its first line (1-based).
    pub line: usize,
    /// The variables named in its lines, in source order.
    pub names: Vec<Named>,
    /// The instances it calls.
    pub calls: Vec<Called>,
    /// The writes to variables, in source order.
    pub writes: Vec<Write>,
    /// Its temporaries: name, and type as written.
    pub temps: Vec<(String, String)>,
    /// Its constants: name, and value as written.
    pub constants: Vec<(String, String)>,
    /// The declarations of its variables and constants: name, and 1-based line number.
    pub declared: Vec<(String, usize)>,
    /// Its networks in LAD and FBD.
    pub networks: Vec<Network>,
}

/// A variable named in a line.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Named {
    /// The 1-based line number.
    pub line: usize,
    /// The variable, as the FMU names it; an index may be the path of another variable.
    pub path: String,
    /// Whether it is global, as in `"DB".x`. A name with neither quotation marks nor `#` may be either.
    pub is_global: bool,
}

/// A statement that writes a variable.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Write {
    /// The variable written; for a call, the instance whose members it writes.
    pub path: String,
    /// Whether the variable is global.
    pub is_global: bool,
    /// The 1-based line number whose execution indicates that the write happened.
    pub line: usize,
    /// The text of the statement.
    pub text: String,
    /// The variables from which the value is computed.
    pub reads: Vec<Named>,
    /// The formula of the value, if it is a truth value.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub logic: Option<Logic>,
    /// The conditions under which the statement runs, outermost first.
    pub guards: Vec<Guard>,
}

/// A condition under which statements run.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Guard {
    /// The kind of statement that the condition belongs to.
    #[cfg_attr(feature = "typescript", ts(type = "\"if\" | \"case\" | \"while\" | \"until\""))]
    pub of: Guarding,
    /// Its 1-based line number.
    pub line: usize,
    /// Its text.
    pub text: String,
    /// Whether the guarded statements run if it is FALSE.
    pub is_negated: bool,
    /// The variables it names.
    pub reads: Vec<Named>,
    /// The formula of the condition; for CASE, whether the arm is selected. For a loop, it refers to the last
    /// iteration.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub logic: Option<Logic>,
}

/// The kind of statement that a condition belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Guarding {
    /// IF and ELSIF.
    If,
    /// The selector of a CASE.
    Case,
    /// WHILE.
    While,
    /// REPEAT: the body runs at least once, and again while the condition is FALSE.
    Until,
}

/// A call to an instance.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Called {
    /// The instance.
    pub instance: String,
    /// The arguments.
    pub arguments: Vec<Passed>,
}

/// An argument of a call.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Passed {
    /// The formal parameter.
    pub formal: String,
    /// The variable passed; `None` for a computed value.
    pub path: Option<String>,
    /// The literal passed, as written.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub literal: Option<String>,
    /// The 1-based line number.
    pub line: usize,
}

/// The default time between two calls in milliseconds, for sources that do not specify it.
const CYCLE: u32 = 100;

/// The time between two calls in milliseconds suggested by the sources, and why. This is the OB's period, which is not
/// part of the sources but is often noted in them.
pub fn proposed_cycle(blocks: &[CodeBlock]) -> (u32, String) {
    let milliseconds = |text: &str| {
        let plain = text.trim_start_matches(['T', 't', 'I', 'i', 'M', 'm', 'E', 'e', '#']);
        let nanoseconds = literal::duration(plain, 1).ok()?;
        u32::try_from(nanoseconds / 1_000_000).ok().filter(|time| (1..=3_600_000).contains(time))
    };
    for block in blocks.iter().filter(|block| block.is_organization) {
        // "every 100 ms" as well as "100ms".
        let joined = block.comment.replace(" ms", "ms").replace(" s ", "s ");
        let words = joined.split(|c: char| c.is_whitespace() || matches!(c, ',' | ';' | '(' | ')' | ':' | '"'));
        if let Some(time) = words
            .filter(|word| word.starts_with(|c: char| c.is_ascii_digit()))
            .find_map(|word| milliseconds(word.trim_end_matches('.')))
        {
            return (time, format!("the comment on {}", block.name));
        }
    }
    let is_cycle = |name: &str| name.eq_ignore_ascii_case("CYCLE");
    for block in blocks {
        let constant = block.constants.iter().find(|(name, _)| is_cycle(name));
        if let Some(time) = constant.and_then(|(_, value)| milliseconds(value)) {
            return (time, format!("the constant CYCLE in {}", block.name));
        }
    }
    for block in blocks {
        for call in &block.calls {
            let passed = call.arguments.iter().find(|of| is_cycle(&of.formal));
            if let Some(time) = passed.and_then(|of| milliseconds(of.literal.as_ref()?)) {
                return (time, format!("the CYCLE that {} passes to {}", block.name, call.instance));
            }
        }
    }
    (CYCLE, "no source specifies one: enter the period of the OB that calls the program".into())
}

/// Global declarations outside blocks with code: data blocks and tags, each with its name, the index of its source and
/// its 1-based line number.
pub fn declared_for_all(sources: &[Source]) -> Vec<(String, usize, usize)> {
    let trees = front::trees(sources, &mut Report::default());
    let mut found = Vec::new();
    for ((file, source), tree) in sources.iter().enumerate().zip(&trees) {
        let blocks = tree.blocks.iter().filter(|block| block.kind == BlockKind::DataBlock).map(|block| &block.name);
        let tags = tree.globals.iter().flat_map(|section| &section.members).flat_map(|member| &member.names);
        found.extend(blocks.chain(tags).map(|name| (name.text.clone(), file, source.place(name.span.range()).line)));
    }
    found
}

/// The blocks with code in these sources.
pub fn watched(sources: &[Source]) -> Vec<CodeBlock> {
    let mut found = Vec::new();
    let trees = front::trees(sources, &mut Report::default());
    for ((file, source), tree) in sources.iter().enumerate().zip(&trees) {
        for (number, block) in tree.blocks.iter().enumerate() {
            let is_data = matches!(block.kind, BlockKind::Type | BlockKind::DataBlock);
            if is_data || tree.instantiated.contains(&number) {
                continue;
            }
            let networks = tree.networks.iter().filter(|(of, _)| *of == number);
            let networks = networks.map(|(_, of)| network::drawn(of, &tree.expressions, source));
            let begun = CodeBlock { networks: networks.collect(), ..start(file, source, block, &tree.expressions) };
            let mut reader = Reader {
                source,
                expressions: &tree.expressions,
                found: begun,
                guards: Vec::new(),
                temporaries: HashMap::new(),
                depth: 0,
            };
            reader.statements(&block.body);
            found.push(reader.found);
        }
    }
    found
}

fn start(file: usize, source: &Source, block: &SourceBlock, expressions: &Expressions) -> CodeBlock {
    let written = |span: Span| source.text[span.range()].to_string();
    let of_kind = |kind: SectionKind| {
        let sections = block.sections.iter().filter(move |section| section.kind == kind);
        sections.flat_map(|section| &section.members)
    };
    let each = |member: &Member, text: String| {
        member.names.iter().map(|name| (name.text.clone(), text.clone())).collect::<Vec<_>>()
    };
    let temps = of_kind(SectionKind::Temp).filter_map(|member| match member.of.as_ref()?.kind {
        TypeKind::Name { ref name, .. } => Some(each(member, name.to_uppercase())),
        _ => None,
    });
    let is_xml = Format::detect(&source.text) == Format::SimaticMl;
    let constants = of_kind(SectionKind::Constant).filter_map(|member| match member.start {
        Some(Start::Value(value)) if is_xml => Some(each(member, self::written(expressions, &HashMap::new(), value))),
        // The text between the `:=` and the semicolon of the declaration.
        Some(Start::Value(_)) => {
            let name = member.names.first()?;
            let rest = written(Span { start: name.span.end, end: source.text.len() as u32, ..name.span });
            let value = rest.split_once(":=")?.1.split(';').next()?.trim().to_string();
            Some(each(member, value))
        }
        _ => None,
    });
    let names = block.sections.iter().flat_map(|section| &section.members).flat_map(|member| &member.names);
    CodeBlock {
        file,
        declared: names.map(|name| (name.text.clone(), source.place(name.span.range()).line)).collect(),
        name: block.name.text.clone(),
        is_organization: block.kind == BlockKind::OrganizationBlock,
        comment: block.comment.clone(),
        line: source.place(block.name.span.range()).line,
        temps: temps.flatten().collect(),
        constants: constants.flatten().collect(),
        ..CodeBlock::default()
    }
}

/// Collects the contents of a block.
struct Reader<'a> {
    source: &'a Source,
    expressions: &'a Expressions,
    found: CodeBlock,
    /// The conditions that enclose the current statement.
    guards: Vec<Guard>,
    /// The expressions assigned to the temporaries of networks, by name.
    temporaries: HashMap<String, ExpressionId>,
    /// The number of nested temporaries that are being resolved.
    depth: usize,
}

impl Reader<'_> {
    fn line(&self, span: Span) -> usize {
        self.source.place(span.range()).line
    }

    fn statements(&mut self, statements: &[Statement]) {
        for statement in statements {
            match &statement.kind {
                StatementKind::Assign(targets, value) => {
                    targets.iter().for_each(|(target, _)| self.expression(*target));
                    self.expression(*value);
                    self.assignment(targets.iter().map(|(target, operator)| (*target, operator.is_some())), *value);
                }
                StatementKind::Call(call) => match &self.expressions[*call].kind {
                    ExpressionKind::Call(callee, arguments) => {
                        let instance = self.path(*callee);
                        self.call(instance.clone(), arguments);
                        self.writes_of_call(*call, instance, arguments);
                    }
                    _ => self.expression(*call),
                },
                StatementKind::If(arms, rest) => {
                    let outer = self.guards.len();
                    for (condition, body) in arms {
                        self.guard(Guarding::If, *condition);
                        self.statements(body);
                        // The following branches run only if this condition is FALSE.
                        self.guards.last_mut().into_iter().for_each(|guard| guard.is_negated = true);
                    }
                    self.statements(rest);
                    self.guards.truncate(outer);
                }
                StatementKind::Case(selector, arms, rest) => {
                    self.expression(*selector);
                    let guard = self.condition(Guarding::Case, *selector);
                    let first: Vec<_> = arms.iter().filter_map(|(labels, _)| Some(labels.first()?.low)).collect();
                    for (labels, body) in arms {
                        let logic = labels.first().map(|label| Logic::of_arms(&[label.low], guard.reads.len()));
                        self.under(Guard { logic, ..guard.clone() }, body);
                    }
                    let logic = Some(Logic::of_arms(&first, guard.reads.len()));
                    self.under(Guard { logic, is_negated: true, ..guard }, rest);
                }
                StatementKind::For { variable, first, last, step, body } => {
                    [variable, first, last].into_iter().chain(step).for_each(|of| self.expression(*of));
                    self.statements(body);
                }
                StatementKind::While(condition, body) => {
                    self.guard(Guarding::While, *condition);
                    self.statements(body);
                    self.guards.pop();
                }
                StatementKind::Repeat(body, condition) => {
                    let guard = self.condition(Guarding::Until, *condition);
                    self.under(Guard { is_negated: true, ..guard }, body);
                    self.expression(*condition);
                }
                StatementKind::Return(value) => value.iter().for_each(|value| self.expression(*value)),
                StatementKind::Let(name, _, value) => {
                    value.iter().for_each(|value| self.expression(*value));
                    self.temporaries.extend(value.map(|value| (name.text.clone(), value)));
                }
                StatementKind::Exit
                | StatementKind::Continue
                | StatementKind::Goto(_)
                | StatementKind::Label(_)
                | StatementKind::Comment(_) => {}
            }
        }
    }

    /// The source text of a span or, in a block with networks, the drawn expressions in SCL.
    fn text(&self, span: Span, drawn: &[ExpressionId]) -> String {
        if self.found.networks.is_empty() {
            return self.source.text.get(span.range()).unwrap_or_default().to_string();
        }
        let written = |id: &ExpressionId| self::written(self.expressions, &self.temporaries, *id);
        drawn.iter().map(written).collect::<Vec<_>>().join(" := ")
    }

    /// Returns the variables in expressions without adding them to the block's names.
    fn reads(&mut self, of: impl IntoIterator<Item = ExpressionId>) -> Vec<Named> {
        let noted = std::mem::take(&mut self.found.names);
        of.into_iter().for_each(|id| self.expression(id));
        std::mem::replace(&mut self.found.names, noted)
    }

    /// Adds a condition that guards the statements read next.
    fn guard(&mut self, of: Guarding, condition: ExpressionId) {
        self.expression(condition);
        let guard = self.condition(of, condition);
        self.guards.push(guard);
    }

    fn condition(&mut self, of: Guarding, condition: ExpressionId) -> Guard {
        let span = self.expressions[condition].span;
        let reads = self.reads([condition]);
        let text = self.text(span, &[condition]);
        let logic = self.logic(condition, &reads);
        Guard { of, line: self.line(span), text, is_negated: false, reads, logic }
    }

    /// Reads statements that run under a condition.
    fn under(&mut self, guard: Guard, body: &[Statement]) {
        self.guards.push(guard);
        self.statements(body);
        self.guards.pop();
    }

    /// Reads an assignment such as `a := b += c`; the operator `+=` also reads its target. The recorded line is the one
    /// with the assigned value, because execution is recorded there: in a network or a long assignment, the target may
    /// be in another line.
    fn assignment(&mut self, targets: impl Iterator<Item = (ExpressionId, bool)> + Clone, value: ExpressionId) {
        let of_targets = targets.clone().filter(|(_, is_read)| *is_read).map(|(target, _)| target);
        let reads = self.reads(of_targets.chain([value]));
        let logic = self.logic(value, &reads);
        let assigned = targets.clone().skip(1).map(|(target, _)| target).chain([value]);
        for ((target, is_read), assigned) in targets.zip(assigned) {
            if let Some((path, is_global)) = self.path(target) {
                let span = self.expressions[target].span;
                let text = self.text(span.to(self.expressions[value].span), &[target, value]);
                let logic = logic.clone().filter(|_| !is_read);
                self.write((path, is_global), self.expressions[assigned].span, text, reads.clone(), logic);
            }
        }
    }

    /// Records that a call writes the members of its instance, and the targets of its outputs.
    fn writes_of_call(&mut self, call: ExpressionId, instance: Option<(String, bool)>, arguments: &[Argument]) {
        let reads = self.reads(arguments.iter().filter(|of| !of.is_output).map(|of| of.value));
        let span = self.expressions[call].span;
        let text = self.text(span, &[call]);
        for argument in arguments.iter().filter(|of| of.is_output) {
            let formal = argument.name.as_ref().map(|name| name.text.as_str()).unwrap_or_default();
            let of_instance = instance.as_ref().map(|(instance, is_global)| Named {
                line: self.line(argument.span),
                path: format!("{instance}.{formal}"),
                is_global: *is_global,
            });
            if let Some((path, is_global)) = self.path(argument.value) {
                let reads = of_instance.map_or_else(|| reads.clone(), |member| vec![member]);
                self.write((path, is_global), argument.span, text.clone(), reads, None);
            }
        }
        if let Some(instance) = instance {
            self.write(instance, span, text, reads, None);
        }
    }

    fn write(&mut self, of: (String, bool), span: Span, text: String, reads: Vec<Named>, logic: Option<Logic>) {
        let ((path, is_global), line) = (of, self.line(span));
        self.found.writes.push(Write { path, is_global, line, text, reads, logic, guards: self.guards.clone() });
    }

    /// Records the variables of an expression. The recursion ends because the parser limits the depth of expressions.
    fn expression(&mut self, id: ExpressionId) {
        let expressions = self.expressions;
        if let ExpressionKind::Name(Scope::Local, name) = &expressions[id].kind
            && let Some(of) = self.temporaries.get(&name.text).copied()
        {
            self.depth += 1;
            if self.depth < DEEPEST {
                self.expression(of);
            }
            self.depth -= 1;
            return;
        }
        if let Some((path, is_global)) = self.path(id) {
            self.note(expressions[id].span, path, is_global);
            return;
        }
        match &expressions[id].kind {
            ExpressionKind::Unary(_, inner)
            | ExpressionKind::Pointer(inner)
            | ExpressionKind::Member(inner, _)
            | ExpressionKind::As(_, inner) => {
                self.expression(*inner);
            }
            ExpressionKind::Binary(_, left, right) => [left, right].into_iter().for_each(|of| self.expression(*of)),
            ExpressionKind::Index(base, indices) => {
                self.expression(*base);
                indices.iter().for_each(|index| self.expression(*index));
            }
            // A call used as a value is a function call.
            ExpressionKind::Call(_, arguments) => self.call(None, arguments),
            ExpressionKind::Name(..)
            | ExpressionKind::Literal(_)
            | ExpressionKind::Address(_)
            | ExpressionKind::Wrong => {}
        }
    }

    /// Reads the arguments of a call to an instance or a function.
    fn call(&mut self, instance: Option<(String, bool)>, arguments: &[Argument]) {
        let mut passed = Vec::new();
        for argument in arguments {
            let path = self.path(argument.value).map(|(path, _)| path);
            if let Some(formal) = argument.name.as_ref().map(|name| name.text.clone()) {
                // A computed input can be watched in the instance.
                if let (None, Some((instance, is_global))) = (&path, &instance) {
                    self.note(argument.span, format!("{instance}.{formal}"), *is_global);
                }
                let literal = match &self.expressions[argument.value].kind {
                    ExpressionKind::Literal(text) => Some(text.clone()),
                    _ => None,
                };
                passed.push(Passed { formal, path, literal, line: self.line(argument.span) });
            }
            self.expression(argument.value);
        }
        if let Some((instance, _)) = instance {
            self.found.calls.push(Called { instance, arguments: passed });
        }
    }

    fn note(&mut self, span: Span, path: String, is_global: bool) {
        let named = Named { line: self.line(span), path, is_global };
        if !self.found.names.contains(&named) {
            self.found.names.push(named);
        }
    }

    fn path(&self, id: ExpressionId) -> Option<(String, bool)> {
        path(self.expressions, id)
    }
}

/// The path of a variable, and whether its root is global; `None` for anything else.
fn path(expressions: &Expressions, id: ExpressionId) -> Option<(String, bool)> {
    match &expressions[id].kind {
        ExpressionKind::Name(scope, name) => Some((name.text.clone(), *scope == Scope::Global)),
        // A slice such as `.%X3` counts as the variable itself.
        ExpressionKind::Member(base, name) if name.text.starts_with('%') => path(expressions, *base),
        ExpressionKind::Member(base, name) => {
            let (base, is_global) = path(expressions, *base)?;
            Some((format!("{base}.{}", name.text), is_global))
        }
        ExpressionKind::Index(base, indices) => {
            let (base, is_global) = path(expressions, *base)?;
            let index = |id: &ExpressionId| match &expressions[*id].kind {
                ExpressionKind::Literal(text) => Some(text.clone()),
                _ => path(expressions, *id).map(|(path, _)| path),
            };
            let indices = indices.iter().map(index).collect::<Option<Vec<_>>>()?;
            Some((format!("{base}[{}]", indices.join(",")), is_global))
        }
        _ => None,
    }
}

/// An expression in SCL. A temporary of a network is replaced by its expression, in which temporaries remain. The
/// recursion ends because the parser and the networks limit the depth of expressions.
fn written(expressions: &Expressions, temporaries: &HashMap<String, ExpressionId>, id: ExpressionId) -> String {
    let of = |id: ExpressionId| written(expressions, temporaries, id);
    let inner = |id: ExpressionId| match &expressions[id].kind {
        ExpressionKind::Binary(..) => format!("({})", of(id)),
        _ => of(id),
    };
    match &expressions[id].kind {
        ExpressionKind::Literal(text) => match text.as_str() {
            "BOOL#TRUE" => "TRUE".to_string(),
            "BOOL#FALSE" => "FALSE".to_string(),
            _ => text.clone(),
        },
        ExpressionKind::Name(Scope::Global, name) => format!("\"{}\"", name.text),
        ExpressionKind::Name(Scope::Local, name) => match temporaries.get(&name.text) {
            Some(of) => format!("({})", written(expressions, &HashMap::new(), *of)),
            None => format!("#{}", name.text),
        },
        ExpressionKind::Name(Scope::Bare, name) => name.text.clone(),
        ExpressionKind::Member(base, name) => format!("{}.{}", of(*base), name.text),
        ExpressionKind::Index(base, indices) => {
            let indices: Vec<String> = indices.iter().map(|index| of(*index)).collect();
            format!("{}[{}]", of(*base), indices.join(", "))
        }
        ExpressionKind::Unary(operator, operand) => match operator {
            Unary::Not => format!("NOT {}", inner(*operand)),
            Unary::Minus => format!("-{}", inner(*operand)),
            Unary::Plus => inner(*operand),
        },
        ExpressionKind::Binary(operator, left, right) => {
            // A chain of one operator needs no parentheses.
            let is_chain = matches!(&expressions[*left].kind, ExpressionKind::Binary(of, ..) if of == operator);
            let left = if is_chain { of(*left) } else { inner(*left) };
            format!("{left} {} {}", sign(*operator), inner(*right))
        }
        ExpressionKind::Call(callee, arguments) => {
            let argument = |of: &Argument| {
                let name = of.name.as_ref().map(|name| name.text.as_str()).unwrap_or_default();
                let between = if of.is_output { "=>" } else { ":=" };
                let value = written(expressions, temporaries, of.value);
                if name.is_empty() { value } else { format!("{name} {between} {value}") }
            };
            format!("{}({})", of(*callee), arguments.iter().map(argument).collect::<Vec<_>>().join(", "))
        }
        ExpressionKind::As(_, inner) | ExpressionKind::Pointer(inner) => of(*inner),
        ExpressionKind::Address(address) => address.clone(),
        ExpressionKind::Wrong => "?".to_string(),
    }
}

fn sign(operator: Binary) -> &'static str {
    match operator {
        Binary::Power => "**",
        Binary::Multiply => "*",
        Binary::Divide => "/",
        Binary::Modulo => "MOD",
        Binary::Add => "+",
        Binary::Subtract => "-",
        Binary::Less => "<",
        Binary::Greater => ">",
        Binary::LessOrEqual => "<=",
        Binary::GreaterOrEqual => ">=",
        Binary::Equal => "=",
        Binary::NotEqual => "<>",
        Binary::And => "AND",
        Binary::Xor => "XOR",
        Binary::Or => "OR",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "FUNCTION_BLOCK \"Pump\"
VAR_INPUT level : Real; END_VAR
VAR t : TON_TIME; m : ARRAY[1..2] OF Bool; END_VAR
VAR_TEMP i : Int; END_VAR
VAR CONSTANT CYCLE : Time := T#1s; END_VAR
BEGIN
  #t(IN := #level > 3.0,
     PT := T#2s, Q => #m[1]);
  IF NOT #m[#i] AND \"Data\".on.%X3 THEN
    #level := LIMIT(MN := 0.0, IN := #level, MX := 1.0);
  END_IF;
END_FUNCTION_BLOCK";

    #[test]
    fn each_line_has_the_variables_that_it_names() {
        let found = watched(&[Source::new("pump.scl", SOURCE.into())]);
        let [pump] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!((pump.name.as_str(), pump.line), ("Pump", 1));
        let names: Vec<(usize, &str, bool)> =
            pump.names.iter().map(|named| (named.line, named.path.as_str(), named.is_global)).collect();
        assert_eq!(
            names,
            [
                (7, "t.IN", false),
                (7, "level", false),
                (8, "t.PT", false),
                (8, "m[1]", false),
                (9, "m[i]", false),
                (9, "Data.on", true),
                (10, "level", false),
            ]
        );
        assert_eq!(pump.calls.len(), 1);
        let passed = |formal: &str, path: Option<&str>, literal: Option<&str>, line| Passed {
            formal: formal.into(),
            path: path.map(str::to_string),
            literal: literal.map(str::to_string),
            line,
        };
        let arguments =
            vec![passed("IN", None, None, 7), passed("PT", None, Some("T#2s"), 8), passed("Q", Some("m[1]"), None, 8)];
        assert_eq!(pump.calls[0], Called { instance: "t".into(), arguments });
        assert_eq!(pump.temps, [("i".to_string(), "INT".to_string())]);
        assert_eq!(pump.constants, [("CYCLE".to_string(), "T#1s".to_string())]);
        let declared = [("level", 2), ("t", 3), ("m", 3), ("i", 4), ("CYCLE", 5)];
        assert_eq!(pump.declared, declared.map(|(name, line)| (name.to_string(), line)));
    }

    #[test]
    fn each_write_has_what_it_reads_and_the_conditions_under_which_it_runs() {
        let source = "FUNCTION_BLOCK \"Valve\"
VAR_INPUT a : Bool; b : Int; END_VAR VAR_OUTPUT open : Bool; n : Int; END_VAR VAR t : TON_TIME; END_VAR
BEGIN
  IF #a AND NOT #t.Q THEN
    #open := TRUE;
  ELSIF #b > 3 THEN
    CASE #b OF
      4: #n += #b;
    ELSE
      #n := 0;
    END_CASE;
  ELSE
    #t(IN := #a, PT := T#1s, Q => #open);
  END_IF;
END_FUNCTION_BLOCK";
        let found = watched(&[Source::new("valve.scl", source.into())]);
        let names = |of: &[Named]| of.iter().map(|named| named.path.clone()).collect::<Vec<_>>().join(" ");
        let guard = |of: &Guard| format!("{}{}", if of.is_negated { "NOT " } else { "" }, of.text);
        let written: Vec<_> = found[0]
            .writes
            .iter()
            .map(|of| {
                let guards: Vec<_> = of.guards.iter().map(guard).collect();
                format!("{} {}: {} | {} | {}", of.line, of.path, of.text, names(&of.reads), guards.join(", "))
            })
            .collect();
        assert_eq!(
            written,
            [
                "5 open: #open := TRUE | TRUE | #a AND NOT #t.Q",
                "8 n: #n += #b | n b | NOT #a AND NOT #t.Q, #b > 3, #b",
                "10 n: #n := 0 |  | NOT #a AND NOT #t.Q, #b > 3, NOT #b",
                "13 open: #t(IN := #a, PT := T#1s, Q => #open) | t.Q | NOT #a AND NOT #t.Q, NOT #b > 3",
                "13 t: #t(IN := #a, PT := T#1s, Q => #open) | a | NOT #a AND NOT #t.Q, NOT #b > 3",
            ]
        );
        assert_eq!(names(&found[0].writes[0].guards[0].reads), "a t.Q");
    }

    #[test]
    fn a_source_with_errors_is_read_as_far_as_it_goes() {
        let text = SOURCE.replace("LIMIT(", "LIMIT((");
        let found = watched(&[Source::new("pump.scl", text.into())]);
        assert!(found.iter().all(|block| block.names.iter().all(|named| named.line < 12)), "{found:?}");
    }
}
