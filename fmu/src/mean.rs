//! The mean of a block's pulse over a step.

/// The sum of the pulses of the calls in one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mean {
    pulses: i64,
    calls: u64,
}

impl Mean {
    /// Adds the pulse after one call: +1, 0 or -1.
    pub fn add(&mut self, pulse: i32) {
        self.pulses += i64::from(pulse);
        self.calls += 1;
    }

    /// The mean over the calls in percent, -100 ... 100; if there were no calls, the value of the `held` pulse.
    pub fn percent(self, held: i32) -> f64 {
        match self.calls {
            0 => 100.0 * f64::from(held),
            calls => 100.0 * self.pulses as f64 / calls as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(pulses: &[i32]) -> Mean {
        let mut mean = Mean::default();
        pulses.iter().for_each(|pulse| mean.add(*pulse));
        mean
    }

    #[test]
    fn the_mean_is_that_of_all_calls_in_percent() {
        assert_eq!(mean(&[1, 0, 0, 0]).percent(1), 25.0);
        assert_eq!(mean(&[-1, -1, 0, 1]).percent(0), -25.0);
    }

    #[test]
    fn without_a_call_the_pulse_that_is_held_counts() {
        assert_eq!([1, 0, -1].map(|held| mean(&[]).percent(held)), [100.0, 0.0, -100.0]);
    }
}
