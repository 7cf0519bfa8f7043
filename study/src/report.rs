//! Renders the results of a study: an HTML page, a JSON file, pictures, and the text that the command prints. None of
//! these depends on when or where the runs were executed, so that the same study yields the same bytes everywhere.

mod what;

use crate::envelope::Envelope;
use crate::expect::{Expectation, MOST_RUNS, Of, Verdict, instead, runs_text, with_unit};
use crate::finished::RunsTable;
use crate::interval;
use crate::pictures::{self, Coordinate};
use crate::ran::Ran;
use crate::results::{Aspect, Quantity, Results};
use crate::sobol::{self, Index};
use crate::summary::{Distribution, PERCENTS, Summary};
use crate::{Along, Axis, Correlation, Job, Sampling, Signals};
use anyhow::{Context, Result};
use askama::Template;
use control::figures::Set;
use draw::histogram::Mark;
use draw::picture;
use host::package::temporary;
use modeldescription::digits::{short, within};
use modeldescription::units;
use run::bail_at;
use run::master::Recording;
use serde::{Serialize, Serializer};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write as _;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::path::Path;
use std::thread;
use what::{AxisPart, RanPart, axis_part, correlation_text, is_sampled};

/// The number of worst runs shown for figures other than the main one, and of runs listed with a failure or a missing
/// figure.
const FEW_RUNS: usize = 3;

/// The contents of a report.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The study's name.
    pub name: &'a str,
    /// The job that was run.
    pub job: &'a Job,
    /// The fingerprint of everything that the results depend on, from [`fingerprint`](super::fingerprint).
    pub fingerprint: &'a str,
    /// The file with the table of runs.
    pub table: &'a RunsTable,
    /// The properties common to all runs.
    pub ran: &'a Ran,
    /// The loop's signals, `FMU.VARIABLE`.
    pub signals: &'a Signals,
    /// The disturbances of the loop.
    pub disturbances: &'a [Set],
    /// The results of the runs.
    pub results: &'a Results,
    /// The summary of the results.
    pub summary: &'a Summary,
    /// The index of the main figure among the figures, from [`main_figure`].
    pub main: Option<usize>,
    /// The expectations, with their verdicts.
    pub verdicts: &'a [(Expectation, Verdict)],
    /// The recordings of runs, each with the index of its run: at least those of [`curves_wanted`] that could be
    /// recorded.
    pub curves: &'a [(u64, Recording)],
    /// The envelope of the process value, if there is one.
    pub envelope: Option<&'a Envelope>,
}

/// The index of the figure used for selecting curves and colouring points: the one chosen by the study, else `iae`,
/// else the first. `None` if there are no figures.
///
/// # Errors
/// The figure chosen by the study does not exist.
pub fn main_figure(job: &Job, figures: &[Quantity]) -> Result<Option<usize>> {
    let find = |name: &str| figures.iter().position(|figure| figure.name == name);
    let Some(main) = &job.study.main else {
        return Ok(find("iae").or((!figures.is_empty()).then_some(0)));
    };
    if let Some(figure) = find(main) {
        return Ok(Some(figure));
    }
    bail_at!("main", "main = {main:?}: the study has no such figure; {}", instead(main, figures))
}

/// The runs whose curves a report shows, without duplicates: the worst, the median and the best.
pub fn curves_wanted(summary: &Summary, main: Option<usize>) -> Vec<u64> {
    let mut wanted = Vec::new();
    for (_, run) in main.map(|main| chosen(&summary.figures[main])).unwrap_or_default() {
        if !wanted.contains(&run) {
            wanted.push(run);
        }
    }
    wanted
}

/// The runs whose curves are drawn, each with its word: the worst, the median and the best; some may be the same run.
fn chosen(of: &Distribution) -> Vec<(&'static str, u64)> {
    let named = [("worst", of.worst.first().copied()), ("median", of.middle), ("best", of.best)];
    named.into_iter().filter_map(|(name, run)| Some((name, run?))).collect()
}

