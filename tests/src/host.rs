//! An instance as a well-behaved host uses it. Tests that misbehave call the functions of the library themselves.

use crate::fmu::Fmu;
use blocks::Class;
use host::library::{CallbackFunctions, Logger, Pointer};
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr;

/// `fmi2Status`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the standard's names
pub enum Status {
    Ok,
    Warning,
    Discard,
    Error,
    Fatal,
    Pending,
}

impl From<c_int> for Status {
    fn from(status: c_int) -> Status {
        match status {
            0 => Status::Ok,
            1 => Status::Warning,
            2 => Status::Discard,
            3 => Status::Error,
            4 => Status::Fatal,
            5 => Status::Pending,
            other => panic!("{other} is no fmi2Status"),
        }
    }
}

/// What a logger was told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The name of the instance.
    pub instance: String,
    /// The status of the call.
    pub status: Status,
    /// The log category.
    pub category: String,
    /// The format, which should be `%s`.
    pub format: String,
    /// What stands for it.
    pub text: String,
}

/// The log of an instance. Its address is the environment of the callbacks.
#[derive(Debug, Default)]
pub struct Log(RefCell<Vec<Entry>>);

impl Log {
    /// What was logged since the last time.
    pub fn take(&self) -> Vec<Entry> {
        self.0.take()
    }
}

/// The C logger takes what `%s` stands for as a variadic argument. Where those go where other arguments go, a function
/// with one argument more is the same; on Apple's 64-bit ARM they go to the stack, behind the eight in registers.
#[cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]
unsafe extern "C" fn logger(
    environment: Pointer,
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    // SAFETY: passed on.
    unsafe { record(environment, instance, status, category, format, text) };
}

#[cfg(all(target_vendor = "apple", target_arch = "aarch64"))]
#[allow(clippy::too_many_arguments)]
unsafe extern "C" fn logger(
    environment: Pointer,
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    // What fills the last registers. An array would be passed by its address.
    _sixth: usize,
    _seventh: usize,
    _eighth: usize,
    text: *const c_char,
) {
    // SAFETY: passed on.
    unsafe { record(environment, instance, status, category, format, text) };
}

unsafe fn record(
    environment: Pointer,
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    let string = |text: *const c_char| {
        assert!(!text.is_null(), "the logger was given NULL");
        // SAFETY: the library gives strings that end with NUL.
        unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
    };
    // SAFETY: the environment is a `Log` that outlives the instance.
    let log = unsafe { &*environment.cast::<Log>() };
    log.0.borrow_mut().push(Entry {
        instance: string(instance),
        status: status.into(),
        category: string(category),
        format: string(format),
        text: string(text),
    });
}

/// Callbacks that write to `log`, which has to outlive the instance.
pub fn logging_callbacks(log: &Log) -> CallbackFunctions {
    // SAFETY: see `logger`: the library calls it with exactly this one argument more.
    let logger = unsafe { std::mem::transmute::<*const (), Logger>(logger as *const ()) };
    CallbackFunctions {
        logger: Some(logger),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        environment: ptr::from_ref(log).cast_mut().cast(),
    }
}

/// An instance, freed at its end.
#[derive(Debug)]
pub struct Instance {
    /// Its library.
    pub fmu: &'static Fmu,
    /// What the C functions take.
    pub component: Pointer,
    /// What it logs.
    pub log: Box<Log>,
}

// SAFETY: the FMUs keep nothing in thread-local places, and one thread at a time has an instance and its log.
unsafe impl Send for Instance {}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: a component of this library, freed once.
        unsafe { (self.fmu.library.free_instance)(self.component) };
    }
}

