//! LAD and FBD: translates networks into statements. A network is a graph of elements and wires, independent of the
//! file format.
//!
//! A reader in [`front`](crate::front) fills [`Network`]s and calls [`lower()`] for the statements of each. Elements are
//! listed in execution order; [`elements`] maps each instruction name to its law.

mod boxes;
mod calls;
pub(crate) mod elements;
mod flow;
mod laws;
mod lint;
mod lower;
mod network;

pub(crate) use lint::lint;
pub(crate) use lower::{Owner, comments, lower, network_title};
pub(crate) use network::{Call, Element, Network, Parameter, Pin, Source, Way};

/// The maximum number of pins of an element.
pub(crate) const MOST_PINS: usize = 1000;
