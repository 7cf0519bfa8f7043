//! Handles Ctrl-C, and on Unix SIGTERM and SIGHUP: the one handler of all commands.

use host::package::temporary;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// The flag that a command looks at while it can end in order.
static FLAG: Mutex<Weak<AtomicBool>> = Mutex::new(Weak::new());

/// From now on a signal ends the command with exit code 130, and leaves nothing temporary. While there is a [`flag`], the first
/// signal sets it instead.
///
/// # Errors
/// The system does not let signals be handled.
pub fn guard() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| {
        let flag = FLAG.lock().unwrap_or_else(PoisonError::into_inner).upgrade();
        if flag.is_none_or(|flag| flag.swap(true, Ordering::Relaxed)) {
            temporary::remove_all();
            process::exit(130);
        }
    })
}

/// Becomes true at the first signal. Whoever holds it looks at it, and ends the command in order; a second signal ends the command
/// at once.
pub fn flag() -> Arc<AtomicBool> {
    let flag = Arc::default();
    *FLAG.lock().unwrap_or_else(PoisonError::into_inner) = Arc::downgrade(&flag);
    flag
}
