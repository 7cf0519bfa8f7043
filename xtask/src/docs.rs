//! `cargo xtask docs`: builds the project's site.

use crate::python::Environment;
use crate::steps::Steps;
use anyhow::Result;
use plcfmu::build::workspace::Workspace;
use plcfmu::command::run;
use plcfmu::package::pack;
use plcfmu::tool::make;

/// The options of the site.
#[derive(clap::Args, Clone, Debug, Default)]
pub(crate) struct Options {
    /// URL of the published site, such as `https://example.org/plcfmu/`, for the sitemap and the page 404.html
    #[arg(long, value_name = "URL")]
    pub address: Option<String>,
    /// URL of the published sources, such as `https://github.com/OWNER/plcfmu`, for links to edit a page
    #[arg(long, value_name = "URL")]
    pub repository: Option<String>,
}

/// Packs the FMUs, builds the parameter tool, and writes the site with both. If the tool's engine cannot be compiled,
/// the site is built without it.
pub(crate) fn docs(workspace: &Workspace, options: &Options) -> Result<()> {
    let mut steps = Steps::new(3);
    let mut python = Environment::ready(workspace)?.python();
    steps.begin("FMUs");
    pack::run(workspace, &pack::Options::default())?;
    python.arg("docs/site/build.py").arg("--fmus").arg(workspace.fmus());
    python.arg("--out").arg(workspace.target.join("docs"));
    python.arg("--results").arg(workspace.target.join("results"));
    python.args(options.address.iter().map(|address| format!("--address={address}")));
    python.args(options.repository.iter().map(|repository| format!("--repository={repository}")));
    steps.begin("the parameter tool");
    match make::run(workspace, &make::Options { fmus: Some(workspace.fmus()), out: None }) {
        Ok(()) => {
            python.arg("--tool").arg(make::place(workspace));
        }
        Err(error) => eprintln!("note: the site does not include the parameter tool: {error:#}"),
    }
    steps.begin("the site");
    run(python.current_dir(&workspace.root))
}
