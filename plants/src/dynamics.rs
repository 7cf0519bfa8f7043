//! Building blocks of plants: lags, transport delays and the analog input module, for blocks that simulate a process.
//!
//! A plant is a block whose law advances a process by one `CYCLE` in each call, with its inputs held. Everything here
//! is solved in closed form, not integrated in small steps: one step of one second yields the same result as a hundred
//! steps of ten milliseconds, apart from the rounding of 64-bit numbers.
//!
//! `exp` and related functions come from the crate `libm`, not from the system's math library, which differs in the
//! last bits from platform to platform: a plant computes the same bits everywhere.
//!
//! ```
//! use blocks::{LReal, Law};
//! use plants::dynamics::{lag, limited, seconds};
//!
//! blocks::block! {
//!     /// A boiler: heating power in, temperature out.
//!     pub struct Boiler as "BOILER" {
//!         input {
//!             /// Heating power
//!             power: LReal = 0.0, min 0.0, max 100.0, unit "%";
//!         }
//!         parameter {
//!             /// Time lag of the boiler
//!             tm_lag: LReal = 60.0, min 0.0, unit "s";
//!         }
//!         cycle {
//!             /// Time by which a call advances the plant
//!             cycle: Time = Time::ms(100), min Time::ms(1);
//!         }
//!         output {
//!             /// Temperature
//!             temp: LReal, unit "degC";
//!         }
//!     }
//! }
//!
//! impl Law for Boiler {
//!     fn restart(&mut self) {
//!         self.clear();
//!         self.temp = 20.0;
//!     }
//!
//!     fn call(&mut self) {
//!         let target = 20.0 + 0.8 * limited(self.power, 0.0, 100.0);
//!         self.temp = lag(self.temp, target, self.tm_lag, seconds(self.cycle));
//!     }
//! }
//!
//! let mut boiler = Boiler { power: 100.0, ..Boiler::default() };
//! boiler.restart();
//! (0..600).for_each(|_| boiler.call());
//! assert!((boiler.temp - (100.0 - 80.0 * (-1.0_f64).exp())).abs() < 1e-9);
//! ```

mod delay;
mod kept;

use blocks::{LReal, Stored, Time, Word};
pub use delay::Delay;
pub use kept::Kept;

/// The mathematical functions of the plants, with the same bits on every platform.
pub use libm::{exp, expm1 as exp_m1, log as ln};

/// Converts a TIME to seconds; a negative TIME becomes 0.
#[inline(always)]
pub fn seconds(time: Time) -> LReal {
    LReal::from(time.milliseconds().max(0)) / 1000.0
}

/// Limits `x` to `low` ... `high`; NaN becomes `low`. Unlike `f64::clamp`, it accepts a `low` above `high`, in which
/// case it returns one of the two.
#[inline(always)]
pub fn limited(x: LReal, low: LReal, high: LReal) -> LReal {
    if x > high {
        high
    } else if x >= low {
        x
    } else {
        low
    }
}

/// First-order lag: returns `value` after `seconds`, on its way to a constant `target`.
///
/// ```text
/// time_constant * d value / dt = target - value
/// ```
///
/// Without a time constant above 0 there is no lag: the value reaches the target immediately. A value at its target
/// stays there to the last bit. If `seconds` is not above 0, nothing happens.
///
/// A law that does this in every call should use [`Lag`].
///
/// ```
/// let value = plants::dynamics::lag(0.0, 100.0, 5.0, 10.0);
/// assert!((value - 100.0 * (1.0 - (-2.0_f64).exp())).abs() < 1e-12);
/// ```
pub fn lag(value: LReal, target: LReal, time_constant: LReal, seconds: LReal) -> LReal {
    Lag::default().step(value, target, time_constant, seconds)
}

