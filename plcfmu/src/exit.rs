//! How a command ends: errors with their own exit codes.

use anyhow::Error;
use host::machine::Fault;
use parameters::Problems;
use parameters::problem::each_drawn;
use std::fmt;
use std::process::ExitCode;
use study::Interrupted;

/// The problems of a file, for a terminal: each with its line of the file.
#[derive(Debug)]
pub struct Wrong(pub Problems);

impl fmt::Display for Wrong {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let each: Vec<String> = each_drawn(&self.0).collect();
        formatter.write_str(each.join("error: ").trim_end())
    }
}

impl std::error::Error for Wrong {}

/// A file that cannot be read, which has its own exit code.
#[derive(Debug)]
pub struct Unreadable(pub Error);

impl fmt::Display for Unreadable {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{:#}", self.0)
    }
}

impl std::error::Error for Unreadable {}

/// Two things are different, as was printed, which has its own exit code.
#[derive(Clone, Copy, Debug)]
pub struct Differs;

impl fmt::Display for Differs {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("there are differences")
    }
}

impl std::error::Error for Differs {}

/// The exit code of an error: 1 is that of a finding, 2 that of a wrong command, 3 that of a file that cannot be read or of a machine that
/// cannot do it, and 130 (128 and the number of its signal) that of Ctrl-C.
pub fn code(error: &Error) -> ExitCode {
    match () {
        () if error.is::<Interrupted>() => ExitCode::from(130),
        () if error.is::<Unreadable>() || error.is::<Wrong>() || error.is::<Fault>() => ExitCode::from(3),
        () => ExitCode::FAILURE,
    }
}
