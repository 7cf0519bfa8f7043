//! The packed FMUs in other people's importers, written in Rust: see `tests/`.

use std::path::{Path, PathBuf};

/// A packed FMU: in the folder that `PLCFMU_FMUS` names, or where `cargo xtask fmu` puts it.
///
/// # Panics
/// It is not there.
pub fn packed(name: &str) -> PathBuf {
    found(name, "PLCFMU_FMUS", "fmu", "cargo xtask fmu")
}

/// The same of FMI 3.0, with the types of the PLC: in the folder that `PLCFMU_FMI3` names, or where `cargo xtask fmu --fmi 3` puts it.
///
/// # Panics
/// It is not there.
pub fn packed_fmi3(name: &str) -> PathBuf {
    found(name, "PLCFMU_FMI3", "fmu3", "cargo xtask fmu --fmi 3")
}

fn found(name: &str, variable: &str, folder: &str, command: &str) -> PathBuf {
    let target = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../target"));
    let folder = std::env::var_os(variable).map_or_else(|| target.join(folder), PathBuf::from);
    let path = folder.join(format!("{name}.fmu"));
    assert!(path.is_file(), "{} is not there: make it with '{command}'", path.display());
    path
}

/// LMN_I of CONT_C in the first five calls after a restart with SP_INT = 1 in automatic mode: e = 2, TI = 20 s and
/// CYCLE = 1 s, so that the first trapezoid adds 0.05 and each one after it 0.1. As REALs, widened.
pub const INTEGRAL: [f32; 5] = [0.05, 0.15, 0.25, 0.35, 0.45];
