//! Information from cargo about the workspace: its folders and FMU packages.

use anyhow::{Context, Result, anyhow};
use cargo_metadata::{CrateType, DependencyKind, Metadata, MetadataCommand, Package};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A cargo workspace of one or more packages.
#[derive(Debug)]
pub struct Workspace {
    /// Its root folder.
    pub root: PathBuf,
    /// The folder in which cargo builds.
    pub target: PathBuf,
    /// Its FMU packages, sorted by name.
    pub crates: Vec<FmuCrate>,
    /// The package of the program library, which runs all SCL programs; `None` outside a clone of plcfmu.
    pub programs: Option<FmuCrate>,
}

/// An FMU package: a `cdylib` that depends on `fmu`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FmuCrate {
    /// The name of the cargo package.
    pub name: String,
    /// The name of its library target.
    pub library: String,
    /// The package's licence, as an SPDX expression.
    pub license: Option<String>,
    /// Whether it is packed only if requested with `-p`: `test-only = true` under `[package.metadata.plcfmu]`.
    pub test_only: bool,
    /// Whether its FMU has no C source: `sources = false` under `[package.metadata.plcfmu]`.
    pub without_sources: bool,
    /// The folders that may contain the Rust source of its block: its own, and those of its path dependencies.
    pub folders: Vec<PathBuf>,
}

impl Workspace {
    /// The workspace of the current folder, as cargo reports it.
    ///
    /// # Errors
    /// Cargo's message if it cannot read the workspace.
    pub fn find() -> Result<Workspace> {
        Workspace::from(&mut MetadataCommand::new()).context("cargo cannot read the package in this folder")
    }

    /// The workspace in another folder. The current folder has no influence: cargo is started in `folder`, so that a
    /// toolchain, a configuration or a package in the current folder is neither read nor run.
    ///
    /// # Errors
    /// As for [`Workspace::find`].
    pub fn in_folder(folder: &Path) -> Result<Workspace> {
        let found = Workspace::from(MetadataCommand::new().current_dir(folder));
        found.with_context(|| format!("cargo cannot read the package in {}", folder.display()))
    }

    fn from(command: &mut MetadataCommand) -> Result<Workspace> {
        let metadata = command.no_deps().exec().map_err(|error| match error {
            cargo_metadata::Error::CargoMetadata { stderr } => {
                anyhow!("{}", stderr.trim().trim_start_matches("error: "))
            }
            cargo_metadata::Error::Io(error) if error.kind() == ErrorKind::NotFound => {
                anyhow!("cargo was not found: to build FMUs from crates, install Rust (https://rustup.rs)")
            }
            error => anyhow!(error),
        });
        Ok(Workspace::from_metadata(&metadata?))
    }

    fn from_metadata(metadata: &Metadata) -> Workspace {
        let is_of_programs = |package: &&Package| package.metadata["plcfmu"]["programs"] == true;
        let (programs, blocks): (Vec<_>, Vec<_>) = metadata.packages.iter().partition(is_of_programs);
        let mut crates: Vec<FmuCrate> = blocks.into_iter().filter_map(fmu_crate).collect();
        for fmu_crate in &mut crates {
            fmu_crate.folders = folders(metadata, &fmu_crate.name);
        }
        crates.sort_by(|a, b| a.name.cmp(&b.name));
        Workspace {
            root: metadata.workspace_root.clone().into(),
            target: metadata.target_directory.clone().into(),
            crates,
            programs: programs.into_iter().find_map(fmu_crate),
        }
    }

    /// The folder of the packed FMUs.
    pub fn fmus(&self) -> PathBuf {
        self.target.join("fmu")
    }

    /// A path for messages: relative to the current folder if it is inside.
    pub fn shown(&self, path: &Path) -> String {
        let here = std::env::current_dir().unwrap_or_else(|_| self.root.clone());
        path.strip_prefix(here).unwrap_or(path).display().to_string()
    }
}

