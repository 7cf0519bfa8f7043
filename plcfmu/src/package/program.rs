//! Packs a PLC program in SCL: the sources go into the FMU's resources, beside the one library of all programs, which translates
//! them when an instance is made. Nothing is compiled for it.

use crate::build::c;
use crate::build::platform;
use crate::package::pack::LICENCES;
use crate::package::version::Version;
use crate::package::{check, program_library, reference};
use crate::page;
use crate::program::trial::nanoseconds;
use anyhow::{Context, Result, anyhow, bail, ensure};
use clap::Parser as _;
use draw::{diagram, picture};
use fmu::cyclic::Cyclic as _;
use host::fmu::platforms;
use host::library::Library;
use host::package::{DESCRIPTION, Package, archive, temporary};
use modeldescription::{Interface, ModelDescription, units};
use parameters::problem::drawn;
use parameters::{Problems, Source};
use program::{CPUS, FILE, LARGEST, Loaded, Manifest, Wrong};
use std::collections::BTreeMap;
use std::env::consts::{ARCH, OS};
use std::fs;
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a user has to be told about the licences of the crates in the library of programs.
const NOTICE: (&str, &str) = ("NOTICE-PROGRAM", include_str!("../../NOTICE-PROGRAM"));

/// How a program is packed.
#[derive(clap::Args, Clone, Debug, Default, PartialEq)]
#[group(skip)] // clap names a group after the type, and others have the same name
pub struct Options {
    /// Time between two calls of a program, such as 100ms, 0.5s or 2s; the period of the OB that calls it. With several
    /// --call, one for each, in their order
    #[arg(long = "cycle", value_name = "TIME", value_parser = milliseconds)]
    pub cycles: Vec<u32>,
    /// What is called in place of one function block: an organization block, a function without parameters, an instance; may
    /// be repeated, each with its --cycle
    #[arg(long = "call", value_name = "NAME", conflicts_with = "fb")]
    pub calls: Vec<String>,
    #[command(flatten)]
    /// How the sources are read.
    pub source: crate::program::Options,
    /// The most statements in a call of a program [default: 1000000]
    #[arg(long, value_name = "COUNT")]
    pub budget: Option<u32>,
    /// Input of a program that becomes a tunable parameter; may be repeated
    #[arg(long = "parameter", value_name = "NAME")]
    pub parameters: Vec<String>,
    /// Setting of a program (S7_SetPoint), or member of a data block, that becomes an input; may be repeated
    #[arg(long = "input", value_name = "NAME")]
    pub inputs: Vec<String>,
    /// Local of a program, or member of a data block, that becomes an output; may be repeated
    #[arg(long = "output", value_name = "NAME")]
    pub outputs: Vec<String>,
}

/// The options alone, as a loop's description has them.
#[derive(clap::Parser)]
#[command(no_binary_name = true)]
struct Alone {
    #[command(flatten)]
    options: Options,
}

impl Options {
    /// Reads options with their values, by their names.
    ///
    /// # Errors
    /// There is no such option, or not with this value.
    pub fn parse(options: &[(String, String)]) -> Result<Options> {
        let arguments = options.iter().map(|(option, value)| format!("--{option}={value}"));
        let parsed = Alone::try_parse_from(arguments).map_err(|error| {
            let text = error.render().to_string();
            anyhow!("{}", text.lines().next().unwrap_or_default().trim_start_matches("error: "))
        })?;
        Ok(parsed.options)
    }

    /// What [`Options::parse`] reads.
    pub fn pairs(&self) -> Vec<(String, String)> {
        let mut pairs = Vec::new();
        let mut add = |option: &str, values: Vec<String>| {
            pairs.extend(values.into_iter().map(|value| (option.to_string(), value)));
        };
        let source = &self.source;
        let of = |names: &[(String, String)], between: &str| {
            names.iter().map(|(name, value)| format!("{name}{between}{value}")).collect::<Vec<_>>()
        };
        add("call", self.calls.clone());
        add("cycle", self.cycles.iter().map(|cycle| format!("{cycle}ms")).collect());
        let cpu = CPUS.iter().filter(|(_, cpu)| Some(*cpu) == source.cpu);
        add("cpu", cpu.map(|(name, _)| (*name).to_string()).collect());
        add("fb", source.fb.iter().cloned().collect());
        add("tag", of(&source.tag.concat(), " : "));
        add(
            "instance",
            of(&source.instance, " : ").into_iter().map(|of| of.trim_end_matches(" : ").to_string()).collect(),
        );
        add("constant", of(&source.constant, "="));
        add("budget", self.budget.iter().map(u32::to_string).collect());
        add("parameter", self.parameters.clone());
        add("input", self.inputs.clone());
        add("output", self.outputs.clone());
        pairs
    }

