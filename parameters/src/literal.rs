//! Values as a PLC program writes them: `2.0e+000`, `T#20S`, `W#16#6C00`, `TRUE`.
//!
//! Letters may be of either case. Single underscores between digits or units are allowed.

use crate::problem::quoted;
use blocks::table::start;
use blocks::{Kind, Time, Value, Word};

/// Parses a literal as a value of this type.
///
/// - REAL and LREAL: a decimal number with or without a fraction and exponent, converted directly to the nearest binary
///   number.
/// - TIME: `T#` or `TIME#`, an optional sign, and the units D, H, M, S and MS in descending order. The first may exceed
///   its range (`T#90S`), the last may have decimals (`T#1.5S`), if the sum is a whole number of milliseconds.
/// - WORD and INT: decimal, with a base (`16#FF`, `2#1010_0000`) or with a type (`W#16#FF`, `B#16#1`, `L#100`). A WORD
///   also accepts negative numbers down to -32768.
/// - BOOL: TRUE, FALSE, 1 or 0.
///
/// # Errors
/// The expected form and the text found, as part of a sentence: `expected a REAL such as 2.5, found ...`.
pub fn parse(literal: &str, kind: Kind) -> Result<Value, String> {
    let refused = |reason: Refusal| {
        let found = quoted(literal);
        match reason {
            Refusal::Form => format!("expected {}, found {found}{}", expectation(kind), remark(literal, kind)),
            Refusal::Range(range) => format!("expected {range}, found {found}"),
        }
    };
    value(literal.trim(), kind).map_err(refused)
}

/// Why a string is not a literal of a type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The syntax is wrong.
    Form,
    /// The value is not valid for the type; contains the valid values.
    Range(&'static str),
}

/// How to write a literal of a type, for messages: `expected ...`.
const fn expectation(kind: Kind) -> &'static str {
    match kind {
        Kind::Real => "a REAL such as 2.5 or 1.0e-3",
        Kind::LReal => "an LREAL such as 2.5 or 1.0e-3",
        Kind::Time => "a TIME such as T#20S or T#1M30S500MS, with units in descending order",
        Kind::Word => "a WORD such as W#16#6C00 or 27648",
        Kind::Int => "an INT such as 200",
        Kind::Bool => "a BOOL: TRUE or FALSE",
        Kind::LTime => "an LTIME such as LT#20S or LT#1M30S500MS, with units in descending order",
        Kind::Byte | Kind::DWord | Kind::LWord => "a bit string such as 16#6C00 or 27648",
        _ => "an integer such as 200",
    }
}

/// The end of an error message: the type that the literal's prefix indicates, if it is a different one, and how to
/// write an S5TIME as a TIME.
fn remark(literal: &str, kind: Kind) -> &'static str {
    let Some((prefix, _)) = literal.trim().split_once('#') else { return "" };
    match prefix.to_ascii_uppercase().as_str() {
        "S5T" | "S5TIME" if kind == Kind::Time => ", which is an S5TIME; write T# instead of S5T#",
        "S5T" | "S5TIME" => ", which is an S5TIME",
        "T" | "TIME" if kind != Kind::Time => ", which is a TIME",
        "LT" | "LTIME" => ", which is an LTIME",
        "L" | "DINT" => ", which is a DINT",
        "W" | "WORD" if kind != Kind::Word => ", which is a WORD",
        "DW" | "DWORD" => ", which is a DWORD",
        "B" | "BYTE" if kind != Kind::Word => ", which is a BYTE",
        _ => "",
    }
}

