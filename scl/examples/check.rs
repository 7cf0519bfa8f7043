//! Checks SCL sources: `cargo run -p scl --example check -- machine.scl types.udt`.

use parameters::{Source, problem::drawn};
use scl::{Options, compile};
use std::path::Path;

fn main() {
    let read = |path: String| Source::read(Path::new(&path), None).unwrap_or_else(|error| panic!("{error}"));
    let sources: Vec<Source> = std::env::args().skip(1).map(read).collect();
    match compile(&sources, &Options::default()) {
        Ok(compiled) => {
            compiled.warnings.iter().for_each(|problems| print!("{}", drawn(problems)));
            println!("no errors");
        }
        Err(errors) => errors.iter().for_each(|problems| print!("{}", drawn(problems))),
    }
}
