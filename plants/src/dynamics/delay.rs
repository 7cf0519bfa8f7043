//! The transport delay.

use super::{Kept, limited, seconds};
use blocks::table::abreast::{LANES, Lane};
use blocks::{LReal, Stored, Time};
use std::array::from_fn;

/// Transport delay of a signal that is held for a cycle: the input appears at the output exactly `delay` seconds later.
///
/// If the delay is not a multiple of the cycle, the output changes within the cycle: it has two parts, and the plant
/// after it is solved for one part and then the other. The delay may change from cycle to cycle, from 0 to the maximum
/// passed to [`Delay::new`]; values in transit then arrive as if the new delay had always applied.
///
/// ```
/// use blocks::Time;
/// use plants::dynamics::Delay;
///
/// let cycle = Time::ms(100);
/// let mut delay = Delay::new(0.25, cycle, 0.0);
/// assert_eq!(delay.step(7.0, 0.25, cycle), [(0.05, 0.0), (0.05, 0.0)]);
/// assert_eq!(delay.step(7.0, 0.25, cycle), [(0.05, 0.0), (0.05, 0.0)]);
/// assert_eq!(delay.step(7.0, 0.25, cycle), [(0.05, 0.0), (0.05, 7.0)]);
/// assert_eq!(delay.step(7.0, 0.25, cycle), [(0.05, 7.0), (0.05, 7.0)]);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Delay {
    /// The inputs, one value per cycle, in a ring buffer.
    line: Vec<LReal>,
    /// The index of the next value.
    next: u32,
    /// The position of the output, behind the input.
    back: Kept<3, Back>,
    /// The ends of the line, which replace `line` while the delay is in a lane.
    ends: Option<Ends>,
}

/// The distance of a delay's output behind its input.
#[derive(Clone, Copy, Debug, Default)]
struct Back {
    /// The number of whole cycles.
    cycles: usize,
    /// The durations, in seconds, of the two parts of a cycle: of the first, in which the output is one cycle older,
    /// and of the rest.
    durations: [LReal; 2],
    /// For each part, whether the output is the input itself.
    is_input: [bool; 2],
}

blocks::lane!(Back { cycles: usize, durations: [LReal; 2], is_input: [bool; 2] });

/// The ends of a line: all that a call needs of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ends {
    /// The longest delay in cycles.
    longest: LReal,
    /// The output in each part of the cycle; unused for a part in which it is the input.
    out: [LReal; 2],
    /// The input.
    input: LReal,
}

blocks::lane!(Ends { longest: LReal, out: [LReal; 2], input: LReal });

impl Delay {
    /// The maximum delay in cycles, which takes 8 MB of memory. A longer delay is truncated to it; [`Delay::check`]
    /// reports this beforehand.
    pub const LONGEST: u32 = 1_000_000;

    /// Creates a delay line for delays of up to `longest` seconds, rounded up to whole cycles, filled with `past`. This
    /// is the only function that allocates memory: call it in the restart of a block.
    pub fn new(longest: LReal, cycle: Time, past: LReal) -> Delay {
        let length = (cycles(longest, cycle).ceil() as usize).min(Delay::LONGEST as usize) + 1;
        Delay { line: vec![past; length], ..Delay::default() }
    }

    /// Checks, for [`Law::check`](blocks::Law::check), that delays of up to `longest` seconds fit in memory.
    ///
    /// # Errors
    /// A sentence that names the parameter, its value and the remedy.
    pub fn check(parameter: &str, longest: LReal, cycle: Time) -> Result<(), String> {
        if cycles(longest, cycle) <= LReal::from(Delay::LONGEST) {
            return Ok(());
        }
        let most = LReal::from(Delay::LONGEST) * seconds(cycle);
        Err(format!(
            "{parameter} is {longest} s, but a CYCLE of {} ms allows at most {most} s: make {parameter} \
             shorter or CYCLE longer",
            cycle.milliseconds()
        ))
    }

    /// Accepts the input of this cycle and returns the output during it: two pairs of a duration in seconds and the
    /// value for that duration. Either duration may be 0; their sum is the cycle. Allocates nothing.
    ///
    /// A delay within a billionth of a cycle of a whole number of cycles is rounded to it. A line not created by
    /// [`Delay::new`] has no delay.
    #[inline(always)]
    pub fn step(&mut self, input: LReal, delay: LReal, cycle: Time) -> [(LReal, LReal); 2] {
        if self.ends.is_none() && self.line.is_empty() {
            return [(0.0, input), (seconds(cycle), input)];
        }
        let of = |[delay, cycle, longest]: [LReal; 3]| Back::new(delay, Time::ms(cycle as i32), longest);
        let back = self.back.get_or_compute(self.numbers(delay, cycle), of);
        let out = match &mut self.ends {
            None => {
                let now = self.next as usize;
                self.put_in(input);
                back.places(now, self.line.len()).map(|place| self.line[place])
            }
            Some(ends) => {
                ends.input = input;
                from_fn(|part| if back.is_input[part] { input } else { ends.out[part] })
            }
        };
        [(back.durations[0], out[0]), (back.durations[1], out[1])]
    }

