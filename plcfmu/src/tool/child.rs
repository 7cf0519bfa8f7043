//! A foreign FMU in a process of its own: a crash or an endless loop of it ends that process and nothing else.
//!
//! ```text
//! Child (Component) --calls--> standard input  of `plcfmu tool-child FILE.fmu FOLDER` --> Instance
//!                  <--reply--- standard output
//! ```
//!
//! The messages of [`framing`] are in the format of postcard. The calls of one
//! message are made in their order up to the first that fails; there is one reply to all of them. Writing is held back until
//! the next other call, so that a step takes one message.

use anyhow::{Context, Result, anyhow, bail, ensure};
use host::fmu::Fmu;
use host::framing::{self, FAREWELL, receive, send};
use host::instance::Instance;
use host::package::{Package, temporary};
use host::standard_output;
use run::component::{Component, Type};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::process::{self, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;
use tempfile::TempDir;

/// The hidden command that is the other side.
pub const COMMAND: &str = "tool-child";

/// What the child is to do.
#[derive(Debug, Deserialize, Serialize)]
enum Call {
    /// The library's table, as JSON.
    Interface,
    Instantiate(String),
    Setup(f64, Option<f64>),
    EnterInitialization,
    ExitInitialization,
    Read(u8, Vec<u32>),
    Write(u8, Vec<u32>, Vec<f64>),
    Step(f64, f64),
    Terminate,
}

impl Call {
    /// What happens to the FMU then, after "while it".
    fn doing(&self) -> &'static str {
        match self {
            Call::Interface => "was loaded",
            Call::Instantiate(_) => "was instantiated",
            Call::Setup(..) => "was set up",
            Call::EnterInitialization | Call::ExitInitialization => "was initialized",
            Call::Read(..) => "was read",
            Call::Write(..) => "was set",
            Call::Step(..) => "made a step",
            Call::Terminate => "was terminated",
        }
    }
}

/// What the child answers.
#[derive(Debug, Deserialize, Serialize)]
enum Reply {
    Done,
    Values(Vec<f64>),
    Text(String),
    /// What the FMU refused, and why.
    Refused(String),
}

/// The processes of a server: whoever ends it ends them all.
#[derive(Clone, Debug, Default)]
pub struct Processes(Arc<Mutex<Running>>);

#[derive(Debug, Default)]
struct Running {
    processes: Vec<Arc<Mutex<process::Child>>>,
    is_over: bool,
}

impl Processes {
    /// Kills them all; no other can be started.
    pub fn kill(&self) {
        let mut running = lock(&self.0);
        running.is_over = true;
        for process in running.processes.drain(..) {
            // One that has ended needs no end.
            let _ = lock(&process).kill();
        }
    }

    fn start(&self, command: &mut Command) -> Result<Arc<Mutex<process::Child>>> {
        let mut running = lock(&self.0);
        ensure!(!running.is_over, "the server is shutting down");
        let process = Arc::new(Mutex::new(command.spawn()?));
        running.processes.push(process.clone());
        Ok(process)
    }

