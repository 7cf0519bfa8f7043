//! Runs a plan and records it.
//!
//! Initialization: every FMU receives its parameters, enters Initialization Mode and receives its inputs. Connected
//! values are then copied from outputs to inputs, in the order of the FMUs, until no output changes, in at most as many
//! passes as there are FMUs; values thus propagate through chains (plant, sensor, filter) in any order. Finally every
//! FMU exits Initialization Mode. With [`Exchange::Parallel`], values are copied once.
//!
//! Step k runs from `start + k step` to `start + (k + 1) step`. Each FMU in turn receives the values set at that time
//! and its connected inputs, and then steps. With [`Exchange::Parallel`], all connected inputs are read before any of
//! the FMUs steps.
//!
//! Each row of the recording corresponds to a point in time. An input has the value that its FMU receives for the step
//! beginning at that time. An output has the value that the connected FMUs read in that step. A row thus shows a
//! controller's inputs and the outputs of its call at that time, and the state at that time of a plant that feeds back
//! to the controller. An output that no FMU reads is recorded together with the other outputs of its FMU; if none of
//! them is read, all have their values at that time, before the step. The last row corresponds to the end, without a
//! step: outputs have their values after the last step, and connected inputs the values of the connected outputs.
//!
//! FMUs with Event Mode are not part of that order: their values are exchanged at a communication point, before any FMU
//! steps. All of them enter Event Mode; one with an event is updated after those that feed it and also have an event,
//! and all are updated again until no output changes. The other FMUs then read their outputs, regardless of order. If
//! an earlier FMU without Event Mode passes a different value to one with Event Mode during the step, that value is
//! also read in Event Mode. An event within a step is handled with the current inputs.
//!
//! [`Run`] produces the same rows with one exception: each row corresponds to a call of the first member, the
//! controller, whose outputs are therefore the results of that call, whether or not they are read.

mod abreast;
mod events;

use crate::component::{Component, Force, Read, Reset, Terminated, Type, Wiring, Written};
use crate::plan::{Assignment, Column, MemberPlan, Plan, ROUNDING};
use crate::system::Exchange;
use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::ops::Range;

/// The recording of a run.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Recording {
    /// The columns of a row.
    pub columns: Vec<Column>,
    /// The time of each row in seconds: the start of each step, and the end.
    pub times: Vec<f64>,
    /// The rows, concatenated.
    values: Vec<f64>,
    /// The FMU that ended the run early, with the time. The last row then has the values from before the step in which
    /// the FMU did so.
    pub ended: Option<String>,
}

impl Recording {
    /// An empty recording with capacity for the whole run.
    fn new(plan: &Plan) -> Result<Recording> {
        let (mut times, mut values) = (Vec::new(), Vec::new());
        let width = plan.columns.len();
        let has_room = (plan.steps + 1).checked_mul(width).is_some_and(|count| {
            times.try_reserve_exact(plan.steps + 1).is_ok() && values.try_reserve_exact(count).is_ok()
        });
        if !has_room {
            let steps = plan.steps;
            bail!(
                "{steps} steps of {width} variables do not fit into memory: record fewer variables, or use longer steps"
            );
        }
        Ok(Recording { columns: plan.columns.clone(), times, values, ended: None })
    }

    /// A recording without rows.
    pub fn empty(columns: Vec<Column>) -> Recording {
        Recording { columns, times: Vec::new(), values: Vec::new(), ended: None }
    }

    /// Appends a row, with a value for each column.
    pub fn push(&mut self, time: f64, row: &[f64]) {
        debug_assert_eq!(row.len(), self.columns.len());
        self.times.push(time);
        self.values.extend_from_slice(row);
    }

    /// Appends the rows of another recording with the same columns.
    pub fn append(&mut self, other: Recording) {
        self.times.extend(other.times);
        self.values.extend(other.values);
        self.ended = self.ended.take().or(other.ended);
    }

    /// The rows, in order of time; true is 1.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = (f64, &[f64])> {
        let width = self.columns.len();
        self.times.iter().enumerate().map(move |(row, time)| (*time, &self.values[row * width..(row + 1) * width]))
    }

    /// The values of a column over time; true is 1.
    pub fn column(&self, column: usize) -> impl Iterator<Item = f64> {
        self.rows().map(move |(_, row)| row[column])
    }

    /// Writes CSV: the header `time,FMU.VARIABLE,...`, then the rows. A number is printed with the fewest digits that
    /// read back bit-equal; true is 1.
    ///
    /// # Errors
    /// Writing to `to` fails.
    pub fn write_csv(&self, to: &mut impl Write) -> io::Result<()> {
        write_csv(to, self.columns.iter(), self.rows().map(|(time, row)| (time, row.iter().copied())))
    }
}

