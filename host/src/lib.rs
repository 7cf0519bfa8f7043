//! Opens FMUs, loads and calls them.
//!
//! ```text
//! Package: the file --Fmu: unpacked and loaded--instantiate--> Instance --+
//! System: names, as the user writes them --Plan::of--> Plan --------------+--run--> Recording
//! ```
//!
//! [`Simulation`](simulation::Simulation) does all of it.
//!
//! An FMU is foreign code in this process. What it reports as an error becomes an error here. A crash of an FMU, or one that
//! never returns, ends or stops the whole process: nothing here can catch that.

#[cfg(any(test, feature = "doubles"))]
pub mod doubles;
pub mod fmu;
pub mod framing;
pub mod hexadecimal;
pub mod instance;
pub mod library;
pub mod package;
pub mod simulation;
pub mod standard_output;
