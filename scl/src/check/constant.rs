//! Literals and their types.

use crate::check::types::{Class, Elementary};
use parameters::literal::{self, Refusal};
use parameters::problem::with_article;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Literal {
    /// An integer; without a type prefix, it takes the type its context requires.
    Whole(i128, Option<Elementary>),
    /// A number with a fraction, as LREAL and as REAL.
    Fraction(f64, f32, Option<Elementary>),
    /// TRUE or FALSE.
    Truth(bool),
    /// A string, and whether its prefix specifies 16-bit characters.
    Text(Vec<u16>, Option<bool>),
    /// A point in time: year, month, day, hour, minute, second, nanosecond.
    Moment([u32; 7]),
}

/// Reads a literal.
///
/// # Errors
/// The expected literal, as a phrase for the error message, and a remedy.
pub(crate) fn read(text: &str) -> Result<Literal, (String, Option<&'static str>)> {
    if text.starts_with('\'') {
        return Ok(Literal::Text(characters(text), None));
    }
    let Some((prefix, rest)) = text.split_once('#') else { return number(text, None) };
    let prefix = prefix.to_ascii_uppercase();
    let of = match prefix.as_str() {
        "2" | "8" | "16" => return number(text, None),
        "B" => Elementary::Byte,
        "W" => Elementary::Word,
        "DW" => Elementary::DWord,
        "LW" => Elementary::LWord,
        "L" => Elementary::DInt,
        "T" => Elementary::Time,
        "LT" => Elementary::LTime,
        "D" => Elementary::Date,
        "DTL" => return moment(rest),
        "STRING" | "WSTRING" | "CHAR" | "WCHAR" if rest.starts_with('\'') => {
            let text = characters(rest);
            return match prefix.as_str() {
                "CHAR" | "WCHAR" if text.len() == 1 => {
                    let of = if prefix == "CHAR" { Elementary::Char } else { Elementary::WChar };
                    Ok(Literal::Whole(i128::from(text[0]), Some(of)))
                }
                "CHAR" | "WCHAR" => Err(("a single character".into(), None)),
                _ => Ok(Literal::Text(text, Some(prefix == "WSTRING"))),
            };
        }
        "C" => return Err(("a number instead of a BCD constant".into(), Some("write its value"))),
        "S5T" | "S5TIME" => return Err(("a TIME instead of an S5TIME".into(), Some("use TON, TOF or TP with T#"))),
        "P" => {
            let help = "pass the variable itself, or ARRAY[*]";
            return Err(("a value instead of a pointer".into(), Some(help)));
        }
        _ => match Elementary::named(&prefix) {
            Some(of) => of,
            None => return Err(("a literal of a known type".into(), None)),
        },
    };
    match of.class() {
        Class::Time => {
            let resolution = if of == Elementary::Time { 1_000_000 } else { 1 };
            let count = literal::duration(rest, resolution).map_err(|reason| match reason {
                Refusal::Form => "a duration such as T#20S or T#1M30S500MS, with units in descending order".to_string(),
                Refusal::Range(range) => range.to_string(),
            });
            let count = count.map_err(|message| (message, None))?;
            in_range(count, of).map(|count| Literal::Whole(count, Some(of)))
        }
        Class::Bool => match rest.to_ascii_uppercase().as_str() {
            "TRUE" | "1" => Ok(Literal::Truth(true)),
            "FALSE" | "0" => Ok(Literal::Truth(false)),
            _ => Err(("TRUE or FALSE".into(), None)),
        },
        Class::Date => date(rest, of).map(|number| Literal::Whole(number, Some(of))),
        _ => number(rest, Some(of)),
    }
}

