use super::*;
use crate::message::Member;
use crate::test_home::{FOREIGN, TestHome};
use run::fmus::{Fmus, number_of};
use run::master::{self, Recording};

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
        Value::Boolean(_) => panic!("{name} is Boolean"),
        value => number_of(value),
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
    let plan = Plan::new(&system, &borrowed).unwrap();
    let mut components: Vec<_> = setup.members.iter().map(|of| home.instantiate(&of.fmu, &of.name).unwrap()).collect();
    master::run(&plan, &mut components, |_| {}).unwrap()
}

fn assert_is(record: &Record, recording: &Recording) {
    // The last row is that of the end, at which there is no call.
    assert_eq!(record.calls() + 1, recording.times.len());
    for (call, (time, row)) in recording.rows().take(record.calls()).enumerate() {
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

#[test]
fn it_repeats_to_the_same_bits() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(3).unwrap();
    session.send(&values(&[("C.SP", 55.5)])).unwrap();
    session.ramp("P.LOAD", -8.0, 20.0).unwrap();
    session.run(60).unwrap();
    session.send(&values(&[("C.SP", 1.0)])).unwrap();
    let state = session.same_bits(&home, None).unwrap();
    assert_eq!((state.run, state.calls), (1, 63));
    let (first, second) = (session.record(Some(0)).unwrap(), session.record(Some(1)).unwrap());
    assert_eq!(first.events(), second.events());
    assert!(first.events().events.iter().any(|event| event.call == 63), "what is sent, but not yet there, is kept");
    let bits = |record: &Record| {
        let all = (0..record.columns().len()).flat_map(|column| record.trace().column(column, 0..63));
        all.map(f64::to_bits).collect::<Vec<_>>()
    };
    assert_eq!(bits(first), bits(second));
}

#[test]
fn an_earlier_run_is_repeated_without_what_was_set_after_its_last_call() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(5).unwrap();
    // Applied, and run again: it has acted in the second run only.
    session.send(&values(&[("C.GAIN", 7.0)])).unwrap();
    session.same_test(&home, None, &Values::new()).unwrap();
    session.same_bits(&home, Some(0)).unwrap();
    assert!(session.record(None).unwrap().events().events.is_empty());
}

#[test]
fn the_same_test_has_the_settings_in_force_from_its_beginning() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(3).unwrap();
    session.send(&values(&[("C.SP", 55.5), ("C.GAIN", 1.3), ("P.LOAD", 2.0)])).unwrap();
    session.run(60).unwrap();
    session.send(&values(&[("C.TI", 4.0), ("C.GAIN", 1.5)])).unwrap();
    let state = session.same_test(&home, None, &Values::new()).unwrap();
    let same = session.record(None).unwrap();
    let shown = |record: &Record| {
        let event = |event: Event| (event.call, event.variable, event.value);
        record.events().events.into_iter().map(event).collect::<Vec<_>>()
    };
    let stimuli = [(3, "C.SP".to_string(), Value::Number(55.5)), (3, "P.LOAD".to_string(), Value::Number(2.0))];
    assert_eq!((shown(same), same.calls()), (stimuli.to_vec(), 63));
    let begins = &same.setup().members[0].values;
    assert_eq!(*begins, values(&[("GAIN", 1.5), ("SP", 40.0), ("TI", 4.0)]));
    assert_eq!((number(&state, "C.GAIN"), number(&state, "C.TI"), number(&state, "C.SP")), (1.5, 4.0, 55.5));

    // The test of any run, with the settings that the page has; a setpoint among them is not.
    session.same_test(&home, Some(0), &values(&[("C.GAIN", 0.2), ("C.SP", 99.0)])).unwrap();
    let same = session.record(None).unwrap();
    assert_eq!(shown(same), stimuli);
    assert_eq!(same.setup().members[0].values, values(&[("GAIN", 0.2), ("SP", 40.0), ("TI", 4.0)]));
    let unknown = error(session.same_test(&home, None, &values(&[("Q.GAIN", 1.0)])));
    assert_eq!(unknown, "the run has no member with the variable \"Q.GAIN\"");
}

