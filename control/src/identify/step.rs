//! Finds the step in a record, and rejects a record from which the plant cannot be identified.

use super::{Recorded, SETTLED};
use crate::extremes;
use anyhow::{Result, bail};
use modeldescription::digits::short;

/// The maximum number of neighbours on each side used for smoothing.
const MOST_NEIGHBOURS: usize = 200;
/// The maximum RMS change due to smoothing, as a multiple of the RMS noise or rounding error, whichever is larger.
const SMOOTHED: f64 = 1.2;
/// The minimum number of samples after the step.
const FEWEST: usize = 10;
/// The minimum change in the manipulated value between two samples that counts as a step, relative to its span.
const STEP: f64 = 0.02;
/// The maximum deviation of the manipulated value from its level, relative to the step.
const FLAT: f64 = 0.05;
/// The minimum response of the process value as a multiple of its noise.
const ABOVE_NOISE: f64 = 10.0;
/// The minimum response of the process value as a multiple of its smallest change.
const COUNTS: f64 = 20.0;
/// The maximum effect of an earlier movement of the process value on the response, relative to the response.
const AT_REST: f64 = 0.05;
/// If the process value moves more slowly by this factor just before the step than earlier, the earlier part is treated
/// as another movement.
const CALMER: f64 = 4.0;

/// A step and its response: times after the step, values as deviations from the levels before it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    /// The time of the step in the record's seconds.
    pub start: f64,
    /// The times of the samples since the step, in seconds after it.
    pub times: Vec<f64>,
    /// The process value minus its level and drift before the step.
    pub values: Vec<f64>,
    /// The manipulated value from each time onward, minus its level before the step.
    pub moves: Vec<(f64, f64)>,
    /// The signed change in the manipulated value.
    pub height: f64,
    /// The process value before the step, and its drift per second.
    pub before: (f64, f64),
    /// The standard deviation of the noise.
    pub noise: f64,
    /// Remarks for the user, one sentence each.
    pub remarks: Vec<String>,
}

/// A movement of the manipulated value, from the first changed sample to the last.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Move {
    first: usize,
    last: usize,
    /// The sample at which the constant value before the movement begins.
    rest: usize,
    from: f64,
    to: f64,
}

impl Step {
    /// Finds the last step of a record and extracts the response.
    pub(super) fn new(recorded: &Recorded, is_integrating: bool) -> Result<Step> {
        check(recorded)?;
        let Recorded { times, output, .. } = *recorded;
        let means = means_of_pulses(times, recorded.input);
        let input = means.as_ref().map_or(recorded.input, |(means, _)| means);
        let found = find(times, input)?;
        let height = found.to - found.from;
        let start = times[found.first];
        let duration = times[times.len() - 1] - start;
        if times.len() - found.first < FEWEST {
            bail!(
                "only {} samples follow the step in the manipulated value at {} s: record at least {FEWEST}",
                times.len() - found.first,
                short(start)
            );
        }
        // Before the step, use at most half as much time as is recorded after it: earlier samples do not show whether
        // the plant is in steady state at the step.
        let begin = (found.rest..found.first).find(|at| start - times[*at] <= duration / 2.0).unwrap_or(found.first);
        let begin = if is_integrating { begin } else { calmest(times, output, begin, found.first) };
        let resting = Line::through(&times[begin..=found.first], &output[begin..=found.first], start);
        let noise = noise(&output[begin..]);
        let after: Vec<f64> = times[found.first..].iter().map(|time| time - start).collect();
        let mut step = Step {
            start,
            moves: moves(&input[found.first..], &after, &found),
            times: after,
            values: output[found.first..].iter().map(|value| value - resting.mean).collect(),
            height,
            before: (resting.mean, 0.0),
            noise,
            remarks: Vec::new(),
        };
        if let Some((_, period)) = means {
            step.remarks.push(format!(
                "The manipulated value consists of pulses: its means over {} s are used.",
                short(period)
            ));
        }
        step.require_answer(&output[begin..])?;
        step.consider_rest(&resting, is_integrating)?;
        step.require_room()?;
        if found.first - begin < 2 {
            step.remarks.push(
                "Almost nothing is recorded before the step: the process value is assumed to have been steady.".into(),
            );
        }
        Ok(step)
    }