/// Writes `summary.json`, `summary.html` and the folder `pictures`, each file via a temporary one that is renamed.
/// Returns a sentence for each picture that could not be drawn or written, which is not an error.
///
/// # Errors
/// `summary.json` or `summary.html` cannot be written.
pub fn write(folder: &Path, report: &Report) -> Result<Vec<String>> {
    let (pictures, mut problems) = pictures(report)?;
    let place = |path: &Path, content: &[u8]| temporary::place(path, |to| Ok(to.write_all(content)?), |_| Ok(()));
    place(&folder.join("summary.json"), json(report)?.as_bytes())?;
    place(&folder.join("summary.html"), html(report, &pictures)?.as_bytes())?;
    for (picture, png) in pictures.iter().zip(drawn(&pictures)) {
        let path = |ending: &str| folder.join("pictures").join(format!("{}.{ending}", picture.name));
        let png = png.with_context(|| format!("no {}", path("png").display()));
        let written = [place(&path("svg"), picture.svg.as_bytes()), png.and_then(|png| place(&path("png"), &png))];
        problems.extend(written.into_iter().filter_map(Result::err).map(|error| format!("{error:#}")));
    }
    Ok(problems)
}

/// Renders each picture as PNG. This is the slowest part of a report, so it uses all cores.
fn drawn(pictures: &[Picture]) -> Vec<Result<Vec<u8>>> {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let draw = |part: &[Picture]| part.iter().map(|picture| picture::png(&picture.svg)).collect::<Vec<_>>();
    thread::scope(|scope| {
        let parts = pictures.chunks(pictures.len().div_ceil(cores).max(1));
        let threads: Vec<_> = parts.map(|part| scope.spawn(move || draw(part))).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}

/// A picture of a report.
struct Picture {
    /// Its file name without extension.
    name: String,
    /// For a histogram, the index of its figure.
    figure: Option<usize>,
    svg: String,
}

/// All pictures that can be drawn: curves, tornado chart and scatter plot of the main figure, then the histograms. Also
/// a sentence for each picture that cannot be drawn.
fn pictures(report: &Report) -> Result<(Vec<Picture>, Vec<String>)> {
    let mut drawn: Vec<(String, Option<usize>, Result<Option<String>>)> = Vec::new();
    if let Some(main) = report.main {
        let of = &report.summary.figures[main];
        let recording = |run: u64| report.curves.iter().find(|(of, _)| *of == run).map(|(_, recording)| recording);
        let mut runs: Vec<(&str, u64, &Recording)> = Vec::new();
        for (word, run) in chosen(of) {
            if let Some(recording) = recording(run).filter(|_| runs.iter().all(|(_, of, _)| *of != run)) {
                runs.push((word, run, recording));
            }
        }
        let values = runs.iter().map(|(_, run, _)| report.value(main, *run));
        let values = values.collect::<Result<Vec<f64>>>()?;
        let absent = report.results.figure(main)?.iter().filter(|value| value.is_nan()).count() as u64;
        let window = report.job.study.window;
        let svg = pictures::curves(
            report.signals,
            (window, report.disturbances),
            (of, &values, [absent, report.summary.runs]),
            &runs,
            report.results.loops.as_ref(),
            report.envelope,
        );
        drawn.push(("curves".to_string(), None, svg));
        let tornado = pictures::tornado(report.results, report.summary, main);
        drawn.push(("tornado".into(), None, tornado));
        drawn.push((
            "scatter".into(),
            None,
            pictures::scatter(report.results, report.summary, main, &coordinates(report)),
        ));
    }
    for (column, of) in report.summary.figures.iter().enumerate() {
        let values = report.results.figure(column)?;
        let svg = pictures::histogram(report.summary, column, &values, &limits(report, column));
        drawn.push((format!("histogram_{}", file_name(&of.figure.name)), Some(column), svg));
    }
    let (mut names, mut problems) = (BTreeSet::new(), Vec::new());
    let picture = |(mut name, figure, svg): (String, Option<usize>, Result<Option<String>>)| {
        // Two names may differ only in characters that file names cannot contain.
        while !names.insert(name.to_lowercase()) {
            name.push('_');
        }
        let svg = svg.unwrap_or_else(|error| {
            problems.push(format!("no picture {name}: {error:#}"));
            None
        });
        Some(Picture { name, figure, svg: svg? })
    };
    let pictures = drawn.into_iter().filter_map(picture).collect();
    Ok((pictures, problems))
}

/// The bounds that a figure is expected to respect in each run.
fn limits(report: &Report, figure: usize) -> Vec<Mark> {
    let own = report.verdicts.iter().filter(|(of, _)| of.figure == figure && of.of == Of::Each);
    own.map(|(of, _)| Mark { at: of.bound, text: of.text.clone(), is_limit: true }).collect()
}

/// How each coordinate is drawn as an axis.
fn coordinates(report: &Report) -> Vec<Coordinate> {
    let has_ratios = |along: &Along| matches!(along, Along::Range { logarithmic: true, .. } | Along::LogNormal { .. });
    let coordinate = |of: &Quantity| {
        // A value set later is named FMU.VARIABLE@SECONDS.
        let name = of.name.split('@').next().unwrap_or_default();
        let is_own = |axis: &&Axis| axis.variables.iter().any(|of| of == name);
        let axes = report.job.study.axes.iter().filter(is_own);
        Coordinate {
            is_logarithmic: axes.clone().any(|axis| has_ratios(&axis.along)),
            is_listed: axes.clone().next().is_some() && axes.clone().all(|axis| !is_sampled(&axis.along)),
        }
    };
    report.results.coordinates.iter().map(coordinate).collect()
}

/// A name that is valid in every file system.
fn file_name(name: &str) -> String {
    let kept = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '.' | '-' | '_');
    name.chars().map(|letter| if kept(letter) { letter } else { '_' }).collect()
}

/// A string without the control characters that XML and HTML forbid.
pub(crate) fn printable(text: &str) -> String {
    let is_forbidden = |letter: char| {
        letter.is_control() && !matches!(letter, '\n' | '\t') || matches!(letter, '\u{fffe}' | '\u{ffff}')
    };
    text.chars().map(|letter| if is_forbidden(letter) { '\u{fffd}' } else { letter }).collect()
}

/// A string as displayed on the page: without forbidden control characters, and with units as in the pictures, such as
/// °C.
fn seen(text: &str) -> String {
    printable(&units::shown(text))
}

/// A list of at most ten runs, each with a remark and its settings; `count` is the total number of such runs.
pub(crate) fn listed(results: &Results, count: usize, runs: impl Iterator<Item = (u64, String)>) -> Result<String> {
    let mut text = String::new();
    for (run, reason) in runs.take(MOST_RUNS) {
        let line_end = if text.is_empty() { "" } else { "\n" };
        let _ = write!(text, "{line_end}run {run}: {reason}");
        if !results.coordinates.is_empty() {
            let of = results.loops.as_ref().map_or_else(String::new, |loops| format!("{}: ", loops.name(run)));
            let _ = write!(text, "\n    {of}{}", settings(results, run)?);
        }
    }
    let more = count.saturating_sub(MOST_RUNS);
    if more > 0 {
        let _ = write!(text, "\nand {more} more");
    }
    Ok(text)
}

/// Whether a file with this name is a picture of a study.
pub fn is_picture(name: &str) -> bool {
    let stem = name.strip_suffix(".svg").or_else(|| name.strip_suffix(".png"));
    stem.is_some_and(|stem| ["curves", "scatter", "tornado"].contains(&stem) || stem.starts_with("histogram_"))
}

/// The settings of a run: `FURNACE.GAIN = 1.2, PID.TI = 20 s`.
fn settings(results: &Results, run: u64) -> Result<String> {
    let setting = |(of, value): (&Quantity, f64)| format!("{} = {}", of.name, with_unit(value, of));
    Ok(results.coordinates.iter().zip(results.point(run)?).map(setting).collect::<Vec<_>>().join(", "))
}

/// Lists the given runs, and how many of `count` are not listed: `run 1`, `runs 1, 2, 3 and 7 more`.
fn numbers(runs: &[u64], count: u64) -> String {
    let named = runs.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
    let run = if count == 1 { "run" } else { "runs" };
    match count - runs.len() as u64 {
        0 => format!("{run} {named}"),
        more => format!("{run} {named} and {more} more"),
    }
}

impl Report<'_> {
    /// The share of `hits` among all runs, with a confidence interval if the runs are independent samples.
    fn share(&self, of: &str, hits: u64) -> Yield {
        let runs = self.summary.runs;
        let interval = if self.job.study.is_independent() { interval::share(hits, runs) } else { None };
        Yield { of: of.into(), hits, share: hits as f64 / runs.max(1) as f64, interval }
    }

    /// The value of a figure in a run.
    fn value(&self, figure: usize, run: u64) -> Result<f64> {
        Ok(self.results.figures_of(run)?[figure])
    }

    /// For each variable with limits, the share of runs in which it stays within them.
    fn yields(&self) -> Result<Vec<Yield>> {
        let figures = self.results.figures.iter().enumerate();
        let of = figures.filter_map(|(column, of)| match &of.of {
            Some((variable, Aspect::Violation)) => Some((column, variable)),
            _ => None,
        });
        of.map(|(column, name)| {
            let hits = self.results.figure(column)?.iter().filter(|time| **time == 0.0).count() as u64;
            Ok(self.share(&format!("{name} within its limits"), hits))
        })
        .collect()
    }

    /// The Sobol indices of a figure for each axis with a distribution; `None` if the study is not sampled for them, or
    /// if [`sobol::indices`] cannot compute them.
    fn indices(&self, figure: usize) -> Result<Option<Vec<(String, Index)>>> {
        let study = &self.job.study;
        if study.sampling != Sampling::Saltelli {
            return Ok(None);
        }
        let names = study.axes.iter().filter(|axis| is_sampled(&axis.along)).map(|axis| axis.variables.join(", "));
        let names: Vec<String> = names.collect();
        let indices = sobol::indices(self.results, figure, names.len())?;
        Ok(indices.map(|indices| names.into_iter().zip(indices).collect()))
    }

    /// A sentence about the runs that failed; `None` if none failed.
    pub(crate) fn failure_text(&self) -> Option<String> {
        let summary = self.summary;
        let first = summary.failures.first()?;
        let most = if summary.failures.len() == 1 { "" } else { "most frequent reason: " };
        let text = format!("{} of {} failed: {most}{}", summary.failed, runs_text(summary.runs), first.reason);
        Some(printable(&text))
    }
}

