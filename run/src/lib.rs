//! A loop of FMUs and how it is run: what is connected to what, when values go from output to input, what is set when, and
//! what is recorded. What is behind an FMU, its C interface or a block that is linked in, is up to [`Fmus`](fmus::Fmus).
//!
//! ```text
//! loop.toml --file--> System: names --Plan::of--> Plan: positions and value references --Run--> Recording
//! ```

pub mod component;
pub mod dialog;
pub mod file;
pub mod fmus;
pub mod master;
pub mod plan;
pub mod system;
#[cfg(any(test, feature = "doubles"))]
#[allow(missing_docs)]
pub mod test_home;
pub mod trace;
