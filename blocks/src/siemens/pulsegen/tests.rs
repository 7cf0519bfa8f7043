//! What `clauses.txt` cannot say of PULSEGEN.

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

#[test]
fn clause_9_an_inv_that_is_nan_is_no_change() {
    let mut block = restarted(ten_calls());
    let run = pulses_with(&mut block, 12, |number, block| block.inv = if number == 3 { Real::NAN } else { 60.0 });
    assert_eq!(run, "++++++....++");
}

#[test]
fn an_inv_that_is_nan_makes_no_pulse() {
    let run = |step3_on| pulses(&mut restarted(Pulsegen { inv: Real::NAN, step3_on, ..ten_calls() }), 10);
    assert_eq!((run(true).as_str(), run(false).as_str()), ("..........", "----------"));
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
    let mean = Pulsegen::TABLE.mean.map(|row| Pulsegen::TABLE.rows[row].name);
    assert_eq!(mean, Some("Q_MEAN"));
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
