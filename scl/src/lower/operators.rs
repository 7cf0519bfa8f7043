//! Operators and the types in which they are computed.

use super::Lowerer;
use super::convert::{binary, unary, zero};
use crate::check::compiler::Operand;
use crate::check::types::{Class, Elementary, Type};
use crate::check::undeclared::Missing;
use crate::front::lexer::Span;
use crate::front::syntax::{Binary, Unary};
use crate::ir::{self, Expr};

impl Lowerer<'_, '_> {
    /// Lowers `+a`, `-a` or `NOT a`.
    pub(crate) fn unary(&mut self, operator: Unary, operand: Operand, span: Span) -> Operand {
        match (operator, operand) {
            (_, Operand::Wrong(name)) => Operand::Wrong(name.inspect(|name| {
                if operator == Unary::Not {
                    self.guess(name, Elementary::Bool);
                }
            })),
            (Unary::Plus, operand) => operand,
            (Unary::Minus, Operand::Whole(whole)) => Operand::Whole(-whole),
            (Unary::Minus, Operand::Fraction(wide, narrow)) => Operand::Fraction(-wide, -narrow),
            (Unary::Minus, Operand::Value(of, value)) if of.is_number() || of.class() == Class::Time => {
                Operand::Value(of, unary(ir::Unary::Neg, of.scalar(), value))
            }
            (Unary::Not, Operand::Whole(whole)) => {
                let of = Elementary::bit_string(self.widest(whole).bits());
                let value = self.converted(Operand::Whole(whole), of, span);
                Operand::Value(of, unary(ir::Unary::Not, of.scalar(), value))
            }
            (Unary::Not, Operand::Value(of, value)) if of.is_whole() || of == Elementary::Bool => {
                Operand::Value(of, unary(ir::Unary::Not, of.scalar(), value))
            }
            (_, operand) => {
                let of = self.type_name(&operand);
                let operator = if operator == Unary::Not { "NOT" } else { "a sign" };
                self.error(span, format!("{operator} cannot be applied to {of}"), None)
            }
        }
    }

    /// The type name of an operand, for messages.
    pub(crate) fn type_name(&self, operand: &Operand) -> String {
        match operand {
            Operand::Whole(_) => "an integer".to_string(),
            Operand::Fraction(..) => "a number".to_string(),
            Operand::Text(..) => "a string".to_string(),
            Operand::Value(of, _) => of.name().to_string(),
            Operand::Variable(Type::Instance(block), _) => {
                format!("an instance of {}", self.compiler.blocks[*block].name)
            }
            Operand::Variable(of, _) => of.to_string(),
            Operand::Wrong(_) => "an invalid operand".to_string(),
        }
    }

    /// Lowers `left operator right`.
    pub(crate) fn binary(&mut self, operator: Binary, left: Operand, right: Operand, span: Span) -> Operand {
        let (left, right) = match (left, right) {
            (Operand::Wrong(name), other) | (other, Operand::Wrong(name)) => {
                if let Some(name) = name {
                    self.guess_from(operator, &name, &other);
                }
                if let Operand::Wrong(Some(other)) = other {
                    self.guess_from(operator, &other, &Operand::Wrong(None));
                }
                return Operand::Wrong(None);
            }
            both => both,
        };
        match operator {
            Binary::And | Binary::Or | Binary::Xor => self.bits(operator, left, right, span),
            Binary::Power => self.power(left, right, span),
            Binary::Add | Binary::Subtract | Binary::Multiply | Binary::Divide | Binary::Modulo => {
                let has_sum = matches!(operator, Binary::Add | Binary::Subtract);
                match has_sum.then(|| self.moments(operator, &left, &right, span)).flatten() {
                    Some(moment) => moment,
                    None => self.arithmetic(operator, left, right, span),
                }
            }
            _ => self.comparison(operator, left, right, span),
        }
    }

    /// Infers the type of an undeclared operand from the operator and the other operand.
    fn guess_from(&mut self, operator: Binary, name: &Missing, other: &Operand) {
        match (other, operator) {
            (Operand::Wrong(_), Binary::And | Binary::Or | Binary::Xor) => self.guess(name, Elementary::Bool),
            (Operand::Wrong(_), Binary::Modulo) => self.guess(name, Elementary::DInt),
            (Operand::Wrong(_), Binary::Equal | Binary::NotEqual) => {}
            (Operand::Wrong(_), _) => self.compiler.guess_likely(name, Elementary::Real),
            (Operand::Whole(_), _) => self.guess(name, Elementary::Int),
            (other, _) => self.guess_like(name, other),
        }
    }

