//! Experiments with the running loop, each in one request: an actuator step in manual mode, and a relay test.
//!
//! Both begin in the same way: the controller is switched to manual mode, the manual value is set so that the actuator
//! stays where it is, and calls are made until the process value has settled. At the end, the actuator returns to its
//! initial position, the plant follows, and mode and manual value are restored; the setpoint never changes. All actions
//! are recorded like those of a user.

use self::bench::Bench;
use crate::describe::describe;
use crate::home::Home;
use crate::message::{State, Values};
use crate::session::{MOST_CALLS, Record, Session};
use crate::signals::{self, Signals};
use anyhow::{Context, Result, ensure};
use control::identify::{self, Data, Identified, Method, Model, resolution};
use control::tune::Controller;
use run::system::Value;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The minimum number of values for a check whether they have settled.
const FIRST: usize = 40;
/// During a test, the process value counts as settled if its drift is below this fraction of its range so far.
const REST: f64 = 0.005;
/// The same fraction for a run until the loop has settled, where the visible response must be complete: the resolution
/// of a step's figures.
const SETTLED: f64 = 0.001;
/// A variable that has moved little since the user's last action has also settled if it moves by less than this
/// fraction of its range in the whole run.
const UNSEEN: f64 = 0.0001;
/// The minimum number of pulse periods (calls, if there are no pulses) before such a run can count as settled: a
/// shorter wait could mistake a dead time for a settled loop.
const WATCHED: usize = 200;
/// A run oscillates if its values vary by more than this fraction of their range in the last third: the band of ±2 %
/// within which a step counts as settled.
const BAND: f64 = 0.04;
/// The minimum number of times that an oscillation must cross its mean in the last third: two periods.
const CROSSINGS: usize = 4;
/// A loop without a process value is not watched if it records more variables than this.
const MOST_VARIABLES: usize = 200;
/// An oscillation that grows by this factor is still increasing. With pulses, a larger factor is needed: because of
/// their minimum length, the amplitude always varies.
const GROWN: f64 = 1.01;
const GROWN_BY_PULSES: f64 = 1.25;
/// A process value has moved if it differs by this many times the noise.
const MOVED: f64 = 8.0;
/// It must also differ by this many times its resolution.
const COUNTS: f64 = 5.0;
/// With pulses, the actuator is first moved by this fraction of the step in the same direction, to take up its
/// backlash.
const TAKEN_UP: f64 = 0.25;
/// The response is recorded for at least this many times the pulse length: a pulse that lasts for much of the response
/// is not a step.
const LONG: usize = 12;
/// The pulse period in calls that is assumed until it can be measured: longer than usual.
const UNKNOWN_PERIOD: usize = 100;

/// A step in the manual value.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct StepTest {
    /// The step in the manipulated value, in its unit; negative for down. If it would exceed a limit and the opposite
    /// step would not, the direction is reversed.
    pub size: f64,
    /// The method of identification.
    pub method: Method,
    /// Whether the plant is integrating.
    #[serde(default)]
    pub is_integrating: bool,
}

/// The result of a step test.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct StepTested {
    /// The state of the run after the test, with the previous mode, manual value and setpoint.
    pub state: State,
    /// When the hold of the plant began, in seconds.
    pub from: f64,
    /// The time of the last call used for identification, in seconds; later calls restore the loop.
    pub to: f64,
    /// The time of the step in the manipulated value, in seconds.
    pub step: f64,
    /// The model.
    pub identified: Identified,
}

/// A test with a relay in place of the controller.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct RelayTest {
    /// The amplitude of the manipulated value, in its unit.
    pub amplitude: f64,
    /// The deviation of the process value at which the relay switches; by default derived from the noise.
    #[serde(default)]
    pub hysteresis: Option<f64>,
}

/// The result of a relay test.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RelayTested {
    /// The state of the run after the test, with the previous mode, manual value and setpoint.
    pub state: State,
    /// When the hold of the plant began, in seconds.
    pub from: f64,
    /// Ultimate gain, and ultimate period in seconds: the inputs of the Ziegler–Nichols rule.
    pub ultimate: (f64, f64),
    /// The amplitude of the process value while the relay switches, in its unit.
    pub swing: f64,
    /// The deviation of the process value at which the relay switched, in its unit.
    pub hysteresis: f64,
    /// An integrator with dead time that has this ultimate gain and period: a relay identifies a plant at only one
    /// frequency.
    pub model: Model,
    /// Remarks for the user, a sentence each.
    pub remarks: Vec<String>,
}

