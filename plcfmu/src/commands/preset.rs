//! `plcfmu preset`: FMUs with the start values of somebody's loops.

use super::{params, print};
use crate::package::preset::{Original, Preset, identifier};
use crate::parameter_file;
use anyhow::{Context, Result, anyhow, bail, ensure};
use blocks::table::number::to_value;
use host::package::{Package, temporary};
use parameters::{Block, Format, Loop, Origin};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Make FMUs that start from the parameters of a PLC project
///
/// A preset is an FMU whose start values are those of a loop: a simulation that sets nothing runs with the plant's parameters. It
/// needs no compiler, and the library stays as it is. An FMU of a preset refuses to start if its resources/start.txt was
/// changed by hand; `plcfmu check` finds any change.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(after_help = HELP)]
pub struct Options {
    /// The FMUs of the loops' blocks, or folders with FMUs
    #[arg(value_name = "FILE.fmu|FOLDER", required = true)]
    files: Vec<PathBuf>,
    /// The file with the parameters; `plcfmu params` shows what is in it
    #[arg(long, value_name = "FILE", required_unless_present = "set")]
    from: Option<String>,
    /// Only the loop with this name; may be repeated [default: all loops of the file]
    #[arg(long = "loop", value_name = "NAME", requires = "from")]
    loops: Vec<String>,
    /// Give an input or a parameter another value, over that of the file; TIME in seconds; may be repeated
    #[arg(short, long, value_name = "VARIABLE=VALUE", value_parser = setting, allow_hyphen_values = true)]
    set: Vec<(String, f64)>,
    /// The block of the loops, where the file does not say it: its name, or FB 41 and the like
    #[arg(long, requires = "from")]
    block: Option<String>,
    /// Where the instance begins in a dump, in bytes
    #[arg(long, default_value_t = 0)]
    offset: usize,
    /// The format of the file with the parameters, if its extension does not say it: awl, scl, db, xml, bin, json, ssv
    #[arg(long, value_parser = params::format, requires = "from")]
    format: Option<Format>,
    /// The encoding of a text, such as windows-1251, if it is neither UTF-8 nor UTF-16 nor windows-1252
    #[arg(long, requires = "from")]
    encoding: Option<String>,
    /// The FMU to write, for one loop
    #[arg(short, long, value_name = "FILE.fmu", conflicts_with = "out_dir")]
    out: Option<PathBuf>,
    /// The folder to write to; each FMU has the name of its loop [default: the current folder]
    #[arg(long, value_name = "FOLDER")]
    out_dir: Option<PathBuf>,
}

const HELP: &str = "\
Examples:
  plcfmu preset PID.fmu --from plant.awl --loop TIC101 -o TIC101.fmu
  plcfmu preset fmus/ --from plant.awl --out-dir presets
  plcfmu preset PID.fmu --set GAIN=2.5 --set CYCLE=0.1 -o FAST.fmu";

/// An argument `VARIABLE=VALUE`; a BOOL may be true or false.
fn setting(argument: &str) -> Result<(String, f64)> {
    let (name, value) = argument.split_once('=').context("give it as VARIABLE=VALUE, such as GAIN=2.5")?;
    let value = match value.to_lowercase().as_str() {
        "true" => 1.0,
        "false" => 0.0,
        number => number.parse().map_err(|_| anyhow!("{value:?} is not a number, true or false"))?,
    };
    Ok((name.to_string(), value))
}

/// An FMU of which presets may be made, and where it is.
struct Fmu {
    path: PathBuf,
    original: Original<BufReader<File>>,
}

/// A preset, where it goes, and what is to be said of it.
struct Made {
    preset: Preset,
    block: String,
    path: PathBuf,
    advice: Vec<String>,
}

/// Makes presets.
///
/// # Errors
/// What is wrong with the parameters or an FMU, or a loop for whose block there is no FMU. Nothing is written then.
pub fn run(options: &Options) -> Result<()> {
    let mut loops = read(options, &blocks(options)?)?;
    let mut fmus = open(&options.files)?;
    ensure!(
        options.out.is_none() || loops.len() == 1,
        "-o names one FMU, but there are {} loops: choose one with --loop, or give --out-dir",
        loops.len()
    );
    for values in &mut loops {
        set(values, &options.set)?;
    }
    let made = make(&mut fmus, &loops, options)?;
    let inputs = fmus.iter().map(|fmu| fmu.path.as_path()).chain(options.from.as_deref().map(Path::new));
    temporary::check_outputs(made.iter().map(|made| made.path.as_path()), inputs)?;
    for Made { preset, block, path, advice } in &made {
        place(preset, path)?;
        let Preset { name, guid, .. } = preset;
        print(&format!("{name}  {block}  {guid}  {}\n", path.display()))?;
        for warning in advice {
            eprintln!("warning: {name}: {warning}");
        }
    }
    Ok(())
}

/// The blocks that a parameter file may have: those that are known, and what the FMUs that are named say of theirs.
fn blocks(options: &Options) -> Result<Vec<Arc<Block>>> {
    let mut blocks = Block::all();
    for file in options.files.iter().filter(|file| !file.is_dir()) {
        let block = Original::open(file).with_context(|| file.display().to_string())?.block;
        if !blocks.iter().any(|known| known.name == block) {
            let block = parameter_file::block_of_library(file).with_context(|| file.display().to_string())?;
            blocks.push(Arc::new(block));
        }
    }
    Ok(blocks)
}

