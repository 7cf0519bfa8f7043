use super::*;
use blocks::{Block, ContC, Stored, Time, Word};

fn started(process: Process) -> Process {
    let mut process = process;
    process.restart();
    process
}

fn run(process: &mut Process, seconds: f64) {
    let calls = (seconds / crate::dynamics::seconds(process.cycle)).round() as u32;
    (0..calls).for_each(|_| process.call());
}

#[track_caller]
fn assert_close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b} within {tolerance}");
}

#[test]
fn it_starts_at_the_operating_point_whatever_the_inputs_are() {
    let process = started(Process { u: 100.0, load: 50.0, pv_0: 25.0, u_0: 40.0, ..Process::default() });
    assert_eq!((process.pv, process.pv_per), (25.0, Word::new(6912)));
}

#[test]
fn at_the_operating_point_it_stays_at_rest_to_the_last_bit() {
    for integ in [false, true] {
        let point = Process { pv_0: 21.3, u_0: 37.1, u: 37.1, gain: 1.7, t2: 3.0, integ, ..Process::default() };
        let mut process = started(point);
        run(&mut process, 1000.0);
        assert_eq!(process.pv, 21.3);
    }
}

#[test]
fn after_the_dead_time_and_t1_it_has_moved_63_2_percent_of_its_way() {
    // 1 s of dead time and 10 s: 11 s, of 30 units for 20 %.
    let mut process = started(Process { u: 20.0, gain: 1.5, ..Process::default() });
    run(&mut process, 11.0);
    assert_close(process.pv, 30.0 * 0.632_120_558_828_557_7, 1e-12);
    run(&mut process, 1000.0);
    assert_close(process.pv, 30.0, 1e-12);
}

#[test]
fn nothing_happens_for_the_calls_of_the_dead_time() {
    for (dead_tm, calls) in [(0.0, 1), (1.0, 11), (1.04, 11), (2.0, 21)] {
        for integ in [false, true] {
            let mut process = started(Process { u: 50.0, dead_tm, integ, ..Process::default() });
            let first = (1..).find(|_| {
                process.call();
                process.pv != 0.0
            });
            assert_eq!(first, Some(calls), "{dead_tm} s");
        }
    }
}

#[test]
fn a_dead_time_that_is_no_multiple_of_the_cycle_is_exact() {
    // 1.04 s in cycles of 0.1 s: at 1.1 s it has moved for 0.06 s.
    let mut process = started(Process { u: 100.0, dead_tm: 1.04, ..Process::default() });
    run(&mut process, 1.1);
    assert_close(process.pv, 100.0 * (1.0 - (-0.06_f64 / 10.0).exp()), 1e-12);
}

#[test]
fn two_lags_answer_in_either_order_as_the_formula_says() {
    for [t1, t2] in [[10.0, 4.0], [4.0, 10.0]] {
        let mut process = started(Process { u: 100.0, t1, t2, dead_tm: 0.0, ..Process::default() });
        for k in 1..=500 {
            process.call();
            let t = f64::from(k) / 10.0;
            let share = 1.0 - (10.0 * (-t / 10.0).exp() - 4.0 * (-t / 4.0).exp()) / 6.0;
            assert_close(process.pv, 100.0 * share, 1e-11);
        }
    }
}

#[test]
fn integrating_it_rises_by_gain_a_second_for_each_percent() {
    // 10 % above U_0, 0.1 a second: 1 a second after the dead time.
    let process = Process { u: 50.0, u_0: 40.0, gain: 0.1, t1: 0.0, dead_tm: 2.0, integ: true, ..Process::default() };
    let mut process = started(Process { pv_0: 7.0, ..process });
    run(&mut process, 2.0);
    assert_eq!(process.pv, 7.0);
    run(&mut process, 60.0);
    assert_close(process.pv, 67.0, 1e-11);
    process.u = 40.0;
    run(&mut process, 100.0);
    assert_close(process.pv, 69.0, 1e-11);
}

#[test]
fn integrating_the_lags_cost_the_slope_times_their_sum() {
    // The ramp is 10 + 4 s late in the end.
    let mut process = started(Process { u: 1.0, t1: 10.0, t2: 4.0, dead_tm: 0.0, integ: true, ..Process::default() });
    run(&mut process, 1000.0);
    assert_close(process.pv, 1000.0 - 14.0, 1e-9);
}

#[test]
fn integrating_it_is_the_integral_of_what_it_would_be_without() {
    let of = |integ| started(Process { gain: 0.3, t1: 5.0, t2: 2.0, dead_tm: 0.73, integ, ..Process::default() });
    let (mut slope, mut process) = (of(false), of(true));
    // By Simpson's rule over cycles of 1 ms.
    (slope.cycle, process.cycle) = (Time::ms(1), Time::ms(1));
    (slope, process) = (started(slope), started(process));
    let (mut sum, mut values) = (0.0, [0.0; 3]);
    for k in 0..20_000 {
        (slope.u, process.u) = if k < 7000 { (80.0, 80.0) } else { (-30.0, -30.0) };
        slope.call();
        process.call();
        values = [values[1], values[2], slope.pv];
        if k % 2 == 1 {
            sum += (values[0] + 4.0 * values[1] + values[2]) * 0.001 / 3.0;
        }
    }
    assert_close(process.pv, sum, 1e-6);
}

