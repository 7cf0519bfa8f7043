//! Creates a crate for a user's own block, with the sources of `blocks` and `fmu` that it needs.

use anyhow::{Context, Result, bail};
use host::package::temporary;
use std::fs;
use std::path::Path;

/// The sources of `blocks` and `fmu`: path and text.
const SOURCES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// The other files next to these sources. `VERSION` in them is replaced by this program's version.
const BESIDE_SOURCES: [(&str, &str); 5] = [
    ("README.md", include_str!("templates/vendored.md")),
    ("LICENSE-MIT", include_str!("../../../LICENSE-MIT")),
    ("LICENSE-APACHE", include_str!("../../../LICENSE-APACHE")),
    ("blocks/Cargo.toml", include_str!("templates/blocks.toml")),
    ("fmu/Cargo.toml", include_str!("templates/fmu.toml")),
];

/// The folder for these sources in a crate.
pub const SOURCES_FOLDER: &str = "plcfmu";

/// The files of the new crate. `my_block`, `MyBlock` and `MY_BLOCK` in them are replaced by the block's names.
const CRATE: [(&str, &str); 4] = [
    ("Cargo.toml", include_str!("templates/crate.toml")),
    ("src/lib.rs", include_str!("templates/lib.rs")),
    ("README.md", include_str!("templates/README.md")),
    (".gitignore", include_str!("templates/gitignore")),
];

/// Names that a crate cannot have: Rust's keywords, Rust's own crates, and the new crate's dependencies.
const RESERVED: &str = "
    abstract alloc as async await become blocks box break const continue core crate do dyn else enum extern
    false final fmu fn for gen if impl in let loop macro match mod move mut override priv proc_macro pub ref
    return self static std struct super test trait true try type typeof unsafe unsized use virtual where while
    yield";

/// The maximum length of a crate name, in characters.
const LONGEST_NAME: usize = 64;

/// The names of a block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    /// The crate's, such as `my_block`.
    pub package: String,
    /// The FMU's, such as `MY_BLOCK`.
    pub block: String,
    /// The Rust type's, such as `MyBlock`.
    type_name: String,
}

impl Names {
    /// Derives the names from the crate name.
    ///
    /// # Errors
    /// It is not a valid crate name.
    pub fn new(package: &str) -> Result<Names> {
        let is_valid = package.starts_with(|first: char| first.is_ascii_lowercase())
            && package.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || "_-".contains(c))
            && !package.ends_with(['_', '-'])
            && package.len() <= LONGEST_NAME;
        if !is_valid {
            bail!(
                "{package:?} is not a valid crate name: use at most {LONGEST_NAME} lower-case letters, digits and _, \
                 beginning with a letter, such as my_block"
            );
        }
        let identifier = package.replace('-', "_");
        if RESERVED.split_whitespace().any(|reserved| reserved == identifier) {
            bail!(
                "{package:?} is not a valid crate name: Rust or plcfmu uses it; choose another, such as my_{identifier}"
            );
        }
        let words: Vec<&str> = identifier.split('_').filter(|word| !word.is_empty()).collect();
        let mut type_name: String = words.iter().map(|word| word[..1].to_uppercase() + &word[1..]).collect();
        if words.len() == 1 {
            // A single word may be the name of a type in Rust or in `blocks`, such as Option or Time.
            type_name.push_str("Block");
        }
        Ok(Names { package: package.into(), block: identifier.to_uppercase(), type_name })
    }

    fn fill_in(&self, text: &str) -> String {
        text.replace("MY_BLOCK", &self.block).replace("MyBlock", &self.type_name).replace("my_block", &self.package)
    }
}

/// Checks that a licence is an SPDX expression.
///
/// # Errors
/// It is not an SPDX expression.
pub fn check_license(license: &str) -> Result<()> {
    if let Err(error) = spdx::Expression::parse(license) {
        bail!(
            "{license:?} is not an SPDX licence expression ({}): use one such as MIT, 'MIT OR Apache-2.0' or \
             LicenseRef-Proprietary",
            error.reason
        );
    }
    Ok(())
}

