//! FMI 3.0: the elements of its modelDescription.xml, the mapping of a block's table to it, and the description of an
//! FMU read from it.
//!
//! As for FMI 2.0: [`ModelDescription`] is plain data, [`write()`] turns it into XML, [`read()`] reads any model
//! description of FMI 3.0, and [`check()`] finds mistakes that a schema does not find.

mod build_description;
mod check;
mod describe;
mod description;
mod mapping;
mod variable;

use crate::error::Error;
use crate::xml::attributes::Element;
pub use crate::xml::read::Limits;
use crate::xml::read::{MODEL_DESCRIPTION, Schema, read_root};
pub use build_description::{
    BUILD_DESCRIPTION, BuildConfiguration, BuildDescription, PreprocessorDefinition, SourceFile, SourceFileSet,
};
pub use check::check;
pub use description::*;
pub use mapping::token;

const SCHEMA: Schema =
    Schema { version: FMI_VERSION, root: MODEL_DESCRIPTION, variables: Variable::NAMES, skipped: Some("Annotations") };

/// Reads a modelDescription.xml of FMI 3.0, made by any tool.
///
/// Reads all elements and attributes of the schema of FMI 3.0, in any order. Annotations and attributes of other
/// namespaces are skipped.
///
/// # Errors
/// The file is malformed or contradicts itself: one sentence with the line.
pub fn read(bytes: &[u8]) -> Result<ModelDescription, Error> {
    read_root(bytes, Limits::default(), SCHEMA, |description| {
        let mut first = None;
        check::contradictions(description, &mut |variable, sentence| {
            first.get_or_insert((variable, sentence));
        });
        first
    })
}

/// Writes a modelDescription.xml: elements and attributes in the order of the standard's schema, without empty lists or
/// a namespace, and with a date only if the description has one. The same description always yields the same bytes.
pub fn write(description: &ModelDescription) -> Vec<u8> {
    crate::xml::write::write(description)
}
