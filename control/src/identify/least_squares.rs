//! Least squares over gain, time constant and dead time.

use super::step::Step;
use super::{Model, error, golden_section, response};
use anyhow::{Context, Result, bail};

/// How many dead times are tried before the best one is improved.
const COARSE: usize = 60;
/// How often the interval around the best dead time is divided.
const FINE: usize = 25;
/// How many samples are compared at most; of more, each n-th.
const MOST_SAMPLES: usize = 10_000;
/// How often the model is improved at most.
const IMPROVEMENTS: usize = 20;
/// The record has to show this part of the answer at least.
const SHOWN: f64 = 0.3;

/// A lag with dead time.
///
/// From `T y'(t) + y(t) = K u(t - L)`, integrated from the step on: `y = -Y/T + (K/T) U(t - L)`, where Y and U are the integrals.
/// Noise is in y alone, which stands on the left: the solution is hardly biased by it.
pub(super) fn lag(step: &Step) -> Result<Model> {
    let samples = Samples::of(step);
    let longest = longest_dead_time(step);
    let missed =
        |dead_time: f64| samples.solve(step, dead_time).map_or(f64::INFINITY, |model| samples.error(step, &model));
    let dead_time = search(longest, missed);
    let model = samples.solve(step, dead_time).context(
        "no lag with dead time fits this record: the plant may integrate, or the record has more than a step in it",
    )?;
    Ok(improved(&samples, step, model))
}

/// An integrator with dead time: `y = k' U(t - L)`.
pub(super) fn integrating(step: &Step) -> Result<Model> {
    let samples = Samples::of(step);
    let solve = |dead_time: f64| {
        let inputs: Vec<f64> =
            samples.places.iter().map(|at| input_integral(step, step.times[*at] - dead_time)).collect();
        let values = samples.places.iter().map(|at| step.values[*at]);
        let product: f64 = inputs.iter().zip(values).map(|(input, value)| input * value).sum();
        let square: f64 = inputs.iter().map(|input| input * input).sum();
        Model { gain: product / square, dead_time, is_integrating: true, ..Model::default() }
    };
    let missed = |dead_time: f64| samples.error(step, &solve(dead_time));
    Ok(solve(search(0.9 * step.duration(), missed)))
}

/// What to say of a record that ends before the answer does.
///
/// # Errors
/// It ends so early that the model is a guess.
pub(super) fn completeness(step: &Step, model: &Model) -> Result<Option<String>> {
    let shown = -libm::expm1(-(step.duration() - model.dead_time).max(0.0) / model.time_constant);
    let percent = shown * 100.0;
    if shown < SHOWN {
        bail!(
            "the record is too short: it shows {percent:.0} % of the answer that the model expects (time constant {:.4} s), and {:.0} % \
             is the least: record longer, or choose an integrating plant",
            model.time_constant,
            SHOWN * 100.0
        );
    }
    let is_short = shown < 0.8;
    Ok(is_short.then(|| {
        format!("The record shows only {percent:.0} % of the answer that the model expects: gain and time constant are uncertain.")
    }))
}

/// The longest dead time that can be: when the answer is well under way.
fn longest_dead_time(step: &Step) -> f64 {
    step.reaches(0.5).unwrap_or(step.duration()).max(step.interval())
}

/// The dead time for which a model misses least.
fn search(longest: f64, mut missed: impl FnMut(f64) -> f64) -> f64 {
    let width = longest / COARSE as f64;
    let best = (0..=COARSE).map(|at| (at, missed(at as f64 * width))).min_by(|(_, a), (_, b)| a.total_cmp(b));
    let best = best.map_or(0, |(at, _)| at) as f64 * width;
    let found = golden_section((best - width).max(0.0), (best + width).min(longest), FINE, &mut missed);
    // A plant without dead time lies at the edge.
    if missed(0.0) <= missed(found) { 0.0 } else { found }
}

/// Which samples are compared, with the integral of the answer up to each of them.
struct Samples {
    places: Vec<usize>,
    integrals: Vec<f64>,
    /// A step of these samples alone.
    thinned: Option<Step>,
}

