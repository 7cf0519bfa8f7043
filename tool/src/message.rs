//! The engine's messages: each [`Request`](crate::Request) gets an [`Answer`]; both are JSON objects.
//!
//! The page sends the same requests to the engine in WebAssembly as to that of `plcfmu tool`.
//!
//! ```json
//! {"do": "start", "members": [{"name": "TIC101", "fmu": "PUMP", "values": {"GAIN": 2.0}}], "connections": []}
//! ```
//!
//! An answer is `{"ok": ...}`, whose content depends on the request, or `{"error": {"message": ...}}`. A variable of a
//! loop is named `MEMBER.VARIABLE`. Times are in seconds. A number that is not finite is the string `"NaN"`, `"inf"` or
//! `"-inf"`. Bytes are Base64.

use manifest::Manifest;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub use control::figures::Happened;
pub use run::fmus::{LoopRole, Member, Values};
pub use run::system::{Exchange, Value};

/// The available FMUs, loops and formats.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Catalogue {
    /// The FMUs, in display order.
    pub fmus: Vec<Entry>,
    /// Loops that are known to work: examples for connections and settings.
    pub loops: Vec<KnownLoop>,
    /// The formats of parameter files that can be written: extension and title of each.
    pub formats: Vec<(String, String)>,
}

/// An FMU of the catalogue.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Entry {
    /// Its name, used in all other requests.
    pub name: String,
    /// A summary in one sentence.
    pub summary: String,
    /// Its role in a loop, such as controller or plant.
    pub part: LoopRole,
    /// Whether it is a foreign FMU: third-party native code.
    pub is_foreign: bool,
}

/// A loop that is known to work.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct KnownLoop {
    /// The name of its description, such as `furnace`.
    pub name: String,
    /// Its title.
    pub title: String,
    /// What is special about it, in a sentence; may be empty.
    pub about: String,
    /// Its members and connections.
    pub setup: Setup,
    /// The duration of the run in its description, in seconds.
    pub stop: Option<f64>,
    /// The settings made during the run: the time in seconds, `MEMBER.VARIABLE`, and the value.
    pub events: Vec<(f64, String, Value)>,
    /// The members that are programs: their FMUs must be built from their sources.
    pub programs: Vec<MadeOf>,
}

/// A member that is a PLC program.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct MadeOf {
    /// The member's name.
    pub member: String,
    /// The names of its sources, without folders.
    pub sources: Vec<String>,
    /// How it is built from them; its list of files is empty.
    pub program: Program,
}

/// The sources of a program, and how it is built from them. The defaults are those of `plcfmu build`, except that the
/// cycle is proposed from the sources.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// The sources.
    #[serde(default)]
    pub files: Vec<SourceFile>,
    /// How it is built from them.
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

/// An FMU as needed by its dialog.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Description {
    /// Its name in the catalogue.
    pub name: String,
    /// The name of its block, as used in parameter files.
    pub block: String,
    /// A summary in one sentence.
    pub summary: String,
    /// Other names of the block in PLC projects.
    pub aliases: Vec<String>,
    /// Its role in a loop, such as controller or plant.
    pub part: LoopRole,
    /// The variable that holds the time between two calls; `None` for a foreign FMU.
    pub cycle: Option<String>,
    /// Its variables, in the order of the table.
    pub variables: Vec<Variable>,
    /// The roles of its variables in a loop.
    pub roles: run::dialog::Roles,
    /// Its settings in groups, in the order of the dialog.
    pub groups: Vec<run::dialog::Group>,
}

/// A variable of an FMU.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Variable {
    /// Its name, such as `GAIN`.
    pub name: String,
    /// A short description.
    pub description: String,
    /// Its PLC type, such as `REAL`; in a foreign FMU its FMI type, such as `Real`.
    pub kind: String,
    /// Its role in the block: `input`, `parameter`, `fixed`, `cycle`, `output` or `local`.
    #[cfg_attr(test, ts(type = "\"input\" | \"parameter\" | \"fixed\" | \"cycle\" | \"output\" | \"local\""))]
    pub role: String,
    /// Whether it can be set while the loop runs.
    pub is_tunable: bool,
    /// Whether it is a stimulus of the loop (setpoint, manual value, disturbance, noise) rather than a setting.
    pub is_stimulus: bool,
    /// Its value in a new instance.
    pub start: Value,
    /// The lowest sensible value.
    pub min: Option<f64>,
    /// The highest sensible value.
    pub max: Option<f64>,
    /// Its physical unit; `s` for a TIME.
    pub unit: Option<String>,
}

