//! The 34 FMI 2.0 co-simulation functions, as a table that specifies each one once: its states, its arguments,
//! and the call of the [`Component`]. The unsafe code is here and in `pointers`: pointers become slices and references,
//! and the host's logger is called. The [`Door`] checks the state, catches panics and logs why a call is refused.
//!
//! The standard requires the following of the host: a `fmi2Component` comes from `fmi2Instantiate`, has not been freed
//! and is used by one thread at a time; an array has the length passed with it. NULL is detected everywhere.

#![allow(unsafe_code, non_snake_case, non_upper_case_globals)]
// The contract above is the safety section of every function here.
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use super::messages;
use super::value::AnyReal;
pub use super::value::Boolean;
use super::{Fmi2, describe};
pub use crate::component::StateAddress;
use crate::component::{Component, Library};
use crate::cyclic::Cyclic;
use crate::door::{Door, Host};
use crate::host_type::Version as _;
use crate::log::{self, Category};
pub use crate::pointers::Status;
use crate::pointers::{array, array_mut, enter, get, get_strings, set, set_strings, status, target, text};
use crate::preset::{Argument, Identity};
use crate::refusal::{Answer, Refusal};
use crate::state::{Function, State};
use crate::table::{Code, Guid};
use blocks::{Block, Class};
use std::ffi::c_void;
use std::ffi::{CStr, CString};
pub use std::ffi::{c_char, c_int};
use std::ptr;

/// `fmi2Type`: co-simulation.
const CO_SIMULATION: c_int = 1;

/// The `fmi2StatusKind`s that the FMU can answer.
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// `fmi2Component`.
pub type Pointer = *mut c_void;

type Logger = unsafe extern "C" fn(
    environment: *mut c_void,
    instance_name: *const c_char,
    status: Status,
    category: *const c_char,
    message: *const c_char,
    ...
);

/// `fmi2CallbackFunctions`. Only the logger is used: the library manages its own memory, and every step ends within its
/// call.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    logger: Option<Logger>,
    allocate_memory: *const c_void,
    free_memory: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

struct Caller {
    logger: Logger,
    environment: *mut c_void,
    instance_name: CString,
}

