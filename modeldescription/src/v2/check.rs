//! Finds mistakes in a model description that is valid XML.

use super::description::{
    Causality, EnumerationType, Initial, ModelDescription, Real, RealAttributes, SimpleType, TypeAttributes, Typed,
    Unit, Unknown, Variability, Variable, VariableNamingConvention,
};
use crate::error::shortened;
use crate::findings::{self, Counted, check_kinds, check_range, check_texts, is_structured_name, repeated};
pub use crate::findings::{Findings, MOST_FINDINGS};
use std::collections::{HashMap, HashSet};

/// All mistakes in a model description that a schema does not detect but that may mislead a host, one sentence each.
///
/// An FMU built by this project must meet more requirements than [`read`](super::read()) checks in FMUs from any tool:
/// the model and the library have the same name, a C identifier; names, causality, variability and start values agree
/// with the standard's tables; the model structure lists exactly the variables that belong there.
///
/// If there are more than [`MOST_FINDINGS`] of a kind, the last sentence states the number of the others.
pub fn check(description: &ModelDescription) -> Findings {
    let (mut forbidden, mut departures, mut odd) = (Counted::default(), Counted::default(), Counted::default());
    contradictions(description, &mut |_, sentence| forbidden.push(sentence));
    check_model(description, &mut forbidden, &mut odd);
    let definitions = Definitions::new(description);
    let is_structured = description.variable_naming_convention == VariableNamingConvention::Structured;
    for variable in &description.model_variables {
        let found = &mut |sentence: String| forbidden.push(about(variable, &sentence));
        if is_structured && !is_structured_name(&variable.name) {
            found(
                "the name does not follow the structured naming convention: use identifiers, dots and [indices]".into(),
            );
        }
        check_combination(variable, found);
        check_value(variable, &definitions, &mut |sentence| odd.push(about(variable, &sentence)));
    }
    check_aliases(description, &mut forbidden);
    check_structure(description, &mut forbidden, &mut departures, &mut odd);
    Findings { forbidden: forbidden.sentences(), departures: departures.sentences(), odd: odd.sentences() }
}

/// The location of a contradiction: the 0-based position of a variable, or `None` if it is not in a variable.
pub(crate) type Place = Option<usize>;

/// The units and type definitions of a model description, by name.
struct Definitions<'a> {
    units: HashMap<&'a str, &'a Unit>,
    types: HashMap<&'a str, &'a TypeAttributes>,
}

impl<'a> Definitions<'a> {
    fn new(description: &'a ModelDescription) -> Definitions<'a> {
        let types = &description.type_definitions;
        Definitions {
            units: description.unit_definitions.iter().map(|unit| (unit.name.as_str(), unit)).collect(),
            types: types.iter().map(|simple_type| (simple_type.name.as_str(), &simple_type.attributes)).collect(),
        }
    }

    fn declared(&self, typed: &Typed) -> Option<&'a TypeAttributes> {
        typed.declared_type().and_then(|name| self.types.get(name).copied())
    }
}

fn about(variable: &Variable, sentence: &str) -> String {
    format!("variable {:?}: {sentence}", shortened(&variable.name))
}

