//! Reads PLC source text: AWL and SCL sources of STEP 7, and external sources of TIA Portal.
//!
//! A text contains blocks. Instance data blocks of known blocks become loops, and so do the instances declared by a
//! function block whose values are in a data block. Other blocks are skipped.

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
