//! FMI 2.0 for co-simulation over the core: the 34 C functions and everything specific to this version.
//!
//! [`ffi`] is the table of functions, each written once; [`value`] has the types of their values.

mod describe;
#[allow(missing_docs)] // the standard documents its functions
pub mod ffi;
mod messages;
pub mod sources;
pub mod value;

use crate::host_type::Version;
use crate::refusal::Answer;
use blocks::{Class, Row, TableText};

pub use describe::describe;

/// The capabilities of an FMU: attributes in modelDescription.xml; those not listed have the standard's default. Other
/// versions derive theirs from these.
pub const CAPABILITIES: &[(&str, bool)] = &[
    // The clock makes the calls within a step, whatever its size.
    ("canHandleVariableCommunicationStepSize", true),
    // The session extrapolates inputs. Outputs change in steps.
    ("canInterpolateInputs", true),
    ("providesDirectionalDerivative", false),
    // A state is a copy of the instance.
    ("canGetAndSetFMUstate", true),
    ("canSerializeFMUstate", true),
    // No globals, no threads, and memory managed by the library.
    ("canRunAsynchronuously", false),
    ("canBeInstantiatedOnlyOncePerProcess", false),
    ("canNotUseMemoryManagementFunctions", true),
];

/// FMI 2.0.
#[derive(Clone, Copy, Debug)]
pub struct Fmi2;

impl Version for Fmi2 {
    const NUMBER: &'static str = "2.0";
    const PREFIX: &'static str = "fmi2";

    fn name_of<S: TableText>(row: &Row<S>) -> &'static str {
        match row.kind.class() {
            Class::Real => "Real",
            Class::Integer => "Integer",
            Class::Boolean => "Boolean",
        }
    }
}

/// The standard's name for the status of a refused call.
pub fn status_name(answer: Answer) -> &'static str {
    match answer {
        Answer::Error => "fmi2Error",
        Answer::Discard => "fmi2Discard",
        Answer::Fatal => "fmi2Fatal",
    }
}
