//! Runs a plan and records it.
//!
//! Initialization: every FMU gets its parameters, enters Initialization Mode and gets its inputs; then the connected values
//! go from output to input, in the order of the FMUs, until no output changes, so that a value goes through chains (plant, sensor,
//! filter) in whatever order they are, but not more often than there are FMUs; then every FMU leaves Initialization Mode.
//! With [`Exchange::Parallel`] they go once.
//!
//! Step k goes from `start + k step` to `start + (k + 1) step`. Each FMU in turn gets the values that are set at that time,
//! then its connected inputs, and steps. With [`Exchange::Parallel`], all inputs are what was there before any of them steps.
//!
//! A row of the recording belongs to a time. An input has the value that its FMU gets for the step that begins then. An output
//! has the value that the connected FMUs read in that step. So the row of a controller is what it saw and gave in its call at
//! that time, and a plant that is connected back to the controller shows what it is at that time. An output that no FMU reads
//! is recorded as the other outputs of its FMU; if none of them is read, all have the values of that time, before the step.
//! The last row is that of the end, without a step: outputs have the values that the last step gave, connected
//! inputs those of their outputs.
//!
//! An FMU with Event Mode has no place in that order: the values that it gives and gets at a communication point are exchanged
//! there, before any FMU steps. All such FMUs enter Event Mode; each that has an event then is updated after those that feed it and
//! have one too, and all once more as long as an output changes. Others see its outputs as they are after that, wherever it
//! stands. If an FMU without Event Mode that stands before it gives it another value in the step, it takes that over in Event Mode too.
//! An event within a step is handled with the inputs as they are.
//!
//! [`Run`] gives the same rows but for one thing: a row is a call of the first member, the controller, so that its outputs are
//! those that the call gave, whether anybody reads them or not.

mod abreast;
mod events;

use crate::component::{Component, Force, Read, Reset, Terminated, Type, Wiring, Written};
use crate::plan::{Assignment, Column, MemberPlan, Plan, ROUNDING};
use crate::system::Exchange;
use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::ops::Range;

/// What a run has recorded.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Recording {
    /// What the values of a row are.
    pub columns: Vec<Column>,
    /// The time of each row in seconds: the beginning of each step, and the end.
    pub times: Vec<f64>,
    /// The rows, one after the other.
    values: Vec<f64>,
    /// The FMU that ended the run early, and when. The step in which it did so has no row.
    pub ended: Option<String>,
}

impl Recording {
    /// An empty one, with room for the whole run.
    fn of(plan: &Plan) -> Result<Recording> {
        let (mut times, mut values) = (Vec::new(), Vec::new());
        let width = plan.columns.len();
        let has_room = (plan.steps + 1).checked_mul(width).is_some_and(|count| {
            times.try_reserve_exact(plan.steps + 1).is_ok() && values.try_reserve_exact(count).is_ok()
        });
        if !has_room {
            let steps = plan.steps;
            bail!("{steps} steps of {width} variables do not fit into the memory: record fewer, or make longer steps");
        }
        Ok(Recording { columns: plan.columns.clone(), times, values, ended: None })
    }

    /// One without rows.
    pub fn empty(columns: Vec<Column>) -> Recording {
        Recording { columns, times: Vec::new(), values: Vec::new(), ended: None }
    }

    /// Adds a row, with a value for each column.
    pub fn push(&mut self, time: f64, row: &[f64]) {
        debug_assert_eq!(row.len(), self.columns.len());
        self.times.push(time);
        self.values.extend_from_slice(row);
    }

