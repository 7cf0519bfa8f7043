//! `plcfmu study`: runs a loop many times with different values.

use super::{WorkerOptions, ensure_study, print, shown, system};
use crate::parameter_file;
use crate::progress::Progress;
use crate::tell;
use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;
use host::package::temporary;
use run::master::Recording;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use study::envelope::Envelope;
use study::expect::{Expectation, Verdict};
use study::experiment::{Detail, Experiment};
use study::finished::{self, RunsTable};
use study::output::Format;
use study::parts::{self, Collector, Parts, Rows};
use study::pool::{self, Pool};
use study::ran::Ran;
use study::report::{self, Report};
use study::results::{Results, RunResult};
use study::summary::Summary;
use study::{self, Interrupted, bundle, junit, output};

/// The number of worst runs listed in the summary for each figure.
const WORST: usize = 10;

/// The maximum number of characters shown of the output of a crashed FMU.
const LONGEST_PRINTED: usize = 500;

/// Run a loop many times with different values: tolerances, grids, regression tests
///
/// A study names a loop, what varies from run to run, and the results of each run. The runs use all cores, with the
/// FMUs in worker processes; the result does not depend on the number of workers. The native code of the FMUs is
/// executed: use FMUs that you trust.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = HELP)]
pub struct Options {
    /// The study: STUDY.toml, or the study.json of a bundle
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The folder of the FMUs; by default, that of the loop's description
    #[arg(long, value_name = "FOLDER")]
    fmus: Option<PathBuf>,
    /// Folder for the results [default: the study's name followed by _results]
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Format of the table with one row per run
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    workers: WorkerOptions,
    /// Create new FMU instances for each run instead of resetting the previous ones: for an FMU that keeps state across
    /// a reset
    #[arg(long, conflicts_with = "resume")]
    new_instances: bool,
    /// Resume an interrupted study; a finished one is not repeated
    #[arg(long)]
    resume: bool,
    /// Also write the curves of these runs, as plcfmu run --out does
    #[arg(long, value_name = "RUN,...", value_delimiter = ',')]
    curves: Vec<u64>,
    /// Require every run to meet this expectation, for example "overshoot < 10 %"; exit code 1 if one does not
    #[arg(long, value_name = "TEXT")]
    expect: Vec<String>,
    /// Write the expectations as tests in JUnit format
    #[arg(long, value_name = "FILE.xml", requires = "expect")]
    junit: Option<PathBuf>,
    /// Write a bundle, a folder with the study and its FMUs for another machine, and run nothing
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["out", "resume", "runs", "part", "junit"])]
    bundle: Option<PathBuf>,
    /// Execute only the runs A to B - 1, and write only a part
    #[arg(long, value_name = "A..B", value_parser = range, requires = "part", conflicts_with_all = ["out", "resume", "curves", "expect", "junit"])]
    runs: Option<Range<u64>>,
    /// The part to write; put it into the subfolder parts of the results folder, and --resume continues from it
    #[arg(long, value_name = "FILE", requires = "runs")]
    part: Option<PathBuf>,
}

const HELP: &str = "\
Examples:
  plcfmu study tolerances.toml
  plcfmu study tolerances.toml --expect 'overshoot < 10 %' --curves 0,17
  plcfmu study tolerances.toml --resume

The plcfmu README describes the contents of a study.";

fn range(text: &str) -> Result<Range<u64>, String> {
    let parsed = text.split_once("..").and_then(|(first, end)| Some(first.parse().ok()?..end.parse().ok()?));
    parsed.filter(|range| !range.is_empty()).ok_or_else(|| "write A..B, such as 0..1000, with B greater than A".into())
}

