//! PLC tag tables as exported by TIA Portal and STEP 7: names of inputs, outputs and memory, and constants.
//!
//! | form | written by |
//! |---|---|
//! | XML with `SW.Tags.PlcTagTable` ([`read`]) | TIA Portal Openness, version control interface |
//! | `.sdf`: quoted strings separated by commas ([`read`]) | *Export* of a tag table, STEP 7 symbol table |
//! | sheets with the headings *Name*, *Data Type*, *Logical Address*, *Comment*, *Value* ([`of_sheet`]) | *Export* to Excel |
//! | `"Start" AT %I0.0 : Bool // Start button`, one per line ([`read`], [`declaration`]) | people, and [`Tag`]'s `Display` |

mod lines;
mod openness;
mod sdf;
mod sheet;
pub mod workbook;

use crate::problem::{Problem, Problems, quoted};
use crate::source::Source;
use std::fmt;
use std::ops::Range;

pub use lines::{Declared, declaration};
pub use sheet::of_sheet;

/// The maximum number of tags and constants in a table, which is more than a CPU can hold.
pub const MOST: usize = 100_000;

/// A tag.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tag {
    /// Its name, without quotation marks.
    pub name: String,
    /// Its type as written, without quotation marks: `Bool`, `Real`, or the name of a PLC data type.
    pub of: String,
    /// Its address with a percent sign, in international mnemonics: `%I0.0`, `%QW4`, `%MD20`. `%I*` specifies only the
    /// area.
    pub address: Option<String>,
    /// The author's comment on it, on one line.
    pub comment: String,
}

/// The memory area of a tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Area {
    /// The process image of inputs, or the inputs themselves.
    Input,
    /// The process image of outputs, or the outputs themselves.
    Output,
    /// Bit memory.
    Memory,
}

/// A user constant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Constant {
    /// Its name, without quotation marks.
    pub name: String,
    /// Its value as a literal of its type: `Int#5`, `T#2s`, `'text'`.
    pub value: String,
}

/// The tags and constants of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tags {
    /// The tags, in file order.
    pub tags: Vec<Tag>,
    /// The constants, in file order.
    pub constants: Vec<Constant>,
}

impl Tag {
    /// A tag with only a name and a type.
    pub fn new(name: impl Into<String>, of: impl Into<String>) -> Tag {
        Tag { name: name.into(), of: of.into(), ..Tag::default() }
    }

    /// Its memory area, if it has an address.
    pub fn area(&self) -> Option<Area> {
        self.address.as_deref().and_then(area)
    }
}

/// The memory area of an address in international mnemonics.
pub fn area(address: &str) -> Option<Area> {
    match address.as_bytes() {
        [b'%', b'I', ..] => Some(Area::Input),
        [b'%', b'Q', ..] => Some(Area::Output),
        [b'%', b'M', ..] => Some(Area::Memory),
        _ => None,
    }
}

impl fmt::Display for Tag {
    /// Displays the line that [`declaration`] parses.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "\"{}\"", self.name)?;
        self.address.iter().try_for_each(|address| write!(formatter, " AT {address}"))?;
        write!(formatter, " : {}", self.of)?;
        match self.comment.is_empty() {
            true => Ok(()),
            false => write!(formatter, " // {}", self.comment),
        }
    }
}

/// An address in international mnemonics, with a percent sign: `%IW64` for `PEW 64`, `%IW64:P` and `E W64`; `None` if
/// it is not an input, output or memory address.
pub fn address(text: &str) -> Option<String> {
    let plain: String = text.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_ascii_uppercase();
    let plain = plain.trim_start_matches('%');
    let plain = plain.strip_suffix(":P").unwrap_or(plain);
    // STEP 7 peripheral inputs and outputs.
    let plain = plain.strip_prefix('P').unwrap_or(plain);
    let mut rest = plain.chars();
    let area = match rest.next()? {
        'I' | 'E' => 'I',
        'Q' | 'A' => 'Q',
        'M' => 'M',
        _ => return None,
    };
    let rest = rest.as_str();
    let digits = rest.trim_start_matches(['X', 'B', 'W', 'D', 'L']);
    let (byte, bit) = digits.split_once('.').unwrap_or((digits, "0"));
    let is_number = byte.bytes().all(|digit| digit.is_ascii_digit())
        && byte.parse::<u32>().is_ok()
        && matches!(bit.as_bytes(), [b'0'..=b'7'])
        && rest.len() - digits.len() <= 1;
    (is_number || rest == "*").then(|| format!("%{area}{rest}"))
}

