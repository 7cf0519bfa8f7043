//! Names and types: turns the tree of each source into declarations (types, block interfaces, global variables and
//! constants), all held in the state of one compilation ([`compiler`]). Names that no source declares are collected
//! together with their uses ([`undeclared`]).
//!
//! Bounds, constants and start values are expressions, so declaring them calls [`lower`](crate::lower).

pub(crate) mod compiler;
pub(crate) mod constant;
pub(crate) mod declare;
pub(crate) mod lint;
pub(crate) mod start;
pub(crate) mod types;
pub(crate) mod undeclared;
