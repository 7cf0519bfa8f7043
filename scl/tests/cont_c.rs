//! CONT_C written in SCL (`data/cont_c.scl`) has the same bits as its law in `blocks`, which was written independently
//! in another language.

#![allow(clippy::unwrap_used)]

use blocks::{Block, ContC, Kind, Law, Role, StaticRow, Time, Value, Word};
use parameters::Source;
use scl::ir::{Program, Scalar, Type};
use scl::machine::{Code, Machine};
use scl::random::Random;
use scl::{Options, compile};
use std::sync::Arc;

/// Returns the total number of calls; `PLCFMU_CALLS=1000000` makes a million.
fn calls() -> usize {
    std::env::var("PLCFMU_CALLS").map_or(if cfg!(debug_assertions) { 100_000 } else { 1_000_000 }, |calls| {
        calls.parse().expect("PLCFMU_CALLS is a number")
    })
}

/// The controller in SCL.
struct Controller {
    machine: Machine,
    cycle: usize,
    /// The type and offset of the variable of each row in the table.
    rows: Vec<(Scalar, usize)>,
}

impl Controller {
    fn new() -> Controller {
        let source = Source::new("cont_c.scl", include_bytes!("data/cont_c.scl").to_vec());
        let compiled = compile(&[source], &Options::default()).unwrap_or_else(|errors| panic!("{}", errors[0]));
        let root = compiled.root.expect("cont_c.scl has a block");
        let rows = ContC::TABLE.rows.iter().map(|row| place(&compiled.program, &root.instance, row)).collect();
        let code = Code::compile(&compiled.program).expect("what is translated fits together");
        Controller { machine: Machine::new(Arc::new(code)), cycle: root.cycle, rows }
    }

    fn set(&mut self, row: usize, value: Value) {
        let (ty, offset) = self.rows[row];
        self.machine.set(scl::ir::Value::new(ty, bits(value)), offset);
    }

    fn get(&self, row: usize) -> u64 {
        let (ty, offset) = self.rows[row];
        self.machine.get(ty, offset).bits()
    }
}

fn place(program: &Program, instance: &str, row: &StaticRow) -> (Scalar, usize) {
    match program.find(&format!("{instance}.{}", row.name)) {
        Some((offset, Type::Scalar(ty))) => (ty, offset),
        _ => panic!("cont_c.scl has no {}", row.name),
    }
}

/// Returns the bits of a value as stored in the machine; all NaNs have the same bits.
fn bits(value: Value) -> u64 {
    match value {
        Value::Real(real) if real.is_nan() => u64::from(f32::NAN.to_bits()),
        value => scl::ir::Value::of_plc(value).bits(),
    }
}

/// Generates a value for a row: usually a typical one, sometimes one that no loop has.
fn value(random: &mut Random, row: &StaticRow) -> Value {
    match row.kind {
        Kind::Bool => Value::Bool(random.below(2) == 1),
        Kind::Time => Value::Time(Time::ms(match random.below(4) {
            0 => 1 + random.below(1000) as i32,
            1 => random.below(2) as i32,
            _ => 1 + random.below(100_000) as i32,
        })),
        Kind::Word => Value::Word(Word::new(random.bits() as i16)),
        Kind::Int => Value::Int(random.bits() as i16),
        Kind::LReal => Value::LReal(f64::from(random.real(100.0))),
        _ => Value::Real(match random.below(16) {
            0 => random.real(1e12),
            1 => [0.0, -0.0, 1e-30, 100.0][random.below(4) as usize],
            _ => random.real(150.0),
        }),
    }
}

/// Makes calls with some switches usually opposite to their start value, and compares all outputs.
fn compare(controller: &mut Controller, random: &mut Random, switches: &[usize], calls: usize) {
    let table = ContC::TABLE;
    let mut block = ContC::default();
    controller.machine.restart();
    for (index, row) in table.rows.iter().enumerate() {
        assert_eq!(controller.get(index), bits(row.start), "start value of {}", row.name);
    }
    let is_switch = |row: &StaticRow| row.kind == Kind::Bool && row.role.is_settable();
    for call in 0..calls {
        for (index, row) in table.rows.iter().enumerate() {
            let changes = match row.role {
                _ if row.name == "COM_RST" => call % 97 == 96 || call % 97 == 0,
                _ if !row.role.is_settable() || is_switch(row) && !switches.contains(&index) => false,
                // A switch is usually inverted, and most values stay as they were in the previous call.
                _ => random.below(if row.role == Role::Input { 3 } else { 40 }) == 0 || call == 0,
            };
            if changes {
                let value = match row.start {
                    _ if row.name == "COM_RST" => Value::Bool(call % 97 == 96),
                    Value::Bool(start) => Value::Bool(start == (random.below(8) == 0)),
                    _ => value(random, row),
                };
                block.set(index, value);
                controller.set(index, value);
            }
        }
        block.call();
        controller.machine.call(controller.cycle, 0).expect("nothing stops");
        for (index, row) in table.rows.iter().enumerate().filter(|(_, row)| !row.role.is_settable()) {
            let (law, mut scl) = (block.get(index).unwrap(), controller.get(index));
            if row.kind == Kind::Real && f32::from_bits(scl as u32).is_nan() {
                scl = u64::from(f32::NAN.to_bits());
            }
            assert_eq!(
                scl,
                bits(law),
                "{} in call {call} with {switches:?} is {law:?} by the law: {block:?}",
                row.name
            );
        }
    }
}

#[test]
fn the_law_in_scl_gives_the_bits_of_the_law_in_rust_with_every_switch() {
    let table = ContC::TABLE;
    let manual = table.find("MAN_ON").unwrap();
    let switches = table.rows.iter().enumerate().filter(|(_, row)| row.kind == Kind::Bool && row.role.is_settable());
    let mut runs = vec![vec![], vec![manual]];
    // Each switch in manual mode, in which the block starts, and in automatic mode.
    runs.extend(switches.flat_map(|(index, _)| [vec![index], vec![index, manual]]));
    let mut random = Random::new(41);
    let mut controller = Controller::new();
    let calls = calls() / runs.len() + 1;
    for switches in runs {
        compare(&mut controller, &mut random, &switches, calls);
    }
}
