//! What `clauses.txt` cannot say of CONT_C.

use super::*;
use crate::table::Time;

/// In automatic mode with setpoint 1 and the other defaults, so that e = 2.
fn automatic() -> ContC {
    ContC { man_on: false, sp_int: 1.0, ..ContC::default() }
}

fn restarted(mut block: ContC) -> ContC {
    block.restart();
    block
}

/// An output after each of some calls.
fn calls<T>(block: &mut ContC, count: usize, output: impl Fn(&ContC) -> T) -> Vec<T> {
    let call = |_| {
        block.call();
        output(block)
    };
    (0..count).map(call).collect()
}

fn after_one_call<T>(mut block: ContC, output: impl Fn(&ContC) -> T) -> T {
    block.call();
    output(&block)
}

#[test]
fn clause_1_a_restart_forgets_the_derivative_and_both_rests() {
    let used = |calls_before| {
        let mut block = ContC { d_sel: true, sp_int: 1.7, ti: Time::ms(7_300), gain: 0.3, ..automatic() };
        calls(&mut block, calls_before, |_| ());
        block.restart();
        calls(&mut block, 50, |block| (block.lmn_i, block.lmn_d))
    };
    assert_eq!(used(37), used(0));
}

#[test]
fn clause_10_what_rounding_takes_from_the_lag_comes_back_in_later_calls() {
    // With a lag of 10^5 calls w climbs by less than its last bit a call; the closed form still holds.
    let mut block = restarted(ContC {
        i_sel: false,
        d_sel: true,
        cycle: Time::ms(10),
        td: Time::ms(1_000_000),
        tm_lag: Time::ms(1_000_000),
        ..automatic()
    });
    calls(&mut block, 300_000, |_| ());
    let (a, v) = (1.0 - 0.01 / (0.005 + 1000.0), 1000.0 / (0.005 + 1000.0));
    let expected = 2.0 * v * f64::powi(a, 299_999);
    assert!((f64::from(block.lmn_d) / expected - 1.0).abs() < 1e-5, "{} {expected}", block.lmn_d);
}

#[test]
fn lmn_per_of_nan_is_16_ffff() {
    let block = restarted(ContC { lmn_off: Real::NAN, ..ContC::default() });
    assert_eq!(after_one_call(block, |block| block.lmn_per.value()), -1);
}

#[test]
fn constant_error_follows_the_closed_forms() {
    let mut block = restarted(ContC { d_sel: true, i_itlval: 5.0, ..automatic() });
    let a = 1.0 - 1.0 / (0.5 + 2.0);
    for (k, (i, d)) in (1..).zip(calls(&mut block, 40, |block| (block.lmn_i, block.lmn_d))) {
        let integral = 5.0 + (1.0 / 20.0) * 2.0 * (f64::from(k) - 0.5);
        let derivative = 2.0 * 4.0 * f64::powi(a, k - 1);
        assert!((f64::from(i) - integral).abs() < 1e-5, "LMN_I in call {k}: {i}, not {integral}");
        assert!((f64::from(d) - derivative).abs() < 1e-5, "LMN_D in call {k}: {d}, not {derivative}");
    }
}

// The numbers in the help of the variables and in the documentation, beyond those that the clauses above have tested.

/// A lag of 100 s with gain 2 behind a dead time of 10 s, in steps of 1 s.
struct Plant {
    pv: f64,
    delayed: std::collections::VecDeque<f64>,
}

impl Plant {
    fn at_rest() -> Plant {
        Plant { pv: 0.0, delayed: [0.0; 10].into() }
    }

    fn step(&mut self, lmn: f64) {
        self.delayed.push_back(lmn);
        let a = f64::exp(-1.0 / 100.0);
        self.pv = a * self.pv + (1.0 - a) * 2.0 * self.delayed.pop_front().unwrap();
    }
}

/// The loop of the quick start after a setpoint step: the highest PV, and when PV was last off by more than 1. A host that
/// makes `calls` calls a step sets PV_IN once in a step; `at_once` says whether the plant sees LMN in the same step.
fn quick_start(setpoint: f64, calls: usize, at_once: bool) -> (f64, usize) {
    let mut block = restarted(ContC { gain: 2.5, ti: Time::ms(80_000), sp_int: setpoint as Real, ..automatic() });
    let mut plant = Plant::at_rest();
    let (mut highest, mut settled) = (0.0, 0);
    for step in 0..600 / calls {
        block.pv_in = plant.pv as Real;
        let former = block.lmn;
        (0..calls).for_each(|_| block.call());
        for second in 0..calls {
            plant.step(f64::from(if at_once { block.lmn } else { former }));
            highest = f64::max(highest, plant.pv);
            if (plant.pv - setpoint).abs() > 1.0 {
                settled = step * calls + second;
            }
        }
    }
    (highest, settled)
}

#[test]
fn the_loop_of_the_quick_start_settles_within_160_s() {
    let (highest, settled) = quick_start(50.0, 1, true);
    assert!(highest < 50.001 && settled < 160, "{highest} {settled}");
}

#[test]
fn the_loop_of_the_quick_start_overshoots_as_the_documentation_says() {
    let overshoots = |setpoint: f64| {
        [(1, true), (10, true), (10, false)]
            .map(|(calls, at_once)| ((quick_start(setpoint, calls, at_once).0 / setpoint - 1.0) * 100.0).round())
    };
    // As long as LMN stays within its limits, the size of the step is of no account.
    assert_eq!(overshoots(10.0), [10.0, 34.0, 90.0]);
    assert_eq!(overshoots(20.0), [10.0, 34.0, 90.0]);
    assert_eq!(overshoots(50.0), [0.0, 8.0, 33.0]);
}

#[test]
fn help_of_i_sel_without_it_a_plant_of_gain_1_stops_at_two_thirds_of_the_setpoint() {
    let mut block = restarted(ContC { i_sel: false, sp_int: 60.0, ..automatic() });
    for _ in 0..5_000 {
        block.pv_in += (block.lmn - block.pv_in) * 0.01;
        block.call();
    }
    assert!((block.pv - 40.0).abs() < 1e-3, "{}", block.pv);
    block.i_sel = true;
    // One step of the integral from 0: (1 / 20) * 40.
    assert!((calls(&mut block, 1, |block| block.lmn_i)[0] - 2.0).abs() < 1e-3, "{}", block.lmn_i);
}
