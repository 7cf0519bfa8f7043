//! MY_BLOCK as an FMU.
//!
//! 1. The table: every variable once, with its type, start value, range, unit and description.
//! 2. The law: the restart and the call.
//! 3. `fmu::export!`: the C functions of an FMU for this block.
//! 4. The tests.

use blocks::{Law, Response, Time};

blocks::block! {
    /// First-order lag: the output follows the input with a time constant.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon lag
    /// input U 0,3
    /// box GAIN 11,3 multiply with GAIN
    /// box LAG 23,3 lag with T1
    /// output Y 32,3
    /// box CALL 42,3 "every CYCLE" with CYCLE
    /// U > GAIN > LAG > Y
    /// ```
    ///
    /// # Algorithm
    ///
    /// ```text
    /// Y = Y + (GAIN * U - Y) * CYCLE / (T1 + CYCLE)
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Restart: Y is 0.
    /// 2. T1 = 0: Y is GAIN * U in every call.
    ///
    /// # Sampling
    ///
    /// Call it every CYCLE.
    ///
    /// # Limits of use
    ///
    /// A negative T1 counts as 0.
    pub struct MyBlock as "MY_BLOCK" {
        input {
            /// Input value
            ///
            /// The output follows it: after a step, 63 % of the way in T1.
            u: Real = 0.0;
        }
        parameter {
            /// Gain
            ///
            /// The steady-state output for an input of 1.
            gain: Real = 1.0;
            /// Time constant
            ///
            /// The larger, the slower. 0: no lag.
            t1: Time = Time::ms(1000), min Time::ms(0);
        }
        cycle {
            /// Time between two calls
            ///
            /// Much less than T1, about a tenth: the lag is computed once per CYCLE.
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Output value
            ///
            /// GAIN * U in the steady state.
            y: Real;
        }
    }
}

impl Law for MyBlock {
    // The experiment that the documentation page draws and the reference results record.
    const RESPONSES: &'static [Response] = &[Response {
        title: "The input steps from 0 to 1 and back",
        calls: 80,
        set: &[(10, "U", 1.0), (50, "U", 0.0)],
        show: &["U", "Y"],
    }];

    fn restart(&mut self) {
        // All outputs to 0 and FALSE.
        self.clear();
    }

    fn call(&mut self) {
        let t1 = self.t1.max(Time::ZERO).seconds();
        let cycle = self.cycle.seconds();
        self.y += (self.gain * self.u - self.y) * (cycle / (t1 + cycle));
    }
}

fmu::export!(MyBlock);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clause_1_a_restart_sets_the_output_to_0() {
        let mut block = MyBlock { u: 1.0, ..MyBlock::default() };
        block.call();
        assert!(block.y > 0.0);
        block.restart();
        assert_eq!(block.y, 0.0);
    }

    #[test]
    fn clause_2_without_a_time_constant_the_output_is_the_input_times_the_gain() {
        let mut block = MyBlock { t1: Time::ms(0), gain: 2.0, u: 3.0, ..MyBlock::default() };
        block.restart();
        block.call();
        assert_eq!(block.y, 6.0);
    }

    #[test]
    fn each_call_covers_the_same_part_of_the_way() {
        // CYCLE / (T1 + CYCLE) is 1/4.
        let mut block = MyBlock { t1: Time::ms(3000), cycle: Time::ms(1000), u: 16.0, ..MyBlock::default() };
        block.restart();
        for y in [4.0, 7.0, 9.25] {
            block.call();
            assert_eq!(block.y, y);
        }
    }

    #[test]
    fn a_negative_time_constant_counts_as_0() {
        let mut block = MyBlock { t1: Time::ms(-100), u: 3.0, ..MyBlock::default() };
        block.restart();
        block.call();
        assert_eq!(block.y, 3.0);
    }
}
