//! Settings of a controller that are the best for a set of plants: what `plcfmu tune-study` searches for.
//!
//! The axes of a study span the plants. A *candidate* has a value for each [`Search`] variable; it is run with every plant. Its
//! *objective* is the figure [`Tune::minimize`], taken [`Over`] the plants. A constraint has to hold for every plant.
//!
//! Candidates are compared by Deb's rule: one that keeps all constraints is better than one that does not; of two that keep
//! them, the one with the lower objective is better; of two that do not, the one with the lower violation. The violation is a
//! sum over the constraints, and for each of them the mean over the plants of `v / (1 + v)`, where `v` is by how much the bound
//! is passed, divided by the bound's amount. A figure without a value, as that of a run that failed, counts as `v` without
//! end, and the objective has to be known for every plant as well.

pub mod robustness;
mod search;

use crate::expect::{Expectation, Of};
use crate::results::Row;
use crate::summary::{mean, percentile};
use anyhow::{Result, bail};
use control::identify::Model;
use libm::{exp, log};
use serde::{Deserialize, Serialize};

pub use search::{Outcome, search};

/// The significant digits of a searched value.
const DIGITS: i32 = 5;

/// This many variables can be searched at once: a simplex needs many more evaluations with each.
const MOST_VARIABLES: usize = 12;

/// The name of the largest sensitivity among the figures.
pub const SENSITIVITY: &str = "ms";

/// What to search for: the table `[tune]` of a study.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Tune {
    /// The figure whose lowest value is the best.
    pub minimize: String,
    /// What of its values for all plants counts, and of those of `front`.
    #[serde(default)]
    pub over: Over,
    /// What has to hold for every plant, such as `overshoot < 10 %`.
    #[serde(default)]
    pub constraints: Vec<String>,
    /// A second figure: the result is also the front of both, where one of them is only better if the other one is worse.
    #[serde(default)]
    pub front: Option<String>,
    /// How many candidates are tried at most; 10 to 100 000.
    #[serde(default = "evaluations")]
    pub evaluations: usize,
    /// What the first candidates depend on.
    #[serde(default)]
    pub seed: u64,
    /// Whether each loop of the table of loops gets settings of its own.
    #[serde(default)]
    pub each: bool,
    /// What varies from candidate to candidate.
    #[serde(default)]
    pub search: Vec<Search>,
    /// The plant's model for `ms`, the same for all plants; without it, what each plant does after a step.
    #[serde(default)]
    pub model: Option<Model>,
    /// The step that shows the plants for `ms`.
    #[serde(default)]
    pub step: robustness::Step,
}

fn evaluations() -> usize {
    500
}

/// What of the values of a figure for all plants counts.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// The highest.
    #[default]
    Worst,
    /// The mean.
    Mean,
    /// The 95th percentile.
    P95,
}

impl Over {
    /// As the user writes it.
    pub fn name(self) -> &'static str {
        match self {
            Over::Worst => "worst",
            Over::Mean => "mean",
            Over::P95 => "p95",
        }
    }

    /// The value that counts; none if one of them has no value.
    pub fn of(self, values: &[f64]) -> Option<f64> {
        if values.is_empty() || values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        Some(match self {
            Over::Worst => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Over::Mean => mean(values)?,
            Over::P95 => {
                let mut sorted = values.to_vec();
                sorted.sort_by(f64::total_cmp);
                percentile(&sorted, 95.0)?
            }
        })
    }
}

/// A variable that varies from candidate to candidate.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// The least value that is tried.
    pub min: f64,
    /// The greatest value that is tried.
    pub max: f64,
    /// Whether equal differences count as equally far; without it, equal ratios do if `min` is above 0.
    #[serde(default)]
    pub linear: bool,
    /// What values there are; not in the file, it follows from the variable's type.
    #[serde(skip)]
    pub grid: Grid,
}

/// What values of a variable are tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Grid {
    /// Numbers with five significant digits.
    #[default]
    Digits,
    /// Whole milliseconds, of a TIME in seconds.
    Milliseconds,
    /// Whole numbers.
    Whole,
}

impl Search {
    /// The value at a place from 0 to 1; a place outside counts as the nearest.
    fn value(&self, place: f64) -> f64 {
        let place = place.clamp(0.0, 1.0);
        let value = if self.is_logarithmic() {
            exp(log(self.min) + (log(self.max) - log(self.min)) * place)
        } else {
            self.min + (self.max - self.min) * place
        };
        let value = match self.grid {
            Grid::Digits => control::tune::rounded(value, DIGITS),
            Grid::Milliseconds => (value * 1000.0).round() / 1000.0,
            Grid::Whole => value.round(),
        };
        value.clamp(self.min, self.max)
    }

    /// Where a value is, from 0 to 1.
    fn place(&self, value: f64) -> f64 {
        let value = value.clamp(self.min, self.max);
        if self.is_logarithmic() {
            (log(value) - log(self.min)) / (log(self.max) - log(self.min))
        } else {
            (value - self.min) / (self.max - self.min)
        }
    }

    fn is_logarithmic(&self) -> bool {
        !self.linear && self.min > 0.0
    }

    /// At which end of the range a value is: `min`, `max`, or neither.
    pub fn end(&self, value: f64) -> Option<&'static str> {
        let place = self.place(value);
        (place < 0.005).then_some("min").or((place > 0.995).then_some("max"))
    }
}

