//! `plcfmu build`: packs the FMUs of the current workspace, or a PLC program in SCL.

use super::print;
use crate::build::compile::GLIBC;
use crate::build::template;
use crate::build::workspace::Workspace;
use crate::package::{self, pack};
use crate::program::{self, survey};
use crate::tell;
use anyhow::{Error, Result, bail, ensure};
use host::package::Package;
use host::package::binary::{Binary, version};
use std::path::{Path, PathBuf};

/// What to build, and how.
#[derive(clap::Args, Debug)]
#[group(skip)] // clap names a group after its type, and the type of the flattened options has the same name
pub struct Options {
    #[command(flatten)]
    pack: pack::Options,
    #[command(flatten)]
    program: package::program::Options,
    /// First replace the crate's copy of the plcfmu sources (its folder plcfmu) with this version's
    #[arg(long)]
    update: bool,
}

/// Packs a program if the first arguments name its sources, otherwise the FMUs of the current workspace.
pub fn run(options: &Options) -> Result<()> {
    let names = &options.pack.names;
    if names.iter().any(|name| program::is_part(Path::new(name))) {
        let files: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
        for file in &files {
            let told = || format!("{} is not a program source (.scl, .udt, .db, .s7dcl, .xml or .awl)", file.display());
            ensure!(program::is_part(file), program::instead(file).unwrap_or_else(told));
        }
        for (option, is_given) in [
            ("package", !options.pack.packages.is_empty()),
            ("platform", !options.pack.platforms.is_empty()),
            ("library", !options.pack.libraries.is_empty()),
            ("update", options.update),
        ] {
            ensure!(
                !is_given,
                "--{option} is for crates: a program is packed for all platforms; --native compiles it for this machine"
            );
        }
        let folder = options.pack.out.clone().unwrap_or_else(|| PathBuf::from("."));
        let manifest = options.program.manifest(&files)?;
        if let Some(table) = survey::table(&files, &manifest)? {
            tell::text(table.trim_end());
        }
        let (path, warnings) = package::program::pack(&manifest, options.pack.version, options.pack.native, &folder)?;
        for warning in warnings {
            tell::text(&warning);
        }
        if !options.pack.native {
            note_glibc(&path)?;
        }
        return print(&format!("{}\n", path.display()));
    }
    options.program.refuse()?;
    // A folder may have the same name as the package in it.
    let mut files = names.iter().map(Path::new).filter(|file| !file.is_dir());
    if let Some(told) = files.find_map(program::instead) {
        bail!(told);
    }
    // Package names contain no dots.
    if let Some(file) = names.iter().find(|name| name.contains('.')) {
        bail!("{file} is neither a program source (.scl, .udt, .db, .s7dcl, .xml, .awl) nor a workspace package");
    }
    let is_told = || names.iter().find_map(|name| program::instead(Path::new(name)));
    let workspace = Workspace::find().map_err(|error| is_told().map_or(error, Error::msg))?;
    if options.update {
        template::update(&workspace.root)?;
    }
    if let Some(path) = template::different_source(&workspace.root) {
        tell::note(&format!(
            "{path} differs from the version in plcfmu {}; 'plcfmu build --update' replaces the folder",
            env!("CARGO_PKG_VERSION")
        ));
    }
    pack::run(&workspace, &options.pack)
}

/// Notes which glibc a packed program needs if it is newer than [`GLIBC`].
fn note_glibc(path: &Path) -> Result<()> {
    let mut package = Package::open(path)?;
    for library in package.libraries.clone() {
        let needed = Binary::read(&package.library(&library)?)?.glibc;
        if let Some(glibc) = needed.filter(|needed| version(needed) > version(GLIBC)) {
            tell::note(&format!(
                "the FMU needs glibc {glibc} or newer: the program library was linked with this machine's C library; for \
                 {GLIBC}, run 'cargo xtask fmu' in a clone of plcfmu, and set PLCFMU_FMUS to its folder target/fmu"
            ));
        }
    }
    Ok(())
}
