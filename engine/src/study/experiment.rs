//! A job whose names are resolved: the point of each run, and what makes a row of it.

use crate::component::Reset;
use crate::dialog::Roles;
use crate::plan::Plan;
use crate::run::{Recording, Run};
use crate::study::Job;
use crate::study::results::{Quantity, Row};
use anyhow::Result;
use modeldescription::v2::ModelDescription;

/// A study that can be run.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// What a run does, with the values of the first point.
    pub plan: Plan,
    /// What a point consists of.
    pub coordinates: Vec<Quantity>,
    /// What a row consists of.
    pub figures: Vec<Quantity>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl Experiment {
    /// Resolves a job. `descriptions` are those of the system's members, in their order; `roles` are those of the first member,
    /// if its library has a table.
    ///
    /// # Errors
    /// What is wrong with which axis, variable or figure, and what to do.
    pub fn of(job: &Job, descriptions: &[&ModelDescription], roles: Option<&Roles>) -> Result<Experiment> {
        let _ = (job, descriptions, roles);
        unimplemented!()
    }

    /// How many runs the axes span.
    pub fn count(&self) -> u64 {
        unimplemented!()
    }

    /// The values of a run, for each coordinate, as its variables get them.
    ///
    /// # Panics
    /// There is no such run.
    pub fn point(&self, run: u64) -> Vec<f64> {
        let _ = run;
        unimplemented!()
    }
}

/// Makes runs one after the other with the same instances, which are reset between them.
#[derive(Debug)]
pub struct Executor<C> {
    experiment: Experiment,
    run: Option<Run<C>>,
}

impl<C: Reset> Executor<C> {
    /// For an experiment.
    pub fn new(experiment: Experiment) -> Executor<C> {
        Executor { experiment, run: None }
    }

    /// Makes the run of a point; `instantiate` gives a new component for each member when there are none that can be reset.
    /// What an FMU refuses becomes the row's error.
    pub fn row(&mut self, point: &[f64], instantiate: impl FnMut(usize) -> Result<C>) -> Row {
        let _ = (point, instantiate);
        unimplemented!()
    }

    /// The same, with all that the run records: the signals of the loop, what figures are taken of, and what the system records.
    ///
    /// # Errors
    /// Which FMU refused what, when.
    pub fn recording(&mut self, point: &[f64], instantiate: impl FnMut(usize) -> Result<C>) -> Result<Recording> {
        let _ = (point, instantiate);
        unimplemented!()
    }
}
