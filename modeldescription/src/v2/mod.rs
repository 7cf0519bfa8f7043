//! FMI 2.0: what a library tells of itself, and modelDescription.xml.
//!
//! ```text
//! library --JSON--> Interface --ModelDescription::of--> ModelDescription --write--> XML
//!                                                             ^                      |
//!                                                             +--------- read -------+
//! ```
//!
//! [`ModelDescription`] is plain data. [`write()`] turns it into XML, always the same bytes; [`read()`] reads any model
//! description of FMI 2.0, whatever tool made it, and refuses damaged or hostile files with one sentence; [`check()`]
//! finds mistakes that a schema does not find.

mod attributes;
mod check;
mod description;
mod interface;
mod lexical;
mod mapping;
mod read;
mod write;

pub use check::{MOST_FINDINGS, check};
pub use description::*;
pub use interface::Interface;
pub use read::{Limits, read, read_within};
pub use write::write;
