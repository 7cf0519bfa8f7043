//! The FMUs for tests, as a catalogue.

use crate::home::Home;
use crate::message::{Entry, KnownLoop, LoopRole};
use anyhow::Result;
pub(crate) use doubles::{FOREIGN, Pid};
use modeldescription::{Description, Table};
use run::component::Component;
use run::fmus::Fmus;
use std::ops::Deref;
use std::sync::Arc;

/// Blocks, and a foreign FMU.
#[derive(Debug, Default)]
pub(crate) struct TestHome {
    fmus: doubles::TestHome,
    pub loops: Vec<KnownLoop>,
}

impl Deref for TestHome {
    type Target = doubles::TestHome;

    fn deref(&self) -> &doubles::TestHome {
        &self.fmus
    }
}

impl Fmus for TestHome {
    fn description(&self, fmu: &str) -> Result<Arc<Description>> {
        self.fmus.description(fmu)
    }

    fn table(&self, fmu: &str) -> Result<Option<Arc<Table>>> {
        self.fmus.table(fmu)
    }

    fn instantiate(&self, fmu: &str, name: &str) -> Result<Box<dyn Component>> {
        self.fmus.instantiate(fmu, name)
    }
}

impl Home for TestHome {
    fn entries(&self) -> Vec<Entry> {
        let entry = |name: &str, part, is_foreign| Entry { name: name.into(), summary: name.into(), part, is_foreign };
        vec![
            entry("PID", LoopRole::Controller, false),
            entry("LAG", LoopRole::Plant, false),
            entry(FOREIGN, LoopRole::Plant, true),
        ]
    }

    fn known_loops(&self) -> Vec<KnownLoop> {
        self.loops.clone()
    }

    fn blocks(&self) -> Vec<Arc<parameters::BlockType>> {
        vec![Arc::new(parameters::BlockType::for_block::<Pid>())]
    }

    fn preset(&self, of: &parameters::Loop) -> Result<Vec<u8>> {
        Ok(of.name.clone().into_bytes())
    }
}
