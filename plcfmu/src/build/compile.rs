//! Builds the libraries of FMUs, with one cargo call per platform.

use crate::build::platform::{self, Platform};
use crate::build::universal;
use crate::build::workspace::{self, FmuCrate, Workspace};
use crate::build::zig::{self, Zig};
use crate::command::{not_started, output, shown};
use crate::progress::Progress;
use crate::tell;
use anyhow::{Context, Result, anyhow, bail};
use cargo_metadata::camino::Utf8PathBuf;
use cargo_metadata::{Artifact, CrateType, Message};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

/// The newest glibc that a portable library may need, available on every Linux since 2014.
pub const GLIBC: &str = "2.17";

/// The oldest macOS on which macOS libraries run: the first version that supports Apple's own processors.
const MACOS: &str = "11.0";

/// How libraries are linked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Linkage {
    /// By zig: for Linux, against glibc [`GLIBC`], so that they also run on other Linux systems; for macOS, on a build
    /// machine with any system.
    Portable(Zig),
    /// By the linker that rustc calls: for this machine, against its C library; for Windows from another system, mingw.
    Native,
}

impl Linkage {
    /// The linkage for this machine: portable on Linux if zig is found, unless `native` is requested.
    pub fn choose(workspace: &Workspace, host: &Platform, native: bool) -> Linkage {
        // On other systems, the version of the C library does not matter.
        let zig = (host.is_linux() && !native).then(|| Zig::find(workspace)).flatten();
        zig.map_or(Linkage::Native, Linkage::Portable)
    }

    /// The linkage for a platform other than `host`, this machine.
    ///
    /// # Errors
    /// The linker is missing; the error states how to install it.
    pub fn cross(workspace: &Workspace, host: &Platform, platform: &Platform) -> Result<Linkage> {
        if platform.is_windows() && !host.is_windows() {
            let prefix = if platform.architecture() == "i686" { "i686" } else { "x86_64" };
            let linker = format!("{prefix}-w64-mingw32-gcc");
            let variable = platform.target.to_uppercase().replace('-', "_");
            if std::env::var_os(format!("CARGO_TARGET_{variable}_LINKER")).is_none() && !zig::is_on_path(&linker) {
                bail!(
                    "{} cannot be built here: {linker} was not found; install it (Debian, Ubuntu: 'apt install \
                     gcc-mingw-w64-{}')",
                    platform.folder,
                    prefix.replace('_', "-")
                );
            }
            return Ok(Linkage::Native);
        }
        if platform.is_windows() || platform.is_macos() && host.is_macos() {
            return Ok(Linkage::Native);
        }
        let zig = Zig::find(workspace).with_context(|| {
            format!(
                "{} cannot be built here: zig and cargo-zigbuild were not found; install them (pip install ziglang \
                 cargo-zigbuild)",
                platform.folder
            )
        })?;
        Ok(Linkage::Portable(zig))
    }
}

/// Builds the release libraries of `crates` for one FMI platform and returns their paths, by package. Libraries for
/// several processors (macOS) are joined into one file.
///
/// # Errors
/// Cargo fails; it has printed the reason.
pub fn compile_joined(
    workspace: &Workspace,
    crates: &[FmuCrate],
    targets: &[(Platform, Linkage)],
) -> Result<BTreeMap<String, PathBuf>> {
    let mut parts = Vec::new();
    for (platform, linkage) in targets {
        parts.push(compile(workspace, crates, platform, linkage)?);
    }
    let [(platform, _), _, ..] = targets else { return parts.pop().context("no target specified") };
    let folder = workspace.target.join("platforms").join(platform.folder).join("joined");
    fs::create_dir_all(&folder).with_context(|| format!("{} cannot be created", folder.display()))?;
    let join = |fmu_crate: &FmuCrate| {
        let mut files = Vec::new();
        for part in parts.iter().filter_map(|part| part.get(&fmu_crate.name)) {
            files.push(fs::read(part).with_context(|| format!("{} cannot be read", part.display()))?);
        }
        let path = folder.join(format!("{}{}", fmu_crate.library, platform.suffix));
        let joined = universal::join(&files).with_context(|| format!("package {}", fmu_crate.name))?;
        fs::write(&path, joined).with_context(|| format!("{} cannot be written", path.display()))?;
        Ok((fmu_crate.name.clone(), path))
    };
    crates.iter().map(join).collect()
}

