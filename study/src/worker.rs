//! A process that executes runs, in the role [`ROLE`] of [`host::child`].
//!
//! ```text
//! Pool --Request--> standard input  of the worker --Experiment, Executor--> Instances
//!      <--Reply---- standard output
//! ```
//!
//! All FMUs run in the same thread. Rows are sent within a few milliseconds, so that a crash loses few of them.

use crate::Job;
use crate::experiment::{Detail, Executor, Experiment, Gives};
use crate::results::RunResult;
use anyhow::{Context, Error, Result, bail};
use host::child::witness::Witnessed;
use host::child::{Channel, serve};
use host::fmu::{Fmu, Unpacked, has_table, has_text};
use host::package::Package;
use host::simulation::Fmus;
use modeldescription::Table;
use modeldescription::{Description, Interface};
use run::component::Reset;
use run::dialog;
use run::master::Recording;
use run::plan::has_events;
use run::subject::Subject;
use run::system::Member;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{Duration, Instant};

/// The role of the process.
pub const ROLE: &str = "worker";

/// The time for which finished rows are collected before they are sent.
pub const FLUSH: Duration = Duration::from_millis(2);

/// The maximum number of runs of linked blocks executed side by side.
pub const ABREAST: usize = blocks::table::abreast::LANES;

/// The approximate maximum number of values recorded by all runs executed side by side.
const MOST_RECORDED: usize = 1 << 23;

/// A request to a worker. The first one is [`WorkerRequest::Begin`].
#[derive(Debug, Deserialize, Serialize)]
pub enum WorkerRequest {
    /// Load the FMUs.
    Begin {
        /// The [`Job`] as JSON.
        job: String,
        /// Whether each row is sent immediately, so that the main process knows which run is in progress.
        is_prompt: bool,
        /// Whether each run uses new instances.
        renews: bool,
        /// Whether FMUs are called through their C interface even if this program has them [`Linked`].
        exact_door: bool,
    },
    /// Execute the runs of these points.
    Rows(Vec<Vec<f64>>, Gives),
    /// Check whether a reset instance computes the same results as a new one.
    CheckReset,
    /// Execute the run of this point with new instances and record it.
    Curve(Vec<f64>, Detail),
}

/// The block of an FMU, linked into this program. If the FMU's library was compiled from the same code, an instance
/// computes the same bits as one called through the C interface, and fails with the same messages.
#[derive(Clone, Debug)]
pub struct Linked {
    /// Its table.
    pub table: Table,
    /// The description in the FMU's library as JSON, see [`Ready::interfaces`].
    pub interface: String,
    /// The hash of the code from which the block was compiled, if known. A library that contains the same hash computes
    /// the same bits; the GUID alone does not show that, since it does not cover the law.
    pub code: Option<&'static str>,
    /// Creates an instance with a name.
    pub instantiate: fn(&str) -> Result<Box<dyn Reset>>,
}

/// Finds the linked block that has the same variables as an FMU, if there is one.
pub type Find = fn(&Description) -> Option<Linked>;

/// A reply of a worker.
#[derive(Debug, Deserialize, Serialize)]
pub enum Reply {
    /// The FMUs are loaded.
    Ready(Ready),
    /// The job is faulty, or a curve cannot be recorded: the message, and its subject.
    Refused(String, Option<Subject>),
    /// The next rows, in the order of the points. A request is answered when each of its points has a row.
    Rows(Vec<RunResult>),
    /// The next piece of the recording.
    Piece(Recording),
    /// The recording is complete. Contains the figures of the run, unless an FMU ended it.
    Curve(Option<Vec<f64>>),
    /// Answers [`WorkerRequest::CheckReset`]: a warning for the user if the results differ.
    Reset(Option<String>),
}

impl Reply {
    fn refused(error: &Error) -> Reply {
        Reply::Refused(format!("{error:#}"), Subject::find(error).cloned())
    }
}

/// Information about the loaded FMUs.
#[derive(Debug, Deserialize, Serialize)]
pub struct Ready {
    /// For each member, the block description in its library as JSON, if it has a table.
    pub interfaces: Vec<Option<String>>,
    /// A warning for the user.
    pub warning: Option<String>,
}

/// Parses the table of a library from [`Ready`].
///
/// # Errors
/// It is damaged.
pub fn table(interface: &str) -> Result<Table> {
    Ok(Interface::parse(interface)?.table)
}

