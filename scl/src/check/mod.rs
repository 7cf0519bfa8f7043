//! Names and types. Takes the tree of each source; gives what every name declares: types, interfaces of blocks, global
//! variables and constants, all in the state of one compilation ([`compiler`]). Names that no source declares are
//! collected with their uses ([`undeclared`]).
//!
//! Bounds, constants and start values are expressions, so declaring calls [`lower`](crate::lower).

pub(crate) mod compiler;
pub(crate) mod constant;
pub(crate) mod declare;
pub(crate) mod lint;
pub(crate) mod start;
pub(crate) mod types;
pub(crate) mod undeclared;
