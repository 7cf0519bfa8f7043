//! Writes a system as the text of a TOML file.

use crate::system::{Exchange, Setting, System, Value};
use anyhow::{Context, Result};
use manifest::Manifest;
use std::collections::BTreeMap;
use std::fmt::{self, Write};
use std::fs;
use std::path::Path;
use toml_writer::TomlWrite;

/// Writes a system as TOML, with paths unchanged. Values from parameter files become settings; if a variable has
/// several settings at the same time, the last one counts.
///
/// # Errors
/// A path is not valid Unicode.
pub fn write(system: &System) -> Result<String> {
    let mut text = String::new();
    for (name, seconds) in [("start", system.start), ("stop", system.stop), ("step", system.step)] {
        if let Some(seconds) = seconds {
            entry(&mut text, name, |text| text.value(seconds))?;
        }
    }
    if system.exchange == Exchange::Parallel {
        entry(&mut text, "exchange", |text| text.value("parallel"))?;
    }
    if system.no_events {
        entry(&mut text, "event_mode", |text| text.value(false))?;
    }
    if !system.record.is_empty() {
        let names: Vec<&str> = system.record.iter().map(|of| of.variable.as_str()).collect();
        entry(&mut text, "record", |text| text.value(names))?;
    }
    text.write_str("\n[fmus]\n")?;
    let unicode = |path: &'_ Path| {
        path.to_str().map(str::to_string).with_context(|| format!("{} is not valid Unicode: rename it", path.display()))
    };
    for member in &system.members {
        match system.programs.get(&member.name) {
            None => {
                let path = unicode(&member.path)?;
                entry(&mut text, &member.name, |text| text.value(path))?;
            }
            Some(program) => {
                program.sources.iter().try_for_each(|path| unicode(path).map(drop))?;
                self::program(&mut text, &member.name, program)?;
            }
        }
    }
    if !system.connections.is_empty() {
        text.write_str("\n[connections]\n")?;
        let mut inputs: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for connection in &system.connections {
            inputs.entry(&connection.from).or_default().push(&connection.to);
        }
        for (from, to) in inputs {
            entry(&mut text, from, |text| match to[..] {
                [to] => text.value(to),
                _ => text.value(to),
            })?;
        }
    }
    settings(&mut text, system)?;
    Ok(text)
}

/// Writes `NAME.sources = [...]`, and a line for each additional key of the manifest.
fn program(text: &mut String, name: &str, manifest: &Manifest) -> Result<()> {
    for (key, value) in toml::Table::try_from(manifest)? {
        text.key(name)?;
        text.write_str(".")?;
        entry(text, &key, |text| write!(text, "{value}"))?;
    }
    Ok(())
}

/// Writes the settings at the start, and the events in order of time.
fn settings(text: &mut String, system: &System) -> fmt::Result {
    let firm = |variable: &str| system.settings.iter().any(|of| !of.is_preliminary && of.variable == variable);
    let connected = |variable: &str| system.connections.iter().any(|of| of.to == variable);
    let (start, mut events): (Vec<&Setting>, Vec<&Setting>) = system.settings.iter().partition(|of| of.time.is_none());
    let start = start.into_iter().filter(|of| !of.is_preliminary || !(firm(&of.variable) || connected(&of.variable)));
    text.write_str("\n[settings]\n")?;
    set(text, "", start)?;
    let time = |of: &Setting| of.time.unwrap_or_default();
    events.sort_by(|one, other| time(one).total_cmp(&time(other)));
    for event in events.chunk_by(|one, other| time(one) == time(other)) {
        text.write_str("\n[[events]]\n")?;
        entry(text, "time", |text| text.value(time(event[0])))?;
        set(text, "set.", event.iter().copied())?;
    }
    Ok(())
}

/// Writes a line for each variable, with its last value.
fn set<'a>(text: &mut String, prefix: &str, settings: impl Iterator<Item = &'a Setting>) -> fmt::Result {
    let mut values: Vec<(&str, Value)> = Vec::new();
    for of in settings {
        match values.iter_mut().find(|(variable, _)| *variable == of.variable) {
            Some((_, value)) => *value = of.value,
            None => values.push((&of.variable, of.value)),
        }
    }
    for (variable, value) in values {
        text.write_str(prefix)?;
        entry(text, variable, |text| match value {
            Value::Boolean(value) => text.value(value),
            // TOML's integers are signed 64-bit numbers.
            Value::Whole(value) => match i64::try_from(value) {
                Ok(value) => text.value(value),
                Err(_) => text.value(value.to_string()),
            },
            Value::Number(value) => text.value(value),
        })?;
    }
    Ok(())
}

/// Writes a line `key = value`.
fn entry(text: &mut String, key: &str, value: impl FnOnce(&mut String) -> fmt::Result) -> fmt::Result {
    text.key(key)?;
    text.write_str(" = ")?;
    value(text)?;
    text.newline()
}

impl System {
    /// The system with the paths of its FMUs and programs as written in a file in `folder`: relative if they are inside
    /// the folder, otherwise absolute.
    pub fn as_in(&self, folder: &Path) -> System {
        let absolute = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let relative = |path: &Path| {
            let path = absolute(path);
            path.strip_prefix(absolute(folder)).map(Path::to_path_buf).unwrap_or(path)
        };
        let mut system = self.clone();
        let members = system.members.iter_mut().map(|member| &mut member.path);
        let sources = system.programs.values_mut().flat_map(|program| &mut program.sources);
        members.chain(sources).for_each(|path| *path = relative(path));
        system
    }
}
