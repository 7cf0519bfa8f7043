//! The running loop, which a user operates interactively, with its record; and the earlier runs.
//!
//! A run is bit-identical to that of `plcfmu run` with the same [`Setup`] and the same settings ([`Done`]): settings
//! take effect before the next call, like those in a description.

mod force;
mod script;
mod until;

use crate::chain::begin_at_the_plant;
use crate::home::Home;
use crate::message::{self, Act, Curves, Event, Events, Setup, State, Values, View};
use anyhow::{Context, Result, bail};
use blocks::table::number::to_value;
use force::Forced;
use modeldescription::Table;
use modeldescription::{Causality, Description};
use run::component::{Component, Type};
use run::master::Run;
use run::plan::{self, Assignment, Column, Names, Plan, Reference};
use run::system::{self, Connection, Recorded, Setting, System, Value, own_name};
use run::trace::Trace;
use script::Script;
use std::collections::{BTreeMap, HashMap, VecDeque};
use std::sync::Arc;

pub use until::Until;

/// The maximum number of calls in a request.
pub const MOST_CALLS: usize = 100_000;

/// The maximum number of calls of a ramp.
pub const MOST_RAMP: usize = 100_000;

/// The maximum number of events of a run.
pub const MOST_EVENTS: usize = 1_000_000;

/// The maximum number of calls in a run that is repeated on the side, such as a trial run while the user types.
pub const MOST_TRIED: usize = 20_000;

/// The maximum number of members of a loop.
const MOST_MEMBERS: usize = 100;

/// The maximum length of a member's name, in characters.
const LONGEST_NAME: usize = 200;

/// The maximum number of recorded variables of a foreign FMU.
const MOST_RECORDED: usize = 1000;

/// The maximum number of calls that a block may make in one communication step.
const MOST_CALLS_OF_STEP: f64 = 1000.0;

/// The number of earlier runs kept.
const EARLIER: usize = 5;

/// The current run and the earlier ones.
#[derive(Default)]
pub struct Session {
    /// Oldest first.
    earlier: VecDeque<Record>,
    present: Option<Present>,
    /// The number of runs started so far.
    runs: usize,
}

/// The setup and the recording of a run.
#[derive(Clone, Debug)]
pub struct Record {
    /// The 0-based number of the run.
    number: usize,
    setup: Setup,
    /// The time of the first call (call 0), in seconds.
    start: f64,
    /// The communication step, in seconds.
    step: f64,
    /// All recorded variables of all past and present members.
    columns: Vec<Column>,
    /// The index of each column, by the variable's name.
    places: HashMap<String, usize>,
    /// The variables set while it ran, in chronological order.
    done: Vec<Done>,
    exchanges: Vec<Exchanged>,
    trace: Trace,
    failure: Option<String>,
}

/// A setting made while the loop ran.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Done {
    /// The 0-based index of the call before which it was set.
    pub call: usize,
    /// The variable, as the index of its column in the record.
    pub column: usize,
    /// Its type.
    pub kind: Type,
    /// Its value; true is 1.
    pub value: f64,
    /// How it was set.
    pub act: Act,
}

/// A replacement of members while the loop ran.
#[derive(Clone, Debug, PartialEq)]
pub struct Exchanged {
    /// The 0-based index of the call before which they were replaced.
    pub call: usize,
    /// All members from then on, except the first, which continues.
    pub members: Vec<message::Member>,
    /// All connections from then on.
    pub connections: Vec<(String, String)>,
}

/// The current run, which can be continued.
struct Present {
    record: Record,
    /// The current system, which may differ from the record's setup after an exchange of members.
    wired: Wired,
    run: Run<Box<dyn Component>>,
    /// For each column of the plan, the index of its column in the record.
    of_plan: Vec<usize>,
    /// The row of the last call, with a value for each column of the record.
    row: Vec<f64>,
    ramps: BTreeMap<usize, Ramp>,
    /// The forced variables, by column.
    forced: BTreeMap<usize, Forced>,
    /// Remarks to return with the next answer.
    remarks: Vec<String>,
}

