//! Checks an FMU file: its packaging, its model description and its libraries; on request, also runs the library for
//! this machine. Nothing is printed here.

use crate::build::compile::GLIBC;
use crate::build::platform;
use crate::package::preset;
use anyhow::{Context, Result, bail, ensure};
use blocks::table::start::Start;
use host::fmu::Fmu;
use host::instance::Instance;
use host::library::{self, FUNCTIONS};
use host::package::archive::Archive;
use host::package::binary::Binary;
use host::package::{DESCRIPTION, LibraryFile, Package, temporary};
use memchr::memmem;
use modeldescription::v3::{BUILD_DESCRIPTION, BuildDescription};
use modeldescription::{Array, Causality, Description, Interface, ModelDescription, Variable, shortened};
use run::component::MOST_UPDATES;
use run::plan::has_events;
use std::io::{Read, Seek};
use std::path::Path;

/// The number of communication steps in a trial run of an FMU.
pub const STEPS: u32 = 10;

/// A GUID that no FMU has.
const NO_GUID: &str = "{00000000-0000-0000-0000-000000000000}";

/// The maximum relative difference between the start value in the model description and the library's: the text may
/// have fewer digits.
const ROUNDED: f64 = 1e-6;

/// The maximum size of a build description, in bytes.
const LARGEST_BUILD_DESCRIPTION: u64 = 1 << 20;

/// The results of a check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// The readable libraries, with their exports and requirements.
    pub libraries: Vec<(LibraryFile, Binary)>,
    /// Problems that keep a host from using the FMU, one sentence each. A correct FMU has none.
    pub errors: Vec<String>,
    /// Deviations from the standard that hosts tolerate, one sentence each.
    pub departures: Vec<String>,
    /// Features that may mislead a host or its user, one sentence each.
    pub remarks: Vec<String>,
}

/// Reads an entire FMU and checks it without running its code.
pub fn check<R: Read + Seek>(package: &mut Package<R>) -> Report {
    let preset = preset::start(package);
    let found = package.xml.check(matches!(preset, Ok(Some(_))));
    let named =
        |findings: Vec<String>| findings.into_iter().map(|finding| format!("{DESCRIPTION}: {finding}")).collect();
    let (errors, departures) = (named(found.forbidden), named(found.departures));
    let mut report = Report { errors, departures, remarks: found.odd, ..Report::default() };
    // Every file must be intact, because a host unpacks all of them.
    report.errors.extend(package.archive.verify().err().map(|error| format!("{error:#}")));
    for name in package.xml.sources() {
        let path = format!("sources/{name}");
        if package.archive.find(&path).is_none() {
            let name = shortened(name);
            report.errors.push(format!("{DESCRIPTION}: SourceFiles names {name:?}, but {path:?} is missing"));
        }
    }
    check_build(package, &mut report);
    report.errors.extend(misnamed(package));
    for file in package.libraries.clone() {
        match check_library(package, &file, &preset) {
            Ok(binary) => report.libraries.push((file, binary)),
            Err(error) => report.errors.push(format!("{}: {error:#}", file.path)),
        }
    }
    report
}

