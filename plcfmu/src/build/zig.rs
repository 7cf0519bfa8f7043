//! Finds cargo-zigbuild and zig, which link libraries for Linux against an old glibc, and for other platforms. Nothing
//! is installed.

use crate::build::workspace::{self, Workspace};
use crate::command::output;
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A script that prints the program folders of a Python environment, and whether it has the module `ziglang`.
const DESCRIBE: &str = "import importlib.util, os, sysconfig
print(sysconfig.get_path('scripts'))
print(sysconfig.get_path('scripts', os.name + '_user'))
print('ziglang' if importlib.util.find_spec('ziglang') else 'no ziglang')
";

/// The interpreter in a Python environment.
const VENV_PYTHON: &str = if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" };

/// cargo-zigbuild, and the zig that it calls.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Zig {
    cargo_zigbuild: PathBuf,
    /// The environment variable for zig, or for the Python that contains it as a module, and its value.
    zig: (&'static str, PathBuf),
}

/// The tools in a program folder or a Python environment.
#[derive(Debug, Default, PartialEq)]
struct Offer {
    cargo_zigbuild: Option<PathBuf>,
    zig: Option<(&'static str, PathBuf)>,
}

impl Zig {
    /// Searches the Python environment `venv` below `target`, the active Python environment, PATH, and the environment
    /// of the `python3` on PATH, in this order. The two programs may be in different places.
    pub fn find(workspace: &Workspace) -> Option<Zig> {
        let own = Some(workspace.target.join("venv").join(VENV_PYTHON)).filter(|python| python.is_file());
        let active = env::var_os("VIRTUAL_ENV").map(|folder| PathBuf::from(folder).join(VENV_PYTHON));
        let offers = [
            own.and_then(|python| in_python(&python, &workspace.root)),
            active.and_then(|python| in_python(&python, &workspace.root)),
            Some(on_path()),
            in_python(Path::new(if cfg!(windows) { "python" } else { "python3" }), &workspace.root),
        ];
        choose(offers.into_iter().flatten())
    }

    /// The command `cargo zigbuild`, which calls `cargo` and keeps zig's own build results in `cache`.
    pub fn build(&self, cargo: &Command, cache: &Path) -> Command {
        let mut command = Command::new(&self.cargo_zigbuild);
        workspace::forget_package(&mut command);
        command.arg("zigbuild").env(self.zig.0, &self.zig.1).env("CARGO", cargo.get_program());
        for variable in ["ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR", "CARGO_ZIGBUILD_CACHE_DIR"] {
            command.env(variable, cache);
        }
        command
    }
}

/// Chooses the first cargo-zigbuild and the first zig.
fn choose(offers: impl Iterator<Item = Offer>) -> Option<Zig> {
    let mut found = Offer::default();
    for offer in offers {
        found.cargo_zigbuild = found.cargo_zigbuild.or(offer.cargo_zigbuild);
        found.zig = found.zig.or(offer.zig);
    }
    Some(Zig { cargo_zigbuild: found.cargo_zigbuild?, zig: found.zig? })
}

fn on_path() -> Offer {
    let path = env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = env::split_paths(&path).collect();
    Offer {
        cargo_zigbuild: program(&folders, "cargo-zigbuild"),
        zig: program(&folders, "zig").map(|zig| ("CARGO_ZIGBUILD_ZIG_PATH", zig)),
    }
}

/// The tools in an interpreter's environment. The interpreter is started in the workspace's folder, because it also
/// imports modules from its current folder.
fn in_python(python: &Path, root: &Path) -> Option<Offer> {
    Some(offer(python, &output(Command::new(python).args(["-c", DESCRIBE]).current_dir(root)).ok()?))
}

fn offer(python: &Path, description: &str) -> Offer {
    let folders: Vec<PathBuf> = description.lines().take(2).map(PathBuf::from).collect();
    let has_zig = description.lines().nth(2) == Some("ziglang");
    Offer {
        cargo_zigbuild: program(&folders, "cargo-zigbuild"),
        zig: has_zig.then(|| ("CARGO_ZIGBUILD_PYTHON_PATH", python.to_path_buf())),
    }
}

/// Whether PATH has a program with this name.
pub fn is_on_path(name: &str) -> bool {
    let path = env::var_os("PATH").unwrap_or_default();
    program(&env::split_paths(&path).collect::<Vec<_>>(), name).is_some()
}

/// The program with this name in the first folder that has it.
fn program(folders: &[PathBuf], name: &str) -> Option<PathBuf> {
    let name = format!("{name}{}", env::consts::EXE_SUFFIX);
    folders.iter().map(|folder| folder.join(&name)).find(|program| program.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn zig_and_cargo_zigbuild_may_come_from_different_places_and_the_first_counts() {
        let build = |path: &str| Offer { cargo_zigbuild: Some(path.into()), zig: None };
        let zig = |path: &str| Offer { cargo_zigbuild: None, zig: Some(("CARGO_ZIGBUILD_ZIG_PATH", path.into())) };
        let found = choose([build("/a"), zig("/b"), build("/c"), zig("/d")].into_iter()).unwrap();
        assert_eq!(found, Zig { cargo_zigbuild: "/a".into(), zig: ("CARGO_ZIGBUILD_ZIG_PATH", "/b".into()) });
        assert_eq!(choose([build("/a"), build("/c")].into_iter()), None);
        assert_eq!(choose([zig("/b")].into_iter()), None);
    }

    #[test]
    fn a_python_environment_offers_its_program_and_its_module() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join(format!("cargo-zigbuild{}", env::consts::EXE_SUFFIX));
        fs::write(&program, "").unwrap();
        let description = |zig: &str| format!("/no/such/folder\n{}\n{zig}\n", folder.path().display());
        let python = Path::new("/x/python");
        let zig = Some(("CARGO_ZIGBUILD_PYTHON_PATH", python.to_path_buf()));
        assert_eq!(offer(python, &description("ziglang")), Offer { cargo_zigbuild: Some(program.clone()), zig });
        assert_eq!(offer(python, &description("no ziglang")), Offer { cargo_zigbuild: Some(program), zig: None });
        assert_eq!(offer(python, ""), Offer::default());
    }
}
