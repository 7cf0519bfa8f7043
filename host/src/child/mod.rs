//! Runs foreign code in a separate process: a crash, an exit or an endless loop in an FMU affects only that process.
//!
//! ```text
//! Process --requests--> standard input  of `plcfmu child ROLE FOLDER` --> Channel
//!         <--replies--- standard output
//!         <--Witness--- a file in FOLDER that both map into memory: which FMU is being called
//! ```
//!
//! Messages are framed by [`framing`] and encoded with postcard. Anything else the process prints goes to standard
//! error.

mod end;
pub mod framing;
pub mod run;
mod standard_output;
pub mod witness;

use crate::instance;
use crate::machine::Fault;
use crate::package::temporary::Folder;
use anyhow::{Context, Result, bail};
use end::{how, last_bytes};
use framing::FAREWELL;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::env;
use std::fs::File;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::process::{self, Child, ChildStdin, Command, ExitStatus, Stdio};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use witness::Witness;

/// The hidden command of plcfmu that runs in the child process.
pub const COMMAND: &str = "child";

/// The interval at which a waiting thread checks for an interruption.
pub const TICK: Duration = Duration::from_millis(100);

/// The maximum number of replies received but not yet read; beyond it, the child process must wait.
const MOST_REPLIES: usize = 64;

/// When an FMU crashes, this many of its last log messages are reported.
const MOST_LOGGED: usize = 3;

/// When an FMU crashes, this many of the last lines printed by its process are reported.
const LINES: usize = 3;

/// The text of [`End::Ended`] for a process that was terminated because its output was invalid.
const DISTURBED: &str = "corrupted the output of its process by writing to it or closing it; the process was ended";

/// The subject used instead of an FMU's name if no FMU was being called; the text of [`End::Ended`] follows.
pub const OWN: &str = "a process of plcfmu (no FMU library was being called)";

/// Where text printed by FMUs goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prints {
    /// Forwarded to the standard error of this process.
    Shown,
    /// The last part is kept; see [`Process::printed`].
    Kept,
    /// Discarded.
    Dropped,
}

/// The parameters for starting processes.
#[derive(Clone, Debug)]
pub struct Starter {
    /// The path of the program `plcfmu`.
    pub program: PathBuf,
    /// The time limit for a reply.
    pub limit: Duration,
    /// Stops all waiting and prevents new processes from starting once it is true.
    pub interrupted: Arc<AtomicBool>,
}

/// The reason why a process sends no more replies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// The user interrupted the command.
    Interrupted,
    /// The process ended or was terminated. The text follows the name of the FMU, such as "crashed: signal 11
    /// (segmentation fault)".
    Ended(String),
}

/// A message sent by the process.
#[derive(Debug, Deserialize, Serialize)]
enum Sent<T> {
    /// A message just logged by an FMU: the name of the instance and the text.
    Logged(String, String),
    Reply(T),
}

/// A child process. Dropping this value ends it.
#[derive(Debug)]
pub struct Process {
    /// The time limit for a reply.
    pub limit: Duration,
    process: Child,
    /// The standard input of the process; `None` once no more requests will be sent.
    requests: Option<ChildStdin>,
    replies: Receiver<Vec<u8>>,
    /// Receives the last output of the process when it ends; `None` if output is not kept.
    printed: Option<Receiver<Vec<u8>>>,
    /// The latest messages of each FMU: the name of the instance and the text.
    logged: Vec<(String, String)>,
    interrupted: Arc<AtomicBool>,
    has_ended: bool,
    /// Shows which FMU is being called.
    pub witness: Witness,
    /// The folder in which FMUs are unpacked; removed after the process has ended.
    _folder: Folder,
}

impl Starter {
    /// The parameters for starting the current program, with a time limit of 300 s for a reply.
    ///
    /// # Errors
    /// The program cannot determine its own path.
    pub fn new() -> Result<Starter> {
        Ok(Starter {
            program: std::env::current_exe().context("plcfmu cannot find its own program file")?,
            limit: Duration::from_secs(300),
            interrupted: Arc::default(),
        })
    }

