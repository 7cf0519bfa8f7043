//! CSV files as plants, recorders and spreadsheets write them, read as columns of numbers.
//!
//! The separator (comma, semicolon, tab), the decimal sign (point or comma), units in the header (`PV [degC]`) and the
//! format of the time (seconds, milliseconds, date and time of day) are detected. If they are ambiguous, there is an
//! error or a remark.

mod clock;
pub mod names;
mod number;

pub use clock::seconds_of_unit;

use anyhow::{Context, Result, bail};
use number::Style;
use std::error::Error;
use std::fmt;

/// The maximum size of the text in bytes.
pub const LARGEST: usize = 128 << 20;

/// The maximum number of values in all columns together.
pub const MOST_VALUES: usize = 32 << 20;

/// The maximum number of columns.
const MOST_COLUMNS: usize = 20_000;

/// The maximum length in bytes of a sampled line.
const LONGEST_LINE: usize = 1 << 20;

/// The headers by which a column with the names of loops is recognized, in lower case.
pub const LOOP_NAMES: [&str; 3] = ["loop", "name", "tag"];

/// What each row of a file represents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RowsAre {
    /// A call of a block; the rows are in chronological order.
    Calls,
    /// A control loop. A column named like a variable must have a number in each row.
    Loops,
}

/// An error in a line of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    line: usize,
    /// The 1-based column number and the name; `None` if the error concerns the whole line.
    column: Option<(usize, String)>,
    /// The message after "line 3" or "line 3, column 2 (PV):".
    text: String,
}

impl Fault {
    /// Formats the error with the file's name: `loops.csv:3:2: PUMP.SPEED: missing number: complete the row, or remove
    /// it`.
    pub fn in_file(&self, file: &str) -> String {
        let Fault { line, text, .. } = self;
        match &self.column {
            Some((number, name)) => format!("{file}:{line}:{number}: {name}: {text}"),
            None => format!("{file}:{line}:1: the line {text}"),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Fault { line, text, .. } = self;
        match &self.column {
            Some((number, name)) => write!(formatter, "line {line}, column {number} ({name}): {text}"),
            None => write!(formatter, "line {line} {text}"),
        }
    }
}

impl Error for Fault {}

/// A parsed CSV file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CsvTable {
    /// The columns in the order of the file. Text columns are left out. If dates and times of day are in separate
    /// columns, the dates are merged into the column of times.
    pub columns: Vec<Column>,
    /// The 1-based line number of each row in the file.
    pub lines: Vec<usize>,
    /// Remarks for the user, one sentence each.
    pub remarks: Vec<String>,
}

/// A column of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// The name without the unit.
    pub name: String,
    /// The name with its unit, as written in the header.
    pub header: String,
    /// The 1-based column number in the file.
    pub number: usize,
    /// The unit given in the header: `PV [degC]`, `PV (degC)` or `PV / degC`.
    pub unit: Option<String>,
    /// The values, one per row; TRUE and ON are 1. A missing value is NaN.
    pub values: Vec<f64>,
    /// Whether the values were written as dates or times of day; `values` then holds seconds after the first row.
    pub is_clock: bool,
    /// Whether the values were written as words, such as TRUE and FALSE.
    pub is_boolean: bool,
    /// The largest number of decimal places in a value.
    pub decimals: i32,
    /// The largest number of significant digits in a value.
    pub digits: i32,
}

impl Column {
    /// Reports missing values among these rows: `Line 5, column PV: no value (nor in 2 later rows)`.
    /// `lines` holds the table's line numbers.
    pub(crate) fn missing(&self, rows: impl Iterator<Item = usize>, lines: &[usize]) -> Option<String> {
        let mut missing = rows.filter(|row| self.values[*row].is_nan());
        let first = missing.next()?;
        let more = match missing.count() {
            0 => String::new(),
            more => format!(" (nor in {more} later row{})", if more == 1 { "" } else { "s" }),
        };
        Some(format!("Line {}, column {}: no value{more}", lines[first], self.name))
    }

