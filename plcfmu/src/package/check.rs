//! Checks an FMU's file: how it is packed, its model description, its libraries; and, where it is asked for, the library
//! of this machine at work. For those that were just packed, and for any others: `cargo xtask check`.

use crate::build::compile::GLIBC;
use crate::build::platform::Platform;
use crate::host::instance::{Instance, Type};
use crate::host::library::Library;
use crate::package::Package;
use crate::package::binary::Binary;
use crate::package::temporary;
use modeldescription::{ModelDescription, Typed, shortened};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Libraries are not taken to be larger.
const LARGEST_LIBRARY: u64 = 1 << 28;

/// How many calls of the block a packed FMU makes before it is let out.
const CYCLES: u32 = 10;

/// What to check.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// The FMUs
    #[arg(value_name = "FILE.fmu", required = true)]
    pub files: Vec<PathBuf>,
    /// Also load this machine's library and let it make some steps: that runs its code
    #[arg(long)]
    pub run: bool,
}

/// Checks FMUs, whoever made them, and prints what they are.
///
/// # Errors
/// How many are not as they should be; what is wrong with them is printed.
pub fn check(options: &Options) -> Result<(), String> {
    let mut wrong = 0;
    for file in &options.files {
        println!("{}", file.display());
        match Package::open(file).and_then(|mut package| examine(&mut package, options.run)) {
            Ok(lines) => lines.iter().for_each(|line| println!("  {line}")),
            Err(error) => {
                println!("  WRONG: {error}");
                wrong += 1;
            }
        }
    }
    match wrong {
        0 => Ok(()),
        _ => Err(format!("{wrong} of {} FMUs are not as they should be", options.files.len())),
    }
}

/// What there is to say of an FMU.
fn examine(package: &mut Package<BufReader<File>>, run_it: bool) -> Result<Vec<String>, String> {
    let description = &package.description;
    let mut lines = vec![headline(description)];
    let is_co_simulation = description.co_simulation.is_some();
    lines.extend(modeldescription::check(description).into_iter().map(|finding| format!("remark: {finding}")));
    for file in package.libraries.clone() {
        let binary = Binary::read(&package.archive.read(&file.path, LARGEST_LIBRARY)?)
            .map_err(|error| format!("{}: {error}", file.path))?;
        if is_co_simulation && let Some(missing) = binary.missing() {
            return Err(format!("{} does not export {missing}", file.path));
        }
        let glibc = binary.glibc.map_or(String::new(), |glibc| format!(", needs glibc {glibc}"));
        lines.push(format!("{}: {} functions of FMI{glibc}", file.path, binary.functions.len()));
    }
    if run_it {
        run(package, host()?, &std::env::temp_dir())?;
        lines.push(format!("instantiated, initialized, {CYCLES} steps made, all variables read, freed"));
    }
    Ok(lines)
}

/// What an FMU is, in one line, whatever its texts hold.
fn headline(description: &ModelDescription) -> String {
    let kinds = [
        description.co_simulation.as_ref().map(|_| "co-simulation"),
        description.model_exchange.as_ref().map(|_| "model exchange"),
    ];
    let kinds: Vec<_> = kinds.into_iter().flatten().collect();
    format!(
        "{:?}: FMI {} for {}, {} variables, GUID {:?}",
        shortened(&description.model_name),
        modeldescription::FMI_VERSION,
        kinds.join(" and "),
        description.model_variables.len(),
        shortened(&description.guid)
    )
}

/// This machine's folder of libraries.
fn host() -> Result<&'static str, String> {
    Platform::host().map(|host| host.folder).map_err(|error| format!("{error:#}"))
}

/// Checks an FMU that was just packed: everything that its users rely on. Where it is to be portable, its Linux libraries need
/// glibc [`GLIBC`] at most.
///
/// # Errors
/// What is wrong.
pub fn packed(path: &Path, description: &ModelDescription, is_portable: bool) -> Result<(), String> {
    let mut package = Package::open(path)?;
    if package.description != *description {
        return Err("modelDescription.xml does not read back as it was written".into());
    }
    let findings = modeldescription::check(description);
    if !findings.is_empty() {
        return Err(format!("modelDescription.xml: {}", join(&findings)));
    }
    for file in package.libraries.clone() {
        let library = Binary::read(&package.archive.read(&file.path, LARGEST_LIBRARY)?).and_then(|binary| {
            binary.check_functions()?;
            if is_portable { binary.check_portable(GLIBC) } else { Ok(()) }
        });
        library.map_err(|error| format!("{}: {error}", file.path))?;
    }
    run(&mut package, host()?, path.parent().unwrap_or(Path::new(".")))
}

