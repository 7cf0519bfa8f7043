//! The 34 functions of FMI 2.0 for co-simulation, as far as they are unsafe: pointers become slices and references,
//! `enter` catches panics, calls the logger and makes the status. [`Component`] decides everything else.
//!
//! What the host has to ensure, as the standard says: a `fmi2Component` comes from `fmi2Instantiate`, is not freed yet and
//! is used by one thread at a time; an array has the length that stands beside it. NULL is recognized everywhere.

#![allow(unsafe_code)]
// The contract above is the safety section of every function here.
#![allow(clippy::missing_safety_doc)]

use crate::refusal::{Answer, Refusal};
use crate::v2::capabilities::{Capability, Setting};
use crate::v2::component::{Component, StateAddress};
use crate::v2::log::{self, Category};
use crate::v2::states::Function;
use crate::v2::value::FmiType;
use crate::v2::{VERSION, interface};
use blocks::Block;
use std::any::Any;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::{ptr, slice};

/// What follows from how the functions are called: no globals, no threads, memory of our own.
pub const CAPABILITIES: &[Capability] = &[
    ("canRunAsynchronuously", Setting::Flag(false)),
    ("canBeInstantiatedOnlyOncePerProcess", Setting::Flag(false)),
    ("canNotUseMemoryManagementFunctions", Setting::Flag(true)),
];

/// `fmi2Status`, an enum of C.
pub type Status = c_int;
const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;
const FATAL: Status = 4;

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

/// `fmi2CallbackFunctions`. The library manages its memory itself, and every step ends within its call, so only the logger
/// is used.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    logger: Option<Logger>,
    allocate_memory: *const c_void,
    free_memory: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

/// Whom to tell.
struct Host {
    logger: Logger,
    environment: *mut c_void,
    instance_name: CString,
}

impl Host {
    fn log(&self, function: &Function, refusal: &Refusal) {
        self.tell(function, status(refusal.answer()), Category::of(refusal.answer()), refusal.reason());
    }

    fn tell(&self, function: &Function, status: Status, category: &Category, message: &str) {
        let text = log::text(function, message);
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
}

/// What a `fmi2Component` points to.
struct Handle<B> {
    component: Component<B>,
    host: Host,
}

impl<B: Block> Handle<B> {
    /// Logs a refusal and gives its status.
    #[cold]
    #[inline(never)]
    fn refuse(&self, function: &Function, refusal: &Refusal) -> Status {
        if self.component.logged.contains(Category::of(refusal.answer())) {
            self.host.log(function, refusal);
        }
        status(refusal.answer())
    }

    /// Logs what the user should know of a call that succeeded.
    #[cold]
    #[inline(never)]
    fn advise(&mut self, function: &Function) {
        for advice in std::mem::take(&mut self.component.advice) {
            self.host.tell(function, OK, &Category::ADVICE, &advice);
        }
    }

    #[cold]
    #[inline(never)]
    fn lock(&mut self, function: &Function, panic: Box<dyn Any + Send>) -> Status {
        self.component.instance.lock();
        self.refuse(function, &panic_refusal(panic))
    }
}

fn status(answer: Answer) -> Status {
    match answer {
        Answer::Error => ERROR,
        Answer::Discard => DISCARD,
        Answer::Fatal => FATAL,
    }
}

/// Every function on a component goes through here.
unsafe fn enter<B: Block>(
    component: Pointer,
    function: &'static Function,
    body: impl FnOnce(&mut Component<B>) -> Result<(), Refusal>,
) -> Status {
    // SAFETY: if it is not NULL, the host's contract says that `instantiate` made it.
    let Some(handle) = (unsafe { component.cast::<Handle<B>>().as_mut() }) else {
        return ERROR;
    };
    match catch_unwind(AssertUnwindSafe(|| {
        handle.component.instance.may(function)?;
        body(&mut handle.component)
    })) {
        Ok(Ok(())) => {
            if !handle.component.advice.is_empty() {
                handle.advise(function);
            }
            OK
        }
        Ok(Err(refusal)) => handle.refuse(function, &refusal),
        Err(panic) => handle.lock(function, panic),
    }
}

/// The functions of a control cycle come here first: `common` does the call in its most frequent case and says whether it
/// was that. If not, nothing has happened, and the caller goes on with `enter`.
///
/// A panic of the block makes the call fatal, as in `enter`.
#[inline(always)]
unsafe fn try_common<B: Block>(
    component: Pointer,
    function: &'static Function,
    common: impl FnOnce(&mut Component<B>) -> bool,
) -> Option<Status> {
    // SAFETY: as in `enter`.
    let handle = unsafe { component.cast::<Handle<B>>().as_mut() }?;
    if !handle.component.instance.allows_common(function) {
        return None;
    }
    match catch_unwind(AssertUnwindSafe(|| common(&mut handle.component))) {
        Ok(true) => Some(OK),
        Ok(false) => None,
        Err(panic) => Some(handle.lock(function, panic)),
    }
}

#[cold]
fn panic_refusal(panic: Box<dyn Any + Send>) -> Refusal {
    let text = panic.downcast_ref::<&str>().copied().or(panic.downcast_ref::<String>().map(String::as_str));
    let reason = format!("panic in the block: {}; the instance is locked", text.unwrap_or("no message"));
    discard(panic);
    Refusal::new(Answer::Fatal, reason)
}

/// Drops what a block made, and catches a panic in doing so.
fn discard<T>(value: T) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| drop(value)))
        && let Err(another) = catch_unwind(AssertUnwindSafe(|| drop(panic)))
    {
        // A payload that panics again when it is dropped is leaked.
        std::mem::forget(another);
    }
}