/// A system with the descriptions of its members and its plan.
struct Wired {
    system: System,
    descriptions: Vec<Arc<Description>>,
    tables: Vec<Option<Arc<Table>>>,
    plan: Plan,
}

/// A variable that is being ramped to a value.
#[derive(Clone, Copy)]
struct Ramp {
    member: usize,
    assignment: Assignment,
    /// The 0-based index of the call before which the first value is set.
    first: usize,
    /// The number of calls before which a value is set.
    calls: usize,
    from: f64,
    to: f64,
}

impl Record {
    /// The 0-based number of the run.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The setup at the start of the run.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The variables set while it ran, in chronological order.
    pub fn done(&self) -> &[Done] {
        &self.done
    }

    /// The replacements of members while it ran.
    pub fn exchanges(&self) -> &[Exchanged] {
        &self.exchanges
    }

    /// The number of calls made.
    pub fn calls(&self) -> usize {
        self.trace.calls()
    }

    /// The communication step, in seconds.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The time of a call, in seconds.
    pub fn time(&self, call: usize) -> f64 {
        plan::time(self.start, self.step, call)
    }

    /// The recorded variables, with types and units.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The index of a variable's column, by `MEMBER.VARIABLE`.
    ///
    /// # Errors
    /// No such variable; the message suggests a similar one.
    pub fn column(&self, variable: &str) -> Result<usize> {
        if let Some(place) = self.places.get(variable) {
            return Ok(*place);
        }
        let hint = plan::suggestion(variable, self.columns.iter().map(|column| column.name.as_str()));
        bail!("run {} has no recorded variable {variable:?}{hint}", self.number)
    }

    /// The recorded values.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Why the run ended, if an FMU failed.
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// The setup and the settings made while it ran, as a message.
    pub fn events(&self) -> Events {
        let event = |done: &Done| Event {
            call: done.call,
            time: self.time(done.call),
            variable: self.columns[done.column].name.clone(),
            value: shown(done.kind, done.value),
            act: done.act,
        };
        Events { setup: self.setup.clone(), events: self.done.iter().map(event).collect(), calls: self.calls() }
    }

    /// The members at the end of the run, the controller first.
    pub fn members(&self) -> impl Iterator<Item = &message::Member> {
        let (controller, others) = self.setup.members.split_at(self.setup.members.len().min(1));
        controller.iter().chain(self.exchanges.last().map_or(others, |exchange| &exchange.members))
    }

    /// The connections at the end of the run.
    pub fn connections(&self) -> &[(String, String)] {
        self.exchanges.last().map_or(&self.setup.connections, |exchange| &exchange.connections)
    }

    /// The output connected to an input of the first member at the end of the run.
    pub fn source_of_own(&self, input: &str) -> Option<&str> {
        let name = &self.setup.members.first()?.name;
        self.connections().iter().find(|(_, to)| own_name(to, name) == Some(input)).map(|(from, _)| from.as_str())
    }

    /// The calls between two times, both in seconds and inclusive; by default all.
    pub fn calls_between(&self, from: Option<f64>, to: Option<f64>) -> std::ops::Range<usize> {
        let place = |time: f64| (time - self.start) / self.step;
        let first = from.map_or(0, |from| (place(from) - plan::ROUNDING).ceil().max(0.0) as usize);
        let end = to.map_or(self.calls(), |to| ((place(to) + plan::ROUNDING).floor() + 1.0).max(0.0) as usize);
        let end = end.min(self.calls());
        first.min(end)..end
    }

    /// The curves of variables, thinned out.
    ///
    /// # Errors
    /// No such variable, or fewer than 2 points requested.
    pub fn view(&self, view: &View) -> Result<Curves> {
        if view.points < 2 {
            bail!("points = {}: a curve needs at least 2", view.points);
        }
        let columns = view.variables.iter().map(|name| self.column(name)).collect::<Result<Vec<_>>>()?;
        let mut curves = self.trace.curves(&columns, self.calls_between(view.from, view.to), view.points);
        for (name, period) in view.means.iter().flatten() {
            let at = view.variables.iter().position(|variable| variable == name).context("no curve to average")?;
            let length = (period / self.step).round().max(1.0) as usize;
            curves.values[at] = self.trace.means(columns[at], &curves.calls, length);
        }
        Ok(Curves {
            times: curves.calls.into_iter().map(|call| self.time(call)).collect(),
            values: curves.values,
            units: columns.iter().map(|column| self.columns[*column].unit.clone()).collect(),
            is_exact: curves.is_exact,
        })
    }

