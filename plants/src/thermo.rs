//! THERMO: a zone that is heated and cooled, a plant for PULSEGEN and PULS_CTR.

use crate::dynamics::{Lag, Lags, analog, limited, seconds};
use blocks::{Law, Response};

blocks::block! {
    /// Climate chamber that is heated and cooled, with different gains and time constants: pulses in, temperature out.
    ///
    /// # Purpose
    ///
    /// A climate chamber with a heater and a cooler of different strength, for loops whose manipulated value ranges
    /// from -100 to 100 %. It accepts the pulses of PULSEGEN and PULS_CTR directly, or their mean. It shows what
    /// RATIOFAC is for.
    ///
    /// # Quick start
    ///
    /// 1. Connect QPOS_P to HEAT and QNEG_P to COOL, with a communication step of PULSEGEN's CYCLE; or Q_MEAN to DRIVE,
    ///    with any step.
    /// 2. Connect TEMP to PV_IN, or T_PER to PV_PER with PVPER_ON = TRUE, PV_FAC = 2 and PV_OFF = -100.
    /// 3. LMN_LLM = -100 in the controller; RATIOFAC = RISE / DROP = 0.5 in the pulse generator.
    ///
    /// For CONT_C with PULSEGEN: with degC for setpoint and process value, CYCLE and PER_TM 2 s, PULSEGEN's CYCLE 10
    /// ms, LMN_LLM -100, GAIN 15, TI 80 s and RATIOFAC 0.5 the chamber goes from 20 to 50 degC in 155 s without
    /// overshoot. A setpoint step of 5 K then overshoots by less than 0.5 K when heating (50 to 55 degC) and by 1 K
    /// when cooling (0 to -5 degC); with RATIOFAC 1 the latter becomes 2.3 K.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon "°C"
    /// input HEAT 0,4.5
    /// input DRIVE 0,11
    /// input COOL 0,17.5
    /// box DEMAND_H 20,5 "HEAT ? 100 : 0," "+ DRIVE if > 0"
    /// box DEMAND_C 20,17 "COOL ? 100 : 0," "- DRIVE if < 0"
    /// box HEATER 33,5 lag with HEAT_TM
    /// box COOLER 33,17 lag with COOL_TM
    /// box RISE 47,5 multiply with RISE
    /// box DROP 47,17 multiply with DROP
    /// input T_AMB 30,11
    /// input LOAD 53,-1
    /// sum DUTY 56,11 top + left + bottom -
    /// sum REST 61,11 left + top +
    /// box CHAMBER 71,11 lag with ZONE_TM T_START
    /// box ANALOG 70,28 "0 ... 27648" with T_PER_0 T_PER_100
    /// output HEATING 41,-1
    /// output COOLING 41,23
    /// output TEMP 81,11
    /// output T_PER 80,28
    /// box CALL 20,29 "every CYCLE" with CYCLE
    /// HEAT > DEMAND_H.left-0.5
    /// DRIVE > x10 > DEMAND_H.left+0.5
    /// COOL > DEMAND_C.left+0.5
    /// 10,11 > y16.5 > DEMAND_C.left-0.5
    /// DEMAND_H > HEATER > RISE > DUTY.top
    /// DEMAND_C > COOLER > DROP > DUTY.bottom
    /// 39.5,5 > y-1 > HEATING
    /// 39.5,17 > y23 > COOLING
    /// T_AMB > DUTY > REST > CHAMBER > TEMP
    /// LOAD > REST.top
    /// 79,11 > y20 > x59.5 > y28 > ANALOG > T_PER
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// process value: TEMP
    /// manipulated value: DRIVE
    /// pulses: HEAT, COOL
    /// disturbances: T_AMB, LOAD
    /// signal process value peripheral: T_PER
    ///
    /// [Manipulated value]
    /// HEAT, COOL, DRIVE
    /// [Disturbance]
    /// T_AMB, LOAD
    /// [Gain and times]
    /// RISE, DROP, HEAT_TM, COOL_TM, ZONE_TM
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
    /// \text{ZONE_TM}\,\dfrac{d\,\text{TEMP}}{dt} &= \text{T_AMB} + \text{LOAD} - \text{TEMP} \\
    /// &\quad + \text{RISE}\,\dfrac{\text{HEATING}}{100\,\%} - \text{DROP}\,\dfrac{\text{COOLING}}{100\,\%}
    /// \end{aligned}
    /// ```
    ///
    /// The equations:
    ///
    /// ```text
    /// h = (HEAT ? 100 % : 0) + (DRIVE where positive)        within 0 ... 100 %
    /// c = (COOL ? 100 % : 0) - (DRIVE where negative)        within 0 ... 100 %
    /// HEAT_TM dHEATING/dt = h - HEATING
    /// COOL_TM dCOOLING/dt = c - COOLING
    /// ZONE_TM dTEMP/dt = T_AMB + LOAD + RISE (HEATING / 100 %) - DROP (COOLING / 100 %) - TEMP
    /// T_PER = 27648 (TEMP - T_PER_0) / (T_PER_100 - T_PER_0), rounded, within 0 ... 27648
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Call k covers the time from k to k + 1 times CYCLE, with the inputs held; after the call, the outputs are
    ///    those at the end of that time. So use a communication step of CYCLE or a multiple of it; with shorter steps
    ///    the outputs run ahead by part of a CYCLE. Pulses are transferred exactly only with steps of PULSEGEN's CYCLE.
    /// 2. Start: the chamber is at T_START; heater and cooler are off and have no effect.
    /// 3. HEAT and COOL are pulses, QPOS_P and QNEG_P of PULSEGEN. DRIVE is heating (positive) or cooling (negative) in
    ///    percent, such as Q_MEAN or a controller's LMN, and adds to them: connect one or the other. Simultaneous
    ///    heating and cooling is possible; two-step control with HEAT = QPOS_P and COOL = QNEG_P alternates between the
    ///    two.
    /// 4. Steady state: TEMP = T_AMB + LOAD + RISE (h / 100 %) - DROP (c / 100 %).
    /// 5. With the defaults, one percent of cooling changes the temperature twice as much as one percent of heating:
    ///    RATIOFAC = RISE / DROP makes the loop gain the same for both.
    /// 6. Disturbances: T_AMB, the temperature around the chamber, and LOAD, the heat released by the load in the
    ///    chamber, as the temperature rise that it causes.
    /// 7. T_PER is TEMP as an analog input word, for PV_PER, without overrange: it saturates at the ends of its range.
    ///    In the controller, PVPER_ON = TRUE, PV_FAC = (T_PER_100 - T_PER_0) / 100 and PV_OFF = T_PER_0 convert it back
    ///    to degC.
    ///
    /// # Limits of use
    ///
    /// Solved in closed form for held inputs, so the result depends on CYCLE only through rounding (a few parts in
    /// 10^14). The results are the same to the last bit on every platform.
    ///
    /// Heater and cooler act with the same strength at every temperature; the cooler has no lowest temperature.
    ///
    /// Bad input: a time constant not above 0 means no lag.
    pub struct Thermo as "THERMO" {
        input {
            /// Heats at full power
            ///
            /// Connect QPOS_P of PULSEGEN or PULS_CTR. It is sampled at the start of a communication step: use a step
            /// of PULSEGEN's CYCLE, or DRIVE for longer steps.
            heat: Bool = false;
            /// Cools at full power
            ///
            /// Connect QNEG_P. In two-step control leave it unconnected, because there QNEG_P is TRUE whenever QPOS_P
            /// is FALSE.
            cool: Bool = false;
            /// Heating, or cooling if negative
            ///
            /// For a manipulated value instead of pulses: LMN of a controller, or Q_MEAN. With the start values, 40
            /// heats to 24 K above the surroundings and -40 cools to 48 K below. It adds to HEAT and COOL.
            drive: LReal = 0.0, min -100.0, max 100.0, unit "%";
            /// Disturbance: temperature of the surroundings
            ///
            /// The chamber drifts towards it with the time constant ZONE_TM. A change during the run is a slow
            /// disturbance that the I action compensates for.
            t_amb: LReal = 20.0, min -273.15, unit "degC";
            /// Disturbance: temperature rise caused by the load in the chamber
            ///
            /// Heat released by the load in the chamber, as the final temperature rise: 10 needs 17 % less heating or 8
            /// % more cooling.
            load: LReal = 0.0, unit "K";
        }
        parameter {
            /// Temperature of the chamber at the start
            ///
            /// Temperature before the first call, when heater and cooler are off.
            t_start: LReal = 20.0, min -273.15, unit "degC";
            /// Temperature above the surroundings that full heating holds
            ///
            /// The gain of heating: RISE / 100, 0.6 K per percent with the start value. RATIOFAC = RISE / DROP makes
            /// the loop gain the same in both directions.
            rise: LReal = 60.0, unit "K";
            /// Temperature below the surroundings that full cooling holds
            ///
            /// The gain of cooling: 1.2 K per percent with the start value, twice that of heating.
            drop: LReal = 120.0, unit "K";
            /// Time constant of the heater; 0: none
            ///
            /// The lag of the heater before its heat reaches the chamber. It smooths shorter pulses.
            heat_tm: LReal = 10.0, min 0.0, unit "s";
            /// Time constant of the cooler; 0: none
            ///
            /// The lag of the cooler, longer than that of the heater: a loop tuned for heating is less damped when
            /// cooling.
            cool_tm: LReal = 15.0, min 0.0, unit "s";
            /// Time constant of the chamber; 0: none
            ///
            /// The dominant time constant for a tuning rule: a step response reaches 63 % after this time. PER_TM of
            /// the pulses should be a tenth of it or less.
            zone_tm: LReal = 100.0, min 0.0, unit "s";
            /// Temperature at which T_PER is 0
            ///
            /// One end of the analog input's range: at this temperature and below, T_PER is 0. Set PV_OFF of the
            /// controller to the same value.
            t_per_0: LReal = -100.0, unit "degC";
            /// Temperature at which T_PER is 27648
            ///
            /// The other end of the range: at this temperature and above, T_PER is 27648. Set PV_FAC of the controller
            /// to a hundredth of the span, 2 with the start values.
            t_per_100: LReal = 100.0, unit "degC";
        }
        cycle {
            /// Time by which a call advances the chamber
            ///
            /// The plant is solved exactly between two calls, so this time affects the result only through rounding.
            /// Set it to the controller's CYCLE or a fraction of it, and use a communication step of this time or a
            /// multiple of it.
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Temperature of the chamber, for PV_IN
            ///
            /// Connect it to PV_IN of the controller for a process value in degC.
            temp: LReal, from t_start, unit "degC";
            /// Temperature of the chamber as an analog input word, for PV_PER
            ///
            /// Connect it to PV_PER of the controller, with PVPER_ON = TRUE, PV_FAC = 2 and PV_OFF = -100. It saturates
            /// at the ends of its range.
            t_per: Word, from t_start t_per_0 t_per_100;
            /// Output of the heater, after its lag
            ///
            /// 0 ... 100 %: the heating pulses smoothed by HEAT_TM. Shows how much of their ripple reaches the chamber.
            heating: LReal, unit "%";
            /// Output of the cooler, after its lag
            ///
            /// 0 ... 100 %: the cooling pulses smoothed by COOL_TM.
            cooling: LReal, unit "%";
        }
    }
    memory Memory {
        /// The lag of the chamber.
        zone: Lag;
        /// The lags of heater and chamber.
        heater: Lags;
        /// The lags of cooler and chamber.
        cooler: Lags;
    }
}

