//! From sources to libraries.

pub mod compile;
pub mod python;
pub mod workspace;
