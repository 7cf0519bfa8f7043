//! HEATER: an electrically heated furnace, a plant for CONT_C.

use crate::dynamics::{Delay, Kept, Lags, analog, limited};
use blocks::{LReal, Law, Response};

blocks::block! {
    /// Electrically heated furnace with a door: heating power in, temperature out, with two lags and a transport delay.
    ///
    /// # Purpose
    ///
    /// A furnace for closing a loop: slow, with a dead time, and with a door as the disturbance. It is a plant for
    /// CONT_C and PULS_CTR, as difficult as temperature loops usually are. Its numbers are round so that they can be
    /// checked with pencil and paper.
    ///
    /// # Quick start
    ///
    /// 1. Connect LMN of the controller to POWER, and TEMP to PV_IN, or T_PER to PV_PER with PVPER_ON = TRUE and PV_FAC
    ///    = 4.
    /// 2. CYCLE: the same as the controller's. Step the controller first, then the furnace.
    /// 3. Set DOOR during the run to create a disturbance.
    ///
    /// For CONT_C, with degC for setpoint and process value and CYCLE 1 s: PI with GAIN 0.7, TI 130 s overshoots a
    /// setpoint step by 0.5 % at most; from 20 to 60 degC it settles to within 2 % of the step after 133 s, from 20 to
    /// 200 degC, with POWER at 100 % at first, after 425 s. At 200 degC, opening the door halfway then causes a drop of
    /// 12 K. PI with GAIN 1.4, TI 80 s is faster where POWER is at 100 % for long (275 s to 200 degC, a drop of 8 K),
    /// but overshoots a step to 60 degC by 30 %. PID with GAIN 4, TI 80 s, TD 16 s, TM_LAG 3 s takes 161 s to 200 degC,
    /// where the door causes a drop of 3 K, but overshoots a step to 40 degC by 12 %.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon furnace
    /// input POWER 0,14
    /// box LIMIT 12,14 limit
    /// box DELAY 23,14 delay with DELAY_TM DELAY_MAX
    /// box RISE 36,14 multiply with RISE
    /// sum HEAT 44.5,14 left + bottom -
    /// box FURNACE 54,14 integrate with FURN_TM T_START
    /// input DOOR 30,26
    /// box LOSS 44.5,26 "x (1 + loss" "by the door)" with DOOR_LOSS
    /// input T_AMB 47,34
    /// sum ABOVE 56,26 right + bottom -
    /// box SENSOR 69,14 lag with SENS_TM
    /// box ANALOG 73,27 "0 ... 27648" with T_PER_0 T_PER_100
    /// output T_FURN 63,7
    /// output TEMP 77,14
    /// output T_PER 83,27
    /// box CALL 22,26 "every CYCLE" with CYCLE
    /// text 12,17 "0 ... 100 %" middle
    /// POWER > LIMIT > DELAY > RISE > HEAT
    /// HEAT > FURNACE > SENSOR > TEMP
    /// 61.5,14 > y7 > T_FURN
    /// 61.5,14 > y26 > ABOVE.right
    /// T_AMB > ABOVE.bottom
    /// ABOVE.left > LOSS.right
    /// DOOR > LOSS
    /// LOSS.top > HEAT.bottom
    /// 75.5,14 > y20 > x64 > y27 > ANALOG
    /// ANALOG > T_PER
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// process value: TEMP
    /// manipulated value: POWER
    /// disturbances: DOOR, T_AMB
    /// signal process value peripheral: T_PER
    ///
    /// [Manipulated value]
    /// POWER
    /// [Disturbance]
    /// DOOR, DOOR_LOSS, T_AMB
    /// [Gain and times]
    /// RISE, FURN_TM, SENS_TM, DELAY_TM, DELAY_MAX
    /// [Start]
    /// T_START
    /// [Peripheral process value]
    /// T_PER_0, T_PER_100
    /// [Sampling]
    /// CYCLE
    /// ```
    ///
    /// # Algorithm
    ///
    /// ```math
    /// \begin{aligned}
    /// \text{FURN_TM}\,\dfrac{d\,\text{T_FURN}}{dt} &= \text{RISE}\,\dfrac{p(t - \text{DELAY_TM})}{100\,\%} \\
    /// &\quad - L\,(\text{T_FURN} - \text{T_AMB}) \\
    /// \text{SENS_TM}\,\dfrac{d\,\text{TEMP}}{dt} &= \text{T_FURN} - \text{TEMP}
    /// \end{aligned}
    /// ```
    ///
    /// `p` is POWER within 0 ... 100 %; the equations use its value DELAY_TM ago. `L` is the loss relative to the loss
    /// with the door closed:
    ///
    /// ```text
    /// L = 1 + (DOOR / 100 %) (DOOR_LOSS / 100 %)
    /// FURN_TM dT_FURN/dt = RISE (p / 100 %) - L (T_FURN - T_AMB)
    /// SENS_TM dTEMP/dt   = T_FURN - TEMP
    /// T_PER = 27648 (TEMP - T_PER_0) / (T_PER_100 - T_PER_0), rounded, within 0 ... 27648
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Call k covers the time from k to k + 1 times CYCLE, with the inputs held; after the call, the outputs are
    ///    those at the end of that time. So use a communication step of CYCLE or a multiple of it; with shorter steps
    ///    the outputs run ahead by part of a CYCLE.
    /// 2. Start: furnace and sensor are in equilibrium at T_START: the power still in the delay is the power that holds
    ///    this temperature with the door closed, limited to 0 ... 100 %.
    /// 3. Steady state: TEMP = T_AMB + RISE (p / 100 %) / L. An open door reduces both the temperature rise and the
    ///    time constant by the factor L.
    /// 4. A power change at time t begins to act at t + DELAY_TM, even within a CYCLE. The disturbances act at once.
    /// 5. POWER and DOOR are limited to 0 ... 100 %.
    /// 6. T_PER is TEMP as an analog input word, for PV_PER, without overrange: it saturates at the ends of its range.
    ///    In CONT_C, PVPER_ON = TRUE, PV_FAC = (T_PER_100 - T_PER_0) / 100 and PV_OFF = T_PER_0 convert it back to
    ///    degC.
    /// 7. All parameters except DELAY_MAX may be tuned during a run. DELAY_TM is limited to DELAY_MAX, or to its own
    ///    value at the start if that is longer.
    ///
    /// # Limits of use
    ///
    /// Solved in closed form for held inputs, so the result depends on CYCLE only through rounding (a few parts in
    /// 10^14). The results are the same to the last bit on every platform.
    ///
    /// The loss is proportional to the temperature difference, as in conduction; radiation is not modelled.
    ///
    /// Bad input: a time that is 0 or negative means no lag, or no delay. DOOR_LOSS below 0 counts as 0.
    pub struct Heater as "HEATER" {
        input {
            /// Heating power
            ///
            /// Connect LMN of the controller. It is limited to 0 ... 100 % and acts after DELAY_TM. With the start
            /// values, 50 % holds 170 degC: T_AMB + RISE / 2.
            power: LReal = 0.0, min 0.0, max 100.0, unit "%";
            /// Disturbance: how far the door is open
            ///
            /// An open door loses heat: at 100 % the loss is DOOR_LOSS percent larger, so 50 % power holds 120 degC
            /// instead of 170. It acts at once and also makes the furnace faster. Set it during a run to see how the
            /// loop recovers.
            door: LReal = 0.0, min 0.0, max 100.0, unit "%";
        }
        parameter {
            /// Temperature of the surroundings
            ///
            /// The temperature to which the furnace cools without power. A change during a run acts as a disturbance
            /// with the time constant FURN_TM.
            t_amb: LReal = 20.0, min -273.15, unit "degC";
            /// Temperature of furnace and sensor at the start
            ///
            /// Furnace and sensor are in equilibrium at this temperature, and the delay is filled with the power that
            /// holds it. With T_START = T_AMB the run is a cold start.
            t_start: LReal = 20.0, min -273.15, unit "degC";
            /// Temperature above the surroundings that full power holds with the door closed
            ///
            /// The gain of the plant: RISE / 100 in K per percent, 3 with the start value. A tuning rule needs it
            /// together with FURN_TM and DELAY_TM.
            rise: LReal = 300.0, unit "K";
            /// Time constant of the furnace with the door closed; 0: none
            ///
            /// After a step in the power, the furnace covers 63 % of the change in this time. It is the dominant time
            /// constant for a tuning rule; an open door makes it shorter.
            furn_tm: LReal = 120.0, min 0.0, unit "s";
            /// Time constant of the sensor; 0: none
            ///
            /// TEMP follows T_FURN with this lag. It adds to the dead time that the controller sees: in a tuning rule,
            /// count half of it as dead time and half as time constant.
            sens_tm: LReal = 20.0, min 0.0, unit "s";
            /// Transport delay from the heating power to the furnace; range: 0 ... DELAY_MAX
            ///
            /// A dead time: a change in POWER takes effect after it. The larger it is relative to FURN_TM, the less
            /// gain the loop tolerates. It may be tuned during a run, up to DELAY_MAX.
            delay_tm: LReal = 5.0, min 0.0, unit "s";
        }
        fixed {
            /// Longest DELAY_TM that may be set during a run
            ///
            /// Reserves memory for the power in the delay, 8 bytes for each CYCLE. Raise it before the start if
            /// DELAY_TM will exceed 60 s.
            delay_max: LReal = 60.0, min 0.0, unit "s";
        }
        parameter {
            /// Additional heat loss with the door fully open, in percent of the loss with it closed
            ///
            /// The strength of the disturbance DOOR: with 50, holding the same temperature with the door fully open
            /// takes half as much power again.
            door_loss: LReal = 50.0, min 0.0, unit "%";
            /// Temperature at which T_PER is 0
            ///
            /// One end of the analog input's range: at this temperature and below, T_PER is 0. Set PV_OFF of the
            /// controller to the same value.
            t_per_0: LReal = 0.0, unit "degC";
            /// Temperature at which T_PER is 27648
            ///
            /// The other end of the range: at this temperature and above, T_PER is 27648. Set PV_FAC of the controller
            /// to a hundredth of the span, 4 with the start values.
            t_per_100: LReal = 400.0, unit "degC";
        }
        cycle {
            /// Time by which a call advances the furnace
            ///
            /// The plant is solved exactly between two calls, so this time affects the result only through rounding.
            /// Set it to the controller's CYCLE or a fraction of it, and use a communication step of this time or a
            /// multiple of it.
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Temperature measured by the sensor, for PV_IN
            ///
            /// Connect it to PV_IN of the controller for a process value in degC. It lags behind T_FURN by SENS_TM.
            temp: LReal, from t_start, unit "degC";
            /// Temperature measured by the sensor as an analog input word, for PV_PER
            ///
            /// Connect it to PV_PER of the controller, with PVPER_ON = TRUE, PV_FAC = 4 and PV_OFF = 0: the reading of
            /// a module for 0 ... 400 degC, in steps of 0.014 K. It saturates at the ends of the range; a real module
            /// continues to 32511 and reads 32767 beyond.
            t_per: Word, from t_start t_per_0 t_per_100;
            /// Temperature of the furnace itself
            ///
            /// The true temperature, without the sensor lag; the controller does not see it. During a fast heat-up it
            /// is above TEMP by SENS_TM times the slope.
            t_furn: LReal, from t_start, unit "degC";
        }
    }
    memory Memory {
        /// The heating power in the delay.
        power: Delay;
        /// The heat loss relative to the loss with the door closed, and the resulting time constant of the furnace.
        loss: Kept<3, [LReal; 2]>;
        /// The lags of furnace and sensor, for each part of a cycle.
        lags: [Lags; 2];
    }
}

