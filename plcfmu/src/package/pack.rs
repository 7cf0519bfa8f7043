//! `cargo xtask fmu`: builds the libraries of the workspace's FMUs, reads each one's table out of it, and packs it.

use crate::build::compile::{Platform, compile};
use crate::build::workspace::{FmuCrate, Workspace};
use crate::host::library::Library;
use crate::package::DESCRIPTION;
use crate::package::archive;
use crate::package::check;
use crate::package::reference;
use crate::package::temporary;
use crate::page;
use crate::page::diagram;
use crate::page::picture;
use crate::progress::Progress;
use modeldescription::{Interface, ModelDescription};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What to pack, and how.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// Blocks to pack, such as CONT_C (capitals do not matter); all of the workspace's if none is named
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
    /// Packages to pack; also those that are for tests only
    #[arg(short, long = "package", value_name = "PACKAGE")]
    pub packages: Vec<String>,
    /// Link against this machine's C library (needs no Python); such an FMU may not run on an older Linux
    #[arg(long)]
    pub native: bool,
}

/// What a user has to be told about the library's licences.
const LICENCES: [(&str, &str); 4] = [
    ("LICENSE-MIT", include_str!("../../../LICENSE-MIT")),
    ("LICENSE-APACHE", include_str!("../../../LICENSE-APACHE")),
    ("LICENSE-UNICODE", include_str!("../../LICENSE-UNICODE")),
    ("NOTICE", include_str!("../../NOTICE")),
];

/// Packs FMUs.
///
/// # Errors
/// What is wrong and what to do; FMUs that were packed before stay as they are.
pub fn run(workspace: &Workspace, options: &Options) -> Result<(), String> {
    let platform = Platform::host(options.native)?;
    let selection = Selection::of(workspace, options)?;
    let _lock = begin(&workspace.fmus())?;
    let libraries = compile(workspace, &selection.crates, &platform)?;
    let mut tables = Vec::new();
    for fmu_crate in &selection.crates {
        let library = &libraries[&fmu_crate.name];
        tables.push((fmu_crate, library, table(fmu_crate, library)?));
    }
    let chosen = selection.chosen(tables)?;
    let progress = Progress::bar(chosen.len());
    for (fmu_crate, library, interface) in chosen {
        progress.begin(&interface.name);
        let folder = workspace.fmus().join(if fmu_crate.test_only { "test-only" } else { "" });
        let path = folder.join(format!("{}.fmu", interface.name));
        let size = pack(fmu_crate, &interface, library, &platform, &path)
            .map_err(|error| format!("{} (package {}): {error}", interface.name, fmu_crate.name))?;
        progress.line(&format!(
            "{:<10} {}  {:>4} kB  {}  {}",
            interface.name,
            platform.shown(),
            size.div_ceil(1000),
            interface.guid,
            workspace.shown(&path)
        ));
        progress.done();
    }
    Ok(())
}

/// What is asked for.
#[derive(Debug)]
struct Selection {
    /// The packages to build.
    crates: Vec<FmuCrate>,
    /// Those that were named by `-p`.
    packages: Vec<String>,
    /// Those that were named otherwise, by block or package; none means all.
    names: Vec<String>,
}