/// The array of `length` elements at `pointer`; NULL is an array of length 0.
unsafe fn array<'a, T>(pointer: *const T, length: usize, name: &str) -> Result<&'a [T], Refusal> {
    if pointer.is_null() && length == 0 {
        return Ok(&[]);
    }
    // SAFETY: as here.
    unsafe { plain_array(pointer, length) }.ok_or_else(|| no_array(pointer.is_null(), length, name))
}

/// The same, to write to.
unsafe fn array_mut<'a, T>(pointer: *mut T, length: usize, name: &str) -> Result<&'a mut [T], Refusal> {
    if pointer.is_null() && length == 0 {
        return Ok(&mut []);
    }
    // SAFETY: as here.
    unsafe { plain_array_mut(pointer, length) }.ok_or_else(|| no_array(pointer.is_null(), length, name))
}

/// The array of `length` elements at `pointer`, if that is not NULL and memory can be so long.
#[inline(always)]
unsafe fn plain_array<'a, T>(pointer: *const T, length: usize) -> Option<&'a [T]> {
    if pointer.is_null() || length > isize::MAX as usize / size_of::<T>() {
        return None;
    }
    // SAFETY: not NULL, no longer than memory can be, and as long as the host says.
    Some(unsafe { slice::from_raw_parts(pointer, length) })
}

/// The same, to write to.
#[inline(always)]
unsafe fn plain_array_mut<'a, T>(pointer: *mut T, length: usize) -> Option<&'a mut [T]> {
    if pointer.is_null() || length > isize::MAX as usize / size_of::<T>() {
        return None;
    }
    // SAFETY: as in `plain_array`, and nobody else uses it during the call.
    Some(unsafe { slice::from_raw_parts_mut(pointer, length) })
}

fn no_array(is_null: bool, length: usize, name: &str) -> Refusal {
    match is_null {
        true => format!("{name} is NULL, though it should have {length} elements"),
        false => format!("{name} cannot have {length} elements"),
    }
    .into()
}

/// The host's variable for a result.
unsafe fn target<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Refusal> {
    // SAFETY: if it is not NULL, it points to the host's variable.
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
    VERSION.as_ptr()
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
            let categories = array(categories, count, "categories")?;
            component.set_debug_logging(logging_on != 0, categories.iter().map(|name| text(*name)))
        })
    }
}

// Create and destroy

pub unsafe fn instantiate<B: Block>(
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
    let host = Host { logger, environment, instance_name: name.unwrap_or(c"").to_owned() };
    let component = catch_unwind(|| Component::<B>::new(name, fmu_type, guid, resources, logging_on != 0))
        .unwrap_or_else(|panic| Err(panic_refusal(panic)));
    match component {
        Ok(component) => Box::into_raw(Box::new(Handle { component, host })).cast(),
        Err(refusal) => {
            // Without an instance, the logger is the only way to say what is wrong: it is called even if loggingOn is false.
            host.log(&Function::INSTANTIATE, &refusal);
            ptr::null_mut()
        }
    }
}

pub unsafe fn free_instance<B: Block>(component: Pointer) {
    if !component.is_null() {
        // SAFETY: made by `instantiate`, and not used again by the host's contract.
        let handle = *unsafe { Box::from_raw(component.cast::<Handle<B>>()) };
        // One by one: a panic while another unwinds would end the process.
        handle.component.into_instances().for_each(discard);
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
        enter::<B>(component, &Function::EXIT_INITIALIZATION_MODE, |component| component.exit_initialization_mode())
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
            component.reset();
            Ok(())
        })
    }
}

