//! A plant's model from the answer to a step.

use serde::{Deserialize, Serialize};

/// What to identify from.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// The recorded step.
    pub data: Data,
    /// How.
    pub method: Method,
    /// Whether the plant integrates.
    #[serde(default)]
    pub is_integrating: bool,
}

/// Where the step is recorded.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum Data {
    /// In a run of the tool: the loop's manipulated value and process value.
    Run {
        /// The run; the present one without it.
        #[serde(default)]
        run: Option<usize>,
        /// The beginning in seconds; shortly before the last step of the manipulated value without it.
        #[serde(default)]
        from: Option<f64>,
        /// The end in seconds; the last call without it.
        #[serde(default)]
        to: Option<f64>,
    },
    /// In a CSV file of the plant.
    Csv {
        /// The text.
        text: String,
        /// The column of the time; by its name without it.
        #[serde(default)]
        time: Option<String>,
        /// The column of the manipulated value.
        #[serde(default)]
        input: Option<String>,
        /// The column of the process value.
        #[serde(default)]
        output: Option<String>,
        /// Which of the rows, in the file's seconds.
        #[serde(default)]
        from: Option<f64>,
        /// The end.
        #[serde(default)]
        to: Option<f64>,
    },
}

/// How a model is found.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The tangent at the point of inflection.
    Tangent,
    /// The times of 28 % and 63 % of the answer.
    TwoPoints,
    /// The area above the answer.
    Area,
    /// Least squares over gain, time constant and dead time.
    LeastSquares,
}

/// A plant: a lag with dead time, or an integrator with dead time.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// K in units of the process value per unit of the manipulated value; per second of an integrating plant.
    pub gain: f64,
    /// T in seconds; 0 of an integrating plant.
    pub time_constant: f64,
    /// A second lag in seconds, or 0.
    #[serde(default)]
    pub second_time_constant: f64,
    /// L in seconds.
    pub dead_time: f64,
    /// Whether the plant integrates.
    #[serde(default)]
    pub is_integrating: bool,
}

/// A model with how well it fits.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Identified {
    /// The model.
    pub model: Model,
    /// How well it fits: 100 (1 - NRMSE) in percent.
    pub fit: f64,
    /// The data that were used and the model's answer, to draw.
    pub times: Vec<f64>,
    /// The measured process value.
    pub measured: Vec<f64>,
    /// The model's process value.
    pub modelled: Vec<f64>,
    /// What the user should know, a sentence each.
    pub remarks: Vec<String>,
}

/// Where a function with one minimum between two numbers is smallest, after so many divisions of the interval.
pub(crate) fn golden_section(low: f64, high: f64, divisions: usize, mut function: impl FnMut(f64) -> f64) -> f64 {
    let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (low, high);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (function(left), function(right));
    for _ in 0..divisions {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - ratio * (high - low);
            at_left = function(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + ratio * (high - low);
            at_right = function(right);
        }
    }
    f64::midpoint(low, high)
}
