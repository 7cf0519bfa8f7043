use super::*;
use crate::message::Member;
use crate::run::{self, Recording};
use crate::test_home::TestHome;

fn values(given: &[(&str, f64)]) -> Values {
    given.iter().map(|(name, value)| (name.to_string(), Value::Number(*value))).collect()
}

fn member(name: &str, fmu: &str, given: &[(&str, f64)]) -> Member {
    Member { name: name.into(), fmu: fmu.into(), values: values(given) }
}

fn wires() -> Vec<(String, String)> {
    [("C.OUT", "P.POWER"), ("P.TEMP", "C.PV_IN")].map(|(from, to)| (from.into(), to.into())).into()
}

fn setup(plant: &str) -> Setup {
    let members = vec![member("C", "PID", &[("GAIN", 0.7), ("SP", 40.0)]), member("P", plant, &[("CYCLE", 0.5)])];
    Setup { members, connections: wires(), ..Setup::default() }
}

fn started(home: &TestHome) -> Session {
    let mut session = Session::default();
    session.start(home, setup("LAG")).unwrap();
    session
}

fn number(state: &State, name: &str) -> f64 {
    match state.values[name] {
        Value::Number(value) => value,
        Value::Boolean(_) => panic!("{name} is Boolean"),
    }
}

fn error<T: std::fmt::Debug>(result: Result<T>) -> String {
    format!("{:#}", result.unwrap_err())
}

/// What `plcfmu run` of the record's description records: settings, events by time, everything recorded.
fn described(home: &TestHome, record: &Record) -> Recording {
    let setup = record.setup();
    let descriptions: Vec<_> = setup.members.iter().map(|of| home.description(&of.fmu).unwrap()).collect();
    let setting = |variable: String, value, time| Setting { variable, value, time, is_preliminary: false, place: None };
    let is_connected = |name: &str| setup.connections.iter().any(|(_, to)| to == name);
    let of_members = setup
        .members
        .iter()
        .flat_map(|of| of.values.iter().map(|(name, value)| setting(format!("{}.{name}", of.name), *value, None)));
    let events = record.events().events.into_iter().map(|event| setting(event.variable, event.value, Some(event.time)));
    let system = System {
        members: setup.members.iter().map(|of| system::Member { name: of.name.clone(), path: "".into() }).collect(),
        settings: of_members.filter(|of| !is_connected(&of.variable)).chain(events).collect(),
        connections: setup
            .connections
            .iter()
            .map(|(from, to)| Connection { from: from.clone(), to: to.clone(), place: None })
            .collect(),
        record: record.columns().iter().map(|column| column.name.as_str().into()).collect(),
        stop: Some(record.time(record.calls())),
        step: Some(record.step()),
        exchange: setup.exchange,
        ..System::default()
    };
    let borrowed: Vec<_> = descriptions.iter().map(|of| &**of).collect();
    let plan = Plan::of(&system, &borrowed).unwrap();
    let mut components: Vec<_> = setup.members.iter().map(|of| home.instantiate(&of.fmu, &of.name).unwrap()).collect();
    run::run(&plan, &mut components, |_| {}).unwrap()
}

fn assert_is(record: &Record, recording: &Recording) {
    assert_eq!(record.calls(), recording.times.len());
    for (call, (time, row)) in recording.rows().enumerate() {
        assert_eq!(record.time(call).to_bits(), time.to_bits());
        for (column, value) in row.iter().enumerate() {
            let own = record.trace().get(column, call);
            assert_eq!(own.to_bits(), value.to_bits(), "{} in call {call}", record.columns()[column].name);
        }
    }
}

#[test]
fn a_session_has_the_bits_of_its_description() {
    for exchange in [system::Exchange::Sequential, system::Exchange::Parallel] {
        let home = TestHome::default();
        let mut session = Session::default();
        session.start(&home, Setup { exchange, ..setup("LAG") }).unwrap();
        session.run(7).unwrap();
        session.send(&values(&[("C.SP", 55.5), ("P.LOAD", 3.0)])).unwrap();
        session.run(40).unwrap();
        session.ramp("C.SP", 20.0, 13.0).unwrap();
        session.send(&values(&[("C.GAIN", 0.1)])).unwrap();
        session.run(100).unwrap();
        session.send(&values(&[("C.MAN_ON", 1.0), ("C.MAN", 12.3), ("C.TI", 4.5)])).unwrap();
        session.run(20).unwrap();
        let record = session.record(None).unwrap();
        assert!(
            record.columns().iter().any(|column| column.name == "P.TEMP" && column.unit.as_deref() == Some("degC"))
        );
        assert_is(record, &described(&home, record));
    }
}
