//! The job of a study: a loop, the axes, and what is computed from each run.

use run::system::{System, Value};
use serde::{Deserialize, Serialize};

/// A complete description of a study. Apart from the FMUs, whose paths it contains, no other file is needed to run it.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// The loop.
    pub system: System,
    /// The axes, and what is computed from each run.
    pub study: Study,
}

/// The axes of a study, and what is computed from each run.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct Study {
    /// The axes. Lists and ranges span a grid, with the first axis varying slowest; distributions are sampled at each
    /// of its points.
    pub axes: Vec<Axis>,
    /// The rank correlations between distributions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub correlations: Vec<Correlation>,
    /// The number of samples of the distributions at each point of the grid, 1 to 10^9. The same samples are used at
    /// every point.
    pub samples: u64,
    /// The seed of the samples.
    pub seed: u64,
    /// How the distributions are sampled.
    pub sampling: Sampling,
    /// The variables that are the loop's signals; those not specified are taken from the first FMU's dialog.
    pub signals: Signals,
    /// The part of a run in which figures are computed.
    pub window: Window,
    /// Figures of individual variables.
    pub values: Vec<Taken>,
    /// Limits for variables.
    pub limits: Vec<Limit>,
    /// The figure by which the summary selects curves and colours points; by default `iae`, or the first figure if
    /// there is no `iae`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub main: Option<String>,
}

impl Default for Study {
    fn default() -> Study {
        Study {
            axes: Vec::new(),
            correlations: Vec::new(),
            samples: 1,
            seed: 0,
            sampling: Sampling::default(),
            signals: Signals::default(),
            window: Window::default(),
            values: Vec::new(),
            limits: Vec::new(),
            main: None,
        }
    }
}

/// A correlation between two axes with distributions.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Correlation {
    /// A variable of each of the two axes.
    pub variables: [String; 2],
    /// Spearman's rank correlation of the values, between -1 and 1, exclusive.
    pub rank: f64,
}

/// An axis: one variable that varies, or several that vary together.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// The variables to set, `FMU.VARIABLE`. All get the same value or, from a list of rows, one value each.
    pub variables: Vec<String>,
    /// The time at which they are set, in seconds; by default at the start, before initialization.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Whether the values are factors for the value that the loop sets, or for the start value if it sets none.
    #[serde(default)]
    pub relative: bool,
    /// Whether the values of a distribution are rounded to integers.
    #[serde(default, skip_serializing_if = "is_false")]
    pub whole: bool,
    /// Axes in the same group vary together: all use their first values, then their second, and so on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// The names of the loops to which the rows belong, one for each row; empty if they have none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
    /// The values.
    pub along: Along,
}

fn is_false(value: &bool) -> bool {
    !value
}

impl Default for Along {
    fn default() -> Along {
        Along::Values(Vec::new())
    }
}

/// The values of an axis.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Along {
    /// A list of values, part of the grid.
    Values(Vec<Value>),
    /// A list of rows with a value for each variable of the axis, part of the grid.
    Rows(Vec<Vec<Value>>),
    /// `count` values from `from` to `to`, both included; part of the grid.
    Range {
        /// The first value.
        from: f64,
        /// The last value.
        to: f64,
        /// The number of values; at least 2.
        count: u64,
        /// Whether values have equal ratios instead of equal differences; if so, both ends must be above 0.
        #[serde(default)]
        logarithmic: bool,
    },
    /// A uniform distribution.
    Uniform {
        /// The minimum.
        min: f64,
        /// The maximum.
        max: f64,
    },
    /// The normal distribution, truncated at `min` and `max` if given.
    Normal {
        /// The mean.
        mean: f64,
        /// The standard deviation; above 0.
        deviation: f64,
        /// The lower truncation bound.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        min: Option<f64>,
        /// The upper truncation bound.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max: Option<f64>,
    },
    /// The log-normal distribution.
    LogNormal {
        /// The median; above 0.
        median: f64,
        /// The standard deviation of the natural logarithm; above 0.
        deviation: f64,
    },
    /// The triangular distribution: its density rises from `min` to `mode` and falls to `max`.
    Triangular {
        /// The minimum.
        min: f64,
        /// The most likely value.
        mode: f64,
        /// The maximum.
        max: f64,
    },
}

/// The sampling method for distributions.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Independent samples.
    #[default]
    Random,
    /// Latin hypercube: each axis is divided into as many parts of equal probability as there are samples, with one
    /// sample in each part.
    LatinHypercube,
    /// A low-discrepancy sequence, which evenly fills the space of all axes.
    Sobol,
    /// Saltelli's scheme for Sobol indices: each sample requires two more runs than there are distributions; see
    /// [`sobol`](crate::sobol).
    Saltelli,
}

/// The loop's signals, `FMU.VARIABLE`.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct Signals {
    /// The setpoint.
    pub setpoint: Option<String>,
    /// The process value, in the setpoint's unit.
    pub process_value: Option<String>,
    /// The manipulated value.
    pub manipulated_value: Option<String>,
    /// The pulse outputs of the controller.
    pub pulses: Option<Vec<String>>,
}

/// A time window of a run in seconds; see [`figures`](control::figures) for the defaults.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct Window {
    /// Its beginning.
    pub from: Option<f64>,
    /// Its end.
    pub to: Option<f64>,
}

/// A variable, and the figures to compute from its values in a run.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Taken {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// The figures, named `FMU.VARIABLE.min` and so on.
    pub take: Vec<Take>,
}

/// A figure computed from the values of a variable in a whole run.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Take {
    /// The minimum.
    Min,
    /// The maximum.
    Max,
    /// The mean over the steps.
    Mean,
    /// The value in the last step.
    Last,
}

/// The limits of a variable. The figure `FMU.VARIABLE.violation` is the time in seconds that the variable spends
/// outside them.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// The lower limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// The upper limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}
