//! Functions that detect whether a LAD or FBD box fails, for its ENO. Their names contain `?`, so that no source can
//! call them.

use super::Given;
use crate::check::compiler::Operand;
use crate::check::types::{Class, Elementary};
use crate::front::lexer::Span;
use crate::front::syntax::Argument;
use crate::ir::{Binary, Convert, Expr, Scalar, Unary, Value};
use crate::lower::Lowerer;
use crate::lower::convert::{binary, convert, unary};

impl Lowerer<'_, '_> {
    /// Whether a calculation with these operands fails: `ADD?`, `CONVERT?_INT`.
    pub(super) fn failure(&mut self, kind: &str, to: &str, given: &Given) -> Operand {
        let span = given.span;
        let is_target = |argument: &Argument| argument.name.as_ref().is_some_and(|name| name.key() == "OUT");
        let target = given.all().iter().find(|argument| is_target(argument));
        let to = match target {
            None => Elementary::named(to.trim_start_matches('_')),
            // Only its type matters: the code is discarded.
            Some(target) => match self.aside(|lowerer| lowerer.operand(target.value, None)).1 {
                Operand::Value(of, _) => Some(of),
                _ => None,
            },
        };
        if kind == "SCALE_X" {
            return self.scaling_fails(to, given);
        }
        let others = given.all().iter().filter(|argument| !is_target(argument));
        let operands: Vec<Operand> = others.map(|argument| self.operand(argument.value, None)).collect();
        let typed = operands.iter().find_map(|operand| match operand {
            Operand::Value(of, _) => Some(*of),
            _ => None,
        });
        let mut values: Vec<(Elementary, Expr)> = Vec::new();
        for operand in operands {
            let is_number = match &operand {
                Operand::Value(of, _) => of.is_number() || of.class() == Class::Time,
                operand => matches!(operand, Operand::Whole(_) | Operand::Fraction(..)),
            };
            if !is_number {
                return truth(false);
            }
            let Some((of, value)) = self.typed(operand, typed, span) else { return truth(false) };
            let (_, value) = self.kept(of, value, span);
            values.push((of, value));
        }
        let Some((of, first)) = values.first().cloned() else { return truth(false) };
        match kind {
            "CALL" => self.invalid(of, first, span),
            "NEG" | "ABS" if of.class() != Class::Real => match of.scalar().is_signed() {
                true => self.compared(Binary::Eq, of.scalar(), first, low(of), span),
                false => truth(false),
            },
            "NEG" | "ABS" => self.invalid(of, first, span),
            "CONVERT" | "ROUND" | "TRUNC" | "CEIL" | "FLOOR" => self.unfitting(kind, of, first, to, span),
            _ => self.overflow(kind, values, span),
        }
    }

    /// Whether the result of SCALE_X does not fit its type, or is infinite or NaN.
    fn scaling_fails(&mut self, to: Option<Elementary>, given: &Given) -> Operand {
        let span = given.span;
        let names = ["MIN", "VALUE", "MAX"];
        let operands: Vec<Operand> = (0..).zip(names).map(|(at, name)| self.argument(given, name, at)).collect();
        let of = self.real_of(&operands, to);
        match self.scaled(given, Some(of)) {
            Operand::Value(of, value) => {
                let (_, value) = self.kept(of, value, span);
                self.unfitting("CONVERT", of, value, to.or(Some(of)), span)
            }
            _ => truth(false),
        }
    }

    fn compared(&mut self, operation: Binary, ty: Scalar, left: Expr, right: Expr, span: Span) -> Operand {
        let at = self.at(span);
        Operand::Value(Elementary::Bool, binary(operation, ty, left, right, at))
    }

    /// Whether a floating-point number is infinite or NaN; numbers of other types are valid.
    fn invalid(&mut self, of: Elementary, value: Expr, span: Span) -> Operand {
        if of.class() != Class::Real {
            return truth(false);
        }
        let at = self.at(span);
        let (_, value) = self.kept(of, value, span);
        let difference = binary(Binary::Sub, of.scalar(), value.clone(), value, at);
        let nothing = Expr::Const(if of == Elementary::Real { 0f32.into() } else { 0f64.into() });
        let valid = binary(Binary::Eq, of.scalar(), difference, nothing, at);
        Operand::Value(Elementary::Bool, unary(Unary::Not, Scalar::Bool, valid))
    }

    /// Whether a sum, product or similar operation overflows its type at any step.
    fn overflow(&mut self, kind: &str, values: Vec<(Elementary, Expr)>, span: Span) -> Operand {
        let at = self.at(span);
        let mut values = values.into_iter();
        let Some((mut of, mut total)) = values.next() else { return truth(false) };
        let mut failed: Option<Expr> = None;
        for (other, value) in values {
            let common = if of == other { Some(of) } else { of.common(other) };
            let Some(common) = common else { return truth(false) };
            let ty = common.scalar();
            let left = convert(total, of.scalar(), ty, Convert::Value, at);
            let right = convert(value, other.scalar(), ty, Convert::Value, at);
            let operation = match kind {
                "ADD" => Binary::Add,
                "SUB" => Binary::Sub,
                "MUL" => Binary::Mul,
                "DIV" => Binary::Div,
                _ => Binary::Rem,
            };
            let (_, result) = self.kept(common, binary(operation, ty, left.clone(), right.clone(), at), span);
            let step = if common.class() == Class::Real {
                match self.invalid(common, result.clone(), span) {
                    Operand::Value(_, step) => step,
                    _ => return truth(false),
                }
            } else {
                wraps(operation, common, left, right, result.clone(), at)
            };
            failed = Some(match failed {
                None => step,
                Some(before) => binary(Binary::Or, Scalar::Bool, before, step, at),
            });
            (of, total) = (common, result);
        }
        failed.map_or(truth(false), |failed| Operand::Value(Elementary::Bool, failed))
    }