fn value(literal: &str, kind: Kind) -> Result<Value, Refusal> {
    match kind {
        Kind::Real => {
            let decimal = decimal(untyped(literal, &["REAL"]))?;
            let real: f32 = decimal.text.parse().map_err(|_| Refusal::Form)?;
            if !real.is_finite() {
                return Err(Refusal::Range("a REAL with a magnitude of at most 3.4028235e38"));
            }
            if real == 0.0 && !decimal.is_zero {
                return Err(Refusal::Range("0.0 or a REAL with a magnitude of at least 1.4e-45"));
            }
            Ok(Value::Real(real))
        }
        Kind::LReal => {
            let decimal = decimal(untyped(literal, &["LREAL", "REAL"]))?;
            let real: f64 = decimal.text.parse().map_err(|_| Refusal::Form)?;
            if !real.is_finite() {
                return Err(Refusal::Range("an LREAL with a magnitude of at most 1.7976931348623157e308"));
            }
            if real == 0.0 && !decimal.is_zero {
                return Err(Refusal::Range("0.0 or an LREAL with a magnitude of at least 4.9e-324"));
            }
            Ok(Value::LReal(real))
        }
        Kind::Time => milliseconds(literal).map(|milliseconds| Value::Time(Time::ms(milliseconds))),
        Kind::Word => {
            let number = match prefixed(literal, &["B", "BYTE"]) {
                Some(byte) => match integer(byte)? {
                    byte @ 0..=255 => byte,
                    _ => return Err(Refusal::Range("a BYTE from B#16#0 to B#16#FF")),
                },
                None => integer(untyped(literal, &["W", "WORD", "INT", "UINT", "L", "DINT"]))?,
            };
            match number {
                -32768..=65535 => Ok(Value::Word(Word::new(number as u16 as i16))),
                _ => Err(Refusal::Range("a WORD from W#16#0 to W#16#FFFF, or from -32768 to 65535")),
            }
        }
        Kind::Int => {
            let number = integer(untyped(literal, &["INT", "L", "DINT", "B", "BYTE", "W", "WORD"]))?;
            i16::try_from(number).map(Value::Int).map_err(|_| Refusal::Range("an INT from -32768 to 32767"))
        }
        Kind::Bool => {
            let literal = untyped(literal, &["BOOL"]);
            let is = |text: &str| literal.eq_ignore_ascii_case(text);
            match () {
                () if is("TRUE") || is("1") => Ok(Value::Bool(true)),
                () if is("FALSE") || is("0") => Ok(Value::Bool(false)),
                () => Err(Refusal::Form),
            }
        }
        Kind::LTime => {
            let nanoseconds = duration(prefixed(literal, &["LT", "LTIME"]).ok_or(Refusal::Form)?, 1)?;
            i64::try_from(nanoseconds)
                .map(|bits| Value::Whole(kind, bits))
                .map_err(|_| Refusal::Range("an LTIME that fits in 64 bits"))
        }
        _ => {
            let number = match literal.split_once('#') {
                Some((prefix, digits)) if prefix.starts_with(|c: char| c.is_ascii_alphabetic()) => integer(digits)?,
                _ => integer(literal)?,
            };
            let (low, high) = kind.whole().unwrap_or_default();
            match (low..=high).contains(&number) {
                true => Ok(Value::Whole(kind, number as u64 as i64)),
                false => Err(Refusal::Range("a number within the range of the type")),
            }
        }
    }
}

/// The text after one of these type names and `#`; `None` if the literal starts with none of them.
fn prefixed<'a>(literal: &'a str, types: &[&str]) -> Option<&'a str> {
    let (prefix, rest) = literal.split_once('#')?;
    types.iter().any(|name| prefix.eq_ignore_ascii_case(name)).then_some(rest)
}

/// The literal without its type prefix, if that is one of these.
fn untyped<'a>(literal: &'a str, types: &[&str]) -> &'a str {
    prefixed(literal, types).unwrap_or(literal)
}

/// Whether a number has a minus sign, and the number without its sign.
fn signed(literal: &str) -> (bool, &str) {
    match literal.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, literal.strip_prefix('+').unwrap_or(literal)),
    }
}

/// A decimal number in Rust's syntax.
struct Decimal {
    text: String,
    /// Whether all digits of the mantissa are 0.
    is_zero: bool,
}

fn decimal(literal: &str) -> Result<Decimal, Refusal> {
    let (is_negative, unsigned) = signed(literal);
    let (mantissa, exponent) = match unsigned.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, Some(exponent)),
        None => (unsigned, None),
    };
    let (whole, fraction) = match mantissa.split_once('.') {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (mantissa, None),
    };
    let exponent_is_negative = exponent.map(signed);
    let parts = [Some(whole), fraction, exponent_is_negative.map(|(_, digits)| digits)];
    if !parts.into_iter().flatten().all(are_digits) {
        return Err(Refusal::Form);
    }
    let is_zero = mantissa.bytes().all(|byte| matches!(byte, b'0' | b'.' | b'_'));
    let text = [if is_negative { "-" } else { "" }, unsigned].concat().replace('_', "");
    Ok(Decimal { text, is_zero })
}