    /// Adds the rows of another recording of the same columns.
    pub fn append(&mut self, other: Recording) {
        self.times.extend(other.times);
        self.values.extend(other.values);
        self.ended = self.ended.take().or(other.ended);
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

    /// Writes CSV: the header `time,FMU.VARIABLE,...`, then the rows. A number is the shortest that reads back
    /// bit-equal; true is 1.
    ///
    /// # Errors
    /// Those of `to`.
    pub fn write_csv(&self, to: &mut impl Write) -> io::Result<()> {
        write_csv(to, self.columns.iter(), self.rows().map(|(time, row)| (time, row.iter().copied())))
    }
}

/// Thins the rows of a long run for a picture. This many consecutive ones become two, which have the least and the
/// greatest value of each column, in the order in which they were.
#[derive(Debug)]
pub struct Thinned {
    recording: Recording,
    /// How many rows become two; 1 keeps them all.
    every: usize,
    /// How many there are of the present ones.
    count: usize,
    first: f64,
    last: f64,
    /// Of each column the least value and the greatest, each with its place among the present ones.
    extremes: Vec<[(f64, usize); 2]>,
}

impl Thinned {
    /// For a run with this many steps and about `most` rows.
    pub fn new(columns: Vec<Column>, steps: usize, most: usize) -> Thinned {
        let every = if steps <= most { 1 } else { (2 * steps).div_ceil(most.max(2)) };
        let extremes = Vec::with_capacity(columns.len());
        Thinned { recording: Recording::empty(columns), every, count: 0, first: 0.0, last: 0.0, extremes }
    }

    /// The next row.
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
            // A value that is not a number is kept, since a curve has a gap there.
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

    /// What there is, if it is this many rows or more; they are not kept then.
    pub fn take(&mut self, rows: usize) -> Option<Recording> {
        let empty = || Recording::empty(self.recording.columns.clone());
        (self.recording.times.len() >= rows.max(1))
            .then(empty)
            .map(|empty| std::mem::replace(&mut self.recording, empty))
    }

    /// What is left of the rows.
    pub fn recording(mut self) -> Recording {
        self.flush();
        self.recording
    }
}

/// Writes columns and rows as [`Recording::write_csv`] does.
///
/// # Errors
/// Those of `to`.
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

/// Writes the first line of a CSV.
///
/// # Errors
/// Those of `to`.
pub fn write_header<'a>(to: &mut (impl Write + ?Sized), columns: impl Iterator<Item = &'a Column>) -> io::Result<()> {
    write!(to, "time")?;
    for column in columns {
        write!(to, ",{}", field(&column.name))?;
    }
    writeln!(to)
}

/// Writes a row of a CSV.
///
/// # Errors
/// Those of `to`.
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

/// The same of values as [`Type::cell`] says.
///
/// # Errors
/// Those of `to`.
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

/// A text as a field of CSV (RFC 4180).
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

/// Runs the plan with one component for each of its members, and keeps all rows. `progress` gets the number of steps that are
/// made, after each.
///
/// # Errors
/// Which FMU refused what, when, and its messages.
///
/// # Panics
/// There are not as many components as members.
pub fn run<C: Component>(plan: &Plan, components: &mut [C], progress: impl FnMut(usize)) -> Result<Recording> {
    let mut recording = Recording::of(plan)?;
    let (times, values) = (&mut recording.times, &mut recording.values);
    recording.ended = run_into(plan, components, progress, |time, row| {
        times.push(time);
        values.extend_from_slice(row);
        Ok(())
    })?;
    Ok(recording)
}

/// The same, and gives each row when it is there. Says which FMU ended the run before its time, and when.
///
/// # Errors
/// Those of [`run()`] and of `give`.
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

/// The same, and gives the values as [`Type::cell`] says: exactly.
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

/// A run in progress, step by step. It needs its [`Plan`] with each call and does not know an end.
#[derive(Debug)]
pub struct Run<C> {
    members: Vec<Running<C>>,
    /// How many steps have been made.
    steps: usize,
    /// How many members have made the present step.
    stepped: usize,
    /// Which member works.
    at: usize,
    /// When the last step began, in seconds.
    time: f64,
    /// The values of `observed` of all members, one member after the other; then once more as they were before the present step.
    values: Vec<f64>,
    /// Where what is recorded is in `values`, for each column of the plan.
    recorded: Vec<usize>,
    /// Whether a member has said nothing of its events yet, on which it depends where that is.
    is_new: bool,
    /// What the last step recorded, for each column of the plan, as [`Type::cell`] says.
    cells: Vec<f64>,
    /// The same as numbers; only if they differ.
    row: Option<Vec<f64>>,
    /// The columns whose numbers differ from what is moved, with their types.
    wide: Vec<(usize, Type)>,
    /// The values of a member before they are read again.
    kept: Vec<f64>,
}

