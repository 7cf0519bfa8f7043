//! Experiments with the loop that runs, each in one request: a step of the manual value, and a relay.
//!
//! Both begin in the same way: the manual value is that at which the actuator is now, the controller goes to manual mode, and calls are
//! made until the process value rests. At the end the setpoint is where the process value is, so that the controller holds it there
//! when it goes to automatic mode. What is done is in the record as if a user had done it.

use crate::describe::describe;
use crate::home::Home;
use crate::message::{State, Values};
use crate::session::{MOST_CALLS, Session};
use crate::signals::{self, Signals};
use anyhow::{Context, Result, bail, ensure};
use control::identify::{self, Data, Identified, Method, Model};
use run::fmus::number_of;
use run::system::Value;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Calls that are made before anybody asks whether the process value rests.
const FIRST: usize = 40;
/// A process value rests if it moves by less than this part of how far it has moved.
const REST: f64 = 0.005;
/// The same for a run that ends by itself: what the user looks at has come to its end. It is what figures resolve of a step.
const SETTLED: f64 = 0.001;
/// Such a run has so many calls at least: a dead time is no rest.
const WATCHED: usize = 200;
/// It swings if the last third of it is wider than the band of 2 % to both sides in which a step counts as settled, of all that it has
/// moved in the run.
const BAND: f64 = 0.04;
/// So often a swing crosses its mean in two periods.
const CROSSINGS: usize = 4;
/// It has moved if it is this many times the noise away.
const MOVED: f64 = 8.0;
/// How many periods of a relay are waited for; the first of them do not count.
const PERIODS: usize = 5;
/// How many of them count.
const COUNTED: usize = 2;

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
    /// Where the run is now: in manual mode, behind the step.
    pub state: State,
    /// From when on the plant was held, in seconds.
    pub from: f64,
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
    /// Where the run is now: in manual mode, at the manipulated value from before.
    pub state: State,
    /// From when on the plant was held, in seconds.
    pub from: f64,
    /// Ultimate gain and period in seconds, as the rule of Ziegler and Nichols takes them.
    pub ultimate: (f64, f64),
    /// The amplitude of the process value.
    pub swing: f64,
    /// An integrator with dead time that has this ultimate gain and period: a relay tells a plant at one frequency only.
    pub model: Model,
    /// What the user should know, a sentence each.
    pub remarks: Vec<String>,
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
/// swing evenly. A loop whose process value is not known never rests.
///
/// # Errors
/// No call or too many; the run has ended.
pub fn settle(home: &dyn Home, session: &mut Session, request: &Settle) -> Result<Settled> {
    let mut left = request.calls;
    let mut watched = 0;
    loop {
        let calls = left.min((watched / 10).max(FIRST));
        let state = session.run(calls)?;
        left -= calls;
        let record = session.record(None)?;
        let done = record.done().last().map_or(0.0, |done| record.time(done.call));
        let signals = |from| Signals::of(home, record, from, None);
        let resting = signals(Some(request.from.max(done))).ok().filter(|last| {
            watched = last.times.len();
            let rests = |values: &[f64], all: &[f64]| is_at_rest(values, SETTLED) && has_settled(values, all);
            watched >= WATCHED
                && signals(None).is_ok_and(|all| {
                    rests(&last.process_value, &all.process_value)
                        && rests(&last.manipulated_value, &all.manipulated_value)
                })
        });
        if resting.is_some() || left == 0 || state.failure.is_some() {
            let resting = resting.filter(|_| state.failure.is_none());
            let swings = match &resting {
                Some(watched) => swings(&watched.process_value, &signals(None)?.process_value),
                None => false,
            };
            return Ok(Settled { is_at_rest: resting.is_some() && !swings, swings, state });
        }
    }
}