/// Builds the release libraries of `crates` for one processor and returns their paths, by package.
///
/// # Errors
/// Cargo fails; it has printed the reason.
pub fn compile(
    workspace: &Workspace,
    crates: &[FmuCrate],
    platform: &Platform,
    linkage: &Linkage,
) -> Result<BTreeMap<String, PathBuf>> {
    built(cargo_build(workspace, platform, linkage)?, crates, platform)
}

/// Like [`compile`], for one crate that rarely changes, for this machine: on Linux portable if zig is found. Prints
/// nothing if the crate is already built, otherwise cargo's output, including the wait for another cargo.
///
/// # Errors
/// As for [`compile`].
pub fn compile_once(workspace: &Workspace, fmu_crate: &FmuCrate) -> Result<(Platform, PathBuf)> {
    let host = Platform::host(&workspace.root)?;
    let linkage = Linkage::choose(workspace, &host, false);
    let mut build = cargo_build(workspace, &host, &linkage)?;
    build.stderr(Stdio::piped());
    if tell::is_quiet() {
        build.arg("--quiet");
    }
    let libraries = built(build, std::slice::from_ref(fmu_crate), &host)?;
    Ok((host, libraries.into_values().next().context("cargo did not build a library")?))
}

/// Forwards cargo's output to standard error except for the line "Finished", the only one if nothing had to be built.
fn pass_on(said: impl Read) {
    let lines = BufReader::new(said).lines().map_while(Result::ok);
    lines.filter(|line| !line.trim_start().starts_with("Finished ")).for_each(|line| tell::raw(&format!("{line}\n")));
}

/// Runs a cargo build command for `crates`, and returns the paths of their libraries, by package.
fn built(mut build: Command, crates: &[FmuCrate], platform: &Platform) -> Result<BTreeMap<String, PathBuf>> {
    for fmu_crate in crates {
        build.args(["--package", &fmu_crate.name]);
    }
    let artifacts = artifacts_for(&mut build, platform)?;
    let library = |fmu_crate: &FmuCrate| {
        let path = artifacts.iter().find_map(|artifact| library(artifact, &fmu_crate.library, platform.suffix));
        let path = path.with_context(|| format!("cargo did not build a library for package {}", fmu_crate.name))?;
        Ok((fmu_crate.name.clone(), path.into()))
    };
    crates.iter().map(library).collect()
}

/// The cargo command that builds for a platform with the profile `library`; the caller adds the packages.
///
/// # Errors
/// rustc cannot report this machine's platform.
pub fn cargo_build(workspace: &Workspace, platform: &Platform, linkage: &Linkage) -> Result<Command> {
    let is_host = Platform::host(&workspace.root)?.target == platform.target;
    let cargo = if is_host { workspace::cargo() } else { workspace::cross_cargo() };
    let folder = target_folder(workspace, platform, linkage)?;
    let mut target = platform.target.to_string();
    let mut build = match linkage {
        Linkage::Portable(zig) => {
            if platform.is_linux() {
                target = format!("{target}.{GLIBC}");
            }
            zig.build(&cargo, &workspace.target.join("portable/zig"))
        }
        Linkage::Native => {
            let mut build = cargo;
            build.arg("build");
            build
        }
    };
    build.current_dir(&workspace.root).args(["--profile", "library", "--target", &target, "--target-dir"]).arg(folder);
    // In a workspace without this profile, libraries are built like releases.
    build.env("CARGO_PROFILE_LIBRARY_INHERITS", "release");
    build.env("CARGO_ENCODED_RUSTFLAGS", flags(workspace, platform)).env_remove("RUSTFLAGS");
    if platform.is_macos() {
        // The linker strips (see `platform_flags`): stripping by another program would invalidate the signature.
        build.env("MACOSX_DEPLOYMENT_TARGET", MACOS).env("CARGO_PROFILE_LIBRARY_STRIP", "none");
    }
    Ok(build)
}

/// Where cargo builds. Each linkage has a separate folder, because cargo does not rebuild what another linker has
/// linked.
fn target_folder(workspace: &Workspace, platform: &Platform, linkage: &Linkage) -> Result<PathBuf> {
    let is_host = Platform::host(&workspace.root)?.target == platform.target;
    Ok(match linkage {
        _ if !is_host => workspace.target.join("platforms").join(platform.folder),
        Linkage::Portable(_) => workspace.target.join("portable"),
        Linkage::Native => workspace.target.join("native"),
    })
}

