//! PULS_CTR: the manual's example of a controller with a pulse output.

mod responses;
#[cfg(test)]
mod tests;

use crate::siemens::advice;
use crate::table::{Bool, Int, Law, Response, Time};
use crate::{ContC, Pulsegen};

crate::block! {
    /// Continuous PID controller with a pulse output: CONT_C and PULSEGEN in one block, at two rates.
    ///
    #[doc = include_str!("page.md")]
    pub struct PulsCtr as "PULS_CTR" {
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            ///
            /// In the unit of the process value: percent with the start values. It is read only when the controller
            /// runs, every 2 s with the start values. A step of 10 moves DI_CONT_C.LMN_P by 20 with GAIN 2, and the
            /// length of the next pulse by 20 % of the period.
            sp_int: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            ///
            /// DI_CONT_C.PV_FAC and DI_CONT_C.PV_OFF scale it: 13824 (50 %) is 200 with PV_FAC 4 and PV_OFF 0; words
            /// from 32768 up are negative. It is read only when the controller runs. A simulated plant with an output
            /// in degC needs a conversion, times 27648 / 400 for 0 ... 400 degC. The block does not detect a broken
            /// wire.
            pv_per: Word = Word::new(0);
        }
        fixed {
            /// Calls from one call of the controller to the next
            ///
            /// The controller runs in one of RED_FAC calls, with the sampling time CYCLE * RED_FAC, which is also the
            /// period of the pulses. 200 calls give a resolution of 0.5 % of LMN, 20 calls 5 %. Choose CYCLE * RED_FAC
            /// no longer than a tenth of the plant's time constant, and RED_FAC 100 or more; shorten CYCLE if this is
            /// impossible.
            red_fac: Int = 200, min 1;
        }
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            ///
            /// While it is TRUE, every call restarts both blocks inside: a pulse ends at once, LMN is 0, and the
            /// integral becomes DI_CONT_C.I_ITLVAL. After it becomes FALSE, there is no pulse for RED_FAC calls.
            com_rst: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// The pulse length is a multiple of CYCLE. 10 ms, a half-wave at 50 Hz, suits a solid-state relay; a
            /// contactor needs a longer DI_PULSEGEN.P_B_TM, not a longer CYCLE. Twice the CYCLE with half the RED_FAC
            /// makes the pulses coarser and leaves the controller unchanged.
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Positive pulse
            ///
            /// TRUE in the first LMN percent of each period: with LMN = 30 and RED_FAC = 200 for 60 calls, then FALSE
            /// for 140. A pulse or break shorter than DI_PULSEGEN.P_B_TM is omitted. With a negative LMN it stays
            /// FALSE, and the pulses appear at DI_PULSEGEN.QNEG_P. It shows the state in the last call: use Q_MEAN if
            /// the communication step is longer than CYCLE.
            qpos_p: Bool;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step in percent, negative ones negative (not in the manual)
        ///
        /// With a communication step of one period it is LMN to a resolution of 100 / RED_FAC: 30 for LMN = 30. In a
        /// step of one CYCLE it is 100, 0 or -100; with steps that are not a multiple of the period it fluctuates.
        /// Connect it to a plant with a Real input. In two-step control (DI_PULSEGEN.STEP3_ON = FALSE) only QPOS_P
        /// counts.
        q_mean;
    }
    instances {
        /// The controller.
        di_cont_c: ContC {
            wired: com_rst cycle sp_int pv_per;
            start: pvper_on = Bool(true), man_on = Bool(false);
        }
        /// The pulse generator.
        di_pulsegen: Pulsegen {
            wired: inv per_tm com_rst cycle;
        }
    }
    memory Memory {
        /// Calls until the controller is called again.
        s_count: Int;
    }
}

impl Law for PulsCtr {
    const RESPONSES: &'static [Response] = responses::RESPONSES;

    const DRAWN_UNIT: Option<&'static str> = Some("%");

    /// Clause 1.
    fn restart(&mut self) {
        self.program(true);
    }

    fn call(&mut self) {
        self.program(self.com_rst);
    }

    fn check(&self) -> Result<(), String> {
        if self.red_fac < 1 {
            return Err(format!(
                "RED_FAC is {}, but CONT_C is called every RED_FAC calls: set RED_FAC to 1 or more",
                self.red_fac
            ));
        }
        let cycle = self.cycle.milliseconds();
        if cycle.checked_mul(i32::from(self.red_fac)).is_none() {
            return Err(format!(
                "CYCLE is {} s and RED_FAC {}, but CONT_C's sampling time CYCLE * RED_FAC cannot exceed {} s: \
                 set RED_FAC to {} or less, or a shorter CYCLE",
                f64::from(cycle) / 1000.0,
                self.red_fac,
                f64::from(i32::MAX) / 1000.0,
                i32::MAX / cycle
            ));
        }
        Ok(())
    }

    fn advice(&self) -> Vec<String> {
        // The restart sets the times of the inner blocks.
        let mut block = self.clone();
        block.restart();
        let mut advice = advice::cont_c(&block.di_cont_c, "DI_CONT_C.");
        advice.extend(advice::pulsegen(&block.di_pulsegen, "DI_PULSEGEN."));
        advice
    }

    fn pulse(&self) -> i32 {
        self.di_pulsegen.pulse()
    }
}

impl PulsCtr {
    /// The statement list, line by line (clauses 1 to 3).
    fn program(&mut self, com_rst: Bool) {
        let memory = &mut self.memory;
        if com_rst {
            memory.s_count = 0;
        }
        // The instruction L fills the upper half of the accumulator with zeros, whatever the sign of the INT.
        let red_fac = i32::from(self.red_fac.cast_unsigned());
        // Clause 2.
        let t_cyc_ctr = Time::ms(self.cycle.milliseconds().wrapping_mul(red_fac));
        memory.s_count = memory.s_count.wrapping_sub(1);
        if memory.s_count <= 0 {
            self.di_cont_c.com_rst = com_rst;
            self.di_cont_c.cycle = t_cyc_ctr;
            self.di_cont_c.sp_int = self.sp_int;
            self.di_cont_c.pv_per = self.pv_per;
            self.di_cont_c.call();
            memory.s_count = self.red_fac;
        }
        // Clause 3.
        self.di_pulsegen.inv = self.di_cont_c.lmn;
        self.di_pulsegen.per_tm = t_cyc_ctr;
        self.di_pulsegen.com_rst = com_rst;
        self.di_pulsegen.cycle = self.cycle;
        self.di_pulsegen.call();
        self.qpos_p = self.di_pulsegen.qpos_p;
    }
}