    /// Returns the mean time between two samples.
    pub(super) fn interval(&self) -> f64 {
        self.duration() / (self.times.len() - 1) as f64
    }

    /// Returns the time from the step to the end of the record.
    pub(super) fn duration(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// Returns what was subtracted from a sample of the process value: the level before the step, extrapolated with the
    /// drift.
    pub(super) fn level(&self, at: usize) -> f64 {
        self.before.0 + self.before.1 * self.times[at]
    }

    /// Returns the mean of the last tenth of the record: the new level, if the response has settled.
    pub(super) fn end(&self) -> f64 {
        let tail = &self.values[self.values.len() - (self.values.len() / 10).max(1)..];
        tail.iter().sum::<f64>() / tail.len() as f64
    }

    /// Returns the time, in seconds after the step, at which this fraction of the response is first reached.
    pub(super) fn reaches(&self, part: f64) -> Option<f64> {
        self.crossing(&self.smoothed(), part * self.end())
    }

    /// Returns the time, in seconds after the step, at which values first reach a level, interpolated between samples.
    pub(super) fn crossing(&self, values: &[f64], level: f64) -> Option<f64> {
        let sign = level.signum();
        let at = values.iter().position(|value| value * sign >= level * sign)?;
        let Some(before) = at.checked_sub(1) else { return Some(self.times[0]) };
        let part = (level - values[before]) / (values[at] - values[before]);
        Some(self.times[before] + part * (self.times[at] - self.times[before]))
    }

    /// Returns the values with most of their noise removed: means over enough neighbours to reduce it to one percent of
    /// the response, but over at most a hundredth of the record.
    pub(super) fn smoothed(&self) -> Vec<f64> {
        let wanted = (self.noise / (0.01 * self.end().abs())).powi(2);
        let most = self.values.len() as f64 / 100.0;
        let half = (wanted.min(most) / 2.0).ceil() as usize;
        if half == 0 || self.noise < 1e-3 * self.end().abs() {
            return self.values.clone();
        }
        let mut sums = vec![0.0];
        sums.extend(self.values.iter().scan(0.0, |sum, value| {
            *sum += value;
            Some(*sum)
        }));
        let mean = |at: usize| {
            let reach = half.min(at).min(self.values.len() - 1 - at);
            (sums[at + reach + 1] - sums[at - reach]) / (2 * reach + 1) as f64
        };
        (0..self.values.len()).map(mean).collect()
    }

    /// Replaces each value with that of a parabola fitted to its neighbours, provided that only noise and rounding are
    /// lost. A plant's response slows down with time, so the number of neighbours grows with the time since the
    /// response began.
    pub(super) fn smooth(&mut self) {
        let lost = self.noise.max(resolution(&self.values) / 12.0_f64.sqrt());
        let Some(begin) = self.values.iter().position(|value| value.abs() > 4.0 * lost) else { return };
        for part in [6, 12, 24, 48] {
            let smooth = |at: usize| parabola(&self.values, at, (at.saturating_sub(begin) / part).min(MOST_NEIGHBOURS));
            let smoothed: Vec<f64> = (0..self.values.len()).map(smooth).collect();
            let squares = self.values.iter().zip(&smoothed).map(|(is, smooth)| (is - smooth) * (is - smooth));
            if (squares.sum::<f64>() / self.values.len() as f64).sqrt() <= SMOOTHED * lost {
                self.values = smoothed;
                return;
            }
        }
    }

    /// Returns the change in the last fifth of the record beyond what noise can explain, relative to the response.
    fn unrest(&self) -> f64 {
        let tail = self.times.partition_point(|time| *time < 0.8 * self.duration());
        let line = Line::through(&self.times[tail..], &self.values[tail..], self.duration());
        let change = line.slope * 0.2 * self.duration();
        // Subtract the change that noise alone may cause.
        ((change.abs() - 3.0 * line.uncertainty * 0.2 * self.duration()) / self.end().abs()).max(0.0)
    }

    /// Rejects a record in which the response has not settled.
    pub(super) fn require_end(&self, method: &str) -> Result<()> {
        let unrest = self.unrest();
        if unrest > SETTLED {
            bail!(
                "the process value is still moving at the end of the record, by {:.1} % of its response in the last \
                 fifth, and {method} needs its final level: record longer, use least squares, or choose an \
                 integrating plant",
                unrest * 100.0
            );
        }
        Ok(())
    }

    /// Rejects a record in which the process value does not respond, or too little compared with its noise and
    /// resolution.
    fn require_answer(&self, output: &[f64]) -> Result<()> {
        let largest = self
            .values
            .iter()
            .copied()
            .fold(0.0, |most: f64, value| if value.abs() > most.abs() { value } else { most });
        if largest == 0.0 {
            bail!(
                "the process value has not moved in the {} s after the step at {} s: record longer, and check that it is \
                 the right signal",
                short(self.duration()),
                short(self.start)
            );
        }
        if self.noise > 0.0 && largest.abs() < ABOVE_NOISE * self.noise {
            bail!(
                "the process value has moved by only {:.4}, less than {ABOVE_NOISE} times its noise of {:.4}: make a \
                 larger step, or record longer",
                largest.abs(),
                self.noise
            );
        }
        let count = resolution(output);
        if largest.abs() < COUNTS * count {
            bail!(
                "the process value has moved by {:.4}, only {:.0} times its smallest change of {count:.4}: \
                 make a step at least {:.0} times as large",
                largest.abs(),
                largest.abs() / count,
                (COUNTS * count / largest.abs()).ceil()
            );
        }
        Ok(())
    }

    /// Subtracts a drift, and rejects a process value that was not steady before the step.
    fn consider_rest(&mut self, resting: &Line, is_integrating: bool) -> Result<()> {
        if !resting.is_significant() {
            return Ok(());
        }
        let (drift, whole) = (resting.slope, self.duration());
        let answer = self.end();
        if is_integrating {
            // The gain follows from the change in slope due to the step, so any slope before it is acceptable.
            self.take_off(resting);
            if drift.abs() * whole > SETTLED * answer.abs() {
                self.remarks.push(format!(
                    "The process value was moving by {drift:.4} per second before the step; the change in its slope is \
                     used."
                ));
            }
            return Ok(());
        }
        let tail = self.times.partition_point(|time| *time < 0.8 * whole);
        let end = Line::through(&self.times[tail..], &self.values[tail..], whole);
        let goes_on = (end.slope - drift).abs() <= 0.3 * drift.abs() + 3.0 * end.uncertainty;
        let left = drift * self.reaches(0.632).unwrap_or(whole) / answer;
        if goes_on && (drift * whole).abs() > SETTLED * (answer - drift * whole).abs() {
            if (drift * whole).abs() > (answer - drift * whole).abs() {
                bail!(
                    "the process value drifts by {drift:.4} per second, which over the record exceeds the response to \
                     the step: wait until it is steady, or make a larger step"
                );
            }
            self.take_off(resting);
            self.remarks.push(format!(
                "The process value drifts by {drift:.4} per second before and after the step; the drift has been \
                 subtracted."
            ));
        } else if left.abs() > AT_REST && !goes_on {
            bail!(
                "the process value was not steady before the step: it moved by {drift:.4} per second, which would \
                 account for {:.0} % of the response: wait until it is steady, then make the step",
                left.abs() * 100.0
            );
        } else if left.abs() > AT_REST / 5.0 {
            self.remarks.push(format!(
                "The process value was not quite steady before the step: it moved by {drift:.4} per second."
            ));
        }
        Ok(())
    }

    /// Subtracts the level and the slope before the step from the values.
    fn take_off(&mut self, resting: &Line) {
        let (level, drift) = (resting.at_end, resting.slope);
        for (value, time) in self.values.iter_mut().zip(&self.times) {
            *value += self.before.0 - level - drift * time;
        }
        self.before = (level, drift);
    }

    /// Rejects a process value that runs into a limit: one that stops abruptly while moving fast.
    fn require_room(&self) -> Result<()> {
        let last = self.values[self.values.len() - 1] + self.level(self.values.len() - 1);
        let raw = |at: usize| self.values[at] + self.level(at);
        let is_at_stop = |at: &usize| (raw(*at) - last).abs() > 1e-12 * last.abs().max(1e-300);
        let Some(moving) = (0..self.values.len()).rev().find(is_at_stop) else { return Ok(()) };
        let stop = moving + 1;
        if self.values.len() - stop < 5 || stop < 5 {
            return Ok(());
        }
        let rate = |at: usize| (raw(at) - raw(at - 3)).abs() / (self.times[at] - self.times[at - 3]);
        let fastest = (3..=stop).map(rate).fold(0.0, f64::max);
        let before: Vec<f64> = (0..=stop).map(raw).collect();
        let few_counts = 3.5 * resolution(&before);
        // The last moving sample may have been taken just before the stop.
        if rate(moving) > 0.05 * fastest
            && (raw(moving) - raw(moving - 3)).abs() >= few_counts
            && !self.is_reversed(moving)
        {
            bail!(
                "the process value stops at {} after {} s while moving fast: it, or the actuator, is at the end of its \
                 range: make a smaller step",
                short(last),
                short(self.times[stop])
            );
        }
        Ok(())
    }

    /// Whether the last moving value is beyond the value at which the process value stops, as noise may cause.
    fn is_reversed(&self, moving: usize) -> bool {
        let end = self.values[self.values.len() - 1];
        (self.values[moving] - end) * end.signum() > 0.0
    }
}

/// A straight line through samples.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    count: usize,
    mean: f64,
    slope: f64,
    /// The value of the line at the requested time.
    at_end: f64,
    /// The standard deviation of the slope.
    uncertainty: f64,
}

