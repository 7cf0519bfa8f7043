//! The formats that contain numbers: dumps, JSON, SSV and Openness XML.

#![allow(clippy::unwrap_used)]

mod dump;
mod hostile;
mod json;
mod openness;
mod round_trip;
mod ssv;

use blocks::{Kind, Role, Row, Time, Value, Word};
use parameters::{BlockType, Format, Loop, Options, Origin, Problems, Reading, Source, read};
use std::sync::Arc;

/// A block with a member of every type.
fn pump() -> Arc<BlockType> {
    let members = vec![
        Row::new("ON", Role::Input, Value::Bool(false)),
        Row::new("MAN_ON", Role::Input, Value::Bool(true)),
        Row { unit: Some("%".into()), max: Some(Value::Real(100.0)), ..Row::new("MAN", Role::Input, Value::Real(5.0)) },
        Row::new("PV_PER", Role::Input, Value::Word(Word::new(0))),
        Row::new("COUNT", Role::Fixed, Value::Int(3)),
        Row::new("GAIN", Role::Parameter, Value::Real(2.0)),
        Row::new("SUM", Role::Parameter, Value::LReal(0.1)),
        Row::new("TI", Role::Parameter, Value::Time(Time::ms(20_000))),
        Row::new("CYCLE", Role::Cycle, Value::Time(Time::ms(1000))),
        Row::new("LMN", Role::Output, Value::Real(0.0)),
        Row::new("QMIN", Role::Output, Value::Bool(false)),
    ];
    Arc::new(BlockType::new("PUMP".into(), vec!["FB 410".into()], members))
}

/// A block that shares some names with [`pump`].
fn valve() -> Arc<BlockType> {
    let members = vec![
        Row::new("GAIN", Role::Parameter, Value::Real(1.0)),
        Row::new("TRAVEL", Role::Parameter, Value::Real(1.0)),
        Row::new("CYCLE", Role::Cycle, Value::Time(Time::ms(1000))),
        Row::new("POSITION", Role::Output, Value::Real(0.0)),
    ];
    Arc::new(BlockType::new("VALVE".into(), Vec::new(), members))
}

/// A block that contains another one.
fn station() -> Arc<BlockType> {
    let members = vec![
        Row::new("STROKE", Role::Parameter, Value::Real(1.0)),
        Row::new("CYCLE", Role::Cycle, Value::Time(Time::ms(1000))),
        Row::new("DI_PUMP.GAIN", Role::Parameter, Value::Real(1.0)),
    ];
    Arc::new(BlockType::new("STATION".into(), Vec::new(), members))
}

fn all() -> Vec<Arc<BlockType>> {
    vec![pump(), valve(), station()]
}

fn of_block(name: &str) -> Options {
    Options { block: Some(name.into()), ..Options::default() }
}

fn reading(format: Format, text: impl AsRef<[u8]>, options: &Options) -> Result<Reading, Problems> {
    let file = format!("plant.{}", format.extensions()[0]);
    read(format, &Source::new(file, text.as_ref().to_vec()), &all(), options)
}

/// Returns the loops of a valid file.
#[track_caller]
fn loops(format: Format, text: impl AsRef<[u8]>) -> Vec<Loop> {
    reading(format, text, &Options::default()).unwrap_or_else(|problems| panic!("{problems}")).loops
}

/// Returns the error of an invalid file.
#[track_caller]
fn refusal(format: Format, text: impl AsRef<[u8]>) -> String {
    reading(format, text, &Options::default()).unwrap_err().to_string()
}

/// Returns the origin of a loop's value: `plant.json:2:3`.
fn origin(one: &Loop, name: &str) -> String {
    let member = one.block.find(name).unwrap();
    one.settings.iter().find(|setting| setting.member == member).unwrap().origin.to_string()
}

/// Returns the names of the settings given in the file.
fn given(one: &Loop) -> Vec<&str> {
    let given = one.settings.iter().filter(|setting| setting.origin != Origin::Default);
    given.map(|setting| one.block.members[setting.member].name.as_str()).collect()
}

#[test]
fn a_value_out_of_its_range_of_sense_is_named_with_the_range() {
    let mut one = Loop::new("P1", pump());
    assert_eq!(one.outside(), Vec::<String>::new());
    one.set(2, Value::Real(100.1), Origin::Default);
    one.set(5, Value::Real(f32::NAN), Origin::Default);
    assert_eq!(
        one.outside(),
        ["MAN = 100.1: the highest sensible value is 100.0", "GAIN = NaN: it is not a finite number"]
    );
}

#[test]
fn the_format_of_a_file_is_that_of_its_ending_in_any_case() {
    assert_eq!(Format::of_file("C:\\plant\\TIC.XML"), Some(Format::Openness));
    assert_eq!(Format::of_file("a.json/b"), None);
    assert_eq!(Format::of_file("ssv"), None);
}

#[test]
fn a_block_that_does_not_exist_is_refused_in_every_format() {
    for format in [Format::Dump, Format::Json, Format::Ssv, Format::Openness] {
        let problems = reading(format, "", &of_block("MOTOR")).unwrap_err();
        let expected =
            format!("plant.{}: no block is called \"MOTOR\"; available: PUMP, VALVE, STATION", format.extensions()[0]);
        assert_eq!(problems.to_string(), expected);
    }
}
