//! Maps a block's table to a model description: PLC types and roles in FMI 2.0.

use super::check::check;
use super::description;
use super::description::{
    Boolean, CoSimulation, Integer, IntegerAttributes, ModelDescription, ModelStructure, Real, RealAttributes, Typed,
    Unknown, Variable, VariableNamingConvention,
};
use crate::description::GENERATION_TOOL;
use crate::error::Error;
use crate::findings::is_structured_name;
use crate::interface::Interface;
use crate::mapping::{causality, default_experiment, text_description, used_units};
use crate::names::Names;
use blocks::table::number::{exact, number};
use blocks::{Class, Kind, Role, Row, Table, Text, Value};

impl ModelDescription {
    /// Creates the model description of the FMU with this library.
    ///
    /// Inputs become discrete inputs, settings become tunable or fixed parameters, each with its start value. Outputs
    /// and locals are discrete and calculated; they do not depend on inputs at the same instant, and initially depend
    /// on the settings listed in the table. REAL, LREAL and TIME become Real, WORD and INT become Integer, BOOL becomes
    /// Boolean. Ranges are copied from the table.
    ///
    /// # Errors
    /// The table has an entry that is not allowed in a model description: an unknown unit, a start value out of range,
    /// or a duplicate name.
    pub fn from_interface(interface: &Interface) -> Result<ModelDescription, Error> {
        let (table, names) = (&interface.table, interface.names);
        let all = table.rows.iter().map(|row| &row.name).chain(table.texts.iter().map(|text| &text.name));
        names.check(all.map(String::as_str)).map_err(|reason| Error::new(format!("{}: {reason}", table.name)))?;
        let mut description = ModelDescription {
            model_name: table.name.clone(),
            guid: interface.guid.clone(),
            description: Some(table.summary()).filter(|summary| !summary.is_empty()),
            generation_tool: Some(GENERATION_TOOL.into()),
            co_simulation: Some(CoSimulation {
                model_identifier: table.name.clone(),
                capabilities: interface.capabilities.clone(),
                source_files: Vec::new(),
            }),
            unit_definitions: used_units(table, Row::shown_unit)?,
            log_categories: interface.log_categories.clone(),
            default_experiment: Some(default_experiment(table)),
            ..ModelDescription::default()
        };
        for (value_reference, row) in (0..).zip(&table.rows) {
            let variable = variable(row, value_reference, names)
                .map_err(|reason| Error::new(format!("{}: variable {}: {reason}", table.name, row.name)))?;
            description.model_variables.push(variable);
        }
        for (value_reference, text) in (table.rows.len() as u32..).zip(&table.texts) {
            description.model_variables.push(text_variable(text, value_reference, names));
        }
        // The structured convention requires ASCII names and non-negative indices.
        let is_structured = |variable: &Variable| is_structured_name(&variable.name);
        if names == Names::Structured && description.model_variables.iter().all(is_structured) {
            description.variable_naming_convention = VariableNamingConvention::Structured;
        }
        description.model_structure = structure(table);
        match check(&description).all() {
            findings if findings.is_empty() => Ok(description),
            findings => Err(Error::new(format!("{}: {}", table.name, findings.join("\n")))),
        }
    }
}

/// The variable for a text. Its description includes the length, because FMI has no attribute for it.
fn text_variable(text: &Text, value_reference: u32, names: Names) -> Variable {
    let (causality, variability, initial) = causality(text.role);
    Variable {
        name: names.convert(&text.name).into_owned(),
        value_reference,
        description: Some(text_description(text)),
        causality,
        variability,
        initial,
        typed: Typed::String(description::Text {
            start: text.role.is_settable().then(|| text.start.clone()),
            ..description::Text::default()
        }),
        ..Variable::default()
    }
}

fn variable(row: &Row, value_reference: u32, names: Names) -> Result<Variable, String> {
    let (causality, variability, initial) = causality(row.role);
    Ok(Variable {
        name: names.convert(&row.name).into_owned(),
        value_reference,
        description: Some(row.description.clone()).filter(|description| !description.is_empty()),
        causality,
        variability,
        initial,
        typed: typed(row)?,
        ..Variable::default()
    })
}

fn typed(row: &Row) -> Result<Typed, String> {
    let start = row.role.is_settable().then_some(row.start);
    match row.kind {
        Kind::Time if row.unit.as_deref().is_some_and(|unit| unit != "s") => {
            Err(format!("unit {:?}: a TIME is in seconds; remove its unit", row.unit.as_deref().unwrap_or("")))
        }
        kind if kind.class() == Class::Real => Ok(Typed::Real(Real {
            attributes: RealAttributes {
                unit: row.shown_unit().map(str::to_owned),
                display_unit: (row.kind == Kind::Time).then(|| "ms".into()),
                min: row.least(),
                max: row.greatest(),
                ..RealAttributes::default()
            },
            start: start.map(number),
            ..Real::default()
        })),
        kind if kind.class() == Class::Integer => {
            if let Some(unit) = &row.unit {
                return Err(format!("unit {unit:?}: an FMI Integer cannot have a unit; put it in the description"));
            }
            Ok(Typed::Integer(Integer {
                attributes: IntegerAttributes {
                    quantity: None,
                    min: row.min.and_then(integer),
                    max: row.max.and_then(integer),
                },
                start: start.and_then(integer),
                ..Integer::default()
            }))
        }
        _ => {
            if row.unit.is_some() || row.min.is_some() || row.max.is_some() {
                return Err("a BOOL cannot have a unit or a range; remove them".into());
            }
            let start = start.map(|start| start == Value::Bool(true));
            Ok(Typed::Boolean(Boolean { start, ..Boolean::default() }))
        }
    }
}

/// The value of an Integer; a DWORD becomes the Integer with the same bits.
fn integer(value: Value) -> Option<i32> {
    exact(value).map(|integer| integer as i32)
}

/// All outputs, in index order. They depend on nothing at the same instant because they change only in `fmi2DoStep`.
/// Before that, they have their values after a restart, which depend on the settings listed in the table.
fn structure(table: &Table) -> ModelStructure {
    let unknown = |index, dependencies| Unknown { index, dependencies: Some(dependencies), dependencies_kind: None };
    let outputs = (1..).zip(&table.rows).filter(|(_, row)| row.role == Role::Output);
    let settings = |row: &Row| {
        let mut named: Vec<u32> = row.from.iter().map(|setting| *setting as u32 + 1).collect();
        named.sort_unstable();
        named
    };
    let texts = (table.rows.len() as u32 + 1..).zip(&table.texts);
    let texts: Vec<u32> = texts.filter(|(_, text)| text.role == Role::Output).map(|(index, _)| index).collect();
    let all = |numbers: Vec<Unknown>| {
        numbers.into_iter().chain(texts.iter().map(|index| unknown(*index, Vec::new()))).collect()
    };
    ModelStructure {
        outputs: all(outputs.clone().map(|(index, _)| unknown(index, Vec::new())).collect()),
        initial_unknowns: all(outputs.map(|(index, row)| unknown(index, settings(row))).collect()),
        derivatives: Vec::new(),
    }
}
