//! Searches for the best settings for all plants of a study, with the runs executed by a pool of workers.

use crate::expect::Expectation;
use crate::experiment::Detail;
use crate::pool::{Options, Pool};
use crate::read::Reading;
use crate::results::{Quantity, RunResult};
use crate::tune::robustness::{Identification, Linear};
use crate::tune::{self, Candidate, Grid, Outcome, Problem, SENSITIVITY, Search, Tune};
use crate::{Along, Axis, Job};
use anyhow::{Context, Result, anyhow, bail, ensure};
use control::margins::Plant;
use host::package::Package;
use modeldescription::Table;
use modeldescription::{Description, Type};
use run::fmus::Values;
use run::plan::near;
use run::subject::About;
use run::system::{Setting, System, Value, own_name};
use std::sync::Arc;
use std::thread;

/// The maximum number of plants in a search.
const MOST_PLANTS: u64 = 10_000;

/// A search that is ready to run.
#[derive(Debug)]
pub struct Tuning {
    /// The search problem.
    pub problem: Problem,
    /// The loop's current settings, for each search variable.
    pub present: Vec<f64>,
    /// The figures in a row, with [`SENSITIVITY`] last if the problem uses it.
    pub figures: Vec<Quantity>,
    /// The units of the search variables.
    pub units: Vec<Option<String>>,
    /// Remarks for the user.
    pub remarks: Vec<String>,
    system: System,
    plants: Vec<Vec<f64>>,
    robustness: Option<Robustness>,
    pool: Pool,
    jobs: usize,
}

/// What is needed to compute Ms.
struct Robustness {
    linear: Linear,
    /// The plants, in the order of the study's points.
    plants: Vec<Arc<Plant>>,
    /// The coordinates of a point that Ms depends on: their positions, and their names as in [`Linear::own_name`].
    own: Vec<(usize, String)>,
}

impl Tuning {
    /// Checks a study with its table `[tune]` and starts the workers. If Ms is needed, also identifies the plants.
    ///
    /// # Errors
    /// The study or an FMU is faulty, or a plant cannot be identified; the message names the remedy.
    pub fn start(reading: &Reading, options: &Options) -> Result<Tuning> {
        let mut tune = reading.tune()?;
        tune.check().context("[tune]").at("tune")?;
        let base = &reading.job;
        let mut present = Vec::new();
        for (number, search) in tune.search.iter_mut().enumerate() {
            let value = variable(base, search).at("variable").at(number).at("search").at("tune")?;
            present.push(value);
        }
        let job = with_axes(base, &tune.search, &present);
        let pool = Pool::start(&job, options)?;
        let experiment = pool.experiment();
        let count = experiment.count();
        ensure!(
            count <= MOST_PLANTS,
            "the axes span {count} plants: a search supports at most {MOST_PLANTS}; use fewer samples or shorter lists"
        );
        let varied = experiment.coordinates.len() - tune.search.len();
        let plants: Vec<Vec<f64>> = (0..count).map(|run| experiment.point(run)[..varied].to_vec()).collect();
        let units = experiment.coordinates[varied..].iter().map(|quantity| quantity.unit.clone()).collect();
        let mut figures = experiment.figures.clone();
        let mut remarks = experiment.warnings.clone();
        figures.push(Quantity::new(SENSITIVITY, None));
        let problem = problem(&tune, &figures)?;
        let used = std::iter::once(problem.minimize).chain(problem.front);
        let mut used = used.chain(problem.constraints.iter().map(|of| of.0.figure));
        let robustness = if used.any(|figure| figure + 1 == figures.len()) {
            let names = experiment.coordinates[..varied].iter().map(|quantity| quantity.name.clone()).collect();
            Some(
                Robustness::new(&tune, base, pool.tables(), names, &plants, options, &mut remarks)
                    .context(SENSITIVITY)
                    .at("tune")?,
            )
        } else {
            figures.pop();
            None
        };
        let system = base.system.clone();
        Ok(Tuning { problem, present, figures, units, remarks, system, plants, robustness, pool, jobs: options.jobs })
    }

    /// The number of plants.
    pub fn plants(&self) -> usize {
        self.plants.len()
    }

    /// The table of the controller's block, if its library has one.
    pub fn table(&self) -> Option<&Table> {
        self.pool.tables().first()?.as_ref()
    }

