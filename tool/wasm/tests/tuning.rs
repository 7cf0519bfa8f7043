//! The tuning rules with the real blocks: settings in each block's form, and the curve that its own arithmetic gives.

use control::identify::{self, Data, Method, Model};
use control::tune::{Predicted, Request, Rule, Structure, Tuned, tune};
use run::system::Value;
use tool::message::{Member, Setup, Values};
use tool::session::Session;
use tool::signals;
use tool_wasm::home::Linked;

fn request(fmu: &str, rule: Rule, structure: Structure, values: &[(&str, f64)]) -> Request {
    Request {
        model: Model { gain: 1.0, time_constant: 10.0, dead_time: 1.0, ..Model::default() },
        rule,
        structure,
        controller: Member {
            name: "TIC101".into(),
            fmu: fmu.into(),
            values: values.iter().map(|(name, value)| ((*name).into(), Value::Number(*value))).collect(),
        },
        closed_loop: None,
        pace: None,
        step: control::tune::Step::default(),
        ultimate: None,
    }
}

fn tuned(request: &Request) -> Tuned {
    tune(&Linked::new(), request).unwrap()
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
    let number = |tuned: &Tuned, name: &str| match tuned.values[name] {
        Value::Number(value) => value,
        Value::Boolean(value) => f64::from(u8::from(value)),
    };
    let of = |tuned: &Tuned| ["GAIN", "TI", "P_SEL", "I_SEL", "D_SEL"].map(|name| number(tuned, name));
    assert_eq!(of(&plain), [4.7619, 8.4, 1.0, 1.0, 0.0]);
    assert_eq!(plain.values.len(), 5);
    assert!((last(&plain.predicted.process_value) - 10.0).abs() < 0.02);
    let halved = tuned(&request("CONT_C", Rule::Simc, Structure::Pi, &[("CYCLE", 0.1), ("LMN_FAC", 0.5)]));
    assert_eq!(of(&halved)[..2], [9.5238, 8.4]);
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
    assert!(pulses.predicted.manipulated_value.iter().all(|value| [0.0, 100.0].contains(value)));
    // PV_IN of the block inside is a parameter, which nothing can be connected to.
    let other = tuned(&request("PULS_CTR", Rule::Simc, Structure::Pi, &[("DI_CONT_C.PVPER_ON", 0.0)]));
    let remark = "Predicted with the process value at PV_PER, that is with DI_CONT_C.PVPER_ON = TRUE.";
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
    let error = tune(&Linked::new(), &request("HLG", Rule::Simc, Structure::Pi, &[])).unwrap_err();
    assert!(error.to_string().starts_with("HLG is not a controller with a GAIN"), "{error}");
}

#[test]
fn a_pulse_of_cont_s_that_moves_the_process_value_through_the_dead_band_is_told() {
    let remarks = |settings: &[(&str, f64)]| tuned(&request("CONT_S", Rule::Simc, Structure::Pi, settings)).remarks;
    // 3 s of 30 s are 10 %, and the plant has a gain of 1.
    let expected = "The shortest pulse of 3 s moves the process value by 10, and DEADB_W = 1 is less than half of it: the loop \
                    will not rest. Shorten PULSE_TM or CYCLE, or set DEADB_W to 5.";
    let settings = [("CYCLE", 0.1), ("PULSE_TM", 3.0), ("MTR_TM", 30.0), ("DEADB_W", 1.0)];
    assert!(remarks(&settings).iter().any(|remark| remark == expected), "{:?}", remarks(&settings));
    for fine in [[settings[0], ("PULSE_TM", 0.3)], [settings[1], ("DEADB_W", 5.0)]] {
        let settings: Vec<_> = [settings[2], settings[3]].into_iter().chain(fine).collect();
        assert!(!remarks(&settings).iter().any(|remark| remark.contains("will not rest")), "{settings:?}");
    }
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

#[test]
fn the_plant_of_a_step_controller_is_identified_from_a_pulse_in_manual_mode() {
    let values = |values: &[(&str, f64)]| -> Values {
        values.iter().map(|(name, value)| ((*name).into(), Value::Number(*value))).collect()
    };
    let member = |name: &str, fmu: &str, of| Member { name: name.into(), fmu: fmu.into(), values: values(of) };
    let controller = [("CYCLE", 0.1), ("MTR_TM", 30.0), ("PULSE_TM", 0.1), ("BREAK_TM", 0.1), ("LMNS_ON", 1.0)];
    let valve = [("CYCLE", 0.1), ("MTR_TM", 30.0), ("BACKLASH", 0.0), ("POS_START", 30.0)];
    let process = [("CYCLE", 0.1), ("GAIN", 2.0), ("T1", 20.0), ("DEAD_TM", 2.0), ("DEAD_MAX", 2.0)];
    let connections = [
        ("TIC101.QLMNUP", "VALVE.UP"),
        ("TIC101.QLMNDN", "VALVE.DOWN"),
        ("VALVE.LMNR", "PLANT.U"),
        ("PLANT.PV", "TIC101.PV_IN"),
    ];
    let setup = Setup {
        members: vec![
            member("TIC101", "CONT_S", &controller),
            member("VALVE", "VALVE", &valve),
            member("PLANT", "PROCESS", &process),
        ],
        connections: connections.map(|(from, to)| (from.into(), to.into())).into(),
        ..Setup::default()
    };
    let (home, mut session) = (Linked::new(), Session::default());
    session.start(&home, setup).unwrap();
    session.run(2000).unwrap();
    for (is_on, calls) in [(1.0, 60), (0.0, 1500)] {
        session.send(&values(&[("TIC101.LMNUP", is_on)])).unwrap();
        session.run(calls).unwrap();
    }
    let data = Data::Run { run: None, from: None, to: None };
    let request = identify::Request { data, method: Method::LeastSquares, is_integrating: false };
    let identified = signals::identify(&home, &session, &request).unwrap();
    let Model { gain, time_constant, dead_time, .. } = identified.model;
    assert!((gain - 2.0).abs() < 0.02 && (time_constant - 20.0).abs() < 0.3, "{identified:?}");
    assert!((dead_time - 2.0).abs() < 0.1, "{dead_time}");
    assert!(identified.remarks[0].contains("100 % in MTR_TM = 30 s"), "{:?}", identified.remarks);
}
