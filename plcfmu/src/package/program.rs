//! Packs a PLC program in SCL: the FMU contains the sources as resources, and the library shared by all programs, which
//! translates them when an instance is created. Nothing is compiled for the program.

mod assume;

use crate::build::c;
use crate::build::platform;
use crate::package::pack::LICENCES;
use crate::package::version::{Fmi, Version};
use crate::package::{check, program_library, reference};
use crate::page;
use crate::program::Parts;
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use fmu::CAPABILITIES;
use fmu::cyclic::Cyclic as _;
use fmu::log::Category;
use fmu::sources::Door;
use host::fmu::platforms;
use host::library::Library;
use host::package::{DESCRIPTION, Package, archive, temporary};
use manifest::{Cpu, FILE, Manifest, constant, declaration, milliseconds, tag, unquoted};
use modeldescription::{Capabilities, Interface, LogCategory, ModelDescription, units};
use parameters::problem::drawn;
use parameters::tags::{Tag, Tags};
use parameters::{Problems, Source};
use program::{LARGEST, Loaded, Wrong};
use serde::Deserialize;
use serde::de::value::{self, MapDeserializer};
use std::collections::BTreeMap;
use std::env::consts::{ARCH, OS};
use std::fs;
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The licence notice of the crates in the program library.
const NOTICE: (&str, &str) = ("NOTICE-PROGRAM", include_str!("../../NOTICE-PROGRAM"));

/// The options for packing a program.
#[derive(clap::Args, Clone, Debug, Default, PartialEq)]
#[group(skip)] // clap names a group after its type, and other options have a type with the same name
pub struct Options {
    /// Time between two calls of a program, such as 100ms, 0.5s or 2s: the period of the OB that calls it. With several
    /// --call, one for each, in the same order
    #[arg(long = "cycle", value_name = "TIME", value_parser = milliseconds)]
    pub cycles: Vec<u32>,
    /// Block to call instead of a single function block: an organization block, a function without parameters or an
    /// instance; may be repeated, each with its --cycle
    #[arg(long = "call", value_name = "NAME", conflicts_with = "fb")]
    calls: Vec<String>,
    /// The CPU whose rules apply: 300 (and 400), 1200 or 1500; by default, the one suggested by the dialect of the
    /// sources
    #[arg(long)]
    cpu: Option<Cpu>,
    /// The function block or instance to run; by default, the one not called by any other block
    #[arg(long, value_name = "NAME")]
    fb: Option<String>,
    /// A PLC tag that no source declares, such as "Start : Bool" or "Start AT %I0.0 : Bool"; or a tag table (.xml,
    /// .xlsx, .sdf, or text with one tag per line)
    #[arg(long = "tag", value_name = "NAME : TYPE", value_parser = tags)]
    tags: Vec<Tags>,
    /// An instance data block that no source declares, such as "Motor_DB : Motor"; the name alone of a declared
    /// instance runs it, like --fb
    #[arg(long = "instance", value_name = "NAME : BLOCK", value_parser = instance)]
    instances: Vec<(String, String)>,
    /// A constant that no source declares, such as MAX=5
    #[arg(long = "constant", value_name = "NAME=VALUE", value_parser = constant)]
    constants: Vec<(String, String)>,
    /// A block to replace with a stub that has only its interface: its inputs become outputs of the FMU, its outputs
    /// inputs; may be repeated
    #[arg(long = "stub", value_name = "NAME")]
    stubs: Vec<String>,
    /// Infer undeclared names from their use: tags, data blocks, types, and stubs of blocks that are only called. The
    /// assumptions are printed and written to FILE, to be edited and passed again [default: assumed.scl]
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "assumed.scl")]
    assume: Option<PathBuf>,
    /// Maximum number of statements in a program call [default: 1000000]
    #[arg(long, value_name = "COUNT")]
    budget: Option<u32>,
    /// Program input that becomes a tunable parameter; may be repeated
    #[arg(long = "parameter", value_name = "NAME")]
    parameters: Vec<String>,
    /// Program setting (S7_SetPoint) or data block member that becomes an input; may be repeated
    #[arg(long = "input", value_name = "NAME")]
    inputs: Vec<String>,
    /// Local program variable or data block member that becomes an output; may be repeated
    #[arg(long = "output", value_name = "NAME")]
    outputs: Vec<String>,
}

