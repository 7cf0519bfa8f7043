//! The repository's chores as a library: `main` only dispatches.

pub mod deep;
pub mod demo;
pub mod test;
