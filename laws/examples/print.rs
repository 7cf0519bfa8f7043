//! Prints a law as C: `cargo run -p laws --example print CONT_C`; that of a block of your own with the files that have it:
//! `cargo run -p laws --example print PUMP pump/src/lib.rs`.

use laws::Sources;
use std::env::args;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = args().nth(1).ok_or("which block?")?;
    let mut sources = Sources::of_blocks();
    for file in args().skip(2) {
        sources.add(&file, std::fs::read_to_string(&file)?);
    }
    let law = laws::read_whole(&sources, &name)?;
    print!("{}", scl::c::print(&law.program)?);
    Ok(())
}
