//! Exports results as files.

use crate::chain::begin_at_the_plant;
use crate::describe::{as_loop, describe, opened, stimuli_of_block};
use crate::home::Home;
use crate::message::{Act, FiguresRequest, Loop, Member, ReadFile};
use crate::report::{self, Report, ReportedReplay, ReportedRun, Tuning};
use crate::session::{Record, Session};
use crate::signals;
use anyhow::{Context, Result, bail};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use manifest::Manifest;
use parameters::{Format, Origin};
use run::file;
use run::fmus::number_of;
use run::master::write_csv;
use run::system::{Connection, Setting, System, Value};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The maximum size of a description that `plcfmu run` reads, in bytes.
const LONGEST_DESCRIPTION: usize = 1 << 20;

/// The file to export.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(rename = "Export", optional_fields = nullable))]
pub enum ExportRequest {
    /// Loops as a parameter file.
    Parameters {
        /// The extension of the file: `awl`, `scl`, `db`, `xml`, `json`, `ssv`.
        format: String,
        /// The loops with their values.
        loops: Vec<Loop>,
        /// The origin of the values, for a comment in the file.
        origin: String,
        /// Whether the file contains the current stimuli (setpoint, manual value and the like). Otherwise, stimuli have
        /// the values of the file from which the loop was read, or are left out.
        #[serde(default)]
        stimuli: bool,
    },
    /// An opened parameter file with new values for its loops; everything else in it is preserved byte for byte.
    Source {
        /// The file as opened.
        file: ReadFile,
        /// The loops of the file with changed values.
        loops: Vec<Loop>,
        /// Whether the file contains the current stimuli; otherwise, they keep the values of the file.
        #[serde(default)]
        stimuli: bool,
    },
    /// A run as a description for `plcfmu run`: setup, connections, events.
    Description {
        /// The run; by default the current one.
        #[serde(default)]
        run: Option<usize>,
    },
    /// A run as CSV, with every call that is still stored individually.
    Csv {
        /// The run; by default the current one.
        #[serde(default)]
        run: Option<usize>,
        /// The variables, by `MEMBER.VARIABLE`; by default all.
        #[serde(default)]
        variables: Vec<String>,
        /// Whether the file also contains the data that a replay of the run needs: mode, setpoint and process value of
        /// the controller, and all variables set or changed in the run.
        #[serde(default)]
        inputs: bool,
    },
    /// One page with parameters, curves and figures, as HTML.
    Report {
        /// The loop with its values.
        of: Loop,
        /// The loop's previous values, for comparison; may be empty.
        #[serde(default)]
        before: Vec<crate::message::LoopValue>,
        /// The run; by default the current one.
        #[serde(default)]
        run: Option<usize>,
        /// A picture of the curves, an `<svg>` or a `data:` URL of a PNG; by default drawn by the engine.
        #[serde(default)]
        picture: Option<String>,
        /// The date of the report, as displayed.
        #[serde(default)]
        date: Option<String>,
        /// How the settings were computed, if a rule was applied.
        #[serde(default)]
        tuning: Option<Box<Tuning>>,
        /// The runs to compare, all with the same step, the earliest first.
        #[serde(default)]
        runs: Vec<ReportedRun>,
        /// The replays of a recording, in order.
        #[serde(default)]
        replays: Vec<ReportedReplay>,
        /// The unit of the process value, if its variable has none.
        #[serde(default)]
        unit: Option<String>,
        /// The unit of the manipulated value, if its variable has none.
        #[serde(default)]
        travel_unit: Option<String>,
    },
    /// The home's FMU for the loop's block, with the loop's values as start values.
    Preset {
        /// The loop with its values.
        of: Loop,
    },
}

/// An exported file.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Exported {
    /// Its name.
    pub file: String,
    /// Its media type.
    pub media_type: String,
    /// Its bytes, Base64.
    pub content: String,
    /// Remarks for the user, a sentence each.
    pub remarks: Vec<String>,
}

