//! What `clauses.txt` cannot say of HLG.

use super::*;

fn ramp(set_point: Int, th_tz: Int, tr_tz: Int) -> Hlg {
    Hlg { s0: set_point, th_tz, tr_tz, ..Hlg::default() }
}

#[test]
fn the_advice_names_the_directions_without_a_ramp() {
    assert_eq!(ramp(0, 1, 0).advice(), ["TR_TZ = 0: downwards, the output jumps to the setpoint in one call"]);
    assert_eq!(ramp(0, -3, 1).advice(), ["TH_TZ = -3: upwards, the output jumps to the setpoint in one call"]);
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
fn clause_2_the_same_set_point_from_the_other_side_starts_without_a_remainder() {
    // SET takes the output over the setpoint, and clears the remainder; the direction alone does it too.
    let mut block = at(0, ramp(10, 4, 4));
    block.call();
    block.hlg = 20;
    assert_eq!(calls(&mut block, 2), [18, 15]);
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
