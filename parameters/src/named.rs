//! Loops given as names and numbers, as in JSON and SSV: a TIME is in seconds, as in the FMU.

use crate::block::BlockType;
use crate::loops::Loop;
use crate::problem::{Remedy, quoted, with_article};
use crate::report::{Report, list};
use crate::value::plc_value;
use blocks::{Form, Kind, Row, Value};
use std::ops::Range;
use std::sync::Arc;

/// A named value, with the locations of both.
pub(crate) struct Entry<'a> {
    pub(crate) name: &'a str,
    pub(crate) name_span: Range<usize>,
    pub(crate) given: Given<'a>,
    pub(crate) span: Range<usize>,
}

/// The maximum length, in bytes, of a name for which similar names are suggested.
const LONGEST_NAME: usize = 60;

/// A value as found in a file.
#[derive(Clone, Copy)]
pub(crate) enum Given<'a> {
    /// A decimal.
    Number(&'a str),
    /// TRUE or FALSE.
    Bool(bool),
    /// Anything else, described for a message.
    Other(&'a str),
}

/// The user's choice of block for the loops of a file.
#[derive(Clone, Copy)]
pub(crate) struct Choice<'a> {
    /// The block for loops that do not name theirs.
    pub(crate) block: Option<&'a Arc<BlockType>>,
    /// Whether the file has only one loop: the chosen block then applies, whatever names its values have.
    pub(crate) is_for_one: bool,
}

/// Builds the loop with these values. Its block is the one chosen by the user, unless the file has several loops and
/// only other blocks have all these names; without a choice, or in that case, it is recognized by the names. `span` is
/// the location of the loop.
pub(crate) fn read(
    report: &mut Report,
    blocks: &[Arc<BlockType>],
    chosen: Choice,
    name: &str,
    span: Range<usize>,
    entries: &[Entry],
) -> Option<Loop> {
    let fits = |block: &Arc<BlockType>| entries.iter().all(|entry| is_settable(block, entry.name));
    let block = match chosen.block {
        Some(block) if chosen.is_for_one || fits(block) || !blocks.iter().any(fits) => block.clone(),
        _ => recognize(report, blocks, name, span, entries)?,
    };
    let mut one = Loop::new(name, block.clone());
    let mut given = vec![false; block.members.len()];
    let mut is_right = true;
    for entry in entries {
        let wrong = match member(&block, entry.name) {
            Err((message, help)) => Some((&entry.name_span, message, help)),
            Ok(index) if std::mem::replace(&mut given[index], true) => {
                Some((&entry.name_span, format!("{} appears twice: remove one", block.members[index].name), None))
            }
            Ok(index) => match value(&block.members[index], entry.given) {
                Err(message) => Some((&entry.span, message, None)),
                Ok(value) => {
                    one.set(index, value, report.origin(entry.span.clone()));
                    None
                }
            },
        };
        if let Some((span, message, help)) = wrong {
            is_right = false;
            report.wrong(span.clone(), message, help);
        }
    }
    is_right.then_some(one)
}

/// The index of the settable member with this name; otherwise an error message and, if possible, a suggestion.
pub(crate) fn member(block: &BlockType, name: &str) -> Result<usize, (String, Option<String>)> {
    match block.find(name) {
        Some(index) if block.members[index].role.is_settable() => Ok(index),
        Some(index) => {
            let member = &block.members[index];
            let what = member.role.name();
            Err((
                format!(
                    "{} of {} is {}: only inputs and parameters can be set",
                    member.name,
                    block.name,
                    with_article(what)
                ),
                None,
            ))
        }
        None => {
            let settable = block.members.iter().filter(|member| member.role.is_settable());
            let nearest = settable
                .filter(|_| name.len() <= LONGEST_NAME)
                .map(|member| (strsim::damerau_levenshtein(&name.to_uppercase(), &member.name.to_uppercase()), member))
                .min_by_key(|(distance, _)| *distance)
                .filter(|(distance, member)| *distance <= 1 + member.name.len() / 4);
            let help = nearest.map(|(_, member)| format!("did you mean {}?", member.name));
            Err((format!("{} has no input or parameter {}", block.name, quoted(name)), help))
        }
    }
}