    /// Adds the columns of the plan that are missing; returns the index in the record of each of the plan's columns.
    fn admit(&mut self, plan: &Plan) -> Vec<usize> {
        let before = self.columns.len();
        let place = |column: &Column| match self.places.get(&column.name) {
            Some(place) => *place,
            None => {
                let place = self.columns.len();
                self.places.insert(column.name.clone(), place);
                self.columns.push(column.clone());
                place
            }
        };
        let places = plan.columns.iter().map(place).collect();
        if self.columns.len() > before {
            self.trace.widen(self.columns.len() - before);
        }
        places
    }
}

impl Session {
    /// Starts a run; the current run becomes an earlier run.
    ///
    /// # Errors
    /// The setup is faulty, or an FMU rejects it. In that case, the current run remains.
    pub fn start(&mut self, home: &dyn Home, setup: Setup) -> Result<State> {
        let mut present = Present::begin(home, setup)?;
        present.record.number = self.runs;
        self.runs += 1;
        if let Some(before) = self.present.replace(present) {
            self.earlier.push_back(before.record);
            if self.earlier.len() > EARLIER {
                self.earlier.pop_front();
            }
        }
        self.state()
    }

    fn present(&mut self) -> Result<&mut Present> {
        self.present.as_mut().context("no loop is running: start one first")
    }

    /// The state of the current run. Each remark is returned only once.
    ///
    /// # Errors
    /// No run.
    pub fn state(&mut self) -> Result<State> {
        Ok(self.present()?.state())
    }

    /// A run; by default the current one.
    ///
    /// # Errors
    /// No such run, or it is no longer kept.
    pub fn record(&self, run: Option<usize>) -> Result<&Record> {
        let present = self.present.as_ref().map(|present| &present.record);
        let Some(run) = run else {
            return present.context("no loop is running: start one first");
        };
        let mut all = self.earlier.iter().chain(present);
        all.find(|record| record.number == run)
            .with_context(|| format!("no run {run}: only the current one and the {EARLIER} before it are kept"))
    }

    /// Sets variables before the next call.
    ///
    /// # Errors
    /// The run has ended; a variable is unknown, connected or fixed; or a value is invalid. In these cases, nothing is
    /// set.
    pub fn send(&mut self, values: &Values) -> Result<State> {
        self.present()?.send(values)?;
        self.state()
    }

    /// Ramps a variable linearly to a value over the given time: a new value is set before each call.
    ///
    /// # Errors
    /// As for [`Session::send`]; the variable is not a number, or the ramp takes too long.
    pub fn ramp(&mut self, variable: &str, to: f64, seconds: f64) -> Result<State> {
        self.present()?.ramp(variable, to, seconds)?;
        self.state()
    }

    /// Makes calls.
    ///
    /// # Errors
    /// Zero or too many calls requested, or the run has ended. A failing FMU is not an error: see [`State::failure`].
    pub fn run(&mut self, calls: usize) -> Result<State> {
        Session::check_calls(calls)?;
        self.present()?.run(calls)?;
        self.state()
    }

    fn check_calls(calls: usize) -> Result<()> {
        if !(1..=MOST_CALLS).contains(&calls) {
            bail!("{calls} calls: a request can make 1 to {MOST_CALLS}; send another request for more");
        }
        Ok(())
    }

    /// Replaces all members but the first, which continues.
    ///
    /// # Errors
    /// The new members are faulty; the run then continues unchanged. If one of them fails during initialization, the
    /// run ends, but the first member is kept for another replacement.
    pub fn exchange(
        &mut self,
        home: &dyn Home,
        members: Vec<message::Member>,
        connections: Vec<(String, String)>,
    ) -> Result<State> {
        self.present()?.exchange(home, members, connections)?;
        self.state()
    }

