//! Implicit and explicit conversions between types.

use super::Lowerer;
use crate::check::compiler::Operand;
use crate::check::types::{Class, Elementary};
use crate::front::lexer::Span;
use crate::ir::{At, Binary, Convert, Expr, Scalar, Unary, Value};
use manifest::Cpu;
use std::fmt::Display;

/// A conversion, folded if its operand is constant.
pub(super) fn convert(value: Expr, from: Scalar, to: Scalar, how: Convert, at: At) -> Expr {
    if from == to && matches!(how, Convert::Value | Convert::Bits) {
        return value;
    }
    if let Expr::Const(constant) = value
        && let Some((converted, _)) = how.fold(constant, to)
    {
        return Expr::Const(converted);
    }
    Expr::Convert(how, from, to, Box::new(value), at)
}

/// A binary operation, folded if both operands are constant and no warning is due.
pub(super) fn binary(operation: Binary, of: Scalar, left: Expr, right: Expr, at: At) -> Expr {
    if let (Expr::Const(left), Expr::Const(right)) = (&left, &right)
        && let Some((result, false)) = operation.fold(*left, *right)
    {
        return Expr::Const(result);
    }
    Expr::Binary(operation, of, Box::new(left), Box::new(right), at)
}

/// A unary operation, folded if its operand is constant.
pub(super) fn unary(operation: Unary, of: Scalar, value: Expr) -> Expr {
    if let Expr::Const(constant) = value
        && let Some(result) = operation.fold(constant)
    {
        return Expr::Const(result);
    }
    Expr::Unary(operation, of, Box::new(value))
}

/// The zero of a type, as a constant.
pub(crate) fn zero(of: Elementary) -> Expr {
    Expr::Const(Value::new(of.scalar(), 0))
}

impl Lowerer<'_, '_> {
    /// The type of an untyped integer literal where the context does not determine it.
    pub(crate) fn widest(&self, whole: i128) -> Elementary {
        match self.compiler.cpu {
            Cpu::S71500 => Elementary::LInt,
            _ if i32::try_from(whole).is_ok() => Elementary::DInt,
            _ => Elementary::LInt,
        }
    }

    /// The type of an untyped floating-point literal where the context does not determine it.
    pub(crate) fn widest_real(&self) -> Elementary {
        if self.compiler.cpu == Cpu::S7300 { Elementary::Real } else { Elementary::LReal }
    }

    /// Converts an operand to a type, as in an assignment.
    pub(crate) fn converted(&mut self, operand: Operand, to: Elementary, span: Span) -> Expr {
        match operand {
            Operand::Value(from, value) => self.implicit(value, from, to, span),
            Operand::Whole(whole) => self.whole_as(whole, to, span),
            Operand::Fraction(wide, narrow) => match to.class() {
                Class::Real if to == Elementary::Real => Expr::Const(narrow.into()),
                Class::Real => Expr::Const(wide.into()),
                _ => {
                    let real = self.widest_real();
                    let value =
                        if real == Elementary::Real { Expr::Const(narrow.into()) } else { Expr::Const(wide.into()) };
                    self.implicit(value, real, to, span)
                }
            },
            Operand::Text(text, _) if to.class() == Class::Character => {
                if text.len() != 1 {
                    self.error(span, format!("a string of {} characters is not a {}", text.len(), to.name()), None);
                }
                Expr::Const(Value::new(to.scalar(), text.first().copied().unwrap_or(0).into()))
            }
            Operand::Text(..) => {
                self.error(span, format!("expected {}, found a string", to.name()), None);
                zero(to)
            }
            Operand::Variable(of, _) => {
                self.error(span, format!("expected {}, found {of}", to.name()), None);
                zero(to)
            }
            Operand::Wrong(name) => {
                if let Some(name) = name {
                    self.guess(&name, to);
                }
                // Deliberately not a constant: it must not be folded or checked.
                Expr::After(Vec::new(), Box::new(zero(to)))
            }
        }
    }

