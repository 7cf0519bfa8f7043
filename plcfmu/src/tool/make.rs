//! `plcfmu-tool.html`: the page with the engine in it, for `cargo xtask tool` and `cargo xtask dist`.

use crate::build::compile;
use crate::build::platform::{self, Platform};
use crate::build::workspace::{self, Workspace};
use crate::command::output;
use crate::package::pack;
use crate::tell;
use crate::tool::assets;
use crate::tool::page::{self, Content, Home};
use anyhow::{Context, Result, ensure};
use host::fmu::Fmu;
use host::package::temporary;
use modeldescription::Interface;
use modeldescription::Table;
use std::fmt;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The file name of the page.
pub const FILE: &str = "plcfmu-tool.html";

/// The package of the engine, which is compiled to WebAssembly.
const ENGINE: &str = "tool_wasm";

/// The platform of the page, which is not an FMI platform.
pub const WEB: Platform =
    Platform { folder: "the page", newer: "the page", target: "wasm32-unknown-unknown", suffix: ".wasm" };

/// The maximum size of the page in bytes, so that it fits into an e-mail.
const LARGEST: usize = 1_600_000;

/// Options for building the page.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// Folder of the FMUs that the page explains; by default, all FMUs are packed first
    #[arg(long, value_name = "DIR")]
    pub fmus: Option<PathBuf>,
    /// Folder for the file [default: target/tool]
    #[arg(short, long = "out", value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Rust's standard library for the page is missing and cannot be fetched or compiled.
#[derive(Clone, Copy, Debug)]
pub struct Missing;

impl fmt::Display for Missing {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "the page cannot be built here: Rust's standard library for {target} is missing, and rustup cannot fetch it; install it \
             with 'rustup target add {target}', on Debian with 'apt install --no-install-recommends rustc-web cargo-web \
             rust-web-src', on Fedora with 'dnf install rust-std-static-{target}', on macOS with rustup ('brew install rustup')",
            target = WEB.target
        )
    }
}

impl std::error::Error for Missing {}

/// The default path of the page.
pub fn place(workspace: &Workspace) -> PathBuf {
    workspace.target.join("tool").join(FILE)
}

/// The cargo that compiles the page's engine. If Rust's standard library for it is missing, rustup installs it, or the
/// returned cargo is a script in the repository that also compiles the library from its sources. Prints a line stating
/// which of the two.
///
/// # Errors
/// [`Missing`].
fn cargo(workspace: &Workspace) -> Result<Command> {
    let is_there = || {
        let folder =
            output(platform::rustc(&workspace.root).args(["--print", "target-libdir", "--target", WEB.target]));
        folder.is_ok_and(|folder| Path::new(folder.trim()).is_dir())
    };
    if is_there() || cfg!(windows) || std::env::var_os(workspace::CROSS_CARGO).is_some() {
        return Ok(workspace::cross_cargo());
    }
    let cross_cargo = workspace.root.join(".ci/cross-cargo");
    let ready = output(Command::new(&cross_cargo).args(["--ready", WEB.target]).current_dir(&workspace.root));
    ensure!(ready.is_ok(), Missing);
    if is_there() {
        tell::text(&format!("rustup has installed Rust's standard library for {}, for the page", WEB.target));
        return Ok(workspace::cargo());
    }
    tell::text(&format!("Rust's standard library for {}, for the page, is compiled from its sources", WEB.target));
    let mut cargo = Command::new(cross_cargo);
    workspace::forget_package(&mut cargo);
    Ok(cargo)
}

/// Builds the page.
///
/// # Errors
/// [`Missing`], before anything is built; the engine cannot be built, or an FMU is damaged.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    // First, because Rust's standard library for the page may be missing.
    let cargo = cargo(workspace)?;
    if options.fmus.is_none() {
        pack::run(workspace, &pack::Options::default())?;
    }
    let engine = engine(workspace, cargo)?;
    let tables = tables(&options.fmus.clone().unwrap_or_else(|| workspace.fmus()))?;
    let sources = page::read(&workspace.root.join("tool/web"))?;
    let assets = assets::json(&tables)?;
    let data: [(&str, &[u8]); 2] = [("assets", &assets), ("engine", &engine)];
    let page = page::assemble(&sources, &Content { home: Home::Page, data: &data })?;
    let path = options.out.as_ref().map_or_else(|| place(workspace), |folder| folder.join(FILE));
    if page.len() > LARGEST {
        tell::warning(&format!("{FILE} has {} bytes; at most {LARGEST} fit into an e-mail", page.len()));
    }
    temporary::place(&path, |file| Ok(file.write_all(page.as_bytes())?), |_| Ok(()))?;
    let kilobytes = |length: usize| length.div_ceil(1000);
    println!(
        "{}  {} kB, including {} kB for the engine",
        workspace.shown(&path),
        kilobytes(page.len()),
        kilobytes(engine.len())
    );
    Ok(())
}

/// Builds the engine and returns its WebAssembly.
fn engine(workspace: &Workspace, mut build: Command) -> Result<Vec<u8>> {
    build.args(["rustc", "--package", ENGINE, "--lib", "--crate-type", "cdylib", "--profile", "page"]);
    build.args(["--target", WEB.target, "--target-dir"]).arg(workspace.target.join("platforms/page"));
    build.current_dir(&workspace.root);
    build.env("CARGO_ENCODED_RUSTFLAGS", compile::flags(workspace, &WEB)).env_remove("RUSTFLAGS");
    let artifacts = compile::artifacts_for(&mut build, &WEB)?;
    let path = artifacts.iter().find_map(|artifact| compile::library(artifact, ENGINE, WEB.suffix));
    let path = path.with_context(|| format!("cargo did not build {ENGINE}"))?;
    fs::read(path).with_context(|| format!("{path} cannot be read"))
}

/// The tables of the FMUs in a folder, sorted by name.
fn tables(folder: &Path) -> Result<Vec<Table>> {
    let mut tables = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "fmu") {
            let interface = Fmu::open(&path)?.library.interface().and_then(|json| Ok(Interface::parse(&json)?));
            tables.push(interface.with_context(|| path.display().to_string())?.table);
        }
    }
    ensure!(!tables.is_empty(), "no FMU in {}: 'cargo xtask fmu' builds them", folder.display());
    tables.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(tables)
}
