//! Makes the files offered for download, for `cargo xtask dist`: every FMU for all platforms that can be built here, an
//! ARM-only version of each, the parameter tool, the command as built by the caller, a folder for trying the FMUs in
//! other tools, checksums, and a table of contents.

use crate::build::platform::{self, Platform};
use crate::build::workspace::Workspace;
use crate::command;
use crate::package::version::{Fmi, Version};
use crate::package::{merge, pack, program_library};
use crate::tell;
use crate::tool::make;
use anyhow::{Context, Result, bail};
use host::hexadecimal;
use host::package::{Package, archive, temporary};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The platforms that are built by default.
const PLATFORMS: [&str; 4] = ["linux64", "win64", "aarch64-linux", "darwin64"];

/// The folder of the ARM-only FMUs. FMI 2.0 has no folder for Linux on ARM, so these FMUs also have their library in
/// `linux64`, where some tools look.
const ALONE: &str = "aarch64-linux";

/// The folder of the FMI 3.0 FMUs, which have the same names as the FMI 2.0 ones.
const NEWER: &str = "fmi3";

/// If the FMUs include this platform, the command is also built for it; otherwise, only for this machine.
const COMMAND: &str = "win64";

/// The files in addition to the FMUs: their suffixes and descriptions.
const ADDED: [(&str, &str); 5] = [
    (".cdx.json", "The crates in the command: a bill of materials (CycloneDX)"),
    (".tar.gz", "The command plcfmu"),
    (".zip", "The command plcfmu"),
    (".html", "The parameter tool: a self-contained page, to be opened from disk or a web server"),
    (".whl", "For pip: the command plcfmu, the Python package plcfmu, and all FMUs"),
];

/// The settings with which TwinCAT builds the sources of an FMU: file name, content and description.
const TWINCAT: (&str, &str, &str) = (
    "plcfmu.xml",
    include_str!("templates/twincat.xml"),
    "Settings for TwinCAT's Target for FMI, which builds the C sources of FMUs (written from its documentation, untested)",
);

/// The folder for trying the FMUs in other tools: each FMU with its reference results, in the layout of the FMI
/// cross-check.
const COMPATIBILITY: &str = "compatibility";

const SUMS: &str = "SHA256SUMS";
const CONTENTS: &str = "CONTENTS.md";

/// The distribution to build.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Options {
    /// Platform to build for; may be repeated [default: those of linux64, win64, aarch64-linux and darwin64 that can be
    /// built here]
    #[arg(long = "platform", value_name = "PLATFORM", value_parser = platform::folder)]
    pub platforms: Vec<&'static str>,
    /// Folder of FMUs and program libraries packed by 'cargo xtask fmu --platform PLATFORM' on another machine; one for
    /// each platform. They are joined, and nothing is packed here
    #[arg(long = "packed", value_name = "DIR", conflicts_with = "platforms")]
    pub packed: Vec<PathBuf>,
    /// Folder for the files, which is replaced [default: target/dist]
    #[arg(short, long = "out", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// The project's URL, such as `https://example.org/plcfmu/`, for its entry in the list of FMI tools, tools.json
    #[arg(long, value_name = "URL")]
    pub address: Option<String>,
}