impl Law for Thermo {
    const HOLDS_INPUTS: bool = true;

    const RESPONSES: &'static [Response] = &[Response {
        title: "40 % heating after 20 s, 40 % cooling after 400 s: twice the change",
        calls: 800,
        set: &[(0, "CYCLE", 1.0), (20, "DRIVE", 40.0), (400, "DRIVE", -40.0)],
        show: &["DRIVE", "HEATING", "COOLING", "TEMP"],
    }];

    fn restart(&mut self) {
        self.clear();
        self.show(self.t_start);
    }

    fn call(&mut self) {
        let cycle = seconds(self.cycle);
        let heat = limited(if self.heat { 100.0 } else { 0.0 } + self.drive.max(0.0), 0.0, 100.0);
        let cool = limited(if self.cool { 100.0 } else { 0.0 } - self.drive.min(0.0), 0.0, 100.0);

        let memory = &mut self.memory;
        // The chamber is linear: the effects of its surroundings, of the heater and of the cooler add up.
        let by_itself = memory.zone.step(self.temp, self.t_amb + self.load, self.zone_tm, cycle);
        let [heating, by_heating] = memory.heater.step([self.heating, 0.0], heat, [self.heat_tm, self.zone_tm], cycle);
        let [cooling, by_cooling] = memory.cooler.step([self.cooling, 0.0], cool, [self.cool_tm, self.zone_tm], cycle);

        self.heating = heating;
        self.cooling = cooling;
        self.show(by_itself + self.rise * by_heating / 100.0 - self.drop * by_cooling / 100.0);
    }
}

