//! The Bode plot of an open loop: the controller as its block computes it, call by call, with a plant model.
//!
//! The response and its margins are computed by [`margins`]. The settings are those that the block actually uses: it
//! raises TI and TM_LAG to at least half the time between two calls of the controller, and TD to at least the whole of
//! it.

use crate::identify::Model;
use crate::margins::{self, Law, Plant};
use crate::predict;
use crate::rules::Settings;
use crate::tune::Controller;
use anyhow::{Result, bail};
use libm::log10;
use run::fmus::{Fmus, Member, Values};
use serde::{Deserialize, Serialize};

/// The approximate maximum number of points per curve.
const POINTS: usize = 400;
/// The plot begins at the lowest frequency at which a margin is read, divided by this number.
const BELOW: f64 = 30.0;

/// The open loops to draw.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct BodeRequest {
    /// The plant model.
    pub model: Model,
    /// The controller with the settings of the first loop.
    pub controller: Member,
    /// For each additional loop, the settings that differ from the first loop's, such as those of a rule.
    pub others: Vec<Values>,
}

/// Open loops, up to the highest frequency that the controller's calls can represent.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Bode {
    /// The frequencies of the points, ascending, in radians per second.
    pub frequencies: Vec<f64>,
    /// The open loops, in the order of the request.
    pub loops: Vec<OpenLoop>,
}

/// An open loop with its margins. Infinite margins are absent.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct OpenLoop {
    /// The amplitude at each frequency, in dB.
    pub amplitude: Vec<f64>,
    /// The phase at each frequency, in degrees.
    pub phase: Vec<f64>,
    /// Ms, the largest sensitivity; absent if the loop is unstable.
    pub sensitivity: Option<f64>,
    /// The gain margin, as a factor.
    pub gain_margin: Option<f64>,
    /// The phase margin, in degrees.
    pub phase_margin: Option<f64>,
    /// The frequency at which the gain margin is read, in radians per second.
    pub phase_crossover: Option<f64>,
    /// The frequency at which the phase margin is read, in radians per second.
    pub gain_crossover: Option<f64>,
}

/// Computes the open loops of a controller with a plant.
///
/// # Errors
/// The model is not a valid plant, the FMU is not a controller or lacks a setting, or its P action is off; the message
/// states what works.
pub fn bode(home: &dyn Fmus, request: &BodeRequest) -> Result<Bode> {
    request.model.check()?;
    let mut plotted = Vec::new();
    for other in std::iter::once(&Values::new()).chain(&request.others) {
        let mut member = request.controller.clone();
        member.values.extend(other.clone());
        let controller = Controller::new(home, &member)?;
        let law = law(home, &controller)?;
        let plant = Plant::of_model(&request.model, controller.sampling());
        let delay = controller.delay_of_pulses();
        plotted.push((margins::open_loop(&plant, &law, delay), margins::compute(&plant, &law, delay)));
    }
    let crossovers = plotted.iter().flat_map(|(_, margins)| [margins.phase_crossover, margins.gain_crossover]);
    let lowest = crossovers.flatten().fold(f64::INFINITY, f64::min) / BELOW;
    let of_first = &plotted[0].0;
    let from = of_first.iter().position(|point| point.frequency >= lowest).unwrap_or_default();
    // Points are taken from the end backwards, so that the highest frequency that the calls can represent is included.
    let stride = (of_first.len() - from).div_ceil(POINTS).max(1);
    let taken = |points: &[margins::Point]| -> Vec<margins::Point> {
        let mut taken: Vec<_> = points[from..].iter().rev().step_by(stride).copied().collect();
        taken.reverse();
        taken
    };
    let frequencies = taken(of_first).iter().map(|point| point.frequency).collect();
    let loops = plotted.iter().map(|(points, margins)| {
        let points = taken(points);
        OpenLoop {
            amplitude: points.iter().map(|point| 20.0 * log10(point.amplitude)).collect(),
            phase: points.iter().map(|point| point.phase).collect(),
            sensitivity: margins.sensitivity,
            gain_margin: margins.gain_margin,
            phase_margin: margins.phase_margin,
            phase_crossover: margins.phase_crossover,
            gain_crossover: margins.gain_crossover,
        }
    });
    Ok(Bode { frequencies, loops: loops.collect() })
}

/// Returns the control law that a controller computes with its settings.
pub(crate) fn law(home: &dyn Fmus, controller: &Controller) -> Result<Law> {
    let fmu = &controller.member.fmu;
    let is_on = |action: usize| controller.roles.structure.get(action).is_none_or(|name| controller.value(name) != 0.0);
    if !is_on(0) {
        bail!(
            "{0} is FALSE, but the margins and the Bode plot of {fmu} need the P action: set {0} to TRUE",
            controller.roles.structure[0]
        );
    }
    let sampling = controller.sampling();
    let setting = |action: usize, place: usize, lowest: f64| {
        let name = controller.roles.controller.get(place).filter(|_| is_on(action))?;
        Some(controller.value(name).max(lowest))
    };
    let Some(name) = controller.roles.controller.first() else { bail!("{fmu} has no GAIN: choose a controller") };
    let gain = controller.value(name);
    if gain == 0.0 {
        bail!("{name} is 0, so the loop has no Bode plot: choose a different {name}");
    }
    let settings = Settings {
        gain,
        ti: setting(1, 1, sampling / 2.0),
        td: setting(2, 2, sampling),
        tm_lag: setting(2, 3, sampling / 2.0).unwrap_or_default(),
    };
    Ok(controller.law(&settings, predict::output_factor(home, controller)?.unwrap_or(1.0)))
}

#[cfg(test)]
mod tests;