fn number(text: &str, of: Option<Elementary>) -> Result<Literal, (String, Option<&'static str>)> {
    let is_real = of.is_some_and(|of| of.class() == Class::Real);
    let is_fraction = !text.contains('#') && text.contains(['.', 'e', 'E']);
    if is_real || is_fraction && of.is_none() {
        let wide = match literal::parse(text, blocks::Kind::LReal) {
            Ok(blocks::Value::LReal(wide)) => wide,
            // A typed REAL may be written as an integer with a base.
            _ => match literal::integer(text) {
                Ok(whole) => whole as f64,
                Err(_) => return Err(("a number such as 2.5 or 1.0e-3".into(), None)),
            },
        };
        let narrow = match literal::parse(text, blocks::Kind::Real) {
            Ok(blocks::Value::Real(narrow)) => narrow,
            _ => wide as f32,
        };
        return Ok(Literal::Fraction(wide, narrow, of));
    }
    let whole = literal::integer(text).map_err(|_| {
        let help = text.ends_with(|last: char| last.is_alphabetic()).then_some("a duration begins with T#");
        ("a number".to_string(), help.filter(|_| !text.contains('#')))
    })?;
    match of {
        // With a base, the digits specify the bits of a signed type.
        Some(of) if text.contains('#') && whole > of.range().1 && whole < 1 << of.bits() => {
            Ok(Literal::Whole(whole - (1 << of.bits()), Some(of)))
        }
        // A negative bit string is its two's complement: -1 sets all bits.
        Some(of) if of.class() == Class::Bits && whole < 0 && -whole <= 1 << (of.bits() - 1) => {
            Ok(Literal::Whole(whole + (1 << of.bits()), Some(of)))
        }
        Some(of) => in_range(whole, of).map(|whole| Literal::Whole(whole, Some(of))),
        None => Ok(Literal::Whole(whole, None)),
    }
}

fn in_range(whole: i128, of: Elementary) -> Result<i128, (String, Option<&'static str>)> {
    let (low, high) = of.range();
    if (low..=high).contains(&whole) {
        return Ok(whole);
    }
    let unit = match of {
        Elementary::Time => " ms",
        Elementary::LTime => " ns",
        _ => "",
    };
    Err((format!("{} from {low} to {high}{unit}", with_article(of.name())), None))
}

/// The characters of a string literal in single quotes, as UTF-16.
fn characters(text: &str) -> Vec<u16> {
    let inner = text.strip_prefix('\'').and_then(|text| text.strip_suffix('\'')).unwrap_or(text);
    let mut characters = inner.chars().peekable();
    let mut units = Vec::new();
    let mut push = |character: char| units.extend(character.encode_utf16(&mut [0; 2]).iter());
    while let Some(character) = characters.next() {
        if character != '$' {
            push(character);
            continue;
        }
        match characters.next() {
            Some('L' | 'l' | 'N' | 'n') => push('\n'),
            Some('P' | 'p') => push('\u{c}'),
            Some('R' | 'r') => push('\r'),
            Some('T' | 't') => push('\t'),
            Some(first) if first.is_ascii_hexdigit() => {
                let second = characters.next_if(char::is_ascii_hexdigit);
                let digits: String = [Some(first), second].into_iter().flatten().collect();
                push(u32::from_str_radix(&digits, 16).ok().and_then(char::from_u32).unwrap_or(' '));
            }
            Some(other) => push(other),
            None => push('$'),
        }
    }
    units
}

/// A date or a time of day as encoded by the CPU.
fn date(text: &str, of: Elementary) -> Result<i128, (String, Option<&'static str>)> {
    const DAY: i128 = 86_400;
    const SECOND: i128 = 1_000_000_000;
    // DATE and DT count from 1990-01-01, LDT from 1970-01-01.
    let (text, origin, unit) = match of {
        Elementary::Date => (text.to_string(), days(1990, 1, 1), DAY * SECOND),
        Elementary::Ldt => (text.to_string(), days(1970, 1, 1), 1),
        Elementary::Dt => (text.to_string(), days(1990, 1, 1), 1),
        Elementary::Tod => (format!("1970-01-01-{text}"), days(1970, 1, 1), SECOND / 1000),
        _ => (format!("1970-01-01-{text}"), days(1970, 1, 1), 1),
    };
    let expected = || (format!("{}, such as D#2020-01-02 or TOD#03:04:05.6", with_article(of.name())), None);
    let Ok(Literal::Moment([year, month, day, hour, minute, second, nanosecond])) = moment(&text) else {
        return Err(expected());
    };
    let seconds = (days(year, month, day) - origin) * DAY + i128::from(hour * 3600 + minute * 60 + second);
    in_range((seconds * SECOND + i128::from(nanosecond)) / unit, of)
}

