//! The tuning rules with the real blocks: settings in each block's form, and the curve that its own arithmetic gives.

#![allow(clippy::unwrap_used)]

use blocks::{ContC, Law, Time};
use control::identify::{self, Data, Method, Model};
use control::process::Process;
use control::rules::{Rule, Structure};
use control::tune::{Predicted, Step, TuneRequest, Tuned, table, tune};
use run::fmus::number_of;
use run::system::{Exchange, Value};
use tool::experiment::{self, RelayTest, RestAt, Settle, StepTest};
use tool::message::{Member, Setup, Values};
use tool::session::Session;
use tool::signals;
use tool_wasm::home::Linked;

fn lag(gain: f64, time_constant: f64, dead_time: f64) -> Model {
    Model { gain, time_constant, dead_time, ..Model::default() }
}

fn request(fmu: &str, rule: Rule, structure: Structure, values: &[(&str, f64)]) -> TuneRequest {
    with(fmu, rule, structure, lag(1.0, 10.0, 1.0), values)
}

/// The same for another plant.
fn with(fmu: &str, rule: Rule, structure: Structure, model: Model, values: &[(&str, f64)]) -> TuneRequest {
    TuneRequest {
        model,
        rule,
        structure,
        controller: Member {
            name: "TIC101".into(),
            fmu: fmu.into(),
            values: values.iter().map(|(name, value)| ((*name).into(), Value::Number(*value))).collect(),
        },
        closed_loop: None,
        pace: None,
        step: Step::default(),
        band: None,
        ultimate: None,
        exchange: Exchange::Sequential,
    }
}

fn tuned(request: &TuneRequest) -> Tuned {
    tune(&Linked::new(), request).unwrap()
}

fn error(request: &TuneRequest) -> String {
    format!("{:#}", tune(&Linked::new(), request).unwrap_err())
}

fn number(tuned: &Tuned, name: &str) -> f64 {
    match tuned.values[name] {
        Value::Number(value) => value,
        Value::Boolean(value) => f64::from(u8::from(value)),
        Value::Whole(value) => panic!("{name} is tuned as the whole number {value}"),
    }
}

fn is_on(tuned: &Tuned, name: &str) -> bool {
    tuned.values[name] == Value::Boolean(true)
}

fn last(curve: &[f64]) -> f64 {
    *curve.last().expect("there is a curve")
}

