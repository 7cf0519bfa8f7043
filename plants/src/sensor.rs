//! SENSOR: a measuring chain with noise, filter and resolution, between a plant and its controller.

use crate::dynamics::{Lag, analog, limited, seconds};
use blocks::{Law, Response};

blocks::block! {
    /// Measuring chain between a plant and its controller: reproducible noise, a filter, and the steps of an analog
    /// input.
    ///
    /// # Purpose
    ///
    /// The process value that a controller receives is noisy and quantized. SENSOR adds both effects to the output of
    /// any plant to show what they do to the manipulated value: how much D action is tolerable, how wide a dead band
    /// must be, how often a valve moves. The noise is the same in every run and on every platform.
    ///
    /// # Quick start
    ///
    /// 1. Connect the process value of the plant to U, and Y to PV_IN of the controller, or Y_PER to PV_PER. Step the
    ///    plant first, then the sensor.
    /// 2. RANGE_LO and RANGE_HI: the range of the transmitter. They scale Y_PER and the steps.
    /// 3. NOISE: the standard deviation of the noise in the unit of U; two thirds of the values lie within it.
    /// 4. LAG_TM for a filter, STEPS for the resolution of the analog input; 0 switches either off.
    /// 5. CYCLE: the same as the controller's.
    ///
    /// Noise of 0.1 makes LMN_P of CONT_C with GAIN 5 vary by 0.5 %, and LMN_D with TD 2 s and TM_LAG 0.2 s at CYCLE 100 ms
    /// by 4.5 %.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon "~"
    /// input U 0,4
    /// box GENERATOR 8,13 "Gaussian" "noise" with NOISE SEED
    /// sum NOISY 17,4 left + bottom +
    /// box FILTER 28,4 lag with LAG_TM
    /// box STEPS_OF 43,4 characteristic with STEPS RANGE_LO RANGE_HI Y_START
    /// output Y 58,4
    /// box ANALOG 55,13 "0 ... 27648"
    /// output Y_PER 64,13
    /// box CALL 30,14 "every CYCLE" with CYCLE
    /// U > NOISY > FILTER > STEPS_OF > Y
    /// GENERATOR > NOISY.bottom
    /// STEPS_OF.bottom > y13 > ANALOG
    /// ANALOG > Y_PER
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// process value: Y
    /// signal input: U
    /// signal process value peripheral: Y_PER
    /// signal start: Y_START
    /// stimuli: NOISE, SEED
    ///
    /// [Process value]
    /// U
    /// [Noise]
    /// NOISE, SEED
    /// [Filter]
    /// LAG_TM
    /// [Peripheral process value]
    /// RANGE_LO, RANGE_HI, STEPS
    /// [Start]
    /// Y_START
    /// [Sampling]
    /// CYCLE
    /// ```
    ///
    /// # Algorithm
    ///
    /// ```math
    /// \begin{aligned}
    /// \text{LAG_TM}\,\dfrac{dx}{dt} &= \text{U} + \text{noise} - x \\
    /// \text{Y} &= x \quad \text{in steps of} \quad \dfrac{\text{RANGE_HI} - \text{RANGE_LO}}{\text{STEPS}}
    /// \end{aligned}
    /// ```
    ///
    /// Call k, where g(k) is the noise:
    ///
    /// ```text
    /// v = U + NOISE g(k)
    /// x = v                                                    in the first call, or without LAG_TM
    ///     x + (1 - exp(-CYCLE / LAG_TM)) (v - x)               later
    /// c = STEPS (x - RANGE_LO) / (RANGE_HI - RANGE_LO), rounded, within 0 ... STEPS
    /// Y = RANGE_LO + c (RANGE_HI - RANGE_LO) / STEPS           x without STEPS
    /// Y_PER = 27648 (Y - RANGE_LO) / (RANGE_HI - RANGE_LO), rounded, within 0 ... 27648
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Call k samples U and holds Y until the next call, as an analog input does; there is no other dead time.
    /// 2. Noise: g(k) depends on k and SEED only. It has mean 0 and standard deviation 1, no value beyond 6, and
    ///    the values are independent. It is the sum of twelve uniformly distributed numbers, which is close to Gaussian.
    /// 3. Every call draws new noise: half the CYCLE gives twice as many noise values per second.
    /// 4. The filter reduces the noise to NOISE sqrt(a / (2 - a)) with a = 1 - exp(-CYCLE / LAG_TM): to 22 % for a
    ///    LAG_TM of ten times CYCLE. It starts at the first value.
    /// 5. STEPS: Y has STEPS + 1 values from RANGE_LO to RANGE_HI and saturates at both ends. 27648 is the number of
    ///    counts of an analog input, 4096 that of a 12-bit one; 0 leaves Y unrounded, even beyond the range.
    /// 6. Y_PER is the analog input word for PV_PER, whatever STEPS is. In CONT_C, PVPER_ON = TRUE, PV_FAC =
    ///    (RANGE_HI - RANGE_LO) / 100 and PV_OFF = RANGE_LO convert it back to Y.
    /// 7. Start: until the first call Y is Y_START, and Y_PER the corresponding word, because they must not depend on
    ///    an input. Set it to the initial value of the plant, so that a controller called before the sensor sees no
    ///    step in the process value.
    ///
    /// # Limits of use
    ///
    /// The results are the same to the last bit on every platform. All parameters may be tuned during a run; a new SEED
    /// continues with different noise.
    ///
    /// Drift, broken wires and mains interference are not modelled.
    ///
    /// Bad input: NOISE, LAG_TM or STEPS below 0 counts as 0. RANGE_HI may be below RANGE_LO; if both are equal, there
    /// are no steps and Y_PER is 0. An infinite U or NaN stays in the filter until the next start, unless LAG_TM is 0.
    pub struct Sensor as "SENSOR" {
        input {
            /// Input value: the true process value
            ///
            /// Connect the output of the plant, in the unit of the range.
            u: LReal = 0.0;
        }
        parameter {
            /// Standard deviation of the noise, in the unit of U; 0: none
            ///
            /// Two thirds of the values are within NOISE of the true value, 95 % within twice as much. Take it from a
            /// recording of the plant in steady state: a sixth of the width of the band in which the value varies.
            noise: LReal = 0.1, min 0.0;
            /// Seed of the noise: each number gives a different sequence
            ///
            /// Two sensors with the same SEED have the same noise, unlike in a real plant: give each a different one.
            seed: Int = 1;
            /// Time constant of the filter; 0: none
            ///
            /// Smooths the noise before the steps, and adds to the lags of the plant: ten times CYCLE leaves 22 % of
            /// the noise. Use as much as the loop tolerates, a tenth of the plant's time constant or less.
            lag_tm: LReal = 0.0, min 0.0, unit "s";
            /// Low end of the range
            ///
            /// The value at which Y_PER is 0. Set PV_OFF of the controller to the same value.
            range_lo: LReal = 0.0;
            /// High end of the range
            ///
            /// The value at which Y_PER is 27648. Set PV_FAC of the controller to a hundredth of the span, 1 with the
            /// start values.
            range_hi: LReal = 100.0;
            /// Steps from RANGE_LO to RANGE_HI; 0: no steps
            ///
            /// The resolution of the analog input: 27648 steps over 0 ... 100 are 0.0036 each, 4096 steps 0.024 each. A
            /// small number shows what a coarse sensor does to the D action: 100 steps are 1 each.
            steps: Int = 27648, min 0, max 32767;
            /// Measured value until the first call
            ///
            /// The value of U at the start: T_START of HEATER, for example. With 0, a controller called before the
            /// sensor reads a furnace at 20 degC as 0 degC in its first call.
            y_start: LReal = 0.0;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// How often the sensor samples and the noise changes. Set it to the controller's CYCLE.
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Measured value, for PV_IN
            ///
            /// Connect it to PV_IN of the controller. It has the unit of U and is Y_START until the first call.
            y: LReal, from y_start;
            /// Measured value as an analog input word, for PV_PER
            ///
            /// Connect it to PV_PER of the controller, with PVPER_ON = TRUE: 0 ... 27648 for RANGE_LO ... RANGE_HI. It
            /// saturates at the ends of the range.
            y_per: Word, from y_start range_lo range_hi;
        }
    }
    memory Memory {
        /// The number of calls so far.
        calls: u64;
        /// The output of the filter.
        x: f64;
        /// The filter.
        filter: Lag;
    }
}

