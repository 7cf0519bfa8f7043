//! The setpoint and process value branches that CONT_C and CONT_S share.

use crate::table::{Real, Word};

/// CRP_IN and PV_NORM: an analog word as a process value.
#[inline(always)]
pub(crate) fn process_value(pv_per: Word, pv_fac: Real, pv_off: Real) -> Real {
    // The REAL nearest to 100/27648. A division would differ in the last bit for one word in five (measured).
    const PERCENT_PER_COUNT: Real = 0.003616898;
    ((pv_per.real() * PERCENT_PER_COUNT) * pv_fac) + pv_off
}

/// DEADBAND: errors within `-width ... width` become 0, larger ones are reduced by the width.
#[inline(always)]
pub(crate) fn dead_band(x: Real, width: Real) -> Real {
    if x < -width {
        x + width
    } else if x > width {
        x - width
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_analog_word_of_27648_is_100_percent() {
        let percent = |word| process_value(Word::new(word), 1.0, 0.0);
        assert_eq!(percent(27648), 100.0);
        assert_eq!(percent(-27648), -100.0);
        assert_eq!(percent(13824), 50.0);
        assert_eq!(percent(32767), 118.5149);
        assert_eq!(percent(-32768), -118.51852);
    }

    #[test]
    fn an_analog_word_is_multiplied_not_divided() {
        let multiplied = process_value(Word::new(23), 1.0, 0.0);
        let divided: Real = (23.0 * 100.0) / 27648.0;
        assert_eq!((multiplied, divided), (0.08318865, 0.08318866));
    }

    #[test]
    fn the_factor_acts_before_the_offset() {
        assert_eq!(process_value(Word::new(13824), 4.0, -50.0), 150.0);
    }

    #[test]
    fn the_dead_band_takes_small_errors_away_and_shortens_large_ones_by_its_half_width() {
        for (x, error) in [(3.0, 1.0), (2.5, 0.5), (2.0, 0.0), (0.5, 0.0), (-2.0, 0.0), (-2.5, -0.5), (-3.0, -1.0)] {
            assert_eq!(dead_band(x, 2.0), error, "error {x}");
        }
    }

    #[test]
    fn a_dead_band_of_zero_changes_nothing() {
        for x in [1e-30, -1e-30, 7.5, -7.5] {
            assert_eq!(dead_band(x, 0.0), x);
        }
    }
}
