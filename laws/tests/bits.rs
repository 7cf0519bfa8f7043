//! The laws as typed programs have the same bits as the laws in Rust, call by call, with typical and extreme values.

#![allow(clippy::unwrap_used)]

use blocks::{Block, EachBlock, Kind, StaticRow, Time, Value, Word, for_each_block};
use laws::{Law, Sources};
use scl::Dialect;
use scl::ir::{Program, Scalar, Type};
use scl::machine::{Code, Machine};
use scl::random::Random;
use std::sync::Arc;

/// Returns the number of calls of each block; `PLCFMU_CALLS=1000000` makes a million.
fn calls() -> usize {
    std::env::var("PLCFMU_CALLS").map_or(20_000, |calls| calls.parse().expect("PLCFMU_CALLS is a number"))
}

/// Generates a value for a row: a typical one or, if `odd`, any bits of the type.
fn value(random: &mut Random, row: &StaticRow, odd: bool) -> Value {
    const ODD: [f32; 10] = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        -0.0,
        1e-45,
        -1e-40,
        f32::MAX,
        f32::MIN,
        2_147_483_648.0,
        16_777_217.0,
    ];
    let odd = odd && random.below(6) == 0;
    match row.kind {
        Kind::Bool => Value::Bool(random.below(2) == 1),
        Kind::Time if odd => Value::Time(Time::ms(random.bits() as i32)),
        Kind::Time => Value::Time(Time::ms(match random.below(4) {
            0 => random.below(3) as i32,
            1 => 10 * random.below(30) as i32,
            _ => 1 + random.below(20_000) as i32,
        })),
        Kind::Word => Value::Word(Word::new(random.bits() as i16)),
        Kind::Int if odd => Value::Int([i16::MIN, i16::MAX, -1, 0][random.below(4) as usize]),
        Kind::Int => Value::Int(random.below(41) as i16 - 10),
        Kind::LReal => Value::LReal(f64::from(random.real(100.0))),
        _ if odd => Value::Real(ODD[random.below(10) as usize]),
        _ => Value::Real(match random.below(5) {
            0 => [0.0, 1.0, 100.0, -100.0, 0.5][random.below(5) as usize],
            1 => random.real(1e6),
            _ => random.real(150.0),
        }),
    }
}

/// Collects the bytes of a variable without padding, as a block stores itself; all NaNs are mapped to the same bits.
fn stored(program: &Program, ty: &Type, bytes: &[u8], into: &mut Vec<u8>) {
    match ty {
        Type::Scalar(ty) => {
            let value = scl::ir::Value::read(*ty, bytes);
            let nan = match ty {
                Scalar::F32 => scl::ir::Value::from(f32::NAN),
                Scalar::F64 => scl::ir::Value::from(f64::NAN),
                _ => value,
            };
            let value = if ty.is_float() && value.number().is_nan() { nan } else { value };
            let mut own = [0; 8];
            value.write(&mut own);
            into.extend(&own[..ty.size()]);
        }
        Type::Record(record) => {
            for member in &program.records[*record].members {
                stored(program, &member.ty, &bytes[member.offset..], into);
            }
        }
        other => panic!("{other:?}"),
    }
}

/// Like [`stored`], but for a block: its own bytes, read in the layout of the law.
fn stored_block(program: &Program, ty: &Type, bytes: &mut &[u8], into: &mut Vec<u8>) {
    match ty {
        Type::Scalar(scalar) => {
            stored(program, ty, bytes, into);
            *bytes = &bytes[scalar.size()..];
        }
        Type::Record(record) => {
            for member in &program.records[*record].members {
                stored_block(program, &member.ty, bytes, into);
            }
        }
        other => panic!("{other:?}"),
    }
}

/// Returns the type and offset of a table row.
fn place(law: &Law, row: &StaticRow) -> (Scalar, usize) {
    let path = format!("{}.{}", law.name, row.name);
    match law.program.find(&path) {
        Some((offset, Type::Scalar(ty))) => (ty, offset),
        other => panic!("{path}: {other:?}"),
    }
}

struct Compare(Vec<String>);

