//! Values on wires: expressions that wait to be used, and are kept in a temporary before what they read is written.

use super::lower::Lowerer;
use crate::lexer::Span;
use crate::network::Pin;
use crate::syntax::{
    Argument, Binary, ExpressionId, ExpressionKind, Expressions, Name, Scope, Statement, StatementKind, Unary, key,
};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A value becomes a temporary when its expression has this many levels.
const DEEPEST: u32 = 30;

/// What a pin carries.
#[derive(Clone, Debug)]
pub struct Value {
    /// Its expression; `None` is TRUE, straight from the power rail.
    pub of: Option<ExpressionId>,
    /// The variables that it reads, in capitals; those that may have other names count as one, which has no name.
    pub reads: BTreeSet<String>,
}

impl Value {
    /// TRUE.
    pub const TRUE: Value = Value { of: None, reads: BTreeSet::new() };
}

/// What the pins of a network carry, as long as it is asked for.
#[derive(Debug, Default)]
pub struct Values {
    of: HashMap<Pin, Value>,
    /// Who reads a variable, so that a large network is not searched at each of its coils.
    readers: BTreeMap<String, BTreeSet<Pin>>,
}

impl Values {
    /// Sets what a pin carries.
    pub fn insert(&mut self, pin: Pin, value: Value) {
        for name in &value.reads {
            self.readers.entry(name.clone()).or_default().insert(pin.clone());
        }
        self.of.insert(pin, value);
    }

    /// What a pin carries.
    pub fn get(&self, pin: &Pin) -> Option<&Value> {
        self.of.get(pin)
    }

    /// What a pin carried.
    pub fn remove(&mut self, pin: &Pin) -> Option<Value> {
        let value = self.of.remove(pin)?;
        for name in &value.reads {
            if let Some(readers) = self.readers.get_mut(name) {
                readers.remove(pin);
            }
        }
        Some(value)
    }

    /// The pins whose values read one of these variables.
    fn readers(&self, roots: &BTreeSet<String>) -> BTreeSet<Pin> {
        roots.iter().filter_map(|root| self.readers.get(root)).flatten().cloned().collect()
    }
}

/// What an expression reads: variables of the block by their names, and all others together.
pub fn reads(expressions: &Expressions, id: ExpressionId, shared: &BTreeSet<String>, into: &mut BTreeSet<String>) {
    match &expressions[id].kind {
        ExpressionKind::Name(scope, name) => {
            let name = name.key();
            let is_own = *scope != Scope::Global && !shared.contains(&name);
            into.insert(if is_own { name } else { String::new() });
        }
        ExpressionKind::Unary(_, inner)
        | ExpressionKind::Member(inner, _)
        | ExpressionKind::Pointer(inner)
        | ExpressionKind::As(_, inner) => reads(expressions, *inner, shared, into),
        ExpressionKind::Binary(_, left, right) => {
            reads(expressions, *left, shared, into);
            reads(expressions, *right, shared, into);
        }
        ExpressionKind::Index(base, indices) => {
            reads(expressions, *base, shared, into);
            indices.iter().for_each(|index| reads(expressions, *index, shared, into));
        }
        ExpressionKind::Call(_, arguments) => {
            arguments.iter().for_each(|argument| reads(expressions, argument.value, shared, into));
        }
        ExpressionKind::Literal(_) | ExpressionKind::Address | ExpressionKind::Wrong => {}
    }
}

/// The variable at the root of a path, as [`reads`] names it.
pub fn root(expressions: &Expressions, id: ExpressionId, shared: &BTreeSet<String>) -> String {
    match &expressions[id].kind {
        ExpressionKind::Member(inner, _) | ExpressionKind::Index(inner, _) => root(expressions, *inner, shared),
        ExpressionKind::Name(scope, name) if *scope != Scope::Global && !shared.contains(&name.key()) => name.key(),
        _ => String::new(),
    }
}

/// An operand as it is written, for messages.
pub fn shown(expressions: &Expressions, id: ExpressionId) -> String {
    match &expressions[id].kind {
        ExpressionKind::Name(Scope::Global, name) => format!("\"{}\"", name.text),
        ExpressionKind::Name(_, name) => format!("#{}", name.text),
        ExpressionKind::Member(inner, name) => format!("{}.{}", shown(expressions, *inner), name.text),
        ExpressionKind::Index(inner, indices) => {
            let indices: Vec<String> = indices.iter().map(|index| shown(expressions, *index)).collect();
            format!("{}[{}]", shown(expressions, *inner), indices.join(","))
        }
        ExpressionKind::Literal(text) => text.clone(),
        ExpressionKind::As(_, inner) => shown(expressions, *inner),
        _ => "...".to_string(),
    }
}

