//! Detects whether this process was started with a standard output.
//!
//! If it is closed, Rust opens /dev/null in its place before `main`, and output is lost without an error. The check
//! therefore happens earlier.

#![allow(unsafe_code)]

use std::sync::atomic::{AtomicBool, Ordering};

static IS_CLOSED: AtomicBool = AtomicBool::new(false);

#[cfg(any(target_os = "linux", target_os = "macos"))]
mod at_start {
    use super::{IS_CLOSED, Ordering};
    use std::ffi::c_int;

    unsafe extern "C" {
        fn fcntl(descriptor: c_int, command: c_int, ...) -> c_int;
    }

    /// The command that reads the flags of a descriptor.
    const F_GETFD: c_int = 1;

    // SAFETY: the loader calls functions in this section before `main`, and `look` does not use Rust's runtime.
    #[used]
    #[cfg_attr(target_os = "linux", unsafe(link_section = ".init_array"))]
    #[cfg_attr(target_os = "macos", unsafe(link_section = "__DATA,__mod_init_func"))]
    static LOOK: extern "C" fn() = look;

    extern "C" fn look() {
        // SAFETY: this command takes no third argument and changes nothing.
        if unsafe { fcntl(1, F_GETFD) } == -1 {
            IS_CLOSED.store(true, Ordering::Relaxed);
        }
    }
}

/// Whether standard output was closed when the process started. Always false on Windows.
pub fn is_closed() -> bool {
    IS_CLOSED.load(Ordering::Relaxed)
}