/// Checks the FMI 3.0 build description, which specifies how to compile the sources.
fn check_build<R: Read + Seek>(package: &mut Package<R>, report: &mut Report) {
    if !package.description.is_fmi_3() {
        return;
    }
    if package.archive.find(BUILD_DESCRIPTION).is_none() {
        let is_source = |path: &str| path.starts_with("sources/") && !path.ends_with('/');
        if let Some(source) = package.archive.entries().iter().find(|entry| is_source(&entry.name)) {
            let source = shortened(&source.name);
            report.departures.push(format!("{source:?} has no {BUILD_DESCRIPTION:?} that describes how to compile it"));
        }
        return;
    }
    let read = |archive: &mut Archive<R>| -> Result<BuildDescription> {
        Ok(BuildDescription::read(&archive.read(BUILD_DESCRIPTION, LARGEST_BUILD_DESCRIPTION)?)?)
    };
    let build = match read(&mut package.archive) {
        Ok(build) => build,
        Err(error) => return report.errors.push(format!("{BUILD_DESCRIPTION}: {error:#}")),
    };
    if let count @ 2.. = build.configurations.len() {
        report.remarks.push(format!(
            "{BUILD_DESCRIPTION}: it has {count} build configurations, but some hosts read only the first"
        ));
    }
    let kinds = [&package.description.co_simulation, &package.description.model_exchange];
    let own: Vec<&str> = kinds.into_iter().flatten().map(|of| of.model_identifier.as_str()).collect();
    for configuration in &build.configurations {
        let named = &configuration.model_identifier;
        if let [first, ..] = own[..]
            && !own.contains(&named.as_str())
        {
            let (named, own) = (shortened(named), shortened(first));
            report.errors.push(format!(
                "{BUILD_DESCRIPTION}: modelIdentifier = {named:?}, but {DESCRIPTION} has {own:?}: correct one of them"
            ));
        }
        for file in configuration.source_file_sets.iter().flat_map(|set| &set.source_files) {
            let path = format!("sources/{}", file.name);
            if package.archive.find(&path).is_none() {
                let (name, path) = (shortened(&file.name), shortened(&path));
                report.errors.push(format!("{BUILD_DESCRIPTION}: SourceFile names {name:?}, but {path:?} is missing"));
            }
        }
    }
}

/// The functions that a library must export for co-simulation in the FMU's FMI version.
fn functions(description: &Description) -> &'static [&'static str] {
    if description.is_fmi_3() { library::v3::FUNCTIONS } else { FUNCTIONS }
}

/// If the FMU has no library with the right name, reports files that look like libraries but have another name.
fn misnamed<R: Read + Seek>(package: &Package<R>) -> Vec<String> {
    let Some(identifier) = package.description.model_identifier().filter(|_| package.libraries.is_empty()) else {
        return Vec::new();
    };
    let is_library = |path: &str| {
        let folder = path.strip_prefix("binaries/").and_then(|path| path.split_once('/'));
        folder.and_then(|(folder, file)| Some(file.ends_with(platform::system(folder)?.1))).unwrap_or(false)
    };
    let names = package.archive.entries().iter().map(|entry| entry.name.as_str()).filter(|path| is_library(path));
    names
        .map(|path| format!("{path}: it is not named {}, the name that hosts look for", shortened(identifier)))
        .collect()
}

/// Reads a library and checks that it matches the model description.
fn check_library<R: Read + Seek>(
    package: &mut Package<R>,
    file: &LibraryFile,
    preset: &Result<Option<Start>>,
) -> Result<Binary> {
    let bytes = package.library(file)?;
    let binary = Binary::read(&bytes)?;
    // In other folders, which FMI permits, any library may be for any system.
    if let Some((_, suffix)) = platform::system(&file.platform) {
        is_for(&binary, &file.platform)?;
        ensure!(file.path.ends_with(suffix), "hosts look there for a library whose name ends in {suffix}");
    }
    if package.description.co_simulation.is_some()
        && let Some(missing) = binary.missing(functions(&package.description))
    {
        bail!("it does not export {missing}");
    }
    let guid = &package.description.guid;
    // A library with a table contains its GUID as text. Other libraries may compute theirs.
    if !binary.has_table {
        return Ok(binary);
    }
    let path = preset::path();
    match preset {
        // Every library contains the null GUID, so finding it would prove nothing.
        Ok(None) if guid != NO_GUID && contains(&bytes, guid.as_bytes()) => Ok(binary),
        Ok(Some(start)) if contains(&bytes, start.library.as_bytes()) => Ok(binary),
        Ok(Some(start)) => {
            let library = shortened(&start.library);
            bail!(
                "it does not contain the GUID {library:?}, for which {path} was made: they are from different builds"
            );
        }
        Ok(None) => {
            let guid = shortened(guid);
            bail!(
                "it does not contain the GUID {guid:?} of {DESCRIPTION}, and a preset's start values, {path}, are \
                 missing: the library and the description are from different builds, or {path} was removed"
            );
        }
        Err(error) => bail!("{error:#}"),
    }
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    !part.is_empty() && memmem::find(bytes, part).is_some()
}

