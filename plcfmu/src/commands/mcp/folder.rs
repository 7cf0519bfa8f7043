//! The folder to which a client is confined. No path may lead out of it, whether it is absolute, contains `..`, follows
//! a link, or is named in a description of a loop or of tests.

use crate::{parameter_file, program};
use anyhow::{Context, Result, ensure};
use parameters::Source;
use serde_json::Value;
use std::env;
use std::path::{Component, Path, PathBuf};

/// A folder, without links in its path.
#[derive(Clone, Debug)]
pub(super) struct Folder(PathBuf);

impl Folder {
    /// The current folder.
    ///
    /// # Errors
    /// The folder no longer exists.
    pub(super) fn current() -> Result<Folder> {
        let folder = env::current_dir().and_then(|folder| folder.canonicalize());
        folder.map(Folder).context("the current folder cannot be read")
    }

    /// Rejects a string in a request that, read as a path, leads out of the folder. Any string is assumed to be a path.
    pub(super) fn ensure_inside(&self, text: &str) -> Result<()> {
        self.ensure_within(Path::new(""), text)
    }

    /// Rejects a description of a loop or of tests, or a folder with such files, that names a path outside.
    ///
    /// # Errors
    /// A file names a path outside.
    pub(super) fn ensure_descriptions_inside(&self, text: &str) -> Result<()> {
        for path in paths(text).map(Path::new) {
            let files = if path.is_dir() { program::test_files(path).unwrap_or_default() } else { vec![path.into()] };
            for file in files.iter().filter(|file| file.is_file()) {
                // A file that cannot be read, or is not a description, names no other files.
                let Ok(source) = Source::read(file, None) else { continue };
                let content = toml::from_str::<Value>(&source.text).unwrap_or_default();
                let beside = file.parent().unwrap_or(Path::new(""));
                let inside = texts(&content).into_iter().try_for_each(|text| self.ensure_within(beside, text));
                inside.with_context(|| format!("{} cannot be used", file.display()))?;
            }
        }
        Ok(())
    }

    fn ensure_within(&self, beside: &Path, text: &str) -> Result<()> {
        ensure!(
            !parameter_file::is_plc(text),
            "{text} is the address of a PLC: specify a file in {}",
            self.0.display()
        );
        for path in paths(text) {
            let is_inside = self.leads_inside(&self.0.join(beside).join(path));
            ensure!(is_inside, "{path} is outside {}, where plcfmu was started", self.0.display());
        }
        Ok(())
    }

    /// Whether a path stays in the folder after following links; a path that does not exist yet is judged by its
    /// nearest existing parent.
    fn leads_inside(&self, path: &Path) -> bool {
        let Some(there) = path.ancestors().find(|part| part.symlink_metadata().is_ok()) else { return false };
        let is_up = |part| part == Component::ParentDir;
        let is_new = path.strip_prefix(there).is_ok_and(|rest| !rest.components().any(is_up));
        // A dangling link is rejected.
        is_new && there.canonicalize().is_ok_and(|real| real.starts_with(&self.0))
    }
}

/// The possible paths in a string: the string itself, and the part after `NAME=`.
fn paths(text: &str) -> impl Iterator<Item = &str> {
    [text].into_iter().chain(text.split_once('=').map(|(_, path)| path))
}

/// All strings in a value.
fn texts(value: &Value) -> Vec<&str> {
    match value {
        Value::String(text) => vec![text],
        Value::Array(values) => values.iter().flat_map(texts).collect(),
        Value::Object(entries) => entries.values().flat_map(texts).collect(),
        _ => Vec::new(),
    }
}
