//! An instance of an FMU: safe to use, with the messages of the FMU in the errors.

#![allow(unsafe_code)]

use crate::library::{CallbackFunctions, Library, Logger, Pointer};
use anyhow::{Context, Result, anyhow, bail};
pub use run::component::Type;
use run::component::{Component, Reset, Terminated};
use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr;
use std::sync::{Mutex, OnceLock, PoisonError};

/// fmi2CoSimulation.
const CO_SIMULATION: c_int = 1;

/// The values of fmi2Status, in order.
const STATUS: [&str; 6] = ["fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending"];
const WARNING: c_int = 1;
const DISCARD: c_int = 2;
const FATAL: c_int = 4;

/// The fmi2StatusKind that tells whether an FMU ends the simulation.
const TERMINATED: c_int = 3;

/// This many messages are kept; later ones replace the earliest.
const MOST_MESSAGES: usize = 100;

/// The longest message that is kept whole, in bytes.
const LONGEST_MESSAGE: usize = 4096;

/// An instance of an FMU for co-simulation. It is freed when it is dropped.
#[derive(Debug)]
pub struct Instance {
    library: Library,
    component: Pointer,
    /// After fmi2Fatal the standard allows no call at all, not even fmi2FreeInstance.
    is_fatal: Cell<bool>,
    /// Integers and Booleans on their way to and from the FMU; kept, so that a step allocates nothing.
    integers: Vec<c_int>,
    // The FMU may keep pointers to both: they stay where they are, and go after the library.
    messages: Box<Messages>,
    _callbacks: Box<CallbackFunctions>,
}

/// What an FMU has logged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Whether its status is fmi2Discard or worse.
    pub is_error: bool,
    /// The text. Of a text with variables only the format is known, see [`Instance::instantiate`].
    pub text: String,
}

/// Filled by the logger, on any thread.
#[derive(Debug)]
struct Messages {
    /// The name of the instance.
    of: String,
    messages: Mutex<Vec<Message>>,
}

/// Gets what each instance logs, with its name.
type Listener = Box<dyn Fn(&str, &str) + Send + Sync>;

static LISTENER: OnceLock<Listener> = OnceLock::new();

/// Sets who gets at once what any instance of this process logs, with its name. Only the first call has an effect.
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

    /// What explains a failure: the errors, or everything if there are none.
    fn explanation(&self) -> String {
        let messages = self.take();
        let has_errors = messages.iter().any(|message| message.is_error);
        let texts = messages.iter().filter(|message| message.is_error || !has_errors);
        let texts: Vec<&str> = texts.map(|message| message.text.as_str()).collect();
        if texts.is_empty() { "the FMU logged no reason".into() } else { texts.join("; ") }
    }
}

impl Instance {
    /// `fmi2Instantiate`, for co-simulation and with logging on. `resources` is the URI of the unpacked resources; FMUs
    /// that need none accept `None`.
    ///
    /// FMI's logger is variadic, and Rust cannot read variadic arguments. A message in the form `"%s", text`, which most
    /// FMUs use, is read in full. Of any other the format is kept as it is.
    ///
    /// # Errors
    /// The FMU refuses, with its messages.
    pub fn instantiate(library: &Library, name: &str, guid: &str, resources: Option<&str>) -> Result<Instance> {
        let text = |text: &str| CString::new(text).with_context(|| format!("{text:?} contains a NUL"));
        let resources = resources.map(text).transpose()?;
        let messages = Box::new(Messages { of: name.into(), messages: Mutex::default() });
        let callbacks = Box::new(CallbackFunctions {
            logger: Some(logger()),
            allocate_memory: Some(calloc),
            free_memory: Some(free),
            step_finished: None,
            environment: ptr::from_ref(&*messages).cast_mut().cast(),
        });
        let (name, guid) = (text(name)?, text(guid)?);
        // SAFETY: the strings end with NUL and outlive the call; callbacks and messages live as long as
        // the instance.
        let component = unsafe {
            (library.instantiate)(
                name.as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                resources.as_ref().map_or(ptr::null(), |uri| uri.as_ptr()),
                &*callbacks,
                0,
                1,
            )
        };
        if component.is_null() {
            bail!("fmi2Instantiate returned no instance: {}", messages.explanation());
        }
        let library = library.clone();
        let is_fatal = Cell::new(false);
        Ok(Instance { library, component, is_fatal, integers: Vec::new(), messages, _callbacks: callbacks })
    }