    /// Restarts with the setup of a run, and repeats its calls with the same events.
    ///
    /// # Errors
    /// No such run; as for [`Session::start`].
    pub fn same_bits(&mut self, home: &dyn Home, run: Option<usize>) -> Result<State> {
        let mut script = Script::new(self.record(run)?);
        if run.is_some() {
            // A setting made after the last call of an earlier run never took effect.
            script.events.retain(|event| event.call < script.calls);
        }
        self.play(home, script)
    }

    /// Restarts with the settings, members and connections that a run had at its end, and repeats its stimuli at the
    /// same times. The values given, by `MEMBER.VARIABLE`, override the settings.
    ///
    /// # Errors
    /// No such run; as for [`Session::start`].
    pub fn same_test(&mut self, home: &dyn Home, run: Option<usize>, values: &Values) -> Result<State> {
        let mut script = Script::new(self.record(run)?);
        script.put_settings(home, values)?;
        self.play(home, script)
    }

    /// Repeats the test of the current run with other settings, by `MEMBER.VARIABLE`. The current run is not affected,
    /// and the trial run is not added to the list.
    ///
    /// # Errors
    /// As for [`Session::same_test`]; or the run has too many calls.
    pub fn tried(&self, home: &dyn Home, values: &Values) -> Result<Session> {
        let mut script = Script::new(self.record(None)?);
        if script.calls > MOST_TRIED {
            bail!("the run has {} calls: settings can be tried only in runs of at most {MOST_TRIED}", script.calls);
        }
        script.put_settings(home, values)?;
        let mut beside = Session::default();
        beside.play(home, script)?;
        Ok(beside)
    }

    /// Repeats the calls of the current run up to and including `call`, without adding a run to the list.
    ///
    /// # Errors
    /// The run has no such call, or too many calls precede it.
    pub fn again_up_to(&self, home: &dyn Home, call: usize) -> Result<()> {
        let record = self.record(None)?;
        if call >= record.calls() {
            bail!("the run has {} calls, numbered from 0: call {call} does not exist", record.calls());
        }
        if call >= MOST_TRIED {
            bail!("call {call} cannot be shown: repeating the run up to it takes more than {MOST_TRIED} calls");
        }
        let mut script = Script { calls: call + 1, ..Script::new(record) };
        // Later events are dropped.
        script.events.retain(|event| event.call <= call);
        script.exchanges.retain(|exchange| exchange.call <= call);
        Session::default().play(home, script)?;
        Ok(())
    }

    fn play(&mut self, home: &dyn Home, script: Script) -> Result<State> {
        let Script { setup, calls, events, exchanges } = script;
        self.start(home, setup)?;
        let present = self.present()?;
        let (mut events, mut exchanges) = (events.into_iter().peekable(), exchanges.into_iter().peekable());
        loop {
            let call = present.run.steps();
            while let Some(of) = exchanges.next_if(|exchange| exchange.call <= call) {
                present.exchange(home, of.members, of.connections)?;
            }
            while let Some(event) = events.next_if(|event| event.call <= call) {
                present.act(&event)?;
            }
            if call >= calls || present.record.failure.is_some() {
                break;
            }
            present.call();
        }
        self.state()
    }

    /// The curves of a run.
    ///
    /// # Errors
    /// No such run or variable.
    pub fn view(&self, view: &View) -> Result<Curves> {
        self.record(view.run)?.view(view)
    }
}

/// The values of all variables of an unconnected member before its first call, by `MEMBER.VARIABLE`.
///
/// # Errors
/// The member's values are faulty, or the FMU rejects them.
pub fn start_values(home: &dyn Home, member: &message::Member) -> Result<Values> {
    let members = std::slice::from_ref(member);
    let begin = Begin::Later { start: 0.0, step: 1.0 };
    let wired = Wired::new(home, members, &[], system::Exchange::Sequential, begin)?;
    let run = Run::begin(&wired.plan, wired.instantiate(home, members)?, None)?;
    let values = wired.plan.columns.iter().zip(run.values(&wired.plan));
    Ok(values.map(|(column, value)| (column.name.clone(), shown(column.kind, value))).collect())
}

