//! Tests of CONT_C, by the number of the clause.

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

/// What a user reads off LMN_PER with this manual value and no limit in its way.
fn word_of(man: Real) -> Int {
    let block = ContC { man, lmn_hlm: Real::INFINITY, lmn_llm: Real::NEG_INFINITY, ..ContC::default() };
    after_one_call(restarted(block), |block| block.lmn_per.value())
}

#[test]
fn clause_1_a_restart_makes_all_nine_outputs_0_or_false() {
    let mut block = restarted(ContC {
        pv_in: 3.0,
        d_sel: true,
        lmn_hlm: 1.0,
        lmn_off: 5.0,
        disv: 4.0,
        i_itlval: 60.0,
        ..automatic()
    });
    block.call();
    assert!(block.lmn != 0.0 && block.lmn_d != 0.0);
    block.com_rst = true;
    block.man = 50.0;
    block.call();
    assert_eq!([block.lmn, block.lmn_p, block.lmn_i, block.lmn_d, block.pv, block.er], [0.0; 6]);
    assert_eq!((block.lmn_per.value(), block.qlmn_hlm, block.qlmn_llm), (0, false, false));
}

#[test]
fn clause_1_i_itlval_counts_in_the_first_automatic_call_after_a_restart() {
    let mut block = restarted(ContC { i_itlval: 30.0, ..automatic() });
    assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [30.05, 30.15]);
}

#[test]
fn clause_1_a_manual_call_after_a_restart_overwrites_i_itlval() {
    let mut block = restarted(ContC { i_itlval: 30.0, sp_int: 0.0, ..automatic() });
    block.man_on = true;
    block.call();
    block.man_on = false;
    block.call();
    assert_eq!(block.lmn_i, 0.0);
}