    fn whole_as(&mut self, whole: i128, to: Elementary, span: Span) -> Expr {
        match to.class() {
            Class::Bool if whole == 0 || whole == 1 => Expr::Const(Value::from(whole == 1)),
            Class::Bool => {
                self.error(span, format!("{whole} is not a BOOL"), Some("write TRUE or FALSE"));
                zero(to)
            }
            Class::Real if to == Elementary::Real => Expr::Const((whole as f32).into()),
            Class::Real => Expr::Const((whole as f64).into()),
            Class::Date => {
                self.error(span, format!("{whole} is not a {}", to.name()), None);
                zero(to)
            }
            _ => {
                let value = Value::new(to.scalar(), whole as u64);
                let (low, high) = to.range();
                let is_bits = to.class() == Class::Bits && whole < 0 && whole >= -(1 << (to.bits() - 1));
                let text = self.compiler.text(span);
                let is_pattern = ["2#", "8#", "16#"].iter().any(|base| text.contains(base)) && whole < 1 << to.bits();
                if !(low..=high).contains(&whole) && !is_bits && !is_pattern {
                    let becomes =
                        if to.scalar().is_signed() { value.bits() as i64 as i128 } else { value.bits().into() };
                    self.does_not_fit(whole, to, becomes, span);
                }
                Expr::Const(value)
            }
        }
    }

    /// Warns about a constant that changes when it is converted.
    fn does_not_fit(&mut self, constant: impl Display, to: Elementary, becomes: impl Display, span: Span) {
        let help = match to.bits() {
            ..32 => Some("use a wider type for the variable, such as DINT"),
            32..64 => Some("use a wider type for the variable, such as LINT"),
            _ => None,
        };
        self.warn(span, format!("{constant} does not fit in {}: it becomes {becomes}", to.name()), help);
    }

    /// Converts a value implicitly, as in an assignment; warns about a possible loss.
    pub(crate) fn implicit(&mut self, value: Expr, from: Elementary, to: Elementary, span: Span) -> Expr {
        use Class::{Bits, Bool, Character, Date, Integer, Real, Time};
        if from == to {
            return value;
        }
        let at = self.at(span);
        let may = |elementary: Elementary, others: &[Elementary]| others.contains(&elementary);
        let is_possible = match (from.class(), to.class()) {
            (Bits | Integer | Real, Bits | Integer | Real) => true,
            (Time, Bits | Integer) => of_time(to),
            (Bits | Integer, Time) => of_time(from),
            (Character, Bits | Integer) => {
                may(to, &[Elementary::Byte, Elementary::USInt, Elementary::SInt]) || from == Elementary::WChar
            }
            (Bits | Integer, Character) => {
                may(from, &[Elementary::Byte, Elementary::USInt, Elementary::SInt]) || to == Elementary::WChar
            }
            (Time, Time) => return self.time(value, from, to, at),
            (Character, Character) => true,
            (Date, Bits | Integer) | (Bits | Integer, Date) => from.bits() == to.bits(),
            (Bool, _) | (_, Bool) => false,
            _ => false,
        };
        if !is_possible {
            let help = match (from.class(), to.class()) {
                (Bool, Bits | Integer) | (Bits | Integer, Bool) => {
                    format!("write {}_TO_{}(...)", from.name(), to.name())
                }
                (Time, Real) | (Real, Time) => "convert through DINT, which counts milliseconds".to_string(),
                (Real, Bool) => "compare it with a number".to_string(),
                _ => format!("convert it with {}_TO_{} if that function exists", from.name(), to.name()),
            };
            self.error(span, format!("{} cannot be converted implicitly to {}", from.name(), to.name()), Some(&help));
            return zero(to);
        }
        if let Some(loss) = loss(from, to).filter(|_| !matches!(value, Expr::Const(_))) {
            self.warn(span, format!("{} is converted to {}: {loss}", from.name(), to.name()), None);
        }
        if let (Expr::Const(constant), Real, Integer | Bits) = (&value, from.class(), to.class()) {
            let message = format!("{constant} is rounded when it is converted to {}", to.name());
            self.warn(span, message, None);
        }
        if let (Expr::Const(constant), Integer, Integer) = (&value, from.class(), to.class()) {
            let becomes = Value::new(to.scalar(), constant.bits());
            if becomes.number() != constant.number() {
                self.does_not_fit(constant, to, becomes, span);
            }
        }
        convert(value, from.scalar(), to.scalar(), Convert::Value, at)
    }

