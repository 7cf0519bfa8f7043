//! FMI 2.0 for co-simulation over the core: the 34 C functions and everything specific to this version.
//!
//! [`ffi`] is the table of the functions, each written once; [`value`] has the types of their values.

#[allow(missing_docs)] // the standard documents its functions
pub mod ffi;
mod messages;
pub mod sources;
pub mod value;

use crate::host_type::Version;
use crate::refusal::Answer;
use blocks::{Class, Row, Table, TableText};

/// What the library of a program says of itself, see [`interface::json_of`](crate::interface::json_of).
pub fn describe<S: TableText>(table: &Table<S>, guid: &str) -> String {
    crate::interface::json_of::<Fmi2, _>(table, guid)
}

/// FMI 2.0.
#[derive(Clone, Copy, Debug)]
pub struct Fmi2;

impl Version for Fmi2 {
    const NUMBER: &'static str = "2.0";
    const PREFIX: &'static str = "fmi2";
    const CAPABILITIES: &'static [(&'static str, &'static str)] = &[
        // The clock makes the calls that fall into a step, whatever its size.
        ("canHandleVariableCommunicationStepSize", "true"),
        // The session extrapolates inputs. Outputs change in steps.
        ("canInterpolateInputs", "true"),
        ("maxOutputDerivativeOrder", "0"),
        ("providesDirectionalDerivative", "false"),
        // A state is a copy of the instance.
        ("canGetAndSetFMUstate", "true"),
        ("canSerializeFMUstate", "true"),
        // No globals, no threads, memory of our own.
        ("canRunAsynchronuously", "false"),
        ("canBeInstantiatedOnlyOncePerProcess", "false"),
        ("canNotUseMemoryManagementFunctions", "true"),
    ];

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
