//! A loaded FMI 2.0 co-simulation library: its functions as declared in C. [`v3`] is its counterpart for
//! FMI 3.0.
//!
//! The functions remain unsafe to call; [`Instance`](crate::instance::Instance) is the safe interface. Tests and
//! benchmarks call them as any host would.

#![allow(unsafe_code)]

use crate::package::temporary::Folder;
use anyhow::{Context, Result, anyhow};
use std::error::Error;
use std::ffi::{c_char, c_double, c_int, c_uint, c_void};
use std::path::Path;
use std::sync::Arc;

/// `fmi2Component`, `fmi2FMUstate`.
pub type Pointer = *mut c_void;

/// `fmi2CallbackLogger`.
pub type Logger = unsafe extern "C" fn(Pointer, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CallbackFunctions {
    /// Called with every message that the FMU logs.
    pub logger: Option<Logger>,
    /// Allocates zeroed memory, like `calloc`. Libraries built by this project never call it.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> Pointer>,
    /// Frees memory allocated by `allocate_memory`. Libraries built by this project never call it.
    pub free_memory: Option<unsafe extern "C" fn(Pointer)>,
    /// Called at the end of an asynchronous step. Libraries built by this project never call it.
    pub step_finished: Option<unsafe extern "C" fn(Pointer, c_int)>,
    /// The first argument of the logger.
    pub environment: Pointer,
}

/// `fmi2Error`, `fmi3Error`: the result of an optional function that the library does not export.
const ERROR: c_int = 3;

/// Looks up the function for a symbol; substitutes a function that returns `fmi2Error` for a missing optional one.
macro_rules! function {
    (required $library:ident $path:ident $symbol:literal ($($argument:ty),*) -> $result:ty) => {
        // SAFETY: FMI defines the type of this symbol.
        *unsafe { $library.get($symbol) }
            .map_err(|_| anyhow!("its library lacks {}", $symbol))?
    };
    (optional $library:ident $path:ident $symbol:literal ($($argument:ty),*) -> $result:ty) => {{
        unsafe extern "C" fn missing($(_: $argument),*) -> $result {
            ERROR
        }
        // SAFETY: FMI defines the type of this symbol.
        let found = unsafe { $library.get::<unsafe extern "C" fn($($argument),*) -> $result>($symbol) };
        found.map_or(missing, |function| *function)
    }};
}

macro_rules! library {
    ($(#[$docs:meta])* prefix $prefix:literal; $($need:ident $field:ident $symbol:literal ($($argument:ty),*) -> $result:ty;)*) => {
        $(#[$docs])*
        #[derive(Clone, Debug)]
        pub struct Library {
            $(
                #[doc = concat!("`", $symbol, "`")]
                pub $field: unsafe extern "C" fn($($argument),*) -> $result,
            )*
            loaded: Arc<Loaded>,
        }

        /// The names of the functions that are looked up.
        pub const FUNCTIONS: &[&str] = &[$($symbol),*];

        /// The common prefix of the version's function names, including those for model exchange.
        pub const PREFIX: &str = $prefix;

        impl Library {
            fn load(path: &Path, folder: Option<Folder>) -> Result<Library> {
                let library = load(path)
                    .map_err(|error| anyhow!("{} cannot be loaded: {}", shown(path), reason(&error, path)))?;
                let lacks = |symbol: &&&str| {
                    // SAFETY: only the address of the symbol is looked up, regardless of its type.
                    unsafe { library.get::<*const ()>(**symbol) }.is_err()
                };
                let missing = FUNCTIONS.iter().filter(lacks).copied().collect();
                Ok(Library {
                    $($field: function!($need library path $symbol ($($argument),*) -> $result),)*
                    loaded: Arc::new(Loaded { library, missing, _folder: folder }),
                })
            }

            /// Loads a library and looks up its functions. This runs code from the library.
            ///
            /// # Errors
            /// It cannot be loaded, or lacks a function that every co-simulation needs.
            pub fn open(path: &Path) -> Result<Library> {
                Library::load(path, None)
            }

            /// Loads a library from a temporary folder, which is removed when the library is unloaded.
            ///
            /// # Errors
            /// As [`Library::open`]; the folder is then removed as well.
            pub fn open_in(folder: Folder, path: &Path) -> Result<Library> {
                Library::load(path, Some(folder))
            }

            /// The table in a library built with `fmu::export!`, as JSON.
            ///
            /// # Errors
            /// The library was not built with `fmu::export!`.
            pub fn interface(&self) -> Result<String> {
                self.loaded.interface()
            }

            /// Whether the library lacks `function`, one of [`FUNCTIONS`].
            pub fn lacks(&self, function: &str) -> bool {
                self.loaded.missing.contains(&function)
            }
        }
    };
}

pub mod v3;

/// A loaded library, by FMI version.
#[derive(Clone, Debug)]
pub enum Opened {
    /// An FMI 2.0 library.
    V2(Library),
    /// An FMI 3.0 library.
    V3(v3::Library),
}

impl Opened {
    /// As [`Library::interface`].
    ///
    /// # Errors
    /// As [`Library::interface`].
    pub fn interface(&self) -> Result<String> {
        match self {
            Opened::V2(library) => library.interface(),
            Opened::V3(library) => library.interface(),
        }
    }
}

library! {
    /// A loaded FMI 2.0 library. Clones share it: it is unloaded when the last one is dropped, and its functions must
    /// not be called afterwards.
    ///
    /// FMI requires all 34 functions, but some libraries lack those that they do not support. Functions essential for
    /// co-simulation are mandatory here. Any other missing function is replaced with one that returns `fmi2Error`, as
    /// the standard requires of unsupported functions.
    prefix "fmi2";
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

/// The library and the folder to which it was unpacked, which is removed after the library is unloaded.
#[derive(Debug)]
struct Loaded {
    library: libloading::Library,
    /// The functions looked up that the library does not export.
    missing: Vec<&'static str>,
    _folder: Option<Folder>,
}

#[cfg(not(windows))]
fn load(path: &Path) -> Result<libloading::Library, libloading::Error> {
    // SAFETY: the initializers of a library can do anything; see the module `host`.
    unsafe { libloading::Library::new(path) }
}

/// Loads a library such that Windows also searches the library's own folder for its dependencies.
#[cfg(windows)]
fn load(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
    // SAFETY: the initializers of a library can do anything; see the module `host`.
    unsafe { Library::load_with_flags(path, LOAD_WITH_ALTERED_SEARCH_PATH) }.map(Into::into)
}

/// The operating system's description of a failure, which libloading's message does not contain.
fn reason(error: &libloading::Error, path: &Path) -> String {
    let reason = error.source().map_or(error.to_string(), ToString::to_string);
    // The reason may start with the path of the unpacked file, which means nothing to the user.
    let reason = reason.strip_prefix(&format!("{}: ", path.display())).unwrap_or(&reason);
    format!("{reason}{}", help(reason))
}

/// The remedy, if the reason suggests one.
fn help(reason: &str) -> &'static str {
    let is_python = reason.contains("undefined symbol: Py") || reason.contains("undefined symbol: _Py");
    if is_python { ": it needs Python; set LD_PRELOAD to the libpython3 library that it was built against" } else { "" }
}

/// The file name of a library.
fn shown(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

impl Loaded {
    /// The table in a library built with `fmu::export!`, as JSON.
    fn interface(&self) -> Result<String> {
        type Interface = unsafe extern "C" fn(*mut u8, usize) -> usize;
        // SAFETY: `fmu::export!` defines the type of this symbol.
        let interface = unsafe { self.library.get::<Interface>("plcfmu_interface") }
            .map_err(|_| anyhow!("the library has no table: its source must end with fmu::export!(MyBlock);"))?;
        // SAFETY: NULL requests only the length, to which the buffer is then sized.
        let json = unsafe {
            let mut json = vec![0; interface(std::ptr::null_mut(), 0)];
            interface(json.as_mut_ptr(), json.len());
            json
        };
        String::from_utf8(json).context("the library's table is not UTF-8")
    }
}

#[cfg(test)]
#[test]
fn an_fmu_that_python_has_to_load_says_so() {
    let of = |symbol: &str| {
        help(&format!("TMP.so: undefined symbol: {symbol}")).contains("set LD_PRELOAD to the libpython3 library")
    };
    assert_eq!(["_Py_NoneStruct", "PyLong_Type", "sin"].map(of), [true, true, false]);
}