#[test]
fn cont_c_overshoots_as_the_linear_loop_does() {
    for (structure, expected, bound) in [(Structure::Pi, 11.7, 0.2), (Structure::Pid, 34.8, 1.0)] {
        // No limit acts.
        let wide = [("CYCLE", 0.01), ("SP_INT", 40.0), ("LMN_HLM", 1e6), ("LMN_LLM", -1e6)];
        let Tuned { predicted, remarks, .. } = tuned(&request("CONT_C", Rule::ChrSetpoint20, structure, &wide));
        assert!(!remarks.iter().any(|remark| remark.contains("limit")), "{remarks:?}");
        let Predicted { times, setpoint, process_value, manipulated_value, overshoot, settling, .. } = predicted;
        let overshoot = overshoot.unwrap();
        assert!((overshoot - expected).abs() < bound, "{structure:?}: {overshoot}");
        assert!(settling.unwrap() < 20.0);
        assert_eq!((setpoint[0], process_value[0]), (40.0, 40.0));
        assert!((last(&setpoint) - 50.0).abs() < 1e-5 && (last(&process_value) - 50.0).abs() < 0.05);
        assert!(times.len() < 2000 && times.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!([times.len(); 3], [setpoint.len(), process_value.len(), manipulated_value.len()]);
    }
}

#[test]
fn cont_c_gets_settings_switches_and_the_gain_that_lmn_fac_takes_away() {
    let plain = tuned(&request("CONT_C", Rule::Simc, Structure::Pi, &[("CYCLE", 0.1)]));
    let of = |tuned: &Tuned| ["GAIN", "TI", "P_SEL", "I_SEL", "D_SEL"].map(|name| number(tuned, name));
    assert_eq!(of(&plain), [4.76, 8.4, 1.0, 1.0, 0.0]);
    assert_eq!(plain.values.len(), 5);
    assert!((last(&plain.predicted.process_value) - 10.0).abs() < 0.02);
    let halved = tuned(&request("CONT_C", Rule::Simc, Structure::Pi, &[("CYCLE", 0.1), ("LMN_FAC", 0.5)]));
    assert_eq!(of(&halved)[..2], [9.52, 8.4]);
    assert_eq!(halved.sensitivity, plain.sensitivity);
}

#[test]
fn cont_c_is_predicted_with_the_resolution_of_pv_per() {
    let word = [("CYCLE", 0.1), ("PVPER_ON", 1.0), ("PV_FAC", 4.0), ("PV_OFF", -50.0), ("SP_INT", 200.0)];
    let predicted = tuned(&request("CONT_C", Rule::Simc, Structure::Pi, &word)).predicted;
    let count = 400.0 / 27648.0;
    assert!((last(&predicted.process_value) - 210.0).abs() < 4.0 * count, "{}", last(&predicted.process_value));
    assert_eq!(predicted.manipulated_value[0], 50.0);
}

#[test]
fn puls_ctr_gets_half_a_period_more_dead_time_and_its_inner_settings() {
    let pulses = tuned(&request("PULS_CTR", Rule::Simc, Structure::Pi, &[("CYCLE", 0.01), ("RED_FAC", 50.0)]));
    assert!((pulses.dead_time - 1.255).abs() < 1e-12, "{}", pulses.dead_time);
    assert_eq!(pulses.values["DI_CONT_C.TI"], Value::Number(10.0));
    assert!(pulses.values.contains_key("DI_CONT_C.D_SEL"));
    assert!((last(&pulses.predicted.process_value) - 10.0).abs() < 1.0, "{}", last(&pulses.predicted.process_value));
    // The manipulated value is the mean of a period, which has 50 calls with or without a pulse: at rest 50, and 10 more after the step.
    let means = &pulses.predicted.manipulated_value;
    assert!(means.iter().all(|mean| (mean / 2.0 - (mean / 2.0).round()).abs() < 1e-9), "{means:?}");
    assert_eq!((means[0], last(means)), (50.0, 60.0));
    assert_eq!(pulses.predicted.travel, None);
    // PV_IN of the block inside is a parameter, which nothing can be connected to.
    let other = tuned(&request("PULS_CTR", Rule::Simc, Structure::Pi, &[("DI_CONT_C.PVPER_ON", 0.0)]));
    let remark = "Predicted with the process value at PV_PER, that is, with DI_CONT_C.PVPER_ON = TRUE.";
    assert!(other.remarks.iter().any(|is| is == remark), "{:?}", other.remarks);
    assert!(!other.predicted.times.is_empty());
}

#[test]
fn cont_s_gets_pi_and_a_valve_that_takes_mtr_tm() {
    let fine = [("CYCLE", 0.1), ("PULSE_TM", 0.1), ("BREAK_TM", 0.1), ("MTR_TM", 10.0), ("DEADB_W", 0.5)];
    let pi = tuned(&request("CONT_S", Rule::Simc, Structure::Pi, &fine));
    assert_eq!(pi.values.len(), 2);
    let predicted = &pi.predicted;
    assert!((last(&predicted.process_value) - 10.0).abs() < 1.0, "{}", last(&predicted.process_value));
    assert!((last(&predicted.manipulated_value) - 60.0).abs() < 1.5, "{}", last(&predicted.manipulated_value));
    // A slower motor makes another curve with the same settings.
    let slow = fine.map(|(name, value)| (name, if name == "MTR_TM" { 60.0 } else { value }));
    let slow = tuned(&request("CONT_S", Rule::Simc, Structure::Pi, &slow));
    assert_eq!(slow.values, pi.values);
    assert_ne!(slow.predicted, pi.predicted);
}

#[test]
fn what_is_no_controller_cannot_be_tuned() {
    let of = |fmu: &str, structure, values: &[(&str, f64)]| error(&request(fmu, Rule::Simc, structure, values));
    let error = of("HLG", Structure::Pi, &[]);
    assert!(error.starts_with("HLG is not a controller with a GAIN"), "{error}");
    assert_eq!(of("CONT_C", Structure::Pi, &[("GAIM", 1.0)]), "CONT_C has no variable GAIM");
    for structure in [Structure::P, Structure::Pid] {
        assert_eq!(of("CONT_S", structure, &[]), "CONT_S is a step controller, which has PI only: use PI");
    }
    let slow = with("CONT_C", Rule::ChrSetpoint0, Structure::Pi, lag(1.0, 1e8, 1.0), &[]);
    assert!(self::error(&slow).starts_with("TI would be 120000000 s, but the longest TIME is 2147483.647 s"));
}

#[test]
fn a_pulse_of_cont_s_that_moves_the_process_value_through_the_dead_band_is_told() {
    let remarks = |settings: &[(&str, f64)]| tuned(&request("CONT_S", Rule::Simc, Structure::Pi, settings)).remarks;
    // 3 s of 30 s are 10 %, and the plant has a gain of 1.
    let expected = "The shortest pulse of 3 s moves the process value by 10, and DEADB_W = 1 is less than half of it: the loop \
                    will not settle. Shorten PULSE_TM or CYCLE, or set DEADB_W to 5.";
    let settings = [("CYCLE", 0.1), ("PULSE_TM", 3.0), ("MTR_TM", 30.0), ("DEADB_W", 1.0)];
    assert!(remarks(&settings).iter().any(|remark| remark == expected), "{:?}", remarks(&settings));
    for fine in [[settings[0], ("PULSE_TM", 0.3)], [settings[1], ("DEADB_W", 5.0)]] {
        let settings: Vec<_> = [settings[2], settings[3]].into_iter().chain(fine).collect();
        assert!(!remarks(&settings).iter().any(|remark| remark.contains("will not settle")), "{settings:?}");
    }
}

#[test]
fn a_dead_band_beyond_the_band_of_the_settling_time_is_told() {
    let told = |fmu: &str, settings: &[(&str, f64)]| {
        let remarks = tuned(&request(fmu, Rule::Simc, Structure::Pi, settings)).remarks;
        remarks.into_iter().find(|remark| remark.contains("counts as settled"))
    };
    let expected = |what: &str, least: f64| {
        Some(format!(
            "{what} is wider than the band of 0.2 on either side of the setpoint in which this step counts as settled: \
             the process value can stay anywhere in it, so a run may settle earlier or later than predicted. A step of \
             more than {least} shows the settling time."
        ))
    };
    // The step is one of 10, and 2 % of it are 0.2; 0.25 are 2 % of 12.5.
    assert_eq!(told("CONT_C", &[("DEADB_W", 0.2)]), None);
    assert_eq!(told("CONT_C", &[("DEADB_W", 0.25)]), expected("DEADB_W = 0.25", 12.5));
    // 0.1 s of 50 s are 0.2 %, and the plant has a gain of 1: 0.15 + 0.1.
    let motor = [("CYCLE", 0.1), ("PULSE_TM", 0.1), ("BREAK_TM", 0.1), ("MTR_TM", 50.0)];
    let valve = |dead_band| told("CONT_S", &[&motor[..], &[("DEADB_W", dead_band)]].concat());
    assert_eq!(valve(0.1), None);
    assert_eq!(valve(0.15), expected("DEADB_W = 0.15 plus half the effect of the shortest pulse (0.1)", 12.5));
}

#[test]
fn a_gain_far_above_the_one_in_force_is_told() {
    // SIMC: 100 s / (0.01 · 2 · (1 s + CYCLE / 2)) = 4760.
    let remarks = |gain| {
        let values = [("CYCLE", 0.1), ("GAIN", gain)];
        tuned(&with("CONT_C", Rule::Simc, Structure::Pi, lag(0.01, 100.0, 1.0), &values)).remarks
    };
    let expected = "GAIN = 4760 is 12 times the current one: a deviation of 0.021 moves the manipulated value by 100 %; \
                    noise and the resolution of the input are amplified likewise. A larger λ results in a lower gain.";
    assert!(remarks(400.0).iter().any(|remark| remark == expected), "{:?}", remarks(400.0));
    assert!(!remarks(1000.0).iter().any(|remark| remark.contains("times the current one")));
}

#[test]
fn cont_s_is_predicted_in_automatic_mode_whatever_its_switches_are_now() {
    let predicted = |switches: &[(&str, f64)]| {
        let settings: Vec<_> = [("CYCLE", 0.1), ("MTR_TM", 30.0)].into_iter().chain(switches.iter().copied()).collect();
        tuned(&request("CONT_S", Rule::Simc, Structure::Pi, &settings)).predicted
    };
    let automatic = predicted(&[]);
    assert!((last(&automatic.process_value) - 10.0).abs() < 2.0, "{}", last(&automatic.process_value));
    assert_eq!(predicted(&[("LMNS_ON", 1.0), ("LMNUP", 1.0), ("LMNR_LS", 1.0)]), automatic);
}

fn values(values: &[(&str, Value)]) -> Values {
    values.iter().map(|(name, value)| ((*name).into(), *value)).collect()
}

/// A valve that a step controller moves, in automatic mode, and a plant of gain 2, 20 s and 2 s.
fn valve_loop(backlash: f64) -> Session {
    let member = |name: &str, fmu: &str, of: &[(&str, f64)]| Member {
        name: name.into(),
        fmu: fmu.into(),
        values: of.iter().map(|(name, value)| ((*name).into(), Value::Number(*value))).collect(),
    };
    let times = [("CYCLE", 0.1), ("MTR_TM", 30.0), ("PULSE_TM", 0.1), ("BREAK_TM", 0.1)];
    let settings = [("GAIN", 1.0), ("TI", 20.0), ("DEADB_W", 0.5), ("SP_INT", 60.0)];
    let valve = [("CYCLE", 0.1), ("MTR_TM", 30.0), ("BACKLASH", backlash), ("POS_START", 30.0)];
    let process = [("CYCLE", 0.1), ("GAIN", 2.0), ("T1", 20.0), ("DEAD_TM", 2.0), ("DEAD_MAX", 2.0)];
    let connections = [
        ("TIC101.QLMNUP", "VALVE.UP"),
        ("TIC101.QLMNDN", "VALVE.DOWN"),
        ("VALVE.LMNR", "PLANT.U"),
        ("PLANT.PV", "TIC101.PV_IN"),
        ("VALVE.LMNR_HS", "TIC101.LMNR_HS"),
        ("VALVE.LMNR_LS", "TIC101.LMNR_LS"),
    ];
    let setup = Setup {
        members: vec![
            member("TIC101", "CONT_S", &[times.as_slice(), &settings].concat()),
            member("VALVE", "VALVE", &valve),
            member("PLANT", "PROCESS", &process),
        ],
        connections: connections.map(|(from, to)| (from.into(), to.into())).into(),
        ..Setup::default()
    };
    let mut session = Session::default();
    session.start(&Linked::new(), setup).unwrap();
    session
}

#[test]
fn the_plant_of_a_step_controller_is_identified_from_a_pulse_in_manual_mode() {
    let (home, mut session) = (Linked::new(), valve_loop(0.0));
    session.send(&values(&[("TIC101.LMNS_ON", Value::Boolean(true))])).unwrap();
    session.run(2000).unwrap();
    for (is_on, calls) in [(true, 60), (false, 1500)] {
        session.send(&values(&[("TIC101.LMNUP", Value::Boolean(is_on))])).unwrap();
        session.run(calls).unwrap();
    }
    let data = Data::Run { run: None, from: None, to: None };
    let request = identify::IdentifyRequest { data, method: Method::LeastSquares, is_integrating: false };
    let identified = signals::identify(&home, &session, &request).unwrap();
    let Model { gain, time_constant, dead_time, .. } = identified.model;
    assert!((gain - 2.0).abs() < 0.02 && (time_constant - 20.0).abs() < 0.3, "{identified:?}");
    assert!((dead_time - 2.0).abs() < 0.1, "{dead_time}");
    assert!(identified.remarks[0].contains("100 % in MTR_TM = 30 s"), "{:?}", identified.remarks);
}

#[test]
fn the_step_test_of_a_step_controller_moves_its_actuator_by_pulses_in_manual_mode() {
    for (backlash, size) in [(0.0, 10.0), (2.0, -10.0)] {
        let (home, mut session) = (Linked::new(), valve_loop(backlash));
        session.run(2000).unwrap();
        let before = session.state().unwrap().values;
        let request = StepTest { size, method: Method::LeastSquares, is_integrating: false };
        let tested = experiment::step(&home, &mut session, &request).unwrap();
        let Model { gain, time_constant, dead_time, .. } = tested.identified.model;
        assert!((gain - 2.0).abs() < 0.02 && (time_constant - 20.0).abs() < 0.3, "{:?}", tested.identified.model);
        assert!((dead_time - 2.0).abs() < 0.1, "{dead_time}");
        let record = session.record(None).unwrap();
        let at = |name: &str, time: f64| {
            let call = record.calls_between(Some(time), Some(time)).start;
            record.trace().get(record.column(name).unwrap(), call)
        };
        // 10 % of 30 s are 3 s, which the valve moves in the 30 calls from the step on.
        let moved = at("VALVE.LMNR", tested.step + 3.0) - at("VALVE.LMNR", tested.step - 0.1);
        assert!((moved - size).abs() < 1e-3, "{moved}");
        assert_eq!(at("TIC101.LMNS_ON", tested.step), 1.0);
        for name in ["TIC101.LMNS_ON", "TIC101.LMNUP", "TIC101.LMNDN", "TIC101.SP_INT"] {
            assert_eq!(tested.state.values[name], before[name], "{name}");
        }
    }
}

#[test]
fn a_step_controller_leaves_manual_mode_before_its_step_is_run() {
    let (home, mut session) = (Linked::new(), valve_loop(0.0));
    session.send(&values(&[("TIC101.LMNS_ON", Value::Boolean(true))])).unwrap();
    session.run(2000).unwrap();
    let settled = experiment::rest_at(&home, &mut session, &RestAt { setpoint: 70.0 }).unwrap();
    assert_eq!(settled.state.values["TIC101.LMNS_ON"], Value::Boolean(false));
    let process_value = number_of(settled.state.values["PLANT.PV"]);
    assert!(settled.is_at_rest && (process_value - 70.0).abs() < 1.0, "{process_value}");
}

#[test]
fn the_prediction_is_for_the_step_that_the_user_makes() {
    let mut request =
        with("CONT_C", Rule::Simc, Structure::Pi, lag(2.0, 8.0, 1.0), &[("CYCLE", 0.2), ("SP_INT", 20.0)]);
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
    // A step of which only the beginning is known ends at a round setpoint: 2 K for 1 % make 20 K.
    request.step = Step { from: Some(50.13), ..request.step };
    request.step.size = None;
    assert_eq!(ends(&tuned(&request).predicted.setpoint).1, 70.0);
    request.step.size = Some(0.0);
    assert!(is_remarked(&request, "the step is 0"));
    request.step = Step { from: Some(50.0), size: Some(-4.0), manual: Some(f64::INFINITY) };
    assert!(is_remarked(&request, "the manipulated value before the step is inf"));
}

#[test]
fn a_rule_for_one_lag_says_which_model_it_is_given() {
    // A cycle of 0.2 s adds 0.1 s of dead time: T = 8 + 1, L = 1 + 0.1 + 1.
    let model = Model { second_time_constant: 2.0, ..lag(2.0, 8.0, 1.0) };
    let request = |model| with("CONT_C", Rule::Simc, Structure::Pi, model, &[("CYCLE", 0.2)]);
    assert!(is_remarked(&request(model), "so that T = 9 s and, with half of CYCLE, L = 2.1 s."));
    // The lag of an integrating plant only delays: L = 1 + 0.1 + 2.
    let model = Model { is_integrating: true, time_constant: 0.0, ..model };
    assert!(is_remarked(&request(model), "dead time, so that, with half of CYCLE, L = 3.1 s."));
}

/// Whether a remark on these settings contains this text.
fn is_remarked(request: &TuneRequest, text: &str) -> bool {
    tuned(request).remarks.iter().any(|remark| remark.contains(text))
}

#[test]
fn a_step_in_which_the_manipulated_value_changes_its_sign_says_that_one_model_may_not_do() {
    let told = |low: f64, manual: f64| {
        let settings = [("CYCLE", 0.2), ("LMN_LLM", low)];
        let mut request = with("CONT_C", Rule::Simc, Structure::Pi, lag(2.0, 8.0, 1.0), &settings);
        request.step = Step { from: Some(50.0), size: Some(-8.0), manual: Some(manual) };
        tuned(&request).remarks.into_iter().filter(|remark| remark.contains("below 0")).collect::<Vec<_>>()
    };
    // 8 K down take 4 % in the end, and with the P action of GAIN 1.82 a jump of 14.6 %, to which the I action adds in the dead time.
    assert!(
        told(-100.0, 10.0)[0].starts_with("In this step, the manipulated value goes from 10 to -6"),
        "{:?}",
        told(-100.0, 10.0)
    );
    assert_eq!((told(0.0, 10.0), told(-100.0, 40.0)), (vec![], vec![]));
}

#[test]
fn the_table_has_all_rules_for_one_step_and_says_which_do_not_apply() {
    let mut request = with("CONT_C", Rule::Amigo, Structure::Pi, lag(2.0, 8.0, 1.0), &[("CYCLE", 0.2)]);
    let rows = table(&Linked::new(), &request).unwrap();
    assert_eq!(rows.len(), Rule::ALL.len());
    let simc = &rows[0];
    // With half of CYCLE the dead time is 1.1 s: SIMC's own closed loop is that, what is offered first is calmer by half.
    let alone = tuned(&TuneRequest { rule: Rule::Simc, ..request.clone() });
    assert_eq!(alone.closed_loop, Some(1.1));
    let calm = tuned(&TuneRequest { rule: Rule::Simc, closed_loop: Some(1.5 * 1.1), ..request.clone() });
    assert_eq!((simc.tuned.as_ref(), simc.name.as_str()), (Some(&calm), "SIMC"));
    let lambda = rows.iter().find(|row| row.rule == Rule::Lambda).unwrap().tuned.as_ref().unwrap();
    assert_eq!((lambda.closed_loop, number(lambda, "TI")), (Some(8.0), 8.0));
    assert!(rows.iter().filter_map(|row| row.tuned.as_ref()).all(|tuned| tuned.predicted.travel.is_some()));
    request.structure = Structure::P;
    let refusal = table(&Linked::new(), &request).unwrap()[0].refusal.clone().unwrap();
    assert!(refusal.starts_with("SIMC has no rule for P:"), "{refusal}");
}

#[test]
fn a_pace_is_a_closed_loop_between_calm_and_fast() {
    let mut request = with("CONT_C", Rule::Lambda, Structure::Pi, lag(2.0, 17.6, 1.0), &[("CYCLE", 0.2)]);
    let closed_loop = |pace| {
        request.pace = Some(pace);
        let tuned = tuned(&request);
        assert!((tuned.pace.unwrap() - pace).abs() < 1e-9, "{:?}", tuned.pace);
        tuned.closed_loop.unwrap()
    };
    let loops = [0.0, 0.5, 1.0].map(closed_loop);
    for (is, expected) in loops.into_iter().zip([17.6, 4.4, 1.1]) {
        assert!((is - expected).abs() < 1e-9, "{is}");
    }
    request.pace = Some(2.0);
    assert_eq!(error(&request), "the pace is 2: it must be between 0 (calm) and 1 (fast)");
}

#[test]
fn a_rule_gets_half_a_cycle_more_dead_time_and_gives_the_settings_and_switches_of_the_block() {
    let mut request = with("CONT_C", Rule::Simc, Structure::Pi, lag(2.0, 8.0, 1.0), &[("CYCLE", 0.2)]);
    let pi = tuned(&request);
    assert_eq!(pi.dead_time, 1.1);
    // T / (2 K L) and T.
    assert_eq!((number(&pi, "GAIN"), number(&pi, "TI")), (1.82, 8.0));
    assert_eq!((is_on(&pi, "P_SEL"), is_on(&pi, "I_SEL"), is_on(&pi, "D_SEL")), (true, true, false));
    assert!(!pi.values.contains_key("TD"));
    // By a scan of the sampled loop; 1.590, pi and 61.35 degrees with calls that are infinitely fast.
    assert!((pi.sensitivity.unwrap() - 1.5928).abs() < 0.001);
    assert!((pi.gain_margin.unwrap() - 3.1280).abs() < 0.001);
    assert!((pi.phase_margin.unwrap() - 61.314).abs() < 0.01);
    assert_eq!(pi.remarks, [""; 0]);

    (request.rule, request.structure) = (Rule::Amigo, Structure::Pid);
    let pid = tuned(&request);
    assert!(is_on(&pid, "D_SEL"));
    // 0.5 L T / (0.3 L + T), and a tenth of it, which is below CYCLE / 2.
    assert_eq!((number(&pid, "TD"), number(&pid, "TM_LAG")), (0.528, 0.1));
    assert_eq!(
        pid.remarks[0],
        "TM_LAG = 0.053 s is below half the time between two calls: the block would use 0.1 s, so TM_LAG is set to \
         that."
    );

    (request.rule, request.structure) = (Rule::ChrSetpoint0, Structure::P);
    let p = tuned(&request);
    assert_eq!((is_on(&p, "P_SEL"), is_on(&p, "I_SEL"), is_on(&p, "D_SEL")), (true, false, false));
    assert!(!p.values.contains_key("TI"));
}

#[test]
fn a_limit_that_acts_in_the_prediction_is_named() {
    let plain = with("CONT_C", Rule::ChrSetpoint20, Structure::Pid, lag(1.0, 10.0, 1.0), &[("CYCLE", 0.1)]);
    let remarks = tuned(&plain).remarks;
    assert!(remarks.iter().any(|remark| remark.contains("stays at its limit of 100 for")), "{remarks:?}");
}

#[test]
fn after_a_unit_load_step_the_integral_of_the_deviation_is_ti_divided_by_gain() {
    // SIMC with the dead time that includes half a cycle: TI / GAIN = 8.4 / 4.7619.
    let model = lag(1.0, 10.0, 1.0);
    let settings = tuned(&with("CONT_C", Rule::Simc, Structure::Pi, model, &[("CYCLE", 0.1)]));
    let (gain, ti) = (number(&settings, "GAIN"), number(&settings, "TI"));
    let mut block = ContC {
        man_on: false,
        gain: gain as f32,
        ti: Time::ms((ti * 1000.0).round() as i32),
        lmn_llm: -100.0,
        cycle: Time::ms(100),
        ..ContC::default()
    };
    block.restart();
    let mut process = Process::at_rest(model, 0.0);
    let mut sum = 0.0;
    for call in 0..3000 {
        let time = f64::from(call) * 0.1;
        block.pv_in = process.output_at(time) as f32;
        block.call();
        sum += f64::from(block.sp_int - block.pv) * 0.1;
        process.put(time, f64::from(block.lmn) + 1.0);
    }
    assert!((-sum - ti / gain).abs() < 1e-4 * ti / gain, "{sum} {}", ti / gain);
    assert!((f64::from(block.lmn) + 1.0).abs() < 1e-4);
}

#[test]
fn a_falling_plant_gets_a_negative_gain_and_a_curve() {
    let falling = tuned(&with("CONT_C", Rule::Simc, Structure::Pi, lag(-0.5, 10.0, 1.0), &[("CYCLE", 0.1)]));
    assert!(number(&falling, "GAIN") < 0.0);
    let Predicted { setpoint, process_value, settling, .. } = falling.predicted;
    assert_eq!(setpoint.last(), Some(&-5.0));
    assert!((process_value.last().unwrap() + 5.0).abs() < 0.01 && settling.is_some());
}

#[test]
fn an_integrating_plant_is_predicted_too() {
    let model = Model { gain: 0.1, dead_time: 2.0, is_integrating: true, ..Model::default() };
    let tuned = tuned(&with("CONT_C", Rule::Simc, Structure::Pi, model, &[("CYCLE", 0.1)]));
    assert!((tuned.sensitivity.unwrap() - 1.704).abs() < 0.001);
    let Predicted { setpoint, process_value, manipulated_value, overshoot, .. } = tuned.predicted;
    let step = setpoint.last().unwrap();
    // GAIN is 1 / (0.1 * 4.1), and 10 % is 4.1 K, with two digits.
    assert!((step - 4.1).abs() < 1e-6, "{step}");
    assert!((process_value.last().unwrap() - step).abs() < 0.02 * step);
    assert!((manipulated_value.last().unwrap() - 50.0).abs() < 0.5);
    assert!(overshoot.unwrap() > 10.0);
}

#[test]
fn numbers_without_sense_are_refused_and_cost_no_time() {
    let model = lag(1.0, 10.0, 1.0);
    let of = |values: &[(&str, f64)]| with("CONT_C", Rule::Simc, Structure::Pi, model, values);
    for cycle in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(error(&of(&[("CYCLE", cycle)])).ends_with("it must be between 0.001 s and 2147483.647 s"), "{cycle}");
    }
    let long = with("PULS_CTR", Rule::Simc, Structure::Pi, model, &[("RED_FAC", 1e7)]);
    let remarks = tuned(&long).remarks;
    assert!(remarks.iter().any(|remark| remark.contains("would take too many calls")), "{remarks:?}");
    // A million calls would be needed: the simulation ends earlier.
    let slow = tuned(&TuneRequest { model: lag(1.0, 10_000.0, 100.0), ..of(&[("CYCLE", 0.001)]) });
    assert!(slow.predicted.times.len() < 2000 && *slow.predicted.times.last().unwrap() < 201.0);
}

