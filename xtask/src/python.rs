//! The Python environment `target/venv` with the packages pinned in `tests/requirements.txt`. It is recreated if that
//! file or the Python has changed, or if its creation was interrupted. It may be a link to another clone's environment.

use anyhow::{Context, Result, bail};
use plcfmu::build::workspace::Workspace;
use plcfmu::command::output;
use plcfmu::progress::Progress;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The oldest Python version that all packages support.
const OLDEST: (u32, u32) = (3, 9);

/// The names of Python interpreters to try, in order.
const CANDIDATES: &[&str] =
    &["python3", "python", "python3.13", "python3.12", "python3.11", "python3.10", "python3.9", "python3.14"];

/// A script that prints a Python's version and path if it can create environments; within an environment, those of its
/// base Python.
const DESCRIBE: &str = "import os, sys, venv, ensurepip
print(sys.version_info[0], sys.version_info[1])
print(sys.version.split()[0])
print(os.path.realpath(getattr(sys, '_base_executable', None) or sys.executable))
";

/// The hint at the end of errors, for users who can do without these packages.
const WITHOUT: &str = "'cargo xtask fmu --native' needs no Python";

/// The environment, ready for use.
#[derive(Debug)]
pub(crate) struct Environment {
    folder: PathBuf,
}

/// A Python that can create an environment.
#[derive(Debug, PartialEq)]
struct Python {
    program: PathBuf,
    version: (u32, u32),
    /// Its full version and path.
    description: String,
}

impl Environment {
    /// Returns the environment of a workspace, creating it if it is missing or out of date.
    pub(crate) fn ready(workspace: &Workspace) -> Result<Environment> {
        Environment::made_with(&find()?, workspace)
    }

    fn made_with(python: &Python, workspace: &Workspace) -> Result<Environment> {
        let requirements = workspace.root.join("tests/requirements.txt");
        let pinned = fs::read_to_string(&requirements).with_context(|| requirements.display().to_string())?;
        let place = workspace.target.join("venv");
        let linked = fs::read_link(&place).ok();
        let environment = Environment { folder: linked.clone().unwrap_or_else(|| place.clone()) };
        // The scripts in an environment contain its path, so a moved environment is also out of date.
        let wanted = format!("{}\n{}\n\n{pinned}", environment.folder.display(), python.description);
        let stamp = environment.folder.join("plcfmu-stamp.txt");
        let is_ready = || fs::read_to_string(&stamp).is_ok_and(|made_of| made_of == wanted);
        if is_ready() {
            return Ok(environment);
        }
        if let Some(other) = linked {
            bail!(
                "{} is a link to {}, which is out of date: remove the link, or run 'cargo xtask test' in the clone that it \
                 belongs to",
                place.display(),
                other.display()
            );
        }
        // Of two concurrent commands, the second waits for the first and then uses its result.
        fs::create_dir_all(&workspace.target)?;
        let lock = File::create(workspace.target.join("venv.lock")).context("target/venv.lock cannot be created")?;
        lock.lock()?;
        if !is_ready() {
            environment.make(python, &requirements)?;
            // Written last: an environment without it is incomplete and is recreated.
            fs::write(&stamp, &wanted).with_context(|| stamp.display().to_string())?;
        }
        Ok(environment)
    }

    fn make(&self, python: &Python, requirements: &Path) -> Result<()> {
        let _progress = Progress::spinner(&format!(
            "creating the Python environment {} (once; downloads the packages in tests/requirements.txt)",
            self.folder.display()
        ));
        if self.folder.exists() {
            fs::remove_dir_all(&self.folder).with_context(|| format!("{} cannot be removed", self.folder.display()))?;
        }
        output(Command::new(&python.program).args(["-m", "venv"]).arg(&self.folder))?;
        let mut install = self.python();
        install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input"]);
        install.args(["--only-binary=:all:", "--requirement"]).arg(requirements);
        if let Err(error) = output(&mut install) {
            bail!(
                "the packages in tests/requirements.txt cannot be installed: {}\nConnect to PyPI or to a mirror \
                 (PIP_INDEX_URL); {WITHOUT}",
                reason(&error.to_string())
            );
        }
        Ok(())
    }

    /// The folder of its programs.
    pub(crate) fn programs(&self) -> PathBuf {
        self.folder.join(if cfg!(windows) { "Scripts" } else { "bin" })
    }

    /// A command that runs the environment's Python, with its programs first on PATH.
    pub(crate) fn python(&self) -> Command {
        let mut command = Command::new(self.programs().join("python").with_extension(std::env::consts::EXE_EXTENSION));
        let path = std::env::var_os("PATH").unwrap_or_default();
        let folders = std::iter::once(self.programs()).chain(std::env::split_paths(&path));
        if let Ok(path) = std::env::join_paths(folders) {
            command.env("PATH", path);
        }
        command.env_remove("PYTHONHOME").env_remove("PYTHONPATH");
        command
    }

