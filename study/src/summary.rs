//! Summarizes the runs of a study: percentiles, and the worst runs with their settings.
//!
//! A *percentile* is interpolated linearly between the two nearest values, as NumPy, pandas and spreadsheets do by
//! default: of n values in ascending order, counted from 0, percentile p is at position p / 100 (n - 1).
//!
//! Low values of a figure are better, except for `FMU.VARIABLE.min`, where high values are. For `FMU.VARIABLE.mean` and
//! `FMU.VARIABLE.last`, where neither is better, the highest value counts as the worst.

use crate::columns::Spill;
use crate::interval;
use crate::results::{Quantity, Results};
use anyhow::Result;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The percentiles in a summary.
pub const PERCENTS: [f64; 7] = [1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0];

/// The maximum size of the orders of coordinates kept in memory, in bytes.
const MOST_BYTES: usize = 1 << 22;

/// The summary of a study. The same results yield the same summary, bit for bit.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Summary {
    /// The number of runs.
    pub runs: u64,
    /// The number of failed runs.
    pub failed: u64,
    /// The reasons for failures, most frequent first.
    pub failures: Vec<Failure>,
    /// The coordinates of the points.
    pub coordinates: Vec<Quantity>,
    /// A distribution for each figure.
    pub figures: Vec<Distribution>,
}

/// Runs that failed for the same reason.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
pub struct Failure {
    /// The message of the FMU or the program.
    pub reason: String,
    /// The number of runs that failed for this reason.
    pub count: u64,
    /// The first of these runs.
    pub runs: Vec<u64>,
}

/// The distribution of a figure over the runs in which it is finite.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Distribution {
    /// The figure.
    pub figure: Quantity,
    /// The number of runs in which it is finite.
    pub count: u64,
    /// The minimum.
    pub min: Option<f64>,
    /// The percentiles [`PERCENTS`], each as a pair of percentage and value; empty if no run has a finite value.
    pub percentiles: Vec<(f64, f64)>,
    /// The 95 % confidence intervals of these percentiles in the population from which the runs were sampled; `None`
    /// where there are too few runs.
    pub intervals: Vec<Option<(f64, f64)>>,
    /// The maximum.
    pub max: Option<f64>,
    /// The mean.
    pub mean: Option<f64>,
    /// The sample standard deviation (with the divisor count - 1); `None` for fewer than two runs.
    pub deviation: Option<f64>,
    /// The run with the best value. Among equal values, here and below, the run with the lowest number comes first.
    pub best: Option<u64>,
    /// The run whose value is the median or, for an even count, the upper of the two middle values.
    pub middle: Option<u64>,
    /// The worst runs, worst first.
    pub worst: Vec<u64>,
    /// The first runs that lack the figure without having failed, for instance because they have not settled.
    pub absent: Vec<u64>,
    /// Spearman's rank correlation with each coordinate, from -1 to 1: positive if the figure rises with the
    /// coordinate. `None` if either has the same value in all runs with the figure.
    pub correlations: Vec<Option<f64>>,
}

impl Summary {
    /// Summarizes results. Each list has at most `worst` runs: the worst runs of a figure, the runs that lack it, and
    /// the runs that failed for the same reason.
    ///
    /// # Errors
    /// The results of a large study cannot be read.
    pub fn new(results: &Results, worst: usize) -> Result<Summary> {
        let mut reasons: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
        for (run, reason) in &results.errors {
            reasons.entry(reason).or_default().push(*run);
        }
        let failure = |(reason, runs): (&str, Vec<u64>)| Failure {
            reason: reason.into(),
            count: runs.len() as u64,
            runs: runs.into_iter().take(worst).collect(),
        };
        let mut failures: Vec<Failure> = reasons.into_iter().map(failure).collect();
        failures.sort_by_key(|failure| (std::cmp::Reverse(failure.count), failure.runs.first().copied()));
        let orders = Orders::new(results)?;
        let figures = 0..results.figures.len();
        Ok(Summary {
            runs: results.count(),
            failed: results.errors.len() as u64,
            failures,
            coordinates: results.coordinates.clone(),
            figures: figures.map(|column| Distribution::new(results, column, &orders, worst)).collect::<Result<_>>()?,
        })
    }

    /// The two coordinates most strongly correlated with a figure, strongest first; fewer if there are fewer
    /// coordinates. Coordinates with equal correlations, or without any, keep their order.
    pub fn strongest(&self, figure: usize) -> Vec<usize> {
        let strength = |coordinate: &usize| self.figures[figure].correlations[*coordinate].map_or(0.0, f64::abs);
        let mut coordinates: Vec<usize> = (0..self.coordinates.len()).collect();
        coordinates.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
        coordinates.truncate(2);
        coordinates
    }
}

