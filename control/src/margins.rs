//! Distance of a loop from instability: sensitivity, gain margin and phase margin of a sampled loop, and the ultimate
//! gain of a plant.
//!
//! The controller samples the plant only at its calls, and holds its manipulated value between them. A plant is
//! therefore represented by its process value at the calls: after a unit step in the manipulated value the process
//! value changes by h1, h2, ..., and `P(z) = h1 z^-1 + h2 z^-2 + ...`. This holds for any linear plant, whether h1, h2,
//! ... are taken from a [record](Plant::of_step) or a [model](Plant::of_model); after the last one, they continue as a
//! geometric sequence. The controller is the law computed in each call, see [`Law`]. By the argument principle, a loop
//! is stable if `(1 - z^-1)^k (1 + C(z) P(z))`, with k integrators, does not encircle 0 as z moves along the unit
//! circle.

use crate::identify::Model;
use crate::process::Process;
use crate::rules::Settings;
use libm::{atan, atan2, cos, exp, hypot, log, pow, sin};
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::{Add, Div, Mul, Sub};

/// The logarithmic spacing of the frequencies. At the frequency at which a dead time contributes a phase of one radian,
/// its phase changes by this many radians from one frequency to the next.
const DENSITY: f64 = 0.012;
/// The maximum number of samples of a plant's step response; beyond it, the response is sampled at longer intervals.
const MOST_STEPS: usize = 20_000;
/// The number of time constants after which a lag has settled.
const RESTS: f64 = 12.0;
/// If the ratio of the change in the last tenth of a record to that in the tenth before it is not below this, the
/// response is not continued as that of a settling lag.
const SLOWEST: f64 = 0.95;
/// The number of bisections that refine a crossing.
const BISECTIONS: usize = 80;

/// The margins read off the frequency response of a loop. An infinite margin is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// Ms, the maximum amplification of a disturbance; absent if the loop is unstable.
    pub sensitivity: Option<f64>,
    /// The factor by which GAIN can rise until the loop oscillates; an unstable loop has less than 1.
    pub gain_margin: Option<f64>,
    /// The number of degrees by which the phase can fall until the loop oscillates; an unstable loop has less than 0.
    pub phase_margin: Option<f64>,
    /// The frequency in rad/s at which the gain margin is read: the phase is -180 degrees.
    pub phase_crossover: Option<f64>,
    /// The frequency in rad/s at which the phase margin is read: the amplitude is 1.
    pub gain_crossover: Option<f64>,
}

impl Margins {
    /// Whether the loop is stable.
    pub fn is_stable(&self) -> bool {
        self.sensitivity.is_some()
    }
}

/// The control law: the controller's output as a function of the error, call by call.
///
/// ```text
/// LMN = p + i + d    p = GAIN e
/// i = i + CYCLE/TI (p + p of the previous call)/2
/// d = TD/(TM_LAG + CYCLE/2) (p - w), then w = w + CYCLE/TD d
/// ```
///
/// If the loop exchanges values less often than the controller is called, the plant receives only every n-th
/// manipulated value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// The settings; only the magnitude of GAIN is used. The caller must raise times that are too short for the law.
    pub settings: Settings,
    /// The time between two calls in seconds.
    pub cycle: f64,
    /// The number of calls from one process value to the next.
    pub calls: u32,
}

impl Law {
    /// Returns the frequency response at `z^-1 = back`, where z is a shift by the time between two process values.
    fn response(&self, back: Complex) -> Complex {
        let Law { settings: Settings { gain, ti, td, tm_lag }, cycle, calls } = *self;
        let mut sum = Complex::ONE;
        // The error is constant from one process value to the next. Only the first call's integration still includes
        // the previous error.
        if let Some(ti) = ti {
            let added = (Complex::ONE + back) * 0.5 + Complex::ONE * f64::from(calls - 1);
            sum = sum + added * (cycle / ti) / (Complex::ONE - back);
        }
        if let Some(td) = td {
            let kick = td / (tm_lag + cycle / 2.0);
            let left = 1.0 - cycle / td * kick;
            let (last, all) = (pow(left, f64::from(calls - 1)), pow(left, f64::from(calls)));
            sum = sum + (Complex::ONE - back) * (kick * last) / (Complex::ONE - back * all);
        }
        sum * gain.abs()
    }