    /// Whether the user has interrupted the search.
    pub fn is_interrupted(&self) -> bool {
        self.pool.is_interrupted()
    }

    /// Runs the search. `progress` receives the number of evaluated candidates and the best one. Returns the outcome
    /// and the result with the current settings.
    ///
    /// # Errors
    /// A worker cannot be started, or the search is interrupted before the first candidates are known.
    pub fn search(&mut self, progress: impl FnMut(usize, &Candidate)) -> Result<(Outcome, Candidate)> {
        let (problem, present) = (self.problem.clone(), self.present.clone());
        let outcome = tune::search(&problem, Some(&present), |batch| self.evaluate(batch), progress)?;
        if let Some(known) = outcome.candidates.iter().find(|candidate| candidate.values == present) {
            let known = known.clone();
            return Ok((outcome, known));
        }
        let rows = self.evaluate(std::slice::from_ref(&present))?.and_then(|mut rows| rows.pop());
        let unknown =
            || vec![RunResult { figures: vec![f64::NAN; self.figures.len()], error: None }; self.plants.len()];
        let rows = rows.unwrap_or_else(unknown);
        Ok((outcome, Candidate::new(&problem, present, rows)))
    }

    /// The loop with these values of the search variables.
    pub fn system(&self, values: &[f64]) -> System {
        let mut system = self.system.clone();
        for (search, value) in self.problem.search.iter().zip(values) {
            system.settings.retain(|of| of.time.is_some() || of.variable != search.variable);
            system.settings.push(Setting {
                variable: search.variable.clone(),
                value: Value::Number(*value),
                time: None,
                is_preliminary: false,
                place: None,
            });
        }
        system
    }

    /// For each candidate, a row for each plant; `None` after an interruption.
    fn evaluate(&mut self, batch: &[Vec<f64>]) -> Result<Option<Vec<Vec<RunResult>>>> {
        let plants = &self.plants;
        let point = |run: u64| {
            let (candidate, plant) = (run as usize / plants.len(), run as usize % plants.len());
            [plants[plant].as_slice(), &batch[candidate]].concat()
        };
        let mut rows = Vec::new();
        self.pool.rows((batch.len() * plants.len()) as u64, &point, &mut |_, row| {
            rows.push(row);
            Ok(())
        })?;
        if rows.len() < batch.len() * plants.len() {
            return Ok(None);
        }
        let mut rows: Vec<Vec<RunResult>> = rows.chunks(plants.len()).map(<[RunResult]>::to_vec).collect();
        if let Some(robustness) = &self.robustness {
            robustness.add(&self.problem.search, plants, batch, &mut rows, self.jobs)?;
        }
        Ok(Some(rows))
    }
}

impl Robustness {
    fn new(
        tune: &Tune,
        job: &Job,
        tables: &[Option<Table>],
        names: Vec<String>,
        plants: &[Vec<f64>],
        options: &Options,
        remarks: &mut Vec<String>,
    ) -> Result<Robustness> {
        let controller = job.system.members.first().map_or("", |member| &member.name);
        let table = tables.first().and_then(Option::as_ref).with_context(|| {
            format!(
                "{controller} is a foreign FMU: the meaning of its settings is unknown; constrain overshoot instead of ms"
            )
        })?;
        let linear = Linear::new(job, &Arc::new(table.clone()))?.with_pulse_former(job, tables)?;
        let ignored = tune.search.iter().map(|of| of.variable.as_str()).filter(|name| !linear.has(name));
        let ignored: Vec<_> = ignored.collect();
        if !ignored.is_empty() {
            remarks.push(format!(
                "Ms does not depend on {} here: each plant is identified with the settings of the loop",
                ignored.join(" and ")
            ));
        }
        let in_point = Identification::is_in_point(job);
        let own = |(place, name): (usize, String)| {
            let own = linear.own_name(&name)?.to_string();
            in_point[place].then_some((place, own))
        };
        let own: Vec<_> = names.into_iter().enumerate().filter_map(own).collect();
        let plants = match &tune.model {
            Some(model) => {
                let plant = Arc::new(linear.modelled(model));
                vec![plant; plants.len()]
            }
            None => identify(&linear, tune, job, (&in_point, &own), plants, options, remarks)?,
        };
        Ok(Robustness { linear, plants, own })
    }

