//! Builds, checks, describes and runs FMUs: the library of the command `plcfmu`.
//!
//! The feature `s7`, on by default, reads data blocks of a PLC over the network; `server`, also on by default, is the
//! parameter tool's local server.

pub mod build;
pub mod colors;
pub mod command;
pub mod commands;
pub mod exit;
pub mod interruption;
pub mod linked;
pub mod package;
pub mod page;
pub mod parameter_file;
#[cfg(feature = "s7")]
pub mod plc;
pub mod program;
pub mod progress;
pub mod tell;
pub mod tool;
