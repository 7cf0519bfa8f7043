//! The clauses of HLG, and what its texts claim.

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
