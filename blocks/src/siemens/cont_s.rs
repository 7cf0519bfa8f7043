//! CONT_S (FB 42): the PI step controller.

use crate::siemens::advice;
use crate::siemens::error_signal::{dead_band, process_value};
use crate::table::{Law, Real, Response, Time};

crate::block! {
    /// PI step controller for a motor-driven actuator without position feedback, with manual pulses (FB 42).
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon three_step
    /// input SP_INT 0,3
    /// input PV_IN 0,8
    /// input PV_PER 0,13
    /// box CRP_IN 11,13 analog_input
    /// box PV_NORM 21,13 normalize with PV_FAC PV_OFF
    /// switch PVPER_ON 31,9 TRUE lower
    /// sum E 37,3 left + bottom -
    /// box DEADBAND 45,3 dead_band with DEADB_W
    /// box GAIN 58,3 multiply with GAIN
    /// output PV 40,9
    /// output ER 54,9
    /// SP_INT > E > DEADBAND
    /// PV_IN > PVPER_ON.FALSE
    /// PV_PER > CRP_IN > PV_NORM > x28 > PVPER_ON.TRUE
    /// PV: PVPER_ON > E.bottom
    /// 37,9 > PV
    /// ER: DEADBAND > GAIN
    /// 52,3 > y9 > ER
    /// text 63,2.2 "e"
    ///
    /// // e, minus position and I action, plus DISV, to the pulses
    /// GAIN > x65 > y19.5 > x2 > y29 > STEP
    /// text 3,28.2 "e"
    /// sum STEP 10,29 left + bottom -
    /// input DISV 8,24
    /// sum FF 16,29 left + top +
    /// box THREE_ST 24,29 three_step
    /// text 17.7,28.2 "z"
    /// switch LMNS_ON 40,25 TRUE lower
    /// switch DOWN 40,34 TRUE lower by LMNS_ON
    /// input LMNUP 31,26
    /// input LMNDN 31,35
    /// box PULSEOUT 52,29 pulses with PULSE_TM BREAK_TM LMNR_HS LMNR_LS
    /// output QLMNUP 66,26
    /// output QLMNDN 66,32
    /// DISV > FF.top
    /// STEP > FF > THREE_ST
    /// THREE_ST.right-1 > x29 > LMNS_ON.FALSE
    /// THREE_ST.right+1 > x29 > DOWN.FALSE
    /// LMNUP > LMNS_ON.TRUE
    /// LMNDN > DOWN.TRUE
    /// LMNS_ON > x44 > PULSEOUT.left-1
    /// DOWN > x44 > PULSEOUT.left+1
    /// PULSEOUT.right-1 > x60 > QLMNUP
    /// PULSEOUT.right+1 > x60 > QLMNDN
    ///
    /// // the pulses back: the assumed travel of the valve
    /// box MEAN 69,40 mean
    /// output QLMN_MEAN 73,40
    /// box MOTOR 52,46 "+100, 0, -100 %" with MTR_TM
    /// sum RATE 36,46 right + bottom -
    /// box INT 22,46 integrate
    /// box PAUSE 22,55 "e / Te," "in pauses" with TI
    /// 63,26 > y39.5 > MEAN.left-0.5
    /// 62,32 > y40.5 > MEAN.left+0.5
    /// MEAN > QLMN_MEAN
    /// 63,39.5 > y45.5 > MOTOR.right-0.5
    /// 62,40.5 > y46.5 > MOTOR.right+0.5
    /// MOTOR.left > RATE.right
    /// RATE.left > INT.right
    /// INT.left > STEP.bottom
    /// 2,29 > y55 > PAUSE
    /// PAUSE > RATE.bottom
    /// text 11,45.2 "F"
    /// text 22,48.8 "F = 0 with LMNS_ON" middle
    ///
    /// box RESTART 75,3 "outputs = 0" "memory = 0" with COM_RST
    /// box CALL 75,13 "every CYCLE" with CYCLE
    /// ```
    ///
    /// # Law
    ///
    /// The law of a call, in this order; every operation rounds to a 32-bit REAL, `a` is the pulse that has been
    /// running since an earlier call (+1 up, -1 down, 0 none):
    ///
    /// ```text
    /// PV     = PVPER_ON ? ((PV_PER * 0.003616898) * PV_FAC) + PV_OFF : PV_IN
    /// ER     = dead band of half width DEADB_W over SP_INT - PV
    /// e      = ER * GAIN
    /// T      = CYCLE,  M = max(MTR_TM, T),  Ti = max(TI, T / 2)                                in seconds
    /// F      = 0                              with LMNS_ON
    ///          F + (((100 * a) * T) / M)      while a pulse runs
    ///          F - ((e * T) / Te)             in pauses,      Te = max(Ti - |(0.01 * e) * M|, 0.1 * Ti)
    /// z      = (e - F) + DISV
    /// off    = (55 * T) / M
    /// lowest = (100 * max(PULSE_TM, CYCLE)) / M
    /// on     = max(min(|e|, |F|, 10), lowest)
    /// demand = +1 if z >= on, or still if z > off
    ///          -1 if z <= -on, or still if z < -off
    ///          0 otherwise;  with LMNS_ON: LMNUP - LMNDN
    /// a      = demand, as far as the stops, PULSE_TM and BREAK_TM allow
    /// QLMNUP = (a = +1),  QLMNDN = (a = -1)
    /// ```
    ///
    /// 1. Restart (COM_RST): all outputs are FALSE / 0, and so is all memory: a running pulse ends at once, whatever is
    ///    left of PULSE_TM. The block does not reset COM_RST: while it is TRUE, every call is a restart. (manual)
    /// 2. Process value: PV_FAC and PV_OFF act on the analog value PV_PER only (manual). 100/27648 is multiplied as a
    ///    REAL (measured). Dead band: ER = x + DEADB_W below -DEADB_W, x - DEADB_W above DEADB_W, else 0. (vendor)
    /// 3. Times have lower bounds: MTR_TM is at least CYCLE, TI at least CYCLE / 2. (vendor)
    /// 4. One integrator F holds both the assumed position of the valve and the I action (manual). During a pulse it
    ///    moves with the motor, and the error is not integrated; in pauses it integrates the error with the shorter
    ///    reset time Te, which compensates for the pulses: the mean rate is e / TI while |e| MTR_TM / 100 stays below
    ///    0.9 TI (measured). The I action that is missed during the first pulse is not compensated: at the end of a
    ///    pulse the travel is e^2 MTR_TM / (100 TI) behind e (1 + t / TI), and further behind between pulses. The first
    ///    pulse lasts e MTR_TM / 100 only if |e| MTR_TM / 100 is well below TI, otherwise longer.
    /// 5. Pauses integrate nothing while the valve is reported at the stop that e pushes against. (measured)
    /// 6. LMNS_ON holds F at 0, so the change back to automatic may bump. (vendor)
    /// 7. TI = 0 switches the I action off. Then F is the position only, and is held within 0 ... 100. (vendor; numbers
    ///    measured)
    /// 8. The on threshold is adapted: few long pulses while the error is large, short ones near the setpoint. With TI
    ///    above 0 it follows the formula; with TI = 0, |e| / 2 replaces min(|e|, |F|), or 0 if PV is 0. If either stop
    ///    is reported, it is `lowest`, also during a pulse; otherwise a pulse keeps the threshold it began with. It is
    ///    adapted in manual mode too. (that it is adapted: vendor; numbers measured)
    /// 9. Three-step element: on at the on threshold, off at the off threshold, with z compared as in the formula.
    ///    (vendor)
    /// 10. Manual pulses: with LMNS_ON, LMNUP alone demands a pulse up, LMNDN alone a pulse down, both or neither
    ///     demand none. (manual, vendor)
    /// 11. A demand against a reported stop is ignored, and so is a demand against the running pulse: between up and
    ///     down there is at least one call with both outputs FALSE. (vendor)
    /// 12. A pulse lasts at least PULSE_TM even if the demand ends earlier, and the break after it at least BREAK_TM;
    ///     this holds for manual pulses too. Both times are counted in calls: with CYCLE 1 s, 3 s are three calls.
    ///     (manual, vendor)
    /// 13. A pulse against a reported stop ends at once, whatever is left of PULSE_TM (vendor). If something was left,
    ///     no break is needed after it; otherwise BREAK_TM applies (measured).
    /// 14. It follows from clauses 11 to 13 that both outputs are never TRUE together, that up and down never follow
    ///     each other in consecutive calls, and that no pulse runs against a reported stop.
    /// 15. QLMN_MEAN is ours, not the manual's: the mean of the pulses over the last communication step, +100 % if up
    ///     all the time, -100 % if down all the time; in a step without a call, the state of the outputs. A Real plant
    ///     input and steps longer than CYCLE need it, because QLMNUP and QLMNDN show only the last call. (decided)
    ///
    /// Sampling: the block computes with CYCLE and must be called that often. A pulse is a whole number of calls, so
    /// the valve moves in steps of 100 CYCLE / MTR_TM percent.
    ///
    /// Bad input: the block checks no parameter. An internal overflow may leave the integrator infinite or NaN, and the
    /// automatic mode stops working; COM_RST or LMNS_ON clears it.
    ///
    /// Decided: QLMN_MEAN. The manual's table says that QLMNDN opens the valve; this is a misprint: QLMNDN closes it.
    ///
    /// Source: Standard Software for S7-300 and S7-400, PID Control, User Manual (C79000-G7076-C516), section 3.2,
    /// figure 3-2, tables 3-3 and 3-4; recordings at the terminals of real blocks.
    pub struct ContS as "CONT_S" | "FB 42" | "SFB 42" {
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            com_rst: Bool = false;
            /// The actuator is at its upper limit stop
            lmnr_hs: Bool = false;
            /// The actuator is at its lower limit stop
            lmnr_ls: Bool = false;
            /// Manual mode: LMNUP and LMNDN make the pulses
            lmns_on: Bool = false;
            /// Manual pulse up
            lmnup: Bool = false;
            /// Manual pulse down
            lmndn: Bool = false;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            pvper_on: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            sp_int: Real = 0.0;
            /// Process value as a floating point number, -100 ... 100 % or a physical value
            pv_in: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            pv_per: Word = Word::new(0);
        }
        parameter {
            /// Proportional gain
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE, 0 switches the integral action off
            ti: Time = Time::ms(20_000);
            /// Dead band: half the width of the band in which the error counts as 0, 0 ... 100 % or a physical value
            deadb_w: Real = 1.0, min 0.0;
            /// Factor of the process value from PV_PER
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            pv_off: Real = 0.0;
            /// Minimum length of a pulse; range: PULSE_TM >= CYCLE
            pulse_tm: Time = Time::ms(3_000);
            /// Minimum length of the break between pulses; range: BREAK_TM >= CYCLE
            break_tm: Time = Time::ms(3_000);
            /// Time the actuator needs from limit stop to limit stop; range: MTR_TM >= CYCLE
            mtr_tm: Time = Time::ms(30_000);
        }
        input {
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            disv: Real = 0.0;
        }
        output {
            /// Pulse up: opens the valve
            qlmnup: Bool;
            /// Pulse down: closes the valve
            qlmndn: Bool;
            /// Process value in use
            pv: Real;
            /// Error after the dead band
            er: Real;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step in percent, up positive (not in the manual)
        qlmn_mean;
    }
    memory Memory {
        /// The running pulse: +1 up, -1 down, 0 none.
        pulse: i32;
        /// The integrator: assumed valve position and I action in one.
        f: Real;
        /// The adapted on threshold.
        on: Real;
        /// Rest of the minimum pulse time, in milliseconds.
        pulse_left: i32;
        /// Rest of the minimum break time, in milliseconds.
        break_left: i32;
    }
}

