//! Instances of one block that make the same ordinary steps side by side: one of each of several runs, which differ in their values.
//!
//! What a step costs beside the law is done once for all of them: their clocks show the same, so one goes for all, and a variable is
//! found once and read from all blocks.

use crate::clock::Clock;
use crate::cyclic::{Cyclic, Reader, Writer};
use crate::instance::Instance;
use crate::session::Session;
use blocks::table::Abreast as _;
use blocks::table::abreast::LANES;

/// Instances at the same time, as long as they make the same steps.
pub struct Abreast<'a, B: Cyclic> {
    sessions: Vec<&'a mut Session<B>>,
    /// What all their blocks are in the end.
    blocks: B::Abreast,
    /// What all their clocks show in the end.
    clock: Clock,
}

impl<'a, B: Cyclic> Abreast<'a, B> {
    /// `None` if a step of one of them is never ordinary, or is not when one of another is, or if they are more than [`LANES`].
    pub fn new(instances: impl IntoIterator<Item = &'a mut Instance<B>>) -> Option<Abreast<'a, B>> {
        let sessions: Vec<_> = instances.into_iter().map(|instance| &mut instance.session).collect();
        let clock = sessions.first()?.clock.clone();
        let is_alike = |session: &&mut Session<B>| session.clock == clock && session.extrapolations.is_empty();
        if !(B::IS_SURE && sessions.len() <= LANES && sessions.iter().all(is_alike)) {
            return None;
        }
        let blocks = B::Abreast::from_blocks(sessions.iter().map(|session| session.block.clone()).collect());
        Some(Abreast { sessions, blocks, clock })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.sessions.len()
    }

    /// Whether a step is an ordinary one.
    pub fn is_ordinary(&self, tc: f64, h: f64) -> bool {
        self.clock.is_ordinary(tc, h)
    }

    /// Writes a variable, a value to each; false if one is refused.
    #[inline(always)]
    pub fn write(&mut self, write: Writer<B>, values: &[f64]) -> bool {
        write(&mut self.blocks, values)
    }

    /// Makes a step, if it is an ordinary one.
    #[inline(always)]
    pub fn make_ordinary_step(&mut self, tc: f64, h: f64) -> bool {
        let is_ordinary = self.clock.check_and_make_ordinary_step(tc, h);
        if is_ordinary {
            self.blocks.each(
                #[inline(always)]
                |block| Session::call_once(block),
            );
        }
        is_ordinary
    }

    /// Reads a variable of each.
    #[inline(always)]
    pub fn read(&self, read: Reader<B>, values: &mut [f64]) {
        read(&self.blocks, values);
    }

    /// Gives the instances what they have come to. Without it they are as before.
    pub fn end(self) {
        for (session, block) in self.sessions.into_iter().zip(self.blocks.into_blocks()) {
            session.block = block;
            session.clock.clone_from(&self.clock);
        }
    }
}