impl Present {
    fn begin(home: &dyn Home, setup: Setup) -> Result<Present> {
        let members = begin_at_the_plant(home, &setup.members, &setup.connections);
        let wired = Wired::new(home, &members, &setup.connections, setup.exchange, Begin::New(setup.step))?;
        let components = wired.instantiate(home, &members)?;
        let run = Run::begin(&wired.plan, components, None)?;
        let mut record = Record {
            number: 0,
            setup,
            start: wired.plan.start,
            step: wired.plan.step,
            columns: Vec::new(),
            places: HashMap::new(),
            done: Vec::new(),
            exchanges: Vec::new(),
            trace: Trace::new(0),
            failure: None,
        };
        let of_plan = record.admit(&wired.plan);
        let row = run.values(&wired.plan);
        let remarks = wired.plan.warnings.clone();
        Ok(Present { record, wired, run, of_plan, row, ramps: BTreeMap::new(), forced: BTreeMap::new(), remarks })
    }

    fn state(&mut self) -> State {
        let record = &self.record;
        let columns = self.of_plan.iter().zip(&self.wired.plan.columns);
        let is_parallel = record.setup.exchange == system::Exchange::Parallel;
        let after = is_parallel.then(|| {
            let present = self.wired.plan.columns.iter().zip(self.run.values(&self.wired.plan));
            present.map(|(of, value)| (of.name.clone(), shown(of.kind, value))).collect()
        });
        State {
            run: record.number,
            calls: record.calls(),
            time: record.time(record.calls().saturating_sub(1)),
            step: record.step,
            values: columns.map(|(place, of)| (of.name.clone(), shown(of.kind, self.row[*place]))).collect(),
            after,
            forced: self.forced.iter().map(|(column, of)| (record.columns[*column].name.clone(), of.shown())).collect(),
            failure: record.failure.clone(),
            is_met: false,
            remarks: std::mem::take(&mut self.remarks),
        }
    }

    fn is_running(&self) -> Result<()> {
        match &self.record.failure {
            Some(failure) => bail!("the run has ended ({failure}): start again, or replace the plant"),
            None => Ok(()),
        }
    }

    /// Returns an error if `more` events would exceed the limit. The remaining events of current ramps count, too.
    fn check_room(&self, more: usize) -> Result<()> {
        let coming: usize = self.ramps.values().map(|ramp| ramp.first + ramp.calls - self.run.steps()).sum();
        if self.record.done.len() + coming + more > MOST_EVENTS {
            bail!("a run can have at most {MOST_EVENTS} events: start again, or use shorter ramps");
        }
        Ok(())
    }

    fn send(&mut self, values: &Values) -> Result<()> {
        self.is_running()?;
        self.check_room(values.len())?;
        let all = values.iter().map(|(name, value)| Ok((name, self.wired.assignment(name, *value)?)));
        for (name, (member, assignment, warning)) in all.collect::<Result<Vec<_>>>()? {
            self.put(member, assignment, name)?;
            self.remarks.extend(warning);
        }
        Ok(())
    }

    /// Sets a variable before the next call, and ends its ramp, if any.
    fn put(&mut self, member: usize, assignment: Assignment, name: &str) -> Result<()> {
        let (call, column) = (self.run.steps(), self.record.column(name)?);
        self.ramps.remove(&column);
        self.note(call, column, assignment, Act::Set);
        self.run.set(member, assignment);
        Ok(())
    }

    /// Records an event. It replaces the previous event of the same variable before the same call if both are of the
    /// same kind.
    fn note(&mut self, call: usize, column: usize, assignment: Assignment, act: Act) {
        let Assignment { kind, value, .. } = assignment;
        let mut last = self.record.done.iter_mut().rev().take_while(|done| done.call == call);
        match last.find(|done| done.column == column) {
            Some(done) if done.act == act => done.value = value,
            _ => self.record.done.push(Done { call, column, kind, value, act }),
        }
    }

