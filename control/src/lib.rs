//! Control engineering: figures of a recorded step, plant identification, tuning rules with the resulting margins and
//! responses, reasons why a recording differs from a block's output, and controller gains in the forms of other tools.

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

/// Returns the lowest and the highest value, ignoring NaN; (∞, −∞) if no value remains.
pub fn extremes<'a>(values: impl IntoIterator<Item = &'a f64>) -> (f64, f64) {
    values
        .into_iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// The example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
