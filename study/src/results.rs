//! The results of the runs of a study.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A column of the results.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
pub struct Quantity {
    /// Its name: `FMU.VARIABLE` or that of a figure.
    pub name: String,
    /// Its unit, if there is one.
    pub unit: Option<String>,
}

/// The result of one run.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Row {
    /// A value for each figure of the experiment; NaN if it has no value.
    pub figures: Vec<f64>,
    /// Why the run failed; then all figures are NaN.
    pub error: Option<String>,
}

/// The names of the loops of a study with a table of loops.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loops {
    /// The names, in the order of the table.
    pub names: Vec<String>,
    /// This many runs one behind the other are of the same loop; 1 or more.
    pub runs: u64,
}

impl Loops {
    /// The loop of a run.
    pub fn of(&self, run: u64) -> &str {
        &self.names[(run / self.runs) as usize % self.names.len()]
    }
}

/// The rows of all runs, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Results {
    /// What the runs were given.
    pub coordinates: Vec<Quantity>,
    /// What they came to.
    pub figures: Vec<Quantity>,
    /// The points of the runs, one behind the other.
    points: Vec<f64>,
    /// The figures of the runs, one behind the other.
    values: Vec<f64>,
    /// The loops that the runs are of, if the study has a table of loops with names.
    pub loops: Option<Loops>,
    /// Why runs failed, by their numbers.
    pub errors: BTreeMap<u64, String>,
    count: u64,
}

impl Results {
    /// Empty, with these columns.
    pub fn new(coordinates: Vec<Quantity>, figures: Vec<Quantity>) -> Results {
        Results { coordinates, figures, ..Results::default() }
    }

    /// Adds the next run.
    ///
    /// # Panics
    /// The point or the row has another number of values than there are columns.
    pub fn push(&mut self, point: &[f64], row: &Row) {
        assert_eq!(point.len(), self.coordinates.len(), "a value for each coordinate");
        assert_eq!(row.figures.len(), self.figures.len(), "a value for each figure");
        self.points.extend_from_slice(point);
        self.values.extend_from_slice(&row.figures);
        self.errors.extend(row.error.clone().map(|error| (self.count, error)));
        self.count += 1;
    }

    /// How many runs there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The point of a run.
    pub fn point(&self, run: u64) -> &[f64] {
        let width = self.coordinates.len();
        &self.points[run as usize * width..][..width]
    }

    /// The figures of a run; NaN where one has no value.
    pub fn figures_of(&self, run: u64) -> &[f64] {
        let width = self.figures.len();
        &self.values[run as usize * width..][..width]
    }

    /// The values of a figure, by the number of its column, for all runs.
    pub fn figure(&self, column: usize) -> impl Iterator<Item = f64> {
        (0..self.count).map(move |run| self.figures_of(run)[column])
    }
}
