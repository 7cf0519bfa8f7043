//! HLG: the ramp function generator (ABB Serie90 / AC500).

use crate::table::{Int, Law, Response};

crate::block! {
    /// Ramp function generator: moves an integer to a set point along a ramp, with stop, set and reset (ABB HLG).
    ///
    /// # Purpose
    ///
    /// The block leads the set point of a drive or a controller along a ramp, so that speed or temperature change no
    /// faster than the machine bears. Start up and return have slopes of their own. It is an integer block: scale
    /// physical values to whole numbers, with as many digits as you need.
    ///
    /// # Quick start
    ///
    /// 1. TZ: the time between two calls, the program cycle of the PLC; 10 ms by default.
    /// 2. S0, and S1 for a second set point with E01: whole numbers from -32767 to 32767, not 0.
    /// 3. TH_TZ = TH / TZ: the calls from 0 up to the set point; 4 s at 10 ms are 400.
    /// 4. TR_TZ = TR / TZ: the same for falling. With 0 the output jumps.
    /// 5. HLG to the drive, or, scaled, to SP_INT of a controller.
    ///
    /// # Diagram
    ///
    /// ```diagram
    /// icon ramp
    /// input S0 0,4
    /// input S1 0,10
    /// switch E01 12,7 TRUE lower
    /// box LIMIT 21,7 limit
    /// box RAMP 33,7 ramp with TH_TZ TR_TZ
    /// switch R 45,8 TRUE lower constant TRUE 0
    /// switch SET 55,9 TRUE lower
    /// switch STOP 65,10 TRUE lower
    /// input INIT 38,16
    /// output HLG 73,10
    /// box LAST 60,24 "HLG of the" "last call"
    /// S0 > x8 > E01.FALSE
    /// S1 > x8 > E01.TRUE
    /// E01 > LIMIT > RAMP > R.FALSE
    /// R > SET.FALSE
    /// INIT > x51 > SET.TRUE
    /// SET > STOP.FALSE
    /// STOP > HLG
    /// 70,10 > y24 > LAST.right
    /// LAST.left > RAMP.bottom
    /// 52,24 > y19 > x61 > STOP.TRUE
    /// text 26,6 "w"
    /// text 21,10 "±32767" middle
    /// text 45,15.2 "±32767"
    /// box CALL 12,21 "every TZ" with TZ
    /// ```
    ///
    /// # Dialog
    ///
    /// ```dialog
    /// setpoint: S0
    /// manipulated value: HLG
    /// signal actual value: INIT
    ///
    /// [Setpoint]
    /// E01
    /// S0 if not E01
    /// S1 if E01
    /// [Ramp]
    /// TH_TZ, TR_TZ
    /// [Stop, set and reset]
    /// STOP
    /// SET if not STOP
    /// INIT if SET and not STOP
    /// R if not SET and not STOP
    /// [Sampling]
    /// TZ
    /// ```
    ///
    /// # Law
    ///
    /// The output moves towards the set point w by the same amount in each call, rising and falling at slopes of their
    /// own:
    ///
    /// ```math
    /// \left|\frac{d\,\text{HLG}}{dt}\right| = \frac{|w|}{N\,\text{TZ}}, \qquad N = \begin{cases} \text{TH_TZ} & w > \text{HLG} \\ \text{TR_TZ} & w < \text{HLG} \end{cases}
    /// ```
    ///
    /// The law of a call, in integers of 32 bits; the first line whose condition holds applies:
    ///
    /// ```text
    /// STOP:               nothing changes
    /// SET:                HLG = INIT within -32767 ... 32767,  remainder = 0
    /// R:                  HLG = 0,  remainder = 0
    /// w = (E01 ? S1 : S0) within -32767 ... 32767,  N = (w > HLG) ? TH_TZ : TR_TZ
    /// w = 0 or w = HLG:   remainder = 0
    /// N <= 0:             HLG = w,  remainder = 0
    /// otherwise:          remainder = 0 if w, direction or N has changed
    ///                     step = (|w| + remainder) div N,  remainder = (|w| + remainder) mod N
    ///                     HLG moves by step towards w; if that would reach or pass w, HLG = w and remainder = 0
    /// ```
    ///
    /// # Clauses
    ///
    /// 1. Slope: within TH the output rises by |set point|, within TR it falls by that (manual), both given as a number
    ///    of program cycles: TH_TZ = TH / TZ, TR_TZ = TR / TZ (manual). From 0 the set point is reached in exactly N
    ///    calls, because the remainder of the division is carried to the next call (decided): from 0 to 10, N = 4 gives
    ///    2, 5, 7, 10.
    /// 2. The remainder belongs to one ramp: another set point, direction or N starts without one, and so does a ramp
    ///    after SET, R or reaching the set point. STOP keeps it. (decided)
    /// 3. At the set point the output stays until the set point changes (manual). It never passes the set point
    ///    (decided).
    /// 4. Set point 0 means slope 0: the output stays where it is. To return to 0, ramp to a set point on the other
    ///    side and limit the output after the block, or use R. (manual)
    /// 5. E01 selects the set point (manual): FALSE S0, TRUE S1 (decided).
    /// 6. TH_TZ or TR_TZ of 0 or less: the output jumps to the set point. (decided)
    /// 7. STOP holds the output, SET sets it to INIT, R sets it to 0, in this priority; all override the ramp. (manual)
    /// 8. Set points range from -32767 to 32767 (manual); -32768 in S0, S1 or INIT counts as -32767 (decided).
    ///
    /// # Sampling
    ///
    /// The ramp counts calls. TZ is the time between two calls and occurs in no formula; scale TH_TZ and TR_TZ to it.
    /// The block has no restart input; at the start the output is 0.
    ///
    /// A communication step of ten times TZ makes ten calls, so the ramp has the same slope and the host sees every
    /// tenth value.
    ///
    /// # Limits of use
    ///
    /// Every value of every pin gives a defined output; nothing overflows.
    ///
    /// # Sources
    ///
    /// Decided: clauses as marked. The library page describes setting an initial value without naming the pins: SET and
    /// INIT are our names. There the program cycle time TZ is not a pin; here it is the parameter that every block has.
    ///
    /// ABB function block library Serie90_AC500_V10, page of HLG. No recordings.
    pub struct Hlg as "HLG" {
        input {
            /// Selects the set point: S0 (FALSE) or S1 (TRUE)
            ///
            /// FALSE ramps to S0, TRUE to S1. It may change at any time: the ramp goes on from the present output
            /// towards the other set point, with the slope of that set point.
            e01: Bool = false;
            /// Set point 0
            ///
            /// The target while E01 is FALSE, and the slope too: the output moves by |S0| in TH_TZ or TR_TZ calls, so a
            /// target of 1000 is reached from 0 in the same time as one of 100. 0 is no target: the output stays where
            /// it is. -32768 counts as -32767.
            s0: Int = 0, min -32767, max 32767;
            /// Set point 1
            ///
            /// The target while E01 is TRUE, and the slope too: the output moves by |S1| in TH_TZ or TR_TZ calls. 0 is
            /// no target: to return to 0, ramp to a set point beyond it, such as -1000, and limit the output behind the
            /// block, or use R.
            s1: Int = 0, min -32767, max 32767;
            /// Start up time TH as a number of program cycles: calls in which the output rises by |set point|
            ///
            /// The time from 0 to a positive set point, divided by TZ: 4 s at TZ = 10 ms are 400. It is used whenever
            /// the output rises, also from a negative output. The steps are whole numbers, and the remainder is carried
            /// on: from 0 to 10 in 4 calls gives 2, 5, 7, 10. With 0, the start value, the output jumps in one call.
            th_tz: Int = 0, min 0;
            /// Return time TR as a number of program cycles: calls in which the output falls by |set point|
            ///
            /// The time from a set point back by its own amount, divided by TZ; used whenever the output falls. With S0
            /// = -500 and 20 the output falls by 25 a call. 0, the start value, jumps in one call.
            tr_tz: Int = 0, min 0;
            /// Holds the output
            ///
            /// While it is TRUE nothing changes, whatever SET and R are; the ramp goes on afterwards as if no time had
            /// passed, with the remainder of its division kept. A drive that has to wait on its way up sets it.
            stop: Bool = false;
            /// Sets the output to INIT (pin name ours)
            ///
            /// While it is TRUE the output is INIT, also above or below both set points; when it becomes FALSE, the
            /// ramp starts from there. Use it to start a ramp at the present speed of a drive. STOP has priority over
            /// it, and it has priority over R.
            set: Bool = false;
            /// Initial value for SET (pin name ours)
            ///
            /// The output while SET is TRUE. It may be beyond the set points: 600 with S0 = 500 and TR_TZ = 10 falls to
            /// 500 in two calls. -32768 counts as -32767.
            init: Int = 0;
            /// Resets the output to 0
            ///
            /// While it is TRUE the output is 0 at once, without a ramp. It is the only way to exactly 0, because a set
            /// point of 0 means to stay. STOP and SET have priority.
            r: Bool = false;
        }
        cycle {
            /// Program cycle time: the time between two calls (no pin of the original)
            ///
            /// The block's law counts calls and does not contain TZ; the FMU calls it every TZ, whatever the
            /// communication step is. When you change TZ, scale TH_TZ and TR_TZ: half of TZ needs twice the number. The
            /// PLC calls the original once a program cycle, 10 ms is typical.
            tz: Time = Time::ms(10), min Time::ms(1);
        }
        output {
            /// Output of the ramp
            ///
            /// A whole number between -32767 and 32767. It never passes the set point, and stays on it until the set
            /// point changes. After a restart it is 0.
            hlg: Int;
        }
    }
    memory Memory {
        /// Remainder of the last step's division.
        remainder: Int;
        /// Set point of the ramp to which the remainder belongs.
        w: Int;
        /// That ramp goes upwards.
        upwards: bool;
        /// N of that ramp.
        n: Int;
    }
}

