//! Experiments: jobs with resolved names, which determine the point of each run and compute its row.

use crate::axes::{Axes, Target, varied};
use crate::measures::{Measures, Traces};
use crate::results::{Loops, Quantity, Results, RunResult};
use crate::{Job, Signals, Study};
use anyhow::{Context, Result};
use control::figures::Set;
use modeldescription::digits::short;
use modeldescription::{Causality, Description};
use run::component::Reset;
use run::dialog::Roles;
use run::master::{self, Recording, Run, Thinned};
use run::plan::{Assignment, MemberPlan, Names, Plan};
use run::subject::About;
use run::system::{Recorded, System};
use serde::{Deserialize, Serialize};
use std::hash::{DefaultHasher, Hasher};

/// The number of rows that suffice for a picture of a run.
const DRAWN: usize = 20_000;

/// The maximum number of values in a trace: one for every other pixel of a picture.
const TRACED: usize = 331;

/// The approximate number of values per piece of a recording.
const PIECE: usize = 1 << 20;

/// How many rows of a run are recorded.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub enum Detail {
    /// Every row.
    All,
    /// The minima and maxima of a long run, for a picture; every row of a shorter one.
    Drawn,
}

impl Detail {
    /// Creates the thinner for a run with this many steps.
    pub fn thinned(self, columns: Vec<run::plan::Column>, steps: usize) -> Thinned {
        Thinned::new(columns, steps, if self == Detail::All { steps } else { DRAWN })
    }
}

/// The contents of a row.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub enum Gives {
    /// The figures.
    Figures,
    /// The figures from new instances, followed by the process value at the times of [`Experiment::trace_times`].
    Trace,
}

/// A study that is ready to run.
///
/// It can also run other points, such as those of an optimizer: the axes then only define the coordinates, and
/// [`Executor::row`] accepts any values for these.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// The plan of a run, with the values of the first point.
    pub plan: Plan,
    /// The coordinates of a point.
    pub coordinates: Vec<Quantity>,
    /// The figures in a row.
    pub figures: Vec<Quantity>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// The names of the loop's signals; all `None` if the setpoint or the process value is unknown.
    pub signals: Signals,
    /// The disturbances of the loop.
    pub disturbances: Vec<Set>,
    /// The loops of the runs, if the study has a table of named loops.
    pub loops: Option<Loops>,
    axes: Axes,
    measures: Measures,
    /// For each coordinate, where its value is in the plan.
    slots: Vec<Slot>,
    /// The same plan, which also records the variables that the system records.
    recording: Plan,
}

/// The position of a value in a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slot {
    member: usize,
    /// The list of the member's plan that contains it.
    list: List,
    place: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum List {
    Parameters,
    Inputs,
    Events,
}

impl Slot {
    /// Finds the value of a variable, which must occur exactly once.
    fn new(plan: &Plan, target: &Target) -> Option<Slot> {
        let own = &plan.members[target.member];
        let is = |assignment: &Assignment| (assignment.kind, assignment.reference) == (target.kind, target.reference);
        let (list, place) = match target.time {
            Some(time) => (List::Events, own.events.iter().position(|(at, of)| *at == time && is(of))?),
            None => match own.parameters.iter().position(is) {
                Some(place) => (List::Parameters, place),
                None => (List::Inputs, own.inputs.iter().position(is)?),
            },
        };
        Some(Slot { member: target.member, list, place })
    }

    fn value(self, members: &mut [MemberPlan]) -> &mut f64 {
        let own = &mut members[self.member];
        match self.list {
            List::Parameters => &mut own.parameters[self.place].value,
            List::Inputs => &mut own.inputs[self.place].value,
            List::Events => &mut own.events[self.place].1.value,
        }
    }
}

