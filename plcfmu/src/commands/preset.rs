//! `plcfmu preset`: makes FMUs with the start values of a project's loops.

use super::loops::{self, Arguments};
use super::{aligned, print, replacing, told_once};
use crate::exit::Unreadable;
use crate::interruption;
use crate::package::apart;
use crate::package::preset::{Original, Preset, identifier};
use crate::tell;
use anyhow::{Context, Result, anyhow, bail, ensure};
use host::child::Starter;
use host::machine::Fault;
use host::package::temporary::Pending;
use host::package::{Package, temporary};
use parameters::{Loop, Origin};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

/// Make FMUs that start from the parameters of a PLC project
///
/// A preset is an FMU that starts with the values of a loop: a simulation that sets nothing runs with the plant's
/// parameters. No compiler is needed, and the library stays unchanged. A preset refuses to start if its
/// resources/start.txt was edited; `plcfmu check` finds any change. Each preset is started once in a separate process:
/// if the FMU refuses one, nothing is written.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(after_help = HELP)]
pub struct Options {
    #[command(flatten)]
    loops: Arguments,
    /// Set an input or a parameter, overriding the file; a TIME is in seconds; may be repeated
    #[arg(short, long, value_name = "VARIABLE=VALUE", value_parser = setting, allow_hyphen_values = true)]
    set: Vec<(String, f64)>,
    /// The FMU to write, for one loop; or a folder, in which each FMU is named after its loop [default: the current
    /// folder]
    #[arg(short, long, value_name = "FILE.fmu|FOLDER")]
    out: Option<PathBuf>,
    /// Print the list of presets as JSON, for scripts
    #[arg(long)]
    json: bool,
}

const HELP: &str = "\
Examples:
  plcfmu preset plant.awl --fmus PID.fmu --loop TIC101 --out TIC101.fmu
  plcfmu preset plant.awl --fmus fmus --out presets
  plcfmu preset PID.fmu --set GAIN=2.5 --set CYCLE=0.1 --out FAST.fmu";

/// An argument `VARIABLE=VALUE`; a BOOL may be true or false.
fn setting(argument: &str) -> Result<(String, f64)> {
    let (name, value) = argument.split_once('=').context("write VARIABLE=VALUE, such as GAIN=2.5")?;
    let value = match value.to_lowercase().as_str() {
        "true" => 1.0,
        "false" => 0.0,
        number => number.parse().map_err(|_| anyhow!("{value:?} is not a number, true or false"))?,
    };
    Ok((name.to_string(), value))
}

/// An FMU from which presets are made, and its file.
struct Fmu {
    path: PathBuf,
    original: Original<BufReader<File>>,
}

/// A preset, its destination, and remarks on it.
struct Made {
    preset: Preset,
    block: String,
    path: PathBuf,
    advice: Vec<String>,
}

/// A finished preset, as printed by `--json`.
#[derive(Serialize)]
struct Told<'a> {
    name: &'a str,
    block: &'a str,
    guid: &'a str,
    file: String,
    warnings: &'a [String],
}

