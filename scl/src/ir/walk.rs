//! Visits all parts of statements.

use super::{Argument, Body, Call, Expr, Place, Program, Statement, Step, What};
use std::collections::BTreeSet;

/// Defines a visitor and the functions that walk it through all parts: read-only with `iter`, mutable with
/// `iter_mut, mut`.
macro_rules! walk {
    ($Look:ident, $iter:ident $(, $mut:ident)?) => {
        /// A visitor. Each part is visited before its own parts.
        pub(crate) trait $Look {
            fn statement(&mut self, _: &$($mut)? Statement) {}
            fn expr(&mut self, _: &$($mut)? Expr) {}
            fn call(&mut self, _: &$($mut)? Call) {}
            fn place(&mut self, _: &$($mut)? Place) {}
        }

        /// Visits statements and all their parts.
        pub(crate) fn statements(list: &$($mut)? [Statement], look: &mut dyn $Look) {
            for statement in list {
                look.statement(statement);
                match &$($mut)? statement.what {
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
                        arms.$iter().for_each(|arm| statements(&$($mut)? arm.body, look));
                        statements(otherwise, look);
                    }
                    What::While(condition, body) | What::Repeat(body, condition) => {
                        expr(condition, look);
                        statements(body, look);
                    }
                    What::For(it) => {
                        place(&$($mut)? it.variable, look);
                        expr(&$($mut)? it.first, look);
                        expr(&$($mut)? it.last, look);
                        expr(&$($mut)? it.step, look);
                        statements(&$($mut)? it.body, look);
                    }
                    What::Break | What::Continue | What::Return | What::Label(_) | What::Goto(_) | What::Comment(_) => {}
                }
            }
        }

        /// Visits a call and all its parts.
        fn call(it: &$($mut)? Call, look: &mut dyn $Look) {
            look.call(it);
            it.instance.$iter().for_each(|it| place(it, look));
            for argument in it.arguments.$iter() {
                match argument {
                    Argument::Value(value) => expr(value, look),
                    Argument::Copy(from) | Argument::Reference(from) => place(from, look),
                    Argument::Start => {}
                }
            }
            it.outputs.$iter().for_each(|(_, to)| place(to, look));
        }

        /// Visits a place and all its parts.
        pub(crate) fn place(it: &$($mut)? Place, look: &mut dyn $Look) {
            look.place(it);
            for step in it.steps.$iter() {
                if let Step::Index(indices, _) = step {
                    indices.$iter().for_each(|index| expr(index, look));
                }
            }
        }

        /// Visits an expression and all its parts.
        pub(crate) fn expr(it: &$($mut)? Expr, look: &mut dyn $Look) {
            look.expr(it);
            match it {
                Expr::Const(_) | Expr::Bound { .. } | Expr::Now => {}
                Expr::Load(_, from) => place(from, look),
                Expr::Unary(_, _, a) | Expr::Convert(_, _, _, a, _) => expr(a, look),
                Expr::Binary(_, _, a, b, _) => {
                    expr(a, look);
                    expr(b, look);
                }
                Expr::Select(_, parts) | Expr::Limit(_, parts) => parts.$iter().for_each(|part| expr(part, look)),
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
    };
}

walk!(Look, iter);

/// The same walk with mutable parts.
pub(crate) mod change {
    use super::{Argument, Call, Expr, Place, Statement, Step, What};

    walk!(Change, iter_mut, mut);
}

/// Set if any visited expression runs statements when it is evaluated.
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

/// Whether any statement, including nested ones, satisfies the predicate.
pub(crate) fn any(list: &[Statement], is_one: fn(&What) -> bool) -> bool {
    struct Finds(bool, fn(&What) -> bool);
    impl Look for Finds {
        fn statement(&mut self, it: &Statement) {
            self.0 |= (self.1)(&it.what);
        }
    }
    let mut finds = Finds(false, is_one);
    statements(list, &mut finds);
    finds.0
}

/// Calls `show` for each call in a list of statements.
pub(crate) fn each_call(list: &[Statement], show: &mut dyn FnMut(&Call)) {
    struct Calls<'s>(&'s mut dyn FnMut(&Call));
    impl Look for Calls<'_> {
        fn call(&mut self, call: &Call) {
            (self.0)(call);
        }
    }
    statements(list, &mut Calls(show));
}

/// The given functions and everything they call, callees first. A native function calls the law added for it.
pub(crate) fn reached(program: &Program, functions: &[usize]) -> Vec<usize> {
    fn add(program: &Program, number: usize, done: &mut BTreeSet<usize>, into: &mut Vec<usize>) {
        if !done.insert(number) {
            return;
        }
        if let Body::Code(body) = &program.functions[number].body {
            each_call(body, &mut |call| add(program, call.function, done, into));
        }
        if let Some(law) = program.docs.laws.get(&number) {
            add(program, *law, done, into);
        }
        into.push(number);
    }
    let (mut done, mut into) = (BTreeSet::new(), Vec::new());
    for number in functions {
        add(program, *number, &mut done, &mut into);
    }
    into
}