impl Tune {
    /// Whether the numbers can be worked with.
    ///
    /// # Errors
    /// Which of them cannot, and what is allowed.
    pub fn check(&self) -> Result<()> {
        if !(10..=100_000).contains(&self.evaluations) {
            bail!("evaluations = {}: 10 to 100000 are possible", self.evaluations);
        }
        if self.search.is_empty() {
            bail!(
                "there is nothing to search: write a table [[tune.search]] with variable, min and max for each setting"
            );
        }
        if self.search.len() > MOST_VARIABLES {
            bail!("{} variables are searched: {MOST_VARIABLES} at most are possible", self.search.len());
        }
        for (number, search) in self.search.iter().enumerate() {
            let Search { variable, min, max, .. } = search;
            if !(min.is_finite() && max.is_finite() && min < max) {
                bail!("{variable} is searched from {min} to {max}: min has to be below max");
            }
            if self.search[..number].iter().any(|other| other.variable == *variable) {
                bail!("{variable} is searched twice: remove one of the tables [[tune.search]]");
            }
        }
        if self.front.as_ref() == Some(&self.minimize) {
            bail!("front and minimize are both {}: a front needs two figures", self.minimize);
        }
        if let Some(model) = &self.model {
            model.check()?;
        }
        Ok(())
    }
}

/// An expectation that has to be met by every plant, or by all plants together if it is one of a percentile or a mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint(pub Expectation);

impl Constraint {
    /// The value that is the closest to breaking it, or that breaks it the most; NaN if one has no value.
    pub fn value(&self, rows: &[Row]) -> f64 {
        let mut values: Vec<f64> = rows.iter().map(|row| row.figures[self.0.figure]).collect();
        if values.iter().any(|value| value.is_nan()) {
            return f64::NAN;
        }
        match self.0.of {
            Of::Each => {
                values.into_iter().max_by(|a, b| self.beyond(*a).total_cmp(&self.beyond(*b))).unwrap_or(f64::NAN)
            }
            Of::Percentile(percent) => {
                values.sort_by(f64::total_cmp);
                percentile(&values, percent).unwrap_or(f64::NAN)
            }
            Of::Mean => mean(&values).unwrap_or(f64::NAN),
        }
    }

    /// Whether its value is within 2 % of the bound, so that it is what keeps the objective from being lower.
    pub fn is_active(&self, rows: &[Row]) -> bool {
        (self.value(rows) - self.0.bound).abs() <= 0.02 * self.scale()
    }

    /// Whether it holds.
    pub fn holds(&self, rows: &[Row]) -> bool {
        self.violation(rows) == 0.0
    }

    /// 0 if it holds, up to 1.
    fn violation(&self, rows: &[Row]) -> f64 {
        if self.0.of != Of::Each {
            return bounded(self.excess(self.value(rows)));
        }
        let sum: f64 = rows.iter().map(|row| bounded(self.excess(row.figures[self.0.figure]))).sum();
        sum / rows.len().max(1) as f64
    }

    /// How far a value is beyond the bound; below 0 if it is not.
    fn beyond(&self, value: f64) -> f64 {
        self.0.comparison.excess(value, self.0.bound)
    }

    /// By how much of the bound a value passes it.
    fn excess(&self, value: f64) -> f64 {
        if self.0.comparison.holds(value, self.0.bound) {
            return 0.0;
        }
        let excess = self.beyond(value) / self.scale();
        // The bound itself may break it, and is as little beyond as can be.
        if excess.is_nan() { f64::INFINITY } else { excess.max(1e-9) }
    }

    fn scale(&self) -> f64 {
        if self.0.bound == 0.0 { 1.0 } else { self.0.bound.abs() }
    }
}

/// `v / (1 + v)`, which does not pass 1.
fn bounded(excess: f64) -> f64 {
    if excess == f64::INFINITY { 1.0 } else { excess / (1.0 + excess) }
}

/// The aim of the search, with figures by their numbers in a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// The figure whose lowest value is the best.
    pub minimize: usize,
    /// What of the values for all plants counts.
    pub over: Over,
    /// What has to hold.
    pub constraints: Vec<Constraint>,
    /// The second figure of the front.
    pub front: Option<usize>,
    /// How many candidates are tried at most.
    pub evaluations: usize,
    /// What the first candidates depend on.
    pub seed: u64,
    /// What varies.
    pub search: Vec<Search>,
}

/// Settings with their result.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The value of each search variable.
    pub values: Vec<f64>,
    /// A row for each plant.
    pub rows: Vec<Row>,
    /// The figure that is minimized; none if it has no value for some plant.
    pub objective: Option<f64>,
    /// The second figure of the front.
    pub second: Option<f64>,
    /// 0 if all constraints hold.
    pub violation: f64,
}

impl Candidate {
    /// Judges settings by their rows.
    pub fn of(problem: &Problem, values: Vec<f64>, rows: Vec<Row>) -> Candidate {
        let figure = |number: usize| -> Vec<f64> { rows.iter().map(|row| row.figures[number]).collect() };
        let counted = |number: usize| problem.over.of(&figure(number));
        // A figure that is not known for some of the plants gets worse with their number.
        let unknown = |number: usize| {
            let values = figure(number);
            values.iter().filter(|value| !value.is_finite()).count() as f64 / values.len().max(1) as f64
        };
        let objectives = std::iter::once(problem.minimize).chain(problem.front);
        let violation = problem.constraints.iter().map(|constraint| constraint.violation(&rows)).sum::<f64>()
            + objectives.map(unknown).sum::<f64>();
        let (objective, second) = (counted(problem.minimize), problem.front.and_then(counted));
        Candidate { values, rows, objective, second, violation }
    }

    /// Whether all constraints hold and the figures are known.
    pub fn is_feasible(&self) -> bool {
        self.violation == 0.0
    }
}

#[cfg(test)]
mod tests;
