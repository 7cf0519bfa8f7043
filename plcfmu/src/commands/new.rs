//! `plcfmu new`: creates a crate for a user's own block, or a program in SCL.

use crate::build::template::{self, Names};
use crate::tell;
use anyhow::{Context, Result};
use std::fs;
use std::io::{IsTerminal, stderr, stdin};
use std::path::{Path, PathBuf};

/// The crate or program to create.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// The crate's name, such as my_block; its FMU is MY_BLOCK.fmu
    name: String,
    /// Create a PLC program in SCL with a test of its logic, instead of a Rust crate
    #[arg(long, conflicts_with = "license")]
    scl: bool,
    /// The block's licence, an SPDX expression such as MIT; prompted for on a terminal, otherwise left open
    #[arg(long, value_name = "SPDX")]
    license: Option<String>,
    /// The folder to create [default: NAME in the current folder]
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// Creates the crate or program and prints the next steps.
pub fn run(options: &Options) -> Result<()> {
    let names = Names::new(&options.name)?;
    if options.scl {
        return make_program(&names, options.out.as_deref());
    }
    let license = match &options.license {
        Some(license) => Some(license.clone()),
        None if stdin().is_terminal() && stderr().is_terminal() => ask()?,
        None => None,
    };
    if let Some(license) = &license {
        template::check_license(license)?;
    }
    let path = options.out.clone().unwrap_or_else(|| names.package.clone().into());
    template::create(&path, &names, license.as_deref())?;
    println!(
        "{folder} is ready. Write the block in src/lib.rs, then:\n\n  cd {folder}\n  cargo test      # runs the block's tests\n  \
         plcfmu build    # packs target/fmu/{block}.fmu",
        folder = quoted(&path.display().to_string()),
        block = names.block
    );
    if license.is_none() {
        println!("\nNo licence is set: add a line such as license = \"MIT\" to Cargo.toml.");
    }
    Ok(())
}

/// Creates a program with its test.
fn make_program(names: &Names, path: Option<&Path>) -> Result<()> {
    let (name, block) = (&names.package, &names.block);
    let folder = path.unwrap_or(Path::new(name));
    fs::create_dir(folder)
        .with_context(|| format!("the folder {} cannot be created: choose another with --out", folder.display()))?;
    let program = include_str!("../program/template/machine.scl").replace("MACHINE", block);
    let test = include_str!("../program/template/machine.toml").replace("machine.scl", &format!("{name}.scl"));
    for (file, text) in [(format!("{name}.scl"), program), (format!("{name}.toml"), test)] {
        let file = folder.join(file);
        fs::write(&file, text).with_context(|| format!("{} cannot be written", file.display()))?;
    }
    let folder = quoted(&folder.display().to_string());
    println!(
        "{folder} is ready. Write the program in {name}.scl, then:\n\n  cd {folder}\n  plcfmu check {name}.scl                  # \
         errors and warnings\n  plcfmu test {name}.toml                  # runs its cases\n  plcfmu build {name}.scl --cycle 100ms   # packs \
         {block}.fmu"
    );
    Ok(())
}

/// A path, quoted for a shell if necessary.
fn quoted(path: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/\\._-+:".contains(c);
    if path.chars().all(is_plain) { path.into() } else { format!("\"{path}\"") }
}

#[cfg(test)]
#[test]
fn a_path_with_a_blank_is_one_word_for_a_shell() {
    assert_eq!(["sub dir/b2", "sub/b2", r"C:\b2"].map(quoted), ["\"sub dir/b2\"", "sub/b2", r"C:\b2"]);
}

/// Asks the user for the licence; `None` leaves it open.
fn ask() -> Result<Option<String>> {
    tell::raw("Licence of the block, such as MIT (Enter leaves it open): ");
    let mut answer = String::new();
    stdin().read_line(&mut answer)?;
    Ok(Some(answer.trim().to_string()).filter(|license| !license.is_empty()))
}
