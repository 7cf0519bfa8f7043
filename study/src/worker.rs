//! A process that makes runs, in the role [`ROLE`] of [`host::child`].
//!
//! ```text
//! Pool --Request--> standard input  of the worker --Experiment, Executor--> Instances
//!      <--Reply---- standard output
//! ```
//!
//! There is one thread for the FMUs. Rows are sent a few milliseconds after they were made at the latest, so that a crash loses
//! few of them.

use crate::Job;
use crate::experiment::{Detail, Executor, Experiment, Gives};
use crate::results::Row;
use anyhow::{Context, Result, bail};
use host::child::witness::Witnessed;
use host::child::{Channel, serve};
use host::fmu::{Fmu, has_table};
use host::package::Package;
use host::simulation::Fmus;
use modeldescription::Table;
use modeldescription::{Description, Interface};
use run::component::Reset;
use run::dialog;
use run::master::Recording;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// The role of the process.
pub const ROLE: &str = "worker";

/// How long rows wait for others before they are sent.
pub const FLUSH: Duration = Duration::from_millis(2);

/// What a worker is to do. The first request is [`Request::Begin`].
#[derive(Debug, Deserialize, Serialize)]
pub enum Request {
    /// Load the FMUs.
    Begin {
        /// The [`Job`] as JSON.
        job: String,
        /// Send each row at once, so that the other side knows which run is under way.
        is_prompt: bool,
        /// Make each run with new instances.
        renews: bool,
    },
    /// Make the runs of these points.
    Rows(Vec<Vec<f64>>, Gives),
    /// Find out whether an instance that was reset computes what a new one does.
    CheckReset,
    /// Make the run of this point and record it.
    Curve(Vec<f64>, Detail),
}

/// What a worker answers.
#[derive(Debug, Deserialize, Serialize)]
pub enum Reply {
    /// The FMUs are loaded; for each member what its library says of its block, if it has a table, as JSON.
    Ready(Vec<Option<String>>),
    /// What is wrong with the job, or why a curve cannot be made.
    Refused(String),
    /// The next rows, in the order of the points. All have come when there are as many as points.
    Rows(Vec<Row>),
    /// The next piece of the recording.
    Piece(Recording),
    /// The recording is complete. The figures of the run, unless an FMU has ended it.
    Curve(Option<Vec<f64>>),
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

/// Makes runs as it is told on standard input, with the FMUs unpacked in `folder`.
///
/// # Errors
/// There is no standard output, or the other side has ended.
pub fn run(folder: &Path) -> Result<()> {
    serve(folder, |channel| {
        let Some(Request::Begin { job, is_prompt, renews }) = channel.next()? else { bail!("there is no job") };
        let (fmus, experiment, interfaces) = match begin(&job, channel) {
            Err(error) => return channel.send(&Reply::Refused(format!("{error:#}"))),
            Ok(begun) => begun,
        };
        channel.send(&Reply::Ready(interfaces))?;
        let flush = if is_prompt { Duration::ZERO } else { FLUSH };
        let instantiate = |member| Witnessed::instantiate(&fmus, member, &channel.witness);
        Serving { experiment, renews, flush }.serve(channel, instantiate)
    })
}

/// Loads the FMUs and resolves the job.
fn begin(job: &str, channel: &Channel) -> Result<(Fmus, Experiment, Vec<Option<String>>)> {
    let job: Job = serde_json::from_str(job)?;
    let mut interfaces = BTreeMap::new();
    let fmus = Fmus::open(&job.system, |path| {
        let mut load = || {
            let mut package = Package::open(path)?;
            // The initialisers of the library run, and may crash.
            let member = job.system.members.iter().position(|member| member.path == path);
            channel.witness.call(member.unwrap_or_default());
            let tells = has_table(&mut package)?;
            let fmu = Fmu::load(&mut package, &channel.folder)?;
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
    /// How long rows wait for others.
    flush: Duration,
}

impl Serving {
    /// Answers the requests, until there are no more.
    fn serve<C: Reset>(self, output: &Channel, mut instantiate: impl FnMut(usize) -> Result<C>) -> Result<()> {
        let mut executor = Executor::new(self.experiment);
        if self.renews {
            executor.renew();
        }
        while let Some(request) = output.next()? {
            match request {
                Request::Begin { .. } => bail!("there is a job already"),
                Request::CheckReset => output.send(&Reply::Reset(executor.check_reset(&mut instantiate)))?,
                Request::Curve(point, detail) => {
                    let made = executor
                        .recording(&point, detail, &mut instantiate, |recording| output.send(&Reply::Piece(recording)));
                    match made {
                        Ok(figures) => output.send(&Reply::Curve(figures))?,
                        Err(error) => output.send(&Reply::Refused(format!("{error:#}")))?,
                    }
                }
                Request::Rows(points, gives) => {
                    let (mut rows, mut flushed) = (Vec::new(), Instant::now());
                    for point in &points {
                        rows.push(executor.row_of(point, gives, &mut instantiate));
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
        let row = Row { figures: vec![f64::NAN, -0.0, 0.1], error: Some("PUMP: dry".into()) };
        let bytes = postcard::to_stdvec(&Reply::Rows(vec![row.clone()])).unwrap();
        let Reply::Rows(rows) = postcard::from_bytes(&bytes).unwrap() else { panic!() };
        let bits = |row: &Row| row.figures.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!((bits(&rows[0]), &rows[0].error), (bits(&row), &row.error));
    }
}
