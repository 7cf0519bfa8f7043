//! The commands of `plcfmu`, one module each: their options and output.

pub mod build;
pub mod check;
pub mod child;
pub mod figures;
pub mod gains;
pub mod info;
pub mod loops;
pub mod manual;
#[cfg(feature = "mcp")]
pub mod mcp;
pub mod merge;
pub mod new;
pub mod params;
pub mod preset;
pub mod prove;
pub mod run;
pub mod show;
pub mod ssp;
pub mod study;
pub mod system;
pub mod test;
#[cfg(feature = "server")]
pub mod tool;
pub mod tune_study;

use crate::exit::Unreadable;
use crate::interruption;
use crate::program::is_source;
use crate::tell::{self, plain};
use ::study::pool;
use anyhow::{Context, Error, Result, anyhow, ensure};
use host::library;
use host::package::binary::Binary;
use host::standard_output::is_closed;
use modeldescription::Description;
use std::io::{ErrorKind, Write, stdout};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The maximum length of a name printed from a foreign FMU, in characters.
const LONGEST_NAME: usize = 60;

/// Writes to standard output. A reader that stops early, such as `head`, is not an error.
fn print(text: &str) -> Result<()> {
    ensure_standard_output()?;
    match stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("standard output cannot be written"),
        _ => Ok(()),
    }
}

/// Fails if standard output is closed: all output would be lost.
fn ensure_standard_output() -> Result<()> {
    ensure!(!is_closed(), "standard output is closed: redirect it to a file, or to /dev/null");
    Ok(())
}

/// Writes a file named by the user, and prints a note if it replaces another, whose comments and manual changes are
/// lost.
fn replacing(file: &Path, write: impl FnOnce() -> Result<()>) -> Result<()> {
    let was_there = file.is_file();
    write()?;
    if was_there {
        tell::note(&format!("{} was replaced", file.display()));
    }
    Ok(())
}

/// Rejects an FMU or a program where a study is expected.
fn ensure_study(file: &Path) -> Result<()> {
    let shown = file.display();
    let is_fmu = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fmu"));
    ensure!(!is_fmu, "{shown} is an FMU: a study is a .toml that names a loop; 'plcfmu run {shown}' runs an FMU");
    ensure!(
        !is_source(file),
        "{shown} is a program: a study is a .toml that names a loop, which may contain a program"
    );
    Ok(())
}

/// Formats rows as lines, each column as wide as its widest cell.
fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    // A name may contain characters that a terminal interprets as commands.
    let rows: Vec<[String; N]> = rows.iter().map(|row| row.each_ref().map(|cell| plain(cell))).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default();
    let widths: [usize; N] = std::array::from_fn(width);
    let mut text = String::new();
    for row in rows {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}

/// Combines equal sentences about different names into one line: `TIC1, TIC2, TIC3 and 37 more: ...`. Keeps the order
/// of names and sentences.
fn told_once(told: impl IntoIterator<Item = (String, String)>) -> Vec<String> {
    const MOST: usize = 3;
    let mut sentences: Vec<(String, Vec<String>)> = Vec::new();
    for (name, sentence) in told {
        match sentences.iter_mut().find(|(other, _)| *other == sentence) {
            Some((_, names)) if names.contains(&name) => {}
            Some((_, names)) => names.push(name),
            None => sentences.push((sentence, vec![name])),
        }
    }
    let line = |(sentence, names): (String, Vec<String>)| {
        let more = names.len().saturating_sub(MOST);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("{}{more}: {sentence}", names[..names.len().min(MOST)].join(", "))
    };
    sentences.into_iter().map(line).collect()
}

/// The options of the workers that run a study.
#[derive(clap::Args, Clone, Debug)]
struct WorkerOptions {
    /// Number of worker processes [default: one for each core]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Time limit for one run, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0, value_parser = time_limit)]
    time_limit: f64,
    /// Call the libraries of all FMUs through FMI's C interface; by default, if plcfmu contains all blocks of the loop,
    /// built from the same sources, it runs these faster copies, with bit-identical results
    #[arg(long)]
    exact_door: bool,
}

impl WorkerOptions {
    fn pool(&self) -> Result<pool::Options> {
        let defaults = pool::Options::new()?;
        Ok(pool::Options {
            jobs: self.jobs.map_or(defaults.jobs, usize::from),
            limit: Duration::from_secs_f64(self.time_limit),
            exact_door: self.exact_door,
            interrupted: interruption::flag(),
            ..defaults
        })
    }
}

/// Parses a time limit, in seconds.
fn time_limit(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.1..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("expected a time from 0.1 s to 1000000 s".into()),
    }
}

/// Rejects folders where FMUs are expected.
fn refuse_folders(files: &[PathBuf]) -> Result<()> {
    let folder = files.iter().find(|file| file.is_dir());
    folder.map_or(Ok(()), |folder| {
        let sample = folder.join("*.fmu");
        let error = anyhow!("{} is a folder: specify FMUs, such as {}", folder.display(), sample.display());
        Err(Error::new(Unreadable(error)))
    })
}

/// The number of exported functions of the FMU's FMI version. A library may also export functions of other versions.
fn functions(binary: &Binary, description: &Description) -> String {
    let prefix = if description.is_fmi_3() { library::v3::PREFIX } else { library::PREFIX };
    let count = binary.functions.iter().filter(|name| name.starts_with(prefix)).count();
    format!("{count} FMI {} functions", description.fmi_version)
}

/// A string from a foreign FMU, safe to print: at most `longest` characters, on one line, without control characters.
fn shown(text: &str, longest: usize) -> String {
    let mut shown = String::new();
    for (place, character) in text.chars().enumerate() {
        match character {
            _ if place == longest => {
                shown.push('…');
                break;
            }
            '"' | '\'' => shown.push(character),
            // Unprintable characters as escape sequences, such as \n or \u{9b}.
            _ => shown.extend(character.escape_debug()),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_to_be_said_of_several_is_said_once() {
        let told = |count: usize| (1..=count).map(|n| (format!("P{n}"), "it is off".to_string()));
        let other = ("P9".to_string(), "it is on".to_string());
        assert_eq!(told_once(told(1).chain([other])), ["P1: it is off", "P9: it is on"]);
        assert_eq!(told_once(told(40)), ["P1, P2, P3 and 37 more: it is off"]);
        assert_eq!(told_once(told(2).chain(told(2))), ["P1, P2: it is off"]);
    }

    #[test]
    fn a_foreign_text_is_printed_on_one_line_without_control_characters() {
        assert_eq!(shown("block's \"gain\" in µm", 60), "block's \"gain\" in µm");
        assert_eq!(shown("a\n  WRONG: b\u{9b}31m\u{202e}\\n", 60), r"a\n  WRONG: b\u{9b}31m\u{202e}\\n");
        assert_eq!(shown(&"x".repeat(3_000_000), 3), "xxx…");
        assert_eq!(shown("xxx", 3), "xxx");
    }
}
