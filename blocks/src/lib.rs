//! PLC control blocks in plain Rust, faithful to the last bit of a 32-bit REAL.
//!
//! A block is a struct with its inputs, parameters and outputs as public fields; [`Law::call`] is one call of a cyclic
//! interrupt. Nothing here knows of FMI, files or time: a block can be used in any Rust program.
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

pub mod block;
mod cont_c;
mod cont_s;
mod error_signal;
mod hlg;
pub mod plant;
mod puls_ctr;
mod pulsegen;
mod stored;
mod types;

pub use block::{Block, Kind, Law, Response, Role, Row, Table, Value};
pub use cont_c::ContC;
pub use cont_s::ContS;
pub use hlg::Hlg;
pub use puls_ctr::PulsCtr;
pub use pulsegen::Pulsegen;
pub use stored::Stored;
pub use types::{Bool, Int, LReal, Real, Time, Word, low_word, rnd};
