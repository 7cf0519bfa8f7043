//! Writes a system as an SSP file (System Structure and Parameterization), for tools that run systems of FMUs: the
//! FMUs, their start values and their connections.
//!
//! Element names are C identifiers, and none is a prefix of another: OMSimulator rejects other characters, and FMPy's
//! master mistakes the parameters of `P10` for those of `P1`.

use crate::package::check;
use crate::package::preset::identifier;
use anyhow::{Context, Result, bail, ensure};
use askama::Template;
use host::package::{Package, archive};
use modeldescription::{Causality, Description, Type, Unit};
use run::plan::{Names, Plan, effective, value, wires};
use run::system::{Exchange, Setting, System, Value};
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// The name of each set of start values. Ecos selects the set to apply by name.
pub const PARAMETER_SET: &str = "start";

/// The options for writing an SSP file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The version of the standard stated in the file.
    pub version: Version,
    /// Omit the connectors of inputs that are not connected: FMPy's master cannot handle them.
    pub only_connected: bool,
}

/// A version of the SSP standard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Version {
    /// SSP 1.0, which all tools read.
    #[default]
    #[value(name = "1.0")]
    V1,
    /// SSP 2.0.
    #[value(name = "2.0")]
    V2,
}

/// An SSP file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ssp {
    /// Its contents. The same system and FMUs always yield the same bytes.
    pub bytes: Vec<u8>,
    /// The number of FMUs in it; a file used by several components is stored once.
    pub fmus: usize,
    /// The number of connectors.
    pub connectors: usize,
    /// Remarks for the user: changed names, and information that an SSP file cannot hold.
    pub remarks: Vec<String>,
}

#[derive(Template)]
#[template(path = "SystemStructure.xml")]
struct Structure<'a> {
    version: &'static str,
    name: &'a str,
    parameter_set: &'static str,
    components: Vec<Component<'a>>,
    connections: Vec<Connection<'a>>,
    units: Vec<UnitDefinition<'a>>,
    start: f64,
    stop: f64,
}

struct Component<'a> {
    name: &'a str,
    source: String,
    connectors: Vec<Connector<'a>>,
    parameters: Vec<Parameter<'a>>,
}

struct Connector<'a> {
    name: &'a str,
    kind: &'static str,
    /// `None` for an enumeration, whose type is defined in the FMU.
    type_name: Option<&'static str>,
    unit: Option<&'a str>,
}

struct Parameter<'a> {
    name: &'a str,
    type_name: &'static str,
    value: String,
}

/// Element and connector of both ends.
struct Connection<'a> {
    from: (&'a str, &'a str),
    to: (&'a str, &'a str),
}

struct UnitDefinition<'a> {
    name: &'a str,
    attributes: Vec<(&'static str, String)>,
}

/// The FMUs of a system, each file once.
struct Resources {
    /// Canonical path, name in the SSP file, content, description.
    files: Vec<(PathBuf, String, Vec<u8>, Description)>,
    /// The index of each member's file.
    of: Vec<usize>,
}