impl Options {
    /// The manifest of a program with these sources.
    ///
    /// # Errors
    /// The number of cycles is neither one nor the number of calls.
    pub fn manifest(&self, sources: &[PathBuf]) -> Result<Manifest> {
        let (known, unknown): (Vec<_>, Vec<_>) = self.instances.iter().cloned().partition(|(_, of)| of.is_empty());
        let instances = unknown.into_iter().map(|(name, of)| Tag::new(name, of));
        let constants =
            self.tags.iter().flat_map(|of| of.constants.iter().map(|of| (of.name.clone(), of.value.clone())));
        let mut manifest = Manifest {
            name: None,
            sources: sources.to_vec(),
            block: self.fb.clone().or(known.into_iter().next().map(|(name, _)| name)),
            cpu: self.cpu,
            budget: self.budget,
            parameters: self.parameters.clone(),
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            declared: self.tags.iter().flat_map(|of| of.tags.clone()).chain(instances).collect(),
            constants: self.constants.iter().cloned().chain(constants).collect(),
            stubs: self.stubs.clone(),
            ..Manifest::default()
        };
        manifest.set_calls(self.calls.clone(), &self.cycles).map_err(Error::msg)?;
        if let Some(file) = &self.assume {
            assume::complete(&mut manifest, file)?;
        }
        Ok(manifest)
    }

    /// Rejects options that need a program; the error names the first of them.
    ///
    /// # Errors
    /// An option is given.
    pub fn refuse(&self) -> Result<()> {
        let given = [
            ("call", !self.calls.is_empty()),
            ("cycle", !self.cycles.is_empty()),
            ("cpu", self.cpu.is_some()),
            ("fb", self.fb.is_some()),
            ("tag", !self.tags.is_empty()),
            ("instance", !self.instances.is_empty()),
            ("constant", !self.constants.is_empty()),
            ("stub", !self.stubs.is_empty()),
            ("assume", self.assume.is_some()),
            ("budget", self.budget.is_some()),
            ("parameter", !self.parameters.is_empty()),
            ("input", !self.inputs.is_empty()),
            ("output", !self.outputs.is_empty()),
        ];
        match given.iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => {
                bail!("--{option} is for programs in SCL: specify the program's sources, such as machine.scl")
            }
            None => Ok(()),
        }
    }
}

/// Parses an argument of `--tag`: a tag, or the path of a tag table.
fn tags(text: &str) -> Result<Tags, String> {
    let path = Path::new(text);
    if path.is_file() {
        return crate::program::table(path).map_err(|error| format!("{error:#}"));
    }
    tag(text).map(|tag| Tags { tags: vec![tag], constants: Vec::new() })
}

/// Parses an argument of `--instance` into name and block. The block is empty for an instance that a source declares.
fn instance(text: &str) -> Result<(String, String), String> {
    if text.contains(':') { declaration(text) } else { Ok((unquoted(text).to_string(), String::new())) }
}

/// A program that can be packed: the contents of its FMU, and warnings for its author.
pub struct Examined {
    manifest: Manifest,
    sources: Vec<Source>,
    loaded: Arc<Loaded>,
    interface: Interface,
    description: ModelDescription,
    /// Warnings for the author, with file, line and column.
    pub warnings: Vec<Problems>,
    /// Why the program, with its start values, stops in one of the calls to be recorded, if it does.
    pub stop: Option<String>,
}

impl Examined {
    /// The block that runs, or the first of several.
    pub fn block(&self) -> &str {
        self.loaded.block()
    }
}

/// Why a program cannot be packaged as an FMU.
#[derive(Debug)]
pub enum Refused {
    /// Errors in the sources.
    Sources(Vec<Problems>),
    /// The sources have no block to run, or several: a sentence, and the warnings. There are no errors.
    Choice(String, Vec<Problems>),
    /// Anything else.
    Other(Error),
}

impl From<Error> for Refused {
    fn from(error: Error) -> Refused {
        Refused::Other(error)
    }
}

impl From<Refused> for Error {
    fn from(refused: Refused) -> Error {
        match refused {
            Refused::Sources(problems) => anyhow!("{}", problems.iter().map(drawn).collect::<String>().trim_end()),
            Refused::Choice(which, _) => anyhow!(which),
            Refused::Other(error) => error,
        }
    }
}

/// Does all processing of the sources that needs no library: `check` reports the result, [`pack`] continues with it.
/// The sources in the manifest are paths.
///
/// # Errors
/// The program cannot be packaged as an FMU; [`Refused`] states why.
pub fn examine(manifest: &Manifest) -> Result<Examined, Refused> {
    let Named { manifest, sources, files } = read(manifest)?;
    // In the FMU, all sources are in one folder; messages use the user's names for them.
    let named = |mut problems: Vec<Problems>| {
        for of in &mut problems {
            let number = sources.iter().position(|source| source.file == of.file);
            of.file = number.map_or(of.file.clone(), |number| files[number].clone());
        }
        problems
    };
    let loaded = Loaded::new(&manifest, &sources, is_unit).map_err(|wrong| match wrong {
        Wrong::Sources(problems) => Refused::Sources(named(problems)),
        Wrong::Choice { ref blocks, ref warnings } => {
            let remedy = match blocks.len() {
                0 | 1 => "",
                _ => ", a function block with --fb NAME, or each organization block with --call NAME and its --cycle TIME",
            };
            Refused::Choice(format!("{wrong}{remedy}"), named(warnings.clone()))
        }
        Wrong::Other(what) => Refused::Other(anyhow!(what)),
    })?;
    let loaded = Arc::new(loaded);
    let interface = interface(&loaded)?;
    let description = ModelDescription::from_interface(&interface).map_err(Error::from)?;
    let mut program = program::Program::new(loaded.clone());
    program.restart();
    (0..interface.table.responses[0].calls).for_each(|_| program.call());
    let stop = program.stopped().map(str::to_string);
    let warnings = named(loaded.warnings.clone());
    Ok(Examined { manifest, sources, loaded, interface, description, warnings, stop })
}

