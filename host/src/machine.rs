//! Machine faults, as opposed to FMU faults.

use anyhow::{Context, Error, Result, anyhow};
use serde::{Deserialize, Serialize};
use std::env;
use std::fmt;
use std::io::{self, ErrorKind};
use std::path::Path;

/// A fault of the machine, such as a full disk for temporary files, which is unrelated to the FMU.
#[derive(Clone, Debug)]
pub struct Fault(String);

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for Fault {}

/// The environment variable for the folder for temporary files.
const VARIABLE: &str = if cfg!(windows) { "TMP" } else { "TMPDIR" };

impl Fault {
    /// The fault for a folder that cannot be written to.
    pub fn no_room(folder: &Path) -> Fault {
        Fault(format!(
            "nothing can be written to {}: free up space there, or {}",
            Fault::place(folder),
            Fault::remedy()
        ))
    }

    /// The fault for a folder whose files cannot be executed.
    fn no_programs(folder: &Path) -> Fault {
        Fault(format!("no program can run from {} (it is mounted noexec): {}", Fault::place(folder), Fault::remedy()))
    }

    /// A folder for a message: the system's folder for temporary files if `folder` is within it, otherwise `folder`.
    fn place(folder: &Path) -> String {
        let temporary = env::temp_dir();
        let known = if folder.starts_with(&temporary) { &temporary } else { folder };
        format!("the folder for temporary files {}", known.display())
    }

    /// The remedy: another folder.
    pub fn remedy() -> String {
        format!("set {VARIABLE} to another folder")
    }
}

/// Marks an error that occurred while unpacking an FMU to `folder` as a machine fault if it is one.
pub(crate) fn unpacking<T>(result: Result<T>, folder: &Path) -> Result<T> {
    let is_no_room = |error: &io::Error| {
        use ErrorKind::{FileTooLarge, PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
        matches!(error.kind(), StorageFull | QuotaExceeded | FileTooLarge | ReadOnlyFilesystem | PermissionDenied)
    };
    result.map_err(|error| match error.chain().find_map(|cause| cause.downcast_ref::<io::Error>()) {
        Some(cause) if is_no_room(cause) => error.context(Fault::no_room(folder)),
        _ => error,
    })
}

/// Marks an error that occurred while loading a library in `folder` as a machine fault if it is one.
pub(crate) fn loading<T>(result: Result<T>, folder: &Path) -> Result<T> {
    if result.is_err() && forbids_programs(folder) { result.context(Fault::no_programs(folder)) } else { result }
}

#[cfg(target_os = "linux")]
fn forbids_programs(folder: &Path) -> bool {
    use rustix::fs::{StatVfsMountFlags, statvfs};
    statvfs(folder).is_ok_and(|system| system.f_flag.contains(StatVfsMountFlags::NOEXEC))
}

#[cfg(not(target_os = "linux"))]
fn forbids_programs(_folder: &Path) -> bool {
    false
}

/// An error in a form that can be sent from one process to another.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum Failure {
    /// A [`Fault`].
    Machine(String),
    /// Any other error.
    Other(String),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        let text = format!("{error:#}");
        if error.is::<Fault>() { Failure::Machine(text) } else { Failure::Other(text) }
    }
}

impl Failure {
    /// Converts it back to an error.
    pub fn into_error(self) -> Error {
        match self {
            Failure::Machine(text) => Error::new(Fault(text)),
            Failure::Other(text) => anyhow!(text),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_room_is_a_fault_of_the_machine_in_another_process_too() {
        let of = |kind: ErrorKind| {
            let result: Result<()> = Err(Error::new(io::Error::from(kind)).context("PUMP.so cannot be unpacked"));
            unpacking(result, Path::new("/full")).unwrap_err()
        };
        let error = Failure::from(of(ErrorKind::StorageFull)).into_error();
        assert!(error.is::<Fault>());
        assert!(
            error.to_string().starts_with(
                "nothing can be written to the folder for temporary files /full: free up space there, or "
            )
        );
        assert!(error.to_string().ends_with(": PUMP.so cannot be unpacked: no storage space"), "{error}");
        assert!(!Failure::from(of(ErrorKind::InvalidData)).into_error().is::<Fault>());
    }
}
