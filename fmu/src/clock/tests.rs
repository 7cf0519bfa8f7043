use super::*;

fn clock(start: f64, cycle: i32) -> Clock {
    Clock::new(start, f64::INFINITY, Time::ms(cycle))
}

fn calls(clock: &mut Clock, tc: f64, h: f64) -> u64 {
    clock.advance(tc, h).unwrap().count
}

fn advanced(clock: &mut Clock, tc: f64, h: f64) -> (u64, f64) {
    let calls = clock.advance(tc, h).unwrap();
    (calls.count, calls.lead)
}

#[test]
fn a_step_of_cycle_is_one_call_and_a_step_of_ten_is_ten() {
    let mut clock = clock(0.0, 1000);
    assert_eq!(calls(&mut clock, 0.0, 1.0), 1);
    assert_eq!(calls(&mut clock, 1.0, 10.0), 10);
    assert_eq!(calls(&mut clock, 11.0, 1.0), 1);
}

#[test]
fn of_ten_steps_of_a_tenth_the_first_makes_the_call() {
    let mut clock = clock(0.0, 1000);
    let made: Vec<u64> = (0..20).map(|i| calls(&mut clock, f64::from(i) * 0.1, 0.1)).collect();
    assert_eq!(made, [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn a_call_belongs_to_the_step_that_begins_at_it_and_not_to_the_one_that_ends_there() {
    let mut clock = clock(5.0, 100);
    assert_eq!(calls(&mut clock, 5.0, 0.05), 1, "t = 5.0");
    assert_eq!(calls(&mut clock, 5.05, 0.05), 0, "t = 5.1 is the next step's");
    assert_eq!(calls(&mut clock, 5.1, 0.15), 2, "t = 5.1 and 5.2");
}

#[test]
fn two_times_within_a_millionth_of_cycle_are_one() {
    assert_eq!(calls(&mut clock(0.0, 1000), 0.0, 1.0 + 0.9e-6), 1);
    assert_eq!(calls(&mut clock(0.0, 1000), 0.0, 1.0 + 1.1e-6), 2);
    assert_eq!(calls(&mut clock(0.0, 1), 0.0, 0.001 + 0.9e-9), 1);
    assert_eq!(calls(&mut clock(0.0, 1), 0.0, 0.001 + 1.1e-9), 2);
}

#[test]
fn the_tolerance_does_not_grow_with_time() {
    // At 1e5 s a double resolves 1.5e-11 s. A step that reaches 1e-5 of a CYCLE beyond t_1 holds it.
    assert_eq!(calls(&mut clock(1e5, 100), 1e5, 0.1), 1);
    assert_eq!(calls(&mut clock(1e5, 100), 1e5, 0.1 + 1e-6), 2);
}

#[test]
fn a_step_of_0_makes_no_call_and_leaves_the_clock_where_it_is() {
    let mut clock = Clock::new(5.0, 8.0, Time::ms(1000));
    for tc in [5.0, 5.3, 7.0, 8.0] {
        assert_eq!(advanced(&mut clock, tc, 0.0), (0, 0.0), "{tc}");
        assert_eq!(clock.end(), 5.0);
    }
    assert_eq!(calls(&mut clock, 5.0, 1.0), 1);
    assert_eq!(calls(&mut clock, 6.0, 0.0), 0);
    assert_eq!(calls(&mut clock, 6.0, 2.0), 2);
    assert_eq!(calls(&mut clock, 8.0, 0.0), 0, "at the stop time");
}

#[test]
fn a_step_of_0_is_refused_where_any_other_would_be() {
    let mut clock = Clock::new(0.0, 8.0, Time::ms(1000));
    clock.advance(0.0, 5.0).unwrap();
    let mut reason = |tc, h| clock.advance(tc, h).unwrap_err().reason().to_string();
    assert!(reason(4.9, 0.0).contains("before 5.0"));
    assert!(reason(8.1, 0.0).contains("stopTime"));
    assert!(reason(f64::NAN, 0.0).contains("must be finite"));
    assert!(reason(5.0, -1e-300).contains("not negative"));
}

#[test]
fn residual_steps_make_no_call_and_lose_none() {
    let mut clock = clock(0.0, 1000);
    for k in 0..100 {
        let t = f64::from(k);
        assert_eq!(calls(&mut clock, t, 1.0), 1, "call {k}");
        assert_eq!(calls(&mut clock, t + 1.0, 1e-16), 0, "residual step after call {k}");
    }
}

#[test]
fn a_host_that_adds_up_its_time_gets_one_call_in_every_step() {
    // 0.01 s added a million times is 10000.000000171856: 17 times the tolerance.
    let mut clock = clock(0.0, 10);
    let mut tc = 0.0;
    for k in 0..1_000_000 {
        assert_eq!(calls(&mut clock, tc, 0.01), 1, "step {k} at {tc:?}");
        tc += 0.01;
    }
    assert_eq!(tc, 10_000.000000171856);
}

#[test]
fn a_host_that_adds_up_steps_of_a_tenth_of_cycle_gets_the_call_in_the_first_of_ten() {
    // 0.001 s added 3 million times is 3000.000000152431: 15 times the tolerance.
    let mut clock = clock(0.0, 10);
    let mut tc = 0.0;
    for k in 0..3_000_000 {
        assert_eq!(calls(&mut clock, tc, 0.001), u64::from(k % 10 == 0), "step {k} at {tc:?}");
        tc += 0.001;
    }
    assert_eq!(tc, 3000.000000152431);
}

#[test]
fn a_point_that_is_off_by_rounding_leaves_the_clock_at_its_tick() {
    // 6 * 0.1 is 0.6000000000000001, and 5 * 0.1 + 0.1 is 0.6.
    let mut clock = clock(0.0, 100);
    for k in 0..1000 {
        assert_eq!(calls(&mut clock, f64::from(k) * 0.1, 0.1), 1);
        assert_eq!((clock.tick, clock.offset), (i64::from(k) + 1, 0.0));
    }
}

#[test]
fn a_host_that_adds_up_steps_of_two_cycles_gets_two_calls_in_every_step() {
    // 0.02 s added half a million times is 10000.000000125436: 12 times the tolerance.
    let mut clock = clock(0.0, 10);
    let mut tc = 0.0;
    for k in 0..500_000 {
        assert_eq!(calls(&mut clock, tc, 0.02), 2, "step {k} at {tc:?}");
        tc += 0.02;
    }
    assert_eq!(tc, 10_000.000000125436);
}

#[test]
fn no_more_than_a_quarter_of_a_cycle_counts_as_rounding() {
    // At 1e9 s a double has steps of 1.19e-7 s: 0.001 added is 0.00100004673 added, 0.07 is 0.0700000525. A quarter of
    // CYCLE is reached after 5350 and 47 700 additions; the host is followed then, and one step makes a call more.
    for (cycle, h, calls_of_h, after) in [(1, 0.001, 1, 5_350..5_400), (10, 0.07, 7, 47_600..47_800)] {
        let (mut clock, mut tc) = (clock(1e9, cycle), 1e9);
        let mut odd = Vec::new();
        for step in 0..after.end + 2_000 {
            let made = calls(&mut clock, tc, h);
            tc += h;
            if made != calls_of_h {
                odd.push((step, made));
            }
        }
        assert!(odd.len() == 1 && after.contains(&odd[0].0) && odd[0].1 == calls_of_h + 1, "{h:?}: {odd:?}");
    }
}

#[test]
fn a_host_that_creeps_ahead_is_followed_when_it_is_a_millionth_of_a_cycle_ahead() {
    // Each step begins 0.9e-6 s after the end of the last one: the third begins at 2.0000018 and holds t = 2 and 3.
    let mut clock = clock(0.0, 1000);
    let made = [0.0, 1.0000009, 2.0000018].map(|tc| calls(&mut clock, tc, 1.0));
    assert_eq!(made, [1, 1, 2]);
}

#[test]
fn a_host_that_goes_back_over_a_call_within_the_tolerance_does_not_get_it_again() {
    let mut clock = clock(0.0, 1000);
    assert_eq!(calls(&mut clock, 0.0, 1.0000015), 2, "t = 0 and 1");
    assert_eq!(calls(&mut clock, 1.0000006, 1e-12), 0, "0.9e-6 s back, which is no difference");
    assert_eq!(calls(&mut clock, 1.0000006, 1.0), 0, "t = 1 is made, t = 2 is the next step's");
    assert_eq!(calls(&mut clock, 2.0000006, 1.0), 1, "t = 2");
}

#[test]
fn a_host_does_not_get_back_by_many_steps_that_are_each_within_the_tolerance() {
    let mut clock = clock(0.0, 1000);
    calls(&mut clock, 0.0, 3.0);
    assert_eq!(calls(&mut clock, 3.0 - 0.9e-6, 1e-12), 0);
    assert_eq!(clock.end(), 3.0, "the furthest");
    let refusal = clock.advance(3.0 - 1.8e-6, 1e-12).unwrap_err();
    assert!(refusal.reason().contains("2.9999982 is before 3.0"), "{}", refusal.reason());
}

#[test]
fn a_step_that_is_a_hair_too_long_makes_one_call_where_the_host_computes_its_points_anew() {
    // 0.1 as a 32-bit float is 0.10000000149: 1.5e-8 of a CYCLE in every step, a tolerance in 67 of them.
    for start in [0.0, 1e5, 1e7] {
        let mut clock = clock(start, 100);
        for k in 0..10_000 {
            let tc = start + f64::from(k) * 0.1;
            assert_eq!(calls(&mut clock, tc, f64::from(0.1f32)), 1, "from {start:?}, step {k}");
        }
    }
}

#[test]
fn a_host_that_adds_its_own_time_to_the_start_gets_one_call_in_every_step() {
    // 0.01 s added a million times is 10000.000000171856: 17 times the tolerance. The same after a jump.
    for ahead in [0.0, 1000.0] {
        let (start, mut clock) = (1e5, clock(1e5, 10));
        assert_eq!(calls(&mut clock, start, 0.01), 1);
        let mut since = ahead + 0.01;
        assert_eq!(calls(&mut clock, start + since, 0.01), 1 + (ahead * 100.0) as u64);
        since += 0.01;
        for k in 2..1_000_000 {
            assert_eq!(calls(&mut clock, start + since, 0.01), 1, "step {k} at {since:?} s since the start");
            since += 0.01;
        }
        assert!((since - ahead - 10_000.0).abs() > 1e-7, "{since:?}");
    }
}

#[test]
fn an_ordinary_step_is_one_of_cycle_from_a_tick_where_nothing_is_near() {
    let at_a_tick = || {
        let mut clock = Clock::new(1234.5, 1244.5, Time::ms(1000));
        calls(&mut clock, 1234.5, 2.0);
        clock
    };
    let ordinary = |change: fn(&mut Clock)| {
        let mut clock = at_a_tick();
        change(&mut clock);
        clock.is_ordinary(clock.end, 1.0)
    };
    assert!(ordinary(|_| ()));
    assert!(!at_a_tick().is_ordinary(1236.6, 1.0), "not from where the last step ended");
    assert!(!at_a_tick().is_ordinary(1236.5, 1.5));
    assert!(!ordinary(|clock| clock.offset = 500.0));
    assert!(!ordinary(|clock| clock.next += 1));
    // The stop time lies at tick 10.
    assert!(ordinary(|clock| (clock.tick, clock.next, clock.end) = (7, 7, 1241.5)));
    assert!(!ordinary(|clock| (clock.tick, clock.next, clock.end) = (8, 8, 1242.5)));
    // A host that has drifted by a quarter of a CYCLE.
    assert!(ordinary(|clock| clock.end += 0.2) && ordinary(|clock| clock.end -= 0.2));
    assert!(!ordinary(|clock| clock.end += 0.25) && !ordinary(|clock| clock.end -= 0.25));
    // Where a double is coarse.
    let resolved = 100.0 / (ROUNDINGS * RESOLUTION);
    assert!(clock(resolved * 0.99, 1000).is_ordinary(resolved * 0.99, 1.0));
    assert!(!clock(resolved, 1000).is_ordinary(resolved, 1.0));
    assert!(!clock(-resolved, 1000).is_ordinary(-resolved, 1.0));
}

#[test]
fn a_call_that_was_made_is_not_made_again_in_an_ordinary_step() {
    let mut clock = clock(0.0, 1000);
    calls(&mut clock, 0.0, 2.0);
    // As where the clock was ahead of a host that adds up, and has been led back to t = 2.
    clock.next = 3;
    assert_eq!(calls(&mut clock, 2.0, 1.0), 0, "t = 2");
    assert_eq!(calls(&mut clock, 3.0, 1.0), 1, "t = 3");
}

#[test]
fn the_end_is_that_of_the_last_step_as_the_host_counts_and_the_start_before_it() {
    let mut clock = clock(5.0, 1000);
    assert_eq!(clock.end(), 5.0);
    calls(&mut clock, 5.0, 2.5);
    assert_eq!(clock.end(), 7.5);
}

#[test]
fn a_host_that_really_is_ahead_is_followed_and_the_calls_in_between_are_made() {
    let mut clock = clock(0.0, 1000);
    assert_eq!(advanced(&mut clock, 0.0, 1.0), (1, 0.0));
    // Calls 1, 2 and 3 are late by 2.5, 1.5 and 0.5 s; the step itself holds call 4, 0.5 s after its begin.
    assert_eq!(advanced(&mut clock, 3.5, 1.0), (4, -2.5));
    assert_eq!((clock.tick, clock.offset), (4, 500.0), "4.5 s are four CYCLEs and 500 ms");
    assert_eq!(advanced(&mut clock, 4.5, 1.0), (1, 0.5));
}

#[test]
fn a_host_a_tenth_of_a_cycle_ahead_is_followed_too() {
    let mut clock = clock(0.0, 1000);
    calls(&mut clock, 0.0, 1.0);
    assert_eq!(advanced(&mut clock, 1.1, 1.0), (2, -0.1));
}

#[test]
fn a_host_that_has_drifted_by_rounding_is_still_followed_when_it_jumps() {
    let mut clock = clock(1e6, 1);
    let mut tc = 1e6;
    for _ in 0..2_000_000 {
        clock.advance(tc, 0.001).unwrap();
        tc += 0.001;
    }
    assert_eq!(calls(&mut clock, tc + 0.0001, 0.001), 2, "0.1 ms ahead: the call due and the one 0.9 ms later");
}

#[test]
fn a_long_step_neither_loses_nor_doubles_a_call() {
    // 49.7 days in one step of 4 294 967 295 calls: h * 1000 / CYCLE is off by half a millionth of a CYCLE.
    assert_eq!(calls(&mut clock(0.0, 1), 0.0, 4_294_967.295), 4_294_967_295);
    assert_eq!(calls(&mut clock(0.0, 7), 0.0, 7.0 * 0.001 * 4_000_000_001.0), 4_000_000_001);
    // As many calls as there may be, off by 1.4 millionths of a CYCLE.
    assert_eq!(calls(&mut clock(0.0, 3950), 0.0, 4_294_960_009.0 * 0.001 * 3950.0), 4_294_960_009);
}

#[test]
fn a_state_that_no_step_leads_to_is_not_restored() {
    let restore = |change: fn(&mut Clock)| {
        let mut clock = clock(0.0, 1000);
        calls(&mut clock, 0.0, 10.5);
        change(&mut clock);
        let mut bytes = Vec::new();
        clock.write(&mut bytes);
        Clock::read(&mut &bytes[..]).is_some()
    };
    assert!(restore(|_| ()));
    assert!(restore(|clock| clock.offset = 1900.0), "less than two CYCLEs beside a tick");
    assert!(!restore(|clock| clock.offset = 2100.0));
    assert!(!restore(|clock| clock.next = 0));
    assert!(!restore(|clock| clock.next += 2));
    assert!(!restore(|clock| clock.tick = i64::MAX));
    assert!(!restore(|clock| clock.tick = -1));
    assert!(!restore(|clock| clock.offset = 1e9));
    assert!(!restore(|clock| clock.offset = f64::NAN));
    assert!(!restore(|clock| clock.cycle = -1.0));
    assert!(!restore(|clock| clock.start = f64::NAN));
    assert!(!restore(|clock| clock.end = f64::INFINITY));
    assert!(!restore(|clock| clock.since = f64::INFINITY));
    assert!(!restore(|clock| clock.stop = f64::NAN));
}

#[test]
fn a_host_behind_by_more_than_rounding_is_refused_with_both_numbers() {
    let mut clock = clock(0.0, 1000);
    calls(&mut clock, 0.0, 1.0);
    let refusal = clock.advance(0.999, 1.0).unwrap_err();
    let error = refusal.reason();
    assert!(error.contains("= 0.999 ") && error.contains(" 1.0,"), "{error}");
    assert_eq!(calls(&mut clock, 1.0 - 1e-12, 1.0), 1, "and by rounding is not");
}

#[test]
fn points_and_steps_that_are_no_times_are_refused() {
    for h in [-5e-324, -1.0, f64::NAN, f64::INFINITY] {
        let refusal = clock(0.0, 1000).advance(0.0, h).unwrap_err();
        assert!(refusal.reason().contains(&format!("{h:?}: the point must be finite, the step finite")), "{h}");
    }
    for tc in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let refusal = clock(0.0, 1000).advance(tc, 1.0).unwrap_err();
        assert!(refusal.reason().contains(&format!("{tc:?}, communicationStepSize = 1.0: the point must be finite")));
    }
}

#[test]
fn the_stop_time_can_be_reached_by_adding_up_but_not_be_passed() {
    // 0.1 s added 100 000 times is 10000.000000018848.
    let mut clock = Clock::new(0.0, 10_000.0, Time::ms(100));
    let mut tc = 0.0;
    for _ in 0..100_000 {
        assert_eq!(calls(&mut clock, tc, 0.1), 1);
        tc += 0.1;
    }
    assert!(tc > 10_000.000000018);
    assert!(clock.advance(tc, 0.1).unwrap_err().reason().contains("10000.0"));
    assert!(Clock::new(0.0, 1.0, Time::ms(100)).advance(0.0, 1.001).is_err());
}

#[test]
fn the_call_at_the_stop_time_is_not_made() {
    // Calls at 0.0, 0.1, ..., 0.9; the one at 1.0 = stopTime belongs to a step after it. Up to 1e-7 s beyond, a step
    // still ends at the stop time.
    let mut clock = Clock::new(0.0, 1.0, Time::ms(100));
    assert_eq!(calls(&mut clock, 0.0, 1.0 + 0.9e-7), 10);
    assert_eq!((clock.tick, clock.next), (10, 10));
    assert!(clock.offset.abs() < 1e-12, "not beyond: {} ms", clock.offset);
}

#[test]
fn the_stop_time_is_counted_from_0_and_not_from_the_start() {
    let clock = || Clock::new(5.0, 6.0, Time::ms(100));
    assert_eq!(calls(&mut clock(), 5.0, 1.0), 10);
    assert!(clock().advance(5.0, 1.001).unwrap_err().reason().contains("stopTime = 6.0"));
}

#[test]
fn a_step_reaches_the_stop_time_by_the_hosts_own_time_where_that_is_behind() {
    // 0.01 s added 3 million times is 29999.999998131676, 187 times the tolerance less than the clock has counted: the
    // host makes up for it in a step of its own.
    let mut clock = Clock::new(0.0, 30_000.0, Time::ms(10));
    let mut tc = 0.0;
    for _ in 0..3_000_000 {
        assert_eq!(calls(&mut clock, tc, 0.01), 1);
        tc += 0.01;
    }
    assert_eq!(tc, 29_999.999998131676);
    assert!(clock.clone().advance(tc, 0.01).is_err());
    assert_eq!(calls(&mut clock, tc, 30_000.0 - tc), 0);
}

#[test]
fn calls_made_before_do_not_count_towards_the_most_that_a_step_may_hold() {
    let mut clock = clock(0.0, 1);
    assert_eq!(calls(&mut clock, 0.0, 3e6), 3_000_000_000);
    assert_eq!(calls(&mut clock, 3e6, 2e6), 2_000_000_000);
    assert_eq!(calls(&mut clock, 5e6, 4_294_967.296), 4_294_967_296, "as many as it may hold");
}

#[test]
fn a_day_in_one_step_makes_every_call_and_an_endless_step_is_refused() {
    assert_eq!(calls(&mut clock(0.0, 1), 0.0, 86_400.0), 86_400_000);
    assert!(clock(0.0, 1).advance(0.0, 4.3e6).unwrap_err().reason().contains("4294967296"));
    assert!(clock(0.0, 1).advance(4.3e6, 1.0).unwrap_err().reason().contains("4294967296"), "nor an endless way to it");
    assert!(clock(0.0, 1000).advance(0.0, 1e300).is_err());
}

#[test]
fn where_a_double_no_longer_tells_the_calls_apart_a_step_is_refused() {
    // 1 ms: the bound lies at 2^47 ms = 1.4e11 s.
    assert_eq!(calls(&mut clock(1e11, 1), 1e11, 1.0), 1000);
    for (start, tc) in [(2e11, 2e11), (0.0, 2e11), (-2e11, 0.0)] {
        let refusal = clock(start, 1).advance(tc, 1.0).unwrap_err();
        assert!(refusal.reason().contains("no longer distinguishes"), "from {start} at {tc}: {}", refusal.reason());
    }
}

#[test]
fn a_refused_step_leaves_the_clock_where_it_was() {
    let mut clock = Clock::new(0.0, 10.0, Time::ms(1000));
    calls(&mut clock, 0.0, 1.5);
    let mut before = Vec::new();
    clock.write(&mut before);
    for (tc, h) in [(0.5, 1.0), (1.5, -1.0), (1.5, 100.0), (f64::NAN, 1.0)] {
        clock.advance(tc, h).unwrap_err();
    }
    let mut after = Vec::new();
    clock.write(&mut after);
    assert_eq!(before, after);
}

#[test]
fn a_step_of_a_cycle_that_begins_beside_a_tick_is_no_ordinary_one() {
    // A step of 4e9 calls may be off by 3.6e-6 of a CYCLE of its own, on top of 2.8e-6 at 2e6 s: the call at its end is
    // the next step's. That one begins 4.2e-6 of a CYCLE after it, and holds the one after as well.
    let mut clock = clock(-2e6, 1);
    let long = 4_000_000.000000004;
    assert_eq!(calls(&mut clock, -2e6, long), 4_000_000_000);
    assert_eq!(clock.next, clock.tick);
    let mut checked = clock.clone();
    let end = clock.end();
    assert_eq!(checked.check_and_advance(end, 0.001).unwrap().count, 2);
    assert_eq!(calls(&mut clock, end, 0.001), 2);
}

#[test]
fn the_ordinary_step_ends_two_cycles_before_the_stop_time_and_where_rounding_is_a_tenth_of_a_cycle() {
    // Four roundings of t: 4 * 2^-52 * t = 0.1 * CYCLE, that is t = 0.1 * 2^50 * CYCLE.
    let reach = 0.1 * 2f64.powi(50);
    assert!((clock(0.0, 1000).horizon / reach - 1.0).abs() < 1e-12);
    assert!((clock(0.0, 10).horizon / (reach * 0.01) - 1.0).abs() < 1e-12);
    assert_eq!(Clock::new(0.0, 10.0, Time::ms(100)).horizon, 9.8);
    assert_eq!(clock(-2e14, 1000).horizon, f64::NEG_INFINITY, "the start is farther from 0 than that");
}

#[test]
fn floor_and_ceil_are_those_of_a_number_of_cycles() {
    assert_eq!([2.0, 2.5, 3.0].map(floor), [2, 2, 3]);
    assert_eq!([2.0, 2.5, 3.0].map(ceil), [2, 3, 3]);
    assert_eq!([-0.25, 0.0].map(|rounding| (floor(rounding), ceil(rounding))), [(0, 0); 2]);
}

#[test]
fn the_ordinary_step_comes_to_the_same_as_the_checked_one() {
    let mut known_before = 0;
    for (start, stop, cycle) in [
        (0.0, f64::INFINITY, 1),
        (1234.5, 1300.0, 10),
        (-1e5, f64::INFINITY, 100),
        (1e9, f64::INFINITY, 1),
        // Where roundings add up to the drift that is allowed, and beyond.
        (1e8, f64::INFINITY, 1),
        (-2e8, f64::INFINITY, 1),
        (3e8, 3e8 + 4.0, 1),
    ] {
        let mut ordinary = Clock::new(start, stop, Time::ms(cycle));
        let mut checked = ordinary.clone();
        for _ in 0..20_000 {
            let (tc, h) = (ordinary.end, ordinary.period);
            let expected = checked.check_and_advance(tc, h);
            let calls = if ordinary.make_ordinary_step(tc, h) {
                known_before += 1;
                Ok(Calls { count: 1, lead: 0.0 })
            } else {
                ordinary.advance(tc, h)
            };
            let same = match (&calls, &expected) {
                (Ok(calls), Ok(expected)) => calls == expected,
                (Err(refusal), Err(expected)) => refusal.reason() == expected.reason(),
                _ => false,
            };
            assert!(same, "{start} {cycle} at {tc}: {calls:?} and {expected:?}");
        }
        let bytes = |clock: &Clock| {
            let mut bytes = Vec::new();
            clock.write(&mut bytes);
            bytes
        };
        assert_eq!(bytes(&ordinary), bytes(&checked), "{start} {cycle}");
    }
    assert!(known_before > 50_000, "{known_before} steps of 140 000 were known to be ordinary");
}

#[test]
fn a_step_between_two_events_comes_to_the_same_as_the_checked_one() {
    let bytes = |clock: &Clock| {
        let mut bytes = Vec::new();
        clock.write(&mut bytes);
        bytes
    };
    for computes_anew in [false, true] {
        for (start, stop, cycle) in [
            (0.0, f64::INFINITY, 1),
            (0.0, 100.0, 10),
            (1234.5, f64::INFINITY, 20),
            (-1e5, f64::INFINITY, 100),
            (1e8, f64::INFINITY, 1),
            // 1.001 * 1000 is not 1001.
            (0.0, f64::INFINITY, 1001),
        ] {
            let mut ordinary = Clock::new(start, stop, Time::ms(cycle));
            let mut checked = ordinary.clone();
            let mut count = 0;
            for k in 0..5_000 {
                let tc = if computes_anew { start + f64::from(k) * ordinary.period } else { ordinary.end };
                let h = ordinary.period;
                assert_eq!(ordinary.make_due_call().unwrap(), checked.make_due_call().unwrap());
                let expected = checked.check_and_advance(tc, h).unwrap().count;
                if ordinary.make_step_between_calls(tc, h) {
                    assert_eq!(expected, 0, "the call at the begin is made");
                    count += 1;
                } else {
                    assert_eq!(ordinary.check_and_advance(tc, h).unwrap().count, expected);
                }
                assert_eq!(bytes(&ordinary), bytes(&checked), "{start} {cycle}, step {k}");
            }
            let is_ordinary = if cycle == 1001 { count == 0 } else { count > 4_900 };
            assert!(is_ordinary, "{start} {cycle}: {count} of 5000 were ordinary");
        }
    }
}

#[test]
fn only_a_step_from_a_call_that_was_made_is_one_between_two_events() {
    let mut clock = clock(0.0, 1000);
    assert!(!clock.make_step_between_calls(0.0, 1.0), "the call at the start is due");
    assert!(clock.make_due_call().unwrap());
    assert!(!clock.make_step_between_calls(0.0, 0.5) && !clock.make_step_between_calls(0.5, 1.0));
    assert!(clock.make_step_between_calls(0.0, 1.0));
    assert!((clock.end(), clock.next_call(), clock.is_due()) == (1.0, 1.0, true));
}

#[test]
fn steps_of_a_host_that_computes_its_points_anew_are_ordinary_and_come_to_the_same_as_checked_ones() {
    for (start, stop, cycle) in [
        (0.0, f64::INFINITY, 100),
        (0.0, 100.0, 10),
        (1234.5, f64::INFINITY, 20),
        (-1e5, f64::INFINITY, 100),
        (1e7, f64::INFINITY, 10),
    ] {
        let mut ordinary = Clock::new(start, stop, Time::ms(cycle));
        let mut checked = ordinary.clone();
        let (steps, h) = (20_000, ordinary.period);
        let mut others = 0;
        for k in 0..steps {
            let tc = start + f64::from(k) * h;
            let expected = checked.check_and_advance(tc, h).map_err(|refusal| refusal.reason().to_string());
            let calls = if ordinary.make_ordinary_step(tc, h) || ordinary.check_and_make_ordinary_step(tc, h) {
                Ok(Calls { count: 1, lead: 0.0 })
            } else {
                others += 1;
                ordinary.advance(tc, h).map_err(|refusal| refusal.reason().to_string())
            };
            assert_eq!(calls, expected, "{start} {cycle} at {tc}");
        }
        let bytes = |clock: &Clock| {
            let mut bytes = Vec::new();
            clock.write(&mut bytes);
            bytes
        };
        assert_eq!(bytes(&ordinary), bytes(&checked), "{start} {cycle}");
        // Two before the stop time, and all behind it.
        let behind = if stop < f64::INFINITY { steps - 10_000 + 2 } else { 0 };
        assert!((behind..=behind + 1).contains(&others), "{start} {cycle}: {others}");
    }
}

#[test]
fn a_point_beside_a_tick_or_no_number_is_not_at_it() {
    let mut clock = clock(0.0, 100);
    calls(&mut clock, 0.0, 0.1);
    assert!(clock.is_at_tick(0.1) && clock.is_at_tick(0.1 + 2e-17));
    for tc in [0.1 + 1e-15, 0.1 - 1e-15, 0.2, 0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(!clock.is_at_tick(tc), "{tc:?}");
    }
    // 1.001 * 1000 is not 1001: the checked step keeps what is left.
    assert!(!Clock::new(5.0, f64::INFINITY, Time::ms(1001)).is_at_tick(5.0));
}

#[test]
fn steps_are_known_to_be_ordinary_as_long_as_the_host_makes_no_other() {
    let mut clock = clock(0.0, 1000);
    assert!(!clock.make_ordinary_step(0.0, 1.0), "not before the first one");
    calls(&mut clock, 0.0, 1.0);
    assert!(clock.make_ordinary_step(1.0, 1.0));
    assert!(!clock.make_ordinary_step(2.5, 1.0) && !clock.make_ordinary_step(2.0, 0.5));
    assert_eq!(calls(&mut clock, 2.0, 2.0), 2);
    assert!(!clock.make_ordinary_step(4.0, 1.0), "it has to be looked at again");
    calls(&mut clock, 4.0, 1.0);
    assert!(clock.make_ordinary_step(5.0, 1.0));
}

#[test]
fn no_step_is_known_to_be_ordinary_near_the_stop_time_or_where_roundings_may_add_up_to_the_drift() {
    let known = |clock: Clock| {
        let mut clock = clock;
        let (tc, h) = (clock.end, clock.period);
        calls(&mut clock, tc, h);
        clock.ordinary_below > clock.tick
    };
    assert!(known(Clock::new(0.0, 1100.0, Time::ms(1000))));
    assert!(!known(Clock::new(0.0, 1000.0, Time::ms(1000))));
    // 1001 steps, 4 roundings each: 4004 * 2^-52 * t = 0.225 * CYCLE at t = 2.5e8 s for 1 ms.
    assert!(known(clock(2e8, 1)) && known(clock(-2e8, 1)));
    assert!(!known(clock(3e8, 1)) && !known(clock(-3e8, 1)));
}

#[test]
fn an_event_so_far_from_0_that_calls_cannot_be_told_apart_is_refused() {
    // 2^53 ms: there, a double steps by a millisecond, four of which may lie between two times that are one.
    let mut clock = Clock::new(9_007_199_254_740.992, f64::INFINITY, Time::ms(1));
    let refusal = clock.make_due_call().unwrap_err();
    assert!(refusal.reason().starts_with("the time = 9007199254740.992: this far from 0"), "{}", refusal.reason());
    let mut clock = Clock::new(0.0, f64::INFINITY, Time::ms(1));
    assert_eq!([clock.make_due_call().unwrap(), clock.make_due_call().unwrap()], [true, false]);
}
