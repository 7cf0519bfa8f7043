//! Values on wires: expressions not yet used, which are saved in a temporary before anything they read is written.

use super::Pin;
use super::lower::Lowerer;
use crate::front::lexer::Span;
use crate::front::syntax::{
    Argument, Binary, ExpressionId, ExpressionKind, Expressions, Name, Scope, Statement, StatementKind, Unary, key,
};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// The nesting depth above which an expression is saved in a temporary.
const DEEPEST: u32 = 30;

/// The value that a pin carries.
#[derive(Clone, Debug)]
pub(super) struct Value {
    /// The expression; `None` is TRUE, directly from the power rail.
    pub of: Option<ExpressionId>,
    /// The variables read, in upper case. Variables that may alias others all count as one, with an empty name.
    pub reads: BTreeSet<String>,
}

impl Value {
    /// The value TRUE, directly from the power rail.
    pub(super) const TRUE: Value = Value { of: None, reads: BTreeSet::new() };
}

/// The values of a network's pins that are still needed.
#[derive(Debug, Default)]
pub(super) struct Values {
    of: HashMap<Pin, Value>,
    /// For each variable, the pins whose values read it, so that a large network need not be searched at every coil.
    readers: BTreeMap<String, BTreeSet<Pin>>,
}

impl Values {
    /// Sets the value of a pin.
    pub(super) fn insert(&mut self, pin: Pin, value: Value) {
        for name in &value.reads {
            self.readers.entry(name.clone()).or_default().insert(pin.clone());
        }
        self.of.insert(pin, value);
    }

    /// The value of a pin.
    pub(super) fn get(&self, pin: &Pin) -> Option<&Value> {
        self.of.get(pin)
    }

    /// Removes and returns the value of a pin.
    pub(super) fn remove(&mut self, pin: &Pin) -> Option<Value> {
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

/// Collects the variables that an expression reads: those of the block by name, all others as one.
pub(super) fn reads(
    expressions: &Expressions,
    id: ExpressionId,
    shared: &BTreeSet<String>,
    into: &mut BTreeSet<String>,
) {
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
        // A tag may have this address.
        ExpressionKind::Address(_) => drop(into.insert(String::new())),
        ExpressionKind::Literal(_) | ExpressionKind::Wrong => {}
    }
}

/// The variable at the root of a path, named as in [`reads`].
pub(super) fn root(expressions: &Expressions, id: ExpressionId, shared: &BTreeSet<String>) -> String {
    match &expressions[id].kind {
        ExpressionKind::Member(inner, _) | ExpressionKind::Index(inner, _) => root(expressions, *inner, shared),
        ExpressionKind::Name(scope, name) if *scope != Scope::Global && !shared.contains(&name.key()) => name.key(),
        _ => String::new(),
    }
}

/// An operand in source notation, for messages and comparisons; `...` for any other expression.
pub(super) fn shown(expressions: &Expressions, id: ExpressionId) -> String {
    match &expressions[id].kind {
        ExpressionKind::Name(Scope::Global, name) => format!("\"{}\"", name.text),
        ExpressionKind::Name(_, name) => format!("#{}", name.text),
        ExpressionKind::Member(inner, name) => format!("{}.{}", shown(expressions, *inner), name.text),
        ExpressionKind::Index(inner, indices) => {
            let indices: Vec<String> = indices.iter().map(|index| shown(expressions, *index)).collect();
            format!("{}[{}]", shown(expressions, *inner), indices.join(","))
        }
        ExpressionKind::Literal(text) | ExpressionKind::Address(text) => text.clone(),
        ExpressionKind::As(_, inner) => shown(expressions, *inner),
        _ => "...".to_string(),
    }
}

impl Lowerer<'_> {
    /// A value, with the variables it reads.
    pub(super) fn value(&self, of: ExpressionId) -> Value {
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

    /// A literal with this text.
    pub(super) fn literal(&mut self, text: &str, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Literal(text.to_string()), span)
    }

    /// A value as an expression.
    pub(super) fn expression(&mut self, value: &Value, span: Span) -> ExpressionId {
        value.of.unwrap_or_else(|| self.literal("BOOL#TRUE", span))
    }

