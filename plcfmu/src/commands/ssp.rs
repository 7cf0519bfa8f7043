//! `plcfmu ssp`: packs FMUs, their values and connections as an SSP file.

use super::{print, replacing, system};
use crate::package::ssp::{self, Version};
use crate::tell;
use ::program::survey::counted;
use anyhow::{Result, bail, ensure};
use host::package::temporary;
use std::io::Write;
use std::path::PathBuf;

/// Pack FMUs with their values and connections as an SSP file
///
/// Tools that run systems of FMUs read SSP files (System Structure and Parameterization), for example libcosim, Ecos,
/// FMPy and OMSimulator. This command accepts the arguments of `plcfmu run`, but does not run the FMUs.
#[derive(clap::Args, Clone, Debug)]
pub struct Options {
    #[command(flatten)]
    system: system::Arguments,
    /// The file to write
    #[arg(short, long, value_name = "FILE.ssp")]
    out: PathBuf,
    /// The version of the SSP standard
    #[arg(long, value_name = "VERSION", default_value = "1.0")]
    ssp_version: Version,
    /// Leave out the connectors of inputs that are not connected
    ///
    /// FMPy's master for SSP files needs this: it fails, or reads the wrong output, if an input has a connector but no
    /// connection.
    #[arg(long)]
    only_connected: bool,
}

/// Writes the SSP file.
///
/// # Errors
/// An argument is invalid, or an SSP file cannot describe the system; nothing is written.
pub fn run(options: &Options) -> Result<()> {
    let out = &options.out;
    if out.extension().is_none_or(|extension| extension != "ssp") {
        bail!("{}: the name of an SSP file must end in .ssp", out.display());
    }
    ensure!(!options.system.has_record(), "--record: an SSP file does not specify what to record: omit this option");
    let system = options.system.system()?;
    temporary::check_outputs([out.as_path()], system.inputs())?;
    let (system, _folder) = system::packed(&system)?;
    let name = ssp::system_name(out);
    let format = ssp::Options { version: options.ssp_version, only_connected: options.only_connected };
    let ssp = ssp::write(&system, &name, format)?;
    for remark in system.remarks.iter().chain(&ssp.remarks) {
        tell::remark(remark);
    }
    replacing(out, || temporary::place(out, |to| Ok(to.write_all(&ssp.bytes)?), |_| Ok(())))?;
    print(&format!(
        "{}: {} with {}, {}, {}\n",
        out.display(),
        counted(system.members.len(), "component", "components"),
        counted(ssp.connectors, "connector", "connectors"),
        counted(system.connections.len(), "connection", "connections"),
        counted(ssp.fmus, "FMU", "FMUs")
    ))
}
