//! One block and its time: restart, steps, inputs extrapolated within a step, and serialization.
//!
//! A refused call changes nothing.

use crate::clock::Clock;
use crate::cyclic::Cyclic;
use crate::mean::Mean;
use crate::messages;
use crate::refusal::Refusal;
use blocks::table::number::{number, to_value};
use blocks::{Kind, Role, Row, Stored, TableText};
use std::mem::ManuallyDrop;

/// The highest order of an input's time derivative.
pub const ORDERS: usize = 4;

/// One block with its clock. A clone is a saved state: it contains no pointers unless the block does.
#[derive(Clone, Debug)]
pub struct Session<B> {
    /// The block; its fields are the values of the rows.
    pub block: B,
    pub(crate) clock: Clock,
    pub(crate) extrapolations: Vec<Extrapolation>,
}

impl<B: Cyclic> Session<B> {
    /// A session with this block, not yet restarted; the time is 0.
    #[inline(always)]
    pub fn new(block: B) -> Self {
        let clock = Clock::new(0.0, f64::INFINITY, block.cycle());
        Session { block, clock, extrapolations: Vec::new() }
    }

    /// Restarts the block with its current inputs and parameters. The time runs from `start` to `stop`, in seconds
    /// (infinite if there is no stop time); the first call is at `start`.
    ///
    /// # Errors
    /// The time between two calls is less than 1 ms, or the block rejects its parameters.
    pub fn restart(&mut self, start: f64, stop: f64) -> Result<(), Refusal> {
        Self::restart_block(&mut self.block)?;
        self.clock = Clock::new(start, stop, self.block.cycle());
        Ok(())
    }

    /// The block as a restart with its current inputs and parameters would leave it; `None` if that restart is refused.
    pub fn restarted(&self) -> Option<B> {
        // If the restart panics, the copy is leaked: dropping it might panic again, which would abort the process.
        let mut block = ManuallyDrop::new(self.block.clone());
        let is_restarted = Self::restart_block(&mut block).is_ok();
        let block = ManuallyDrop::into_inner(block);
        is_restarted.then_some(block)
    }

    fn restart_block(block: &mut B) -> Result<(), Refusal> {
        let cycle = block.cycle().milliseconds();
        if cycle < 1 {
            let name = &block.table().rows[block.table().cycle].name;
            return Err(messages::short_cycle(name, f64::from(cycle) / 1000.0).into());
        }
        block.check()?;
        block.restart();
        Self::show_mean(block, Mean::default());
        Ok(())
    }

    /// Advice if a step of `h` seconds is so much shorter than the time between two calls that CYCLE may be in the
    /// wrong unit.
    pub fn advice_on_step(&self, h: f64) -> Option<String> {
        let cycle = self.clock.period();
        // Steps shorter than a microsecond result from rounding in the host's time.
        let is_odd = 1e-6 < h && h < cycle / 100.0;
        is_odd.then(|| {
            let table = self.block.table();
            messages::short_step(h, &table.rows[table.cycle].name, cycle, (cycle / h).round_ties_even())
        })
    }

    /// The end of the last step in seconds. Never decreases, even if a step begins and ends slightly early.
    pub fn end(&self) -> f64 {
        self.clock.end()
    }

    /// Makes every call from `tc` up to but not including `tc + h`, in seconds.
    ///
    /// # Errors
    /// The [`Clock`] rejects a time, or an extrapolated input may leave its range. In these cases, no call is made.
    pub fn step(&mut self, tc: f64, h: f64) -> Result<(), Refusal> {
        let mut clock = self.clock.clone();
        let calls = clock.advance(tc, h)?;
        let cycle = clock.period();
        for input in &mut self.extrapolations {
            let row = &self.block.table().rows[input.row as usize];
            input.value = self.block.get(input.row as usize).map(number).unwrap_or_default();
            // An upper bound of the value's magnitude within the step. If the bound is in range, every value is.
            let last = (calls.lead + calls.count as f64 * cycle).max(0.0);
            let bound =
                Extrapolation { value: input.value.abs(), derivatives: input.derivatives.map(f64::abs), row: 0 };
            if let Err(range) = to_value(bound.at(last), row.kind) {
                return Err(messages::extrapolated(&row.name, last, range).into());
            }
        }
        self.clock = clock;
        let mut mean = Mean::default();
        for call in 0..calls.count {
            let t = (calls.lead + call as f64 * cycle).max(0.0);
            for input in &self.extrapolations {
                write(&mut self.block, input.row, input.at(t));
            }
            Self::call(&mut self.block, &mut mean);
        }
        for input in &self.extrapolations {
            write(&mut self.block, input.row, input.value);
        }
        Self::show_mean(&mut self.block, mean);
        Ok(())
    }

