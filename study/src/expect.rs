//! Expectations about the runs of a study, such as `overshoot < 10 %`.
//!
//! ```text
//! overshoot < 10 %             for each run
//! p95(settling) < 300 s        for a percentile of all runs; also min(..), median(..) and max(..)
//! mean(travel) <= 250          for the mean
//! TANK.LEVEL.violation == 0    the unit may be omitted
//! ```

use crate::interval;
use crate::results::{Quantity, Results};
use crate::summary::{mean, percentile};
use anyhow::{Context, Result, bail};
use control::figures;
use modeldescription::digits::short;
use run::plan::near;
use std::fmt;

/// An expectation: each run, or a percentile or the mean of all runs, must respect a bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    /// The text as written by the user.
    pub text: String,
    /// The index of the figure's column.
    pub figure: usize,
    /// The quantity to compare.
    pub of: Of,
    /// The comparison.
    pub comparison: Comparison,
    /// The bound, in the figure's unit.
    pub bound: f64,
}

/// The quantity that is compared with the bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Of {
    /// The value of every run.
    Each,
    /// A percentile of all runs, from 0 (the minimum) to 100 (the maximum).
    Percentile(f64),
    /// The mean of all runs.
    Mean,
}

/// The comparison with the bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// `<`
    Less,
    /// `<=`
    AtMost,
    /// `>`
    Greater,
    /// `>=`
    AtLeast,
    /// `==`
    Equal,
}

impl Comparison {
    /// All comparisons; a sign precedes its own prefixes.
    const ALL: [Comparison; 5] =
        [Comparison::AtMost, Comparison::AtLeast, Comparison::Equal, Comparison::Less, Comparison::Greater];

    /// The sign as written.
    pub fn sign(self) -> &'static str {
        match self {
            Comparison::Less => "<",
            Comparison::AtMost => "<=",
            Comparison::Greater => ">",
            Comparison::AtLeast => ">=",
            Comparison::Equal => "==",
        }
    }

    /// Whether a value respects the bound; always false for NaN.
    pub fn holds(self, value: f64, bound: f64) -> bool {
        match self {
            Comparison::Less => value < bound,
            Comparison::AtMost => value <= bound,
            Comparison::Greater => value > bound,
            Comparison::AtLeast => value >= bound,
            Comparison::Equal => value == bound,
        }
    }

    /// The signed distance by which a value exceeds the bound; negative while it does not. The larger, the worse.
    pub fn excess(self, value: f64, bound: f64) -> f64 {
        match self {
            Comparison::Less | Comparison::AtMost => value - bound,
            Comparison::Greater | Comparison::AtLeast => bound - value,
            Comparison::Equal => (value - bound).abs(),
        }
    }

    /// The value used in a percentile or mean for a run that lacks the figure: the worst possible one.
    fn worst(self) -> f64 {
        match self {
            Comparison::Less | Comparison::AtMost => f64::INFINITY,
            Comparison::Greater | Comparison::AtLeast => f64::NEG_INFINITY,
            Comparison::Equal => f64::NAN,
        }
    }
}

/// The maximum number of runs listed with their settings.
pub(crate) const MOST_RUNS: usize = 10;

/// The result of checking an expectation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// At most ten runs that do not meet the bound, each with the reason: first those without the figure, then those
    /// furthest beyond the bound, last those that ended with an error. Empty if the expectation is met.
    pub offending: Vec<(u64, String)>,
    /// The total number of such runs.
    pub count: usize,
    /// The problem, in a sentence; `None` if the expectation is met.
    pub problem: Option<String>,
    /// The number of runs that meet the bound; `None` for an expectation about all runs together.
    pub hits: Option<u64>,
    /// For a percentile of independent samples, the 95 % confidence interval of the true percentile; infinite on a side
    /// with too few runs.
    pub interval: Option<(f64, f64)>,
    /// Whether only part of the interval respects the bound.
    pub is_undecided: bool,
}