/// Makes presets.
///
/// # Errors
/// The parameters or an FMU are faulty, or the block of a loop has no FMU: nothing is written. If a loop cannot be
/// read, the presets of the others are written.
pub fn run(options: &Options) -> Result<()> {
    let mut arguments = options.loops.clone();
    // The FMUs given with --fmus or, without this option, those among the parameter files.
    let is_fmu = |file: &&String| file.to_lowercase().ends_with(".fmu");
    let sources: Vec<PathBuf> = if arguments.fmus.is_empty() {
        arguments.files.iter().filter(is_fmu).map(PathBuf::from).collect()
    } else {
        loops::fmus(&arguments.fmus)?
    };
    ensure!(
        !sources.is_empty(),
        "presets are made from FMUs: specify the FMUs of the loops' blocks, or their folder, with --fmus"
    );
    if let Some(out) = &options.out {
        let shown = out.display();
        let is_folder = out.is_dir() || shown.to_string().ends_with(std::path::is_separator);
        ensure!(
            is_folder || is_file(out) || out.extension().is_none() || out.exists(),
            "{shown}: a preset's file name must end in .fmu; for a folder, write {shown}/"
        );
    }
    let name = options.out.as_deref().filter(|out| is_file(out)).and_then(Path::file_stem);
    if let (Some(name), [_], true) =
        (name, arguments.files.as_slice(), arguments.files.iter().all(|file| is_fmu(&file)))
    {
        // A preset made from an FMU alone is named after its output file.
        arguments.names = vec![name.to_string_lossy().into_owned()];
    }
    let mut found = arguments.read(&arguments.blocks()?)?;
    let mut loops = std::mem::take(&mut found.loops);
    if loops.is_empty() {
        return found.finish();
    }
    let mut fmus = open(&sources, &options.loops.fmus)?;
    ensure!(
        name.is_none() || loops.len() == 1,
        "--out specifies one FMU, but there are {} loops: choose one with --loop, or specify a folder",
        loops.len()
    );
    for values in &mut loops {
        set(values, &options.set)?;
    }
    let made = make(&mut fmus, &loops, options)?;
    let inputs =
        sources.iter().map(PathBuf::as_path).chain(arguments.files.iter().map(|file| Path::new(file.as_str())));
    let folder = options.out.as_deref().filter(|out| out.is_file() && !is_file(out));
    temporary::check_outputs(folder.into_iter().chain(made.iter().map(|made| made.path.as_path())), inputs)?;
    ensure!(folder.is_none(), "--out is an existing file, but not an FMU: specify FILE.fmu, or a folder");
    start(&made)?;
    let pending = made.iter().map(|Made { preset, path, .. }| write(preset, path)).collect::<Result<Vec<_>>>()?;
    for preset in pending {
        // In a folder, presets are replaced without a note, like the results of a build.
        match options.out.as_deref().filter(|_| name.is_some()) {
            Some(file) => replacing(file, || preset.finish())?,
            None => preset.finish()?,
        }
    }
    tell_of(&made, options.json)?;
    found.finish()
}

/// Whether a path names an FMU and not a folder.
fn is_file(out: &Path) -> bool {
    out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fmu"))
}

/// Starts each preset that this machine can run, as a host would.
fn start(made: &[Made]) -> Result<()> {
    let starter = Starter { interrupted: interruption::flag(), ..Starter::new()? };
    let folder = temporary::Folder::new()?;
    for Made { preset, path, .. } in made {
        let file = folder.path().join(format!("{}.fmu", preset.name));
        std::fs::write(&file, &preset.bytes).with_context(|| file.display().to_string())?;
        let started = match host::fmu::library(&Package::open(&file)?) {
            Ok(_) => apart::run(&starter, &file),
            Err(_) => Ok(()),
        };
        if let Err(error) = started {
            let how = if error.is::<Fault>() { "could not be tried" } else { "would not run" };
            return Err(error.context(format!("{} {how}", path.display())));
        }
        std::fs::remove_file(&file).with_context(|| file.display().to_string())?;
    }
    Ok(())
}

fn tell_of(made: &[Made], is_json: bool) -> Result<()> {
    if is_json {
        let told = made.iter().map(|Made { preset, block, path, advice }| Told {
            name: &preset.name,
            block,
            guid: &preset.guid,
            file: path.display().to_string(),
            warnings: advice,
        });
        return print(&format!("{}\n", serde_json::to_string_pretty(&told.collect::<Vec<_>>())?));
    }
    let row = |made: &Made| {
        [made.preset.name.clone(), made.block.clone(), made.preset.guid.clone(), made.path.display().to_string()]
    };
    print(&aligned(&made.iter().map(row).collect::<Vec<_>>()))?;
    let advice = made.iter().flat_map(|made| made.advice.iter().map(|text| (made.preset.name.clone(), text.clone())));
    for warning in told_once(advice) {
        tell::warning(&warning);
    }
    Ok(())
}