/// Creates the experiment of a job; it is identical in the worker and in the process that distributes the points.
///
/// # Errors
/// The job is faulty.
pub fn experiment(job: &Job, descriptions: &[&Description], table: Option<&Table>) -> Result<Experiment> {
    let roles = table.map(dialog::read).transpose()?.map(|(roles, _)| roles);
    Experiment::new(job, descriptions, roles.as_ref())
}

/// Executes the runs requested on standard input, with the FMUs unpacked in `folder`. If `find` returns a block for
/// every FMU of a loop, the loop runs in this process without their libraries.
///
/// # Errors
/// Standard output is missing, or the main process has ended.
pub fn run(folder: &Path, find: Find) -> Result<()> {
    serve(folder, |channel| {
        let Some(WorkerRequest::Begin { job, is_prompt, renews, exact_door }) = channel.next()? else {
            bail!("no job")
        };
        let Begun { members, experiment, ready } = match begin(&job, channel, find, exact_door) {
            Err(error) => return channel.send(&Reply::refused(&error)),
            Ok(begun) => begun,
        };
        channel.send(&Reply::Ready(ready))?;
        let flush = if is_prompt { Duration::ZERO } else { FLUSH };
        let is_linked = matches!(members, Members::Linked(_));
        let recorded = experiment.plan.steps.saturating_mul(experiment.plan.columns.len()).max(1);
        let abreast = if is_linked && !is_prompt { (MOST_RECORDED / recorded).clamp(1, ABREAST) } else { 1 };
        let serving = Serving { experiment, renews, flush, abreast };
        match members {
            Members::Linked(members) => {
                let instantiate = |member: usize| {
                    let (name, of): &Named = &members[member];
                    (of.instantiate)(name).with_context(|| name.clone())
                };
                serving.serve(channel, instantiate)
            }
            Members::Loaded(fmus) => {
                serving.serve(channel, |member| Witnessed::instantiate(&fmus, member, &channel.witness))
            }
        }
    })
}

/// The state of a worker that is ready to execute runs.
struct Begun {
    members: Members,
    experiment: Experiment,
    ready: Ready,
}

/// A member's name, and its linked block.
type Named = (String, Linked);

/// The implementation of the loop's members.
enum Members {
    /// Blocks linked into this program.
    Linked(Vec<Named>),
    /// FMUs with their libraries.
    Loaded(Fmus),
}

/// Resolves the job. Its FMUs are loaded unless all of them are linked.
fn begin(job: &str, channel: &Channel, find: Find, exact_door: bool) -> Result<Begun> {
    let job: Job = serde_json::from_str(job)?;
    let linked = if exact_door { None } else { linked(&job, find) };
    let others: BTreeSet<&str> = linked.iter().flatten().filter(|of| !of.is_same).map(|of| of.file.as_str()).collect();
    let warning = (!others.is_empty()).then(|| of_other_code(&Vec::from_iter(others)));
    let Some(linked) = linked.filter(|_| warning.is_none()) else {
        let (fmus, experiment, interfaces) = load(&job, channel)?;
        return Ok(Begun { members: Members::Loaded(fmus), experiment, ready: Ready { interfaces, warning } });
    };
    let interfaces: Vec<_> = linked.iter().map(|of| Some(of.block.interface.clone())).collect();
    let table = linked.first().map(|of| &of.block.table);
    let descriptions: Vec<&Description> = linked.iter().map(|of| &of.description).collect();
    let experiment = experiment(&job, &descriptions, table)?;
    let members = job.system.members.into_iter().zip(linked).map(|(member, of)| (member.name, of.block)).collect();
    Ok(Begun { members: Members::Linked(members), experiment, ready: Ready { interfaces, warning } })
}

/// A warning about files whose blocks are linked into this program from different code.
fn of_other_code(files: &[&str]) -> String {
    let (files, are, their, them) = match files {
        [file] => ((*file).to_string(), "is", "its law", "it"),
        files => (files.join(", "), "are", "their laws", "them"),
    };
    format!(
        "{files} {are} not built from the sources of this plcfmu, so {their} may differ: the study calls the libraries of the FMUs, \
         which takes longer; pack {them} again, or pass --exact-door to call the libraries without this warning"
    )
}

