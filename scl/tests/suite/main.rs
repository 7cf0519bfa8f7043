//! The behavior of the language and its functions, with values that can be checked by hand: small programs and their
//! results.

#![allow(clippy::unwrap_used)]

mod clock;
mod functions;
mod language;
mod texts;
mod views;

use parameters::{Problems, Source};
use scl::ir::{Scalar, Type, Value};
use scl::machine::{Code, Machine, Stop};
use scl::{Compiled, Options, compile};
use std::sync::Arc;

/// Compiles a source.
fn compiled(source: &str) -> Result<Compiled, Vec<Problems>> {
    compile(&[Source::new("b.scl", source.into())], &Options::default())
}

/// A program with its values.
struct Ran {
    compiled: Compiled,
    machine: Machine,
}

impl Ran {
    /// Creates a program before its first call.
    fn new(compiled: Compiled) -> Ran {
        let machine = Machine::new(Arc::new(Code::compile(&compiled.program).unwrap()));
        Ran { compiled, machine }
    }

    /// Makes one call, at a time in nanoseconds.
    fn call(&mut self, now: i64) -> Result<(), Stop> {
        self.machine.call(self.compiled.root.as_ref().unwrap().cycle, now)
    }

    /// Returns a variable of the block that is run.
    fn get(&self, name: &str) -> Value {
        let path = format!("{}.{name}", self.compiled.root.as_ref().unwrap().instance);
        match self.compiled.program.find(&path) {
            Some((offset, Type::Scalar(of))) => self.machine.get(of, offset),
            other => panic!("{path}: {other:?}"),
        }
    }
}

/// Whether `y` is TRUE after one call.
fn is_y_true(compiled: Compiled) -> bool {
    let mut ran = Ran::new(compiled);
    ran.call(0).unwrap();
    let y = ran.get("y");
    assert_eq!(y.ty(), Scalar::Bool, "y is no BOOL");
    y == true.into()
}

/// Compiles a source and returns whether `y` is TRUE after one call.
#[track_caller]
fn runs(source: &str) -> bool {
    is_y_true(compiled(source).unwrap_or_else(|errors| panic!("{source}: {}", errors[0])))
}
