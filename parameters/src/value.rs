//! Values as people and text formats write them: decimals, with a TIME in seconds, as in the FMU.

use blocks::table::number::{number, to_value};
use blocks::table::start;
use blocks::{Kind, Time, Value};

/// Converts a number as the FMU does, except that a TIME may be negative, as in a PLC.
fn from_number(number: f64, kind: Kind) -> Result<Value, &'static str> {
    const LOWEST: i32 = i32::MIN;
    if kind == Kind::Time && number < 0.0 {
        let milliseconds = (number * 1000.0).round();
        return if milliseconds >= f64::from(LOWEST) {
            Ok(Value::Time(Time::ms(milliseconds as i32)))
        } else {
            Err("a TIME accepts -2147483.648 ... 2147483.647 s")
        };
    }
    to_value(number, kind)
}

/// Converts a number from a user or a file, with a TIME in seconds.
///
/// # Errors
/// The permitted values of the type, if the number is out of range, would become 0, or cannot be represented closely
/// enough.
pub fn plc_value(number: f64, kind: Kind) -> Result<Value, &'static str> {
    /// The tolerance in milliseconds.
    const ROUNDING: f64 = 1e-3;
    let value = from_number(number, kind)?;
    match value {
        Value::Real(0.0) if number != 0.0 => Err("a REAL accepts 0 and magnitudes of at least 1.4e-45"),
        Value::Time(_) if (number * 1000.0 - (number * 1000.0).round()).abs() > ROUNDING => {
            Err("a TIME is a whole number of milliseconds")
        }
        _ => Ok(value),
    }
}

/// A value as written in JSON and XML: the shortest decimal that reads back to the same value, an integer, `true` or
/// `false`.
///
/// # Errors
/// The value is not finite.
pub(crate) fn text(value: Value) -> Result<String, String> {
    match value {
        Value::Real(real) if !real.is_finite() => Err(format!("{real}")),
        Value::LReal(lreal) if !lreal.is_finite() => Err(format!("{lreal}")),
        Value::Real(real) => {
            let shortest = format!("{real:?}");
            // A host reads it as binary64 and rounds that to a REAL.
            let reads_back = shortest.parse::<f64>().is_ok_and(|number| number as f32 == real);
            Ok(if reads_back { shortest } else { format!("{:?}", f64::from(real)) })
        }
        Value::LReal(_) | Value::Time(_) => Ok(format!("{:?}", number(value))),
        Value::Whole(..) => Ok(start::text(value)),
        Value::Word(word) => Ok(word.value().to_string()),
        Value::Int(int) => Ok(int.to_string()),
        Value::Bool(bool) => Ok(bool.to_string()),
    }
}

/// A value as text, as in the FMU: the shortest decimal that reads back to the same value, a TIME in seconds, an
/// integer, `true` or `false`; `NaN` and `inf` for a REAL that is not finite.
pub fn decimal(value: Value) -> String {
    text(value).unwrap_or_else(|number| number)
}
