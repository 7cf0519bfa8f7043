//! The parts of the mapping from a block's table to a model description shared by all versions.

use crate::description::{BaseUnit, Causality, DefaultExperiment, DisplayUnit, Initial, Unit, Variability};
use crate::error::Error;
use crate::units;
use blocks::{Role, Row, Table, Text};

/// The default experiment: from 0 to the end of the first documented response, with one call per step.
pub(crate) fn default_experiment(table: &Table) -> DefaultExperiment {
    let cycle = table.rows.get(table.cycle).map_or(0.0, Row::start);
    // Computed in whole milliseconds to avoid rounding errors in the stop time: 0.3, not 0.30000000000000004.
    let milliseconds =
        f64::from(table.responses.first().map_or(1, |response| response.calls.max(1))) * (cycle * 1000.0).round();
    DefaultExperiment {
        start_time: Some(0.0),
        stop_time: Some(milliseconds / 1000.0),
        tolerance: None,
        step_size: Some(cycle),
    }
}

/// The definitions of all units in use, in the order of [`units::names`]; `unit` returns the unit of a variable.
pub(crate) fn used_units(table: &Table, unit: impl Fn(&Row) -> Option<&str>) -> Result<Vec<Unit>, Error> {
    let known: Vec<&str> = units::names().collect();
    let used = |name: &str| table.rows.iter().any(|row| unit(row) == Some(name));
    if let Some((row, unknown)) =
        table.rows.iter().filter_map(|row| Some((row, unit(row)?))).find(|(_, unit)| !known.contains(unit))
    {
        return Err(Error::new(format!(
            "{}: variable {}: unit {unknown:?} is unknown: use one of {}",
            table.name,
            row.name,
            known.join(", ")
        )));
    }
    Ok(known.into_iter().filter(|name| used(name)).filter_map(unit_definition).collect())
}

/// The definition of a unit; that of the second has the millisecond as a display unit.
fn unit_definition(name: &str) -> Option<Unit> {
    let units::Definition { kg, m, s, A, K, rad, factor, offset } = units::definition(name)?;
    let base_unit = BaseUnit { kg, m, s, A, K, rad, factor, offset, ..BaseUnit::default() };
    let display_units = match name {
        "s" => vec![DisplayUnit { name: "ms".into(), factor: 1000.0, offset: 0.0 }],
        _ => Vec::new(),
    };
    Some(Unit { name: name.into(), base_unit: Some(base_unit), display_units })
}

/// The causality, variability and `initial` in FMI for a role.
pub(crate) fn causality(role: Role) -> (Causality, Variability, Option<Initial>) {
    match role {
        Role::Input => (Causality::Input, Variability::Discrete, None),
        Role::Parameter => (Causality::Parameter, Variability::Tunable, Some(Initial::Exact)),
        Role::Fixed | Role::Cycle => (Causality::Parameter, Variability::Fixed, Some(Initial::Exact)),
        Role::Output => (Causality::Output, Variability::Discrete, Some(Initial::Calculated)),
        Role::Local => (Causality::Local, Variability::Discrete, Some(Initial::Calculated)),
    }
}

/// The description of a text, which includes its length because FMI has no attribute for it.
pub(crate) fn text_description(text: &Text) -> String {
    let of = text.ty.name();
    if text.description.is_empty() { of } else { format!("{}; {of}", text.description) }
}
