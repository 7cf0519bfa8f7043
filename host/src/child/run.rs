//! A whole run in one process: there is no message for a step.

use super::witness::Witnessed;
use super::{Channel, End, OWN, Prints, Starter, serve};
use crate::fmu::{Unpacked, ensure_runs};
use crate::machine::Failure;
use crate::package::Package;
use crate::simulation::Fmus;
use anyhow::{Context, Result, anyhow};
use run::dialog::{self, Roles};
use run::master;
use run::plan::Plan;
use run::system::System;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;
use std::path::Path;

/// The role of the process.
pub const ROLE: &str = "run";

/// This many bytes of rows are in a message, at least.
const PIECE: usize = 1 << 16;

#[derive(Deserialize, Serialize)]
struct Request {
    /// The system as JSON.
    system: String,
    /// Whether all rows are sent, or the last one alone.
    wants_rows: bool,
}

#[derive(Deserialize, Serialize)]
enum Reply {
    /// The run begins: what the variables of each member are in a loop, if it says so.
    Began(Vec<Option<Roles>>),
    /// The next rows, each the time and the values of 8 bytes.
    Rows(ByteBuf),
    /// The run is over: what FMUs have logged, with their names, and which FMU ended it before its time, or why it failed.
    Over { messages: Vec<(String, String)>, ended: Result<Option<String>, Failure> },
}

/// What becomes of the rows of a run.
pub trait Rows {
    /// Whether all rows are needed, or the last one alone.
    fn are_wanted(&self) -> bool;

    /// The run begins; `roles` are what the variables of each member are in a loop, if it says so.
    fn begin(&mut self, roles: Vec<Option<Roles>>);

    /// Takes the next row: the time in seconds, and the values of the plan's columns, as `Type::cell` says.
    ///
    /// # Errors
    /// It cannot be taken: the run ends.
    fn take(&mut self, time: f64, row: &[f64]) -> Result<()>;
}

/// A run that is over, or that an FMU has ended.
#[derive(Debug)]
pub struct Finished {
    /// What FMUs have logged, with their names; errors are part of the error already.
    pub messages: Vec<(String, String)>,
    /// How many steps were made.
    pub steps: usize,
    /// Which FMU ended the run before its time, and when; else which FMU refused what or crashed, when, and its messages.
    pub ended: Result<Option<String>>,
}

/// Checks a system against the descriptions of its FMUs. None of their code runs.
///
/// # Errors
/// What is wrong with which FMU, name, value, connection or time, and what to do.
pub fn plan(system: &System) -> Result<Plan> {
    let open = |path: &Path| {
        let package = Package::open(path).with_context(|| path.display().to_string())?;
        ensure_runs(&package.description).with_context(|| path.display().to_string())?;
        anyhow::Ok(package)
    };
    let descriptions = system.members.iter().map(|member| Ok(open(&member.path)?.description));
    let descriptions = descriptions.collect::<Result<Vec<_>>>()?;
    Plan::of(system, &descriptions.iter().collect::<Vec<_>>())
}

/// Runs a system in a process of its own. The limit of `starter` is for one call of an FMU. `progress` gets the number of
/// steps that are made, now and then.
///
/// # Errors
/// The process cannot be started, there is an interruption, or a row cannot be taken.
pub fn run(
    starter: &Starter,
    system: &System,
    plan: &Plan,
    rows: &mut impl Rows,
    mut progress: impl FnMut(usize),
) -> Result<Finished> {
    let mut process = starter.start(ROLE, Prints::Shown)?;
    process.send(&Request { system: serde_json::to_string(system)?, wants_rows: rows.are_wanted() });
    let mut calls = 0;
    loop {
        let reply = process.receive(|witness| {
            progress(witness.steps());
            std::mem::replace(&mut calls, witness.calls()) != calls
        });
        match reply {
            Ok(Reply::Began(roles)) => rows.begin(roles),
            Ok(Reply::Rows(bytes)) => {
                progress(process.witness.steps());
                let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
                for row in numbers.chunks_exact(plan.columns.len() + 1) {
                    rows.take(row[0], &row[1..])?;
                }
            }
            Ok(Reply::Over { messages, ended }) => {
                let steps = process.witness.steps();
                return Ok(Finished { messages, steps, ended: ended.map_err(Failure::into_error) });
            }
            Err(End::Interrupted) => return Err(anyhow!("interrupted")),
            Err(End::Ended(what)) => {
                let name = process.witness.member().and_then(|at| system.members.get(at)).map(|of| of.name.as_str());
                let (time, words) = (plan.time(process.witness.steps()), process.last_words(name));
                let error = match name {
                    Some(name) => anyhow!("{name}: at {time:?} s, the FMU {what}{words}"),
                    None => anyhow!("at {time:?} s, {OWN} {what}{words}"),
                };
                return Ok(Finished { messages: Vec::new(), steps: process.witness.steps(), ended: Err(error) });
            }
        }
    }
}

/// The other side.
///
/// # Errors
/// The other side has ended.
pub fn child(folder: &Path) -> Result<()> {
    serve(folder, |channel| {
        let Some(request) = channel.next::<Request>()? else { return Ok(()) };
        channel.tell_messages();
        let mut messages = Vec::new();
        let system = serde_json::from_str(&request.system)?;
        let ended = simulate(channel, &system, request.wants_rows, &mut messages).map_err(Failure::from);
        channel.send(&Reply::Over { messages, ended })
    })
}

fn simulate(
    channel: &Channel,
    system: &System,
    wants_rows: bool,
    messages: &mut Vec<(String, String)>,
) -> Result<Option<String>> {
    let witness = &channel.witness;
    let fmus = Fmus::open(system, |path| {
        let member = system.members.iter().position(|member| member.path == path).unwrap_or_default();
        let unpacked = Package::open(path).and_then(|mut package| Unpacked::new(&mut package, &channel.folder));
        // The initialisers of the library run, and may crash.
        witness.call(member);
        let fmu = unpacked.and_then(Unpacked::load).with_context(|| path.display().to_string());
        witness.clear();
        fmu
    })?;
    let plan = Plan::of(system, &fmus.descriptions())?;
    let instances = (0..system.members.len()).map(|member| Witnessed::instantiate(&fmus, member, witness));
    let mut instances = instances.collect::<Result<Vec<_>>>()?;
    // A foreign FMU has no table and no roles.
    let roles = |member| fmus.of(member).table().and_then(|table| dialog::of(&table)).ok().map(|(roles, _)| roles);
    channel.send(&Reply::Began((0..system.members.len()).map(roles).collect()))?;
    let mut rows: Vec<u8> = Vec::with_capacity(PIECE);
    let mut give = |time: f64, row: &[f64]| {
        if !wants_rows {
            rows.clear();
        }
        rows.extend(std::iter::once(&time).chain(row).flat_map(|value| value.to_le_bytes()));
        if rows.len() < PIECE {
            return Ok(());
        }
        channel.send(&Reply::Rows(ByteBuf::from(std::mem::take(&mut rows))))
    };
    let ended = master::run_cells(&plan, &mut instances, |steps| witness.stepped(steps), &mut give);
    for (member, of) in system.members.iter().zip(&mut instances) {
        messages.extend(of.instance.take_messages().into_iter().map(|message| (member.name.clone(), message.text)));
    }
    if ended.is_ok() {
        channel.send(&Reply::Rows(ByteBuf::from(rows)))?;
    }
    ended
}