    /// Starts a process; `role` is the argument of the hidden command that selects what it does.
    ///
    /// # Errors
    /// The user interrupted the command, no temporary folder can be created, or the program cannot be run.
    pub fn start(&self, role: &str, prints: Prints) -> Result<Process> {
        if self.interrupted.load(Ordering::Relaxed) {
            bail!("interrupted");
        }
        let temporary = env::temp_dir();
        let folder = Folder::new().with_context(|| Fault::no_room(&temporary))?;
        let witness = Witness::open(folder.path()).with_context(|| Fault::no_room(&temporary))?;
        let errors = match prints {
            Prints::Shown => Stdio::inherit(),
            Prints::Kept => Stdio::piped(),
            Prints::Dropped => Stdio::null(),
        };
        let mut command = Command::new(&self.program);
        command.args([COMMAND, role]).arg(folder.path());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(errors);
        // Its own process group, so that Ctrl-C reaches only the main process.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        #[cfg(windows)]
        std::os::windows::process::CommandExt::creation_flags(&mut command, NEW_PROCESS_GROUP);
        let mut process = command.spawn().with_context(|| format!("{} cannot be run", self.program.display()))?;
        let requests = process.stdin.take();
        let mut output = process.stdout.take().context("the process has no standard output")?;
        let (sender, replies) = mpsc::sync_channel(MOST_REPLIES);
        thread::spawn(move || {
            // This thread ends when the process closes its output.
            while let Ok(Some(message)) = framing::receive(&mut output) {
                if sender.send(message).is_err() {
                    break;
                }
            }
        });
        let printed = process.stderr.take().map(|errors| {
            let (sender, printed) = mpsc::channel();
            thread::spawn(move || sender.send(last_bytes(errors)));
            printed
        });
        Ok(Process {
            limit: self.limit,
            process,
            requests,
            replies,
            printed,
            logged: Vec::new(),
            interrupted: self.interrupted.clone(),
            has_ended: false,
            witness,
            _folder: folder,
        })
    }
}

#[cfg(windows)]
const NEW_PROCESS_GROUP: u32 = 0x200;

impl Process {
    /// Sends a request. If it cannot be sent, there is no reply, and [`Process::receive`] returns the reason.
    pub fn send(&mut self, request: &impl Serialize) {
        let message = postcard::to_stdvec(request).unwrap_or_default();
        let _ = self.requests.as_mut().map(|requests| framing::send(requests, &message));
    }