/// Two lags in series, the first on its way to `target`, the second following the first: returns both after `seconds`.
///
/// ```text
/// time_constants[0] * d values[0] / dt = target    - values[0]
/// time_constants[1] * d values[1] / dt = values[0] - values[1]
/// ```
///
/// Either time constant may be 0, as with [`lag`]; equal and nearly equal time constants lose no accuracy.
///
/// A law that does this in every call should use [`Lags`].
///
/// ```
/// // From rest, with equal time constants: 1 - (1 + t/T) exp(-t/T).
/// let [_, second] = plants::dynamics::lags([0.0, 0.0], 1.0, [4.0, 4.0], 4.0);
/// assert!((second - (1.0 - 2.0 * (-1.0_f64).exp())).abs() < 1e-15);
/// ```
pub fn lags(values: [LReal; 2], target: LReal, time_constants: [LReal; 2], seconds: LReal) -> [LReal; 2] {
    Lags::default().step(values, target, time_constants, seconds)
}

/// [`lag`] for the memory of a block: recomputes `exp` only if the time constant or the duration has changed since the
/// last step.
///
/// ```
/// let mut filter = plants::dynamics::Lag::default();
/// let often = (0..4).fold(0.0, |value, _| filter.step(value, 1.0, 5.0, 0.5));
/// assert!((often - plants::dynamics::lag(0.0, 1.0, 5.0, 2.0)).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Lag {
    way: Kept<2, Way>,
}

impl Lag {
    /// Returns `value` after `seconds`.
    #[inline]
    pub fn step(&mut self, value: LReal, target: LReal, time_constant: LReal, seconds: LReal) -> LReal {
        if seconds <= 0.0 || seconds.is_nan() {
            return value;
        }
        let way = self.way.get_or_compute([time_constant, seconds], |[time_constant, seconds]| {
            Way::new(passed(seconds, time_constant))
        });
        way.from(value, target)
    }
}

/// [`lags`] for the memory of a block: recomputes `exp` only if a time constant or the duration has changed since the
/// last step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lags {
    ways: Kept<3, Ways>,
}

blocks::lane!(Lags { ways: Kept<3, Ways>, });

impl Lags {
    /// Returns `values` after `seconds`.
    #[inline]
    pub fn step(
        &mut self,
        values: [LReal; 2],
        target: LReal,
        [first, second]: [LReal; 2],
        seconds: LReal,
    ) -> [LReal; 2] {
        let is_time = seconds > 0.0;
        let compute = |[first, second, seconds]: [LReal; 3]| Ways::new([first, second], seconds);
        let Some(ways) = self.ways.get_if(is_time, [first, second, seconds], compute) else { return values };
        let after = ways.from(values, target);
        if is_time { after } else { values }
    }
}

/// The progress of a lag towards its target in a given time.
#[derive(Clone, Copy, Debug, Default)]
struct Way {
    /// Whether the target is reached immediately.
    is_whole: bool,
    /// The fraction of the distance covered, unless the target is reached.
    share: LReal,
}

blocks::lane!(Way { is_whole: bool, share: LReal });

impl Way {
    /// Returns the progress after this many time constants.
    fn new(passed: LReal) -> Way {
        Way { is_whole: passed == LReal::INFINITY, share: share(passed) }
    }

    #[inline(always)]
    fn from(self, value: LReal, target: LReal) -> LReal {
        let part = value + (target - value) * self.share;
        if self.is_whole { target } else { part }
    }
}

/// The progress of two lags in series in a given time.
#[derive(Clone, Copy, Debug, Default)]
struct Ways {
    first: Way,
    second: Way,
    /// The contribution of the first lag's initial deviation that remains in the second lag.
    through: LReal,
}

blocks::lane!(Ways { first: Way, second: Way, through: LReal });

impl Ways {
    fn new(time_constants: [LReal; 2], seconds: LReal) -> Ways {
        let [h1, h2] = time_constants.map(|time_constant| passed(seconds, time_constant));
        // h2 (exp(-h1) - exp(-h2)) / (h2 - h1), written so that nothing cancels if both are close and nothing overflows
        // if they are far apart.
        let apart = (h2 - h1).abs();
        let mean_decay = if apart == 0.0 { 1.0 } else { share(apart) / apart };
        let through = h2 * (1.0 - share(h1.min(h2))) * mean_decay;
        Ways { first: Way::new(h1), second: Way::new(h2), through }
    }

    #[inline(always)]
    fn from(self, [first, second]: [LReal; 2], target: LReal) -> [LReal; 2] {
        let first_after = self.first.from(first, target);
        let second_after = second + (target - second) * self.second.share + (first - target) * self.through;
        [first_after, if self.second.is_whole { first_after } else { second_after }]
    }
}

