//! When is the block called: integer ticks of whole milliseconds.
//!
//! The block is called at `t_k = start + k * CYCLE`, k = 0, 1, 2, ..., as a cyclic interrupt would, whatever the
//! communication step: a step makes every call with `tc <= t_k < tc + h`.
//!
//! The clock keeps its own time: a tick counter, and the offset from that tick, to which each step adds its `h`. The
//! `tc` of the host is only compared with it. A host that adds up its time drifts by the rounding of every addition
//! (0.01 s added a million times is 1.7e-7 s off), and a clock that believed it would some day make no call in one step
//! and two in another. As long as the two agree within what rounding can do, the clock goes on by itself; where the
//! host is really ahead, the clock follows it and makes the calls in between.
//!
//! How far this goes: the rounding of a double grows with |t|, a CYCLE does not. Up to |t| / CYCLE = 2^47 (4 000 years
//! at 1 ms) every call is made, once, in its step. Beyond, where a double hardly tells one call from the next, a step is
//! refused.

use blocks::{Stored, Time};

/// Two times closer than this part of a CYCLE are one.
const SAME: f64 = 1e-6;

/// How many roundings of a double, beyond the accumulated ones, may stand between two times that are meant to be one:
/// that of start, of tc, of their difference and its conversion to milliseconds.
const ROUNDINGS: f64 = 4.0;

/// No step makes more calls than this: a day at 1 ms is 86 million.
const MOST_CALLS: f64 = 4_294_967_296.0;

/// The time of one block. Positions are milliseconds since the start.
#[derive(Clone, Debug)]
pub struct Clock {
    /// Start time in seconds.
    start: f64,
    /// Stop time in seconds; infinite if there is none.
    stop: f64,
    /// Time between two calls in whole milliseconds.
    cycle: u32,
    /// The number k of the next call.
    next: u64,
    /// The present time is `tick * cycle + offset`.
    tick: u64,
    offset: f64,
    /// Where the host said the last step ends, in seconds.
    end: f64,
    /// How far the host's time may have drifted from ours by adding up, in milliseconds.
    drift: f64,
}

/// The calls of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calls {
    /// How many.
    pub count: u64,
    /// From the begin of the step to the first of them, in seconds; negative where the host is ahead and calls are
    /// made up for.
    pub lead: f64,
}

impl Clock {
    /// A clock that stands at `start`; `stop` is infinite if there is none.
    pub fn new(start: f64, stop: f64, cycle: Time) -> Clock {
        let cycle = u32::try_from(cycle.milliseconds()).unwrap_or(0);
        Clock { start, stop, cycle, next: 0, tick: 0, offset: 0.0, end: start, drift: 0.0 }
    }

    /// The time between two calls in seconds.
    pub fn cycle(&self) -> f64 {
        f64::from(self.cycle) / 1000.0
    }

    /// The end of the last step in seconds, as the host counts.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// Goes from `tc` to `tc + h` (seconds) and says which calls lie in between.
    ///
    /// # Errors
    /// A sentence with the numbers, and the clock stays where it is, if `tc` or `h` is no time, `tc` lies behind the
    /// last step's end, or `tc + h` behind the stop time, by more than rounding.
    #[inline]
    pub fn advance(&mut self, tc: f64, h: f64) -> Result<Calls, String> {
        let cycle = f64::from(self.cycle);
        // Written so that NaN fails.
        if !(h > 0.0 && h < f64::INFINITY && tc.abs() < f64::INFINITY) {
            return Err(format!(
                "currentCommunicationPoint = {tc:?}, communicationStepSize = {h:?}: the point must be finite, the \
                 step finite and greater than 0"
            ));
        }
        let ulp = f64::EPSILON * 1000.0 * self.start.abs().max(tc.abs());
        let same = SAME * cycle + ROUNDINGS * ulp;
        if same > 0.125 * cycle {
            return Err(format!(
                "currentCommunicationPoint = {tc:?}: there a double no longer tells one CYCLE of {} s from the next; \
                 start nearer to 0",
                self.cycle()
            ));
        }
        if (tc - self.end) * 1000.0 < -same {
            return Err(format!(
                "currentCommunicationPoint = {tc:?} lies behind {:?}, where the last step ended; to go back, restore \
                 an FMU state",
                self.end
            ));
        }

        let (mut tick, mut offset, mut drift) = (self.tick, self.offset, self.drift);
        let position = (tc - self.start) * 1000.0;
        if (position - (tick as f64 * cycle + offset)).abs() > same + drift {
            tick = (position / cycle) as u64;
            offset = position - tick as f64 * cycle;
            drift = 0.0;
        }

        let mut step = h * 1000.0;
        let present = tick as f64 * cycle + offset;
        let beyond = present + step - (self.stop - self.start) * 1000.0;
        if beyond > 0.0 {
            if beyond.min((tc + h - self.stop) * 1000.0) > same + drift {
                return Err(format!(
                    "currentCommunicationPoint = {tc:?}, communicationStepSize = {h:?}: the step ends behind \
                     stopTime = {:?}",
                    self.stop
                ));
            }
            step -= beyond;
        }

        let tolerance = same / cycle;
        let cycles = (offset + step) / cycle;
        if cycles > MOST_CALLS {
            return Err(format!(
                "communicationStepSize = {h:?}: a step may hold {MOST_CALLS} calls, one every {} s; make it shorter",
                self.cycle()
            ));
        }
        let calls_end = (tick + ceil(cycles - tolerance)).max(self.next);
        let count = calls_end - self.next;
        let lead = self.next as f64 * cycle - present;
        let lead = if lead.abs() > same { lead / 1000.0 } else { 0.0 };

        let passed = floor(cycles + tolerance);
        self.tick = tick + passed;
        self.offset = offset + step - passed as f64 * cycle;
        self.next = calls_end;
        self.end = tc + h;
        // One more addition of the host's, rounded to half a unit in the last place (a whole one to be safe). Never more
        // than a quarter of a CYCLE: no host's rounding is a reason to call at another time than it says.
        self.drift = (drift + f64::EPSILON * 1000.0 * self.end.abs()).min(0.25 * cycle);
        Ok(Calls { count, lead })
    }
}

/// The floor of a number of cycles, 0 where it is negative by rounding. (`f64::floor` is a library call on processors
/// without SSE 4.1, which a portable library cannot ask for.)
fn floor(x: f64) -> u64 {
    x as i64 as u64
}

fn ceil(x: f64) -> u64 {
    let floor = x as i64;
    (floor + i64::from(x > floor as f64)) as u64
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
        self.drift.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some(Clock {
            start: Stored::read(bytes)?,
            stop: Stored::read(bytes)?,
            cycle: Stored::read(bytes)?,
            next: Stored::read(bytes)?,
            tick: Stored::read(bytes)?,
            offset: Stored::read(bytes)?,
            end: Stored::read(bytes)?,
            drift: Stored::read(bytes)?,
        })
    }
}
