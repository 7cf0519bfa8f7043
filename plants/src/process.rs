//! PROCESS: a process with lags, a dead time and an optional integrator, a plant for any controller.

use crate::dynamics::{Delay, Lags, analog};
use blocks::{Law, Response};

blocks::block! {
    /// Generic process with two lags and a dead time, self-regulating or integrating: manipulated value in, process
    /// value out.
    ///
    /// # Purpose
    ///
    /// The process assumed by tuning rules, for a loop whose real plant is known only by three numbers: gain, time
    /// constant and dead time. With INTEG it has no self-regulation, like a level. Nothing in it is limited or
    /// nonlinear, so every result can be compared with theory.
    ///
    /// # Quick start
    ///
    /// 1. Connect LMN of the controller to U, and PV to PV_IN, or PV_PER to PV_PER with PVPER_ON = TRUE; the start
    ///    values scale it to 0 ... 100.
    /// 2. Take GAIN, T1 and DEAD_TM from a step response of the plant: the change in the process value per percent, the
    ///    time to 63 % of that change, and the time before anything happens. Set INTEG = TRUE for a plant that does not
    ///    settle.
    /// 3. U_0 and PV_0: a manipulated value and the process value that it holds; the run starts at this operating
    ///    point.
    /// 4. CYCLE: the same as the controller's. Step the controller first, then the process.
    /// 5. Set LOAD during the run to create a disturbance.
    ///
    /// For CONT_C: with CYCLE 100 ms and the start values of the process, GAIN 4.76 and TI 8.4 s (SIMC) bring PV from 0
    /// to within 0.2 of 10 in 9 s, with 7 % overshoot; a LOAD of 10 % then moves PV by 1.8 at most.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon lag
    /// input U 0,5
    /// input LOAD 4,11
    /// sum IN 10,5 left + bottom +
    /// box DEAD 20,5 delay with DEAD_TM DEAD_MAX
    /// input U_0 27,11
    /// sum REST 32,5 left + bottom -
    /// box GAIN 41,5 multiply with GAIN
    /// box LAG_1 53,5 lag with T1
    /// box LAG_2 65,5 lag with T2
    /// U > IN > DEAD > REST > GAIN > LAG_1 > LAG_2
    /// LOAD > IN.bottom
    /// U_0 > REST.bottom
    ///
    /// // self-regulating or integrating, and the operating point
    /// LAG_2 > x73 > y18 > x4 > y23 > INTEG.FALSE
    /// box INT 15,30 integrate
    /// 4,23 > y30 > INT
    /// switch INTEG 28,24 TRUE lower
    /// INT > x24 > INTEG.TRUE
    /// input PV_0 31,31
    /// sum POINT 38,24 left + bottom +
    /// output PV 46,24
    /// box ANALOG 52,31 "0 ... 27648" with PV_PER_0 PV_PER_100
    /// output PV_PER 62,31
    /// box CALL 66,24 "every CYCLE" with CYCLE
    /// INTEG > POINT > PV
    /// PV_0 > POINT.bottom
    /// 42,24 > y31 > ANALOG
    /// ANALOG > PV_PER
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// process value: PV
    /// manipulated value: U
    /// disturbances: LOAD
    /// signal process value peripheral: PV_PER
    ///
    /// [Manipulated value]
    /// U
    /// [Disturbance]
    /// LOAD
    /// [Gain and times]
    /// GAIN, T1, T2, DEAD_TM, INTEG, DEAD_MAX
    /// [Start]
    /// PV_0, U_0
    /// [Peripheral process value]
    /// PV_PER_0, PV_PER_100
    /// [Sampling]
    /// CYCLE
    /// ```
    ///
    /// # Algorithm
    ///
    /// As transfer functions from U + LOAD to PV, without and with INTEG:
    ///
    /// ```math
    /// \frac{\text{GAIN}\; e^{-\text{DEAD_TM}\,s}}{(1 + \text{T1}\,s)(1 + \text{T2}\,s)}, \qquad \frac{\text{GAIN}\; e^{-\text{DEAD_TM}\,s}}{s\,(1 + \text{T1}\,s)(1 + \text{T2}\,s)}
    /// ```
    ///
    /// The process, where `u` is U + LOAD DEAD_TM ago:
    ///
    /// ```text
    /// T1 dx1/dt = GAIN (u - U_0) - x1
    /// T2 dx2/dt = x1 - x2
    /// PV        = PV_0 + x2                  without INTEG
    /// dPV/dt    = x2 / 1 s                   with INTEG
    /// PV_PER    = 27648 (PV - PV_PER_0) / (PV_PER_100 - PV_PER_0), rounded, within 0 ... 27648
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Call k covers the time from k to k + 1 times CYCLE, with the inputs held; after the call, the outputs are
    ///    those at the end of that time. So use a communication step of CYCLE or a multiple of it; with shorter steps
    ///    the outputs run ahead by part of a CYCLE.
    /// 2. Start: PV is PV_0, in steady state, and the dead time is filled with U_0. As long as U stays at U_0, nothing
    ///    changes.
    /// 3. Steady state without INTEG: PV = PV_0 + GAIN (U + LOAD - U_0).
    /// 4. With INTEG: PV changes by GAIN (U + LOAD - U_0) per second once the lags have settled, and is constant only
    ///    if U + LOAD is U_0.
    /// 5. A change in U or LOAD at time t begins to act at t + DEAD_TM, even within a CYCLE.
    /// 6. PV_PER is PV as an analog input word, for PV_PER, without overrange: it saturates at the ends of its range,
    ///    but PV does not. In CONT_C, PVPER_ON = TRUE, PV_FAC = (PV_PER_100 - PV_PER_0) / 100 and PV_OFF = PV_PER_0
    ///    convert it back to PV.
    /// 7. All parameters except INTEG and DEAD_MAX may be tuned during a run. DEAD_TM is limited to DEAD_MAX, or to its
    ///    own value at the start if that is longer. A new GAIN or U_0 acts through the lags; a new PV_0 shifts PV at
    ///    once, but with INTEG it has no effect after the start.
    ///
    /// # Limits of use
    ///
    /// Solved in closed form for held inputs, so the result depends on CYCLE only through rounding (a few parts in
    /// 10^13). The results are the same to the last bit on every platform.
    ///
    /// U is not limited: limit it at its source. The process has no noise; SENSOR adds it.
    ///
    /// Bad input: a time that is 0 or negative means no lag, or no delay. An infinite input or NaN stays in PV until the
    /// next start.
    pub struct Process as "PROCESS" {
        input {
            /// Manipulated value
            ///
            /// Connect LMN of the controller. Its difference from U_0 acts after DEAD_TM: with the start values, 10 %
            /// more finally raises PV by 10.
            u: LReal = 0.0, min -100.0, max 100.0, unit "%";
            /// Disturbance at the input
            ///
            /// Added to U before the dead time: the demand of another consumer, or a supply, in percent of U. A
            /// controller with I action compensates for it by lowering LMN by the same amount.
            load: LReal = 0.0, min -100.0, max 100.0, unit "%";
        }
        parameter {
            /// Gain: change in PV per percent of U; with INTEG, per percent and second
            ///
            /// The change in PV divided by the change in U, once PV has settled: 1.5 if 10 % more raises it by 15. With
            /// INTEG it is the slope of PV per percent. If it is below 0, PV falls when U rises, and the controller
            /// needs a negative GAIN too.
            gain: LReal = 1.0;
            /// First time constant; 0: none
            ///
            /// After a step in U, PV has covered 63.2 % of its change after the dead time plus T1, if T2 is 0.
            t1: LReal = 10.0, min 0.0, unit "s";
            /// Second time constant; 0: none
            ///
            /// A second lag, such as that of a sensor. Which of the two is longer does not matter. In a tuning rule for
            /// one lag, count half of the shorter one as dead time and half as time constant.
            t2: LReal = 0.0, min 0.0, unit "s";
            /// Dead time; range: 0 ... DEAD_MAX
            ///
            /// A change in U takes effect after it. The larger it is relative to T1, the less gain the loop tolerates.
            /// It may be tuned during a run, up to DEAD_MAX.
            dead_tm: LReal = 1.0, min 0.0, unit "s";
        }
        fixed {
            /// Integrating process: PV does not settle by itself
            ///
            /// TRUE: PV is the integral of the self-regulating response, as for a level or a position. Only U + LOAD =
            /// U_0 holds it. P action alone then leaves no error after a setpoint step, but one after a LOAD step.
            integ: Bool = false;
            /// Longest DEAD_TM that may be set during a run
            ///
            /// Reserves memory for the values in the dead time, 8 bytes for each CYCLE. Raise it before the start if
            /// DEAD_TM will exceed 60 s.
            dead_max: LReal = 60.0, min 0.0, unit "s";
        }
        parameter {
            /// Process value at the operating point, and at the start
            ///
            /// The process value that U_0 holds, in the unit of PV: 20 for a cold furnace without power.
            pv_0: LReal = 0.0;
            /// Manipulated value at the operating point
            ///
            /// The value of U that holds PV_0; with INTEG, the value that holds any process value, such as the inflow
            /// that balances a tank's outflow. Set MAN of the controller to it to start in steady state.
            u_0: LReal = 0.0, min -100.0, max 100.0, unit "%";
            /// Process value at which PV_PER is 0
            ///
            /// One end of the analog input's range: at this value and below, PV_PER is 0. Set PV_OFF of the controller
            /// to the same value.
            pv_per_0: LReal = 0.0;
            /// Process value at which PV_PER is 27648
            ///
            /// The other end of the range: at this value and above, PV_PER is 27648. Set PV_FAC of the controller to a
            /// hundredth of the span, 1 with the start values.
            pv_per_100: LReal = 100.0;
        }
        cycle {
            /// Time by which a call advances the process
            ///
            /// The process is solved exactly between two calls, so this time affects the result only through rounding.
            /// Set it to the controller's CYCLE or a fraction of it, and use a communication step of this time or a
            /// multiple of it.
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Process value, for PV_IN
            ///
            /// Connect it to PV_IN of the controller. Its unit is that of GAIN and PV_0.
            pv: LReal, from pv_0;
            /// Process value as an analog input word, for PV_PER
            ///
            /// Connect it to PV_PER of the controller, with PVPER_ON = TRUE: 0 ... 27648 for PV_PER_0 ... PV_PER_100. It
            /// saturates at the ends of its range.
            pv_per: Word, from pv_0 pv_per_0 pv_per_100;
        }
    }
    memory Memory {
        /// The manipulated values in the dead time.
        u: Delay;
        /// Both lags, for each part of a cycle.
        lags: [Lags; 2];
        /// The output of the first lag.
        x1: f64;
        /// The output of the second lag.
        x2: f64;
    }
}

