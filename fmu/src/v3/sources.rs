//! FMI 3.0 in C, for each choice of types.

use super::{ffi, messages};
use crate::sources::{Door, EVENTS};
use blocks::Types;

/// The types in the order of their numbers in the C file.
const TYPES: &[&str] =
    &["Float32", "Float64", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean"];

/// The door with the types of the PLC.
pub static NATIVE: Door = Door {
    type_of: |variable| Types::Native.host_type(variable.kind, variable.is_analog),
    has_arrays: Types::Native.has_arrays(),
    token: |hash| Types::Native.token(hash),
    ..DOOR
};

/// The door with the few wide types that every host supports.
pub static WIDE: Door = DOOR;

const DOOR: Door = Door {
    standard: "FMI 3.0",
    header_name: "fmi3Functions.h",
    header: include_str!("c/fmi3Functions.h"),
    prefix: "FMI3_FUNCTION_PREFIX",
    names: include_str!("c/types.c"),
    table: ffi::TABLE,
    messages: messages::ALL,
    functions: [EVENTS, include_str!("c/functions.c")],
    types: TYPES,
    type_of: |variable| Types::Wide.host_type(variable.kind, variable.is_analog),
    has_arrays: Types::Wide.has_arrays(),
    has_dependencies: true,
    token: |hash| Types::Wide.token(hash),
};
