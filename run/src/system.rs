//! The system to run: named FMUs, settings, connections, recorded variables. Plain data with names as written by the
//! user; [`Plan`](crate::plan::Plan) checks them.

use anyhow::{Context, Result, anyhow, bail};
use manifest::Manifest;
use parameters::{Loop, Origin};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// FMUs that run together. Variables are named `FMU.VARIABLE`, such as `PID.OUT`.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct System {
    /// The FMUs, in stepping order.
    pub members: Vec<Member>,
    /// The settings, at the start or later.
    pub settings: Vec<Setting>,
    /// The connections from outputs to inputs.
    pub connections: Vec<Connection>,
    /// The variables to record; if empty, all outputs, and the inputs that are connected or set.
    pub record: Vec<Recorded>,
    /// The start in seconds; by default, the earliest one proposed by an FMU, or else 0.
    pub start: Option<f64>,
    /// The end in seconds; by default, the latest one proposed by an FMU.
    pub stop: Option<f64>,
    /// The communication step in seconds; by default, the smallest one proposed by an FMU.
    pub step: Option<f64>,
    /// The order in which values are exchanged.
    pub exchange: Exchange,
    /// Whether FMUs with Event Mode are stepped without using it.
    #[serde(default)]
    pub no_events: bool,
    /// Remarks for the user about the files that the system was read from.
    pub remarks: Vec<String>,
    /// The files that the system was read from, except FMUs.
    #[serde(skip)]
    pub sources: Vec<PathBuf>,
    /// The members that are PLC programs, to be packed as FMUs before the run.
    #[serde(skip)]
    pub programs: BTreeMap<String, Manifest>,
}

impl System {
    /// All files that must not be overwritten: those that the system was read from, FMUs and program sources.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        let of_programs = self.programs.values().flat_map(|program| &program.sources);
        let members = self.members.iter().map(|member| &member.path);
        self.sources.iter().chain(members).chain(of_programs).map(PathBuf::as_path)
    }
}

/// An FMU in a system.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct Member {
    /// Its unique name, which prefixes its variables.
    pub name: String,
    /// The path of its .fmu file.
    pub path: PathBuf,
}

/// A value for a variable.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Setting {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// The value.
    pub value: Value,
    /// The time in seconds; the value takes effect at the next communication point. `None` for the initialization.
    pub time: Option<f64>,
    /// Whether it is from a parameter file, so that a connection or another setting of the variable takes precedence.
    pub is_preliminary: bool,
    /// Its location, if it is in a file.
    pub place: Option<FilePosition>,
}

/// A recorded variable.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct Recorded {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// Its location, if it is in a file.
    pub place: Option<FilePosition>,
}

/// A value as written by the user.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(type = "boolean | number | \"NaN\" | \"inf\" | \"-inf\""))]
pub enum Value {
    /// `true` or `false`
    Boolean(bool),
    /// A whole number with more digits than a floating-point number can hold.
    Whole(i128),
    /// Any other number.
    Number(f64),
}

/// A connection from an output to an input.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct Connection {
    /// The output, `FMU.VARIABLE`.
    pub from: String,
    /// The input, `FMU.VARIABLE`.
    pub to: String,
    /// Its location, if it is in a file.
    pub place: Option<FilePosition>,
}

/// A location in a file, displayed as `FILE:LINE:COLUMN`.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct FilePosition {
    /// The file as specified by the user.
    pub file: String,
    /// The 1-based line number.
    pub line: usize,
    /// The 1-based column, in characters.
    pub column: usize,
}

/// The variable's name within the member, if `variable` (`FMU.VARIABLE`) belongs to that member.
pub fn own_name<'a>(variable: &'a str, member: &str) -> Option<&'a str> {
    variable.strip_prefix(member)?.strip_prefix('.')
}

impl fmt::Display for FilePosition {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// When values are passed from outputs to inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Exchange {
    /// Before each FMU's step: it receives the values that earlier FMUs computed in this step, and those that later
    /// FMUs computed in the previous step (Gauss-Seidel).
    #[default]
    Sequential,
    /// For all FMUs at the same time, before any of them steps (Jacobi).
    Parallel,
}

impl FromStr for Setting {
    type Err = anyhow::Error;

    /// Parses `FMU.VARIABLE=VALUE` or `FMU.VARIABLE=VALUE@SECONDS`.
    fn from_str(text: &str) -> Result<Setting> {
        let form = || format!("{text:?}: write FMU.VARIABLE=VALUE or FMU.VARIABLE=VALUE@SECONDS");
        let (variable, value) = text.split_once('=').with_context(form)?;
        let (value, time) = match value.split_once('@') {
            None => (value, None),
            Some((value, time)) => (value, Some(number(time).with_context(form)?)),
        };
        if variable.is_empty() {
            return Err(anyhow!("the variable name is missing").context(form()));
        }
        let value = value.parse().with_context(form)?;
        Ok(Setting { variable: variable.into(), value, time, is_preliminary: false, place: None })
    }
}

impl Setting {
    /// The values of a PLC loop as settings of the FMU named `member`. A value without a location is assigned `place`.
    pub fn of_loop(one: &Loop, member: &str, place: Option<&FilePosition>) -> Vec<Setting> {
        let setting = |setting: &parameters::MemberValue| {
            let place = match &setting.origin {
                Origin::Text { file, line, column, .. } => {
                    Some(FilePosition { file: file.clone(), line: *line, column: *column })
                }
                _ => place.cloned(),
            };
            Setting {
                variable: format!("{member}.{}", one.block.members[setting.member].name),
                value: match setting.value {
                    blocks::Value::Bool(value) => Value::Boolean(value),
                    value => Value::Number(blocks::table::number::number(value)),
                },
                time: None,
                is_preliminary: true,
                place,
            }
        };
        one.settings.iter().map(setting).collect()
    }
}

