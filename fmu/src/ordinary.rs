//! A fast path for the ordinary case of what a host does in every control cycle: set inputs or parameters, make a step
//! of one CYCLE from the end of the last one, and read outputs.
//!
//! This module adds no behaviour. The checked functions try the fast ones first. Each does what its checked counterpart
//! does, but only where no check can fail, and returns whether it did; if it did not, nothing has changed, and the
//! checked function takes over. Without this file, all FMUs behave the same but take three times as long.
//!
//! | fast | checked |
//! |---|---|
//! | [`HostType::get_ordinary`], [`HostType::set_ordinary`] | [`Instance::get`](crate::instance::Instance::get), [`Instance::set`](crate::instance::Instance::set) |
//! | [`Session::make_ordinary_step`] | [`Session::step`] |
//! | [`Session::make_ordinary_step_between_events`] | [`Session::step_between_events`] |
//! | [`call_once`](crate::abreast::call_once), for several instances at the same time | all of these |
//! | [`Clock::make_ordinary_step`], [`Clock::check_and_make_ordinary_step`], [`Clock::make_step_between_calls`] | [`Clock::advance`] |

use crate::clock::{Clock, MOST_DRIFT, RESOLUTION, ROUNDINGS, SAME};
use crate::cyclic::Cyclic;
use crate::host_type::{HostType, Version};
use crate::mean::Mean;
use crate::session::Session;
use blocks::table::number;
use blocks::{Kind, Real, Role, Table, Value};

/// The number of steps of one CYCLE that one check covers, including the current one.
const ORDINARY_STEPS: i64 = 1000;

/// A type in which a host passes a value for a REAL.
pub trait Number: Copy {
    /// Whether the number rounds to a finite REAL.
    fn is_real(self) -> bool;

    /// The nearest REAL.
    fn to_real(self) -> Real;
}

impl Number for f64 {
    #[inline(always)]
    fn is_real(self) -> bool {
        number::is_real(self)
    }

    #[inline(always)]
    fn to_real(self) -> Real {
        self as Real
    }
}

impl Number for f32 {
    #[inline(always)]
    fn is_real(self) -> bool {
        self.is_finite()
    }

    #[inline(always)]
    fn to_real(self) -> Real {
        self
    }
}

/// Writes numbers: fastest for one or two REALs or one LREAL, fast for more REALs, and with [`set_values`] for all
/// others.
#[inline(always)]
pub fn set_numbers<V: Version, B: Cyclic>(block: &mut B, references: &[u32], values: &[f64]) -> bool
where
    f64: HostType<V>,
{
    #[inline(never)]
    fn set_many<V: Version, B: Cyclic>(block: &mut B, references: &[u32], values: &[f64]) -> bool
    where
        f64: HostType<V>,
    {
        set_many_reals(block, references, values) || set_values(block, references, values)
    }
    if set_few_reals(block, references, values) {
        return true;
    }
    match (references, values) {
        ([reference], [value]) if set_lreal(block, *reference, *value) => true,
        _ => set_many(block, references, values),
    }
}

/// Writes REALs from 32-bit values if all may be set at any time and all values are finite.
#[inline(always)]
pub fn set_reals<B: Cyclic>(block: &mut B, references: &[u32], values: &[f32]) -> bool {
    set_few_reals(block, references, values) || set_many_reals(block, references, values)
}

/// Writes one or two REALs.
#[inline(always)]
fn set_few_reals<B: Cyclic, T: Number>(block: &mut B, references: &[u32], values: &[T]) -> bool {
    // Not a loop: in one, the compiler would compute the addresses of all REALs first.
    match (references, values) {
        ([reference], [value]) if takes(block, (reference, value)) => put_real(block, *reference, *value),
        ([first, second], [one, other]) if takes(block, (first, one)) && takes(block, (second, other)) => {
            put_real(block, *first, *one);
            put_real(block, *second, *other);
        }
        _ => return false,
    }
    true
}

/// Writes any number of REALs.
#[inline(never)]
fn set_many_reals<B: Cyclic, T: Number>(block: &mut B, references: &[u32], values: &[T]) -> bool {
    #[inline(never)]
    fn put<B: Cyclic>(block: &mut B, reference: u32, value: Real) {
        put_real(block, reference, value);
    }
    let fits = references.iter().zip(values).all(|pair| takes(block, pair));
    if fits {
        references.iter().zip(values).for_each(|(reference, value)| put(block, *reference, value.to_real()));
    }
    fits
}

