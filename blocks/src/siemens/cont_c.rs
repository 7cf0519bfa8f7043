//! CONT_C (FB 41): the continuous PID controller.

use crate::siemens::advice;
use crate::siemens::error_signal::{dead_band, process_value};
use crate::table::{Int, Law, Real, Response, Word, low_word, rnd};

crate::block! {
    /// Continuous PID controller with manual mode, anti-windup, feedforward and analog value conversion (FB 41).
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon "PID"
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
    /// // e goes to the three actions
    /// GAIN > x65 > y19.5 > x2 > y24 > P_SEL.TRUE
    /// 2,24 > y33 > INT > I_SEL.TRUE
    /// 2,33 > y48 > DIF > D_SEL.TRUE
    /// text 3,23.2 "e"
    /// switch P_SEL 20,25 TRUE upper constant FALSE 0.0
    /// box INT 9.5,33 integrate with TI INT_HOLD I_ITL_ON I_ITLVAL
    /// switch I_SEL 20,34 TRUE upper constant FALSE 0.0
    /// box DIF 9.5,48 differentiate with TD TM_LAG
    /// switch D_SEL 20,49 TRUE upper constant FALSE 0.0
    /// output LMN_P 25.5,22
    /// output LMN_I 25.5,31
    /// output LMN_D 25.5,46
    /// sum PID 32.5,34 top + left + bottom +
    /// LMN_P: P_SEL > PID.top
    /// LMN_I: I_SEL > PID
    /// LMN_D: D_SEL > PID.bottom
    /// 24,25 > y22 > LMN_P
    /// 24,34 > y31 > LMN_I
    /// 24,49 > y46 > LMN_D
    ///
    /// input DISV 33.5,28
    /// sum FF 40,34 left + top +
    /// input MAN 35,40
    /// switch MAN_ON 46,35 TRUE lower
    /// box LMNLIMIT 55,35 limit with LMN_HLM LMN_LLM
    /// box LMN_NORM 67,35 normalize with LMN_FAC LMN_OFF
    /// box CRP_OUT 67,46 analog_output
    /// output QLMN_HLM 57,27
    /// output QLMN_LLM 53,45
    /// output LMN 75.5,35
    /// output LMN_PER 69,52
    /// DISV > FF.top
    /// PID > FF > MAN_ON.FALSE
    /// MAN > x42 > MAN_ON.TRUE
    /// MAN_ON > LMNLIMIT > LMN_NORM > LMN
    /// LMNLIMIT.top > y27 > QLMN_HLM
    /// LMNLIMIT.bottom-3.5 > y45 > QLMN_LLM
    /// 73.5,35 > y46 > CRP_OUT.right
    /// CRP_OUT.bottom > y52 > LMN_PER
    ///
    /// box RESTART 74,3 "outputs = 0" "INT = I_ITLVAL" with COM_RST
    /// box CALL 74,13 "every CYCLE" with CYCLE
    /// ```
    ///
    /// The law of a call, in this order; every operation rounds to a 32-bit REAL, `[k-1]` is the value of the previous
    /// call:
    ///
    /// ```text
    /// PV    = PVPER_ON ? ((PV_PER * 0.003616898) * PV_FAC) + PV_OFF : PV_IN
    /// ER    = dead band of half width DEADB_W over SP_INT - PV
    /// e     = ER * GAIN
    /// T     = CYCLE,  Ti = max(TI, T / 2),  Td = max(TD, T),  Tl = max(TM_LAG, T / 2)         in seconds
    /// LMN_P = P_SEL ? e : 0
    /// LMN_I = I[k-1] + q,  q = (((T / Ti) * (e + e[k-1])) * 0.5) + rest
    /// LMN_D = (e - w) * V,  V = Td / ((T * 0.5) + Tl),  w = w + (((T / Td) * LMN_D) + restD)
    /// u     = MAN_ON ? MAN : ((LMN_P + LMN_I) + LMN_D) + DISV
    /// y     = u within LMN_LLM ... LMN_HLM
    /// LMN   = (y * LMN_FAC) + LMN_OFF
    /// LMN_PER = low word of RND(LMN * 276.48)
    /// ```
    ///
    /// 1. Restart (COM_RST): all outputs are 0 / FALSE, the integrator's memory is I_ITLVAL, all other memory is 0.
    ///    MAN, the limits, LMN_OFF and DISV have no effect. I_ITLVAL takes effect in the first automatic call after the
    ///    restart. The block does not reset COM_RST: while it is TRUE, every call is a restart. (manual)
    /// 2. Process value: PV_FAC and PV_OFF act on the analog value PV_PER only (manual). 100/27648 is multiplied as a
    ///    REAL; a division would differ in the last bit for one word in five (measured).
    /// 3. Dead band: ER = x + DEADB_W below -DEADB_W, x - DEADB_W above DEADB_W, else 0. (vendor)
    /// 4. P, I and D act on e = ER * GAIN (manual). If D is selected, a change of GAIN therefore kicks LMN_D once.
    /// 5. Times have lower bounds: TI is at least CYCLE / 2, TD at least CYCLE, TM_LAG at least CYCLE / 2. TI = 0 does
    ///    not switch the I action off; I_SEL does. (vendor)
    /// 6. Integral: trapezoidal rule; the round-off error of a call is added in the next one, so that small increments
    ///    on a large integral are not lost (vendor). INT_HOLD stops it. If the previous call, manual or automatic,
    ///    ended at a limit, the integral does not move further in that direction (anti-windup; vendor, observed).
    /// 7. The integral is held within LMN_LLM ... LMN_HLM, whatever P, D and DISV are. If I_ITL_ON, manual mode or
    ///    I_SEL has set it outside, it stays free until an automatic call finds it inside. (measured)
    /// 8. I_ITL_ON sets LMN_I = I_ITLVAL, in manual mode too (vendor); I_SEL = FALSE sets it to 0.
    /// 9. Manual mode: LMN follows MAN within the limits. The integral becomes y of the *previous* call - LMN_P - DISV,
    ///    so the change to automatic is bumpless if MAN was constant for two calls (manual; that it is the previous
    ///    call's: measured). With I_SEL off or I_ITL_ON on nothing is matched, and the change may bump.
    /// 10. Derivative: a first-order lag TM_LAG, step height e TD / (CYCLE / 2 + TM_LAG); in manual mode or with D_SEL
    ///     off it is 0 and follows e, so that switching it on is bumpless. (vendor, observed)
    /// 11. Limits: at or above LMN_HLM, y = LMN_HLM and only QLMN_HLM is TRUE; otherwise, at or below LMN_LLM, y =
    ///     LMN_LLM and only QLMN_LLM is TRUE. MAN is limited too. With the defaults LMN = 0 sets QLMN_LLM. (vendor,
    ///     measured)
    /// 12. LMN_PER is not clipped: LMN above 118.5 % wraps to a negative word (118.515 gives 32767, 118.52 gives
    ///     -32768, 150 gives -24064), below -118.5 % to a positive one. Keep both limits, times LMN_FAC plus LMN_OFF,
    ///     within -118.5 ... 118.5 %. (measured)
    ///
    /// Sampling: the block computes with CYCLE and must be called that often. After a restart, with constant e:
    /// `LMN_I(k) = I_ITLVAL + (T / Ti) e (k - 1/2)`, `LMN_D(k) = e V a^(k-1)` with `a = 1 - T / (T / 2 + Tl)`.
    ///
    /// Bad input: the block checks no parameter. An internal overflow may leave NaN in LMN; COM_RST clears it. If
    /// LMN_HLM is below LMN_LLM, LMN is one of the two, and LMN_I jumps between them.
    ///
    /// Source: Standard Software for S7-300 and S7-400, PID Control, User Manual (C79000-G7076-C516), section 3.1,
    /// figure 3-1, tables 3-1 and 3-2; recordings at the terminals of real blocks.
    pub struct ContC as "CONT_C" | "FB 41" | "SFB 41" {
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            com_rst: Bool = false;
            /// Manual mode: the loop is open and MAN is the manipulated value
            man_on: Bool = true;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            pvper_on: Bool = false;
            /// Proportional action on
            p_sel: Bool = true;
            /// Integral action on
            i_sel: Bool = true;
        }
        input {
            /// Holds the integral action
            int_hold: Bool = false;
            /// Sets the integral action to I_ITLVAL
            i_itl_on: Bool = false;
        }
        parameter {
            /// Derivative action on
            d_sel: Bool = false;
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
            /// Manual value, -100 ... 100 % or a physical value
            man: Real = 0.0;
        }
        parameter {
            /// Proportional gain
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE
            ti: Time = Time::ms(20_000);
            /// Derivative time; range: TD >= CYCLE
            td: Time = Time::ms(10_000);
            /// Time lag of the derivative action; range: TM_LAG >= CYCLE / 2
            tm_lag: Time = Time::ms(2_000);
            /// Dead band: half the width of the band in which the error counts as 0
            deadb_w: Real = 0.0, min 0.0;
            /// High limit of the manipulated value; range: LMN_LLM ... 100 % or a physical value
            lmn_hlm: Real = 100.0;
            /// Low limit of the manipulated value; range: -100 % ... LMN_HLM or a physical value
            lmn_llm: Real = 0.0;
            /// Factor of the process value from PV_PER
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            pv_off: Real = 0.0;
            /// Factor of the manipulated value
            lmn_fac: Real = 1.0;
            /// Offset of the manipulated value; LMN_PER wraps where LMN passes 118.5 %
            lmn_off: Real = 0.0;
        }
        input {
            /// Value of the integral action at the restart and with I_ITL_ON, -100 ... 100 % or a physical value
            i_itlval: Real = 0.0;
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            disv: Real = 0.0;
        }
        output {
            /// Manipulated value
            lmn: Real;
            /// Manipulated value as an analog output word: 27648 is 100 %; wraps beyond 118.5 %
            lmn_per: Word;
            /// The manipulated value is at its high limit
            qlmn_hlm: Bool;
            /// The manipulated value is at its low limit
            qlmn_llm: Bool;
            /// Proportional component of the manipulated value
            lmn_p: Real;
            /// Integral component of the manipulated value
            lmn_i: Real;
            /// Derivative component of the manipulated value
            lmn_d: Real;
            /// Process value in use
            pv: Real;
            /// Error after the dead band
            er: Real;
        }
    }
    memory Memory {
        /// Error times gain of the previous call.
        e: Real;
        /// Integral of the previous call.
        i: Real;
        /// Round-off error of the integral.
        rest: Real;
        /// The integral was set outside the limits and is not held within them until it is back inside.
        free: bool;
        /// Limited value of the previous call, before LMN_FAC and LMN_OFF.
        y: Real;
        /// Feedback of the derivative action: e after the time lag.
        w: Real;
        /// Round-off error of the feedback.
        rest_d: Real;
    }
}