/// The output of the command: the percentiles, the failures and the verdicts.
///
/// # Errors
/// The results of a large study cannot be read.
pub fn text(report: &Report) -> Result<String> {
    let summary = report.summary;
    let mut text = format!("{}: {}", report.name, runs_text(summary.runs));
    if summary.failed > 0 {
        let _ = write!(text, ", {} failed", summary.failed);
    }
    text.push('\n');
    let mut rows = vec![["", "5 %", "median", "95 %", "worst", "run"].map(str::to_string)];
    for (column, of) in summary.figures.iter().enumerate() {
        let percent =
            |wanted: f64| of.percentiles.iter().find(|(percent, _)| *percent == wanted).map(|(_, value)| *value);
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_string(), |value| number(of, value));
        let worst = of.worst.first();
        let value = worst.map(|run| report.value(column, *run)).transpose()?;
        rows.push([
            pictures::axis(&of.figure),
            number(percent(5.0)),
            number(percent(50.0)),
            number(percent(95.0)),
            number(value),
            worst.map_or_else(|| "-".into(), u64::to_string),
        ]);
    }
    write_table(&mut text, &rows);
    let intervals = intervals(report);
    let has_one = |cells: &[String; 3]| cells.iter().any(|cell| cell != TOO_FEW);
    if intervals.iter().any(|(_, cells)| has_one(cells)) {
        let head = ["95 % confidence interval", "5 %", "median", "95 %"].map(str::to_string);
        let rows = intervals.into_iter().map(|(figure, [low, middle, high])| [figure, low, middle, high]);
        write_table(&mut text, &[head].into_iter().chain(rows).collect::<Vec<_>>());
    } else if !intervals.is_empty() {
        let _ = writeln!(text, "  {TOO_FEW} for 95 % confidence intervals");
    }
    for column in 0..summary.figures.len() {
        for sentence in absent_texts(report, column)? {
            let _ = writeln!(text, "  {sentence}");
        }
    }
    for failure in &summary.failures {
        let runs = &failure.runs[..failure.runs.len().min(FEW_RUNS)];
        let _ = writeln!(text, "  failed: {}: {}", numbers(runs, failure.count), failure.reason);
    }
    for of in report.yields()? {
        let _ = writeln!(text, "  {}: {} of the runs", of.of, of.text());
    }
    for (expectation, verdict) in report.verdicts {
        match &verdict.problem {
            None => {
                let _ = writeln!(text, "met: {expectation}");
            }
            Some(problem) => {
                let judged = if verdict.is_undecided { "undecided" } else { "not met" };
                let _ = writeln!(text, "{judged}: {expectation}: {problem}");
                if let Some(hits) = verdict.hits {
                    let _ = writeln!(text, "    {} of the runs meet it", report.share("", hits).text());
                }
                for line in listed(report.results, verdict.count, verdict.offending.iter().cloned())?.lines() {
                    let _ = writeln!(text, "    {line}");
                }
            }
        }
    }
    Ok(printable(&text))
}