/// Applies the values given with --set to a loop.
fn set(values: &mut Loop, settings: &[(String, f64)]) -> Result<()> {
    for (place, (name, number)) in settings.iter().enumerate() {
        let is_same = |(other, _): &(String, f64)| other.eq_ignore_ascii_case(name);
        ensure!(!settings[..place].iter().any(is_same), "{name} is set twice: remove one of the settings");
        let block = values.block.clone();
        let member = block.find(name).filter(|member| block.members[*member].role.is_settable());
        let member = member.with_context(|| format!("{} has no input or parameter {name}", block.name))?;
        let value = parameters::plc_value(*number, block.members[member].kind);
        let value = value.map_err(|why| anyhow!("{} = {number:?}: {why}", block.members[member].name))?;
        values.set(member, value, Origin::File { file: "command line".into() });
    }
    Ok(())
}

/// Opens the FMUs, skipping presets that were found in a named folder.
fn open(files: &[PathBuf], named: &[PathBuf]) -> Result<Vec<Fmu>> {
    let mut fmus = Vec::new();
    for path in files {
        let original = Original::open(path).map_err(|error| Unreadable(error.context(path.display().to_string())))?;
        if !original.is_preset || named.is_empty() || named.contains(path) {
            fmus.push(Fmu { path: path.clone(), original });
        }
    }
    Ok(fmus)
}

/// Makes the presets of all loops in memory; none is written yet.
fn make(fmus: &mut [Fmu], loops: &[Loop], options: &Options) -> Result<Vec<Made>> {
    check_blocks(fmus, loops)?;
    let (file, folder) = match options.out.clone() {
        Some(out) if is_file(&out) => (Some(out), PathBuf::new()),
        out => (None, out.unwrap_or_default()),
    };
    let mut made: Vec<Made> = Vec::new();
    let mut names: BTreeMap<String, &str> = BTreeMap::new();
    for values in loops {
        let identifier = identifier(&values.name);
        // Windows and macOS ignore case in file names.
        if let Some(other) = names.insert(identifier.to_lowercase(), &values.name) {
            bail!(
                "the loops {other:?} and {:?} would both be written as {identifier}.fmu: write one of them with --loop and --out",
                values.name
            );
        }
        let path = file.clone().unwrap_or_else(|| folder.join(format!("{identifier}.fmu")));
        let Some(fmu) = fmus.iter_mut().find(|fmu| fmu.original.block == values.block.name) else { continue };
        let preset = fmu.original.preset(values);
        let preset = preset.with_context(|| format!("{} as preset {:?}", fmu.path.display(), values.name))?;
        made.push(Made { preset, block: values.block.name.clone(), path, advice: values.warnings() });
    }
    Ok(made)
}

/// Fails if the block of a loop has no FMU, or more than one.
fn check_blocks(fmus: &[Fmu], loops: &[Loop]) -> Result<()> {
    let of = |block: &str| -> Vec<&Fmu> { fmus.iter().filter(|fmu| fmu.original.block == block).collect() };
    let mut missing: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for values in loops {
        match of(&values.block.name).as_slice() {
            [] => missing.entry(&values.block.name).or_default().push(&values.name),
            [_] => {}
            [first, second, ..] => bail!(
                "{} and {} are both FMUs of {}: specify only the one to use for {} with --fmus",
                first.path.display(),
                second.path.display(),
                values.block.name,
                values.name
            ),
        }
    }
    let missing: Vec<String> =
        missing.into_iter().map(|(block, loops)| format!("{block} (used by {})", loops.join(", "))).collect();
    ensure!(missing.is_empty(), "no FMU for {}: specify its file or folder with --fmus", missing.join(" and for "));
    Ok(())
}

/// Writes a preset next to its destination, and checks that its start values can be read back.
fn write(preset: &Preset, path: &Path) -> Result<Pending> {
    Pending::write(
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
