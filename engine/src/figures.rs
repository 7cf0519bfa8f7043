//! What a run comes to: rise time, overshoot, settling, integrals of the control deviation, travel, pulses.

use serde::{Deserialize, Serialize};

/// Of which part of which run.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct Request {
    /// The run; the present one without it.
    pub run: Option<usize>,
    /// The beginning in seconds; the last change of the setpoint without it.
    pub from: Option<f64>,
    /// The end in seconds; the last call without it.
    pub to: Option<f64>,
}

/// The figures of a run. What cannot be said is absent, and `remarks` say why.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Figures {
    /// From where on, in seconds.
    pub from: f64,
    /// Up to where, in seconds.
    pub to: f64,
    /// From 10 % to 90 % of the step, in seconds.
    pub rise: Option<f64>,
    /// Beyond the setpoint, in percent of the step.
    pub overshoot: Option<f64>,
    /// When the process value stays within 2 % of the step, in seconds after `from`.
    pub settled: Option<f64>,
    /// The integral of the deviation's amount.
    pub iae: Option<f64>,
    /// The integral of the deviation's square.
    pub ise: Option<f64>,
    /// The largest deviation.
    pub peak: Option<f64>,
    /// How far the manipulated value moves, in its unit.
    pub travel: Option<f64>,
    /// How many pulses begin, on all pulse outputs.
    pub pulses: Option<u64>,
    /// The unit of the process value.
    pub unit: Option<String>,
    /// The unit of the manipulated value.
    pub travel_unit: Option<String>,
    /// What could not be said, and why.
    pub remarks: Vec<String>,
}
