//! Names by which the columns of a recording are recognized.

/// Names of the setpoint, in upper case like all names below.
pub const SETPOINTS: [&str; 4] = ["SP", "SETPOINT", "SET POINT", "SOLLWERT"];
/// Names of the process value.
pub const PROCESS_VALUES: [&str; 5] = ["PV", "PV_IN", "PROCESS VALUE", "PROCESS VARIABLE", "ISTWERT"];
/// Names of the manipulated value.
pub const MANIPULATED_VALUES: [&str; 8] = ["LMN", "MV", "OUT", "OUTPUT", "CO", "OP", "MANIPULATED VALUE", "STELLWERT"];
/// Names of the switch to manual mode.
pub const MANUAL: [&str; 5] = ["MAN_ON", "MANUAL", "HAND", "MANUAL MODE", "MAN_MODE"];

/// Returns the parts of a column name that may be the name of a variable, from the whole name to its last part:
/// `PLC.TIC101.in_GAIN`, `TIC101.in_GAIN`, ..., `GAIN`.
pub fn ends(name: &str) -> impl Iterator<Item = &str> {
    let is_separator = |letter: char| matches!(letter, '.' | '/' | '\\' | ':' | '|');
    let after = move |(at, letter): (usize, char)| is_separator(letter).then(|| &name[at + letter.len_utf8()..]);
    let all = std::iter::once(name).chain(name.char_indices().filter_map(after));
    all.map(|name| name.trim().trim_matches('"').trim())
}

/// Returns the last part of a column name, see [`ends`], in upper case.
pub fn short_name(name: &str) -> String {
    ends(name).last().unwrap_or_default().to_uppercase()
}
