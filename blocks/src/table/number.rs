//! Conversion between PLC values and plain numbers, with the range of each type.

use crate::table::{Kind, Time, Value, Word};

/// The maximum TIME in seconds.
const LONGEST_TIME: f64 = 2_147_483.647;

/// Converts a number into a PLC value: a REAL is rounded to binary32, a TIME, given in seconds, to the nearest
/// millisecond. The upper half of an unsigned WORD is mapped to the negative half of a signed one. A BOOL is 0 or 1.
///
/// # Errors
/// The number is out of range; the error describes the range of the type.
#[inline]
pub fn to_value(number: f64, kind: Kind) -> Result<Value, &'static str> {
    match kind {
        Kind::Real if is_real(number) => Ok(Value::Real(number as f32)),
        Kind::Time if (0.0..=LONGEST_TIME).contains(&number) => {
            Ok(Value::Time(Time::ms((number * 1000.0).round() as i32)))
        }
        Kind::LReal if number.is_finite() => Ok(Value::LReal(number)),
        Kind::Word if (-32768.0..=65535.0).contains(&number) && is_whole(number) => {
            Ok(Value::Word(Word::new(number as i32 as i16)))
        }
        Kind::Int if (-32768.0..=32767.0).contains(&number) && is_whole(number) => Ok(Value::Int(number as i16)),
        Kind::Bool if number == 0.0 || number == 1.0 => Ok(Value::Bool(number == 1.0)),
        _ if kind.whole().is_some() => whole(number, kind),
        _ => Err(kind.takes()),
    }
}

/// Whether a number of at most 31 bits is an integer. (`f64::fract` is a library call on processors without SSE 4.1.)
fn is_whole(number: f64) -> bool {
    f64::from(number as i32) == number
}

/// The largest integer up to which binary64 represents all integers.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// Converts a number into an integer of a type that exists only in programs. An LTIME, given in seconds, is rounded to
/// the nearest nanosecond; a DWORD may also be given as a signed number.
fn whole(number: f64, kind: Kind) -> Result<Value, &'static str> {
    let scaled = if kind == Kind::LTime { (number * 1e9).round_ties_even() } else { number };
    if scaled.fract() != 0.0 || scaled.abs() > EXACT {
        return Err(kind.takes());
    }
    of_exact(scaled as i128, kind)
}

/// Whether the number rounds to a finite REAL. The bound is halfway between the largest REAL and the power of 2 above
/// it; from there on, numbers round to infinity.
#[inline(always)]
pub fn is_real(number: f64) -> bool {
    number.abs() < 340282356779733661637539395458142568448.0
}

/// Returns the value as a number: a TIME in seconds, TRUE as 1.
#[inline]
pub fn number(value: Value) -> f64 {
    match value {
        Value::Real(real) => f64::from(real),
        Value::LReal(lreal) => lreal,
        Value::Time(time) => f64::from(time.milliseconds()) / 1000.0,
        Value::Word(word) => f64::from(word.value()),
        Value::Int(int) => f64::from(int),
        Value::Bool(bool) => f64::from(u8::from(bool)),
        Value::Whole(Kind::LTime, nanoseconds) => nanoseconds as f64 / 1e9,
        Value::Whole(Kind::ULInt | Kind::LWord, bits) => bits as u64 as f64,
        Value::Whole(_, whole) => whole as f64,
    }
}

/// Returns the exact value of an integer or a duration, a TIME in milliseconds and an LTIME in nanoseconds; `None` for
/// other types.
pub fn exact(value: Value) -> Option<i128> {
    match value {
        Value::Real(_) | Value::LReal(_) | Value::Bool(_) => None,
        Value::Time(time) => Some(time.milliseconds().into()),
        Value::Word(word) => Some(word.value().into()),
        Value::Int(int) => Some(int.into()),
        Value::Whole(Kind::ULInt | Kind::LWord, bits) => Some((bits as u64).into()),
        Value::Whole(_, whole) => Some(whole.into()),
    }
}

/// Returns the [`exact`] value if [`number`] cannot represent it, because it has more digits than a double can hold.
pub fn beyond_number(value: Value) -> Option<i128> {
    let scale = match value.kind() {
        Kind::Time => 1e3,
        Kind::LTime => 1e9,
        _ => 1.0,
    };
    exact(value).filter(|exact| (number(value) * scale).round() as i128 != *exact)
}

