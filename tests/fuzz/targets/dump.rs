//! Reads any bytes as a dump of each block; the first byte is the offset.

#![no_main]

mod round_trip;

use libfuzzer_sys::fuzz_target;
use parameters::{Block, Format, Options, Source, read, write};

fuzz_target!(|bytes: &[u8]| {
    let Some((offset, dump)) = bytes.split_first() else { return };
    for block in Block::all() {
        let options = Options { block: Some(block.name.clone()), ..Options::default() };
        round_trip::check(Format::Dump, dump, &options);
        let there = Options { offset: usize::from(*offset), ..options.clone() };
        if let Ok(reading) = read(Format::Dump, &Source::new("plant", dump.to_vec()), &Block::all(), &there) {
            let written = write(Format::Dump, &reading.loops, "fuzz").expect("a dump was read");
            round_trip::check(Format::Dump, &written, &options);
        }
    }
});