/// The days since 0000-03-01.
fn days(year: u32, month: u32, day: u32) -> i128 {
    // Years start in March, so that the leap day comes last.
    let (year, month) = if month < 3 { (i128::from(year) - 1, month + 9) } else { (i128::from(year), month - 3) };
    365 * year + year / 4 - year / 100 + year / 400 + i128::from((153 * month + 2) / 5 + day) - 1
}

/// Parses a point in time such as `2020-01-02-03:04:05.6`.
fn moment(text: &str) -> Result<Literal, (String, Option<&'static str>)> {
    let wrong = || ("a DTL such as DTL#2020-01-02-03:04:05.6".to_string(), None);
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    let mut parts = [0u32; 7];
    let mut count = 0;
    for part in whole.split(['-', ':']) {
        *parts.get_mut(count).filter(|_| count < 6).ok_or_else(wrong)? = part.parse().map_err(|_| wrong())?;
        count += 1;
    }
    let nanoseconds = format!("{fraction:0<9}");
    parts[6] = nanoseconds.get(..9).and_then(|digits| digits.parse().ok()).ok_or_else(wrong)?;
    let [year, month, day, hour, minute, second, _] = parts;
    let is_moment = (1970..=2554).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
    if count < 3 || !is_moment || hour > 23 || minute > 59 || second > 59 {
        return Err(wrong());
    }
    Ok(Literal::Moment(parts))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(text: &str) -> (i128, Option<Elementary>) {
        match read(text) {
            Ok(Literal::Whole(whole, of)) => (whole, of),
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn a_whole_number_has_a_type_if_one_is_written() {
        assert_eq!(whole("1_000"), (1000, None));
        assert_eq!(whole("16#FF"), (255, None));
        assert_eq!(whole("INT#-5"), (-5, Some(Elementary::Int)));
        assert_eq!(whole("W#16#6C00"), (27648, Some(Elementary::Word)));
        assert_eq!(whole("INT#16#FFFF"), (-1, Some(Elementary::Int)));
        assert_eq!(whole("ULINT#16#FFFF_FFFF_FFFF_FFFF"), (u64::MAX.into(), Some(Elementary::ULInt)));
        assert_eq!(read("SINT#128"), Err(("a SINT from -128 to 127".into(), None)));
        assert_eq!(read("10ms"), Err(("a number".into(), Some("a duration begins with T#"))));
    }

    #[test]
    fn durations_are_milliseconds_or_nanoseconds() {
        assert_eq!(whole("T#1m_30s"), (90_000, Some(Elementary::Time)));
        assert_eq!(whole("TIME#-1s"), (-1000, Some(Elementary::Time)));
        assert_eq!(whole("LT#1ms_5ns"), (1_000_005, Some(Elementary::LTime)));
        assert_eq!(read("T#25d"), Err(("a TIME from -2147483648 to 2147483647 ms".into(), None)));
        assert!(read("S5T#2S").unwrap_err().1.unwrap().contains("use TON, TOF or TP"));
    }

    #[test]
    fn dates_are_counted_from_the_day_of_their_type() {
        assert_eq!(whole("D#1990-01-01"), (0, Some(Elementary::Date)));
        assert_eq!(whole("D#2000-03-01"), (3712, Some(Elementary::Date)));
        assert_eq!(whole("TOD#01:00:00.5"), (3_600_500, Some(Elementary::Tod)));
        assert_eq!(whole("LDT#1970-01-02-00:00:00"), (86_400_000_000_000, Some(Elementary::Ldt)));
        assert!(read("TOD#25:00:00").is_err());
    }

    #[test]
    fn a_real_is_rounded_once() {
        let Ok(Literal::Fraction(wide, narrow, None)) = read("0.1") else { panic!() };
        assert_eq!((wide, narrow), (0.1, 0.1f32));
        let Ok(Literal::Fraction(wide, _, Some(Elementary::Real))) = read("REAL#2") else { panic!() };
        assert_eq!(wide, 2.0);
    }

    #[test]
    fn a_text_has_escapes() {
        let Ok(Literal::Text(text, None)) = read("'it$'s $41$L'") else { panic!() };
        assert_eq!(String::from_utf16(&text).unwrap(), "it's A\n");
    }
}
