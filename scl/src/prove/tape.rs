//! Generates the inputs of each call and the expected outputs.

use crate::random::Random;
use blocks::{Block, EachBlock, Kind, Role, StaticRow, StaticTable, Time, Value, Word, for_each_block};

/// The maximum number of calls on a tape.
pub const MOST_CALLS: usize = 1_000_000;

/// If at least half of the outputs are truth values, one in this many calls places an input at a switching threshold:
/// numeric outputs reveal differences anyway.
const THRESHOLD: u64 = 4;

/// An entry of the tape: a changed input, or an output whose expected value changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The number of the input or output: inputs are numbered from 1, outputs after them. 0 for a call without changes.
    pub what: u8,
    /// Whether this is the last entry before its call.
    pub is_last: bool,
    /// The bits of the value.
    pub bits: u32,
}

/// The inputs of each call and the expected outputs.
#[derive(Clone, Debug)]
pub struct Tape {
    /// The block.
    pub table: &'static StaticTable,
    /// The numbers of the table rows that the tape sets, in table order.
    pub inputs: Vec<usize>,
    /// The numbers of the table rows that are compared after each call.
    pub outputs: Vec<usize>,
    /// The changes, in the order of the calls.
    pub entries: Vec<Entry>,
    /// The number of calls.
    pub calls: usize,
    /// The seed of the random numbers.
    pub seed: u32,
}

/// The common characteristics of consecutive calls. They vary between stretches, because most differences between two
/// laws appear only when values coincide, or after a long time without changes.
struct Stretch {
    /// The number of calls.
    length: usize,
    /// A signal changes in one of this many calls, on average.
    pace: u64,
    /// A setting or switch changes in one of this many calls, on average.
    unrest: u64,
    /// The largest typical magnitude of a signal.
    scale: f32,
    /// The grid of signal values, which makes sums and limits coincide exactly; 0 for none.
    grid: f32,
    /// The sampling time of the block, in milliseconds.
    cycle: i32,
    /// The default sampling time of the block, in milliseconds.
    start_cycle: f64,
    /// Whether most settings keep their defaults and some signals stay constant: several unusual values together mask
    /// the law's behaviour.
    is_plain: bool,
    /// Whether values at the ends of their ranges, or far from typical ones, may occur.
    is_wild: bool,
    /// Whether signals usually change only slightly.
    drifts: bool,
}

impl Stretch {
    fn new(random: &mut Random, table: &StaticTable, cycle: Time) -> Stretch {
        let start_cycle = match table.rows[table.cycle].start {
            Value::Time(time) => f64::from(time.milliseconds()),
            _ => 1.0,
        };
        let cycle = match random.below(6) {
            0 => 1 + random.below(2000) as i32,
            1 => random.one_of(&[1, 2, 10, 100, 500, 1000]),
            2 | 3 => start_cycle as i32,
            _ => cycle.milliseconds(),
        };
        let pace = random.one_of(&[1, 2, 3, 10, 40, 100]);
        Stretch {
            length: 20 + random.below(if pace > 3 { 150 } else { 60 }) as usize,
            pace,
            unrest: random.one_of(&[40, 200, 1000, 1000]),
            scale: random.one_of(&[1.0, 5.0, 20.0, 120.0, 120.0, 120.0]),
            grid: random.one_of(&[0.0, 0.0, 0.5, 1.0, 5.0, 10.0]),
            cycle,
            start_cycle,
            is_plain: !random.once_in(3),
            is_wild: random.once_in(5),
            drifts: random.once_in(3),
        }
    }

