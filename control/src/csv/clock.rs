//! Parses the times in a CSV file: seconds, milliseconds, dates and times of day.

use super::{Cells, Column, Times};

/// The recognized names of a time column, in lower case and without a unit.
pub(super) const NAMES: [&str; 18] = [
    "time",
    "t",
    "zeit",
    "timestamp",
    "time stamp",
    "time_stamp",
    "datetime",
    "date time",
    "date_time",
    "date/time",
    "date and time",
    "datum",
    "datum/uhrzeit",
    "datum uhrzeit",
    "datum/zeit",
    "date",
    "uhrzeit",
    "zeitstempel",
];

const NANOSECONDS: i64 = 1_000_000_000;
const DAY: i64 = 86_400 * NANOSECONDS;

/// A date, a time of day, or both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Stamp {
    /// The number of days since 1970-01-01.
    pub(super) day: Option<i64>,
    /// The number of nanoseconds since midnight.
    pub(super) clock: Option<i64>,
}

/// Parses a date, a time of day, or both: `2026-11-22 10:15:30.100`, `22.11.2026 10:15:30,1`, `11/22/2026 10:15 PM`,
/// `10:15:30:100`.
pub(super) fn parse(cell: &str, is_month_first: bool) -> Option<Stamp> {
    let cell = cell.trim();
    if cell.len() < 4 || cell.len() > 40 || !cell.is_ascii() || !cell.starts_with(|first: char| first.is_ascii_digit())
    {
        return None;
    }
    let split =
        cell.find([' ', 'T', 't', '-', '.', '/', ':']).filter(|at| matches!(cell.as_bytes()[*at], b'-' | b'.' | b'/'));
    if split.is_none() {
        return Some(Stamp { day: None, clock: Some(clock(cell)?) });
    }
    let end = cell.find([' ', 'T', 't', ';', '_']).unwrap_or(cell.len());
    let day = Some(date(&cell[..end], is_month_first)?);
    let rest = cell.get(end + 1..).unwrap_or("").trim();
    if rest.is_empty() {
        return Some(Stamp { day, clock: None });
    }
    Some(Stamp { day, clock: Some(clock(rest)?) })
}

/// Parses a date into the number of days since 1970-01-01.
fn date(text: &str, is_month_first: bool) -> Option<i64> {
    let sign = text.chars().find(|letter| !letter.is_ascii_digit())?;
    let parts: Vec<&str> = text.split(sign).collect();
    let [first, second, third] = parts[..] else { return None };
    let number = |text: &str| {
        let is_number = (1..=4).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
        is_number.then(|| text.parse::<i64>().ok()).flatten()
    };
    let (year, month, day) = match sign {
        _ if first.len() == 4 => (number(first)?, number(second)?, number(third)?),
        '/' if is_month_first => (number(third)?, number(first)?, number(second)?),
        '.' | '/' | '-' => (number(third)?, number(second)?, number(first)?),
        _ => return None,
    };
    let year = if third.len() == 2 && first.len() <= 2 { year + 2000 } else { year };
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return None,
    };
    if !(1..=length).contains(&day) || !(1900..=2200).contains(&year) {
        return None;
    }
    // Count years from March, so that the leap day is the last day of a year.
    let (from_march, year) = if month > 2 { (month - 3, year) } else { (month + 9, year - 1) };
    let before = (153 * from_march + 2) / 5 + day - 1;
    Some(365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + before - 719_468)
}

/// Parses a time of day into nanoseconds since midnight, less its offset from UTC; a duration may exceed a day.
fn clock(text: &str) -> Option<i64> {
    let upper = text.to_ascii_uppercase();
    let (text, afternoon) = match upper.trim_end().strip_suffix(['M']).and_then(|text| text.strip_suffix(['A', 'P'])) {
        Some(rest) => (rest.trim_end(), Some(upper.trim_end().ends_with("PM"))),
        None => (upper.as_str(), None),
    };
    let text = text.strip_suffix('Z').unwrap_or(text);
    let (text, offset) = match text.rfind(['+', '-']) {
        Some(at) => (&text[..at], offset(&text[at..])?),
        None => (text, 0),
    };
    let mut parts = text.trim().splitn(3, ':');
    let number = |text: &str, most: i64| {
        let is_number = (1..=4).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
        is_number.then(|| text.parse::<i64>().ok()).flatten().filter(|number| *number <= most)
    };
    let hours = number(parts.next()?, 9999)?;
    let minutes = number(parts.next()?, 59)?;
    let (seconds, fraction) = match parts.next() {
        None => (0, 0),
        Some(rest) => match rest.split_once(['.', ',', ':']) {
            None => (number(rest, 60)?, 0),
            Some((seconds, digits)) => {
                if digits.is_empty() || digits.len() > 12 || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
                    return None;
                }
                let nine: String = digits.chars().chain(std::iter::repeat('0')).take(9).collect();
                (number(seconds, 60)?, nine.parse::<i64>().ok()?)
            }
        },
    };
    let hours = match afternoon {
        Some(_) if !(1..=12).contains(&hours) => return None,
        Some(is_afternoon) => hours % 12 + if is_afternoon { 12 } else { 0 },
        None => hours,
    };
    Some(((hours * 60 + minutes) * 60 + seconds) * NANOSECONDS + fraction - offset)
}