impl Law for ContS {
    const RESPONSES: &'static [Response] = &[Response {
        title: "Setpoint 11: a long pulse for the P action, then short ones for the I action; back at 0 the P action is \
                taken back and the I action stays; at -6 the I action moves down",
        calls: 140,
        set: &[(5, "SP_INT", 11.0), (48, "SP_INT", 0.0), (70, "SP_INT", -6.0)],
        show: &["SP_INT", "ER", "QLMNUP", "QLMNDN"],
    }];

    fn restart(&mut self) {
        self.clear();
    }

    #[inline(always)]
    fn call(&mut self) {
        if self.com_rst {
            return self.restart();
        }
        self.pv = if self.pvper_on { process_value(self.pv_per, self.pv_fac, self.pv_off) } else { self.pv_in };
        self.er = dead_band(self.sp_int - self.pv, self.deadb_w);
        let e = self.er * self.gain;

        let t = self.cycle.seconds();
        let m = self.mtr_tm.seconds().max(t);

        self.memory.f = self.integral(e, t, m);
        self.memory.on = self.on_threshold(e, m);
        let demand = if self.lmns_on {
            i32::from(self.lmnup) - i32::from(self.lmndn)
        } else {
            self.three_step((e - self.memory.f) + self.disv, (55.0 * t) / m)
        };
        let reversal = demand * self.memory.pulse < 0;
        self.pulse_stage(if reversal || self.at_stop(demand > 0, demand < 0) { 0 } else { demand });

        self.qlmnup = self.memory.pulse > 0;
        self.qlmndn = self.memory.pulse < 0;
    }

    fn advice(&self) -> Vec<String> {
        advice::cont_s(self)
    }

    fn pulse(&self) -> i32 {
        self.memory.pulse
    }
}

