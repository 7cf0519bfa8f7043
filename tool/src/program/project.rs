//! Converts the files of a project opened by the page to a program.

use crate::message::SourceFile;
use anyhow::{Context, Error, Result, anyhow, ensure};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use manifest::Manifest;
use modeldescription::shortened;
use parameters::Source;
use parameters::problem::drawn;
use parameters::tags::workbook::sheets;
use parameters::tags::{self, Tags};
use program::project::{Kind, Parts, kind, parts};
use std::collections::BTreeMap;

/// The maximum total size of the files, in bytes.
const LARGEST: usize = 16 << 20;

/// Marks a part of a workbook: the page unpacks workbooks and appends the part's path to the workbook's name.
const WORKBOOK: &str = ".xlsx/";

/// The sources and the tag tables among files. Ignores files that do not belong to a program.
///
/// # Errors
/// A file is not Base64, a tag table is faulty, the files are too large, or there is no source among them.
pub(super) fn read(files: &[SourceFile], manifest: &Manifest) -> Result<Parts> {
    let size: usize = files.iter().map(|of| of.content.len() / 4 * 3).sum();
    ensure!(
        size <= LARGEST,
        "the sources are larger than {} MiB: leave out files that the program does not use",
        LARGEST >> 20
    );
    let (mut sources, mut tables): (Vec<Source>, Vec<(String, Tags)>) = (Vec::new(), Vec::new());
    let mut workbooks: BTreeMap<&str, BTreeMap<&str, Vec<u8>>> = BTreeMap::new();
    for SourceFile { file, content } in files {
        let bytes = STANDARD.decode(content).with_context(|| format!("the content of {file} is not Base64"))?;
        if let Some(at) = file.find(WORKBOOK) {
            let (name, part) = (&file[..at + WORKBOOK.len() - 1], &file[at + WORKBOOK.len()..]);
            workbooks.entry(name).or_default().insert(part, bytes);
            continue;
        }
        let source = Source::new(file.as_str(), bytes);
        match kind(file, || Some(source.text.clone())) {
            Kind::Source => {
                let is_second = sources.iter().any(|other| other.file.eq_ignore_ascii_case(file));
                ensure!(!is_second, "two sources are named {}: rename one", shortened(file));
                sources.push(source);
            }
            Kind::Table => {
                let tags = tags::read(&source).map_err(|wrong| anyhow!("{}", drawn(&wrong).trim_end()))?;
                tables.push((file.clone(), tags));
            }
            Kind::Other => {}
        }
    }
    for (name, parts) in workbooks {
        let tags = workbook(parts).map_err(|wrong| anyhow!("{name}: {wrong}"))?;
        tables.extend(tags.map(|tags| (name.to_string(), tags)));
    }
    ensure!(!sources.is_empty(), "no source: open files that end in .scl, .udt, .db, .s7dcl, .xml or .awl");
    parts(manifest, sources, tables).map_err(Error::msg)
}

/// The tags of a workbook; `None` if it contains no tag table.
fn workbook(mut parts: BTreeMap<&str, Vec<u8>>) -> Result<Option<Tags>, String> {
    let mut part = |path: &str| {
        let bytes = parts.remove(path);
        bytes.map(String::from_utf8).transpose().map_err(|_| format!("{path} is not UTF-8"))
    };
    let (mut tags, mut has_table) = (Tags::default(), false);
    for (name, rows) in sheets(&mut part)? {
        has_table |= tags::of_sheet(&rows, &mut tags).map_err(|wrong| format!("sheet {name:?}: {wrong}"))?;
    }
    Ok(has_table.then_some(tags))
}