    fn ramp(&mut self, variable: &str, to: f64, seconds: f64) -> Result<()> {
        self.is_running()?;
        let (member, assignment, warning) = self.wired.assignment(variable, Value::Number(to))?;
        if assignment.kind == Type::Boolean {
            bail!("{variable} is Boolean: only a number can be ramped");
        }
        let calls = (seconds / self.record.step).round().max(1.0);
        if !(seconds >= 0.0 && calls <= MOST_RAMP as f64) {
            let most = MOST_RAMP as f64 * self.record.step;
            bail!("a ramp of {seconds:?} s: the allowed range is 0 to {most:?} s ({MOST_RAMP} calls)");
        }
        let calls = calls as usize;
        self.check_room(calls)?;
        let (column, first) = (self.record.column(variable)?, self.run.steps());
        let sent = self.record.done.iter().rev().take_while(|done| done.call == first);
        let sent = sent.filter(|done| done.column == column).map(|done| done.value).next();
        let from = sent.unwrap_or_else(|| self.present_value(column));
        self.ramps.insert(column, Ramp { member, assignment, first, calls, from, to });
        self.remarks.extend(warning);
        Ok(())
    }

    /// The value of a variable after the last call, by its column in the record; NaN if no current member has it.
    fn present_value(&self, column: usize) -> f64 {
        let place = self.of_plan.iter().position(|of| *of == column);
        place.map_or(f64::NAN, |place| self.run.values(&self.wired.plan)[place])
    }

    /// Sets the next value of each ramp.
    fn follow_ramps(&mut self) {
        let call = self.run.steps();
        let ramps: Vec<(usize, Ramp)> = self.ramps.iter().map(|(column, ramp)| (*column, *ramp)).collect();
        for (column, ramp) in ramps {
            let number = call - ramp.first + 1;
            let between = ramp.from + (ramp.to - ramp.from) * (number as f64 / ramp.calls as f64);
            let value = match ramp.assignment.kind {
                _ if number >= ramp.calls => ramp.to,
                Type::Integer => between.round(),
                _ => between,
            };
            let assignment = Assignment { value, ..ramp.assignment };
            self.note(call, column, assignment, Act::Set);
            self.run.set(ramp.member, assignment);
            if number >= ramp.calls {
                self.ramps.remove(&column);
            }
        }
    }

    fn run(&mut self, calls: usize) -> Result<()> {
        self.is_running()?;
        for _ in 0..calls {
            self.call();
            if self.record.failure.is_some() {
                break;
            }
        }
        Ok(())
    }

    /// Makes a call.
    fn call(&mut self) {
        self.follow_ramps();
        let failed = self.run.step(&self.wired.plan).err();
        let counts = failed.is_none() || self.run.abandon_step();
        if let Some(error) = failed {
            self.record.failure = Some(format!("{error:#}"));
            self.ramps.clear();
        }
        if counts {
            for (place, value) in self.of_plan.iter().zip(self.run.row()) {
                self.row[*place] = *value;
            }
            self.show_forced();
            self.record.trace.push(&self.row);
        }
    }

    fn exchange(
        &mut self,
        home: &dyn Home,
        members: Vec<message::Member>,
        connections: Vec<(String, String)>,
    ) -> Result<()> {
        let begun = begin_at_the_plant(home, &members, &connections);
        let Some(first) = self.record.setup.members.first() else { bail!("no controller") };
        if self.record.failure.is_some() && self.run.at() == 0 {
            bail!("{} itself has failed: start again", first.name);
        }
        let all: Vec<message::Member> = std::iter::once(first).chain(&begun).cloned().collect();
        let begin = Begin::Later { start: self.record.start, step: self.record.step };
        let wired = Wired::new(home, &all, &connections, self.record.setup.exchange, begin)?;
        let mut components = Vec::new();
        for member in &begun {
            components.push(wired.instance(home, member)?);
        }
        self.run.exchange(&wired.plan, components)?;
        self.remarks.extend(wired.plan.warnings.iter().cloned());
        self.ramps.retain(|_, ramp| ramp.member == 0);
        self.forced.retain(|_, of| of.member == 0);
        self.of_plan = self.record.admit(&wired.plan);
        self.row = vec![f64::NAN; self.record.columns.len()];
        for (place, value) in self.of_plan.iter().zip(self.run.values(&wired.plan)) {
            self.row[*place] = value;
        }
        self.wired = wired;
        self.record.failure = None;
        self.record.exchanges.push(Exchanged { call: self.run.steps(), members, connections });
        Ok(())
    }
}