/// Finds the mistakes for which [`read`](super::read()) rejects a file, such as duplicate or missing definitions and
/// values out of range.
pub(crate) fn contradictions(description: &ModelDescription, found: &mut impl FnMut(Place, String)) {
    if description.model_exchange.is_none() && description.co_simulation.is_none() {
        found(None, "neither ModelExchange nor CoSimulation is present: add at least one".into());
    }
    let exchanged = description.model_exchange.iter().flat_map(|own| &own.source_files);
    let simulated = description.co_simulation.iter().flat_map(|own| &own.source_files);
    for (what, repeated) in [
        ("ModelExchange: File", repeated(exchanged.map(|file| &file.name))),
        ("CoSimulation: File", repeated(simulated.map(|file| &file.name))),
        ("Unit", repeated(description.unit_definitions.iter().map(|unit| &unit.name))),
        ("SimpleType", repeated(description.type_definitions.iter().map(|simple_type| &simple_type.name))),
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
    let definitions = Definitions::new(description);
    for SimpleType { name, attributes, .. } in &description.type_definitions {
        check_type(attributes, &definitions, &mut |sentence| {
            found(None, format!("SimpleType {:?}: {sentence}", shortened(name)));
        });
    }

    let count = description.model_variables.len();
    let mut names = HashSet::with_capacity(count);
    let mut settable = HashMap::new();
    for (place, variable) in description.model_variables.iter().enumerate() {
        let found = &mut |sentence: String| found(Some(place), about(variable, &sentence));
        if !names.insert(variable.name.as_str()) {
            found("the name is used twice: use a unique name for each variable".into());
        }
        if variable.is_settable() {
            let functions = functions(&variable.typed);
            if let Some(other) = settable.insert((functions, variable.value_reference), &variable.name) {
                found(format!(
                    "valueReference = {} is also used by {:?}: each settable {functions} needs its own",
                    variable.value_reference,
                    shortened(other)
                ));
            }
        }
        check_typed(&variable.typed, &definitions, count, found);
    }
    let structure = &description.model_structure;
    for (list, unknowns) in [
        ("Outputs", &structure.outputs),
        ("Derivatives", &structure.derivatives),
        ("InitialUnknowns", &structure.initial_unknowns),
    ] {
        for unknown in unknowns {
            check_unknown(unknown, count, &mut |sentence| {
                found(None, format!("{list}: Unknown with index = {}: {sentence}", unknown.index));
            });
        }
    }
}

/// The type in the names of the C functions that get and set a value: `Integer` for an Enumeration.
fn functions(typed: &Typed) -> &'static str {
    match typed {
        Typed::Enumeration(_) => "Integer",
        other => other.name(),
    }
}

fn check_type(attributes: &TypeAttributes, definitions: &Definitions<'_>, found: &mut impl FnMut(String)) {
    match attributes {
        TypeAttributes::Real(real) => {
            check_range(real.min, real.max, None, found);
            check_unit(real, definitions, found);
        }
        TypeAttributes::Integer(integer) => check_range(integer.min, integer.max, None, found),
        TypeAttributes::Enumeration(EnumerationType { items, .. }) => {
            for name in repeated(items.iter().map(|item| &item.name)) {
                found(format!("Item {:?} is defined twice: define it once", shortened(name)));
            }
        }
        TypeAttributes::Boolean(_) | TypeAttributes::String(_) => {}
    }
}

fn check_typed(typed: &Typed, definitions: &Definitions<'_>, count: usize, found: &mut impl FnMut(String)) {
    let declared = definitions.declared(typed);
    if let (Some(name), None) = (typed.declared_type(), declared) {
        let name = shortened(name);
        found(format!("declaredType = {name:?} is not defined: add the SimpleType, or remove the attribute"));
    }
    match (typed, declared) {
        (Typed::Real(real), None | Some(TypeAttributes::Real(_))) => {
            let (mut min, mut max) = (real.attributes.min, real.attributes.max);
            if let Some(TypeAttributes::Real(declared)) = declared {
                (min, max) = (min.or(declared.min), max.or(declared.max));
            }
            check_range(min, max, real.start, found);
            check_unit(&real.attributes, definitions, found);
            if let Some(index) = real.derivative.filter(|index| !is_index(*index, count)) {
                found(format!("derivative = {index}: no such variable; the indices are 1 to {count}"));
            }
        }
        (Typed::Integer(integer), None | Some(TypeAttributes::Integer(_))) => {
            let (mut min, mut max) = (integer.attributes.min, integer.attributes.max);
            if let Some(TypeAttributes::Integer(declared)) = declared {
                (min, max) = (min.or(declared.min), max.or(declared.max));
            }
            check_range(min, max, integer.start, found);
        }
        (Typed::Enumeration(enumeration), None | Some(TypeAttributes::Enumeration(_))) => {
            check_range(enumeration.attributes.min, enumeration.attributes.max, enumeration.start, found);
        }
        (Typed::Boolean(_), None | Some(TypeAttributes::Boolean(_))) => {}
        (Typed::String(_), None | Some(TypeAttributes::String(_))) => {}
        (typed, Some(_)) => {
            let declared = shortened(typed.declared_type().unwrap_or_default());
            let name = typed.name();
            found(format!("declaredType = {declared:?} is not of type {name}: refer to a SimpleType of the same type"));
        }
    }
}

