//! A source for a PLC that compares the PLC's own block with the law of a block of `blocks`, call by call and bit by bit.
//!
//! The tape in its data blocks has the inputs of each call and the bits that each output must have after it: expected values
//! come from the law, never from the PLC's arithmetic. Only changes are on the tape. A function block makes one call in each
//! cycle of the PLC and stops at the first difference; a data block of fixed layout, the result, then has call, output, expected
//! and found bits ([`Outcome`]).

mod outcome;
mod source;
mod tape;

pub use outcome::{Outcome, RESULT_BYTES, State};
pub use source::{Names, call, largest, print, result};
pub use tape::{MOST_CALLS, Tape};

/// The blocks for which there is a tape.
pub fn blocks() -> Vec<&'static str> {
    crate::library::natives()
}
