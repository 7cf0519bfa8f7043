//! What a process does at this moment, in memory that it shares with the process that has started it. It costs nothing to
//! write, and stays when the process has crashed.

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

/// The size of what is shared, in bytes.
const SIZE: usize = size_of::<Words>();

/// What is shared.
#[derive(Debug)]
#[repr(C)]
struct Words {
    /// The member that was called last, from 1; 0 is none.
    member: AtomicU64,
    /// How many calls there were.
    calls: AtomicU64,
    /// How many steps of the run are made.
    steps: AtomicU64,
}

/// Which FMU is called, and how far its run is.
#[derive(Debug)]
pub struct Witness(MmapRaw);

impl Witness {
    /// That of the folder that both processes know.
    ///
    /// # Errors
    /// Its file cannot be made or mapped into the memory.
    pub fn open(folder: &Path) -> Result<Witness> {
        let map = || {
            let path = folder.join("witness");
            let mut file = temporary::options().read(true).write(true).create(true).truncate(false).open(path)?;
            if file.metadata()?.len() < SIZE as u64 {
                // Written, not only made longer: a page of a file that the disk has no room for kills whoever touches it.
                file.write_all(&[0; SIZE])?;
            }
            MmapOptions::new().len(SIZE).map_raw(&file)
        };
        Ok(Witness(map().with_context(|| format!("no file can be shared in {}", folder.display()))?))
    }

    fn words(&self) -> &Words {
        // SAFETY: the mapping is as large as this, begins with a page and lives as long as self; any bytes are good, and both
        // processes use atomics alone.
        unsafe { &*self.0.as_ptr().cast() }
    }

    /// A member is called.
    #[inline]
    pub fn call(&self, member: usize) {
        let Words { member: at, calls, .. } = self.words();
        at.store(member as u64 + 1, Ordering::Relaxed);
        // There is one writer.
        calls.store(calls.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
    }

    /// No member is called: what fails now is this program's own.
    pub fn clear(&self) {
        self.words().member.store(0, Ordering::Relaxed);
    }

    /// This many steps are made.
    #[inline]
    pub fn stepped(&self, steps: usize) {
        self.words().steps.store(steps as u64, Ordering::Relaxed);
    }

    /// The member that was called last; none if no call was made, or if this program itself has failed since.
    pub fn member(&self) -> Option<usize> {
        (self.words().member.load(Ordering::Relaxed) as usize).checked_sub(1)
    }

    /// How many calls there were.
    pub fn calls(&self) -> u64 {
        self.words().calls.load(Ordering::Relaxed)
    }

    /// How many steps are made.
    pub fn steps(&self) -> usize {
        self.words().steps.load(Ordering::Relaxed) as usize
    }
}

/// An instance whose calls are seen.
#[derive(Debug)]
pub struct Witnessed {
    /// The instance.
    pub instance: Instance,
    member: usize,
    witness: Rc<Witness>,
}

impl Witnessed {
    /// A new instance for a member.
    ///
    /// # Errors
    /// Which FMU refuses, with its messages.
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
