//! Proofs on a PLC: generates a source that compares the PLC's own block with the law of the same block in `blocks`,
//! call by call and bit by bit, and reads the result.
//!
//! The tape in its data blocks holds the inputs of each call and the bits that each output must have afterwards:
//! expected values are computed by the law, never by the PLC's arithmetic. The tape records only changes. A function
//! block makes one call per PLC cycle and stops at the first difference; the result, a data block of fixed layout, then
//! contains the call, the output, and the expected and actual bits ([`Outcome`]).

mod outcome;
mod source;
mod tape;

pub use outcome::{Outcome, RESULT_BYTES, State};
pub use source::{Names, call, largest, print, result};
pub use tape::{MOST_CALLS, Tape};

/// The blocks that can be proved.
pub fn blocks() -> Vec<&'static str> {
    crate::library::natives()
}
