//! Least squares over gain, one or two lags, and dead time.

use super::gauss_newton::{Shape, improved};
use super::step::{Step, resolution};
use super::{Model, error, golden_section, response};
use crate::process::Process;
use anyhow::{Context, Result, bail};

/// The number of intervals between the dead times tried before the best one is refined.
const COARSE: usize = 60;
/// The number of divisions of the interval around the best dead time.
const FINE: usize = 25;
/// The maximum number of samples compared; a longer record is decimated.
const MOST_SAMPLES: usize = 10_000;
/// The minimum fraction of the response that the record must contain.
const SHOWN: f64 = 0.3;
/// The ratios of the faster lag to the slower one at which the search for two lags starts.
const RATIOS: [f64; 4] = [0.05, 0.2, 0.5, 1.0];
/// The initial lags in the search for a lag after an integrator, as fractions of the dead time found without a lag.
const PARTS: [f64; 4] = [0.1, 0.4, 0.7, 0.95];
/// The minimum reduction of the sum of squares by a second lag, as a multiple of the variance of an independent sample.
/// A superfluous parameter reduces it by one variance on average because of noise, and by 20 or more in about one of
/// 100,000 records.
const BEYOND_NOISE: f64 = 20.0;
/// The fraction of the response below which residuals do not justify another lag.
const MISSED: f64 = 1e-5;

/// Fits one or two lags with dead time: two only if the second reduces the residual by more than noise and resolution
/// can explain.
pub(super) fn lags(step: &Step) -> Result<Model> {
    let samples = Samples::new(step);
    let one = lag(&samples, step)?;
    Ok(with_second_lag(&samples, step, &one).unwrap_or(one))
}

/// Fits a lag with dead time.
///
/// From `T y'(t) + y(t) = K u(t - L)`, integrated from the step onward: `y = -Y/T + (K/T) U(t - L)`, where Y and U are
/// the integrals. Noise mainly affects y on the left-hand side, so it hardly biases the solution.
fn lag(samples: &Samples, step: &Step) -> Result<Model> {
    let longest = longest_dead_time(step);
    let missed =
        |dead_time: f64| samples.solve(step, dead_time).map_or(f64::INFINITY, |model| samples.error(step, &model));
    let dead_time = search(longest, missed);
    let model = samples.solve(step, dead_time).context(
        "no lag with dead time fits this record: the plant may be integrating, or the record contains more than \
         one step",
    )?;
    Ok(improved(samples.compared(step), Shape::Lag, model))
}

/// Returns the best model with two lags, if the data support the second one.
fn with_second_lag(samples: &Samples, step: &Step, one: &Model) -> Option<Model> {
    let compared = samples.compared(step);
    // The half rule reversed: the single lag is the slower one of the two plus half of the faster one, and its dead
    // time contains the other half.
    let start = |ratio: f64| {
        let slow = one.time_constant / (1.0 + ratio / 2.0);
        let dead_time = (one.dead_time - ratio * slow / 2.0).max(0.0);
        Model { time_constant: slow, second_time_constant: ratio * slow, dead_time, ..*one }
    };
    let begin = best(compared, RATIOS.map(start))?;
    // Where the best pair of lags is complex, the best real pair consists of equal lags.
    let apart = improved(compared, Shape::TwoLags, begin);
    let equal = improved(compared, Shape::EqualLags, start(1.0));
    best(compared, [apart, equal]).filter(|two| is_shown(compared, one, two))
}

/// Returns the model with the smallest residual.
fn best(step: &Step, models: impl IntoIterator<Item = Model>) -> Option<Model> {
    let missed = |model: &Model| error(step, &response(step, model));
    models.into_iter().min_by(|a, b| missed(a).total_cmp(&missed(b)))
}

/// Whether the data support the second lag of a model: it is at least one sampling interval long and reduces the
/// residual enough.
fn is_shown(step: &Step, one: &Model, two: &Model) -> bool {
    two.second_time_constant >= step.interval() && explains_more(step, one, two)
}

/// Whether the model with more parameters reduces the residual by more than noise and resolution can explain.
fn explains_more(step: &Step, few: &Model, many: &Model) -> bool {
    let missed = |model: &Model| -> Vec<f64> {
        response(step, model).iter().zip(&step.values).map(|(model, is)| is - model).collect()
    };
    let squares = |missed: &[f64]| missed.iter().map(|value| value * value).sum::<f64>();
    let (of_few, of_many) = (missed(few), missed(many));
    let count = step.values.len() as f64;
    let rounding = resolution(&step.values) / 12.0_f64.sqrt();
    let smallest = [step.noise, rounding, MISSED * step.end().abs()].into_iter().fold(0.0, f64::max);
    let variance = (squares(&of_many) / count).max(smallest * smallest);
    squares(&of_few) - squares(&of_many) > BEYOND_NOISE * variance * memory(&of_many)
}

/// Returns the correlation length of the residuals in samples: 1 for white noise, more for drift and for a value that
/// stays within one count.
fn memory(missed: &[f64]) -> f64 {
    let square: f64 = missed.iter().map(|value| value * value).sum();
    if square == 0.0 {
        return 1.0;
    }
    let correlation = |lag: usize| missed.iter().zip(&missed[lag..]).map(|(a, b)| a * b).sum::<f64>() / square;
    1.0 + 2.0 * (1..missed.len() / 4).map(correlation).take_while(|part| *part > 0.05).sum::<f64>()
}