impl Law for Hlg {
    const RESPONSES: &'static [Response] = &[
        Response {
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
            show: &["HLG", "STOP", "E01", "R"],
        },
        Response {
            title: "SET to 600, then down to the set point 500 in 2 calls of 50; set point 0 holds the output",
            calls: 60,
            set: &[
                (0, "S0", 500.0),
                (0, "TH_TZ", 20.0),
                (0, "TR_TZ", 10.0),
                (0, "INIT", 600.0),
                (15, "SET", 1.0),
                (25, "SET", 0.0),
                (40, "S0", 0.0),
            ],
            show: &["HLG", "SET"],
        },
        Response {
            title: "10 in 4 calls: 2, 5, 7, 10, because the remainder of the division is carried on; with TR_TZ = 0 the way back is \
                a jump",
            calls: 60,
            set: &[(0, "TH_TZ", 4.0), (0, "S0", 10.0), (0, "S1", -10.0), (20, "E01", 1.0)],
            show: &["HLG", "E01"],
        },
    ];

    fn restart(&mut self) {
        self.clear();
    }

    #[inline(always)]
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

    fn advice(&self) -> Vec<String> {
        let jumps = [("TH_TZ", "upwards", self.th_tz), ("TR_TZ", "downwards", self.tr_tz)].into_iter();
        jumps
            .filter(|(_, _, n)| *n <= 0)
            .map(|(name, direction, n)| {
                format!("{name} = {n}: {direction} the output jumps to the set point in one call")
            })
            .collect()
    }
}

