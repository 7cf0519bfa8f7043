//! CONT_S (FB 42): the PI step controller.

use crate::block::{Law, Response};
use crate::error_signal::{dead_band, process_value};
use crate::types::{Real, Time, Word};

crate::block! {
    /// PI step controller for a motor-driven actuator without position feedback, with manual pulses (FB 42).
    ///
    /// ```text
    /// SP_INT ------------>(+)--> dead band --ER--> x GAIN --e--+-->(+)-->(+)--z--> three-step --> manual --> pulse --+--> QLMNUP
    ///                     -^     DEADB_W                       |   -^     ^        element        LMNS_ON    stage   |
    /// PV_IN --------+      |                                   |    |     |        on, off        LMNUP              +--> QLMNDN
    ///               +--PV--+                                   |    F    DISV                     LMNDN    PULSE_TM  |
    /// PV_PER --> x 100/27648                                   |    |                                      BREAK_TM  |
    ///            x PV_FAC + PV_OFF                             +--> integrator                             LMNR_HS   |
    ///            (PVPER_ON)                                         TI    ^                                LMNR_LS   |
    ///                                                                     |                                          |
    ///                                                                     +--- +100, 0, -100 % in MTR_TM <-----------+
    /// ```
    ///
    /// The law of a call, in this order; every operation rounds to a 32-bit REAL, `a` is the pulse that runs since an
    /// earlier call (+1 up, -1 down, 0 none):
    ///
    /// ```text
    /// PV     = PVPER_ON ? ((PV_PER * 0.003616898) * PV_FAC) + PV_OFF : PV_IN
    /// ER     = dead band of half width DEADB_W over SP_INT - PV
    /// e      = ER * GAIN
    /// T      = CYCLE,  M = max(MTR_TM, T),  Ti = max(TI, T / 2)                                in seconds
    /// F      = 0                              with LMNS_ON
    ///          F + (((100 * a) * T) / M)      while a pulse runs
    ///          F - ((e * T) / Te)             in the pauses,  Te = max(Ti - |(0.01 * e) * M|, 0.1 * Ti)
    /// z      = (e - F) + DISV
    /// off    = (55 * T) / M
    /// lowest = (100 * max(PULSE_TM, CYCLE)) / M
    /// on     = max(min(|e|, |F|, 10), lowest)
    /// demand = +1 if z >= on, or still if z > off
    ///          -1 if z <= -on, or still if z < -off
    ///          0 otherwise;  with LMNS_ON: LMNUP - LMNDN
    /// a      = demand, as far as the stops, PULSE_TM and BREAK_TM allow
    /// QLMNUP = (a = +1),  QLMNDN = (a = -1)
    /// ```
    ///
    /// 1. Restart (COM_RST): all outputs are FALSE / 0, and so is all memory: a running pulse is cut at once, whatever is
    ///    left of PULSE_TM. The block does not take COM_RST back: while it is TRUE every call is a restart. (manual)
    /// 2. Process value: PV_FAC and PV_OFF act on the analog value PV_PER alone (manual). 100/27648 is multiplied as a
    ///    REAL (measured). Dead band: ER = x + DEADB_W below -DEADB_W, x - DEADB_W above DEADB_W, else 0. (vendor)
    /// 3. Times have floors: MTR_TM no less than CYCLE, TI than CYCLE / 2. (vendor)
    /// 4. One integrator F holds the assumed position of the valve and the I action (manual). While a pulse runs it goes
    ///    with the motor, and the error is not integrated; in the pauses it takes the error with the shorter reset time
    ///    Te, which makes up for the pulses: the mean rate is e / TI while |e| MTR_TM / 100 stays below 0.9 TI (measured).
    ///    The I action of the time that the first pulse takes is not made up: the travel stays e^2 MTR_TM / (100 TI)
    ///    behind e (1 + t / TI).
    /// 5. The pauses integrate nothing while the valve is reported at the stop that e pushes against. (measured)
    /// 6. LMNS_ON holds F at 0, so the change back to automatic may bump. (vendor)
    /// 7. TI = 0 switches the I action off. F is the position alone then, and held within 0 ... 100. (vendor; numbers
    ///    measured)
    /// 8. The on threshold is adapted: few long pulses while the error is large, short ones near the setpoint. It is as in
    ///    the formula with TI above 0; with TI = 0, |e| / 2 stands for min(|e|, |F|), or 0 where PV is 0. With either stop
    ///    reported it is `lowest`, also during a pulse; otherwise a pulse keeps the threshold it began with. It is
    ///    adapted in manual mode too. (that it is adapted: vendor; numbers measured)
    /// 9. Three-step element: on at the on threshold, off at the off threshold, with z compared as in the formula. (vendor)
    /// 10. Manual pulses: with LMNS_ON, LMNUP alone asks for a pulse up, LMNDN alone for one down, both or neither for
    ///     none. (manual, vendor)
    /// 11. A demand against a reported stop counts as none, and so does one against the running pulse: between up and down
    ///     lies at least one call with both outputs FALSE. (vendor)
    /// 12. A pulse that nothing demands any more lasts at least PULSE_TM, and the break after it at least BREAK_TM; manual
    ///     pulses too. Both times are counted in calls of CYCLE: a minimum of 3 s at 1 s is three calls. (manual, vendor)
    /// 13. A pulse that runs against a reported stop ends at once, whatever is left of PULSE_TM (vendor). If something was
    ///     left, no break has to pass after it, else BREAK_TM (measured).
    /// 14. Never are both outputs TRUE, never does DOWN follow UP in the next call or the other way round, never does a
    ///     pulse run against a reported stop: clauses 11 to 13 together.
    /// 15. QLMN_MEAN is ours, not the manual's: the mean of the pulses over the last communication step, +100 % for up
    ///     throughout, -100 % for down throughout; in a step without a call the state that the outputs hold. A Real plant
    ///     input and steps longer than CYCLE need it, for QLMNUP and QLMNDN only show the last call. (decided)
    ///
    /// Sampling: the block computes with CYCLE and must be called that often. A pulse is a whole number of calls, so the
    /// valve moves in steps of 100 CYCLE / MTR_TM percent.
    ///
    /// Bad input: the block checks no parameter. An overflow inside may leave the integrator infinite or NaN, of no use to
    /// the automatic mode; COM_RST clears it, and LMNS_ON too.
    ///
    /// Decided: QLMN_MEAN. The manual's table says of QLMNDN that the valve is opened, a misprint: QLMNDN closes it.
    ///
    /// Source: Standard Software for S7-300 and S7-400, PID Control, User Manual (C79000-G7076-C516), section 3.2,
    /// figure 3-2, tables 3-3 and 3-4; recordings at the terminals of real blocks.
    pub struct ContS as "CONT_S" {
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            com_rst: Bool = false;
            /// The actuator is at its upper limit stop
            lmnr_hs: Bool = false;
            /// The actuator is at its lower limit stop
            lmnr_ls: Bool = false;
            /// Manual mode: LMNUP and LMNDN make the pulses
            lmns_on: Bool = false;
            /// Manual pulse up
            lmnup: Bool = false;
            /// Manual pulse down
            lmndn: Bool = false;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            pvper_on: Bool = false;
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
        }
        parameter {
            /// Proportional gain
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE, 0 switches the integral action off
            ti: Time = Time::ms(20_000);
            /// Dead band: half the width of the band of errors that count as none, 0 ... 100 % or a physical value
            deadb_w: Real = 1.0, min 0.0;
            /// Factor of the process value from PV_PER
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            pv_off: Real = 0.0;
            /// Minimum length of a pulse; range: PULSE_TM >= CYCLE
            pulse_tm: Time = Time::ms(3_000);
            /// Minimum length of the break between pulses; range: BREAK_TM >= CYCLE
            break_tm: Time = Time::ms(3_000);
            /// Time that the actuator takes from limit stop to limit stop; range: MTR_TM >= CYCLE
            mtr_tm: Time = Time::ms(30_000);
        }
        input {
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            disv: Real = 0.0;
        }
        output {
            /// Pulse up: opens the valve
            qlmnup: Bool;
            /// Pulse down: closes the valve
            qlmndn: Bool;
            /// Process value in use
            pv: Real;
            /// Error after the dead band
            er: Real;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step, up positive (not in the manual)
        qlmn_mean;
    }
    memory Memory {
        /// The pulse that runs: +1 up, -1 down, 0 none.
        pulse: i32;
        /// The integrator: assumed valve position and I action in one.
        f: Real;
        /// The adapted on threshold.
        on: Real;
        /// What is left of the minimum pulse time, in milliseconds.
        pulse_left: i32;
        /// What is left of the minimum break time, in milliseconds.
        break_left: i32;
    }
}

