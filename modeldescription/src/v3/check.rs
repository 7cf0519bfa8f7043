//! Finds mistakes in an FMI 3.0 model description that is valid XML.

use super::describe::size;
use super::description::{
    Causality, InitialUnknown, ModelDescription, Output, TypeDefinition, Typed, Unit, Unknown, Variability, Variable,
    VariableNamingConvention,
};
use crate::description::Initial;
use crate::error::shortened;
use crate::findings::{self, Counted, Findings, check_kinds, check_range, check_texts, is_structured_name, repeated};
use std::collections::{HashMap, HashSet};

/// All mistakes in a model description that a schema does not detect but that may mislead a host, one sentence each, as
/// for FMI 2.0.
pub fn check(description: &ModelDescription) -> Findings {
    let (mut forbidden, mut departures, mut odd) = (Counted::default(), Counted::default(), Counted::default());
    contradictions(description, &mut |_, sentence| forbidden.push(sentence));
    check_model(description, &mut forbidden, &mut odd);
    let is_structured = description.variable_naming_convention == VariableNamingConvention::Structured;
    let units: HashMap<&str, &Unit> = description.unit_definitions.iter().map(|of| (of.name.as_str(), of)).collect();
    let types: HashMap<&str, &TypeDefinition> =
        description.type_definitions.iter().map(|of| (of.name.as_str(), of)).collect();
    for variable in &description.model_variables {
        let found = &mut |sentence: String| forbidden.push(about(variable, &sentence));
        if is_structured && !is_structured_name(&variable.common.name) {
            found(
                "the name does not follow the structured naming convention: use identifiers, dots and [indices]".into(),
            );
        }
        check_combination(variable, found);
        check_display_unit(variable, &units, &types, &mut |sentence| odd.push(about(variable, &sentence)));
    }
    check_structure(description, &mut forbidden, &mut departures, &mut odd);
    Findings { forbidden: forbidden.sentences(), departures: departures.sentences(), odd: odd.sentences() }
}

/// The location of a contradiction: the 0-based position of a variable, or `None` if it is not in a variable.
pub(crate) type Place = Option<usize>;

fn about(variable: &Variable, sentence: &str) -> String {
    format!("variable {:?}: {sentence}", shortened(&variable.common.name))
}

/// Finds the mistakes for which [`read`](super::read()) rejects a file, such as duplicate or missing definitions and
/// values out of range.
pub(crate) fn contradictions(description: &ModelDescription, found: &mut impl FnMut(Place, String)) {
    let ModelDescription { model_exchange, co_simulation, scheduled_execution, .. } = description;
    if model_exchange.is_none() && co_simulation.is_none() && scheduled_execution.is_none() {
        found(None, "ModelExchange, CoSimulation and ScheduledExecution are all missing: add at least one".into());
    }
    for (what, repeated) in [
        ("Unit", repeated(description.unit_definitions.iter().map(|unit| &unit.name))),
        ("TypeDefinition", repeated(description.type_definitions.iter().map(|definition| &definition.name))),
        ("Category", repeated(description.log_categories.iter().map(|category| &category.name))),
    ] {
        for name in repeated {
            found(None, format!("{what} {:?} is defined twice: define it once", shortened(name)));
        }
    }
    for Unit { name, display_units, .. } in &description.unit_definitions {
        for display_unit in repeated(display_units.iter().map(|display_unit| &display_unit.name)) {
            let (name, display_unit) = (shortened(name), shortened(display_unit));
            found(None, format!("Unit {name:?}: DisplayUnit {display_unit:?} is defined twice: define it once"));
        }
    }
    let units: HashSet<&str> = description.unit_definitions.iter().map(|unit| unit.name.as_str()).collect();
    let types: HashMap<&str, &TypeDefinition> =
        description.type_definitions.iter().map(|of| (of.name.as_str(), of)).collect();
    for definition in &description.type_definitions {
        check_type(definition, &units, &mut |sentence| {
            found(None, format!("type {:?}: {sentence}", shortened(&definition.name)));
        });
    }
    let mut names = HashSet::new();
    let mut references: HashMap<u32, &str> = HashMap::new();
    let sizes = description.sizes();
    let dimension_variables: HashSet<u32> = description
        .model_variables
        .iter()
        .filter(|variable| {
            matches!(variable.typed, Typed::UInt64(_))
                && (variable.common.causality == Causality::StructuralParameter
                    || variable.variability() == Variability::Constant)
        })
        .map(Variable::value_reference)
        .collect();
    for (place, variable) in description.model_variables.iter().enumerate() {
        let found = &mut |sentence: String| found(Some(place), about(variable, &sentence));
        let own = &variable.common.name;
        for name in std::iter::once(own).chain(variable.aliases.iter().map(|alias| &alias.name)) {
            if !names.insert(name.as_str()) {
                found(format!("the name {:?} is used twice: use a unique name for each variable", shortened(name)));
            }
        }
        let reference = variable.value_reference();
        if let Some(other) = references.insert(reference, own) {
            found(format!(
                "valueReference = {reference} is also used by {:?}: each variable needs its own",
                shortened(other)
            ));
        }
        check_dimensions(variable, &dimension_variables, &sizes, found);
        check_typed(variable, &types, &units, found);
    }
    for (list, unknown) in unknowns(description) {
        let reference = unknown.value_reference;
        let mut about = |sentence: String| found(None, format!("{list}: valueReference = {reference}: {sentence}"));
        let mut all = unknown.dependencies.iter().flatten().chain([&reference]);
        if let Some(missing) = all.find(|one| !references.contains_key(one)) {
            about(format!("no variable has the value reference {missing}: add the variable, or remove the reference"));
        }
        check_kinds(unknown.dependencies.as_deref(), unknown.dependencies_kind.as_deref(), &mut about);
    }
}

