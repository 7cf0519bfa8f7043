//! `plcfmu tune-study`: searches the settings of a controller that are the best for all plants of a study.

use super::study::interruption;
use super::{print, system, time_limit};
use crate::parameter_file;
use crate::progress::Progress;
use crate::tell;
use anyhow::{Result, bail};
use host::package::temporary;
use modeldescription::digits::short;
use std::path::PathBuf;
use std::time::Duration;
use study::pool;
use study::tuned::{self, Found};
use study::tuning::Tuning;
use study::{self, Interrupted};

/// Search the settings of a controller that are the best for all plants of a study
///
/// The axes of the study span the plants. Its table "tune" says which figure is to be low, what has to hold for every plant,
/// and which settings are searched within which range. The result is the same with any number of jobs.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = HELP)]
pub struct Options {
    /// The study, with a table [tune]
    #[arg(value_name = "STUDY.toml")]
    study: PathBuf,
    /// The folder of the FMUs; by default, that of the loop's description
    #[arg(long, value_name = "FOLDER")]
    fmus: Option<PathBuf>,
    /// Where the results go [default: the study's name and _tuned]
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// How many worker processes there are [default: one for each core]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// How long one run may take, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0, value_parser = time_limit)]
    time_limit: f64,
}

const HELP: &str = "\
Example of a table [tune]:
  [tune]
  minimize = \"iae\"
  over = \"worst\"                        # of all plants; or mean, p95
  constraints = [\"overshoot < 10 %\", \"ms < 1.8\"]
  front = \"travel\"                      # a second figure, if a front of both is wanted
  evaluations = 500

  [[tune.search]]
  variable = \"PID.GAIN\"
  min = 0.5
  max = 10.0

Files of the result: tuned.toml is the loop with the settings found, which plcfmu run runs; tuned.json has them as a \
parameter file, if the block is one of a PLC's; settings.csv; front.csv, front.svg and front.png.

The README of plcfmu says what a study and its table [tune] are made of.";

/// Searches.
///
/// # Errors
/// What is wrong and what to do; no candidate meets the constraints; [`Interrupted`].
pub fn run(options: &Options) -> Result<()> {
    let mut reading = study::open(&options.study, options.fmus.as_deref(), parameter_file::read_any)?;
    let (system, _folder) = system::packed(&reading.job.system)?;
    reading.job.system = system;
    let out = options.out.clone().unwrap_or_else(|| format!("{}_tuned", reading.name).into());
    let outputs = tuned::FILES.map(|file| out.join(file));
    temporary::check_outputs(outputs.iter().map(PathBuf::as_path), reading.job.system.inputs())?;
    let defaults = pool::Options::new()?;
    let pool_options = pool::Options {
        jobs: options.jobs.map_or(defaults.jobs, usize::from),
        limit: Duration::from_secs_f64(options.time_limit),
        interrupted: interruption()?,
        ..defaults
    };
    let mut tuning = Tuning::start(&reading, &pool_options).map_err(|error| reading.located(error, &options.study))?;
    for remark in reading.job.system.remarks.iter().chain(&tuning.remarks) {
        tell::remark(remark);
    }
    let progress = Progress::candidates(tuning.problem.evaluations);
    let minimized = &tuning.figures[tuning.problem.minimize];
    let (name, unit) = (minimized.name.clone(), minimized.unit.clone().unwrap_or_default());
    let searched = tuning.search(|count, best| {
        progress.set(count);
        progress.begin(&match best.objective.filter(|_| best.is_feasible()) {
            Some(value) => format!("{name} {} {unit}", short(value)),
            None => "no candidate meets the constraints yet".into(),
        });
    });
    drop(progress);
    let (outcome, present) = match searched {
        Err(_) if tuning.is_interrupted() => bail!(Interrupted("nothing was written".into())),
        searched => searched?,
    };
    let found = Found { tuning: &tuning, outcome: &outcome, present: &present };
    print(&found.text())?;
    for remark in found.remarks() {
        tell::remark(&remark);
    }
    if let Some(problem) = found.problem() {
        bail!("{problem}");
    }
    for path in tuned::write(&out, &found)? {
        print(&format!("{}\n", path.display()))?;
    }
    if tuning.is_interrupted() {
        bail!(Interrupted("the settings are the best of those that were tried".into()));
    }
    Ok(())
}
