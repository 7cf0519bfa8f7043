//! Runs a plan and records it.
//!
//! Initialization: every FMU gets its parameters, enters Initialization Mode and gets its inputs; then the connected values
//! go once from output to input, in the order of the FMUs; then every FMU leaves Initialization Mode.
//!
//! Step k goes from `start + k step` to `start + (k + 1) step`. Each FMU in turn gets the values that are set at that time,
//! then its connected inputs, and steps. With [`Exchange::Parallel`], all get their inputs before any of them steps.
//!
//! A row of the recording belongs to a step and has the time at which the step begins. An input has the value that its FMU
//! got for the step. An output has the value that the connected FMUs read. So the row of a controller is what it saw and
//! gave in its call at that time, and a plant that is connected back to the controller shows what it was at that time,
//! before its own step. An output that no FMU reads is recorded as the other outputs of its FMU; if none of them is read, all
//! are recorded after the step.

use crate::host::instance::{Instance, Type};
use crate::host::plan::{Assignment, Block, Column, MemberPlan, Plan, ROUNDING};
use crate::host::system::Exchange;
use anyhow::{Context, Result, bail};
use std::io::{self, Write};

/// What a run needs of an instance of an FMU.
pub trait Component {
    /// Start and end of the simulation in seconds.
    ///
    /// # Errors
    /// The FMU refuses. So in all other functions.
    fn setup(&mut self, start: f64, stop: f64) -> Result<()>;
    /// Enters Initialization Mode.
    ///
    /// # Errors
    /// The FMU refuses.
    fn enter_initialization(&mut self) -> Result<()>;
    /// Leaves Initialization Mode.
    ///
    /// # Errors
    /// The FMU refuses.
    fn exit_initialization(&mut self) -> Result<()>;
    /// Reads variables of one type; true is 1.
    ///
    /// # Errors
    /// The FMU refuses.
    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()>;
    /// Writes variables of one type; true is 1.
    ///
    /// # Errors
    /// The FMU refuses.
    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()>;
    /// Steps from `time` to `time + size`, in seconds.
    ///
    /// # Errors
    /// The FMU refuses.
    fn step(&mut self, time: f64, size: f64) -> Result<()>;
    /// Ends the simulation.
    ///
    /// # Errors
    /// The FMU refuses.
    fn terminate(&mut self) -> Result<()>;
}

impl Component for Instance {
    fn setup(&mut self, start: f64, stop: f64) -> Result<()> {
        Instance::setup(self, start, Some(stop))
    }

    fn enter_initialization(&mut self) -> Result<()> {
        Instance::enter_initialization(self)
    }

    fn exit_initialization(&mut self) -> Result<()> {
        Instance::exit_initialization(self)
    }

    fn read(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.get_all(kind, references, values)
    }

    fn write(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<()> {
        self.set_all(kind, references, values)
    }

    fn step(&mut self, time: f64, size: f64) -> Result<()> {
        Instance::step(self, time, size)
    }

    fn terminate(&mut self) -> Result<()> {
        Instance::terminate(self)
    }
}

/// What a run has recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// What the values of a row are.
    pub columns: Vec<Column>,
    /// The time of each row in seconds.
    pub times: Vec<f64>,
    /// The rows, one behind the other.
    values: Vec<f64>,
}

impl Recording {
    /// An empty one, with room for the whole run.
    fn of(plan: &Plan) -> Result<Recording> {
        let (mut times, mut values) = (Vec::new(), Vec::new());
        let width = plan.columns.len();
        let has_room = plan.steps.checked_mul(width).is_some_and(|count| {
            times.try_reserve_exact(plan.steps).is_ok() && values.try_reserve_exact(count).is_ok()
        });
        if !has_room {
            let steps = plan.steps;
            bail!("{steps} steps of {width} variables do not fit into the memory: record fewer, or make longer steps");
        }
        Ok(Recording { columns: plan.columns.clone(), times, values })
    }

    /// The rows, in the order of time; true is 1.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = (f64, &[f64])> {
        let width = self.columns.len();
        self.times.iter().enumerate().map(move |(row, time)| (*time, &self.values[row * width..(row + 1) * width]))
    }

    /// The values of a column over time; true is 1.
    pub fn column(&self, column: usize) -> impl Iterator<Item = f64> {
        self.rows().map(move |(_, row)| row[column])
    }

    /// Writes CSV: the header `time,FMU.VARIABLE,...`, then a row for every step. A number is the shortest that reads back
    /// bit-equal; true is 1.
    ///
    /// # Errors
    /// Those of `to`.
    pub fn write_csv(&self, to: &mut impl Write) -> io::Result<()> {
        write!(to, "time")?;
        for column in &self.columns {
            write!(to, ",{}", field(&column.name))?;
        }
        writeln!(to)?;
        for (time, row) in self.rows() {
            write!(to, "{time:?}")?;
            for (value, column) in row.iter().zip(&self.columns) {
                match column.kind {
                    Type::Real => write!(to, ",{value:?}")?,
                    Type::Integer | Type::Boolean => write!(to, ",{value}")?,
                }
            }
            writeln!(to)?;
        }
        Ok(())
    }
}

/// A text as a field of CSV (RFC 4180).
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

