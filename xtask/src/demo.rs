//! `cargo xtask demo`: runs the closed loops in `examples/`, each a separate Python program.

use crate::python::Environment;
use crate::steps::Steps;
use anyhow::{Context, Result, bail};
use plcfmu::build::compile::artifacts;
use plcfmu::build::workspace::{self, Workspace};
use plcfmu::command::run;
use plcfmu::package::pack;
use std::fs;
use std::path::{Path, PathBuf};

/// The options of the demo.
#[derive(clap::Args, Clone, Debug, Default)]
pub(crate) struct Options {
    /// Loops to run, such as cascade [default: all]
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
}

/// Packs the FMUs and runs the loops; each prints its figures.
pub(crate) fn demo(workspace: Workspace, options: &Options) -> Result<()> {
    // No loop runs a program, and the program library takes a long time to compile.
    let workspace = &Workspace { programs: None, ..workspace };
    let loops = choose(find(&workspace.root.join("examples"))?, &options.names)?;
    let mut steps = Steps::new(2 + loops.len());
    let environment = Environment::ready(workspace)?;
    steps.begin("FMUs");
    pack::run(workspace, &pack::Options::default())?;
    steps.begin("the command");
    let command = build_command(workspace)?;
    let results = workspace.target.join("demo");
    for program in loops {
        steps.begin(&name(&program));
        let mut python = environment.python();
        python.arg(&program).arg("--fmus").arg(workspace.fmus()).arg("--out").arg(&results);
        // The examples import the Python package, which calls the command for figures.
        python.env("PYTHONPATH", workspace.root.join("plcfmu/python")).env("PLCFMU_COMMAND", &command);
        run(python.current_dir(&workspace.root))?;
    }
    println!("\nCSV, PNG and SVG files: {}", workspace.shown(&results));
    Ok(())
}

/// Builds the command `plcfmu`, most of which is already part of this program, and returns its path.
fn build_command(workspace: &Workspace) -> Result<PathBuf> {
    let mut build = workspace::cargo();
    // Both packages, so that cargo uses the union of their features, as it did for this program.
    build.args(["build", "--quiet", "--package", "plcfmu", "--package", "xtask", "--bin", "plcfmu"]);
    let built = artifacts(build.current_dir(&workspace.root))?;
    let executable = built.into_iter().find_map(|artifact| artifact.executable);
    Ok(executable.context("cargo did not build plcfmu")?.into())
}

/// The loops in a folder: the Python files that are programs; the other files are shared modules.
fn find(folder: &Path) -> Result<Vec<PathBuf>> {
    let failed = || folder.display().to_string();
    let mut loops = Vec::new();
    for entry in fs::read_dir(folder).with_context(failed)? {
        let path = entry.with_context(failed)?.path();
        let is_python = path.extension().is_some_and(|extension| extension == "py");
        if is_python && fs::read_to_string(&path).with_context(failed)?.contains("__name__ == \"__main__\"") {
            loops.push(path);
        }
    }
    loops.sort();
    Ok(loops)
}

fn name(program: &Path) -> String {
    program.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn choose(loops: Vec<PathBuf>, names: &[String]) -> Result<Vec<PathBuf>> {
    if names.is_empty() {
        return Ok(loops);
    }
    let is = |program: &Path, asked: &str| name(program).eq_ignore_ascii_case(asked.trim_end_matches(".py"));
    if let Some(unknown) = names.iter().find(|asked| !loops.iter().any(|program| is(program, asked))) {
        let known: Vec<_> = loops.iter().map(|program| name(program)).collect();
        bail!("no demo {unknown}; available: {}", known.join(", "));
    }
    Ok(loops.into_iter().filter(|program| names.iter().any(|asked| is(program, asked))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_demo_is_chosen_by_its_name() {
        let loops = || vec![PathBuf::from("examples/cascade.py"), PathBuf::from("examples/ramp.py")];
        assert_eq!(choose(loops(), &[]).unwrap(), loops());
        assert_eq!(choose(loops(), &["Ramp".into()]).unwrap(), loops()[1..]);
        assert_eq!(choose(loops(), &["cascade.py".into()]).unwrap(), loops()[..1]);
        assert_eq!(
            choose(loops(), &["ramps".into()]).unwrap_err().to_string(),
            "no demo ramps; available: cascade, ramp"
        );
    }

    #[test]
    fn a_demo_is_a_python_file_that_is_a_program() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write("shared.py", "def f(): pass\n");
        write("b.py", "if __name__ == \"__main__\":\n    main()\n");
        write("a.py", "if __name__ == \"__main__\":\n    main()\n");
        write("c.txt", "__name__ == \"__main__\"");
        let names: Vec<_> = find(folder.path()).unwrap().iter().map(|program| name(program)).collect();
        assert_eq!(names, ["a", "b"]);
    }
}