/// Builds the distribution in a new folder, which then replaces the old one. `python` is a Python with maturin, for the
/// wheels and archives.
///
/// # Errors
/// Something cannot be built or written; the folder is left unchanged.
pub fn run(workspace: &Workspace, options: &Options, mut python: Command) -> Result<()> {
    let folder = options.out.clone().unwrap_or_else(|| workspace.target.join("dist"));
    check_replaceable(&folder)?;
    let unwritable = || format!("{} cannot be written", folder.display());
    let parent = temporary::folder(&folder);
    fs::create_dir_all(parent).with_context(unwritable)?;
    temporary::remove_left(parent).with_context(unwritable)?;
    // Created next to its destination, so that it appears complete or not at all.
    let beside = temporary::Folder::new_in(parent).with_context(unwritable)?;
    let new = beside.path().join("dist");
    let host = Platform::host(&workspace.root)?;
    let as_available = options.platforms.is_empty() && options.packed.is_empty();
    if options.packed.is_empty() {
        let platforms = if as_available { PLATFORMS.to_vec() } else { options.platforms.clone() };
        let packing = pack::Options { platforms, out: Some(new.clone()), as_available, ..pack::Options::default() };
        pack::run(workspace, &packing)?;
        let newer = new.join(NEWER);
        let version = Version { fmi: Fmi::Three, ..Version::default() };
        pack::run(workspace, &pack::Options { version, out: Some(newer.clone()), ..packing })?;
        // Both versions use the same program library.
        fs::remove_dir_all(newer.join(program_library::FOLDER)).with_context(unwritable)?;
    } else {
        join(&options.packed, &new)?;
    }
    let platforms = platforms_in(&new)?;
    if platforms.contains(host.folder) {
        match make::run(workspace, &make::Options { fmus: Some(new.clone()), out: Some(new.clone()) }) {
            Err(error) if as_available => tell::note(&format!("left out: {error:#}")),
            made => made?,
        }
    }
    python.arg(workspace.root.join("plcfmu/python/build_wheel.py")).args(["--archive", "--fmus=.", "--out=."]);
    python.args(targets(&new, &host)?.iter().map(|target| format!("--target={target}")));
    let mut compatibility = Command::new(python.get_program());
    compatibility.arg(workspace.root.join("plcfmu/python/compatibility.py")).arg("--fmus").arg(&new);
    compatibility.arg("--out").arg(new.join(COMPATIBILITY)).args(["--version", env!("CARGO_PKG_VERSION")]);
    compatibility.args(options.address.iter().map(|address| format!("--address={address}")));
    let mut try_them = Command::new(python.get_program());
    try_them.arg(workspace.root.join("plcfmu/python/try_release.py")).arg(&new);
    command::run(python.current_dir(&new))?;
    command::run(&mut try_them)?;
    command::run(&mut compatibility)?;
    // The program libraries are now in the wheels and archives.
    fs::remove_dir_all(new.join(program_library::FOLDER)).with_context(unwritable)?;
    finish(&new)?;
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(unwritable)?;
    }
    fs::rename(&new, &folder).with_context(unwritable)?;
    println!("{}", workspace.shown(&folder));
    Ok(())
}

/// Checks that the folder was created by this command, and may therefore be replaced.
fn check_replaceable(folder: &Path) -> Result<()> {
    if folder.exists() && !folder.join(SUMS).is_file() {
        bail!("{} exists and was not created by this command: choose another folder with --out", folder.display());
    }
    Ok(())
}

/// Joins the FMUs and program libraries from several machines in a new folder.
fn join(packed: &[PathBuf], new: &Path) -> Result<()> {
    let newer: Vec<PathBuf> = packed.iter().map(|folder| folder.join(NEWER)).collect();
    if let Some(missing) = newer.iter().find(|folder| !folder.is_dir()) {
        let missing = missing.display();
        bail!("the FMI 3.0 FMUs are missing from {missing}: pack them with 'cargo xtask fmu --fmi 3 --out {missing}'");
    }
    join_fmus(packed, new)?;
    join_fmus(&newer, &new.join(NEWER))?;
    for (platform, library) in packed.iter().flat_map(|folder| program_library::all_in(folder)) {
        let place = program_library::place(new, platform);
        let copied = fs::create_dir_all(temporary::folder(&place)).and_then(|()| fs::copy(&library, &place));
        copied.with_context(|| format!("{} cannot be copied", library.display()))?;
    }
    Ok(())
}

/// Joins the FMUs of the same name from several folders, and writes them to the folder `new`.
fn join_fmus(packed: &[PathBuf], new: &Path) -> Result<()> {
    fs::create_dir_all(new).with_context(|| new.display().to_string())?;
    for name in names_in_all(packed)? {
        let read = |folder: &PathBuf| -> Result<(String, merge::Files)> {
            let path = folder.join(&name);
            let shown = path.display().to_string();
            Ok((shown.clone(), merge::files(&mut Package::open(&path).with_context(|| shown.clone())?).context(shown)?))
        };
        let joined = merge::join_all(packed.iter().map(read).collect::<Result<_>>()?)?;
        let bytes = archive::write(&joined)?;
        temporary::place(&new.join(name), |file| Ok(file.write_all(&bytes)?), |_| Ok(()))?;
    }
    Ok(())
}

