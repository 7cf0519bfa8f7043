//! A project's files as a program: selects the files that belong to it, and adds tag tables and stubs to its sources.

use manifest::Manifest;
use parameters::Source;
use parameters::tags::{self, Declared, Tags};
use std::collections::HashMap;

/// The extensions of source files.
pub const SOURCES: [&str; 7] = ["scl", "udt", "db", "awl", "xml", "s7dcl", "s7res"];

/// The extensions of tag tables. Not every file with such an extension is a tag table.
pub const TABLES: [&str; 3] = ["xml", "xlsx", "sdf"];

/// The name of the source that contains the stubs; it is not a file.
const STUBS: &str = "stubs.scl";

/// The role of a file in a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Kind {
    Source,
    Table,
    Other,
}

/// The extension of a file, in lower case.
pub fn ending(file: &str) -> String {
    let name = file.rsplit(['/', '\\']).next().unwrap_or_default();
    name.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase()
}

/// The kind of a file, determined by its extension and, for XML, its text. Every workbook counts as a tag table.
pub fn kind(file: &str, text: impl FnOnce() -> Option<String>) -> Kind {
    match ending(file).as_str() {
        "sdf" | "xlsx" => Kind::Table,
        // A project also contains other XML files.
        "xml" => match text() {
            Some(text) if tags::is_table(&text) => Kind::Table,
            Some(text) if text.contains("<SW.") => Kind::Source,
            _ => Kind::Other,
        },
        ending if SOURCES.contains(&ending) => Kind::Source,
        _ => Kind::Other,
    }
}

/// The contents of a program's files.
#[derive(Clone, Debug)]
pub struct Parts {
    /// The sources, followed by one with stubs if the manifest names stubs that no file declares.
    pub sources: Vec<Source>,
    /// The manifest as given, followed by the tags and constants that the tables declare.
    pub manifest: Manifest,
    /// The tag tables: the file, the number of tags and the number of constants.
    pub tables: Vec<(String, usize, usize)>,
}

/// Combines sources and tag tables. Declarations in the manifest take precedence.
///
/// # Errors
/// Two tables declare a name differently.
pub fn parts(manifest: &Manifest, sources: Vec<Source>, tables: Vec<(String, Tags)>) -> Result<Parts, String> {
    let mut parts = Parts { sources, manifest: manifest.clone(), tables: Vec::new() };
    let mut known: HashMap<String, (String, Declared)> = HashMap::new();
    for (file, Tags { tags, constants }) in tables {
        parts.tables.push((file.clone(), tags.len(), constants.len()));
        let all = tags.into_iter().map(Declared::Tag).chain(constants.into_iter().map(Declared::Constant));
        for declared in all {
            let name = match &declared {
                Declared::Tag(tag) => tag.name.clone(),
                Declared::Constant(constant) => constant.name.clone(),
            };
            match known.get(&name.to_uppercase()) {
                Some((_, earlier)) if is_same(earlier, &declared) => continue,
                Some((earlier, _)) => {
                    return Err(format!(
                        "{earlier} and {file} declare {name:?} differently: correct one of them, or omit one of the files"
                    ));
                }
                None => {}
            }
            match &declared {
                Declared::Tag(tag) => parts.manifest.declared.push(tag.clone()),
                Declared::Constant(of) => parts.manifest.constants.push((of.name.clone(), of.value.clone())),
            }
            known.insert(name.to_uppercase(), (file.clone(), declared));
        }
    }
    let stubs = stubs(&parts.sources, &parts.manifest);
    parts.sources.extend(stubs);
    Ok(parts)
}

/// Whether two declarations of a name are equal apart from their comments.
fn is_same(one: &Declared, other: &Declared) -> bool {
    match (one, other) {
        (Declared::Tag(one), Declared::Tag(other)) => {
            one.of.eq_ignore_ascii_case(&other.of) && one.address == other.address
        }
        (one, other) => one == other,
    }
}

/// A source with the stubs that the manifest names but no source declares.
fn stubs(sources: &[Source], manifest: &Manifest) -> Option<Source> {
    if manifest.stubs.is_empty() {
        return None;
    }
    let assumptions = scl::assume(sources, manifest, Some(&manifest.stubs));
    (!assumptions.is_empty()).then(|| Source::new(STUBS, scl::assumed(&assumptions).into_bytes()))
}
