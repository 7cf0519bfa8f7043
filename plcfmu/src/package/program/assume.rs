//! Assumptions about undeclared names: a separate source that a user may edit.

use crate::program::{self, Parts};
use crate::tell;
use anyhow::{Context, Result, ensure};
use manifest::Manifest;
use parameters::Source;
use scl::Assumption;
use std::fs;
use std::path::Path;

/// The beginning of a new assumption file.
const HEAD: &str = "// Assumptions of plcfmu about names that no source declares. Correct them, and pass this file again with --assume.\n\
    // A variable that is only read is an input of the FMU, any other an output; AT %I*, %Q* or %M* overrides this.\n\
    // Nothing here is a statement on safety: only the interface of a safety block is used.\n\n";

/// Adds the assumption file to the sources of a program, the missing declarations to the file, and a cycle to the
/// manifest. Prints each new assumption.
///
/// # Errors
/// A program file cannot be read; the assumption file is one of its sources, or cannot be written.
pub(super) fn complete(manifest: &mut Manifest, file: &Path) -> Result<()> {
    if file.is_file() && !program::has_source(manifest, file)? {
        manifest.sources.push(file.to_path_buf());
    }
    let Parts { sources, manifest: of, .. } = program::parts(manifest)?;
    if manifest.cycle.is_none() {
        let (cycle, why) = scl::watch::proposed_cycle(&scl::watch::watched(&sources));
        tell::text(&format!("assumed: the program is called every {cycle} ms: {why}"));
        manifest.cycle = Some(cycle);
    }
    let assumptions = scl::assume(&sources, &of, None);
    if assumptions.is_empty() {
        return Ok(());
    }
    let before = if file.is_file() { fs::read_to_string(file) } else { Ok(HEAD.to_string()) };
    let before = before.with_context(|| format!("{} cannot be read", file.display()))?;
    // Stubs are code, too: a file that contains code is an assumption file only if it begins as one.
    let is_program = program::has_code(file) && !before.contains(HEAD.lines().next().unwrap_or_default());
    ensure!(!is_program, "{} is a source of the program: choose another file for --assume", file.display());
    for assumption in &assumptions {
        tell::text(&line(assumption, &sources));
    }
    fs::write(file, before + &scl::assumed(&assumptions))
        .with_context(|| format!("{} cannot be written", file.display()))?;
    let (count, shown) = (assumptions.len(), file.display());
    let are = if count == 1 { "assumption is" } else { "assumptions are" };
    tell::note(&format!("{count} {are} in {shown}: correct any that are wrong, and pass --assume {shown} again"));
    if !program::has_source(manifest, file)? {
        manifest.sources.push(file.to_path_buf());
    }
    Ok(())
}

/// An assumption on one line, with the location of its first use.
fn line(assumption: &Assumption, sources: &[Source]) -> String {
    let (file, at) = assumption.at;
    let place = sources.get(file as usize).map_or_else(String::new, |source| {
        let at = at as usize;
        format!("{}:{}: ", source.file, source.place(at..at).line)
    });
    format!("{place}assumed: \"{}\" is {}", assumption.name, assumption.what)
}