/// Holds the plant, steps the manipulated value, waits, and identifies.
///
/// # Errors
/// The controller has no manual value, the plant does not come to rest, the step does not move it, or no model fits: why, and what to do.
pub fn step(home: &dyn Home, session: &mut Session, request: &StepTest) -> Result<StepTested> {
    let size = request.size;
    ensure!(size != 0.0 && size.is_finite(), "the step is {size}: it has to be a number other than 0");
    let mut bench = Bench::hold(home, session)?;
    if request.is_integrating {
        bench.run(FIRST)?;
    } else {
        bench.settle(|_| true)?;
    }
    let before = bench.process_value()?;
    let (level, noise) = (mean(&before[before.len() * 2 / 3..]), noise(&before));
    let step = bench.next_time()?;
    let size = if !bench.is_within(size)? && bench.is_within(-size)? { -size } else { size };
    bench.put(bench.manual + size)?;
    let has_moved = |values: &[f64]| (mean(&values[values.len() * 2 / 3..]) - level).abs() > MOVED * noise + 1e-9;
    if request.is_integrating {
        let mut waited = 0;
        while !bench.process_value_from(step)?.last().is_some_and(|last| (last - level).abs() > 5.0 * MOVED * noise) {
            bench.run(FIRST)?;
            waited += FIRST;
            bench.check_patience(waited, "the step does not move it")?;
        }
        bench.run(waited.max(FIRST) * 2)?;
    } else {
        bench.settle(has_moved)?;
    }
    let data = Data::Run { run: None, from: Some(bench.from), to: None };
    let of = identify::Request { data, method: request.method, is_integrating: request.is_integrating };
    let from = bench.from;
    let identified = signals::identify(home, bench.session, &of)?;
    bench.follow()?;
    Ok(StepTested { state: session.state()?, from, step, identified })
}

/// Holds the plant, lets the manipulated value switch up and down around where it was, and measures how the process value swings.
///
/// # Errors
/// As for [`step`]; the process value does not swing.
pub fn relay(home: &dyn Home, session: &mut Session, request: &RelayTest) -> Result<RelayTested> {
    let amplitude = request.amplitude;
    ensure!(amplitude > 0.0 && amplitude.is_finite(), "the relay is {amplitude}: it has to be above 0");
    let mut bench = Bench::hold(home, session)?;
    bench.settle(|_| true)?;
    let before = bench.process_value()?;
    let level = mean(&before[before.len() * 2 / 3..]);
    for way in [amplitude, -amplitude] {
        ensure!(
            bench.is_within(way)?,
            "the manipulated value is {}, and {amplitude} more or less are beyond its limits: choose a smaller relay, or move it \
             to the middle first",
            bench.output
        );
    }
    let hysteresis = request.hysteresis.unwrap_or(4.0 * noise(&before));
    ensure!(hysteresis >= 0.0 && hysteresis.is_finite(), "the hysteresis is {hysteresis}: it has to be 0 or more");
    let mut is_up = true;
    bench.put(bench.manual + amplitude)?;
    // The sign of the plant's gain: which way the first step moves it.
    let (mut sign, mut rises, mut waited) = (0.0, Vec::new(), 0);
    while rises.len() <= PERIODS {
        bench.run(1)?;
        waited += 1;
        bench.check_patience(waited, "the process value does not swing: choose a larger amplitude")?;
        let off = bench.value(&bench.process_value_name.clone())? - level;
        if sign == 0.0 && off.abs() > hysteresis + 1e-9 {
            sign = off.signum();
        }
        let goes = match sign * off {
            off if off > hysteresis && is_up => false,
            off if off < -hysteresis && !is_up => true,
            _ => continue,
        };
        if goes {
            rises.push(bench.next_time()?);
        }
        is_up = goes;
        bench.put(bench.manual + if goes { amplitude } else { -amplitude })?;
    }
    bench.put(bench.manual)?;
    let from = rises[rises.len() - 1 - COUNTED];
    let periods: Vec<f64> = rises.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let counted = &periods[periods.len() - COUNTED..];
    let period = mean(counted);
    let half = |values: &[f64]| {
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        (high - low) / 2.0
    };
    let recorded = bench.signals(from)?;
    let (swing, moved) = (half(&recorded.process_value), half(&recorded.manipulated_value));
    let gain = identify::ultimate_gain(moved, swing, hysteresis)? * sign;
    let mut remarks = Vec::new();
    if half(counted) > 0.05 * period {
        remarks.push(format!("The periods differ, {:?} s: the plant drifts or the noise is strong.", counted));
    }
    if moved < 0.99 * amplitude {
        remarks.push(format!("The manipulated value moved by {moved} only: it is at a limit."));
    }
    let from = bench.from;
    bench.follow()?;
    // At the ultimate frequency its phase is -180 degrees, of which the dead time has a half, and its gain that of the plant.
    let model =
        Model { gain: TAU / (period * gain), dead_time: period / 4.0, is_integrating: true, ..Model::default() };
    Ok(RelayTested { state: session.state()?, from, ultimate: (gain, period), swing, model, remarks })
}

