//! When is the block called: integer ticks of whole milliseconds.
//!
//! The block is called at `t_k = start + k * CYCLE`, k = 0, 1, 2, ..., as by a cyclic interrupt, whatever the
//! communication step: a step makes every call with `tc <= t_k < tc + h`.
//!
//! Hosts compute `tc` in one of two ways, which need opposite treatment:
//!
//! - A host that adds up: `tc` is, to the last bit, the sum of the last step's `tc` and `h`, or of the start time and all
//!   `h` so far. Such a time drifts by the rounding of every addition (0.01 s added a million times is off by 1.7e-7 s), and
//!   a clock that relied on it would eventually make two calls in one step. So the clock keeps a time of its own, a tick
//!   counter and an offset from that tick, and adds each `h` to it, as long as rounding can explain the difference from
//!   `tc`.
//! - A host that computes `tc` anew for every step. Its `h` may be inexact: rounded to 32 bits, or written with a few
//!   decimals. A clock that added up such an `h` would eventually make a call one step early. So the clock continues from
//!   `tc`.
//!
//! If the host is ahead, the clock follows it and makes the calls in between.
//!
//! Limits: the rounding of a double grows with |t|, a CYCLE does not.
//!
//! - Up to |t| / CYCLE = 2^47 (4 000 years at 1 ms), every call is made exactly once, in the step that holds it, if the
//!   host computes its points anew. Beyond that, where a double hardly distinguishes one call from the next, a step is
//!   refused.
//! - Accumulated drift up to CYCLE / 4 is corrected; beyond that the clock follows the host, and one step makes a call more
//!   or less than the others. From 0 on this takes at least 6e7 steps of CYCLE; at |t| / CYCLE = 1e12 (1e9 s at 1 ms) at
//!   least 2 000.
//! - An `h` whose error is below the rounding of `tc` cannot be told from the step of a host that adds up. For a 32-bit `h`
//!   this begins at |t| / CYCLE = 1e8.

use crate::refusal::Refusal;
use blocks::{Stored, Time};

/// Two times that differ by less than this fraction of a CYCLE are the same.
const SAME: f64 = 1e-6;

/// How far the time of a host that adds up may drift from the clock's, as a fraction of a CYCLE. Beyond it the host is
/// followed.
const MOST_DRIFT: f64 = 0.25;

/// How many roundings of a double, beyond the accumulated ones, may separate two times that are meant to be the same: that
/// of start, of tc, of their difference and of its conversion to milliseconds.
const ROUNDINGS: f64 = 4.0;

/// The resolution of a double at 1 s, in milliseconds.
const RESOLUTION: f64 = f64::EPSILON * 1000.0;

/// So many steps are known to be ordinary after one look.
const ORDINARY_STEPS: i64 = 1000;

/// No step makes more calls than this: a day at 1 ms is 86 million.
const MOST_CALLS: f64 = 4_294_967_296.0;

/// The time of one block. Positions are milliseconds since the start.
#[derive(Clone, Debug)]
pub struct Clock {
    /// Start time in seconds.
    start: f64,
    /// Stop time in seconds; infinite if there is none.
    stop: f64,
    /// Time between two calls: a whole number of milliseconds.
    cycle: f64,
    /// Its reciprocal, so that a step needs no division.
    per_cycle: f64,
    /// The same in seconds.
    period: f64,
    /// Up to this time, in seconds, a step of one CYCLE can neither reach the stop time nor be beyond what a double
    /// resolves.
    horizon: f64,
    /// By what part of a time's magnitude it may be off by rounding and still be ordinary, per 1000; below 0 where a step of one
    /// CYCLE leaves a rounding of its own.
    rounding: f64,
    /// Below this tick, every step of one CYCLE from where the last one ended is an ordinary one.
    ordinary_below: i64,
    /// The number k of the next call.
    next: i64,
    /// The present time is `tick * cycle + offset`.
    tick: i64,
    offset: f64,
    /// The end of the last step in seconds, as the host gave it; the furthest end if the last step began a little before
    /// it.
    end: f64,
    /// The sum of all steps since the start, in seconds, as a host would add them up.
    since: f64,
}

/// The calls of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calls {
    /// How many.
    pub count: u64,
    /// From the start of the step to the first of them, in seconds; negative if the host is ahead and the step makes up
    /// for calls.
    pub lead: f64,
}

impl Clock {
    /// A clock that stands at `start`; `stop` is infinite if there is none.
    pub fn new(start: f64, stop: f64, cycle: Time) -> Clock {
        Clock {
            start,
            stop,
            cycle: f64::from(cycle.milliseconds()),
            per_cycle: 0.0,
            period: 0.0,
            horizon: 0.0,
            rounding: 0.0,
            ordinary_below: 0,
            next: 0,
            tick: 0,
            offset: 0.0,
            end: start,
            since: 0.0,
        }
        .with_constants()
    }

    /// Computes what follows from start, stop and cycle.
    fn with_constants(mut self) -> Clock {
        self.per_cycle = 1.0 / self.cycle;
        self.period = self.cycle / 1000.0;
        self.rounding = if self.period * 1000.0 == self.cycle { ROUNDINGS * RESOLUTION } else { -1.0 };
        let resolved = 0.1 * self.cycle / (ROUNDINGS * RESOLUTION);
        self.horizon =
            if self.start.abs() < resolved { resolved.min(self.stop - 2.0 * self.period) } else { f64::NEG_INFINITY };
        self
    }

