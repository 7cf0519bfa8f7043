//! Builds the libraries of FMUs, all in one cargo call.

use crate::build::python::Environment;
use crate::build::workspace::{self, FmuCrate, Workspace};
use crate::command::shown;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// The newest glibc that a portable library may need; every Linux since 2014 has it.
pub const GLIBC: &str = "2.17";

/// How libraries are linked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Linkage {
    /// On Linux against an old glibc, by zig, so that they run on other machines too.
    Portable,
    /// By this machine's linker against its C library.
    Native,
}

/// For what libraries are built.
#[derive(Clone, Debug)]
pub struct Platform {
    /// As Rust calls it, such as `x86_64-unknown-linux-gnu`.
    pub target: String,
    /// As FMI calls it: the folder below `binaries`, such as `linux64`.
    pub folder: &'static str,
    /// What a library's file name ends with.
    pub extension: &'static str,
    /// How libraries are linked.
    pub linkage: Linkage,
}

impl Platform {
    /// This machine.
    ///
    /// # Errors
    /// FMI 2.0 has no name for it.
    pub fn host(native: bool) -> Result<Platform, String> {
        Platform::of(&workspace::host()?, native)
    }

    fn of(target: &str, native: bool) -> Result<Platform, String> {
        let (folder, extension) = match target {
            "x86_64-unknown-linux-gnu" => ("linux64", "so"),
            "i686-unknown-linux-gnu" => ("linux32", "so"),
            "aarch64-unknown-linux-gnu" => ("aarch64-linux", "so"),
            "x86_64-apple-darwin" | "aarch64-apple-darwin" => ("darwin64", "dylib"),
            windows if windows.starts_with("x86_64-pc-windows-") => ("win64", "dll"),
            windows if windows.starts_with("i686-pc-windows-") => ("win32", "dll"),
            _ => {
                return Err(format!(
                    "FMUs are not made on this machine ({target}): it takes Linux with glibc, Windows or macOS"
                ));
            }
        };
        // Elsewhere the system's C library has one version for all.
        let linkage = if native || !target.contains("linux") { Linkage::Native } else { Linkage::Portable };
        Ok(Platform { target: target.into(), folder, extension, linkage })
    }

    /// The platform as the user reads it.
    pub fn shown(&self) -> String {
        match self.linkage {
            Linkage::Native if self.target.contains("linux") => format!("{} (this machine's glibc)", self.folder),
            _ => self.folder.to_string(),
        }
    }
}

/// Builds the release libraries of `crates` and says where they are, by package.
///
/// # Errors
/// Cargo does not build them; it has said why.
pub fn compile(
    workspace: &Workspace,
    crates: &[FmuCrate],
    platform: &Platform,
) -> Result<BTreeMap<String, PathBuf>, String> {
    let mut build = match platform.linkage {
        Linkage::Portable => {
            let mut zigbuild = Environment::ready(workspace)?.program("cargo-zigbuild");
            workspace::forget_package(&mut zigbuild);
            zigbuild.arg("zigbuild").arg("--target").arg(format!("{}.{GLIBC}", platform.target));
            zigbuild
        }
        Linkage::Native => {
            let mut build = workspace::cargo();
            build.arg("build").arg("--target").arg(&platform.target);
            build
        }
    };
    build.current_dir(&workspace.root).args(["--release", "--message-format=json-render-diagnostics"]);
    // Apart from everybody else's builds: cargo does not build again what another linker has linked.
    build.arg("--target-dir").arg(workspace.target.join(match platform.linkage {
        Linkage::Portable => "portable",
        Linkage::Native => "native",
    }));
    for fmu_crate in crates {
        build.args(["--package", &fmu_crate.name]);
    }
    build.env("CARGO_ENCODED_RUSTFLAGS", flags(workspace)).env_remove("RUSTFLAGS");
    // What zig builds for itself, the stubs of that glibc, lies there too.
    let zig = workspace.target.join("portable/zig");
    for variable in ["ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR", "CARGO_ZIGBUILD_CACHE_DIR"] {
        build.env(variable, &zig);
    }
    let libraries = run(&mut build)?;
    crates
        .iter()
        .map(|fmu_crate| {
            let library = libraries.get(&fmu_crate.library).cloned();
            let library = library.ok_or_else(|| format!("cargo has built no library of package {}", fmu_crate.name))?;
            Ok((fmu_crate.name.clone(), library))
        })
        .collect()
}