/// Thins the rows of a long run for a plot: each group of consecutive rows becomes two, with the minimum and maximum of
/// each column in their original order.
#[derive(Debug)]
pub struct Thinned {
    recording: Recording,
    /// The number of rows in a group; 1 keeps all rows.
    every: usize,
    /// The number of rows in the current group so far.
    count: usize,
    first: f64,
    last: f64,
    /// For each column, the minimum and maximum of the current group, each with its position in the group.
    extremes: Vec<[(f64, usize); 2]>,
}

impl Thinned {
    /// Creates a thinner for a run with this many steps, which keeps about `most` rows.
    pub fn new(columns: Vec<Column>, steps: usize, most: usize) -> Thinned {
        let every = if steps <= most { 1 } else { (2 * steps).div_ceil(most.max(2)) };
        let extremes = Vec::with_capacity(columns.len());
        Thinned { recording: Recording::empty(columns), every, count: 0, first: 0.0, last: 0.0, extremes }
    }

    /// Adds the next row.
    pub fn push(&mut self, time: f64, row: &[f64]) {
        if self.every == 1 {
            return self.recording.push(time, row);
        }
        if self.count == 0 {
            self.first = time;
            self.extremes.clear();
            self.extremes.extend(row.iter().map(|value| [(*value, 0); 2]));
        }
        self.last = time;
        for ([least, greatest], value) in self.extremes.iter_mut().zip(row) {
            // Keep NaN: the curve has a gap there.
            if *value < least.0 || value.is_nan() {
                *least = (*value, self.count);
            } else if *value > greatest.0 {
                *greatest = (*value, self.count);
            }
        }
        self.count += 1;
        if self.count == self.every {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let Thinned { recording, extremes, count, first, last, .. } = self;
        let ordered = |of: &[(f64, usize); 2]| if of[0].1 <= of[1].1 { [of[0].0, of[1].0] } else { [of[1].0, of[0].0] };
        for (place, time) in [*first, *last].into_iter().enumerate().take(*count) {
            recording.push(time, &extremes.iter().map(|of| ordered(of)[place]).collect::<Vec<_>>());
        }
        *count = 0;
    }

    /// Removes and returns the recorded rows, if there are at least `rows`.
    pub fn take(&mut self, rows: usize) -> Option<Recording> {
        let empty = || Recording::empty(self.recording.columns.clone());
        (self.recording.times.len() >= rows.max(1))
            .then(empty)
            .map(|empty| std::mem::replace(&mut self.recording, empty))
    }

    /// Returns the remaining rows.
    pub fn recording(mut self) -> Recording {
        self.flush();
        self.recording
    }
}

/// Writes columns and rows like [`Recording::write_csv`].
///
/// # Errors
/// Writing to `to` fails.
pub fn write_csv<'a>(
    to: &mut impl Write,
    columns: impl Iterator<Item = &'a Column> + Clone,
    rows: impl Iterator<Item = (f64, impl Iterator<Item = f64>)>,
) -> io::Result<()> {
    write_header(to, columns.clone())?;
    for (time, row) in rows {
        write_row(to, columns.clone(), time, row)?;
    }
    Ok(())
}

/// Writes the header line of a CSV file.
///
/// # Errors
/// Writing to `to` fails.
pub fn write_header<'a>(to: &mut (impl Write + ?Sized), columns: impl Iterator<Item = &'a Column>) -> io::Result<()> {
    write!(to, "time")?;
    for column in columns {
        write!(to, ",{}", field(&column.name))?;
    }
    writeln!(to)
}

/// Writes a row of a CSV file.
///
/// # Errors
/// Writing to `to` fails.
pub fn write_row<'a>(
    to: &mut (impl Write + ?Sized),
    columns: impl Iterator<Item = &'a Column>,
    time: f64,
    row: impl Iterator<Item = f64>,
) -> io::Result<()> {
    write!(to, "{time:?}")?;
    for (value, column) in row.zip(columns) {
        write_value(to, column, value)?;
    }
    writeln!(to)
}

