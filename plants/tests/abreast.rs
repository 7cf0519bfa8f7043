//! Blocks side by side compute what each computes alone, bit for bit: all blocks and plants, with any values.

#![allow(clippy::unwrap_used)]

use blocks::table::abreast::{Abreast, EachInLanes, InLanes, LANES, Lanes};
use blocks::table::number;
use blocks::{Block, EachBlock, Kind, Role, StaticRow, Value};

/// How many calls each block makes.
const CALLS: usize = 300;

/// Numbers without a pattern, the same in each run of the test (SplitMix64).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// Whether something happens that happens once in `every` times.
    fn once_in(&mut self, every: u64) -> bool {
        self.bits().is_multiple_of(every)
    }

    /// From 0 to 1.
    fn part(&mut self) -> f64 {
        self.bits() as f64 / u64::MAX as f64
    }

    /// A value for a row: around its start, where it has room, and not outside of what the row takes.
    fn value(&mut self, row: &StaticRow) -> f64 {
        let limit = |limit: Option<Value>, none: f64| limit.map_or(none, number::number);
        let start = number::number(row.start);
        let value = match row.kind {
            Kind::Bool => f64::from(u8::from(self.once_in(3))),
            Kind::Word | Kind::Int => (self.part() * 20_000.0).round() - 2_000.0,
            Kind::Time => start * (0.5 + self.part()),
            _ if self.once_in(8) => 0.0,
            _ => start * (0.5 + self.part()) + 100.0 * (self.part() - 0.4),
        };
        value.max(limit(row.min, f64::NEG_INFINITY)).min(limit(row.max, f64::INFINITY))
    }
}

/// Compares each block.
struct Compared {
    random: Random,
    names: Vec<&'static str>,
}

impl EachBlock for Compared {
    fn block<B: Block>(&mut self) {
        self.compare_groups::<B, Vec<B>>();
    }
}

impl EachInLanes for Compared {
    fn block<B: InLanes>(&mut self) {
        self.compare_groups::<B, Lanes<B>>();
    }
}

impl Compared {
    fn compare_groups<B: Block, G: Abreast<B>>(&mut self) {
        for count in [LANES, 5, 1] {
            self.compare::<B, G>(count);
        }
        self.names.push(B::TABLE.name);
    }

    fn compare<B: Block, G: Abreast<B>>(&mut self, count: usize) {
        let random = &mut self.random;
        let is_own = |row: &StaticRow| !row.is_inner() && matches!(row.role, Role::Input | Role::Parameter);
        let own: Vec<usize> =
            (0..B::TABLE.rows.len()).filter(|row| is_own(&B::TABLE.rows[*row]) && G::writer(*row).is_some()).collect();
        let mut alone: Vec<B> = (0..count).map(|_| B::default()).collect();
        for block in &mut alone {
            for row in &own {
                // Most stand as they start, so that the block is not always in an odd mode.
                if random.once_in(3) {
                    let value = random.value(&B::TABLE.rows[*row]);
                    block.set(*row, number::to_value(value, B::TABLE.rows[*row].kind).unwrap());
                }
            }
            block.restart();
        }
        let mut abreast = G::from_blocks(alone.clone());
        for call in 0..CALLS {
            // Inputs that move, as connected ones do, and now and then a setting or a switch.
            for row in &own {
                let table = &B::TABLE.rows[*row];
                if !random.once_in(if table.role == Role::Input && table.kind != Kind::Bool { 2 } else { 100 }) {
                    continue;
                }
                let read = G::reader(*row).unwrap();
                let mut values = vec![0.0; count];
                read(&abreast, &mut values);
                for value in &mut values {
                    if random.once_in(2) {
                        *value = random.value(table);
                    }
                }
                assert!(G::writer(*row).unwrap()(&mut abreast, &values), "{} {}", B::TABLE.name, table.name);
                for (block, value) in alone.iter_mut().zip(&values) {
                    block.set(*row, number::to_value(*value, table.kind).unwrap());
                }
            }
            abreast.each(B::call);
            alone.iter_mut().for_each(B::call);
            for row in (0..B::TABLE.rows.len()).filter(|row| G::reader(*row).is_some()) {
                let mut values = vec![0.0; count];
                G::reader(row).unwrap()(&abreast, &mut values);
                for (lane, (block, value)) in alone.iter().zip(values).enumerate() {
                    let expected = number::number(block.get(row).unwrap());
                    // Of what is not a number, the bits may differ: they depend on the order of operands.
                    let is_same = expected.to_bits() == value.to_bits() || expected.is_nan() && value.is_nan();
                    let name = B::TABLE.rows[row].name;
                    assert!(is_same, "{} {name}, lane {lane}, call {call}: {value} for {expected}", B::TABLE.name);
                }
            }
        }
        for (block, other) in abreast.into_blocks().into_iter().zip(alone) {
            let (mut one, mut two) = (Vec::new(), Vec::new());
            block.write(&mut one);
            other.write(&mut two);
            assert_eq!(one, two, "{}: what is kept from call to call", B::TABLE.name);
        }
    }
}

#[test]
fn blocks_side_by_side_compute_what_each_computes_alone() {
    let mut compared = Compared { random: Random(1), names: Vec::new() };
    blocks::for_each_block(&mut compared);
    plants::for_each_plant(&mut compared);
    assert!(compared.names.len() >= 12);
    compared.names.clear();
    blocks::for_each_in_lanes(&mut compared);
    plants::for_each_in_lanes(&mut compared);
    assert_eq!(compared.names, ["CONT_C", "HEATER", "PROCESS"]);
}
