//! The times of the calls: integer ticks of whole milliseconds.
//!
//! The block is called at `t_k = start + k * CYCLE`, k = 0, 1, 2, ..., as by a cyclic interrupt, regardless of the
//! communication step: a step makes every call with `tc <= t_k < tc + h`.
//!
//! Hosts compute `tc` in one of two ways, which need opposite treatment:
//!
//! - A host that adds up: `tc` is, to the last bit, the sum of the last step's `tc` and `h`, or of the start time and
//!   all `h` so far. Such a time drifts by the rounding of every addition (0.01 s added a million times is off by
//!   1.7e-7 s), and a clock that relied on it would eventually make two calls in one step. The clock therefore keeps
//!   its own time, a tick counter and an offset from that tick, and adds each `h` to it while rounding can explain the
//!   difference from `tc`.
//! - A host that recomputes `tc` for every step. Its `h` may be inexact: rounded to 32 bits, or written with a few
//!   decimals. A clock that added up such an `h` would eventually make a call one step early. The clock therefore
//!   continues from `tc`.
//!
//! If the host is ahead, the clock follows it and makes the calls in between.
//!
//! Limits: the rounding error of a double grows with |t|, a CYCLE does not.
//!
//! - Up to |t| / CYCLE = 2^47 (4 000 years at 1 ms), every call is made exactly once, in the step that contains it, if
//!   the host recomputes its communication points. Beyond that, where a double hardly distinguishes one call from the
//!   next, steps are refused.
//! - Accumulated drift up to CYCLE / 4 is corrected; beyond that, the clock follows the host, and one step makes one
//!   call more or fewer than the others. Starting at 0, this takes at least 6e7 steps of CYCLE; at |t| / CYCLE = 1e12
//!   (1e9 s at 1 ms), at least 2 000.
//! - An `h` whose error is below the rounding of `tc` cannot be distinguished from the step of a host that adds up. For
//!   a 32-bit `h`, this begins at |t| / CYCLE = 1e8.

use crate::messages;
use crate::refusal::Refusal;
use blocks::{Stored, Time};

/// Two times that differ by less than this fraction of a CYCLE count as equal.
pub(crate) const SAME: f64 = 1e-6;

/// The maximum drift between the time of a host that adds up and the clock's, as a fraction of a CYCLE. Beyond it, the
/// clock follows the host.
pub(crate) const MOST_DRIFT: f64 = 0.25;

/// The number of rounding errors of a double that may separate two times meant to be equal, not counting accumulated
/// ones: one each in start, in tc, in their difference and in its conversion to milliseconds.
pub(crate) const ROUNDINGS: f64 = 4.0;

/// The resolution of a double at 1 s, in milliseconds.
pub(crate) const RESOLUTION: f64 = f64::EPSILON * 1000.0;

/// The maximum tolerance for equal times, as a fraction of a CYCLE. Steps that would need more are refused, because
/// their calls could not be distinguished.
const MOST_SAME: f64 = 0.125;

/// The maximum number of calls in a step; a day at 1 ms has 86 million.
const MOST_CALLS: f64 = 4_294_967_296.0;

/// The clock of one block.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    /// Start time in seconds.
    pub(crate) start: f64,
    /// Stop time in seconds; infinite if there is none.
    pub(crate) stop: f64,
    /// Time between two calls, in milliseconds: a whole number.
    pub(crate) cycle: f64,
    /// The reciprocal of `cycle`, so that a step needs no division.
    pub(crate) per_cycle: f64,
    /// `cycle` in seconds.
    pub(crate) period: f64,
    /// A step of one CYCLE that begins before this time, in seconds, cannot reach the stop time, and its rounding
    /// errors are small compared with a CYCLE.
    pub(crate) horizon: f64,
    /// The tolerance for communication points that the host recomputes, in milliseconds per second of their distance
    /// from 0; negative if `period`, converted back to milliseconds, is not exactly `cycle`.
    pub(crate) rounding: f64,
    /// Below this tick, every step of one CYCLE that starts at the end of the last one is ordinary.
    pub(crate) ordinary_below: i64,
    /// The number k of the next call.
    pub(crate) next: i64,
    /// The current time, in milliseconds since the start, is `tick * cycle + offset`.
    pub(crate) tick: i64,
    pub(crate) offset: f64,
    /// The end of the last step in seconds, in the host's time. Never decreases, even if a step begins and ends
    /// slightly early.
    pub(crate) end: f64,
    /// The sum of all steps since the start, in seconds, as a host would add them up.
    pub(crate) since: f64,
}

