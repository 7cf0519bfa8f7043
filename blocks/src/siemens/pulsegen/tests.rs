//! The clauses of PULSEGEN, and what its texts claim.

use super::*;
use crate::table::{Block, Real, Time};

/// Ten calls a period, no minimum time, three-step.
fn ten_calls() -> Pulsegen {
    Pulsegen { per_tm: Time::ms(100), p_b_tm: Time::ms(0), cycle: Time::ms(10), ..Pulsegen::default() }
}

fn restarted(mut block: Pulsegen) -> Pulsegen {
    block.restart();
    block
}

/// The outputs of the last call as a letter.
fn letter(block: &Pulsegen) -> char {
    match (block.qpos_p, block.qneg_p) {
        (true, true) => '!',
        (true, false) => '+',
        (false, true) => '-',
        (false, false) => '.',
    }
}

/// One letter a call; `before` is shown the number of each call, from 0 on, and may set inputs.
fn pulses_with(block: &mut Pulsegen, calls: usize, before: impl Fn(usize, &mut Pulsegen)) -> String {
    let call = |number| {
        before(number, block);
        block.call();
        letter(block)
    };
    (0..calls).map(call).collect()
}

fn pulses(block: &mut Pulsegen, calls: usize) -> String {
    pulses_with(block, calls, |_, _| ())
}

/// A period of ten calls of 100 ms with a minimum time of two, after a restart.
fn period(inv: Real, block: Pulsegen) -> String {
    let times = (Time::ms(1_000), Time::ms(200), Time::ms(100));
    let (per_tm, p_b_tm, cycle) = times;
    pulses(&mut restarted(Pulsegen { inv, per_tm, p_b_tm, cycle, ..block }), 10)
}

/// In how many of its ten calls a period has QPOS_P on, and in how many QNEG_P.
fn share(inv: Real, block: Pulsegen) -> (usize, usize) {
    let period = period(inv, block);
    (period.matches('+').count(), period.matches('-').count())
}

fn three_step(ratiofac: Real) -> Pulsegen {
    Pulsegen { ratiofac, ..Pulsegen::default() }
}

fn two_step(st2bi_on: bool) -> Pulsegen {
    Pulsegen { step3_on: false, st2bi_on, ..Pulsegen::default() }
}

#[test]
fn clause_1_a_restart_makes_both_outputs_false_in_two_step_mode_too() {
    for block in [two_step(false), two_step(true), three_step(1.0)] {
        let mut block = restarted(Pulsegen { inv: 50.0, ..block });
        assert_eq!(letter(&block), '.');
        block.call();
        assert_eq!(letter(&block), '+');
        block.com_rst = true;
        assert_eq!(pulses(&mut block, 2), "..");
        assert!(block.com_rst);
    }
}

#[test]
fn clause_1_the_call_after_a_restart_starts_a_period() {
    let mut block = restarted(Pulsegen { inv: 30.0, ..ten_calls() });
    assert_eq!(pulses(&mut block, 5), "+++..");
    block.com_rst = true;
    assert_eq!(pulses(&mut block, 1), ".");
    block.com_rst = false;
    assert_eq!(pulses(&mut block, 10), "+++.......");
}

#[test]
fn clause_2_30_percent_of_ten_calls_is_three_calls_on_and_seven_off() {
    assert_eq!(pulses(&mut restarted(Pulsegen { inv: 30.0, ..ten_calls() }), 20), "+++.......+++.......");
}

#[test]
fn clause_2_inv_is_read_in_the_first_call_of_a_period() {
    let mut block = restarted(Pulsegen { syn_on: false, ..ten_calls() });
    let run = pulses_with(&mut block, 20, |number, block| block.inv = if number == 10 { 60.0 } else { 20.0 });
    assert_eq!(run, "++........++++++....");
}

#[test]
fn clause_2_halves_of_a_call_are_rounded_to_the_even_number() {
    let calls = [34.0, 35.0, 36.0, 45.0, 46.0]
        .map(|inv| pulses(&mut restarted(Pulsegen { inv, ..ten_calls() }), 10).matches('+').count());
    assert_eq!(calls, [3, 4, 4, 4, 5]);
}

