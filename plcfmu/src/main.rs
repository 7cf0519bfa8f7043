//! The command `plcfmu`.

use clap::{CommandFactory, Parser, Subcommand};
use host::child::COMMAND;
use host::package::temporary;
#[cfg(feature = "mcp")]
use plcfmu::commands::mcp;
#[cfg(feature = "server")]
use plcfmu::commands::tool;
use plcfmu::commands::{
    build, check, child, figures, gains, info, manual, merge, new, params, preset, prove, run, show, ssp, study, test,
    tune_study,
};
use plcfmu::{exit, interruption, tell};
use std::process::ExitCode;

/// The help about commands that run FMU code.
const NATIVE_CODE: &str = "\
Native FMU code runs in a separate process: in run, check --run, study and tune-study; in tool, when a loop is started; and in mcp, \
when its client calls run. preset starts each preset once. If you name an FMU of your own block, params, preset and tool also load its \
library to read its table. No other command runs native FMU code.";

/// Makes FMUs from PLC blocks; inspects, checks and runs FMUs.
#[derive(Parser)]
#[command(name = "plcfmu", version, after_help = NATIVE_CODE)]
struct Arguments {
    #[command(flatten)]
    tell: tell::Options,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Info(info::Options),
    Check(check::Options),
    Test(test::Options),
    Run(run::Options),
    Show(show::Options),
    Ssp(ssp::Options),
    Study(study::Options),
    TuneStudy(tune_study::Options),
    Params(params::Options),
    Gains(gains::Options),
    #[command(hide = true)]
    Figures(figures::Options),
    Completions(manual::Completions),
    Manual(manual::Manual),
    /// Create a crate for your own block, or a program in SCL
    ///
    /// The crate builds as created: it includes the sources that it needs. With --scl, the command creates a PLC
    /// program and a test of its logic, which need no compiler.
    New(new::Options),
    /// Pack a PLC program in SCL, or the FMUs of the current crate or workspace
    ///
    /// `plcfmu build machine.scl --cycle 100ms` makes an FMU from a program, without a compiler, and runs no code from
    /// the current folder.
    ///
    /// Without sources, it builds, packs and checks the crate's FMUs with Cargo. This runs code from the crate: its
    /// build scripts and macros, and programs named in .cargo/config.toml and rust-toolchain.toml. Build only crates
    /// that you trust.
    ///
    /// Links Linux libraries against an old glibc if zig and cargo-zigbuild are found: in target/venv, in the active
    /// Python environment, on PATH, or in the environment of python3.
    Build(build::Options),
    Merge(merge::Options),
    Preset(preset::Options),
    Prove(prove::Options),
    #[cfg(feature = "mcp")]
    Mcp(mcp::Options),
    #[cfg(feature = "server")]
    Tool(tool::Options),
    /// Run foreign code for another plcfmu process
    #[command(name = COMMAND, hide = true)]
    Child(child::Options),
}

fn main() -> ExitCode {
    let Arguments { tell, command } = Arguments::parse();
    tell.apply();
    // The process that runs foreign code ends with its parent.
    if !matches!(command, Command::Child(_)) {
        if let Err(error) = interruption::guard() {
            tell::warning(&format!("Ctrl-C may leave temporary files: {error}"));
        }
        temporary::remove_forgotten();
    }
    let result = match command {
        Command::Info(options) => info::run(&options),
        Command::Check(options) => check::run(&options),
        Command::Test(options) => test::run(&options),
        Command::Run(options) => run::run(&options),
        Command::Show(options) => show::run(&options),
        Command::Ssp(options) => ssp::run(&options),
        Command::Study(options) => study::run(&options),
        Command::TuneStudy(options) => tune_study::run(&options),
        Command::Params(options) => params::run(&options),
        Command::Gains(options) => gains::run(&options),
        Command::Figures(options) => figures::run(&options),
        Command::Completions(options) => manual::completions(&options, Arguments::command()),
        Command::Manual(options) => manual::manual(&options, Arguments::command()),
        Command::New(options) => new::run(&options),
        Command::Build(options) => build::run(&options),
        Command::Merge(options) => merge::run(&options),
        Command::Preset(options) => preset::run(&options),
        Command::Prove(options) => prove::run(&options),
        #[cfg(feature = "mcp")]
        Command::Mcp(options) => mcp::run(&options),
        #[cfg(feature = "server")]
        Command::Tool(options) => tool::run(&options),
        Command::Child(options) => child::run(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell::error(&error);
            exit::code(&error)
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_arguments_of_all_commands_are_consistent() {
        super::Arguments::command().debug_assert();
    }
}
