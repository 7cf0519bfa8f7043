//! The 34 functions of FMI 2.0 for co-simulation. Everything unsafe stands here, and no decision: pointers become slices
//! and references, one door (`enter`) catches panics, logs refusals and makes the status; [`Instance`] decides.
//!
//! What a host owes, as the standard says: a `fmi2Component` is one that `fmi2Instantiate` gave and that is not freed
//! yet, used by one thread at a time; an array has the length that stands beside it. NULL is recognised everywhere.

#![allow(unsafe_code)]
// The contract above is the safety section of every function here.
#![allow(clippy::missing_safety_doc)]

use crate::instance::{Answer, Function, Instance, Refusal, no_string};
use crate::interface::{self, Guid};
use crate::value::{Boolean, FmiType};
use blocks::Block;
use std::any::Any;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::{ptr, slice};

/// `fmi2Status`, an enum of C.
pub type Status = c_int;
const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;
const FATAL: Status = 4;

/// `fmi2Type`: co-simulation.
const CO_SIMULATION: c_int = 1;

/// `fmi2StatusKind`s that have an answer.
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

type Logger = unsafe extern "C" fn(
    environment: *mut c_void,
    instance_name: *const c_char,
    status: Status,
    category: *const c_char,
    message: *const c_char,
    ...
);

/// `fmi2CallbackFunctions`. Memory is our own, and no step ends later than its call: only the logger is used.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    logger: Option<Logger>,
    allocate_memory: *const c_void,
    free_memory: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

/// A log category, as modelDescription.xml declares it.
#[derive(Clone, Copy)]
struct Category {
    name: &'static CStr,
    bit: u8,
}

const STATUS_ERROR: Category = Category { name: c"logStatusError", bit: 1 };
const STATUS_DISCARD: Category = Category { name: c"logStatusDiscard", bit: 2 };
const STATUS_FATAL: Category = Category { name: c"logStatusFatal", bit: 4 };
const CATEGORIES: [Category; 3] = [STATUS_ERROR, STATUS_DISCARD, STATUS_FATAL];
const ALL_CATEGORIES: u8 = 7;

/// Where messages go.
struct Log {
    logger: Logger,
    environment: *mut c_void,
    instance_name: CString,
    enabled: u8,
}

impl Log {
    /// Logs a refusal and gives its status.
    #[cold]
    fn refusal(&self, function: &Function, refusal: &Refusal) -> Status {
        let (status, category) = match refusal.answer() {
            Answer::Error => (ERROR, STATUS_ERROR),
            Answer::Discard => (DISCARD, STATUS_DISCARD),
            Answer::Fatal => (FATAL, STATUS_FATAL),
        };
        if self.enabled & category.bit != 0 {
            // A NUL would end the text early; `#` begins a reference to a variable.
            let text = format!("{}: {}", function.name, refusal.reason()).replace('\0', "").replace('#', "##");
            let text = CString::new(text).unwrap_or_default();
            // SAFETY: the host gave the logger and its environment for this, and all strings end with NUL.
            unsafe {
                (self.logger)(
                    self.environment,
                    self.instance_name.as_ptr(),
                    status,
                    category.name.as_ptr(),
                    c"%s".as_ptr(),
                    text.as_ptr(),
                );
            }
        }
        status
    }
}

/// What a `fmi2Component` points to.
pub struct Component<B> {
    log: Log,
    instance: Instance<B>,
    /// What fmi2GetFMUstate handed out, each known to the host by its address. They end with the component.
    saved: Vec<Box<Instance<B>>>,
}

/// `fmi2Component`.
pub type Pointer = *mut c_void;

/// The one door: every function on a component goes through here.
#[inline(always)]
unsafe fn enter<B: Block>(
    component: Pointer,
    function: &'static Function,
    body: impl FnOnce(&mut Component<B>) -> Result<(), Refusal>,
) -> Status {
    // SAFETY: not NULL then, and a component of ours by the host's contract.
    let Some(component) = (unsafe { component.cast::<Component<B>>().as_mut() }) else {
        return ERROR;
    };
    match catch_unwind(AssertUnwindSafe(|| {
        component.instance.may(function)?;
        body(component)
    })) {
        Ok(Ok(())) => OK,
        Ok(Err(refusal)) => component.log.refusal(function, &refusal),
        Err(panic) => {
            component.instance.lock();
            component.log.refusal(function, &panic_refusal(panic))
        }
    }
}