impl Selection {
    fn of(workspace: &Workspace, options: &Options) -> Result<Selection, String> {
        let known: Vec<&str> = workspace.crates.iter().map(|fmu_crate| fmu_crate.name.as_str()).collect();
        if let Some(unknown) = options.packages.iter().find(|package| !known.contains(&package.as_str())) {
            return Err(format!(
                "{unknown} is no FMU package of this workspace: an FMU is a cdylib that depends on fmu; there are {}",
                known.join(", ")
            ));
        }
        let asked = |fmu_crate: &FmuCrate| options.packages.contains(&fmu_crate.name);
        let named =
            |fmu_crate: &FmuCrate| !fmu_crate.test_only && options.names.iter().any(|name| same(name, &fmu_crate.name));
        let all_are_packages = options
            .names
            .iter()
            .all(|name| workspace.crates.iter().any(|fmu_crate| !fmu_crate.test_only && same(name, &fmu_crate.name)));
        let crates: Vec<FmuCrate> = if options.names.is_empty() && options.packages.is_empty() {
            workspace.crates.iter().filter(|fmu_crate| !fmu_crate.test_only).cloned().collect()
        } else if all_are_packages {
            workspace.crates.iter().filter(|fmu_crate| asked(fmu_crate) || named(fmu_crate)).cloned().collect()
        } else {
            // Only the libraries know the names of their blocks.
            workspace.crates.iter().filter(|fmu_crate| asked(fmu_crate) || !fmu_crate.test_only).cloned().collect()
        };
        if crates.is_empty() {
            return Err("this workspace has no FMU: an FMU is a package with a cdylib that depends on fmu".into());
        }
        Ok(Selection { crates, packages: options.packages.clone(), names: options.names.clone() })
    }

    /// Those of the tables that are asked for.
    fn chosen<'a>(&self, tables: Vec<Table<'a>>) -> Result<Vec<Table<'a>>, String> {
        let is =
            |name: &str, (fmu_crate, _, interface): &Table| same(name, &fmu_crate.name) || same(name, &interface.name);
        if let Some(unknown) = self.names.iter().find(|name| !tables.iter().any(|table| is(name, table))) {
            let known: Vec<_> = tables.iter().map(|(_, _, interface)| interface.name.as_str()).collect();
            return Err(format!("there is no FMU {unknown}: there are {}", known.join(", ")));
        }
        let all = self.names.is_empty() && self.packages.is_empty();
        let asked = |table: &Table| {
            all || self.packages.contains(&table.0.name) || self.names.iter().any(|name| is(name, table))
        };
        let mut chosen: Vec<Table> = tables.into_iter().filter(asked).collect();
        chosen.sort_by(|(.., a), (.., b)| a.name.cmp(&b.name));
        for (place, (fmu_crate, _, interface)) in chosen.iter().enumerate() {
            if let Some((other, ..)) = chosen[..place].iter().find(|(_, _, other)| same(&other.name, &interface.name)) {
                return Err(format!(
                    "the packages {} and {} both make {}.fmu: give one of the blocks another name",
                    other.name, fmu_crate.name, interface.name
                ));
            }
        }
        Ok(chosen)
    }
}

/// A package, its library and the table in it.
type Table<'a> = (&'a FmuCrate, &'a PathBuf, Interface);

/// Whether two names are one: capitals do not matter, nor does what stands between words.
fn same(a: &str, b: &str) -> bool {
    a.replace('-', "_").eq_ignore_ascii_case(&b.replace('-', "_"))
}

fn table(fmu_crate: &FmuCrate, library: &Path) -> Result<Interface, String> {
    let interface = Library::open(library).and_then(|library| library.interface());
    let interface = interface.and_then(|json| Ok(Interface::parse(&json)?));
    interface.map_err(|error| format!("package {}: {error:#}", fmu_crate.name))
}

/// Makes the folder, waits for another packer, and removes what an interrupted one has left.
fn begin(folder: &Path) -> Result<File, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    fs::create_dir_all(folder.join("test-only")).map_err(failed)?;
    let lock = File::create(folder.join(".lock")).map_err(failed)?;
    if lock.try_lock().is_err() {
        eprintln!("waiting for another 'cargo xtask' that packs FMUs ...");
        lock.lock().map_err(failed)?;
    }
    temporary::remove_left(folder).and_then(|()| temporary::remove_left(&folder.join("test-only"))).map_err(failed)?;
    Ok(lock)
}

