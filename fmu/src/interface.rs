//! What the library says of itself: the GUID of its interface, and its table as text for the packer.

use crate::value;
use blocks::{Block, Row, Table, Value};
use std::fmt::Write;
use std::marker::PhantomData;

/// The GUID of a block's interface, computed while the library is compiled.
pub struct Guid<B>(PhantomData<B>);

impl<B: Block> Guid<B> {
    /// A hash of everything a host relies on, and of the memory that a serialized state is made of.
    pub const BYTES: [u8; 16] = table_hash(BASIS, B::TABLE).to_be_bytes();

    const TEXT_BYTES: [u8; 38] = guid_text(Self::BYTES);

    /// The GUID as it stands in modelDescription.xml.
    pub const TEXT: &'static str = match std::str::from_utf8(&Self::TEXT_BYTES) {
        Ok(text) => text,
        Err(_) => "",
    };
}

// FNV-1a with 128 bits (Fowler, Noll, Vo).
const BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
const PRIME: u128 = (1 << 88) + 0x13b;

/// The hash of `bytes` after what was hashed before. A change of any one byte changes it: each step is a bijection.
pub const fn hash(mut hash: u128, bytes: &[u8]) -> u128 {
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u128).wrapping_mul(PRIME);
        i += 1;
    }
    hash
}

/// The checksum of a serialized state.
pub fn checksum(bytes: &[u8]) -> u128 {
    hash(BASIS, bytes)
}

const fn text_hash(state: u128, text: &str) -> u128 {
    hash(hash(state, text.as_bytes()), &[0])
}

const fn value_hash(state: u128, value: Option<Value>) -> u128 {
    match value {
        None => hash(state, &[0]),
        Some(Value::Real(real)) => hash(hash(state, &[1]), &real.to_bits().to_le_bytes()),
        Some(Value::LReal(lreal)) => hash(hash(state, &[2]), &lreal.to_bits().to_le_bytes()),
        Some(Value::Time(time)) => hash(hash(state, &[3]), &time.milliseconds().to_le_bytes()),
        Some(Value::Word(word)) => hash(hash(state, &[4]), &word.value().to_le_bytes()),
        Some(Value::Int(int)) => hash(hash(state, &[5]), &int.to_le_bytes()),
        Some(Value::Bool(bool)) => hash(state, &[6, bool as u8]),
    }
}

const fn row_hash(mut state: u128, row: &Row) -> u128 {
    let mut i = 0;
    while i < row.path.len() {
        state = text_hash(state, row.path[i]);
        i += 1;
    }
    state = text_hash(state, row.name);
    state = hash(state, &[row.kind as u8, row.role as u8]);
    state = value_hash(state, Some(row.start));
    state = value_hash(state, row.min);
    state = value_hash(state, row.max);
    text_hash(state, if let Some(unit) = row.unit { unit } else { "" })
}

const fn table_hash(mut state: u128, table: &Table) -> u128 {
    state = text_hash(state, table.name);
    let mut i = 0;
    while i < table.rows.len() {
        state = row_hash(state, &table.rows[i]);
        i += 1;
    }
    i = 0;
    while i < table.memory.len() {
        state = text_hash(text_hash(state, table.memory[i].0), table.memory[i].1);
        i += 1;
    }
    i = 0;
    while i < table.instances.len() {
        state = table_hash(state, table.instances[i]);
        i += 1;
    }
    state
}

const fn guid_text(bytes: [u8; 16]) -> [u8; 38] {
    const DIGITS: [u8; 16] = *b"0123456789abcdef";
    let mut text = *b"{00000000-0000-0000-0000-000000000000}";
    let mut place = 1;
    let mut i = 0;
    while i < 16 {
        if text[place] == b'-' {
            place += 1;
        }
        text[place] = DIGITS[(bytes[i] >> 4) as usize];
        text[place + 1] = DIGITS[(bytes[i] & 15) as usize];
        place += 2;
        i += 1;
    }
    text
}

/// The table as JSON: name, documentation, GUID, the number of the cycle variable, the variables by value reference
/// (numbers as FMI has them: TIME in seconds, TRUE as 1), and the response.
pub fn json<B: Block>() -> String {
    let table = B::TABLE;
    let mut json = String::new();
    let _ = write!(
        json,
        r#"{{"name":{},"docs":{},"guid":{},"cycle":{},"variables":["#,
        quoted(table.name),
        quoted(table.docs),
        quoted(Guid::<B>::TEXT),
        table.cycle
    );
    for (i, row) in table.rows.iter().enumerate() {
        let _ = write!(
            json,
            r#"{}{{"name":{},"description":{},"kind":"{:?}","role":"{:?}","start":{:?},"min":{},"max":{},"unit":{}}}"#,
            if i == 0 { "" } else { "," },
            quoted(&row.full_name()),
            quoted(row.description),
            row.kind,
            row.role,
            value::number(row.start),
            optional(row.min.map(value::number).map(|min| format!("{min:?}"))),
            optional(row.max.map(value::number).map(|max| format!("{max:?}"))),
            optional(row.unit.map(quoted)),
        );
    }
    let response = &table.response;
    let set: Vec<String> =
        response.set.iter().map(|(call, name, value)| format!("[{call},{},{value:?}]", quoted(name))).collect();
    let show: Vec<String> = response.show.iter().map(|name| quoted(name)).collect();
    let _ = write!(
        json,
        r#"],"response":{{"title":{},"calls":{},"set":[{}],"show":[{}]}}}}"#,
        quoted(response.title),
        response.calls,
        set.join(","),
        show.join(",")
    );
    json
}

fn optional(text: Option<String>) -> String {
    text.unwrap_or_else(|| "null".into())
}

fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            control if control < ' ' => {
                let _ = write!(quoted, "\\u{:04x}", u32::from(control));
            }
            other => quoted.push(other),
        }
    }
    quoted.push('"');
    quoted
}