/// Creates an SSP file from a system, with the given name, without running its FMUs.
///
/// # Errors
/// An FMU, name, value or connection is unsuitable; the error states the remedy.
pub fn write(system: &System, name: &str, options: Options) -> Result<Ssp> {
    let resources = Resources::open(system)?;
    let descriptions: Vec<&Description> = resources.of.iter().map(|of| &resources.files[*of].3).collect();
    let plan = Plan::new(system, &descriptions)?;
    let names = Names::new(system, &descriptions)?;
    let wires = wires(&names, &system.connections)?;
    let settings = effective(&names, &system.settings, &wires)?;
    let elements = identifiers(&system.members.iter().map(|member| member.name.as_str()).collect::<Vec<_>>())?;

    let mut components = Vec::new();
    for (member, description) in descriptions.iter().enumerate() {
        let is_connected =
            |name: &str| wires.iter().any(|wire| wire.to.member == member && wire.to.variable.name == name);
        let connectors = description.variables.iter().filter_map(|variable| {
            let kind = match variable.causality {
                Causality::Input if options.only_connected && !is_connected(&variable.name) => return None,
                Causality::Input => "input",
                Causality::Output => "output",
                _ => return None,
            };
            // An enumeration has none of SSP's basic types.
            let type_name = variable.kind.map_or(variable.type_name, |kind| type_name_of(kind, options.version));
            let type_name = (!variable.is_enumeration()).then_some(type_name);
            Some(Connector { name: &variable.name, kind, type_name, unit: variable.unit.as_deref() })
        });
        let mut parameters = Vec::new();
        for (setting, reference) in
            settings.iter().filter(|(of, reference)| reference.member == member && of.time.is_none())
        {
            let number = value(reference.kind, setting.value)?;
            let (type_name, value) = (type_name_of(reference.kind, options.version), reference.kind.text(number));
            parameters.push(Parameter { name: &reference.variable.name, type_name, value });
        }
        components.push(Component {
            name: &elements[member],
            source: format!("resources/{}", resources.files[resources.of[member]].1),
            connectors: connectors.collect(),
            parameters,
        });
    }
    let connections = wires.iter().map(|wire| Connection {
        from: (&elements[wire.from.member], &wire.from.variable.name),
        to: (&elements[wire.to.member], &wire.to.variable.name),
    });
    let units = units(&components, &resources)?;
    let connectors = components.iter().map(|component| component.connectors.len()).sum();
    let structure = Structure {
        version: match options.version {
            Version::V1 => "1.0",
            Version::V2 => "2.0",
        },
        name,
        parameter_set: PARAMETER_SET,
        connections: connections.collect(),
        units,
        components,
        start: plan.start,
        stop: plan.time(plan.steps),
    };
    let mut files = BTreeMap::from([("SystemStructure.ssd".to_string(), structure.render()?.into_bytes())]);
    let fmus = resources.files.len();
    let remarks = remarks(system, &plan, &elements);
    drop(structure);
    for (_, name, content, _) in resources.files {
        files.insert(format!("resources/{name}"), content);
    }
    Ok(Ssp { bytes: archive::write(&files)?, fmus, connectors, remarks })
}

/// The name of a type in an SSP version: only 2.0 has the FMI 3.0 types.
fn type_name_of(kind: Type, version: Version) -> &'static str {
    match (kind, version) {
        (Type::Real | Type::Integer | Type::Boolean, _) | (_, Version::V2) => kind.name(),
        (kind, Version::V1) if kind.is_floating() => Type::Real.name(),
        (_, Version::V1) => Type::Integer.name(),
    }
}

impl Resources {
    fn open(system: &System) -> Result<Resources> {
        let mut resources = Resources { files: Vec::new(), of: Vec::new() };
        for member in &system.members {
            let shown = || member.path.display().to_string();
            let path = fs::canonicalize(&member.path).with_context(shown)?;
            if let Some(place) = resources.files.iter().position(|(other, ..)| *other == path) {
                resources.of.push(place);
                continue;
            }
            let content = fs::read(&path).with_context(shown)?;
            let mut package = Package::read(Cursor::new(&content)).with_context(shown)?;
            // Recipients must not get an FMU that `plcfmu check` rejects.
            let errors = check::check(&mut package).errors;
            ensure!(errors.is_empty(), "{}: the FMU is faulty: {}", shown(), errors.join("; "));
            let description = package.description;
            if description.co_simulation.is_none() {
                bail!("{}: the FMU is for model exchange only; only co-simulation is supported", shown());
            }
            if let Some(array) = description.arrays.first() {
                bail!(
                    "{}: {} is an array, which tools do not find in an SSP file: pack the FMU with --types wide",
                    shown(),
                    array.name
                );
            }
            let stem = identifier(&path.file_stem().unwrap_or_default().to_string_lossy());
            let is_taken = |name: &str| resources.files.iter().any(|(_, other, ..)| other.eq_ignore_ascii_case(name));
            let mut name = format!("{stem}.fmu");
            let mut number = 2;
            while is_taken(&name) {
                name = format!("{stem}_{number}.fmu");
                number += 1;
            }
            resources.of.push(resources.files.len());
            resources.files.push((path, name, content, description));
        }
        Ok(resources)
    }
}

