//! A block's table, as its library tells it in JSON. Nothing here depends on a version of FMI.

use crate::error::{Error, shortened};
use blocks::table::number::{beyond_number, number};
use blocks::{Kind, Role};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};

/// A block's table.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// The block's name, which the model, the library and the FMU have too.
    pub name: String,
    /// The other names by which a PLC project may call the block.
    #[serde(default)]
    pub aliases: Vec<String>,
    /// The block's documentation (Markdown); its first paragraph says what the block does.
    pub docs: String,
    /// The row that holds the time between two calls.
    pub cycle: usize,
    /// The row that holds the mean of the block's pulse over a communication step, if it has one.
    pub mean: Option<usize>,
    /// All variables; the number of the row is the value reference.
    pub variables: Vec<Row>,
    /// The texts of a program. Their value references follow those of the variables.
    #[serde(default)]
    pub texts: Vec<Text>,
    /// The runs that the documentation shows; there is at least one, which the reference results record.
    pub responses: Vec<Response>,
    /// The characteristics that the documentation shows.
    #[serde(default)]
    pub characteristics: Vec<Characteristic>,
    /// The unit that signals without one of their own have in the drawings of both.
    #[serde(default)]
    pub drawn_unit: Option<String>,
}

/// One variable. Numbers are those of the C interface: a TIME in seconds, FALSE and TRUE as 0 and 1.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Its name with the instances that lead to it: `GAIN`, `DI_CONT_C.GAIN`.
    pub name: String,
    /// A short text, on one line.
    pub description: String,
    /// Instructions for its use (Markdown); may be empty.
    #[serde(default)]
    pub help: String,
    /// Its PLC type.
    #[serde(deserialize_with = "kind")]
    pub kind: Kind,
    /// Whether a WORD is an analog value, which has a sign.
    #[serde(default)]
    pub analog: bool,
    /// Who sets it, and when.
    #[serde(deserialize_with = "role")]
    pub role: Role,
    /// Its value in a new block.
    pub start: f64,
    /// The same, of an integer that has more digits than a number here; a duration in milliseconds or nanoseconds.
    #[serde(default)]
    pub exact: Option<i128>,
    /// The lowest value that makes sense.
    pub min: Option<f64>,
    /// The highest value that makes sense.
    pub max: Option<f64>,
    /// Its physical unit.
    pub unit: Option<String>,
    /// The names of the settings on which its value after a restart depends.
    #[serde(default)]
    pub from: Vec<String>,
}

impl Row {
    /// The unit in which people and hosts read its values: seconds of a duration, and its own else.
    pub fn shown_unit(&self) -> Option<&str> {
        self.kind.shown_unit(self.unit.as_deref())
    }
}

/// A text of a program.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Text {
    /// Its name with what leads to it.
    pub name: String,
    /// A short text, on one line.
    pub description: String,
    /// Its PLC type with its length: `STRING[20]`.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Who sets it, and when.
    #[serde(deserialize_with = "role")]
    pub role: Role,
    /// Its value in a new program.
    pub start: String,
}

/// A short run of the block that shows what it does.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Response {
    /// What the run shows, in one sentence.
    pub title: String,
    /// The number of calls.
    pub calls: u32,
    /// What is set: the number of the call before which (0 is before the restart), the variable, its value.
    pub set: Vec<(u32, String, f64)>,
    /// The variables that are drawn and recorded; if empty, all inputs and outputs.
    pub show: Vec<String>,
}

/// What the block does at each value of a variable: for each of `points` values a new instance makes `calls` calls, and the mean
/// of each shown variable over these calls is drawn.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Characteristic {
    /// What it shows, in one sentence.
    pub title: String,
    /// The variable of the horizontal axis.
    pub variable: String,
    /// Its lowest and its highest value.
    pub range: (f64, f64),
    /// How many values it takes, both ends included.
    pub points: u32,
    /// The calls for each value.
    pub calls: u32,
    /// What is set before the restart.
    pub set: Vec<(String, f64)>,
    /// The variables that are drawn.
    pub show: Vec<String>,
}

impl From<&blocks::Table> for Table {
    /// The table of a block that is linked in.
    fn from(of: &blocks::Table) -> Table {
        let texts = |texts: &[&str]| texts.iter().map(ToString::to_string).collect();
        let row = |row: &blocks::Row| Row {
            name: row.full_name(),
            description: row.description.into(),
            help: row.help.into(),
            kind: row.kind,
            analog: row.is_analog,
            role: row.role,
            start: number(row.start),
            exact: beyond_number(row.start),
            min: row.least(),
            max: row.greatest(),
            unit: row.unit.map(str::to_string),
            from: row.from.iter().map(|setting| of.rows[*setting].full_name()).collect(),
        };
        let text = |of: &blocks::Text| Text {
            name: of.name.into(),
            description: of.description.into(),
            type_name: of.ty.name(),
            role: of.role,
            start: of.start.into(),
        };
        let response = |of: &blocks::Response| Response {
            title: of.title.into(),
            calls: of.calls,
            set: of.set.iter().map(|(call, name, value)| (*call, name.to_string(), *value)).collect(),
            show: texts(of.show),
        };
        let characteristic = |of: &blocks::Characteristic| Characteristic {
            title: of.title.into(),
            variable: of.variable.into(),
            range: of.range,
            points: of.points,
            calls: of.calls,
            set: of.set.iter().map(|(name, value)| (name.to_string(), *value)).collect(),
            show: texts(of.show),
        };
        Table {
            name: of.name.into(),
            aliases: texts(of.aliases),
            docs: of.docs.into(),
            cycle: of.cycle,
            mean: of.mean,
            variables: of.rows.iter().map(row).collect(),
            texts: of.texts.iter().map(text).collect(),
            responses: of.responses.iter().map(response).collect(),
            characteristics: of.characteristics.iter().map(characteristic).collect(),
            drawn_unit: of.drawn_unit.map(str::to_string),
        }
    }
}

impl Table {
    /// The row of the variable with this full name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.variables.iter().position(|row| row.name == name)
    }

    /// The rows of the variables with these names.
    pub fn rows(&self, names: &[String]) -> Vec<usize> {
        names.iter().filter_map(|name| self.find(name)).collect()
    }

    /// The rows of the variables that a response draws.
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

    /// What the block does, in one sentence: the first paragraph of its documentation, on one line.
    pub fn summary(&self) -> String {
        let lines = self.docs.lines().map(str::trim).skip_while(|line| line.is_empty());
        lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
    }

    /// Refuses a table whose parts do not fit together.
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

/// Reads a library's description of itself. An error says where the parser stopped and after which text.
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
