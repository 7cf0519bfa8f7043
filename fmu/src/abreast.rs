//! The parts of an instance that an ordinary step changes, for programs that step several instances at the same time:
//! one instance from each of several runs, with identical clocks.

use crate::clock::Clock;
use crate::cyclic::Cyclic;
use crate::instance::Instance;
use crate::session::Session;

impl<B: Cyclic> Instance<B> {
    /// The block and the clock; `None` if no step can be ordinary, because the block is a program or because inputs are
    /// extrapolated.
    pub fn ordinary_parts(&mut self) -> Option<(&mut B, &mut Clock)> {
        let Session { block, clock, extrapolations } = &mut self.session;
        (B::IS_SURE && extrapolations.is_empty()).then_some((block, clock))
    }
}

/// Makes the call of an ordinary step.
#[inline(always)]
pub fn call_once<B: Cyclic>(block: &mut B) {
    Session::call_once(block);
}
