//! FMI 2.0: the elements of its modelDescription.xml, the mapping of a block's table to it, and the description of an
//! FMU read from it.
//!
//! ```text
//! Interface --ModelDescription::of--> ModelDescription --write--> XML
//!                  Description <------------ |  ^                  |
//!                                               +------- read -----+
//! ```
//!
//! [`ModelDescription`] is plain data. [`write()`] turns it into XML, always the same bytes; [`read()`] reads any model
//! description of FMI 2.0, whatever tool made it, and refuses damaged or hostile files with one sentence; [`check()`]
//! finds mistakes that a schema does not find.

mod check;
mod describe;
mod description;
mod mapping;

use crate::error::Error;
use crate::xml::attributes::Element;
pub use crate::xml::read::Limits;
use crate::xml::read::{MODEL_DESCRIPTION, Schema, read_root};
pub use check::{Findings, MOST_FINDINGS, check};
pub use description::*;

/// Reads a modelDescription.xml of FMI 2.0, made by any tool.
///
/// Reads all elements and attributes of the schema of FMI 2.0, in any order. Annotations and attributes of other
/// namespaces are skipped.
///
/// Memory is bounded: the default [`Limits`] are checked during reading, and document type declarations are rejected,
/// so that no entity is ever expanded. The time is proportional to the size of the file.
///
/// # Errors
/// One sentence with the line, the element, the attribute, its value and the remedy, for a file that
/// - is not XML, not UTF-8, not a model description, or belongs to another version of FMI;
/// - has elements, attributes or words that FMI 2.0 does not have, lacks required ones, or repeats one;
/// - contradicts itself: a name or unit is defined twice, two inputs or parameters share a value reference, a unit,
///   type or variable does not exist, a range is empty, or a start value is out of range.
pub fn read(bytes: &[u8]) -> Result<ModelDescription, Error> {
    read_within(bytes, Limits::default())
}

/// Reads a modelDescription.xml like [`read()`], with other limits.
///
/// # Errors
/// As [`read()`].
pub fn read_within(bytes: &[u8], limits: Limits) -> Result<ModelDescription, Error> {
    let schema = Schema { version: FMI_VERSION, root: MODEL_DESCRIPTION, variables: Variable::NAMES, skipped: None };
    read_root(bytes, limits, schema, |description| {
        let mut first = None;
        check::contradictions(description, &mut |variable, sentence| {
            first.get_or_insert((variable, sentence));
        });
        first
    })
}

/// Writes a modelDescription.xml: elements and attributes in the order of the standard's schema, without empty lists or
/// a namespace, and with a date only if the description has one. The same description always yields the same bytes.
///
/// Attributes with the standard's default value are omitted, except for capability flags, causality and variability,
/// which a reader of the file wants to see. Characters that XML cannot represent (most control characters) become
/// U+FFFD; [`check()`] reports them.
pub fn write(description: &ModelDescription) -> Vec<u8> {
    crate::xml::write::write(description)
}
