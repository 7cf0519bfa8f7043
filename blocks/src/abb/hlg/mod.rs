//! HLG: the ramp function generator (ABB Serie90 / AC500).

mod responses;
#[cfg(test)]
mod tests;

use crate::table::{Int, Law, Response};

crate::block! {
    /// Ramp function generator: moves an integer to a setpoint along a ramp, with stop, set and reset (ABB HLG).
    ///
    #[doc = include_str!("page.md")]
    pub struct Hlg as "HLG" {
        input {
            /// Selects the setpoint: S0 (FALSE) or S1 (TRUE)
            ///
            /// It may change at any time: the ramp continues from the current output towards the other setpoint, with
            /// that setpoint's slope.
            e01: Bool = false;
            /// Setpoint 0
            ///
            /// The target while E01 is FALSE. It also determines the slope: the output moves by |S0| in TH_TZ or TR_TZ
            /// calls, so from 0 it takes as long to reach 1000 as 100. With 0 the output stays where it is. -32768
            /// counts as -32767.
            s0: Int = 0, min -32767, max 32767;
            /// Setpoint 1
            ///
            /// The target while E01 is TRUE. It also determines the slope: the output moves by |S1| in TH_TZ or TR_TZ
            /// calls. With 0 the output stays where it is: to return to 0, ramp to a setpoint beyond it, such as -1000,
            /// and limit the output after the block, or use R.
            s1: Int = 0, min -32767, max 32767;
            /// Start-up time TH as a number of program cycles: the calls in which the output rises by |setpoint|
            ///
            /// The time from 0 to a positive setpoint, divided by TZ: 400 for 4 s at TZ = 10 ms. It applies whenever
            /// the output rises, even from a negative value. The steps are whole numbers, and the remainder is carried
            /// over: from 0 to 10 in 4 calls gives 2, 5, 7, 10. With 0, the start value, the output jumps in one call.
            th_tz: Int = 0, min 0;
            /// Return time TR as a number of program cycles: the calls in which the output falls by |setpoint|
            ///
            /// The time in which the output falls by the amount of the setpoint, divided by TZ; it applies whenever the
            /// output falls. With S0 = -500 and TR_TZ = 20 it falls by 25 per call. With 0, the start value, it jumps
            /// in one call.
            tr_tz: Int = 0, min 0;
            /// Holds the output
            ///
            /// While it is TRUE nothing changes, whatever SET and R are; afterwards the ramp continues as if no time
            /// had passed. Use it where a drive has to wait during run-up.
            stop: Bool = false;
            /// Sets the output to INIT (our name for the pin)
            ///
            /// While it is TRUE the output is INIT, even above or below both setpoints; when it becomes FALSE, the ramp
            /// starts from there. Use it to start a ramp at the current speed of a drive. STOP has priority over SET,
            /// and SET over R.
            set: Bool = false;
            /// Value of the output while SET is TRUE (our name for the pin)
            ///
            /// It may be beyond the setpoints: from 600, with S0 = 500 and TR_TZ = 10, the output falls to 500 in two
            /// calls. -32768 counts as -32767.
            init: Int = 0;
            /// Resets the output to 0
            ///
            /// While it is TRUE the output is 0, reached at once without a ramp. A setpoint of 0 holds the output, so
            /// use R, or SET with INIT = 0, to reach exactly 0. STOP and SET have priority.
            r: Bool = false;
        }
        cycle {
            /// Program cycle time: the time between two calls (not a pin of the original)
            ///
            /// The block counts calls and does not use TZ; the FMU calls it every TZ, whatever the communication step
            /// is. If you change TZ, rescale TH_TZ and TR_TZ: half of TZ needs twice the number. The PLC calls the
            /// original once per program cycle, typically 10 ms.
            tz: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Output of the ramp
            ///
            /// A whole number between -32767 and 32767. It never passes the setpoint, and stays there until the
            /// setpoint changes. After a restart it is 0.
            hlg: Int;
        }
    }
    memory Memory {
        /// Remainder of the last step's division.
        remainder: Int;
        /// Setpoint of the ramp to which the remainder belongs.
        w: Int;
        /// Whether that ramp goes up.
        upwards: bool;
        /// N of that ramp.
        n: Int;
    }
}

impl Law for Hlg {
    const RESPONSES: &'static [Response] = responses::RESPONSES;

    fn restart(&mut self) {
        self.clear();
    }

    #[inline(always)]
    fn call(&mut self) {
        // Clause 7.
        if self.stop {
            return;
        }
        if self.set {
            return self.arrive(limited(self.init));
        }
        if self.r {
            return self.arrive(0);
        }
        // Clauses 5 and 8.
        let w = limited(if self.e01 { self.s1 } else { self.s0 });
        // Clauses 3 and 4.
        if w == 0 || w == self.hlg {
            return self.arrive(self.hlg);
        }
        let upwards = w > self.hlg;
        let n = if upwards { self.th_tz } else { self.tr_tz };
        // Clause 6.
        if n <= 0 {
            return self.arrive(w);
        }

        // Clauses 1 and 2.
        let memory = &mut self.memory;
        if (memory.w, memory.upwards, memory.n) != (w, upwards, n) {
            *memory = Memory { remainder: 0, w, upwards, n };
        }
        let amount = i32::from(w).abs() + i32::from(memory.remainder);
        let step = amount / i32::from(n);
        memory.remainder = (amount % i32::from(n)) as Int;

        let distance = i32::from(w) - i32::from(self.hlg);
        if step >= distance.abs() {
            self.arrive(w);
        } else {
            self.hlg = (i32::from(self.hlg) + step * distance.signum()) as Int;
        }
    }

    fn advice(&self) -> Vec<String> {
        let jumps = [("TH_TZ", "upwards", self.th_tz), ("TR_TZ", "downwards", self.tr_tz)].into_iter();
        jumps
            .filter(|(_, _, n)| *n <= 0)
            .map(|(name, direction, n)| {
                format!("{name} = {n}: {direction}, the output jumps to the setpoint in one call")
            })
            .collect()
    }
}

impl Hlg {
    /// Sets the output and ends the ramp.
    fn arrive(&mut self, output: Int) {
        self.hlg = output;
        self.memory.remainder = 0;
    }
}

/// Setpoints are symmetrical: -32768 becomes -32767 (clause 8).
fn limited(value: Int) -> Int {
    value.max(-32767)
}
