//! How far a loop is from instability: sensitivity, gain margin and phase margin, from the frequency response of controller and
//! plant with the exact dead time; and the gain at which the plant oscillates.

use crate::identify::Model;
use crate::rules::Settings;
use libm::{atan, atan2, cos, exp, hypot, log};
use std::f64::consts::{FRAC_PI_2, PI};

/// The frequencies of the scan: enough that neighbours differ by less than a radian of the dead time.
const POINTS: usize = 4000;
/// How often an interval is divided when a crossing is refined.
const BISECTIONS: usize = 80;

/// What the frequency response of a loop says. A margin that is infinite is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// Ms, the largest amplification of a disturbance; absent if the loop is unstable.
    pub sensitivity: Option<f64>,
    /// By which factor GAIN can rise until the loop oscillates; below 1 it is unstable.
    pub gain_margin: Option<f64>,
    /// By how many degrees the phase can fall until the loop oscillates; below 0 it is unstable.
    pub phase_margin: Option<f64>,
}

impl Margins {
    /// Whether the loop is stable.
    pub fn is_stable(&self) -> bool {
        self.sensitivity.is_some()
    }
}

/// The margins of a controller with a plant. GAIN and the plant's gain count by their amounts.
pub fn of(model: &Model, settings: &Settings) -> Margins {
    let open_loop = |frequency: f64| {
        let (amplitude, phase) = controller(settings, frequency);
        let plant = plant(model, frequency);
        (amplitude * plant.0, phase + plant.1)
    };
    let frequencies = frequencies(model, settings);
    let responses: Vec<(f64, f64)> = frequencies.iter().map(|frequency| open_loop(*frequency)).collect();
    let (mut gain_margin, mut phase_margin) = (None::<f64>, None::<f64>);
    for (pair, between) in responses.windows(2).zip(frequencies.windows(2)) {
        let turns = |phase: f64| ((phase + PI) / (2.0 * PI)).ceil();
        // Below -180, -540, ... degrees.
        if turns(pair[1].1) < turns(pair[0].1) {
            let level = 2.0 * PI * (turns(pair[0].1) - 1.0) - PI;
            let frequency = crossing(between, |frequency| open_loop(frequency).1 - level);
            let margin = 1.0 / open_loop(frequency).0;
            gain_margin = Some(gain_margin.map_or(margin, |other| other.min(margin)));
        }
        if (pair[0].0 > 1.0) != (pair[1].0 > 1.0) {
            let frequency = crossing(between, |frequency| open_loop(frequency).0 - 1.0);
            let margin = 180.0 + open_loop(frequency).1.to_degrees();
            phase_margin = Some(phase_margin.map_or(margin, |other| other.min(margin)));
        }
    }
    let is_stable = gain_margin.is_none_or(|margin| margin > 1.0) && phase_margin.is_none_or(|margin| margin > 0.0);
    let sensitivity = is_stable.then(|| {
        let amplification = |(amplitude, phase): (f64, f64)| {
            1.0 / (1.0 + 2.0 * amplitude * cos(phase) + amplitude * amplitude).max(f64::MIN_POSITIVE).sqrt()
        };
        let (highest, _) = responses.iter().enumerate().fold((0, 0.0), |best, (point, response)| {
            let value = amplification(*response);
            if value > best.1 { (point, value) } else { best }
        });
        let (low, high) = (highest.saturating_sub(1), (highest + 1).min(POINTS - 1));
        maximum(frequencies[low], frequencies[high], |frequency| amplification(open_loop(frequency)))
    });
    Margins { sensitivity, gain_margin, phase_margin }
}

/// The ultimate gain, by its amount, and the period of the oscillation in seconds: what a P controller needs to make the loop
/// oscillate. A plant without dead time has none, as its phase does not reach -180 degrees.
pub fn ultimate(model: &Model) -> Option<(f64, f64)> {
    if model.dead_time <= 0.0 {
        return None;
    }
    // At this frequency the dead time alone makes -180 degrees.
    ultimate_of(PI / model.dead_time, |frequency| plant(model, frequency))
}

/// The same for any plant: its amplitude and its phase in radians, falling from above -180 degrees to below at `highest`.
pub fn ultimate_of(highest: f64, plant: impl Fn(f64) -> (f64, f64)) -> Option<(f64, f64)> {
    if plant(highest).1 > -PI {
        return None;
    }
    let frequency = crossing(&[highest * 1e-9, highest], |frequency| plant(frequency).1 + PI);
    Some((1.0 / plant(frequency).0, 2.0 * PI / frequency))
}

/// Amplitude and phase of the controller. Its real part is never negative, so that the phase does not jump.
fn controller(settings: &Settings, frequency: f64) -> (f64, f64) {
    let td = settings.td.unwrap_or_default();
    let lag = frequency * settings.tm_lag;
    let filtered = frequency * td / (1.0 + lag * lag);
    let real = 1.0 + filtered * lag;
    let imaginary = filtered - settings.ti.map_or(0.0, |ti| 1.0 / (frequency * ti));
    (settings.gain.abs() * hypot(real, imaginary), atan2(imaginary, real))
}

/// Amplitude and phase of the plant.
fn plant(model: &Model, frequency: f64) -> (f64, f64) {
    let second = frequency * model.second_time_constant;
    let (amplitude, phase) = if model.is_integrating {
        (model.gain.abs() / frequency, -FRAC_PI_2)
    } else {
        let first = frequency * model.time_constant;
        (model.gain.abs() / hypot(1.0, first), -atan(first))
    };
    (amplitude / hypot(1.0, second), phase - atan(second) - frequency * model.dead_time)
}

/// Where to look, from far below to far above all of the loop's times.
fn frequencies(model: &Model, settings: &Settings) -> Vec<f64> {
    let times = [
        model.time_constant,
        model.second_time_constant,
        model.dead_time,
        settings.ti.unwrap_or_default(),
        settings.td.unwrap_or_default(),
        settings.tm_lag,
        // An integrator is as fast as its gain.
        if model.is_integrating { 1.0 / (model.gain * settings.gain).abs() } else { 0.0 },
    ];
    let positive = || times.iter().copied().filter(|time| *time > 0.0 && time.is_finite());
    let longest = positive().fold(0.0, f64::max);
    let shortest = positive().fold(f64::INFINITY, f64::min);
    if longest == 0.0 {
        return vec![1.0; POINTS];
    }
    let lowest = log(1e-4 / longest);
    let highest = if model.dead_time > 0.0 { log(100.0 / model.dead_time) } else { log(1e4 / shortest) };
    let highest = highest.max(lowest + 1.0);
    (0..POINTS).map(|point| exp(lowest + (highest - lowest) * point as f64 / (POINTS - 1) as f64)).collect()
}

/// Where a function changes its sign within an interval.
fn crossing(between: &[f64], function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (between[0], between[1]);
    let is_positive = function(low) > 0.0;
    for _ in 0..BISECTIONS {
        let middle = f64::midpoint(low, high);
        if (function(middle) > 0.0) == is_positive {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// The largest value of a function that has one maximum within an interval.
fn maximum(low: f64, high: f64, function: impl Fn(f64) -> f64) -> f64 {
    let at = crate::identify::golden_section(low, high, BISECTIONS, |frequency| -function(frequency));
    function(at)
}

#[cfg(test)]
mod tests;
