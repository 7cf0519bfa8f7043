//! Numbers for people to read.

use blocks::Kind;

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

/// A variable's value without its unit. A 32-bit REAL has as many digits as tell it from its neighbours.
pub fn number(kind: Kind, value: f64) -> String {
    let is_short = value == 0.0 || (1e-5..1e9).contains(&value.abs());
    match kind {
        Kind::Bool => if value == 0.0 { "FALSE" } else { "TRUE" }.to_string(),
        Kind::Real if is_short => (value as f32).to_string(),
        Kind::Real => format!("{:e}", value as f32),
        _ if is_short => value.to_string(),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_written_with_at_most_six_digits() {
        let texts = [0.0, -0.0, 0.1, 1.0 / 3.0, -123_456.7, 12.340_000_1, 2e-7, 1.5e12, 1_000_000.0].map(short);
        assert_eq!(texts, ["0", "0", "0.1", "0.333333", "-123457", "12.34", "2.000e-7", "1.500e12", "1000000"]);
    }
}
