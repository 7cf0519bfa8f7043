//! What `clauses.txt` cannot say of PULS_CTR.

use super::*;
use crate::table::{Block, Role, Word};

/// The controller in every fifth call, proportional with gain 1, without minimum time.
fn every_fifth() -> PulsCtr {
    let mut block = PulsCtr { red_fac: 5, ..PulsCtr::default() };
    block.di_cont_c.i_sel = false;
    block.di_cont_c.gain = 1.0;
    block.di_pulsegen.p_b_tm = Time::ms(0);
    block
}

fn restarted(mut block: PulsCtr) -> PulsCtr {
    block.restart();
    block
}

/// QPOS_P of each call; `before` is shown the number of each call, from 1 on.
fn pulses_with(block: &mut PulsCtr, calls: usize, before: impl Fn(usize, &mut PulsCtr)) -> String {
    let call = |number| {
        before(number, block);
        block.call();
        if block.qpos_p { '+' } else { '.' }
    };
    (1..=calls).map(call).collect()
}

/// In which calls LMN was made anew, with a setpoint that differs in every call.
fn controller_calls(block: &mut PulsCtr, calls: usize) -> Vec<usize> {
    let mut made = Vec::new();
    for number in 1..=calls {
        let before = block.di_cont_c.lmn;
        block.sp_int = number as f32;
        block.call();
        if block.di_cont_c.lmn != before {
            made.push(number);
        }
    }
    made
}

#[test]
fn clause_1_the_restart_is_the_program_with_com_rst_true() {
    let mut by_call = PulsCtr { com_rst: true, ..every_fifth() };
    by_call.call();
    by_call.com_rst = false;
    assert_eq!(format!("{:?}", restarted(every_fifth())), format!("{by_call:?}"));
}

#[test]
fn clause_1_without_a_restart_the_first_call_already_calls_the_controller() {
    assert_eq!(controller_calls(&mut every_fifth(), 7), [1, 6]);
}

#[test]
fn clause_3_the_pulses_are_those_of_the_two_blocks_called_in_this_order() {
    let mut block = restarted(PulsCtr { red_fac: 20, ..PulsCtr::default() });
    let mut controller =
        ContC { pvper_on: true, man_on: false, cycle: Time::ms(200), sp_int: 30.0, ..ContC::default() };
    let mut generator = Pulsegen { per_tm: Time::ms(200), cycle: Time::ms(10), ..Pulsegen::default() };
    controller.restart();
    generator.restart();
    block.sp_int = 30.0;
    let mut seen = 0;
    for call in 1..=2000_i16 {
        let word = Word::new(call.wrapping_mul(37) % 16_000);
        block.pv_per = word;
        block.call();
        if call % 20 == 0 {
            controller.pv_per = word;
            controller.call();
        }
        generator.inv = controller.lmn;
        generator.call();
        assert_eq!(block.qpos_p, generator.qpos_p, "call {call}");
        seen += i32::from(block.qpos_p);
    }
    assert!((200..1800).contains(&seen), "{seen} calls on");
}

#[test]
fn clause_5_settings_inside_are_parameters_and_what_is_wired_or_made_inside_can_be_read() {
    let role = |name| PulsCtr::TABLE.rows[PulsCtr::TABLE.find(name).unwrap()].role;
    for name in ["DI_CONT_C.GAIN", "DI_CONT_C.MAN_ON", "DI_CONT_C.DISV", "DI_PULSEGEN.P_B_TM", "DI_PULSEGEN.SYN_ON"] {
        assert_eq!(role(name), Role::Parameter, "{name}");
    }
    for name in [
        "DI_CONT_C.COM_RST",
        "DI_CONT_C.CYCLE",
        "DI_CONT_C.SP_INT",
        "DI_CONT_C.PV_PER",
        "DI_CONT_C.LMN",
        "DI_PULSEGEN.INV",
        "DI_PULSEGEN.PER_TM",
        "DI_PULSEGEN.COM_RST",
        "DI_PULSEGEN.CYCLE",
        "DI_PULSEGEN.QNEG_P",
    ] {
        assert_eq!(role(name), Role::Local, "{name}");
    }
    assert_eq!((role("RED_FAC"), role("CYCLE")), (Role::Fixed, Role::Cycle));
}

