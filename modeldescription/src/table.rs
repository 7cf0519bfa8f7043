//! A block's table, as its library returns it in JSON. Nothing here depends on the version of FMI.

use crate::error::{Error, shortened};
use blocks::table::number::{beyond_number, number};
use blocks::{Kind, Role, StaticRow, StaticTable, TableText};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};

/// A block's table.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// The block's name, which is also that of the model, the library and the FMU.
    pub name: String,
    /// Other names by which a PLC project may call the block.
    #[serde(default)]
    pub aliases: Vec<String>,
    /// The block's documentation (Markdown); the first paragraph is a summary.
    pub docs: String,
    /// The index of the row with the time between two calls.
    pub cycle: usize,
    /// The index of the row with the mean of the block's pulse over a communication step, if it has one.
    pub mean: Option<usize>,
    /// The variables; the index of a row is the value reference.
    pub variables: Vec<Row>,
    /// The texts of a program, with value references that continue those of the variables.
    #[serde(default)]
    pub texts: Vec<Text>,
    /// The responses in the documentation, at least one; the reference results record the first.
    pub responses: Vec<Response>,
    /// The characteristics in the documentation.
    #[serde(default)]
    pub characteristics: Vec<Characteristic>,
    /// The unit of signals without a unit in the drawings of responses and characteristics.
    #[serde(default)]
    pub drawn_unit: Option<String>,
}

/// A variable. Numbers are as in the C interface: a TIME in seconds, FALSE and TRUE as 0 and 1.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Its name, qualified by the instances that lead to it: `GAIN`, `DI_CONT_C.GAIN`.
    pub name: String,
    /// A short description, on one line.
    pub description: String,
    /// Instructions for its use (Markdown); may be empty.
    #[serde(default)]
    pub help: String,
    /// Its PLC type.
    #[serde(deserialize_with = "kind")]
    pub kind: Kind,
    /// Whether a WORD is an analog value, which is signed.
    #[serde(default)]
    pub analog: bool,
    /// Its role: who sets it, and when.
    #[serde(deserialize_with = "role")]
    pub role: Role,
    /// Its start value.
    pub start: f64,
    /// The exact start value of an integer with too many digits for `start`; for a duration, in milliseconds or
    /// nanoseconds.
    #[serde(default)]
    pub exact: Option<i128>,
    /// The lowest plausible value.
    pub min: Option<f64>,
    /// The highest plausible value.
    pub max: Option<f64>,
    /// Its physical unit.
    pub unit: Option<String>,
    /// The names of the settings that determine its value after a restart.
    #[serde(default)]
    pub from: Vec<String>,
}

impl Row {
    /// The unit in which people and hosts read its values: seconds for a duration, otherwise its own.
    pub fn shown_unit(&self) -> Option<&str> {
        self.kind.shown_unit(self.unit.as_deref())
    }
}

/// A text of a program.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Text {
    /// Its qualified name.
    pub name: String,
    /// A short description, on one line.
    pub description: String,
    /// Its PLC type with its length: `STRING[20]`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Its role: who sets it, and when.
    #[serde(deserialize_with = "role")]
    pub role: Role,
    /// Its start value.
    pub start: String,
}

/// A short run that shows the behaviour of the block.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Response {
    /// The title, in one sentence.
    pub title: String,
    /// The number of calls.
    pub calls: u32,
    /// The settings: the number of the call before which a variable is set (0 for before the restart), the variable,
    /// and its value.
    pub set: Vec<(u32, String, f64)>,
    /// The variables to draw and record; if empty, all inputs and outputs.
    pub show: Vec<String>,
}

/// A characteristic: for each of `points` values of a variable, a new instance makes `calls` calls, and the mean of
/// each shown variable over these calls is drawn.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Characteristic {
    /// The title, in one sentence.
    pub title: String,
    /// The variable of the horizontal axis.
    pub variable: String,
    /// The lowest and highest value of the variable.
    pub range: (f64, f64),
    /// The number of its values, including both ends.
    pub points: u32,
    /// The number of calls for each value.
    pub calls: u32,
    /// The settings before the restart.
    pub set: Vec<(String, f64)>,
    /// The variables to draw.
    pub show: Vec<String>,
}

impl<S: TableText> From<&StaticTable<S>> for Table {
    /// Converts the table of a linked block.
    fn from(of: &StaticTable<S>) -> Table {
        let texts = |texts: &[S]| texts.iter().map(ToString::to_string).collect();
        let row = |row: &StaticRow<S>| Row {
            name: row.name.to_string(),
            description: row.description.to_string(),
            help: row.help.to_string(),
            kind: row.kind,
            analog: row.is_analog,
            role: row.role,
            start: number(row.start),
            exact: beyond_number(row.start),
            min: row.least(),
            max: row.greatest(),
            unit: row.unit.as_ref().map(S::to_string),
            from: row.from.iter().map(|setting| of.rows[*setting].name.to_string()).collect(),
        };
        let text = |of: &blocks::Text<S>| Text {
            name: of.name.to_string(),
            description: of.description.to_string(),
            type_name: of.ty.name(),
            role: of.role,
            start: of.start.to_string(),
        };
        let response = |of: &blocks::Response<S>| Response {
            title: of.title.to_string(),
            calls: of.calls,
            set: of.set.iter().map(|(call, name, value)| (*call, name.to_string(), *value)).collect(),
            show: texts(&of.show),
        };
        let characteristic = |of: &blocks::Characteristic<S>| Characteristic {
            title: of.title.to_string(),
            variable: of.variable.to_string(),
            range: of.range,
            points: of.points,
            calls: of.calls,
            set: of.set.iter().map(|(name, value)| (name.to_string(), *value)).collect(),
            show: texts(&of.show),
        };
        Table {
            name: of.name.to_string(),
            aliases: texts(&of.aliases),
            docs: of.docs.to_string(),
            cycle: of.cycle,
            mean: of.mean,
            variables: of.rows.iter().map(row).collect(),
            texts: of.texts.iter().map(text).collect(),
            responses: of.responses.iter().map(response).collect(),
            characteristics: of.characteristics.iter().map(characteristic).collect(),
            drawn_unit: of.drawn_unit.as_ref().map(S::to_string),
        }
    }
}