#[test]
fn an_unstable_or_nervous_loop_is_named_before_it_is_applied() {
    let nervous =
        tuned(&with("CONT_C", Rule::ZieglerNicholsStep, Structure::Pi, lag(1.0, 10.5, 1.0), &[("CYCLE", 0.1)]));
    assert!((nervous.sensitivity.unwrap() - 3.4075).abs() < 0.002);
    assert!(nervous.remarks[0].starts_with("Ms = 3.4"), "{:?}", nervous.remarks);
    let wrong = TuneRequest {
        ultimate: Some((50.0, 3.85)),
        ..with("CONT_C", Rule::ZieglerNicholsUltimate, Structure::Pi, lag(1.0, 10.0, 1.0), &[("CYCLE", 0.1)])
    };
    let unstable = tuned(&wrong);
    assert_eq!(unstable.sensitivity, None);
    assert!(unstable.remarks[0].starts_with("The loop would be unstable"), "{:?}", unstable.remarks);
}

#[test]
fn a_second_lag_is_told_where_the_rule_does_not_know_it() {
    let model = Model { second_time_constant: 2.0, ..lag(1.0, 10.0, 1.0) };
    let pi = tuned(&with("CONT_C", Rule::Simc, Structure::Pi, model, &[("CYCLE", 0.1)]));
    assert!(
        pi.remarks[0].starts_with("SIMC supports only one lag")
            && pi.remarks[0].contains("T = 11 s and, with half of CYCLE, L = 2.05 s"),
        "{:?}",
        pi.remarks
    );
    let third = Model { second_time_constant: 2.0 / 3.0, ..model };
    let told = &tuned(&with("CONT_C", Rule::Simc, Structure::Pi, third, &[("CYCLE", 0.1)])).remarks[0];
    assert!(told.contains("T = 10.33 s and, with half of CYCLE, L = 1.383 s"), "{told}");
    let pid = tuned(&with("CONT_C", Rule::Simc, Structure::Pid, model, &[("CYCLE", 0.1)]));
    assert!(!pid.remarks.iter().any(|remark| remark.contains("one lag")));
    // 2 s / 1.238 = 1.6155 s.
    assert_eq!(number(&pid, "TD"), 1.62);
}

