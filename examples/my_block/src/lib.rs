//! TWO_POINT: a two-point controller that shows how to turn your own block into an FMU. Copy this folder and change it.
//!
//! 1. The table: every variable once, with its type, start value, range, unit and description.
//! 2. The law: the restart and the call.
//! 3. `fmu::export!`: the C functions of FMI for this block.
//! 4. Tests: one for each clause in the documentation.

use blocks::{Law, Response};

blocks::block! {
    /// Two-point controller with hysteresis: switches on below the setpoint and off above it.
    ///
    /// # Purpose
    ///
    /// A thermostat or a level switch: one output, on or off. It is the smallest complete example of your own block.
    /// For proportional control use a continuous controller with a pulse generator.
    ///
    /// # Quick start
    ///
    /// 1. Connect SP and PV, in the same unit.
    /// 2. HYS: the band in which PV may swing; MIN_TM: the shortest switching time that the contactor tolerates.
    /// 3. CYCLE: a tenth of the time that PV takes to cross the band.
    /// 4. Connect Q, or Q_MEAN for a Real input, to the plant.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon two_step
    /// input SP 0,3
    /// input PV 0,9
    /// sum DIFF 9,3 left + bottom -
    /// box HYSTERESIS 20,3 two_step with HYS
    /// switch MAN_ON 32,4 TRUE lower
    /// input MAN 22,11
    /// box MIN_TIME 43,4 "stays for" with MIN_TM
    /// output ER 14,11
    /// output Q 54,4
    /// box MEAN 56,12 mean
    /// output Q_MEAN 61,12
    /// box CALL 37,13 "every CYCLE" with CYCLE
    /// SP > DIFF
    /// PV > DIFF.bottom
    /// ER: DIFF > HYSTERESIS
    /// 12,3 > y11 > ER
    /// HYSTERESIS > MAN_ON.FALSE
    /// MAN > x29 > MAN_ON.TRUE
    /// MAN_ON > MIN_TIME > Q
    /// 51,4 > y12 > MEAN
    /// MEAN > Q_MEAN
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// setpoint: SP
    /// process value: PV, PV
    /// manipulated value: Q_MEAN
    /// manual: MAN_ON, MAN
    ///
    /// [Setpoint]
    /// SP
    /// [Process value]
    /// PV
    /// [Hysteresis and time]
    /// HYS if not MAN_ON
    /// MIN_TM
    /// [Manual]
    /// MAN_ON
    /// MAN if MAN_ON
    /// [Sampling]
    /// CYCLE
    /// ```
    ///
    /// # Algorithm
    ///
    /// One call, in this order; w is the time for which Q must keep its state:
    ///
    /// ```text
    /// ER   = SP - PV
    /// want = TRUE if ER > HYS / 2;  FALSE if ER < -HYS / 2;  else Q
    /// want = MAN with MAN_ON
    /// Q    = want and w = MIN_TM,  if want is not Q and w = 0
    /// w    = w - CYCLE, at least 0
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Restart: Q is FALSE and may switch immediately.
    /// 2. Between SP - HYS / 2 and SP + HYS / 2 nothing switches. HYS = 0 leaves no such band: Q then changes with the sign
    ///    of ER.
    /// 3. MAN_ON: Q follows MAN, whatever PV is.
    /// 4. After a change Q keeps its state for MIN_TM, in manual mode too, to spare the contactor.
    /// 5. Q_MEAN is the mean of Q over the last communication step, 0 or 100 % if it did not switch.
    ///
    /// # Sampling
    ///
    /// Call it every CYCLE; PV can leave the band by its change in one CYCLE.
    ///
    /// # Limits of use
    ///
    /// With HYS below 0 the two limits are swapped, and switching on takes precedence.
    pub struct TwoPoint as "TWO_POINT" {
        input {
            /// Setpoint
            ///
            /// The output switches on when PV is more than HYS / 2 below it, and off when PV is more than HYS / 2 above
            /// it.
            sp: Real = 0.0;
            /// Process value, in the unit of the setpoint
            ///
            /// Connect the measured value, in the unit of SP.
            pv: Real = 0.0;
            /// Manual mode: MAN sets the output
            ///
            /// While it is TRUE the output follows MAN, whatever PV is. MIN_TM still applies.
            man_on: Bool = false;
            /// Manual value
            ///
            /// The output with MAN_ON = TRUE.
            man: Bool = false;
        }
        parameter {
            /// Hysteresis: the width of the band around the setpoint in which nothing switches
            ///
            /// The wider the band, the less often the output switches, and the further PV moves away from SP: with 4 it
            /// is 2 on either side, plus the overshoot due to the plant's lag. It must be larger than the noise of PV.
            hys: Real = 1.0, min 0.0;
            /// Minimum time between two changes of the output
            ///
            /// After each change the output keeps its state for at least this time. Contactors and compressors need it:
            /// 0 for a solid-state relay, minutes for a compressor.
            min_tm: Time = Time::ms(0);
        }
        cycle {
            /// Sampling time: the time between two calls
            ///
            /// The output can change once per CYCLE. Use a tenth of the time that PV takes to cross the band, or less.
            cycle: Time = Time::ms(100), min Time::ms(1);
        }
        output {
            /// Actuating signal
            ///
            /// TRUE while PV has to rise. It shows the state in the last call; for a plant with a Real input use
            /// Q_MEAN.
            q: Bool;
            /// Error: setpoint minus process value
            ///
            /// SP - PV, positive while PV is too low.
            er: Real;
        }
    }
    mean {
        /// Mean of the actuating signal over the last communication step in percent
        ///
        /// For a plant with a Real input: 100 if the output was on throughout the communication step, 40 if it was on
        /// for four of ten calls.
        q_mean;
    }
    memory Memory {
        /// How long Q must still keep its state, in milliseconds.
        wait: i32;
    }
}

