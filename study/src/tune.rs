//! Tuning of a controller for a set of plants: the problem that `plcfmu tune-study` solves.
//!
//! The axes of a study span the plants. A *candidate* has a value for each [`Search`] variable; it is run with every
//! plant. Its *objective* is the figure [`Tune::minimize`], combined over the plants as specified by [`Over`]. A
//! constraint must hold for every plant or, if it is about a percentile or a mean, for all plants together.
//!
//! Candidates are compared by Deb's rule: a feasible candidate beats an infeasible one; of two feasible ones, the lower
//! objective wins; of two infeasible ones, the lower violation wins. The violation is the sum over the constraints of
//! the mean over the plants of `v / (1 + v)`, where `v` is the amount by which the bound is exceeded, divided by the
//! bound's magnitude. If a figure has no value, for example because its run failed, `v` is infinite. A feasible
//! candidate also has an objective for every plant: each missing one adds to the violation.

pub mod robustness;
mod search;

use crate::expect::{Expectation, Of};
use crate::results::RunResult;
use crate::summary::{mean, percentile};
use anyhow::{Result, bail};
use control::identify::Model;
use libm::{exp, log};
use run::bail_at;
use run::subject::About;
use serde::{Deserialize, Serialize};

pub use search::{Outcome, search};

/// The number of significant digits in a searched value.
const DIGITS: i32 = 5;

/// The maximum number of search variables: each one considerably increases the number of evaluations that a simplex
/// needs.
const MOST_VARIABLES: usize = 12;

/// The name of the figure for the maximum sensitivity.
pub const SENSITIVITY: &str = "ms";

/// The search problem: the table `[tune]` of a study.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Tune {
    /// The figure to minimize.
    pub minimize: String,
    /// How the values for all plants are combined, for `minimize` and for `front`.
    #[serde(default)]
    pub over: Over,
    /// The constraints for every plant, such as `overshoot < 10 %`.
    #[serde(default)]
    pub constraints: Vec<String>,
    /// A second figure to minimize: the result then includes the Pareto front of both.
    #[serde(default)]
    pub front: Option<String>,
    /// The maximum number of candidates, 10 to 100 000.
    #[serde(default = "evaluations")]
    pub evaluations: usize,
    /// The seed of the initial design, from which the search starts.
    #[serde(default)]
    pub seed: u64,
    /// Whether each loop in the table of loops is tuned separately.
    #[serde(default)]
    pub each: bool,
    /// The variables to search.
    #[serde(default)]
    pub search: Vec<Search>,
    /// The plant model for `ms`, the same for all plants; by default each plant is identified from a step response.
    #[serde(default)]
    pub model: Option<Model>,
    /// The step that identifies the plants for `ms`.
    #[serde(default)]
    pub step: robustness::Step,
}

fn evaluations() -> usize {
    500
}

/// How the values of a figure for all plants are combined into one.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// The highest value.
    #[default]
    Worst,
    /// The mean.
    Mean,
    /// The 95th percentile.
    P95,
}

impl Over {
    /// The name as written by the user.
    pub fn name(self) -> &'static str {
        match self {
            Over::Worst => "worst",
            Over::Mean => "mean",
            Over::P95 => "p95",
        }
    }

    /// The combined value; `None` if any value is missing or infinite, or if there are no values.
    pub fn combine(self, values: &[f64]) -> Option<f64> {
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

/// A search variable.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// The lowest value to try.
    pub min: f64,
    /// The highest value to try.
    pub max: f64,
    /// Whether the scale is linear; by default it is logarithmic if `min` is above 0.
    #[serde(default)]
    pub linear: bool,
    /// The grid of values; not in the file but derived from the variable's type.
    #[serde(skip)]
    pub grid: Grid,
}

/// The grid of values tried for a variable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Grid {
    /// Numbers with five significant digits.
    #[default]
    Digits,
    /// Whole milliseconds, for a TIME in seconds.
    Milliseconds,
    /// Integers.
    Whole,
}

impl Search {
    /// The value on the grid at a position in the range, from 0 (`min`) to 1 (`max`); positions outside are clamped.
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

    /// The position of a value in the range, from 0 (`min`) to 1 (`max`); values outside are clamped.
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

    /// The end of the range, `min` or `max`, that a value has reached to within 0.5 %; `None` if neither.
    pub fn end(&self, value: f64) -> Option<&'static str> {
        let place = self.place(value);
        (place < 0.005).then_some("min").or((place > 0.995).then_some("max"))
    }
}

