//! What the packer checks: a library before it is packed, and the FMU with this machine's library at work.

use crate::build::compile::GLIBC;
use crate::build::platform;
use crate::host::fmu::Fmu;
use crate::host::functions::FUNCTIONS;
use crate::host::instance::{Instance, Type};
use crate::package::binary::Binary;
use crate::package::check::{check, contains};
use crate::package::{DESCRIPTION, Package, temporary};
use anyhow::{Context, Result, bail, ensure};
use modeldescription::shortened;
use modeldescription::v2::{Interface, ModelDescription, Typed};
use std::io::{Read, Seek};
use std::path::Path;

/// How many communication steps an FMU makes when it is run.
pub const STEPS: u32 = 10;

/// Checks a library that is to be packed for one of FMI's platforms: it is for this platform, exports FMI's functions and no
/// other, needs nothing that is not on every such system, and holds the same table as the library that was run.
///
/// `is_native` says that it was linked for this machine's Linux: it may need a newer glibc than [`GLIBC`].
///
/// # Errors
/// What is wrong, or differs.
pub fn library(bytes: &[u8], folder: &str, interface: &Interface, is_native: bool) -> Result<()> {
    let binary = Binary::read(bytes)?;
    let (system, _) = platform::system(folder).with_context(|| format!("FMI has no platform {folder}"))?;
    let processors = platform::architectures(folder);
    ensure!(
        binary.system == system && binary.architectures.iter().all(|own| processors.contains(&own.as_str())),
        "it is a library of {} for {}; {folder} needs one of {system} for {}",
        binary.system,
        binary.architectures.join(" and "),
        processors.join(" and ")
    );
    binary.check_functions(FUNCTIONS)?;
    binary.check_needed()?;
    if !is_native {
        binary.check_portable(GLIBC)?;
    }
    // The GUID is computed from all that a host relies on; the texts are not part of it.
    let guid = &interface.guid;
    ensure!(contains(bytes, guid.as_bytes()), "it does not contain the GUID {guid}: it was built from other sources");
    let table = &interface.table;
    let descriptions =
        table.variables.iter().flat_map(|row| [&row.description, &row.help]).filter(|text| !text.is_empty());
    if let Some(text) = descriptions.chain([&table.docs]).find(|text| !contains(bytes, text.as_bytes())) {
        bail!("it does not contain the text {:?}: it was built from other sources", shortened(text));
    }
    Ok(())
}

/// Checks an FMU that was just packed, with libraries that [`library`] has accepted. If it has one for this
/// machine, that is run.
///
/// # Errors
/// What is wrong.
pub fn packed(path: &Path, description: &ModelDescription, has_host: bool) -> Result<()> {
    let mut package = Package::open(path)?;
    ensure!(package.description == *description, "{DESCRIPTION} does not read back as it was written");
    let report = check(&mut package);
    ensure!(report.errors.is_empty(), report.errors.join("; "));
    ensure!(report.remarks.is_empty(), "{DESCRIPTION}: {}", report.remarks.join("; "));
    if has_host {
        run(&mut package, temporary::folder(path))?;
    }
    Ok(())
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
