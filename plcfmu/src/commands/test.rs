//! `plcfmu test`: tests of a program in SCL.

use super::print;
use crate::program::{self, trial};
use anyhow::{Context, Result, bail, ensure};
use parameters::problem::drawn;
use std::fs;
use std::path::PathBuf;
use study::junit;

const HELP: &str = "\
Example of a file:
  sources = [\"machine.scl\"]
  cycle = \"100ms\"

  [[case]]
  name = \"the valve opens\"
  steps = [
    { at = \"0s\", set = { level = 20.0 } },
    { at = \"1s\", set = { start = true }, within = \"2s\", expect = { valve = true } },
    { at = \"5s\", until = \"9s\", expect = { valve = true, level = 20.0 }, tolerance = 0.1 },
  ]";

/// Test the logic of a program in SCL
///
/// The file says which sources the program has, what its inputs are over time, and what is expected of its variables.
/// Each case begins with the start values. What a step sets is set before the call at its time; what it expects must hold
/// after this call, or after one of the calls `within` a time, or after all calls `until` a time.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(after_help = HELP)]
pub struct Options {
    /// The file with the cases
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Write the results as JUnit XML, which CI servers show as tests
    #[arg(long, value_name = "FILE.xml")]
    pub junit: Option<PathBuf>,
    /// Write the sources as a page that shows which lines were run
    #[arg(long, value_name = "FILE.html")]
    pub coverage: Option<PathBuf>,
}

/// Runs the cases of a file and prints their results.
///
/// # Errors
/// The file or the program is wrong; or the number of cases that failed, which have been printed.
pub fn run(options: &Options) -> Result<()> {
    ensure!(
        !program::is_source(&options.file),
        "{} is a program: name its test, a .toml; 'plcfmu new --scl NAME' writes a program with one",
        options.file.display()
    );
    let file = trial::File::read(&options.file)?;
    let compiled = match program::compile(&file.sources(), &file.manifest)? {
        Ok(compiled) => compiled,
        Err(errors) => {
            errors.iter().try_for_each(|problems| print(&drawn(problems)))?;
            bail!("the program has errors");
        }
    };
    let mut trial = trial::Trial::new(compiled)?;
    let mut cases = Vec::new();
    for case in &file.cases {
        let problem = trial.run(&file, case)?;
        let verdict = problem.as_ref().map_or_else(|| "ok".to_string(), |problem| format!("FAILED: {problem}"));
        print(&format!("{}: {verdict}\n", case.name))?;
        cases.push(junit::Case { name: case.name.clone(), text: problem.clone().unwrap_or_default(), problem });
    }
    let failed = cases.iter().filter(|case| case.problem.is_some()).count();
    let coverage = trial.coverage();
    print(&format!("{} of {} lines of statements were run\n", coverage.run(), coverage.all()))?;
    if let Some(path) = &options.coverage {
        let page = coverage.page(&file.sources())?;
        fs::write(path, page).with_context(|| format!("{} cannot be written", path.display()))?;
    }
    if let Some(path) = &options.junit {
        junit::write_suite(path, &options.file.display().to_string(), cases)?;
    }
    match failed {
        0 => Ok(()),
        failed => bail!("{failed} of {} cases failed", file.cases.len()),
    }
}