#[test]
fn clause_5_the_pulses_inside_do_not_have_a_mean_of_their_own() {
    assert_eq!(PulsCtr::TABLE.find("DI_PULSEGEN.Q_MEAN"), None);
    assert_eq!(PulsCtr::TABLE.mean, PulsCtr::TABLE.find("Q_MEAN"));
    assert!(PulsCtr::TABLE.mean.is_some());
}

#[test]
fn clause_6_the_mean_counts_the_pulses_of_the_generator_inside() {
    let pulse = |sp_int| {
        let mut block = every_fifth();
        block.di_cont_c.lmn_llm = -100.0;
        block.sp_int = sp_int;
        let mut block = restarted(block);
        pulses_with(&mut block, 6, |_, _| ());
        block.pulse()
    };
    assert_eq!([pulse(40.0), pulse(-40.0), pulse(0.0)], [1, -1, 0]);
}

#[test]
fn red_fac_below_1_is_refused_with_its_value_and_the_remedy() {
    for red_fac in [0, -1, Int::MIN] {
        let error = PulsCtr { red_fac, ..PulsCtr::default() }.check().unwrap_err();
        assert!(error.starts_with(&format!("RED_FAC is {red_fac}, ")), "{error}");
        assert!(error.ends_with("set RED_FAC to 1 or more"), "{error}");
    }
    assert_eq!(PulsCtr { red_fac: 1, ..PulsCtr::default() }.check(), Ok(()));
}

#[test]
fn a_sampling_time_of_the_controller_beyond_time_is_refused_with_the_remedy() {
    let check = |cycle, red_fac| PulsCtr { cycle: Time::ms(cycle), red_fac, ..PulsCtr::default() }.check();
    assert_eq!(check(10_737_418, 200), Ok(()));
    let error = check(10_737_419, 200).unwrap_err();
    assert!(error.starts_with("CYCLE is 10737.419 s and RED_FAC 200, "), "{error}");
    assert!(error.contains("2147483.647 s"), "{error}");
    assert!(error.contains("set RED_FAC to 199 or less"), "{error}");
    assert_eq!(check(10_737_419, 199), Ok(()));
    assert_eq!(check(i32::MAX, 1), Ok(()));
}

#[test]
fn unchecked_red_fac_below_1_does_what_the_statement_list_does() {
    // 0: sCount is 0, then -1: the controller runs in every call.
    assert_eq!(controller_calls(&mut restarted(PulsCtr { red_fac: 0, ..every_fifth() }), 3), [1, 2, 3]);
    // -1 is loaded without its sign as 65535, and sCount is -1, then -2.
    let mut block = restarted(PulsCtr { red_fac: -1, ..every_fifth() });
    assert_eq!(block.di_cont_c.cycle, Time::ms(655_350));
    assert_eq!(controller_calls(&mut block, 3), [1, 2, 3]);
    // -32768 less 1 wraps to 32767: so many calls pass before the next.
    let mut block = restarted(PulsCtr { red_fac: Int::MIN, ..every_fifth() });
    block.sp_int = 1.0;
    pulses_with(&mut block, 32_767, |_, _| ());
    assert_eq!(block.di_cont_c.lmn, 0.0);
    block.call();
    assert_eq!(block.di_cont_c.lmn, 1.0);
}

// The numbers in the help of the variables and in the documentation.

#[test]
fn the_loop_of_the_quick_start_settles_with_little_overshoot() {
    // A lag of 100 s with 4 degC per percent behind a dead time of 10 s.
    let mut block = PulsCtr { sp_int: 200.0, ..PulsCtr::default() };
    block.di_cont_c.gain = 1.04;
    block.di_cont_c.ti = Time::ms(96_000);
    block.di_cont_c.pv_fac = 4.0;
    let mut block = restarted(block);
    let mut delayed = std::collections::VecDeque::from([0.0; 1000]);
    let (mut temperature, mut highest) = (0.0, 0.0);
    for call in 1..=60_000 {
        block.pv_per = Word::new((temperature * 276.48 / 4.0) as Int);
        block.call();
        delayed.push_back(if block.qpos_p { 400.0 } else { 0.0 });
        temperature += (delayed.pop_front().unwrap() - temperature) * (0.01 / 100.0);
        highest = f64::max(highest, temperature);
        assert!(call < 30_000 || (temperature - 200.0).abs() < 4.0, "{temperature} in call {call}");
    }
    assert!(highest < 204.0, "{highest}");
}
