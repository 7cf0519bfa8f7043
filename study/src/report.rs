//! What a study writes of its results: a page, a file for programs, pictures, and the text of the command. None of it says
//! when or on which machine the runs were made, so that the same study gives the same bytes everywhere.

mod what;

use crate::envelope::Envelope;
use crate::expect::{Expectation, MOST_RUNS, Of, Verdict, runs_text, with_unit};
use crate::finished::Table;
use crate::interval;
use crate::pictures::{self, Coordinate};
use crate::ran::Ran;
use crate::results::{Quantity, Results};
use crate::sobol::{self, Index};
use crate::summary::{Distribution, PERCENTS, Summary};
use crate::{Along, Axis, Correlation, Job, Sampling, Signals};
use anyhow::{Context, Result, bail};
use askama::Template;
use control::figures::Set;
use draw::histogram::Mark;
use draw::picture;
use host::package::temporary;
use modeldescription::digits::{short, within};
use modeldescription::units;
use run::master::Recording;
use run::plan::near;
use serde::{Serialize, Serializer};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write as _;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::path::Path;
use std::thread;
use what::{AxisPart, RanPart, axis_part, correlation_text, is_sampled};

/// This many for figures that are not the main one.
const FEW_RUNS: usize = 3;

/// What a report is of.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The study's name.
    pub name: &'a str,
    /// What was run.
    pub job: &'a Job,
    /// What the results depend on, from [`fingerprint`](super::fingerprint).
    pub fingerprint: &'a str,
    /// The table with the runs.
    pub table: &'a Table,
    /// What all runs have in common.
    pub ran: &'a Ran,
    /// The loop's signals, `FMU.VARIABLE`.
    pub signals: &'a Signals,
    /// What disturbs the loop.
    pub disturbances: &'a [Set],
    /// What the runs came to.
    pub results: &'a Results,
    /// What they came to together.
    pub summary: &'a Summary,
    /// The number of the main figure's column, from [`main_figure`].
    pub main: Option<usize>,
    /// What was expected, and what came of it.
    pub verdicts: &'a [(Expectation, Verdict)],
    /// The curves of runs, at least of those that are wanted by [`curves_wanted`], by their numbers.
    pub curves: &'a [(u64, Recording)],
    /// Between which values most runs are, if that is known.
    pub envelope: Option<&'a Envelope>,
}

/// The figure by which curves are chosen and points coloured: the study's, else `iae`, else the first. None if
/// there are no figures.
///
/// # Errors
/// The study has no such figure.
pub fn main_figure(job: &Job, figures: &[Quantity]) -> Result<Option<usize>> {
    let find = |name: &str| figures.iter().position(|figure| figure.name == name);
    let Some(main) = &job.study.main else {
        return Ok(find("iae").or((!figures.is_empty()).then_some(0)));
    };
    if let Some(figure) = find(main) {
        return Ok(Some(figure));
    }
    let names = || figures.iter().map(|figure| figure.name.as_str());
    match near(main, names()) {
        Some(near) => bail!("main = {main:?}: the study has no such figure; did you mean {near}?"),
        None => {
            bail!("main = {main:?}: the study has no such figure; there are {}", names().collect::<Vec<_>>().join(", "))
        }
    }
}

/// The runs whose curves a report shows, each once: the worst, the one in the middle and the best.
pub fn curves_wanted(summary: &Summary, main: Option<usize>) -> Vec<u64> {
    let mut wanted = Vec::new();
    for (_, run) in main.map(|main| chosen(&summary.figures[main])).unwrap_or_default() {
        if !wanted.contains(&run) {
            wanted.push(run);
        }
    }
    wanted
}

/// The runs of a distribution that have a name.
fn chosen(of: &Distribution) -> Vec<(&'static str, u64)> {
    let named = [("worst", of.worst.first().copied()), ("median", of.middle), ("best", of.best)];
    named.into_iter().filter_map(|(name, run)| Some((name, run?))).collect()
}

/// Writes `summary.json`, `summary.html` and the folder `pictures`, each file beside its place and renamed. Gives a sentence for
/// each picture that cannot be drawn or written: it costs nothing but itself.
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
        let png = png.with_context(|| format!("there is no {}", path("png").display()));
        let written = [place(&path("svg"), picture.svg.as_bytes()), png.and_then(|png| place(&path("png"), &png))];
        problems.extend(written.into_iter().filter_map(Result::err).map(|error| format!("{error:#}")));
    }
    Ok(problems)
}

