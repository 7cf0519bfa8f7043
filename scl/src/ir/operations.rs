//! The semantics of each operation: the only place that defines the CPU's arithmetic.
//!
//! A number is represented by 64 bits ([`Scalar::of_bits`]).

// A macro generates each operation for all integer types; for some of these, a cast or a comparison is redundant.
#![allow(unused_comparisons, clippy::unnecessary_cast, clippy::absurd_extreme_comparisons)]

use super::{Binary, Convert, Scalar, Unary, Value, mathematics};

/// A unary operation.
pub(crate) type One = fn(u64) -> u64;

/// A unary operation that also reports whether its result is inexact.
pub(crate) type OneChecked = fn(u64) -> (u64, bool);

/// A binary operation.
pub(crate) type Two = fn(u64, u64) -> u64;

/// A binary operation that also reports a division by 0 or an overflow.
pub(crate) type TwoChecked = fn(u64, u64) -> (u64, bool);

/// A ternary operation.
pub(crate) type Three = fn(u64, u64, u64) -> u64;

/// An operation that never warns, or one that may.
#[derive(Clone, Copy)]
pub(crate) enum Either<F, C> {
    Plain(F),
    Checked(C),
}
use Either::{Checked, Plain};

fn f32_of(bits: u64) -> f32 {
    f32::from_bits(bits as u32)
}

fn f64_of(bits: u64) -> f64 {
    f64::from_bits(bits)
}

fn bits32(number: f32) -> u64 {
    u64::from(number.to_bits())
}

fn bits64(number: f64) -> u64 {
    number.to_bits()
}

/// Selects a function by integer type; the type is `$T` in the expression.
macro_rules! for_integer {
    ($scalar:expr, $T:ident => $expression:expr) => {
        match $scalar {
            Scalar::I8 => {
                type $T = i8;
                $expression
            }
            Scalar::I16 => {
                type $T = i16;
                $expression
            }
            Scalar::I32 => {
                type $T = i32;
                $expression
            }
            Scalar::I64 => {
                type $T = i64;
                $expression
            }
            Scalar::U8 => {
                type $T = u8;
                $expression
            }
            Scalar::U16 => {
                type $T = u16;
                $expression
            }
            Scalar::U32 => {
                type $T = u32;
                $expression
            }
            Scalar::U64 => {
                type $T = u64;
                $expression
            }
            _ => return None,
        }
    };
}

impl Unary {
    /// The function for operands of a type; `None` if the type does not support the operation.
    pub(crate) fn function(self, ty: Scalar) -> Option<One> {
        match ty {
            Scalar::F32 => self.of_f32(),
            Scalar::F64 => self.of_f64(),
            Scalar::Bool => (self == Unary::Not).then_some(|a| u64::from(a == 0)),
            _ => Some(match self {
                Unary::Neg => for_integer!(ty, T => |a| (a as T).wrapping_neg() as u64),
                Unary::Not => for_integer!(ty, T => |a| !(a as T) as u64),
                Unary::Abs => for_integer!(ty, T => |a| {
                    let number = a as T;
                    if number < 0 { number.wrapping_neg() as u64 } else { a }
                }),
                Unary::Swap => for_integer!(ty, T => |a| (a as T).swap_bytes() as u64),
                _ => return None,
            }),
        }
    }

    fn of_f64(self) -> Option<One> {
        Some(match self {
            Unary::Neg => |a| bits64(-f64_of(a)),
            Unary::Abs => |a| bits64(f64_of(a).abs()),
            Unary::Frac => |a| bits64(f64_of(a) - f64_of(a).trunc()),
            Unary::Sqrt => |a| bits64(f64_of(a).sqrt()),
            Unary::Exp => |a| bits64(mathematics::exp_f64(f64_of(a))),
            Unary::Ln => |a| bits64(mathematics::ln_f64(f64_of(a))),
            Unary::Log => |a| bits64(mathematics::log_f64(f64_of(a))),
            Unary::Sin => |a| bits64(mathematics::sin_f64(f64_of(a))),
            Unary::Cos => |a| bits64(mathematics::cos_f64(f64_of(a))),
            Unary::Tan => |a| bits64(mathematics::tan_f64(f64_of(a))),
            Unary::Asin => |a| bits64(mathematics::asin_f64(f64_of(a))),
            Unary::Acos => |a| bits64(mathematics::acos_f64(f64_of(a))),
            Unary::Atan => |a| bits64(mathematics::atan_f64(f64_of(a))),
            Unary::Not | Unary::Swap => return None,
        })
    }