/// A request to settle the loop in automatic mode at a setpoint, from which a step can begin.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RestAt {
    /// The setpoint, in its unit.
    pub setpoint: f64,
}

/// A request to run until the loop has settled.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Settle {
    /// The maximum number of calls, at least one.
    pub calls: usize,
    /// The time from which the loop is watched, in seconds: when the user started the run.
    pub from: f64,
}

/// The result of a run until the loop has settled.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Settled {
    /// The state of the run.
    pub state: State,
    /// Whether the loop has settled.
    pub is_at_rest: bool,
    /// Whether it oscillates steadily instead, and would continue to. If neither is true, all calls were made, or the
    /// run has failed.
    pub swings: bool,
}

/// Makes calls until process value and manipulated value have settled after the user's last action, or oscillate
/// steadily. In a loop without a known process value, such as a ramp before a drive, all recorded variables must have
/// settled.
///
/// # Errors
/// Zero or too many calls requested, or the run has ended.
pub fn settle(home: &dyn Home, session: &mut Session, request: &Settle) -> Result<Settled> {
    let mut left = request.calls;
    let mut watched = 0;
    let every = period_in_calls(home, session.record(None)?);
    let grown = if every > 1 { GROWN_BY_PULSES } else { GROWN };
    loop {
        let calls = left.min((watched / 10).max(FIRST));
        let state = session.run(calls)?;
        left -= calls;
        let record = session.record(None)?;
        let done = record.done().last().map_or(0.0, |done| record.time(done.call));
        let resting = Watched::new(home, record, Some(request.from.max(done))).filter(|last| {
            watched = last.values.first().map_or(0, Vec::len);
            let rests =
                |(values, all): (&Vec<f64>, &Vec<f64>)| is_at_rest(values, SETTLED) && has_settled(values, all, grown);
            watched >= WATCHED * every
                && Watched::new(home, record, None).is_some_and(|all| last.values.iter().zip(&all.values).all(rests))
        });
        if resting.is_some() || left == 0 || state.failure.is_some() {
            let resting = resting.filter(|_| state.failure.is_none());
            let all = resting.as_ref().and_then(|_| Watched::new(home, record, None));
            let swings = resting.iter().zip(&all).any(|(last, all)| {
                last.values.iter().zip(&all.values).take(last.swinging).any(|(values, all)| swings(values, all))
            });
            return Ok(Settled { is_at_rest: resting.is_some() && !swings, swings, state });
        }
    }
}

/// The number of calls in a period of the controller's own pulses; 1 without pulses.
fn period_in_calls(home: &dyn Home, record: &Record) -> usize {
    let controller = record.members().next().and_then(|member| Controller::new(home, member).ok());
    controller.map_or(1, |controller| controller.period_in_calls(record.step()))
}

/// The variables that must settle.
struct Watched {
    /// The values of each variable, all for the same calls.
    values: Vec<Vec<f64>>,
    /// The number of leading variables that are checked for oscillation.
    swinging: usize,
}

impl Watched {
    /// Process value and manipulated value; in a loop without them, all recorded variables. `None` if they are too many
    /// or have no values.
    fn new(home: &dyn Home, record: &Record, from: Option<f64>) -> Option<Watched> {
        if let Ok(signals) = Signals::new(home, record, from, None) {
            return Some(Watched { values: vec![signals.process_value, signals.manipulated_value], swinging: 1 });
        }
        let columns = record.columns().len();
        let calls = record.calls_between(from, None);
        let calls = calls.start.max(record.trace().exact().start)..calls.end;
        let values = |column| record.trace().column(column, calls.clone()).collect::<Vec<_>>();
        // The variables of a replaced member are NaN.
        let is_there = |values: &Vec<f64>| values.last().is_none_or(|last| !last.is_nan());
        let values: Vec<_> =
            if columns > MOST_VARIABLES { Vec::new() } else { (0..columns).map(values).filter(is_there).collect() };
        (!values.is_empty()).then_some(Watched { swinging: values.len(), values })
    }
}