impl Law for ContC {
    const RESPONSES: &'static [Response] = &[Response {
        title: "Setpoint step to 5, P, I and D action; the derivative time is 1 s, its lag 2 s",
        calls: 60,
        set: &[(0, "MAN_ON", 0.0), (0, "D_SEL", 1.0), (0, "TD", 1.0), (5, "SP_INT", 5.0), (40, "SP_INT", 0.0)],
        show: &["SP_INT", "LMN", "LMN_P", "LMN_I", "LMN_D"],
    }];

    fn restart(&mut self) {
        self.clear();
        self.memory.i = self.i_itlval;
    }

    #[inline(always)]
    fn call(&mut self) {
        if self.com_rst {
            return self.restart();
        }
        self.pv = if self.pvper_on { process_value(self.pv_per, self.pv_fac, self.pv_off) } else { self.pv_in };
        self.er = dead_band(self.sp_int - self.pv, self.deadb_w);
        let e = self.er * self.gain;

        self.lmn_p = if self.p_sel { e } else { 0.0 };
        self.lmn_i = self.integral(e);
        self.lmn_d = self.derivative(e);
        let u = if self.man_on { self.man } else { ((self.lmn_p + self.lmn_i) + self.lmn_d) + self.disv };

        self.qlmn_hlm = u >= self.lmn_hlm;
        self.qlmn_llm = !self.qlmn_hlm && u <= self.lmn_llm;
        let y = if self.qlmn_hlm {
            self.lmn_hlm
        } else if self.qlmn_llm {
            self.lmn_llm
        } else {
            u
        };
        self.lmn = (y * self.lmn_fac) + self.lmn_off;
        self.lmn_per = Word::new(analog_output(self.lmn));

        self.memory.e = e;
        self.memory.i = self.lmn_i;
        self.memory.y = y;
    }

    fn advice(&self) -> Vec<String> {
        advice::cont_c(self, "")
    }
}

