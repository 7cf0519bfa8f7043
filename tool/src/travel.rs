//! The travel of a step controller's actuator, computed from the pulses and the actuator's travel time from stop to
//! stop. Stops and backlash are not taken into account.

use crate::home::Home;
use crate::session::Record;
use crate::signals::Signals;
use anyhow::{Context, Result, bail};
use control::identify::{self, Identified, Recorded};
use control::tune::Controller;
use modeldescription::digits::short;

/// The remedy if the travel is unknown.
const REMEDY: &str = "identify from a CSV file that contains the actuator position";
/// The minimum travel per sample during a pulse, as a fraction of the range of the travel: so, even if a pulse lasts
/// for many calls, it looks like a step.
const MOVE: f64 = 0.04;

/// Identifies the plant from the travel of the actuator, as its manipulated value, and the process value.
///
/// # Errors
/// As for [`percent_of_a_call`], or the record does not reveal the plant.
pub(crate) fn identify(
    home: &dyn Home,
    record: &Record,
    signals: &Signals,
    request: &identify::IdentifyRequest,
) -> Result<Identified> {
    let motor = Motor::new(home, record)?;
    let percent = motor.percent_of_a_call(record)?;
    let travel = travel(&signals.pulses, percent);
    let stride = stride(&travel, percent);
    let (times, input, output) = thinned(&signals.times, &travel, &signals.process_value, stride);
    let recorded = Recorded { times: &times, input: &input, output: &output };
    let names = motor.controller.roles.pulses.join(" and ");
    let mut identified = identify::identify(&recorded, request.method, request.is_integrating)
        .with_context(|| format!("the manipulated value is the travel caused by {names}"))?;
    identified.remarks.insert(
        0,
        format!(
            "The manipulated value is the travel caused by {names}: 100 % in {} = {} s. The backlash is unknown: \
             the pulse before the step should have the same direction.",
            motor.time,
            short(motor.seconds)
        ),
    );
    Ok(identified)
}

/// The distance that a pulse of one call moves the actuator, in percent of its travel.
///
/// # Errors
/// The controller is not a step controller with a travel time above 0, or it is called more often than the run records.
pub(crate) fn percent_of_a_call(home: &dyn Home, record: &Record) -> Result<f64> {
    Motor::new(home, record)?.percent_of_a_call(record)
}

/// The actuator of a step controller.
struct Motor {
    controller: Controller,
    /// The setting that holds the travel time from stop to stop.
    time: String,
    seconds: f64,
}

impl Motor {
    fn new(home: &dyn Home, record: &Record) -> Result<Motor> {
        let member = record.setup().members.first().context("no controller")?;
        let controller = Controller::new(home, member)?;
        let time = controller.motor_time_setting().filter(|_| controller.is_step_controller()).map(str::to_string);
        let Some(time) = time.filter(|_| controller.roles.pulses.len() == 2) else {
            bail!("{} has no manipulated value, and the travel of its pulses is unknown: {REMEDY}", member.fmu);
        };
        let seconds = last(record, &member.name, &time)?;
        if seconds <= 0.0 {
            bail!("{time} is {seconds} s: set it to the actuator's travel time from stop to stop");
        }
        Ok(Motor { controller, time, seconds })
    }

    fn percent_of_a_call(&self, record: &Record) -> Result<f64> {
        let member = &self.controller.member;
        let cycle = last(record, &member.name, self.controller.cycle_setting())?;
        let interval = record.time(1) - record.time(0);
        if interval > 1.5 * cycle {
            bail!(
                "the run has steps of {} s, but {} is called every {} s: not every pulse is recorded; {REMEDY}",
                short(interval),
                member.fmu,
                short(cycle)
            );
        }
        Ok(100.0 * interval / self.seconds)
    }
}

/// The value of a setting in the last call.
fn last(record: &Record, member: &str, setting: &str) -> Result<f64> {
    let column = record.column(&format!("{member}.{setting}"))?;
    let last = record.trace().exact().end.saturating_sub(1);
    record.trace().column(column, last..last + 1).next().context("the run has no calls yet: run the loop first")
}

/// The total displacement of the actuator by the pulses up and down, in percent; `percent` is the travel per call of a
/// pulse.
pub(crate) fn total(pulses: &[Vec<bool>], percent: f64) -> f64 {
    let calls = |which: usize| pulses[which].iter().filter(|is_on| **is_on).count() as f64;
    percent * (calls(0) - calls(1))
}

/// The mean position of the actuator during each call, in percent, counted from its first position.
fn travel(pulses: &[Vec<bool>], percent: f64) -> Vec<f64> {
    let mut position = 0.0;
    let mean = |(up, down): (&bool, &bool)| {
        let way = percent * (f64::from(u8::from(*up)) - f64::from(u8::from(*down)));
        position += way;
        position - way / 2.0
    };
    pulses[0].iter().zip(&pulses[1]).map(mean).collect()
}

/// The number of calls per sample for which a pulse moves the actuator by at least [`MOVE`] per sample.
fn stride(travel: &[f64], percent: f64) -> usize {
    let (low, high) = travel.iter().fold((0.0_f64, 0.0_f64), |(low, high), at| (low.min(*at), high.max(*at)));
    ((MOVE * (high - low) / percent).ceil() as usize).max(1)
}

/// Thins out the signals to one sample per `stride` calls: time and output in the first of these calls, and the mean of
/// the input over all of them.
fn thinned(times: &[f64], input: &[f64], output: &[f64], stride: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let firsts = |values: &[f64]| values.iter().copied().step_by(stride).collect::<Vec<_>>();
    let means = input.chunks(stride).map(|part| part.iter().sum::<f64>() / part.len() as f64).collect();
    (firsts(times), means, firsts(output))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_travel_is_the_sum_of_the_pulses_and_its_mean_lies_in_the_middle_of_a_call() {
        let up = vec![false, true, true, false, false, false];
        let down = vec![false, false, false, false, true, false];
        let pulses = [up, down];
        assert_eq!(travel(&pulses, 4.0), [0.0, 2.0, 6.0, 8.0, 6.0, 4.0]);
        assert_eq!(total(&pulses, 4.0), 4.0);
    }

    #[test]
    fn a_sample_has_so_many_calls_that_a_pulse_moves_a_part_of_the_travel_that_counts() {
        assert_eq!(stride(&[0.0, 2.0, 6.0, 8.0], 4.0), 1);
        // 300 calls of 0.1 %: 0.04 of 30 % is 12 calls.
        let travel: Vec<f64> = (0..=300).map(|call| f64::from(call) * 0.1).collect();
        assert_eq!(stride(&travel, 0.1), 12);
        assert_eq!(stride(&[0.0; 9], 0.1), 1);
    }

    #[test]
    fn thinned_samples_keep_the_mean_of_the_input() {
        let (times, input, output) = thinned(&[0.0, 1.0, 2.0], &[2.0, 4.0, 5.0], &[7.0, 8.0, 9.0], 2);
        assert_eq!((times, input, output), (vec![0.0, 2.0], vec![3.0, 5.0], vec![7.0, 9.0]));
    }
}
