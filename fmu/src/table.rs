//! A block's table as JSON for the packer, and its fingerprint.

use crate::preset::Form;
use blocks::table::fingerprint::{self, BASIS, hash};
use blocks::table::number::{beyond_number, number};
use blocks::{Block, StaticRow, StaticTable, Table, TableText, Types, Value};
use std::fmt::Write;
use std::marker::PhantomData;

/// The fingerprint of a block's table, computed at compile time.
pub struct Fingerprint<B>(PhantomData<B>);

impl<B: Block> Fingerprint<B> {
    /// A hash of everything a host relies on, and of the memory layout of a saved session. Purely descriptive strings
    /// are excluded.
    pub const HASH: u128 = table_hash(BASIS, B::TABLE);
}

/// The GUID of a block's FMU, computed at compile time: the fingerprint of the block's table.
pub struct Guid<B>(PhantomData<B>);

impl<B: Block> Guid<B> {
    const TEXT_BYTES: [u8; 38] = fingerprint::text(Fingerprint::<B>::HASH);

    /// The instantiation token for each choice of types.
    pub const TOKENS: [[u8; 38]; 2] = [
        fingerprint::text(Types::Native.token(Fingerprint::<B>::HASH)),
        fingerprint::text(Types::Wide.token(Fingerprint::<B>::HASH)),
    ];

    /// The identifier in this form.
    pub const fn text(form: Form) -> &'static [u8; 38] {
        match form {
            Form::Guid => &Self::TEXT_BYTES,
            Form::Token(Types::Native) => &Self::TOKENS[0],
            Form::Token(Types::Wide) => &Self::TOKENS[1],
        }
    }

    /// The GUID as in modelDescription.xml.
    pub const TEXT: &'static str = match std::str::from_utf8(&Self::TEXT_BYTES) {
        Ok(text) => text,
        Err(_) => "",
    };
}

/// Identifies the code from which a block's library is compiled: a hash of the sources of this crate, of `blocks`, and
/// of the block's crate. Unlike the GUID, it changes with the law.
pub struct Code<B>(PhantomData<B>);

impl<B: Block> Code<B> {
    const TEXT_BYTES: Option<[u8; 38]> = match (option_env!("PLCFMU_CODE"), blocks::CODE, B::CODE) {
        (Some(fmu), Some(blocks), Some(own)) => {
            Some(fingerprint::text(text_hash(text_hash(text_hash(BASIS, fmu), blocks), own)))
        }
        _ => None,
    };

    /// The hash in the form of a GUID; `None` if it is unknown for one of the crates. The library file built with
    /// [`export!`](crate::export) contains it.
    pub const TEXT: Option<&'static str> = match &Self::TEXT_BYTES {
        Some(bytes) => match std::str::from_utf8(bytes) {
            Ok(text) => Some(text),
            Err(_) => None,
        },
        None => None,
    };
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
        Some(Value::Whole(kind, bits)) => hash(hash(state, &[7, kind as u8]), &bits.to_le_bytes()),
    }
}

/// Hashes the names of the outer instances, padded with empty ones to three, and then the variable's own name.
const fn name_hash(mut state: u128, name: &str) -> u128 {
    let mut bytes = name.as_bytes();
    let mut instances = 0;
    let mut i = 0;
    while i < bytes.len() {
        if bytes[i] == b'.' {
            let (instance, rest) = bytes.split_at(i);
            state = hash(hash(state, instance), &[0]);
            bytes = rest.split_at(1).1;
            instances += 1;
            i = 0;
        } else {
            i += 1;
        }
    }
    while instances < 3 {
        state = hash(state, &[0]);
        instances += 1;
    }
    hash(hash(state, bytes), &[0])
}

const fn row_hash(mut state: u128, row: &StaticRow) -> u128 {
    state = name_hash(state, row.name);
    state = hash(state, &[row.kind as u8, row.role as u8]);
    state = value_hash(state, Some(row.start));
    state = value_hash(state, row.min);
    state = value_hash(state, row.max);
    state = text_hash(state, if let Some(unit) = row.unit { unit } else { "" });
    state = hash(state, &[row.from.len() as u8]);
    let mut i = 0;
    while i < row.from.len() {
        state = hash(state, &(row.from[i] as u32).to_le_bytes());
        i += 1;
    }
    state
}

