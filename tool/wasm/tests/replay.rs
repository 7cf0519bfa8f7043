//! Recordings through the blocks that are linked in.

#![allow(clippy::unwrap_used)]

use control::replay::{Change, Conclusion, ReplayRequest, Replayed, Why, replay};
use run::component::{Component, Type};
use run::fmus::{Fmus, number_of};
use run::system::Value;
use std::fmt::Write;
use std::path::Path;
use tool::message::Member;
use tool_wasm::home::Linked;

fn member(fmu: &str, values: &[(&str, f64)]) -> Member {
    let value = |(name, value): &(&str, f64)| (name.to_string(), Value::Number(*value));
    Member { name: "TIC101".into(), fmu: fmu.into(), values: values.iter().map(value).collect() }
}

fn request(controller: Member, text: String) -> ReplayRequest {
    ReplayRequest { controller, text, columns: Vec::new(), tolerance: None, try_suspects: true }
}

fn run(request: &ReplayRequest) -> Replayed {
    replay(&Linked::new(), request).unwrap_or_else(|error| panic!("{error:#}"))
}

/// A block that runs a lag in closed loop, and what a recorder on the plant writes.
struct Plant<'a> {
    fmu: &'a str,
    values: &'a [(&'a str, f64)],
    calls: usize,
    /// Calls that the recorder writes no row for.
    unwritten: &'a [usize],
    /// Rows in which the block is not called.
    uncalled: &'a [usize],
    /// The call of the first row.
    from: usize,
    decimals: usize,
}

impl Default for Plant<'_> {
    fn default() -> Self {
        Plant { fmu: "CONT_C", values: &[], calls: 400, unwritten: &[], uncalled: &[], from: 0, decimals: 3 }
    }
}

impl Plant<'_> {
    /// `time;SP;PV;LMN;MAN_ON;MAN` of a run with two steps of the setpoint and a while in manual.
    fn record(&self) -> String {
        let home = Linked::new();
        let description = home.description(self.fmu).unwrap();
        let find = |name: &str| {
            let variable = description.variable(name).unwrap_or_else(|| panic!("{name}"));
            let kind = match variable.kind {
                Some(Type::Real) => Type::Real,
                Some(Type::Boolean) => Type::Boolean,
                _ => Type::Integer,
            };
            (kind, variable.value_reference)
        };
        let mut block = home.instantiate(self.fmu, "PLC").unwrap();
        let set = |block: &mut dyn Component, name: &str, value: f64| {
            let (kind, reference) = find(name);
            block.write(kind, &[reference], &[value]).unwrap();
        };
        block.setup(0.0, None).unwrap();
        for (name, value) in self.values {
            set(&mut *block, name, *value);
        }
        block.enter_initialization().unwrap();
        block.exit_initialization().unwrap();
        let mut cycle = [0.0];
        block.read(Type::Real, &[find("CYCLE").1], &mut cycle).unwrap();
        let is_word = self.values.contains(&("PVPER_ON", 1.0));
        let (mut text, mut pv, mut lmn, mut made) = (String::from("time;SP;PV;LMN;MAN_ON;MAN\n"), 20.0f64, 0.0, 0);
        for call in 0..self.calls {
            let sp = if call < 30 {
                20.0
            } else if call < 220 {
                60.0
            } else {
                45.0
            };
            let (manual, man) = ((320..340).contains(&call), 30.0);
            let pv_in = if is_word { (pv * 276.48).round() / 276.48 } else { (pv * 1000.0).round() / 1000.0 };
            if !self.uncalled.contains(&call) {
                set(&mut *block, "SP_INT", sp);
                set(&mut *block, "PV_IN", pv_in);
                if is_word {
                    set(&mut *block, "PV_PER", (pv * 276.48).round());
                }
                set(&mut *block, "MAN_ON", f64::from(u8::from(manual)));
                set(&mut *block, "MAN", man);
                block.step(made as f64 * cycle[0], cycle[0]).unwrap();
                made += 1;
                let mut now = [0.0];
                block.read(Type::Real, &[find("LMN").1], &mut now).unwrap();
                lmn = now[0];
            }
            if call >= self.from && !self.unwritten.contains(&call) {
                let d = self.decimals;
                let time = call as f64 * cycle[0];
                writeln!(text, "{time:.3};{sp:.1};{pv_in:.d$};{lmn:.d$};{};{man:.1}", u8::from(manual)).unwrap();
            }
            // A lag of 40 calls with gain 0.9, an ambient temperature of 20, and an oven door.
            let door = if call > 120 { -4.0 } else { 0.0 };
            pv += (20.0 + 0.9 * lmn + door - pv) / 40.0;
        }
        text
    }
}