    /// Returns the numbers that determine the position of the output.
    #[inline(always)]
    fn numbers(&self, delay: LReal, cycle: Time) -> [LReal; 3] {
        [delay, LReal::from(cycle.milliseconds()), self.ends.map_or_else(|| self.longest(), |ends| ends.longest)]
    }

    /// The longest delay in cycles.
    fn longest(&self) -> LReal {
        self.line.len().saturating_sub(1) as LReal
    }

    /// Returns the output in each part of the next cycle; arbitrary for a part in which it is that cycle's input.
    #[inline]
    fn out(&self) -> [LReal; 2] {
        let places = |back: Back| back.places(self.next as usize, self.line.len());
        self.back.last().map_or([0.0; 2], |back| places(back).map(|place| self.line[place]))
    }

    /// Puts a value into the line, in place of the oldest one.
    #[inline]
    fn put_in(&mut self, input: LReal) {
        let now = self.next as usize;
        self.line[now] = input;
        self.next = if now + 1 == self.line.len() { 0 } else { self.next + 1 };
    }
}

impl Back {
    /// Returns the indices in the line of the output in both parts of the cycle, if the input of this cycle is at
    /// `now`.
    #[inline(always)]
    fn places(self, now: usize, length: usize) -> [usize; 2] {
        // A delay as long as the line has no older part: `cycles + 1` then wraps around, for a duration of 0.
        [self.cycles + 1, self.cycles].map(|back| if back > now { now + length - back } else { now - back })
    }

    /// Computes the position for a delay in seconds, limited to `longest` cycles.
    fn new(delay: LReal, cycle: Time, longest: LReal) -> Back {
        let whole_cycle = seconds(cycle);
        let delay = limited(cycles(delay, cycle), 0.0, longest);
        let cycles = delay as usize;
        let part = whole_cycle * (delay - cycles as LReal);
        Back { cycles, durations: [part, whole_cycle - part], is_input: [cycles as LReal == longest, cycles == 0] }
    }
}

/// Converts a delay into cycles without the rounding error of the division: 0.3 s is 3 cycles of 0.1 s, not
/// 2.9999999999999996.
fn cycles(delay: LReal, cycle: Time) -> LReal {
    const ROUNDING: LReal = 1e-9;
    if cycle <= Time::ZERO {
        return 0.0;
    }
    let cycles = delay / seconds(cycle);
    let whole = (cycles + ROUNDING) as u64 as LReal;
    if (cycles - whole).abs() <= ROUNDING { whole } else { cycles }
}

impl Stored for Delay {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.line.write(bytes);
        self.next.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let delay = Delay { line: Stored::read(bytes)?, next: Stored::read(bytes)?, ..Delay::default() };
        ((delay.next as usize) < delay.line.len().max(1)).then_some(delay)
    }
}

/// Delays in lanes: the lines are stored whole, and the values that a steady call needs are stored variable by
/// variable.
pub struct Lanes {
    delays: [Delay; LANES],
    back: <Kept<3, Back> as Lane>::Lanes,
    ends: <Ends as Lane>::Lanes,
}

impl Lane for Delay {
    type Lanes = Lanes;

    fn lanes() -> Lanes {
        Lanes { delays: from_fn(|_| Delay::default()), back: <Kept<3, Back>>::lanes(), ends: Ends::lanes() }
    }

    fn put(self, lanes: &mut Lanes, lane: usize) {
        self.back.put(&mut lanes.back, lane);
        Ends { longest: self.longest(), out: self.out(), input: 0.0 }.put(&mut lanes.ends, lane);
        lanes.delays[lane] = self;
    }

    fn take(lanes: &mut Lanes, lane: usize) -> Delay {
        std::mem::take(&mut lanes.delays[lane])
    }

    #[inline(always)]
    fn load(lanes: &Lanes, lane: usize) -> Delay {
        let (back, ends) = (Kept::load(&lanes.back, lane), Ends::load(&lanes.ends, lane));
        Delay { line: Vec::new(), next: 0, back, ends: Some(ends) }
    }

    #[inline(always)]
    fn is_steady(&self) -> bool {
        self.back.is_steady()
    }

    #[inline(always)]
    fn store(self, lanes: &mut Lanes, lane: usize, _is_steady: bool) {
        let input = self.ends.map_or(0.0, |ends| ends.input);
        input.put(&mut lanes.ends.input, lane);
    }