#[test]
fn clause_1_while_com_rst_is_true_every_call_is_a_restart_and_nothing_takes_it_back() {
    let mut block = restarted(automatic());
    calls(&mut block, 3, |_| ());
    block.com_rst = true;
    assert_eq!(calls(&mut block, 3, |block| (block.lmn, block.com_rst)), [(0.0, true); 3]);
    block.com_rst = false;
    assert_eq!(calls(&mut block, 1, |block| block.lmn), [2.05]);
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
fn clause_2_pvper_on_selects_the_analog_value() {
    let block = ContC { pv_in: 7.0, pv_per: Word::new(27648), ..automatic() };
    assert_eq!(after_one_call(block.clone(), |block| (block.pv, block.er)), (7.0, -6.0));
    let block = ContC { pvper_on: true, ..block };
    assert_eq!(after_one_call(block, |block| (block.pv, block.er)), (100.0, -99.0));
}

#[test]
fn clause_2_factor_and_offset_act_on_the_analog_value_alone() {
    let block = ContC { pv_in: 7.0, pv_per: Word::new(13824), pv_fac: 4.0, pv_off: -50.0, ..automatic() };
    assert_eq!(after_one_call(block.clone(), |block| block.pv), 7.0);
    assert_eq!(after_one_call(ContC { pvper_on: true, ..block }, |block| block.pv), 150.0);
}

#[test]
fn clause_3_the_error_loses_half_the_width_of_the_dead_band() {
    for (setpoint, error) in [(3.0, 1.0), (2.0, 0.0), (-2.0, 0.0), (-3.0, -1.0)] {
        let block = ContC { sp_int: setpoint, deadb_w: 2.0, ..automatic() };
        assert_eq!(after_one_call(block, |block| (block.er, block.lmn_p)), (error, 2.0 * error), "SP {setpoint}");
    }
}

#[test]
fn clause_4_p_i_and_d_all_act_on_error_times_gain() {
    let parts = |gain| {
        let block = ContC { gain, d_sel: true, lmn_llm: -100.0, ..automatic() };
        after_one_call(restarted(block), |block| (block.lmn_p, block.lmn_i, block.lmn_d))
    };
    assert_eq!(parts(2.0), (2.0, 0.05, 8.0));
    assert_eq!(parts(-4.0), (-4.0, -0.1, -16.0));
}

#[test]
fn clause_4_a_part_that_is_not_selected_is_0() {
    let parts = |p_sel, i_sel, d_sel| {
        let block = ContC { p_sel, i_sel, d_sel, ..automatic() };
        after_one_call(restarted(block), |block| (block.lmn_p, block.lmn_i, block.lmn_d, block.lmn))
    };
    assert_eq!(parts(true, false, false), (2.0, 0.0, 0.0, 2.0));
    assert_eq!(parts(false, true, false), (0.0, 0.05, 0.0, 0.05));
    assert_eq!(parts(false, false, true), (0.0, 0.0, 8.0, 8.0));
}

#[test]
fn clause_4_a_change_of_gain_kicks_the_derivative_once() {
    // w holds the old product 2; the new one is 3: a step of 1, times V = 4.
    let mut block = restarted(ContC { d_sel: true, ..automatic() });
    calls(&mut block, 60, |_| ());
    assert!(block.lmn_d.abs() < 1e-5);
    block.gain = 3.0;
    block.call();
    assert!((block.lmn_d - 4.0).abs() < 1e-5, "{}", block.lmn_d);
}

#[test]
fn clause_5_a_reset_time_below_half_a_cycle_counts_as_half_a_cycle() {
    // (1 s / 0.5 s) * (2 + 0) / 2
    for ti in [0, 300, 500] {
        let block = ContC { ti: Time::ms(ti), ..automatic() };
        assert_eq!(after_one_call(restarted(block), |block| block.lmn_i), 2.0, "TI {ti} ms");
    }
}

#[test]
fn clause_5_a_derivative_time_below_a_cycle_counts_as_a_cycle() {
    // V = 1 / (0.5 + 2)
    for td in [0, 700, 1000] {
        let block = ContC { td: Time::ms(td), d_sel: true, ..automatic() };
        assert_eq!(after_one_call(restarted(block), |block| block.lmn_d), 0.8, "TD {td} ms");
    }
}

#[test]
fn clause_5_a_time_lag_below_half_a_cycle_counts_as_half_a_cycle() {
    // V = 10 / (0.5 + 0.5), and the lag forgets the step in one call.
    for tm_lag in [0, 300, 500] {
        let block = ContC { tm_lag: Time::ms(tm_lag), i_sel: false, d_sel: true, ..automatic() };
        assert_eq!(calls(&mut restarted(block), 3, |block| block.lmn_d), [20.0, 0.0, 0.0], "TM_LAG {tm_lag} ms");
    }
}

#[test]
fn clause_6_the_integral_grows_by_trapezoids() {
    let mut block = restarted(automatic());
    let rows = calls(&mut block, 5, |block| (block.lmn_i, block.lmn_per.value()));
    assert_eq!(rows, [(0.05, 567), (0.15, 594), (0.25, 622), (0.35, 650), (0.45, 677)]);
}

#[test]
fn clause_6_what_rounding_takes_comes_back_in_later_calls() {
    // Each call adds 1e-7 to 50, where a REAL has steps of 3.8e-6.
    let mut block = restarted(ContC {
        cycle: Time::ms(10),
        ti: Time::ms(3_600_000),
        gain: 1.0,
        sp_int: 0.036,
        i_itlval: 50.0,
        ..automatic()
    });
    calls(&mut block, 100_000, |_| ());
    assert_eq!(block.lmn_i, 50.01);
}

#[test]
fn clause_6_int_hold_stops_the_integral_and_drops_the_rest() {
    let mut block = restarted(automatic());
    calls(&mut block, 2, |_| ());
    block.int_hold = true;
    assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [0.15; 3]);
    assert_eq!(block.memory.rest, 0.0);
    block.int_hold = false;
    assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [0.25]);
}

#[test]
fn clause_6_a_limit_reached_in_the_last_call_stops_the_integral_in_its_direction_only() {
    // u is 2.05 in the first call, above the limit, and so it stays while e does.
    let mut block = restarted(ContC { lmn_hlm: 1.0, lmn_llm: -100.0, ..automatic() });
    assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [0.05; 3]);
    block.sp_int = -3.0;
    assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [-0.05]);
}