fn write_value(to: &mut (impl Write + ?Sized), column: &Column, value: f64) -> io::Result<()> {
    if column.kind.is_floating() { write!(to, ",{value:?}") } else { write!(to, ",{value}") }
}

/// Writes a row of a CSV file, given as cells (see [`Type::cell`]).
///
/// # Errors
/// Writing to `to` fails.
pub fn write_cells(to: &mut (impl Write + ?Sized), columns: &[Column], time: f64, row: &[f64]) -> io::Result<()> {
    write!(to, "{time:?}")?;
    for (cell, column) in row.iter().zip(columns) {
        match column.kind.whole_of(*cell).filter(|_| column.kind.is_wide()) {
            Some(whole) => write!(to, ",{whole}")?,
            None => write_value(to, column, *cell)?,
        }
    }
    writeln!(to)
}

/// A string as a CSV field (RFC 4180).
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

/// Runs the plan with one component for each member and keeps all rows. `progress` receives the number of completed
/// steps after each step.
///
/// # Errors
/// An FMU rejects a call; the error states its name, the rejected call, the time and its messages.
///
/// # Panics
/// The number of components differs from the number of members.
pub fn run<C: Component>(plan: &Plan, components: &mut [C], progress: impl FnMut(usize)) -> Result<Recording> {
    let mut recording = Recording::new(plan)?;
    let (times, values) = (&mut recording.times, &mut recording.values);
    recording.ended = run_into(plan, components, progress, |time, row| {
        times.push(time);
        values.extend_from_slice(row);
        Ok(())
    })?;
    Ok(recording)
}

/// Runs the plan like [`run()`], but passes each row to `give` as soon as it is complete. Returns the FMU that ended
/// the run early, with the time.
///
/// # Errors
/// As [`run()`], or `give` fails.
///
/// # Panics
/// As [`run()`].
pub fn run_into<C: Component>(
    plan: &Plan,
    components: &mut [C],
    progress: impl FnMut(usize),
    mut give: impl FnMut(f64, &[f64]) -> Result<()>,
) -> Result<Option<String>> {
    let mut numbers = vec![0.0; plan.columns.len()];
    run_cells(plan, components, progress, |time, row| {
        numbers.copy_from_slice(row);
        plan.to_numbers(&mut numbers);
        give(time, &numbers)
    })
}

/// Runs the plan like [`run_into`], but passes the exact values to `give`, as cells (see [`Type::cell`]).
///
/// # Errors
/// As [`run_into`].
///
/// # Panics
/// As [`run()`].
pub fn run_cells<C: Component>(
    plan: &Plan,
    components: &mut [C],
    mut progress: impl FnMut(usize),
    mut give: impl FnMut(f64, &[f64]) -> Result<()>,
) -> Result<Option<String>> {
    let stop = plan.time(plan.steps).max(plan.time(plan.steps - 1) + plan.step);
    let mut run = Run::begin(plan, components.iter_mut().collect(), Some(stop))?;
    run.recorded = recorded(plan, true);
    let mut ended = None;
    for step in 0..plan.steps {
        match run.step(plan) {
            Err(error) if error.is::<Terminated>() => {
                ended = Some(format!("{error:#}"));
                break;
            }
            stepped => stepped?,
        }
        give(run.time(), &run.cells)?;
        progress(step + 1);
    }
    if ended.is_none() {
        run.show_end(plan);
    } else {
        run.show_before();
    }
    give(plan.time(run.steps()), &run.cells)?;
    run.terminate(plan)?;
    Ok(ended)
}

/// A run performed step by step, without a predetermined end. It does not keep its [`Plan`]: functions that need the
/// plan receive it as an argument.
#[derive(Debug)]
pub struct Run<C> {
    members: Vec<Running<C>>,
    /// The number of completed steps.
    steps: usize,
    /// The number of members that have completed the current step.
    stepped: usize,
    /// The index of the active member.
    at: usize,
    /// The start time of the last step, in seconds.
    time: f64,
    /// The values of `observed`, member by member, followed by a copy from before the current step.
    values: Vec<f64>,
    /// The position in `values` of each recorded column.
    recorded: Vec<usize>,
    /// Whether `recorded` has yet to be adjusted to the members that have announced events.
    is_new: bool,
    /// The last recorded row, as cells (see [`Type::cell`]).
    cells: Vec<f64>,
    /// The same row as numbers; `None` if all cells are numbers.
    row: Option<Vec<f64>>,
    /// The columns whose numbers differ from the cells, with their types.
    wide: Vec<(usize, Type)>,
    /// A member's values before they are read again.
    kept: Vec<f64>,
}

