//! Handles Ctrl-C, and on Unix SIGTERM and SIGHUP, for all commands.

use host::package::temporary;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// The flag that a command polls while it can end gracefully.
static FLAG: Mutex<Weak<AtomicBool>> = Mutex::new(Weak::new());

/// Installs the handler: a signal removes temporary files and ends the command with exit code 130. While a [`flag`]
/// exists, the first signal sets it instead.
///
/// # Errors
/// The system does not allow a signal handler.
pub fn guard() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| {
        let flag = FLAG.lock().unwrap_or_else(PoisonError::into_inner).upgrade();
        if flag.is_none_or(|flag| flag.swap(true, Ordering::Relaxed)) {
            temporary::remove_all();
            process::exit(130);
        }
    })
}

/// Creates the flag that becomes true at the first signal. Its holder polls it and ends the command gracefully; a
/// second signal, or any signal after the flag was dropped, ends the command immediately.
pub fn flag() -> Arc<AtomicBool> {
    let flag = Arc::default();
    *FLAG.lock().unwrap_or_else(PoisonError::into_inner) = Arc::downgrade(&flag);
    flag
}
