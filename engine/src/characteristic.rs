//! The characteristic of a pulse former: the mean of its pulses over its input, with the settings as they are.

use crate::message::Member;
use serde::{Deserialize, Serialize};

/// Whose.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// The block with its settings.
    pub member: Member,
}

/// The characteristics that the block's table describes, with these settings.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Characteristics {
    /// One for each characteristic of the table that sweeps another variable or shows others.
    pub sweeps: Vec<Sweep>,
}

/// The mean of variables over an input.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Sweep {
    /// What it shows.
    pub title: String,
    /// The variable of the horizontal axis.
    pub variable: String,
    /// Its unit.
    pub unit: Option<String>,
    /// Its values.
    pub inputs: Vec<f64>,
    /// Each variable with its means; true counts 1.
    pub outputs: Vec<(String, Vec<f64>)>,
}