/// Settles the loop in automatic mode at a setpoint, so that a setpoint step from there is comparable to
/// the predicted one. Manual mode ends with the setpoint at the process value, so that the bumpless transfer starts
/// without an error.
///
/// # Errors
/// The setpoint is unknown or connected, the run has ended, or the loop does not settle.
pub fn rest_at(home: &dyn Home, session: &mut Session, request: &RestAt) -> Result<Settled> {
    let record = session.record(None)?;
    let controller = record.members().next().context("no controller")?.clone();
    let roles = describe(home, &controller.fmu)?.roles;
    let name = |variable: &String| format!("{}.{variable}", controller.name);
    let setpoint = roles.setpoint.as_ref().map(name);
    let setpoint =
        setpoint.with_context(|| format!("{} does not specify which variable is its setpoint", controller.fmu))?;
    let send = |session: &mut Session, name: &str, value| session.send(&Values::from([(name.to_string(), value)]));
    if let (Some(switch), Some(process_value)) = (roles.manual_switch(), roles.compared_process_value()) {
        let (switch, process_value) = (name(switch), name(process_value));
        let mut values = session.state()?.values;
        if values.get(switch.as_str()) == Some(&Value::Boolean(true)) {
            // A block that has not been called yet has no process value.
            if session.record(None)?.calls() == 0 {
                values = session.run(1)?.values;
            }
            send(session, &setpoint, values[process_value.as_str()])?;
            session.run(1)?;
            send(session, &switch, Value::Boolean(false))?;
        }
    }
    send(session, &setpoint, Value::Number(request.setpoint))?;
    let from = session.state()?.time;
    let settled = settle(home, session, &Settle { calls: MOST_CALLS, from })?;
    ensure!(
        settled.is_at_rest || settled.swings,
        "{} does not settle at {}, where the step should begin: choose less aggressive settings or another start",
        controller.name,
        request.setpoint
    );
    Ok(settled)
}

/// Holds the plant, steps the manipulated value, waits, identifies, and restores the loop.
///
/// # Errors
/// The controller has neither a manual value nor manual pulses, the plant does not settle or does not respond to the
/// step, or no model fits; the message gives the reason and the remedy.
pub fn step(home: &dyn Home, session: &mut Session, request: &StepTest) -> Result<StepTested> {
    let size = request.size;
    ensure!(size != 0.0 && size.is_finite(), "the step size is {size}: it must be a nonzero number");
    let mut bench = Bench::hold(home, session)?;
    let tested = step_held(&mut bench, request);
    let last = bench.signals(bench.from)?.times.last().copied();
    bench.release(tested.as_ref().ok().map(|(_, _, level)| *level), request.is_integrating)?;
    let (step, identified, _) = tested?;
    let from = bench.from;
    Ok(StepTested { state: session.state()?, from, to: last.unwrap_or(from), step, identified })
}

/// Steps a held plant: returns the time of the step, the model, and the process value before the step.
fn step_held(bench: &mut Bench, request: &StepTest) -> Result<(f64, Identified, f64)> {
    let size = request.size;
    let size = if !bench.is_within(size)? && bench.is_within(-size)? { -size } else { size };
    if bench.has_pulses() {
        // Take up the actuator's backlash before its travel counts.
        bench.put(TAKEN_UP * size)?;
    }
    if request.is_integrating {
        bench.run(FIRST)?;
    } else {
        bench.settle(REST, |_| true)?;
    }
    let before = bench.sampled(bench.from)?;
    let before = &before[before.len() * 2 / 3..];
    let (level, noise) = (mean(before), noise(before));
    let step = bench.next_time()?;
    let calls = bench.put(bench.away()? + size)?;
    // A change by a single count of an analog word does not show yet that the plant has responded.
    let has_moved = |values: &[f64]| {
        if values.len() < LONG * calls {
            return false;
        }
        let least = (MOVED * noise).max(COUNTS * resolution(values));
        (mean(&values[values.len() * 2 / 3..]) - level).abs() > least + 1e-9
    };
    if request.is_integrating {
        let mut waited = 0;
        while !bench.process_value_from(step)?.last().is_some_and(|last| (last - level).abs() > 5.0 * MOVED * noise) {
            bench.run(FIRST)?;
            waited += FIRST;
            bench.check_patience(waited, "has not responded to the step: choose a larger step")?;
        }
        bench.run(waited.max(FIRST).max(LONG * calls) * 2)?;
    } else {
        bench.settle(REST, has_moved)?;
    }
    let data = Data::Run { run: None, from: Some(bench.from), to: None };
    let of = identify::IdentifyRequest { data, method: request.method, is_integrating: request.is_integrating };
    let identified = signals::identify(bench.home, bench.session, &of)?;
    Ok((step, identified, level))
}