impl Line {
    fn through(times: &[f64], values: &[f64], at: f64) -> Line {
        let count = times.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let middle = times.iter().sum::<f64>() / count;
        let spread: f64 = times.iter().map(|time| (time - middle) * (time - middle)).sum();
        let slope = if spread > 0.0 {
            times.iter().zip(values).map(|(time, value)| (time - middle) * (value - mean)).sum::<f64>() / spread
        } else {
            0.0
        };
        let missed = |(time, value): (&f64, &f64)| (value - mean - slope * (time - middle)).powi(2);
        let square: f64 = times.iter().zip(values).map(missed).sum();
        let uncertainty = if times.len() > 2 { (square / (count - 2.0) / spread).sqrt() } else { 0.0 };
        Line { count: times.len(), mean, slope, at_end: mean + slope * (at - middle), uncertainty }
    }

    /// Whether the slope is larger than noise alone can explain.
    fn is_significant(&self) -> bool {
        self.count > 2 && self.slope.abs() > 4.0 * self.uncertainty
    }
}

/// Returns the sample from which the process value is steady before the step. An earlier movement that has died away,
/// such as the response to the first manual value, is excluded; a constant drift is not. `begin` is the first
/// sample considered.
fn calmest(times: &[f64], output: &[f64], begin: usize, step: usize) -> usize {
    let line = |begin: usize| Line::through(&times[begin..=step], &output[begin..=step], times[step]);
    let (mut calmest, mut slope) = (begin, line(begin));
    if !slope.is_significant() {
        return begin;
    }
    let mut length = (step - begin) / 2;
    while length >= FEWEST {
        let shorter = line(step - length);
        if shorter.slope.abs() + 2.0 * shorter.uncertainty < slope.slope.abs() / CALMER {
            (calmest, slope) = (step - length, shorter);
        }
        length /= 2;
    }
    calmest
}

