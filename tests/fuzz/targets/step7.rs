//! Reads any bytes as a PLC source text: loops or problems, and loops that were read are written and read again as the same.

#![no_main]

use libfuzzer_sys::fuzz_target;
use parameters::{Block, Format, Loop, Options, Source, literal, problem, read, write};

/// Names, blocks and values; as literals, because a negative zero equals a positive one.
fn content(loops: &[Loop]) -> Vec<(&str, &str, Vec<String>)> {
    let values = |one: &Loop| one.settings.iter().map(|setting| literal::text(setting.value)).collect();
    loops.iter().map(|one| (one.name.as_str(), one.block.name.as_str(), values(one))).collect()
}

fuzz_target!(|bytes: &[u8]| {
    let blocks = Block::all();
    let options = Options::default();
    let source = Source::new("plant.awl", bytes.to_vec());
    match read(Format::Step7, &source, &blocks, &options) {
        Ok(reading) => {
            assert!(!reading.loops.is_empty());
            problem::drawn(&reading.remarks);
            for format in [Format::Step7, Format::Tia] {
                // Names may be too long, or have characters that the format does not have.
                let Ok(text) = write(format, &reading.loops, "fuzz") else { continue };
                let source = Source::new("plant", text);
                let again = read(format, &source, &blocks, &options)
                    .unwrap_or_else(|problems| panic!("{problems}\n{}", source.text));
                assert_eq!(content(&again.loops), content(&reading.loops), "{}", source.text);
            }
        }
        Err(problems) => {
            assert!(!problems.problems.is_empty());
            assert!(problem::drawn(&problems).len() < 50_000, "{problems}");
        }
    }
});
