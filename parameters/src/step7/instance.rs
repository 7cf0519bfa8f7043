//! Reads the values of one instance.

use super::parser::Name;
use super::values::Assignment;
use crate::block::BlockType;
use crate::literal;
use crate::loops::Loop;
use crate::problem::{nearest, quoted};
use crate::report::Report;
use blocks::{Form, Kind};
use std::collections::HashSet;
use std::ops::Range;
use std::sync::Arc;

/// The maximum number of variables in a block's memory. Siemens' blocks have nine.
const MOST_MEMORY: usize = 100;

/// An instance whose values are being read.
pub(super) struct Instance {
    pub(super) one: Loop,
    /// For each member, the range of its value in the text.
    given: Vec<Option<Range<usize>>>,
    /// The paths of instances whose last member was given: anything after it is the block's memory.
    complete: HashSet<String>,
    /// The number of values given for the block's memory.
    memory: usize,
    /// The location of the first REAL with seven digits.
    pub(super) seven_digits: Option<Range<usize>>,
}

impl Instance {
    pub(super) fn new(name: &str, block: Arc<BlockType>) -> Instance {
        let given = vec![None; block.members.len()];
        Instance { one: Loop::new(name, block), given, complete: HashSet::new(), memory: 0, seven_digits: None }
    }

    /// Assigns a value; `path` is the member's name relative to the instance. Values that the block computes itself,
    /// its outputs and its memory, are ignored.
    pub(super) fn assign(&mut self, path: &[String], assignment: &Assignment, report: &mut Report) {
        let name = path.join(".");
        let block = self.one.block.clone();
        let prefix = name.rsplit_once('.').map_or("", |(prefix, _)| prefix).to_uppercase();
        let Some(index) = find(&block, &name) else {
            if self.is_memory(&prefix, &name) {
                return;
            }
            // Searching for a suggestion takes time, which would be wasted on a problem that is only counted.
            let help = if report.has_room() { self.suggestion(&name) } else { None };
            let message = format!("{} has no member {}", block.name, quoted(&name));
            report.wrong(assignment.path_span.clone(), message, help);
            return;
        };
        if is_last(&block, index) {
            self.complete.insert(prefix);
        }
        self.set(index, assignment, report);
    }

    /// Assigns a value to the member with this index.
    pub(super) fn set(&mut self, index: usize, assignment: &Assignment, report: &mut Report) {
        let member = &self.one.block.members[index];
        if let Some(first) = self.given[index].replace(assignment.path_span.clone()) {
            let line = report.line(first);
            let message = format!("{} is assigned twice; the first assignment is on line {line}", member.name);
            report.wrong(assignment.path_span.clone(), message, None);
            return;
        }
        if !member.role.is_settable() {
            return;
        }
        match literal::parse(&assignment.literal, member.kind) {
            Ok(value) => {
                if member.kind == Kind::Real && self.seven_digits.is_none() && has_seven_digits(&assignment.literal) {
                    self.seven_digits = Some(assignment.literal_span.clone());
                }
                let origin = report.origin(assignment.literal_span.clone());
                self.one.set(index, value, origin);
            }
            Err(message) => {
                let message = format!("{}: {message}", member.name);
                report.wrong(assignment.literal_span.clone(), message, None);
            }
        }
    }

    /// Assigns all values by position, for a block uploaded without names: `IN0`, `IN7`, `OUT22`.
    pub(super) fn assign_by_position(&mut self, db: &Name, assignments: &[Assignment], report: &mut Report) {
        let block = self.one.block.clone();
        let own: Vec<usize> = (0..block.members.len()).filter(|index| block.is_own(*index)).collect();
        let needed = own.iter().rposition(|index| block.members[*index].role.is_settable()).map_or(0, |last| last + 1);
        let mut previous = None;
        for (position, assignment) in assignments.iter().enumerate() {
            let name = assignment.path.join(".");
            let lost = lost_name(&name).filter(|(_, number)| previous.is_none_or(|previous| previous < *number));
            let member = own.get(position).map(|index| &block.members[*index]);
            let fits = match (lost, member) {
                (Some(("STAT", _)), None) => continue,
                (Some(("IN", _)), Some(member)) => {
                    member.role.is_settable() && has_form(&assignment.literal, member.kind)
                }
                (Some(("OUT", _)), Some(member)) => {
                    !member.role.is_settable() && has_form(&assignment.literal, member.kind)
                }
                _ => false,
            };
            if !fits {
                let expected = match member {
                    Some(member) => format!("expected {} ({}) at this position", member.name, member.kind.name()),
                    None => "expected only memory (STAT) at this position".to_string(),
                };
                let found = format!("{} := {}", quoted(&name), quoted(&assignment.literal));
                let message = format!("the member names are lost: in {}, {expected}, found {found}", block.name);
                report.wrong(assignment.path_span.clone(), message, None);
                return;
            }
            previous = lost.map(|(_, number)| number);
            self.set(own[position], assignment, report);
        }
        if assignments.len() < needed {
            let message = format!(
                "the member names are lost: {} has {} inputs and parameters, found {} values",
                block.name,
                needed,
                assignments.len()
            );
            report.wrong(db.span.clone(), message, None);
            return;
        }
        let message = format!("{}: the member names are lost; the values were assigned by position", db.text);
        report.remark(Some(db.span.clone()), message);
    }