/// A member of a run in progress.
#[derive(Debug)]
struct Running<C> {
    component: C,
    wiring: Wiring,
    /// The number of [`MemberPlan::events`] already applied.
    events: usize,
    /// The time of the next assignment in seconds; minus infinity if one is pending.
    next: f64,
    /// Assignments for the next step, applied after the plan's events.
    pending: Vec<Assignment>,
    /// The state of its events; `None` if it is not called in Event Mode.
    own: Option<events::Own>,
}

impl<C: Component> Run<C> {
    /// Initializes the components, one for each member of the plan. `stop` is the end in seconds, if known.
    ///
    /// # Errors
    /// An FMU rejects a call; the error states its name, the rejected call and its messages.
    ///
    /// # Panics
    /// The number of components differs from the number of members.
    pub fn begin(plan: &Plan, components: Vec<C>, stop: Option<f64>) -> Result<Run<C>> {
        assert_eq!(components.len(), plan.members.len(), "each member has a component");
        let members =
            components.into_iter().enumerate().map(|(member, component)| Running::new(plan, member, component));
        let mut run = Run {
            members: members.collect(),
            steps: 0,
            stepped: 0,
            at: 0,
            time: plan.start,
            values: vec![0.0; 2 * count(plan)],
            recorded: recorded(plan, false),
            is_new: true,
            cells: vec![0.0; plan.columns.len()],
            row: None,
            wide: plan.wide(),
            kept: Vec::new(),
        };
        run.initialize(plan, 0, plan.start, stop)?;
        run.record();
        Ok(run)
    }

    /// Performs one step.
    ///
    /// # Errors
    /// An FMU rejects a call; the error states its name, the rejected call, the time and its messages. The run is then
    /// over.
    pub fn step(&mut self, plan: &Plan) -> Result<()> {
        let time = plan.time(self.steps);
        (self.time, self.stepped) = (time, 0);
        let due = due(plan, time);
        if self.members.iter().any(|of| of.own.is_some()) {
            self.handle_events(plan, time, due)?;
        }
        self.keep();
        for (member, (of, own)) in self.members.iter_mut().zip(&plan.members).enumerate() {
            self.at = member;
            if of.own.is_some() {
                of.take_over(&self.values).map_err(|error| at_time(error, own, time))?;
            } else {
                if of.next <= due {
                    of.assign_due(own, due).map_err(|error| at_time(error, own, time))?;
                }
                of.write_inputs(&self.values).map_err(|error| at_time(error, own, time))?;
            }
            of.component.step(time, plan.step).map_err(|error| in_step(error, own))?;
            self.stepped = member + 1;
            of.observe(&mut self.values).map_err(|error| after_step(error, own, time))?;
        }
        self.end_step();
        Ok(())
    }

    /// Copies the current values to those from before the step.
    #[inline]
    fn keep(&mut self) {
        let count = self.values.len() / 2;
        let (values, before) = self.values.split_at_mut(count);
        before.copy_from_slice(values);
    }

    /// Completes a step.
    #[inline]
    fn end_step(&mut self) {
        self.record();
        if !self.wide.is_empty() {
            let row = self.row.insert(self.cells.clone());
            self.wide.iter().for_each(|(column, kind)| row[*column] = kind.number(row[*column]));
        }
        self.steps += 1;
    }

    /// Records the step's row.
    #[inline]
    fn record(&mut self) {
        for (value, place) in self.cells.iter_mut().zip(&self.recorded) {
            *value = self.values[*place];
        }
    }

    /// Completes the row of a step in which an FMU ended the run, with the values from before the step.
    fn show_before(&mut self) {
        let count = self.values.len() / 2;
        for (value, place) in self.cells.iter_mut().zip(&self.recorded).filter(|(_, place)| **place >= count) {
            *value = self.values[*place];
        }
    }

    /// Completes the last row, in which connected inputs have the values that they would receive in a further step.
    fn show_end(&mut self, plan: &Plan) {
        for (value, column) in self.cells.iter_mut().zip(&plan.columns) {
            *value = self.values[place(plan, plan.source_of(column).unwrap_or(column.source))];
        }
    }

