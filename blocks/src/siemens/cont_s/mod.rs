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
            /// While it is TRUE, every call is a restart: both pulses end at once, even within PULSE_TM, the outputs
            /// are 0 and the integrator is empty. The block does not reset it. Nothing has to be set at the start of a
            /// simulation, because the FMU restarts the block when the initialization ends; a pulse of one call is the
            /// remedy after a NaN has reached the integrator.
            com_rst: Bool = false;
            /// The actuator is at its upper limit stop
            ///
            /// TRUE blocks QLMNUP: a pulse up ends at once, and pauses no longer integrate an error that pushes
            /// upwards. Wire it to the limit switch of the valve, or to that of a simulated one. Without limit switches
            /// leave it FALSE: the block then goes on pulsing against the stop, because it has no position feedback,
            /// and finds its way back without harm. While either stop is reported, the on threshold is at its lowest,
            /// 100 PULSE_TM / MTR_TM percent.
            lmnr_hs: Bool = false;
            /// The actuator is at its lower limit stop
            ///
            /// TRUE blocks QLMNDN: a pulse down ends at once, and pauses no longer integrate an error that pushes
            /// downwards. It is the counterpart of LMNR_HS. Both TRUE at the same time block every pulse, which is a
            /// wiring fault in most plants.
            lmnr_ls: Bool = false;
            /// Manual mode: LMNUP and LMNDN make the pulses
            ///
            /// While it is TRUE, only LMNUP and LMNDN move the valve, within PULSE_TM, BREAK_TM and the limit stops;
            /// setpoint and error are ignored. The integrator is held at 0. When it becomes FALSE, the controller
            /// begins with F = 0 and acts on the error as after a restart: with GAIN = 2, an error of 8 beyond the dead
            /// band demands 16 % of travel at once. For a smooth change let the setpoint be near the process value.
            /// Unlike CONT_C, the block starts in automatic mode.
            lmns_on: Bool = false;
            /// Manual pulse up
            ///
            /// Acts only with LMNS_ON = TRUE. The pulse lasts as long as LMNUP is TRUE, but at least PULSE_TM and in
            /// whole calls: with MTR_TM = 30 s, LMNUP for 6 s opens the valve by 20 %. Together with LMNDN it demands
            /// nothing. LMNR_HS stops it.
            lmnup: Bool = false;
            /// Manual pulse down
            ///
            /// Acts only with LMNS_ON = TRUE. The pulse lasts as long as LMNDN is TRUE, but at least PULSE_TM and in
            /// whole calls. Together with LMNUP it demands nothing. LMNR_LS stops it.
            lmndn: Bool = false;
        }
        parameter {
            /// The process value comes from PV_PER (TRUE) or PV_IN (FALSE)
            ///
            /// FALSE takes PV_IN as it is, in percent or in a physical unit. TRUE takes the analog word PV_PER, where
            /// 27648 is 100, times PV_FAC plus PV_OFF. Setpoint, dead band and PV always have the unit of the process
            /// value that is chosen here.
            pvper_on: Bool = false;
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// The block computes with this time and the FMU calls it that often, whatever the communication step is. A
            /// pulse is a whole number of calls, so the valve moves in steps of 100 CYCLE / MTR_TM percent: 3.3 % with
            /// the start values of 1 s and 30 s, 0.33 % with 0.1 s. Choose CYCLE at most PULSE_TM, a tenth of the
            /// plant's dominant time constant, and as in the PLC. 100 ms is usual.
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        input {
            /// Setpoint, -100 ... 100 % or a physical value
            ///
            /// Has the unit of PV. A step of the setpoint acts on the P action at once: a step of 10 with GAIN = 2 and
            /// no dead band demands 20 % of travel, which is a pulse of 6 s with MTR_TM = 30 s and TI = 0. If that is
            /// too rough, ramp the setpoint before the block.
            sp_int: Real = 0.0;
            /// Process value as a floating point number, -100 ... 100 % or a physical value
            ///
            /// Used while PVPER_ON is FALSE. Connect the output of the plant here if it is a Real in percent or in a
            /// physical unit. It is not limited and not filtered: noise larger than DEADB_W makes the valve work.
            pv_in: Real = 0.0;
            /// Process value as an analog input word: 27648 is 100 %
            ///
            /// Used while PVPER_ON is TRUE: what an analog input module gives for 0 ... 100 % is 0 ... 27648; its
            /// overrange ends at 32511, which is 117.6 %. Words from 32768 on are negative: 65535 is -1. Scale with
            /// PV_FAC and PV_OFF.
            pv_per: Word = Word::new(0);
        }
        parameter {
            /// Proportional gain
            ///
            /// Percent of valve travel for each unit of the error, and for the I action as well: GAIN acts on P and I
            /// together. With GAIN = 2 an error of 5 beyond the dead band demands 10 % of travel, which is the smallest
            /// demand that makes a pulse with the start values. A negative GAIN is for plants in which opening the
            /// valve lowers the process value. Begin with the SIMC rule GAIN = T / (K 2 L), at most, for a plant with
            /// gain K, time constant T and dead time L: K = 2, T = 60 s, L = 10 s give 1.5. GAIN = 0 makes no pulses
            /// from the error.
            gain: Real = 2.0;
            /// Reset time of the integral action; range: TI >= CYCLE, 0 switches the integral action off
            ///
            /// The I action repeats the travel of the P action every TI while the error stays: with GAIN = 2 and an
            /// error of 10 it adds 20 % of travel in each TI. Begin with the plant's time constant, but not more than 8
            /// times its dead time. Where the valve takes long for the P action (|e| MTR_TM / 100 above 0.9 TI), the I
            /// action falls behind: the reset time in pauses is never below a tenth of TI. 0 switches the I action off,
            /// unlike in CONT_C; the valve then follows GAIN times the error, with a permanent error. Between 0 and
            /// CYCLE / 2 the block uses CYCLE / 2.
            ti: Time = Time::ms(20_000);
            /// Dead band: half the width of the band in which the error counts as 0, 0 ... 100 % or a physical value
            ///
            /// Within SP_INT - DEADB_W ... SP_INT + DEADB_W the error is 0 and the valve rests; beyond it the error is
            /// counted from the edge of the band. It spares the motor. Choose it larger than the noise of PV and at
            /// least half as large as the change of PV that the shortest pulse causes: K 100 PULSE_TM / MTR_TM with the
            /// plant's gain K, else the loop hunts. The start value is 1, not 0 as in CONT_C. A negative value widens
            /// the error instead.
            deadb_w: Real = 1.0, min 0.0;
            /// Factor of the process value from PV_PER
            ///
            /// Acts on PV_PER only: PV = PV_PER * 100 / 27648 * PV_FAC + PV_OFF. For a transmitter of 0 ... 400 degC
            /// set 4 and PV_OFF = 0; then setpoint and dead band are in degC. With PV_IN it has no effect.
            pv_fac: Real = 1.0;
            /// Offset of the process value from PV_PER
            ///
            /// Acts on PV_PER only, behind PV_FAC: for a transmitter of -50 ... 150 degC set PV_FAC = 2 and PV_OFF =
            /// -50. With PV_IN it has no effect.
            pv_off: Real = 0.0;
            /// Minimum length of a pulse; range: PULSE_TM >= CYCLE
            ///
            /// No pulse is shorter, manual ones included; only a limit stop or a restart ends it earlier. It is counted
            /// in calls and rounded up: 3 s are 3 calls of 1 s. It sets the smallest move of the valve and the lowest
            /// on threshold, 100 PULSE_TM / MTR_TM percent: 10 % with the start values, which is coarse. For a
            /// contactor or a motor with run-up take what its data sheet asks for, often 0.1 ... 1 s. Below CYCLE it is
            /// CYCLE.
            pulse_tm: Time = Time::ms(3_000);
            /// Minimum length of the break between pulses; range: BREAK_TM >= CYCLE
            ///
            /// The rest between two pulses, in any direction, so that the motor can stop and the contactors can release
            /// before it reverses. It is counted in calls; even with 0 there is one call without a pulse between up and
            /// down. A long break slows the loop: with PULSE_TM = BREAK_TM and short pulses the valve moves half of the
            /// time. After a pulse that a limit stop has cut within PULSE_TM, no break is needed.
            break_tm: Time = Time::ms(3_000);
            /// Time the actuator needs from limit stop to limit stop; range: MTR_TM >= CYCLE
            ///
            /// From the data sheet of the actuator, or measured with a stop watch from closed to open. The block has no
            /// position feedback: it computes the travel from the time of its pulses, 100 CYCLE / MTR_TM percent a
            /// call. If the true time is 30 % longer, each pulse moves 30 % / 1.3 = 23 % less than the block assumes,
            /// and the I action makes up for it more slowly. Below CYCLE it is CYCLE.
            mtr_tm: Time = Time::ms(30_000);
        }
        input {
            /// Disturbance variable for feedforward, -100 ... 100 % or a physical value
            ///
            /// Added to the demanded travel, behind GAIN and the dead band: a change of DISV by 10 moves the valve by
            /// 10 % without waiting for an error. Connect a measured disturbance, scaled by how much valve it needs. It
            /// acts in automatic mode only.
            disv: Real = 0.0;
        }
        output {
            /// Pulse up: opens the valve
            ///
            /// TRUE while the motor has to open the valve. It shows the last call of the communication step: for steps
            /// longer than CYCLE and for a plant with a Real input use QLMN_MEAN. Never TRUE together with QLMNDN, and
            /// between up and down there is at least one call with both FALSE.
            qlmnup: Bool;
            /// Pulse down: closes the valve
            ///
            /// TRUE while the motor has to close the valve. It shows the last call of the communication step: for steps
            /// longer than CYCLE and for a plant with a Real input use QLMN_MEAN.
            qlmndn: Bool;
            /// Process value in use
            ///
            /// The process value that the last call used: PV_IN, or PV_PER scaled by PV_FAC and PV_OFF. It is 0 until
            /// the first call.
            pv: Real;
            /// Error after the dead band
            ///
            /// SP_INT - PV behind the dead band: 0 within it, otherwise smaller by DEADB_W than the true error. With
            /// SP_INT = 11, PV = 0 and DEADB_W = 1 it is 10. It is not multiplied by GAIN.
            er: Real;
        }
    }
    mean {
        /// Mean of the pulses over the last communication step in percent, up positive (not in the manual)
        ///
        /// Connects the pulses to a plant with one Real input for the motor. 100 means up in every call of the step,
        /// -100 down in every call; a step of ten calls with four calls up gives 40. A valve that integrates QLMN_MEAN
        /// / MTR_TM moves exactly as far as the pulses say, at any communication step.
        qlmn_mean;
    }
    memory Memory {
        /// The running pulse: +1 up, -1 down, 0 none.
        pulse: i32;
        /// The integrator: assumed valve position and I action in one.
        f: Real;
        /// The adapted on threshold.
        on: Real;
        /// Rest of the minimum pulse time, in milliseconds.
        pulse_left: i32;
        /// Rest of the minimum break time, in milliseconds.
        break_left: i32;
    }
}

impl Law for ContS {
    const RESPONSES: &'static [Response] = responses::RESPONSES;

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
    /// Whether the valve is reported at the stop that lies in this direction.
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

    /// THREE_ST: the direction in which the valve should go (clause 9).
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
