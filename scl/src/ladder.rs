//! LAD and FBD: a network as a graph of elements and wires, whatever format it was read from, and its translation to statements.
//!
//! A reader fills [`Network`]s and asks [`lower()`] for the statements of each. Elements stand in the order in which they
//! take effect; which element a name stands for, and its law, is a row of [`elements`].

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

/// An element has no more pins.
pub const MOST_PINS: usize = 1000;
