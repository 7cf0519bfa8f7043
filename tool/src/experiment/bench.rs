//! A loop held in manual mode for a test of its plant.

use super::{FIRST, MOST_CALLS, SETTLED, Settle, UNKNOWN_PERIOD, is_at_rest, settle};
use crate::describe::describe;
use crate::home::Home;
use crate::message::Values;
use crate::session::Session;
use crate::signals::Signals;
use crate::travel;
use anyhow::{Context, Result, bail, ensure};
use control::identify::means_of_pulses;
use run::fmus::number_of;
use run::system::{Exchange, Value};

/// A loop held in manual mode. Displacements of the actuator are in the unit of the manipulated value; with pulses, in
/// percent of its travel.
pub(super) struct Bench<'a> {
    pub(super) home: &'a dyn Home,
    pub(super) session: &'a mut Session,
    drive: Drive,
    pub(super) process_value_name: String,
    /// `MEMBER.VARIABLE` of the switch to manual mode.
    switch_name: String,
    /// The previous mode, manual value and manual pulses.
    was: Values,
    /// The initial position of the actuator; 0 with pulses, whose travel is counted from there.
    pub(super) output: f64,
    /// When the hold began, in seconds.
    pub(super) from: f64,
    /// The number of calls in a pulse period, in which the controller may sample the process value only once; 1 without
    /// pulses.
    pub(super) every: usize,
}

/// How the actuator is moved in manual mode. All names are `MEMBER.VARIABLE`.
enum Drive {
    Value {
        name: String,
        /// The manual value that keeps the actuator at its initial position.
        held: f64,
        /// The current displacement from that position.
        away: f64,
        /// The names of the low and the high limit of the manipulated value.
        limits: Option<[String; 2]>,
    },
    Pulses {
        /// The pulses down and up.
        names: [String; 2],
        /// The variables that indicate the low and the high stop of the actuator.
        stops: [Option<String>; 2],
        /// The travel caused by a pulse of one call, in percent.
        percent: f64,
    },
}

impl Drive {
    /// The settings that move the actuator.
    fn settings(&self) -> &[String] {
        match self {
            Drive::Value { name, .. } => std::slice::from_ref(name),
            Drive::Pulses { names, .. } => names,
        }
    }
}

