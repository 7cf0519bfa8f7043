//! A study's job: a loop, the axes, and what each run yields.

use run::system::{System, Value};
use serde::{Deserialize, Serialize};

/// What to run, complete: nothing in it depends on the file that it was read from but the paths of the FMUs.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// The loop.
    pub system: System,
    /// What varies, and what each run yields.
    pub study: Study,
}

/// What varies from run to run, and what each run yields.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct Study {
    /// What varies. Lists and ranges span a grid, the first axis slowest; distributions are sampled at each of its points.
    pub axes: Vec<Axis>,
    /// Which distributions depend on each other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub correlations: Vec<Correlation>,
    /// How many samples the distributions have, at each point of the grid; 1 to 10^9. They are the same at each point.
    pub samples: u64,
    /// What the samples depend on beside their number.
    pub seed: u64,
    /// How the distributions are sampled.
    pub sampling: Sampling,
    /// Which variables are the loop's signals; by default as the first FMU's table says.
    pub signals: Signals,
    /// Which part of a run the figures are of.
    pub window: Window,
    /// Figures of single variables.
    pub values: Vec<Taken>,
    /// What a variable should stay within.
    pub limits: Vec<Limit>,
    /// The figure by which the summary chooses curves and colours; by default `iae`, or else the first figure.
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

/// Two axes with distributions whose values go up and down together.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Correlation {
    /// A variable of each of the two axes.
    pub variables: [String; 2],
    /// The rank correlation (Spearman) of the values, above -1 and below 1.
    pub rank: f64,
}

/// What varies: one value, or several values that belong together.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// What gets the value: `FMU.VARIABLE`. Several variables get the same value, or of a list of rows one value each.
    pub variables: Vec<String>,
    /// When it is set, in seconds; at the start, before the initialization, without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// The values are factors for what the loop sets, or for the start value if it sets nothing.
    #[serde(default)]
    pub relative: bool,
    /// The values of a distribution are whole numbers.
    #[serde(default, skip_serializing_if = "is_false")]
    pub whole: bool,
    /// Axes of the same group vary together: they have the first value of each, then the second, and so on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// The names of the loops that the values belong to, one for each; empty without names.
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
    /// These, part of the grid.
    Values(Vec<Value>),
    /// Rows with a value for each variable of the axis, part of the grid.
    Rows(Vec<Vec<Value>>),
    /// `count` values from `from` to `to`, both included; part of the grid.
    Range {
        /// The first.
        from: f64,
        /// The last.
        to: f64,
        /// How many; at least 2.
        count: u64,
        /// With equal ratios in place of equal differences; both ends are above 0 then.
        #[serde(default)]
        logarithmic: bool,
    },
    /// Everything between with the same density.
    Uniform {
        /// The least.
        min: f64,
        /// The greatest.
        max: f64,
    },
    /// The normal distribution, cut at `min` and `max` if given.
    Normal {
        /// The mean.
        mean: f64,
        /// The standard deviation; above 0.
        deviation: f64,
        /// No value is less.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        min: Option<f64>,
        /// No value is greater.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max: Option<f64>,
    },
    /// The logarithm has a normal distribution.
    LogNormal {
        /// Half of the values are less; above 0.
        median: f64,
        /// The standard deviation of the natural logarithm; above 0.
        deviation: f64,
    },
    /// The density rises from `min` to `mode` and falls to `max`.
    Triangular {
        /// The least.
        min: f64,
        /// The most frequent.
        mode: f64,
        /// The greatest.
        max: f64,
    },
}

/// How distributions are sampled.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Each sample by itself.
    #[default]
    Random,
    /// Each axis is divided into as many parts of equal probability as there are samples; each part has one sample.
    LatinHypercube,
    /// A low-discrepancy sequence, which fills the space of all axes evenly.
    Sobol,
    /// For Sobol's indices: each sample has a run more than there are distributions, and another one; see
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
    /// Pulse outputs.
    pub pulses: Option<Vec<String>>,
}

/// A part of a run in seconds; see [`figures`](control::figures) for the defaults.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct Window {
    /// Its beginning.
    pub from: Option<f64>,
    /// Its end.
    pub to: Option<f64>,
}

/// What of a variable is a figure.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Taken {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// What is taken of its values; the figures are named `FMU.VARIABLE.min` and so on.
    pub take: Vec<Take>,
}

/// What is taken of a variable's values in the whole run.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Take {
    /// The least.
    Min,
    /// The greatest.
    Max,
    /// The mean over the steps.
    Mean,
    /// That of the last step.
    Last,
}

/// What a variable should stay within. The figure `FMU.VARIABLE.violation` is the time in seconds that it spends outside.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// The least value allowed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// The greatest value allowed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}
