//! The language's test cases: programs, their inputs in each call, and the expected bits.

#![allow(clippy::unwrap_used)]

use parameters::{Problems, Source};
use scl::ir::{Body, Program, Scalar, Value, What};
use scl::machine::{Code, Machine};
use scl::{Compiled, Cpu, Options, compile};
use serde_json::Value as Json;
use std::path::Path;
use std::sync::Arc;

fn cases(file: &str) -> Vec<Json> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(file);
    let json: Json = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    match json["cases"].as_array() {
        Some(cases) => cases.clone(),
        None => vec![json],
    }
}

fn text(problems: &[Problems]) -> String {
    problems.iter().map(|problems| format!("{problems}\n")).collect()
}

fn compiled(case: &Json) -> Result<Compiled, String> {
    let cpu = match case["cpu"].as_str() {
        Some("300") => Some(Cpu::S7300),
        Some("1200") => Some(Cpu::S71200),
        _ => Some(Cpu::S71500),
    };
    let source = Source::new("case.scl", case["scl"].as_str().unwrap().into());
    let block = case["block"].as_str().map(str::to_string);
    compile(&[source], &Options { cpu, block, ..Options::default() }).map_err(|errors| text(&errors))
}

/// Converts the value of a case into the bits of a type.
fn value(json: &Json, of: Scalar) -> Value {
    let bits = match json {
        Json::String(bits) => u64::from_str_radix(bits.trim_start_matches("0x"), 16).unwrap(),
        Json::Bool(truth) => u64::from(*truth),
        number => number.as_i64().map_or_else(|| number.as_u64().unwrap(), |number| number as u64),
    };
    Value::new(of, bits)
}

struct Running {
    program: Program,
    machine: Machine,
    instance: String,
    cycle: usize,
}

impl Running {
    fn new(compiled: Compiled) -> Running {
        let root = compiled.root.expect("a block to be run");
        let code = Code::compile(&compiled.program).unwrap_or_else(|error| panic!("{error}"));
        let machine = Machine::new(Arc::new(code));
        Running { program: compiled.program, machine, instance: root.instance, cycle: root.cycle }
    }

    fn place(&self, name: &str) -> (usize, Scalar) {
        let path = format!("{}.{name}", self.instance);
        match self.program.find(&path) {
            Some((offset, scl::ir::Type::Scalar(of))) => (offset, of),
            other => panic!("{path}: {other:?}"),
        }
    }
}

/// Returns the names of the elements of a case's variable, row by row.
fn names(variable: &Json) -> Vec<String> {
    let name = variable["name"].as_str().unwrap();
    let of = variable["type"].as_str().unwrap().to_uppercase();
    match of.strip_prefix("ARRAY[").and_then(|rest| rest.split_once(']')) {
        Some((bounds, _)) => {
            let (low, high) = bounds.split_once("..").unwrap();
            let (low, high): (i32, i32) = (low.trim().parse().unwrap(), high.trim().parse().unwrap());
            (low..=high).map(|index| format!("{name}[{index}]")).collect()
        }
        None => vec![name.to_string()],
    }
}

fn check(case: &Json) -> Result<(), String> {
    check_of(case, compiled(case))
}

/// Parses the program again after it has been printed as SCL; fails with the construct that SCL cannot express.
fn read_again(case: &Json) -> Result<Compiled, String> {
    let first = compiled(case)?;
    let root = first.root.as_ref().ok_or("no block to be run")?;
    let Body::Code(cycle) = &first.program.functions[root.cycle].body else { return Err("no code".to_string()) };
    let called = cycle.iter().find_map(|statement| match &statement.what {
        What::Call(call) => Some(call.function),
        _ => None,
    });
    let text = scl::print(&first.program, &[called.ok_or("nothing is called")?], scl::Dialect::Tia)?;
    // The start values of inner structures are in a data block.
    let data_block = format!("{}_DB", root.block);
    let has_data_block = text.contains(&format!("DATA_BLOCK \"{data_block}\""));
    let block = Some(if has_data_block { data_block } else { root.block.clone() });
    let options = Options { cpu: Some(first.cpu), block, ..Options::default() };
    let source = Source::new("case.scl", text.clone().into_bytes());
    Ok(compile(&[source], &options).unwrap_or_else(|errors| panic!("{}: {}\n{text}", case["name"], errors[0])))
}