/// Creates a crate in the new folder `path`. Without `license`, the crate specifies no licence.
///
/// # Errors
/// The folder already exists, or cannot be written.
pub fn create(path: &Path, names: &Names, license: Option<&str>) -> Result<()> {
    if path.symlink_metadata().is_ok() {
        bail!("{} already exists: choose another name, or another folder with --out", path.display());
    }
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let failed = || format!("{} cannot be created", path.display());
    fs::create_dir_all(parent).with_context(failed)?;
    // Created next to its destination, so that it appears complete or not at all.
    let temporary = temporary::Folder::new_in(parent).with_context(failed)?;
    let folder = temporary.path().join("crate");
    for (file, text) in CRATE {
        let mut text = names.fill_in(text);
        if let ("Cargo.toml", Some(license)) = (file, license) {
            text = text.replacen("publish = false", &format!("license = \"{license}\"\npublish = false"), 1);
        }
        write(&folder.join(file), &text)?;
    }
    write_sources(&folder)?;
    fs::rename(&folder, path).with_context(failed)
}

/// The first path, relative to the crate's folder, at which the sources in a crate differ from this program's. `None`
/// if they are equal, or the crate has none.
pub fn different_source(crate_folder: &Path) -> Option<String> {
    let folder = crate_folder.join(SOURCES_FOLDER);
    // In plcfmu's own repository, the folder with this name has other contents.
    if !folder.join("fmu/Cargo.toml").is_file() {
        return None;
    }
    let differs =
        |(path, text): &(String, String)| fs::read(folder.join(path)).ok().as_deref() != Some(text.as_bytes());
    sources().find(differs).map(|(path, _)| format!("{SOURCES_FOLDER}/{path}"))
}

/// Replaces the sources in a crate with this program's.
///
/// # Errors
/// The crate contains no sources, or they cannot be written.
pub fn update(crate_folder: &Path) -> Result<()> {
    let folder = crate_folder.join(SOURCES_FOLDER);
    if !folder.join("fmu/Cargo.toml").is_file() {
        bail!("{} has no plcfmu sources: only a crate created by 'plcfmu new' has them", folder.display());
    }
    let failed = || format!("{} cannot be replaced", folder.display());
    let temporary = temporary::Folder::new_in(crate_folder).with_context(failed)?;
    write_sources(temporary.path())?;
    fs::rename(&folder, temporary.path().join("old")).with_context(failed)?;
    fs::rename(temporary.path().join(SOURCES_FOLDER), &folder).with_context(failed)
}

/// All files in the folder of plcfmu sources: path in the folder, and text.
fn sources() -> impl Iterator<Item = (String, String)> {
    let beside = BESIDE_SOURCES.iter().map(|(path, text)| (*path, text.replace("VERSION", env!("CARGO_PKG_VERSION"))));
    let sources = SOURCES.iter().map(|(path, text)| (*path, text.to_string()));
    beside.chain(sources).map(|(path, text)| (path.to_string(), text))
}

fn write_sources(crate_folder: &Path) -> Result<()> {
    sources().try_for_each(|(path, text)| write(&crate_folder.join(SOURCES_FOLDER).join(path), &text))
}

