//! An instance of a foreign FMU in a separate process, see [`host::child`]: a crash or an endless loop ends only that
//! process.
//!
//! The calls in one message are made in order up to the first that fails, with a single reply. Writes are queued until
//! the next other call, so that a step needs only one message.

use anyhow::{Context, Result, anyhow, bail, ensure};
use host::child::{self, End, Prints, Process, serve};
use host::fmu::Fmu;
use host::instance::Instance;
use host::package::Package;
use run::component::{Component, Type};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The role of the child process, a command-line argument.
pub const ROLE: &str = "instance";

/// A call for the child to make.
#[derive(Debug, Deserialize, Serialize)]
enum Call {
    Open(PathBuf),
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
    /// The FMU's activity during the call, to complete "while it ...".
    fn doing(&self) -> &'static str {
        match self {
            Call::Open(_) => "was being loaded",
            Call::Instantiate(_) => "was being instantiated",
            Call::Setup(..) => "was being set up",
            Call::EnterInitialization | Call::ExitInitialization => "was being initialized",
            Call::Read(..) => "was being read",
            Call::Write(..) => "was being set",
            Call::Step(..) => "was making a step",
            Call::Terminate => "was being terminated",
        }
    }
}

/// The child's reply.
#[derive(Debug, Deserialize, Serialize)]
enum Reply {
    Done,
    Values(Vec<f64>),
    /// A call was refused, for this reason.
    Refused(String),
}

/// An instance of a foreign FMU, in a separate process. The process ends when this is dropped.
#[derive(Debug)]
pub struct Child {
    process: Process,
    /// Calls that will be sent with the next message.
    queued: Vec<Call>,
    /// Why the process has ended; `None` while it runs.
    end: Option<String>,
}

/// Instantiates the FMU in a separate process. `starter` specifies the time limit of its calls.
///
/// # Errors
/// The FMU at `path` cannot be loaded, refuses a call, crashes or hangs.
pub fn instantiate(starter: &child::Starter, path: &Path, name: &str) -> Result<Child> {
    let mut child = Child::start(starter, path)?;
    child.done(Call::Instantiate(name.into()))?;
    Ok(child)
}

impl Child {
    fn start(starter: &child::Starter, path: &Path) -> Result<Child> {
        let process = starter.start(ROLE, Prints::Shown)?;
        Ok(Child { process, queued: vec![Call::Open(path.to_path_buf())], end: None })
    }

    /// Makes the queued calls, then this one.
    fn ask(&mut self, call: Call) -> Result<Reply> {
        if let Some(end) = &self.end {
            bail!("{end}");
        }
        let doing = call.doing();
        self.queued.push(call);
        self.process.send(&self.queued);
        self.queued.clear();
        match self.process.receive(|_| false) {
            Ok(Reply::Refused(message)) => Err(anyhow!(message)),
            Ok(reply) => Ok(reply),
            Err(end) => {
                let why = match end {
                    End::Interrupted => "interrupted".into(),
                    End::Ended(what) => format!("the FMU {what} while it {doing}"),
                };
                self.end = Some(why.clone());
                Err(anyhow!(why))
            }
        }
    }

    fn done(&mut self, call: Call) -> Result<()> {
        match self.ask(call)? {
            Reply::Done => Ok(()),
            other => bail!("its process answered {other:?}"),
        }
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

/// A type's number in a message.
fn number(kind: Type) -> u8 {
    Type::ALL.iter().position(|other| *other == kind).map_or(u8::MAX, |place| place as u8)
}

fn kind(number: u8) -> Result<Type> {
    Type::ALL.get(usize::from(number)).copied().context("no such type")
}

/// Runs the FMU unpacked in `folder` as requested on standard input.
///
/// # Errors
/// Standard output is missing, or the other side has closed the connection.
pub fn run(folder: &Path) -> Result<()> {
    serve(folder, |channel| {
        let (mut fmu, mut instance) = (None, None);
        while let Some(calls) = channel.next::<Vec<Call>>()? {
            let mut reply = Reply::Done;
            for call in calls {
                let made = match call {
                    Call::Open(path) => {
                        let loaded = Package::open(&path).and_then(|mut package| Fmu::load(&mut package, folder));
                        loaded.map(|loaded| {
                            fmu = Some(loaded);
                            Reply::Done
                        })
                    }
                    call => make(fmu.as_ref(), &mut instance, call),
                };
                reply = made.unwrap_or_else(|error| Reply::Refused(format!("{error:#}")));
                if matches!(reply, Reply::Refused(_)) {
                    break;
                }
            }
            channel.send(&reply)?;
        }
        drop(instance);
        Ok(())
    })
}

fn make(fmu: Option<&Fmu>, instance: &mut Option<Instance>, call: Call) -> Result<Reply> {
    let fmu = fmu.context("the FMU has not been loaded")?;
    let made = |instance: &mut Option<Instance>, act: &dyn Fn(&mut Instance) -> Result<()>| -> Result<Reply> {
        act(instance.as_mut().context("the FMU has not been instantiated")?)?;
        Ok(Reply::Done)
    };
    match call {
        Call::Open(_) => bail!("the FMU is loaded already"),
        Call::Instantiate(name) => {
            *instance = Some(fmu.instantiate(&name, false)?);
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
            ensure!(references.len() == values.len(), "the numbers of values and variables differ");
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
    fn the_types_have_numbers() {
        for of in Type::ALL {
            assert_eq!(kind(number(of)).unwrap(), of);
        }
        kind(Type::ALL.len() as u8).unwrap_err();
    }
}
