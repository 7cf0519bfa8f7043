//! `cargo xtask release`: checks that a version can be released, then creates its commit and tag. It pushes nothing.

use anyhow::{Context, Result, bail};
use plcfmu::build::workspace::{self, Workspace};
use plcfmu::command::{output, run};
use std::fs;
use std::path::Path;
use std::process::Command;
use toml::Table;

/// The release to make.
#[derive(clap::Args, Clone, Debug, Default)]
pub(crate) struct Options {
    /// The version to release, such as 0.2.0 [default: the version in Cargo.toml]
    pub version: Option<String>,
    /// Only check; change nothing
    #[arg(long)]
    pub check: bool,
}

const MANIFEST: &str = "Cargo.toml";
const CITATION: &str = "CITATION.cff";
const CHANGELOG: &str = "CHANGELOG.md";
const WHEEL: &str = "plcfmu/python/pyproject.toml";
const WORKFLOW: &str = ".github/workflows/release.yml";

/// The files expected in the repository's root.
const EXPECTED: &[&str] =
    &["README.md", "LICENSE-APACHE", "LICENSE-MIT", "CONTRIBUTING.md", "CODE_OF_CONDUCT.md", "SECURITY.md"];

/// The licence files that a package must contain: cargo does not include files outside its folder.
const LICENCES: &[&str] = &["LICENSE-APACHE", "LICENSE-MIT"];

/// The crate for use in other programs. All others are parts of the command, which is built from the whole workspace.
const LIBRARY: &str = "blocks";

const UNRELEASED: &str = "## [Unreleased]";

/// A requirement for a release: its name and, if it is not met, the problem and its remedy.
struct Check {
    name: String,
    fault: Option<String>,
}

/// The files that a release reads and changes.
struct Sources {
    manifest: Table,
    citation: String,
    changelog: String,
    wheel: Table,
    library: Table,
    workflow: String,
}

/// Checks the release, creates its commit and tag unless only checks are requested, and lists the remaining manual
/// steps.
pub(crate) fn release(workspace: &Workspace, options: &Options) -> Result<()> {
    let root = &workspace.root;
    let sources = Sources::read(root)?;
    let current = sources.version()?;
    let version = options.version.as_deref().unwrap_or(current);
    let mut checks = repository(root, version)?;
    checks.extend(sources.checks(version));
    checks.push(lock(root));
    checks.push(licences(root));
    checks.push(packs(root));
    let missing = EXPECTED.iter().filter(|name| !root.join(name).is_file()).copied().collect::<Vec<_>>();
    checks.push(Check::new("the top-level files exist", missing.is_empty(), || format!("add {}", missing.join(", "))));
    println!("Release {version}:");
    for check in &checks {
        match &check.fault {
            None => println!("  ok    {}", check.name),
            Some(fault) => println!("  FAIL  {}: {fault}", check.name),
        }
    }
    let failed = checks.iter().filter(|check| check.fault.is_some()).count();
    if failed > 0 {
        bail!("{failed} of {} checks failed; nothing was changed", checks.len());
    }
    if !options.check {
        commit(root, &sources, version)?;
    }
    println!("\n{}", by_hand(&sources, version, options.check));
    Ok(())
}

impl Check {
    fn new(name: impl Into<String>, holds: bool, fault: impl FnOnce() -> String) -> Check {
        Check { name: name.into(), fault: (!holds).then(fault) }
    }
}

/// Checks the state of the git repository.
fn repository(root: &Path, version: &str) -> Result<Vec<Check>> {
    let changed = git(root, &["status", "--porcelain"])?;
    let tag = format!("v{version}");
    let tags = git(root, &["tag", "--list", &tag])?;
    Ok(vec![
        Check::new("every change is committed", changed.is_empty(), || {
            format!("commit or remove {}", changed.lines().map(|line| line[3..].trim()).collect::<Vec<_>>().join(", "))
        }),
        Check::new(format!("the tag {tag} is new"), tags.is_empty(), || {
            format!("choose a version other than {version}")
        }),
    ])
}

