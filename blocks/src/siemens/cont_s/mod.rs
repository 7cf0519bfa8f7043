//! CONT_S (FB 42): the PI step controller.

mod responses;
#[cfg(test)]
mod tests;

use crate::siemens::advice;
use crate::siemens::error_signal::{dead_band, process_value};
use crate::table::{Law, Real, Response, Time};

crate::block! {
    /// PI step controller for a motor-driven actuator without position feedback, with manual pulses (FB 42).
    ///
    #[doc = include_str!("page.md")]
    pub struct ContS as "CONT_S" | "FB 42" | "SFB 42" {
        input {
            /// Complete restart: TRUE runs the restart routine instead of the controller
            ///
            /// While it is TRUE, every call is a restart (clause 1): both pulses end at once, even within PULSE_TM. Set
            /// it for one call if a NaN has reached the integrator.
            com_rst: Bool = false;
            /// The actuator is at its upper limit stop
            ///
            /// TRUE blocks QLMNUP. Connect it to the limit switch of the valve. Without limit switches leave it FALSE:
            /// the block then keeps pulsing against the stop, but recovers without harm.
            lmnr_hs: Bool = false;
            /// The actuator is at its lower limit stop
            ///
            /// TRUE blocks QLMNDN, as LMNR_HS blocks QLMNUP. If both are TRUE, every pulse is blocked, which usually
            /// indicates a wiring fault.
            lmnr_ls: Bool = false;
            /// Manual mode: LMNUP and LMNDN generate the pulses
            ///
            /// Setpoint and error are ignored, and the integrator is held at 0. When it becomes FALSE, the controller
            /// acts on the error as after a restart: with GAIN = 2, an error of 8 beyond the dead band demands 16 % of
            /// travel at once. For a smooth transition, keep the setpoint near the process value.
            lmns_on: Bool = false;
            /// Manual pulse up
            ///
            /// Acts only with LMNS_ON. The pulse lasts as long as LMNUP is TRUE, but at least PULSE_TM: with MTR_TM =
            /// 30 s, LMNUP for 6 s opens the valve by 20 %.
            lmnup: Bool = false;
            /// Manual pulse down
            ///
            /// Like LMNUP, in the other direction: it closes the valve. If both are TRUE, there is no demand.
            lmndn: Bool = false;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            ///
            /// Setpoint, dead band and PV have the unit of the process value selected here.
            pvper_on: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// A pulse is a whole number of calls, so the valve moves in steps of 100 CYCLE / MTR_TM percent: 3.3 %
            /// with the start values, 0.33 % with 0.1 s, which is usual. Choose CYCLE at most PULSE_TM and a tenth of
            /// the plant's dominant time constant.
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            ///
            /// In the unit of PV. A step of 10 with GAIN = 2 and no dead band demands 20 % of travel at once; a ramp
            /// before SP_INT avoids this.
            sp_int: Real = 0.0;
            /// Process value as a floating point number, -100 ... 100 % or a physical value
            ///
            /// Neither limited nor filtered: noise larger than DEADB_W makes the valve work.
            pv_in: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            ///
            /// The overrange of an analog input ends at 32511, which is 117.6 %. Words from 32768 up are negative:
            /// 65535 is -1.
            pv_per: Word = Word::new(0);
        }
        parameter {
            /// Proportional gain
            ///
            /// In percent of travel per unit of error; negative if opening the valve lowers the process value. With
            /// GAIN = 2, an error of 5 beyond the dead band demands 10 %, the smallest demand that causes a pulse with
            /// the start values. The rule of the quick start gives 1.5 for K = 2, T = 60 s, L = 10 s.
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE, 0 switches the integral action off
            ///
            /// The I action repeats the travel of the P action every TI while the error persists: with GAIN = 2 and an
            /// error of 10 it adds 20 % in each TI. If the valve takes long for the P action (|e| MTR_TM / 100 above
            /// 0.9 TI), the I action falls behind. With TI = 0, unlike in CONT_C, there is no I action and a
            /// steady-state error remains; between 0 and CYCLE / 2 it is CYCLE / 2.
            ti: Time = Time::ms(20_000);
            /// Dead band: half the width of the band in which the error counts as 0, 0 ... 100 % or a physical value
            ///
            /// Spares the motor. Choose it larger than the noise of PV and at least half the change in PV caused by the
            /// shortest pulse, K 100 PULSE_TM / MTR_TM with the plant gain K; otherwise the loop hunts.
            deadb_w: Real = 1.0, min 0.0;
            /// Factor of the process value from PV_PER
            ///
            /// Scales the word: PV = PV_PER * 100 / 27648 * PV_FAC + PV_OFF. PV_FAC is the transmitter's span divided
            /// by 100: 4 for 0 ... 400 degC; setpoint and dead band are then in degC.
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            ///
            /// PV at PV_PER = 0: -50, with PV_FAC = 2, for a transmitter of -50 ... 150 degC.
            pv_off: Real = 0.0;
            /// Minimum length of a pulse; range: PULSE_TM >= CYCLE
            ///
            /// Rounded up to whole calls; only a limit stop or a restart ends a pulse earlier. It determines the
            /// smallest movement of the valve, 100 PULSE_TM / MTR_TM percent: 10 % with the start values, which is
            /// coarse. Use the value from the data sheets of contactor and motor, often 0.1 ... 1 s.
            pulse_tm: Time = Time::ms(3_000);
            /// Minimum length of the break between pulses; range: BREAK_TM >= CYCLE
            ///
            /// The break between two pulses, in either direction, in which the motor stops and the contactors release.
            /// Even with 0 there is one call without a pulse between up and down.
            break_tm: Time = Time::ms(3_000);
            /// Time the actuator needs from limit stop to limit stop; range: MTR_TM >= CYCLE
            ///
            /// From the data sheet of the actuator, or measured from closed to open. If the true time is 30 % longer,
            /// each pulse moves the valve 23 % less than assumed, and the I action takes longer to compensate.
            mtr_tm: Time = Time::ms(30_000);
        }
        input {
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            ///
            /// Added to the demanded travel in automatic mode: a change of 10 moves the valve by 10 % without waiting
            /// for an error. Connect a measured disturbance, scaled to the valve travel that compensates for it.
            disv: Real = 0.0;
        }
        output {
            /// Pulse up: opens the valve
            ///
            /// Never TRUE together with QLMNDN. It shows the state in the last call of the communication step: for
            /// steps longer than CYCLE, and for a plant with a Real input, use QLMN_MEAN.
            qlmnup: Bool;
            /// Pulse down: closes the valve
            ///
            /// Like QLMNUP, in the other direction. Never TRUE together with QLMNUP.
            qlmndn: Bool;
            /// Process value in use
            ///
            /// PV_IN, or PV_PER scaled by PV_FAC and PV_OFF: the value for operators and alarms.
            pv: Real;
            /// Error after the dead band
            ///
            /// 0 within the dead band, otherwise smaller by DEADB_W than the true error. Not multiplied by GAIN.
            er: Real;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step in percent, up positive (not in the manual)
        ///
        /// Connects the pulses to a plant with one Real input for the motor: a step of ten calls with four calls up
        /// gives 40. A valve that integrates QLMN_MEAN / MTR_TM moves exactly as far as with the pulses, with any
        /// communication step.
        qlmn_mean;
    }
    memory Memory {
        /// The running pulse: +1 up, -1 down, 0 none.
        pulse: i32;
        /// The integrator: assumed valve position and I action in one.
        f: Real;
        /// The adapted on threshold.
        on: Real;
        /// Remaining minimum pulse time, in milliseconds.
        pulse_left: i32;
        /// Remaining minimum break time, in milliseconds.
        break_left: i32;
    }
}

impl Law for ContS {
    const RESPONSES: &'static [Response] = responses::RESPONSES;

    const DRAWN_UNIT: Option<&'static str> = Some("%");

    /// Clause 1.
    fn restart(&mut self) {
        self.clear();
    }

    #[inline(always)]
    fn call(&mut self) {
        if self.com_rst {
            return self.restart();
        }
        // Clause 2.
        self.pv = if self.pvper_on { process_value(self.pv_per, self.pv_fac, self.pv_off) } else { self.pv_in };
        self.er = dead_band(self.sp_int - self.pv, self.deadb_w);
        let e = self.er * self.gain;

        let t = self.cycle.seconds();
        // Clause 3.
        let m = self.mtr_tm.seconds().max(t);

        self.memory.f = self.integral(e, t, m);
        self.memory.on = self.on_threshold(e, m);
        // Clauses 9 and 10.
        let demand = if self.lmns_on {
            i32::from(self.lmnup) - i32::from(self.lmndn)
        } else {
            self.three_step((e - self.memory.f) + self.disv, (55.0 * t) / m)
        };
        // Clause 11.
        let reversal = demand * self.memory.pulse < 0;
        self.pulse_stage(if reversal || self.at_stop(demand > 0, demand < 0) { 0 } else { demand });

        self.qlmnup = self.memory.pulse > 0;
        self.qlmndn = self.memory.pulse < 0;
    }

    fn advice(&self) -> Vec<String> {
        advice::cont_s(self)
    }

    fn pulse(&self) -> i32 {
        self.memory.pulse
    }
}

impl ContS {
    /// Whether a limit switch reports the stop in this direction.
    fn at_stop(&self, up: bool, down: bool) -> bool {
        (up && self.lmnr_hs) || (down && self.lmnr_ls)
    }

    /// The integrator F after this call (clauses 3 to 7).
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

    /// The on threshold in this call (clause 8).
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

    /// THREE_ST: the direction in which the valve should move (clause 9).
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

    /// PULSEOUT: minimum pulse and minimum break, and the stops (clauses 12 and 13).
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
