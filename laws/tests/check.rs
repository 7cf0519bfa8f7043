//! What a block rejects is also rejected by its law as a typed program, with the same sentence.

#![allow(clippy::unwrap_used)]

use blocks::{Law as _, PulsCtr, Time};
use laws::{Law, Sources};
use scl::ir::Scalar;
use scl::machine::{Code, Machine};
use std::sync::Arc;

/// Returns the sentence with which a law rejects the present settings.
fn refusal(law: &Law, machine: &mut Machine) -> Result<(), String> {
    let check = law.check.as_ref().expect("the block has a check");
    machine.call(check.function, 0).unwrap();
    let at = |name: &str| law.program.find(name).unwrap().0;
    let number = machine.get(Scalar::I32, at("refusal")).number() as usize;
    if number == 0 {
        return Ok(());
    }
    let mut text = check.messages[number - 1].clone();
    for place in 1..=laws::NUMBERS {
        let value = machine.get(Scalar::F64, at(&format!("refusal_{place}"))).number();
        text = text.replacen('\u{1}', &value.to_string(), 1);
    }
    Err(text)
}

#[test]
fn settings_are_refused_with_the_sentence_of_rust() {
    let law = laws::read_whole(&Sources::of_blocks(), "PULS_CTR").unwrap_or_else(|error| panic!("{error}"));
    let mut machine = Machine::new(Arc::new(Code::compile(&law.program).unwrap()));
    let mut refused = 0;
    for (cycle, red_fac) in [
        (1000, 1),
        (1000, 0),
        (1000, -3),
        (1000, i16::MAX),
        (65_538, i16::MAX),
        (65_539, i16::MAX),
        (i32::MAX, 2),
        (i32::MAX, 1),
        (123_456_789, 1000),
    ] {
        let block = PulsCtr { cycle: Time::ms(cycle), red_fac, ..PulsCtr::default() };
        machine.set(cycle.into(), law.program.find("PULS_CTR.CYCLE").unwrap().0);
        machine.set(red_fac.into(), law.program.find("PULS_CTR.RED_FAC").unwrap().0);
        assert_eq!(refusal(&law, &mut machine), block.check(), "CYCLE {cycle}, RED_FAC {red_fac}");
        refused += usize::from(block.check().is_err());
    }
    assert_eq!(refused, 5);
}

#[test]
fn a_block_that_refuses_nothing_has_no_check() {
    assert!(laws::read_whole(&Sources::of_blocks(), "CONT_C").unwrap().check.is_none());
}

#[test]
fn a_sentence_that_cannot_be_read_is_told_with_its_place() {
    let cases = [
        ("Err(format!(\"{:.3} is much\", self.weight))", "{:.3} in a message is not supported"),
        ("Err(why())", "a refusal must be format!"),
        ("Err(format!(\"{} {} {} {} {}\", 1, 2, 3, 4, 5))", "at most 4 numbers"),
    ];
    for (refusal, message) in cases {
        let from = "    fn restart(&mut self) {";
        let text = include_str!("counter/mod.rs");
        assert_eq!(text.matches(from).count(), 1);
        let line = text.lines().position(|line| line.contains(from.trim())).unwrap() + 2;
        let check = format!("    fn check(&self) -> Result<(), String> {{\n        {refusal}\n    }}\n\n{from}");
        let mut sources = Sources::of_blocks();
        sources.add("my_block/src/lib.rs", text.replace(from, &check));
        let error = laws::read_whole(&sources, "COUNTER").expect_err(refusal);
        assert!(error.message.contains(message), "{refusal}: {error}");
        assert_eq!((error.file.as_str(), error.line), ("my_block/src/lib.rs", line), "{error}");
    }
}
