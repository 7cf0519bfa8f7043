//! PULS_CTR: the manual's example of a controller with a pulse output.

use crate::block::{Law, Response};
use crate::types::{Bool, Int, Time};
use crate::{ContC, Pulsegen};

crate::block! {
    /// Continuous PID controller with a pulse output: CONT_C and PULSEGEN in one block, at two rates.
    ///
    /// ```text
    /// every RED_FAC calls                                   every call
    ///                    +-----------+                      +-------------+
    /// SP_INT ----------->| DI_CONT_C |---- LMN ----> INV ---| DI_PULSEGEN |----> QPOS_P
    /// PV_PER ----------->|           |                      |             |
    /// CYCLE * RED_FAC -->| CYCLE     |     CYCLE * RED_FAC->| PER_TM      |
    /// COM_RST ---------->|           |           COM_RST -->|             |
    ///                    +-----------+             CYCLE -->| CYCLE       |
    ///                                                       +-------------+
    /// ```
    ///
    /// The law of a call, in this order, is that of the example's statement list; sCount is the block's only memory:
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
    /// 1. Restart (COM_RST): both blocks inside run their restart, and sCount becomes RED_FAC. After it CONT_C first runs
    ///    in call RED_FAC, and then every RED_FAC calls. While COM_RST is TRUE every call is a restart. (manual)
    /// 2. CONT_C computes with CYCLE * RED_FAC, which is also the period of the pulses; PULSEGEN runs in every call, with
    ///    CYCLE. (manual)
    /// 3. LMN goes to INV in every call. CONT_C runs in the last call of a period, which is no time to synchronize, so its
    ///    LMN is the pulse of the period that starts one call later. (follows from the manual's program)
    /// 4. PV_PER is the process value and the controller runs automatically: DI_CONT_C.PVPER_ON starts TRUE and
    ///    DI_CONT_C.MAN_ON FALSE. CONT_C's own defaults are the opposite; nothing in the example sets them, and it would
    ///    give the manual value 0 for ever. (decided)
    /// 5. What the example leaves open of both blocks inside is a parameter of this block: `DI_CONT_C.GAIN`,
    ///    `DI_CONT_C.MAN`, `DI_PULSEGEN.P_B_TM` and so on. What it connects, and all results, can be read:
    ///    `DI_CONT_C.LMN`, `DI_PULSEGEN.QNEG_P`. (decided)
    /// 6. Q_MEAN is ours, not the manual's: that of the PULSEGEN inside, the mean of its pulses over the last communication
    ///    step, +100 % for the positive one throughout, -100 % for the negative one. (decided)
    ///
    /// Sampling: call the block every CYCLE. A pulse is a whole number of calls, so RED_FAC is the resolution of LMN: 200
    /// calls tell 0.5 % apart. With three steps a negative LMN needs `DI_CONT_C.LMN_LLM` below 0, and the actuator
    /// `DI_PULSEGEN.QNEG_P`.
    ///
    /// Bad input: RED_FAC below 1 and CYCLE * RED_FAC beyond the longest TIME, 2147483.647 s, are refused before the
    /// restart (decided). Nothing else is checked. What the program does without that check is the statement list's: sCount
    /// is an INT that wraps, RED_FAC is loaded without its sign, and the product keeps its low 32 bits.
    ///
    /// Decided: RED_FAC starts at 200 and CYCLE at 10 ms, the manual's 2 s and 10 ms; clauses 4 to 6.
    ///
    /// Source: Standard Software for S7-300 and S7-400, PID Control, User Manual (C79000-G7076-C516), section 3.4,
    /// figures 3-10 and 3-11, tables 3-7 and 3-8. The laws of the blocks inside: `CONT_C` and `PULSEGEN`.
    pub struct PulsCtr as "PULS_CTR" {
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            sp_int: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            pv_per: Word = Word::new(0);
        }
        fixed {
            /// Calls from one call of the controller to the next
            red_fac: Int = 200, min 1;
        }
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            com_rst: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Positive pulse
            qpos_p: Bool;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step, negative ones negative (not in the manual)
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
    const RESPONSE: Response = Response {
        title: "The setpoint rises to 10: the controller answers every 20 calls, and each period's pulse is as long as LMN \
                says",
        calls: 160,
        set: &[
            (0, "RED_FAC", 20.0),
            (0, "DI_PULSEGEN.P_B_TM", 0.01),
            (0, "DI_CONT_C.TI", 0.5),
            (10, "SP_INT", 10.0),
        ],
        show: &["SP_INT", "DI_CONT_C.LMN", "QPOS_P"],
    };

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
