//! Control engineering: figures of a recorded step, a plant's model, settings by tuning rules with their margins and
//! predicted effects, reasons why a recording differs from what a block computes, and gains as other tools write them.

pub mod bode;
pub mod characteristic;
pub mod csv;
pub mod figures;
pub mod gains;
pub mod identify;
pub mod in_force;
pub mod margins;
pub mod predict;
pub mod process;
pub mod replay;
pub mod rules;
pub mod tune;

/// Returns the lowest and the highest of values, without those that are not a number; (∞, −∞) if there are none.
pub fn extremes<'a>(values: impl IntoIterator<Item = &'a f64>) -> (f64, f64) {
    values
        .into_iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// The example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