/// Each picture as a PNG. Nothing else in a report takes as long, so all cores draw.
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
    /// The name of its files without the ending.
    name: String,
    /// The figure that it shows the distribution of.
    figure: Option<usize>,
    svg: String,
}

/// All pictures that can be drawn: the curves and the scatter plot of the main figure, then the histograms. And a sentence for each of
/// the others.
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
        // Two names that differ in signs which a file's name cannot have.
        while !names.insert(name.to_lowercase()) {
            name.push('_');
        }
        let svg = svg.unwrap_or_else(|error| {
            problems.push(format!("there is no picture {name}: {error:#}"));
            None
        });
        Some(Picture { name, figure, svg: svg? })
    };
    let pictures = drawn.into_iter().filter_map(picture).collect();
    Ok((pictures, problems))
}

/// The bounds that are expected of each run's figure.
fn limits(report: &Report, figure: usize) -> Vec<Mark> {
    let own = report.verdicts.iter().filter(|(of, _)| of.figure == figure && of.of == Of::Each);
    own.map(|(of, _)| Mark { at: of.bound, text: of.text.clone(), is_limit: true }).collect()
}

/// How the axes of the coordinates are drawn.
fn coordinates(report: &Report) -> Vec<Coordinate> {
    let has_ratios = |along: &Along| matches!(along, Along::Range { logarithmic: true, .. } | Along::LogNormal { .. });
    let coordinate = |of: &Quantity| {
        // A value that is set later is named FMU.VARIABLE@SECONDS.
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

/// A name that every file system takes.
fn file_name(name: &str) -> String {
    let kept = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '.' | '-' | '_');
    name.chars().map(|letter| if kept(letter) { letter } else { '_' }).collect()
}

/// A text without the control characters that XML and HTML forbid.
pub(crate) fn printable(text: &str) -> String {
    let is_forbidden = |letter: char| {
        letter.is_control() && !matches!(letter, '\n' | '\t') || matches!(letter, '\u{fffe}' | '\u{ffff}')
    };
    text.chars().map(|letter| if is_forbidden(letter) { '\u{fffd}' } else { letter }).collect()
}

/// A text with units, as the page shows it: with °C, as the pictures.
fn seen(text: &str) -> String {
    printable(&units::shown(text))
}

/// The first ten of `count` runs with what is to be said of them, and their settings.
pub(crate) fn listed(results: &Results, count: usize, runs: impl Iterator<Item = (u64, String)>) -> Result<String> {
    let mut text = String::new();
    for (run, reason) in runs.take(MOST_RUNS) {
        let line_end = if text.is_empty() { "" } else { "\n" };
        let _ = write!(text, "{line_end}run {run}: {reason}");
        if !results.coordinates.is_empty() {
            let of = results.loops.as_ref().map_or_else(String::new, |loops| format!("{}: ", loops.of(run)));
            let _ = write!(text, "\n    {of}{}", settings(results, run)?);
        }
    }
    let more = count.saturating_sub(MOST_RUNS);
    if more > 0 {
        let _ = write!(text, "\nand {more} more");
    }
    Ok(text)
}

/// Whether a file has the name of a picture of a study.
pub fn is_picture(name: &str) -> bool {
    let stem = name.strip_suffix(".svg").or_else(|| name.strip_suffix(".png"));
    stem.is_some_and(|stem| ["curves", "scatter", "tornado"].contains(&stem) || stem.starts_with("histogram_"))
}

/// What a run was given: `FURNACE.GAIN = 1.2, PID.TI = 20 s`.
fn settings(results: &Results, run: u64) -> Result<String> {
    let setting = |(of, value): (&Quantity, f64)| format!("{} = {}", of.name, with_unit(value, of));
    Ok(results.coordinates.iter().zip(results.point(run)?).map(setting).collect::<Vec<_>>().join(", "))
}

/// Runs by their numbers: `run 1`, `runs 1, 2, 3 and 7 more`.
fn numbers(runs: &[u64], count: u64) -> String {
    let named = runs.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
    let run = if count == 1 { "run" } else { "runs" };
    match count - runs.len() as u64 {
        0 => format!("{run} {named}"),
        more => format!("{run} {named} and {more} more"),
    }
}

impl Report<'_> {
    /// The share of runs that meet something.
    fn share(&self, of: &str, hits: u64) -> Yield {
        let runs = self.summary.runs;
        let interval = if self.job.study.is_independent() { interval::share(hits, runs) } else { None };
        Yield { of: of.into(), hits, share: hits as f64 / runs.max(1) as f64, interval }
    }

    /// A figure of a run.
    fn value(&self, figure: usize, run: u64) -> Result<f64> {
        Ok(self.results.figures_of(run)?[figure])
    }

    /// The shares of runs whose variables stay within their limits.
    fn yields(&self) -> Result<Vec<Yield>> {
        let figures = self.results.figures.iter().enumerate();
        let of = figures.filter_map(|(column, of)| Some((column, of.name.strip_suffix(".violation")?)));
        of.map(|(column, name)| {
            let hits = self.results.figure(column)?.iter().filter(|time| **time == 0.0).count() as u64;
            Ok(self.share(&format!("{name} within its limits"), hits))
        })
        .collect()
    }

    /// Sobol's indices of a figure, by the axes with a distribution; none if the study is not made for them.
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

    /// What is wrong with the runs that failed, a sentence; none if no run failed.
    pub(crate) fn failure_text(&self) -> Option<String> {
        let summary = self.summary;
        let first = summary.failures.first()?;
        let most = if summary.failures.len() == 1 { "" } else { "most frequent reason: " };
        let text = format!("{} of {} failed: {most}{}", summary.failed, runs_text(summary.runs), first.reason);
        Some(printable(&text))
    }
}