/// A parameter file to read.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct ReadFile {
    /// Its name, whose extension selects the format.
    pub file: String,
    /// Its bytes, Base64.
    pub content: String,
    /// The block, if the file does not specify it.
    #[serde(default)]
    pub block: Option<String>,
    /// The loop's name, if the file does not specify it.
    #[serde(default)]
    pub name: Option<String>,
}

/// The loops of a file.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Loops {
    /// The loops, in the order of the file; empty if the file is faulty.
    pub loops: Vec<Loop>,
    /// The problems, or remarks for the user if the file can be used.
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
    /// Its title in the file.
    pub title: Option<String>,
    /// The name of its block in the catalogue.
    pub block: String,
    /// The time between two calls, in seconds.
    pub cycle: Option<f64>,
    /// Its values.
    pub settings: Vec<LoopValue>,
    /// Warnings about unexpected effects of the settings and about values out of range.
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
    /// The origin of the value, such as `plant.awl:12:8`; `None` for the block's start value.
    pub origin: Option<String>,
    /// The value in the file from which the loop was read, if the current value differs.
    #[serde(default)]
    pub file: Option<Value>,
}

/// A problem in a file, or a remark on it.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Problem {
    /// The 1-based line and column, if the problem concerns a place in the file.
    pub place: Option<(usize, usize)>,
    /// The problem.
    pub message: String,
    /// The remedy.
    pub help: Option<String>,
    /// Whether to offer the user a choice of the block whose parameters the file contains.
    pub asks_for_block: bool,
}

/// The result of checking a block's settings.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Checked {
    /// Remarks, each with the variables concerned.
    pub remarks: Vec<Remark>,
    /// The settings without effect in combination with the others, by name.
    pub unused: Vec<String>,
    /// The values as rounded by the PLC types, where they differ from those given.
    pub rounded: Values,
}

/// A sentence about settings.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Remark {
    /// The variables concerned.
    pub variables: Vec<String>,
    /// The sentence.
    pub text: String,
    /// Whether the FMU will reject the value.
    pub is_error: bool,
}

/// How to connect a controller and a plant.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Proposal {
    /// The proposed connections.
    pub connections: Vec<Wire>,
    /// All other possible connections.
    pub others: Vec<Wire>,
    /// Settings for the proposed connections, by `MEMBER.VARIABLE`.
    pub values: Values,
    /// The communication step for the proposed connections, in seconds; by default the controller's cycle.
    #[serde(default)]
    pub step: Option<f64>,
    /// When values pass from output to input, as in the known loop on which the proposal is based.
    #[serde(default)]
    pub exchange: Exchange,
    /// Unconnected inputs that need a connection.
    pub open: Vec<Open>,
    /// Other remarks for the user, a sentence each.
    pub remarks: Vec<String>,
}

/// An input that needs a connection.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Open {
    /// The input, `MEMBER.VARIABLE`.
    pub input: String,
    /// The problem, in a sentence.
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
    /// The reason for the proposal.
    pub reason: String,
}

/// The setup of a run: a controller first, then its plant and any other members.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Setup {
    /// The FMUs, in the order in which they are stepped.
    pub members: Vec<Member>,
    /// The connections, each from an output to an input, both `MEMBER.VARIABLE`.
    pub connections: Vec<(String, String)>,
    /// The communication step, in seconds; by default the first member's cycle.
    #[serde(default)]
    pub step: Option<f64>,
    /// When values pass from output to input.
    #[serde(default)]
    pub exchange: Exchange,
}

/// The state of a run.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct State {
    /// The 0-based number of the run.
    pub run: usize,
    /// The number of calls made.
    pub calls: usize,
    /// The time of the last call, in seconds; 0 before the first.
    pub time: f64,
    /// The communication step in seconds.
    pub step: f64,
    /// The values of all variables in the row of the last call, by `MEMBER.VARIABLE`.
    pub values: Values,
    /// In a parallel exchange: the values after the last call, because the outputs in `values` are those of the
    /// previous call.
    pub after: Option<Values>,
    /// The forced values, by `MEMBER.VARIABLE`.
    pub forced: Values,
    /// Why the run has ended: which FMU failed, and its messages.
    pub failure: Option<String>,
    /// Whether the calls of this request ended because its condition became true.
    #[serde(default)]
    pub is_met: bool,
    /// Remarks since the last answer, from the FMUs and from checking the setup, a sentence each.
    pub remarks: Vec<String>,
}