    fn refuse(&mut self, operator: &str, left: &Operand, right: &Operand, span: Span, help: Option<&str>) -> Operand {
        let (left, right) = (self.type_name(left), self.type_name(right));
        self.error(span, format!("{operator} cannot be applied to {left} and {right}"), help)
    }

    /// Applies an operation to both operands, converted to one type.
    fn both(&mut self, operation: ir::Binary, of: Elementary, left: Operand, right: Operand, span: Span) -> Expr {
        let left = self.widened(left, of, span);
        let right = self.widened(right, of, span);
        let at = self.at(span);
        binary(operation, of.scalar(), left, right, at)
    }

    /// Converts an operand to the type of the operation as in an assignment, but without warnings.
    fn widened(&mut self, operand: Operand, to: Elementary, span: Span) -> Expr {
        match operand {
            Operand::Value(from, value) if from.is_number() && to.is_number() => {
                let at = self.at(span);
                super::convert::convert(value, from.scalar(), to.scalar(), ir::Convert::Value, at)
            }
            other => self.converted(other, to, span),
        }
    }

    fn bits(&mut self, operator: Binary, left: Operand, right: Operand, span: Span) -> Operand {
        let (operation, name) = match operator {
            Binary::And => (ir::Binary::And, "AND"),
            Binary::Or => (ir::Binary::Or, "OR"),
            _ => (ir::Binary::Xor, "XOR"),
        };
        let of = match (&left, &right) {
            (Operand::Value(left, _), Operand::Value(right, _)) if left == right && *left == Elementary::Bool => {
                Some(*left)
            }
            (Operand::Value(left, _), Operand::Value(right, _)) if left.is_whole() && right.is_whole() => {
                Some(Elementary::bit_string(left.bits().max(right.bits())))
            }
            (Operand::Value(of, _), Operand::Whole(_)) | (Operand::Whole(_), Operand::Value(of, _))
                if of.is_whole() || *of == Elementary::Bool =>
            {
                Some(*of)
            }
            (Operand::Whole(left), Operand::Whole(right)) => {
                Some(Elementary::bit_string(self.widest(*left.max(right)).bits()))
            }
            _ => None,
        };
        match of {
            Some(of) => Operand::Value(of, self.both(operation, of, left, right, span)),
            None => {
                let help = "both sides must be BOOL, or both must be bit strings; to use a number, compare it first";
                self.refuse(name, &left, &right, span, Some(help))
            }
        }
    }

    fn power(&mut self, left: Operand, right: Operand, span: Span) -> Operand {
        let of_value = |operand: &Operand| match operand {
            Operand::Value(of, _) => Some(*of),
            _ => None,
        };
        let kinds = [of_value(&left), of_value(&right)];
        let are_numbers = kinds.iter().flatten().all(|of| of.is_number())
            && ![&left, &right].iter().any(|operand| matches!(operand, Operand::Variable(..) | Operand::Text(..)));
        if !are_numbers {
            return self.refuse("**", &left, &right, span, None);
        }
        let of = match kinds {
            _ if kinds.contains(&Some(Elementary::LReal)) => Elementary::LReal,
            _ if kinds.contains(&Some(Elementary::Real)) => Elementary::Real,
            _ => self.widest_real(),
        };
        Operand::Value(of, self.both(ir::Binary::Pow, of, left, right, span))
    }

    /// The type in which two operands are computed or compared; `None` if they have no common type.
    pub(crate) fn common(&self, left: &Operand, right: &Operand) -> Option<Elementary> {
        use Operand::{Fraction, Value, Whole};
        match (left, right) {
            (Value(left, _), Value(right, _)) => left.common(*right),
            (Value(of, _), Whole(_)) | (Whole(_), Value(of, _)) => Some(*of),
            (Value(of, _), Fraction(..)) | (Fraction(..), Value(of, _)) => match of.class() {
                Class::Real => Some(*of),
                Class::Integer | Class::Bits => Some(self.widest_real()),
                _ => None,
            },
            (Whole(left), Whole(right)) => {
                let larger = if left.abs() > right.abs() { left } else { right };
                Some(self.widest(*larger))
            }
            (Fraction(..), Whole(_) | Fraction(..)) | (Whole(_), Fraction(..)) => Some(self.widest_real()),
            (Value(of, _), Operand::Text(text, _)) | (Operand::Text(text, _), Value(of, _))
                if of.class() == Class::Character && text.len() == 1 =>
            {
                Some(*of)
            }
            _ => None,
        }
    }

