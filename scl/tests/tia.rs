//! Programs in the style of exports from TIA Portal. Each compiles and runs, unless its first lines say otherwise:
//!
//! - `// refused: LINE: TEXT` is one of its errors, and there is no error in another line;
//! - `// lacks` means that it uses undeclared names, and has no other errors.
//!
//! A program may check itself: a variable `fail` is 0 after each call, or the number of the failed check. The expected
//! values were calculated by hand.

use parameters::Source;
use scl::ir::{Scalar, Value};
use scl::machine::{Code, Machine};
use scl::{Compiled, Options, compile};
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// Phrases that occur in the errors for undeclared names.
const LACKS: [&str; 2] = ["no source declares", "accesses the PLC's hardware or system"];

/// The number of calls of a program that checks itself, 100 ms apart; another program is called once.
const CALLS: i64 = 12;

fn run(name: &str, compiled: &Compiled) {
    let code = Code::compile(&compiled.program).unwrap_or_else(|error| panic!("{name}: {error}"));
    let Some(root) = &compiled.root else { return };
    let mut machine = Machine::new(Arc::new(code));
    let variables = root.variables.iter().chain(&compiled.globals);
    let checks: Vec<_> = variables
        .filter(|of| of.name == "fail" || of.name.ends_with(".fail"))
        .map(|of| (&of.name, of.offset))
        .collect();
    for call in 0..if checks.is_empty() { 1 } else { CALLS } {
        machine.call(root.cycle, call * 100_000_000).unwrap_or_else(|stop| panic!("{name}: {stop}"));
        for (path, offset) in &checks {
            assert_eq!(machine.get(Scalar::I16, *offset), Value::from(0i16), "{name}: {path} after call {}", call + 1);
        }
    }
}

#[test]
fn programs_from_tia_portal_compile_or_say_why_not() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tia");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for file in &files {
        let source = Source::read(file, None).unwrap();
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let refused: Vec<(usize, String)> = source
            .text
            .lines()
            .filter_map(|line| line.strip_prefix("// refused: ")?.split_once(": "))
            .map(|(line, text)| (line.parse().unwrap(), text.to_string()))
            .collect();
        let lacks = source.text.starts_with("// lacks");
        let errors: Vec<(usize, String)> = match compile(std::slice::from_ref(&source), &Options::default()) {
            Ok(compiled) => {
                run(&name, &compiled);
                Vec::new()
            }
            Err(errors) => errors
                .into_iter()
                .flat_map(|of_file| of_file.problems)
                .map(|problem| (problem.place.expect("an error has a place").line, problem.message))
                .collect(),
        };
        if lacks {
            let others: Vec<_> =
                errors.iter().filter(|(_, text)| !LACKS.iter().any(|lack| text.contains(lack))).collect();
            assert!(others.is_empty() && !errors.is_empty(), "{name}: {others:?}");
            continue;
        }
        for (line, text) in &refused {
            assert!(
                errors.iter().any(|(at, error)| at == line && error.contains(text)),
                "{name}:{line}: {text}: {errors:#?}"
            );
        }
        let others: Vec<_> = errors.iter().filter(|(at, _)| refused.iter().all(|(line, _)| line != at)).collect();
        assert!(others.is_empty(), "{name}: {others:#?}");
    }
    assert!(files.len() >= 100, "the folder has {} programs", files.len());
}
