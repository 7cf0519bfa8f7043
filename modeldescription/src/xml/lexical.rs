//! Attribute values as written in XML Schema.

use std::borrow::Cow;

/// White space in XML.
pub(crate) const SPACES: [char; 4] = [' ', '\t', '\n', '\r'];

/// A type of attribute values. White space around numbers and words is ignored when reading.
pub(crate) trait Value: Sized {
    /// Parses a value; `None` if the string is invalid.
    fn parse(text: &str) -> Option<Self>;

    /// A description of valid strings, for messages: "expected ...".
    fn expected() -> Cow<'static, str>;

    /// The string that reads back as this value; `None` if the attribute is omitted.
    fn text(&self) -> Option<Cow<'_, str>>;

    /// The value of an absent attribute without a default; `None` if the attribute is required.
    fn absent() -> Option<Self> {
        None
    }
}

impl Value for String {
    fn parse(text: &str) -> Option<String> {
        Some(text.to_owned())
    }

    fn expected() -> Cow<'static, str> {
        "a string".into()
    }

    fn text(&self) -> Option<Cow<'_, str>> {
        Some(self.into())
    }
}

impl Value for f64 {
    fn parse(text: &str) -> Option<f64> {
        match text.trim_matches(SPACES) {
            "NaN" => Some(f64::NAN),
            "INF" => Some(f64::INFINITY),
            "-INF" => Some(f64::NEG_INFINITY),
            // Rust also accepts words unknown to XML Schema, such as `inf` and `infinity`.
            text if text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E')) => {
                text.parse().ok()
            }
            _ => None,
        }
    }

    fn expected() -> Cow<'static, str> {
        "a number, such as 0.5, 1e-3 or INF".into()
    }

    fn text(&self) -> Option<Cow<'_, str>> {
        Some(match *self {
            f64::INFINITY => "INF".into(),
            f64::NEG_INFINITY => "-INF".into(),
            // The shortest digits that read back as the same bits; a NaN is "NaN".
            number => format!("{number:?}").into(),
        })
    }
}

macro_rules! integers {
    ($($Integer:ident),*) => { $(
        impl Value for $Integer {
            fn parse(text: &str) -> Option<$Integer> {
                text.trim_matches(SPACES).parse().ok()
            }

            fn expected() -> Cow<'static, str> {
                format!("an integer from {} to {}", $Integer::MIN, $Integer::MAX).into()
            }

            fn text(&self) -> Option<Cow<'_, str>> {
                Some(self.to_string().into())
            }
        }
    )* };
}

integers!(i32, u32, u64, i64, i128);

impl Value for bool {
    fn parse(text: &str) -> Option<bool> {
        match text.trim_matches(SPACES) {
            "true" | "1" => Some(true),
            "false" | "0" => Some(false),
            _ => None,
        }
    }

    fn expected() -> Cow<'static, str> {
        "true or false".into()
    }

    fn text(&self) -> Option<Cow<'_, str>> {
        Some(if *self { "true" } else { "false" }.into())
    }
}

impl<T: Value> Value for Option<T> {
    fn parse(text: &str) -> Option<Option<T>> {
        T::parse(text).map(Some)
    }

    fn expected() -> Cow<'static, str> {
        T::expected()
    }

    fn text(&self) -> Option<Cow<'_, str>> {
        self.as_ref().and_then(T::text)
    }

    fn absent() -> Option<Option<T>> {
        Some(None)
    }
}

/// A list of items separated by white space.
impl<T: Value> Value for Vec<T> {
    fn parse(text: &str) -> Option<Vec<T>> {
        text.split(SPACES).filter(|item| !item.is_empty()).map(T::parse).collect()
    }

    fn expected() -> Cow<'static, str> {
        format!("a list separated by spaces, with each item {}", T::expected()).into()
    }

    fn text(&self) -> Option<Cow<'_, str>> {
        Some(self.iter().filter_map(T::text).collect::<Vec<_>>().join(" ").into())
    }
}

/// Whether XML 1.0 can represent this character.
pub(crate) fn is_xml(character: char) -> bool {
    matches!(character, '\t' | '\n' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn real(text: &str) -> Option<f64> {
        Value::parse(text)
    }

    #[test]
    fn reals_are_written_as_xml_schema_has_them() {
        let numbers = [1.0, -0.0, 0.1, 1e300, 1e-7, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        let texts = numbers.each_ref().map(|number| number.text().unwrap());
        assert_eq!(texts, ["1.0", "-0.0", "0.1", "1e300", "1e-7", "INF", "-INF", "NaN"]);
    }

    #[test]
    fn the_widest_and_narrowest_doubles_and_a_widened_32_bit_number_read_back_bit_by_bit() {
        for number in [f64::MAX, f64::MIN_POSITIVE, f64::from_bits(1), -0.0, f64::from(0.1_f32), 100.0 / 27648.0] {
            assert_eq!(real(&number.text().unwrap()).map(f64::to_bits), Some(number.to_bits()));
        }
    }

    #[test]
    fn numbers_that_only_rust_would_read_are_refused() {
        for text in ["inf", "+INF", "infinity", "nan", "1_000", "", ".", "e5", "0x10", "1,5", "1 2"] {
            assert_eq!(real(text), None, "{text:?}");
        }
        assert_eq!(real("+1.E2"), Some(100.0));
        assert_eq!(real("\t1 "), Some(1.0));
    }
}
