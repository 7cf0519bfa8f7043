//! CONT_C (FB 41): the continuous PID controller.

mod responses;
#[cfg(test)]
mod tests;

use crate::siemens::advice;
use crate::siemens::error_signal::{dead_band, process_value};
use crate::table::{Characteristic, Int, Law, Real, Response, Word, low_word, rnd};

crate::block! {
    /// Continuous PID controller with manual mode, anti-windup, feedforward and analog value conversion (FB 41).
    ///
    #[doc = include_str!("page.md")]
    pub struct ContC as "CONT_C" | "FB 41" | "SFB 41" {
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            ///
            /// While it is TRUE, every call is a restart: all outputs are 0 or FALSE, the integral becomes
            /// I_ITLVAL, and the rest of the memory is cleared. The block does not reset COM_RST. Every run begins
            /// with a restart; set it for one during the run, after a standstill or when LMN is NaN.
            com_rst: Bool = false;
            /// Manual mode: the loop is open and MAN is the manipulated value
            ///
            /// In manual mode LMN follows MAN within the limits, LMN_D is 0, and LMN_I is set so that LMN_P + LMN_I +
            /// DISV is the manipulated value of the previous call. So LMN does not jump when MAN_ON falls: with
            /// MAN = 40, ER = 10 and the start values GAIN 2 and TI 20 s, the first automatic call gives 41, one
            /// step of the integral more.
            ///
            /// LMN does jump if MAN has changed in the last manual call (it returns to the former value), if
            /// SP_INT, the process value, DISV or GAIN changes in the call in which MAN_ON falls, and if I_SEL is
            /// FALSE or I_ITL_ON is TRUE, because nothing is matched then. In the other direction LMN jumps to MAN:
            /// set MAN to LMN before.
            man_on: Bool = true;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            ///
            /// TRUE converts the analog word PV_PER to percent and scales it by PV_FAC and PV_OFF, so that the
            /// steps of the analog input (0.0036 %) and its range are part of the simulation. The other input has
            /// no effect. Switching in automatic mode is a step of the process value.
            pvper_on: Bool = false;
            /// Proportional action on
            ///
            /// FALSE makes LMN_P 0; I and D action still act on GAIN * ER. I action alone suits plants that follow
            /// at once or have little but dead time. If P_SEL falls in automatic mode, LMN loses LMN_P at once; in
            /// manual mode LMN_I is matched to the new sum.
            p_sel: Bool = true;
            /// Integral action on
            ///
            /// FALSE sets LMN_I to 0 and leaves a P or PD controller, at which an error remains: with GAIN 2, a
            /// plant whose gain is 1 and SP_INT = 60, PV stops at 40, unless DISV supplies the manipulated value
            /// that the plant needs. If I_SEL falls in automatic mode, LMN loses LMN_I at once; if it rises, the
            /// integral starts from 0.
            i_sel: Bool = true;
        }
        input {
            /// Holds the integral action
            ///
            /// While it is TRUE, LMN_I keeps its value; afterwards the integral continues from there. Use it while
            /// LMN has no effect for a reason that the block does not see: a closed gate, or, in the primary
            /// controller of a cascade, a secondary controller in manual mode. I_SEL = FALSE, I_ITL_ON, MAN_ON and
            /// the limits take precedence: if LMN_HLM falls to 10, an LMN_I held at 30 becomes 10.
            int_hold: Bool = false;
            /// Sets the integral action to I_ITLVAL
            ///
            /// While it is TRUE, LMN_I is I_ITLVAL, in manual mode too; with I_SEL = FALSE it has no effect. When
            /// it falls, the integral continues from there, even from beyond a limit: 120 stays 120 until the error
            /// brings it below LMN_HLM = 100. Use it to preset the integral before a batch is heated, or to take
            /// LMN over from elsewhere, with I_ITLVAL = LMN - LMN_P - DISV.
            i_itl_on: Bool = false;
        }
        parameter {
            /// Derivative action on
            ///
            /// TRUE adds LMN_D, the lagged derivative of GAIN * ER. It makes loops with two or more lags faster and
            /// better damped; where the process value is noisy, such as a flow, it mostly moves the actuator. It
            /// acts on the setpoint too: with GAIN 2, TD 10 s, TM_LAG 2 s and CYCLE 1 s, a setpoint step of 1 makes
            /// LMN_D 8. Switching it on is bumpless; switching it off takes LMN_D away at once.
            d_sel: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// The block measures no time: called every 2 s with CYCLE = 1 s it would integrate at half the rate.
            /// Choose a tenth of the plant's time constant or less: sampling acts like an additional dead time of
            /// CYCLE / 2.
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            ///
            /// The value that PV is to reach, in the unit of PV. A step of 10 moves LMN_P by 20 with GAIN 2 in the
            /// next call and, with D_SEL and the start values, LMN_D by 80; a ramp before the setpoint avoids both.
            /// The block does not limit it.
            sp_int: Real = 0.0;
            /// Process value as a floating point number, -100 ... 100 % or a physical value
            ///
            /// The process value while PVPER_ON is FALSE, in the unit of SP_INT; PV_FAC and PV_OFF do not act on
            /// it. The block neither filters nor checks it: noise of 0.5 moves LMN_P by 1 with GAIN 2, and a value
            /// that fails to 0 drives LMN to a limit.
            pv_in: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            ///
            /// The process value while PVPER_ON is TRUE: PV = PV_PER * 100 / 27648 * PV_FAC + PV_OFF. One count is
            /// 0.0036 %. 32768 ... 65535 are taken, too, and count as negative. Analog inputs report overflow and
            /// underflow by 32767 and -32768: the block takes them for process values, so check for a broken wire
            /// outside and switch to manual mode.
            pv_per: Word = Word::new(0);
            /// Manual value, -100 ... 100 % or a physical value
            ///
            /// LMN in manual mode, before the limits, LMN_FAC and LMN_OFF. When MAN_ON rises, LMN jumps to it; keep
            /// it at LMN until then. LMN_I follows it one call later, so leave MAN unchanged for two calls before
            /// MAN_ON falls: if it goes from 40 to 50 in the last manual call, LMN returns to 40.
            man: Real = 0.0;
        }
        parameter {
            /// Proportional gain
            ///
            /// GAIN multiplies the error before it goes to all three parts: LMN_P is GAIN * ER, LMN_I grows by
            /// GAIN * ER in every TI, and LMN_D starts at GAIN * ER * TD / (TM_LAG + CYCLE / 2). An error step of 10
            /// with the start values (GAIN 2, TI 20 s, TD 10 s, TM_LAG 2 s, CYCLE 1 s) gives LMN_P = 20, an LMN_I
            /// that rises by 1 per second, and LMN_D = 80 at first; GAIN 4 doubles each of them.
            ///
            /// Its unit is percent of LMN per unit of PV. If PV falls when LMN rises, as in cooling, GAIN must be
            /// negative. Begin with the rule of the quick start. A change of GAIN while there is an error moves
            /// LMN_P at once and kicks LMN_D once; LMN_I stays.
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE
            ///
            /// The time in which LMN_I grows by GAIN * ER at a constant error: with GAIN 2, ER = 10 and TI = 20 s
            /// by 20 in 20 s. A shorter TI removes an error faster, a too short one makes the loop oscillate. A TI
            /// below CYCLE / 2 counts as CYCLE / 2; TI = 0 does not switch the I action off, I_SEL does. A change
            /// of TI does not make LMN jump.
            ti: Time = Time::ms(20_000);
            /// Derivative time; range: TD >= CYCLE
            ///
            /// How far ahead the D action looks, with D_SEL: if the error changes by 0.5 per second, LMN_D settles
            /// at GAIN * TD * 0.5, 5 with GAIN 1 and TD = 10 s. Begin with half the plant's dead time or with its
            /// second largest time constant, and stay below TI / 4. A TD below CYCLE counts as CYCLE: D_SEL
            /// switches the D action off, not TD = 0.
            td: Time = Time::ms(10_000);
            /// Time lag of the derivative action; range: TM_LAG >= CYCLE / 2
            ///
            /// The time constant with which LMN_D decays. It limits the kick: at an error step LMN_D is TD /
            /// (TM_LAG + CYCLE / 2) times LMN_P, and each further call multiplies it by the same factor, here 0.6:
            /// 8, 4.8, 2.88 for GAIN * ER = 2, TD 10 s, TM_LAG 2 s, CYCLE 1 s. Choose TD / 10 ... TD / 5; larger if
            /// noise moves the actuator. A value below CYCLE / 2 counts as CYCLE / 2: the whole kick then falls
            /// into one call, 20, 0, 0.
            tm_lag: Time = Time::ms(2_000);
            /// Dead band: half the width of the band in which the error counts as 0
            ///
            /// While SP_INT - PV is within -DEADB_W ... DEADB_W, ER is 0; beyond, ER is smaller by DEADB_W, so that
            /// nothing jumps at the edge: a difference of 5 with DEADB_W = 2 gives ER = 3. It has the unit of PV.
            /// Use it against a limit cycle behind a coarse actuator: if the pulses resolve 1 % and the plant's
            /// gain is 2, PV moves in steps of 2, and 1 is enough. A value below 0 makes every error larger.
            deadb_w: Real = 0.0, min 0.0;
            /// High limit of the manipulated value; range: LMN_LLM ... 100 % or a physical value
            ///
            /// The manipulated value is held at or below it, in manual mode too, before LMN_FAC and LMN_OFF. There
            /// QLMN_HLM is TRUE and the integral does not rise further (anti-windup): LMN leaves the limit as soon
            /// as LMN_P or LMN_D falls, without first unwinding the integral. If it is lowered during a run, LMN
            /// and LMN_I go down with it at once. Keep it above LMN_LLM, and see LMN_PER for how far it may be
            /// raised.
            lmn_hlm: Real = 100.0;
            /// Low limit of the manipulated value; range: -100 % ... LMN_HLM or a physical value
            ///
            /// The manipulated value is held at or above it, as at LMN_HLM. The start value 0 is for actuators with
            /// one direction: heating and cooling, or negative pulses behind the block, need -100. A restart gives
            /// LMN = 0 whatever it is.
            lmn_llm: Real = 0.0;
            /// Factor of the process value from PV_PER
            ///
            /// The span of the transmitter divided by 100: 4 for 0 ... 400 degC, so that 13824 (50 %) reads 200. It
            /// does not act on PV_IN. GAIN is in percent of LMN per unit of PV: with PV_FAC = 4 instead of 1, a
            /// quarter of the GAIN gives the same loop. A change during a run is a step of the process value.
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            ///
            /// What PV is at PV_PER = 0: for a transmitter whose 0 ... 27648 means -50 ... 150 degC, PV_OFF is -50
            /// and PV_FAC 2, and 13824 reads 50. It does not act on PV_IN. A change during a run is a step of the
            /// process value.
            pv_off: Real = 0.0;
            /// Factor of the manipulated value
            ///
            /// LMN is the limited value times LMN_FAC plus LMN_OFF, so the limits and the integral know nothing of
            /// it. It is part of the loop's gain: with LMN_FAC = 0.5, the loop needs twice the GAIN. -1 with
            /// LMN_OFF = 100 reverses an actuator: 30 becomes 70. A change during a run makes LMN jump.
            lmn_fac: Real = 1.0;
            /// Offset of the manipulated value
            ///
            /// Added last, in manual mode too: MAN = 40 and LMN_OFF = 10 give LMN = 50. With LMN_FAC = 0.5 and
            /// LMN_OFF = 50, limits of -100 and 100 become 0 and 100. After a restart LMN is 0, not LMN_OFF.
            lmn_off: Real = 0.0;
        }
        input {
            /// Value of the integral action at the restart and with I_ITL_ON, -100 ... 100 % or a physical value
            ///
            /// Where the integral starts after a restart, if the first call is an automatic one, and what it is
            /// while I_ITL_ON is TRUE. The first call adds half a step: with I_ITLVAL = 40, GAIN 2, TI 20 s, CYCLE
            /// 1 s and ER = 10, LMN_I is 40.5. Choose the LMN that the plant needs at its usual setpoint. After a
            /// restart it is held within the limits, with I_ITL_ON it is not.
            i_itlval: Real = 0.0;
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            ///
            /// Added to the sum of P, I and D action in automatic mode: if it rises by 10, LMN rises by 10 in the
            /// same call. Connect a measured disturbance times the LMN that makes up for it: if 1 m3/h more needs 4
            /// % more LMN, 4 times the flow. The limits apply to the sum. In manual mode LMN_I is matched to it, so
            /// a constant DISV causes no bump.
            disv: Real = 0.0;
        }
        output {
            /// Manipulated value
            ///
            /// What the actuator gets: the limited sum, or MAN, times LMN_FAC plus LMN_OFF. It keeps its value
            /// between two calls and is 0 after a restart.
            lmn: Real;
            /// Manipulated value as an analog output word: 27648 is 100 %; wraps beyond 118.5 %
            ///
            /// LMN * 276.48, rounded to a whole number: 50 % is 13824, 100 % is 27648. It is not clipped (clause
            /// 12): keep both limits, times LMN_FAC plus LMN_OFF, within -118.5 ... 118.5 %. If LMN is a physical
            /// value, scale it to percent outside and leave LMN_PER unconnected.
            lmn_per: Word;
            /// The manipulated value is at its high limit
            ///
            /// TRUE if the value to be limited, MAN in manual mode, is LMN_HLM or more; the integral then does not
            /// rise in the next call. If it stays TRUE in automatic mode, the actuator is too weak for the setpoint
            /// or the limit too low. QLMN_LLM is never TRUE at the same time, even if LMN_HLM is 10 and LMN_LLM 90.
            qlmn_hlm: Bool;
            /// The manipulated value is at its low limit
            ///
            /// TRUE if the value to be limited, MAN in manual mode, is LMN_LLM or less; the integral then does not
            /// fall in the next call. With LMN_LLM = 0 it is TRUE whenever that value is 0, as in the first call
            /// with all start values; that is no fault.
            qlmn_llm: Bool;
            /// Proportional component of the manipulated value
            ///
            /// GAIN * ER, or 0 with P_SEL = FALSE. It is computed in manual mode too and is not limited: with GAIN
            /// 2 and ER = 80 it is 160 while LMN stays at 100.
            lmn_p: Real;
            /// Integral component of the manipulated value
            ///
            /// What the past errors have added up to. When the loop is at rest, LMN_I + DISV is the LMN that the
            /// load needs. In automatic mode it stays within LMN_LLM ... LMN_HLM and stops while LMN is at a limit.
            /// In manual mode it follows MAN - LMN_P - DISV one call later: with MAN = 40 and ER = 10 at GAIN 2 it
            /// is 20.
            lmn_i: Real;
            /// Derivative component of the manipulated value
            ///
            /// A kick at each change of the error, which decays with TM_LAG. At a constant error it returns to 0,
            /// and in manual mode or with D_SEL = FALSE it is 0. It is not limited.
            lmn_d: Real;
            /// Process value in use
            ///
            /// What is compared with SP_INT: PV_IN, or PV_PER scaled by PV_FAC and PV_OFF. Show this one to
            /// operators and alarms. It is computed in manual mode too, and is 0 from a restart until the first
            /// call.
            pv: Real;
            /// Error after the dead band
            ///
            /// SP_INT - PV, less DEADB_W: positive while PV is too low. With DEADB_W = 1 a difference of 3 is 2
            /// here, and one of 0.5 is 0. GAIN is not in it. If it stays away from 0 in automatic mode, LMN is at a
            /// limit, the I action is off or on hold, or the setpoint or a disturbance keeps changing.
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
    const RESPONSES: &'static [Response] = responses::RESPONSES;

    const CHARACTERISTICS: &'static [Characteristic] = responses::CHARACTERISTICS;

    /// Clause 1.
    fn restart(&mut self) {
        self.clear();
        self.memory.i = self.i_itlval;
    }

    #[inline(always)]
    fn call(&mut self) {
        if self.com_rst {
            return self.restart();
        }
        // Clauses 2 and 3.
        self.pv = if self.pvper_on { process_value(self.pv_per, self.pv_fac, self.pv_off) } else { self.pv_in };
        self.er = dead_band(self.sp_int - self.pv, self.deadb_w);
        // Clause 4.
        let e = self.er * self.gain;

        self.lmn_p = if self.p_sel { e } else { 0.0 };
        // Clauses 5 to 10.
        self.lmn_i = self.integral(e);
        self.lmn_d = self.derivative(e);
        let u = if self.man_on { self.man } else { ((self.lmn_p + self.lmn_i) + self.lmn_d) + self.disv };

        // Clause 11.
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
        // Clause 12.
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
    /// INT: the integral after this call (clauses 5 to 9).
    fn integral(&mut self, e: Real) -> Real {
        let memory = &mut self.memory;
        // Clauses 8 and 9.
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
        // Clause 5.
        let ti = self.ti.seconds().max(t * 0.5);
        // Clause 6.
        let mut q = (((t / ti) * (e + memory.e)) * 0.5) + memory.rest;
        // The limit outputs are still those of the previous call.
        if self.int_hold || (q > 0.0 && self.qlmn_hlm) || (q < 0.0 && self.qlmn_llm) {
            q = 0.0;
        }
        let i = memory.i + q;
        memory.rest = (memory.i - i) + q;
        // Clause 7.
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

    /// DIF: the derivative component of this call (clauses 5 and 10).
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