/// Exports a file.
///
/// # Errors
/// Why it cannot be created, and the remedy.
pub fn export(home: &dyn Home, session: &Session, request: &ExportRequest) -> Result<Exported> {
    match request {
        ExportRequest::Parameters { format, loops, origin, stimuli } => {
            parameter_file(home, format, &of_settings(home, loops, *stimuli)?, origin)
        }
        ExportRequest::Source { file, loops, stimuli } => source(home, file, &of_settings(home, loops, *stimuli)?),
        ExportRequest::Description { run } => {
            let record = session.record(*run)?;
            let (text, remarks) = description(home, record)?;
            let file = format!("{}.toml", file_name(&record.setup().members[0].name));
            Ok(Exported::new(file, "application/toml", text.into_bytes(), remarks))
        }
        ExportRequest::Csv { run, variables, inputs } => {
            let record = session.record(*run)?;
            let mut columns: Vec<usize> = match variables.as_slice() {
                [] => (0..record.columns().len()).collect(),
                _ => variables.iter().map(|name| record.column(name)).collect::<Result<_>>()?,
            };
            if *inputs {
                let more = acting(home, record)?;
                columns.extend(more.into_iter().filter(|column| !columns.contains(column)).collect::<Vec<_>>());
            }
            let (text, remarks) = csv(record, &columns)?;
            let file = format!("{}.csv", file_name(&record.setup().members[0].name));
            Ok(Exported::new(file, "text/csv", text, remarks))
        }
        ExportRequest::Report { of, before, run, picture, date, tuning, runs, replays, unit, travel_unit } => {
            // A report on settings alone needs no run.
            let record = match run {
                Some(run) => Some(session.record(Some(*run))?),
                None => session.record(None).ok(),
            };
            // A loop without a setpoint has no figures.
            let figures_of = |run: Option<usize>| {
                let (unit, travel_unit) = (unit.clone(), travel_unit.clone());
                let of_run = FiguresRequest { run, unit, travel_unit, ..FiguresRequest::default() };
                signals::figures(home, session, &of_run).ok()
            };
            let figures = record.and_then(|_| figures_of(*run));
            let compared = runs.iter().filter_map(|one| Some((one, figures_of(Some(one.run))?))).collect();
            let units = [unit.as_deref(), travel_unit.as_deref()];
            let (picture, date, tuning) = (picture.as_deref(), date.as_deref(), tuning.as_deref());
            let figures = figures.as_ref();
            let report = Report { of, before, record, figures, compared, picture, date, tuning, replays, units };
            let page = report::page(home, &report)?;
            Ok(Exported::new(format!("{}.html", file_name(&of.name)), "text/html", page.into_bytes(), Vec::new()))
        }
        ExportRequest::Preset { of } => preset(home, of),
    }
}

impl Exported {
    fn new(file: String, media_type: &str, content: Vec<u8>, remarks: Vec<String>) -> Exported {
        Exported { file, media_type: media_type.into(), content: STANDARD.encode(content), remarks }
    }
}

/// A file name for a loop, valid on any system.
fn file_name(name: &str) -> String {
    let plain = |letter: char| if letter.is_alphanumeric() || matches!(letter, '-' | '_' | '.') { letter } else { '_' };
    let name: String = name.chars().take(80).map(plain).collect();
    let name = name.trim_matches('.');
    if name.is_empty() { "loop".into() } else { name.into() }
}

fn parameter_file(home: &dyn Home, format: &str, loops: &[Loop], origin: &str) -> Result<Exported> {
    let ending = format.to_lowercase();
    let Some(kind) = Format::of_file(&format!("file.{ending}")) else {
        let endings: Vec<_> = Format::ALL.iter().flat_map(|format| format.extensions()).copied().collect();
        bail!("{format:?} is not a parameter file format: use one of {}", endings.join(", "));
    };
    let [first, rest @ ..] = loops else { bail!("no loop to export: open or create one first") };
    let loops = loops.iter().map(|of| as_loop(home, of)).collect::<Result<Vec<_>>>()?;
    // The origin is written into a comment, so it must not contain line breaks.
    let origin: String =
        origin.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).take(300).collect();
    let content = parameters::write(kind, &loops, &origin).map_err(anyhow::Error::msg)?;
    let name = if rest.is_empty() { file_name(&first.name) } else { "loops".into() };
    let remarks = loops.iter().flat_map(|of| of.warnings().into_iter().map(|text| format!("{}: {text}", of.name)));
    let remarks: Vec<_> = remarks.take(100).collect();
    Ok(Exported::new(format!("{name}.{ending}"), kind.media_type(), content, remarks))
}

