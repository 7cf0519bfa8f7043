//! A block's table as the JSON returned by its library. Nothing here depends on the FMI version.

use crate::error::{Error, shortened};
use blocks::table::number::{of_exact, to_value};
use blocks::{Characteristic, Kind, Response, Role, Row, Table, Text, TextType, Time, Value};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};

/// The grammar of a table. Numbers are as in the C interface: a TIME in seconds, FALSE and TRUE as 0 and 1.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TableGrammar {
    name: String,
    #[serde(default)]
    aliases: Vec<String>,
    docs: String,
    cycle: usize,
    mean: Option<usize>,
    variables: Vec<RowGrammar>,
    #[serde(default)]
    texts: Vec<TextGrammar>,
    responses: Vec<ResponseGrammar>,
    #[serde(default)]
    characteristics: Vec<CharacteristicGrammar>,
    #[serde(default)]
    drawn_unit: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RowGrammar {
    name: String,
    description: String,
    #[serde(default)]
    help: String,
    #[serde(deserialize_with = "kind")]
    kind: Kind,
    #[serde(default)]
    analog: bool,
    #[serde(deserialize_with = "role")]
    role: Role,
    start: f64,
    /// The start value of an integer with too many digits for `start`; for a duration, in milliseconds or nanoseconds.
    #[serde(default)]
    exact: Option<i128>,
    min: Option<f64>,
    max: Option<f64>,
    unit: Option<String>,
    /// The names of the settings that determine its value after a restart.
    #[serde(default)]
    from: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TextGrammar {
    name: String,
    description: String,
    #[serde(rename = "type", deserialize_with = "text_type")]
    ty: TextType,
    #[serde(deserialize_with = "role")]
    role: Role,
    start: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ResponseGrammar {
    title: String,
    calls: u32,
    set: Vec<(u32, String, f64)>,
    show: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CharacteristicGrammar {
    title: String,
    variable: String,
    range: (f64, f64),
    points: u32,
    calls: u32,
    set: Vec<(String, f64)>,
    show: Vec<String>,
}

/// Reads a table from JSON.
///
/// # Errors
/// The JSON is malformed, a value does not fit its type, or a restart value depends on something other than a setting.
pub fn read_table(json: &str) -> Result<Table, Error> {
    from_json::<TableGrammar>(json)?.table()
}

impl TableGrammar {
    pub(crate) fn table(self) -> Result<Table, Error> {
        let TableGrammar { name, aliases, docs, cycle, mean, variables, .. } = self;
        let wrong = |what: String| Error::new(format!("the library's table of {name}: {what}"));
        let is_setting = |row: &RowGrammar| matches!(row.role, Role::Parameter | Role::Fixed | Role::Cycle);
        let mut rows = Vec::with_capacity(variables.len());
        for row in &variables {
            let setting = |name: &String| {
                variables.iter().position(|other| other.name == *name && is_setting(other)).ok_or_else(|| {
                    let own = &row.name;
                    wrong(format!(
                        "the restart value of {own} depends on {name:?}, which is not a parameter in the table"
                    ))
                })
            };
            let from = row.from.iter().map(setting).collect::<Result<_, Error>>()?;
            let row = row.row(from).map_err(|why| wrong(format!("{} is {why}", row.name)))?;
            rows.push(row);
        }
        let text = |TextGrammar { name, description, ty, role, start }| Text { name, description, role, start, ty };
        let response = |ResponseGrammar { title, calls, set, show }| Response { title, calls, set, show };
        let characteristic = |CharacteristicGrammar { title, variable, range, points, calls, set, show }| {
            Characteristic { title, variable, range, points, calls, set, show }
        };
        Ok(Table {
            aliases,
            docs,
            rows,
            texts: self.texts.into_iter().map(text).collect(),
            tunable_reals: Vec::new(),
            tunable_lreals: Vec::new(),
            cycle,
            mean,
            memory: Vec::new(),
            instances: &[],
            responses: self.responses.into_iter().map(response).collect(),
            characteristics: self.characteristics.into_iter().map(characteristic).collect(),
            drawn_unit: self.drawn_unit,
            name,
        })
    }
}

impl RowGrammar {
    fn row(&self, from: Vec<usize>) -> Result<Row, String> {
        let kind = self.kind;
        let value = |number: f64| match kind {
            // Negative durations are allowed here: a program may start with one, although no host can set it.
            Kind::Time => Ok(Value::Time(Time::ms((number * 1000.0).round() as i32))),
            _ => to_value(number, kind).map_err(|range| format!("{number:?}: {range}")),
        };
        let exact = |exact: i128| of_exact(exact, kind).map_err(|range| format!("{exact}: {range}"));
        Ok(Row {
            name: self.name.clone(),
            description: self.description.clone(),
            help: self.help.clone(),
            kind,
            is_analog: self.analog,
            role: self.role,
            start: self.exact.map_or_else(|| value(self.start), exact)?,
            min: self.min.map(value).transpose()?,
            max: self.max.map(value).transpose()?,
            unit: self.unit.clone(),
            from,
        })
    }
}

/// Rejects an inconsistent table.
pub(crate) fn check(table: &Table) -> Result<(), Error> {
    let wrong = |what: String| Err(Error::new(format!("the library's table of {}: {what}", table.name)));
    match table.rows.get(table.cycle) {
        Some(row @ Row { kind: Kind::Time, role: Role::Cycle, .. }) if row.start() >= 0.001 => {}
        Some(row @ Row { kind: Kind::Time, role: Role::Cycle, name, .. }) => {
            return wrong(format!("{name} starts at {:?} s: the minimum is 0.001 s", row.start()));
        }
        Some(Row { name, kind, role, .. }) => {
            let (kind, role) = (kind.name(), role.name());
            return wrong(format!("the cycle row {name} has type {kind} and role {role}: they must be TIME and cycle"));
        }
        None => {
            let rows = table.rows.len();
            return wrong(format!(
                "the cycle is row {} (counted from 0), but the number of rows is {rows}",
                table.cycle
            ));
        }
    }
    for row in &table.rows {
        let numbers = [("starts at", Some(row.start())), ("has min", row.least()), ("has max", row.greatest())];
        if let Some((what, Some(number))) = numbers.into_iter().find(|(_, of)| of.is_some_and(|of| !of.is_finite())) {
            let name = &row.name;
            return wrong(format!("{name} {what} {number:?}: every start, min and max must be finite"));
        }
    }
    if let Some(mean) = table.mean
        && table.rows.get(mean).is_none_or(|row| row.role != Role::Output)
    {
        return wrong(format!("the mean of the pulse is row {mean}, which is not an output"));
    }
    if table.responses.is_empty() {
        return wrong("it has no response: RESPONSES needs at least one, such as Response::AT_REST".into());
    }
    for response in &table.responses {
        let set = response.set.iter().map(|(_, name, _)| name);
        if let Some(unknown) = set.chain(&response.show).find(|name| table.find(name).is_none()) {
            return wrong(format!("its response names {unknown:?}: the table has no such variable"));
        }
    }
    for characteristic in &table.characteristics {
        let set = characteristic.set.iter().map(|(name, _)| name).chain([&characteristic.variable]);
        if let Some(unknown) = set.chain(&characteristic.show).find(|name| table.find(name).is_none()) {
            return wrong(format!("its characteristic names {unknown:?}: the table has no such variable"));
        }
        let (from, to) = characteristic.range;
        if !(from < to && characteristic.points >= 2 && characteristic.calls >= 1) {
            return wrong(format!(
                "its characteristic as a function of {} needs an ascending range, at least 2 points and 1 call",
                characteristic.variable
            ));
        }
    }
    Ok(())
}

fn kind<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Kind, D::Error> {
    let name = String::deserialize(deserializer)?;
    Kind::named(&name).ok_or_else(|| unknown("kind", &name, Kind::ALL.iter().map(|kind| kind.name())))
}

fn role<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Role, D::Error> {
    let name = String::deserialize(deserializer)?;
    Role::named(&name).ok_or_else(|| unknown("role", &name, Role::ALL.iter().map(|role| role.name())))
}

fn text_type<'de, D: Deserializer<'de>>(deserializer: D) -> Result<TextType, D::Error> {
    let name = String::deserialize(deserializer)?;
    TextType::named(&name).ok_or_else(|| unknown("type", &name, ["STRING[n]", "WSTRING[n]"].into_iter()))
}

fn unknown<E: serde::de::Error>(what: &str, name: &str, known: impl Iterator<Item = &'static str>) -> E {
    let known = known.collect::<Vec<_>>().join(", ");
    E::custom(format!("unknown {what} `{}`, expected one of {known}", shortened(name)))
}

/// Parses a library's description of itself. An error states the position at which the parser stopped and the text
/// before it.
pub(crate) fn from_json<T: DeserializeOwned>(json: &str) -> Result<T, Error> {
    serde_json::from_str(json).map_err(|error| {
        let line = json.lines().nth(error.line().saturating_sub(1)).unwrap_or("");
        let end = line.floor_char_boundary(error.column());
        let begin = line.floor_char_boundary(end.saturating_sub(60));
        Error::new(format!(
            "the library's table cannot be read: {error}, after {:?}; build library and packer from the same sources, \
             and make every start, min and max finite",
            &line[begin..end]
        ))
    })
}
