//! Documents in SIMATIC SD.

#![allow(clippy::unwrap_used)]

mod blocks;
mod elements;
mod errors;
mod random;

use parameters::{Problems, Source};
use scl::ir::Type;
use scl::machine::{Code, Machine};
use scl::{Compiled, Options, compile};
use std::sync::Arc;

/// Formats the errors of a program, one per line.
fn problems(errors: &[Problems]) -> String {
    errors.iter().map(|errors| format!("{errors}\n")).collect()
}

/// Compiles files with their names.
fn compiled(files: &[(&str, &str)]) -> Result<Compiled, String> {
    let sources: Vec<Source> = files.iter().map(|(name, text)| Source::new(*name, text.as_bytes().to_vec())).collect();
    compile(&sources, &Options { block: Some("B".to_string()), ..Options::default() })
        .map_err(|errors| problems(&errors))
}

/// A program with its values.
struct Ran {
    compiled: Compiled,
    machine: Machine,
}

impl Ran {
    fn new(compiled: Compiled) -> Ran {
        let machine = Machine::new(Arc::new(Code::compile(&compiled.program).unwrap()));
        Ran { compiled, machine }
    }

    /// Sets a variable of the block to these bits.
    fn set(&mut self, name: &str, bits: u64) {
        let path = format!("{}.{name}", self.compiled.root.as_ref().unwrap().instance);
        let Some((offset, Type::Scalar(of))) = self.compiled.program.find(&path) else { panic!("{path} is no number") };
        self.machine.set(scl::ir::Value::new(of, bits), offset);
    }

    /// Makes a call at a time in milliseconds, and returns all variables of the block after it.
    fn call(&mut self, milliseconds: i64) -> Vec<(String, u64)> {
        let root = self.compiled.root.as_ref().unwrap();
        self.machine.call(root.cycle, milliseconds * 1_000_000).unwrap();
        let numbers = root.variables.iter().filter_map(|variable| match variable.ty {
            Type::Scalar(of) => Some((variable.name.clone(), self.machine.get(of, variable.offset).bits())),
            _ => None,
        });
        numbers.collect()
    }
}

/// A deterministic pseudorandom number generator.
struct Random(u64);

impl Random {
    fn below(&mut self, count: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % count
    }
}

/// The inputs and outputs of the blocks in the tests.
const HEAD: &str =
    "    VAR_INPUT a : Bool; b : Bool; c : Bool; s : Bool; r : Bool; i : Int; j : Int; x : Real; w : Word; END_VAR
    VAR_OUTPUT y : Bool; z : Bool; n : Int; k : Int; q : Real; v : Word; et : Time; cv : Int; END_VAR\n";

/// Returns a block with these sections and networks as a document, and the same block in SCL; other blocks are
/// appended.
fn pair(sections: &str, networks: &str, statements: &str) -> (String, String) {
    let head = format!("FUNCTION_BLOCK \"B\"\n{HEAD}{sections}\n");
    (
        format!("{{ S7_PreferredLanguage := \"LAD\" }}\n{head}{networks}\nEND_FUNCTION_BLOCK\n"),
        format!("{}BEGIN\n{statements}\nEND_FUNCTION_BLOCK\n", head.replace("_.", "")),
    )
}

/// Runs both with the same inputs, and compares the bits of all variables after each call.
#[track_caller]
fn compare(document: &str, source: &str, others: &str, calls: u64, seed: u64) {
    let read = |name: &str, text: &str| compiled(&[(name, text), ("others.scl", others)]);
    let document_of = read("B.s7dcl", document).unwrap_or_else(|errors| panic!("{document}\n{errors}"));
    let source_of = read("B.scl", source).unwrap_or_else(|errors| panic!("{source}\n{errors}"));
    let (mut one, mut other) = (Ran::new(document_of), Ran::new(source_of));
    let mut random = Random(seed);
    for call in 0..calls {
        let mut inputs: Vec<(&str, u64)> = ["a", "b", "c", "s", "r"].map(|name| (name, random.below(2))).to_vec();
        let integers = [0, 1, 2, 3, 5, 100, 32767, 32768, 65535];
        inputs.extend(["i", "j", "w"].map(|name| (name, integers[random.below(9) as usize])));
        let numbers = [0.0f32, 0.5, 1.0, -2.5, 1e10, f32::NAN, f32::INFINITY];
        inputs.push(("x", u64::from(numbers[random.below(7) as usize].to_bits())));
        for (name, bits) in inputs {
            one.set(name, bits);
            other.set(name, bits);
        }
        let now = call as i64 * 100;
        let (one, other) = (one.call(now), other.call(now));
        let different = one.iter().zip(&other).find(|(one, other)| one != other);
        assert!(different.is_none(), "{different:?} after call {call} of\n{document}\n{source}");
    }
}