/// The names of the FMUs, which must be the same in all folders.
fn names_in_all(folders: &[PathBuf]) -> Result<Vec<String>> {
    let (first, others) = folders.split_first().context("no folder specified")?;
    let fmus = names(first, ".fmu")?;
    for other in others {
        let there = names(other, ".fmu")?;
        if let Some(name) = fmus.iter().chain(&there).find(|name| !fmus.contains(name) || !there.contains(name)) {
            let (first, other) = (first.display(), other.display());
            bail!("{name} is in only one of {first} and {other}: pack the same FMUs for all platforms");
        }
    }
    Ok(fmus)
}

/// The platforms of the FMUs in a folder. Fails if one of them has no program library.
fn platforms_in(folder: &Path) -> Result<BTreeSet<String>> {
    let mut all = BTreeSet::new();
    for name in names(folder, ".fmu")? {
        let read = || merge::files(&mut Package::open(&folder.join(&name))?);
        let mut files = read().with_context(|| name.clone())?;
        merge::remove_stand_in(&mut files);
        all.extend(merge::platforms(&files));
    }
    check_programs(&all, &program_library::all_in(folder))?;
    Ok(all)
}

/// Checks that each platform of the FMUs has a program library.
fn check_programs(platforms: &BTreeSet<String>, programs: &BTreeMap<&str, PathBuf>) -> Result<()> {
    match platforms.iter().find(|platform| !programs.contains_key(platform.as_str())) {
        None => Ok(()),
        Some(platform) => bail!(
            "the FMUs have libraries for {platform}, but its program library is missing: pack all FMUs with 'cargo xtask \
             fmu --platform {platform}', and keep the folder {} next to them",
            program_library::FOLDER
        ),
    }
}

/// The Rust targets for which to build the command, according to the platforms of the FMUs in a folder.
fn targets(folder: &Path, host: &Platform) -> Result<Vec<&'static str>> {
    let mut targets = vec![host.target];
    for name in names(folder, ".fmu")?.iter().take(1) {
        let package = Package::open(&folder.join(name)).with_context(|| name.clone())?;
        if package.libraries.iter().any(|library| library.platform == COMMAND) {
            targets.extend(Platform::of_folder(COMMAND, host).iter().map(|platform| platform.target));
        }
    }
    targets.dedup();
    Ok(targets)
}

/// Adds the files derived from the others in a folder: the ARM-only FMUs, the table of contents and the checksums.
fn finish(folder: &Path) -> Result<()> {
    let mut files = BTreeMap::new();
    for name in names(folder, ".fmu")? {
        let read = || -> Result<(Vec<u8>, merge::Files)> {
            let path = folder.join(&name);
            Ok((fs::read(&path)?, merge::files(&mut Package::open(&path)?)?))
        };
        let (bytes, content) = read().with_context(|| name.clone())?;
        if let Some(alone) = merge::only(&content, ALONE).filter(|alone| *alone != content) {
            files.insert(format!("{ALONE}/{name}"), archive::write(&alone)?);
        }
        files.insert(name, bytes);
    }
    if folder.join(NEWER).is_dir() {
        below(folder, NEWER, &mut files)?;
    }
    for (end, _) in ADDED {
        for name in names(folder, end)? {
            let bytes = fs::read(folder.join(&name)).with_context(|| name.clone())?;
            files.insert(name, bytes);
        }
    }
    let (name, settings, _) = TWINCAT;
    files.insert(name.into(), settings.replace("VERSION", env!("CARGO_PKG_VERSION")).into_bytes());
    files.insert(CONTENTS.into(), contents(&files)?.into_bytes());
    if folder.join(COMPATIBILITY).is_dir() {
        below(folder, COMPATIBILITY, &mut files)?;
    }
    files.insert(SUMS.into(), sums(&files).into_bytes());
    for (name, bytes) in &files {
        temporary::place(&folder.join(name), |file| Ok(file.write_all(bytes)?), |_| Ok(()))?;
    }
    Ok(())
}

