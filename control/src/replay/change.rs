//! The conclusions of a replay as data: what was changed, why, and why equal outputs prove nothing. The caller puts
//! them into words.

use run::system::Value;
use serde::{Deserialize, Serialize};

/// One change of a setting of the block, or of its calls.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Change {
    /// A setting has another value.
    Setting {
        /// The setting.
        name: String,
        /// Its value in the replay that explains the recording.
        value: Value,
        /// Its value in the loop.
        before: Value,
        /// The reason for trying this value; `None` if it was searched for.
        why: Option<Why>,
    },
    /// The block is called this many times from row to row.
    Calls(usize),
    /// A row of the recording is not a call.
    LeftOut {
        /// Its line in the file.
        line: usize,
        /// Its time in seconds.
        time: f64,
    },
    /// A call before a row that has no row itself.
    Added {
        /// The line of the row in the file.
        line: usize,
        /// The time of the row in seconds.
        time: f64,
    },
}

/// A setting changed during the recording, with the time of the change.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Since {
    /// The setting, its value from there on, and that before it.
    pub change: Change,
    /// The likeliest first call with the new value, from 0, with its time in seconds.
    pub at: (usize, f64),
    /// The first call that may have been it.
    pub earliest: (usize, f64),
    /// The last one: another call between explains the recording as well, with another value perhaps.
    pub latest: (usize, f64),
}

/// The reason for trying a value of a setting.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Why {
    /// A round part of the value in the loop, or a round multiple of it.
    Factor,
    /// The sign of the value in the loop is the other one.
    Sign,
    /// Minutes were taken for seconds.
    Minutes,
    /// Seconds were taken for minutes.
    NoMinutes,
    /// Seconds were taken for milliseconds.
    Seconds,
    /// Milliseconds were taken for seconds.
    Milliseconds,
    /// The rows have this spacing.
    Spacing,
    /// The outputs change only once in this many rows.
    Rhythm(usize),
    /// There the recording stays.
    Stays,
    /// No dead band.
    NoDeadBand,
    /// Within it the recording rests.
    Rests,
}

/// A setting that changes during a recording: the comparison uses the recorded values instead of the loop's.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Moving {
    /// The setting.
    pub name: String,
    /// Its first value in the recording.
    pub first: Value,
    /// Its last value there.
    pub last: Value,
    /// Its value in the loop.
    pub before: Value,
}

/// The reason why equal outputs prove nothing about a controller's settings.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Doubt {
    /// The recording has none of these outputs, which depend on the settings.
    NotRecorded(Vec<String>),
    /// All calls are in manual mode.
    Manual,
    /// The recording does not have this switch to manual mode, and it is TRUE in the loop.
    ManualInLoop(String),
}