#[test]
fn clause_6_the_low_limit_stops_the_integral_downwards() {
    let mut block = restarted(ContC { sp_int: -1.0, lmn_llm: -1.0, ..automatic() });
    assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [-0.05; 3]);
    block.sp_int = 3.0;
    assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [0.05]);
}

#[test]
fn clause_6_a_limit_that_a_manual_call_ended_at_counts_too() {
    let integral = |man| {
        let mut block = restarted(ContC { man, man_on: true, ..automatic() });
        calls(&mut block, 2, |_| ());
        block.man_on = false;
        calls(&mut block, 1, |block| block.lmn_i)[0]
    };
    assert_eq!(integral(99.0), 97.1);
    assert_eq!(integral(100.0), 98.0);
}

#[test]
fn clause_7_the_integral_stays_within_the_limits_whatever_the_other_parts_are() {
    let mut block = restarted(ContC { i_itlval: 99.9, disv: -50.0, ..automatic() });
    assert_eq!(calls(&mut block, 4, |block| block.lmn_i), [99.950005, 100.0, 100.0, 100.0]);
    block.sp_int = -1.0;
    block.disv = 50.0;
    block.i_itlval = 0.04;
    block.restart();
    assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [0.0, 0.0, 0.0]);
}

#[test]
fn clause_7_the_integral_held_at_its_limit_leaves_no_rest() {
    let mut block = restarted(ContC { i_itlval: 120.0, disv: -150.0, ..automatic() });
    assert_eq!(calls(&mut block, 1, |block| (block.lmn_i, block.memory.rest)), [(100.0, 0.0)]);
}

#[test]
fn clause_7_a_limit_that_moves_takes_the_integral_with_it_even_on_hold() {
    let mut block = restarted(ContC { i_itlval: 30.0, int_hold: true, ..automatic() });
    assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [30.0]);
    block.lmn_hlm = 10.0;
    assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [10.0]);
    block.lmn_hlm = 100.0;
    block.lmn_llm = 40.0;
    assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [40.0]);
}

#[test]
fn clause_7_with_crossed_limits_the_high_one_is_asked_first() {
    let integral = |i_itlval| {
        let block = ContC { i_itlval, int_hold: true, lmn_hlm: 10.0, lmn_llm: 50.0, ..automatic() };
        after_one_call(restarted(block), |block| block.lmn_i)
    };
    assert_eq!((integral(20.0), integral(10.0), integral(-5.0)), (10.0, 50.0, 50.0));
}

#[test]
fn clause_7_i_itlval_beyond_a_limit_is_clamped_after_a_restart_and_free_with_i_itl_on() {
    let beyond = ContC { i_itlval: 120.0, ..automatic() };
    assert_eq!(after_one_call(restarted(beyond.clone()), |block| block.lmn_i), 100.0);
    let mut block = restarted(ContC { i_itl_on: true, ..beyond });
    block.call();
    block.i_itl_on = false;
    assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [120.0, 120.0]);
}

#[test]
fn clause_7_an_integral_put_outside_comes_back_by_itself_and_is_held_from_then_on() {
    // e = -20 takes 1 off a call (half of it in the first), e = +20 brings it back.
    let mut block = restarted(ContC { i_itlval: 101.5, i_itl_on: true, sp_int: -10.0, disv: -500.0, ..automatic() });
    block.lmn_llm = -1000.0;
    block.call();
    block.i_itl_on = false;
    assert_eq!(calls(&mut block, 3, |block| block.lmn_i), [100.5, 99.5, 98.5]);
    block.sp_int = 10.0;
    assert_eq!(calls(&mut block, 4, |block| block.lmn_i), [98.5, 99.5, 100.0, 100.0]);
}

