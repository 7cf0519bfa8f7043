//! The run that each block shows in its documentation does what its title says.

use blocks::table::number::{number, to_value};
use blocks::{Block, ContC, ContS, Hlg, PulsCtr, Pulsegen};

/// Runs the block's response and returns the rows of the variables that it shows, a value for each call.
fn run<B: Block>() -> Vec<(&'static str, Vec<f64>)> {
    let response = B::TABLE.responses[0];
    let mut block = B::default();
    let mut shown: Vec<_> = response.show.iter().map(|name| (*name, Vec::new())).collect();
    set::<B>(&mut block, 0);
    block.restart();
    for call in 1..=response.calls {
        set::<B>(&mut block, call);
        block.call();
        for (name, values) in &mut shown {
            values.push(number(block.get(row::<B>(name)).unwrap()));
        }
    }
    shown
}

fn set<B: Block>(block: &mut B, call: u32) {
    for (at, name, value) in B::TABLE.responses[0].set {
        if *at == call {
            let row = row::<B>(name);
            let value = to_value(*value, B::TABLE.rows[row].kind).unwrap();
            assert!(block.set(row, value));
        }
    }
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
    let shown = run::<ContC>();
    let at = |name, call: usize| values(&shown, name)[call - 1];
    // e = 10: P at once, I by (1 / 20) * 10 a call after half of it, D = 10 * 1 / 2.5.
    assert_eq!([at("LMN", 4), at("LMN_P", 5), at("LMN_I", 5), at("LMN_D", 5)], [0.0, 10.0, 0.25, 4.0]);
    assert_eq!(at("LMN_I", 6), 0.75);
    // Back at 0: P gone, D downwards, I as it was but for the last half step.
    assert_eq!([at("LMN_P", 40), at("LMN_I", 40), at("LMN_I", 60)], [0.0, 17.5, 17.5]);
    assert!((at("LMN_D", 40) + 4.0).abs() < 1e-3);
}

#[test]
fn cont_s_makes_a_long_pulse_and_short_ones_and_takes_the_long_one_back() {
    let shown = run::<ContS>();
    let up = "....######......###.......###.......###.......###.";
    let down = "....................................................######...........###.................###.................###";
    assert_eq!(bits(&shown, "QLMNUP").trim_end_matches('.'), up.trim_end_matches('.'));
    assert!(bits(&shown, "QLMNDN").starts_with(down), "{}", bits(&shown, "QLMNDN"));
}

#[test]
fn pulsegen_synchronizes_to_a_new_value_in_the_middle_of_a_period() {
    let shown = run::<Pulsegen>();
    let positive = "######..............######..............######....###############.....###############.....#####";
    assert_eq!(bits(&shown, "QPOS_P").trim_end_matches('.'), positive);
    let negative = format!("{}##########..........##########", ".".repeat(95));
    assert_eq!(bits(&shown, "QNEG_P").trim_end_matches('.'), negative);
}

#[test]
fn puls_ctr_makes_pulses_as_long_as_the_manipulated_value_of_their_period() {
    let shown = run::<PulsCtr>();
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
fn hlg_goes_up_stops_goes_down_at_another_slope_and_is_reset() {
    let output = values(&run::<Hlg>(), "HLG");
    let at = |call: usize| output[call - 1];
    assert_eq!(
        [at(4), at(5), at(24), at(34), at(35), at(54), at(59)],
        [0.0, 25.0, 500.0, 500.0, 525.0, 1000.0, 1000.0]
    );
    assert_eq!([at(60), at(119), at(129), at(130), at(140)], [975.0, -500.0, -500.0, 0.0, 0.0]);
}