#[cold]
fn panic_refusal(panic: Box<dyn Any + Send>) -> Refusal {
    let text = panic.downcast_ref::<&str>().copied().or(panic.downcast_ref::<String>().map(String::as_str));
    let reason = format!("panic in the block: {}; the instance is locked", text.unwrap_or("no message"));
    discard(panic);
    Refusal::new(Answer::Fatal, reason)
}

/// Drops what a block made; a panic in doing so ends here.
fn discard<T>(value: T) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| drop(value)))
        && let Err(another) = catch_unwind(AssertUnwindSafe(|| drop(panic)))
    {
        // Payloads that go on panicking when they are dropped are given up.
        std::mem::forget(another);
    }
}

/// The array of `length` elements at `pointer`, which a NULL with length 0 also is.
#[inline(always)]
unsafe fn array<'a, T>(pointer: *const T, length: usize, name: &'static str) -> Result<&'a [T], Refusal> {
    if pointer.is_null() && length == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() || length > isize::MAX as usize / size_of::<T>() {
        return Err(no_array(pointer.is_null(), length, name));
    }
    // SAFETY: not NULL, no longer than memory can be, and as long as the host says.
    Ok(unsafe { slice::from_raw_parts(pointer, length) })
}

/// The same, to write to.
#[inline(always)]
unsafe fn array_mut<'a, T>(pointer: *mut T, length: usize, name: &'static str) -> Result<&'a mut [T], Refusal> {
    if pointer.is_null() && length == 0 {
        return Ok(&mut []);
    }
    if pointer.is_null() || length > isize::MAX as usize / size_of::<T>() {
        return Err(no_array(pointer.is_null(), length, name));
    }
    // SAFETY: as in `array`, and nobody else's during the call.
    Ok(unsafe { slice::from_raw_parts_mut(pointer, length) })
}

#[cold]
fn no_array(is_null: bool, length: usize, name: &str) -> Refusal {
    match is_null {
        true => format!("{name} is NULL, though it should have {length} elements"),
        false => format!("{name} cannot have {length} elements"),
    }
    .into()
}

/// Where a result goes.
unsafe fn target<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Refusal> {
    // SAFETY: not NULL then, and the host's variable.
    unsafe { pointer.as_mut() }.ok_or_else(|| format!("{name} is NULL").into())
}

unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not NULL, and a C string by the host's contract.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

// Inquire version numbers, and logging

pub extern "C" fn get_types_platform() -> *const c_char {
    c"default".as_ptr()
}

pub extern "C" fn get_version() -> *const c_char {
    c"2.0".as_ptr()
}

pub unsafe fn set_debug_logging<B: Block>(
    component: Pointer,
    logging_on: c_int,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::SET_DEBUG_LOGGING, |component| {
            let mut bits = if count == 0 { ALL_CATEGORIES } else { 0 };
            for name in array(categories, count, "categories")? {
                let name = text(*name).ok_or("a category is NULL")?;
                let category = CATEGORIES.iter().find(|category| category.name == name).ok_or_else(|| {
                    let known: Vec<_> = CATEGORIES.iter().map(|category| category.name.to_string_lossy()).collect();
                    format!("category {:?} is unknown: there are {}", name.to_string_lossy(), known.join(", "))
                })?;
                bits |= category.bit;
            }
            // What was on before does not count; off is off, whatever is named.
            component.log.enabled = if logging_on != 0 { bits } else { 0 };
            Ok(())
        })
    }
}

// Create and destroy

#[allow(clippy::too_many_arguments)] // the standard's
pub unsafe fn instantiate<B: Block>(
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    callbacks: *const CallbackFunctions,
    logging_on: c_int,
) -> Pointer {
    // SAFETY: the host's contract.
    let (callbacks, name, guid) = unsafe { (callbacks.as_ref().copied(), text(instance_name), text(guid)) };
    let Some((logger, environment)) = callbacks.and_then(|given| Some((given.logger?, given.environment))) else {
        return ptr::null_mut();
    };
    // Until the instance exists, the logger is the only way to tell what is wrong: loggingOn counts from then on.
    let mut log = Log { logger, environment, instance_name: name.unwrap_or(c"").to_owned(), enabled: ALL_CATEGORIES };
    let refuse = |log: &Log, refusal: Refusal| {
        log.refusal(&Function::INSTANTIATE, &refusal);
        ptr::null_mut()
    };
    if name.is_none_or(CStr::is_empty) {
        return refuse(&log, "instanceName is NULL or empty: give the instance a name".into());
    }
    if fmu_type != CO_SIMULATION {
        return refuse(&log, format!("fmuType = {fmu_type}: this FMU is for co-simulation (1) only").into());
    }
    if guid.is_none_or(|guid| guid.to_bytes() != Guid::<B>::TEXT.as_bytes()) {
        let given = guid.map_or("NULL".into(), |guid| format!("{:?}", guid.to_string_lossy()));
        let reason = format!(
            "fmuGUID = {given}: this library is {}; take the modelDescription.xml that came with it",
            Guid::<B>::TEXT
        );
        return refuse(&log, reason.into());
    }
    match catch_unwind(Instance::<B>::default) {
        Ok(instance) => {
            log.enabled = if logging_on != 0 { ALL_CATEGORIES } else { 0 };
            Box::into_raw(Box::new(Component { log, instance, saved: Vec::new() })).cast()
        }
        Err(panic) => refuse(&log, panic_refusal(panic)),
    }
}