impl EachBlock for Compare {
    fn block<B: Block>(&mut self) {
        let law = laws::read(&Sources::of_blocks(), B::TABLE.name).unwrap_or_else(|error| panic!("{error}"));
        compare::<B>(&law, calls());
        self.0.push(law.name);
    }
}

fn compare<B: Block>(law: &Law, calls: usize) {
    let rows = B::TABLE.rows;
    let places: Vec<_> = rows.iter().map(|row| place(law, row)).collect();
    let code = Code::compile(&law.program).unwrap_or_else(|error| panic!("{error}"));
    let mut machine = Machine::new(Arc::new(code));
    let mut random = Random::new(B::TABLE.name.len() as u64);
    let mut block = B::default();
    let is_kept = |row: &StaticRow| !row.role.is_settable();
    let whole = Type::Record(law.record);
    let mut restarts = 0;
    for call in 0..calls {
        // Calls with typical values and calls with extreme ones alternate in sections; each section begins with a new
        // block.
        if call % 1000 == 0 {
            block = B::default();
            machine.restart();
        }
        let odd = call / 1000 % 2 == 1;
        for (row, (ty, offset)) in rows.iter().zip(&places).filter(|(row, _)| !is_kept(row)) {
            if call % 1000 == 0 || random.below(12) == 0 {
                let index = rows.iter().position(|it| std::ptr::eq(it, row)).unwrap();
                // Restarts are rare.
                let value = match row.kind {
                    Kind::Bool if row.name.ends_with("COM_RST") => Value::Bool(random.below(20) == 0),
                    _ => value(&mut random, row, odd),
                };
                block.set(index, value);
                machine.set(scl::ir::Value::new(*ty, scl::ir::Value::of_plc(value).bits()), *offset);
            }
        }
        if call % 1000 == 0 || random.below(200) == 0 {
            restarts += 1;
            block.restart();
            machine.call(law.restart, 0).unwrap();
        }
        block.call();
        machine.call(law.call, 0).unwrap();
        let (mut expected, mut found, mut own) = (Vec::new(), Vec::new(), Vec::new());
        block.write(&mut own);
        stored_block(&law.program, &whole, &mut &own[..], &mut expected);
        stored(&law.program, &whole, machine.state(), &mut found);
        if expected != found {
            let differ = |(row, (ty, offset)): (&StaticRow, &(Scalar, usize))| {
                let index = rows.iter().position(|it| std::ptr::eq(it, row)).unwrap();
                let (law, rust) = (machine.get(*ty, *offset), block.get(index).unwrap());
                let rust = scl::ir::Value::of_plc(rust);
                let both_nan = law.number().is_nan() && rust.number().is_nan();
                (law != rust && !both_nan).then(|| format!("{} is {law}, in Rust {rust}", row.name))
            };
            let differ: Vec<String> = rows.iter().zip(&places).filter_map(differ).collect();
            panic!("{} differs in call {call}: {differ:?}\n{found:?}\n{expected:?}", law.name);
        }
        if B::TABLE.mean.is_some() {
            let (offset, _) = law.program.find("pulse").unwrap();
            assert_eq!(machine.get(Scalar::I32, offset), block.pulse().into(), "pulse of {} in call {call}", law.name);
        }
    }
    assert!(restarts > calls / 1000, "{restarts} restarts");
}

#[test]
fn laws_give_the_bits_of_rust_with_usual_and_odd_values() {
    let mut compare = Compare(Vec::new());
    for_each_block(&mut compare);
    assert!(compare.0.len() >= 5, "{:?}", compare.0);
}

struct CompareScl(Dialect);

impl EachBlock for CompareScl {
    fn block<B: Block>(&mut self) {
        compare_scl::<B>(self.0, calls());
    }
}

