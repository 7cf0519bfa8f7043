//! Start values as text, which replace those in the block's table for an instance.
//!
//! ```text
//! preset = TIC101
//! block = PUMP
//! library = {4a2b45f4-41f7-76f6-d106-523464f0c161}
//! FLOW = 1.5
//! ON = false
//! CYCLE = 0.1
//! ```
//!
//! Each setting has a line, in any order, and each value has only one valid form: a REAL with all digits that
//! distinguish it from the neighbouring 64-bit numbers, a TIME in seconds. A hash of the text reveals changes.

use super::number::{number, to_value};
use super::{Kind, Table, TableText, Value, fingerprint};
use std::fmt;

/// The name of the file that contains the text.
pub const FILE: &str = "start.txt";

/// The maximum size of this file in bytes.
pub const LARGEST: u64 = 1 << 20;

const PRESET: &str = "preset";
const BLOCK: &str = "block";
const LIBRARY: &str = "library";

/// The maximum number of characters of a string shown in a message.
const SHOWN: usize = 60;

/// The start values of a preset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Start {
    /// The name of the preset.
    pub preset: String,
    /// The name of the block.
    pub block: String,
    /// The identifier of the FMU from which the preset was created.
    pub library: String,
    /// The name and value of each setting.
    pub values: Vec<(String, String)>,
}

impl Start {
    /// Parses a text without checking whether the block has these settings, see [`Start::settings`].
    ///
    /// # Errors
    /// A line is malformed or missing; the message states the expected form.
    pub fn parse(text: &str) -> Result<Start, String> {
        let mut lines = text.lines().zip(1..);
        let mut header = |key: &str| match lines.next() {
            Some((line, number)) => match line.split_once(" = ") {
                Some((found, value)) if found == key && !value.is_empty() => Ok(value.to_string()),
                _ => Err(format!("line {number} is {:?} instead of \"{key} = ...\"", shown(line))),
            },
            None => Err(format!("the line \"{key} = ...\" is missing")),
        };
        let (preset, block, library) = (header(PRESET)?, header(BLOCK)?, header(LIBRARY)?);
        let value = |(line, number): (&str, usize)| match line.split_once(" = ") {
            Some((name, value)) => Ok((name.to_string(), value.to_string())),
            None => Err(format!("line {number} is {:?} instead of \"NAME = VALUE\"", shown(line))),
        };
        let values = lines.map(value).collect::<Result<_, _>>()?;
        Ok(Start { preset, block, library, values })
    }

    /// Returns the rows of the table's settings with their values.
    ///
    /// # Errors
    /// A setting is unknown, missing or duplicate; a value has the wrong type, is out of range, or is not in the form
    /// that [`text`] produces; the time between two calls is below 1 ms.
    pub fn settings<S: TableText>(&self, table: &Table<S>) -> Result<Vec<(usize, Value)>, String> {
        let mut settings: Vec<(usize, Value)> = Vec::with_capacity(self.values.len());
        for (name, text) in &self.values {
            let row = table.find(name).filter(|row| table.rows[*row].role.is_settable());
            let row = row.ok_or_else(|| format!("{} has no setting {:?}", table.name, shown(name)))?;
            if settings.iter().any(|(known, _)| *known == row) {
                return Err(format!("{name} occurs twice"));
            }
            let value = value(text, table.rows[row].kind).map_err(|why| format!("{name} = {}: {why}", shown(text)))?;
            if row == table.cycle && number(value) < 0.001 {
                return Err(format!("{name} = {text}: the time between two calls must be at least 0.001 s"));
            }
            settings.push((row, value));
        }
        let is_missing = |row: usize| !settings.iter().any(|(known, _)| *known == row);
        match (0..table.rows.len()).find(|row| table.rows[*row].role.is_settable() && is_missing(*row)) {
            Some(missing) => Err(format!("{} is missing", table.rows[missing].name)),
            None => Ok(settings),
        }
    }
}

impl fmt::Display for Start {
    /// Writes the text that [`Start::parse`] reads.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        for (key, value) in [(PRESET, &self.preset), (BLOCK, &self.block), (LIBRARY, &self.library)] {
            writeln!(formatter, "{key} = {value}")?;
        }
        self.values.iter().try_for_each(|(name, value)| writeln!(formatter, "{name} = {value}"))
    }
}

/// Returns the fingerprint of start values: a hash of their text, which includes the fingerprint of the library.
pub fn fingerprint(text: &[u8]) -> u128 {
    fingerprint::checksum(text)
}

/// Formats a value in the only form that [`Start::settings`] accepts.
pub fn text(value: Value) -> String {
    match value {
        Value::Real(_) | Value::LReal(_) | Value::Time(_) | Value::Whole(Kind::LTime, _) => {
            format!("{:?}", number(value))
        }
        Value::Whole(Kind::ULInt | Kind::LWord, bits) => (bits as u64).to_string(),
        Value::Whole(_, whole) => whole.to_string(),
        Value::Word(word) => word.value().to_string(),
        Value::Int(int) => int.to_string(),
        Value::Bool(bool) => bool.to_string(),
    }
}

/// Parses the text of a value of this type.
fn value(written: &str, kind: Kind) -> Result<Value, String> {
    let number = match (kind, written) {
        (Kind::Bool, "true") => 1.0,
        (Kind::Bool, "false") => 0.0,
        (Kind::Bool, _) => return Err("a BOOL must be true or false".into()),
        _ => written.parse().map_err(|_| "not a number")?,
    };
    let value = to_value(number, kind)?;
    match text(value) {
        form if form == written => Ok(value),
        form => Err(format!("this {} must be written as {form}", kind.name())),
    }
}

