//! A table that summarizes the program in a project's files and lists its missing declarations.

use crate::project::{self, Parts};
use scl::{BlockKind, Survey};
use std::collections::{BTreeMap, BTreeSet};

/// The maximum number of names in a row.
const MOST_NAMES: usize = 10;

/// The block kinds, in the order of the report.
const KINDS: [(BlockKind, &str, &str); 5] = [
    (BlockKind::OrganizationBlock, "organization block", "organization blocks"),
    (BlockKind::FunctionBlock, "function block", "function blocks"),
    (BlockKind::Function, "function", "functions"),
    (BlockKind::DataBlock, "data block", "data blocks"),
    (BlockKind::Type, "type", "types"),
];

/// The rows of the table: a label and a text. `rest` follows the number of names that a row leaves out and states where
/// to find them.
pub fn rows(parts: &Parts, rest: &str) -> Vec<(&'static str, String)> {
    let Parts { sources, manifest, tables } = parts;
    let survey = scl::survey(sources, manifest);
    let files: Vec<&str> = sources.iter().map(|source| source.file.as_str()).collect();
    let mut rows = blocks(&survey, &files);
    if !tables.is_empty() {
        let (tags, constants) = tables.iter().fold((0, 0), |(tags, constants), of| (tags + of.1, constants + of.2));
        let used = match manifest.declared.is_empty() {
            true => String::new(),
            false => format!(", {} in use", survey.tags),
        };
        let constants = match constants {
            0 => String::new(),
            count => format!("; {}", counted(count, "constant", "constants")),
        };
        let of = counted(tables.len(), "table", "tables");
        rows.push(("tags", format!("{}{used}{constants}, from {of}", counted(tags, "tag", "tags"))));
    }
    rows.extend(missing(&survey, rest).into_iter().map(|text| ("missing", text)));
    rows
}

/// A count with its noun in singular or plural.
pub fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// The numbers of blocks by source format; data blocks and types have their own rows.
fn blocks(survey: &Survey, files: &[&str]) -> Vec<(&'static str, String)> {
    let mut forms: BTreeMap<&'static str, Vec<BlockKind>> = BTreeMap::new();
    for (kind, _, file) in &survey.blocks {
        let form = match kind {
            BlockKind::DataBlock => "data blocks",
            BlockKind::Type => "types",
            _ => form(files.get(*file).copied().unwrap_or_default()),
        };
        forms.entry(form).or_default().push(*kind);
    }
    let text = |kinds: Vec<BlockKind>| {
        let count = |of: BlockKind| kinds.iter().filter(|kind| **kind == of).count();
        let of = |(kind, one, several): &(BlockKind, &str, &str)| match count(*kind) {
            0 => None,
            count => Some(counted(count, one, several)),
        };
        KINDS.iter().filter_map(of).collect::<Vec<_>>().join(", ")
    };
    forms.into_iter().map(|(form, kinds)| (form, text(kinds))).collect()
}

/// The format of a source, by its extension.
fn form(file: &str) -> &'static str {
    match project::ending(file).as_str() {
        "xml" => "SimaticML",
        "s7dcl" => "SIMATIC SD",
        "awl" => "AWL",
        _ => "SCL",
    }
}

/// The names of the missing declarations, one line per kind.
fn missing(survey: &Survey, rest: &str) -> Vec<String> {
    let kinds: BTreeSet<&str> = survey.missing.iter().map(|(_, kind)| *kind).collect();
    let line = |kind: &str| {
        let names: Vec<String> =
            survey.missing.iter().filter(|(_, of)| *of == kind).map(|(name, _)| format!("\"{name}\"")).collect();
        let more = match names.len().saturating_sub(MOST_NAMES) {
            0 => String::new(),
            more => format!(", and {more} more{rest}"),
        };
        format!("{} {kind}: {}{more}", names.len(), names[..names.len().min(MOST_NAMES)].join(", "))
    };
    kinds.into_iter().map(line).collect()
}
