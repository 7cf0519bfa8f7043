//! The operands that decided a program's assignments in a call, for the page.

use program::Program;
use scl::watch::{CodeBlock, Influence, Logic};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// The decisions that led to an assignment.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Decisions {
    /// The decision on the assigned value; `None` if it is not a truth value.
    pub value: Option<Decision>,
    /// The decisions on the conditions under which the assignment is executed, in order.
    pub guards: Vec<Option<Decision>>,
}

/// The operands that decided a truth value.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Decision {
    /// The value; `None` if it was not calculated in this call.
    pub truth: Option<bool>,
    /// The role of each operand in the decision: `decided`, `shared` (did not decide alone), `idle` (made no
    /// difference).
    #[cfg_attr(test, ts(type = "(\"decided\" | \"shared\" | \"idle\")[]"))]
    pub parts: Vec<String>,
    /// The values of the operands when the decision was calculated; `None` for an operand that is not a Boolean.
    pub values: Vec<Option<bool>>,
    /// The numbers of the deciding truth values, as in `Monitored::wires`.
    pub wires: Vec<u32>,
}

/// The decisions for each write of a block in the instance at `path`.
pub(super) fn decisions(program: &Program, blocks: &[CodeBlock], block: &str, path: &str) -> Vec<Decisions> {
    let Some(of) = blocks.iter().find(|of| of.name.eq_ignore_ascii_case(block)) else { return Vec::new() };
    let mut noted: HashMap<u32, Option<bool>> = HashMap::new();
    for (wire, truth) in program.wires(block, path) {
        // A value that was calculated more than once with different results is unknown.
        noted.entry(wire).and_modify(|kept| *kept = kept.filter(|kept| *kept == truth)).or_insert(Some(truth));
    }
    let value = |wire: u32| noted.get(&wire).copied().flatten();
    let decision = |logic: &Option<Logic>, reads: usize| {
        let logic = logic.as_ref()?;
        let Some(found) = logic.decided(reads, &value) else { return Some(Decision::default()) };
        let word = |part: &Influence| match part {
            Influence::Decided => "decided",
            Influence::Shared => "shared",
            Influence::Idle => "idle",
        };
        let parts = found.parts.iter().map(|part| word(part).to_string()).collect();
        Some(Decision { truth: Some(found.truth), parts, values: found.values, wires: found.wires })
    };
    let each = |of: &scl::watch::Write| Decisions {
        value: decision(&of.logic, of.reads.len()),
        guards: of.guards.iter().map(|guard| decision(&guard.logic, guard.reads.len())).collect(),
    };
    of.writes.iter().map(each).collect()
}