    /// Whether a number does not fit the type to which it is converted or rounded.
    fn unfitting(&mut self, kind: &str, of: Elementary, value: Expr, to: Option<Elementary>, span: Span) -> Operand {
        let at = self.at(span);
        let to = to.unwrap_or(Elementary::DInt);
        if of.class() == Class::Real && to.class() == Class::Real {
            let value = convert(value, of.scalar(), to.scalar(), Convert::Value, at);
            return self.invalid(to, value, span);
        }
        if !to.is_whole() || to.class() == Class::Bits {
            return truth(false);
        }
        let (lowest, highest) = to.range();
        let or = |left: Expr, right: Expr| binary(Binary::Or, Scalar::Bool, left, right, at);
        let failed = if of.class() == Class::Real {
            let value = convert(value, of.scalar(), Scalar::F64, Convert::Value, at);
            let (from, below) = match kind {
                "TRUNC" => ((lowest - 1) as f64, Binary::Gt),
                "CEIL" => ((lowest - 1) as f64, Binary::Gt),
                "FLOOR" => (lowest as f64, Binary::Ge),
                _ => (lowest as f64 - 0.5, Binary::Ge),
            };
            let (until, above) = match kind {
                "TRUNC" | "FLOOR" => ((highest + 1) as f64, Binary::Lt),
                "CEIL" if highest < 1 << 53 => (highest as f64, Binary::Le),
                "CEIL" => ((highest + 1) as f64, Binary::Lt),
                _ if highest < 1 << 52 => (highest as f64 + 0.5, Binary::Lt),
                _ => ((highest + 1) as f64, Binary::Lt),
            };
            let is_above = binary(below, Scalar::F64, value.clone(), Expr::Const(from.into()), at);
            let is_below = binary(above, Scalar::F64, value, Expr::Const(until.into()), at);
            let fits = binary(Binary::And, Scalar::Bool, is_above, is_below, at);
            unary(Unary::Not, Scalar::Bool, fits)
        } else if of.scalar().is_signed() {
            let value = convert(value, of.scalar(), Scalar::I64, Convert::Value, at);
            let lowest = Expr::Const((lowest.max(i128::from(i64::MIN)) as i64).into());
            let highest = Expr::Const((highest.min(i128::from(i64::MAX)) as i64).into());
            or(
                binary(Binary::Lt, Scalar::I64, value.clone(), lowest, at),
                binary(Binary::Gt, Scalar::I64, value, highest, at),
            )
        } else {
            let value = convert(value, of.scalar(), Scalar::U64, Convert::Value, at);
            let highest = Expr::Const(Value::new(Scalar::U64, highest as u64));
            binary(Binary::Gt, Scalar::U64, value, highest, at)
        };
        Operand::Value(Elementary::Bool, failed)
    }
}

fn truth(truth: bool) -> Operand {
    Operand::Value(Elementary::Bool, Expr::Const(truth.into()))
}

/// The lowest value of a type.
fn low(of: Elementary) -> Expr {
    Expr::Const(Value::new(of.scalar(), of.range().0 as u64))
}

/// Whether an integer operation with this result has overflowed its type.
fn wraps(operation: Binary, of: Elementary, left: Expr, right: Expr, result: Expr, at: crate::ir::At) -> Expr {
    let ty = of.scalar();
    let zero = || Expr::Const(Value::new(ty, 0));
    let minus_one = || Expr::Const(Value::new(ty, u64::MAX));
    let and = |one: Expr, other: Expr| binary(Binary::And, Scalar::Bool, one, other, at);
    let or = |one: Expr, other: Expr| binary(Binary::Or, Scalar::Bool, one, other, at);
    let xor = |one: Expr, other: Expr| binary(Binary::Xor, ty, one, other, at);
    let is = |operation: Binary, one: Expr, other: Expr| binary(operation, ty, one, other, at);
    // The only quotient that overflows: the lowest value divided by -1.
    let extreme = |left: Expr, right: Expr| and(is(Binary::Eq, left, low(of)), is(Binary::Eq, right, minus_one()));
    match operation {
        Binary::Add if ty.is_signed() => {
            let signs = binary(Binary::And, ty, xor(left, result.clone()), xor(right, result), at);
            is(Binary::Lt, signs, zero())
        }
        Binary::Add => is(Binary::Lt, result, left),
        Binary::Sub if ty.is_signed() => {
            let signs = binary(Binary::And, ty, xor(left.clone(), right), xor(left, result), at);
            is(Binary::Lt, signs, zero())
        }
        Binary::Sub => is(Binary::Lt, left, right),
        Binary::Mul => {
            let back = is(Binary::Div, result, right.clone());
            let differs = and(is(Binary::Ne, right.clone(), zero()), is(Binary::Ne, back, left.clone()));
            if ty.is_signed() { or(differs, extreme(left, right)) } else { differs }
        }
        Binary::Div if ty.is_signed() => or(is(Binary::Eq, right.clone(), zero()), extreme(left, right)),
        _ => is(Binary::Eq, right, zero()),
    }
}