    /// A value for a row: usually a typical one, sometimes one at the end of its range.
    fn value(&self, random: &mut Random, row: &StaticRow) -> Value {
        let is_odd = self.is_wild && random.once_in(6);
        match row.kind {
            Kind::Bool => Value::Bool(random.once_in(2)),
            // The behaviour for a sampling time of 0 is undefined.
            Kind::Time if row.role == Role::Cycle => Value::Time(Time::ms(self.cycle)),
            Kind::Int if row.role == Role::Fixed => {
                let most = random.one_of(&[5, 20, 50]);
                Value::Int(1 + random.below(most) as i16)
            }
            Kind::Time if is_odd => Value::Time(Time::ms(random.below(600_000) as i32)),
            Kind::Time => Value::Time(Time::ms(self.time(random, row))),
            Kind::Word if is_odd => Value::Word(Word::new(random.one_of(&[i16::MIN, i16::MAX, 0, 27648]))),
            Kind::Word if random.once_in(3) => Value::Word(Word::new(random.bits() as i16)),
            // 27648 is 100 %.
            Kind::Word => Value::Word(Word::new((self.real(random) * 276.48) as i16)),
            Kind::Int if is_odd => Value::Int(random.one_of(&[i16::MIN, i16::MAX, -1, 0, 1])),
            Kind::Int => Value::Int(match random.below(8) {
                0 => random.bits() as i16,
                1 => -(random.below(200) as i16),
                2..=4 => random.below(12) as i16,
                _ => random.below(200) as i16,
            }),
            _ if is_odd => Value::Real(match random.below(3) {
                0 => random.real(1e6),
                _ => random.one_of(&[0.0, 1.0, 100.0, -100.0, -0.0]),
            }),
            _ if random.once_in(6)
                && let (Some(Value::Real(min)), Some(Value::Real(max))) = (row.min, row.max) =>
            {
                Value::Real(random.one_of(&[min, max]) + random.one_of(&[0.0, 0.5, -0.5, 2.0, -2.0]))
            }
            _ => Value::Real(match (row.start, random.below(8)) {
                // Usually of the same order of magnitude as the default.
                (Value::Real(start), 0..=5) if start != 0.0 => start * random.one_of(&[0.1, 0.25, 0.5, 0.9, 1.0, 2.0]),
                (Value::Real(start), 6) if start != 0.0 => random.real(2.0 * start),
                _ => self.real(random),
            }),
        }
    }

    /// The default value. A duration is scaled so that it spans as many calls as it does at the default sampling time.
    fn start(&self, row: &StaticRow) -> Value {
        match row.start {
            Value::Time(_) if row.role != Role::Cycle => Value::Time(Time::ms(self.calls(row, 1.0))),
            start => start,
        }
    }

    /// A duration in milliseconds that spans `factor` times as many calls as the default duration does at the default
    /// sampling time.
    fn calls(&self, row: &StaticRow, factor: f64) -> i32 {
        let Value::Time(start) = row.start else { return 0 };
        let calls = f64::from(start.milliseconds()) / self.start_cycle * factor;
        self.cycle.saturating_mul(calls.round() as i32)
    }

    /// A random duration in milliseconds: usually a multiple of the sampling time, and of about the default magnitude.
    fn time(&self, random: &mut Random, row: &StaticRow) -> i32 {
        let few = |random: &mut Random| self.cycle.saturating_mul(random.below(12) as i32);
        match random.below(16) {
            0 | 1 => 0,
            2 => few(random).saturating_add(random.below(3) as i32 - 1).max(0),
            3..=5 => few(random),
            6 => 1 + random.below(20_000) as i32,
            7 | 8 => self.cycle.saturating_mul(random.one_of(&[5, 10, 20, 25, 50, 100])),
            _ => {
                let factor = random.one_of(&[0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 2.0]);
                self.calls(row, factor).max(self.cycle)
            }
        }
    }

    /// The next value of a signal.
    fn next(&self, random: &mut Random, row: &StaticRow, old: Option<Value>) -> Value {
        match old {
            Some(Value::Real(old)) if self.drifts && !random.once_in(20) => {
                let step = if self.grid == 0.0 { self.scale / 32.0 } else { self.grid };
                Value::Real((old + self.on_grid(random.real(2.0 * step))).clamp(-self.scale, self.scale))
            }
            _ => self.value(random, row),
        }
    }

    fn real(&self, random: &mut Random) -> f32 {
        let value = random.real(self.scale);
        self.on_grid(value)
    }

    fn on_grid(&self, value: f32) -> f32 {
        if self.grid == 0.0 { value } else { (value / self.grid).round() * self.grid + 0.0 }
    }
}

/// The bits of a value as a DWORD.
pub(super) fn bits(value: Value) -> u32 {
    match value {
        Value::Word(word) => u32::from(word.value() as u16),
        // A tape contains no NaN.
        value => match value.kind() {
            Kind::Int => crate::ir::Value::of_plc(value).bits() as u16 as u32,
            _ => crate::ir::Value::of_plc(value).bits() as u32,
        },
    }
}

/// The rank of a value among all values of its type: neighbours differ by 1.
fn place_of(value: Value) -> i64 {
    match value {
        Value::Real(real) => {
            let bits = i64::from(real.to_bits() & 0x7FFF_FFFF);
            if real.is_sign_negative() { -bits } else { bits }
        }
        Value::Time(time) => i64::from(time.milliseconds()),
        Value::Word(word) => i64::from(word.value()),
        Value::Int(int) => i64::from(int),
        _ => 0,
    }
}

