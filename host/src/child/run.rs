//! A whole run in one process: there is no message for a step.

use super::witness::Witnessed;
use super::{Channel, End, Prints, Starter, serve};
use crate::fmu::Fmu;
use crate::package::Package;
use crate::simulation::Fmus;
use anyhow::{Context, Result, anyhow};
use run::master::{self, Recording};
use run::plan::Plan;
use run::system::System;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;
use std::path::Path;

/// The role of the process.
pub const ROLE: &str = "run";

/// The longest piece of a recording in a message, in bytes.
const PIECE: usize = 1 << 26;

#[derive(Deserialize, Serialize)]
enum Reply {
    /// The next bytes of the recording.
    Piece(ByteBuf),
    /// The run is over: what FMUs have logged, with their names, and why there is no recording.
    Over { messages: Vec<(String, String)>, error: Option<String> },
}

/// A run that is over, or that an FMU has ended.
#[derive(Debug)]
pub struct Finished {
    /// What FMUs have logged, with their names; errors are part of the error already.
    pub messages: Vec<(String, String)>,
    /// What was recorded; else which FMU refused what or crashed, when, and its messages.
    pub recording: Result<Recording>,
}

/// Checks a system against the descriptions of its FMUs. None of their code runs.
///
/// # Errors
/// What is wrong with which FMU, name, value, connection or time, and what to do.
pub fn plan(system: &System) -> Result<Plan> {
    let open = |path: &Path| Package::open(path).with_context(|| path.display().to_string());
    let descriptions = system.members.iter().map(|member| Ok(open(&member.path)?.description));
    let descriptions = descriptions.collect::<Result<Vec<_>>>()?;
    Plan::of(system, &descriptions.iter().collect::<Vec<_>>())
}

/// Runs a system in a process of its own. The limit of `starter` is for one call of an FMU. `progress` gets the number of
/// steps that are made, now and then.
///
/// # Errors
/// The process cannot be started, or there is an interruption.
pub fn run(starter: &Starter, system: &System, plan: &Plan, mut progress: impl FnMut(usize)) -> Result<Finished> {
    let mut process = starter.start(ROLE, Prints::Shown)?;
    process.send(&serde_json::to_string(system)?);
    let (mut bytes, mut calls) = (Vec::new(), 0);
    loop {
        let reply = process.receive(|witness| {
            progress(witness.steps());
            std::mem::replace(&mut calls, witness.calls()) != calls
        });
        match reply {
            Ok(Reply::Piece(piece)) => bytes.extend_from_slice(&piece),
            Ok(Reply::Over { messages, error: Some(error) }) => {
                return Ok(Finished { messages, recording: Err(anyhow!(error)) });
            }
            Ok(Reply::Over { messages, error: None }) => {
                return Ok(Finished { messages, recording: Ok(postcard::from_bytes(&bytes)?) });
            }
            Err(End::Interrupted) => return Err(anyhow!("interrupted")),
            Err(End::Ended(what)) => {
                let name = process.witness.member().and_then(|at| system.members.get(at)).map(|of| of.name.as_str());
                let (time, words) = (plan.time(process.witness.steps()), process.last_words(name));
                let error = anyhow!("{}: at {time:?} s, the FMU {what}{words}", name.unwrap_or("an FMU"));
                return Ok(Finished { messages: Vec::new(), recording: Err(error) });
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
        let Some(system) = channel.next::<String>()? else { return Ok(()) };
        channel.tell_messages();
        let mut messages = Vec::new();
        let error = match simulate(channel, &serde_json::from_str(&system)?, &mut messages) {
            Ok(recording) => {
                for piece in postcard::to_stdvec(&recording)?.chunks(PIECE) {
                    channel.send(&Reply::Piece(ByteBuf::from(piece)))?;
                }
                None
            }
            Err(error) => Some(format!("{error:#}")),
        };
        channel.send(&Reply::Over { messages, error })
    })
}

fn simulate(channel: &Channel, system: &System, messages: &mut Vec<(String, String)>) -> Result<Recording> {
    let witness = &channel.witness;
    let fmus = Fmus::open(system, |path| {
        let member = system.members.iter().position(|member| member.path == path).unwrap_or_default();
        witness.call(member);
        Fmu::load(&mut Package::open(path)?, &channel.folder).with_context(|| path.display().to_string())
    })?;
    let plan = Plan::of(system, &fmus.descriptions())?;
    let instances = (0..system.members.len()).map(|member| Witnessed::instantiate(&fmus, member, witness));
    let mut instances = instances.collect::<Result<Vec<_>>>()?;
    let recording = master::run(&plan, &mut instances, |steps| witness.stepped(steps));
    for (member, of) in system.members.iter().zip(&mut instances) {
        messages.extend(of.instance.take_messages().into_iter().map(|message| (member.name.clone(), message.text)));
    }
    recording
}
