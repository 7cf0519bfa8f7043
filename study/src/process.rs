//! A worker process as seen by the main process.

use crate::experiment::{Detail, Gives};
use crate::results::RunResult;
use crate::worker::{ROLE, Ready, Reply, WorkerRequest};
use anyhow::{Error, Result, anyhow, bail};
use host::child::{self, OWN, Prints, Process};
pub use host::child::{End, TICK};
use run::master::Recording;
use run::subject::Subject;
use std::time::{Duration, Instant};

/// The time allowed for unpacking FMUs beyond the limit for a run, since other workers may keep the machine busy.
const LOADING: Duration = Duration::from_secs(60);

/// The parameters for starting workers.
#[derive(Clone, Debug)]
pub struct Starter {
    /// The parameters for starting a process; its time limit applies to one run.
    pub child: child::Starter,
    /// The job as JSON.
    pub job: String,
    /// The names of its members.
    pub members: Vec<String>,
    /// Whether each run uses new instances.
    pub renews: bool,
    /// Whether all FMUs are called through their C interface.
    pub exact_door: bool,
}

impl Starter {
    /// Starts a worker, and waits until it has loaded the FMUs. If `listens`, the output of the FMUs is kept and the
    /// worker sends each row immediately.
    ///
    /// # Errors
    /// The job or an FMU is faulty.
    pub fn start(&self, listens: bool) -> Result<(Worker, Ready)> {
        // What FMUs print in thousands of runs is of no use unless one of them crashes.
        let mut worker = Worker(self.child.start(ROLE, if listens { Prints::Kept } else { Prints::Dropped })?);
        let Starter { renews, exact_door, .. } = *self;
        worker.0.send(&WorkerRequest::Begin { job: self.job.clone(), is_prompt: listens, renews, exact_door });
        let (began, mut calls) = (Instant::now(), 0);
        // The time limit restarts with each library. Outside libraries, while FMUs are unpacked, it does not apply for
        // the first minute.
        let reply = worker.0.receive(|witness| {
            let is_next = std::mem::replace(&mut calls, witness.calls()) != calls;
            is_next || witness.member().is_none() && began.elapsed() < LOADING
        });
        match reply {
            Ok(Reply::Ready(ready)) => Ok((worker, ready)),
            Ok(Reply::Refused(message, Some(subject))) => Err(subject.attach(Error::msg(message))),
            Ok(Reply::Refused(message, None)) => bail!(message),
            Ok(other) => bail!("unexpected answer from a worker: {other:?}"),
            Err(End::Interrupted) => bail!("interrupted"),
            Err(end) => {
                let error = anyhow!("{} while the loop was loaded", worker.text(&end, self));
                Err(if worker.called(self).is_none() { Subject::Outside.attach(error) } else { error })
            }
        }
    }
}

/// The recording of a run, and its figures unless an FMU ended it.
pub type Curve = (Recording, Option<Vec<f64>>);

/// A worker process, which ends when this value is dropped.
#[derive(Debug)]
pub struct Worker(Process);

impl Worker {
    /// How the process ended, with the name of the FMU that was being called.
    pub fn text(&self, end: &End, starter: &Starter) -> String {
        match end {
            End::Interrupted => "interrupted".into(),
            End::Ended(what) => {
                format!("{} {what}", self.called(starter).unwrap_or(OWN))
            }
        }
    }

    /// The name of the FMU that is being called.
    fn called<'a>(&self, starter: &'a Starter) -> Option<&'a str> {
        self.0.witness.member().and_then(|at| starter.members.get(at)).map(String::as_str)
    }

    /// Executes runs. `each` receives the rows; their points are removed from `points`. Returns the reason if the
    /// process ended before all rows had arrived.
    pub fn rows(
        &mut self,
        points: &mut Vec<Vec<f64>>,
        gives: Gives,
        mut each: impl FnMut(Vec<RunResult>),
    ) -> Option<End> {
        self.0.send(&WorkerRequest::Rows(points.clone(), gives));
        while !points.is_empty() {
            match self.reply() {
                Ok(Reply::Rows(rows)) if rows.len() <= points.len() => {
                    points.drain(..rows.len());
                    each(rows);
                }
                Ok(_) => return Some(self.0.disturbed()),
                Err(end) => return Some(end),
            }
        }
        None
    }

    /// Executes a run with new instances and records it. Returns its figures as well, unless an FMU ended it.
    ///
    /// # Errors
    /// The reason why the process ended; the inner error is a call rejected by an FMU.
    pub fn curve(&mut self, point: &[f64], detail: Detail) -> Result<Result<Curve>, End> {
        self.0.send(&WorkerRequest::Curve(point.to_vec(), detail));
        let mut recording: Option<Recording> = None;
        loop {
            match self.reply()? {
                Reply::Piece(piece) => match &mut recording {
                    Some(recording) => recording.append(piece),
                    None => recording = Some(piece),
                },
                Reply::Curve(figures) => {
                    let recording = recording.ok_or_else(|| self.0.disturbed())?;
                    return Ok(Ok((recording, figures)));
                }
                Reply::Refused(message, _) => return Ok(Err(Error::msg(message))),
                _ => return Err(self.0.disturbed()),
            }
        }
    }

    /// Checks whether a reset instance computes the same results as a new one; returns a message for the user if not.
    ///
    /// # Errors
    /// The reason why the process ended.
    pub fn check_reset(&mut self) -> Result<Option<String>, End> {
        self.0.send(&WorkerRequest::CheckReset);
        match self.reply()? {
            Reply::Reset(warning) => Ok(warning),
            _ => Err(self.0.disturbed()),
        }
    }

    /// The last lines printed by the FMUs in a process that has ended; empty unless it was started with `listens`.
    pub fn printed(&self) -> Vec<String> {
        self.0.printed()
    }

    fn reply(&mut self) -> Result<Reply, End> {
        self.0.receive(|_| false)
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use std::sync::Arc;

    #[test]
    fn an_fmu_that_was_not_called_is_not_to_blame() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("panics");
        // The exit code of a Rust program after a panic.
        fs::write(&program, "#!/bin/sh\nexit 101\n").unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        let child = child::Starter { program, limit: Duration::from_secs(60), interrupted: Arc::default() };
        let members = vec!["PUMP".to_string()];
        let starter = Starter { child, job: "{}".into(), members, renews: false, exact_door: false };
        let error = starter.start(false).unwrap_err().to_string();
        assert_eq!(
            error,
            "a process of plcfmu (no FMU library was being called) ended its process with exit code 101 while the loop was loaded"
        );
    }
}
