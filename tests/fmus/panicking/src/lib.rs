//! A block that panics on demand, in every place where the code of a block runs.

use blocks::{Law, Stored};
use std::panic::{panic_any, set_hook};
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

blocks::block! {
    /// Panics where it is told to, and counts its calls otherwise.
    ///
    /// In its law when CALLS reaches AT_CALL; in its restart; in the check of its parameters. ARM makes the next call
    /// put a fuse into the memory, which panics when it is cloned (1), dropped (2), written (3) or read (4), or makes
    /// the next new block panic (5). PAYLOAD is what it panics with: a text (0), a text with `#` and NUL in it (1),
    /// a number (2), or something that panics again when it is dropped (3).
    pub struct Panicking as "PANICKING" {
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(1000), min Time::ms(1);
        }
        input {
            /// The number of the call that panics; 0 is none
            at_call: Int = 0;
            /// The restart panics
            in_restart: Bool = false;
            /// The check of the parameters panics
            in_check: Bool = false;
            /// What the next call arms
            arm: Int = 0;
            /// What it panics with
            payload: Int = 0;
        }
        output {
            /// Calls since the restart
            calls: LReal;
        }
    }
    memory Memory {
        /// What panics when the memory is handled.
        fuse: Fuse;
    }
}

/// What panics when it is handled in one way.
#[derive(Debug)]
pub struct Fuse(i16);

const CLONE: i16 = 1;
const DROP: i16 = 2;
const WRITE: i16 = 3;
const READ: i16 = 4;
const DEFAULT: i16 = 5;

/// The next new block panics.
static DEFAULT_PANICS: AtomicBool = AtomicBool::new(false);

impl Default for Fuse {
    fn default() -> Fuse {
        if DEFAULT_PANICS.swap(false, Ordering::Relaxed) {
            fail(0, "a new block");
        }
        Fuse(0)
    }
}

impl Clone for Fuse {
    fn clone(&self) -> Fuse {
        if self.0 == CLONE {
            fail(0, "clone");
        }
        Fuse(self.0)
    }
}

impl Drop for Fuse {
    fn drop(&mut self) {
        if self.0 == DROP {
            fail(0, "drop");
        }
    }
}

impl Stored for Fuse {
    fn write(&self, bytes: &mut Vec<u8>) {
        if self.0 == WRITE {
            fail(0, "write");
        }
        self.0.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Fuse> {
        let fuse = i16::read(bytes)?;
        if fuse == READ {
            fail(0, "read");
        }
        Some(Fuse(fuse))
    }
}

impl Law for Panicking {
    fn restart(&mut self) {
        if self.in_restart {
            fail(self.payload, "restart");
        }
        self.clear();
    }

    fn call(&mut self) {
        self.calls += 1.0;
        if self.calls == f64::from(self.at_call) {
            fail(self.payload, "call");
        }
        if self.arm == DEFAULT {
            DEFAULT_PANICS.store(true, Ordering::Relaxed);
        } else if self.arm != 0 {
            self.memory.fuse.0 = self.arm;
        }
        self.arm = 0;
    }

    fn check(&self) -> Result<(), String> {
        if self.in_check {
            fail(self.payload, "check");
        }
        Ok(())
    }
}

/// A payload that panics when it is dropped.
struct Bomb;

impl Drop for Bomb {
    fn drop(&mut self) {
        panic_any(Bomb);
    }
}

fn fail(payload: i16, place: &'static str) -> ! {
    // Panics are wanted here: nothing goes to standard error.
    static QUIET: Once = Once::new();
    QUIET.call_once(|| set_hook(Box::new(|_| {})));
    match payload {
        0 => panic_any(place),
        1 => panic_any(format!("{place} #1 \0 %s")),
        2 => panic_any(42),
        _ => panic_any(Bomb),
    }
}

fmu::export!(Panicking);
