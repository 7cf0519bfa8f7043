//! Checks an FMU's file: how it is packed, its model description and its libraries; and, on request, the library of this
//! machine at work. Nothing is printed here.

use crate::build::compile::GLIBC;
use crate::host::fmu::Fmu;
use crate::host::instance::{Instance, Type};
use crate::host::library::FUNCTIONS;
use crate::package::binary::Binary;
use crate::package::{DESCRIPTION, LibraryFile, Package};
use anyhow::{Context, Result, bail, ensure};
use modeldescription::shortened;
use modeldescription::v2::{ModelDescription, Typed, Variable};
use std::io::{Read, Seek};
use std::path::Path;

/// How many communication steps an FMU makes when it is run.
pub const STEPS: u32 = 10;

/// What a check has found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// The libraries that can be read, and what they export and need.
    pub libraries: Vec<(LibraryFile, Binary)>,
    /// What keeps a host from using the FMU, a sentence each. An FMU without any is as it should be.
    pub errors: Vec<String>,
    /// What may mislead a host or its user, a sentence each.
    pub remarks: Vec<String>,
}

/// Reads all of an FMU and checks it. None of its code runs.
pub fn check<R: Read + Seek>(package: &mut Package<R>) -> Report {
    let mut report = Report::default();
    let impossible = |variable: &&Variable| !variable.causality.allows(variable.variability);
    for variable in package.description.model_variables.iter().filter(impossible) {
        report.errors.push(format!("{DESCRIPTION}: {}", contradiction(variable)));
    }
    let is_error = |finding: &String| report.errors.iter().any(|error| error.ends_with(finding.as_str()));
    let mut findings = modeldescription::v2::check(&package.description);
    findings.retain(|finding| !is_error(finding));
    report.remarks = findings;
    report.errors.truncate(modeldescription::v2::MOST_FINDINGS);
    for file in package.libraries.clone() {
        match check_library(package, &file) {
            Ok(binary) => report.libraries.push((file, binary)),
            Err(error) => report.errors.push(format!("{}: {error:#}", file.path)),
        }
    }
    report
}

/// Reads a library and checks that it belongs to the model description.
fn check_library<R: Read + Seek>(package: &mut Package<R>, file: &LibraryFile) -> Result<Binary> {
    let bytes = package.library(file)?;
    let binary = Binary::read(&bytes)?;
    if package.description.co_simulation.is_some()
        && let Some(missing) = binary.missing(FUNCTIONS)
    {
        bail!("it does not export {missing}");
    }
    let guid = &package.description.guid;
    // A library with a table holds its GUID as text. Others may compute theirs, or hold none.
    if binary.has_table && !contains(&bytes, guid.as_bytes()) {
        let guid = shortened(guid);
        bail!("it does not contain the GUID {guid:?} of {DESCRIPTION}: the two come from different builds");
    }
    Ok(binary)
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    !part.is_empty() && bytes.windows(part.len()).any(|window| window == part)
}

fn contradiction(variable: &Variable) -> String {
    let Variable { causality, variability, .. } = variable;
    let name = shortened(&variable.name);
    format!("variable {name:?}: causality = {causality} and variability = {variability} are not allowed together")
}

/// Checks an FMU that was just packed: everything that its users rely on. If it is to be portable, its Linux libraries need
/// glibc [`GLIBC`] at most.
///
/// # Errors
/// What is wrong.
pub fn packed(path: &Path, description: &ModelDescription, is_portable: bool) -> Result<()> {
    let mut package = Package::open(path)?;
    ensure!(package.description == *description, "{DESCRIPTION} does not read back as it was written");
    let report = check(&mut package);
    ensure!(report.errors.is_empty(), report.errors.join("; "));
    ensure!(report.remarks.is_empty(), "{DESCRIPTION}: {}", report.remarks.join("; "));
    for (file, binary) in &report.libraries {
        let portable = || if is_portable { binary.check_portable(GLIBC) } else { Ok(()) };
        binary.check_functions(FUNCTIONS).and_then(|()| portable()).with_context(|| file.path.clone())?;
    }
    run(&mut package, path.parent().unwrap_or(Path::new(".")))
}

