//! Control engineering: figures of a recorded step, a plant's model, settings by tuning rules with their margins and
//! predicted effects, reasons why a recording differs from what a block computes, and gains as other tools write them.

pub mod bode;
pub mod characteristic;
pub mod csv;
pub mod figures;
pub mod gains;
pub mod identify;
pub mod margins;
pub mod predict;
pub mod process;
pub mod replay;
pub mod rules;
pub mod tune;

/// The example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
