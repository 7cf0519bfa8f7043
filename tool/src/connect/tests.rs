use super::*;
use crate::message::Setup;
use crate::test_home::{FOREIGN, TestHome};
use run::system::Exchange;

fn member(name: &str, fmu: &str) -> Member {
    Member { name: name.into(), fmu: fmu.into(), values: Values::new() }
}

fn shown(proposal: &Proposal) -> Vec<String> {
    proposal.connections.iter().map(|wire| format!("{} -> {}: {}", wire.from, wire.to, wire.reason)).collect()
}

/// What is open, as sentences.
fn texts(proposal: &Proposal) -> Vec<&str> {
    proposal.open.iter().map(|open| open.text.as_str()).collect()
}

#[test]
fn ends_of_the_same_role_are_connected_and_pulses_drive_a_plant_that_takes_them() {
    let proposal = propose(&TestHome::default(), &member("C", "PID"), &member("P", "LAG")).unwrap();
    let expected = [
        "C.UP -> P.HEAT: both are pulses of the manipulated value",
        "C.DOWN -> P.COOL: both are pulses of the manipulated value",
        "P.TEMP -> C.PV_IN: both are the process value, both in °C",
        "P.AT_TOP -> C.STOP_HIGH: both are the high stop",
    ];
    assert_eq!(shown(&proposal), expected);
    assert_eq!(proposal.values, Values::from([("P.CYCLE".into(), Value::Number(0.5))]));
    assert_eq!((texts(&proposal), &proposal.remarks), (Vec::<&str>::new(), &Vec::<String>::new()));
    let other = proposal.others.iter().find(|wire| wire.from == "C.OUT" && wire.to == "P.POWER").unwrap();
    assert_eq!(other.reason, "same unit, %");
    assert!(proposal.others.iter().all(|wire| !proposal.connections.iter().any(|own| own == wire)));
    assert!(!proposal.others.iter().any(|wire| wire.from == "C.OUT" && wire.to == "P.HEAT"), "types differ");
    assert!(!proposal.others.iter().any(|wire| wire.from == "P.TEMP" && wire.to == "C.MAN"), "units differ");
}

#[test]
fn of_a_foreign_fmu_only_names_and_units_are_known() {
    let proposal = propose(&TestHome::default(), &member("C", "PID"), &member("P", FOREIGN)).unwrap();
    // OUT could go to POWER and to LOAD, TEMP to SP and to PV_IN: nothing is clear.
    assert_eq!(shown(&proposal), Vec::<String>::new());
    assert_eq!(texts(&proposal), ["nothing is connected to C.PV_IN", "nothing is connected to C.STOP_HIGH"]);
    assert_eq!(proposal.open[0].input, "C.PV_IN");
    assert!(proposal.others.iter().any(|wire| wire.from == "C.OUT" && wire.to == "P.LOAD"));
    assert!(proposal.values.is_empty(), "a foreign FMU has no cycle");
}

#[test]
fn a_known_loop_is_taken_with_the_settings_of_its_plant() {
    let mut home = TestHome::default();
    let mut plant = member("LAG", "LAG");
    plant.values = Values::from([("K".into(), Value::Number(2.5)), ("CYCLE".into(), Value::Number(7.0))]);
    let connections = [("PID.OUT", "LAG.POWER"), ("LAG.TEMP", "PID.PV_IN")];
    let setup = Setup {
        members: vec![member("PID", "PID"), plant],
        connections: connections.map(|(from, to)| (from.into(), to.into())).into(),
        step: Some(0.5),
        exchange: Exchange::Parallel,
    };
    home.loops.push(KnownLoop { title: "A lag".into(), setup: setup.clone(), ..KnownLoop::default() });
    let proposal = propose(&home, &member("C", "PID"), &member("P", "LAG")).unwrap();
    let expected =
        ["C.OUT -> P.POWER: as in the known loop \"A lag\"", "P.TEMP -> C.PV_IN: as in the known loop \"A lag\""];
    assert_eq!(shown(&proposal), expected);
    assert_eq!(proposal.exchange, Exchange::Parallel);
    assert_eq!(proposal.step, None, "0.5 s is the controller's cycle");
    assert_eq!(proposal.values["P.K"], Value::Number(2.5));
    assert_eq!(proposal.values["P.CYCLE"], Value::Number(0.5), "the cycle is the controller's");
    assert_eq!(texts(&proposal), ["nothing is connected to C.STOP_HIGH"]);

    // Of two known loops, the one with a call in each step is taken; the other has a step of its own.
    home.loops.insert(
        0,
        KnownLoop { title: "Means".into(), setup: Setup { step: Some(5.0), ..setup }, ..KnownLoop::default() },
    );
    let reason = |home: &TestHome| {
        let proposal = propose(home, &member("C", "PID"), &member("P", "LAG")).unwrap();
        (proposal.connections[0].reason.clone(), proposal.step)
    };
    assert_eq!(reason(&home), ("as in the known loop \"A lag\"".into(), None));
    home.loops.pop();
    assert_eq!(reason(&home), ("as in the known loop \"Means\"".into(), Some(5.0)));
}

