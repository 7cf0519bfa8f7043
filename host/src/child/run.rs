//! A complete run in a child process, without a message for each step.

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

/// Rows are sent when they fill at least this many bytes, and at the end of the run.
const PIECE: usize = 1 << 16;

#[derive(Deserialize, Serialize)]
struct Request {
    /// The system as JSON.
    system: String,
    /// Whether all rows are sent, or only the last one.
    wants_rows: bool,
}

#[derive(Deserialize, Serialize)]
enum Reply {
    /// The run has started. For each member: the roles of its variables in a control loop, if known.
    Began(Vec<Option<Roles>>),
    /// The next rows, each consisting of the time and the values, as little-endian 64-bit floating-point numbers.
    Rows(ByteBuf),
    /// The run is over: the messages logged by FMUs, each with the FMU's name, and which FMU ended the run early, if
    /// any, or why the run failed.
    Over { messages: Vec<(String, String)>, ended: Result<Option<String>, Failure> },
}

/// A receiver of the rows of a run.
pub trait Rows {
    /// Whether all rows are needed, or only the last one.
    fn are_wanted(&self) -> bool;

    /// Called when the run starts. For each member, `roles` contains the roles of its variables in a control loop, if
    /// known.
    fn begin(&mut self, roles: Vec<Option<Roles>>);

    /// Receives the next row: the time in seconds, and the values of the plan's columns as cells (`Type::cell`).
    ///
    /// # Errors
    /// The row cannot be processed; the run ends.
    fn take(&mut self, time: f64, row: &[f64]) -> Result<()>;
}

/// A run that was completed, ended early or failed.
#[derive(Debug)]
pub struct Finished {
    /// The messages logged by FMUs, each with the FMU's name, unless they are already part of the error.
    pub messages: Vec<(String, String)>,
    /// The number of completed steps.
    pub steps: usize,
    /// Which FMU ended the run early and when, `None` if the run was completed; or an error that states which FMU
    /// failed, when, and its messages.
    pub ended: Result<Option<String>>,
}

/// Checks a system against the descriptions of its FMUs, without running their code.
///
/// # Errors
/// An FMU, name, value, connection or time is wrong; the message states the remedy.
pub fn plan(system: &System) -> Result<Plan> {
    let open = |path: &Path| {
        let package = Package::open(path).with_context(|| path.display().to_string())?;
        ensure_runs(&package.description).with_context(|| path.display().to_string())?;
        anyhow::Ok(package)
    };
    let descriptions = system.members.iter().map(|member| Ok(open(&member.path)?.description));
    let descriptions = descriptions.collect::<Result<Vec<_>>>()?;
    Plan::new(system, &descriptions.iter().collect::<Vec<_>>())
}

/// Runs a system in a separate process. The limit of `starter` applies to one call of an FMU. `progress` periodically
/// receives the number of completed steps.
///
/// # Errors
/// The process cannot be started, the user interrupts the run, or a row cannot be processed.
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

/// Runs in the child process: receives a system, runs it and sends the rows.
///
/// # Errors
/// The request is invalid, or the other side has ended.
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
        // Loading a library runs its initializers, which may crash.
        witness.call(member);
        let fmu = unpacked.and_then(Unpacked::load).with_context(|| path.display().to_string());
        witness.clear();
        fmu
    })?;
    let plan = Plan::new(system, &fmus.descriptions())?;
    let instances = (0..system.members.len()).map(|member| Witnessed::instantiate(&fmus, member, witness));
    let mut instances = instances.collect::<Result<Vec<_>>>()?;
    // An FMU from another tool has neither a table nor roles.
    let roles = |member| fmus.fmu(member).table().and_then(|table| dialog::read(&table)).ok().map(|(roles, _)| roles);
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