impl Instance {
    /// A new instance with logging on.
    ///
    /// # Panics
    /// The library refuses.
    pub fn new(fmu: &'static Fmu) -> Instance {
        let log = Box::<Log>::default();
        let callbacks = logging_callbacks(&log);
        let name = CString::new(fmu.package.as_str()).unwrap_or_default();
        // SAFETY: all pointers point to what the function takes.
        let component = unsafe {
            (fmu.library.instantiate)(name.as_ptr(), 1, fmu.guid.as_ptr(), fmu.location(), &raw const callbacks, 0, 1)
        };
        assert!(!component.is_null(), "{}: {:?}", fmu.package, log.take());
        Instance { fmu, component, log }
    }

    /// A new instance that is initialised with its start values and ready to step.
    ///
    /// # Panics
    /// The library refuses.
    pub fn running(fmu: &'static Fmu, start: f64, stop: Option<f64>) -> Instance {
        let instance = Instance::new(fmu);
        instance.initialize(start, stop);
        instance
    }

    /// Initialises it.
    ///
    /// # Panics
    /// The library refuses.
    pub fn initialize(&self, start: f64, stop: Option<f64>) {
        assert_eq!(self.setup_experiment(start, stop), Status::Ok, "{:?}", self.log.take());
        assert_eq!(self.enter_initialization_mode(), Status::Ok, "{:?}", self.log.take());
        assert_eq!(self.exit_initialization_mode(), Status::Ok, "{:?}", self.log.take());
        // Advice on the settings, with which no test begins.
        self.log.take();
    }

    /// fmi2SetupExperiment.
    pub fn setup_experiment(&self, start: f64, stop: Option<f64>) -> Status {
        let defined = c_int::from(stop.is_some());
        // SAFETY: a component of this library.
        unsafe { (self.fmu.library.setup_experiment)(self.component, 0, 0.0, start, defined, stop.unwrap_or(0.0)) }
            .into()
    }

    /// fmi2EnterInitializationMode.
    pub fn enter_initialization_mode(&self) -> Status {
        // SAFETY: a component of this library.
        unsafe { (self.fmu.library.enter_initialization_mode)(self.component) }.into()
    }

    /// fmi2ExitInitializationMode.
    pub fn exit_initialization_mode(&self) -> Status {
        // SAFETY: a component of this library.
        unsafe { (self.fmu.library.exit_initialization_mode)(self.component) }.into()
    }

    /// fmi2Terminate.
    pub fn terminate(&self) -> Status {
        // SAFETY: a component of this library.
        unsafe { (self.fmu.library.terminate)(self.component) }.into()
    }

    /// fmi2Reset.
    pub fn reset(&self) -> Status {
        // SAFETY: a component of this library.
        unsafe { (self.fmu.library.reset)(self.component) }.into()
    }

    /// fmi2DoStep.
    pub fn step(&self, tc: f64, h: f64) -> Status {
        // SAFETY: a component of this library.
        unsafe { (self.fmu.library.do_step)(self.component, tc, h, 1) }.into()
    }

    /// Sets a variable by the function of its type, rounding to what that takes.
    pub fn try_set(&self, reference: u32, value: f64) -> Status {
        let Fmu { library, variables, .. } = self.fmu;
        let vr = &raw const reference;
        // SAFETY: a component of this library; one reference, one value.
        unsafe {
            match variables[reference as usize].kind.class() {
                Class::Real => (library.set_real)(self.component, vr, 1, &raw const value),
                Class::Integer => {
                    let value = value as c_int;
                    (library.set_integer)(self.component, vr, 1, &raw const value)
                }
                Class::Boolean => {
                    let value = c_int::from(value != 0.0);
                    (library.set_boolean)(self.component, vr, 1, &raw const value)
                }
            }
        }
        .into()
    }

    /// Sets a variable.
    ///
    /// # Panics
    /// The library refuses.
    pub fn set(&self, name: &str, value: f64) {
        assert_eq!(self.try_set(self.fmu.reference(name), value), Status::Ok, "{name}: {:?}", self.log.take());
    }

