//! PLC control blocks in plain Rust, faithful to the last bit of a 32-bit REAL.
//!
//! A block is a struct with its inputs, parameters and outputs as public fields; [`Law::call`] is one call of a cyclic
//! interrupt. Nothing here depends on how a block is packaged: it can be used in any Rust program.
//!
//! ```
//! use blocks::{ContC, Law};
//!
//! let mut controller = ContC { man_on: false, sp_int: 1.0, ..ContC::default() };
//! controller.restart();
//! controller.call();
//! assert_eq!(controller.lmn, 2.05);
//! ```
//!
//! The documentation of each block states its law, clause by clause, and where each rule comes from:
//! *manual* (the vendor's published manual), *vendor* (later vendor texts on the same blocks or their sisters),
//! *measured* (recorded at the terminals of a real block), *observed* (published descriptions of how the blocks behave),
//! *decided* (by us, where all of these are silent).

mod abb;
mod siemens;
pub mod table;

pub use abb::Hlg;
pub use siemens::{ContC, ContS, PulsCtr, Pulsegen};
pub use table::{
    Block, Bool, Int, Kind, LReal, Law, Real, Response, Role, Row, Stored, Table, Time, Value, Word, low_word, rnd,
};
