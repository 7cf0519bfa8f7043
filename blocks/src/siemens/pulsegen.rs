//! PULSEGEN (FB 43): the pulse generator.

use std::cmp::Ordering;

use crate::siemens::advice;
use crate::table::{Characteristic, Law, Real, Response, rnd};

crate::block! {
    /// Pulse duration modulation of a manipulated value for proportional actuators, in three or two steps (FB 43).
    ///
    /// # Purpose
    ///
    /// The block switches an actuator on and off so that its mean is a manipulated value: a heater by a relay, heating
    /// and cooling by two valves. It stands behind a continuous controller such as CONT_C. It does no control of its
    /// own and knows nothing of the actuator but its shortest switching time.
    ///
    /// # Quick start
    ///
    /// 1. STEP3_ON and ST2BI_ON: two actuators (three-step), or one for -100 ... 100 % (bipolar) or 0 ... 100 %
    ///    (monopolar).
    /// 2. PER_TM: a tenth of the plant's time constant or less; 1 s for solid state relays, 10 s and more for
    ///    contactors.
    /// 3. CYCLE: PER_TM / 100 for a resolution of 1 %, PER_TM / 20 at most.
    /// 4. P_B_TM: the shortest time for which the actuator may be switched.
    /// 5. INV from LMN of the controller; QPOS_P and QNEG_P, or Q_MEAN, to the plant. Call the controller once a
    ///    period, or set SYN_ON = FALSE.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon pulses
    /// input INV 0,8
    /// box WIDTH 15,8 characteristic with STEP3_ON ST2BI_ON RATIOFAC P_B_TM
    /// box PERIOD 36,8 pulses with PER_TM SYN_ON
    /// switch MAN_ON 55,7 TRUE lower
    /// switch NEG 55,17 TRUE lower by MAN_ON
    /// box MANUAL 36,24 "outputs set" "by hand" with POS_P_ON NEG_P_ON
    /// output QPOS_P 66,7
    /// output QNEG_P 66,17
    /// box MEAN 68,27 mean
    /// output Q_MEAN 73,27
    /// INV > WIDTH > PERIOD
    /// text 24,7.2 "width"
    /// PERIOD.right-1 > x44 > MAN_ON.FALSE
    /// PERIOD.right+1 > x44 > NEG.FALSE
    /// MANUAL.right-1 > x46 > MAN_ON.TRUE
    /// MANUAL.right+1 > x48 > NEG.TRUE
    /// MAN_ON > QPOS_P
    /// NEG > QNEG_P
    /// 62,7 > y26.5 > MEAN.left-0.5
    /// 60,17 > y27.5 > MEAN.left+0.5
    /// MEAN > Q_MEAN
    /// box RESTART 9,25 "outputs = FALSE," "new period" with COM_RST
    /// box CALL 22,25 "every CYCLE" with CYCLE
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// manipulated value: INV
    /// pulses: QPOS_P, QNEG_P
    /// pulse former: PER_TM, P_B_TM, RATIOFAC
    ///
    /// [Manipulated value]
    /// INV
    /// [Structure]
    /// STEP3_ON
    /// ST2BI_ON if not STEP3_ON
    /// [Pulse former]
    /// PER_TM, P_B_TM
    /// RATIOFAC if STEP3_ON
    /// SYN_ON
    /// [Manual]
    /// MAN_ON
    /// POS_P_ON if MAN_ON
    /// NEG_P_ON if MAN_ON and STEP3_ON
    /// [Sampling]
    /// CYCLE, COM_RST
    /// ```
    ///
    /// # Law
    ///
    /// The share of a period that the pulse is on, in three-step control, bipolar and monopolar two-step control:
    ///
    /// ```math
    /// \frac{|\text{INV}|}{100\,\%}, \qquad \frac{\text{INV} + 100\,\%}{200\,\%}, \qquad \frac{\text{INV}}{100\,\%}
    /// ```
    ///
    /// Pulses and breaks that would be shorter than the minimum time are left out:
    ///
    /// ```math
    /// w = \begin{cases} 0 & w < \text{P_B_TM} \\ \text{PER_TM} & w > \text{PER_TM} - \text{P_B_TM} \end{cases}
    /// ```
    ///
    /// The law of a call, in this order; every operation rounds to a 32-bit REAL, times are in milliseconds, R is the
    /// number of calls left in the period, K of those left in the pulse:
    ///
    /// ```text
    /// R <= 0:                             a period starts:
    ///     R = RND(PER_TM / CYCLE), at least 0
    ///     w = |(((INV * k) * PER_TM) * 0.01) + b|          INV takes effect only here
    ///     w > s * (PER_TM - P_B_TM):      w = s * PER_TM
    ///     else w < s * P_B_TM:            w = 0
    ///     K = RND(w / CYCLE)
    /// else SYN_ON, INV changed since the previous call, R > 2:
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
    /// # Clauses
    ///
    /// 1. Restart (COM_RST): both outputs are FALSE, QNEG_P in two-step mode too; the next automatic call starts a
    ///    period. The block does not reset COM_RST: while it is TRUE, every call is a restart. (manual)
    /// 2. A period is PER_TM / CYCLE calls long and starts with its pulse: 30 % in ten calls is three calls on, seven
    ///    off. A later change of INV takes effect in the next period (manual). Numbers of calls are rounded, halves to
    ///    even: in a period of ten calls, 34, 35, 36, 45, 46 % give 3, 4, 4, 4, 5 calls (measured).
    /// 3. Three-step control (STEP3_ON): a positive INV pulses QPOS_P, a negative one QNEG_P, |INV| percent of PER_TM.
    ///    (manual)
    /// 4. A pulse shorter than P_B_TM is suppressed; a pulse that would leave a break shorter than P_B_TM fills the
    ///    period. (manual)
    /// 5. RATIOFAC below 1 multiplies the length of negative pulses by RATIOFAC; above 1 it divides that of positive
    ///    pulses by RATIOFAC. The shortest pulse of that sign scales with them (manual), and so do the threshold of the
    ///    full pulse and the full pulse itself (decided). So with a RATIOFAC other than 1 a pulse may be shorter than
    ///    P_B_TM.
    /// 6. Two-step control, bipolar (ST2BI_ON): QPOS_P is on for (INV + 100) / 2 percent of PER_TM; clause 4 applies.
    ///    QNEG_P is its opposite. (manual)
    /// 7. Two-step control, monopolar: QPOS_P is on for INV percent of PER_TM, and off if INV is below 0; clause 4
    ///    applies. QNEG_P is its opposite. (manual)
    /// 8. Manual mode (MAN_ON), whatever INV is: in three-step control POS_P_ON alone sets QPOS_P, NEG_P_ON alone sets
    ///    QNEG_P, both or neither set nothing; in two-step control QPOS_P follows POS_P_ON and QNEG_P is its opposite
    ///    (manual). The next automatic call starts a period (decided).
    /// 9. Synchronization (SYN_ON): a change of INV ends the period early, except in its first call and its last two
    ///    (manual). The call that sees the change still belongs to the old pulse, the next starts the new period
    ///    (decided).
    /// 10. Q_MEAN is ours, not the manual's: the mean of the pulses over the last communication step, +100 % if
    ///     positive all the time, -100 % if negative all the time; in a step without a call, the state of the outputs.
    ///     In two-step control there is one actuator, on QPOS_P, and QNEG_P is no pulse: +100 % if QPOS_P is on all the
    ///     time, 0 if it is off. A Real plant input and steps longer than CYCLE need Q_MEAN, because QPOS_P and QNEG_P
    ///     show only the last call. (decided)
    ///
    /// # Sampling
    ///
    /// Call the block every CYCLE, and change INV once a period. With SYN_ON and an INV that changes in every call, a
    /// period lasts two calls, and 30 % of ten calls is on all the time. A pulse is a whole number of calls, so PER_TM
    /// / CYCLE is the resolution of INV: 20 calls resolve 5 %, 100 calls 1 %.
    ///
    /// A communication step of ten times CYCLE makes ten calls with the inputs of its start, and INV is that of the
    /// start for all of them; the outputs show the last call only, Q_MEAN the mean of the ten. A step of CYCLE / 10
    /// makes a call in one step of ten and none in the others.
    ///
    /// # Limits of use
    ///
    /// The block checks no parameter. With P_B_TM above half of PER_TM the output is only off or fully on, with P_B_TM
    /// above PER_TM always fully on, whatever INV is (in three-step control the negative pulse for INV = 0). PER_TM up
    /// to CYCLE / 2 is rounded to no call at all and makes no pulse. The counters have 32 bits and do not wrap.
    ///
    /// # Sources
    ///
    /// Decided: the full pulse and its threshold with RATIOFAC; which call starts the synchronized period; the start of
    /// a period after manual mode; Q_MEAN. The manual's text calls the outputs QPOS and QNEG in places; for POS_P_ON
    /// and NEG_P_ON in two-step mode it agrees with its mode table: QNEG_P is the opposite of QPOS_P.
    ///
    /// Standard Software for S7-300 and S7-400, PID Control, User Manual (C79000-G7076-C516), section 3.3,
    /// figures 3-3 to 3-9, tables 3-5 and 3-6. Only the rounding of clause 2 is recorded.
    pub struct Pulsegen as "PULSEGEN" | "FB 43" | "SFB 43" {
        input {
            /// Manipulated value in percent, to be turned into pulses
            ///
            /// Connect LMN of CONT_C here. It is read at the start of a period, or at any call with SYN_ON, and held to
            /// the end of the period. In three-step control its sign chooses the output: 30 with PER_TM = 1 s is a
            /// positive pulse of 0.3 s. Bipolar two-step control maps -100 ... 100 to 0 ... 100 % on time, monopolar 0
            /// ... 100 to the same. Values beyond the range give a full pulse in their direction; in two-step control
            /// below it none. Limit LMN of the controller to the range that the actuator has.
            inv: Real = 0.0, min -100.0, max 100.0;
        }
        parameter {
            /// Period of the pulses, in which INV is updated once; range: PER_TM >= 20 CYCLE
            ///
            /// The mean of the pulses over a period is INV, so the plant must not follow single pulses: choose PER_TM
            /// well below its dominant time constant, a tenth or less, and long enough for the wear of the relay. 1 s
            /// is for solid state relays, 10 ... 60 s for contactors and heating valves. PER_TM / CYCLE is the
            /// resolution: the start values, 1 s and 10 ms, give 100 calls and 1 %; below 20 calls it is coarser than 5
            /// %. It acts on the loop as a dead time of about PER_TM / 2. It is rounded to whole calls and takes effect
            /// with the next period.
            per_tm: Time = Time::ms(1000);
            /// Minimum length of a pulse and of a break; range: P_B_TM >= CYCLE
            ///
            /// Pulses shorter than this are left out, and breaks shorter than this are filled, so that the actuator is
            /// never switched for less time than it takes. With PER_TM = 1 s and 0.05 s, INV below 5 % gives nothing
            /// and above 95 % a full pulse: the characteristic jumps there. Take the shortest sensible on time of the
            /// relay or valve. Above PER_TM / 2 there is only off and fully on, above PER_TM only fully on.
            p_b_tm: Time = Time::ms(50);
            /// Ratio of the length of negative to positive pulses
            ///
            /// Makes up for a process that reacts differently to cooling and heating, in three-step control only. If
            /// cooling is twice as strong as heating, set 0.5: negative pulses are half as long, INV = -50 gives 25 %.
            /// Above 1 the positive pulses are divided by it: with 2, INV = 50 gives 25 %. The minimum time scales with
            /// the pulses of that sign, so that they may be shorter than P_B_TM. 1 is symmetrical.
            ratiofac: Real = 1.0, min 0.1, max 10.0;
            /// Three-step control: positive and negative pulses; otherwise two-step control
            ///
            /// TRUE: QPOS_P and QNEG_P drive two actuators, such as heating and cooling, or open and close. FALSE:
            /// QPOS_P drives one actuator and QNEG_P is its opposite; ST2BI_ON then says which range INV has. A change
            /// takes effect with the next period, for the pulse width, and at once for the outputs.
            step3_on: Bool = true;
            /// Two-step control is bipolar, -100 ... 100 % (TRUE), or monopolar, 0 ... 100 % (FALSE)
            ///
            /// Only with STEP3_ON = FALSE. TRUE: INV = -100 is off, 0 is half on, 100 is on; for a controller whose
            /// output goes from -100 to 100. FALSE: 0 is off, 100 is on, and below 0 it stays off; for a controller
            /// with LMN_LLM = 0. Choosing the wrong one halves or doubles the gain of the loop.
            st2bi_on: Bool = false;
        }
        input {
            /// Manual mode: POS_P_ON and NEG_P_ON set the outputs
            ///
            /// While it is TRUE, POS_P_ON and NEG_P_ON switch the outputs in the same call, without period and without
            /// minimum time. When it becomes FALSE, the next call starts a new period with the INV of that call.
            man_on: Bool = false;
            /// Manual positive pulse
            ///
            /// Acts with MAN_ON = TRUE. In three-step control it sets QPOS_P unless NEG_P_ON is TRUE as well; in
            /// two-step control QPOS_P follows it, and QNEG_P is the opposite. P_B_TM is not observed: a short command
            /// makes a short pulse.
            pos_p_on: Bool = false;
            /// Manual negative pulse; no effect in two-step control
            ///
            /// Acts with MAN_ON = TRUE in three-step control: it sets QNEG_P unless POS_P_ON is TRUE as well. In
            /// two-step control it has no effect, because QNEG_P is the opposite of QPOS_P.
            neg_p_on: Bool = false;
            /// Synchronization: a change of INV starts a new period
            ///
            /// TRUE: a new INV ends the running period and starts a new one with the next call, except in the first
            /// call and in the last two of a period. It saves the wait of up to a PER_TM and fits a controller that
            /// computes INV once a period. With an INV that changes in every call it defeats the modulation: a period
            /// then lasts two calls, and 30 % of ten calls is on all the time. Set FALSE there, or call the controller
            /// once a period as PULS_CTR does.
            syn_on: Bool = true;
            /// Complete restart: TRUE runs the restart routine instead of the generator
            ///
            /// While it is TRUE, every call is a restart: both outputs are FALSE, QNEG_P in two-step control too. The
            /// first call after it starts a period. The block does not reset it; at the start of a simulation the FMU
            /// restarts the block itself.
            com_rst: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// The time base of the pulses: the FMU calls the block that often, whatever the communication step is.
            /// Pulses and periods are whole numbers of calls. Choose PER_TM / 100 for a resolution of 1 %, as the start
            /// values have it, and call the controller before it less often: its CYCLE may be PER_TM.
            cycle: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Positive pulse
            ///
            /// TRUE while the actuator for positive values is on. It shows the last call of the communication step:
            /// with a step of PER_TM it always shows the same call of the period. Use Q_MEAN for longer steps and for a
            /// plant with a Real input.
            qpos_p: Bool;
            /// Negative pulse; in two-step control the opposite of QPOS_P
            ///
            /// In three-step control TRUE while the actuator for negative values is on. In two-step control it is TRUE
            /// whenever QPOS_P is FALSE, but not after a restart, when both are FALSE. Do not connect it to a second
            /// actuator there.
            qneg_p: Bool;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step in percent, negative ones negative (not in the manual)
        ///
        /// Connects the pulses to a plant with a Real input. With a communication step of one period it is INV itself,
        /// rounded to whole calls: 34 in a period of ten calls gives 30. In steps of one CYCLE it is 100, 0 or -100. In
        /// two-step control it counts QPOS_P only, 0 ... 100.
        q_mean;
    }
    memory Memory {
        /// INV of the previous call.
        inv: Real;
        /// R: calls left in the period.
        period_left: i32;
        /// K: calls left in the pulse.
        pulse_left: i32;
        /// The pulse is negative.
        negative: bool;
        /// What the last call made: +1 a positive pulse, -1 a negative one, 0 none.
        pulse: i32;
    }
}

/// The share of a period of 100 calls in which the outputs are TRUE, in steps of 1 %.
const SHARE_OVER_INV: Characteristic = Characteristic {
    title: "",
    variable: "INV",
    range: (-100.0, 100.0),
    points: 201,
    calls: 100,
    set: &[],
    show: &["QPOS_P", "QNEG_P"],
};

impl Law for Pulsegen {
    const RESPONSES: &'static [Response] = &[
        Response {
            title: "Periods of 20 calls: 30 %, then 75 % and -50 %, which come in the middle of a period and start a new one, \
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
        },
        Response {
            title: "Two-step control, bipolar: 0 % is on for half of the period, -60 % for a fifth, 100 % throughout; QNEG_P is the \
                opposite",
            calls: 120,
            set: &[
                (0, "STEP3_ON", 0.0),
                (0, "ST2BI_ON", 1.0),
                (0, "PER_TM", 0.2),
                (0, "P_B_TM", 0.01),
                (40, "INV", -60.0),
                (80, "INV", 100.0),
            ],
            show: &["INV", "QPOS_P", "QNEG_P"],
        },
        Response {
            title: "RATIOFAC = 0.5: 50 % is 10 calls of 20 on QPOS_P, -50 % only 5 on QNEG_P",
            calls: 80,
            set: &[(0, "RATIOFAC", 0.5), (0, "PER_TM", 0.2), (0, "P_B_TM", 0.01), (0, "INV", 50.0), (40, "INV", -50.0)],
            show: &["INV", "QPOS_P", "QNEG_P"],
        },
        Response {
            title: "P_B_TM = 40 ms, 4 calls: 15 % of 20 calls would be 3 and is left out, 25 % is 5, 85 % would leave a break of 3 \
                and is on throughout",
            calls: 120,
            set: &[(0, "PER_TM", 0.2), (0, "P_B_TM", 0.04), (0, "INV", 15.0), (40, "INV", 25.0), (80, "INV", 85.0)],
            show: &["INV", "QPOS_P", "QNEG_P"],
        },
        Response {
            title: "MAN_ON: the outputs follow POS_P_ON and NEG_P_ON call by call; afterwards a period starts with INV = 30 %",
            calls: 80,
            set: &[
                (0, "PER_TM", 0.2),
                (0, "P_B_TM", 0.01),
                (0, "INV", 30.0),
                (10, "MAN_ON", 1.0),
                (15, "POS_P_ON", 1.0),
                (17, "POS_P_ON", 0.0),
                (25, "NEG_P_ON", 1.0),
                (30, "POS_P_ON", 1.0),
                (35, "POS_P_ON", 0.0),
                (40, "NEG_P_ON", 0.0),
                (45, "MAN_ON", 0.0),
            ],
            show: &["MAN_ON", "POS_P_ON", "NEG_P_ON", "QPOS_P", "QNEG_P"],
        },
    ];

    const CHARACTERISTICS: &'static [Characteristic] = &[
        Characteristic {
            title: "Three-step control: below P_B_TM, 5 % of the period, there is no pulse, above 95 % no break",
            set: &[],
            ..SHARE_OVER_INV
        },
        Characteristic {
            title: "Three-step control, RATIOFAC = 0.5: negative pulses, and their shortest and longest one, are half as long",
            set: &[("RATIOFAC", 0.5)],
            ..SHARE_OVER_INV
        },
        Characteristic {
            title: "Two-step control, bipolar: half of the period at 0 %; QNEG_P is the opposite",
            set: &[("STEP3_ON", 0.0), ("ST2BI_ON", 1.0)],
            ..SHARE_OVER_INV
        },
        Characteristic {
            title: "Two-step control, monopolar: off below 0 %; QNEG_P is the opposite",
            set: &[("STEP3_ON", 0.0)],
            ..SHARE_OVER_INV
        },
    ];

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
        // In two-step control QNEG_P is the opposite of QPOS_P and no pulse.
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
        let positive = self.inv > 0.0;
        let (factor, offset, scale) = if self.step3_on {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Block, Real, Time};

    /// Ten calls a period, no minimum time, three-step.
    fn ten_calls() -> Pulsegen {
        Pulsegen { per_tm: Time::ms(100), p_b_tm: Time::ms(0), cycle: Time::ms(10), ..Pulsegen::default() }
    }

    fn restarted(mut block: Pulsegen) -> Pulsegen {
        block.restart();
        block
    }

    /// The outputs of the last call as a letter.
    fn letter(block: &Pulsegen) -> char {
        match (block.qpos_p, block.qneg_p) {
            (true, true) => '!',
            (true, false) => '+',
            (false, true) => '-',
            (false, false) => '.',
        }
    }

    /// One letter a call; `before` is shown the number of each call, from 0 on, and may set inputs.
    fn pulses_with(block: &mut Pulsegen, calls: usize, before: impl Fn(usize, &mut Pulsegen)) -> String {
        let call = |number| {
            before(number, block);
            block.call();
            letter(block)
        };
        (0..calls).map(call).collect()
    }

    fn pulses(block: &mut Pulsegen, calls: usize) -> String {
        pulses_with(block, calls, |_, _| ())
    }

    /// A period of ten calls of 100 ms with a minimum time of two, after a restart.
    fn period(inv: Real, block: Pulsegen) -> String {
        let times = (Time::ms(1_000), Time::ms(200), Time::ms(100));
        let (per_tm, p_b_tm, cycle) = times;
        pulses(&mut restarted(Pulsegen { inv, per_tm, p_b_tm, cycle, ..block }), 10)
    }

    /// In how many of its ten calls a period has QPOS_P on, and in how many QNEG_P.
    fn share(inv: Real, block: Pulsegen) -> (usize, usize) {
        let period = period(inv, block);
        (period.matches('+').count(), period.matches('-').count())
    }

    fn three_step(ratiofac: Real) -> Pulsegen {
        Pulsegen { ratiofac, ..Pulsegen::default() }
    }

    fn two_step(st2bi_on: bool) -> Pulsegen {
        Pulsegen { step3_on: false, st2bi_on, ..Pulsegen::default() }
    }

    #[test]
    fn clause_1_a_restart_makes_both_outputs_false_in_two_step_mode_too() {
        for block in [two_step(false), two_step(true), three_step(1.0)] {
            let mut block = restarted(Pulsegen { inv: 50.0, ..block });
            assert_eq!(letter(&block), '.');
            block.call();
            assert_eq!(letter(&block), '+');
            block.com_rst = true;
            assert_eq!(pulses(&mut block, 2), "..");
            assert!(block.com_rst);
        }
    }

    #[test]
    fn clause_1_the_call_after_a_restart_starts_a_period() {
        let mut block = restarted(Pulsegen { inv: 30.0, ..ten_calls() });
        assert_eq!(pulses(&mut block, 5), "+++..");
        block.com_rst = true;
        assert_eq!(pulses(&mut block, 1), ".");
        block.com_rst = false;
        assert_eq!(pulses(&mut block, 10), "+++.......");
    }

    #[test]
    fn clause_2_30_percent_of_ten_calls_is_three_calls_on_and_seven_off() {
        assert_eq!(pulses(&mut restarted(Pulsegen { inv: 30.0, ..ten_calls() }), 20), "+++.......+++.......");
    }

    #[test]
    fn clause_2_inv_is_read_in_the_first_call_of_a_period() {
        let mut block = restarted(Pulsegen { syn_on: false, ..ten_calls() });
        let run = pulses_with(&mut block, 20, |number, block| block.inv = if number == 10 { 60.0 } else { 20.0 });
        assert_eq!(run, "++........++++++....");
    }

    #[test]
    fn clause_2_halves_of_a_call_are_rounded_to_the_even_number() {
        let calls = [34.0, 35.0, 36.0, 45.0, 46.0]
            .map(|inv| pulses(&mut restarted(Pulsegen { inv, ..ten_calls() }), 10).matches('+').count());
        assert_eq!(calls, [3, 4, 4, 4, 5]);
    }

    #[test]
    fn clause_2_the_calls_of_a_period_are_rounded_too() {
        // 2.5 calls are 2, 3.5 calls are 4.
        let run = |per_tm| {
            let block = Pulsegen { inv: 30.0, per_tm: Time::ms(per_tm), ..ten_calls() };
            pulses(&mut restarted(block), 12)
        };
        assert_eq!((run(25).as_str(), run(35).as_str()), ("+.+.+.+.+.+.", "+...+...+..."));
    }

    #[test]
    fn clause_3_a_negative_inv_pulses_the_negative_output() {
        assert_eq!(pulses(&mut restarted(Pulsegen { inv: -30.0, ..ten_calls() }), 20), "---.......---.......");
    }

    #[test]
    fn clause_3_three_step_control_does_not_ask_for_st2bi_on() {
        assert_eq!(period(-50.0, Pulsegen { st2bi_on: true, ..three_step(1.0) }), "-----.....");
    }

    #[test]
    fn clause_3_an_inv_beyond_100_percent_is_the_full_pulse() {
        assert_eq!((share(150.0, three_step(1.0)), share(-150.0, three_step(1.0))), ((10, 0), (0, 10)));
    }

    #[test]
    fn clause_4_short_pulses_are_left_out_and_short_breaks_filled() {
        let calls = [19.99, 20.0, 25.0, 75.0, 80.0, 80.01].map(|inv| share(inv, three_step(1.0)));
        assert_eq!(calls, [(0, 0), (2, 0), (2, 0), (8, 0), (8, 0), (10, 0)]);
        let calls = [-19.99, -20.0, -25.0, -75.0, -80.0, -80.01].map(|inv| share(inv, three_step(1.0)));
        assert_eq!(calls, [(0, 0), (0, 2), (0, 2), (0, 8), (0, 8), (0, 10)]);
    }

    #[test]
    fn clause_5_a_ratio_factor_below_1_shortens_negative_pulses() {
        let calls = [-19.0, -20.0, -80.0, -80.01, -100.0, 50.0].map(|inv| share(inv, three_step(0.5)));
        assert_eq!(calls, [(0, 0), (0, 1), (0, 4), (0, 5), (0, 5), (5, 0)]);
    }

    #[test]
    fn clause_5_a_ratio_factor_above_1_shortens_positive_pulses() {
        let calls = [19.0, 20.0, 80.0, 81.0, 100.0, -50.0].map(|inv| share(inv, three_step(2.0)));
        assert_eq!(calls, [(0, 0), (1, 0), (4, 0), (5, 0), (5, 0), (0, 5)]);
    }

    #[test]
    fn clause_5_the_ratio_factor_counts_in_three_step_control_only() {
        for ratiofac in [0.5, 2.0] {
            assert_eq!(share(60.0, Pulsegen { ratiofac, ..two_step(true) }), (8, 2));
            assert_eq!(share(60.0, Pulsegen { ratiofac, ..two_step(false) }), (6, 4));
        }
    }

    #[test]
    fn clause_6_bipolar_control_is_half_on_at_0_percent() {
        let calls = [-101.0, -100.0, -60.01, -60.0, 0.0, 60.0, 60.01, 100.0].map(|inv| share(inv, two_step(true)).0);
        assert_eq!(calls, [0, 0, 0, 2, 5, 8, 10, 10]);
    }

    #[test]
    fn clause_6_below_minus_100_percent_bipolar_control_stays_off() {
        // Without the case of its own, |INV + 100| / 2 would be on again for two calls here.
        assert_eq!(share(-150.0, two_step(true)).0, 0);
    }

    #[test]
    fn clause_6_exactly_minus_100_percent_is_computed_like_every_value_above_it() {
        // In a period this long rounding leaves 4 ms of |-50 % + 50 %|, four calls.
        let (per_tm, p_b_tm, cycle) = (Time::ms(123_456_789), Time::ms(0), Time::ms(1));
        let mut block = restarted(Pulsegen { inv: -100.0, per_tm, p_b_tm, cycle, ..two_step(true) });
        assert_eq!(pulses(&mut block, 6), "++++--");
    }

    #[test]
    fn clause_7_monopolar_control_is_off_below_0_percent() {
        let calls = [-50.0, 0.0, 10.0, 20.0, 80.0, 81.0].map(|inv| share(inv, two_step(false)).0);
        assert_eq!(calls, [0, 0, 0, 2, 8, 10]);
    }

    #[test]
    fn clause_6_and_7_with_two_steps_the_negative_output_is_the_opposite_of_the_positive_one() {
        assert_eq!(period(50.0, two_step(false)), "+++++-----");
        assert_eq!(period(0.0, two_step(true)), "+++++-----");
        assert_eq!(period(-100.0, two_step(true)), "----------");
    }

    #[test]
    fn clause_8_the_manual_signals_set_the_outputs_as_the_table_says() {
        let manual = |step3_on, pos_p_on, neg_p_on| {
            let block = Pulsegen { man_on: true, step3_on, pos_p_on, neg_p_on, inv: 70.0, ..ten_calls() };
            pulses(&mut restarted(block), 1)
        };
        let table = [(false, false), (true, false), (false, true), (true, true)];
        assert_eq!(table.map(|(pos, neg)| manual(true, pos, neg)), [".", "+", "-", "."]);
        assert_eq!(table.map(|(pos, neg)| manual(false, pos, neg)), ["-", "+", "-", "+"]);
    }

    #[test]
    fn clause_8_after_manual_mode_a_period_starts() {
        let mut block = restarted(Pulsegen { inv: 30.0, ..ten_calls() });
        let run = pulses_with(&mut block, 17, |number, block| block.man_on = (5..7).contains(&number));
        assert_eq!(run, "+++....+++.......");
    }

    /// Twenty calls with INV 30 %, and 80 % from call `change` on.
    fn synchronized(change: usize, syn_on: bool) -> String {
        let mut block = restarted(Pulsegen { syn_on, ..ten_calls() });
        pulses_with(&mut block, 20, |number, block| block.inv = if number < change { 30.0 } else { 80.0 })
    }

    #[test]
    fn clause_9_a_change_of_inv_starts_a_period_in_the_next_call() {
        assert_eq!(synchronized(1, true), "++++++++++..++++++++");
        assert_eq!(synchronized(2, true), "+++++++++++..+++++++");
        assert_eq!(synchronized(4, true), "+++..++++++++..+++++");
        assert_eq!(synchronized(7, true), "+++.....++++++++..++");
    }

    #[test]
    fn clause_9_in_the_last_two_calls_of_a_period_a_change_waits() {
        assert_eq!(synchronized(8, true), "+++.......++++++++..");
        assert_eq!(synchronized(9, true), "+++.......++++++++..");
    }

    #[test]
    fn clause_9_a_change_in_the_first_call_of_a_period_is_the_new_period() {
        assert_eq!(synchronized(0, true), "++++++++..++++++++..");
        assert_eq!(synchronized(10, true), "+++.......++++++++..");
    }

    #[test]
    fn clause_9_without_syn_on_every_change_waits_for_the_period() {
        for change in 1..=10 {
            assert_eq!(synchronized(change, false), "+++.......++++++++..", "change in call {change}");
        }
    }

    #[test]
    fn clause_9_an_inv_that_changes_in_every_call_makes_periods_of_two_calls() {
        let mut block = restarted(ten_calls());
        let run = pulses_with(&mut block, 20, |number, block| block.inv = 30.0 + number as Real * 0.01);
        assert_eq!(run, "+".repeat(20));
    }

    #[test]
    fn clause_9_a_change_during_manual_mode_is_no_change_afterwards() {
        let mut block = restarted(Pulsegen { inv: 30.0, ..ten_calls() });
        let run = pulses_with(&mut block, 13, |number, block| {
            block.man_on = number < 2;
            block.inv = if number == 0 { 30.0 } else { 50.0 };
        });
        assert_eq!(run, "..+++++.....+");
    }

    #[test]
    fn clause_9_an_inv_that_is_nan_is_no_change() {
        let mut block = restarted(ten_calls());
        let run = pulses_with(&mut block, 12, |number, block| block.inv = if number == 3 { Real::NAN } else { 60.0 });
        assert_eq!(run, "++++++....++");
    }

    #[test]
    fn an_inv_that_is_nan_makes_no_pulse() {
        assert_eq!(share(Real::NAN, three_step(1.0)), (0, 0));
        assert_eq!(share(Real::NAN, two_step(true)).0, 0);
    }

    #[test]
    fn clause_10_with_three_steps_the_mean_counts_the_negative_pulse_negative() {
        let mut block = restarted(Pulsegen { inv: -30.0, ..ten_calls() });
        block.call();
        assert_eq!(block.pulse(), -1);
        pulses(&mut block, 5);
        assert_eq!(block.pulse(), 0);
        let mut block = restarted(Pulsegen { inv: 30.0, ..ten_calls() });
        block.call();
        assert_eq!(block.pulse(), 1);
        let mean = Pulsegen::TABLE.mean.map(|row| Pulsegen::TABLE.rows[row].full_name());
        assert_eq!(mean.as_deref(), Some("Q_MEAN"));
    }

    #[test]
    fn clause_10_with_two_steps_the_opposite_output_is_no_pulse() {
        let mut block = restarted(Pulsegen { inv: 30.0, step3_on: false, ..ten_calls() });
        assert_eq!(block.pulse(), 0);
        let mut means = Vec::new();
        for _ in 0..5 {
            block.call();
            means.push(block.pulse());
        }
        assert_eq!(means, [1, 1, 1, 0, 0]);
        assert!(block.qneg_p);
    }

    #[test]
    fn clause_10_a_change_of_mode_counts_from_the_next_call_on() {
        let mut block = restarted(Pulsegen { step3_on: false, ..ten_calls() });
        block.call();
        block.step3_on = true;
        assert_eq!((block.qneg_p, block.pulse()), (true, 0));
    }

    #[test]
    fn a_period_of_half_a_call_is_rounded_to_none_and_has_no_pulse() {
        let mut block = restarted(Pulsegen { per_tm: Time::ms(5), inv: 100.0, ..ten_calls() });
        assert_eq!(pulses(&mut block, 4), "....");
        // The next setting counts in the next call already.
        block.per_tm = Time::ms(20);
        assert_eq!(pulses(&mut block, 4), "++++");
    }

    #[test]
    fn a_minimum_time_above_half_of_the_period_leaves_off_and_fully_on() {
        let calls = |inv| {
            let block = Pulsegen { inv, p_b_tm: Time::ms(60), ..ten_calls() };
            pulses(&mut restarted(block), 10).matches('+').count()
        };
        assert_eq!([10.0, 40.0, 41.0, 60.0, 90.0].map(calls), [0, 0, 10, 10, 10]);
    }

    #[test]
    fn a_minimum_time_above_the_period_leaves_fully_on() {
        let run = |inv, step3_on| {
            let block = Pulsegen { inv, step3_on, p_b_tm: Time::ms(101), ..ten_calls() };
            pulses(&mut restarted(block), 10)
        };
        assert_eq!(run(1.0, true), "++++++++++");
        assert_eq!(run(0.0, true), "----------");
        assert_eq!(run(-1.0, false), "++++++++++");
    }

    #[test]
    fn the_longest_period_and_the_widest_pulse_do_not_wrap() {
        let block = Pulsegen {
            per_tm: Time::ms(i32::MAX),
            cycle: Time::ms(1),
            p_b_tm: Time::ms(0),
            inv: Real::MAX,
            syn_on: false,
            ..Pulsegen::default()
        };
        assert_eq!(pulses(&mut restarted(block.clone()), 5), "+++++");
        let block = Pulsegen { inv: -1.0, ratiofac: Real::MIN, ..block };
        assert_eq!(pulses(&mut restarted(block), 5), ".....");
    }
}
