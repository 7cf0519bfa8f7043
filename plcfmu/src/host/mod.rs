//! Loads FMUs and runs them.

pub mod instance;
pub mod library;