/// Fits an integrator with dead time, `y = k' U(t - L)`, and adds a lag if that reduces the residual by more than noise
/// and resolution can explain.
pub(super) fn integrating(step: &Step) -> Result<Model> {
    let samples = Samples::new(step);
    let solve = |dead_time: f64| {
        let inputs: Vec<f64> =
            samples.places.iter().map(|at| input_integral(step, step.times[*at] - dead_time)).collect();
        let values = samples.places.iter().map(|at| step.values[*at]);
        let product: f64 = inputs.iter().zip(values).map(|(input, value)| input * value).sum();
        let square: f64 = inputs.iter().map(|input| input * input).sum();
        Model { gain: product / square, dead_time, is_integrating: true, ..Model::default() }
    };
    let missed = |dead_time: f64| samples.error(step, &solve(dead_time));
    let one = solve(search(0.9 * step.duration(), missed));
    let compared = samples.compared(step);
    // A lag delays a ramp by its time constant.
    let start = |part: f64| Model {
        second_time_constant: part * one.dead_time,
        dead_time: (1.0 - part) * one.dead_time,
        ..one
    };
    let two = best(compared, PARTS.map(start)).map(|begin| improved(compared, Shape::IntegratorAndLag, begin));
    Ok(two.filter(|two| is_shown(compared, &one, two)).unwrap_or(one))
}

/// Returns a remark if the record shows less than 80 % of the response that the model predicts.
///
/// # Errors
/// The record shows less than [`SHOWN`] of that response, so the model would be a guess.
pub(super) fn completeness(step: &Step, model: &Model) -> Result<Option<String>> {
    let mut process = Process::at_rest(Model { gain: 1.0, ..*model }, 0.0);
    process.put(0.0, 1.0);
    let shown = process.output_at(step.duration());
    let percent = shown * 100.0;
    if shown < SHOWN {
        bail!(
            "the record is too short: it shows {percent:.0} % of the response that the model predicts (time constant \
             {:.4} s); at least {:.0} % is required: record longer, or choose an integrating plant",
            model.time_constant,
            SHOWN * 100.0
        );
    }
    let is_short = shown < 0.8;
    Ok(is_short.then(|| {
        format!("The record shows only {percent:.0} % of the response that the model predicts: gain and time constant are uncertain.")
    }))
}

/// Returns the maximum plausible dead time: the time at which half of the response is reached.
fn longest_dead_time(step: &Step) -> f64 {
    step.reaches(0.5).unwrap_or(step.duration()).max(step.interval())
}

/// Returns the dead time with the smallest residual.
fn search(longest: f64, mut missed: impl FnMut(f64) -> f64) -> f64 {
    let width = longest / COARSE as f64;
    let best = (0..=COARSE).map(|at| (at, missed(at as f64 * width))).min_by(|(_, a), (_, b)| a.total_cmp(b));
    let best = best.map_or(0, |(at, _)| at) as f64 * width;
    let found = golden_section((best - width).max(0.0), (best + width).min(longest), FINE, &mut missed);
    // For a plant without dead time, the optimum is at the edge of the interval.
    if missed(0.0) <= missed(found) { 0.0 } else { found }
}

/// The samples to compare, with the integral of the response up to each of them.
struct Samples {
    places: Vec<usize>,
    integrals: Vec<f64>,
    /// The step with only these samples; `None` if these are all.
    thinned: Option<Step>,
}

impl Samples {
    fn new(step: &Step) -> Samples {
        let stride = step.times.len().div_ceil(MOST_SAMPLES).max(1);
        let (mut places, mut integrals, mut sum) = (Vec::new(), Vec::new(), 0.0);
        for at in 0..step.times.len() {
            if at > 0 {
                sum += f64::midpoint(step.values[at - 1], step.values[at]) * (step.times[at] - step.times[at - 1]);
            }
            if at % stride == 0 {
                places.push(at);
                integrals.push(sum);
            }
        }
        let pick = |values: &[f64]| places.iter().map(|at| values[*at]).collect();
        let thinned =
            (stride > 1).then(|| Step { times: pick(&step.times), values: pick(&step.values), ..step.clone() });
        Samples { places, integrals, thinned }
    }

    /// Returns the step with the compared samples.
    fn compared<'a>(&'a self, step: &'a Step) -> &'a Step {
        self.thinned.as_ref().unwrap_or(step)
    }

    fn error(&self, step: &Step, model: &Model) -> f64 {
        let step = self.compared(step);
        error(step, &response(step, model))
    }

    /// Returns the model with the best gain and time constant for a dead time; `None` if no lag fits.
    fn solve(&self, step: &Step, dead_time: f64) -> Option<Model> {
        // The normal equations of y = a (-Y) + b U.
        let (mut yy, mut yu, mut uu, mut ry, mut ru) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (at, integral) in self.places.iter().zip(&self.integrals) {
            let (value, input) = (step.values[*at], input_integral(step, step.times[*at] - dead_time));
            yy += integral * integral;
            yu -= integral * input;
            uu += input * input;
            ry -= integral * value;
            ru += input * value;
        }
        let determinant = yy * uu - yu * yu;
        let (a, b) = ((ry * uu - ru * yu) / determinant, (ru * yy - ry * yu) / determinant);
        let model = Model { gain: b / a, time_constant: 1.0 / a, dead_time, ..Model::default() };
        (a > 0.0 && a.is_finite() && b.is_finite() && b != 0.0).then_some(model)
    }
}

/// Returns the integral of the input from the step to a time.
fn input_integral(step: &Step, to: f64) -> f64 {
    let mut sum = 0.0;
    for (at, (from, input)) in step.moves.iter().enumerate() {
        let end = step.moves.get(at + 1).map_or(to, |(next, _)| next.min(to));
        sum += input * (end - from).max(0.0);
    }
    sum
}
