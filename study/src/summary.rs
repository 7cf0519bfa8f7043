//! What the runs of a study have in common: percentiles, and the worst runs with their settings.
//!
//! A *percentile* is interpolated linearly between the two nearest values, as NumPy, pandas and spreadsheets do by default:
//! of n values in ascending order, counted from 0, percentile p is at the place p / 100 (n - 1).
//!
//! Which value of a figure is the best, says [`figures::FIGURES`]. Of the other figures the lowest is, but for the least value of a
//! variable, `FMU.VARIABLE.min`: the highest is the best. For `FMU.VARIABLE.mean` and `FMU.VARIABLE.last`, neither end of which is better, the
//! highest value counts as the worst.

use crate::columns::Spill;
use crate::interval;
use crate::results::{Quantity, Results};
use anyhow::Result;
use control::figures;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Which percentiles a summary has.
pub const PERCENTS: [f64; 7] = [1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0];

/// At most this many bytes of the orders of coordinates are kept in memory.
const MOST_BYTES: usize = 1 << 22;

/// A summary. The same results give the same summary, bit for bit.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Summary {
    /// How many runs there are.
    pub runs: u64,
    /// How many of them failed.
    pub failed: u64,
    /// Why runs failed, the most frequent reason first.
    pub failures: Vec<Failure>,
    /// What varies.
    pub coordinates: Vec<Quantity>,
    /// A distribution for each figure.
    pub figures: Vec<Distribution>,
}

/// Runs that failed for the same reason.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
pub struct Failure {
    /// What the FMU or the program said.
    pub reason: String,
    /// How many runs failed for it.
    pub count: u64,
    /// The first of them.
    pub runs: Vec<u64>,
}

/// How a figure is distributed over the runs. A run counts if its figure is a finite number.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Distribution {
    /// The figure.
    pub figure: Quantity,
    /// In how many runs it is a finite number.
    pub count: u64,
    /// The least value.
    pub min: Option<f64>,
    /// The percentiles [`PERCENTS`], with their numbers.
    pub percentiles: Vec<(f64, f64)>,
    /// For each of them the interval that holds that of all machines with 95 % confidence, as far as there are enough runs for it.
    pub intervals: Vec<Option<(f64, f64)>>,
    /// The greatest value.
    pub max: Option<f64>,
    /// The mean.
    pub mean: Option<f64>,
    /// The standard deviation of a sample (divided by the count less 1), or `None` for a single run.
    pub deviation: Option<f64>,
    /// The best run. Of runs with the same value the one with the lower number comes first, here and in all that follows.
    pub best: Option<u64>,
    /// The run with the median, or the next above it.
    pub middle: Option<u64>,
    /// The worst runs, the worst first.
    pub worst: Vec<u64>,
    /// The first runs that have not failed and yet have no such figure, for instance because they have not settled.
    pub absent: Vec<u64>,
    /// The rank correlation (Spearman) with each coordinate, from -1 to 1: above 0 if the figure rises with it. None if one of
    /// the two has the same value in all runs.
    pub correlations: Vec<Option<f64>>,
}

impl Summary {
    /// The summary of results. Of each figure it names the `worst` worst runs, and as many of those that failed for a reason or
    /// have no figure.
    ///
    /// # Errors
    /// The results of a large study cannot be read.
    pub fn of(results: &Results, worst: usize) -> Result<Summary> {
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
        let orders = Orders::of(results)?;
        let figures = 0..results.figures.len();
        Ok(Summary {
            runs: results.count(),
            failed: results.errors.len() as u64,
            failures,
            coordinates: results.coordinates.clone(),
            figures: figures.map(|column| Distribution::of(results, column, &orders, worst)).collect::<Result<_>>()?,
        })
    }

    /// The two coordinates with the strongest correlation with a figure, the stronger one first; fewer if there are fewer
    /// coordinates. Without correlations the first two.
    pub fn strongest(&self, figure: usize) -> Vec<usize> {
        let strength = |coordinate: &usize| self.figures[figure].correlations[*coordinate].map_or(0.0, f64::abs);
        let mut coordinates: Vec<usize> = (0..self.coordinates.len()).collect();
        coordinates.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
        coordinates.truncate(2);
        coordinates
    }
}

/// Whether the lowest value of a figure is the best.
pub fn is_lower_better(figure: &str) -> bool {
    figures::find(figure).map_or(!figure.ends_with(".min"), |known| known.is_lower_better)
}

/// The runs whose value is a finite number, by this value. A study has fewer runs than 2^32.
fn ascending(values: &[f64]) -> Vec<u32> {
    let mut rated: Vec<(f64, u32)> = values.iter().copied().zip(0..).collect();
    rated.retain(|(value, _)| value.is_finite());
    // Adding 0 makes -0 a 0, which is the same number.
    rated.sort_unstable_by(|a, b| (a.0 + 0.0).total_cmp(&(b.0 + 0.0)).then(a.1.cmp(&b.1)));
    // A list of its own: collected, it would keep the room of the other one.
    let mut order = Vec::with_capacity(rated.len());
    order.extend(rated.into_iter().map(|(_, run)| run));
    order
}

/// The runs in ascending order of each coordinate, which each figure needs. Those of many runs and coordinates are in a file.
struct Orders {
    runs: Spill,
    /// Where those of a coordinate begin, and how many they are.
    places: Vec<(u64, usize)>,
}

