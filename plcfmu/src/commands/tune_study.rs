//! `plcfmu tune-study`: searches for the controller settings that are best for all plants of a study.

use super::{WorkerOptions, ensure_study, print, system};
use crate::parameter_file;
use crate::progress::Progress;
use crate::tell;
use anyhow::{Context, Result, bail};
use host::package::temporary;
use modeldescription::digits::short;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use study::each::{self, Tuned};
use study::tuned::{self, Found};
use study::tuning::Tuning;
use study::{self, Interrupted};

/// Search for the controller settings that are best for all plants of a study
///
/// The axes of the study span the plants. Its table "tune" specifies which figure to minimize, which constraints every
/// plant must meet, and which settings to search in which range. The result does not depend on the number of jobs. The
/// native code of the FMUs is executed: use FMUs that you trust.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = HELP)]
pub struct Options {
    /// The study, with a table [tune]
    #[arg(value_name = "STUDY.toml")]
    study: PathBuf,
    /// The folder of the FMUs; by default, that of the loop's description
    #[arg(long, value_name = "FOLDER")]
    fmus: Option<PathBuf>,
    /// Folder for the results [default: the study's name followed by _tuned]
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    #[command(flatten)]
    workers: WorkerOptions,
}

const HELP: &str = "\
Example of a table [tune]:
  [tune]
  minimize = \"iae\"
  over = \"worst\"                        # of all plants; or mean, p95
  constraints = [\"overshoot < 10 %\", \"ms < 1.8\"]
  front = \"travel\"                      # a second figure, for a front of both
  evaluations = 500

  [[tune.search]]
  variable = \"PID.GAIN\"
  min = 0.5
  max = 10.0

Result files: tuned.toml, the loop with the settings found, for plcfmu run; tuned.json, these settings as a parameter \
file, if the block is a PLC block; settings.csv; front.csv, front.svg and front.png.

The plcfmu README describes the contents of a study and its table [tune].";

/// Searches for the settings, and writes them.
///
/// # Errors
/// The study is invalid; no candidate meets the constraints; [`Interrupted`].
pub fn run(options: &Options) -> Result<()> {
    ensure_study(&options.study)?;
    let mut reading = study::open(&options.study, options.fmus.as_deref(), parameter_file::read_any)?;
    let (system, _folder) = system::packed(&reading.job.system)?;
    reading.job.system = system;
    let out = options.out.clone().unwrap_or_else(|| format!("{}_tuned", reading.name).into());
    let outputs = tuned::FILES.map(|file| out.join(file));
    temporary::check_outputs(outputs.iter().map(PathBuf::as_path), reading.job.system.inputs())?;
    if reading.is_each() {
        return run_each(options, &reading, &out);
    }
    let pool_options = options.workers.pool()?;
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
        bail!(Interrupted("the settings are the best of those tried so far".into()));
    }
    Ok(())
}

/// Tunes each loop of the study's table separately, and writes the settings found to a copy of the loops' parameter
/// file. A loop that cannot be tuned does not affect the others.
fn run_each(options: &Options, reading: &study::read::Reading, out: &Path) -> Result<()> {
    let pool_options = options.workers.pool()?;
    let names = reading.loops().map_err(|error| reading.located(error, &options.study))?;
    let source = reading.tables.iter().find_map(|(_, rows)| Some((&*rows.path, rows.source.as_ref()?)));
    let file = source.and_then(|(path, _)| path.file_name()).map(|name| out.join(name));
    let settings = out.join("settings.csv");
    temporary::check_outputs(file.iter().chain([&settings]).map(PathBuf::as_path), reading.job.system.inputs())?;
    for remark in &reading.job.system.remarks {
        tell::remark(remark);
    }
    let progress = Progress::bar(names.len());
    let (mut tuned, mut columns, mut variables) = (Vec::new(), Vec::new(), Vec::new());
    // Remarks common to several loops are printed once.
    let mut remarks = BTreeSet::new();
    for (row, name) in names.iter().enumerate() {
        progress.set(row);
        progress.begin(name);
        let one = Tuning::start(&reading.alone(row), &pool_options).and_then(|mut tuning| {
            remarks.extend(tuning.remarks.iter().cloned());
            let (outcome, present) = tuning.search(|_, _| {})?;
            columns = each::columns(&tuning);
            variables = tuning.problem.search.iter().map(|of| of.variable.clone()).collect();
            let found = Found { tuning: &tuning, outcome: &outcome, present: &present };
            Ok(Tuned::new(name, &found))
        });
        if pool_options.interrupted.load(Ordering::Relaxed) {
            bail!(Interrupted("nothing was written".into()));
        }
        tuned.push(one.unwrap_or_else(|error| Tuned::failed(name, format!("{error:#}"))));
    }
    drop(progress);
    for remark in &remarks {
        tell::remark(remark);
    }
    let failed: Vec<&Tuned> = tuned.iter().filter(|one| one.problem.is_some()).collect();
    for one in &failed {
        tell::warning(&format!("{}: {}", one.name, one.problem.as_deref().unwrap_or_default()));
    }
    if failed.len() == tuned.len() {
        bail!("no loop was tuned: nothing was written");
    }
    std::fs::create_dir_all(out).with_context(|| format!("{} cannot be created", out.display()))?;
    let write = |path: &Path, content: &[u8]| {
        temporary::place(path, |to| Ok(to.write_all(content)?), |_| Ok(()))?;
        print(&format!("{}\n", path.display()))
    };
    write(&settings, each::csv(&columns, &tuned).as_bytes())?;
    if let (Some((path, source)), Some(file)) = (source, file) {
        write(&file, &each::written_back(path, source, &variables, &tuned)?)?;
    }
    print(&format!("{} of {} loops tuned\n", tuned.len() - failed.len(), tuned.len()))?;
    if !failed.is_empty() {
        bail!("{} of {} loops could not be tuned and keep their settings", failed.len(), tuned.len());
    }
    Ok(())
}
