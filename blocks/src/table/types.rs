//! The PLC's elementary types and the conversions between them, as an S7 CPU performs them.

/// BOOL: one bit.
pub type Bool = bool;

/// INT: signed 16-bit integer.
pub type Int = i16;

/// REAL: IEEE 754 binary32. Every operation rounds to it.
pub type Real = f32;

/// LREAL: IEEE 754 binary64, for plants.
pub type LReal = f64;

/// TIME: a signed 32-bit count of milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Time(i32);

impl Time {
    /// The zero duration.
    pub const ZERO: Time = Time(0);

    /// A duration of `milliseconds`.
    pub const fn ms(milliseconds: i32) -> Time {
        Time(milliseconds)
    }

    /// The count of milliseconds.
    pub const fn milliseconds(self) -> i32 {
        self.0
    }

    /// The duration in seconds as the blocks compute it: `real(t) / 1000.0` in binary32.
    #[inline(always)]
    pub fn seconds(self) -> Real {
        self.0 as Real / 1000.0
    }

    /// The count of milliseconds as a REAL, rounded to nearest even.
    #[inline(always)]
    pub fn real(self) -> Real {
        self.0 as Real
    }
}

/// WORD with an analog value: two's complement, 27648 is 100 %.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Word(i16);

impl Word {
    /// The word that holds `value`.
    pub const fn new(value: i16) -> Word {
        Word(value)
    }

    /// The word read as a signed number.
    pub const fn value(self) -> i16 {
        self.0
    }

    /// The word as a REAL.
    #[inline(always)]
    pub fn real(self) -> Real {
        Real::from(self.0)
    }
}

/// Rounds to the nearest integer, ties to even, as the S7 instruction RND does.
///
/// A number beyond 32 bits is not converted: its REAL bit pattern stays in the accumulator (measured). NaN becomes -1
/// (observed).
#[inline(always)]
pub fn rnd(x: Real) -> i32 {
    // Adding 1.5 * 2^52 leaves no bit for a fraction, so the addition itself rounds, and the low bits of the sum are
    // the integer. This needs no instruction that old processors lack, and is exact for every 32-bit result.
    const INTEGERS_ONLY: f64 = 6_755_399_441_055_744.0;
    const TWO_TO_31: Real = 2_147_483_648.0;
    if x.is_nan() {
        -1
    } else if (-TWO_TO_31..TWO_TO_31).contains(&x) {
        (f64::from(x) + INTEGERS_ONLY).to_bits() as i32
    } else {
        x.to_bits() as i32
    }
}

/// The low word of a 32-bit result, read as an INT.
#[inline(always)]
pub const fn low_word(x: i32) -> Int {
    x as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rnd_takes_ties_to_the_even_integer() {
        for (x, integer) in [(0.5, 0), (1.5, 2), (2.5, 2), (-0.5, 0), (-1.5, -2), (-2.5, -2)] {
            assert_eq!(rnd(x), integer, "RND({x})");
        }
        assert_eq!(rnd(3.4999998), 3);
        assert_eq!(rnd(-3.5000002), -4);
    }

    #[test]
    fn rnd_converts_up_to_32_bits_and_leaves_the_bit_pattern_beyond() {
        assert_eq!(rnd(2_147_483_520.0), 2_147_483_520);
        assert_eq!(rnd(-2_147_483_648.0), i32::MIN);
        assert_eq!(rnd(2_147_483_648.0), 0x4F00_0000);
        assert_eq!(rnd(Real::INFINITY), 0x7F80_0000);
        assert_eq!(rnd(Real::NAN), -1);
    }

    #[test]
    fn an_int_made_of_a_number_beyond_32_bits_is_the_low_word_of_its_bit_pattern() {
        assert_eq!(low_word(rnd(1e9 * 276.48)), -16644);
    }

    #[test]
    fn a_time_in_seconds_is_its_real_divided_by_1000() {
        assert_eq!(Time::ms(1).seconds().to_bits(), (1.0f32 / 1000.0).to_bits());
        assert_eq!(Time::ms(20_000).seconds(), 20.0);
        // 2^24 + 1 has no REAL of its own: to nearest even.
        assert_eq!(Time::ms(16_777_217).real(), 16_777_216.0);
    }

    #[test]
    fn a_word_is_a_signed_16_bit_number() {
        assert_eq!(Word::new(-32768).real(), -32768.0);
    }
}
