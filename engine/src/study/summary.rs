//! What the runs of a study come to together: percentiles, and the worst runs with their settings.

use crate::study::results::{Quantity, Results};
use serde::{Deserialize, Serialize};

/// A summary. The same results give the same summary, bit for bit.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Summary {
    /// How many runs there are.
    pub runs: u64,
    /// How many of them failed.
    pub failed: u64,
    /// A distribution for each figure.
    pub figures: Vec<Distribution>,
}

/// How a figure is distributed over the runs.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Distribution {
    /// The figure.
    pub figure: Quantity,
    /// In how many runs it can be said.
    pub count: u64,
    /// The least value.
    pub min: Option<f64>,
    /// The percentiles 1, 5, 25, 50, 75, 95 and 99, with their numbers.
    pub percentiles: Vec<(f64, f64)>,
    /// The greatest value.
    pub max: Option<f64>,
    /// The mean.
    pub mean: Option<f64>,
    /// The standard deviation.
    pub deviation: Option<f64>,
    /// The best run, the run in the middle, and the worst runs, the worst first: the figure's lowest value is the best.
    pub best: Option<u64>,
    /// The run with the median, or the next above it.
    pub middle: Option<u64>,
    /// The worst runs.
    pub worst: Vec<u64>,
}

impl Summary {
    /// The summary of results, with `worst` worst runs for each figure.
    pub fn of(results: &Results, worst: usize) -> Summary {
        let _ = (results, worst);
        unimplemented!()
    }
}