const fn table_hash(mut state: u128, table: &StaticTable) -> u128 {
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

/// The table as a JSON object: name, aliases, documentation, the row numbers of the cycle and the mean, the variables
/// in the order of the rows, the texts, the responses, the characteristics and the default unit of their drawings.
/// Values are plain numbers: a TIME in seconds, TRUE as 1. A variable whose restart value depends on settings lists
/// them in `from`.
pub fn json<S: TableText>(table: &Table<S>) -> String {
    let mut json = String::new();
    let _ = write!(
        json,
        r#"{{"name":{},"aliases":[{}],"docs":{},"cycle":{},"mean":{},"variables":["#,
        quoted(&table.name),
        list(&table.aliases, |alias| quoted(alias)),
        quoted(&table.docs),
        table.cycle,
        optional(table.mean.map(|mean| mean.to_string()))
    );
    for (i, row) in table.rows.iter().enumerate() {
        let from: Vec<String> = row.from.iter().map(|setting| quoted(&table.rows[*setting].name)).collect();
        let _ = write!(
            json,
            r#"{}{{"name":{},"description":{}{},"kind":"{}"{},"role":"{}","start":{:?}{},"min":{},"max":{},"unit":{}{}}}"#,
            if i == 0 { "" } else { "," },
            quoted(&row.name),
            quoted(&row.description),
            if row.help.is_empty() { String::new() } else { format!(r#","help":{}"#, quoted(&row.help)) },
            row.kind.name(),
            if row.is_analog { r#","analog":true"# } else { "" },
            row.role.name(),
            number(row.start),
            beyond_number(row.start).map_or_else(String::new, |exact| format!(r#","exact":{exact}"#)),
            optional(row.least().map(|min| format!("{min:?}"))),
            optional(row.greatest().map(|max| format!("{max:?}"))),
            optional(row.unit.as_deref().map(quoted)),
            if from.is_empty() { String::new() } else { format!(r#","from":[{}]"#, from.join(",")) },
        );
    }
    let texts = list(&table.texts, |text| {
        format!(
            r#"{{"name":{},"description":{},"type":{},"role":"{}","start":{}}}"#,
            quoted(&text.name),
            quoted(&text.description),
            quoted(&text.ty.name()),
            text.role.name(),
            quoted(&text.start),
        )
    });
    let texts = if texts.is_empty() { String::new() } else { format!(r#","texts":[{texts}]"#) };
    let responses = list(&table.responses, |response| {
        format!(
            r#"{{"title":{},"calls":{},"set":[{}],"show":[{}]}}"#,
            quoted(&response.title),
            response.calls,
            list(&response.set, |(call, name, value)| format!("[{call},{},{value:?}]", quoted(name))),
            list(&response.show, |name| quoted(name)),
        )
    });
    let characteristics = list(&table.characteristics, |characteristic| {
        let (from, to) = characteristic.range;
        format!(
            r#"{{"title":{},"variable":{},"range":[{from:?},{to:?}],"points":{},"calls":{},"set":[{}],"show":[{}]}}"#,
            quoted(&characteristic.title),
            quoted(&characteristic.variable),
            characteristic.points,
            characteristic.calls,
            list(&characteristic.set, |(name, value)| format!("[{},{value:?}]", quoted(name))),
            list(&characteristic.show, |name| quoted(name)),
        )
    });
    let drawn_unit =
        table.drawn_unit.as_ref().map_or_else(String::new, |unit| format!(r#","drawn_unit":{}"#, quoted(unit)));
    let _ = write!(json, r#"]{texts},"responses":[{responses}],"characteristics":[{characteristics}]{drawn_unit}}}"#);
    json
}

fn list<T>(items: &[T], text: impl Fn(&T) -> String) -> String {
    items.iter().map(text).collect::<Vec<_>>().join(",")
}

fn optional(text: Option<String>) -> String {
    text.unwrap_or_else(|| "null".into())
}

/// The text as a JSON string.
pub(crate) fn quoted(text: &str) -> String {
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
    use crate::test_block::Sum;

    #[test]
    fn everything_a_host_relies_on_is_in_the_fingerprint() {
        let row = Sum::TABLE.rows[0];
        let of = |row: StaticRow| row_hash(BASIS, &row);
        let same = of(row);
        assert_ne!(of(StaticRow { name: "OTHER", ..row }), same, "name");
        assert_ne!(of(StaticRow { name: "A.U", ..row }), same, "instance");
        assert_ne!(of(StaticRow { role: blocks::Role::Parameter, ..row }), same, "role");
        assert_ne!(of(StaticRow { kind: blocks::Kind::Int, ..row }), same, "type");
        assert_ne!(of(StaticRow { start: Value::Bool(true), ..row }), same, "start");
        assert_ne!(of(StaticRow { min: Some(Value::Bool(false)), ..row }), same, "min");
        assert_ne!(of(StaticRow { max: Some(Value::Bool(false)), ..row }), same, "max");
        assert_ne!(of(StaticRow { unit: Some("s"), ..row }), same, "unit");
        assert_ne!(of(StaticRow { from: &[4], ..row }), same, "settings of the restart value");
        assert_ne!(of(StaticRow { from: &[4], ..row }), of(StaticRow { from: &[3], ..row }), "which settings");
        assert_eq!(of(StaticRow { description: "in other words", ..row }), same, "its description is not");
    }

    #[test]
    fn the_memory_that_a_state_is_made_of_is_in_the_fingerprint() {
        let table = |memory| StaticTable { memory, ..*Sum::TABLE };
        assert_ne!(table_hash(BASIS, &table(&[("a", "Real")])), table_hash(BASIS, &table(&[("a", "LReal")])));
        assert_ne!(table_hash(BASIS, &table(&[("a", "Real")])), table_hash(BASIS, &table(&[("b", "Real")])));
    }

    #[test]
    fn the_instances_that_a_state_is_made_of_are_in_the_fingerprint() {
        const fn table(name: &'static str, instances: &'static [&'static StaticTable]) -> StaticTable {
            StaticTable { name, instances, ..*Sum::TABLE }
        }
        const A: &StaticTable = &table("A", &[]);
        const B: &StaticTable = &table("B", &[]);
        let of = |instances| table_hash(BASIS, &table("X", instances));
        let all = [of(&[]), of(&[A]), of(&[B]), of(&[A, A]), of(&[A, B]), of(&[B, A])];
        for (i, one) in all.iter().enumerate() {
            assert!(!all[..i].contains(one), "case {i}");
        }
    }

    #[test]
    fn a_limit_of_a_real_holds_its_decimal_and_itself() {
        // The REAL next to 0.1 lies above it, the one next to 0.7 below.
        let row =
            |limit| StaticRow { min: Some(Value::Real(limit)), max: Some(Value::Real(limit)), ..StaticRow::EMPTY };
        let limits = |limit| (row(limit).least().unwrap(), row(limit).greatest().unwrap());
        assert_eq!(limits(0.1), (0.1, 0.10000000149011612));
        assert_eq!(limits(0.7), (0.699999988079071, 0.7));
        assert_eq!(limits(f32::MAX).1, 3.4028235e38);
        assert!(json(Sum::TABLE).contains(r#""start":1.0,"min":0.1,"max":10.0"#));
    }

    #[test]
    fn the_guid_has_the_form_of_one() {
        let guid = Guid::<Sum>::TEXT;
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
    fn a_variable_is_written_with_the_names_of_its_type_and_role() {
        let json = json(Sum::TABLE);
        assert!(json.starts_with(r#"{"name":"SUM","aliases":[],"docs":" Adds up its inputs"#), "{json}");
        assert!(json.contains(r#""cycle":5,"mean":8,"variables":[{"name":"U","description":"Summand","kind":"REAL","#));
        assert!(
            json.contains(r#""name":"FIRST","description":"Refused below 0","kind":"INT","role":"fixed","start":0.0"#)
        );
        assert!(json.contains(r#""kind":"TIME","role":"cycle","start":0.1,"min":0.001,"max":null,"unit":null}"#));
        assert!(
            json.contains(r#""name":"COUNT","description":"Calls since the restart","kind":"INT","role":"output","#)
        );
        assert!(json.contains(r#""unit":null,"from":["FIRST"]},{"name":"Q_MEAN""#), "{json}");
        assert!(json.ends_with(
            r#""responses":[{"title":"At rest, with all defaults","calls":60,"set":[],"show":[]}],"characteristics":[]}"#
        ));
    }

    #[test]
    fn texts_are_quoted_for_json() {
        assert_eq!(quoted("a \"b\" \\ \n°"), "\"a \\\"b\\\" \\\\ \\u000a°\"");
    }
}