    /// Returns the maximum rounding error of a value as written: half of its last digit. A column with up to three
    /// decimals, such as 0.125, may be off by 0.0005; one with six significant digits, such as 123.456 and 0.00123456,
    /// by half of the sixth digit.
    pub fn resolution(&self, value: f64) -> f64 {
        if self.is_boolean || self.is_clock || !value.is_finite() {
            return 0.0;
        }
        let fixed = 0.5 * 10f64.powi(-self.decimals);
        let exponent = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
        if value == 0.0 { fixed } else { fixed.max(0.5 * 10f64.powi(exponent - self.digits + 1)) }
    }
}

/// The times of the rows in seconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Times {
    /// The seconds, which never decrease. Dates are converted to seconds after the first row.
    pub seconds: Vec<f64>,
    /// Whether the unit is stated in the header or evident from the values; otherwise, it was guessed from the size of
    /// the steps.
    pub is_unit_known: bool,
    /// A sentence that states the guessed unit, if it is not seconds.
    pub remark: Option<String>,
}

impl CsvTable {
    /// Parses a file's text.
    ///
    /// # Errors
    /// The text is malformed; the message states the line, where possible the column, and the remedy.
    pub fn read(text: &str) -> Result<CsvTable> {
        Layout::new(text, RowsAre::Calls)?.read()
    }

    /// Parses a table with one row per loop. A column named like a variable, `FMU.VARIABLE`, may contain only
    /// numbers.
    ///
    /// # Errors
    /// As in [`CsvTable::read`]; a [`Fault`] if the error concerns a line.
    pub fn of_loops(text: &str) -> Result<CsvTable> {
        Layout::new(text, RowsAre::Loops)?.read()
    }

    /// Returns the names of the columns with their units, as written in the header.
    pub fn headers(self) -> Vec<String> {
        self.columns.into_iter().map(|column| column.header).collect()
    }

    /// Returns the number of data rows.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// Returns the index of the column with this name, with or without its unit, ignoring case.
    pub fn find(&self, name: &str) -> Option<usize> {
        let written = |column: &Column| column.header == name;
        let equal = |column: &Column| column.name == name;
        let alike = |column: &Column| column.name.trim().to_lowercase() == name.trim().to_lowercase();
        let position = |is_it: &dyn Fn(&Column) -> bool| self.columns.iter().position(is_it);
        position(&written).or_else(|| position(&equal)).or_else(|| position(&alike))
    }

    /// Returns the column for the first of these names, in upper case, that is the [short name](names::short_name) of a
    /// column.
    pub fn called(&self, names: &[&str]) -> Option<&Column> {
        let short: Vec<String> = self.columns.iter().map(|column| names::short_name(&column.name)).collect();
        let place = names.iter().find_map(|name| short.iter().position(|short| short == name))?;
        Some(&self.columns[place])
    }

    /// Returns the column with this name, as in [`CsvTable::find`].
    ///
    /// # Errors
    /// No column has this name; the message lists the existing ones, at most 20.
    pub fn column(&self, name: &str) -> Result<&Column> {
        let names = || self.columns.iter().map(|column| column.name.as_str());
        let found = self.find(name).with_context(|| {
            let near = run::plan::suggestion(name, names());
            let list: Vec<_> = names().take(20).collect();
            let more = if self.columns.len() > list.len() { ", ..." } else { "" };
            format!("the file has no column {name}; available: {}{more}{near}", list.join(", "))
        })?;
        Ok(&self.columns[found])
    }