#[test]
fn load_adds_to_the_manipulated_value() {
    let end = |u, load| {
        let mut process = started(Process { u, load, ..Process::default() });
        run(&mut process, 20.0);
        process.pv.to_bits()
    };
    assert_eq!(end(30.0, 10.0), end(40.0, 0.0));
    assert_eq!(end(30.0, -30.0), end(0.0, 0.0));
}

#[test]
fn the_result_does_not_depend_on_the_cycle() {
    for integ in [false, true] {
        let end = |cycle| {
            let process = Process { cycle: Time::ms(cycle), t2: 3.0, dead_tm: 2.345, integ, ..Process::default() };
            let mut process = started(process);
            let values = (0..300).map(|second| {
                process.u = f64::from(second * 37 % 101);
                process.load = f64::from(second * 13 % 11);
                run(&mut process, 1.0);
                process.pv
            });
            values.collect::<Vec<_>>()
        };
        for (coarse, fine) in end(1000).into_iter().zip(end(10)) {
            assert_close(coarse, fine, 1e-8);
        }
    }
}

#[test]
fn the_dead_time_may_be_tuned_up_to_its_longest() {
    let first_change = |dead_tm, tuned| {
        let mut process = started(Process { dead_tm, dead_max: 10.0, ..Process::default() });
        process.dead_tm = tuned;
        process.u = 100.0;
        (1..).find(|_| {
            process.call();
            process.pv > 0.0
        })
    };
    assert_eq!(first_change(5.0, 8.0), Some(81));
    assert_eq!(first_change(5.0, 1e6), Some(101), "cut to DEAD_MAX");
    assert_eq!(first_change(15.0, 15.0), Some(151), "DEAD_TM at the start is longer");
}

#[test]
fn bad_parameters_give_no_nan() {
    for integ in [false, true] {
        for bad in [0.0, -1.0] {
            let process = Process { t1: bad, t2: bad, dead_tm: bad, dead_max: bad, ..Process::default() };
            let mut process = started(Process { u: 10.0, pv_per_0: bad, pv_per_100: bad, integ, ..process });
            process.call();
            assert_close(process.pv, if integ { 1.0 } else { 10.0 }, 1e-12);
            assert_eq!(process.pv_per.value(), 0);
        }
        let mut process = started(Process { u: 10.0, t1: f64::INFINITY, t2: 1e300, integ, ..Process::default() });
        run(&mut process, 10.0);
        assert!(process.pv.is_finite());
    }
}

#[test]
fn a_dead_time_too_long_for_its_memory_is_refused() {
    assert_eq!(Process::default().check(), Ok(()));
    let error = Process { dead_tm: 1e9, ..Process::default() }.check().unwrap_err();
    assert!(error.starts_with("DEAD_TM is 1000000000 s, but "), "{error}");
    let error = Process { dead_max: 1e9, ..Process::default() }.check().unwrap_err();
    assert!(error.starts_with("DEAD_MAX is 1000000000 s, but "), "{error}");
}

#[test]
fn saved_and_read_back_it_goes_on_bit_for_bit() {
    let mut process = started(Process { dead_tm: 1.23, t2: 2.0, integ: true, ..Process::default() });
    for k in 0..100 {
        process.u = f64::from(k);
        process.call();
    }
    let mut bytes = vec![];
    process.write(&mut bytes);
    let mut again = Process::read(&mut &bytes[..]).unwrap();
    for _ in 0..100 {
        process.call();
        again.call();
        for row in 0..Process::TABLE.rows.len() {
            assert_eq!(process.get(row), again.get(row));
        }
    }
}

/// From 0 to 10, then a LOAD of 10 %: when it is within 0.2 for good, the highest value before the LOAD, and how far it
/// then went away.
fn controlled_by(controller: ContC) -> (f64, f64, f64) {
    let mut process = started(Process::default());
    let mut controller = ContC { man_on: false, sp_int: 10.0, cycle: Time::ms(100), ..controller };
    controller.restart();
    let (mut settled, mut highest, mut furthest) = (0.0, f64::MIN, 0.0_f64);
    for call in 0..2000 {
        process.load = if call < 1000 { 0.0 } else { 10.0 };
        controller.pv_in = process.pv as f32;
        controller.call();
        process.u = f64::from(controller.lmn);
        process.call();
        if call < 1000 {
            highest = highest.max(process.pv);
            if (process.pv - 10.0).abs() > 0.2 {
                settled = f64::from(call + 1) / 10.0;
            }
        } else {
            furthest = furthest.max((process.pv - 10.0).abs());
        }
    }
    (settled, highest, furthest)
}

#[test]
fn cont_c_with_the_settings_of_the_documentation_does_what_it_says() {
    let (settled, highest, furthest) = controlled_by(ContC { gain: 4.76, ti: Time::ms(8400), ..ContC::default() });
    assert!(settled < 9.0 && highest < 10.75 && furthest < 1.8, "{settled} s, up to {highest}, {furthest} away");
    assert!(settled > 8.0 && highest > 10.65 && furthest > 1.7, "{settled} s, up to {highest}, {furthest} away");
}
