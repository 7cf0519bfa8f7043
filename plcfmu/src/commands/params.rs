//! `plcfmu params`: shows, converts and compares the values of PLC parameter files.

use super::loops::Arguments;
use super::{aligned, print, replacing, told_once};
use crate::exit::Differs;
use crate::parameter_file::{check_target, format_of};
use crate::tell::{self, plain};
use anyhow::{Context, Error, Result, bail};
use blocks::Value;
use blocks::table::number::number;
use host::package::temporary;
use parameters::{BlockType, Format, Loop, MemberValue, decimal};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Show, convert and compare the parameters of control loops
///
/// A TIME is in seconds. A loop that cannot be read does not affect the others, but the exit code is 3.
///
/// By design, nothing is ever written to a PLC: write a source with --out, and load it with the engineering tool.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    #[allow(missing_docs)]
    #[command(flatten)]
    pub loops: Arguments,
    /// Write the loops to this file; its extension selects the format
    #[arg(short, long, value_name = "FILE", conflicts_with = "diff")]
    pub out: Option<String>,
    /// Show only the differences from this file; exit code 1 if there are any
    #[arg(long, value_name = "OTHER")]
    pub diff: Option<String>,
    /// The offset of the instance in OTHER, in bytes
    #[arg(long, value_name = "BYTES", requires = "diff", allow_negative_numbers = true)]
    pub diff_offset: Option<usize>,
    /// Print the loops, or the differences, as JSON, for scripts
    #[arg(long, conflicts_with = "out")]
    pub json: bool,
}

/// Shows, converts or compares the loops, depending on the options.
///
/// # Errors
/// A file or a loop cannot be read; the requested output cannot be written; [`Differs`].
pub fn run(options: &Options) -> Result<()> {
    let blocks = options.loops.blocks()?;
    let mut found = options.loops.read(&blocks)?;
    let loops = std::mem::take(&mut found.loops);
    if let Some(other) = &options.diff {
        found.finish()?;
        return compare(options, other, &loops, &blocks);
    }
    if loops.is_empty() {
        return found.finish();
    }
    if let Some(target) = &options.out {
        write(target, options, &loops)?;
    } else if options.json {
        let json = parameters::write(Format::Json, &loops, "").map_err(Error::msg)?;
        print(&String::from_utf8_lossy(&json))?;
    } else {
        print(&table(&loops))?;
    }
    let warnings = loops.iter().flat_map(|one| one.warnings().into_iter().map(|text| (one.name.clone(), text)));
    for warning in told_once(warnings) {
        tell::warning(&warning);
    }
    found.finish()
}

/// Compares the loops with those of another file.
fn compare(options: &Options, other: &str, before: &[Loop], blocks: &[Arc<BlockType>]) -> Result<()> {
    let arguments =
        Arguments { files: vec![other.into()], offset: options.diff_offset, format: None, ..options.loops.clone() };
    let mut found = arguments.read(blocks)?;
    let after = std::mem::take(&mut found.loops);
    found.finish()?;
    let differences = differences((&options.loops.files.join(", "), before), (other, &after))?;
    if options.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&differences)?))?;
    } else {
        print(&differences.text())?;
    }
    if differences.is_empty() { Ok(()) } else { Err(Error::new(Differs)) }
}

/// Writes the loops to a temporary file, and renames it to the target.
fn write(target: &str, options: &Options, loops: &[Loop]) -> Result<()> {
    check_target(target)?;
    let Arguments { files, fmus, .. } = &options.loops;
    let file = Path::new(target);
    temporary::check_outputs(
        [file],
        fmus.iter().map(PathBuf::as_path).chain(files.iter().map(|file| Path::new(file.as_str()))),
    )?;
    let format = format_of(target)?;
    let origin = format!("Made by plcfmu {} from {}", env!("CARGO_PKG_VERSION"), files.join(", "));
    let bytes = parameters::write(format, loops, &origin).map_err(|error| anyhow::anyhow!("{target}: {error}"))?;
    replacing(file, || temporary::place(file, |to| to.write_all(&bytes).context("writing"), |_| Ok(())))?;
    if format == Format::Dump {
        tell::remark(&format!(
            "{target}: outputs are 0; the block's internal memory, which follows them, is unknown and left out"
        ));
    }
    let values: usize = loops.iter().map(|one| one.settings.len()).sum();
    let plural = if loops.len() == 1 { "" } else { "s" };
    print(&format!("{target}: {} loop{plural}, {values} values\n", loops.len()))
}