#[test]
fn settings_are_tried_beside_the_run_with_the_bits_of_the_same_test() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(3).unwrap();
    session.send(&values(&[("C.SP", 55.5)])).unwrap();
    session.run(60).unwrap();
    let other = values(&[("C.GAIN", 0.2)]);
    let wanted = view("P.TEMP", 200);
    let before = session.view(&wanted).unwrap();
    let tried = session.tried(&home, &other).and_then(|beside| beside.view(&wanted)).unwrap();
    assert_eq!((session.record(None).unwrap().number(), session.view(&wanted).unwrap()), (0, before));
    session.same_test(&home, None, &other).unwrap();
    assert_eq!(tried, session.view(&wanted).unwrap());
    session.run(MOST_TRIED).unwrap();
    let refused = error(session.tried(&home, &other).map(|_| ()));
    assert_eq!(refused, "the run has 20063 calls: settings can be tried only in runs of at most 20000");
}

#[test]
fn the_same_test_has_the_plant_in_force_from_its_beginning() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(4).unwrap();
    session.send(&values(&[("P.LOAD", 2.0)])).unwrap();
    session.run(4).unwrap();
    // The same plant, three times as slow: what disturbed it stays.
    let slower = member("P", "LAG", &[("CYCLE", 0.5), ("T", 30.0), ("LOAD", 2.0)]);
    session.exchange(&home, vec![slower], wires()).unwrap();
    session.run(4).unwrap();
    session.same_test(&home, None, &Values::new()).unwrap();
    let same = session.record(None).unwrap();
    assert!(same.exchanges().is_empty());
    assert_eq!(same.setup().members[1].values, values(&[("CYCLE", 0.5), ("T", 30.0)]));
    let load = |call| same.trace().get(same.column("P.LOAD").unwrap(), call);
    assert_eq!((same.calls(), load(3), load(4), load(11)), (12, 0.0, 2.0, 2.0));
    // Another one: what was set in the plant that has gone does not come again.
    let other = [("C.OUT", "Q.POWER"), ("Q.TEMP", "C.PV_IN")].map(|(from, to)| (from.into(), to.into()));
    session.exchange(&home, vec![member("Q", "LAG", &[("CYCLE", 0.5)])], other.into()).unwrap();
    let state = session.same_test(&home, None, &Values::new()).unwrap();
    assert_eq!((state.calls, session.record(None).unwrap().events().events.len()), (12, 0));
}

#[test]
fn a_ramp_is_an_event_before_each_call_and_ends_at_its_value() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(2).unwrap();
    session.ramp("C.SP", 50.0, 2.0).unwrap();
    session.run(6).unwrap();
    let events = session.record(None).unwrap().events().events;
    let shown: Vec<_> = events.iter().map(|event| (event.call, event.time, event.value)).collect();
    let expected = [(2, 1.0, 42.5), (3, 1.5, 45.0), (4, 2.0, 47.5), (5, 2.5, 50.0)];
    assert_eq!(shown, expected.map(|(call, time, value)| (call, time, Value::Number(value))));
}

#[test]
fn a_ramp_begins_at_the_value_that_was_sent_and_a_later_value_ends_it() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(1).unwrap();
    session.send(&values(&[("C.SP", 10.0)])).unwrap();
    session.ramp("C.SP", 14.0, 2.0).unwrap();
    session.run(2).unwrap();
    session.send(&values(&[("C.SP", 99.0)])).unwrap();
    let state = session.run(5).unwrap();
    assert_eq!(number(&state, "C.SP"), 99.0);
    let events = session.record(None).unwrap().events().events;
    let shown: Vec<_> = events.iter().map(|event| (event.call, event.value)).collect();
    assert_eq!(shown, [(1, 11.0), (2, 12.0), (3, 99.0)].map(|(call, value)| (call, Value::Number(value))));
}

#[test]
fn of_two_values_before_one_call_the_later_counts() {
    let home = TestHome::default();
    let mut session = started(&home);
    for value in [1.0, 2.0, 3.0] {
        session.send(&values(&[("C.SP", value)])).unwrap();
    }
    assert_eq!(number(&session.run(1).unwrap(), "C.SP"), 3.0);
    let events = session.record(None).unwrap().events().events;
    assert_eq!(events.len(), 1);
    assert_eq!((events[0].call, events[0].value), (0, Value::Number(3.0)));
}

