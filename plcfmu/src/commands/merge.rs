//! `plcfmu merge`: joins FMUs for single platforms into one for all of them.

use super::{print, replacing};
use crate::package::check;
use crate::package::merge::{self, Files};
use anyhow::{Context, Result, ensure};
use host::package::{Package, archive, temporary};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Join FMUs that were built from the same sources on different machines into one for all their platforms
///
/// Their model descriptions must be the same. None of their code is run.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// The FMUs
    #[arg(value_name = "FILE.fmu", required = true, num_args = 2..)]
    pub files: Vec<PathBuf>,
    /// The FMU to write; it may be one of the inputs
    #[arg(short, long = "out", value_name = "FILE.fmu")]
    pub out: PathBuf,
}

/// Merges FMUs.
///
/// # Errors
/// An FMU is faulty, or two do not match; an existing output file is then kept.
pub fn run(options: &Options) -> Result<()> {
    let mut packages = Vec::new();
    for file in &options.files {
        let files = read(file).with_context(|| file.display().to_string())?;
        packages.push((file.display().to_string(), files));
    }
    let joined = merge::join_all(packages)?;
    let bytes = archive::write(&joined)?;
    let check = |path: &Path| {
        let report = check::check(&mut Package::open(path)?);
        ensure!(report.errors.is_empty(), report.errors.join("; "));
        Ok(())
    };
    replacing(&options.out, || temporary::place(&options.out, |file| Ok(file.write_all(&bytes)?), check))?;
    let platforms: Vec<String> = merge::platforms(&joined).into_iter().collect();
    let size = bytes.len().div_ceil(1000);
    print(&format!("{}  {}  {size} kB\n", options.out.display(), platforms.join(" ")))
}

fn read(file: &Path) -> Result<Files> {
    merge::files(&mut Package::open(file)?)
}