impl Experiment {
    /// Resolves a job. `descriptions` describes the system's members, in order; `roles` are the first member's roles,
    /// if its library has a table.
    ///
    /// # Errors
    /// An axis, variable or figure is wrong; the message names the remedy.
    pub fn new(job: &Job, descriptions: &[&Description], roles: Option<&Roles>) -> Result<Experiment> {
        let (system, study) = (&job.system, &job.study);
        // An error in the loop itself must not be blamed on an axis.
        Plan::new(system, descriptions)?;
        let names = Names::new(system, descriptions)?;
        let axes = Axes::new(study, system, &names)?;
        let first = axes.point(0);
        for (number, axis) in study.axes.iter().enumerate() {
            let own = axes.coordinates(number);
            let alone = varied(system, &names, &axes.targets[own.clone()], &first[own]);
            Plan::new(&alone, descriptions).with_context(|| axis.label(number)).at(number).at("axes")?;
        }
        let measures = Measures::new(study, system, &names, roles)?;
        let record = |system| System { record: recorded(measures.columns.iter()), ..system };
        // Each axis has its own warning for all of its values.
        let fixed = Plan::new(&record(varied(system, &names, &axes.targets, &[])), descriptions)?;
        let mut warnings = [fixed.warnings, axes.warnings(study), measures.warnings.clone()].concat();
        let varied = varied(system, &names, &axes.targets, &first);
        let all = Plan::new(&varied, descriptions)?;
        let columns = all.columns.iter().map(|column| &column.name).chain(&measures.columns);
        let recording = Plan::new(&System { record: recorded(columns), ..varied.clone() }, descriptions)?;
        let plan = Plan { warnings: Vec::new(), ..Plan::new(&record(varied), descriptions)? };
        warnings.extend(constant_setpoint(study, system, &measures.signals, &names));
        let end = plan.time(plan.steps);
        warnings.extend(study.window.from.filter(|from| *from >= end).map(|from| {
            format!(
                "window: from = {from:?} s is not before the end of the run at {} s, so the loop has no figures: \
                 use an earlier time",
                short(end)
            )
        }));
        let slots = axes
            .targets
            .iter()
            .map(|target| Slot::new(&plan, target).with_context(|| format!("{} is not in the plan", target.name)))
            .collect::<Result<Vec<_>>>()?;
        Ok(Experiment {
            coordinates: axes.targets.iter().map(Target::coordinate).collect(),
            figures: measures.figures.clone(),
            plan,
            warnings,
            signals: measures.signals.clone(),
            disturbances: measures.disturbances.clone(),
            loops: axes.loops(study),
            axes,
            measures,
            slots,
            recording,
        })
    }

    /// The number of runs that the axes span.
    pub fn count(&self) -> u64 {
        self.axes.count()
    }

    /// Empty results with this experiment's columns.
    pub fn results(&self) -> Results {
        let mut results = Results::new(self.coordinates.clone(), self.figures.clone());
        results.loops = self.loops.clone();
        results
    }

    /// The point of a run: the values that its variables receive.
    ///
    /// # Panics
    /// The run does not exist.
    pub fn point(&self, run: u64) -> Vec<f64> {
        self.axes.point(run)
    }

    /// The times, in seconds, of the process values in a row with [`Gives::Trace`]; empty if the loop's process value
    /// is unknown.
    pub fn trace_times(&self) -> Vec<f64> {
        let has_loop = self.signals.process_value.is_some();
        traced(self.plan.steps).filter(|_| has_loop).map(|step| self.plan.time(step)).collect()
    }

    /// Writes the values of a point into the plan.
    fn set(&mut self, point: &[f64]) {
        assert_eq!(point.len(), self.slots.len(), "a value for each coordinate");
        for (slot, value) in self.slots.iter().zip(point) {
            *slot.value(&mut self.plan.members) = *value;
            *slot.value(&mut self.recording.members) = *value;
        }
    }
}

/// The steps at which a trace has values.
pub(super) fn traced(steps: usize) -> impl Iterator<Item = usize> {
    let count = steps.min(TRACED);
    (0..count).map(move |place| if count == 1 { 0 } else { place * (steps - 1) / (count - 1) })
}

/// A warning for the user if the setpoint does not change during any run.
fn constant_setpoint(study: &Study, system: &System, signals: &Signals, names: &Names) -> Option<String> {
    let setpoint = signals.setpoint.as_ref()?;
    // An output may change by itself.
    let causality = names.find(setpoint).ok()?.variable.causality;
    let is_set = matches!(causality, Causality::Input | Causality::Parameter);
    let is_connected = system.connections.iter().any(|of| of.to == *setpoint);
    let has_event = system.settings.iter().any(|of| of.time.is_some() && of.variable == *setpoint);
    let has_axis = study.axes.iter().any(|axis| axis.time.is_some() && axis.variables.contains(setpoint));
    (is_set && !is_connected && !has_event && !has_axis).then(|| {
        format!(
            "{setpoint} does not change during a run: rise, overshoot and settling describe the approach to \
             the setpoint from the start values; to step the setpoint, write [[events]] with time = SECONDS and set = \
             {{ {setpoint} = VALUE }}"
        )
    })
}

