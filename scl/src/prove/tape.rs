//! What a block is given in each call, and what it must give.

use blocks::{Block, EachBlock, Kind, Role, Row, Table, Time, Value, Word, for_each_block};

/// The most calls of a tape.
pub const MOST_CALLS: usize = 1_000_000;

/// A change on the tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// From 1: the input, or behind all inputs the output; 0 for a call in which nothing changes.
    pub what: u8,
    /// It is the last one before its call.
    pub is_last: bool,
    /// The bits of the value.
    pub bits: u32,
}

/// What a block is given in each call, and what it must give.
#[derive(Clone, Debug)]
pub struct Tape {
    /// The block.
    pub table: &'static Table,
    /// The rows that are set, in the order of the table.
    pub inputs: Vec<usize>,
    /// The rows that are compared.
    pub outputs: Vec<usize>,
    /// The changes, call by call.
    pub entries: Vec<Entry>,
    /// The number of calls.
    pub calls: usize,
    /// What the random numbers began with.
    pub seed: u32,
}

/// Random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    fn below(&mut self, count: u64) -> u64 {
        (self.next() >> 11) % count
    }

    /// Once in so many.
    fn once_in(&mut self, count: u64) -> bool {
        self.below(count) == 0
    }

    fn real(&mut self, most: f32) -> f32 {
        (self.below(1 << 24) as f32 / (1 << 23) as f32 - 1.0) * most
    }

    /// A value for a row: mostly a usual one, now and then one at an end of its range.
    fn value(&mut self, row: &Row) -> Value {
        match row.kind {
            Kind::Bool => Value::Bool(self.once_in(2)),
            // Without time between two calls, or without calls, nothing is defined.
            Kind::Time if row.role == Role::Cycle => Value::Time(Time::ms(1 + self.below(2000) as i32)),
            Kind::Int if row.role == Role::Fixed => Value::Int(1 + self.below(50) as i16),
            Kind::Time => Value::Time(Time::ms(match self.below(6) {
                0 => self.below(2) as i32,
                1 | 2 => 10 * (1 + self.below(50) as i32),
                3 => 1 + self.below(600_000) as i32,
                _ => 1 + self.below(20_000) as i32,
            })),
            Kind::Word => Value::Word(Word::new(match self.below(4) {
                0 => [i16::MIN, i16::MAX, 0, 27648][self.below(4) as usize],
                _ => self.next() as i16,
            })),
            Kind::Int => Value::Int(match self.below(8) {
                0 => [i16::MIN, i16::MAX, -1, 0][self.below(4) as usize],
                1 => self.next() as i16,
                _ => self.below(200) as i16,
            }),
            _ => Value::Real(match self.below(12) {
                0 => self.real(1e6),
                1 => [0.0, 1.0, 100.0, -100.0][self.below(4) as usize],
                2..=4 => self.real(5.0),
                _ => self.real(120.0),
            }),
        }
    }
}

/// The bits of a value as a DWORD.
pub(super) fn bits(value: Value) -> u32 {
    match value {
        Value::Word(word) => u32::from(word.value() as u16),
        // A REAL that is not a number is not on a tape.
        value => match value.kind() {
            Kind::Int => crate::program::Value::of_plc(value).bits() as u16 as u32,
            _ => crate::program::Value::of_plc(value).bits() as u32,
        },
    }
}

/// Whether a PLC calculates with such a value as we do: no infinity, and none below the normal range, which some CPUs flush.
fn is_usual(value: Value) -> bool {
    !matches!(value, Value::Real(real) if !real.is_finite() || real.is_subnormal())
}