    /// Two values combined by AND, OR or XOR.
    pub(super) fn joined(&mut self, operator: Binary, left: Value, right: Value, span: Span) -> Value {
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
    pub(super) fn binary(
        &mut self,
        operator: Binary,
        left: ExpressionId,
        right: ExpressionId,
        span: Span,
    ) -> ExpressionId {
        self.add(ExpressionKind::Binary(operator, left, right), span)
    }

    /// `op operand`.
    pub(super) fn unary(&mut self, operator: Unary, operand: ExpressionId, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Unary(operator, operand), span)
    }

    /// NOT a value.
    pub(super) fn negated(&mut self, value: Value, span: Span) -> Value {
        let of = match value.of {
            None => self.literal("BOOL#FALSE", span),
            Some(of) => self.unary(Unary::Not, of, span),
        };
        Value { of: Some(of), ..value }
    }

    /// `function(name := value, ...)`; each argument is its name, whether it is an output, and its value.
    pub(super) fn call(
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

    /// The name of a CPU function as an expression.
    pub(super) fn function(&mut self, name: &str, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Name(Scope::Bare, Name { text: name.to_string(), span }), span)
    }

    /// A member of an instance.
    pub(super) fn member(&mut self, of: ExpressionId, name: &str, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Member(of, Name { text: name.to_string(), span }), span)
    }

    /// A new name for a temporary, which the block does not use yet.
    pub(super) fn temporary(&mut self, span: Span) -> Name {
        loop {
            self.count += 1;
            let text = format!("w{}_{}", self.number, self.count);
            if !self.owner.names.contains(&key(&text)) {
                self.temporaries.insert(key(&text));
                return Name { text, span };
            }
        }
    }

    /// A named temporary as an expression.
    pub(super) fn named(&mut self, name: &Name, span: Span) -> ExpressionId {
        self.add(ExpressionKind::Name(Scope::Local, Name { text: name.text.clone(), span }), span)
    }

    /// Adds a statement. It must not write anything that a pending value reads.
    pub(super) fn push(&mut self, kind: StatementKind, span: Span) {
        self.code.push(Statement { kind, span });
    }

    /// Evaluates a value at this point and saves it in a temporary, unless it is a literal, a temporary or TRUE.
    pub(super) fn kept(&mut self, value: Value, span: Span) -> Value {
        let Some(of) = value.of else { return value };
        let is_free = value.reads.is_empty();
        if is_free && matches!(self.tree.expressions[of].kind, ExpressionKind::Name(..) | ExpressionKind::Literal(_)) {
            return value;
        }
        let name = self.temporary(span);
        self.push(StatementKind::Let(name.clone(), None, Some(of)), span);
        Value { of: Some(self.named(&name, span)), reads: BTreeSet::new() }
    }

    /// The same value, saved in a temporary if it reads one of these variables, which are about to be written.
    pub(super) fn apart(&mut self, value: Value, roots: &BTreeSet<String>, span: Span) -> Value {
        if value.reads.is_disjoint(roots) { value } else { self.kept(value, span) }
    }

    /// The variables to which these targets belong, named as in [`reads`].
    pub(super) fn roots(&self, targets: impl IntoIterator<Item = ExpressionId>) -> BTreeSet<String> {
        targets.into_iter().map(|target| root(&self.tree.expressions, target, &self.owner.shared)).collect()
    }

    /// Saves all pending values that read these variables, which are about to be written.
    pub(super) fn before_writing(&mut self, roots: &BTreeSet<String>, span: Span) {
        for pin in self.values.readers(roots) {
            let Some(value) = self.values.remove(&pin) else { continue };
            let span = self.spans.get(pin.0).copied().unwrap_or(span);
            let value = self.kept(value, span);
            self.values.insert(pin, value);
        }
    }

    /// Assigns a value to a variable, after saving the pending values that read the variable.
    pub(super) fn assign(&mut self, target: ExpressionId, value: ExpressionId, span: Span) {
        let roots = self.roots([target]);
        self.before_writing(&roots, span);
        self.push(StatementKind::Assign(vec![(target, None)], value), span);
    }

    /// Adds statements that run only if a value is TRUE.
    pub(super) fn only_if(&mut self, condition: Value, body: Vec<Statement>, span: Span) {
        match condition.of {
            None => self.code.extend(body),
            Some(condition) => self.push(StatementKind::If(vec![(condition, body)], Vec::new()), span),
        }
    }

    /// Returns the statements that `part` generates, instead of adding them to the block.
    pub(super) fn aside(&mut self, part: impl FnOnce(&mut Self)) -> Vec<Statement> {
        let outer = std::mem::take(&mut self.code);
        part(self);
        std::mem::replace(&mut self.code, outer)
    }
}