/// The value with this rank.
fn value_at(kind: Kind, place: i64) -> Value {
    match kind {
        Kind::Time => Value::Time(Time::ms(place as i32)),
        Kind::Word => Value::Word(Word::new(place as i16)),
        Kind::Int => Value::Int(place as i16),
        _ => Value::Real(f32::from_bits(place.unsigned_abs() as u32) * if place < 0 { -1.0 } else { 1.0 }),
    }
}

/// Whether a row is a signal: an input other than a truth value. Signals change more often than other inputs.
fn is_signal(row: &StaticRow) -> bool {
    row.role == Role::Input && row.kind != Kind::Bool
}

/// Whether a PLC computes with this value as the law does: it is neither infinite nor a subnormal number, which some
/// CPUs flush to 0.
fn is_usual(value: Value) -> bool {
    !matches!(value, Value::Real(real) if !real.is_finite() || real.is_subnormal())
}

impl Tape {
    /// Generates a tape for the block with this name or alias; `None` if there is no such block.
    pub fn new(name: &str, calls: usize, seed: u32) -> Option<Tape> {
        struct Make<'a>(&'a str, usize, u32, Option<Tape>);
        impl EachBlock for Make<'_> {
            fn block<B: Block>(&mut self) {
                let is_it = |it: &str| it.replace(' ', "").eq_ignore_ascii_case(&self.0.replace(' ', ""));
                if self.3.is_none() && (is_it(B::TABLE.name) || B::TABLE.aliases.iter().any(|alias| is_it(alias))) {
                    self.3 = Some(tape::<B>(self.1, self.2));
                }
            }
        }
        let mut make = Make(name, calls.min(MOST_CALLS), seed, None);
        for_each_block(&mut make);
        make.3
    }

    /// The names and values of all inputs in a call; calls are counted from 1.
    pub fn inputs_of(&self, call: usize) -> Vec<(String, String)> {
        let mut values: Vec<u32> = self.inputs.iter().map(|row| bits(self.table.rows[*row].start)).collect();
        let mut made = 0;
        for entry in &self.entries {
            // The changes before this call have been made.
            if made == call {
                break;
            }
            if let Some(value) = usize::from(entry.what).checked_sub(1).and_then(|input| values.get_mut(input)) {
                *value = entry.bits;
            }
            made += usize::from(entry.is_last);
        }
        let rows = self.inputs.iter().map(|row| &self.table.rows[*row]);
        rows.zip(values).map(|(row, bits)| (row.name.to_string(), super::outcome::value_text(row.kind, bits))).collect()
    }

    /// A number that two different tapes are unlikely to share.
    pub fn fingerprint(&self) -> u32 {
        // FNV-1a.
        let bytes = self.entries.iter().flat_map(|entry| {
            let head = [entry.what, u8::from(entry.is_last)];
            head.into_iter().chain(entry.bits.to_be_bytes())
        });
        bytes.fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
    }
}

/// The input that restarts the block when a call sets it, if there is one.
fn restart_input<B: Block>(inputs: &[usize]) -> Option<usize> {
    let table = B::TABLE;
    let mut random = Random::new(1);
    let stretch = Stretch::new(&mut random, table, Time::ms(1000));
    let switches = inputs.iter().copied().filter(|row| table.rows[*row].kind == Kind::Bool);
    let mut switches: Vec<usize> = switches.filter(|row| table.rows[*row].start == Value::Bool(false)).collect();
    for _ in 0..20 {
        let mut block = B::default();
        for row in inputs.iter().filter(|row| table.rows[**row].kind != Kind::Bool) {
            block.set(*row, stretch.value(&mut random, &table.rows[*row]));
        }
        (0..20).for_each(|_| block.call());
        switches.retain(|row| {
            let (mut called, mut restarted) = (block.clone(), block.clone());
            called.set(*row, Value::Bool(true));
            restarted.set(*row, Value::Bool(true));
            called.call();
            restarted.restart();
            let stored = |block: &B| {
                let mut bytes = Vec::new();
                block.write(&mut bytes);
                bytes
            };
            stored(&called) == stored(&restarted)
        });
    }
    switches.first().copied()
}

/// A call: the changed inputs, as indices into the tape's inputs, and the block after the call.
struct Call<B> {
    changes: Vec<(usize, Value)>,
    block: B,
}