impl Law for ContS {
    const RESPONSE: Response = Response {
        title: "Setpoint step to 11: one long pulse for the P action, then short ones for the I action; rest when the \
                process value arrives; down when it overshoots",
        calls: 100,
        set: &[(5, "SP_INT", 11.0), (46, "PV_IN", 11.0), (60, "PV_IN", 15.0), (80, "PV_IN", 11.0)],
        show: &["SP_INT", "PV", "ER", "QLMNUP", "QLMNDN"],
    };

    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        if self.com_rst {
            return self.restart();
        }
        self.pv = if self.pvper_on { process_value(self.pv_per, self.pv_fac, self.pv_off) } else { self.pv_in };
        self.er = dead_band(self.sp_int - self.pv, self.deadb_w);
        let e = self.er * self.gain;

        let t = self.cycle.seconds();
        let m = self.mtr_tm.seconds().max(t);

        self.memory.f = self.integral(e, t, m);
        self.memory.on = self.on_threshold(e, m);
        let demand = if self.lmns_on {
            i32::from(self.lmnup) - i32::from(self.lmndn)
        } else {
            self.three_step((e - self.memory.f) + self.disv, (55.0 * t) / m)
        };
        let reversal = demand * self.memory.pulse < 0;
        self.pulse_stage(if reversal || self.at_stop(demand > 0, demand < 0) { 0 } else { demand });