/// Checks that the lock file matches the manifests: release archives are built with `--locked`. Uses `cargo update`,
/// because other commands would need the crates for all platforms, many of which no build has fetched.
fn lock(root: &Path) -> Check {
    let mut cargo = workspace::cargo();
    cargo.args(["update", "--workspace", "--locked", "--offline", "--quiet"]).current_dir(root);
    Check::new("Cargo.lock matches the manifests", output(&mut cargo).is_ok(), || {
        "run 'cargo check' and commit Cargo.lock".into()
    })
}

/// Checks that the library's folder contains the licences.
fn licences(root: &Path) -> Check {
    let own = |name: &str| fs::read(root.join(LIBRARY).join(name)).ok();
    let absent: Vec<_> = LICENCES.iter().copied().filter(|name| fs::read(root.join(name)).ok() != own(name)).collect();
    Check::new(format!("the crate {LIBRARY} has the licences"), absent.is_empty(), || {
        format!("copy {} to {LIBRARY}/", absent.join(", "))
    })
}

/// Checks that the library compiles from its package alone, as `cargo publish --dry-run` requires.
fn packs(root: &Path) -> Check {
    let mut cargo = workspace::cargo();
    cargo.args(["package", "--quiet", "--offline", "--allow-dirty", "--package", LIBRARY]).current_dir(root);
    Check::new(format!("the crate {LIBRARY} compiles from its package alone"), output(&mut cargo).is_ok(), || {
        format!("'cargo package --allow-dirty --package {LIBRARY}' shows what is missing")
    })
}

fn git(root: &Path, arguments: &[&str]) -> Result<String> {
    output(Command::new("git").args(arguments).current_dir(root)).map(|text| text.trim_end().to_string())
}

impl Sources {
    fn read(root: &Path) -> Result<Sources> {
        let text = |name: &str| fs::read_to_string(root.join(name)).context(name.to_string());
        let table = |name: &str| text(name)?.parse::<Table>().context(name.to_string());
        Ok(Sources {
            manifest: table(MANIFEST)?,
            citation: text(CITATION)?,
            changelog: text(CHANGELOG)?,
            wheel: table(WHEEL)?,
            library: table(&format!("{LIBRARY}/{MANIFEST}"))?,
            workflow: text(WORKFLOW)?,
        })
    }

    /// An entry of `[workspace.package]`, inherited by all packages.
    fn shared(&self, key: &str) -> Option<&str> {
        self.manifest["workspace"]["package"].get(key)?.as_str()
    }

    fn version(&self) -> Result<&str> {
        self.shared("version").context("Cargo.toml: no version under [workspace.package]")
    }

    /// Checks the files individually and against each other.
    fn checks(&self, version: &str) -> Vec<Check> {
        let numbers: Vec<_> = version.split('.').collect();
        let is_version = numbers.len() == 3 && numbers.iter().all(|number| number.parse::<u32>().is_ok());
        let current = self.shared("version").unwrap_or_default();
        let rust = self.shared("rust-version").unwrap_or_default();
        let of_wheel = ["description", "readme", "license", "keywords", "classifiers", "requires-python"];
        let of_wheel = absent(&self.wheel, "project", &of_wheel);
        let of_library =
            absent(&self.library, "package", &["description", "license", "keywords", "categories", "rust-version"]);
        vec![
            Check::new("the version has three numbers", is_version, || format!("{version} is not of the form 0.2.0")),
            Check::new("CITATION.cff has the version in Cargo.toml", cited(&self.citation) == Some(current), || {
                format!("write 'version: {current}' there")
            }),
            Check::new("CHANGELOG.md describes the changes", !unreleased(&self.changelog).is_empty(), || {
                format!("describe them under '{UNRELEASED}'")
            }),
            Check::new(
                format!("CHANGELOG.md has no section for {version} yet"),
                !self.changelog.contains(&format!("\n## [{version}]")),
                || format!("{version} has been released: choose another version"),
            ),
            Check::new(
                "the workflow builds with the Rust version in Cargo.toml",
                !rust.is_empty() && self.workflow.contains(&format!("rustup toolchain install {rust}.")),
                || format!("install {rust}.x in {WORKFLOW}"),
            ),
            Check::new("the wheel has its metadata", of_wheel.is_empty(), || {
                format!("add {} to [project] in {WHEEL}", of_wheel.join(", "))
            }),
            Check::new(format!("the crate {LIBRARY} has its metadata"), of_library.is_empty(), || {
                format!("add {} to [package] in {LIBRARY}/{MANIFEST}", of_library.join(", "))
            }),
        ]
    }
}

