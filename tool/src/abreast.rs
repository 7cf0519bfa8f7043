//! Instances of one block that make the same ordinary steps side by side: one of each of several runs, which differ in their values.
//!
//! What a step costs beside the law is done once for all of them: their clocks show the same, so one goes for all, and a variable is
//! found once and read from all blocks.

use crate::linked::Instance;
use blocks::table::abreast::{self, LANES, Reader, Writer};
use blocks::{Block, Role};
use fmu::abreast::call_once;
use fmu::clock::Clock;
use run::component::{Abreast, Wiring};
use std::any::Any;

/// Fewer instances are faster one by one: side by side, lanes cost the same whether something is in them or not.
const FEWEST: usize = 4;

/// Combines instances; `None` if their next step is not the same ordinary one, or a variable cannot be read or set together.
pub(crate) fn combine<'a, B: Block, G: abreast::Abreast<B>>(
    instances: Vec<&'a mut dyn Any>,
    wiring: &Wiring,
) -> Option<Box<dyn Abreast + 'a>> {
    if !(FEWEST..=LANES).contains(&instances.len()) {
        return None;
    }
    let writer = |(reference, source): (&u32, &usize)| {
        let row = B::TABLE.rows.get(*reference as usize)?;
        let is_tunable = matches!(row.role, Role::Input | Role::Parameter);
        Some((G::writer(*reference as usize).filter(|_| is_tunable)?, *source))
    };
    let reader = |(reference, place): (&u32, usize)| Some((G::reader(*reference as usize)?, place));
    let inputs = wiring.written.iter().flat_map(|of| of.references.iter().zip(&of.sources)).map(writer);
    let outputs = wiring.read.iter().flat_map(|of| of.references.iter().zip(of.places.clone())).map(reader);
    let (inputs, outputs) = (inputs.collect::<Option<_>>()?, outputs.collect::<Option<_>>()?);
    let parts = instances.into_iter().map(|of| of.downcast_mut::<Instance<B>>()?.ordinary_parts());
    let parts: Vec<_> = parts.collect::<Option<_>>()?;
    let clock = parts.first()?.1.clone();
    if parts.iter().any(|(_, other)| **other != clock) {
        return None;
    }
    let blocks = G::from_blocks(parts.iter().map(|(block, _)| B::clone(block)).collect());
    Some(Box::new(Group { parts, blocks, clock, inputs, outputs }))
}

struct Group<'a, B, G> {
    parts: Vec<(&'a mut B, &'a mut Clock)>,
    /// What all blocks are in the end.
    blocks: G,
    /// What all clocks show in the end.
    clock: Clock,
    /// What writes the connected inputs, and where their values are in those of a run.
    inputs: Vec<(Writer<G>, usize)>,
    /// What reads what others need, and where it goes.
    outputs: Vec<(Reader<G>, usize)>,
}

impl<B: Block, G: abreast::Abreast<B>> Abreast for Group<'_, B, G> {
    fn is_ordinary(&self, time: f64, size: f64) -> bool {
        self.clock.is_ordinary(time, size)
    }

    fn cycle(&mut self, values: &mut [f64], time: f64, size: f64) -> bool {
        let count = self.parts.len();
        let of = |place: usize| place * count..(place + 1) * count;
        let is_made = self.inputs.iter().all(|(write, source)| write(&mut self.blocks, &values[of(*source)]))
            && self.clock.check_and_make_ordinary_step(time, size);
        if is_made {
            call::<B, G>(&mut self.blocks);
            self.outputs.iter().for_each(|(read, place)| read(&self.blocks, &mut values[of(*place)]));
        }
        is_made
    }

    fn end(self: Box<Self>) {
        for ((block, clock), after) in self.parts.into_iter().zip(self.blocks.into_blocks()) {
            *block = after;
            clock.clone_from(&self.clock);
        }
    }
}

/// Makes a call of each block. It is compiled for each of these sets of vector instructions, and for none of them; the first that the
/// processor has is called. The operations are the same (nothing is fused), so the bits are.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn call<B: Block, G: abreast::Abreast<B>>(blocks: &mut G) {
    blocks.each(
        #[inline(always)]
        |block| call_once(block),
    );
}
