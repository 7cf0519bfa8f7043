//! Methods that read a model off the response curve.

use super::Model;
use super::step::Step;
use anyhow::{Context, Result};
use std::f64::consts::E;

/// Longer recordings are averaged down to at most this many samples before the slope search.
const MOST_SAMPLES: usize = 20_000;

/// The line fitted to a window of the response: its centre and slope.
struct Tangent {
    time: f64,
    value: f64,
    slope: f64,
}

/// Returns the fractions of the response that a lag reaches after a third of its time constant, and after one time
/// constant.
fn parts() -> [f64; 2] {
    [1.0 / 3.0, 1.0].map(|constants: f64| -libm::expm1(-constants))
}

/// Identifies a lag from the times at which 28 % and 63 % of the response are reached.
pub(super) fn two_points(step: &Step) -> Result<Model> {
    let missing = "the response does not pass 28 % and 63 % of its final value: use least squares";
    let [first, second] = parts().map(|part| step.reaches(part).context(missing));
    let (first, second) = (first?, second?);
    let time_constant = 1.5 * (second - first);
    Ok(model(step, step.end(), time_constant, second - time_constant - delay_of_input(step)))
}

/// Identifies a lag from the areas above and below the response.
pub(super) fn area(step: &Step) -> Result<Model> {
    let end = step.end();
    let above = integral(step, step.duration(), |value| end - value) / end;
    let below = integral(step, above, |value| value) / end;
    let time_constant = E * below;
    Ok(model(step, end, time_constant, above - time_constant - delay_of_input(step)))
}

/// Identifies a lag from the steepest slope.
pub(super) fn tangent(step: &Step) -> Result<Model> {
    let steepest = steepest(step)?;
    let end = step.end();
    let start = steepest.time - steepest.value / steepest.slope;
    Ok(model(step, end, end / steepest.slope, start - delay_of_input(step)))
}

/// Identifies an integrating plant from the steepest slope.
pub(super) fn integrating_tangent(step: &Step) -> Result<Model> {
    let steepest = steepest(step)?;
    let start = steepest.time - steepest.value / steepest.slope - delay_of_input(step);
    Ok(Model {
        gain: steepest.slope / step.height,
        dead_time: start.max(0.0),
        is_integrating: true,
        ..Model::default()
    })
}

/// Returns the delay of the input in seconds: from its first change to the ideal step that has the same area.
fn delay_of_input(step: &Step) -> f64 {
    let late: f64 = step.moves.windows(2).map(|pair| (step.height - pair[0].1) * (pair[1].0 - pair[0].0)).sum();
    late / step.height
}

fn model(step: &Step, end: f64, time_constant: f64, dead_time: f64) -> Model {
    Model { gain: end / step.height, time_constant, dead_time: dead_time.max(0.0), ..Model::default() }
}

/// Integrates a function of the process value from the step to a time by the trapezoidal rule.
fn integral(step: &Step, to: f64, function: impl Fn(f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for (times, values) in step.times.windows(2).zip(step.values.windows(2)) {
        if times[0] >= to {
            break;
        }
        let end = times[1].min(to);
        let last = values[0] + (values[1] - values[0]) * (end - times[0]) / (times[1] - times[0]);
        sum += f64::midpoint(function(values[0]), function(last)) * (end - times[0]);
    }
    sum
}

/// Finds the steepest point of the response: the slope of a straight line through enough samples to determine it
/// to five percent despite the noise, but through at most a tenth of the record.
fn steepest(step: &Step) -> Result<Tangent> {
    let neighbours = step.times.len().div_ceil(MOST_SAMPLES).max(1);
    let means = |values: &[f64]| {
        values.chunks(neighbours).map(|of| of.iter().sum::<f64>() / of.len() as f64).collect::<Vec<_>>()
    };
    let step = &Step {
        times: means(&step.times),
        values: means(&step.values),
        noise: step.noise / (neighbours as f64).sqrt(),
        ..step.clone()
    };
    let (interval, most) = (step.interval(), (step.times.len() / 10).max(2));
    let mut count = 2;
    let mut found =
        steepest_of(step, count).context("the response has no slope towards its final value: use least squares")?;
    while count < most {
        let uncertainty = step.noise * 12.0_f64.sqrt() / (interval * (count as f64).powf(1.5));
        if uncertainty <= 0.05 * found.slope.abs() {
            break;
        }
        count = (count * 5 / 4 + 1).min(most);
        found =
            steepest_of(step, count).context("the response has no slope towards its final value: use least squares")?;
    }
    Ok(found)
}

fn steepest_of(step: &Step, count: usize) -> Option<Tangent> {
    let sign = step.end().signum();
    let lines = step.times.windows(count).zip(step.values.windows(count)).map(|(times, values)| {
        let samples = times.len() as f64;
        let (time, value) = (times.iter().sum::<f64>() / samples, values.iter().sum::<f64>() / samples);
        let product: f64 = times.iter().zip(values).map(|(t, v)| (t - time) * (v - value)).sum();
        let spread: f64 = times.iter().map(|t| (t - time) * (t - time)).sum();
        Tangent { time, value, slope: product / spread }
    });
    lines.max_by(|a, b| (a.slope * sign).total_cmp(&(b.slope * sign))).filter(|line| line.slope * sign > 0.0)
}
