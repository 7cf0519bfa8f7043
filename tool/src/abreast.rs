//! Instances of one block stepped side by side: one from each of several runs, which make the same ordinary steps with
//! different values.
//!
//! The overhead of a step is paid only once: all clocks are equal, so one serves for all, and each variable is looked
//! up once and read from all blocks.

use crate::linked::Instance;
use blocks::table::abreast::{self, LANES, Reader, Writer};
use blocks::{Block, Role};
use fmu::abreast::call_once;
use fmu::clock::Clock;
use run::component::{Abreast, Wiring};
use std::any::Any;

/// Fewer instances are faster one by one: side by side, empty lanes cost as much as used ones.
const FEWEST: usize = 4;

/// Combines instances; `None` unless all make the same ordinary step next and every variable can be read or set side by
/// side.
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
    /// The state of all blocks, copied back at the end.
    blocks: G,
    /// The common clock, copied back to all parts at the end.
    clock: Clock,
    /// Writers of the connected inputs, each with the index of its value among the values of a run.
    inputs: Vec<(Writer<G>, usize)>,
    /// Readers of the outputs that other members need, each with the index at which its value is stored.
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

/// Calls each block once. The function is compiled for each of these vector instruction sets and for the baseline; the
/// first version that the processor supports is used. The operations are the same (none are fused), so the results are
/// bit-identical.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn call<B: Block, G: abreast::Abreast<B>>(blocks: &mut G) {
    blocks.each(
        #[inline(always)]
        |block| call_once(block),
    );
}
