//! Prints a law as C: `cargo run -p laws --example print CONT_C`, or as SCL with `tia` or `step7` after the name. For
//! the law of your own block, add its source files: `cargo run -p laws --example print PUMP pump/src/lib.rs`.

use laws::Sources;
use scl::Dialect;
use std::env::args;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = args().nth(1).ok_or("specify the name of a block")?;
    let mut sources = Sources::of_blocks();
    let mut dialect = None;
    for argument in args().skip(2) {
        match argument.as_str() {
            "tia" => dialect = Some(Dialect::Tia),
            "step7" => dialect = Some(Dialect::Step7),
            file => sources.add(file, std::fs::read_to_string(file)?),
        }
    }
    let law = laws::read_whole(&sources, &name)?;
    match dialect {
        Some(dialect) => print!("{}", law.scl(dialect)?),
        None => print!("{}", scl::c::print(&law.program)?),
    }
    Ok(())
}