pub unsafe fn free_instance<B: Block>(component: Pointer) {
    if !component.is_null() {
        // SAFETY: made by `instantiate`, and not used again by the host's contract.
        let component = *unsafe { Box::from_raw(component.cast::<Component<B>>()) };
        // One by one: a panic while another unwinds would end the process.
        discard(component.instance);
        component.saved.into_iter().for_each(discard);
    }
}

// Enter and exit modes

pub unsafe fn setup_experiment<B: Block>(
    component: Pointer,
    start_time: f64,
    stop_time_defined: c_int,
    stop_time: f64,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::SETUP_EXPERIMENT, |component| {
            component.instance.setup_experiment(start_time, (stop_time_defined != 0).then_some(stop_time))
        })
    }
}

pub unsafe fn enter_initialization_mode<B: Block>(component: Pointer) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::ENTER_INITIALIZATION_MODE, |component| {
            component.instance.enter_initialization_mode()
        })
    }
}

pub unsafe fn exit_initialization_mode<B: Block>(component: Pointer) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::EXIT_INITIALIZATION_MODE, |component| {
            component.instance.exit_initialization_mode()
        })
    }
}

pub unsafe fn terminate<B: Block>(component: Pointer) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::TERMINATE, |component| {
            component.instance.terminate();
            Ok(())
        })
    }
}

pub unsafe fn reset<B: Block>(component: Pointer) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::RESET, |component| {
            component.instance = Instance::default();
            Ok(())
        })
    }
}

// Variable values

pub unsafe fn get<B: Block, T: FmiType>(
    component: Pointer,
    function: &'static Function,
    references: *const u32,
    count: usize,
    values: *mut T,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, function, |component| {
            let references = array(references, count, "vr")?;
            component.instance.get(references, array_mut(values, count, "value")?)
        })
    }
}

pub unsafe fn set<B: Block, T: FmiType>(
    component: Pointer,
    function: &'static Function,
    references: *const u32,
    count: usize,
    values: *const T,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, function, |component| {
            let references = array(references, count, "vr")?;
            component.instance.set(references, array(values, count, "value")?)
        })
    }
}

/// Both functions for String variables, of which there are none.
pub unsafe fn strings<B: Block>(
    component: Pointer,
    function: &'static Function,
    references: *const u32,
    count: usize,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, function, |_| {
            array(references, count, "vr")?.first().map_or(Ok(()), |reference| Err(no_string::<B>(*reference)))
        })
    }
}

// FMU states

/// The place of a state among those handed out.
fn find<B>(saved: &[Box<Instance<B>>], state: *mut c_void) -> Result<usize, Refusal> {
    saved
        .iter()
        .position(|known| ptr::from_ref(&**known).cast() == state.cast_const())
        .ok_or_else(|| "FMUstate is none that this instance gave, or is freed; to move a state, serialize it".into())
}

/// Keeps an instance for the host, in the state it names or, if that is NULL, in a new one.
fn keep<B>(saved: &mut Vec<Box<Instance<B>>>, state: &mut *mut c_void, instance: Instance<B>) -> Result<(), Refusal> {
    if state.is_null() {
        let mut instance = Box::new(instance);
        *state = ptr::from_mut(&mut *instance).cast();
        saved.push(instance);
    } else {
        let place = find(saved, *state)?;
        *saved[place] = instance;
    }
    Ok(())
}

pub unsafe fn get_fmu_state<B: Block>(component: Pointer, state: *mut *mut c_void) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::GET_FMU_STATE, |component| {
            let instance = component.instance.clone();
            keep(&mut component.saved, target(state, "FMUstate")?, instance)
        })
    }
}