/// The flags that keep this machine's paths out of the libraries, and those for the platform's linker, as the value of
/// `CARGO_ENCODED_RUSTFLAGS`.
pub fn flags(workspace: &Workspace, platform: &Platform) -> String {
    let home = std::env::home_dir().unwrap_or_default();
    let cargo_home = std::env::var_os("CARGO_HOME").map_or(home.join(".cargo"), PathBuf::from);
    let paths = [(cargo_home, "/cargo"), (workspace.root.clone(), "/plcfmu")];
    let mut flags = paths.map(|(path, name)| format!("--remap-path-prefix={}={name}", path.display())).to_vec();
    flags.extend(platform_flags(platform).iter().map(ToString::to_string));
    flags.join("\x1f")
}

fn platform_flags(platform: &Platform) -> &'static [&'static str] {
    if platform.target.ends_with("-windows-gnu") {
        // Without the link time, the same sources yield the same bytes.
        &["-Clink-arg=-Wl,--no-insert-timestamp"]
    } else if platform.target.ends_with("-windows-msvc") {
        // With a static C runtime: not every Windows system has VCRUNTIME140.dll.
        &["-Ctarget-feature=+crt-static", "-Clink-arg=/Brepro"]
    } else if platform.is_macos() {
        // With rpath, the library's install name does not contain a path of this machine.
        &["-Crpath=yes", "-Clink-arg=-Wl,-x", "-Clink-arg=-Wl,-S"]
    } else {
        &[]
    }
}

/// Like [`artifacts`], but if Rust's standard library for the platform is missing, the error states how to install it.
///
/// # Errors
/// As for [`artifacts`].
pub fn artifacts_for(build: &mut Command, platform: &Platform) -> Result<Vec<Artifact>> {
    let root = build.get_current_dir().unwrap_or(Path::new("."));
    let folder = output(platform::rustc(root).args(["--print", "target-libdir", "--target", platform.target]));
    if folder.is_ok_and(|folder| PathBuf::from(folder.trim()).is_dir()) {
        return artifacts(build);
    }
    // Cargo may be configured to build the standard library itself. If not, it prints many errors, which are replaced
    // by one.
    let _progress = Progress::spinner(&format!("building for {} ({})", platform.folder, platform.target));
    let mut log = tempfile::tempfile().context("cannot create a temporary file for cargo's messages")?;
    let standard_error = log.try_clone().context("cannot create a temporary file for cargo's messages")?;
    artifacts(build.stderr(standard_error)).map_err(|error| match read(&mut log) {
        Ok(messages) if messages.contains(NO_STANDARD_LIBRARY) => anyhow!(
            "{} cannot be built here: Rust's standard library for {target} is missing; install it with 'rustup target \
             add {target}'",
            platform.folder,
            target = platform.target
        ),
        messages => {
            tell::raw(&messages.unwrap_or_default());
            error
        }
    })
}

/// rustc's error code for a missing crate.
const NO_STANDARD_LIBRARY: &str = "E0463";

fn read(log: &mut File) -> Result<String> {
    let mut text = String::new();
    log.rewind()?;
    log.read_to_string(&mut text)?;
    Ok(text)
}

/// Runs a cargo build command and returns its artifacts. If its standard error is piped, the output is forwarded to
/// this program's standard error.
///
/// # Errors
/// Cargo cannot be started or fails.
pub fn artifacts(build: &mut Command) -> Result<Vec<Artifact>> {
    build.arg("--message-format=json-render-diagnostics").stdout(Stdio::piped());
    let mut child = build.spawn().map_err(|error| not_started(build, &error))?;
    let said = child.stderr.take().map(|said| thread::spawn(|| pass_on(said)));
    let mut artifacts = Vec::new();
    if let Some(messages) = child.stdout.take() {
        for message in Message::parse_stream(BufReader::new(messages)) {
            if let Message::CompilerArtifact(artifact) = message.with_context(|| shown(build))? {
                artifacts.push(artifact);
            }
        }
    }
    let status = child.wait().with_context(|| shown(build))?;
    if let Some(said) = said {
        let _ = said.join();
    }
    if !status.success() {
        bail!("{} ended with {status}", shown(build));
    }
    Ok(artifacts)
}

/// The library file of an artifact, if it is the `cdylib` with this name.
pub fn library<'a>(artifact: &'a Artifact, name: &str, suffix: &str) -> Option<&'a Utf8PathBuf> {
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
