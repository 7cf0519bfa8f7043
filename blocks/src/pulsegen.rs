//! PULSEGEN (FB 43): the pulse generator.

use std::cmp::Ordering;

use crate::block::{Law, Response};
use crate::types::{Real, Time, rnd};

crate::block! {
    /// Pulse duration modulation of a manipulated value for proportional actuators, in three or two steps (FB 43).
    ///
    /// ```text
    ///         +------------------------+      +-------------------+      +-----------------+
    /// INV --->| characteristic         |--w-->| pulse of K calls  |----->| manual mode     |----> QPOS_P
    ///         | STEP3_ON, ST2BI_ON     |      | in a period of R  |      | MAN_ON          |
    ///         | RATIOFAC, P_B_TM       |      | PER_TM, SYN_ON    |      | POS_P_ON        |----> QNEG_P
    ///         +------------------------+      +-------------------+      | NEG_P_ON        |
    ///                                                                    +-----------------+
    /// ```
    ///
    /// The law of a call, in this order; every operation rounds to a 32-bit REAL, times are in milliseconds, R is the
    /// number of calls left in the period, K of those left in the pulse:
    ///
    /// ```text
    /// R <= 0:                             a period starts:
    ///     R = RND(PER_TM / CYCLE), at least 0
    ///     w = |(((INV * k) * PER_TM) * 0.01) + b|          INV is read here and nowhere else
    ///     w > s * (PER_TM - P_B_TM):      w = s * PER_TM
    ///     else w < s * P_B_TM:            w = 0
    ///     K = RND(w / CYCLE)
    /// else SYN_ON, INV not that of the last call, R > 2:
    ///     R = 1                           this call is the last of the period
    /// three-step:  QPOS_P or QNEG_P = (K > 0), by the sign of INV
    /// two-step:    QPOS_P = (K > 0),  QNEG_P = not QPOS_P
    /// R = R - 1,  K = K - 1, at least 0
    ///
    /// mode                  INV             k                              b              s
    /// three-step            above 0         RATIOFAC > 1 ? 1/RATIOFAC : 1  0              k
    /// three-step            0 and below     RATIOFAC > 1 ? 1 : RATIOFAC    0              k
    /// two-step bipolar      below -100      0                              0              1
    /// two-step bipolar      -100 and above  0.5                            0.5 * PER_TM   1
    /// two-step monopolar    below 0         0                              0              1
    /// two-step monopolar    0 and above     1                              0              1
    /// ```
    ///
    /// 1. Restart (COM_RST): both outputs are FALSE, QNEG_P in two-step mode too; the next automatic call starts a period.
    ///    The block does not take COM_RST back: while it is TRUE every call is a restart. (manual)
    /// 2. A period is PER_TM / CYCLE calls long and starts with its pulse: 30 % in ten calls is three calls on, seven off.
    ///    What INV does later in the period waits for the next (manual). The numbers of calls are rounded with halves to
    ///    the even number: ten calls make 3, 4, 4, 4, 5 of 34, 35, 36, 45, 46 % (measured).
    /// 3. Three-step control (STEP3_ON): a positive INV pulses QPOS_P, a negative one QNEG_P, |INV| percent of PER_TM.
    ///    (manual)
    /// 4. A pulse that would be shorter than P_B_TM is left out; one that would leave a break shorter than P_B_TM fills
    ///    the period. (manual)
    /// 5. RATIOFAC below 1 shortens negative pulses to RATIOFAC times their length, above 1 positive ones to the
    ///    RATIOFAC-th part, and the shortest pulse of that sign with them (manual). The threshold of the full pulse, and
    ///    the full pulse itself, are scaled alike (decided). So with a RATIOFAC other than 1 a pulse may be shorter than
    ///    P_B_TM.
    /// 6. Two-step control, bipolar (ST2BI_ON): QPOS_P is on for (INV + 100) / 2 percent of PER_TM, clause 4 included;
    ///    QNEG_P is its opposite. (manual)
    /// 7. Two-step control, monopolar: QPOS_P is on for INV percent of PER_TM and not at all below 0, clause 4 included;
    ///    QNEG_P is its opposite. (manual)
    /// 8. Manual mode (MAN_ON), whatever INV is: with three steps POS_P_ON alone sets QPOS_P, NEG_P_ON alone QNEG_P, both
    ///    or neither set nothing; with two steps QPOS_P follows POS_P_ON and QNEG_P is its opposite (manual). The next
    ///    automatic call starts a period (decided).
    /// 9. Synchronization (SYN_ON): a change of INV cuts the period short, but not in its first call and its last two
    ///    (manual). The call that sees the change still belongs to the old pulse, the next starts the new period (decided).
    /// 10. Q_MEAN is ours, not the manual's: the mean of the pulses over the last communication step, +100 % for the
    ///     positive one throughout, -100 % for the negative one; in a step without a call the state that the outputs hold.
    ///     With two steps there is one actuator, on QPOS_P, and QNEG_P no pulse of its own: +100 % for QPOS_P throughout,
    ///     0 for none. A Real plant input and steps longer than CYCLE need it, for QPOS_P and QNEG_P only show the last
    ///     call. (decided)
    ///
    /// Sampling: call the block every CYCLE, and let INV change once a period. With SYN_ON and an INV that changes in
    /// every call a period lasts two calls, and 30 % of ten calls is on all the time. A pulse is a whole number of calls,
    /// so PER_TM / CYCLE is the resolution of INV: 20 calls tell 5 % apart, 100 calls 1 %.
    ///
    /// Bad input: the block checks no parameter. P_B_TM above half of PER_TM leaves only off and fully on, P_B_TM above
    /// PER_TM only fully on, whatever INV is. PER_TM below CYCLE / 2 makes every call a period without a length, in which
    /// K counts for one call. The counters have 32 bits and do not wrap.
    ///
    /// Decided: the full pulse and its threshold with RATIOFAC; which call starts the synchronized period; the start of a
    /// period after manual mode; Q_MEAN. The manual's text calls the outputs QPOS and QNEG in places, and says of POS_P_ON
    /// and NEG_P_ON in two-step mode what its mode table says: QNEG_P is the opposite of QPOS_P.
    ///
    /// Source: Standard Software for S7-300 and S7-400, PID Control, User Manual (C79000-G7076-C516), section 3.3,
    /// figures 3-3 to 3-9, tables 3-5 and 3-6. No recordings of pulses but those of clause 2.
    pub struct Pulsegen as "PULSEGEN" {
        input {
            /// Manipulated value to be turned into pulses
            inv: Real = 0.0, min -100.0, max 100.0, unit "%";
        }
        parameter {
            /// Period of the pulses; the time in which INV is renewed; range: PER_TM >= 20 CYCLE
            per_tm: Time = Time::ms(1000);
            /// Minimum length of a pulse and of a break; range: P_B_TM >= CYCLE
            p_b_tm: Time = Time::ms(50);
            /// Ratio of the length of negative to positive pulses
            ratiofac: Real = 1.0, min 0.1, max 10.0;
            /// Three-step control: positive and negative pulses; otherwise two-step control
            step3_on: Bool = true;
            /// Two-step control is bipolar, -100 ... 100 % (TRUE), or monopolar, 0 ... 100 % (FALSE)
            st2bi_on: Bool = false;
        }
        input {
            /// Manual mode: POS_P_ON and NEG_P_ON set the outputs
            man_on: Bool = false;
            /// Manual positive pulse
            pos_p_on: Bool = false;
            /// Manual negative pulse; without effect in two-step control
            neg_p_on: Bool = false;
            /// Synchronization: a change of INV starts a new period
            syn_on: Bool = true;
            /// Complete restart: TRUE runs the restart routine instead of the generator
            com_rst: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Positive pulse
            qpos_p: Bool;
            /// Negative pulse; in two-step control the opposite of QPOS_P
            qneg_p: Bool;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step, negative ones negative (not in the manual)
        q_mean;
    }
    memory Memory {
        /// INV of the last call.
        inv: Real;
        /// R: calls left in the period.
        period_left: i32;
        /// K: calls left in the pulse.
        pulse_left: i32;
        /// The pulse is a negative one.
        negative: bool;
        /// What the last call made: +1 a positive pulse, -1 a negative one, 0 none.
        pulse: i32;
    }
}

impl Law for Pulsegen {
    const RESPONSE: Response = Response {
        title: "Periods of 20 calls: 30 %, then 75 % and -50 %, which come in the midst of a period and start a new one, \
                then 4 %, too little for a pulse",
        calls: 160,
        set: &[
            (0, "PER_TM", 0.2),
            (0, "P_B_TM", 0.01),
            (0, "INV", 30.0),
            (50, "INV", 75.0),
            (95, "INV", -50.0),
            (136, "INV", 4.0),
        ],
        show: &["INV", "QPOS_P", "QNEG_P"],
    };

    fn restart(&mut self) {
        self.clear();
    }

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
        // With two steps QNEG_P is the opposite of QPOS_P, no pulse.
        self.memory.pulse = i32::from(self.qpos_p) - i32::from(self.step3_on && self.qneg_p);
    }

    fn pulse(&self) -> i32 {
        self.memory.pulse
    }
}

