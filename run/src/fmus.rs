//! The available FMUs: their descriptions, and instances of them.

use crate::component::Component;
use crate::dialog::{self, Group, Roles};
use crate::system::Value;
use anyhow::Result;
use modeldescription::{Description, Table};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Access to FMUs by name, whether they are blocks linked into this program or used through their C interface.
pub trait Fmus {
    /// The description of an FMU, as in its modelDescription.xml.
    ///
    /// # Errors
    /// The FMU does not exist or cannot be read.
    fn description(&self, fmu: &str) -> Result<Arc<Description>>;

    /// The table of an FMU built with `fmu::export!`; `None` for an FMU from another tool.
    ///
    /// # Errors
    /// The FMU does not exist or cannot be read.
    fn table(&self, fmu: &str) -> Result<Option<Arc<Table>>>;

    /// The dialog of an FMU with this table; by default, the one in the table's documentation.
    ///
    /// # Errors
    /// The dialog is wrong.
    fn dialog(&self, _fmu: &str, table: &Table) -> Result<(Roles, Vec<Group>)> {
        dialog::read(table)
    }

    /// Creates an instance of an FMU.
    ///
    /// # Errors
    /// The FMU does not exist or cannot be instantiated.
    fn instantiate(&self, fmu: &str, name: &str) -> Result<Box<dyn Component>>;
}

/// Values by variable name.
pub type Values = BTreeMap<String, Value>;

/// An FMU in a loop.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Member {
    /// Its name in the loop.
    pub name: String,
    /// The name of its FMU, as in [`Fmus`].
    pub fmu: String,
    /// Its settings; other variables have their start values.
    #[serde(default)]
    pub values: Values,
}

/// The role of an FMU in a loop.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum LoopRole {
    /// It has a setpoint or outputs a manipulated value.
    Controller,
    /// It has a manipulated value as input or a process value as output.
    Plant,
    /// Anything else.
    Other,
}

/// A value as a number; true is 1.
pub fn number_of(value: Value) -> f64 {
    match value {
        Value::Boolean(value) => f64::from(u8::from(value)),
        Value::Whole(value) => value as f64,
        Value::Number(value) => value,
    }
}