    /// An error that names an option, if one is given: there is no program that it could be for.
    ///
    /// # Errors
    /// An option is given.
    pub fn refuse(&self) -> Result<()> {
        match self.pairs().first() {
            Some((option, _)) => {
                bail!("--{option} is for programs in SCL, and none is named: name its sources, such as machine.scl")
            }
            None => Ok(()),
        }
    }

    /// The same, with a time between two calls where none is given: for [`examine`], which does not ask for one.
    #[must_use]
    pub fn with_cycle(&self) -> Options {
        let cycles = if self.cycles.is_empty() { vec![100] } else { self.cycles.clone() };
        Options { cycles, ..self.clone() }
    }

    /// The time between two calls of the FMU, and what is called with which period: the greatest common divisor of the periods is
    /// the former.
    fn tasks(&self) -> Result<(u32, Vec<(String, u32)>)> {
        let (cycles, calls) = (&self.cycles, &self.calls);
        let all = match (cycles.as_slice(), calls.len()) {
            ([], _) => bail!(
                "give the time between two calls with --cycle, such as --cycle 100ms: it is the period of the OB, which sources do not have"
            ),
            ([cycle], 0 | 1) => return Ok((*cycle, calls.iter().map(|call| (call.clone(), 0)).collect())),
            ([cycle], count) => vec![*cycle; count],
            (cycles, count) if cycles.len() == count => cycles.to_vec(),
            (cycles, count) => {
                bail!("{} --cycle for {count} --call: give each --call NAME its --cycle TIME", cycles.len())
            }
        };
        let divisor = |mut one: u32, mut other: u32| {
            while other > 0 {
                (one, other) = (other, one % other);
            }
            one
        };
        let cycle = all.iter().copied().fold(0, divisor);
        let period = |of: u32| if of == cycle { 0 } else { of };
        Ok((cycle, calls.iter().cloned().zip(all.iter().map(|of| period(*of))).collect()))
    }
}

/// The time between two calls: whole milliseconds, as the FMU has them.
fn milliseconds(text: &str) -> Result<u32> {
    let nanoseconds = nanoseconds(text)?;
    let milliseconds = i32::try_from(nanoseconds / 1_000_000).ok().filter(|time| *time >= 1);
    let milliseconds = milliseconds.filter(|_| nanoseconds % 1_000_000 == 0);
    milliseconds.map(i32::unsigned_abs).context("give it in whole milliseconds, at least 1: 100ms, 0.5s, 2s")
}

/// A program that can be packed: what its FMU will be, and what its author should know.
pub struct Examined {
    manifest: Manifest,
    sources: Vec<Source>,
    loaded: Arc<Loaded>,
    interface: Interface,
    description: ModelDescription,
    /// What the author should know, with file, line and column.
    pub warnings: Vec<Problems>,
    /// Why the program, with its start values, stops in one of the calls that would be recorded.
    pub stop: Option<String>,
}

impl Examined {
    /// The block that is run, or the first of several.
    pub fn block(&self) -> &str {
        self.loaded.block()
    }
}

/// Why there is no FMU of a program.
#[derive(Debug)]
pub enum Refused {
    /// What is wrong with the sources.
    Sources(Vec<Problems>),
    /// The sources have no block to be run, or several: a sentence. Nothing else is wrong.
    Choice(String, Vec<Problems>),
    /// Anything else.
    Other(anyhow::Error),
}

impl From<anyhow::Error> for Refused {
    fn from(error: anyhow::Error) -> Refused {
        Refused::Other(error)
    }
}

impl From<Refused> for anyhow::Error {
    fn from(refused: Refused) -> anyhow::Error {
        match refused {
            Refused::Sources(problems) => anyhow!("{}", problems.iter().map(drawn).collect::<String>().trim_end()),
            Refused::Choice(which, _) => anyhow!(which),
            Refused::Other(error) => error,
        }
    }
}

