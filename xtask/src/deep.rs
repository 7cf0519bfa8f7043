//! The additional tests of `cargo xtask test --deep`: the Python tests marked as deep; the Rust and Python tests that
//! call the libraries' C functions, under valgrind, which checks every memory access and reports every leak; and the
//! Rust tests with far more cases.

use crate::python::Environment;
use anyhow::{Context, Result, bail};
use plcfmu::build::compile::artifacts;
use plcfmu::build::workspace::{self, Workspace};
use plcfmu::command::{heading, output, run};
use std::ffi::OsString;
use std::fs;
use std::process::Command;

/// The Python tests that call every function in every state.
const CONFORMANCE: [&str; 2] = ["tests/test_conformance.py", "tests/test_fmu_state.py"];

/// The environment variables of the random tests, each with its value under valgrind, which slows tests down fiftyfold,
/// and its value without valgrind, for 25 to 100 times the usual number of cases.
const CASES: [(&str, &str, &str); 6] = [
    ("PLCFMU_HOSTILE_SEED", "1", "2"),
    ("PLCFMU_HOSTILE_CALLS", "60000", "30000000"),
    ("PLCFMU_THREADS_ROUNDS", "4", "20000"),
    ("PLCFMU_TIME_CALLS", "200000", "5000000000"),
    ("PLCFMU_TIME_STEPS", "20000", "500000000"),
    ("PLCFMU_TIME_ROUNDS", "1", "2000"),
];

/// Checks that valgrind is installed.
pub(crate) fn ready() -> Result<()> {
    let version = output(Command::new("valgrind").arg("--version"));
    version.context("--deep needs valgrind: on Debian and Ubuntu 'apt install valgrind'").map(|_| ())
}

/// Runs the tests. `variables` are environment variables without which some Python tests are skipped.
pub(crate) fn test(workspace: &Workspace, environment: &Environment, variables: &[(&str, OsString)]) -> Result<()> {
    heading("slow Python tests");
    let mut pytest = environment.python();
    pytest.args(["-m", "pytest", "tests", "-m", "deep", "-nauto", "--dist=loadfile"]);
    run(pytest.envs(variables.iter().cloned()).current_dir(&workspace.root))?;
    let mut build = workspace::cargo();
    build.args(["test", "--package", "tests", "--test", "*", "--no-run"]).current_dir(&workspace.root);
    let programs: Vec<_> = artifacts(&mut build)?.into_iter().filter_map(|artifact| artifact.executable).collect();
    heading("Rust tests of the libraries under valgrind");
    for program in &programs {
        let mut valgrind = valgrind();
        valgrind.arg("--error-exitcode=1").arg(program).current_dir(&workspace.root);
        run(valgrind.envs(CASES.map(|(variable, watched, _)| (variable, watched))))?;
    }
    heading("Python tests of the packed FMUs under valgrind");
    conformance(workspace, environment)?;
    heading("Rust tests of the libraries with far more cases");
    for program in &programs {
        let many = CASES.map(|(variable, _, many)| (variable, many));
        run(Command::new(program).envs(many).current_dir(&workspace.root))?;
    }
    Ok(())
}

fn valgrind() -> Command {
    let mut valgrind = Command::new("valgrind");
    // Only definite leaks: thread-local data of Rust's standard library would be reported as "possibly lost".
    valgrind.args(["--quiet", "--leak-check=full", "--show-leak-kinds=definite", "--errors-for-leak-kinds=definite"]);
    valgrind
}

/// Runs the conformance tests under valgrind. Python and its packages leak, differently in every version, so only
/// reports that mention an FMU's library count.
fn conformance(workspace: &Workspace, environment: &Environment) -> Result<()> {
    let log = workspace.target.join("valgrind.log");
    let mut valgrind = valgrind();
    // Keep the library's name even if the library is unloaded before the leak is reported.
    valgrind.arg("--keep-debuginfo=yes").arg(format!("--log-file={}", log.display()));
    valgrind.arg(environment.programs().join("python")).args(["-m", "pytest", "-q"]).args(CONFORMANCE);
    // Python's own allocator would hide out-of-bounds accesses.
    valgrind.env("PYTHONMALLOC", "malloc").env("PLCFMU_FMUS", workspace.fmus());
    run(valgrind.current_dir(&workspace.root))?;
    let text = fs::read(&log).with_context(|| log.display().to_string())?;
    let reports = reports(&String::from_utf8_lossy(&text));
    if !reports.is_empty() {
        bail!("valgrind's reports on the FMUs' libraries:\n\n{}\n\nfull log: {}", reports.join("\n\n"), log.display());
    }
    Ok(())
}

/// The reports in valgrind's log that mention an FMU's library.
fn reports(log: &str) -> Vec<String> {
    let lines: Vec<&str> =
        log.lines().map(|line| line.trim_start_matches(|c: char| c == '=' || c.is_ascii_digit())).collect();
    let is_of_an_fmu = |report: &&[&str]| report.iter().any(|line| line.contains("/binaries/"));
    lines.split(|line| line.trim().is_empty()).filter(is_of_an_fmu).map(|report| report.join("\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_valgrinds_log_only_what_concerns_an_fmu_is_reported() {
        let log = "\
==7== 8 bytes in 1 blocks are definitely lost in loss record 1 of 2
==7==    at 0x48: malloc (in /usr/libexec/valgrind/vgpreload_memcheck-amd64-linux.so)
==7==    by 0x49: ??? (in /venv/lib/etree.so)
==7==
==7== Invalid write of size 4
==7==    at 0x4A: ??? (in /tmp/PUMP0/binaries/linux64/PUMP.so)
==7==    by 0x4B: ??? (in /usr/lib/libffi.so)
==7==
";
        assert_eq!(
            reports(log),
            [" Invalid write of size 4\n    at 0x4A: ??? (in /tmp/PUMP0/binaries/linux64/PUMP.so)\n    by 0x4B: \
              ??? (in /usr/lib/libffi.so)"]
        );
    }
}
