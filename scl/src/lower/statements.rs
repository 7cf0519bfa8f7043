//! Statements.

use super::convert::{binary, zero};
use super::paths::{Slice, Variable};
use super::{LabelOf, Loop, Lowerer};
use crate::check::compiler::{Note, Operand, Slot, Symbol};
use crate::check::types::{Elementary, Type, text_name};
use crate::check::undeclared::Missing;
use crate::front::lexer::Span;
use crate::front::syntax::{Binary, ExpressionId, ExpressionKind, Label, Name, SectionKind, Statement, StatementKind};
use crate::ir::walk;
use crate::ir::{self, Arm, At, Expr, For, Place, Scalar, Step, Value, What};
use manifest::Cpu;
use std::rc::Rc;

impl Lowerer<'_, '_> {
    pub(crate) fn statements(&mut self, statements: &[Statement]) {
        self.warn_of_calls(statements);
        for statement in statements {
            self.with_views(statement.span, |lowerer| lowerer.statement(statement));
        }
    }

    /// Warns about an instance called twice in one statement list.
    fn warn_of_calls(&mut self, statements: &[Statement]) {
        let mut called: Vec<&str> = Vec::new();
        for statement in statements {
            let StatementKind::Call(call) = &statement.kind else { continue };
            let ExpressionKind::Call(callee, _) = &self.expressions()[*call].kind else { continue };
            let name = self.compiler.text(self.span(*callee));
            let is_instance = self.is_instance(*callee);
            if called.contains(&name) && is_instance {
                let message = format!("the instance {name} is called a second time in this cycle");
                self.warn(statement.span, message, Some("call it once, or use two instances"));
            }
            called.push(name);
        }
    }

    fn body(&mut self, statements: &[Statement]) -> Vec<ir::Statement> {
        self.aside(|lowerer| lowerer.statements(statements)).0
    }

    fn condition_of(&mut self, id: ExpressionId) -> Expr {
        let span = self.span(id);
        // Statements required by the condition stay with it: a loop repeats them in every iteration.
        let (before, condition) = self.aside(|lowerer| {
            lowerer.with_views(span, |lowerer| {
                let operand = lowerer.operand(id, Some(Elementary::Bool));
                lowerer.condition(operand, span)
            })
        });
        if before.is_empty() { condition } else { Expr::After(before, Box::new(condition)) }
    }

    fn statement(&mut self, statement: &Statement) {
        let span = statement.span;
        match &statement.kind {
            StatementKind::Assign(targets, value) => self.assignments(targets, *value, span),
            StatementKind::Call(call) => self.call_statement(*call),
            StatementKind::If(arms, otherwise) => self.conditional(arms, otherwise, span),
            StatementKind::Case(selector, arms, otherwise) => self.case(*selector, arms, otherwise, span),
            StatementKind::For { variable, first, last, step, body } => {
                self.counting(*variable, [*first, *last], *step, body, span);
            }
            StatementKind::While(condition, body) => {
                let condition = self.condition_of(*condition);
                let body = self.in_loop(None, body);
                self.warn_of_endless(&condition, true, &body, span);
                self.push(span, What::While(condition, body));
            }
            StatementKind::Repeat(body, condition) => {
                let body = self.in_loop(None, body);
                let condition = self.condition_of(*condition);
                self.warn_of_endless(&condition, false, &body, span);
                self.push(span, What::Repeat(body, condition));
            }
            StatementKind::Exit | StatementKind::Continue => {
                if self.loops.is_empty() {
                    let name = if matches!(statement.kind, StatementKind::Exit) { "EXIT" } else { "CONTINUE" };
                    self.error(span, format!("{name} is not inside a loop"), Some("to leave the block, use RETURN"));
                    return;
                }
                let is_exit = matches!(statement.kind, StatementKind::Exit);
                self.push(span, if is_exit { What::Break } else { What::Continue });
            }
            StatementKind::Return(value) => {
                if let Some(value) = value {
                    let condition = self.condition_of(*value);
                    let name = Name { text: "ENO".to_string(), span };
                    if let super::paths::Path::Variable(eno) = self.eno_path(&name) {
                        self.push(span, What::Assign(eno.place, condition));
                    }
                }
                self.push(span, What::Return);
            }
            StatementKind::Goto(name) => {
                let loops: Vec<usize> = self.loops.iter().map(|(number, _)| *number).collect();
                let label = self.label(&name.text);
                label.jumps.push((name.span, loops));
                let number = label.number;
                self.push(span, What::Goto(number));
            }
            StatementKind::Label(name) => {
                let loops: Vec<usize> = self.loops.iter().map(|(number, _)| *number).collect();
                let label = self.label(&name.text);
                let number = label.number;
                if label.loops.replace(loops).is_some() {
                    self.error(name.span, format!("the label {} is defined twice", name.text), None);
                    return;
                }
                self.push(span, What::Label(number));
            }
            StatementKind::Let(name, of, value) => self.declare(name, *of, *value, span),
            StatementKind::Comment(text) => self.push(span, What::Comment(text.clone())),
        }
    }

