//! Replaces values in a source; everything else is preserved byte for byte.

use crate::loops::{Loop, MemberValue, Origin};
use crate::problem::quoted;
use crate::step7::member_path;
use crate::value::{decimal, text};
use crate::{BlockType, Format, Options, Source, literal, read};
use blocks::Value;
use std::ops::Range;
use std::sync::Arc;

/// A replaced value.
#[derive(Clone, Debug, PartialEq)]
pub struct Replaced {
    /// The name of the loop.
    pub loop_name: String,
    /// The name of the member.
    pub member: String,
    /// The previous origin of the value; [`Origin::Default`] if the source did not contain it.
    pub origin: Origin,
}

/// Writes the values of these loops into the source, and returns the source and the replaced values. A value that
/// already agrees is left as written. A member without a value in the source is inserted next to another member of its
/// loop.
///
/// # Errors
/// The source cannot be read, does not contain one of the loops, or has no place for a value; the message is a
/// sentence.
pub fn rewrite(
    format: Format,
    source: &Source,
    blocks: &[Arc<BlockType>],
    options: &Options,
    loops: &[Loop],
) -> Result<(Vec<u8>, Vec<Replaced>), String> {
    if format == Format::Dump {
        return Err(format!("{} is a data block dump, which has no text to change", source.file));
    }
    let wrong = |_| format!("{} can no longer be read", source.file);
    let before = read(format, source, blocks, options).map_err(wrong)?.loops;
    let (mut edits, mut replaced) = (Vec::new(), Vec::new());
    for one in loops {
        let is_it = |other: &&Loop| other.name == one.name && other.block.name == one.block.name;
        let own = before.iter().find(is_it);
        let own =
            own.ok_or_else(|| format!("{} has no loop {} of type {}", source.file, quoted(&one.name), one.block.name))?;
        for (setting, old) in one.settings.iter().zip(&own.settings) {
            if same(setting.value, old.value) {
                continue;
            }
            let member = one.block.members[setting.member].name.as_str();
            let edit = edit(format, source, own, old, setting.value);
            edits.push(edit.ok_or_else(|| {
                format!(
                    "{} has no replaceable value of {member} in {}: write a new parameter file",
                    source.file, one.name
                )
            })?);
            replaced.push(Replaced { loop_name: one.name.clone(), member: member.into(), origin: old.origin.clone() });
        }
    }
    let bytes = edited(source, edits)
        .ok_or_else(|| format!("the encoding of {} lacks a character: write a new parameter file", source.file))?;
    // The result is read back before it is returned, to verify that the values are where they belong.
    let result = Source::in_encoding(source.file.clone(), bytes.clone(), source.encoding);
    let after = read(format, &result, blocks, options).map_err(wrong)?.loops;
    let wanted = |own: &Loop| {
        let one = loops.iter().find(|one| one.name == own.name && one.block.name == own.block.name);
        one.unwrap_or(own).settings.iter().map(|setting| setting.value).collect::<Vec<_>>()
    };
    let is_right = before.len() == after.len()
        && before.iter().zip(&after).all(|(own, read)| {
            let read_values = read.settings.iter().map(|setting| setting.value);
            own.name == read.name && wanted(own).into_iter().zip(read_values).all(|(a, b)| same(a, b))
        });
    if is_right {
        Ok((bytes, replaced))
    } else {
        Err(format!("{} is written in a way that cannot be changed in place: write a new parameter file", source.file))
    }
}

fn same(a: Value, b: Value) -> bool {
    literal::text(a) == literal::text(b)
}

/// A range of the text, and its replacement.
type Edit = (Range<usize>, String);

fn edit(format: Format, source: &Source, own: &Loop, old: &MemberValue, value: Value) -> Option<Edit> {
    let Origin::Text { span, .. } = &old.origin else { return inserted(format, source, own, old.member, value) };
    let written = source.text.get(span.clone())?;
    if format == Format::Ssv {
        // The location covers the whole element.
        let at = value_of_attribute(written, "value")?;
        return Some((span.start + at.start..span.start + at.end, text(value).ok()?));
    }
    Some((span.clone(), as_written(format, written, value)?))
}

