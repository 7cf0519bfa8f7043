use super::*;
use crate::message::{Member, Setup};
use crate::test_home::TestHome;

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
    let values = tested.state.values;
    assert_eq!(values["C.MAN_ON"], Value::Boolean(true));
    // In automatic mode the P action starts from there.
    let number = |name: &str| number_of(values[name]);
    assert!((number("C.SP") - number("C.PV_IN")).abs() < 0.01, "{values:?}");
}

#[test]
fn a_relay_test_gives_the_ultimate_gain_and_period() {
    let home = TestHome::default();
    let mut session = session(&home);
    let tested = relay(&home, &mut session, &RelayTest { amplitude: 10.0, hysteresis: Some(1.0) }).unwrap();
    // The lag is driven to 15 above and below its mean, and goes from one end of its swing to the other in T ln((15 + a) / (15 - a)).
    let period = 2.0 * 10.0 * ((15.0 + tested.swing) / (15.0 - tested.swing)).ln();
    assert!((tested.ultimate.1 - period).abs() < 0.2, "{tested:?}");
    let expected = 4.0 * 10.0 / (std::f64::consts::PI * (tested.swing * tested.swing - 1.0).sqrt());
    assert!(
        (tested.ultimate.0 / expected - 1.0).abs() < 1e-9 && tested.swing > 1.0 && tested.swing < 1.4,
        "{tested:?}"
    );
    // An integrator K/s with dead time L: at 2 pi / (4 L) its gain is 1 over the ultimate gain.
    let model = tested.model;
    assert!(model.is_integrating && (4.0 * model.dead_time / tested.ultimate.1 - 1.0).abs() < 1e-12, "{model:?}");
    let frequency = std::f64::consts::FRAC_PI_2 / model.dead_time;
    assert!((model.gain / frequency * tested.ultimate.0 - 1.0).abs() < 1e-12, "{model:?}");
    let number = |name: &str| number_of(tested.state.values[name]);
    assert!(number("C.MAN_ON") == 1.0 && tested.remarks.is_empty(), "{tested:?}");
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
    let unstable = [("C.GAIN", 0.7), ("C.TI", 0.004)].map(|(name, value)| (name.to_string(), Value::Number(value)));
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
    assert_eq!(error(&mut session(&home), 0.0), "the step is 0: it has to be a number other than 0");
    assert!(error(&mut Session::default(), 1.0).contains("start a loop first"));
    // Nothing answers the step.
    let mut alone = Session::default();
    let member =
        Member { name: "C".into(), fmu: "PID".into(), values: Values::from([("CYCLE".into(), Value::Number(0.1))]) };
    alone.start(&home, Setup { members: vec![member], ..Setup::default() }).unwrap();
    let error = error(&mut alone, 5.0);
    assert_eq!(error, "nothing answers C: connect a plant first");
}