impl Samples {
    fn of(step: &Step) -> Samples {
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

    fn error(&self, step: &Step, model: &Model) -> f64 {
        let step = self.thinned.as_ref().unwrap_or(step);
        error(step, &response(step, model))
    }

    /// Gain and time constant for a dead time.
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

/// The integral of the input, from the step to a time.
fn input_integral(step: &Step, to: f64) -> f64 {
    let mut sum = 0.0;
    for (at, (from, input)) in step.moves.iter().enumerate() {
        let end = step.moves.get(at + 1).map_or(to, |(next, _)| next.min(to));
        sum += input * (end - from).max(0.0);
    }
    sum
}

/// Gauss and Newton over gain, time constant and dead time, as far as the model gets better.
fn improved(samples: &Samples, step: &Step, model: Model) -> Model {
    let of_samples = samples.thinned.as_ref().unwrap_or(step);
    let mut best = (samples.error(step, &model), model);
    let mut damping = 1e-6;
    for _ in 0..IMPROVEMENTS {
        let Some(next) = newton(of_samples, &best.1, damping) else { break };
        let missed = samples.error(step, &next);
        if missed < best.0 {
            let gained = best.0 - missed;
            best = (missed, next);
            damping /= 10.0;
            if gained < 1e-9 * missed {
                break;
            }
        } else {
            damping = (damping * 100.0).max(1e-6);
            if damping > 1e6 {
                break;
            }
        }
    }
    best.1
}

/// One step of Gauss and Newton with damping; none if it leads nowhere.
fn newton(step: &Step, model: &Model, damping: f64) -> Option<Model> {
    let base = response(step, model);
    let sizes = [1e-5 * model.gain.abs(), 1e-5 * model.time_constant, 1e-5 * (model.time_constant + model.dead_time)];
    let changed = |parameter: usize, by: f64| match parameter {
        0 => Model { gain: model.gain + by, ..*model },
        1 => Model { time_constant: model.time_constant + by, ..*model },
        _ => Model { dead_time: model.dead_time + by, ..*model },
    };
    let slopes: [Vec<f64>; 3] = [0, 1, 2].map(|parameter| {
        let response = response(step, &changed(parameter, sizes[parameter]));
        response.iter().zip(&base).map(|(new, old)| new - old).collect()
    });
    let missed: Vec<f64> = step.values.iter().zip(&base).map(|(is, model)| is - model).collect();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut matrix = [[0.0; 4]; 3];
    for (row, equation) in matrix.iter_mut().enumerate() {
        for (column, slope) in slopes.iter().enumerate() {
            equation[column] = product(&slopes[row], slope);
        }
        equation[row] *= 1.0 + damping;
        equation[3] = product(&slopes[row], &missed);
    }
    let by = solved(matrix)?;
    let next = Model {
        gain: model.gain + by[0] * sizes[0],
        time_constant: model.time_constant + by[1] * sizes[1],
        dead_time: (model.dead_time + by[2] * sizes[2]).max(0.0),
        ..*model
    };
    (next.time_constant > 0.0 && next.gain.is_finite() && next.dead_time.is_finite()).then_some(next)
}

/// Three linear equations.
fn solved(mut matrix: [[f64; 4]; 3]) -> Option<[f64; 3]> {
    for column in 0..3 {
        let pivot = (column..3).max_by(|a, b| matrix[*a][column].abs().total_cmp(&matrix[*b][column].abs()))?;
        matrix.swap(column, pivot);
        if matrix[column][column] == 0.0 {
            return None;
        }
        let equation = matrix[column];
        for (row, other) in matrix.iter_mut().enumerate() {
            if row != column {
                let factor = other[column] / equation[column];
                for (value, pivot) in other.iter_mut().zip(equation) {
                    *value -= factor * pivot;
                }
            }
        }
    }
    let [a, b, c] = matrix;
    Some([a[3] / a[0], b[3] / b[1], c[3] / c[2]])
}