impl Law for Heater {
    const HOLDS_INPUTS: bool = true;

    const RESPONSES: &'static [Response] = &[
        Response {
            title: "Full power for 4 min, then 50 %; the door opens after 15 min",
            calls: 1500,
            set: &[(0, "CYCLE", 1.0), (0, "POWER", 100.0), (240, "POWER", 50.0), (900, "DOOR", 100.0)],
            show: &["POWER", "DOOR", "TEMP", "T_FURN"],
        },
        Response {
            title: "A step to 50 %: nothing for 5 s, then two lags, finally 170 degC",
            calls: 900,
            set: &[(0, "CYCLE", 1.0), (10, "POWER", 50.0)],
            show: &["POWER", "TEMP", "T_FURN"],
        },
    ];

    fn check(&self) -> Result<(), String> {
        Delay::check("DELAY_TM", self.delay_tm, self.cycle)?;
        Delay::check("DELAY_MAX", self.delay_max, self.cycle)
    }

    fn restart(&mut self) {
        self.clear();
        let held = limited(100.0 * (self.t_start - self.t_amb) / self.rise, 0.0, 100.0);
        self.memory.power = Delay::new(self.delay_tm.max(self.delay_max), self.cycle, held);
        self.show([self.t_start; 2]);
    }

    #[inline(always)]
    fn call(&mut self) {
        let power = limited(self.power, 0.0, 100.0);
        let [loss, furn_tm] = self.memory.loss.get_or_compute([self.door, self.door_loss, self.furn_tm], Heater::loss);
        let [(first, power), (second, power_after)] = self.memory.power.step(power, self.delay_tm, self.cycle);
        let target = |power: LReal| self.t_amb + self.rise * power / 100.0 / loss;
        let time_constants = [furn_tm, self.sens_tm];
        let [lags, lags_after] = &mut self.memory.lags;
        let temperatures = lags.step([self.t_furn, self.temp], target(power), time_constants, first);
        let temperatures = lags_after.step(temperatures, target(power_after), time_constants, second);
        self.show(temperatures);
    }
}

