//! A safe wrapper for an instance of an FMU, which includes the FMU's messages in errors.
//!
//! `v2` and `v3` implement the calls of each version; their results are evaluated here, identically for both.

#![allow(unsafe_code)]

mod v2;
mod v3;

use crate::library::{self, Library, Opened};
use anyhow::{Context, Result, anyhow, bail};
use modeldescription::Array;
pub use run::component::Type;
use run::component::{Component, Reset, Terminated, Update};
use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int};
use std::sync::{Mutex, OnceLock, PoisonError};

/// The values of fmi2Status and fmi3Status, in order, without the prefix.
const STATUS: [&str; 6] = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];
const WARNING: c_int = 1;
const DISCARD: c_int = 2;
const FATAL: c_int = 4;

/// The number of messages kept; newer ones replace the oldest.
const MOST_MESSAGES: usize = 100;

/// The length up to which a message is kept in full, in bytes.
const LONGEST_MESSAGE: usize = 4096;

/// An instance of an FMU for co-simulation. It is freed when dropped, unless the FMU has reported a fatal error.
#[derive(Debug)]
pub struct Instance {
    called: Called,
    /// Whether a call returned fmi2Fatal or fmi3Fatal. The standard then forbids all calls, even the one that frees the
    /// instance.
    is_fatal: Cell<bool>,
    // The FMU may keep a pointer to this: it must not move and must outlive the library.
    messages: Box<Messages>,
}

/// The instance, by FMI version.
#[derive(Debug)]
enum Called {
    V2(Box<v2::Instance>),
    V3(Box<v3::Instance>),
}

/// A failed call: its function and status.
type Failed = (&'static str, c_int);

/// The arguments of an instantiation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Start<'a> {
    /// The name of the instance.
    pub name: &'a str,
    /// The GUID, or the FMI 3.0 instantiation token.
    pub guid: &'a str,
    /// The location of the unpacked resources: a URI in FMI 2.0, a path in FMI 3.0. FMUs without resources accept
    /// `None`.
    pub resources: Option<&'a str>,
    /// The arrays of the FMU, with the start values of their elements.
    pub arrays: &'a [(Array, Vec<f64>)],
    /// Whether Event Mode is used, which FMI 2.0 does not have.
    pub has_events: bool,
}

/// A message logged by an FMU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Whether its status is Discard or worse.
    pub is_error: bool,
    /// The text. For a message with variadic arguments, only the format is known; see [`Instance::instantiate`].
    pub text: String,
}

/// The messages received by the logger, on any thread.
#[derive(Debug)]
struct Messages {
    /// The name of the instance.
    of: String,
    messages: Mutex<Vec<Message>>,
}

/// A callback for log messages: the name of the instance, and the text.
type Listener = Box<dyn Fn(&str, &str) + Send + Sync>;

static LISTENER: OnceLock<Listener> = OnceLock::new();

/// Sets a listener that immediately receives every message logged by any instance in this process, with the instance's
/// name. Only the first call has an effect.
pub fn listen(listener: impl Fn(&str, &str) + Send + Sync + 'static) {
    let _ = LISTENER.set(Box::new(listener));
}

impl Messages {
    fn add(&self, message: Message) {
        if let Some(listener) = LISTENER.get() {
            listener(&self.of, &message.text);
        }
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.len() == MOST_MESSAGES {
            messages.remove(0);
        }
        messages.push(message);
    }