/// Whether a string consists of decimal digits with single underscores between them.
fn are_digits(text: &str) -> bool {
    !text.is_empty()
        && text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'_')
        && has_single_underscores_inside(text)
}

fn has_single_underscores_inside(text: &str) -> bool {
    !text.starts_with('_') && !text.ends_with('_') && !text.contains("__")
}

/// Parses an integer, decimal or with a base, such as `-12` or `16#FF_00`. Magnitudes beyond 127 bits saturate.
///
/// # Errors
/// The text is not an integer.
pub fn integer(literal: &str) -> Result<i128, Refusal> {
    let (is_negative, unsigned) = signed(literal);
    let (base, digits) = match unsigned.split_once('#') {
        Some(("2", digits)) => (2, digits),
        Some(("8", digits)) => (8, digits),
        Some(("16", digits)) => (16, digits),
        Some(_) => return Err(Refusal::Form),
        None => (10, unsigned),
    };
    if digits.is_empty() || !has_single_underscores_inside(digits) {
        return Err(Refusal::Form);
    }
    let mut number = 0i128;
    for digit in digits.chars().filter(|digit| *digit != '_') {
        let digit = digit.to_digit(base).ok_or(Refusal::Form)?;
        number = number.saturating_mul(i128::from(base)).saturating_add(i128::from(digit));
    }
    Ok(if is_negative { -number } else { number })
}

/// The units of a TIME or LTIME from longest to shortest: name, length in nanoseconds, and the number that make up the
/// next longer unit.
const UNITS: [(&str, i128, i128); 7] = [
    ("D", 86_400_000_000_000, i128::MAX),
    ("H", 3_600_000_000_000, 24),
    ("M", 60_000_000_000, 60),
    ("S", 1_000_000_000, 60),
    ("MS", MILLISECOND, 1000),
    ("US", 1000, 1000),
    ("NS", 1, 1000),
];

/// One millisecond in nanoseconds.
const MILLISECOND: i128 = 1_000_000;

const TIME_RANGE: Refusal = Refusal::Range("a TIME from T#-24D20H31M23S648MS to T#24D20H31M23S647MS");

fn milliseconds(literal: &str) -> Result<i32, Refusal> {
    let sum = duration(prefixed(literal, &["T", "TIME"]).ok_or(Refusal::Form)?, MILLISECOND)?;
    i32::try_from(sum).map_err(|_| TIME_RANGE)
}

/// Parses a duration without its type, such as `1H_30M` or `-2.5S`, as a multiple of a resolution in nanoseconds; no
/// unit may be shorter than the resolution. Magnitudes beyond 127 bits saturate.
///
/// # Errors
/// The text is not a duration, or not a multiple of the resolution.
pub fn duration(literal: &str, resolution: i128) -> Result<i128, Refusal> {
    let (is_negative, mut rest) = signed(literal);
    let mut units = UNITS.iter().filter(|(_, length, _)| *length >= resolution);
    let mut sum = 0i128;
    let mut is_first = true;
    let mut is_last = false;
    while !rest.is_empty() {
        let number_length = rest.find(|c: char| !matches!(c, '0'..='9' | '.' | '_')).ok_or(Refusal::Form)?;
        let (number, after_number) = rest.split_at(number_length);
        let unit_length = after_number.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(after_number.len());
        let (unit, after_unit) = after_number.split_at(unit_length);
        // The search continues after the previous unit, so that repeated or misordered units are not found.
        let (_, length, most) = units.find(|(name, ..)| unit.eq_ignore_ascii_case(name)).ok_or(Refusal::Form)?;
        let (whole, fraction) = match number.split_once('.') {
            Some((whole, fraction)) => (whole, Some(fraction)),
            None => (number, None),
        };
        if is_last || !are_digits(whole) || !fraction.is_none_or(are_digits) {
            return Err(Refusal::Form);
        }
        is_last = fraction.is_some();
        let whole = integer(whole)?;
        let length = length / resolution;
        if !is_first && whole >= *most {
            return Err(Refusal::Range("a duration whose units after the first are within their range, such as 59S"));
        }
        let fraction = fraction_of(fraction.unwrap_or_default(), length)?;
        sum = sum.saturating_add(whole.saturating_mul(length)).saturating_add(fraction);
        is_first = false;
        // `T#1D_2H`: an underscore between two units.
        rest = match after_unit.strip_prefix('_') {
            Some("") => return Err(Refusal::Form),
            Some(rest) => rest,
            None => after_unit,
        };
    }
    if is_first {
        return Err(Refusal::Form);
    }
    Ok(if is_negative { -sum } else { sum })
}

