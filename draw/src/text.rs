//! Formats values for display.

pub use modeldescription::digits::number;
use modeldescription::{Row, units};

/// A variable's value with its unit: `TRUE`, `20 s`, `20 °C`, `0.1`.
pub fn value(row: &Row, value: f64) -> String {
    let number = number(row.kind, value);
    match row.shown_unit() {
        Some(unit) => units::shown(&format!("{number} {unit}")),
        None => number,
    }
}

/// The plausible range: `0 ... 100`, `≥ 0.001`, `≤ 5`; empty if there are no limits.
pub fn range(row: &Row) -> String {
    let number = |value| number(row.kind, value);
    match (row.least(), row.greatest()) {
        (Some(min), Some(max)) => format!("{} ... {}", number(min), number(max)),
        (Some(min), None) => format!("\u{2265} {}", number(min)),
        (None, Some(max)) => format!("\u{2264} {}", number(max)),
        (None, None) => String::new(),
    }
}

/// The description and, separately, the range that follows it in words because it depends on other variables: the text
/// before and after `; range: `. `None` if the variable has both `min` and `max`, or its description has no such range.
pub fn range_in_words(row: &Row) -> Option<(&str, &str)> {
    match (row.least(), row.greatest()) {
        (Some(_), Some(_)) => None,
        _ => row.description.split_once("; range: "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Kind, Role, Time, Value};

    fn row(kind: Kind, unit: Option<&str>) -> Row {
        Row { unit: unit.map(str::to_string), ..Row::new("X", Role::Input, Value::zero(kind)) }
    }

    #[test]
    fn values_are_written_as_people_read_them() {
        assert_eq!(value(&row(Kind::Bool, None), 1.0), "TRUE");
        assert_eq!(value(&row(Kind::Bool, None), 0.0), "FALSE");
        assert_eq!(value(&row(Kind::Time, None), 0.02), "0.02 s");
        assert_eq!(value(&row(Kind::LReal, Some("degC")), 21.5), "21.5 °C");
        assert_eq!(value(&row(Kind::LReal, Some("m2")), 0.2), "0.2 m²");
        assert_eq!(value(&row(Kind::Real, None), f64::from(0.1f32)), "0.1");
        assert_eq!(value(&row(Kind::LReal, None), f64::from(0.1f32)), "0.10000000149011612");
        assert_eq!(value(&row(Kind::Word, None), -32768.0), "-32768");
        assert_eq!(value(&row(Kind::Real, None), f64::from(f32::MAX)), "3.4028235e38");
    }

    #[test]
    fn a_range_may_have_one_end() {
        let mut row = row(Kind::Time, None);
        assert_eq!(range(&row), "");
        row.min = Some(Value::Time(Time::ms(1)));
        assert_eq!(range(&row), "\u{2265} 0.001");
        row.max = Some(Value::Time(Time::ms(2000)));
        assert_eq!(range(&row), "0.001 ... 2");
        row.min = None;
        assert_eq!(range(&row), "\u{2264} 2");
    }

    #[test]
    fn a_range_in_words_is_that_of_the_description() {
        let mut row = row(Kind::Time, None);
        assert_eq!(range_in_words(&row), None);
        row.description = "Reset time; range: TI >= CYCLE".into();
        assert_eq!(range_in_words(&row), Some(("Reset time", "TI >= CYCLE")));
        row.min = Some(Value::Time(Time::ms(1)));
        assert_eq!(range_in_words(&row), Some(("Reset time", "TI >= CYCLE")));
        row.max = Some(Value::Time(Time::ms(9000)));
        assert_eq!(range_in_words(&row), None);
    }
}