    /// Adds Ms to the rows of candidates, using at most `jobs` threads.
    fn add(
        &self,
        search: &[Search],
        plants: &[Vec<f64>],
        batch: &[Vec<f64>],
        rows: &mut [Vec<RunResult>],
        jobs: usize,
    ) -> Result<()> {
        let mut work: Vec<(&Vec<f64>, &mut Vec<RunResult>)> = batch.iter().zip(rows).collect();
        let share = work.len().div_ceil(jobs.max(1)).max(1);
        let controller = search.iter().map(|of| self.linear.own_name(&of.variable)).collect::<Vec<_>>();
        let one = |values: &[f64], rows: &mut [RunResult]| -> Result<()> {
            for ((point, plant), row) in plants.iter().zip(&self.plants).zip(rows) {
                let of_plant = of_point(&self.own, point);
                let searched = controller.iter().zip(values);
                let searched = searched.filter_map(|(name, value)| Some(((*name)?.to_string(), Value::Number(*value))));
                let settings: Values = of_plant.chain(searched).collect();
                row.figures.push(self.linear.sensitivity(plant, &settings)?);
            }
            Ok(())
        };
        thread::scope(|scope| {
            let threads: Vec<_> = work
                .chunks_mut(share)
                .map(|share| scope.spawn(|| share.iter_mut().try_for_each(|(values, rows)| one(values, rows))))
                .collect();
            threads.into_iter().try_for_each(|thread| thread.join().unwrap_or_else(|_| bail!("a thread has panicked")))
        })
    }
}

impl std::fmt::Debug for Robustness {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.debug_struct("Robustness").field("plants", &self.plants.len()).finish_non_exhaustive()
    }
}

/// The settings in a point that Ms depends on.
fn of_point<'a>(own: &'a [(usize, String)], point: &'a [f64]) -> impl Iterator<Item = (String, Value)> + 'a {
    own.iter().map(|(place, name)| (name.clone(), Value::Number(point[*place])))
}

/// Identifies all plants from a step in the manual value. `in_point` marks the coordinates that the points of the
/// identification contain; `own` lists the coordinates that Ms depends on, see [`Robustness::own`].
fn identify(
    linear: &Linear,
    tune: &Tune,
    job: &Job,
    (in_point, own): (&[bool], &[(usize, String)]),
    plants: &[Vec<f64>],
    options: &Options,
    remarks: &mut Vec<String>,
) -> Result<Vec<Arc<Plant>>> {
    let advised = |error: anyhow::Error| {
        anyhow!(
            "{error:#}; change [tune.step], or specify the plant's model in [tune]: \
             model = {{ gain = ..., time_constant = ..., dead_time = ... }}"
        )
    };
    let descriptions = descriptions(&job.system)?;
    let experiments = || descriptions.iter().filter_map(|of| of.default_experiment);
    let start = job.system.start.or(experiments().filter_map(|of| of.start_time).reduce(f64::min)).unwrap_or(0.0);
    let stop = job.system.stop.or(experiments().filter_map(|of| of.stop_time).reduce(f64::max));
    let stop = tune.step.stop.or(stop).context("the study has no stop time: specify one, such as stop = 600")?;
    let identification = linear.identification(job, &tune.step, start, stop).map_err(advised)?;
    let mut pool = Pool::start(&identification.job, options).context("the loop in manual mode").map_err(advised)?;
    let mut identified = Vec::new();
    let mut worst: Option<(f64, usize)> = None;
    for (number, plant) in plants.iter().enumerate() {
        let point: Vec<f64> = plant.iter().zip(in_point).filter_map(|(value, is_in)| is_in.then_some(*value)).collect();
        let settings = of_point(own, plant).collect();
        let found = pool.curve(&point, Detail::All);
        let found = found.and_then(|(recording, _)| linear.identified(&identification, &recording, &settings));
        let found = found.with_context(|| format!("plant {number}")).map_err(advised)?;
        worst = found.fit.filter(|fit| worst.is_none_or(|(worst, _)| *fit < worst)).map(|fit| (fit, number)).or(worst);
        identified.push(Arc::new(found.plant));
    }
    remarks.extend(worst.map(|(fit, number)| {
        format!(
            "the process value is noisy: for Ms, each plant is approximated by a lag with dead time (worst fit: \
             {fit:.0} %, for plant {number}); without noise, Ms is computed from the recorded step itself"
        )
    }));
    Ok(identified)
}

