//! The hidden command that runs foreign code in a separate process, see [`host::child`].

use crate::linked;
use crate::package::apart;
#[cfg(feature = "server")]
use crate::tool::child;
use anyhow::{Result, bail};
use host::child::run as simulation;
use std::path::PathBuf;
use study::worker;

/// A request from another plcfmu process.
#[derive(clap::Args, Clone, Debug)]
pub struct Options {
    /// The role of the process
    role: String,
    /// Where FMUs are unpacked
    folder: PathBuf,
}

/// Carries out the requests read from standard input until it ends.
///
/// # Errors
/// The role does not exist, or the other side has closed the connection.
pub fn run(options: &Options) -> Result<()> {
    match options.role.as_str() {
        simulation::ROLE => simulation::child(&options.folder),
        apart::ROLE => apart::child(&options.folder),
        worker::ROLE => worker::run(&options.folder, linked::find),
        #[cfg(feature = "server")]
        child::ROLE => child::run(&options.folder),
        role => bail!("no role {role}"),
    }
}
