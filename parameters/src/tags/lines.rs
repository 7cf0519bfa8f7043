//! Reads declarations as people write them: `"Start" AT %I0.0 : Bool // Start button`, `MAX : Int := 5`.

use super::{Constant, Tag, Tags, Wrong, address, literal, one_line};

/// A declaration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Declared {
    /// A tag, or an instance of a block.
    Tag(Tag),
    /// A constant.
    Constant(Constant),
}

/// Parses a declaration: a name, optionally quoted; optionally AT and an address; a colon and a type; optionally `:=`
/// and a value, which makes it a constant; and optionally a comment after `//`.
///
/// # Errors
/// The text is not a declaration: what was expected.
///
/// ```
/// use parameters::tags::{Area, Declared, declaration};
/// let Ok(Declared::Tag(tag)) = declaration("\"Level 1\" AT %IW64 : Int // Level; unit: mm") else { panic!() };
/// assert_eq!((tag.name.as_str(), tag.of.as_str(), tag.area()), ("Level 1", "Int", Some(Area::Input)));
/// assert_eq!(tag.to_string(), "\"Level 1\" AT %IW64 : Int // Level; unit: mm");
/// ```
pub fn declaration(text: &str) -> Result<Declared, String> {
    let expected = || "write a name, a colon and a type, such as Start : Bool".to_string();
    let text = text.trim();
    let (name, rest) = match text.strip_prefix('"') {
        Some(quoted) => quoted.split_once('"').ok_or("the quotation mark is not closed")?,
        None => {
            let colon = text.find(':').ok_or_else(expected)?;
            // ASCII upper case preserves all byte offsets.
            let at = text[..colon].to_ascii_uppercase().find(" AT ");
            text.split_at(at.unwrap_or(colon))
        }
    };
    let rest = rest.trim();
    let name = name.trim();
    let (place, rest) = match rest.get(..2).filter(|word| word.eq_ignore_ascii_case("AT")) {
        Some(_) => {
            let (place, rest) = rest[2..].split_once(':').ok_or_else(expected)?;
            let place = address(place)
                .ok_or_else(|| format!("{} is not an input, output or memory address such as %I0.0", place.trim()))?;
            (Some(place), rest)
        }
        None => (None, rest.strip_prefix(':').ok_or_else(expected)?),
    };
    // A string literal may contain two slashes.
    let is_outside = |at: &usize| rest[..*at].matches('\'').count() % 2 == 0;
    let comment = rest.match_indices("//").map(|(at, _)| at).find(is_outside);
    let (rest, comment) = comment.map_or((rest, ""), |at| (&rest[..at], &rest[at + 2..]));
    let rest = rest.trim().trim_end_matches(';');
    let (of, value) = rest.split_once(":=").map_or((rest, None), |(of, value)| (of, Some(value)));
    let of = of.trim().trim_matches('"');
    if name.is_empty() || of.is_empty() || value.is_some_and(|value| value.trim().is_empty()) {
        return Err(expected());
    }
    Ok(match value {
        Some(value) => Declared::Constant(Constant { name: name.into(), value: literal(of, value) }),
        None => Declared::Tag(Tag { name: name.into(), of: of.into(), address: place, comment: one_line(comment) }),
    })
}

/// Reads a list of declarations, one per line, with empty lines and comments allowed.
pub(super) fn read(text: &str) -> Result<Tags, Vec<Wrong>> {
    let mut tags = Tags::default();
    let mut wrong = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let span = start..start + line.trim_end().len();
        start += line.len();
        if line.trim().is_empty() || line.trim_start().starts_with("//") {
            continue;
        }
        match declaration(line) {
            Ok(Declared::Tag(tag)) => tags.tags.push(tag),
            Ok(Declared::Constant(constant)) => tags.constants.push(constant),
            Err(message) => wrong.push((span, format!("{message}; a tag list has one such line per tag"))),
        }
    }
    if wrong.is_empty() { Ok(tags) } else { Err(wrong) }
}
