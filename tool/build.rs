//! Puts the loops of `examples/loops` into the engine, as JSON: loops that are known to work.

use serde_json::{Map, Value, json};
use std::path::PathBuf;
use std::{env, fs};
use toml::Table;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let folder = |variable| PathBuf::from(env::var_os(variable).unwrap_or_default());
    let loops = folder("CARGO_MANIFEST_DIR").join("../examples/loops");
    println!("cargo::rerun-if-changed={}", loops.display());
    let mut files = fs::read_dir(&loops)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    files.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    let mut known = Vec::new();
    for file in files {
        known.push(known_loop(&fs::read_to_string(&file)?).map_err(|error| format!("{}: {error}", file.display()))?);
    }
    Ok(fs::write(folder("OUT_DIR").join("loops.json"), Value::Array(known).to_string())?)
}

/// A `KnownLoop` of the messages. How long the loop runs in the file, and what is recorded, does not matter here.
fn known_loop(text: &str) -> Result<Value> {
    let file: Table = text.parse()?;
    let table = |name: &str| file.get(name).and_then(toml::Value::as_table).cloned().unwrap_or_default();
    let mut settings = Map::new();
    flatten("", &table("settings"), &mut settings);
    let mut members = Vec::new();
    for (name, fmu) in table("fmus") {
        let fmu = fmu.as_str().and_then(|file| file.strip_suffix(".fmu")).ok_or("an FMU is NAME = \"FILE.fmu\"")?;
        let prefix = format!("{name}.");
        let own = settings.iter().filter_map(|(key, value)| Some((key.strip_prefix(&prefix)?, value.clone())));
        let values: Map<_, _> = own.map(|(key, value)| (key.to_string(), value)).collect();
        members.push(json!({ "name": name, "fmu": fmu, "values": values }));
    }
    let mut ends = Map::new();
    flatten("", &table("connections"), &mut ends);
    let mut connections = Vec::new();
    for (from, to) in ends {
        match to {
            Value::Array(all) => connections.extend(all.into_iter().map(|to| json!([from, to]))),
            to => connections.push(json!([from, to])),
        }
    }
    let title =
        text.lines().next().and_then(|line| line.strip_prefix("# ")).ok_or("the first line says what it shows")?;
    let mut setup = json!({ "members": members, "connections": connections });
    for name in ["step", "exchange"] {
        if let Some(value) = file.get(name) {
            setup[name] = serde_json::to_value(value)?;
        }
    }
    Ok(json!({ "title": title, "setup": setup }))
}

/// The values of a table and of those inside it, by the keys joined by points.
fn flatten(prefix: &str, table: &Table, to: &mut Map<String, Value>) {
    for (key, value) in table {
        let name = format!("{prefix}{key}");
        match value {
            toml::Value::Table(inner) => flatten(&format!("{name}."), inner, to),
            value => drop(to.insert(name, json!(value))),
        }
    }
}
