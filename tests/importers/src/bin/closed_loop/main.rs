//! `closed_loop fmi` and `closed_loop fmi-rs`: a co-simulation master made of one of these crates. It reads a closed loop
//! from standard input and writes the outputs after each step, as JSON both:
//!
//! ```text
//! {"fmus": {"CONT_C": {"GAIN": 1.4, ...}, "HEATER": {...}},                 FMUs with their start values
//!  "connections": [["CONT_C", "LMN", "HEATER", "POWER"], ...],              output to input
//!  "step": 1.0, "steps": 300}
//!
//! {"CONT_C.LMN": 84.0, "HEATER.TEMP": 20.0, ...}                            one line a step
//! ```
//!
//! Numbers are written so that they are read back without a bit of difference.

mod by_fmi;
mod by_fmi_rs;

use by_fmi::ByFmi;
use by_fmi_rs::ByFmiRs;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::{BufWriter, Write, stdin, stdout};

/// A variable as an importer reads it from modelDescription.xml.
struct Variable {
    reference: u32,
    kind: Kind,
    is_output: bool,
}

/// The types that the FMUs use.
enum Kind {
    Real,
    Integer,
    Boolean,
}

/// An instance in the hands of an importer.
trait Slave {
    fn variables(&self) -> BTreeMap<String, Variable>;
    fn set(&mut self, variable: &Variable, value: &Value);
    fn get(&mut self, variable: &Variable) -> Value;
    /// Goes through Initialization Mode.
    fn initialize(&mut self);
    fn step(&mut self, time: f64, step: f64);
}

/// An instance with its variables by name.
struct Fmu {
    slave: Box<dyn Slave>,
    variables: BTreeMap<String, Variable>,
}

impl Fmu {
    fn new(slave: Box<dyn Slave>) -> Fmu {
        Fmu { variables: slave.variables(), slave }
    }

    fn get(&mut self, name: &str) -> Value {
        self.slave.get(&self.variables[name])
    }

    fn set(&mut self, name: &str, value: &Value) {
        self.slave.set(&self.variables[name], value);
    }
}

fn main() {
    let importer = std::env::args().nth(1).expect("the importer: fmi or fmi-rs");
    let description: Value = serde_json::from_reader(stdin()).expect("a closed loop as JSON");
    let connections: Vec<[String; 4]> =
        serde_json::from_value(description["connections"].clone()).expect("connections");
    let step = description["step"].as_f64().expect("step");
    let steps = description["steps"].as_u64().expect("steps");

    let mut fmus = BTreeMap::new();
    for (name, start) in description["fmus"].as_object().expect("fmus") {
        let mut fmu = Fmu::new(match importer.as_str() {
            "fmi" => Box::new(ByFmi::new(name)),
            "fmi-rs" => Box::new(ByFmiRs::new(name)),
            other => panic!("the importer is fmi or fmi-rs, not {other}"),
        });
        for (variable, value) in start.as_object().expect("start values") {
            fmu.set(variable, value);
        }
        fmu.slave.initialize();
        fmus.insert(name.as_str(), fmu);
    }

    let mut recording = BufWriter::new(stdout().lock());
    for number in 0..steps {
        // Everyone's inputs are what the others have given by now; so nobody steps before all are read.
        let mut signals = vec![];
        for [from, output, _, _] in &connections {
            signals.push(fmus.get_mut(from.as_str()).expect("a fmu").get(output));
        }
        for ([_, _, to, input], signal) in connections.iter().zip(&signals) {
            fmus.get_mut(to.as_str()).expect("a fmu").set(input, signal);
        }
        for fmu in fmus.values_mut() {
            fmu.slave.step(number as f64 * step, step);
        }
        writeln!(recording, "{}", Value::Object(outputs(&mut fmus))).expect("standard output");
    }
}

fn outputs(fmus: &mut BTreeMap<&str, Fmu>) -> Map<String, Value> {
    let mut outputs = Map::new();
    for (name, fmu) in fmus {
        for (variable_name, variable) in fmu.variables.iter().filter(|(_, variable)| variable.is_output) {
            outputs.insert(format!("{name}.{variable_name}"), fmu.slave.get(variable));
        }
    }
    outputs
}

fn real(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no Real"))
}

fn integer(value: &Value) -> i32 {
    value.as_i64().and_then(|value| value.try_into().ok()).unwrap_or_else(|| panic!("{value} is no Integer"))
}

fn boolean(value: &Value) -> i32 {
    value.as_bool().unwrap_or_else(|| panic!("{value} is no Boolean")).into()
}

fn real_value(value: f64) -> Value {
    assert!(value.is_finite(), "JSON has no {value}");
    json!(value)
}
