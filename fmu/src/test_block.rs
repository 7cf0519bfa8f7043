//! The block of the unit tests.

use blocks::Law;

blocks::block! {
    /// Adds its input up, call by call, and pulses in every fourth call.
    pub struct Sum as "SUM" {
        input {
            /// Summand
            u: Real = 0.0;
            /// Exact summand
            v: LReal = 0.0;
            /// Unused
            on: Bool = false;
        }
        parameter {
            /// Factor
            factor: Real = 1.0, min 0.1, max 10.0;
        }
        fixed {
            /// Refused below 0
            first: Int = 0;
        }
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Sum of u times factor, and v
            sum: LReal;
            /// Calls since the restart
            count: Int;
        }
    }
    mean {
        /// Mean of the pulse
        q_mean;
    }
}

impl Law for Sum {
    fn restart(&mut self) {
        self.clear();
        self.count = self.first;
    }

    fn call(&mut self) {
        self.sum += f64::from(self.u * self.factor) + self.v;
        self.count = self.count.wrapping_add(1);
    }

    fn check(&self) -> Result<(), String> {
        if self.first < 0 { Err(format!("FIRST = {}: must not be below 0", self.first)) } else { Ok(()) }
    }

    fn pulse(&self) -> i32 {
        i32::from(self.count % 4 == 1)
    }
}

// The rows by number.
pub const U: u32 = 0;
pub const V: u32 = 1;
pub const ON: u32 = 2;
pub const FACTOR: u32 = 3;
pub const FIRST: u32 = 4;
pub const CYCLE: u32 = 5;
pub const SUM: u32 = 6;
pub const COUNT: u32 = 7;