    /// The folder with a package's files.
    pub(crate) fn package(&self, name: &str) -> Result<PathBuf> {
        let script =
            "import importlib.util, sys; print(importlib.util.find_spec(sys.argv[1]).submodule_search_locations[0])";
        Ok(output(self.python().args(["-c", script, name]))?.trim().into())
    }
}

/// Returns pip's last error, which summarizes the others.
fn reason(output: &str) -> &str {
    let mut errors = output.lines().filter_map(|line| line.trim().strip_prefix("ERROR: "));
    errors.next_back().or(output.lines().last()).unwrap_or_default()
}

/// The first Python that is new enough: the one named by the environment variable PYTHON if set, otherwise one on PATH.
fn find() -> Result<Python> {
    let chosen = std::env::var("PYTHON").ok().filter(|python| !python.is_empty());
    let candidates = chosen.as_deref().map_or(CANDIDATES.to_vec(), |python| vec![python]);
    choose(candidates.into_iter().filter_map(describe).collect(), chosen.as_deref())
}

/// The first Python in `found` that is new enough. `chosen` is the value of PYTHON, for the error.
fn choose(found: Vec<Python>, chosen: Option<&str>) -> Result<Python> {
    let old: String = found.iter().map(|python| format!(" (but {})", python.description)).collect();
    found.into_iter().find(|python| python.version >= OLDEST).with_context(|| {
        let place = chosen.map_or("PATH has no".into(), |program| format!("PYTHON={program} is not"));
        let (major, minor) = OLDEST;
        format!(
            "{place} Python {major}.{minor} or newer with the modules venv and ensurepip{old}: install one (python.org, or \
             'apt install python3-venv'), or set PYTHON to its path; {WITHOUT}"
        )
    })
}

/// The version and path of a program, if it is a Python.
fn describe(program: &str) -> Option<Python> {
    parse(&output(Command::new(program).args(["-c", DESCRIBE])).ok()?)
}

fn parse(text: &str) -> Option<Python> {
    let mut lines = text.lines().map(str::trim);
    let (major, minor) = lines.next()?.split_once(' ')?;
    let version = (major.parse().ok()?, minor.parse().ok()?);
    let (full_version, program) = (lines.next()?, lines.next()?);
    let description = format!("Python {full_version} at {program}");
    Some(Python { program: program.into(), version, description })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn python(text: &str) -> Python {
        parse(text).unwrap()
    }

    #[test]
    fn the_first_python_that_is_new_enough_is_taken() {
        let found = vec![python("3 8\n3.8.1\n/a\n"), python("3 11\n3.11.2\n/b\n"), python("3 9\n3.9.18\n/c\n")];
        assert_eq!(choose(found, None).unwrap().program, Path::new("/b"));
        assert_eq!(parse("hello\n"), None);
        assert_eq!(describe("there-is-no-such-program"), None);
    }

    #[test]
    fn a_missing_python_is_one_sentence_with_the_remedy() {
        let remedy = "install one (python.org, or 'apt install python3-venv'), or set PYTHON to its path; 'cargo xtask fmu \
                      --native' needs no Python";
        let wanted = "Python 3.9 or newer with the modules venv and ensurepip";
        let error = |found, chosen| choose(found, chosen).unwrap_err().to_string();
        assert_eq!(error(vec![], None), format!("PATH has no {wanted}: {remedy}"));
        let old = vec![python("3 8\n3.8.1\n/a\n")];
        assert_eq!(error(old, Some("/x")), format!("PYTHON=/x is not {wanted} (but Python 3.8.1 at /a): {remedy}"));
    }

    #[test]
    fn of_pips_output_the_last_error_is_shown() {
        let output = "python -m pip ended with exit status: 1:\nWARNING: Retrying\nERROR: Could not find a version\nERROR: No \
                      matching distribution found for attrs==26.1.0\n[notice] x";
        assert_eq!(reason(output), "No matching distribution found for attrs==26.1.0");
        assert_eq!(reason("killed"), "killed");
    }

    #[cfg(unix)]
    #[test]
    fn an_environment_of_another_clone_is_used_as_it_is_and_never_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["tests", "target", "other"] {
            fs::create_dir(path(name)).unwrap();
        }
        fs::write(path("tests/requirements.txt"), "fmpy==1\n").unwrap();
        fs::write(path("other/plcfmu-stamp.txt"), "another Python").unwrap();
        std::os::unix::fs::symlink(path("other"), path("target/venv")).unwrap();
        let workspace = Workspace { root: path(""), target: path("target"), crates: Vec::new(), programs: None };
        let python = python("3 11\n3.11.2\n/a\n");
        let error = Environment::made_with(&python, &workspace).unwrap_err().to_string();
        assert!(error.contains("target/venv is a link to") && error.contains("other, which is out of date"), "{error}");
        assert_eq!(fs::read_to_string(path("other/plcfmu-stamp.txt")).unwrap(), "another Python");
        let stamp = format!("{}\n{}\n\nfmpy==1\n", path("other").display(), python.description);
        fs::write(path("other/plcfmu-stamp.txt"), stamp).unwrap();
        assert_eq!(Environment::made_with(&python, &workspace).unwrap().folder, path("other"));
    }
}
