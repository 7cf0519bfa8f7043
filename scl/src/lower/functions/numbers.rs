//! Numeric functions: mathematics, limits, scaling, shifts, and selection.

use super::super::Lowerer;
use super::super::convert::{binary, convert, unary, zero};
use super::super::paths::Variable;
use super::Given;
use crate::check::compiler::Operand;
use crate::check::types::{Class, Elementary, Type};
use crate::front::lexer::Span;
use crate::ir::{Arm, Binary, Convert, Expr, Scalar, Statement, Unary, Value, What};

/// The maximum number of inputs of MIN, MAX and MUX.
const MOST_INPUTS: usize = 32;

impl Lowerer<'_, '_> {
    pub(super) fn float_function(&mut self, operation: Unary, given: &Given, expected: Option<Elementary>) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let span = self.argument_span(given, "IN", 0);
        let of = match &operand {
            Operand::Value(Elementary::LReal, _) => Elementary::LReal,
            Operand::Value(Elementary::Real, _) => Elementary::Real,
            Operand::Wrong(_) => return Operand::Wrong(None),
            _ => expected.filter(|of| of.class() == Class::Real).unwrap_or_else(|| self.widest_real()),
        };
        let value = self.converted(operand, of, span);
        Operand::Value(of, unary(operation, of.scalar(), value))
    }

    pub(super) fn absolute(&mut self, given: &Given) -> Operand {
        match self.argument(given, "IN", 0) {
            Operand::Whole(whole) => Operand::Whole(whole.abs()),
            Operand::Fraction(wide, narrow) => Operand::Fraction(wide.abs(), narrow.abs()),
            Operand::Value(of, value) if of.is_number() || of.class() == Class::Time => {
                Operand::Value(of, unary(Unary::Abs, of.scalar(), value))
            }
            Operand::Wrong(_) => Operand::Wrong(None),
            other => {
                let found = self.type_name(&other);
                self.error(given.span, format!("ABS cannot be applied to {found}"), None)
            }
        }
    }

    pub(super) fn square(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let expected = expected.filter(|of| of.class() == Class::Real).or(Some(self.widest_real()));
        let Some((of, value)) = self.typed(operand, expected, given.span) else { return Operand::Wrong(None) };
        let to = if of.class() == Class::Real { of } else { expected.unwrap_or(of) };
        let at = self.at(given.span);
        let value = convert(value, of.scalar(), to.scalar(), Convert::Value, at);
        let (code, (place, _)) = self.aside(|lowerer| lowerer.kept(to, value, given.span));
        let load = || Box::new(Expr::Load(to.scalar(), place.clone()));
        let product = Expr::Binary(Binary::Mul, to.scalar(), load(), load(), at);
        Operand::Value(to, Expr::After(code, Box::new(product)))
    }

    pub(super) fn extreme(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operation = if given.name == "MIN" { Binary::Min } else { Binary::Max };
        let operands: Vec<Operand> = given.all().iter().map(|argument| self.operand(argument.value, None)).collect();
        if !(2..=MOST_INPUTS).contains(&operands.len()) {
            return self.error(given.span, format!("{} needs 2 to 32 inputs", given.name), None);
        }
        let Some(of) = self.common_of(&operands, expected, given.span) else { return Operand::Wrong(None) };
        let at = self.at(given.span);
        let values = self.all(operands, of, given.span);
        let value = values.into_iter().reduce(|one, other| binary(operation, of.scalar(), one, other, at));
        value.map_or(Operand::Wrong(None), |value| Operand::Value(of, value))
    }

    pub(super) fn limited(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operands: Vec<Operand> = ["MN", "IN", "MX"]
            .iter()
            .enumerate()
            .map(|(position, name)| self.argument(given, name, position))
            .collect();
        let Some(of) = self.common_of(&operands, expected, given.span) else { return Operand::Wrong(None) };
        let values = self.all(operands, of, given.span);
        match <[Expr; 3]>::try_from(values) {
            Ok(values) => Operand::Value(of, Expr::Limit(of.scalar(), Box::new(values))),
            Err(_) => Operand::Wrong(None),
        }
    }

    pub(super) fn shifted(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operation = match given.name {
            "SHL" => Binary::Shl,
            "SHR" => Binary::Shr,
            "ROL" => Binary::Rol,
            _ => Binary::Ror,
        };
        let operand = self.argument(given, "IN", 0);
        let expected = expected.filter(|of| of.is_whole());
        let Some((of, value)) = self.typed(operand, expected, given.span) else { return Operand::Wrong(None) };
        let amount = self.argument(given, "N", 1);
        let span = self.argument_span(given, "N", 1);
        let Some((of_amount, amount)) = self.typed(amount, Some(Elementary::UDInt), span) else {
            return Operand::Wrong(None);
        };
        if !of.is_whole() || !of_amount.is_whole() {
            let name = given.name;
            return self.error(given.span, format!("{name} needs a bit string or integer IN and an integer N"), None);
        }
        let at = self.at(given.span);
        let amount = convert(amount, of_amount.scalar(), Scalar::U32, Convert::Value, at);
        Operand::Value(of, binary(operation, of.scalar(), value, amount, at))
    }

    pub(super) fn swapped(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let Some((of, value)) = self.typed(operand, expected, given.span) else { return Operand::Wrong(None) };
        if !of.is_whole() {
            return self.error(given.span, format!("SWAP cannot be applied to {}", of.name()), None);
        }
        Operand::Value(of, unary(Unary::Swap, of.scalar(), value))
    }

    /// The floating-point type of an operation on these operands.
    pub(super) fn real_of(&self, operands: &[Operand], expected: Option<Elementary>) -> Elementary {
        let is_wide = operands.iter().any(|operand| matches!(operand, Operand::Value(Elementary::LReal, _)));
        if is_wide || expected == Some(Elementary::LReal) { Elementary::LReal } else { Elementary::Real }
    }

    pub(super) fn normed(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operands: Vec<Operand> = ["MIN", "VALUE", "MAX"]
            .iter()
            .enumerate()
            .map(|(position, name)| self.argument(given, name, position))
            .collect();
        let of = self.real_of(&operands, expected);
        let at = self.at(given.span);
        let values: Vec<Expr> = self.all(operands, of, given.span);
        let (code, [low, value, high]) = self.aside(|lowerer| lowerer.kept_all(of, values, given.span));
        let scalar = of.scalar();
        let above = binary(Binary::Sub, scalar, value, low.clone(), at);
        let range = binary(Binary::Sub, scalar, high, low, at);
        Operand::Value(of, Expr::After(code, Box::new(binary(Binary::Div, scalar, above, range, at))))
    }

    fn kept_all(&mut self, of: Elementary, values: Vec<Expr>, span: Span) -> [Expr; 3] {
        let mut kept = values
            .into_iter()
            .map(|value| if matches!(value, Expr::Const(_)) { value } else { self.kept(of, value, span).1 });
        [(); 3].map(|()| kept.next().unwrap_or(zero(of)))
    }

    pub(super) fn scaled(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operands: Vec<Operand> = ["MIN", "VALUE", "MAX"]
            .iter()
            .enumerate()
            .map(|(position, name)| self.argument(given, name, position))
            .collect();
        let limits = [&operands[0], &operands[2]];
        let of_limits = limits.iter().find_map(|operand| match operand {
            Operand::Value(of, _) => Some(*of),
            _ => None,
        });
        let of = self.real_of(&operands, expected);
        let to = expected.or(of_limits).filter(|to| to.is_number()).unwrap_or(of);
        let at = self.at(given.span);
        let values: Vec<Expr> = self.all(operands, of, given.span);
        let (code, [low, value, high]) = self.aside(|lowerer| lowerer.kept_all(of, values, given.span));
        let scalar = of.scalar();
        let range = binary(Binary::Sub, scalar, high, low.clone(), at);
        let product = binary(Binary::Mul, scalar, value, range, at);
        let sum = binary(Binary::Add, scalar, product, low, at);
        let result = convert(Expr::After(code, Box::new(sum)), scalar, to.scalar(), Convert::Value, at);
        Operand::Value(to, result)
    }

    pub(super) fn rounded(&mut self, name: &str, given: &Given, expected: Option<Elementary>) -> Operand {
        let how = match name {
            "ROUND" => Convert::Value,
            "TRUNC" => Convert::Trunc,
            "CEIL" => Convert::Ceil,
            _ => Convert::Floor,
        };
        let operand = self.argument(given, "IN", 0);
        let Some((from, value)) = self.typed(operand, None, given.span) else { return Operand::Wrong(None) };
        let to = expected.filter(|to| to.is_number()).unwrap_or(Elementary::DInt);
        let at = self.at(given.span);
        let value = match from.class() {
            Class::Real => value,
            Class::Integer | Class::Bits => convert(value, from.scalar(), Scalar::F64, Convert::Value, at),
            _ => return self.error(given.span, format!("{name} cannot be applied to {}", from.name()), None),
        };
        let from = if from.class() == Class::Real { from.scalar() } else { Scalar::F64 };
        if to.class() == Class::Real {
            let whole = convert(value, from, Scalar::I64, how, at);
            return Operand::Value(to, convert(whole, Scalar::I64, to.scalar(), Convert::Value, at));
        }
        Operand::Value(to, convert(value, from, to.scalar(), how, at))
    }

    pub(super) fn fraction(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let operand = self.argument(given, "IN", 0);
        let of = self.real_of(std::slice::from_ref(&operand), expected);
        let value = self.converted(operand, of, given.span);
        Operand::Value(of, unary(Unary::Frac, of.scalar(), value))
    }

    pub(super) fn selected(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let condition = self.argument(given, "G", 0);
        let condition = self.condition(condition, given.span);
        let operands = vec![self.argument(given, "IN0", 1), self.argument(given, "IN1", 2)];
        if let [Operand::Text(..) | Operand::Variable(..), Operand::Text(..) | Operand::Variable(..)] =
            operands.as_slice()
        {
            return self.selected_variable(condition, operands, given.span);
        }
        let Some(of) = self.common_of(&operands, expected, given.span) else { return Operand::Wrong(None) };
        let mut values = self.all(operands, of, given.span).into_iter();
        let (Some(no), Some(yes)) = (values.next(), values.next()) else { return Operand::Wrong(None) };
        Operand::Value(of, Expr::Select(of.scalar(), Box::new([condition, yes, no])))
    }

    /// SEL of two strings or structures: copies one of them.
    fn selected_variable(&mut self, condition: Expr, operands: Vec<Operand>, span: Span) -> Operand {
        let (chosen, mut copies) = self.copies(operands, span);
        let (yes, no) = (copies.pop().unwrap_or_default(), copies.pop().unwrap_or_default());
        self.push(span, What::If(condition, yes, no));
        Operand::Variable(chosen.of, chosen.place)
    }

    /// A temporary for one of several strings or structures, and for each of these the statements that copy it there.
    fn copies(&mut self, operands: Vec<Operand>, span: Span) -> (Variable, Vec<Vec<Statement>>) {
        let mut of = Type::Text { capacity: 254, wide: false };
        for operand in &operands {
            match operand {
                Operand::Variable(Type::Text { wide, .. }, _) | Operand::Text(_, Some(wide)) => {
                    of = Type::Text { capacity: 254, wide: *wide };
                    break;
                }
                Operand::Variable(other, _) => {
                    of = other.clone();
                    break;
                }
                _ => {}
            }
        }
        let chosen = Variable::whole(of.clone(), self.temp(self.compiler.lowered(&of)));
        let copy = |operand| self.aside(|lowerer| lowerer.assign(&chosen, operand, span)).0;
        let copies = operands.into_iter().map(copy).collect();
        (chosen, copies)
    }

    /// MUX of strings or structures; the result is empty if K selects none and INELSE is absent.
    fn multiplexed_variable(
        &mut self,
        number: Expr,
        operands: Vec<Operand>,
        has_otherwise: bool,
        span: Span,
    ) -> Operand {
        let (chosen, mut copies) = self.copies(operands, span);
        let otherwise = if has_otherwise { copies.pop().unwrap_or_default() } else { Vec::new() };
        let arm = |(index, body)| Arm { values: vec![(index as i64, index as i64)], body };
        let arms = copies.into_iter().enumerate().map(arm).collect();
        self.push(span, What::Case(number, arms, otherwise));
        Operand::Variable(chosen.of, chosen.place)
    }

    pub(super) fn multiplexed(&mut self, given: &Given, expected: Option<Elementary>) -> Operand {
        let number = self.argument(given, "K", 0);
        let Some((of_number, number)) = self.typed(number, Some(Elementary::DInt), given.span) else {
            return Operand::Wrong(None);
        };
        let mut operands = Vec::new();
        while operands.len() < MOST_INPUTS
            && let Some(id) = given.find(&format!("IN{}", operands.len()), operands.len() + 1)
        {
            operands.push(self.operand(id, None));
        }
        let otherwise = given.find("INELSE", None).map(|id| self.operand(id, None));
        let has_otherwise = otherwise.is_some();
        operands.extend(otherwise);
        if operands.is_empty() {
            return self.error(given.span, "MUX is called without IN0", None);
        }
        if operands.iter().all(|operand| matches!(operand, Operand::Text(..) | Operand::Variable(..))) {
            return self.multiplexed_variable(number, operands, has_otherwise, given.span);
        }
        let Some(of) = self.common_of(&operands, expected, given.span) else { return Operand::Wrong(None) };
        let mut values = self.all(operands, of, given.span);
        let at = self.at(given.span);
        let mut value = if has_otherwise { values.pop().unwrap_or(zero(of)) } else { zero(of) };
        let (code, (_, number)) = self.aside(|lowerer| lowerer.kept(of_number, number, given.span));
        for (index, input) in values.into_iter().enumerate().rev() {
            let this = Expr::Const(Value::new(of_number.scalar(), index as u64));
            let is_this = binary(Binary::Eq, of_number.scalar(), number.clone(), this, at);
            value = Expr::Select(of.scalar(), Box::new([is_this, input, value]));
        }
        Operand::Value(of, Expr::After(code, Box::new(value)))
    }
}