/// Runs the plan with one component for each of its members. `progress` gets the number of steps that are made, after each.
///
/// # Errors
/// Which FMU refused what, when, and its messages.
///
/// # Panics
/// There are not as many components as members.
pub fn run<C: Component>(plan: &Plan, components: &mut [C], mut progress: impl FnMut(usize)) -> Result<Recording> {
    assert_eq!(components.len(), plan.members.len(), "each member has a component");
    let mut running: Vec<Running<C>> = plan.members.iter().zip(components).map(Running::of).collect();
    initialize(plan, &mut running)?;
    let mut recording = Recording::of(plan)?;
    for step in 0..plan.steps {
        let time = plan.time(step);
        let row = recording.begin(time, &running);
        if plan.exchange == Exchange::Parallel {
            for member in 0..running.len() {
                prepare(&mut running, member, time, plan.step)?;
            }
        }
        for member in 0..running.len() {
            if plan.exchange == Exchange::Sequential {
                prepare(&mut running, member, time, plan.step)?;
            }
            let of = &mut running[member];
            of.component.step(time, plan.step).with_context(|| of.plan.name.clone())?;
            of.observe().with_context(|| format!("{} after the step at {time:?} s", of.plan.name))?;
        }
        recording.end(row, &running);
        progress(step + 1);
    }
    for of in &mut running {
        of.component.terminate().with_context(|| of.plan.name.clone())?;
    }
    Ok(recording)
}

impl Recording {
    /// Begins a row with what is recorded before the step, and gives its place.
    fn begin<C>(&mut self, time: f64, running: &[Running<C>]) -> usize {
        let row = self.values.len();
        self.times.push(time);
        self.values.extend(self.columns.iter().map(|column| running[column.source.0].values[column.source.1]));
        row
    }

    /// Completes a row with what is recorded after the step.
    fn end<C>(&mut self, row: usize, running: &[Running<C>]) {
        for (value, column) in self.values[row..].iter_mut().zip(&self.columns) {
            if !column.is_before_step {
                *value = running[column.source.0].values[column.source.1];
            }
        }
    }
}

/// A member at work.
struct Running<'a, C> {
    plan: &'a MemberPlan,
    component: &'a mut C,
    /// The values of `plan.observed`.
    values: Vec<f64>,
    /// The values of `plan.connected`.
    inputs: Vec<f64>,
    /// How many of `plan.events` have been.
    events: usize,
}

impl<'a, C: Component> Running<'a, C> {
    fn of((plan, component): (&'a MemberPlan, &'a mut C)) -> Running<'a, C> {
        let values = vec![0.0; plan.observed.references.len()];
        let inputs = vec![0.0; plan.connected.references.len()];
        Running { plan, component, values, inputs, events: 0 }
    }

    fn set(&mut self, assignments: impl IntoIterator<Item = &'a Assignment>) -> Result<()> {
        for assignment in assignments {
            self.component.write(assignment.kind, &[assignment.reference], &[assignment.value])?;
        }
        Ok(())
    }

    /// Writes the connected inputs.
    fn write_inputs(&mut self) -> Result<()> {
        let Block { references, .. } = &self.plan.connected;
        for (kind, range) in self.plan.connected.groups() {
            self.component.write(kind, &references[range.clone()], &self.inputs[range])?;
        }
        Ok(())
    }

    /// Reads everything that others need or that is recorded.
    fn observe(&mut self) -> Result<()> {
        read(self.component, &self.plan.observed, &mut self.values)
    }

    /// Reads the connected outputs alone: in Initialization Mode the standard allows no more.
    fn observe_outputs(&mut self) -> Result<()> {
        let mut outputs = vec![0.0; self.plan.outputs.references.len()];
        read(self.component, &self.plan.outputs, &mut outputs)?;
        for (place, output) in self.plan.output_places.iter().zip(outputs) {
            self.values[*place] = output;
        }
        Ok(())
    }
}

fn read(component: &mut impl Component, block: &Block, values: &mut [f64]) -> Result<()> {
    for (kind, range) in block.groups() {
        component.read(kind, &block.references[range.clone()], &mut values[range])?;
    }
    Ok(())
}

/// Up to the first step.
fn initialize<C: Component>(plan: &Plan, running: &mut [Running<C>]) -> Result<()> {
    let stop = plan.time(plan.steps).max(plan.time(plan.steps - 1) + plan.step);
    let at = |of: &MemberPlan| format!("{} before the first step", of.name);
    for of in running.iter_mut() {
        of.component.setup(plan.start, stop).with_context(|| at(of.plan))?;
        of.set(&of.plan.parameters).with_context(|| at(of.plan))?;
        of.component.enter_initialization().with_context(|| at(of.plan))?;
        of.set(&of.plan.inputs).with_context(|| at(of.plan))?;
        of.observe_outputs().with_context(|| at(of.plan))?;
    }
    for member in 0..running.len() {
        gather(running, member);
        let of = &mut running[member];
        of.write_inputs().with_context(|| at(of.plan))?;
        if plan.exchange == Exchange::Sequential {
            of.observe_outputs().with_context(|| at(of.plan))?;
        }
    }
    for of in running.iter_mut() {
        of.component.exit_initialization().with_context(|| at(of.plan))?;
        of.observe().with_context(|| at(of.plan))?;
    }
    Ok(())
}

/// Gives a member what is set at this time, and its connected inputs.
fn prepare<C: Component>(running: &mut [Running<C>], member: usize, time: f64, step: f64) -> Result<()> {
    gather(running, member);
    let of = &mut running[member];
    while let Some((at, assignment)) = of.plan.events.get(of.events)
        && *at <= time + ROUNDING * step
    {
        of.events += 1;
        of.set([assignment]).with_context(|| format!("{} at {time:?} s", of.plan.name))?;
    }
    of.write_inputs().with_context(|| format!("{} at {time:?} s", of.plan.name))
}

/// Fetches the values of a member's connected inputs from where they are.
fn gather<C>(running: &mut [Running<C>], member: usize) {
    for place in 0..running[member].inputs.len() {
        let (from, source) = running[member].plan.sources[place];
        running[member].inputs[place] = running[from].values[source];
    }
}

#[cfg(test)]
mod tests;
