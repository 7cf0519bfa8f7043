//! The runs and characteristics that each block shows in its documentation do what their titles say.

use blocks::table::number::{number, to_value};
use blocks::{Block, ContC, ContS, Hlg, Law, PulsCtr, Pulsegen};

/// Runs the block's response of this number and returns the rows of the variables that it shows, a value for each call.
fn run<B: Block>(number_of_response: usize) -> Vec<(&'static str, Vec<f64>)> {
    let response = B::TABLE.responses[number_of_response];
    let mut block = B::default();
    let mut shown: Vec<_> = response.show.iter().map(|name| (*name, Vec::new())).collect();
    set(&mut block, response.set, 0);
    block.restart();
    for call in 0..response.calls {
        if call > 0 {
            set(&mut block, response.set, call);
        }
        block.call();
        for (name, values) in &mut shown {
            values.push(number(block.get(row::<B>(name)).unwrap()));
        }
    }
    shown
}

fn set<B: Block>(block: &mut B, what: &[(u32, &str, f64)], call: u32) {
    for (at, name, value) in what {
        if *at == call {
            let row = row::<B>(name);
            let value = to_value(*value, B::TABLE.rows[row].kind).unwrap();
            assert!(block.set(row, value));
        }
    }
}

/// The block's characteristic of this number: the mean of a variable that it shows at this value of its variable.
fn mean<B: Block>(number_of_characteristic: usize, at: f64, name: &str) -> f64 {
    let characteristic = B::TABLE.characteristics[number_of_characteristic];
    assert!(characteristic.show.contains(&name), "{name} is not shown");
    let mut block = B::default();
    for (name, value) in characteristic.set.iter().chain(&[(characteristic.variable, at)]) {
        set(&mut block, &[(0, *name, *value)], 0);
    }
    block.restart();
    let calls = (0..characteristic.calls).map(|_| {
        block.call();
        number(block.get(row::<B>(name)).unwrap())
    });
    calls.sum::<f64>() / f64::from(characteristic.calls)
}

fn row<B: Block>(name: &str) -> usize {
    B::TABLE.find(name).unwrap_or_else(|| panic!("{} has no {name}", B::TABLE.name))
}

