//! Checks SCL sources: `cargo run -p scl --example check -- machine.scl types.udt`.

use parameters::{Source, problem::drawn};
use scl::machine::{Code, Machine};
use scl::{Options, compile};
use std::path::Path;
use std::sync::Arc;

fn main() {
    let read = |path: String| Source::read(Path::new(&path), None).unwrap_or_else(|error| panic!("{error}"));
    let sources: Vec<Source> = std::env::args().skip(1).map(read).collect();
    match compile(&sources, &Options::default()) {
        Ok(compiled) => {
            compiled.warnings.iter().for_each(|problems| print!("{}", drawn(problems)));
            // Every accepted program can be compiled for the machine.
            let code = Code::compile(&compiled.program).unwrap_or_else(|error| panic!("{error}"));
            let stop = compiled.root.and_then(|root| Machine::new(Arc::new(code)).call(root.cycle, 0).err());
            stop.iter().for_each(|stop| println!("the first call stops: {stop}"));
            println!("no errors");
        }
        Err(errors) => errors.iter().for_each(|problems| print!("{}", drawn(problems))),
    }
}