/// The letter of the area and the bits (8 per byte, from the start of the area) covered by an address in the form that
/// [`address`] returns; `None` for an area without an address.
pub fn bits(address: &str) -> Option<(char, Range<u64>)> {
    let mut letters = address.trim_start_matches('%').chars();
    let (area, rest) = (letters.next()?, letters.as_str());
    let digits = rest.trim_start_matches(char::is_alphabetic);
    let width = match rest.chars().next()? {
        'B' => 8,
        'W' => 16,
        'D' => 32,
        'L' => 64,
        _ => 1,
    };
    let (byte, bit) = digits.split_once('.').unwrap_or((digits, "0"));
    let first = byte.parse::<u64>().ok()? * 8 + bit.parse::<u64>().ok()?;
    Some((area, first..first + width))
}

/// The address of a tag in a table, if it has one; S5 timers and counters have none, because they are in separate
/// areas.
fn address_of(name: &str, written: &str) -> Result<Option<String>, String> {
    let number = written.trim().trim_start_matches('%').strip_prefix(['T', 't', 'C', 'c', 'Z', 'z']).map(str::trim);
    let is_s5 = number.is_some_and(|number| number.parse::<u32>().is_ok());
    match address(written) {
        None if !written.trim().is_empty() && !is_s5 => Err(format!(
            "the address {} of {} is not an input, output or memory address such as %I0.0 or %QW4",
            quoted(written.trim()),
            quoted(name)
        )),
        address => Ok(address),
    }
}

/// A comment joined into one line.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A constant's value as a literal of its type: 5 as an Int is `Int#5`.
fn literal(of: &str, value: &str) -> String {
    let value = value.trim();
    // Some tools write a decimal comma.
    let is_real = of.eq_ignore_ascii_case("real") || of.eq_ignore_ascii_case("lreal");
    let value = if is_real { value.replace(',', ".") } else { value.to_string() };
    let is_elementary = !of.is_empty() && of.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    // T#2s and 'text' already have a type; 16#FF has only a base.
    let is_bare = !value.starts_with('\'')
        && (!value.contains('#') || value.starts_with("16#") || value.starts_with("2#") || value.starts_with("8#"));
    if is_elementary && is_bare { format!("{of}#{value}") } else { value }
}

/// A location and the error there.
type Wrong = (std::ops::Range<usize>, String);

/// Reads a table in XML (`.xml`), in STEP 7's symbol table format (`.sdf`), or as one declaration per line.
///
/// # Errors
/// The errors with line and column: damaged XML, a row without a name or type, more than [`MOST`] rows.
pub fn read(source: &Source) -> Result<Tags, Problems> {
    let is = |ending: &str| source.file.rsplit('.').next().is_some_and(|of| of.eq_ignore_ascii_case(ending));
    let found = if is("xml") {
        openness::read(source)
    } else if is("sdf") {
        sdf::read(&source.text)
    } else {
        lines::read(&source.text)
    };
    let found = found.and_then(|tags| match tags.tags.len() + tags.constants.len() {
        count if count > MOST => Err(vec![(0..0, format!("the table has {count} rows: the limit is {MOST}"))]),
        _ => Ok(tags),
    });
    found.map_err(|wrong| {
        let problem = |(span, message)| Problem { place: Some(source.place(span)), message, help: None };
        Problems {
            file: source.file.clone(),
            text: source.text.clone(),
            problems: wrong.into_iter().map(problem).collect(),
        }
    })
}

/// A quick check whether a text is XML with a tag table.
pub fn is_table(text: &str) -> bool {
    text.contains("<SW.Tags.PlcTag")
}

#[cfg(test)]
mod tests;