/// The runs with a finite value, ordered by that value. A study has fewer runs than 2^32.
fn ascending(values: &[f64]) -> Vec<u32> {
    let mut rated: Vec<(f64, u32)> = values.iter().copied().zip(0..).collect();
    rated.retain(|(value, _)| value.is_finite());
    // Adding 0 turns -0 into 0: `total_cmp` distinguishes the two.
    rated.sort_unstable_by(|a, b| (a.0 + 0.0).total_cmp(&(b.0 + 0.0)).then(a.1.cmp(&b.1)));
    // Collecting in place would keep the larger allocation.
    let mut order = Vec::with_capacity(rated.len());
    order.extend(rated.into_iter().map(|(_, run)| run));
    order
}

/// For each coordinate, the runs in ascending order of its value. They are computed once for all figures, and kept in a
/// file if they are large.
struct Orders {
    runs: Spill,
    /// For each coordinate, the byte position at which its order starts, and the number of runs in it.
    places: Vec<(u64, usize)>,
}

impl Orders {
    fn new(results: &Results) -> Result<Orders> {
        let mut orders = Orders { runs: Spill::new(MOST_BYTES, results.folder()), places: Vec::new() };
        for column in 0..results.coordinates.len() {
            let order = ascending(&results.coordinate(column)?);
            orders.places.push((orders.runs.append(order.iter().map(|run| run.to_le_bytes()))?, order.len()));
        }
        Ok(orders)
    }

    fn of_coordinate(&self, column: usize) -> Result<Vec<u32>> {
        let (begin, count) = self.places[column];
        let mut order = Vec::with_capacity(count);
        self.runs.read(begin, count, u32::from_le_bytes, &mut order)?;
        Ok(order)
    }
}

impl Distribution {
    fn new(results: &Results, column: usize, orders: &Orders, worst: usize) -> Result<Distribution> {
        let (mut distribution, ranks) = Distribution::alone(results, column, worst)?;
        for coordinate in 0..results.coordinates.len() {
            let order = orders.of_coordinate(coordinate)?;
            distribution.correlations.push(ranks.correlation(order, &results.coordinate(coordinate)?));
        }
        Ok(distribution)
    }

    /// The distribution without correlations, and the ranks from which these are computed.
    fn alone(results: &Results, column: usize, worst: usize) -> Result<(Distribution, Ranks)> {
        let values = results.figure(column)?;
        let value = |run: &u32| values[*run as usize];
        let order = ascending(&values);
        let sorted: Vec<f64> = order.iter().map(value).collect();
        let figure = results.figures[column].clone();
        // At both ends, runs with equal values are in ascending order.
        let lowest = || order.iter().map(|run| u64::from(*run));
        let highest = || order.chunk_by(|a, b| value(a) == value(b)).rev().flatten().map(|run| u64::from(*run));
        let is_lower_better = figure.is_lower_better();
        let absent = (0..).zip(&*values).filter(|(run, value)| value.is_nan() && !results.errors.contains_key(run));
        let distribution = Distribution {
            count: order.len() as u64,
            min: sorted.first().copied(),
            percentiles: PERCENTS
                .into_iter()
                .filter_map(|percent| Some((percent, percentile(&sorted, percent)?)))
                .collect(),
            intervals: PERCENTS.iter().map(|percent| interval::percentile(&sorted, *percent)).collect(),
            max: sorted.last().copied(),
            mean: mean(&sorted),
            deviation: deviation(&sorted),
            best: if is_lower_better { lowest().next() } else { highest().next() },
            middle: order.get(order.len() / 2).map(|run| u64::from(*run)),
            worst: if is_lower_better { highest().take(worst).collect() } else { lowest().take(worst).collect() },
            absent: absent.map(|(run, _)| run).take(worst).collect(),
            correlations: Vec::new(),
            figure,
        };
        drop(sorted);
        Ok((distribution, Ranks::new(&order, &values)))
    }
}

/// A percentile (0 to 100) of values in ascending order; `None` if there are no values. Values may be infinite.
pub fn percentile(sorted: &[f64], percent: f64) -> Option<f64> {
    let place = percent / 100.0 * sorted.len().checked_sub(1)? as f64;
    let (below, part) = (place.floor() as usize, place.fract());
    let low = sorted[below];
    let high = sorted.get(below + 1).copied().filter(|high| part > 0.0 && *high != low);
    Some(high.map_or(low, |high| match (low.is_finite(), high.is_finite()) {
        // Interpolate from the nearer value, as NumPy does, to get the same digits.
        (true, true) if part < 0.5 => low + (high - low) * part,
        (true, true) => high - (high - low) * (1.0 - part),
        (false, _) => low,
        (true, false) => high,
    }))
}