/// Truncates a string for a message.
fn shown(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Law, Time, Word};

    crate::block! {
        /// Pumps.
        pub struct Pump as "PUMP" {
            input { /// Flow
                    flow: Real = 0.1;
                    /// Measured
                    level: Word; }
            parameter { /// On
                        on: Bool = true;
                        /// Exact
                        gain: LReal = 1.0; }
            fixed { /// Stages
                    stages: Int = 2; }
            cycle { /// Time between two calls
                    cycle: Time = Time::ms(100); }
            output { /// Result
                     q: Real; }
        }
    }

    impl Law for Pump {
        fn restart(&mut self) {
            self.clear();
        }

        fn call(&mut self) {}
    }

    const TABLE: &crate::StaticTable = <Pump as crate::Block>::TABLE;
    const TEXT: &str = "preset = P1\nblock = PUMP\nlibrary = {1}\nFLOW = 0.10000000149011612\nLEVEL = -1\nON = false\n\
                        GAIN = 0.1\nSTAGES = -7\nCYCLE = 20.001\n";

    fn settings(text: &str) -> Result<Vec<(usize, Value)>, String> {
        Start::parse(text)?.settings(TABLE)
    }

    #[test]
    fn the_settings_are_those_of_the_text() {
        let expected = [
            Value::Real(0.1),
            Value::Word(Word::new(-1)),
            Value::Bool(false),
            Value::LReal(0.1),
            Value::Int(-7),
            Value::Time(Time::ms(20_001)),
        ];
        assert_eq!(settings(TEXT).unwrap(), expected.into_iter().enumerate().collect::<Vec<_>>());
        let start = Start::parse(TEXT).unwrap();
        assert_eq!((start.preset.as_str(), start.block.as_str(), start.library.as_str()), ("P1", "PUMP", "{1}"));
        assert_eq!(start.to_string(), TEXT);
    }

    #[test]
    fn what_is_not_a_start_text_is_refused_with_its_line() {
        for (text, error) in [
            ("", "the line \"preset = ...\" is missing"),
            ("hello\n", "line 1 is \"hello\" instead of \"preset = ...\""),
            ("preset = P1\npreset = P1\n", "line 2 is \"preset = P1\" instead of \"block = ...\""),
            (&TEXT.replace("ON = false", "ON: false"), "line 6 is \"ON: false\" instead of \"NAME = VALUE\""),
            (&TEXT.replace("ON = false", ""), "line 6 is \"\" instead of \"NAME = VALUE\""),
        ] {
            assert_eq!(settings(text).unwrap_err(), error, "{text}");
        }
        let long = settings(&"ä".repeat(100_000)).unwrap_err();
        assert_eq!(long, format!("line 1 is {:?} instead of \"preset = ...\"", "ä".repeat(60) + "…"));
    }

    #[test]
    fn settings_that_do_not_fit_the_block_are_refused() {
        for (from, to, error) in [
            ("ON = false", "OFF = false", "PUMP has no setting \"OFF\""),
            ("ON = false", "Q = 1.0", "PUMP has no setting \"Q\""),
            ("ON = false\n", "", "ON is missing"),
            ("ON = false", "FLOW = 0.5", "FLOW occurs twice"),
            ("ON = false", "ON = 0", "ON = 0: a BOOL must be true or false"),
            ("LEVEL = -1", "LEVEL = x", "LEVEL = x: not a number"),
            ("LEVEL = -1", "LEVEL = 65535", "LEVEL = 65535: this WORD must be written as -1"),
            ("LEVEL = -1", "LEVEL = 65536", "LEVEL = 65536: a WORD accepts -32768 ... 65535"),
            ("STAGES = -7", "STAGES = 0.5", "STAGES = 0.5: an INT accepts -32768 ... 32767"),
            (
                "FLOW = 0.10000000149011612",
                "FLOW = 0.1",
                "FLOW = 0.1: this REAL must be written as 0.10000000149011612",
            ),
            ("GAIN = 0.1", "GAIN = NaN", "GAIN = NaN: an LREAL accepts finite numbers"),
            ("CYCLE = 20.001", "CYCLE = 20.0014", "CYCLE = 20.0014: this TIME must be written as 20.001"),
            ("CYCLE = 20.001", "CYCLE = 0.0", "CYCLE = 0.0: the time between two calls must be at least 0.001 s"),
            ("CYCLE = 20.001", "CYCLE = -1.0", "CYCLE = -1.0: a TIME accepts 0 ... 2147483.647 s"),
        ] {
            assert!(TEXT.contains(from));
            assert_eq!(settings(&TEXT.replace(from, to)).unwrap_err(), error);
        }
    }

    #[test]
    fn every_value_reads_back_bit_by_bit() {
        for real in [f32::MAX, f32::MIN_POSITIVE, 1e-45, -0.0, 0.1, 16_777_217.0] {
            let written = text(Value::Real(real));
            let Ok(Value::Real(read)) = value(&written, Kind::Real) else { panic!("{written}") };
            assert_eq!(read.to_bits(), real.to_bits());
        }
        for milliseconds in [0, 1, 999, i32::MAX] {
            let time = Value::Time(Time::ms(milliseconds));
            assert_eq!(value(&text(time), Kind::Time), Ok(time));
        }
    }

    #[test]
    fn presets_with_the_same_values_differ_by_their_names() {
        let other = TEXT.replace("P1", "P2");
        assert_ne!(fingerprint(TEXT.as_bytes()), fingerprint(other.as_bytes()));
    }
}
