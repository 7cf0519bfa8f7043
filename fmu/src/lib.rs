//! The FMI 2.0 co-simulation interface that every block's FMU shares.
//!
//! A crate of type `cdylib` becomes the library of an FMU by its last line:
//!
//! ```
//! blocks::block! {
//!     /// Doubles its input.
//!     pub struct Twice as "TWICE" {
//!         input {
//!             /// Input value
//!             u: Real = 0.0;
//!         }
//!         cycle {
//!             /// Time between two calls
//!             cycle: Time = Time::ms(100), min Time::ms(1);
//!         }
//!         output {
//!             /// Output value
//!             y: Real;
//!         }
//!     }
//! }
//!
//! impl blocks::Law for Twice {
//!     fn restart(&mut self) {
//!         self.clear();
//!     }
//!
//!     fn call(&mut self) {
//!         self.y = self.u * 2.0;
//!     }
//! }
//!
//! fmu::export!(Twice);
//! # fn main() {}
//! ```
//!
//! `cargo xtask fmu -p PACKAGE` packs it.
//!
//! Data flows one way: [`ffi`] makes slices of pointers, [`instance`] decides what is allowed and what a step does,
//! [`clock`] says which calls fall into it, and the block's law computes. Between `fmi2DoStep` and the law there is no
//! dynamic dispatch and no allocation.

pub mod clock;
#[allow(missing_docs)] // the standard documents its functions
pub mod ffi;
pub mod instance;
pub mod interface;
pub mod value;

