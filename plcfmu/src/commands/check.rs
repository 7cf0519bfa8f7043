//! `plcfmu check`: reports the problems of FMUs and of SCL programs, one sentence for each.

use super::{LONGEST_NAME, functions, print, refuse_folders, shown, time_limit};
use crate::exit::Unreadable;
use crate::interruption;
use crate::package::apart;
use crate::package::check::{STEPS, check};
use crate::package::program::{self as packing, Refused};
use crate::program::{self, survey};
use crate::tell::plain;
use anyhow::{Error, Result, anyhow, bail, ensure};
use host::child::Starter;
use host::machine::Fault;
use host::package::Package;
use modeldescription::{Description, shortened};
use parameters::problem::drawn;
use parameters::{Problem, Problems};
use serde::Serialize;
use serde_json::{Value, json};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;
use study::Interrupted;

/// Check FMU files from any vendor, or a program in SCL
///
/// Reads the archive, the model description and the libraries, and reports each problem in one sentence. No foreign
/// code runs unless --run is given.
///
/// Name all sources of a program (.scl, .udt, .db, .s7dcl, .xml, .awl) and its tag tables (.xml, .xlsx, .sdf) together,
/// or their folder. Errors are reported with file, line and column, as is anything that the author may not expect: a
/// temporary that is read before it is written, a REAL compared for equality, a lossy conversion.
#[derive(clap::Args, Clone, Debug)]
#[group(skip)] // clap names a group after its type, and the type of the flattened options has the same name
pub struct Options {
    /// The FMUs, and the sources of a program
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// Also load the library for this machine and run a few steps: this executes its code
    #[arg(long)]
    pub run: bool,
    /// Print the findings as JSON, for scripts
    #[arg(long)]
    pub json: bool,
    /// Time limit for running each FMU with --run, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = time_limit)]
    pub time_limit: f64,
    #[allow(missing_docs)]
    #[command(flatten, next_help_heading = "Programs in SCL")]
    pub program: packing::Options,
}

/// Checks FMUs and a program, and prints a description of each and its problems.
///
/// # Errors
/// An FMU or the program is faulty, or a file cannot be read; the problems have been printed.
pub fn run(options: &Options) -> Result<()> {
    let (sources, fmus): (Vec<PathBuf>, Vec<PathBuf>) =
        options.files.iter().cloned().partition(|file| program::is_part(file));
    if !sources.is_empty() {
        ensure!(fmus.is_empty() || !options.json, "--json accepts a program or FMUs, not both");
        check_program(&sources, &options.program, options.json)?;
        if options.json {
            return Ok(());
        }
    } else {
        options.program.refuse()?;
    }
    let (mut wrong, mut untried) = (0, 0);
    let limit = Duration::from_secs_f64(options.time_limit);
    let starter =
        options.run.then(|| anyhow::Ok(Starter { limit, interrupted: interruption::flag(), ..Starter::new()? }));
    let starter = starter.transpose()?;
    let mut unreadable = None;
    let mut verdicts = Vec::new();
    refuse_folders(&fmus)?;
    for file in &fmus {
        let verdict = examine(file, starter.as_ref());
        if starter.as_ref().is_some_and(|starter| starter.interrupted.load(Ordering::Relaxed)) {
            bail!(Interrupted(format!("{} was not checked", file.display())));
        }
        if let Err(error) = File::open(file) {
            unreadable.get_or_insert_with(|| Unreadable(anyhow!("{} cannot be read: {error}", file.display())));
        }
        wrong += usize::from(!verdict.errors.is_empty());
        untried += usize::from(verdict.untried.is_some());
        if options.json {
            verdicts.push(verdict);
        } else {
            print(&verdict.text())?;
        }
    }
    if options.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&verdicts)?))?;
    }
    if let Some(unreadable) = unreadable {
        return Err(Error::new(unreadable));
    }
    match (wrong, fmus.len()) {
        (0, _) if untried > 0 => {
            let all = fmus.len();
            Err(Error::new(Unreadable(anyhow!("{untried} of {all} FMUs could not be tried on this machine"))))
        }
        (0, _) => Ok(()),
        (_, 1) => bail!("the FMU is faulty"),
        (wrong, all) => bail!("{wrong} of {all} FMUs are faulty"),
    }
}

