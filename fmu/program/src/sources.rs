//! A program as C source.

use crate::table::Held;
use crate::{Loaded, Program};
use blocks::table::number::number;
use fmu::cyclic::Cyclic;
use fmu::sources::{self, Door, Of, Parts, TakesEffect};
use std::sync::Arc;

impl Loaded {
    /// The program's FMU as the text of one C file, for the FMI version of `door`. `with_laws` adds the laws of the
    /// built-in blocks that the program instantiates.
    ///
    /// # Errors
    /// A part of the program cannot be printed as C.
    pub fn sources(
        self: &Arc<Self>,
        door: &'static Door,
        with_laws: impl FnOnce(&scl::ir::Program) -> Result<scl::ir::Program, String>,
    ) -> Result<String, String> {
        let linked = with_laws(&self.program)?;
        let law = scl::c::print(&linked)?;
        let given = |held: Held| match held {
            Held::Memory => TakesEffect::AtOnce,
            Held::InOut => TakesEffect::EachCall,
            Held::Start => TakesEffect::AtStart,
        };
        let places: Vec<(usize, TakesEffect)> =
            self.places.iter().map(|place| (place.offset, given(place.held))).collect();
        let table = &self.table;
        let texts: Vec<(blocks::Text, usize, usize)> = table
            .texts
            .iter()
            .zip(&self.texts)
            .map(|(text, place)| (text.clone(), place.offset, place.size()))
            .collect();
        let mut program = Program::new(self.clone());
        program.restart();
        let Ok(tape) = sources::tape(&table.rows, &mut program);
        Ok(sources::file(&Parts {
            door,
            name: &table.name,
            variables: &table.rows,
            cycle: (table.cycle, (number(table.rows[table.cycle].start) * 1000.0).round()),
            hash: self.hash,
            law: &law,
            call: &scl::c::name(&linked, self.cycle),
            places: &places,
            layout: self.layout.as_ref(),
            texts: &texts,
            memory: self.program.records[self.program.memory].start.len(),
            tape,
            of: Of::Program {
                startup: self.startup.map(|startup| scl::c::name(&linked, startup)).as_deref(),
                own_cycle: self.own_cycle,
                files: &self.program.files,
                budget: self.budget,
            },
        }))
    }
}