    /// Declares a temporary of the given type or, without one, of its value's type; without either, the type is that of
    /// the output later stored in it.
    fn declare(&mut self, name: &Name, of: Option<Elementary>, value: Option<ExpressionId>, span: Span) {
        if of.is_none() && value.is_none() {
            self.untyped.insert(name.key());
            return;
        }
        let value = value.map(|value| self.operand(value, of));
        let (of, value) = match (of, value) {
            (Some(of), Some(operand)) => (of, Some(self.converted(operand, of, span))),
            (Some(of), None) => (of, None),
            (None, Some(Operand::Value(of, value))) => (of, Some(value)),
            (None, Some(Operand::Whole(whole))) => {
                let of = self.widest(whole);
                (of, Some(self.converted(Operand::Whole(whole), of, span)))
            }
            (None, Some(operand @ Operand::Fraction(..))) => {
                let of = self.widest_real();
                (of, Some(self.converted(operand, of, span)))
            }
            (None, Some(Operand::Wrong(missing))) => {
                missing.iter().for_each(|name| self.guess(name, Elementary::Bool));
                (Elementary::Bool, None)
            }
            (None, Some(other)) => {
                let found = self.type_name(&other);
                self.error(span, format!("a wire carries a number or a BOOL, not {found}"), Some("use a variable"));
                (Elementary::Bool, None)
            }
            (None, None) => return,
        };
        let known = match self.symbol(&name.text) {
            Some(Symbol::Variable(SectionKind::Temp, Type::Elementary(known), Slot::Local(number))) => {
                (known == of).then_some(number)
            }
            _ => None,
        };
        let number = known.unwrap_or_else(|| self.temporary(name, Type::Elementary(of)));
        if let Some(value) = value {
            self.push(span, What::Assign(Place::new(ir::Base::Local(number)), value));
        }
    }

    /// Adds a named temporary; returns its local index.
    fn temporary(&mut self, name: &Name, of: Type) -> usize {
        let ty = self.compiler.lowered(&of);
        self.locals.push(ir::Local { name: name.text.clone(), ty, by_reference: false });
        let number = self.locals.len() - 1;
        let symbol = Symbol::Variable(SectionKind::Temp, of, Slot::Local(number));
        Rc::make_mut(&mut self.symbols).insert(name.key(), symbol);
        number
    }

    /// Sets the type of an untyped temporary to that of the output stored in it.
    pub(crate) fn declare_for(&mut self, target: ExpressionId, of: &Type) {
        if let ExpressionKind::Name(_, name) = &self.expressions()[target].kind
            && self.untyped.remove(&name.key())
        {
            self.temporary(name, of.clone());
        }
    }

    fn label(&mut self, name: &str) -> &mut LabelOf {
        let number = self.labels.len();
        self.labels.entry(name.to_string()).or_insert(LabelOf { number, loops: None, jumps: Vec::new() })
    }

    /// Checks that jumps go to labels of the block, and never into a loop.
    pub(crate) fn check_labels(&mut self) {
        for (name, label) in std::mem::take(&mut self.labels) {
            for (span, loops) in &label.jumps {
                match &label.loops {
                    None => {
                        self.error(*span, format!("no label {name} in this block"), None);
                    }
                    Some(inside) if !loops.starts_with(inside) => {
                        self.error(
                            *span,
                            format!("GOTO jumps into the loop that contains the label {name}"),
                            Some("use IF in the loop"),
                        );
                    }
                    Some(_) => {}
                }
            }
        }
    }