/// Gives a library the 34 functions of FMI 2.0 for co-simulation over one block, and `plcfmu_interface`, from which the
/// packer reads the block's table.
#[macro_export]
macro_rules! export {
    ($Block:ty) => {
        #[allow(unsafe_code, missing_docs, non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]
        mod fmi2 {
            use super::*;
            use $crate::ffi::{self, CallbackFunctions, Pointer, Status};
            use $crate::instance::Function;
            use $crate::value::Boolean;
            use std::ffi::{c_char, c_int, c_void};

            type TheBlock = $Block;

            $crate::functions! {
                fn fmi2GetTypesPlatform() -> *const c_char { ffi::get_types_platform() }
                fn fmi2GetVersion() -> *const c_char { ffi::get_version() }
                fn fmi2SetDebugLogging(c: Pointer, logging_on: c_int, count: usize, categories: *const *const c_char) -> Status {
                    ffi::set_debug_logging::<TheBlock>(c, logging_on, count, categories)
                }
                fn fmi2Instantiate(
                    instance_name: *const c_char,
                    fmu_type: c_int,
                    guid: *const c_char,
                    _resource_location: *const c_char,
                    callbacks: *const CallbackFunctions,
                    _visible: c_int,
                    logging_on: c_int,
                ) -> Pointer {
                    ffi::instantiate::<TheBlock>(instance_name, fmu_type, guid, callbacks, logging_on)
                }
                fn fmi2FreeInstance(c: Pointer) -> () { ffi::free_instance::<TheBlock>(c) }
                fn fmi2SetupExperiment(
                    c: Pointer,
                    _tolerance_defined: c_int,
                    _tolerance: f64,
                    start_time: f64,
                    stop_time_defined: c_int,
                    stop_time: f64,
                ) -> Status {
                    ffi::setup_experiment::<TheBlock>(c, start_time, stop_time_defined, stop_time)
                }
                fn fmi2EnterInitializationMode(c: Pointer) -> Status { ffi::enter_initialization_mode::<TheBlock>(c) }
                fn fmi2ExitInitializationMode(c: Pointer) -> Status { ffi::exit_initialization_mode::<TheBlock>(c) }
                fn fmi2Terminate(c: Pointer) -> Status { ffi::terminate::<TheBlock>(c) }
                fn fmi2Reset(c: Pointer) -> Status { ffi::reset::<TheBlock>(c) }
                fn fmi2GetReal(c: Pointer, vr: *const u32, count: usize, value: *mut f64) -> Status {
                    ffi::get::<TheBlock, _>(c, &Function::GET_REAL, vr, count, value)
                }
                fn fmi2GetInteger(c: Pointer, vr: *const u32, count: usize, value: *mut c_int) -> Status {
                    ffi::get::<TheBlock, _>(c, &Function::GET_INTEGER, vr, count, value)
                }
                fn fmi2GetBoolean(c: Pointer, vr: *const u32, count: usize, value: *mut Boolean) -> Status {
                    ffi::get::<TheBlock, _>(c, &Function::GET_BOOLEAN, vr, count, value)
                }
                fn fmi2GetString(c: Pointer, vr: *const u32, count: usize, _value: *mut *const c_char) -> Status {
                    ffi::strings::<TheBlock>(c, &Function::GET_STRING, vr, count)
                }
                fn fmi2SetReal(c: Pointer, vr: *const u32, count: usize, value: *const f64) -> Status {
                    ffi::set::<TheBlock, _>(c, &Function::SET_REAL, vr, count, value)
                }
                fn fmi2SetInteger(c: Pointer, vr: *const u32, count: usize, value: *const c_int) -> Status {
                    ffi::set::<TheBlock, _>(c, &Function::SET_INTEGER, vr, count, value)
                }
                fn fmi2SetBoolean(c: Pointer, vr: *const u32, count: usize, value: *const Boolean) -> Status {
                    ffi::set::<TheBlock, _>(c, &Function::SET_BOOLEAN, vr, count, value)
                }
                fn fmi2SetString(c: Pointer, vr: *const u32, count: usize, _value: *const *const c_char) -> Status {
                    ffi::strings::<TheBlock>(c, &Function::SET_STRING, vr, count)
                }
                fn fmi2GetFMUstate(c: Pointer, state: *mut *mut c_void) -> Status { ffi::get_fmu_state::<TheBlock>(c, state) }
                fn fmi2SetFMUstate(c: Pointer, state: *mut c_void) -> Status { ffi::set_fmu_state::<TheBlock>(c, state) }
                fn fmi2FreeFMUstate(c: Pointer, state: *mut *mut c_void) -> Status { ffi::free_fmu_state::<TheBlock>(c, state) }
                fn fmi2SerializedFMUstateSize(c: Pointer, state: *mut c_void, size: *mut usize) -> Status {
                    ffi::serialized_fmu_state_size::<TheBlock>(c, state, size)
                }
                fn fmi2SerializeFMUstate(c: Pointer, state: *mut c_void, bytes: *mut u8, size: usize) -> Status {
                    ffi::serialize_fmu_state::<TheBlock>(c, state, bytes, size)
                }
                fn fmi2DeSerializeFMUstate(c: Pointer, bytes: *const u8, size: usize, state: *mut *mut c_void) -> Status {
                    ffi::deserialize_fmu_state::<TheBlock>(c, bytes, size, state)
                }
                fn fmi2GetDirectionalDerivative(
                    c: Pointer,
                    _unknowns: *const u32,
                    _unknown_count: usize,
                    _knowns: *const u32,
                    _known_count: usize,
                    _known_changes: *const f64,
                    _unknown_changes: *mut f64,
                ) -> Status {
                    ffi::get_directional_derivative::<TheBlock>(c)
                }
                fn fmi2SetRealInputDerivatives(
                    c: Pointer,
                    vr: *const u32,
                    count: usize,
                    order: *const c_int,
                    value: *const f64,
                ) -> Status {
                    ffi::set_real_input_derivatives::<TheBlock>(c, vr, count, order, value)
                }
                fn fmi2GetRealOutputDerivatives(
                    c: Pointer,
                    _vr: *const u32,
                    count: usize,
                    _order: *const c_int,
                    _value: *mut f64,
                ) -> Status {
                    ffi::get_real_output_derivatives::<TheBlock>(c, count)
                }
                fn fmi2DoStep(c: Pointer, tc: f64, h: f64, _no_set_fmu_state_prior: c_int) -> Status {
                    ffi::do_step::<TheBlock>(c, tc, h)
                }
                fn fmi2CancelStep(c: Pointer) -> Status { ffi::cancel_step::<TheBlock>(c) }
                fn fmi2GetStatus(c: Pointer, kind: c_int, value: *mut Status) -> Status {
                    ffi::get_status::<TheBlock, _>(c, &Function::GET_STATUS, kind, value, ffi::no_status)
                }
                fn fmi2GetRealStatus(c: Pointer, kind: c_int, value: *mut f64) -> Status {
                    ffi::get_status::<TheBlock, _>(c, &Function::GET_REAL_STATUS, kind, value, ffi::real_status)
                }
                fn fmi2GetIntegerStatus(c: Pointer, kind: c_int, value: *mut c_int) -> Status {
                    ffi::get_status::<TheBlock, _>(c, &Function::GET_INTEGER_STATUS, kind, value, ffi::no_status)
                }
                fn fmi2GetBooleanStatus(c: Pointer, kind: c_int, value: *mut Boolean) -> Status {
                    ffi::get_status::<TheBlock, _>(c, &Function::GET_BOOLEAN_STATUS, kind, value, ffi::boolean_status)
                }
                fn fmi2GetStringStatus(c: Pointer, kind: c_int, value: *mut *const c_char) -> Status {
                    ffi::get_status::<TheBlock, _>(c, &Function::GET_STRING_STATUS, kind, value, ffi::no_status)
                }
                fn plcfmu_interface(buffer: *mut u8, size: usize) -> usize { ffi::interface::<TheBlock>(buffer, size) }
            }
        }
    };
}

/// Exported C functions, unsafe each: the host keeps the standard's contract.
#[doc(hidden)]
#[macro_export]
macro_rules! functions {
    ($(fn $name:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty $body:block)*) => { $(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($($argument: $type),*) -> $result {
            // SAFETY: passed on to the host.
            #[allow(unused_unsafe)]
            unsafe { $body }
        }
    )* };
}