impl Expectation {
    /// Parses `FIGURE < NUMBER [UNIT]`, with <, <=, >, >= or ==. In place of a figure it may name `pN(FIGURE)`, a
    /// percentile (0 to 100), `min(FIGURE)`, `median(FIGURE)`, `max(FIGURE)` or `mean(FIGURE)`.
    ///
    /// # Errors
    /// The figure is unknown, or the unit differs from the figure's.
    pub fn parse(text: &str, figures: &[Quantity]) -> Result<Expectation> {
        let text = text.trim();
        let read = || {
            let sign = |(at, _): (usize, char)| {
                Comparison::ALL.into_iter().find(|of| text[at..].starts_with(of.sign())).map(|of| (at, of))
            };
            let Some((at, comparison)) = text.char_indices().find_map(sign) else {
                if text.contains('=') {
                    bail!("use <, <=, >, >= or == to compare a figure with a bound, not =");
                }
                bail!("no <, <=, >, >= or ==; write, for example, overshoot < 10 %");
            };
            let (left, right) = (text[..at].trim(), text[at + comparison.sign().len()..].trim());
            let (of, figure) = subject(left, figures)?;
            let bound = bound(right, &figures[figure])?;
            Ok(Expectation { text: text.into(), figure, of, comparison, bound })
        };
        read().with_context(|| format!("expectation {text:?}"))
    }

    /// Checks the expectation. If `is_sample`, the runs are independent samples of a larger population of machines, and
    /// an expectation about a percentile must hold for that population at a confidence level of 95 %.
    ///
    /// # Errors
    /// The results of a large study cannot be read.
    pub fn verdict(&self, results: &Results, is_sample: bool) -> Result<Verdict> {
        let values = results.figure(self.figure)?;
        let value = |run: u64| values[run as usize];
        let runs = results.count();
        let mut offending: Vec<u64> = (0..runs).filter(|run| !self.comparison.holds(value(*run), self.bound)).collect();
        let worth = |run: &u64| match (results.errors.contains_key(run), value(*run).is_nan()) {
            (true, _) => (2, 0.0),
            (false, true) => (0, 0.0),
            (false, false) => (1, self.comparison.excess(value(*run), self.bound)),
        };
        offending.sort_by(|a, b| {
            let ((first, a), (second, b)) = (worth(a), worth(b));
            first.cmp(&second).then(b.total_cmp(&a))
        });
        let count = offending.len();
        let named = offending.iter().take(MOST_RUNS).map(|run| (*run, self.reason(results, *run, value(*run))));
        let named: Vec<(u64, String)> = named.collect();
        let hits = (self.of == Of::Each).then(|| runs - count as u64);
        let mut verdict = Verdict { hits, ..Verdict::default() };
        if self.of == Of::Each {
            verdict.problem = named.first().map(|(worst, reason)| {
                let (fail, which) = if count == 1 { ("fails", "") } else { ("fail", "worst: ") };
                format!("{count} of {} {fail}; {which}run {worst}: {reason}", runs_text(runs))
            });
        } else {
            drop(offending);
            self.judge_all(results, &values, is_sample, &mut verdict);
        }
        if verdict.problem.is_some() {
            (verdict.offending, verdict.count) = (named, count);
        }
        Ok(verdict)
    }

