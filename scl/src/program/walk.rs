//! Looks at all parts of statements.

use super::{Argument, Call, Expr, Place, Statement, Step, What};

/// What looks at the parts of statements and expressions.
pub(crate) trait Look {
    /// A statement, before its parts.
    fn statement(&mut self, _: &Statement) {}
    /// An expression, before its parts.
    fn expr(&mut self, _: &Expr) {}
    /// A call, before its arguments.
    fn call(&mut self, _: &Call) {}
}

/// Shows all parts of statements.
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

/// Shows all parts of a place.
pub(crate) fn place(it: &Place, look: &mut dyn Look) {
    for step in &it.steps {
        if let Step::Index(indices, _) = step {
            indices.iter().for_each(|index| expr(index, look));
        }
    }
}

/// Shows an expression and all its parts.
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

/// Whether statements are run while an expression is calculated.
pub(crate) fn runs_statements(it: &Expr) -> bool {
    struct Finds(bool);
    impl Look for Finds {
        fn expr(&mut self, it: &Expr) {
            self.0 |= matches!(it, Expr::After(..));
        }
    }
    let mut finds = Finds(false);
    expr(it, &mut finds);
    finds.0
}
