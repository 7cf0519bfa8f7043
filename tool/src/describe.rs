//! Describes the catalogue, an FMU with its variables and groups, and the loops of a parameter file; and checks
//! settings before they are sent.

use crate::home::Home;
use crate::message::{
    Catalogue, Checked, Description, Loop, LoopRole, LoopValue, Loops, Problem, ReadFile, Remark, Values, Variable,
};
use anyhow::{Context, Result, bail};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use blocks::table::number::{number, to_value};
use blocks::{Kind, Role};
use modeldescription::{Causality, Row, Table, Type, Variability, units};
use parameters::{Format, Options, Origin, Problems, Remedy, Source};
use run::dialog::{self, Group, Roles};
use run::fmus::number_of;
use run::system::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The maximum size of a parameter file, in bytes.
const LARGEST: usize = 64 << 20;

/// The available FMUs.
pub fn catalogue(home: &dyn Home) -> Catalogue {
    let offered = Format::ALL.iter().flat_map(|format| format.offered());
    let formats = offered.map(|(extension, title)| (extension.to_string(), title.to_string())).collect();
    Catalogue { fmus: home.entries(), loops: home.known_loops(), formats }
}

/// An FMU with its variables, groups and roles.
///
/// # Errors
/// No such FMU, or its documentation is faulty.
pub fn describe(home: &dyn Home, fmu: &str) -> Result<Description> {
    let description = home.description(fmu)?;
    let entry = home.entries().into_iter().find(|entry| entry.name == fmu);
    let aliases = |block: &str| {
        let blocks = home.blocks();
        blocks.iter().find(|of| of.name == block).map(|of| of.aliases.clone()).unwrap_or_default()
    };
    let Some(table) = home.table(fmu)? else {
        let (roles, groups) = foreign_groups(&description);
        return Ok(Description {
            name: fmu.into(),
            block: description.model_name.clone(),
            summary: description.description.clone().unwrap_or_default(),
            aliases: Vec::new(),
            part: entry.map_or(LoopRole::Other, |entry| entry.part),
            cycle: None,
            variables: foreign_variables(&description),
            roles,
            groups,
        });
    };
    let (roles, groups) = home.dialog(fmu, &table).with_context(|| fmu.to_string())?;
    Ok(Description {
        name: fmu.into(),
        block: table.name.clone(),
        summary: table.summary(),
        aliases: if table.aliases.is_empty() { aliases(&table.name) } else { table.aliases.clone() },
        part: entry.map_or_else(|| roles.part(&table), |entry| entry.part),
        cycle: table.rows.get(table.cycle).map(|row| row.name.clone()),
        variables: table.rows.iter().map(|row| variable(row, &description, &roles)).collect(),
        roles,
        groups,
    })
}

/// Converts a number to a value of a PLC type.
fn shown(kind: Kind, value: f64) -> Value {
    match kind {
        Kind::Bool => Value::Boolean(value != 0.0),
        _ => Value::Number(value),
    }
}

fn variable(row: &Row, description: &modeldescription::Description, roles: &Roles) -> Variable {
    Variable {
        name: row.name.clone(),
        description: row.description.clone(),
        kind: row.kind.name().into(),
        role: row.role.name().into(),
        is_tunable: matches!(row.role, Role::Input | Role::Parameter),
        is_stimulus: row.role.is_settable() && roles.is_stimulus(&row.name, row.role == Role::Input),
        // The start values of a preset differ from those of its block.
        start: shown(row.kind, description.start(&row.name).unwrap_or(row.start())),
        min: row.least(),
        max: row.greatest(),
        unit: row.shown_unit().map(str::to_string),
    }
}

fn foreign_variables(description: &modeldescription::Description) -> Vec<Variable> {
    let variable = |of: &modeldescription::Variable| {
        let kind = of.kind?;
        let role = match (of.causality, of.variability) {
            (Causality::Input, _) => "input",
            (Causality::Output, _) => "output",
            (Causality::Parameter, Variability::Tunable) => "parameter",
            (Causality::Parameter, _) => "fixed",
            _ => "local",
        };
        let start = of.start.unwrap_or(0.0);
        Some(Variable {
            name: of.name.clone(),
            description: of.description.clone().unwrap_or_default(),
            kind: kind.name().into(),
            role: role.into(),
            is_tunable: matches!(role, "input" | "parameter"),
            is_stimulus: role == "input",
            start: if kind == Type::Boolean { Value::Boolean(start != 0.0) } else { Value::Number(start) },
            min: of.min,
            max: of.max,
            unit: of.unit.clone(),
        })
    };
    description.variables.iter().filter_map(variable).collect()
}