/// CONT_C with PROCESS, in manual mode at 40 %, as the tool connects them.
fn held_process(home: &Linked, of: &[(&str, f64)], is_word: bool) -> Session {
    let values = |values: &[(&str, f64)]| -> Values {
        values.iter().map(|(name, value)| ((*name).into(), Value::Number(*value))).collect()
    };
    let mut plant = values(of);
    plant.extend(values(&[("CYCLE", 0.1), ("DEAD_MAX", 20.0), ("U_0", 40.0), ("PV_0", 50.0)]));
    let mut controller = values(&[("CYCLE", 0.1), ("MAN", 40.0)]);
    controller.insert("PVPER_ON".into(), Value::Boolean(is_word));
    if let Some(value) = plant.get_mut("INTEG") {
        *value = Value::Boolean(true);
    }
    let input = if is_word { ("P.PV_PER", "C.PV_PER") } else { ("P.PV", "C.PV_IN") };
    let member = |name: &str, fmu: &str, values| Member { name: name.into(), fmu: fmu.into(), values };
    let setup = Setup {
        members: vec![member("C", "CONT_C", controller), member("P", "PROCESS", plant)],
        connections: [("C.LMN", "P.U"), input].map(|(from, to)| (from.into(), to.into())).into(),
        ..Setup::default()
    };
    let mut session = Session::default();
    session.start(home, setup).unwrap();
    session
}

