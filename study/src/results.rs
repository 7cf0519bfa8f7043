//! The results of the runs of a study.

use crate::Take;
use crate::columns::Columns;
use anyhow::Result;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// A column of the results.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
pub struct Quantity {
    /// Its name: `FMU.VARIABLE`, or the name of a figure.
    pub name: String,
    /// Its unit, if it has one.
    pub unit: Option<String>,
    /// For a figure of a single variable: the variable, and the aspect of it that the figure measures.
    #[serde(skip)]
    pub of: Option<(String, Aspect)>,
}

/// What a figure measures about a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aspect {
    /// Its minimum, maximum, mean or last value in the run.
    Taken(Take),
    /// The time outside its limits.
    Violation,
}

impl Quantity {
    /// A quantity with this name and unit.
    pub fn new(name: &str, unit: Option<&str>) -> Quantity {
        Quantity { name: name.into(), unit: unit.map(Into::into), of: None }
    }

    /// Whether low values of the figure count as better: true except for the minimum of a variable.
    pub fn is_lower_better(&self) -> bool {
        !matches!(self.of, Some((_, Aspect::Taken(Take::Min))))
    }
}

/// The result of one run.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct RunResult {
    /// A value for each figure of the experiment; NaN if missing.
    pub figures: Vec<f64>,
    /// The reason why the run failed, in which case all figures are NaN.
    pub error: Option<String>,
}

/// The named loops of a study's table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loops {
    /// The names, in table order.
    pub names: Vec<String>,
    /// The number of consecutive runs of the same loop; at least 1.
    pub runs: u64,
}

impl Loops {
    /// The loop of a run.
    pub fn name(&self, run: u64) -> &str {
        &self.names[(run / self.runs) as usize % self.names.len()]
    }
}

/// The approximate maximum number of values kept in memory: 2 MB, and up to as much again for spare capacity.
const MOST_VALUES: usize = 1 << 18;

/// The rows of all runs, in order. Those of a large study are in an unnamed file, from which each access reads: request
/// a whole column once rather than a value for each run.
#[derive(Debug)]
pub struct Results {
    /// The coordinates.
    pub coordinates: Vec<Quantity>,
    /// The figures.
    pub figures: Vec<Quantity>,
    /// The values: first the points of the runs, then the figures.
    columns: Columns,
    /// The loops of the runs, if the study has a table of named loops.
    pub loops: Option<Loops>,
    /// The reason for the failure of each failed run, by run.
    pub errors: BTreeMap<u64, String>,
}

impl Results {
    /// Creates empty results with these columns.
    pub fn new(coordinates: Vec<Quantity>, figures: Vec<Quantity>) -> Results {
        let columns = Columns::new(coordinates.len() + figures.len(), MOST_VALUES, &std::env::temp_dir());
        Results { coordinates, figures, columns, loops: None, errors: BTreeMap::new() }
    }

    /// Keeps the file of a large study in `folder` instead of the folder for temporary files, which may be small or in
    /// memory. The results must still be empty.
    pub fn kept_in(self, folder: &Path) -> Results {
        self.within(MOST_VALUES, folder)
    }

    /// Keeps at most about `most` values in memory, the others in a file in `folder`. The results must still be empty.
    pub(crate) fn within(self, most: usize, folder: &Path) -> Results {
        Results { columns: Columns::new(self.width(), most, folder), ..self }
    }

    /// The folder of the file.
    pub(crate) fn folder(&self) -> &Path {
        self.columns.folder()
    }

    /// Appends the next run.
    ///
    /// # Errors
    /// The file cannot be written, for instance because the disk is full.
    ///
    /// # Panics
    /// The number of values in the point or the row differs from the number of columns.
    pub fn push(&mut self, point: &[f64], row: &RunResult) -> Result<()> {
        assert_eq!(point.len(), self.coordinates.len(), "a value for each coordinate");
        assert_eq!(row.figures.len(), self.figures.len(), "a value for each figure");
        self.errors.extend(row.error.clone().map(|error| (self.count(), error)));
        self.columns.push(point.iter().chain(&row.figures).copied())
    }