impl ContS {
    /// Whether the valve is reported at the stop that lies in this direction.
    fn at_stop(&self, up: bool, down: bool) -> bool {
        (up && self.lmnr_hs) || (down && self.lmnr_ls)
    }

    /// The integrator F after this call.
    fn integral(&self, e: Real, t: Real, m: Real) -> Real {
        let Memory { f, pulse, .. } = self.memory;
        if self.lmns_on {
            return 0.0;
        }
        if self.ti > Time::ZERO {
            if pulse != 0 {
                f + (((100.0 * pulse as Real) * t) / m)
            } else if self.at_stop(e > 0.0, e < 0.0) {
                f
            } else {
                let ti = self.ti.seconds().max(t * 0.5);
                let te = (ti - ((0.01 * e) * m).abs()).max(0.1 * ti);
                f - ((e * t) / te)
            }
        } else {
            (f + (((100.0 * pulse as Real) * t) / m)).clamp(0.0, 100.0)
        }
    }

    /// The on threshold in this call.
    fn on_threshold(&self, e: Real, m: Real) -> Real {
        let lowest = (100.0 * self.pulse_tm.max(self.cycle).seconds()) / m;
        if self.lmnr_hs || self.lmnr_ls {
            lowest
        } else if self.memory.pulse != 0 {
            self.memory.on
        } else {
            let want = if self.ti > Time::ZERO {
                e.abs().min(self.memory.f.abs())
            } else if self.pv == 0.0 {
                0.0
            } else {
                e.abs() * 0.5
            };
            want.min(10.0).max(lowest)
        }
    }

    /// THREE_ST: the direction in which the valve should go.
    fn three_step(&self, z: Real, off: Real) -> i32 {
        let Memory { pulse, on, .. } = self.memory;
        if (pulse > 0 && z > off) || z >= on {
            1
        } else if (pulse < 0 && z < -off) || z <= -on {
            -1
        } else {
            0
        }
    }

