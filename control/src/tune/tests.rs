use super::home::{Controllers, Pid};
use super::*;
use crate::process::Process;
use blocks::{Law, Time};
use run::test_home::FOREIGN;

fn lag(gain: f64, time_constant: f64, dead_time: f64) -> Model {
    Model { gain, time_constant, dead_time, ..Model::default() }
}

fn request(fmu: &str, rule: Rule, structure: Structure, model: Model, values: &[(&str, f64)]) -> Request {
    let values = values.iter().map(|(name, value)| ((*name).into(), Value::Number(*value))).collect();
    Request {
        model,
        rule,
        structure,
        controller: Member { name: "TIC101".into(), fmu: fmu.into(), values },
        closed_loop: None,
        pace: None,
        step: Step::default(),
        ultimate: None,
    }
}

fn tuned(request: &Request) -> Tuned {
    tune(&Controllers, request).unwrap()
}

fn error(request: &Request) -> String {
    format!("{:#}", tune(&Controllers, request).unwrap_err())
}

fn number(tuned: &Tuned, name: &str) -> f64 {
    match tuned.values[name] {
        Value::Number(value) => value,
        Value::Boolean(_) => panic!("{name} is a switch"),
    }
}

fn is_on(tuned: &Tuned, name: &str) -> bool {
    tuned.values[name] == Value::Boolean(true)
}

#[test]
fn the_prediction_is_for_the_step_that_the_user_makes() {
    let mut request = request("PID", Rule::Simc, Structure::Pi, lag(2.0, 8.0, 1.0), &[("CYCLE", 0.2), ("SP", 20.0)]);
    request.step = Step { from: Some(50.0), size: Some(-4.0), manual: Some(30.0) };
    let predicted = tuned(&request).predicted;
    let ends = |values: &[f64]| (values[0], values[values.len() - 1]);
    assert_eq!(ends(&predicted.setpoint), (50.0, 46.0));
    assert!((ends(&predicted.process_value).1 - 46.0).abs() < 0.01 && predicted.process_value[0] == 50.0);
    // 4 down need 2 % less; on its way the manipulated value goes GAIN times 4 down and comes back.
    let (first, last) = ends(&predicted.manipulated_value);
    assert!((first - 30.0).abs() < 1e-3 && (last - 28.0).abs() < 0.01, "{first} {last}");
    // 7.3 down at once and 1 more in the dead time, 6.3 up again, and a little of both.
    let travel = predicted.travel.unwrap();
    assert!((14.5..15.5).contains(&travel), "{travel}");
    request.step.size = Some(0.0);
    let remarks = tuned(&request).remarks;
    assert!(remarks.iter().any(|remark| remark.contains("the step is 0")), "{remarks:?}");
}

#[test]
fn the_table_has_all_rules_for_one_step_and_says_which_do_not_apply() {
    let request = request("PID", Rule::Simc, Structure::P, lag(2.0, 8.0, 1.0), &[("CYCLE", 0.2)]);
    let rows = table(&Controllers, &request).unwrap();
    assert_eq!(rows.len(), 27);
    let find = |rule, structure| rows.iter().find(|row| row.rule == rule && row.structure == structure).unwrap();
    let simc = find(Rule::Simc, Structure::Pi);
    let alone = tuned(&Request { structure: Structure::Pi, ..request.clone() });
    assert_eq!((simc.tuned.as_ref(), simc.name.as_str()), (Some(&alone), "SIMC"));
    assert_eq!(alone.closed_loop, Some(1.1));
    let refusal = find(Rule::Simc, Structure::P).refusal.as_deref().unwrap();
    assert!(refusal.starts_with("SIMC has no P controller"), "{refusal}");
    let lambda = find(Rule::Lambda, Structure::Pi).tuned.as_ref().unwrap();
    assert_eq!((lambda.closed_loop, number(lambda, "TI")), (Some(8.0), 8.0));
    assert!(rows.iter().filter_map(|row| row.tuned.as_ref()).all(|tuned| tuned.predicted.travel.is_some()));
}

#[test]
fn a_pace_is_a_closed_loop_between_calm_and_fast() {
    let mut request = request("PID", Rule::Lambda, Structure::Pi, lag(2.0, 17.6, 1.0), &[("CYCLE", 0.2)]);
    let closed_loop = |pace| {
        request.pace = Some(pace);
        tuned(&request).closed_loop.unwrap()
    };
    let loops = [0.0, 0.5, 1.0].map(closed_loop);
    for (is, expected) in loops.into_iter().zip([17.6, 4.4, 1.1]) {
        assert!((is - expected).abs() < 1e-9, "{is}");
    }
    request.pace = Some(2.0);
    assert_eq!(error(&request), "the pace is 2: it is from 0, calm, to 1, fast");
}

