//! Identification of a plant model from the response to a step in the manipulated value.
//!
//! The last recorded step is used. The manipulated value must be constant before and after it, as in manual mode, and
//! the process value must be steady or drift at a constant rate before it. A recorded manipulated value is assumed to
//! take effect at its timestamp, and a process value to have been sampled at its timestamp, as in the recording of a
//! run. If a plant's logger samples the two at different times but records them together, the difference adds to the
//! dead time.
//!
//! - [`Method::Tangent`]: the tangent at the steepest point, whose slope is measured over more samples if there is
//!   noise. It meets the old level at the dead time, and the new level one time constant later.
//! - [`Method::TwoPoints`]: the times at which 28.3 % and 63.2 % of the response are reached; T is 1.5 times their
//!   difference, and L is the second time minus T.
//! - [`Method::Area`]: for a unit step, the area between the response and its final level is K (T + L); T is e / K
//!   times the area below the response up to the time T + L.
//! - [`Method::LeastSquares`]: a search over the dead time; for each candidate, gain and time constant follow from a
//!   linear equation for the response and its integral, and the best model is refined by least squares over all three
//!   parameters. A second lag is fitted too, and kept if it reduces the residual by more than the noise and the
//!   resolution of the process value can explain.
//!
//! Unless the plant is integrating, the first three need a response that settles within the record. Only the tangent
//! and least squares can identify an integrating plant. A model whose fit is below [`LOWEST_FIT`] is rejected.

mod gauss_newton;
mod least_squares;
mod methods;
mod step;

pub(crate) use step::noise;
pub use step::{means_of_pulses, resolution};

use crate::csv::names::{MANIPULATED_VALUES, PROCESS_VALUES};
use crate::csv::{Column, CsvTable};
use crate::process::Process;
use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use step::Step;

/// The fit in percent below which a model is rejected.
pub const LOWEST_FIT: f64 = 60.0;
/// The fit in percent below which a model gets a remark.
const GOOD_FIT: f64 = 85.0;
/// The maximum number of points in each curve of the result.
const MOST_POINTS: usize = 2000;
/// The maximum movement of a settled process value in the last fifth of the record, relative to the response.
const SETTLED: f64 = 0.02;

/// The data from which to identify a plant, and the method.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct IdentifyRequest {
    /// The recorded step.
    pub data: Data,
    /// The identification method.
    pub method: Method,
    /// Whether the plant is integrating.
    #[serde(default)]
    pub is_integrating: bool,
}

/// The source of the recorded step.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(optional_fields = nullable))]
pub enum Data {
    /// A run of the tool: the loop's manipulated value and process value.
    Run {
        /// The run; by default the current one.
        #[serde(default)]
        run: Option<usize>,
        /// The beginning in seconds; by default shortly before the last step in the manipulated value.
        #[serde(default)]
        from: Option<f64>,
        /// The end in seconds; by default the last call.
        #[serde(default)]
        to: Option<f64>,
    },
    /// A CSV file recorded at the plant.
    Csv {
        /// The text of the file.
        text: String,
        /// The time column; by default recognized by its name.
        #[serde(default)]
        time: Option<String>,
        /// The column of the manipulated value; by default recognized by its name.
        #[serde(default)]
        input: Option<String>,
        /// The column of the process value; by default recognized by its name.
        #[serde(default)]
        output: Option<String>,
        /// The time of the first row to use, in the file's seconds.
        #[serde(default)]
        from: Option<f64>,
        /// The time of the last row to use, in the file's seconds.
        #[serde(default)]
        to: Option<f64>,
    },
}

/// The method of identification.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Method {
    /// The tangent at the point of inflection.
    Tangent,
    /// The times at which 28 % and 63 % of the response are reached.
    TwoPoints,
    /// The areas above and below the response.
    Area,
    /// Least squares over gain, one or two lags, and dead time.
    LeastSquares,
}

/// A plant: a lag with dead time, or an integrator with dead time.
///
/// The gain is measured from the controller's output to the process value that the controller compares with the
/// setpoint. A model identified from a loop's signals has this gain: it includes the factor that the block applies to
/// the process value (PV_FAC), but not the one that the block applies to the manipulated value (LMN_FAC);
/// [`tune`](crate::tune) takes the latter into account.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Model {
    /// K in units of the process value per unit of the manipulated value; per second for an integrating plant.
    pub gain: f64,
    /// T in seconds; 0 for an integrating plant.
    pub time_constant: f64,
    /// The time constant of a second lag in seconds; 0 if there is none.
    #[serde(default)]
    pub second_time_constant: f64,
    /// L in seconds.
    pub dead_time: f64,
    /// Whether the plant is integrating.
    #[serde(default)]
    pub is_integrating: bool,
}