#[test]
fn clause_2_the_calls_of_a_period_are_rounded_too() {
    // 2.5 calls are 2, 3.5 calls are 4.
    let run = |per_tm| {
        let block = Pulsegen { inv: 30.0, per_tm: Time::ms(per_tm), ..ten_calls() };
        pulses(&mut restarted(block), 12)
    };
    assert_eq!((run(25).as_str(), run(35).as_str()), ("+.+.+.+.+.+.", "+...+...+..."));
}

#[test]
fn clause_3_a_negative_inv_pulses_the_negative_output() {
    assert_eq!(pulses(&mut restarted(Pulsegen { inv: -30.0, ..ten_calls() }), 20), "---.......---.......");
}

#[test]
fn clause_3_three_step_control_does_not_ask_for_st2bi_on() {
    assert_eq!(period(-50.0, Pulsegen { st2bi_on: true, ..three_step(1.0) }), "-----.....");
}

#[test]
fn clause_3_an_inv_beyond_100_percent_is_the_full_pulse() {
    assert_eq!((share(150.0, three_step(1.0)), share(-150.0, three_step(1.0))), ((10, 0), (0, 10)));
}

#[test]
fn clause_4_short_pulses_are_left_out_and_short_breaks_filled() {
    let calls = [19.99, 20.0, 25.0, 75.0, 80.0, 80.01].map(|inv| share(inv, three_step(1.0)));
    assert_eq!(calls, [(0, 0), (2, 0), (2, 0), (8, 0), (8, 0), (10, 0)]);
    let calls = [-19.99, -20.0, -25.0, -75.0, -80.0, -80.01].map(|inv| share(inv, three_step(1.0)));
    assert_eq!(calls, [(0, 0), (0, 2), (0, 2), (0, 8), (0, 8), (0, 10)]);
}

#[test]
fn clause_5_a_ratio_factor_below_1_shortens_negative_pulses() {
    let calls = [-19.0, -20.0, -80.0, -80.01, -100.0, 50.0].map(|inv| share(inv, three_step(0.5)));
    assert_eq!(calls, [(0, 0), (0, 1), (0, 4), (0, 5), (0, 5), (5, 0)]);
}

#[test]
fn clause_5_a_ratio_factor_above_1_shortens_positive_pulses() {
    let calls = [19.0, 20.0, 80.0, 81.0, 100.0, -50.0].map(|inv| share(inv, three_step(2.0)));
    assert_eq!(calls, [(0, 0), (1, 0), (4, 0), (5, 0), (5, 0), (0, 5)]);
}

#[test]
fn clause_5_the_ratio_factor_counts_in_three_step_control_only() {
    for ratiofac in [0.5, 2.0] {
        assert_eq!(share(60.0, Pulsegen { ratiofac, ..two_step(true) }), (8, 2));
        assert_eq!(share(60.0, Pulsegen { ratiofac, ..two_step(false) }), (6, 4));
    }
}

#[test]
fn clause_6_bipolar_control_is_half_on_at_0_percent() {
    let calls = [-101.0, -100.0, -60.01, -60.0, 0.0, 60.0, 60.01, 100.0].map(|inv| share(inv, two_step(true)).0);
    assert_eq!(calls, [0, 0, 0, 2, 5, 8, 10, 10]);
}

#[test]
fn clause_6_below_minus_100_percent_bipolar_control_stays_off() {
    // Without the case of its own, |INV + 100| / 2 would be on again for two calls here.
    assert_eq!(share(-150.0, two_step(true)).0, 0);
}

#[test]
fn clause_6_exactly_minus_100_percent_is_computed_like_every_value_above_it() {
    // In a period this long rounding leaves 4 ms of |-50 % + 50 %|, four calls.
    let (per_tm, p_b_tm, cycle) = (Time::ms(123_456_789), Time::ms(0), Time::ms(1));
    let mut block = restarted(Pulsegen { inv: -100.0, per_tm, p_b_tm, cycle, ..two_step(true) });
    assert_eq!(pulses(&mut block, 6), "++++--");
}