// Variable values

#[inline(always)]
pub unsafe fn get<B: Block, T: FmiType>(
    component: Pointer,
    function: &'static Function,
    references: *const u32,
    count: usize,
    values: *mut T,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        try_common::<B>(component, function, |component| {
            match (plain_array(references, count), plain_array_mut(values, count)) {
                (Some(references), Some(values)) => component.instance.get_common(references, values),
                _ => false,
            }
        })
        .unwrap_or_else(|| get_any::<B, T>(component, function, references, count, values))
    }
}

#[inline(never)]
unsafe fn get_any<B: Block, T: FmiType>(
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

#[inline(always)]
pub unsafe fn set<B: Block, T: FmiType>(
    component: Pointer,
    function: &'static Function,
    references: *const u32,
    count: usize,
    values: *const T,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        try_common::<B>(component, function, |component| {
            match (plain_array(references, count), plain_array(values, count)) {
                (Some(references), Some(values)) => component.instance.set_common(references, values),
                _ => false,
            }
        })
        .unwrap_or_else(|| set_any::<B, T>(component, function, references, count, values))
    }
}

#[inline(never)]
unsafe fn set_any<B: Block, T: FmiType>(
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

/// Both functions for String variables.
pub unsafe fn strings<B: Block>(
    component: Pointer,
    function: &'static Function,
    references: *const u32,
    count: usize,
) -> Status {
    // SAFETY: the host's contract.
    unsafe { enter::<B>(component, function, |component| component.strings(array(references, count, "vr")?)) }
}

// FMU states

pub unsafe fn get_fmu_state<B: Block>(component: Pointer, state: *mut StateAddress) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::GET_FMU_STATE, |component| component.get_state(target(state, "FMUstate")?))
    }
}

pub unsafe fn set_fmu_state<B: Block>(component: Pointer, state: StateAddress) -> Status {
    // SAFETY: the host's contract.
    unsafe { enter::<B>(component, &Function::SET_FMU_STATE, |component| component.set_state(state)) }
}

pub unsafe fn free_fmu_state<B: Block>(component: Pointer, state: *mut StateAddress) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::FREE_FMU_STATE, |component| component.free_state(target(state, "FMUstate")?))
    }
}

pub unsafe fn serialized_fmu_state_size<B: Block>(component: Pointer, state: StateAddress, size: *mut usize) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::SERIALIZED_FMU_STATE_SIZE, |component| {
            *target(size, "size")? = component.serialized_size(state)?;
            Ok(())
        })
    }
}

pub unsafe fn serialize_fmu_state<B: Block>(
    component: Pointer,
    state: StateAddress,
    bytes: *mut u8,
    size: usize,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::SERIALIZE_FMU_STATE, |component| {
            component.serialize(state, array_mut(bytes, size, "serializedState")?)
        })
    }
}

pub unsafe fn deserialize_fmu_state<B: Block>(
    component: Pointer,
    bytes: *const u8,
    size: usize,
    state: *mut StateAddress,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::DESERIALIZE_FMU_STATE, |component| {
            component.deserialize(array(bytes, size, "serializedState")?, target(state, "FMUstate")?)
        })
    }
}

// Derivatives

pub unsafe fn get_directional_derivative<B: Block>(component: Pointer) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, &Function::GET_DIRECTIONAL_DERIVATIVE, |component| component.directional_derivative())
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
        enter::<B>(component, &Function::GET_REAL_OUTPUT_DERIVATIVES, |component| component.output_derivatives(count))
    }
}

// Computing

#[inline(always)]
pub unsafe fn do_step<B: Block>(component: Pointer, tc: f64, h: f64) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        try_common::<B>(component, &Function::DO_STEP, |component| component.instance.do_common_step(tc, h))
            .unwrap_or_else(|| do_any_step::<B>(component, tc, h))
    }
}

#[inline(never)]
unsafe fn do_any_step<B: Block>(component: Pointer, tc: f64, h: f64) -> Status {
    // SAFETY: the host's contract.
    unsafe { enter::<B>(component, &Function::DO_STEP, |component| component.do_step(tc, h)) }
}

pub unsafe fn cancel_step<B: Block>(component: Pointer) -> Status {
    // SAFETY: the host's contract.
    unsafe { enter::<B>(component, &Function::CANCEL_STEP, |component| component.cancel_step()) }
}