impl Lowerer<'_> {
    /// A value with what it reads.
    pub fn value(&self, of: ExpressionId) -> Value {
        let mut value = Value { of: Some(of), reads: BTreeSet::new() };
        reads(&self.tree.expressions, of, &self.owner.shared, &mut value.reads);
        for temporary in &self.temporaries {
            value.reads.remove(temporary);
        }
        value
    }

    fn add(&mut self, kind: ExpressionKind, span: Span) -> ExpressionId {
        self.tree.expressions.add(kind, span)
    }

    /// TRUE or FALSE, a number or a text.
    pub fn literal(&mut self, text: &str, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Literal(text.to_string()), span)
    }

    /// The expression of a value.
    pub fn expression(&mut self, value: &Value, span: Span) -> ExpressionId {
        value.of.unwrap_or_else(|| self.literal("BOOL#TRUE", span))
    }

    /// One value AND, OR, XOR another one.
    pub fn joined(&mut self, operator: Binary, left: Value, right: Value, span: Span) -> Value {
        match (operator, left.of, right.of) {
            (Binary::And, None, _) => return right,
            (Binary::And, _, None) => return left,
            (Binary::Or, None, _) | (Binary::Or, _, None) => return Value::TRUE,
            _ => {}
        }
        let (one, other) = (self.expression(&left, span), self.expression(&right, span));
        let of = self.binary(operator, one, other, span);
        let mut reads = left.reads;
        reads.extend(right.reads);
        let value = Value { of: Some(of), reads };
        if self.tree.expressions[of].depth > DEEPEST { self.kept(value, span) } else { value }
    }

    /// `left op right`.
    pub fn binary(&mut self, operator: Binary, left: ExpressionId, right: ExpressionId, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Binary(operator, left, right), span)
    }

    /// `op operand`.
    pub fn unary(&mut self, operator: Unary, operand: ExpressionId, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Unary(operator, operand), span)
    }

    /// NOT a value.
    pub fn negated(&mut self, value: Value, span: Span) -> Value {
        let of = match value.of {
            None => self.literal("BOOL#FALSE", span),
            Some(of) => self.unary(Unary::Not, of, span),
        };
        Value { of: Some(of), ..value }
    }

    /// `function(name := value, ...)`; a name that ends in `=>` is an output.
    pub fn call(
        &mut self,
        callee: ExpressionId,
        arguments: Vec<(String, bool, ExpressionId)>,
        span: Span,
    ) -> ExpressionId {
        let argument = |(name, is_output, value): (String, bool, ExpressionId)| {
            let span = self.tree.expressions[value].span;
            Argument { name: Some(Name { text: name, span }), is_output, value, span }
        };
        let arguments = arguments.into_iter().map(argument).collect();
        self.add(ExpressionKind::Call(callee, arguments), span)
    }

    /// The name of a function of the CPU.
    pub fn function(&mut self, name: &str, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Name(Scope::Bare, Name { text: name.to_string(), span }), span)
    }

    /// A member of an instance.
    pub fn member(&mut self, of: ExpressionId, name: &str, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Member(of, Name { text: name.to_string(), span }), span)
    }

    /// A name for a temporary.
    pub fn temporary(&mut self, span: Span) -> Name {
        loop {
            self.count += 1;
            let text = format!("w{}_{}", self.number, self.count);
            if !self.owner.names.contains(&key(&text)) {
                self.temporaries.insert(key(&text));
                return Name { text, span };
            }
        }
    }

    /// A temporary as an expression.
    pub fn named(&mut self, name: &Name, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Name(Scope::Local, Name { text: name.text.clone(), span }), span)
    }

    /// A statement that writes nothing which another value reads.
    pub fn push(&mut self, kind: StatementKind, span: Span) {
        self.code.push(Statement { kind, span });
    }

    /// A value that is calculated here and now; a constant or a temporary is as it is.
    pub fn kept(&mut self, value: Value, span: Span) -> Value {
        let Some(of) = value.of else { return value };
        let is_free = value.reads.is_empty();
        if is_free && matches!(self.tree.expressions[of].kind, ExpressionKind::Name(..) | ExpressionKind::Literal(_)) {
            return value;
        }
        let name = self.temporary(span);
        self.push(StatementKind::Let(name.clone(), None, Some(of)), span);
        Value { of: Some(self.named(&name, span)), reads: BTreeSet::new() }
    }

    /// A value that is still needed after these variables have been written.
    pub fn apart(&mut self, value: Value, roots: &BTreeSet<String>, span: Span) -> Value {
        if value.reads.is_disjoint(roots) { value } else { self.kept(value, span) }
    }

    /// The roots of these variables.
    pub fn roots(&self, targets: impl IntoIterator<Item = ExpressionId>) -> BTreeSet<String> {
        targets.into_iter().map(|target| root(&self.tree.expressions, target, &self.owner.shared)).collect()
    }

    /// Before variables are written, the values that read them are kept.
    pub fn before_writing(&mut self, roots: &BTreeSet<String>, span: Span) {
        for pin in self.values.readers(roots) {
            let Some(value) = self.values.remove(&pin) else { continue };
            let span = self.spans.get(pin.0).copied().unwrap_or(span);
            let value = self.kept(value, span);
            self.values.insert(pin, value);
        }
    }

    /// Assigns a value to a variable.
    pub fn assign(&mut self, target: ExpressionId, value: ExpressionId, span: Span) {
        let roots = self.roots([target]);
        self.before_writing(&roots, span);
        self.push(StatementKind::Assign(vec![(target, None)], value), span);
    }

    /// Statements that are executed if a value is TRUE.
    pub fn only_if(&mut self, condition: Value, body: Vec<Statement>, span: Span) {
        match condition.of {
            None => self.code.extend(body),
            Some(condition) => self.push(StatementKind::If(vec![(condition, body)], Vec::new()), span),
        }
    }

    /// The statements that a part makes, aside.
    pub fn aside(&mut self, part: impl FnOnce(&mut Self)) -> Vec<Statement> {
        let outer = std::mem::take(&mut self.code);
        part(self);
        std::mem::replace(&mut self.code, outer)
    }
}
