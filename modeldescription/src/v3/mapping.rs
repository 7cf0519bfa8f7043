//! Maps a block's table to a model description: PLC types and roles in FMI 3.0.

use super::check::check;
use super::description::{
    Boolean, Causality, CoSimulation, Common, Dimension, Float, FloatAttributes, InitialUnknown, Integer,
    IntegerAttributes, InterfaceType, ModelDescription, ModelStructure, Output, Start, Typed, Unknown, Variable,
    VariableNamingConvention,
};
use crate::description::{self, GENERATION_TOOL, Initial};
use crate::error::Error;
use crate::findings::is_structured_name;
use crate::interface::Interface;
use crate::mapping::{causality, default_experiment, text_description, used_units};
use crate::names::Names;
use blocks::table::arrays::{Group, grouped};
use blocks::table::fingerprint;
use blocks::table::number::exact;
use blocks::{Class, Kind, Role, Row, Table, Text, Types, Value};
use std::collections::HashSet;

/// Returns the instantiation token of an FMU: its GUID combined with the version and the choice of types, so that the
/// library knows which interface is expected.
pub fn token(guid: &str, types: Types) -> String {
    let hash = fingerprint::parse(guid).unwrap_or(fingerprint::checksum(guid.as_bytes()));
    String::from_utf8_lossy(&fingerprint::text(types.token(hash))).into_owned()
}

impl ModelDescription {
    /// Creates the model description of the FMU with this library.
    ///
    /// As for FMI 2.0, but with the PLC's types unless [`Types::Wide`] is requested, with arrays kept as arrays, and
    /// with the time as the last variable.
    ///
    /// # Errors
    /// The table has an entry that is not allowed in a model description: an unknown unit, a start value out of range,
    /// or a duplicate name.
    pub fn from_interface(interface: &Interface) -> Result<ModelDescription, Error> {
        let table = &interface.table;
        let own = &interface.capabilities;
        let mut description = ModelDescription {
            model_name: table.name.clone(),
            instantiation_token: token(&interface.guid, interface.types),
            description: Some(table.summary()).filter(|summary| !summary.is_empty()),
            generation_tool: Some(GENERATION_TOOL.into()),
            co_simulation: Some(CoSimulation {
                of: InterfaceType {
                    model_identifier: table.name.clone(),
                    can_be_instantiated_only_once_per_process: own.can_be_instantiated_only_once_per_process,
                    can_get_and_set_fmu_state: own.can_get_and_set_fmu_state,
                    can_serialize_fmu_state: own.can_serialize_fmu_state,
                    ..InterfaceType::default()
                },
                can_handle_variable_communication_step_size: own.can_handle_variable_communication_step_size,
                might_return_early_from_do_step: true,
                has_event_mode: true,
                ..CoSimulation::default()
            }),
            unit_definitions: used_units(table, |row| unit(row, interface.types))?
                .into_iter()
                .map(Into::into)
                .collect(),
            log_categories: interface.log_categories.clone(),
            default_experiment: Some(default_experiment(table)),
            ..ModelDescription::default()
        };
        let (mut rows, mut texts) = (groups(table, interface.types), text_groups(table, interface.types));
        let names = interface.names;
        names
            .check(rows.iter().chain(&texts).map(|group| group.name.as_str()))
            .map_err(|reason| Error::new(format!("{}: {reason}", table.name)))?;
        for group in rows.iter_mut().chain(&mut texts) {
            group.name = names.convert(&group.name).into_owned();
        }
        for group in &rows {
            let variable = variable(table, group, interface.types)
                .map_err(|reason| Error::new(format!("{}: variable {}: {reason}", table.name, group.name)))?;
            description.model_variables.push(variable);
        }
        description.model_variables.extend(texts.iter().map(|group| text_variable(table, group)));
        let used: HashSet<&str> = description.model_variables.iter().map(|of| of.common.name.as_str()).collect();
        let mut time = "time".to_string();
        while used.contains(time.as_str()) {
            time.insert_str(0, &names.convert("FMI."));
        }
        description.model_variables.push(Variable {
            common: Common {
                name: time,
                value_reference: (table.rows.len() + table.texts.len()) as u32,
                description: Some("Simulation time in seconds".into()),
                causality: Causality::Independent,
                variability: Some(description::Variability::Continuous),
                ..Common::default()
            },
            ..Variable::default()
        });
        // The structured convention requires ASCII names and non-negative indices.
        let is_structured = |variable: &Variable| is_structured_name(&variable.common.name);
        if names == Names::Structured && description.model_variables.iter().all(is_structured) {
            description.variable_naming_convention = VariableNamingConvention::Structured;
        }
        description.model_structure = structure(table, &rows, &texts);
        match check(&description).all() {
            findings if findings.is_empty() => Ok(description),
            findings => Err(Error::new(format!("{}: {}", table.name, findings.join("\n")))),
        }
    }
}

