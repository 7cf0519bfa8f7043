//! FMI 2.0 for co-simulation over the core: the 34 C functions and what the standard says of them.
//!
//! [`ffi`] turns pointers into references and slices, catches panics and calls the logger; [`component`] and [`instance`]
//! decide what a call does; [`states`] says when it is allowed. `preset` reads start values from the FMU's `resources`.

pub mod capabilities;
pub mod component;
mod export;
#[allow(missing_docs)] // the standard documents its functions
pub mod ffi;
pub mod instance;
pub mod interface;
pub mod log;
mod preset;
mod resources;
pub mod states;
pub mod value;

/// The version of FMI, as fmi2GetVersion and modelDescription.xml give it.
pub const VERSION: &std::ffi::CStr = c"2.0";
