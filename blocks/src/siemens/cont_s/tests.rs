//! The clauses of CONT_S, and what its texts claim.

use super::*;
use crate::table::{Block, Word};

fn restarted(mut block: ContS) -> ContS {
    block.restart();
    block
}

/// The pulse of the last call as a letter: Up, Down or none.
fn letter(block: &ContS) -> char {
    match (block.qlmnup, block.qlmndn) {
        (true, true) => '!',
        (true, false) => 'U',
        (false, true) => 'D',
        (false, false) => '.',
    }
}

/// One letter a call; `before` is shown the number of each call, from 1 on, and may set inputs.
fn pulses_with(block: &mut ContS, calls: usize, before: impl Fn(usize, &mut ContS)) -> String {
    let call = |number| {
        before(number, block);
        block.call();
        letter(block)
    };
    (1..=calls).map(call).collect()
}

fn pulses(block: &mut ContS, calls: usize) -> String {
    pulses_with(block, calls, |_, _| ())
}

/// Without I action, minimum times of a call, 10 % a call: the valve follows e.
fn position_only() -> ContS {
    ContS {
        gain: 1.0,
        deadb_w: 0.0,
        ti: Time::ms(0),
        mtr_tm: Time::ms(10_000),
        pulse_tm: Time::ms(1_000),
        break_tm: Time::ms(1_000),
        ..ContS::default()
    }
}

/// As above, but 1 % a call and with thresholds from 1 % on.
fn slow_motor() -> ContS {
    ContS { mtr_tm: Time::ms(100_000), ..position_only() }
}

/// Fine pulses: 0.1 s of 30 s.
fn pi(e: Real) -> ContS {
    ContS {
        gain: 1.0,
        deadb_w: 0.0,
        cycle: Time::ms(100),
        pulse_tm: Time::ms(100),
        break_tm: Time::ms(100),
        sp_int: e,
        ..ContS::default()
    }
}

fn manual() -> ContS {
    ContS { lmns_on: true, ..ContS::default() }
}

#[test]
fn clause_1_a_restart_cuts_a_pulse_at_once_and_clears_all_outputs() {
    let mut block = restarted(ContS { sp_int: 11.0, pv_in: -3.0, ..ContS::default() });
    assert_eq!(pulses(&mut block, 1), "U");
    block.com_rst = true;
    block.call();
    assert_eq!((block.qlmnup, block.qlmndn, block.pv, block.er), (false, false, 0.0, 0.0));
    assert_eq!(block.memory.pulse_left, 0);
}

#[test]
fn clause_1_after_a_restart_no_break_has_to_pass() {
    let run = |calls_before| {
        let mut block = ContS { sp_int: 11.0, ..ContS::default() };
        pulses(&mut block, calls_before);
        block.restart();
        pulses(&mut block, 60)
    };
    assert_eq!(run(8), run(0));
}

#[test]
fn clause_1_while_com_rst_is_true_every_call_is_a_restart() {
    let mut block = restarted(ContS { sp_int: 11.0, com_rst: true, ..ContS::default() });
    assert_eq!(pulses(&mut block, 3), "...");
    assert!(block.com_rst);
}

#[test]
fn clause_2_process_value_and_error_are_made_as_in_cont_c() {
    let mut block = ContS { pv_in: 7.0, pv_per: Word::new(13824), pv_fac: 4.0, pv_off: -50.0, ..ContS::default() };
    block.call();
    assert_eq!((block.pv, block.er), (7.0, -6.0));
    block.pvper_on = true;
    block.call();
    assert_eq!((block.pv, block.er), (150.0, -149.0));
}

#[test]
fn clause_3_a_motor_time_below_a_cycle_counts_as_a_cycle() {
    // The valve moves 100 % a call; 55 % is the off threshold.
    let travel = |mtr_tm| {
        let block = ContS { sp_int: 160.0, mtr_tm: Time::ms(mtr_tm), ti: Time::ms(1_000_000), ..position_only() };
        pulses(&mut restarted(block), 5)
    };
    assert_eq!(travel(1_000), "UU...");
    assert_eq!(travel(0), "UU...");
}