    /// Returns the index of the time column: the one with a name such as `time`, `t [ms]`, `Zeit` or `timestamp`;
    /// otherwise the first with dates or times of day; otherwise the first column if its unit is a time unit.
    pub fn time(&self) -> Option<usize> {
        let named = |column: &Column| {
            let (name, _) = clock::unit_of_name(&column.name);
            clock::NAMES.contains(&name.as_str())
        };
        let by_unit = || {
            let first = self.columns.first()?;
            first.unit.as_deref().and_then(seconds_of_unit).map(|_| 0)
        };
        let dated = self.columns.iter().position(|column| column.is_clock && named(column));
        let dated = dated.or_else(|| self.columns.iter().position(named));
        dated.or_else(|| self.columns.iter().position(|column| column.is_clock)).or_else(by_unit)
    }

    /// Returns the times of the rows in seconds, from the given column.
    ///
    /// # Errors
    /// A time is missing or decreases.
    pub fn times(&self, column: usize) -> Result<Times> {
        let of = &self.columns[column];
        for (row, value) in of.values.iter().enumerate() {
            let line = self.lines[row];
            if !value.is_finite() {
                bail!("line {line}, column {}: missing time: complete the row, or remove it", of.name);
            }
            if row > 0 && *value < of.values[row - 1] {
                bail!(
                    "line {line}, column {}: the time decreases from {:?} to {value:?}; sort the rows, or cut the file \
                     there",
                    of.name,
                    of.values[row - 1]
                );
            }
        }
        Ok(clock::times(of))
    }
}

/// Returns the names of the loops in a table with one row per loop; `None` if the table has no column for names.
///
/// # Errors
/// The text is not a CSV file.
pub fn loop_names(text: &str) -> Result<Option<Vec<String>>> {
    let layout = Layout::new(text, RowsAre::Loops)?;
    let Some(column) = layout.header.iter().position(Header::has_loop_names) else { return Ok(None) };
    let mut texts = Vec::new();
    layout.each(|_, record| {
        texts.push(record.get(column).unwrap_or_default().to_string());
        Ok(())
    })?;
    Ok(Some(texts))
}

/// Where the rows of a text begin, and their format.
struct Layout<'a> {
    text: &'a str,
    /// The 1-based line number at which `text` begins.
    line: usize,
    separator: u8,
    rows_are: RowsAre,
    header: Vec<Header>,
    /// The number of records in `text` before the first row of values.
    skip: usize,
}

/// The name and unit of a column.
struct Header {
    /// The name and unit as written; `column 3` for a column without a name.
    written: String,
    name: String,
    unit: Option<String>,
}

fn reader(text: &str, separator: u8) -> ::csv::Reader<&[u8]> {
    let mut builder = ::csv::ReaderBuilder::new();
    builder.delimiter(separator).has_headers(false).flexible(true).trim(::csv::Trim::All);
    builder.from_reader(text.as_bytes())
}

/// The number of records from which the layout is determined.
const SAMPLE: usize = 100;