#[test]
fn clause_7_monopolar_control_is_off_below_0_percent() {
    let calls = [-50.0, 0.0, 10.0, 20.0, 80.0, 81.0].map(|inv| share(inv, two_step(false)).0);
    assert_eq!(calls, [0, 0, 0, 2, 8, 10]);
}

#[test]
fn clause_6_and_7_with_two_steps_the_negative_output_is_the_opposite_of_the_positive_one() {
    assert_eq!(period(50.0, two_step(false)), "+++++-----");
    assert_eq!(period(0.0, two_step(true)), "+++++-----");
    assert_eq!(period(-100.0, two_step(true)), "----------");
}

#[test]
fn clause_8_the_manual_signals_set_the_outputs_as_the_table_says() {
    let manual = |step3_on, pos_p_on, neg_p_on| {
        let block = Pulsegen { man_on: true, step3_on, pos_p_on, neg_p_on, inv: 70.0, ..ten_calls() };
        pulses(&mut restarted(block), 1)
    };
    let table = [(false, false), (true, false), (false, true), (true, true)];
    assert_eq!(table.map(|(pos, neg)| manual(true, pos, neg)), [".", "+", "-", "."]);
    assert_eq!(table.map(|(pos, neg)| manual(false, pos, neg)), ["-", "+", "-", "+"]);
}

#[test]
fn clause_8_after_manual_mode_a_period_starts() {
    let mut block = restarted(Pulsegen { inv: 30.0, ..ten_calls() });
    let run = pulses_with(&mut block, 17, |number, block| block.man_on = (5..7).contains(&number));
    assert_eq!(run, "+++....+++.......");
}

/// Twenty calls with INV 30 %, and 80 % from call `change` on.
fn synchronized(change: usize, syn_on: bool) -> String {
    let mut block = restarted(Pulsegen { syn_on, ..ten_calls() });
    pulses_with(&mut block, 20, |number, block| block.inv = if number < change { 30.0 } else { 80.0 })
}

#[test]
fn clause_9_a_change_of_inv_starts_a_period_in_the_next_call() {
    assert_eq!(synchronized(1, true), "++++++++++..++++++++");
    assert_eq!(synchronized(2, true), "+++++++++++..+++++++");
    assert_eq!(synchronized(4, true), "+++..++++++++..+++++");
    assert_eq!(synchronized(7, true), "+++.....++++++++..++");
}

#[test]
fn clause_9_in_the_last_two_calls_of_a_period_a_change_waits() {
    assert_eq!(synchronized(8, true), "+++.......++++++++..");
    assert_eq!(synchronized(9, true), "+++.......++++++++..");
}

#[test]
fn clause_9_a_change_in_the_first_call_of_a_period_is_the_new_period() {
    assert_eq!(synchronized(0, true), "++++++++..++++++++..");
    assert_eq!(synchronized(10, true), "+++.......++++++++..");
}

#[test]
fn clause_9_without_syn_on_every_change_waits_for_the_period() {
    for change in 1..=10 {
        assert_eq!(synchronized(change, false), "+++.......++++++++..", "change in call {change}");
    }
}

#[test]
fn clause_9_an_inv_that_changes_in_every_call_makes_periods_of_two_calls() {
    let mut block = restarted(ten_calls());
    let run = pulses_with(&mut block, 20, |number, block| block.inv = 30.0 + number as Real * 0.01);
    assert_eq!(run, "+".repeat(20));
}

#[test]
fn clause_9_a_change_during_manual_mode_is_no_change_afterwards() {
    let mut block = restarted(Pulsegen { inv: 30.0, ..ten_calls() });
    let run = pulses_with(&mut block, 13, |number, block| {
        block.man_on = number < 2;
        block.inv = if number == 0 { 30.0 } else { 50.0 };
    });
    assert_eq!(run, "..+++++.....+");
}