    fn forget(&self, process: &Arc<Mutex<process::Child>>) {
        lock(&self.0).processes.retain(|other| !Arc::ptr_eq(other, process));
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An instance of a foreign FMU, in a process of its own. The process ends when this is dropped.
#[derive(Debug)]
pub struct Child {
    process: Arc<Mutex<process::Child>>,
    processes: Processes,
    /// `None` when no more calls will come.
    calls: Option<ChildStdin>,
    replies: Receiver<Vec<u8>>,
    /// How long a message may take.
    limit: Duration,
    /// Calls that are made with the next message.
    queued: Vec<Call>,
    /// Why the process has ended.
    end: Option<String>,
    /// The FMU is unpacked here; removed after the process is gone.
    _folder: TempDir,
}

/// How to start processes.
#[derive(Clone, Debug)]
pub struct Starter {
    /// The program `plcfmu`.
    pub program: PathBuf,
    /// How long a call of an FMU may take.
    pub limit: Duration,
    /// Where the processes are kept.
    pub processes: Processes,
}

impl Starter {
    /// Instantiates the FMU at `path` in a new process.
    ///
    /// # Errors
    /// The FMU cannot be loaded or refuses, or it crashes or hangs.
    pub fn instantiate(&self, path: &Path, name: &str) -> Result<Child> {
        let mut child = self.start(path)?;
        child.done(Call::Instantiate(name.into()))?;
        Ok(child)
    }

    /// The table of the FMU at `path`, as JSON.
    ///
    /// # Errors
    /// It has none, or as for [`Starter::instantiate`].
    pub fn interface(&self, path: &Path) -> Result<String> {
        match self.start(path)?.ask(Call::Interface)? {
            Reply::Text(json) => Ok(json),
            other => bail!("its process answered {other:?}"),
        }
    }

    fn start(&self, path: &Path) -> Result<Child> {
        let folder = temporary::builder().tempdir().context("there is no folder for temporary files")?;
        let mut command = Command::new(&self.program);
        command.arg(COMMAND).arg(path).arg(folder.path());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        let process =
            self.processes.start(&mut command).with_context(|| format!("{} cannot run", self.program.display()))?;
        let (calls, from_child) = {
            let mut process = lock(&process);
            (process.stdin.take(), process.stdout.take())
        };
        let (sender, replies) = mpsc::channel();
        let mut from_child = from_child.context("the process has no standard output")?;
        thread::spawn(move || {
            // The end of the process ends this thread too.
            while let Ok(Some(reply)) = receive(&mut from_child) {
                if sender.send(reply).is_err() {
                    break;
                }
            }
        });
        Ok(Child {
            process,
            processes: self.processes.clone(),
            calls,
            replies,
            limit: self.limit,
            queued: Vec::new(),
            end: None,
            _folder: folder,
        })
    }
}

impl Child {
    /// Makes the calls that are held back, and this one.
    fn ask(&mut self, call: Call) -> Result<Reply> {
        if let Some(end) = &self.end {
            bail!("{end}");
        }
        let doing = call.doing();
        self.queued.push(call);
        let message = postcard::to_stdvec(&self.queued).map_err(anyhow::Error::new);
        self.queued.clear();
        let message = message?;
        let is_sent = self.calls.as_mut().is_some_and(|calls| send(calls, &message).is_ok());
        // Who could not be sent anything has ended, and so has its output.
        let reply = match self.replies.recv_timeout(self.limit) {
            Ok(reply) if is_sent => reply,
            Err(RecvTimeoutError::Timeout) => return Err(self.give_up(doing)),
            _ => return Err(self.has_ended(doing)),
        };
        match postcard::from_bytes(&reply) {
            Ok(Reply::Refused(message)) => Err(anyhow!(message)),
            Ok(reply) => Ok(reply),
            Err(_) => {
                let _ = lock(&self.process).kill();
                Err(self.ended(format!("the FMU disturbed its process while it {doing}: the process was ended")))
            }
        }
    }

    fn done(&mut self, call: Call) -> Result<()> {
        match self.ask(call)? {
            Reply::Done => Ok(()),
            other => bail!("its process answered {other:?}"),
        }
    }

    /// Ends a process that does not answer.
    fn give_up(&mut self, doing: &str) -> anyhow::Error {
        let _ = lock(&self.process).kill();
        let seconds = self.limit.as_secs_f64();
        self.ended(format!("the FMU did not return within {seconds} s while it {doing}: its process was ended"))
    }

    /// Says how a process has ended by itself.
    fn has_ended(&mut self, doing: &str) -> anyhow::Error {
        let mut process = lock(&self.process);
        // It may have closed its output alone. The status of one that has ended stays as it is.
        let _ = process.kill();
        let status = process.wait();
        drop(process);
        let status = status.map_or_else(|error| error.to_string(), |status| status.to_string());
        self.ended(format!("the FMU crashed while it {doing}: its process ended with {status}"))
    }

    fn ended(&mut self, why: String) -> anyhow::Error {
        self.end = Some(why.clone());
        anyhow!(why)
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // It frees its instance and ends when nothing more can come; then its output ends.
        drop(self.calls.take());
        if self.end.is_none() && self.replies.recv_timeout(FAREWELL) != Err(RecvTimeoutError::Disconnected) {
            let _ = lock(&self.process).kill();
        }
        let mut process = lock(&self.process);
        // Its output is closed, but it may not be gone.
        if self.end.is_some() {
            let _ = process.kill();
        }
        let _ = process.wait();
        drop(process);
        self.processes.forget(&self.process);
    }
}

impl Component for Child {
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.done(Call::Setup(start, stop))
    }

    fn enter_initialization(&mut self) -> Result<()> {
        self.done(Call::EnterInitialization)
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.done(Call::ExitInitialization)
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        match self.ask(Call::Read(number(kind), references.to_vec()))? {
            Reply::Values(read) if read.len() == values.len() => values.copy_from_slice(&read),
            other => bail!("its process answered {other:?}"),
        }
        Ok(())
    }

    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        if let Some(end) = &self.end {
            bail!("{end}");
        }
        self.queued.push(Call::Write(number(kind), references.to_vec(), values.to_vec()));
        Ok(())
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        self.done(Call::Step(time, size))
    }

