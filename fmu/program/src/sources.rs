//! A program as C.

use crate::table::Held;
use crate::{Loaded, Program};
use fmu::sources::{self, Given, Parts};
use std::sync::Arc;

impl Loaded {
    /// The FMU of the program as one file of C.
    ///
    /// # Errors
    /// What of the program cannot be printed as C: a block of this project, or a function such as EXP.
    pub fn sources(self: &Arc<Self>) -> Result<String, String> {
        let law = scl::c::print(&self.program)?;
        let given = |held: Held| match held {
            Held::Memory => Given::AtOnce,
            Held::InOut => Given::EachCall,
            Held::Start => Given::AtStart,
        };
        let places: Vec<(usize, Given)> = self.places.iter().map(|place| (place.offset, given(place.held))).collect();
        Ok(sources::file(&Parts {
            table: self.table,
            hash: self.hash,
            law: &law,
            call: &scl::c::name(&self.program, self.cycle),
            startup: self.startup.map(|startup| scl::c::name(&self.program, startup)).as_deref(),
            places: &places,
            memory: self.program.records[self.program.memory].start.len(),
            own_cycle: self.own_cycle,
            files: &self.program.files,
            budget: self.budget,
            tape: sources::tape(Program::new(self.clone())),
        }))
    }
}
