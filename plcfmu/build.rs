//! Generates the Rust files through which the command embeds other files. `sources.rs` and `web.rs` are lists of
//! (path, text): the sources of `blocks` and `fmu` for `plcfmu new`, and those of the parameter tool's page.
//! `program_library.rs` contains the library that runs all SCL programs, or the folder in which to build it.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs, io};

/// If this environment variable is `beside`, the command does not embed the program library: in a release, the
/// libraries for all platforms are next to the command.
const PROGRAMS: &str = "PLCFMU_PROGRAMS";

fn main() -> io::Result<()> {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default()).join("..").canonicalize()?;
    let mut files = Vec::new();
    for library in ["blocks", "fmu"] {
        let folder = root.join(library).join("src");
        println!("cargo::rerun-if-changed={}", folder.display());
        // Rust sources and the files that they include: the blocks' documentation and the C door.
        let is_source =
            |path: &Path| path.extension().is_some_and(|of| ["rs", "md", "c", "h"].iter().any(|wanted| of == *wanted));
        collect(&folder, &is_source, &mut files)?;
    }
    write("sources.rs", &root, files)?;
    let web = root.join("tool/web");
    let mut files = Vec::new();
    for folder in [web.clone(), web.join("src"), web.join("vendor")] {
        println!("cargo::rerun-if-changed={}", folder.display());
        for entry in fs::read_dir(folder)? {
            files.extend(Some(entry?.path()).filter(|path| path.is_file() && is_of_page(path)));
        }
    }
    write("web.rs", &web, files)?;
    let text = program_library(&root)?;
    fs::write(out().join("program_library.rs"), text)
}

/// The Rust expression in `program_library.rs`: the library's bytes, the root of the clone in which to build it, or
/// neither. The library is compiled here only for an optimized command, so that a command built by `cargo install`
/// needs neither the clone nor cargo. For a debug build, which is compiled often, that would take too long.
fn program_library(root: &Path) -> io::Result<String> {
    println!("cargo::rerun-if-env-changed={PROGRAMS}");
    if env::var_os(PROGRAMS).is_some_and(|place| place == "beside") {
        return Ok("(None, None)".into());
    }
    if env::var_os("PROFILE").is_some_and(|profile| profile == "debug") {
        return Ok(format!("(None, Some({:?}))", root.display().to_string()));
    }
    let variable = |name: &str| env::var(name).map_err(io::Error::other);
    let target = variable("TARGET")?;
    // A separate target folder, because the cargo that runs this build script has locked the usual one.
    let folder = out().join("program_library");
    let cargo_home =
        env::var_os("CARGO_HOME").map_or(env::home_dir().unwrap_or_default().join(".cargo"), PathBuf::from);
    let mut flags = format!("--remap-path-prefix={}=/cargo", cargo_home.display());
    let _ = write!(flags, "\x1f--remap-path-prefix={}=/plcfmu", root.display());
    if target.ends_with("-windows-msvc") {
        flags.push_str("\x1f-Ctarget-feature=+crt-static");
    }
    let mut cargo = Command::new(variable("CARGO")?);
    cargo
        .args(["build", "--profile", "library", "--package", "program_library", "--target", &target, "--target-dir"])
        .arg(&folder);
    cargo.current_dir(root).env("CARGO_ENCODED_RUSTFLAGS", flags).env_remove("RUSTFLAGS");
    // Clippy sets this variable to check crates without compiling them, but the library must be compiled.
    let output = cargo.env_remove("RUSTC_WORKSPACE_WRAPPER").output()?;
    if !output.status.success() {
        return Err(io::Error::other(format!(
            "the program library does not compile:\n{}",
            String::from_utf8_lossy(&output.stderr)
        )));
    }
    let built = folder.join(target).join("library");
    let prefix = if env::var_os("CARGO_CFG_WINDOWS").is_some() { "" } else { "lib" };
    let suffix = match env::var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("windows") => "dll",
        Ok("macos") => "dylib",
        _ => "so",
    };
    // The dependencies in Makefile syntax, where a blank in a path is escaped with a backslash.
    let made_of = fs::read_to_string(built.join(format!("{prefix}program_library.d")))?.replace("\\ ", "\0");
    for file in made_of.split_whitespace().skip(1) {
        println!("cargo::rerun-if-changed={}", file.replace('\0', " "));
    }
    println!("cargo::rerun-if-changed={}", root.join("Cargo.lock").display());
    let library = built.join(format!("{prefix}program_library.{suffix}"));
    Ok(format!("(Some(include_bytes!({:?})), None)", library.display().to_string()))
}

/// The folder for generated files.
fn out() -> PathBuf {
    PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default())
}

/// Whether a file is part of the parameter tool's page: a source, or the licence of a vendored script.
fn is_of_page(path: &Path) -> bool {
    path.extension().is_some_and(|extension| ["html", "css", "js"].iter().any(|of| extension == *of))
        || path.file_name().is_some_and(|name| name == "LICENSE")
}

/// Writes the list of `files` to the generated file `name`, with paths relative to `root`.
fn write(name: &str, root: &Path, mut files: Vec<PathBuf>) -> io::Result<()> {
    files.sort();
    let mut list = String::from("&[\n");
    for file in files {
        // Paths in a crate use `/` on every system.
        let path: Vec<_> = file.strip_prefix(root).unwrap_or(&file).iter().map(|part| part.to_string_lossy()).collect();
        let _ = writeln!(list, "    ({:?}, include_str!({:?})),", path.join("/"), file.display().to_string());
    }
    list.push_str("]\n");
    fs::write(out().join(name), list)
}

/// Adds the wanted files in a folder and its subfolders to `files`.
fn collect(folder: &Path, is_wanted: &dyn Fn(&Path) -> bool, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, is_wanted, files)?;
        } else if is_wanted(&path) {
            files.push(path);
        }
    }
    Ok(())
}
