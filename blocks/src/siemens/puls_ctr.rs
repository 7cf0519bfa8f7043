//! PULS_CTR: the manual's example of a controller with a pulse output.

use crate::siemens::advice;
use crate::table::{Bool, Int, Law, Response, Time};
use crate::{ContC, Pulsegen};

crate::block! {
    /// Continuous PID controller with a pulse output: CONT_C and PULSEGEN in one block, at two rates.
    ///
    /// # Purpose
    ///
    /// PULS_CTR holds a process value at its setpoint with an actuator that is only switched: CONT_C computes a
    /// manipulated value in percent, and PULSEGEN switches the output on for that share of a period. It is used for
    /// heaters, solenoid valves and cooling machines behind a relay or contactor, with a period so short against the
    /// plant's time constant that the plant smooths the pulses. It leaves setpoint ramps, filters and supervision to
    /// others, as CONT_C does, and it has no output of its own for negative pulses: these are DI_PULSEGEN.QNEG_P.
    ///
    /// # Quick start
    ///
    /// 1. Calls: CYCLE is the time between two calls, 10 ms for a solid-state relay.
    /// 2. Period: RED_FAC so that CYCLE * RED_FAC is at most a tenth of the plant's time constant, and at least 100 for
    ///    a resolution of 1 %. 200 gives 2 s, which suits a plant of 20 s and more.
    /// 3. Process value: connect PV_PER, and set DI_CONT_C.PV_FAC and DI_CONT_C.PV_OFF: 4 and 0 for a transmitter of 0
    ///    ... 400 degC.
    /// 4. Tuning: in manual mode (DI_CONT_C.MAN_ON), change DI_CONT_C.MAN and watch PV. K is the change of PV divided by
    ///    that of MAN, L the time until PV begins to move plus CYCLE * RED_FAC (half of it for the sampling, half for the
    ///    pulses), T the time from there to 63 % of the change. Set DI_CONT_C.GAIN = T / (2 K L) and DI_CONT_C.TI to the
    ///    smaller one of T and 8 L: GAIN = 1.04 and TI = 96 s for K = 4 degC per percent, T = 100 s and a dead time of 10
    ///    s, so L = 12 s.
    /// 5. Shortest pulse: DI_PULSEGEN.P_B_TM as the actuator needs it, 50 ms for a solenoid valve, 0.2 s and more for a
    ///    contactor. Then set SP_INT; the controller starts in automatic mode.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon pulses
    /// frame 25,-1 16,17 "every RED_FAC calls"
    /// frame 55,-1 18,17 "every call"
    /// input SP_INT 0,5.5
    /// input PV_PER 0,9.5
    /// input RED_FAC 0,14
    /// input CYCLE 0,19
    /// input COM_RST 0,24
    /// box tCycCtr 15,15.5 multiply
    /// box DI_CONT_C 33,8.5 in SP_INT PV_PER CYCLE COM_RST out LMN
    /// box DI_PULSEGEN 64,8.5 in INV PER_TM CYCLE COM_RST out QPOS_P QNEG_P Q_MEAN
    /// value DI_CONT_C.LMN 42,5.5
    /// output QPOS_P 76,5.5
    /// output Q_MEAN 76,13
    /// SP_INT > DI_CONT_C.SP_INT
    /// PV_PER > x20.5 > DI_CONT_C.PV_PER
    /// RED_FAC > x10 > tCycCtr.left-0.5
    /// CYCLE > x10 > tCycCtr.left+0.5
    /// tCycCtr > x22 > DI_CONT_C.CYCLE
    /// COM_RST > x23.5 > DI_CONT_C.COM_RST
    /// DI_CONT_C.LMN: DI_CONT_C.LMN > DI_PULSEGEN.INV
    /// 22,15.5 > y20 > x51.2 > DI_PULSEGEN.PER_TM
    /// 8,19 > y22 > x52.5 > DI_PULSEGEN.CYCLE
    /// 23.5,24 > x53.8 > DI_PULSEGEN.COM_RST
    /// DI_PULSEGEN.QPOS_P > QPOS_P
    /// DI_PULSEGEN.Q_MEAN > x74.5 > Q_MEAN
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// setpoint: SP_INT
    /// process value: PV_PER, DI_CONT_C.PV
    /// manipulated value: Q_MEAN
    /// manual: DI_CONT_C.MAN_ON, DI_CONT_C.MAN
    /// controller: DI_CONT_C.GAIN, DI_CONT_C.TI, DI_CONT_C.TD, DI_CONT_C.TM_LAG
    /// structure: DI_CONT_C.P_SEL, DI_CONT_C.I_SEL, DI_CONT_C.D_SEL
    /// pulses: QPOS_P, DI_PULSEGEN.QNEG_P
    /// pulse former: RED_FAC, DI_PULSEGEN.P_B_TM, DI_PULSEGEN.RATIOFAC
    /// signal process value peripheral: PV_PER
    ///
    /// [Setpoint]
    /// SP_INT
    /// [Process value]
    /// DI_CONT_C.PVPER_ON
    /// DI_CONT_C.PV_IN if not DI_CONT_C.PVPER_ON
    /// PV_PER, DI_CONT_C.PV_FAC, DI_CONT_C.PV_OFF if DI_CONT_C.PVPER_ON
    /// [Dead band]
    /// DI_CONT_C.DEADB_W
    /// [Structure]
    /// DI_CONT_C.P_SEL, DI_CONT_C.I_SEL, DI_CONT_C.D_SEL
    /// [Gain and times]
    /// DI_CONT_C.GAIN if DI_CONT_C.P_SEL or DI_CONT_C.I_SEL or DI_CONT_C.D_SEL
    /// DI_CONT_C.TI if DI_CONT_C.I_SEL and not DI_CONT_C.INT_HOLD and not DI_CONT_C.I_ITL_ON
    /// DI_CONT_C.TD, DI_CONT_C.TM_LAG if DI_CONT_C.D_SEL
    /// [Manual]
    /// DI_CONT_C.MAN_ON
    /// DI_CONT_C.MAN if DI_CONT_C.MAN_ON
    /// [Limits]
    /// DI_CONT_C.LMN_HLM, DI_CONT_C.LMN_LLM
    /// [Normalization]
    /// DI_CONT_C.LMN_FAC, DI_CONT_C.LMN_OFF
    /// [Integral action]
    /// DI_CONT_C.INT_HOLD if DI_CONT_C.I_SEL and not DI_CONT_C.I_ITL_ON
    /// DI_CONT_C.I_ITL_ON, DI_CONT_C.I_ITLVAL if DI_CONT_C.I_SEL
    /// [Disturbance]
    /// DI_CONT_C.DISV
    /// [Pulse former]
    /// RED_FAC, DI_PULSEGEN.P_B_TM
    /// DI_PULSEGEN.STEP3_ON
    /// DI_PULSEGEN.ST2BI_ON if not DI_PULSEGEN.STEP3_ON
    /// DI_PULSEGEN.RATIOFAC if DI_PULSEGEN.STEP3_ON
    /// DI_PULSEGEN.SYN_ON
    /// [Manual pulses]
    /// DI_PULSEGEN.MAN_ON
    /// DI_PULSEGEN.POS_P_ON if DI_PULSEGEN.MAN_ON
    /// DI_PULSEGEN.NEG_P_ON if DI_PULSEGEN.MAN_ON and DI_PULSEGEN.STEP3_ON
    /// [Sampling]
    /// CYCLE, COM_RST
    /// ```
    ///
    /// # Law
    ///
    /// The pulse of a period is as long as the manipulated value demands, in whole calls:
    ///
    /// ```math
    /// \begin{aligned}
    /// T &= \text{CYCLE} \cdot \text{RED_FAC} \\
    /// K &= \text{RND} \left( \dfrac{\text{LMN}}{100} \cdot \dfrac{T}{\text{CYCLE}} \right) \\
    /// \dfrac{K}{\text{RED_FAC}} &\approx \dfrac{\text{LMN}}{100}
    /// \end{aligned}
    /// ```
    ///
    /// `T` is the sampling time of CONT_C and the period of the pulses, `K` the number of calls, at the beginning of a period
    /// of RED_FAC calls, in which QPOS_P is TRUE. This holds for 0 ... 100 % if pulse and break are not shorter than
    /// DI_PULSEGEN.P_B_TM. LMN follows the law of CONT_C; in automatic mode and between the limits:
    ///
    /// ```math
    /// \text{LMN}(s) = \text{GAIN} \left( 1 + \dfrac{1}{\text{TI} \, s}
    ///     + \dfrac{\text{TD} \, s}{1 + \text{TM_LAG} \, s} \right) \text{ER}(s) + \text{DISV}(s)
    /// ```
    ///
    /// The exact order of operations of a call is the example's statement list; sCount is the block's only memory:
    ///
    /// ```text
    /// sCount  = 0 with COM_RST
    /// tCycCtr = CYCLE * RED_FAC
    /// sCount  = sCount - 1
    /// sCount <= 0:
    ///     DI_CONT_C(COM_RST, CYCLE = tCycCtr, SP_INT, PV_PER)
    ///     sCount = RED_FAC
    /// DI_PULSEGEN(INV = DI_CONT_C.LMN, PER_TM = tCycCtr, COM_RST, CYCLE)
    /// QPOS_P  = DI_PULSEGEN.QPOS_P
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Restart (COM_RST): both blocks inside run their restart, and sCount becomes RED_FAC. After it CONT_C first
    ///    runs in call RED_FAC, and then every RED_FAC calls. While COM_RST is TRUE, every call is a restart. (manual)
    /// 2. CONT_C computes with CYCLE * RED_FAC, which is also the period of the pulses; PULSEGEN runs in every call,
    ///    with CYCLE. (manual)
    /// 3. LMN goes to INV in every call. CONT_C runs in the last call of a period, where PULSEGEN does not synchronize,
    ///    so its LMN sets the pulse of the period that starts one call later. (follows from the manual's program)
    /// 4. PV_PER is the process value and the controller starts in automatic mode: DI_CONT_C.PVPER_ON starts TRUE and
    ///    DI_CONT_C.MAN_ON FALSE. CONT_C's own defaults are the opposite; nothing in the example sets them, so the
    ///    output would stay at the manual value 0. (decided)
    /// 5. Inputs of the two inner blocks that the example leaves unconnected are parameters of this block:
    ///    `DI_CONT_C.GAIN`, `DI_CONT_C.MAN`, `DI_PULSEGEN.P_B_TM` and so on. Connected inputs and all outputs can be
    ///    read: `DI_CONT_C.LMN`, `DI_PULSEGEN.QNEG_P`. (decided)
    /// 6. Q_MEAN is ours, not the manual's: that of the inner PULSEGEN, the mean of its pulses over the last
    ///    communication step, +100 % if positive all the time, -100 % if negative all the time. (decided)
    ///
    /// # Sampling
    ///
    /// Call the block every CYCLE. A pulse is a whole number of calls, so RED_FAC is the resolution of LMN: 200 calls
    /// resolve 0.5 %.
    ///
    /// If a host steps ten times CYCLE, the block makes ten calls in that step with the same SP_INT and PV_PER. The
    /// controller is hardly affected, because it runs only every RED_FAC calls, but the host sees QPOS_P of the last of
    /// the ten calls: a pulse of 3 calls may be missed or seem to last for 10. Connect Q_MEAN instead, the mean of the
    /// step. If a host steps a tenth of CYCLE, one step of ten makes a call.
    ///
    /// # Limits of use
    ///
    /// Bad input: RED_FAC below 1 and CYCLE * RED_FAC beyond the longest TIME, 2147483.647 s, are refused before the
    /// restart (decided). Nothing else is checked. Without that check the program behaves as the statement list does:
    /// sCount is an INT that wraps, RED_FAC is loaded without its sign, and the product keeps its low 32 bits.
    ///
    /// Negative manipulated values need `DI_CONT_C.LMN_LLM` below 0 and an actuator on `DI_PULSEGEN.QNEG_P`. SP_INT and
    /// PV_PER act only when the controller runs, so a disturbance may go unseen for up to CYCLE * RED_FAC. LMN_PER of the
    /// controller is not used here, so its wrap beyond 118.5 % does no harm. The controller inside does not know a broken
    /// wire (32767 is 118.51 %), and its change from automatic to manual mode is not bumpless. With DI_PULSEGEN.P_B_TM above
    /// half of the period the output is only off or fully on.
    ///
    /// # Sources
    ///
    /// Standard Software for S7-300 and S7-400, PID Control, User Manual (C79000-G7076-C516), section 3.4, figures 3-10
    /// and 3-11, tables 3-7 and 3-8. For the laws of the inner blocks see `CONT_C` and `PULSEGEN`.
    ///
    /// Decided: RED_FAC starts at 200 and CYCLE at 10 ms, the manual's 2 s and 10 ms; clauses 4 to 6.
    pub struct PulsCtr as "PULS_CTR" {
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            ///
            /// The setpoint of the controller inside, in the unit of its process value: percent with the start values,
            /// degC with DI_CONT_C.PV_FAC = 4 for a transmitter of 0 ... 400 degC. It is read only when the controller
            /// runs, every 2 s with RED_FAC 200 and CYCLE 10 ms. A step of 10 moves DI_CONT_C.LMN_P by 20 with GAIN 2,
            /// and the length of the next pulse by 20 % of the period.
            sp_int: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            ///
            /// The word that the analog input gives; DI_CONT_C.PV_FAC and DI_CONT_C.PV_OFF scale it: 13824 (50 %) is
            /// 200 with PV_FAC 4 and PV_OFF 0. It is read only when the controller runs. A simulated plant that gives
            /// degC needs a conversion before it, times 27648 / 400 for 0 ... 400 degC. The block does not detect a
            /// broken wire: 32767 is 118.51 %.
            pv_per: Word = Word::new(0);
        }
        fixed {
            /// Calls from one call of the controller to the next
            ///
            /// The controller runs in one call of RED_FAC, with the sampling time CYCLE * RED_FAC, which is also the
            /// period of the pulses: 2 s with 200 and 10 ms. It also sets the resolution of the pulses: 200 resolve 0.5 %
            /// of LMN, 20 resolve 5 %. Choose CYCLE * RED_FAC at most a tenth of the plant's time constant, and RED_FAC
            /// 100 or more; shorten CYCLE if the two do not go together. After a restart the first pulse comes after
            /// RED_FAC calls.
            red_fac: Int = 200, min 1;
        }
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            ///
            /// While it is TRUE, every call restarts both blocks inside: a pulse ends at once, LMN is 0, and the
            /// integral becomes DI_CONT_C.I_ITLVAL. When it falls, the controller first runs after RED_FAC calls, so
            /// there is no pulse for 2 s with RED_FAC 200 and CYCLE 10 ms. The block does not reset COM_RST. Every run
            /// begins with a restart; set it for another one during the run.
            com_rst: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// A pulse is a whole number of CYCLE long. 10 ms, a half-wave of 50 Hz, suits a solid-state relay; a
            /// contactor needs a longer DI_PULSEGEN.P_B_TM, not a longer CYCLE. The controller does not compute with it
            /// but with CYCLE * RED_FAC, so twice the CYCLE with half the RED_FAC leaves the controller as it is and
            /// makes the pulses coarser.
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Positive pulse
            ///
            /// TRUE in the first LMN percent of each period: with LMN = 30 and RED_FAC = 200 in 60 calls, then FALSE in
            /// 140. A pulse or break shorter than DI_PULSEGEN.P_B_TM is left out: with 50 ms of 2 s, LMN below 2.5
            /// gives no pulse and above 97.5 no break. For a negative LMN it stays FALSE; DI_PULSEGEN.QNEG_P has the
            /// pulses then. It shows the last call, so take Q_MEAN if the communication step is longer than CYCLE.
            qpos_p: Bool;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step in percent, negative ones negative (not in the manual)
        ///
        /// With a communication step of one period it is LMN, to 100 / RED_FAC: 30 for LMN = 30. In a step of one CYCLE
        /// it is 100, 0 or -100; steps that are no multiple of the period make it fluctuate. Connect it to a plant with
        /// a Real input, a heater's power for example. In two-step control (DI_PULSEGEN.STEP3_ON = FALSE) it is between
        /// 0 and 100, because only QPOS_P counts.
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
    const RESPONSES: &'static [Response] = &[
        Response {
            title: "The setpoint rises to 10: the controller responds every 20 calls, and LMN sets the length of each \
                    period's pulse",
            calls: 160,
            set: &[
                (0, "RED_FAC", 20.0),
                (0, "DI_PULSEGEN.P_B_TM", 0.01),
                (0, "DI_CONT_C.TI", 0.5),
                (10, "SP_INT", 10.0),
            ],
            show: &["SP_INT", "DI_CONT_C.LMN", "QPOS_P"],
        },
        Response {
            title: "The setpoint goes from 30 to -60, P action with GAIN 1 and LMN_LLM = -100: the pulses change from QPOS_P \
                    to QNEG_P when the controller has run",
            calls: 160,
            set: &[
                (0, "RED_FAC", 20.0),
                (0, "DI_PULSEGEN.P_B_TM", 0.01),
                (0, "DI_CONT_C.I_SEL", 0.0),
                (0, "DI_CONT_C.GAIN", 1.0),
                (0, "DI_CONT_C.LMN_LLM", -100.0),
                (0, "SP_INT", 30.0),
                (70, "SP_INT", -60.0),
            ],
            show: &["SP_INT", "DI_CONT_C.LMN", "QPOS_P", "DI_PULSEGEN.QNEG_P"],
        },
        Response {
            title: "Periods of 0.2 s with P_B_TM = 0.04 s: an LMN below 20 % gives no pulse, one above 80 % no break",
            calls: 140,
            set: &[
                (0, "RED_FAC", 20.0),
                (0, "DI_PULSEGEN.P_B_TM", 0.04),
                (0, "DI_CONT_C.MAN_ON", 1.0),
                (0, "DI_CONT_C.MAN", 50.0),
                (30, "DI_CONT_C.MAN", 25.0),
                (50, "DI_CONT_C.MAN", 15.0),
                (70, "DI_CONT_C.MAN", 75.0),
                (90, "DI_CONT_C.MAN", 85.0),
                (110, "DI_CONT_C.MAN", 50.0),
            ],
            show: &["DI_CONT_C.LMN", "QPOS_P"],
        },
    ];

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
                "CYCLE is {} s and RED_FAC {}, but CONT_C's sampling time CYCLE * RED_FAC ends at {} s: \
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
        // The restart gives the inner blocks their times.
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
    /// The statement list, line by line.
    fn program(&mut self, com_rst: Bool) {
        let memory = &mut self.memory;
        if com_rst {
            memory.s_count = 0;
        }
        // The instruction L fills the upper half of the accumulator with zeros, whatever the sign of the INT.
        let red_fac = i32::from(self.red_fac.cast_unsigned());
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
        self.di_pulsegen.inv = self.di_cont_c.lmn;
        self.di_pulsegen.per_tm = t_cyc_ctr;
        self.di_pulsegen.com_rst = com_rst;
        self.di_pulsegen.cycle = self.cycle;
        self.di_pulsegen.call();
        self.qpos_p = self.di_pulsegen.qpos_p;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Block, Role, Word};

    /// The controller in every fifth call, proportional with gain 1, without minimum time.
    fn every_fifth() -> PulsCtr {
        let mut block = PulsCtr { red_fac: 5, ..PulsCtr::default() };
        block.di_cont_c.i_sel = false;
        block.di_cont_c.gain = 1.0;
        block.di_pulsegen.p_b_tm = Time::ms(0);
        block
    }

    fn restarted(mut block: PulsCtr) -> PulsCtr {
        block.restart();
        block
    }

    /// QPOS_P of each call; `before` is shown the number of each call, from 1 on.
    fn pulses_with(block: &mut PulsCtr, calls: usize, before: impl Fn(usize, &mut PulsCtr)) -> String {
        let call = |number| {
            before(number, block);
            block.call();
            if block.qpos_p { '+' } else { '.' }
        };
        (1..=calls).map(call).collect()
    }

    /// In which calls LMN was made anew, with a setpoint that differs in every call.
    fn controller_calls(block: &mut PulsCtr, calls: usize) -> Vec<usize> {
        let mut made = Vec::new();
        for number in 1..=calls {
            let before = block.di_cont_c.lmn;
            block.sp_int = number as f32;
            block.call();
            if block.di_cont_c.lmn != before {
                made.push(number);
            }
        }
        made
    }

    #[test]
    fn clause_1_after_a_restart_the_controller_first_runs_in_call_red_fac() {
        assert_eq!(controller_calls(&mut restarted(every_fifth()), 17), [5, 10, 15]);
    }

    #[test]
    fn clause_1_with_red_fac_1_the_controller_runs_in_every_call() {
        let mut block = restarted(PulsCtr { red_fac: 1, ..every_fifth() });
        assert_eq!(controller_calls(&mut block, 4), [1, 2, 3, 4]);
    }

    #[test]
    fn clause_1_com_rst_restarts_both_blocks_inside_at_once_and_counts_anew() {
        let mut block = restarted(PulsCtr { sp_int: 60.0, ..every_fifth() });
        pulses_with(&mut block, 6, |_, _| ());
        assert!(block.qpos_p && block.di_cont_c.lmn == 60.0);
        block.com_rst = true;
        assert_eq!(pulses_with(&mut block, 3, |_, _| ()), "...");
        assert_eq!((block.di_cont_c.lmn, block.di_pulsegen.qpos_p, block.com_rst), (0.0, false, true));
        block.com_rst = false;
        assert_eq!(controller_calls(&mut block, 7), [5]);
    }

    #[test]
    fn clause_1_the_restart_is_the_program_with_com_rst_true() {
        let mut by_call = PulsCtr { com_rst: true, ..every_fifth() };
        by_call.call();
        by_call.com_rst = false;
        assert_eq!(format!("{:?}", restarted(every_fifth())), format!("{by_call:?}"));
    }

    #[test]
    fn clause_1_without_a_restart_the_first_call_already_calls_the_controller() {
        assert_eq!(controller_calls(&mut every_fifth(), 7), [1, 6]);
    }

    #[test]
    fn clause_2_the_controller_computes_with_the_time_between_its_calls() {
        let mut block = every_fifth();
        block.di_cont_c.i_sel = true;
        block.sp_int = 4.0;
        let mut block = restarted(block);
        pulses_with(&mut block, 5, |_, _| ());
        assert_eq!(block.di_cont_c.cycle, Time::ms(50));
        // (0.05 s / 20 s) * (4 + 0) / 2
        assert_eq!(block.di_cont_c.lmn_i, 0.005);
    }

    #[test]
    fn clause_2_the_period_of_the_pulses_is_the_time_between_the_controllers_calls() {
        let mut block = restarted(PulsCtr { sp_int: 40.0, ..every_fifth() });
        assert_eq!(pulses_with(&mut block, 20, |_, _| ()), ".....++...++...++...");
        assert_eq!((block.di_pulsegen.per_tm, block.di_pulsegen.cycle), (Time::ms(50), Time::ms(10)));
    }

    #[test]
    fn clause_3_lmn_becomes_the_pulse_of_the_period_that_starts_one_call_later() {
        let mut block = restarted(every_fifth());
        let run = pulses_with(&mut block, 20, |number, block| block.sp_int = if number < 10 { 20.0 } else { 80.0 });
        assert_eq!(run, ".....+....++++.++++.");
    }

    #[test]
    fn clause_3_the_pulses_are_those_of_the_two_blocks_called_in_this_order() {
        let mut block = restarted(PulsCtr { red_fac: 20, ..PulsCtr::default() });
        let mut controller =
            ContC { pvper_on: true, man_on: false, cycle: Time::ms(200), sp_int: 30.0, ..ContC::default() };
        let mut generator = Pulsegen { per_tm: Time::ms(200), cycle: Time::ms(10), ..Pulsegen::default() };
        controller.restart();
        generator.restart();
        block.sp_int = 30.0;
        let mut seen = 0;
        for call in 1..=2000_i16 {
            let word = Word::new(call.wrapping_mul(37) % 16_000);
            block.pv_per = word;
            block.call();
            if call % 20 == 0 {
                controller.pv_per = word;
                controller.call();
            }
            generator.inv = controller.lmn;
            generator.call();
            assert_eq!(block.qpos_p, generator.qpos_p, "call {call}");
            seen += i32::from(block.qpos_p);
        }
        assert!((200..1800).contains(&seen), "{seen} calls on");
    }

    #[test]
    fn clause_4_the_controller_starts_in_automatic_mode_on_the_analog_value() {
        let mut block = restarted(PulsCtr { red_fac: 1, pv_per: Word::new(-13824), ..PulsCtr::default() });
        block.call();
        assert_eq!((block.di_cont_c.pv, block.di_cont_c.lmn_p), (-50.0, 100.0));
    }

    #[test]
    fn clause_5_settings_inside_are_parameters_and_what_is_wired_or_made_inside_can_be_read() {
        let role = |name| PulsCtr::TABLE.rows[PulsCtr::TABLE.find(name).unwrap()].role;
        for name in ["DI_CONT_C.GAIN", "DI_CONT_C.MAN_ON", "DI_CONT_C.DISV", "DI_PULSEGEN.P_B_TM", "DI_PULSEGEN.SYN_ON"]
        {
            assert_eq!(role(name), Role::Parameter, "{name}");
        }
        for name in [
            "DI_CONT_C.COM_RST",
            "DI_CONT_C.CYCLE",
            "DI_CONT_C.SP_INT",
            "DI_CONT_C.PV_PER",
            "DI_CONT_C.LMN",
            "DI_PULSEGEN.INV",
            "DI_PULSEGEN.PER_TM",
            "DI_PULSEGEN.COM_RST",
            "DI_PULSEGEN.CYCLE",
            "DI_PULSEGEN.QNEG_P",
        ] {
            assert_eq!(role(name), Role::Local, "{name}");
        }
        assert_eq!((role("RED_FAC"), role("CYCLE")), (Role::Fixed, Role::Cycle));
    }

    #[test]
    fn clause_5_the_pulses_inside_do_not_have_a_mean_of_their_own() {
        assert_eq!(PulsCtr::TABLE.find("DI_PULSEGEN.Q_MEAN"), None);
        assert_eq!(PulsCtr::TABLE.mean, PulsCtr::TABLE.find("Q_MEAN"));
        assert!(PulsCtr::TABLE.mean.is_some());
    }

    #[test]
    fn clause_6_the_mean_counts_the_pulses_of_the_generator_inside() {
        let pulse = |sp_int| {
            let mut block = every_fifth();
            block.di_cont_c.lmn_llm = -100.0;
            block.sp_int = sp_int;
            let mut block = restarted(block);
            pulses_with(&mut block, 6, |_, _| ());
            block.pulse()
        };
        assert_eq!([pulse(40.0), pulse(-40.0), pulse(0.0)], [1, -1, 0]);
    }

    #[test]
    fn red_fac_below_1_is_refused_with_its_value_and_the_remedy() {
        for red_fac in [0, -1, Int::MIN] {
            let error = PulsCtr { red_fac, ..PulsCtr::default() }.check().unwrap_err();
            assert!(error.starts_with(&format!("RED_FAC is {red_fac}, ")), "{error}");
            assert!(error.ends_with("set RED_FAC to 1 or more"), "{error}");
        }
        assert_eq!(PulsCtr { red_fac: 1, ..PulsCtr::default() }.check(), Ok(()));
    }

    #[test]
    fn a_sampling_time_of_the_controller_beyond_time_is_refused_with_the_remedy() {
        let check = |cycle, red_fac| PulsCtr { cycle: Time::ms(cycle), red_fac, ..PulsCtr::default() }.check();
        assert_eq!(check(10_737_418, 200), Ok(()));
        let error = check(10_737_419, 200).unwrap_err();
        assert!(error.starts_with("CYCLE is 10737.419 s and RED_FAC 200, "), "{error}");
        assert!(error.contains("2147483.647 s"), "{error}");
        assert!(error.contains("set RED_FAC to 199 or less"), "{error}");
        assert_eq!(check(10_737_419, 199), Ok(()));
        assert_eq!(check(i32::MAX, 1), Ok(()));
    }

    #[test]
    fn unchecked_red_fac_below_1_does_what_the_statement_list_does() {
        // 0: sCount is 0, then -1: the controller runs in every call.
        assert_eq!(controller_calls(&mut restarted(PulsCtr { red_fac: 0, ..every_fifth() }), 3), [1, 2, 3]);
        // -1 is loaded without its sign as 65535, and sCount is -1, then -2.
        let mut block = restarted(PulsCtr { red_fac: -1, ..every_fifth() });
        assert_eq!(block.di_cont_c.cycle, Time::ms(655_350));
        assert_eq!(controller_calls(&mut block, 3), [1, 2, 3]);
        // -32768 less 1 wraps to 32767: so many calls pass before the next.
        let mut block = restarted(PulsCtr { red_fac: Int::MIN, ..every_fifth() });
        block.sp_int = 1.0;
        pulses_with(&mut block, 32_767, |_, _| ());
        assert_eq!(block.di_cont_c.lmn, 0.0);
        block.call();
        assert_eq!(block.di_cont_c.lmn, 1.0);
    }

    // The numbers in the help of the variables and in the documentation.

    #[test]
    fn the_loop_of_the_quick_start_settles_with_little_overshoot() {
        // A lag of 100 s with 4 degC per percent behind a dead time of 10 s.
        let mut block = PulsCtr { sp_int: 200.0, ..PulsCtr::default() };
        block.di_cont_c.gain = 1.04;
        block.di_cont_c.ti = Time::ms(96_000);
        block.di_cont_c.pv_fac = 4.0;
        let mut block = restarted(block);
        let mut delayed = std::collections::VecDeque::from([0.0; 1000]);
        let (mut temperature, mut highest) = (0.0, 0.0);
        for call in 1..=60_000 {
            block.pv_per = Word::new((temperature * 276.48 / 4.0) as Int);
            block.call();
            delayed.push_back(if block.qpos_p { 400.0 } else { 0.0 });
            temperature += (delayed.pop_front().unwrap() - temperature) * (0.01 / 100.0);
            highest = f64::max(highest, temperature);
            assert!(call < 30_000 || (temperature - 200.0).abs() < 4.0, "{temperature} in call {call}");
        }
        assert!(highest < 204.0, "{highest}");
    }

    /// In how many of the 200 calls of the second period the output is on, with this manual value and the start values.
    fn calls_on(man: f32) -> usize {
        let mut block = PulsCtr::default();
        (block.di_cont_c.man_on, block.di_cont_c.man) = (true, man);
        let pulses = pulses_with(&mut restarted(block), 400, |_, _| ());
        assert_eq!(pulses[..200], ".".repeat(200), "the first pulse comes after RED_FAC calls");
        pulses[200..].matches('+').count()
    }

    #[test]
    fn help_of_qpos_p_30_percent_are_60_of_200_calls_and_less_than_2_5_percent_none() {
        assert_eq!(calls_on(30.0), 60);
        assert_eq!([calls_on(2.4), calls_on(2.5), calls_on(97.5), calls_on(97.6)], [0, 5, 195, 200]);
    }

    #[test]
    fn help_of_sp_int_and_pv_per_they_are_read_when_the_controller_runs_and_scaled_by_pv_fac() {
        let mut block = PulsCtr { sp_int: 210.0, pv_per: Word::new(13824), ..PulsCtr::default() };
        block.di_cont_c.pv_fac = 4.0;
        let mut block = restarted(block);
        pulses_with(&mut block, 199, |_, _| ());
        assert_eq!((block.di_cont_c.pv, block.di_cont_c.lmn_p), (0.0, 0.0));
        block.call();
        assert_eq!((block.di_cont_c.pv, block.di_cont_c.lmn_p), (200.0, 20.0));
        assert_eq!(block.di_cont_c.cycle, Time::ms(2_000));
    }

    #[test]
    fn help_of_cycle_twice_the_cycle_with_half_the_red_fac_leaves_the_controller_as_it_is() {
        let inside = |cycle, red_fac| {
            let mut block = PulsCtr { cycle: Time::ms(cycle), red_fac, sp_int: 10.0, ..PulsCtr::default() };
            block.di_cont_c.pvper_on = false;
            let mut block = restarted(block);
            pulses_with(&mut block, 3 * red_fac.cast_unsigned() as usize, |_, _| ());
            block.di_cont_c.lmn
        };
        assert_eq!(inside(10, 200), inside(20, 100));
        assert!(inside(10, 200) > 20.0);
    }
}
