//! A system with its FMUs opened and instantiated, ready to run once.
//!
//! ```no_run
//! use host::simulation::Simulation;
//! use run::system::{Member, System};
//!
//! let system = System {
//!     members: [("PID", "PID.fmu"), ("FURNACE", "FURNACE.fmu")].map(|(name, path)| Member { name: name.into(), path: path.into() }).into(),
//!     connections: vec!["PID.OUT=FURNACE.POWER".parse()?, "FURNACE.TEMP=PID.PV".parse()?],
//!     settings: vec!["PID.GAIN=2".parse()?, "PID.SP=60@120".parse()?],
//!     stop: Some(600.0),
//!     ..System::default()
//! };
//! let recording = Simulation::open(&system)?.run(|_| {})?;
//! recording.write_csv(&mut std::io::stdout())?;
//! # Ok::<(), anyhow::Error>(())
//! ```

use crate::fmu::Fmu;
use crate::instance::{Instance, Message};
use anyhow::{Context, Result, bail};
use modeldescription::Description;
use run::master::{self, Recording};
use run::plan::Plan;
use run::system::System;
use std::fs;
use std::path::{Path, PathBuf};

/// The FMUs of a system, each file opened once.
#[derive(Debug)]
pub struct Fmus {
    fmus: Vec<Fmu>,
    /// The name of each member, and the place of its FMU.
    members: Vec<(String, usize)>,
}

impl Fmus {
    /// Opens each file with `open`, and checks that the members can be instantiated together.
    ///
    /// # Errors
    /// There is no such file, `open` fails, or an FMU cannot have two instances.
    pub fn open(system: &System, mut open: impl FnMut(&Path) -> Result<Fmu>) -> Result<Fmus> {
        let mut paths: Vec<PathBuf> = Vec::new();
        let mut of = Fmus { fmus: Vec::new(), members: Vec::new() };
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
                bail!("{} can be instantiated only once per process: a run cannot have two of it", shown());
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
    pub fn of(&self, member: usize) -> &Fmu {
        &self.fmus[self.members[member].1]
    }

    /// A new instance for a member.
    ///
    /// # Errors
    /// Which FMU refuses, with its messages.
    ///
    /// # Panics
    /// There is no such member.
    pub fn instantiate(&self, member: usize) -> Result<Instance> {
        let name = &self.members[member].0;
        self.of(member).instantiate(name).with_context(|| name.clone())
    }
}

/// A system that is ready to run.
#[derive(Debug)]
pub struct Simulation {
    /// What the run does.
    pub plan: Plan,
    instances: Vec<Instance>,
}

impl Simulation {
    /// Opens the FMUs of a system, each file once, checks the system against them, and instantiates them. This runs code of
    /// the FMUs.
    ///
    /// # Errors
    /// What is wrong with which FMU, name, value, connection or time, and what to do.
    pub fn open(system: &System) -> Result<Simulation> {
        let fmus = Fmus::open(system, Fmu::open)?;
        let plan = Plan::of(system, &fmus.descriptions())?;
        let instances = (0..system.members.len()).map(|member| fmus.instantiate(member));
        Ok(Simulation { plan, instances: instances.collect::<Result<_>>()? })
    }

    /// Runs it from start to stop. `progress` gets the number of steps that are made, after each. A simulation runs once.
    ///
    /// # Errors
    /// Which FMU refused what, when, and its messages.
    pub fn run(&mut self, progress: impl FnMut(usize)) -> Result<Recording> {
        master::run(&self.plan, &mut self.instances, progress)
    }

    /// What the FMUs have logged since the last time, with the name of the FMU.
    pub fn take_messages(&mut self) -> Vec<(String, Message)> {
        let members = self.plan.members.iter().zip(&mut self.instances);
        let messages = members.flat_map(|(member, instance)| {
            instance.take_messages().into_iter().map(|message| (member.name.clone(), message))
        });
        messages.collect()
    }
}