#[test]
fn a_rule_gets_half_a_cycle_more_dead_time_and_gives_the_settings_and_switches_of_the_block() {
    let mut request = request("PID", Rule::Simc, Structure::Pi, lag(2.0, 8.0, 1.0), &[("CYCLE", 0.2)]);
    let pi = tuned(&request);
    assert_eq!(pi.dead_time, 1.1);
    // T / (2 K L) and T.
    assert_eq!((number(&pi, "GAIN"), number(&pi, "TI")), (1.8182, 8.0));
    assert_eq!((is_on(&pi, "P_SEL"), is_on(&pi, "I_SEL"), is_on(&pi, "D_SEL")), (true, true, false));
    assert!(!pi.values.contains_key("TD"));
    // By a scan of the sampled loop; 1.590, pi and 61.35 degrees with calls that are infinitely fast.
    assert!((pi.sensitivity.unwrap() - 1.5920).abs() < 0.001);
    assert!((pi.gain_margin.unwrap() - 3.1311).abs() < 0.001);
    assert!((pi.phase_margin.unwrap() - 61.342).abs() < 0.01);
    assert_eq!(pi.remarks, [""; 0]);

    (request.rule, request.structure) = (Rule::Amigo, Structure::Pid);
    let pid = tuned(&request);
    assert!(is_on(&pid, "D_SEL"));
    // 0.5 L T / (0.3 L + T), and a tenth of it, which is below CYCLE / 2.
    assert_eq!((number(&pid, "TD"), number(&pid, "TM_LAG")), (0.528, 0.1));
    assert_eq!(
        pid.remarks[0],
        "TM_LAG = 0.053 s is below half the time between two calls: the block computes with 0.1 s, which is set."
    );

    (request.rule, request.structure) = (Rule::ChrSetpoint0, Structure::P);
    let p = tuned(&request);
    assert_eq!((is_on(&p, "P_SEL"), is_on(&p, "I_SEL"), is_on(&p, "D_SEL")), (true, false, false));
    assert!(!p.values.contains_key("TI"));
}

#[test]
fn a_limit_that_acts_in_the_prediction_is_named() {
    let plain = request("PID", Rule::ChrSetpoint20, Structure::Pid, lag(1.0, 10.0, 1.0), &[]);
    let remarks = tuned(&plain).remarks;
    assert!(remarks.iter().any(|remark| remark.contains("stays at its limit of 100 for")), "{remarks:?}");
}

#[test]
fn after_a_unit_load_step_the_integral_of_the_deviation_is_ti_divided_by_gain() {
    // SIMC with the dead time that includes half a cycle: TI / GAIN = 8.4 / 4.7619.
    let model = lag(1.0, 10.0, 1.0);
    let settings = tuned(&request("PID", Rule::Simc, Structure::Pi, model, &[]));
    let (gain, ti) = (number(&settings, "GAIN"), number(&settings, "TI"));
    let mut block = Pid {
        man_on: false,
        gain: gain as f32,
        ti: Time::ms((ti * 1000.0).round() as i32),
        low: -100.0,
        ..Pid::default()
    };
    block.restart();
    let mut process = Process::at_rest(model, 0.0);
    let mut sum = 0.0;
    for call in 0..3000 {
        let time = f64::from(call) * 0.1;
        block.pv_in = process.output_at(time) as f32;
        block.call();
        sum += f64::from(block.sp - block.pv) * 0.1;
        process.put(time, f64::from(block.lmn) + 1.0);
    }
    assert!((-sum - ti / gain).abs() < 1e-4 * ti / gain, "{sum} {}", ti / gain);
    assert!((f64::from(block.lmn) + 1.0).abs() < 1e-4);
}

#[test]
fn what_the_block_applies_to_its_output_is_made_up_for_by_gain() {
    let plain = tuned(&request("PID", Rule::Amigo, Structure::Pi, lag(1.0, 10.0, 1.0), &[]));
    for (factor, low, high) in [(0.5, 0.0, 100.0), (-0.3, -100.0, 100.0), (2.5, 0.0, 7.5)] {
        let values = [("LMN_FAC", factor), ("LOW", low), ("HIGH", high)];
        let scaled = tuned(&request("PID", Rule::Amigo, Structure::Pi, lag(1.0, 10.0, 1.0), &values));
        let ratio = number(&scaled, "GAIN") * factor / number(&plain, "GAIN");
        assert!((ratio - 1.0).abs() < 1e-4, "{factor}: {ratio}");
        assert!((scaled.sensitivity.unwrap() - plain.sensitivity.unwrap()).abs() < 1e-4);
        assert!(scaled.remarks[0].starts_with(&format!("PID multiplies its manipulated value by {factor}")));
    }
}