/// The rows that form each variable.
fn groups(table: &Table, types: Types) -> Vec<Group> {
    let rows = table.rows.iter();
    grouped(rows.map(|row| (row.name.as_str(), (row.kind, row.role))), types.has_arrays())
}

/// The texts that form each variable.
fn text_groups(table: &Table, types: Types) -> Vec<Group> {
    let texts = table.texts.iter();
    grouped(texts.map(|text| (text.name.as_str(), (text.ty, text.role))), types.has_arrays())
}

/// The unit of a row, if it is a floating-point number; integers have no unit.
fn unit(row: &Row, types: Types) -> Option<&str> {
    let is_float = matches!(types.host_type(row.kind, row.is_analog), "Float32" | "Float64");
    if is_float { row.shown_unit() } else { None }
}

/// The common attributes of the variable for a group; `first` is the value reference of row (or text) 0.
fn common(group: &Group, first: usize, description: String, role: Role) -> Common {
    let (of, variability, initial) = causality(role);
    let of = match of {
        description::Causality::Parameter => Causality::Parameter,
        description::Causality::CalculatedParameter => Causality::CalculatedParameter,
        description::Causality::Input => Causality::Input,
        description::Causality::Output => Causality::Output,
        description::Causality::Local => Causality::Local,
        description::Causality::Independent => Causality::Independent,
    };
    let bounds = group.bounds.iter().map(|(low, high)| format!("{low}..{high}")).collect::<Vec<_>>().join(", ");
    let description = match (bounds.is_empty(), description.is_empty()) {
        (true, _) => description,
        (false, true) => format!("ARRAY[{bounds}]"),
        (false, false) => format!("{description}; ARRAY[{bounds}]"),
    };
    Common {
        name: group.name.clone(),
        value_reference: (first + group.rows[0]) as u32,
        description: Some(description).filter(|description| !description.is_empty()),
        causality: of,
        variability: Some(variability),
        initial: initial.filter(|initial| *initial == Initial::Calculated),
        ..Common::default()
    }
}

fn dimensions(group: &Group) -> Vec<Dimension> {
    let sizes = group.sizes();
    sizes.map(|size| Dimension { start: Some(size as u64), value_reference: None }).collect()
}

/// The variable for a text. Its description includes the length, because FMI has no attribute for it.
fn text_variable(table: &Table, group: &Group) -> Variable {
    let text: &Text = &table.texts[group.rows[0]];
    let starts = group.rows.iter().map(|place| Start { value: Some(table.texts[*place].start.clone()) });
    Variable {
        common: common(group, table.rows.len(), text_description(text), text.role),
        typed: Typed::String,
        dimensions: dimensions(group),
        starts: if text.role.is_settable() { starts.collect() } else { Vec::new() },
        aliases: Vec::new(),
    }
}

fn variable(table: &Table, group: &Group, types: Types) -> Result<Variable, String> {
    let rows: Vec<&Row> = group.rows.iter().map(|place| &table.rows[*place]).collect();
    let row = rows[0];
    let mut description = row.description.clone();
    // Integers have no unit in FMI.
    if let Some(unit) = types.unit(row.kind) {
        description = if description.is_empty() { format!("in {unit}") } else { format!("{description}; in {unit}") };
    }
    Ok(Variable {
        common: common(group, 0, description, row.role),
        typed: typed(&rows, types)?,
        dimensions: dimensions(group),
        ..Variable::default()
    })
}

/// The limit that all elements have in common; `None` if they differ.
fn shared<T: PartialEq>(rows: &[&Row], of: impl Fn(&Row) -> Option<T>) -> Option<T> {
    let first = of(rows[0]);
    first.filter(|first| rows.iter().all(|row| of(row).as_ref() == Some(first)))
}