impl Tape {
    /// A tape for the block of this name, or of one of its other names; `None` if there is none.
    pub fn of(name: &str, calls: usize, seed: u32) -> Option<Tape> {
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

    /// The inputs in a call, from 1 on, in words.
    pub fn inputs_of(&self, call: usize) -> Vec<(String, String)> {
        let mut values: Vec<u32> = self.inputs.iter().map(|row| bits(self.table.rows[*row].start)).collect();
        let mut made = 0;
        for entry in &self.entries {
            // Calls count from 1.
            if made == call {
                break;
            }
            if let Some(value) = usize::from(entry.what).checked_sub(1).and_then(|input| values.get_mut(input)) {
                *value = entry.bits;
            }
            made += usize::from(entry.is_last);
        }
        let rows = self.inputs.iter().map(|row| &self.table.rows[*row]);
        rows.zip(values).map(|(row, bits)| (row.full_name(), super::outcome::value_text(row.kind, bits))).collect()
    }

    /// A number that two different tapes hardly have in common.
    pub fn fingerprint(&self) -> u32 {
        // FNV-1a.
        let bytes = self.entries.iter().flat_map(|entry| {
            let head = [entry.what, u8::from(entry.is_last)];
            head.into_iter().chain(entry.bits.to_be_bytes())
        });
        bytes.fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
    }
}

/// The input that restarts the block, if it has one: a call with it is the restart.
fn restart_input<B: Block>(inputs: &[usize]) -> Option<usize> {
    let table = B::TABLE;
    let mut random = Random(1);
    let switches = inputs.iter().copied().filter(|row| table.rows[*row].kind == Kind::Bool);
    let mut switches: Vec<usize> = switches.filter(|row| table.rows[*row].start == Value::Bool(false)).collect();
    for _ in 0..20 {
        let mut block = B::default();
        for row in inputs.iter().filter(|row| table.rows[**row].kind != Kind::Bool) {
            block.set(*row, random.value(&table.rows[*row]));
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

fn tape<B: Block>(calls: usize, seed: u32) -> Tape {
    let table = B::TABLE;
    let rows = || table.rows.iter().enumerate().filter(|(_, row)| row.kind != Kind::LReal);
    let inputs: Vec<usize> = rows().filter(|(_, row)| row.role.is_settable()).map(|(number, _)| number).collect();
    let outputs: Vec<usize> = rows().filter(|(_, row)| row.role == Role::Output).map(|(number, _)| number).collect();
    let results: Vec<usize> = rows().filter(|(_, row)| !row.role.is_settable()).map(|(number, _)| number).collect();
    let restart = restart_input::<B>(&inputs);
    let mut tape = Tape { table, inputs, outputs, entries: Vec::new(), calls, seed };
    let mut random = Random(u64::from(seed));
    let mut block = B::default();
    let mut expected = vec![0; tape.outputs.len()];
    // Where the present stretch ends, and how often its signals change.
    let (mut end, mut pace) = (0, 1);
    for call in 0..calls {
        let mut next;
        let mut changes;
        let begins = call == end;
        if begins {
            end = call + 20 + random.below(180) as usize;
            pace = [1, 3, 10, 40][random.below(4) as usize];
        }
        let mut tries = 0;
        // Values with which the law gives infinity, or what a CPU may flush to 0, are not used.
        loop {
            next = block.clone();
            changes = Vec::new();
            for (number, row_number) in tape.inputs.iter().enumerate() {
                let row = &table.rows[*row_number];
                let value = if Some(*row_number) == restart {
                    Some(Value::Bool(call == 0 || random.once_in(200)))
                } else if call == 0 {
                    Some(row.start)
                } else if tries > 20 {
                    None
                } else if begins {
                    // A third of the settings is that of a new block.
                    random.once_in(2).then(|| if random.once_in(3) { row.start } else { random.value(row) })
                } else {
                    let often = if row.role == Role::Input && row.kind != Kind::Bool { pace } else { 150 };
                    random.once_in(often).then(|| random.value(row))
                };
                // What a block inside starts with is up to the PLC's project: the tape sets all of it.
                let is_inner = !row.path[0].is_empty();
                let value = value.filter(|value| call == 0 && is_inner || block.get(*row_number) != Some(*value));
                if let Some(value) = value {
                    next.set(*row_number, value);
                    changes.push((number, value));
                }
            }
            next.call();
            let is_good = results.iter().all(|row| next.get(*row).is_some_and(is_usual));
            tries += 1;
            if is_good || tries > 40 {
                break;
            }
        }
        if tries > 40 {
            // The memory itself has gone astray: only a new block helps, which is what the restart is.
            let Some(restart) = restart else { break };
            next = block.clone();
            changes = vec![(tape.inputs.iter().position(|row| *row == restart).unwrap_or(0), Value::Bool(true))];
            next.set(restart, Value::Bool(true));
            next.call();
        }
        let first = tape.entries.len();
        let entry = |what: usize, bits: u32| Entry { what: what as u8, is_last: false, bits };
        tape.entries.extend(changes.iter().map(|(input, value)| entry(input + 1, bits(*value))));
        for (number, row) in tape.outputs.iter().enumerate() {
            let value = next.get(*row).map_or(0, bits);
            if value != expected[number] {
                expected[number] = value;
                tape.entries.push(entry(tape.inputs.len() + number + 1, value));
            }
        }
        if tape.entries.len() == first {
            tape.entries.push(entry(0, 0));
        }
        if let Some(last) = tape.entries.last_mut() {
            last.is_last = true;
        }
        block = next;
        tape.calls = call + 1;
    }
    tape
}