/// Prints the errors and warnings of a program: everything that `build` would report.
fn check_program(sources: &[PathBuf], options: &packing::Options, is_json: bool) -> Result<()> {
    let mut manifest = options.manifest(sources)?;
    if !is_json && let Some(table) = survey::table(sources, &manifest)? {
        print(&table)?;
    }
    manifest.cycle = manifest.cycle.or(Some(100));
    let none = Vec::new;
    let (block, remark, errors, warnings) = match packing::examine(&manifest) {
        Ok(examined) => {
            let stop = examined.stop.as_deref().map(packing::stops);
            (Some(examined.block().to_string()), stop, none(), examined.warnings)
        }
        Err(Refused::Choice(which, warnings)) => (None, Some(which), none(), warnings),
        Err(Refused::Sources(errors)) => (None, None, errors, none()),
        Err(Refused::Other(error)) => return Err(error),
    };
    let count = |problems: &[Problems]| match problems.iter().map(|of_file| of_file.problems.len()).sum::<usize>() {
        1 => (1, ""),
        count => (count, "s"),
    };
    if is_json {
        let (errors, warnings) = (findings(&errors), findings(&warnings));
        let found = json!({ "block": block, "errors": errors, "warnings": warnings, "remark": remark });
        print(&format!("{found:#}\n"))?;
    } else {
        errors.iter().chain(&warnings).try_for_each(|problems| print(&drawn(problems)))?;
    }
    if let (errors @ 1.., plural) = count(&errors) {
        bail!("the program has {errors} error{plural}");
    }
    if is_json {
        return Ok(());
    }
    let (warnings, plural) = count(&warnings);
    let runs = block.map_or_else(|| "build: ".to_string(), |block| format!("the FMU runs {block}\n"));
    let remark = remark.map_or_else(String::new, |remark| remark + "\n");
    print(&format!("no errors, {warnings} warning{plural}; {runs}{remark}"))
}

/// The problems as JSON, for scripts.
fn findings(problems: &[Problems]) -> Vec<Value> {
    let finding = |file: &str, problem: &Problem| {
        json!({
            "file": file,
            "line": problem.place.as_ref().map(|place| place.line),
            "column": problem.place.as_ref().map(|place| place.column),
            "message": problem.message,
            "help": problem.help.as_ref().map(ToString::to_string),
        })
    };
    problems.iter().flat_map(|of| of.problems.iter().map(move |problem| finding(&of.file, problem))).collect()
}

/// The findings on an FMU, as printed by `--json`.
#[derive(Debug, Default, Serialize)]
struct Verdict {
    file: String,
    /// A one-line summary: name, FMI version, kind, number of variables and GUID.
    what: Option<String>,
    /// Problems that keep importers from using the FMU.
    errors: Vec<String>,
    /// Violations of the standard that importers tolerate.
    departures: Vec<String>,
    /// Permitted features that may surprise the user.
    remarks: Vec<String>,
    /// The FMU's libraries, one string each.
    libraries: Vec<String>,
    /// The result of the trial run, or why there was none.
    run: Option<String>,
    /// Why the FMU could not be tried: a fault of this machine.
    untried: Option<String>,
}

impl Verdict {
    /// The result as text.
    fn text(&self) -> String {
        let errors = self.errors.iter().map(|error| format!("WRONG: {error}"));
        let remarks = self.remarks.iter().map(|remark| format!("remark: {remark}"));
        let others = self.libraries.iter().chain(&self.run).cloned();
        let departures = self.departures.iter().map(|departure| format!("DEPARTS: {departure}"));
        let untried = self.untried.iter().map(|why| format!("could not be tried: {why}"));
        let verdict = match (self.errors.is_empty() && self.untried.is_none(), self.departures.is_empty()) {
            (false, _) => None,
            (true, false) => Some("departs from the standard, but runs in the tools tested".to_string()),
            (true, true) => Some("ok".to_string()),
        };
        let lines = self.what.iter().cloned().chain(errors).chain(departures).chain(remarks).chain(others);
        let lines = lines.chain(untried).chain(verdict);
        // Names in an archive may contain characters that a terminal interprets as commands.
        plain(&format!("{}\n{}", self.file, lines.map(|line| format!("  {line}\n")).collect::<String>()))
    }
}

