//! Makes, checks, shows and runs FMUs: the library behind the command `plcfmu`.

pub mod build;
pub mod command;
pub mod host;
pub mod package;
pub mod page;
pub mod progress;