/// A model and the quality of its fit.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Identified {
    /// The identified model.
    pub model: Model,
    /// The quality of the fit: 100 (1 - NRMSE) in percent.
    pub fit: f64,
    /// The times of a chart of the measured and the modelled response, in seconds.
    pub times: Vec<f64>,
    /// The measured process value at these times.
    pub measured: Vec<f64>,
    /// The model's process value at these times.
    pub modelled: Vec<f64>,
    /// Remarks for the user, one sentence each.
    pub remarks: Vec<String>,
}

/// A recorded step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recorded<'a> {
    /// The times of the samples in seconds, strictly increasing.
    pub times: &'a [f64],
    /// The manipulated value at each time.
    pub input: &'a [f64],
    /// The process value at each time.
    pub output: &'a [f64],
}

/// Identifies the model from a recorded step.
///
/// # Errors
/// The plant cannot be identified from the record; the message states the reason, with numbers, and the remedy.
pub fn identify(recorded: &Recorded, method: Method, is_integrating: bool) -> Result<Identified> {
    let step = Step::new(recorded, is_integrating)?;
    let model = match (method, is_integrating) {
        (Method::LeastSquares, true) => least_squares::integrating(&step)?,
        (Method::LeastSquares, false) => least_squares::lags(&step)?,
        (Method::Tangent, true) => methods::integrating_tangent(&step)?,
        (_, true) => {
            bail!("{} needs a response that settles, but the plant is integrating: use least squares", name(method))
        }
        (_, false) => {
            step.require_end(name(method))?;
            match method {
                Method::Tangent => methods::tangent(&step)?,
                Method::TwoPoints => methods::two_points(&step)?,
                _ => methods::area(&step)?,
            }
        }
    };
    judged(&step, model, method)
}

/// The sampled response of a plant to a unit step in the manipulated value.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// The deviation of the process value from its steady value, beginning with the sample of the step.
    pub values: Vec<f64>,
    /// The time between two samples in seconds.
    pub interval: f64,
    /// The standard deviation of the noise in the response.
    pub noise: f64,
}

impl Answer {
    /// Extracts the response from a record with equidistant samples. Noise and quantization of the process value, which
    /// may dominate the changes from sample to sample, are smoothed out without affecting the response.
    ///
    /// # Errors
    /// The plant cannot be identified from the record; the message states the reason, with numbers, and the remedy.
    pub fn new(recorded: &Recorded, is_integrating: bool) -> Result<Answer> {
        let mut step = Step::new(recorded, is_integrating)?;
        step.smooth();
        let values = step.values.iter().map(|value| value / step.height).collect();
        Ok(Answer { values, interval: step.interval(), noise: (step.noise / step.height).abs() })
    }

    /// Returns the moving average of the response over the preceding `period` seconds, which removes pulses with this
    /// period.
    #[must_use]
    pub fn averaged(&self, period: f64) -> Answer {
        let count = (period / self.interval).round().max(1.0) as usize;
        let mean = |at: usize| self.values[at.saturating_sub(count - 1)..=at].iter().sum::<f64>() / count as f64;
        Answer { values: (0..self.values.len()).map(mean).collect(), ..*self }
    }

    /// Returns every `count`-th sample of the response.
    #[must_use]
    pub fn every(&self, count: usize) -> Answer {
        let values = self.values.iter().step_by(count).copied().collect();
        Answer { values, interval: self.interval * count as f64, ..*self }
    }

    /// Returns the possible share of noise in the response's spectrum, at the frequency where it is largest.
    pub fn uncertainty(&self) -> f64 {
        let largest = self.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        self.noise * (self.values.len() as f64).sqrt() / largest
    }
}

/// Identifies the model from a recorded step in a CSV file.
///
/// # Errors
/// The file is malformed (the message states line and column), a column is missing, or the plant cannot be identified,
/// as in [`identify`].
pub fn of_csv(request: &IdentifyRequest) -> Result<Identified> {
    let Data::Csv { text, time, input, output, from, to } = &request.data else {
        bail!("the data are not a CSV file");
    };
    let table = CsvTable::read(text)?;
    let time = match time {
        Some(name) => table.find(name).with_context(|| format!("the file has no column {name}: choose another"))?,
        None => table.time().context("the file has no column with a recognized time name: choose the time column")?,
    };
    let times = table.times(time)?;
    let column = |chosen: &Option<String>, what: &str, names: &[&str]| match chosen {
        Some(name) => table.column(name),
        None => table.called(names).with_context(|| {
            let columns: Vec<_> = table.columns.iter().take(12).map(|column| column.header.as_str()).collect();
            format!(
                "choose the {what} column: none of {} has a recognized name ({})",
                columns.join(", "),
                names.join(", ")
            )
        }),
    };
    let input = column(input, "manipulated value", &MANIPULATED_VALUES)?;
    let output = column(output, "process value", &PROCESS_VALUES)?;
    let used = format!("The manipulated value is {}, the process value {}.", input.header, output.header);
    let (from, to) = (from.unwrap_or(f64::NEG_INFINITY), to.unwrap_or(f64::INFINITY));
    let mut rows: Vec<usize> = (0..table.rows()).filter(|row| (from..=to).contains(&times.seconds[*row])).collect();
    let missing = |column: &Column| {
        let missing = column.missing(rows.iter().copied(), &table.lines)?;
        Some(format!("{missing}; rows without a value are ignored. Complete the file if the step occurs there."))
    };
    let missing: Vec<String> = [input, output].into_iter().filter_map(missing).collect();
    rows.retain(|row| input.values[*row].is_finite() && output.values[*row].is_finite());
    // Of several rows with the same time, only the last one is used.
    let latest: Vec<bool> = (0..rows.len())
        .map(|place| rows.get(place + 1).is_none_or(|next| times.seconds[*next] > times.seconds[rows[place]]))
        .collect();
    let mut latest = latest.into_iter();
    rows.retain(|_| latest.next().unwrap_or_default());
    let of_rows = |values: &[f64]| rows.iter().map(|row| values[*row]).collect::<Vec<_>>();
    let (seconds, input, output) = (of_rows(&times.seconds), of_rows(&input.values), of_rows(&output.values));
    let recorded = Recorded { times: &seconds, input: &input, output: &output };
    let mut identified = identify(&recorded, request.method, request.is_integrating)?;
    identified.remarks.insert(0, used);
    identified.remarks.extend(missing);
    identified.remarks.extend(times.remark);
    identified.remarks.extend(table.remarks);
    Ok(identified)
}

