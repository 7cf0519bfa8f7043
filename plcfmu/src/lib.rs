//! Makes, checks, shows and runs FMUs: the library behind the command `plcfmu`.
//!
//! Without the feature `command`, which is on by default, only [`package`] is there, to read and write FMU files.
//! The feature `s7`, on by default too, reads data blocks of a PLC over the network.

#[cfg(feature = "command")]
pub mod build;
#[cfg(feature = "command")]
pub mod command;
#[cfg(feature = "command")]
pub mod commands;
#[cfg(feature = "command")]
pub mod framing;
#[cfg(feature = "command")]
mod hexadecimal;
#[cfg(feature = "command")]
pub mod host;
pub mod package;
#[cfg(feature = "command")]
pub mod page;
#[cfg(feature = "command")]
pub mod parameter_file;
#[cfg(feature = "s7")]
pub mod plc;
#[cfg(feature = "command")]
pub mod progress;
#[cfg(feature = "command")]
pub mod study;
#[cfg(feature = "command")]
pub mod tool;
