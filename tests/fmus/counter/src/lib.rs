//! A block that records when it is called and what it sees then.

use blocks::Law;

blocks::block! {
    /// Counts its calls and adds up the inputs that it sees in them.
    ///
    /// ```text
    /// WEIGHTED = WEIGHTED + (CALLS + 1) * U
    /// SUM      = SUM + U
    /// CALLS    = CALLS + 1
    /// ```
    ///
    /// The sums are exact while they are whole numbers below 2^53. WEIGHTED tells which call saw which input.
    pub struct Counter as "COUNTER" {
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(1), min Time::ms(1);
        }
        input {
            /// What is added up
            u: LReal = 0.0;
            /// The same as a 32-bit number
            r: Real = 0.0;
        }
        output {
            /// Calls since the restart
            calls: LReal;
            /// Sum of U over the calls
            sum: LReal;
            /// Sum of the number of the call, from 1, times U
            weighted: LReal;
            /// U as the last call saw it
            last: LReal;
            /// R as the last call saw it
            last_r: Real;
            /// Restarts since the instance was made or reset
            restarts: Int;
        }
    }
}

impl Law for Counter {
    fn restart(&mut self) {
        let restarts = self.restarts;
        self.clear();
        self.restarts = restarts.saturating_add(1);
    }

    fn call(&mut self) {
        self.calls += 1.0;
        self.sum += self.u;
        self.weighted += self.calls * self.u;
        self.last = self.u;
        self.last_r = self.r;
    }
}

fmu::export!(Counter);
