//! JSON: an object for each loop, with the names and numbers of the FMU.
//!
//! ```json
//! {
//!   "TIC101": {
//!     "ON": false,
//!     "GAIN": 2.0,
//!     "TI": 20.0
//!   }
//! }
//! ```
//!
//! A TIME is in seconds. An object without nested objects is a single unnamed loop. Missing members have the
//! block's start values. The file does not state the block of a loop, which is identified by its names.

use crate::block::BlockType;
use crate::loops::Loop;
use crate::named::{self, Choice, Entry, Given};
use crate::problem::quoted;
use crate::report::{MOST_LOOPS, Report};
use crate::value;
use crate::{Options, Problems, Reading, Source};
use jsonc_parser::ast::{Object, ObjectProp, Value};
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// Strict JSON, without the parser's extensions.
const STRICT: ParseOptions = ParseOptions {
    allow_comments: false,
    allow_loose_object_property_names: false,
    allow_trailing_commas: false,
    allow_missing_commas: false,
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// Reads the loops of a JSON file.
///
/// # Errors
/// The file is malformed, or the block of a loop is ambiguous; [`Options::block`] resolves that.
pub fn read(source: &Source, blocks: &[Arc<BlockType>], options: &Options) -> Result<Reading, Problems> {
    let mut report = Report::new(source, options);
    let loops = loops(&mut report, source, blocks, options);
    report.finish(loops)
}

fn loops(report: &mut Report, source: &Source, blocks: &[Arc<BlockType>], options: &Options) -> Vec<Loop> {
    let mut loops = Vec::new();
    let Ok(chosen) = report.chosen(blocks, options) else { return loops };
    let span = |ranged: &dyn Ranged| {
        let range = ranged.range();
        range.start..range.end
    };
    let object = match parse_to_ast(&source.text, &CollectOptions::default(), &STRICT) {
        Ok(parsed) => match parsed.value {
            Some(Value::Object(object)) => object,
            Some(other) => {
                let message = format!("expected an object with loops, found {}", described(&other));
                report.wrong(span(&other), message, None);
                return loops;
            }
            None => {
                report.wrong_file("expected a JSON object with loops, found an empty file", None);
                return loops;
            }
        },
        Err(error) => {
            let range = error.range();
            let message = format!("this is not JSON: {}", lower_first(&error.kind().to_string()));
            report.wrong(range.start..range.end, message, None);
            return loops;
        }
    };

    let is_loop = |property: &ObjectProp| matches!(property.value, Value::Object(_));
    if !object.properties.iter().any(is_loop) {
        if object.properties.is_empty() && chosen.is_none() {
            return loops;
        }
        let name = report.loop_name(options);
        let entries = entries(&object, &span);
        let choice = Choice { block: chosen.as_ref(), is_for_one: true };
        loops.extend(named::read(report, blocks, choice, &name, span(&object), &entries));
        return loops;
    }
    let choice = Choice { block: chosen.as_ref(), is_for_one: object.properties.len() == 1 };
    let mut names = BTreeSet::new();
    for property in &object.properties {
        let name = property.name.as_str();
        let at = span(&property.name);
        if !names.insert(name) {
            report.wrong(at, format!("the loop {} appears twice: remove or rename one", quoted(name)), None);
            continue;
        }
        if names.len() > MOST_LOOPS {
            report.wrong(at, format!("the file has more than {MOST_LOOPS} loops; split it"), None);
            break;
        }
        match &property.value {
            Value::Object(object) => {
                let entries = entries(object, &span);
                loops.extend(named::read(report, blocks, choice, name, at, &entries));
            }
            other => {
                let found = described(other);
                let message = format!("{}: expected an object with the values of a loop, found {found}", quoted(name));
                report.wrong(
                    span(other),
                    message,
                    Some("move it into the loop to which it belongs, or remove it".into()),
                );
            }
        }
    }
    loops
}

fn entries<'a>(object: &'a Object<'a>, span: &dyn Fn(&dyn Ranged) -> Range<usize>) -> Vec<Entry<'a>> {
    let entry = |property: &'a ObjectProp<'a>| Entry {
        name: property.name.as_str(),
        name_span: span(&property.name),
        given: match &property.value {
            Value::NumberLit(number) => Given::Number(number.value),
            Value::BooleanLit(boolean) => Given::Bool(boolean.value),
            other => Given::Other(described(other)),
        },
        span: span(&property.value),
    };
    object.properties.iter().map(entry).collect()
}

fn described(value: &Value) -> &'static str {
    match value {
        Value::StringLit(_) => "a string",
        Value::NumberLit(_) => "a number",
        Value::BooleanLit(_) => "a Boolean",
        Value::Object(_) => "an object",
        Value::Array(_) => "an array",
        Value::NullKeyword(_) => "null",
    }
}

fn lower_first(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_lowercase().chain(characters).collect())
}

/// Writes all settings of the loops, in the order of their blocks.
///
/// # Errors
/// A value is not finite, or two loops have the same name.
pub fn write(loops: &[Loop]) -> Result<String, String> {
    named::check_names(loops)?;
    let object = |one: &Loop| {
        let member = |setting: &crate::MemberValue| {
            let name = &one.block.members[setting.member].name;
            let value = value::text(setting.value)
                .map_err(|value| format!("{}: {name} is {value}, but JSON has only finite numbers", one.name))?;
            Ok(format!("    {}: {value}", string(name)))
        };
        let members: Result<Vec<String>, String> = one.settings.iter().map(member).collect();
        Ok(format!("  {}: {{\n{}\n  }}", string(&one.name), members?.join(",\n")))
    };
    let objects: Result<Vec<String>, String> = loops.iter().map(object).collect();
    Ok(format!("{{\n{}\n}}\n", objects?.join(",\n")))
}

fn string(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
