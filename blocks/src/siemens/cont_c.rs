//! CONT_C (FB 41): the continuous PID controller.

use crate::siemens::advice;
use crate::siemens::error_signal::{dead_band, process_value};
use crate::table::{Int, Law, Real, Response, Word, low_word, rnd};

crate::block! {
    /// Continuous PID controller with manual mode, anti-windup, feedforward and analog value conversion (FB 41).
    ///
    /// ```text
    /// SP_INT ---------->(+)--> dead band --ER--> x GAIN --e--+--> P, P_SEL ---------------- LMN_P --+
    ///                   -^     DEADB_W                       |                                      |
    /// PV_IN ------+      |                                   +--> I, I_SEL, TI, I_ITLVAL - LMN_I --(+)<-- DISV
    ///             +--PV--+                                   |                                      |
    /// PV_PER --> x 100/27648                                 +--> D, D_SEL, TD, TM_LAG --- LMN_D ---+
    ///            x PV_FAC + PV_OFF                                                                  |
    ///            (PVPER_ON)                                                                         v
    ///                                                              MAN (instead, with MAN_ON) ----> u
    ///                                                                                               |
    /// LMN_PER <-- x 276.48 <-- LMN <----- x LMN_FAC + LMN_OFF <--y-- limits LMN_LLM ... LMN_HLM <---+
    ///                                                                +--> QLMN_LLM, QLMN_HLM
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
mod tests;
