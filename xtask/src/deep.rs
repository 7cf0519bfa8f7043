//! What `cargo xtask test --deep` adds: the tests that call the libraries' C functions, under valgrind, where every read
//! and write is watched and every leak counted; and the same tests with far more cases.

use crate::command::{output, run};
use crate::test::heading;
use crate::workspace::{self, Workspace};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;

/// How much each test tries under valgrind, which takes fifty times as long, ...
const WATCHED: &[(&str, &str)] = &[
    ("PLCFMU_HOSTILE_CALLS", "60000"),
    ("PLCFMU_THREADS_ROUNDS", "4"),
    ("PLCFMU_TIME_CALLS", "200000"),
    ("PLCFMU_TIME_STEPS", "20000"),
    ("PLCFMU_TIME_ROUNDS", "1"),
];

/// ... and how much without: some twenty times as much as the test command.
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
/// The first program that fails; it has said what.
pub fn test(workspace: &Workspace) -> Result<(), String> {
    let programs = programs(workspace)?;
    heading("Rust tests of the libraries under valgrind");
    for program in &programs {
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--quiet", "--error-exitcode=1", "--leak-check=full"]);
        // What Rust's standard library keeps for each thread counts as "possibly lost".
        valgrind.args(["--show-leak-kinds=definite", "--errors-for-leak-kinds=definite"]);
        run(valgrind.arg(program).envs(WATCHED.iter().copied()).current_dir(&workspace.root))?;
    }
    heading("Rust tests of the libraries with many more cases");
    for program in &programs {
        run(Command::new(program).envs(MANY.iter().copied()).current_dir(&workspace.root))?;
    }
    Ok(())
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
    fn cargo_tells_where_a_test_program_is() {
        let message = |test: bool, executable: &str| {
            format!(r#"{{"reason": "compiler-artifact", "profile": {{"test": {test}}}, "executable": {executable}}}"#)
        };
        assert_eq!(program(&message(true, r#""/t/hostile-1""#)), Some("/t/hostile-1".into()));
        assert_eq!(program(&message(true, "null")), None);
        assert_eq!(program(&message(false, r#""/t/xtask""#)), None);
    }
}