    fn assignments(&mut self, targets: &[(ExpressionId, Option<Binary>)], value: ExpressionId, span: Span) {
        let mut value_span = self.span(value);
        let mut next: Option<Operand> = None;
        for (target, operator) in targets.iter().rev() {
            let place = self.target(*target);
            let target_span = self.span(*target);
            let of = place.as_ref().and_then(|place| place.slice.map_or(place.of.elementary(), |slice| Some(slice.of)));
            let mut operand = match next.take() {
                Some(operand) => operand,
                None => self.operand(value, of.filter(|_| operator.is_none())),
            };
            let Some(variable) = place else {
                self.guess_target(*target, &operand);
                next = Some(operand);
                continue;
            };
            self.check_written(&variable, target_span);
            self.note_of_type(&variable, value, &operand, value_span);
            if let Some(operator) = operator {
                let before = self.value_of(&variable, target_span);
                operand = self.binary(*operator, before, operand, span);
            }
            self.assign(&variable, operand, value_span);
            next = Some(self.value_of(&variable, target_span));
            value_span = target_span;
        }
    }

    /// Warns about `#dint := #int * 1000`, which wraps in INT, and `#real := #int / 2`, which divides integers.
    fn note_of_type(&mut self, variable: &Variable, value: ExpressionId, operand: &Operand, span: Span) {
        let ExpressionKind::Binary(operator, ..) = &self.expressions()[value].kind else { return };
        let (Type::Elementary(to), Operand::Value(of, value)) = (&variable.of, operand) else { return };
        if matches!(value, Expr::Const(_)) {
            return;
        }
        let (of, to) = (*of, *to);
        let is_sum = matches!(operator, Binary::Add | Binary::Subtract | Binary::Multiply);
        if is_sum && of.is_whole() && to.is_whole() && of.bits() < to.bits() {
            let help = format!("convert an operand first: {}_TO_{}(...)", of.name(), to.name());
            self.warn(
                span,
                format!("this is computed in {} and may overflow before it is converted to {}", of.name(), to.name()),
                Some(&help),
            );
        }
        if *operator == Binary::Divide && of.is_whole() && to.class() == crate::check::types::Class::Real {
            let message = format!("integer division: the fraction is lost before the result becomes {}", to.name());
            self.warn(span, message, Some("convert an operand first, or write 2.0 instead of 2"));
        }
    }

    /// Warns about an endless loop: the condition is constant and no statement leaves the loop.
    fn warn_of_endless(&mut self, condition: &Expr, runs_on: bool, body: &[ir::Statement], span: Span) {
        let leaves = walk::any(body, |what| matches!(what, What::Break | What::Return | What::Goto(_)));
        if !leaves && *condition == Expr::Const(runs_on.into()) {
            self.warn(span, "this loop never ends", Some("leave it with EXIT or RETURN, or count with FOR"));
        }
    }

    /// Warns about writes to inputs. A write to a loop variable is an error, on S7-300 and S7-400 a warning.
    fn check_written(&mut self, variable: &Variable, span: Span) {
        if variable.section == Some(SectionKind::Input) && self.file != self.compiler.library_file() {
            self.warn(
                span,
                "an input is written, but the caller does not see the change",
                Some("use a static or temporary variable"),
            );
        }
        let counted = self.loops.iter().any(|(_, one)| one.variable.as_ref() == Some(&variable.place));
        if counted {
            let name = self.compiler.text(span).trim_start_matches('#').to_string();
            if self.compiler.cpu == Cpu::S7300 {
                self.warn(
                    span,
                    format!("the loop variable {name} is written inside its loop: the new value is used"),
                    None,
                );
            } else {
                let message = format!("the loop variable {name} must not be written inside its loop");
                self.error(span, message, Some("use WHILE, or EXIT to leave the loop"));
            }
        }
    }

    /// Infers the type of an undeclared variable from an assignment to it.
    pub(crate) fn guess_target(&mut self, target: ExpressionId, operand: &Operand) {
        if let Some(missing) = self.missing(target) {
            self.guess_like(&missing, operand);
        }
    }

    /// Infers the type of an undeclared variable from a value assigned to it or compared with it.
    pub(crate) fn guess_like(&mut self, missing: &Missing, operand: &Operand) {
        match operand {
            Operand::Value(of, _) => self.guess(missing, *of),
            Operand::Fraction(..) => self.guess(missing, Elementary::Real),
            // A truth value may be written as a number.
            Operand::Whole(0 | 1) => self.compiler.guess_likely(missing, Elementary::Int),
            Operand::Whole(_) => self.guess(missing, Elementary::Int),
            Operand::Text(_, wide) => {
                self.compiler.guess_missing(missing, text_name(*wide == Some(true)).to_string());
            }
            Operand::Variable(of, _) => {
                if let Some(of) = self.compiler.written(of) {
                    self.compiler.guess_missing(missing, of);
                }
            }
            Operand::Wrong(_) => {}
        }
    }

