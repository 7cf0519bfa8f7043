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

/// The table as JSON: name, documentation, GUID, the numbers of the cycle variable and of the mean, the variables by value
/// reference (numbers as FMI has them: TIME in seconds, TRUE as 1), and the response.
pub fn json<B: Block>() -> String {
    let table = B::TABLE;
    let mut json = String::new();
    let _ = write!(
        json,
        r#"{{"name":{},"docs":{},"guid":{},"cycle":{},"mean":{},"variables":["#,
        quoted(table.name),
        quoted(table.docs),
        quoted(Guid::<B>::TEXT),
        table.cycle,
        optional(table.mean.map(|mean| mean.to_string()))
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
            optional(row.min.map(|min| format!("{:?}", value::number(min).min(decimal(min))))),
            optional(row.max.map(|max| format!("{:?}", value::number(max).max(decimal(max))))),
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

/// The value as it is written in decimals: 0.1 for the REAL next to it, which is a little more. A range holds both, so that
/// neither a host that computes in doubles nor the REAL itself falls out of it.
fn decimal(value: Value) -> f64 {
    match value {
        Value::Real(real) => real.to_string().parse().unwrap_or(f64::from(real)),
        other => value::number(other),
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use blocks::ContC;

    #[test]
    fn the_guid_has_the_form_of_one() {
        let guid = Guid::<ContC>::TEXT;
        assert_eq!(guid.len(), 38);
        for (place, character) in guid.char_indices() {
            match place {
                0 => assert_eq!(character, '{'),
                37 => assert_eq!(character, '}'),
                9 | 14 | 19 | 24 => assert_eq!(character, '-'),
                _ => assert!(character.is_ascii_hexdigit(), "{guid}"),
            }
        }
    }

    #[test]
    fn the_guid_is_written_byte_by_byte_in_hexadecimal_digits() {
        let bytes = 0x0123_4567_89ab_cdef_fedc_ba98_7654_3210_u128.to_be_bytes();
        assert_eq!(&guid_text(bytes), b"{01234567-89ab-cdef-fedc-ba9876543210}");
    }

    #[test]
    fn the_hash_is_fnv_1a_with_128_bits() {
        // The authors' own test vectors.
        assert_eq!(checksum(b""), 0x6c62272e07bb014262b821756295c58d);
        assert_eq!(checksum(b"a"), 0xd228cb696f1a8caf78912b704e4a8964);
        assert_eq!(checksum(b"foobar"), 0x343e1662793c64bf6f0d3597ba446f18);
    }

    #[test]
    fn everything_a_host_relies_on_is_in_the_guid() {
        let row = ContC::TABLE.rows[0];
        let of = |row: Row| row_hash(BASIS, &row);
        let same = of(row);
        assert_ne!(of(Row { name: "OTHER", ..row }), same, "name");
        assert_ne!(of(Row { path: ["A", "", ""], ..row }), same, "path");
        assert_ne!(of(Row { role: blocks::Role::Parameter, ..row }), same, "role");
        assert_ne!(of(Row { kind: blocks::Kind::Int, ..row }), same, "type");
        assert_ne!(of(Row { start: Value::Bool(true), ..row }), same, "start");
        assert_ne!(of(Row { min: Some(Value::Bool(false)), ..row }), same, "min");
        assert_ne!(of(Row { max: Some(Value::Bool(false)), ..row }), same, "max");
        assert_ne!(of(Row { unit: Some("s"), ..row }), same, "unit");
        assert_eq!(of(Row { description: "in other words", ..row }), same, "its description is not");
    }

    #[test]
    fn the_memory_that_a_state_is_made_of_is_in_the_guid() {
        let table = |memory| Table {
            name: "X",
            docs: "",
            rows: ContC::TABLE.rows,
            cycle: 8,
            mean: None,
            memory,
            instances: &[],
            response: blocks::Response::AT_REST,
        };
        assert_ne!(table_hash(BASIS, &table(&[("a", "Real")])), table_hash(BASIS, &table(&[("a", "LReal")])));
        assert_ne!(table_hash(BASIS, &table(&[("a", "Real")])), table_hash(BASIS, &table(&[("b", "Real")])));
    }

    #[test]
    fn the_instances_that_a_state_is_made_of_are_in_the_guid() {
        const fn table(name: &'static str, instances: &'static [&'static Table]) -> Table {
            let (rows, memory, response) = (&[], &[], blocks::Response::AT_REST);
            Table { name, docs: "", rows, cycle: 0, mean: None, memory, instances, response }
        }
        const A: &Table = &table("A", &[]);
        const B: &Table = &table("B", &[]);
        let of = |instances| table_hash(BASIS, &table("X", instances));
        let all = [of(&[]), of(&[A]), of(&[B]), of(&[A, A]), of(&[A, B]), of(&[B, A])];
        for (i, one) in all.iter().enumerate() {
            assert!(!all[..i].contains(one), "case {i}");
        }
    }

    #[test]
    fn a_limit_of_a_real_holds_its_decimal_and_itself() {
        // The REAL next to 0.1 lies above it, the one next to 0.7 below.
        assert_eq!((decimal(Value::Real(0.1)), value::number(Value::Real(0.1))), (0.1, 0.10000000149011612));
        assert_eq!((decimal(Value::Real(0.7)), value::number(Value::Real(0.7))), (0.7, 0.699999988079071));
        assert_eq!(decimal(Value::Real(f32::MAX)), 3.4028235e38);
        assert!(json::<blocks::Pulsegen>().contains(r#""start":1.0,"min":0.1,"max":10.0"#));
    }

    #[test]
    fn texts_are_quoted_for_json() {
        assert_eq!(quoted("a \"b\" \\ \n°"), "\"a \\\"b\\\" \\\\ \\u000a°\"");
    }
}