/// Writes rows of cells, the first column left-aligned, the others right-aligned.
fn write_table<const N: usize>(text: &mut String, rows: &[[String; N]]) {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    for row in rows {
        let _ = write!(text, "  {:<1$}", row[0], widths[0]);
        for (cell, width) in row.iter().zip(widths).skip(1) {
            let _ = write!(text, "  {cell:>width$}");
        }
        text.push('\n');
    }
}

/// A figure's value in a table: with as many digits as its spread justifies, at most six.
fn number(of: &Distribution, value: f64) -> String {
    shorter(pictures::told_bare(of, value), short(value))
}

fn shorter(one: String, other: String) -> String {
    if other.len() < one.len() { other } else { one }
}

/// Sentences about the runs that lack a figure although they did not fail, and about those in which the figure is
/// infinite: neither are included in the statistics.
fn absent_texts(report: &Report, column: usize) -> Result<Vec<String>> {
    let (summary, of) = (report.summary, &report.summary.figures[column]);
    let values = report.results.figure(column)?;
    let infinite = (0..).zip(values.iter()).filter(|(_, value)| value.is_infinite());
    let infinite: Vec<u64> = infinite.map(|(run, _)| run).collect();
    let have = |count: u64| if count == 1 { "has" } else { "have" };
    let sentence = |count: u64, runs: &[u64], what: String| {
        let runs = numbers(&runs[..runs.len().min(FEW_RUNS)], count);
        format!("{} {} {what}: {runs}", runs_text(count), have(count))
    };
    let (without, count) = (summary.runs - summary.failed - of.count, infinite.len() as u64);
    let name = &of.figure.name;
    let absent = (without > count).then(|| sentence(without - count, &of.absent, format!("no {name}")));
    let infinite =
        (count > 0).then(|| sentence(count, &infinite, format!("an infinite {name}, excluded from the statistics")));
    Ok(absent.into_iter().chain(infinite).collect())
}