/// When members start.
enum Begin {
    /// At the start of the run, with this communication step.
    New(Option<f64>),
    /// During the run.
    Later { start: f64, step: f64 },
}

impl Wired {
    /// Checks members and connections, and creates a plan that records all variables; of a foreign FMU, at most
    /// [`MOST_RECORDED`].
    fn new(
        home: &dyn Home,
        members: &[message::Member],
        connections: &[(String, String)],
        exchange: system::Exchange,
        begin: Begin,
    ) -> Result<Wired> {
        check_names(members)?;
        let descriptions = members.iter().map(|of| home.description(&of.fmu)).collect::<Result<Vec<_>>>()?;
        let tables = members.iter().map(|of| home.table(&of.fmu)).collect::<Result<Vec<_>>>()?;
        let borrowed: Vec<&Description> = descriptions.iter().map(|of| &**of).collect();
        let (start, step) = match begin {
            Begin::Later { start, step } => (start, step),
            Begin::New(step) => {
                let experiments = borrowed.iter().filter_map(|of| of.default_experiment?.start_time);
                let start = experiments.reduce(f64::min).unwrap_or(0.0);
                let own = cycle(&members[0], borrowed[0], tables[0].as_deref());
                let proposed = || own.or(borrowed[0].default_experiment.and_then(|of| of.step_size));
                let step = step.or_else(proposed);
                (start, step.with_context(|| format!("{} proposes no communication step: set one", members[0].name))?)
            }
        };
        for ((member, description), table) in members.iter().zip(&borrowed).zip(&tables) {
            if let Some(cycle) = cycle(member, description, table.as_deref())
                && step / cycle.max(0.001) > MOST_CALLS_OF_STEP
            {
                bail!(
                    "{} is called every {cycle:?} s, which is more than {MOST_CALLS_OF_STEP} times in a communication \
                     step of {step:?} s: make the step shorter",
                    member.name
                );
            }
        }
        let mut record = Vec::new();
        for ((member, description), table) in members.iter().zip(&borrowed).zip(&tables) {
            let most = if table.is_some() { usize::MAX } else { MOST_RECORDED };
            record.extend(
                recorded(description, most)
                    .map(|variable| Recorded { variable: format!("{}.{variable}", member.name), place: None }),
            );
        }
        let setting = |member: &message::Member, (name, value): (&String, &Value)| Setting {
            variable: format!("{}.{name}", member.name),
            value: *value,
            time: None,
            is_preliminary: true,
            place: None,
        };
        let system = System {
            members: members
                .iter()
                .map(|of| system::Member { name: of.name.clone(), path: format!("{}.fmu", of.fmu).into() })
                .collect(),
            settings: members.iter().flat_map(|of| of.values.iter().map(move |value| setting(of, value))).collect(),
            connections: connections
                .iter()
                .map(|(from, to)| Connection { from: from.clone(), to: to.clone(), place: None })
                .collect(),
            record,
            start: Some(start),
            stop: Some(start + step),
            step: Some(step),
            exchange,
            // In the tool, each step is a call.
            no_events: true,
            ..System::default()
        };
        let names = Names::new(&system, &borrowed)?;
        for setting in &system.settings {
            let reference = names.find(&setting.variable)?;
            fitting(tables[reference.member].as_deref(), &reference, &setting.variable, setting.value)?;
        }
        let mut plan = Plan::new(&system, &borrowed)?;
        for (member, (description, table)) in members.iter().zip(borrowed.iter().zip(&tables)) {
            let count = recorded(description, usize::MAX).count();
            if table.is_none() && count > MOST_RECORDED {
                plan.warnings.push(format!("{}: only {MOST_RECORDED} of {count} variables are recorded", member.name));
            }
        }
        Ok(Wired { system, descriptions, tables, plan })
    }

    fn instance(&self, home: &dyn Home, member: &message::Member) -> Result<Box<dyn Component>> {
        home.instantiate(&member.fmu, &member.name).with_context(|| member.name.clone())
    }