#[test]
fn clause_3_a_reset_time_below_half_a_cycle_counts_as_half_a_cycle() {
    let integral = |ti| {
        let mut block = restarted(ContS { sp_int: 0.1, ti: Time::ms(ti), ..slow_motor() });
        block.call();
        block.memory.f
    };
    assert_eq!(integral(1), integral(500));
    // Te = 0.5 s - 0.01 * 0.1 * 100 s
    assert!((integral(500) + 0.1 / 0.4).abs() < 1e-6);
}

#[test]
fn clause_4_the_first_pulse_takes_the_valve_as_far_as_the_p_action_asks() {
    // e % of 30 s in calls of 0.1 s
    for (e, calls) in [(1.0, 3), (5.0, 15), (20.0, 60)] {
        let first = pulses(&mut restarted(pi(e)), 100);
        assert_eq!(first.find('.'), Some(calls), "e {e}: {first}");
    }
}

#[test]
fn clause_4_between_pulses_the_valve_moves_at_the_rate_of_the_i_action() {
    for e in [1.0, 5.0, 20.0, -5.0] {
        let run = pulses(&mut restarted(pi(e)), 400_000);
        let up = |letter: &u8| *letter != b'.';
        let letters = run.as_bytes();
        let starts: Vec<_> = (1..letters.len()).filter(|&k| up(&letters[k]) && !up(&letters[k - 1])).collect();
        let (first, last) = (starts[0], starts[starts.len() - 1]);
        let travel = letters[first..last].iter().filter(|letter| up(letter)).count() as f64 * (100.0 * 0.1 / 30.0);
        let rate = travel / ((last - first) as f64 * 0.1);
        let ideal = f64::from(e).abs() / 20.0;
        assert!((rate / ideal - 1.0).abs() < 2e-4, "e {e}: {rate} % a second, not {ideal}");
    }
}

#[test]
fn clause_4_the_time_of_the_first_pulse_is_not_made_up() {
    // e^2 MTR_TM / (100 TI) = 6 % behind 20 (1 + t / 20), give or take a pulse.
    let calls = 400_000;
    let run = pulses(&mut restarted(pi(20.0)), calls);
    let travel = run.matches('U').count() as f64 * (100.0 * 0.1 / 30.0);
    let behind = 20.0 * (1.0 + calls as f64 * 0.1 / 20.0) - travel;
    assert!((behind - 6.0).abs() < 10.0, "{behind} %");
}

#[test]
fn clause_4_the_defaults_with_a_setpoint_of_11() {
    let run = pulses(&mut restarted(ContS { sp_int: 11.0, ..ContS::default() }), 60);
    assert_eq!(run, "UUUUUU......UUU.......UUU.......UUU.......UUU.......UUU.....");
}

#[test]
fn clause_4_the_defaults_with_a_setpoint_of_minus_6() {
    let run = pulses(&mut restarted(ContS { sp_int: -6.0, ..ContS::default() }), 40);
    assert_eq!(run, "DDD................DDD.................D");
}

#[test]
fn clause_4_a_large_error_shortens_the_reset_time_to_a_tenth_at_most() {
    // 0.01 * 50 * 30 s leaves 5 s of 20; 0.01 * 500 * 30 s would leave less than nothing.
    let slope = |e: Real| {
        let mut block = restarted(ContS { lmnr_hs: true, sp_int: -e, ..pi(0.0) });
        block.call();
        block.memory.f
    };
    assert!((slope(50.0) - 50.0 * 0.1 / 5.0).abs() < 1e-5);
    assert!((slope(500.0) - 500.0 * 0.1 / 2.0).abs() < 1e-4);
}

#[test]
fn clause_4_every_operation_rounds_in_the_order_of_the_formulas() {
    // In another order the last digit is another: -0.35275745, and 0.043478258 for the pulse.
    let (cycle, mtr_tm, ti) = (Time::ms(700), Time::ms(41_000), Time::ms(17_000));
    let mut block = restarted(ContS { cycle, mtr_tm, ti, ..pi(7.1) });
    block.call();
    assert_eq!(block.memory.f, -0.35275742);

    for ti in [0, 20_000] {
        let (cycle, mtr_tm, ti) = (Time::ms(10), Time::ms(23_000), Time::ms(ti));
        let mut block = restarted(ContS { cycle, mtr_tm, ti, lmnup: true, ..manual() });
        block.call();
        block.lmns_on = false;
        block.call();
        assert_eq!(block.memory.f, 0.04347826);
    }
}