/// The inputs and the parameters of a foreign FMU.
fn foreign_groups(description: &modeldescription::Description) -> (Roles, Vec<Group>) {
    let fields = |causality: Causality| {
        let variables = description.variables.iter();
        let settable = variables.filter(move |of| of.causality == causality && of.is_settable());
        settable.filter(|of| of.kind.is_some()).map(|of| dialog::Field { name: of.name.clone(), used_if: Vec::new() })
    };
    let groups = [("Inputs", Causality::Input), ("Parameters", Causality::Parameter)];
    let groups = groups.map(|(title, causality)| Group { title: title.into(), fields: fields(causality).collect() });
    (Roles::default(), groups.into_iter().filter(|group| !group.fields.is_empty()).collect())
}

/// Decodes a parameter file in a message.
///
/// # Errors
/// The content is not Base64 or is too large, or the file does not have the extension of a parameter file.
pub fn opened(file: &ReadFile) -> Result<(Format, Source, Options)> {
    if file.content.len() / 4 * 3 > LARGEST {
        bail!("{} is larger than {} MiB: split it", file.file, LARGEST >> 20);
    }
    let bytes =
        STANDARD.decode(&file.content).with_context(|| format!("the content of {} is not Base64", file.file))?;
    let format = Format::of_file(&file.file);
    let format = format.with_context(|| format!("{}: not a parameter file (unknown extension)", file.file))?;
    let options = Options { block: file.block.clone(), name: file.name.clone(), ..Options::default() };
    Ok((format, Source::new(file.file.as_str(), bytes), options))
}

/// Returns a test for whether a block's setting is a stimulus.
///
/// # Errors
/// The documentation of one of the block's FMUs is faulty.
pub fn stimuli_of_block(home: &dyn Home, block: &str) -> Result<impl Fn(&str) -> bool + use<>> {
    let mut stimuli = Vec::new();
    for entry in home.entries() {
        if home.table(&entry.name)?.is_some_and(|table| table.name == block) {
            let variables = describe(home, &entry.name)?.variables;
            stimuli = variables.into_iter().filter(|of| of.is_stimulus).map(|of| of.name).collect();
            break;
        }
    }
    Ok(move |name: &str| stimuli.iter().any(|stimulus| stimulus == name))
}

/// Reads a parameter file. Problems in the file are part of the answer, not errors.
///
/// # Errors
/// The content is not Base64, or is too large.
pub fn read(home: &dyn Home, file: &ReadFile) -> Result<Loops> {
    let refused = |message: String, help: Option<String>| Loops {
        loops: Vec::new(),
        problems: vec![Problem { place: None, message, help, asks_for_block: false }],
        is_refused: true,
    };
    if Format::of_file(&file.file).is_none() {
        let endings: Vec<String> =
            Format::ALL.iter().flat_map(|format| format.extensions()).map(|ending| format!(".{ending}")).collect();
        let message = format!("{}: not a parameter file (unknown extension)", file.file);
        return Ok(refused(message, Some(format!("parameter files end in {}", endings.join(", ")))));
    }
    let (format, source, options) = opened(file)?;
    Ok(match parameters::read(format, &source, &home.blocks(), &options) {
        Ok(reading) => Loops {
            loops: reading.loops.iter().map(as_message).collect(),
            problems: problems(reading.remarks, false),
            is_refused: false,
        },
        Err(wrong) => Loops { loops: Vec::new(), problems: problems(wrong, file.block.is_some()), is_refused: true },
    })
}

/// The problems as messages. If the user chose the block (`is_chosen`), each of them offers to choose another.
fn problems(problems: Problems, is_chosen: bool) -> Vec<Problem> {
    let problem = |of: parameters::Problem| Problem {
        place: of.place.map(|place| (place.line, place.column)),
        message: of.message,
        help: of.help.as_ref().map(remedy),
        asks_for_block: is_chosen || matches!(of.help, Some(Remedy::ChooseBlock(_) | Remedy::ChooseThisBlock(_))),
    };
    problems.problems.into_iter().map(problem).collect()
}