    /// Returns the time between two process values in seconds.
    fn sampling(&self) -> f64 {
        self.cycle * f64::from(self.calls)
    }
}

/// The frequency response of a plant whose process value is sampled by the calls of a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// The frequencies in rad/s, ascending, with the response at each.
    responses: Vec<(f64, Complex)>,
    /// The delay in seconds caused by the hold of the manipulated value and by pulses.
    hold: f64,
    is_integrating: bool,
}

impl Plant {
    /// Creates a plant from the sampled response of its process value to a unit step in the manipulated value. The
    /// values are `interval` seconds apart, beginning at the call of the step.
    ///
    /// `delay` is the delay added by pulses, half of their period, in seconds.
    ///
    /// The changes in the last tenth and in the tenth before it determine how the response continues.
    pub fn of_step(values: &[f64], interval: f64, is_integrating: bool, delay: f64) -> Plant {
        let stride = values.len().div_ceil(MOST_STEPS).max(1);
        let values: Vec<f64> = values.iter().step_by(stride).copied().collect();
        let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let tenth = (steps.len() / 10).max(1).min(steps.len());
        let last: f64 = steps[steps.len() - tenth..].iter().sum();
        let before: f64 = steps.iter().rev().skip(tenth).take(tenth).sum();
        let (ratio, next) = if is_integrating {
            (1.0, (last + before) / (2 * tenth) as f64)
        } else if last / before > 0.0 && last / before < SLOWEST {
            let ratio = pow(last / before, 1.0 / tenth as f64);
            // The next tenth is smaller than the last one by the same ratio; this is its first step.
            (ratio, last * (last / before) * (1.0 - ratio) / (1.0 - last / before))
        } else {
            (0.0, 0.0)
        };
        let interval = interval * stride as f64;
        let longest = interval * steps.len() as f64;
        let plant = Plant::new(&steps, (ratio, next), interval, longest, is_integrating);
        Plant { hold: plant.hold + delay, ..plant }
    }

    /// Creates a plant from a model, for a controller that is called every `cycle` seconds.
    pub fn of_model(model: &Model, cycle: f64) -> Plant {
        let lags = [model.time_constant, model.second_time_constant];
        let (short, long) = (lags[0].min(lags[1]), lags[0].max(lags[1]));
        // Once the shorter lag has settled, only the longer one remains.
        let end = model.dead_time + RESTS * if model.is_integrating { long } else { short };
        let interval = cycle.max(end / MOST_STEPS as f64);
        let mut process = Process::at_rest(*model, 0.0);
        process.put(0.0, 1.0);
        let count = (end / interval).ceil() as usize + 10;
        let values: Vec<f64> = (0..=count).map(|call| process.output_at(call as f64 * interval)).collect();
        let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let ratio = match model.is_integrating {
            true => 1.0,
            false if long > 0.0 => exp(-interval / long),
            false => 0.0,
        };
        let longest = (interval * count as f64).max(long);
        Plant::new(&steps, (ratio, steps[count - 1] * ratio), interval, longest, model.is_integrating)
    }

    /// `tail` holds the ratio of successive steps after the last one, and the first of these steps; `longest` is the
    /// longest time scale of the plant in seconds.
    fn new(steps: &[f64], tail: (f64, f64), interval: f64, longest: f64, is_integrating: bool) -> Plant {
        // A loop with an integrating plant may be much slower than the plant's time scale.
        let lowest = log(if is_integrating { 1e-5 } else { 1e-2 } / longest);
        let highest = log(PI / interval);
        let count = ((highest - lowest) / DENSITY).ceil();
        let way = steps.iter().sum::<f64>() + if is_integrating { tail.1 } else { tail.1 / (1.0 - tail.0) };
        let response = |point: usize| {
            let frequency = exp(lowest + (highest - lowest) * (point as f64 / count));
            let back = Complex::turned(-frequency * interval);
            let behind = Complex::ONE * tail.1 / (Complex::ONE - back * tail.0);
            let sum = steps.iter().rev().fold(behind, |sum, step| sum * back + Complex::ONE * *step);
            (frequency, sum * back * way.signum())
        };
        Plant { responses: (0..=count as usize).map(response).collect(), hold: interval / 2.0, is_integrating }
    }
}