    #[inline(always)]
    fn settle(lanes: &mut Lanes, lane: usize) {
        let delay = &mut lanes.delays[lane];
        delay.put_in(lanes.ends.input[lane]);
        delay.out().put(&mut lanes.ends.out, lane);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(delay: LReal, longest: LReal, cycle: Time, count: usize) -> Vec<[(LReal, LReal); 2]> {
        let mut line = Delay::new(longest, cycle, 0.0);
        (1..=count).map(|input| line.step(input as LReal, delay, cycle)).collect()
    }

    #[test]
    fn a_delay_of_whole_cycles_comes_out_whole() {
        // 0.3 / 0.1 is 2.9999999999999996.
        let out = counted(0.3, 0.3, Time::ms(100), 5);
        let after: Vec<_> = out.iter().map(|parts| parts[1]).collect();
        assert_eq!(after, [(0.1, 0.0), (0.1, 0.0), (0.1, 0.0), (0.1, 1.0), (0.1, 2.0)]);
        assert!(out.iter().all(|parts| parts[0].0 == 0.0));
    }

    #[test]
    fn a_delay_between_whole_cycles_changes_within_the_cycle() {
        // 2.25 s in cycles of 1 s: the input of the first cycle is output from 0.25 s after the start of the third.
        let out = counted(2.25, 10.0, Time::ms(1000), 4);
        assert_eq!(out[2], [(0.25, 0.0), (0.75, 1.0)]);
        assert_eq!(out[3], [(0.25, 1.0), (0.75, 2.0)]);
        // A delay shorter than a cycle.
        assert_eq!(counted(0.5, 0.5, Time::ms(2000), 2)[1], [(0.5, 1.0), (1.5, 2.0)]);
    }

    #[test]
    fn no_delay_and_a_negative_one_pass_the_input_on() {
        for delay in [0.0, -3.0, LReal::NAN] {
            let out = counted(delay, 0.0, Time::ms(1000), 3);
            assert_eq!(out.iter().map(|parts| parts[1]).collect::<Vec<_>>(), [(1.0, 1.0), (1.0, 2.0), (1.0, 3.0)]);
        }
    }

    #[test]
    fn a_delay_beyond_the_longest_is_the_longest() {
        assert_eq!(counted(9.0, 2.0, Time::ms(1000), 6), counted(2.0, 2.0, Time::ms(1000), 6));
    }

    #[test]
    fn a_delay_tuned_while_running_counts_back_from_now() {
        let cycle = Time::ms(1000);
        let mut line = Delay::new(5.0, cycle, 0.0);
        for input in 1..=6 {
            line.step(LReal::from(input), 4.0, cycle);
        }
        assert_eq!(line.step(7.0, 1.0, cycle)[1], (1.0, 6.0));
        assert_eq!(line.step(8.0, 5.0, cycle)[1], (1.0, 3.0));
    }

    #[test]
    fn a_delay_line_saved_and_read_back_goes_on_alike() {
        let cycle = Time::ms(100);
        let mut line = Delay::new(0.25, cycle, 1.0);
        for input in 0..7 {
            line.step(LReal::from(input), 0.25, cycle);
        }
        let mut bytes = Vec::new();
        line.write(&mut bytes);
        let mut rest = &bytes[..];
        let mut again = Delay::read(&mut rest).unwrap();
        assert!(rest.is_empty());
        for input in [8.0, 9.0, 10.0, 11.0] {
            assert_eq!(line.step(input, 0.25, cycle), again.step(input, 0.25, cycle));
        }
    }

    #[test]
    fn a_damaged_delay_line_is_refused_or_at_least_never_read_out_of_bounds() {
        let cycle = Time::ms(100);
        let mut bytes = Vec::new();
        Delay::new(0.25, cycle, 1.0).write(&mut bytes);
        // The line holds four values, at the indices 0 to 3.
        for next in [4, 200] {
            *bytes.iter_mut().nth_back(3).unwrap() = next;
            assert_eq!(Delay::read(&mut &bytes[..]), None, "the next value's place {next} lies outside");
        }
        for length in 0..4 {
            let mut short = Delay { line: vec![0.0; length], next: 0, ..Delay::default() };
            for input in 0..9 {
                let [_, (seconds, _)] = short.step(LReal::from(input), 1e9, cycle);
                assert_eq!(seconds, 0.1);
            }
        }
    }

    #[test]
    fn a_delay_too_long_for_its_memory_is_refused_with_the_remedy() {
        assert_eq!(Delay::check("DELAY_MAX", 1e6, Time::ms(1000)), Ok(()));
        assert_eq!(
            Delay::check("DELAY_MAX", 60_000.0, Time::ms(10)).unwrap_err(),
            "DELAY_MAX is 60000 s, but a CYCLE of 10 ms allows at most 10000 s: make DELAY_MAX shorter or \
             CYCLE longer"
        );
        assert_eq!(Delay::new(1e300, Time::ms(10), 0.0).line.len(), 1_000_001);
        assert_eq!(Delay::new(1.0, Time::ZERO, 0.0).line.len(), 1);
    }
}