/// Returns the number of time constants in `seconds`: infinity without a lag.
fn passed(seconds: LReal, time_constant: LReal) -> LReal {
    if time_constant > 0.0 { seconds / time_constant } else { LReal::INFINITY }
}

/// Returns the fraction of the distance that a lag covers in `passed` time constants: 1 - exp(-passed), accurate for
/// small values as well.
fn share(passed: LReal) -> LReal {
    -exp_m1(-passed)
}

/// The word that an analog input module returns for a process value: 0 at `at_0`, 27648 at `at_100`, rounded to the
/// nearest count.
///
/// It saturates: the word never leaves 0 ... 27648. Real modules continue to 118 % before they report an overflow; here
/// the range ends where the sensor's range ends. `at_100` may be below `at_0`; if both are equal the word is 0.
///
/// ```
/// assert_eq!(plants::dynamics::analog(100.0, 0.0, 400.0).value(), 6912);
/// assert_eq!(plants::dynamics::analog(500.0, 0.0, 400.0).value(), 27648);
/// assert_eq!(plants::dynamics::analog(-1.0, 0.0, 400.0).value(), 0);
/// ```
#[inline(always)]
pub fn analog(value: LReal, at_0: LReal, at_100: LReal) -> Word {
    let counts = limited((value - at_0) / (at_100 - at_0) * 27648.0, 0.0, 27648.0);
    // The value is not negative, so truncation rounds half up. Adding 2^52 leaves no bit for a fraction, and the low
    // bits are the integer nearest to the sum; `as i16` would prevent vectorization.
    const INTEGERS_ONLY: LReal = 4_503_599_627_370_496.0;
    let shifted = (counts + 0.5) + INTEGERS_ONLY;
    let is_above = shifted - INTEGERS_ONLY > counts + 0.5;
    let word = shifted.to_bits() as i16 - i16::from(is_above);
    Word::new(if at_0 == at_100 { 0 } else { word })
}

impl Stored for Lag {
    fn write(&self, _bytes: &mut Vec<u8>) {}

    fn read(_bytes: &mut &[u8]) -> Option<Self> {
        Some(Lag::default())
    }
}

impl Stored for Lags {
    fn write(&self, _bytes: &mut Vec<u8>) {}

