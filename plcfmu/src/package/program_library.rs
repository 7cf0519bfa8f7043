//! Finds the library that runs all programs in SCL or, in a clone, builds it. The current folder has no influence:
//! nothing in it is read or run.

use crate::build::compile::compile_once;
use crate::build::platform;
use crate::build::workspace::Workspace;
use anyhow::{Context, Result, bail, ensure};
use host::fmu::platforms;
use std::collections::BTreeMap;
use std::env::consts::{ARCH, OS};
use std::fs;
use std::path::{Path, PathBuf};

/// Embedded in this command by build.rs: if the command was compiled with optimization, as by `cargo install`, the
/// library for the command's platform; otherwise, the path of the clone from which the command was compiled. Neither if
/// the libraries are shipped next to the command, as in a release.
const OWN: (Option<&[u8]>, Option<&str>) = include!(concat!(env!("OUT_DIR"), "/program_library.rs"));

/// The environment variable that names a folder of FMUs and program libraries.
const FMUS: &str = "PLCFMU_FMUS";

/// The name of the folder with the program libraries in a folder of FMUs.
pub const FOLDER: &str = "programs";

/// The path of the library for a platform in a folder of FMUs.
pub fn place(folder: &Path, platform: &str) -> PathBuf {
    let suffix = platform::system(platform).map_or("", |(_, suffix)| suffix);
    folder.join(FOLDER).join(platform).join(format!("program{suffix}"))
}

/// The program libraries in a folder of FMUs, by platform.
pub fn all_in(folder: &Path) -> BTreeMap<&'static str, PathBuf> {
    let places = platform::folders().into_iter().map(|platform| (platform, place(folder, platform)));
    places.filter(|(_, library)| library.is_file()).collect()
}

/// Finds the program libraries, by platform, in the first of these places: the folder `programs` next to this command
/// or, in a Python environment, in `share/plcfmu`; the folder of packed FMUs named by the environment variable
/// PLCFMU_FMUS; this command, whose embedded library is written to `folder`; or the clone from which this command was
/// compiled, where the library is built once. The last two have a library for this machine only.
///
/// # Errors
/// No library is found, or it cannot be built; the error states the remedy.
pub fn find(folder: &Path) -> Result<BTreeMap<&'static str, PathBuf>> {
    let own = std::env::current_exe().unwrap_or_default();
    let beside = own.parent().map(Path::to_path_buf);
    let shared = beside.as_ref().map(|beside| beside.join("../share/plcfmu"));
    for folder in beside.into_iter().chain(shared).chain(std::env::var_os(FMUS).map(PathBuf::from)) {
        let libraries = all_in(&folder);
        if !libraries.is_empty() {
            return Ok(libraries);
        }
    }
    let (platform, library) = match OWN {
        (Some(bytes), _) => {
            let platform = *platforms(OS, ARCH).first().context("FMI has no platform for this machine")?;
            let library = place(folder, platform);
            fs::create_dir_all(library.parent().unwrap_or(folder))
                .and_then(|()| fs::write(&library, bytes))
                .with_context(|| format!("{} cannot be written", library.display()))?;
            (platform, library)
        }
        (None, Some(clone)) => built(Path::new(clone)).context("the program library cannot be built")?,
        (None, None) => bail!(
            "the program library is missing: it belongs in the folder programs next to {}; unpack the whole archive, or \
             set {FMUS} to a folder of packed FMUs",
            own.display()
        ),
    };
    Ok(BTreeMap::from([(platform, library)]))
}

/// Builds the library in a clone, for this machine.
fn built(clone: &Path) -> Result<(&'static str, PathBuf)> {
    ensure!(
        clone.join("Cargo.toml").is_file(),
        "the sources from which this command was compiled, {}, no longer exist; compile it again, with 'cargo install --path \
         plcfmu' for a command that needs no sources",
        clone.display()
    );
    let workspace = Workspace::in_folder(clone)?;
    let package = workspace.programs.clone();
    let package = package.with_context(|| format!("{} has no program package", clone.display()))?;
    let (host, library) = compile_once(&workspace, &package)?;
    Ok((host.folder, library))
}