/// The mean; `None` if there are no values, or if their sum overflows.
pub fn mean(values: &[f64]) -> Option<f64> {
    let mean = sum(values.iter().copied()) / values.len() as f64;
    mean.is_finite().then_some(mean)
}

/// The sample standard deviation; `None` if there are fewer than two values, or if it overflows.
fn deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    let squares = sum(values.iter().map(|value| (value - mean) * (value - mean)));
    let deviation = (squares / (values.len() - 1) as f64).sqrt();
    deviation.is_finite().then_some(deviation)
}

/// The sum with compensation of rounding errors (Neumaier).
fn sum(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0_f64);
    for value in values {
        let next = sum + value;
        lost += if sum.abs() >= value.abs() { (sum - next) + value } else { (value - next) + sum };
        sum = next;
    }
    sum + lost
}

/// The 0-based rank of each run's figure; equal values share the mean of their ranks.
struct Ranks {
    ranks: Vec<f64>,
    count: usize,
}

impl Ranks {
    /// Ranks the values; `order` lists the runs with a finite value, in ascending order.
    fn new(order: &[u32], values: &[f64]) -> Ranks {
        let mut ranks = vec![f64::NAN; values.len()];
        shared_ranks(order, values, |run, rank| ranks[run as usize] = rank);
        Ranks { ranks, count: order.len() }
    }

    /// The correlation with the ranks of a coordinate with these values; `order` lists the runs in their ascending
    /// order.
    fn correlation(&self, mut order: Vec<u32>, values: &[f64]) -> Option<f64> {
        order.retain(|run| !self.ranks[*run as usize].is_nan());
        if order.len() < self.count || self.count < 2 {
            return None;
        }
        let mean = (self.count - 1) as f64 / 2.0;
        let (mut both, mut own, mut other) = (0.0, 0.0, 0.0);
        shared_ranks(&order, values, |run, rank| {
            let (a, b) = (self.ranks[run as usize] - mean, rank - mean);
            (both, own, other) = (both + a * b, own + a * a, other + b * b);
        });
        (own > 0.0 && other > 0.0).then(|| both / (own * other).sqrt())
    }
}

