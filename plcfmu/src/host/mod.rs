//! Loads FMUs, connects them, runs them and records what they do.
//!
//! ```text
//! System: names, as the user writes them --Plan::of--> Plan: positions and value references --+
//! Fmu: unpacked and loaded -------instantiate--------> Instance ------------------------------+--run--> Recording
//! ```
//!
//! [`Simulation`](simulation::Simulation) does all of it.
//!
//! An FMU is foreign code in this process. What it reports as an error becomes an error here. A crash of an FMU, or one that
//! never returns, ends or stops the whole process: nothing here can catch that.

pub mod file;
pub mod fmu;
pub mod instance;
pub mod library;
pub mod simulation;
pub mod standard_output;
