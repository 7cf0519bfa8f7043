//! What cargo knows of the workspace: where things are, and which of its packages are FMUs.

use crate::command::output;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The workspace that `cargo xtask` is called in.
#[derive(Debug)]
pub struct Workspace {
    /// Its folder.
    pub root: PathBuf,
    /// Where cargo builds, and everything that `cargo xtask` makes lies.
    pub target: PathBuf,
    /// Its FMU packages, by name.
    pub crates: Vec<FmuCrate>,
}

/// A package that is an FMU: a `cdylib` that depends on `fmu`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FmuCrate {
    /// The name of the cargo package.
    pub name: String,
    /// The name of its library target.
    pub library: String,
    /// The package's licence, as SPDX writes it.
    pub license: Option<String>,
    /// Only packed when asked for with `-p`.
    pub test_only: bool,
}

impl Workspace {
    /// Asks cargo.
    ///
    /// # Errors
    /// What cargo says, if it cannot read the workspace.
    pub fn find() -> Result<Workspace, String> {
        let mut metadata = cargo();
        metadata.args(["metadata", "--format-version", "1", "--no-deps"]);
        Workspace::parse(&output(&mut metadata)?)
    }

    fn parse(metadata: &str) -> Result<Workspace, String> {
        let metadata: Value =
            serde_json::from_str(metadata).map_err(|error| format!("cargo metadata is no JSON: {error}"))?;
        let folder = |key: &str| {
            metadata[key].as_str().map(PathBuf::from).ok_or_else(|| format!("cargo metadata does not name the {key}"))
        };
        let mut crates: Vec<FmuCrate> = list(&metadata["packages"]).iter().filter_map(fmu_crate).collect();
        crates.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(Workspace { root: folder("workspace_root")?, target: folder("target_directory")?, crates })
    }

    /// The folder of the packed FMUs.
    pub fn fmus(&self) -> PathBuf {
        self.target.join("fmu")
    }

    /// A path as the user would write it: from the folder he stands in, where it lies in there.
    pub fn shown(&self, path: &Path) -> String {
        let here = std::env::current_dir().unwrap_or_else(|_| self.root.clone());
        path.strip_prefix(here).unwrap_or(path).display().to_string()
    }
}

fn fmu_crate(package: &Value) -> Option<FmuCrate> {
    let is_library = |target: &&Value| list(&target["crate_types"]).iter().any(|kind| kind == "cdylib");
    let library = list(&package["targets"]).iter().find(is_library)?;
    let is_fmu = |dependency: &Value| dependency["name"] == "fmu" && dependency["kind"].is_null();
    if !list(&package["dependencies"]).iter().any(is_fmu) {
        return None;
    }
    Some(FmuCrate {
        name: package["name"].as_str()?.to_string(),
        library: library["name"].as_str()?.to_string(),
        license: package["license"].as_str().map(str::to_string),
        test_only: package["metadata"]["plcfmu"]["test-only"] == true,
    })
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// The cargo that runs us, or the one on the path.
pub fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    forget_package(&mut cargo);
    cargo
}

/// Takes what cargo told us of our own package out of a command's environment: it is none of the packages' that the
/// command builds.
pub fn forget_package(command: &mut Command) {
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy();
        if name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_") {
            command.env_remove(&*name);
        }
    }
}

/// The processor and system that rustc builds for when it is not told, such as `x86_64-unknown-linux-gnu`.
///
/// # Errors
/// rustc cannot be run.
pub fn host() -> Result<String, String> {
    let version = output(Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into())).arg("-vV"))?;
    version
        .lines()
        .find_map(|line| line.strip_prefix("host: "))
        .map(str::to_string)
        .ok_or_else(|| format!("rustc -vV names no host: {version}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const METADATA: &str = r#"{
        "workspace_root": "/w", "target_directory": "/w/target",
        "packages": [
            {"name": "pump", "metadata": null, "license": "MIT",
             "targets": [{"name": "pump_library", "crate_types": ["cdylib"]}],
             "dependencies": [{"name": "fmu", "kind": null}]},
            {"name": "boom", "metadata": {"plcfmu": {"test-only": true}},
             "targets": [{"name": "boom", "crate_types": ["rlib", "cdylib"]}],
             "dependencies": [{"name": "fmu", "kind": null}]},
            {"name": "other_library", "metadata": null,
             "targets": [{"name": "other_library", "crate_types": ["cdylib"]}],
             "dependencies": [{"name": "fmu", "kind": "dev"}]},
            {"name": "plain", "metadata": null,
             "targets": [{"name": "plain", "crate_types": ["lib"]}],
             "dependencies": [{"name": "fmu", "kind": null}]}
        ]
    }"#;

    #[test]
    fn an_fmu_is_a_cdylib_that_depends_on_fmu() {
        let workspace = Workspace::parse(METADATA).unwrap();
        let fmu_crate = |package: &str, library: &str, license: Option<&str>, test_only| FmuCrate {
            name: package.into(),
            library: library.into(),
            license: license.map(str::to_string),
            test_only,
        };
        assert_eq!(
            workspace.crates,
            [fmu_crate("boom", "boom", None, true), fmu_crate("pump", "pump_library", Some("MIT"), false)]
        );
        assert_eq!(workspace.fmus(), Path::new("/w/target/fmu"));
    }

    #[test]
    fn metadata_without_a_target_folder_is_refused() {
        assert_eq!(
            Workspace::parse(r#"{"workspace_root": "/w"}"#).unwrap_err(),
            "cargo metadata does not name the target_directory"
        );
    }
}
