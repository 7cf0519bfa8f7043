//! PLC source text: AWL and SCL sources of STEP 7, and external sources of TIA Portal.
//!
//! A text holds blocks. Its instance data blocks of known block types become loops, and so do the instances that a function
//! block declares and a data block gives values to. Other blocks are skipped.

mod instance;
mod lexer;
mod parser;
mod reader;
#[cfg(test)]
mod tests;
mod values;
mod writer;

pub use reader::read;
pub(crate) use writer::path as member_path;
pub use writer::{write, write_tia};