impl Tune {
    /// Checks everything that does not depend on the loop.
    ///
    /// # Errors
    /// A number is outside its permitted range, or a variable or figure is named twice; the message names the remedy.
    pub fn check(&self) -> Result<()> {
        if !(10..=100_000).contains(&self.evaluations) {
            bail_at!("evaluations", "evaluations = {}: it must be between 10 and 100000", self.evaluations);
        }
        if self.search.is_empty() {
            bail!("nothing to search: add a [[tune.search]] table with `variable`, `min` and `max` for each setting");
        }
        if self.search.len() > MOST_VARIABLES {
            bail_at!("search", "{} variables are searched: use at most {MOST_VARIABLES}", self.search.len());
        }
        for (number, search) in self.search.iter().enumerate() {
            let Search { variable, min, max, .. } = search;
            let check = || {
                if !(min.is_finite() && max.is_finite() && min < max) {
                    bail!("{variable} is searched from {min} to {max}: min must be below max");
                }
                if self.search[..number].iter().any(|other| other.variable == *variable) {
                    bail!("{variable} is searched twice: remove one of the [[tune.search]] tables");
                }
                Ok(())
            };
            check().at(number).at("search")?;
        }
        if self.front.as_ref() == Some(&self.minimize) {
            bail_at!("front", "front and minimize are both {}: a front needs two figures", self.minimize);
        }
        if let Some(model) = &self.model {
            model.check().at("model")?;
        }
        Ok(())
    }
}

/// An expectation to be met by every plant, or by all plants together if it is about a percentile or a mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint(pub Expectation);

impl Constraint {
    /// The percentile or mean that the constraint is about; for one about every plant, the value that violates it most
    /// or comes closest to it. NaN if any value is missing.
    pub fn value(&self, rows: &[RunResult]) -> f64 {
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

    /// Whether its value is within 2 % of the bound, so that it probably prevents a lower objective.
    pub fn is_active(&self, rows: &[RunResult]) -> bool {
        (self.value(rows) - self.0.bound).abs() <= 0.02 * self.scale()
    }

    /// Whether it holds.
    pub fn holds(&self, rows: &[RunResult]) -> bool {
        self.violation(rows) == 0.0
    }

    /// The violation, from 0 (the constraint holds) to 1: for a constraint about every plant, the mean over the plants.
    fn violation(&self, rows: &[RunResult]) -> f64 {
        if self.0.of != Of::Each {
            return bounded(self.excess(self.value(rows)));
        }
        let sum: f64 = rows.iter().map(|row| bounded(self.excess(row.figures[self.0.figure]))).sum();
        sum / rows.len().max(1) as f64
    }

    /// The signed distance by which a value exceeds the bound; negative while it does not.
    fn beyond(&self, value: f64) -> f64 {
        self.0.comparison.excess(value, self.0.bound)
    }

    /// The excess beyond the bound, relative to the bound's magnitude; 0 if the value respects it.
    fn excess(&self, value: f64) -> f64 {
        if self.0.comparison.holds(value, self.0.bound) {
            return 0.0;
        }
        let excess = self.beyond(value) / self.scale();
        // With `<` or `>`, a value equal to the bound violates the constraint, although its excess is 0.
        if excess.is_nan() { f64::INFINITY } else { excess.max(1e-9) }
    }

    fn scale(&self) -> f64 {
        if self.0.bound == 0.0 { 1.0 } else { self.0.bound.abs() }
    }
}

/// `v / (1 + v)`, which is at most 1.
fn bounded(excess: f64) -> f64 {
    if excess == f64::INFINITY { 1.0 } else { excess / (1.0 + excess) }
}

/// The search problem, with each figure as its index in a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// The figure to minimize.
    pub minimize: usize,
    /// How the values for all plants are combined.
    pub over: Over,
    /// The conditions that must hold.
    pub constraints: Vec<Constraint>,
    /// The second figure, for the front.
    pub front: Option<usize>,
    /// The maximum number of candidates.
    pub evaluations: usize,
    /// The seed of the initial design.
    pub seed: u64,
    /// The search variables.
    pub search: Vec<Search>,
}

/// Settings and their result.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The value of each search variable.
    pub values: Vec<f64>,
    /// The rows, one for each plant.
    pub rows: Vec<RunResult>,
    /// The minimized figure, combined over the plants; `None` if it is missing for any plant.
    pub objective: Option<f64>,
    /// The second figure, for the front, combined over the plants; `None` if it is missing for any plant, or if the
    /// problem has no second figure.
    pub second: Option<f64>,
    /// The violation: the sum over the constraints, plus, for each figure to minimize, the share of plants that lack
    /// it. 0 if the candidate is feasible.
    pub violation: f64,
}

impl Candidate {
    /// Evaluates settings from their rows.
    pub fn new(problem: &Problem, values: Vec<f64>, rows: Vec<RunResult>) -> Candidate {
        let figure = |number: usize| -> Vec<f64> { rows.iter().map(|row| row.figures[number]).collect() };
        let counted = |number: usize| problem.over.combine(&figure(number));
        // The more plants lack the figure, the worse.
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
