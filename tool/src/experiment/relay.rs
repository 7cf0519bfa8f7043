//! The relay test: finds the gain and period at which a P action alone would make the loop oscillate.
//!
//! A relay finds them only approximately: its hysteresis, needed against noise, and the harmonics of its square wave
//! shift the result. Therefore, square waves of fixed periods follow: the first harmonics of manipulated value and
//! process value yield gain and phase of the sampled plant exactly, and both are interpolated between the two periods
//! whose phases enclose -180 degrees.

use super::{Bench, FIRST, REST, RelayTest, half, mean, noise};
use anyhow::{Result, bail, ensure};
use std::f64::consts::{PI, TAU};

/// The number of periods of the relay's oscillation; the last one is measured.
const PERIODS: usize = 3;
/// The maximum number of square waves tried.
const WAVES: usize = 8;
/// The number of periods of a square wave before measurement starts.
const PASSED: usize = 2;
/// The number of measured periods: the minimum, and the maximum in the presence of noise.
const MEASURED: std::ops::RangeInclusive<usize> = 3..=30;
/// The allowed noise in the first harmonic, as a fraction of it.
const CLEAR: f64 = 0.01;
/// A phase counts as -180 degrees if it is this close, in radians.
const NEAR: f64 = 0.05;
/// The shortest period considered, in calls: shorter ones are caused by the sampling rather than by the plant.
const SHORTEST: usize = 4;

/// The result of the test.
pub(super) struct Found {
    pub gain: f64,
    pub period: f64,
    pub swing: f64,
    pub hysteresis: f64,
    pub remarks: Vec<String>,
}

/// The plant's gain and phase for a square wave of this period in calls. The phase is from -2 pi to 0, with the sign of
/// the plant's gain taken out.
struct Response {
    period: usize,
    gain: f64,
    phase: f64,
}

/// Tests a held plant.
pub(super) fn held(bench: &mut Bench, request: &RelayTest) -> Result<Found> {
    let amplitude = request.amplitude;
    ensure!(
        !bench.has_pulses(),
        "a relay test needs a manual value, but the controller has only manual pulses: run a step test instead"
    );
    bench.settle(REST, |_| true)?;
    let before = bench.process_value()?;
    let noise = noise(&before[before.len() / 2..]);
    let level = mean(&before[before.len() * 2 / 3..]);
    for way in [amplitude, -amplitude] {
        ensure!(
            bench.is_within(way)?,
            "the manipulated value is {}, and a step of {amplitude} up or down would exceed its limits: choose a \
             smaller amplitude, or first move the manipulated value to the middle of its range",
            bench.output
        );
    }
    let hysteresis = request.hysteresis.unwrap_or(4.0 * noise);
    ensure!(hysteresis >= 0.0 && hysteresis.is_finite(), "the hysteresis is {hysteresis}: it must be 0 or more");
    let (swing, sign, moved, found) = oscillate(bench, amplitude, level, hysteresis)?;
    let mut remarks = Vec::new();
    if moved < 0.99 * amplitude {
        remarks.push(format!("The manipulated value moved by only {moved}: it is at a limit."));
    }
    let mut responses: Vec<Response> = Vec::new();
    let mut period = found.max(SHORTEST);
    for _ in 0..WAVES {
        let response = wave(bench, amplitude, period, noise, sign)?;
        let phase = response.phase;
        responses.push(response);
        responses.sort_by_key(|response| response.period);
        // A longer period has less phase lag. The next period to try is where the phase crosses -180 degrees between
        // two tried periods; if it does not, a shorter or a longer one.
        let next = match responses.iter().position(|response| response.phase > -PI) {
            Some(0) => (period as f64 * (-phase / PI).clamp(0.5, 0.95)).floor() as usize,
            None => (period as f64 * (-phase / PI).clamp(1.05, 2.0)).ceil() as usize,
            Some(at) => ultimate_period(&responses[at - 1], &responses[at]).round() as usize,
        };
        let next = next.max(SHORTEST);
        if responses.iter().any(|response| response.period == next)
            || (responses.len() > 1 && (phase + PI).abs() < NEAR)
        {
            break;
        }
        period = next;
    }
    bench.put(0.0)?;
    let between = responses.iter().position(|response| response.phase > -PI).filter(|at| *at > 0);
    // If only phases on one side of -180 degrees were found, but one is near it, extrapolates from two periods.
    let beyond = || {
        let last = responses.len().checked_sub(1).filter(|last| *last > 0)?;
        let at = if responses[0].phase > -PI { 1 } else { last };
        responses[at - 1..=at].iter().any(|response| (response.phase + PI).abs() < NEAR).then_some(at)
    };
    let Some(at) = between.or_else(beyond) else {
        let step = bench.session.record(None)?.step();
        bail!(
            "no ultimate period found between {} s and {} s: the plant has too little dead time for calls every \
             {step} s, or there is too much noise; run a step test instead",
            responses.first().map_or(0.0, |response| response.period as f64 * step),
            responses.last().map_or(0.0, |response| response.period as f64 * step)
        );
    };
    let (short, long) = (&responses[at - 1], &responses[at]);
    let calls = ultimate_period(short, long);
    let part = (calls / short.period as f64).ln() / (long.period as f64 / short.period as f64).ln();
    let gain = short.gain.abs().ln() * (1.0 - part) + long.gain.abs().ln() * part;
    let period = calls * bench.session.record(None)?.step();
    Ok(Found { gain: sign / gain.exp(), period, swing, hysteresis, remarks })
}