/// Ordered pairs of name and value, serialized as an object.
struct Pairs<T>(Vec<(String, T)>);

impl<T: Serialize> Serialize for Pairs<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

/// The share of runs that meet a condition.
#[derive(Debug, Serialize)]
struct Yield {
    /// The condition, as displayed.
    #[serde(skip)]
    of: String,
    /// The number of these runs.
    hits: u64,
    /// Their share of all runs, from 0 to 1.
    share: f64,
    /// The 95 % confidence interval of the share in the population from which the runs were sampled; only for
    /// independent samples.
    interval: Option<(f64, f64)>,
}

impl Yield {
    /// `95.29 % (94.86 to 95.69 %)`
    fn text(&self) -> String {
        let percent = |share: f64| short((share * 1e4).round() / 1e2);
        let share = percent(self.share);
        match self.interval {
            Some((low, high)) => format!("{share} % ({} to {} %)", percent(low), percent(high)),
            None => format!("{share} %"),
        }
    }
}

/// The contents of `summary.json`.
#[derive(Serialize)]
struct Document<'a> {
    study: &'a str,
    fingerprint: &'a str,
    #[serde(flatten)]
    ran: &'a Ran,
    table: &'a RunsTable,
    runs: u64,
    failed: u64,
    failures: &'a [crate::summary::Failure],
    axes: &'a [Axis],
    /// The rank correlations between distributions.
    #[serde(skip_serializing_if = "<[Correlation]>::is_empty")]
    correlations: &'a [Correlation],
    samples: u64,
    seed: u64,
    sampling: Sampling,
    coordinates: &'a [Quantity],
    main: Option<&'a str>,
    figures: Vec<FigureDocument<'a>>,
    expectations: Vec<ExpectationDocument<'a>>,
    /// For each variable with limits, the share of runs in which it stays within them.
    limits: Vec<Yield>,
}

#[derive(Serialize)]
struct FigureDocument<'a> {
    name: &'a str,
    unit: Option<&'a str>,
    /// The number of runs with a finite value.
    count: u64,
    min: Option<f64>,
    percentiles: Pairs<f64>,
    /// The 95 % confidence intervals of the percentiles of the population from which the runs were sampled; only for
    /// independent samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    intervals: Option<Pairs<Option<(f64, f64)>>>,
    max: Option<f64>,
    mean: Option<f64>,
    deviation: Option<f64>,
    /// Spearman's rank correlation with each coordinate.
    correlations: Pairs<Option<f64>>,
    /// The Sobol indices of each axis with a distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    sobol: Option<Pairs<Index>>,
    best: Option<RunDocument>,
    median: Option<RunDocument>,
    worst: Vec<RunDocument>,
    /// The first runs that lack the figure although they did not fail.
    absent: &'a [u64],
}

