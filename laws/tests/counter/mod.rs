//! COUNTER: uses what a law may use and ours do not.

use blocks::{Int, Law, Real};

blocks::block! {
    /// Counts calls.
    pub struct Counter as "COUNTER" {
        input {
            /// Counts upwards
            up: Bool = false;
            /// Step
            step: Int = 1 + 2;
            /// Weight of a step
            weight: Real = 0.0;
        }
        cycle {
            /// Sampling time
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Count
            count: Int;
            /// Sum of the weights
            sum: Real;
            /// The last step was another one
            is_different: Bool;
        }
    }
    memory Memory {
        /// The last weight as an integer.
        whole: i32;
        /// The last weight.
        weight: Real;
    }
}

impl Law for Counter {
    fn restart(&mut self) {
        self.clear();
    }

    fn call(&mut self) {
        if self.up {
            self.count += 1;
        }
        // A loop, a match of integers, and a choice that has an effect.
        let mut left: Int = self.step;
        while left > 0 {
            left -= 1;
            if left == 4 {
                continue;
            }
            let _ = match left {
                0 => self.add(0.5),
                1 | 2 => self.add(self.weight),
                other if other > 5 => false,
                _ => true,
            };
            if left == 1 && self.add(1.0) || self.sum > 1e6 {
                break;
            }
        }
        self.is_different = self.memory.weight != self.weight;
        self.memory = Memory { whole: self.weight as i32, weight: self.weight };
        if let Some(limit) = self.limit() {
            self.sum = self.sum.clamp(-limit, limit);
        }
        self.count = (i32::from(self.count) ^ 1) as Int;
    }
}

impl Counter {
    /// Adds to the sum; whether it is positive.
    fn add(&mut self, weight: Real) -> bool {
        self.sum += weight;
        self.sum > 0.0
    }

    fn limit(&self) -> Option<Real> {
        if self.step == 8 { None } else { Some(1000.0) }
    }
}
