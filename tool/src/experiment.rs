//! Experiments with the loop that runs, each in one request: a step of the actuator in manual mode, and a relay.
//!
//! Both begin in the same way: the manual value is that at which the actuator is now, the controller goes to manual mode, and calls are
//! made until the process value rests. At the end the actuator goes back, the plant follows, and mode and manual value are what they
//! were; the setpoint never changes. What is done is in the record as if a user had done it.

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

/// Calls that are made before anybody asks whether the process value rests.
const FIRST: usize = 40;
/// A process value rests if it moves by less than this part of how far it has moved.
const REST: f64 = 0.005;
/// The same for a run that ends by itself: what the user looks at has come to its end. It is what figures resolve of a step.
const SETTLED: f64 = 0.001;
/// What has moved little since the user has done something last also rests if it moves by less than this part of its way in the run.
const UNSEEN: f64 = 0.0001;
/// The controller has acted so many times at least in such a run, once in a period of its own pulses: a dead time is no rest.
const WATCHED: usize = 200;
/// It swings if the last third of it is wider than the band of 2 % to both sides in which a step counts as settled, of all that it has
/// moved in the run.
const BAND: f64 = 0.04;
/// So often a swing crosses its mean in two periods.
const CROSSINGS: usize = 4;
/// Of a loop without a process value so many variables are watched at most.
const MOST_VARIABLES: usize = 200;
/// A swing that has become this many times as wide still grows; by pulses, which can only be so short, it is never the same.
const GROWN: f64 = 1.01;
const GROWN_BY_PULSES: f64 = 1.25;
/// It has moved if it is this many times the noise away.
const MOVED: f64 = 8.0;
/// And this many times its smallest change.
const COUNTS: f64 = 5.0;
/// A step controller first moves its actuator by this part of the step, in the same direction.
const TAKEN_UP: f64 = 0.25;
/// The answer is recorded for so many times as long as the pulse lasts: one that takes a large part of the answer is no step.
const LONG: usize = 12;
/// The calls of a pulse period before there are pulses: longer than usual ones.
const UNKNOWN_PERIOD: usize = 100;

/// A step of the manual value.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct StepTest {
    /// By how much the manipulated value steps, in its unit; below 0 for down. Where that leads beyond one of its limits and the other
    /// direction does not, it steps in the other one.
    pub size: f64,
    /// How the model is found.
    pub method: Method,
    /// Whether the plant integrates.
    #[serde(default)]
    pub is_integrating: bool,
}

/// What a step test gives.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct StepTested {
    /// Where the run is now: after the test, with mode, manual value and setpoint from before it.
    pub state: State,
    /// From when on the plant was held, in seconds.
    pub from: f64,
    /// The last call that the model was found from, in seconds: later ones give the loop back.
    pub to: f64,
    /// When the manipulated value stepped, in seconds.
    pub step: f64,
    /// The model.
    pub identified: Identified,
}

/// A relay instead of the controller.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct RelayTest {
    /// By how much the manipulated value goes up and down, in its unit.
    pub amplitude: f64,
    /// How far the process value has to go before the relay switches; by the noise without it.
    #[serde(default)]
    pub hysteresis: Option<f64>,
}

/// What a relay test gives.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RelayTested {
    /// Where the run is now: after the test, with mode, manual value and setpoint from before it.
    pub state: State,
    /// From when on the plant was held, in seconds.
    pub from: f64,
    /// Ultimate gain and period in seconds, as the rule of Ziegler and Nichols takes them.
    pub ultimate: (f64, f64),
    /// The amplitude of the process value while the relay switches.
    pub swing: f64,
    /// How far the process value had to go before the relay switched, in its unit.
    pub hysteresis: f64,
    /// An integrator with dead time that has this ultimate gain and period: a relay tells a plant at one frequency only.
    pub model: Model,
    /// What the user should know, a sentence each.
    pub remarks: Vec<String>,
}

/// Automatic mode at rest at a setpoint, from which a step can begin.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RestAt {
    /// The setpoint, in its unit.
    pub setpoint: f64,
}