/// A point on the frequency response of an open loop, without the sign of the negative feedback.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The frequency in rad/s.
    pub frequency: f64,
    /// The amplitude as a factor.
    pub amplitude: f64,
    /// The phase in degrees, without jumps of 360 degrees.
    pub phase: f64,
}

/// Computes the open loop of a controller with a plant, up to the highest frequency that the calls can represent.
/// `delay` is as in [`compute`].
pub fn open_loop(plant: &Plant, law: &Law, delay: f64) -> Vec<Point> {
    let mut phase = 0.0;
    let mut before: Option<Complex> = None;
    let responses = responses(plant, law, delay);
    let points = responses.map(|(frequency, open)| {
        phase = before.map_or_else(|| first_phase(open), |before| phase + (open / before).angle());
        before = Some(open);
        Point { frequency, amplitude: open.amount(), phase: phase.to_degrees() }
    });
    points.collect()
}

/// Computes the frequency response of the open loop.
fn responses(plant: &Plant, law: &Law, delay: f64) -> impl Iterator<Item = (f64, Complex)> {
    let sampling = law.sampling();
    let delay = delay + sampling / 2.0 - plant.hold;
    let seen = plant.responses.iter().take_while(move |(frequency, _)| *frequency <= PI / sampling * (1.0 + 1e-9));
    seen.map(move |(frequency, response)| {
        let back = Complex::turned(-frequency * sampling);
        (*frequency, law.response(back) * *response * Complex::turned(-frequency * delay))
    })
}

/// Returns the phase in radians at the lowest frequency: between that of three integrators and that of a
/// differentiator.
fn first_phase(open: Complex) -> f64 {
    open.angle() - if open.angle() > FRAC_PI_2 { 2.0 * PI } else { 0.0 }
}

/// Computes the margins of a controller with a plant; only the magnitude of the gain is used.
///
/// `delay` is the delay that pulses add to the hold, half of their period, in seconds. If the plant was sampled with a
/// different delay or interval than the law, the response is corrected by the difference in delay and half the
/// difference in interval.
pub fn compute(plant: &Plant, law: &Law, delay: f64) -> Margins {
    let sampling = law.sampling();
    // Each integrator is a pole at 1.
    let integrators = usize::from(law.settings.ti.is_some()) + usize::from(plant.is_integrating);
    let mut points = responses(plant, law, delay).map(|(frequency, open)| {
        let back = Complex::turned(-frequency * sampling);
        let turning = (0..integrators).fold(Complex::ONE + open, |turning, _| turning * (Complex::ONE - back));
        (frequency, open, turning)
    });
    let Some((mut frequency, mut open, mut turning)) = points.next() else { return Margins::default() };
    let mut angle = turning.angle();
    let mut phase = first_phase(open);
    let mut nearest = (open + Complex::ONE).amount();
    let (mut gain_margin, mut phase_margin) = (None::<(f64, f64)>, None::<(f64, f64)>);
    let least = |margin: &mut Option<(f64, f64)>, value: f64, frequency: f64| {
        if margin.is_none_or(|(other, _)| value < other) {
            *margin = Some((value, frequency));
        }
    };
    for (next_frequency, next, next_turning) in points {
        angle += (next_turning / turning).angle();
        let turn = (next / open).angle();
        let between = |part: f64| frequency * pow(next_frequency / frequency, part);
        if open.imaginary < 0.0 && next.imaginary >= 0.0 {
            let part = open.imaginary / (open.imaginary - next.imaginary);
            let real = open.real + part * (next.real - open.real);
            if real < 0.0 {
                least(&mut gain_margin, -1.0 / real, between(part));
            }
        }
        let (amount, next_amount) = (open.amount(), next.amount());
        if (amount > 1.0) != (next_amount > 1.0) {
            let part = log(amount) / (log(amount) - log(next_amount));
            least(&mut phase_margin, 180.0 + (phase + part * turn).to_degrees(), between(part));
        }
        // Between two points, the angle and the logarithm of the amplitude change linearly: the curve is an arc.
        let middle = open * Complex::turned(turn / 2.0) * (next_amount / amount).sqrt();
        for (from, to) in [(open, middle), (middle, next)] {
            nearest = nearest.min(distance(from + Complex::ONE, to + Complex::ONE));
        }
        phase += turn;
        (frequency, open, turning) = (next_frequency, next, next_turning);
    }
    // The response of a sampled loop is real at the highest frequency.
    if open.real < 0.0 && open.imaginary < 0.0 {
        least(&mut gain_margin, -1.0 / open.real, frequency);
    }
    Margins {
        sensitivity: (angle.abs() < FRAC_PI_2).then(|| 1.0 / nearest.max(f64::MIN_POSITIVE)),
        gain_margin: gain_margin.map(|(margin, _)| margin),
        phase_margin: phase_margin.map(|(margin, _)| margin),
        phase_crossover: gain_margin.map(|(_, frequency)| frequency),
        gain_crossover: phase_margin.map(|(_, frequency)| frequency),
    }
}

