//! What a user expects of the runs of a study, such as `overshoot < 10 %`.

use crate::study::results::{Quantity, Results};
use anyhow::Result;

/// An expectation: each run, or a percentile of all, keeps to a bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    /// As the user writes it.
    pub text: String,
}

/// What came of an expectation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// The runs that do not keep to it; failed runs, and runs whose figure cannot be said, do not.
    pub offending: Vec<u64>,
    /// What is wrong, a sentence; none if it is met.
    pub problem: Option<String>,
}

impl Expectation {
    /// Reads `FIGURE < NUMBER [UNIT]`, with <, <=, > or >=, or `pN(FIGURE) < ...` for a percentile.
    ///
    /// # Errors
    /// What is wrong with it: there is no such figure, the unit is another one.
    pub fn parse(text: &str, figures: &[Quantity]) -> Result<Expectation> {
        let _ = (text, figures);
        unimplemented!()
    }

    /// Whether the runs keep to it.
    pub fn verdict(&self, results: &Results) -> Verdict {
        let _ = results;
        unimplemented!()
    }
}