/// Parses an offset from UTC into nanoseconds: `+01:00`, `+0100`, `+01`.
fn offset(text: &str) -> Option<i64> {
    let sign = if text.starts_with('-') { -1 } else { 1 };
    let digits: String = text[1..].chars().filter(|letter| *letter != ':').collect();
    let number: i64 = digits.parse().ok()?;
    let (hours, minutes) = match digits.len() {
        1 | 2 => (number, 0),
        4 => (number / 100, number % 100),
        _ => return None,
    };
    Some(sign * (hours * 60 + minutes) * 60 * NANOSECONDS)
}

/// Merges the first column of dates without times into the first column of times of day without dates, if both exist.
pub(super) fn join(columns: &mut [Cells]) {
    let is = |cells: &Cells, has: fn(&Stamp) -> bool| cells.dates > 0 && cells.stamps.iter().any(has);
    let is_date = |cells: &Cells| is(cells, |stamp| stamp.day.is_some()) && !is(cells, |stamp| stamp.clock.is_some());
    let is_clock = |cells: &Cells| is(cells, |stamp| stamp.clock.is_some()) && !is(cells, |stamp| stamp.day.is_some());
    let (Some(date), Some(time)) = (columns.iter().position(is_date), columns.iter().position(is_clock)) else {
        return;
    };
    let days: Vec<_> = columns[date].stamps.iter().map(|stamp| stamp.day).collect();
    for (stamp, day) in columns[time].stamps.iter_mut().zip(days) {
        stamp.day = day;
    }
    columns[date].is_merged = true;
}

/// Converts timestamps into seconds after the first row. Times of day without a date are assumed to pass midnight when
/// they fall by more than half a day.
pub(super) fn seconds(stamps: &[Stamp]) -> Vec<f64> {
    let is_dated = stamps.iter().any(|stamp| stamp.day.is_some());
    let (mut first, mut last, mut midnights) = (None, i64::MIN, 0);
    let seconds = stamps.iter().map(|stamp| {
        if stamp.day.is_none() && (is_dated || stamp.clock.is_none()) {
            return f64::NAN;
        }
        let clock = stamp.clock.unwrap_or(0);
        if !is_dated && last != i64::MIN && clock < last - DAY / 2 {
            midnights += 1;
        }
        last = clock;
        let at = (stamp.day.unwrap_or(0) + midnights) * DAY + clock;
        let after = at - *first.get_or_insert(at);
        (after / NANOSECONDS) as f64 + (after % NANOSECONDS) as f64 / NANOSECONDS as f64
    });
    seconds.collect()
}

/// Returns the length of a unit of time in seconds.
pub fn seconds_of_unit(unit: &str) -> Option<f64> {
    Some(match unit.trim().to_lowercase().as_str() {
        "s" | "sec" | "second" | "seconds" | "sek" | "sekunden" => 1.0,
        "ms" | "msec" | "millisecond" | "milliseconds" | "millisekunden" => 1e-3,
        "us" | "\u{b5}s" | "\u{3bc}s" => 1e-6,
        "ns" => 1e-9,
        "min" | "minute" | "minutes" | "minuten" => 60.0,
        "h" | "hour" | "hours" | "std" | "stunden" => 3600.0,
        "d" | "day" | "days" => 86_400.0,
        _ => return None,
    })
}

/// Splits a name such as `time_ms` into the name in lower case and the unit at its end.
pub(super) fn unit_of_name(name: &str) -> (String, Option<f64>) {
    let name = name.trim().to_lowercase();
    match name.rsplit_once(['_', ' ']) {
        Some((rest, unit)) if seconds_of_unit(unit).is_some() => (rest.trim().into(), seconds_of_unit(unit)),
        _ => (name, None),
    }
}

/// Converts a column whose values never decrease into times in seconds.
pub(super) fn times(column: &Column) -> Times {
    if column.is_clock {
        return Times { seconds: column.values.clone(), is_unit_known: true, remark: None };
    }
    let (_, of_name) = unit_of_name(&column.name);
    let known = column.unit.as_deref().and_then(seconds_of_unit).or(of_name);
    let (first, last) = (column.values.first().copied().unwrap_or(0.0), column.values.last().copied().unwrap_or(0.0));
    let mut steps: Vec<f64> =
        column.values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    let middle = steps.len() / 2;
    let step = if steps.is_empty() { 1.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 };
    let is_whole = column.decimals <= 0;
    let (factor, is_absolute, guess) = match known {
        Some(factor) => (factor, first * factor > 1e8, None),
        // Without a unit, large values are milliseconds or seconds since 1970, or days since 1900 as in spreadsheets.
        None if first > 1e11 && first < 1e13 => (1e-3, true, Some("milliseconds since 1970")),
        None if first > 1e8 && first < 1e10 => (1.0, true, None),
        None if first > 20_000.0 && last < 80_000.0 && step < 0.5 && !is_whole => (86_400.0, true, Some("days")),
        None if is_whole && step >= 100.0 && step % 60.0 != 0.0 => (1e-3, false, Some("milliseconds")),
        None => (1.0, false, None),
    };
    let origin = if is_absolute { first } else { 0.0 };
    // Dividing by 1000 rounds correctly, so that 100 ms becomes the number nearest to 0.1; multiplying by 0.001 may
    // not.
    let scaled = |value: f64| if factor < 1.0 { value / (1.0 / factor).round() } else { value * factor };
    let remark = guess.map(|unit| {
        format!(
            "Column {} has steps of {step} and no unit: it is read as {unit}. If this is wrong, add the \
             unit to the header, as in {} [s].",
            column.name, column.name
        )
    });
    let seconds = column.values.iter().map(|value| scaled(value - origin)).collect();
    Times { seconds, is_unit_known: known.is_some() || is_absolute, remark }
}