/// What the command prints: the percentiles, what failed, and the verdicts.
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
        let head = ["with 95 % confidence", "5 %", "median", "95 %"].map(str::to_string);
        let rows = intervals.into_iter().map(|(figure, [low, middle, high])| [figure, low, middle, high]);
        write_table(&mut text, &[head].into_iter().chain(rows).collect::<Vec<_>>());
    } else if !intervals.is_empty() {
        let _ = writeln!(text, "  {TOO_FEW} for intervals with 95 % confidence");
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

/// Writes rows of cells, the first column to the left, the others to the right.
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

/// A value of a figure in a table: with the digits that its spread justifies, and six at most.
fn number(of: &Distribution, value: f64) -> String {
    shorter(pictures::told_bare(of, value), short(value))
}

fn shorter(one: String, other: String) -> String {
    if other.len() < one.len() { other } else { one }
}

/// Which runs did not fail and yet have no such figure, and in which it is infinite: neither counts in what is said of the others.
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
    let infinite = (count > 0).then(|| sentence(count, &infinite, format!("an infinite {name}, which does not count")));
    Ok(absent.into_iter().chain(infinite).collect())
}

/// Names with values, in their order.
struct Pairs<T>(Vec<(String, T)>);

impl<T: Serialize> Serialize for Pairs<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

/// The share of runs that meet something.
#[derive(Debug, Serialize)]
struct Yield {
    #[serde(skip)]
    of: String,
    /// How many they are.
    hits: u64,
    /// The share of all runs, from 0 to 1.
    share: f64,
    /// The interval that holds the share of all machines with 95 % confidence; only of independent samples.
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

/// `summary.json`.
#[derive(Serialize)]
struct Document<'a> {
    study: &'a str,
    fingerprint: &'a str,
    #[serde(flatten)]
    ran: &'a Ran,
    table: &'a Table,
    runs: u64,
    failed: u64,
    failures: &'a [crate::summary::Failure],
    axes: &'a [Axis],
    /// Which distributions depend on each other.
    #[serde(skip_serializing_if = "<[Correlation]>::is_empty")]
    correlations: &'a [Correlation],
    samples: u64,
    seed: u64,
    sampling: Sampling,
    coordinates: &'a [Quantity],
    main: Option<&'a str>,
    figures: Vec<FigureDocument<'a>>,
    expectations: Vec<ExpectationDocument<'a>>,
    /// The runs whose variable stays within its limits.
    limits: Vec<Yield>,
}

#[derive(Serialize)]
struct FigureDocument<'a> {
    name: &'a str,
    unit: Option<&'a str>,
    /// How many runs have it.
    count: u64,
    min: Option<f64>,
    percentiles: Pairs<f64>,
    /// Intervals that hold the percentiles of all machines with 95 % confidence; only of independent samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    intervals: Option<Pairs<Option<(f64, f64)>>>,
    max: Option<f64>,
    mean: Option<f64>,
    deviation: Option<f64>,
    /// Spearman's rank correlation with each coordinate.
    correlations: Pairs<Option<f64>>,
    /// Sobol's indices of each axis with a distribution.
    #[serde(skip_serializing_if = "Option::is_none")]
    sobol: Option<Pairs<Index>>,
    best: Option<RunDocument>,
    median: Option<RunDocument>,
    worst: Vec<RunDocument>,
    /// Runs without it that have not failed.
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
    /// Whether the runs are too few to decide.
    undecided: bool,
    /// Of a percentile of samples, the ends of its interval; null where there are too few runs for an end.
    #[serde(skip_serializing_if = "Option::is_none")]
    interval: Option<(f64, f64)>,
    problem: Option<&'a str>,
    /// How many meet it, if it is of each run.
    #[serde(flatten)]
    share: Option<Yield>,
    /// How many runs fail.
    count: usize,
    /// The first of them.
    runs: Vec<OffendingDocument>,
}