/// A run until the loop rests.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Settle {
    /// How many calls at most, one at least.
    pub calls: usize,
    /// From when on it is watched, in seconds: when the user has started it.
    pub from: f64,
}

/// What a run until the loop rests gives.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Settled {
    /// Where the run is now.
    pub state: State,
    /// Whether the loop rests.
    pub is_at_rest: bool,
    /// Whether it swings evenly instead, and would go on so. If neither, all calls were made, or the run has failed.
    pub swings: bool,
}

/// Makes calls until process value and manipulated value rest since the user has done something last, or on the whole do so where they
/// swing evenly. Of a loop whose process value is not known, such as a ramp before a drive, everything that is recorded has to rest.
///
/// # Errors
/// No call or too many; the run has ended.
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

/// The calls of a period of the controller's own pulses, in which it acts once; 1 of a controller without.
fn period_in_calls(home: &dyn Home, record: &Record) -> usize {
    let controller = record.members().next().and_then(|member| Controller::new(home, member).ok());
    controller.map_or(1, |controller| controller.period_in_calls(record.step()))
}

/// What has to rest.
struct Watched {
    /// The values of each variable, in the same calls.
    values: Vec<Vec<f64>>,
    /// The first so many of them are the ones that a loop swings in.
    swinging: usize,
}

impl Watched {
    /// Process value and manipulated value; of a loop without them everything that is recorded. Nothing if that is too much.
    fn new(home: &dyn Home, record: &Record, from: Option<f64>) -> Option<Watched> {
        if let Ok(signals) = Signals::new(home, record, from, None) {
            return Some(Watched { values: vec![signals.process_value, signals.manipulated_value], swinging: 1 });
        }
        let columns = record.columns().len();
        let calls = record.calls_between(from, None);
        let calls = calls.start.max(record.trace().exact().start)..calls.end;
        let values = |column| record.trace().column(column, calls.clone()).collect::<Vec<_>>();
        // A member that was exchanged has no values any more.
        let is_there = |values: &Vec<f64>| values.last().is_none_or(|last| !last.is_nan());
        let values: Vec<_> =
            if columns > MOST_VARIABLES { Vec::new() } else { (0..columns).map(values).filter(is_there).collect() };
        (!values.is_empty()).then_some(Watched { swinging: values.len(), values })
    }
}