/// Runs a study.
///
/// # Errors
/// The study is invalid; all runs fail; a run does not meet an expectation; [`Interrupted`].
pub fn run(options: &Options) -> Result<()> {
    ensure_study(&options.study)?;
    let mut reading = study::open(&options.study, options.fmus.as_deref(), parameter_file::read_any)?;
    let (system, _folder) = system::packed(&reading.job.system)?;
    reading.job.system = system;
    let out = options.out.clone().unwrap_or_else(|| format!("{}_results", reading.name).into());
    let table = options.format.file(&out);
    let outputs = options.junit.iter().chain(&options.part).chain([&table]);
    temporary::check_outputs(outputs.map(PathBuf::as_path), reading.job.system.inputs())?;
    let fingerprint = study::fingerprint(&reading.job)?;
    let mut pool = start(options, &reading)?;
    warn(&pool, &reading.job.system.remarks);
    let count = pool.experiment().count();
    if let (Some(runs), Some(part)) = (&options.runs, &options.part) {
        return make_part(&mut pool, runs, part, &fingerprint);
    }
    let figures = pool.experiment().figures.clone();
    let expectations = options.expect.iter().map(|text| Expectation::parse(text, &figures));
    let expectations = expectations.collect::<Result<Vec<_>>>()?;
    let main = report::main_figure(&reading.job, &figures).map_err(|error| reading.located(error, &options.study))?;
    if let Some(run) = options.curves.iter().find(|run| **run >= count) {
        bail!("no run {run}: the study has runs 0 to {}", count.saturating_sub(1));
    }
    if let Some(folder) = &options.bundle {
        bundle::write(folder, &reading, count, pool.renews())?;
        let file = folder.join("study.json");
        return print(&format!("{}: a bundle for {count} runs; run it with 'plcfmu study'\n", file.display()));
    }

    let mut parts = Parts::open(&out, &fingerprint, options.resume)?;
    let results = match finished(&out, options, pool.experiment(), &fingerprint, &mut parts)? {
        Some(results) => results,
        None => {
            make_runs(&mut pool, &mut parts)?;
            results(&pool, &parts, &out)?
        }
    };
    let is_sample = reading.job.study.is_independent();
    let verdicts = expectations.into_iter().map(|expectation| {
        let verdict = expectation.verdict(&results, is_sample)?;
        Ok((expectation, verdict))
    });
    let verdicts = verdicts.collect::<Result<Vec<_>>>()?;
    let summary = Summary::new(&results, WORST)?;
    let mut again = Again { results: &results, runs: BTreeMap::new() };
    let wanted = report::curves_wanted(&summary, main);
    let curves = curves(&mut pool, &mut again, &out, &options.curves, &wanted)?;
    let experiment = pool.experiment().clone();
    let is_failed = |run| results.errors.contains_key(&run);
    let envelope = Envelope::new(&mut pool, &experiment, is_failed, |run, figures| again.compare(run, figures))?;
    ensure_going(&pool)?;
    again.warning().iter().for_each(|warning| tell::warning(warning));
    output::write(&options.format.file(&out), options.format, &results)?;
    let ran = Ran::new(&reading, &experiment)?;
    let report = Report {
        name: &reading.name,
        job: &reading.job,
        fingerprint: &fingerprint,
        table: &RunsTable::new(&out, options.format)?,
        ran: &ran,
        signals: &experiment.signals,
        disturbances: &experiment.disturbances,
        results: &results,
        summary: &summary,
        main,
        verdicts: &verdicts,
        curves: &curves,
        envelope: envelope.as_ref(),
    };
    write(&out, options, &report)?;
    parts.remove()?;
    print(&report::text(&report)?)?;
    print(&format!(
        "{}: a row for each run\n{}\n",
        options.format.file(&out).display(),
        out.join("summary.html").display()
    ))?;
    for run in options.curves.iter().collect::<BTreeSet<_>>() {
        if curves.iter().any(|(of, _)| of == run) {
            print(&format!("{}\n", curve_file(&out, *run).display()))?;
        }
    }
    if let Some(printed) = pool.printed() {
        tell::warning(&shown(&printed, LONGEST_PRINTED));
    }
    judge(&results, &verdicts)
}

fn start(options: &Options, reading: &study::read::Reading) -> Result<Pool> {
    let renews = if options.new_instances { Some(true) } else { reading.renews };
    let pool_options = pool::Options { renews, ..options.workers.pool()? };
    let pool = Pool::start(&reading.job, &pool_options);
    if pool_options.interrupted.load(Ordering::Relaxed) {
        bail!(Interrupted("no run was started".into()));
    }
    pool.map_err(|error| reading.located(error, &options.study))
}