/// All unknowns, each with the name of its element.
fn unknowns(description: &ModelDescription) -> impl Iterator<Item = (&'static str, &Unknown)> {
    let of = &description.model_structure;
    let outputs = of.outputs.iter().map(|one| ("Output", &one.unknown));
    let derivatives = of.continuous_state_derivatives.iter().map(|one| ("ContinuousStateDerivative", &one.unknown));
    let clocked = of.clocked_states.iter().map(|one| ("ClockedState", &one.unknown));
    let initial = of.initial_unknowns.iter().map(|one| ("InitialUnknown", &one.unknown));
    let indicators = of.event_indicators.iter().map(|one| ("EventIndicator", &one.unknown));
    outputs.chain(derivatives).chain(clocked).chain(initial).chain(indicators)
}

fn check_type(definition: &TypeDefinition, units: &HashSet<&str>, found: &mut impl FnMut(String)) {
    if let Some(own) = definition.attributes.float() {
        check_range(own.min, own.max, None, found);
        check_unit(own.unit.as_deref(), units, found);
    }
    if let Some(own) = definition.attributes.integer() {
        check_range(own.min, own.max, None, found);
    }
    for name in repeated(definition.items.iter().map(|item| &item.name)) {
        found(format!("Item {:?} is defined twice: define it once", shortened(name)));
    }
}

fn check_unit(unit: Option<&str>, units: &HashSet<&str>, found: &mut impl FnMut(String)) {
    if let Some(unit) = unit.filter(|unit| !units.contains(unit)) {
        found(format!("unit = {:?} is not defined: add it to UnitDefinitions", shortened(unit)));
    }
}

/// Checks the sizes of an array, and that it has a start value for each element or one for all.
fn check_dimensions(
    variable: &Variable,
    variables: &HashSet<u32>,
    sizes: &HashMap<u32, u64>,
    found: &mut impl FnMut(String),
) {
    let mut count = Some(1u64);
    for dimension in &variable.dimensions {
        match (dimension.start, dimension.value_reference) {
            (Some(_), None) => {}
            (None, Some(reference)) if variables.contains(&reference) => {}
            (None, Some(reference)) => {
                return found(format!(
                    "Dimension: valueReference = {reference} does not refer to a UInt64 constant or structural \
                     parameter: correct it"
                ));
            }
            _ => return found("Dimension: it must have either start or valueReference".into()),
        }
        let of = size(dimension, sizes);
        if of == Some(0) {
            return found("Dimension: the size is 0: an array must start with at least one element".into());
        }
        count = count.zip(of).and_then(|(all, of)| all.checked_mul(of));
    }
    let starts = match &variable.typed {
        Typed::Float32(own) | Typed::Float64(own) => own.start.as_ref().map(Vec::len),
        Typed::Boolean(own) => own.start.as_ref().map(Vec::len),
        Typed::String | Typed::Binary(_) => Some(variable.starts.len()).filter(|count| *count > 0),
        other => other.integer().and_then(|(own, _)| own.start.as_ref()).map(Vec::len),
    };
    if let (Some(starts), Some(count)) = (starts, count)
        && starts != 1
        && starts as u64 != count
    {
        found(format!(
            "start and the array differ in length ({starts} and {count}): give one for each element, or one for all"
        ));
    }
}