/// The gain and period of P control at the stability limit, by a frequency scan of the plant between two calls 0.1 s apart: a lag or two, or
/// an integrator with one, behind a hold and a dead time of whole calls.
fn exact_ultimate(gain: f64, lags: [f64; 2], dead_calls: f64, integrates: bool) -> (f64, f64) {
    // Each part in its discrete form: the step response of partial fractions, A_k / (z - e^(-T/T_k)).
    let response = |angle: f64| -> (f64, f64) {
        let [a, b] = lags;
        // c + d t + sum of r_k e^(-t/T_k)
        let (constant, ramp, parts): (f64, f64, Vec<(f64, f64)>) = match (integrates, b > 0.0) {
            (false, false) => (1.0, 0.0, vec![(-1.0, a)]),
            (false, true) => (1.0, 0.0, vec![(-a / (a - b), a), (b / (a - b), b)]),
            (true, _) => (-a, 1.0, vec![(a, a)]),
        };
        // (1 - z^-1) times the z-transform of the step response.
        let (mut real, mut imaginary) = (constant, 0.0);
        let back = (angle.cos(), -angle.sin());
        let off = (1.0 - back.0, -back.1);
        let quotient = |n: (f64, f64), d: (f64, f64)| {
            let size = d.0 * d.0 + d.1 * d.1;
            ((n.0 * d.0 + n.1 * d.1) / size, (n.1 * d.0 - n.0 * d.1) / size)
        };
        let slope = quotient((back.0 * 0.1 * ramp, back.1 * 0.1 * ramp), off);
        (real, imaginary) = (real + slope.0, imaginary + slope.1);
        for (part, time) in parts {
            let stays = (-0.1 / time).exp();
            let one = quotient((off.0 * part, off.1 * part), (1.0 - stays * back.0, -stays * back.1));
            (real, imaginary) = (real + one.0, imaginary + one.1);
        }
        (gain * real.hypot(imaginary), imaginary.atan2(real))
    };
    let (mut before, mut turned, mut angle): (Option<f64>, f64, f64) = (None, 0.0, 1e-4);
    loop {
        let (size, phase) = response(angle);
        if let Some(before) = before {
            turned += (phase - before + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        } else {
            turned = phase;
        }
        before = Some(phase);
        if turned - angle * dead_calls <= -std::f64::consts::PI {
            return (1.0 / size, std::f64::consts::TAU / angle * 0.1);
        }
        angle *= 1.0005;
    }
}

#[test]
fn a_relay_finds_the_ultimate_gain_and_period_of_100_plants() {
    let home = Linked::new();
    let mut state = 7_u32;
    let mut random = |low: f64, high: f64| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        low * (high / low).powf(f64::from(state >> 8) / f64::from(1 << 24))
    };
    for plant in 0..100 {
        let (integrates, is_word) = (plant % 4 == 3, plant % 2 == 1);
        let lag = random(1.0, 20.0);
        let second = if plant % 4 == 2 { lag * random(0.1, 0.9) } else { 0.0 };
        let dead = (random(0.05, 1.5) * lag * 10.0).clamp(4.0, 60.0).round();
        let gain = if integrates { random(0.02, 0.1) } else { random(0.5, 1.5) };
        let integ = if integrates { Some(("INTEG", 1.0)) } else { None };
        let of: Vec<_> =
            [("GAIN", gain), ("T1", lag), ("T2", second), ("DEAD_TM", dead / 10.0)].into_iter().chain(integ).collect();
        let mut session = held_process(&home, &of, is_word);
        let found = experiment::relay(&home, &mut session, &RelayTest { amplitude: 10.0, hysteresis: None });
        let found = found.unwrap_or_else(|error| panic!("{of:?}: {error:#}"));
        let (expected, period) = exact_ultimate(gain, [lag, second], dead, integrates);
        let ratio = (found.ultimate.0 / expected, found.ultimate.1 / period);
        assert!([ratio.0, ratio.1].iter().all(|one| (one - 1.0).abs() < 0.1), "{of:?} {is_word}: {ratio:?} {found:?}");
        // A word of 1/27648 of the range has a step, not noise; nothing else has any.
        assert!(
            if is_word { found.hysteresis < 0.02 } else { found.hysteresis < 1e-6 },
            "{of:?}: {}",
            found.hysteresis
        );
        let values = &found.state.values;
        assert_eq!(
            (values["C.MAN_ON"], values["C.MAN"], values["C.SP_INT"]),
            (Value::Boolean(true), Value::Number(40.0), Value::Number(0.0))
        );
    }
}