/// Rejects records that are too short, have missing values, or whose times do not increase.
fn check(recorded: &Recorded) -> Result<()> {
    let Recorded { times, input, output } = *recorded;
    if times.len() != input.len() || times.len() != output.len() {
        bail!(
            "{} times, {} manipulated values and {} process values: every sample needs one of each",
            times.len(),
            input.len(),
            output.len()
        );
    }
    if times.len() < FEWEST {
        bail!("the record has only {} samples: record at least {FEWEST} after the step", times.len());
    }
    if let Some(at) =
        (0..times.len()).find(|at| ![times[*at], input[*at], output[*at]].iter().all(|value| value.is_finite()))
    {
        bail!("sample {at} at {} s has a value that is not a number: choose another part of the record", times[at]);
    }
    if let Some(at) = (1..times.len()).find(|at| times[*at] <= times[at - 1]) {
        bail!("the time goes from {} s to {} s: it must increase from sample to sample", times[at - 1], times[at]);
    }
    Ok(())
}

/// Finds the last step in the manipulated value.
fn find(times: &[f64], input: &[f64]) -> Result<Move> {
    let (low, high) = extremes(input);
    let span = high - low;
    if span <= 1e-12 * low.abs().max(high.abs()) {
        bail!(
            "no step found: the manipulated value is constant at {low}; change it once in manual mode while recording"
        );
    }
    let threshold = (STEP * span).max(10.0 * typical_change(input));
    let changes: Vec<usize> = (1..input.len()).filter(|at| (input[*at] - input[at - 1]).abs() > threshold).collect();
    let Some(last) = changes.last().copied() else {
        bail!(
            "no step found: the manipulated value goes from {low} to {high}, but never by more than {:.1} % of this \
             range in one sample; change it in a single step, in manual mode",
            threshold / span * 100.0
        );
    };
    // Changes with at most two samples between them belong to one movement.
    let groups = changes.windows(2).rposition(|pair| pair[1] - pair[0] > 3);
    let first = groups.map_or(changes[0], |group| changes[group + 1]);
    let rest = groups.map_or(0, |group| changes[group]);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (from, to) = (mean(&input[rest..first]), mean(&input[last..]));
    let (start, end) = (times[first], times[times.len() - 1]);
    if times[last] - start > 0.1 * (end - start) {
        bail!(
            "no step found: the manipulated value moves from {} s to {} s, and the record ends at {} s; change it \
             once in manual mode, and record until the process value is steady again",
            short(start),
            short(times[last]),
            short(end)
        );
    }
    let height = (to - from).abs();
    for (when, values) in [("before", &input[rest..first]), ("after", &input[last..])] {
        let third = values.len().div_ceil(3);
        let (begin, finish) = (mean(&values[..third]), mean(&values[values.len() - third..]));
        if (finish - begin).abs() > FLAT * height {
            bail!(
                "the manipulated value is not constant {when} the step at {} s: it goes from {begin:.4} to \
                 {finish:.4}: make the step in manual mode",
                short(start)
            );
        }
    }
    Ok(Move { first, last, rest, from, to })
}

