//! The properties of an FMU, and its modelDescription.xml.
//!
//! A library describes its block in a [`Table`] and its FMI support in an [`Interface`]. They are turned into a
//! [`ModelDescription`], which can be written as XML and parsed again. A [`Description`] of the FMU, which is
//! independent of the FMI version, is derived from it.
//!
//! ```text
//! library --JSON--> Interface --from_interface--> ModelDescription --write--> XML
//!                                                    |     ^                   |
//!                                  Description <-----+     +------- read ------+
//! ```
//!
//! Version-specific code is in separate modules, [`v2`] for FMI 2.0 and [`v3`] for FMI 3.0, which are used only by
//! [`ModelDescription`].
//!
//! ```
//! use modeldescription::{Interface, ModelDescription};
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
//! let file = ModelDescription::from_interface(&Interface::parse(json)?)?;
//! assert_eq!(file.check(false).all(), Vec::<String>::new());
//! assert_eq!(ModelDescription::read(&file.write())?, file);
//! assert_eq!(file.description().start("CYCLE"), Some(0.1));
//! # Ok::<(), modeldescription::Error>(())
//! ```
//!
//! The crate knows no specific block and performs no file access.

pub mod arrays;
mod description;
pub mod digits;
mod error;
mod findings;
mod interface;
mod mapping;
mod model_description;
mod names;
mod rows;
mod table;
pub mod units;
pub mod v2;
pub mod v3;
mod xml;

pub use arrays::Array;
pub use blocks::{Row, Table};
pub use description::{
    BaseUnit, Capabilities, Causality, DefaultExperiment, Description, DisplayUnit, GENERATION_TOOL, Initial,
    LogCategory, Support, Type, Unit, Variability, Variable,
};
pub use error::{Error, shortened};
pub use interface::Interface;
pub use model_description::{Findings, MOST_FINDINGS, ModelDescription, Preset, VERSIONS};
pub use names::Names;
pub use table::read_table;