    /// `fmi2SetupExperiment`: start and, if it is known, end of the simulation in seconds.
    ///
    /// # Errors
    /// The FMU refuses, with its messages.
    pub fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        let (defined, stop) = (c_int::from(stop.is_some()), stop.unwrap_or(0.0));
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.setup_experiment)(self.component, 0, 0.0, start, defined, stop) };
        self.check("fmi2SetupExperiment", status)
    }

    /// `fmi2EnterInitializationMode`
    ///
    /// # Errors
    /// The FMU refuses, with its messages.
    pub fn enter_initialization(&mut self) -> Result<()> {
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.enter_initialization_mode)(self.component) };
        self.check("fmi2EnterInitializationMode", status)
    }

    /// `fmi2ExitInitializationMode`
    ///
    /// # Errors
    /// The FMU refuses, with its messages.
    pub fn exit_initialization(&mut self) -> Result<()> {
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.exit_initialization_mode)(self.component) };
        self.check("fmi2ExitInitializationMode", status)
    }

    /// `fmi2DoStep` from `time` to `time + size`, in seconds.
    ///
    /// # Errors
    /// The FMU refuses, discards the step or answers later (fmi2Pending), with its messages; [`Terminated`].
    #[inline]
    pub fn step(&mut self, time: f64, size: f64) -> Result<()> {
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.do_step)(self.component, time, size, 1) };
        if status == DISCARD && self.has_terminated() {
            return Err(in_step(Terminated.into(), time, size));
        }
        self.check("fmi2DoStep", status).map_err(|error| in_step(error, time, size))
    }

    /// Whether the FMU has discarded a step because it ends the simulation.
    #[cold]
    fn has_terminated(&self) -> bool {
        let mut value = 0;
        // SAFETY: the component is this instance's and lives; there is room for one value.
        let status = unsafe { (self.library.get_boolean_status)(self.component, TERMINATED, &mut value) };
        status == 0 && value != 0
    }

    /// `fmi2Terminate`
    ///
    /// # Errors
    /// The FMU refuses, with its messages.
    pub fn terminate(&mut self) -> Result<()> {
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.terminate)(self.component) };
        self.check("fmi2Terminate", status)
    }

    /// `fmi2Reset`: as if it had just been instantiated.
    ///
    /// # Errors
    /// The FMU refuses, with its messages.
    pub fn reset(&mut self) -> Result<()> {
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.reset)(self.component) };
        self.check("fmi2Reset", status)
    }

    /// A variable's value; true is 1.
    ///
    /// # Errors
    /// The FMU refuses, with its messages.
    pub fn get(&self, kind: Type, reference: u32) -> Result<f64> {
        let (mut real, mut integer) = (0.0, 0);
        // SAFETY: the component is this instance's and lives; one reference, room for one value.
        let status = unsafe {
            match kind {
                Type::Real => (self.library.get_real)(self.component, &reference, 1, &mut real),
                Type::Integer => (self.library.get_integer)(self.component, &reference, 1, &mut integer),
                Type::Boolean => (self.library.get_boolean)(self.component, &reference, 1, &mut integer),
            }
        };
        self.check(getter(kind), status)?;
        Ok(if kind == Type::Real { real } else { f64::from(integer) })
    }

    /// Sets a variable; for a Boolean, 0 is false and anything else true.
    ///
    /// # Errors
    /// The FMU refuses, with its messages; the value is not an integer of 32 bits, but the variable is not Real.
    pub fn set(&mut self, kind: Type, reference: u32, value: f64) -> Result<()> {
        self.set_all(kind, &[reference], &[value])
    }

    /// The values of several variables of one type, in one call; true is 1.
    ///
    /// # Errors
    /// The FMU refuses, with its messages.
    ///
    /// # Panics
    /// There are not as many values as references.
    #[inline]
    pub fn get_all(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        assert!(references.len() == values.len(), "there is a value for each reference");
        let (from, count) = (references.as_ptr(), references.len());
        if kind == Type::Real {
            // SAFETY: the component is this instance's and lives; `count` references, and room for as many values.
            let status = unsafe { (self.library.get_real)(self.component, from, count, values.as_mut_ptr()) };
            return self.check("fmi2GetReal", status);
        }
        self.get_integers(kind, references, values)
    }

    /// The same for Integers and Booleans.
    fn get_integers(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        let (from, count) = (references.as_ptr(), references.len());
        self.integers.clear();
        self.integers.resize(count, 0);
        let integers = self.integers.as_mut_ptr();
        // SAFETY: the component is this instance's and lives; `count` references, and room for as many values.
        let status = unsafe {
            match kind {
                Type::Boolean => (self.library.get_boolean)(self.component, from, count, integers),
                _ => (self.library.get_integer)(self.component, from, count, integers),
            }
        };
        self.check(getter(kind), status)?;
        for (value, integer) in values.iter_mut().zip(&self.integers) {
            *value = f64::from(*integer);
        }
        Ok(())
    }

    /// Sets several variables of one type in one call; for a Boolean, 0 is false and anything else true.
    ///
    /// # Errors
    /// As [`Instance::set`].
    ///
    /// # Panics
    /// There are not as many values as references.
    #[inline]
    pub fn set_all(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        assert!(references.len() == values.len(), "there is a value for each reference");
        let (to, count) = (references.as_ptr(), references.len());
        if kind == Type::Real {
            // SAFETY: the component is this instance's and lives; `count` references and as many values.
            let status = unsafe { (self.library.set_real)(self.component, to, count, values.as_ptr()) };
            return self.check("fmi2SetReal", status);
        }
        self.set_integers(kind, references, values)
    }

    /// The same for Integers and Booleans.
    fn set_integers(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        let (to, count) = (references.as_ptr(), references.len());
        self.integers.clear();
        for value in values {
            let integer = *value as c_int;
            if f64::from(integer) != *value {
                bail!("{value:?} is not an integer of 32 bits");
            }
            self.integers.push(if kind == Type::Boolean { c_int::from(integer != 0) } else { integer });
        }
        // SAFETY: the component is this instance's and lives; `count` references and as many values.
        let (function, status) = unsafe {
            match kind {
                Type::Boolean => {
                    ("fmi2SetBoolean", (self.library.set_boolean)(self.component, to, count, self.integers.as_ptr()))
                }
                _ => ("fmi2SetInteger", (self.library.set_integer)(self.component, to, count, self.integers.as_ptr())),
            }
        };
        self.check(function, status)
    }

    /// What the FMU has logged since the last time; the latest 100 messages, if there were more.
    pub fn take_messages(&mut self) -> Vec<Message> {
        self.messages.take()
    }

    /// fmi2OK and fmi2Warning go on.
    #[inline]
    fn check(&self, function: &str, status: c_int) -> Result<()> {
        if status == 0 || status == WARNING { Ok(()) } else { Err(self.failure(function, status)) }
    }

    #[cold]
    fn failure(&self, function: &str, status: c_int) -> anyhow::Error {
        self.is_fatal.set(self.is_fatal.get() || status == FATAL);
        let name = usize::try_from(status).ok().and_then(|status| STATUS.get(status));
        let name = name.map_or_else(|| format!("the unknown status {status}"), ToString::to_string);
        let explanation = self.messages.explanation();
        // Many FMUs begin their messages with the function.
        let explanation =
            explanation.strip_prefix(function).and_then(|rest| rest.strip_prefix(": ")).unwrap_or(&explanation);
        anyhow!("{function} returned {name}: {explanation}")
    }
}