/// The definitions of all units used by connectors. A unit name can have only one definition in a file.
fn units<'a>(components: &[Component], resources: &'a Resources) -> Result<Vec<UnitDefinition<'a>>> {
    let mut used: Vec<&str> = components.iter().flat_map(|of| &of.connectors).filter_map(|of| of.unit).collect();
    used.sort_unstable();
    used.dedup();
    let mut definitions = Vec::new();
    for name in used {
        let of_files = resources.files.iter().filter_map(|(.., file, _, description)| {
            let unit = description.units.iter().find(|unit| unit.name == name)?;
            Some((file, unit))
        });
        let mut of_files = of_files.peekable();
        let Some((file, unit)) = of_files.next() else {
            bail!("no FMU defines the unit {name}, although one uses it");
        };
        if let Some((other, _)) = of_files.find(|(_, other)| other.base_unit != unit.base_unit) {
            bail!("{file} and {other} define the unit {name} differently: one SSP file cannot hold both");
        }
        let Unit { name, base_unit, .. } = unit;
        definitions.push(UnitDefinition { name, attributes: base_unit.unwrap_or_default().list() });
    }
    Ok(definitions)
}

/// Remarks on what an SSP file cannot hold, and on changed names.
fn remarks(system: &System, plan: &Plan, elements: &[String]) -> Vec<String> {
    let mut remarks = Vec::new();
    for (member, element) in system.members.iter().zip(elements).filter(|(member, element)| member.name != **element) {
        remarks.push(format!("{} is named {element} in the SSP file", member.name));
    }
    let event = |setting: &Setting| {
        let value = match setting.value {
            Value::Boolean(value) => value.to_string(),
            Value::Whole(whole) => whole.to_string(),
            Value::Number(number) => number.to_string(),
        };
        Some(format!("{} = {value} at {} s", setting.variable, setting.time?))
    };
    let events: Vec<_> = system.settings.iter().filter_map(event).collect();
    if !events.is_empty() {
        remarks.push(format!("an SSP file cannot set values during a run; left out: {}", events.join(", ")));
    }
    if system.exchange == Exchange::Sequential && !system.connections.is_empty() {
        remarks.push(
            "an SSP file does not specify the order of FMUs: libcosim and Ecos exchange all values at the same time, as \
             plcfmu run --parallel does"
                .into(),
        );
    }
    remarks.push(format!("an SSP file has no communication step: set {} s in the tool that runs it", plan.step));
    remarks
}

/// Names as C identifiers, none of which is a prefix of another.
fn identifiers(names: &[&str]) -> Result<Vec<String>> {
    let mut identifiers: Vec<String> = names.iter().map(|name| identifier(name)).collect();
    // Longest first: a name that is a prefix of another is lengthened.
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_key(|place| std::cmp::Reverse(identifiers[*place].len()));
    let mut taken: Vec<String> = Vec::new();
    for place in order {
        let own = &identifiers[place];
        let longer = std::iter::once('_').chain('A'..='Z').map(|last| format!("{own}{last}"));
        // Further candidates, for names that have become equal as identifiers.
        let base = own.trim_end_matches('_');
        let numbered = (2..=names.len() + 1).map(|number| format!("{base}x{number}_"));
        let mut candidates = std::iter::once(own.clone()).chain(longer).chain(numbered);
        let is_free = |name: &String| !taken.iter().any(|other| other.starts_with(name) || name.starts_with(other));
        let Some(free) = candidates.find(is_free) else {
            bail!("{} is a prefix of too many other FMU names: rename it", names[place]);
        };
        taken.push(free.clone());
        identifiers[place] = free;
    }
    Ok(identifiers)
}

/// The name of the system in a file with this name.
pub fn system_name(file: &Path) -> String {
    identifier(&file.file_stem().unwrap_or_default().to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_c_identifiers_of_which_none_begins_another() {
        let changed = |names: &[&str]| identifiers(names).unwrap();
        assert_eq!(changed(&["TIC101", "TIC102"]), ["TIC101", "TIC102"]);
        assert_eq!(changed(&["1-2 ä", "DB4"]), ["_1_2__", "DB4"]);
        assert_eq!(changed(&["DB4", "DB41"]), ["DB4_", "DB41"]);
        assert_eq!(changed(&["DB4", "DB4_", "DB4"]), ["DB4A", "DB4_", "DB4B"]);
        for names in [vec!["a", "aa", "aaa", "a_", "a-", "A"], vec!["P", "P_", "P_", "P_A", "P__", ""]] {
            let changed = changed(&names);
            for (place, one) in changed.iter().enumerate() {
                let others = changed.iter().enumerate().filter(|(other, _)| *other != place);
                assert!(others.into_iter().all(|(_, other)| !other.starts_with(one)), "{names:?}: {changed:?}");
            }
        }
    }

    #[test]
    fn the_system_is_called_as_its_file() {
        assert_eq!(system_name(Path::new("a/plant 1.ssp")), "plant_1");
    }
}
