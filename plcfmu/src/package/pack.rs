//! Packs FMUs for `plcfmu build` and `cargo xtask fmu`: builds the libraries of a workspace's FMU crates, reads each
//! block's table from its library, and writes the packages.
//!
//! The table, the documentation and the recorded results are read from the library for this machine, which is loaded.
//! Libraries for other platforms are only read, and must contain the same table.

use crate::build::compile::{GLIBC, Linkage, compile_joined};
use crate::build::platform::{self, Platform};
use crate::build::workspace::{FmuCrate, Workspace};
use crate::package::check;
use crate::package::program_library;
use crate::package::version::{Fmi, Version};
use crate::package::{reference, sources};
use crate::page;
use crate::progress::Progress;
use crate::tell;
use anyhow::{Context, Result, bail};
use host::library::Library;
use host::package::DESCRIPTION;
use host::package::archive;
use host::package::binary::{self, Binary};
use host::package::temporary;
use modeldescription::{Interface, ModelDescription};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The crates to pack, and how.
#[derive(clap::Args, Clone, Debug, Default)]
#[group(skip)] // clap names a group after its type, and other options have a type with the same name
pub struct Options {
    /// Sources of a PLC program (.scl, .udt, .db, .s7dcl); or FMUs to pack, by package name, such as PUMP for pump
    /// [default: all FMUs of the workspace]
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
    /// Packages to pack, including test-only packages
    #[arg(short, long = "package", value_name = "PACKAGE")]
    pub packages: Vec<String>,
    /// Platform to build for, such as win64; may be repeated [default: this machine's]
    ///
    /// linux64, linux32, win64, win32, darwin64, aarch64-linux or aarch32-linux (also: armv7). Platforms other than
    /// this machine's need Rust's standard library ('rustup target add ...') and a linker: mingw for Windows, zig with
    /// cargo-zigbuild for the others. The environment variable PLCFMU_CROSS_CARGO names a different cargo for these.
    #[arg(long = "platform", value_name = "PLATFORM", value_parser = platform::folder)]
    pub platforms: Vec<&'static str>,
    /// Library built elsewhere, for the single FMU being packed; may be repeated
    #[arg(long = "library", value_name = "PLATFORM=FILE", value_parser = given_library)]
    pub libraries: Vec<(&'static str, PathBuf)>,
    /// Link against this machine's C library (needs no zig); the FMU may not run on an older Linux. A PLC program
    /// is compiled through C, by the compiler in the environment variable CC, or by cc, gcc, clang or zig
    #[arg(long)]
    pub native: bool,
    #[command(flatten)]
    /// The FMI version, types and names.
    pub version: Version,
    /// Folder for the FMUs [default: target/fmu, for FMI 3.0 target/fmu3, for programs the current folder]
    #[arg(short, long = "out", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Skip platforms that cannot be built here, with a note.
    #[arg(skip)]
    pub as_available: bool,
}

/// Parses an argument of `--library` into platform and file.
fn given_library(argument: &str) -> Result<(&'static str, PathBuf)> {
    let (platform, file) = argument.split_once('=').context("write PLATFORM=FILE, such as win64=pump.dll")?;
    Ok((platform::folder(platform)?, file.into()))
}

/// The licences and notices in each FMU: file name and text.
pub const LICENCES: [(&str, &str); 4] = [
    ("LICENSE-MIT", include_str!("../../../LICENSE-MIT")),
    ("LICENSE-APACHE", include_str!("../../../LICENSE-APACHE")),
    ("LICENSE-UNICODE", include_str!("../../LICENSE-UNICODE")),
    ("NOTICE", include_str!("../../NOTICE")),
];

/// A built FMU crate.
#[derive(Debug)]
struct Built {
    fmu_crate: FmuCrate,
    /// The library for this machine, which can be loaded.
    here: PathBuf,
    interface: Interface,
    /// The library for each platform, by the platform's name in FMI.
    libraries: BTreeMap<&'static str, PathBuf>,
}

/// Which libraries to build, and which were built elsewhere.
#[derive(Debug)]
struct Plan {
    host: Platform,
    /// The builds for each FMI platform, this machine's last.
    built: Vec<(&'static str, Vec<(Platform, Linkage)>)>,
    given: BTreeMap<&'static str, PathBuf>,
    /// Whether the library for this machine is also packed, rather than only built for its table.
    has_host: bool,
    /// Whether the library for this machine is linked against this machine's C library.
    is_host_native: bool,
}

/// Decides which platforms to build for, and how, without building or writing anything.
fn plan(workspace: &Workspace, options: &Options, crates: usize) -> Result<Plan> {
    let host = Platform::host(&workspace.root)?;
    let mut given = BTreeMap::new();
    for (folder, path) in &options.libraries {
        if options.platforms.contains(folder) || given.insert(*folder, path.clone()).is_some() {
            bail!("{folder} is requested twice: build it with --platform, or specify its library once with --library");
        }
    }
    if !given.is_empty() && crates != 1 {
        bail!("--library applies to one FMU, but {crates} would be packed: choose one, such as 'PUMP'");
    }
    let mut folders = options.platforms.clone();
    if folders.is_empty() && !given.contains_key(host.folder) {
        folders.push(host.folder);
    }
    let has_host = folders.contains(&host.folder) || given.contains_key(host.folder);
    let own = Linkage::choose(workspace, &host, options.native);
    let mut built: Vec<(&str, Vec<(Platform, Linkage)>)> = Vec::new();
    for folder in folders {
        if built.iter().any(|(other, _)| *other == folder) {
            continue;
        }
        // Unless this machine's platform is requested explicitly, only its own half of a universal macOS file is built.
        let is_asked = options.platforms.contains(&folder);
        let platforms = if is_asked { Platform::of_folder(folder, &host) } else { vec![host] };
        let linked = |platform: Platform| {
            let is_host = platform == host;
            Ok((platform, if is_host { own.clone() } else { Linkage::cross(workspace, &host, &platform)? }))
        };
        match platforms.into_iter().map(linked).collect::<Result<Vec<_>>>() {
            Ok(targets) => built.push((folder, targets)),
            Err(error) if options.as_available => tell::note(&format!("left out: {error:#}")),
            Err(error) => return Err(error),
        }
    }
    if !has_host {
        built.push((host.folder, vec![(host, own.clone())]));
    }
    // This machine's build comes last: if something is missing, the others fail early.
    built.sort_by_key(|(folder, _)| *folder == host.folder);
    Ok(Plan { host, built, given, has_host, is_host_native: own == Linkage::Native })
}

/// Packs FMUs.
///
/// # Errors
/// An option is invalid, a library cannot be built, or an FMU is faulty. FMUs packed before the error are kept.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    options.version.check()?;
    let crates = select(workspace, options)?;
    let plan = plan(workspace, options, crates.len())?;
    let folder = options.out.clone().unwrap_or_else(|| match options.version.fmi {
        Fmi::Two => workspace.fmus(),
        Fmi::Three => workspace.fmus().with_file_name("fmu3"),
    });
    let _lock = begin(workspace, &folder)?;
    let is_all = options.names.is_empty() && options.packages.is_empty();
    let programs = workspace.programs.as_ref().filter(|programs| is_all || options.packages.contains(&programs.name));
    let (all, libraries) = build(workspace, options, crates, programs, &plan)?;
    for (platform, library) in &libraries {
        let place = program_library::place(&folder, platform);
        fs::create_dir_all(temporary::folder(&place)).with_context(|| place.display().to_string())?;
        fs::copy(library, &place).with_context(|| format!("{} cannot be written", place.display()))?;
    }
    let progress = Progress::bar(all.len());
    for built in &all {
        let name = &built.interface.table.name;
        progress.begin(name);
        let folder = if built.fmu_crate.test_only { &folder.join("test-only") } else { &folder };
        let path = folder.join(format!("{name}.fmu"));
        let size = pack(workspace, built, &plan, options.version, &path)
            .with_context(|| format!("{name} (package {})", built.fmu_crate.name))?;
        let platforms: Vec<_> = built.libraries.keys().copied().collect();
        progress.line(&format!(
            "{name:<10} {}  {:>4} kB  {}  {}",
            platforms.join(" "),
            size.div_ceil(1000),
            built.interface.guid,
            workspace.shown(&path)
        ));
        progress.done();
    }
    drop(progress);
    if !plan.has_host {
        let host = plan.host.folder;
        tell::note(&format!(
            "the library for this machine ({host}) was built only to read the tables; the FMUs do not contain it"
        ));
    } else if plan.is_host_native && plan.host.is_linux() {
        note_glibc(&all, options.native)?;
    }
    Ok(())
}

/// Builds and checks all libraries, without packing any FMU. Returns the built crates and, if `programs` is given, the
/// program library for each platform.
fn build(
    workspace: &Workspace,
    options: &Options,
    crates: Vec<FmuCrate>,
    programs: Option<&FmuCrate>,
    plan: &Plan,
) -> Result<(Vec<Built>, BTreeMap<&'static str, PathBuf>)> {
    let together: Vec<FmuCrate> = crates.iter().chain(programs).cloned().collect();
    let host = plan.host.folder;
    let mut libraries: BTreeMap<&'static str, BTreeMap<String, PathBuf>> = BTreeMap::new();
    for (folder, targets) in &plan.built {
        match compile_joined(workspace, &together, targets) {
            Ok(paths) => {
                libraries.insert(folder, paths);
            }
            Err(error) if options.as_available && *folder != host => tell::note(&format!("left out: {error:#}")),
            Err(error) => return Err(error),
        }
    }
    let of_programs = |paths: &mut BTreeMap<String, PathBuf>| paths.remove(&programs?.name);
    let of_programs = libraries.iter_mut().filter_map(|(folder, paths)| Some((*folder, of_programs(paths)?))).collect();
    let mut all = Vec::new();
    for fmu_crate in crates {
        let mut own: BTreeMap<&'static str, PathBuf> = plan.given.clone();
        for (folder, paths) in &mut libraries {
            own.extend(paths.remove(&fmu_crate.name).map(|path| (*folder, path)));
        }
        let here = own.get(host).cloned().context("no library for this machine was built")?;
        let interface = interface(&here).with_context(|| format!("package {}", fmu_crate.name))?;
        if !plan.has_host {
            own.remove(host);
        }
        for (folder, path) in &own {
            let is_native = options.native || plan.is_host_native && *folder == host;
            let bytes = fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
            check::library(&bytes, folder, &interface, is_native)
                .with_context(|| format!("package {}: {folder}: {}", fmu_crate.name, path.display()))?;
        }
        all.push(Built { fmu_crate, here, interface, libraries: own });
    }
    all.sort_by(|a, b| a.interface.table.name.cmp(&b.interface.table.name));
    let made: Vec<_> =
        all.iter().map(|built| (built.fmu_crate.name.as_str(), built.interface.table.name.as_str())).collect();
    check_names(&made)?;
    Ok((all, of_programs))
}

/// Prints a note on the glibc version that the FMUs require because they were linked against this machine's.
fn note_glibc(all: &[Built], asked_for: bool) -> Result<()> {
    let mut needed = Vec::new();
    for built in all {
        needed.extend(Binary::read(&fs::read(&built.here)?)?.glibc);
    }
    let Some(glibc) = needed.into_iter().max_by_key(|glibc| binary::version(glibc)) else { return Ok(()) };
    let remedy = if asked_for {
        String::new()
    } else {
        format!("; for {GLIBC}, install zig and cargo-zigbuild (pip install ziglang cargo-zigbuild)")
    };
    tell::note(&format!("linked with this machine's C library: the FMUs need glibc {glibc} or newer{remedy}"));
    Ok(())
}

/// The requested crates: those of `-p` by their exact names, the others ignoring case and the difference between `-`
/// and `_`. The program package may be named with `-p`, but is not returned.
///
/// # Errors
/// A requested crate does not exist.
pub fn select(workspace: &Workspace, options: &Options) -> Result<Vec<FmuCrate>> {
    const WHAT: &str = "an FMU package has a cdylib target and depends on fmu";
    if workspace.crates.is_empty() {
        bail!("no FMU in {}: {WHAT}; 'plcfmu new NAME' creates one", workspace.root.display());
    }
    let is_named = |name: &str, fmu_crate: &FmuCrate| !fmu_crate.test_only && is_same(name, &fmu_crate.name);
    let names = |test_only: bool| -> String {
        let crates = workspace.crates.iter().filter(|fmu_crate| test_only || !fmu_crate.test_only);
        crates.map(|fmu_crate| fmu_crate.name.as_str()).collect::<Vec<_>>().join(", ")
    };
    for package in &options.packages {
        if !workspace.crates.iter().chain(&workspace.programs).any(|fmu_crate| fmu_crate.name == *package) {
            bail!("{package} is not an FMU package ({WHAT}); available: {}", names(true));
        }
    }
    for name in &options.names {
        if !workspace.crates.iter().any(|fmu_crate| is_named(name, fmu_crate)) {
            bail!("no FMU {name}; available packages: {}", names(false));
        }
    }
    let is_all = options.names.is_empty() && options.packages.is_empty();
    let is_asked = |fmu_crate: &&FmuCrate| {
        is_all && !fmu_crate.test_only
            || options.packages.contains(&fmu_crate.name)
            || options.names.iter().any(|name| is_named(name, fmu_crate))
    };
    Ok(workspace.crates.iter().filter(is_asked).cloned().collect())
}

/// Whether two names are equal, ignoring case and the difference between `-` and `_`.
fn is_same(a: &str, b: &str) -> bool {
    a.replace('-', "_").eq_ignore_ascii_case(&b.replace('-', "_"))
}

/// Checks that no two packages produce the same file; `made` lists each package with its FMU.
fn check_names(made: &[(&str, &str)]) -> Result<()> {
    for (place, (package, fmu)) in made.iter().enumerate() {
        if let Some((other, _)) = made[..place].iter().find(|(_, other)| is_same(other, fmu)) {
            bail!("the packages {other} and {package} would both produce {fmu}.fmu: rename one of the blocks");
        }
    }
    Ok(())
}

/// The self-description of a library, which is loaded for this purpose.
fn interface(library: &Path) -> Result<Interface> {
    let json = Library::open(library)?.interface()?;
    Ok(Interface::parse(&json)?)
}

/// Creates the folder, waits until no other command is packing FMUs of this workspace, and removes the leftovers of
/// interrupted commands. The returned file holds the lock.
fn begin(workspace: &Workspace, folder: &Path) -> Result<File> {
    let own = workspace.fmus();
    let test_only = folder.join("test-only");
    let lock = || -> io::Result<File> {
        fs::create_dir_all(&own)?;
        let lock = File::create(own.join(".lock"))?;
        if lock.try_lock().is_err() {
            tell::text("waiting for another command that is packing the FMUs of this workspace ...");
            lock.lock()?;
        }
        fs::create_dir_all(folder)?;
        temporary::remove_left(folder)?;
        if test_only.is_dir() {
            temporary::remove_left(&test_only)?;
        }
        Ok(lock)
    };
    lock().with_context(|| format!("{} cannot be used for FMUs", folder.display()))
}

/// Packs one FMU and returns its size in bytes.
fn pack(workspace: &Workspace, built: &Built, plan: &Plan, version: Version, path: &Path) -> Result<usize> {
    let interface = version.adapt(&built.interface);
    let mut xml = ModelDescription::from_interface(&interface)?.with_license(built.fmu_crate.license.clone());
    let name = &interface.table.name;
    let source = source(workspace, built, version)?;
    let file = source.as_ref().map(|_| format!("{name}.c"));
    if let Some(file) = &file {
        xml = xml.with_sources(std::slice::from_ref(file));
    }
    let mut files = files(built, &xml, version, file.as_deref())?;
    files.extend(source.map(|text| version.sources(name, text)).unwrap_or_default());
    let bytes = archive::write(&version.placed(files))?;
    temporary::place(path, |file| Ok(file.write_all(&bytes)?), |packed| check::packed(packed, &xml, plan.has_host))?;
    Ok(bytes.len())
}

/// The FMU as C source. If the block's law cannot be read, a note is printed, and the FMU contains no C source.
fn source(workspace: &Workspace, built: &Built, version: Version) -> Result<Option<String>> {
    let Built { fmu_crate, here, interface, .. } = built;
    if fmu_crate.without_sources {
        return Ok(None);
    }
    match sources::generate(workspace, fmu_crate, &Library::open(here)?, interface, version.door()) {
        Ok(text) => Ok(Some(text)),
        Err(why) => {
            tell::note(&format!(
                "{} is packed without C: {why:#}; write the law so that plcfmu can read it, or omit the C source \
                 with sources = false under [package.metadata.plcfmu] in the Cargo.toml of {}",
                interface.table.name, fmu_crate.name
            ));
            Ok(None)
        }
    }
}

/// All files of an FMU except its C file `source`, by path in the FMU.
fn files(
    built: &Built,
    xml: &ModelDescription,
    version: Version,
    source: Option<&str>,
) -> Result<BTreeMap<String, Vec<u8>>> {
    let Built { interface, libraries, fmu_crate, .. } = built;
    let table = &interface.table;
    let name = &table.name;
    let mut files = BTreeMap::new();
    files.insert(DESCRIPTION.to_string(), xml.write());
    for (folder, library) in libraries {
        let content = fs::read(library).with_context(|| format!("{} cannot be read", library.display()))?;
        let suffix = platform::system(folder).map_or("", |(_, suffix)| suffix);
        files.insert(format!("binaries/{folder}/{name}{suffix}"), content);
    }
    let recordings = reference::run(&built.here, interface)?;
    files.extend(reference::files(table, &recordings.responses[0], version));
    files.insert(
        "documentation/index.html".into(),
        page::html(table, &xml.description(), &recordings, fmu_crate.license.as_deref(), source)?.into_bytes(),
    );
    for (licence, text) in LICENCES {
        files.insert(format!("documentation/licenses/{licence}"), text.into());
    }
    files.extend(version.pictures(table)?);
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fmu_crate(package: &str, test_only: bool) -> FmuCrate {
        FmuCrate { name: package.into(), library: package.into(), test_only, ..FmuCrate::default() }
    }

    fn workspace(root: &Path) -> Workspace {
        let crates = vec![fmu_crate("boom", true), fmu_crate("my-pump", false), fmu_crate("valve", false)];
        Workspace { root: root.into(), target: root.join("target"), crates, programs: None }
    }

    /// An existing folder, in which rustc can be run.
    fn here() -> &'static Path {
        Path::new(env!("CARGO_MANIFEST_DIR"))
    }