/// The interface of the program library when it runs this program.
fn interface(loaded: &Loaded) -> Result<Interface> {
    let capabilities = MapDeserializer::<_, value::Error>::new(CAPABILITIES.iter().copied());
    let log_category = |category: &Category| LogCategory {
        name: category.name.to_string_lossy().into(),
        description: Some(category.description.into()),
    };
    Ok(Interface {
        capabilities: Capabilities::deserialize(capabilities)?,
        log_categories: Category::ALL.iter().map(log_category).collect(),
        ..Interface::linked(loaded.table.clone(), &loaded.guid())?
    })
}

/// Whether plcfmu can define the unit in FMI base units.
fn is_unit(unit: &str) -> bool {
    units::definition(unit).is_some()
}

/// The note on a program that stops with its start values.
pub fn stops(stop: &str) -> String {
    format!(
        "with its start values, the program stops: {stop}; change the start values that cause this, or set other \
         values before the first step"
    )
}

/// Compiles the C source of a program to a library in a folder.
fn compile_natively(folder: &Path, file: &str, text: &str, door: &Door, told: &str) -> Result<PathBuf> {
    let suffix = platforms(OS, ARCH).first().and_then(|host| platform::system(host)).map_or("", |(_, suffix)| suffix);
    fs::write(folder.join(file), text)?;
    c::compile(&folder.join(file), door, told, folder, suffix)
}

/// Packs the program with these source files as `NAME.fmu` in a folder, and returns the path and the warnings. A native
/// FMU contains a library compiled by this machine's C compiler; any other, the library shared by all programs.
///
/// # Errors
/// The sources have errors, all of which are stated with file, line and column; or the program library is missing.
pub fn pack(manifest: &Manifest, version: Version, native: bool, folder: &Path) -> Result<(PathBuf, Vec<String>)> {
    version.check()?;
    ensure!(
        manifest.cycle.is_some(),
        "specify the time between two calls with --cycle, such as --cycle 100ms: the sources do not state the period of \
         the OB"
    );
    let Examined { manifest, sources, loaded, interface, description: mut xml, warnings, stop } = examine(manifest)?;
    if version != Version::default() {
        xml = ModelDescription::from_interface(&version.adapt(&interface))?;
    }
    let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).filter(|text| !text.is_empty()).collect();
    warnings.extend(stop.as_deref().map(|stop| format!("note: {}", stops(stop))));
    let name = &interface.table.name;
    let mut contents = BTreeMap::new();
    let host = *platforms(OS, ARCH).first().context("FMI has no platform for this machine")?;
    let compiled = temporary::Folder::new()?;
    let mut libraries = if native { BTreeMap::new() } else { program_library::find(compiled.path())? };
    let mut source = None;
    // A second library for recording, if needed: the reference results are recorded through FMI 2.0, but a library
    // compiled from C exports the functions of only one FMI version.
    let mut recorded = None;
    match loaded.sources(version.door(), laws::with_laws) {
        Ok(text) => {
            let file = format!("{name}.c");
            if native {
                let told = fmu::describe(&loaded.table, &loaded.guid());
                libraries.insert(host, compile_natively(compiled.path(), &file, &text, version.door(), &told)?);
                if version.fmi == Fmi::Three {
                    let text =
                        loaded.sources(Version::default().door(), laws::with_laws).map_err(anyhow::Error::msg)?;
                    let folder = compiled.path().join("recorded");
                    fs::create_dir(&folder)?;
                    recorded = Some(compile_natively(&folder, &file, &text, Version::default().door(), &told)?);
                }
            }
            contents.extend(version.sources(name, text));
            xml = xml.with_sources(std::slice::from_ref(&file));
            source = Some(file);
        }
        Err(reason) => {
            ensure!(!native, "{name} cannot be written in C: {reason}; omit --native");
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
    let here = recorded.as_ref().or_else(|| libraries.get(host));
    let here = here.with_context(|| format!("no program library for {host}"))?;
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
        page::html(&interface.table, &xml.description(), &recordings, None, source.as_deref())?.into_bytes(),
    );
    for (platform, library) in &libraries {
        let suffix = platform::system(platform).map_or("", |(_, suffix)| suffix);
        let bytes = fs::read(library).with_context(|| library.display().to_string())?;
        contents.insert(format!("binaries/{platform}/{name}{suffix}"), bytes);
    }
    for (licence, text) in LICENCES.into_iter().chain([NOTICE]) {
        contents.insert(format!("documentation/licenses/{licence}"), text.into());
    }
    contents.extend(version.pictures(&interface.table)?);
    let bytes = archive::write(&version.placed(contents))?;
    fs::create_dir_all(folder).with_context(|| format!("{} cannot be created", folder.display()))?;
    let path = folder.join(format!("{name}.fmu"));
    temporary::place(&path, |file| Ok(file.write_all(&bytes)?), |packed| check::packed(packed, &xml, stop.is_none()))?;
    Ok((path, warnings))
}

