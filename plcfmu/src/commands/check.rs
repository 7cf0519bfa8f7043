//! `plcfmu check`: says in one sentence each what is wrong with FMUs.

use super::{LONGEST_NAME, functions, print, shown};
use crate::package::check::{STEPS, check, run as run_library};
use anyhow::{Result, bail};
use host::package::Package;
use modeldescription::{Description, shortened};
use std::path::{Path, PathBuf};

/// Check FMU files, whoever made them
///
/// Reads the archive, the model description and the libraries, and says in one sentence each what is wrong. No foreign
/// code runs unless --run is given.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// The FMUs
    #[arg(value_name = "FILE.fmu", required = true)]
    pub files: Vec<PathBuf>,
    /// Also load this machine's library and let it make some steps: this runs its code
    #[arg(long)]
    pub run: bool,
}

/// Checks FMUs and prints what they are and what is wrong with them.
///
/// # Errors
/// The number of FMUs that are wrong; what is wrong has been printed.
pub fn run(options: &Options) -> Result<()> {
    let mut wrong = 0;
    for file in &options.files {
        let verdict = examine(file, options.run);
        let lines: String = verdict.lines.iter().map(|line| format!("  {line}\n")).collect();
        print(&format!("{}\n{lines}", file.display()))?;
        wrong += usize::from(verdict.is_wrong);
    }
    match (wrong, options.files.len()) {
        (0, _) => Ok(()),
        (_, 1) => bail!("the FMU is wrong"),
        (wrong, all) => bail!("{wrong} of {all} FMUs are wrong"),
    }
}

/// What is printed of an FMU.
#[derive(Debug, Default)]
struct Verdict {
    lines: Vec<String>,
    is_wrong: bool,
}

impl Verdict {
    fn wrong(&mut self, error: &str) {
        self.lines.push(format!("WRONG: {error}"));
        self.is_wrong = true;
    }
}

fn examine(file: &Path, is_run: bool) -> Verdict {
    let mut verdict = Verdict::default();
    let mut package = match Package::open(file) {
        Ok(package) => package,
        Err(error) => {
            verdict.wrong(&format!("{error:#}"));
            return verdict;
        }
    };
    verdict.lines.push(headline(&package.description));
    let report = check(&mut package);
    report.errors.iter().for_each(|error| verdict.wrong(error));
    verdict.lines.extend(report.remarks.iter().map(|remark| format!("remark: {remark}")));
    for (file, binary) in &report.libraries {
        let needs = |glibc: &String| format!(", needs glibc {}", shown(glibc, LONGEST_NAME));
        let glibc = binary.glibc.as_ref().map_or(String::new(), needs);
        verdict.lines.push(format!("{}: {}{glibc}", file.path, functions(binary)));
    }
    // The code of an FMU that is wrong is not run.
    if is_run && !verdict.is_wrong {
        let place = std::env::temp_dir();
        match run_library(&mut package, &place) {
            Ok(()) => {
                verdict.lines.push(format!("run: instantiated, initialized, {STEPS} steps, all variables read, freed"));
            }
            Err(error) => verdict.wrong(&format!("{error:#}")),
        }
    }
    verdict
}

/// What an FMU is, in one line, whatever its texts contain.
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

/// What an FMU is made for.
pub(super) fn kinds(description: &Description) -> Vec<&'static str> {
    let co_simulation = description.co_simulation.as_ref().map(|_| "co-simulation");
    let model_exchange = description.model_exchange.as_ref().map(|_| "model exchange");
    co_simulation.into_iter().chain(model_exchange).collect()
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
        let verdict = examine(Path::new("/no/such/file.fmu"), true);
        assert!(verdict.is_wrong);
        assert!(verdict.lines[0].starts_with("WRONG: it cannot be opened: "), "{:?}", verdict.lines);
    }
}
