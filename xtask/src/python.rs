//! The Python environment `target/venv`: made of the packages pinned in `tests/requirements.txt`, and made again when
//! that file or the Python has changed, or when making it was interrupted. It may be a link to that of another clone.

use crate::build::workspace::Workspace;
use crate::command::output;
use crate::progress::Progress;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The oldest Python that all of it runs in.
const OLDEST: (u32, u32) = (3, 9);

/// Which Pythons are looked for, in this order.
const CANDIDATES: &[&str] =
    &["python3", "python", "python3.13", "python3.12", "python3.11", "python3.10", "python3.9", "python3.14"];

/// Prints what tells one Python from another, and whether it can make environments. In an environment, such as our own
/// where somebody has activated it, that is the Python that it was made with.
const DESCRIBE: &str = "import os, sys
print(sys.version_info[0], sys.version_info[1])
print(sys.version.split()[0])
print(os.path.realpath(getattr(sys, '_base_executable', None) or sys.executable))
try:
    import venv, ensurepip
    print('venv')
except ImportError:
    print('no venv')
";

/// The environment, ready for use.
#[derive(Debug)]
pub struct Environment {
    folder: PathBuf,
}

/// A Python that an environment can be made with.
#[derive(Debug, PartialEq)]
struct Python {
    program: OsString,
    version: (u32, u32),
    /// Its full version and path.
    description: String,
    has_venv: bool,
}

impl Environment {
    /// The environment of a workspace; made if it is not there or out of date.
    ///
    /// # Errors
    /// There is no Python that is new enough, the packages cannot be installed, or the environment is a link to one that is
    /// out of date; with the remedy.
    pub fn ready(workspace: &Workspace) -> Result<Environment, String> {
        Environment::made_with(&find()?, workspace)
    }

    fn made_with(python: &Python, workspace: &Workspace) -> Result<Environment, String> {
        let requirements = workspace.root.join("tests/requirements.txt");
        let pinned = fs::read_to_string(&requirements)
            .map_err(|error| format!("{} cannot be read: {error}", requirements.display()))?;
        let place = workspace.target.join("venv");
        let linked = fs::read_link(&place).ok();
        let environment = Environment { folder: linked.clone().unwrap_or_else(|| place.clone()) };
        // Scripts in an environment name its folder, so one that was moved is out of date too.
        let wanted = format!("{}\n{}\n\n{pinned}", environment.folder.display(), python.description);
        let stamp = environment.folder.join("plcfmu-stamp.txt");
        if fs::read_to_string(&stamp).is_ok_and(|made_of| made_of == wanted) {
            return Ok(environment);
        }
        if let Some(other) = linked {
            return Err(format!(
                "{} is a link to {}, which is out of date: remove the link, or run 'cargo xtask test' where the other \
                 belongs",
                place.display(),
                other.display()
            ));
        }
        // Two commands at once: the second waits, and then finds what the first has made.
        fs::create_dir_all(&workspace.target)
            .map_err(|error| format!("{} cannot be made: {error}", workspace.target.display()))?;
        let lock = workspace.target.join("venv.lock");
        let lock = fs::File::create(&lock).map_err(|error| format!("{} cannot be made: {error}", lock.display()))?;
        lock.lock().map_err(|error| format!("target/venv.lock cannot be locked: {error}"))?;
        if fs::read_to_string(&stamp).is_ok_and(|made_of| made_of == wanted) {
            return Ok(environment);
        }
        environment.make(python, &requirements)?;
        // Written last: an environment without it is unfinished and made again.
        fs::write(&stamp, wanted).map_err(|error| format!("{} cannot be written: {error}", stamp.display()))?;
        Ok(environment)
    }

    fn make(&self, python: &Python, requirements: &Path) -> Result<(), String> {
        if !python.has_venv {
            return Err(format!(
                "{} cannot make environments (it has no modules venv and ensurepip): install them, on Debian and Ubuntu \
                 with 'apt install python3-venv'",
                python.description
            ));
        }
        let progress = Progress::spinner(&format!(
            "making the Python environment {} (once; it loads the packages of tests/requirements.txt)",
            self.folder.display()
        ));
        if self.folder.exists() {
            fs::remove_dir_all(&self.folder)
                .map_err(|error| format!("{} is out of date and cannot be removed: {error}", self.folder.display()))?;
        }
        output(Command::new(&python.program).args(["-m", "venv"]).arg(&self.folder))?;
        let mut install = self.python();
        install
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input"])
            .args(["--only-binary=:all:", "--requirement"])
            .arg(requirements);
        output(&mut install).map_err(|error| {
            format!(
                "the Python packages of {} cannot be installed; is there a connection to PyPI (or a mirror: \
                 PIP_INDEX_URL)?\n{error}",
                requirements.display()
            )
        })?;
        drop(progress);
        Ok(())
    }

    /// Its programs.
    pub fn programs(&self) -> PathBuf {
        self.folder.join(if cfg!(windows) { "Scripts" } else { "bin" })
    }

    /// A command that runs its Python, with its programs first on PATH.
    pub fn python(&self) -> Command {
        self.program("python")
    }

    /// A command that runs one of its programs, with its programs first on PATH.
    pub fn program(&self, name: &str) -> Command {
        let mut command = Command::new(self.programs().join(name).with_extension(std::env::consts::EXE_EXTENSION));
        let path = std::env::var_os("PATH").unwrap_or_default();
        let folders = std::iter::once(self.programs()).chain(std::env::split_paths(&path));
        if let Ok(path) = std::env::join_paths(folders) {
            command.env("PATH", path);
        }
        command.env_remove("PYTHONHOME").env_remove("PYTHONPATH");
        command
    }