#[test]
fn what_cannot_be_sent_is_refused_before_anything_is_changed() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(1).unwrap();
    let cases = [
        (
            "C.BITS",
            4.0,
            "C.BITS cannot be changed while the loop runs, because it is a fixed parameter: restart with the new value",
        ),
        ("C.CYCLE", 4.0, "restart with the new value"),
        ("C.PV_IN", 4.0, "C.PV_IN cannot be set: it is connected to P.TEMP"),
        ("C.OUT", 4.0, "C.OUT cannot be set: its causality is output"),
        (
            "C.GAIN",
            1e39,
            "C.GAIN cannot be set to 1e39: a REAL accepts finite numbers with a magnitude of at most 3.4028235e38",
        ),
        ("C.GAIN", f64::NAN, "C.GAIN cannot be set: NaN is not a finite number"),
        ("P.LOAD", f64::INFINITY, "P.LOAD cannot be set: inf is not a finite number"),
        ("C.TI", -1.0, "a TIME accepts 0 ... 2147483.647 s"),
        ("C.MAN_ON", 0.5, "neither true (1) nor false (0)"),
        ("C.GAN", 1.0, "did you mean C.GAIN?"),
        ("<b>x</b>", 1.0, "does not name an FMU of this run"),
    ];
    for (name, value, expected) in cases {
        let error = error(session.send(&values(&[("C.SP", -7.0), (name, value)])));
        assert!(error.contains(expected), "{name}: {error}");
        let before = session.record(None).unwrap().calls();
        assert_eq!(number(&session.run(1).unwrap(), "C.SP"), 40.0, "{name}");
        assert_eq!(session.record(None).unwrap().calls(), before + 1);
    }
    assert!(session.record(None).unwrap().events().events.is_empty());
    let warned = session.send(&values(&[("C.SP", 101.0)])).unwrap();
    assert_eq!(warned.remarks, ["C.SP = 101.0 is outside the range declared by the FMU, -100.0 to 100.0"]);
    assert!(session.run(1).unwrap().remarks.is_empty(), "a remark is said once");
}

