//! FMI 2.0 for co-simulation over the core: the 34 C functions and what only this version says.
//!
//! [`ffi`] is the table of the functions, each written once; [`value`] are the types of their values; [`capabilities`] and
//! [`interface`] are what the library says of itself.

pub mod capabilities;
#[allow(missing_docs)] // the standard documents its functions
pub mod ffi;
pub mod interface;
pub mod value;

/// The version of FMI, as fmi2GetVersion and modelDescription.xml give it.
pub const VERSION: &std::ffi::CStr = c"2.0";

/// The words of FMI 2.0.
#[derive(Clone, Copy, Debug)]
pub struct Fmi2;

/// What the standard calls the status of a refused call.
pub fn status_name(answer: crate::refusal::Answer) -> &'static str {
    use crate::refusal::Answer;
    match answer {
        Answer::Error => "fmi2Error",
        Answer::Discard => "fmi2Discard",
        Answer::Fatal => "fmi2Fatal",
    }
}
