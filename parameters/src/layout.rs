//! Where a data block that is not optimized holds its members: the packing rule of S7.
//!
//! BOOLs fill a byte from its lowest bit on. Everything wider, and the first BOOL after it, begins at an even byte. Numbers
//! are big endian.

use crate::block::{Block, Part};
use blocks::Kind;
use std::fmt;

/// A place in a data block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Address {
    /// The byte, from 0.
    pub byte: usize,
    /// The bit of a BOOL, 0 the lowest; 0 for everything else.
    pub bit: u8,
    /// How the address is written: a BOOL with its bit.
    pub is_bit: bool,
}

impl fmt::Display for Address {
    /// `20`, or `0.3` for a BOOL.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}", self.byte)?;
        if self.is_bit { write!(formatter, ".{}", self.bit) } else { Ok(()) }
    }
}

/// The address of each member, and how many bytes they take together, which is even. A member of an inner block has none, because a table does not
/// say how much memory its neighbours take; nor has what only the FMU has.
pub fn addresses(block: &Block) -> (Vec<Option<Address>>, usize) {
    let mut next = Address { byte: 0, bit: 0, is_bit: true };
    let mut addresses = Vec::new();
    let mut previous = None;
    for member in &block.members {
        if member.part != Part::Own {
            addresses.push(None);
            continue;
        }
        let is_bit = member.kind == Kind::Bool;
        // A section of the declaration (inputs, outputs) begins at an even byte.
        let is_result = !member.role.is_settable();
        if !is_bit || previous != Some((is_bit, is_result)) {
            next = even(next);
        }
        previous = Some((is_bit, is_result));
        addresses.push(Some(Address { is_bit, ..next }));
        next = if is_bit {
            Address { byte: next.byte + usize::from(next.bit == 7), bit: (next.bit + 1) % 8, is_bit }
        } else {
            Address { byte: next.byte + member.kind.width(), bit: 0, is_bit }
        };
    }
    (addresses, even(next).byte)
}

/// The next even byte, unless the address is one.
fn even(address: Address) -> Address {
    let byte = address.byte + usize::from(address.bit > 0);
    Address { byte: byte.next_multiple_of(2), bit: 0, ..address }
}
