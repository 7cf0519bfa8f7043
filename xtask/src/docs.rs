//! `cargo xtask docs`: the project's site.

use crate::python::Environment;
use anyhow::Result;
use plcfmu::build::workspace::Workspace;
use plcfmu::command::run;
use plcfmu::package::pack;
use plcfmu::tool::make;

/// What the site is made for.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// Where the site will be published, such as `https://example.org/plcfmu/`; for previews, the sitemap and its page 404.html
    #[arg(long, value_name = "URL")]
    pub address: Option<String>,
}

/// Packs the FMUs, makes the parameter tool, and writes the site with both. Where the engine of the tool cannot be compiled,
/// the site is without it.
pub fn docs(workspace: &Workspace, options: &Options) -> Result<()> {
    let mut python = Environment::ready(workspace)?.python();
    pack::run(workspace, &pack::Options::default())?;
    python.arg("docs/site/build.py").arg("--fmus").arg(workspace.fmus());
    python.arg("--out").arg(workspace.target.join("docs"));
    python.args(options.address.iter().map(|address| format!("--address={address}")));
    match make::run(workspace, &make::Options { fmus: Some(workspace.fmus()), out: None }) {
        Ok(()) => {
            python.arg("--tool").arg(make::place(workspace));
        }
        Err(error) => eprintln!("note: the site is without the parameter tool: {error:#}"),
    }
    run(python.current_dir(&workspace.root))
}