/// The settings of the file with which all recordings are replayed.
const FILE: [(&str, f64); 4] = [("GAIN", 2.0), ("TI", 20.0), ("CYCLE", 1.0), ("LMN_HLM", 90.0)];

/// Settings of the file with others.
fn with<'a>(others: &[(&'a str, f64)]) -> Vec<(&'a str, f64)> {
    let kept = FILE.into_iter().filter(|(name, _)| others.iter().all(|(other, _)| other != name));
    kept.chain(others.iter().copied()).collect()
}

/// What a recording of a plant with these settings says, replayed with those of the file.
fn with_fault(faults: &[(&str, f64)]) -> Replayed {
    let values = with(faults);
    run(&request(member("CONT_C", &FILE), Plant { values: &values, ..Plant::default() }.record()))
}

/// What the first suspect changes; it has to fit.
fn named(replayed: &Replayed) -> &[Change] {
    let first = replayed.suspects.first().unwrap_or_else(|| panic!("{replayed:?}"));
    assert!(first.fits, "{replayed:#?}");
    let conclusions = [Conclusion::Cause, Conclusion::LikelyCause, Conclusion::Ambiguous];
    assert!(conclusions.contains(&replayed.conclusion), "{:?}", replayed.conclusion);
    &first.changes
}

/// Whether a setting has this value instead of that one, as REALs.
fn is_setting(change: &Change, of: &str, is: f64, instead_of: f64) -> bool {
    let is_same = |value: &Value, number: f64| number_of(*value) as f32 == number as f32;
    matches!(change, Change::Setting { name, value, before, .. }
        if name == of && is_same(value, is) && is_same(before, instead_of))
}

/// The first suspect is this setting.
fn assert_named(replayed: &Replayed, name: &str, value: f64, before: f64) {
    assert!(is_setting(&named(replayed)[0], name, value, before), "{:?}", replayed.suspects);
}

/// Whether all outputs are equal, bit for bit.
fn is_exact(replayed: &Replayed) -> bool {
    replayed.conclusion == Conclusion::Equal && replayed.outputs.iter().all(|of| of.largest == 0.0)
}

#[test]
fn the_measured_recordings_are_equal_from_the_first_call_on_bit_for_bit() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/traces");
    let mut count = 0;
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.extension().is_none_or(|extension| extension != "csv") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let rows = text.lines().filter(|line| !line.starts_with('#')).count() - 1;
        let replayed = run(&request(member(&name[..6], &[]), text));
        assert!(is_exact(&replayed), "{name}: {replayed:?}");
        assert_eq!(replayed.calls, rows, "{name}");
        assert!(replayed.outputs.len() >= 3 && replayed.outputs.iter().all(|of| of.first.is_none()), "{name}");
        count += 1;
    }
    assert!(count > 20);
}

#[test]
fn a_single_wrong_digit_of_a_measured_recording_is_found() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/traces/CONT_C_02_derivative.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    let header: Vec<_> = lines.iter().find(|line| line.starts_with("call")).unwrap().split(',').collect();
    let column = header.iter().position(|name| *name == "out_LMN").unwrap();
    let row = 6;
    let at = lines.iter().position(|line| line.starts_with(&format!("{row},"))).unwrap();
    let mut cells: Vec<String> = lines[at].split(',').map(str::to_string).collect();
    cells[column] = format!("{}", cells[column].parse::<f64>().unwrap() + 0.001);
    lines[at] = cells.join(",");
    let replayed = run(&request(member("CONT_C", &[]), lines.join("\n")));
    let lmn = replayed.outputs.iter().find(|of| of.variable == "LMN").unwrap();
    assert_eq!((lmn.first.map(|first| first.0), lmn.different), (Some(row), 1));
}

