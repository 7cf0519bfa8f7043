//! `plcfmu params`: the values of a PLC's parameter files, shown, converted and compared.

use super::print;
use crate::parameter_file::{self, block_of_library, check_target, format_of};
use anyhow::{Context, Result, bail};
use blocks::Value;
use blocks::table::number::number;
use host::package::temporary;
use parameters::{Block, Format, Loop, Setting, decimal};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Show, convert and compare the parameters of control loops
///
/// Reads STEP 7 sources (.awl, .scl), TIA Portal sources (.db), TIA Openness XML (.xml), dumps of data blocks (.bin), JSON, SSV, and
/// the start values of an FMU. A TIME is in seconds.
///
/// s7://HOST/RACK/SLOT/DBn in place of a file reads a data block of an S7, such as s7://192.168.0.1/0/2/DB41, with --block. Nothing
/// is ever written to a PLC, on purpose: write a source text with --to, and load it with the engineering tool.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// The file, or the address of a data block in a PLC
    #[arg(value_name = "FILE")]
    pub file: String,
    /// The block of the loops, where the file does not say it: its name, or FB 41 and the like
    #[arg(long)]
    pub block: Option<String>,
    /// The loop: one of several, or the name of one to which the file gives none
    #[arg(long = "loop", value_name = "NAME")]
    pub name: Option<String>,
    /// Where the instance begins in a dump or a PLC's data block, in bytes
    #[arg(long, default_value_t = 0)]
    pub offset: usize,
    /// The format of FILE, if its extension does not say it: awl, scl, db, xml, bin, json, ssv
    #[arg(long, value_parser = format)]
    pub format: Option<Format>,
    /// The encoding of a text, such as windows-1251, if it is neither UTF-8 nor UTF-16 nor windows-1252
    #[arg(long)]
    pub encoding: Option<String>,
    /// Write the loops to this file; its extension selects the format
    #[arg(long, value_name = "FILE", conflicts_with = "diff")]
    pub to: Option<String>,
    /// Show only what is different in this file
    #[arg(long, value_name = "OTHER")]
    pub diff: Option<String>,
    /// Print the loops as JSON, for scripts
    #[arg(long, conflicts_with_all = ["to", "diff"])]
    pub json: bool,
    /// An FMU of your own whose block the file may contain; its library is loaded
    #[arg(long, value_name = "FILE.fmu")]
    pub fmu: Vec<PathBuf>,
}

/// The format with this extension.
pub(super) fn format(extension: &str) -> Result<Format, String> {
    Format::of_file(&format!(".{extension}")).ok_or_else(|| {
        let extensions: Vec<&str> = Format::ALL.iter().flat_map(|format| format.extensions()).copied().collect();
        format!("the formats are {}", extensions.join(", "))
    })
}

/// Shows, converts or compares.
///
/// # Errors
/// A file cannot be read, or all that is wrong with it; or what is asked for cannot be written.
pub fn run(options: &Options) -> Result<()> {
    let mut blocks = Vec::new();
    for path in &options.fmu {
        blocks.push(Arc::new(block_of_library(path)?));
    }
    blocks.extend(Block::all());
    let loops = read(&options.file, options.format, &blocks, options)?;
    if let Some(other) = &options.diff {
        let after = read(other, None, &blocks, options)?;
        return print(&differences((&options.file, &loops), (other, &after))?);
    }
    if let Some(target) = &options.to {
        write(target, options, &loops)?;
    } else if options.json {
        let json = parameters::write(Format::Json, &loops, "").map_err(|error| anyhow::anyhow!(error))?;
        print(&String::from_utf8_lossy(&json))?;
    } else {
        print(&table(&loops))?;
    }
    for one in &loops {
        for warning in one.warnings() {
            eprintln!("warning: {}: {warning}", one.name);
        }
    }
    Ok(())
}

/// The loops of a file that the user asked for.
fn read(file: &str, format: Option<Format>, blocks: &[Arc<Block>], options: &Options) -> Result<Vec<Loop>> {
    let of_file = parameters::Options {
        block: options.block.clone(),
        name: options.name.clone(),
        offset: options.offset,
        ..parameters::Options::default()
    };
    let encoding = options.encoding.as_deref();
    loops(file, format, encoding, blocks, &of_file, options.name.as_slice())
}