impl Thermo {
    fn show(&mut self, temp: f64) {
        self.temp = temp;
        self.t_per = analog(temp, self.t_per_0, self.t_per_100);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Block, ContC, PulsCtr, Pulsegen, Stored, Time};

    fn started(thermo: Thermo) -> Thermo {
        let mut thermo = thermo;
        thermo.restart();
        thermo
    }

    fn run(thermo: &mut Thermo, seconds: f64) {
        let calls = (seconds / crate::dynamics::seconds(thermo.cycle)).round() as u32;
        (0..calls).for_each(|_| thermo.call());
    }

    #[track_caller]
    fn assert_close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b} within {tolerance}");
    }

    #[test]
    fn it_starts_with_its_start_temperature_whatever_the_inputs_are() {
        let thermo =
            Thermo { t_start: 50.0, heat: true, cool: true, drive: 9.0, t_amb: -9.0, load: 5.0, ..Thermo::default() };
        let thermo = started(thermo);
        assert_eq!((thermo.temp, thermo.heating, thermo.cooling), (50.0, 0.0, 0.0));
        assert_eq!(thermo.t_per.value(), 20736, "27648 * 150 / 200");
    }

    #[test]
    fn at_rest_it_stays_at_rest_to_the_last_bit() {
        let mut thermo = started(Thermo { t_amb: 21.3, t_start: 21.3, ..Thermo::default() });
        run(&mut thermo, 100.0);
        assert_eq!((thermo.temp, thermo.heating, thermo.cooling), (21.3, 0.0, 0.0));
    }

    #[test]
    fn heating_cooling_surroundings_and_load_add_up() {
        let settled = |heat, cool, drive, t_amb, load| {
            let mut thermo = Thermo { heat, cool, drive, t_amb, load, cycle: Time::ms(1000), ..Thermo::default() };
            thermo = started(thermo);
            run(&mut thermo, 5000.0);
            thermo.temp
        };
        assert_close(settled(true, false, 0.0, 20.0, 0.0), 80.0, 1e-9);
        assert_close(settled(false, true, 0.0, 20.0, 0.0), -100.0, 1e-9);
        assert_close(settled(true, true, 0.0, 20.0, 0.0), -40.0, 1e-9);
        assert_close(settled(false, false, 25.0, 20.0, 0.0), 35.0, 1e-9);
        assert_close(settled(false, false, -25.0, 20.0, 0.0), -10.0, 1e-9);
        assert_close(settled(false, false, 0.0, -5.0, 7.0), 2.0, 1e-9);
    }

    #[test]
    fn drive_adds_to_the_pulses_and_each_actuator_is_limited_to_100_percent() {
        let after_a_call = |heat, cool, drive| {
            let mut thermo = started(Thermo { heat, cool, drive, heat_tm: 0.0, cool_tm: 0.0, ..Thermo::default() });
            thermo.call();
            (thermo.heating, thermo.cooling)
        };
        assert_eq!(after_a_call(true, false, 50.0), (100.0, 0.0));
        assert_eq!(after_a_call(true, false, -30.0), (100.0, 30.0));
        assert_eq!(after_a_call(false, true, 30.0), (30.0, 100.0));
        assert_eq!(after_a_call(false, false, 1e9), (100.0, 0.0));
        assert_eq!(after_a_call(false, false, -1e9), (0.0, 100.0));
    }

    #[test]
    fn heating_and_cooling_are_two_lags_each_with_its_own_time_constants() {
        for (drive, actuator, change) in [(100.0, 10.0, 60.0), (-100.0, 15.0, -120.0)] {
            let mut thermo = started(Thermo { drive, ..Thermo::default() });
            for second in 1..=600 {
                run(&mut thermo, 1.0);
                let t = f64::from(second);
                let (chamber, own) = ((-t / 100.0).exp(), (-t / actuator).exp());
                let decay = (100.0 * chamber - actuator * own) / (100.0 - actuator);
                assert_close(thermo.temp, 20.0 + change * (1.0 - decay), 1e-9);
                let at_actuator = 100.0 * (1.0 - own);
                assert_close(if drive > 0.0 { thermo.heating } else { thermo.cooling }, at_actuator, 1e-9);
            }
        }
    }

    #[test]
    fn the_result_does_not_depend_on_the_cycle() {
        let end = |cycle| {
            let mut thermo = started(Thermo { cycle: Time::ms(cycle), ..Thermo::default() });
            let mut results = vec![];
            for second in 0..600 {
                thermo.heat = second % 7 < 3;
                thermo.cool = second % 11 < 2;
                thermo.drive = f64::from(second * 37 % 201 - 100);
                thermo.t_amb = f64::from(second % 50);
                run(&mut thermo, 1.0);
                results.push((thermo.temp, thermo.heating, thermo.cooling));
            }
            results
        };
        for (coarse, fine) in end(1000).iter().zip(end(10)) {
            assert_close(coarse.0, fine.0, 1e-10);
            assert_close(coarse.1, fine.1, 1e-10);
            assert_close(coarse.2, fine.2, 1e-10);
        }
    }

    #[test]
    fn bad_parameters_give_no_nan() {
        for bad in [0.0, -1.0] {
            let mut thermo = started(Thermo {
                heat: true,
                heat_tm: bad,
                cool_tm: bad,
                zone_tm: bad,
                t_per_0: bad,
                t_per_100: bad,
                ..Thermo::default()
            });
            thermo.call();
            assert_eq!(thermo.temp, 80.0, "no lags");
            (thermo.heat, thermo.cool) = (false, true);
            thermo.call();
            assert_eq!(thermo.temp, -100.0);
            assert_eq!(thermo.t_per.value(), 0);
        }
    }

    #[test]
    fn saved_and_read_back_it_goes_on_bit_for_bit() {
        let mut thermo = started(Thermo { heat: true, drive: -40.0, ..Thermo::default() });
        run(&mut thermo, 4.0);
        let mut bytes = vec![];
        thermo.write(&mut bytes);
        let mut again = Thermo::read(&mut &bytes[..]).unwrap();
        for _ in 0..100 {
            thermo.call();
            again.call();
            for row in 0..Thermo::TABLE.rows.len() {
                assert_eq!(thermo.get(row), again.get(row));
            }
        }
    }

    /// CONT_C every 2 s and PULSEGEN every 10 ms, each setpoint for 10 min: the settling time to within 1 K, and the
    /// overshoot.
    fn controlled_with(ratiofac: f32, setpoints: &[f64]) -> Vec<(f64, f64)> {
        let mut thermo = started(Thermo::default());
        let mut controller = ContC { man_on: false, pvper_on: true, pv_fac: 2.0, pv_off: -100.0, ..ContC::default() };
        controller = ContC { lmn_llm: -100.0, gain: 15.0, ti: Time::ms(80_000), cycle: Time::ms(2000), ..controller };
        let mut pulses = Pulsegen { per_tm: Time::ms(2000), ratiofac, ..Pulsegen::default() };
        controller.restart();
        pulses.restart();
        let mut results = vec![];
        for &setpoint in setpoints {
            let sign = (setpoint - thermo.temp).signum();
            let (mut settled, mut beyond) = (0.0, f64::MIN);
            for call in 0..60_000 {
                controller.sp_int = setpoint as f32;
                controller.pv_per = thermo.t_per;
                if call % 200 == 0 {
                    controller.call();
                }
                pulses.inv = controller.lmn;
                pulses.call();
                (thermo.heat, thermo.cool) = (pulses.qpos_p, pulses.qneg_p);
                thermo.call();
                if (thermo.temp - setpoint).abs() > 1.0 {
                    settled = f64::from(call + 1) / 100.0;
                }
                beyond = beyond.max(sign * (thermo.temp - setpoint));
            }
            results.push((settled, beyond));
        }
        results
    }

    #[test]
    fn cont_c_and_pulsegen_with_the_settings_of_the_documentation_do_what_it_says() {
        let setpoints = [50.0, 55.0, 50.0, 0.0, -5.0];
        let alike = controlled_with(0.5, &setpoints);
        assert!(alike[0].0 < 155.0 && alike[0].1 < 0.1, "to 50 degC: {:?}", alike[0]);
        assert!(alike[1].1 < 0.5, "5 K upwards: {:?}", alike[1]);
        assert!(alike[4].1 < 1.1, "5 K downwards: {:?}", alike[4]);
        let unlike = controlled_with(1.0, &setpoints);
        assert_eq!(unlike[..2], alike[..2], "nothing is cooled before");
        assert!(unlike[4].1 > 2.0, "5 K downwards: {:?}", unlike[4]);
    }

    #[test]
    fn puls_ctr_controls_it_too() {
        let mut thermo = started(Thermo::default());
        // 50 degC is 75 % of the range of T_PER.
        let mut controller = PulsCtr { sp_int: 75.0, ..PulsCtr::default() };
        controller.di_cont_c.gain = 8.0;
        controller.di_cont_c.ti = Time::ms(60_000);
        controller.restart();
        for _ in 0..60_000 {
            controller.pv_per = thermo.t_per;
            controller.call();
            thermo.heat = controller.qpos_p;
            thermo.call();
        }
        assert_close(thermo.temp, 50.0, 1.0);
    }
}
