//! `plcfmu`: makes, checks, shows and runs FMUs.

use clap::{Parser, Subcommand};
use plcfmu::commands::{check, info};
use std::process::ExitCode;

/// FMUs of PLC control blocks, and of anybody else: look into them, check them.
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
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Info(options) => info::run(&options),
        Command::Check(options) => check::run(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