#[test]
fn clause_7_an_integral_that_manual_mode_put_outside_stays_free() {
    // y is at most 100, DISV takes it to 150.
    let mut block = restarted(ContC { man: 100.0, man_on: true, disv: -52.0, sp_int: 0.0, ..automatic() });
    calls(&mut block, 2, |_| ());
    block.man_on = false;
    assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [152.0, 152.0]);
}

#[test]
fn clause_7_an_integral_that_i_sel_put_outside_stays_free() {
    let mut block = restarted(ContC { i_sel: false, lmn_llm: 20.0, sp_int: 0.0, ..automatic() });
    block.call();
    block.i_sel = true;
    assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [0.0, 0.0]);
}

#[test]
fn clause_7_an_integral_exactly_at_a_limit_is_inside_and_arms_the_clamp() {
    for (edge, new_high, new_low, held) in [(100.0, 90.0, 0.0, 90.0), (0.0, 100.0, 10.0, 10.0)] {
        let mut block = restarted(ContC { i_itlval: edge, i_itl_on: true, int_hold: true, ..automatic() });
        block.call();
        block.i_itl_on = false;
        block.call();
        (block.lmn_hlm, block.lmn_llm) = (new_high, new_low);
        assert_eq!(calls(&mut block, 1, |block| block.lmn_i), [held]);
    }
}

#[test]
fn clause_8_i_itl_on_sets_the_integral_in_manual_mode_too() {
    for man_on in [false, true] {
        let mut block = restarted(ContC { man_on, i_itl_on: true, i_itlval: 12.5, ..automatic() });
        assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [12.5, 12.5]);
    }
}

#[test]
fn clause_8_an_integral_that_is_not_selected_is_0_even_with_i_itl_on() {
    let mut block = restarted(ContC { i_sel: false, i_itl_on: true, i_itlval: 12.5, ..automatic() });
    assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [0.0, 0.0]);
}

#[test]
fn clause_8_setting_the_integral_drops_the_rest() {
    let with_rest = |set: fn(&mut ContC)| {
        let mut block = restarted(ContC { gain: 0.3, ti: Time::ms(7_300), i_itlval: 50.0, ..automatic() });
        calls(&mut block, 3, |_| ());
        assert!(block.memory.rest != 0.0);
        set(&mut block);
        block.call();
        block.memory.rest
    };
    assert_eq!(with_rest(|block| block.i_itl_on = true), 0.0);
    assert_eq!(with_rest(|block| block.i_sel = false), 0.0);
    assert_eq!(with_rest(|block| block.man_on = true), 0.0);
}

#[test]
fn clause_9_lmn_follows_the_manual_value_at_once_and_the_integral_one_call_later() {
    let mut block = restarted(ContC::default());
    let mut rows = Vec::new();
    for man in [40.0, 40.0, 50.0, 60.0, 60.0] {
        block.man = man;
        block.call();
        rows.push((block.lmn, block.lmn_i));
    }
    assert_eq!(rows, [(40.0, 0.0), (40.0, 40.0), (50.0, 40.0), (60.0, 50.0), (60.0, 60.0)]);
}

#[test]
fn clause_9_the_change_to_automatic_is_without_a_bump_when_man_stood_still_for_two_calls() {
    let mut block = restarted(ContC { man_on: true, man: 40.0, disv: 5.0, ti: Time::ms(2_000_000), ..automatic() });
    calls(&mut block, 2, |_| ());
    assert_eq!(block.lmn_i, 33.0);
    block.man_on = false;
    assert_eq!(calls(&mut block, 1, |block| block.lmn), [40.001]);
}

#[test]
fn clause_9_the_integral_matches_the_manual_value_within_the_limits_before_lmn_fac_and_lmn_off() {
    let mut block = restarted(ContC { man: 130.0, lmn_fac: 0.5, lmn_off: 7.0, ..ContC::default() });
    assert_eq!(calls(&mut block, 2, |block| (block.lmn, block.lmn_i)), [(57.0, 0.0), (57.0, 100.0)]);
}