pub unsafe fn set_fmu_state<B: Block>(component: Pointer, state: *mut c_void) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::SET_FMU_STATE, |component| {
            let place = find(&component.saved, state)?;
            component.instance = (*component.saved[place]).clone();
            Ok(())
        })
    }
}

pub unsafe fn free_fmu_state<B: Block>(component: Pointer, state: *mut *mut c_void) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::FREE_FMU_STATE, |component| {
            let state = target(state, "FMUstate")?;
            if !state.is_null() {
                let place = find(&component.saved, *state)?;
                component.saved.swap_remove(place);
                *state = ptr::null_mut();
            }
            Ok(())
        })
    }
}

pub unsafe fn serialized_fmu_state_size<B: Block>(component: Pointer, state: *mut c_void, size: *mut usize) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::SERIALIZED_FMU_STATE_SIZE, |component| {
            let place = find(&component.saved, state)?;
            *target(size, "size")? = component.saved[place].to_bytes().len();
            Ok(())
        })
    }
}

pub unsafe fn serialize_fmu_state<B: Block>(
    component: Pointer,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::SERIALIZE_FMU_STATE, |component| {
            let place = find(&component.saved, state)?;
            let serialized = component.saved[place].to_bytes();
            let bytes = array_mut(bytes, size, "serializedState")?;
            let length = serialized.len();
            let room = bytes.get_mut(..length).ok_or_else(|| {
                format!("size = {size}: the state takes {length} bytes, as fmi2SerializedFMUstateSize says")
            })?;
            room.copy_from_slice(&serialized);
            Ok(())
        })
    }
}

pub unsafe fn deserialize_fmu_state<B: Block>(
    component: Pointer,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::DESERIALIZE_FMU_STATE, |component| {
            let instance = Instance::from_bytes(array(bytes, size, "serializedState")?)?;
            keep(&mut component.saved, target(state, "FMUstate")?, instance)
        })
    }
}

// Derivatives

pub unsafe fn get_directional_derivative<B: Block>(component: Pointer) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::GET_DIRECTIONAL_DERIVATIVE, |_| {
            Err("not provided (providesDirectionalDerivative = false)".into())
        })
    }
}

pub unsafe fn set_real_input_derivatives<B: Block>(
    component: Pointer,
    references: *const u32,
    count: usize,
    orders: *const c_int,
    derivatives: *const f64,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::SET_REAL_INPUT_DERIVATIVES, |component| {
            component.instance.set_input_derivatives(
                array(references, count, "vr")?,
                array(orders, count, "order")?,
                array(derivatives, count, "value")?,
            )
        })
    }
}

pub unsafe fn get_real_output_derivatives<B: Block>(component: Pointer, count: usize) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::GET_REAL_OUTPUT_DERIVATIVES, |_| match count {
            0 => Ok(()),
            _ => Err("outputs change in steps and have no derivatives (maxOutputDerivativeOrder = 0)".into()),
        })
    }
}

// Computing

#[inline]
pub unsafe fn do_step<B: Block>(component: Pointer, tc: f64, h: f64) -> Status {
    // SAFETY: the host's contract.
    unsafe { enter::<B>(component, &Function::DO_STEP, |component| component.instance.do_step(tc, h)) }
}

pub unsafe fn cancel_step<B: Block>(component: Pointer) -> Status {
    // SAFETY: the host's contract. The state table refuses it before the body.
    unsafe { enter::<B>(component, &Function::CANCEL_STEP, |_| Ok(())) }
}

/// The five status functions: `answer` knows what can be asked.
pub unsafe fn get_status<B: Block, T>(
    component: Pointer,
    function: &'static Function,
    kind: c_int,
    value: *mut T,
    answer: impl FnOnce(&Instance<B>, c_int) -> Option<T>,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, function, |component| {
            let value = target(value, "value")?;
            *value = answer(&component.instance, kind).ok_or_else(|| {
                Refusal::new(Answer::Discard, format!("status kind {kind} has no answer here: no step is ever pending"))
            })?;
            Ok(())
        })
    }
}

/// fmi2LastSuccessfulTime.
pub fn real_status<B: Block>(instance: &Instance<B>, kind: c_int) -> Option<f64> {
    (kind == LAST_SUCCESSFUL_TIME).then(|| instance.last_successful_time())
}

