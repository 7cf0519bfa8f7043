//! A host for the tests in Rust and the benchmarks: it builds the workspace's FMU libraries (or takes those in the folder
//! `PLCFMU_LIBRARIES`), loads them, and calls their C functions as a co-simulation tool does.

// A host calls C functions.
#![allow(unsafe_code)]
// Pointers to components and states go to the FMU as they are: what it does with wrong ones is what is tested.
#![allow(clippy::not_unsafe_ptr_arg_deref)]

mod counting;
mod fmu;
mod host;
mod random;

pub use blocks::{Class, Kind, Role};
pub use counting::Counting;
pub use fmu::{Fmu, all_fmus, fmu_of, plain_library};
pub use host::{Entry, Instance, Log, Status, call_harmlessly, logging_callbacks};
pub use random::Random;

/// A number that the environment gives, or `default`: how much a test tries.
///
/// # Panics
/// It is set and no number.
pub fn setting(name: &str, default: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|error| panic!("{name} = {text:?}: {error}")),
        Err(_) => default,
    }
}

/// The content of a serialized state with its checksum behind it: FNV-1a with 128 bits.
pub fn sealed(mut content: Vec<u8>) -> Vec<u8> {
    let mut hash: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    for byte in &content {
        hash = (hash ^ u128::from(*byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
    }
    content.extend(hash.to_le_bytes());
    content
}
