//! Parameter files of a PLC, and other sources of a loop's values.

use crate::exit::{Unreadable, Wrong};
use crate::package::apart;
#[cfg(feature = "s7")]
use crate::{plc, progress::Progress};
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use blocks::Value;
use host::child::Starter;
use host::package::Package;
use modeldescription::Description;
use parameters::{BlockType, Format, Loop, Options, Origin, Problems, Reading, Source};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The time limit for loading an FMU's library and reading the description of its block.
const LOADING: Duration = Duration::from_secs(60);

/// Reads the loops of a file: a parameter file, whose extension selects the format if none is given and whose encoding
/// is detected as in [`Source::new`]; an FMU, whose start values form one loop; or a data block of a PLC,
/// `s7://HOST/RACK/SLOT/DBn`.
///
/// # Errors
/// The file cannot be read, or has problems; the error states all of them, with file, line and column.
pub fn read(
    name: &str,
    format: Option<Format>,
    encoding: Option<&str>,
    blocks: &[Arc<BlockType>],
    options: &Options,
) -> Result<Reading> {
    if is_plc(name) {
        return read_plc(name, blocks, options);
    }
    if format.is_none() && name.to_lowercase().ends_with(".fmu") {
        return read_fmu(name, blocks, options).map_err(|error| Unreadable(error.context(name.to_string())).into());
    }
    let format = match format {
        Some(format) => format,
        None => format_of(name)?,
    };
    let source = Source::read(Path::new(name), encoding).map_err(|error| Error::new(Unreadable(Error::msg(error))))?;
    parameters::read(format, &source, blocks, options).map_err(|problems| Error::new(Wrong(problems)))
}

/// Whether this is the address of a data block of a PLC rather than a file.
pub(crate) fn is_plc(name: &str) -> bool {
    name.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("s7://"))
}

/// Reads the data block of a PLC as a dump.
#[cfg(feature = "s7")]
fn read_plc(name: &str, blocks: &[Arc<BlockType>], options: &Options) -> Result<Reading> {
    let address: plc::Address = name.parse()?;
    let names = || blocks.iter().map(|block| block.name.as_str()).collect::<Vec<_>>().join(", ");
    let Some(block) = &options.block else {
        bail!(
            "{name}: a PLC does not state which block a data block belongs to: specify it with --block (available: {})",
            names()
        );
    };
    let block = blocks
        .iter()
        .find(|own| own.is_called(block))
        .with_context(|| format!("{name}: no block is called {block:?}; available: {}", names()))?;
    let progress = Progress::spinner(&format!("reading DB{} of {}", address.number, address.host));
    let bytes = plc::fetch(&address, block, options.offset)?;
    drop(progress);
    Ok(parameters::read(Format::Dump, &Source::new(name, bytes), blocks, options)?)
}

#[cfg(not(feature = "s7"))]
fn read_plc(name: &str, _blocks: &[Arc<BlockType>], _options: &Options) -> Result<Reading> {
    bail!("{name}: this build of plcfmu cannot read a PLC: rebuild it with the feature s7")
}

/// Reads the loops of a file as [`read`] does, for all blocks of the catalogue.
///
/// # Errors
/// As for [`read`].
pub fn read_any(name: &str, options: &Options) -> Result<Reading> {
    read(name, None, None, &BlockType::all(), options)
}

/// The format of a file, by its extension. Standard input needs an explicit format.
///
/// # Errors
/// No format has this extension, or the file is standard input.
pub fn format_of(name: &str) -> Result<Format> {
    ensure!(name != Source::STANDARD_INPUT, "standard input has no extension: specify its format with --format");
    Format::of_file(name).with_context(|| {
        let extensions: Vec<String> = Format::ALL
            .iter()
            .flat_map(|format| format.extensions())
            .map(|extension| format!(".{extension}"))
            .collect();
        format!("{name}: not a parameter file; its extension must be one of {}", extensions.join(", "))
    })
}

/// An FMU as a loop: its name and its start values.
fn read_fmu(name: &str, blocks: &[Arc<BlockType>], options: &Options) -> Result<Reading> {
    let description = Package::open(Path::new(name))?.description;
    let called = options.name.as_deref().unwrap_or(&description.model_name);
    let of_block = |block: &Arc<BlockType>| start_values(&description, block, called, name);
    let known = blocks.iter().filter(|block| is_of(&description, block)).find_map(|block| of_block(block).ok());
    let one = match known {
        Some(one) => one,
        None => of_block(&Arc::new(block_of_library(Path::new(name))?))?,
    };
    let remarks = Problems { file: name.to_string(), text: String::new(), problems: Vec::new() };
    Ok(Reading { loops: vec![one], wrong: remarks.clone(), remarks })
}

/// Whether an FMU has the name of this block.
pub(crate) fn is_of(description: &Description, block: &BlockType) -> bool {
    description.model_identifier() == Some(&block.name)
}

/// The start values of a block's FMU, as a loop read from `file`.
///
/// # Errors
/// The FMU lacks a start value, or has one that the block cannot have.
pub(crate) fn start_values(description: &Description, block: &Arc<BlockType>, name: &str, file: &str) -> Result<Loop> {
    let mut one = Loop::new(name, block.clone());
    for (index, value) in values(description, block)? {
        one.set(index, value, Origin::File { file: file.to_string() });
    }
    Ok(one)
}

/// The start values that an FMU declares for a block's inputs and parameters, by index of the block's member.
fn values(description: &Description, block: &BlockType) -> Result<Vec<(usize, Value)>> {
    let mut values = Vec::new();
    let places = description.places(block.members.iter().map(|of| (of.name.as_str(), (of.kind, of.role))));
    let settings = block.members.iter().zip(places).enumerate().filter(|(_, (member, _))| member.role.is_settable());
    for (index, (member, place)) in settings {
        let name = &member.name;
        let variable = place.map(|place| &description.variables[place]);
        let start = variable.map(|variable| variable.start_of(member.kind)).transpose();
        let shown = || variable.and_then(|variable| variable.start).unwrap_or_default();
        let start = start.map_err(|range| anyhow!("{name} starts at {:?}, but {range}", shown()))?.flatten();
        values.push((index, start.with_context(|| format!("the FMU has no start value for {name}"))?));
    }
    Ok(values)
}

/// The block of an FMU made with `fmu::export!`, from the table in its library for this machine, which is loaded in a
/// separate process. For the FMU of a program, the block is derived from the sources in the FMU instead.
///
/// # Errors
/// The FMU cannot be loaded here, ends its process, or was not made with `fmu::export!`.
pub fn block_of_library(path: &Path) -> Result<BlockType> {
    let interface = match crate::package::program::interface_of(&mut Package::open(path)?)? {
        Some(interface) => interface,
        None => apart::interface(&Starter { limit: LOADING, ..Starter::new()? }, path)?,
    };
    Ok(BlockType::from(&interface.table))
}

/// Rejects a PLC as the target.
///
/// # Errors
/// The target is a PLC.
pub fn check_target(target: &str) -> Result<()> {
    if is_plc(target) {
        bail!(
            "{target}: plcfmu never writes to a PLC: write a source, such as plant.awl, and load it with the engineering tool"
        );
    }
    Ok(())
}