    /// Makes a step in which calls are events that the host handles between steps. Calls that are due at the start and
    /// have not been handled by the host are made. The step ends early at the next call if that is allowed; otherwise,
    /// the calls within it are made, except one at its end.
    ///
    /// # Errors
    /// As [`Session::step`].
    pub fn step_between_events(&mut self, tc: f64, h: f64, may_return_early: bool) -> Result<Reached, Refusal> {
        let (mut end, mut is_early) = (tc + h, false);
        if may_return_early {
            let mut clock = self.clock.clone();
            let calls = clock.advance(tc, h)?;
            let due = match calls.lead {
                lead if lead > 0.0 => 0,
                lead => (-lead / clock.period() + crate::clock::SAME) as i64 + 1,
            };
            if calls.count > due as u64 {
                let mut present = self.clock.clone();
                present.next += due;
                (end, is_early) = (present.next_call(), true);
            }
        }
        self.step(tc, if is_early { (end - tc).max(0.0) } else { h })?;
        Ok(Reached { end, is_early, is_event: self.clock.is_due() })
    }

    /// Makes the call that is due at the current time, if any. Returns the time of the next one in seconds.
    ///
    /// # Errors
    /// The time is so far from 0 that calls cannot be distinguished.
    pub fn handle_event(&mut self) -> Result<f64, Refusal> {
        if self.clock.make_due_call()? {
            Self::call_once(&mut self.block);
        }
        Ok(self.clock.next_call())
    }

    // The browser page is optimized for size, not speed: there, each law is compiled only once.
    #[cfg_attr(target_family = "wasm", inline(never))]
    #[cfg_attr(not(target_family = "wasm"), inline(always))]
    fn call(block: &mut B, mean: &mut Mean) {
        block.call();
        if B::HAS_MEAN {
            mean.add(block.pulse());
        }
    }

    /// Makes the only call of a step that contains exactly one.
    #[inline(always)]
    pub(crate) fn call_once(block: &mut B) {
        let mut mean = Mean::default();
        Self::call(block, &mut mean);
        Self::show_mean(block, mean);
    }

    #[inline(always)]
    pub(crate) fn show_mean(block: &mut B, mean: Mean) {
        if B::HAS_MEAN {
            block.set_mean(mean.percent(block.pulse()));
        }
    }

    /// Checks one time derivative for [`Session::set_derivatives`].
    ///
    /// # Errors
    /// The row is not a REAL or LREAL input, the order is not 1 to 4, or the derivative is not finite.
    pub fn check_derivative<S: TableText>(row: &Row<S>, order: i32, derivative: f64) -> Result<(), Refusal> {
        if row.role != Role::Input || !matches!(row.kind, Kind::Real | Kind::LReal) {
            return Err(messages::no_real_input(&row.name).into());
        }
        if !(1..=ORDERS as i32).contains(&order) {
            return Err(messages::wrong_order(&row.name, order).into());
        }
        if !derivative.is_finite() {
            return Err(messages::endless_derivative(&row.name, derivative).into());
        }
        Ok(())
    }

    /// Sets time derivatives of inputs as (row, order, derivative), each checked by [`Session::check_derivative`]: in
    /// all subsequent steps, the block sees the input extrapolated from the start of the step. A derivative holds until
    /// it is changed; 0 removes it.
    pub fn set_derivatives(&mut self, derivatives: impl Iterator<Item = (u32, i32, f64)>) {
        for (row, order, derivative) in derivatives {
            let place = self.extrapolations.iter().position(|known| known.row == row).unwrap_or_else(|| {
                self.extrapolations.push(Extrapolation { row, value: 0.0, derivatives: [0.0; ORDERS] });
                self.extrapolations.len() - 1
            });
            self.extrapolations[place].derivatives[order as usize - 1] = derivative;
        }
        self.extrapolations.retain(|known| known.derivatives != [0.0; ORDERS]);
    }
}

impl<B: Cyclic> Session<B> {
    /// Appends the session to `bytes`.
    pub fn store(&self, bytes: &mut Vec<u8>) {
        self.clock.write(bytes);
        self.extrapolations.write(bytes);
        self.block.store(bytes);
    }

    /// Restores the session that [`Session::store`] wrote; `None` if `bytes` does not begin with one. `block` is any
    /// block with the same table.
    pub fn restored(block: &B, bytes: &mut &[u8]) -> Option<Self> {
        let clock = Clock::read(bytes)?;
        let extrapolations = Vec::<Extrapolation>::read(bytes)?;
        if extrapolations.iter().any(|input| input.row as usize >= block.table().rows.len()) {
            return None;
        }
        Some(Session { block: block.restored(bytes)?, clock, extrapolations })
    }
}

/// The end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// The time in seconds.
    pub end: f64,
    /// Whether this is before the requested end.
    pub is_early: bool,
    /// Whether a call that the host must handle as an event is due at this time.
    pub is_event: bool,
}

/// An input extrapolated within a step.
#[derive(Clone, Debug)]
pub(crate) struct Extrapolation {
    row: u32,
    /// The input's own value, saved while a step replaces it with extrapolated ones; meaningless between steps.
    value: f64,
    /// The first to fourth derivatives.
    derivatives: [f64; ORDERS],
}

impl Extrapolation {
    /// The value `t` seconds after the start of the step.
    fn at(&self, t: f64) -> f64 {
        let mut sum = self.value;
        let mut factor = 1.0;
        for (order, derivative) in (1u32..).zip(self.derivatives) {
            factor *= t / f64::from(order);
            sum += derivative * factor;
        }
        sum
    }
}