    /// Functions such as EXP and SIN are computed in binary64; the result is then rounded to binary32.
    fn of_f32(self) -> Option<One> {
        Some(match self {
            Unary::Neg => |a| bits32(-f32_of(a)),
            Unary::Abs => |a| bits32(f32_of(a).abs()),
            Unary::Frac => |a| bits32(f32_of(a) - f32_of(a).trunc()),
            Unary::Sqrt => |a| bits32(f32_of(a).sqrt()),
            Unary::Exp => |a| bits32(mathematics::exp_f64(f64::from(f32_of(a))) as f32),
            Unary::Ln => |a| bits32(mathematics::ln_f64(f64::from(f32_of(a))) as f32),
            Unary::Log => |a| bits32(mathematics::log_f64(f64::from(f32_of(a))) as f32),
            Unary::Sin => |a| bits32(mathematics::sin_f64(f64::from(f32_of(a))) as f32),
            Unary::Cos => |a| bits32(mathematics::cos_f64(f64::from(f32_of(a))) as f32),
            Unary::Tan => |a| bits32(mathematics::tan_f64(f64::from(f32_of(a))) as f32),
            Unary::Asin => |a| bits32(mathematics::asin_f64(f64::from(f32_of(a))) as f32),
            Unary::Acos => |a| bits32(mathematics::acos_f64(f64::from(f32_of(a))) as f32),
            Unary::Atan => |a| bits32(mathematics::atan_f64(f64::from(f32_of(a))) as f32),
            Unary::Not | Unary::Swap => return None,
        })
    }

    /// The result for a constant; `None` if its type does not support the operation.
    pub fn fold(self, a: Value) -> Option<Value> {
        self.function(a.ty()).map(|function| Value::new(a.ty(), function(a.bits())))
    }
}

impl Binary {
    /// The function for operands of a type; `None` if the type does not support the operation.
    pub(crate) fn function(self, ty: Scalar) -> Option<Either<Two, TwoChecked>> {
        match ty {
            Scalar::Bool => self.of_bool().map(Plain),
            Scalar::F32 => self.of_f32(),
            Scalar::F64 => self.of_f64(),
            _ => self.of_integer(ty),
        }
    }

    fn of_bool(self) -> Option<Two> {
        Some(match self {
            Binary::And => |a, b| a & b,
            Binary::Or => |a, b| a | b,
            Binary::Xor | Binary::Ne => |a, b| a ^ b,
            Binary::Eq => |a, b| u64::from(a == b),
            _ => return None,
        })
    }

    fn of_integer(self, ty: Scalar) -> Option<Either<Two, TwoChecked>> {
        let checked: TwoChecked = match self {
            Binary::Add => for_integer!(ty, T => |a, b| {
                let (sum, overflows) = (a as T).overflowing_add(b as T);
                (sum as u64, overflows)
            }),
            Binary::Sub => for_integer!(ty, T => |a, b| {
                let (difference, overflows) = (a as T).overflowing_sub(b as T);
                (difference as u64, overflows)
            }),
            Binary::Mul => for_integer!(ty, T => |a, b| {
                let (product, overflows) = (a as T).overflowing_mul(b as T);
                (product as u64, overflows)
            }),
            Binary::Div => for_integer!(ty, T => |a, b| {
                let (a, b) = (a as T, b as T);
                if b == 0 { (0, true) } else { (a.wrapping_div(b) as u64, a.checked_div(b).is_none()) }
            }),
            Binary::Rem => for_integer!(ty, T => |a, b| {
                let (a, b) = (a as T, b as T);
                if b == 0 { (0, true) } else { (a.wrapping_rem(b) as u64, false) }
            }),
            _ => return self.of_integer_exactly(ty).map(Plain),
        };
        Some(Checked(checked))
    }

