use super::*;

const ALL: [Sampling; 3] = [Sampling::Random, Sampling::LatinHypercube, Sampling::Sobol];

fn samples(sampling: Sampling, seed: u64, count: u64, axis: usize) -> Vec<f64> {
    let sampler = Sampler::new(sampling, seed, count, axis + 1);
    (0..count).map(|sample| sampler.probability(axis, sample)).collect()
}

/// Returns the number of samples in each of this many intervals of equal width.
fn histogram(samples: &[f64], count: usize) -> Vec<usize> {
    let mut histogram = vec![0; count];
    samples.iter().for_each(|sample| histogram[(sample * count as f64) as usize] += 1);
    histogram
}

#[test]
fn each_sample_of_saltellis_design_has_a_run_for_each_axis_between_two_points() {
    let sampler = Sampler::new(Sampling::Saltelli, 3, 8 * 5, 3);
    let point = |run: u64| [0, 1, 2].map(|axis| sampler.probability(axis, run));
    for first in (0..40).step_by(5) {
        let (a, b) = (point(first), point(first + 4));
        assert!((0..3).all(|axis| a[axis] != b[axis]));
        for own in 0..3 {
            let expected: Vec<f64> = (0..3).map(|axis| if axis == own { b[axis] } else { a[axis] }).collect();
            assert_eq!(point(first + 1 + own as u64)[..], expected);
        }
    }
}

#[test]
fn probabilities_are_above_0_and_below_1() {
    for sampling in ALL {
        for count in [1, 2, 3, 1000] {
            let samples = samples(sampling, 7, count, 2);
            assert!(samples.iter().all(|sample| *sample > 0.0 && *sample < 1.0), "{sampling:?}, {count}");
        }
    }
    assert_eq!([0, u64::MAX].map(|bits| centered(bits, 52)), [LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY]);
}

#[test]
fn a_sample_depends_on_seed_axis_and_number_alone() {
    for sampling in ALL {
        let one = Sampler::new(sampling, 7, 64, 3);
        // A sampler with another number of axes, queried in another order.
        let other = Sampler::new(sampling, 7, 64, 5);
        for axis in 0..3 {
            for sample in (0..64).rev() {
                assert_eq!(one.probability(axis, sample), other.probability(axis, sample), "{sampling:?}");
            }
        }
        assert_ne!(samples(sampling, 7, 64, 0), samples(sampling, 8, 64, 0), "{sampling:?}: another seed");
        assert_ne!(samples(sampling, 7, 64, 0), samples(sampling, 7, 64, 1), "{sampling:?}: another axis");
    }
    // A larger number of random samples continues a smaller one.
    assert_eq!(samples(Sampling::Random, 7, 100, 0)[..50], samples(Sampling::Random, 7, 50, 0));
}

#[test]
fn random_samples_are_spread_evenly() {
    let samples = samples(Sampling::Random, 1, 20_000, 0);
    // Chi-square with 99 degrees of freedom: between 60 and 149 except for one seed in a thousand.
    let expected = 200.0;
    let counts = histogram(&samples, 100);
    let square: f64 = counts.iter().map(|count| (*count as f64 - expected).powi(2) / expected).sum();
    assert!((60.0..149.0).contains(&square), "{square}");
}

#[test]
fn a_latin_hypercube_has_one_sample_in_each_stratum_of_each_axis() {
    for count in [1, 2, 3, 5, 64, 100, 1000, 4097] {
        for axis in 0..3 {
            let samples = samples(Sampling::LatinHypercube, 3, count, axis);
            assert!(histogram(&samples, count as usize).iter().all(|count| *count == 1), "{count}, axis {axis}");
        }
    }
}

#[test]
fn the_order_of_the_strata_tells_nothing_of_another_axis() {
    let count = 2000;
    let [one, other] = [0, 1].map(|axis| samples(Sampling::LatinHypercube, 3, count, axis));
    let covariance: f64 = one.iter().zip(&other).map(|(one, other)| (one - 0.5) * (other - 0.5)).sum();
    let correlation = 12.0 * covariance / count as f64;
    // The standard deviation for independent samples is 1/sqrt(2000) = 0.022.
    assert!(correlation.abs() < 0.07, "{correlation}");
    let neighbours: f64 = one.windows(2).map(|pair| (pair[0] - 0.5) * (pair[1] - 0.5)).sum();
    assert!((12.0 * neighbours / count as f64).abs() < 0.07);
}

#[test]
fn the_permutations_of_few_numbers_are_about_equally_frequent() {
    let mut counts = [0; 6];
    for seed in 0..6000 {
        let permutation = Permutation::new(seed, 0, 3);
        let order = [0, 1, 2].map(|number| permutation.image(number));
        let all = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        counts[all.iter().position(|of| *of == order).unwrap()] += 1;
    }
    // The standard deviation of each is 29.
    assert!(counts.iter().all(|count| (900..1100).contains(count)), "{counts:?}");
}

#[test]
fn a_sobol_sequence_fills_each_axis_and_each_pair_of_axes_evenly() {
    let [one, other] = [0, 1].map(|axis| samples(Sampling::Sobol, 5, 256, axis));
    assert!(histogram(&one, 256).iter().all(|count| *count == 1));
    assert!(histogram(&other, 256).iter().all(|count| *count == 1));
    let mut squares = vec![0; 256];
    for (one, other) in one.iter().zip(&other) {
        squares[(one * 16.0) as usize * 16 + (other * 16.0) as usize] += 1;
    }
    assert!(squares.iter().all(|count| *count == 1));
}

#[test]
fn the_samples_do_not_change_with_a_new_version() {
    let bits = |sampling| {
        let sampler = Sampler::new(sampling, 42, 1000, 2);
        [(0, 0), (0, 999), (1, 500)].map(|(axis, sample)| sampler.probability(axis, sample).to_bits())
    };
    // The first row agrees with an independent implementation of ChaCha8: 8 rounds, key (42, axis, 0, 0), nonce 0.
    let expected = [
        [4_599_945_214_697_038_826, 4_604_414_193_286_394_059, 4_602_017_942_603_493_078],
        [4_604_510_417_419_585_454, 4_604_045_145_233_759_928, 4_588_586_272_519_389_970],
        [4_606_412_666_708_164_608, 4_596_212_992_869_138_432, 4_606_141_588_773_535_744],
    ];
    assert_eq!(ALL.map(bits), expected);
}

#[test]
#[should_panic(expected = "there are 10 samples, not 10")]
fn there_is_no_sample_behind_the_last() {
    Sampler::new(Sampling::Random, 0, 10, 1).probability(0, 10);
}
