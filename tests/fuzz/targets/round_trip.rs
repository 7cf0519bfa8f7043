//! What the targets of the parameter files have in common.

use parameters::{Block, Format, Loop, Options, Source, literal, problem, read, write};

/// Names, blocks and values; as literals, because a negative zero equals a positive one.
fn content(loops: &[Loop]) -> Vec<(&str, &str, Vec<String>)> {
    let values = |one: &Loop| one.settings.iter().map(|setting| literal::text(setting.value)).collect();
    loops.iter().map(|one| (one.name.as_str(), one.block.name.as_str(), values(one))).collect()
}

/// Reads any bytes: loops or problems, and loops that were read are written and read again as the same.
pub fn check(format: Format, bytes: &[u8], options: &Options) {
    let blocks = Block::all();
    match read(format, &Source::new("plant", bytes.to_vec()), &blocks, options) {
        Ok(reading) => {
            assert!(!reading.loops.is_empty());
            problem::drawn(&reading.remarks);
            // Not every name and not every value can be written.
            let Ok(written) = write(format, &reading.loops, "fuzz") else { return };
            let source = Source::new("plant", written);
            let again = read(format, &source, &blocks, options)
                .unwrap_or_else(|problems| panic!("{problems}\n{}", source.text));
            assert_eq!(content(&again.loops), content(&reading.loops), "{}", source.text);
        }
        Err(problems) => {
            assert!(!problems.problems.is_empty());
            assert!(problem::drawn(&problems).len() < 50_000, "{problems}");
        }
    }
}