#[test]
fn clause_5_the_error_is_not_integrated_against_a_reported_stop() {
    let integral = |sp_int, lmnr_hs, lmnr_ls| {
        let mut block = restarted(ContS { sp_int, lmnr_hs, lmnr_ls, ..pi(0.0) });
        block.call();
        block.memory.f
    };
    assert_eq!(integral(5.0, true, false), 0.0);
    assert_eq!(integral(-5.0, false, true), 0.0);
    assert!(integral(5.0, false, true) < 0.0);
    assert!(integral(-5.0, true, false) > 0.0);
}

#[test]
fn clause_6_manual_mode_holds_the_integrator_at_0_so_that_the_change_back_bumps() {
    let mut block = restarted(ContS { sp_int: 11.0, ..ContS::default() });
    assert_eq!(pulses(&mut block, 12), "UUUUUU......");
    let automatic = pulses(&mut block.clone(), 1);
    block.lmns_on = true;
    block.call();
    assert_eq!(block.memory.f, 0.0);
    block.lmns_on = false;
    // At rest it would have made one short pulse; now it goes all the way again.
    assert_eq!((automatic.as_str(), pulses(&mut block, 8).as_str()), ("U", "UUUUUU.."));
}

#[test]
fn clause_7_without_i_action_the_valve_goes_to_e_and_rests() {
    let run = pulses(&mut restarted(ContS { sp_int: 40.0, ..position_only() }), 30);
    assert_eq!(run, "UUUU..........................");
}

#[test]
fn clause_7_without_i_action_the_assumed_position_stays_within_0_and_100_percent() {
    // From 0 it cannot go down, and at 100 it does not reach 150: the pulse lasts until a stop is reported.
    for (setpoint, letter) in [(-40.0, "D"), (150.0, "U")] {
        let mut block = restarted(ContS { sp_int: setpoint, ..position_only() });
        assert_eq!(pulses(&mut block, 40), letter.repeat(40));
    }
}

#[test]
fn clause_7_a_negative_position_becomes_0_when_the_i_action_is_switched_off() {
    let mut block = restarted(ContS { sp_int: 3.0, ti: Time::ms(1_000), lmns_on: false, ..slow_motor() });
    block.lmnr_hs = false;
    block.call();
    assert!(block.memory.f < 0.0);
    block.ti = Time::ms(0);
    block.sp_int = 0.0;
    block.lmnr_hs = true;
    block.call();
    assert!(block.memory.f >= 0.0);
}

#[test]
fn clause_8_the_on_threshold_is_capped_at_10() {
    // After 20 % up, F falls by 20 / (1000 - 0.2 * 100) a call; 10 % take 490 calls, 1 % would take 49.
    let mut block = restarted(ContS { sp_int: 20.0, ti: Time::ms(1_000_000), ..slow_motor() });
    let run = pulses(&mut block, 600);
    let rest = &run[20..];
    assert!(run.starts_with(&"U".repeat(20)) && rest.starts_with('.'), "{run}");
    let pause = rest.find('U').unwrap();
    assert!((480..=500).contains(&pause), "{pause} calls");
}

#[test]
fn clause_8_below_10_the_on_threshold_is_the_smaller_of_error_and_integrator() {
    let threshold = |e, f| {
        let mut block = restarted(ContS { sp_int: e, ti: Time::ms(1_000_000_000), ..slow_motor() });
        block.memory.f = f;
        block.call();
        block.memory.on
    };
    assert!((threshold(6.0, 8.0) - 6.0).abs() < 1e-5);
    assert!((threshold(-6.0, -8.0) - 6.0).abs() < 1e-5);
    assert!((threshold(8.0, 6.0) - 6.0).abs() < 1e-5);
    assert!((threshold(8.0, -6.0) - 6.0).abs() < 1e-5);
    assert_eq!(threshold(0.5, 8.0), 1.0);
}

