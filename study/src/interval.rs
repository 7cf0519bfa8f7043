//! The precision of a percentile or a share: 95 % confidence intervals.
//!
//! They are valid for independent samples. A Latin hypercube or a Sobol sequence covers the axes more evenly, so that
//! estimates are usually more precise than the interval suggests.

use libm::{exp, lgamma, log, log1p};

/// The probability of an error on each side.
const TAIL: f64 = 0.025;

/// The standard normal quantile for [`TAIL`].
const NORMAL: f64 = 1.959_963_984_540_054;

/// The confidence interval of a percentile (0 to 100) of values in ascending order, which may have any distribution.
/// Both ends are among the values. `None` if there are too few values for both ends.
///
/// H. A. David and H. N. Nagaraja, "Order Statistics" (3rd edition, 2003), section 7.1: the number of values below the
/// true percentile has a binomial distribution.
pub fn percentile(sorted: &[f64], percent: f64) -> Option<(f64, f64)> {
    let (low, high) = ranks(sorted.len(), percent / 100.0)?;
    Some((sorted[low? - 1], sorted[high? - 1]))
}

/// The confidence interval of a percentile, infinite on a side with too few values. `None` for the percentiles 0 and
/// 100, or if there are no values.
pub fn bounds(sorted: &[f64], percent: f64) -> Option<(f64, f64)> {
    let (low, high) = ranks(sorted.len(), percent / 100.0)?;
    Some((low.map_or(f64::NEG_INFINITY, |rank| sorted[rank - 1]), high.map_or(f64::INFINITY, |rank| sorted[rank - 1])))
}

/// The number of values needed for a finite interval on both sides; the percentile is above 0 and below 100.
pub fn fewest(percent: f64) -> u64 {
    let share = percent / 100.0;
    // The probability that all values are on the same side of the percentile is share ^ count.
    (log(TAIL) / log(share.max(1.0 - share))).ceil() as u64
}

/// The 1-based ranks of the values at the ends; `None` for an end with too few values.
fn ranks(count: usize, share: f64) -> Option<(Option<usize>, Option<usize>)> {
    if count == 0 || !(0.0 < share && share < 1.0) {
        return None;
    }
    let (size, deviation) = (count as f64, (count as f64 * share * (1.0 - share)).sqrt());
    // Ranks further from the expected one have a negligible probability.
    let far = (12.0 * deviation + 40.0).ceil();
    let first = (size * share - far).max(0.0) as usize;
    let last = ((size * share + far) as usize).min(count);
    let probability = |below: usize| {
        let k = below as f64;
        let ways = lgamma(size + 1.0) - lgamma(k + 1.0) - lgamma(size - k + 1.0);
        exp(ways + k * log(share) + (size - k) * log1p(-share))
    };
    // The ranks at which the cumulative probability first exceeds [`TAIL`], from below and from above.
    let (mut low, mut sum) = (0, 0.0);
    for below in first..=last {
        sum += probability(below);
        if sum > TAIL {
            low = below;
            break;
        }
    }
    let (mut high, mut sum) = (count + 1, 0.0);
    for below in (first..=last).rev() {
        sum += probability(below);
        if sum > TAIL {
            high = below + 1;
            break;
        }
    }
    Some(((low >= 1).then_some(low), (high <= count).then_some(high)))
}

