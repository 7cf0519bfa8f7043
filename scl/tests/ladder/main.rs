//! Ladder and function block diagrams, written as SimaticML by a writer of the tests: the behavior of each element.

#![allow(clippy::unwrap_used)]

mod damaged;
mod data;
mod elements;
mod example;
mod formats;
mod order;
mod random;
mod twice;
mod xml;

use parameters::{Problems, Source};
use scl::ir::{Scalar, Type, Value};
use scl::machine::{Code, Machine};
use scl::{Compiled, Options, compile, compile_watched};
use std::sync::Arc;
use xml::Net;

/// A program and its values.
struct Ran {
    compiled: Compiled,
    machine: Machine,
    /// The same program with watching enabled, which must behave identically.
    watched: Option<Machine>,
    now: i64,
}

fn compiled(sources: &[(&str, String)]) -> Result<Compiled, Vec<Problems>> {
    compiled_as(compile, sources)
}

type Compile = fn(&[Source], &Options) -> Result<Compiled, Vec<Problems>>;

fn compiled_as(compile: Compile, sources: &[(&str, String)]) -> Result<Compiled, Vec<Problems>> {
    let sources: Vec<Source> =
        sources.iter().map(|(name, text)| Source::new(*name, text.clone().into_bytes())).collect();
    // Constructs that no random network happens to call must not be run in its place.
    let has_it = sources
        .iter()
        .any(|source| source.text.contains("FUNCTION_BLOCK \"B\"") || source.text.contains("<Name>B</Name>"));
    compile(&sources, &Options { block: has_it.then(|| "B".to_string()), ..Options::default() })
}

impl Ran {
    #[track_caller]
    fn new(sources: &[(&str, String)]) -> Ran {
        match compiled(sources) {
            Ok(compiled) => {
                let watched = compiled_as(compile_watched, sources).unwrap_or_else(|errors| panic!("{}", errors[0]));
                let mut watched = Machine::new(Arc::new(Code::compile(&watched.program).unwrap()));
                watched.keep_locals();
                Ran { watched: Some(watched), ..Ran::from_compiled(compiled) }
            }
            Err(errors) => panic!("{}", errors[0]),
        }
    }

    fn from_compiled(compiled: Compiled) -> Ran {
        let machine = Machine::new(Arc::new(Code::compile(&compiled.program).unwrap()));
        Ran { compiled, machine, watched: None, now: 0 }
    }

    /// Creates a function block with these sections and networks in LAD.
    #[track_caller]
    fn of(sections: &[(&str, &str)], networks: Vec<Net>) -> Ran {
        Ran::new(&[("b.xml", xml::block("FB", "B", sections, networks, "LAD"))])
    }

    fn place(&self, name: &str) -> (usize, Scalar) {
        let path = format!("{}.{name}", self.compiled.root.as_ref().unwrap().instance);
        match self.compiled.program.find(&path) {
            Some((offset, Type::Scalar(of))) => (offset, of),
            other => panic!("{path}: {other:?}"),
        }
    }

    fn set(&mut self, name: &str, value: i64) -> &mut Ran {
        let (offset, of) = self.place(name);
        let value = match of {
            Scalar::F32 => (value as f32).into(),
            Scalar::F64 => (value as f64).into(),
            of => Value::new(of, value as u64),
        };
        self.machine.set(value, offset);
        self
    }

    /// Makes a call 100 ms after the last one.
    fn call(&mut self) -> &mut Ran {
        let cycle = self.compiled.root.as_ref().unwrap().cycle;
        if let Some(watched) = &mut self.watched {
            watched.state_mut().copy_from_slice(self.machine.state());
            watched.call(cycle, self.now).unwrap();
        }
        self.machine.call(cycle, self.now).unwrap();
        assert!(self.watched.as_ref().is_none_or(|watched| watched.state() == self.machine.state()));
        self.now += 100_000_000;
        self
    }

    /// Returns the bits of a variable.
    fn bits(&self, name: &str) -> i64 {
        let (offset, of) = self.place(name);
        self.machine.get(of, offset).bits() as i64
    }

    /// Returns a variable as an integer.
    fn get(&self, name: &str) -> i64 {
        let (offset, of) = self.place(name);
        let value = self.machine.get(of, offset);
        match of {
            Scalar::F32 => f32::from_bits(value.bits() as u32) as i64,
            Scalar::F64 => f64::from_bits(value.bits()) as i64,
            Scalar::Bool => (value.bits() & 1) as i64,
            of if of.is_signed() => value.bits() as i64,
            _ => value.bits() as i64,
        }
    }
}
