//! A file recorded on the plant through the block: does it do what the plant's did?

use crate::message::{Member, Values};
use serde::{Deserialize, Serialize};

/// What to replay.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// The block with the file's parameters.
    pub controller: Member,
    /// The text of the CSV file.
    pub text: String,
    /// Which column is which variable of the block; `time` is the time. By their names without it.
    #[serde(default)]
    pub columns: Vec<(String, String)>,
    /// How far a value may be off and still counts as equal: that of the recording's resolution.
    #[serde(default)]
    pub tolerance: Option<f64>,
    /// Whether to try what usually is the matter.
    #[serde(default)]
    pub try_suspects: bool,
}

/// What came out.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Replayed {
    /// Which column is which variable of the block.
    pub columns: Vec<(String, String)>,
    /// How many calls were made.
    pub calls: usize,
    /// One for each output that the file has.
    pub outputs: Vec<Compared>,
    /// What was tried, the best first.
    pub suspects: Vec<Suspect>,
    /// The conclusion, in one sentence.
    pub verdict: String,
    /// What the user should know, a sentence each.
    pub remarks: Vec<String>,
}

/// An output, recorded and computed.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Compared {
    /// The variable.
    pub variable: String,
    /// The first call that differs, from 0, with its time in seconds.
    pub first: Option<(usize, f64)>,
    /// How many calls differ.
    pub different: usize,
    /// The largest difference.
    pub largest: f64,
    /// To draw: times in seconds.
    pub times: Vec<f64>,
    /// The recorded values.
    pub recorded: Vec<f64>,
    /// What the block computes.
    pub computed: Vec<f64>,
}

/// A change that was tried.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Suspect {
    /// What was changed, in one sentence.
    pub text: String,
    /// The settings that were changed.
    pub values: Values,
    /// How many calls still differ.
    pub different: usize,
    /// The largest difference.
    pub largest: f64,
    /// Whether nothing differs any more.
    pub fits: bool,
}