    fn read(_bytes: &mut &[u8]) -> Option<Self> {
        Some(Lags::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: LReal, b: LReal, relative: LReal) -> bool {
        (a - b).abs() <= relative * b.abs()
    }

    /// Integrates two lags by the classical fourth-order method in many small steps: an independent computation of the
    /// same values.
    fn lags_in_small_steps(mut x: [LReal; 2], target: LReal, t: [LReal; 2], seconds: LReal) -> [LReal; 2] {
        let slope = |x: [LReal; 2]| [(target - x[0]) / t[0], (x[0] - x[1]) / t[1]];
        let on = |x: [LReal; 2], d: [LReal; 2], h: LReal| [x[0] + h * d[0], x[1] + h * d[1]];
        let h = seconds / 10_000.0;
        for _ in 0..10_000 {
            let k1 = slope(x);
            let k2 = slope(on(x, k1, h / 2.0));
            let k3 = slope(on(x, k2, h / 2.0));
            let k4 = slope(on(x, k3, h));
            x = [0, 1].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        x
    }

    #[test]
    fn a_lag_covers_63_percent_of_its_way_in_its_time_constant() {
        assert!(close(lag(0.0, 1.0, 7.0, 7.0), 0.632_120_558_828_557_7, 1e-15));
        assert!(close(lag(10.0, 2.0, 7.0, 14.0), 2.0 + 8.0 * 0.135_335_283_236_612_7, 1e-15));
    }

    #[test]
    fn a_lag_without_a_time_constant_is_none() {
        for time_constant in [0.0, -0.0, -5.0, LReal::NAN] {
            assert_eq!(lag(0.7, 0.1, time_constant, 0.01), 0.1);
            assert_eq!(lags([1.0, 2.0], 8.0, [time_constant; 2], 0.01), [8.0, 8.0]);
        }
        assert_eq!(lags([1.0, 2.0], 8.0, [0.0, 4.0], 1.0), [8.0, lag(2.0, 8.0, 4.0, 1.0)]);
        assert_eq!(lags([1.0, 2.0], 8.0, [4.0, 0.0], 1.0), [lag(1.0, 8.0, 4.0, 1.0); 2]);
    }

    #[test]
    fn a_lag_at_its_target_stays_there_to_the_last_bit() {
        assert_eq!(lag(0.1, 0.1, 3.0, 0.7).to_bits(), 0.1_f64.to_bits());
        assert_eq!(lags([0.1, 0.1], 0.1, [3.0, 5.0], 0.7), [0.1, 0.1]);
    }

    #[test]
    fn in_no_time_nothing_happens_even_without_a_lag() {
        for seconds in [0.0, -1.0, LReal::NAN] {
            assert_eq!(lag(1.0, 9.0, 0.0, seconds), 1.0);
            assert_eq!(lags([1.0, 2.0], 9.0, [0.0, 3.0], seconds), [1.0, 2.0]);
        }
    }

    #[test]
    fn two_lags_are_what_small_steps_give_for_apart_near_and_equal_time_constants() {
        for t in [[2.0, 5.0], [5.0, 2.0], [3.0, 3.0], [3.0, 3.0 + 1e-9], [3.0 + 1e-5, 3.0], [0.5, 50.0]] {
            let closed = lags([4.0, -1.0], 10.0, t, 2.5);
            let small = lags_in_small_steps([4.0, -1.0], 10.0, t, 2.5);
            for i in [0, 1] {
                assert!(close(closed[i], small[i], 1e-12), "{t:?}: {closed:?}, in small steps {small:?}");
            }
        }
    }

    #[test]
    fn two_lags_in_a_thousand_steps_end_where_one_step_ends() {
        let t = [2.0, 2.000_001];
        let once = lags([4.0, -1.0], 10.0, t, 3.0);
        let often = (0..1000).fold([4.0, -1.0], |x, _| lags(x, 10.0, t, 0.003));
        assert!(close(often[0], once[0], 1e-13) && close(often[1], once[1], 1e-13));
    }

    #[test]
    fn no_time_constant_however_extreme_gives_nan_or_leaves_the_range_of_the_values() {
        let extremes = [1e-320, 1e-300, 1e-9, 1.0, 1e9, 1e300, LReal::INFINITY];
        for first in extremes {
            for second in extremes {
                for value in lags([0.0, 0.5], 1.0, [first, second], 0.1) {
                    assert!((0.0..=1.0).contains(&value), "{value} for {first}, {second}");
                }
            }
        }
    }

    #[test]
    fn limited_takes_nan_and_limits_the_wrong_way_round() {
        assert_eq!([-1.0, 0.0, 5.0, 9.0, 10.0].map(|x| limited(x, 0.0, 9.0)), [0.0, 0.0, 5.0, 9.0, 9.0]);
        assert_eq!(limited(LReal::NAN, 2.0, 9.0), 2.0);
        assert!([2.0, 9.0].contains(&limited(5.0, 9.0, 2.0)));
    }

    #[test]
    fn the_analog_word_is_rounded_and_saturates() {
        // 1 count is 400 / 27648 = 0.01447 K.
        assert_eq!(analog(0.007, 0.0, 400.0).value(), 0);
        assert_eq!(analog(0.008, 0.0, 400.0).value(), 1);
        assert_eq!(analog(-50.0, -50.0, 150.0).value(), 0);
        assert_eq!(analog(50.0, -50.0, 150.0).value(), 13824);
        assert_eq!(analog(25.0, 100.0, 0.0).value(), 20736, "a range that counts down");
        for (value, word) in [(400.1, 27648), (1e300, 27648), (-0.1, 0), (-1e300, 0), (LReal::NAN, 0)] {
            assert_eq!(analog(value, 0.0, 400.0).value(), word, "{value}");
        }
        assert_eq!([6.0, 7.0, 8.0].map(|value| analog(value, 7.0, 7.0).value()), [0, 0, 0], "no range");
    }

    #[test]
    fn seconds_are_exact_to_a_double() {
        assert_eq!(seconds(Time::ms(100)), 0.1);
        assert_eq!(seconds(Time::ms(-5)), 0.0);
    }
}
