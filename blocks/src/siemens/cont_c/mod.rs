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
            /// For a restart during operation: after a shutdown, or if LMN is NaN.
            com_rst: Bool = false;
            /// Manual mode: the loop is open and MAN is the manipulated value
            ///
            /// LMN does not jump when MAN_ON becomes FALSE (clause 9), unless SP_INT, the process value, DISV or GAIN
            /// changes in that call, or MAN in the previous one. When MAN_ON becomes TRUE, LMN jumps to MAN.
            man_on: Bool = true;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            ///
            /// TRUE also simulates the resolution (0.0036 %) and the range of the analog input.
            pvper_on: Bool = false;
            /// Proportional action on
            ///
            /// I action alone suits plants that respond immediately or consist mostly of dead time.
            p_sel: Bool = true;
            /// Integral action on
            ///
            /// FALSE leaves a P or PD controller with a steady-state error (a third of SP_INT with GAIN = 2 and a plant
            /// gain of 1), unless DISV supplies the LMN.
            i_sel: Bool = true;
        }
        input {
            /// Holds the integral action
            ///
            /// Use it while LMN has no effect, as with a secondary controller in manual mode. I_SEL = FALSE, I_ITL_ON,
            /// MAN_ON and the limits take precedence.
            int_hold: Bool = false;
            /// Sets the integral action to I_ITLVAL
            ///
            /// Use it to preset the integral before a batch, or to take over an LMN from elsewhere: I_ITLVAL = LMN -
            /// LMN_P - DISV.
            i_itl_on: Bool = false;
        }
        parameter {
            /// Derivative action on
            ///
            /// Speeds up loops with two or more lags; with a noisy PV, such as a flow, it mainly wears the actuator. It
            /// also acts on the setpoint.
            d_sel: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// In the PLC, it must be the period of the calling OB. Sampling acts like an additional dead time of CYCLE
            /// / 2.
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            ///
            /// In the unit of PV. A step moves LMN_P and LMN_D at once; a ramp before SP_INT avoids this.
            sp_int: Real = 0.0;
            /// Process value as a floating point number, -100 ... 100 % or a physical value
            ///
            /// Neither filtered nor checked: a signal that fails to 0 drives LMN to a limit.
            pv_in: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            ///
            /// 32768 ... 65535 count as negative words. Overflow and underflow, 32767 and -32768, count as process
            /// values: check for a broken wire outside the block.
            pv_per: Word = Word::new(0);
            /// Manual value, -100 ... 100 % or a physical value
            ///
            /// Acts before the limits, LMN_FAC and LMN_OFF. A change in the last manual call is lost (clause 9).
            man: Real = 0.0;
        }
        parameter {
            /// Proportional gain
            ///
            /// In percent of LMN per unit of PV; negative if PV falls when LMN rises, as in cooling. With the start
            /// values, an ER of 10 gives LMN_P = 20, and LMN_I rises by 1 per second.
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE
            ///
            /// The time in which LMN_I grows by GAIN * ER. Too short a TI makes the loop oscillate. A change is
            /// bumpless. TI = 0 counts as CYCLE / 2; I_SEL = FALSE switches the integral action off.
            ti: Time = Time::ms(20_000);
            /// Derivative time; range: TD >= CYCLE
            ///
            /// LMN_D settles at GAIN * TD times the slope of ER. Start with half the plant's dead time or its second
            /// largest time constant, and stay below TI / 4.
            td: Time = Time::ms(10_000);
            /// Time lag of the derivative action; range: TM_LAG >= CYCLE / 2
            ///
            /// The time constant with which LMN_D decays: 8, 4.8, 2.88 with the start values, at once at CYCLE / 2 or less.
            /// Choose TD / 10 ... TD / 5, or more against noise.
            tm_lag: Time = Time::ms(2_000);
            /// Dead band: half the width of the band in which the error counts as 0
            ///
            /// A difference of 5 with DEADB_W = 2 gives ER = 3. It prevents a limit cycle with a coarse actuator:
            /// choose 1 for pulses with a resolution of 1 % and a plant gain of 2.
            deadb_w: Real = 0.0, min 0.0;
            /// High limit of the manipulated value; range: LMN_LLM ... 100 % or a physical value
            ///
            /// Acts before LMN_FAC and LMN_OFF, and also on MAN. LMN leaves the limit as soon as LMN_P or LMN_D falls,
            /// without first unwinding the integral. Lowering the limit lowers LMN and LMN_I at once.
            lmn_hlm: Real = 100.0;
            /// Low limit of the manipulated value; range: -100 % ... LMN_HLM or a physical value
            ///
            /// Like LMN_HLM. Heating and cooling, or negative pulses from PULSEGEN, need -100.
            lmn_llm: Real = 0.0;
            /// Factor of the process value from PV_PER
            ///
            /// The scaling that normalizes the word: PV = PV_PER * 100 / 27648 * PV_FAC + PV_OFF. PV_FAC is the
            /// transmitter's span divided by 100: 4 for 0 ... 400 degC. With 4 instead of 1, a quarter of the GAIN gives
            /// the same loop gain.
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            ///
            /// PV at PV_PER = 0: -50, with PV_FAC = 2, for a transmitter of -50 ... 150 degC; 13824 is then 50.
            pv_off: Real = 0.0;
            /// Factor of the manipulated value
            ///
            /// Part of the loop gain: 0.5 needs twice the GAIN. -1 with LMN_OFF = 100 reverses an actuator.
            lmn_fac: Real = 1.0;
            /// Offset of the manipulated value
            ///
            /// Added last: 50, with LMN_FAC = 0.5, maps limits of -100 and 100 to 0 and 100.
            lmn_off: Real = 0.0;
        }
        input {
            /// Value of the integral action at the restart and with I_ITL_ON, -100 ... 100 % or a physical value
            ///
            /// Choose the LMN that the plant needs at its usual setpoint. The first call in automatic mode adds half an
            /// integration step.
            i_itlval: Real = 0.0;
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            ///
            /// A measured disturbance times the change in LMN that compensates for one unit of it: 4 times the flow if 1
            /// m3/h more needs 4 % more LMN.
            disv: Real = 0.0;
        }
        output {
            /// Manipulated value
            ///
            /// The limited sum of the components and DISV, or MAN, times LMN_FAC, plus LMN_OFF. Held between two calls.
            lmn: Real;
            /// Manipulated value as an analog output word: 27648 is 100 %; wraps beyond 118.5 %
            ///
            /// If LMN is a physical value, scale it outside the block and leave LMN_PER unconnected.
            lmn_per: Word;
            /// The manipulated value is at its high limit
            ///
            /// If it stays TRUE in automatic mode, the actuator is too weak or the limit too low.
            qlmn_hlm: Bool;
            /// The manipulated value is at its low limit
            ///
            /// With LMN_LLM = 0 it is TRUE whenever the value to be limited is 0, as in the first call.
            qlmn_llm: Bool;
            /// Proportional component of the manipulated value
            ///
            /// GAIN * ER, in manual mode too; not limited: 160 for GAIN = 2 and ER = 80.
            lmn_p: Real;
            /// Integral component of the manipulated value
            ///
            /// In steady state, LMN_I + DISV is the LMN that the load needs. In manual mode LMN_I follows MAN - LMN_P -
            /// DISV one call later.
            lmn_i: Real;
            /// Derivative component of the manipulated value
            ///
            /// A kick at each change in ER, which decays with TM_LAG; not limited.
            lmn_d: Real;
            /// Process value in use
            ///
            /// PV_IN, or PV_PER scaled, in manual mode too: the value for operators and alarms.
            pv: Real;
            /// Error after the dead band
            ///
            /// If it does not return to 0 in automatic mode, LMN is at a limit, or the I action is off or on hold.
            er: Real;
        }
    }
    memory Memory {
        /// Error times GAIN in the previous call.
        e: Real;
        /// Integral of the previous call.
        i: Real;
        /// Round-off error of the integral.
        rest: Real;
        /// Whether the integral has been set to a value and not been within the limits since; until then, it is not
        /// limited.
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

    const DRAWN_UNIT: Option<&'static str> = Some("%");

    const CHARACTERISTICS: &'static [Characteristic] = responses::CHARACTERISTICS;

    /// Clause 1.
    #[inline(always)]
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
        // Limited first, then scaled, and not limited again.
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
    #[inline(always)]
    fn integral(&mut self, e: Real) -> Real {
        let memory = &mut self.memory;
        // Clauses 8 and 9.
        let put = if !self.i_sel {
            Some(0.0)
        } else if self.i_itl_on {
            Some(self.i_itlval)
        } else if self.man_on {
            // LMN_P and DISV of this call, the limited value of the previous one: automatic mode begins without a bump.
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
        // The mean of this and the previous error, plus the accumulated rounding error. Clause 6.
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
    #[inline(always)]
    fn derivative(&mut self, e: Real) -> Real {
        let memory = &mut self.memory;
        if !self.d_sel || self.man_on {
            memory.rest_d = 0.0;
            memory.w = e;
            return 0.0;
        }
        // w follows the error with a lag of about TM_LAG; the component is the error minus w, scaled by TD.
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
#[inline(always)]
fn analog_output(lmn: Real) -> Int {
    low_word(rnd(lmn * 276.48))
}