#[test]
fn clause_8_the_lowest_threshold_is_the_way_of_the_shortest_pulse() {
    let threshold = |pulse_tm| {
        let mut block = restarted(ContS { pulse_tm: Time::ms(pulse_tm), ..slow_motor() });
        block.call();
        block.memory.on
    };
    assert_eq!((threshold(4_000), threshold(1_000), threshold(0)), (4.0, 1.0, 1.0));
    // The lowest threshold may lie above the cap.
    assert_eq!(threshold(20_000), 20.0);
    let (cycle, mtr_tm) = (Time::ms(10), Time::ms(23_000));
    let mut block = restarted(ContS { cycle, mtr_tm, pulse_tm: cycle, ..slow_motor() });
    block.call();
    assert_eq!(block.memory.on, 0.04347826);
}

#[test]
fn clause_8_a_reported_stop_sets_the_lowest_threshold_also_during_a_pulse() {
    for (lmnr_hs, lmnr_ls) in [(true, false), (false, true)] {
        let mut block = restarted(ContS { sp_int: 8.0, pv_in: -8.0, lmnr_hs, lmnr_ls, ..slow_motor() });
        block.call();
        assert_eq!(block.memory.on, 1.0);
    }
    let mut block = restarted(ContS { sp_int: 8.0, pv_in: -8.0, ..slow_motor() });
    assert_eq!(pulses(&mut block, 2), "UU");
    assert_eq!(block.memory.on, 8.0);
    block.lmnr_ls = true;
    assert_eq!(pulses(&mut block, 1), "U");
    assert_eq!(block.memory.on, 1.0);
    block.lmnr_ls = false;
    assert_eq!(pulses(&mut block, 1), "U");
    assert_eq!(block.memory.on, 1.0);
}

#[test]
fn clause_8_a_pulse_keeps_the_threshold_it_began_with() {
    let mut block = restarted(ContS { sp_int: 8.0, pv_in: -8.0, ..slow_motor() });
    block.call();
    block.sp_int = 4.0;
    block.call();
    assert_eq!((letter(&block), block.memory.on), ('U', 8.0));
}

#[test]
fn clause_8_without_i_action_the_threshold_is_half_the_error_or_the_lowest_at_a_process_value_of_0() {
    let first = |sp_int, pv_in| {
        let mut block = restarted(ContS { sp_int, pv_in, disv: -5.0, ..slow_motor() });
        (pulses(&mut block, 1), block.memory.on)
    };
    // e = 8, so z = 3: below 4, above 1.
    assert_eq!(first(10.0, 2.0), (".".into(), 4.0));
    assert_eq!(first(8.0, 0.0), ("U".into(), 1.0));
}

#[test]
fn clause_8_the_threshold_is_adapted_in_manual_mode_too() {
    let mut block = restarted(ContS { sp_int: 8.0, pv_in: -8.0, lmns_on: true, ..slow_motor() });
    block.call();
    assert_eq!(block.memory.on, 8.0);
}

#[test]
fn clause_9_a_pulse_starts_at_the_on_threshold_and_not_below() {
    let first = |sp_int| pulses(&mut restarted(ContS { sp_int, ..position_only() }), 1);
    assert_eq!([first(10.0), first(9.99), first(-10.0), first(-9.99)], ["U", ".", "D", "."]);
}

#[test]
fn clause_9_a_pulse_ends_at_the_off_threshold() {
    // 55 % of a call's way, 5.5 %, of what is left after four calls; exactly there it ends.
    let run = |sp_int| pulses(&mut restarted(ContS { sp_int, ..position_only() }), 8);
    assert_eq!([run(44.0), run(45.5), run(46.0)], ["UUUU....", "UUUU....", "UUUUU..."]);
}

#[test]
fn clause_9_the_off_threshold_is_55_percent_of_what_the_valve_moves_in_a_call() {
    // Half a second is 5 % here: 2.75 %.
    let run = |sp_int| {
        let block = ContS { sp_int, cycle: Time::ms(500), pulse_tm: Time::ms(500), ..position_only() };
        pulses(&mut restarted(block), 12)
    };
    assert_eq!([run(42.5), run(43.0)], ["UUUUUUUU....", "UUUUUUUUU..."]);
}

#[test]
fn clause_9_a_pulse_down_ends_at_the_off_threshold() {
    let run = |target| {
        let mut block = restarted(ContS { sp_int: 100.0, ..position_only() });
        assert_eq!(pulses(&mut block, 12), "UUUUUUUUUU..");
        block.sp_int = target;
        pulses(&mut block, 8)
    };
    assert_eq!([run(56.0), run(54.5), run(54.0)], ["DDDD....", "DDDD....", "DDDDD..."]);
}