struct Maker {
    random: Random,
    table: &'static StaticTable,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    restart: Option<usize>,
}

impl Maker {
    /// The new value of an input before a call, or `None` if it does not change.
    fn change(&mut self, stretch: &Stretch, number: usize, old: Option<Value>, begins: bool) -> Option<Value> {
        let random = &mut self.random;
        let row = &self.table.rows[number];
        if begins && row.role == Role::Cycle {
            Some(Value::Time(Time::ms(stretch.cycle)))
        } else if begins {
            let is_start = random.once_in(if is_signal(row) { 2 } else { 3 }) != stretch.is_plain;
            let value = if is_start { stretch.start(row) } else { stretch.value(random, row) };
            (stretch.is_plain || random.once_in(2)).then_some(value)
        } else if is_signal(row) {
            // A signal that starts at its default in a plain stretch stays there.
            let rests = stretch.is_plain && old == Some(row.start) && !random.once_in(20);
            (!rests && random.once_in(stretch.pace)).then(|| stretch.next(random, row, old))
        } else {
            random.once_in(stretch.unrest).then(|| stretch.value(random, row))
        }
    }

    /// The next call; `None` if no inputs are found with which all outputs are usual ([`is_usual`]) and the block has
    /// no restart input.
    fn call<B: Block>(&mut self, stretch: &Stretch, block: &B, begins: bool, is_first: bool) -> Option<Call<B>> {
        let restarts = is_first || begins && self.random.once_in(3) || self.random.once_in(400);
        for tries in 0..40 {
            let mut next = block.clone();
            let mut changes = Vec::new();
            for number in 0..self.inputs.len() {
                let row_number = self.inputs[number];
                let row = &self.table.rows[row_number];
                let old = block.get(row_number);
                let value = if Some(row_number) == self.restart {
                    Some(Value::Bool(restarts))
                } else if is_first {
                    Some(row.start)
                } else if tries > 20 {
                    None
                } else {
                    self.change(stretch, row_number, old, begins)
                };
                // The defaults of inner blocks depend on the PLC project, so the tape sets all of them.
                let is_inner = row.is_inner();
                if let Some(value) = value.filter(|value| is_first && is_inner || old != Some(*value)) {
                    next.set(row_number, value);
                    changes.push((number, value));
                }
            }
            next.call();
            if self.outputs.iter().all(|row| next.get(*row).is_some_and(is_usual)) {
                return Some(Call { changes, block: next });
            }
        }
        // The block's memory itself is out of range, so only a restart helps.
        let restart = self.restart?;
        let mut next = block.clone();
        let changes = vec![(self.inputs.iter().position(|row| *row == restart)?, Value::Bool(true))];
        next.set(restart, Value::Bool(true));
        next.call();
        Some(Call { changes, block: next })
    }

    /// The outputs of type BOOL.
    fn switches(&self) -> impl Iterator<Item = usize> {
        self.outputs.iter().copied().filter(|row| self.table.rows[*row].kind == Kind::Bool)
    }

    /// Finds an input and a value at which outputs switch differently than at the neighbouring value, within `calls`
    /// calls and with nothing else changed: the block's threshold to within one unit in the last place. `None` if none
    /// is found.
    fn threshold<B: Block>(&mut self, stretch: &Stretch, block: &B, calls: usize) -> Option<(usize, Value)> {
        let switches: Vec<usize> = self.switches().collect();
        for _ in 0..16 {
            let number = self.random.below(self.inputs.len() as u64) as usize;
            let row_number = self.inputs[number];
            let row = &self.table.rows[row_number];
            if row.kind == Kind::Bool || row.role == Role::Cycle || row.role == Role::Fixed {
                continue;
            }
            let switched = |place: i64| -> Vec<bool> {
                let mut block = block.clone();
                block.set(row_number, value_at(row.kind, place));
                let after = |_| {
                    block.call();
                    switches.iter().map(|row| block.get(*row) == Some(Value::Bool(true))).collect::<Vec<bool>>()
                };
                (0..calls).flat_map(after).collect()
            };
            let (mut here, mut there) =
                (block.get(row_number).map_or(0, place_of), place_of(stretch.value(&mut self.random, row)));
            let first = switched(here);
            if first == switched(there) {
                continue;
            }
            while here.abs_diff(there) > 1 {
                let middle = here + (there - here) / 2;
                *if switched(middle) == first { &mut here } else { &mut there } = middle;
            }
            return Some((number, value_at(row.kind, if self.random.once_in(2) { here } else { there })));
        }
        None
    }

