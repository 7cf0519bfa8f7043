//! Exit codes, and the errors that select them.

use anyhow::Error;
use host::machine::Fault;
use parameters::Problems;
use parameters::problem::each_drawn;
use std::fmt;
use std::process::ExitCode;
use study::Interrupted;

/// The problems of a file, each shown with its line in the file. The exit code is 3.
#[derive(Debug)]
pub struct Wrong(pub Problems);

impl fmt::Display for Wrong {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let each: Vec<String> = each_drawn(&self.0).collect();
        formatter.write_str(each.join("error: ").trim_end())
    }
}

impl std::error::Error for Wrong {}

/// A file cannot be read. The exit code is 3.
#[derive(Debug)]
pub struct Unreadable(pub Error);

impl fmt::Display for Unreadable {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{:#}", self.0)
    }
}

impl std::error::Error for Unreadable {}

/// Differences were found and have been printed. The exit code is 1.
#[derive(Clone, Copy, Debug)]
pub struct Differs;

impl fmt::Display for Differs {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("there are differences")
    }
}

impl std::error::Error for Differs {}

/// The exit code of an error: 3 for a file that cannot be read or a fault of the machine, 130 (128 plus the signal
/// number) for Ctrl-C, and otherwise 1. For invalid options, clap has already exited with 2.
pub fn code(error: &Error) -> ExitCode {
    match () {
        () if error.is::<Interrupted>() => ExitCode::from(130),
        () if error.is::<Unreadable>() || error.is::<Wrong>() || error.is::<Fault>() => ExitCode::from(3),
        () => ExitCode::FAILURE,
    }
}
