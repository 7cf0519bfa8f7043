//! Maps a probability to a value of a distribution, with identical bits on every platform.
//!
//! Values are drawn by inversion: a probability, uniformly distributed between 0 and 1, becomes the quantile for that
//! probability. One probability yields one value, so that stratified and low-discrepancy sampling work for every
//! distribution. Exponential and logarithm come from the crate `libm`, since platform implementations differ.

use crate::Along;
use libm::{erfc, exp, log};
use std::f64::consts::SQRT_2;

/// A distribution from which values are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distribution {
    /// See [`Along::Uniform`].
    Uniform {
        /// The minimum.
        min: f64,
        /// The maximum.
        max: f64,
    },
    /// See [`Along::Normal`], without bounds.
    Normal {
        /// The mean.
        mean: f64,
        /// The standard deviation.
        deviation: f64,
    },
    /// See [`Along::Normal`], with bounds.
    Truncated {
        /// The mean of the distribution before truncation.
        mean: f64,
        /// The standard deviation of the distribution before truncation.
        deviation: f64,
        /// The minimum; may be infinite.
        min: f64,
        /// The maximum; may be infinite.
        max: f64,
        /// The share of the untruncated distribution below `min`, or above `max` if `is_mirrored`.
        low: f64,
        /// The share of the untruncated distribution that remains.
        share: f64,
        /// Whether probabilities are counted from above, because from below they would round to 1.
        is_mirrored: bool,
    },
    /// See [`Along::LogNormal`].
    LogNormal {
        /// The median.
        median: f64,
        /// The standard deviation of the natural logarithm.
        deviation: f64,
    },
    /// See [`Along::Triangular`].
    Triangular {
        /// The minimum.
        min: f64,
        /// The most likely value.
        mode: f64,
        /// The maximum.
        max: f64,
    },
}

impl Distribution {
    /// The distribution of an axis; `None` for lists and ranges.
    pub fn new(along: &Along) -> Option<Distribution> {
        match *along {
            Along::Values(_) | Along::Rows(_) | Along::Range { .. } => None,
            Along::Uniform { min, max } => Some(Distribution::Uniform { min, max }),
            Along::Normal { mean, deviation, min: None, max: None } => Some(Distribution::Normal { mean, deviation }),
            Along::Normal { mean, deviation, min, max } => {
                Some(truncated(mean, deviation, min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY)))
            }
            Along::LogNormal { median, deviation } => Some(Distribution::LogNormal { median, deviation }),
            Along::Triangular { min, mode, max } => Some(Distribution::Triangular { min, mode, max }),
        }
    }

    /// The minimum and maximum; infinite if unbounded.
    pub fn bounds(&self) -> (f64, f64) {
        match *self {
            Distribution::Uniform { min, max }
            | Distribution::Truncated { min, max, .. }
            | Distribution::Triangular { min, max, .. } => (min, max),
            Distribution::Normal { .. } => (f64::NEG_INFINITY, f64::INFINITY),
            Distribution::LogNormal { .. } => (0.0, f64::INFINITY),
        }
    }

    /// Like [`Distribution::quantile`], or an integer if `is_whole`: for a uniform distribution every integer in its
    /// range with the same probability, for others the nearest one within the bounds, which must contain one.
    pub fn quantile_of(&self, probability: f64, is_whole: bool) -> f64 {
        if !is_whole {
            return self.quantile(probability);
        }
        let (min, max) = self.bounds();
        let (min, max) = (min.ceil(), max.floor());
        let value = match self {
            Distribution::Uniform { .. } => (min + probability * (max - min + 1.0)).floor(),
            _ => self.quantile(probability).round(),
        };
        value.max(min).min(max)
    }

    /// The quantile for a probability, which is above 0 and below 1.
    pub fn quantile(&self, probability: f64) -> f64 {
        match *self {
            Distribution::Uniform { min, max } => (min + probability * (max - min)).clamp(min, max),
            Distribution::Normal { mean, deviation } => mean + deviation * normal_quantile(probability),
            Distribution::Truncated { mean, deviation, min, max, low, share, is_mirrored } => {
                let quantile = if is_mirrored {
                    -normal_quantile(low + (1.0 - probability) * share)
                } else {
                    normal_quantile(low + probability * share)
                };
                (mean + deviation * quantile).clamp(min, max)
            }
            Distribution::LogNormal { median, deviation } => median * exp(deviation * normal_quantile(probability)),
            Distribution::Triangular { min, mode, max } => {
                let (rising, width) = (mode - min, max - min);
                let value = if probability * width < rising {
                    min + (probability * width * rising).sqrt()
                } else {
                    max - ((1.0 - probability) * width * (max - mode)).sqrt()
                };
                value.clamp(min, max)
            }
        }
    }
}