impl Hlg {
    /// Sets the output; no ramp is running.
    fn arrive(&mut self, output: Int) {
        self.hlg = output;
        self.memory.remainder = 0;
    }
}

/// Set points are symmetrical: -32768 becomes -32767.
fn limited(value: Int) -> Int {
    value.max(-32767)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(set_point: Int, th_tz: Int, tr_tz: Int) -> Hlg {
        Hlg { s0: set_point, th_tz, tr_tz, ..Hlg::default() }
    }

    #[test]
    fn the_advice_names_the_directions_without_a_ramp() {
        assert_eq!(ramp(0, 1, 0).advice(), ["TR_TZ = 0: downwards the output jumps to the set point in one call"]);
        assert_eq!(ramp(0, -3, 1).advice(), ["TH_TZ = -3: upwards the output jumps to the set point in one call"]);
        assert_eq!(ramp(0, 1, 1).advice(), Vec::<String>::new());
    }

    /// A block whose output starts at `output`.
    fn at(output: Int, mut block: Hlg) -> Hlg {
        block.init = output;
        block.set = true;
        block.call();
        block.set = false;
        block
    }

    fn calls(block: &mut Hlg, count: usize) -> Vec<Int> {
        let call = |_| {
            block.call();
            block.hlg
        };
        (0..count).map(call).collect()
    }

    #[test]
    fn clause_1_the_amount_of_the_set_point_is_run_through_in_n_calls() {
        assert_eq!(calls(&mut ramp(10, 4, 0), 5), [2, 5, 7, 10, 10]);
        assert_eq!(calls(&mut ramp(10, 3, 0), 4), [3, 6, 10, 10]);
        assert_eq!(calls(&mut ramp(3, 7, 0), 8), [0, 0, 1, 1, 2, 2, 3, 3]);
    }

    #[test]
    fn clause_1_from_0_every_set_point_is_reached_in_exactly_n_calls() {
        for set_point in [1, 2, 9, 10, 11, 999, 32_767] {
            for n in [1, 2, 3, 7, 10, 100, 1_000] {
                for sign in [1, -1] {
                    let outputs = calls(&mut ramp(sign * set_point, n, n), n as usize);
                    let (last, before) = outputs.split_last().unwrap();
                    assert_eq!(*last, sign * set_point, "{set_point} in {n}");
                    assert!(!before.contains(last), "{set_point} in {n}: too early");
                }
            }
        }
    }

    #[test]
    fn clause_1_th_tz_counts_upwards_and_tr_tz_downwards() {
        assert_eq!(calls(&mut ramp(100, 4, 2), 2), [25, 50]);
        assert_eq!(calls(&mut ramp(-100, 4, 2), 2), [-50, -100]);
    }

    #[test]
    fn clause_1_the_set_point_and_not_the_distance_makes_the_slope() {
        let mut block = at(1_000, ramp(-500, 0, 5));
        let expected: Vec<Int> = (1..=15).map(|k| 1_000 - 100 * k).collect();
        assert_eq!(calls(&mut block, 15), expected);
        assert_eq!(calls(&mut block, 1), [-500]);
    }

    #[test]
    fn clause_2_another_set_point_direction_or_n_starts_without_a_remainder() {
        // 10 / 4 leaves 2 in the first call.
        let second = |change: fn(&mut Hlg)| {
            let mut block = ramp(10, 4, 4);
            block.call();
            change(&mut block);
            calls(&mut block, 1)[0]
        };
        assert_eq!(second(|_| ()), 5);
        assert_eq!(second(|block| block.s0 = 11), 2 + 11 / 4);
        assert_eq!(second(|block| block.th_tz = 3), 2 + 10 / 3);
        assert_eq!(second(|block| block.s0 = -10), 2 - 10 / 4);
    }

    #[test]
    fn clause_2_the_same_set_point_from_the_other_side_starts_without_a_remainder() {
        // SET takes the output over the set point, and clears the remainder; the direction alone does it too.
        let mut block = at(0, ramp(10, 4, 4));
        block.call();
        block.hlg = 20;
        assert_eq!(calls(&mut block, 2), [18, 15]);
    }

    #[test]
    fn clause_2_set_r_and_arrival_drop_the_remainder() {
        let interrupted = |set: bool, r: bool| {
            let mut block = ramp(10, 4, 4);
            block.call();
            (block.set, block.r) = (set, r);
            block.call();
            (block.set, block.r) = (false, false);
            calls(&mut block, 2)
        };
        assert_eq!(interrupted(true, false), [2, 5]);
        assert_eq!(interrupted(false, true), [2, 5]);

        // 10 / 3 leaves 1 on arrival from 9.
        let mut block = at(9, ramp(10, 3, 3));
        assert_eq!(calls(&mut block, 1), [10]);
        block.hlg = 0;
        assert_eq!(calls(&mut block, 3), [3, 6, 10]);
    }

    #[test]
    fn clause_2_a_set_point_of_0_and_a_jump_drop_the_remainder() {
        let interrupted = |pause: fn(&mut Hlg), resume: fn(&mut Hlg)| {
            let mut block = ramp(10, 4, 4);
            block.call();
            pause(&mut block);
            block.call();
            resume(&mut block);
            calls(&mut block, 2)
        };
        assert_eq!(interrupted(|block| block.s0 = 0, |block| block.s0 = 10), [4, 7]);
        let jump = |block: &mut Hlg| (block.s0, block.th_tz) = (3, 0);
        assert_eq!(interrupted(jump, |block| (block.s0, block.th_tz) = (10, 4)), [5, 8]);
    }

    #[test]
    fn clause_2_stop_keeps_the_remainder() {
        let mut block = ramp(10, 4, 4);
        block.call();
        block.stop = true;
        assert_eq!(calls(&mut block, 3), [2, 2, 2]);
        block.stop = false;
        assert_eq!(calls(&mut block, 3), [5, 7, 10]);
    }

    #[test]
    fn clause_3_the_output_never_passes_the_set_point() {
        assert_eq!(calls(&mut at(95, ramp(100, 10, 0)), 2), [100, 100]);
        assert_eq!(calls(&mut at(-95, ramp(-100, 0, 10)), 2), [-100, -100]);
        assert_eq!(calls(&mut at(90, ramp(100, 10, 0)), 2), [100, 100]);
    }

    #[test]
    fn clause_4_a_set_point_of_0_holds_the_output() {
        assert_eq!(calls(&mut at(77, ramp(0, 5, 5)), 3), [77; 3]);
        assert_eq!(calls(&mut at(77, ramp(0, 0, 0)), 3), [77; 3]);
    }

    #[test]
    fn clause_5_e01_selects_s1() {
        let block = Hlg { s0: 10, s1: -20, ..Hlg::default() };
        assert_eq!(calls(&mut block.clone(), 1), [10]);
        assert_eq!(calls(&mut Hlg { e01: true, ..block }, 1), [-20]);
    }

    #[test]
    fn clause_6_no_calls_for_the_ramp_is_a_jump() {
        for n in [0, -1, Int::MIN] {
            assert_eq!(calls(&mut ramp(1_000, n, 5), 2), [1_000, 1_000]);
            assert_eq!(calls(&mut ramp(-1_000, 5, n), 2), [-1_000, -1_000]);
        }
    }

    #[test]
    fn clause_7_stop_comes_before_set_and_set_before_r() {
        let output = |stop, set, r| {
            let mut block = Hlg { init: 7, ..at(50, ramp(100, 10, 10)) };
            (block.stop, block.set, block.r) = (stop, set, r);
            calls(&mut block, 1)[0]
        };
        assert_eq!(output(true, true, true), 50);
        assert_eq!(output(true, false, true), 50);
        assert_eq!(output(false, true, true), 7);
        assert_eq!(output(false, false, true), 0);
        assert_eq!(output(false, false, false), 60);
    }

    #[test]
    fn clause_8_minus_32768_counts_as_minus_32767() {
        assert_eq!(calls(&mut ramp(Int::MIN, 1, 1), 2), [-32_767; 2]);
        assert_eq!(calls(&mut Hlg { e01: true, s1: Int::MIN, ..Hlg::default() }, 1), [-32_767]);
        assert_eq!(at(Int::MIN, Hlg::default()).hlg, -32_767);
    }

    #[test]
    fn clause_8_the_whole_range_is_run_through_without_overflow() {
        assert_eq!(calls(&mut at(-32_767, ramp(32_767, 2, 2)), 5), [-16_384, 0, 16_383, 32_767, 32_767]);
        assert_eq!(calls(&mut at(32_767, ramp(-32_767, 2, 2)), 5), [16_384, 0, -16_383, -32_767, -32_767]);
    }

    #[test]
    fn clause_8_no_value_of_any_pin_overflows_or_leaves_the_range() {
        let extremes = [Int::MIN, -32_767, -1, 0, 1, 2, 32_766, Int::MAX];
        for start in extremes {
            for set_point in extremes {
                for n in extremes {
                    let mut block = at(start, ramp(set_point, n, n));
                    block.hlg = start;
                    let outputs = calls(&mut block, 5);
                    let reached = set_point.max(-32_767);
                    let (low, high) = (start.min(reached), start.max(reached));
                    let all_between = outputs.iter().all(|output| (low..=high).contains(output));
                    assert!(all_between, "{start} to {set_point} in {n}: {outputs:?}");
                }
            }
        }
    }

    #[test]
    fn a_restart_makes_the_output_0() {
        let mut block = at(50, ramp(10, 4, 4));
        block.restart();
        assert_eq!((block.hlg, calls(&mut block, 4)), (0, vec![2, 5, 7, 10]));
    }
}
