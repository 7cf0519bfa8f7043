//! What `clauses.txt` cannot say of CONT_S.

use super::*;
use crate::table::Block;

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
fn clause_8_the_threshold_is_adapted_in_manual_mode_too() {
    let mut block = restarted(ContS { sp_int: 8.0, pv_in: -8.0, lmns_on: true, ..slow_motor() });
    block.call();
    assert_eq!(block.memory.on, 8.0);
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
    let mean = ContS::TABLE.mean.map(|row| ContS::TABLE.rows[row].name);
    assert_eq!(mean, Some("QLMN_MEAN"));
}
