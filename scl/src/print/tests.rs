//! Random programs have the same results after they have been printed and parsed again.

use super::{Dialect, print};
use crate::ir::{Program, Type};
use crate::machine::tests::random::{Of, Random};
use crate::machine::{Code, Machine};
use crate::{Options, compile};
use parameters::Source;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Returns the number of programs per run, which `PLCFMU_PROGRAMS` changes.
fn programs() -> u64 {
    std::env::var("PLCFMU_PROGRAMS").map_or(200, |programs| programs.parse().expect("PLCFMU_PROGRAMS is a number"))
}

/// Collects the memory's members as bytes, by name; all NaNs are mapped to the same bits.
fn values(program: &Program, ty: &Type, bytes: &[u8], name: &str, into: &mut BTreeMap<String, u64>) {
    match ty {
        Type::Scalar(ty) => {
            let value = crate::ir::Value::read(*ty, bytes);
            let bits = if ty.is_float() && value.number().is_nan() { 0x7FC0_0000 } else { value.bits() };
            into.insert(name.to_string(), bits);
        }
        Type::Array { of, .. } => {
            let size = program.size(of);
            for (index, part) in bytes[..program.size(ty)].chunks(size).enumerate() {
                values(program, of, part, &format!("{name}[{index}]"), into);
            }
        }
        Type::Record(record) => {
            for member in &program.records[*record].members {
                let name = format!("{name}.{}", member.name.to_ascii_lowercase());
                values(program, &member.ty, &bytes[member.offset..], &name, into);
            }
        }
        Type::Text { wide: false, .. } => {
            let length = usize::from(u16::from_le_bytes([bytes[0], bytes[1]]));
            let bits = bytes[..2 + length].iter().fold(0, |bits: u64, byte| bits.wrapping_mul(257) + u64::from(*byte));
            into.insert(name.to_string(), bits);
        }
        _ => {}
    }
}

/// Returns the memory after each call; `None` for a call that is stopped.
fn run(program: &Program, function: usize) -> Vec<Option<BTreeMap<String, u64>>> {
    let mut machine = Machine::new(Arc::new(Code::compile(program).unwrap()));
    machine.budget = 4000;
    let calls = (0..3).map(|call| {
        machine.call(function, call * 100_000_000).ok()?;
        let mut found = BTreeMap::new();
        let memory = &program.records[program.memory];
        for member in &memory.members {
            // The printed program keeps the numbers and arrays of the memory in a data block.
            let name = if member.name == "globals" { String::new() } else { format!(".{}", member.name) };
            values(program, &member.ty, &machine.state()[member.offset..], &name.to_ascii_lowercase(), &mut found);
        }
        Some(found)
    });
    calls.collect()
}

#[test]
fn random_programs_give_the_same_bits_when_they_are_read_again() {
    let (mut printed, mut compared) = (0, 0);
    let mut refusals: BTreeMap<String, usize> = BTreeMap::new();
    for seed in 1..=programs() {
        let program = Random::program(seed * 7919, 0, Of::Scl);
        let entry = Random::entry(&program);
        let text = match print(&program, &[entry], Dialect::Tia) {
            Ok(text) => text,
            Err(error) => {
                *refusals
                    .entry(error.split_once(": ").map_or(error.clone(), |(_, rest)| rest.to_string()))
                    .or_default() += 1;
                continue;
            }
        };
        printed += 1;
        let task = crate::Task { name: "f0".to_string(), period: 0 };
        let options = Options { calls: vec![task], ..Options::default() };
        // The generator may produce a constant index that is out of bounds: it stops the program, whereas SCL rejects
        // it at compile time.
        let compiled = match compile(&[Source::new("random.scl", text.clone().into_bytes())], &options) {
            Err(errors) if errors[0].to_string().contains("is outside") => continue,
            Err(errors) => panic!("seed {seed}: {}\n{text}", errors[0]),
            Ok(compiled) => compiled,
        };
        let before = run(&program, entry);
        let after = run(&compiled.program, compiled.root.unwrap().cycle);
        for (call, pair) in before.iter().zip(&after).enumerate() {
            // The statement counts differ where the printer adds statements.
            let (Some(before), Some(after)) = pair else { break };
            for (name, value) in after {
                assert_eq!(Some(value), before.get(name), "seed {seed}, call {call}: {name}\n{text}");
                compared += 1;
            }
        }
    }
    assert!(printed > 5 && compared > 100, "{printed} printed, {compared} compared: {refusals:?}");
}

/// An engineer finds the names of the project again, blanks and letters beyond ASCII included.
#[test]
fn blocks_and_data_blocks_keep_their_names() {
    let text = "DATA_BLOCK \"HMI\"\nSTRUCT\n  level : REAL;\nEND_STRUCT\nBEGIN\nEND_DATA_BLOCK\n\
                DATA_BLOCK \"数据块_1\"\nSTRUCT\n  n : INT := 3;\nEND_STRUCT\nBEGIN\nEND_DATA_BLOCK\n\
                FUNCTION \"Größe von\" : INT\nVAR_INPUT x : INT; END_VAR\nBEGIN\n#\"Größe von\" := #x + 1;\nEND_FUNCTION\n\
                FUNCTION_BLOCK \"Motor 1\"\nVAR_OUTPUT y : INT; END_VAR\nBEGIN\n\
                #y := \"Größe von\"(\"数据块_1\".n); \"HMI\".level := 2.5;\nEND_FUNCTION_BLOCK\n";
    let compiled = compile(&[Source::new("a.scl", text.into())], &Options::default()).unwrap();
    let printed = print(&compiled.program, &[compiled.root.as_ref().unwrap().cycle], Dialect::Tia).unwrap();
    for name in [
        "DATA_BLOCK \"HMI\"\n",
        "DATA_BLOCK \"数据块_1\"\n",
        "FUNCTION \"Größe von\" : ",
        "FUNCTION_BLOCK \"Motor 1\"\n",
    ] {
        assert!(printed.contains(name), "{name}{printed}");
    }
    compile(&[Source::new("b.scl", printed.clone().into())], &Options::default())
        .unwrap_or_else(|errors| panic!("{}\n{printed}", errors[0]));
    // STEP 7 has letters, digits and underscores.
    let printed = print(&compiled.program, &[compiled.root.as_ref().unwrap().cycle], Dialect::Step7).unwrap();
    assert!(printed.contains("DATA_BLOCK \"x_1\"\n") && printed.contains("FUNCTION_BLOCK \"Motor_1\"\n"), "{printed}");
}