/// Checks that a library is for the platform of this FMI folder.
fn is_for(binary: &Binary, folder: &str) -> Result<()> {
    let (system, _) = platform::system(folder).with_context(|| format!("FMI has no platform {folder}"))?;
    let processors = platform::architectures(folder);
    let is_known = |own: &String| processors.contains(&own.as_str());
    // If the folder is for one macOS processor, a universal file, which is for both, also suits it.
    let is_enough = match system {
        "macOS" if processors.len() == 1 => binary.architectures.iter().any(is_known),
        _ => binary.architectures.iter().all(is_known),
    };
    ensure!(
        binary.system == system && is_enough,
        "it is a {} library for {}; {folder} needs a {system} library for {}",
        binary.system,
        binary.architectures.join(" and "),
        processors.join(" and ")
    );
    Ok(())
}

/// Checks a library to be packed for an FMI platform: it must be for this platform, export exactly FMI's functions,
/// require nothing beyond a standard system, and contain the same table as the library that was run.
///
/// If `is_native`, it was linked for this machine's Linux and may need a newer glibc than [`GLIBC`].
///
/// # Errors
/// The library does not meet one of these requirements; the error states which.
pub fn library(bytes: &[u8], folder: &str, interface: &Interface, is_native: bool) -> Result<()> {
    let binary = Binary::read(bytes)?;
    is_for(&binary, folder)?;
    binary.check_functions(&[FUNCTIONS, fmu::v3::ffi::FUNCTIONS].concat())?;
    binary.check_needed()?;
    if !is_native {
        binary.check_portable(GLIBC)?;
    }
    // The GUID covers everything on which a host relies. Texts are not covered, so they are compared separately.
    let guid = &interface.guid;
    ensure!(contains(bytes, guid.as_bytes()), "it does not contain the GUID {guid}: it was built from other sources");
    let table = &interface.table;
    let descriptions = table.rows.iter().flat_map(|row| [&row.description, &row.help]).filter(|text| !text.is_empty());
    if let Some(text) = descriptions.chain([&table.docs]).find(|text| !contains(bytes, text.as_bytes())) {
        bail!("it does not contain the text {:?}: it was built from other sources", shortened(text));
    }
    Ok(())
}

/// Checks an FMU that was just packed from libraries that [`library()`] has accepted. If it contains a library for this
/// machine, it is run.
///
/// # Errors
/// The FMU is faulty; the error describes the problem.
pub fn packed(path: &Path, xml: &ModelDescription, has_host: bool) -> Result<()> {
    let mut package = Package::open(path)?;
    ensure!(package.xml == *xml, "{DESCRIPTION} does not read back as it was written");
    let report = check(&mut package);
    ensure!(report.errors.is_empty(), report.errors.join("; "));
    ensure!(report.departures.is_empty(), report.departures.join("; "));
    ensure!(report.remarks.is_empty(), "{DESCRIPTION}: {}", report.remarks.join("; "));
    if has_host {
        run(&mut package, temporary::folder(path))?;
    }
    Ok(())
}

