//! The FMU libraries that the tests call: built or handed in, loaded, and their tables read. That of programs
//! stands for several: one for each program of the tests.

use blocks::{Row, Text};
use host::library::Library;
use manifest::{FILE, Manifest};
use modeldescription::Interface;
use parameters::Source;
use plcfmu::build::compile::{Linkage, compile};
use plcfmu::build::platform::Platform;
use plcfmu::build::workspace::{FmuCrate, Workspace};
use program::Loaded;
use std::collections::{BTreeMap, BTreeSet};
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::ffi::{CString, c_char};
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::{LazyLock, Mutex, PoisonError};

/// A loaded FMU library with what it says of itself.
#[derive(Debug)]
pub struct Fmu {
    /// The cargo package, or the file name without extension of a library that was handed in.
    pub package: String,
    /// The 34 functions.
    pub library: Library,
    /// The file it was loaded from.
    pub path: PathBuf,
    /// The block's name.
    pub name: String,
    /// What fmi2Instantiate wants to be given.
    pub guid: CString,
    /// The folder of the resources, where the library needs them: it is that of programs.
    pub resources: Option<CString>,
    /// The value reference of the time between two calls.
    pub cycle: u32,
    /// The variables, by value reference.
    pub variables: Vec<Row>,
    /// The texts of a program, whose value references follow.
    pub texts: Vec<Text>,
}

impl Fmu {
    /// The value reference of a variable.
    ///
    /// # Panics
    /// There is no such variable.
    pub fn reference(&self, name: &str) -> u32 {
        let place = self.variables.iter().position(|variable| variable.name == name);
        place.unwrap_or_else(|| panic!("{} has no variable {name}", self.name)) as u32
    }

    /// The resources as fmi2Instantiate takes them.
    pub fn location(&self) -> *const c_char {
        self.resources.as_ref().map_or(ptr::null(), |folder| folder.as_ptr())
    }
}

/// The folder of libraries that are built already, for machines without cargo: `PLCFMU_LIBRARIES`.
static PREBUILT: LazyLock<Option<PathBuf>> = LazyLock::new(|| std::env::var_os("PLCFMU_LIBRARIES").map(PathBuf::from));

/// The packages in `tests/fmus`. Cargo knows them by `test-only` in their `Cargo.toml`; a folder of libraries does not.
const TEST_ONLY: [&str; 2] = ["counter", "panicking"];

/// The package of the program library.
const PROGRAMS: &str = "program_library";

/// Programs with variables of every type, which run without a stop whatever they are given.
const PROGRAM_SOURCES: [(&str, &str); 3] = [
    ("kinds", include_str!("../programs/kinds.scl")),
    ("label", include_str!("../programs/label.scl")),
    ("mixer", include_str!("../programs/mixer.scl")),
];

static WORKSPACE: LazyLock<Workspace> = LazyLock::new(|| Workspace::find().unwrap_or_else(|error| panic!("{error:#}")));

/// Loaded libraries by package; they stay to the end of the process.
static LOADED: Mutex<BTreeMap<String, &'static Fmu>> = Mutex::new(BTreeMap::new());

/// The library of one FMU package.
///
/// # Panics
/// It does not build or load.
pub fn fmu_of(package: &str) -> &'static Fmu {
    load(&[package.into()])[0]
}

/// The libraries of all FMU packages of the workspace but those in `tests/fmus`, and that of programs with each of the programs in
/// `tests/programs`. If `PLCFMU_LIBRARIES` names a folder, those of the libraries in there, and no cargo is called.
///
/// # Panics
/// They do not build or load.
pub fn all_fmus() -> Vec<&'static Fmu> {
    let packages: Vec<String> = match &*PREBUILT {
        Some(folder) => {
            let all = prebuilt(folder).into_keys();
            all.filter(|package| !TEST_ONLY.contains(&package.as_str())).collect()
        }
        None => {
            let blocks = WORKSPACE.crates.iter().filter(|fmu| !fmu.test_only);
            blocks.chain(&WORKSPACE.programs).map(|fmu| fmu.name.clone()).collect()
        }
    };
    assert!(!packages.is_empty(), "there are no FMUs: the workspace, or the folder PLCFMU_LIBRARIES, has none");
    let (programs, blocks): (Vec<_>, Vec<_>) = packages.into_iter().partition(|package| package == PROGRAMS);
    let of_tests = PROGRAM_SOURCES.iter().filter(|_| !programs.is_empty()).map(|(name, _)| (*name).to_string());
    load(&blocks.into_iter().chain(of_tests).collect::<Vec<_>>())
}

fn load(packages: &[String]) -> Vec<&'static Fmu> {
    // One test may have failed here before the others.
    let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    let missing: Vec<&String> = packages.iter().filter(|package| !loaded.contains_key(*package)).collect();
    if !missing.is_empty() {
        let libraries = match &*PREBUILT {
            Some(folder) => prebuilt(folder),
            None => built(&missing.iter().map(|package| library_of(package)).collect()),
        };
        for package in missing {
            let library = libraries.get(library_of(package));
            let path = library.unwrap_or_else(|| panic!("there is no library of {package} in PLCFMU_LIBRARIES"));
            loaded.insert(package.clone(), Box::leak(Box::new(open(package, path))));
        }
    }
    packages.iter().map(|package| loaded[package]).collect()
}