    fn terminate(&mut self) -> Result<()> {
        self.done(Call::Terminate)
    }
}

/// A type as a message has it.
fn number(kind: Type) -> u8 {
    Type::ALL.iter().position(|other| *other == kind).map_or(u8::MAX, |place| place as u8)
}

fn kind(number: u8) -> Result<Type> {
    Type::ALL.get(usize::from(number)).copied().context("there is no such type")
}

/// The other side: what `plcfmu tool-child FILE.fmu FOLDER` does until its input ends.
#[derive(clap::Args, Clone, Debug)]
pub struct Options {
    /// The FMU
    file: PathBuf,
    /// Where it is unpacked
    folder: PathBuf,
}

/// Runs an FMU as it is told on standard input.
///
/// # Errors
/// There is no standard output.
pub fn run(options: &Options) -> Result<()> {
    let mut replies = standard_output::take().context("standard output")?;
    let (messages, at_work) = framing::input();
    let mut fmu = Package::open(&options.file).and_then(|mut package| Fmu::load(&mut package, &options.folder));
    let mut instance = None;
    for message in messages {
        let calls: Vec<Call> = postcard::from_bytes(&message)?;
        let mut reply = Reply::Done;
        for call in calls {
            reply = make(&mut fmu, &mut instance, call).unwrap_or_else(|error| Reply::Refused(format!("{error:#}")));
            if matches!(reply, Reply::Refused(_)) {
                break;
            }
        }
        send(&mut replies, &postcard::to_stdvec(&reply)?)?;
    }
    drop(instance);
    drop(fmu);
    drop(replies);
    // Without waiting for the thread above, which must not believe that this is over before.
    drop(at_work);
    process::exit(0)
}

fn make(fmu: &mut Result<Fmu>, instance: &mut Option<Instance>, call: Call) -> Result<Reply> {
    let fmu = match fmu {
        Ok(fmu) => fmu,
        Err(error) => bail!("{error:#}"),
    };
    let made = |instance: &mut Option<Instance>, act: &dyn Fn(&mut Instance) -> Result<()>| -> Result<Reply> {
        act(instance.as_mut().context("the FMU has not been instantiated")?)?;
        Ok(Reply::Done)
    };
    match call {
        Call::Interface => fmu.library.interface().map(Reply::Text),
        Call::Instantiate(name) => {
            *instance = Some(fmu.instantiate(&name)?);
            Ok(Reply::Done)
        }
        Call::Read(type_number, references) => {
            let mut values = vec![0.0; references.len()];
            let of = instance.as_mut().context("the FMU has not been instantiated")?;
            of.get_all(kind(type_number)?, &references, &mut values)?;
            Ok(Reply::Values(values))
        }
        Call::Setup(start, stop) => made(instance, &|of| of.setup(start, stop)),
        Call::EnterInitialization => made(instance, &Instance::enter_initialization),
        Call::ExitInitialization => made(instance, &Instance::exit_initialization),
        Call::Write(number, references, values) => {
            ensure!(references.len() == values.len(), "there are not as many values as variables");
            made(instance, &|of| of.set_all(kind(number)?, &references, &values))
        }
        Call::Step(time, size) => made(instance, &|of| of.step(time, size)),
        Call::Terminate => made(instance, &Instance::terminate),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_arrive_as_they_were_sent_up_to_the_end_of_the_stream() {
        let calls = vec![Call::Write(number(Type::Real), vec![7], vec![f64::NAN, -0.0]), Call::Step(0.1, 0.2)];
        let mut stream = Vec::new();
        send(&mut stream, &postcard::to_stdvec(&calls).unwrap()).unwrap();
        send(&mut stream, &[]).unwrap();
        let mut stream = stream.as_slice();
        let calls: Vec<Call> = postcard::from_bytes(&receive(&mut stream).unwrap().unwrap()).unwrap();
        let [Call::Write(0, references, values), Call::Step(time, size)] = calls.as_slice() else {
            panic!("{calls:?}")
        };
        assert_eq!((references.as_slice(), *time, *size), ([7].as_slice(), 0.1, 0.2));
        assert_eq!([values[0].to_bits(), values[1].to_bits()], [f64::NAN.to_bits(), (-0.0_f64).to_bits()]);
        assert_eq!(receive(&mut stream).unwrap(), Some(Vec::new()));
        assert_eq!(receive(&mut stream).unwrap(), None);
    }

    #[test]
    fn the_types_have_numbers() {
        for of in Type::ALL {
            assert_eq!(kind(number(of)).unwrap(), of);
        }
        kind(9).unwrap_err();
    }
}
