//! The runs and characteristics that each block shows in its documentation do what their titles say.

use blocks::table::number::{number, to_value};
use blocks::{Block, ContC, ContS, Hlg, PulsCtr, Pulsegen};

/// Runs the block's response of this number and returns the rows of the variables that it shows, a value for each call.
fn run<B: Block>(number_of_response: usize) -> Vec<(&'static str, Vec<f64>)> {
    let response = B::TABLE.responses[number_of_response];
    let mut block = B::default();
    let mut shown: Vec<_> = response.show.iter().map(|name| (*name, Vec::new())).collect();
    set(&mut block, response.set, 0);
    block.restart();
    for call in 1..=response.calls {
        set(&mut block, response.set, call);
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
    let at = |name, call: usize| values(&shown, name)[call - 1];
    // e = 10: P at once, I by (1 / 20) * 10 a call after half of it, D = 10 * 1 / 2.5.
    assert_eq!([at("LMN", 4), at("LMN_P", 5), at("LMN_I", 5), at("LMN_D", 5)], [0.0, 10.0, 0.25, 4.0]);
    assert_eq!(at("LMN_I", 6), 0.75);
    // Back at 0: P gone, D downwards, I as it was but for the last half step.
    assert_eq!([at("LMN_P", 40), at("LMN_I", 40), at("LMN_I", 60)], [0.0, 17.5, 17.5]);
    assert!((at("LMN_D", 40) + 4.0).abs() < 1e-3);
}

#[test]
fn cont_c_with_p_action_alone_is_proportional_to_the_error() {
    let lmn = values(&run::<ContC>(1), "LMN");
    assert_eq!([lmn[3], lmn[4], lmn[23], lmn[24], lmn[43], lmn[44]], [0.0, 20.0, 20.0, 40.0, 40.0, 0.0]);
}

#[test]
fn cont_c_integrates_a_constant_error_and_keeps_the_integral_without_one() {
    let shown = run::<ContC>(2);
    let (p, i) = (values(&shown, "LMN_P"), values(&shown, "LMN_I"));
    assert_eq!((p[4], i[24] - i[4], i[44] - i[24]), (20.0, 20.0, 19.5));
    assert_eq!((p[44], i[44], i[59]), (0.0, 40.0, 40.0));
}

#[test]
fn cont_c_applies_gain_to_all_three_parts() {
    let shown = run::<ContC>(3);
    let [p, i, d] = ["LMN_P", "LMN_I", "LMN_D"].map(|name| values(&shown, name));
    assert_eq!((p[28], p[29]), (10.0, 20.0));
    assert_eq!((i[27] - i[26], i[40] - i[39]), (0.5, 1.0));
    assert!(d[28].abs() < 1e-3 && (d[29] - 20.0).abs() < 1e-3 && d[59].abs() < 1e-3, "{d:?}");
}

#[test]
fn cont_c_at_a_limit_stops_the_integral_and_leaves_the_limit_with_the_error() {
    let shown = run::<ContC>(4);
    let [lmn, i] = ["LMN", "LMN_I"].map(|name| values(&shown, name));
    assert!(lmn[11..39].iter().all(|lmn| *lmn == 100.0) && i[11..39].iter().all(|i| *i == 22.0));
    assert!(bits(&shown, "QLMN_HLM")[11..40].contains("############################."));
    assert_eq!((i[10], lmn[39]), (18.0, 0.0));
    assert!(lmn[42..65].iter().all(|lmn| (0.0..10.0).contains(lmn)), "{lmn:?}");
}

#[test]
fn cont_c_changes_to_automatic_mode_without_a_jump() {
    let shown = run::<ContC>(5);
    let [lmn, p, i] = ["LMN", "LMN_P", "LMN_I"].map(|name| values(&shown, name));
    assert_eq!(bits(&shown, "MAN_ON"), format!("{}{}", "#".repeat(19), ".".repeat(41)));
    assert_eq!((p[18], i[18]), (10.0, 30.0));
    assert_eq!([lmn[18], lmn[19], lmn[20]], [40.0, 40.5, 41.0]);
}

#[test]
fn cont_c_jumps_back_if_the_manual_value_changed_in_the_last_manual_call() {
    let shown = run::<ContC>(6);
    let [lmn, i] = ["LMN", "LMN_I"].map(|name| values(&shown, name));
    assert_eq!([lmn[17], lmn[18], lmn[19]], [40.0, 60.0, 40.5]);
    assert_eq!([i[17], i[18], i[19]], [30.0, 30.0, 30.5]);
    assert_eq!([lmn[38], lmn[39]], [50.0, 60.0]);
}

#[test]
fn cont_c_holds_and_sets_the_integral() {
    let i = values(&run::<ContC>(7), "LMN_I");
    assert_eq!([i[13], i[14], i[28], i[29]], [46.75, 46.75, 46.75, 47.25]);
    assert_eq!([i[43], i[44], i[48], i[49]], [54.25, 40.0, 40.0, 40.5]);
}

#[test]
fn cont_c_takes_the_dead_band_off_the_error() {
    let er = values(&run::<ContC>(8), "ER");
    assert_eq!([er[4], er[14], er[24], er[39], er[49]], [0.0, 0.0, 3.0, -3.0, 0.0]);
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
    let up = "....######......###.......###.......###.......###.";
    let down = "....................................................######...........###.................###.................###";
    assert_eq!(bits(&shown, "QLMNUP").trim_end_matches('.'), up.trim_end_matches('.'));
    assert!(bits(&shown, "QLMNDN").starts_with(down), "{}", bits(&shown, "QLMNDN"));
}

#[test]
fn pulsegen_synchronizes_to_a_new_value_in_the_middle_of_a_period() {
    let shown = run::<Pulsegen>(0);
    let positive = "######..............######..............######....###############.....###############.....#####";
    assert_eq!(bits(&shown, "QPOS_P").trim_end_matches('.'), positive);
    let negative = format!("{}##########..........##########", ".".repeat(95));
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
    let at = |call: usize| output[call - 1];
    assert_eq!(
        [at(4), at(5), at(24), at(34), at(35), at(54), at(59)],
        [0.0, 25.0, 500.0, 500.0, 525.0, 1000.0, 1000.0]
    );
    assert_eq!([at(60), at(119), at(129), at(130), at(140)], [975.0, -500.0, -500.0, 0.0, 0.0]);
}
