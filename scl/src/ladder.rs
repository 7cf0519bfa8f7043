//! LAD and FBD: networks as graphs of elements and wires, independent of the file format, and their translation to
//! statements.
//!
//! A reader fills [`Network`]s and calls [`lower()`] for the statements of each. Elements are listed in execution
//! order; [`elements`] maps each instruction name to its law.

mod boxes;
mod calls;
pub mod elements;
mod flow;
mod laws;
mod lint;
mod lower;

pub use crate::network::{Call, Element, Network, Parameter, Source, Way};
pub use lint::lint;
pub use lower::{Owner, comments, lower, network_title};

/// The maximum number of pins of an element.
pub const MOST_PINS: usize = 1000;