    /// The time between two calls in seconds.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The end of the last step in seconds, as the host counts.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// Goes from `tc` to `tc + h` (seconds) and says which calls lie in between. If `h` is 0, there are none, and the clock
    /// stays where it is.
    ///
    /// # Errors
    /// `tc` or `h` is not a valid time; `tc` is before the end of the last step, or `tc + h` after the stop time, by more
    /// than rounding. The clock stays where it is.
    pub fn advance(&mut self, tc: f64, h: f64) -> Result<Calls, Refusal> {
        if self.check_and_make_ordinary_step(tc, h) {
            return Ok(Calls { count: 1, lead: 0.0 });
        }
        self.check_and_advance(tc, h)
    }

    /// Goes from `tc` to `tc + h` if that is an ordinary step, which holds one call, and says whether it is.
    #[inline]
    pub fn check_and_make_ordinary_step(&mut self, tc: f64, h: f64) -> bool {
        let is_ordinary = self.is_ordinary(tc, h);
        if is_ordinary {
            self.ordinary_below = if self.stays_ordinary(tc) { self.tick + ORDINARY_STEPS } else { 0 };
            self.advance_by_a_tick(tc, h);
        }
        is_ordinary
    }

    /// Goes from `tc` to `tc + h` if that is known to be an ordinary step, which holds one call, and says whether it is.
    #[inline(always)]
    pub fn make_ordinary_step(&mut self, tc: f64, h: f64) -> bool {
        // Bits are compared faster than numbers. Where 0 stands against -0, `advance` makes the step.
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

    /// The ordinary step goes from where the last one ended, at a tick, to the next tick: nothing that `check_and_advance`
    /// checks can fail then, and the result is the same.
    #[inline]
    fn is_ordinary(&self, tc: f64, h: f64) -> bool {
        h == self.period
            && self.offset == 0.0
            && self.next == self.tick
            && tc < self.horizon
            && if tc == self.end { self.drift(tc) < MOST_DRIFT * self.cycle } else { self.is_at_tick(tc) }
    }

    /// Whether only the rounding of a host that computes its points anew separates `tc` from the tick at which the last step
    /// ended: 6 * 0.1 is not 5 * 0.1 + 0.1.
    #[inline]
    fn is_at_tick(&self, tc: f64) -> bool {
        // Of a `tc` that is not finite, the magnitude is that of `end`.
        let rounding = self.rounding * tc.abs().min(self.end.abs()).max(self.start.abs());
        self.drift(tc) <= rounding && (self.end - tc) * 1000.0 <= SAME * self.cycle + rounding
    }

    /// How far the host's time is from the clock's tick, in milliseconds.
    fn drift(&self, tc: f64) -> f64 {
        ((tc - self.start) * 1000.0 - self.tick as f64 * self.cycle).abs()
    }

    /// Whether, after an ordinary step from `tc` on, the next `ORDINARY_STEPS` steps of one CYCLE are ordinary too: they
    /// end before the horizon, and the roundings of `end` cannot add up to the drift that is allowed.
    fn stays_ordinary(&self, tc: f64) -> bool {
        let steps = ORDINARY_STEPS as f64 + 1.0;
        let last = tc + steps * self.period;
        let rounding = ROUNDINGS * RESOLUTION * tc.abs().max(last.abs()).max(self.start.abs());
        last < self.horizon && self.drift(tc) + steps * rounding < 0.9 * MOST_DRIFT * self.cycle
    }

    fn check_and_advance(&mut self, tc: f64, h: f64) -> Result<Calls, Refusal> {
        let cycle = self.cycle;
        // NaN lies in no range.
        if !((0.0..f64::INFINITY).contains(&h) && tc.abs() < f64::INFINITY) {
            return Err(no_time(tc, h));
        }
        let magnitude = if tc.abs() > self.start.abs() { tc.abs() } else { self.start.abs() };
        let same = SAME * cycle + ROUNDINGS * RESOLUTION * magnitude;
        if same > 0.125 * cycle {
            return Err(no_resolution(tc, self.period));
        }
        if (self.end - tc) * 1000.0 > same {
            return Err(before_end(tc, self.end));
        }

        let adds_up = tc == self.end || tc == self.start + self.since;
        let rounding = if adds_up { MOST_DRIFT * cycle } else { ROUNDINGS * RESOLUTION * magnitude };
        let (mut tick, mut offset, mut since) = (self.tick, self.offset, self.since);
        let position = (tc - self.start) * 1000.0;
        if (position - (tick as f64 * cycle + offset)).abs() > rounding {
            tick = floor(position * self.per_cycle);
            offset = position - tick as f64 * cycle;
            since = tc - self.start;
        }

        let mut step = h * 1000.0;
        let present = tick as f64 * cycle + offset;
        if self.stop < f64::INFINITY {
            let beyond = present + step - (self.stop - self.start) * 1000.0;
            if beyond > 0.0 {
                if beyond.min((tc + h - self.stop) * 1000.0) > same {
                    return Err(after_stop(tc, h, self.stop));
                }
                step -= beyond;
            }
        }

        if h == 0.0 {
            // Some hosts end a run with such a step. It makes no call, not even one that is due, and moves nothing.
            return Ok(Calls { count: 0, lead: 0.0 });
        }

        let first = self.next;
        let lead = first as f64 * cycle - present;
        // A long step has rounding of its own.
        let tolerance = (same + ROUNDINGS * f64::EPSILON * step) * self.per_cycle;
        let cycles = (offset + step) * self.per_cycle;
        if cycles + (tick - first) as f64 > MOST_CALLS {
            return Err(too_many_calls(tc, h, self.end, self.period));
        }
        let passed = floor(cycles + tolerance);
        self.ordinary_below = 0;
        self.tick = tick + passed;
        self.next = (tick + ceil(cycles - tolerance)).max(first);
        self.offset = offset + step - passed as f64 * cycle;
        // The furthest end: steps that each begin within the tolerance before it must not take the host back.
        self.end = if tc + h > self.end { tc + h } else { self.end };
        self.since = since + h;
        Ok(Calls { count: (self.next - first) as u64, lead: if lead.abs() > same { lead / 1000.0 } else { 0.0 } })
    }
}

// The messages stand in functions of their own, so that a step that is not refused does not carry their code along.

#[cold]
fn no_time(tc: f64, h: f64) -> Refusal {
    format!(
        "currentCommunicationPoint = {tc:?}, communicationStepSize = {h:?}: the point must be finite, the step finite \
         and not below 0"
    )
    .into()
}

#[cold]
fn no_resolution(tc: f64, cycle: f64) -> Refusal {
    format!(
        "currentCommunicationPoint = {tc:?}: this far from 0, a double no longer distinguishes one CYCLE of {cycle} s from \
         the next; start nearer to 0"
    )
    .into()
}

#[cold]
fn before_end(tc: f64, end: f64) -> Refusal {
    format!(
        "currentCommunicationPoint = {tc:?} is before {end:?}, where the last step ended; to go back, restore an FMU \
         state"
    )
    .into()
}

#[cold]
fn after_stop(tc: f64, h: f64, stop: f64) -> Refusal {
    format!(
        "currentCommunicationPoint = {tc:?}, communicationStepSize = {h:?}: the step ends after stopTime = {stop:?}"
    )
    .into()
}

#[cold]
fn too_many_calls(tc: f64, h: f64, end: f64, cycle: f64) -> Refusal {
    format!(
        "currentCommunicationPoint = {tc:?}, communicationStepSize = {h:?}: from {end:?} on, with one call every {cycle} s, \
         this is more than {MOST_CALLS} calls; make the step shorter"
    )
    .into()
}

/// The floor of a number of cycles, 0 where it is negative by rounding. (`f64::floor` is a library call on processors
/// without SSE 4.1, which a portable library cannot ask for.)
fn floor(x: f64) -> i64 {
    x as i64
}

fn ceil(x: f64) -> i64 {
    let floor = x as i64;
    floor + i64::from(x > floor as f64)
}

impl Stored for Clock {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.start.write(bytes);
        self.stop.write(bytes);
        self.cycle.write(bytes);
        self.next.write(bytes);
        self.tick.write(bytes);
        self.offset.write(bytes);
        self.end.write(bytes);
        self.since.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let (start, stop, cycle) = (f64::read(bytes)?, f64::read(bytes)?, f64::read(bytes)?);
        let clock = Clock {
            start,
            stop,
            cycle,
            per_cycle: 0.0,
            period: 0.0,
            horizon: 0.0,
            rounding: 0.0,
            ordinary_below: 0,
            next: Stored::read(bytes)?,
            tick: Stored::read(bytes)?,
            offset: Stored::read(bytes)?,
            end: Stored::read(bytes)?,
            since: Stored::read(bytes)?,
        };
        clock.is_possible().then_some(clock.with_constants())
    }
}

