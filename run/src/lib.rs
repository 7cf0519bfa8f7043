//! Loops of FMUs and their simulation: connections, the order in which values are exchanged, settings over time, and
//! recording. The implementation of [`Fmus`](fmus::Fmus) decides whether an FMU is a block linked into this program or
//! is used through its C interface.
//!
//! ```text
//! loop.toml --file--> System: names --Plan::new-> Plan: positions and value references --run--> Recording
//! ```

pub mod component;
pub mod dialog;
pub mod file;
pub mod fmus;
pub mod master;
pub mod plan;
pub mod subject;
pub mod system;
pub mod trace;
