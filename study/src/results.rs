//! The results of the runs of a study.

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
    /// This many successive runs are of the same loop; 1 or more.
    pub runs: u64,
}

impl Loops {
    /// The loop of a run.
    pub fn of(&self, run: u64) -> &str {
        &self.names[(run / self.runs) as usize % self.names.len()]
    }
}

/// At most this many values are kept in memory: 2 MB, and up to as much again for the room in which their lists grow.
const MOST_VALUES: usize = 1 << 18;

/// The rows of all runs, in their order. Those of a large study are in a file without a name, from which a column is read when it is
/// needed: ask for it once, not for each run.
#[derive(Debug)]
pub struct Results {
    /// What the runs were given.
    pub coordinates: Vec<Quantity>,
    /// What they came to.
    pub figures: Vec<Quantity>,
    /// The points of the runs, then their figures.
    columns: Columns,
    /// The loops that the runs are of, if the study has a table of loops with names.
    pub loops: Option<Loops>,
    /// Why runs failed, by their numbers.
    pub errors: BTreeMap<u64, String>,
}

impl Results {
    /// Empty, with these columns.
    pub fn new(coordinates: Vec<Quantity>, figures: Vec<Quantity>) -> Results {
        let columns = Columns::new(coordinates.len() + figures.len(), MOST_VALUES, &std::env::temp_dir());
        Results { coordinates, figures, columns, loops: None, errors: BTreeMap::new() }
    }

    /// The same, still empty, with the file in this folder instead of that of temporary files, which may be small or in memory.
    pub fn kept_in(self, folder: &Path) -> Results {
        self.within(MOST_VALUES, folder)
    }

    /// The same with about this many values in memory at most.
    pub(crate) fn within(self, most: usize, folder: &Path) -> Results {
        Results { columns: Columns::new(self.width(), most, folder), ..self }
    }

    /// Where the file is.
    pub(crate) fn folder(&self) -> &Path {
        self.columns.folder()
    }

    /// Adds the next run.
    ///
    /// # Errors
    /// No room for it in the folder of temporary files.
    ///
    /// # Panics
    /// The point or the row has another number of values than there are columns.
    pub fn push(&mut self, point: &[f64], row: &Row) -> Result<()> {
        assert_eq!(point.len(), self.coordinates.len(), "a value for each coordinate");
        assert_eq!(row.figures.len(), self.figures.len(), "a value for each figure");
        self.errors.extend(row.error.clone().map(|error| (self.count(), error)));
        self.columns.push(point.iter().chain(&row.figures).copied())
    }

    /// How many runs there are.
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

    /// The figures of a run; NaN where one has no value.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn figures_of(&self, run: u64) -> Result<Vec<f64>> {
        self.columns.row(run, self.coordinates.len()..self.width())
    }

    /// The values of a coordinate, by the number of its column, for all runs.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn coordinate(&self, column: usize) -> Result<Cow<'_, [f64]>> {
        self.column(column, 0..self.count())
    }

    /// The values of a figure, by the number of its column, for all runs.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn figure(&self, column: usize) -> Result<Cow<'_, [f64]>> {
        self.column(self.coordinates.len() + column, 0..self.count())
    }

    /// How many coordinates and figures there are.
    pub(crate) fn width(&self) -> usize {
        self.coordinates.len() + self.figures.len()
    }

    /// The values of some runs, by the number of a column of the coordinates, which the figures follow.
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
            results.push(&point, &Row { figures, error }).unwrap();
        }
        results
    }

    fn empty() -> Results {
        let quantity = |name: &&str| Quantity { name: (*name).into(), unit: Some("s".into()) };
        Results::new(["P.LAG", "C.GAIN"].iter().map(quantity).collect(), ["rise", "iae"].iter().map(quantity).collect())
    }

    /// All that is made of results.
    fn made(results: &Results) -> (Summary, Vec<u8>, Vec<u8>, Vec<Option<String>>) {
        let (mut csv, mut parquet) = (Vec::new(), Vec::new());
        write_csv(&mut csv, results).unwrap();
        write_parquet(&mut parquet, results).unwrap();
        let summary = Summary::of(results, 10).unwrap();
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
        // Of the 4000 values so many are in memory: blocks of 128 rows, of 333, of one.
        for most in [512, 1332, 1] {
            let in_file = filled(empty().within(most, folder.path()));
            assert!(made(&in_file) == in_memory, "{most}");
            assert_eq!(in_file.point(990).unwrap(), [f64::from(990 * 7919 % 1000), 0.0]);
            assert_eq!(in_file.figures_of(3).unwrap()[1], f64::from(3 * 7919 % 1000) / 3.0);
        }
    }
}
