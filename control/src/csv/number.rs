//! Parses numbers, and words for true, false and missing values, in a CSV file.

use anyhow::{Result, bail};

/// The format of numbers and dates in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Style {
    /// Whether the decimal sign is a comma.
    is_comma: bool,
    /// Whether the month comes first in a date with slashes: 11/12/2026 is in November.
    pub(super) is_month_first: bool,
}

/// A parsed number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    pub(super) value: f64,
    /// The number of decimal places.
    pub(super) decimals: i32,
    /// The number of significant digits.
    pub(super) digits: i32,
}

/// The meaning of a point or comma in a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sign {
    /// A decimal point: `12.5`, `0.125`, `1,234.5`.
    Point,
    /// A decimal comma: `12,5`, `0,125`, `1.234,5`.
    Comma,
    /// Ambiguous, `1.234`: a decimal point, or a thousands separator.
    MaybePoint,
    /// Ambiguous, `1,234`: a decimal comma, or a thousands separator.
    MaybeComma,
}

/// What the cells read so far reveal about the format.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// The line, column and text of the first number of each [`Sign`].
    signs: [Option<(usize, usize, String)>; 4],
    is_day_first: bool,
    is_month_first: bool,
    has_am_pm: bool,
}

impl Found {
    /// Records what a cell reveals about the format.
    pub(super) fn look_at(&mut self, cell: &str, (line, column): (usize, usize)) {
        if cell.bytes().any(|byte| matches!(byte, b'.' | b',')) {
            if let Some(sign) = sign(cell) {
                self.signs[sign as usize].get_or_insert_with(|| (line, column, cell.into()));
            }
        } else if !cell.contains('/') {
            return;
        }
        if let [first, second, _] = cell.split('/').collect::<Vec<_>>()[..] {
            let number = |text: &str| text.trim().parse::<u32>().ok();
            if let (Some(first), Some(second)) = (number(first), number(second)) {
                self.is_day_first |= first > 12 && first < 32;
                self.is_month_first |= second > 12 && second < 32;
                self.has_am_pm |= cell.trim_end().to_uppercase().ends_with('M');
            }
        }
    }

    /// Returns the format of the file, or an error if decimal points and decimal commas are mixed. `name` returns the
    /// name of a column.
    pub(super) fn style<'a>(&self, is_separated_by_comma: bool, name: impl Fn(usize) -> &'a str) -> Result<Style> {
        let [point, comma, maybe_point, maybe_comma] = &self.signs;
        let both = |a: &(usize, usize, String), b: &(usize, usize, String)| {
            format!(
                "line {}, column {} ({}) has {:?}, and line {}, column {} ({}) has {:?}: write all numbers with the same \
                 decimal sign, and without thousands separators",
                a.0,
                a.1 + 1,
                name(a.1),
                a.2,
                b.0,
                b.1 + 1,
                name(b.1),
                b.2
            )
        };
        let is_comma = match (point, comma) {
            (Some(point), Some(comma)) => bail!(both(point, comma)),
            (None, Some(_)) => true,
            (Some(_), None) => false,
            (None, None) => match (maybe_point, maybe_comma) {
                (Some(point), Some(comma)) => bail!(both(point, comma)),
                // In a file separated by commas, a quoted number such as 1,234 has a thousands separator unless other
                // cells show a decimal comma.
                (None, Some(_)) => !is_separated_by_comma,
                _ => false,
            },
        };
        let is_month_first = !self.is_day_first && (self.is_month_first || self.has_am_pm);
        Ok(Style { is_comma, is_month_first })
    }
}

/// Classifies the point or comma of a number; `None` if the cell is not a number with a point or comma.
fn sign(cell: &str) -> Option<Sign> {
    let cell = cell.trim().trim_start_matches(['+', '-']);
    let (mantissa, exponent) = match cell.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, Some(exponent)),
        None => (cell, None),
    };
    if exponent.is_some_and(|exponent| exponent.parse::<i32>().is_err()) {
        return None;
    }
    if mantissa.is_empty()
        || !mantissa.chars().all(|letter| letter.is_ascii_digit() || is_grouping(letter) || matches!(letter, '.' | ','))
    {
        return None;
    }
    let (points, commas) = (mantissa.matches('.').count(), mantissa.matches(',').count());
    let is_grouped = |separator: char| {
        let mut groups = mantissa.split(['.', ',']);
        let first = groups.next().unwrap_or_default();
        let is_first = (1..=3).contains(&first.len()) && !first.starts_with('0');
        is_first && exponent.is_none() && mantissa.split(separator).skip(1).all(|group| group.len() == 3)
    };
    match (points, commas) {
        (0, 0) => None,
        (1, 0) if is_grouped('.') => Some(Sign::MaybePoint),
        (0, 1) if is_grouped(',') => Some(Sign::MaybeComma),
        (1, 0) => Some(Sign::Point),
        (0, 1) => Some(Sign::Comma),
        // Several equal signs separate thousands, so the other one is the decimal sign.
        (_, 0) if is_grouped('.') => Some(Sign::Comma),
        (0, _) if is_grouped(',') => Some(Sign::Point),
        (1, _) if mantissa.find('.') > mantissa.rfind(',') => Some(Sign::Point),
        (_, 1) if mantissa.find(',') > mantissa.rfind('.') => Some(Sign::Comma),
        _ => None,
    }
}

