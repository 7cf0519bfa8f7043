//! `plcfmu new`: makes a crate for a block of one's own.

use crate::build::template::{self, Names};
use anyhow::Result;
use std::io::{IsTerminal, stderr, stdin};
use std::path::PathBuf;

/// What to make.
#[derive(clap::Args, Debug)]
pub struct Options {
    /// The crate's name, such as my_block; its FMU is MY_BLOCK.fmu
    name: String,
    /// The block's licence, an SPDX expression such as MIT; asked for on a terminal, otherwise left open
    #[arg(long, value_name = "SPDX")]
    license: Option<String>,
    /// The folder to make [default: NAME in the current folder]
    #[arg(long, value_name = "DIR")]
    path: Option<PathBuf>,
}

/// Makes the crate and says what to do next.
pub fn run(options: &Options) -> Result<()> {
    let names = Names::of(&options.name)?;
    let license = match &options.license {
        Some(license) => Some(license.clone()),
        None if stdin().is_terminal() && stderr().is_terminal() => ask()?,
        None => None,
    };
    if let Some(license) = &license {
        template::check_license(license)?;
    }
    let path = options.path.clone().unwrap_or_else(|| names.package.clone().into());
    template::create(&path, &names, license.as_deref())?;
    println!(
        "{folder} is ready. Write the block in src/lib.rs, then:\n\n  cd {folder}\n  cargo test      # runs the block's tests\n  \
         plcfmu build    # packs target/fmu/{block}.fmu",
        folder = path.display(),
        block = names.block
    );
    if license.is_none() {
        println!("\nThe licence is open: add a line such as license = \"MIT\" to Cargo.toml to name one.");
    }
    Ok(())
}

/// Asks for the licence.
fn ask() -> Result<Option<String>> {
    eprint!("Licence of the block, such as MIT (Enter leaves it open): ");
    let mut answer = String::new();
    stdin().read_line(&mut answer)?;
    Ok(Some(answer.trim().to_string()).filter(|license| !license.is_empty()))
}