fn check_unit(attributes: &RealAttributes, definitions: &Definitions<'_>, found: &mut impl FnMut(String)) {
    if let Some(unit) = attributes.unit.as_deref().filter(|unit| !definitions.units.contains_key(unit)) {
        found(format!("unit = {:?} is not defined: add it to UnitDefinitions", shortened(unit)));
    }
}

fn is_index(index: u32, count: usize) -> bool {
    place(index).is_some_and(|place| place < count)
}

/// The 0-based position of the variable with this 1-based index.
fn place(index: u32) -> Option<usize> {
    usize::try_from(index).ok()?.checked_sub(1)
}

fn check_unknown(unknown: &Unknown, count: usize, found: &mut impl FnMut(String)) {
    if !is_index(unknown.index, count) {
        found(format!("no such variable; the indices are 1 to {count}"));
    }
    let mut dependencies = unknown.dependencies.iter().flatten();
    if let Some(dependency) = dependencies.find(|dependency| !is_index(**dependency, count)) {
        found(format!("dependencies has {dependency}: no such variable; the indices are 1 to {count}"));
    }
    check_kinds(unknown.dependencies.as_deref(), unknown.dependencies_kind.as_deref(), found);
}

/// Checks names, texts, the identifier of the table and the default experiment.
fn check_model(description: &ModelDescription, forbidden: &mut Counted, odd: &mut Counted) {
    let ModelDescription { model_name, description: text, default_experiment, .. } = description;
    let identifier = description.model_identifier();
    findings::check_model(model_name, identifier, text.as_deref(), *default_experiment, forbidden, odd);
    if description.guid.is_empty() {
        odd.push("guid is empty: it must be the GUID that the library expects".into());
    }
    if description.model_variables.is_empty() {
        forbidden.push("there are no variables: the schema requires at least one".into());
    }
    for variable in &description.model_variables {
        if let Some(sentence) = check_texts(&variable.name, variable.description.as_deref()) {
            forbidden.push(about(variable, &sentence));
        }
    }
}

/// Checks the combination of causality, variability, initial and start against the standard's tables.
fn check_combination(variable: &Variable, found: &mut impl FnMut(String)) {
    use Causality::{CalculatedParameter, Independent, Input, Local, Output, Parameter};
    use Variability::{Constant, Continuous, Fixed, Tunable};
    let Variable { causality, variability, typed, .. } = variable;
    if *variability == Continuous && !matches!(typed, Typed::Real(_)) {
        found(format!("variability = continuous: only a Real can be continuous; {} is discrete", typed.name()));
    }
    if !causality.allows(*variability) {
        found(format!(
            "causality = {causality} and variability = {variability} are not allowed together: change one of them"
        ));
        return;
    }
    let initial = variable.initial_or_default();
    let goes_with_them = match (causality, variability) {
        (Input | Independent, _) => initial.is_none(),
        (Parameter, _) | (Output | Local, Constant) => initial == Some(Initial::Exact),
        (CalculatedParameter, _) | (Local, Fixed | Tunable) => initial != Some(Initial::Exact),
        (Output | Local, _) => true,
    };
    if !goes_with_them {
        let initial = initial.map_or("", Initial::word);
        found(format!(
            "causality = {causality} and variability = {variability} do not allow initial = {initial}: remove it"
        ));
    }
    let needs_start = *causality == Input || matches!(initial, Some(Initial::Exact | Initial::Approx));
    match (needs_start, typed.has_start()) {
        (true, false) => found("start is missing: add it".into()),
        (false, true) => found("start is given, but the value is calculated: remove start".into()),
        _ => {}
    }
}

fn check_value(variable: &Variable, definitions: &Definitions<'_>, found: &mut impl FnMut(String)) {
    let declared = definitions.declared(&variable.typed);
    match &variable.typed {
        Typed::Real(real) => check_display_unit(real, declared, definitions, found),
        Typed::Enumeration(enumeration) => {
            if let (Some(start), Some(TypeAttributes::Enumeration(EnumerationType { items, .. }))) =
                (enumeration.start, declared)
                && !items.iter().any(|item| item.value == start)
            {
                found(format!(
                    "start = {start} is not the value of any item of its enumeration type: use the value of one of its items"
                ));
            }
        }
        _ => {}
    }
}