/// A loop in manual mode.
struct Bench<'a> {
    home: &'a dyn Home,
    session: &'a mut Session,
    /// `MEMBER.VARIABLE` of the manual value.
    manual_name: String,
    process_value_name: String,
    /// `MEMBER.VARIABLE` of the setpoint, if it can be set.
    setpoint_name: Option<String>,
    /// `MEMBER.VARIABLE` of the limits of the manipulated value, high and low.
    limits: Option<(String, String)>,
    /// Where the actuator was.
    output: f64,
    /// The manual value at which it is there.
    manual: f64,
    /// From when on it is held, in seconds.
    from: f64,
}

impl<'a> Bench<'a> {
    /// Goes to manual mode without moving the actuator.
    fn hold(home: &'a dyn Home, session: &'a mut Session) -> Result<Bench<'a>> {
        let record = session.record(None)?;
        let controller = record.members().next().context("there is no controller")?.clone();
        ensure!(record.members().nth(1).is_some(), "nothing answers {}: connect a plant first", controller.name);
        let roles = describe(home, &controller.fmu)?.roles;
        let fmu = &controller.fmu;
        let (Some((switch, manual)), Some(output)) = (&roles.manual, &roles.manipulated_value) else {
            bail!(
                "{fmu} has no manual value that steps its output: move the actuator by hand and identify from the run"
            );
        };
        let process_value = roles
            .compared_process_value()
            .with_context(|| format!("{fmu} does not say which of its variables is its process value"))?;
        let name = |variable: &String| format!("{}.{variable}", controller.name);
        let is_free = |setpoint: &String| record.connections().iter().all(|(_, to)| to != setpoint);
        let setpoint_name = roles.setpoint.as_ref().map(name).filter(is_free);
        let mut bench = Bench {
            home,
            session,
            setpoint_name,
            manual_name: name(manual),
            process_value_name: name(process_value),
            limits: roles.limits.as_ref().map(|(high, low)| (name(high), name(low))),
            output: 0.0,
            manual: 0.0,
            from: 0.0,
        };
        let record = bench.session.record(None)?;
        // What was set since the last call, such as the manual value, counts.
        if record.calls() == 0 || record.done().last().is_some_and(|done| done.call == record.calls()) {
            bench.run(1)?;
        }
        let (switch, output) = (name(switch), name(output));
        let target = bench.value(&output)?;
        bench.from = bench.next_time()?;
        bench.session.send(&Values::from([(switch, Value::Boolean(true))]))?;
        // What the block does to the manual value is a straight line: a factor and an offset.
        let mut tried: Option<(f64, f64)> = None;
        (bench.output, bench.manual) = (target, target);
        for _ in 0..3 {
            bench.put(bench.manual)?;
            bench.run(1)?;
            let now = bench.value(&output)?;
            let off = target - now;
            if off.abs() <= 1e-6 * target.abs().max(1.0) {
                break;
            }
            let slope = match tried {
                Some((manual, before)) if bench.manual != manual && now != before => {
                    (now - before) / (bench.manual - manual)
                }
                _ => 1.0,
            };
            tried = Some((bench.manual, now));
            bench.manual += off / slope;
        }
        Ok(bench)
    }

    /// Whether the manipulated value is within its limits if it moves by so much.
    fn is_within(&mut self, size: f64) -> Result<bool> {
        let Some((high, low)) = self.limits.clone() else { return Ok(true) };
        Ok((self.value(&low)?..=self.value(&high)?).contains(&(self.output + size)))
    }

    fn put(&mut self, value: f64) -> Result<()> {
        self.session.send(&Values::from([(self.manual_name.clone(), Value::Number(value))]))?;
        Ok(())
    }

    /// Sets the setpoint to where the process value is. In manual mode that moves nothing, and from the next call on the P action starts
    /// from an error of 0.
    fn follow(&mut self) -> Result<()> {
        let Some(setpoint) = self.setpoint_name.clone() else { return Ok(()) };
        let value = self.value(&self.process_value_name.clone())?;
        self.session.send(&Values::from([(setpoint, Value::Number(value))]))?;
        self.run(1)
    }

    fn run(&mut self, calls: usize) -> Result<()> {
        match self.session.run(calls.min(MOST_CALLS))?.failure {
            Some(failure) => bail!("the run has ended ({failure}): start again"),
            None => Ok(()),
        }
    }

    /// The value of a variable after the last call.
    fn value(&mut self, name: &str) -> Result<f64> {
        let state = self.session.state()?;
        state.values.get(name).copied().map(number_of).with_context(|| format!("{name} is not recorded"))
    }

    /// When the next call is, in seconds.
    fn next_time(&self) -> Result<f64> {
        let record = self.session.record(None)?;
        Ok(record.time(record.calls()))
    }

    fn signals(&self, from: f64) -> Result<Signals> {
        Signals::of(self.home, self.session.record(None)?, Some(from), None)
    }

    /// The process value since the plant is held.
    fn process_value(&self) -> Result<Vec<f64>> {
        self.process_value_from(self.from)
    }

    fn process_value_from(&self, from: f64) -> Result<Vec<f64>> {
        Ok(self.signals(from)?.process_value)
    }

    /// Makes calls until the process value rests, and has done what `is_done` asks for.
    fn settle(&mut self, is_done: impl Fn(&[f64]) -> bool) -> Result<()> {
        let from = self.next_time()?;
        let mut calls = FIRST;
        let mut made = 0;
        loop {
            self.run(calls)?;
            made += calls;
            let values = self.process_value_from(from)?;
            if is_done(&values) && is_at_rest(&values, REST) {
                return Ok(());
            }
            self.check_patience(made, "it does not come to rest, or the step does not move it: choose a larger step")?;
            calls = (made / 10).max(FIRST);
        }
    }

    fn check_patience(&self, calls: usize, what: &str) -> Result<()> {
        if calls > MOST_CALLS / 2 {
            let seconds = calls as f64 * self.session.record(None)?.step();
            bail!(
                "{} after {seconds:?} s: {what}; a plant that integrates has to be named so",
                self.process_value_name
            );
        }
        Ok(())
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
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

/// Whether the last third of values that are at rest on the whole stays within what figures resolve of `all` values of the run, or goes up
/// and down evenly around its mean: at a turning point it does neither.
fn has_settled(values: &[f64], all: &[f64]) -> bool {
    let last = &values[values.len() * 2 / 3..];
    let mean = mean(last);
    let crossings = last.windows(2).filter(|pair| (pair[0] < mean) != (pair[1] < mean)).count();
    let (first, second) = last.split_at(last.len() / 2);
    let is_even = crossings >= CROSSINGS && width(second) > width(first) / 2.0;
    values.is_empty() || is_even || width(last) <= (SETTLED * width(all)).max(MOVED * noise(values))
}

/// Whether values that are at rest on the whole swing, by more than noise and by what can be seen of `all` values of the run.
fn swings(values: &[f64], all: &[f64]) -> bool {
    let magnitude = values.iter().fold(0.0_f64, |magnitude, value| magnitude.max(value.abs()));
    let unseen = (BAND * width(all)).max(SETTLED * magnitude).max(MOVED * noise(values));
    width(&values[values.len() * 2 / 3..]) > unseen
}

/// From the lowest to the highest of values.
fn width(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    high - low
}

#[cfg(test)]
mod tests;