    /// The packages selected by these arguments.
    fn selected(names: &[&str], packages: &[&str]) -> Result<Vec<String>> {
        let text = |words: &[&str]| words.iter().map(|word| word.to_string()).collect();
        let options = Options { names: text(names), packages: text(packages), ..Options::default() };
        let crates = select(&workspace(Path::new("/w")), &options)?;
        Ok(crates.into_iter().map(|fmu_crate| fmu_crate.name).collect())
    }

    #[test]
    fn all_fmus_are_packed_but_those_for_tests() {
        assert_eq!(selected(&[], &[]).unwrap(), ["my-pump", "valve"]);
    }

    #[test]
    fn a_package_is_named_exactly_and_may_be_for_tests() {
        assert_eq!(selected(&[], &["boom"]).unwrap(), ["boom"]);
        assert_eq!(
            selected(&[], &["bom"]).unwrap_err().to_string(),
            "bom is not an FMU package (an FMU package has a cdylib target and depends on fmu); available: \
             boom, my-pump, valve"
        );
    }

    #[test]
    fn the_package_of_programs_may_be_named_with_those_of_fmus() {
        let programs = Some(fmu_crate("programs", false));
        let workspace = Workspace { programs, ..workspace(Path::new("/w")) };
        let packages = ["valve", "programs"].map(String::from).to_vec();
        let options = Options { packages, ..Options::default() };
        assert_eq!(select(&workspace, &options).unwrap(), [fmu_crate("valve", false)]);
    }