    /// Receives the next reply. While there is none, `is_alive` is called once per [`TICK`] and returns whether the
    /// time limit restarts.
    ///
    /// # Errors
    /// The reason why there is no reply.
    pub fn receive<T: DeserializeOwned>(&mut self, mut is_alive: impl FnMut(&Witness) -> bool) -> Result<T, End> {
        let mut began = Instant::now();
        let mut is_left = false;
        loop {
            let left = self.limit.saturating_sub(began.elapsed());
            match self.replies.recv_timeout(left.min(TICK)) {
                Ok(message) => match postcard::from_bytes(&message) {
                    Ok(Sent::Reply(reply)) => return Ok(reply),
                    Ok(Sent::Logged(name, text)) => keep(&mut self.logged, name, text),
                    Err(_) => return Err(self.disturbed()),
                },
                Err(_) if self.interrupted.load(Ordering::Relaxed) => {
                    self.kill();
                    return Err(End::Interrupted);
                }
                Err(RecvTimeoutError::Disconnected) => return Err(self.ended()),
                // Its last replies may still arrive, but wait only one more tick: a process started by the FMU may keep
                // the output open.
                Err(RecvTimeoutError::Timeout) if self.has_ended_itself() => {
                    self.end_group();
                    if std::mem::replace(&mut is_left, true) {
                        return Err(self.ended());
                    }
                }
                Err(RecvTimeoutError::Timeout) if is_alive(&self.witness) => began = Instant::now(),
                Err(RecvTimeoutError::Timeout) if left.is_zero() => {
                    self.kill();
                    return Err(End::Ended(format!("did not return within {} s", self.limit.as_secs_f64())));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    /// How a process ended after its last reply. A process that does not exit within [`FAREWELL`] has closed its output
    /// or sent an invalid message, and is terminated.
    fn ended(&mut self) -> End {
        let began = Instant::now();
        while began.elapsed() < FAREWELL {
            if self.has_ended_itself() {
                return End::Ended(how(self.kill()));
            }
            thread::sleep(Duration::from_millis(1));
        }
        self.disturbed()
    }

    /// Terminates a process that sent an invalid reply.
    pub fn disturbed(&mut self) -> End {
        self.kill();
        End::Ended(DISTURBED.into())
    }

    /// The last lines printed by a process that has ended and whose output is kept.
    pub fn printed(&self) -> Vec<String> {
        // A time limit, because a process started by the FMU may keep the other end open.
        let bytes = self.printed.as_ref().and_then(|printed| printed.recv_timeout(FAREWELL).ok()).unwrap_or_default();
        let text = String::from_utf8_lossy(&bytes);
        let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        lines[lines.len().saturating_sub(LINES)..].iter().map(|line| line.to_string()).collect()
    }

    /// The last log messages of the FMU `name` (of all FMUs if `None`) and the last lines printed by the process,
    /// worded as the end of a sentence about a crash.
    pub fn last_words(&self, name: Option<&str>) -> String {
        let logged = self.logged.iter().filter(|(of, _)| name.is_none_or(|name| of == name));
        let logged: Vec<&str> = logged.map(|(_, text)| text.as_str()).collect();
        let logged = &logged[logged.len().saturating_sub(MOST_LOGGED)..];
        let printed = self.printed();
        let mut words = String::new();
        if !logged.is_empty() {
            words.push_str(&format!("; it logged: {}", logged.join(" / ")));
        }
        if !printed.is_empty() {
            words.push_str(&format!("; it printed: {}", printed.join(" / ")));
        }
        words
    }

    /// Terminates the process and returns its exit status, if known.
    pub fn kill(&mut self) -> Option<ExitStatus> {
        self.end_group();
        self.has_ended = true;
        // If the process has already ended, this does not change its status.
        let _ = self.process.kill();
        self.process.wait().ok()
    }

    /// Whether the process has ended on its own. It is not reaped, so its process ID cannot be reused yet.
    #[cfg(unix)]
    fn has_ended_itself(&mut self) -> bool {
        use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
        let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        !matches!(waitid(WaitId::Pid(Pid::from_child(&self.process)), look), Ok(None))
    }

    #[cfg(not(unix))]
    fn has_ended_itself(&mut self) -> bool {
        !matches!(self.process.try_wait(), Ok(None))
    }

    /// Terminates all processes in the process group: this one, and those that the FMU started unless they have left
    /// the group. On Windows, does nothing.
    fn end_group(&self) {
        #[cfg(unix)]
        if !self.has_ended {
            use rustix::process::{Pid, Signal, kill_process_group};
            let _ = kill_process_group(Pid::from_child(&self.process), Signal::KILL);
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The process frees its instances and exits when no more requests can arrive; then its output ends.
        drop(self.requests.take());
        if !self.has_ended {
            let began = Instant::now();
            while began.elapsed() < FAREWELL
                && !self.has_ended_itself()
                && self.replies.recv_timeout(TICK) != Err(RecvTimeoutError::Disconnected)
            {}
            self.kill();
        }
    }
}

/// The child's side of the connection: requests in, replies out.
#[derive(Debug)]
pub struct Channel {
    requests: Receiver<Vec<u8>>,
    replies: Arc<Mutex<File>>,
    /// The folder in which FMUs are unpacked.
    pub folder: PathBuf,
    /// Shows the other side which FMU is being called.
    pub witness: Rc<Witness>,
}

impl Channel {
    /// Receives the next request; `None` if there are no more.
    ///
    /// # Errors
    /// The request is invalid.
    pub fn next<T: DeserializeOwned>(&self) -> Result<Option<T>> {
        self.requests.recv().ok().map(|message| Ok(postcard::from_bytes(&message)?)).transpose()
    }

    /// Sends a reply.
    ///
    /// # Errors
    /// The other side has ended.
    pub fn send(&self, reply: &impl Serialize) -> Result<()> {
        send(&self.replies, &Sent::Reply(reply))
    }

    /// From now on, immediately forwards messages logged by FMUs to the other side.
    pub fn tell_messages(&self) {
        let replies = self.replies.clone();
        instance::listen(move |name, text| {
            // If the other side no longer listens, it terminates this process.
            let _ = send(&replies, &Sent::<()>::Logged(name.into(), text.into()));
        });
    }
}

fn send<T: Serialize>(to: &Mutex<File>, sent: &Sent<T>) -> Result<()> {
    let message = postcard::to_stdvec(sent)?;
    let mut to = to.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(framing::send(&mut *to, &message)?)
}

/// Adds a message, and keeps only the latest of its FMU, as many as [`Process::last_words`] shows: a run of hours may
/// log one in every step.
fn keep(logged: &mut Vec<(String, String)>, name: String, text: String) {
    let own: Vec<_> = (0..logged.len()).filter(|&at| logged[at].0 == name).collect();
    if own.len() == MOST_LOGGED {
        logged.remove(own[0]);
    }
    logged.push((name, text));
}

/// Opens the channel to the parent process, lets `answer` process the requests, then exits.
///
/// # Errors
/// There is no standard output, the witness in `folder` cannot be opened, or `answer` fails.
pub fn serve(folder: &Path, answer: impl FnOnce(&Channel) -> Result<()>) -> Result<()> {
    let replies = standard_output::take().context("standard output")?;
    let witness = Rc::new(Witness::open(folder)?);
    // Kept until this process exits: without the sender, the reader thread would end it as soon as the input ends.
    let (requests, _at_work) = framing::input();
    let replies = Arc::new(Mutex::new(replies));
    let channel = Channel { requests, replies, folder: folder.to_path_buf(), witness };
    // A panic that arrives here is this program's own: one in an FMU's library aborts the process or does not leave the
    // library.
    match panic::catch_unwind(AssertUnwindSafe(|| answer(&channel))) {
        Ok(answered) => answered?,
        Err(panic) => {
            channel.witness.clear();
            panic::resume_unwind(panic);
        }
    }
    process::exit(0)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_process_that_is_ended_since_its_output_makes_no_sense_has_not_crashed() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("disturbed");
        // The text decodes to an impossible message length; the script keeps running.
        std::fs::write(&program, "#!/bin/sh\nprintf 'what an FMU has printed'\nread request\n").unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        let starter = Starter { program, limit: Duration::from_secs(60), interrupted: Arc::default() };
        let mut process = starter.start("role", Prints::Dropped).unwrap();
        assert_eq!(process.receive::<()>(|_| false), Err(End::Ended(DISTURBED.into())));
    }

    #[test]
    fn the_latest_messages_of_each_fmu_are_kept() {
        let mut logged = Vec::new();
        keep(&mut logged, "TANK".into(), "full".into());
        for number in 1..=5 {
            keep(&mut logged, "PUMP".into(), number.to_string());
        }
        let kept: Vec<_> = logged.iter().map(|(name, text)| format!("{name} {text}")).collect();
        assert_eq!(kept, ["TANK full", "PUMP 3", "PUMP 4", "PUMP 5"]);
    }
}
