//! Advice about settings with which the controllers and the pulse generator may behave unexpectedly. `path` is the
//! prefix of an inner block, such as `DI_CONT_C.`, and empty otherwise.

use crate::table::number::shown;
use crate::table::{Real, Time, rnd};
use crate::{ContC, ContS, Pulsegen};

/// Returns the advice for CONT_C.
pub(crate) fn cont_c(block: &ContC, path: &str) -> Vec<String> {
    let mut advice = Vec::new();
    if block.man_on {
        let man = shown(block.man);
        advice.push(format!("{path}MAN_ON is TRUE: LMN follows MAN = {man} within its limits until MAN_ON is FALSE"));
    }
    let cycle = block.cycle.milliseconds();
    let half_cycle = f64::from(cycle) / 2.0;
    if block.i_sel {
        advice.extend(raised(path, "TI", block.ti, "CYCLE / 2", half_cycle));
    }
    if block.d_sel {
        advice.extend(raised(path, "TD", block.td, "CYCLE", f64::from(cycle)));
        advice.extend(raised(path, "TM_LAG", block.tm_lag, "CYCLE / 2", half_cycle));
    }
    advice.extend(common(path, block.gain, block.deadb_w));

    let (low, high) = (block.lmn_llm, block.lmn_hlm);
    if high <= low {
        let (low, high) = (shown(low), shown(high));
        advice.push(format!(
            "{path}LMN_HLM = {high} is not above LMN_LLM = {low}: the manipulated value is always at one of these limits"
        ));
    }
    for (name, limit) in [("LMN_HLM", high), ("LMN_LLM", low)] {
        let lmn = (limit * block.lmn_fac) + block.lmn_off;
        if i16::try_from(rnd(lmn * 276.48)).is_err() {
            let lmn = shown(lmn);
            advice.push(format!(
                "{path}LMN can reach {lmn} ({name} * LMN_FAC + LMN_OFF): beyond 118.5 % in either direction, LMN_PER wraps around to the opposite sign"
            ));
        }
    }
    advice
}

/// Returns the advice for CONT_S.
pub(crate) fn cont_s(block: &ContS) -> Vec<String> {
    let mut advice = Vec::new();
    if block.lmns_on {
        advice.push("LMNS_ON is TRUE: LMNUP and LMNDN generate the pulses until LMNS_ON is FALSE".into());
    }
    let cycle = block.cycle.milliseconds();
    if block.ti > Time::ZERO {
        advice.extend(raised("", "TI", block.ti, "CYCLE / 2", f64::from(cycle) / 2.0));
    }
    advice.extend(raised("", "MTR_TM", block.mtr_tm, "CYCLE", f64::from(cycle)));
    for (name, what, time) in [("PULSE_TM", "pulse", block.pulse_tm), ("BREAK_TM", "break", block.break_tm)] {
        if time < block.cycle {
            let (time, cycle) = (seconds(time), seconds(block.cycle));
            advice.push(format!("{name} = {time} s is below CYCLE: the shortest {what} is one CYCLE, {cycle} s"));
        }
    }
    advice.extend(common("", block.gain, block.deadb_w));
    advice
}

/// Returns the advice for PULSEGEN.
pub(crate) fn pulsegen(block: &Pulsegen, path: &str) -> Vec<String> {
    let mut advice = Vec::new();
    let (period, shortest, cycle) = (seconds(block.per_tm), seconds(block.p_b_tm), seconds(block.cycle));
    let calls = rnd(block.per_tm.real() / block.cycle.real());
    if calls <= 0 {
        advice.push(format!(
            "{path}PER_TM = {period} s is not above {path}CYCLE / 2 = {} s: no pulses are output",
            cycle / 2.0
        ));
    } else if calls < 20 {
        advice.push(format!(
            "{path}PER_TM = {period} s is {calls} times {path}CYCLE: the pulses change in steps of {} %; with \
             20 times or more, in steps of 5 % or less",
            100.0 / Real::from(calls as i16)
        ));
    }
    if shortest > period {
        advice.push(format!("{path}P_B_TM = {shortest} s is above PER_TM = {period} s: the output is always fully on"));
    } else if shortest > period / 2.0 {
        advice.push(format!(
            "{path}P_B_TM = {shortest} s is above half of PER_TM = {period} s: the output is either off or fully on"
        ));
    }
    if block.step3_on && !(0.1..=10.0).contains(&block.ratiofac) {
        let ratiofac = shown(block.ratiofac);
        advice.push(format!("{path}RATIOFAC = {ratiofac} is outside 0.1 ... 10; it is used unchanged"));
    }
    advice
}