impl Host for Caller {
    fn tell(&self, function: &Function, answer: Result<(), Answer>, category: &Category, message: &str) {
        let text = log::text(function, message);
        // SAFETY: the host passed the logger and its environment for this purpose, and all strings end with NUL.
        unsafe {
            (self.logger)(
                self.environment,
                self.instance_name.as_ptr(),
                status(answer),
                category.name.as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}

/// Stores the result of a query in the host's variable.
unsafe fn answer<T>(pointer: *mut T, value: Result<T, Refusal>) -> Result<(), Refusal> {
    // SAFETY: the host's contract.
    let target = unsafe { target(pointer, "value") }?;
    *target = value?;
    Ok(())
}

/// Refuses a status kind that a function cannot answer, such as fmi2DoStepStatus or fmi2PendingStatus, which apply only
/// while a step is pending.
fn no_status<T>(kind: c_int) -> Result<T, Refusal> {
    Err(Refusal::new(Answer::Discard, messages::no_status(kind)))
}

/// Reads variables of any type as Reals.
#[inline(never)]
fn get_any<B: Cyclic>(c: &mut Component<B>, references: &[u32], values: &mut [f64]) -> Result<(), Refusal> {
    // SAFETY: an `AnyReal` is an `f64`.
    let values = unsafe { array_mut(values.as_mut_ptr().cast::<AnyReal>(), values.len(), "value") }?;
    c.instance.get(references, values)?;
    tell_conversion(c, references);
    Ok(())
}

/// Writes variables of any type as Reals.
#[inline(never)]
fn set_any<B: Cyclic>(c: &mut Component<B>, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
    // SAFETY: an `AnyReal` is an `f64`.
    let values = unsafe { array(values.as_ptr().cast::<AnyReal>(), values.len(), "value") }?;
    c.instance.set(references, values)?;
    tell_conversion(c, references);
    Ok(())
}

/// Advises the host, once, that a variable of a different type was read or written as a Real.
fn tell_conversion<B: Cyclic>(c: &mut Component<B>, references: &[u32]) {
    let other = references.iter().filter_map(|reference| c.instance.block().table().rows.get(*reference as usize));
    let Some(row) = other.into_iter().find(|row| row.kind.class() != Class::Real) else { return };
    let (name, kind) = (row.name.clone(), Fmi2::name_of(row));
    c.advise_on_conversion(|| messages::counts_as_real(&name, kind));
}

// FMI 2.0, section 4.2.4, in the order given there. The table is more lenient than the standard because real hosts need
// it: in state instantiated, Get also works and returns the start values, and inputs may be set.
functions! {
    ($) export_fmi2: v2, in "stepComplete", with Boolean, CallbackFunctions, Pointer, StateAddress, Status, c_char, c_int;
    fmi2GetTypesPlatform() -> *const c_char { c"default".as_ptr() };
    fmi2GetVersion() -> *const c_char { c"2.0".as_ptr() };
    fmi2SetDebugLogging[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, logging_on: c_int, count: usize, categories: *const *const c_char,
    ) -> Status => |c| {
        let categories = array(categories, count, "categories")?;
        c.set_debug_logging(logging_on != 0, categories.iter().map(|name| text(*name)))
    };

    fmi2Instantiate(
        instance_name: *const c_char, fmu_type: c_int, guid: *const c_char, resources: *const c_char,
        callbacks: *const CallbackFunctions, _visible: c_int, logging_on: c_int,
    ) -> Pointer {
        // SAFETY: the host's contract.
        unsafe { instantiate::<L>(instance_name, fmu_type, guid, resources, callbacks, logging_on) }
    };
    fmi2FreeInstance(component: Pointer) {
        if !component.is_null() {
            // SAFETY: created by `fmi2Instantiate`, and not used again, by the host's contract.
            unsafe { Box::from_raw(component.cast::<Door<L::Block, Caller>>()) }.close();
        }
    };

    fmi2SetupExperiment[Instantiated](
        component: Pointer, _tolerance_defined: c_int, _tolerance: f64, start_time: f64, stop_time_defined: c_int, stop_time: f64,
    ) -> Status => |c| c.instance.setup_experiment(start_time, (stop_time_defined != 0).then_some(stop_time));
    fmi2EnterInitializationMode[Instantiated](component: Pointer) -> Status
        => |c| c.instance.enter_initialization_mode(&Function::fmi2SetupExperiment);
    fmi2ExitInitializationMode[InitializationMode](component: Pointer) -> Status => |c| c.exit_initialization_mode();
    fmi2Terminate[StepComplete](component: Pointer) -> Status => |c| {
        c.instance.terminate();
        Ok(())
    };
    fmi2Reset[Instantiated InitializationMode StepComplete Terminated](component: Pointer) -> Status => |c| {
        c.reset();
        Ok(())
    };

    fmi2GetReal[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, vr: *const u32, count: usize, value: *mut f64,
    ) -> Status => |c| {
        let (vr, reals) = (array(vr, count, "vr")?, array_mut(value, count, "value")?);
        if c.instance.get_ordinary::<Fmi2, _>(vr, reals) { Ok(()) } else { get_any(c, vr, reals) }
    };
    fmi2GetInteger[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, vr: *const u32, count: usize, value: *mut c_int,
    ) -> Status => |c| get::<Fmi2, _, _>(c, vr, count, value);
    fmi2GetBoolean[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, vr: *const u32, count: usize, value: *mut Boolean,
    ) -> Status => |c| get::<Fmi2, _, _>(c, vr, count, value);
    fmi2GetString[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, vr: *const u32, count: usize, value: *mut *const c_char,
    ) -> Status => |c| get_strings::<Fmi2, _>(c, vr, count, value);
    fmi2SetReal[Instantiated InitializationMode StepComplete](
        component: Pointer, vr: *const u32, count: usize, value: *const f64,
    ) -> Status => |c| {
        let (vr, reals) = (array(vr, count, "vr")?, array(value, count, "value")?);
        if c.instance.set_ordinary::<Fmi2, _>(vr, reals) { Ok(()) } else { set_any(c, vr, reals) }
    };
    fmi2SetInteger[Instantiated InitializationMode StepComplete](
        component: Pointer, vr: *const u32, count: usize, value: *const c_int,
    ) -> Status => |c| set::<Fmi2, _, _>(c, vr, count, value);
    fmi2SetBoolean[Instantiated InitializationMode StepComplete](
        component: Pointer, vr: *const u32, count: usize, value: *const Boolean,
    ) -> Status => |c| set::<Fmi2, _, _>(c, vr, count, value);
    fmi2SetString[Instantiated InitializationMode StepComplete](
        component: Pointer, vr: *const u32, count: usize, value: *const *const c_char,
    ) -> Status => |c| set_strings::<Fmi2, _>(c, vr, count, value);

    fmi2GetFMUstate[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, state: *mut StateAddress,
    ) -> Status => |c| c.get_state(target(state, "FMUstate")?);
    fmi2SetFMUstate[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, state: StateAddress,
    ) -> Status => |c| c.set_state(state);
    fmi2FreeFMUstate[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, state: *mut StateAddress,
    ) -> Status => |c| c.free_state(target(state, "FMUstate")?);
    fmi2SerializedFMUstateSize[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, state: StateAddress, size: *mut usize,
    ) -> Status => |c| {
        *target(size, "size")? = c.serialized_size(state)?;
        Ok(())
    };
    fmi2SerializeFMUstate[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, state: StateAddress, bytes: *mut u8, size: usize,
    ) -> Status => |c| c.serialize(state, array_mut(bytes, size, "serializedState")?);
    fmi2DeSerializeFMUstate[Instantiated InitializationMode StepComplete Terminated](
        component: Pointer, bytes: *const u8, size: usize, state: *mut StateAddress,
    ) -> Status => |c| c.deserialize(array(bytes, size, "serializedState")?, target(state, "FMUstate")?);

    fmi2GetDirectionalDerivative[InitializationMode StepComplete](
        component: Pointer, _unknowns: *const u32, _unknown_count: usize, _knowns: *const u32, _known_count: usize,
        _known_changes: *const f64, _unknown_changes: *mut f64,
    ) -> Status => |_c| Err(messages::not_provided("providesDirectionalDerivative").into());
    fmi2SetRealInputDerivatives[Instantiated InitializationMode StepComplete](
        component: Pointer, vr: *const u32, count: usize, order: *const c_int, value: *const f64,
    ) -> Status => |c| c.instance.set_input_derivatives::<Fmi2>(
        array(vr, count, "vr")?,
        array(order, count, "order")?,
        array(value, count, "value")?,
    );
    fmi2GetRealOutputDerivatives[StepComplete Terminated](
        component: Pointer, _vr: *const u32, count: usize, _order: *const c_int, _value: *mut f64,
    ) -> Status => |_c| match count {
        0 => Ok(()),
        _ => Err(messages::no_output_derivatives().into()),
    };

    fmi2DoStep[StepComplete](component: Pointer, tc: f64, h: f64, _no_set_fmu_state_prior: c_int) -> Status
        => |c| c.do_step(tc, h).map(drop);
    fmi2CancelStep[Instantiated InitializationMode StepComplete Terminated](component: Pointer) -> Status
        => |_c| Err(messages::nothing_to_cancel().into());
    fmi2GetStatus[StepComplete Terminated](component: Pointer, kind: c_int, value: *mut Status) -> Status
        => |_c| answer(value, no_status(kind));
    fmi2GetRealStatus[StepComplete Terminated](component: Pointer, kind: c_int, value: *mut f64) -> Status
        => |c| answer(value, match kind {
            LAST_SUCCESSFUL_TIME => Ok(c.instance.last_successful_time()),
            _ => no_status(kind),
        });
    fmi2GetIntegerStatus[StepComplete Terminated](component: Pointer, kind: c_int, value: *mut c_int) -> Status
        => |_c| answer(value, no_status(kind));
    // A block never ends the simulation.
    fmi2GetBooleanStatus[StepComplete Terminated](component: Pointer, kind: c_int, value: *mut Boolean) -> Status
        => |_c| answer(value, if kind == TERMINATED { Ok(Boolean(0)) } else { no_status(kind) });
    fmi2GetStringStatus[StepComplete Terminated](component: Pointer, kind: c_int, value: *mut *const c_char) -> Status
        => |_c| answer(value, no_status(kind));
}

unsafe fn instantiate<L: Library>(
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resources: *const c_char,
    callbacks: *const CallbackFunctions,
    logging_on: c_int,
) -> Pointer {
    // SAFETY: the host's contract.
    let (callbacks, name) = unsafe { (callbacks.as_ref().copied(), text(instance_name)) };
    // SAFETY: the host's contract.
    let (guid, resources) = unsafe { (text(guid), text(resources)) };
    let Some((logger, environment)) = callbacks.and_then(|given| Some((given.logger?, given.environment))) else {
        return ptr::null_mut();
    };
    let host = Caller { logger, environment, instance_name: name.unwrap_or(c"").to_owned() };
    let door = Door::new(host, &Function::fmi2Instantiate, || {
        if name.is_none_or(CStr::is_empty) {
            return Err(messages::no_name().into());
        }
        if fmu_type != CO_SIMULATION {
            return Err(messages::no_simulation_of_this_type(fmu_type).into());
        }
        let identity = Identity { name: "fmuGUID", value: guid, forms: Identity::GUID };
        let origin = L::open(identity, Argument { name: "fmuResourceLocation", value: resources })?;
        Ok(Component::new(origin, logging_on != 0))
    });
    door.map_or(ptr::null_mut(), |door| Box::into_raw(Box::new(door)).cast())
}

// For the packer

/// Adds the function to an FMU's library through which the packer reads the library's description.
#[macro_export]
macro_rules! export_interface {
    ($Library:ty) => {
        #[allow(unsafe_code, missing_docs, clippy::missing_safety_doc)]
        mod interface {
            use super::*;

            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn plcfmu_interface(buffer: *mut u8, size: usize) -> usize {
                // SAFETY: passed on to the packer.
                unsafe { $crate::v2::ffi::interface::<$Library>(buffer, size) }
            }
        }
    };
}

/// Copies the library's description of itself (see [`describe`]) to `buffer`, at most `size` bytes, and returns
/// its full length in bytes.
pub unsafe fn interface<B: Block>(buffer: *mut u8, size: usize) -> usize {
    // Other programs search the library file for these strings; `black_box` keeps the compiler from removing them.
    std::hint::black_box(Code::<B>::TEXT);
    std::hint::black_box(&Guid::<B>::TOKENS);
    let json = describe(B::TABLE, Guid::<B>::TEXT);
    if !buffer.is_null() {
        let length = size.min(json.len());
        // SAFETY: the caller's buffer has `size` bytes, which is at least `length`.
        unsafe { ptr::copy_nonoverlapping(json.as_ptr(), buffer, length) };
    }
    json.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pointers::{ERROR, FATAL, OK};
    use crate::test_block::Fragile;

    #[test]
    fn the_types_platform_is_default_and_the_version_2_0() {
        // SAFETY: they have no arguments.
        let texts = unsafe { [(fmi2GetTypesPlatform::<Fragile>(), c"default"), (fmi2GetVersion::<Fragile>(), c"2.0")] };
        for (pointer, expected) in texts {
            assert!(!pointer.is_null());
            // SAFETY: not NULL, and the two functions give constants of this file.
            assert_eq!(unsafe { CStr::from_ptr(pointer) }, expected);
        }
    }

    /// The reference of the input.
    static U: u32 = 0;

    /// A running instance with logging off.
    fn running() -> Pointer {
        unsafe extern "C" fn silent() {}
        // SAFETY: a function that leaves its arguments alone can be called with any.
        let logger = unsafe { std::mem::transmute::<*const (), Logger>(silent as *const ()) };
        let nothing = ptr::null();
        let callbacks = CallbackFunctions {
            logger: Some(logger),
            allocate_memory: nothing,
            free_memory: nothing,
            step_finished: nothing,
            environment: ptr::null_mut(),
        };
        let guid = CString::new(Guid::<Fragile>::TEXT).unwrap();
        // SAFETY: all pointers point to what the functions take.
        unsafe {
            let component =
                instantiate::<Fragile>(c"x".as_ptr(), 1, guid.as_ptr(), ptr::null(), &raw const callbacks, 0);
            assert_eq!(fmi2SetupExperiment::<Fragile>(component, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode::<Fragile>(component), OK);
            assert_eq!(fmi2ExitInitializationMode::<Fragile>(component), OK);
            component
        }
    }

    #[test]
    fn a_panic_in_one_of_many_ordinary_steps_is_fatal_and_locks_the_instance() {
        let component = running();
        // SAFETY: a living component, freed once.
        unsafe {
            let statuses: Vec<Status> =
                (0..11).map(|k| fmi2DoStep::<Fragile>(component, f64::from(k), 1.0, 1)).collect();
            assert_eq!(statuses, [OK, OK, OK, OK, OK, OK, OK, OK, OK, FATAL, FATAL]);
            let mut value = 5.0;
            let status = fmi2GetReal::<Fragile>(component, &raw const U, 1, &raw mut value);
            assert_eq!((status, value), (FATAL, 5.0));
            fmi2FreeInstance::<Fragile>(component);
        }
    }

    #[test]
    fn one_wrong_value_of_two_changes_neither() {
        let component = running();
        // SAFETY: a living component, freed once; arrays as long as counted.
        unsafe {
            let set = |references: [u32; 2], values: [f64; 2]| {
                fmi2SetReal::<Fragile>(component, references.as_ptr(), 2, values.as_ptr())
            };
            let u = || {
                let mut value = f64::NAN;
                assert_eq!(fmi2GetReal::<Fragile>(component, &raw const U, 1, &raw mut value), OK);
                value
            };
            assert_eq!((set([U, U], [1.0, 2.0]), u()), (OK, 2.0));
            // NaN, beyond the largest REAL, an output, a fixed parameter, no variable.
            assert_eq!((set([U, U], [3.0, f64::NAN]), u()), (ERROR, 2.0));
            assert_eq!((set([U, U], [3.5e38, 3.0]), u()), (ERROR, 2.0));
            for other in [1, 2, 3, u32::MAX] {
                assert_eq!((set([U, other], [3.0, 3.0]), u()), (ERROR, 2.0), "{other}");
                assert_eq!((set([other, U], [3.0, 3.0]), u()), (ERROR, 2.0), "{other}");
            }
            fmi2FreeInstance::<Fragile>(component);
        }
    }
}
