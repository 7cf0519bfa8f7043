//! Reads any bytes as a PLC program: errors, or a program of which one call ends.

#![no_main]

use libfuzzer_sys::fuzz_target;
use parameters::{Source, problem};
use scl::machine::{Code, Machine};
use scl::{Options, compile};
use std::sync::Arc;

fuzz_target!(|bytes: &[u8]| {
    match compile(&[Source::new("machine.scl", bytes.to_vec())], &Options::default()) {
        Ok(compiled) => {
            let code = Code::compile(&compiled.program).unwrap_or_else(|error| panic!("{error}"));
            let Some(root) = compiled.root else { return };
            let mut machine = Machine::new(Arc::new(code));
            machine.budget = 10_000;
            for function in root.startup.into_iter().chain([root.cycle]) {
                // It may stop: with a reason.
                let _ = machine.call(function, 0);
            }
        }
        Err(errors) => {
            assert!(!errors.is_empty());
            errors.iter().for_each(|problems| drop(problem::drawn(problems)));
        }
    }
});
