//! The axes that cause a figure's variance: Sobol indices, from a study with `sampling = "saltelli"`.
//!
//! The *first-order index* of an axis is the share of the variance that its value alone explains. The *total index*
//! adds the effects of its interactions with other axes: where it exceeds the first-order index, the axes interact,
//! which a rank correlation does not show.
//!
//! The runs follow A. Saltelli and others, "Variance based sensitivity analysis of model output. Design and estimator
//! for the total sensitivity index", Computer Physics Communications 181 (2010), pages 259 to 270. With d axes, each
//! base sample has d + 2 runs: A, then for each axis A with the axis' value of B, then B. The estimators are (b) and
//! (f) in its table 2; (f) is due to M. J. W. Jansen (1999).

use crate::results::Results;
use anyhow::Result;
use serde::Serialize;

/// The half-width of a 95 % confidence interval, in standard deviations.
const NORMAL: f64 = 1.96;

/// The Sobol indices of an axis for a figure.
#[derive(Clone, Copy, Debug, Default, Serialize, PartialEq)]
pub struct Index {
    /// The share of the variance explained by this axis alone, from 0 to 1; the estimate may lie slightly outside.
    pub first: f64,
    /// The half-width of the 95 % confidence interval of `first`.
    pub first_error: f64,
    /// The share of the variance explained by this axis and its interactions with other axes.
    pub total: f64,
    /// The half-width of the 95 % confidence interval of `total`.
    pub total_error: f64,
}

/// The number of runs per base sample.
pub fn runs_of_sample(axes: usize) -> u64 {
    axes as u64 + 2
}

/// The indices of each axis for a figure, by the figure's column index; `None` if the figure does not vary, if it is
/// missing or infinite in any run, or if there are fewer than two samples. `axes` is the number of axes with a
/// distribution.
///
/// # Errors
/// The results of a large study cannot be read.
pub fn indices(results: &Results, figure: usize, axes: usize) -> Result<Option<Vec<Index>>> {
    Ok(of_values(&results.figure(figure)?, axes))
}

fn of_values(values: &[f64], axes: usize) -> Option<Vec<Index>> {
    let width = runs_of_sample(axes) as usize;
    let samples: Vec<&[f64]> = values.chunks_exact(width).collect();
    if axes == 0 || samples.len() < 2 || values.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let count = samples.len() as f64;
    let mean = samples.iter().map(|of| of[0] + of[width - 1]).sum::<f64>() / (2.0 * count);
    // The contribution of a sample to the variance.
    let spread = |of: &[f64]| ((of[0] - mean).powi(2) + (of[width - 1] - mean).powi(2)) / 2.0;
    let variance = samples.iter().map(|of| spread(of)).sum::<f64>() / count;
    if variance <= 0.0 || !variance.is_finite() {
        return None;
    }
    // A ratio of two means, with its standard error (W. G. Cochran, "Sampling Techniques", 3rd edition, 1977, section
    // 6.4).
    let ratio = |part: &dyn Fn(&[f64]) -> f64| {
        let ratio = samples.iter().map(|of| part(of)).sum::<f64>() / count / variance;
        let square = samples.iter().map(|of| (part(of) - ratio * spread(of)).powi(2)).sum::<f64>() / (count - 1.0);
        (ratio, NORMAL * (square / count).sqrt() / variance)
    };
    let index = |axis: usize| {
        let (first, first_error) = ratio(&|of| (of[width - 1] - mean) * (of[axis + 1] - of[0]));
        let (total, total_error) = ratio(&|of| (of[0] - of[axis + 1]).powi(2) / 2.0);
        Index { first, first_error, total, total_error }
    };
    Some((0..axes).map(index).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sampling;
    use crate::sampling::Sampler;
    use std::f64::consts::PI;

    /// The indices of a function of numbers distributed uniformly from 0 to 1.
    fn of(axes: usize, samples: u64, function: impl Fn(&[f64]) -> f64) -> Vec<Index> {
        let count = samples * runs_of_sample(axes);
        let sampler = Sampler::new(Sampling::Saltelli, 1, count, axes);
        let value = |run| function(&(0..axes).map(|axis| sampler.probability(axis, run)).collect::<Vec<_>>());
        of_values(&(0..count).map(value).collect::<Vec<_>>(), axes).unwrap()
    }

    #[test]
    fn the_indices_of_ishigamis_function_are_the_analytic_ones() {
        let (a, b) = (7.0, 0.1);
        let function = |point: &[f64]| {
            let [x, y, z] = [0, 1, 2].map(|axis| (2.0 * point[axis] - 1.0) * PI);
            x.sin() + a * y.sin().powi(2) + b * z.powi(4) * x.sin()
        };
        let variance = a * a / 8.0 + b * PI.powi(4) / 5.0 + b * b * PI.powi(8) / 18.0 + 0.5;
        let first = [0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2), a * a / 8.0, 0.0].map(|part| part / variance);
        let both = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0) / variance;
        let total = [first[0] + both, first[1], both];
        assert!((first[0] - 0.3139).abs() < 1e-4 && (both - 0.2437).abs() < 1e-4);
        for (axis, index) in of(3, 8192, function).into_iter().enumerate() {
            assert!((index.first - first[axis]).abs() < 0.01, "{axis}: {index:?}");
            assert!((index.total - total[axis]).abs() < 0.01, "{axis}: {index:?}");
            assert!((index.first - first[axis]).abs() < index.first_error && index.first_error < 0.05, "{index:?}");
            assert!((index.total - total[axis]).abs() < index.total_error.max(1e-3), "{index:?}");
        }
    }

    #[test]
    fn a_sum_has_no_interactions_and_a_product_has() {
        // Variances 1/12 and 4/12.
        for (index, expected) in of(2, 4096, |point| point[0] + 2.0 * point[1]).into_iter().zip([0.2, 0.8]) {
            assert!((index.first - expected).abs() < 0.01 && (index.total - expected).abs() < 0.01, "{index:?}");
        }
        // (x - 1/2)(y - 1/2): neither explains anything alone.
        for index in of(2, 4096, |point| (point[0] - 0.5) * (point[1] - 0.5)) {
            assert!(index.first.abs() < 0.05 && (index.total - 1.0).abs() < 0.05, "{index:?}");
        }
    }

    #[test]
    fn the_estimators_can_be_checked_by_hand() {
        // One axis, runs A, A with the axis of B, B: 0 4 4 and 2 2 2. The mean of A and B is 2, the variance (4+4+0+0)/4 = 2.
        // First: ((4-2)(4-0) + 0) / 2 / 2 = 2. Total: ((0-4)^2 + 0) / 2 / 2 / 2 = 2.
        let index = of_values(&[0.0, 4.0, 4.0, 2.0, 2.0, 2.0], 1).unwrap()[0];
        assert_eq!((index.first, index.total), (2.0, 2.0));
        assert_eq!(of_values(&[0.0, f64::NAN, 4.0, 2.0, 2.0, 2.0], 1), None);
        assert_eq!(of_values(&[1.0; 6], 1), None);
    }
}
