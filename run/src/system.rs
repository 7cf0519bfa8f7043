//! What to run: FMUs by name, what is set, what is connected, what is recorded. Plain data with the names as the user
//! writes them; [`Plan`](crate::plan::Plan) checks them.

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
    /// The FMUs, in the order in which they are stepped.
    pub members: Vec<Member>,
    /// Values that are set at the start or later.
    pub settings: Vec<Setting>,
    /// Which output goes to which input.
    pub connections: Vec<Connection>,
    /// The variables to record. If there are none: all outputs, and the inputs that are connected or set.
    pub record: Vec<Recorded>,
    /// The start in seconds; by default the earliest that an FMU proposes, else 0.
    pub start: Option<f64>,
    /// The end in seconds; by default the latest that an FMU proposes.
    pub stop: Option<f64>,
    /// The communication step in seconds; by default the smallest that an FMU proposes.
    pub step: Option<f64>,
    /// When values go from output to input.
    pub exchange: Exchange,
    /// FMUs with Event Mode are stepped as those without it.
    #[serde(default)]
    pub no_events: bool,
    /// What the user should know of the files that it was read from.
    pub remarks: Vec<String>,
    /// The files that it was read from, FMUs apart.
    #[serde(skip)]
    pub sources: Vec<PathBuf>,
    /// The members that are PLC programs; they are packed as FMUs before the run.
    #[serde(skip)]
    pub programs: BTreeMap<String, Manifest>,
}

impl System {
    /// The files that it was read from and those of its FMUs, onto which nothing should be written.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        let of_programs = self.programs.values().flat_map(|program| &program.sources);
        let members = self.members.iter().map(|member| &member.path);
        self.sources.iter().chain(members).chain(of_programs).map(PathBuf::as_path)
    }
}

/// An FMU in a system.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct Member {
    /// Its name, by which its variables are named. No two members have the same.
    pub name: String,
    /// The .fmu file.
    pub path: PathBuf,
}

/// A value for a variable.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Setting {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// The value.
    pub value: Value,
    /// When it is set, in seconds: at the first communication point that is not earlier. At the start, before the
    /// initialization, if there is no time.
    pub time: Option<f64>,
    /// The value of a parameter file: a connection to the variable and another setting of it take precedence.
    pub is_preliminary: bool,
    /// Where it is written, if it is in a file.
    pub place: Option<Place>,
}

/// A variable that is recorded.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct Recorded {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// Where it is written, if it is in a file.
    pub place: Option<Place>,
}

/// A value as the user writes it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(type = "boolean | number | \"NaN\" | \"inf\" | \"-inf\""))]
pub enum Value {
    /// `true` or `false`
    Boolean(bool),
    /// A whole number of more digits than a floating-point number has.
    Whole(i128),
    /// Anything else.
    Number(f64),
}

/// From an output to an input.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct Connection {
    /// The output, `FMU.VARIABLE`.
    pub from: String,
    /// The input, `FMU.VARIABLE`.
    pub to: String,
    /// Where it is written, if it is in a file.
    pub place: Option<Place>,
}

/// A place in a file, shown as `FILE:LINE:COLUMN`.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct Place {
    /// The file, as the user gave it.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
}

/// The name that a variable `FMU.VARIABLE` has in a member, if it is one of the member.
pub fn own_name<'a>(variable: &'a str, member: &str) -> Option<&'a str> {
    variable.strip_prefix(member)?.strip_prefix('.')
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// When values go from output to input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Exchange {
    /// Before each FMU's step: it gets what the FMUs before it computed in this step, and what those after it computed in
    /// the previous one (Gauss-Seidel).
    #[default]
    Sequential,
    /// For all FMUs at once, before any of them steps (Jacobi).
    Parallel,
}

impl FromStr for Setting {
    type Err = anyhow::Error;

    /// `FMU.VARIABLE=VALUE`, or `FMU.VARIABLE=VALUE@SECONDS`.
    fn from_str(text: &str) -> Result<Setting> {
        let form = || format!("{text:?}: write FMU.VARIABLE=VALUE or FMU.VARIABLE=VALUE@SECONDS");
        let (variable, value) = text.split_once('=').with_context(form)?;
        let (value, time) = match value.split_once('@') {
            None => (value, None),
            Some((value, time)) => (value, Some(number(time).with_context(form)?)),
        };
        if variable.is_empty() {
            return Err(anyhow!("no variable is named").context(form()));
        }
        let value = value.parse().with_context(form)?;
        Ok(Setting { variable: variable.into(), value, time, is_preliminary: false, place: None })
    }
}

impl Setting {
    /// The values of a loop of a PLC for an FMU that is called `member`. A value without a line of its own is said to be at
    /// `place`.
    pub fn of_loop(one: &Loop, member: &str, place: Option<&Place>) -> Vec<Setting> {
        let setting = |setting: &parameters::Setting| {
            let place = match &setting.origin {
                Origin::Text { file, line, column, .. } => {
                    Some(Place { file: file.clone(), line: *line, column: *column })
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
    /// `true`, `2.5`; a number that is not finite as `"NaN"`, `"inf"` or `"-inf"`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Value::Boolean(value) => serializer.serialize_bool(*value),
            // JSON's readers have doubles, which cannot hold this number.
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
                    .ok_or_else(|| de::Error::custom(format!("{text:?} is neither true nor false nor a number"))),
            },
        }
    }
}

impl FromStr for Connection {
    type Err = anyhow::Error;

    /// `FMU.OUTPUT=FMU.INPUT`
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

/// A whole number of at most 64 bits, more than a double holds exactly.
pub(crate) fn whole(text: &str) -> Option<i128> {
    let whole = text.trim().parse::<i128>().ok()?;
    let is_long = (i64::MIN.into()..=u64::MAX.into()).contains(&whole) && whole.abs() > EXACT;
    is_long.then_some(whole)
}

/// Up to this number, a floating-point number may be any whole number.
pub(crate) const EXACT: i128 = 1 << 53;

/// A finite number.
fn number(text: &str) -> Result<f64> {
    match text.trim().parse::<f64>() {
        Ok(number) if text.trim().parse::<i128>().is_ok_and(|whole| number as i128 != whole) => {
            bail!("{text:?} has more digits than a setting holds; the nearest one is {number}")
        }
        Ok(number) if number.is_finite() => Ok(number),
        _ => bail!("{text:?} is not a finite number (the decimal sign is a point)"),
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
            assert!(error::<Setting>(text).contains("has more digits than a setting holds"), "{text}");
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
             decimal sign is a point)"
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