    fn take(&self) -> Vec<Message> {
        std::mem::take(&mut *self.messages.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The messages that explain a failure: the errors, or all messages if there are none.
    fn explanation(&self) -> String {
        let messages = self.take();
        let has_errors = messages.iter().any(|message| message.is_error);
        let texts = messages.iter().filter(|message| message.is_error || !has_errors);
        let texts: Vec<&str> = texts.map(|message| message.text.as_str()).collect();
        if texts.is_empty() { "the FMU logged no reason".into() } else { texts.join("; ") }
    }
}

/// Evaluates an expression with the instance of either version as `$of`.
macro_rules! call {
    ($self:ident, $of:ident => $result:expr) => {
        match &mut $self.called {
            Called::V2($of) => $result,
            Called::V3($of) => $result,
        }
    };
}

impl Instance {
    /// Calls `fmi2Instantiate`, for co-simulation and with logging on. `resources` is the URI of the unpacked
    /// resources; FMUs without resources accept `None`.
    ///
    /// FMI's logger is variadic, and Rust cannot read variadic arguments. A message of the form `"%s", text`, which
    /// most FMUs use, is read in full. For any other message, only the format is kept.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    pub fn instantiate(library: &Library, name: &str, guid: &str, resources: Option<&str>) -> Result<Instance> {
        Instance::start(&Opened::V2(library.clone()), &Start { name, guid, resources, ..Start::default() })
    }

    /// Creates an instance of an FMU of either version, for co-simulation and with logging on.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    pub fn start(library: &Opened, start: &Start) -> Result<Instance> {
        let text = |text: &str| CString::new(text).with_context(|| format!("{text:?} contains a NUL character"));
        let messages = Box::new(Messages { of: start.name.into(), messages: Mutex::default() });
        let (name, guid) = (text(start.name)?, text(start.guid)?);
        let resources = start.resources.map(text).transpose()?;
        let called = match library {
            Opened::V2(_) if start.has_events => bail!("it is an FMI 2.0 FMU, which has no Event Mode"),
            Opened::V2(library) => v2::Instance::new(library, &name, &guid, resources.as_deref(), &messages)
                .map(|of| Called::V2(Box::new(of)))
                .with_context(|| format!("fmi2Instantiate returned no instance: {}", messages.explanation()))?,
            Opened::V3(library) => v3::Instance::new(library, &name, &guid, resources.as_deref(), &messages, start)
                .map(|of| Called::V3(Box::new(of)))
                .with_context(|| {
                    format!("fmi3InstantiateCoSimulation returned no instance: {}", messages.explanation())
                })?,
        };
        Ok(Instance { called, is_fatal: Cell::new(false), messages })
    }