/// Packs one FMU and says how large it is.
fn pack(
    fmu_crate: &FmuCrate,
    interface: &Interface,
    library: &Path,
    platform: &Platform,
    path: &Path,
) -> Result<usize, String> {
    let mut description = ModelDescription::of(interface).map_err(|error| error.to_string())?;
    description.license = fmu_crate.license.clone();
    let bytes =
        archive::write(&files(interface, &description, library, platform)?).map_err(|error| format!("{error:#}"))?;
    place(&bytes, path, |packed| check::packed(packed, &description, platform).map_err(|error| format!("{error:#}")))?;
    Ok(bytes.len())
}

/// Writes a file beside its place, checks it there, and gives it its name: at every moment there is the old file or the
/// new one.
fn place(bytes: &[u8], path: &Path, check: impl FnOnce(&Path) -> Result<(), String>) -> Result<(), String> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let failed = |error: std::io::Error| format!("{} cannot be written: {error}", path.display());
    let mut builder = temporary::builder();
    // As other files: the temporary ones of this crate are their owner's alone.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut temporary = builder.tempfile_in(folder).map_err(failed)?;
    temporary.write_all(bytes).map_err(failed)?;
    // On the disk before it gets its name.
    temporary.as_file().sync_all().map_err(failed)?;
    check(temporary.path())?;
    temporary.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// Everything that is in an FMU, by its path there.