/// The loops with their stimuli as in their files, or without those that their files do not contain; unchanged if
/// `stimuli` is true.
fn of_settings(home: &dyn Home, loops: &[Loop], stimuli: bool) -> Result<Vec<Loop>> {
    let mut loops = loops.to_vec();
    if stimuli {
        return Ok(loops);
    }
    for one in &mut loops {
        let is_stimulus = stimuli_of_block(home, &one.block)?;
        one.settings.retain_mut(|setting| {
            if is_stimulus(&setting.name) {
                setting.value = setting.file.unwrap_or(setting.value);
            }
            !is_stimulus(&setting.name) || setting.file.is_some()
        });
    }
    Ok(loops)
}

fn source(home: &dyn Home, file: &ReadFile, loops: &[Loop]) -> Result<Exported> {
    let (format, source, options) = opened(file)?;
    let blocks = home.blocks();
    let before = parameters::read(format, &source, &blocks, &options);
    let before = before.map_err(|_| anyhow::anyhow!("{} can no longer be read: open it again", file.file))?.loops;
    // Settings that the request omits keep the values of the file.
    let whole = |of: &Loop| -> Result<parameters::Loop> {
        let given = as_loop(home, of)?;
        let own = before.iter().find(|own| own.name == of.name && own.block.name == given.block.name);
        let mut whole = own
            .with_context(|| format!("{} has no loop {:?} with the block {}", file.file, of.name, of.block))?
            .clone();
        for setting in &of.settings {
            if let (Some(member), Some(value)) = (whole.block.find(&setting.name), given.get(&setting.name)) {
                whole.set(member, value, Origin::Default);
            }
        }
        Ok(whole)
    };
    let loops = loops.iter().map(whole).collect::<Result<Vec<_>>>()?;
    let (content, replaced) =
        parameters::rewrite(format, &source, &blocks, &options, &loops).map_err(anyhow::Error::msg)?;
    let sentence = |of: &parameters::Replaced| match of.origin {
        Origin::Default => format!("{}: {} was added", of.loop_name, of.member),
        _ => format!("{}: {} was changed ({})", of.loop_name, of.member, of.origin),
    };
    let remarks = if replaced.is_empty() {
        vec!["nothing has changed since the file was opened".into()]
    } else {
        replaced.iter().take(100).map(sentence).collect()
    };
    let name = file.file.rsplit(['/', '\\']).next().unwrap_or_default();
    let (stem, ending) = name.rsplit_once('.').unwrap_or((name, "txt"));
    Ok(Exported::new(format!("{}.{}", file_name(stem), file_name(ending)), format.media_type(), content, remarks))
}

fn preset(home: &dyn Home, of: &Loop) -> Result<Exported> {
    let one = as_loop(home, of)?;
    let content = home.preset(&one)?;
    Ok(Exported::new(format!("{}.fmu", file_name(&of.name)), "application/octet-stream", content, one.warnings()))
}

/// A run as a description with which `plcfmu run` produces bit-identical results.
fn description(home: &dyn Home, record: &Record) -> Result<(String, Vec<String>)> {
    let mut remarks = Vec::new();
    let setup = record.setup();
    let mut calls = record.calls();
    if let Some(exchange) = record.exchanges().first() {
        calls = exchange.call;
        remarks.push(format!(
            "The description ends at call {calls} ({:?} s), when {} was replaced: it cannot express a change of FMUs.",
            record.time(calls),
            setup.members.get(1).map_or("a plant", |member| member.name.as_str())
        ));
    }
    if calls == 0 {
        bail!("the run has no calls yet: make at least one first");
    }
    if let Some(forced) = record.done().iter().find(|done| done.act != Act::Set && done.call < calls) {
        calls = forced.call;
        let (name, time) = (&record.columns()[forced.column].name, record.time(calls));
        if calls == 0 {
            bail!("{name} is forced from the start, which a description cannot express: release it and run again");
        }
        remarks.push(format!(
            "The description ends at call {calls} ({time:?} s), when {name} was written: it can set only inputs and \
             parameters."
        ));
    }
    let system = system(home, record, calls);
    for program in system.programs.values() {
        let files: Vec<String> = program.sources.iter().map(|file| file.display().to_string()).collect();
        remarks.push(format!("Put the program's sources in the same folder: {}.", files.join(", ")));
    }
    let about = format!("# A run of the parameter tool, {calls} calls: plcfmu run FILE.toml\n");
    let text = about + &file::write(&system)?;
    if text.len() > LONGEST_DESCRIPTION {
        remarks.push(format!(
            "The description is {} MiB, because each call of a ramp is a separate event: 'plcfmu run' reads at most \
             {} MiB.",
            text.len().div_ceil(1 << 20),
            LONGEST_DESCRIPTION >> 20
        ));
    }
    Ok((text, remarks))
}