/// The only block with all these names; if several have them, the one with no other inputs and parameters.
fn recognize(
    report: &mut Report,
    blocks: &[Arc<BlockType>],
    name: &str,
    span: Range<usize>,
    entries: &[Entry],
) -> Option<Arc<BlockType>> {
    let matches = |block: &&Arc<BlockType>| entries.iter().filter(|entry| is_settable(block, entry.name)).count();
    let fitting: Vec<&Arc<BlockType>> = blocks.iter().filter(|block| matches(block) == entries.len()).collect();
    let names: Vec<&str> = entries.iter().map(|entry| entry.name).collect();
    let mut whole = fitting.iter().filter(|block| is_complete(block, &names));
    match (fitting.as_slice(), whole.next(), whole.next()) {
        ([block], ..) | (_, Some(block), None) => Some((*block).clone()),
        ([], ..) => {
            // Errors refer to the block that fits best; a block that fits only by chance would mislead.
            let best = blocks.iter().max_by_key(matches).filter(|block| 2 * matches(block) >= entries.len());
            if best.is_none() {
                let help = Some(Remedy::ChooseBlock(list(blocks)));
                report.wrong_with(span, format!("{}: no block has these inputs and parameters", quoted(name)), help);
            }
            best.cloned()
        }
        (several, ..) => {
            let several: Vec<Arc<BlockType>> = several.iter().map(|block| (*block).clone()).collect();
            let help = Some(Remedy::ChooseBlock(list(&several)));
            report.wrong_with(span, format!("{}: several blocks have these inputs and parameters", quoted(name)), help);
            None
        }
    }
}

/// Whether these are the names of all inputs and parameters of the block.
pub(crate) fn is_complete(block: &BlockType, names: &[&str]) -> bool {
    let settable = block.members.iter().filter(|member| member.role.is_settable()).count();
    names.len() == settable && names.iter().all(|name| is_settable(block, name))
}

/// Whether the block has an input or parameter with this name.
pub(crate) fn is_settable(block: &BlockType, name: &str) -> bool {
    block.find(name).is_some_and(|index| block.members[index].role.is_settable())
}

/// Converts a value to the member's type. A value outside the plausible range is not an error: the block accepts it.
fn value(member: &Row, given: Given) -> Result<Value, String> {
    let expected = match member.kind.form() {
        Form::Switch => "true or false",
        Form::Duration => "a number of seconds",
        Form::Decimal => "a number",
        Form::Bits | Form::Integer => "an integer",
    };
    let found = match (given, member.kind) {
        (Given::Bool(bool), Kind::Bool) => return Ok(Value::Bool(bool)),
        (Given::Number(text), kind) if kind != Kind::Bool => {
            return match text.parse().map(|number| plc_value(number, kind)) {
                Ok(Ok(value)) => Ok(value),
                Ok(Err(range)) => Err(format!("{}: found {}, but {range}", member.name, quoted(text))),
                Err(_) => Err(format!("{}: expected {expected}, found {}", member.name, quoted(text))),
            };
        }
        (Given::Number(text), _) => quoted(text),
        (Given::Bool(bool), _) => bool.to_string(),
        (Given::Other(what), _) => what.to_string(),
    };
    Err(format!("{}: expected {expected}, found {found}", member.name))
}

/// Rejects two loops with the same name, which a reader could not tell apart.
pub(crate) fn check_names(loops: &[Loop]) -> Result<(), String> {
    let mut names = std::collections::BTreeSet::new();
    match loops.iter().find(|one| !names.insert(&one.name)) {
        Some(one) => Err(format!("two loops are called {}: rename one, or write only one", one.name)),
        None => Ok(()),
    }
}
