//! `plcfmu show`: prints a program as plcfmu understands it.

use super::print;
use crate::package::program::Options as Packing;
use crate::program::{self, Parts};
use anyhow::{Error, Result, bail};
use parameters::problem::drawn;
use scl::Dialect;
use std::path::PathBuf;

/// Print a program as plcfmu understands it, in SCL
///
/// This includes blocks in LAD and FBD: the text shows what runs, with network titles and comments. The printed program
/// yields the same results, bit for bit.
#[derive(clap::Args, Clone, Debug)]
#[group(skip)] // clap names a group after its type, and the type of the flattened options has the same name
pub struct Options {
    /// The files of the program (.scl, .udt, .db, .s7dcl, .xml), all together
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// The output language
    #[arg(long = "as", value_enum, value_name = "LANGUAGE", default_value_t = Language::Scl)]
    language: Language,
    #[allow(missing_docs)]
    #[command(flatten, next_help_heading = "Programs")]
    program: Packing,
}

/// A PLC language.
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