#[test]
fn after_a_step_test_the_step_that_is_predicted_is_the_step_that_comes() {
    let home = Linked::new();
    let mut session = held_process(&home, &[("GAIN", 1.5), ("T1", 10.0), ("DEAD_TM", 1.0)], false);
    let test = StepTest { size: 10.0, method: Method::LeastSquares, is_integrating: false };
    let model = experiment::step(&home, &mut session, &test).unwrap().identified.model;
    for (rule, least) in [(Rule::ZieglerNicholsStep, 20.0), (Rule::Simc, 0.0)] {
        let mut request = with("CONT_C", rule, Structure::Pi, model, &[("CYCLE", 0.1)]);
        request.step = Step { from: Some(50.0), size: Some(5.0), manual: Some(40.0) };
        let Tuned { values, predicted, .. } = tuned(&request);
        let named = values.iter().map(|(name, value)| (format!("C.{name}"), *value)).collect();
        session.send(&named).unwrap();
        let settled = experiment::rest_at(&home, &mut session, &RestAt { setpoint: 50.0 }).unwrap();
        assert!(settled.is_at_rest, "{rule:?}");
        let from = settled.state.time;
        session.send(&Values::from([("C.SP_INT".into(), Value::Number(55.0))])).unwrap();
        experiment::settle(&home, &mut session, &Settle { calls: 20_000, from }).unwrap();
        let came = signals::Signals::new(&home, session.record(None).unwrap(), Some(from), None).unwrap();
        // The highest value, without the code of the figures.
        let highest = came.process_value.iter().fold(f64::NEG_INFINITY, |high, value| high.max(*value));
        let overshoot = ((highest - 55.0) / 5.0 * 100.0).max(0.0);
        assert!(
            (predicted.overshoot.unwrap() - overshoot).abs() < 1.0,
            "{rule:?}: {overshoot} {:?}",
            predicted.overshoot
        );
        assert!(overshoot >= least, "{rule:?}: {overshoot}");
    }
}

