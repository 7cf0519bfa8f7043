//! The memory layout of a non-optimized data block: the S7 packing rule.
//!
//! BOOLs fill a byte from its lowest bit up. Wider types, and the first BOOL after them, start at an even byte. Numbers
//! are big-endian.

use crate::block::BlockType;
use blocks::Kind;
use std::fmt;

/// An address in a data block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Address {
    /// The byte offset.
    pub byte: usize,
    /// The bit number of a BOOL, 0 for the lowest bit; 0 for other types.
    pub bit: u8,
    /// Whether the address is displayed with its bit, as for a BOOL.
    pub is_bit: bool,
}

impl fmt::Display for Address {
    /// Displays `20`, or `0.3` for a BOOL.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}", self.byte)?;
        if self.is_bit { write!(formatter, ".{}", self.bit) } else { Ok(()) }
    }
}

/// The address of each member, and their total size in bytes, which is even. Members of inner blocks have no address,
/// because it would depend on the size of memory that the table does not specify; neither do members that exist only in
/// the FMU.
pub fn addresses(block: &BlockType) -> (Vec<Option<Address>>, usize) {
    let mut next = Address { byte: 0, bit: 0, is_bit: true };
    let mut addresses = Vec::new();
    let mut previous = None;
    for (index, member) in block.members.iter().enumerate() {
        if !block.is_own(index) {
            addresses.push(None);
            continue;
        }
        let is_bit = member.kind == Kind::Bool;
        // A section of the declaration (inputs, outputs) starts at an even byte.
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

/// Rounds an address up to an even byte.
fn even(address: Address) -> Address {
    let byte = address.byte + usize::from(address.bit > 0);
    Address { byte: byte.next_multiple_of(2), bit: 0, ..address }
}