/// Loads the library for this machine and runs it: it accepts its own GUID and no other, makes [`STEPS`] steps, and all its
/// variables can be read. The FMU is unpacked into a temporary folder below `place`.
///
/// # Errors
/// There is no such library, or a call fails.
pub fn run<R: Read + Seek>(package: &mut Package<R>, place: &Path) -> Result<()> {
    ensure!(
        package.description.co_simulation.is_some(),
        "it is for model exchange only and cannot make steps by itself"
    );
    let fmu = Fmu::load(package, place)?;
    let description = &fmu.description;
    ensure!(
        Instance::instantiate(&fmu.library, "plcfmu", "{00000000-0000-0000-0000-000000000000}", None).is_err(),
        "its library accepts any GUID, not only that of {DESCRIPTION}"
    );
    let mut instance = fmu.instantiate("plcfmu")?;
    let experiment = description.default_experiment.unwrap_or_default();
    let start = experiment.start_time.unwrap_or(0.0);
    let step = experiment.step_size.unwrap_or(0.01);
    instance.setup(start, None)?;
    instance.enter_initialization()?;
    instance.exit_initialization()?;
    for call in 0..STEPS {
        instance.step(start + f64::from(call) * step, step)?;
    }
    for variable in &description.model_variables {
        let Some(kind) = fmi_type(&variable.typed) else { continue };
        let value = instance.get(kind, variable.value_reference);
        value.with_context(|| format!("{:?} cannot be read", shortened(&variable.name)))?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::archive;
    use crate::package::binary::tests::macos;
    use modeldescription::v2::{Interface, Variability};

    /// The description of a small block.
    fn description() -> ModelDescription {
        let json = r#"{"table":{"name":"PUMP","docs":"Pumps.","cycle":0,"variables":[
            {"name":"CYCLE","description":"x","kind":"TIME","role":"cycle","start":1.0,"min":0.001,"max":null,"unit":null}],
            "response":{"title":"x","calls":3,"set":[],"show":[]}},
            "interface":{"version":"2.0","guid":"{1}","capabilities":{},"log_categories":[]}}"#;
        ModelDescription::of(&Interface::parse(json).unwrap()).unwrap()
    }

    /// What the check says of an FMU with this library.
    fn verdict(library: &[u8], expected: &ModelDescription) -> String {
        let files = [
            ("modelDescription.xml".to_string(), modeldescription::v2::write(&description())),
            ("binaries/linux64/PUMP.so".to_string(), library.to_vec()),
        ];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("PUMP.fmu");
        std::fs::write(&path, archive::write(&files.into()).unwrap()).unwrap();
        format!("{:#}", packed(&path, expected, false).unwrap_err())
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
            error.starts_with("binaries/linux64/PUMP.so: it is not a library of Linux, Windows or macOS: "),
            "{error}"
        );
    }

    /// What the check says of an FMU with this description and this library for macOS.
    fn report(description: &ModelDescription, library: Vec<u8>) -> Report {
        let files = [
            ("modelDescription.xml".to_string(), modeldescription::v2::write(description)),
            ("binaries/darwin64/PUMP.dylib".to_string(), library),
        ];
        let bytes = archive::write(&files.into()).unwrap();
        check(&mut Package::read(std::io::Cursor::new(bytes)).unwrap())
    }

    fn library(has_table: bool, guid: &str) -> Vec<u8> {
        let table = has_table.then_some("plcfmu_interface");
        let functions: Vec<&str> = FUNCTIONS.iter().copied().chain(table).collect();
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
            [
                "binaries/darwin64/PUMP.dylib: it does not contain the GUID \"{2}\" of modelDescription.xml: the two come \
              from different builds"
            ]
        );
        // A library of another tool may compute its GUID.
        assert_eq!(report(&falsified, library(false, "{1}")).errors, [""; 0]);
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
                 allowed together"
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