/// Prints remarks and the study's warnings before the runs start.
fn warn(pool: &Pool, remarks: &[String]) {
    for remark in remarks {
        tell::remark(remark);
    }
    for warning in &pool.experiment().warnings {
        tell::warning(warning);
    }
}

/// Executes the runs of a part, and writes the part.
fn make_part(pool: &mut Pool, runs: &Range<u64>, part: &Path, fingerprint: &str) -> Result<()> {
    let count = pool.experiment().count();
    ensure!(runs.end <= count, "the study has runs 0 to {}, not {}..{}", count - 1, runs.start, runs.end);
    let experiment = pool.experiment().clone();
    let mut rows = Rows::default();
    let point = |run| experiment.point(runs.start + run);
    pool.rows(runs.end - runs.start, &point, &mut |_, row| rows.push(&row))?;
    if pool.is_interrupted() {
        bail!(Interrupted("nothing was written".into()));
    }
    parts::write(part, fingerprint, runs.start, &mut rows)
}

/// Executes the runs that are missing from the parts.
fn make_runs(pool: &mut Pool, parts: &mut Parts) -> Result<()> {
    let experiment = pool.experiment().clone();
    let count = experiment.count();
    let missing = Missing::new(parts.missing(count));
    let there = count - missing.count;
    let progress = Progress::runs(count, there, experiment.plan.steps);
    let mut kept = Kept { collector: Collector::new(parts), missing: &missing, progress: &progress, done: there };
    let made = pool.rows_into(missing.count, &|place| experiment.point(missing.run(place)), &mut kept);
    let Kept { mut collector, done, .. } = kept;
    // The rows received so far are kept even after an error.
    collector.flush()?;
    drop(progress);
    made?;
    if pool.is_interrupted() {
        bail!(Interrupted(format!(
            "{done} of {count} runs are kept; the same command with --resume completes the study"
        )));
    }
    Ok(())
}

/// Stores rows in parts, and shows the progress.
struct Kept<'a> {
    collector: Collector<'a>,
    missing: &'a Missing,
    progress: &'a Progress,
    done: u64,
}

impl pool::Sink for Kept<'_> {
    fn row(&mut self, place: u64, row: RunResult) -> Result<()> {
        self.done += 1;
        self.progress.set(self.done as usize);
        self.collector.push(self.missing.run(place), &row)
    }

    fn idle(&mut self) -> Result<()> {
        self.collector.wait()
    }
}

/// The runs that are not in any part, in ascending order.
struct Missing {
    /// The ranges, each with the number of runs in earlier ranges.
    ranges: Vec<(u64, Range<u64>)>,
    count: u64,
}

impl Missing {
    fn new(ranges: Vec<Range<u64>>) -> Missing {
        let mut missing = Missing { ranges: Vec::new(), count: 0 };
        for range in ranges {
            let length = range.end - range.start;
            missing.ranges.push((missing.count, range));
            missing.count += length;
        }
        missing
    }

    /// The number of the run at this position among the missing ones.
    fn run(&self, place: u64) -> u64 {
        let range = self.ranges.partition_point(|(before, _)| *before <= place).saturating_sub(1);
        let (before, range) = &self.ranges[range];
        range.start + (place - before)
    }
}

/// The results already in the folder of a resumed study, or `None` if runs are missing.
fn finished(
    out: &Path,
    options: &Options,
    experiment: &Experiment,
    fingerprint: &str,
    parts: &mut Parts,
) -> Result<Option<Results>> {
    if !options.resume {
        return Ok(None);
    }
    let count = experiment.count();
    let (mut results, mut rows) = (experiment.results().kept_in(out), 0);
    let mut each = |row: RunResult| {
        rows += 1;
        // Surplus rows are reported below.
        if rows <= count { results.push(&experiment.point(rows - 1), &row) } else { Ok(()) }
    };
    let (coordinates, figures) = (experiment.coordinates.len(), experiment.figures.len());
    match finished::rows(out, fingerprint, coordinates, figures, &mut each) {
        Ok(true) => {}
        Ok(false) => return Ok(None),
        // These results cannot be used, but the parts will replace them.
        Err(_) if !parts.are_empty() => return Ok(None),
        Err(error) => {
            parts.remove()?;
            return Err(error);
        }
    }
    ensure!(rows == count, "{} has {rows} of {count} runs: start over without --resume", out.display());
    tell::remark(&format!("{} has all {count} runs of this study: no run is repeated", out.display()));
    Ok(Some(results))
}