/// The loops of a file that have one of these names; all if there are no names. What is to be said of the file is printed.
pub(super) fn loops(
    file: &str,
    format: Option<Format>,
    encoding: Option<&str>,
    blocks: &[Arc<Block>],
    options: &parameters::Options,
    names: &[String],
) -> Result<Vec<Loop>> {
    let mut reading = parameter_file::read(file, format, encoding, blocks, options)?;
    for remark in run::file::remarks(&reading) {
        eprintln!("remark: {remark}");
    }
    let is_called = |one: &Loop, name: &String| one.name.eq_ignore_ascii_case(name);
    if let Some(missing) = names.iter().find(|name| !reading.loops.iter().any(|one| is_called(one, name))) {
        let all: Vec<&str> = reading.loops.iter().map(|one| one.name.as_str()).collect();
        bail!("{file} has no loop {missing}: it has {}", all.join(", "));
    }
    reading.loops.retain(|one| names.is_empty() || names.iter().any(|name| is_called(one, name)));
    Ok(reading.loops)
}

/// Writes the loops beside the file's place, and renames that.
fn write(target: &str, options: &Options, loops: &[Loop]) -> Result<()> {
    check_target(target)?;
    temporary::check_outputs(
        [Path::new(target)],
        options.fmu.iter().map(PathBuf::as_path).chain([Path::new(&options.file)]),
    )?;
    let format = format_of(target)?;
    let origin = format!("Made by plcfmu {} from {}", env!("CARGO_PKG_VERSION"), options.file);
    let bytes = parameters::write(format, loops, &origin).map_err(|error| anyhow::anyhow!("{target}: {error}"))?;
    temporary::place(Path::new(target), |file| file.write_all(&bytes).context("writing"), |_| Ok(()))?;
    if format == Format::Dump {
        eprintln!(
            "remark: {target}: outputs are 0, and the memory of the block behind them is not known and not there"
        );
    }
    let values: usize = loops.iter().map(|one| one.settings.len()).sum();
    let plural = if loops.len() == 1 { "" } else { "s" };
    print(&format!("{target}: {} loop{plural}, {values} values\n", loops.len()))
}

/// All values, a line each.
fn table(loops: &[Loop]) -> String {
    let head = ["Loop", "Block", "Parameter", "Value", "Unit", "Start", "Origin"];
    let mut rows = vec![head.map(str::to_string)];
    for one in loops {
        for setting in &one.settings {
            let member = &one.block.members[setting.member];
            rows.push([
                one.name.clone(),
                one.block.name.clone(),
                member.name.clone(),
                decimal(setting.value),
                member.shown_unit().unwrap_or_default().to_string(),
                decimal(member.start),
                setting.origin.to_string(),
            ]);
        }
    }
    aligned(&rows)
}

/// What is different, a line each.
fn differences(before: (&str, &[Loop]), after: (&str, &[Loop])) -> Result<String> {
    let mut rows = vec![["Loop", "Parameter", "Before", "After", "Unit"].map(str::to_string)];
    let mut alone = Vec::new();
    let mut pairs = Vec::new();
    if let ([one], [other]) = (before.1, after.1) {
        // A file that holds one loop may give it no name.
        pairs.push((one, other));
    } else {
        let find = |loops: &'_ [Loop], name: &str| loops.iter().position(|one| one.name.eq_ignore_ascii_case(name));
        for one in before.1 {
            match find(after.1, &one.name) {
                Some(other) => pairs.push((one, &after.1[other])),
                None => alone.push(format!("{} is only in {}\n", one.name, before.0)),
            }
        }
        let only_after = after.1.iter().filter(|one| find(before.1, &one.name).is_none());
        alone.extend(only_after.map(|one| format!("{} is only in {}\n", one.name, after.0)));
    }
    for (one, other) in pairs {
        if one.block != other.block {
            let (name, block, other) = (&one.name, &one.block.name, &other.block.name);
            bail!("{name} is a {block} in {} and a {other} in {}", before.0, after.0);
        }
        let changed = |(one, other): &(&Setting, &Setting)| !is_same(one.value, other.value);
        for (was, is) in one.settings.iter().zip(&other.settings).filter(changed) {
            let member = &one.block.members[was.member];
            let (was, is) = (decimal(was.value), decimal(is.value));
            rows.push([
                one.name.clone(),
                member.name.clone(),
                was,
                is,
                member.shown_unit().unwrap_or_default().to_string(),
            ]);
        }
    }
    let table = match rows.len() {
        1 if alone.is_empty() => "no differences\n".to_string(),
        1 => String::new(),
        _ => aligned(&rows),
    };
    Ok(table + &alone.concat())
}

/// Bit for bit.
fn is_same(one: Value, other: Value) -> bool {
    one.kind() == other.kind() && number(one).to_bits() == number(other).to_bits()
}

/// Rows of cells in columns as wide as their widest cell.
fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default();
    let widths: [usize; N] = std::array::from_fn(width);
    let mut text = String::new();
    for row in rows {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}