/// The libraries in a folder by package: `libcont_c.so`, `cont_c.so` or `cont_c.dll` is that of `cont_c`.
fn prebuilt(folder: &Path) -> BTreeMap<String, PathBuf> {
    let files = std::fs::read_dir(folder)
        .unwrap_or_else(|error| panic!("PLCFMU_LIBRARIES: {} cannot be read: {error}", folder.display()));
    files
        .map(|file| file.unwrap_or_else(|error| panic!("PLCFMU_LIBRARIES: {error:#}")).path())
        .filter_map(|path| {
            let name = path.file_name()?.to_str()?.strip_suffix(DLL_SUFFIX)?;
            Some((name.strip_prefix(DLL_PREFIX).unwrap_or(name).to_string(), path))
        })
        .collect()
}

/// The package that the library of an FMU is built from: a program has that of all programs.
fn library_of(package: &str) -> &str {
    if PROGRAM_SOURCES.iter().any(|(name, _)| *name == package) { PROGRAMS } else { package }
}

fn built(packages: &BTreeSet<&str>) -> BTreeMap<String, PathBuf> {
    let fmu_crate = |package: &&str| -> FmuCrate {
        let found = WORKSPACE.crates.iter().chain(&WORKSPACE.programs).find(|fmu| fmu.name == **package);
        found.unwrap_or_else(|| panic!("the workspace has no FMU package {package}")).clone()
    };
    build(&packages.iter().map(fmu_crate).collect::<Vec<_>>())
}

/// Builds release libraries for this machine, in a folder of their own: cargo holds no lock there while it runs tests.
fn build(crates: &[FmuCrate]) -> BTreeMap<String, PathBuf> {
    let built = Platform::host(&WORKSPACE.root).and_then(|host| compile(&WORKSPACE, crates, &host, &Linkage::Native));
    built.unwrap_or_else(|error| panic!("{error:#}"))
}

/// The library of a package that is not an FMU, for example the reference of a benchmark.
///
/// # Panics
/// It does not build.
pub fn plain_library(package: &str) -> PathBuf {
    if let Some(folder) = &*PREBUILT {
        let library = prebuilt(folder).remove(package);
        return library.unwrap_or_else(|| panic!("there is no library of {package} in PLCFMU_LIBRARIES"));
    }
    let plain = FmuCrate { name: package.into(), library: package.into(), test_only: true, ..FmuCrate::default() };
    build(&[plain]).remove(package).unwrap_or_else(|| panic!("cargo has built no library of {package}"))
}

fn open(package: &str, path: &Path) -> Fmu {
    let library = Library::open(path).unwrap_or_else(|error| panic!("{error:#}"));
    let (json, resources) = match PROGRAM_SOURCES.iter().find(|(name, _)| *name == package) {
        Some((name, text)) => {
            let folder = path.with_file_name("programs").join(name);
            let told =
                unpack(&format!("{name}.scl"), text, &folder).unwrap_or_else(|error| panic!("{package}: {error}"));
            (Ok(told), CString::new(folder.display().to_string()).ok())
        }
        None => (library.interface(), None),
    };
    let json = json.unwrap_or_else(|error| panic!("{package}: {error:#}"));
    let interface = Interface::parse(&json).unwrap_or_else(|error| panic!("{package}: {error:#}"));
    Fmu {
        package: package.into(),
        library,
        path: path.to_path_buf(),
        name: interface.table.name,
        guid: CString::new(interface.guid).unwrap_or_else(|error| panic!("{package}: {error:#}")),
        resources,
        cycle: interface.table.cycle as u32,
        variables: interface.table.rows,
        texts: interface.table.texts,
    }
}

/// Writes the resources of a program's FMU into a folder, and gives what the FMU tells of itself.
fn unpack(file: &str, text: &str, folder: &Path) -> std::io::Result<String> {
    let manifest = Manifest { cycle: Some(100), sources: vec![file.into()], ..Manifest::default() };
    let loaded = Loaded::new(&manifest, &[Source::new(file, text.into())], |_| false).map_err(std::io::Error::other)?;
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join(FILE), manifest.to_string())?;
    std::fs::write(folder.join(file), text)?;
    Ok(fmu::describe(&loaded.table, &loaded.guid()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_only_fmus_are_those_that_cargo_knows() {
        let known: Vec<&str> =
            WORKSPACE.crates.iter().filter(|fmu| fmu.test_only).map(|fmu| fmu.name.as_str()).collect();
        assert_eq!(known, TEST_ONLY);
    }

    #[test]
    fn a_library_in_a_folder_is_known_by_its_name_without_what_the_system_adds() {
        let folder = tempfile::tempdir().unwrap();
        for file in [format!("{DLL_PREFIX}pump{DLL_SUFFIX}"), format!("fan{DLL_SUFFIX}"), "pump.txt".into()] {
            std::fs::write(folder.path().join(file), "").unwrap();
        }
        assert_eq!(prebuilt(folder.path()).into_keys().collect::<Vec<_>>(), ["fan", "pump"]);
    }
}