/// Converts an integer, as returned by [`exact`], into a PLC value. The upper half of an unsigned WORD is mapped to the
/// negative half of a signed one; a DWORD may also be given as a signed number.
///
/// # Errors
/// The integer is out of range; the error describes the range of the type.
pub fn of_exact(integer: i128, kind: Kind) -> Result<Value, &'static str> {
    let refused = || kind.takes();
    match kind {
        Kind::Time => i32::try_from(integer).map(|time| Value::Time(Time::ms(time))).map_err(|_| refused()),
        Kind::Int => i16::try_from(integer).map(Value::Int).map_err(|_| refused()),
        Kind::Word if (-32768..=65535).contains(&integer) => Ok(Value::Word(Word::new(integer as i16))),
        _ => {
            let (low, high) = kind.whole().ok_or_else(refused)?;
            let low = if kind == Kind::DWord { i32::MIN.into() } else { low };
            if !(low..=high).contains(&integer) {
                return Err(refused());
            }
            let bits = integer as i64;
            Ok(Value::Whole(kind, if kind == Kind::DWord { i64::from(bits as u32) } else { bits }))
        }
    }
}

/// Formats a REAL for display: the shortest decimal form that distinguishes it from its neighbours, with an exponent if
/// its magnitude is below 1e-5 (but not 0) or at least 1e9.
pub fn shown(real: f32) -> String {
    let is_short = real == 0.0 || (1e-5..1e9).contains(&real.abs());
    if is_short { real.to_string() } else { format!("{real:e}") }
}

/// Returns the number that the decimal form of the value denotes: 0.1 for the REAL nearest to it, which is slightly
/// larger.
pub fn decimal(value: Value) -> f64 {
    match value {
        Value::Real(real) => real.to_string().parse().unwrap_or(f64::from(real)),
        other => number(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_have_16_bits_and_no_fraction() {
        assert_eq!(to_value(65535.0, Kind::Word), Ok(Value::Word(Word::new(-1))));
        assert_eq!(to_value(-32768.0, Kind::Word), Ok(Value::Word(Word::new(-32768))));
        assert_eq!(to_value(32767.0, Kind::Int), Ok(Value::Int(32767)));
        for outside in [65536.0, -32769.0, 0.5, f64::NAN, f64::INFINITY] {
            assert_eq!(to_value(outside, Kind::Word), Err("a WORD accepts -32768 ... 65535"), "{outside}");
            assert_eq!(to_value(outside, Kind::Int), Err("an INT accepts -32768 ... 32767"), "{outside}");
        }
        assert_eq!(to_value(32768.0, Kind::Int), Err("an INT accepts -32768 ... 32767"));
    }

    #[test]
    fn a_bool_is_0_or_1() {
        assert_eq!(to_value(1.0, Kind::Bool), Ok(Value::Bool(true)));
        assert_eq!(to_value(0.0, Kind::Bool), Ok(Value::Bool(false)));
        for outside in [-1.0, 0.5, 2.0, f64::NAN] {
            assert_eq!(to_value(outside, Kind::Bool), Err("a BOOL accepts 0 and 1"), "{outside}");
        }
    }

    #[test]
    fn every_value_is_its_number_again() {
        let values = [
            Value::Real(0.1),
            Value::LReal(0.1),
            Value::Time(Time::ms(20_001)),
            Value::Word(Word::new(-1)),
            Value::Int(-7),
            Value::Bool(true),
        ];
        for value in values {
            assert_eq!(to_value(number(value), value.kind()), Ok(value));
        }
    }

    #[test]
    fn integers_of_64_bits_are_exact() {
        let linted = |whole| Value::Whole(Kind::LInt, whole);
        assert_eq!(beyond_number(linted(9_007_199_254_740_992)), None);
        assert_eq!(beyond_number(linted(9_007_199_254_740_993)), Some(9_007_199_254_740_993));
        assert_eq!(beyond_number(Value::Whole(Kind::ULInt, -1)), Some(u64::MAX.into()));
        assert_eq!(exact(Value::Whole(Kind::LTime, -1)), Some(-1));
        assert_eq!(exact(Value::Time(Time::ms(-1))), Some(-1));
    }

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
