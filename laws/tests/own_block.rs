//! A user's own block is read like the built-in ones, and unsupported code is reported with its position.

use blocks::Law as _;
use laws::Sources;
use scl::ir::{Scalar, Value};
use scl::machine::{Code, Machine};
use std::sync::Arc;

mod counter;

fn sources() -> Sources {
    let mut sources = Sources::of_blocks();
    sources.add("my_block/src/lib.rs", include_str!("counter/mod.rs"));
    sources
}

#[test]
fn a_block_of_ones_own_gives_the_bits_of_rust() {
    let law = laws::read(&sources(), "COUNTER").unwrap_or_else(|error| panic!("{error}"));
    let mut machine = Machine::new(Arc::new(Code::compile(&law.program).unwrap()));
    let offset = |name: &str| law.program.find(&format!("COUNTER.{name}")).unwrap().0;
    let mut block = counter::Counter::default();
    assert_eq!(machine.get(Scalar::I16, offset("STEP")), Value::from(3_i16), "a start value");
    for call in 0..400_i32 {
        block.up = call % 7 < 5;
        block.step = (call % 11) as i16 - 2;
        block.weight = [0.5, f32::NAN, -2.0, 1e30][call as usize % 4];
        machine.set(block.up.into(), offset("UP"));
        machine.set(block.step.into(), offset("STEP"));
        machine.set(block.weight.into(), offset("WEIGHT"));
        if call % 100 == 99 {
            block.restart();
            machine.call(law.restart, 0).unwrap();
        }
        block.call();
        machine.call(law.call, 0).unwrap();
        assert_eq!(machine.get(Scalar::I16, offset("COUNT")), block.count.into(), "call {call}");
        let sum = machine.get(Scalar::F32, offset("SUM"));
        assert!(sum == block.sum.into() || sum.number().is_nan() && block.sum.is_nan(), "call {call}: {sum}");
        assert_eq!(machine.get(Scalar::Bool, offset("IS_DIFFERENT")), block.is_different.into(), "call {call}");
        assert_eq!(machine.get(Scalar::I32, offset("memory.whole")), Value::from(block.memory.whole), "call {call}");
    }
}

#[test]
fn what_cannot_be_read_is_told_with_its_place() {
    let cases = [
        ("self.count += 1;", "self.count += self.up.len();", "len of bool is not supported"),
        ("self.count += 1;", "self.count = 1.5;", "expected i16, found a floating-point number"),
        ("self.count += 1;", "println!();", "this statement is not supported"),
        ("self.count += 1;", "let open = 2.0;", "the type of open is ambiguous"),
        ("self.count += 1;", "for i in 0..3 {}", "this statement is not supported"),
        ("self.count += 1;", "self.other += 1;", "no field other"),
        ("self.count += 1;", "self.call();", "a law must not call itself"),
    ];
    for (from, to, message) in cases {
        let text = include_str!("counter/mod.rs");
        assert_eq!(text.matches(from).count(), 1);
        let line = text.lines().position(|line| line.contains(from)).unwrap() + 1;
        let mut sources = Sources::of_blocks();
        sources.add("my_block/src/lib.rs", text.replace(from, to));
        let error = laws::read(&sources, "COUNTER").expect_err(to);
        assert!(error.message.contains(message), "{to}: {error}");
        // A recursive law is reported at its beginning.
        let place = (error.file.as_str(), error.line);
        assert!(place == ("my_block/src/lib.rs", line) || to == "self.call();", "{to}: {error}");
        assert!(error.column > 1, "{error}");
    }
}

/// The library's statements about Rust's numbers.
mod library {
    #![allow(dead_code)]
    use blocks::{LReal, Real};
    include!("../src/library.rs");
}

#[test]
fn the_library_does_what_rust_does() {
    let reals = [
        0.0_f32,
        -0.0,
        1.0,
        -1.5,
        2.5,
        0.5,
        1e-45,
        f32::MAX,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        3e9,
        -3e9,
        2_147_483_648.0,
    ];
    let same = |a: f32, b: f32| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan() || a == 0.0 && b == 0.0;
    let integers = [0, 1, -1, 7, i32::MIN, i32::MAX, i32::MIN + 1, 1 << 30, -(1 << 30) - 1];
    for a in reals {
        for b in reals {
            assert!(same(library::max_real(a, b), a.max(b)), "{a} max {b}");
            assert!(same(library::min_real(a, b), a.min(b)), "{a} min {b}");
            let (wide, other) = (f64::from(a), f64::from(b));
            assert!(same(library::max_lreal(wide, other) as f32, a.max(b)), "{a} max {b}");
            assert!(same(library::min_lreal(wide, other) as f32, a.min(b)), "{a} min {b}");
        }
        assert_eq!(library::rnd(a), blocks::rnd(a), "rnd({a})");
    }
    for a in integers {
        for b in integers {
            assert_eq!(library::sub_saturating(a, b), a.saturating_sub(b), "{a} - {b}");
            assert_eq!(library::add_saturating(a, b), a.saturating_add(b), "{a} + {b}");
        }
        assert_eq!(library::sign(a), a.signum(), "{a}");
    }
}
