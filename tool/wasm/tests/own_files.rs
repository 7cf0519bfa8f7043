//! Recordings as the product itself writes them, and as a recorder with a faster clock does, through the replay.

#![allow(clippy::unwrap_used)]

use control::replay::{Change, Conclusion, Doubt, ReplayRequest, Replayed, Why, replay};
use run::fmus::Fmus;
use run::system::Value;
use std::fmt::Write;
use tool::home::Home;
use tool::message::{Member, Setup};
use tool::session::Session;
use tool_wasm::home::Linked;

type Values<'a> = &'a [(&'a str, f64)];

/// The loop with which all are replayed.
const FILE: Values = &[("GAIN", 1.4), ("TI", 20.0), ("CYCLE", 1.0), ("LMN_HLM", 90.0), ("MAN_ON", 0.0)];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// A row at the stop time that repeats the outputs, as of `plcfmu run`.
    EndRow,
    /// Four rows for each call.
    FasterClock,
    /// Each row has the output of the call before, as of a loop with parallel exchange.
    Parallel,
}

fn member(values: Values) -> Member {
    let value = |(name, value): &(&str, f64)| (name.to_string(), Value::Number(*value));
    Member { name: "TIC101".into(), fmu: "CONT_C".into(), values: values.iter().map(value).collect() }
}

fn replayed(values: Values, text: String) -> Replayed {
    let request =
        ReplayRequest { controller: member(values), text, columns: Vec::new(), tolerance: None, try_suspects: true };
    replay(&Linked::new(), &request).unwrap_or_else(|error| panic!("{error:#}"))
}

/// 160 calls in a loop with a lag, with two steps of the setpoint.
fn recording(faults: Values, kind: Kind, decimals: Option<usize>) -> String {
    changed(&[], (faults, 0), kind, decimals)
}

/// The same with other settings from a call on.
fn changed(own: Values, (faults, from): (Values, usize), kind: Kind, decimals: Option<usize>) -> String {
    let home = Linked::new();
    let description = home.description("CONT_C").unwrap();
    let find = |name: &str| {
        let variable = description.variable(name).unwrap();
        (variable.kind.unwrap(), variable.value_reference)
    };
    let mut block = home.instantiate("CONT_C", "PLC").unwrap();
    block.setup(0.0, None).unwrap();
    let at_first = if from == 0 { faults } else { &[] };
    for (name, value) in FILE.iter().chain(own).chain(at_first) {
        block.write(find(name).0, &[find(name).1], &[*value]).unwrap();
    }
    block.enter_initialization().unwrap();
    block.exit_initialization().unwrap();
    let cycle = faults.iter().find(|(name, _)| *name == "CYCLE").map_or(1, |(_, cycle)| *cycle as usize);
    let number = |value: f64| decimals.map_or_else(|| format!("{value}"), |digits| format!("{value:.digits$}"));
    let (mut text, mut pv, mut lmn) = (String::from("time,SP_INT,PV_IN,LMN\n"), 20.0f64, [0.0]);
    for call in 0..160 {
        let sp = [20.0, 60.0, 45.0][usize::from(call >= 10) + usize::from(call >= 90)];
        let pv_in: f64 = number(f64::from(pv as f32)).parse().unwrap();
        let before = lmn[0];
        if call % cycle == 0 {
            let by_hand = faults.iter().copied().filter(|_| call == from && from > 0);
            for (name, value) in [("SP_INT", sp), ("PV_IN", pv_in)].into_iter().chain(by_hand) {
                block.write(find(name).0, &[find(name).1], &[value]).unwrap();
            }
            block.step((call / cycle) as f64 * cycle as f64, cycle as f64).unwrap();
            block.read(find("LMN").0, &[find("LMN").1], &mut lmn).unwrap();
        }
        let shown = if kind == Kind::Parallel { before } else { lmn[0] };
        let rows = if kind == Kind::FasterClock { 4 } else { 1 };
        for row in 0..rows {
            let time = call as f64 + f64::from(row) * 0.25;
            let between = pv_in + 0.01 * f64::from(row);
            writeln!(text, "{time},{sp},{},{}", number(between), number(shown)).unwrap();
        }
        pv += (20.0 + 0.9 * lmn[0] - if call > 50 { 4.0 } else { 0.0 } - pv) / 30.0;
    }
    if kind == Kind::EndRow {
        writeln!(text, "160,45,{},{}", number(pv), number(lmn[0])).unwrap();
    }
    text
}

const FAULTS: [Values; 7] = [
    &[],
    &[("GAIN", 1.0)],
    &[("TI", 35.0)],
    &[("LMN_HLM", 45.0)],
    &[("DEADB_W", 0.5)],
    &[("GAIN", 0.7), ("TI", 50.0)],
    &[("LMN_LLM", 20.0)],
];

/// What is told of each: `=` equal, `+` the true change for sure, `l` the true change as the likeliest, `?` nothing. With `!`, another
/// change would be told.
/// One column for each of `FAULTS`; a low limit that is never left does what an offset does.
const VERDICTS: [(Kind, Option<usize>, &str); 6] = [
    (Kind::EndRow, None, "=l+++l?"),
    (Kind::EndRow, Some(3), "=l+++l?"),
    (Kind::FasterClock, None, "=l+++l?"),
    (Kind::FasterClock, Some(3), "=l+++l?"),
    (Kind::Parallel, None, "=l+++l?"),
    (Kind::Parallel, Some(3), "=l+++l?"),
];

fn verdict(faults: Values, kind: Kind, decimals: Option<usize>) -> (char, String) {
    let replayed = replayed(FILE, recording(faults, kind, decimals));
    let is_near = |found: &Value, value: f64| matches!(found, Value::Number(found) if *found as f32 == value as f32);
    let is_true = |suspect: &control::replay::Suspect| {
        suspect.values.len() == faults.len()
            && faults.iter().all(|(name, value)| suspect.values.get(*name).is_some_and(|found| is_near(found, *value)))
    };
    let verdict = match replayed.conclusion {
        Conclusion::Equal => '=',
        Conclusion::Cause if is_true(&replayed.suspects[0]) => '+',
        Conclusion::LikelyCause if is_true(&replayed.suspects[0]) => 'l',
        Conclusion::Cause | Conclusion::LikelyCause => '!',
        Conclusion::Ambiguous | Conclusion::Coarse | Conclusion::Rounded => '?',
        Conclusion::Unexplained | Conclusion::Differs => '?',
    };
    (verdict, format!("{:?}\n  {:?}", replayed.suspects, replayed.remarks))
}

fn assert_verdicts(wanted: Kind) {
    let mut wrong = String::new();
    for (kind, decimals, expected) in VERDICTS.into_iter().filter(|(kind, ..)| *kind == wanted) {
        for (faults, expected) in FAULTS.into_iter().zip(expected.chars()) {
            let (told, text) = verdict(faults, kind, decimals);
            if told != expected {
                writeln!(wrong, "{kind:?} {decimals:?} {faults:?}: {told} instead of {expected}: {text}").unwrap();
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn a_row_at_the_end_of_a_run_hides_no_cause() {
    assert_verdicts(Kind::EndRow);
}

#[test]
fn rows_between_calls_hide_no_cause() {
    assert_verdicts(Kind::FasterClock);
}

#[test]
fn outputs_one_call_late_hide_no_cause() {
    assert_verdicts(Kind::Parallel);
}

#[test]
fn outputs_one_call_late_are_no_missed_calls_where_they_are_rounded_and_the_process_value_is_late_too() {
    for decimals in 1..=3 {
        // The column has a name of neither the block's input nor its output, and the values of the output.
        let text = recording(&[], Kind::Parallel, Some(decimals));
        let mut rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        for row in (2..rows.len()).rev() {
            rows[row][2] = rows[row - 1][2];
        }
        (rows[0][2], rows[1][2]) = ("Istwert", "0");
        let text: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
        let replayed = replayed(FILE, text.join("\n"));
        assert_eq!(replayed.conclusion, Conclusion::Equal, "{decimals}: {:?}", replayed.suspects);
    }
}

#[test]
fn a_limit_that_is_only_touched_is_named_and_no_call_is_missed_instead() {
    // A manipulated value that swings to 60 % a few times, each time for a call.
    for decimals in [None, Some(2)] {
        let home = Linked::new();
        let description = home.description("CONT_C").unwrap();
        let find = |name: &str| {
            let variable = description.variable(name).unwrap();
            (variable.kind.unwrap(), variable.value_reference)
        };
        let mut block = home.instantiate("CONT_C", "PLC").unwrap();
        block.setup(0.0, None).unwrap();
        for (name, value) in FILE.iter().chain(&[("LMN_HLM", 60.0)]) {
            block.write(find(name).0, &[find(name).1], &[*value]).unwrap();
        }
        block.enter_initialization().unwrap();
        block.exit_initialization().unwrap();
        let (mut text, mut lmn) = (String::from("time,SP_INT,PV_IN,LMN\n"), [0.0]);
        for call in 0..120 {
            let pv = if call % 30 == 20 { 20.0 } else { 59.0 + 0.1 * f64::from(call % 7) };
            for (name, value) in [("SP_INT", 60.0), ("PV_IN", f64::from(pv as f32))] {
                block.write(find(name).0, &[find(name).1], &[value]).unwrap();
            }
            block.step(f64::from(call), 1.0).unwrap();
            block.read(find("LMN").0, &[find("LMN").1], &mut lmn).unwrap();
            let shown = decimals.map_or_else(|| format!("{}", lmn[0]), |digits: usize| format!("{:.digits$}", lmn[0]));
            writeln!(text, "{call},60,{pv:.1},{shown}").unwrap();
        }
        let replayed = replayed(FILE, text);
        let [(name, value)] = &replayed.suspects[0].values.iter().collect::<Vec<_>>()[..] else {
            panic!("{replayed:?}")
        };
        assert_eq!((name.as_str(), **value), ("LMN_HLM", Value::Number(60.0)), "{:?}", replayed.suspects);
        // Where digits are missing, an offset below the limit of the loop does the same.
        let told = if decimals.is_none() { Conclusion::Cause } else { Conclusion::Ambiguous };
        assert_eq!(replayed.conclusion, told, "{:?}", replayed.suspects);
        let is_missed = |change: &Change| matches!(change, Change::LeftOut { .. } | Change::Added { .. });
        let fitting = replayed.suspects.iter().filter(|suspect| suspect.fits);
        assert!(!fitting.flat_map(|suspect| &suspect.changes).any(is_missed), "{:?}", replayed.suspects);
    }
}

#[test]
fn at_least_six_of_seven_causes_are_named_and_none_wrong() {
    let all: String = VERDICTS.iter().map(|(.., told)| *told).collect();
    assert!(all.len() >= 40 && !all.contains('!'), "{all}");
    assert!(all.matches(['=', '+', 'l']).count() * 7 >= all.len() * 6, "{all}");
}

#[test]
fn the_example_of_the_plant_tells_the_tuned_values() {
    let text = include_str!("../../../examples/plant/recorded.csv").to_string();
    let file = [
        ("MAN_ON", 0.0),
        ("PVPER_ON", 1.0),
        ("PV_FAC", 4.0),
        ("CYCLE", 1.0),
        ("SP_INT", 60.0),
        ("GAIN", 1.4),
        ("TI", 80.0),
    ];
    let replayed = replayed(&file, text);
    let best = &replayed.suspects[0];
    let expected = [("GAIN".to_string(), Value::Number(f64::from(0.7f32))), ("TI".into(), Value::Number(130.0))];
    assert!(best.fits && best.values == expected.into(), "{replayed:?}");
    assert_eq!(replayed.calls, 900);
}

#[test]
fn a_longer_cycle_shows_in_the_rows_that_move() {
    let replayed = replayed(FILE, recording(&[("CYCLE", 2.0)], Kind::EndRow, None));
    let (value, before) = (Value::Number(2.0), Value::Number(1.0));
    let expected = Change::Setting { name: "CYCLE".into(), value, before, why: Some(Why::Rhythm(2)) };
    assert!(
        replayed.suspects.iter().any(|suspect| suspect.fits && suspect.changes == [expected.clone()]),
        "{replayed:?}"
    );
}

#[test]
fn a_loop_in_manual_mode_is_told_from_a_recording_in_manual_mode() {
    let text = "time,SP_INT,PV_IN,LMN\n0,20,20,0\n1,20,20,0\n2,20,20,0\n".to_string();
    let replayed = replayed(&[("MAN_ON", 1.0)], text);
    assert_eq!(replayed.doubt, Some(Doubt::ManualInLoop("MAN_ON".into())));
}

#[test]
fn a_controller_at_its_limit_is_not_taken_for_one_in_manual_mode() {
    let replayed = replayed(FILE, recording(&[("GAIN", -1.4)], Kind::EndRow, None));
    assert!(!replayed.suspects.iter().any(|suspect| suspect.is_sure), "{:?}", replayed.suspects);
    assert_eq!(replayed.doubt, None);
    let has_manual = |suspect: &control::replay::Suspect| suspect.values.contains_key("MAN_ON");
    assert!(!replayed.suspects.iter().any(has_manual), "{:?}", replayed.suspects);
}

#[test]
fn a_limit_that_rounded_values_touch_does_not_explain_a_gain_that_was_changed_by_hand() {
    let home = Linked::new();
    let title = "A furnace with a continuous controller and an analog word";
    let setup = home.known_loops().into_iter().find(|of| of.title == title).unwrap().setup;
    let mut session = Session::default();
    session.start(&home, setup.clone()).unwrap();
    session.run(300).unwrap();
    session.send(&[("CONT_C.GAIN".to_string(), Value::Number(1.2))].into_iter().collect()).unwrap();
    session.run(300).unwrap();
    let record = session.record(None).unwrap();
    let mut text = String::from("time,SP_INT,PV,LMN\n");
    let columns = ["SP_INT", "PV", "LMN"].map(|name| record.column(&format!("CONT_C.{name}")).unwrap());
    for call in 0..600 {
        let row = columns.map(|column| format!("{:.2}", record.trace().get(column, call)));
        writeln!(text, "{call},{}", row.join(",")).unwrap();
    }
    let controller = setup.members.into_iter().next().unwrap();
    let request = ReplayRequest { controller, text, columns: Vec::new(), tolerance: None, try_suspects: true };
    let replayed = replay(&home, &request).unwrap();
    let found = replayed.suspects.iter().find(|suspect| suspect.fits).unwrap();
    let values: Vec<(&str, Value)> = found.values.iter().map(|(name, value)| (name.as_str(), *value)).collect();
    assert_eq!(values, [("GAIN", Value::Number(f64::from(1.2_f32)))], "{:?}", replayed.suspects);
    // A row has the output of the call before.
    let since = found.since.as_ref().unwrap();
    assert!((300..=301).contains(&since.at.0), "{since:?}");
}

/// The call from which on a setting has another value, 20 calls before a step of the setpoint.
const BY_HAND: usize = 70;

/// What is changed by hand, and what the loop has besides.
const CHANGES: [(Values, Values); 6] = [
    (&[], &[("GAIN", 1.0)]),
    (&[], &[("TI", 35.0)]),
    (&[], &[("LMN_HLM", 45.0)]),
    (&[], &[("DISV", 5.0)]),
    (&[], &[("LMN_OFF", 5.0)]),
    (&[("D_SEL", 1.0), ("TD", 4.0), ("TM_LAG", 2.0)], &[("TD", 8.0)]),
];

/// What is told of each of `CHANGES`: `+` the true change for sure, `l` as the likeliest, `?` as one of those that cannot be told apart,
/// `-` nothing. With `!`, another change would be told, or a range without the true value or time.
const TOLD: [(Kind, Option<usize>, &str); 4] = [
    (Kind::EndRow, Some(2), "+++??+"),
    (Kind::Parallel, None, "+++??+"),
    (Kind::Parallel, Some(2), "+++??+"),
    (Kind::Parallel, Some(1), "+++??l"),
];

#[test]
fn a_setting_changed_by_hand_is_told_with_ranges_that_have_its_value_and_its_time() {
    let mut wrong = String::new();
    for (kind, decimals, expected) in TOLD {
        let mut told = String::new();
        let mut all = String::new();
        for (own, change) in CHANGES {
            let [(name, value)] = change else { panic!("one") };
            let file: Vec<_> = FILE.iter().chain(own).copied().collect();
            let text = changed(own, (change, BY_HAND), kind, decimals);
            let is_true = |suspect: &control::replay::Suspect| {
                let Some(since) = &suspect.since else { return false };
                let Change::Setting { name: told, value: Value::Number(found), .. } = &since.change else {
                    return false;
                };
                let (low, high) = suspect.range.unwrap_or((*found, *found));
                let has_value = (low - 1e-6..=high + 1e-6).contains(value);
                let has_time = (since.earliest.0..=since.latest.0).contains(&BY_HAND);
                told == name && has_value && has_time
            };
            let first = replayed(&file, text.clone());
            let fitting: Vec<_> = first.suspects.iter().filter(|suspect| suspect.fits).collect();
            told.push(match first.conclusion {
                Conclusion::Cause if is_true(fitting[0]) => '+',
                Conclusion::LikelyCause if is_true(fitting[0]) => 'l',
                Conclusion::Ambiguous if fitting.iter().any(|suspect| is_true(suspect)) => '?',
                Conclusion::Unexplained | Conclusion::Equal => '-',
                _ => '!',
            });
            writeln!(all, "  {change:?}: {:?} {fitting:#?}", first.conclusion).unwrap();
            // With the later value in force, the recording tells the same of it.
            if kind == Kind::Parallel && decimals == Some(2) && ["GAIN", "TI"].contains(name) {
                let file: Vec<_> = file.iter().chain(change).copied().collect();
                let applied = replayed(&file, text);
                let says_same = applied.conclusion == Conclusion::Cause && is_true(&applied.suspects[0]);
                assert!(says_same && applied.suspects[0].values.is_empty(), "{change:?}: {applied:#?}");
            }
        }
        if told != expected {
            writeln!(wrong, "{kind:?} {decimals:?}: {told} instead of {expected}\n{all}").unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// The loop of the file with other settings.
fn wrong<'a>(others: Values<'a>) -> Vec<(&'a str, f64)> {
    FILE.iter().chain(others).copied().collect()
}

/// The first explanation of the recording of the file's loop, replayed with other settings: whether it is the only one, its values, and the
/// range of the last one.
fn explanation(others: Values, decimals: Option<usize>) -> (Conclusion, tool::message::Values, Option<(f64, f64)>) {
    let replayed = replayed(&wrong(others), recording(&[], Kind::EndRow, decimals));
    let first = replayed.suspects.into_iter().next().filter(|first| first.fits).expect("it is explained");
    assert!(first.since.is_none(), "nothing was changed by hand: {first:?}");
    (replayed.conclusion, first.values, first.range)
}

#[test]
fn switches_of_the_integral_action_are_named() {
    for decimals in [None, Some(3)] {
        for name in ["INT_HOLD", "I_ITL_ON"] {
            let (conclusion, values, _) = explanation(&[(name, 1.0), ("I_ITLVAL", 10.0)], decimals);
            assert_eq!((conclusion, values), (Conclusion::Cause, [(name.to_string(), Value::Boolean(false))].into()));
        }
    }
}

#[test]
fn a_limit_that_the_recording_never_reaches_has_any_value_beyond_it() {
    for decimals in [None, Some(3)] {
        let (conclusion, values, range) = explanation(&[("LMN_HLM", 50.0)], decimals);
        // The start value is as good as the 90 of the loop: nothing tells more than that it is above what was recorded.
        assert_eq!((conclusion, values), (Conclusion::Cause, [("LMN_HLM".to_string(), Value::Number(100.0))].into()));
        let (low, high) = range.unwrap();
        assert!(low > 58.0 && low < 60.0 && high == f64::MAX, "{low} {high}");
        let (conclusion, values, _) = explanation(&[("LMN_HLM", 50.0), ("TI", 12.0)], decimals);
        let both = [("LMN_HLM".to_string(), Value::Number(100.0)), ("TI".to_string(), Value::Number(20.0))];
        assert_eq!((conclusion, values), (Conclusion::Cause, both.into()));
    }
}

#[test]
fn a_value_with_few_digits_is_likelier_than_one_with_many() {
    // GAIN 1.4 / 1.1 explains it as well.
    let (conclusion, values, _) = explanation(&[("LMN_FAC", 1.1)], None);
    assert_eq!((conclusion, values), (Conclusion::Ambiguous, [("LMN_FAC".to_string(), Value::Number(1.0))].into()));
}

#[test]
fn a_limit_changed_by_hand_is_not_taken_for_manual_mode() {
    let by_hand = |decimals| replayed(FILE, changed(&[], (&[("LMN_HLM", 50.0)], 60), Kind::EndRow, decimals));
    for (decimals, conclusion) in [(None, Conclusion::Cause), (Some(3), Conclusion::Ambiguous)] {
        let replayed = by_hand(decimals);
        assert_eq!(replayed.conclusion, conclusion);
        let since = replayed.suspects[0].since.as_ref().unwrap();
        assert_eq!(since.at, (60, 60.0));
        assert!(matches!(&since.change, Change::Setting { name, value: Value::Number(50.0), .. } if name == "LMN_HLM"));
    }
    // With 3 decimals, manual mode would do.
    assert!(by_hand(Some(3)).remarks.iter().any(|remark| remark.contains("is constant")));
}

/// A loop with a dead time of 1 s that has settled when a disturbance of 6 comes at 180 s: the manipulated value jumps, and stands still for
/// ten rows until the process value answers.
fn disturbed(decimals: usize) -> String {
    let values =
        |values: Values| values.iter().map(|(name, value)| (name.to_string(), Value::Number(*value))).collect();
    let controller = [("MAN_ON", 0.0), ("SP_INT", 20.0), ("GAIN", 4.76), ("TI", 8.4), ("CYCLE", 0.1)];
    let member = |name: &str, fmu: &str, given| Member { name: name.into(), fmu: fmu.into(), values: values(given) };
    let connections = [("C.LMN", "P.U"), ("P.PV", "C.PV_IN")].map(|(from, to)| (from.into(), to.into())).into();
    let members = vec![member("C", "CONT_C", &controller), member("P", "PROCESS", &[("CYCLE", 0.1)])];
    let mut session = Session::default();
    session.start(&Linked::new(), Setup { members, connections, ..Setup::default() }).unwrap();
    for (calls, name, value) in [(1200, "C.SP_INT", 50.0), (600, "C.DISV", 6.0), (300, "C.SP_INT", 80.0)] {
        session.run(calls).unwrap();
        session.send(&values(&[(name, value)])).unwrap();
    }
    session.run(300).unwrap();
    let record = session.record(None).unwrap();
    let columns = ["C.SP_INT", "C.PV", "C.LMN"].map(|name| record.column(name).unwrap());
    let mut text = String::from("time,SP_INT,PV_IN,LMN\n");
    for call in 0..record.calls() {
        let [sp, pv, lmn] = columns.map(|column| record.trace().get(column, call));
        writeln!(text, "{:.1},{sp:.decimals$},{pv:.decimals$},{lmn:.decimals$}", record.time(call)).unwrap();
    }
    text
}

#[test]
fn a_step_of_a_manipulated_value_that_stands_still_is_a_change_by_hand() {
    let loop_values = [("MAN_ON", 0.0), ("GAIN", 4.76), ("TI", 8.4), ("CYCLE", 0.1)];
    let replayed = replayed(&loop_values, disturbed(3));
    assert_eq!(replayed.conclusion, Conclusion::Cause, "{:?}", replayed.remarks);
    let since = replayed.suspects[0].since.as_ref().unwrap();
    assert_eq!(since.at, (1800, 180.0));
    assert!(matches!(&since.change, Change::Setting { name, value: Value::Number(6.0), .. } if name == "DISV"));
}

#[test]
fn a_curve_that_bends_is_no_noise() {
    let replayed =
        replayed(&wrong(&[("GAIN", 2.0), ("TI", 50.0), ("DEADB_W", 0.5)]), recording(&[], Kind::EndRow, None));
    assert!(
        replayed.outputs.iter().all(|of| of.first.is_none() || of.noise <= of.allowed),
        "{:?}",
        replayed.outputs[0].noise
    );
}

#[test]
fn a_value_as_good_as_0_is_0() {
    for decimals in [None, Some(3)] {
        let (_, values, _) = explanation(&[("LMN_OFF", 3.0)], decimals);
        assert_eq!(values, [("LMN_OFF".to_string(), Value::Number(0.0))].into());
    }
}
