//! The conclusions of a replay as data: the changes, the reasons for them, and the reasons why equal outputs prove
//! nothing. The caller puts them into words.

use run::system::Value;
use serde::{Deserialize, Serialize};

/// A change to one of the block's settings, or to its calls.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Change {
    /// A setting has another value.
    Setting {
        /// The name of the setting.
        name: String,
        /// Its value in the replay that explains the recording.
        value: Value,
        /// Its value in the loop or, if an earlier change applies, after that change.
        before: Value,
        /// The reason for trying this value; `None` if it was searched for.
        why: Option<Why>,
    },
    /// The block is called this many times per row.
    Calls(usize),
    /// A row of the recording is not a call.
    LeftOut {
        /// Its line in the file.
        line: usize,
        /// Its time in seconds.
        time: f64,
    },
    /// An additional call before a row, not recorded as a row.
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
    /// The setting, with its values after and before the change.
    pub change: Change,
    /// The 0-based index of the likeliest first call with the new value, with its time in seconds.
    pub at: (usize, f64),
    /// The earliest call that may have been the first with the new value.
    pub earliest: (usize, f64),
    /// The latest such call. Any call from the earliest to this one explains the recording equally well, possibly with
    /// another value.
    pub latest: (usize, f64),
}

/// The reason for trying a value of a setting.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Why {
    /// A simple fraction or multiple of the value in the loop.
    Factor,
    /// The value in the loop has the opposite sign.
    Sign,
    /// Minutes were mistaken for seconds.
    Minutes,
    /// Seconds were mistaken for minutes.
    NoMinutes,
    /// Seconds were mistaken for milliseconds.
    Seconds,
    /// Milliseconds were mistaken for seconds.
    Milliseconds,
    /// The rows have this spacing.
    Spacing,
    /// The outputs change only once in this many rows.
    Rhythm(usize),
    /// The recorded manipulated value stays at this value, as at a limit.
    Stays,
    /// The dead band is switched off.
    NoDeadBand,
    /// The recorded manipulated value does not move while the deviation is within this value.
    Rests,
}

/// A setting that changes during a recording: the comparison uses the recorded values instead of the loop's.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Moving {
    /// The name of the setting.
    pub name: String,
    /// Its first value in the recording.
    pub first: Value,
    /// Its last value in the recording.
    pub last: Value,
    /// Its value in the loop.
    pub before: Value,
}

/// The reason why equal outputs prove nothing about a controller's settings.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Doubt {
    /// None of these outputs, which depend on the settings, is in the recording.
    NotRecorded(Vec<String>),
    /// All calls are in manual mode.
    Manual,
    /// This switch to manual mode is not in the recording, and it is TRUE in the loop.
    ManualInLoop(String),
}
