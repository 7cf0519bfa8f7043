//! The events in a run of a loop: setpoint steps and disturbances. Each event covers the part of the run up to
//! the next one.

use super::{BAND, Signals, duration};
use run::dialog::Roles;
use run::fmus::number_of;
use run::system::{Connection, Setting, own_name};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::ops::Range;

/// The event that begins a part of a run.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Cause {
    /// The start of the run while the process value is far from the setpoint.
    Start,
    /// A setpoint change. One made in manual mode counts when automatic mode begins.
    Setpoint,
    /// The change to automatic mode while the process value is far from the setpoint.
    Automatic,
    /// A disturbance of the loop.
    Disturbance,
}

/// A setpoint step or a disturbance.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Event {
    pub cause: Cause,
    /// The calls from the event up to the next setpoint change, disturbance or mode change.
    pub calls: Range<usize>,
}

impl Event {
    pub(super) fn is_step(&self) -> bool {
        self.cause != Cause::Disturbance
    }
}

/// The wiring of a loop, which determines which variables disturb it. All variables are named `MEMBER.VARIABLE`.
#[derive(Clone, Debug)]
pub struct Wiring<'a> {
    /// The controller's setpoint.
    pub setpoint: String,
    /// The names of the members, the controller first.
    pub members: Vec<&'a str>,
    /// The roles of the members' variables, where known.
    pub roles: Vec<Option<Roles>>,
    /// The connections from an output to an input.
    pub connections: Vec<(&'a str, &'a str)>,
}

/// A value set while a loop runs.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Set {
    /// When it is set, in seconds.
    pub time: f64,
    /// The variable, as `MEMBER.VARIABLE`.
    pub variable: String,
    /// The value; true is 1. `None` if the member was replaced by another one.
    pub value: Option<f64>,
    /// The previous value, if it is known.
    pub before: Option<f64>,
}

impl Set {
    /// Returns the timed settings of a system, in chronological order.
    pub fn of_settings(settings: &[Setting]) -> Vec<Set> {
        let mut timed: Vec<(f64, &Setting)> = settings.iter().filter_map(|of| Some((of.time?, of))).collect();
        timed.sort_by(|one, other| one.0.total_cmp(&other.0));
        let at_start = settings.iter().filter(|of| of.time.is_none());
        let mut values: HashMap<String, f64> = at_start.map(|of| (of.variable.clone(), number_of(of.value))).collect();
        let set = |(time, of): (f64, &Setting)| {
            let (variable, value) = (of.variable.clone(), number_of(of.value));
            let before = values.insert(variable.clone(), value);
            Set { time, variable, value: Some(value), before }
        };
        timed.into_iter().map(set).collect()
    }
}

impl<'a> Wiring<'a> {
    /// Returns the wiring of a system whose controller is its first member; `None` without a setpoint.
    pub fn new(members: Vec<&'a str>, roles: Vec<Option<Roles>>, connections: &'a [Connection]) -> Option<Wiring<'a>> {
        let setpoint = roles.first()?.as_ref()?.setpoint.as_ref()?;
        let connections = connections.iter().map(|of| (of.from.as_str(), of.to.as_str())).collect();
        Some(Wiring { setpoint: format!("{}.{setpoint}", members.first()?), members, roles, connections })
    }

    /// Returns the index of the member that has a variable, and the variable's own name.
    fn owner<'b>(&self, variable: &'b str) -> Option<(usize, &'b str)> {
        let own = |(at, member): (usize, &&str)| Some((at, own_name(variable, member)?));
        self.members.iter().enumerate().filter_map(own).min_by_key(|(_, name)| name.len())
    }

    /// Whether setting a variable disturbs the loop. A variable of the controller does so if the controller declares it
    /// as a disturbance; a variable of another member, unless that member provides the setpoint.
    pub fn is_disturbance(&self, variable: &str) -> bool {
        let Some((member, name)) = self.owner(variable) else { return false };
        let is_of = |of: &str| self.owner(of).is_some_and(|(owner, _)| owner == member);
        match member {
            0 => self
                .roles
                .first()
                .and_then(Option::as_ref)
                .is_some_and(|roles| roles.disturbances.iter().any(|of| of == name)),
            _ => {
                !is_of(&self.setpoint) && !self.connections.iter().any(|(from, to)| *to == self.setpoint && is_of(from))
            }
        }
    }

    /// Returns those of the settings that disturb the loop; setting a variable to its current value is not a
    /// disturbance.
    pub fn disturbances(&self, set: impl IntoIterator<Item = Set>) -> Vec<Set> {
        let is_change =
            |set: &Set| (set.value.is_none() || set.before != set.value) && self.is_disturbance(&set.variable);
        set.into_iter().filter(is_change).collect()
    }

    /// Returns the unit of the manipulated value: its own or, if it has none, that of an input connected to it. `unit`
    /// looks up the unit of a variable.
    pub fn unit_of_manipulated_value(&self, unit: impl Fn(&str) -> Option<String>) -> Option<String> {
        let name = self.roles.first()?.as_ref()?.manipulated_value.as_ref()?;
        let own = format!("{}.{name}", self.members[0]);
        let inputs = self.connections.iter().filter(|(from, _)| *from == own).map(|(_, to)| *to);
        [own.as_str()].into_iter().chain(inputs).find_map(&unit)
    }

    /// Returns the first unit found among those of the process value, the setpoint, the output connected to the process
    /// value, and the plants' process values. `unit` looks up the unit of a variable.
    pub fn unit_of_process_value(&self, unit: impl Fn(&str) -> Option<String>) -> Option<String> {
        let roles = self.roles.first()?.as_ref()?;
        let full = |member: &str, name: &String| format!("{member}.{name}");
        let own = roles.compared_process_value().map(|name| full(self.members[0], name));
        let input = roles.process_value.as_ref().map(|name| full(self.members[0], name));
        let source = self.connections.iter().find(|(_, to)| Some(*to) == input.as_deref());
        // In a loop without a compared process value, such as a ramp generator with a drive, the two may have different
        // units.
        let plants = self.members.iter().zip(&self.roles).skip(1).filter(|_| roles.compared_process_value().is_some());
        let given = plants.filter_map(|(member, roles)| Some(full(member, roles.as_ref()?.process_value.as_ref()?)));
        let named = own.into_iter().chain([self.setpoint.clone()]).chain(source.map(|(from, _)| from.to_string()));
        named.chain(given).filter_map(|name| unit(&name)).find(|unit| unit != "1")
    }
}

