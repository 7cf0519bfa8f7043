//! PULSEGEN (FB 43): the pulse generator.

mod responses;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;

use crate::siemens::advice;
use crate::table::{Characteristic, Law, Real, Response, rnd};

crate::block! {
    /// Pulse duration modulation of a manipulated value for proportional actuators, in three or two steps (FB 43).
    ///
    #[doc = include_str!("page.md")]
    pub struct Pulsegen as "PULSEGEN" | "FB 43" | "SFB 43" {
        input {
            /// Manipulated value in percent, to be turned into pulses
            ///
            /// Connect LMN of CONT_C here, limited to the range of the actuator. It is read at the start of a period,
            /// or in any call with SYN_ON. In three-step control 30 with PER_TM = 1 s is a positive pulse of 0.3 s.
            /// Values beyond the range give a full pulse in their direction; in two-step control, values below it give
            /// none.
            inv: Real = 0.0, min -100.0, max 100.0;
        }
        parameter {
            /// Period of the pulses, in which INV is updated once; range: PER_TM >= 20 CYCLE
            ///
            /// Choose a tenth of the plant's dominant time constant or less, and long enough for the wear of the relay:
            /// 1 s suits solid-state relays, 10 ... 60 s contactors and heating valves. PER_TM / CYCLE is the
            /// resolution: 1 % with the start values. In the loop it acts like a dead time of about PER_TM / 2. A
            /// change takes effect with the next period.
            per_tm: Time = Time::ms(1000);
            /// Minimum length of a pulse and of a break; range: P_B_TM >= CYCLE
            ///
            /// Shorter pulses are omitted, shorter breaks filled: with PER_TM = 1 s and 0.05 s, INV below 5 % gives no
            /// pulse and INV above 95 % a full pulse. Use the shortest acceptable on time of the relay or valve. Above
            /// PER_TM / 2 the output is either off or fully on, above PER_TM always fully on.
            p_b_tm: Time = Time::ms(50);
            /// Ratio of the lengths of negative and positive pulses
            ///
            /// Compensates for different process gains for heating and cooling, in three-step control only. If cooling
            /// is twice as strong, set 0.5: INV = -50 gives 25 %. Above 1 it divides the positive pulses: with 2, INV =
            /// 50 gives 25 %. The minimum time of the pulses that it shortens is reduced by the same factor.
            ratiofac: Real = 1.0, min 0.1, max 10.0;
            /// Three-step control: positive and negative pulses; otherwise two-step control
            ///
            /// TRUE: QPOS_P and QNEG_P drive two actuators, such as heating and cooling. FALSE: QPOS_P drives one
            /// actuator, QNEG_P is its opposite, and ST2BI_ON selects the range of INV. A change affects the pulse
            /// width from the next period, but the outputs at once.
            step3_on: Bool = true;
            /// Two-step control is bipolar, -100 ... 100 % (TRUE), or monopolar, 0 ... 100 % (FALSE)
            ///
            /// Only with STEP3_ON = FALSE. TRUE: INV = -100 is off, 0 is half on, 100 is on. FALSE: 0 is off, 100 is
            /// on, for a controller with LMN_LLM = 0. The wrong choice halves or doubles the loop gain.
            st2bi_on: Bool = false;
        }
        input {
            /// Manual mode: POS_P_ON and NEG_P_ON set the outputs
            ///
            /// POS_P_ON and NEG_P_ON act in the same call, regardless of period and minimum time. The first call with
            /// FALSE starts a new period with the INV of that call.
            man_on: Bool = false;
            /// Manual positive pulse
            ///
            /// In three-step control it sets QPOS_P unless NEG_P_ON is TRUE as well; in two-step control QPOS_P follows
            /// it, and QNEG_P is the opposite.
            pos_p_on: Bool = false;
            /// Manual negative pulse; no effect in two-step control
            ///
            /// In three-step control it sets QNEG_P unless POS_P_ON is TRUE as well. It acts only with MAN_ON.
            neg_p_on: Bool = false;
            /// Synchronization: a change in INV starts a new period
            ///
            /// TRUE: a new INV ends the current period, except in its first call and its last two. This avoids a delay
            /// of up to PER_TM if the controller computes INV once per period. With an INV that changes in every call,
            /// a period lasts two calls, and 30 % of ten calls is on all the time: use FALSE in that case.
            syn_on: Bool = true;
            /// Complete restart: TRUE runs the restart routine instead of the generator
            ///
            /// While it is TRUE, every call is a restart: both outputs are FALSE, including QNEG_P in two-step control.
            /// The first call after the restart starts a period.
            com_rst: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// Pulses and periods are whole numbers of calls. Choose PER_TM / 100 for a resolution of 1 %, and call the
            /// controller before it less often: its CYCLE may be PER_TM.
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Positive pulse
            ///
            /// It shows the state in the last call of the communication step: with a step of PER_TM always the same
            /// call of the period. Use Q_MEAN for steps longer than CYCLE and for a plant with a Real input.
            qpos_p: Bool;
            /// Negative pulse; in two-step control the opposite of QPOS_P
            ///
            /// In two-step control it is TRUE whenever QPOS_P is FALSE, except after a restart. Do not connect it to a
            /// second actuator in this case.
            qneg_p: Bool;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step in percent, negative ones negative (not in the manual)
        ///
        /// Connects the pulses to a plant with a Real input. With a communication step of one period it is INV, rounded
        /// to whole calls: 34 in a period of ten calls gives 30. In steps of one CYCLE it is 100, 0 or -100. In
        /// two-step control it counts QPOS_P only.
        q_mean;
    }
    memory Memory {
        /// INV of the previous call.
        inv: Real;
        /// R: calls left in the period.
        period_left: i32;
        /// K: calls left in the pulse.
        pulse_left: i32;
        /// Whether the pulse is negative.
        negative: bool;
        /// The pulse of the last call: +1 positive, -1 negative, 0 none.
        pulse: i32;
    }
}

impl Law for Pulsegen {
    const RESPONSES: &'static [Response] = responses::RESPONSES;

    const DRAWN_UNIT: Option<&'static str> = Some("%");

    const CHARACTERISTICS: &'static [Characteristic] = responses::CHARACTERISTICS;

    /// Clause 1.
    fn restart(&mut self) {
        self.clear();
    }

    #[inline(always)]
    fn call(&mut self) {
        if self.com_rst {
            return self.restart();
        }
        if self.man_on {
            self.manual();
        } else {
            self.automatic();
        }
        self.memory.inv = self.inv;
        // In two-step control, QNEG_P is the inverse of QPOS_P and not a pulse.
        self.memory.pulse = i32::from(self.qpos_p) - i32::from(self.step3_on && self.qneg_p);
    }

    fn advice(&self) -> Vec<String> {
        advice::pulsegen(self, "")
    }

    fn pulse(&self) -> i32 {
        self.memory.pulse
    }
}

impl Pulsegen {
    /// Manual mode (clause 8).
    fn manual(&mut self) {
        if self.step3_on {
            self.qpos_p = self.pos_p_on && !self.neg_p_on;
            self.qneg_p = self.neg_p_on && !self.pos_p_on;
        } else {
            self.qpos_p = self.pos_p_on;
            self.qneg_p = !self.pos_p_on;
        }
        self.memory.period_left = 0;
    }

    /// Periods and pulses (clauses 2, 3, 6 and 7).
    fn automatic(&mut self) {
        if self.memory.period_left <= 0 {
            let cycle = self.cycle.real();
            let (width, negative) = self.width();
            self.memory.period_left = rnd(self.per_tm.real() / cycle).max(0);
            self.memory.pulse_left = rnd(width / cycle);
            self.memory.negative = negative;
        } else if self.syn_on && self.inv_has_changed() && self.memory.period_left > 2 {
            // Clause 9.
            self.memory.period_left = 1;
        }
        let on = self.memory.pulse_left > 0;
        if self.step3_on {
            self.qpos_p = on && !self.memory.negative;
            self.qneg_p = on && self.memory.negative;
        } else {
            self.qpos_p = on;
            self.qneg_p = !on;
        }
        self.memory.period_left -= 1;
        self.memory.pulse_left = self.memory.pulse_left.saturating_sub(1).max(0);
    }

    /// Whether INV is above or below its value in the last call; false if either value is NaN.
    fn inv_has_changed(&self) -> bool {
        self.inv.partial_cmp(&self.memory.inv).is_some_and(Ordering::is_ne)
    }

    /// The width of the pulse in milliseconds, and whether it is negative (clauses 3 to 7).
    fn width(&self) -> (Real, bool) {
        let period = self.per_tm.real();
        let shortest = self.p_b_tm.real();
        let positive = self.inv > 0.0;
        let (factor, offset, scale) = if self.step3_on {
            // Clause 5.
            let factor = match (positive, self.ratiofac > 1.0) {
                (true, true) => 1.0 / self.ratiofac,
                (false, false) => self.ratiofac,
                _ => 1.0,
            };
            (factor, 0.0, factor)
        } else if self.st2bi_on {
            if self.inv < -100.0 { (0.0, 0.0, 1.0) } else { (0.5, 0.5 * period, 1.0) }
        } else {
            (if self.inv < 0.0 { 0.0 } else { 1.0 }, 0.0, 1.0)
        };
        let width = ((((self.inv * factor) * period) * 0.01) + offset).abs();
        // Clause 4.
        let width = if width > scale * (period - shortest) {
            scale * period
        } else if width < scale * shortest {
            0.0
        } else {
            width
        };
        (width, self.step3_on && !positive)
    }
}