#[derive(Serialize)]
struct RunDocument {
    run: u64,
    value: f64,
    settings: Pairs<f64>,
}

#[derive(Serialize)]
struct ExpectationDocument<'a> {
    expectation: &'a str,
    met: bool,
    /// Whether there are too few runs to decide whether it is met.
    undecided: bool,
    /// The confidence interval of a percentile of samples; null for an end with too few runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    interval: Option<(f64, f64)>,
    problem: Option<&'a str>,
    /// The share of runs that meet it, if it is about each run.
    #[serde(flatten)]
    share: Option<Yield>,
    /// The number of runs that do not meet it.
    count: usize,
    /// At most ten of these runs.
    runs: Vec<OffendingDocument>,
}

#[derive(Serialize)]
struct OffendingDocument {
    run: u64,
    reason: String,
    settings: Pairs<f64>,
}

/// Renders `summary.json`.
fn json(report: &Report) -> Result<String> {
    let (study, summary, results) = (&report.job.study, report.summary, report.results);
    let settings = |run: u64| -> Result<Pairs<f64>> {
        let names = results.coordinates.iter().map(|of| of.name.clone());
        Ok(Pairs(names.zip(results.point(run)?).collect()))
    };
    let figure = |column: usize| -> Result<FigureDocument> {
        let of = &summary.figures[column];
        let document = |run: u64| -> Result<RunDocument> {
            Ok(RunDocument { run, value: report.value(column, run)?, settings: settings(run)? })
        };
        let correlations = summary.coordinates.iter().map(|of| of.name.clone()).zip(of.correlations.iter().copied());
        Ok(FigureDocument {
            name: &of.figure.name,
            unit: of.figure.unit.as_deref(),
            count: of.count,
            min: of.min,
            percentiles: Pairs(of.percentiles.iter().map(|(percent, value)| (format!("p{percent}"), *value)).collect()),
            intervals: report.job.study.is_independent().then(|| {
                let intervals = of.percentiles.iter().zip(&of.intervals);
                Pairs(intervals.map(|((percent, _), interval)| (format!("p{percent}"), *interval)).collect())
            }),
            max: of.max,
            mean: of.mean,
            deviation: of.deviation,
            correlations: Pairs(correlations.collect()),
            sobol: report.indices(column)?.map(Pairs),
            best: of.best.map(document).transpose()?,
            median: of.middle.map(document).transpose()?,
            worst: of.worst.iter().copied().map(document).collect::<Result<_>>()?,
            absent: &of.absent,
        })
    };
    let expectation = |number: usize| -> Result<ExpectationDocument> {
        let (of, verdict) = &report.verdicts[number];
        let offending = |(run, reason): &(u64, String)| -> Result<OffendingDocument> {
            Ok(OffendingDocument { run: *run, reason: reason.clone(), settings: settings(*run)? })
        };
        Ok(ExpectationDocument {
            expectation: &of.text,
            met: verdict.problem.is_none(),
            undecided: verdict.is_undecided,
            interval: verdict.interval,
            problem: verdict.problem.as_deref(),
            share: verdict.hits.map(|hits| report.share(&of.text, hits)),
            count: verdict.count,
            runs: verdict.offending.iter().map(offending).collect::<Result<_>>()?,
        })
    };
    let document = Document {
        study: report.name,
        fingerprint: report.fingerprint,
        ran: report.ran,
        table: report.table,
        runs: summary.runs,
        failed: summary.failed,
        failures: &summary.failures,
        axes: &study.axes,
        correlations: &study.correlations,
        samples: study.samples,
        seed: study.seed,
        sampling: study.sampling,
        coordinates: &summary.coordinates,
        main: report.main.map(|main| summary.figures[main].figure.name.as_str()),
        figures: (0..summary.figures.len()).map(figure).collect::<Result<_>>()?,
        expectations: (0..report.verdicts.len()).map(expectation).collect::<Result<_>>()?,
        limits: report.yields()?,
    };
    let mut text = serde_json::to_string_pretty(&document).context("the summary cannot be written as JSON")?;
    text.push('\n');
    Ok(text)
}

