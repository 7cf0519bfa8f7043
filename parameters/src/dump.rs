//! The bytes of a non-optimized data block, as a PLC stores them: see [`layout`].
//!
//! A dump contains the exact values, but does not name its block. A remark points out anything that does not look like
//! an instance of the block named by the user.

use crate::block::BlockType;
use crate::layout::{self, Address};
use crate::loops::{Loop, Origin};
use crate::report::{Report, list};
use crate::{Options, Problems, Reading, Remedy, Source};
use blocks::{Kind, Role, Time, Value, Word};
use std::sync::Arc;

/// Reads one instance, which starts at byte [`Options::offset`].
///
/// # Errors
/// The user names no block or one that cannot be dumped, or the dump is too short.
pub fn read(source: &Source, blocks: &[Arc<BlockType>], options: &Options) -> Result<Reading, Problems> {
    let mut report = Report::new(source, options);
    let Ok(chosen) = report.chosen(blocks, options) else { return report.finish(Vec::new()) };
    let Some(block) = chosen else {
        let help = Remedy::ChooseBlock(list(blocks));
        report.wrong_file("a dump does not state which block it belongs to", Some(help));
        return report.finish(Vec::new());
    };
    let (addresses, size) = match whole(&block) {
        Ok(layout) => layout,
        Err(message) => {
            report.wrong_file(message, None);
            return report.finish(Vec::new());
        }
    };
    let offset = options.offset;
    if !offset.is_multiple_of(2) {
        report.wrong_file(format!("the offset is {offset}: an instance starts at an even byte"), None);
        return report.finish(Vec::new());
    }
    let Some(data) = source.bytes.get(offset..).and_then(|data| data.get(..size)) else {
        let (name, length) = (&block.name, source.bytes.len());
        let behind = if offset > 0 { format!(" from byte {offset}") } else { String::new() };
        let message = format!("{name} needs {size} bytes{behind}, but the dump has only {length}");
        report.wrong_file(message, Some("read the whole data block, and check the block and the offset".into()));
        return report.finish(Vec::new());
    };

    let mut one = Loop::new(report.loop_name(options), block.clone());
    for (index, (member, address)) in block.members.iter().zip(&addresses).enumerate() {
        let Some(address) = *address else { continue };
        let value = value(data, address, member.kind);
        let place = Address { byte: address.byte + offset, ..address };
        if !is_finite(value) {
            report.remark(None, format!("byte {place}: {} is not a finite number", member.name));
        }
        if member.role == Role::Cycle && matches!(value, Value::Time(cycle) if cycle <= Time::ZERO) {
            let message =
                format!("byte {place}: {} is not greater than 0: a running instance never has this value", member.name);
            report.remark(None, message);
        }
        one.set(index, value, Origin::Data { file: source.file.clone(), address: place });
    }
    for byte in unused(&addresses, &block, data) {
        let message = format!(
            "byte {}: bits are set that {} does not use: the block or the offset may be wrong",
            byte + offset,
            block.name
        );
        report.remark(None, message);
    }
    report.finish(vec![one])
}

/// Writes one loop: inputs and parameters, with 0 for the outputs. The memory that follows the block's outputs is not
/// in its table, so it is not written.
///
/// # Errors
/// The number of loops is not one, or the loop's block contains other blocks.
pub fn write(loops: &[Loop]) -> Result<Vec<u8>, String> {
    let [one] = loops else {
        return Err(format!("a dump holds one loop, not {}: write only one", loops.len()));
    };
    let (addresses, size) = whole(&one.block)?;
    let mut data = vec![0; size];
    for setting in &one.settings {
        if let Some(address) = addresses[setting.member] {
            put(&mut data, address, setting.value);
        }
    }
    Ok(data)
}

/// The member addresses and the size of a block that its table describes completely: one without inner blocks.
fn whole(block: &BlockType) -> Result<(Vec<Option<Address>>, usize), String> {
    if let Some(inner) = block.members.iter().find(|member| member.is_inner()) {
        return Err(format!(
            "{} contains other blocks ({}), whose location in a data block is unknown: use a format other than a dump",
            block.name, inner.name
        ));
    }
    Ok(layout::addresses(block))
}

/// The offsets of bytes in which bits are set that belong to no member.
fn unused(addresses: &[Option<Address>], block: &BlockType, data: &[u8]) -> Vec<usize> {
    let mut used = vec![0u8; data.len()];
    for (member, address) in block.members.iter().zip(addresses) {
        match address {
            Some(address) if address.is_bit => used[address.byte] |= 1 << address.bit,
            Some(address) => used[address.byte..address.byte + member.kind.width()].fill(0xFF),
            None => {}
        }
    }
    (0..data.len()).filter(|byte| data[*byte] & !used[*byte] != 0).collect()
}

fn is_finite(value: Value) -> bool {
    match value {
        Value::Real(real) => real.is_finite(),
        Value::LReal(lreal) => lreal.is_finite(),
        _ => true,
    }
}

/// The value at an address inside the data.
fn value(data: &[u8], address: Address, kind: Kind) -> Value {
    match kind {
        Kind::Bool => Value::Bool(data[address.byte] >> address.bit & 1 == 1),
        Kind::Real => Value::Real(f32::from_be_bytes(bytes(data, address))),
        Kind::LReal => Value::LReal(f64::from_be_bytes(bytes(data, address))),
        Kind::Time => Value::Time(Time::ms(i32::from_be_bytes(bytes(data, address)))),
        Kind::Word => Value::Word(Word::new(i16::from_be_bytes(bytes(data, address)))),
        Kind::Int => Value::Int(i16::from_be_bytes(bytes(data, address))),
        _ => {
            let bytes = &data[address.byte..address.byte + kind.width()];
            let is_negative = kind.whole().is_some_and(|(low, _)| low < 0) && bytes[0] >= 0x80;
            let extend = |bits: i64, byte: &u8| bits << 8 | i64::from(*byte);
            Value::Whole(kind, bytes.iter().fold(-i64::from(is_negative), extend))
        }
    }
}

fn bytes<const N: usize>(data: &[u8], address: Address) -> [u8; N] {
    std::array::from_fn(|place| data[address.byte + place])
}

fn put(data: &mut [u8], address: Address, value: Value) {
    let mut put = |bytes: &[u8]| data[address.byte..address.byte + bytes.len()].copy_from_slice(bytes);
    match value {
        Value::Bool(bool) => data[address.byte] |= u8::from(bool) << address.bit,
        Value::Real(real) => put(&real.to_be_bytes()),
        Value::LReal(lreal) => put(&lreal.to_be_bytes()),
        Value::Time(time) => put(&time.milliseconds().to_be_bytes()),
        Value::Word(word) => put(&word.value().to_be_bytes()),
        Value::Int(int) => put(&int.to_be_bytes()),
        Value::Whole(kind, bits) => put(&bits.to_be_bytes()[8 - kind.width()..]),
    }
}
