//! The input and output of a reader, whatever the format.

use crate::loops::Loop;
use crate::problem::Problems;

/// The user's options for reading a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The block's name or alias, if the file does not specify it.
    pub block: Option<String>,
    /// The loop's name, if the file does not specify it; by default the file name.
    pub name: Option<String>,
    /// The byte offset of the instance in a dump.
    pub offset: usize,
    /// Whether correct loops are returned even if others in the file have errors.
    pub is_partial: bool,
}

/// The contents of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The loops, in file order.
    pub loops: Vec<Loop>,
    /// Remarks for the user on a readable file, such as skipped blocks or doubts about a dump.
    pub remarks: Problems,
    /// The problems of the omitted loops, if [`Options::is_partial`] is set.
    pub wrong: Problems,
}