/// Calls `tell` with each run in `order` and its rank; equal values share the mean of their ranks.
fn shared_ranks(order: &[u32], values: &[f64], mut tell: impl FnMut(u32, f64)) {
    let mut first = 0;
    for equal in order.chunk_by(|a, b| values[*a as usize] == values[*b as usize]) {
        let rank = first as f64 + (equal.len() - 1) as f64 / 2.0;
        equal.iter().for_each(|run| tell(*run, rank));
        first += equal.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Take;
    use crate::results::{Aspect, RunResult};

    /// Results with one figure and one coordinate; NaN marks a run without the figure.
    fn results(figure: &str, values: &[(f64, f64)]) -> Results {
        let quantity = |name: &str| {
            let of = name.strip_suffix(".min").map(|variable| (variable.into(), Aspect::Taken(Take::Min)));
            Quantity { of, ..Quantity::new(name, None) }
        };
        let mut results = Results::new(vec![quantity("P.GAIN")], vec![quantity(figure)]);
        for (point, value) in values {
            results.push(&[*point], &RunResult { figures: vec![*value], error: None }).unwrap();
        }
        results
    }

    fn of(figure: &str, values: &[f64]) -> Distribution {
        let values: Vec<(f64, f64)> = values.iter().map(|value| (0.0, *value)).collect();
        Summary::new(&results(figure, &values), 3).unwrap().figures.remove(0)
    }

    #[test]
    fn percentiles_are_interpolated_between_the_nearest_values_as_numpy_does() {
        // Among five values, the positions of percentiles 5, 50 and 95 are 0.2, 2 and 3.8.
        let five = of("iae", &[50.0, 10.0, 40.0, 20.0, 30.0]);
        let percent =
            |of: &Distribution, wanted: f64| of.percentiles.iter().find(|(percent, _)| *percent == wanted).unwrap().1;
        assert_eq!((percent(&five, 5.0), percent(&five, 50.0), percent(&five, 95.0)), (12.0, 30.0, 48.0));
        assert_eq!((five.min, five.max, five.mean), (Some(10.0), Some(50.0), Some(30.0)));
        let two = of("iae", &[1.0, 2.0]);
        assert_eq!((percent(&two, 25.0), percent(&two, 50.0), percent(&two, 75.0)), (1.25, 1.5, 1.75));
        assert_eq!(percent(&of("iae", &[7.0]), 99.0), 7.0);
        assert_eq!(percentile(&[], 50.0), None);
    }

    #[test]
    fn the_deviation_is_that_of_a_sample_and_does_not_lose_digits() {
        let textbook = of("iae", &[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        assert_eq!((textbook.mean, textbook.deviation), (Some(5.0), Some((32.0_f64 / 7.0).sqrt())));
        // The sum of squares would lose all digits of the deviation.
        let large = of("iae", &[1e15 + 4.0, 1e15 + 7.0, 1e15 + 13.0, 1e15 + 16.0]);
        assert_eq!((large.mean, large.deviation), (Some(1e15 + 10.0), Some(30.0_f64.sqrt())));
        let compensated = of("iae", &[1e16, 1.0, 1.0, -1e16]);
        assert_eq!(compensated.mean, Some(0.5));
        assert_eq!(of("iae", &[3.0]).deviation, None);
    }

    #[test]
    fn the_lowest_value_is_the_best_but_for_the_least_value_of_a_variable() {
        let iae = of("iae", &[3.0, 1.0, 5.0, 4.0]);
        assert_eq!((iae.best, iae.middle, iae.worst), (Some(1), Some(3), vec![2, 3, 0]));
        let level = of("TANK.LEVEL.min", &[3.0, 1.0, 5.0, 4.0]);
        assert_eq!((level.best, level.middle, level.worst), (Some(2), Some(3), vec![1, 0, 3]));
    }

    #[test]
    fn of_equal_values_the_run_with_the_lower_number_comes_first() {
        let equal = of("iae", &[2.0, 1.0, 2.0, 1.0, 0.0, -0.0]);
        assert_eq!((equal.best, equal.worst), (Some(4), vec![0, 2, 1]));
        assert_eq!(of("X.min", &[2.0, 1.0, 2.0, 1.0]).best, Some(0));
    }

    #[test]
    fn what_cannot_be_said_and_what_failed_do_not_count_and_are_named() {
        let mut results = results("settling", &[(1.0, 5.0), (2.0, f64::NAN), (3.0, 7.0)]);
        for reason in ["b", "a", "b"] {
            results.push(&[4.0], &RunResult { figures: vec![f64::NAN], error: Some(reason.into()) }).unwrap();
        }
        let summary = Summary::new(&results, 1).unwrap();
        assert_eq!((summary.runs, summary.failed), (6, 3));
        let failures: Vec<_> = summary
            .failures
            .iter()
            .map(|failure| (failure.reason.as_str(), failure.count, &failure.runs[..]))
            .collect();
        assert_eq!(failures, [("b", 2, &[3][..]), ("a", 1, &[4])]);
        let settling = &summary.figures[0];
        assert_eq!((settling.count, settling.mean, &settling.absent[..]), (2, Some(6.0), &[1][..]));
        let none = of("settling", &[f64::NAN]);
        assert_eq!((none.count, none.min, none.mean, none.best, none.middle), (0, None, None, None, None));
        assert!(none.percentiles.is_empty() && none.worst.is_empty());
    }

    #[test]
    fn a_coordinate_correlates_by_rank() {
        let correlation =
            |values: &[(f64, f64)]| Summary::new(&results("iae", values), 1).unwrap().figures[0].correlations[0];
        // Any rising curve correlates like a straight line; a run without the figure is ignored.
        assert_eq!(correlation(&[(1.0, 1.0), (2.0, 8.0), (9.0, f64::NAN), (3.0, 1000.0)]), Some(1.0));
        assert_eq!(correlation(&[(1.0, 3.0), (2.0, 2.0), (3.0, 1.0)]), Some(-1.0));
        // Ranks 0, 1.5, 1.5, 3 and 0, 1, 2, 3: 4.5 / sqrt(4.5 * 5).
        let shared = correlation(&[(1.0, 1.0), (2.0, 2.0), (2.0, 3.0), (4.0, 4.0)]).unwrap();
        assert!((shared - 4.5 / 22.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(correlation(&[(1.0, 1.0), (1.0, 2.0)]), None);
        assert_eq!(correlation(&[(1.0, 1.0), (2.0, 1.0)]), None);
    }

    #[test]
    fn the_strongest_coordinates_come_first() {
        let quantity = |name: &str| Quantity::new(name, None);
        let mut results = Results::new(["A", "B", "C"].map(quantity).to_vec(), vec![quantity("iae")]);
        for (point, value) in
            [([1.0, 4.0, 2.0], 1.0), ([1.0, 3.0, 1.0], 2.0), ([1.0, 2.0, 4.0], 3.0), ([1.0, 1.0, 3.0], 4.0)]
        {
            results.push(&point, &RunResult { figures: vec![value], error: None }).unwrap();
        }
        assert_eq!(Summary::new(&results, 1).unwrap().strongest(0), [1, 2]);
    }
}
