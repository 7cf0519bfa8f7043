//! The functions of FMI 2.0 for co-simulation, each written once.

/// Gives a macro each function: whether no co-simulation can do without it, the name of its field, its symbol and its type.
macro_rules! each_function {
    ($macro:ident) => {
        $macro! {
                required get_types_platform "fmi2GetTypesPlatform" () -> *const c_char;
                required get_version "fmi2GetVersion" () -> *const c_char;
                optional set_debug_logging "fmi2SetDebugLogging" (Pointer, c_int, usize, *const *const c_char) -> c_int;
                required instantiate "fmi2Instantiate" (*const c_char, c_int, *const c_char, *const c_char, *const CallbackFunctions, c_int, c_int) -> Pointer;
                required free_instance "fmi2FreeInstance" (Pointer) -> ();
                required setup_experiment "fmi2SetupExperiment" (Pointer, c_int, c_double, c_double, c_int, c_double) -> c_int;
                required enter_initialization_mode "fmi2EnterInitializationMode" (Pointer) -> c_int;
                required exit_initialization_mode "fmi2ExitInitializationMode" (Pointer) -> c_int;
                required terminate "fmi2Terminate" (Pointer) -> c_int;
                required reset "fmi2Reset" (Pointer) -> c_int;
                required get_real "fmi2GetReal" (Pointer, *const c_uint, usize, *mut c_double) -> c_int;
                required get_integer "fmi2GetInteger" (Pointer, *const c_uint, usize, *mut c_int) -> c_int;
                required get_boolean "fmi2GetBoolean" (Pointer, *const c_uint, usize, *mut c_int) -> c_int;
                optional get_string "fmi2GetString" (Pointer, *const c_uint, usize, *mut *const c_char) -> c_int;
                required set_real "fmi2SetReal" (Pointer, *const c_uint, usize, *const c_double) -> c_int;
                required set_integer "fmi2SetInteger" (Pointer, *const c_uint, usize, *const c_int) -> c_int;
                required set_boolean "fmi2SetBoolean" (Pointer, *const c_uint, usize, *const c_int) -> c_int;
                optional set_string "fmi2SetString" (Pointer, *const c_uint, usize, *const *const c_char) -> c_int;
                optional get_fmu_state "fmi2GetFMUstate" (Pointer, *mut Pointer) -> c_int;
                optional set_fmu_state "fmi2SetFMUstate" (Pointer, Pointer) -> c_int;
                optional free_fmu_state "fmi2FreeFMUstate" (Pointer, *mut Pointer) -> c_int;
                optional serialized_fmu_state_size "fmi2SerializedFMUstateSize" (Pointer, Pointer, *mut usize) -> c_int;
                optional serialize_fmu_state "fmi2SerializeFMUstate" (Pointer, Pointer, *mut u8, usize) -> c_int;
                optional deserialize_fmu_state "fmi2DeSerializeFMUstate" (Pointer, *const u8, usize, *mut Pointer) -> c_int;
                optional get_directional_derivative "fmi2GetDirectionalDerivative" (Pointer, *const c_uint, usize, *const c_uint, usize, *const c_double, *mut c_double) -> c_int;
                optional set_real_input_derivatives "fmi2SetRealInputDerivatives" (Pointer, *const c_uint, usize, *const c_int, *const c_double) -> c_int;
                optional get_real_output_derivatives "fmi2GetRealOutputDerivatives" (Pointer, *const c_uint, usize, *const c_int, *mut c_double) -> c_int;
                required do_step "fmi2DoStep" (Pointer, c_double, c_double, c_int) -> c_int;
                optional cancel_step "fmi2CancelStep" (Pointer) -> c_int;
                optional get_status "fmi2GetStatus" (Pointer, c_int, *mut c_int) -> c_int;
                optional get_real_status "fmi2GetRealStatus" (Pointer, c_int, *mut c_double) -> c_int;
                optional get_integer_status "fmi2GetIntegerStatus" (Pointer, c_int, *mut c_int) -> c_int;
                optional get_boolean_status "fmi2GetBooleanStatus" (Pointer, c_int, *mut c_int) -> c_int;
                optional get_string_status "fmi2GetStringStatus" (Pointer, c_int, *mut *const c_char) -> c_int;
        }
    };
}
#[cfg(feature = "command")]
pub(crate) use each_function;

macro_rules! names {
    ($($need:ident $field:ident $symbol:literal ($($argument:ty),*) -> $result:ty;)*) => {
        /// The names of the 34 functions.
        pub const FUNCTIONS: &[&str] = &[$($symbol),*];
    };
}

each_function!(names);

/// What the names of all functions of FMI 2.0 begin with, those for model exchange too.
pub const PREFIX: &str = "fmi2";
