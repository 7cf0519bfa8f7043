//! Builds the libraries of FMUs, all in one cargo call.

use crate::build::platform::Platform;
use crate::build::workspace::{self, FmuCrate, Workspace};
use crate::build::zig::Zig;
use crate::command::{not_started, shown};
use anyhow::{Context, Result, bail};
use cargo_metadata::camino::Utf8PathBuf;
use cargo_metadata::{Artifact, CrateType, Message};
use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// The newest glibc that a portable library may need; every Linux since 2014 has it.
pub const GLIBC: &str = "2.17";

/// How libraries are linked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Linkage {
    /// Against glibc [`GLIBC`], so that they run on other Linux systems too.
    Portable(Zig),
    /// By the host's linker against the host's C library.
    Native,
}

impl Linkage {
    /// Portable on Linux where zig is found, unless `native` is asked for.
    pub fn choose(workspace: &Workspace, platform: &Platform, native: bool) -> Linkage {
        // Elsewhere the system's C library has one version for all.
        let zig = (platform.is_linux() && !native).then(|| Zig::find(&workspace.target)).flatten();
        zig.map_or(Linkage::Native, Linkage::Portable)
    }
}

/// Builds the release libraries of `crates` and returns their paths, by package.
///
/// # Errors
/// Cargo does not build them; it has said why.
pub fn compile(
    workspace: &Workspace,
    crates: &[FmuCrate],
    platform: &Platform,
    linkage: &Linkage,
) -> Result<BTreeMap<String, PathBuf>> {
    let (mut build, target, folder) = match linkage {
        Linkage::Portable(zig) => {
            (zig.cargo(&workspace.target.join("portable/zig")), format!("{}.{GLIBC}", platform.target), "portable")
        }
        Linkage::Native => {
            let mut build = workspace::cargo();
            build.arg("build");
            (build, platform.target.to_string(), "native")
        }
    };
    build.current_dir(&workspace.root).args(["--release", "--target", &target]);
    // Each linkage has its own folder: cargo does not build again what another linker has linked.
    build.arg("--target-dir").arg(workspace.target.join(folder));
    for fmu_crate in crates {
        build.args(["--package", &fmu_crate.name]);
    }
    build.env("CARGO_ENCODED_RUSTFLAGS", flags(workspace)).env_remove("RUSTFLAGS");
    let artifacts = artifacts(&mut build)?;
    let library = |fmu_crate: &FmuCrate| {
        let path = artifacts.iter().find_map(|artifact| library(artifact, &fmu_crate.library, platform.suffix));
        let path = path.with_context(|| format!("cargo has not built a library of package {}", fmu_crate.name))?;
        Ok((fmu_crate.name.clone(), path.into()))
    };
    crates.iter().map(library).collect()
}

/// Flags that keep this machine's paths out of the libraries.
fn flags(workspace: &Workspace) -> String {
    let home = std::env::home_dir().unwrap_or_default();
    let cargo_home = std::env::var_os("CARGO_HOME").map_or(home.join(".cargo"), PathBuf::from);
    [(cargo_home, "/cargo"), (workspace.root.clone(), "/plcfmu")]
        .map(|(path, name)| format!("--remap-path-prefix={}={name}", path.display()))
        .join("\x1f")
}

/// Runs a cargo command that builds, and returns what it has built. Diagnostics go to standard error.
///
/// # Errors
/// Cargo cannot be started or fails.
pub fn artifacts(build: &mut Command) -> Result<Vec<Artifact>> {
    build.arg("--message-format=json-render-diagnostics").stdout(Stdio::piped());
    let mut child = build.spawn().map_err(|error| not_started(build, &error))?;
    let mut artifacts = Vec::new();
    if let Some(messages) = child.stdout.take() {
        for message in Message::parse_stream(BufReader::new(messages)) {
            if let Message::CompilerArtifact(artifact) = message.with_context(|| shown(build))? {
                artifacts.push(artifact);
            }
        }
    }
    let status = child.wait().with_context(|| shown(build))?;
    if !status.success() {
        bail!("{} ended with {status}", shown(build));
    }
    Ok(artifacts)
}

/// The library file of the artifact if it is the `cdylib` of this name.
fn library<'a>(artifact: &'a Artifact, name: &str, suffix: &str) -> Option<&'a Utf8PathBuf> {
    let is_library = artifact.target.name == name && artifact.target.crate_types.contains(&CrateType::CDyLib);
    artifact.filenames.iter().find(|file| is_library && file.as_str().ends_with(suffix))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_of_an_artifact_is_the_file_that_is_loaded() {
        let artifact = |crate_type: &str| -> Artifact {
            let json = format!(
                r#"{{"package_id": "pump", "manifest_path": "/w/Cargo.toml", "features": [], "fresh": false,
                "profile": {{"opt_level": "3", "debug_assertions": false, "overflow_checks": false, "test": false}},
                "target": {{"name": "pump", "kind": ["{crate_type}"], "crate_types": ["{crate_type}"], "src_path": "/w/lib.rs"}},
                "filenames": ["/t/release/pump.dll.lib", "/t/release/pump.dll"], "executable": null}}"#
            );
            serde_json::from_str(&json).unwrap()
        };
        let path = |name, artifact: &Artifact| library(artifact, name, ".dll").cloned();
        assert_eq!(path("pump", &artifact("cdylib")), Some("/t/release/pump.dll".into()));
        assert_eq!(path("valve", &artifact("cdylib")), None);
        assert_eq!(path("pump", &artifact("rlib")), None);
    }
}
