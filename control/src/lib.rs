//! Control engineering: figures of a recorded step, a plant's model, settings by rules, their margins and what they lead to,
//! and why a recording differs from what a block computes.

pub mod characteristic;
pub mod csv;
pub mod figures;
pub mod identify;
pub mod margins;
mod predict;
pub mod process;
pub mod replay;
pub mod rules;
pub mod tune;
