//! A loaded FMI 3.0 co-simulation library: its functions as declared in C.
//!
//! `fmi3Boolean` is C's `bool`. Where a library writes one, it is a `u8` here because it may be neither 0 nor 1.

use super::{ERROR, Loaded, Pointer, load, reason, shown};
use crate::package::temporary::Folder;
use anyhow::{Result, anyhow};
use std::ffi::{c_char, c_double, c_int};
use std::path::Path;
use std::sync::Arc;

/// `fmi3LogMessageCallback`: environment, status, category, message.
pub type LogMessage = unsafe extern "C" fn(Pointer, c_int, *const c_char, *const c_char);

/// `fmi3IntermediateUpdateCallback`: never passed, so its arguments are not declared.
pub type IntermediateUpdate = unsafe extern "C" fn();

library! {
    /// A loaded FMI 3.0 library, analogous to the FMI 2.0 one, with the functions that a co-simulation host without
    /// Clocks may call.
    prefix "fmi3";
    required get_version "fmi3GetVersion" () -> *const c_char;
    optional set_debug_logging "fmi3SetDebugLogging" (Pointer, bool, usize, *const *const c_char) -> c_int;
    required instantiate_co_simulation "fmi3InstantiateCoSimulation" (*const c_char, *const c_char, *const c_char, bool, bool, bool, bool, *const u32, usize, Pointer, Option<LogMessage>, Option<IntermediateUpdate>) -> Pointer;
    required free_instance "fmi3FreeInstance" (Pointer) -> ();
    required enter_initialization_mode "fmi3EnterInitializationMode" (Pointer, bool, c_double, c_double, bool, c_double) -> c_int;
    required exit_initialization_mode "fmi3ExitInitializationMode" (Pointer) -> c_int;
    optional enter_event_mode "fmi3EnterEventMode" (Pointer) -> c_int;
    required terminate "fmi3Terminate" (Pointer) -> c_int;
    required reset "fmi3Reset" (Pointer) -> c_int;
    optional get_float32 "fmi3GetFloat32" (Pointer, *const u32, usize, *mut f32, usize) -> c_int;
    optional get_float64 "fmi3GetFloat64" (Pointer, *const u32, usize, *mut f64, usize) -> c_int;
    optional get_int8 "fmi3GetInt8" (Pointer, *const u32, usize, *mut i8, usize) -> c_int;
    optional get_uint8 "fmi3GetUInt8" (Pointer, *const u32, usize, *mut u8, usize) -> c_int;
    optional get_int16 "fmi3GetInt16" (Pointer, *const u32, usize, *mut i16, usize) -> c_int;
    optional get_uint16 "fmi3GetUInt16" (Pointer, *const u32, usize, *mut u16, usize) -> c_int;
    optional get_int32 "fmi3GetInt32" (Pointer, *const u32, usize, *mut i32, usize) -> c_int;
    optional get_uint32 "fmi3GetUInt32" (Pointer, *const u32, usize, *mut u32, usize) -> c_int;
    optional get_int64 "fmi3GetInt64" (Pointer, *const u32, usize, *mut i64, usize) -> c_int;
    optional get_uint64 "fmi3GetUInt64" (Pointer, *const u32, usize, *mut u64, usize) -> c_int;
    optional get_boolean "fmi3GetBoolean" (Pointer, *const u32, usize, *mut u8, usize) -> c_int;
    optional get_string "fmi3GetString" (Pointer, *const u32, usize, *mut *const c_char, usize) -> c_int;
    optional get_binary "fmi3GetBinary" (Pointer, *const u32, usize, *mut usize, *mut *const u8, usize) -> c_int;
    optional set_float32 "fmi3SetFloat32" (Pointer, *const u32, usize, *const f32, usize) -> c_int;
    optional set_float64 "fmi3SetFloat64" (Pointer, *const u32, usize, *const f64, usize) -> c_int;
    optional set_int8 "fmi3SetInt8" (Pointer, *const u32, usize, *const i8, usize) -> c_int;
    optional set_uint8 "fmi3SetUInt8" (Pointer, *const u32, usize, *const u8, usize) -> c_int;
    optional set_int16 "fmi3SetInt16" (Pointer, *const u32, usize, *const i16, usize) -> c_int;
    optional set_uint16 "fmi3SetUInt16" (Pointer, *const u32, usize, *const u16, usize) -> c_int;
    optional set_int32 "fmi3SetInt32" (Pointer, *const u32, usize, *const i32, usize) -> c_int;
    optional set_uint32 "fmi3SetUInt32" (Pointer, *const u32, usize, *const u32, usize) -> c_int;
    optional set_int64 "fmi3SetInt64" (Pointer, *const u32, usize, *const i64, usize) -> c_int;
    optional set_uint64 "fmi3SetUInt64" (Pointer, *const u32, usize, *const u64, usize) -> c_int;
    optional set_boolean "fmi3SetBoolean" (Pointer, *const u32, usize, *const u8, usize) -> c_int;
    optional set_string "fmi3SetString" (Pointer, *const u32, usize, *const *const c_char, usize) -> c_int;
    optional set_binary "fmi3SetBinary" (Pointer, *const u32, usize, *const usize, *const *const u8, usize) -> c_int;
    optional get_number_of_variable_dependencies "fmi3GetNumberOfVariableDependencies" (Pointer, u32, *mut usize) -> c_int;
    optional get_variable_dependencies "fmi3GetVariableDependencies" (Pointer, u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize) -> c_int;
    optional get_fmu_state "fmi3GetFMUState" (Pointer, *mut Pointer) -> c_int;
    optional set_fmu_state "fmi3SetFMUState" (Pointer, Pointer) -> c_int;
    optional free_fmu_state "fmi3FreeFMUState" (Pointer, *mut Pointer) -> c_int;
    optional serialized_fmu_state_size "fmi3SerializedFMUStateSize" (Pointer, Pointer, *mut usize) -> c_int;
    optional serialize_fmu_state "fmi3SerializeFMUState" (Pointer, Pointer, *mut u8, usize) -> c_int;
    optional deserialize_fmu_state "fmi3DeserializeFMUState" (Pointer, *const u8, usize, *mut Pointer) -> c_int;
    optional get_directional_derivative "fmi3GetDirectionalDerivative" (Pointer, *const u32, usize, *const u32, usize, *const c_double, usize, *mut c_double, usize) -> c_int;
    optional get_adjoint_derivative "fmi3GetAdjointDerivative" (Pointer, *const u32, usize, *const u32, usize, *const c_double, usize, *mut c_double, usize) -> c_int;
    optional enter_configuration_mode "fmi3EnterConfigurationMode" (Pointer) -> c_int;
    optional exit_configuration_mode "fmi3ExitConfigurationMode" (Pointer) -> c_int;
    optional update_discrete_states "fmi3UpdateDiscreteStates" (Pointer, *mut u8, *mut u8, *mut u8, *mut u8, *mut u8, *mut c_double) -> c_int;
    optional enter_step_mode "fmi3EnterStepMode" (Pointer) -> c_int;
    optional get_output_derivatives "fmi3GetOutputDerivatives" (Pointer, *const u32, usize, *const i32, *mut c_double, usize) -> c_int;
    required do_step "fmi3DoStep" (Pointer, c_double, c_double, bool, *mut u8, *mut u8, *mut u8, *mut c_double) -> c_int;
}