/// A remedy in the page's wording.
pub fn remedy(remedy: &Remedy) -> String {
    match remedy {
        Remedy::Sentence(text) => text.clone(),
        Remedy::ChooseBlock(blocks) => format!("choose its block: {blocks}"),
        Remedy::ChooseThisBlock(block) => {
            format!("if it is {block}, which has the same members, choose that as its block")
        }
        Remedy::DeclareConstant(name) => format!("declare it under Options as a constant, such as {name} = 5"),
        Remedy::DeclareInstance(name) => {
            format!("specify its block under Options as the tag {name} : Block")
        }
        Remedy::ListMissing => "also open the files that declare them".to_string(),
        Remedy::Stub(_) => "ask its author for the source".to_string(),
        Remedy::DeclareTag { name, of } => {
            format!(
                "declare it under Options: the tag {name} : {of} makes it an input or output, {name} = 5 a constant"
            )
        }
    }
}

/// A loop as a message.
fn as_message(of: &parameters::Loop) -> Loop {
    let members = &of.block.members;
    let setting = |setting: &parameters::MemberValue| LoopValue {
        name: members[setting.member].name.clone(),
        value: shown(members[setting.member].kind, number(setting.value)),
        origin: (setting.origin != Origin::Default).then(|| setting.origin.to_string()),
        file: None,
    };
    let cycle = of.settings.iter().find(|setting| members[setting.member].role == Role::Cycle);
    Loop {
        name: of.name.clone(),
        title: of.title.clone(),
        block: of.block.name.clone(),
        cycle: cycle.map(|setting| number(setting.value)),
        settings: of.settings.iter().map(setting).collect(),
        warnings: of.warnings(),
    }
}

/// Converts a loop from a message to a parameter-file loop.
///
/// # Errors
/// The catalogue has no such block, the block has no such setting, or a value does not fit the setting's type.
pub fn as_loop(home: &dyn Home, of: &Loop) -> Result<parameters::Loop> {
    let block = home.blocks().into_iter().find(|block| block.is_called(&of.block));
    let block = block.with_context(|| format!("{}: no block {:?} in the catalogue", of.name, of.block))?;
    let mut one = parameters::Loop::new(of.name.as_str(), Arc::clone(&block));
    for setting in &of.settings {
        let member = block.find(&setting.name).filter(|member| block.members[*member].role.is_settable());
        let member =
            member.with_context(|| format!("{}: {} has no setting {:?}", of.name, block.name, setting.name))?;
        let given = number_of(setting.value);
        let value = to_value(given, block.members[member].kind)
            .map_err(|range| anyhow::anyhow!("{}: {} = {given:?}: {range}", of.name, setting.name))?;
        let origin = setting.origin.as_ref().map_or(Origin::Default, |file| Origin::File { file: file.clone() });
        one.set(member, value, origin);
    }
    Ok(one)
}

/// Checks settings of an FMU; settings that are not given have their start values.
///
/// # Errors
/// No such FMU, or its documentation is faulty.
pub fn check(home: &dyn Home, fmu: &str, values: &Values) -> Result<Checked> {
    let description = describe(home, fmu)?;
    let table = home.table(fmu)?;
    let mut checked = Checked::default();
    let mut good: BTreeMap<&str, f64> = BTreeMap::new();
    for (name, value) in values {
        let variable = description.variables.iter().find(|of| of.name == *name);
        let row = table.as_deref().and_then(|table| table.find(name).map(|row| &table.rows[row]));
        match (variable, examine(name, variable, row, *value)) {
            (_, Err(text)) => {
                checked.remarks.push(Remark { variables: vec![name.clone()], text, is_error: true });
            }
            (Some(variable), Ok(held)) => {
                good.insert(name, held);
                if held.to_bits() != number_of(*value).to_bits() && !(held == 0.0 && number_of(*value) == 0.0) {
                    checked.rounded.insert(name.clone(), as_given(*value, held));
                }
                if let Some(text) = outside(variable, held) {
                    checked.remarks.push(Remark { variables: vec![name.clone()], text, is_error: false });
                }
            }
            (None, Ok(_)) => {}
        }
    }
    let value = |name: &str| {
        let own = description.variables.iter().find(|of| of.name == name).map(|of| number_of(of.start));
        good.get(name).copied().or(own).unwrap_or(0.0)
    };
    for field in description.groups.iter().flat_map(|group| &group.fields) {
        if !field.is_used(|name| value(name) != 0.0) {
            checked.unused.push(field.name.clone());
        }
    }
    if let Some(table) = &table {
        checked.remarks.extend(advice(home, table, &value, &checked.remarks));
    }
    Ok(checked)
}