/// Whether the variable is a REAL that may be set at any time and the value fits a REAL.
#[inline(always)]
fn takes<B: Cyclic, T: Number>(block: &B, (reference, value): (&u32, &T)) -> bool {
    block.table().tunable_reals.get(*reference as usize) == Some(&true) && value.is_real()
}

#[inline(always)]
fn put_real<B: Cyclic, T: Number>(block: &mut B, reference: u32, value: T) {
    if let Some(real) = block.real_mut(reference as usize) {
        *real = value.to_real();
    }
}

/// Writes an LREAL that may be set at any time. Returns false, changing nothing, if the variable is not such an LREAL
/// or the value is not finite.
#[inline]
fn set_lreal<B: Cyclic>(block: &mut B, reference: u32, value: f64) -> bool {
    let fits = block.table().tunable_lreals.get(reference as usize) == Some(&true) && value.is_finite();
    if fits && let Some(lreal) = block.lreal_mut(reference as usize) {
        *lreal = value;
    }
    fits
}

/// Writes inputs and parameters of one type if all have this type and all values are in range.
#[inline]
pub fn set_values<V: Version, B: Cyclic, T: HostType<V>>(block: &mut B, references: &[u32], values: &[T]) -> bool {
    /// A separate function: in a loop, the compiler would compute the addresses of all variables first.
    #[inline(never)]
    fn put<B: Cyclic>(block: &mut B, row: usize, value: Value) {
        block.set(row, value);
    }
    let value_of = |table: &Table<B::Text>, reference: &u32, value: &T| {
        let row = table.rows.get(*reference as usize)?;
        let is_tunable = matches!(row.role, Role::Input | Role::Parameter) && T::is_of(row);
        value.to_plc(row.kind).ok().filter(|_| is_tunable)
    };
    if let ([reference], [value]) = (references, values) {
        let value = value_of(block.table(), reference, value);
        return value.is_some_and(|value| block.set(*reference as usize, value));
    }
    let mut all = references.iter().zip(values);
    if !all.all(|(reference, value)| value_of(block.table(), reference, value).is_some()) {
        return false;
    }
    for (reference, value) in references.iter().zip(values) {
        if let Some(value) = value_of(block.table(), reference, value) {
            put(block, *reference as usize, value);
        }
    }
    true
}

/// Reads numbers: fastest for one or two REALs or one LREAL, and with [`get_values`] for all others.
#[inline(always)]
pub fn get_numbers<V: Version, B: Cyclic>(block: &B, references: &[u32], values: &mut [f64]) -> bool
where
    f64: HostType<V>,
{
    if get_few_reals(block, references, values) {
        return true;
    }
    if let ([reference], [value]) = (references, &mut *values)
        && let Some(lreal) = block.lreal(*reference as usize)
    {
        *value = lreal;
        return true;
    }
    get_many(block, references, values)
}

/// Reads one or two REALs.
#[inline(always)]
fn get_few_reals<B: Cyclic, T: From<Real>>(block: &B, references: &[u32], values: &mut [T]) -> bool {
    match (references, values) {
        ([reference], [value]) => {
            let Some(real) = block.real(*reference as usize) else { return false };
            *value = real.into();
        }
        ([first, second], [one, other]) => {
            let (Some(first), Some(second)) = (block.real(*first as usize), block.real(*second as usize)) else {
                return false;
            };
            (*one, *other) = (first.into(), second.into());
        }
        _ => return false,
    }
    true
}

/// Reads REALs as 32-bit values; returns false if a variable has a different type.
#[inline(always)]
pub fn get_reals<B: Cyclic>(block: &B, references: &[u32], values: &mut [f32]) -> bool {
    #[inline(never)]
    fn real<B: Cyclic>(block: &B, row: usize) -> Option<f32> {
        block.real(row)
    }
    if get_few_reals(block, references, values) {
        return true;
    }
    let rows = &block.table().rows;
    if !references.iter().all(|reference| rows.get(*reference as usize).is_some_and(|row| row.kind == Kind::Real)) {
        return false;
    }
    for (value, reference) in values.iter_mut().zip(references) {
        *value = real(block, *reference as usize).unwrap_or_default();
    }
    true
}

/// Reads REALs and LREALs; if a variable has a different type, reads any numbers.
#[inline(never)]
fn get_many<V: Version, B: Cyclic>(block: &B, references: &[u32], values: &mut [f64]) -> bool
where
    f64: HostType<V>,
{
    let rows = &block.table().rows;
    let is_number =
        |reference: &u32| rows.get(*reference as usize).is_some_and(|row| matches!(row.kind, Kind::Real | Kind::LReal));
    if !references.iter().all(is_number) {
        return get_values(block, references, values);
    }
    for (value, reference) in values.iter_mut().zip(references) {
        *value = real_or_lreal(block, *reference as usize).unwrap_or_default();
    }
    true
}

