use super::*;
use crate::message::{Member, Setup};
use crate::test_home::TestHome;
use run::fmus::number_of;

fn session(home: &TestHome) -> Session {
    let values =
        |given: &[(&str, f64)]| given.iter().map(|(name, value)| (name.to_string(), Value::Number(*value))).collect();
    let member = |name: &str, fmu: &str, given: &[(&str, f64)]| Member {
        name: name.into(),
        fmu: fmu.into(),
        values: values(given),
    };
    let connections = [("C.OUT", "P.POWER"), ("P.TEMP", "C.PV_IN")];
    let setup = Setup {
        members: vec![
            member("C", "PID", &[("GAIN", 1.0), ("TI", 8.0), ("SP", 30.0), ("CYCLE", 0.1)]),
            member("P", "LAG", &[("CYCLE", 0.1)]),
        ],
        connections: connections.map(|(from, to)| (from.into(), to.into())).into(),
        ..Setup::default()
    };
    let mut session = Session::default();
    session.start(home, setup).unwrap();
    session.run(37).unwrap();
    session
}

#[test]
fn a_step_test_holds_waits_steps_waits_and_identifies() {
    let home = TestHome::default();
    let mut session = session(&home);
    let before = number_of(session.state().unwrap().values["C.OUT"]);
    let request = StepTest { size: 10.0, method: Method::LeastSquares, is_integrating: false };
    let tested = step(&home, &mut session, &request).unwrap();
    let model = tested.identified.model;
    // The plant has a gain of 1.5 and a lag of 10 s.
    assert!((model.gain / 1.5 - 1.0).abs() < 0.01 && (model.time_constant / 10.0 - 1.0).abs() < 0.02, "{model:?}");
    let record = session.record(None).unwrap();
    let at = |name: &str, time: f64| {
        let call = record.calls_between(Some(time), Some(time)).start;
        record.trace().get(record.column(name).unwrap(), call)
    };
    assert_eq!((at("C.OUT", tested.from), at("C.MAN_ON", tested.from)), (before, 1.0), "it does not jump");
    assert_eq!(at("C.OUT", tested.step), before + 10.0);
    assert_eq!(at("C.OUT", tested.step - 0.1), before);
    assert!(tested.step - tested.from > 20.0, "the plant was not at rest");
    // Afterwards everything is as the user had it.
    let values = tested.state.values;
    let number = |name: &str| number_of(values[name]);
    assert_eq!((values["C.MAN_ON"], number("C.MAN"), number("C.SP")), (Value::Boolean(false), 0.0, 30.0));
}

#[test]
fn a_test_in_manual_mode_leaves_manual_value_and_plant_where_they_were() {
    let home = TestHome::default();
    let mut session = session(&home);
    let set = |values: &[(&str, Value)]| values.iter().map(|(name, value)| (name.to_string(), *value)).collect();
    session.send(&set(&[("C.MAN_ON", Value::Boolean(true)), ("C.MAN", Value::Number(12.0))])).unwrap();
    session.run(2000).unwrap();
    let before = session.state().unwrap().values;
    let request = StepTest { size: 10.0, method: Method::LeastSquares, is_integrating: false };
    let after = step(&home, &mut session, &request).unwrap().state.values;
    for name in ["C.MAN_ON", "C.MAN", "C.SP", "C.OUT"] {
        assert_eq!(after[name], before[name], "{name}");
    }
    assert!((number_of(after["P.TEMP"]) - number_of(before["P.TEMP"])).abs() < 0.02, "{after:?}");
    // The step that follows begins in automatic mode at rest, and its first answer has the P action: GAIN is 1.
    let at = number_of(before["P.TEMP"]);
    let settled = rest_at(&home, &mut session, &RestAt { setpoint: at }).unwrap();
    let (held, is_manual) = (number_of(settled.state.values["C.OUT"]), settled.state.values["C.MAN_ON"]);
    assert!(settled.is_at_rest && is_manual == Value::Boolean(false) && (held - 12.0).abs() < 0.02, "{settled:?}");
    session.send(&set(&[("C.SP", Value::Number(at + 5.0))])).unwrap();
    let answer = number_of(session.run(1).unwrap().values["C.OUT"]);
    assert!((answer - held - 5.0).abs() < 0.2, "{answer} {held}");
}