impl<'a> Layout<'a> {
    fn new(text: &'a str, rows_are: RowsAre) -> Result<Layout<'a>> {
        if text.len() > LARGEST {
            bail!(
                "the file has {} bytes; at most {LARGEST} are read: cut out the part of interest, or keep every tenth \
                 row",
                text.len()
            );
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        // Reject a binary file before parsing anything. U+001A is allowed because DOS text files end with it.
        let is_binary = |c: &char| c.is_control() && !c.is_whitespace() && *c != '\u{1a}';
        if let Some(found) = text.chars().take(LONGEST_LINE).find(is_binary) {
            bail!("the file is not text: it contains the character {found:?}; export the recording as CSV");
        }
        if let Some(line) = text.lines().take(SAMPLE).position(|line| line.len() > LONGEST_LINE) {
            bail!("line {} has more than {LONGEST_LINE} bytes: this is not a CSV file", line + 1);
        }
        let (mut rest, mut line, mut comment, mut told) = (text, 1, None, None);
        loop {
            let end = rest.find('\n').map_or(rest.len(), |end| end + 1);
            let first = rest[..end].trim();
            // The `sep=` line with which spreadsheets declare the separator.
            let separator = first.to_lowercase().strip_prefix("sep=").and_then(|of| of.bytes().next());
            match separator {
                Some(separator) => told = Some(separator),
                None if first.starts_with('#') => comment = Some(first.trim_start_matches('#').trim()),
                None if first.is_empty() && end > 0 => {}
                None => break,
            }
            (rest, line) = (&rest[end..], line + 1);
            if rest.is_empty() {
                bail!("the file has no rows: {}", rows_are.needed());
            }
        }
        if rest.trim().is_empty() {
            bail!("the file is empty: {}", rows_are.needed());
        }
        let separator = told.unwrap_or_else(|| separator(rest));
        let mut sample = Vec::new();
        for record in reader(rest, separator).records().take(SAMPLE) {
            sample.push(record?.iter().map(str::to_string).collect::<Vec<_>>());
        }
        let width = usual_width(&sample);
        let titles = sample.iter().position(|record| record.len() >= width).unwrap_or(0);
        let is_value = |cell: &String| number::is_value(cell) || clock::parse(cell, false).is_some();
        let first = &sample[titles];
        let (header, mut skip) = if first.iter().any(is_value) && !first.iter().any(|cell| is_name(cell)) {
            let comment: Vec<_> = comment.map(|line| fields(line, separator)).unwrap_or_default();
            if comment.len() != first.len() {
                let c = separator as char;
                let example = match rows_are {
                    RowsAre::Calls => format!("time{c}SP{c}PV{c}LMN"),
                    RowsAre::Loops => format!("loop{c}PUMP.SPEED"),
                };
                let text = format!("has values but no header line above it: add one, such as {example}");
                bail!(Fault { line: line + titles, column: None, text });
            }
            (comment, titles)
        } else {
            (first.clone(), titles + 1)
        };
        if header.len() > MOST_COLUMNS {
            bail!("the file has {} columns; at most {MOST_COLUMNS} are read: remove columns", header.len());
        }
        let mut header: Vec<Header> =
            header.iter().enumerate().map(|(number, cell)| Header::new(cell, number)).collect();
        // A second header line that contains only units.
        if skip == titles + 1
            && let Some(units) = sample.get(skip)
            && units.len() == header.len()
            && !units.iter().any(is_value)
            && units.iter().all(|unit| unit.len() <= 12)
            && units.iter().any(|unit| !unit.is_empty())
            && (rows_are == RowsAre::Calls || header.iter().zip(units).all(is_unit_of_loops))
            && sample.get(skip + 1).is_some_and(|record| record.iter().any(is_value))
        {
            for (header, unit) in header.iter_mut().zip(units) {
                let unit = unit.trim_matches(['[', ']', '(', ')']);
                header.unit = header.unit.take().or_else(|| (!unit.is_empty()).then(|| unit.to_string()));
            }
            skip += 1;
        }
        Ok(Layout { text: rest, line, separator, rows_are, header, skip })
    }

    /// Calls a function with the line number and the record of each non-empty row after the header.
    fn each(&self, mut row: impl FnMut(usize, &::csv::StringRecord) -> Result<()>) -> Result<()> {
        let mut reader = reader(self.text, self.separator);
        let mut record = ::csv::StringRecord::new();
        let mut number = 0;
        let (mut counted, mut line) = (0, 0);
        while reader.read_record(&mut record)? {
            // The reported position may be before the record: the reader has not consumed the LF of a preceding CR LF,
            // or empty lines.
            let rest = record.position().map_or(counted, |position| position.byte() as usize);
            let begin = rest + self.text[rest..].find(|c| !matches!(c, '\r' | '\n')).unwrap_or_default();
            line += self.text[counted..begin].matches('\n').count();
            counted = begin;
            number += 1;
            if number > self.skip && !record.iter().all(str::is_empty) {
                row(self.line + line, &record)?;
            }
        }
        Ok(())
    }

    fn read(self) -> Result<CsvTable> {
        let style = self.style()?;
        let width = self.header.len();
        let mut columns: Vec<Cells> = (0..width).map(|_| Cells::default()).collect();
        let mut lines: Vec<usize> = Vec::new();
        let mut short: Option<(usize, usize)> = None;
        let incomplete = |line: usize, found: usize| Fault {
            line,
            column: None,
            text: format!("has {found} values, but the header has {width} columns: complete the row, or remove it"),
        };
        self.each(|line, record| {
            if let Some((line, found)) = short {
                bail!(incomplete(line, found));
            }
            if let Some(extra) = record.iter().skip(width).position(|cell| !cell.is_empty()) {
                let text = format!(
                    "has {} values, but the header has {width} columns (the first without a name: {:?}); if the \
                     decimal sign is a comma, the separator must be a semicolon or a tab",
                    record.len(),
                    &record[width + extra]
                );
                bail!(Fault { line, column: None, text });
            }
            if record.len() < width {
                short = Some((line, record.len()));
                return Ok(());
            }
            if (lines.len() + 1).saturating_mul(width) > MOST_VALUES {
                bail!(
                    "the file has more than {MOST_VALUES} values ({width} columns, line {line}): remove columns, or \
                     keep every tenth row"
                );
            }
            lines.push(line);
            for (cells, cell) in columns.iter_mut().zip(record) {
                cells.push(cell, line, &style);
            }
            Ok(())
        })?;
        let mut table = CsvTable { columns: Vec::new(), lines, remarks: Vec::new() };
        if let Some((line, found)) = short {
            // The last row of a recording may be incomplete because the recorder was switched off, but that of a list
            // of loops may not.
            if self.rows_are == RowsAre::Loops {
                bail!(incomplete(line, found));
            }
            table.remarks.push(format!(
                "Line {line}, the last one, has {found} values instead of {width}: it was cut off and is ignored."
            ));
        }
        if table.lines.is_empty() {
            bail!("the file has a header but no data rows: add a row for each {}", self.rows_are.noun());
        }
        if self.rows_are == RowsAre::Calls {
            clock::join(&mut columns);
        }
        // The remark that a column of loop names contains text and is ignored is discarded: such a column is used.
        let mut names = Vec::new();
        for (number, (header, cells)) in self.header.into_iter().zip(columns).enumerate() {
            let is_variable = self.rows_are == RowsAre::Loops && is_variable(&header.name);
            let CsvTable { lines, remarks, .. } = &mut table;
            let column = if is_variable {
                Some(cells.of_variable(number, header, lines)?)
            } else {
                let has_names = self.rows_are == RowsAre::Loops && header.has_loop_names();
                cells.column(number, header, if has_names { &mut names } else { remarks })?
            };
            table.columns.extend(column);
        }
        if table.columns.is_empty() {
            bail!("the file has no column with numbers: export the values as numbers");
        }
        Ok(table)
    }

    /// Detects how numbers and dates are written in this file.
    fn style(&self) -> Result<Style> {
        let mut found = number::Found::default();
        self.each(|line, record| {
            for (column, cell) in record.iter().enumerate() {
                found.look_at(cell, (line, column));
            }
            Ok(())
        })?;
        let name = |column: usize| self.header.get(column).map_or("?", |header| header.name.as_str());
        found.style(self.separator == b',', name)
    }
}

impl Header {
    fn has_loop_names(&self) -> bool {
        LOOP_NAMES.contains(&self.name.trim().to_lowercase().as_str())
    }

    /// Parses the header of a column; `number` is the column's index, counted from 0.
    fn new(cell: &str, number: usize) -> Header {
        let cell = cell.trim();
        let header = |name: &str, unit: Option<&str>| Header {
            written: cell.into(),
            name: name.trim().into(),
            unit: unit.map(|unit| unit.trim().to_string()).filter(|unit| !unit.is_empty()),
        };
        if cell.is_empty() {
            let name = format!("column {}", number + 1);
            return Header { written: name.clone(), name, unit: None };
        }
        for (open, close) in [('[', ']'), ('(', ')')] {
            if let Some((name, unit)) = cell.strip_suffix(close).and_then(|cell| cell.rsplit_once(open))
                && !name.trim().is_empty()
                // An array index in brackets is not a unit.
                && !(open == '[' && unit.parse::<u32>().is_ok())
            {
                return header(name, Some(unit));
            }
        }
        match cell.split_once(" / ") {
            Some((name, unit)) if !name.trim().is_empty() && !unit.trim().is_empty() => header(name, Some(unit)),
            _ => header(cell, None),
        }
    }
}

/// The contents of a column, up to the row read last.
#[derive(Default)]
pub struct Cells {
    values: Vec<f64>,
    /// The dates and times of day: one per value, or empty.
    stamps: Vec<clock::Stamp>,
    /// The number of cells of each kind. `numbers` includes `words` (for true and false) and `literals` (of type TIME);
    /// `dates` includes times of day; `texts` counts all other cells that are not missing values.
    numbers: usize,
    words: usize,
    literals: usize,
    dates: usize,
    texts: usize,
    /// The line and text of the first cell that is neither a number nor a date.
    text: Option<(usize, String)>,
    decimals: i32,
    digits: i32,
    /// Whether the cells have been merged into another column.
    is_merged: bool,
}

impl Cells {
    fn push(&mut self, cell: &str, line: usize, style: &Style) {
        let mut value = f64::NAN;
        let mut stamp = clock::Stamp::default();
        if number::is_missing(cell) {
        } else if let Some(number) = style.number(cell) {
            value = number.value;
            self.numbers += 1;
            self.decimals = self.decimals.max(number.decimals);
            self.digits = self.digits.max(number.digits);
        } else if let Some(word) = number::boolean(cell) {
            value = f64::from(u8::from(word));
            self.numbers += 1;
            self.words += 1;
        } else if let Some(seconds) = number::literal(cell) {
            value = seconds;
            self.numbers += 1;
            self.literals += 1;
            self.decimals = 3;
        } else if let Some(found) = clock::parse(cell, style.is_month_first) {
            stamp = found;
            self.dates += 1;
        } else {
            self.texts += 1;
            self.text.get_or_insert_with(|| (line, cell.chars().take(40).collect()));
        }
        if self.dates > 0 {
            self.stamps.resize(self.values.len(), clock::Stamp::default());
            self.stamps.push(stamp);
        }
        self.values.push(value);
    }

    /// Converts the cells into the column of a variable, which must have a number in each of the `lines`.
    fn of_variable(self, number: usize, header: Header, lines: &[usize]) -> Result<Column> {
        let wrong = |line: usize, text: String| Fault { line, column: Some((number + 1, header.name.clone())), text };
        if let Some((line, text)) = &self.text {
            bail!(wrong(
                *line,
                format!("{text:?} is not a number, TRUE or FALSE: write a number without a unit, or remove the row")
            ));
        }
        if let Some(row) = self.stamps.iter().position(|stamp| *stamp != clock::Stamp::default()) {
            let text = "a date or a time of day is not a number: write a number, or remove the row".to_string();
            bail!(wrong(lines[row], text));
        }
        if let Some(row) = self.values.iter().position(|value| !value.is_finite()) {
            bail!(wrong(lines[row], "missing number: complete the row, or remove it".to_string()));
        }
        let column = self.column(number, header, &mut Vec::new())?;
        column.context("a column of numbers has them")
    }

    /// Converts the cells into a column; `None` if they are to be left out: texts, dates merged into another column, or
    /// empty cells under a header without a unit.
    fn column(mut self, number: usize, header: Header, remarks: &mut Vec<String>) -> Result<Option<Column>> {
        let name = header.name;
        if self.is_merged || (header.unit.is_none() && self.numbers + self.dates + self.texts == 0) {
            return Ok(None);
        }
        if self.texts > self.numbers + self.dates {
            remarks.push(format!("Column {name} contains text and is ignored."));
            return Ok(None);
        }
        if let Some((line, text)) = self.text {
            let text = format!("{text:?} is not a number, TRUE, FALSE or a date; correct it, or leave the cell empty");
            bail!(Fault { line, column: Some((number + 1, name)), text });
        }
        let is_clock = self.dates > 0;
        if is_clock && self.numbers > 0 {
            bail!(
                "column {} ({name}) has dates in some rows and numbers in others: use only dates or only numbers",
                number + 1
            );
        }
        if is_clock {
            self.values = clock::seconds(&self.stamps);
        }
        Ok(Some(Column {
            name,
            header: header.written,
            number: number + 1,
            unit: header.unit.or_else(|| (self.literals > 0).then(|| "s".to_string())),
            values: self.values,
            is_clock,
            is_boolean: self.words > 0,
            decimals: self.decimals,
            digits: self.digits,
        }))
    }
}

impl RowsAre {
    fn noun(self) -> &'static str {
        match self {
            RowsAre::Calls => "call",
            RowsAre::Loops => "loop",
        }
    }

    fn needed(self) -> String {
        format!("a header with column names and a row for each {} are required", self.noun())
    }
}

/// Whether a column is named like a variable, `FMU.VARIABLE`; the name "Descr. 1" is not.
fn is_variable(name: &str) -> bool {
    name.split_once('.').is_some_and(|(fmu, own)| !fmu.is_empty() && !own.is_empty())
        && !name.contains(char::is_whitespace)
}

/// Whether a cell below a header may belong to a row of units in a table of loops; a row with a loop's name or with
/// anything that begins with a digit is a loop.
fn is_unit_of_loops((header, cell): (&Header, &String)) -> bool {
    if is_variable(&header.name) { !cell.starts_with(|letter: char| letter.is_ascii_digit()) } else { cell.is_empty() }
}

/// Whether a header cell is a name: it contains a letter and is neither a number, a word for true or false, nor a date.
fn is_name(cell: &str) -> bool {
    cell.chars().any(char::is_alphabetic) && !number::is_value(cell) && clock::parse(cell, false).is_none()
}

/// Detects the separator: the one that splits most of the first lines into the same number of fields, at least two.
fn separator(text: &str) -> u8 {
    let rated = [b';', b'\t', b',', b'|'].map(|separator| {
        let widths: Vec<usize> =
            reader(text, separator).records().take(SAMPLE).filter_map(Result::ok).map(|record| record.len()).collect();
        let usual = usual(&widths);
        let equal = widths.iter().filter(|width| **width == usual).count();
        let share = if usual > 1 { 100 * equal / widths.len().max(1) } else { 0 };
        (share, separator)
    });
    // Take the first of several nearly equal candidates, since splitting at a decimal comma may also yield equal
    // numbers of fields.
    let best = rated.iter().map(|(share, _)| *share).max().unwrap_or(0);
    rated.iter().find(|(share, _)| *share > 0 && *share + 10 >= best).map_or(b',', |(_, separator)| *separator)
}

/// Returns the most frequent width, the larger one if two are equally frequent; 0 if there are none.
fn usual(widths: &[usize]) -> usize {
    let count = |width: usize| widths.iter().filter(|other| **other == width).count();
    widths.iter().copied().max_by_key(|width| (count(*width), *width)).unwrap_or(0)
}

fn usual_width(sample: &[Vec<String>]) -> usize {
    let widths: Vec<usize> = sample.iter().map(Vec::len).collect();
    // The header may have fewer or more fields than the rows, which is reported later.
    if widths.len() <= 2 { widths.first().copied().unwrap_or(0) } else { usual(&widths) }
}

fn fields(line: &str, separator: u8) -> Vec<String> {
    let record = reader(line, separator).records().next();
    record.and_then(Result::ok).map(|record| record.iter().map(str::to_string).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests;