/// Loads the library for this machine and runs it: it must accept only its own GUID, start with the declared values,
/// make [`STEPS`] steps, and return the values of all its variables. The FMU is unpacked into a temporary folder below
/// `place`.
///
/// # Errors
/// The library is missing, or a call fails.
pub fn run<R: Read + Seek>(package: &mut Package<R>, place: &Path) -> Result<()> {
    ensure!(
        package.description.co_simulation.is_some(),
        "it is for model exchange only and cannot be stepped without a solver"
    );
    let fmu = Fmu::load(package, place)?;
    let description = &fmu.description;
    ensure!(
        fmu.instantiate_with("plcfmu", NO_GUID, false).is_err(),
        "its library accepts any {}, not only the one in {DESCRIPTION}",
        token(description)
    );
    let mut instance = fmu.instantiate("plcfmu", false)?;
    let experiment = description.default_experiment.unwrap_or_default();
    let start = experiment.start_time.unwrap_or(0.0);
    let step = experiment.step_size.unwrap_or(0.01);
    instance.setup(start, None)?;
    instance.enter_initialization()?;
    instance.exit_initialization()?;
    check_starts(description, &mut instance)?;
    for call in 0..STEPS {
        instance.step(start + f64::from(call) * step, step)?;
    }
    for variable in description.variables.iter().filter(|of| !is_further_element(description, of)) {
        let Some(kind) = variable.kind else { continue };
        let value = instance.get(kind, variable.value_reference);
        value.with_context(|| format!("{:?} cannot be read", shortened(&variable.name)))?;
    }
    instance.terminate()?;
    drop(instance);
    run_with_events(&fmu, start, step).context("in Event Mode")
}

/// Whether a variable is an array element other than the first, through which the whole array is read.
fn is_further_element(description: &Description, of: &Variable) -> bool {
    let is_in = |array: &Array| {
        let place = of.value_reference.checked_sub(array.first_reference);
        place.is_some_and(|place| place > 0 && (place as usize) < array.count)
    };
    description.arrays.iter().any(is_in)
}

/// The FMI version's term for the string by which a library recognizes its model description.
fn token(description: &Description) -> &'static str {
    if description.is_fmi_3() { "instantiation token" } else { "GUID" }
}

/// Runs the FMU again with Event Mode, if it supports it: an event is handled before each step.
fn run_with_events(fmu: &Fmu, start: f64, step: f64) -> Result<()> {
    if !has_events(&fmu.description) {
        return Ok(());
    }
    let mut instance = fmu.instantiate("plcfmu", true)?;
    instance.setup(start, None)?;
    instance.enter_initialization()?;
    instance.exit_initialization()?;
    for call in 0..STEPS {
        instance.enter_events()?;
        let mut updates = 0;
        while instance.update()?.is_needed {
            updates += 1;
            ensure!(updates < MOST_UPDATES, "fmi3UpdateDiscreteStates requests more than {MOST_UPDATES} calls");
        }
        instance.leave_events()?;
        instance.step(start + f64::from(call) * step, step)?;
    }
    instance.terminate()
}