#[test]
fn a_rounded_recording_with_the_right_settings_is_equal() {
    for decimals in [1, 2, 3, 5] {
        let text = Plant { values: &FILE, decimals, ..Plant::default() }.record();
        let replayed = run(&request(member("CONT_C", &FILE), text));
        assert_eq!(replayed.conclusion, Conclusion::Equal, "{decimals}: {replayed:?}");
        assert!(replayed.suspects.is_empty());
    }
}

#[test]
fn a_recording_that_begins_in_the_middle_is_taken_up_bumplessly() {
    for from in [100, 230] {
        let text = Plant { values: &FILE, from, ..Plant::default() }.record();
        let replayed = run(&request(member("CONT_C", &FILE), text));
        assert_eq!(replayed.conclusion, Conclusion::Equal, "{from}: {replayed:?}");
        let says = |words: &str| replayed.remarks.iter().any(|remark| remark.contains(words));
        assert!(says("starts in manual mode at the recorded LMN"), "{from}: {:?}", replayed.remarks);
    }
}

/// The first columns of a recording.
fn columns(text: &str, count: usize) -> String {
    let first = |line: &str| line.split(';').take(count).collect::<Vec<_>>().join(";");
    text.lines().map(first).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_time_in_manual_mode_shows_in_a_manipulated_value_that_stands_still() {
    // From call 320 on it is 30 for 20 calls; the columns that say so are left out.
    for (decimals, plant) in [(3, FILE.to_vec()), (6, FILE.to_vec()), (3, with(&[("TI", 50.0)]))] {
        let text = columns(&Plant { values: &plant, decimals, ..Plant::default() }.record(), 4);
        let replayed = run(&request(member("CONT_C", &with(&[("MAN_ON", 0.0)])), text));
        let said = "LMN is constant from 320 s to 339 s: the controller is assumed to be in manual mode there.";
        assert!(replayed.remarks.iter().any(|remark| remark == said), "{:?}", replayed.remarks);
        match plant.contains(&("TI", 50.0)) {
            false => assert_eq!(replayed.conclusion, Conclusion::Equal, "{:?}", replayed.suspects),
            true => assert_named(&replayed, "TI", 50.0, 20.0),
        }
    }
}

#[test]
fn the_noise_of_a_recording_tells_the_tolerance_that_it_needs() {
    let text = columns(&Plant { values: &FILE, ..Plant::default() }.record(), 4);
    // A recorder with noise of its own, evenly within 0.06 to both sides: its standard deviation is 0.035.
    let mut bits = 1_u32;
    let noisy = |line: &str| {
        let mut cells: Vec<String> = line.split(';').map(str::to_string).collect();
        bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let off = 0.12 * (f64::from(bits >> 8) / f64::from(1 << 24) - 0.5);
        cells[2] = cells[2].parse::<f64>().map_or(cells[2].clone(), |value| format!("{:.3}", value + off));
        cells.join(";")
    };
    let text = text.lines().map(noisy).collect::<Vec<_>>().join("\n");
    let automatic = with(&[("MAN_ON", 0.0)]);
    let replayed = run(&request(member("CONT_C", &automatic), text.clone()));
    let noise = replayed.outputs[0].noise;
    // GAIN is 2.
    assert!((0.06..0.09).contains(&noise) && replayed.conclusion == Conclusion::Unexplained, "{noise}");
    let with_tolerance = ReplayRequest { tolerance: Some(6.0 * noise), ..request(member("CONT_C", &automatic), text) };
    assert_eq!(run(&with_tolerance).conclusion, Conclusion::Equal);
}

#[test]
fn another_cycle_is_named() {
    for cycle in [0.5, 2.0, 10.0, 0.3] {
        assert_named(&with_fault(&[("CYCLE", cycle)]), "CYCLE", cycle, 1.0);
    }
}

#[test]
fn settings_are_told_with_the_cycle_of_the_recording_not_with_one_that_a_false_ti_makes_up_for() {
    // With CYCLE 1 s a TI of 24 s integrates in each call what 12 s does with CYCLE 0.5 s.
    let others = [("CYCLE", 0.5), ("GAIN", 1.2), ("TI", 12.0)];
    let replayed = with_fault(&others);
    let [cycle, settings @ ..] = named(&replayed) else { panic!("{replayed:?}") };
    assert!(is_setting(cycle, "CYCLE", 0.5, 1.0), "{replayed:#?}");
    for (name, is, before) in [("GAIN", 1.2, 2.0), ("TI", 12.0, 20.0)] {
        assert!(settings.iter().any(|change| is_setting(change, name, is, before)), "{name}: {replayed:#?}");
    }
    // With all of it applied, nothing differs.
    let text = Plant { values: &with(&others), ..Plant::default() }.record();
    assert_eq!(run(&request(member("CONT_C", &with(&others)), text)).conclusion, Conclusion::Equal);
}

#[test]
fn another_sign_of_the_gain_is_named() {
    assert_named(&with_fault(&[("GAIN", -2.0)]), "GAIN", -2.0, 2.0);
}

#[test]
fn other_limits_are_named() {
    assert_named(&with_fault(&[("LMN_HLM", 70.0)]), "LMN_HLM", 70.0, 90.0);
    assert_named(&with_fault(&[("LMN_LLM", 10.0)]), "LMN_LLM", 10.0, 0.0);
}

#[test]
fn the_word_of_the_periphery_is_named() {
    // Both terminals are in the recording, and the block reads the other one.
    let values = with(&[("PVPER_ON", 1.0), ("PV_FAC", 1.1)]);
    let text = Plant { values: &values, ..Plant::default() }.record();
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    lines[0] = "time;SP;PV_IN;LMN;MAN_ON;MAN;PV_PER".into();
    for line in &mut lines[1..] {
        let pv: f64 = line.split(';').nth(2).unwrap().parse().unwrap();
        line.push_str(&format!(";{}", (pv * 276.48).round()));
    }
    let file = with(&[("PV_FAC", 1.1)]);
    let replayed = run(&request(member("CONT_C", &file), lines.join("\n")));
    assert_named(&replayed, "PVPER_ON", 1.0, 0.0);
}

#[test]
fn another_structure_is_named() {
    assert_named(&with_fault(&[("I_SEL", 0.0)]), "I_SEL", 0.0, 1.0);
    assert!(!named(&with_fault(&[("D_SEL", 1.0), ("TD", 10.0)])).is_empty());
}

#[test]
fn minutes_taken_for_seconds_are_named() {
    let replayed = with_fault(&[("TI", 1200.0)]);
    assert_named(&replayed, "TI", 1200.0, 20.0);
    assert!(matches!(named(&replayed)[0], Change::Setting { why: Some(Why::Minutes), .. }), "{:?}", replayed.suspects);
}

#[test]
fn a_dead_band_is_named() {
    assert_named(&with_fault(&[("DEADB_W", 0.5)]), "DEADB_W", 0.5, 0.0);
    let file = with(&[("DEADB_W", 0.5)]);
    let text = Plant { values: &FILE, ..Plant::default() }.record();
    assert_named(&run(&request(member("CONT_C", &file), text)), "DEADB_W", 0.0, 0.5);
}

#[test]
fn a_missed_call_and_a_missing_row_are_named() {
    let text = Plant { values: &FILE, uncalled: &[57], ..Plant::default() }.record();
    let replayed = run(&request(member("CONT_C", &FILE), text));
    assert_eq!(named(&replayed), [Change::LeftOut { line: 59, time: 57.0 }]);
    let text = Plant { values: &FILE, unwritten: &[57], ..Plant::default() }.record();
    let replayed = run(&request(member("CONT_C", &FILE), text));
    assert!(matches!(named(&replayed), [Change::Added { line: 59, .. }]), "{:?}", replayed.suspects);
}

#[test]
fn two_faults_at_once_are_named() {
    let replayed = with_fault(&[("GAIN", -2.0), ("LMN_LLM", -50.0)]);
    let changes = named(&replayed);
    let has =
        |name: &str, value: f64, before: f64| changes.iter().any(|change| is_setting(change, name, value, before));
    assert!(has("GAIN", -2.0, 2.0) && has("LMN_LLM", -50.0, 0.0), "{changes:?}");
}

/// What an input is in each call.
type Course = fn(usize) -> f64;

/// A recording of a block with these settings and inputs, call by call; `time` and its columns are as their variables.
fn tape(fmu: &str, values: &[(&str, f64)], calls: usize, inputs: &[(&str, Course)], outputs: &[&str]) -> String {
    let home = Linked::new();
    let description = home.description(fmu).unwrap();
    let find = |name: &str| {
        let variable = description.variable(name).unwrap_or_else(|| panic!("{name}"));
        (variable.kind.unwrap(), variable.value_reference)
    };
    let mut block = home.instantiate(fmu, "PLC").unwrap();
    block.setup(0.0, None).unwrap();
    let set = |block: &mut dyn Component, name: &str, value: f64| {
        let (kind, reference) = find(name);
        block.write(kind, &[reference], &[value]).unwrap();
    };
    values.iter().for_each(|(name, value)| set(&mut *block, name, *value));
    block.enter_initialization().unwrap();
    block.exit_initialization().unwrap();
    let table = home.table(fmu).unwrap().unwrap();
    let (cycle, mut now) = (&table.rows[table.cycle].name, [0.0]);
    block.read(find(cycle).0, &[find(cycle).1], &mut now).unwrap();
    let cycle = now[0];
    let names: Vec<&str> = inputs.iter().map(|(name, _)| *name).chain(outputs.iter().copied()).collect();
    let mut text = format!("time;{}\n", names.join(";"));
    for call in 0..calls {
        let mut cells = vec![format!("{:.3}", call as f64 * cycle)];
        for (name, value) in inputs {
            let value = (value(call) * 1000.0).round() / 1000.0;
            set(&mut *block, name, value);
            cells.push(format!("{value}"));
        }
        block.step(call as f64 * cycle, cycle).unwrap();
        for name in outputs {
            let (kind, reference) = find(name);
            block.read(kind, &[reference], &mut now).unwrap();
            cells.push(format!("{:.3}", now[0]));
        }
        writeln!(text, "{}", cells.join(";")).unwrap();
    }
    text
}

/// A process value that wanders, and stands still for a while.
fn wandering(call: usize) -> f64 {
    let time = call as f64;
    50.0 + 8.0 * (time / 37.0).sin() + 3.0 * (time / 11.0).sin() + if (150..200).contains(&call) { 6.0 } else { 0.0 }
}

fn stepping(call: usize) -> f64 {
    if call < 100 {
        52.0
    } else if call < 260 {
        60.0
    } else {
        45.0
    }
}

/// What differs on the plant from the file.
struct Wrong {
    fmu: &'static str,
    file: &'static [(&'static str, f64)],
    plant: &'static [(&'static str, f64)],
}