fn fmu_crate(package: &Package) -> Option<FmuCrate> {
    let library = package.targets.iter().find(|target| target.crate_types.contains(&CrateType::CDyLib))?;
    package.dependencies.iter().find(|needed| needed.name == "fmu" && needed.kind == DependencyKind::Normal)?;
    Some(FmuCrate {
        name: package.name.to_string(),
        library: library.name.clone(),
        license: package.license.clone(),
        test_only: package.metadata["plcfmu"]["test-only"] == true,
        without_sources: package.metadata["plcfmu"]["sources"] == false,
        folders: Vec::new(),
    })
}

/// The source folders of a package and of its path dependencies, except for `blocks` and `fmu`, which all FMUs share.
fn folders(metadata: &Metadata, name: &str) -> Vec<PathBuf> {
    let Some(package) = metadata.packages.iter().find(|package| package.name == name) else { return Vec::new() };
    let root = package.manifest_path.parent().map(|folder| folder.as_std_path().to_path_buf());
    let is_own = |needed: &&cargo_metadata::Dependency| {
        needed.kind == DependencyKind::Normal && !["blocks", "fmu"].contains(&needed.name.as_str())
    };
    let needed = package.dependencies.iter().filter(is_own).filter_map(|needed| needed.path.as_ref());
    let all = root.into_iter().chain(needed.map(|path| path.as_std_path().to_path_buf()));
    all.map(|folder| folder.join("src")).filter(|folder| folder.is_dir()).collect()
}

/// The cargo that runs this program, or the one on PATH.
pub fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    forget_package(&mut cargo);
    cargo
}

/// The environment variable that names the cargo for platforms other than this machine's. It may be a script that
/// selects another compiler; the libraries for this machine are unaffected.
pub const CROSS_CARGO: &str = "PLCFMU_CROSS_CARGO";

/// The cargo for platforms other than this machine's: from the environment variable [`CROSS_CARGO`], or the usual one.
pub fn cross_cargo() -> Command {
    let Some(program) = std::env::var_os(CROSS_CARGO).filter(|cargo| !cargo.is_empty()) else { return cargo() };
    let mut cargo = Command::new(program);
    forget_package(&mut cargo);
    cargo
}

/// Removes from a command's environment the package variables, which `cargo run` and `cargo test` set for the program
/// that they start. Otherwise, build scripts that watch these variables would rerun each time.
pub fn forget_package(command: &mut Command) {
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy();
        if name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_") {
            command.env_remove(&*name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// A package as cargo describes it.
    fn package(name: &str, library: &str, crate_types: &[&str], kind: Value, rest: Value) -> Value {
        let mut package = json!({
            "name": name, "version": "0.1.0", "id": name, "features": {}, "manifest_path": format!("/w/{name}/Cargo.toml"),
            "targets": [{"name": library, "kind": crate_types, "crate_types": crate_types, "src_path": "/w/lib.rs"}],
            "dependencies": [{"name": "fmu", "req": "*", "kind": kind, "optional": false, "uses_default_features": true,
                              "features": []}],
        });
        for (key, value) in rest.as_object().unwrap() {
            package[key] = value.clone();
        }
        package
    }

    #[test]
    fn an_fmu_crate_is_a_cdylib_that_depends_on_fmu() {
        let metadata = json!({
            "version": 1, "workspace_root": "/w", "target_directory": "/w/target", "workspace_members": [],
            "packages": [
                package("pump", "pump_library", &["cdylib"], Value::Null, json!({"license": "MIT"})),
                package("boom", "boom", &["rlib", "cdylib"], Value::Null,
                        json!({"metadata": {"plcfmu": {"test-only": true}}})),
                package("other", "other", &["cdylib"], json!("dev"), json!({})),
                package("plain", "plain", &["lib"], Value::Null, json!({})),
            ],
        });
        let workspace = Workspace::from_metadata(&serde_json::from_value(metadata).unwrap());
        let fmu_crate = |package: &str, library: &str, license: Option<&str>, test_only| FmuCrate {
            name: package.into(),
            library: library.into(),
            license: license.map(str::to_string),
            test_only,
            ..FmuCrate::default()
        };
        assert_eq!(
            workspace.crates,
            [fmu_crate("boom", "boom", None, true), fmu_crate("pump", "pump_library", Some("MIT"), false)]
        );
        assert_eq!(workspace.fmus(), Path::new("/w/target/fmu"));
    }
}
