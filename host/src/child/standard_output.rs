//! Protects the standard output of a process from the libraries it loads.

#![allow(unsafe_code)]

use std::ffi::c_int;
use std::fs::File;
use std::io;

/// The file descriptors of standard output and standard error.
const OUTPUT: c_int = 1;
const ERROR: c_int = 2;

/// Takes exclusive ownership of standard output. From now on, anything else that this process prints, in C or Rust,
/// goes to standard error.
///
/// # Errors
/// The process has no standard output, or standard error cannot be duplicated onto it.
pub(super) fn take() -> io::Result<File> {
    let own = copy()?;
    // SAFETY: both are file descriptors; the C library checks that they are open.
    if unsafe { dup2(ERROR, OUTPUT) } < 0 {
        return Err(io::Error::last_os_error());
    }
    Ok(own)
}

#[cfg(unix)]
fn copy() -> io::Result<File> {
    use std::os::fd::AsFd;
    io::stdout().as_fd().try_clone_to_owned().map(File::from)
}

#[cfg(windows)]
fn copy() -> io::Result<File> {
    use std::os::windows::io::AsHandle;
    io::stdout().as_handle().try_clone_to_owned().map(File::from)
}

unsafe extern "C" {
    #[cfg_attr(windows, link_name = "_dup2")]
    fn dup2(from: c_int, to: c_int) -> c_int;
}
