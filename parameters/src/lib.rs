//! PLC parameter files: read as values of control blocks, and written.
//!
//! A *loop* is one instance of a block, such as an instance data block of a PLC project: a name, and a value for each of the
//! block's inputs and parameters. [`read()`] gives the loops of a file in any [`Format`], [`write()`] writes them in any other,
//! and [`rewrite()`] changes values in a file and leaves the rest of it byte for byte.
//! Every value knows where it comes from ([`Origin`]), and a file with an error gives no loops, but all its errors
//! ([`Problems`]).
//!
//! Nothing here names a block or knows what an FMU is: what blocks there are, and by which names a PLC project calls them, is
//! in the blocks' tables ([`Block`]).

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

pub use block::{Block, Member, Part};
pub use format::{Format, read, write};
pub use loops::{Loop, Origin, Setting};
pub use problem::{Place, Problem, Problems, Remedy};
pub use reading::{Options, Reading};
pub use rewrite::{Replaced, rewrite};
pub use source::Source;
pub use value::{decimal, plc_value};

/// Tests the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