#[test]
fn clause_9_an_inv_that_is_nan_is_no_change() {
    let mut block = restarted(ten_calls());
    let run = pulses_with(&mut block, 12, |number, block| block.inv = if number == 3 { Real::NAN } else { 60.0 });
    assert_eq!(run, "++++++....++");
}

#[test]
fn an_inv_that_is_nan_makes_no_pulse() {
    assert_eq!(share(Real::NAN, three_step(1.0)), (0, 0));
    assert_eq!(share(Real::NAN, two_step(true)).0, 0);
}

#[test]
fn clause_10_with_three_steps_the_mean_counts_the_negative_pulse_negative() {
    let mut block = restarted(Pulsegen { inv: -30.0, ..ten_calls() });
    block.call();
    assert_eq!(block.pulse(), -1);
    pulses(&mut block, 5);
    assert_eq!(block.pulse(), 0);
    let mut block = restarted(Pulsegen { inv: 30.0, ..ten_calls() });
    block.call();
    assert_eq!(block.pulse(), 1);
    let mean = Pulsegen::TABLE.mean.map(|row| Pulsegen::TABLE.rows[row].full_name());
    assert_eq!(mean.as_deref(), Some("Q_MEAN"));
}

#[test]
fn clause_10_with_two_steps_the_opposite_output_is_no_pulse() {
    let mut block = restarted(Pulsegen { inv: 30.0, step3_on: false, ..ten_calls() });
    assert_eq!(block.pulse(), 0);
    let mut means = Vec::new();
    for _ in 0..5 {
        block.call();
        means.push(block.pulse());
    }
    assert_eq!(means, [1, 1, 1, 0, 0]);
    assert!(block.qneg_p);
}

#[test]
fn clause_10_a_change_of_mode_counts_from_the_next_call_on() {
    let mut block = restarted(Pulsegen { step3_on: false, ..ten_calls() });
    block.call();
    block.step3_on = true;
    assert_eq!((block.qneg_p, block.pulse()), (true, 0));
}

#[test]
fn a_period_of_half_a_call_is_rounded_to_none_and_has_no_pulse() {
    let mut block = restarted(Pulsegen { per_tm: Time::ms(5), inv: 100.0, ..ten_calls() });
    assert_eq!(pulses(&mut block, 4), "....");
    // The next setting counts in the next call already.
    block.per_tm = Time::ms(20);
    assert_eq!(pulses(&mut block, 4), "++++");
}

#[test]
fn a_minimum_time_above_half_of_the_period_leaves_off_and_fully_on() {
    let calls = |inv| {
        let block = Pulsegen { inv, p_b_tm: Time::ms(60), ..ten_calls() };
        pulses(&mut restarted(block), 10).matches('+').count()
    };
    assert_eq!([10.0, 40.0, 41.0, 60.0, 90.0].map(calls), [0, 0, 10, 10, 10]);
}

#[test]
fn a_minimum_time_above_the_period_leaves_fully_on() {
    let run = |inv, step3_on| {
        let block = Pulsegen { inv, step3_on, p_b_tm: Time::ms(101), ..ten_calls() };
        pulses(&mut restarted(block), 10)
    };
    assert_eq!(run(1.0, true), "++++++++++");
    assert_eq!(run(0.0, true), "----------");
    assert_eq!(run(-1.0, false), "++++++++++");
}

#[test]
fn the_longest_period_and_the_widest_pulse_do_not_wrap() {
    let block = Pulsegen {
        per_tm: Time::ms(i32::MAX),
        cycle: Time::ms(1),
        p_b_tm: Time::ms(0),
        inv: Real::MAX,
        syn_on: false,
        ..Pulsegen::default()
    };
    assert_eq!(pulses(&mut restarted(block.clone()), 5), "+++++");
    let block = Pulsegen { inv: -1.0, ratiofac: Real::MIN, ..block };
    assert_eq!(pulses(&mut restarted(block), 5), ".....");
}