impl Pulsegen {
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

    fn automatic(&mut self) {
        if self.memory.period_left <= 0 {
            let cycle = self.cycle.real();
            let (width, negative) = self.width();
            self.memory.period_left = rnd(self.per_tm.real() / cycle).max(0);
            self.memory.pulse_left = rnd(width / cycle);
            self.memory.negative = negative;
        } else if self.syn_on && self.inv_has_changed() && self.memory.period_left > 2 {
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

    /// Whether INV lies above or below that of the last call. Any comparison with NaN is false, this one too.
    fn inv_has_changed(&self) -> bool {
        self.inv.partial_cmp(&self.memory.inv).is_some_and(Ordering::is_ne)
    }

    /// The width of the pulse in milliseconds, and whether it is a negative one.
    fn width(&self) -> (Real, bool) {
        let period = self.per_tm.real();
        let shortest = self.p_b_tm.real();
        let negative = self.step3_on && !(self.inv > 0.0);
        let (factor, offset, scale) = if negative {
            let factor = if self.ratiofac > 1.0 { 1.0 } else { self.ratiofac };
            (factor, 0.0, factor)
        } else if self.step3_on {
            let factor = if self.ratiofac > 1.0 { 1.0 / self.ratiofac } else { 1.0 };
            (factor, 0.0, factor)
        } else if self.st2bi_on {
            if self.inv < -100.0 { (0.0, 0.0, 1.0) } else { (0.5, 0.5 * period, 1.0) }
        } else if self.inv < 0.0 {
            (0.0, 0.0, 1.0)
        } else {
            (1.0, 0.0, 1.0)
        };
        let width = ((((self.inv * factor) * period) * 0.01) + offset).abs();
        let width = if width > scale * (period - shortest) {
            scale * period
        } else if width < scale * shortest {
            0.0
        } else {
            width
        };
        (width, negative)
    }
}