/// Converts the decimals of a number of units to a multiple of the resolution; a unit is `length` times the resolution.
fn fraction_of(decimals: &str, length: i128) -> Result<i128, Refusal> {
    const NOT_WHOLE: Refusal = Refusal::Range("a TIME in whole milliseconds, or an LTIME in whole nanoseconds");
    // 86 400 000 000 000 has the factors 2^17 and 5^11: with more than 17 significant decimals the product is never an
    // integer.
    const MOST_DECIMALS: usize = 17;
    let decimals = decimals.trim_end_matches(['0', '_']);
    let mut numerator = 0i128;
    let mut denominator = 1i128;
    for (place, digit) in decimals.bytes().filter(u8::is_ascii_digit).enumerate() {
        if place == MOST_DECIMALS {
            return Err(NOT_WHOLE);
        }
        numerator = numerator * 10 + i128::from(digit - b'0');
        denominator *= 10;
    }
    let scaled = numerator * length;
    if scaled % denominator == 0 { Ok(scaled / denominator) } else { Err(NOT_WHOLE) }
}

/// A literal that reads back bit for bit: a REAL or LREAL with STEP 7's six decimals, or with more where six would
/// represent a different number. A REAL or LREAL that is not finite has no literal; it becomes `NaN`, `inf` or `-inf`,
/// which [`parse`] rejects.
pub fn text(value: Value) -> String {
    match value {
        Value::Real(real) => with_plc_exponent(format!("{real:e}")),
        Value::LReal(real) => with_plc_exponent(format!("{real:e}")),
        Value::Time(time) => time_text(time.milliseconds()),
        Value::Word(word) => format!("W#16#{:04X}", word.value()),
        Value::Int(int) => int.to_string(),
        Value::Bool(bool) => if bool { "TRUE" } else { "FALSE" }.to_string(),
        Value::Whole(Kind::LTime, nanoseconds) => format!("LT#{nanoseconds}NS"),
        Value::Whole(..) => start::text(value),
    }
}

/// A number in STEP 7's notation: at least six decimals, and an exponent with a sign and three digits.
fn with_plc_exponent(number: String) -> String {
    like(&number, "0.000000e+000").unwrap_or(number)
}

/// Rewrites a number with an exponent in the style of another: at least as many decimals, the same exponent letter, as
/// many exponent digits, and a sign if the other has one. `None` if either has no exponent.
pub fn like(number: &str, style: &str) -> Option<String> {
    let parts = |text: &str| -> Option<(String, String, String)> {
        let (mantissa, exponent) = text.split_once(['e', 'E'])?;
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        Some((whole.into(), fraction.into(), exponent.into()))
    };
    let (whole, fraction, exponent) = parts(number)?;
    let (_, decimals, as_exponent) = parts(style)?;
    let letter = if style.contains('E') { 'E' } else { 'e' };
    let (is_negative, digits) = signed(&exponent);
    let sign = match as_exponent.starts_with(['+', '-']) {
        _ if is_negative => "-",
        true => "+",
        false => "",
    };
    let places = signed(&as_exponent).1.len();
    let fraction = format!("{fraction:0<width$}", width = decimals.len());
    let point = if fraction.is_empty() { "" } else { "." };
    Some(format!("{whole}{point}{fraction}{letter}{sign}{digits:0>places$}"))
}