    /// The value behind a reference, TRUE as 1.
    ///
    /// # Panics
    /// The library refuses.
    pub fn value(&self, reference: u32) -> f64 {
        let Fmu { library, variables, .. } = self.fmu;
        let vr = &raw const reference;
        let (mut real, mut integer) = (0.0, 0);
        // SAFETY: a component of this library; one reference, one value.
        let status: Status = unsafe {
            match variables[reference as usize].kind.class() {
                Class::Real => (library.get_real)(self.component, vr, 1, &raw mut real),
                Class::Integer => (library.get_integer)(self.component, vr, 1, &raw mut integer),
                Class::Boolean => (library.get_boolean)(self.component, vr, 1, &raw mut integer),
            }
        }
        .into();
        assert_eq!(status, Status::Ok, "{:?}", self.log.take());
        real + f64::from(integer)
    }

    /// The value of a variable, TRUE as 1.
    ///
    /// # Panics
    /// The library refuses.
    pub fn get(&self, name: &str) -> f64 {
        self.value(self.fmu.reference(name))
    }

    /// The bits of all variables' values.
    pub fn values(&self) -> Vec<u64> {
        (0..self.fmu.variables.len() as u32).map(|reference| self.value(reference).to_bits()).collect()
    }

    /// fmi2SetRealInputDerivatives of one input.
    pub fn set_derivative(&self, name: &str, order: c_int, derivative: f64) -> Status {
        let reference = self.fmu.reference(name);
        // SAFETY: a component of this library; one reference, one order, one value.
        unsafe {
            (self.fmu.library.set_real_input_derivatives)(
                self.component,
                &raw const reference,
                1,
                &raw const order,
                &raw const derivative,
            )
        }
        .into()
    }

    /// fmi2GetFMUstate into a state that is there already, or into a new one (NULL).
    ///
    /// # Panics
    /// The library refuses.
    pub fn save(&self, state: &mut Pointer) {
        // SAFETY: a component of this library, and a state of its own or NULL.
        let status: Status = unsafe { (self.fmu.library.get_fmu_state)(self.component, state) }.into();
        assert_eq!(status, Status::Ok, "{:?}", self.log.take());
    }

    /// fmi2SetFMUstate.
    pub fn restore(&self, state: Pointer) -> Status {
        // SAFETY: a component of this library; it looks before it follows the state's address.
        unsafe { (self.fmu.library.set_fmu_state)(self.component, state) }.into()
    }

    /// fmi2FreeFMUstate.
    ///
    /// # Panics
    /// The library refuses.
    pub fn forget(&self, state: &mut Pointer) {
        // SAFETY: a component of this library; it looks before it follows the state's address.
        let status: Status = unsafe { (self.fmu.library.free_fmu_state)(self.component, state) }.into();
        assert_eq!(status, Status::Ok, "{:?}", self.log.take());
    }

    /// A state as bytes.
    ///
    /// # Panics
    /// The library refuses.
    pub fn serialize(&self, state: Pointer) -> Vec<u8> {
        let mut size = 0;
        // SAFETY: a component of this library, and a buffer as long as it wants.
        unsafe {
            let status: Status =
                (self.fmu.library.serialized_fmu_state_size)(self.component, state, &raw mut size).into();
            assert_eq!(status, Status::Ok, "{:?}", self.log.take());
            let mut bytes = vec![0; size];
            let status: Status =
                (self.fmu.library.serialize_fmu_state)(self.component, state, bytes.as_mut_ptr(), size).into();
            assert_eq!(status, Status::Ok, "{:?}", self.log.take());
            bytes
        }
    }

    /// fmi2DeSerializeFMUstate.
    pub fn deserialize(&self, bytes: &[u8], state: &mut Pointer) -> Status {
        // SAFETY: a component of this library, and as many bytes as said.
        unsafe { (self.fmu.library.deserialize_fmu_state)(self.component, bytes.as_ptr(), bytes.len(), state) }.into()
    }