/// Compares a law, printed as SCL and parsed again, with the block.
fn compare_scl<B: Block>(dialect: Dialect, calls: usize) {
    // The mean of a pulse is for the host of an FMU; a PLC does not have it.
    let is_mean = |row: &StaticRow| row.kind == Kind::LReal;
    let rows: Vec<(usize, &StaticRow)> = B::TABLE.rows.iter().enumerate().filter(|(_, row)| !is_mean(row)).collect();
    let law = laws::read(&Sources::of_blocks(), B::TABLE.name).unwrap_or_else(|error| panic!("{error}"));
    let text = law.scl(dialect).unwrap_or_else(|error| panic!("{}: {error}", law.name));
    assert_eq!(text.contains('#') && text.contains("S7_Optimized_Access"), dialect == Dialect::Tia);
    // The start values of inner blocks are in a data block.
    let data_block = format!("{}_DB", law.name);
    let block = if text.contains(&format!("DATA_BLOCK \"{data_block}\"")) { data_block } else { law.name.clone() };
    let cpu = Some(if dialect == Dialect::Tia { scl::Cpu::S71500 } else { scl::Cpu::S7300 });
    let options = scl::Options { cpu, block: Some(block), ..scl::Options::default() };
    let compiled = scl::compile(&[parameters::Source::new("law.scl", text.clone().into_bytes())], &options)
        .unwrap_or_else(|errors| panic!("{}\n{text}", errors[0]));
    let root = compiled.root.unwrap();
    let path = |row: &StaticRow| format!("{}.{}", root.instance, row.name);
    let places: Vec<(Scalar, usize)> = rows
        .iter()
        .map(|(_, row)| match compiled.program.find(&path(row)) {
            Some((offset, Type::Scalar(ty))) => (ty, offset),
            other => panic!("{}: {other:?}\n{text}", path(row)),
        })
        .collect();
    let mut machine = Machine::new(Arc::new(Code::compile(&compiled.program).unwrap()));
    let mut random = Random::new(B::TABLE.name.len() as u64 + 100);
    let mut block = B::default();
    for ((index, row), (ty, offset)) in rows.iter().zip(&places) {
        let start = scl::ir::Value::of_plc(block.get(*index).unwrap());
        assert_eq!(machine.get(*ty, *offset), start, "start of {} in SCL", row.name);
    }
    for call in 0..calls {
        if call % 1000 == 0 {
            block = B::default();
            machine.restart();
        }
        let odd = call / 1000 % 2 == 1;
        for ((index, row), (ty, offset)) in rows.iter().zip(&places) {
            if row.role.is_settable() && (call % 1000 == 0 || random.below(12) == 0) {
                let value = match row.kind {
                    Kind::Bool if row.name.ends_with("COM_RST") => Value::Bool(random.below(20) == 0),
                    _ => value(&mut random, row, odd),
                };
                block.set(*index, value);
                machine.set(scl::ir::Value::new(*ty, scl::ir::Value::of_plc(value).bits()), *offset);
            }
        }
        block.call();
        machine.call(root.cycle, 0).unwrap();
        for ((index, row), (ty, offset)) in rows.iter().zip(&places) {
            let (found, expected) = (machine.get(*ty, *offset), scl::ir::Value::of_plc(block.get(*index).unwrap()));
            let both_nan = found.number().is_nan() && expected.number().is_nan();
            assert!(
                found == expected || both_nan,
                "{} in call {call} is {found} in {dialect:?} SCL, {expected} in Rust\n{text}",
                row.name
            );
        }
    }
}

#[test]
fn laws_printed_as_scl_and_read_again_give_the_bits_of_rust() {
    for dialect in [Dialect::Tia, Dialect::Step7] {
        for_each_block(&mut CompareScl(dialect));
    }
}

#[test]
fn start_values_are_those_of_the_table() {
    struct Starts;
    impl EachBlock for Starts {
        fn block<B: Block>(&mut self) {
            let law = laws::read(&Sources::of_blocks(), B::TABLE.name).unwrap();
            let (mut expected, mut found, mut own) = (Vec::new(), Vec::new(), Vec::new());
            B::default().write(&mut own);
            let ty = Type::Record(law.record);
            stored_block(&law.program, &ty, &mut &own[..], &mut expected);
            stored(&law.program, &ty, &law.program.records[law.record].start, &mut found);
            assert_eq!(found, expected, "{}", law.name);
        }
    }
    for_each_block(&mut Starts);
}