/// All that is done with the sources before a library is needed: `check` says what it finds, [`pack`] goes on with it.
///
/// # Errors
/// Why there is no FMU of them.
pub fn examine(files: &[PathBuf], options: &Options) -> Result<Examined, Refused> {
    let (manifest, sources) = read(files, options)?;
    // In the FMU they lie side by side; a message names them as the user does.
    let named = |mut problems: Vec<Problems>| {
        for of in &mut problems {
            let number = sources.iter().position(|source| source.file == of.file);
            of.file = number.map_or(of.file.clone(), |number| files[number].display().to_string());
        }
        problems
    };
    let loaded = Loaded::new(&manifest, &sources, is_unit).map_err(|wrong| match wrong {
        Wrong::Sources(problems) => Refused::Sources(named(problems)),
        Wrong::Choice { ref warnings, .. } => Refused::Choice(wrong.to_string(), named(warnings.clone())),
        Wrong::Other(what) => Refused::Other(anyhow!(what)),
    })?;
    let loaded = Arc::new(loaded);
    let interface = Interface::parse(&fmu::describe(loaded.table, &loaded.guid())).map_err(anyhow::Error::from)?;
    let description = ModelDescription::of(&interface).map_err(anyhow::Error::from)?;
    let mut program = program::Program::new(loaded.clone());
    program.restart();
    (0..interface.table.responses[0].calls).for_each(|_| program.call());
    let stop = program.stopped().map(str::to_string);
    let warnings = named(loaded.warnings.clone());
    Ok(Examined { manifest, sources, loaded, interface, description, warnings, stop })
}

/// Whether FMI knows the unit.
fn is_unit(unit: &str) -> bool {
    units::definition(unit).is_some()
}

/// What the user is told of a program that stops with its start values.
pub fn stops(stop: &str) -> String {
    format!(
        "with its start values the program stops: {stop}; set what this depends on before the first step, or give it another \
         start value"
    )
}

/// Packs the program of these sources, as `NAME.fmu` in a folder, and gives the path. Warnings are for the user. A native one has
/// the library that this machine's C compiler makes of it; any other that of all programs.
///
/// # Errors
/// All that is wrong with the sources, with file, line and column; the library of programs is missing.
pub fn pack(
    files: &[PathBuf],
    options: &Options,
    version: Version,
    native: bool,
    folder: &Path,
) -> Result<(PathBuf, Vec<String>)> {
    version.check()?;
    ensure!(
        !native || version.has_sources(),
        "--native compiles a program through C, which there is of FMI 2.0 alone: leave out --native or --fmi 3"
    );
    let Examined { manifest, sources, loaded, interface, description: mut xml, warnings, stop } =
        examine(files, options)?;
    if version != Version::default() {
        xml = ModelDescription::of(&version.of(&interface))?;
    }
    let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).filter(|text| !text.is_empty()).collect();
    warnings.extend(stop.as_deref().map(|stop| format!("note: {}", stops(stop))));
    let name = &interface.table.name;
    let mut contents = BTreeMap::new();
    let host = *platforms(OS, ARCH).first().context("FMI has no platform for this machine")?;
    let compiled = temporary::Folder::new()?;
    let mut libraries = if native { BTreeMap::new() } else { program_library::find(compiled.path())? };
    match loaded.sources(laws::with_laws) {
        _ if !version.has_sources() => {}
        Ok(text) => {
            let file = format!("{name}.c");
            if native {
                let suffix = platform::system(host).map_or("", |(_, suffix)| suffix);
                fs::write(compiled.path().join(&file), &text)?;
                let told = fmu::describe(loaded.table, &loaded.guid());
                libraries.insert(host, c::compile(&compiled.path().join(&file), &told, compiled.path(), suffix)?);
            }
            contents.insert(format!("sources/{file}"), text.into_bytes());
            xml = xml.with_sources(&[file]);
        }
        Err(reason) => {
            ensure!(!native, "{name} has no form in C: {reason}; leave out --native");
            warnings.push(format!("note: {name} is packed without C: {reason}"));
        }
    }
    contents.insert(DESCRIPTION.to_string(), xml.write());
    let unpacked = temporary::Folder::new()?;
    for (file, text) in [(FILE, manifest.to_string().into_bytes())]
        .into_iter()
        .chain(sources.iter().map(|source| (source.file.as_str(), source.text.clone().into_bytes())))
    {
        fs::write(unpacked.path().join(file), &text)?;
        contents.insert(format!("resources/{file}"), text);
    }
    let here = libraries.get(host).with_context(|| format!("there is no library of programs for {host}"))?;
    let resources = unpacked.path().display().to_string();
    let response = &interface.table.responses[0];
    let mut recordings = reference::Recordings { responses: Vec::new(), characteristics: Vec::new() };
    if stop.is_none() {
        let recording = reference::record(&Library::open(here)?, &interface, response, Some(&resources))
            .context("the program with its start values")?;
        contents.extend(reference::files(&interface.table, &recording, version));
        recordings.responses.push(recording);
    }
    contents.insert(
        "documentation/index.html".into(),
        page::html(&interface.table, &interface.guid, &recordings, None, xml.sources().first().copied())?.into_bytes(),
    );
    for (platform, library) in &libraries {
        let suffix = platform::system(platform).map_or("", |(_, suffix)| suffix);
        let bytes = fs::read(library).with_context(|| library.display().to_string())?;
        contents.insert(format!("binaries/{platform}/{name}{suffix}"), bytes);
    }
    for (licence, text) in LICENCES.into_iter().chain([NOTICE]) {
        contents.insert(format!("documentation/licenses/{licence}"), text.into());
    }
    contents.insert("model.png".into(), picture::png(&diagram::icon::svg(&interface.table)?)?);
    let bytes = archive::write(&version.placed(contents))?;
    let is_run = stop.is_none() && version.is_run();
    fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    let path = folder.join(format!("{name}.fmu"));
    temporary::place(&path, |file| Ok(file.write_all(&bytes)?), |packed| check::packed(packed, &xml, is_run))?;
    Ok((path, warnings))
}