/// Returns the value as rounded by the type, or the problem with it.
fn examine(name: &str, variable: Option<&Variable>, row: Option<&Row>, value: Value) -> Result<f64, String> {
    let Some(variable) = variable else { return Err(format!("no variable {name:?}")) };
    if matches!(variable.role.as_str(), "output" | "local") {
        return Err(format!(
            "{name} cannot be set: its role is {}; only inputs and parameters can be set",
            variable.role
        ));
    }
    let is_boolean = matches!(variable.start, Value::Boolean(_));
    let given = match value {
        Value::Boolean(value) if !is_boolean => {
            return Err(format!("{name} is of type {}: {value} is not a number", variable.kind));
        }
        value => number_of(value),
    };
    if !given.is_finite() {
        return Err(format!("{name} = {given:?}: not a finite number"));
    }
    let Some(row) = row else {
        return match variable.kind.as_str() {
            "Integer" if f64::from(given as i32) != given => Err(format!("{name} = {given:?}: not a 32-bit integer")),
            "Boolean" if given != 0.0 && given != 1.0 => {
                Err(format!("{name} = {given:?}: a Boolean must be 0 (FALSE) or 1 (TRUE)"))
            }
            _ => Ok(given),
        };
    };
    if row.role == Role::Cycle && given < 0.0005 {
        return Err(format!("{name} = {given:?} s: the time between two calls must be at least 0.001 s"));
    }
    to_value(given, row.kind).map(number).map_err(|range| format!("{name} = {given:?}: {range}"))
}

/// The value as rounded by the type: Boolean if a Boolean was given, a number otherwise.
fn as_given(given: Value, held: f64) -> Value {
    match given {
        Value::Boolean(_) => Value::Boolean(held != 0.0),
        Value::Whole(_) | Value::Number(_) => Value::Number(held),
    }
}

/// A warning if the value is outside its recommended range.
fn outside(variable: &Variable, value: f64) -> Option<String> {
    let unit = variable.unit.as_ref().map_or_else(String::new, |unit| format!(" {}", units::shown(unit)));
    let (bound, which) = match (variable.min, variable.max) {
        (Some(min), _) if value < min => (min, "lowest"),
        (_, Some(max)) if value > max => (max, "highest"),
        _ => return None,
    };
    Some(format!("{} = {value}{unit}: the {which} sensible value is {bound}{unit}", variable.name))
}

/// The block's advice on its settings.
fn advice(home: &dyn Home, table: &Table, value: &dyn Fn(&str) -> f64, refused: &[Remark]) -> Vec<Remark> {
    if refused.iter().any(|remark| remark.is_error) {
        // The start values would replace the invalid values, and the advice would not apply to the user's settings.
        return Vec::new();
    }
    let Some(block) = home.blocks().into_iter().find(|block| block.name == table.name) else { return Vec::new() };
    let settings = block.members.iter().enumerate().filter(|(_, member)| member.role.is_settable());
    let settings: Vec<_> = settings
        .filter_map(|(index, member)| Some((index, to_value(value(&member.name), member.kind).ok()?)))
        .collect();
    let remark = |text: String| Remark { variables: named(table, &text), text, is_error: false };
    block.advice(&settings).into_iter().map(remark).collect()
}

/// The variables named in a sentence, without duplicates.
fn named(table: &Table, text: &str) -> Vec<String> {
    let is_of_name = |character: char| character.is_alphanumeric() || character == '_' || character == '.';
    let mut named: Vec<String> = Vec::new();
    for word in text.split(|character| !is_of_name(character)).map(|word| word.trim_matches('.')) {
        if table.find(word).is_some() && !named.iter().any(|known| known == word) {
            named.push(word.to_string());
        }
    }
    named
}

#[cfg(test)]
mod tests;
