//! Calls an FMI 2.0 instance.

use super::{DISCARD, Failed, Messages, Stopped, Type, Unset, WARNING, cut, done};
use crate::library::{CallbackFunctions, Library, Logger, Pointer};
use std::ffi::{CStr, c_char, c_int};
use std::ptr;

/// The value of fmi2CoSimulation.
const CO_SIMULATION: c_int = 1;

/// The value of fmi2Terminated, which asks an FMU whether it has ended the simulation.
const TERMINATED: c_int = 3;

/// An FMI 2.0 instance.
#[derive(Debug)]
pub(super) struct Instance {
    pub library: Library,
    component: Pointer,
    /// A buffer for Integers and Booleans, kept so that a step does not allocate.
    integers: Vec<c_int>,
    // The FMU may keep a pointer to the callbacks: they must not move and must outlive the library.
    _callbacks: Box<CallbackFunctions>,
}

impl Instance {
    /// Calls `fmi2Instantiate`; `None` if the FMU refuses. The messages must outlive the instance.
    pub(super) fn new(
        library: &Library,
        name: &CStr,
        guid: &CStr,
        resources: Option<&CStr>,
        messages: &Messages,
    ) -> Option<Instance> {
        let callbacks = Box::new(CallbackFunctions {
            logger: Some(logger()),
            allocate_memory: Some(calloc),
            free_memory: Some(free),
            step_finished: None,
            environment: ptr::from_ref(messages).cast_mut().cast(),
        });
        // SAFETY: the strings are NUL-terminated and outlive the call; callbacks and messages live as long as the
        // instance.
        let component = unsafe {
            (library.instantiate)(
                name.as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                resources.map_or(ptr::null(), CStr::as_ptr),
                &*callbacks,
                0,
                1,
            )
        };
        let library = library.clone();
        (!component.is_null()).then_some(Instance { library, component, integers: Vec::new(), _callbacks: callbacks })
    }

