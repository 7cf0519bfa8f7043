//! PLC parameter files: parsed into control block values, and written.
//!
//! A *loop* is one instance of a block, such as an instance data block of a PLC project: a name, and a value for each
//! of the block's inputs and parameters. [`read()`] returns the loops of a file in any [`Format`], [`write()`] writes
//! them in any other, and [`rewrite()`] changes values in a file and preserves the rest of it byte for byte. Every
//! value records its origin ([`Origin`]), and a file with errors yields all of its errors ([`Problems`]) and no loops.
//!
//! This crate names no block and does not depend on FMUs: the blocks' tables ([`BlockType`]) define which blocks exist
//! and what they are called in a PLC project.

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
