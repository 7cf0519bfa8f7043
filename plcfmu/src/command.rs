//! Runs other programs.

use anyhow::{Error, Result, anyhow, bail};
use std::io::{self, ErrorKind};
use std::process::{Command, Stdio};

/// Prints a heading before the output of the programs that follow.
pub fn heading(part: &str) {
    println!("\n== {part}");
}

/// Runs a program with direct access to the terminal.
///
/// # Errors
/// It cannot be started, or ends with a status other than 0.
pub fn run(command: &mut Command) -> Result<()> {
    let status = command.status().map_err(|error| not_started(command, &error))?;
    if !status.success() {
        bail!("{} ended with {status}", shown(command));
    }
    Ok(())
}

/// Runs a program silently and returns its standard output.
///
/// # Errors
/// As for [`run()`]; the message includes the program's output.
pub fn output(command: &mut Command) -> Result<String> {
    let output = command.stdin(Stdio::null()).output().map_err(|error| not_started(command, &error))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        let said = format!("{text}{}", String::from_utf8_lossy(&output.stderr));
        bail!("{} ended with {}:\n{}", shown(command), output.status, said.trim());
    }
    Ok(text)
}

/// Why a program could not be started, and the remedy.
pub fn not_started(command: &Command, error: &io::Error) -> Error {
    let program = command.get_program().to_string_lossy();
    match error.kind() {
        ErrorKind::NotFound => anyhow!("{program} was not found: install it, or add its folder to PATH"),
        _ => anyhow!("{program} cannot be started: {error}"),
    }
}

/// The command line, as a user would type it.
pub fn shown(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
    words.join(" ")
}