impl Law for TwoPoint {
    // The runs shown on the FMU's documentation page and recorded in its reference results.
    const RESPONSES: &'static [Response] = &[Response {
        title: "The process value falls below the band of 2 around 50, rises above it, and returns to it",
        calls: 60,
        set: &[
            (0, "SP", 50.0),
            (0, "HYS", 2.0),
            (0, "PV", 50.0),
            (10, "PV", 48.5),
            (20, "PV", 50.5),
            (30, "PV", 51.5),
            (40, "PV", 49.5),
        ],
        show: &["SP", "PV", "Q"],
    }];

    fn restart(&mut self) {
        // Set all outputs and the memory to 0 and FALSE.
        self.clear();
    }

    fn call(&mut self) {
        self.er = self.sp - self.pv;
        let half = self.hys * 0.5;
        let mut want = self.q;
        if self.er > half {
            want = true;
        } else if self.er < -half {
            want = false;
        }
        if self.man_on {
            want = self.man;
        }
        if want != self.q && self.memory.wait == 0 {
            self.q = want;
            self.memory.wait = self.min_tm.milliseconds();
        }
        self.memory.wait = self.memory.wait.saturating_sub(self.cycle.milliseconds()).max(0);
    }

    // The source of Q_MEAN. Omit this in a block without a `mean` section.
    fn pulse(&self) -> i32 {
        i32::from(self.q)
    }
}

fmu::export!(TwoPoint);

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::{Bool, Real, Time};

    fn restarted(block: TwoPoint) -> TwoPoint {
        let mut block = block;
        block.restart();
        block
    }

    /// Q after a call for each of these process values.
    fn switches(block: &mut TwoPoint, process_values: &[Real]) -> Vec<Bool> {
        let call = |&pv: &Real| {
            block.pv = pv;
            block.call();
            block.q
        };
        process_values.iter().map(call).collect()
    }

    #[test]
    fn clause_1_a_restart_switches_off_and_ends_the_minimum_time() {
        let mut block = restarted(TwoPoint { sp: 50.0, min_tm: Time::ms(60_000), ..TwoPoint::default() });
        assert_eq!(switches(&mut block, &[0.0]), [true]);
        block.restart();
        assert!(!block.q);
        assert_eq!(switches(&mut block, &[0.0]), [true]);
    }

    #[test]
    fn clause_2_it_switches_outside_the_band_only() {
        let mut block = restarted(TwoPoint { sp: 50.0, hys: 2.0, ..TwoPoint::default() });
        // 49 and 51 are the ends of the band and belong to it.
        let process_values = [50.0, 49.0, 48.9, 50.5, 51.0, 51.1, 49.0, 48.9];
        assert_eq!(switches(&mut block, &process_values), [false, false, true, true, true, false, false, true]);
    }

    #[test]
    fn clause_2_without_a_band_the_sign_of_the_error_decides() {
        let mut block = restarted(TwoPoint { sp: 50.0, hys: 0.0, ..TwoPoint::default() });
        assert_eq!(switches(&mut block, &[50.0, 49.9, 50.0, 50.1, 50.0]), [false, true, true, false, false]);
    }

    #[test]
    fn clause_3_in_manual_mode_the_process_value_does_not_matter() {
        let mut block = restarted(TwoPoint { sp: 50.0, man_on: true, man: true, ..TwoPoint::default() });
        assert_eq!(switches(&mut block, &[0.0, 99.0]), [true, true]);
        block.man = false;
        assert_eq!(switches(&mut block, &[0.0, 99.0]), [false, false]);
    }

    #[test]
    fn clause_4_the_output_stays_for_the_minimum_time() {
        // 300 ms is three calls at 100 ms: on in the first, and off in the fourth at the earliest.
        let mut block = restarted(TwoPoint { sp: 50.0, min_tm: Time::ms(300), ..TwoPoint::default() });
        assert_eq!(switches(&mut block, &[0.0, 99.0, 99.0, 99.0, 0.0]), [true, true, true, false, false]);
    }

    #[test]
    fn clause_5_the_mean_is_made_of_the_output() {
        let mut block = restarted(TwoPoint { sp: 50.0, ..TwoPoint::default() });
        assert_eq!(block.pulse(), 0);
        block.call();
        assert_eq!(block.pulse(), 1);
    }

    #[test]
    fn a_process_value_that_is_no_number_switches_nothing() {
        let mut block = restarted(TwoPoint { sp: 50.0, ..TwoPoint::default() });
        assert_eq!(switches(&mut block, &[0.0, Real::NAN, 99.0, Real::NAN]), [true, true, false, false]);
    }
}
