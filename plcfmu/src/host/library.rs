//! An FMU's library, loaded: the 34 functions of FMI 2.0 for co-simulation as C declares them, and the block's table.
//!
//! The only place outside the FMUs where there is unsafe code. The functions stay unsafe to call; the packer's check, the
//! tests and the benchmarks call them as a host does.

#![allow(unsafe_code)]

use std::error::Error;
use std::ffi::{c_char, c_double, c_int, c_uint, c_void};
use std::path::Path;

/// `fmi2Component`, `fmi2FMUstate`.
pub type Pointer = *mut c_void;

/// `fmi2CallbackLogger`.
pub type Logger = unsafe extern "C" fn(Pointer, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CallbackFunctions {
    /// Called with every message.
    pub logger: Option<Logger>,
    /// Never called: the FMUs manage their memory themselves.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> Pointer>,
    /// Never called.
    pub free_memory: Option<unsafe extern "C" fn(Pointer)>,
    /// Never called: no step ends later than its call.
    pub step_finished: Option<unsafe extern "C" fn(Pointer, c_int)>,
    /// First argument of the logger.
    pub environment: Pointer,
}

macro_rules! library {
    ($($field:ident $symbol:literal ($($argument:ty),*) -> $result:ty;)*) => {
        /// A loaded library. The functions live as long as it does.
        #[derive(Debug)]
        pub struct Library {
            $(
                #[doc = concat!("`", $symbol, "`")]
                pub $field: unsafe extern "C" fn($($argument),*) -> $result,
            )*
            library: libloading::Library,
        }

        /// The names of the 34 functions.
        pub const FUNCTIONS: &[&str] = &[$($symbol),*];

        impl Library {
            /// Loads a library and finds its functions.
            ///
            /// # Errors
            /// A sentence with the path, and the function that is missing if it is one.
            pub fn open(path: &Path) -> Result<Library, String> {
                // SAFETY: a library that cargo has just built or that was taken from an FMU made here; its initialisers
                // are those of Rust's standard library.
                let library = unsafe { libloading::Library::new(path) }
                    .map_err(|error| format!("{} cannot be loaded: {}", path.display(), reason(&error)))?;
                Ok(Library {
                    $(
                        // SAFETY: FMI 2.0 gives these symbols these types.
                        $field: *unsafe { library.get($symbol) }
                            .map_err(|error| format!("{} has no function {}: {error}", path.display(), $symbol))?,
                    )*
                    library,
                })
            }
        }
    };
}

library! {
    get_types_platform "fmi2GetTypesPlatform" () -> *const c_char;
    get_version "fmi2GetVersion" () -> *const c_char;
    set_debug_logging "fmi2SetDebugLogging" (Pointer, c_int, usize, *const *const c_char) -> c_int;
    instantiate "fmi2Instantiate" (*const c_char, c_int, *const c_char, *const c_char, *const CallbackFunctions, c_int, c_int) -> Pointer;
    free_instance "fmi2FreeInstance" (Pointer) -> ();
    setup_experiment "fmi2SetupExperiment" (Pointer, c_int, c_double, c_double, c_int, c_double) -> c_int;
    enter_initialization_mode "fmi2EnterInitializationMode" (Pointer) -> c_int;
    exit_initialization_mode "fmi2ExitInitializationMode" (Pointer) -> c_int;
    terminate "fmi2Terminate" (Pointer) -> c_int;
    reset "fmi2Reset" (Pointer) -> c_int;
    get_real "fmi2GetReal" (Pointer, *const c_uint, usize, *mut c_double) -> c_int;
    get_integer "fmi2GetInteger" (Pointer, *const c_uint, usize, *mut c_int) -> c_int;
    get_boolean "fmi2GetBoolean" (Pointer, *const c_uint, usize, *mut c_int) -> c_int;
    get_string "fmi2GetString" (Pointer, *const c_uint, usize, *mut *const c_char) -> c_int;
    set_real "fmi2SetReal" (Pointer, *const c_uint, usize, *const c_double) -> c_int;
    set_integer "fmi2SetInteger" (Pointer, *const c_uint, usize, *const c_int) -> c_int;
    set_boolean "fmi2SetBoolean" (Pointer, *const c_uint, usize, *const c_int) -> c_int;
    set_string "fmi2SetString" (Pointer, *const c_uint, usize, *const *const c_char) -> c_int;
    get_fmu_state "fmi2GetFMUstate" (Pointer, *mut Pointer) -> c_int;
    set_fmu_state "fmi2SetFMUstate" (Pointer, Pointer) -> c_int;
    free_fmu_state "fmi2FreeFMUstate" (Pointer, *mut Pointer) -> c_int;
    serialized_fmu_state_size "fmi2SerializedFMUstateSize" (Pointer, Pointer, *mut usize) -> c_int;
    serialize_fmu_state "fmi2SerializeFMUstate" (Pointer, Pointer, *mut u8, usize) -> c_int;
    deserialize_fmu_state "fmi2DeSerializeFMUstate" (Pointer, *const u8, usize, *mut Pointer) -> c_int;
    get_directional_derivative "fmi2GetDirectionalDerivative" (Pointer, *const c_uint, usize, *const c_uint, usize, *const c_double, *mut c_double) -> c_int;
    set_real_input_derivatives "fmi2SetRealInputDerivatives" (Pointer, *const c_uint, usize, *const c_int, *const c_double) -> c_int;
    get_real_output_derivatives "fmi2GetRealOutputDerivatives" (Pointer, *const c_uint, usize, *const c_int, *mut c_double) -> c_int;
    do_step "fmi2DoStep" (Pointer, c_double, c_double, c_int) -> c_int;
    cancel_step "fmi2CancelStep" (Pointer) -> c_int;
    get_status "fmi2GetStatus" (Pointer, c_int, *mut c_int) -> c_int;
    get_real_status "fmi2GetRealStatus" (Pointer, c_int, *mut c_double) -> c_int;
    get_integer_status "fmi2GetIntegerStatus" (Pointer, c_int, *mut c_int) -> c_int;
    get_boolean_status "fmi2GetBooleanStatus" (Pointer, c_int, *mut c_int) -> c_int;
    get_string_status "fmi2GetStringStatus" (Pointer, c_int, *mut *const c_char) -> c_int;
}

/// What the system says of a failure, if it says anything: libloading's own text is only that there was one.
fn reason(error: &libloading::Error) -> String {
    error.source().map_or(error.to_string(), ToString::to_string)
}

impl Library {
    /// The block's table as JSON, as `fmu::interface::json` writes it.
    ///
    /// # Errors
    /// The library was not made with `fmu::export!`.
    pub fn interface(&self) -> Result<String, String> {
        type Interface = unsafe extern "C" fn(*mut u8, usize) -> usize;
        // SAFETY: `fmu::export!` gives the symbol this type.
        let interface = unsafe { self.library.get::<Interface>("plcfmu_interface") }
            .map_err(|_| "the library has no table: its last line should be fmu::export!(MyBlock);".to_string())?;
        // SAFETY: NULL asks for the length alone; then the buffer is as long as that.
        let json = unsafe {
            let mut json = vec![0; interface(std::ptr::null_mut(), 0)];
            interface(json.as_mut_ptr(), json.len());
            json
        };
        String::from_utf8(json).map_err(|error| format!("the library's table is no UTF-8: {error}"))
    }
}