/// A separate function: in a loop, the compiler would compute the addresses of all variables first.
#[inline(never)]
fn real_or_lreal<B: Cyclic>(block: &B, row: usize) -> Option<f64> {
    block.real(row).map(f64::from).or_else(|| block.lreal(row))
}

/// Reads variables of one type if all have this type.
#[inline]
pub fn get_values<V: Version, B: Cyclic, T: HostType<V>>(block: &B, references: &[u32], values: &mut [T]) -> bool {
    /// A separate function: in a loop, the compiler would compute the addresses of all variables first.
    #[inline(never)]
    fn value<B: Cyclic>(block: &B, row: usize) -> Option<Value> {
        block.get(row)
    }
    if let ([reference], [value]) = (references, &mut *values) {
        // Two host types can hold a WORD; the row determines which one does.
        let is_of = |value: &Value| {
            value.kind() != Kind::Word || block.table().rows.get(*reference as usize).is_some_and(T::is_of)
        };
        let got = block.get(*reference as usize).filter(is_of).and_then(T::from_plc);
        got.into_iter().for_each(|got| *value = got);
        return got.is_some();
    }
    let rows = &block.table().rows;
    if !references.iter().all(|reference| rows.get(*reference as usize).is_some_and(|row| T::is_of(row))) {
        return false;
    }
    for (reference, to) in references.iter().zip(values) {
        if let Some(got) = value(block, *reference as usize).and_then(T::from_plc) {
            *to = got;
        }
    }
    true
}

impl<B: Cyclic> Session<B> {
    /// Makes the ordinary step from one call to the next and returns whether it did. If not, nothing has changed, and
    /// [`Session::step`] must make the step.
    #[inline(always)]
    pub fn make_ordinary_step(&mut self, tc: f64, h: f64) -> bool {
        let is_ordinary = B::IS_SURE
            && self.extrapolations.is_empty()
            && (self.clock.make_ordinary_step(tc, h) || self.clock.check_and_make_ordinary_step(tc, h));
        if is_ordinary {
            Self::call_once(&mut self.block);
        }
        is_ordinary
    }

    /// Advances from a call that the host has handled to the next one, which is then due, and returns whether it did.
    /// If not, nothing has changed, and [`Session::step_between_events`] must make the step.
    #[inline(never)]
    pub fn make_ordinary_step_between_events(&mut self, tc: f64, h: f64) -> bool {
        let is_ordinary = B::IS_SURE && self.extrapolations.is_empty() && self.clock.make_step_between_calls(tc, h);
        if is_ordinary {
            Self::show_mean(&mut self.block, Mean::default());
        }
        is_ordinary
    }
}

impl Clock {
    /// Advances from `tc` to `tc + h` if that is an ordinary step, which contains one call. Returns whether it is.
    #[inline]
    pub fn check_and_make_ordinary_step(&mut self, tc: f64, h: f64) -> bool {
        let is_ordinary = self.is_ordinary(tc, h);
        if is_ordinary {
            self.ordinary_below = if self.stays_ordinary(tc) { self.tick + ORDINARY_STEPS } else { 0 };
            self.advance_by_a_tick(tc, h);
        }
        is_ordinary
    }

    /// Advances from `tc` to `tc + h` if an earlier check has shown that this is an ordinary step, which contains one
    /// call. Returns whether it has.
    #[inline(always)]
    pub fn make_ordinary_step(&mut self, tc: f64, h: f64) -> bool {
        // Comparing bits is faster than comparing numbers. If 0 meets -0, `advance` makes the step.
        let is_ordinary = self.tick < self.ordinary_below
            && tc.to_bits() == self.end.to_bits()
            && h.to_bits() == self.period.to_bits();
        if is_ordinary {
            debug_assert!(self.is_ordinary(tc, h));
            self.advance_by_a_tick(tc, h);
        }
        is_ordinary
    }

    #[inline(always)]
    fn advance_by_a_tick(&mut self, tc: f64, h: f64) {
        self.tick += 1;
        self.next = self.tick;
        self.end = tc + h;
        self.since += h;
    }