/// The contents of the page.
#[derive(Template)]
#[template(path = "summary.html")]
struct Page<'a> {
    name: String,
    /// A sentence with the number of runs and of failed runs.
    about: String,
    expectations: Vec<ExpectationPart>,
    /// The SVG drawings of the main figure.
    pictures: Vec<&'a str>,
    main: Option<String>,
    /// A sentence if the main figure has the same value in all runs.
    constant: Option<String>,
    axes: Vec<AxisPart>,
    /// The correlations between axes.
    correlations: Option<String>,
    sampling: Option<String>,
    percents: Vec<String>,
    figures: Vec<FigurePart<'a>>,
    coordinates: Vec<String>,
    /// The variables with limits, and the shares of runs within them.
    yields: Vec<(String, String)>,
    /// For each figure, the intervals of the percentiles 5, 50 and 95.
    intervals: Vec<(String, [String; 3])>,
    /// Whether the shares have confidence intervals.
    is_independent: bool,
    /// The names of the axes with Sobol indices, and for each figure a row with the indices of these axes.
    index_names: Vec<String>,
    indices: Vec<IndexRow>,
    /// Whether any figure has a rank correlation with a coordinate.
    has_influence: bool,
    failures: Vec<(String, String)>,
    ran: RanPart<'a>,
}

struct ExpectationPart {
    text: String,
    share: String,
    judged: &'static str,
    problem: String,
    runs: String,
}

struct FigurePart<'a> {
    name: String,
    anchor: String,
    title: String,
    count: u64,
    /// Minimum, percentiles, maximum, mean, standard deviation.
    numbers: Vec<String>,
    correlations: Vec<String>,
    absent: Vec<String>,
    histogram: Option<&'a str>,
    /// The worst runs: number, figure, settings.
    worst: Vec<(u64, String, Vec<String>)>,
    is_lower_better: bool,
}

/// Renders `summary.html`.
fn html(report: &Report, pictures: &[Picture]) -> Result<String> {
    let (study, summary, results) = (&report.job.study, report.summary, report.results);
    let mut about = runs_text(summary.runs);
    let failed = match summary.failed {
        0 => "; none failed.".to_string(),
        failed => format!("; {failed} failed."),
    };
    about.push_str(&failed);
    let expectation = |(of, verdict): &(Expectation, Verdict)| -> Result<ExpectationPart> {
        let runs = listed(results, verdict.count, verdict.offending.iter().cloned())?;
        Ok(ExpectationPart {
            text: printable(&of.text),
            judged: match (&verdict.problem, verdict.is_undecided) {
                (None, _) => "met",
                (Some(_), true) => "undecided",
                (Some(_), false) => "not met",
            },
            share: verdict.hits.map_or_else(String::new, |hits| report.share("", hits).text()),
            problem: match (&verdict.problem, of.of) {
                (Some(problem), _) => seen(problem),
                (None, Of::Each) => "every run meets it".into(),
                (None, _) => String::new(),
            },
            runs: seen(&runs),
        })
    };
    let figure = |(column, of): (usize, &Distribution)| -> Result<FigurePart> {
        let row = |run: &u64| -> Result<_> {
            let cells = results.point(*run)?.into_iter().map(short).collect();
            Ok((*run, number(of, report.value(column, *run)?), cells))
        };
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| number(of, value));
        let percentiles = of.percentiles.iter().map(|(_, value)| Some(*value));
        let percentiles: Vec<Option<f64>> = percentiles.chain(std::iter::repeat(None)).take(PERCENTS.len()).collect();
        let all = [of.min].into_iter().chain(percentiles).chain([of.max, of.mean, of.deviation]);
        let most = if report.main == Some(column) { MOST_RUNS } else { FEW_RUNS };
        let worst = of.worst.iter().take(most);
        let histogram = pictures.iter().find(|picture| picture.figure == Some(column));
        Ok(FigurePart {
            name: printable(&of.figure.name),
            anchor: format!("figure-{column}"),
            title: seen(&pictures::axis(&of.figure)),
            count: of.count,
            numbers: all.map(number).collect(),
            correlations: of
                .correlations
                .iter()
                .map(|correlation| correlation.map_or_else(String::new, |correlation| format!("{correlation:.2}")))
                .collect(),
            absent: absent_texts(report, column)?,
            histogram: histogram.map(|picture| picture.svg.as_str()),
            worst: worst.map(row).collect::<Result<_>>()?,
            is_lower_better: of.figure.is_lower_better(),
        })
    };
    let failures = summary.failures.iter().map(|of| (numbers(&of.runs, of.count), printable(&of.reason)));
    let has_samples = study.axes.iter().any(|axis| is_sampled(&axis.along));
    let sampling = match study.sampling {
        Sampling::Random => "at random",
        Sampling::LatinHypercube => "as a Latin hypercube",
        Sampling::Sobol => "as a Sobol sequence",
        Sampling::Saltelli => "as a Sobol sequence for Sobol indices",
    };
    let index_names = (0..summary.figures.len()).find_map(|column| report.indices(column).transpose());
    let index_names = index_names.transpose()?.unwrap_or_default();
    let page = Page {
        name: printable(report.name),
        about,
        expectations: report.verdicts.iter().map(expectation).collect::<Result<_>>()?,
        pictures: pictures.iter().filter(|of| of.figure.is_none()).map(|of| of.svg.as_str()).collect(),
        main: report.main.map(|main| printable(&summary.figures[main].figure.name)),
        constant: report.main.and_then(|main| pictures::constant(&summary.figures[main])).map(|text| seen(&text)),
        axes: study.axes.iter().map(axis_part).collect(),
        correlations: correlation_text(&study.correlations),
        sampling: has_samples.then(|| format!("{} samples {sampling}, seed {}.", study.samples, study.seed)),
        percents: PERCENTS.iter().map(|percent| format!("{percent} %")).collect(),
        yields: report.yields()?.iter().map(|of| (printable(&of.of), of.text())).collect(),
        intervals: intervals(report).into_iter().map(|(figure, cells)| (seen(&figure), cells)).collect(),
        is_independent: report.job.study.is_independent(),
        index_names: index_names.into_iter().map(|(name, _)| printable(&name)).collect(),
        indices: indices(report)?,
        figures: summary.figures.iter().enumerate().map(figure).collect::<Result<_>>()?,
        has_influence: summary.figures.iter().any(|of| of.correlations.iter().any(Option::is_some)),
        coordinates: summary.coordinates.iter().map(|of| seen(&pictures::axis(of))).collect(),
        failures: failures.collect(),
        ran: RanPart::new(report),
    };
    Ok(page.render()?)
}