/// The named variables, to be recorded.
fn recorded<'a>(names: impl Iterator<Item = &'a String>) -> Vec<Recorded> {
    names.map(|name| Recorded::from(name.as_str())).collect()
}

/// Executes runs, reusing instances by resetting them.
#[derive(Debug)]
pub struct Executor<C> {
    experiment: Experiment,
    /// Finished runs, whose instances can be reset.
    runs: Vec<Run<C>>,
    /// The traces of the runs executed last, in order.
    traces: Vec<Traces>,
    /// Whether each run needs new instances, because reset ones compute different results.
    is_reset_wrong: bool,
}

impl<C: Reset> Executor<C> {
    /// Creates an executor for an experiment.
    pub fn new(experiment: Experiment) -> Executor<C> {
        Executor { experiment, runs: Vec::new(), traces: vec![Traces::default()], is_reset_wrong: false }
    }

    /// Uses new instances for each run, as after a [`check_reset`](Executor::check_reset) that finds a difference.
    pub fn renew(&mut self) {
        self.is_reset_wrong = true;
    }

    /// The experiment.
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// Executes the run of a point; `instantiate` creates a component for each member if there are none to reset. A
    /// call rejected by an FMU becomes the row's error.
    ///
    /// # Panics
    /// The point does not have a value for each coordinate.
    pub fn row(&mut self, point: &[f64], instantiate: impl FnMut(usize) -> Result<C>) -> RunResult {
        self.rows(&[point.to_vec()], Gives::Figures, instantiate).remove(0)
    }

    /// Executes the runs of points, each with its own instances, side by side where possible. The rows have the
    /// requested values, which do not depend on how runs are grouped.
    ///
    /// # Panics
    /// See [`Executor::row`].
    pub fn rows(
        &mut self,
        points: &[Vec<f64>],
        gives: Gives,
        mut instantiate: impl FnMut(usize) -> Result<C>,
    ) -> Vec<RunResult> {
        if points.len() > 1 && self.make(points, gives, &mut instantiate).is_ok() {
            return (0..points.len()).map(|number| self.row_of(number, gives)).collect();
        }
        let mut row = |point: &Vec<f64>| {
            let is_reset = !self.runs.is_empty();
            let point = std::slice::from_ref(point);
            let mut made = self.make(point, gives, &mut instantiate);
            if made.is_err() && is_reset {
                // The reason for a failure must not depend on the runs before it.
                made = self.make(point, gives, &mut instantiate);
            }
            let Err(error) = made else { return self.row_of(0, gives) };
            let error = format!("{error:#}").split_whitespace().collect::<Vec<_>>().join(" ");
            RunResult { figures: vec![f64::NAN; self.experiment.figures.len()], error: Some(error) }
        };
        points.iter().map(&mut row).collect()
    }

    /// The row of one of the last runs.
    fn row_of(&mut self, number: usize, gives: Gives) -> RunResult {
        let Experiment { measures, plan, .. } = &self.experiment;
        let traces = &mut self.traces[number];
        let mut figures = measures.end(traces, plan);
        if gives == Gives::Trace {
            figures.extend(measures.process_values(traces));
        }
        RunResult { figures, error: None }
    }

    /// Executes the run of a point with new instances and records it: the signals of the loop, the variables from which
    /// figures are computed, and those that the system records. `receive` is passed the recording in pieces. Returns
    /// the figures, or `None` if an FMU ended the run.
    ///
    /// # Errors
    /// An FMU rejects a call (the message contains the time), or `receive` fails.
    ///
    /// # Panics
    /// See [`Executor::row`].
    pub fn recording(
        &mut self,
        point: &[f64],
        detail: Detail,
        instantiate: impl FnMut(usize) -> Result<C>,
        mut receive: impl FnMut(Recording) -> Result<()>,
    ) -> Result<Option<Vec<f64>>> {
        // Some FMUs allow only one instance per process.
        self.runs.clear();
        self.experiment.set(point);
        let Experiment { plan: measured, recording: plan, measures, .. } = &self.experiment;
        let place = |name: &String| plan.columns.iter().position(|column| column.name == *name).unwrap_or_default();
        let places: Vec<usize> = measured.columns.iter().map(|column| place(&column.name)).collect();
        let mut kept = detail.thinned(plan.columns.clone(), plan.steps + 1);
        let piece = PIECE / plan.columns.len().max(1);
        let traces = &mut self.traces[0];
        measures.begin(traces);
        let mut before: Option<Vec<f64>> = None;
        let mut row = vec![0.0; places.len()];
        let ended = master::run_into(
            plan,
            &mut instances(plan, instantiate)?,
            |_| {},
            |time, values| {
                kept.push(time, values);
                if let Some(before) = &before {
                    // Figures refer to calls (see `master`): here, the result of a call appears in the next row if no
                    // output of its FMU is connected.
                    for (place, value) in places.iter().zip(&mut row) {
                        *value = if plan.columns[*place].is_unread { values[*place] } else { before[*place] };
                    }
                    traces.push(&row);
                }
                before = Some(values.to_vec());
                kept.take(piece).map_or(Ok(()), &mut receive)
            },
        )?;
        let has_ended = ended.is_some();
        let mut last = kept.recording();
        last.ended = ended;
        receive(last)?;
        Ok((!has_ended).then(|| measures.end(traces, plan)))
    }

