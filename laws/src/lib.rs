//! Reads block laws written in Rust as typed programs, which `scl` can run in its machine and print as C and SCL.
//!
//! The law in Rust remains the only definition. It consists of the block's table, its methods and the functions they
//! call, which may use `if`, `let`, `match`, `while`, arithmetic, conversions and inner blocks. Anything else is an
//! [`Error`] with file, line and column. Names, order and comments are kept.
//!
//! Numbers agree with Rust to the last bit, with two exceptions where a law panics in Rust: here, integer overflow
//! wraps, and an integer divided by 0 is 0. All NaNs are equivalent, whatever their bits.

mod body;
mod check;
mod expr;
mod item;
mod link;
mod method;
mod pattern;
mod reader;
mod source;
mod table;
mod value;

pub use check::{Check, NUMBERS};
pub use link::with_laws;
pub use source::{Error, Sources};

use scl::Dialect;
use scl::ir::Program;

/// The origins of a block's rules: the words in brackets after the clauses of its documentation, and their meanings.
pub const ORIGINS: [(&str, &str); 5] = [
    ("manual", "the vendor's manual of this block"),
    ("vendor", "the vendor's later texts on this or related blocks"),
    ("measured", "recorded on a real block"),
    ("observed", "published descriptions of the behaviour"),
    ("decided", "our own choice, where all of these are silent"),
];

/// A law as a typed program.
#[derive(Clone, Debug)]
pub struct Law {
    /// The program. Its memory contains the block under its name, then, if the block has a mean, the member `pulse`
    /// with the pulse of the last call, then, if `check` is present, the members that the check writes.
    pub program: Program,
    /// The name of the block in its table.
    pub name: String,
    /// The number of the block's record. Its members are the rows of the block's table, the inner blocks, the mean, and
    /// `memory`.
    pub record: usize,
    /// The index of the function that restarts the block.
    pub restart: usize,
    /// The index of the function that calls the block.
    pub call: usize,
    /// The index of the function that updates `pulse`, if [`read_whole`] was used and the law has a mean.
    pub pulse: Option<usize>,
    /// The check of the block's settings, if [`read_whole`] was used and the law has one.
    pub check: Option<Check>,
}

impl Law {
    /// Prints the law as the source of a function block with the block's name and interface.
    ///
    /// # Errors
    /// The dialect cannot express a part of the law; the message states which part.
    pub fn scl(&self, dialect: Dialect) -> Result<String, String> {
        let functions = &self.program.functions;
        let method = |name: &str| functions.iter().position(|it| it.name == format!("{}.{name}", self.name));
        let body = method("call").ok_or_else(|| format!("{} has no method `call`", self.name))?;
        scl::print(&self.program, &[body], dialect)
    }
}

/// Reads the law of a block by the name in its table, ignoring case.
///
/// # Errors
/// The law uses something unsupported; the error states the location.
pub fn read(sources: &Sources, block: &str) -> Result<Law, Error> {
    reader::law(sources, block, false)
}

/// Reads a law like [`read`], with the functions that only a host needs: the settings check, and the update of the
/// pulse without a call.
///
/// # Errors
/// The law uses something unsupported; the error states the location.
pub fn read_whole(sources: &Sources, block: &str) -> Result<Law, Error> {
    reader::law(sources, block, true)
}