    /// Advances from a tick whose call has been made to the next tick. Returns whether `tc` and `h` match that step.
    #[inline]
    pub fn make_step_between_calls(&mut self, tc: f64, h: f64) -> bool {
        // `rounding` is negative if `period` has a rounding error, which only `advance` accounts for.
        let is_ordinary = self.next == self.tick + 1 && self.rounding >= 0.0 && self.is_from_tick_to_tick(tc, h);
        if is_ordinary {
            self.advance_by_a_tick(tc, h);
        }
        is_ordinary
    }

    /// Whether the step contains exactly one call, at its start.
    #[inline]
    pub fn is_ordinary(&self, tc: f64, h: f64) -> bool {
        self.next == self.tick && self.is_from_tick_to_tick(tc, h)
    }

    /// Whether a step goes from the end of the last one, at a tick, to the next tick. No check in `check_and_advance`
    /// can then fail, and the result is the same.
    #[inline]
    fn is_from_tick_to_tick(&self, tc: f64, h: f64) -> bool {
        h == self.period
            && self.offset == 0.0
            && tc < self.horizon
            && if tc == self.end { self.drift(tc) < MOST_DRIFT * self.cycle } else { self.is_at_tick(tc) }
    }

    /// Whether `tc` differs from the tick at which the last step ended only by the rounding of a host that recomputes
    /// its communication points: 6 * 0.1 is not 5 * 0.1 + 0.1.
    #[inline]
    pub(crate) fn is_at_tick(&self, tc: f64) -> bool {
        // If `tc` is not finite, the magnitude is that of `end`.
        let rounding = self.rounding * tc.abs().min(self.end.abs()).max(self.start.abs());
        self.drift(tc) <= rounding && (self.end - tc) * 1000.0 <= SAME * self.cycle + rounding
    }

    /// The difference between the host's time and the clock's tick, in milliseconds.
    fn drift(&self, tc: f64) -> f64 {
        ((tc - self.start) * 1000.0 - self.tick as f64 * self.cycle).abs()
    }

