//! `plcfmu-tool.html`: the page with the engine in it, for `cargo xtask tool` and `cargo xtask dist`.

use crate::build::compile;
use crate::build::platform::Platform;
use crate::build::workspace::{self, Workspace};
use crate::package::pack;
use crate::tell;
use crate::tool::assets;
use crate::tool::page::{self, Content, Home};
use anyhow::{Context, Result, ensure};
use host::fmu::Fmu;
use host::package::temporary;
use modeldescription::Interface;
use modeldescription::Table;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The name of the file.
pub const FILE: &str = "plcfmu-tool.html";

/// The package that becomes WebAssembly.
const ENGINE: &str = "tool_wasm";

/// Where it runs: no platform of FMI.
pub const WEB: Platform = Platform { folder: "the page", target: "wasm32-unknown-unknown", suffix: ".wasm" };

/// The page is to fit into a mail: this many bytes.
const LARGEST: usize = 1_400_000;

/// What to make.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// Folder of the FMUs that the page explains; without it, all FMUs are packed first
    #[arg(long, value_name = "DIR")]
    pub fmus: Option<PathBuf>,
    /// Folder for the file [default: target/tool]
    #[arg(short, long = "out", value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Where the page is by default.
pub fn place(workspace: &Workspace) -> PathBuf {
    workspace.target.join("tool").join(FILE)
}

/// Makes the page.
///
/// # Errors
/// The engine cannot be built, or an FMU is damaged.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    if options.fmus.is_none() {
        pack::run(workspace, &pack::Options::default())?;
    }
    let engine = engine(workspace)?;
    let tables = tables(&options.fmus.clone().unwrap_or_else(|| workspace.fmus()))?;
    let sources = page::read(&workspace.root.join("tool/web"))?;
    let assets = assets::json(&tables)?;
    let data: [(&str, &[u8]); 2] = [("assets", &assets), ("engine", &engine)];
    let page = page::assemble(&sources, &Content { home: Home::Page, data: &data })?;
    let path = options.out.as_ref().map_or_else(|| place(workspace), |folder| folder.join(FILE));
    if page.len() > LARGEST {
        tell::warning(&format!("{FILE} has {} bytes: more than {LARGEST} do not fit into a mail", page.len()));
    }
    temporary::place(&path, |file| Ok(file.write_all(page.as_bytes())?), |_| Ok(()))?;
    let kilobytes = |length: usize| length.div_ceil(1000);
    println!(
        "{}  {} kB, with the engine of {} kB",
        workspace.shown(&path),
        kilobytes(page.len()),
        kilobytes(engine.len())
    );
    Ok(())
}

/// The engine as WebAssembly.
fn engine(workspace: &Workspace) -> Result<Vec<u8>> {
    let mut build = workspace::cross_cargo();
    build.args(["rustc", "--package", ENGINE, "--lib", "--crate-type", "cdylib", "--profile", "page"]);
    build.args(["--target", WEB.target, "--target-dir"]).arg(workspace.target.join("platforms/page"));
    build.current_dir(&workspace.root);
    build.env("CARGO_ENCODED_RUSTFLAGS", compile::flags(workspace, &WEB)).env_remove("RUSTFLAGS");
    let artifacts = compile::artifacts_for(&mut build, &WEB)?;
    let path = artifacts.iter().find_map(|artifact| compile::library(artifact, ENGINE, WEB.suffix));
    let path = path.with_context(|| format!("cargo has not built {ENGINE}"))?;
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
    ensure!(!tables.is_empty(), "there is no FMU in {}: 'cargo xtask fmu' makes them", folder.display());
    tables.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(tables)
}
