//! A table that summarizes a program in a folder and its missing parts.

use super::parts;
use ::program::project::Parts;
use ::program::survey::{counted, rows};
use anyhow::Result;
use manifest::Manifest;
use std::path::PathBuf;

/// The table for a program given as a folder; `None` if only files are given.
///
/// # Errors
/// A file of the program cannot be read.
pub fn table(named: &[PathBuf], manifest: &Manifest) -> Result<Option<String>> {
    if !named.iter().any(|path| path.is_dir()) {
        return Ok(None);
    }
    Ok(describe(named, &parts(manifest)?))
}

/// Like [`table`], for a program that has already been read.
pub fn describe(named: &[PathBuf], parts: &Parts) -> Option<String> {
    if !named.iter().any(|path| path.is_dir()) {
        return None;
    }
    let folder: Vec<String> = named.iter().map(|path| path.display().to_string()).collect();
    let mut lines = vec![format!("{}: {}", folder.join(", "), counted(parts.sources.len(), "source", "sources"))];
    let rows = rows(parts, ": --assume lists them");
    lines.extend(rows.into_iter().map(|(name, text)| format!("  {name:<12}{text}")));
    Some(lines.join("\n") + "\n")
}
