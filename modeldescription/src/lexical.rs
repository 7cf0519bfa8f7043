//! Numbers as XML Schema writes them.

/// An `xs:double` that reads back with the same bits (a NaN as a NaN).
pub(crate) fn real_text(real: f64) -> String {
    if real.is_nan() {
        "NaN".into()
    } else if real.is_infinite() {
        if real > 0.0 { "INF".into() } else { "-INF".into() }
    } else {
        // The shortest digits that read back the same.
        format!("{real:?}")
    }
}

/// The number in an `xs:double`.
pub(crate) fn real(text: &str) -> Option<f64> {
    match text {
        "NaN" => Some(f64::NAN),
        "INF" => Some(f64::INFINITY),
        "-INF" => Some(f64::NEG_INFINITY),
        // Rust reads words that XML Schema has not, such as `inf` and `infinity`.
        _ if text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E')) => {
            text.parse().ok()
        }
        _ => None,
    }
}

/// The value of an `xs:boolean`.
pub(crate) fn boolean(text: &str) -> Option<bool> {
    match text {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// Whether XML 1.0 can hold this character.
pub(crate) fn is_xml(character: char) -> bool {
    matches!(character, '\t' | '\n' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reals_are_written_as_xml_schema_has_them() {
        let texts = [1.0, -0.0, 0.1, 1e300, 1e-7, f64::INFINITY, f64::NEG_INFINITY, f64::NAN].map(real_text);
        assert_eq!(texts, ["1.0", "-0.0", "0.1", "1e300", "1e-7", "INF", "-INF", "NaN"]);
    }

    #[test]
    fn the_widest_and_narrowest_doubles_and_a_widened_32_bit_number_read_back_bit_by_bit() {
        for number in [f64::MAX, f64::MIN_POSITIVE, f64::from_bits(1), -0.0, f64::from(0.1_f32), 100.0 / 27648.0] {
            assert_eq!(real(&real_text(number)).map(f64::to_bits), Some(number.to_bits()));
        }
    }

    #[test]
    fn numbers_that_only_rust_would_read_are_none() {
        for text in ["inf", "+INF", "infinity", "nan", "1_000", "", ".", "e5", "0x10", "1,5", "1 "] {
            assert_eq!(real(text), None, "{text:?}");
        }
        assert_eq!(real("+1.E2"), Some(100.0));
    }
}