    /// The present state as bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut state = ptr::null_mut();
        self.save(&mut state);
        let bytes = self.serialize(state);
        self.forget(&mut state);
        bytes
    }
}

/// Calls a function that takes a component, by its name, with arguments that are right for any block.
///
/// # Panics
/// The function does not take a component and gives a status.
pub fn call_harmlessly(fmu: &Fmu, function: &str, component: Pointer) -> Status {
    let library = &fmu.library;
    let (reference, mut real, mut integer, mut size, mut state) = (fmu.cycle, 1.0, 1, 0, ptr::null_mut());
    let (vr, order) = (&raw const reference, &raw const integer);
    let mut text = ptr::null();
    let mut byte = 0u8;
    // SAFETY: the component is one of this library or NULL, and each array has the one element that is asked for.
    unsafe {
        match function {
            "fmi2SetDebugLogging" => (library.set_debug_logging)(component, 1, 0, ptr::null()),
            "fmi2SetupExperiment" => (library.setup_experiment)(component, 0, 0.0, 0.0, 0, 0.0),
            "fmi2EnterInitializationMode" => (library.enter_initialization_mode)(component),
            "fmi2ExitInitializationMode" => (library.exit_initialization_mode)(component),
            "fmi2Terminate" => (library.terminate)(component),
            "fmi2Reset" => (library.reset)(component),
            "fmi2GetReal" => (library.get_real)(component, vr, 1, &raw mut real),
            "fmi2GetInteger" => (library.get_integer)(component, vr, 1, &raw mut integer),
            "fmi2GetBoolean" => (library.get_boolean)(component, vr, 1, &raw mut integer),
            "fmi2GetString" => (library.get_string)(component, vr, 1, &raw mut text),
            "fmi2SetReal" => (library.set_real)(component, vr, 1, &raw const real),
            "fmi2SetInteger" => (library.set_integer)(component, vr, 1, &raw const integer),
            "fmi2SetBoolean" => (library.set_boolean)(component, vr, 1, &raw const integer),
            "fmi2SetString" => (library.set_string)(component, vr, 1, &raw const text),
            "fmi2GetFMUstate" => (library.get_fmu_state)(component, &raw mut state),
            "fmi2SetFMUstate" => (library.set_fmu_state)(component, state),
            "fmi2FreeFMUstate" => (library.free_fmu_state)(component, &raw mut state),
            "fmi2SerializedFMUstateSize" => (library.serialized_fmu_state_size)(component, state, &raw mut size),
            "fmi2SerializeFMUstate" => (library.serialize_fmu_state)(component, state, &raw mut byte, 1),
            "fmi2DeSerializeFMUstate" => (library.deserialize_fmu_state)(component, &raw const byte, 1, &raw mut state),
            "fmi2GetDirectionalDerivative" => {
                (library.get_directional_derivative)(component, vr, 1, vr, 1, &raw const real, &raw mut real)
            }
            "fmi2SetRealInputDerivatives" => {
                (library.set_real_input_derivatives)(component, vr, 1, order, &raw const real)
            }
            "fmi2GetRealOutputDerivatives" => {
                (library.get_real_output_derivatives)(component, vr, 1, order, &raw mut real)
            }
            "fmi2DoStep" => (library.do_step)(component, 0.0, 1.0, 1),
            "fmi2CancelStep" => (library.cancel_step)(component),
            "fmi2GetStatus" => (library.get_status)(component, 0, &raw mut integer),
            "fmi2GetRealStatus" => (library.get_real_status)(component, 2, &raw mut real),
            "fmi2GetIntegerStatus" => (library.get_integer_status)(component, 0, &raw mut integer),
            "fmi2GetBooleanStatus" => (library.get_boolean_status)(component, 3, &raw mut integer),
            "fmi2GetStringStatus" => (library.get_string_status)(component, 1, &raw mut text),
            other => panic!("{other} takes no component or gives no status"),
        }
    }
    .into()
}