    /// Whether, after an ordinary step from `tc`, the next `ORDINARY_STEPS` steps of one CYCLE are ordinary too: they
    /// end before the horizon, and the rounding errors of `end` cannot add up to the permitted drift.
    fn stays_ordinary(&self, tc: f64) -> bool {
        let steps = ORDINARY_STEPS as f64 + 1.0;
        let last = tc + steps * self.period;
        let rounding = ROUNDINGS * RESOLUTION * tc.abs().max(last.abs()).max(self.start.abs());
        last < self.horizon && self.drift(tc) + steps * rounding < 0.9 * MOST_DRIFT * self.cycle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_block::{COUNT, CYCLE, FACTOR, FIRST, ON, SUM, Sum, U, V};
    use crate::v2::Fmi2;
    use crate::v2::value::Boolean;

    #[test]
    fn reals_and_lreals_are_read_at_once_and_nothing_is_if_one_is_of_another_type() {
        let block = Sum { u: 0.5, v: 0.1, sum: -3.0, ..Sum::default() };
        let mut values = [9.0; 3];
        assert!(get_numbers::<Fmi2, _>(&block, &[V, U, SUM], &mut values));
        assert_eq!(values, [0.1, 0.5, -3.0]);
        let mut values = [9.0; 2];
        for other in [ON, FIRST, COUNT, 1000, u32::MAX] {
            assert!(!get_numbers::<Fmi2, _>(&block, &[V, other], &mut values), "{other}");
            assert_eq!(values, [9.0; 2]);
        }
    }

    #[test]
    fn an_lreal_is_set_at_once_if_it_is_an_input_and_the_value_a_number() {
        let mut block = Sum::default();
        assert!(set_numbers::<Fmi2, _>(&mut block, &[V], &[0.1]));
        assert_eq!(block.v, 0.1);
        for (reference, value) in [(V, f64::NAN), (V, f64::INFINITY), (SUM, 1.0), (CYCLE, 1.0), (ON, 1.0), (1000, 1.0)]
        {
            assert!(!set_numbers::<Fmi2, _>(&mut block, &[reference], &[value]), "{reference}");
        }
        assert_eq!((block.v, block.sum), (0.1, 0.0));
    }

    #[test]
    fn any_number_of_values_is_set_at_once_and_nothing_is_if_one_is_refused() {
        let mut block = Sum::default();
        assert!(set_numbers::<Fmi2, _>(&mut block, &[U, FACTOR, U], &[1.0, 2.0, 3.0]));
        assert!(set_numbers::<Fmi2, _>(&mut block, &[V, FACTOR], &[0.1, 4.0]));
        assert_eq!((block.u, block.factor, block.v), (3.0, 4.0, 0.1));
        let beyond = f64::from(f32::MAX) * 2.0;
        for (reference, value) in [(SUM, 1.0), (CYCLE, 1.0), (ON, 1.0), (U, beyond), (V, f64::NAN), (1000, 1.0)] {
            assert!(!set_numbers::<Fmi2, _>(&mut block, &[U, FACTOR, reference], &[5.0, 5.0, value]), "{reference}");
            assert!(!set_numbers::<Fmi2, _>(&mut block, &[V, reference], &[5.0, value]), "{reference}");
        }
        assert_eq!((block.u, block.factor, block.v), (3.0, 4.0, 0.1));
    }

    #[test]
    fn reals_given_as_such_are_set_and_read_at_once_and_none_is_if_one_is_refused() {
        let mut block = Sum::default();
        for references in [&[U][..], &[U, FACTOR], &[U, FACTOR, U]] {
            let values = [0.1, 2.5, 0.3].map(|value: f32| value * references.len() as f32);
            let values = &values[..references.len()];
            assert!(set_reals(&mut block, references, values));
            assert_eq!(block.u, values[if references.len() == 3 { 2 } else { 0 }]);
            let mut got = vec![0.0; references.len()];
            assert!(get_reals(&block, references, &mut got));
            assert_eq!(got[0], block.u);
        }
        let (u, factor) = (block.u, block.factor);
        assert_eq!(factor, 7.5);
        for (reference, value) in [(V, 1.0), (ON, 1.0), (1000, 1.0), (U, f32::NAN), (U, f32::INFINITY)] {
            for references in [&[reference][..], &[FACTOR, reference], &[FACTOR, U, reference]] {
                let mut values = vec![5.0; references.len()];
                values[references.len() - 1] = value;
                assert!(!set_reals(&mut block, references, &values), "{references:?}");
            }
        }
        assert_eq!((block.u, block.factor), (u, factor));
        let mut got = [9.0; 3];
        assert!(!get_reals(&block, &[U, V], &mut got[..2]) && !get_reals(&block, &[U, FACTOR, ON], &mut got));
        assert_eq!(got, [9.0; 3]);
    }

    #[test]
    fn a_step_between_two_events_comes_to_the_same_as_the_checked_one() {
        let mut ordinary = Session::new(Sum::default());
        ordinary.restart(0.0, f64::INFINITY).unwrap();
        let mut checked = ordinary.clone();
        for k in 0..20 {
            let tc = ordinary.end();
            for session in [&mut ordinary, &mut checked] {
                session.block.u = k as f32;
                session.handle_event().unwrap();
            }
            assert!(ordinary.make_ordinary_step_between_events(tc, 0.1), "step {k}");
            let reached = checked.step_between_events(tc, 0.1, k % 2 == 0).unwrap();
            assert!((reached.end, reached.is_early, reached.is_event) == (tc + 0.1, false, true));
            let bytes = [&ordinary, &checked].map(|session| {
                let mut bytes = Vec::new();
                session.store(&mut bytes);
                bytes
            });
            assert_eq!(bytes[0], bytes[1], "step {k}");
        }
        assert_eq!(ordinary.block.count, 20);
    }

    #[test]
    fn booleans_and_integers_are_set_and_read_at_once_if_the_block_may_see_them_at_any_time() {
        let mut block = Sum { count: 7, ..Sum::default() };
        assert!(set_values::<Fmi2, _, _>(&mut block, &[ON], &[Boolean(-1)]) && block.on);
        assert!(set_values::<Fmi2, _, _>(&mut block, &[ON, ON], &[Boolean(1), Boolean(0)]) && !block.on);
        assert!(!set_values::<Fmi2, _, _>(&mut block, &[ON, U], &[Boolean(1); 2]) && !block.on);
        assert!(
            !set_values::<Fmi2, _, _>(&mut block, &[FIRST], &[1])
                && !set_values::<Fmi2, _, _>(&mut block, &[COUNT], &[1])
        );
        let mut integers = [-1; 2];
        assert!(get_values::<Fmi2, _, _>(&block, &[COUNT], &mut integers[..1]) && integers == [7, -1]);
        assert!(!get_values::<Fmi2, _, _>(&block, &[COUNT, ON], &mut integers) && integers == [7, -1]);
        assert!(get_values::<Fmi2, _, _>(&block, &[FIRST, COUNT], &mut integers) && integers == [0, 7]);
        let mut seconds = [9.0; 2];
        assert!(get_numbers::<Fmi2, _>(&block, &[CYCLE, CYCLE], &mut seconds) && seconds == [0.1; 2]);
    }
}
