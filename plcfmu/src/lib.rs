//! Builds, checks, shows and runs FMUs: the library behind the command `plcfmu`.
//!
//! The feature `s7`, on by default, reads data blocks of a PLC over the network; `server`, on by default too, is the parameter
//! tool's server on this machine.

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