/// A member whose block, or one with the same variables, is linked into this program.
struct Candidate {
    /// The name of the FMU's file.
    file: String,
    block: Linked,
    description: Description,
    /// Whether the FMU's library is compiled from the same code.
    is_same: bool,
}

/// The members with their linked blocks; `None` unless every member has one. Problems with a file are reported when it
/// is loaded.
fn linked(job: &Job, find: Find) -> Option<Vec<Candidate>> {
    let member = |member: &Member| {
        let mut package = Package::open(&member.path).ok()?;
        // Linked blocks do not support Event Mode.
        let has_events = !job.system.no_events && has_events(&package.description);
        let block = find(&package.description).filter(|_| !has_events)?;
        let is_same = block.code.is_some_and(|code| has_text(&mut package, code).unwrap_or(false));
        let file = member.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Some(Candidate { file, block, description: package.description, is_same })
    };
    job.system.members.iter().map(member).collect()
}

/// Loads the FMUs and resolves the job.
fn load(job: &Job, channel: &Channel) -> Result<(Fmus, Experiment, Vec<Option<String>>)> {
    let mut interfaces = BTreeMap::new();
    let fmus = Fmus::open(&job.system, |path| {
        let mut load = || {
            let mut package = Package::open(path)?;
            let tells = has_table(&mut package)?;
            let unpacked = Unpacked::new(&mut package, &channel.folder)?;
            // The library's initializers run here, and may crash.
            let member = job.system.members.iter().position(|member| member.path == path);
            channel.witness.call(member.unwrap_or_default());
            let fmu = unpacked.load()?;
            if tells {
                interfaces.insert(path.to_path_buf(), fmu.library.interface()?);
            }
            channel.witness.clear();
            Ok(fmu)
        };
        let fmu: Result<Fmu> = load();
        fmu.with_context(|| path.display().to_string())
    })?;
    let interfaces: Vec<_> = job.system.members.iter().map(|member| interfaces.get(&member.path).cloned()).collect();
    let table = interfaces.first().and_then(Option::as_deref).map(table).transpose()?;
    let experiment = experiment(job, &fmus.descriptions(), table.as_ref())?;
    Ok((fmus, experiment, interfaces))
}

/// The state needed to answer requests.
struct Serving {
    experiment: Experiment,
    renews: bool,
    /// The time for which finished rows are collected before they are sent.
    flush: Duration,
    /// The number of runs executed side by side.
    abreast: usize,
}

impl Serving {
    /// Answers requests until the main process closes standard input.
    fn serve<C: Reset>(self, output: &Channel, mut instantiate: impl FnMut(usize) -> Result<C>) -> Result<()> {
        let mut executor = Executor::new(self.experiment);
        if self.renews {
            executor.renew();
        }
        while let Some(request) = output.next()? {
            match request {
                WorkerRequest::Begin { .. } => bail!("a job has already been given"),
                WorkerRequest::CheckReset => output.send(&Reply::Reset(executor.check_reset(&mut instantiate)))?,
                WorkerRequest::Curve(point, detail) => {
                    let made = executor
                        .recording(&point, detail, &mut instantiate, |recording| output.send(&Reply::Piece(recording)));
                    match made {
                        Ok(figures) => output.send(&Reply::Curve(figures))?,
                        Err(error) => output.send(&Reply::refused(&error))?,
                    }
                }
                WorkerRequest::Rows(points, gives) => {
                    let (mut rows, mut flushed) = (Vec::new(), Instant::now());
                    for points in points.chunks(self.abreast) {
                        rows.extend(executor.rows(points, gives, &mut instantiate));
                        if flushed.elapsed() >= self.flush {
                            output.send(&Reply::Rows(std::mem::take(&mut rows)))?;
                            flushed = Instant::now();
                        }
                    }
                    if !rows.is_empty() {
                        output.send(&Reply::Rows(rows))?;
                    }
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_their_bits_on_their_way() {
        let row = RunResult { figures: vec![f64::NAN, -0.0, 0.1], error: Some("PUMP: dry".into()) };
        let bytes = postcard::to_stdvec(&Reply::Rows(vec![row.clone()])).unwrap();
        let Reply::Rows(rows) = postcard::from_bytes(&bytes).unwrap() else { panic!() };
        let bits = |row: &RunResult| row.figures.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!((bits(&rows[0]), &rows[0].error), (bits(&row), &row.error));
    }
}
