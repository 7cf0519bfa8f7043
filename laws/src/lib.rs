//! Laws of blocks, written in Rust, read as typed programs: to be run by `scl`'s machine, printed as C and printed as SCL.
//!
//! The law in Rust stays the only one. Read are its table, its methods and the functions that they call: `if`, `let`, `match`,
//! `while`, arithmetic, conversions, blocks inside of blocks. Anything else is an [`Error`] with file, line and column. Names,
//! order and comments are kept.
//!
//! Numbers are those of Rust to the last bit, with two exceptions, where a law stops in Rust and not here: integers that
//! overflow wrap, and an integer divided by 0 is 0. What is not a number is only that, whatever its bits are.

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

use scl::program::Program;
use scl::scl::Dialect;

/// Where the rules of a block come from: the words in brackets behind its clauses, and whom they stand for.
pub const ORIGINS: [(&str, &str); 5] = [
    ("manual", "the vendor's manual of this block"),
    ("vendor", "the vendor's later texts on this or related blocks"),
    ("measured", "recorded at a real block"),
    ("observed", "published descriptions of the behaviour"),
    ("decided", "by us, where all these are silent"),
];

/// A law as a typed program.
#[derive(Clone, Debug)]
pub struct Law {
    /// The program. Its memory has the block under its name, and behind it, if the block has a mean, what its last call gave for
    /// it under the name `pulse`.
    pub program: Program,
    /// The name of the block in its table.
    pub name: String,
    /// The record of the block: the rows of its table under their names, the blocks inside, the mean, and `memory`.
    pub record: usize,
    /// The number of the function that restarts it.
    pub restart: usize,
    /// The number of the function that calls it.
    pub call: usize,
    /// The number of the function that writes `pulse` anew, if [`read_whole`] has read a law that has a mean.
    pub pulse: Option<usize>,
    /// Why it refuses settings, if [`read_whole`] has read a law that does.
    pub check: Option<Check>,
}

impl Law {
    /// The law as the source of a function block with the block's name and interface.
    ///
    /// # Errors
    /// What the dialect has no word for, by name.
    pub fn scl(&self, dialect: Dialect) -> Result<String, String> {
        let functions = &self.program.functions;
        let method = |name: &str| functions.iter().position(|it| it.name == format!("{}.{name}", self.name));
        let body = method("call").ok_or_else(|| format!("{} has no law that is called", self.name))?;
        scl::scl::print(&self.program, &[body], dialect)
    }
}

/// Reads the law of the block that has this name in its table.
///
/// # Errors
/// What is not known, with its place.
pub fn read(sources: &Sources, block: &str) -> Result<Law, Error> {
    reader::law(sources, block, false)
}

/// The same with all that a host needs: the check of the settings, and the pulse between two calls.
///
/// # Errors
/// What is not known, with its place.
pub fn read_whole(sources: &Sources, block: &str) -> Result<Law, Error> {
    reader::law(sources, block, true)
}
