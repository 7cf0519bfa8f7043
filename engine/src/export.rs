//! What a user takes away: files as text or bytes.

use crate::message::Loop;
use serde::{Deserialize, Serialize};

/// What to take away.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// Loops as a parameter file.
    Parameters {
        /// `awl`, `scl`, `db`, `xml`, `json`, `ssv`: the ending of the file.
        format: String,
        /// The loops with their values.
        loops: Vec<Loop>,
        /// What they were made of, for a comment.
        origin: String,
    },
    /// A run as a description for `plcfmu run`: setup, connections, what was done.
    Description {
        /// The run; the present one without it.
        run: Option<usize>,
    },
    /// A run as CSV, every call that is still held.
    Csv {
        /// The run; the present one without it.
        run: Option<usize>,
        /// The variables, by `MEMBER.VARIABLE`; all without it.
        #[serde(default)]
        variables: Vec<String>,
    },
    /// One page with parameters, curves and figures, as HTML.
    Report {
        /// The loop with its values.
        of: Loop,
        /// The values before, to compare with; may be empty.
        before: Vec<crate::message::Setting>,
        /// The run; the present one without it.
        run: Option<usize>,
        /// A picture of the curves, an `<svg>` or a `data:` URL of a PNG; drawn by the engine without it.
        picture: Option<String>,
    },
    /// The FMU of a block with these start values.
    Preset {
        /// The loop with its values.
        of: Loop,
        /// The block's FMU, Base64; the home's own without it.
        fmu: Option<String>,
    },
}

/// A file to take away.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Exported {
    /// Its name.
    pub file: String,
    /// Its media type.
    pub media_type: String,
    /// Its bytes, Base64.
    pub content: String,
    /// What the user should know, a sentence each.
    pub remarks: Vec<String>,
}