impl Law for Process {
    const HOLDS_INPUTS: bool = true;

    const RESPONSES: &'static [Response] = &[
        Response {
            title: "A step in U to 50 %: nothing for the dead time of 5 s, then 63.2 % of 50 in T1 = 20 s; a LOAD of -20 % \
                    after 120 s",
            calls: 240,
            set: &[(0, "CYCLE", 1.0), (0, "T1", 20.0), (0, "DEAD_TM", 5.0), (10, "U", 50.0), (120, "LOAD", -20.0)],
            show: &["U", "LOAD", "PV"],
        },
        Response {
            title: "INTEG with GAIN 0.1: at 10 % above U_0 = 40 %, PV rises by 1 per second; at 10 % below, it falls again",
            calls: 120,
            set: &[
                (0, "CYCLE", 1.0),
                (0, "INTEG", 1.0),
                (0, "GAIN", 0.1),
                (0, "T1", 0.0),
                (0, "U_0", 40.0),
                (0, "U", 40.0),
                (10, "U", 50.0),
                (60, "U", 30.0),
                (110, "U", 40.0),
            ],
            show: &["U", "PV"],
        },
    ];

    fn check(&self) -> Result<(), String> {
        Delay::check("DEAD_TM", self.dead_tm, self.cycle)?;
        Delay::check("DEAD_MAX", self.dead_max, self.cycle)
    }

    fn restart(&mut self) {
        self.clear();
        self.memory.u = Delay::new(self.dead_tm.max(self.dead_max), self.cycle, self.u_0);
        self.show(self.pv_0);
    }

    #[inline(always)]
    fn call(&mut self) {
        let mut pv = self.pv;
        let parts = self.memory.u.step(self.u + self.load, self.dead_tm, self.cycle);
        for (part, (duration, u)) in parts.into_iter().enumerate() {
            let target = self.gain * (u - self.u_0);
            let Memory { x1, x2, .. } = self.memory;
            let [x1_after, x2_after] = self.memory.lags[part].step([x1, x2], target, [self.t1, self.t2], duration);
            // The equations of the lags, integrated: x1 = target - T1 dx1/dt, x2 = x1 - T2 dx2/dt.
            pv += target * duration - held(self.t1, x1_after - x1) - held(self.t2, x2_after - x2);
            (self.memory.x1, self.memory.x2) = (x1_after, x2_after);
        }
        self.show(if self.integ { pv } else { self.pv_0 + self.memory.x2 });
    }
}

/// Returns the part of the integral that a lag retains while its output changes by `change`.
#[inline(always)]
fn held(time_constant: f64, change: f64) -> f64 {
    if change == 0.0 { 0.0 } else { time_constant.max(0.0) * change }
}

impl Process {
    #[inline(always)]
    fn show(&mut self, pv: f64) {
        self.pv = pv;
        self.pv_per = analog(pv, self.pv_per_0, self.pv_per_100);
    }
}

#[cfg(test)]
mod tests;