/// The calls of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calls {
    /// The number of calls.
    pub count: u64,
    /// The time from the start of the step to the first call, in seconds; negative if the host is ahead and the step
    /// catches up on calls.
    pub lead: f64,
}

impl Clock {
    /// A clock at `start`, in seconds, that runs until `stop`, which is infinite if there is no stop time.
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

    /// Computes the constants that depend on start, stop and cycle.
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

    /// The end of the last step in seconds, in the host's time.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// The time of the next call in seconds.
    pub fn next_call(&self) -> f64 {
        self.start + self.next as f64 * self.cycle / 1000.0
    }

    /// Whether the next call is due now, within rounding.
    pub fn is_due(&self) -> bool {
        (self.next - self.tick) as f64 * self.cycle - self.offset <= self.same()
    }

    /// The tolerance in milliseconds within which times count as equal to the current one.
    fn same(&self) -> f64 {
        SAME * self.cycle + ROUNDINGS * RESOLUTION * self.end.abs().max(self.start.abs())
    }

    /// If a call is due, counts it as made. Returns whether one was due.
    ///
    /// # Errors
    /// The current time is so far from 0 that calls cannot be distinguished.
    pub fn make_due_call(&mut self) -> Result<bool, Refusal> {
        if self.same() > MOST_SAME * self.cycle {
            return Err(messages::no_resolution("the time", self.end, self.period).into());
        }
        let is_due = self.is_due();
        if is_due {
            self.next += 1;
            self.ordinary_below = 0;
        }
        Ok(is_due)
    }

    /// Advances from `tc` to `tc + h` (seconds) and returns the calls in between. If `h` is 0, there are no calls, and
    /// the clock does not advance.
    ///
    /// # Errors
    /// `tc` or `h` is not finite, or `h` is negative; by more than rounding, `tc` is before the end of the last step or
    /// `tc + h` is after the stop time; `tc` is so far from 0 that calls cannot be distinguished; or the step contains
    /// too many calls. In these cases, the clock does not advance.
    pub fn advance(&mut self, tc: f64, h: f64) -> Result<Calls, Refusal> {
        if self.check_and_make_ordinary_step(tc, h) {
            return Ok(Calls { count: 1, lead: 0.0 });
        }
        self.check_and_advance(tc, h)
    }

    fn check_and_advance(&mut self, tc: f64, h: f64) -> Result<Calls, Refusal> {
        let cycle = self.cycle;
        // No range contains NaN.
        if !((0.0..f64::INFINITY).contains(&h) && tc.abs() < f64::INFINITY) {
            return Err(messages::no_time(tc, h).into());
        }
        let magnitude = if tc.abs() > self.start.abs() { tc.abs() } else { self.start.abs() };
        let same = SAME * cycle + ROUNDINGS * RESOLUTION * magnitude;
        if same > MOST_SAME * cycle {
            return Err(messages::no_resolution("currentCommunicationPoint", tc, self.period).into());
        }
        if (self.end - tc) * 1000.0 > same {
            return Err(messages::before_end(tc, self.end).into());
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
                    return Err(messages::after_stop(tc, h, self.stop).into());
                }
                step -= beyond;
            }
        }

        if h == 0.0 {
            // Some hosts end a run with such a step. It makes no call, not even a due one, and does not advance the
            // clock.
            return Ok(Calls { count: 0, lead: 0.0 });
        }

        let first = self.next;
        let lead = first as f64 * cycle - present;
        // A long step adds a rounding error.
        let tolerance = (same + ROUNDINGS * f64::EPSILON * step) * self.per_cycle;
        let cycles = (offset + step) * self.per_cycle;
        if cycles + (tick - first) as f64 > MOST_CALLS {
            return Err(messages::too_many_calls(tc, h, self.end, self.period).into());
        }
        let passed = floor(cycles + tolerance);
        self.ordinary_below = 0;
        self.tick = tick + passed;
        self.next = (tick + ceil(cycles - tolerance)).max(first);
        self.offset = offset + step - passed as f64 * cycle;
        // The furthest end: steps that each begin slightly early, within the tolerance, must not move the time
        // backwards.
        self.end = if tc + h > self.end { tc + h } else { self.end };
        self.since = since + h;
        Ok(Calls { count: (self.next - first) as u64, lead: if lead.abs() > same { lead / 1000.0 } else { 0.0 } })
    }
}

/// The floor of a number of cycles; 0 if rounding has made it negative. (`f64::floor` is a library call on processors
/// without SSE 4.1, which a portable library cannot require.)
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
    /// Whether all values are in the ranges that steps can produce. No other state may be restored: it could demand an
    /// endless number of calls.
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
mod tests;