#[test]
fn a_relay_test_of_a_plant_without_dead_time_is_refused_and_leaves_no_trace() {
    let home = TestHome::default();
    let mut session = session(&home);
    let refused = relay(&home, &mut session, &RelayTest { amplitude: 10.0, hysteresis: Some(1.0) }).unwrap_err();
    assert!(refused.to_string().contains("too little dead time for calls every 0.1 s"), "{refused:#}");
    let values = session.state().unwrap().values;
    let number = |name: &str| number_of(values[name]);
    assert_eq!((values["C.MAN_ON"], number("C.MAN"), number("C.SP")), (Value::Boolean(false), 0.0, 30.0));
}

#[test]
fn a_run_until_the_loop_rests_ends_where_it_does_and_says_so() {
    let home = TestHome::default();
    let mut session = session(&home);
    let from = session.state().unwrap().time;
    let settled = settle(&home, &mut session, &Settle { calls: 20_000, from }).unwrap();
    let number = |settled: &Settled, name: &str| number_of(settled.state.values[name]);
    // The setpoint is 30, the plant has a gain of 1.5: 20 % hold it there.
    assert!(settled.is_at_rest && !settled.swings && settled.state.calls < 2000, "{}", settled.state.calls);
    assert!((number(&settled, "P.TEMP") - 30.0).abs() < 0.1 && (number(&settled, "C.OUT") - 20.0).abs() < 0.1);
    // What is done then is waited for anew, 200 calls at least.
    let before = settled.state.calls;
    session.send(&Values::from([("C.SP".into(), Value::Number(60.0))])).unwrap();
    let settled = settle(&home, &mut session, &Settle { calls: 20_000, from }).unwrap();
    assert!(settled.is_at_rest && settled.state.calls >= before + 200 && settled.state.calls < before + 2000);
    assert!((number(&settled, "P.TEMP") - 60.0).abs() < 0.2);
    // So many calls do not show it.
    session.send(&Values::from([("C.SP".into(), Value::Number(30.0))])).unwrap();
    let settled = settle(&home, &mut session, &Settle { calls: 150, from }).unwrap();
    assert!(!settled.is_at_rest);
}

#[test]
fn a_loop_that_swings_for_ever_is_not_said_to_rest() {
    let home = TestHome::default();
    let mut session = session(&home);
    let from = session.state().unwrap().time;
    // With TI far below the delay of a call the loop is unstable, until the limits of the output hold its swing.
    let unstable = [("C.GAIN", 3.0), ("C.TI", 0.004)].map(|(name, value)| (name.to_string(), Value::Number(value)));
    session.send(&Values::from(unstable)).unwrap();
    let settled = settle(&home, &mut session, &Settle { calls: 20_000, from }).unwrap();
    assert_eq!((settled.is_at_rest, settled.swings), (false, true), "{}", settled.state.calls);
    assert!(settled.state.calls < 20_000);
}

#[test]
fn an_experiment_that_tells_nothing_is_refused() {
    let home = TestHome::default();
    let request = |size| StepTest { size, method: Method::LeastSquares, is_integrating: false };
    let error = |session: &mut Session, size| format!("{:#}", step(&home, session, &request(size)).unwrap_err());
    assert_eq!(error(&mut session(&home), 0.0), "the step size is 0: it must be a nonzero number");
    assert!(error(&mut Session::default(), 1.0).contains("start one first"));
    // Nothing answers the step.
    let mut alone = Session::default();
    let member =
        Member { name: "C".into(), fmu: "PID".into(), values: Values::from([("CYCLE".into(), Value::Number(0.1))]) };
    alone.start(&home, Setup { members: vec![member], ..Setup::default() }).unwrap();
    let error = error(&mut alone, 5.0);
    assert_eq!(error, "nothing responds to C: connect a plant first");
}
