//! Foreign code in a process of its own: a crash, an exit or an endless loop of an FMU ends that process and nothing else.
//!
//! ```text
//! Process --requests--> standard input  of `plcfmu child ROLE FOLDER` --> Channel
//!         <--replies--- standard output
//!         <--Witness--- a file in FOLDER that both have in their memory: which FMU is called
//! ```
//!
//! Messages are framed by [`framing`] and in the format of postcard. What the process prints goes to standard error.

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

/// The hidden command that is the other side.
pub const COMMAND: &str = "child";

/// How often a thread that waits looks whether there is an interruption.
pub const TICK: Duration = Duration::from_millis(100);

/// This many replies may wait to be read.
const MOST_REPLIES: usize = 64;

/// This many of the messages that an FMU has logged last are told when it crashes.
const MOST_LOGGED: usize = 3;

/// This many lines are told of what it has printed last.
const LINES: usize = 3;

/// What is told of a process that is ended, as its output is not that of this program.
const DISTURBED: &str = "disturbed its process, by what it wrote to its output or by closing it; the process was ended";

/// What has ended if no FMU was called, before the words of [`End::Ended`].
pub const OWN: &str = "a process of plcfmu (the library of no FMU was called)";

/// What becomes of what FMUs print.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prints {
    /// It goes to the standard error of this process.
    Shown,
    /// The last of it is kept, see [`Process::printed`].
    Kept,
    /// Nobody reads it.
    Dropped,
}

/// How to start processes.
#[derive(Clone, Debug)]
pub struct Starter {
    /// The program `plcfmu`.
    pub program: PathBuf,
    /// How long a reply may take.
    pub limit: Duration,
    /// Nothing is waited for, and no process is started, when this becomes true.
    pub interrupted: Arc<AtomicBool>,
}

/// Why a process gives no more replies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// There is an interruption.
    Interrupted,
    /// It has ended or was ended, as the words after the name of the FMU say: "crashed: signal 11 (segmentation fault)".
    Ended(String),
}

/// What the process sends.
#[derive(Debug, Deserialize, Serialize)]
enum Sent<T> {
    /// What an FMU has logged just now, with its name.
    Logged(String, String),
    Reply(T),
}

/// A process. It ends when this is dropped.
#[derive(Debug)]
pub struct Process {
    /// How long a reply may take.
    pub limit: Duration,
    process: Child,
    /// `None` when no more requests will come.
    requests: Option<ChildStdin>,
    replies: Receiver<Vec<u8>>,
    /// What it has printed last, when it has ended; `None` if nobody listens.
    printed: Option<Receiver<Vec<u8>>>,
    /// What was logged last.
    logged: Vec<(String, String)>,
    interrupted: Arc<AtomicBool>,
    has_ended: bool,
    /// Which FMU it calls.
    pub witness: Witness,
    /// FMUs are unpacked here; removed after the process is gone.
    _folder: Folder,
}

impl Starter {
    /// Starters of the program that runs, with 300 s for a reply.
    ///
    /// # Errors
    /// The program does not find itself.
    pub fn new() -> Result<Starter> {
        Ok(Starter {
            program: std::env::current_exe().context("plcfmu cannot find its own program file")?,
            limit: Duration::from_secs(300),
            interrupted: Arc::default(),
        })
    }

