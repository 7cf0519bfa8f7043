//! `plcfmu figures`: the figures of a recorded loop as JSON, for the Python package.

use super::print;
use anyhow::{Context, Result};
use control::figures::{Set, Signals, Span, Window};
use serde::{Deserialize, Serialize};
use std::io;

/// Compute the figures of a recorded loop, JSON in and out
#[derive(clap::Args, Debug)]
pub struct Options {}

/// The content of standard input: one value of each signal per row, `null` for NaN.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Recorded {
    /// The time of each row, in seconds.
    times: Vec<f64>,
    setpoint: Vec<Option<f64>>,
    process_value: Vec<Option<f64>>,
    /// Empty if the manipulated value was not recorded.
    manipulated_value: Vec<Option<f64>>,
    /// The setpoint before and after the step with which the rows begin.
    step: (f64, f64),
    /// The times of disturbances, in seconds.
    #[serde(default)]
    disturbances: Vec<f64>,
    /// The unit of the process value.
    unit: Option<String>,
    /// The unit of the manipulated value.
    travel_unit: Option<String>,
}

/// A figure. The command prints a list of them.
#[derive(Serialize)]
struct Told {
    key: &'static str,
    /// A short description.
    meaning: &'static str,
    unit: Option<String>,
    value: Option<f64>,
}

/// Runs the command.
///
/// # Errors
/// Standard input is malformed.
pub fn run(_: &Options) -> Result<()> {
    let recorded: Recorded = serde_json::from_reader(io::stdin().lock()).context("standard input")?;
    let numbers = |values: &[Option<f64>]| values.iter().map(|value| value.unwrap_or(f64::NAN)).collect::<Vec<f64>>();
    let [setpoint, process_value, manipulated_value] =
        [&recorded.setpoint, &recorded.process_value, &recorded.manipulated_value].map(|values| numbers(values));
    let disturbances: Vec<Set> =
        recorded.disturbances.iter().map(|time| Set { time: *time, ..Set::default() }).collect();
    let signals = Signals {
        times: &recorded.times,
        setpoint: &setpoint,
        process_value: &process_value,
        manipulated_value: &manipulated_value,
        disturbances: &disturbances,
        ..Signals::default()
    };
    let window = Window::measure(signals, &Span { step: Some(recorded.step), ..Span::default() });
    let told = window.figures().map(|figure| Told {
        key: figure.key,
        meaning: figure.meaning,
        unit: figure.unit.text(recorded.unit.as_deref(), recorded.travel_unit.as_deref()),
        value: figure.value(&window).ok(),
    });
    print(&serde_json::to_string(&told.collect::<Vec<_>>())?)
}
