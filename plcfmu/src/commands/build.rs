//! `plcfmu build`: packs the FMUs of the workspace that it is called in.

use crate::build::template;
use crate::build::workspace::Workspace;
use crate::package::pack;
use anyhow::Result;

/// What to build.
#[derive(clap::Args, Debug)]
#[group(skip)] // clap names a group after the type, and the packer's has the same name
pub struct Options {
    #[command(flatten)]
    pack: pack::Options,
    /// First replace the crate's copy of plcfmu's sources (its folder plcfmu) by that of this version
    #[arg(long)]
    update: bool,
}

/// Builds and packs.
pub fn run(options: &Options) -> Result<()> {
    let workspace = Workspace::find()?;
    if options.update {
        template::update(&workspace.root)?;
    }
    if let Some(path) = template::different_source(&workspace.root) {
        eprintln!(
            "note: {path} is not that of plcfmu {}; 'plcfmu build --update' replaces the folder",
            env!("CARGO_PKG_VERSION")
        );
    }
    pack::run(&workspace, &options.pack)
}
