//! The messages of the engine: a [`Request`](crate::Request) in, an [`Answer`] out, each a JSON object.
//!
//! The page posts the same requests to the engine in WebAssembly and to the one behind `plcfmu tool`.
//!
//! ```json
//! {"do": "start", "members": [{"name": "TIC101", "fmu": "PUMP", "values": {"GAIN": 2.0}}], "connections": []}
//! ```
//!
//! An answer is `{"ok": ...}`, whose content depends on the request, or `{"error": {"message": ...}}`.
//! A variable of a loop is named `MEMBER.VARIABLE`. Times are in seconds. A number that is not finite is the text `"NaN"`,
//! `"inf"` or `"-inf"`. Bytes are Base64.

use manifest::Manifest;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub use control::figures::Happened;
pub use run::fmus::{LoopRole, Member, Values};
pub use run::system::{Exchange, Value};

/// What there is to choose from.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Catalogue {
    /// The FMUs, in the order in which they are shown.
    pub fmus: Vec<Entry>,
    /// Loops that are known to work: examples for connections and settings.
    pub loops: Vec<KnownLoop>,
    /// The kinds of parameter files that can be written: extensions and titles.
    pub formats: Vec<(String, String)>,
}

/// An FMU of the catalogue.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Entry {
    /// Its name, by which all other requests name it.
    pub name: String,
    /// What it does, in one sentence.
    pub summary: String,
    /// What it is in a loop.
    pub part: LoopRole,
    /// Whether it is a foreign FMU: native code of somebody else.
    pub is_foreign: bool,
}

/// A loop that is known to work.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct KnownLoop {
    /// The name of its description, `furnace`.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// What is special about it, or empty.
    pub about: String,
    /// Its members and connections.
    pub setup: Setup,
    /// How long it runs in its description, in seconds.
    pub stop: Option<f64>,
    /// What is set meanwhile: the time in seconds, `MEMBER.VARIABLE`, and the value.
    pub events: Vec<(f64, String, Value)>,
    /// The members that are programs: their FMUs have to be made of their sources.
    pub programs: Vec<MadeOf>,
}

/// A member that is a program.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct MadeOf {
    /// The member.
    pub member: String,
    /// The names of its sources, without folders.
    pub sources: Vec<String>,
    /// How it is made of them. The sources themselves are missing.
    pub program: Program,
}

/// The sources of a program, and how it is made of them. What is left out is as for `plcfmu build`; without a cycle, it is what the
/// sources propose.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// The sources.
    #[serde(default)]
    pub files: Vec<SourceFile>,
    /// How it is made of them.
    #[serde(flatten)]
    pub manifest: Manifest,
}

/// A source.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SourceFile {
    /// Its name.
    pub file: String,
    /// Its bytes, Base64.
    pub content: String,
}

/// An FMU as a dialog shows it.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Description {
    /// Its name in the catalogue.
    pub name: String,
    /// The name of its block, by which parameter files know it.
    pub block: String,
    /// What it does, in one sentence.
    pub summary: String,
    /// The other names by which a PLC project may call the block.
    pub aliases: Vec<String>,
    /// What it is in a loop.
    pub part: LoopRole,
    /// The variable that holds the time between two calls; a foreign FMU has none.
    pub cycle: Option<String>,
    /// Its variables, in the order of the table.
    pub variables: Vec<Variable>,
    /// What its variables are in a loop.
    pub roles: run::dialog::Roles,
    /// Its settings in groups, in the order of the dialog.
    pub groups: Vec<run::dialog::Group>,
}

/// A variable of an FMU.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Variable {
    /// Its name, `GAIN`.
    pub name: String,
    /// A short text.
    pub description: String,
    /// Its PLC type, `REAL`; that of FMI in a foreign FMU, `Real`.
    pub kind: String,
    /// `input`, `parameter`, `fixed`, `cycle`, `output`, `local`
    #[cfg_attr(test, ts(type = "\"input\" | \"parameter\" | \"fixed\" | \"cycle\" | \"output\" | \"local\""))]
    pub role: String,
    /// Whether it can be set while the loop runs.
    pub is_tunable: bool,
    /// Whether it is what the loop is tried with (setpoint, manual value, disturbance, noise), and not a setting.
    pub is_stimulus: bool,
    /// Its value in a new instance.
    pub start: Value,
    /// The lowest value that makes sense.
    pub min: Option<f64>,
    /// The highest value that makes sense.
    pub max: Option<f64>,
    /// Its physical unit; s of a TIME.
    pub unit: Option<String>,
}