impl Table {
    /// The index of the row with this full name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.variables.iter().position(|row| row.name == name)
    }

    /// The indices of the rows with these names.
    pub fn rows(&self, names: &[String]) -> Vec<usize> {
        names.iter().filter_map(|name| self.find(name)).collect()
    }

    /// The indices of the rows that a response draws.
    pub fn shown(&self, response: &Response) -> Vec<usize> {
        let is_terminal = |row: &usize| matches!(self.variables[*row].role, Role::Input | Role::Output);
        match response.show.as_slice() {
            [] => (0..self.variables.len()).filter(is_terminal).collect(),
            names => self.rows(names),
        }
    }

    fn is_setting(&self, name: &str) -> bool {
        self.find(name)
            .is_some_and(|row| matches!(self.variables[row].role, Role::Parameter | Role::Fixed | Role::Cycle))
    }

    /// A summary of the block in one sentence: the first paragraph of its documentation, on one line.
    pub fn summary(&self) -> String {
        let lines = self.docs.lines().map(str::trim).skip_while(|line| line.is_empty());
        lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
    }

    /// Rejects an inconsistent table.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let wrong = |what: String| Err(Error::new(format!("the library's table of {}: {what}", self.name)));
        match self.variables.get(self.cycle) {
            Some(Row { kind: Kind::Time, role: Role::Cycle, start, .. }) if *start >= 0.001 => {}
            Some(Row { kind: Kind::Time, role: Role::Cycle, name, start, .. }) => {
                return wrong(format!("{name} starts at {start:?} s: a block is called every millisecond at most"));
            }
            Some(Row { name, kind, role, .. }) => {
                let (kind, role) = (kind.name(), role.name());
                return wrong(format!(
                    "the cycle is row {name}, which is {kind} and {role}: it must be TIME and cycle"
                ));
            }
            None => {
                let rows = self.variables.len();
                return wrong(format!("the cycle is row {}, but there are only {rows} rows", self.cycle));
            }
        }
        if let Some(mean) = self.mean
            && self.variables.get(mean).is_none_or(|row| row.role != Role::Output)
        {
            return wrong(format!("the mean of the pulse is row {mean}, which is not an output"));
        }
        for row in &self.variables {
            if let Some(other) = row.from.iter().find(|name| !self.is_setting(name)) {
                return wrong(format!(
                    "{} has its restart value from {other:?}, which is not a parameter of the table",
                    row.name
                ));
            }
        }
        if self.responses.is_empty() {
            return wrong("it has no response: RESPONSES needs at least one, such as Response::AT_REST".into());
        }
        for response in &self.responses {
            let set = response.set.iter().map(|(_, name, _)| name);
            if let Some(unknown) = set.chain(&response.show).find(|name| self.find(name).is_none()) {
                return wrong(format!("its response names {unknown:?}: the table has no such variable"));
            }
        }
        for characteristic in &self.characteristics {
            let set = characteristic.set.iter().map(|(name, _)| name).chain([&characteristic.variable]);
            if let Some(unknown) = set.chain(&characteristic.show).find(|name| self.find(name).is_none()) {
                return wrong(format!("its characteristic names {unknown:?}: the table has no such variable"));
            }
            let (from, to) = characteristic.range;
            if !(from < to && characteristic.points >= 2 && characteristic.calls >= 1) {
                return wrong(format!(
                    "its characteristic over {} needs a range that rises, at least 2 points and 1 call",
                    characteristic.variable
                ));
            }
        }
        Ok(())
    }
}

fn kind<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Kind, D::Error> {
    let name = String::deserialize(deserializer)?;
    Kind::named(&name).ok_or_else(|| unknown("kind", &name, Kind::ALL.iter().map(|kind| kind.name())))
}

fn role<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Role, D::Error> {
    let name = String::deserialize(deserializer)?;
    Role::named(&name).ok_or_else(|| unknown("role", &name, Role::ALL.iter().map(|role| role.name())))
}

fn unknown<E: serde::de::Error>(what: &str, name: &str, known: impl Iterator<Item = &'static str>) -> E {
    let known = known.collect::<Vec<_>>().join(", ");
    E::custom(format!("unknown {what} `{}`, expected one of {known}", shortened(name)))
}

/// Parses a library's description of itself. An error gives the position at which the parser stopped, and the text
/// before it.
pub(crate) fn from_json<T: DeserializeOwned>(json: &str) -> Result<T, Error> {
    serde_json::from_str(json).map_err(|error| {
        let line = json.lines().nth(error.line().saturating_sub(1)).unwrap_or("");
        let end = line.floor_char_boundary(error.column());
        let begin = line.floor_char_boundary(end.saturating_sub(60));
        Error::new(format!(
            "the library's table cannot be read: {error}, after {:?}; build library and packer from the same sources, \
             and give every start, min and max a finite number",
            &line[begin..end]
        ))
    })
}
