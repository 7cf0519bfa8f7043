//! A library's instance, as a co-simulation master has it: safe to use, with the library's own messages as errors.

#![allow(unsafe_code)]

use crate::host::library::{CallbackFunctions, Library, Logger, Pointer};
use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr;
use std::sync::{Mutex, PoisonError};

/// fmi2CoSimulation.
const CO_SIMULATION: c_int = 1;

/// An instance of the FMU that a library holds.
#[derive(Debug)]
pub struct Instance<'a> {
    library: &'a Library,
    component: Pointer,
    // The library may keep pointers to both: they stay where they are and go last.
    messages: Box<Messages>,
    _callbacks: Box<CallbackFunctions>,
}

/// What the library has logged.
#[derive(Debug, Default)]
struct Messages(Mutex<Vec<String>>);

impl Messages {
    fn take(&self) -> String {
        let mut messages = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let text = messages.join("; ");
        messages.clear();
        text
    }
}

/// What variables the FMI functions are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// fmi2GetReal, fmi2SetReal
    Real,
    /// fmi2GetInteger, fmi2SetInteger
    Integer,
    /// fmi2GetBoolean, fmi2SetBoolean
    Boolean,
}

impl<'a> Instance<'a> {
    /// `fmi2Instantiate`, for co-simulation and with logging on. `resources` is the URI of the unpacked resources.
    ///
    /// # Errors
    /// What the library has logged.
    pub fn instantiate(library: &'a Library, guid: &str, resources: Option<&str>) -> Result<Instance<'a>, String> {
        let no_nul = |text: &str| CString::new(text).map_err(|_| format!("{text:?} holds a NUL"));
        let guid = no_nul(guid)?;
        let resources = resources.map(no_nul).transpose()?;
        let messages = Box::<Messages>::default();
        let callbacks = Box::new(CallbackFunctions {
            logger: Some(logger()),
            allocate_memory: Some(calloc),
            free_memory: Some(free),
            step_finished: None,
            environment: ptr::from_ref(&*messages).cast_mut().cast(),
        });
        // SAFETY: the strings end with NUL and outlive the call; callbacks and messages live as long as
        // the instance.
        let component = unsafe {
            (library.instantiate)(
                c"plcfmu".as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                resources.as_ref().map_or(ptr::null(), |uri| uri.as_ptr()),
                &*callbacks,
                0,
                1,
            )
        };
        if component.is_null() {
            return Err(format!("fmi2Instantiate gives no instance ({})", messages.take()));
        }
        Ok(Instance { library, component, messages, _callbacks: callbacks })
    }

    /// `fmi2SetupExperiment` and `fmi2EnterInitializationMode`.
    ///
    /// # Errors
    /// What the library has logged.
    pub fn enter_initialization(&mut self, start: f64) -> Result<(), String> {
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.setup_experiment)(self.component, 0, 0.0, start, 0, 0.0) };
        self.check("fmi2SetupExperiment", status)?;
        // SAFETY: as above.
        let status = unsafe { (self.library.enter_initialization_mode)(self.component) };
        self.check("fmi2EnterInitializationMode", status)
    }

    /// `fmi2ExitInitializationMode`.
    ///
    /// # Errors
    /// What the library has logged.
    pub fn exit_initialization(&mut self) -> Result<(), String> {
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.exit_initialization_mode)(self.component) };
        self.check("fmi2ExitInitializationMode", status)
    }

    /// `fmi2DoStep`.
    ///
    /// # Errors
    /// What the library has logged.
    pub fn step(&mut self, time: f64, size: f64) -> Result<(), String> {
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.do_step)(self.component, time, size, 1) };
        self.check(&format!("fmi2DoStep at {time:?} s"), status)
    }

    /// `fmi2Terminate`.
    ///
    /// # Errors
    /// What the library has logged.
    pub fn terminate(&mut self) -> Result<(), String> {
        // SAFETY: the component is this instance's and lives.
        let status = unsafe { (self.library.terminate)(self.component) };
        self.check("fmi2Terminate", status)
    }

    /// A variable's value; true is 1.
    ///
    /// # Errors
    /// What the library has logged.
    pub fn get(&self, kind: Type, reference: u32) -> Result<f64, String> {
        let (mut real, mut integer) = (0.0, 0);
        // SAFETY: the component is this instance's and lives; one reference, room for one value.
        let status = unsafe {
            match kind {
                Type::Real => (self.library.get_real)(self.component, &reference, 1, &mut real),
                Type::Integer => (self.library.get_integer)(self.component, &reference, 1, &mut integer),
                Type::Boolean => (self.library.get_boolean)(self.component, &reference, 1, &mut integer),
            }
        };
        self.check("fmi2Get", status)?;
        Ok(if kind == Type::Real { real } else { f64::from(integer) })
    }

    /// Sets a variable; not 0 is true.
    ///
    /// # Errors
    /// What the library has logged; a value that an Integer cannot have.
    pub fn set(&mut self, kind: Type, reference: u32, value: f64) -> Result<(), String> {
        let integer = value as c_int;
        if kind != Type::Real && f64::from(integer) != value {
            return Err(format!("{value:?} is no integer"));
        }
        // SAFETY: the component is this instance's and lives; one reference, one value.
        let status = unsafe {
            match kind {
                Type::Real => (self.library.set_real)(self.component, &reference, 1, &value),
                Type::Integer => (self.library.set_integer)(self.component, &reference, 1, &integer),
                Type::Boolean => (self.library.set_boolean)(self.component, &reference, 1, &integer),
            }
        };
        self.check("fmi2Set", status)
    }

    /// fmi2OK and fmi2Warning go on.
    fn check(&self, function: &str, status: c_int) -> Result<(), String> {
        let messages = self.messages.take();
        if matches!(status, 0 | 1) { Ok(()) } else { Err(format!("{function} gives status {status} ({messages})")) }
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        // SAFETY: the component is this instance's, and nobody uses it afterwards.
        unsafe { (self.library.free_instance)(self.component) }
    }
}

/// A logger is variadic, which Rust cannot write. Our libraries give it `"%s"` and the text, of which this one reads the
/// text where variadic arguments travel as others do.
fn logger() -> Logger {
    type Fixed = unsafe extern "C" fn(Pointer, *const c_char, c_int, *const c_char, *const c_char, *const c_char);
    // SAFETY: both are pointers to C functions. A variadic call passes its first arguments as any other does; the last
    // is only read where that is so for the variadic ones too, see `log`.
    unsafe { std::mem::transmute::<Fixed, Logger>(log) }
}

unsafe extern "C" fn log(
    environment: Pointer,
    _instance: *const c_char,
    _status: c_int,
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
    // On Apple's ARM processors variadic arguments travel elsewhere.
    let readable = !cfg!(all(target_vendor = "apple", target_arch = "aarch64"));
    let message = if format == c"%s" && readable && !text.is_null() {
        // SAFETY: with "%s" it is a C string.
        unsafe { CStr::from_ptr(text) }
    } else {
        format
    };
    let message = message.to_string_lossy().replace("##", "#");
    messages.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
}

// For libraries of others, which let the host manage their memory.
unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> Pointer;
    fn free(memory: Pointer);
}
