//! Writes source texts with the values of loops.

use crate::encoding::Encoding;
use crate::literal;
use crate::loops::Loop;
use crate::problem::quoted;
use blocks::{Kind, Value};
use std::collections::HashSet;

/// The maximum length of a data block name in the STEP 7 symbol table, in characters.
const LONGEST_SYMBOL: usize = 24;

/// The maximum length of a data block name in TIA Portal, in characters.
const LONGEST_NAME: usize = 125;

/// Possible member names that have a different meaning in AWL or SCL.
const RESERVED: [&str; 40] = [
    "A", "AN", "AND", "AR", "BEGIN", "CALL", "CASE", "CLR", "D", "DI", "DIV", "DO", "EXIT", "F", "FALSE", "FOR", "FP",
    "I", "IF", "L", "M", "MOD", "NOT", "O", "ON", "OR", "Q", "R", "RETURN", "S", "SET", "STOP", "T", "TAR", "TITLE",
    "TRUE", "U", "UN", "X", "XOR",
];

/// Writes an AWL source for STEP 7, in Windows-1252: an instance data block for each loop, with all inputs and
/// parameters. A comment states the `origin`.
///
/// # Errors
/// STEP 7 cannot represent the loops: one sentence that states why.
pub fn write(loops: &[Loop], origin: &str) -> Result<Vec<u8>, String> {
    check(loops, LONGEST_SYMBOL, "STEP 7")?;
    let mut text = comment(origin);
    for one in loops {
        if let Some(member) =
            one.block.members.iter().find(|member| member.kind == Kind::LReal && member.role.is_settable())
        {
            let (name, member) = (&one.name, &member.name);
            return Err(format!(
                "{name}: {member} is an LREAL, which STEP 7 does not support; write a source for TIA Portal"
            ));
        }
        let block = one.block.aliases.iter().find(|alias| alias.starts_with("FB "));
        let block = block.cloned().unwrap_or_else(|| format!("\"{}\"", one.block.name));
        let name = match one.name.strip_prefix("DB") {
            Some(number) if is_number(number) => format!("DB {number}"),
            _ => format!("\"{}\"", one.name),
        };
        data_block(&mut text, one, &name, &["TITLE =", "VERSION : 0.1"], &block)?;
    }
    // Only a name can have a character outside the encoding: comments have `?` in its place.
    let bytes = Encoding::Windows1252.encode(&text).ok_or(
        "a name has characters that STEP 7 does not support: rename the loop, or write a source for TIA Portal",
    )?;
    if !text.is_ascii() && std::str::from_utf8(&bytes).is_ok() {
        return Err("the names would be read as UTF-8: rename the loops, or write a source for TIA Portal".into());
    }
    Ok(bytes)
}

/// Writes an external source for TIA Portal: an instance data block for each loop, with all inputs and parameters. The
/// text starts with a byte order mark, from which TIA Portal recognizes UTF-8.
///
/// # Errors
/// TIA Portal cannot represent the loops: one sentence that states why.
pub fn write_tia(loops: &[Loop], origin: &str) -> Result<String, String> {
    check(loops, LONGEST_NAME, "TIA Portal")?;
    let mut text = format!("\u{feff}{}", comment(origin));
    for one in loops {
        // Blocks with a number belong to the system, all others to the user.
        let block = match one.block.aliases.as_slice() {
            [] => format!("\"{}\"", one.block.name),
            _ => one.block.name.clone(),
        };
        let header = ["{ S7_Optimized_Access := 'FALSE' }", "VERSION : 0.1", "NON_RETAIN"];
        data_block(&mut text, one, &format!("\"{}\"", one.name), &header, &block)?;
    }
    Ok(text)
}

/// Rejects names that a source cannot contain.
fn check(loops: &[Loop], longest: usize, tool: &str) -> Result<(), String> {
    let mut names = HashSet::new();
    for Loop { name, .. } in loops {
        let shown = quoted(name);
        if name.is_empty() || name.contains(|c: char| c.is_control() || c == '"') {
            return Err(format!(
                "{shown} is not a valid data block name: it is empty, or contains a quote or a control character"
            ));
        }
        if name.chars().count() > longest {
            return Err(format!("{shown} is too long: {tool} accepts names of at most {longest} characters"));
        }
        if !names.insert(name.to_uppercase()) {
            return Err(format!("two loops are named {shown}: {tool} ignores case"));
        }
    }
    Ok(())
}

fn data_block(text: &mut String, one: &Loop, name: &str, header: &[&str], block: &str) -> Result<(), String> {
    text.push_str(&format!("\nDATA_BLOCK {name}\n"));
    for line in header {
        text.push_str(line);
        text.push('\n');
    }
    text.push_str(&format!("{block}\nBEGIN\n"));
    for setting in &one.settings {
        let member = &one.block.members[setting.member];
        if !member.role.is_settable() {
            continue;
        }
        let is_finite = match setting.value {
            Value::Real(real) => real.is_finite(),
            Value::LReal(real) => real.is_finite(),
            _ => true,
        };
        if !is_finite {
            let value = literal::text(setting.value);
            return Err(format!("{}: {} is {value}, which a source text cannot represent", one.name, member.name));
        }
        text.push_str(&format!("   {} := {};\n", path(&member.name), literal::text(setting.value)));
    }
    text.push_str("END_DATA_BLOCK\n");
    Ok(())
}

/// The name of a member, quoted where necessary.
pub(crate) fn path(name: &str) -> String {
    let part = |part: &str| {
        let is_plain = part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && !part.starts_with(|c: char| c.is_ascii_digit())
            && !RESERVED.contains(&part.to_ascii_uppercase().as_str());
        if is_plain { part.to_string() } else { format!("\"{part}\"") }
    };
    name.split('.').map(part).collect::<Vec<_>>().join(".")
}

/// Whether a string is a data block number in STEP 7's notation.
fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit()) && (text == "0" || !text.starts_with('0'))
}

/// The lines of a text as comments; characters outside Windows-1252 become `?`.
fn comment(origin: &str) -> String {
    let is_held = |c: &char| Encoding::Windows1252.encode(c.encode_utf8(&mut [0; 4])).is_some();
    let plain = |line: &str| -> String {
        line.chars().filter(|c| !c.is_control()).map(|c| if is_held(&c) { c } else { '?' }).collect()
    };
    origin.lines().map(|line| format!("// {}\n", plain(line).trim_end())).collect()
}