    /// PULSEOUT: minimum pulse and minimum break, and the stops.
    fn pulse_stage(&mut self, demand: i32) {
        let stopped = self.at_stop(self.memory.pulse > 0, self.memory.pulse < 0);
        let memory = &mut self.memory;
        if stopped || (memory.pulse != 0 && demand == 0 && memory.pulse_left == 0) {
            memory.break_left = if memory.pulse_left > 0 { 0 } else { self.break_tm.milliseconds() };
            memory.pulse_left = 0;
            memory.pulse = 0;
        } else if memory.pulse == 0 && demand != 0 && memory.break_left == 0 {
            memory.pulse_left = self.pulse_tm.milliseconds();
            memory.pulse = demand;
        }
        memory.pulse_left = memory.pulse_left.saturating_sub(self.cycle.milliseconds()).max(0);
        memory.break_left = memory.break_left.saturating_sub(self.cycle.milliseconds()).max(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Block, Word};

    fn restarted(mut block: ContS) -> ContS {
        block.restart();
        block
    }

    /// The pulse of the last call as a letter: Up, Down or none.
    fn letter(block: &ContS) -> char {
        match (block.qlmnup, block.qlmndn) {
            (true, true) => '!',
            (true, false) => 'U',
            (false, true) => 'D',
            (false, false) => '.',
        }
    }

    /// One letter a call; `before` is shown the number of each call, from 1 on, and may set inputs.
    fn pulses_with(block: &mut ContS, calls: usize, before: impl Fn(usize, &mut ContS)) -> String {
        let call = |number| {
            before(number, block);
            block.call();
            letter(block)
        };
        (1..=calls).map(call).collect()
    }

    fn pulses(block: &mut ContS, calls: usize) -> String {
        pulses_with(block, calls, |_, _| ())
    }

    /// Without I action, minimum times of a call, 10 % a call: the valve follows e.
    fn position_only() -> ContS {
        ContS {
            gain: 1.0,
            deadb_w: 0.0,
            ti: Time::ms(0),
            mtr_tm: Time::ms(10_000),
            pulse_tm: Time::ms(1_000),
            break_tm: Time::ms(1_000),
            ..ContS::default()
        }
    }

    /// As above, but 1 % a call and with thresholds from 1 % on.
    fn slow_motor() -> ContS {
        ContS { mtr_tm: Time::ms(100_000), ..position_only() }
    }

    /// Fine pulses: 0.1 s of 30 s.
    fn pi(e: Real) -> ContS {
        ContS {
            gain: 1.0,
            deadb_w: 0.0,
            cycle: Time::ms(100),
            pulse_tm: Time::ms(100),
            break_tm: Time::ms(100),
            sp_int: e,
            ..ContS::default()
        }
    }

    fn manual() -> ContS {
        ContS { lmns_on: true, ..ContS::default() }
    }

    #[test]
    fn clause_1_a_restart_cuts_a_pulse_at_once_and_clears_all_outputs() {
        let mut block = restarted(ContS { sp_int: 11.0, pv_in: -3.0, ..ContS::default() });
        assert_eq!(pulses(&mut block, 1), "U");
        block.com_rst = true;
        block.call();
        assert_eq!((block.qlmnup, block.qlmndn, block.pv, block.er), (false, false, 0.0, 0.0));
        assert_eq!(block.memory.pulse_left, 0);
    }

    #[test]
    fn clause_1_after_a_restart_no_break_has_to_pass() {
        let run = |calls_before| {
            let mut block = ContS { sp_int: 11.0, ..ContS::default() };
            pulses(&mut block, calls_before);
            block.restart();
            pulses(&mut block, 60)
        };
        assert_eq!(run(8), run(0));
    }

    #[test]
    fn clause_1_while_com_rst_is_true_every_call_is_a_restart() {
        let mut block = restarted(ContS { sp_int: 11.0, com_rst: true, ..ContS::default() });
        assert_eq!(pulses(&mut block, 3), "...");
        assert!(block.com_rst);
    }

    #[test]
    fn clause_2_process_value_and_error_are_made_as_in_cont_c() {
        let mut block = ContS { pv_in: 7.0, pv_per: Word::new(13824), pv_fac: 4.0, pv_off: -50.0, ..ContS::default() };
        block.call();
        assert_eq!((block.pv, block.er), (7.0, -6.0));
        block.pvper_on = true;
        block.call();
        assert_eq!((block.pv, block.er), (150.0, -149.0));
    }

    #[test]
    fn clause_3_a_motor_time_below_a_cycle_counts_as_a_cycle() {
        // The valve moves 100 % a call; 55 % is the off threshold.
        let travel = |mtr_tm| {
            let block = ContS { sp_int: 160.0, mtr_tm: Time::ms(mtr_tm), ti: Time::ms(1_000_000), ..position_only() };
            pulses(&mut restarted(block), 5)
        };
        assert_eq!(travel(1_000), "UU...");
        assert_eq!(travel(0), "UU...");
    }

    #[test]
    fn clause_3_a_reset_time_below_half_a_cycle_counts_as_half_a_cycle() {
        let integral = |ti| {
            let mut block = restarted(ContS { sp_int: 0.1, ti: Time::ms(ti), ..slow_motor() });
            block.call();
            block.memory.f
        };
        assert_eq!(integral(1), integral(500));
        // Te = 0.5 s - 0.01 * 0.1 * 100 s
        assert!((integral(500) + 0.1 / 0.4).abs() < 1e-6);
    }

    #[test]
    fn clause_4_the_first_pulse_takes_the_valve_as_far_as_the_p_action_asks() {
        // e % of 30 s in calls of 0.1 s
        for (e, calls) in [(1.0, 3), (5.0, 15), (20.0, 60)] {
            let first = pulses(&mut restarted(pi(e)), 100);
            assert_eq!(first.find('.'), Some(calls), "e {e}: {first}");
        }
    }

    #[test]
    fn clause_4_between_pulses_the_valve_moves_at_the_rate_of_the_i_action() {
        for e in [1.0, 5.0, 20.0, -5.0] {
            let run = pulses(&mut restarted(pi(e)), 400_000);
            let up = |letter: &u8| *letter != b'.';
            let letters = run.as_bytes();
            let starts: Vec<_> = (1..letters.len()).filter(|&k| up(&letters[k]) && !up(&letters[k - 1])).collect();
            let (first, last) = (starts[0], starts[starts.len() - 1]);
            let travel = letters[first..last].iter().filter(|letter| up(letter)).count() as f64 * (100.0 * 0.1 / 30.0);
            let rate = travel / ((last - first) as f64 * 0.1);
            let ideal = f64::from(e).abs() / 20.0;
            assert!((rate / ideal - 1.0).abs() < 2e-4, "e {e}: {rate} % a second, not {ideal}");
        }
    }

    #[test]
    fn clause_4_the_time_of_the_first_pulse_is_not_made_up() {
        // e^2 MTR_TM / (100 TI) = 6 % behind 20 (1 + t / 20), give or take a pulse.
        let calls = 400_000;
        let run = pulses(&mut restarted(pi(20.0)), calls);
        let travel = run.matches('U').count() as f64 * (100.0 * 0.1 / 30.0);
        let behind = 20.0 * (1.0 + calls as f64 * 0.1 / 20.0) - travel;
        assert!((behind - 6.0).abs() < 10.0, "{behind} %");
    }

    #[test]
    fn clause_4_the_defaults_with_a_setpoint_of_11() {
        let run = pulses(&mut restarted(ContS { sp_int: 11.0, ..ContS::default() }), 60);
        assert_eq!(run, "UUUUUU......UUU.......UUU.......UUU.......UUU.......UUU.....");
    }

    #[test]
    fn clause_4_the_defaults_with_a_setpoint_of_minus_6() {
        let run = pulses(&mut restarted(ContS { sp_int: -6.0, ..ContS::default() }), 40);
        assert_eq!(run, "DDD................DDD.................D");
    }

    #[test]
    fn clause_4_a_large_error_shortens_the_reset_time_to_a_tenth_at_most() {
        // 0.01 * 50 * 30 s leaves 5 s of 20; 0.01 * 500 * 30 s would leave less than nothing.
        let slope = |e: Real| {
            let mut block = restarted(ContS { lmnr_hs: true, sp_int: -e, ..pi(0.0) });
            block.call();
            block.memory.f
        };
        assert!((slope(50.0) - 50.0 * 0.1 / 5.0).abs() < 1e-5);
        assert!((slope(500.0) - 500.0 * 0.1 / 2.0).abs() < 1e-4);
    }

    #[test]
    fn clause_4_every_operation_rounds_in_the_order_of_the_formulas() {
        // In another order the last digit is another: -0.35275745, and 0.043478258 for the pulse.
        let (cycle, mtr_tm, ti) = (Time::ms(700), Time::ms(41_000), Time::ms(17_000));
        let mut block = restarted(ContS { cycle, mtr_tm, ti, ..pi(7.1) });
        block.call();
        assert_eq!(block.memory.f, -0.35275742);

        for ti in [0, 20_000] {
            let (cycle, mtr_tm, ti) = (Time::ms(10), Time::ms(23_000), Time::ms(ti));
            let mut block = restarted(ContS { cycle, mtr_tm, ti, lmnup: true, ..manual() });
            block.call();
            block.lmns_on = false;
            block.call();
            assert_eq!(block.memory.f, 0.04347826);
        }
    }

    #[test]
    fn clause_5_the_error_is_not_integrated_against_a_reported_stop() {
        let integral = |sp_int, lmnr_hs, lmnr_ls| {
            let mut block = restarted(ContS { sp_int, lmnr_hs, lmnr_ls, ..pi(0.0) });
            block.call();
            block.memory.f
        };
        assert_eq!(integral(5.0, true, false), 0.0);
        assert_eq!(integral(-5.0, false, true), 0.0);
        assert!(integral(5.0, false, true) < 0.0);
        assert!(integral(-5.0, true, false) > 0.0);
    }

    #[test]
    fn clause_6_manual_mode_holds_the_integrator_at_0_so_that_the_change_back_bumps() {
        let mut block = restarted(ContS { sp_int: 11.0, ..ContS::default() });
        assert_eq!(pulses(&mut block, 12), "UUUUUU......");
        let automatic = pulses(&mut block.clone(), 1);
        block.lmns_on = true;
        block.call();
        assert_eq!(block.memory.f, 0.0);
        block.lmns_on = false;
        // At rest it would have made one short pulse; now it goes all the way again.
        assert_eq!((automatic.as_str(), pulses(&mut block, 8).as_str()), ("U", "UUUUUU.."));
    }

    #[test]
    fn clause_7_without_i_action_the_valve_goes_to_e_and_rests() {
        let run = pulses(&mut restarted(ContS { sp_int: 40.0, ..position_only() }), 30);
        assert_eq!(run, "UUUU..........................");
    }

    #[test]
    fn clause_7_without_i_action_the_assumed_position_stays_within_0_and_100_percent() {
        // From 0 it cannot go down, and at 100 it does not reach 150: the pulse lasts until a stop is reported.
        for (setpoint, letter) in [(-40.0, "D"), (150.0, "U")] {
            let mut block = restarted(ContS { sp_int: setpoint, ..position_only() });
            assert_eq!(pulses(&mut block, 40), letter.repeat(40));
        }
    }

    #[test]
    fn clause_7_a_negative_position_becomes_0_when_the_i_action_is_switched_off() {
        let mut block = restarted(ContS { sp_int: 3.0, ti: Time::ms(1_000), lmns_on: false, ..slow_motor() });
        block.lmnr_hs = false;
        block.call();
        assert!(block.memory.f < 0.0);
        block.ti = Time::ms(0);
        block.sp_int = 0.0;
        block.lmnr_hs = true;
        block.call();
        assert!(block.memory.f >= 0.0);
    }

    #[test]
    fn clause_8_the_on_threshold_is_capped_at_10() {
        // After 20 % up, F falls by 20 / (1000 - 0.2 * 100) a call; 10 % take 490 calls, 1 % would take 49.
        let mut block = restarted(ContS { sp_int: 20.0, ti: Time::ms(1_000_000), ..slow_motor() });
        let run = pulses(&mut block, 600);
        let rest = &run[20..];
        assert!(run.starts_with(&"U".repeat(20)) && rest.starts_with('.'), "{run}");
        let pause = rest.find('U').unwrap();
        assert!((480..=500).contains(&pause), "{pause} calls");
    }

    #[test]
    fn clause_8_below_10_the_on_threshold_is_the_smaller_of_error_and_integrator() {
        let threshold = |e, f| {
            let mut block = restarted(ContS { sp_int: e, ti: Time::ms(1_000_000_000), ..slow_motor() });
            block.memory.f = f;
            block.call();
            block.memory.on
        };
        assert!((threshold(6.0, 8.0) - 6.0).abs() < 1e-5);
        assert!((threshold(-6.0, -8.0) - 6.0).abs() < 1e-5);
        assert!((threshold(8.0, 6.0) - 6.0).abs() < 1e-5);
        assert!((threshold(8.0, -6.0) - 6.0).abs() < 1e-5);
        assert_eq!(threshold(0.5, 8.0), 1.0);
    }

    #[test]
    fn clause_8_the_lowest_threshold_is_the_way_of_the_shortest_pulse() {
        let threshold = |pulse_tm| {
            let mut block = restarted(ContS { pulse_tm: Time::ms(pulse_tm), ..slow_motor() });
            block.call();
            block.memory.on
        };
        assert_eq!((threshold(4_000), threshold(1_000), threshold(0)), (4.0, 1.0, 1.0));
        // The lowest threshold may lie above the cap.
        assert_eq!(threshold(20_000), 20.0);
        let (cycle, mtr_tm) = (Time::ms(10), Time::ms(23_000));
        let mut block = restarted(ContS { cycle, mtr_tm, pulse_tm: cycle, ..slow_motor() });
        block.call();
        assert_eq!(block.memory.on, 0.04347826);
    }

    #[test]
    fn clause_8_a_reported_stop_sets_the_lowest_threshold_also_during_a_pulse() {
        for (lmnr_hs, lmnr_ls) in [(true, false), (false, true)] {
            let mut block = restarted(ContS { sp_int: 8.0, pv_in: -8.0, lmnr_hs, lmnr_ls, ..slow_motor() });
            block.call();
            assert_eq!(block.memory.on, 1.0);
        }
        let mut block = restarted(ContS { sp_int: 8.0, pv_in: -8.0, ..slow_motor() });
        assert_eq!(pulses(&mut block, 2), "UU");
        assert_eq!(block.memory.on, 8.0);
        block.lmnr_ls = true;
        assert_eq!(pulses(&mut block, 1), "U");
        assert_eq!(block.memory.on, 1.0);
        block.lmnr_ls = false;
        assert_eq!(pulses(&mut block, 1), "U");
        assert_eq!(block.memory.on, 1.0);
    }

    #[test]
    fn clause_8_a_pulse_keeps_the_threshold_it_began_with() {
        let mut block = restarted(ContS { sp_int: 8.0, pv_in: -8.0, ..slow_motor() });
        block.call();
        block.sp_int = 4.0;
        block.call();
        assert_eq!((letter(&block), block.memory.on), ('U', 8.0));
    }

    #[test]
    fn clause_8_without_i_action_the_threshold_is_half_the_error_or_the_lowest_at_a_process_value_of_0() {
        let first = |sp_int, pv_in| {
            let mut block = restarted(ContS { sp_int, pv_in, disv: -5.0, ..slow_motor() });
            (pulses(&mut block, 1), block.memory.on)
        };
        // e = 8, so z = 3: below 4, above 1.
        assert_eq!(first(10.0, 2.0), (".".into(), 4.0));
        assert_eq!(first(8.0, 0.0), ("U".into(), 1.0));
    }

    #[test]
    fn clause_8_the_threshold_is_adapted_in_manual_mode_too() {
        let mut block = restarted(ContS { sp_int: 8.0, pv_in: -8.0, lmns_on: true, ..slow_motor() });
        block.call();
        assert_eq!(block.memory.on, 8.0);
    }

    #[test]
    fn clause_9_a_pulse_starts_at_the_on_threshold_and_not_below() {
        let first = |sp_int| pulses(&mut restarted(ContS { sp_int, ..position_only() }), 1);
        assert_eq!([first(10.0), first(9.99), first(-10.0), first(-9.99)], ["U", ".", "D", "."]);
    }

    #[test]
    fn clause_9_a_pulse_ends_at_the_off_threshold() {
        // 55 % of a call's way, 5.5 %, of what is left after four calls; exactly there it ends.
        let run = |sp_int| pulses(&mut restarted(ContS { sp_int, ..position_only() }), 8);
        assert_eq!([run(44.0), run(45.5), run(46.0)], ["UUUU....", "UUUU....", "UUUUU..."]);
    }

    #[test]
    fn clause_9_the_off_threshold_is_55_percent_of_what_the_valve_moves_in_a_call() {
        // Half a second is 5 % here: 2.75 %.
        let run = |sp_int| {
            let block = ContS { sp_int, cycle: Time::ms(500), pulse_tm: Time::ms(500), ..position_only() };
            pulses(&mut restarted(block), 12)
        };
        assert_eq!([run(42.5), run(43.0)], ["UUUUUUUU....", "UUUUUUUUU..."]);
    }

    #[test]
    fn clause_9_a_pulse_down_ends_at_the_off_threshold() {
        let run = |target| {
            let mut block = restarted(ContS { sp_int: 100.0, ..position_only() });
            assert_eq!(pulses(&mut block, 12), "UUUUUUUUUU..");
            block.sp_int = target;
            pulses(&mut block, 8)
        };
        assert_eq!([run(56.0), run(54.5), run(54.0)], ["DDDD....", "DDDD....", "DDDDD..."]);
    }

    #[test]
    fn clause_9_the_disturbance_variable_is_fed_forward() {
        let run = |disv| pulses(&mut restarted(ContS { disv, sp_int: 40.0, ..position_only() }), 8);
        assert_eq!([run(20.0), run(-20.0)], ["UUUUUU..", "UU......"]);
    }

    #[test]
    fn clause_9_the_integrator_is_subtracted_before_the_disturbance_variable_is_added() {
        // (1e8 - 50) - 1e8 is -48 in a REAL, within +-49; (1e8 - 1e8) - 50 would be beyond.
        let block = ContS { sp_int: 1e8, disv: -1e8, pulse_tm: Time::ms(49_000), ..slow_motor() };
        let mut block = restarted(block);
        block.memory.f = 50.0;
        assert_eq!(pulses(&mut block, 1), ".");
        assert_eq!((block.memory.f, block.memory.on), (50.0, 49.0));
    }

    #[test]
    fn clause_10_one_manual_signal_makes_a_pulse_both_or_neither_none() {
        let pulse = |lmnup, lmndn| pulses(&mut restarted(ContS { lmnup, lmndn, sp_int: 50.0, ..manual() }), 2);
        assert_eq!(pulse(true, false), "UU");
        assert_eq!(pulse(false, true), "DD");
        assert_eq!(pulse(true, true), "..");
        assert_eq!(pulse(false, false), "..");
    }

    #[test]
    fn clause_10_manual_signals_count_with_lmns_on_only() {
        assert_eq!(pulses(&mut restarted(ContS { lmnup: true, ..ContS::default() }), 3), "...");
    }

    #[test]
    fn clause_11_a_demand_against_a_reported_stop_starts_no_pulse() {
        let pulse = |sp_int, lmnr_hs, lmnr_ls| {
            pulses(&mut restarted(ContS { sp_int, lmnr_hs, lmnr_ls, ..ContS::default() }), 2)
        };
        assert_eq!(pulse(21.0, true, false), "..");
        assert_eq!(pulse(-21.0, false, true), "..");
        assert_eq!(pulse(21.0, false, true), "UU");
        assert_eq!(pulse(-21.0, true, false), "DD");
    }

    #[test]
    fn clause_11_between_up_and_down_lies_a_call_without_a_pulse() {
        let mut block = restarted(ContS { lmnup: true, pulse_tm: Time::ms(0), break_tm: Time::ms(0), ..manual() });
        let run = pulses_with(&mut block, 8, |number, block| {
            block.lmnup = number <= 3 || number > 6;
            block.lmndn = !block.lmnup;
        });
        assert_eq!(run, "UUU.DD.U");
    }

    #[test]
    fn clause_12_manual_pulses_keep_the_minimum_pulse_and_break() {
        let run = pulses_with(&mut restarted(manual()), 16, |number, block| {
            block.lmnup = number == 2;
            block.lmndn = (4..=12).contains(&number);
        });
        assert_eq!(run, ".UUU...DDDDD....");
    }

    #[test]
    fn clause_12_the_minimum_times_are_counted_in_calls() {
        let run = |pulse_tm, break_tm| {
            let mut block = ContS { pulse_tm: Time::ms(pulse_tm), break_tm: Time::ms(break_tm), ..manual() };
            pulses_with(&mut block, 12, |number, block| block.lmnup = number == 1 || number > 5)
        };
        assert_eq!(run(3_000, 3_000), "UUU...UUUUUU");
        assert_eq!(run(3_000, 4_000), "UUU....UUUUU");
        assert_eq!(run(2_500, 3_500), "UUU....UUUUU");
        assert_eq!(run(1_000, 8_000), "U........UUU");
        assert_eq!(run(0, 0), "U....UUUUUUU");
    }

    #[test]
    fn clause_12_the_pulse_of_the_automatic_mode_ends_as_a_manual_one() {
        let mut block = restarted(ContS { sp_int: 11.0, ..ContS::default() });
        assert_eq!(pulses(&mut block, 1), "U");
        block.lmns_on = true;
        assert_eq!(pulses(&mut block, 4), "UU..");
    }

    #[test]
    fn clause_13_a_stop_in_a_minimum_pulse_ends_it_and_asks_for_no_break() {
        let run = pulses_with(&mut restarted(manual()), 16, |number, block| {
            block.lmnup = number >= 2;
            block.lmnr_hs = number == 3 || number == 4;
        });
        assert_eq!(run, ".U..UUUUUUUUUUUU");
    }

    #[test]
    fn clause_13_a_stop_after_the_minimum_pulse_asks_for_the_break() {
        let run = pulses_with(&mut restarted(manual()), 12, |number, block| {
            block.lmndn = true;
            block.lmnr_ls = number == 5;
        });
        assert_eq!(run, "DDDD...DDDDD");
    }

    #[test]
    fn clause_13_the_stop_of_the_other_direction_ends_nothing() {
        let run = pulses_with(&mut restarted(manual()), 6, |number, block| {
            block.lmnup = true;
            block.lmnr_ls = number >= 3;
        });
        assert_eq!(run, "UUUUUU");
    }

    #[test]
    fn clause_13_a_stop_in_the_pulses_of_the_automatic_mode() {
        let mut block = restarted(ContS { sp_int: 21.0, ..ContS::default() });
        let run = pulses_with(&mut block, 24, |number, block| block.lmnr_hs = (8..=12).contains(&number));
        assert_eq!(run, "UUUUUUU.....UUUUUUUU...U");
    }

    #[test]
    fn clause_14_whatever_is_set_the_pulses_stay_safe() {
        let mut random = Random(0x2545_F491_4F6C_DD1D);
        let mut block = restarted(ContS::default());
        let mut last = '.';
        let mut seen = String::new();
        for call in 0..300_000 {
            if call % 500 == 0 {
                block.cycle = Time::ms(random.between(1, 2_000));
                block.ti = Time::ms(random.between(0, 2) * random.between(0, 40_000));
                block.pulse_tm = Time::ms(random.between(0, 5_000));
                block.break_tm = Time::ms(random.between(0, 5_000));
                block.mtr_tm = Time::ms(random.between(0, 60_000));
                block.gain = random.between(-30, 30) as Real / 10.0;
                block.deadb_w = random.between(0, 20) as Real / 10.0;
            }
            if random.one_in(10) {
                block.sp_int = random.between(-1_000, 1_000) as Real / 10.0;
                block.disv = random.between(-100, 100) as Real / 10.0;
                block.lmns_on = random.one_in(3);
            }
            block.lmnup = random.one_in(3);
            block.lmndn = random.one_in(3);
            block.lmnr_hs = random.one_in(12);
            block.lmnr_ls = random.one_in(12);
            block.com_rst = random.one_in(2_000);
            block.call();

            let pulse = letter(&block);
            assert_ne!(pulse, '!', "both outputs in call {call}");
            assert!(!matches!((last, pulse), ('U', 'D') | ('D', 'U')), "{last}{pulse} in call {call}");
            assert!(!(pulse == 'U' && block.lmnr_hs || pulse == 'D' && block.lmnr_ls), "against a stop in call {call}");
            assert_eq!(block.pulse(), i32::from(block.qlmnup) - i32::from(block.qlmndn));
            last = pulse;
            seen.push(pulse);
        }
        for change in ["U.", "D.", ".U", ".D", "UUU", "DDD", "U.D", "D.U"] {
            assert!(seen.contains(change), "the drive never made {change}");
        }
    }

    /// Xorshift: numbers without pattern, the same in every run.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> u64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            self.0
        }

        fn between(&mut self, lowest: i32, highest: i32) -> i32 {
            let count = i64::from(highest) - i64::from(lowest) + 1;
            (i64::from(lowest) + (self.next() >> 33) as i64 % count) as i32
        }

        fn one_in(&mut self, count: u64) -> bool {
            (self.next() >> 33).is_multiple_of(count)
        }
    }

    #[test]
    fn clause_15_the_mean_row_counts_up_positive_and_down_negative() {
        let pulse = |lmnup, lmndn| {
            let mut block = restarted(ContS { lmnup, lmndn, ..manual() });
            block.call();
            block.pulse()
        };
        assert_eq!([pulse(true, false), pulse(false, true), pulse(false, false)], [1, -1, 0]);
        let mean = ContS::TABLE.mean.map(|row| ContS::TABLE.rows[row].full_name());
        assert_eq!(mean.as_deref(), Some("QLMN_MEAN"));
    }
}