impl Orders {
    fn of(results: &Results) -> Result<Orders> {
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
    fn of(results: &Results, column: usize, orders: &Orders, worst: usize) -> Result<Distribution> {
        let (mut distribution, ranks) = Distribution::alone(results, column, worst)?;
        for coordinate in 0..results.coordinates.len() {
            let order = orders.of_coordinate(coordinate)?;
            distribution.correlations.push(ranks.correlation(order, &results.coordinate(coordinate)?));
        }
        Ok(distribution)
    }

    /// Without correlations, but with the ranks for them.
    fn alone(results: &Results, column: usize, worst: usize) -> Result<(Distribution, Ranks)> {
        let values = results.figure(column)?;
        let value = |run: &u32| values[*run as usize];
        let order = ascending(&values);
        let sorted: Vec<f64> = order.iter().map(value).collect();
        let figure = results.figures[column].clone();
        // Equal values are in the order of their runs, from both ends.
        let lowest = || order.iter().map(|run| u64::from(*run));
        let highest = || order.chunk_by(|a, b| value(a) == value(b)).rev().flatten().map(|run| u64::from(*run));
        let is_lower_better = is_lower_better(&figure.name);
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
        Ok((distribution, Ranks::of(&order, &values)))
    }
}

/// A percentile of values in ascending order, from 0 to 100; none if there are no values. Values may be infinite.
pub fn percentile(sorted: &[f64], percent: f64) -> Option<f64> {
    let place = percent / 100.0 * sorted.len().checked_sub(1)? as f64;
    let (below, part) = (place.floor() as usize, place.fract());
    let low = sorted[below];
    let high = sorted.get(below + 1).copied().filter(|high| part > 0.0 && *high != low);
    Some(high.map_or(low, |high| match (low.is_finite(), high.is_finite()) {
        // From the nearer of the two, as NumPy does, so that the digits are the same.
        (true, true) if part < 0.5 => low + (high - low) * part,
        (true, true) => high - (high - low) * (1.0 - part),
        (false, _) => low,
        (true, false) => high,
    }))
}

/// The mean; none if there are no values, or if their sum is too large.
pub fn mean(values: &[f64]) -> Option<f64> {
    let mean = sum(values.iter().copied()) / values.len() as f64;
    mean.is_finite().then_some(mean)
}

/// The standard deviation of a sample; none if there are fewer than two values, or if it is too large.
fn deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    let squares = sum(values.iter().map(|value| (value - mean) * (value - mean)));
    let deviation = (squares / (values.len() - 1) as f64).sqrt();
    deviation.is_finite().then_some(deviation)
}

/// The sum with the rounding errors added in the end (Neumaier).
fn sum(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0_f64);
    for value in values {
        let next = sum + value;
        lost += if sum.abs() >= value.abs() { (sum - next) + value } else { (value - next) + sum };
        sum = next;
    }
    sum + lost
}

/// The rank of each run's figure among all figures, from 0 on; runs with the same value share the mean of their ranks.
struct Ranks {
    ranks: Vec<f64>,
    count: usize,
}

impl Ranks {
    /// `order` has the runs with a figure in the order of its value.
    fn of(order: &[u32], values: &[f64]) -> Ranks {
        let mut ranks = vec![f64::NAN; values.len()];
        shared_ranks(order, values, |run, rank| ranks[run as usize] = rank);
        Ranks { ranks, count: order.len() }
    }

    /// The correlation with the ranks of a coordinate; `order` has all runs in the order of its value.
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

/// Tells the rank of each run.
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
    use crate::results::Row;

    /// Results of one figure over one coordinate; NaN is a run without the figure.
    fn results(figure: &str, values: &[(f64, f64)]) -> Results {
        let quantity = |name: &str| Quantity { name: name.into(), unit: None };
        let mut results = Results::new(vec![quantity("P.GAIN")], vec![quantity(figure)]);
        for (point, value) in values {
            results.push(&[*point], &Row { figures: vec![*value], error: None }).unwrap();
        }
        results
    }

    fn of(figure: &str, values: &[f64]) -> Distribution {
        let values: Vec<(f64, f64)> = values.iter().map(|value| (0.0, *value)).collect();
        Summary::of(&results(figure, &values), 3).unwrap().figures.remove(0)
    }

    #[test]
    fn percentiles_are_interpolated_between_the_nearest_values_as_numpy_does() {
        // The places of 5, 50 and 95 % among five values are 0.2, 2 and 3.8.
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
        // The sum of the squares would have lost it all.
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
            results.push(&[4.0], &Row { figures: vec![f64::NAN], error: Some(reason.into()) }).unwrap();
        }
        let summary = Summary::of(&results, 1).unwrap();
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
            |values: &[(f64, f64)]| Summary::of(&results("iae", values), 1).unwrap().figures[0].correlations[0];
        // A curve that rises counts as much as a line; a run without the figure does not count.
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
        let quantity = |name: &str| Quantity { name: name.into(), unit: None };
        let mut results = Results::new(["A", "B", "C"].map(quantity).to_vec(), vec![quantity("iae")]);
        for (point, value) in
            [([1.0, 4.0, 2.0], 1.0), ([1.0, 3.0, 1.0], 2.0), ([1.0, 2.0, 4.0], 3.0), ([1.0, 1.0, 3.0], 4.0)]
        {
            results.push(&point, &Row { figures: vec![value], error: None }).unwrap();
        }
        assert_eq!(Summary::of(&results, 1).unwrap().strongest(0), [1, 2]);
    }
}