impl Wrong {
    fn recording(&self) -> String {
        let plant: Vec<(&str, f64)> = merged(self.file, self.plant);
        match self.fmu {
            "CONT_C" if self.plant.iter().any(|(name, _)| *name == "MAN_ON") => {
                let outputs = ["LMN"];
                tape("CONT_C", &plant, 400, &[("SP_INT", stepping), ("PV_IN", wandering)], &outputs)
            }
            "CONT_C" => Plant { values: &plant, ..Plant::default() }.record(),
            "CONT_S" => {
                let inputs: [(&str, Course); 2] = [("SP_INT", stepping), ("PV_IN", wandering)];
                tape("CONT_S", &plant, 800, &inputs, &["QLMNUP", "QLMNDN"])
            }
            "PULSEGEN" => {
                tape("PULSEGEN", &plant, 1500, &[("INV", |call| wandering(call / 4) - 45.0)], &["QPOS_P", "QNEG_P"])
            }
            "PULS_CTR" => {
                let word: Course = |call| (wandering(call / 4) * 276.48).round();
                tape(
                    "PULS_CTR",
                    &plant,
                    2000,
                    &[("SP_INT", |call| stepping(call / 4)), ("PV_PER", word)],
                    &["QPOS_P", "DI_CONT_C.LMN"],
                )
            }
            _ => tape("HLG", &plant, 600, &[("S0", |call| if call < 300 { 20_000.0 } else { 3_000.0 })], &["HLG"]),
        }
    }
}