/// Returns the manipulated value after the step as moves: one for each sample during the movement, then the new level.
fn moves(input: &[f64], times: &[f64], found: &Move) -> Vec<(f64, f64)> {
    let length = found.last - found.first;
    let within = (0..length).map(|at| (times[at], input[at] - found.from));
    within.chain([(times[length], found.to - found.from)]).collect()
}

/// The minimum number of changes for a signal to count as pulses.
const PULSES: usize = 8;

/// Replaces a pulse signal with at most three levels by its mean in each period, from the beginning of one pulse to
/// that of the next, and returns it with the median period; `None` for any other signal.
pub fn means_of_pulses(times: &[f64], input: &[f64]) -> Option<(Vec<f64>, f64)> {
    let mut levels: Vec<f64> = Vec::new();
    for value in input {
        if !levels.contains(value) {
            levels.push(*value);
        }
        if levels.len() > 3 {
            return None;
        }
    }
    let changes = input.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let begins: Vec<usize> = (1..input.len()).filter(|at| input[*at].abs() > input[at - 1].abs()).collect();
    let mut periods: Vec<f64> = begins.windows(2).map(|pair| times[pair[1]] - times[pair[0]]).collect();
    if changes < PULSES || periods.is_empty() {
        return None;
    }
    let period = median(&mut periods);
    let mut means = input.to_vec();
    for (place, begin) in begins.iter().enumerate() {
        let (from, next) = (times[*begin], begins.get(place + 1).copied());
        // The period of the last pulse, or of the last one before a pause, is taken to be the median period; half a
        // sample allows for rounding.
        let interval = times[*begin] - times[begin - 1];
        let end = next
            .filter(|next| times[*next] - from <= 1.5 * period)
            .unwrap_or_else(|| times.partition_point(|time| *time < from + period - interval / 2.0));
        let is_cut_off = times[end - 1] + 1.5 * interval < from + period && end == times.len();
        let mean = input[*begin..end].iter().sum::<f64>() / (end - begin) as f64;
        let value = if is_cut_off { means[begin - 1] } else { mean };
        means[*begin..end].fill(value);
    }
    // If the record begins within a period, only the remainder of that period is recorded: use the mean of the next
    // one. A longer time before the first pulse is a pause.
    if times[begins[0]] - times[0] <= 1.5 * period {
        let first = means[begins[0]];
        means[..begins[0]].fill(first);
    }
    Some((means, period))
}

