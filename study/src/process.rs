//! A worker process as the main process sees it.

use crate::results::Row;
use crate::worker::{COMMAND, Reply, Request};
use anyhow::{Context, Result, bail};
use host::framing::{self, FAREWELL};
use host::package::temporary;
use run::master::Recording;
use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// How often a thread that waits looks whether there is an interruption.
pub const TICK: Duration = Duration::from_millis(100);

/// How long FMUs may take to load, at least: they are unpacked, and the machine is busy with the other workers.
const LOADING: Duration = Duration::from_secs(60);

/// So many replies may wait to be read.
const MOST_REPLIES: usize = 64;

/// So many bytes are kept of what FMUs print.
const MOST_PRINTED: usize = 4096;

/// So many lines of it are shown.
const LINES: usize = 3;

/// How to start workers.
#[derive(Clone, Debug)]
pub struct Starter {
    /// The program `plcfmu`.
    pub program: PathBuf,
    /// The job as JSON.
    pub job: String,
    /// The names of its members.
    pub members: Vec<String>,
    /// Each run is made with new instances.
    pub renews: bool,
    /// How long one run may take.
    pub limit: Duration,
    /// Nothing is waited for when this becomes true.
    pub interrupted: Arc<AtomicBool>,
}

/// Why a worker gives no more replies.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// There is an interruption.
    Interrupted,
    /// It has ended or was ended, as the sentence says: "crashed: signal 11 (segmentation fault)".
    Ended {
        /// What the FMU did.
        what: String,
        /// The member that was called, if that is known.
        at: Option<u32>,
    },
}

impl End {
    /// A sentence with the name of the FMU.
    pub fn text(&self, starter: &Starter) -> String {
        match self {
            End::Interrupted => "interrupted".into(),
            End::Ended { what, at } => {
                let name = at.and_then(|at| starter.members.get(at as usize));
                format!("{} {what}", name.map_or("an FMU", String::as_str))
            }
        }
    }
}

impl Starter {
    /// Starts a worker, and waits until it has loaded the FMUs. Gives what the library of each member says of its
    /// block.
    ///
    /// # Errors
    /// What is wrong with the job or with an FMU.
    pub fn start(&self, announces: bool) -> Result<(Worker, Vec<Option<String>>)> {
        let mut worker = self.spawn(announces)?;
        worker.limit = self.limit.max(LOADING);
        worker.send(&Request::Begin { job: self.job.clone(), announces, renews: self.renews });
        match worker.reply() {
            Ok(Reply::Ready(interfaces)) => {
                (worker.announces, worker.limit) = (announces, self.limit);
                Ok((worker, interfaces))
            }
            Ok(Reply::Refused(error)) => bail!("{error}"),
            Ok(other) => bail!("a worker answered {other:?}"),
            Err(End::Interrupted) => bail!("interrupted"),
            Err(end) => bail!("{} while it was loaded", end.text(self)),
        }
    }

    fn spawn(&self, listens: bool) -> Result<Worker> {
        let folder = temporary::builder().tempdir().context("there is no folder for temporary files")?;
        let mut command = Command::new(&self.program);
        // What FMUs print in thousands of runs helps nobody, unless one crashes.
        let errors = if listens { Stdio::piped() } else { Stdio::null() };
        command.arg(COMMAND).arg(folder.path()).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(errors);
        // Ctrl-C is for the main process alone.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        #[cfg(windows)]
        std::os::windows::process::CommandExt::creation_flags(&mut command, NEW_PROCESS_GROUP);
        let mut process = command.spawn().with_context(|| format!("{} cannot run", self.program.display()))?;
        let requests = process.stdin.take();
        let mut from_worker = process.stdout.take().context("the worker has no standard output")?;
        let (sender, replies) = mpsc::sync_channel(MOST_REPLIES);
        thread::spawn(move || {
            // The end of the process ends this thread too.
            while let Ok(Some(message)) = framing::receive(&mut from_worker) {
                let Ok(reply) = postcard::from_bytes(&message) else { break };
                if sender.send(reply).is_err() {
                    break;
                }
            }
        });
        let printed = process.stderr.take().map(|errors| {
            let (sender, printed) = mpsc::channel();
            thread::spawn(move || sender.send(last_bytes(errors)));
            printed
        });
        Ok(Worker {
            process,
            requests,
            replies,
            printed,
            limit: self.limit,
            interrupted: self.interrupted.clone(),
            at: None,
            announces: true,
            has_ended: false,
            _folder: folder,
        })
    }
}

#[cfg(windows)]
const NEW_PROCESS_GROUP: u32 = 0x200;

/// A worker process. It ends when this is dropped.
#[derive(Debug)]
pub struct Worker {
    process: Child,
    /// `None` when no more requests will come.
    requests: Option<ChildStdin>,
    replies: Receiver<Reply>,
    /// What its FMUs have printed last, when it has ended; `None` if nobody listens.
    printed: Option<Receiver<Vec<u8>>>,
    limit: Duration,
    interrupted: Arc<AtomicBool>,
    /// The member that was announced last.
    at: Option<u32>,
    /// All calls are announced. While the FMUs are loaded, they always are.
    announces: bool,
    has_ended: bool,
    /// The FMUs are unpacked here; removed after the process is gone.
    _folder: TempDir,
}