    /// The number of runs.
    pub fn count(&self) -> u64 {
        self.columns.count()
    }

    /// The point of a run.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn point(&self, run: u64) -> Result<Vec<f64>> {
        self.columns.row(run, 0..self.coordinates.len())
    }

    /// The figures of a run; NaN where one is missing.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn figures_of(&self, run: u64) -> Result<Vec<f64>> {
        self.columns.row(run, self.coordinates.len()..self.width())
    }

    /// The values of a coordinate for all runs, by column index.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn coordinate(&self, column: usize) -> Result<Cow<'_, [f64]>> {
        self.column(column, 0..self.count())
    }

    /// The values of a figure for all runs, by column index.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn figure(&self, column: usize) -> Result<Cow<'_, [f64]>> {
        self.column(self.coordinates.len() + column, 0..self.count())
    }

    /// The number of coordinates and figures.
    pub(crate) fn width(&self) -> usize {
        self.coordinates.len() + self.figures.len()
    }

    /// The values of a range of runs, by column index, with the figures after the coordinates.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn column(&self, column: usize, runs: Range<u64>) -> Result<Cow<'_, [f64]>> {
        self.columns.column(column, runs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expect::Expectation;
    use crate::output::{write_csv, write_parquet};
    use crate::pictures::{scatter, tornado};
    use crate::sobol;
    use crate::summary::Summary;

    /// A thousand runs over two coordinates with two figures. Every seventh has no rise, every hundredth failed.
    fn filled(mut results: Results) -> Results {
        for run in 0..1000_u32 {
            let point = [f64::from(run * 7919 % 1000), f64::from(run % 10)];
            let error = (run % 100 == 99).then(|| format!("run {run} is dry"));
            let rise = if run % 7 == 6 { f64::NAN } else { point[0] - 3.0 * point[1] };
            let figures = if error.is_some() { vec![f64::NAN; 2] } else { vec![rise, point[0] / 3.0] };
            results.push(&point, &RunResult { figures, error }).unwrap();
        }
        results
    }

    fn empty() -> Results {
        let quantity = |name: &&str| Quantity::new(name, Some("s"));
        Results::new(["P.LAG", "C.GAIN"].iter().map(quantity).collect(), ["rise", "iae"].iter().map(quantity).collect())
    }

    /// Everything derived from results.
    fn made(results: &Results) -> (Summary, Vec<u8>, Vec<u8>, Vec<Option<String>>) {
        let (mut csv, mut parquet) = (Vec::new(), Vec::new());
        write_csv(&mut csv, results).unwrap();
        write_parquet(&mut parquet, results).unwrap();
        let summary = Summary::new(results, 10).unwrap();
        let verdict = |text: &str| Expectation::parse(text, &results.figures).unwrap().verdict(results, false).unwrap();
        let texts = vec![
            scatter(results, &summary, 0, &[]).unwrap(),
            tornado(results, &summary, 1).unwrap(),
            Some(format!("{:?}", ["rise < 500 s", "p5(rise) > 9000", "mean(iae) < 1"].map(verdict))),
            Some(format!("{:?}", sobol::indices(results, 1, 2).unwrap())),
        ];
        (summary, csv, parquet, texts)
    }

    #[test]
    fn results_in_a_file_come_to_the_same_bytes_as_those_in_memory() {
        let folder = tempfile::tempdir().unwrap();
        let in_memory = made(&filled(empty()));
        assert!(in_memory.3[..2].iter().all(Option::is_some), "there are pictures");
        // The number of the 4000 values in memory: blocks of 128 rows, of 333 rows, of one row.
        for most in [512, 1332, 1] {
            let in_file = filled(empty().within(most, folder.path()));
            assert!(made(&in_file) == in_memory, "{most}");
            assert_eq!(in_file.point(990).unwrap(), [f64::from(990 * 7919 % 1000), 0.0]);
            assert_eq!(in_file.figures_of(3).unwrap()[1], f64::from(3 * 7919 % 1000) / 3.0);
        }
    }
}