/// The keys missing in a table of a manifest.
fn absent<'a>(manifest: &Table, table: &str, keys: &[&'a str]) -> Vec<&'a str> {
    let entries = manifest.get(table).and_then(toml::Value::as_table);
    keys.iter().copied().filter(|key| entries.is_none_or(|entries| !entries.contains_key(*key))).collect()
}

/// The version in CITATION.cff.
fn cited(citation: &str) -> Option<&str> {
    citation.lines().find_map(|line| line.strip_prefix("version:")).map(str::trim)
}

/// The changelog section of unreleased changes, without its heading.
fn unreleased(changelog: &str) -> &str {
    let (_, rest) = changelog.split_once(UNRELEASED).unwrap_or_default();
    rest.split("\n## ").next().unwrap_or_default().trim()
}

/// Writes version and date into the files, commits them and creates the tag. The date is the last commit's, so that
/// the same state yields the same release.
fn commit(root: &Path, sources: &Sources, version: &str) -> Result<()> {
    let date = git(root, &["log", "-1", "--format=%cs"])?;
    let current = sources.version()?;
    let manifest = fs::read_to_string(root.join(MANIFEST)).context(MANIFEST)?;
    // The first version in the file belongs to [workspace.package]; package versions follow it.
    let line = |version: &str| format!("\nversion = \"{version}\"\n");
    let files = [
        (MANIFEST, manifest.replacen(&line(current), &line(version), 1)),
        (CITATION, cite(&sources.citation, version, &date)),
        (CHANGELOG, sources.changelog.replacen(UNRELEASED, &format!("{UNRELEASED}\n\n## [{version}] - {date}"), 1)),
    ];
    for (name, text) in files {
        fs::write(root.join(name), text).context(name)?;
    }
    run(workspace::cargo().args(["update", "--workspace", "--offline", "--quiet"]).current_dir(root))?;
    run(Command::new("git")
        .args(["commit", "--quiet", "--all", "--message"])
        .arg(format!("Release {version}"))
        .current_dir(root))?;
    let tag = format!("v{version}");
    run(Command::new("git")
        .args(["tag", "--annotate", "--message"])
        .args([&format!("plcfmu {version}"), &tag])
        .current_dir(root))
}

/// The contents of CITATION.cff with this version and date.
fn cite(citation: &str, version: &str, date: &str) -> String {
    let lines = citation.lines().filter(|line| !line.starts_with("date-released:"));
    let cited = lines.map(|line| match line.starts_with("version:") {
        true => format!("version: {version}\ndate-released: {date}\n"),
        false => format!("{line}\n"),
    });
    cited.collect()
}

