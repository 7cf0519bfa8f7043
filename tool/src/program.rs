//! PLC programs: translates them to run like their FMUs, and reports their activity line by line.

mod decided;
mod kept;
mod project;
mod roles;

pub use kept::Programs;

use crate::describe::remedy;
use crate::home::Home;
use crate::message::{LoopRole, Program, Value, Values};
use crate::session::Session;
use anyhow::Result;
use fmu::cyclic::Cyclic;
use manifest::{Manifest, Task};
use modeldescription::{Interface, ModelDescription, Table, units};
use parameters::{Problems, Source};
use program::project::Parts;
use program::{Loaded, Wrong, survey};
use run::dialog::{Group, Roles};
use scl::watch::{self, CodeBlock};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The maximum number of problems reported.
const MOST_PROBLEMS: usize = 500;

/// The result of a translation.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Compiled {
    /// The name in the catalogue under which the program runs; `None` if it was rejected.
    pub fmu: Option<String>,
    /// The block to run.
    pub block: String,
    /// Errors if it was rejected, otherwise warnings, in the order of the sources.
    pub problems: Vec<Finding>,
    /// The blocks to choose from, if the block to run is ambiguous.
    pub candidates: Vec<String>,
    /// The time between two calls in seconds.
    pub cycle: f64,
    /// The origin of the cycle, if it was proposed from the sources; else empty.
    pub cycle_from: String,
    /// The texts of the sources.
    pub sources: Vec<SourceText>,
    /// The blocks with code, in the order of the sources.
    pub blocks: Vec<CodeBlock>,
    /// The declarations of data blocks and tags: name, 0-based index of the source, and line.
    pub declared: Vec<(String, usize, usize)>,
    /// The instances of blocks. The first is the program itself, whose path is empty.
    pub parts: Vec<Instance>,
    /// A table that summarizes the project's files and missing parts: name and text of each row. Empty for a single
    /// source.
    pub survey: Vec<(String, String)>,
    /// If the program was rejected: assumptions about undeclared names under which it might be accepted.
    pub assumptions: Vec<Assumption>,
}

/// A possible assumption about an undeclared name.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Assumption {
    /// The name.
    pub name: String,
    /// The assumption, in a sentence.
    pub what: String,
    /// The place of its first use: the source, and the line in it.
    pub place: Option<(String, usize)>,
    /// Its declaration in SCL.
    pub text: String,
}

/// A message about a place in a source.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Finding {
    /// The source's name; empty if the message concerns all sources.
    pub file: String,
    /// The 1-based line and column, if the message concerns a place in the source.
    pub place: Option<(usize, usize)>,
    /// The number of characters concerned in that line.
    pub length: usize,
    /// The problem.
    pub message: String,
    /// The remedy.
    pub help: Option<String>,
    /// Whether it is an error, which prevents the program from running.
    pub is_error: bool,
}

/// A source as text.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SourceText {
    /// Its name.
    pub file: String,
    /// Its text.
    pub text: String,
}

/// An instance of a block.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Instance {
    /// Its path in the FMU's variable names, such as `motors[1]`; empty for the program itself.
    pub path: String,
    /// Its block.
    pub block: String,
    /// Whether the block is a catalogue block rather than SCL code.
    pub is_native: bool,
}

/// The activity of a program in a call, apart from the values of its variables, which belong to the state of the run.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Monitored {
    /// The program's temporary variables at the end of the call.
    pub temps: Values,
    /// Its STRINGs and WSTRINGs at the end of the call, which a run cannot record.
    pub texts: BTreeMap<String, String>,
    /// The executed lines, each with the 0-based index of its source.
    pub lines: Vec<(usize, usize)>,
    /// The program's warnings since its start, each with file and line.
    pub warnings: Vec<String>,
    /// The truth values in the networks of the requested block, by number. Values that were not calculated in the call
    /// are missing.
    pub wires: Vec<(u32, bool)>,
    /// For each block whose decisions were requested: the decisions for each of its writes.
    pub decided: Vec<Vec<decided::Decisions>>,
}