/// Returns the value at a sample of the parabola that best fits its neighbours (Savitzky and Golay), with up to `reach`
/// neighbours on each side.
fn parabola(values: &[f64], at: usize, reach: usize) -> f64 {
    let reach = reach.min(at).min(values.len() - 1 - at);
    if reach < 2 {
        return values[at];
    }
    let count = (2 * reach + 1) as f64;
    let square = (reach * (reach + 1)) as f64;
    // With n = 2 reach + 1 and m = reach (reach + 1), the weight of neighbour i is (3 (3 m - 1) - 15 i^2) / (n (4 m -
    // 3)).
    let weight = |i: f64| (3.0 * (3.0 * square - 1.0) - 15.0 * i * i) / (count * (4.0 * square - 3.0));
    let neighbours = values[at - reach..=at + reach].iter().enumerate();
    neighbours.map(|(place, value)| weight(place as f64 - reach as f64) * value).sum()
}

/// Returns the median absolute change from sample to sample: a measure of the noise, since steps are rare.
fn typical_change(values: &[f64]) -> f64 {
    let mut changes: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    median(&mut changes)
}

/// Returns the standard deviation of the noise, estimated from the difference between each sample and the mean of its
/// two neighbours. Triples with a missing value are ignored.
pub(crate) fn noise(values: &[f64]) -> f64 {
    let bends = values.windows(3).map(|three| (three[0] - 2.0 * three[1] + three[2]).abs());
    let mut bends: Vec<f64> = bends.filter(|bend| bend.is_finite()).collect();
    median(&mut bends) / (0.6745 * 6.0_f64.sqrt())
}

fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Returns the smallest change from sample to sample; 0 if there is none.
pub fn resolution(values: &[f64]) -> f64 {
    let changes = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|change| *change > 0.0);
    let smallest = changes.fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 0.0 }
}