/// A parameter file.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct ReadFile {
    /// Its name, whose extension selects the format.
    pub file: String,
    /// Its bytes, Base64.
    pub content: String,
    /// The block, where the file does not say it.
    #[serde(default)]
    pub block: Option<String>,
    /// The loop's name, where the file does not say it.
    #[serde(default)]
    pub name: Option<String>,
}

/// The loops of a file.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Loops {
    /// The loops, in the order of the file; none if something is wrong with it.
    pub loops: Vec<Loop>,
    /// What is wrong, or what the user should know.
    pub problems: Vec<Problem>,
    /// Whether the file could not be used.
    pub is_refused: bool,
}

/// A loop of a file.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Loop {
    /// Its name.
    pub name: String,
    /// What its author calls it.
    pub title: Option<String>,
    /// Its block; one of the catalogue has this name.
    pub block: String,
    /// The time between two calls.
    pub cycle: Option<f64>,
    /// Its values.
    pub settings: Vec<LoopValue>,
    /// What the block will do with them where a user may not expect it, and values out of range.
    pub warnings: Vec<String>,
}

/// A value of a loop.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LoopValue {
    /// The variable.
    pub name: String,
    /// Its value.
    pub value: Value,
    /// Where the value comes from, `plant.awl:12:8`; without it, it is the block's start value.
    pub origin: Option<String>,
    /// The value of the file, where that is another one by now.
    #[serde(default)]
    pub file: Option<Value>,
}

/// Something about a place of a file.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Problem {
    /// The line and the column, from 1, if it has a place.
    pub place: Option<(usize, usize)>,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
    /// The user must choose the block that the file has the parameters of.
    pub asks_for_block: bool,
}

/// What a block does with settings.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Checked {
    /// Sentences, with the settings that they name.
    pub remarks: Vec<Remark>,
    /// The settings that have no effect with the others as they are, by name.
    pub unused: Vec<String>,
    /// The values as the PLC's types hold them, where they differ from what was given.
    pub rounded: Values,
}

/// A sentence about settings.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Remark {
    /// The variables that it is about.
    pub variables: Vec<String>,
    /// The sentence.
    pub text: String,
    /// Whether the FMU will refuse the value.
    pub is_error: bool,
}

/// How a controller and a plant are connected.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Proposal {
    /// The connections that are proposed.
    pub connections: Vec<Wire>,
    /// All others that are possible.
    pub others: Vec<Wire>,
    /// Settings that go with the proposed connections, by `MEMBER.VARIABLE`.
    pub values: Values,
    /// The communication step that goes with them; the controller's cycle without it.
    #[serde(default)]
    pub step: Option<f64>,
    /// When values go from output to input, in the known loop that this is taken from.
    #[serde(default)]
    pub exchange: Exchange,
    /// Inputs that need a connection and have none.
    pub open: Vec<Open>,
    /// What else the user should know, a sentence each.
    pub remarks: Vec<String>,
}

/// An input that needs a connection, until something goes to it.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Open {
    /// The input, `MEMBER.VARIABLE`.
    pub input: String,
    /// What is missing, a sentence.
    pub text: String,
}

/// A possible connection.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Wire {
    /// The output, `MEMBER.VARIABLE`.
    pub from: String,
    /// The input, `MEMBER.VARIABLE`.
    pub to: String,
    /// Why it is proposed.
    pub reason: String,
}

/// What to run: a controller first, then its plant and what else there is.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Setup {
    /// The FMUs, in the order in which they are stepped.
    pub members: Vec<Member>,
    /// From an output to an input, both `MEMBER.VARIABLE`.
    pub connections: Vec<(String, String)>,
    /// The communication step; by default the first member's cycle.
    #[serde(default)]
    pub step: Option<f64>,
    /// When values go from output to input.
    #[serde(default)]
    pub exchange: Exchange,
}

/// Where the run is.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct State {
    /// The number of the run, from 0.
    pub run: usize,
    /// How many calls have been made.
    pub calls: usize,
    /// When the last call was, in seconds; 0 before the first.
    pub time: f64,
    /// The communication step in seconds.
    pub step: f64,
    /// The values of all variables in the row of the last call, by `MEMBER.VARIABLE`.
    pub values: Values,
    /// The values after the last call, where members act in parallel: the outputs in its row are those of the call before.
    pub after: Option<Values>,
    /// What is forced, by `MEMBER.VARIABLE`.
    pub forced: Values,
    /// What has ended the run: which FMU failed, and its messages.
    pub failure: Option<String>,
    /// Whether the last calls ended because the condition that they were made with began to hold.
    #[serde(default)]
    pub is_met: bool,
    /// What the FMUs and the plan say since the last answer, a sentence each.
    pub remarks: Vec<String>,
}

