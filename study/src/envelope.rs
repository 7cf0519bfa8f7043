//! The envelope of most runs: the 5th and 95th percentile of the process value at each time.

use crate::experiment::Experiment;
use crate::pool::Pool;
use crate::sampling::Permutation;
use crate::summary::percentile;
use anyhow::Result;

/// The permitted number of runs in an envelope; these runs are repeated to obtain their curves.
const RUNS: std::ops::RangeInclusive<u64> = 20..=200;

/// The percentiles of a signal over the runs, at equidistant times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Envelope {
    /// The number of runs in the envelope.
    pub runs: u64,
    /// The times in seconds.
    pub times: Vec<f64>,
    /// The 5th percentile at each time.
    pub low: Vec<f64>,
    /// The 95th percentile at each time.
    pub high: Vec<f64>,
}

/// The runs chosen for an envelope: a random tenth, at least 20 and at most 200; empty if there are fewer than 20.
fn chosen(count: u64) -> Vec<u64> {
    if count < *RUNS.start() {
        return Vec::new();
    }
    // Evenly spaced runs might all share one value of a grid axis.
    let order = Permutation::new(0, 0, count);
    (0..(count / 10).clamp(*RUNS.start(), *RUNS.end())).map(|place| order.image(place)).collect()
}

impl Envelope {
    /// The envelope of the process value; `None` if the loop's process value is unknown or there are too few runs. The
    /// runs are repeated with new instances, and `again` receives the number of each with its figures.
    ///
    /// # Errors
    /// A worker cannot be started, or `again` fails.
    pub fn new(
        pool: &mut Pool,
        experiment: &Experiment,
        is_failed: impl Fn(u64) -> bool,
        mut again: impl FnMut(u64, &[f64]) -> Result<()>,
    ) -> Result<Option<Envelope>> {
        let runs: Vec<u64> = chosen(experiment.count()).into_iter().filter(|run| !is_failed(*run)).collect();
        let times = experiment.trace_times();
        if (runs.len() as u64) < *RUNS.start() {
            return Ok(None);
        }
        let mut traces = Vec::new();
        pool.traces(runs.len() as u64, &|place| experiment.point(runs[place as usize]), &mut |place, mut row| {
            if row.error.is_none() {
                traces.push(row.figures.split_off(experiment.figures.len()));
                again(runs[place as usize], &row.figures)?;
            }
            Ok(())
        })?;
        // The runs are repeated even without a process value to draw, because `again` compares their figures.
        Ok(if times.is_empty() { None } else { Envelope::of_traces(times, &traces) })
    }

    /// The envelope of curves; `None` if at some time none of them has a finite value.
    fn of_traces(times: Vec<f64>, traces: &[Vec<f64>]) -> Option<Envelope> {
        let mut envelope = Envelope { runs: traces.len() as u64, times, ..Envelope::default() };
        for place in 0..envelope.times.len() {
            let mut values: Vec<f64> = traces.iter().filter_map(|trace| trace.get(place).copied()).collect();
            values.retain(|value| value.is_finite());
            values.sort_unstable_by(f64::total_cmp);
            envelope.low.push(percentile(&values, 5.0)?);
            envelope.high.push(percentile(&values, 95.0)?);
        }
        Some(envelope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_has_the_percentiles_5_and_95_at_each_time() {
        let traces: Vec<Vec<f64>> = (0..=100).map(|run| vec![7.0, f64::from(run)]).collect();
        let envelope = Envelope::of_traces(vec![0.0, 1.0], &traces).unwrap();
        assert_eq!((envelope.runs, envelope.low, envelope.high), (101, vec![7.0, 5.0], vec![7.0, 95.0]));
        assert_eq!(Envelope::of_traces(vec![0.0], &[vec![f64::NAN]]), None);
    }

    #[test]
    fn it_is_of_a_tenth_of_the_runs_each_once() {
        let lengths = [19, 20, 300, 10_000].map(|count| chosen(count).len());
        assert_eq!(lengths, [0, 20, 30, 200]);
        let mut runs = chosen(300);
        runs.sort_unstable();
        runs.dedup();
        assert!(runs.len() == 30 && runs.iter().all(|run| *run < 300));
    }
}
