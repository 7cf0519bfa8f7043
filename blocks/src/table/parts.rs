//! The parts of [`block!`](crate::block!) that are plain functions, evaluated at compile time.

use crate::table::{Kind, Role, StaticRow, StaticTable, Value};

impl StaticTable {
    /// Returns the number of rows of an inner block: all except the mean, which belongs to a communication step.
    #[doc(hidden)]
    pub const fn inner(&self) -> usize {
        self.rows.len() - self.mean.is_some() as usize
    }
}

#[doc(hidden)]
pub const fn upper<const N: usize>(name: &str) -> [u8; N] {
    let mut bytes = [0; N];
    let mut i = 0;
    while i < N {
        bytes[i] = name.as_bytes()[i].to_ascii_uppercase();
        i += 1;
    }
    bytes
}

#[doc(hidden)]
pub const fn text(bytes: &[u8]) -> &str {
    match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(_) => panic!("a name must be UTF-8"),
    }
}

/// Returns the first line of a variable's documentation.
#[doc(hidden)]
pub const fn short_text(doc: &str) -> &str {
    let (first, rest) = first_line(doc.as_bytes().trim_ascii());
    assert!(
        rest.is_empty() || first_line(rest).0.trim_ascii().is_empty(),
        "a variable's short text must be one line; its help follows after an empty line"
    );
    text(first.trim_ascii())
}

/// Returns the documentation of a variable after its first line.
#[doc(hidden)]
pub const fn help(doc: &str) -> &str {
    text(first_line(doc.as_bytes().trim_ascii()).1.trim_ascii())
}

const fn first_line(bytes: &[u8]) -> (&[u8], &[u8]) {
    let mut end = 0;
    while end < bytes.len() {
        if bytes[end] == b'\n' {
            let (line, rest) = bytes.split_at(end);
            return (line, rest.split_at(1).1);
        }
        end += 1;
    }
    (bytes, &[])
}

#[doc(hidden)]
pub const fn inner_rows(instances: &[&StaticTable]) -> usize {
    let mut rows = 0;
    let mut i = 0;
    while i < instances.len() {
        rows += instances[i].inner();
        i += 1;
    }
    rows
}

#[doc(hidden)]
pub const fn copy(from: &[StaticRow], to: &mut [StaticRow], mut next: usize) -> usize {
    let mut i = 0;
    while i < from.len() {
        to[next] = from[i];
        next += 1;
        i += 1;
    }
    next
}

#[doc(hidden)]
pub const fn tunable<const N: usize>(rows: &[StaticRow; N], kind: Kind) -> [bool; N] {
    let mut tunable = [false; N];
    let mut i = 0;
    while i < N {
        tunable[i] = rows[i].kind as u8 == kind as u8 && matches!(rows[i].role, Role::Input | Role::Parameter);
        i += 1;
    }
    tunable
}

/// Returns the total length, in bytes, of the names that an inner block's rows have in the outer block.
#[doc(hidden)]
pub const fn length(instance: &str, table: &StaticTable) -> usize {
    let mut length = 0;
    let mut i = 0;
    while i < table.inner() {
        length += instance.len() + 1 + table.rows[i].name.len();
        i += 1;
    }
    length
}

/// Returns these names, concatenated: each consists of the instance's name, a dot and the name in the inner block.
#[doc(hidden)]
pub const fn inner_names<const N: usize>(instance: &str, table: &StaticTable) -> [u8; N] {
    let mut names = [b'.'; N];
    let mut rest: &mut [u8] = &mut names;
    let mut i = 0;
    while i < table.inner() {
        let name = table.rows[i].name;
        let (to, next) = rest.split_at_mut(instance.len() + 1 + name.len());
        let (first, last) = to.split_at_mut(instance.len() + 1);
        first.split_at_mut(instance.len()).0.copy_from_slice(instance.as_bytes());
        last.copy_from_slice(name.as_bytes());
        rest = next;
        i += 1;
    }
    names
}

/// Copies the rows of an inner block, with the name (see [`inner_names`]), role and start value that each has in the
/// outer block. Returns the index after the last row.
#[doc(hidden)]
pub const fn nest(
    instance: &str,
    mut names: &'static str,
    table: &StaticTable,
    wired: &[&str],
    starts: &[(&str, Value)],
    to: &mut [StaticRow],
    mut next: usize,
) -> usize {
    let mut found = 0;
    let mut i = 0;
    while i < table.inner() {
        let mut row = table.rows[i];
        // In the outer block, outputs become locals, and the settings have different row numbers.
        row.from = &[];
        row.role = match row.role {
            Role::Input => Role::Parameter,
            Role::Cycle => Role::Fixed,
            Role::Output => Role::Local,
            other => other,
        };
        let mut w = 0;
        while w < wired.len() {
            if row.name.eq_ignore_ascii_case(wired[w]) {
                row.role = Role::Local;
                found += 1;
            }
            w += 1;
        }
        let mut s = 0;
        while s < starts.len() {
            if row.name.eq_ignore_ascii_case(starts[s].0) {
                row.start = starts[s].1;
                found += 1;
            }
            s += 1;
        }
        (row.name, names) = names.split_at(instance.len() + 1 + row.name.len());
        to[next] = row;
        next += 1;
        i += 1;
    }
    assert!(found == wired.len() + starts.len(), "`wired` or `start` names an unknown terminal of the inner block");
    next
}

/// Asserts that only outputs have a `from` and that it lists only settings: a restart value never depends on a signal.
#[doc(hidden)]
pub const fn check_restart_values(rows: &[StaticRow]) {
    let mut i = 0;
    while i < rows.len() {
        let from = rows[i].from;
        assert!(from.is_empty() || matches!(rows[i].role, Role::Output), "`from` is only for outputs");
        let mut s = 0;
        while s < from.len() {
            assert!(
                matches!(rows[from[s]].role, Role::Parameter | Role::Fixed | Role::Cycle),
                "`from` accepts only settings: rows of the sections parameter, fixed and cycle"
            );
            s += 1;
        }
        i += 1;
    }
}

#[doc(hidden)]
pub const fn cycle_row(rows: &[StaticRow]) -> usize {
    let mut cycle = None;
    let mut i = 0;
    while i < rows.len() {
        if matches!(rows[i].role, Role::Cycle) {
            assert!(cycle.is_none(), "a table cannot have two `cycle` rows");
            assert!(matches!(rows[i].kind, Kind::Time), "the `cycle` row must be a Time");
            cycle = Some(i);
        }
        i += 1;
    }
    match cycle {
        Some(i) => i,
        None => panic!("a table needs a `cycle` row: the time between two calls"),
    }
}