    /// Calls that start at a threshold, in which nothing else changes; empty if no threshold is found.
    fn at_threshold<B: Block>(&mut self, stretch: &Stretch, block: &B) -> Vec<Call<B>> {
        let calls = self.random.one_of(&[1, 5, 20, 60]);
        let mut all: Vec<Call<B>> = Vec::new();
        let Some((number, value)) = self.threshold(stretch, block, calls) else { return all };
        let mut changes = vec![(number, value)];
        let mut next = block.clone();
        next.set(self.inputs[number], value);
        if let Some(restart) = self.restart
            && block.get(restart) != Some(Value::Bool(false))
        {
            return all;
        }
        for _ in 0..calls {
            next.call();
            if !self.outputs.iter().all(|row| next.get(*row).is_some_and(is_usual)) {
                break;
            }
            all.push(Call { changes: std::mem::take(&mut changes), block: next.clone() });
        }
        all
    }

    /// The calls of one stretch: among several candidates, the one in which outputs of type BOOL switch most often per
    /// call. Empty if no candidate contains a call.
    fn stretch<B: Block>(&mut self, block: &B, is_first: bool) -> Vec<Call<B>> {
        let seeks = 2 * self.switches().count() >= self.outputs.len();
        let tries = self.random.one_of(&[1, 4, 12]);
        let mut best = (Vec::new(), 0);
        for _ in 0..tries {
            let stretch = Stretch::new(&mut self.random, self.table, block.cycle());
            let mut calls: Vec<Call<B>> = Vec::new();
            let mut switched = 0;
            while calls.len() < stretch.length {
                let before = calls.last().map_or(block, |call| &call.block);
                let begins = calls.is_empty();
                if seeks && !begins && self.random.once_in(THRESHOLD) {
                    let at = self.at_threshold(&stretch, before);
                    calls.extend(at);
                    continue;
                }
                let Some(call) = self.call(&stretch, before, begins, begins && is_first) else { break };
                switched += self.switches().filter(|row| call.block.get(*row) != before.get(*row)).count();
                calls.push(call);
            }
            let often = 1 + 1000 * switched / calls.len().max(1);
            if often > best.1 && !calls.is_empty() {
                best = (calls, often);
            }
        }
        best.0
    }
}

fn tape<B: Block>(calls: usize, seed: u32) -> Tape {
    let table = B::TABLE;
    let rows = || table.rows.iter().enumerate().filter(|(_, row)| row.kind != Kind::LReal);
    let inputs: Vec<usize> = rows().filter(|(_, row)| row.role.is_settable()).map(|(number, _)| number).collect();
    let outputs: Vec<usize> = rows().filter(|(_, row)| !row.role.is_settable()).map(|(number, _)| number).collect();
    let restart = restart_input::<B>(&inputs);
    let mut maker = Maker {
        random: Random::new(u64::from(seed)),
        table,
        inputs: inputs.clone(),
        outputs: outputs.clone(),
        restart,
    };
    let mut tape = Tape { table, inputs, outputs, entries: Vec::new(), calls: 0, seed };
    let mut expected = vec![0; tape.outputs.len()];
    let mut block = B::default();
    while tape.calls < calls {
        let made = maker.stretch(&block, tape.calls == 0);
        if made.is_empty() {
            break;
        }
        for call in made.into_iter().take(calls - tape.calls) {
            tape.push(&call, &mut expected);
            block = call.block;
        }
    }
    tape
}

impl Tape {
    /// Appends a call and the outputs that it changes.
    fn push<B: Block>(&mut self, call: &Call<B>, expected: &mut [u32]) {
        let first = self.entries.len();
        let entry = |what: usize, bits: u32| Entry { what: what as u8, is_last: false, bits };
        self.entries.extend(call.changes.iter().map(|(input, value)| entry(input + 1, bits(*value))));
        for (number, row) in self.outputs.iter().enumerate() {
            let value = call.block.get(*row).map_or(0, bits);
            if value != expected[number] {
                expected[number] = value;
                self.entries.push(entry(self.inputs.len() + number + 1, value));
            }
        }
        if self.entries.len() == first {
            self.entries.push(entry(0, 0));
        }
        if let Some(last) = self.entries.last_mut() {
            last.is_last = true;
        }
        self.calls += 1;
    }
}