/// The interface of a packed program, derived from its sources; `None` if the FMU is not a program.
///
/// # Errors
/// The sources in the FMU are damaged.
pub fn interface_of<R: Read + Seek>(package: &mut Package<R>) -> Result<Option<Interface>> {
    let path = |file: &str| format!("resources/{file}");
    if package.archive.find(&path(FILE)).is_none() {
        return Ok(None);
    }
    let manifest = String::from_utf8(package.archive.read(&path(FILE), LARGEST)?)
        .map_err(Error::msg)
        .and_then(|text| Manifest::parse(&text).map_err(Error::msg))
        .with_context(|| path(FILE))?;
    let mut sources = Vec::new();
    for file in manifest.sources.iter().map(|source| source.display().to_string()) {
        let bytes = package.archive.read(&path(&file), LARGEST)?;
        sources.push(Source::new(file, bytes));
    }
    let loaded = Loaded::new(&manifest, &sources, is_unit).map_err(Error::msg)?;
    interface(&loaded).map(Some)
}

/// A program as stored in an FMU.
struct Named {
    /// The sources, under their names in the FMU.
    sources: Vec<Source>,
    /// The program's manifest.
    manifest: Manifest,
    /// The user's names for the sources.
    files: Vec<String>,
}

/// Reads the sources and the manifest, and gives the sources the names that they will have in the FMU.
fn read(manifest: &Manifest) -> Result<Named> {
    let Parts { sources: all, manifest, .. } = crate::program::parts(manifest)?;
    let mut sources: Vec<Source> = Vec::new();
    let mut files = Vec::new();
    for mut source in all {
        ensure!(
            source.text.len() as u64 <= LARGEST,
            "{}: a source may be at most {} MiB in size: split it",
            source.file,
            LARGEST >> 20
        );
        let path = PathBuf::from(&source.file);
        let name = PathBuf::from(path.file_name().context("the name of a source is empty")?);
        let beside = partner(&source.file)
            .and_then(|name| files.iter().position(|file: &String| file.eq_ignore_ascii_case(&name)));
        let name = match beside {
            Some(other) => {
                let ending = path.extension().unwrap_or_default();
                Path::new(&sources[other].file).with_extension(ending).display().to_string()
            }
            None => free(&name, |name| {
                let other = partner(name);
                let is_it = |of: &Source| {
                    of.file.eq_ignore_ascii_case(name)
                        || other.as_ref().is_some_and(|other| of.file.eq_ignore_ascii_case(other))
                };
                name == FILE || sources.iter().any(is_it)
            }),
        };
        files.push(std::mem::replace(&mut source.file, name));
        sources.push(source);
    }
    let names = sources.iter().map(|source| source.file.clone().into()).collect();
    Ok(Named { manifest: Manifest { sources: names, ..manifest }, sources, files })
}

/// The name of a SIMATIC SD file's companion: a document's text file, or a text file's document.
fn partner(file: &str) -> Option<String> {
    let file = Path::new(file);
    let ending = match file.extension()?.to_ascii_lowercase().to_str()? {
        "s7dcl" => "s7res",
        "s7res" => "s7dcl",
        _ => return None,
    };
    Some(file.with_extension(ending).display().to_string())
}

/// The name of a source in an FMU, where all sources are in one folder: `pump.scl`, or `pump_2.scl` for a second one.
fn free(file: &Path, is_taken: impl Fn(&str) -> bool) -> String {
    let text = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let (stem, ending) = (text(file.file_stem()), text(file.extension()));
    let names = (2..).map(|number| format!("{stem}_{number}.{ending}"));
    std::iter::once(text(file.file_name())).chain(names).find(|name| !is_taken(name)).unwrap_or_default()
}

#[cfg(test)]
mod tests;