#[test]
fn a_known_loop_whose_inputs_have_no_effect_is_not_taken() {
    let mut home = TestHome::default();
    let connections = [("P.TEMP", "C.SP"), ("P.TEMP", "C.MAN")];
    let setup = Setup {
        members: vec![member("P", "LAG"), member("C", "PID")],
        connections: connections.map(|(from, to)| (from.into(), to.into())).into(),
        ..Setup::default()
    };
    home.loops.push(KnownLoop { title: "Manual".into(), setup, ..KnownLoop::default() });
    let mut controller = member("C", "PID");
    let is_known = |controller: &Member| {
        let proposal = propose(&home, controller, &member("P", "LAG")).unwrap();
        proposal.connections[0].reason.starts_with("as in")
    };
    assert!(!is_known(&controller), "MAN is not used");
    controller.values.insert("MAN_ON".into(), Value::Boolean(true));
    assert!(is_known(&controller));
}

#[test]
fn two_members_of_one_name_are_refused_and_an_unknown_fmu_is_named() {
    let home = TestHome::default();
    let error = |a: &Member, b: &Member| format!("{:#}", propose(&home, a, b).unwrap_err());
    assert_eq!(error(&member("C", "PID"), &member("C", "LAG")), "two members are named C: rename one");
    assert_eq!(error(&member("C", "PID"), &member("P", "<b>")), "no FMU \"<b>\" here");
}

#[test]
fn nothing_goes_to_an_input_without_effect_or_to_one_that_has_a_source() {
    let home = TestHome::default();
    let mut controller = member("C", "PID");
    let wires = |controller: &Member| {
        let (end, mut draft) = (End::new(&home, controller).unwrap(), Draft::default());
        for output in ["OUT", "OUT"] {
            connect(&end, output, &end, "MAN", "it is tried", &mut draft);
        }
        shown(&draft.proposal)
    };
    assert_eq!(wires(&controller), Vec::<String>::new());
    controller.values.insert("MAN_ON".into(), Value::Boolean(true));
    assert_eq!(wires(&controller), ["C.OUT -> C.MAN: it is tried, both in %"]);
}

#[test]
fn ends_that_belong_together_and_do_not_fit_are_told() {
    let home = TestHome::default();
    let (controller, plant) = (member("C", "PID"), member("P", "LAG"));
    let (controller, plant) = (End::new(&home, &controller).unwrap(), End::new(&home, &plant).unwrap());
    let mut draft = Draft::default();
    connect(&controller, "PV", &plant, "POWER", "both are asked for", &mut draft);
    remarks(&home, &controller, &plant, &mut draft);
    let expected =
        "C.PV (°C) cannot be connected to P.POWER (%), although both are asked for: values are not converted";
    assert!(texts(&draft).contains(&expected), "{:?}", draft.open);
}

#[test]
fn pulses_that_move_an_actuator_are_not_connected_with_pulses_that_act_while_they_are_on() {
    let home = TestHome::default();
    let (controller, plant) = (member("C", "PID"), member("P", "LAG"));
    let (controller, mut plant) = (End::new(&home, &controller).unwrap(), End::new(&home, &plant).unwrap());
    plant.description.roles.signals.clear();
    let mut proposal = draft(&home, &controller, &plant);
    remarks(&home, &controller, &plant, &mut proposal);
    assert_eq!(shown(&proposal), ["P.TEMP -> C.PV_IN: both are the process value, both in °C"]);
    let expected = [
        "UP and DOWN of C move an actuator between its stops, but HEAT and COOL of P act only while they are on: these pulses are \
         not compatible, so they are not connected",
        "nothing is connected to C.STOP_HIGH",
        "nothing is connected to P.POWER",
    ];
    assert_eq!(texts(&proposal), expected);
    assert_eq!(proposal.remarks, ["PID can drive these plants: LAG"]);
}