#[derive(Serialize)]
struct OffendingDocument {
    run: u64,
    reason: String,
    settings: Pairs<f64>,
}

/// `summary.json`.
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

/// What the page shows.
#[derive(Template)]
#[template(path = "summary.html")]
struct Page<'a> {
    name: String,
    /// How many runs, and how many of them failed.
    about: String,
    expectations: Vec<ExpectationPart>,
    /// SVG drawings of the main figure.
    pictures: Vec<&'a str>,
    main: Option<String>,
    /// That it has the same value in all runs.
    constant: Option<String>,
    axes: Vec<AxisPart>,
    /// How the axes correlate.
    correlations: Option<String>,
    sampling: Option<String>,
    percents: Vec<String>,
    figures: Vec<FigurePart<'a>>,
    coordinates: Vec<String>,
    /// Variables with limits, and the shares of runs within them.
    yields: Vec<(String, String)>,
    /// Of each figure the intervals of the percentiles 5, 50 and 95.
    intervals: Vec<(String, [String; 3])>,
    /// Whether the shares have intervals.
    is_independent: bool,
    /// The axes with Sobol's indices, and of each figure the indices of each.
    index_names: Vec<String>,
    indices: Vec<IndexRow>,
    /// Whether there is any rank correlation.
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
    /// Least, percentiles, greatest, mean, deviation.
    numbers: Vec<String>,
    correlations: Vec<String>,
    absent: Vec<String>,
    histogram: Option<&'a str>,
    /// What the worst runs have: the number, the figure, the settings.
    worst: Vec<(u64, String, Vec<String>)>,
    is_lower_better: bool,
}

/// `summary.html`.
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
            is_lower_better: crate::summary::is_lower_better(&of.figure.name),
        })
    };
    let failures = summary.failures.iter().map(|of| (numbers(&of.runs, of.count), printable(&of.reason)));
    let has_samples = study.axes.iter().any(|axis| is_sampled(&axis.along));
    let sampling = match study.sampling {
        Sampling::Random => "at random",
        Sampling::LatinHypercube => "as a Latin hypercube",
        Sampling::Sobol => "as a Sobol sequence",
        Sampling::Saltelli => "as a Sobol sequence for Sobol's indices",
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
        ran: RanPart::of(report),
    };
    Ok(page.render()?)
}

/// In place of an interval.
const TOO_FEW: &str = "too few runs";

/// Of each figure the intervals of the percentiles 5, 50 and 95.
fn intervals(report: &Report) -> Vec<(String, [String; 3])> {
    let row = |of: &Distribution| {
        let cells = interval_cells(of).map(|cell| cell.unwrap_or_else(|| TOO_FEW.into()));
        (pictures::axis(&of.figure), cells)
    };
    let figures = report.summary.figures.iter().filter(|of| of.count > 0);
    if report.job.study.is_independent() { figures.map(row).collect() } else { Vec::new() }
}

/// The intervals of the percentiles 5, 50 and 95; none for which there are too few runs.
fn interval_cells(of: &Distribution) -> [Option<String>; 3] {
    [5.0, 50.0, 95.0].map(|wanted| {
        let place = PERCENTS.iter().position(|percent| *percent == wanted)?;
        let (low, high) = (*of.intervals.get(place)?)?;
        // The spread of the figure would make one number of both ends.
        let ends = [low, high].map(|end| shorter(within(end, high - low), short(end)));
        let ends = if ends[0] == ends[1] { [low, high].map(|end| within(end, high - low)) } else { ends };
        Some(ends.join(" to "))
    })
}

/// A figure, and for each axis the first-order index and the total one.
type IndexRow = (String, Vec<(String, String)>);

/// Of each figure that varies in a study for Sobol's indices the indices of each axis: the first-order one and the total one.
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