/// The curves to show.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct View {
    /// The run; by default the current one.
    #[serde(default)]
    pub run: Option<usize>,
    /// The variables, by `MEMBER.VARIABLE`.
    pub variables: Vec<String>,
    /// The beginning in seconds; by default that of the run.
    #[serde(default)]
    pub from: Option<f64>,
    /// The end in seconds; by default the last call.
    #[serde(default)]
    pub to: Option<f64>,
    /// The maximum number of rows, at least 2.
    pub points: usize,
    /// The variables to average, each with the time to average over, in seconds, up to and including each call; for
    /// pulses, their period.
    #[serde(default)]
    pub means: Option<BTreeMap<String, f64>>,
}

/// Curves. If they are exact, each row is a call. Otherwise, each pair of rows represents a group of calls: their times
/// are those of its first and its last call; their values are the lowest and the highest value of each variable in the
/// group, in the order in which they occur.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Curves {
    /// The times in seconds.
    pub times: Vec<f64>,
    /// The values of each variable at these times; NaN is `null`, true is 1.
    #[cfg_attr(test, ts(type = "(number | null)[][]"))]
    pub values: Vec<Vec<f64>>,
    /// Their units.
    pub units: Vec<Option<String>>,
    /// Whether every call is included.
    pub is_exact: bool,
}

/// The setup of a run, and its events in chronological order.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Events {
    /// The setup at the start of the run.
    pub setup: Setup,
    /// The events.
    pub events: Vec<Event>,
    /// The number of calls made by the run.
    pub calls: usize,
}

/// A variable that was set while the loop ran.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Event {
    /// The 0-based index of the call before which it was set.
    pub call: usize,
    /// The time of that call, in seconds.
    pub time: f64,
    /// `MEMBER.VARIABLE`
    pub variable: String,
    /// The value; for a release, the previous forced value.
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
    /// As FMI allows: an input or a tunable parameter.
    #[default]
    Set,
    /// Once, before the call, for any variable.
    Write,
    /// For every call from this one onward, for any variable.
    Force,
    /// No longer forced.
    Release,
}

impl Act {
    fn is_set(&self) -> bool {
        *self == Act::Set
    }
}

/// A run, and the part of it to evaluate.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
#[serde(default, deny_unknown_fields)]
pub struct FiguresRequest {
    /// The run; by default the current one.
    pub run: Option<usize>,
    /// The beginning in seconds; by default that of the last step.
    pub from: Option<f64>,
    /// The end in seconds; by default that of the last step's window if no beginning is given either, else the last
    /// call.
    pub to: Option<f64>,
    /// The unit of the process value, if its variable has none.
    pub unit: Option<String>,
    /// The unit of the manipulated value, if its variable has none.
    pub travel_unit: Option<String>,
}

/// A run's test, repeated with other settings.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Tried {
    /// Its curves.
    pub curves: Curves,
    /// Its figures; `None` for a loop without a setpoint or a process value.
    pub figures: Option<Figures>,
}

/// The figures that can be computed from a run's signals.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Figures {
    /// The beginning of their window, in seconds.
    pub from: f64,
    /// The end of their window, in seconds.
    pub to: f64,
    /// The step to which they belong: two runs with the same step over the same time can be compared.
    pub step: Option<Happened>,
    /// The disturbance to which the disturbance figures belong.
    pub disturbance: Option<Happened>,
    /// The figures, in display order.
    pub figures: Vec<Figure>,
    /// Which figures are missing, and why.
    pub remarks: Vec<String>,
}

/// A figure of a run.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Figure {
    /// Its name, such as `settling`.
    pub key: String,
    /// Its title, such as `Settling time`.
    pub title: String,
    /// A short description.
    pub meaning: String,
    /// Its value; `None` if it is missing for the reason given in the remarks.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: Option<String>,
}

/// The answer of the engine.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// The result.
    Ok(serde_json::Value),
    /// Why there is no result.
    Error(Error),
}

/// Why a request was rejected.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Error {
    /// The problem, with the name and value concerned, and the remedy, in one sentence.
    pub message: String,
}