/// Holds the plant, switches the manipulated value up and down around its previous value, and measures the gain and
/// period at which the loop with a P action alone would oscillate; then restores the loop.
///
/// # Errors
/// As for [`step`]; the process value does not oscillate, or its ultimate period is too short for the interval between
/// calls.
pub fn relay(home: &dyn Home, session: &mut Session, request: &RelayTest) -> Result<RelayTested> {
    let amplitude = request.amplitude;
    ensure!(amplitude > 0.0 && amplitude.is_finite(), "the relay amplitude is {amplitude}: it must be above 0");
    let mut bench = Bench::hold(home, session)?;
    let tested = relay::held(&mut bench, request);
    bench.release(tested.as_ref().ok().map(|_| 0.0), false)?;
    let relay::Found { gain, period, swing, hysteresis, remarks } = tested?;
    let from = bench.from;
    // At the ultimate frequency, the model's phase is -180 degrees, half of which is due to the dead time, and its gain
    // is that of the plant.
    let model =
        Model { gain: TAU / (period * gain), dead_time: period / 4.0, is_integrating: true, ..Model::default() };
    Ok(RelayTested { state: session.state()?, from, ultimate: (gain, period), swing, hysteresis, model, remarks })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Half the range of values.
fn half(values: &[f64]) -> f64 {
    width(values) / 2.0
}

/// The standard deviation of the noise in the values, estimated from their second differences, in which a trend
/// cancels.
fn noise(values: &[f64]) -> f64 {
    let changes: Vec<f64> = values.windows(3).map(|three| three[0] - 2.0 * three[1] + three[2]).collect();
    (changes.iter().map(|change| change * change).sum::<f64>() / (6.0 * changes.len().max(1) as f64)).sqrt()
}

/// Whether the mean is the same in both halves of the values' last third, within the fraction `part` of their range
/// plus noise. An empty list has settled.
fn is_at_rest(values: &[f64], part: f64) -> bool {
    if values.is_empty() {
        return true;
    }
    let last = &values[values.len() * 2 / 3..];
    let (first, second) = last.split_at(last.len() / 2);
    let seen = 3.0 * noise(values) / (first.len().max(1) as f64).sqrt();
    values.len() >= FIRST && (mean(second) - mean(first)).abs() <= part * width(values) + seen
}

/// Whether the last third of values that pass [`is_at_rest`] stays within the resolution of the figures, or oscillates
/// evenly around its mean. Values at a turning point do neither. `all` holds the values of the whole run.
fn has_settled(values: &[f64], all: &[f64], grown: f64) -> bool {
    let last = &values[values.len() * 2 / 3..];
    let mean = mean(last);
    let crossings = last.windows(2).filter(|pair| (pair[0] < mean) != (pair[1] < mean)).count();
    let (first, second) = last.split_at(last.len() / 2);
    let (earlier, later) = (width(first), width(second));
    let is_even = crossings >= CROSSINGS && later > earlier / 2.0 && later < grown * earlier;
    let unseen = (SETTLED * width(values)).max(UNSEEN * width(all)).max(MOVED * noise(values));
    values.is_empty() || is_even || width(last) <= unseen
}

/// Whether values that pass [`has_settled`] oscillate by more than the noise and by a visible fraction of the range of
/// `all`, the values of the whole run.
fn swings(values: &[f64], all: &[f64]) -> bool {
    let magnitude = values.iter().fold(0.0_f64, |magnitude, value| magnitude.max(value.abs()));
    let unseen = (BAND * width(all)).max(SETTLED * magnitude).max(MOVED * noise(values));
    width(&values[values.len() * 2 / 3..]) > unseen
}

/// The range of values.
fn width(values: &[f64]) -> f64 {
    let (low, high) = control::extremes(values);
    high - low
}

mod bench;
mod relay;
#[cfg(test)]
mod tests;
