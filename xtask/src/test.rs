//! `cargo xtask test`: runs all tests of the project.

use crate::deep;
use crate::python::Environment;
use crate::steps::Steps;
use anyhow::{Context, Result};
use plcfmu::build::compile::{Linkage, compile};
use plcfmu::build::platform::Platform;
use plcfmu::build::workspace::{self, Workspace};
use plcfmu::command::{output, run};
use plcfmu::package::pack;
use plcfmu::package::version::{Fmi, Version};
use plcfmu::tool::make;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Which tests to run.
#[derive(clap::Args, Clone, Debug, Default)]
pub(crate) struct Options {
    /// Also run the slow tests, the library tests under valgrind, and the random tests with far more cases (one more
    /// hour)
    #[arg(long)]
    pub deep: bool,
    /// Also test the libraries for other platforms, under Wine and qemu: .ci/platforms (one more hour)
    #[arg(long)]
    pub platforms: bool,
    /// Arguments for pytest, such as -k NAME
    #[arg(last = true, value_name = "PYTEST ARGUMENTS")]
    pub pytest: Vec<OsString>,
}

/// Runs the tests.
pub(crate) fn test(workspace: &Workspace, options: &Options) -> Result<()> {
    // First check for missing tools, so that the user does not wait in vain.
    if options.deep {
        deep::ready()?;
    }
    let mut steps = Steps::new(5 + usize::from(options.deep) + usize::from(options.platforms));
    let environment = Environment::ready(workspace)?;
    steps.begin("FMUs");
    pack::run(workspace, &pack::Options::default())?;
    let newer = workspace.target.join("fmu3");
    let version = Version { fmi: Fmi::Three, ..Version::default() };
    pack::run(workspace, &pack::Options { version, out: Some(newer.clone()), ..pack::Options::default() })?;
    steps.begin("Rust tests");
    // The whole workspace, so that new packages are tested too; all failures, because a run takes minutes.
    let mut tests = workspace::cargo();
    tests.args(["test", "--workspace", "--no-fail-fast"]).env("PLCFMU_LIBRARIES", libraries(workspace)?);
    run(tests.current_dir(&workspace.root))?;
    steps.begin("the parameter tool");
    let files = [("PLCFMU_FMUS", workspace.fmus()), ("PLCFMU_FMI3", newer), ("PLCFMU_TOOL", make::place(workspace))];
    let variables: Vec<_> =
        libclang(&environment)?.into_iter().chain(files.map(|(name, path)| (name, path.into_os_string()))).collect();
    page(workspace)?;
    steps.begin("other importers in Rust");
    let mut importers = workspace::cargo();
    importers.args(["test", "--locked", "--manifest-path", "tests/importers/Cargo.toml"]);
    // Compile the dependencies of both workspaces only once.
    importers.arg("--target-dir").arg(&workspace.target);
    run(importers.current_dir(&workspace.root).envs(variables.clone()))?;
    steps.begin("Python tests");
    let mut pytest = environment.python();
    // In the order defined by tests/conftest.py, not by the number of tests per file.
    pytest.args(["-m", "pytest", "tests", "-nauto", "--dist=loadfile", "--no-loadscope-reorder"]).args(&options.pytest);
    // The site's page "What was tested" is generated from these results, which must be complete.
    if options.pytest.is_empty() {
        pytest.env("PLCFMU_RESULTS", workspace.target.join("results"));
    }
    run(pytest.envs(variables.clone()).current_dir(&workspace.root))?;
    if options.deep {
        steps.begin("deep tests");
        deep::test(workspace, &environment, &variables)?;
    }
    if options.platforms {
        steps.begin("other platforms");
        run(Command::new(workspace.root.join(".ci/platforms")).current_dir(&workspace.root))?;
    }
    Ok(())
}

/// Builds the libraries of all FMU crates, including those in `tests/fmus`, and the program library; returns the folder
/// to which they were copied.
fn libraries(workspace: &Workspace) -> Result<PathBuf> {
    let host = Platform::host(&workspace.root)?;
    let linkage = Linkage::choose(workspace, &host, false);
    let folder = workspace.target.join("libraries");
    // A crate may have been removed since the last run, and its library with it.
    remove(&folder, |folder| fs::remove_dir_all(folder))?;
    fs::create_dir_all(&folder)?;
    let crates: Vec<_> = workspace.crates.iter().chain(&workspace.programs).cloned().collect();
    for library in compile(workspace, &crates, &host, &linkage)?.values() {
        fs::copy(library, folder.join(library.file_name().unwrap_or_default()))?;
    }
    Ok(folder)
}

/// Builds the page of the parameter tool. If its engine cannot be compiled, removes any old page, and its tests are
/// skipped.
fn page(workspace: &Workspace) -> Result<()> {
    match make::run(workspace, &make::Options { fmus: Some(workspace.fmus()), out: None }) {
        Err(error) if error.is::<make::Missing>() => {
            println!("skipped, including its tests: {error:#}");
            remove(&make::place(workspace), |page| fs::remove_file(page))
        }
        made => made,
    }
}

/// Removes the leftovers of an earlier run, if there are any.
fn remove(path: &Path, how: impl FnOnce(&Path) -> io::Result<()>) -> Result<()> {
    if path.exists() {
        how(path).with_context(|| format!("{} cannot be removed", path.display()))?;
    }
    Ok(())
}

/// The environment variables through which bindgen, needed by tests/importers, finds libclang; empty if the user has
/// set LIBCLANG_PATH.
fn libclang(environment: &Environment) -> Result<Vec<(&'static str, OsString)>> {
    if std::env::var_os("LIBCLANG_PATH").is_some() {
        return Ok(Vec::new());
    }
    let mut variables = vec![("LIBCLANG_PATH", environment.package("clang")?.join("native").into_os_string())];
    // The libclang from PyPI lacks a compiler's own headers.
    variables.extend(compiler_headers().map(|include| ("BINDGEN_EXTRA_CLANG_ARGS", format!("-I{include}").into())));
    Ok(variables)
}

/// The folder in which a gcc-like C compiler has stddef.h.
fn compiler_headers() -> Option<String> {
    let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
    let include = output(Command::new(compiler).arg("-print-file-name=include")).ok()?.trim().to_string();
    Path::new(&include).join("stddef.h").is_file().then_some(include)
}