    /// Abandons a step after an error of [`Run::step`]. If the first member has completed the step, it counts, and its
    /// row has the last known values of the other members. Returns whether it counts.
    pub fn abandon_step(&mut self) -> bool {
        let counts = self.stepped > 0;
        if counts {
            self.end_step();
        }
        counts
    }

    /// Replaces all members except the first, which continues. The new ones start at the time of the next step. `plan`
    /// is the plan with the new members; it has the old start and step, and observes the same variables of the first
    /// member.
    ///
    /// # Errors
    /// A new FMU rejects a call; the error contains its messages. In that case, nothing is replaced.
    ///
    /// # Panics
    /// The number of components is wrong, or the plan observes other variables of the first member.
    pub fn exchange(&mut self, plan: &Plan, others: Vec<C>) -> Result<()> {
        assert_eq!(others.len() + 1, plan.members.len(), "each member has a component");
        assert_eq!(self.members[0].wiring.own.len(), plan.members[0].observed.references.len(), "the same variables");
        let before = self.members.split_off(1);
        let first = std::mem::replace(&mut self.members[0].wiring, Wiring::new(plan, 0));
        self.members.extend(others.into_iter().enumerate().map(|(other, of)| Running::new(plan, other + 1, of)));
        let values = self.values.clone();
        self.values.truncate(first.own.end);
        self.values.resize(2 * count(plan), 0.0);
        let exchanged = self.initialize(plan, 1, plan.time(self.steps), None);
        if exchanged.is_err() {
            self.members.truncate(1);
            self.members.extend(before);
            self.members[0].wiring = first;
            self.values = values;
        } else {
            (self.recorded, self.is_new) = (recorded(plan, false), true);
            self.cells = vec![0.0; plan.columns.len()];
            (self.row, self.wide) = (None, plan.wide());
        }
        exchanged
    }

    /// The index of the last active member: after an error of [`Run::step`], the one that failed.
    pub fn at(&self) -> usize {
        self.at
    }

    /// The values last read, for each column of the plan; true is 1. Before the first step, the values after
    /// initialization.
    pub fn values(&self, plan: &Plan) -> Vec<f64> {
        plan.columns.iter().map(|column| column.kind.number(self.values[place(plan, column.source)])).collect()
    }

    /// Sets a variable of a member in the next step, after the plan's own settings.
    pub fn set(&mut self, member: usize, assignment: Assignment) {
        let of = &mut self.members[member];
        of.pending.push(assignment);
        of.next = f64::NEG_INFINITY;
    }

    /// Overwrites a variable of any kind in a member.
    ///
    /// # Errors
    /// The member does not allow it.
    pub fn force(&mut self, member: usize, reference: u32, how: Force) -> Result<()> {
        self.members[member].component.force(reference, how)
    }

    /// The number of completed steps.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// The start time of the last step, in seconds.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The row of the last step as numbers, one for each column of the plan; true is 1.
    pub fn row(&self) -> &[f64] {
        self.row.as_ref().unwrap_or(&self.cells)
    }

    /// Ends the simulation.
    ///
    /// # Errors
    /// An FMU rejects a call; the error states its name and messages.
    pub fn terminate(&mut self, plan: &Plan) -> Result<()> {
        for (of, plan) in self.members.iter_mut().zip(&plan.members) {
            of.component.terminate().with_context(|| plan.name.clone())?;
        }
        Ok(())
    }

    /// Initializes the members from index `first` onward, at `start` seconds.
    fn initialize(&mut self, plan: &Plan, first: usize, start: f64, stop: Option<f64>) -> Result<()> {
        let at = |of: &MemberPlan| format!("{} before the first step", of.name);
        for (of, own) in self.members.iter_mut().zip(&plan.members).skip(first) {
            of.component.setup(start, stop).with_context(|| at(own))?;
            of.assign(&own.parameters).with_context(|| at(own))?;
            of.component.enter_initialization().with_context(|| at(own))?;
            of.assign(&own.inputs).with_context(|| at(own))?;
            of.observe_outputs(own, &mut self.values).with_context(|| at(own))?;
        }
        for _ in first..plan.members.len() {
            self.keep();
            for (of, own) in self.members.iter_mut().zip(&plan.members).skip(first) {
                of.write_inputs(&self.values).with_context(|| at(own))?;
                if plan.exchange == Exchange::Sequential {
                    of.observe_outputs(own, &mut self.values).with_context(|| at(own))?;
                }
            }
            let (values, before) = self.values.split_at(self.values.len() / 2);
            if before.iter().zip(values).all(|(before, after)| before.to_bits() == after.to_bits()) {
                break;
            }
        }
        for (of, own) in self.members.iter_mut().zip(&plan.members).skip(first) {
            of.component.exit_initialization().with_context(|| at(own))?;
            of.observe(&mut self.values).with_context(|| at(own))?;
        }
        Ok(())
    }
}