/// Returns the name of a method for users.
fn name(method: Method) -> &'static str {
    match method {
        Method::Tangent => "the tangent",
        Method::TwoPoints => "the two-point method",
        Method::Area => "the area method",
        Method::LeastSquares => "least squares",
    }
}

/// Returns the model's response to the recorded input, at the record's times after the step.
fn response(step: &Step, model: &Model) -> Vec<f64> {
    let mut process = Process::at_rest(*model, 0.0);
    for (time, input) in &step.moves {
        process.put(*time, *input);
    }
    step.times.iter().map(|time| process.output_at(*time)).collect()
}

/// Returns the RMS error of a model relative to the RMS deviation of the response from its mean.
fn error(step: &Step, modelled: &[f64]) -> f64 {
    let mean = step.values.iter().sum::<f64>() / step.values.len() as f64;
    let missed: f64 = step.values.iter().zip(modelled).map(|(is, model)| (is - model) * (is - model)).sum();
    let all: f64 = step.values.iter().map(|is| (is - mean) * (is - mean)).sum();
    (missed / all).sqrt()
}

/// Rejects a model whose fit is below [`LOWEST_FIT`]; otherwise returns it with its curve and remarks.
fn judged(step: &Step, model: Model, method: Method) -> Result<Identified> {
    let Model { gain, time_constant, dead_time, is_integrating, .. } = model;
    if !(gain.is_finite() && gain != 0.0 && time_constant.is_finite() && dead_time.is_finite()) {
        bail!("{} finds no model for this record: use another method", name(method));
    }
    let modelled = response(step, &model);
    let fit = 100.0 * (1.0 - error(step, &modelled));
    if fit < LOWEST_FIT || fit.is_nan() {
        let other = match (method, is_integrating) {
            (_, true) => "the plant may not be integrating, or the record contains more than one step",
            (Method::LeastSquares, false) => "the plant may be integrating, or the record contains more than one step",
            _ => "use least squares, or record a step from steady state",
        };
        bail!(
            "the fit of the model is only {fit:.1} %; at least {LOWEST_FIT} % is required (gain {gain:.4}, time \
             constant {time_constant:.4} s, dead time {dead_time:.4} s): {other}"
        );
    }
    let mut remarks = step.remarks.clone();
    if fit < GOOD_FIT {
        remarks.push(format!(
            "The fit of the model is {fit:.1} %: there is noise, or the plant has more lags than the model. Compare \
             the curves before you use the model."
        ));
    }
    let interval = step.interval();
    if !is_integrating && time_constant < 5.0 * interval {
        remarks.push(format!(
            "The time constant of {time_constant:.4} s is only {:.1} times the time between two samples: sample \
             faster.",
            time_constant / interval
        ));
    }
    if !is_integrating && method == Method::LeastSquares {
        remarks.extend(least_squares::completeness(step, &model)?);
    }
    let stride = step.times.len().div_ceil(MOST_POINTS).max(1);
    let shown = || (0..step.times.len()).step_by(stride);
    Ok(Identified {
        model,
        fit,
        times: shown().map(|at| step.times[at] + step.start).collect(),
        measured: shown().map(|at| step.values[at] + step.level(at)).collect(),
        modelled: shown().map(|at| modelled[at] + step.level(at)).collect(),
        remarks,
    })
}

/// Returns the position of the minimum of a unimodal function between `low` and `high`, after this many golden-section
/// divisions of the interval.
pub fn golden_section(low: f64, high: f64, divisions: usize, mut function: impl FnMut(f64) -> f64) -> f64 {
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

#[cfg(test)]
mod tests;
