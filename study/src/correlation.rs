//! Rank correlations between distributions.
//!
//! The probabilities of all axes are mapped to standard normal numbers, mixed so that these correlate, and mapped back
//! to probabilities: each axis keeps its distribution, of whatever kind. For a rank correlation s, the normal numbers
//! have the correlation 2 sin(pi s / 6) (W. H. Kruskal, "Ordinal measures of association", Journal of the American
//! Statistical Association 53, 1958). The mixing matrix is the Cholesky factor, so that an axis depends only on those
//! before it.

use crate::distribution::{Distribution, normal_quantile, normal_share};
use crate::sampling::LEAST_PROBABILITY;
use crate::{Correlation, Study};
use anyhow::{Context, Result, bail, ensure};
use libm::sin;
use run::subject::About;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// The rows of the mixing matrix, one for each distribution; empty if all are independent.
///
/// # Errors
/// A correlation names a variable without a distribution or has an invalid rank, or the correlations contradict each
/// other.
pub(super) fn mixing(study: &Study) -> Result<Vec<Vec<f64>>> {
    if study.correlations.is_empty() {
        return Ok(Vec::new());
    }
    let drawn: Vec<_> = study.axes.iter().filter(|axis| Distribution::new(&axis.along).is_some()).collect();
    let find = |of: &Correlation, name: &String| {
        let found = drawn.iter().position(|axis| axis.variables.contains(name));
        found.with_context(|| {
            let names = of.variables.join(" and ");
            format!(
                "correlations: {names}: no axis has a distribution for {name}: use a variable of an axis that has one"
            )
        })
    };
    let mut matrix: Vec<Vec<f64>> = (0..drawn.len())
        .map(|row| (0..drawn.len()).map(|column| f64::from(u8::from(row == column))).collect())
        .collect();
    let mut pairs = BTreeSet::new();
    for (number, of) in study.correlations.iter().enumerate() {
        let mut add = || {
            let [first, second] = [find(of, &of.variables[0])?, find(of, &of.variables[1])?];
            let names = of.variables.join(" and ");
            ensure!(
                first != second,
                "correlations: {names} belong to the same axis: use variables of two different axes"
            );
            ensure!(
                of.rank > -1.0 && of.rank < 1.0,
                "correlations: {names}: rank = {:?}: use a number above -1 and below 1",
                of.rank
            );
            ensure!(
                pairs.insert((first.min(second), first.max(second))),
                "correlations: {names}: their axes already have a correlation: keep only one of the two"
            );
            let normal = 2.0 * sin(PI * of.rank / 6.0);
            (matrix[first][second], matrix[second][first]) = (normal, normal);
            Ok(())
        };
        add().at(number).at("correlations")?;
    }
    cholesky(&matrix)
        .context(
            "correlations: they contradict each other: use values closer to 0, or add the missing correlations \
             between their axes",
        )
        .at("correlations")
}

/// The lower triangular Cholesky factor of a symmetric matrix; an error if it is not positive definite.
fn cholesky(matrix: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
    let mut factor: Vec<Vec<f64>> = Vec::new();
    for row in matrix {
        let mut own: Vec<f64> = Vec::new();
        for column in 0..factor.len() {
            let sum: f64 = (0..column).map(|place| own[place] * factor[column][place]).sum();
            own.push((row[column] - sum) / factor[column][column]);
        }
        let rest = row[factor.len()] - own.iter().map(|value| value * value).sum::<f64>();
        if rest <= 1e-12 {
            bail!("the matrix is not positive definite");
        }
        own.push(rest.sqrt());
        factor.push(own);
    }
    Ok(factor)
}

/// The probability of one distribution, mixed from the independent probabilities of all.
pub(super) fn probability(mixing: &[Vec<f64>], number: usize, own: impl Fn(usize) -> f64) -> f64 {
    let Some(row) = mixing.get(number).filter(|row| row[..number].iter().any(|factor| *factor != 0.0)) else {
        return own(number);
    };
    let normal: f64 = row.iter().enumerate().map(|(other, factor)| factor * normal_quantile(own(other))).sum();
    normal_share(normal).clamp(LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Sampler;
    use crate::{Along, Axis, Sampling};

    fn study(pairs: &[(usize, usize, f64)]) -> Study {
        let axis = |name: &&str| Axis {
            variables: vec![(*name).to_string()],
            along: Along::Uniform { min: 0.0, max: 1.0 },
            ..Axis::default()
        };
        let names = ["P.A", "P.B", "P.C"];
        let correlation = |(one, other, rank): &(usize, usize, f64)| Correlation {
            variables: [names[*one].into(), names[*other].into()],
            rank: *rank,
        };
        Study {
            axes: names.iter().map(axis).collect(),
            correlations: pairs.iter().map(correlation).collect(),
            ..Study::default()
        }
    }

    #[test]
    fn axes_have_the_rank_correlation_that_is_asked_for_and_keep_their_distributions() {
        let mixing = mixing(&study(&[(0, 2, 0.7), (1, 2, -0.3)])).unwrap();
        let count = 20_000;
        let sampler = Sampler::new(Sampling::Random, 5, count, 3);
        let sample = |axis: usize| -> Vec<f64> {
            let own = |run| probability(&mixing, axis, |axis| sampler.probability(axis, run));
            (0..count).map(own).collect()
        };
        let [a, b, c] = [sample(0), sample(1), sample(2)];
        // For uniform numbers, the rank correlation equals the correlation: 12 times the mean product of the deviations
        // from 1/2.
        let rank = |x: &[f64], y: &[f64]| {
            12.0 * x.iter().zip(y).map(|(x, y)| (x - 0.5) * (y - 0.5)).sum::<f64>() / count as f64
        };
        assert!((rank(&a, &c) - 0.7).abs() < 0.02, "{}", rank(&a, &c));
        assert!((rank(&b, &c) + 0.3).abs() < 0.02 && rank(&a, &b).abs() < 0.02);
        assert!((rank(&c, &c) - 1.0).abs() < 0.02 && c.iter().all(|value| *value > 0.0 && *value < 1.0));
    }

    #[test]
    fn correlations_that_cannot_be_or_name_nothing_are_refused() {
        let error = |pairs: &[(usize, usize, f64)]| format!("{:#}", mixing(&study(pairs)).unwrap_err());
        assert!(
            error(&[(0, 1, 0.95), (1, 2, 0.95), (0, 2, -0.9)]).starts_with("correlations: they contradict each other")
        );
        assert!(error(&[(0, 1, 1.0)]).contains("rank = 1.0: use a number above -1 and below 1"));
        assert_eq!(
            error(&[(0, 1, 0.9), (1, 0, -0.9)]),
            "correlations: P.B and P.A: their axes already have a correlation: keep only one of the two"
        );
        assert!(error(&[(1, 1, 0.5)]).contains("belong to the same axis"));
        let mut unknown = study(&[(0, 1, 0.5)]);
        unknown.correlations[0].variables[1] = "P.X".into();
        assert!(format!("{:#}", mixing(&unknown).unwrap_err()).contains("no axis has a distribution for P.X"));
        assert!(mixing(&study(&[])).unwrap().is_empty());
    }
}
