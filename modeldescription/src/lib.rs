//! From a block's table, as its library exports it, to the modelDescription.xml of an FMU, and back.
//!
//! The library tells its block's [`Table`] without naming a version of FMI; what depends on the version is in a module
//! of its own, [`v2`] for FMI 2.0.
//!
//! ```
//! use modeldescription::v2::{Interface, ModelDescription, check, read, write};
//!
//! let json = r#"{
//!     "table": {"name": "COUNTER", "docs": "Counts its calls.", "cycle": 0, "mean": null,
//!         "variables": [
//!             {"name": "CYCLE", "description": "Time between two calls", "kind": "TIME", "role": "cycle",
//!              "start": 0.1, "min": 0.001, "max": null, "unit": null},
//!             {"name": "COUNT", "description": "Calls so far", "kind": "INT", "role": "output",
//!              "start": 0.0, "min": null, "max": null, "unit": null}],
//!         "responses":[{"title": "Ten calls", "calls": 10, "set": [], "show": ["COUNT"]}]},
//!     "interface": {"version": "2.0", "guid": "{0}", "capabilities": {"canGetAndSetFMUstate": true},
//!         "log_categories": [{"name": "logStatusError", "description": "Calls that were refused"}]}
//! }"#;
//! let description = ModelDescription::of(&Interface::parse(json)?)?;
//! assert_eq!(check(&description), Vec::<String>::new());
//! assert_eq!(read(&write(&description))?, description);
//! # Ok::<(), modeldescription::Error>(())
//! ```
//!
//! The crate names no block, and reads and writes memory only.

pub mod digits;
mod error;
mod table;
pub mod units;
pub mod v2;

pub use error::{Error, shortened};
pub use table::{Characteristic, Response, Row, Table};
