//! The last line of an FMU's library.

/// Gives a library the 34 functions of FMI 2.0 for co-simulation over one block, and `plcfmu_interface`, from which the
/// packer reads what the library says of itself.
#[macro_export]
macro_rules! export {
    ($Block:ty) => {
        $crate::exported_functions! { $Block =>
            fn fmi2GetTypesPlatform() -> *const c_char { ffi::get_types_platform() }
            fn fmi2GetVersion() -> *const c_char { ffi::get_version() }
            fn fmi2SetDebugLogging(c: Pointer, logging_on: c_int, count: usize, categories: *const *const c_char) -> Status {
                ffi::set_debug_logging::<TheBlock>(c, logging_on, count, categories)
            }
            fn fmi2Instantiate(
                instance_name: *const c_char,
                fmu_type: c_int,
                guid: *const c_char,
                resource_location: *const c_char,
                callbacks: *const CallbackFunctions,
                _visible: c_int,
                logging_on: c_int,
            ) -> Pointer {
                ffi::instantiate::<TheBlock>(instance_name, fmu_type, guid, resource_location, callbacks, logging_on)
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
                ffi::get_status::<TheBlock, _>(c, &Function::GET_STATUS, kind, value, Component::no_status)
            }
            fn fmi2GetRealStatus(c: Pointer, kind: c_int, value: *mut f64) -> Status {
                ffi::get_status::<TheBlock, _>(c, &Function::GET_REAL_STATUS, kind, value, Component::real_status)
            }
            fn fmi2GetIntegerStatus(c: Pointer, kind: c_int, value: *mut c_int) -> Status {
                ffi::get_status::<TheBlock, _>(c, &Function::GET_INTEGER_STATUS, kind, value, Component::no_status)
            }
            fn fmi2GetBooleanStatus(c: Pointer, kind: c_int, value: *mut Boolean) -> Status {
                ffi::get_status::<TheBlock, _>(c, &Function::GET_BOOLEAN_STATUS, kind, value, Component::boolean_status)
            }
            fn fmi2GetStringStatus(c: Pointer, kind: c_int, value: *mut *const c_char) -> Status {
                ffi::get_status::<TheBlock, _>(c, &Function::GET_STRING_STATUS, kind, value, Component::no_status)
            }
            fn plcfmu_interface(buffer: *mut u8, size: usize) -> usize { ffi::interface::<TheBlock>(buffer, size) }
        }
    };
}
