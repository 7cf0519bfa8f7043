//! What a reader of any format is told and what it gives.

use crate::loops::Loop;
use crate::problem::Problems;

/// What the user says of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The block's name or alias, where the file does not say it.
    pub block: Option<String>,
    /// The loop's name, where the file does not say it; by default the name of the file.
    pub name: Option<String>,
    /// Where the instance begins in a dump, in bytes.
    pub offset: usize,
    /// Loops that are right are read although others of the file are wrong.
    pub is_partial: bool,
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The loops, in the order of the file.
    pub loops: Vec<Loop>,
    /// What the user should know of the file, though it can be read: other blocks that were skipped, what a dump does not
    /// prove.
    pub remarks: Problems,
    /// What is wrong with the loops that are not here, if [`Options::is_partial`] allows that.
    pub wrong: Problems,
}