/// The confidence interval of the share of `hits` in `count`, both ends from 0 to 1; `None` if `count` is 0.
///
/// E. B. Wilson, "Probable inference, the law of succession, and statistical inference", Journal of the American
/// Statistical Association 22 (1927), pages 209 to 212: it is also accurate for small numbers and for shares near 0 and
/// 1.
pub fn share(hits: u64, count: u64) -> Option<(f64, f64)> {
    if count == 0 {
        return None;
    }
    let (size, share) = (count as f64, hits as f64 / count as f64);
    let square = NORMAL * NORMAL / size;
    let middle = share + square / 2.0;
    let half = (square * (share * (1.0 - share) + square / 4.0)).sqrt();
    let end = |value: f64| (value / (1.0 + square)).clamp(0.0, 1.0);
    Some((end(middle - half), end(middle + half)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_median_is_that_of_the_tables() {
        // The 6th and 15th of 20 values: at most 5 heads in 20 tosses have the probability 0.0207, at most 6
        // 0.0577.
        assert_eq!(ranks(20, 0.5), Some((Some(6), Some(15))));
        // Both ends of 6 values: 2 / 64 = 0.031 is outside. For 5 values it would be 2 / 32 = 0.0625.
        assert_eq!((ranks(6, 0.5), ranks(5, 0.5)), (Some((Some(1), Some(6))), Some((None, None))));
        assert_eq!(fewest(50.0), 6);
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(percentile(&values, 50.0), Some((6.0, 15.0)));
    }

    #[test]
    fn an_end_for_which_there_are_too_few_values_is_infinite() {
        // 0.95 ^ 71 = 0.0262 and 0.95 ^ 72 = 0.0249.
        assert_eq!([fewest(95.0), fewest(5.0)], [72, 72]);
        let values: Vec<f64> = (1..=72).map(f64::from).collect();
        assert_eq!(bounds(&values, 95.0).unwrap().1, 72.0);
        assert_eq!(percentile(&values[..71], 95.0), None);
        assert_eq!(bounds(&values[..71], 95.0).unwrap().1, f64::INFINITY);
        // The probability that at most 16 of 20 values are below it is 0.0159; for at most 17 it is 0.0755.
        assert_eq!(bounds(&values[..20], 95.0), Some((17.0, f64::INFINITY)));
        assert_eq!(bounds(&values[..20], 5.0), Some((f64::NEG_INFINITY, 4.0)));
        assert_eq!([bounds(&values, 0.0), bounds(&values, 100.0), bounds(&[], 50.0)], [None; 3]);
    }

    #[test]
    fn the_ranks_of_a_large_sample_are_those_of_the_normal_distribution() {
        // 500 -+ 1.96 sqrt(10 000 * 0.05 * 0.95) = 500 -+ 42.7.
        let both = |count, share| ranks(count, share).and_then(|(low, high)| Some((low?, high?))).unwrap();
        let (low, high) = both(10_000, 0.05);
        assert!(low.abs_diff(458) <= 1 && high.abs_diff(544) <= 1, "{low} {high}");
        let (low, high) = both(1_000_000, 0.95);
        assert!(low.abs_diff(949_573) <= 2 && high.abs_diff(950_428) <= 2, "{low} {high}");
    }

    #[test]
    fn the_ends_cover_the_percentile_as_often_as_they_say() {
        // Both tails, by summing the binomial distribution itself.
        for (count, share) in [(59_usize, 0.1), (200, 0.95), (37, 0.5)] {
            let (Some(low), Some(high)) = ranks(count, share).unwrap() else { panic!("{count} {share}") };
            let mut probabilities = vec![(1.0 - share).powi(count as i32)];
            for below in 1..=count {
                let before = probabilities[below - 1];
                probabilities.push(before * (count + 1 - below) as f64 / below as f64 * share / (1.0 - share));
            }
            let (under, over): (f64, f64) = (probabilities[..low].iter().sum(), probabilities[high..].iter().sum());
            assert!(under <= 0.025 && over <= 0.025, "{count} {share}");
            // One value fewer on either side would be too few.
            assert!(under + probabilities[low] > 0.025 && over + probabilities[high - 1] > 0.025, "{count} {share}");
        }
    }

    #[test]
    fn the_interval_of_a_share_is_wilsons() {
        let (low, high) = share(8, 10).unwrap();
        assert!((low - 0.4902).abs() < 5e-5 && (high - 0.9433).abs() < 5e-5, "{low} {high}");
        // 0 of 10: 3.8416 / (10 + 3.8416) is the upper end.
        let (low, high) = share(0, 10).unwrap();
        assert!(low == 0.0 && (high - 0.27754).abs() < 1e-5, "{low} {high}");
        assert_eq!(share(0, 0), None);
    }
}