#[test]
fn clause_9_the_disturbance_variable_is_fed_forward() {
    let run = |disv| pulses(&mut restarted(ContS { disv, sp_int: 40.0, ..position_only() }), 8);
    assert_eq!([run(20.0), run(-20.0)], ["UUUUUU..", "UU......"]);
}

#[test]
fn clause_9_the_integrator_is_subtracted_before_the_disturbance_variable_is_added() {
    // (1e8 - 50) - 1e8 is -48 in a REAL, within +-49; (1e8 - 1e8) - 50 would be beyond.
    let block = ContS { sp_int: 1e8, disv: -1e8, pulse_tm: Time::ms(49_000), ..slow_motor() };
    let mut block = restarted(block);
    block.memory.f = 50.0;
    assert_eq!(pulses(&mut block, 1), ".");
    assert_eq!((block.memory.f, block.memory.on), (50.0, 49.0));
}

#[test]
fn clause_10_one_manual_signal_makes_a_pulse_both_or_neither_none() {
    let pulse = |lmnup, lmndn| pulses(&mut restarted(ContS { lmnup, lmndn, sp_int: 50.0, ..manual() }), 2);
    assert_eq!(pulse(true, false), "UU");
    assert_eq!(pulse(false, true), "DD");
    assert_eq!(pulse(true, true), "..");
    assert_eq!(pulse(false, false), "..");
}

#[test]
fn clause_10_manual_signals_count_with_lmns_on_only() {
    assert_eq!(pulses(&mut restarted(ContS { lmnup: true, ..ContS::default() }), 3), "...");
}

#[test]
fn clause_11_a_demand_against_a_reported_stop_starts_no_pulse() {
    let pulse =
        |sp_int, lmnr_hs, lmnr_ls| pulses(&mut restarted(ContS { sp_int, lmnr_hs, lmnr_ls, ..ContS::default() }), 2);
    assert_eq!(pulse(21.0, true, false), "..");
    assert_eq!(pulse(-21.0, false, true), "..");
    assert_eq!(pulse(21.0, false, true), "UU");
    assert_eq!(pulse(-21.0, true, false), "DD");
}

#[test]
fn clause_11_between_up_and_down_lies_a_call_without_a_pulse() {
    let mut block = restarted(ContS { lmnup: true, pulse_tm: Time::ms(0), break_tm: Time::ms(0), ..manual() });
    let run = pulses_with(&mut block, 8, |number, block| {
        block.lmnup = number <= 3 || number > 6;
        block.lmndn = !block.lmnup;
    });
    assert_eq!(run, "UUU.DD.U");
}

#[test]
fn clause_12_manual_pulses_keep_the_minimum_pulse_and_break() {
    let run = pulses_with(&mut restarted(manual()), 16, |number, block| {
        block.lmnup = number == 2;
        block.lmndn = (4..=12).contains(&number);
    });
    assert_eq!(run, ".UUU...DDDDD....");
}

#[test]
fn clause_12_the_minimum_times_are_counted_in_calls() {
    let run = |pulse_tm, break_tm| {
        let mut block = ContS { pulse_tm: Time::ms(pulse_tm), break_tm: Time::ms(break_tm), ..manual() };
        pulses_with(&mut block, 12, |number, block| block.lmnup = number == 1 || number > 5)
    };
    assert_eq!(run(3_000, 3_000), "UUU...UUUUUU");
    assert_eq!(run(3_000, 4_000), "UUU....UUUUU");
    assert_eq!(run(2_500, 3_500), "UUU....UUUUU");
    assert_eq!(run(1_000, 8_000), "U........UUU");
    assert_eq!(run(0, 0), "U....UUUUUUU");
}

#[test]
fn clause_12_the_pulse_of_the_automatic_mode_ends_as_a_manual_one() {
    let mut block = restarted(ContS { sp_int: 11.0, ..ContS::default() });
    assert_eq!(pulses(&mut block, 1), "U");
    block.lmns_on = true;
    assert_eq!(pulses(&mut block, 4), "UU..");
}