/// Compares the start values of inputs and parameters, none of which has been set, with the declared values. To be
/// called after initialization, when a host may read them.
fn check_starts(description: &Description, instance: &mut Instance) -> Result<()> {
    for variable in &description.variables {
        let (Some(kind), Some(declared)) = (variable.kind, variable.start) else { continue };
        if !matches!(variable.causality, Causality::Input | Causality::Parameter) {
            continue;
        }
        let name = shortened(&variable.name);
        let own = instance.get(kind, variable.value_reference).with_context(|| format!("{name:?} cannot be read"))?;
        let is_same = own == declared || (own - declared).abs() <= ROUNDED * own.abs().max(declared.abs());
        ensure!(
            is_same || own.is_nan() && declared.is_nan(),
            "{name:?} starts with {own:?}, but its start value in {DESCRIPTION} is {declared:?}: hosts rely on the declared value"
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use doubles::macos;
    use host::package::archive;
    use modeldescription::Variability;
    use modeldescription::v2::{ModelDescription, write};
    use std::collections::BTreeMap;

    /// The description of a small block by its library.
    fn interface() -> Interface {
        let json = r#"{"table":{"name":"PUMP","docs":"Pumps.","cycle":0,"variables":[
            {"name":"CYCLE","description":"x","kind":"TIME","role":"cycle","start":1.0,"min":0.001,"max":null,"unit":null}],
            "responses":[{"title":"x","calls":3,"set":[],"show":[]}]},
            "interface":{"version":"2.0","guid":"{1}","capabilities":{},"log_categories":[]}}"#;
        Interface::parse(json).unwrap()
    }

    fn description() -> ModelDescription {
        ModelDescription::from_interface(&interface()).unwrap()
    }

    /// The findings for an FMU with this library.
    fn verdict(library: &[u8], expected: &ModelDescription) -> String {
        let files = [
            ("modelDescription.xml".to_string(), write(&description())),
            ("binaries/linux64/PUMP.so".to_string(), library.to_vec()),
        ];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("PUMP.fmu");
        std::fs::write(&path, archive::write(&files.into()).unwrap()).unwrap();
        format!("{:#}", packed(&path, &expected.clone().into(), true).unwrap_err())
    }

    #[test]
    fn an_fmu_with_another_description_than_the_one_written_is_not_let_out() {
        let other = ModelDescription { guid: "{2}".into(), ..description() };
        assert_eq!(verdict(b"", &other), "modelDescription.xml does not read back as it was written");
    }

    #[test]
    fn an_fmu_whose_library_is_damaged_is_not_let_out() {
        let error = verdict(b"hello", &description());
        assert!(
            error.starts_with("binaries/linux64/PUMP.so: it is not a library for Linux, Windows or macOS: "),
            "{error}"
        );
    }

    /// The findings for an FMU with this description and this library for macOS.
    fn report(description: &ModelDescription, library: Vec<u8>) -> Report {
        let files = [
            ("modelDescription.xml".to_string(), write(description)),
            ("binaries/darwin64/PUMP.dylib".to_string(), library),
        ];
        let bytes = archive::write(&files.into()).unwrap();
        check(&mut Package::read(std::io::Cursor::new(bytes)).unwrap())
    }

    fn library(has_table: bool, guid: &str) -> Vec<u8> {
        let table = has_table.then_some("plcfmu_interface");
        let functions: Vec<&str> = [FUNCTIONS, fmu::v3::ffi::FUNCTIONS].concat().into_iter().chain(table).collect();
        let mut bytes = macos(object::Architecture::X86_64, &functions);
        bytes.extend(guid.as_bytes());
        bytes
    }

    #[test]
    fn a_guid_that_a_library_with_a_table_does_not_contain_is_an_error() {
        let good = report(&description(), library(true, "{1}"));
        assert_eq!((good.errors, good.libraries.len()), (vec![], 1));
        let falsified = ModelDescription { guid: "{2}".into(), ..description() };
        assert_eq!(
            report(&falsified, library(true, "{1}")).errors,
            ["binaries/darwin64/PUMP.dylib: it does not contain the GUID \"{2}\" of modelDescription.xml, and a \
                 preset's start values, resources/start.txt, are missing: the library and the description are from \
                 different builds, or resources/start.txt was removed"]
        );
        // A library from another tool may compute its GUID.
        assert_eq!(report(&falsified, library(false, "{1}")).errors, [""; 0]);
    }

    #[test]
    fn a_library_of_another_platform_or_other_sources_is_not_packed() {
        let refusal = |library: &[u8], folder: &str| -> String {
            format!("{:#}", super::library(library, folder, &interface(), false).unwrap_err())
        };
        let good = [library(true, "{1}"), b"Pumps.".to_vec()].concat();
        super::library(&good, "darwin64", &interface(), false).unwrap();
        assert_eq!(
            refusal(&good, "win64"),
            "it is a macOS library for x86_64; win64 needs a Windows library for x86_64"
        );
        assert_eq!(
            refusal(&macos(object::Architecture::Arm, FUNCTIONS), "darwin64"),
            "it is a macOS library for arm; darwin64 needs a macOS library for x86_64 and aarch64"
        );
        let more: Vec<&str> = [FUNCTIONS, fmu::v3::ffi::FUNCTIONS, &["fmiOther"]].concat();
        assert_eq!(
            refusal(&macos(object::Architecture::X86_64, &more), "darwin64"),
            "it exports fmiOther, which is not an FMI co-simulation function"
        );
        assert_eq!(
            refusal(&library(true, "{2} Pumps."), "darwin64"),
            "it does not contain the GUID {1}: it was built from other sources"
        );
        assert_eq!(
            refusal(&library(true, "{1} pumps."), "darwin64"),
            "it does not contain the text \"Pumps.\": it was built from other sources"
        );
    }

    #[test]
    fn a_build_description_that_does_not_fit_is_found_by_name() {
        let newer = Interface { version: modeldescription::v3::FMI_VERSION.into(), ..interface() };
        let xml = modeldescription::ModelDescription::from_interface(&newer).unwrap().write();
        let report = |build: Option<&str>| {
            let mut files: BTreeMap<String, Vec<u8>> =
                [("modelDescription.xml".to_string(), xml.clone()), ("sources/PUMP.c".to_string(), b"int a;".to_vec())]
                    .into();
            files.extend(build.map(|text| (BUILD_DESCRIPTION.to_string(), text.as_bytes().to_vec())));
            let bytes = archive::write(&files).unwrap();
            check(&mut Package::read(std::io::Cursor::new(bytes)).unwrap())
        };
        let build = |body: &str| format!("<fmiBuildDescription fmiVersion=\"3.0\">\n{body}</fmiBuildDescription>");
        let configuration = |identifier: &str, file: &str| {
            format!(
                "<BuildConfiguration modelIdentifier=\"{identifier}\"><SourceFileSet><SourceFile name=\"{file}\"/></SourceFileSet></BuildConfiguration>\n"
            )
        };
        let good = configuration("PUMP", "PUMP.c");
        assert_eq!(report(Some(&build(&good))), Report::default());
        for (body, expected) in [
            (String::new(), "element BuildConfiguration is missing: add it"),
            (good.replace("</SourceFileSet>", ""), "line 2: this is not XML: "),
            (
                configuration("FAN", "PUMP.c"),
                "modelIdentifier = \"FAN\", but modelDescription.xml has \"PUMP\": correct one of them",
            ),
            (configuration("PUMP", "FAN.c"), "SourceFile names \"FAN.c\", but \"sources/FAN.c\" is missing"),
        ] {
            let errors = report(Some(&build(&body))).errors;
            let [error] = &errors[..] else { panic!("{errors:?}") };
            let rest = error.strip_prefix("sources/buildDescription.xml: ");
            assert!(rest.is_some_and(|rest| rest.starts_with(expected)), "{error}");
        }
        assert_eq!(
            report(Some(&build(&good.repeat(2)))).remarks,
            ["sources/buildDescription.xml: it has 2 build configurations, but some hosts read only the first"]
        );
        assert_eq!(
            report(None).departures,
            ["\"sources/PUMP.c\" has no \"sources/buildDescription.xml\" that describes how to compile it"]
        );
    }

    #[test]
    fn a_library_without_a_function_is_an_error_and_does_not_hide_others() {
        let mut wrong = description();
        wrong.model_variables[0].variability = Variability::Discrete;
        let library = macos(object::Architecture::X86_64, &FUNCTIONS[1..]);
        assert_eq!(
            report(&wrong, library).errors,
            [
                "modelDescription.xml: variable \"CYCLE\": causality = parameter and variability = discrete are not \
                 allowed together: change one of them"
                    .to_string(),
                format!("binaries/darwin64/PUMP.dylib: it does not export {}", FUNCTIONS[0])
            ]
        );
    }

    #[test]
    fn a_pair_of_causality_and_variability_that_importers_refuse_is_an_error_and_not_a_remark() {
        let mut wrong = description();
        wrong.model_variables[0].variability = Variability::Constant;
        let report = report(&wrong, library(true, "{1}"));
        assert_eq!(report.errors.len(), 1);
        assert!(!report.remarks.iter().any(|remark| remark.contains("not allowed together")), "{:?}", report.remarks);
    }
}