    fn arithmetic(&mut self, operator: Binary, left: Operand, right: Operand, span: Span) -> Operand {
        let (operation, name) = match operator {
            Binary::Add => (ir::Binary::Add, "+"),
            Binary::Subtract => (ir::Binary::Sub, "-"),
            Binary::Multiply => (ir::Binary::Mul, "*"),
            Binary::Divide => (ir::Binary::Div, "/"),
            _ => (ir::Binary::Rem, "MOD"),
        };
        let class = |operand: &Operand| match operand {
            Operand::Value(of, _) => Some(of.class()),
            _ => None,
        };
        if class(&left) == Some(Class::Time) || class(&right) == Some(Class::Time) {
            return self.durations(operator, operation, name, left, right, span);
        }
        let common = self.common(&left, &right).filter(|of| of.is_number());
        let Some(mut of) = common else {
            return self.refuse(name, &left, &right, span, None);
        };
        if of.class() == Class::Real && operator == Binary::Modulo {
            return self.refuse(name, &left, &right, span, Some("MOD needs integers"));
        }
        if of.class() == Class::Bits {
            of = Elementary::integer(of.bits(), false);
        }
        let value = self.both(operation, of, left, right, span);
        if let Expr::Binary(ir::Binary::Div | ir::Binary::Rem, _, _, by, _) = &value
            && matches!(**by, Expr::Const(by) if of.is_whole() && by.bits() == 0)
        {
            self.warn(span, "division by 0: the result is 0", None);
        }
        Operand::Value(of, value)
    }

    fn durations(
        &mut self,
        operator: Binary,
        operation: ir::Binary,
        name: &str,
        left: Operand,
        right: Operand,
        span: Span,
    ) -> Operand {
        let of = |operand: &Operand| match operand {
            Operand::Value(of, _) => Some(*of),
            Operand::Whole(_) => Some(Elementary::DInt),
            _ => None,
        };
        let (Some(one), Some(other)) = (of(&left), of(&right)) else {
            let help = "multiply a TIME by an integer, or convert through DINT";
            return self.refuse(name, &left, &right, span, Some(help));
        };
        let is_long = one == Elementary::LTime || other == Elementary::LTime;
        let time = if is_long { Elementary::LTime } else { Elementary::Time };
        let is_time = |of: Elementary| of.class() == Class::Time;
        let is_possible = match operator {
            Binary::Add | Binary::Subtract => [one, other].iter().all(|of| is_time(*of) || of.is_whole()),
            Binary::Multiply => is_time(one) != is_time(other) && (one.is_whole() || other.is_whole()),
            Binary::Divide => is_time(one) && other.is_whole(),
            _ => false,
        };
        if !is_possible {
            let help = "add TIME to TIME, multiply or divide it by an integer, or convert it with TIME_TO_DINT";
            return self.refuse(name, &left, &right, span, Some(help));
        }
        // An integer combined with a TIME is assumed to be in the same unit.
        let number = if is_long { Elementary::LInt } else { Elementary::DInt };
        let mut operand = |operand: Operand| match operand {
            Operand::Value(of, value) if is_time(of) => self.implicit(value, of, time, span),
            other => self.widened(other, number, span),
        };
        let (left, right) = (operand(left), operand(right));
        let at = self.at(span);
        Operand::Value(time, binary(operation, time.scalar(), left, right, at))
    }

