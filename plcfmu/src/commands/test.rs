//! `plcfmu test`: tests a program in SCL.

use super::print;
use crate::package::program::Refused;
use crate::program::{self, trial};
use anyhow::{Context, Result, bail, ensure};
use host::package::temporary;
use parameters::problem::drawn;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use study::junit;

const HELP: &str = "\
Example of a test file:
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
/// The file names the sources of the program (by default, those in its folder), sets its inputs over time, and states
/// the expected values of its variables. Each case begins with the start values. A step sets its values before the call
/// at its time; its expectations must hold after this call, after one of the calls `within` a time, or after all calls
/// `until` a time.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(after_help = HELP)]
pub struct Options {
    /// The test file, or a folder of test files
    #[arg(value_name = "FILE.toml|FOLDER")]
    pub file: PathBuf,
    /// Write the results as JUnit XML, which CI servers show as tests
    #[arg(long, value_name = "FILE.xml")]
    pub junit: Option<PathBuf>,
    /// Print the results as JSON, for scripts
    #[arg(long)]
    pub json: bool,
    /// Write a page with the sources that shows which lines were run
    #[arg(long, value_name = "FILE.html")]
    pub coverage: Option<PathBuf>,
}

/// Runs the cases of a test file, or of all test files in a folder, and prints the results.
///
/// # Errors
/// A file or the program is faulty; or cases failed, in which case the error states their number.
pub fn run(options: &Options) -> Result<()> {
    let path = &options.file;
    ensure!(
        !program::is_source(path),
        "{} is a program: specify its test file, a .toml; 'plcfmu new --scl NAME' creates a program with a test",
        path.display()
    );
    let files = if path.is_dir() { program::test_files(path)? } else { vec![path.clone()] };
    ensure!(
        files.len() == 1 || options.coverage.is_none(),
        "{} has {} test files: choose one of them for --coverage",
        path.display(),
        files.len()
    );
    let trials = files.iter().map(|file| trial::File::read(file)).collect::<Result<Vec<_>>>()?;
    let mut inputs = files.clone();
    for trial in &trials {
        inputs.extend(program::files(&trial.manifest)?);
    }
    let outputs = [&options.junit, &options.coverage].into_iter().flatten();
    temporary::check_outputs(outputs.map(PathBuf::as_path), inputs.iter().map(PathBuf::as_path))?;
    let (mut cases, mut told) = (Vec::new(), Vec::new());
    for (path, file) in files.iter().zip(&trials) {
        if files.len() > 1 && !options.json {
            print(&format!("{}\n", path.display()))?;
        }
        cases.extend(run_file(path, file, options, &mut told)?);
    }
    if options.json {
        print(&format!("{:#}\n", Value::Array(told)))?;
    }
    if let Some(junit) = &options.junit {
        junit::write_suite(junit, &path.display().to_string(), cases.clone())?;
    }
    match cases.iter().filter(|case| case.problem.is_some()).count() {
        0 => Ok(()),
        failed => bail!("{failed} of {} cases failed", cases.len()),
    }
}

/// Runs the cases of a file, and appends their results to `told`, the list for `--json`.
fn run_file(path: &Path, file: &trial::File, options: &Options, told: &mut Vec<Value>) -> Result<Vec<junit::Case>> {
    let say = |text: &str| if options.json { Ok(()) } else { print(text) };
    let parts = program::parts(&file.manifest)?;
    if let Some(table) = program::survey::describe(&file.manifest.sources, &parts) {
        say(&table)?;
    }
    let compiled = match scl::compile(&parts.sources, &parts.manifest) {
        Ok(compiled) => compiled,
        Err(errors) if options.json => return Err(Refused::Sources(errors).into()),
        Err(errors) => {
            errors.iter().try_for_each(|problems| print(&drawn(problems)))?;
            bail!("the program has errors");
        }
    };
    let mut trial = trial::Trial::new(compiled)?;
    let mut cases = Vec::new();
    for case in &file.cases {
        let problem = trial.run(file, case)?;
        let verdict = problem.as_ref().map_or_else(|| "ok".to_string(), |problem| format!("FAILED: {problem}"));
        say(&format!("{}: {verdict}\n", case.name))?;
        cases.push(junit::Case { name: case.name.clone(), text: problem.clone().unwrap_or_default(), problem });
    }
    let coverage = trial.coverage();
    let (run, all) = (coverage.run(), coverage.all());
    say(&format!("{run} of {all} statement lines were run\n"))?;
    let of_case = |case: &junit::Case| json!({ "name": case.name, "problem": case.problem });
    let results: Vec<Value> = cases.iter().map(of_case).collect();
    told.push(json!({ "file": path.display().to_string(), "cases": results, "lines": all, "lines_run": run }));
    if let Some(path) = &options.coverage {
        fs::write(path, coverage.page(&parts.sources))
            .with_context(|| format!("{} cannot be written", path.display()))?;
    }
    Ok(cases)
}