    #[test]
    fn an_fmu_is_named_by_its_package_in_any_case() {
        assert_eq!(selected(&["VALVE"], &[]).unwrap(), ["valve"]);
        assert_eq!(selected(&["My_Pump"], &[]).unwrap(), ["my-pump"]);
        assert_eq!(selected(&["valve", "my-pump"], &[]).unwrap(), ["my-pump", "valve"]);
        assert_eq!(selected(&["valve"], &["boom"]).unwrap(), ["boom", "valve"]);
    }

    #[test]
    fn an_unknown_fmu_is_refused_with_those_that_there_are() {
        for name in ["PUMPS", "boom"] {
            assert_eq!(
                selected(&[name], &["valve"]).unwrap_err().to_string(),
                format!("no FMU {name}; available packages: my-pump, valve")
            );
        }
    }

    #[test]
    fn a_workspace_without_an_fmu_is_told_what_makes_one() {
        let workspace = Workspace { crates: Vec::new(), ..workspace(Path::new("/w")) };
        let error = select(&workspace, &Options::default()).unwrap_err().to_string();
        assert!(error.starts_with("no FMU in /w: ") && error.ends_with("'plcfmu new NAME' creates one"), "{error}");
    }

    /// The plan for these arguments: what is built, and whether the library for this machine is packed.
    fn planned(platforms: &[&'static str], libraries: &[&str], crates: usize) -> Result<(Vec<&'static str>, bool)> {
        let libraries = libraries.iter().map(|argument| given_library(argument)).collect::<Result<Vec<_>>>()?;
        let options = Options { platforms: platforms.to_vec(), libraries, native: true, ..Options::default() };
        let plan = plan(&workspace(here()), &options, crates)?;
        Ok((plan.built.iter().map(|(folder, _)| *folder).collect(), plan.has_host))
    }

    #[test]
    fn an_fmu_is_built_for_this_machine_alone_if_no_platform_is_named() {
        let host = Platform::host(here()).unwrap().folder;
        assert_eq!(planned(&[], &[], 5).unwrap(), (vec![host], true));
        assert_eq!(planned(&[host, host], &[], 5).unwrap(), (vec![host], true));
        assert_eq!(planned(&[], &["linux32=a.so"], 1).unwrap(), (vec![host], true));
    }

    #[test]
    fn a_library_that_was_built_elsewhere_is_not_built_again() {
        let host = Platform::host(here()).unwrap().folder;
        let given = format!("{host}=pump.so");
        assert_eq!(planned(&[], &[&given, "linux32=a=b.so"], 1).unwrap(), (vec![], true));
        assert_eq!(given_library("linux32=a=b.so").unwrap(), ("linux32", "a=b.so".into()));
        let refusal = |platforms: &[&'static str], libraries: &[&str], crates| -> String {
            planned(platforms, libraries, crates).unwrap_err().to_string()
        };
        let twice =
            format!("{host} is requested twice: build it with --platform, or specify its library once with --library");
        assert_eq!(refusal(&[host], &[&given], 1), twice);
        assert_eq!(refusal(&[], &[&given, &given], 1), twice);
        assert_eq!(
            refusal(&[], &[&given], 2),
            "--library applies to one FMU, but 2 would be packed: choose one, such as 'PUMP'"
        );
        assert_eq!(refusal(&[], &["pump.so"], 1), "write PLATFORM=FILE, such as win64=pump.dll");
        assert!(refusal(&[], &["win128=pump.so"], 1).starts_with("available: linux64, "));
    }

    #[test]
    fn two_packages_cannot_make_one_fmu() {
        check_names(&[("a", "PUMP"), ("b", "VALVE")]).unwrap();
        assert_eq!(
            check_names(&[("a", "PUMP"), ("b", "Pump")]).unwrap_err().to_string(),
            "the packages a and b would both produce Pump.fmu: rename one of the blocks"
        );
    }

    #[test]
    fn what_an_interrupted_packer_left_is_removed_and_nothing_else() {
        let root = tempfile::tempdir().unwrap();
        let workspace = workspace(root.path());
        let folder = workspace.fmus();
        drop(begin(&workspace, &folder).unwrap());
        fs::create_dir_all(folder.join("test-only")).unwrap();
        for name in [".plcfmu-1a2b.tmp", "test-only/.plcfmu-x.tmp", "PUMP.fmu", "notes.tmp"] {
            fs::write(folder.join(name), "x").unwrap();
        }
        fs::create_dir_all(folder.join(".plcfmu-3c.tmp/binaries/linux64")).unwrap();
        let _lock = begin(&workspace, &folder).unwrap();
        let names = |folder: &Path| -> Vec<String> {
            let entries = fs::read_dir(folder).unwrap();
            let mut names: Vec<String> =
                entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        };
        assert_eq!(names(&folder), [".lock", "PUMP.fmu", "notes.tmp", "test-only"]);
        assert_eq!(names(&folder.join("test-only")), [""; 0]);
    }
}