impl<C: Reset> Run<C> {
    /// Restarts the run after resetting all components. The plan may set different values, but must observe and connect
    /// the same variables.
    ///
    /// # Errors
    /// As [`Run::begin`], or an FMU cannot be reset. New components are then required.
    pub fn restart(&mut self, plan: &Plan, stop: Option<f64>) -> Result<()> {
        for (of, own) in self.members.iter_mut().zip(&plan.members) {
            of.component.reset().with_context(|| own.name.clone())?;
            of.events = 0;
            of.pending.clear();
            of.expect_next(own);
            of.own = own.has_events.then(events::Own::default);
        }
        self.values.fill(0.0);
        (self.steps, self.stepped, self.at, self.time) = (0, 0, 0, plan.start);
        self.is_new = true;
        self.initialize(plan, 0, plan.start, stop)
    }
}

impl Wiring {
    /// The wiring of a member, by index.
    fn new(plan: &Plan, member: usize) -> Wiring {
        let own = &plan.members[member];
        let first = first_value(plan, member);
        let read = |(kind, range): (Type, Range<usize>)| Read {
            kind,
            references: own.observed.references[range.clone()].to_vec(),
            places: first + range.start..first + range.end,
        };
        let written = |(kind, range): (Type, Range<usize>)| Written {
            kind,
            references: own.connected.references[range.clone()].to_vec(),
            sources: own.sources[range.clone()].iter().map(|source| seen(plan, member, *source)).collect(),
            converted: own.sources[range.clone()]
                .iter()
                .map(|(from, place)| plan.members[*from].observed.kind(*place))
                .enumerate()
                .filter(|(_, from)| *from != kind && (from.is_wide() || kind.is_wide()))
                .collect(),
            values: vec![0.0; range.len()],
            seen: vec![f64::NAN; range.len()],
        };
        Wiring {
            own: first..first_value(plan, member + 1),
            read: own.observed.groups().map(read).collect(),
            written: own.connected.groups().map(written).collect(),
        }
    }
}

impl Written {
    /// Converts values between 64-bit integers and other types.
    #[cold]
    #[inline(never)]
    fn convert(&mut self) -> Result<()> {
        for (place, from) in &self.converted {
            let whole = from.whole_of(self.values[*place]);
            let cell = whole.and_then(|whole| self.kind.whole_cell(whole));
            let shown = || whole.map_or_else(|| format!("{:?}", self.values[*place]), |whole| whole.to_string());
            self.values[*place] =
                cell.with_context(|| format!("{} does not fit into {}", shown(), self.kind.name()))?;
        }
        Ok(())
    }
}

/// The time, in seconds, up to which settings belong to the step that starts at `time`.
fn due(plan: &Plan, time: f64) -> f64 {
    time + ROUNDING * plan.step
}

/// The total number of values of all members.
fn count(plan: &Plan) -> usize {
    first_value(plan, plan.members.len())
}

/// The position of a member's first value among the run's values.
fn first_value(plan: &Plan, member: usize) -> usize {
    plan.members[..member].iter().map(|of| of.observed.references.len()).sum()
}

/// The position of a value among the run's values, given the member and the position in its `observed`.
fn place(plan: &Plan, (member, place): (usize, usize)) -> usize {
    first_value(plan, member) + place
}

/// The position at which a member reads a value: in the copy from before the step, unless it receives the value that an
/// earlier member produced in the same step.
fn seen(plan: &Plan, member: usize, source: (usize, usize)) -> usize {
    let is_in_order = plan.exchange == Exchange::Sequential && !plan.members[source.0].has_events;
    let is_given_in_step = is_in_order && source.0 < member;
    place(plan, source) + if is_given_in_step { 0 } else { count(plan) }
}

