//! `plcfmu prove`: writes a source that compares a PLC's own block with plcfmu's, and reports the result.

use super::{print, replacing};
use crate::exit::{Differs, Unreadable};
use crate::parameter_file::is_plc;
use crate::tell;
use anyhow::{Context, Result, anyhow, bail, ensure};
use host::package::temporary;
use scl::Dialect;
use scl::prove::{self, MOST_CALLS, Names, Outcome, RESULT_BYTES, State, Tape};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Write a source that compares a PLC's own block with plcfmu's, call by call, and read the result
///
/// The source contains a tape of inputs with the expected bits of each output, and a function block that makes one call
/// per cycle of the PLC, or of PLCSIM, and stops at the first difference. --read reports the result.
#[derive(clap::Args, Clone, Debug)]
#[command(
    override_usage = "plcfmu prove BLOCK --out FILE.scl [--calls N] [--seed N] [--dialect tia|step7] [--block NAME] [--number N]\n       \
                      plcfmu prove --read FILE.bin|s7://HOST/RACK/SLOT/DBn"
)]
pub struct Options {
    /// The block of plcfmu that serves as the reference
    #[arg(value_name = "BLOCK", required_unless_present = "read", conflicts_with = "read", value_parser = block())]
    name: Option<String>,
    /// The source to write
    #[arg(short, long, value_name = "FILE.scl", required_unless_present = "read", conflicts_with = "read")]
    out: Option<PathBuf>,
    /// Number of calls on the tape, one per PLC cycle
    #[arg(long, value_name = "N", default_value_t = 5000, value_parser = clap::value_parser!(u32).range(1..=MOST_CALLS as i64))]
    calls: u32,
    /// Seed of the tape: each number gives a different tape
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,
    /// The compiler that reads the source: TIA Portal, or STEP 7 V5 with S7-SCL
    #[arg(long, value_enum, default_value_t = Compiler::Tia)]
    dialect: Compiler,
    /// The PLC's own block, if it is not from the vendor's library: FB200, or its name
    #[arg(long, value_name = "NAME")]
    block: Option<String>,
    /// STEP 7: the number of the function block and of the first data block in the source
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u16).range(1..=16000))]
    number: u16,
    /// Report the result: its data block as bytes, or its address in the PLC, which is only read
    #[arg(long, value_name = "FILE.bin|s7://...")]
    read: Option<String>,
}

/// The compiler that reads the source.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Compiler {
    /// TIA Portal
    Tia,
    /// STEP 7 V5 with S7-SCL
    Step7,
}

fn block() -> clap::builder::PossibleValuesParser {
    clap::builder::PossibleValuesParser::new(prove::blocks())
}

/// Writes a source, or reports the result from a PLC.
///
/// # Errors
/// A file cannot be written or read; [`Differs`] if the PLC found a difference.
pub fn run(options: &Options) -> Result<()> {
    match &options.read {
        Some(from) => read(from),
        None => write(options),
    }
}

fn write(options: &Options) -> Result<()> {
    let (Some(name), Some(out)) = (&options.name, &options.out) else { bail!("BLOCK and --out are missing") };
    let dialect = match options.dialect {
        Compiler::Tia => Dialect::Tia,
        Compiler::Step7 => Dialect::Step7,
    };
    let tape = Tape::new(name, options.calls as usize, options.seed);
    let tape = tape.with_context(|| format!("no block {name}"))?;
    let own = options.block.clone().map(|block| Names { block, first: options.number });
    let names = own.or_else(|| Names::new(&tape, dialect).map(|names| Names { first: options.number, ..names }));
    let names = names.with_context(|| {
        format!("the STEP 7 libraries have no {name}: specify your project's function block, as in --block FB200")
    })?;
    let source = prove::print(&tape, &names, dialect);
    replacing(out, || temporary::place(out, |file| Ok(file.write_all(source.as_bytes())?), |_| Ok(())))?;
    let (bytes, blocks) = tape.size(dialect);
    let kilobytes = |bytes: usize| format!("{} KB", bytes.div_ceil(1024));
    let seconds = tape.calls as f64 / 100.0;
    let mut text = format!("{}: {} calls of {}, {}\n", out.display(), tape.calls, names.block, kilobytes(source.len()));
    text += &format!(
        "tape     {} of load memory and the same amount of work memory, in {blocks} data block{} of at most {}\n",
        kilobytes(bytes),
        if blocks == 1 { "" } else { "s" },
        kilobytes(bytes.min(prove::largest(dialect)))
    );
    text += &format!("cycles   {}: {seconds} s at a cycle time of 10 ms\n", tape.calls);
    text += &format!("call     {} once per cycle\n", prove::call(&tape, &names, dialect));
    text += &format!("result   {}\n", prove::result(&tape, &names, dialect));
    print(&text)
}

fn read(from: &str) -> Result<()> {
    let bytes = result(from).map_err(|error| Unreadable(error.context(from.to_string())))?;
    let outcome = Outcome::read(&bytes).map_err(|error| Unreadable(anyhow!("{from}: {error}")))?;
    let tape = outcome.tape();
    if tape.is_none() {
        tell::remark(&format!(
            "this version of plcfmu generates a different tape for {} calls and seed {}: names and inputs are unknown",
            outcome.calls, outcome.seed
        ));
    }
    let mut text = format!("{}\n", outcome.text(tape.as_ref()));
    if let (State::Differs { .. }, Some(tape)) = (outcome.state, &tape) {
        text += "inputs of this call:\n";
        for (name, value) in tape.inputs_of(outcome.done as usize) {
            text += &format!("  {name} {value}\n");
        }
    }
    print(&text)?;
    match outcome.state {
        State::Complete => Ok(()),
        State::Differs { .. } => Err(Differs.into()),
        State::Running => bail!("the PLC has not yet made all calls: read it again later"),
    }
}

/// The content of the result's data block, from a file or a PLC.
fn result(from: &str) -> Result<Vec<u8>> {
    if is_plc(from) {
        return of_plc(from);
    }
    let bytes = std::fs::read(Path::new(from))?;
    ensure!(!bytes.is_empty(), "the file is empty");
    Ok(bytes)
}

#[cfg(feature = "s7")]
fn of_plc(from: &str) -> Result<Vec<u8>> {
    crate::plc::fetch_bytes(&from.parse()?, RESULT_BYTES)
}

#[cfg(not(feature = "s7"))]
fn of_plc(_: &str) -> Result<Vec<u8>> {
    bail!("this build of plcfmu cannot read the {RESULT_BYTES} bytes from a PLC: rebuild it with the feature s7")
}