    /// Assigns a value to a variable, converted to its type.
    pub(crate) fn assign(&mut self, variable: &Variable, operand: Operand, span: Span) {
        let place = variable.place.clone();
        match &variable.of {
            Type::Elementary(of) => match variable.slice {
                None => {
                    let value = self.converted(operand, *of, span);
                    self.push(span, What::Assign(place, value));
                }
                Some(slice) => {
                    let value = self.converted(operand, slice.of, span);
                    let value = self.with_slice(*of, slice, &place, value, span);
                    self.push(span, What::Assign(place, value));
                }
            },
            Type::Wrong | Type::Missing(_) => {}
            Type::Text { wide, .. } => {
                if let Some(from) = self.text_as(operand, *wide, span) {
                    self.push(span, What::Copy(place, from));
                }
            }
            of => match operand {
                Operand::Wrong(missing) => {
                    if let (Some(missing), Some(of)) = (missing, self.compiler.written(of)) {
                        self.compiler.guess_missing(&missing, of);
                    }
                }
                Operand::Variable(from, source) if of.is_like(&from) && !matches!(of, Type::Instance(_)) => {
                    self.push(span, What::Copy(place, source));
                }
                operand @ Operand::Value(Elementary::Dt, _) if of.is_like(&self.compiler.dtl()) => {
                    if let Operand::Variable(_, source) = self.dtl_of(operand, span) {
                        self.push(span, What::Copy(place, source));
                    }
                }
                other => {
                    let (of, found) = (of.to_string(), self.type_name(&other));
                    self.error(span, format!("expected {of}, found {found}"), None);
                }
            },
        }
    }

    /// The whole variable's value with one slice replaced.
    fn with_slice(&mut self, of: Elementary, slice: Slice, place: &Place, value: Expr, span: Span) -> Expr {
        let at = self.at(span);
        let scalar = of.scalar();
        let ones = if slice.of.bits() == 64 { u64::MAX } else { (1 << slice.of.bits()) - 1 };
        let keep = Expr::Const(Value::new(scalar, !(ones << slice.shift)));
        let kept = binary(ir::Binary::And, scalar, Expr::Load(scalar, place.clone()), keep, at);
        // A slice is zero-extended.
        let wide = super::convert::convert(value, slice.of.scalar(), scalar, ir::Convert::Value, at);
        let shifted = binary(ir::Binary::Shl, scalar, wide, Expr::Const(slice.shift.into()), at);
        binary(ir::Binary::Or, scalar, kept, shifted, at)
    }

    fn conditional(&mut self, arms: &[(ExpressionId, Vec<Statement>)], otherwise: &[Statement], span: Span) {
        let [(condition, body), rest @ ..] = arms else { return };
        let condition = self.condition_of(*condition);
        let body = self.body(body);
        // The ELSIF chain is built from its end, without recursion.
        let mut lowered: Vec<(ir::At, Expr, Vec<ir::Statement>)> = Vec::new();
        for (id, statements) in rest {
            let at = self.at(self.span(*id));
            let condition = self.condition_of(*id);
            let statements = self.body(statements);
            lowered.push((at, condition, statements));
        }
        let mut last = self.body(otherwise);
        for (at, condition, statements) in lowered.into_iter().rev() {
            last = vec![ir::Statement { at, what: What::If(condition, statements, last) }];
        }
        self.push(span, What::If(condition, body, last));
    }

    fn case(
        &mut self,
        selector: ExpressionId,
        arms: &[(Vec<Label>, Vec<Statement>)],
        otherwise: &[Statement],
        span: Span,
    ) {
        let selector_span = self.span(selector);
        let operand = self.operand(selector, None);
        let value = match operand {
            Operand::Value(of, value) if of.is_whole() || of.class() == crate::check::types::Class::Character => value,
            Operand::Wrong(name) => {
                if let Some(name) = name {
                    self.guess(&name, Elementary::Int);
                }
                zero(Elementary::LInt)
            }
            Operand::Whole(_) => {
                let of = self.widest(0);
                self.converted(operand, of, selector_span)
            }
            other => {
                let of = self.type_name(&other);
                self.error(
                    selector_span,
                    format!("CASE selects by an integer or a bit string, not by {of}"),
                    Some("use IF"),
                );
                zero(Elementary::LInt)
            }
        };
        let mut taken: Vec<(i64, i64)> = Vec::new();
        let mut lowered = Vec::new();
        for (labels, body) in arms {
            let mut values = Vec::new();
            for label in labels {
                if let Some(range) = self.range_of(label) {
                    let label_span = self.span(label.low);
                    if taken.iter().any(|(low, high)| range.0 <= *high && *low <= range.1) {
                        self.warn(label_span, "this CASE value occurs twice: the first one applies", None);
                    }
                    taken.push(range);
                    values.push(range);
                }
            }
            let mut body = self.body(body);
            // For watching: records that the arm does not run, and inside the arm that it does.
            if let Some(place) = labels.first().and_then(|label| self.place_of_note(label.low)) {
                let note = |truth: u8| ir::Statement {
                    at: At::NOTE,
                    what: What::Assign(place.clone(), Expr::Const(truth.into())),
                };
                self.code.push(note(Note::FALSE));
                body.insert(0, note(Note::TRUE));
            }
            lowered.push(Arm { values, body });
        }
        let otherwise = self.body(otherwise);
        self.push(span, What::Case(value, lowered, otherwise));
    }