/// The five status functions: `answer` knows what can be asked.
pub unsafe fn get_status<B: Block, T>(
    component: Pointer,
    function: &'static Function,
    kind: c_int,
    value: *mut T,
    answer: impl FnOnce(&Component<B>, c_int) -> Result<T, Refusal>,
) -> Status {
    // SAFETY: the host's contract.
    unsafe {
        enter::<B>(component, function, |component| {
            let value = target(value, "value")?;
            *value = answer(component, kind)?;
            Ok(())
        })
    }
}

// For the packer

/// Copies what the library says of itself (see [`interface::json`]) to `buffer`, at most `size` bytes, and returns its full
/// length in bytes.
pub unsafe fn interface<B: Block>(buffer: *mut u8, size: usize) -> usize {
    let json = interface::json::<B>();
    if !buffer.is_null() {
        let length = size.min(json.len());
        // SAFETY: the caller's buffer has `size` bytes, which is at least `length`.
        unsafe { ptr::copy_nonoverlapping(json.as_ptr(), buffer, length) };
    }
    json.len()
}

/// The exported C functions of one block. They are unsafe because the host has to keep the contract of this file.
#[doc(hidden)]
#[macro_export]
macro_rules! exported_functions {
    ($Block:ty => $(fn $name:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty $body:block)*) => {
        #[allow(unsafe_code, missing_docs, non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]
        mod fmi2 {
            use super::*;
            use $crate::v2::component::Component;
            use $crate::v2::ffi::{self, CallbackFunctions, Pointer, Status};
            use $crate::v2::states::Function;
            use $crate::v2::value::Boolean;
            use std::ffi::{c_char, c_int, c_void};

            type TheBlock = $Block;

            $(
                #[unsafe(no_mangle)]
                pub unsafe extern "C" fn $name($($argument: $type),*) -> $result {
                    // SAFETY: passed on to the host.
                    #[allow(unused_unsafe)]
                    unsafe { $body }
                }
            )*
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_types_platform_is_default_and_the_version_2_0() {
        for (pointer, expected) in [(get_types_platform(), c"default"), (get_version(), c"2.0")] {
            assert!(!pointer.is_null());
            // SAFETY: not NULL, and the two functions give constants of this file.
            assert_eq!(unsafe { CStr::from_ptr(pointer) }, expected);
        }
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

    blocks::block! {
        /// Panics in its tenth call.
        pub struct Fragile as "FRAGILE" {
            input {
                /// Unused
                u: Real = 0.0;
            }
            cycle {
                /// Time between two calls
                cycle: Time = Time::ms(1000), min Time::ms(1);
            }
            output {
                /// Calls since the restart
                calls: LReal;
            }
        }
    }

    impl blocks::Law for Fragile {
        fn restart(&mut self) {
            self.clear();
        }

        fn call(&mut self) {
            self.calls += 1.0;
            assert!(self.calls < 10.0, "the tenth call");
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
        let guid = CString::new(interface::Guid::<Fragile>::TEXT).unwrap();
        // SAFETY: all pointers point to what the functions take.
        unsafe {
            let component =
                instantiate::<Fragile>(c"x".as_ptr(), 1, guid.as_ptr(), ptr::null(), &raw const callbacks, 0);
            assert_eq!(setup_experiment::<Fragile>(component, 0.0, 0, 0.0), OK);
            assert_eq!(enter_initialization_mode::<Fragile>(component), OK);
            assert_eq!(exit_initialization_mode::<Fragile>(component), OK);
            component
        }
    }

    #[test]
    fn a_panic_in_one_of_many_ordinary_steps_is_fatal_and_locks_the_instance() {
        let component = running();
        // SAFETY: a living component, freed once.
        unsafe {
            let statuses: Vec<Status> = (0..11).map(|k| do_step::<Fragile>(component, f64::from(k), 1.0)).collect();
            assert_eq!(statuses, [OK, OK, OK, OK, OK, OK, OK, OK, OK, FATAL, FATAL]);
            let mut value = 5.0;
            let status = get::<Fragile, f64>(component, &Function::GET_REAL, &raw const U, 1, &raw mut value);
            assert_eq!((status, value), (FATAL, 5.0));
            free_instance::<Fragile>(component);
        }
    }

    #[test]
    fn one_wrong_value_of_two_changes_neither() {
        let component = running();
        // SAFETY: a living component, freed once; arrays as long as counted.
        unsafe {
            let set = |references: [u32; 2], values: [f64; 2]| {
                set::<Fragile, f64>(component, &Function::SET_REAL, references.as_ptr(), 2, values.as_ptr())
            };
            let u = || {
                let mut value = f64::NAN;
                assert_eq!(get::<Fragile, f64>(component, &Function::GET_REAL, &raw const U, 1, &raw mut value), OK);
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
            free_instance::<Fragile>(component);
        }
    }
}
