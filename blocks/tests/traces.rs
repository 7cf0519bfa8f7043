//! The recordings made at the terminals of real blocks, replayed call by call and compared bit for bit.
//!
//! A trace has columns `in_NAME` (before the call) and `out_NAME` (after it), times in milliseconds; row 0 is the restart
//! call. The blocks are driven through their tables, by name, as every other user of the crate drives them.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

use blocks::{Block, ContC, ContS, Kind, Time, Value, Word};

#[test]
fn cont_c_repeats_its_recordings_bit_for_bit() {
    replay_all::<ContC>();
}

#[test]
fn cont_s_repeats_its_recordings_bit_for_bit() {
    replay_all::<ContS>();
}

fn replay_all<B: Block>() {
    let traces = traces_of(B::TABLE.name);
    assert!(!traces.is_empty(), "no trace of {} in {}", B::TABLE.name, directory().display());
    for trace in traces {
        let calls = replay::<B>(&trace);
        assert!(calls > 1, "{} records no call", trace.display());
    }
}

fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/traces")
}

fn traces_of(block: &str) -> Vec<PathBuf> {
    let directory = directory();
    let entries = fs::read_dir(&directory).unwrap_or_else(|error| panic!("{}: {error}", directory.display()));
    let mut traces: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    traces.retain(|path| path.file_name().unwrap().to_string_lossy().starts_with(&format!("{block}_")));
    traces.sort();
    traces
}

/// Replays one trace and returns the number of its calls.
fn replay<B: Block>(trace: &Path) -> usize {
    let text = fs::read_to_string(trace).unwrap_or_else(|error| panic!("{}: {error}", trace.display()));
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<_> = lines.next().expect("a line of column names").split(',').collect();
    assert!(columns.iter().any(|column| column.starts_with("out_")), "{} records no output", trace.display());

    let mut block = B::default();
    let mut calls = 0;
    for line in lines {
        let fields: Vec<_> = line.split(',').collect();
        assert_eq!(fields.len(), columns.len(), "{}: {line}", trace.display());
        for (column, field) in columns.iter().zip(&fields) {
            if let Some(name) = column.strip_prefix("in_") {
                let row = row::<B>(name);
                assert!(block.set(row, value(B::TABLE.rows[row].kind, field)));
            }
        }
        block.call();
        for (column, field) in columns.iter().zip(&fields) {
            if let Some(name) = column.strip_prefix("out_") {
                let row = row::<B>(name);
                let recorded = value(B::TABLE.rows[row].kind, field);
                let computed = block.get(row).unwrap();
                assert!(
                    is_same(computed, recorded),
                    "{}, call {}: {name} is {computed:?}, recorded was {recorded:?}",
                    trace.display(),
                    fields[0]
                );
            }
        }
        calls += 1;
    }
    calls
}

fn row<B: Block>(name: &str) -> usize {
    B::TABLE.find(name).unwrap_or_else(|| panic!("{} has no terminal {name}", B::TABLE.name))
}

fn value(kind: Kind, field: &str) -> Value {
    match kind {
        Kind::Real => Value::Real(field.parse().unwrap()),
        Kind::LReal => Value::LReal(field.parse().unwrap()),
        Kind::Time => Value::Time(Time::ms(field.parse().unwrap())),
        Kind::Word => Value::Word(Word::new(field.parse().unwrap())),
        Kind::Int => Value::Int(field.parse().unwrap()),
        Kind::Bool => Value::Bool(field == "1"),
        _ => unreachable!("no block has such a type"),
    }
}

/// Equal to the last bit; the sign of zero counts too.
fn is_same(computed: Value, recorded: Value) -> bool {
    match (computed, recorded) {
        (Value::Real(computed), Value::Real(recorded)) => computed.to_bits() == recorded.to_bits(),
        _ => computed == recorded,
    }
}
