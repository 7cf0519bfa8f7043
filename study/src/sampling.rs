//! The samples of the distributions. Each is computed from the seed, the axis, the sample index and the numbers of
//! samples and axes alone.
//!
//! - Random: the samples of an axis are words of a ChaCha8 key stream, with a key derived from seed and axis; the
//!   sample index is the position in the stream. An axis appended after the others does not change their samples.
//! - Latin hypercube (M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21, 1979): sample `s` of an axis lies at
//!   a random position in stratum `p(s)`, with as many strata as samples. The permutation `p` is a Feistel network with
//!   cycle walking (J. Black, P. Rogaway, "Ciphers with Arbitrary Finite Domains", CT-RSA 2002): nothing is stored, and
//!   any sample is computed independently.
//! - Sobol: the sequence of the crate `sobol_burley` with Owen scrambling (B. Burley, "Practical Hash-based Owen
//!   Scrambling", Journal of Computer Graphics Techniques 9, 2020); limited to the first 2^16 samples and to 256
//!   dimensions.
//! - Saltelli: the same Sobol sequence with two dimensions, A and B, for each axis; each of its points yields the runs
//!   listed in [`crate::sobol`].

use crate::Sampling;
use crate::sobol::runs_of_sample;
use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

/// The maximum number of samples in a Sobol sequence.
pub const SOBOL_SAMPLES: u64 = 1 << 16;
/// The maximum number of axes in a Sobol sequence.
pub const SOBOL_AXES: usize = sobol_burley::NUM_DIMENSIONS as usize;
/// The lowest probability of a sample, and its smallest distance from 1.
pub const LEAST_PROBABILITY: f64 = f64::EPSILON / 2.0;

/// The purpose of a key stream, which is part of its key.
#[derive(Clone, Copy)]
enum Use {
    /// The random part of a sample.
    Samples = 0,
    /// The order of the strata of a Latin hypercube.
    Permutation = 1,
    /// The scrambling of a Sobol sequence.
    Scrambling = 2,
}

/// Computes the probabilities from which the samples are derived as quantiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampler {
    seed: u64,
    samples: u64,
    method: Method,
}

#[derive(Clone, Debug, PartialEq)]
enum Method {
    Random,
    /// The order of the strata for each axis.
    LatinHypercube(Vec<Permutation>),
    /// The seed of the scrambling.
    Sobol(u32),
    /// The seed of the scrambling, and the number of axes.
    Saltelli(u32, usize),
}

impl Sampler {
    /// Creates a sampler for `samples` samples, 1 to 10^9, of `axes` distributions.
    pub fn new(sampling: Sampling, seed: u64, samples: u64, axes: usize) -> Sampler {
        let permutation = |axis| Permutation::new(seed, axis, samples);
        let method = match sampling {
            Sampling::Random => Method::Random,
            Sampling::LatinHypercube => Method::LatinHypercube((0..axes).map(permutation).collect()),
            Sampling::Sobol => Method::Sobol(stream(seed, 0, Use::Scrambling).next_u32()),
            Sampling::Saltelli => Method::Saltelli(stream(seed, 0, Use::Scrambling).next_u32(), axes),
        };
        Sampler { seed, samples, method }
    }

    /// The probability of a sample on an axis, from [`LEAST_PROBABILITY`] to 1 - `LEAST_PROBABILITY`. `axis` counts
    /// only the axes with a distribution, from 0.
    ///
    /// # Panics
    /// The sample or axis does not exist.
    pub fn probability(&self, axis: usize, sample: u64) -> f64 {
        assert!(sample < self.samples, "there are {} samples, not {sample}", self.samples);
        match &self.method {
            Method::Random => centered(self.bits(axis, sample), 52),
            Method::LatinHypercube(permutations) => {
                let stratum = permutations[axis].image(sample) as f64;
                // Stratum and position together have at most 53 bits, so that their sum is exact.
                (stratum + centered(self.bits(axis, sample), 22)) / self.samples as f64
            }
            Method::Sobol(seed) => sobol(*seed, sample, axis),
            Method::Saltelli(seed, axes) => {
                let width = runs_of_sample(*axes);
                let run = (sample % width) as usize;
                let is_other = run == axis + 1 || run == axes + 1;
                sobol(*seed, sample / width, if is_other { axes + axis } else { axis })
            }
        }
    }

    /// The random bits of a sample.
    fn bits(&self, axis: usize, sample: u64) -> u64 {
        let mut stream = stream(self.seed, axis, Use::Samples);
        stream.set_word_pos(2 * u128::from(sample));
        stream.next_u64()
    }
}

/// A number of the Sobol sequence: the middle of the interval of width 2^-23 that the crate's number represents.
fn sobol(seed: u32, sample: u64, dimension: usize) -> f64 {
    f64::from(sobol_burley::sample(sample as u32, dimension as u32, seed)) + 0.5 / f64::from(1 << 23)
}

/// The key stream of an axis for a purpose.
fn stream(seed: u64, axis: usize, purpose: Use) -> ChaCha8Rng {
    let mut key = [0; 32];
    for (bytes, word) in key.chunks_exact_mut(8).zip([seed, axis as u64, purpose as u64]) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    ChaCha8Rng::from_seed(key)
}

/// A number between 0 and 1, exclusive, from the `count` highest bits: the middle of one of 2^count equal intervals.
fn centered(bits: u64, count: u32) -> f64 {
    ((bits >> (64 - count)) as f64 + 0.5) / (1_u64 << count) as f64
}

/// The number of rounds in the Feistel network.
const ROUNDS: usize = 8;

/// A permutation of the numbers below `count`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Permutation {
    count: u64,
    /// The number of bits in each half of a number.
    half: u32,
    keys: [u64; ROUNDS],
}

impl Permutation {
    /// Creates the permutation for a seed and an axis.
    pub(crate) fn new(seed: u64, axis: usize, count: u64) -> Permutation {
        let bits = u64::BITS - count.saturating_sub(1).leading_zeros();
        let mut stream = stream(seed, axis, Use::Permutation);
        Permutation { count, half: bits.div_ceil(2).max(1), keys: std::array::from_fn(|_| stream.next_u64()) }
    }

    /// The image of a number below `count`.
    pub(crate) fn image(&self, number: u64) -> u64 {
        // The network permutes the numbers below a power of 4. Following its cycle until a number is below `count`
        // again permutes those below `count`.
        let mut number = self.network(number);
        while number >= self.count {
            number = self.network(number);
        }
        number
    }

    fn network(&self, number: u64) -> u64 {
        let mask = (1 << self.half) - 1;
        let (mut left, mut right) = (number >> self.half, number & mask);
        for key in self.keys {
            (left, right) = (right, left ^ (mix(right ^ key) & mask));
        }
        left << self.half | right
    }
}

/// Makes each bit of the result depend on all bits of `value`: the finalizer of SplitMix64 (G. L. Steele, D. Lea, C. H.
/// Flood, OOPSLA 2014).
fn mix(mut value: u64) -> u64 {
    value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

#[cfg(test)]
mod tests;