fn typed(rows: &[&Row], types: Types) -> Result<Typed, String> {
    let row = rows[0];
    let (kind, name) = (row.kind, types.host_type(row.kind, row.is_analog));
    let is_set = row.role.is_settable();
    if kind == Kind::Time && row.unit.as_deref().is_some_and(|unit| unit != "s") {
        let unit = row.unit.as_deref().unwrap_or_default();
        return Err(format!("unit {unit:?}: a TIME is in seconds; remove its unit"));
    }
    if matches!(name, "Float32" | "Float64") {
        // A 32-bit number is written with the fewest digits that distinguish it from its neighbours.
        let value = |number: f64| match name {
            "Float32" => (number as f32).to_string().parse().unwrap_or(number),
            _ => number,
        };
        let own = Float {
            attributes: FloatAttributes {
                unit: unit(row, types).map(str::to_owned),
                display_unit: (kind == Kind::Time).then(|| "ms".into()),
                min: shared(rows, |row| row.least().map(value)),
                max: shared(rows, |row| row.greatest().map(value)),
                ..FloatAttributes::default()
            },
            start: is_set.then(|| rows.iter().map(|row| value(row.start())).collect()),
            ..Float::default()
        };
        return Ok(if name == "Float32" { Typed::Float32(own) } else { Typed::Float64(own) });
    }
    if kind.class() == Class::Boolean {
        if row.unit.is_some() || row.min.is_some() || row.max.is_some() {
            return Err("a BOOL cannot have a unit or a range; remove them".into());
        }
        let start = rows.iter().map(|row| row.start == Value::Bool(true)).collect();
        return Ok(Typed::Boolean(Boolean { start: is_set.then_some(start) }));
    }
    if let Some(unit) = row.unit.as_deref().filter(|_| !matches!(kind, Kind::Time | Kind::LTime)) {
        return Err(format!("unit {unit:?}: an FMI integer cannot have a unit; put it in the description"));
    }
    let own = Integer {
        attributes: IntegerAttributes {
            quantity: None,
            min: shared(rows, |row| row.min.and_then(exact)),
            max: shared(rows, |row| row.max.and_then(exact)),
        },
        start: is_set.then(|| rows.iter().filter_map(|row| exact(row.start)).collect()),
    };
    Ok(match name {
        "Int8" => Typed::Int8(own),
        "UInt8" => Typed::UInt8(own),
        "Int16" => Typed::Int16(own),
        "UInt16" if kind == Kind::Word => Typed::UInt16(bits(own, |start| i128::from(start as u16))),
        "UInt16" => Typed::UInt16(own),
        "Int32" if types == Types::Wide && kind == Kind::DWord => {
            Typed::Int32(bits(own, |start| i128::from(start as u32 as i32)))
        }
        "Int32" => Typed::Int32(own),
        "UInt32" => Typed::UInt32(own),
        "Int64" => Typed::Int64(own),
        _ => Typed::UInt64(own),
    })
}

/// A WORD or DWORD as a different integer type with the same bits; the range is dropped.
fn bits(mut own: Integer, of: fn(i128) -> i128) -> Integer {
    own.start.iter_mut().flatten().for_each(|start| *start = of(*start));
    own.attributes = IntegerAttributes::default();
    own
}

/// All outputs, in the order of their value references. They depend on nothing at the same instant because they change
/// only when the block is called, in a step or at an event. Before the first call, they have their values after a
/// restart, which depend on the settings listed in the table.
fn structure(table: &Table, rows: &[Group], texts: &[Group]) -> ModelStructure {
    let mut references = vec![0; table.rows.len()];
    for group in rows {
        group.rows.iter().for_each(|place| references[*place] = group.rows[0] as u32);
    }
    let mut structure = ModelStructure::default();
    let mut add = |reference: usize, mut from: Vec<u32>| {
        from.sort_unstable();
        from.dedup();
        let unknown = |dependencies| Unknown {
            value_reference: reference as u32,
            dependencies: Some(dependencies),
            dependencies_kind: None,
        };
        structure.outputs.push(Output { unknown: unknown(Vec::new()) });
        structure.initial_unknowns.push(InitialUnknown { unknown: unknown(from) });
    };
    for group in rows.iter().filter(|group| table.rows[group.rows[0]].role == Role::Output) {
        let from = group.rows.iter().flat_map(|place| &table.rows[*place].from);
        add(group.rows[0], from.map(|setting| references[*setting]).collect());
    }
    for group in texts.iter().filter(|group| table.texts[group.rows[0]].role == Role::Output) {
        add(table.rows.len() + group.rows[0], Vec::new());
    }
    structure
}