/// Loads the library for `platform` and lets it work: its own GUID and no other is taken, it makes some steps, all its
/// variables can be read. It is unpacked below `place`.
fn run(package: &mut Package<BufReader<File>>, platform: &str, place: &Path) -> Result<(), String> {
    if package.description.co_simulation.is_none() {
        return Err("it is for model exchange only and cannot make steps by itself".into());
    }
    let file = package.libraries.iter().find(|file| file.platform == platform);
    let file =
        file.ok_or_else(|| format!("it has no library for {platform}, only for {}", package.platforms()))?.clone();
    // Declared before the library: it goes after it.
    let folder = temporary::builder().tempdir_in(place).map_err(|error| format!("no temporary folder: {error}"))?;
    package.archive.unpack(folder.path())?;
    let below = format!("{}/", folder.path().display());
    let library = Library::open(&folder.path().join(&file.path)).map_err(|error| error.replace(&below, ""))?;
    let resources = uri(&folder.path().join("resources"));
    let description = &package.description;
    if Instance::instantiate(&library, "{00000000-0000-0000-0000-000000000000}", Some(&resources)).is_ok() {
        return Err(format!("{} takes any GUID, not only that of modelDescription.xml", file.path));
    }
    let mut instance = Instance::instantiate(&library, &description.guid, Some(&resources))?;
    let experiment = description.default_experiment.unwrap_or_default();
    let start = experiment.start_time.unwrap_or(0.0);
    let step = experiment.step_size.unwrap_or(0.01);
    instance.enter_initialization(start)?;
    instance.exit_initialization()?;
    for call in 0..CYCLES {
        instance.step(start + f64::from(call) * step, step)?;
    }
    for variable in &description.model_variables {
        let Some(kind) = fmi_type(&variable.typed) else { continue };
        let value = instance.get(kind, variable.value_reference);
        value.map_err(|error| format!("{:?} cannot be read: {error}", shortened(&variable.name)))?;
    }
    instance.terminate()
}

fn fmi_type(typed: &Typed) -> Option<Type> {
    match typed {
        Typed::Real(_) => Some(Type::Real),
        Typed::Integer(_) | Typed::Enumeration(_) => Some(Type::Integer),
        Typed::Boolean(_) => Some(Type::Boolean),
        Typed::String(_) => None,
    }
}

/// A folder as FMI names it.
fn uri(folder: &Path) -> String {
    let path = folder.display().to_string().replace('\\', "/").replace('%', "%25").replace(' ', "%20");
    format!("file://{}{path}", if path.starts_with('/') { "" } else { "/" })
}

fn join<T: std::fmt::Display>(findings: &[T]) -> String {
    findings.iter().map(T::to_string).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::archive;
    use modeldescription::Interface;

    /// The description of a small block.
    fn description() -> ModelDescription {
        let json = r#"{"name":"PUMP","docs":"Pumps.","guid":"{1}","cycle":0,"variables":[
            {"name":"CYCLE","description":"x","kind":"Time","role":"Cycle","start":1.0,"min":0.001,"max":null,"unit":null}],
            "response":{"title":"x","calls":3,"set":[],"show":[]}}"#;
        ModelDescription::of(&Interface::parse(json).unwrap()).unwrap()
    }

    /// What the check says of an FMU with this library.
    fn verdict(library: &[u8], expected: &ModelDescription) -> String {
        let files = [
            ("modelDescription.xml".to_string(), modeldescription::write(&description())),
            ("binaries/linux64/PUMP.so".to_string(), library.to_vec()),
        ];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("PUMP.fmu");
        std::fs::write(&path, archive::write(&files.into()).unwrap()).unwrap();
        packed(&path, expected, false).unwrap_err()
    }

    #[test]
    fn an_fmu_with_another_description_than_the_one_written_is_not_let_out() {
        let other = ModelDescription { guid: "{2}".into(), ..description() };
        assert_eq!(verdict(b"", &other), "modelDescription.xml does not read back as it was written");
    }

    #[test]
    fn an_fmu_whose_library_is_none_is_not_let_out() {
        let error = verdict(b"hello", &description());
        assert!(
            error.starts_with("binaries/linux64/PUMP.so: it is no library of Linux, Windows or macOS: "),
            "{error}"
        );
    }

    #[test]
    fn an_fmu_is_one_line_whatever_its_texts_hold() {
        let mut description = description();
        assert_eq!(headline(&description), r#""PUMP": FMI 2.0 for co-simulation, 1 variables, GUID "{1}""#);
        description.model_name = "PUMP\n  linux64: fine\u{9b}31m".into();
        description.guid = "0".repeat(3_000_000);
        assert_eq!(
            headline(&description),
            format!(
                r#""PUMP\n  linux64: fine\u{{9b}}31m": FMI 2.0 for co-simulation, 1 variables, GUID "{}…""#,
                "0".repeat(60)
            )
        );
    }

    #[test]
    fn a_folder_is_named_as_a_uri() {
        assert_eq!(uri(Path::new("/tmp/a b/50%/resources")), "file:///tmp/a%20b/50%25/resources");
        assert_eq!(uri(Path::new("C:\\x\\resources")), "file:///C:/x/resources");
    }
}