    fn of_integer_exactly(self, ty: Scalar) -> Option<Two> {
        Some(match self {
            Binary::And => |a, b| a & b,
            Binary::Or => |a, b| a | b,
            Binary::Xor => |a, b| a ^ b,
            Binary::Shl => for_integer!(ty, T => |a, n| if n < T::BITS as u64 { ((a as T) << n) as u64 } else { 0 }),
            Binary::Shr => for_integer!(ty, T => |a, n| {
                // A shift by the whole width is undefined, so the last bit is shifted separately.
                let last = u64::from(T::BITS - 1);
                if n <= last { ((a as T) >> n) as u64 } else { (((a as T) >> last) >> 1) as u64 }
            }),
            Binary::Rol => for_integer!(ty, T => |a, n| (a as T).rotate_left((n % u64::from(T::BITS)) as u32) as u64),
            Binary::Ror => for_integer!(ty, T => |a, n| (a as T).rotate_right((n % u64::from(T::BITS)) as u32) as u64),
            Binary::Min => for_integer!(ty, T => |a, b| if (b as T) < (a as T) { b } else { a }),
            Binary::Max => for_integer!(ty, T => |a, b| if (b as T) > (a as T) { b } else { a }),
            Binary::Eq => |a, b| u64::from(a == b),
            Binary::Ne => |a, b| u64::from(a != b),
            Binary::Lt => for_integer!(ty, T => |a, b| u64::from((a as T) < (b as T))),
            Binary::Le => for_integer!(ty, T => |a, b| u64::from(a as T <= b as T)),
            Binary::Gt => for_integer!(ty, T => |a, b| u64::from(a as T > b as T)),
            Binary::Ge => for_integer!(ty, T => |a, b| u64::from(a as T >= b as T)),
            _ => return None,
        })
    }

    /// The result for constants, and whether there was a division by 0 or an overflow; `None` if their type does not
    /// support the operation.
    pub fn fold(self, a: Value, b: Value) -> Option<(Value, bool)> {
        if b.ty() != (if self.shifts() { Scalar::U32 } else { a.ty() }) {
            return None;
        }
        let (bits, warns) = match self.function(a.ty())? {
            Plain(function) => (function(a.bits(), b.bits()), false),
            Checked(function) => function(a.bits(), b.bits()),
        };
        Some((Value::new(if self.compares() { Scalar::Bool } else { a.ty() }, bits), warns))
    }
}

/// The binary operations of a floating-point type: even `<>` is FALSE if an operand is NaN.
macro_rules! binary_of_float {
    ($name:ident, $of:ident, $bits:ident, |$a:ident, $b:ident| $power:expr) => {
        impl Binary {
            fn $name(self) -> Option<Either<Two, TwoChecked>> {
                Some(Plain(match self {
                    Binary::Add => |a, b| $bits($of(a) + $of(b)),
                    Binary::Sub => |a, b| $bits($of(a) - $of(b)),
                    Binary::Mul => |a, b| $bits($of(a) * $of(b)),
                    Binary::Div => return Some(Checked(|a, b| ($bits($of(a) / $of(b)), $of(b) == 0.0))),
                    Binary::Pow => |$a, $b| $power,
                    Binary::Min => |a, b| if $of(b) < $of(a) { b } else { a },
                    Binary::Max => |a, b| if $of(b) > $of(a) { b } else { a },
                    Binary::Eq => |a, b| u64::from($of(a) == $of(b)),
                    Binary::Ne => |a, b| u64::from($of(a) < $of(b) || $of(a) > $of(b)),
                    Binary::Lt => |a, b| u64::from($of(a) < $of(b)),
                    Binary::Le => |a, b| u64::from($of(a) <= $of(b)),
                    Binary::Gt => |a, b| u64::from($of(a) > $of(b)),
                    Binary::Ge => |a, b| u64::from($of(a) >= $of(b)),
                    _ => return None,
                }))
            }
        }
    };
}

binary_of_float!(of_f32, f32_of, bits32, |a, b| bits32(
    mathematics::pow_f64(f64::from(f32_of(a)), f64::from(f32_of(b))) as f32
));
binary_of_float!(of_f64, f64_of, bits64, |a, b| bits64(mathematics::pow_f64(f64_of(a), f64_of(b))));

