//! Reads PLC source text: STEP 7 AWL and SCL sources, and TIA Portal external sources.
//!
//! A text contains blocks. Instance data blocks of known blocks become loops, and so do the instances declared by a
//! function block if a data block contains their values. Other blocks are skipped.

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
