//! The project's commands, and what they are made of: `cargo xtask help` lists them.

pub mod library;
