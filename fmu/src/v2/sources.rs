//! FMI 2.0 in C.

use super::{ffi, messages};
use crate::sources::Door;
use blocks::{Class, Row};

/// The FMI 2.0 C door.
pub static DOOR: Door = Door {
    standard: "FMI 2.0",
    header_name: "fmi2Functions.h",
    header: include_str!("c/fmi2Functions.h"),
    prefix: "FMI2_FUNCTION_PREFIX",
    names: include_str!("c/types.c"),
    table: ffi::TABLE,
    messages: messages::ALL,
    functions: ["", include_str!("c/functions.c")],
    types: &["Real", "Integer", "Boolean"],
    type_of,
    has_arrays: false,
    has_dependencies: false,
    token: |hash| hash,
};

fn type_of(variable: &Row) -> &'static str {
    match variable.kind.class() {
        Class::Real => "Real",
        Class::Integer => "Integer",
        Class::Boolean => "Boolean",
    }
}