/// The results of all runs, read from the parts. If there are many, they are stored in `out` instead of in memory.
fn results(pool: &Pool, parts: &Parts, out: &Path) -> Result<Results> {
    let experiment = pool.experiment();
    let mut results = experiment.results().kept_in(out);
    parts.rows(|run, row| results.push(&experiment.point(run), &row))?;
    Ok(results)
}

/// Repeats runs to record their curves: those `wanted` for the report, and those `named` by the user, whose curves are
/// also written to files. A run without curves causes a warning and does not affect the others.
fn curves(
    pool: &mut Pool,
    again: &mut Again,
    out: &Path,
    named: &[u64],
    wanted: &[u64],
) -> Result<Vec<(u64, Recording)>> {
    let (mut curves, results) = (Vec::new(), again.results);
    study::clear(&out.join("curves"), |name| name.starts_with("run_") && name.ends_with(".csv"))?;
    for run in named.iter().chain(wanted).copied().collect::<BTreeSet<_>>() {
        if results.errors.contains_key(&run) {
            tell::warning(&format!("run {run} failed and has no curves"));
            continue;
        }
        let is_named = named.contains(&run);
        let made = pool.curve(&results.point(run)?, if is_named { Detail::All } else { Detail::Drawn });
        ensure_going(pool)?;
        let (mut recording, figures) = match made {
            Ok(made) => made,
            Err(error) => {
                tell::warning(&format!("run {run} has no curves: {error:#}"));
                continue;
            }
        };
        if let Some(figures) = figures {
            again.compare(run, &figures)?;
        }
        if is_named {
            temporary::place(&curve_file(out, run), |to| Ok(recording.write_csv(to)?), |_| Ok(()))?;
            recording = drawn(recording);
        }
        curves.push((run, recording));
    }
    Ok(curves)
}

/// The file with the curves of a run.
fn curve_file(out: &Path, run: u64) -> PathBuf {
    out.join("curves").join(format!("run_{run}.csv"))
}

/// Fails if the user has interrupted the study after all runs were completed: `--resume` then writes the results.
fn ensure_going(pool: &Pool) -> Result<()> {
    if pool.is_interrupted() {
        bail!(Interrupted("all runs are kept; the same command with --resume writes the results".into()));
    }
    Ok(())
}

/// Thins out a full recording to what would have been recorded for a picture alone.
fn drawn(recording: Recording) -> Recording {
    let mut thinned = Detail::Drawn.thinned(recording.columns.clone(), recording.times.len());
    recording.rows().for_each(|(time, row)| thinned.push(time, row));
    let mut drawn = thinned.recording();
    drawn.ended = recording.ended;
    drawn
}

/// The runs repeated with new instances, for curves and the envelope: if an FMU keeps state across a reset, their
/// results differ.
struct Again<'a> {
    results: &'a Results,
    /// For each run, the first figure that differs from the table.
    runs: BTreeMap<u64, Option<String>>,
}

impl Again<'_> {
    /// Compares the figures of a repeated run with the table.
    fn compare(&mut self, run: u64, anew: &[f64]) -> Result<()> {
        let row = self.results.figures_of(run)?;
        let pairs = self.results.figures.iter().zip(row.iter().zip(anew));
        let mut differing = pairs.filter(|(_, (row, anew))| row != anew && !(row.is_nan() && anew.is_nan()));
        let difference = differing.next().map(|(figure, (row, anew))| {
            let [row, anew] =
                [row, anew].map(|value| if value.is_nan() { "no value".into() } else { format!("{value:?}") });
            format!("{} is {row} in the table, but {anew} when repeated with new instances", figure.name)
        });
        self.runs.insert(run, difference);
        Ok(())
    }

    /// A warning if the figures of a repeated run differ from the table.
    fn warning(&self) -> Option<String> {
        let mut differing = self.runs.iter().filter_map(|(run, difference)| Some((run, difference.as_ref()?)));
        let (run, difference) = differing.next()?;
        let (differing, count) = (1 + differing.count(), self.runs.len());
        Some(format!(
            "run {run}: {difference}; {differing} of {count} repeated runs differ: an FMU keeps state across a reset, so rows of \
             the table may be wrong: repeat the study with --new-instances, and report this to the FMU's vendor"
        ))
    }
}