impl Stored for Extrapolation {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.row.write(bytes);
        self.derivatives.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some(Extrapolation { row: Stored::read(bytes)?, value: 0.0, derivatives: Stored::read(bytes)? })
    }
}

fn write<B: Cyclic>(block: &mut B, row: u32, value: f64) {
    if let Ok(value) = to_value(value, block.table().rows[row as usize].kind) {
        block.set(row as usize, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_block::{Sum, U, V};

    fn restarted() -> Session<Sum> {
        let mut session = Session::new(Sum::default());
        session.restart(0.0, f64::INFINITY).unwrap();
        session
    }

    fn bytes(session: &Session<Sum>) -> Vec<u8> {
        let mut bytes = Vec::new();
        session.store(&mut bytes);
        bytes
    }

    #[test]
    fn inputs_with_derivatives_are_extrapolated_to_each_call_and_keep_their_own_value() {
        // u(t) = 1 + 10 t, v(t) = 5 t^2 / 2 + t^3 at t = 0, 0.1, 0.2, 0.3, 0.4.
        let mut session = restarted();
        session.block.u = 1.0;
        session.set_derivatives([(U, 1, 10.0), (V, 2, 5.0), (V, 3, 6.0)].into_iter());
        session.step(0.0, 0.5).unwrap();
        let u: f64 = 1.0 + 2.0 + 3.0 + 4.0 + 5.0;
        let v = 2.5 * (0.01 + 0.04 + 0.09 + 0.16) + (0.001 + 0.008 + 0.027 + 0.064);
        assert!((session.block.sum - u - v).abs() < 1e-6);
        assert_eq!((session.block.u, session.block.v), (1.0, 0.0));
    }

    #[test]
    fn a_derivative_of_0_takes_the_extrapolation_back() {
        let mut session = restarted();
        session.set_derivatives([(U, 1, 10.0)].into_iter());
        session.set_derivatives([(U, 1, 0.0)].into_iter());
        assert!(session.extrapolations.is_empty());
    }

    #[test]
    fn an_extrapolation_begins_at_the_step_and_calls_made_up_for_see_its_first_value() {
        let mut session = restarted();
        session.step(0.0, 0.1).unwrap();
        session.set_derivatives([(U, 1, 10.0)].into_iter());
        // tc = 0.35: the calls at 0.1, 0.2 and 0.3 see u = 0, the one at 0.4 sees 0.5.
        session.step(0.35, 0.1).unwrap();
        assert_eq!(session.block.count, 5);
        assert!((session.block.sum - 0.5).abs() < 1e-6);
    }

    #[test]
    fn an_extrapolation_out_of_range_is_refused_before_any_call() {
        let mut session = restarted();
        session.set_derivatives([(U, 1, 1e38)].into_iter());
        session.step(0.0, 1.0).unwrap();
        let before = bytes(&session);
        let refusal = session.step(1.0, 100.0).unwrap_err();
        assert!(refusal.reason().starts_with("U, extrapolated over 100.0 s, may leave its range"));
        assert_eq!(bytes(&session), before);
    }

    #[test]
    fn the_mean_is_that_of_the_last_step_and_the_held_state_in_a_step_without_a_call() {
        let mut session = restarted();
        assert_eq!(session.block.q_mean, 0.0);
        session.step(0.0, 0.8).unwrap();
        assert_eq!(session.block.q_mean, 25.0, "calls 1 and 5 of 8");
        session.step(0.8, 0.15).unwrap();
        assert_eq!(session.block.q_mean, 50.0, "call 9 of 9 and 10");
        session.step(0.95, 0.05).unwrap();
        assert_eq!(session.block.q_mean, 0.0, "no call; call 10 left no pulse");
    }

    #[test]
    fn a_step_of_0_makes_no_call_and_shows_the_held_pulse_whatever_is_extrapolated() {
        let mut session = restarted();
        session.step(0.0, 0.5).unwrap();
        assert_eq!((session.block.count, session.block.q_mean), (5, 40.0));
        session.set_derivatives([(U, 1, 3e38)].into_iter());
        for (tc, h) in [(0.5, 0.0), (0.5, -0.0), (0.75, 0.0)] {
            session.step(tc, h).unwrap();
            assert_eq!((session.block.count, session.block.sum, session.block.q_mean), (5, 0.0, 100.0), "{tc:?}");
        }
        // The calls at 0.5 and 0.6 are made up for with u = 0, those at 0.7 and 0.8 see it extrapolated.
        session.set_derivatives([(U, 1, 10.0)].into_iter());
        session.step(0.7, 0.2).unwrap();
        assert_eq!(session.block.count, 9);
        assert!((session.block.sum - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_mean_counts_the_pulses_of_a_step_with_extrapolated_inputs_too() {
        let mut session = restarted();
        session.set_derivatives([(U, 1, 10.0)].into_iter());
        session.step(0.0, 0.5).unwrap();
        assert_eq!(session.block.q_mean, 40.0, "calls 1 and 5 of 5");
    }
}