impl ContC {
    /// INT: the integral after this call.
    fn integral(&mut self, e: Real) -> Real {
        let memory = &mut self.memory;
        let put = if !self.i_sel {
            Some(0.0)
        } else if self.i_itl_on {
            Some(self.i_itlval)
        } else if self.man_on {
            Some((memory.y - self.lmn_p) - self.disv)
        } else {
            None
        };
        if let Some(i) = put {
            memory.rest = 0.0;
            memory.free = true;
            return i;
        }

        let t = self.cycle.seconds();
        let ti = self.ti.seconds().max(t * 0.5);
        let mut q = (((t / ti) * (e + memory.e)) * 0.5) + memory.rest;
        // The limit outputs are still those of the previous call.
        if self.int_hold || (q > 0.0 && self.qlmn_hlm) || (q < 0.0 && self.qlmn_llm) {
            q = 0.0;
        }
        let i = memory.i + q;
        memory.rest = (memory.i - i) + q;
        let limit = if i > self.lmn_hlm {
            self.lmn_hlm
        } else if i < self.lmn_llm {
            self.lmn_llm
        } else {
            memory.free = false;
            return i;
        };
        memory.rest = 0.0;
        if memory.free { i } else { limit }
    }

    /// DIF: the derivative component of this call.
    fn derivative(&mut self, e: Real) -> Real {
        let memory = &mut self.memory;
        if !self.d_sel || self.man_on {
            memory.rest_d = 0.0;
            memory.w = e;
            return 0.0;
        }
        let t = self.cycle.seconds();
        let td = self.td.seconds().max(t);
        let tl = self.tm_lag.seconds().max(t * 0.5);
        let v = td / ((t * 0.5) + tl);
        let d = (e - memory.w) * v;
        let q = ((t / td) * d) + memory.rest_d;
        let w = q + memory.w;
        memory.rest_d = (memory.w - w) + q;
        memory.w = w;
        d
    }
}