/// The function for the median of lowest, number and highest; the number itself if lowest is above highest.
pub(crate) fn limit(ty: Scalar) -> Option<Three> {
    Some(match ty {
        Scalar::F32 => |low, x, high| limited(low, x, high, |a, b| f32_of(a) < f32_of(b)),
        Scalar::F64 => |low, x, high| limited(low, x, high, |a, b| f64_of(a) < f64_of(b)),
        _ => for_integer!(ty, T => |low, x, high| limited(low, x, high, |a, b| (a as T) < (b as T))),
    })
}

fn limited(low: u64, x: u64, high: u64, less: impl Fn(u64, u64) -> bool) -> u64 {
    if less(high, low) {
        x
    } else if less(x, low) {
        low
    } else if less(high, x) {
        high
    } else {
        x
    }
}

impl Convert {
    /// The function that converts between two types; `None` if there is no such conversion.
    pub(crate) fn function(self, from: Scalar, to: Scalar) -> Option<Either<One, OneChecked>> {
        if self == Convert::Bits {
            let whole =
                from.size() == to.size() && (from.is_float() && to.is_integer() || from.is_integer() && to.is_float());
            return if whole { wrap(to).map(Plain) } else { None };
        }
        if from.is_float() && to.is_integer() {
            return if from == Scalar::F32 { self.of_f32(to) } else { self.of_f64(to) }.map(Checked);
        }
        if self != Convert::Value {
            return None;
        }
        Some(Plain(match (from, to) {
            (Scalar::F32, Scalar::F32) | (Scalar::F64, Scalar::F64) => |a| a,
            (Scalar::F32, Scalar::F64) => |a| bits64(f64::from(f32_of(a))),
            (Scalar::F64, Scalar::F32) => |a| bits32(f64_of(a) as f32),
            (Scalar::F32 | Scalar::F64, _) | (Scalar::Bool, Scalar::F32 | Scalar::F64) => return None,
            (Scalar::U64, Scalar::F32) => |a| bits32(a as f32),
            (Scalar::U64, Scalar::F64) => |a| bits64(a as f64),
            (_, Scalar::F32) => |a| bits32(a as i64 as f32),
            (_, Scalar::F64) => |a| bits64(a as i64 as f64),
            _ => wrap(to)?,
        }))
    }

    /// The converted constant, and whether the result is inexact; `None` if there is no such conversion.
    pub fn fold(self, a: Value, to: Scalar) -> Option<(Value, bool)> {
        let (bits, warns) = match self.function(a.ty(), to)? {
            Plain(function) => (function(a.bits()), false),
            Checked(function) => function(a.bits()),
        };
        Some((Value::new(to, bits), warns))
    }
}

/// Truncates an integer to its low bits.
fn wrap(to: Scalar) -> Option<One> {
    Some(match to {
        Scalar::Bool => |a| a & 1,
        Scalar::F32 => |a| u64::from(a as u32),
        Scalar::F64 => |a| a,
        _ => for_integer!(to, T => |a| a as T as u64),
    })
}

/// Converts an integral floating-point number to an integer: its low bits, and whether it is out of range. Numbers
/// beyond 64 bits are saturated first, and NaN becomes 0.
macro_rules! low_bits {
    ($T:ty, $whole:expr) => {{
        let whole: f64 = $whole;
        // The cast saturates beyond 64 bits; only `u64` has numbers beyond `i64`.
        let bits =
            if <$T>::MAX as u128 > i64::MAX as u128 && whole > 0.0 { whole as u64 as $T } else { whole as i64 as $T };
        (bits as u64, bits as f64 != whole)
    }};
}
/// Conversions from a floating-point type to integers.
macro_rules! integer_of {
    ($name:ident, $of:ident) => {
        impl Convert {
            fn $name(self, to: Scalar) -> Option<OneChecked> {
                Some(match self {
                    Convert::Value => for_integer!(to, T => |a| low_bits!(T, f64::from($of(a)).round_ties_even())),
                    Convert::Trunc => for_integer!(to, T => |a| low_bits!(T, f64::from($of(a)).trunc())),
                    Convert::Ceil => for_integer!(to, T => |a| low_bits!(T, f64::from($of(a)).ceil())),
                    Convert::Floor => for_integer!(to, T => |a| low_bits!(T, f64::from($of(a)).floor())),
                    Convert::Bits => return None,
                })
            }
        }
    };
}

integer_of!(of_f32, f32_of);
integer_of!(of_f64, f64_of);