/// A furnace in manual mode with a manual value of 10 %, called each second.
fn manual_furnace(home: &Linked, exchange: Exchange) -> Session {
    let member = |name: &str, fmu: &str, values: &[(&str, Value)]| Member {
        name: name.into(),
        fmu: fmu.into(),
        values: values.iter().map(|(name, value)| ((*name).into(), *value)).collect(),
    };
    let cycle = ("CYCLE", Value::Number(1.0));
    let members = vec![
        member("C", "CONT_C", &[cycle, ("MAN", Value::Number(10.0)), ("MAN_ON", Value::Boolean(true))]),
        member("H", "HEATER", &[cycle]),
    ];
    let connections = [("C.LMN", "H.POWER"), ("H.TEMP", "C.PV_IN")].map(|(from, to)| (from.into(), to.into())).into();
    let mut session = Session::default();
    session.start(home, Setup { members, connections, exchange, ..Setup::default() }).unwrap();
    session
}

#[test]
fn a_cold_furnace_is_identified_from_a_run_that_begins_in_manual_mode() {
    let home = Linked::new();
    let mut session = manual_furnace(&home, Exchange::Parallel);
    let data = Data::Run { run: None, from: None, to: None };
    let request = identify::IdentifyRequest { data, method: Method::LeastSquares, is_integrating: false };
    assert!(signals::identify(&home, &session, &request).is_err(), "nothing has run yet");
    session.run(900).unwrap();
    let model = signals::identify(&home, &session, &request).unwrap().model;
    // The manipulated value steps from 0 to 10 % after the first row, which has the outputs before the first call: a process value of 0,
    // and not the 20 degC of the cold furnace.
    assert!((model.gain / 3.0 - 1.0).abs() < 0.01 && (model.time_constant / 120.0 - 1.0).abs() < 0.02, "{model:?}");
}

#[test]
fn a_furnace_with_two_lags_does_what_its_identified_model_predicts() {
    for exchange in [Exchange::Sequential, Exchange::Parallel] {
        furnace_does_what_is_predicted(exchange);
    }
}

/// Where controller and plant act at once, the manipulated value reaches the plant a call later, and a row has the process value of the
/// call before it.
fn furnace_does_what_is_predicted(exchange: Exchange) {
    let home = Linked::new();
    let late = if exchange == Exchange::Parallel { 1.0 } else { 0.0 };
    let mut session = manual_furnace(&home, exchange);
    // Nothing has run before: the first rows of a loop in which all act at once have outputs of no call, and are no part of the test.
    let test = StepTest { size: 10.0, method: Method::LeastSquares, is_integrating: false };
    let model = experiment::step(&home, &mut session, &test).unwrap().identified.model;
    // RISE / 100 %, FURN_TM and SENS_TM to 1 %, and DELAY_TM to a part of a call: the test begins as soon as the plant is almost at rest.
    let found = [model.gain, model.time_constant, model.second_time_constant];
    for (is, expected) in found.into_iter().zip([3.0, 120.0, 20.0]) {
        assert!((is / expected - 1.0).abs() < 0.01, "{model:?}");
    }
    assert!((model.dead_time - 5.0 - late).abs() < 0.3, "{model:?}");
    // 100 degC need (100 - 20) / 3 %.
    let step = Step { from: Some(100.0), size: Some(10.0), manual: Some(80.0 / 3.0) };
    let of =
        |rule, structure| TuneRequest { step, exchange, ..with("CONT_C", rule, structure, model, &[("CYCLE", 1.0)]) };
    let offered = table(&home, &of(Rule::Simc, Structure::Pi)).unwrap()[0].tuned.clone().unwrap();
    // A PI loop with the true model: lambda = 1.5 (5 s + 20 s + 0.5 s), GAIN = 130 s / (3 (lambda + 15.5 s)); of both, 1 s more if late.
    let gain = 130.0 / (3.0 * (1.5 * (25.5 + late) + 15.5 + late));
    assert!(
        (number(&offered, "GAIN") - gain).abs() < 0.01 && (number(&offered, "TI") - 130.0).abs() < 1.0,
        "{offered:?}"
    );
    let others = [Rule::Simc, Rule::ZieglerNicholsStep].map(|rule| tuned(&of(rule, Structure::Pi)));
    for (place, Tuned { values, predicted, .. }) in [offered].into_iter().chain(others).enumerate() {
        session.send(&values.iter().map(|(name, value)| (format!("C.{name}"), *value)).collect()).unwrap();
        let from = experiment::rest_at(&home, &mut session, &RestAt { setpoint: 100.0 }).unwrap().state.time;
        session.send(&Values::from([("C.SP_INT".into(), Value::Number(110.0))])).unwrap();
        experiment::settle(&home, &mut session, &Settle { calls: 20_000, from }).unwrap();
        let rows = signals::Signals::new(&home, session.record(None).unwrap(), Some(from), None).unwrap().process_value;
        // The call at `from` was made before the setpoint was set.
        let came = &rows;
        // The figures without their code: overshoot in percent of the step, and when it stays within 2 % of it.
        let highest = came.iter().fold(f64::NEG_INFINITY, |high, value| high.max(*value));
        let settling = came.iter().rposition(|value| (value - 110.0).abs() > 0.2).map_or(0, |last| last + 1) as f64;
        let came = [((highest - 110.0) * 10.0).max(0.0), settling];
        let told = [predicted.overshoot, predicted.settling].map(Option::unwrap);
        if place == 0 {
            assert!(
                came[0] > 1.0 && came[0] < 5.0 && predicted.load.is_some_and(|load| load.recovery.is_some()),
                "{came:?}"
            );
            // Call by call, not one earlier or later: in the first 100 calls the model misses the furnace by less than half of a call's way.
            let begin = predicted.setpoint.iter().position(|setpoint| *setpoint == 110.0).unwrap();
            let missed = |late: usize| {
                let pairs = predicted.process_value[begin..].iter().zip(&rows[late..]).take(100);
                pairs.map(|(told, came)| (told - came).abs()).sum::<f64>()
            };
            assert!(
                missed(1) < 0.5 * missed(0) && missed(1) < 0.5 * missed(2),
                "{exchange:?} {:?}",
                [0, 1, 2].map(missed)
            );
        }
        // A loop that swings passes the band half a period earlier or later.
        let off = [0.3 + 0.02 * came[0], if place == 2 { 80.0 } else { 3.0 }];
        for ((told, came), off) in told.into_iter().zip(came).zip(off) {
            assert!((told - came).abs() <= off, "{place}: {told} instead of {came}");
        }
    }
}

