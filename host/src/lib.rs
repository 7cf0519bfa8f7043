//! Opens FMUs, loads and calls them.
//!
//! ```text
//! Package: the file --Fmu: unpacked and loaded--instantiate--> Instance --+
//! System: names, as the user writes them --Plan::of--> Plan --------------+--run--> Recording
//! ```
//!
//! An FMU is foreign code. What it reports as an error becomes an error here. A crash of an FMU, or one that never returns, ends
//! or stops its whole process: [`child`] gives it a process of its own.

pub mod child;
#[cfg(any(test, feature = "doubles"))]
pub mod doubles;
pub mod fmu;
pub mod hexadecimal;
pub mod instance;
pub mod library;
pub mod machine;
pub mod package;
pub mod simulation;
pub mod standard_output;
