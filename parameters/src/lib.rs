//! PLC parameter files: parsed into values of control blocks, and written.
//!
//! A *loop* is one instance of a block, such as an instance data block of a PLC project: a name, and a value for each
//! of the block's inputs and parameters. [`read()`] returns the loops of a file in any [`Format`], [`write()`] writes
//! them in any other, and [`rewrite()`] changes values in a file and preserves the rest of it byte for byte. Every
//! value records its origin ([`Origin`]), and a file with errors yields no loops, but all of its errors ([`Problems`]).
//!
//! No block is named in this crate, and it knows nothing of FMUs: which blocks there are, and their names in a PLC
//! project, is defined by the blocks' tables ([`BlockType`]).

mod block;
mod encoding;
mod format;
mod loops;
mod named;
mod reading;
mod report;
mod rewrite;
mod source;
mod value;

pub mod dump;
pub mod json;
pub mod layout;
pub mod literal;
pub mod openness;
pub mod problem;
pub mod ssv;
pub mod step7;
pub mod tags;

pub mod xml;

pub use block::BlockType;
pub use format::{Format, read, write};
pub use loops::{Loop, MemberValue, Origin};
pub use problem::{Problem, Problems, Remedy, TextPosition};
pub use reading::{Options, Reading};
pub use rewrite::{Replaced, rewrite};
pub use source::Source;
pub use value::{decimal, plc_value};

/// Tests the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