    /// Judges the value of all runs together.
    fn judge_all(&self, results: &Results, values: &[f64], is_sample: bool, verdict: &mut Verdict) {
        let figure = &results.figures[self.figure];
        let absent = values.iter().filter(|value| value.is_nan()).count();
        let replaced = |value: &f64| if value.is_nan() { self.comparison.worst() } else { *value };
        let mut values: Vec<f64> = values.iter().map(replaced).collect();
        values.sort_unstable_by(f64::total_cmp);
        let (name, value) = match self.of {
            Of::Mean => ("mean".to_string(), mean(&values)),
            Of::Percentile(0.0) => ("minimum".to_string(), percentile(&values, 0.0)),
            Of::Percentile(50.0) => ("median".to_string(), percentile(&values, 50.0)),
            Of::Percentile(100.0) => ("maximum".to_string(), percentile(&values, 100.0)),
            Of::Percentile(percent) => (format!("{} percentile", ordinal(percent)), percentile(&values, percent)),
            Of::Each => return,
        };
        // With `==`, no value is comparable if any run lacks the figure.
        let value = value.filter(|_| !(absent > 0 && self.comparison == Comparison::Equal));
        if results.count() == 0 {
            verdict.problem = Some(format!("{} has no {name}: there are no runs", figure.name));
            return;
        }
        let is_met = value.is_some_and(|value| self.comparison.holds(value, self.bound));
        if let (Of::Percentile(percent), Some(_), true) = (self.of, value, is_sample) {
            verdict.interval = interval::bounds(&values, percent);
        }
        let sentence = match value.filter(|value| value.is_finite() || absent == 0) {
            Some(value) => format!("the {name} of {} is {}", figure.name, with_unit(value, figure)),
            None => {
                let failed = results.errors.len();
                let of_these = if failed > 0 { format!(" ({failed} of them failed)") } else { String::new() };
                let have = if absent == 1 { "has" } else { "have" };
                format!(
                    "{} has no {name}: {absent} of {} {have} no {}{of_these}",
                    figure.name,
                    runs_text(results.count()),
                    figure.name
                )
            }
        };
        match (verdict.interval, self.of) {
            (Some(ends), Of::Percentile(percent)) if !self.is_decided(ends) => {
                verdict.is_undecided = true;
                let end = |end: f64| if end.is_finite() { with_unit(end, figure) } else { "any value".into() };
                let (runs, fewest) = (results.count(), interval::fewest(percent));
                let advice = match runs < fewest {
                    true => format!("at least {fewest} runs are needed"),
                    false => "more runs are needed".to_string(),
                };
                verdict.problem = Some(format!(
                    "{} cannot decide this: {sentence} (95 % confidence interval: {} to {}); {advice}",
                    runs_text(runs),
                    end(ends.0),
                    end(ends.1)
                ));
            }
            _ => verdict.problem = (!is_met).then_some(sentence),
        }
    }

    /// Whether either all values in this interval respect the bound, or none of them does.
    fn is_decided(&self, (low, high): (f64, f64)) -> bool {
        let holds = [low, high].map(|end| self.comparison.holds(end, self.bound));
        match self.comparison {
            Comparison::Equal => holds == [true; 2] || self.bound < low || high < self.bound,
            _ => holds[0] == holds[1],
        }
    }

    /// Why a run fails: its value, the lack of one, or its error.
    fn reason(&self, results: &Results, run: u64, value: f64) -> String {
        let figure = &results.figures[self.figure];
        match (results.errors.get(&run), value) {
            (Some(error), _) => format!("it failed: {error}"),
            (None, value) if value.is_nan() => match figures::find(&figure.name) {
                Some(known) => format!("no {}, since {}", figure.name, known.absent),
                None => format!("it has no {}", figure.name),
            },
            (None, value) => format!("{} is {}", figure.name, with_unit(value, figure)),
        }
    }
}

/// Parses the left side: the quantity, and the index of its figure.
fn subject(text: &str, figures: &[Quantity]) -> Result<(Of, usize)> {
    let find = |name: &str| figures.iter().position(|figure| figure.name == name);
    // The name of a variable may contain brackets.
    if let Some(figure) = find(text) {
        return Ok((Of::Each, figure));
    }
    if text.is_empty() {
        bail!("no figure before the sign; write, for example, overshoot < 10 %");
    }
    let Some((function, name)) = text.strip_suffix(')').and_then(|text| text.split_once('(')) else {
        return Err(unknown(text, figures));
    };
    let (function, name) = (function.trim(), name.trim());
    let of = match function {
        "min" => Of::Percentile(0.0),
        "median" => Of::Percentile(50.0),
        "max" => Of::Percentile(100.0),
        "mean" => Of::Mean,
        _ => match function.strip_prefix('p').map(str::parse::<f64>) {
            Some(Ok(percent)) if (0.0..=100.0).contains(&percent) => Of::Percentile(percent),
            Some(Ok(percent)) => bail!("p{percent}({name}): percentiles range from p0 to p100"),
            _ => bail!("{function}({name}): write p95({name}), or use min, median, max or mean instead of p95"),
        },
    };
    Ok((of, find(name).ok_or_else(|| unknown(name, figures))?))
}

fn unknown(name: &str, figures: &[Quantity]) -> anyhow::Error {
    anyhow::anyhow!("the study has no figure {name}; {}", instead(name, figures))
}

/// The end of a message about a wrong name: suggests the most similar figure, or lists all figures.
pub(crate) fn instead(name: &str, figures: &[Quantity]) -> String {
    let names = || figures.iter().map(|figure| figure.name.as_str());
    match near(name, names()) {
        Some(near) => format!("did you mean {near}?"),
        None => format!("the figures are {}", names().collect::<Vec<_>>().join(", ")),
    }
}