/// Flags that take this machine's paths out of the libraries.
fn flags(workspace: &Workspace) -> String {
    let home = std::env::home_dir().unwrap_or_default();
    let cargo_home = std::env::var_os("CARGO_HOME").map_or(home.join(".cargo"), PathBuf::from);
    [(cargo_home, "/cargo"), (workspace.root.clone(), "/plcfmu")]
        .map(|(path, name)| format!("--remap-path-prefix={}={name}", path.display()))
        .join("\x1f")
}

/// Runs cargo and collects the `cdylib`s it tells of, by the name of their target.
fn run(build: &mut Command) -> Result<BTreeMap<String, PathBuf>, String> {
    let line = shown(build);
    let failed = |what: &str| format!("{line}: {what}");
    let mut child = build.stdout(Stdio::piped()).spawn().map_err(|error| failed(&error.to_string()))?;
    let mut libraries = BTreeMap::new();
    if let Some(messages) = child.stdout.take() {
        for message in BufReader::new(messages).lines() {
            let message = message.map_err(|error| failed(&error.to_string()))?;
            libraries.extend(library(&message));
        }
    }
    let status = child.wait().map_err(|error| failed(&error.to_string()))?;
    if status.success() { Ok(libraries) } else { Err(failed(&format!("ended with {status}"))) }
}

/// The library that a message of cargo tells of.
fn library(message: &str) -> Option<(String, PathBuf)> {
    let message: Value = serde_json::from_str(message).ok()?;
    if message["reason"] != "compiler-artifact" {
        return None;
    }
    let target = &message["target"];
    if !target["crate_types"].as_array()?.iter().any(|kind| kind == "cdylib") {
        return None;
    }
    let is_library = |name: &&str| [".so", ".dll", ".dylib"].iter().any(|extension| name.ends_with(extension));
    let file = message["filenames"].as_array()?.iter().filter_map(Value::as_str).find(is_library)?;
    Some((target["name"].as_str()?.to_string(), file.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fmi_has_a_folder_for_each_platform() {
        let folder = |target| Platform::of(target, false).map(|platform| (platform.folder, platform.extension));
        assert_eq!(folder("x86_64-unknown-linux-gnu"), Ok(("linux64", "so")));
        assert_eq!(folder("aarch64-unknown-linux-gnu"), Ok(("aarch64-linux", "so")));
        assert_eq!(folder("x86_64-pc-windows-msvc"), Ok(("win64", "dll")));
        assert_eq!(folder("aarch64-apple-darwin"), Ok(("darwin64", "dylib")));
        assert!(folder("riscv64gc-unknown-linux-gnu").unwrap_err().contains("riscv64gc-unknown-linux-gnu"));
    }

    #[test]
    fn a_library_that_is_bound_to_this_machine_says_so() {
        let shown = |target, native| Platform::of(target, native).unwrap().shown();
        assert_eq!(shown("x86_64-unknown-linux-gnu", false), "linux64");
        assert_eq!(shown("x86_64-unknown-linux-gnu", true), "linux64 (this machine's glibc)");
        assert_eq!(shown("x86_64-pc-windows-msvc", true), "win64");
    }

    #[test]
    fn cargo_tells_where_a_library_is() {
        let message = r#"{"reason": "compiler-artifact", "target": {"name": "pump", "crate_types": ["cdylib"]},
            "filenames": ["/t/release/pump.dll.lib", "/t/release/pump.dll"]}"#;
        assert_eq!(library(message), Some(("pump".into(), "/t/release/pump.dll".into())));
        let rlib = message.replace("cdylib", "rlib");
        assert_eq!(library(&rlib), None);
        assert_eq!(library("warning: not JSON"), None);
    }
}
