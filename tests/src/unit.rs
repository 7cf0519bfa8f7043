//! The FMU libraries of the workspace: built, loaded, and their tables read.

use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::{LazyLock, Mutex, PoisonError};
use xtask::library::Library;
use xtask::workspace::{self, Workspace};

/// A loaded FMU library with what it says of itself.
#[derive(Debug)]
pub struct Unit {
    /// The cargo package.
    pub package: String,
    /// The 34 functions.
    pub library: Library,
    /// The file it was loaded from.
    pub path: PathBuf,
    /// The block's name.
    pub name: String,
    /// What fmi2Instantiate wants to be given.
    pub guid: CString,
    /// The value reference of the time between two calls.
    pub cycle: u32,
    /// The variables, by value reference.
    pub variables: Vec<Variable>,
}

/// One variable, as the library's table has it.
#[derive(Debug)]
pub struct Variable {
    /// Its full name.
    pub name: String,
    /// Its PLC type.
    pub kind: Kind,
    /// Who sets it, and when.
    pub role: Role,
    /// Its start value, as FMI has it.
    pub start: f64,
}

/// A PLC type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the PLC's names
pub enum Kind {
    Real,
    LReal,
    Time,
    Word,
    Int,
    Bool,
}

/// Who sets a variable, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // see `blocks::Role`
pub enum Role {
    Input,
    Parameter,
    Fixed,
    Cycle,
    Output,
    Local,
}

impl Unit {
    /// The value reference of a variable.
    ///
    /// # Panics
    /// There is no such variable.
    pub fn reference(&self, name: &str) -> u32 {
        let place = self.variables.iter().position(|variable| variable.name == name);
        place.unwrap_or_else(|| panic!("{} has no variable {name}", self.name)) as u32
    }
}

static WORKSPACE: LazyLock<Workspace> = LazyLock::new(|| Workspace::find().unwrap_or_else(|error| panic!("{error}")));

/// Loaded libraries by package; they stay to the end of the process.
static LOADED: Mutex<BTreeMap<String, &'static Unit>> = Mutex::new(BTreeMap::new());

/// The library of one FMU package, built as it would be packed.
///
/// # Panics
/// It does not build or load.
pub fn unit(package: &str) -> &'static Unit {
    load(&[package])[0]
}

/// The libraries of all FMU packages of the workspace that are not there for tests only.
///
/// # Panics
/// They do not build or load.
pub fn units() -> Vec<&'static Unit> {
    let packages: Vec<&str> =
        WORKSPACE.units.iter().filter(|unit| !unit.test_only).map(|unit| unit.package.as_str()).collect();
    assert!(!packages.is_empty(), "the workspace has no FMU packages");
    load(&packages)
}

fn load(packages: &[&str]) -> Vec<&'static Unit> {
    // One test may have failed here before the others.
    let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    let missing: Vec<&str> = packages.iter().copied().filter(|package| !loaded.contains_key(*package)).collect();
    if !missing.is_empty() {
        let libraries = build(&missing);
        for package in missing {
            loaded.insert(package.into(), Box::leak(Box::new(open(package, &libraries))));
        }
    }
    packages.iter().map(|package| loaded[*package]).collect()
}

/// The library of a package that is no FMU package, built in the same way.
///
/// # Panics
/// It does not build.
pub fn plain_library(package: &str) -> PathBuf {
    let mut libraries = build(&[package]);
    libraries.remove(package).unwrap_or_else(|| panic!("cargo has built no library of {package}"))
}

/// Builds release libraries; cargo says where they are, by the name of their target. (While cargo runs tests or
/// benchmarks it holds no lock that a second cargo would wait for.)
fn build(packages: &[&str]) -> BTreeMap<String, PathBuf> {
    let mut cargo = workspace::cargo();
    cargo.current_dir(&WORKSPACE.root).args([
        "build",
        "--quiet",
        "--release",
        "--message-format=json-render-diagnostics",
    ]);
    // Those of the package under test are none of the libraries'.
    for (name, _) in std::env::vars_os() {
        if name.to_str().is_some_and(|name| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_")) {
            cargo.env_remove(name);
        }
    }
    for package in packages {
        cargo.args(["--package", package]);
    }
    let output = cargo.stderr(Stdio::inherit()).output().unwrap_or_else(|error| panic!("cargo: {error}"));
    assert!(output.status.success(), "cargo build of {packages:?} ended with {}", output.status);
    String::from_utf8_lossy(&output.stdout).lines().filter_map(artifact).collect()
}

fn artifact(message: &str) -> Option<(String, PathBuf)> {
    let message: Value = serde_json::from_str(message).ok()?;
    let target = &message["target"];
    if message["reason"] != "compiler-artifact" || !target["crate_types"].as_array()?.contains(&"cdylib".into()) {
        return None;
    }
    let suffix = std::env::consts::DLL_SUFFIX;
    let file = message["filenames"].as_array()?.iter().filter_map(Value::as_str).find(|file| file.ends_with(suffix))?;
    Some((target["name"].as_str()?.into(), file.into()))
}

fn open(package: &str, libraries: &BTreeMap<String, PathBuf>) -> Unit {
    let named = WORKSPACE.units.iter().find(|unit| unit.package == package);
    let named = named.unwrap_or_else(|| panic!("the workspace has no FMU package {package}"));
    let path = libraries.get(&named.library).unwrap_or_else(|| panic!("cargo has built no library of {package}"));
    let library = Library::open(path).unwrap_or_else(|error| panic!("{error}"));
    let table = library.interface().unwrap_or_else(|error| panic!("{error}"));
    let table: Value = serde_json::from_str(&table).unwrap_or_else(|error| panic!("{package}: {error}: {table}"));
    read(package, path, library, &table).unwrap_or_else(|| panic!("{package}: this is no table: {table}"))
}

fn read(package: &str, path: &Path, library: Library, table: &Value) -> Option<Unit> {
    let (table, interface) = (&table["table"], &table["interface"]);
    Some(Unit {
        package: package.into(),
        library,
        path: path.to_path_buf(),
        name: table["name"].as_str()?.into(),
        guid: CString::new(interface["guid"].as_str()?).ok()?,
        cycle: table["cycle"].as_u64()?.try_into().ok()?,
        variables: table["variables"].as_array()?.iter().map(variable).collect::<Option<_>>()?,
    })
}

fn variable(row: &Value) -> Option<Variable> {
    Some(Variable {
        name: row["name"].as_str()?.into(),
        kind: match row["kind"].as_str()? {
            "REAL" => Kind::Real,
            "LREAL" => Kind::LReal,
            "TIME" => Kind::Time,
            "WORD" => Kind::Word,
            "INT" => Kind::Int,
            "BOOL" => Kind::Bool,
            _ => return None,
        },
        role: match row["role"].as_str()? {
            "input" => Role::Input,
            "parameter" => Role::Parameter,
            "fixed" => Role::Fixed,
            "cycle" => Role::Cycle,
            "output" => Role::Output,
            "local" => Role::Local,
            _ => return None,
        },
        start: row["start"].as_f64()?,
    })
}