/// Parses a number, optionally followed by the figure's unit.
fn bound(text: &str, figure: &Quantity) -> Result<f64> {
    let is_of_number = |letter: char| letter.is_ascii_digit() || "+-.".contains(letter);
    let mut end = text.find(|letter| !is_of_number(letter)).unwrap_or(text.len());
    // An `e` followed by digits is an exponent, not the first letter of a unit.
    if let Some(exponent) = text[end..].strip_prefix(['e', 'E'])
        && exponent.trim_start_matches(['+', '-']).starts_with(|letter: char| letter.is_ascii_digit())
    {
        let rest = exponent.trim_start_matches(['+', '-']).trim_start_matches(|letter: char| letter.is_ascii_digit());
        end = text.len() - rest.len();
    }
    let (number, unit) = (&text[..end], text[end..].trim());
    let number = match number.parse::<f64>() {
        Ok(number) if number.is_finite() && !unit.starts_with(',') => number,
        _ => bail!("{text:?} is not a number, with or without a unit (the decimal separator is a point)"),
    };
    match figure.unit.as_deref() {
        _ if unit.is_empty() => Ok(number),
        Some(own) if own == unit => Ok(number),
        Some(own) => bail!("{} is in {own}, not in {unit}", figure.name),
        None => bail!("{} has no unit: write the number alone", figure.name),
    }
}

/// A value with its figure's unit.
pub fn with_unit(value: f64, of: &Quantity) -> String {
    match &of.unit {
        Some(unit) => format!("{} {unit}", short(value)),
        None => short(value),
    }
}

/// A count of runs: `1 run`, `2 runs`.
pub fn runs_text(count: u64) -> String {
    if count == 1 { "1 run".into() } else { format!("{count} runs") }
}