    fn comparison(&mut self, operator: Binary, left: Operand, right: Operand, span: Span) -> Operand {
        let (operation, name) = match operator {
            Binary::Less => (ir::Binary::Lt, "<"),
            Binary::LessOrEqual => (ir::Binary::Le, "<="),
            Binary::Greater => (ir::Binary::Gt, ">"),
            Binary::GreaterOrEqual => (ir::Binary::Ge, ">="),
            Binary::Equal => (ir::Binary::Eq, "="),
            _ => (ir::Binary::Ne, "<>"),
        };
        let is_equality = matches!(operator, Binary::Equal | Binary::NotEqual);
        let is_text =
            |operand: &Operand| matches!(operand, Operand::Text(..) | Operand::Variable(Type::Text { .. }, _));
        if !is_equality && let Some([left, right]) = self.compared_moments(&left, &right, span) {
            return self.comparison(operator, left, right, span);
        }
        if let (Operand::Variable(one, place), Operand::Variable(other, with)) = (&left, &right)
            && !is_text(&left)
        {
            if !is_equality || !one.is_like(other) || matches!(one, Type::Instance(_)) {
                return self.refuse(name, &left, &right, span, None);
            }
            let same = Expr::Same(place.clone(), with.clone());
            let negated = operator == Binary::NotEqual;
            let value = if negated { unary(ir::Unary::Not, ir::Scalar::Bool, same) } else { same };
            return Operand::Value(Elementary::Bool, value);
        }
        let common = self.common(&left, &right);
        if common.is_none() && is_text(&left) && is_text(&right) {
            let width = |operand: &Operand| match operand {
                Operand::Variable(Type::Text { wide, .. }, _) => Some(*wide),
                Operand::Text(text, wide) => wide.or(text.iter().any(|unit| *unit > 255).then_some(true)),
                _ => None,
            };
            let (one, other) = (width(&left), width(&right));
            if one.is_some() && other.is_some() && one != other {
                let help = "a STRING cannot be compared with a WSTRING: write WSTRING#'...', or use one type";
                return self.refuse(name, &left, &right, span, Some(help));
            }
            // An untyped string takes the type of the other operand.
            let of_other = |operand: Operand| match operand {
                Operand::Text(text, None) => Operand::Text(text, one.or(other)),
                operand => operand,
            };
            let (left, right) = (self.text_place(of_other(left)), self.text_place(of_other(right)));
            let (Some(left), Some(right)) = (left, right) else { return Operand::Wrong(None) };
            return Operand::Value(Elementary::Bool, Expr::Texts(operation, left, right));
        }
        let of = common.or_else(|| match (&left, &right) {
            // An integer compared with a TIME is a number of milliseconds, with an LTIME of nanoseconds.
            (Operand::Value(one, _), Operand::Value(other, _)) if one.class() == Class::Time && other.is_whole() => {
                Some(*one)
            }
            (Operand::Value(one, _), Operand::Value(other, _)) if other.class() == Class::Time && one.is_whole() => {
                Some(*other)
            }
            (Operand::Value(one, _), Operand::Value(other, _))
                if one.class() == Class::Character && other.is_whole() =>
            {
                Some(*other)
            }
            (Operand::Value(one, _), Operand::Value(other, _))
                if other.class() == Class::Character && one.is_whole() =>
            {
                Some(*one)
            }
            _ => None,
        });
        let Some(of) = of else {
            return self.refuse(name, &left, &right, span, None);
        };
        if of == Elementary::Bool && !is_equality {
            return self.refuse(name, &left, &right, span, Some("BOOL can only be compared with = and <>"));
        }
        if let (Operand::Value(Elementary::Real, _), Operand::Value(Elementary::LReal, _))
        | (Operand::Value(Elementary::LReal, _), Operand::Value(Elementary::Real, _)) = (&left, &right)
        {
            self.warn(span, "REAL is compared with LREAL: the REAL is converted", Some("convert one of them"));
        }
        let is_constant =
            |operand: &Operand| !matches!(operand, Operand::Value(_, value) if !matches!(value, Expr::Const(_)));
        if is_equality && of.class() == Class::Real && !(is_constant(&left) && is_constant(&right)) {
            let help = "rounding may keep them from being equal: compare ABS(a - b) with a tolerance";
            self.warn(span, format!("{} values are compared for equality", of.name()), Some(help));
        }
        if of.class() == Class::Time {
            let (left, right) = (self.converted(left, of, span), self.converted(right, of, span));
            let at = self.at(span);
            return Operand::Value(Elementary::Bool, binary(operation, of.scalar(), left, right, at));
        }
        Operand::Value(Elementary::Bool, self.both(operation, of, left, right, span))
    }

    /// A condition as an expression of type BOOL; any other type is reported as an error.
    pub(crate) fn condition(&mut self, operand: Operand, span: Span) -> Expr {
        match operand {
            Operand::Value(Elementary::Bool, value) => value,
            Operand::Wrong(_) | Operand::Whole(0 | 1) => self.converted(operand, Elementary::Bool, span),
            other => {
                let of = self.type_name(&other);
                self.error(
                    span,
                    format!("a condition must be a BOOL, not {of}"),
                    Some("compare it, for example with `<> 0`"),
                );
                zero(Elementary::Bool)
            }
        }
    }
}