#[test]
fn a_falling_plant_gets_a_negative_gain_and_a_curve() {
    let falling = tuned(&request("PID", Rule::Simc, Structure::Pi, lag(-0.5, 10.0, 1.0), &[]));
    assert!(number(&falling, "GAIN") < 0.0);
    let Predicted { setpoint, process_value, settling, .. } = falling.predicted;
    assert_eq!(setpoint.last(), Some(&-5.0));
    assert!((process_value.last().unwrap() + 5.0).abs() < 0.01 && settling.is_some());
}

#[test]
fn an_integrating_plant_is_predicted_too() {
    let model = Model { gain: 0.1, dead_time: 2.0, is_integrating: true, ..Model::default() };
    let tuned = tuned(&request("PID", Rule::Simc, Structure::Pi, model, &[]));
    assert!((tuned.sensitivity.unwrap() - 1.704).abs() < 0.001);
    let Predicted { setpoint, process_value, manipulated_value, overshoot, .. } = tuned.predicted;
    let step = setpoint.last().unwrap();
    assert!((step - 10.0 * 0.1 * 4.1).abs() < 1e-3, "{step}");
    assert!((process_value.last().unwrap() - step).abs() < 0.02 * step);
    assert!((manipulated_value.last().unwrap() - 50.0).abs() < 0.5);
    assert!(overshoot.unwrap() > 10.0);
}

#[test]
fn a_word_of_an_analog_input_is_predicted_with_its_resolution() {
    let real = request("PID", Rule::Simc, Structure::Pi, lag(0.3, 10.0, 1.0), &[("SP", 40.0)]);
    let word = request(
        "PID",
        Rule::Simc,
        Structure::Pi,
        lag(0.3, 10.0, 1.0),
        &[("SP", 40.0), ("WORD_ON", 1.0), ("PV_FAC", 4.0)],
    );
    let (real, word) = (tuned(&real), tuned(&word));
    assert_eq!(real.values, word.values);
    let count = 400.0 / 27648.0;
    let apart = real.predicted.process_value.iter().zip(&word.predicted.process_value).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    assert!(apart > 0.0 && apart < 3.0 * count, "{apart}");
}

#[test]
fn pulses_add_half_a_period_whether_it_is_a_time_or_a_number_of_calls() {
    let pulser = request("PULSER", Rule::Simc, Structure::Pi, lag(1.0, 10.0, 1.0), &[("N", 40.0)]);
    let tuned_pulser = tuned(&pulser);
    // 5 ms of a call and 200 ms of forty.
    assert!((tuned_pulser.dead_time - 1.205).abs() < 1e-12);
    assert!((number(&tuned_pulser, "TI") - 9.64).abs() < 1e-9);
    let last = *tuned_pulser.predicted.process_value.last().unwrap();
    assert!((last - 10.0).abs() < 0.5, "{last}");
    assert!(tuned_pulser.predicted.overshoot.is_some());
    // Forty calls of 0.1 s.
    let slow = [("CYCLE", 0.1), ("N", 40.0)];
    let slow = tuned(&request("PULSER", Rule::Simc, Structure::Pi, lag(1.0, 10.0, 1.0), &slow));
    assert!((slow.dead_time - 3.05).abs() < 1e-12);
    assert!(slow.remarks[0].starts_with("The sampling costs more than the plant's dead time"), "{:?}", slow.remarks);
}

#[test]
fn a_step_controller_has_pi_only_and_a_valve_in_its_prediction() {
    let stepper = |structure| request("STEPPER", Rule::Simc, structure, lag(1.0, 30.0, 3.0), &[]);
    let pi = tuned(&stepper(Structure::Pi));
    assert_eq!(pi.values.len(), 2);
    let Predicted { process_value, manipulated_value, settling, .. } = &pi.predicted;
    assert!((process_value.last().unwrap() - 10.0).abs() < 1.0, "{:?}", process_value.last());
    // The valve is within its stops, and begins in the middle.
    assert_eq!(manipulated_value[0], 50.0);
    assert!((manipulated_value.last().unwrap() - 60.0).abs() < 1.5, "{:?}", manipulated_value.last());
    assert!(manipulated_value.iter().all(|position| (0.0..=100.0).contains(position)));
    assert!(settling.is_some());
    for structure in [Structure::P, Structure::Pid] {
        assert_eq!(error(&stepper(structure)), "STEPPER is a step controller, which has PI only: take PI");
    }
}

#[test]
fn what_cannot_be_tuned_says_why() {
    let model = lag(1.0, 10.0, 1.0);
    let of = |fmu: &str, values: &[(&str, f64)]| error(&request(fmu, Rule::Simc, Structure::Pi, model, values));
    assert!(of(FOREIGN, &[]).starts_with("FOREIGN is a foreign FMU"));
    assert!(of("LAG", &[]).starts_with("LAG is not a controller with a GAIN"));
    assert_eq!(of("PID", &[("GAIM", 1.0)]), "PID has no variable GAIM");
    assert_eq!(error(&request("PULSER", Rule::Amigo, Structure::Pid, model, &[])), "PULSER has no D action: take PI");
    let slow = request("PID", Rule::ChrSetpoint0, Structure::Pi, lag(1.0, 1e8, 1.0), &[]);
    assert!(error(&slow).starts_with("TI would be 120000000 s, and the longest TIME is 2147483.647 s"));
}

