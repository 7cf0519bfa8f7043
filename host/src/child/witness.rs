//! The current activity of a process, in memory shared with the process that started it. Writing to it costs next to
//! nothing, and its contents survive a crash.

#![allow(unsafe_code)]

use crate::instance::Instance;
use crate::package::temporary;
use crate::simulation::Fmus;
use anyhow::{Context, Result};
use memmap2::{MmapOptions, MmapRaw};
use run::component::Reset;
use std::io::Write;
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The size of the shared memory, in bytes.
const SIZE: usize = size_of::<Words>();

/// The layout of the shared memory.
#[derive(Debug)]
#[repr(C)]
struct Words {
    /// The number of the member called last, starting at 1; 0 for none.
    member: AtomicU64,
    /// The number of calls to all members.
    calls: AtomicU64,
    /// The number of completed steps.
    steps: AtomicU64,
}

/// The member being called, and the progress of the run.
#[derive(Debug)]
pub struct Witness(MmapRaw);

impl Witness {
    /// Opens the witness in the folder shared by both processes, or creates it.
    ///
    /// # Errors
    /// Its file cannot be created or mapped into memory.
    pub fn open(folder: &Path) -> Result<Witness> {
        let map = || {
            let path = folder.join("witness");
            let mut file = temporary::options().read(true).write(true).create(true).truncate(false).open(path)?;
            if file.metadata()?.len() < SIZE as u64 {
                // Written, not merely extended: touching a page for which the disk has no space would kill the process.
                file.write_all(&[0; SIZE])?;
            }
            MmapOptions::new().len(SIZE).map_raw(&file)
        };
        Ok(Witness(map().with_context(|| format!("cannot create a shared file in {}", folder.display()))?))
    }

    fn words(&self) -> &Words {
        // SAFETY: the mapping is as large as this, page-aligned and lives as long as self; all bit patterns are valid,
        // and both processes use only atomics.
        unsafe { &*self.0.as_ptr().cast() }
    }

    /// Records that a member is being called.
    #[inline]
    pub fn call(&self, member: usize) {
        let Words { member: at, calls, .. } = self.words();
        at.store(member as u64 + 1, Ordering::Relaxed);
        // No atomic increment is needed: only the child process writes.
        calls.store(calls.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
    }

    /// Records that no member is being called: any later failure is this program's own.
    pub fn clear(&self) {
        self.words().member.store(0, Ordering::Relaxed);
    }

    /// Records the number of completed steps.
    #[inline]
    pub fn stepped(&self, steps: usize) {
        self.words().steps.store(steps as u64, Ordering::Relaxed);
    }

    /// The member called last; `None` if no call has been made, or if this program itself has been active since.
    pub fn member(&self) -> Option<usize> {
        (self.words().member.load(Ordering::Relaxed) as usize).checked_sub(1)
    }

    /// The number of calls.
    pub fn calls(&self) -> u64 {
        self.words().calls.load(Ordering::Relaxed)
    }

    /// The number of completed steps.
    pub fn steps(&self) -> usize {
        self.words().steps.load(Ordering::Relaxed) as usize
    }
}

/// An instance whose calls are recorded in a [`Witness`].
#[derive(Debug)]
pub struct Witnessed {
    /// The instance itself, whose direct calls are not recorded.
    pub instance: Instance,
    member: usize,
    witness: Rc<Witness>,
}

impl Witnessed {
    /// Creates an instance for a member.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains the name of the member and the FMU's messages.
    pub fn instantiate(fmus: &Fmus, member: usize, witness: &Rc<Witness>) -> Result<Witnessed> {
        witness.call(member);
        Ok(Witnessed { instance: fmus.instantiate(member)?, member, witness: witness.clone() })
    }

    #[inline]
    fn called(&mut self) -> &mut Instance {
        self.witness.call(self.member);
        &mut self.instance
    }
}

run::forward_component!([] Witnessed, self => self.called());

impl Reset for Witnessed {
    fn reset(&mut self) -> Result<()> {
        self.called().reset()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_side_sees_what_the_other_does() {
        let folder = tempfile::tempdir().unwrap();
        let [child, parent] = [(); 2].map(|()| Witness::open(folder.path()).unwrap());
        assert_eq!((parent.member(), parent.calls(), parent.steps()), (None, 0, 0));
        child.call(2);
        child.call(0);
        child.stepped(7);
        assert_eq!((parent.member(), parent.calls(), parent.steps()), (Some(0), 2, 7));
        child.clear();
        assert_eq!((parent.member(), parent.calls()), (None, 2));
    }
}