fn check_display_unit(
    real: &Real,
    declared: Option<&TypeAttributes>,
    definitions: &Definitions<'_>,
    found: &mut impl FnMut(String),
) {
    let Some(display_unit) = &real.attributes.display_unit else { return };
    let unit = match (&real.attributes.unit, declared) {
        (None, Some(TypeAttributes::Real(declared))) => declared.unit.as_deref(),
        (unit, _) => unit.as_deref(),
    };
    let definition = unit.and_then(|unit| definitions.units.get(unit));
    if !definition.is_some_and(|unit| unit.display_units.iter().any(|defined| defined.name == *display_unit)) {
        let unit = unit.unwrap_or_default();
        found(format!("displayUnit = {display_unit:?} is not a DisplayUnit of unit = {unit:?}: define it there"));
    }
}

/// Checks that no output shares the value reference of an input or parameter: setting the latter would change the
/// output.
fn check_aliases(description: &ModelDescription, forbidden: &mut Counted) {
    let variables = || description.model_variables.iter();
    let key = |variable: &Variable| (functions(&variable.typed), variable.value_reference);
    let set: HashMap<_, _> =
        variables().filter(|variable| variable.is_settable()).map(|variable| (key(variable), &variable.name)).collect();
    for variable in variables().filter(|variable| variable.causality == Causality::Output) {
        if let Some(other) = set.get(&key(variable)) {
            let (reference, other) = (variable.value_reference, shortened(other));
            let sentence = format!(
                "valueReference = {reference} is also used by {other:?}, which can be set: the output needs its own"
            );
            forbidden.push(about(variable, &sentence));
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
    let indexed = || (1..).zip(variables);
    // Continuous states and their derivatives are also unknowns of the initialization.
    let mut states = HashSet::new();
    for derivative in &structure.derivatives {
        let variable = place(derivative.index).and_then(|place| variables.get(place));
        if let Some(Variable { typed: Typed::Real(Real { derivative: Some(state), .. }), .. }) = variable {
            states.extend([derivative.index, *state]);
        }
    }
    let is_initial_unknown = |index: u32, variable: &Variable| {
        let is_found = matches!(variable.initial_or_default(), Some(Initial::Approx | Initial::Calculated));
        match variable.causality {
            Causality::CalculatedParameter => true,
            Causality::Output => is_found,
            _ => is_found && states.contains(&index),
        }
    };
    let outputs = indexed().filter(|(_, variable)| variable.causality == Causality::Output);
    let initial_unknowns = indexed().filter(|(index, variable)| is_initial_unknown(*index, variable));
    let index = |(index, _): (u32, &Variable)| index;
    for (list, unknowns, expected) in [
        ("Outputs", &structure.outputs, outputs.map(index).collect::<Vec<u32>>()),
        ("InitialUnknowns", &structure.initial_unknowns, initial_unknowns.map(index).collect()),
    ] {
        let mut listed: Vec<u32> = unknowns.iter().map(|unknown| unknown.index).collect();
        let is_sorted = listed.is_sorted();
        listed.sort_unstable();
        listed.dedup();
        if listed.len() < unknowns.len() {
            odd.push(format!("{list}: a variable is listed twice: list it once"));
        }
        if list == "InitialUnknowns" && !is_sorted {
            odd.push(format!("{list}: the indices are not in ascending order: sort them"));
        }
        let name = |index: u32| place(index).and_then(|place| variables.get(place)).map_or("", |found| &found.name);
        for missing in expected.iter().filter(|index| listed.binary_search(index).is_err()) {
            let sentence = format!("{list}: variable {:?} (index {missing}) is missing: add it", name(*missing));
            if list == "InitialUnknowns" { &mut *departures } else { &mut *forbidden }.push(sentence);
        }
        for surplus in listed.iter().filter(|index| expected.binary_search(index).is_err()) {
            forbidden.push(format!(
                "{list}: variable {:?} (index {surplus}) does not belong here: remove it",
                name(*surplus)
            ));
        }
    }
}
