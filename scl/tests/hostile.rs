//! Damaged and hostile sources always result in a program or a list of errors.

#![allow(clippy::unwrap_used)]

use parameters::Source;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use scl::machine::{Code, Machine};
use scl::{Options, compile};
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// Returns the programs of the cases, including the examples, the hand-written ones, and those in the style of TIA
/// Portal.
fn programs() -> &'static [String] {
    static PROGRAMS: OnceLock<Vec<String>> = OnceLock::new();
    PROGRAMS.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
        let mut programs = Vec::new();
        for file in ["example_tank.json", "example_furnace.json", "example_conveyor.json", "hand.json"] {
            let json: serde_json::Value =
                serde_json::from_str(&std::fs::read_to_string(folder.join(file)).unwrap()).unwrap();
            let cases = json["cases"].as_array().cloned().unwrap_or_else(|| vec![json.clone()]);
            programs.extend(cases.iter().map(|case| case["scl"].as_str().unwrap().to_string()));
        }
        let mut files: Vec<_> =
            folder.parent().unwrap().join("tia").read_dir().unwrap().map(|file| file.unwrap().path()).collect();
        files.sort();
        programs.extend(files.iter().map(|file| std::fs::read_to_string(file).unwrap()));
        programs
    })
}

fn pick(index: prop::sample::Index) -> &'static str {
    &programs()[index.index(programs().len())]
}

/// Compiles the text and makes a call; every file reported must have an error.
fn try_it(text: &str) {
    match compile(&[Source::new("a.scl", text.into())], &Options::default()) {
        Ok(compiled) => {
            let code = Code::compile(&compiled.program).unwrap_or_else(|error| panic!("{error}\n{text}"));
            if let Some(root) = compiled.root {
                // The call may stop, with a reason.
                let _ = Machine::new(Arc::new(code)).call(root.cycle, 0);
            }
        }
        Err(errors) => assert!(errors.iter().all(|problems| !problems.problems.is_empty())),
    }
}

/// Splits a program into words with the separators after them.
fn words(text: &str) -> Vec<&str> {
    text.split_inclusive([' ', '\n', ';', '(', ')', ',', '.', '#', '[', ']']).collect()
}

#[test]
fn a_program_that_is_cut_anywhere_is_told() {
    for program in programs() {
        for end in (0..program.len()).step_by(499) {
            try_it(&program[..program.floor_char_boundary(end)]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 250, rng_seed: RngSeed::Fixed(22), ..ProptestConfig::default() })]

    #[test]
    fn a_program_with_words_of_another_is_told(
        one: prop::sample::Index,
        other: prop::sample::Index,
        places in prop::collection::vec((any::<prop::sample::Index>(), any::<prop::sample::Index>()), 1..6),
    ) {
        let (one, other) = (words(pick(one)), words(pick(other)));
        let mut mixed = one;
        for (to, from) in places {
            let to = to.index(mixed.len());
            mixed[to] = other[from.index(other.len())];
        }
        try_it(&mixed.concat());
    }

    #[test]
    fn a_program_with_words_left_out_or_twice_is_told(
        program: prop::sample::Index,
        places in prop::collection::vec((any::<prop::sample::Index>(), any::<bool>()), 1..6),
    ) {
        let mut words = words(pick(program));
        for (at, twice) in places {
            let at = at.index(words.len());
            if twice {
                words.insert(at, words[at]);
            } else if words.len() > 1 {
                words.remove(at);
            }
        }
        try_it(&words.concat());
    }

    #[test]
    fn a_program_with_bits_turned_over_is_told(
        program: prop::sample::Index,
        places in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u32), 1..9),
    ) {
        let mut bytes = pick(program).as_bytes().to_vec();
        for (at, bit) in places {
            let at = at.index(bytes.len());
            bytes[at] ^= 1 << bit;
        }
        // In a file, text that is not valid UTF-8 is read as Windows-1252.
        let source = Source::new("a.scl", bytes);
        try_it(&source.text);
    }
}
