//! The command `plcfmu`.

use clap::{Parser, Subcommand};
use plcfmu::commands::{check, info, run};
use std::process::ExitCode;

/// Makes FMUs of PLC blocks, looks into FMUs, checks and runs them.
#[derive(Parser)]
#[command(name = "plcfmu", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Info(info::Options),
    Check(check::Options),
    Run(run::Options),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Info(options) => info::run(&options),
        Command::Check(options) => check::run(&options),
        Command::Run(options) => run::run(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
