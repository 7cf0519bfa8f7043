//! Running other programs.

use std::io::ErrorKind;
use std::process::{Command, Stdio};

/// Runs a program that talks to the user itself.
///
/// # Errors
/// It is not there, or ends with another status than 0.
pub fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|error| not_started(command, &error))?;
    if status.success() { Ok(()) } else { Err(format!("{} ended with {status}", shown(command))) }
}

/// Runs a program silently and gives what it writes to standard output.
///
/// # Errors
/// As [`run`], with what the program wrote.
pub fn output(command: &mut Command) -> Result<String, String> {
    let output = command.stdin(Stdio::null()).output().map_err(|error| not_started(command, &error))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if !output.status.success() {
        let said = format!("{text}{}", String::from_utf8_lossy(&output.stderr));
        return Err(format!("{} ended with {}:\n{}", shown(command), output.status, said.trim()));
    }
    Ok(text)
}

fn not_started(command: &Command, error: &std::io::Error) -> String {
    let program = command.get_program().to_string_lossy();
    match error.kind() {
        ErrorKind::NotFound => format!("{program} is not there: install it, or put it on PATH"),
        _ => format!("{program} cannot be started: {error}"),
    }
}

/// The command line, as one would type it.
pub fn shown(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
    words.join(" ")
}