/// An ordinal number: 95th, 2nd, 99.9th.
fn ordinal(number: f64) -> String {
    let is_whole = number.fract() == 0.0;
    let ending = match (number % 10.0, number % 100.0) {
        (_, 11.0..=13.0) => "th",
        (1.0, _) if is_whole => "st",
        (2.0, _) if is_whole => "nd",
        (3.0, _) if is_whole => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
}

impl fmt::Display for Expectation {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::RunResult;

    const NONE: f64 = f64::NAN;

    fn figures() -> Vec<Quantity> {
        let quantity = |name: &str, unit: &str| Quantity::new(name, Some(unit).filter(|unit| !unit.is_empty()));
        vec![
            quantity("overshoot", "%"),
            quantity("settling", "s"),
            quantity("pulses", ""),
            quantity("FMU.der(x).max", "m/s"),
            quantity("iae", "degC s"),
        ]
    }

    /// Results with overshoot and settling; `None` is a failed run.
    fn results(rows: &[Option<(f64, f64)>]) -> Results {
        let mut results = Results::new(Vec::new(), figures());
        for row in rows {
            let (overshoot, settling) = row.unwrap_or((NONE, NONE));
            let error = row.is_none().then(|| "PLANT: division by zero".to_string());
            results.push(&[], &RunResult { figures: vec![overshoot, settling, NONE, NONE, NONE], error }).unwrap();
        }
        results
    }

    fn runs(verdict: &Verdict) -> Vec<u64> {
        verdict.offending.iter().map(|(run, _)| *run).collect()
    }

    fn parse(text: &str) -> Expectation {
        Expectation::parse(text, &figures()).unwrap()
    }

    fn error(text: &str) -> String {
        format!("{:#}", Expectation::parse(text, &figures()).unwrap_err())
    }

    #[test]
    fn an_expectation_names_a_figure_a_comparison_and_a_bound() {
        let parts = |text: &str| {
            let of = parse(text);
            (of.figure, of.of, of.comparison, of.bound)
        };
        assert_eq!(parts("overshoot < 10 %"), (0, Of::Each, Comparison::Less, 10.0));
        assert_eq!(parts(" overshoot<=10%"), (0, Of::Each, Comparison::AtMost, 10.0));
        assert_eq!(parts("p95(settling) < 300 s"), (1, Of::Percentile(95.0), Comparison::Less, 300.0));
        assert_eq!(parts("p99.9( settling ) > 3e2s"), (1, Of::Percentile(99.9), Comparison::Greater, 300.0));
        assert_eq!(parts("pulses == 0"), (2, Of::Each, Comparison::Equal, 0.0));
        assert_eq!(parts("max(pulses) >= -1.5e+1"), (2, Of::Percentile(100.0), Comparison::AtLeast, -15.0));
        assert_eq!(parts("mean(iae)< 5 degC s"), (4, Of::Mean, Comparison::Less, 5.0));
        assert_eq!(parts("FMU.der(x).max < 1"), (3, Of::Each, Comparison::Less, 1.0));
        assert_eq!(parts("median(FMU.der(x).max) < 1 m/s"), (3, Of::Percentile(50.0), Comparison::Less, 1.0));
    }

    #[test]
    fn a_wrong_expectation_says_what_to_write() {
        let cases = [
            ("overshot < 10", "the study has no figure overshot; did you mean overshoot?"),
            ("p95(setling) < 1", "the study has no figure setling; did you mean settling?"),
            ("x < 1", "the study has no figure x; the figures are overshoot, settling, pulses, FMU.der(x).max, iae"),
            ("overshoot < 10 s", "overshoot is in %, not in s"),
            ("pulses < 10 s", "pulses has no unit: write the number alone"),
            ("overshoot < ten", "\"ten\" is not a number, with or without a unit (the decimal separator is a point)"),
            (
                "overshoot < 2,5 %",
                "\"2,5 %\" is not a number, with or without a unit (the decimal separator is a point)",
            ),
            ("overshoot = 1", "use <, <=, >, >= or == to compare a figure with a bound, not ="),
            ("overshoot", "no <, <=, >, >= or ==; write, for example, overshoot < 10 %"),
            ("< 1", "no figure before the sign; write, for example, overshoot < 10 %"),
            ("p101(pulses) < 1", "p101(pulses): percentiles range from p0 to p100"),
            ("best(pulses) < 1", "best(pulses): write p95(pulses), or use min, median, max or mean instead of p95"),
        ];
        for (text, expected) in cases {
            assert_eq!(error(text), format!("expectation {text:?}: {expected}"));
        }
    }

    #[test]
    fn runs_without_the_figure_and_failed_runs_fail() {
        let results = results(&[Some((12.5, 1.0)), Some((5.0, 1.0)), None, Some((NONE, 1.0)), Some((30.0, 1.0))]);
        let expectation = parse("overshoot < 10 %");
        let verdict = expectation.verdict(&results, false).unwrap();
        assert_eq!((runs(&verdict), verdict.count), (vec![3, 4, 0, 2], 4));
        assert_eq!(
            verdict.problem.unwrap(),
            "4 of 5 runs fail; worst: run 3: no overshoot, since the process value does not reach the setpoint"
        );
        assert_eq!(verdict.offending[1].1, "overshoot is 30 %");
        assert_eq!(verdict.offending[3].1, "it failed: PLANT: division by zero");
        assert_eq!(
            parse("settling == 1").verdict(&results, false).unwrap().problem.unwrap(),
            "1 of 5 runs fails; run 2: it failed: PLANT: division by zero"
        );
    }

    #[test]
    fn ten_of_the_runs_that_fail_are_named_and_all_are_counted() {
        let rows: Vec<_> = (0..25).map(|run| Some((f64::from(run), 1.0))).collect();
        let verdict = parse("overshoot < 5 %").verdict(&results(&rows), false).unwrap();
        assert_eq!((runs(&verdict), verdict.count, verdict.hits), ((15..25).rev().collect(), 20, Some(5)));
    }

    #[test]
    fn an_expectation_that_is_met_has_no_offending_runs() {
        let results = results(&[Some((9.0, 1.0)), Some((10.0, 100.0)), Some((1.0, 2.0))]);
        for met in [
            "overshoot <= 10",
            "max(overshoot) < 10.5",
            "median(settling) == 2",
            "min(settling) >= 1",
            "p50(overshoot) > 8",
        ] {
            let Verdict { offending, problem, .. } = parse(met).verdict(&results, false).unwrap();
            assert_eq!((offending, problem), (Vec::new(), None), "{met}");
        }
        assert_eq!(
            ["overshoot < 10", "mean(overshoot) < 8"].map(|text| parse(text).verdict(&results, false).unwrap().hits),
            [Some(2), None]
        );
        assert_eq!(runs(&parse("overshoot < 10").verdict(&results, false).unwrap()), [1]);
        assert_eq!(runs(&parse("overshoot > 9").verdict(&results, false).unwrap()), [2, 0]);
    }

    #[test]
    fn a_percentile_counts_a_run_without_the_figure_as_the_worst() {
        let rows: Vec<_> = (0..=10).map(|run| Some((f64::from(run), if run < 9 { 1.0 } else { NONE }))).collect();
        let results = results(&rows);
        let problem = |text: &str| parse(text).verdict(&results, false).unwrap().problem;
        assert_eq!(problem("p80(settling) < 2 s"), None);
        assert_eq!(
            problem("p90(settling) < 2 s").unwrap(),
            "settling has no 90th percentile: 2 of 11 runs have no settling"
        );
        assert_eq!(problem("min(settling) > 0 s").unwrap(), "settling has no minimum: 2 of 11 runs have no settling");
        assert_eq!(problem("mean(settling) < 2 s").unwrap(), "settling has no mean: 2 of 11 runs have no settling");
        assert_eq!(problem("min(settling) == 1").unwrap(), "settling has no minimum: 2 of 11 runs have no settling");
        assert_eq!(problem("p95(overshoot) < 9 %").unwrap(), "the 95th percentile of overshoot is 9.5 %");
        assert_eq!(runs(&parse("p95(overshoot) < 9 %").verdict(&results, false).unwrap()), [10, 9]);
        assert_eq!(problem("mean(overshoot) > 5").unwrap(), "the mean of overshoot is 5 %");
    }

    #[test]
    fn too_few_samples_decide_nothing_of_a_percentile() {
        // Runs with 0 to 19 %: the interval of the 95th percentile begins at the 17th value and has no upper end.
        let rows: Vec<_> = (0..20).map(|run| Some((f64::from(run), 1.0))).collect();
        let results = results(&rows);
        let verdict = |text: &str| parse(text).verdict(&results, true).unwrap();
        let undecided = verdict("p95(overshoot) < 100 %");
        assert!(undecided.is_undecided);
        assert_eq!(undecided.interval, Some((16.0, f64::INFINITY)));
        assert_eq!(
            undecided.problem.unwrap(),
            "20 runs cannot decide this: the 95th percentile of overshoot is 18.05 % (95 % confidence interval: \
             16 % to any value); at least 72 runs are needed"
        );
        // Not met, regardless of what additional runs would show.
        let not_met = verdict("p95(overshoot) < 16 %");
        assert!(!not_met.is_undecided);
        assert_eq!(not_met.problem.unwrap(), "the 95th percentile of overshoot is 18.05 %");
        assert_eq!(verdict("p95(overshoot) > 15.9 %").problem, None);
        assert!(
            verdict("p5(overshoot) > -1 %").problem.unwrap().contains("interval: any value to 3 %); at least 72 runs")
        );
        // The interval of the median: from the 6th to the 15th value.
        assert_eq!(
            (verdict("median(overshoot) < 14.1 %").problem, verdict("median(overshoot) < 5 %").is_undecided),
            (None, false)
        );
        let close = verdict("median(overshoot) < 14 %");
        assert_eq!(
            close.problem.unwrap(),
            "20 runs cannot decide this: the median of overshoot is 9.5 % (95 % confidence interval: 5 % to \
             14 %); more runs are needed"
        );
        // The runs are all the machines, and expectations about the runs alone.
        assert_eq!(parse("p95(overshoot) < 100 %").verdict(&results, false).unwrap().problem, None);
        assert_eq!(
            [verdict("max(overshoot) < 100 %").problem, verdict("mean(overshoot) < 100 %").problem],
            [None, None]
        );
    }

    #[test]
    fn percentiles_are_named_as_they_are_spoken() {
        let names = [1.0, 2.0, 3.0, 11.0, 12.0, 13.0, 21.0, 95.0, 99.9].map(ordinal);
        assert_eq!(names, ["1st", "2nd", "3rd", "11th", "12th", "13th", "21st", "95th", "99.9th"]);
    }
}
