//! Steps several instances of a block side by side. Each belongs to a different run; all make the same ordinary steps,
//! with different values.
//!
//! This pays the overhead of a step only once: the clocks are equal, so one clock serves all instances, and each
//! variable is looked up once and then read from all blocks.

use crate::linked::Instance;
use blocks::table::abreast::{self, LANES, Reader, Writer};
use blocks::{Block, Role};
use fmu::abreast::call_once;
use fmu::clock::Clock;
use run::component::{Abreast, Wiring};
use std::any::Any;

/// Fewer instances than this are faster one by one: side by side, unused vector lanes cost as much as used ones.
const FEWEST: usize = 4;

/// Combines instances; `None` unless their number suits the lanes, their clocks are equal, the next step of each may be
/// an ordinary one, and all variables in `wiring` can be read or set side by side.
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
    /// The state of all blocks, copied back to `parts` at the end.
    blocks: G,
    /// The common clock, copied back to `parts` at the end.
    clock: Clock,
    /// Writers of the connected inputs, each with the index of its source among a run's values.
    inputs: Vec<(Writer<G>, usize)>,
    /// Readers of the outputs that other members need, each with the index among a run's values where its value is
    /// stored.
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

/// Calls each block once. The function is compiled for each of the instruction sets below and for the baseline; at run
/// time, the first version that the processor supports is used. All versions perform the same operations (none are
/// fused), so their results are bit-identical.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn call<B: Block, G: abreast::Abreast<B>>(blocks: &mut G) {
    blocks.each(
        #[inline(always)]
        |block| call_once(block),
    );
}
