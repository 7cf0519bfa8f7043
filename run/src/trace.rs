//! A recording of a run with bounded size: the most recent calls exactly, earlier ones as an overview.

use std::collections::VecDeque;
use std::ops::Range;

/// The minimum number of most recent calls kept exactly.
pub const EXACT: usize = 65_536;

/// The number of calls packed together.
const CHUNK: usize = 1024;

/// The maximum number of buckets in the overview; beyond it, pairs of buckets are merged.
const BUCKETS: usize = 4096;

/// The initial number of calls in a bucket.
const FIRST_WIDTH: usize = 16;

/// The values of several variables in each call.
#[derive(Clone, Debug)]
pub struct Trace {
    /// The number of variables.
    width: usize,
    /// The number of calls.
    calls: usize,
    /// The calls before the first chunk.
    overview: Overview,
    chunks: VecDeque<Chunk>,
    /// The calls after the last chunk, row by row.
    rows: Vec<f64>,
}

/// A chunk of calls, packed variable by variable.
#[derive(Clone, Debug)]
struct Chunk {
    /// The index of its first call.
    first: usize,
    calls: usize,
    columns: Vec<Packed>,
}

/// The values of a variable, losslessly packed.
#[derive(Clone, Debug)]
enum Packed {
    /// The same value in each call.
    Constant(f64),
    Flags(Box<[bool]>),
    Single(Box<[f32]>),
    Double(Box<[f64]>),
}

/// The lowest and highest values in buckets of calls, starting at call 0.
#[derive(Clone, Debug)]
struct Overview {
    /// The number of calls it covers.
    calls: usize,
    /// The number of calls in each bucket; the last one may have fewer.
    bucket: usize,
    /// The buckets of each variable.
    columns: Vec<Vec<Extremes>>,
}

/// The lowest and highest of several values of a variable, ignoring NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extremes {
    low: f64,
    high: f64,
    /// Whether the highest value comes after the lowest.
    rises: bool,
}

impl Extremes {
    const NONE: Extremes = Extremes { low: f64::NAN, high: f64::NAN, rises: true };

    fn new(value: f64) -> Extremes {
        Extremes { low: value, high: value, rises: true }
    }

    /// Includes later values.
    fn extend(&mut self, later: Extremes) {
        if later.low.is_nan() {
            return;
        }
        if self.low.is_nan() {
            *self = later;
            return;
        }
        let (is_lower, is_higher) = (later.low < self.low, later.high > self.high);
        self.rises = match (is_lower, is_higher) {
            (true, true) => later.rises,
            (true, false) => false,
            (false, true) => true,
            (false, false) => self.rises,
        };
        (self.low, self.high) = (self.low.min(later.low), self.high.max(later.high));
    }

    /// Both values in order of time.
    fn in_time(self) -> (f64, f64) {
        if self.rises { (self.low, self.high) } else { (self.high, self.low) }
    }
}

impl Packed {
    fn new(values: impl Iterator<Item = f64> + Clone) -> Packed {
        let first = values.clone().next().unwrap_or(f64::NAN);
        if values.clone().all(|value| value.to_bits() == first.to_bits()) {
            return Packed::Constant(first);
        }
        let is_flag = |value: f64| value.to_bits() == 0 || value == 1.0;
        if values.clone().all(is_flag) {
            return Packed::Flags(values.map(|value| value == 1.0).collect());
        }
        if values.clone().all(|value| f64::from(value as f32).to_bits() == value.to_bits()) {
            return Packed::Single(values.map(|value| value as f32).collect());
        }
        Packed::Double(values.collect())
    }

    fn get(&self, place: usize) -> f64 {
        match self {
            Packed::Constant(value) => *value,
            Packed::Flags(values) => f64::from(u8::from(values[place])),
            Packed::Single(values) => f64::from(values[place]),
            Packed::Double(values) => values[place],
        }
    }
}

impl Overview {
    /// Adds the calls of the next chunk.
    fn take(&mut self, chunk: &Chunk) {
        for (buckets, packed) in self.columns.iter_mut().zip(&chunk.columns) {
            for place in 0..chunk.calls {
                let value = Extremes::new(packed.get(place));
                match buckets.get_mut((self.calls + place) / self.bucket) {
                    Some(bucket) => bucket.extend(value),
                    None => buckets.push(value),
                }
            }
        }
        self.calls += chunk.calls;
        while self.calls.div_ceil(self.bucket) > BUCKETS - CHUNK / FIRST_WIDTH {
            self.bucket *= 2;
            for buckets in &mut self.columns {
                let count = buckets.len().div_ceil(2);
                for pair in 0..count {
                    let mut both = buckets[2 * pair];
                    if let Some(later) = buckets.get(2 * pair + 1) {
                        both.extend(*later);
                    }
                    buckets[pair] = both;
                }
                buckets.truncate(count);
            }
        }
    }
}

