//! A system with its FMUs opened and instantiated, ready to run once.
//!
//! ```no_run
//! use plcfmu::host::simulation::Simulation;
//! use engine::system::{Member, System};
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

use crate::host::fmu::Fmu;
use crate::host::instance::{Instance, Message};
use anyhow::{Context, Result, bail};
use engine::plan::Plan;
use engine::run::{self, Recording};
use engine::system::System;
use std::fs;
use std::path::PathBuf;

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
        let mut fmus: Vec<(PathBuf, Fmu)> = Vec::new();
        let mut places = Vec::new();
        for member in &system.members {
            let shown = || member.path.display().to_string();
            let path = fs::canonicalize(&member.path).with_context(shown)?;
            let place = match fmus.iter().position(|(other, _)| *other == path) {
                Some(place) => place,
                None => {
                    fmus.push((path, Fmu::open(&member.path)?));
                    fmus.len() - 1
                }
            };
            if places.contains(&place) && fmus[place].1.capabilities().can_be_instantiated_only_once_per_process {
                bail!("{} can be instantiated only once per process: a run cannot have two of it", shown());
            }
            places.push(place);
        }
        let descriptions: Vec<_> = places.iter().map(|place| &fmus[*place].1.description).collect();
        let plan = Plan::of(system, &descriptions)?;
        let instances = system
            .members
            .iter()
            .zip(&places)
            .map(|(member, place)| fmus[*place].1.instantiate(&member.name).with_context(|| member.name.clone()));
        Ok(Simulation { plan, instances: instances.collect::<Result<_>>()? })
    }

    /// Runs it from start to stop. `progress` gets the number of steps that are made, after each. A simulation runs once.
    ///
    /// # Errors
    /// Which FMU refused what, when, and its messages.
    pub fn run(&mut self, progress: impl FnMut(usize)) -> Result<Recording> {
        run::run(&self.plan, &mut self.instances, progress)
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