impl FromStr for Value {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Value> {
        match text {
            _ if text.eq_ignore_ascii_case("true") => Ok(Value::Boolean(true)),
            _ if text.eq_ignore_ascii_case("false") => Ok(Value::Boolean(false)),
            _ => match whole(text) {
                Some(whole) => Ok(Value::Whole(whole)),
                None => number(text).map(Value::Number),
            },
        }
    }
}

impl Serialize for Value {
    /// Serializes `true` or `2.5`; a number that is not finite becomes `"NaN"`, `"inf"` or `"-inf"`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Value::Boolean(value) => serializer.serialize_bool(*value),
            // JSON readers use doubles, which cannot represent this number.
            Value::Whole(value) => serializer.collect_str(value),
            Value::Number(value) if value.is_finite() => serializer.serialize_f64(*value),
            Value::Number(value) => serializer.collect_str(value),
        }
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Value, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Given {
            Boolean(bool),
            Number(f64),
            Text(String),
        }
        match Given::deserialize(deserializer)? {
            Given::Boolean(value) => Ok(Value::Boolean(value)),
            Given::Number(value) => Ok(Value::Number(value)),
            Given::Text(text) => match text.as_str() {
                "NaN" | "inf" | "-inf" => Ok(Value::Number(text.parse().map_err(de::Error::custom)?)),
                text => whole(text)
                    .map(Value::Whole)
                    .ok_or_else(|| de::Error::custom(format!("{text:?} is not true, false or a number"))),
            },
        }
    }
}

impl FromStr for Connection {
    type Err = anyhow::Error;

    /// Parses `FMU.OUTPUT=FMU.INPUT`.
    fn from_str(text: &str) -> Result<Connection> {
        match text.split_once('=') {
            Some((from, to)) if !from.is_empty() && !to.is_empty() => {
                Ok(Connection { from: from.into(), to: to.into(), place: None })
            }
            _ => bail!("{text:?}: write FMU.OUTPUT=FMU.INPUT"),
        }
    }
}

impl From<&str> for Recorded {
    fn from(variable: &str) -> Recorded {
        Recorded { variable: variable.into(), place: None }
    }
}

/// Parses an integer of at most 64 bits whose magnitude exceeds [`EXACT`], so that a double may not hold it exactly.
pub(crate) fn whole(text: &str) -> Option<i128> {
    let whole = text.trim().parse::<i128>().ok()?;
    let is_long = (i64::MIN.into()..=u64::MAX.into()).contains(&whole) && whole.abs() > EXACT;
    is_long.then_some(whole)
}

/// The magnitude up to which a double holds every integer.
pub(crate) const EXACT: i128 = 1 << 53;

/// Parses a finite number.
fn number(text: &str) -> Result<f64> {
    match text.trim().parse::<f64>() {
        Ok(number) if text.trim().parse::<i128>().is_ok_and(|whole| number as i128 != whole) => {
            bail!("{text:?} has more digits than a setting can hold; the nearest value is {number}")
        }
        Ok(number) if number.is_finite() => Ok(number),
        _ => bail!("{text:?} is not a finite number (the decimal separator is a point)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error<T: FromStr<Err = anyhow::Error> + std::fmt::Debug>(text: &str) -> String {
        format!("{:#}", text.parse::<T>().unwrap_err())
    }

    #[test]
    fn a_number_that_no_type_holds_exactly_is_refused() {
        for text in ["S.SP=18446744073709551617", "S.SP=1@9007199254740993"] {
            assert!(error::<Setting>(text).contains("has more digits than a setting can hold"), "{text}");
        }
        assert_eq!("18446744073709551615".parse::<Value>().unwrap(), Value::Whole(u64::MAX.into()));
    }

    #[test]
    fn a_setting_has_a_value_and_may_have_a_time() {
        let setting = |text: &str| text.parse::<Setting>().unwrap();
        let expected =
            |value, time| Setting { variable: "A.B.C".into(), value, time, is_preliminary: false, place: None };
        assert_eq!(setting("A.B.C=-2.5e1"), expected(Value::Number(-25.0), None));
        assert_eq!(setting("A.B.C=60@120.5"), expected(Value::Number(60.0), Some(120.5)));
        assert_eq!(setting("A.B.C=TRUE@0"), expected(Value::Boolean(true), Some(0.0)));
        assert_eq!(setting("A.B.C=false"), expected(Value::Boolean(false), None));
    }

    #[test]
    fn a_wrong_setting_says_what_is_wrong_and_how_it_is_written() {
        assert_eq!(
            error::<Setting>("A.B=2,5"),
            "\"A.B=2,5\": write FMU.VARIABLE=VALUE or FMU.VARIABLE=VALUE@SECONDS: \"2,5\" is not a finite number (the \
             decimal separator is a point)"
        );
        for text in ["A.B", "=1", "A.B=", "A.B=1@", "A.B=inf", "A.B=1@x", "A.B=on"] {
            assert!(error::<Setting>(text).contains("write FMU.VARIABLE=VALUE"), "{text}");
        }
    }

    #[test]
    fn a_connection_goes_from_an_output_to_an_input() {
        let connection: Connection = "A.LMN=B.POWER".parse().unwrap();
        assert_eq!((connection.from.as_str(), connection.to.as_str()), ("A.LMN", "B.POWER"));
        assert_eq!(error::<Connection>("A.LMN"), "\"A.LMN\": write FMU.OUTPUT=FMU.INPUT");
    }
}