impl Law for Sensor {
    const HOLDS_INPUTS: bool = true;

    const RESPONSES: &'static [Response] = &[
        Response {
            title: "Noise of 0.5 on a value that steps from 50 to 52; a filter of 2 s after 30 s",
            calls: 600,
            set: &[(0, "NOISE", 0.5), (0, "U", 50.0), (200, "U", 52.0), (300, "LAG_TM", 2.0), (450, "U", 50.0)],
            show: &["U", "Y"],
        },
        Response {
            title: "100 STEPS over 0 ... 100, without noise and with a noise of 0.3: rounded to whole numbers",
            calls: 300,
            set: &[
                (0, "NOISE", 0.0),
                (0, "STEPS", 100.0),
                (0, "U", 20.0),
                (50, "U", 20.4),
                (100, "U", 20.6),
                (150, "NOISE", 0.3),
                (225, "U", 20.0),
            ],
            show: &["U", "Y"],
        },
    ];

    fn restart(&mut self) {
        self.clear();
        self.y = self.y_start;
        self.y_per = analog(self.y, self.range_lo, self.range_hi);
    }

    fn call(&mut self) {
        let v = self.u + self.noise.max(0.0) * noise(self.memory.calls, self.seed);
        let filtered = self.memory.filter.step(self.memory.x, v, self.lag_tm, seconds(self.cycle));
        self.memory.x = if self.memory.calls == 0 { v } else { filtered };
        self.memory.calls = self.memory.calls.wrapping_add(1);

        let (low, span, steps) = (self.range_lo, self.range_hi - self.range_lo, f64::from(self.steps));
        self.y = self.memory.x;
        if steps > 0.0 && span != 0.0 {
            // The value is not negative, so truncation rounds half up.
            let count = (limited(steps * (self.y - low) / span, 0.0, steps) + 0.5) as u32;
            self.y = low + f64::from(count) * span / steps;
        }
        self.y_per = analog(self.y, low, self.range_hi);
    }
}

