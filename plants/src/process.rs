//! PROCESS: a process of lags, dead time and integrator, a plant for any controller.

use crate::dynamics::{Delay, Lags, analog};
use blocks::{Law, Response};

blocks::block! {
    /// Generic process of two lags and a dead time, self-regulating or integrating: manipulated value in, process value out.
    ///
    /// # Purpose
    ///
    /// The process of the tuning rules, for a loop whose real plant is known by three numbers only: gain, time constant
    /// and dead time. With INTEG it is one without self-regulation, such as a level. Nothing in it is limited or
    /// nonlinear, so that every result can be compared with theory.
    ///
    /// # Quick start
    ///
    /// 1. Connect LMN of the controller to U, and PV to PV_IN, or PV_PER to PV_PER with PVPER_ON = TRUE; the start
    ///    values scale it to 0 ... 100.
    /// 2. GAIN, T1 and DEAD_TM from a step response of the plant: the change of the process value for each percent, the
    ///    time to 63 % of it, and the time before anything happens. INTEG = TRUE for a plant that does not come to rest.
    /// 3. U_0 and PV_0: a manipulated value and the process value that it holds; the run starts there.
    /// 4. CYCLE: as the controller's. Step the controller first, then the process.
    /// 5. LOAD during the run for a disturbance.
    ///
    /// For CONT_C: with CYCLE 100 ms and the start values of the process, GAIN 4.76 and TI 8.4 s (SIMC) bring it from 0 to
    /// 10 within 0.2 in 9 s, with 7 % overshoot; a LOAD of 10 % then moves PV by 1.8 at most.
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
    /// The process, `u` being U + LOAD as it was DEAD_TM ago:
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
    /// 1. Call k stands for the time from k to k + 1 times CYCLE, with the inputs held: after it the outputs are those
    ///    at its end. So step it by CYCLE or a multiple of it; in shorter steps the outputs run ahead by part of a CYCLE.
    /// 2. Start: PV is PV_0, at rest, and U_0 has been on its way through the dead time. A U that holds U_0 leaves it so.
    /// 3. Steady state without INTEG: PV = PV_0 + GAIN (U + LOAD - U_0).
    /// 4. With INTEG: PV changes by GAIN (U + LOAD - U_0) a second, once the lags have settled, and rests only where U +
    ///    LOAD is U_0.
    /// 5. A change of U or LOAD at time t begins to act at t + DEAD_TM, within a CYCLE too.
    /// 6. PV_PER is PV as an analog input word, for PV_PER, without overrange: it saturates at the ends of its range, PV does
    ///    not. With CONT_C's PVPER_ON, PV_FAC = (PV_PER_100 - PV_PER_0) / 100 and PV_OFF = PV_PER_0 make PV of it again.
    /// 7. All parameters but INTEG and DEAD_MAX may be tuned while the process runs. DEAD_TM counts up to DEAD_MAX, or to
    ///    its own value at the start where that is longer. A new GAIN or U_0 acts through the lags; a new PV_0 shifts PV
    ///    at once, and with INTEG it has no effect any more.
    ///
    /// # Limits of use
    ///
    /// Solved in closed form for held inputs, so the result depends on CYCLE only by rounding (a few parts in
    /// 10^13). The results are the same to the last bit on every platform.
    ///
    /// U is not limited: limit it where it is made. The process has no noise; SENSOR adds it.
    ///
    /// Bad input: a time that is 0 or negative means no lag, or no delay. An infinite input or NaN stays in PV until the
    /// next start.
    pub struct Process as "PROCESS" {
        input {
            /// Manipulated value
            ///
            /// Connect LMN of the controller. It acts DEAD_TM later, as its difference to U_0: with the start values 10 %
            /// more raise PV by 10 in the end.
            u: LReal = 0.0, min -100.0, max 100.0, unit "%";
            /// Disturbance at the input
            ///
            /// Added to U before the dead time: what another consumer takes, or a supply gives, in percent of U. A
            /// controller with I action makes up for it by just as much less LMN.
            load: LReal = 0.0, min -100.0, max 100.0, unit "%";
        }
        parameter {
            /// Gain: change of PV for each percent of U; with INTEG per second
            ///
            /// The change of PV divided by that of U, when PV has come to rest: 1.5 if 10 % more raise it by 15. With
            /// INTEG the slope of PV for each percent. Below 0 PV falls where U rises, and the controller needs a negative
            /// GAIN too.
            gain: LReal = 1.0;
            /// First time constant; 0: none
            ///
            /// After a step of U, PV has moved 63.2 % of its way after the dead time and T1, if T2 is 0.
            t1: LReal = 10.0, min 0.0, unit "s";
            /// Second time constant; 0: none
            ///
            /// A second lag, such as that of a sensor. Which of the two is longer does not matter. A tuning rule for one
            /// lag takes half of the shorter one as dead time and half as time constant.
            t2: LReal = 0.0, min 0.0, unit "s";
            /// Dead time; range: 0 ... DEAD_MAX
            ///
            /// A change of U takes effect after it. The larger its share of T1, the less gain the loop bears.
            /// It may be tuned during a run, up to DEAD_MAX.
            dead_tm: LReal = 1.0, min 0.0, unit "s";
        }
        fixed {
            /// Integrating process: PV does not settle by itself
            ///
            /// TRUE: PV is the integral of what FALSE would show, as for a level or a position. Only U + LOAD = U_0 holds it.
            /// A P action alone then leaves no error at a setpoint, but one behind a LOAD.
            integ: Bool = false;
            /// Longest DEAD_TM that may be tuned while running
            ///
            /// Reserves memory for the values on their way, 8 bytes for each CYCLE. Raise it before the start if DEAD_TM
            /// is to be tuned beyond 60 s.
            dead_max: LReal = 60.0, min 0.0, unit "s";
        }
        parameter {
            /// Process value at the operating point, and at the start
            ///
            /// The process value that U_0 holds: 20 for a furnace that is cold without power. Has the unit of PV.
            pv_0: LReal = 0.0;
            /// Manipulated value at the operating point
            ///
            /// The value of U that holds PV_0; with INTEG the one that holds any process value, as the outflow of a tank
            /// does. Set MAN of the controller to it for a start at rest.
            u_0: LReal = 0.0, min -100.0, max 100.0, unit "%";
            /// Process value at which PV_PER is 0
            ///
            /// One end of the analog input's range: this value and anything below is 0 in PV_PER. PV_OFF of the
            /// controller is the same number.
            pv_per_0: LReal = 0.0;
            /// Process value at which PV_PER is 27648
            ///
            /// The other end of the range: this value and anything above is 27648 in PV_PER. PV_FAC of the controller is
            /// a hundredth of the span, 1 with the start values.
            pv_per_100: LReal = 100.0;
        }
        cycle {
            /// Time by which a call advances the process
            ///
            /// The process is solved exactly between two calls, so this time changes the result by rounding only. Make it
            /// the controller's CYCLE or a part of it, and step the FMU by it or by a multiple of it.
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Process value, for PV_IN
            ///
            /// Connect it to PV_IN of the controller. Its unit is whatever GAIN and PV_0 are given in.
            pv: LReal, from pv_0;
            /// Process value as an analog input word, for PV_PER
            ///
            /// Connect it to PV_PER of the controller, with PVPER_ON = TRUE: 0 ... 27648 for PV_PER_0 ... PV_PER_100. It
            /// saturates at the ends of its range.
            pv_per: Word, from pv_0 pv_per_0 pv_per_100;
        }
    }
    memory Memory {
        /// The manipulated values on their way through the dead time.
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
            title: "A step of U to 50 %: nothing for the dead time of 5 s, then 63.2 % of 50 in T1 = 20 s; from second 120 on \
                    a LOAD of -20 %",
            calls: 240,
            set: &[(0, "CYCLE", 1.0), (0, "T1", 20.0), (0, "DEAD_TM", 5.0), (10, "U", 50.0), (120, "LOAD", -20.0)],
            show: &["U", "LOAD", "PV"],
        },
        Response {
            title: "INTEG with GAIN 0.1: 10 % above U_0 = 40 % raise PV by 1 a second, 10 % below lower it again",
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