/// fmi2Terminated: a block never ends the simulation.
pub fn boolean_status<B: Block>(_instance: &Instance<B>, kind: c_int) -> Option<Boolean> {
    (kind == TERMINATED).then_some(Boolean(0))
}

/// fmi2DoStepStatus, fmi2PendingStatus and the rest: only asked while a step is pending, which none ever is.
pub fn no_status<B: Block, T>(_instance: &Instance<B>, _kind: c_int) -> Option<T> {
    None
}

// For the packer

/// Copies the block's table as JSON (see [`interface::json`]) to `buffer`, as far as `size` bytes reach, and returns its
/// length in bytes.
pub unsafe fn interface<B: Block>(buffer: *mut u8, size: usize) -> usize {
    let json = interface::json::<B>();
    if !buffer.is_null() {
        let length = size.min(json.len());
        // SAFETY: the caller's buffer has `size` bytes.
        unsafe { ptr::copy_nonoverlapping(json.as_ptr(), buffer, length) };
    }
    json.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::ContC;

    #[test]
    fn the_types_platform_is_default_and_the_version_2_0() {
        for (pointer, expected) in [(get_types_platform(), c"default"), (get_version(), c"2.0")] {
            assert!(!pointer.is_null());
            // SAFETY: not NULL, and the two functions give constants of this file.
            assert_eq!(unsafe { CStr::from_ptr(pointer) }, expected);
        }
    }

    #[test]
    fn a_state_is_found_by_the_address_that_was_given_and_by_no_other() {
        let mut saved: Vec<Box<Instance<ContC>>> = Vec::new();
        let mut states = [ptr::null_mut(); 3];
        for state in &mut states {
            keep(&mut saved, state, Instance::default()).unwrap();
        }
        assert_eq!(states.map(|state| find(&saved, state).unwrap()), [0, 1, 2]);
        assert!(find(&saved, ptr::null_mut()).unwrap_err().reason().contains("none that this instance gave"));
        drop(saved.swap_remove(0));
        assert_eq!(find(&saved, states[2]).unwrap(), 0, "the last one has taken the place of the first");
        assert!(find(&saved, states[0]).is_err(), "freed");
    }

    #[test]
    fn a_state_that_is_given_again_is_overwritten_where_it_is() {
        let mut saved: Vec<Box<Instance<ContC>>> = Vec::new();
        let mut state = ptr::null_mut();
        keep(&mut saved, &mut state, Instance::default()).unwrap();
        let (place, mut later) = (state, Instance::default());
        later.terminate();
        keep(&mut saved, &mut state, later.clone()).unwrap();
        assert_eq!((saved.len(), state), (1, place));
        assert_eq!(saved[0].to_bytes(), later.to_bytes());
    }

    #[test]
    fn of_the_inquiries_only_the_last_successful_time_and_terminated_have_an_answer() {
        let mut instance = Instance::<ContC>::default();
        instance.setup_experiment(7.5, None).unwrap();
        instance.enter_initialization_mode().unwrap();
        instance.exit_initialization_mode().unwrap();
        // fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated
        assert_eq!([0, 1, 2, 3].map(|kind| real_status(&instance, kind)), [None, None, Some(7.5), None]);
        assert_eq!([0, 1, 2, 3].map(|kind| boolean_status(&instance, kind)), [None, None, None, Some(Boolean(0))]);
        assert_eq!([0, 1, 2, 3].map(|kind| no_status::<ContC, c_int>(&instance, kind)), [None; 4]);
    }

    #[test]
    fn a_panic_in_dropping_what_a_block_made_ends_there() {
        struct Loud;
        impl Drop for Loud {
            fn drop(&mut self) {
                panic!("dropped");
            }
        }
        discard(Loud);
    }

    #[test]
    fn an_array_is_null_only_with_length_0() {
        // SAFETY: NULL, which is recognised before it is read.
        let of = |length| unsafe { array::<f64>(ptr::null(), length, "value") };
        assert!(of(0).unwrap().is_empty());
        assert_eq!(of(3).unwrap_err().reason(), "value is NULL, though it should have 3 elements");
        let value = 1.5;
        // SAFETY: one element is there; the other lengths are refused before anything is read.
        let of = |length| unsafe { array(&raw const value, length, "value") };
        assert_eq!(of(1).unwrap(), [1.5]);
        let longest = isize::MAX as usize / 8;
        for length in [longest + 1, usize::MAX] {
            assert_eq!(of(length).unwrap_err().reason(), format!("value cannot have {length} elements"));
        }
    }
}