fn write(path: &Path, text: &str) -> Result<()> {
    path.parent()
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| fs::write(path, text))
        .with_context(|| format!("{} cannot be written", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cargo_metadata::MetadataCommand;

    #[test]
    fn a_block_is_named_after_its_crate() {
        let names = |package| Names::new(package).map(|names| (names.block, names.type_name)).unwrap();
        assert_eq!(names("my_pump"), ("MY_PUMP".into(), "MyPump".into()));
        assert_eq!(names("my-pump2"), ("MY_PUMP2".into(), "MyPump2".into()));
        // Not `Time`, which is a type of a variable.
        assert_eq!(names("time"), ("TIME".into(), "TimeBlock".into()));
    }

    #[test]
    fn a_name_that_a_crate_cannot_have_is_refused() {
        let long = "a".repeat(65);
        for name in ["", "Pump", "2pump", "_pump", "pump_", "pump.x", "../pump", "püump", &long] {
            let error = Names::new(name).unwrap_err().to_string();
            assert!(error.contains("lower-case letters, digits and _"), "{name}: {error}");
        }
        for name in ["fn", "fmu", "proc-macro"] {
            assert!(Names::new(name).unwrap_err().to_string().contains("choose another, such as my_"), "{name}");
        }
    }

    #[test]
    fn a_licence_is_an_spdx_expression() {
        for license in ["MIT", "MIT OR Apache-2.0", "LicenseRef-Proprietary"] {
            check_license(license).unwrap();
        }
        for license in ["", "MIT or mine", "Apache 2", "MIT\"\nx = \""] {
            let error = check_license(license).unwrap_err().to_string();
            assert!(error.contains("is not an SPDX licence expression"), "{license}: {error}");
        }
    }

    #[test]
    fn the_licence_is_the_users_choice_and_otherwise_left_open() {
        let folder = tempfile::tempdir().unwrap();
        let license = |name: &str, license| {
            let path = folder.path().join(name);
            create(&path, &Names::new("pump").unwrap(), license).unwrap();
            let mut command = MetadataCommand::new();
            let metadata = command.manifest_path(path.join("Cargo.toml")).no_deps().other_options(["--offline".into()]);
            metadata.exec().unwrap().packages[0].license.clone()
        };
        assert_eq!(license("open", None), None);
        assert_eq!(license("chosen", Some("EUPL-1.2")), Some("EUPL-1.2".into()));
    }

    #[test]
    fn a_folder_that_exists_is_never_touched() {
        let folder = tempfile::tempdir().unwrap();
        let error = create(folder.path(), &Names::new("pump").unwrap(), None).unwrap_err().to_string();
        assert!(error.contains("already exists: choose another name, or another folder with --out"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn sources_that_were_changed_are_told_and_replaced_on_request() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pump");
        assert_eq!(different_source(folder.path()), None);
        create(&path, &Names::new("pump").unwrap(), None).unwrap();
        assert_eq!(different_source(&path), None);
        fs::write(path.join("plcfmu/blocks/src/lib.rs"), "changed").unwrap();
        fs::write(path.join("plcfmu/blocks/src/old.rs"), "no longer there").unwrap();
        assert_eq!(different_source(&path).unwrap(), "plcfmu/blocks/src/lib.rs");
        update(&path).unwrap();
        assert_eq!(different_source(&path), None);
        assert!(!path.join("plcfmu/blocks/src/old.rs").exists());
        assert!(update(folder.path()).unwrap_err().to_string().contains("only a crate created by 'plcfmu new' has"));
    }

    #[test]
    fn the_manifests_of_the_sources_say_what_those_in_the_repository_say() {
        let folder = tempfile::tempdir().unwrap();
        write_sources(folder.path()).unwrap();
        for library in ["blocks", "fmu"] {
            let package = |root: &Path| {
                let manifest = root.join(library).join("Cargo.toml");
                let metadata = MetadataCommand::new().manifest_path(manifest).no_deps().exec().unwrap();
                let package = metadata.packages.into_iter().find(|package| package.name == library).unwrap();
                let dependencies: Vec<_> = package
                    .dependencies
                    .into_iter()
                    .map(|needed| (needed.name, needed.kind, needed.features))
                    .collect();
                let texts = (package.description, package.license, package.rust_version);
                (package.version, package.edition, texts, dependencies)
            };
            let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
            assert_eq!(package(&folder.path().join(SOURCES_FOLDER)), package(&repository), "{library}");
        }
    }
}