/// Which curves to show.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct View {
    /// The run; the present one without it.
    #[serde(default)]
    pub run: Option<usize>,
    /// The variables, by `MEMBER.VARIABLE`.
    pub variables: Vec<String>,
    /// The beginning in seconds; that of the run without it.
    #[serde(default)]
    pub from: Option<f64>,
    /// The end in seconds; the last call without it.
    #[serde(default)]
    pub to: Option<f64>,
    /// At most this many points.
    pub points: usize,
    /// For these variables the mean over so many seconds, up to and with the call: of pulses the mean of their period.
    #[serde(default)]
    pub means: Option<BTreeMap<String, f64>>,
}

/// Curves: each row is a call. If they are not exact, each two rows are a group of calls, at the times of its first and its
/// last one, with the lowest and the highest value of each variable in the group, in the order in which they occur.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Curves {
    /// The times in seconds.
    pub times: Vec<f64>,
    /// The values of each variable at these times; `null` is not a number; true is 1.
    #[cfg_attr(test, ts(type = "(number | null)[][]"))]
    pub values: Vec<Vec<f64>>,
    /// Their units.
    pub units: Vec<Option<String>>,
    /// Whether every call is there.
    pub is_exact: bool,
}

/// What a run began with, and what was done in it, in the order of time.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Events {
    /// What the run began with.
    pub setup: Setup,
    /// What was done.
    pub events: Vec<Event>,
    /// How many calls the run has made.
    pub calls: usize,
}

/// A value that was set while the loop ran.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Event {
    /// Before which call, from 0.
    pub call: usize,
    /// When that call is, in seconds.
    pub time: f64,
    /// `MEMBER.VARIABLE`
    pub variable: String,
    /// The value; of what was released, the one that it had.
    pub value: Value,
    /// How it was set.
    #[serde(default, skip_serializing_if = "Act::is_set")]
    #[cfg_attr(test, ts(as = "Option<Act>", optional))]
    pub act: Act,
}

/// How a variable is set.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum Act {
    /// As an FMU allows it: an input or a parameter.
    #[default]
    Set,
    /// Once, whatever it is.
    Write,
    /// For every call from then on, whatever it is.
    Force,
    /// It is forced no longer.
    Release,
}

impl Act {
    fn is_set(&self) -> bool {
        *self == Act::Set
    }
}

/// Of which part of which run.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
#[serde(default, deny_unknown_fields)]
pub struct FiguresRequest {
    /// The run; the present one without it.
    pub run: Option<usize>,
    /// The beginning in seconds; that of the last step without it.
    pub from: Option<f64>,
    /// The end in seconds; without it and without a beginning, that of the last step's window.
    pub to: Option<f64>,
    /// The unit of the process value, where its variable has none.
    pub unit: Option<String>,
    /// The unit of the manipulated value, where its variable has none.
    pub travel_unit: Option<String>,
}

/// The test of a run with other settings.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Tried {
    /// Its curves.
    pub curves: Curves,
    /// Its figures; none of a loop without a setpoint or a process value.
    pub figures: Option<Figures>,
}

/// The figures of a run, those that its signals allow.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Figures {
    /// From where on, in seconds.
    pub from: f64,
    /// Up to where, in seconds.
    pub to: f64,
    /// The step that they belong to: two runs with the same step over the same time can be compared.
    pub step: Option<Happened>,
    /// The disturbance that those of a disturbance belong to.
    pub disturbance: Option<Happened>,
    /// The figures, in the order in which they are shown.
    pub figures: Vec<Figure>,
    /// Which figures are absent, and why.
    pub remarks: Vec<String>,
}

/// A figure of a run.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Figure {
    /// Its name, `settling`.
    pub key: String,
    /// Its title, `Settling time`.
    pub title: String,
    /// What it is, in a few words.
    pub meaning: String,
    /// Its value; it is absent if the remarks say why.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: Option<String>,
}

/// What the engine answers.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// What was asked for.
    Ok(serde_json::Value),
    /// Why there is no answer.
    Error(Error),
}

/// Why a request was refused.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Error {
    /// What is wrong, with name and value, and what to do: one sentence.
    pub message: String,
}