    /// Checks that reset instances compute the same results as new ones, by running the second point after the first.
    /// If any bit differs, all further runs use new instances. A worker calls this once, before its first run.
    ///
    /// Returns a sentence for the user if there is a difference.
    pub fn check_reset(&mut self, mut instantiate: impl FnMut(usize) -> Result<C>) -> Option<String> {
        let (first, second) = (self.experiment.point(0), self.experiment.point(1.min(self.experiment.count() - 1)));
        let mut values = |executor: &mut Self, point: Vec<f64>| {
            let is_made = executor.make(&[point], Gives::Figures, &mut instantiate).is_ok();
            let mut bits = DefaultHasher::new();
            let recorded = executor.traces[0].columns.iter().flatten();
            recorded.for_each(|value| bits.write_u64(value.to_bits()));
            (bits.finish(), is_made)
        };
        self.runs.clear();
        values(self, first);
        let is_reset = !self.runs.is_empty();
        let after_reset = values(self, second.clone());
        self.runs.clear();
        let anew = values(self, second);
        self.is_reset_wrong = is_reset && after_reset != anew;
        self.is_reset_wrong.then(|| {
            "an FMU's results after a reset differ from those of a new instance: each run gets new instances, \
             which takes longer; report this to the FMU's vendor"
                .into()
        })
    }

    /// Executes the runs of points, side by side where possible, and leaves their traces in `self`.
    fn make(
        &mut self,
        points: &[Vec<f64>],
        gives: Gives,
        instantiate: &mut impl FnMut(usize) -> Result<C>,
    ) -> Result<()> {
        let Executor { experiment, traces, .. } = self;
        let mut used = std::mem::take(&mut self.runs);
        if self.is_reset_wrong || gives == Gives::Trace {
            used.clear();
        }
        let stop = stop(&experiment.plan);
        let mut runs = Vec::with_capacity(points.len());
        traces.resize_with(points.len(), Traces::default);
        for (point, traces) in points.iter().zip(&mut *traces) {
            experiment.measures.begin(traces);
            experiment.set(point);
            let plan = &experiment.plan;
            runs.push(match used.pop() {
                Some(mut run) => {
                    run.restart(plan, Some(stop))?;
                    run
                }
                None => Run::begin(plan, instances(plan, &mut *instantiate)?, Some(stop))?,
            });
        }
        let mut columns = experiment.measures.abreast();
        let mut is_abreast = true;
        while is_abreast && runs.iter().any(|run| run.steps() < experiment.plan.steps) {
            let record = |column: usize, values: &[f64]| columns.push(column, values, traces);
            is_abreast = Run::steps_abreast(&mut runs, &experiment.plan, record)?;
            columns.finish(traces);
            // Steps that cannot be performed side by side: those up to the next setting, one at a time, or all that
            // remain.
            for ((run, point), traces) in runs.iter_mut().zip(points).zip(&mut *traces) {
                experiment.set(point);
                let plan = &experiment.plan;
                while run.steps() < plan.steps {
                    run.step(plan)?;
                    traces.push(run.row());
                    if is_abreast {
                        break;
                    }
                }
            }
        }
        for run in &mut runs {
            run.terminate(&experiment.plan)?;
        }
        runs.extend(used);
        self.runs = runs;
        Ok(())
    }
}

/// The end of the last step, in seconds.
fn stop(plan: &Plan) -> f64 {
    plan.time(plan.steps).max(plan.time(plan.steps - 1) + plan.step)
}

/// Creates a component for each member.
fn instances<C>(plan: &Plan, instantiate: impl FnMut(usize) -> Result<C>) -> Result<Vec<C>> {
    (0..plan.members.len()).map(instantiate).collect()
}

#[cfg(test)]
mod tests;
