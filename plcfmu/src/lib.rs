//! Builds, checks, describes and runs FMUs: the library of the command `plcfmu`.
//!
//! Three features are on by default: `mcp` serves agents and editors, `s7` reads data blocks of a PLC over the network,
//! and `server` is the parameter tool's local server.

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