fn values(shown: &[(&'static str, Vec<f64>)], name: &str) -> Vec<f64> {
    shown.iter().find(|(shown, _)| *shown == name).unwrap_or_else(|| panic!("{name} is not shown")).1.clone()
}

/// A bit over the calls: `#` is TRUE.
fn bits(shown: &[(&'static str, Vec<f64>)], name: &str) -> String {
    values(shown, name).iter().map(|value| if *value == 0.0 { '.' } else { '#' }).collect()
}

#[test]
fn cont_c_answers_a_setpoint_step_with_p_i_and_d() {
    let shown = run::<ContC>(0);
    let at = |name, call: usize| values(&shown, name)[call];
    // e = 10: P at once, I by (1 / 20) * 10 a call after half of it, D = 10 * 1 / 2.5.
    assert_eq!([at("LMN", 4), at("LMN_P", 5), at("LMN_I", 5), at("LMN_D", 5)], [0.0, 10.0, 0.25, 4.0]);
    assert_eq!(at("LMN_I", 6), 0.75);
    // Back at 0: P gone, D downwards, I as it was but for the last half step.
    assert_eq!([at("LMN_P", 40), at("LMN_I", 40), at("LMN_I", 59)], [0.0, 17.5, 17.5]);
    assert!((at("LMN_D", 40) + 4.0).abs() < 1e-3);
}

#[test]
fn cont_c_with_p_action_alone_is_proportional_to_the_error() {
    let lmn = values(&run::<ContC>(1), "LMN");
    assert_eq!([lmn[4], lmn[5], lmn[24], lmn[25], lmn[44], lmn[45]], [0.0, 20.0, 20.0, 40.0, 40.0, 0.0]);
}

#[test]
fn cont_c_integrates_a_constant_error_and_keeps_the_integral_without_one() {
    let shown = run::<ContC>(2);
    let (p, i) = (values(&shown, "LMN_P"), values(&shown, "LMN_I"));
    assert_eq!((p[5], i[25] - i[5], i[45] - i[25]), (20.0, 20.0, 19.5));
    assert_eq!((p[45], i[45], i[59]), (0.0, 40.0, 40.0));
}

#[test]
fn cont_c_applies_gain_to_all_three_parts() {
    let shown = run::<ContC>(3);
    let [p, i, d] = ["LMN_P", "LMN_I", "LMN_D"].map(|name| values(&shown, name));
    assert_eq!((p[29], p[30]), (10.0, 20.0));
    assert_eq!((i[28] - i[27], i[41] - i[40]), (0.5, 1.0));
    assert!(d[29].abs() < 1e-3 && (d[30] - 20.0).abs() < 1e-3 && d[59].abs() < 1e-3, "{d:?}");
}

#[test]
fn cont_c_at_a_limit_stops_the_integral_and_leaves_the_limit_with_the_error() {
    let shown = run::<ContC>(4);
    let [lmn, i] = ["LMN", "LMN_I"].map(|name| values(&shown, name));
    assert!(lmn[12..40].iter().all(|lmn| *lmn == 100.0) && i[12..40].iter().all(|i| *i == 22.0));
    assert!(bits(&shown, "QLMN_HLM")[12..41].contains("############################."));
    assert_eq!((i[11], lmn[40]), (18.0, 0.0));
    assert!(lmn[43..66].iter().all(|lmn| (0.0..10.0).contains(lmn)), "{lmn:?}");
}

#[test]
fn cont_c_changes_to_automatic_mode_without_a_jump() {
    let shown = run::<ContC>(5);
    let [lmn, p, i] = ["LMN", "LMN_P", "LMN_I"].map(|name| values(&shown, name));
    assert_eq!(bits(&shown, "MAN_ON"), format!("{}{}", "#".repeat(20), ".".repeat(40)));
    assert_eq!((p[19], i[19]), (10.0, 30.0));
    assert_eq!([lmn[19], lmn[20], lmn[21]], [40.0, 40.5, 41.0]);
}

#[test]
fn cont_c_jumps_back_if_the_manual_value_changed_in_the_last_manual_call() {
    let shown = run::<ContC>(6);
    let [lmn, i] = ["LMN", "LMN_I"].map(|name| values(&shown, name));
    assert_eq!([lmn[18], lmn[19], lmn[20]], [40.0, 60.0, 40.5]);
    assert_eq!([i[18], i[19], i[20]], [30.0, 30.0, 30.5]);
    assert_eq!([lmn[39], lmn[40]], [50.0, 60.0]);
}

#[test]
fn cont_c_holds_and_sets_the_integral() {
    let i = values(&run::<ContC>(7), "LMN_I");
    assert_eq!([i[14], i[15], i[29], i[30]], [47.25, 47.25, 47.25, 47.75]);
    assert_eq!([i[44], i[45], i[49], i[50]], [54.75, 40.0, 40.0, 40.5]);
}

#[test]
fn cont_c_takes_the_dead_band_off_the_error() {
    let er = values(&run::<ContC>(8), "ER");
    assert_eq!([er[5], er[15], er[25], er[40], er[50]], [0.0, 0.0, 3.0, -3.0, 0.0]);
    for (difference, er) in [(-50.0, -40.0), (-11.0, -1.0), (-10.0, 0.0), (5.0, 0.0), (10.0, 0.0), (12.0, 2.0)] {
        assert_eq!(mean::<ContC>(0, difference, "ER"), er, "difference {difference}");
    }
}

#[test]
fn cont_c_limits_before_it_scales() {
    for (man, lmn) in [(-50.0, 10.0), (0.0, 10.0), (40.0, 30.0), (80.0, 50.0), (150.0, 50.0)] {
        assert_eq!(mean::<ContC>(1, man, "LMN"), lmn, "MAN {man}");
    }
}

#[test]
fn cont_c_wraps_its_analog_word_beyond_118_5_percent() {
    let words = values(&run::<ContC>(9), "LMN_PER");
    let expected = [13824.0, 27648.0, 32625.0, -32358.0, -24064.0, 32358.0];
    assert_eq!([words[5], words[10], words[20], words[30], words[40], words[50]], expected);
    for (man, word) in [(-150.0, 24064.0), (-118.5, -32763.0), (0.0, 0.0), (118.5, 32763.0), (119.0, -32635.0)] {
        assert_eq!(mean::<ContC>(2, man, "LMN_PER"), word, "MAN {man}");
    }
}

#[test]
fn cont_s_makes_a_long_pulse_and_short_ones_and_takes_the_long_one_back() {
    let shown = run::<ContS>(0);
    let up = ".....######......###.......###.......###.......###.";
    let down = ".....................................................######...........###.................###.................###";
    assert_eq!(bits(&shown, "QLMNUP").trim_end_matches('.'), up.trim_end_matches('.'));
    assert!(bits(&shown, "QLMNDN").starts_with(down), "{}", bits(&shown, "QLMNDN"));
}

#[test]
fn pulsegen_synchronizes_to_a_new_value_in_the_middle_of_a_period() {
    let shown = run::<Pulsegen>(0);
    let positive = "######..............######..............######.....###############.....###############.....#####";
    assert_eq!(bits(&shown, "QPOS_P").trim_end_matches('.'), positive);
    let negative = format!("{}##########..........##########", ".".repeat(96));
    assert_eq!(bits(&shown, "QNEG_P").trim_end_matches('.'), negative);
}

#[test]
fn puls_ctr_makes_pulses_as_long_as_the_manipulated_value_of_their_period() {
    let shown = run::<PulsCtr>(0);
    let lmn = values(&shown, "DI_CONT_C.LMN");
    let pulses = bits(&shown, "QPOS_P");
    for (period, calls) in [(1, 5), (2, 6), (3, 8), (4, 10), (5, 11), (6, 13), (7, 14)] {
        let first = 20 * period;
        assert_eq!(lmn[first - 1], 16.0 + 8.0 * period as f64, "LMN of period {period}");
        assert_eq!(pulses[first..first + 20], format!("{}{}", "#".repeat(calls), ".".repeat(20 - calls)));
    }
    assert_eq!(pulses[..20], ".".repeat(20));
}

#[test]
fn puls_ctr_changes_from_positive_to_negative_pulses_when_the_controller_has_run() {
    let shown = run::<PulsCtr>(1);
    let period = |calls: usize| format!("{}{}", "#".repeat(calls), ".".repeat(20 - calls));
    let none = ".".repeat(20);
    let positive = [none.clone(), period(6).repeat(3), none.repeat(4)].concat();
    assert_eq!(bits(&shown, "QPOS_P"), positive);
    assert_eq!(bits(&shown, "DI_PULSEGEN.QNEG_P"), [none.repeat(4), period(12).repeat(4)].concat());
    let lmn = values(&shown, "DI_CONT_C.LMN");
    assert_eq!([lmn[18], lmn[19], lmn[78], lmn[79]], [0.0, 30.0, 30.0, -60.0]);
}

#[test]
fn puls_ctr_leaves_out_pulses_and_breaks_that_are_too_short() {
    let shown = run::<PulsCtr>(2);
    let lmn = values(&shown, "DI_CONT_C.LMN");
    let pulses = bits(&shown, "QPOS_P");
    for (period, value, calls) in
        [(1, 50.0, 10), (2, 25.0, 5), (3, 15.0, 0), (4, 75.0, 15), (5, 85.0, 20), (6, 50.0, 10)]
    {
        let first = 20 * period;
        assert_eq!(lmn[first - 1], value, "LMN of period {period}");
        assert_eq!(pulses[first..first + 20], format!("{}{}", "#".repeat(calls), ".".repeat(20 - calls)));
    }
}

#[test]
fn hlg_goes_up_stops_goes_down_at_another_slope_and_is_reset() {
    let output = values(&run::<Hlg>(0), "HLG");
    let at = |call: usize| output[call];
    assert_eq!(
        [at(4), at(5), at(24), at(34), at(35), at(54), at(59)],
        [0.0, 25.0, 500.0, 500.0, 525.0, 1000.0, 1000.0]
    );
    assert_eq!([at(60), at(119), at(129), at(130), at(139)], [975.0, -500.0, -500.0, 0.0, 0.0]);
}

#[test]
fn cont_s_with_the_p_action_alone_makes_six_calls_up_and_three_down() {
    let shown = run::<ContS>(1);
    // 20 % are 6 calls of 100 / 30 %.
    assert_eq!(bits(&shown, "QLMNUP").trim_end_matches('.'), ".....######");
    assert_eq!(bits(&shown, "QLMNDN").trim_end_matches('.'), format!("{}###", ".".repeat(30)));
}

#[test]
fn cont_s_by_hand_makes_pulses_of_at_least_pulse_tm() {
    let shown = run::<ContS>(2);
    assert_eq!(bits(&shown, "QLMNUP").trim_end_matches('.'), ".....######");
    assert_eq!(bits(&shown, "QLMNDN").trim_end_matches('.'), format!("{}###", ".".repeat(25)));
}

#[test]
fn cont_s_ends_a_pulse_at_the_stop_and_goes_down_freely() {
    let shown = run::<ContS>(3);
    let (up, down) = (bits(&shown, "QLMNUP"), bits(&shown, "QLMNDN"));
    assert_eq!(up.trim_end_matches('.'), ".....##########");
    assert_eq!(down.find('#'), Some(30));
}

#[test]
fn pulsegen_in_two_steps_bipolar_is_half_on_at_0() {
    let shown = run::<Pulsegen>(1);
    let (on, off) = (bits(&shown, "QPOS_P"), bits(&shown, "QNEG_P"));
    assert_eq!([on[..20].matches('#').count(), on[60..80].matches('#').count()], [10, 4]);
    assert_eq!(on[100..], "#".repeat(20));
    assert!(on.chars().zip(off.chars()).all(|(on, off)| on != off));
}

#[test]
fn pulsegen_with_half_a_ratio_makes_negative_pulses_half_as_long() {
    let shown = run::<Pulsegen>(2);
    assert_eq!(bits(&shown, "QPOS_P")[20..40], format!("{}{}", "#".repeat(10), ".".repeat(10)));
    assert_eq!(bits(&shown, "QNEG_P")[60..80].matches('#').count(), 5);
}

#[test]
fn pulsegen_leaves_out_pulses_and_breaks_below_the_minimum() {
    let on = bits(&run::<Pulsegen>(3), "QPOS_P");
    assert_eq!([on[..40].matches('#').count(), on[60..80].matches('#').count()], [0, 5]);
    assert_eq!(on[100..], "#".repeat(20));
}

#[test]
fn pulsegen_by_hand_follows_the_commands_and_starts_a_period_afterwards() {
    let shown = run::<Pulsegen>(4);
    let (positive, negative) = (bits(&shown, "QPOS_P"), bits(&shown, "QNEG_P"));
    assert_eq!(positive[10..45], format!(".....##{}", ".".repeat(28)));
    assert_eq!(negative[10..45], format!("{}#####.....#####.....", ".".repeat(15)));
    assert_eq!(positive[45..65], format!("######{}", ".".repeat(14)));
}

#[test]
fn the_characteristics_of_pulsegen_are_those_of_the_manuals_figures() {
    let share = |number, inv, name| mean::<Pulsegen>(number, inv, name);
    let three_step = |number, inv| (share(number, inv, "QPOS_P"), share(number, inv, "QNEG_P"));
    for (inv, positive) in [(4.0, 0.0), (5.0, 0.05), (50.0, 0.5), (95.0, 0.95), (96.0, 1.0)] {
        assert_eq!((three_step(0, inv), three_step(0, -inv)), ((positive, 0.0), (0.0, positive)), "{inv}");
    }
    assert_eq!((three_step(1, 50.0), three_step(1, -50.0)), ((0.5, 0.0), (0.0, 0.25)));
    assert_eq!((three_step(1, -100.0), three_step(1, -4.0)), ((0.0, 0.5), (0.0, 0.0)));
    for (inv, on) in [(-100.0, 0.0), (-50.0, 0.25), (0.0, 0.5), (50.0, 0.75), (100.0, 1.0)] {
        assert_eq!(three_step(2, inv), (on, 1.0 - on), "bipolar {inv}");
    }
    for (inv, on) in [(-50.0, 0.0), (0.0, 0.0), (50.0, 0.5), (100.0, 1.0)] {
        assert_eq!(three_step(3, inv), (on, 1.0 - on), "monopolar {inv}");
    }
}

#[test]
fn hlg_falls_from_init_by_50_a_call_and_stays_at_set_point_0() {
    let output = values(&run::<Hlg>(1), "HLG");
    // Up to 500 by 25 a call.
    assert_eq!(
        [output[0], output[15], output[24], output[25], output[26], output[59]],
        [25.0, 600.0, 600.0, 550.0, 500.0, 500.0]
    );
}

#[test]
fn hlg_carries_the_remainder_on_and_jumps_without_a_return_time() {
    let output = values(&run::<Hlg>(2), "HLG");
    assert_eq!(
        [output[0], output[1], output[2], output[3], output[19], output[20]],
        [2.0, 5.0, 7.0, 10.0, 10.0, -10.0]
    );
}

#[test]
fn what_the_help_of_cont_s_claims_of_its_pulses_is_so() {
    // LMNUP for 6 s is 6 calls; an error of 8 beyond the dead band of 1 demands 16 % after manual mode.
    let mut block = ContS { lmns_on: true, sp_int: 9.0, ..ContS::default() };
    block.restart();
    block.call();
    assert!(!block.qlmnup && !block.qlmndn);
    block.lmns_on = false;
    block.call();
    assert!(block.qlmnup);
    // With GAIN = 2 an error of 5 beyond the dead band makes a pulse, less does not at once.
    for (sp_int, pulses) in [(6.0, true), (5.9, false)] {
        let mut block = ContS { sp_int, ti: blocks::Time::ms(2_000_000), ..ContS::default() };
        block.restart();
        block.call();
        assert_eq!(block.qlmnup, pulses, "SP_INT = {sp_int}");
    }
}