/// Examines an FMU. With a starter, its code is also run, in a separate process.
fn examine(file: &Path, starter: Option<&Starter>) -> Verdict {
    let mut verdict = Verdict { file: file.display().to_string(), ..Verdict::default() };
    let mut package = match Package::open(file) {
        Ok(package) => package,
        Err(error) => {
            verdict.errors.push(program::instead(file).unwrap_or_else(|| format!("{error:#}")));
            return verdict;
        }
    };
    verdict.what = Some(headline(&package.description));
    let report = check(&mut package);
    (verdict.errors, verdict.departures, verdict.remarks) = (report.errors, report.departures, report.remarks);
    for (file, binary) in &report.libraries {
        let needs = |glibc: &String| format!(", needs glibc {}", shown(glibc, LONGEST_NAME));
        let glibc = binary.glibc.as_ref().map_or(String::new(), needs);
        verdict.libraries.push(format!("{}: {}{glibc}", file.path, functions(binary, &package.description)));
    }
    // The code of a faulty FMU is not run. An FMU that cannot be run here, such as one without a library for this
    // platform, may still be correct.
    match (starter.filter(|_| verdict.errors.is_empty()), host::fmu::library(&package)) {
        (None, _) => {}
        (Some(_), Err(why)) => verdict.run = Some(format!("not run: {why:#}")),
        (Some(starter), Ok(_)) => match apart::run(starter, file) {
            Ok(()) => {
                let done = format!("run: instantiated, initialized, {STEPS} steps, all variables read, freed");
                verdict.run = Some(done);
            }
            Err(error) if error.is::<Fault>() => verdict.untried = Some(format!("{error:#}")),
            Err(error) => verdict.errors.push(format!("{error:#}")),
        },
    }
    verdict
}

/// A one-line summary of an FMU, with its strings quoted and shortened.
fn headline(description: &Description) -> String {
    format!(
        "{:?}: FMI {} for {}, {} variables, GUID {:?}",
        shortened(&description.model_name),
        description.fmi_version,
        kinds(description).join(" and "),
        description.variables.len(),
        shortened(&description.guid)
    )
}

/// The kinds of simulation that an FMU supports.
pub(super) fn kinds(description: &Description) -> Vec<&'static str> {
    let co_simulation = description.co_simulation.as_ref().map(|_| "co-simulation");
    let model_exchange = description.model_exchange.as_ref().map(|_| "model exchange");
    let scheduled_execution = description.scheduled_execution.as_ref().map(|_| "scheduled execution");
    co_simulation.into_iter().chain(model_exchange).chain(scheduled_execution).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use modeldescription::Support;

    #[test]
    fn an_fmu_is_one_line_whatever_its_texts_contain() {
        let mut description = Description {
            fmi_version: "2.0",
            model_name: "PUMP".into(),
            guid: "{1}".into(),
            co_simulation: Some(Support::default()),
            ..Description::default()
        };
        assert_eq!(headline(&description), r#""PUMP": FMI 2.0 for co-simulation, 0 variables, GUID "{1}""#);
        description.model_name = "PUMP\n  linux64: fine\u{9b}31m".into();
        description.guid = "0".repeat(3_000_000);
        assert_eq!(
            headline(&description),
            format!(
                r#""PUMP\n  linux64: fine\u{{9b}}31m": FMI 2.0 for co-simulation, 0 variables, GUID "{}…""#,
                "0".repeat(60)
            )
        );
    }

    #[test]
    fn a_file_that_is_not_an_fmu_is_wrong() {
        let verdict = examine(Path::new("/no/such/file.fmu"), None);
        assert!(verdict.errors[0].starts_with("it cannot be opened: "), "{:?}", verdict.errors);
        assert!(verdict.text().starts_with("/no/such/file.fmu\n  WRONG: it cannot be opened: "));
    }
}
