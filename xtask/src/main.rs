//! `cargo xtask`: the repository's chores.

mod deep;
mod demo;
mod docs;
mod python;
mod release;
mod steps;
mod test;

use anyhow::Result;
use clap::{Parser, Subcommand};
use plcfmu::build::platform::Platform;
use plcfmu::build::workspace::Workspace;
use plcfmu::package::{dist, pack};
use plcfmu::tool::make;
use python::Environment;
use std::process::ExitCode;

/// The repository's chores: pack its FMUs, test them, run them in closed loops, write the site.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", after_help = HELP)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const HELP: &str = "\
Examples:
  cargo xtask demo                  co-simulate all closed loops, print their figures, plot them
  cargo xtask fmu                   pack all FMUs
  cargo xtask test                  check everything (takes some minutes the first time)
  cargo xtask test -- -k time       only the Python tests with 'time' in their name
  cargo xtask test --platforms      also test the libraries for Windows and ARM, under Wine and qemu

Results, below target/: fmu/NAME.fmu, demo/ (CSV, PNG, SVG), dist/, docs/, tool/, venv/ (the Python environment)
Needed: Rust, a C compiler, Python 3.9 or newer. 'cargo xtask fmu --native' needs no Python.";

#[derive(Subcommand)]
enum Command {
    /// Build, pack and check FMUs: target/fmu/NAME.fmu. Like 'plcfmu build', with the zig of tests/requirements.txt
    Fmu(pack::Options),
    /// Pack all FMUs for all platforms, the Python wheels and the command, with checksums and a table: target/dist/
    Dist(dist::Options),
    /// Build the parameter tool, a self-contained HTML file: target/tool/plcfmu-tool.html
    Tool(make::Options),
    /// Run all tests: Rust, Python, other importers
    Test(test::Options),
    /// Run closed loops of FMUs, print their figures, plot them: target/demo/
    Demo(demo::Options),
    /// Write the site, with the pages of all FMUs and the parameter tool: target/docs/index.html
    Docs(docs::Options),
    /// Check that a version can be released, then create its commit and tag; nothing is pushed
    Release(release::Options),
}

fn main() -> ExitCode {
    match dispatch(Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(command: Command) -> Result<()> {
    let workspace = Workspace::find()?;
    match command {
        Command::Fmu(options) => {
            // First, so that a wrong name is reported before the Python environment is created.
            pack::select(&workspace, &options)?;
            if !options.native && Platform::host(&workspace.root)?.is_linux() {
                Environment::ready(&workspace)?;
            }
            pack::run(&workspace, &options)
        }
        Command::Dist(options) => dist::run(&workspace, &options, Environment::ready(&workspace)?.python()),
        Command::Tool(options) => {
            if options.fmus.is_none() {
                Environment::ready(&workspace)?;
            }
            make::run(&workspace, &options)
        }
        Command::Test(options) => test::test(&workspace, &options),
        Command::Demo(options) => demo::demo(workspace, &options),
        Command::Docs(options) => docs::docs(&workspace, &options),
        Command::Release(options) => release::release(&workspace, &options),
    }
}
