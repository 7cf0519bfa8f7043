//! The modelDescription.xml of an FMU after FMI 2.0: made from a block's table, written, read back and checked.
//!
//! ```text
//! library --JSON--> Interface --ModelDescription::of--> ModelDescription --write--> XML
//!                                                             ^                      |
//!                                                             +--------- read -------+
//! ```
//!
//! [`ModelDescription`] is plain data. [`write()`] makes XML of it, the same bytes each time; [`read()`] takes any model
//! description of FMI 2.0, whatever tool made it, and refuses with one sentence what is damaged or hostile; [`check()`]
//! finds what a schema does not.
//!
//! ```
//! use modeldescription::{Interface, ModelDescription, check, read, write};
//!
//! let json = r#"{
//!     "name": "COUNTER", "docs": "Counts its calls.", "guid": "{0}", "cycle": 0,
//!     "variables": [
//!         {"name": "CYCLE", "description": "Time between two calls", "kind": "Time", "role": "Cycle",
//!          "start": 0.1, "min": 0.001, "max": null, "unit": null},
//!         {"name": "COUNT", "description": "Calls so far", "kind": "Int", "role": "Output",
//!          "start": 0.0, "min": null, "max": null, "unit": null}],
//!     "response": {"title": "Ten calls", "calls": 10, "set": [], "show": ["COUNT"]}
//! }"#;
//! let description = ModelDescription::of(&Interface::parse(json)?)?;
//! assert_eq!(check(&description), Vec::<String>::new());
//! assert_eq!(read(&write(&description))?, description);
//! # Ok::<(), modeldescription::Error>(())
//! ```
//!
//! The crate knows FMI and XML, and no block. It reads and writes memory only.

mod check;
mod description;
mod error;
pub mod interface;
mod lexical;
mod mapping;
mod read;
pub mod units;
mod write;

pub use check::{MOST_FINDINGS, check};
pub use description::*;
pub use error::{Error, shortened};
pub use interface::Interface;
pub use read::{Limits, read, read_within};
pub use write::write;