        self.qlmnup = self.memory.pulse > 0;
        self.qlmndn = self.memory.pulse < 0;
    }

    fn pulse(&self) -> i32 {
        self.memory.pulse
    }
}

impl ContS {
    /// Whether the valve is reported at the stop that lies in this direction.
    fn at_stop(&self, up: bool, down: bool) -> bool {
        (up && self.lmnr_hs) || (down && self.lmnr_ls)
    }

    /// The integrator F after this call.
    fn integral(&self, e: Real, t: Real, m: Real) -> Real {
        let Memory { f, pulse, .. } = self.memory;
        if self.lmns_on {
            return 0.0;
        }
        if self.ti > Time::ZERO {
            if pulse != 0 {
                f + (((100.0 * pulse as Real) * t) / m)
            } else if self.at_stop(e > 0.0, e < 0.0) {
                f
            } else {
                let ti = self.ti.seconds().max(t * 0.5);
                let te = (ti - ((0.01 * e) * m).abs()).max(0.1 * ti);
                f - ((e * t) / te)
            }
        } else {
            (f + (((100.0 * pulse as Real) * t) / m)).clamp(0.0, 100.0)
        }
    }

    /// The on threshold in this call.
    fn on_threshold(&self, e: Real, m: Real) -> Real {
        let lowest = (100.0 * self.pulse_tm.max(self.cycle).seconds()) / m;
        if self.lmnr_hs || self.lmnr_ls {
            lowest
        } else if self.memory.pulse != 0 {
            self.memory.on
        } else {
            let want = if self.ti > Time::ZERO {
                e.abs().min(self.memory.f.abs())
            } else if self.pv == 0.0 {
                0.0
            } else {
                e.abs() * 0.5
            };
            want.min(10.0).max(lowest)
        }
    }

    /// THREE_ST: the direction in which the valve should go.
    fn three_step(&self, z: Real, off: Real) -> i32 {
        let Memory { pulse, on, .. } = self.memory;
        if (pulse > 0 && z > off) || z >= on {
            1
        } else if (pulse < 0 && z < -off) || z <= -on {
            -1
        } else {
            0
        }
    }

    /// PULSEOUT: minimum pulse and minimum break, and the stops.
    fn pulse_stage(&mut self, demand: i32) {
        let stopped = self.at_stop(self.memory.pulse > 0, self.memory.pulse < 0);
        let memory = &mut self.memory;
        if stopped || (memory.pulse != 0 && demand == 0 && memory.pulse_left == 0) {
            memory.break_left = if memory.pulse_left > 0 { 0 } else { self.break_tm.milliseconds() };
            memory.pulse_left = 0;
            memory.pulse = 0;
        } else if memory.pulse == 0 && demand != 0 && memory.break_left == 0 {
            memory.pulse_left = self.pulse_tm.milliseconds();
            memory.pulse = demand;
        }
        memory.pulse_left = memory.pulse_left.saturating_sub(self.cycle.milliseconds()).max(0);
        memory.break_left = memory.break_left.saturating_sub(self.cycle.milliseconds()).max(0);
    }
}
