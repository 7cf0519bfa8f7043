//! FMI 3.0 for co-simulation over the core: the 75 C functions and everything specific to this version.
//!
//! [`ffi`] is the table of functions, each written once; [`value`] has the types of their values, and [`access`]
//! handles arrays and the time. A model description uses either the PLC's types or the few that every host supports
//! ([`Native`], [`Wide`]): the library is the same, and the instantiation token selects the types.

pub mod access;
#[allow(missing_docs)] // the standard documents its functions
pub mod ffi;
mod messages;
pub mod sources;
pub mod value;

use crate::host_type::Version;
use crate::preset::Form;
use blocks::{Row, TableText, Types};

/// FMI 3.0 with the types of the PLC.
#[derive(Clone, Copy, Debug)]
pub struct Native;

/// FMI 3.0 with the few wide types that every host supports.
#[derive(Clone, Copy, Debug)]
pub struct Wide;

/// A choice of types.
pub trait Choice: Version {
    /// The types chosen.
    const TYPES: Types;
}

macro_rules! versions {
    ($($Version:ident),*) => { $(
        impl Version for $Version {
            const NUMBER: &'static str = "3.0";
            const PREFIX: &'static str = "fmi3";

            fn name_of<S: TableText>(row: &Row<S>) -> &'static str {
                Types::$Version.host_type(row.kind, row.is_analog)
            }
        }

        impl Choice for $Version {
            const TYPES: Types = Types::$Version;
        }
    )* };
}

versions!(Native, Wide);

/// The forms of the instantiation token: one for each choice of types.
pub const FORMS: &[Form] = &[Form::Token(Types::Native), Form::Token(Types::Wide)];