/// The period in calls at which the phase is -180 degrees, interpolated between two periods.
fn ultimate_period(short: &Response, long: &Response) -> f64 {
    let part = (-PI - short.phase) / (long.phase - short.phase);
    short.period as f64 * (long.period as f64 / short.period as f64).powf(part)
}

/// Lets the loop oscillate under relay control; returns the amplitude of the process value, the sign of the plant's
/// gain, the amplitude of the manipulated value, and the period in calls.
fn oscillate(bench: &mut Bench, amplitude: f64, level: f64, hysteresis: f64) -> Result<(f64, f64, f64, usize)> {
    let mut is_up = true;
    bench.put(amplitude)?;
    // The sign of the plant's gain: the direction of the response to the first step.
    let (mut sign, mut rises, mut waited, mut before) = (0.0, Vec::new(), 0, 0.0);
    let mut from = bench.next_time()?;
    while rises.len() <= PERIODS {
        bench.run(1)?;
        waited += 1;
        bench.check_patience(waited, "does not oscillate: choose a larger amplitude")?;
        let off = bench.value(&bench.process_value_name.clone())? - level;
        // The threshold must be exceeded twice in a row: noise exceeds four times its standard deviation once in
        // several thousand calls.
        if sign == 0.0 && off.abs().min(before * off.signum()) > hysteresis + 1e-9 {
            sign = off.signum();
        }
        before = off;
        let goes = match sign * off {
            off if off > hysteresis && is_up => false,
            off if off < -hysteresis && !is_up => true,
            _ => continue,
        };
        if goes {
            from = if rises.len() == PERIODS { from } else { bench.next_time()? };
            rises.push(waited);
        }
        is_up = goes;
        bench.put(if goes { amplitude } else { -amplitude })?;
    }
    let recorded = bench.signals(from)?;
    Ok((half(&recorded.process_value), sign, half(&recorded.manipulated_value), rises[PERIODS] - rises[PERIODS - 1]))
}

/// Drives the plant with a square wave of this period in calls, and measures its response.
fn wave(bench: &mut Bench, amplitude: f64, period: usize, noise: f64, sign: f64) -> Result<Response> {
    let drive = |bench: &mut Bench, periods: usize| -> Result<()> {
        for _ in 0..periods {
            for (way, calls) in [(amplitude, period.div_ceil(2)), (-amplitude, period / 2)] {
                bench.put(way)?;
                bench.run(calls)?;
            }
        }
        Ok(())
    };
    // Wait long enough even if the dead time spans many periods.
    drive(bench, PASSED.max(FIRST.div_ceil(period)))?;
    let from = bench.next_time()?;
    drive(bench, *MEASURED.start())?;
    let first = harmonic(&bench.signals(from)?.process_value, period).0;
    let wanted = (noise / (CLEAR * first.max(f64::MIN_POSITIVE))).powi(2) * 2.0 / period as f64;
    let more = (wanted.min(*MEASURED.end() as f64).ceil() as usize).saturating_sub(*MEASURED.start());
    drive(bench, more)?;
    let recorded = bench.signals(from)?;
    let (swing, phase) = harmonic(&recorded.process_value, period);
    let (moved, moved_phase) = harmonic(&recorded.manipulated_value, period);
    ensure!(swing > 0.0 && moved > 0.0, "the process value does not oscillate: choose a larger amplitude");
    let turned = if sign < 0.0 { PI } else { 0.0 };
    // From -2 pi to 0.
    let lag = (phase - moved_phase - turned).rem_euclid(TAU) - TAU;
    Ok(Response { period, gain: swing / moved, phase: lag })
}

/// Amplitude and phase of the first harmonic over the last whole periods, with the drift subtracted.
fn harmonic(values: &[f64], period: usize) -> (f64, f64) {
    let count = values.len() / period * period;
    let values = &values[values.len() - count..];
    let drift = (mean(&values[count - period..]) - mean(&values[..period])) / (count - period).max(1) as f64;
    let (mut real, mut imaginary) = (0.0, 0.0);
    for (at, value) in values.iter().enumerate() {
        let angle = TAU * (at % period) as f64 / period as f64;
        let value = value - drift * at as f64;
        real += value * angle.cos();
        imaginary -= value * angle.sin();
    }
    (real.hypot(imaginary) * 2.0 / count as f64, imaginary.atan2(real))
}