fn descriptions(system: &System) -> Result<Vec<Description>> {
    system.members.iter().map(|member| Ok(Package::open(&member.path)?.description)).collect()
}

/// The search problem, with figures resolved to indices.
fn problem(tune: &Tune, figures: &[Quantity]) -> Result<Problem> {
    let figure = |key: &'static str, name: &String| {
        let found = figures.iter().position(|figure| figure.name == *name).with_context(|| {
            let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
            let hint =
                near(name, names.iter().copied()).map_or_else(String::new, |near| format!("; did you mean {near}?"));
            format!("{key}: no figure {name}; available: {}{hint}", names.join(", "))
        });
        found.at(key)
    };
    let constraint = |(number, text): (usize, &String)| {
        Ok(tune::Constraint(Expectation::parse(text, figures).at(number).at("constraints")?))
    };
    let problem = || -> Result<Problem> {
        Ok(Problem {
            minimize: figure("minimize", &tune.minimize)?,
            over: tune.over,
            constraints: tune.constraints.iter().enumerate().map(constraint).collect::<Result<_>>()?,
            front: tune.front.as_ref().map(|name| figure("front", name)).transpose()?,
            evaluations: tune.evaluations,
            seed: tune.seed,
            search: tune.search.clone(),
        })
    };
    problem().context("[tune]").at("tune")
}

/// The job with the search variables as additional axes: they are the last coordinates of each point.
fn with_axes(job: &Job, search: &[Search], present: &[f64]) -> Job {
    let mut job = job.clone();
    job.study.axes.extend(search.iter().zip(present).map(|(search, value)| Axis {
        variables: vec![search.variable.clone()],
        along: Along::Values(vec![Value::Number(*value)]),
        ..Axis::default()
    }));
    job
}

/// Checks a search variable, and sets its grid. Returns its current value in the loop.
fn variable(job: &Job, search: &mut Search) -> Result<f64> {
    let (system, name) = (&job.system, search.variable.as_str());
    let is_axis = |axis: &Axis| axis.time.is_none() && axis.variables.contains(&search.variable);
    ensure!(
        !job.study.axes.iter().any(is_axis),
        "[tune]: {name} is both searched and varied by an axis: remove one of them"
    );
    let found = system.members.iter().find_map(|member| Some((member, own_name(name, &member.name)?)));
    let (member, own) = found.with_context(|| {
        let names: Vec<&str> = system.members.iter().map(|member| member.name.as_str()).collect();
        format!(
            "[tune]: {name} is searched, but the loop has no such FMU: write FMU.VARIABLE, where FMU is one of {}",
            names.join(", ")
        )
    })?;
    let description = Package::open(&member.path)?.description;
    let variable = description.variable(own).with_context(|| {
        let names = description.variables.iter().map(|of| of.name.as_str());
        let hint = near(own, names).map_or_else(String::new, |near| format!("; did you mean {near}?"));
        format!("[tune]: {} has no variable {own}{hint}", member.name)
    })?;
    search.grid = match variable.kind {
        // A PLC's TIME, which has a resolution of milliseconds, is displayed in ms.
        Some(Type::Real) if variable.display_unit.as_deref() == Some("ms") => Grid::Milliseconds,
        Some(kind) if kind.is_floating() => Grid::Digits,
        Some(kind) if kind.whole().is_some() && !variable.is_enumeration() => Grid::Whole,
        _ => bail!(
            "[tune]: {name} is searched, but it is neither a Real nor an Integer: make it an axis, or run two studies"
        ),
    };
    let own_settings = || system.settings.iter().filter(|of| of.time.is_none() && of.variable == name);
    let set = own_settings().find(|of| !of.is_preliminary).or(own_settings().next());
    let value = match set.map(|of| of.value) {
        Some(Value::Number(value)) => Some(value),
        Some(Value::Whole(value)) => Some(value as f64),
        Some(Value::Boolean(_)) => bail!("{name} is a number, but the loop sets it to TRUE or FALSE: set a number"),
        None => description.start(own),
    };
    Ok(value.unwrap_or_default())
}
