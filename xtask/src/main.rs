//! `cargo xtask`: the project's commands.

use clap::{Parser, Subcommand};
use plcfmu::build::workspace::Workspace;
use plcfmu::package::pack;
use std::process::ExitCode;
use xtask::{demo, test};

/// The project's commands: pack PLC control blocks as FMUs, test them, show them in closed loops.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", after_help = HELP)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const HELP: &str = "\
Examples:
  cargo xtask demo                  co-simulate all closed loops, print their figures, draw them
  cargo xtask demo cont_c_heater    only this one
  cargo xtask fmu                   pack all FMUs
  cargo xtask fmu CONT_C            only this one
  cargo xtask fmu -p my_block       the FMU of one's own package
  cargo xtask test                  check everything (the first time it takes some minutes)
  cargo xtask test -- -k time       all of it, but of the Python tests only those with 'time' in their name

Where things land, all below target/:
  fmu/NAME.fmu       the packed FMUs; documentation/index.html in each says what it does
  demo/              CSV and PNG files of the closed loops
  venv/              the Python environment (made when it is first needed; packages of tests/requirements.txt)
  portable/, native/ the FMUs' libraries as cargo builds them

Needed: Rust, a C compiler, Python 3.9 or newer. 'cargo xtask fmu --native' needs no Python.";

#[derive(Subcommand)]
enum Command {
    /// Build, pack and check FMUs: target/fmu/NAME.fmu
    ///
    /// Finds every package of the workspace that is an FMU (a cdylib that depends on fmu), builds the libraries, reads the
    /// block's table out of each, writes model description, documentation, picture and reference results, and packs it.
    /// An FMU gets its name only after it was opened again and its library has worked.
    Fmu(pack::Options),
    /// Run all tests: Rust, Python, other importers
    Test(test::Options),
    /// Run closed loops of FMUs, print their figures, draw them: target/demo/
    Demo(demo::Options),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match dispatch(arguments.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(command: Command) -> Result<(), String> {
    match command {
        Command::Fmu(options) => pack::run(&Workspace::find()?, &options),
        Command::Test(options) => test::test(&Workspace::find()?, &options),
        Command::Demo(options) => demo::demo(&Workspace::find()?, &options),
    }
}