/// The loops that presets are made of.
fn read(options: &Options, blocks: &[Arc<Block>]) -> Result<Vec<Loop>> {
    let of_file = parameters::Options {
        block: options.block.clone(),
        name: match options.loops.as_slice() {
            [name] => Some(name.clone()),
            _ => None,
        },
        offset: options.offset,
        ..parameters::Options::default()
    };
    let Some(from) = &options.from else { return own(options, blocks) };
    params::loops(from, options.format, options.encoding.as_deref(), blocks, &of_file, &options.loops)
}

/// The present start values of the one FMU, as a loop named after the file to write.
fn own(options: &Options, blocks: &[Arc<Block>]) -> Result<Vec<Loop>> {
    let name = options.out.as_deref().and_then(Path::file_stem);
    let name = name.context("give the FMU to write with -o: the preset gets its name")?.to_string_lossy().into_owned();
    let [file] = options.files.as_slice() else {
        bail!("without --from, a preset is made of one FMU, not of {}", options.files.len());
    };
    let named = parameters::Options { name: Some(name), ..parameters::Options::default() };
    Ok(parameter_file::read(&file.display().to_string(), None, None, blocks, &named)?.loops)
}

/// Gives variables of a loop other values.
fn set(values: &mut Loop, settings: &[(String, f64)]) -> Result<()> {
    for (name, number) in settings {
        let block = values.block.clone();
        let member = block.find(name).filter(|member| block.members[*member].role.is_settable());
        let member = member.with_context(|| format!("{} has no input or parameter {name}", block.name))?;
        let value = to_value(*number, block.members[member].kind);
        let value = value.map_err(|why| anyhow!("{} = {number}: {why}", block.members[member].name))?;
        values.set(member, value, Origin::File { file: "command line".into() });
    }
    Ok(())
}

/// Opens the FMUs that are named, and those in folders that are named. In a folder, presets are passed over.
fn open(files: &[PathBuf]) -> Result<Vec<Fmu>> {
    let mut fmus = Vec::new();
    for file in files {
        let shown = || file.display().to_string();
        if !file.is_dir() {
            fmus.push(Fmu { path: file.clone(), original: Original::open(file).with_context(shown)? });
            continue;
        }
        let entries = std::fs::read_dir(file).and_then(Iterator::collect::<Result<Vec<_>, _>>).with_context(shown)?;
        let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
        paths.retain(|path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fmu")));
        ensure!(!paths.is_empty(), "{} has no FMUs", shown());
        paths.sort();
        for path in paths {
            let original = Original::open(&path).with_context(|| path.display().to_string())?;
            if !original.is_preset {
                fmus.push(Fmu { path, original });
            }
        }
    }
    Ok(fmus)
}

/// Makes all presets before any is written.
fn make(fmus: &mut [Fmu], loops: &[Loop], options: &Options) -> Result<Vec<Made>> {
    check_blocks(fmus, loops)?;
    let folder = options.out_dir.clone().unwrap_or_default();
    let mut made: Vec<Made> = Vec::new();
    let mut names: BTreeMap<String, &str> = BTreeMap::new();
    for values in loops {
        let identifier = identifier(&values.name);
        // Case does not count on Windows and macOS.
        if let Some(other) = names.insert(identifier.to_lowercase(), &values.name) {
            bail!(
                "the loops {other:?} and {:?} would both be written as {identifier}.fmu: make one with --loop and -o",
                values.name
            );
        }
        let path = options.out.clone().unwrap_or_else(|| folder.join(format!("{identifier}.fmu")));
        let Some(fmu) = fmus.iter_mut().find(|fmu| fmu.original.block == values.block.name) else { continue };
        let preset = fmu.original.preset(values);
        let preset = preset.with_context(|| format!("{} as preset {:?}", fmu.path.display(), values.name))?;
        made.push(Made { preset, block: values.block.name.clone(), path, advice: values.warnings() });
    }
    Ok(made)
}

/// Refuses loops for whose block there is no FMU, or more than one.
fn check_blocks(fmus: &[Fmu], loops: &[Loop]) -> Result<()> {
    let of = |block: &str| -> Vec<&Fmu> { fmus.iter().filter(|fmu| fmu.original.block == block).collect() };
    let mut missing: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for values in loops {
        match of(&values.block.name).as_slice() {
            [] => missing.entry(&values.block.name).or_default().push(&values.name),
            [_] => {}
            [first, second, ..] => bail!(
                "{} and {} are both FMUs of {}: name the one that {} shall be made of",
                first.path.display(),
                second.path.display(),
                values.block.name,
                values.name
            ),
        }
    }
    let missing: Vec<String> =
        missing.into_iter().map(|(block, loops)| format!("{block} (of {})", loops.join(", "))).collect();
    ensure!(missing.is_empty(), "there is no FMU of {}: name it, or its folder", missing.join(" and of "));
    Ok(())
}

/// Writes a preset, if it reads back as it should.
fn place(preset: &Preset, path: &Path) -> Result<()> {
    temporary::place(
        path,
        |file| Ok(file.write_all(&preset.bytes)?),
        |path| {
            let mut package = Package::open(path)?;
            let start = crate::package::preset::start(&mut package)?;
            ensure!(start.is_some(), "its start values are missing");
            Ok(())
        },
    )
}