/// Whether a character is a space or an apostrophe that separates thousands.
fn is_grouping(letter: char) -> bool {
    matches!(letter, ' ' | '\'' | '\u{a0}' | '\u{202f}' | '\u{2019}')
}

impl Style {
    /// Parses a number in this format.
    pub(super) fn number(&self, cell: &str) -> Option<Number> {
        let first = cell.trim_start_matches(['+', '-']).bytes().next()?;
        if !first.is_ascii_digit() && !matches!(first, b'.' | b',') {
            return infinity(cell);
        }
        let is_plain =
            cell.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b'+' | b'-' | b'e' | b'E'));
        let has_one_point = !self.is_comma || !cell.contains('.');
        if is_plain && has_one_point {
            return Some(Number::new(cell.parse().ok()?, cell));
        }
        let (decimal, thousands) = if self.is_comma { (',', '.') } else { ('.', ',') };
        let (whole, fraction) = match cell.split_once(decimal) {
            Some((whole, fraction)) => (whole, Some(fraction)),
            None => (cell, None),
        };
        let mut plain = String::with_capacity(cell.len());
        let is_group = |letter: char| letter == thousands || is_grouping(letter);
        if whole.contains(is_group) {
            let mut groups = whole.split(is_group);
            let first = groups.next().unwrap_or_default().trim_start_matches(['+', '-']);
            if !(1..=3).contains(&first.len()) || !groups.all(|group| group.len() == 3) {
                return None;
            }
        }
        plain.extend(whole.chars().filter(|letter| !is_group(*letter)));
        if let Some(fraction) = fraction {
            if fraction.contains(decimal) || fraction.contains(thousands) {
                return None;
            }
            plain.push('.');
            plain.push_str(fraction);
        }
        Some(Number::new(plain.parse().ok()?, &plain))
    }
}

impl Number {
    /// Counts the digits and decimal places of `text`, in which the decimal sign is a point.
    fn new(value: f64, text: &str) -> Number {
        let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
        let exponent: i32 = exponent.parse().unwrap_or(0);
        let decimals = mantissa.split_once('.').map_or(0, |(_, fraction)| fraction.len() as i32);
        let digits =
            mantissa.bytes().skip_while(|byte| !matches!(byte, b'1'..=b'9')).filter(u8::is_ascii_digit).count();
        Number { value, decimals: decimals.saturating_sub(exponent).clamp(-300, 300), digits: (digits as i32).min(300) }
    }
}

fn infinity(cell: &str) -> Option<Number> {
    let value = match cell.to_lowercase().as_str() {
        "inf" | "+inf" | "infinity" => f64::INFINITY,
        "-inf" | "-infinity" => f64::NEG_INFINITY,
        _ => return None,
    };
    Some(Number { value, decimals: 0, digits: 0 })
}

/// Whether a cell denotes a missing value.
pub(super) fn is_missing(cell: &str) -> bool {
    cell.is_empty()
        || cell.len() <= 7
            && ["nan", "-", "--", "---", "n/a", "#n/a", "na", "null", "none", "bad", "#nv", "-nan", "?", "#value!"]
                .iter()
                .any(|word| cell.eq_ignore_ascii_case(word))
}

/// Parses the words for true and false.
pub(super) fn boolean(cell: &str) -> Option<bool> {
    const WORDS: [(&str, &str); 4] = [("TRUE", "FALSE"), ("ON", "OFF"), ("YES", "NO"), ("EIN", "AUS")];
    const MORE: [(&str, &str); 2] = [("WAHR", "FALSCH"), ("JA", "NEIN")];
    if cell.len() > 6 {
        return None;
    }
    let is = |word: &str| cell.eq_ignore_ascii_case(word);
    WORDS.iter().chain(&MORE).find_map(|(yes, no)| if is(yes) { Some(true) } else { is(no).then_some(false) })
}

/// Parses a TIME literal of a PLC program, such as `T#20S`, into seconds.
pub(super) fn literal(cell: &str) -> Option<f64> {
    if !cell.starts_with(['T', 't']) {
        return None;
    }
    parameters::literal::parse(cell, blocks::Kind::Time).ok().map(blocks::table::number::number)
}

/// Whether a cell is a number in any format, or a word for true or false.
pub(super) fn is_value(cell: &str) -> bool {
    let cell = cell.trim();
    let in_style = |is_comma| Style { is_comma, ..Style::default() }.number(cell).is_some();
    boolean(cell).is_some() || literal(cell).is_some() || in_style(false) || in_style(true)
}