    /// Whether a member that is not in the table belongs to the block's memory, which follows all other members. A name
    /// similar to that of an unassigned member is taken for a typo instead.
    fn is_memory(&mut self, prefix: &str, name: &str) -> bool {
        self.memory += usize::from(self.complete.contains(prefix));
        self.complete.contains(prefix) && self.memory <= MOST_MEMORY && self.suggestion(name).is_none()
    }

    /// Suggests the unassigned member with the most similar name.
    fn suggestion(&self, name: &str) -> Option<String> {
        let members = self.one.block.members.iter().enumerate();
        let free = members.filter(|(index, member)| member.role.is_settable() && self.given[*index].is_none());
        let nearest = nearest(name, free.map(|(_, member)| member.name.as_str()))?;
        Some(format!("did you mean {nearest}?"))
    }
}

/// The number of inputs and parameters among these names; `None` if they cannot be those of an instance of the block:
/// its members, each at most once, followed by its memory.
pub(super) fn fit<'a>(block: &BlockType, names: impl IntoIterator<Item = &'a [String]>) -> Option<usize> {
    let mut given = vec![false; block.members.len()];
    let mut memory = 0;
    let mut is_complete = false;
    for name in names {
        match find(block, &name.join(".")) {
            Some(index) if std::mem::replace(&mut given[index], true) => return None,
            Some(index) => is_complete |= is_last(block, index),
            None if is_complete && memory < MOST_MEMORY => memory += 1,
            None => return None,
        }
    }
    Some((0..given.len()).filter(|index| given[*index] && block.members[*index].role.is_settable()).count())
}

/// The member with this name, if it exists in the PLC.
pub(super) fn find(block: &BlockType, name: &str) -> Option<usize> {
    block.find(name).filter(|index| block.mean != Some(*index))
}

/// Whether the member is the last one of its instance.
fn is_last(block: &BlockType, index: usize) -> bool {
    let path = |index: usize| block.members[index].name.rsplit_once('.').map(|(path, _)| path);
    let is_of_instance = |other: &usize| block.mean != Some(*other) && path(*other) == path(index);
    !(index + 1..block.members.len()).any(|other| is_of_instance(&other))
}

/// Whether a number has an exponent and seven digits, as generated by STEP 7. Two REALs may then have the same literal.
fn has_seven_digits(literal: &str) -> bool {
    match literal.split_once(['e', 'E']) {
        Some((mantissa, _)) => mantissa.bytes().filter(u8::is_ascii_digit).count() == 7,
        None => false,
    }
}

/// The section and the index in a name that a PLC generates for a member whose own name is lost.
pub(super) fn lost_name(name: &str) -> Option<(&'static str, u32)> {
    let section = ["IN", "OUT", "STAT"].into_iter().find(|section| {
        name.get(..section.len()).is_some_and(|start| start.eq_ignore_ascii_case(section))
            && name[section.len()..].starts_with(|c: char| c.is_ascii_digit())
    })?;
    Some((section, name[section.len()..].parse().ok()?))
}

/// Whether a literal is in the PLC's notation for this type.
fn has_form(literal: &str, kind: Kind) -> bool {
    let has_type = literal.contains('#');
    match kind.form() {
        Form::Decimal => !has_type && literal.contains(['.', 'e', 'E']),
        Form::Duration => literal::parse(literal, kind).is_ok(),
        Form::Bits => has_type && literal::parse(literal, kind).is_ok(),
        Form::Switch => literal.eq_ignore_ascii_case("TRUE") || literal.eq_ignore_ascii_case("FALSE"),
        Form::Integer => !has_type && literal::parse(literal, kind).is_ok(),
    }
}