impl Trace {
    /// An empty trace of this many variables.
    pub fn new(width: usize) -> Trace {
        Trace {
            width,
            calls: 0,
            overview: Overview { calls: 0, bucket: FIRST_WIDTH, columns: vec![Vec::new(); width] },
            chunks: VecDeque::with_capacity(EXACT / CHUNK + 2),
            rows: Vec::with_capacity(CHUNK * width),
        }
    }

    /// The number of calls.
    pub fn calls(&self) -> usize {
        self.calls
    }

    /// The range of calls kept exactly.
    pub fn exact(&self) -> Range<usize> {
        self.overview.calls..self.calls
    }

    /// Records a call.
    ///
    /// # Panics
    /// The number of values differs from the number of variables.
    pub fn push(&mut self, row: &[f64]) {
        assert_eq!(row.len(), self.width, "each variable has a value");
        self.rows.extend_from_slice(row);
        self.calls += 1;
        if self.calls - self.packed() == CHUNK {
            self.pack();
        }
    }

    /// Adds variables, with NaN for all calls so far.
    pub fn widen(&mut self, count: usize) {
        self.pack();
        self.width += count;
        let buckets = self.overview.calls.div_ceil(self.overview.bucket);
        for _ in 0..count {
            self.overview.columns.push(vec![Extremes::NONE; buckets]);
        }
        for chunk in &mut self.chunks {
            chunk.columns.extend((0..count).map(|_| Packed::Constant(f64::NAN)));
        }
        self.rows = Vec::with_capacity(CHUNK * self.width);
    }

    /// The number of calls before `rows`.
    fn packed(&self) -> usize {
        self.chunks.back().map_or(self.overview.calls, |chunk| chunk.first + chunk.calls)
    }

    /// Packs the rows, and moves chunks that no longer need to be kept exactly to the overview.
    fn pack(&mut self) {
        let first = self.packed();
        let calls = self.calls - first;
        if calls == 0 {
            return;
        }
        let column = |column| Packed::new(self.rows[column..].iter().step_by(self.width).copied());
        let columns = (0..self.width).map(column).collect();
        self.chunks.push_back(Chunk { first, calls, columns });
        self.rows.clear();
        while let Some(oldest) = self.chunks.front()
            && self.calls - (oldest.first + oldest.calls) >= EXACT
        {
            self.overview.take(oldest);
            self.chunks.pop_front();
        }
    }

    /// The allocated size in bytes.
    pub fn capacity(&self) -> usize {
        let of = |packed: &Packed| match packed {
            Packed::Constant(_) => 0,
            Packed::Flags(values) => values.len(),
            Packed::Single(values) => 4 * values.len(),
            Packed::Double(values) => 8 * values.len(),
        };
        let chunks = self.chunks.iter().flat_map(|chunk| &chunk.columns).map(of).sum::<usize>();
        let columns = self.chunks.iter().map(|chunk| chunk.columns.capacity() * size_of::<Packed>()).sum::<usize>();
        let overview =
            self.overview.columns.iter().map(|column| column.capacity() * size_of::<Extremes>()).sum::<usize>();
        8 * self.rows.capacity() + self.chunks.capacity() * size_of::<Chunk>() + chunks + columns + overview
    }

    /// The value of a variable in a call; NaN if the call is no longer kept exactly.
    pub fn get(&self, column: usize, call: usize) -> f64 {
        if call >= self.packed() {
            let place = (call - self.packed()) * self.width + column;
            return self.rows.get(place).copied().unwrap_or(f64::NAN);
        }
        let chunk = self.chunks.partition_point(|chunk| chunk.first + chunk.calls <= call);
        match self.chunks.get(chunk) {
            Some(chunk) if chunk.first <= call => chunk.columns[column].get(call - chunk.first),
            _ => f64::NAN,
        }
    }