/// Writes the result files next to their table, replacing older ones.
fn write(out: &Path, options: &Options, report: &Report) -> Result<()> {
    // Only replace the table of an older study, not just any file with this name.
    let has_older = out.join("summary.json").is_file();
    if let Err(error) = study::clear(&out.join("pictures"), report::is_picture) {
        tell::warning(&format!("older pictures could not be removed: {error:#}"));
    }
    for problem in report::write(out, report)? {
        tell::warning(&problem);
    }
    if let Some(file) = &options.junit {
        junit::write(file, report)?;
    }
    // Done last: until then, the older summary still has its table, and --resume can continue.
    for old in Format::value_variants().iter().map(|format| format.file(out)) {
        if has_older && old != options.format.file(out) && old.exists() {
            fs::remove_file(&old).with_context(|| old.display().to_string())?;
        }
    }
    Ok(())
}

/// Fails if all runs failed or an expectation is not met, and warns if some runs failed. The report contains the
/// details.
fn judge(results: &Results, verdicts: &[(Expectation, Verdict)]) -> Result<()> {
    let (count, failed) = (results.count(), results.errors.len() as u64);
    if let Some((run, error)) = results.errors.first_key_value() {
        let said = format!("{failed} of {count} runs failed; the first is run {run}: {error}");
        ensure!(failed < count, "{said}");
        tell::warning(&said);
    }
    let problems = verdicts.iter().filter_map(|(expectation, verdict)| {
        let problem = verdict.problem.as_ref()?;
        Some(format!("{}: {problem}", expectation.text))
    });
    let problems: Vec<_> = problems.collect();
    ensure!(problems.is_empty(), "{}", problems.join("; "));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_runs_are_counted_through() {
        let missing = Missing::new(vec![3..5, 9..10, 20..30]);
        assert_eq!(missing.count, 13);
        let runs: Vec<_> = (0..5).map(|place| missing.run(place)).collect();
        assert_eq!(runs, [3, 4, 9, 20, 21]);
    }

    #[test]
    fn a_run_that_is_another_one_with_new_instances_is_told() {
        let quantity = |name: &str| study::results::Quantity::new(name, None);
        let mut results = Results::new(Vec::new(), vec![quantity("rise"), quantity("iae")]);
        results.push(&[], &RunResult { figures: vec![f64::NAN, 1.5], error: None }).unwrap();
        results.push(&[], &RunResult { figures: vec![2.0, 1.5], error: None }).unwrap();
        let mut again = Again { results: &results, runs: BTreeMap::new() };
        again.compare(0, &[f64::NAN, 1.5]).unwrap();
        assert_eq!(again.warning(), None);
        again.compare(1, &[2.0, 0.1]).unwrap();
        let warning = again.warning().unwrap();
        let said =
            "run 1: iae is 1.5 in the table, but 0.1 when repeated with new instances; 1 of 2 repeated runs differ:";
        assert!(warning.starts_with(said) && warning.contains("--new-instances"), "{warning}");
        again.compare(0, &[2.0, 1.5]).unwrap();
        let warning = again.warning().unwrap();
        assert!(
            warning.starts_with("run 0: rise is no value in the table, but 2.0 when repeated with new instances;"),
            "{warning}"
        );
    }

    #[test]
    fn a_range_of_runs_is_not_empty() {
        assert_eq!(range("5..9"), Ok(5..9));
        for wrong in ["5", "9..5", "5..5", "a..b", ".."] {
            range(wrong).unwrap_err();
        }
    }
}
