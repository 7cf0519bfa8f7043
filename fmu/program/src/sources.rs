//! A program as C.

use crate::{Loaded, Program};
use fmu::sources::{self, Parts};
use std::sync::Arc;

impl Loaded {
    /// The FMU of the program as one file of C.
    ///
    /// # Errors
    /// What of the program cannot be printed as C: a block of this project, or a function such as EXP.
    pub fn sources(self: &Arc<Self>) -> Result<String, String> {
        let law = scl::c::print(&self.program)?;
        let places: Vec<(usize, bool)> = self.places.iter().map(|place| (place.offset, place.is_in_out)).collect();
        Ok(sources::file(&Parts {
            table: self.table,
            hash: self.hash,
            law: &law,
            call: &scl::c::name(&self.program, self.cycle),
            places: &places,
            memory: self.program.records[self.program.memory].start.len(),
            own_cycle: self.own_cycle,
            files: &self.program.files,
            budget: self.budget,
            tape: sources::tape(Program::new(self.clone())),
        }))
    }
}
