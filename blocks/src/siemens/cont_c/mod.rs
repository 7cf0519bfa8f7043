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
            /// Every run begins with a restart; set it for one during the run, after a standstill or when LMN is NaN.
            com_rst: Bool = false;
            /// Manual mode: the loop is open and MAN is the manipulated value
            ///
            /// LMN does not jump when MAN_ON falls (clause 9): with MAN = 40, ER = 10 and the start values, the first
            /// automatic call gives 41. It does if SP_INT, the process value, DISV or GAIN changes in that call, or MAN
            /// in the one before. When MAN_ON rises, LMN jumps to MAN.
            man_on: Bool = true;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            ///
            /// TRUE makes the steps of the analog input (0.0036 %) and its range part of the simulation.
            pvper_on: Bool = false;
            /// Proportional action on
            ///
            /// I action alone suits plants that follow at once or consist mostly of dead time.
            p_sel: Bool = true;
            /// Integral action on
            ///
            /// FALSE leaves a P or PD controller, at which an error remains: with GAIN 2, a plant whose gain is 1 and
            /// SP_INT = 60, PV stops at 40, unless DISV supplies the missing LMN.
            i_sel: Bool = true;
        }
        input {
            /// Holds the integral action
            ///
            /// Use it while LMN has no effect for a reason that the block does not see, such as a secondary controller
            /// in manual mode. I_SEL = FALSE, I_ITL_ON, MAN_ON and the limits take precedence.
            int_hold: Bool = false;
            /// Sets the integral action to I_ITLVAL
            ///
            /// Presets the integral before a batch is heated, or takes LMN over from elsewhere, with I_ITLVAL = LMN -
            /// LMN_P - DISV.
            i_itl_on: Bool = false;
        }
        parameter {
            /// Derivative action on
            ///
            /// Makes loops with two or more lags faster and better damped; where the process value is noisy, such as a
            /// flow, it mostly moves the actuator. It acts on the setpoint too.
            d_sel: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// The block measures no time: called every 2 s with CYCLE = 1 s, it integrates at half the rate. Sampling
            /// acts like an additional dead time of CYCLE / 2.
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            ///
            /// In the unit of PV. A step of 10 moves LMN_P by 20 with the start values, and LMN_D, with D_SEL, by 80; a
            /// ramp before the setpoint avoids both.
            sp_int: Real = 0.0;
            /// Process value as a floating point number, -100 ... 100 % or a physical value
            ///
            /// Neither filtered nor checked: noise of 0.5 moves LMN_P by 1 with GAIN 2, and a value that fails to 0
            /// drives LMN to a limit.
            pv_in: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            ///
            /// 32768 ... 65535 count as negative words. Overflow and underflow of an analog input, 32767 and -32768,
            /// count as process values: check for a broken wire outside.
            pv_per: Word = Word::new(0);
            /// Manual value, -100 ... 100 % or a physical value
            ///
            /// Acts before the limits, LMN_FAC and LMN_OFF. If it goes from 40 to 50 in the last manual call, LMN
            /// returns to 40 (clause 9).
            man: Real = 0.0;
        }
        parameter {
            /// Proportional gain
            ///
            /// In percent of LMN per unit of PV; negative if PV falls when LMN rises, as in cooling. An error step of
            /// 10 with the start values gives LMN_P = 20, an LMN_I that rises by 1 per second, and LMN_D = 80 at first.
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE
            ///
            /// The time in which LMN_I grows by GAIN * ER at a constant error. Too short a TI makes the loop oscillate.
            /// A change does not make LMN jump.
            ti: Time = Time::ms(20_000);
            /// Derivative time; range: TD >= CYCLE
            ///
            /// If the error changes by 0.5 per second, LMN_D settles at GAIN * TD * 0.5. Begin with half the plant's
            /// dead time or its second largest time constant, and stay below TI / 4.
            td: Time = Time::ms(10_000);
            /// Time lag of the derivative action; range: TM_LAG >= CYCLE / 2
            ///
            /// The time constant with which LMN_D decays: 8, 4.8, 2.88 after an error step of GAIN * ER = 2 with the
            /// start values, or 20, 0, 0 at CYCLE / 2 or less. Choose TD / 10 ... TD / 5; more if noise moves the
            /// actuator.
            tm_lag: Time = Time::ms(2_000);
            /// Dead band: half the width of the band in which the error counts as 0
            ///
            /// A difference of 5 with DEADB_W = 2 gives ER = 3. Use it against a limit cycle behind a coarse actuator:
            /// if the pulses resolve 1 % and the plant's gain is 2, 1 is enough. A value below 0 makes every error
            /// larger.
            deadb_w: Real = 0.0, min 0.0;
            /// High limit of the manipulated value; range: LMN_LLM ... 100 % or a physical value
            ///
            /// Acts before LMN_FAC and LMN_OFF, on MAN too. LMN leaves the limit as soon as LMN_P or LMN_D falls,
            /// without first unwinding the integral. If it is lowered, LMN and LMN_I go down at once.
            lmn_hlm: Real = 100.0;
            /// Low limit of the manipulated value; range: -100 % ... LMN_HLM or a physical value
            ///
            /// As LMN_HLM. The start value is for actuators with one direction: heating and cooling, or negative pulses
            /// behind the block, need -100.
            lmn_llm: Real = 0.0;
            /// Factor of the process value from PV_PER
            ///
            /// The span of the transmitter divided by 100: 4 for 0 ... 400 degC, so that 13824 (50 %) reads 200. With 4
            /// instead of 1, a quarter of the GAIN gives the same loop.
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            ///
            /// PV at PV_PER = 0: for a transmitter whose 0 ... 27648 means -50 ... 150 degC, PV_OFF is -50 and PV_FAC
            /// 2, and 13824 reads 50.
            pv_off: Real = 0.0;
            /// Factor of the manipulated value
            ///
            /// A part of the loop's gain: with 0.5, the loop needs twice the GAIN. -1 with LMN_OFF = 100 reverses an
            /// actuator: 30 becomes 70.
            lmn_fac: Real = 1.0;
            /// Offset of the manipulated value
            ///
            /// Added last. With LMN_FAC = 0.5 and LMN_OFF = 50, limits of -100 and 100 become 0 and 100. A restart
            /// gives LMN = 0.
            lmn_off: Real = 0.0;
        }
        input {
            /// Value of the integral action at the restart and with I_ITL_ON, -100 ... 100 % or a physical value
            ///
            /// Choose the LMN that the plant needs at its usual setpoint. The first automatic call adds half a step:
            /// 40.5 for 40 with ER = 10 and the start values.
            i_itlval: Real = 0.0;
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            ///
            /// Connect a measured disturbance times the LMN that makes up for it: if 1 m3/h more needs 4 % more LMN, 4
            /// times the flow. A constant DISV causes no bump.
            disv: Real = 0.0;
        }
        output {
            /// Manipulated value
            ///
            /// The limited sum, or MAN, times LMN_FAC plus LMN_OFF. It holds between two calls.
            lmn: Real;
            /// Manipulated value as an analog output word: 27648 is 100 %; wraps beyond 118.5 %
            ///
            /// Not clipped (clause 12): if LMN is a physical value, scale it to percent outside and leave LMN_PER
            /// unconnected.
            lmn_per: Word;
            /// The manipulated value is at its high limit
            ///
            /// If it stays TRUE in automatic mode, the actuator is too weak for the setpoint or the limit too low.
            qlmn_hlm: Bool;
            /// The manipulated value is at its low limit
            ///
            /// With LMN_LLM = 0 it is TRUE whenever the value to be limited is 0, as in the first call; that is no
            /// fault.
            qlmn_llm: Bool;
            /// Proportional component of the manipulated value
            ///
            /// GAIN * ER, in manual mode too, and not limited: with GAIN 2 and ER = 80 it is 160 while LMN stays at
            /// 100.
            lmn_p: Real;
            /// Integral component of the manipulated value
            ///
            /// At rest, LMN_I + DISV is the LMN that the load needs. In manual mode it follows MAN - LMN_P - DISV one
            /// call later: 20 with MAN = 40, ER = 10 and GAIN 2.
            lmn_i: Real;
            /// Derivative component of the manipulated value
            ///
            /// A kick at each change of the error, which decays with TM_LAG, and is not limited.
            lmn_d: Real;
            /// Process value in use
            ///
            /// PV_IN, or PV_PER scaled by PV_FAC and PV_OFF, in manual mode too. Show this one to operators and alarms.
            pv: Real;
            /// Error after the dead band
            ///
            /// If it stays away from 0 in automatic mode, LMN is at a limit, the I action is off or on hold, or the
            /// setpoint or a disturbance keeps changing.
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
