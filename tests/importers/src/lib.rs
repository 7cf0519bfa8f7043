//! The packed FMUs in other people's importers, written in Rust: see `tests/`.

use std::path::PathBuf;

/// A packed FMU: in the folder that `PLCFMU_FMUS` names, or where `cargo xtask fmu` puts it.
///
/// # Panics
/// It is not there.
pub fn packed(name: &str) -> PathBuf {
    let built = concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/fmu");
    let folder = PathBuf::from(std::env::var_os("PLCFMU_FMUS").unwrap_or_else(|| built.into()));
    let path = folder.join(format!("{name}.fmu"));
    assert!(path.is_file(), "{} is not there: make it with 'cargo xtask fmu'", path.display());
    path
}

/// LMN_I of CONT_C in the first five calls after a restart with SP_INT = 1 in automatic mode: e = 2, TI = 20 s and
/// CYCLE = 1 s, so that the first trapezoid adds 0.05 and each one after it 0.1. As REALs, widened.
pub const INTEGRAL: [f32; 5] = [0.05, 0.15, 0.25, 0.35, 0.45];