/// Brings the loop to rest in automatic mode at a setpoint: from there a step of the setpoint is the one that is predicted. Manual mode
/// ends with the setpoint at the process value, so that the bumpless change has no error to swallow.
///
/// # Errors
/// The setpoint is not known or connected, the run has ended, or the loop does not come to rest.
pub fn rest_at(home: &dyn Home, session: &mut Session, request: &RestAt) -> Result<Settled> {
    let record = session.record(None)?;
    let controller = record.members().next().context("there is no controller")?.clone();
    let roles = describe(home, &controller.fmu)?.roles;
    let name = |variable: &String| format!("{}.{variable}", controller.name);
    let setpoint = roles.setpoint.as_ref().map(name);
    let setpoint =
        setpoint.with_context(|| format!("{} does not say which variable is its setpoint", controller.fmu))?;
    let send = |session: &mut Session, name: &str, value| session.send(&Values::from([(name.to_string(), value)]));
    if let (Some(switch), Some(process_value)) = (roles.manual_switch(), roles.compared_process_value()) {
        let (switch, process_value) = (name(switch), name(process_value));
        let mut values = session.state()?.values;
        if values.get(switch.as_str()) == Some(&Value::Boolean(true)) {
            // A block that was never called does not know its process value yet.
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
        "{} does not come to rest at {} from where the step is to begin: choose calmer settings or another start",
        controller.name,
        request.setpoint
    );
    Ok(settled)
}

/// Holds the plant, steps the manipulated value, waits, identifies, and gives the loop back as it was.
///
/// # Errors
/// The controller has neither a manual value nor manual pulses, the plant does not come to rest, the step does not move it, or no model
/// fits: why, and what to do.
pub fn step(home: &dyn Home, session: &mut Session, request: &StepTest) -> Result<StepTested> {
    let size = request.size;
    ensure!(size != 0.0 && size.is_finite(), "the step is {size}: it has to be a number other than 0");
    let mut bench = Bench::hold(home, session)?;
    let tested = step_held(&mut bench, request);
    let last = bench.signals(bench.from)?.times.last().copied();
    bench.release(tested.as_ref().ok().map(|(_, _, level)| *level), request.is_integrating)?;
    let (step, identified, _) = tested?;
    let from = bench.from;
    Ok(StepTested { state: session.state()?, from, to: last.unwrap_or(from), step, identified })
}

/// The step of a plant that is held: when, the model, and the process value before it.
fn step_held(bench: &mut Bench, request: &StepTest) -> Result<(f64, Identified, f64)> {
    let size = request.size;
    let size = if !bench.is_within(size)? && bench.is_within(-size)? { -size } else { size };
    if bench.has_pulses() {
        // Takes up the backlash of the actuator before its travel counts.
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
    // An analog word that has moved by a count has hardly begun to answer.
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
            bench.check_patience(waited, "the step does not move it")?;
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

/// Holds the plant, lets the manipulated value switch up and down around where it was, and measures the gain and period at which the loop
/// with a P action alone would oscillate; then gives the loop back as it was.
///
/// # Errors
/// As for [`step`]; the process value does not swing, or it has no ultimate period that calls so far apart can show.
pub fn relay(home: &dyn Home, session: &mut Session, request: &RelayTest) -> Result<RelayTested> {
    let amplitude = request.amplitude;
    ensure!(amplitude > 0.0 && amplitude.is_finite(), "the relay is {amplitude}: it has to be above 0");
    let mut bench = Bench::hold(home, session)?;
    let tested = relay::held(&mut bench, request);
    bench.release(tested.as_ref().ok().map(|_| 0.0), false)?;
    let relay::Found { gain, period, swing, hysteresis, remarks } = tested?;
    let from = bench.from;
    // At the ultimate frequency its phase is -180 degrees, of which the dead time has a half, and its gain that of the plant.
    let model =
        Model { gain: TAU / (period * gain), dead_time: period / 4.0, is_integrating: true, ..Model::default() };
    Ok(RelayTested { state: session.state()?, from, ultimate: (gain, period), swing, hysteresis, model, remarks })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Half of the way from the lowest to the highest of values.
fn half(values: &[f64]) -> f64 {
    width(values) / 2.0
}

/// The standard deviation of what changes from call to call without a trend.
fn noise(values: &[f64]) -> f64 {
    let changes: Vec<f64> = values.windows(3).map(|three| three[0] - 2.0 * three[1] + three[2]).collect();
    (changes.iter().map(|change| change * change).sum::<f64>() / (6.0 * changes.len().max(1) as f64)).sqrt()
}

/// Whether the last third of the values stays where it is, within this part of how far they have moved, as far as the noise lets one
/// see. No values are at rest.
fn is_at_rest(values: &[f64], part: f64) -> bool {
    if values.is_empty() {
        return true;
    }
    let last = &values[values.len() * 2 / 3..];
    let (first, second) = last.split_at(last.len() / 2);
    let seen = 3.0 * noise(values) / (first.len().max(1) as f64).sqrt();
    values.len() >= FIRST && (mean(second) - mean(first)).abs() <= part * width(values) + seen
}

/// Whether the last third of values that are at rest on the whole stays within what figures resolve of their way, or goes up and down
/// evenly around its mean: at a turning point it does neither. `all` are those of the run.
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

/// Whether values that are at rest on the whole swing, by more than noise and by what can be seen of `all` values of the run.
fn swings(values: &[f64], all: &[f64]) -> bool {
    let magnitude = values.iter().fold(0.0_f64, |magnitude, value| magnitude.max(value.abs()));
    let unseen = (BAND * width(all)).max(SETTLED * magnitude).max(MOVED * noise(values));
    width(&values[values.len() * 2 / 3..]) > unseen
}

/// From the lowest to the highest of values.
fn width(values: &[f64]) -> f64 {
    let (low, high) = control::extremes(values);
    high - low
}

mod bench;
mod relay;
#[cfg(test)]
mod tests;