/// What the sources in a packed program tell of it; `None` if the FMU is no program.
///
/// # Errors
/// They are damaged.
pub fn interface_of<R: Read + Seek>(package: &mut Package<R>) -> Result<Option<Interface>> {
    let path = |file: &str| format!("resources/{file}");
    if package.archive.find(&path(FILE)).is_none() {
        return Ok(None);
    }
    let manifest = String::from_utf8(package.archive.read(&path(FILE), LARGEST)?)
        .map_err(anyhow::Error::msg)
        .and_then(|text| Manifest::parse(&text).map_err(anyhow::Error::msg))
        .with_context(|| path(FILE))?;
    let mut sources = Vec::new();
    for file in &manifest.sources {
        sources.push(Source::new(file.clone(), package.archive.read(&path(file), LARGEST)?));
    }
    let loaded = Loaded::new(&manifest, &sources, is_unit).map_err(anyhow::Error::msg)?;
    Ok(Some(Interface::parse(&fmu::describe(loaded.table, &loaded.guid()))?))
}

/// The sources, under their names in the FMU, and what is made of them.
fn read(files: &[PathBuf], options: &Options) -> Result<(Manifest, Vec<Source>)> {
    let (cycle, calls) = options.tasks()?;
    let mut sources: Vec<Source> = Vec::new();
    for file in files {
        let mut source = Source::read(file, None).map_err(anyhow::Error::msg)?;
        let name = PathBuf::from(file.file_name().context("the name of a source is empty")?);
        ensure!(
            source.text.len() as u64 <= LARGEST,
            "{}: a source has at most {} MiB: split it",
            file.display(),
            LARGEST >> 20
        );
        source.file = free(&name, |name| name == FILE || sources.iter().any(|of| of.file.eq_ignore_ascii_case(name)));
        sources.push(source);
    }
    let given = &options.source;
    let manifest = Manifest {
        name: None,
        sources: sources.iter().map(|source| source.file.clone()).collect(),
        cycle,
        block: given.block(),
        cpu: given.cpu,
        budget: options.budget,
        parameters: options.parameters.clone(),
        inputs: options.inputs.clone(),
        declared: given.declared(),
        constants: given.constant.clone(),
        outputs: options.outputs.clone(),
        calls,
    };
    Ok((manifest, sources))
}

/// The name of a source in an FMU, where all lie in one folder: `pump.scl`, a second one `pump_2.scl`.
fn free(file: &Path, is_taken: impl Fn(&str) -> bool) -> String {
    let text = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let (stem, ending) = (text(file.file_stem()), text(file.extension()));
    let names = (2..).map(|number| format!("{stem}_{number}.{ending}"));
    std::iter::once(text(file.file_name())).chain(names).find(|name| !is_taken(name)).unwrap_or_default()
}

#[cfg(test)]
mod tests;