    /// Starts a process for one of the roles of the hidden command.
    ///
    /// # Errors
    /// There is an interruption, no folder for temporary files, or the program cannot run.
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
        // Ctrl-C is for the main process alone.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        #[cfg(windows)]
        std::os::windows::process::CommandExt::creation_flags(&mut command, NEW_PROCESS_GROUP);
        let mut process = command.spawn().with_context(|| format!("{} cannot run", self.program.display()))?;
        let requests = process.stdin.take();
        let mut output = process.stdout.take().context("the process has no standard output")?;
        let (sender, replies) = mpsc::sync_channel(MOST_REPLIES);
        thread::spawn(move || {
            // The end of the process ends this thread too.
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
    /// Sends a request. One that cannot be sent has no reply: [`Process::receive`] says why.
    pub fn send(&mut self, request: &impl Serialize) {
        let message = postcard::to_stdvec(request).unwrap_or_default();
        let _ = self.requests.as_mut().map(|requests| framing::send(requests, &message));
    }

    /// The next reply. `is_alive` is asked now and then whether the time limit begins anew.
    ///
    /// # Errors
    /// Why there is none.
    pub fn receive<T: DeserializeOwned>(&mut self, mut is_alive: impl FnMut(&Witness) -> bool) -> Result<T, End> {
        let mut began = Instant::now();
        let mut is_left = false;
        loop {
            let left = self.limit.saturating_sub(began.elapsed());
            match self.replies.recv_timeout(left.min(TICK)) {
                Ok(message) => match postcard::from_bytes(&message) {
                    Ok(Sent::Reply(reply)) => return Ok(reply),
                    Ok(Sent::Logged(name, text)) => self.logged.push((name, text)),
                    Err(_) => return Err(self.disturbed()),
                },
                Err(_) if self.interrupted.load(Ordering::Relaxed) => {
                    self.kill();
                    return Err(End::Interrupted);
                }
                Err(RecvTimeoutError::Disconnected) => return Err(self.ended()),
                // What it has sent before is still on its way, unless another process holds its output.
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

    /// How a process has ended whose replies have. One that does not end by itself has closed its output, or its output makes no
    /// sense; it is ended.
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

    /// Ends a process whose reply makes no sense.
    pub fn disturbed(&mut self) -> End {
        self.kill();
        End::Ended(DISTURBED.into())
    }

    /// The last lines that a process has printed, which has ended and whose prints are kept.
    pub fn printed(&self) -> Vec<String> {
        // A process that the FMU has started may still hold the other end.
        let bytes = self.printed.as_ref().and_then(|printed| printed.recv_timeout(FAREWELL).ok()).unwrap_or_default();
        let text = String::from_utf8_lossy(&bytes);
        let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        lines[lines.len().saturating_sub(LINES)..].iter().map(|line| line.to_string()).collect()
    }

    /// What the FMU with this name, or any FMU, has logged and printed last, as the end of a sentence about its crash.
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

    /// Ends the process, and says how it has ended.
    pub fn kill(&mut self) -> Option<ExitStatus> {
        self.end_group();
        self.has_ended = true;
        // It may have closed its output alone. The status of one that has ended stays as it is.
        let _ = self.process.kill();
        self.process.wait().ok()
    }

    /// Whether it has ended without being told to. Its number is not given to another process before it is waited for.
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

    /// Ends it and the processes that the FMU has started, but for those that have left its group. On Windows these stay.
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
        // It frees its instances and ends when nothing more can come; then its output ends.
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

/// The side of the process: where requests come from and replies go.
#[derive(Debug)]
pub struct Channel {
    requests: Receiver<Vec<u8>>,
    replies: Arc<Mutex<File>>,
    /// Where FMUs are unpacked.
    pub folder: PathBuf,
    /// Tells the other side which FMU is called.
    pub witness: Rc<Witness>,
}

impl Channel {
    /// The next request; `None` if there will be none.
    ///
    /// # Errors
    /// It makes no sense.
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

    /// From now on the other side gets to know at once what FMUs log.
    pub fn tell_messages(&self) {
        let replies = self.replies.clone();
        instance::listen(move |name, text| {
            // The other side ends this process if it does not listen any more.
            let _ = send(&replies, &Sent::<()>::Logged(name.into(), text.into()));
        });
    }
}

fn send<T: Serialize>(to: &Mutex<File>, sent: &Sent<T>) -> Result<()> {
    let message = postcard::to_stdvec(sent)?;
    let mut to = to.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(framing::send(&mut *to, &message)?)
}

/// Does what the requests on standard input say, and ends the process.
///
/// # Errors
/// There is no standard output, no witness in `folder`, or `answer` fails.
pub fn serve(folder: &Path, answer: impl FnOnce(&Channel) -> Result<()>) -> Result<()> {
    let replies = standard_output::take().context("standard output")?;
    let witness = Rc::new(Witness::open(folder)?);
    let (requests, at_work) = framing::input();
    let replies = Arc::new(Mutex::new(replies));
    let channel = Channel { requests, replies, folder: folder.to_path_buf(), witness };
    // A panic comes from the code of this program: one in an FMU's library ends the process, or stays in there.
    match panic::catch_unwind(AssertUnwindSafe(|| answer(&channel))) {
        Ok(answered) => answered?,
        Err(panic) => {
            channel.witness.clear();
            panic::resume_unwind(panic);
        }
    }
    // Without waiting for the thread that reads, which must not believe that this is over before.
    drop(at_work);
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
        // A length beyond all messages; then it goes on.
        std::fs::write(&program, "#!/bin/sh\nprintf 'what an FMU has printed'\nread request\n").unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        let starter = Starter { program, limit: Duration::from_secs(60), interrupted: Arc::default() };
        let mut process = starter.start("role", Prints::Dropped).unwrap();
        assert_eq!(process.receive::<()>(|_| false), Err(End::Ended(DISTURBED.into())));
    }
}