/// Checks the results of a file's programs after they have been printed and parsed again; returns their number, and the
/// reasons why others were skipped.
fn check_printed(file: &str) -> (usize, Vec<String>) {
    let (mut count, mut refused, mut failed) = (0, Vec::new(), Vec::new());
    for case in cases(file).iter().filter(|case| !case["error"].is_object()) {
        match read_again(case) {
            Ok(again) => {
                count += 1;
                if let Err(error) = check_of(case, Ok(again)) {
                    failed.push(format!("{}: {error}", case["name"]));
                }
            }
            Err(error) => refused.push(format!("{}: {error}", case["name"])),
        }
    }
    assert!(failed.is_empty(), "{} of {count}:\n{}", failed.len(), failed.join("\n"));
    (count, refused)
}

#[test]
fn printed_programs_give_the_same_bits_when_they_are_read_again() {
    for example in ["example_tank.json", "example_furnace.json", "example_conveyor.json"] {
        let (count, refused) = check_printed(example);
        assert_eq!(count, 1, "{refused:?}");
    }
    for file in ["hand.json", "random.json"] {
        let (count, refused) = check_printed(file);
        assert!(count > refused.len(), "{file}: {count} printed, {}", refused.join("\n"));
    }
}

fn check_of(case: &Json, compiled: Result<Compiled, String>) -> Result<(), String> {
    let error = &case["error"];
    let says = error["says"].as_str().unwrap_or_default();
    let line = || {
        let of = error["line_of"].as_str().unwrap();
        case["scl"].as_str().unwrap().lines().position(|line| line.contains(of)).unwrap() + 1
    };
    if error.is_object() && error["at_call"].is_null() {
        let errors = compiled.err().ok_or("it is not refused")?;
        let start = format!("case.scl:{}:", line());
        let is_told = errors.lines().any(|error| error.starts_with(&start) && error.contains(says));
        return if is_told { Ok(()) } else { Err(format!("expected {start} {says}, found\n{errors}")) };
    }
    let mut running = Running::new(compiled?);
    let cycle = case["cycle_ms"].as_i64().unwrap();
    let inputs: Vec<String> = case["inputs"].as_array().unwrap().iter().flat_map(names).collect();
    let outputs: Vec<String> = case["outputs"].as_array().unwrap().iter().flat_map(names).collect();
    for (call, given) in case["tape"].as_array().unwrap().iter().enumerate() {
        let given = flat(given);
        assert_eq!(given.len(), inputs.len());
        for (name, given) in inputs.iter().zip(&given) {
            let (offset, of) = running.place(name);
            running.machine.set(value(given, of), offset);
        }
        let result = running.machine.call(running.cycle, call as i64 * cycle * 1_000_000);
        if error["at_call"].as_u64() == Some(call as u64) {
            let stop = result.err().ok_or("it does not stop")?.to_string();
            let place = format!("case.scl:{}", line());
            return if stop.contains(says) && stop.contains(&place) { Ok(()) } else { Err(stop) };
        }
        result.map_err(|stop| stop.to_string())?;
        let expected = flat(&case["expected"][call]);
        for (name, expected) in outputs.iter().zip(&expected) {
            let (offset, of) = running.place(name);
            let (found, expected) = (running.machine.get(of, offset), value(expected, of));
            if found != expected {
                return Err(format!("call {call}: {name} is {found}, expected {expected}"));
            }
        }
    }
    Ok(())
}

/// Flattens a row of values, arrays one after the other.
fn flat(row: &Json) -> Vec<Json> {
    match row {
        Json::Array(values) => values.iter().flat_map(flat).collect(),
        value => vec![value.clone()],
    }
}

fn check_all(file: &str) {
    let mut failed = Vec::new();
    let cases = cases(file);
    for case in &cases {
        if let Err(error) = check(case) {
            failed.push(format!("{}: {error}", case["name"]));
        }
    }
    assert!(failed.is_empty(), "{} of {}:\n{}", failed.len(), cases.len(), failed.join("\n"));
}

#[test]
fn cases_by_hand_give_their_bits() {
    check_all("hand.json");
}

#[test]
fn random_programs_give_the_bits_of_other_compilers() {
    check_all("random.json");
}

#[test]
fn the_tank_fills_settles_and_holds_its_level() {
    check_all("example_tank.json");
}

#[test]
fn the_furnace_follows_its_ramp() {
    check_all("example_furnace.json");
}

#[test]
fn the_conveyor_starts_against_the_flow() {
    check_all("example_conveyor.json");
}