/// Adds all files below `inside`, a folder in `folder`, under their paths with `/`.
fn below(folder: &Path, inside: &str, files: &mut BTreeMap<String, Vec<u8>>) -> Result<()> {
    for entry in fs::read_dir(folder.join(inside)).with_context(|| inside.to_string())? {
        let entry = entry?;
        let name = format!("{inside}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            below(folder, &name, files)?;
        } else {
            let bytes = fs::read(entry.path()).with_context(|| name.clone())?;
            files.insert(name, bytes);
        }
    }
    Ok(())
}

/// The names of the files in a folder with this suffix, sorted.
fn names(folder: &Path, end: &str) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.ends_with(end) {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// The table of all files, in Markdown.
fn contents(files: &BTreeMap<String, Vec<u8>>) -> Result<String> {
    let mut table = String::from("# Contents\n\n| file | for | kB | description |\n|---|---|---|---|\n");
    for (name, bytes) in files {
        let (platforms, what) = match ADDED.iter().find_map(|(end, what)| Some((name.strip_suffix(end)?, what))) {
            _ if name == TWINCAT.0 => ("TwinCAT".into(), TWINCAT.2.to_string()),
            Some((_, what)) if name == make::FILE => ("any browser".into(), (*what).to_string()),
            // The platform is the last part of the name.
            Some((stem, what)) => (stem.rsplit('-').next().unwrap_or_default().to_string(), (*what).to_string()),
            None => {
                let package = Package::read(Cursor::new(bytes)).with_context(|| name.clone())?;
                (package.platforms(), package.description.description.clone().unwrap_or_default())
            }
        };
        let what = what.replace('|', "\\|");
        let _ = writeln!(table, "| {name} | {platforms} | {} | {what} |", bytes.len().div_ceil(1000));
    }
    let _ = write!(
        table,
        "\nThe folder {NEWER}/ has the FMI 3.0 FMUs. FMI 2.0 has no folder for Linux on ARM: the FMUs in {ALONE}/ also have that library in linux64, for tools that \
         look there. {COMPATIBILITY}/ has each FMU with inputs, reference results and options, in the layout of the FMI \
         cross-check.\n"
    );
    Ok(table)
}

/// The checksums in the format of `sha256sum --check`.
fn sums(files: &BTreeMap<String, Vec<u8>>) -> String {
    let mut sums = String::new();
    for (name, bytes) in files {
        let _ = writeln!(sums, "{}  {name}", hexadecimal::digits(&Sha256::digest(bytes)));
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use host::package::DESCRIPTION;
    use modeldescription::v2::{CoSimulation, ModelDescription, write};

    /// An FMU with these libraries: platform and content.
    fn fmu(libraries: &[(&str, &str)]) -> Vec<u8> {
        let co_simulation = CoSimulation { model_identifier: "PUMP".into(), ..CoSimulation::default() };
        let description = ModelDescription {
            model_name: "PUMP".into(),
            guid: "{1}".into(),
            description: Some("Pumps or not".into()),
            co_simulation: Some(co_simulation),
            ..ModelDescription::default()
        };
        let mut files = merge::Files::from([(DESCRIPTION.into(), write(&description))]);
        for (platform, content) in libraries {
            files.insert(format!("binaries/{platform}/PUMP.so"), content.as_bytes().to_vec());
        }
        archive::write(&files).unwrap()
    }

    #[test]
    fn the_table_names_each_file_with_its_platforms() {
        let files = BTreeMap::from([
            ("PUMP.fmu".to_string(), fmu(&[("aarch64-linux", "4"), ("linux64", "1")])),
            ("aarch64-linux/PUMP.fmu".to_string(), fmu(&[("aarch64-linux", "4"), ("linux64", "4")])),
            ("fmi3/PUMP.fmu".to_string(), fmu(&[("x86_64-linux", "4")])),
        ]);
        let table = contents(&files).unwrap();
        assert!(table.contains("\n| PUMP.fmu | aarch64-linux, linux64 | 1 | Pumps or not |\n"), "{table}");
        assert!(table.contains("\n| aarch64-linux/PUMP.fmu | aarch64-linux, linux64 | 1 |"), "{table}");
        assert!(table.contains("\n| fmi3/PUMP.fmu | x86_64-linux | 1 |"), "{table}");
        let files = ["plcfmu-0.1.0-linux64.tar.gz", "plcfmu-0.1.0-py3-none-win_amd64.whl", make::FILE, TWINCAT.0];
        let table = contents(&files.map(|name| (name.to_string(), vec![0; 2345])).into()).unwrap();
        assert!(table.contains("\n| plcfmu-0.1.0-linux64.tar.gz | linux64 | 3 | The command plcfmu |\n"), "{table}");
        assert!(table.contains("\n| plcfmu-0.1.0-py3-none-win_amd64.whl | win_amd64 | 3 | For pip: "), "{table}");
        assert!(table.contains("\n| plcfmu.xml | TwinCAT | 3 | Settings for TwinCAT"), "{table}");
        assert!(table.contains("\n| plcfmu-tool.html | any browser | 3 | The parameter tool"), "{table}");
    }

    #[test]
    fn the_command_is_built_for_this_machine_and_for_windows_if_the_fmus_are() {
        let host = Platform::find("x86_64-unknown-linux-gnu").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("PUMP.fmu");
        fs::write(&path, fmu(&[("linux64", "1"), ("aarch64-linux", "2")])).unwrap();
        assert_eq!(targets(folder.path(), &host).unwrap(), ["x86_64-unknown-linux-gnu"]);
        fs::write(&path, fmu(&[("linux64", "1"), ("win64", "2")])).unwrap();
        assert_eq!(targets(folder.path(), &host).unwrap(), ["x86_64-unknown-linux-gnu", "x86_64-pc-windows-gnu"]);
        let windows = Platform::find("x86_64-pc-windows-msvc").unwrap();
        assert_eq!(targets(folder.path(), &windows).unwrap(), ["x86_64-pc-windows-msvc"]);
    }

    #[test]
    fn an_fmu_that_was_not_packed_for_all_platforms_is_refused() {
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        let paths = folders.each_ref().map(|folder| folder.path().to_path_buf());
        paths.iter().for_each(|path| fs::write(path.join("PUMP.fmu"), "").unwrap());
        assert_eq!(names_in_all(&paths).unwrap(), ["PUMP.fmu"]);
        fs::write(paths[1].join("FAN.fmu"), "").unwrap();
        let error = names_in_all(&paths).unwrap_err().to_string();
        assert!(error.starts_with("FAN.fmu is in only one of ") && error.ends_with("for all platforms"), "{error}");
    }

    #[test]
    fn a_library_of_programs_that_is_missing_for_a_platform_is_told() {
        let platforms = BTreeSet::from(["linux64", "win64"].map(String::from));
        let programs = |names: &[&'static str]| names.iter().map(|name| (*name, PathBuf::new())).collect();
        check_programs(&platforms, &programs(&["darwin64", "linux64", "win64"])).unwrap();
        let error = check_programs(&platforms, &programs(&["linux64"])).unwrap_err().to_string();
        assert!(error.starts_with("the FMUs have libraries for win64, but its program library"), "{error}");
    }

    #[test]
    fn checksums_are_those_of_sha256sum() {
        let files = BTreeMap::from([("a.fmu".to_string(), b"abc".to_vec())]);
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sums(&files), format!("{sum}  a.fmu\n"));
    }

    #[test]
    fn the_checksums_are_of_the_files_for_other_tools_too() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join(COMPATIBILITY).join("fmus/PUMP");
        fs::create_dir_all(&inside).unwrap();
        fs::write(inside.join("PUMP_ref.csv"), "abc").unwrap();
        finish(folder.path()).unwrap();
        let sums = fs::read_to_string(folder.path().join(SUMS)).unwrap();
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert!(sums.contains(&format!("{sum}  {COMPATIBILITY}/fmus/PUMP/PUMP_ref.csv\n")), "{sums}");
        assert!(!fs::read_to_string(folder.path().join(CONTENTS)).unwrap().contains("PUMP_ref"));
    }

    #[test]
    fn a_folder_with_anything_else_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        assert!(check_replaceable(&folder.path().join("dist")).is_ok());
        let error = check_replaceable(folder.path()).unwrap_err().to_string();
        assert!(error.ends_with("was not created by this command: choose another folder with --out"), "{error}");
        fs::write(folder.path().join(SUMS), "").unwrap();
        assert!(check_replaceable(folder.path()).is_ok());
    }
}
