//! The blocks for the unit tests.

use crate::state::{Function, State};
use blocks::Law;

blocks::block! {
    /// Adds up its inputs, call by call, and pulses in every fourth call.
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
            count: Int, from first;
        }
    }
    mean {
        /// Mean of the pulse in percent
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

    fn advice(&self) -> Vec<String> {
        if self.first > 5 { vec![format!("FIRST = {}: the count starts late", self.first)] } else { Vec::new() }
    }

    fn pulse(&self) -> i32 {
        i32::from(self.count % 4 == 1)
    }
}

// The row numbers.
pub(crate) const U: u32 = 0;
pub(crate) const V: u32 = 1;
pub(crate) const ON: u32 = 2;
pub(crate) const FACTOR: u32 = 3;
pub(crate) const FIRST: u32 = 4;
pub(crate) const CYCLE: u32 = 5;
pub(crate) const SUM: u32 = 6;
pub(crate) const COUNT: u32 = 7;

/// The function that sets the start time, for messages.
pub(crate) const SETUP: Function = Function::new("setup", &[State::Instantiated], "");

blocks::block! {
    /// Panics in its tenth call.
    pub struct Fragile as "FRAGILE" {
        input {
            /// Unused
            u: Real = 0.0;
        }
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        output {
            /// Calls since the restart
            calls: LReal;
        }
    }
}

impl Law for Fragile {
    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        self.calls += 1.0;
        assert!(self.calls < 10.0, "the tenth call");
    }
}

blocks::block! {
    /// A block with the name of `Sum` but another table.
    pub struct Other as "SUM" {
        input {
            /// Summand
            u: Real = 1.0;
        }
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
    }
}
impl Law for Other {
    fn restart(&mut self) {}
    fn call(&mut self) {}
}
