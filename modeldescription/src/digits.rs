//! Formats numbers for human readers.

use blocks::Kind;
use blocks::table::number::shown;

/// A number with at most six digits.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return format!("{value}");
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-5..=8).contains(&exponent) {
        return format!("{value:.3e}");
    }
    let text = format!("{value:.*}", (5 - exponent).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// A number rounded to the digits that the spread of such numbers justifies: to the largest power of ten that is at
/// most one fiftieth of `spread`. If `spread` is 0, it has at most six digits.
pub fn within(value: f64, spread: f64) -> String {
    let place = (spread / 50.0).log10().floor();
    if !(value.is_finite() && (-15.0..=15.0).contains(&place)) {
        return short(value);
    }
    if place < 0.0 {
        let text = format!("{value:.*}", -place as usize);
        return text.trim_end_matches('0').trim_end_matches('.').into();
    }
    let unit = 10f64.powi(place as i32);
    let rounded = (value / unit).round() * unit;
    if rounded.abs() < 1e9 { format!("{}", rounded + 0.0) } else { format!("{rounded:e}") }
}

/// A number with three significant digits, but with no decimal place finer than that of `least`.
pub fn rounded(value: f64, least: f64) -> String {
    let third = 10f64.powf(value.abs().log10().floor() - 2.0);
    within(value, 50.0 * third.max(10f64.powf(least.log10().floor())))
}

/// A variable's value without its unit. A 32-bit REAL has just enough digits to distinguish it from its neighbours.
pub fn number(kind: Kind, value: f64) -> String {
    match kind {
        Kind::Bool => if value == 0.0 { "FALSE" } else { "TRUE" }.to_string(),
        Kind::Real => shown(value as f32),
        _ if value == 0.0 || (1e-5..1e9).contains(&value.abs()) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

/// An ordinal number: `2nd`.
pub fn ordinal(number: usize) -> String {
    let end = match (number % 10, number % 100) {
        (1, of) if of != 11 => "st",
        (2, of) if of != 12 => "nd",
        (3, of) if of != 13 => "rd",
        _ => "th",
    };
    format!("{number}{end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_the_digits_that_the_spread_tells() {
        // Fiftieths: 0.15, 153, 6.2, 0.00014.
        let texts = [(5.8798, 7.4), (15377.8, 7655.0), (306.2, 309.0), (179.99612, 0.007)];
        assert_eq!(texts.map(|(value, spread)| within(value, spread)), ["5.9", "15400", "306", "179.9961"]);
        assert_eq!(within(1.0 / 3.0, 0.0), "0.333333");
        assert_eq!(within(105.0, 9.0), "105");
        assert_eq!([within(-0.04, 400.0), within(f64::INFINITY, 1.0)], ["0", "inf"]);
    }

    #[test]
    fn what_people_read_has_three_digits_and_none_finer_than_the_least() {
        let texts =
            [(2484.82, 0.0), (0.96918, 0.0), (80.635, 0.1), (-12.892, 0.1), (8.06, 1.0), (0.0, 0.1), (1e-7, 0.0)];
        let texts = texts.map(|(value, least)| rounded(value, least));
        assert_eq!(texts, ["2480", "0.969", "80.6", "-12.9", "8", "0", "0.0000001"]);
    }

    #[test]
    fn a_number_is_written_with_at_most_six_digits() {
        let texts = [0.0, -0.0, 0.1, 1.0 / 3.0, -123_456.7, 12.340_000_1, 2e-7, 1.5e12, 1_000_000.0].map(short);
        assert_eq!(texts, ["0", "0", "0.1", "0.333333", "-123457", "12.34", "2.000e-7", "1.500e12", "1000000"]);
    }
}