    /// Calls `fmi2SetupExperiment` with the start and, if known, the end of the simulation in seconds. An FMI 3.0
    /// FMU receives them in [`Instance::enter_initialization`].
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    pub fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        let done = call!(self, of => of.setup(start, stop));
        self.check(done)
    }

    /// Calls `fmi2EnterInitializationMode` or `fmi3EnterInitializationMode`.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    pub fn enter_initialization(&mut self) -> Result<()> {
        let done = call!(self, of => of.enter_initialization());
        self.check(done)
    }

    /// Calls `fmi2ExitInitializationMode` or `fmi3ExitInitializationMode`; an instance that uses Event
    /// Mode is then in it.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    pub fn exit_initialization(&mut self) -> Result<()> {
        let done = call!(self, of => of.exit_initialization());
        self.check(done)
    }

    /// Calls `fmi2DoStep` or `fmi3DoStep` from `time` to `time + size`, in seconds. If the instance uses Event
    /// Mode, events within the step are handled, except at its end.
    ///
    /// # Errors
    /// The FMU refuses or discards the step, or works asynchronously (fmi2Pending); the error contains its messages.
    /// [`Terminated`] if the FMU ended the simulation.
    #[inline]
    pub fn step(&mut self, time: f64, size: f64) -> Result<()> {
        let done = match &mut self.called {
            Called::V2(of) => of.step(time, size),
            Called::V3(of) => of.step(time, size),
        };
        match done {
            Ok(()) => Ok(()),
            Err(stopped) => Err(self.in_step(stopped, time, size)),
        }
    }

    /// The error for a step that failed. Separate from [`Instance::step`] to keep the code of successful steps small.
    #[cold]
    #[inline(never)]
    fn in_step(&self, stopped: Stopped, time: f64, size: f64) -> anyhow::Error {
        let error = match stopped {
            Stopped::Failed((function, status)) => self.failure(function, status),
            Stopped::Terminated => Terminated.into(),
            Stopped::Astray(what) => anyhow!(what),
        };
        error.context(format!("at {time:?} s, step {size:?} s"))
    }

    /// Enters Event Mode unless it is active.
    ///
    /// # Errors
    /// The FMU refuses the call (the error contains its messages), or has no Event Mode.
    pub fn enter_events(&mut self) -> Result<()> {
        let Called::V3(of) = &mut self.called else { bail!("it is an FMI 2.0 FMU, which has no Event Mode") };
        let done = of.enter_events();
        self.check(done)
    }

    /// Calls `fmi3UpdateDiscreteStates`, in Event Mode.
    ///
    /// # Errors
    /// The FMU refuses the call (the error contains its messages) or has no Event Mode; [`Terminated`] if it ended the
    /// simulation.
    pub fn update(&mut self) -> Result<Update> {
        let Called::V3(of) = &mut self.called else { bail!("it is an FMI 2.0 FMU, which has no Event Mode") };
        match of.update() {
            Ok(update) => Ok(update),
            Err(Stopped::Terminated) => Err(Terminated.into()),
            Err(Stopped::Failed((function, status))) => Err(self.failure(function, status)),
            Err(Stopped::Astray(what)) => Err(anyhow!(what)),
        }
    }

    /// Calls `fmi3EnterStepMode`.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    pub fn leave_events(&mut self) -> Result<()> {
        let Called::V3(of) = &mut self.called else { bail!("it is an FMI 2.0 FMU, which has no Event Mode") };
        let done = of.leave_events();
        self.check(done)
    }

    /// Calls `fmi2Terminate` or `fmi3Terminate`.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    pub fn terminate(&mut self) -> Result<()> {
        let done = call!(self, of => of.terminate());
        self.check(done)
    }

    /// Calls `fmi2Reset` or `fmi3Reset`, after which the instance is as if newly created.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    pub fn reset(&mut self) -> Result<()> {
        let done = call!(self, of => of.reset());
        self.check(done)
    }

    /// Reads a variable; true is 1. A 64-bit integer is rounded to the nearest `f64`.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    pub fn get(&mut self, kind: Type, reference: u32) -> Result<f64> {
        let mut cell = [0.0];
        self.get_all(kind, &[reference], &mut cell)?;
        Ok(kind.number(cell[0]))
    }

    /// Sets a variable; for a Boolean, 0 is false and anything else true.
    ///
    /// # Errors
    /// The FMU refuses the call (the error contains its messages), or the value is not valid for the type.
    pub fn set(&mut self, kind: Type, reference: u32, value: f64) -> Result<()> {
        self.set_all(kind, &[reference], &[kind.cell(value)])
    }

    /// Reads several variables of one type in one call, as cells ([`Type::cell`]); true is 1.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains its messages.
    ///
    /// # Panics
    /// The numbers of values and references differ.
    #[inline]
    pub fn get_all(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        assert!(references.len() == values.len(), "there is a value for each reference");
        let done = call!(self, of => of.get_all(kind, references, values));
        self.check(done)
    }

    /// Sets several variables of one type in one call to values given as cells ([`Type::cell`]); for a Boolean, 0 is
    /// false and anything else true.
    ///
    /// # Errors
    /// As [`Instance::set`].
    ///
    /// # Panics
    /// The numbers of values and references differ.
    #[inline]
    pub fn set_all(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        assert!(references.len() == values.len(), "there is a value for each reference");
        let done = call!(self, of => of.set_all(kind, references, values));
        match done {
            Ok(()) => Ok(()),
            Err(Unset::Failed((function, status))) => Err(self.failure(function, status)),
            Err(Unset::Value(value)) => Err(unfit(kind, value)),
        }
    }

    /// Returns and clears the messages logged by the FMU; if there were more than 100, the latest 100.
    pub fn take_messages(&mut self) -> Vec<Message> {
        self.messages.take()
    }

    #[inline]
    fn check(&self, done: Result<(), Failed>) -> Result<()> {
        match done {
            Ok(()) => Ok(()),
            Err((function, status)) => Err(self.failure(function, status)),
        }
    }

    #[cold]
    #[inline(never)]
    fn failure(&self, function: &str, status: c_int) -> anyhow::Error {
        let (lacks, prefix) = match &self.called {
            Called::V2(of) => (of.library.lacks(function), library::PREFIX),
            Called::V3(of) => (of.library.lacks(function), library::v3::PREFIX),
        };
        if lacks {
            return anyhow!("its library lacks {function}");
        }
        self.is_fatal.set(self.is_fatal.get() || status == FATAL);
        let name = usize::try_from(status).ok().and_then(|status| STATUS.get(status));
        let name = name.map_or_else(|| format!("the unknown status {status}"), |name| format!("{prefix}{name}"));
        let explanation = self.messages.explanation();
        // Many FMUs start their messages with the function's name.
        let explanation =
            explanation.strip_prefix(function).and_then(|rest| rest.strip_prefix(": ")).unwrap_or(&explanation);
        anyhow!("{function} returned {name}: {explanation}")
    }
}

