//! Refinement of a model by the damped Gauss-Newton method.

use super::step::Step;
use super::{Model, error, response};

/// The maximum number of iterations.
const IMPROVEMENTS: usize = 40;
/// The relative step size for finite differences.
const DIFFERENCE: f64 = 1e-5;

/// The free parameters of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// Gain, time constant, dead time.
    Lag,
    /// Gain, common time constant of both lags, dead time.
    EqualLags,
    /// Gain, sum and product of two time constants, dead time. Unlike the time constants themselves, these cannot swap.
    TwoLags,
    /// Gain of an integrator, time constant of the lag after it, dead time.
    IntegratorAndLag,
}

impl Shape {
    /// Returns the free parameters, with the dead time last.
    fn parameters(self, model: &Model) -> Vec<f64> {
        let Model { gain, time_constant: one, second_time_constant: two, dead_time, .. } = *model;
        match self {
            Shape::Lag => vec![gain, one, dead_time],
            Shape::EqualLags => vec![gain, f64::midpoint(one, two), dead_time],
            Shape::TwoLags => vec![gain, one + two, one * two, dead_time],
            Shape::IntegratorAndLag => vec![gain, two, dead_time],
        }
    }

    /// Returns the model with these parameters; `None` if they are impossible. Complex lags are replaced by equal ones.
    fn model(self, parameters: &[f64]) -> Option<Model> {
        let (gain, dead_time) = (parameters[0], parameters[parameters.len() - 1]);
        let (one, two) = match self {
            Shape::Lag => (parameters[1], 0.0),
            Shape::EqualLags => (parameters[1], parameters[1]),
            Shape::TwoLags => {
                let (half, product) = (parameters[1] / 2.0, parameters[2]);
                let slow = half + (half * half - product).max(0.0).sqrt();
                // Computing `half - sqrt(...)` could subtract nearly equal numbers and lose digits.
                (slow, (product / slow).min(slow))
            }
            Shape::IntegratorAndLag => (0.0, parameters[1]),
        };
        let is_integrating = self == Shape::IntegratorAndLag;
        let model = Model { gain, time_constant: one, second_time_constant: two, dead_time, is_integrating };
        let is_model = (one > 0.0 || is_integrating)
            && two >= 0.0
            && [gain, one, two, dead_time].iter().all(|number| number.is_finite());
        is_model.then_some(model)
    }

    /// Returns the parameter differences for the numerical derivatives. Decreasing the product keeps the lags real.
    fn differences(self, model: &Model) -> Vec<f64> {
        let scale = model.time_constant + model.second_time_constant;
        let mut differences: Vec<f64> = self.parameters(model).iter().map(|value| DIFFERENCE * value).collect();
        if self == Shape::TwoLags {
            differences[2] = -differences[2];
        }
        if let Some(dead_time) = differences.last_mut() {
            *dead_time = DIFFERENCE * (scale + model.dead_time);
        }
        differences
    }
}

/// Returns the model that results from reducing the residual iteratively, starting from `model`.
pub(super) fn improved(step: &Step, shape: Shape, model: Model) -> Model {
    let mut best = (error(step, &response(step, &model)), model);
    let mut damping = 1e-6;
    for _ in 0..IMPROVEMENTS {
        let Some(next) = newton(step, shape, &best.1, damping) else { break };
        let missed = error(step, &response(step, &next));
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

/// Performs one damped step; `None` if the equations are singular or the new parameters are impossible.
fn newton(step: &Step, shape: Shape, model: &Model, damping: f64) -> Option<Model> {
    let base = response(step, model);
    let (parameters, differences) = (shape.parameters(model), shape.differences(model));
    let slope = |at: usize| -> Option<Vec<f64>> {
        let mut changed = parameters.clone();
        changed[at] += differences[at];
        Some(response(step, &shape.model(&changed)?).iter().zip(&base).map(|(new, old)| new - old).collect())
    };
    let slopes: Vec<Vec<f64>> = (0..parameters.len()).map(slope).collect::<Option<_>>()?;
    let missed: Vec<f64> = step.values.iter().zip(&base).map(|(is, model)| is - model).collect();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut matrix: Vec<Vec<f64>> = slopes
        .iter()
        .enumerate()
        .map(|(row, own)| {
            let mut equation: Vec<f64> = slopes.iter().map(|slope| product(own, slope)).collect();
            equation[row] *= 1.0 + damping;
            equation.push(product(own, &missed));
            equation
        })
        .collect();
    let last = parameters.len() - 1;
    let moved = |by: &[f64]| -> Vec<f64> {
        parameters.iter().zip(by).zip(&differences).map(|((value, by), size)| value + by * size).collect()
    };
    let mut next = moved(&solved(matrix.clone())?);
    if next[last] < 0.0 {
        // The best step among models without dead time.
        matrix[last].fill(0.0);
        (matrix[last][last], matrix[last][last + 1]) = (1.0, -parameters[last] / differences[last]);
        next = moved(&solved(matrix)?);
        next[last] = 0.0;
    }
    shape.model(&next)
}

/// Solves linear equations, each with its right-hand side as the last number; `None` if the matrix is singular.
fn solved(mut matrix: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let count = matrix.len();
    for column in 0..count {
        let pivot = (column..count).max_by(|a, b| matrix[*a][column].abs().total_cmp(&matrix[*b][column].abs()))?;
        matrix.swap(column, pivot);
        if matrix[column][column] == 0.0 {
            return None;
        }
        let equation = matrix[column].clone();
        for (row, other) in matrix.iter_mut().enumerate() {
            if row != column {
                let factor = other[column] / equation[column];
                for (value, pivot) in other.iter_mut().zip(&equation) {
                    *value -= factor * pivot;
                }
            }
        }
    }
    Some(matrix.iter().enumerate().map(|(at, equation)| equation[count] / equation[at]).collect())
}