/// A member at work.
#[derive(Debug)]
struct Running<C> {
    component: C,
    wiring: Wiring,
    /// How many of `plan.events` have been.
    events: usize,
    /// When the next of them is, in seconds; minus infinity if anything is pending.
    next: f64,
    /// The assignments of the next step, after the plan's events.
    pending: Vec<Assignment>,
    /// Its announced events; `None` if it is not called in Event Mode.
    own: Option<events::Own>,
}

impl<C: Component> Run<C> {
    /// Initializes the components, one for each member of the plan. `stop` is the end in seconds, if it is known.
    ///
    /// # Errors
    /// Which FMU refused what, and its messages.
    ///
    /// # Panics
    /// There are not as many components as members.
    pub fn begin(plan: &Plan, components: Vec<C>, stop: Option<f64>) -> Result<Run<C>> {
        assert_eq!(components.len(), plan.members.len(), "each member has a component");
        let members =
            components.into_iter().enumerate().map(|(member, component)| Running::of(plan, member, component));
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

    /// Makes one step.
    ///
    /// # Errors
    /// Which FMU refused what, when, and its messages. The run is over then.
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

    /// Keeps the values as those before the step.
    #[inline]
    fn keep(&mut self) {
        let count = self.values.len() / 2;
        let (values, before) = self.values.split_at_mut(count);
        before.copy_from_slice(values);
    }

    /// Ends a step.
    #[inline]
    fn end_step(&mut self) {
        self.record();
        if !self.wide.is_empty() {
            let row = self.row.insert(self.cells.clone());
            self.wide.iter().for_each(|(column, kind)| row[*column] = kind.number(row[*column]));
        }
        self.steps += 1;
    }

    /// Records the step.
    #[inline]
    fn record(&mut self) {
        for (value, place) in self.cells.iter_mut().zip(&self.recorded) {
            *value = self.values[*place];
        }
    }

    /// Makes the row of a step that has begun and was ended: what it records of the time before it.
    fn show_before(&mut self) {
        let count = self.values.len() / 2;
        for (value, place) in self.cells.iter_mut().zip(&self.recorded).filter(|(_, place)| **place >= count) {
            *value = self.values[*place];
        }
    }

    /// Makes the row of the end: connected inputs are what they would get in another step.
    fn show_end(&mut self, plan: &Plan) {
        for (value, column) in self.cells.iter_mut().zip(&plan.columns) {
            *value = self.values[place(plan, plan.source_of(column).unwrap_or(column.source))];
        }
    }

    /// After an error of [`Run::step`]: if the first member has made the step, the step counts, and its row has the last
    /// known values of the others. Says whether it counts.
    pub fn abandon_step(&mut self) -> bool {
        let counts = self.stepped > 0;
        if counts {
            self.end_step();
        }
        counts
    }

    /// Replaces all members but the first, which continues. The new ones begin at the time of the next step; `plan` is theirs,
    /// with the old start and step, and observes the same variables of the first member.
    ///
    /// # Errors
    /// A refusal of a new FMU, with its messages. Nothing is replaced then.
    ///
    /// # Panics
    /// There are not as many components as other members, or something else is observed of the first.
    pub fn exchange(&mut self, plan: &Plan, others: Vec<C>) -> Result<()> {
        assert_eq!(others.len() + 1, plan.members.len(), "each member has a component");
        assert_eq!(self.members[0].wiring.own.len(), plan.members[0].observed.references.len(), "the same is observed");
        let before = self.members.split_off(1);
        let first = std::mem::replace(&mut self.members[0].wiring, Wiring::of(plan, 0));
        self.members.extend(others.into_iter().enumerate().map(|(other, of)| Running::of(plan, other + 1, of)));
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

    /// Which member worked last: after an error of [`Run::step`], the one that failed.
    pub fn at(&self) -> usize {
        self.at
    }

    /// What was last read, for each column of the plan; true is 1. Before the first step these are the values after the
    /// initialization.
    pub fn values(&self, plan: &Plan) -> Vec<f64> {
        plan.columns.iter().map(|column| column.kind.number(self.values[place(plan, column.source)])).collect()
    }

    /// Sets a variable of a member in the next step, after what the plan sets then.
    pub fn set(&mut self, member: usize, assignment: Assignment) {
        let of = &mut self.members[member];
        of.pending.push(assignment);
        of.next = f64::NEG_INFINITY;
    }

    /// Writes a variable of a member whatever it is.
    ///
    /// # Errors
    /// The member does not allow it.
    pub fn force(&mut self, member: usize, reference: u32, how: Force) -> Result<()> {
        self.members[member].component.force(reference, how)
    }

    /// How many steps have been made.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// When the last step began, in seconds.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// What the last step recorded, for each column of the plan; true is 1.
    pub fn row(&self) -> &[f64] {
        self.row.as_ref().unwrap_or(&self.cells)
    }

    /// Ends the simulation.
    ///
    /// # Errors
    /// Which FMU refused, and its messages.
    pub fn terminate(&mut self, plan: &Plan) -> Result<()> {
        for (of, plan) in self.members.iter_mut().zip(&plan.members) {
            of.component.terminate().with_context(|| plan.name.clone())?;
        }
        Ok(())
    }

    /// Initializes the members from number `first` on, at `start` seconds.
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
    /// Begins anew, with all components reset. The plan may set other values than before, but observes and connects the same.
    ///
    /// # Errors
    /// As [`Run::begin`], and an FMU cannot be reset. Only new components can go on then.
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
    /// That of a member by its number.
    fn of(plan: &Plan, member: usize) -> Wiring {
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
    /// Makes whole numbers of 64 bits of others, and others of them.
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

/// What is set by this time is set in the step that begins at `time`, in seconds.
fn due(plan: &Plan, time: f64) -> f64 {
    time + ROUNDING * plan.step
}

/// How many values all members have.
fn count(plan: &Plan) -> usize {
    first_value(plan, plan.members.len())
}

/// Where the values of a member begin in those of the run.
fn first_value(plan: &Plan, member: usize) -> usize {
    plan.members[..member].iter().map(|of| of.observed.references.len()).sum()
}

/// Where a value is in those of the run: that of a member, at a place of its `observed`.
fn place(plan: &Plan, (member, place): (usize, usize)) -> usize {
    first_value(plan, member) + place
}

/// Where a member sees a value: as it was before the step, unless it gets what those before it have given in the same step.
fn seen(plan: &Plan, member: usize, source: (usize, usize)) -> usize {
    let is_in_order = plan.exchange == Exchange::Sequential && !plan.members[source.0].has_events;
    let is_given_in_step = is_in_order && source.0 < member;
    place(plan, source) + if is_given_in_step { 0 } else { count(plan) }
}

/// Where the values of the columns are. `of_times` asks for rows of times, in place of those of the first member's calls.
fn recorded(plan: &Plan, of_times: bool) -> Vec<usize> {
    let is_at_its_time = |column: &Column| column.is_unread && (of_times || column.source.0 > 0);
    let is_before = |column: &Column| column.is_before_step || is_at_its_time(column);
    let place = |column: &Column| place(plan, column.source) + if is_before(column) { count(plan) } else { 0 };
    plan.columns.iter().map(place).collect()
}

impl<C: Component> Running<C> {
    fn of(plan: &Plan, member: usize, component: C) -> Running<C> {
        let wiring = Wiring::of(plan, member);
        let own = plan.members[member].has_events.then(events::Own::default);
        let mut running = Running { component, wiring, events: 0, next: f64::NAN, pending: Vec::new(), own };
        running.expect_next(&plan.members[member]);
        running
    }

    /// Notes when the next event is.
    fn expect_next(&mut self, own: &MemberPlan) {
        self.next = own.events.get(self.events).map_or(f64::INFINITY, |(at, _)| *at);
    }

    /// Sets what is set by this time, in seconds. Few steps set anything.
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

    /// Writes the connected inputs, from the values of the run.
    #[inline(always)]
    fn write_inputs(&mut self, values: &[f64]) -> Result<()> {
        self.write_inputs_at(values, |source| source)
    }

    /// The same; `place` says where a source is.
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

    /// Reads everything that others need or that is recorded, into the values of the run.
    #[inline(always)]
    fn observe(&mut self, values: &mut [f64]) -> Result<()> {
        for group in &self.wiring.read {
            self.component.read(group.kind, &group.references, &mut values[group.places.clone()])?;
        }
        Ok(())
    }

    /// Reads the connected outputs alone: in Initialization Mode the standard allows no more.
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

// What an error is about. Functions of their own, so that a step that succeeds does not carry their code along.

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