fn truncated(mean: f64, deviation: f64, min: f64, max: f64) -> Distribution {
    let (from, to) = ((min - mean) / deviation, (max - mean) / deviation);
    let is_mirrored = from > 0.0;
    let (from, to) = if is_mirrored { (-to, -from) } else { (from, to) };
    let low = normal_share(from);
    Distribution::Truncated { mean, deviation, min, max, low, share: normal_share(to) - low, is_mirrored }
}

/// The standard normal distribution function: the probability of a lower value.
pub fn normal_share(value: f64) -> f64 {
    0.5 * erfc(-value / SQRT_2)
}

/// The standard normal quantile; infinite for 0 and 1.
///
/// M. J. Wichura, "Algorithm AS 241: The Percentage Points of the Normal Distribution", Applied Statistics 37 (1988),
/// pages 477 to 484, routine PPND16: accurate to about 16 digits.
pub fn normal_quantile(probability: f64) -> f64 {
    let centered = probability - 0.5;
    if centered.abs() <= 0.425 {
        let square = 0.180625 - centered * centered;
        return centered * ratio(&CENTER, square);
    }
    let tail = if centered < 0.0 { probability } else { 1.0 - probability };
    if tail <= 0.0 {
        return f64::INFINITY.copysign(centered);
    }
    let root = (-log(tail)).sqrt();
    let amount = if root <= 5.0 { ratio(&TAIL, root - 1.6) } else { ratio(&FAR_TAIL, root - 5.0) };
    amount.copysign(centered)
}

/// A ratio of two polynomials, given the coefficients of numerator and denominator, constant terms first.
fn ratio([numerator, denominator]: &[[f64; 8]; 2], value: f64) -> f64 {
    let polynomial = |of: &[f64; 8]| of.iter().rev().fold(0.0, |sum, coefficient| sum * value + coefficient);
    polynomial(numerator) / polynomial(denominator)
}

/// The coefficients a and b of AS 241.
#[expect(clippy::excessive_precision, reason = "the digits that are published")]
const CENTER: [[f64; 8]; 2] = [
    [
        3.387_132_872_796_366_608,
        1.331_416_678_917_843_774_5e+2,
        1.971_590_950_306_551_442_7e+3,
        1.373_169_376_550_946_112_5e+4,
        4.592_195_393_154_987_145_7e+4,
        6.726_577_092_700_870_085_3e+4,
        3.343_057_558_358_812_810_5e+4,
        2.509_080_928_730_122_672_7e+3,
    ],
    [
        1.0,
        4.231_333_070_160_091_125_2e+1,
        6.871_870_074_920_579_083e+2,
        5.394_196_021_424_751_107_7e+3,
        2.121_379_430_158_659_586_7e+4,
        3.930_789_580_009_271_061e+4,
        2.872_908_573_572_194_267_4e+4,
        5.226_495_278_852_854_561e+3,
    ],
];

/// The coefficients c and d of AS 241.
#[expect(clippy::excessive_precision, reason = "the digits that are published")]
const TAIL: [[f64; 8]; 2] = [
    [
        1.423_437_110_749_683_577_34,
        4.630_337_846_156_545_295_9,
        5.769_497_221_460_691_405_5,
        3.647_848_324_763_204_605_04,
        1.270_458_252_452_368_382_58,
        2.417_807_251_774_506_117_7e-1,
        2.272_384_498_926_918_458_33e-2,
        7.745_450_142_783_414_076_4e-4,
    ],
    [
        1.0,
        2.053_191_626_637_758_821_87,
        1.676_384_830_183_803_849_4,
        6.897_673_349_851_000_045_5e-1,
        1.481_039_764_274_800_745_9e-1,
        1.519_866_656_361_645_719_66e-2,
        5.475_938_084_995_344_946e-4,
        1.050_750_071_644_416_843_24e-9,
    ],
];

/// The coefficients e and f of AS 241.
#[expect(clippy::excessive_precision, reason = "the digits that are published")]
const FAR_TAIL: [[f64; 8]; 2] = [
    [
        6.657_904_643_501_103_777_2,
        5.463_784_911_164_114_369_9,
        1.784_826_539_917_291_335_8,
        2.965_605_718_285_048_912_3e-1,
        2.653_218_952_657_612_309_3e-2,
        1.242_660_947_388_078_438_6e-3,
        2.711_555_568_743_487_578_15e-5,
        2.010_334_399_292_288_132_65e-7,
    ],
    [
        1.0,
        5.998_322_065_558_879_376_9e-1,
        1.369_298_809_227_358_053_1e-1,
        1.487_536_129_085_061_485_25e-2,
        7.868_691_311_456_132_591e-4,
        1.846_318_317_510_054_681_8e-5,
        1.421_511_758_316_445_888_7e-7,
        2.044_263_103_389_939_785_64e-15,
    ],
];

#[cfg(test)]
mod tests;