/// Shown instead of a confidence interval.
const TOO_FEW: &str = "too few runs";

/// For each figure, the confidence intervals of the percentiles 5, 50 and 95; empty unless the runs are independent
/// samples.
fn intervals(report: &Report) -> Vec<(String, [String; 3])> {
    let row = |of: &Distribution| {
        let cells = interval_cells(of).map(|cell| cell.unwrap_or_else(|| TOO_FEW.into()));
        (pictures::axis(&of.figure), cells)
    };
    let figures = report.summary.figures.iter().filter(|of| of.count > 0);
    if report.job.study.is_independent() { figures.map(row).collect() } else { Vec::new() }
}

/// The confidence intervals of the percentiles 5, 50 and 95; `None` for those with too few runs.
fn interval_cells(of: &Distribution) -> [Option<String>; 3] {
    [5.0, 50.0, 95.0].map(|wanted| {
        let place = PERCENTS.iter().position(|percent| *percent == wanted)?;
        let (low, high) = (*of.intervals.get(place)?)?;
        // Round by the width of the interval: rounded by the figure's spread, both ends might become the same number.
        let ends = [low, high].map(|end| shorter(within(end, high - low), short(end)));
        let ends = if ends[0] == ends[1] { [low, high].map(|end| within(end, high - low)) } else { ends };
        Some(ends.join(" to "))
    })
}

/// A figure and, for each axis, its first-order and total index.
type IndexRow = (String, Vec<(String, String)>);

/// The first-order and total Sobol indices for each axis, for each figure that varies.
fn indices(report: &Report) -> Result<Vec<IndexRow>> {
    let cell = |value: f64, error: f64| format!("{value:.2} ± {error:.2}");
    let cells = |of: Index| (cell(of.first, of.first_error), cell(of.total, of.total_error));
    let row = |(column, of): (usize, &Distribution)| {
        let row = |indices: Vec<(String, Index)>| {
            (printable(&of.figure.name), indices.into_iter().map(|(_, of)| cells(of)).collect())
        };
        report.indices(column).map(|indices| indices.map(row)).transpose()
    };
    report.summary.figures.iter().enumerate().filter_map(row).collect()
}

#[cfg(test)]
pub(crate) mod tests;
