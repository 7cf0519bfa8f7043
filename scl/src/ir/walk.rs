//! Visits all parts of statements.

use super::{Argument, Call, Expr, Place, Statement, Step, What};

/// A visitor of statements and expressions.
pub(crate) trait Look {
    /// Visits a statement, before its parts.
    fn statement(&mut self, _: &Statement) {}
    /// Visits an expression, before its parts.
    fn expr(&mut self, _: &Expr) {}
    /// Visits a call, before its arguments.
    fn call(&mut self, _: &Call) {}
}

/// Visits statements and all their parts.
pub(crate) fn statements(list: &[Statement], look: &mut dyn Look) {
    for statement in list {
        look.statement(statement);
        match &statement.what {
            What::Assign(to, value) => {
                place(to, look);
                expr(value, look);
            }
            What::Copy(to, from) => {
                place(to, look);
                place(from, look);
            }
            What::Call(it) => call(it, look),
            What::If(condition, then, otherwise) => {
                expr(condition, look);
                statements(then, look);
                statements(otherwise, look);
            }
            What::Case(selector, arms, otherwise) => {
                expr(selector, look);
                arms.iter().for_each(|arm| statements(&arm.body, look));
                statements(otherwise, look);
            }
            What::While(condition, body) | What::Repeat(body, condition) => {
                expr(condition, look);
                statements(body, look);
            }
            What::For(it) => {
                place(&it.variable, look);
                [&it.first, &it.last, &it.step].into_iter().for_each(|it| expr(it, look));
                statements(&it.body, look);
            }
            What::Break | What::Continue | What::Return | What::Label(_) | What::Goto(_) | What::Comment(_) => {}
        }
    }
}

fn call(it: &Call, look: &mut dyn Look) {
    look.call(it);
    it.instance.iter().for_each(|it| place(it, look));
    for argument in &it.arguments {
        match argument {
            Argument::Value(value) => expr(value, look),
            Argument::Copy(from) | Argument::Reference(from) => place(from, look),
            Argument::Start => {}
        }
    }
    it.outputs.iter().for_each(|(_, to)| place(to, look));
}

/// Visits all parts of a place.
pub(crate) fn place(it: &Place, look: &mut dyn Look) {
    for step in &it.steps {
        if let Step::Index(indices, _) = step {
            indices.iter().for_each(|index| expr(index, look));
        }
    }
}

/// Visits an expression and all its parts.
pub(crate) fn expr(it: &Expr, look: &mut dyn Look) {
    look.expr(it);
    match it {
        Expr::Const(_) | Expr::Bound { .. } | Expr::Now => {}
        Expr::Load(_, from) => place(from, look),
        Expr::Unary(_, _, a) | Expr::Convert(_, _, _, a, _) => expr(a, look),
        Expr::Binary(_, _, a, b, _) => {
            expr(a, look);
            expr(b, look);
        }
        Expr::Select(_, parts) | Expr::Limit(_, parts) => parts.iter().for_each(|part| expr(part, look)),
        Expr::Texts(_, a, b) | Expr::Same(a, b) => {
            place(a, look);
            place(b, look);
        }
        Expr::After(before, value) => {
            statements(before, look);
            expr(value, look);
        }
    }
}

/// Whether evaluating an expression runs statements.
#[derive(Default)]
struct Runs(bool);

impl Look for Runs {
    fn expr(&mut self, it: &Expr) {
        self.0 |= matches!(it, Expr::After(..));
    }
}

/// Whether evaluating an expression runs statements.
pub(crate) fn runs_statements(it: &Expr) -> bool {
    let mut runs = Runs::default();
    expr(it, &mut runs);
    runs.0
}

/// Whether evaluating the arguments of a call, including the indices of its places, runs statements.
pub(crate) fn call_runs_statements(it: &Call) -> bool {
    let mut runs = Runs::default();
    call(it, &mut runs);
    runs.0
}

/// A mutable part of a statement.
pub(crate) enum Part<'a> {
    Place(&'a mut Place),
    Call(&'a mut Call),
}

/// Applies a change to all places in statements.
pub(crate) fn change_places(list: &mut [Statement], change: &mut dyn FnMut(&mut Place)) {
    change_parts(list, &mut |part| {
        if let Part::Place(place) = part {
            change(place);
        }
    });
}

/// Applies a change to all calls in statements.
pub(crate) fn change_calls(list: &mut [Statement], change: &mut dyn FnMut(&mut Call)) {
    change_parts(list, &mut |part| {
        if let Part::Call(call) = part {
            change(call);
        }
    });
}

fn change_parts(list: &mut [Statement], change: &mut dyn FnMut(Part)) {
    for statement in list {
        match &mut statement.what {
            What::Assign(to, value) => {
                change_place(to, change);
                change_expr(value, change);
            }
            What::Copy(to, from) => {
                change_place(to, change);
                change_place(from, change);
            }
            What::Call(it) => change_call(it, change),
            What::If(condition, then, otherwise) => {
                change_expr(condition, change);
                change_parts(then, change);
                change_parts(otherwise, change);
            }
            What::Case(selector, arms, otherwise) => {
                change_expr(selector, change);
                arms.iter_mut().for_each(|arm| change_parts(&mut arm.body, change));
                change_parts(otherwise, change);
            }
            What::While(condition, body) | What::Repeat(body, condition) => {
                change_expr(condition, change);
                change_parts(body, change);
            }
            What::For(it) => {
                change_place(&mut it.variable, change);
                [&mut it.first, &mut it.last, &mut it.step].into_iter().for_each(|it| change_expr(it, change));
                change_parts(&mut it.body, change);
            }
            What::Break | What::Continue | What::Return | What::Label(_) | What::Goto(_) | What::Comment(_) => {}
        }
    }
}

fn change_call(it: &mut Call, change: &mut dyn FnMut(Part)) {
    change(Part::Call(it));
    it.instance.iter_mut().for_each(|it| change_place(it, change));
    for argument in &mut it.arguments {
        match argument {
            Argument::Value(value) => change_expr(value, change),
            Argument::Copy(from) | Argument::Reference(from) => change_place(from, change),
            Argument::Start => {}
        }
    }
    it.outputs.iter_mut().for_each(|(_, to)| change_place(to, change));
}

fn change_place(it: &mut Place, change: &mut dyn FnMut(Part)) {
    change(Part::Place(it));
    for step in &mut it.steps {
        if let Step::Index(indices, _) = step {
            indices.iter_mut().for_each(|index| change_expr(index, change));
        }
    }
}

fn change_expr(it: &mut Expr, change: &mut dyn FnMut(Part)) {
    match it {
        Expr::Const(_) | Expr::Bound { .. } | Expr::Now => {}
        Expr::Load(_, from) => change_place(from, change),
        Expr::Unary(_, _, a) | Expr::Convert(_, _, _, a, _) => change_expr(a, change),
        Expr::Binary(_, _, a, b, _) => {
            change_expr(a, change);
            change_expr(b, change);
        }
        Expr::Select(_, parts) | Expr::Limit(_, parts) => parts.iter_mut().for_each(|part| change_expr(part, change)),
        Expr::Texts(_, a, b) | Expr::Same(a, b) => {
            change_place(a, change);
            change_place(b, change);
        }
        Expr::After(before, value) => {
            change_parts(before, change);
            change_expr(value, change);
        }
    }
}