/// The remaining manual steps.
fn by_hand(sources: &Sources, version: &str, is_check: bool) -> String {
    let mut steps = Vec::new();
    if is_check {
        steps.push(format!("Create the commit and the tag: cargo xtask release {version}"));
    }
    if sources.shared("repository").is_none() {
        steps.push(format!(
            "Choose where to host the repository, and write its URL to Cargo.toml (repository) and {WHEEL} ([project.urls])"
        ));
    }
    steps.push(".ci/run on a clean checkout (30 minutes on 2 cores)".into());
    steps.push(format!(
        "Push: git push origin HEAD v{version}. {WORKFLOW} tests, builds on each system, and attaches files, checksums and \
         provenance; it needs GitHub Pages enabled (source: GitHub Actions)"
    ));
    steps.push("Upload the wheels to PyPI with a project account: python -m twine upload *.whl".into());
    steps.push(format!(
        "If other programs are to use the crate {LIBRARY}: set publish = true in {LIBRARY}/Cargo.toml, then cargo publish --package \
         {LIBRARY}"
    ));
    steps.push(
        "Sign the command for Windows and macOS, if a certificate is available: nothing is signed automatically".into(),
    );
    steps.push("Send compatibility/ to the list of FMI tools: cargo xtask dist --address URL writes the entry".into());
    let steps = steps.iter().enumerate().map(|(number, step)| format!("  {}. {step}", number + 1));
    format!("Remaining manual steps:\n{}", steps.collect::<Vec<_>>().join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHANGES: &str = "# Changelog\n\n## [Unreleased]\n\n- a new block\n\n## [0.1.0] - 2026-01-02\n\n- all\n";

    #[test]
    fn what_is_new_ends_at_the_last_release() {
        assert_eq!(unreleased(CHANGES), "- a new block");
        assert_eq!(unreleased("# Changelog\n\n## [Unreleased]\n\n## [0.1.0] - 2026-01-02\n\n- all\n"), "");
    }

    fn sources(changelog: &str) -> Sources {
        Sources {
            manifest: "[workspace.package]\nversion = \"0.1.0\"\nrust-version = \"1.95\"\n".parse().unwrap(),
            citation: "title: x\nversion: 0.1.0\ntype: software\n".into(),
            changelog: changelog.into(),
            wheel: "[project]\ndescription = \"x\"\nreadme = \"x\"\nlicense = \"x\"\nkeywords = []\n\
                classifiers = []\nrequires-python = \"x\"\n"
                .parse()
                .unwrap(),
            library: "[package]\ndescription = \"x\"\nlicense.workspace = true\nrust-version.workspace = true\n\
                keywords = []\ncategories = []\n"
                .parse()
                .unwrap(),
            workflow: "      - run: rustup toolchain install 1.95.0 --profile minimal\n".into(),
        }
    }

    fn faults(sources: &Sources, version: &str) -> Vec<String> {
        sources.checks(version).into_iter().filter_map(|check| check.fault.map(|_| check.name)).collect()
    }

    #[test]
    fn each_check_fails_where_its_file_is_wrong() {
        assert!(faults(&sources(CHANGES), "0.2.0").is_empty());
        assert_eq!(faults(&sources(CHANGES), "0.1.0"), ["CHANGELOG.md has no section for 0.1.0 yet"]);
        assert_eq!(faults(&sources(CHANGES), "0.2"), ["the version has three numbers"]);
        assert_eq!(
            faults(&sources("## [Unreleased]\n\n## [0.1.0]\n"), "0.2.0"),
            ["CHANGELOG.md describes the changes"]
        );
        let mut other = sources(CHANGES);
        other.citation = "version: 0.0.9\n".into();
        other.workflow = "rustup toolchain install 1.94.0".into();
        other.wheel = "[project]\ndescription = \"x\"\n".parse().unwrap();
        other.library = "[package]\nkeywords = []\n".parse().unwrap();
        let expected = [
            "CITATION.cff has the version in Cargo.toml",
            "the workflow builds with the Rust version in Cargo.toml",
            "the wheel has its metadata",
            "the crate blocks has its metadata",
        ];
        assert_eq!(faults(&other, "0.2.0"), expected);
    }

    #[test]
    fn a_library_that_needs_a_file_outside_of_its_folder_does_not_pack() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let manifest = "[package]\nname = \"blocks\"\nversion = \"0.1.0\"\nedition = \"2024\"\n";
        fs::create_dir_all(root.join("blocks/src")).unwrap();
        fs::write(root.join(MANIFEST), "[workspace]\nmembers = [\"blocks\"]\nresolver = \"3\"\n").unwrap();
        fs::write(root.join("blocks/Cargo.toml"), manifest).unwrap();
        fs::write(root.join("outside.txt"), "").unwrap();
        let faults = ["../../outside.txt", "inside.txt"].map(|file| {
            fs::write(root.join("blocks/src/inside.txt"), "").unwrap();
            fs::write(root.join("blocks/src/lib.rs"), format!("const _: &str = include_str!(\"{file}\");\n")).unwrap();
            packs(root).fault
        });
        let remedy = "'cargo package --allow-dirty --package blocks' shows what is missing";
        assert_eq!(faults, [Some(remedy.to_string()), None]);
    }

    #[test]
    fn a_licence_that_the_library_lacks_or_that_differs_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        fs::create_dir(root.join("blocks")).unwrap();
        for (name, text) in [("LICENSE-APACHE", "a"), ("LICENSE-MIT", "b"), ("blocks/LICENSE-APACHE", "other")] {
            fs::write(root.join(name), text).unwrap();
        }
        assert_eq!(licences(root).fault.as_deref(), Some("copy LICENSE-APACHE, LICENSE-MIT to blocks/"));
        for name in LICENCES {
            fs::copy(root.join(name), root.join("blocks").join(name)).unwrap();
        }
        assert_eq!(licences(root).fault, None);
    }

    #[test]
    fn a_lock_file_of_another_version_is_a_fault() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let write = |version: &str| {
            let text = format!("[package]\nname = \"x\"\nversion = \"{version}\"\nedition = \"2024\"\n");
            fs::write(root.join(MANIFEST), text).unwrap();
        };
        fs::create_dir(root.join("src")).unwrap();
        fs::write(root.join("src/lib.rs"), "").unwrap();
        write("0.1.0");
        run(workspace::cargo().args(["generate-lockfile", "--offline", "--quiet"]).current_dir(root)).unwrap();
        assert_eq!(lock(root).fault, None);
        write("0.2.0");
        assert_eq!(lock(root).fault.as_deref(), Some("run 'cargo check' and commit Cargo.lock"));
    }

    /// A repository with the files of a release and one commit dated 2026-02-03.
    #[test]
    fn a_release_is_one_commit_and_one_tag() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let sources = sources(CHANGES);
        let package = "[package]\nname = \"x\"\nversion.workspace = true\n\n";
        let manifest = "[workspace]\n\n[workspace.package]\nversion = \"0.1.0\"\n";
        fs::create_dir(root.join("src")).unwrap();
        fs::write(root.join("src/lib.rs"), "").unwrap();
        fs::write(root.join(MANIFEST), format!("{package}{manifest}")).unwrap();
        fs::write(root.join(CITATION), &sources.citation).unwrap();
        fs::write(root.join(CHANGELOG), CHANGES).unwrap();
        git(root, &["init", "--quiet"]).unwrap();
        git(root, &["config", "user.name", "x"]).unwrap();
        git(root, &["config", "user.email", "x@example.org"]).unwrap();
        git(root, &["add", "."]).unwrap();
        let mut first = Command::new("git");
        first.env("GIT_COMMITTER_DATE", "2026-02-03T12:00:00+00:00");
        run(first.args(["commit", "--quiet", "--message", "x"]).current_dir(root)).unwrap();
        commit(root, &sources, "0.2.0").unwrap();
        assert_eq!(git(root, &["status", "--porcelain", "--untracked-files=no"]).unwrap(), "");
        assert_eq!(git(root, &["log", "--format=%s"]).unwrap(), "Release 0.2.0\nx");
        assert_eq!(git(root, &["describe"]).unwrap(), "v0.2.0");
        let read = |name: &str| fs::read_to_string(root.join(name)).unwrap();
        assert_eq!(read(CITATION), "title: x\nversion: 0.2.0\ndate-released: 2026-02-03\ntype: software\n");
        assert!(read(MANIFEST).contains("[workspace.package]\nversion = \"0.2.0\"\n"));
        assert!(read(CHANGELOG).contains("## [Unreleased]\n\n## [0.2.0] - 2026-02-03\n\n- a new block\n"));
    }
}