#[test]
fn clause_13_a_stop_in_a_minimum_pulse_ends_it_and_asks_for_no_break() {
    let run = pulses_with(&mut restarted(manual()), 16, |number, block| {
        block.lmnup = number >= 2;
        block.lmnr_hs = number == 3 || number == 4;
    });
    assert_eq!(run, ".U..UUUUUUUUUUUU");
}

#[test]
fn clause_13_a_stop_after_the_minimum_pulse_asks_for_the_break() {
    let run = pulses_with(&mut restarted(manual()), 12, |number, block| {
        block.lmndn = true;
        block.lmnr_ls = number == 5;
    });
    assert_eq!(run, "DDDD...DDDDD");
}

#[test]
fn clause_13_the_stop_of_the_other_direction_ends_nothing() {
    let run = pulses_with(&mut restarted(manual()), 6, |number, block| {
        block.lmnup = true;
        block.lmnr_ls = number >= 3;
    });
    assert_eq!(run, "UUUUUU");
}

#[test]
fn clause_13_a_stop_in_the_pulses_of_the_automatic_mode() {
    let mut block = restarted(ContS { sp_int: 21.0, ..ContS::default() });
    let run = pulses_with(&mut block, 24, |number, block| block.lmnr_hs = (8..=12).contains(&number));
    assert_eq!(run, "UUUUUUU.....UUUUUUUU...U");
}

#[test]
fn clause_14_whatever_is_set_the_pulses_stay_safe() {
    let mut random = Random(0x2545_F491_4F6C_DD1D);
    let mut block = restarted(ContS::default());
    let mut last = '.';
    let mut seen = String::new();
    for call in 0..300_000 {
        if call % 500 == 0 {
            block.cycle = Time::ms(random.between(1, 2_000));
            block.ti = Time::ms(random.between(0, 2) * random.between(0, 40_000));
            block.pulse_tm = Time::ms(random.between(0, 5_000));
            block.break_tm = Time::ms(random.between(0, 5_000));
            block.mtr_tm = Time::ms(random.between(0, 60_000));
            block.gain = random.between(-30, 30) as Real / 10.0;
            block.deadb_w = random.between(0, 20) as Real / 10.0;
        }
        if random.one_in(10) {
            block.sp_int = random.between(-1_000, 1_000) as Real / 10.0;
            block.disv = random.between(-100, 100) as Real / 10.0;
            block.lmns_on = random.one_in(3);
        }
        block.lmnup = random.one_in(3);
        block.lmndn = random.one_in(3);
        block.lmnr_hs = random.one_in(12);
        block.lmnr_ls = random.one_in(12);
        block.com_rst = random.one_in(2_000);
        block.call();

        let pulse = letter(&block);
        assert_ne!(pulse, '!', "both outputs in call {call}");
        assert!(!matches!((last, pulse), ('U', 'D') | ('D', 'U')), "{last}{pulse} in call {call}");
        assert!(!(pulse == 'U' && block.lmnr_hs || pulse == 'D' && block.lmnr_ls), "against a stop in call {call}");
        assert_eq!(block.pulse(), i32::from(block.qlmnup) - i32::from(block.qlmndn));
        last = pulse;
        seen.push(pulse);
    }
    for change in ["U.", "D.", ".U", ".D", "UUU", "DDD", "U.D", "D.U"] {
        assert!(seen.contains(change), "the drive never made {change}");
    }
}

/// Xorshift: numbers without pattern, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn between(&mut self, lowest: i32, highest: i32) -> i32 {
        let count = i64::from(highest) - i64::from(lowest) + 1;
        (i64::from(lowest) + (self.next() >> 33) as i64 % count) as i32
    }

    fn one_in(&mut self, count: u64) -> bool {
        (self.next() >> 33).is_multiple_of(count)
    }
}

#[test]
fn clause_15_the_mean_row_counts_up_positive_and_down_negative() {
    let pulse = |lmnup, lmndn| {
        let mut block = restarted(ContS { lmnup, lmndn, ..manual() });
        block.call();
        block.pulse()
    };
    assert_eq!([pulse(true, false), pulse(false, true), pulse(false, false)], [1, -1, 0]);
    let mean = ContS::TABLE.mean.map(|row| ContS::TABLE.rows[row].full_name());
    assert_eq!(mean.as_deref(), Some("QLMN_MEAN"));
}