#[test]
fn clause_10_the_derivative_steps_and_decays_with_the_time_lag() {
    let mut block = restarted(ContC { i_sel: false, d_sel: true, ..automatic() });
    assert_eq!(calls(&mut block, 5, |block| block.lmn_d), [8.0, 4.8, 2.88, 1.7279997, 1.0367999]);
}

#[test]
fn clause_10_switching_the_derivative_on_is_without_a_bump() {
    for off in [ContC { d_sel: false, ..automatic() }, ContC { d_sel: true, man_on: true, ..automatic() }] {
        let mut block = restarted(off);
        assert_eq!(calls(&mut block, 2, |block| block.lmn_d), [0.0, 0.0]);
        (block.d_sel, block.man_on) = (true, false);
        assert_eq!(calls(&mut block, 2, |block| block.lmn_d), [0.0, 0.0]);
        block.sp_int = 2.0;
        assert_eq!(calls(&mut block, 1, |block| block.lmn_d), [8.0]);
    }
}

#[test]
fn clause_10_switching_the_derivative_off_drops_the_rest() {
    let mut block = restarted(ContC { d_sel: true, sp_int: 0.3, ..automatic() });
    calls(&mut block, 4, |_| ());
    assert!(block.memory.rest_d != 0.0);
    block.d_sel = false;
    block.call();
    assert_eq!(block.memory.rest_d, 0.0);
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
fn clause_11_at_and_above_the_high_limit_only_its_flag_is_true() {
    for man in [90.0, 150.0] {
        let block = restarted(ContC { man, lmn_hlm: 90.0, ..ContC::default() });
        assert_eq!(after_one_call(block, |b| (b.lmn, b.qlmn_hlm, b.qlmn_llm)), (90.0, true, false));
    }
}

#[test]
fn clause_11_at_and_below_the_low_limit_only_its_flag_is_true() {
    for man in [-20.0, -150.0] {
        let block = restarted(ContC { man, lmn_llm: -20.0, ..ContC::default() });
        assert_eq!(after_one_call(block, |b| (b.lmn, b.qlmn_hlm, b.qlmn_llm)), (-20.0, false, true));
    }
}

#[test]
fn clause_11_between_the_limits_neither_flag_is_true() {
    let block = restarted(ContC { man: 50.0, ..ContC::default() });
    assert_eq!(after_one_call(block, |b| (b.lmn, b.qlmn_hlm, b.qlmn_llm)), (50.0, false, false));
}

#[test]
fn clause_11_with_crossed_limits_the_high_one_wins() {
    let block = restarted(ContC { man: 50.0, lmn_hlm: 10.0, lmn_llm: 90.0, ..ContC::default() });
    assert_eq!(after_one_call(block, |b| (b.lmn, b.qlmn_hlm, b.qlmn_llm)), (10.0, true, false));
}

#[test]
fn clause_11_with_the_defaults_a_manipulated_value_of_0_is_at_the_low_limit() {
    assert!(after_one_call(restarted(ContC::default()), |block| block.qlmn_llm));
}

#[test]
fn the_disturbance_variable_is_added_in_automatic_mode_only() {
    let block = restarted(ContC { disv: 10.0, man: 33.0, ..automatic() });
    assert_eq!(after_one_call(block.clone(), |block| block.lmn), 12.05);
    assert_eq!(after_one_call(ContC { man_on: true, ..block }, |block| block.lmn), 33.0);
}

#[test]
fn lmn_fac_and_lmn_off_act_behind_the_limits() {
    let block = restarted(ContC { man: 150.0, lmn_fac: 0.5, lmn_off: -60.0, ..ContC::default() });
    assert_eq!(after_one_call(block, |block| (block.lmn, block.lmn_per.value())), (-10.0, -2765));
}

#[test]
fn clause_12_lmn_per_is_27648_at_100_percent() {
    for (man, word) in [(1.0, 276), (12.5, 3456), (50.0, 13824), (100.0, 27648), (118.0, 32625), (-100.0, -27648)] {
        assert_eq!(word_of(man), word, "LMN {man}");
    }
}

#[test]
fn clause_12_lmn_per_wraps_where_lmn_passes_118_5_percent() {
    for (man, word) in [(117.59, 32511), (118.515, 32767), (118.52, -32768), (150.0, -24064), (-118.53, 32765)] {
        assert_eq!(word_of(man), word, "LMN {man}");
    }
}

#[test]
fn clause_12_lmn_per_of_a_number_beyond_32_bits_is_the_low_word_of_its_bits() {
    assert_eq!(word_of(1e9), -16644);
}

#[test]
fn lmn_per_of_nan_is_16_ffff() {
    let block = restarted(ContC { lmn_off: Real::NAN, ..ContC::default() });
    assert_eq!(after_one_call(block, |block| block.lmn_per.value()), -1);
}

#[test]
fn an_overflow_inside_is_cleared_by_com_rst() {
    let mut block = restarted(ContC { d_sel: true, sp_int: 3e38, gain: 3e38, ..automatic() });
    calls(&mut block, 3, |_| ());
    assert!(!block.lmn_i.is_finite() || !block.lmn_d.is_finite());
    (block.sp_int, block.gain, block.com_rst) = (1.0, 2.0, true);
    block.call();
    block.com_rst = false;
    assert_eq!(calls(&mut block, 1, |block| block.lmn), [10.05]);
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

/// The loop of the quick start with setpoint 50: the highest PV, and when PV was last off by more than 1. A host that
/// makes `calls` calls a step sets PV_IN once in a step; `at_once` says whether the plant sees LMN in the same step.
fn quick_start(calls: usize, at_once: bool) -> (f64, usize) {
    let mut block = restarted(ContC { gain: 2.5, ti: Time::ms(80_000), sp_int: 50.0, ..automatic() });
    let mut plant = Plant::at_rest();
    let (mut highest, mut settled) = (0.0, 0);
    for step in 0..600 / calls {
        block.pv_in = plant.pv as Real;
        let former = block.lmn;
        (0..calls).for_each(|_| block.call());
        for second in 0..calls {
            plant.step(f64::from(if at_once { block.lmn } else { former }));
            highest = f64::max(highest, plant.pv);
            if (plant.pv - 50.0).abs() > 1.0 {
                settled = step * calls + second;
            }
        }
    }
    (highest, settled)
}

#[test]
fn the_loop_of_the_quick_start_settles_without_overshoot() {
    let (highest, settled) = quick_start(1, true);
    assert!(highest < 50.001 && settled < 160, "{highest} {settled}");
}

#[test]
fn the_loop_of_the_quick_start_overshoots_at_steps_of_ten_calls() {
    let overshoot = |at_once| (quick_start(10, at_once).0 / 50.0 - 1.0) * 100.0;
    assert_eq!((overshoot(true).round(), overshoot(false).round()), (8.0, 33.0));
}

#[test]
fn help_of_com_rst_a_restart_gives_0_below_the_low_limit() {
    assert_eq!(restarted(ContC { lmn_llm: 20.0, ..automatic() }).lmn, 0.0);
    assert_eq!(after_one_call(ContC { com_rst: true, lmn_llm: 20.0, ..automatic() }, |block| block.lmn), 0.0);
}

/// 20 manual calls at 40 with an error of 10, then an automatic one before which something changes.
fn lmn_after_manual_mode(change: impl Fn(&mut ContC)) -> Real {
    let mut block = restarted(ContC { man_on: true, man: 40.0, sp_int: 10.0, ..automatic() });
    calls(&mut block, 20, |_| ());
    block.man_on = false;
    change(&mut block);
    calls(&mut block, 1, |block| block.lmn)[0]
}

#[test]
fn help_of_man_on_the_first_automatic_call_adds_one_step_of_the_integral() {
    assert_eq!(lmn_after_manual_mode(|_| ()), 41.0);
}

#[test]
fn help_of_man_on_lmn_jumps_with_what_changes_in_the_call_in_which_it_falls() {
    let jump = |change: fn(&mut ContC)| lmn_after_manual_mode(change) - 41.0;
    assert_eq!(jump(|block| block.sp_int = 20.0), 20.5);
    assert_eq!(jump(|block| block.pv_in = -10.0), 20.5);
    assert_eq!(jump(|block| block.disv = 7.0), 7.0);
    assert_eq!(jump(|block| block.gain = 4.0), 20.5);
    assert_eq!(jump(|block| block.i_sel = false), 20.0 - 41.0);
    assert_eq!(jump(|block| (block.i_itl_on, block.i_itlval) = (true, 3.0)), 23.0 - 41.0);
}

#[test]
fn help_of_pvper_on_and_pv_off_a_process_value_that_differs_moves_lmn_p() {
    let mut block = restarted(ContC { pv_in: 10.0, pv_per: Word::new(13824), pv_off: -45.0, ..automatic() });
    let lmn_p = |block: &mut ContC| calls(block, 1, |block| block.lmn_p)[0];
    let before = lmn_p(&mut block);
    block.pvper_on = true;
    assert_eq!(lmn_p(&mut block) - before, 10.0);
    block.pv_off = -46.0;
    assert_eq!(lmn_p(&mut block) - before, 12.0);
}

#[test]
fn help_of_p_sel_the_integral_alone_moves_lmn_by_1_per_second() {
    let mut block = restarted(ContC { p_sel: false, sp_int: 10.0, ..automatic() });
    assert_eq!(calls(&mut block, 3, |block| block.lmn), [0.5, 1.5, 2.5]);
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

#[test]
fn help_of_gain_doubling_it_doubles_all_three_parts() {
    let parts = |gain| {
        let mut block = restarted(ContC { gain, sp_int: 10.0, d_sel: true, lmn_hlm: 1000.0, ..automatic() });
        let rows = calls(&mut block, 2, |block| (block.lmn_p, block.lmn_i, block.lmn_d));
        (rows[0].0, rows[1].1 - rows[0].1, rows[0].2)
    };
    assert_eq!(parts(2.0), (20.0, 1.0, 80.0));
    assert_eq!(parts(4.0), (40.0, 2.0, 160.0));
}

#[test]
fn help_of_gain_changing_it_moves_p_and_kicks_d_and_leaves_i() {
    let mut block = restarted(ContC { gain: 1.0, sp_int: 10.0, d_sel: true, ..automatic() });
    let before = calls(&mut block, 50, |block| (block.lmn_p, block.lmn_i, block.lmn_d))[49];
    block.gain = 2.0;
    let after = calls(&mut block, 1, |block| (block.lmn_p, block.lmn_i, block.lmn_d))[0];
    assert_eq!((after.0 - before.0, after.1 - before.1), (10.0, 0.75));
    assert!(before.2.abs() < 1e-3 && (after.2 - 40.0).abs() < 1e-3, "{before:?} {after:?}");
}

#[test]
fn help_of_ti_changing_it_does_not_make_lmn_jump() {
    let lmn = |ti| {
        let mut block = restarted(ContC { sp_int: 10.0, ..automatic() });
        calls(&mut block, 20, |_| ());
        block.ti = ti;
        calls(&mut block, 1, |block| block.lmn)[0]
    };
    assert_eq!((lmn(Time::ms(20_000)), lmn(Time::ms(40_000))), (40.5, 40.0));
}

#[test]
fn help_of_ti_the_integral_grows_by_lmn_p_in_ti() {
    let mut block = restarted(ContC { sp_int: 10.0, ..automatic() });
    let integral = calls(&mut block, 21, |block| block.lmn_i);
    assert_eq!((block.lmn_p, integral[20] - integral[0]), (20.0, 20.0));
}

#[test]
fn help_of_td_the_derivative_of_a_ramp_settles_at_td_times_its_slope() {
    let mut block = restarted(ContC { gain: 1.0, d_sel: true, ..automatic() });
    for second in 0..100_u8 {
        block.sp_int = 0.5 * Real::from(second);
        block.call();
    }
    assert!((block.lmn_d - 5.0).abs() < 1e-4, "{}", block.lmn_d);
}

#[test]
fn help_of_lmn_hlm_lmn_leaves_the_limit_as_soon_as_lmn_p_falls() {
    let mut block = restarted(ContC { sp_int: 40.0, ..automatic() });
    calls(&mut block, 100, |_| ());
    assert_eq!((block.lmn, block.lmn_p, block.lmn_i), (100.0, 80.0, 22.0));
    block.sp_int = 35.0;
    assert_eq!(calls(&mut block, 1, |block| block.lmn), [92.0]);
    block.lmn_hlm = 10.0;
    assert_eq!(calls(&mut block, 1, |block| (block.lmn, block.lmn_i)), [(10.0, 10.0)]);
}

#[test]
fn help_of_pv_fac_and_pv_off_a_word_becomes_a_temperature() {
    let pv = |pv_fac, pv_off| {
        let block = ContC { pvper_on: true, pv_per: Word::new(13824), pv_fac, pv_off, ..automatic() };
        after_one_call(restarted(block), |block| block.pv)
    };
    assert_eq!((pv(4.0, 0.0), pv(2.0, -50.0)), (200.0, 50.0));
}

#[test]
fn help_of_lmn_fac_and_lmn_off_the_examples_hold() {
    let lmn = |man, lmn_fac, lmn_off| {
        let block = ContC { man, lmn_fac, lmn_off, lmn_llm: -100.0, ..ContC::default() };
        after_one_call(restarted(block), |block| (block.lmn, block.lmn_per.value()))
    };
    assert_eq!(lmn(30.0, -1.0, 100.0).0, 70.0);
    assert_eq!(lmn(40.0, 1.0, 10.0).0, 50.0);
    assert_eq!((lmn(-100.0, 0.5, 50.0).0, lmn(100.0, 0.5, 50.0).0), (0.0, 100.0));
    assert_eq!(lmn(100.0, 1.0, 20.0), (120.0, -32358));
    assert!(lmn(7.9, 15.0, 0.0).1 > 0 && lmn(7.91, 15.0, 0.0).1 < 0);
}

#[test]
fn help_of_i_itlval_the_first_automatic_call_adds_half_a_step() {
    let block = ContC { i_itlval: 40.0, sp_int: 10.0, ..automatic() };
    assert_eq!(after_one_call(restarted(block.clone()), |block| block.lmn_i), 40.5);
    let mut manual = restarted(ContC { man_on: true, ..block });
    manual.call();
    manual.man_on = false;
    assert_eq!(calls(&mut manual, 1, |block| block.lmn_i), [-19.0], "a manual call discards it");
}

#[test]
fn help_of_disv_lmn_rises_by_as_much_in_the_same_call() {
    let mut block = restarted(ContC { sp_int: 0.0, i_itlval: 30.0, ..automatic() });
    assert_eq!(calls(&mut block, 1, |block| block.lmn), [30.0]);
    block.disv = 10.0;
    assert_eq!(calls(&mut block, 1, |block| (block.lmn, block.er)), [(40.0, 0.0)]);
}

#[test]
fn help_of_lmn_per_150_percent_reads_as_minus_87() {
    assert_eq!((f32::from(word_of(150.0)) / 276.48).round(), -87.0);
}

#[test]
fn help_of_lmn_p_it_is_not_limited() {
    let block = restarted(ContC { sp_int: 80.0, ..automatic() });
    assert_eq!(after_one_call(block, |block| (block.lmn_p, block.lmn)), (160.0, 100.0));
}

#[test]
fn help_of_lmn_i_in_manual_mode_it_is_what_is_left_of_man() {
    let mut block = restarted(ContC { man_on: true, man: 40.0, sp_int: 10.0, ..automatic() });
    assert_eq!(calls(&mut block, 2, |block| block.lmn_i), [-20.0, 20.0]);
}

#[test]
fn help_of_er_the_dead_band_is_off_it() {
    let er = |sp_int| after_one_call(ContC { sp_int, deadb_w: 1.0, ..automatic() }, |block| block.er);
    assert_eq!((er(3.0), er(0.5)), (2.0, 0.0));
}