/// A program of the catalogue.
#[derive(Clone)]
pub struct Kept {
    name: String,
    manifest: Manifest,
    sources: Vec<Source>,
    loaded: Arc<Loaded>,
    table: Arc<Table>,
    description: Arc<modeldescription::Description>,
    /// The roles and groups inferred from its controller calls, if any.
    dialog: Option<(Roles, Vec<Group>)>,
    blocks: Arc<Vec<CodeBlock>>,
}

/// Translates the sources and, if there are no errors, adds the program to the catalogue. Problems in the sources are
/// part of the answer, not errors.
///
/// # Errors
/// A file is not Base64, a tag table is faulty, the files are too large or contain no source, or an option is invalid.
pub fn compile<H: Home>(home: &Programs<H>, request: &Program) -> Result<Compiled> {
    let parts = project::read(&request.files, &request.manifest)?;
    let Parts { sources, manifest, .. } = &parts;
    let blocks = Arc::new(watch::watched(sources));
    let (cycle, cycle_from) = match request.manifest.cycle {
        Some(cycle) => (cycle, String::new()),
        None => watch::proposed_cycle(&blocks),
    };
    let manifest = completed(manifest, sources, &blocks, cycle);
    let mut compiled = Compiled {
        cycle: f64::from(cycle) / 1000.0,
        cycle_from,
        blocks: blocks.to_vec(),
        declared: watch::declared_for_all(sources),
        sources: sources.iter().map(|of| SourceText { file: of.file.clone(), text: of.text.clone() }).collect(),
        ..Compiled::default()
    };
    if request.files.len() > 1 {
        let rows = survey::rows(&parts, "");
        compiled.survey = rows.into_iter().map(|(name, text)| (name.to_string(), text)).collect();
    }
    let loaded = match Loaded::watched(&manifest, sources, |unit| units::definition(unit).is_some()) {
        Ok(loaded) => loaded,
        Err(wrong) => {
            refuse(wrong, &mut compiled);
            compiled.assumptions = assumptions(sources, &manifest);
            return Ok(compiled);
        }
    };
    let sources = sources.clone();
    compiled.problems = findings(&loaded.warnings, false);
    compiled.block = loaded.block().to_string();
    compiled.parts = loaded
        .parts()
        .into_iter()
        .map(|of| Instance { path: of.path, block: of.block, is_native: of.is_native })
        .collect();
    let name = home.admit(loaded, |loaded, name| {
        // A changed program gets a new name. Its table must have the same name, because requests use it as the name of
        // the block.
        let table = Table { name: name.clone(), ..loaded.table.clone() };
        let dialog = roles::dialog(home, &table, &blocks, &compiled.parts);
        let interface = Interface::linked(table, &loaded.guid())?;
        let description = Arc::new(ModelDescription::from_interface(&interface)?.description());
        let table = Arc::new(interface.table);
        Ok(Kept { name, manifest, sources, loaded, table, description, dialog, blocks: blocks.clone() })
    })?;
    compiled.fmu = Some(name);
    Ok(compiled)
}

/// The blocks of interest, each with the path of its instance; the path is empty for a function.
#[derive(Clone, Copy, Debug)]
pub struct Looked<'a> {
    /// The block whose networks are displayed.
    pub networks: Option<&'a (String, String)>,
    /// The blocks whose decisions are requested.
    pub why: &'a [(String, String)],
}

/// The activity of a program in the loop during its last or an earlier call.
///
/// # Errors
/// No program runs under this name; the run has no such call, or too many calls precede it.
pub fn monitor<H: Home>(
    home: &Programs<H>,
    session: &Session,
    member: &str,
    call: Option<usize>,
    looked: Looked,
) -> Result<Monitored> {
    match call {
        None => last_call(home, member, looked),
        Some(call) => home.beside(|| {
            session.again_up_to(home, call)?;
            last_call(home, member, looked)
        }),
    }
}

