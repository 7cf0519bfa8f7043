//! Findings about a model description, as sentences, and the rules common to all FMI versions.

use crate::description::{DefaultExperiment, DependencyKind};
use crate::xml::lexical::is_xml;
use std::cmp::Ordering;
use std::collections::HashSet;
use std::fmt::Debug;

/// The maximum number of findings of a kind in a report; an additional sentence states the number of the others.
pub const MOST_FINDINGS: usize = 20;

/// The findings of a check, one sentence each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    /// Violations of the FMI standard. A host may reject the FMU.
    pub forbidden: Vec<String>,
    /// Violations that importers tolerate: all importers tested run such FMUs anyway. These are variables missing
    /// from InitialUnknowns, which importers use only for algebraic loops during initialization.
    pub departures: Vec<String>,
    /// Permitted or common practice that may mislead a host.
    pub odd: Vec<String>,
}

impl Findings {
    /// All findings.
    pub fn all(self) -> Vec<String> {
        [self.forbidden, self.departures, self.odd].concat()
    }
}

/// The first findings, and the number of the others.
#[derive(Default)]
pub(crate) struct Counted {
    first: Vec<String>,
    more: usize,
}

impl Counted {
    pub(crate) fn push(&mut self, sentence: String) {
        if self.first.len() < MOST_FINDINGS {
            self.first.push(sentence);
        } else {
            self.more += 1;
        }
    }

    pub(crate) fn sentences(mut self) -> Vec<String> {
        if self.more > 0 {
            self.first.push(format!("and {} more", self.more));
        }
        self.first
    }
}

/// Each occurrence of a name after its first.
pub(crate) fn repeated<'a>(names: impl Iterator<Item = &'a String>) -> Vec<&'a String> {
    let mut seen = HashSet::new();
    names.filter(|name| !seen.insert(name.as_str())).collect()
}

/// Checks that each dependency has a kind, if any has.
pub(crate) fn check_kinds(
    dependencies: Option<&[u32]>,
    kinds: Option<&[DependencyKind]>,
    found: &mut impl FnMut(String),
) {
    let (kinds, dependencies) = (kinds.map(<[_]>::len), dependencies.map_or(0, <[_]>::len));
    if let Some(kinds) = kinds.filter(|kinds| *kinds != dependencies) {
        found(format!(
            "dependenciesKind and dependencies differ in length ({kinds} and {dependencies}): give one kind for each \
             dependency"
        ));
    }
}

/// Checks the model's name, identifier, description and default experiment.
pub(crate) fn check_model(
    name: &str,
    identifier: Option<&str>,
    description: Option<&str>,
    experiment: Option<DefaultExperiment>,
    forbidden: &mut Counted,
    odd: &mut Counted,
) {
    if let Some(identifier) = identifier {
        if !is_identifier(identifier) {
            forbidden.push(format!(
                "modelIdentifier = {identifier:?} is not a C identifier: use letters, digits and _, but no leading digit"
            ));
        }
        if identifier != name {
            odd.push(format!(
                "modelIdentifier = {identifier:?} differs from modelName = {name:?}: name the library after the model"
            ));
        }
    }
    for (attribute, text) in [("modelName", Some(name)), ("description", description)] {
        if let Some(character) = text.and_then(unwritable) {
            forbidden.push(format!("{attribute}: XML cannot represent the character {character:?}: remove it"));
        }
    }
    let experiment = experiment.unwrap_or_default();
    for (attribute, value) in [("stepSize", experiment.step_size), ("tolerance", experiment.tolerance)] {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
            odd.push(format!("DefaultExperiment: {attribute} = {value:?}: it must be a positive number"));
        }
    }
    if let (Some(start), Some(stop)) = (experiment.start_time, experiment.stop_time)
        && start.partial_cmp(&stop) != Some(Ordering::Less)
    {
        odd.push(format!("DefaultExperiment: stopTime = {stop:?}: it must be later than startTime = {start:?}"));
    }
}

/// A sentence about a variable whose name or description XML cannot represent.
pub(crate) fn check_texts(name: &str, description: Option<&str>) -> Option<String> {
    let character = unwritable(name).or_else(|| description.and_then(unwritable))?;
    Some(format!("XML cannot represent the character {character:?} in its name or description: remove it"))
}

/// The first character that XML cannot represent.
fn unwritable(text: &str) -> Option<char> {
    text.chars().find(|character| !is_xml(*character))
}

/// Reports an empty range or a start value outside it. A NaN is reported if there is another value to compare it with.
pub(crate) fn check_range<T: PartialOrd + Debug + Copy>(
    min: Option<T>,
    max: Option<T>,
    start: Option<T>,
    found: &mut impl FnMut(String),
) {
    let in_order = |low: T, high: T| low <= high;
    match (min, max) {
        (Some(min), Some(max)) if !in_order(min, max) => {
            return found(format!("min = {min:?} is above max = {max:?}: correct one of them"));
        }
        _ => {}
    }
    match (min, start) {
        (Some(min), Some(start)) if !in_order(min, start) => {
            found(format!("start = {start:?} is below min = {min:?}: correct one of them"));
        }
        _ => {}
    }
    match (start, max) {
        (Some(start), Some(max)) if !in_order(start, max) => {
            found(format!("start = {start:?} is above max = {max:?}: correct one of them"));
        }
        _ => {}
    }
}

/// Whether a name is a C identifier.
pub(crate) fn is_identifier(name: &str) -> bool {
    name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        && name.bytes().next().is_some_and(|first| !first.is_ascii_digit())
}

/// Whether a name follows the structured naming convention: `a.b[1,2].'c d'`, `der(a.b,2)`.
pub(crate) fn is_structured_name(name: &str) -> bool {
    let Some(inner) = name.strip_prefix("der(").and_then(|inner| inner.strip_suffix(')')) else {
        return is_structured_identifier(name);
    };
    // The order of the derivative may follow a comma. The text after a comma between indices is not a number: it ends
    // with a bracket.
    match inner.rsplit_once(',') {
        Some((identifier, order)) if is_number(order) => is_structured_identifier(identifier),
        _ => is_structured_identifier(inner),
    }
}

fn is_structured_identifier(name: &str) -> bool {
    let mut rest = name;
    loop {
        match after_part(rest).and_then(after_indices) {
            Some("") => return true,
            Some(after) => match after.strip_prefix('.') {
                Some(next) => rest = next,
                None => return false,
            },
            None => return false,
        }
    }
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// The text after the identifier or quoted name with which `text` starts; `None` if there is none.
fn after_part(text: &str) -> Option<&str> {
    let Some(quoted) = text.strip_prefix('\'') else {
        let end = text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(text.len());
        return is_identifier(&text[..end]).then(|| &text[end..]);
    };
    let mut characters = quoted.char_indices();
    while let Some((place, character)) = characters.next() {
        match character {
            '\'' => return (place > 0).then(|| &quoted[place + 1..]),
            '\\' => {
                characters.next().filter(|(_, escaped)| "'\"?\\abfnrtv".contains(*escaped))?;
            }
            '"' | '`' => return None,
            ' '..='~' => {}
            _ => return None,
        }
    }
    None
}

/// The text after the indices in brackets with which `text` starts, or all of it if it does not; `None` if the indices
/// are malformed.
fn after_indices(text: &str) -> Option<&str> {
    let Some(indices) = text.strip_prefix('[') else { return Some(text) };
    let (indices, after) = indices.split_once(']')?;
    indices.split(',').all(is_number).then_some(after)
}