    fn range_of(&mut self, label: &Label) -> Option<(i64, i64)> {
        let low = self.whole(label.low);
        let high = label.high.map_or(low, |high| self.whole(high));
        let (low, high) = (low?, high?);
        if low > high {
            self.error(
                self.span(label.low),
                format!("{low}..{high} is not a range"),
                Some("write the lower value first"),
            );
            return None;
        }
        Some((low as i64, high as i64))
    }

    fn in_loop(&mut self, variable: Option<Place>, body: &[Statement]) -> Vec<ir::Statement> {
        self.loop_count += 1;
        self.loops.push((self.loop_count, Loop { variable }));
        let body = self.body(body);
        self.loops.pop();
        body
    }

    fn counting(
        &mut self,
        variable: ExpressionId,
        [first, last]: [ExpressionId; 2],
        step: Option<ExpressionId>,
        body: &[Statement],
        span: Span,
    ) {
        let target = self.target(variable);
        let variable_span = self.span(variable);
        let of = match target.as_ref().map(|target| &target.of) {
            Some(Type::Elementary(of)) if of.is_whole() => *of,
            None | Some(Type::Wrong | Type::Missing(_)) => Elementary::DInt,
            Some(of) => {
                let message = format!("a loop variable must be an integer, not {of}");
                self.error(variable_span, message, None);
                Elementary::DInt
            }
        };
        if let Some(target) = &target {
            if self.is_view(target) {
                self.error(variable_span, "a loop variable cannot be a view (AT)", Some("use a separate variable"));
            }
            self.check_written(target, variable_span);
        } else {
            self.guess_target(variable, &Operand::Value(Elementary::Int, zero(Elementary::Int)));
        }
        let mut number = |id: ExpressionId| {
            let span = self.span(id);
            let operand = self.operand(id, Some(of));
            self.converted(operand, of, span)
        };
        let first = number(first);
        let (last_id, last) = (last, number(last));
        let step_value = step.map(number);
        if let (Some(step), Some(Expr::Const(value))) = (step, &step_value)
            && value.bits() == 0
        {
            self.error(self.span(step), "a loop with step 0 never ends", None);
        }
        let is_limit = |value: &Value| value.bits() == of.range().1 as u64 || value.bits() == of.range().0 as u64;
        if let Expr::Const(value) = &last
            && is_limit(value)
            && value.bits() != 0
        {
            let message =
                format!("the loop counts to the limit of {}: it ends in the FMU, but perhaps not on a CPU", of.name());
            self.warn(self.span(last_id), message, Some("use a larger type"));
        }
        // The loop counts in the variable selected at its start, even if an index changes later.
        let place = target.map(|target| self.frozen(target.place, variable_span));
        let body = self.in_loop(place.clone(), body);
        let Some(variable) = place else { return };
        let step = step_value.unwrap_or(Expr::Const(Value::new(of.scalar(), 1)));
        self.push(span, What::For(Box::new(For { variable, first, last, step, body })));
    }

    /// The place with its computed indices stored in temporaries, so that they are evaluated only once.
    pub(crate) fn frozen(&mut self, mut place: Place, span: Span) -> Place {
        for step in &mut place.steps {
            let Step::Index(indices, _) = step else { continue };
            for index in indices {
                if matches!(index, Expr::Const(_)) {
                    continue;
                }
                let of: Scalar = index.ty();
                let temp = self.temp(ir::Type::Scalar(of));
                let value = std::mem::replace(index, Expr::Load(of, temp.clone()));
                self.push(span, What::Assign(temp, value));
            }
        }
        place
    }
}