/// Returns the noise in a call, with mean 0 and standard deviation 1: the normalized sum of twelve numbers from 0 to
/// 65535. The sum is exact, because it is computed in integers.
fn noise(call: u64, seed: i16) -> f64 {
    const MEAN: i32 = 12 * 65535 / 2;
    // Twelve times the variance of each number, (65536^2 - 1) / 12.
    const VARIANCE: f64 = 65536.0 * 65536.0 - 1.0;
    let numbers = (0..3).flat_map(|part| {
        let bits = scrambled(call.wrapping_mul(3).wrapping_add(part), seed);
        [0, 16, 32, 48].map(|place| i32::from((bits >> place) as u16))
    });
    f64::from(numbers.sum::<i32>() - MEAN) / VARIANCE.sqrt()
}

/// Returns 64 pseudorandom bits: the element with this index of a SplitMix64 sequence, which starts at a different
/// state for each seed.
fn scrambled(number: u64, seed: i16) -> u64 {
    let start = u64::from(seed.cast_unsigned()).wrapping_mul(0xd1b5_4a32_d192_ed03);
    let mut bits = start.wrapping_add(number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Block, Stored, Word};

    /// A sensor without noise or quantization.
    fn plain() -> Sensor {
        started(Sensor { noise: 0.0, steps: 0, ..Sensor::default() })
    }

    fn started(sensor: Sensor) -> Sensor {
        let mut sensor = sensor;
        sensor.restart();
        sensor
    }

    fn recorded(mut sensor: Sensor, calls: usize) -> Vec<f64> {
        sensor.restart();
        let value = |_| {
            sensor.call();
            sensor.y
        };
        (0..calls).map(value).collect()
    }

    fn mean(values: &[f64]) -> f64 {
        values.iter().sum::<f64>() / values.len() as f64
    }

    fn deviation(values: &[f64]) -> f64 {
        let mean = mean(values);
        mean_of(values, |value| (value - mean) * (value - mean)).sqrt()
    }

    fn mean_of(values: &[f64], of: impl Fn(f64) -> f64) -> f64 {
        mean(&values.iter().map(|value| of(*value)).collect::<Vec<_>>())
    }

    #[track_caller]
    fn assert_close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b} within {tolerance}");
    }

    #[test]
    fn without_noise_filter_and_steps_it_passes_the_value_on() {
        let mut sensor = plain();
        for u in [12.345, -3.0, 1e9] {
            sensor.u = u;
            sensor.call();
            assert_eq!(sensor.y, u);
        }
    }

    #[test]
    fn outputs_are_those_of_y_start_until_the_first_call() {
        let sensor = started(Sensor { u: 50.0, ..Sensor::default() });
        assert_eq!((sensor.y, sensor.y_per), (0.0, Word::new(0)));
        // A quarter of 0 ... 100 is 6912 of 27648.
        let sensor = started(Sensor { u: 50.0, y_start: 25.0, ..Sensor::default() });
        assert_eq!((sensor.y, sensor.y_per), (25.0, Word::new(6912)));
    }

    #[test]
    fn the_noise_has_its_mean_its_deviation_and_the_shares_of_a_gaussian() {
        let values = recorded(Sensor { u: 50.0, noise: 2.0, steps: 0, ..Sensor::default() }, 100_000);
        // The standard error is 0.006 for the mean of 100 000 values, and 0.0045 for their deviation.
        assert_close(mean(&values), 50.0, 0.02);
        assert_close(deviation(&values), 2.0, 0.015);
        let within = |width: f64| mean_of(&values, |value| f64::from((value - 50.0).abs() < width));
        assert_close(within(2.0), 0.683, 0.01);
        assert_close(within(4.0), 0.954, 0.005);
        assert_eq!(within(12.0), 1.0);
    }

    #[test]
    fn no_value_of_the_noise_tells_of_the_next_ones() {
        let values = recorded(Sensor { noise: 1.0, steps: 0, ..Sensor::default() }, 100_000);
        for distance in [1, 2, 3, 10, 100] {
            let products: Vec<f64> = values.windows(distance + 1).map(|values| values[0] * values[distance]).collect();
            assert_close(mean(&products), 0.0, 0.015);
        }
    }

    #[test]
    fn a_seed_has_the_same_noise_every_time_and_another_one_other_noise() {
        let of = |seed| recorded(Sensor { noise: 1.0, steps: 0, seed, ..Sensor::default() }, 10_000);
        assert_eq!(of(1), of(1));
        for (one, other) in [(1, 2), (1, -1), (0, 1), (100, 32767)] {
            let products: Vec<f64> = of(one).iter().zip(of(other)).map(|(a, b)| a * b).collect();
            assert_close(mean(&products), 0.0, 0.05);
        }
    }

    #[test]
    fn the_noise_is_the_same_bits_everywhere() {
        let values = recorded(Sensor { noise: 1.0, steps: 0, ..Sensor::default() }, 3);
        assert_eq!(values, [-0.02973937988627462, -0.7026672364099262, -1.2984008790574038]);
        assert_eq!(scrambled(0, 0), 0xe220_a839_7b1d_cdaf, "the first number of SplitMix64 that starts at 0");
    }

    #[test]
    fn noise_is_in_proportion_and_never_negative() {
        let of = |noise| recorded(Sensor { noise, steps: 0, ..Sensor::default() }, 100);
        assert_eq!(of(2.0), of(1.0).iter().map(|value| 2.0 * value).collect::<Vec<_>>());
        for none in [0.0, -1.0, f64::NAN] {
            assert_eq!(of(none), vec![0.0; 100]);
        }
    }

    #[test]
    fn the_filter_starts_at_the_first_value_and_reaches_63_2_percent_in_its_time() {
        let mut sensor = plain();
        (sensor.lag_tm, sensor.u) = (1.0, 50.0);
        sensor.call();
        assert_eq!(sensor.y, 50.0);
        sensor.u = 60.0;
        (0..10).for_each(|_| sensor.call());
        assert_close(sensor.y, 50.0 + 10.0 * 0.632_120_558_828_557_7, 1e-12);
    }

    #[test]
    fn the_filter_leaves_22_percent_of_the_noise_with_ten_cycles() {
        // a = 1 - exp(-0.1) = 0.0952, sqrt(a / (2 - a)) = 0.2235.
        let sensor = Sensor { noise: 1.0, steps: 0, lag_tm: 1.0, ..Sensor::default() };
        assert_close(deviation(&recorded(sensor, 100_000)), 0.2235, 0.005);
    }

    #[test]
    fn the_value_comes_in_steps_and_ends_with_the_range() {
        let mut sensor = Sensor { steps: 100, range_lo: -50.0, range_hi: 150.0, ..plain() };
        for (u, y) in
            [(-50.0, -50.0), (0.9, 0.0), (1.0, 2.0), (20.9, 20.0), (21.1, 22.0), (-70.0, -50.0), (1e300, 150.0)]
        {
            sensor.u = u;
            sensor.call();
            assert_eq!(sensor.y, y, "{u}");
        }
    }

    #[test]
    fn the_steps_of_an_analog_input_are_its_counts() {
        let mut sensor = Sensor { steps: 27648, range_hi: 400.0, ..plain() };
        for (u, counts) in [(0.007, 0), (0.008, 1), (100.0, 6912), (400.0, 27648), (500.0, 27648), (-1.0, 0)] {
            sensor.u = u;
            sensor.call();
            assert_eq!(sensor.y_per.value(), counts, "{u}");
            assert_close(sensor.y, f64::from(counts) * 400.0 / 27648.0, 1e-12);
        }
    }

    #[test]
    fn the_word_has_the_steps_of_the_value() {
        // 4096 steps are 6.75 counts each.
        let mut sensor = Sensor { steps: 4096, ..plain() };
        sensor.u = 100.0 / 4096.0;
        sensor.call();
        assert_eq!(sensor.y_per.value(), 7);
        // Without STEPS, Y_PER is still a word.
        let mut sensor = Sensor { u: 25.0, ..plain() };
        sensor.call();
        assert_eq!(sensor.y_per.value(), 6912);
    }

    #[test]
    fn bad_parameters_give_no_nan() {
        for bad in [0.0, -1.0] {
            let bad = Sensor { u: 5.0, noise: bad, lag_tm: bad, range_lo: bad, range_hi: bad, ..Sensor::default() };
            for steps in [0, -1, 100] {
                let mut sensor = started(Sensor { steps, ..bad.clone() });
                sensor.call();
                assert_eq!((sensor.y, sensor.y_per.value()), (5.0, 0));
            }
        }
        let mut turned = Sensor { u: 75.0, steps: 100, range_lo: 100.0, range_hi: 0.0, ..plain() };
        turned.call();
        assert_eq!((turned.y, turned.y_per.value()), (75.0, 6912));
    }

    #[test]
    fn saved_and_read_back_it_goes_on_bit_for_bit() {
        let mut sensor = started(Sensor { noise: 1.0, lag_tm: 0.5, ..Sensor::default() });
        (0..100).for_each(|_| sensor.call());
        let mut bytes = vec![];
        sensor.write(&mut bytes);
        let mut again = Sensor::read(&mut &bytes[..]).unwrap();
        for _ in 0..100 {
            sensor.call();
            again.call();
            for row in 0..Sensor::TABLE.rows.len() {
                assert_eq!(sensor.get(row), again.get(row));
            }
        }
    }
}