impl Worker {
    /// Makes runs. `each` gets the rows with their points, which are taken from `points`. Gives why it has ended before there
    /// was a row for each.
    pub fn rows(&mut self, points: &mut Vec<Vec<f64>>, mut each: impl FnMut(Vec<(Vec<f64>, Row)>)) -> Option<End> {
        self.send(&Request::Rows(points.clone()));
        while !points.is_empty() {
            match self.reply() {
                Ok(Reply::Rows(rows)) if rows.len() <= points.len() => {
                    each(points.drain(..rows.len()).zip(rows).collect());
                }
                Ok(_) => return Some(self.ended("disturbed its process".into())),
                Err(end) => return Some(end),
            }
        }
        None
    }

    /// Makes a run and records it.
    ///
    /// # Errors
    /// Why the process has ended; in the result, what an FMU refuses.
    pub fn curve(&mut self, point: &[f64]) -> Result<Result<Recording>, End> {
        self.send(&Request::Curve(point.to_vec()));
        match self.reply()? {
            Reply::Curve(recording) => Ok(Ok(recording)),
            Reply::Refused(error) => Ok(Err(anyhow::Error::msg(error))),
            _ => Err(self.ended("disturbed its process".into())),
        }
    }

    /// Finds out whether an instance that was reset computes what a new one does: what the user should know.
    ///
    /// # Errors
    /// Why the process has ended.
    pub fn check_reset(&mut self) -> Result<Option<String>, End> {
        self.send(&Request::CheckReset);
        match self.reply()? {
            Reply::Reset(warning) => Ok(warning),
            _ => Err(self.ended("disturbed its process".into())),
        }
    }

    /// The last lines that the FMUs of a process have printed, which has ended and was started to announce its calls.
    pub fn printed(&self) -> Vec<String> {
        // A process that the FMU has started may still hold the other end.
        let bytes = self.printed.as_ref().and_then(|printed| printed.recv_timeout(FAREWELL).ok()).unwrap_or_default();
        let text = String::from_utf8_lossy(&bytes);
        let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        lines[lines.len().saturating_sub(LINES)..].iter().map(|line| line.to_string()).collect()
    }

    fn send(&mut self, request: &Request) {
        let message = postcard::to_stdvec(request).unwrap_or_default();
        // One that cannot be sent anything has ended, and so has its output.
        let _ = self.requests.as_mut().map(|requests| framing::send(requests, &message));
    }

    /// The next reply but announcements.
    fn reply(&mut self) -> Result<Reply, End> {
        let began = Instant::now();
        loop {
            let left = self.limit.saturating_sub(began.elapsed());
            match self.replies.recv_timeout(left.min(TICK)) {
                Ok(Reply::At(member)) => self.at = Some(member),
                Ok(reply) => return Ok(reply),
                Err(_) if self.interrupted.load(Ordering::Relaxed) => {
                    self.kill();
                    return Err(End::Interrupted);
                }
                Err(RecvTimeoutError::Disconnected) => {
                    let status = self.kill();
                    return Err(self.ended(how(status)));
                }
                Err(RecvTimeoutError::Timeout) if left.is_zero() => {
                    let seconds = self.limit.as_secs_f64();
                    return Err(self.ended(format!("did not return within {seconds} s")));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    fn ended(&mut self, what: String) -> End {
        self.kill();
        End::Ended { what, at: self.at.filter(|_| self.announces) }
    }

    /// Ends the process, and says how it has ended.
    fn kill(&mut self) -> Option<ExitStatus> {
        self.has_ended = true;
        // It may have closed its output alone. The status of one that has ended stays as it is.
        let _ = self.process.kill();
        self.process.wait().ok()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // It frees its instances and ends when nothing more can come; then its output ends.
        drop(self.requests.take());
        if !self.has_ended {
            let began = Instant::now();
            while began.elapsed() < FAREWELL && self.replies.recv_timeout(FAREWELL).is_ok() {}
            self.kill();
        }
    }
}

/// The last bytes that can be read.
fn last_bytes(mut from: impl Read) -> Vec<u8> {
    let (mut last, mut read) = (Vec::new(), [0; MOST_PRINTED]);
    while let Ok(count @ 1..) = from.read(&mut read) {
        last.extend_from_slice(&read[..count]);
        last.drain(..last.len().saturating_sub(MOST_PRINTED));
    }
    last
}

/// How a process has ended, after the name of the FMU.
fn how(status: Option<ExitStatus>) -> String {
    let Some(status) = status else { return "ended its process".into() };
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("crashed: signal {signal} ({})", signal_name(signal));
    }
    match status.code() {
        // Windows: exceptions are statuses of the severity "error".
        Some(code) if cfg!(windows) && code < 0 => format!("crashed: exception {:#010x}", code as u32),
        Some(code) => format!("ended its process with exit code {code}"),
        None => format!("ended its process with {status}"),
    }
}

#[cfg(unix)]
fn signal_name(signal: i32) -> &'static str {
    match signal {
        4 => "illegal instruction",
        5 => "trap",
        6 => "abort",
        8 => "arithmetic error",
        9 => "kill",
        11 => "segmentation fault",
        15 => "termination",
        7 | 10 => "bus error",
        _ => "see kill -l",
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::process::ExitStatusExt;

    #[test]
    fn the_end_of_a_process_is_said_in_words() {
        let how = |raw| how(Some(ExitStatus::from_raw(raw)));
        assert_eq!(how(11), "crashed: signal 11 (segmentation fault)");
        assert_eq!(how(3 << 8), "ended its process with exit code 3");
    }

    #[test]
    fn the_last_bytes_of_a_long_text_are_kept() {
        let text: Vec<u8> = (0..3 * MOST_PRINTED + 7).map(|place| place as u8).collect();
        assert_eq!(last_bytes(&text[..]), text[text.len() - MOST_PRINTED..]);
        assert_eq!(last_bytes(&text[..5]), text[..5]);
    }
}