/// Returns the distance from 0 to the segment between two points.
fn distance(from: Complex, to: Complex) -> f64 {
    let way = to - from;
    let length = way.real * way.real + way.imaginary * way.imaginary;
    let part = -(from.real * way.real + from.imaginary * way.imaginary) / length;
    let part = if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) };
    (from + way * part).amount()
}

/// Returns the magnitude of the ultimate gain and the period of the oscillation in seconds: the gain at which a P
/// controller makes the loop oscillate. A plant without dead time has none: its phase does not reach -180 degrees.
pub fn ultimate(model: &Model) -> Option<(f64, f64)> {
    if model.dead_time <= 0.0 {
        return None;
    }
    // At this frequency the dead time alone contributes -180 degrees.
    ultimate_of(PI / model.dead_time, |frequency| plant(model, frequency))
}

/// Like [`ultimate`], for any plant: `plant` returns its amplitude and its phase in radians, which falls from above
/// -180 degrees to -180 degrees or less at `highest`.
pub fn ultimate_of(highest: f64, plant: impl Fn(f64) -> (f64, f64)) -> Option<(f64, f64)> {
    if plant(highest).1 > -PI {
        return None;
    }
    let frequency = crossing(&[highest * 1e-9, highest], |frequency| plant(frequency).1 + PI);
    Some((1.0 / plant(frequency).0, 2.0 * PI / frequency))
}

/// Returns the amplitude and the phase in radians of the plant at a frequency in rad/s.
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

/// Finds the sign change of a function within an interval by bisection.
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

/// A complex number.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Complex {
    real: f64,
    imaginary: f64,
}

impl Complex {
    const ONE: Complex = Complex { real: 1.0, imaginary: 0.0 };

    /// Returns the number on the unit circle at an angle in radians.
    fn turned(angle: f64) -> Complex {
        Complex { real: cos(angle), imaginary: sin(angle) }
    }

    fn amount(self) -> f64 {
        hypot(self.real, self.imaginary)
    }

    /// Returns the angle from -pi to pi.
    fn angle(self) -> f64 {
        atan2(self.imaginary, self.real)
    }
}

impl Add for Complex {
    type Output = Complex;

    fn add(self, other: Complex) -> Complex {
        Complex { real: self.real + other.real, imaginary: self.imaginary + other.imaginary }
    }
}

impl Sub for Complex {
    type Output = Complex;

    fn sub(self, other: Complex) -> Complex {
        self + other * -1.0
    }
}

impl Mul for Complex {
    type Output = Complex;

    fn mul(self, other: Complex) -> Complex {
        Complex {
            real: self.real * other.real - self.imaginary * other.imaginary,
            imaginary: self.real * other.imaginary + self.imaginary * other.real,
        }
    }
}

impl Mul<f64> for Complex {
    type Output = Complex;

    fn mul(self, factor: f64) -> Complex {
        Complex { real: self.real * factor, imaginary: self.imaginary * factor }
    }
}

impl Div for Complex {
    type Output = Complex;

    fn div(self, other: Complex) -> Complex {
        let conjugate = Complex { real: other.real, imaginary: -other.imaginary };
        self * conjugate * (1.0 / (other.real * other.real + other.imaginary * other.imaginary))
    }
}

#[cfg(test)]
mod tests;