fn check_typed(
    variable: &Variable,
    types: &HashMap<&str, &TypeDefinition>,
    units: &HashSet<&str>,
    found: &mut impl FnMut(String),
) {
    let declared = variable.common.declared_type.as_deref().map(|name| (name, types.get(name)));
    let typed = &variable.typed;
    match declared {
        Some((name, None)) => {
            let name = shortened(name);
            found(format!("declaredType = {name:?} is not defined: add the type definition, or remove the attribute"));
        }
        Some((name, Some(of))) if of.attributes.name() != typed.name() => {
            let (name, own) = (shortened(name), typed.name());
            found(format!("declaredType = {name:?} is not of type {own}: refer to a type definition of the same type"));
        }
        None if matches!(typed, Typed::Enumeration(_)) => found("declaredType is missing: add it".into()),
        _ => {}
    }
    let attributes = declared.and_then(|(_, of)| of.map(|of| &of.attributes));
    if let Some(own) = typed.float() {
        let of_type = attributes.and_then(|of| of.float());
        let min = own.attributes.min.or_else(|| of_type?.min);
        let max = own.attributes.max.or_else(|| of_type?.max);
        check_range(min, max, None, found);
        for start in own.start.iter().flatten() {
            check_range(min, None, Some(*start), found);
            check_range(None, max, Some(*start), found);
        }
        check_unit(own.attributes.unit.as_deref(), units, found);
    }
    if let Some((own, (low, high))) = typed.integer() {
        let of_type = attributes.and_then(|of| of.integer());
        let min = own.attributes.min.or_else(|| of_type?.min);
        let max = own.attributes.max.or_else(|| of_type?.max);
        check_range(min, max, None, found);
        for start in own.start.iter().flatten() {
            check_range(min, None, Some(*start), found);
            check_range(None, max, Some(*start), found);
        }
        let all = own.attributes.min.iter().chain(&own.attributes.max).chain(own.start.iter().flatten());
        if let Some(outside) = all.into_iter().find(|value| !(low..=high).contains(*value)) {
            found(format!("{outside} is outside the range of {}, {low} to {high}", typed.name()));
        }
    }
}

/// Checks names, texts, the token, the time and the default experiment.
fn check_model(description: &ModelDescription, forbidden: &mut Counted, odd: &mut Counted) {
    let ModelDescription { model_name, description: text, default_experiment, .. } = description;
    let identifier = description.model_identifier();
    findings::check_model(model_name, identifier, text.as_deref(), *default_experiment, forbidden, odd);
    if description.instantiation_token.is_empty() {
        odd.push("instantiationToken is empty: it must be the token that the library expects".into());
    }
    let is_time = |variable: &&Variable| variable.common.causality == Causality::Independent;
    match description.model_variables.iter().filter(is_time).count() {
        1 => {}
        count => forbidden.push(format!("{count} variables are independent: exactly one must be, the time")),
    }
    for variable in &description.model_variables {
        let own = &variable.common;
        if let Some(sentence) = check_texts(&own.name, own.description.as_deref()) {
            forbidden.push(about(variable, &sentence));
        }
    }
    if let Some(step) = description.co_simulation.as_ref().and_then(|own| own.fixed_internal_step_size)
        && !(step.is_finite() && step > 0.0)
    {
        odd.push(format!("CoSimulation: fixedInternalStepSize = {step:?}: it must be a positive number"));
    }
}

/// Checks the combination of causality, variability, initial and start against the standard's tables.
fn check_combination(variable: &Variable, found: &mut impl FnMut(String)) {
    use Causality::{CalculatedParameter, Independent, Input, Local, Output, Parameter, StructuralParameter};
    use Variability::{Constant, Continuous, Discrete, Fixed, Tunable};
    let (causality, variability) = (variable.common.causality, variable.variability());
    let typed = &variable.typed;
    if matches!(typed, Typed::Clock(_)) {
        return;
    }
    if variability == Continuous && typed.float().is_none() {
        found(format!(
            "variability = continuous: only a Float32 or Float64 can be continuous; {} is discrete",
            typed.name()
        ));
    }
    let is_allowed = match causality {
        Parameter | CalculatedParameter | StructuralParameter => matches!(variability, Fixed | Tunable),
        Input => matches!(variability, Discrete | Continuous),
        Output => matches!(variability, Constant | Discrete | Continuous),
        Local => true,
        Independent => variability == Continuous,
    };
    if !is_allowed {
        return found(format!(
            "causality = {causality} and variability = {variability} are not allowed together: change one of them"
        ));
    }
    let initial = variable.initial_or_default();
    let goes_with_them = match (causality, variability) {
        (Independent, _) => initial.is_none(),
        (Input | Parameter | StructuralParameter, _) | (Output | Local, Constant) => initial == Some(Initial::Exact),
        (CalculatedParameter, _) | (Local, Fixed | Tunable) => initial != Some(Initial::Exact),
        (Output | Local, _) => true,
    };
    if !goes_with_them {
        let initial = initial.map_or("", Initial::word);
        found(format!(
            "causality = {causality} and variability = {variability} do not allow initial = {initial}: remove it"
        ));
    }
    if causality == Independent && typed.float().is_none() {
        found(format!("the independent variable is of type {}: it must be a Float32 or Float64", typed.name()));
    }
    match (matches!(initial, Some(Initial::Exact | Initial::Approx)), variable.has_start()) {
        (true, false) => found("start is missing: add it".into()),
        (false, true) => found("start is given, but the value is calculated: remove start".into()),
        _ => {}
    }
}