fn merged<'a>(file: &[(&'a str, f64)], others: &[(&'a str, f64)]) -> Vec<(&'a str, f64)> {
    let kept = file.iter().copied().filter(|(name, _)| others.iter().all(|(other, _)| other != name));
    kept.chain(others.iter().copied()).collect()
}

const PI: &[(&str, f64)] = &FILE;
const PID: &[(&str, f64)] =
    &[("GAIN", 2.0), ("TI", 20.0), ("CYCLE", 1.0), ("LMN_HLM", 90.0), ("D_SEL", 1.0), ("TD", 5.0), ("TM_LAG", 2.0)];
const STEPS: &[(&str, f64)] = &[
    ("GAIN", 1.0),
    ("TI", 40.0),
    ("CYCLE", 0.5),
    ("MTR_TM", 30.0),
    ("PULSE_TM", 2.0),
    ("BREAK_TM", 2.0),
    ("DEADB_W", 0.5),
];
const PULSES: &[(&str, f64)] = &[("PER_TM", 10.0), ("P_B_TM", 0.2), ("CYCLE", 0.1), ("STEP3_ON", 1.0)];
const BOTH: &[(&str, f64)] =
    &[("RED_FAC", 20.0), ("DI_CONT_C.GAIN", 2.0), ("DI_CONT_C.TI", 20.0), ("DI_CONT_C.PV_FAC", 1.0), ("CYCLE", 0.1)];
const RAMP: &[(&str, f64)] = &[("TH_TZ", 200.0), ("TR_TZ", 100.0)];

const WRONG: [Wrong; 25] = [
    Wrong { fmu: "CONT_C", file: PI, plant: &[("TI", 25.0)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("TI", 40.0)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("TI", 17.35)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("GAIN", 2.2)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("GAIN", 0.66961)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("GAIN", 2.2), ("TI", 25.0)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("GAIN", 1.0), ("TI", 60.0)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("LMN_HLM", 70.0)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("LMN_HLM", 70.0), ("TI", 30.0)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("GAIN", -2.0)] },
    Wrong { fmu: "CONT_C", file: PI, plant: &[("DEADB_W", 0.5)] },
    Wrong { fmu: "CONT_C", file: PID, plant: &[("TD", 8.0)] },
    Wrong { fmu: "CONT_C", file: PID, plant: &[("TM_LAG", 4.0)] },
    Wrong { fmu: "CONT_C", file: PID, plant: &[("TD", 8.0), ("TI", 33.0)] },
    Wrong {
        fmu: "CONT_C",
        file: &[("GAIN", 2.0), ("TI", 20.0), ("CYCLE", 1.0), ("MAN_ON", 1.0)],
        plant: &[("MAN_ON", 0.0)],
    },
    Wrong {
        fmu: "CONT_C",
        file: &[("GAIN", 2.0), ("TI", 20.0), ("CYCLE", 1.0), ("MAN_ON", 1.0)],
        plant: &[("MAN_ON", 0.0), ("TI", 35.0)],
    },
    Wrong { fmu: "CONT_S", file: STEPS, plant: &[("GAIN", 1.5)] },
    Wrong { fmu: "CONT_S", file: STEPS, plant: &[("PULSE_TM", 4.0)] },
    Wrong { fmu: "CONT_S", file: STEPS, plant: &[("MTR_TM", 45.0)] },
    Wrong { fmu: "PULSEGEN", file: PULSES, plant: &[("PER_TM", 12.0)] },
    Wrong { fmu: "PULS_CTR", file: BOTH, plant: &[("DI_CONT_C.GAIN", 3.0)] },
    Wrong { fmu: "PULS_CTR", file: BOTH, plant: &[("DI_CONT_C.TI", 50.0)] },
    Wrong { fmu: "PULS_CTR", file: BOTH, plant: &[("RED_FAC", 25.0)] },
    Wrong { fmu: "HLG", file: RAMP, plant: &[("TH_TZ", 150.0)] },
    Wrong { fmu: "HLG", file: RAMP, plant: &[("TR_TZ", 70.0)] },
];

#[test]
fn one_or_two_wrong_settings_of_a_continuous_controller_are_told() {
    assert_told(|wrong| wrong.fmu == "CONT_C");
}

#[test]
fn one_wrong_setting_of_a_block_with_pulses_or_a_ramp_is_told() {
    assert_told(|wrong| wrong.fmu != "CONT_C");
}

/// Each cause is told for sure, and nothing else is.
fn assert_told(which: fn(&&Wrong) -> bool) {
    let mut missed = Vec::new();
    for wrong in WRONG.iter().filter(which) {
        let replayed = run(&request(member(wrong.fmu, wrong.file), wrong.recording()));
        let is_true = |suspect: &control::replay::Suspect| {
            let near = |(name, value): &(&str, f64)| {
                suspect.values.get(*name).is_some_and(|found| (number_of(*found) - value).abs() <= 1e-6 * value.abs())
            };
            suspect.values.len() == wrong.plant.len() && wrong.plant.iter().all(near)
        };
        if let Some(lie) = replayed.suspects.iter().find(|suspect| suspect.is_sure && !is_true(suspect)) {
            missed.push(format!("{:?} is told wrong: {:?}", wrong.plant, lie.changes));
        } else if !replayed.suspects.iter().any(|suspect| suspect.is_sure && is_true(suspect)) {
            missed.push(format!("{} {:?} is not told: {:?}", wrong.fmu, wrong.plant, replayed.suspects));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// Pulses of a step controller with TI 12 s whose process value creeps to the setpoint from a call on, each in the row of the next call;
/// replayed with TI 6 s.
fn late_pulses(calls: usize, creeping: Course) -> Replayed {
    let file = [("GAIN", 1.2), ("TI", 6.0), ("CYCLE", 0.1), ("PULSE_TM", 0.1), ("BREAK_TM", 0.1), ("DEADB_W", 0.2)];
    let plant = merged(&file, &[("TI", 12.0)]);
    let text = tape("CONT_S", &plant, calls, &[("SP_INT", |_| 50.0), ("PV_IN", creeping)], &["QLMNUP", "QLMNDN"]);
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(';').collect()).collect();
    let late = |row: usize| [&rows[row][..3], &rows[(row - 1).max(1)][3..]].concat().join(";");
    let text: Vec<String> = std::iter::once(rows[0].join(";")).chain((1..rows.len()).map(late)).collect();
    run(&request(member("CONT_S", &file), text.join("\n")))
}

#[test]
fn pulses_that_fit_in_their_row_and_a_call_late_are_told_with_the_plainer_value_and_both() {
    // After a dead time it does not say which call a pulse belongs to.
    let replayed = late_pulses(600, |call| 50.0 - 30.0 * (-(call.saturating_sub(30) as f64) / 200.0).exp());
    assert_named(&replayed, "TI", 12.0, 6.0);
    assert!(
        replayed.remarks.iter().any(|remark| remark.starts_with("Each row holds the outputs of the previous call"))
    );
    let (low, high) = replayed.suspects[0].range.expect("the other reading has another value");
    assert!(low < 11.95 && high == 12.0, "{low} to {high}");
}

#[test]
fn a_pulse_that_rounding_moves_by_a_call_makes_no_change_by_hand() {
    let replayed = late_pulses(200, |call| 50.0 - 30.0 * (-(call as f64) / 100.0).exp());
    assert_named(&replayed, "TI", 12.0, 6.0);
    assert!(replayed.suspects.iter().all(|suspect| suspect.since.is_none()), "{:?}", replayed.suspects);
}

#[test]
fn pulses_that_differ_no_more_than_rounding_moves_them_name_no_setting() {
    let settings = [("GAIN", 1.2), ("TI", 6.0), ("CYCLE", 0.1), ("PULSE_TM", 0.1), ("BREAK_TM", 0.1), ("DEADB_W", 0.2)];
    let process_value: Course = |call| 50.0 - 30.0 * (-(call as f64) / 90.0).exp() * (call as f64 / 60.0).cos();
    let recorded = |plant: &[(&str, f64)], decimals: usize| {
        let inputs: [(&str, Course); 2] = [("SP_INT", |_| 50.0), ("PV_IN", process_value)];
        let text = tape("CONT_S", &merged(&settings, plant), 600, &inputs, &["QLMNUP", "QLMNDN"]);
        let rounded = |line: &str| {
            let mut cells: Vec<String> = line.split(';').map(str::to_string).collect();
            cells[2] = cells[2].parse::<f64>().map_or(cells[2].clone(), |value| format!("{value:.decimals$}"));
            cells.join(";")
        };
        let text = text.lines().map(rounded).collect::<Vec<_>>().join("\n");
        run(&request(member("CONT_S", &settings), text))
    };
    let replayed = recorded(&[], 1);
    assert_eq!(replayed.conclusion, Conclusion::Rounded, "{:?}", replayed.suspects);
    assert!(replayed.suspects.is_empty() && replayed.outputs.iter().any(|of| of.different > 0));
    assert_named(&recorded(&[("TI", 12.0)], 2), "TI", 12.0, 6.0);
}

#[test]
fn what_a_recording_does_not_tell_is_not_told() {
    // Pulses alone tell a gain and a length, and not all of these settings.
    for wrong in [
        Wrong { fmu: "CONT_S", file: STEPS, plant: &[("TI", 25.0)] },
        Wrong { fmu: "PULSEGEN", file: PULSES, plant: &[("RATIOFAC", 2.0)] },
    ] {
        let replayed = run(&request(member(wrong.fmu, wrong.file), wrong.recording()));
        let name = wrong.plant[0].0;
        assert!(
            replayed.suspects.iter().all(|suspect| !suspect.is_sure || suspect.values.contains_key(name)),
            "{:?}",
            replayed.suspects
        );
    }
    // Rounded to whole numbers, nothing tells one setting from another.
    for (plant, decimals) in [(&[("TI", 20.4)][..], 1), (&[("GAIN", 2.02)][..], 0)] {
        let text = Plant { values: &with(plant), decimals, ..Plant::default() }.record();
        let replayed = run(&request(member("CONT_C", &FILE), text));
        assert!(
            replayed.suspects.iter().all(|suspect| !suspect.is_sure || suspect.values.contains_key(plant[0].0)),
            "{:?}",
            replayed.suspects
        );
    }
    // Three wrong settings.
    let text = Plant { values: &with(&[("GAIN", 3.1), ("TI", 47.0), ("LMN_LLM", 12.0)]), ..Plant::default() }.record();
    let replayed = run(&request(member("CONT_C", &FILE), text));
    assert!(!replayed.suspects.iter().any(|suspect| suspect.is_sure), "{:?}", replayed.suspects);
    assert_eq!(replayed.conclusion, Conclusion::Unexplained);
}
