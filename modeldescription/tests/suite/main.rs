//! The guarantees of the crate, with a test for each clause.

#![allow(clippy::unwrap_used)]

mod check;
mod description;
mod random;
mod read;
mod sample;
mod table;
mod v3;
mod write;
