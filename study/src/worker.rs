//! A process that makes runs: what `plcfmu study-worker FOLDER` does until its input ends.
//!
//! ```text
//! Pool --Request--> standard input  of the worker --Experiment, Executor--> Instances
//!      <--Reply---- standard output
//! ```
//!
//! The messages of [`framing`] are in the format of postcard. There is one thread for the FMUs. Rows are sent
//! a few milliseconds after they were made at the latest, so that a crash loses few of them.

use crate::Job;
use crate::experiment::{Executor, Experiment};
use crate::results::Row;
use anyhow::{Context, Result, bail};
use host::fmu::{Fmu, has_table};
use host::framing;
use host::instance::Instance;
use host::package::Package;
use host::simulation::Fmus;
use host::standard_output;
use modeldescription::Table;
use modeldescription::{Description, Interface};
use run::component::{Component, Reset, Type};
use run::dialog;
use run::master::Recording;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// The hidden command.
pub const COMMAND: &str = "study-worker";

/// How long rows wait for others before they are sent.
pub const FLUSH: Duration = Duration::from_millis(2);

/// What a worker is to do. The first request is [`Request::Begin`].
#[derive(Debug, Deserialize, Serialize)]
pub enum Request {
    /// Load the FMUs.
    Begin {
        /// The [`Job`] as JSON.
        job: String,
        /// Say before each call which FMU is called. This takes much longer.
        announces: bool,
        /// Make each run with new instances.
        renews: bool,
    },
    /// Make the runs of these points.
    Rows(Vec<Vec<f64>>),
    /// Find out whether an instance that was reset computes what a new one does.
    CheckReset,
    /// Make the run of this point and record it.
    Curve(Vec<f64>),
}

/// What a worker answers.
#[derive(Debug, Deserialize, Serialize)]
pub enum Reply {
    /// From now on a member is called, until another is named.
    At(u32),
    /// The FMUs are loaded; for each member what its library says of its block, if it has a table, as JSON.
    Ready(Vec<Option<String>>),
    /// What is wrong with the job, or why a curve cannot be made.
    Refused(String),
    /// The next rows, in the order of the points. All have come when there are as many as points.
    Rows(Vec<Row>),
    /// The recording.
    Curve(Recording),
    /// What the user should know of instances that are reset.
    Reset(Option<String>),
}

/// The table of a library, as it says it in [`Reply::Ready`].
///
/// # Errors
/// It is damaged.
pub fn table(interface: &str) -> Result<Table> {
    Ok(Interface::parse(interface)?.table)
}

/// The experiment of a job: the same in the worker and in the process that hands out the points.
///
/// # Errors
/// What is wrong with the job.
pub fn experiment(job: &Job, descriptions: &[&Description], table: Option<&Table>) -> Result<Experiment> {
    let roles = table.map(dialog::of).transpose()?.map(|(roles, _)| roles);
    Experiment::of(job, descriptions, roles.as_ref())
}

/// The options of the hidden command.
#[derive(clap::Args, Clone, Debug)]
pub struct Options {
    /// Where the FMUs are unpacked
    folder: PathBuf,
}

/// Makes runs as it is told on standard input.
///
/// # Errors
/// There is no standard output, or the other side has ended.
pub fn run(options: &Options) -> Result<()> {
    let output = Output(Rc::new(RefCell::new((standard_output::take().context("standard output")?, None))));
    let (messages, at_work) = framing::input();
    let mut messages = messages.into_iter().map(|message| Ok(postcard::from_bytes::<Request>(&message)?));
    let Some(Request::Begin { job, announces, renews }) = messages.next().transpose()? else {
        bail!("there is no job")
    };
    match begin(&job, &options.folder, &output) {
        Err(error) => output.send(&Reply::Refused(format!("{error:#}")))?,
        Ok((fmus, experiment, interfaces)) => {
            output.send(&Reply::Ready(interfaces))?;
            let begin = Serving { experiment, renews, flush: if announces { Duration::ZERO } else { FLUSH } };
            if announces {
                let instantiate = |member: usize| {
                    output.at(member)?;
                    Ok(Announced { instance: fmus.instantiate(member)?, member, output: output.clone() })
                };
                begin.serve(messages, &output, instantiate)?;
            } else {
                let instantiate = |member| fmus.instantiate(member);
                begin.serve(messages, &output, instantiate)?;
            }
        }
    }
    drop(output);
    // Without waiting for the thread that reads, which must not believe that this is over before.
    drop(at_work);
    process::exit(0)
}