/// A function of its own, so that a step that succeeds does not carry its code along.
#[cold]
#[inline(never)]
fn in_step(error: anyhow::Error, time: f64, size: f64) -> anyhow::Error {
    error.context(format!("at {time:?} s, step {size:?} s"))
}

fn getter(kind: Type) -> &'static str {
    match kind {
        Type::Real => "fmi2GetReal",
        Type::Integer => "fmi2GetInteger",
        Type::Boolean => "fmi2GetBoolean",
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if !self.is_fatal.get() {
            // SAFETY: the component is this instance's, and nobody uses it afterwards.
            unsafe { (self.library.free_instance)(self.component) }
        }
    }
}

/// A logger is variadic, which Rust cannot write. Most libraries give it `"%s"` and the text, of which this one reads the
/// text where variadic arguments are passed as others are.
fn logger() -> Logger {
    type Fixed = unsafe extern "C" fn(Pointer, *const c_char, c_int, *const c_char, *const c_char, *const c_char);
    // SAFETY: both are pointers to C functions. A variadic call passes its first arguments as any other does; the last
    // is only read where that is so for the variadic ones too, see `log`.
    unsafe { std::mem::transmute::<Fixed, Logger>(log) }
}

unsafe extern "C" fn log(
    environment: Pointer,
    _instance: *const c_char,
    status: c_int,
    _category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    // SAFETY: the environment that `instantiate` gave; it lives as long as the instance.
    let Some(messages) = (unsafe { environment.cast::<Messages>().as_ref() }) else { return };
    if format.is_null() {
        return;
    }
    // SAFETY: a C string by FMI's contract.
    let format = unsafe { CStr::from_ptr(format) };
    // Apple's ARM processors pass variadic arguments elsewhere.
    let is_readable = !cfg!(all(target_vendor = "apple", target_arch = "aarch64"));
    let text = if format == c"%s" && is_readable && !text.is_null() {
        // SAFETY: with "%s" it is a C string.
        unsafe { CStr::from_ptr(text) }
    } else {
        format
    };
    let text = text.to_string_lossy().trim_end().replace("##", "#");
    messages.add(Message { is_error: status > WARNING, text: cut(text) });
}

/// A message as it is kept: of a long one the beginning, and how long it is.
fn cut(mut text: String) -> String {
    let length = text.len();
    if length > LONGEST_MESSAGE {
        text.truncate(text.floor_char_boundary(LONGEST_MESSAGE));
        text.push_str(&format!("... (cut: the message has {length} bytes)"));
    }
    text
}

// For FMUs that let the host manage their memory.
unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> Pointer;
    fn free(memory: Pointer);
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