fn files(
    interface: &Interface,
    description: &ModelDescription,
    library: &Path,
    platform: &Platform,
) -> Result<BTreeMap<String, Vec<u8>>, String> {
    let name = &interface.name;
    let mut files = BTreeMap::new();
    files.insert(DESCRIPTION.to_string(), modeldescription::write(description));
    let content = fs::read(library).map_err(|error| format!("{} cannot be read: {error}", library.display()))?;
    files.insert(format!("binaries/{}/{name}.{}", platform.folder, platform.extension), content);
    let recording = reference::run(library, interface).map_err(|error| format!("{error:#}"))?;
    files.extend(reference::files(interface, &recording));
    let page =
        page::html(interface, &recording, description.license.as_deref()).map_err(|error| format!("{error:#}"))?;
    files.insert("documentation/index.html".into(), page.into_bytes());
    for (licence, text) in LICENCES {
        files.insert(format!("documentation/licenses/{licence}"), text.into());
    }
    let picture = diagram::svg(interface).and_then(|svg| picture::png(&svg)).map_err(|error| format!("{error:#}"))?;
    files.insert("model.png".into(), picture);
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fmu_crate(package: &str, test_only: bool) -> FmuCrate {
        FmuCrate { name: package.into(), library: package.into(), license: None, test_only }
    }

    fn workspace() -> Workspace {
        let crates = vec![fmu_crate("boom", true), fmu_crate("my-pump", false), fmu_crate("valve", false)];
        Workspace { root: "/w".into(), target: "/w/target".into(), crates }
    }

    fn select(names: &[&str], packages: &[&str]) -> Result<Selection, String> {
        let text = |words: &[&str]| words.iter().map(|word| word.to_string()).collect();
        Selection::of(&workspace(), &Options { names: text(names), packages: text(packages), native: false })
    }

    fn built(names: &[&str], packages: &[&str]) -> Vec<String> {
        select(names, packages).unwrap().crates.into_iter().map(|fmu_crate| fmu_crate.name).collect()
    }

    fn interface(name: &str) -> Interface {
        let json = format!(
            r#"{{"name":"{name}","docs":"x","guid":"{{1}}","cycle":0,"variables":[{{"name":"CYCLE","description":"x",
            "kind":"Time","role":"Cycle","start":1.0,"min":0.001,"max":null,"fmu_crate":null}}],
            "response":{{"title":"x","calls":3,"set":[],"show":[]}}}}"#
        );
        Interface::parse(&json).unwrap()
    }

    /// The blocks that are packed, where the packages my-pump, valve and boom hold PUMP, VALVE and BOOM.
    fn chosen(names: &[&str], packages: &[&str]) -> Result<Vec<String>, String> {
        let selection = select(names, packages)?;
        let library = PathBuf::new();
        let block = |fmu_crate: &FmuCrate| fmu_crate.name.trim_start_matches("my-").to_uppercase();
        let tables =
            selection.crates.iter().map(|fmu_crate| (fmu_crate, &library, interface(&block(fmu_crate)))).collect();
        Ok(selection.chosen(tables)?.into_iter().map(|(.., interface)| interface.name).collect())
    }

    #[test]
    fn all_fmus_are_packed_but_those_for_tests() {
        assert_eq!(built(&[], &[]), ["my-pump", "valve"]);
        assert_eq!(chosen(&[], &[]).unwrap(), ["PUMP", "VALVE"]);
    }

    #[test]
    fn a_package_is_named_exactly_and_may_be_for_tests() {
        assert_eq!(built(&[], &["boom"]), ["boom"]);
        assert_eq!(chosen(&[], &["boom"]).unwrap(), ["BOOM"]);
        assert_eq!(
            select(&[], &["bom"]).unwrap_err(),
            "bom is no FMU package of this workspace: an FMU is a cdylib that depends on fmu; there are boom, my-pump, \
             valve"
        );
    }

    #[test]
    fn a_block_is_named_by_its_name_or_its_package_in_any_case() {
        assert_eq!(built(&["VALVE"], &[]), ["valve"]);
        assert_eq!(built(&["My_Pump"], &[]), ["my-pump"]);
        // The name of a block is only known once all are built.
        assert_eq!(built(&["pump"], &[]), ["my-pump", "valve"]);
        assert_eq!(chosen(&["pump"], &[]).unwrap(), ["PUMP"]);
        assert_eq!(chosen(&["pump"], &["boom"]).unwrap(), ["BOOM", "PUMP"]);
        assert_eq!(chosen(&["valve", "pump"], &[]).unwrap(), ["PUMP", "VALVE"]);
    }

    #[test]
    fn an_unknown_block_is_refused_with_those_that_there_are() {
        assert_eq!(chosen(&["PUMPS"], &[]).unwrap_err(), "there is no FMU PUMPS: there are PUMP, VALVE");
        assert_eq!(chosen(&["boom"], &[]).unwrap_err(), "there is no FMU boom: there are PUMP, VALVE");
    }

    #[test]
    fn two_packages_cannot_make_one_fmu() {
        let selection = select(&[], &[]).unwrap();
        let library = PathBuf::new();
        let tables = selection.crates.iter().map(|fmu_crate| (fmu_crate, &library, interface("PUMP"))).collect();
        assert_eq!(
            selection.chosen(tables).unwrap_err(),
            "the packages my-pump and valve both make PUMP.fmu: give one of the blocks another name"
        );
    }

    #[test]
    fn a_file_that_fails_its_check_leaves_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("PUMP.fmu");
        place(b"old", &path, |_| Ok(())).unwrap();
        let error = place(b"new", &path, |beside| {
            assert_eq!(fs::read(beside).unwrap(), b"new");
            assert_eq!(fs::read(&path).unwrap(), b"old");
            Err("it does not load".into())
        });
        assert_eq!(error.unwrap_err(), "it does not load");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        place(b"new", &path, |_| Ok(())).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_an_interrupted_packer_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        drop(begin(folder.path()).unwrap());
        for name in [".plcfmu-1a2b.tmp", "test-only/.plcfmu-x.tmp", "PUMP.fmu", "notes.tmp"] {
            fs::write(folder.path().join(name), "x").unwrap();
        }
        fs::create_dir_all(folder.path().join(".plcfmu-3c.tmp/binaries/linux64")).unwrap();
        let _lock = begin(folder.path()).unwrap();
        let names = |folder: &Path| -> Vec<String> {
            let entries = fs::read_dir(folder).unwrap();
            let mut names: Vec<String> =
                entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        };
        assert_eq!(names(folder.path()), [".lock", "PUMP.fmu", "notes.tmp", "test-only"]);
        assert_eq!(names(&folder.path().join("test-only")), [""; 0]);
    }
}
