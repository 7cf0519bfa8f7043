//! Prints a law as C: `cargo run -p laws --example print CONT_C`.

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).ok_or("which block?")?;
    let law = laws::read_whole(&laws::Sources::of_blocks(), &name)?;
    print!("{}", scl::c::print(&law.program)?);
    Ok(())
}