    /// Converts between TIME and LTIME.
    fn time(&mut self, value: Expr, from: Elementary, to: Elementary, at: At) -> Expr {
        const NANOSECONDS: i64 = 1_000_000;
        let factor = Expr::Const(NANOSECONDS.into());
        match (from, to) {
            (Elementary::Time, Elementary::LTime) => {
                let wide = convert(value, Scalar::I32, Scalar::I64, Convert::Value, at);
                binary(Binary::Mul, Scalar::I64, wide, factor, at)
            }
            _ => {
                let milliseconds = binary(Binary::Div, Scalar::I64, value, factor, at);
                convert(milliseconds, Scalar::I64, Scalar::I32, Convert::Value, at)
            }
        }
    }

    /// Lowers `X_TO_Y(value)`.
    pub(crate) fn explicit(&mut self, value: Expr, from: Elementary, to: Elementary, span: Span) -> Operand {
        use Class::{Bits, Bool, Character, Date, Integer, Real, Time};
        let at = self.at(span);
        let are_bits = |real: Elementary, bits: Elementary| {
            real.class() == Real && bits.class() == Bits && real.bits() == bits.bits()
        };
        let value = match (from.class(), to.class()) {
            _ if are_bits(from, to) || are_bits(to, from) => {
                convert(value, from.scalar(), to.scalar(), Convert::Bits, at)
            }
            (Time, Time) if from != to => self.time(value, from, to, at),
            (Bits | Integer | Real | Bool | Time | Character, Bits | Integer | Real | Bool | Time | Character) => {
                convert(value, from.scalar(), to.scalar(), Convert::Value, at)
            }
            (Date, Bits | Integer | Date) | (Bits | Integer, Date) => {
                convert(value, from.scalar(), to.scalar(), Convert::Value, at)
            }
            _ => return self.error(span, format!("there is no function {}_TO_{}", from.name(), to.name()), None),
        };
        Operand::Value(to, value)
    }
}

fn of_time(elementary: Elementary) -> bool {
    matches!(
        elementary,
        Elementary::DInt
            | Elementary::UDInt
            | Elementary::DWord
            | Elementary::LInt
            | Elementary::ULInt
            | Elementary::LWord
    )
}

/// The loss an implicit conversion may cause, for a warning.
fn loss(from: Elementary, to: Elementary) -> Option<&'static str> {
    use Class::{Bits, Integer, Real};
    match (from.class(), to.class()) {
        (Real, Real) if from == Elementary::LReal => Some("the value is rounded"),
        (Real, Bits | Integer) => Some("the value is rounded, and its high bits are lost if it does not fit"),
        (Bits, Real) if from.bits() >= 32 => Some("the value is converted, not the bit pattern"),
        (Bits | Integer, Real) => {
            let digits = if to == Elementary::Real { 24 } else { 53 };
            (from.bits() - u32::from(from.scalar().is_signed()) > digits).then_some("the value is rounded")
        }
        (Bits | Integer, Bits | Integer) if from.bits() > to.bits() => Some("the high bits are lost"),
        (Integer, Integer) if from.scalar().is_signed() && !to.scalar().is_signed() => {
            Some("a negative number becomes a large one")
        }
        (Integer, Integer) if from.bits() == to.bits() => Some("a large number becomes a negative one"),
        _ => None,
    }
}