impl Heater {
    /// Returns the heat loss relative to the loss with the door closed, and the resulting time constant of the furnace.
    fn loss([door, door_loss, furn_tm]: [LReal; 3]) -> [LReal; 2] {
        let loss = 1.0 + limited(door, 0.0, 100.0) / 100.0 * door_loss.max(0.0) / 100.0;
        [loss, furn_tm / loss]
    }

    #[inline(always)]
    fn show(&mut self, [t_furn, temp]: [f64; 2]) {
        self.t_furn = t_furn;
        self.temp = temp;
        self.t_per = analog(temp, self.t_per_0, self.t_per_100);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Block, ContC, Stored, Time, Word};

    fn started(heater: Heater) -> Heater {
        let mut heater = heater;
        heater.restart();
        heater
    }

    fn run(heater: &mut Heater, seconds: f64) {
        let calls = (seconds / crate::dynamics::seconds(heater.cycle)).round() as u32;
        (0..calls).for_each(|_| heater.call());
    }

    #[track_caller]
    fn assert_close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b} within {tolerance}");
    }

    #[test]
    fn it_starts_with_its_start_temperature_whatever_the_inputs_are() {
        let heater = started(Heater { power: 100.0, door: 100.0, t_start: 100.0, ..Heater::default() });
        assert_eq!((heater.temp, heater.t_furn, heater.t_per), (100.0, 100.0, Word::new(6912)));
    }

    #[test]
    fn at_rest_it_stays_at_rest_to_the_last_bit() {
        let mut heater = started(Heater { t_amb: 21.3, t_start: 21.3, ..Heater::default() });
        run(&mut heater, 1000.0);
        assert_eq!((heater.temp, heater.t_furn), (21.3, 21.3));
    }

    #[test]
    fn a_warm_start_is_at_rest_until_the_power_that_held_it_has_arrived() {
        // 50 % holds (170 - 20) degC.
        let mut heater = started(Heater { t_start: 170.0, ..Heater::default() });
        run(&mut heater, 5.0);
        assert_close(heater.temp, 170.0, 1e-11);
        run(&mut heater, 1.0);
        assert!(heater.t_furn < 169.0);
    }

    #[test]
    fn power_holds_its_share_of_the_rise_above_the_surroundings() {
        // 20 degC + 300 K * 50 %.
        let mut heater = started(Heater { power: 50.0, ..Heater::default() });
        run(&mut heater, 4000.0);
        assert_close(heater.temp, 170.0, 1e-9);
        assert_eq!(heater.t_per.value(), 11750, "27648 * 170 / 400 = 11750.4");
    }

    #[test]
    fn the_door_divides_the_rise_and_the_time_constant_by_one_plus_the_loss() {
        // L = 1.5: 20 degC + 150 K / 1.5, and 120 s / 1.5 = 80 s.
        let mut heater = started(Heater { power: 50.0, t_start: 170.0, door: 100.0, ..Heater::default() });
        run(&mut heater, 80.0);
        assert_close(heater.t_furn, 120.0 + 50.0 * (-1.0_f64).exp(), 1e-9);
        run(&mut heater, 4000.0);
        assert_close(heater.temp, 120.0, 1e-9);
    }

    #[test]
    fn a_power_step_gives_the_response_of_two_lags_after_the_delay() {
        let mut heater = started(Heater { power: 100.0, ..Heater::default() });
        for k in 1..=6000 {
            heater.call();
            let t = (f64::from(k) / 10.0 - 5.0).max(0.0);
            let furnace = 1.0 - (-t / 120.0).exp();
            let sensor = 1.0 - (120.0 * (-t / 120.0).exp() - 20.0 * (-t / 20.0).exp()) / 100.0;
            assert_close(heater.t_furn, 20.0 + 300.0 * furnace, 1e-9);
            assert_close(heater.temp, 20.0 + 300.0 * sensor, 1e-9);
        }
    }

    #[test]
    fn a_delay_that_is_no_multiple_of_the_cycle_is_exact() {
        // 5.04 s in cycles of 0.1 s: at 5.1 s the furnace has been heated for 0.06 s.
        let mut heater = started(Heater { power: 100.0, delay_tm: 5.04, ..Heater::default() });
        run(&mut heater, 5.0);
        assert_eq!(heater.t_furn, 20.0);
        heater.call();
        assert_close(heater.t_furn, 20.0 + 300.0 * (1.0 - (-0.06_f64 / 120.0).exp()), 1e-12);
    }

    #[test]
    fn the_result_does_not_depend_on_the_cycle() {
        let end = |cycle| {
            let mut heater = started(Heater { cycle: Time::ms(cycle), delay_tm: 2.345, ..Heater::default() });
            let mut temperatures = vec![];
            for second in 0..300 {
                heater.power = f64::from(second * 37 % 101);
                heater.door = f64::from(second * 13 % 101);
                run(&mut heater, 1.0);
                temperatures.push((heater.temp, heater.t_furn));
            }
            temperatures
        };
        for (coarse, fine) in end(1000).iter().zip(end(10)) {
            assert_close(coarse.0, fine.0, 1e-9);
            assert_close(coarse.1, fine.1, 1e-9);
        }
    }

    #[test]
    fn power_and_door_are_limited_to_0_and_100_percent() {
        let end = |power, door| {
            let mut heater = started(Heater { power, door, ..Heater::default() });
            run(&mut heater, 100.0);
            heater.temp.to_bits()
        };
        assert_eq!(end(1e9, -5.0), end(100.0, 0.0));
        assert_eq!(end(-1e9, 200.0), end(0.0, 100.0));
        assert_eq!(end(f64::NAN, f64::NAN), end(0.0, 0.0));
    }

    #[test]
    fn the_delay_may_be_tuned_up_to_its_longest() {
        let first_heat = |delay_tm, tuned| {
            let mut heater = started(Heater { delay_tm, delay_max: 10.0, ..Heater::default() });
            heater.delay_tm = tuned;
            heater.power = 100.0;
            (1..).find(|_| {
                heater.call();
                heater.t_furn > 20.0
            })
        };
        assert_eq!(first_heat(5.0, 8.0), Some(81));
        assert_eq!(first_heat(5.0, 1e6), Some(101), "cut to DELAY_MAX");
        assert_eq!(first_heat(15.0, 15.0), Some(151), "DELAY_TM at the start is longer");
    }

    #[test]
    fn bad_parameters_give_no_nan() {
        for bad in [0.0, -1.0] {
            let mut heater = started(Heater {
                power: 100.0,
                door: 100.0,
                rise: bad,
                furn_tm: bad,
                sens_tm: bad,
                delay_tm: bad,
                delay_max: bad,
                door_loss: bad,
                t_per_0: bad,
                t_per_100: bad,
                ..Heater::default()
            });
            heater.call();
            assert_eq!(heater.temp, 20.0 + bad, "no lag, no delay");
            assert_eq!(heater.t_per.value(), 0);
        }
    }

    #[test]
    fn a_delay_too_long_for_its_memory_is_refused() {
        assert_eq!(Heater::default().check(), Ok(()));
        let error = Heater { delay_tm: 1e9, ..Heater::default() }.check().unwrap_err();
        assert!(error.starts_with("DELAY_TM is 1000000000 s, but "), "{error}");
        let error = Heater { delay_max: 1e9, ..Heater::default() }.check().unwrap_err();
        assert!(error.starts_with("DELAY_MAX is 1000000000 s, but "), "{error}");
    }

    #[test]
    fn saved_and_read_back_it_goes_on_bit_for_bit() {
        let mut heater = started(Heater { delay_tm: 1.23, ..Heater::default() });
        for k in 0..100 {
            heater.power = f64::from(k);
            heater.call();
        }
        let mut bytes = vec![];
        heater.write(&mut bytes);
        let mut again = Heater::read(&mut &bytes[..]).unwrap();
        for _ in 0..100 {
            heater.call();
            again.call();
            for row in 0..Heater::TABLE.rows.len() {
                assert_eq!(heater.get(row), again.get(row));
            }
        }
    }

    /// From 20 degC to the setpoint, with the door half open after 1500 s: the settling time to within 2 % of the step
    /// in seconds and the overshoot in percent, both before the door is opened, and the largest drop below the setpoint
    /// afterwards in K.
    fn controlled_by(controller: ContC, setpoint: f64) -> (usize, f64, f64) {
        let mut furnace = started(Heater::default());
        let mut controller =
            ContC { man_on: false, sp_int: setpoint as f32, pvper_on: true, pv_fac: 4.0, ..controller };
        controller.restart();
        let step = setpoint - 20.0;
        let (mut settled, mut overshoot, mut below) = (0, 0.0_f64, 0.0_f64);
        for second in 0..3000 {
            furnace.door = if second < 1500 { 0.0 } else { 50.0 };
            controller.pv_per = furnace.t_per;
            controller.call();
            furnace.power = f64::from(controller.lmn);
            run(&mut furnace, 1.0);
            let error = setpoint - furnace.temp;
            if second >= 1500 {
                below = below.max(error);
                continue;
            }
            overshoot = overshoot.max(-error / step * 100.0);
            if error.abs() > 0.02 * step {
                settled = second + 1;
            }
        }
        (settled, overshoot, below)
    }

    #[test]
    fn cont_c_with_the_settings_of_the_documentation_does_what_it_says() {
        let pi = |gain, seconds| ContC { gain, ti: Time::ms(1000 * seconds), ..ContC::default() };
        let pid = ContC { d_sel: true, td: Time::ms(16_000), tm_lag: Time::ms(3000), ..pi(4.0, 80) };
        for (controller, setpoint, settled, overshoot, below) in [
            (pi(0.7, 130), 60.0, 133, 0.5, 2.9),
            (pi(0.7, 130), 200.0, 425, 0.0, 12.0),
            (pi(1.4, 80), 60.0, 215, 30.0, 1.9),
            (pi(1.4, 80), 200.0, 275, 0.0, 8.4),
            (pid.clone(), 40.0, 153, 11.6, 0.3),
            (pid, 200.0, 161, 0.0, 3.0),
        ] {
            let (gain, found) = (controller.gain, controlled_by(controller, setpoint));
            let what = format!("GAIN {gain} to {setpoint} degC: {found:?}");
            assert!(found.0.abs_diff(settled) <= 2 && (found.1 - overshoot).abs() < 0.5, "{what}");
            assert!((found.2 - below).abs() < 0.5, "{what}");
        }
    }
}