/// The positions of the columns' values. With `of_times`, a row shows the values at its time instead of the results of
/// the first member's call.
fn recorded(plan: &Plan, of_times: bool) -> Vec<usize> {
    let is_at_its_time = |column: &Column| column.is_unread && (of_times || column.source.0 > 0);
    let is_before = |column: &Column| column.is_before_step || is_at_its_time(column);
    let place = |column: &Column| place(plan, column.source) + if is_before(column) { count(plan) } else { 0 };
    plan.columns.iter().map(place).collect()
}

impl<C: Component> Running<C> {
    fn new(plan: &Plan, member: usize, component: C) -> Running<C> {
        let wiring = Wiring::new(plan, member);
        let own = plan.members[member].has_events.then(events::Own::default);
        let mut running = Running { component, wiring, events: 0, next: f64::NAN, pending: Vec::new(), own };
        running.expect_next(&plan.members[member]);
        running
    }

    /// Updates the time of the next assignment.
    fn expect_next(&mut self, own: &MemberPlan) {
        self.next = own.events.get(self.events).map_or(f64::INFINITY, |(at, _)| *at);
    }

    /// Applies all settings due by this time, in seconds. Not inlined: most steps set nothing.
    #[inline(never)]
    fn assign_due(&mut self, own: &MemberPlan, due: f64) -> Result<()> {
        while let Some((at, assignment)) = own.events.get(self.events)
            && *at <= due
        {
            self.events += 1;
            self.assign([assignment])?;
        }
        self.expect_next(own);
        let pending = std::mem::take(&mut self.pending);
        self.assign(&pending)
    }

    fn assign<'a>(&mut self, assignments: impl IntoIterator<Item = &'a Assignment>) -> Result<()> {
        for assignment in assignments {
            self.component.write(assignment.kind, &[assignment.reference], &[assignment.value])?;
        }
        Ok(())
    }

    /// Writes the connected inputs from the run's values.
    #[inline(always)]
    fn write_inputs(&mut self, values: &[f64]) -> Result<()> {
        self.write_inputs_at(values, |source| source)
    }

    /// Writes the connected inputs; `place` maps a source to its position.
    #[inline(always)]
    fn write_inputs_at(&mut self, values: &[f64], place: impl Fn(usize) -> usize) -> Result<()> {
        for group in &mut self.wiring.written {
            for (value, source) in group.values.iter_mut().zip(&group.sources) {
                *value = values[place(*source)];
            }
            if self.own.is_some() {
                group.seen.copy_from_slice(&group.values);
            }
            if !group.converted.is_empty() {
                group.convert()?;
            }
            self.component.write(group.kind, &group.references, &group.values)?;
        }
        Ok(())
    }

    /// Updates the run's values with all variables that other members read or that are recorded.
    #[inline(always)]
    fn observe(&mut self, values: &mut [f64]) -> Result<()> {
        for group in &self.wiring.read {
            self.component.read(group.kind, &group.references, &mut values[group.places.clone()])?;
        }
        Ok(())
    }

    /// Reads only the connected outputs because the standard allows nothing else in Initialization Mode.
    fn observe_outputs(&mut self, plan: &MemberPlan, values: &mut [f64]) -> Result<()> {
        let mut outputs = vec![0.0; plan.outputs.references.len()];
        for (kind, range) in plan.outputs.groups() {
            self.component.read(kind, &plan.outputs.references[range.clone()], &mut outputs[range])?;
        }
        let own = &mut values[self.wiring.own.clone()];
        for (place, output) in plan.output_places.iter().zip(outputs) {
            own[*place] = output;
        }
        Ok(())
    }
}

// Error contexts. Separate functions, so that successful steps do not load their code.

#[cold]
#[inline(never)]
fn at_time(error: anyhow::Error, own: &MemberPlan, time: f64) -> anyhow::Error {
    error.context(format!("{} at {time:?} s", own.name))
}

#[cold]
#[inline(never)]
fn in_step(error: anyhow::Error, own: &MemberPlan) -> anyhow::Error {
    error.context(own.name.clone())
}

#[cold]
#[inline(never)]
fn after_step(error: anyhow::Error, own: &MemberPlan, time: f64) -> anyhow::Error {
    error.context(format!("{} after the step at {time:?} s", own.name))
}

#[cfg(test)]
mod tests;
