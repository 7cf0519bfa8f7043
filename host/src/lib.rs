//! Opens, loads and calls FMUs.
//!
//! ```text
//! Package: the file --Fmu: unpacked and loaded--instantiate--> Instance --+
//! System: names, as the user writes them --Plan::of--> Plan --------------+--run--> Recording
//! ```
//!
//! An FMU is foreign code. An error that it reports becomes an error here. A crash terminates the whole process, and a
//! call that never returns blocks it; [`child`] therefore runs FMUs in a separate process.

pub mod child;
pub mod fmu;
pub mod hexadecimal;
pub mod instance;
pub mod library;
pub mod machine;
pub mod package;
pub mod simulation;
pub mod standard_output;