    /// The folder of a package's files.
    ///
    /// # Errors
    /// Python cannot find it.
    pub fn package(&self, name: &str) -> Result<PathBuf, String> {
        let script =
            "import importlib.util, sys; print(importlib.util.find_spec(sys.argv[1]).submodule_search_locations[0])";
        Ok(output(self.python().args(["-c", script, name]))?.trim().into())
    }
}

/// The first Python that is new enough: that of the variable PYTHON if it is set, else one on PATH.
fn find() -> Result<Python, String> {
    let chosen = std::env::var_os("PYTHON").filter(|python| !python.is_empty());
    let candidates = match &chosen {
        Some(python) => vec![python.clone()],
        None => CANDIDATES.iter().map(OsString::from).collect(),
    };
    choose(candidates.into_iter().filter_map(describe).collect()).map_err(|found| refusal(chosen.as_deref(), &found))
}

/// That there is no Python to use, and what to do.
fn refusal(chosen: Option<&OsStr>, found: &[String]) -> String {
    let state = match (chosen, found) {
        (Some(program), []) => format!("PYTHON = {} is none", program.display()),
        (Some(program), [found, ..]) => format!("PYTHON = {} is {found}", program.display()),
        (None, []) => "there is none on PATH".to_string(),
        (None, found) => format!("on PATH there is only {}", found.join(", ")),
    };
    format!(
        "Python {}.{} or newer is needed, and {state}: install it (python.org, or 'apt install python3-venv'), or name \
         one by the variable PYTHON; 'cargo xtask fmu --native' needs none",
        OLDEST.0, OLDEST.1
    )
}

/// The first that is new enough; prefers one that can make environments.
fn choose(found: Vec<Python>) -> Result<Python, Vec<String>> {
    let descriptions = found.iter().map(|python| python.description.clone()).collect();
    let mut new_enough: Vec<Python> = found.into_iter().filter(|python| python.version >= OLDEST).collect();
    if new_enough.is_empty() {
        return Err(descriptions);
    }
    let place = new_enough.iter().position(|python| python.has_venv).unwrap_or(0);
    Ok(new_enough.swap_remove(place))
}

/// What a program says of itself, if it is a Python.
fn describe(program: OsString) -> Option<Python> {
    parse(&output(Command::new(&program).args(["-c", DESCRIBE])).ok()?)
}

fn parse(text: &str) -> Option<Python> {
    let mut lines = text.lines();
    let (major, minor) = lines.next()?.split_once(' ')?;
    let version = (major.parse().ok()?, minor.trim().parse().ok()?);
    let (full_version, program) = (lines.next()?.trim(), lines.next()?.trim());
    let description = format!("Python {full_version} at {program}");
    Some(Python { program: program.into(), version, description, has_venv: lines.next()?.trim() == "venv" })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn python(text: &str) -> Python {
        parse(text).unwrap()
    }

    #[test]
    fn the_first_python_that_is_new_enough_and_makes_environments_is_taken() {
        let old = || python("3 8\n3.8.1\n/a\nvenv\n");
        let bare = || python("3 11\n3.11.2\n/b\nno venv\n");
        let good = || python("3 9\n3.9.18\n/c\nvenv\n");
        assert_eq!(choose(vec![old(), bare(), good()]).unwrap().program, "/c");
        assert_eq!(choose(vec![old(), bare()]).unwrap().program, "/b");
        assert_eq!(choose(vec![old()]).unwrap_err(), ["Python 3.8.1 at /a"]);
        assert_eq!(choose(vec![]).unwrap_err(), [""; 0]);
    }

    #[test]
    fn a_missing_python_is_one_sentence_with_the_remedy() {
        let remedy = "install it (python.org, or 'apt install python3-venv'), or name one by the variable PYTHON; \
                      'cargo xtask fmu --native' needs none";
        let old = || vec!["Python 3.8.1 at /a".to_string()];
        let named = Some(OsStr::new("/x"));
        for (chosen, found, state) in [
            (None, vec![], "there is none on PATH"),
            (None, old(), "on PATH there is only Python 3.8.1 at /a"),
            (named, vec![], "PYTHON = /x is none"),
            (named, old(), "PYTHON = /x is Python 3.8.1 at /a"),
        ] {
            assert_eq!(refusal(chosen, &found), format!("Python 3.9 or newer is needed, and {state}: {remedy}"));
        }
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
        let workspace = Workspace { root: path(""), target: path("target"), crates: Vec::new() };
        let python = python("3 11\n3.11.2\n/a\nvenv\n");
        let error = Environment::made_with(&python, &workspace).unwrap_err();
        assert!(error.contains("target/venv is a link to") && error.contains("other, which is out of date"), "{error}");
        assert_eq!(fs::read_to_string(path("other/plcfmu-stamp.txt")).unwrap(), "another Python");
        let stamp = format!("{}\n{}\n\nfmpy==1\n", path("other").display(), python.description);
        fs::write(path("other/plcfmu-stamp.txt"), stamp).unwrap();
        assert_eq!(Environment::made_with(&python, &workspace).unwrap().folder, path("other"));
    }

    #[test]
    fn what_is_no_python_is_passed_over() {
        assert_eq!(parse("hello\n"), None);
        assert_eq!(parse(""), None);
        assert_eq!(describe("there-is-no-such-program".into()), None);
    }
}