/// The first `calls` calls of a run as a system for `plcfmu run`.
fn system(home: &dyn Home, record: &Record, calls: usize) -> System {
    let setup = record.setup();
    let set = |variable: String, value, time| Setting { variable, value, time, is_preliminary: false, place: None };
    let is_free = |variable: &String| !setup.connections.iter().any(|(_, to)| to == variable);
    let programs: BTreeMap<String, Manifest> =
        setup.members.iter().filter_map(|of| Some((of.name.clone(), home.program(&of.fmu)?))).collect();
    let member = |of: &Member| run::system::Member {
        name: of.name.clone(),
        path: programs.get(&of.name).map_or_else(|| format!("{}.fmu", of.fmu).into(), |of| of.sources[0].clone()),
    };
    let begun = begin_at_the_plant(home, &setup.members, &setup.connections);
    let at_start = begun.iter().flat_map(|member| {
        let full = move |(name, value): (&String, &Value)| (format!("{}.{name}", member.name), *value);
        member.values.iter().map(full)
    });
    let at_start =
        at_start.filter(|(variable, _)| is_free(variable)).map(|(variable, value)| set(variable, value, None));
    let events = record.events().events.into_iter().filter(|event| event.call < calls);
    let events = events.map(|event| set(event.variable, event.value, Some(record.time(event.call))));
    let connection = |(from, to): &(String, String)| Connection { from: from.clone(), to: to.clone(), place: None };
    System {
        members: setup.members.iter().map(member).collect(),
        settings: at_start.chain(events).collect(),
        connections: setup.connections.iter().map(connection).collect(),
        start: Some(record.time(0)),
        stop: Some(record.time(calls)),
        step: Some(record.step()),
        exchange: setup.exchange,
        no_events: true,
        programs,
        ..System::default()
    }
}

/// The columns needed to replay the run: the controller's mode, manual value, setpoint and process value, its inputs
/// that are not at their start values, and its settings that changed; and, for all members, the variables set during
/// the run.
fn acting(home: &dyn Home, record: &Record) -> Result<Vec<usize>> {
    let Some(controller) = record.setup().members.first() else { return Ok(Vec::new()) };
    let description = describe(home, &controller.fmu)?;
    let roles = &description.roles;
    let manual = roles.manual.iter().flat_map(|(switch, value)| [switch, value]);
    let needed: Vec<&String> = manual.chain(&roles.setpoint).chain(&roles.process_value).collect();
    let (trace, calls) = (record.trace(), record.trace().exact());
    let mut columns: Vec<usize> = Vec::new();
    for variable in &description.variables {
        if matches!(variable.role.as_str(), "output" | "local") {
            continue;
        }
        let Ok(column) = record.column(&format!("{}.{}", controller.name, variable.name)) else { continue };
        let mut values = trace.column(column, calls.clone());
        let first = values.next();
        let start = number_of(variable.start);
        let acts = values.any(|value| Some(value) != first)
            || variable.role == "input" && first.is_some_and(|first| first != start);
        if acts || needed.contains(&&variable.name) {
            columns.push(column);
        }
    }
    // Variables set only before the first call are part of the setup.
    let set = record.done().iter().filter(|done| done.call > calls.start).map(|done| done.column);
    columns.extend(set);
    columns.sort_unstable();
    columns.dedup();
    Ok(columns)
}

/// A run as CSV, in the format of `plcfmu run --out`.
fn csv(record: &Record, columns: &[usize]) -> Result<(Vec<u8>, Vec<String>)> {
    let trace = record.trace();
    let calls = trace.exact();
    let mut remarks = Vec::new();
    if calls.start > 0 {
        remarks.push(format!(
            "The calls before call {} ({:?} s) are stored only as an overview and are missing from the file.",
            calls.start,
            record.time(calls.start)
        ));
    }
    let mut content = Vec::new();
    let rows = calls.map(|call| (record.time(call), columns.iter().map(move |column| trace.get(*column, call))));
    write_csv(&mut content, columns.iter().map(|column| &record.columns()[*column]), rows)?;
    Ok((content, remarks))
}

#[cfg(test)]
mod tests;
