//! A worker process as the main process sees it.

use crate::experiment::{Detail, Gives};
use crate::results::Row;
use crate::worker::{ROLE, Ready, Reply, Request};
use anyhow::{Result, bail};
use host::child::{self, OWN, Prints, Process};
pub use host::child::{End, TICK};
use run::master::Recording;
use std::time::{Duration, Instant};

/// How long FMUs may take to be unpacked, besides the limit: the machine is busy with the other workers.
const LOADING: Duration = Duration::from_secs(60);

/// How to start workers.
#[derive(Clone, Debug)]
pub struct Starter {
    /// How to start a process; its limit is for one run.
    pub child: child::Starter,
    /// The job as JSON.
    pub job: String,
    /// The names of its members.
    pub members: Vec<String>,
    /// Each run is made with new instances.
    pub renews: bool,
    /// FMUs are called through their C interface, whatever they are.
    pub exact_door: bool,
}

impl Starter {
    /// Starts a worker, and waits until it has loaded the FMUs. What the FMUs of one that `listens` print is
    /// kept, and each of its rows is sent at once.
    ///
    /// # Errors
    /// What is wrong with the job or with an FMU.
    pub fn start(&self, listens: bool) -> Result<(Worker, Ready)> {
        // What FMUs print in thousands of runs is of no use, unless one crashes.
        let mut worker = Worker(self.child.start(ROLE, if listens { Prints::Kept } else { Prints::Dropped })?);
        let Starter { renews, exact_door, .. } = *self;
        worker.0.send(&Request::Begin { job: self.job.clone(), is_prompt: listens, renews, exact_door });
        let (began, mut calls) = (Instant::now(), 0);
        // A library may take as long to load as a run.
        let reply = worker.0.receive(|witness| {
            let is_next = std::mem::replace(&mut calls, witness.calls()) != calls;
            is_next || witness.member().is_none() && began.elapsed() < LOADING
        });
        match reply {
            Ok(Reply::Ready(ready)) => Ok((worker, ready)),
            Ok(Reply::Refused(error)) => bail!("{error}"),
            Ok(other) => bail!("a worker answered {other:?}"),
            Err(End::Interrupted) => bail!("interrupted"),
            Err(end) => bail!("{} while the loop was loaded", worker.text(&end, self)),
        }
    }
}

/// The recording of a run, and its figures, unless an FMU has ended it.
pub type Curve = (Recording, Option<Vec<f64>>);

/// A worker process. It ends when this is dropped.
#[derive(Debug)]
pub struct Worker(Process);

impl Worker {
    /// How it has ended, with the name of the FMU that was called.
    pub fn text(&self, end: &End, starter: &Starter) -> String {
        match end {
            End::Interrupted => "interrupted".into(),
            End::Ended(what) => {
                let name = self.0.witness.member().and_then(|at| starter.members.get(at));
                format!("{} {what}", name.map_or(OWN, String::as_str))
            }
        }
    }

    /// Makes runs. `each` gets the rows, whose points are taken from `points`. Gives why it has ended before there
    /// was a row for each.
    pub fn rows(&mut self, points: &mut Vec<Vec<f64>>, gives: Gives, mut each: impl FnMut(Vec<Row>)) -> Option<End> {
        self.0.send(&Request::Rows(points.clone(), gives));
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

    /// Makes a run with new instances and records it. Gives its figures as well, unless an FMU has ended it.
    ///
    /// # Errors
    /// Why the process has ended; in the result, what an FMU refuses.
    pub fn curve(&mut self, point: &[f64], detail: Detail) -> Result<Result<Curve>, End> {
        self.0.send(&Request::Curve(point.to_vec(), detail));
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
                Reply::Refused(error) => return Ok(Err(anyhow::Error::msg(error))),
                _ => return Err(self.0.disturbed()),
            }
        }
    }

    /// Finds out whether an instance that was reset computes what a new one does: what the user should know.
    ///
    /// # Errors
    /// Why the process has ended.
    pub fn check_reset(&mut self) -> Result<Option<String>, End> {
        self.0.send(&Request::CheckReset);
        match self.reply()? {
            Reply::Reset(warning) => Ok(warning),
            _ => Err(self.0.disturbed()),
        }
    }

    /// The last lines that the FMUs of a process have printed, which has ended and was started to listen.
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
        // As Rust's programs end after a panic.
        fs::write(&program, "#!/bin/sh\nexit 101\n").unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        let child = child::Starter { program, limit: Duration::from_secs(60), interrupted: Arc::default() };
        let members = vec!["PUMP".to_string()];
        let starter = Starter { child, job: "{}".into(), members, renews: false, exact_door: false };
        let error = starter.start(false).unwrap_err().to_string();
        assert_eq!(
            error,
            "a process of plcfmu (the library of no FMU was called) ended its process with exit code 101 while the loop was loaded"
        );
    }
}
