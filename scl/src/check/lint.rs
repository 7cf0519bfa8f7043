//! Warns about temporaries that are read before they are written.

use crate::check::compiler::{BlockId, Compiler};
use crate::front::lexer::Span;
use crate::ir::{Argument, At, Base, Call, Expr, Place, Statement, Step, What};
use std::collections::BTreeSet;

/// Warns about each temporary of a block that some path reads before writing it; its value is then 0. Blocks with jumps
/// are not checked.
pub(crate) fn unwritten(compiler: &mut Compiler, (file, _): BlockId, temps: &[(usize, String)], code: &[Statement]) {
    if temps.is_empty() || file == compiler.library_file() {
        return;
    }
    let mut flow = Flow { temps, written: BTreeSet::new(), found: Vec::new(), has_jumps: false };
    flow.statements(code);
    if flow.has_jumps {
        return;
    }
    for (at, name) in flow.found {
        let source = &compiler.sources[file];
        let start = line_start(&source.text, at.line);
        let line = source.text[start..].lines().next().unwrap_or_default();
        let offset = line.find(&name).unwrap_or(line.len() - line.trim_start().len());
        let span =
            Span { file: file as u32, start: (start + offset) as u32, end: (start + offset + name.len()) as u32 };
        let message = format!("the temporary {name} may be read before it is written; if so, it is 0");
        compiler.warn(span, message, Some("write it first, or declare it in VAR to keep its value between calls"));
    }
}

fn line_start(text: &str, line: u32) -> usize {
    let newline = text.match_indices('\n').nth((line as usize).wrapping_sub(2));
    if line < 2 { 0 } else { newline.map_or(text.len(), |(at, _)| at + 1) }
}

struct Flow<'a> {
    temps: &'a [(usize, String)],
    written: BTreeSet<usize>,
    found: Vec<(At, String)>,
    has_jumps: bool,
}

impl Flow<'_> {
    fn statements(&mut self, code: &[Statement]) {
        for statement in code {
            self.statement(statement);
        }
    }

    /// Returns the temporaries definitely written once these statements have run; leaves `written` unchanged, because
    /// they may not run.
    fn branch(&mut self, code: &[Statement]) -> BTreeSet<usize> {
        let before = self.written.clone();
        self.statements(code);
        let leaves = matches!(code.last(), Some(Statement { what: What::Return | What::Break | What::Continue, .. }));
        let after = std::mem::replace(&mut self.written, before);
        // A branch that leaves the loop or the function does not restrict what is written afterwards.
        if leaves { self.temps.iter().map(|(number, _)| *number).collect() } else { after }
    }

    fn join(&mut self, branches: Vec<BTreeSet<usize>>) {
        let joined = branches.into_iter().reduce(|one, other| one.intersection(&other).copied().collect());
        self.written.extend(joined.unwrap_or_default());
    }

    fn statement(&mut self, statement: &Statement) {
        let at = statement.at;
        match &statement.what {
            What::Assign(place, value) => {
                self.expression(value, at);
                self.writes(place, at);
            }
            What::Copy(to, from) => {
                self.reads(from, at);
                self.writes(to, at);
            }
            What::Call(call) => self.call(call, at),
            What::If(condition, yes, no) => {
                self.expression(condition, at);
                let branches = vec![self.branch(yes), self.branch(no)];
                self.join(branches);
            }
            What::Case(selector, arms, otherwise) => {
                self.expression(selector, at);
                let mut branches = vec![self.branch(otherwise)];
                branches.extend(arms.iter().map(|arm| self.branch(&arm.body)));
                self.join(branches);
            }
            What::While(condition, body) => {
                self.expression(condition, at);
                self.branch(body);
            }
            What::Repeat(body, condition) => {
                self.statements(body);
                self.expression(condition, at);
            }
            What::For(counting) => {
                for value in [&counting.first, &counting.last, &counting.step] {
                    self.expression(value, at);
                }
                self.writes(&counting.variable, at);
                self.branch(&counting.body);
            }
            What::Label(_) | What::Goto(_) => self.has_jumps = true,
            What::Break | What::Continue | What::Return | What::Comment(_) => {}
        }
    }

    fn call(&mut self, call: &Call, at: At) {
        for argument in &call.arguments {
            match argument {
                Argument::Value(value) => self.expression(value, at),
                Argument::Copy(place) => self.reads(place, at),
                Argument::Reference(_) | Argument::Start => {}
            }
        }
        for (_, place) in &call.outputs {
            self.writes(place, at);
        }
    }

    fn writes(&mut self, place: &Place, at: At) {
        self.indices(place, at);
        if let (Base::Local(number), []) = (place.base, place.steps.as_slice()) {
            self.written.insert(number);
        }
    }

    fn indices(&mut self, place: &Place, at: At) {
        for step in &place.steps {
            if let Step::Index(indices, _) = step {
                for index in indices {
                    self.expression(index, at);
                }
            }
        }
    }

    fn reads(&mut self, place: &Place, at: At) {
        self.indices(place, at);
        let (Base::Local(number), []) = (place.base, place.steps.as_slice()) else { return };
        let Some((_, name)) = self.temps.iter().find(|(temp, _)| *temp == number) else { return };
        // Warn once per temporary.
        let is_told = self.found.iter().any(|(_, told)| told == name);
        if self.written.insert(number) && !is_told {
            self.found.push((at, name.clone()));
        }
    }

    fn expression(&mut self, expression: &Expr, at: At) {
        match expression {
            Expr::Const(_) | Expr::Now | Expr::Bound { .. } => {}
            Expr::Load(_, place) => self.reads(place, at),
            Expr::Unary(_, _, value) | Expr::Convert(_, _, _, value, _) => self.expression(value, at),
            Expr::Binary(_, _, left, right, _) => {
                self.expression(left, at);
                self.expression(right, at);
            }
            Expr::Select(_, values) | Expr::Limit(_, values) => {
                values.iter().for_each(|value| self.expression(value, at));
            }
            Expr::Texts(_, one, other) | Expr::Same(one, other) => {
                self.reads(one, at);
                self.reads(other, at);
            }
            Expr::After(code, value) => {
                self.statements(code);
                self.expression(value, at);
            }
        }
    }
}