#[test]
fn a_load_step_costs_ti_over_gain() {
    // SIMC with lambda = 2 L does not overshoot after a load, so that the IAE is the integral of the error: load * TI / GAIN.
    let mut request = request("CONT_C", Rule::Simc, Structure::Pi, &[("CYCLE", 0.05)]);
    request.closed_loop = Some(2.0);
    let tuned = tuned(&request);
    let load = tuned.predicted.load.clone().unwrap();
    let expected = 10.0 * number(&tuned, "TI") / number(&tuned, "GAIN");
    assert!((load.iae.unwrap() / expected - 1.0).abs() < 0.01, "{load:?} {expected}");
    // Within the dead time nothing answers: 10 (1 - e^(-L/T)) at L = 1 s after it began to act, and at most that of 2 L more.
    let unanswered = |time: f64| 10.0 * (1.0 - (-time / 10.0_f64).exp());
    assert!(load.deviation > unanswered(1.0) && load.deviation < unanswered(4.0), "{load:?}");
    assert!(load.recovery.unwrap() > 2.0 && load.recovery.unwrap() < 40.0, "{load:?}");
}

#[test]
fn what_a_load_does_depends_on_the_band_of_a_run_and_on_no_other_step() {
    let load = |size: Option<f64>, band: Option<f64>| {
        let mut request = request("CONT_C", Rule::Simc, Structure::Pi, &[("CYCLE", 0.05)]);
        (request.step.size, request.band) = (size, band);
        tuned(&request).predicted.load.unwrap()
    };
    // The default step is 10 % times the gain of 1, and the band 2 % of it.
    let usual = load(None, None);
    assert_eq!((usual.band, load(Some(3.0), None), load(Some(-25.0), None)), (0.2, usual.clone(), usual.clone()));
    // A wider band is reached earlier, and nothing else changes.
    let wide = load(Some(3.0), Some(1.0));
    assert!(wide.band == 1.0 && wide.recovery < usual.recovery, "{wide:?} {usual:?}");
    assert_eq!((wide.deviation, wide.iae), (usual.deviation, usual.iae));
    let mut wrong = request("CONT_C", Rule::Simc, Structure::Pi, &[]);
    wrong.band = Some(0.0);
    let told = tuned(&wrong).remarks.concat();
    assert!(told.contains("the recovery band is 0: it must be above 0"), "{told}");
}

#[test]
fn a_metric_that_is_absent_has_a_reason() {
    let plain = request("CONT_C", Rule::Simc, Structure::Pi, &[("CYCLE", 0.05)]);
    let Tuned { predicted, absent, .. } = tuned(&plain);
    assert!(absent.is_empty() && predicted.load.unwrap().size == 10.0);
    // At rest at 0 %, the lower limit, the load is one that the manipulated value can make up for. Up to 9 % it can make up for 9 of 10 %:
    // with a gain of 1, the process value stays 1 below the setpoint.
    let rest = Step { manual: Some(0.0), size: Some(5.0), ..Step::default() };
    assert!(tuned(&TuneRequest { step: rest, ..plain }).absent.is_empty());
    let limited = request("CONT_C", Rule::Simc, Structure::Pi, &[("CYCLE", 0.05), ("LMN_HLM", 9.0)]);
    let Tuned { predicted, absent, .. } = tuned(&TuneRequest { step: rest, ..limited });
    let why = "the manipulated value stays at its limit of 9".to_string();
    assert_eq!(absent, [("recovery", &why), ("iae", &why)].map(|(name, why)| (name.into(), why.clone())).into());
    let load = predicted.load.unwrap();
    assert!(load.size == -10.0 && load.deviation > 1.0, "{load:?}");
    // A GAIN of 45 makes this plant swing, whose ultimate gain is about 16.
    let wild = TuneRequest {
        ultimate: Some((100.0, 4.0)),
        ..self::request("CONT_C", Rule::ZieglerNicholsUltimate, Structure::Pi, &[("CYCLE", 0.05)])
    };
    let Tuned { absent, gain_margin, .. } = tuned(&wild);
    assert_eq!(absent["sensitivity"], "the loop is unstable");
    assert!(gain_margin.unwrap() < 1.0 && !absent.contains_key("gain_margin"), "{absent:?}");
    assert_eq!(absent["recovery"], "the process value does not return to the setpoint");
    assert!(absent.contains_key("settling"), "{absent:?}");
}

#[test]
fn a_test_in_automatic_mode_ends_there_at_rest_at_the_setpoint() {
    let home = Linked::new();
    let mut session = held_process(&home, &[("GAIN", 1.5), ("T1", 10.0), ("DEAD_TM", 1.0)], false);
    let settings = [("C.GAIN", 1.0), ("C.TI", 10.0)].map(|(name, value)| (name.to_string(), Value::Number(value)));
    session.send(&Values::from(settings)).unwrap();
    experiment::rest_at(&home, &mut session, &RestAt { setpoint: 60.0 }).unwrap();
    let was =
        |session: &mut Session| ["C.MAN_ON", "C.MAN", "C.SP_INT"].map(|name| session.state().unwrap().values[name]);
    let before = was(&mut session);
    assert_eq!((before[0], before[2]), (Value::Boolean(false), Value::Number(60.0)));
    let step = StepTest { size: 10.0, method: Method::LeastSquares, is_integrating: false };
    experiment::step(&home, &mut session, &step).unwrap();
    let at = |session: &mut Session| run::fmus::number_of(session.state().unwrap().values["C.PV"]);
    assert!(was(&mut session) == before && (at(&mut session) - 60.0).abs() < 0.05, "{}", at(&mut session));
    experiment::relay(&home, &mut session, &RelayTest { amplitude: 5.0, hysteresis: None }).unwrap();
    assert!(was(&mut session) == before && (at(&mut session) - 60.0).abs() < 0.05, "{}", at(&mut session));
    // The setpoint never moved.
    let events = session.record(None).unwrap().events().events;
    let moved = events.iter().filter(|event| event.variable == "C.SP_INT").count();
    assert_eq!(moved, 2, "{events:?}");
}