#[test]
fn numbers_without_sense_are_refused_and_cost_no_time() {
    let model = lag(1.0, 10.0, 1.0);
    let of = |values: &[(&str, f64)]| request("PID", Rule::Simc, Structure::Pi, model, values);
    for cycle in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(error(&of(&[("CYCLE", cycle)])).ends_with("it has to be a millisecond at least"), "{cycle}");
    }
    let long = request("PULSER", Rule::Simc, Structure::Pi, model, &[("N", 1e7)]);
    let remarks = tuned(&long).remarks;
    assert!(remarks.iter().any(|remark| remark.contains("takes too many calls")), "{remarks:?}");
    // A million calls would be needed: the simulation ends earlier.
    let slow = tuned(&Request { model: lag(1.0, 10_000.0, 100.0), ..of(&[("CYCLE", 0.001)]) });
    assert!(slow.predicted.times.len() < 2000 && *slow.predicted.times.last().unwrap() < 201.0);
}

#[test]
fn an_unstable_or_nervous_loop_is_named_before_it_is_applied() {
    let nervous = tuned(&request("PID", Rule::ZieglerNicholsStep, Structure::Pi, lag(1.0, 10.5, 1.0), &[]));
    assert!((nervous.sensitivity.unwrap() - 3.4093).abs() < 0.002);
    assert!(nervous.remarks[0].starts_with("Ms = 3.4"), "{:?}", nervous.remarks);
    let wrong = Request {
        ultimate: Some((50.0, 3.85)),
        ..request("PID", Rule::ZieglerNicholsUltimate, Structure::Pi, lag(1.0, 10.0, 1.0), &[])
    };
    let unstable = tuned(&wrong);
    assert_eq!(unstable.sensitivity, None);
    assert!(unstable.remarks[0].starts_with("The loop would be unstable"), "{:?}", unstable.remarks);
}

#[test]
fn a_second_lag_is_told_where_the_rule_does_not_know_it() {
    let model = Model { second_time_constant: 2.0, ..lag(1.0, 10.0, 1.0) };
    let pi = tuned(&request("PID", Rule::Simc, Structure::Pi, model, &[]));
    assert!(
        pi.remarks[0].starts_with("SIMC knows one lag") && pi.remarks[0].contains("T = 11 s and L = 2 s"),
        "{:?}",
        pi.remarks
    );
    let pid = tuned(&request("PID", Rule::Simc, Structure::Pid, model, &[]));
    assert!(!pid.remarks.iter().any(|remark| remark.contains("one lag")));
    assert!((number(&pid, "TD") - 2.0 / 1.238).abs() < 0.001, "{}", number(&pid, "TD"));
}

#[test]
fn the_ratio_of_heating_and_cooling_makes_both_equally_strong() {
    // Cooling is twice as strong: its pulses are half as long.
    let strong = ratio(&lag(1.0, 60.0, 5.0), &lag(2.0, 40.0, 4.0)).unwrap();
    assert_eq!((strong.ratio, strong.model), (0.5, lag(1.0, 60.0, 5.0)));
    assert_eq!(strong.remarks, [""; 0]);
    // Cooling is weaker: the pulses of heating are shorter. A cooling output of its own falls.
    let weak = ratio(&lag(1.5, 60.0, 2.0), &lag(-0.5, 40.0, 8.0)).unwrap();
    assert_eq!((weak.ratio, weak.model), (3.0, lag(0.5, 40.0, 8.0)));
    assert!(weak.remarks[0].starts_with("The dead times differ, 2 and 8 s"));
    assert!(
        ratio(&lag(20.0, 60.0, 5.0), &lag(1.0, 60.0, 5.0)).unwrap().remarks[0]
            .contains("RATIOFAC = 20 is outside 0.1 ... 10")
    );
    let integrating = Model { is_integrating: true, time_constant: 0.0, ..lag(1.0, 0.0, 5.0) };
    assert!(ratio(&lag(1.0, 60.0, 5.0), &integrating).is_err());
    assert!(
        format!("{:#}", ratio(&lag(0.0, 1.0, 1.0), &integrating).unwrap_err())
            .starts_with("heating: the plant's gain is 0")
    );
}

#[test]
fn a_setting_has_five_digits() {
    assert_eq!(
        [rounded(2.823_549, 5), rounded(-0.000_123_456, 5), rounded(98_765.4, 5), rounded(0.0, 5)],
        [2.8235, -0.000_123_46, 98_765.0, 0.0]
    );
}