/// Returns the advice that CONT_C and CONT_S share.
fn common(path: &str, gain: Real, deadb_w: Real) -> Vec<String> {
    let mut advice = Vec::new();
    if gain == 0.0 {
        advice.push(format!("{path}GAIN = 0: the output does not respond to the error"));
    }
    if deadb_w < 0.0 {
        let (deadb_w, wider) = (shown(deadb_w), shown(-deadb_w));
        advice.push(format!("{path}DEADB_W = {deadb_w} is below 0: it increases every error by {wider}"));
    }
    advice
}

/// Returns the advice for a time that the block raises to `lowest`, in milliseconds.
fn raised(path: &str, name: &str, time: Time, bound: &str, lowest: f64) -> Option<String> {
    let is_raised = f64::from(time.milliseconds()) < lowest;
    is_raised.then(|| {
        let (time, lowest) = (seconds(time), lowest / 1000.0);
        format!("{path}{name} = {time} s is below {path}{bound}: the block uses {lowest} s")
    })
}

fn seconds(time: Time) -> f64 {
    f64::from(time.milliseconds()) / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Law, PulsCtr};

    fn automatic() -> ContC {
        ContC { man_on: false, ..ContC::default() }
    }

    #[test]
    fn the_default_cont_c_is_in_manual_mode_and_says_so() {
        let advice = ContC { man: 30.0, ..ContC::default() }.advice();
        assert_eq!(advice, ["MAN_ON is TRUE: LMN follows MAN = 30 within its limits until MAN_ON is FALSE"]);
    }

    #[test]
    fn cont_c_with_usual_settings_has_no_advice() {
        assert_eq!(automatic().advice(), Vec::<String>::new());
        let edge = ContC {
            d_sel: true,
            ti: Time::ms(500),
            td: Time::ms(1000),
            tm_lag: Time::ms(500),
            lmn_hlm: 118.5,
            lmn_llm: -118.5,
            ..automatic()
        };
        assert_eq!(edge.advice(), Vec::<String>::new());
    }

    #[test]
    fn cont_c_names_the_times_that_it_raises_and_what_it_computes_with() {
        let short = ContC { d_sel: true, ti: Time::ms(499), td: Time::ms(999), tm_lag: Time::ms(0), ..automatic() };
        let expected = [
            "TI = 0.499 s is below CYCLE / 2: the block uses 0.5 s",
            "TD = 0.999 s is below CYCLE: the block uses 1 s",
            "TM_LAG = 0 s is below CYCLE / 2: the block uses 0.5 s",
        ];
        assert_eq!(short.advice(), expected);
    }

    #[test]
    fn a_time_of_an_action_that_is_off_needs_no_advice() {
        let off = ContC { i_sel: false, ti: Time::ms(0), td: Time::ms(0), tm_lag: Time::ms(0), ..automatic() };
        assert_eq!(off.advice(), Vec::<String>::new());
    }

    #[test]
    fn a_negative_dead_band_makes_errors_larger_as_the_advice_says() {
        let mut block = ContC { deadb_w: -1.5, sp_int: 2.0, ..automatic() };
        assert_eq!(block.advice(), ["DEADB_W = -1.5 is below 0: it increases every error by 1.5"]);
        block.call();
        assert_eq!(block.er, 3.5);
        assert_eq!(ContS { deadb_w: -1.0, ..ContS::default() }.advice().len(), 1);
    }

    #[test]
    fn a_number_that_nobody_can_read_in_full_has_an_exponent() {
        let block = ContC { man_on: true, man: 1e-40, lmn_hlm: 3.4e38, ..automatic() };
        let expected = [
            "MAN_ON is TRUE: LMN follows MAN = 1e-40 within its limits until MAN_ON is FALSE",
            "LMN can reach 3.4e38 (LMN_HLM * LMN_FAC + LMN_OFF): beyond 118.5 % in either direction, LMN_PER wraps around to the opposite sign",
        ];
        assert_eq!(block.advice(), expected);
    }

    #[test]
    fn limits_in_the_wrong_order_and_a_gain_of_0_are_named() {
        let block = ContC { lmn_hlm: -5.0, lmn_llm: 10.0, gain: 0.0, ..automatic() };
        let expected = [
            "GAIN = 0: the output does not respond to the error",
            "LMN_HLM = -5 is not above LMN_LLM = 10: the manipulated value is always at one of these limits",
        ];
        assert_eq!(block.advice(), expected);
        assert_eq!(ContC { lmn_hlm: 0.0, ..automatic() }.advice().len(), 1, "equal limits");
        assert_eq!(ContS { gain: 0.0, ..ContS::default() }.advice(), [expected[0]]);
    }

    #[test]
    fn a_manipulated_value_at_which_lmn_per_wraps_is_named() {
        let block = ContC { lmn_fac: 1.5, lmn_off: -10.0, lmn_llm: -100.0, ..automatic() };
        let expected = [
            "LMN can reach 140 (LMN_HLM * LMN_FAC + LMN_OFF): beyond 118.5 % in either direction, LMN_PER wraps around to the opposite sign",
            "LMN can reach -160 (LMN_LLM * LMN_FAC + LMN_OFF): beyond 118.5 % in either direction, LMN_PER wraps around to the opposite sign",
        ];
        assert_eq!(block.advice(), expected);
    }

    #[test]
    fn cont_s_names_manual_mode_and_the_times_that_are_shorter_than_a_call() {
        let short = ContS {
            lmns_on: true,
            ti: Time::ms(499),
            mtr_tm: Time::ms(999),
            pulse_tm: Time::ms(500),
            break_tm: Time::ms(0),
            ..ContS::default()
        };
        let expected = [
            "LMNS_ON is TRUE: LMNUP and LMNDN generate the pulses until LMNS_ON is FALSE",
            "TI = 0.499 s is below CYCLE / 2: the block uses 0.5 s",
            "MTR_TM = 0.999 s is below CYCLE: the block uses 1 s",
            "PULSE_TM = 0.5 s is below CYCLE: the shortest pulse is one CYCLE, 1 s",
            "BREAK_TM = 0 s is below CYCLE: the shortest break is one CYCLE, 1 s",
        ];
        assert_eq!(short.advice(), expected);
        let edge = ContS { ti: Time::ms(500), mtr_tm: Time::ms(1000), pulse_tm: Time::ms(1000), ..ContS::default() };
        assert_eq!(edge.advice(), Vec::<String>::new());
        assert_eq!(ContS { ti: Time::ZERO, ..ContS::default() }.advice(), Vec::<String>::new(), "the I action is off");
    }

    #[test]
    fn pulsegen_names_the_resolution_of_a_short_period() {
        let of = |per_tm| Pulsegen { per_tm: Time::ms(per_tm), p_b_tm: Time::ms(0), ..Pulsegen::default() }.advice();
        assert_eq!(of(200), Vec::<String>::new());
        let expected = "PER_TM = 0.08 s is 8 times CYCLE: the pulses change in steps of 12.5 %; with 20 times or more, in \
                        steps of 5 % or less";
        assert_eq!(of(80), [expected]);
        assert_eq!(of(5), ["PER_TM = 0.005 s is not above CYCLE / 2 = 0.005 s: no pulses are output"]);
    }

    #[test]
    fn pulsegen_names_a_shortest_pulse_that_leaves_only_off_and_on() {
        let of = |p_b_tm| Pulsegen { p_b_tm: Time::ms(p_b_tm), ..Pulsegen::default() }.advice();
        assert_eq!(of(500), Vec::<String>::new());
        assert_eq!(of(501), ["P_B_TM = 0.501 s is above half of PER_TM = 1 s: the output is either off or fully on"]);
        assert_eq!(of(1001), ["P_B_TM = 1.001 s is above PER_TM = 1 s: the output is always fully on"]);
    }

    #[test]
    fn pulsegen_names_a_ratio_outside_its_range_where_it_is_used() {
        let of = |step3_on, ratiofac| Pulsegen { step3_on, ratiofac, ..Pulsegen::default() }.advice();
        assert_eq!(of(true, 0.05), ["RATIOFAC = 0.05 is outside 0.1 ... 10; it is used unchanged"]);
        assert_eq!(of(true, 11.0).len(), 1);
        assert_eq!(of(false, 11.0), Vec::<String>::new());
        assert_eq!([of(true, 0.1), of(true, 10.0)], [Vec::<String>::new(), Vec::new()]);
    }

    #[test]
    fn puls_ctr_names_the_settings_of_its_inner_blocks_by_their_paths_and_knows_their_cycles() {
        let mut block = PulsCtr { red_fac: 10, ..PulsCtr::default() };
        block.di_cont_c.ti = Time::ms(49);
        block.di_cont_c.man_on = true;
        let expected = [
            "DI_CONT_C.MAN_ON is TRUE: LMN follows MAN = 0 within its limits until MAN_ON is FALSE",
            "DI_CONT_C.TI = 0.049 s is below DI_CONT_C.CYCLE / 2: the block uses 0.05 s",
            "DI_PULSEGEN.PER_TM = 0.1 s is 10 times DI_PULSEGEN.CYCLE: the pulses change in steps of 10 %; with 20 times or \
             more, in steps of 5 % or less",
        ];
        assert_eq!(block.advice(), expected);
        assert_eq!(PulsCtr::default().advice(), Vec::<String>::new());
    }
}