impl Clock {
    /// Whether a sequence of steps can lead to this state. No other state may be restored: it could ask for endless calls.
    fn is_possible(&self) -> bool {
        const LAST_TICK: i64 = 1 << 53;
        (0.0..=f64::from(i32::MAX)).contains(&self.cycle)
            && self.start.is_finite()
            && self.end.is_finite()
            && self.since.is_finite()
            && self.stop >= self.start
            && (0..=LAST_TICK).contains(&self.tick)
            && (self.tick..=self.tick + 2).contains(&self.next)
            && self.offset.abs() <= 2.0 * self.cycle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(start: f64, cycle: i32) -> Clock {
        Clock::new(start, f64::INFINITY, Time::ms(cycle))
    }

    fn calls(clock: &mut Clock, tc: f64, h: f64) -> u64 {
        clock.advance(tc, h).unwrap().count
    }

    fn advanced(clock: &mut Clock, tc: f64, h: f64) -> (u64, f64) {
        let calls = clock.advance(tc, h).unwrap();
        (calls.count, calls.lead)
    }

    #[test]
    fn a_step_of_cycle_is_one_call_and_a_step_of_ten_is_ten() {
        let mut clock = clock(0.0, 1000);
        assert_eq!(calls(&mut clock, 0.0, 1.0), 1);
        assert_eq!(calls(&mut clock, 1.0, 10.0), 10);
        assert_eq!(calls(&mut clock, 11.0, 1.0), 1);
    }

    #[test]
    fn of_ten_steps_of_a_tenth_the_first_makes_the_call() {
        let mut clock = clock(0.0, 1000);
        let made: Vec<u64> = (0..20).map(|i| calls(&mut clock, f64::from(i) * 0.1, 0.1)).collect();
        assert_eq!(made, [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn a_call_belongs_to_the_step_that_begins_at_it_and_not_to_the_one_that_ends_there() {
        let mut clock = clock(5.0, 100);
        assert_eq!(calls(&mut clock, 5.0, 0.05), 1, "t = 5.0");
        assert_eq!(calls(&mut clock, 5.05, 0.05), 0, "t = 5.1 is the next step's");
        assert_eq!(calls(&mut clock, 5.1, 0.15), 2, "t = 5.1 and 5.2");
    }

    #[test]
    fn two_times_within_a_millionth_of_cycle_are_one() {
        assert_eq!(calls(&mut clock(0.0, 1000), 0.0, 1.0 + 0.9e-6), 1);
        assert_eq!(calls(&mut clock(0.0, 1000), 0.0, 1.0 + 1.1e-6), 2);
        assert_eq!(calls(&mut clock(0.0, 1), 0.0, 0.001 + 0.9e-9), 1);
        assert_eq!(calls(&mut clock(0.0, 1), 0.0, 0.001 + 1.1e-9), 2);
    }

    #[test]
    fn the_tolerance_does_not_grow_with_time() {
        // At 1e5 s a double resolves 1.5e-11 s. A step that reaches 1e-5 of a CYCLE beyond t_1 holds it.
        assert_eq!(calls(&mut clock(1e5, 100), 1e5, 0.1), 1);
        assert_eq!(calls(&mut clock(1e5, 100), 1e5, 0.1 + 1e-6), 2);
    }

    #[test]
    fn a_step_of_0_makes_no_call_and_leaves_the_clock_where_it_is() {
        let mut clock = Clock::new(5.0, 8.0, Time::ms(1000));
        for tc in [5.0, 5.3, 7.0, 8.0] {
            assert_eq!(advanced(&mut clock, tc, 0.0), (0, 0.0), "{tc}");
            assert_eq!(clock.end(), 5.0);
        }
        assert_eq!(calls(&mut clock, 5.0, 1.0), 1);
        assert_eq!(calls(&mut clock, 6.0, 0.0), 0);
        assert_eq!(calls(&mut clock, 6.0, 2.0), 2);
        assert_eq!(calls(&mut clock, 8.0, 0.0), 0, "at the stop time");
    }

    #[test]
    fn a_step_of_0_is_refused_where_any_other_would_be() {
        let mut clock = Clock::new(0.0, 8.0, Time::ms(1000));
        clock.advance(0.0, 5.0).unwrap();
        let mut reason = |tc, h| clock.advance(tc, h).unwrap_err().reason().to_string();
        assert!(reason(4.9, 0.0).contains("before 5.0"));
        assert!(reason(8.1, 0.0).contains("stopTime"));
        assert!(reason(f64::NAN, 0.0).contains("must be finite"));
        assert!(reason(5.0, -1e-300).contains("not below 0"));
    }

    #[test]
    fn residual_steps_make_no_call_and_lose_none() {
        let mut clock = clock(0.0, 1000);
        for k in 0..100 {
            let t = f64::from(k);
            assert_eq!(calls(&mut clock, t, 1.0), 1, "call {k}");
            assert_eq!(calls(&mut clock, t + 1.0, 1e-16), 0, "residual step after call {k}");
        }
    }

    #[test]
    fn a_host_that_adds_up_its_time_gets_one_call_in_every_step() {
        // 0.01 s added a million times is 10000.000000171856: 17 times the tolerance.
        let mut clock = clock(0.0, 10);
        let mut tc = 0.0;
        for k in 0..1_000_000 {
            assert_eq!(calls(&mut clock, tc, 0.01), 1, "step {k} at {tc:?}");
            tc += 0.01;
        }
        assert_eq!(tc, 10_000.000000171856);
    }

    #[test]
    fn a_host_that_adds_up_steps_of_a_tenth_of_cycle_gets_the_call_in_the_first_of_ten() {
        // 0.001 s added 3 million times is 3000.000000152431: 15 times the tolerance.
        let mut clock = clock(0.0, 10);
        let mut tc = 0.0;
        for k in 0..3_000_000 {
            assert_eq!(calls(&mut clock, tc, 0.001), u64::from(k % 10 == 0), "step {k} at {tc:?}");
            tc += 0.001;
        }
        assert_eq!(tc, 3000.000000152431);
    }

    #[test]
    fn a_point_that_is_off_by_rounding_leaves_the_clock_at_its_tick() {
        // 6 * 0.1 is 0.6000000000000001, and 5 * 0.1 + 0.1 is 0.6.
        let mut clock = clock(0.0, 100);
        for k in 0..1000 {
            assert_eq!(calls(&mut clock, f64::from(k) * 0.1, 0.1), 1);
            assert_eq!((clock.tick, clock.offset), (i64::from(k) + 1, 0.0));
        }
    }

    #[test]
    fn a_host_that_adds_up_steps_of_two_cycles_gets_two_calls_in_every_step() {
        // 0.02 s added half a million times is 10000.000000125436: 12 times the tolerance.
        let mut clock = clock(0.0, 10);
        let mut tc = 0.0;
        for k in 0..500_000 {
            assert_eq!(calls(&mut clock, tc, 0.02), 2, "step {k} at {tc:?}");
            tc += 0.02;
        }
        assert_eq!(tc, 10_000.000000125436);
    }

    #[test]
    fn no_more_than_a_quarter_of_a_cycle_counts_as_rounding() {
        // At 1e9 s a double has steps of 1.19e-7 s: 0.001 added is 0.00100004673 added, 0.07 is 0.0700000525. A quarter of
        // CYCLE is reached after 5350 and 47 700 additions; the host is followed then, and one step makes a call more.
        for (cycle, h, calls_of_h, after) in [(1, 0.001, 1, 5_350..5_400), (10, 0.07, 7, 47_600..47_800)] {
            let (mut clock, mut tc) = (clock(1e9, cycle), 1e9);
            let mut odd = Vec::new();
            for step in 0..after.end + 2_000 {
                let made = calls(&mut clock, tc, h);
                tc += h;
                if made != calls_of_h {
                    odd.push((step, made));
                }
            }
            assert!(odd.len() == 1 && after.contains(&odd[0].0) && odd[0].1 == calls_of_h + 1, "{h:?}: {odd:?}");
        }
    }

    #[test]
    fn a_host_that_creeps_ahead_is_followed_when_it_is_a_millionth_of_a_cycle_ahead() {
        // Each step begins 0.9e-6 s after the end of the last one: the third begins at 2.0000018 and holds t = 2 and 3.
        let mut clock = clock(0.0, 1000);
        let made = [0.0, 1.0000009, 2.0000018].map(|tc| calls(&mut clock, tc, 1.0));
        assert_eq!(made, [1, 1, 2]);
    }

    #[test]
    fn a_host_that_goes_back_over_a_call_within_the_tolerance_does_not_get_it_again() {
        let mut clock = clock(0.0, 1000);
        assert_eq!(calls(&mut clock, 0.0, 1.0000015), 2, "t = 0 and 1");
        assert_eq!(calls(&mut clock, 1.0000006, 1e-12), 0, "0.9e-6 s back, which is no difference");
        assert_eq!(calls(&mut clock, 1.0000006, 1.0), 0, "t = 1 is made, t = 2 is the next step's");
        assert_eq!(calls(&mut clock, 2.0000006, 1.0), 1, "t = 2");
    }

    #[test]
    fn a_host_does_not_get_back_by_many_steps_that_are_each_within_the_tolerance() {
        let mut clock = clock(0.0, 1000);
        calls(&mut clock, 0.0, 3.0);
        assert_eq!(calls(&mut clock, 3.0 - 0.9e-6, 1e-12), 0);
        assert_eq!(clock.end(), 3.0, "the furthest");
        let refusal = clock.advance(3.0 - 1.8e-6, 1e-12).unwrap_err();
        assert!(refusal.reason().contains("2.9999982 is before 3.0"), "{}", refusal.reason());
    }

    #[test]
    fn a_step_that_is_a_hair_too_long_makes_one_call_where_the_host_computes_its_points_anew() {
        // 0.1 as a 32-bit float is 0.10000000149: 1.5e-8 of a CYCLE in every step, a tolerance in 67 of them.
        for start in [0.0, 1e5, 1e7] {
            let mut clock = clock(start, 100);
            for k in 0..10_000 {
                let tc = start + f64::from(k) * 0.1;
                assert_eq!(calls(&mut clock, tc, f64::from(0.1f32)), 1, "from {start:?}, step {k}");
            }
        }
    }

    #[test]
    fn a_host_that_adds_its_own_time_to_the_start_gets_one_call_in_every_step() {
        // 0.01 s added a million times is 10000.000000171856: 17 times the tolerance. The same after a jump.
        for ahead in [0.0, 1000.0] {
            let (start, mut clock) = (1e5, clock(1e5, 10));
            assert_eq!(calls(&mut clock, start, 0.01), 1);
            let mut since = ahead + 0.01;
            assert_eq!(calls(&mut clock, start + since, 0.01), 1 + (ahead * 100.0) as u64);
            since += 0.01;
            for k in 2..1_000_000 {
                assert_eq!(calls(&mut clock, start + since, 0.01), 1, "step {k} at {since:?} s since the start");
                since += 0.01;
            }
            assert!((since - ahead - 10_000.0).abs() > 1e-7, "{since:?}");
        }
    }

    #[test]
    fn an_ordinary_step_is_one_of_cycle_from_a_tick_where_nothing_is_near() {
        let at_a_tick = || {
            let mut clock = Clock::new(1234.5, 1244.5, Time::ms(1000));
            calls(&mut clock, 1234.5, 2.0);
            clock
        };
        let ordinary = |change: fn(&mut Clock)| {
            let mut clock = at_a_tick();
            change(&mut clock);
            clock.is_ordinary(clock.end, 1.0)
        };
        assert!(ordinary(|_| ()));
        assert!(!at_a_tick().is_ordinary(1236.6, 1.0), "not from where the last step ended");
        assert!(!at_a_tick().is_ordinary(1236.5, 1.5));
        assert!(!ordinary(|clock| clock.offset = 500.0));
        assert!(!ordinary(|clock| clock.next += 1));
        // The stop time lies at tick 10.
        assert!(ordinary(|clock| (clock.tick, clock.next, clock.end) = (7, 7, 1241.5)));
        assert!(!ordinary(|clock| (clock.tick, clock.next, clock.end) = (8, 8, 1242.5)));
        // A host that has drifted by a quarter of a CYCLE.
        assert!(ordinary(|clock| clock.end += 0.2) && ordinary(|clock| clock.end -= 0.2));
        assert!(!ordinary(|clock| clock.end += 0.25) && !ordinary(|clock| clock.end -= 0.25));
        // Where a double is coarse.
        let resolved = 100.0 / (ROUNDINGS * RESOLUTION);
        assert!(clock(resolved * 0.99, 1000).is_ordinary(resolved * 0.99, 1.0));
        assert!(!clock(resolved, 1000).is_ordinary(resolved, 1.0));
        assert!(!clock(-resolved, 1000).is_ordinary(-resolved, 1.0));
    }

    #[test]
    fn a_call_that_was_made_is_not_made_again_in_an_ordinary_step() {
        let mut clock = clock(0.0, 1000);
        calls(&mut clock, 0.0, 2.0);
        // As where the clock was ahead of a host that adds up, and has been led back to t = 2.
        clock.next = 3;
        assert_eq!(calls(&mut clock, 2.0, 1.0), 0, "t = 2");
        assert_eq!(calls(&mut clock, 3.0, 1.0), 1, "t = 3");
    }

    #[test]
    fn the_end_is_that_of_the_last_step_as_the_host_counts_and_the_start_before_it() {
        let mut clock = clock(5.0, 1000);
        assert_eq!(clock.end(), 5.0);
        calls(&mut clock, 5.0, 2.5);
        assert_eq!(clock.end(), 7.5);
    }

    #[test]
    fn a_host_that_really_is_ahead_is_followed_and_the_calls_in_between_are_made() {
        let mut clock = clock(0.0, 1000);
        assert_eq!(advanced(&mut clock, 0.0, 1.0), (1, 0.0));
        // Calls 1, 2 and 3 are late by 2.5, 1.5 and 0.5 s; the step itself holds call 4, 0.5 s after its begin.
        assert_eq!(advanced(&mut clock, 3.5, 1.0), (4, -2.5));
        assert_eq!((clock.tick, clock.offset), (4, 500.0), "4.5 s are four CYCLEs and 500 ms");
        assert_eq!(advanced(&mut clock, 4.5, 1.0), (1, 0.5));
    }

    #[test]
    fn a_host_a_tenth_of_a_cycle_ahead_is_followed_too() {
        let mut clock = clock(0.0, 1000);
        calls(&mut clock, 0.0, 1.0);
        assert_eq!(advanced(&mut clock, 1.1, 1.0), (2, -0.1));
    }

    #[test]
    fn a_host_that_has_drifted_by_rounding_is_still_followed_when_it_jumps() {
        let mut clock = clock(1e6, 1);
        let mut tc = 1e6;
        for _ in 0..2_000_000 {
            clock.advance(tc, 0.001).unwrap();
            tc += 0.001;
        }
        assert_eq!(calls(&mut clock, tc + 0.0001, 0.001), 2, "0.1 ms ahead: the call due and the one 0.9 ms later");
    }

    #[test]
    fn a_long_step_neither_loses_nor_doubles_a_call() {
        // 49.7 days in one step of 4 294 967 295 calls: h * 1000 / CYCLE is off by half a millionth of a CYCLE.
        assert_eq!(calls(&mut clock(0.0, 1), 0.0, 4_294_967.295), 4_294_967_295);
        assert_eq!(calls(&mut clock(0.0, 7), 0.0, 7.0 * 0.001 * 4_000_000_001.0), 4_000_000_001);
        // As many calls as there may be, off by 1.4 millionths of a CYCLE.
        assert_eq!(calls(&mut clock(0.0, 3950), 0.0, 4_294_960_009.0 * 0.001 * 3950.0), 4_294_960_009);
    }

    #[test]
    fn a_state_that_no_step_leads_to_is_not_restored() {
        let restore = |change: fn(&mut Clock)| {
            let mut clock = clock(0.0, 1000);
            calls(&mut clock, 0.0, 10.5);
            change(&mut clock);
            let mut bytes = Vec::new();
            clock.write(&mut bytes);
            Clock::read(&mut &bytes[..]).is_some()
        };
        assert!(restore(|_| ()));
        assert!(restore(|clock| clock.offset = 1900.0), "less than two CYCLEs beside a tick");
        assert!(!restore(|clock| clock.offset = 2100.0));
        assert!(!restore(|clock| clock.next = 0));
        assert!(!restore(|clock| clock.next += 2));
        assert!(!restore(|clock| clock.tick = i64::MAX));
        assert!(!restore(|clock| clock.tick = -1));
        assert!(!restore(|clock| clock.offset = 1e9));
        assert!(!restore(|clock| clock.offset = f64::NAN));
        assert!(!restore(|clock| clock.cycle = -1.0));
        assert!(!restore(|clock| clock.start = f64::NAN));
        assert!(!restore(|clock| clock.end = f64::INFINITY));
        assert!(!restore(|clock| clock.since = f64::INFINITY));
        assert!(!restore(|clock| clock.stop = f64::NAN));
    }

    #[test]
    fn a_host_behind_by_more_than_rounding_is_refused_with_both_numbers() {
        let mut clock = clock(0.0, 1000);
        calls(&mut clock, 0.0, 1.0);
        let refusal = clock.advance(0.999, 1.0).unwrap_err();
        let error = refusal.reason();
        assert!(error.contains("= 0.999 ") && error.contains(" 1.0,"), "{error}");
        assert_eq!(calls(&mut clock, 1.0 - 1e-12, 1.0), 1, "and by rounding is not");
    }

    #[test]
    fn points_and_steps_that_are_no_times_are_refused() {
        for h in [-5e-324, -1.0, f64::NAN, f64::INFINITY] {
            let refusal = clock(0.0, 1000).advance(0.0, h).unwrap_err();
            assert!(refusal.reason().contains(&format!("{h:?}: the point must be finite, the step finite")), "{h}");
        }
        for tc in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let refusal = clock(0.0, 1000).advance(tc, 1.0).unwrap_err();
            assert!(
                refusal.reason().contains(&format!("{tc:?}, communicationStepSize = 1.0: the point must be finite"))
            );
        }
    }

    #[test]
    fn the_stop_time_can_be_reached_by_adding_up_but_not_be_passed() {
        // 0.1 s added 100 000 times is 10000.000000018848.
        let mut clock = Clock::new(0.0, 10_000.0, Time::ms(100));
        let mut tc = 0.0;
        for _ in 0..100_000 {
            assert_eq!(calls(&mut clock, tc, 0.1), 1);
            tc += 0.1;
        }
        assert!(tc > 10_000.000000018);
        assert!(clock.advance(tc, 0.1).unwrap_err().reason().contains("10000.0"));
        assert!(Clock::new(0.0, 1.0, Time::ms(100)).advance(0.0, 1.001).is_err());
    }

    #[test]
    fn the_call_at_the_stop_time_is_not_made() {
        // Calls at 0.0, 0.1, ..., 0.9; the one at 1.0 = stopTime belongs to a step after it. Up to 1e-7 s beyond, a step
        // still ends at the stop time.
        let mut clock = Clock::new(0.0, 1.0, Time::ms(100));
        assert_eq!(calls(&mut clock, 0.0, 1.0 + 0.9e-7), 10);
        assert_eq!((clock.tick, clock.next), (10, 10));
        assert!(clock.offset.abs() < 1e-12, "not beyond: {} ms", clock.offset);
    }

    #[test]
    fn the_stop_time_is_counted_from_0_and_not_from_the_start() {
        let clock = || Clock::new(5.0, 6.0, Time::ms(100));
        assert_eq!(calls(&mut clock(), 5.0, 1.0), 10);
        assert!(clock().advance(5.0, 1.001).unwrap_err().reason().contains("stopTime = 6.0"));
    }

    #[test]
    fn a_step_reaches_the_stop_time_by_the_hosts_own_time_where_that_is_behind() {
        // 0.01 s added 3 million times is 29999.999998131676, 187 times the tolerance less than the clock has counted: the
        // host makes up for it in a step of its own.
        let mut clock = Clock::new(0.0, 30_000.0, Time::ms(10));
        let mut tc = 0.0;
        for _ in 0..3_000_000 {
            assert_eq!(calls(&mut clock, tc, 0.01), 1);
            tc += 0.01;
        }
        assert_eq!(tc, 29_999.999998131676);
        assert!(clock.clone().advance(tc, 0.01).is_err());
        assert_eq!(calls(&mut clock, tc, 30_000.0 - tc), 0);
    }

    #[test]
    fn calls_made_before_do_not_count_towards_the_most_that_a_step_may_hold() {
        let mut clock = clock(0.0, 1);
        assert_eq!(calls(&mut clock, 0.0, 3e6), 3_000_000_000);
        assert_eq!(calls(&mut clock, 3e6, 2e6), 2_000_000_000);
        assert_eq!(calls(&mut clock, 5e6, 4_294_967.296), 4_294_967_296, "as many as it may hold");
    }

    #[test]
    fn a_day_in_one_step_makes_every_call_and_an_endless_step_is_refused() {
        assert_eq!(calls(&mut clock(0.0, 1), 0.0, 86_400.0), 86_400_000);
        assert!(clock(0.0, 1).advance(0.0, 4.3e6).unwrap_err().reason().contains("4294967296"));
        assert!(
            clock(0.0, 1).advance(4.3e6, 1.0).unwrap_err().reason().contains("4294967296"),
            "nor an endless way to it"
        );
        assert!(clock(0.0, 1000).advance(0.0, 1e300).is_err());
    }

    #[test]
    fn where_a_double_no_longer_tells_the_calls_apart_a_step_is_refused() {
        // 1 ms: the bound lies at 2^47 ms = 1.4e11 s.
        assert_eq!(calls(&mut clock(1e11, 1), 1e11, 1.0), 1000);
        for (start, tc) in [(2e11, 2e11), (0.0, 2e11), (-2e11, 0.0)] {
            let refusal = clock(start, 1).advance(tc, 1.0).unwrap_err();
            assert!(refusal.reason().contains("no longer distinguishes"), "from {start} at {tc}: {}", refusal.reason());
        }
    }

    #[test]
    fn a_refused_step_leaves_the_clock_where_it_was() {
        let mut clock = Clock::new(0.0, 10.0, Time::ms(1000));
        calls(&mut clock, 0.0, 1.5);
        let mut before = Vec::new();
        clock.write(&mut before);
        for (tc, h) in [(0.5, 1.0), (1.5, -1.0), (1.5, 100.0), (f64::NAN, 1.0)] {
            clock.advance(tc, h).unwrap_err();
        }
        let mut after = Vec::new();
        clock.write(&mut after);
        assert_eq!(before, after);
    }

    #[test]
    fn a_step_of_a_cycle_that_begins_beside_a_tick_is_no_ordinary_one() {
        // A step of 4e9 calls may be off by 3.6e-6 of a CYCLE of its own, on top of 2.8e-6 at 2e6 s: the call at its end is
        // the next step's. That one begins 4.2e-6 of a CYCLE after it, and holds the one after as well.
        let mut clock = clock(-2e6, 1);
        let long = 4_000_000.000000004;
        assert_eq!(calls(&mut clock, -2e6, long), 4_000_000_000);
        assert_eq!(clock.next, clock.tick);
        let mut checked = clock.clone();
        let end = clock.end();
        assert_eq!(checked.check_and_advance(end, 0.001).unwrap().count, 2);
        assert_eq!(calls(&mut clock, end, 0.001), 2);
    }

    #[test]
    fn the_ordinary_step_ends_two_cycles_before_the_stop_time_and_where_rounding_is_a_tenth_of_a_cycle() {
        // Four roundings of t: 4 * 2^-52 * t = 0.1 * CYCLE, that is t = 0.1 * 2^50 * CYCLE.
        let reach = 0.1 * 2f64.powi(50);
        assert!((clock(0.0, 1000).horizon / reach - 1.0).abs() < 1e-12);
        assert!((clock(0.0, 10).horizon / (reach * 0.01) - 1.0).abs() < 1e-12);
        assert_eq!(Clock::new(0.0, 10.0, Time::ms(100)).horizon, 9.8);
        assert_eq!(clock(-2e14, 1000).horizon, f64::NEG_INFINITY, "the start is farther from 0 than that");
    }

    #[test]
    fn floor_and_ceil_are_those_of_a_number_of_cycles() {
        assert_eq!([2.0, 2.5, 3.0].map(floor), [2, 2, 3]);
        assert_eq!([2.0, 2.5, 3.0].map(ceil), [2, 3, 3]);
        assert_eq!([-0.25, 0.0].map(|rounding| (floor(rounding), ceil(rounding))), [(0, 0); 2]);
    }

    #[test]
    fn the_ordinary_step_comes_to_the_same_as_the_checked_one() {
        let mut known_before = 0;
        for (start, stop, cycle) in [
            (0.0, f64::INFINITY, 1),
            (1234.5, 1300.0, 10),
            (-1e5, f64::INFINITY, 100),
            (1e9, f64::INFINITY, 1),
            // Where roundings add up to the drift that is allowed, and beyond.
            (1e8, f64::INFINITY, 1),
            (-2e8, f64::INFINITY, 1),
            (3e8, 3e8 + 4.0, 1),
        ] {
            let mut ordinary = Clock::new(start, stop, Time::ms(cycle));
            let mut checked = ordinary.clone();
            for _ in 0..20_000 {
                let (tc, h) = (ordinary.end, ordinary.period);
                let expected = checked.check_and_advance(tc, h);
                let calls = if ordinary.make_ordinary_step(tc, h) {
                    known_before += 1;
                    Ok(Calls { count: 1, lead: 0.0 })
                } else {
                    ordinary.advance(tc, h)
                };
                let same = match (&calls, &expected) {
                    (Ok(calls), Ok(expected)) => calls == expected,
                    (Err(refusal), Err(expected)) => refusal.reason() == expected.reason(),
                    _ => false,
                };
                assert!(same, "{start} {cycle} at {tc}: {calls:?} and {expected:?}");
            }
            let bytes = |clock: &Clock| {
                let mut bytes = Vec::new();
                clock.write(&mut bytes);
                bytes
            };
            assert_eq!(bytes(&ordinary), bytes(&checked), "{start} {cycle}");
        }
        assert!(known_before > 50_000, "{known_before} steps of 140 000 were known to be ordinary");
    }

    #[test]
    fn steps_are_known_to_be_ordinary_as_long_as_the_host_makes_no_other() {
        let mut clock = clock(0.0, 1000);
        assert!(!clock.make_ordinary_step(0.0, 1.0), "not before the first one");
        calls(&mut clock, 0.0, 1.0);
        assert!(clock.make_ordinary_step(1.0, 1.0));
        assert!(!clock.make_ordinary_step(2.5, 1.0) && !clock.make_ordinary_step(2.0, 0.5));
        assert_eq!(calls(&mut clock, 2.0, 2.0), 2);
        assert!(!clock.make_ordinary_step(4.0, 1.0), "it has to be looked at again");
        calls(&mut clock, 4.0, 1.0);
        assert!(clock.make_ordinary_step(5.0, 1.0));
    }

    #[test]
    fn no_step_is_known_to_be_ordinary_near_the_stop_time_or_where_roundings_may_add_up_to_the_drift() {
        let known = |clock: Clock| {
            let mut clock = clock;
            let (tc, h) = (clock.end, clock.period);
            calls(&mut clock, tc, h);
            clock.ordinary_below > clock.tick
        };
        assert!(known(Clock::new(0.0, 1100.0, Time::ms(1000))));
        assert!(!known(Clock::new(0.0, 1000.0, Time::ms(1000))));
        // 1001 steps, 4 roundings each: 4004 * 2^-52 * t = 0.225 * CYCLE at t = 2.5e8 s for 1 ms.
        assert!(known(clock(2e8, 1)) && known(clock(-2e8, 1)));
        assert!(!known(clock(3e8, 1)) && !known(clock(-3e8, 1)));
    }
}
