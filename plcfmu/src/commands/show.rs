//! `plcfmu show`: prints a program as it was understood.

use super::print;
use crate::package::program::Options as Packing;
use crate::program::{self, Parts};
use anyhow::{Error, Result, bail};
use parameters::problem::drawn;
use scl::Dialect;
use std::path::PathBuf;

/// Print a program as it was understood, as a source in SCL
///
/// Blocks in LAD and FBD, too: the text shows what runs, with titles and comments of the networks. It is a program that
/// yields the same results, bit by bit.
#[derive(clap::Args, Clone, Debug)]
#[group(skip)] // clap names a group after the type, and that of the programs has the same name
pub struct Options {
    /// The files of the program (.scl, .udt, .db, .s7dcl, .xml), all together
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// The language in which it is printed
    #[arg(long = "as", value_enum, value_name = "LANGUAGE", default_value_t = Language::Scl)]
    language: Language,
    #[allow(missing_docs)]
    #[command(flatten, next_help_heading = "Programs")]
    program: Packing,
}

/// A language of PLCs.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Language {
    /// Structured Control Language
    Scl,
}

/// Prints the blocks of a program.
///
/// # Errors
/// A file cannot be read, or the program has errors, which have been printed.
pub fn run(options: &Options) -> Result<()> {
    let manifest = options.program.manifest(&options.files)?;
    let Parts { sources, manifest, .. } = program::parts(&manifest)?;
    let compiled = match scl::compile(&sources, &manifest) {
        Ok(compiled) => compiled,
        Err(errors) => {
            errors.iter().try_for_each(|problems| print(&drawn(problems)))?;
            bail!("the program has errors");
        }
    };
    let Language::Scl = options.language;
    print(&scl::print(&compiled.program, &compiled.blocks(), Dialect::Tia).map_err(Error::msg)?)
}