fn last_call<H: Home>(home: &Programs<H>, member: &str, looked: Looked) -> Result<Monitored> {
    home.with_running(member, |program, warnings, blocks| Monitored {
        wires: looked.networks.map(|(block, path)| program.wires(block, path)).unwrap_or_default(),
        decided: looked.why.iter().map(|(block, path)| decided::decisions(program, blocks, block, path)).collect(),
        texts: program
            .table()
            .texts
            .iter()
            .enumerate()
            .filter_map(|(number, text)| Some((text.name.clone(), program.text(number)?)))
            .collect(),
        temps: program
            .temps()
            .into_iter()
            .map(|(name, value)| {
                let shown = match value.ty() {
                    scl::ir::Scalar::Bool => Value::Boolean(value.bits() != 0),
                    _ => Value::Number(value.number()),
                };
                (name.to_string(), shown)
            })
            .collect(),
        lines: program.lines().into_iter().map(|(file, line)| (file, line as usize)).collect(),
        warnings: warnings.to_vec(),
    })
}

/// The manifest with the names of the sources and the cycle. An organization block chosen as the block to run becomes a
/// call.
fn completed(manifest: &Manifest, sources: &[Source], blocks: &[CodeBlock], cycle: u32) -> Manifest {
    let is_organization =
        |name: &String| blocks.iter().any(|block| block.is_organization && block.name.eq_ignore_ascii_case(name));
    let (called, block) = manifest.block.clone().map_or((None, None), |name| match is_organization(&name) {
        true => (Some(Task { name, period: 0 }), None),
        false => (None, Some(name)),
    });
    Manifest {
        sources: sources.iter().map(|source| source.file.clone().into()).collect(),
        cycle: Some(cycle),
        calls: called.into_iter().chain(manifest.calls.iter().cloned()).collect(),
        block,
        ..manifest.clone()
    }
}

/// Possible assumptions about undeclared names.
fn assumptions(sources: &[Source], manifest: &Manifest) -> Vec<Assumption> {
    let of = |of: scl::Assumption| {
        let source = sources.get(of.at.0 as usize);
        let line = source.map(|source| source.place(of.at.1 as usize..of.at.1 as usize).line);
        let place = source.map(|source| source.file.clone()).zip(line);
        Assumption { name: of.name, what: of.what, place, text: of.text }
    };
    scl::assume(sources, manifest, None).into_iter().map(of).collect()
}

fn refuse(wrong: Wrong, compiled: &mut Compiled) {
    let about_all = |message: String, help: Option<&str>| Finding {
        message,
        help: help.map(str::to_string),
        is_error: true,
        ..Finding::default()
    };
    compiled.problems = match wrong {
        Wrong::Sources(problems) => findings(&problems, true),
        Wrong::Choice { blocks: candidates, .. } if candidates.len() > 1 => {
            let message = format!("several blocks are not called by any other: {}", candidates.join(", "));
            compiled.candidates = candidates;
            vec![about_all(message, Some("choose the one to run"))]
        }
        other => vec![about_all(other.to_string(), None)],
    };
}

fn findings(problems: &[Problems], is_error: bool) -> Vec<Finding> {
    let of_file = |problems: &Problems| {
        let finding = |of: &parameters::Problem| {
            let about = of.place.as_ref().and_then(|place| problems.text.get(place.span.clone())).unwrap_or_default();
            Finding {
                file: problems.file.clone(),
                place: of.place.as_ref().map(|place| (place.line, place.column)),
                length: about.lines().next().unwrap_or_default().chars().count(),
                message: of.message.clone(),
                help: of.help.as_ref().map(remedy),
                is_error,
            }
        };
        problems.problems.iter().map(finding).collect::<Vec<_>>()
    };
    problems.iter().flat_map(of_file).take(MOST_PROBLEMS).collect()
}

impl Kept {
    /// Its role in a loop: a program drives the other members.
    fn part(&self) -> LoopRole {
        LoopRole::Controller
    }
}

#[cfg(test)]
mod tests;
