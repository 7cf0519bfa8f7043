//! The FMUs of a system, loaded into this process.

use crate::fmu::Fmu;
use crate::instance::Instance;
use anyhow::{Context, Result, bail};
use modeldescription::Description;
use run::system::System;
use std::fs;
use std::path::{Path, PathBuf};

/// The FMUs of a system; each file is opened only once.
#[derive(Debug)]
pub struct Fmus {
    fmus: Vec<Fmu>,
    /// The name of each member, and the index of its FMU.
    members: Vec<(String, usize)>,
    /// Whether Event Mode is disabled for all FMUs.
    no_events: bool,
}

impl Fmus {
    /// Opens each file with `open`, and checks that the members can be instantiated together.
    ///
    /// # Errors
    /// A file does not exist, `open` fails, or an FMU that allows only one instance per process has two members.
    pub fn open(system: &System, mut open: impl FnMut(&Path) -> Result<Fmu>) -> Result<Fmus> {
        let mut paths: Vec<PathBuf> = Vec::new();
        let mut of = Fmus { fmus: Vec::new(), members: Vec::new(), no_events: system.no_events };
        for member in &system.members {
            let shown = || member.path.display().to_string();
            let path = fs::canonicalize(&member.path).with_context(shown)?;
            let place = match paths.iter().position(|other| *other == path) {
                Some(place) => place,
                None => {
                    paths.push(path);
                    of.fmus.push(open(&member.path)?);
                    of.fmus.len() - 1
                }
            };
            let is_there_twice = of.members.iter().any(|(_, other)| *other == place);
            if is_there_twice && of.fmus[place].can("canBeInstantiatedOnlyOncePerProcess") {
                bail!("{} can be instantiated only once per process: a run cannot contain it twice", shown());
            }
            of.members.push((member.name.clone(), place));
        }
        Ok(of)
    }

    /// The descriptions of the members.
    pub fn descriptions(&self) -> Vec<&Description> {
        self.members.iter().map(|(_, place)| &self.fmus[*place].description).collect()
    }

    /// The FMU of a member.
    ///
    /// # Panics
    /// There is no such member.
    pub fn fmu(&self, member: usize) -> &Fmu {
        &self.fmus[self.members[member].1]
    }

    /// Creates an instance for a member.
    ///
    /// # Errors
    /// The FMU refuses the call; the error contains the name of the member and the FMU's messages.
    ///
    /// # Panics
    /// There is no such member.
    pub fn instantiate(&self, member: usize) -> Result<Instance> {
        let (name, of) = (&self.members[member].0, self.fmu(member));
        of.instantiate(name, !self.no_events && run::plan::has_events(&of.description)).with_context(|| name.clone())
    }
}