    pub(super) fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<(), Failed> {
        let (defined, stop) = (c_int::from(stop.is_some()), stop.unwrap_or(0.0));
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.setup_experiment)(self.component, 0, 0.0, start, defined, stop) };
        done("fmi2SetupExperiment", status)
    }

    pub(super) fn enter_initialization(&mut self) -> Result<(), Failed> {
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.enter_initialization_mode)(self.component) };
        done("fmi2EnterInitializationMode", status)
    }

    pub(super) fn exit_initialization(&mut self) -> Result<(), Failed> {
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.exit_initialization_mode)(self.component) };
        done("fmi2ExitInitializationMode", status)
    }

    #[inline]
    pub(super) fn step(&mut self, time: f64, size: f64) -> Result<(), Stopped> {
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.do_step)(self.component, time, size, 1) };
        if status == 0 || status == WARNING {
            return Ok(());
        }
        let has_terminated = status == DISCARD && self.has_terminated();
        Err(if has_terminated { Stopped::Terminated } else { Stopped::Failed(("fmi2DoStep", status)) })
    }

    /// Whether the FMU discarded a step because it ended the simulation.
    #[cold]
    fn has_terminated(&self) -> bool {
        let mut value = 0;
        // SAFETY: the component belongs to this instance and is alive; there is space for one value.
        let status = unsafe { (self.library.get_boolean_status)(self.component, TERMINATED, &mut value) };
        status == 0 && value != 0
    }

    pub(super) fn terminate(&mut self) -> Result<(), Failed> {
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.terminate)(self.component) };
        done("fmi2Terminate", status)
    }

    pub(super) fn reset(&mut self) -> Result<(), Failed> {
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.reset)(self.component) };
        done("fmi2Reset", status)
    }

    /// Frees the instance, which must not be called afterwards.
    pub(super) fn free(&mut self) {
        // SAFETY: the component belongs to this instance and is not used afterwards.
        unsafe { (self.library.free_instance)(self.component) }
    }

    #[inline]
    pub(super) fn get_all(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<(), Failed> {
        let (from, count) = (references.as_ptr(), references.len());
        if kind == Type::Real {
            // SAFETY: the component belongs to this instance and is alive; there are `count` references and space for
            // as many values.
            let status = unsafe { (self.library.get_real)(self.component, from, count, values.as_mut_ptr()) };
            return done("fmi2GetReal", status);
        }
        self.get_integers(kind, references, values)
    }

    /// Reads Integers or Booleans.
    fn get_integers(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<(), Failed> {
        let (from, count) = (references.as_ptr(), references.len());
        self.integers.clear();
        self.integers.resize(count, 0);
        let integers = self.integers.as_mut_ptr();
        // SAFETY: the component belongs to this instance and is alive; there are `count` references and space for as
        // many values.
        unsafe {
            match kind {
                Type::Boolean => {
                    done("fmi2GetBoolean", (self.library.get_boolean)(self.component, from, count, integers))
                }
                _ => done("fmi2GetInteger", (self.library.get_integer)(self.component, from, count, integers)),
            }
        }?;
        for (value, integer) in values.iter_mut().zip(&self.integers) {
            *value = f64::from(*integer);
        }
        Ok(())
    }

    #[inline]
    pub(super) fn set_all(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<(), Unset> {
        let (to, count) = (references.as_ptr(), references.len());
        if kind == Type::Real {
            // SAFETY: the component belongs to this instance and is alive; there are `count` references and as many
            // values.
            let status = unsafe { (self.library.set_real)(self.component, to, count, values.as_ptr()) };
            return done("fmi2SetReal", status).map_err(Unset::Failed);
        }
        self.set_integers(kind, references, values)
    }

    /// Sets Integers or Booleans.
    fn set_integers(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<(), Unset> {
        let (to, count) = (references.as_ptr(), references.len());
        self.integers.clear();
        for value in values {
            let integer = *value as c_int;
            if f64::from(integer) != *value {
                return Err(Unset::Value(*value));
            }
            self.integers.push(if kind == Type::Boolean { c_int::from(integer != 0) } else { integer });
        }
        // SAFETY: the component belongs to this instance and is alive; there are `count` references and as many values.
        let set = unsafe {
            match kind {
                Type::Boolean => done(
                    "fmi2SetBoolean",
                    (self.library.set_boolean)(self.component, to, count, self.integers.as_ptr()),
                ),
                _ => done(
                    "fmi2SetInteger",
                    (self.library.set_integer)(self.component, to, count, self.integers.as_ptr()),
                ),
            }
        };
        set.map_err(Unset::Failed)
    }
}

/// The logger. FMI requires a variadic function, which cannot be written in Rust. Most libraries pass `"%s"` and the
/// text; this function reads that text on platforms that pass variadic arguments like named ones.
fn logger() -> Logger {
    type Fixed = unsafe extern "C" fn(Pointer, *const c_char, c_int, *const c_char, *const c_char, *const c_char);
    // SAFETY: both are pointers to C functions. A variadic call passes its named arguments like any other; the last
    // argument is read only where that applies to variadic arguments as well, see `log`.
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
    // SAFETY: this is the environment passed by `instantiate`, which lives as long as the instance.
    let Some(messages) = (unsafe { environment.cast::<Messages>().as_ref() }) else { return };
    if format.is_null() {
        return;
    }
    // SAFETY: a C string according to FMI.
    let format = unsafe { CStr::from_ptr(format) };
    // Apple's ARM processors pass variadic arguments differently.
    let is_readable = !cfg!(all(target_vendor = "apple", target_arch = "aarch64"));
    let text = if format == c"%s" && is_readable && !text.is_null() {
        // SAFETY: with the format "%s" it is a C string.
        unsafe { CStr::from_ptr(text) }
    } else {
        format
    };
    let text = text.to_string_lossy().trim_end().replace("##", "#");
    messages.add(super::Message { is_error: status > WARNING, text: cut(text) });
}

// For FMUs that use the host's memory functions.
unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> Pointer;
    fn free(memory: Pointer);
}
