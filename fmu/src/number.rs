//! PLC values as plain numbers, with the range of each type.

use blocks::{Kind, Time, Value};

/// The longest TIME in seconds.
const LONGEST_TIME: f64 = 2_147_483.647;

/// The PLC value of a number: a REAL is rounded to binary32, a TIME, given in seconds, to the nearest millisecond.
///
/// # Errors
/// The range of the type, as a text, if the number lies outside it. BOOL, INT and WORD are treated as REAL; they have no
/// fractions, so they should not be given here.
#[inline]
pub fn to_value(number: f64, kind: Kind) -> Result<Value, &'static str> {
    match kind {
        Kind::Time if (0.0..=LONGEST_TIME).contains(&number) => {
            Ok(Value::Time(Time::ms((number * 1000.0).round() as i32)))
        }
        Kind::Time => Err("a TIME takes 0 ... 2147483.647 s"),
        Kind::LReal if number.is_finite() => Ok(Value::LReal(number)),
        Kind::LReal => Err("an LREAL takes finite numbers"),
        _ if is_real(number) => Ok(Value::Real(number as f32)),
        _ => Err("a REAL takes finite numbers of at most 3.4028235e38"),
    }
}

/// Whether the number has a finite REAL next to it. The bound lies halfway between the largest REAL and the power of 2
/// beyond it; from there on a number is rounded to infinity.
#[inline(always)]
pub fn is_real(number: f64) -> bool {
    number.abs() < 340282356779733661637539395458142568448.0
}

/// The value as a number: a TIME in seconds, TRUE as 1.
#[inline]
pub fn number(value: Value) -> f64 {
    match value {
        Value::Real(real) => f64::from(real),
        Value::LReal(lreal) => lreal,
        Value::Time(time) => f64::from(time.milliseconds()) / 1000.0,
        Value::Word(word) => f64::from(word.value()),
        Value::Int(int) => f64::from(int),
        Value::Bool(bool) => f64::from(u8::from(bool)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_a_real_if_its_conversion_is_finite() {
        let bound = 340282356779733661637539395458142568448.0f64;
        for number in [
            bound.next_down(),
            bound,
            bound.next_up(),
            f64::from(f32::MAX),
            0.0,
            5e-324,
            f64::MAX,
            f64::INFINITY,
            f64::NAN,
        ] {
            for number in [number, -number] {
                assert_eq!(is_real(number), (number as f32).is_finite(), "{number:?}");
            }
        }
    }
}
