//! The speed of the machine: nanoseconds per operation, and the time of a call of CONT_C in SCL as a multiple of its
//! law in Rust, both measured alternately in one run.
//!
//! `cargo bench -p scl`

use blocks::{ContC, Law};
use parameters::Source;
use scl::machine::{Code, Machine};
use scl::{Options, compile};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// Ten operations per run: five additions and five multiplications.
const OPERATIONS: &str = "FUNCTION_BLOCK B VAR_INPUT x : TYPE; END_VAR VAR_OUTPUT y : TYPE; END_VAR
    VAR_TEMP a : TYPE; n : INT; END_VAR
    BEGIN
        a := x;
        FOR n := 1 TO 1000 DO
            a := (((((a + x) * x + x) * x + x) * x + x) * x + x) * x;
        END_FOR;
        y := a;
    END_FUNCTION_BLOCK";

/// Creates a machine for a source, and returns it with the function of a cycle and a lookup of member offsets.
fn machine(name: &str, text: &str) -> (Machine, usize, impl Fn(&str) -> usize + use<>) {
    let compiled = compile(&[Source::new(name, text.into())], &Options::default()).expect("the source has no error");
    let root = compiled.root.expect("the source has a block");
    let code = Code::compile(&compiled.program).expect("what is translated fits together");
    let offset = move |member: &str| compiled.program.find(&format!("{}.{member}", root.instance)).expect("a member").0;
    (Machine::new(Arc::new(code)), root.cycle, offset)
}

/// Returns the minimum time per run in nanoseconds, over this many rounds with this many runs.
fn least(rounds: usize, runs: usize, mut run: impl FnMut()) -> f64 {
    let round = |_| {
        let start = Instant::now();
        (0..runs).for_each(|_| run());
        start.elapsed().as_nanos() as f64 / runs as f64
    };
    (0..rounds).map(round).fold(f64::INFINITY, f64::min)
}

fn main() {
    for ty in ["REAL", "LREAL", "INT", "DINT"] {
        let (mut machine, cycle, offset) = machine("operations.scl", &OPERATIONS.replace("TYPE", ty));
        let x = offset("x");
        if ty.ends_with("REAL") {
            // A number whose powers neither underflow nor overflow.
            match ty {
                "REAL" => machine.set(0.5_f32.into(), x),
                _ => machine.set(0.5_f64.into(), x),
            }
        }
        let time = least(20, 20, || machine.call(cycle, 0).expect("nothing stops"));
        println!("{ty:6} {:6.2} ns for an operation", time / 10_000.0);
    }

    let (mut machine, cycle, offset) = machine("cont_c.scl", include_str!("../data/cont_c.scl"));
    let (process_value, manual) = (offset("PV_IN"), offset("MAN_ON"));
    machine.set(false.into(), manual);
    let mut block = ContC { man_on: false, ..ContC::default() };
    let (mut in_scl, mut in_rust) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..20 {
        let mut value = 0.0_f32;
        in_scl = in_scl.min(least(1, 10_000, || {
            value += 0.01;
            machine.set(value.into(), process_value);
            machine.call(cycle, 0).expect("nothing stops");
        }));
        let mut value = 0.0_f32;
        in_rust = in_rust.min(least(1, 10_000, || {
            value += 0.01;
            block.pv_in = black_box(value);
            block.call();
            black_box(&block);
        }));
    }
    println!("CONT_C {in_scl:6.1} ns for a call in SCL, {in_rust:.1} ns in Rust: {:.1} times", in_scl / in_rust);
}