/// All values, one per line.
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

/// The differences between two files, as printed by `--json`.
#[derive(Debug, Default, Serialize)]
struct Differences {
    /// Values that differ in any bit.
    differences: Vec<Difference>,
    /// Loops in only one of the files.
    only_in: Vec<Alone>,
}

/// A value that differs.
#[derive(Debug, Serialize)]
struct Difference {
    #[serde(rename = "loop")]
    of: String,
    parameter: String,
    before: String,
    after: String,
    unit: Option<String>,
}

/// A loop missing from the other file.
#[derive(Debug, Serialize)]
struct Alone {
    #[serde(rename = "loop")]
    of: String,
    file: String,
}

impl Differences {
    fn is_empty(&self) -> bool {
        self.differences.is_empty() && self.only_in.is_empty()
    }

    /// The differences as text, one per line.
    fn text(&self) -> String {
        let mut rows = vec![["Loop", "Parameter", "Before", "After", "Unit"].map(str::to_string)];
        for Difference { of, parameter, before, after, unit } in &self.differences {
            rows.push([of.clone(), parameter.clone(), before.clone(), after.clone(), unit.clone().unwrap_or_default()]);
        }
        let alone = self.only_in.iter().map(|Alone { of, file }| plain(&format!("{of} is only in {file}\n")));
        let table = match rows.len() {
            1 if self.is_empty() => "no differences\n".to_string(),
            1 => String::new(),
            _ => aligned(&rows),
        };
        table + &alone.collect::<String>()
    }
}

/// Finds the differences between the loops of two files, each given with its name.
fn differences(before: (&str, &[Loop]), after: (&str, &[Loop])) -> Result<Differences> {
    let mut all = Differences::default();
    let mut pairs = Vec::new();
    if let ([one], [other]) = (before.1, after.1) {
        // Single loops are compared regardless of their names: a file with one loop may leave it unnamed.
        pairs.push((one, other));
    } else {
        let find = |loops: &'_ [Loop], name: &str| loops.iter().position(|one| one.name.eq_ignore_ascii_case(name));
        let alone = |one: &Loop, file: &str| Alone { of: one.name.clone(), file: file.into() };
        for one in before.1 {
            match find(after.1, &one.name) {
                Some(other) => pairs.push((one, &after.1[other])),
                None => all.only_in.push(alone(one, before.0)),
            }
        }
        let only_after = after.1.iter().filter(|one| find(before.1, &one.name).is_none());
        all.only_in.extend(only_after.map(|one| alone(one, after.0)));
    }
    for (one, other) in pairs {
        if one.block != other.block {
            let (name, block, other) = (&one.name, &one.block.name, &other.block.name);
            bail!("{name} is a {block} in {}, but a {other} in {}", before.0, after.0);
        }
        let changed = |(one, other): &(&MemberValue, &MemberValue)| !is_same(one.value, other.value);
        for (was, is) in one.settings.iter().zip(&other.settings).filter(changed) {
            let member = &one.block.members[was.member];
            all.differences.push(Difference {
                of: one.name.clone(),
                parameter: member.name.clone(),
                before: decimal(was.value),
                after: decimal(is.value),
                unit: member.shown_unit().map(str::to_string),
            });
        }
    }
    Ok(all)
}

/// Whether two values have the same kind and the same bits.
fn is_same(one: Value, other: Value) -> bool {
    one.kind() == other.kind() && number(one).to_bits() == number(other).to_bits()
}
