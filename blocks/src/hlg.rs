//! HLG: the ramp function generator (ABB Serie90 / AC500).

use crate::block::{Law, Response};
use crate::types::Int;

crate::block! {
    /// Ramp function generator: leads an integer to a set point along a ramp, with stop, set and reset (ABB HLG).
    ///
    /// ```text
    ///                                    +----------------------+
    /// S0 --+                             | ramp, |w| in N calls |
    ///      +--(E01)--> +-32767 --w------>| N = TH_TZ upwards    |----+----> HLG
    /// S1 --+                             |     TR_TZ downwards  |    |
    ///                                    +----------------------+    |
    ///                                      ^  STOP: hold             |
    ///                                      |  SET:  INIT             |
    ///                                      |  R:    0                |
    ///                                      +-------------------------+
    /// ```
    ///
    /// The law of a call, in integers of 32 bits; the first line that holds is the call:
    ///
    /// ```text
    /// STOP:               nothing changes
    /// SET:                HLG = INIT within -32767 ... 32767,  remainder = 0
    /// R:                  HLG = 0,  remainder = 0
    /// w = (E01 ? S1 : S0) within -32767 ... 32767,  N = (w > HLG) ? TH_TZ : TR_TZ
    /// w = 0 or w = HLG:   remainder = 0
    /// N <= 0:             HLG = w,  remainder = 0
    /// otherwise:          remainder = 0 if w, direction or N are new
    ///                     step = (|w| + remainder) div N,  remainder = (|w| + remainder) mod N
    ///                     HLG goes by step towards w; where that would reach or pass w, HLG = w and remainder = 0
    /// ```
    ///
    /// 1. Slope: the output runs through the amount of the set point in TH upwards and in TR downwards (manual), both given
    ///    as a number of program cycles: TH_TZ = TH / TZ, TR_TZ = TR / TZ (manual). From 0 the set point is reached in
    ///    exactly N calls, because what the division leaves is carried to the next call (decided): 0, 10 and N = 4 give
    ///    2, 5, 7, 10.
    /// 2. The remainder belongs to one ramp: another set point, direction or N starts without one; so does a ramp after
    ///    SET, R and arrival. STOP keeps it. (decided)
    /// 3. At the set point the output stays until there is another (manual). It never passes the set point (decided).
    /// 4. Set point 0 means slope 0: the output stays where it is. To come back to 0, ramp to a set point on the other
    ///    side and limit the output behind the block, or use R. (manual)
    /// 5. E01 selects the set point (manual): FALSE S0, TRUE S1 (decided).
    /// 6. TH_TZ or TR_TZ of 0 or less: the output jumps to the set point. (decided)
    /// 7. STOP holds the output, SET makes it INIT, R makes it 0: in this priority, and all before the ramp. (manual)
    /// 8. Set points reach from -32767 to 32767 (manual); -32768, of S0, S1 or INIT, counts as -32767 (decided).
    ///
    /// Sampling: the ramp counts calls. TZ is the time between two calls and enters no formula; scale TH_TZ and TR_TZ to it.
    /// The block has no restart input; at the start the output is 0.
    ///
    /// Bad input: any value of any pin gives a defined output; nothing overflows.
    ///
    /// Decided: clauses as marked. The library page describes setting to an initial value without naming the pins: SET and
    /// INIT are our names, and so is TZ for the program cycle time.
    ///
    /// Source: ABB function block library Serie90_AC500_V10, page of HLG. No recordings.
    pub struct Hlg as "HLG" {
        input {
            /// Selects the set point: S0 (FALSE) or S1 (TRUE)
            e01: Bool = false;
            /// Set point 0
            s0: Int = 0, min -32767, max 32767;
            /// Set point 1
            s1: Int = 0, min -32767, max 32767;
            /// Start up time TH as a number of program cycles: calls in which the output rises by |set point|
            th_tz: Int = 0, min 0;
            /// Return time TR as a number of program cycles: calls in which the output falls by |set point|
            tr_tz: Int = 0, min 0;
            /// Holds the output
            stop: Bool = false;
            /// Sets the output to INIT (pin name ours)
            set: Bool = false;
            /// Initial value for SET (pin name ours)
            init: Int = 0;
            /// Resets the output to 0
            r: Bool = false;
        }
        cycle {
            /// Program cycle time: the time between two calls (name ours)
            tz: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Output of the ramp
            hlg: Int;
        }
    }
    memory Memory {
        /// What the last step's division left.
        remainder: Int;
        /// Set point of the ramp that the remainder belongs to.
        w: Int;
        /// That ramp goes upwards.
        upwards: bool;
        /// N of that ramp.
        n: Int;
    }
}

impl Law for Hlg {
    const RESPONSE: Response = Response {
        title: "Up to 1000 in 40 calls, stopped for 10 of them; down to -500 at 500 in 20 calls; reset",
        calls: 140,
        set: &[
            (0, "TH_TZ", 40.0),
            (0, "TR_TZ", 20.0),
            (0, "S1", -500.0),
            (5, "S0", 1000.0),
            (25, "STOP", 1.0),
            (35, "STOP", 0.0),
            (60, "E01", 1.0),
            (130, "R", 1.0),
        ],
        show: &["HLG"],
    };

    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        if self.stop {
            return;
        }
        if self.set {
            return self.arrive(limited(self.init));
        }
        if self.r {
            return self.arrive(0);
        }
        let w = limited(if self.e01 { self.s1 } else { self.s0 });
        if w == 0 || w == self.hlg {
            return self.arrive(self.hlg);
        }
        let upwards = w > self.hlg;
        let n = if upwards { self.th_tz } else { self.tr_tz };
        if n <= 0 {
            return self.arrive(w);
        }

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
}

impl Hlg {
    /// The output is where it shall be: no ramp is under way.
    fn arrive(&mut self, output: Int) {
        self.hlg = output;
        self.memory.remainder = 0;
    }
}

/// Set points are symmetrical: -32768 is none.
fn limited(value: Int) -> Int {
    value.max(-32767)
}