impl<'a> Bench<'a> {
    /// Switches to manual mode without moving the actuator.
    pub(super) fn hold(home: &'a dyn Home, session: &'a mut Session) -> Result<Bench<'a>> {
        let record = session.record(None)?;
        let controller = record.members().next().context("no controller")?.clone();
        ensure!(record.members().nth(1).is_some(), "nothing responds to {}: connect a plant first", controller.name);
        let roles = describe(home, &controller.fmu)?.roles;
        let fmu = &controller.fmu;
        let name = |variable: &String| format!("{}.{variable}", controller.name);
        let (switch, drive, output) = match (&roles.manual, &roles.manipulated_value, &roles.manual_pulses) {
            (Some((switch, manual)), Some(output), _) => {
                let limits = roles.limits.as_ref().map(|(high, low)| [name(low), name(high)]);
                (switch, Drive::Value { name: name(manual), held: 0.0, away: 0.0, limits }, Some(name(output)))
            }
            (_, _, Some((switch, [up, down]))) => {
                let stops = ["low stop", "high stop"]
                    .map(|stop| roles.signals.iter().find(|(meaning, _)| meaning == stop).map(|(_, of)| name(of)));
                (switch, Drive::Pulses { names: [name(down), name(up)], stops, percent: f64::NAN }, None)
            }
            _ => bail!(
                "{fmu} has no manual value with which its output can be stepped: move the actuator manually, then \
                 identify from the run"
            ),
        };
        let process_value = roles
            .compared_process_value()
            .with_context(|| format!("{fmu} does not specify which variable is its process value"))?;
        let values = session.state()?.values;
        let set = std::iter::once(name(switch)).chain(drive.settings().iter().cloned());
        let was = set.filter_map(|name| Some((name.clone(), *values.get(name.as_str())?))).collect();
        let mut bench = Bench {
            home,
            was,
            switch_name: name(switch),
            process_value_name: name(process_value),
            session,
            drive,
            output: 0.0,
            from: 0.0,
            every: 1,
        };
        let record = bench.session.record(None)?;
        // In a parallel exchange, a value takes one call to pass through each member. Until it has passed through all
        // of them, a row contains values from before the first call.
        let until_seen = match record.setup().exchange {
            Exchange::Sequential => 1,
            Exchange::Parallel => record.members().count(),
        };
        // Settings made since the last call, such as the manual value, must take effect, too.
        if record.calls() == 0 || record.done().last().is_some_and(|done| done.call == record.calls()) {
            bench.run(until_seen)?;
        }
        match output {
            Some(output) => bench.hold_value(&output, until_seen)?,
            None => bench.hold_position(until_seen)?,
        }
        Ok(bench)
    }

    /// Finds the manual value that leaves the output unchanged.
    fn hold_value(&mut self, output: &str, until_seen: usize) -> Result<()> {
        // In a single call, a pulse is either on or off; the actuator follows the mean.
        let pulses = self.signals(0.0)?;
        let means = means_of_pulses(&pulses.times, &pulses.manipulated_value).filter(|_| !pulses.pulses.is_empty());
        let target = match means.as_ref().and_then(|(means, _)| means.last()) {
            Some(mean) => *mean,
            None => self.value(output)?,
        };
        self.go_manual()?;
        self.output = target;
        self.hold_at(target)?;
        if !pulses.pulses.is_empty() {
            self.every = UNKNOWN_PERIOD;
        }
        if let Some((_, period)) = means {
            self.every = ((period / self.session.record(None)?.step()).round() as usize).max(1);
            return Ok(());
        }
        // Within its limits, the block's output is a linear function of the manual value, with unknown factor and
        // offset.
        let mut tried: Option<(f64, f64)> = None;
        let mut manual = target;
        for _ in 0..3 {
            self.run(until_seen)?;
            let now = self.value(output)?;
            let off = target - now;
            if off.abs() <= 1e-6 * target.abs().max(1.0) {
                break;
            }
            let slope = match tried {
                Some((other, before)) if manual != other && now != before => (now - before) / (manual - other),
                _ => 1.0,
            };
            tried = Some((manual, now));
            manual += off / slope;
            self.hold_at(manual)?;
        }
        Ok(())
    }

    /// Switches to manual mode with both pulses off, so that the actuator does not move.
    fn hold_position(&mut self, until_seen: usize) -> Result<()> {
        let moved = travel::percent_of_a_call(self.home, self.session.record(None)?)?;
        self.go_manual()?;
        if let Drive::Pulses { names, percent, .. } = &mut self.drive {
            *percent = moved;
            self.session.send(&names.iter().map(|name| (name.clone(), Value::Boolean(false))).collect())?;
        }
        self.run(until_seen)
    }

    fn go_manual(&mut self) -> Result<()> {
        self.from = self.next_time()?;
        self.session.send(&Values::from([(self.switch_name.clone(), Value::Boolean(true))]))?;
        Ok(())
    }

    fn hold_at(&mut self, value: f64) -> Result<()> {
        if let Drive::Value { held, .. } = &mut self.drive {
            *held = value;
        }
        self.put(0.0).map(drop)
    }

    /// Whether the actuator can move this far from its initial position: the manipulated value would be within its
    /// limits. With pulses: whether the actuator is not at the stop in that direction.
    pub(super) fn is_within(&mut self, size: f64) -> Result<bool> {
        match &self.drive {
            Drive::Value { limits: None, .. } => Ok(true),
            Drive::Value { limits: Some([low, high]), .. } => {
                let (low, high) = (low.clone(), high.clone());
                Ok((self.value(&low)?..=self.value(&high)?).contains(&(self.output + size)))
            }
            Drive::Pulses { stops, .. } => match stops[usize::from(size > 0.0)].clone() {
                Some(stop) => Ok(self.value(&stop)? == 0.0),
                None => Ok(true),
            },
        }
    }

    /// Whether pulses move the actuator.
    pub(super) fn has_pulses(&self) -> bool {
        matches!(self.drive, Drive::Pulses { .. })
    }

    /// The displacement of the actuator from its initial position.
    pub(super) fn away(&self) -> Result<f64> {
        match &self.drive {
            Drive::Value { away, .. } => Ok(*away),
            Drive::Pulses { percent, .. } => Ok(travel::total(&self.signals(self.from)?.pulses, *percent)),
        }
    }

    /// Moves the actuator to this distance from its initial position, and returns the number of calls that its pulse
    /// took.
    pub(super) fn put(&mut self, value: f64) -> Result<usize> {
        let way = value - self.away()?;
        match &mut self.drive {
            Drive::Value { name, held, away, .. } => {
                *away = value;
                let sent = Values::from([(name.clone(), Value::Number(*held + value))]);
                self.session.send(&sent)?;
                Ok(0)
            }
            Drive::Pulses { names, percent, .. } => {
                let calls = (way.abs() / *percent).round() as usize;
                if calls > 0 {
                    let name = names[usize::from(way > 0.0)].clone();
                    for (is_on, calls) in [(true, calls), (false, 1)] {
                        self.session.send(&Values::from([(name.clone(), Value::Boolean(is_on))]))?;
                        self.run(calls)?;
                    }
                }
                Ok(calls)
            }
        }
    }

    /// Restores the loop: the actuator returns to its initial position, the plant follows, and mode and manual value
    /// are restored. An integrating plant is driven back to this `level`. Without a level, the test has failed, and the
    /// function does not wait.
    pub(super) fn release(&mut self, level: Option<f64>, is_integrating: bool) -> Result<()> {
        let was_automatic = self.was.get(&self.switch_name) == Some(&Value::Boolean(false));
        let size = self.away()?;
        self.put(0.0)?;
        match level {
            Some(level) if is_integrating && !was_automatic => self.drive_back(level, size)?,
            Some(_) if !is_integrating => self.settle(SETTLED, |_| true)?,
            _ => {}
        }
        self.session.send(&self.was.clone())?;
        if was_automatic && level.is_some() {
            let from = self.next_time()?;
            settle(self.home, self.session, &Settle { calls: MOST_CALLS / 10, from })?;
            return Ok(());
        }
        self.run(1)
    }

    /// Moves the process value of an integrating plant back to a level, by the opposite of the step `size`.
    fn drive_back(&mut self, level: f64, size: f64) -> Result<()> {
        let values = self.process_value()?;
        let off = values.last().map_or(0.0, |last| last - level);
        if self.is_within(-size)? {
            self.put(-size)?;
            let mut left = values.len() * 4;
            while left > 0 && (self.value(&self.process_value_name.clone())? - level) * off > 0.0 {
                self.run(1)?;
                left -= 1;
            }
            self.put(0.0)?;
        }
        Ok(())
    }

    pub(super) fn run(&mut self, calls: usize) -> Result<()> {
        match self.session.run(calls.min(MOST_CALLS))?.failure {
            Some(failure) => bail!("the run has ended ({failure}): start again"),
            None => Ok(()),
        }
    }

    /// The value of a variable after the last call.
    pub(super) fn value(&mut self, name: &str) -> Result<f64> {
        let state = self.session.state()?;
        state.values.get(name).copied().map(number_of).with_context(|| format!("{name} is not recorded"))
    }

    /// The time of the next call, in seconds.
    pub(super) fn next_time(&self) -> Result<f64> {
        let record = self.session.record(None)?;
        Ok(record.time(record.calls()))
    }

    pub(super) fn signals(&self, from: f64) -> Result<Signals> {
        Signals::new(self.home, self.session.record(None)?, Some(from), None)
    }

    /// The process value in each call since the hold began.
    pub(super) fn process_value(&self) -> Result<Vec<f64>> {
        self.process_value_from(self.from)
    }

    pub(super) fn process_value_from(&self, from: f64) -> Result<Vec<f64>> {
        Ok(self.signals(from)?.process_value)
    }

    /// One process value per pulse period.
    pub(super) fn sampled(&self, from: f64) -> Result<Vec<f64>> {
        Ok(self.process_value_from(from)?.into_iter().step_by(self.every).collect())
    }

    /// Makes calls until the process value has settled within the fraction `part` of its range and meets the condition
    /// `is_done`.
    pub(super) fn settle(&mut self, part: f64, is_done: impl Fn(&[f64]) -> bool) -> Result<()> {
        let from = self.next_time()?;
        let first = FIRST * self.every;
        let mut calls = first;
        let mut made = 0;
        loop {
            self.run(calls)?;
            made += calls;
            let values = self.sampled(from)?;
            if is_done(&values) && is_at_rest(&values, part) {
                return Ok(());
            }
            self.check_patience(made, "has not settled, or has not responded to the step: choose a larger step")?;
            calls = (made / 10).max(first);
        }
    }

    pub(super) fn check_patience(&self, calls: usize, what: &str) -> Result<()> {
        if calls > MOST_CALLS / 2 {
            let seconds = calls as f64 * self.session.record(None)?.step();
            bail!(
                "after {seconds:?} s, {} {what}; if the plant is integrating, tick that option below and test again",
                self.process_value_name
            );
        }
        Ok(())
    }
}
