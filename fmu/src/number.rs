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
        // Beyond the largest REAL the conversion gives an infinity; NaN and infinity stay what they are.
        _ if (number as f32).is_finite() => Ok(Value::Real(number as f32)),
        _ => Err("a REAL takes finite numbers of at most 3.4028235e38"),
    }
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