/// Loads the FMUs and resolves the job.
fn begin(job: &str, folder: &Path, output: &Output) -> Result<(Fmus, Experiment, Vec<Option<String>>)> {
    let job: Job = serde_json::from_str(job)?;
    let mut interfaces = BTreeMap::new();
    let fmus = Fmus::open(&job.system, |path| {
        let mut load = || {
            let mut package = Package::open(path)?;
            // The initialisers of the library run, and may crash.
            let member = job.system.members.iter().position(|member| member.path == path);
            output.at(member.unwrap_or_default())?;
            let tells = has_table(&mut package)?;
            let fmu = Fmu::load(&mut package, folder)?;
            if tells {
                interfaces.insert(path.to_path_buf(), fmu.library.interface()?);
            }
            Ok(fmu)
        };
        let fmu: Result<Fmu> = load();
        fmu.with_context(|| path.display().to_string())
    })?;
    let interfaces: Vec<_> = job.system.members.iter().map(|member| interfaces.get(&member.path).cloned()).collect();
    let table = interfaces.first().and_then(Option::as_deref).map(table).transpose()?;
    let experiment = experiment(&job, &fmus.descriptions(), table.as_ref())?;
    Ok((fmus, experiment, interfaces))
}

/// How requests are answered.
struct Serving {
    experiment: Experiment,
    renews: bool,
    /// How long rows wait for others. They do not while calls are announced: the other side then knows which run is under way.
    flush: Duration,
}

impl Serving {
    /// Answers the requests, until there are no more.
    fn serve<C: Reset>(
        self,
        requests: impl Iterator<Item = Result<Request>>,
        output: &Output,
        mut instantiate: impl FnMut(usize) -> Result<C>,
    ) -> Result<()> {
        let mut executor = Executor::new(self.experiment);
        if self.renews {
            executor.renew();
        }
        for request in requests {
            match request? {
                Request::Begin { .. } => bail!("there is a job already"),
                Request::CheckReset => output.send(&Reply::Reset(executor.check_reset(&mut instantiate)))?,
                Request::Curve(point) => match executor.recording(&point, &mut instantiate) {
                    Ok(recording) => output.send(&Reply::Curve(recording))?,
                    Err(error) => output.send(&Reply::Refused(format!("{error:#}")))?,
                },
                Request::Rows(points) => {
                    let (mut rows, mut flushed) = (Vec::new(), Instant::now());
                    for point in &points {
                        rows.push(executor.row(point, &mut instantiate));
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

/// Where replies go, with the member that was announced last.
#[derive(Clone, Debug)]
struct Output(Rc<RefCell<(File, Option<usize>)>>);

impl Output {
    fn send(&self, reply: &Reply) -> Result<()> {
        Ok(framing::send(&mut self.0.borrow_mut().0, &postcard::to_stdvec(reply)?)?)
    }

    /// Announces that a member is called.
    fn at(&self, member: usize) -> Result<()> {
        let last = self.0.borrow_mut().1.replace(member);
        if last != Some(member) {
            self.send(&Reply::At(u32::try_from(member)?))?;
        }
        Ok(())
    }
}

/// An instance whose calls are announced, so that the other side knows which FMU has crashed.
#[derive(Debug)]
struct Announced {
    instance: Instance,
    member: usize,
    output: Output,
}

impl Announced {
    fn called(&mut self) -> Result<&mut Instance> {
        self.output.at(self.member)?;
        Ok(&mut self.instance)
    }
}

impl Component for Announced {
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.called()?.setup(start, stop)
    }

    fn enter_initialization(&mut self) -> Result<()> {
        self.called()?.enter_initialization()
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.called()?.exit_initialization()
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.called()?.get_all(kind, references, values)
    }

    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        self.called()?.set_all(kind, references, values)
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        self.called()?.step(time, size)
    }

    fn terminate(&mut self) -> Result<()> {
        self.called()?.terminate()
    }
}

impl Reset for Announced {
    fn reset(&mut self) -> Result<()> {
        self.called()?.reset()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_their_bits_on_their_way() {
        let row = Row { figures: vec![f64::NAN, -0.0, 0.1], error: Some("PUMP: dry".into()) };
        let bytes = postcard::to_stdvec(&Reply::Rows(vec![row.clone()])).unwrap();
        let Reply::Rows(rows) = postcard::from_bytes(&bytes).unwrap() else { panic!() };
        let bits = |row: &Row| row.figures.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!((bits(&rows[0]), &rows[0].error), (bits(&row), &row.error));
    }
}