/// The reason why a step or update was not completed.
#[derive(Debug)]
enum Stopped {
    Failed(Failed),
    /// The FMU ended the simulation.
    Terminated,
    /// The FMU returned invalid data.
    Astray(String),
}

/// The reason why a variable was not set.
#[derive(Debug)]
enum Unset {
    Failed(Failed),
    /// The value is not valid for the type.
    Value(f64),
}

/// Accepts OK and Warning; any other status is a failure.
#[inline]
fn done(function: &'static str, status: c_int) -> Result<(), Failed> {
    if status == 0 || status == WARNING { Ok(()) } else { Err((function, status)) }
}

#[cold]
#[inline(never)]
fn unfit(kind: Type, value: f64) -> anyhow::Error {
    match kind.whole() {
        Some((low, high)) if kind != Type::Integer => {
            anyhow!("{value:?} is not a whole number from {low} to {high}, the range of {}", kind.name())
        }
        None if kind.is_floating() => anyhow!("{value:?} is outside the range of {}", kind.name()),
        _ => anyhow!("{value:?} is not a 32-bit integer"),
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if !self.is_fatal.get() {
            call!(self, of => of.free());
        }
    }
}

/// A string from the FMU, unless it is NULL.
///
/// # Safety
/// `text` must be NULL or a C string.
unsafe fn said(text: *const c_char) -> Option<String> {
    // SAFETY: guaranteed by the caller.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
}

/// Truncates a long message and appends its length.
fn cut(mut text: String) -> String {
    let length = text.len();
    if length > LONGEST_MESSAGE {
        text.truncate(text.floor_char_boundary(LONGEST_MESSAGE));
        text.push_str(&format!("... (cut: the message has {length} bytes)"));
    }
    text
}

impl Component for Instance {
    fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        Instance::setup(self, start, stop)
    }

    fn enter_initialization(&mut self) -> Result<()> {
        Instance::enter_initialization(self)
    }

    fn exit_initialization(&mut self) -> Result<()> {
        Instance::exit_initialization(self)
    }

    #[inline]
    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.get_all(kind, references, values)
    }

    #[inline]
    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        self.set_all(kind, references, values)
    }

    #[inline]
    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        Instance::step(self, time, size)
    }

    fn enter_events(&mut self) -> Result<()> {
        Instance::enter_events(self)
    }

    fn update(&mut self) -> Result<Update> {
        Instance::update(self)
    }

    fn leave_events(&mut self) -> Result<()> {
        Instance::leave_events(self)
    }

    fn terminate(&mut self) -> Result<()> {
        Instance::terminate(self)
    }
}

impl Reset for Instance {
    fn reset(&mut self) -> Result<()> {
        Instance::reset(self)
    }
}

#[cfg(test)]
#[test]
fn of_a_long_message_the_beginning_is_kept_and_how_long_it_is() {
    assert_eq!(cut("the sensor is broken".into()), "the sensor is broken");
    // Two bytes each, after one: the limit is in the middle of one of them.
    let long = cut(format!("x{}", "ä".repeat(25_000_000)));
    assert_eq!(long, format!("x{}... (cut: the message has 50000001 bytes)", "ä".repeat(2047)));
}
