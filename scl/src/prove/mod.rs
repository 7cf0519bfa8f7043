//! Proofs on a PLC. Takes the law of a block of `blocks`; gives a source for a PLC that compares the PLC's own block with
//! it, call by call and bit by bit, and reads the result.
//!
//! The tape in its data blocks holds the inputs of each call and the bits that each output must have afterwards:
//! expected values come from the law, never from the PLC's arithmetic. The tape records only changes. A function block
//! makes one call in each cycle of the PLC and stops at the first difference; the result, a data block of fixed layout,
//! then contains the call, the output, and the expected and actual bits ([`Outcome`]).

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