    fn instantiate(&self, home: &dyn Home, members: &[message::Member]) -> Result<Vec<Box<dyn Component>>> {
        members.iter().map(|member| self.instance(home, member)).collect()
    }

    /// The assignment that sets a variable while the loop runs, with the index of its member, and a warning if the
    /// value is outside the declared range.
    fn assignment(&self, name: &str, value: Value) -> Result<(usize, Assignment, Option<String>)> {
        let descriptions: Vec<&Description> = self.descriptions.iter().map(|of| &**of).collect();
        let names = Names::new(&self.system, &descriptions)?;
        let reference = names.find(name)?;
        let wires = plan::wires(&names, &self.system.connections)?;
        let (assignment, warning) = plan::assignment(&names, name, value, &reference, &wires)?;
        if !reference.variable.is_tunable() {
            bail!(
                "{name} cannot be changed while the loop runs, because it is a fixed parameter: restart with the new value"
            );
        }
        fitting(self.tables[reference.member].as_deref(), &reference, name, value)?;
        Ok((reference.member, assignment, warning))
    }
}

/// Checks a value and converts it to the variable's type.
///
/// # Errors
/// The value has the wrong type, is not finite, or is outside the range of the PLC type.
fn fitting(table: Option<&Table>, reference: &Reference, name: &str, value: Value) -> Result<f64> {
    let value = plan::value(reference.kind, value).with_context(|| format!("{name} cannot be set"))?;
    if !value.is_finite() {
        bail!("{name} cannot be set: {value:?} is not a finite number");
    }
    let row = table.and_then(|table| table.rows.iter().find(|row| row.name == reference.variable.name));
    if let Some(row) = row {
        to_value(value, row.kind).map_err(|range| anyhow::anyhow!("{name} cannot be set to {value:?}: {range}"))?;
    }
    Ok(value)
}

/// A value as represented in messages.
fn shown(kind: Type, value: f64) -> Value {
    match kind {
        Type::Boolean => Value::Boolean(value != 0.0),
        _ => Value::Number(value),
    }
}

/// The time between two calls of a block; `None` for a foreign FMU.
fn cycle(member: &message::Member, description: &Description, table: Option<&Table>) -> Option<f64> {
    let row = table?.rows.get(table?.cycle)?;
    match member.values.get(&row.name) {
        Some(Value::Number(cycle)) => Some(*cycle),
        _ => description.start(&row.name).or(Some(row.start())),
    }
}

/// The variables of an FMU to record, in the order of the FMU. If there are more than `most`, inputs and outputs come
/// first, and the rest is left out.
fn recorded(description: &Description, most: usize) -> impl Iterator<Item = &str> {
    let variables = || description.variables.iter().filter(|of| of.kind.is_some());
    let is_terminal = |of: &&modeldescription::Variable| matches!(of.causality, Causality::Input | Causality::Output);
    let has_room = variables().count() <= most;
    let all = variables().filter(move |_| has_room);
    let terminals = variables().filter(move |of| !has_room && is_terminal(of));
    let others = variables().filter(move |of| !has_room && !is_terminal(of));
    all.chain(terminals.chain(others).take(most)).map(|of| of.name.as_str())
}

/// Rejects too few or too many members, and member names that are empty, too long or ambiguous.
fn check_names(members: &[message::Member]) -> Result<()> {
    if members.is_empty() {
        bail!("nothing to run: a loop needs at least one FMU");
    }
    if members.len() > MOST_MEMBERS {
        bail!("{} members: a loop can have at most {MOST_MEMBERS}", members.len());
    }
    for (number, member) in members.iter().enumerate() {
        let name = &member.name;
        if name.is_empty() || name.chars().count() > LONGEST_NAME {
            bail!(
                "the name of member {} has {} characters: 1 to {LONGEST_NAME} are allowed",
                number + 1,
                name.chars().count()
            );
        }
        for other in &members[..number] {
            if *name == other.name {
                bail!("two members are named {name}: rename one");
            }
            if own_name(&other.name, name).or(own_name(name, &other.name)).is_some() {
                bail!(
                    "the members {} and {name} cannot be told apart: one name must not begin with the other followed \
                     by a dot",
                    other.name
                );
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