fn time_text(milliseconds: i32) -> String {
    if milliseconds == 0 {
        return "T#0MS".to_string();
    }
    let mut text = if milliseconds < 0 { "T#-" } else { "T#" }.to_string();
    let mut rest = i128::from(milliseconds).abs() * MILLISECOND;
    for (name, length, _) in UNITS {
        if rest >= length {
            text.push_str(&format!("{}{name}", rest / length));
            rest %= length;
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn real(literal: &str) -> f32 {
        match parse(literal, Kind::Real) {
            Ok(Value::Real(real)) => real,
            other => panic!("{literal}: {other:?}"),
        }
    }

    fn time(literal: &str) -> i32 {
        match parse(literal, Kind::Time) {
            Ok(Value::Time(time)) => time.milliseconds(),
            other => panic!("{literal}: {other:?}"),
        }
    }

    fn word(literal: &str) -> i16 {
        match parse(literal, Kind::Word) {
            Ok(Value::Word(word)) => word.value(),
            other => panic!("{literal}: {other:?}"),
        }
    }

    fn assert_refused(literal: &str, kind: Kind, part: &str) {
        match parse(literal, kind) {
            Err(message) => assert!(message.contains(part), "{literal}: {message}"),
            Ok(value) => panic!("{literal} became {value:?}"),
        }
    }

    #[test]
    fn a_real_has_an_optional_fraction_exponent_and_sign() {
        assert_eq!(real("2.000000e+001"), 20.0);
        assert_eq!(real("-4.2e1"), -42.0);
        assert_eq!(real("100.0"), 100.0);
        assert_eq!(real("100"), 100.0);
        assert_eq!(real("+1_000.5E0"), 1000.5);
        assert_eq!(real("REAL#-1.5"), -1.5);
        assert_eq!(real("-0.0").to_bits(), (-0.0f32).to_bits());
    }

    #[test]
    fn a_real_is_converted_straight_to_binary32() {
        // Slightly more than halfway between two REALs. Via binary64, it becomes a tie, which is rounded down.
        let literal = "1.00000005960464477539062500000000001";
        assert_eq!(real(literal).to_bits(), 0x3F80_0001);
        assert_eq!((literal.parse::<f64>().unwrap() as f32).to_bits(), 0x3F80_0000);
    }

    #[test]
    fn a_real_beyond_binary32_is_refused() {
        assert_eq!(real("3.4028235e38"), f32::MAX);
        for beyond in ["3.4028236e38", "-1e39", "1e999999999999"] {
            assert_refused(beyond, Kind::Real, "a REAL with a magnitude of at most 3.4028235e38");
        }
        assert_eq!(real("1.4e-45").to_bits(), 1);
        assert_refused("1e-46", Kind::Real, "0.0 or a REAL with a magnitude of at least 1.4e-45");
        assert_eq!(real("0.000e-99"), 0.0);
    }

    #[test]
    fn what_is_no_decimal_is_no_real() {
        for literal in
            ["", "-", ".5", "5.", "1e", "1e+", "NaN", "inf", "1,5", "1.2.3", "--1", "TRUE", "1__0", "_1", "16#10"]
        {
            assert_refused(literal, Kind::Real, "expected a REAL such as 2.5");
        }
        assert_refused("T#20S", Kind::Real, "found `T#20S`, which is a TIME");
        assert_refused("L#100", Kind::Real, "found `L#100`, which is a DINT");
        assert_refused("W#16#1", Kind::Real, "found `W#16#1`, which is a WORD");
    }

    #[test]
    fn a_time_is_the_sum_of_its_units() {
        assert_eq!(time("T#20S"), 20_000);
        assert_eq!(time("TIME#1M30S500MS"), 90_500);
        assert_eq!(time("t#1d_2h_3m_4s_5ms"), 93_784_005);
        assert_eq!(time("T#5M1MS"), 300_001);
        assert_eq!(time("T#-1S"), -1000);
        assert_eq!(time("T#0MS"), 0);
    }

    #[test]
    fn the_first_unit_of_a_time_may_exceed_its_range_and_no_other() {
        assert_eq!(time("T#90S"), 90_000);
        assert_eq!(time("T#100H"), 360_000_000);
        assert_eq!(time("T#2147483647MS"), i32::MAX);
        assert_refused("T#1M60S", Kind::Time, "units after the first are within their range");
        assert_refused("T#1S1000MS", Kind::Time, "units after the first");
    }

    #[test]
    fn the_last_unit_of_a_time_may_have_decimals() {
        assert_eq!(time("T#1.5S"), 1500);
        assert_eq!(time("T#1M0.25S"), 60_250);
        assert_eq!(time("T#0.00001D"), 864);
        assert_eq!(time("T#2.000000000000000S"), 2000);
        assert_refused("T#1.5M30S", Kind::Time, "expected a TIME such as");
    }

    #[test]
    fn a_time_below_one_millisecond_is_refused() {
        for literal in ["T#0.5MS", "T#1.0005S", "T#0.000000000001D", "T#1.00000000000000000000001S"] {
            assert_refused(literal, Kind::Time, "whole milliseconds");
        }
    }

    #[test]
    fn units_of_a_time_stand_once_and_in_falling_order() {
        for literal in ["T#1S1M", "T#1S1S", "T#1MS1S", "T#1M1M", "T#20", "T#", "T#-", "T#S", "T#1X", "T#1_", "T#_1S"] {
            assert_refused(literal, Kind::Time, "with units in descending order");
        }
        for literal in ["20", "20S", "TRUE", "20.0", "T#1S_", "T#--1S", "T# 1S", "T#1S__1MS"] {
            assert_refused(literal, Kind::Time, "expected a TIME such as T#20S");
        }
    }

    #[test]
    fn a_time_ends_where_32_bits_end() {
        assert_eq!(time("T#24D20H31M23S647MS"), i32::MAX);
        assert_eq!(time("T#-24D20H31M23S648MS"), i32::MIN);
        for beyond in ["T#24D20H31M23S648MS", "T#-24D20H31M23S649MS", "T#25D", "T#99999999999999999999999999D"] {
            assert_refused(beyond, Kind::Time, "T#24D20H31M23S647MS");
        }
    }

    #[test]
    fn an_s5time_is_refused_with_a_hint() {
        assert_refused("S5T#20S", Kind::Time, "which is an S5TIME; write T# instead of S5T#");
        assert_refused("S5TIME#20S", Kind::Time, "write T#");
        assert_refused("LT#20S", Kind::Time, "which is an LTIME");
    }

    #[test]
    fn a_word_has_a_base_a_type_or_neither() {
        assert_eq!(word("W#16#6C00"), 27648);
        assert_eq!(word("16#ff"), 255);
        assert_eq!(word("2#1010_0000"), 160);
        assert_eq!(word("8#17"), 15);
        assert_eq!(word("B#16#1"), 1);
        assert_eq!(word("L#100"), 100);
        assert_eq!(word("WORD#16#FFFF"), -1);
        assert_eq!((word("65535"), word("-1"), word("-32768")), (-1, -1, -32768));
        assert_refused("W#16#10000", Kind::Word, "W#16#0 to W#16#FFFF");
        assert_refused("-32769", Kind::Word, "-32768 to 65535");
        assert_refused("B#16#100", Kind::Word, "B#16#0 to B#16#FF");
        assert_refused("DW#16#1", Kind::Word, "which is a DWORD");
        for literal in ["W#16#G", "3#1", "16#", "1.0", "W#", "TRUE"] {
            assert_refused(literal, Kind::Word, "expected a WORD such as");
        }
    }

    #[test]
    fn an_int_has_a_sign_and_16_bits() {
        assert_eq!(parse("-32768", Kind::Int), Ok(Value::Int(-32768)));
        assert_eq!(parse("16#7FFF", Kind::Int), Ok(Value::Int(32767)));
        assert_eq!(parse("L#200", Kind::Int), Ok(Value::Int(200)));
        assert_refused("32768", Kind::Int, "-32768 to 32767");
        assert_refused("99999999999999999999999999", Kind::Int, "-32768 to 32767");
        assert_refused("200.0", Kind::Int, "expected an INT such as 200");
    }

    #[test]
    fn a_bool_is_true_false_1_or_0() {
        for literal in ["TRUE", "true", "True", "1", "BOOL#TRUE"] {
            assert_eq!(parse(literal, Kind::Bool), Ok(Value::Bool(true)), "{literal}");
        }
        for literal in ["FALSE", "false", "0"] {
            assert_eq!(parse(literal, Kind::Bool), Ok(Value::Bool(false)), "{literal}");
        }
        for literal in ["2", "yes", "1.0", ""] {
            assert_refused(literal, Kind::Bool, "TRUE or FALSE");
        }
    }

    #[test]
    fn texts_are_what_the_plc_shows() {
        assert_eq!(text(Value::Real(2.0)), "2.000000e+000");
        assert_eq!(text(Value::Real(-0.0001)), "-1.000000e-004");
        assert_eq!(text(Value::Real(0.9)), "9.000000e-001");
        // Six decimals would represent a different number.
        assert_eq!(text(Value::Real(std::f32::consts::PI)), "3.1415927e+000");
        assert_eq!(text(Value::LReal(0.1)), "1.000000e-001");
        assert_eq!(text(Value::Time(Time::ms(20_000))), "T#20S");
        assert_eq!(text(Value::Time(Time::ms(-90_500))), "T#-1M30S500MS");
        assert_eq!(text(Value::Time(Time::ms(i32::MIN))), "T#-24D20H31M23S648MS");
        assert_eq!(text(Value::Word(Word::new(-1))), "W#16#FFFF");
        assert_eq!(text(Value::Int(-7)), "-7");
        assert_eq!(text(Value::Bool(true)), "TRUE");
    }

    #[test]
    fn a_number_of_a_million_digits_is_read_and_its_message_is_short() {
        let nines = "9".repeat(1_000_000);
        assert!(parse(&nines, Kind::Real).unwrap_err().len() < 200);
        assert!(parse(&format!("T#{nines}S"), Kind::Time).unwrap_err().len() < 200);
        assert_eq!(real(&format!("0.{}", "3".repeat(1_000_000))), 1.0 / 3.0);
    }

    /// Whether the value reads back bit for bit.
    fn reads_back(value: Value) -> bool {
        let literal = text(value);
        match (parse(&literal, value.kind()), value) {
            (Ok(Value::Real(read)), Value::Real(real)) => read.to_bits() == real.to_bits(),
            (Ok(Value::LReal(read)), Value::LReal(real)) => read.to_bits() == real.to_bits(),
            (read, value) => read == Ok(value),
        }
    }

    #[test]
    fn reals_of_every_exponent_read_back_bit_equal() {
        let mantissas = [0, 1, 2, 0x2A_AAAA, 0x3F_FFFF, 0x40_0000, 0x55_5555, 0x7F_FFFE, 0x7F_FFFF];
        for exponent in 0..=254u32 {
            for mantissa in mantissas.into_iter().chain((0..200).map(|step| step * 41_777 + exponent)) {
                for sign in [0, 1u32 << 31] {
                    let real = f32::from_bits(sign | exponent << 23 | mantissa & 0x7F_FFFF);
                    assert!(reads_back(Value::Real(real)), "{real:e}");
                }
            }
        }
    }

    #[test]
    fn times_at_the_borders_of_their_units_read_back() {
        let lengths = UNITS.iter().map(|(_, length, _)| length / MILLISECOND);
        let borders = lengths.flat_map(|length| [length - 1, length, length + 1]).chain([0, 1]);
        for border in borders.map(|border| border as i32).chain([i32::MIN, i32::MIN + 1, i32::MAX - 1, i32::MAX]) {
            for milliseconds in [border, border.wrapping_neg()] {
                assert!(reads_back(Value::Time(Time::ms(milliseconds))), "{milliseconds} ms");
            }
        }
    }

    #[test]
    fn every_16_bit_value_reads_back() {
        for bits in i16::MIN..=i16::MAX {
            assert!(reads_back(Value::Word(Word::new(bits))) && reads_back(Value::Int(bits)), "{bits}");
        }
        assert!(reads_back(Value::Bool(true)) && reads_back(Value::Bool(false)));
    }

    proptest! {
        #[test]
        fn any_finite_value_reads_back(bits: u32, wide: u64, milliseconds: i32) {
            let (real, lreal) = (f32::from_bits(bits), f64::from_bits(wide));
            prop_assert!(!real.is_finite() || reads_back(Value::Real(real)), "{real:e}");
            prop_assert!(!lreal.is_finite() || reads_back(Value::LReal(lreal)), "{lreal:e}");
            prop_assert!(reads_back(Value::Time(Time::ms(milliseconds))), "{milliseconds} ms");
        }

        #[test]
        fn any_text_is_a_value_or_a_short_sentence(literal in "[TWLS5#\\-+0-9._eEdDhHmMsSRUA]{0,30}|.{0,60}") {
            for kind in Kind::ALL {
                match parse(&literal, *kind) {
                    Ok(value) => prop_assert!(value.kind() == *kind && reads_back(value)),
                    Err(message) => prop_assert!(message.starts_with("expected ") && message.len() < 400),
                }
            }
        }
    }
}
