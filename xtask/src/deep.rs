//! What `cargo xtask test --deep` adds: the tests that call the libraries' C functions, in Rust and in Python, under
//! valgrind, where every read and write is watched and every leak counted; and those in Rust with far more cases.

use crate::test::heading;
use plcfmu::build::python::Environment;
use plcfmu::build::workspace::{self, Workspace};
use plcfmu::command::{output, run};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// The tests in Python that call every function, in every state.
const CONFORMANCE: [&str; 2] = ["tests/test_conformance.py", "tests/test_fmu_state.py"];

/// How much each test tries under valgrind, which takes fifty times as long, ...
const WATCHED: &[(&str, &str)] = &[
    ("PLCFMU_HOSTILE_CALLS", "60000"),
    ("PLCFMU_THREADS_ROUNDS", "4"),
    ("PLCFMU_TIME_CALLS", "200000"),
    ("PLCFMU_TIME_STEPS", "20000"),
    ("PLCFMU_TIME_ROUNDS", "1"),
];

/// ... and how much without: 25 to 100 times as much as the test command.
const MANY: &[(&str, &str)] = &[
    ("PLCFMU_HOSTILE_CALLS", "30000000"),
    ("PLCFMU_HOSTILE_SEED", "2"),
    ("PLCFMU_THREADS_ROUNDS", "20000"),
    ("PLCFMU_TIME_CALLS", "5000000000"),
    ("PLCFMU_TIME_STEPS", "500000000"),
    ("PLCFMU_TIME_ROUNDS", "2000"),
];

/// Checks that valgrind is there.
///
/// # Errors
/// How to get it.
pub fn ready() -> Result<(), String> {
    output(Command::new("valgrind").arg("--version")).map(|_| ()).map_err(|_| {
        "--deep needs valgrind: install it, on Debian and Ubuntu with 'apt install valgrind'; without --deep the tests \
         need none"
            .into()
    })
}

/// Runs the tests.
///
/// # Errors
/// The first program that fails, or what valgrind has found.
pub fn test(workspace: &Workspace, environment: &Environment) -> Result<(), String> {
    let programs = programs(workspace)?;
    heading("Rust tests of the libraries under valgrind");
    for program in &programs {
        let mut valgrind = valgrind();
        valgrind.arg("--error-exitcode=1").arg(program);
        run(valgrind.envs(WATCHED.iter().copied()).current_dir(&workspace.root))?;
    }
    heading("Python tests of the packed FMUs under valgrind");
    conformance(workspace, environment)?;
    heading("Rust tests of the libraries with many more cases");
    for program in &programs {
        run(Command::new(program).envs(MANY.iter().copied()).current_dir(&workspace.root))?;
    }
    Ok(())
}

fn valgrind() -> Command {
    let mut valgrind = Command::new("valgrind");
    // What Rust's standard library keeps for each thread counts as "possibly lost".
    valgrind.args(["--quiet", "--leak-check=full", "--show-leak-kinds=definite", "--errors-for-leak-kinds=definite"]);
    valgrind
}

/// Python and its packages have leaks of their own, other ones in every version: what counts are the reports in which an
/// FMU's library occurs.
fn conformance(workspace: &Workspace, environment: &Environment) -> Result<(), String> {
    let log = workspace.target.join("valgrind.log");
    let mut valgrind = valgrind();
    // A library's name is wanted even where it has been unloaded before the leak is reported.
    valgrind.arg("--keep-debuginfo=yes").arg(format!("--log-file={}", log.display()));
    valgrind.arg(environment.programs().join("python")).args(["-m", "pytest", "-q"]).args(CONFORMANCE);
    // Python's own allocator would hide a block's bounds.
    valgrind.env("PYTHONMALLOC", "malloc").env("PLCFMU_FMUS", workspace.fmus());
    run(valgrind.current_dir(&workspace.root))?;
    let text = fs::read(&log).map_err(|error| format!("{} cannot be read: {error}", log.display()))?;
    let reports = reports(&String::from_utf8_lossy(&text));
    if reports.is_empty() {
        return Ok(());
    }
    Err(format!("valgrind reports of the FMUs' libraries:\n\n{}\n\nall of it: {}", reports.join("\n\n"), log.display()))
}

/// The reports in valgrind's log in which the library of an FMU occurs.
fn reports(log: &str) -> Vec<String> {
    let lines: Vec<&str> =
        log.lines().map(|line| line.trim_start_matches(|c: char| c == '=' || c.is_ascii_digit())).collect();
    let of_an_fmu = |report: &&[&str]| report.iter().any(|line| line.contains("/binaries/"));
    lines.split(|line| line.trim().is_empty()).filter(of_an_fmu).map(|report| report.join("\n")).collect()
}

/// Builds the test programs of the package `tests` and says where they are.
fn programs(workspace: &Workspace) -> Result<Vec<PathBuf>, String> {
    let mut build = workspace::cargo();
    build.args(["test", "--package", "tests", "--test", "*", "--no-run", "--message-format=json-render-diagnostics"]);
    Ok(output(build.current_dir(&workspace.root))?.lines().filter_map(program).collect())
}

/// The test program that a message of cargo tells of.
fn program(message: &str) -> Option<PathBuf> {
    let message: Value = serde_json::from_str(message).ok()?;
    let is_test = message["reason"] == "compiler-artifact" && message["profile"]["test"] == true;
    message["executable"].as_str().filter(|_| is_test).map(PathBuf::from)
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
==7==    at 0x4A: get_real (in /tmp/PUMP0/binaries/linux64/PUMP.so)
==7==    by 0x4B: ??? (in /usr/lib/libffi.so)
==7==
";
        assert_eq!(
            reports(log),
            [" Invalid write of size 4\n    at 0x4A: get_real (in /tmp/PUMP0/binaries/linux64/PUMP.so)\n    by 0x4B: \
              ??? (in /usr/lib/libffi.so)"]
        );
    }

    #[test]
    fn cargo_tells_where_a_test_program_is() {
        let message = |test: bool, executable: &str| {
            format!(r#"{{"reason": "compiler-artifact", "profile": {{"test": {test}}}, "executable": {executable}}}"#)
        };
        assert_eq!(program(&message(true, r#""/t/hostile-1""#)), Some("/t/hostile-1".into()));
        assert_eq!(program(&message(true, "null")), None);
        assert_eq!(program(&message(false, r#""/t/xtask""#)), None);
    }
}