/// Returns the first call that uses a value: the one before which it is set.
fn call_of(times: &[f64], set: &Set) -> usize {
    // The times of calls have rounding errors.
    let slack = 1e-6 * duration(times, 0);
    times.partition_point(|of| *of < set.time - slack)
}

/// Returns the calls before which values are set, in ascending order.
fn calls_of(times: &[f64], set: &[Set]) -> Vec<usize> {
    let mut calls: Vec<usize> = set.iter().map(|set| call_of(times, set)).collect();
    calls.sort_unstable();
    calls
}

impl Signals<'_> {
    /// Returns the steps and disturbances before the call `end`, in chronological order.
    pub(super) fn events(&self, end: usize) -> Vec<Event> {
        let (setpoint, value) = (&self.setpoint[..end], &self.process_value[..end]);
        let is_manual = |call: usize| self.manual.get(call).copied().unwrap_or(false);
        let disturbed = calls_of(self.times, self.disturbances);
        let is_disturbed = |call: usize| disturbed.binary_search(&call).is_ok();
        let first = self.first_call(end);
        let begins = first < end && !is_manual(first) && !self.is_cut;
        let mut begun = begins.then_some((Cause::Start, first));
        let mut is_pending = false;
        let mut events = Vec::new();
        let mut close = |begun: &mut Option<(Cause, usize)>, call: usize| {
            let event = begun.take().map(|(cause, start)| Event { cause, calls: start..call });
            events.extend(event.filter(|event| {
                matches!(event.cause, Cause::Setpoint | Cause::Disturbance)
                    || is_far(setpoint, value, first, &event.calls)
            }));
        };
        for call in first + 1..end {
            let has_changed = setpoint[call] != setpoint[call - 1];
            let is_ramp = call > first + 1 && setpoint[call - 1] != setpoint[call - 2];
            let (is, was) = (is_manual(call), is_manual(call - 1));
            is_pending |= has_changed && (is || was);
            let cause = match (was, is) {
                (_, true) => None,
                (true, false) if std::mem::take(&mut is_pending) => Some(Cause::Setpoint),
                (true, false) => Some(Cause::Automatic),
                _ if has_changed && !is_ramp => Some(Cause::Setpoint),
                // A disturbance that changes in consecutive calls begins in the first of them.
                _ if is_disturbed(call) && !is_disturbed(call - 1) => Some(Cause::Disturbance),
                _ => continue,
            };
            close(&mut begun, call);
            begun = cause.map(|cause| (cause, call));
        }
        close(&mut begun, end);
        events
    }

    /// Returns the disturbances set in these calls, each variable with its last value.
    pub(super) fn disturbances_in(&self, calls: &Range<usize>) -> Vec<Set> {
        let mut by: Vec<Set> = Vec::new();
        for set in self.disturbances {
            if calls.contains(&call_of(self.times, set)) {
                by.retain(|other| other.variable != set.variable);
                by.push(set.clone());
            }
        }
        by
    }

    /// Returns the first call with a process value computed by the plant. The output of a block is 0 before its first
    /// call; such a 0 is recognized because the jump away from it exceeds the movement that follows.
    pub(super) fn first_call(&self, end: usize) -> usize {
        let values = &self.process_value[..end];
        let given = values.iter().position(|value| *value != 0.0).filter(|_| !self.is_cut);
        let Some(given) = given else { return self.first.min(end) };
        let is_quiet = self.setpoint[..=given].windows(2).all(|pair| pair[0] == pair[1])
            && calls_of(self.times, self.disturbances).first().is_none_or(|call| *call == 0 || *call > given);
        let next = values[given..].windows(2).map(|pair| (pair[1] - pair[0]).abs()).find(|of| *of > 0.0).unwrap_or(0.0);
        let is_jump = given > 0 && is_quiet && values[given].abs() > JUMP * next;
        if is_jump { given } else { self.first.min(end) }
    }
}

/// The minimum ratio of the jump away from the 0 before a block's first call to the first movement after it.
const JUMP: f64 = 3.0;

/// Whether the process value begins far from the setpoint: at a distance of at least half of its span in these calls,
/// and at least [`BAND`] times its span in the whole run. Otherwise, the loop was in steady state.
fn is_far(setpoint: &[f64], value: &[f64], first: usize, calls: &Range<usize>) -> bool {
    let width = |values: &[f64]| {
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), of| (low.min(*of), high.max(*of)));
        high - low
    };
    let distance = (setpoint[calls.start] - value[calls.start]).abs();
    distance >= width(&value[calls.clone()]) / 2.0 && distance >= BAND * width(&value[first..])
}