#[test]
fn a_ramp_that_cannot_be_is_refused() {
    let home = TestHome::default();
    let mut session = started(&home);
    let cases = [
        ("C.MAN_ON", 1.0, 1.0, "C.MAN_ON is Boolean: only a number can be ramped"),
        ("C.SP", 1.0, -1.0, "a ramp of -1.0 s: the allowed range is 0 to 50000.0 s (100000 calls)"),
        ("C.SP", 1.0, f64::NAN, "a ramp of NaN s"),
        ("C.SP", 1.0, 1e9, "a ramp of 1000000000.0 s"),
        ("C.SP", 1e300, 1.0, "a REAL accepts finite numbers"),
        ("C.PV_IN", 1.0, 1.0, "it is connected to P.TEMP"),
    ];
    for (name, to, seconds, expected) in cases {
        let error = error(session.ramp(name, to, seconds));
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_run_has_a_million_events_at_most() {
    let home = TestHome::default();
    let mut session = Session::default();
    let members = ["C", "P", "Q"].map(|name| member(name, if name == "C" { "PID" } else { "LAG" }, &[]));
    session.start(&home, Setup { members: members.into(), step: Some(0.5), ..Setup::default() }).unwrap();
    for name in ["C.SP", "C.MAN", "C.GAIN", "C.TI", "P.LOAD", "P.K", "P.T", "Q.LOAD", "Q.K"] {
        session.ramp(name, 50.0, 50_000.0).unwrap();
    }
    session.ramp("Q.T", 50.0, 49_999.0).unwrap();
    session.send(&values(&[("C.HIGH", 1.0), ("P.POWER", 1.0)])).unwrap();
    let expected = "a run can have at most 1000000 events: start again, or use shorter ramps";
    assert_eq!(error(session.send(&values(&[("C.HIGH", 1.0)]))), expected);
    assert_eq!(error(session.ramp("C.HIGH", 1.0, 0.5)), expected);
    session.run(3).unwrap();
    // What has been and what will be count together.
    assert_eq!(error(session.ramp("C.HIGH", 1.0, 0.5)), expected);
}

#[test]
fn a_setup_that_cannot_run_is_refused_and_the_present_run_goes_on() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(5).unwrap();
    let one = |name: &str, fmu: &str, given: &[(&str, f64)]| Setup {
        members: vec![member(name, fmu, given)],
        ..Setup::default()
    };
    let both =
        |a: &str, b: &str| Setup { members: vec![member(a, "PID", &[]), member(b, "LAG", &[])], ..Setup::default() };
    let wired = |from: &str, to: &str| Setup { connections: vec![(from.into(), to.into())], ..setup("LAG") };
    let cases = [
        (Setup::default(), "nothing to run"),
        (one("C", "NO_SUCH", &[]), "no FMU \"NO_SUCH\" here"),
        (one("", "PID", &[]), "the name of member 1 has 0 characters"),
        (one(&"x".repeat(201), "PID", &[]), "the name of member 1 has 201 characters"),
        (both("C", "C"), "two members are named C: rename one"),
        (both("C.D", "C"), "the members C.D and C cannot be told apart"),
        (Setup { members: vec![member("C", "PID", &[]); 101], ..Setup::default() }, "101 members"),
        (one("C", "PID", &[("GAN", 1.0)]), "did you mean C.GAIN?"),
        (one("C", "PID", &[("GAIN", f64::NAN)]), "C.GAIN cannot be set: NaN is not a finite number"),
        (one("C", "PID", &[("BITS", 40_000.0)]), "an INT accepts -32768 ... 32767"),
        (one("C", "PID", &[("CYCLE", 0.0)]), "the communication step is 0.0 s"),
        (Setup { step: Some(-1.0), ..setup("LAG") }, "the communication step is -1.0 s"),
        (Setup { step: Some(f64::NAN), ..setup("LAG") }, "the communication step is NaN s"),
        (Setup { step: Some(1e6), ..setup("LAG") }, "which is more than 1000 times in a communication step"),
        (wired("C.OUT", "P.HEAT"), "it is Real, but the input is Boolean"),
        (wired("C.OUT", "P.TEMP"), "the causality of P.TEMP is output"),
    ];
    for (setup, expected) in cases {
        let error = error(session.start(&home, setup));
        assert!(error.contains(expected), "{expected}: {error}");
    }
    assert_eq!(session.run(1).unwrap().calls, 6);
    assert_eq!(session.state().unwrap().run, 0);
}

#[test]
fn names_may_hold_any_text() {
    let home = TestHome::default();
    let name = "TIC 101 <img src=x onerror=alert(1)> \"ä\" {}";
    let mut session = Session::default();
    let setup = Setup { members: vec![member(name, "PID", &[("SP", 4.0)])], ..Setup::default() };
    session.start(&home, setup).unwrap();
    session.send(&values(&[(&format!("{name}.GAIN"), 3.0)])).unwrap();
    let state = session.run(1).unwrap();
    assert_eq!(number(&state, &format!("{name}.GAIN")), 3.0);
    assert!(number(&state, &format!("{name}.OUT")) > 12.0);
}

#[test]
fn a_request_makes_so_many_calls_and_no_more() {
    let home = TestHome::default();
    let mut session = Session::default();
    assert_eq!(error(session.run(1)), "no loop is running: start one first");
    session.start(&home, setup("LAG")).unwrap();
    for calls in [0, MOST_CALLS + 1, usize::MAX] {
        let error = error(session.run(calls));
        assert_eq!(error, format!("{calls} calls: a request can make 1 to 100000; send another request for more"));
    }
    assert_eq!(session.run(MOST_CALLS).unwrap().calls, MOST_CALLS);
}

#[test]
fn before_the_first_call_the_values_are_those_after_the_initialization() {
    let home = TestHome::default();
    let mut session = Session::default();
    let state = session.start(&home, setup("LAG")).unwrap();
    assert_eq!((state.run, state.calls, state.time, state.step), (0, 0, 0.0, 0.5));
    assert_eq!((number(&state, "C.SP"), number(&state, "P.CYCLE")), (40.0, 0.5));
    assert_eq!(state.values["C.P_SEL"], Value::Boolean(true));
    let state = session.run(3).unwrap();
    assert_eq!((state.calls, state.time), (3, 1.0));
}

#[test]
fn five_earlier_runs_are_kept_and_can_be_viewed() {
    let home = TestHome::default();
    let mut session = started(&home);
    for run in 1..=6 {
        session.run(run).unwrap();
        session.start(&home, setup("LAG")).unwrap();
    }
    assert_eq!(
        error(session.record(Some(0)).map(Record::calls)),
        "no run 0: only the current one and the 5 before it are kept"
    );
    for run in 1..=5 {
        assert_eq!(session.record(Some(run)).unwrap().calls(), run + 1);
    }
    assert_eq!(session.record(Some(6)).unwrap().calls(), 0);
    session.record(Some(7)).unwrap_err();
}

fn view(variable: &str, points: usize) -> View {
    View { run: None, variables: vec![variable.into()], from: None, to: None, points, means: None }
}

#[test]
fn a_view_has_the_calls_between_two_times_with_the_units() {
    let home = TestHome::default();
    let mut session = started(&home);
    session.run(100).unwrap();
    let between = |from, to| session.view(&View { from: Some(from), to: Some(to), ..view("P.TEMP", 50) }).unwrap();
    let curves = between(1.0, 2.4);
    assert_eq!((curves.times.as_slice(), curves.is_exact), ([1.0, 1.5, 2.0].as_slice(), true));
    assert_eq!(curves.units, [Some("degC".to_string())]);
    let record = session.record(None).unwrap();
    let column = record.column("P.TEMP").unwrap();
    assert_eq!(
        curves.values,
        [vec![record.trace().get(column, 2), record.trace().get(column, 3), record.trace().get(column, 4)]]
    );
    assert!(between(5.0, 4.0).times.is_empty() && between(-9.0, -1.0).times.is_empty());
    assert!(between(60.0, f64::MAX).times.is_empty());
    assert_eq!(between(-f64::MAX, 0.0).times, [0.0]);
    let all = session.view(&view("P.TEMP", 100)).unwrap();
    assert_eq!((all.times.len(), all.is_exact), (100, true));
    let thin = session.view(&view("P.TEMP", 99)).unwrap();
    assert_eq!((thin.times.len(), thin.is_exact), (98, false));
    assert_eq!(error(session.view(&view("P.TEMP", 0))), "points = 0: a curve needs at least 2");
    assert!(error(session.view(&view("P.TEM", 9))).ends_with("did you mean P.TEMP?"));
}

#[test]
fn an_fmu_that_fails_ends_the_run_and_the_controller_goes_on_with_another_plant() {
    let home = TestHome::default();
    home.fails_at.set(5.0);
    let mut session = Session::default();
    let mut foreign = setup(FOREIGN);
    foreign.members[1].values = values(&[("CYCLE", 0.5)]);
    session.start(&home, foreign).unwrap();
    session.run(4).unwrap();
    session.send(&values(&[("C.SP", 30.0)])).unwrap();
    let state = session.run(100).unwrap();
    assert_eq!(state.failure.as_deref(), Some("P: the step returned an error: it is enough"));
    // The controller has made its call at 5 s before the plant failed.
    assert_eq!((state.calls, state.time), (11, 5.0));
    assert_eq!(session.view(&view("C.OUT", 100)).unwrap().times.len(), 11);
    assert!(error(session.run(1)).contains("the run has ended (P: the step returned an error: it is enough)"));
    assert!(error(session.send(&values(&[("C.SP", 1.0)]))).starts_with("the run has ended"));

    let other = member("Q", "LAG", &[("CYCLE", 0.5)]);
    let connections = [("C.OUT", "Q.POWER"), ("Q.TEMP", "C.PV_IN")].map(|(from, to)| (from.into(), to.into()));
    let integral = number(&state, "C.OUT");
    let state = session.exchange(&home, vec![other], connections.into()).unwrap();
    assert_eq!((state.failure, state.calls), (None, 11));
    assert!(!state.values.contains_key("P.TEMP") && state.values.contains_key("Q.TEMP"));
    let state = session.run(1).unwrap();
    // The integral is kept: the plant is cold again, so the output is higher than it was, not lower.
    assert!(number(&state, "C.OUT") > integral, "{} {integral}", number(&state, "C.OUT"));
    assert_eq!((state.time, number(&state, "C.SP")), (5.5, 30.0));
    session.run(20).unwrap();

    let record = session.record(None).unwrap();
    assert_eq!(record.events().events.len(), 1);
    assert_eq!(record.exchanges()[0].call, 11);
    let of = |name: &str, call| record.trace().get(record.column(name).unwrap(), call);
    assert!(of("P.TEMP", 10).is_finite() && of("P.TEMP", 11).is_nan());
    assert!(of("Q.TEMP", 10).is_nan() && of("Q.TEMP", 11).is_finite());

    let before = session.record(None).unwrap().clone();
    session.same_bits(&home, None).unwrap();
    let again = session.record(None).unwrap();
    assert_eq!((again.calls(), again.exchanges()), (before.calls(), before.exchanges()));
    for name in ["C.OUT", "P.TEMP", "Q.TEMP"] {
        let bits = |record: &Record| {
            let values = record.trace().column(record.column(name).unwrap(), 0..record.calls());
            values.map(f64::to_bits).collect::<Vec<_>>()
        };
        assert_eq!(bits(again), bits(&before), "{name}");
    }
}

#[test]
fn an_exchange_that_cannot_be_leaves_everything_as_it_was() {
    let home = TestHome::default();
    let mut session = started(&home);
    let mut untouched = started(&home);
    session.run(10).unwrap();
    untouched.run(10).unwrap();
    home.fails_early.set(true);
    let exchange = |session: &mut Session, members: Vec<Member>| error(session.exchange(&home, members, wires()));
    assert_eq!(
        exchange(&mut session, vec![member("P", FOREIGN, &[])]),
        "P before the first step: the initialization returned an error: not today"
    );
    assert!(exchange(&mut session, vec![member("C", "LAG", &[])]).contains("two members are named C"));
    assert!(exchange(&mut session, vec![]).contains("P.POWER does not name an FMU of this run"));
    assert_eq!(session.run(50).unwrap().values, untouched.run(50).unwrap().values);
    assert!(session.record(None).unwrap().exchanges().is_empty());
    let state = session.exchange(&home, vec![], vec![]).unwrap();
    assert!(state.values.keys().all(|name| name.starts_with("C.")), "the controller goes on alone");
    assert_eq!(session.run(1).unwrap().calls, 61);
}

#[test]
fn a_controller_that_fails_itself_has_to_begin_again() {
    let home = TestHome::default();
    home.fails_at.set(1.0);
    let mut session = Session::default();
    let members = vec![member("F", FOREIGN, &[]), member("P", "LAG", &[])];
    session.start(&home, Setup { members, step: Some(0.5), ..Setup::default() }).unwrap();
    let state = session.run(9).unwrap();
    assert_eq!((state.failure.is_some(), state.calls), (true, 2));
    assert_eq!(error(session.exchange(&home, vec![], vec![])), "F itself has failed: start again");
    session.start(&home, setup("LAG")).unwrap();
    assert_eq!(session.run(9).unwrap().failure, None);
    assert_eq!(session.record(Some(0)).unwrap().failure(), Some("F: the step returned an error: it is enough"));
}

#[test]
fn a_million_calls_fit_into_the_memory_of_a_few() {
    let home = TestHome::default();
    let mut session = Session::default();
    session.start(&home, Setup { members: vec![member("C", "PID", &[("SP", 1.0)])], ..Setup::default() }).unwrap();
    let size = |session: &Session| session.record(None).unwrap().trace().capacity();
    session.run(MOST_CALLS).unwrap();
    session.run(MOST_CALLS).unwrap();
    let before = size(&session);
    for _ in 0..8 {
        session.run(MOST_CALLS).unwrap();
    }
    assert_eq!(session.record(None).unwrap().calls(), 1_000_000);
    let after = size(&session);
    // A chunk of constant values is smaller than one of others.
    assert!(after <= before, "{before} {after}");
}
