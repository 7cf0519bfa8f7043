//! Runs the source of a proof: with the block it was made for it finds nothing, and with a slightly different law it
//! reports the first call and output that differ.

#![allow(clippy::unwrap_used)]

use laws::Sources;
use parameters::Source;
use scl::Dialect;
use scl::ir::{Scalar, Type};
use scl::machine::{Code, Machine};
use scl::prove::{Names, Outcome, RESULT_BYTES, State, Tape, print};
use scl::{Cpu, Options, compile};
use std::sync::Arc;

const CALLS: usize = 1200;

const BLOCKS: [&str; 5] = ["CONT_C", "CONT_S", "PULSEGEN", "PULS_CTR", "HLG"];

/// Returns the result's data block as bytes, in the standard (non-optimized) layout, after the last cycle.
fn run(tape: &Tape, dialect: Dialect, other: Option<&str>) -> Vec<u8> {
    let block = other.map_or_else(|| tape.table.name.to_string(), |_| "OTHER".to_string());
    let text = print(tape, &Names { block, first: 400 }, dialect);
    let mut sources = vec![Source::new("prove.scl", text.clone().into_bytes())];
    sources.extend(other.map(|other| Source::new("other.scl", other.as_bytes().to_vec())));
    let (cpu, instance, result) = match dialect {
        Dialect::Tia => {
            (Cpu::S71500, format!("PROVE_{}_DB", tape.table.name), format!("PROVE_{}_RESULT", tape.table.name))
        }
        Dialect::Step7 => (Cpu::S7300, "DB400".to_string(), "DB401".to_string()),
    };
    let options = Options { cpu: Some(cpu), block: Some(instance), ..Options::default() };
    let compiled =
        compile(&sources, &options).unwrap_or_else(|errors| panic!("{}\n{}", errors[0], &text[..text.len().min(6000)]));
    let root = compiled.root.unwrap();
    let mut machine = Machine::new(Arc::new(Code::compile(&compiled.program).unwrap()));
    // A few cycles more than calls: the block has stopped by then.
    for cycle in 0..tape.calls + 3 {
        machine.call(root.cycle, cycle as i64 * 10_000_000).unwrap_or_else(|stop| panic!("{stop}"));
    }
    let members = ["magic", "layout", "state", "seed", "tape", "calls", "done", "output", "spare", "expected", "found"];
    let mut bytes = Vec::new();
    for member in members {
        let path = format!("{result}.{member}");
        let Some((offset, Type::Scalar(ty))) = compiled.program.find(&path) else { panic!("{path}") };
        let bits = machine.get(ty, offset).bits();
        match ty {
            Scalar::I16 => bytes.extend((bits as u16).to_be_bytes()),
            _ => bytes.extend((bits as u32).to_be_bytes()),
        }
    }
    assert_eq!(bytes.len(), RESULT_BYTES);
    bytes
}

#[test]
fn the_block_itself_passes_in_both_dialects() {
    for name in BLOCKS {
        let tape = Tape::new(name, CALLS, 1).unwrap();
        assert_eq!(tape.calls, CALLS, "{name}");
        for dialect in [Dialect::Tia, Dialect::Step7] {
            // Programs have no names for the interior of a built-in block, so the law in SCL replaces it.
            let has_inner = tape.inputs.iter().any(|row| tape.table.rows[*row].is_inner());
            let law = has_inner.then(|| changed(name, dialect, "", ""));
            let outcome = Outcome::read(&run(&tape, dialect, law.as_deref())).unwrap();
            assert_eq!(outcome.text(Some(&tape)), format!("{name}: 1,200 calls, 0 differ"), "{dialect:?}");
        }
    }
}

#[test]
fn the_guide_has_the_sizes_of_the_tapes() {
    let guide = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/prove.md")).unwrap();
    for name in BLOCKS {
        let tape = Tape::new(name, 5000, 1).unwrap();
        let ((bytes, tia), (_, step7)) = (tape.size(Dialect::Tia), tape.size(Dialect::Step7));
        let row = format!("| {name} | {} KB | {tia} | {step7} |", bytes.div_ceil(1024));
        assert!(guide.contains(&row), "docs/prove.md has no row {row}");
    }
}

/// Returns a law as SCL under another name, changed in one place.
fn changed(name: &str, dialect: Dialect, from: &str, to: &str) -> String {
    let law = laws::read(&Sources::of_blocks(), name).unwrap();
    let text = law.scl(dialect).unwrap();
    assert!(from.is_empty() || text.matches(from).count() == 1, "{from} in\n{text}");
    let text = if from.is_empty() { text } else { text.replace(from, to) };
    let text = text.replace(&format!("FUNCTION_BLOCK \"{name}\""), "FUNCTION_BLOCK \"OTHER\"");
    text.replace(&format!("\n\"{name}\"\nBEGIN"), "\n\"OTHER\"\nBEGIN")
}

/// Returns the result of a proof for a law with one change, and the inputs of the call.
fn found(name: &str, from: &str, to: &str) -> (Outcome, String, String) {
    let tape = Tape::new(name, CALLS, 1).unwrap();
    let same = Outcome::read(&run(&tape, Dialect::Tia, Some(&changed(name, Dialect::Tia, from, from)))).unwrap();
    assert_eq!(same.state, State::Complete, "{name} as SCL: {}", same.text(Some(&tape)));
    let outcome = Outcome::read(&run(&tape, Dialect::Tia, Some(&changed(name, Dialect::Tia, from, to)))).unwrap();
    let State::Differs { output, .. } = outcome.state else { panic!("{name}: {}", outcome.text(Some(&tape))) };
    let text = outcome.text(outcome.tape().as_ref());
    let output = tape.table.rows[tape.outputs[output]].name.to_string();
    (outcome, output, text)
}

#[test]
fn a_law_with_one_change_is_found_at_its_first_call_and_output() {
    // The constant of the analog value changed by one bit: detected at the first analog value for which it matters.
    let (outcome, output, text) = found("CONT_C", "0.003616898;", "0.0036168983;");
    assert!(["LMN", "LMN_PER", "LMN_P", "PV"].contains(&&*output), "{text}");
    let tape = outcome.tape().unwrap();
    let inputs = tape.inputs_of(outcome.done as usize);
    let value = |name: &str| inputs.iter().find(|(it, _)| it == name).unwrap().1.clone();
    assert_eq!(value("PVPER_ON"), "TRUE", "{text}");
    assert!(text.starts_with("CONT_C: call ") && text.contains(" of 1,200 differs: "), "{text}");

    let (_, output, text) = found("CONT_C", "#LMN_PER := INT_TO_WORD(", "#LMN_PER := NOT INT_TO_WORD(");
    assert_eq!(output, "LMN_PER", "{text}");
    let (_, output, text) = found("CONT_S", "#QLMNDN := #memory.pulse < 0;", "#QLMNDN := #memory.pulse <> 0;");
    assert_eq!(output, "QLMNDN", "{text}");
    let (_, output, text) = found("PULSEGEN", "#memory.pulse_left > 0", "#memory.pulse_left > 1");
    assert!(output.starts_with('Q'), "{text}");
    let (_, output, text) = found("PULS_CTR", "#memory.s_count <= 0", "#memory.s_count < 0");
    assert!(output.starts_with("DI_CONT_C."), "{text}");
    let (_, output, text) = found("HLG", "IN2 := -32767", "IN2 := -5");
    assert_eq!(output, "HLG", "{text}");
}