    /// The values of a variable in a range of calls; NaN where a call is no longer kept exactly.
    pub fn column(&self, column: usize, calls: Range<usize>) -> impl Iterator<Item = f64> + '_ {
        calls.map(move |call| self.get(column, call))
    }

    /// The mean of a variable over the `length` calls that end with each of these ascending calls; over fewer at the
    /// beginning of the exactly kept range, NaN before it.
    pub fn means(&self, column: usize, calls: &[usize], length: usize) -> Vec<f64> {
        let Range { start, end } = self.exact();
        let first = calls.first().map_or(start, |call| (call + 1).saturating_sub(length)).max(start);
        let last = calls.last().map_or(first, |call| (call + 1).min(end));
        let mut sums = vec![0.0];
        self.each(column, first..last, |_, value| sums.push(sums[sums.len() - 1] + value));
        let mean = |call: &usize| {
            let after = (call + 1).saturating_sub(first).min(sums.len() - 1);
            let before = after.saturating_sub(length);
            (sums[after] - sums[before]) / (after - before) as f64
        };
        calls.iter().map(mean).collect()
    }

    /// Calls `give` with the index of each call in an exactly kept range and the variable's value.
    fn each(&self, column: usize, calls: Range<usize>, mut give: impl FnMut(usize, f64)) {
        for chunk in &self.chunks {
            let all = chunk.first..chunk.first + chunk.calls;
            for call in calls.start.max(all.start)..calls.end.min(all.end) {
                give(call, chunk.columns[column].get(call - chunk.first));
            }
        }
        let packed = self.packed();
        for call in calls.start.max(packed)..calls.end {
            give(call, self.rows[(call - packed) * self.width + column]);
        }
    }

    /// The lowest and highest values of a variable in each group, in order of time, as in [`Curves`].
    fn extremes(&self, column: usize, calls: &Range<usize>, groups: &Groups) -> Vec<(f64, f64)> {
        let mut all = vec![Extremes::NONE; groups.count];
        let mut put = |call: usize, value: Extremes| all[groups.group(call)].extend(value);
        if calls.start < self.overview.calls {
            let width = self.overview.bucket;
            let last = calls.end.min(self.overview.calls).div_ceil(width);
            for bucket in calls.start / width..last {
                put((bucket * width).max(calls.start), self.overview.columns[column][bucket]);
            }
        }
        let exact = calls.start.max(self.overview.calls)..calls.end;
        if !exact.is_empty() {
            let mut group = groups.group(exact.start);
            let mut end = groups.first_call(group + 1);
            self.each(column, exact, |call, value| {
                while call >= end {
                    group += 1;
                    end = groups.first_call(group + 1);
                }
                all[group].extend(Extremes::new(value));
            });
        }
        all.into_iter().map(Extremes::in_time).collect()
    }

    /// The curves of variables over a range of calls, with at most `points` points (at least 2).
    pub fn curves(&self, columns: &[usize], calls: Range<usize>, points: usize) -> Curves {
        let calls = calls.start.min(self.calls)..calls.end.min(self.calls);
        let count = calls.len();
        if count == 0 || calls.start >= self.overview.calls && count <= points {
            let values = columns.iter().map(|column| self.column(*column, calls.clone()).collect()).collect();
            return Curves { calls: calls.collect(), values, is_exact: true };
        }
        let groups = Groups { first: calls.start, calls: count, count: (points / 2).clamp(1, count.max(1)) };
        // An overview bucket may span several groups; all of them but the first are then empty.
        let is_there = |group: &usize| {
            let (first, end) = (groups.first_call(*group), groups.first_call(group + 1));
            *group == 0 || end > self.overview.calls || first.next_multiple_of(self.overview.bucket) < end
        };
        let there: Vec<usize> = (0..groups.count).filter(is_there).collect();
        let mut curves = Curves { calls: Vec::with_capacity(2 * there.len()), values: Vec::new(), is_exact: false };
        for (place, group) in there.iter().enumerate() {
            let first = groups.first_call(*group);
            let end = there.get(place + 1).map_or(calls.end, |next| groups.first_call(*next));
            curves.calls.extend([first, end - 1]);
        }
        for column in columns {
            let extremes = self.extremes(*column, &calls, &groups);
            curves.values.push(there.iter().flat_map(|group| [extremes[*group].0, extremes[*group].1]).collect());
        }
        curves
    }
}

/// A range of calls divided into groups of nearly equal size.
struct Groups {
    /// The first call.
    first: usize,
    /// The number of calls.
    calls: usize,
    /// The number of groups, at most the number of calls unless there are none.
    count: usize,
}

impl Groups {
    fn first_call(&self, group: usize) -> usize {
        self.first + (group as u64 * self.calls as u64).div_ceil(self.count as u64) as usize
    }

    fn group(&self, call: usize) -> usize {
        ((call - self.first) as u64 * self.count as u64 / self.calls as u64) as usize
    }
}

/// Curves of variables over calls. If they are exact, each call is a point. Otherwise, each pair of points represents a
/// group of calls: its first and last call, with the lowest and highest values of each variable in the group in their
/// order of occurrence.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// The call indices.
    pub calls: Vec<usize>,
    /// The values of each variable.
    pub values: Vec<Vec<f64>>,
    /// Whether every call is included.
    pub is_exact: bool,
}

#[cfg(test)]
mod tests;