/// A value in the notation of the value it replaces.
fn as_written(format: Format, written: &str, value: Value) -> Option<String> {
    if format == Format::Json {
        return text(value).ok();
    }
    let exact = literal::text(value);
    let short = decimal(value);
    if !matches!(value, Value::Real(_) | Value::LReal(_)) {
        return Some(exact);
    }
    if written.contains(['e', 'E']) {
        let shortest = match value {
            Value::Real(real) => format!("{real:e}"),
            Value::LReal(real) => format!("{real:e}"),
            _ => exact.clone(),
        };
        return Some(literal::like(&shortest, written).unwrap_or(exact));
    }
    let reads_back = literal::parse(&short, value.kind()).is_ok_and(|read| same(read, value));
    Some(if reads_back && !short.contains(['e', 'E']) { short } else { exact })
}

/// The range of an attribute's value in a start tag, without its quotes.
fn value_of_attribute(tag: &str, name: &str) -> Option<Range<usize>> {
    let mut from = 0;
    while let Some(at) = tag[from..].find(name).map(|at| at + from) {
        let rest = &tag[at + name.len()..];
        let equals = rest.trim_start();
        let is_name = tag[..at].ends_with(|before: char| before.is_whitespace()) && equals.starts_with('=');
        if is_name {
            let after = equals[1..].trim_start();
            let quote = after.chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
            let start = tag.len() - after.len() + 1;
            return Some(start..start + after[1..].find(quote)?);
        }
        from = at + name.len();
    }
    None
}

/// Inserts a missing value next to the value of another member of the loop.
fn inserted(format: Format, source: &Source, own: &Loop, member: usize, value: Value) -> Option<Edit> {
    let is_given = |setting: &&MemberValue| matches!(setting.origin, Origin::Text { .. });
    let before = own.settings.iter().rev().filter(|setting| setting.member < member).find(is_given);
    let beside = before.or_else(|| own.settings.iter().find(is_given))?;
    let Origin::Text { span, .. } = &beside.origin else { return None };
    let name = own.block.members[member].name.as_str();
    let neighbour = own.block.members[beside.member].name.as_str();
    let text = &source.text;
    let start = text[..span.start].rfind('\n').map_or(0, |end| end + 1);
    let left = &text[start..span.start];
    let indent = &left[..left.len() - left.trim_start().len()];
    let end = text[span.end..].find('\n').map(|end| span.end + end)?;
    let line_end = if text[..end].ends_with('\r') { "\r\n" } else { "\n" };
    match format {
        Format::Json => {
            let key = serde_json::Value::from(name).to_string();
            let is_alone = left.trim_start().starts_with('"');
            let between = if is_alone { format!(",{line_end}{indent}") } else { ", ".into() };
            Some((span.end..span.end, format!("{between}{key}: {}", as_written(format, "", value)?)))
        }
        Format::Step7 | Format::Tia => {
            let path = left.trim().strip_suffix(":=")?.trim_end();
            if path.contains([';', ':', '{']) {
                return None;
            }
            // The member's name is preceded by the path of the instance.
            let plain: String = path.chars().filter(|letter| *letter != '"').collect();
            let leads = plain.len().checked_sub(neighbour.len())?;
            let is_it = plain.is_char_boundary(leads) && plain[leads..].eq_ignore_ascii_case(neighbour);
            let parts = plain.get(..leads)?.matches('.').count();
            let prefix: String = path.split_inclusive('.').take(parts).collect();
            let value = as_written(format, "", value)?;
            let line = format!("{indent}{prefix}{} := {value};{line_end}", member_path(name));
            is_it.then_some((end + 1..end + 1, line))
        }
        _ => None,
    }
}

/// The bytes of a source with replacements in its text.
fn edited(source: &Source, mut edits: Vec<Edit>) -> Option<Vec<u8>> {
    edits.sort_by_key(|(range, _)| range.start);
    let (mut bytes, mut at) = (source.bytes[..source.start].to_vec(), 0);
    let mut from = source.start;
    for (range, text) in edits {
        let kept = source.encoding.encode(source.text.get(at..range.start)?)?.len();
        let old = source.encoding.encode(&source.text[range.clone()])?.len();
        bytes.extend(source.bytes.get(from..from + kept)?);
        bytes.extend(source.encoding.encode(&text)?);
        (at, from) = (range.end, from + kept + old);
    }
    bytes.extend(source.bytes.get(from..)?);
    Some(bytes)
}

#[cfg(test)]
mod tests;
