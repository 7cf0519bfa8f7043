//! `plcfmu completions` and `plcfmu manual`: shell completions and manual pages.

use super::print;
use anyhow::{Context, Result};
use clap::Command;
use clap_complete::{Shell, generate};
use std::fs;
use std::path::{Path, PathBuf};

/// Print the completions of plcfmu for a shell
///
/// For bash: plcfmu completions bash > ~/.local/share/bash-completion/completions/plcfmu
#[derive(clap::Args, Clone, Debug)]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Write the manual pages of plcfmu, one for each command
///
/// For example: plcfmu manual --out ~/.local/share/man/man1
#[derive(clap::Args, Clone, Debug)]
pub struct Manual {
    /// The folder to write to
    #[arg(short, long, value_name = "FOLDER", default_value = ".")]
    out: PathBuf,
}

/// Prints the completions of a shell.
///
/// # Errors
/// Standard output cannot be written.
pub fn completions(options: &Completions, mut command: Command) -> Result<()> {
    let mut text = Vec::new();
    generate(options.shell, &mut command, "plcfmu", &mut text);
    print(&String::from_utf8_lossy(&text))
}

/// Writes the manual pages.
///
/// # Errors
/// A page cannot be written.
pub fn manual(options: &Manual, mut command: Command) -> Result<()> {
    command.build();
    fs::create_dir_all(&options.out).with_context(|| options.out.display().to_string())?;
    pages(&options.out, &command, "plcfmu")
}

/// Writes the page of a command and the pages of its subcommands.
fn pages(folder: &Path, command: &Command, name: &str) -> Result<()> {
    let file = folder.join(format!("{name}.1"));
    let mut text = Vec::new();
    clap_mangen::Man::new(command.clone()).title(name).render(&mut text)?;
    fs::write(&file, text).with_context(|| file.display().to_string())?;
    print(&format!("{}\n", file.display()))?;
    let commands = command.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help");
    commands.into_iter().try_for_each(|inner| pages(folder, inner, &format!("{name}-{}", inner.get_name())))
}