/// CRP_OUT: a manipulated value as an analog word.
fn analog_output(lmn: Real) -> Int {
    low_word(rnd(lmn * 276.48))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Time;

    /// In automatic mode with setpoint 1 and the other defaults, so that e = 2.
    fn automatic() -> ContC {
        ContC { man_on: false, sp_int: 1.0, ..ContC::default() }
    }

    fn restarted(mut block: ContC) -> ContC {
        block.restart();
        block
    }

    /// An output after each of some calls.
    fn calls<T>(block: &mut ContC, count: usize, output: impl Fn(&ContC) -> T) -> Vec<T> {
        let call = |_| {
            block.call();
            output(block)
        };
        (0..count).map(call).collect()
    }

    fn after_one_call<T>(mut block: ContC, output: impl Fn(&ContC) -> T) -> T {
        block.call();
        output(&block)
    }

    /// What a user reads off LMN_PER with this manual value and no limit in its way.
    fn word_of(man: Real) -> Int {
        let block = ContC { man, lmn_hlm: Real::INFINITY, lmn_llm: Real::NEG_INFINITY, ..ContC::default() };
        after_one_call(restarted(block), |block| block.lmn_per.value())
    }

    #[test]
    fn clause_1_a_restart_makes_all_nine_outputs_0_or_false() {
        let mut block = restarted(ContC {
            pv_in: 3.0,
            d_sel: true,
            lmn_hlm: 1.0,
            lmn_off: 5.0,
            disv: 4.0,
            i_itlval: 60.0,
            ..automatic()
        });
        block.call();
        assert!(block.lmn != 0.0 && block.lmn_d != 0.0);
        block.com_rst = true;
        block.man = 50.0;
        block.call();
        assert_eq!([block.lmn, block.lmn_p, block.lmn_i, block.lmn_d, block.pv, block.er], [0.0; 6]);
        assert_eq!((block.lmn_per.value(), block.qlmn_hlm, block.qlmn_llm), (0, false, false));
    }

    #[test]
    fn clause_1_i_itlval_counts_in_the_first_automatic_call_after_a_restart() {
        let mut block = restarted(ContC { i_itlval: 30.0, ..automatic() });
        assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [30.05, 30.15]);
    }

    #[test]
    fn clause_1_a_manual_call_after_a_restart_overwrites_i_itlval() {
        let mut block = restarted(ContC { i_itlval: 30.0, sp_int: 0.0, ..automatic() });
        block.man_on = true;
        block.call();
        block.man_on = false;
        block.call();
        assert_eq!(block.lmn_i, 0.0);
    }

    #[test]
    fn clause_1_while_com_rst_is_true_every_call_is_a_restart_and_nothing_takes_it_back() {
        let mut block = restarted(automatic());
        calls(&mut block, 3, |_| ());
        block.com_rst = true;
        assert_eq!(calls(&mut block, 3, |block| (block.lmn, block.com_rst)), [(0.0, true); 3]);
        block.com_rst = false;
        assert_eq!(calls(&mut block, 1, |block| block.lmn), [2.05]);
    }

    #[test]
    fn clause_1_a_restart_forgets_the_derivative_and_both_rests() {
        let used = |calls_before| {
            let mut block = ContC { d_sel: true, sp_int: 1.7, ti: Time::ms(7_300), gain: 0.3, ..automatic() };
            calls(&mut block, calls_before, |_| ());
            block.restart();
            calls(&mut block, 50, |block| (block.lmn_i, block.lmn_d))
        };
        assert_eq!(used(37), used(0));
    }

    #[test]
    fn clause_2_pvper_on_selects_the_analog_value() {
        let block = ContC { pv_in: 7.0, pv_per: Word::new(27648), ..automatic() };
        assert_eq!(after_one_call(block.clone(), |block| (block.pv, block.er)), (7.0, -6.0));
        let block = ContC { pvper_on: true, ..block };
        assert_eq!(after_one_call(block, |block| (block.pv, block.er)), (100.0, -99.0));
    }

    #[test]
    fn clause_2_factor_and_offset_act_on_the_analog_value_alone() {
        let block = ContC { pv_in: 7.0, pv_per: Word::new(13824), pv_fac: 4.0, pv_off: -50.0, ..automatic() };
        assert_eq!(after_one_call(block.clone(), |block| block.pv), 7.0);
        assert_eq!(after_one_call(ContC { pvper_on: true, ..block }, |block| block.pv), 150.0);
    }

    #[test]
    fn clause_3_the_error_loses_half_the_width_of_the_dead_band() {
        for (setpoint, error) in [(3.0, 1.0), (2.0, 0.0), (-2.0, 0.0), (-3.0, -1.0)] {
            let block = ContC { sp_int: setpoint, deadb_w: 2.0, ..automatic() };
            assert_eq!(after_one_call(block, |block| (block.er, block.lmn_p)), (error, 2.0 * error), "SP {setpoint}");
        }
    }

    #[test]
    fn clause_4_p_i_and_d_all_act_on_error_times_gain() {
        let parts = |gain| {
            let block = ContC { gain, d_sel: true, lmn_llm: -100.0, ..automatic() };
            after_one_call(restarted(block), |block| (block.lmn_p, block.lmn_i, block.lmn_d))
        };
        assert_eq!(parts(2.0), (2.0, 0.05, 8.0));
        assert_eq!(parts(-4.0), (-4.0, -0.1, -16.0));
    }

    #[test]
    fn clause_4_a_part_that_is_not_selected_is_0() {
        let parts = |p_sel, i_sel, d_sel| {
            let block = ContC { p_sel, i_sel, d_sel, ..automatic() };
            after_one_call(restarted(block), |block| (block.lmn_p, block.lmn_i, block.lmn_d, block.lmn))
        };
        assert_eq!(parts(true, false, false), (2.0, 0.0, 0.0, 2.0));
        assert_eq!(parts(false, true, false), (0.0, 0.05, 0.0, 0.05));
        assert_eq!(parts(false, false, true), (0.0, 0.0, 8.0, 8.0));
    }

    #[test]
    fn clause_4_a_change_of_gain_kicks_the_derivative_once() {
        // w holds the old product 2; the new one is 3: a step of 1, times V = 4.
        let mut block = restarted(ContC { d_sel: true, ..automatic() });
        calls(&mut block, 60, |_| ());
        assert!(block.lmn_d.abs() < 1e-5);
        block.gain = 3.0;
        block.call();
        assert!((block.lmn_d - 4.0).abs() < 1e-5, "{}", block.lmn_d);
    }

    #[test]
    fn clause_5_a_reset_time_below_half_a_cycle_counts_as_half_a_cycle() {
        // (1 s / 0.5 s) * (2 + 0) / 2
        for ti in [0, 300, 500] {
            let block = ContC { ti: Time::ms(ti), ..automatic() };
            assert_eq!(after_one_call(restarted(block), |block| block.lmn_i), 2.0, "TI {ti} ms");
        }
    }

    #[test]
    fn clause_5_a_derivative_time_below_a_cycle_counts_as_a_cycle() {
        // V = 1 / (0.5 + 2)
        for td in [0, 700, 1000] {
            let block = ContC { td: Time::ms(td), d_sel: true, ..automatic() };
            assert_eq!(after_one_call(restarted(block), |block| block.lmn_d), 0.8, "TD {td} ms");
        }
    }

    #[test]
    fn clause_5_a_time_lag_below_half_a_cycle_counts_as_half_a_cycle() {
        // V = 10 / (0.5 + 0.5), and the lag forgets the step in one call.
        for tm_lag in [0, 300, 500] {
            let block = ContC { tm_lag: Time::ms(tm_lag), i_sel: false, d_sel: true, ..automatic() };
            assert_eq!(calls(&mut restarted(block), 3, |block| block.lmn_d), [20.0, 0.0, 0.0], "TM_LAG {tm_lag} ms");
        }
    }

    #[test]
    fn clause_6_the_integral_grows_by_trapezoids() {
        let mut block = restarted(automatic());
        let rows = calls(&mut block, 5, |block| (block.lmn_i, block.lmn_per.value()));
        assert_eq!(rows, [(0.05, 567), (0.15, 594), (0.25, 622), (0.35, 650), (0.45, 677)]);
    }

    #[test]
    fn clause_6_what_rounding_takes_comes_back_in_later_calls() {
        // Each call adds 1e-7 to 50, where a REAL has steps of 3.8e-6.
        let mut block = restarted(ContC {
            cycle: Time::ms(10),
            ti: Time::ms(3_600_000),
            gain: 1.0,
            sp_int: 0.036,
            i_itlval: 50.0,
            ..automatic()
        });
        calls(&mut block, 100_000, |_| ());
        assert_eq!(block.lmn_i, 50.01);
    }

    #[test]
    fn clause_6_int_hold_stops_the_integral_and_drops_the_rest() {
        let mut block = restarted(automatic());
        calls(&mut block, 2, |_| ());
        block.int_hold = true;
        assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [0.15; 3]);
        assert_eq!(block.memory.rest, 0.0);
        block.int_hold = false;
        assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [0.25]);
    }

    #[test]
    fn clause_6_a_limit_reached_in_the_last_call_stops_the_integral_in_its_direction_only() {
        // u is 2.05 in the first call, above the limit, and so it stays while e does.
        let mut block = restarted(ContC { lmn_hlm: 1.0, lmn_llm: -100.0, ..automatic() });
        assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [0.05; 3]);
        block.sp_int = -3.0;
        assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [-0.05]);
    }

    #[test]
    fn clause_6_the_low_limit_stops_the_integral_downwards() {
        let mut block = restarted(ContC { sp_int: -1.0, lmn_llm: -1.0, ..automatic() });
        assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [-0.05; 3]);
        block.sp_int = 3.0;
        assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [0.05]);
    }

    #[test]
    fn clause_6_a_limit_that_a_manual_call_ended_at_counts_too() {
        let integral = |man| {
            let mut block = restarted(ContC { man, man_on: true, ..automatic() });
            calls(&mut block, 2, |_| ());
            block.man_on = false;
            calls(&mut block, 1, |block| block.lmn_i)[0]
        };
        assert_eq!(integral(99.0), 97.1);
        assert_eq!(integral(100.0), 98.0);
    }

    #[test]
    fn clause_7_the_integral_stays_within_the_limits_whatever_the_other_parts_are() {
        let mut block = restarted(ContC { i_itlval: 99.9, disv: -50.0, ..automatic() });
        assert_eq!(calls(&mut block, 4, |block| block.lmn_i), [99.950005, 100.0, 100.0, 100.0]);
        block.sp_int = -1.0;
        block.disv = 50.0;
        block.i_itlval = 0.04;
        block.restart();
        assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [0.0, 0.0, 0.0]);
    }

    #[test]
    fn clause_7_the_integral_held_at_its_limit_leaves_no_rest() {
        let mut block = restarted(ContC { i_itlval: 120.0, disv: -150.0, ..automatic() });
        assert_eq!(calls(&mut block, 1, |block| (block.lmn_i, block.memory.rest)), [(100.0, 0.0)]);
    }

    #[test]
    fn clause_7_a_limit_that_moves_takes_the_integral_with_it_even_on_hold() {
        let mut block = restarted(ContC { i_itlval: 30.0, int_hold: true, ..automatic() });
        assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [30.0]);
        block.lmn_hlm = 10.0;
        assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [10.0]);
        block.lmn_hlm = 100.0;
        block.lmn_llm = 40.0;
        assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [40.0]);
    }

    #[test]
    fn clause_7_with_crossed_limits_the_high_one_is_asked_first() {
        let integral = |i_itlval| {
            let block = ContC { i_itlval, int_hold: true, lmn_hlm: 10.0, lmn_llm: 50.0, ..automatic() };
            after_one_call(restarted(block), |block| block.lmn_i)
        };
        assert_eq!((integral(20.0), integral(10.0), integral(-5.0)), (10.0, 50.0, 50.0));
    }

    #[test]
    fn clause_7_i_itlval_beyond_a_limit_is_clamped_after_a_restart_and_free_with_i_itl_on() {
        let beyond = ContC { i_itlval: 120.0, ..automatic() };
        assert_eq!(after_one_call(restarted(beyond.clone()), |block| block.lmn_i), 100.0);
        let mut block = restarted(ContC { i_itl_on: true, ..beyond });
        block.call();
        block.i_itl_on = false;
        assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [120.0, 120.0]);
    }

    #[test]
    fn clause_7_an_integral_put_outside_comes_back_by_itself_and_is_held_from_then_on() {
        // e = -20 takes 1 off a call (half of it in the first), e = +20 brings it back.
        let mut block =
            restarted(ContC { i_itlval: 101.5, i_itl_on: true, sp_int: -10.0, disv: -500.0, ..automatic() });
        block.lmn_llm = -1000.0;
        block.call();
        block.i_itl_on = false;
        assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [100.5, 99.5, 98.5]);
        block.sp_int = 10.0;
        assert_eq!(calls(&mut block, 4, |block| block.lmn_i), [98.5, 99.5, 100.0, 100.0]);
    }

    #[test]
    fn clause_7_an_integral_that_manual_mode_put_outside_stays_free() {
        // y is at most 100, DISV takes it to 150.
        let mut block = restarted(ContC { man: 100.0, man_on: true, disv: -52.0, sp_int: 0.0, ..automatic() });
        calls(&mut block, 2, |_| ());
        block.man_on = false;
        assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [152.0, 152.0]);
    }

    #[test]
    fn clause_7_an_integral_that_i_sel_put_outside_stays_free() {
        let mut block = restarted(ContC { i_sel: false, lmn_llm: 20.0, sp_int: 0.0, ..automatic() });
        block.call();
        block.i_sel = true;
        assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [0.0, 0.0]);
    }

    #[test]
    fn clause_7_an_integral_exactly_at_a_limit_is_inside_and_arms_the_clamp() {
        for (edge, new_high, new_low, held) in [(100.0, 90.0, 0.0, 90.0), (0.0, 100.0, 10.0, 10.0)] {
            let mut block = restarted(ContC { i_itlval: edge, i_itl_on: true, int_hold: true, ..automatic() });
            block.call();
            block.i_itl_on = false;
            block.call();
            (block.lmn_hlm, block.lmn_llm) = (new_high, new_low);
            assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [held]);
        }
    }

    #[test]
    fn clause_8_i_itl_on_sets_the_integral_in_manual_mode_too() {
        for man_on in [false, true] {
            let mut block = restarted(ContC { man_on, i_itl_on: true, i_itlval: 12.5, ..automatic() });
            assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [12.5, 12.5]);
        }
    }

    #[test]
    fn clause_8_an_integral_that_is_not_selected_is_0_even_with_i_itl_on() {
        let mut block = restarted(ContC { i_sel: false, i_itl_on: true, i_itlval: 12.5, ..automatic() });
        assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [0.0, 0.0]);
    }

    #[test]
    fn clause_8_setting_the_integral_drops_the_rest() {
        let with_rest = |set: fn(&mut ContC)| {
            let mut block = restarted(ContC { gain: 0.3, ti: Time::ms(7_300), i_itlval: 50.0, ..automatic() });
            calls(&mut block, 3, |_| ());
            assert!(block.memory.rest != 0.0);
            set(&mut block);
            block.call();
            block.memory.rest
        };
        assert_eq!(with_rest(|block| block.i_itl_on = true), 0.0);
        assert_eq!(with_rest(|block| block.i_sel = false), 0.0);
        assert_eq!(with_rest(|block| block.man_on = true), 0.0);
    }

    #[test]
    fn clause_9_lmn_follows_the_manual_value_at_once_and_the_integral_one_call_later() {
        let mut block = restarted(ContC::default());
        let mut rows = Vec::new();
        for man in [40.0, 40.0, 50.0, 60.0, 60.0] {
            block.man = man;
            block.call();
            rows.push((block.lmn, block.lmn_i));
        }
        assert_eq!(rows, [(40.0, 0.0), (40.0, 40.0), (50.0, 40.0), (60.0, 50.0), (60.0, 60.0)]);
    }

    #[test]
    fn clause_9_the_change_to_automatic_is_without_a_bump_when_man_stood_still_for_two_calls() {
        let mut block = restarted(ContC { man_on: true, man: 40.0, disv: 5.0, ti: Time::ms(2_000_000), ..automatic() });
        calls(&mut block, 2, |_| ());
        assert_eq!(block.lmn_i, 33.0);
        block.man_on = false;
        assert_eq!(calls(&mut block, 1, |block| block.lmn), [40.001]);
    }

    #[test]
    fn clause_9_the_integral_matches_the_manual_value_within_the_limits_before_lmn_fac_and_lmn_off() {
        let mut block = restarted(ContC { man: 130.0, lmn_fac: 0.5, lmn_off: 7.0, ..ContC::default() });
        assert_eq!(calls(&mut block, 2, |block| (block.lmn, block.lmn_i)), [(57.0, 0.0), (57.0, 100.0)]);
    }

    #[test]
    fn clause_10_the_derivative_steps_and_decays_with_the_time_lag() {
        let mut block = restarted(ContC { i_sel: false, d_sel: true, ..automatic() });
        assert_eq!(calls(&mut block, 5, |block| block.lmn_d), [8.0, 4.8, 2.88, 1.7279997, 1.0367999]);
    }

    #[test]
    fn clause_10_switching_the_derivative_on_is_without_a_bump() {
        for off in [ContC { d_sel: false, ..automatic() }, ContC { d_sel: true, man_on: true, ..automatic() }] {
            let mut block = restarted(off);
            assert_eq!(calls(&mut block, 2, |block| block.lmn_d), [0.0, 0.0]);
            (block.d_sel, block.man_on) = (true, false);
            assert_eq!(calls(&mut block, 2, |block| block.lmn_d), [0.0, 0.0]);
            block.sp_int = 2.0;
            assert_eq!(calls(&mut block, 1, |block| block.lmn_d), [8.0]);
        }
    }

    #[test]
    fn clause_10_switching_the_derivative_off_drops_the_rest() {
        let mut block = restarted(ContC { d_sel: true, sp_int: 0.3, ..automatic() });
        calls(&mut block, 4, |_| ());
        assert!(block.memory.rest_d != 0.0);
        block.d_sel = false;
        block.call();
        assert_eq!(block.memory.rest_d, 0.0);
    }

    #[test]
    fn clause_10_what_rounding_takes_from_the_lag_comes_back_in_later_calls() {
        // With a lag of 10^5 calls w climbs by less than its last bit a call; the closed form still holds.
        let mut block = restarted(ContC {
            i_sel: false,
            d_sel: true,
            cycle: Time::ms(10),
            td: Time::ms(1_000_000),
            tm_lag: Time::ms(1_000_000),
            ..automatic()
        });
        calls(&mut block, 300_000, |_| ());
        let (a, v) = (1.0 - 0.01 / (0.005 + 1000.0), 1000.0 / (0.005 + 1000.0));
        let expected = 2.0 * v * f64::powi(a, 299_999);
        assert!((f64::from(block.lmn_d) / expected - 1.0).abs() < 1e-5, "{} {expected}", block.lmn_d);
    }

    #[test]
    fn clause_11_at_and_above_the_high_limit_only_its_flag_is_true() {
        for man in [90.0, 150.0] {
            let block = restarted(ContC { man, lmn_hlm: 90.0, ..ContC::default() });
            assert_eq!(after_one_call(block, |b| (b.lmn, b.qlmn_hlm, b.qlmn_llm)), (90.0, true, false));
        }
    }

    #[test]
    fn clause_11_at_and_below_the_low_limit_only_its_flag_is_true() {
        for man in [-20.0, -150.0] {
            let block = restarted(ContC { man, lmn_llm: -20.0, ..ContC::default() });
            assert_eq!(after_one_call(block, |b| (b.lmn, b.qlmn_hlm, b.qlmn_llm)), (-20.0, false, true));
        }
    }

    #[test]
    fn clause_11_between_the_limits_neither_flag_is_true() {
        let block = restarted(ContC { man: 50.0, ..ContC::default() });
        assert_eq!(after_one_call(block, |b| (b.lmn, b.qlmn_hlm, b.qlmn_llm)), (50.0, false, false));
    }

    #[test]
    fn clause_11_with_crossed_limits_the_high_one_wins() {
        let block = restarted(ContC { man: 50.0, lmn_hlm: 10.0, lmn_llm: 90.0, ..ContC::default() });
        assert_eq!(after_one_call(block, |b| (b.lmn, b.qlmn_hlm, b.qlmn_llm)), (10.0, true, false));
    }

    #[test]
    fn clause_11_with_the_defaults_a_manipulated_value_of_0_is_at_the_low_limit() {
        assert!(after_one_call(restarted(ContC::default()), |block| block.qlmn_llm));
    }

    #[test]
    fn the_disturbance_variable_is_added_in_automatic_mode_only() {
        let block = restarted(ContC { disv: 10.0, man: 33.0, ..automatic() });
        assert_eq!(after_one_call(block.clone(), |block| block.lmn), 12.05);
        assert_eq!(after_one_call(ContC { man_on: true, ..block }, |block| block.lmn), 33.0);
    }

    #[test]
    fn lmn_fac_and_lmn_off_act_behind_the_limits() {
        let block = restarted(ContC { man: 150.0, lmn_fac: 0.5, lmn_off: -60.0, ..ContC::default() });
        assert_eq!(after_one_call(block, |block| (block.lmn, block.lmn_per.value())), (-10.0, -2765));
    }

    #[test]
    fn clause_12_lmn_per_is_27648_at_100_percent() {
        for (man, word) in [(1.0, 276), (12.5, 3456), (50.0, 13824), (100.0, 27648), (118.0, 32625), (-100.0, -27648)] {
            assert_eq!(word_of(man), word, "LMN {man}");
        }
    }

    #[test]
    fn clause_12_lmn_per_wraps_where_lmn_passes_118_5_percent() {
        for (man, word) in [(117.59, 32511), (118.515, 32767), (118.52, -32768), (150.0, -24064), (-118.53, 32765)] {
            assert_eq!(word_of(man), word, "LMN {man}");
        }
    }

    #[test]
    fn clause_12_lmn_per_of_a_number_beyond_32_bits_is_the_low_word_of_its_bits() {
        assert_eq!(word_of(1e9), -16644);
    }

    #[test]
    fn lmn_per_of_nan_is_16_ffff() {
        let block = restarted(ContC { lmn_off: Real::NAN, ..ContC::default() });
        assert_eq!(after_one_call(block, |block| block.lmn_per.value()), -1);
    }

    #[test]
    fn an_overflow_inside_is_cleared_by_com_rst() {
        let mut block = restarted(ContC { d_sel: true, sp_int: 3e38, gain: 3e38, ..automatic() });
        calls(&mut block, 3, |_| ());
        assert!(!block.lmn_i.is_finite() || !block.lmn_d.is_finite());
        (block.sp_int, block.gain, block.com_rst) = (1.0, 2.0, true);
        block.call();
        block.com_rst = false;
        assert_eq!(calls(&mut block, 1, |block| block.lmn), [10.05]);
    }

    #[test]
    fn constant_error_follows_the_closed_forms() {
        let mut block = restarted(ContC { d_sel: true, i_itlval: 5.0, ..automatic() });
        let a = 1.0 - 1.0 / (0.5 + 2.0);
        for (k, (i, d)) in (1..).zip(calls(&mut block, 40, |block| (block.lmn_i, block.lmn_d))) {
            let integral = 5.0 + (1.0 / 20.0) * 2.0 * (f64::from(k) - 0.5);
            let derivative = 2.0 * 4.0 * f64::powi(a, k - 1);
            assert!((f64::from(i) - integral).abs() < 1e-5, "LMN_I in call {k}: {i}, not {integral}");
            assert!((f64::from(d) - derivative).abs() < 1e-5, "LMN_D in call {k}: {d}, not {derivative}");
        }
    }
}