fn check_display_unit(
    variable: &Variable,
    units: &HashMap<&str, &Unit>,
    types: &HashMap<&str, &TypeDefinition>,
    found: &mut impl FnMut(String),
) {
    let Some(own) = variable.typed.float() else { return };
    let declared = variable.common.declared_type.as_deref().and_then(|name| types.get(name)?.attributes.float());
    let unit = own.attributes.unit.as_deref().or_else(|| declared?.unit.as_deref());
    let definition = unit.and_then(|unit| units.get(unit));
    let aliases = variable.aliases.iter().filter_map(|alias| alias.display_unit.as_ref());
    for display_unit in own.attributes.display_unit.iter().chain(aliases) {
        if !definition.is_some_and(|unit| unit.display_units.iter().any(|defined| defined.name == *display_unit)) {
            let unit = unit.unwrap_or_default();
            found(format!("displayUnit = {display_unit:?} is not a DisplayUnit of unit = {unit:?}: define it there"));
        }
    }
}

fn check_structure(
    description: &ModelDescription,
    forbidden: &mut Counted,
    departures: &mut Counted,
    odd: &mut Counted,
) {
    let variables = &description.model_variables;
    let structure = &description.model_structure;
    // Continuous states and their derivatives are also unknowns of the initialization.
    let mut states = HashSet::new();
    for derivative in &structure.continuous_state_derivatives {
        let reference = derivative.unknown.value_reference;
        let variable = variables.iter().find(|variable| variable.value_reference() == reference);
        let state = variable.and_then(|variable| variable.typed.float()?.derivative);
        states.extend(state.into_iter().chain([reference]));
    }
    let is_initial_unknown = |variable: &&Variable| {
        let is_found = matches!(variable.initial_or_default(), Some(Initial::Approx | Initial::Calculated));
        match variable.common.causality {
            _ if variable.common.clocks.is_some() || matches!(variable.typed, Typed::Clock(_)) => false,
            Causality::CalculatedParameter => true,
            Causality::Output => is_found,
            _ => is_found && states.contains(&variable.value_reference()),
        }
    };
    let is_output = |variable: &&Variable| variable.common.causality == Causality::Output;
    let names: HashMap<u32, &str> =
        variables.iter().map(|variable| (variable.value_reference(), variable.common.name.as_str())).collect();
    let outputs = structure.outputs.iter().map(|Output { unknown }| unknown.value_reference).collect::<Vec<u32>>();
    let initial = structure.initial_unknowns.iter().map(|InitialUnknown { unknown }| unknown.value_reference);
    for (list, listed, expected) in [
        ("Output", outputs, variables.iter().filter(is_output).map(Variable::value_reference).collect::<Vec<u32>>()),
        (
            "InitialUnknown",
            initial.collect(),
            variables.iter().filter(is_initial_unknown).map(Variable::value_reference).collect(),
        ),
    ] {
        let unique: HashSet<u32> = listed.iter().copied().collect();
        if unique.len() < listed.len() {
            odd.push(format!("{list}: a variable is listed twice: list it once"));
        }
        let name = |reference: u32| names.get(&reference).copied().unwrap_or_default();
        for missing in expected.iter().filter(|reference| !unique.contains(reference)) {
            let sentence =
                format!("{list}: variable {:?} (valueReference {missing}) is missing: add it", name(*missing));
            if list == "InitialUnknown" { &mut *departures } else { &mut *forbidden }.push(sentence);
        }
        let expected: HashSet<u32> = expected.into_iter().collect();
        for surplus in listed.iter().filter(|reference| !expected.contains(reference)) {
            // According to the standard, listing clocked outputs is optional.
            if list == "InitialUnknown" && names.contains_key(surplus) {
                let variable = variables.iter().find(|variable| variable.value_reference() == *surplus);
                if variable.is_some_and(|variable| variable.common.clocks.is_some()) {
                    continue;
                }
            }
            forbidden.push(format!(
                "{list}: variable {:?} (valueReference {surplus}) does not belong here: remove it",
                name(*surplus)
            ));
        }
    }
}
