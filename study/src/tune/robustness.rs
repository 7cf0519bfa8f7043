//! Ms, the maximum sensitivity of a loop, for the candidates of a search: a measure of the loop's robustness against
//! changes in the plant.
//!
//! Computing it requires a model of each plant. The loop is therefore run in manual mode, without its events; the
//! manual value steps, and the process value is recorded: its response, sampled at the calls, is the model, see
//! [`margins`]. The gain is measured from the manual value to the process value as seen by the controller; it includes
//! the block's processing of the manual value, all FMUs between controller and plant, and pulses with their actuator.
//! Pulses with a period longer than the time between two calls are represented by their mean. If the process value is
//! noisy, a lag with dead time is identified instead.
//!
//! The controller is the law computed in each call, see [`Law`], with the candidate's GAIN, TI, TD and TM_LAG.

use crate::Job;
use anyhow::{Context, Result, bail};
use control::identify::{self, Answer, Method, Model, Recorded};
use control::margins::{self, Law, Plant};
use control::rules::{FILTER, Settings};
use control::tune::Controller;
use modeldescription::Table;
use run::dialog;
use run::fmus::{Member, Values};
use run::master::Recording;
use run::system::{self, Setting, Value, own_name};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The default height of the step in the manual value, in the unit of that value.
const HEIGHT: f64 = 20.0;
/// The default time of the step, as a share of the run.
const SHARE: f64 = 0.1;
/// The relative noise in a recording above which the plant is identified as a lag with dead time.
const NOISE: f64 = 0.005;

/// The step in the manual value that identifies the plants.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct Step {
    /// The manual value before the step; by default the value set in the loop, else the variable's start value.
    pub from: Option<f64>,
    /// The manual value after the step; by default `from` + 20.
    pub to: Option<f64>,
    /// The time of the step in seconds, moved to the next call of the controller; by default after a tenth of the run.
    pub time: Option<f64>,
    /// The end of the identification run in seconds; by default the end of the study's runs.
    pub stop: Option<f64>,
    /// Whether the plant is integrating.
    pub is_integrating: bool,
}

/// A controller with a known linear form.
pub struct Linear {
    controller: Controller,
    /// The period, in seconds, of a pulse former in another FMU, with its name `FMU.VARIABLE`.
    period: Option<(String, f64)>,
    /// The communication step in seconds; 0 if the loop does not specify it.
    step: f64,
}

/// The identification of the plants: a job to run at the points of the study, and the signals to evaluate.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// The loop in manual mode.
    pub job: Job,
    /// The manual value, `FMU.VARIABLE`.
    manual: String,
    /// The process value, `FMU.VARIABLE`.
    process_value: String,
    is_integrating: bool,
}

/// An identified plant, from which Ms is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// The plant.
    pub plant: Plant,
    /// If a lag with dead time replaces the response because of noise, its fit in percent.
    pub fit: Option<f64>,
}

impl Linear {
    /// Creates the controller from the first member of the loop, whose block has this table.
    ///
    /// # Errors
    /// It has no linear form; the message names the reason and the remedy.
    pub fn new(job: &Job, table: &Arc<Table>) -> Result<Linear> {
        let member = job.system.members.first().context("no controller")?;
        let values = of_member(job, &member.name);
        let member = Member { name: member.name.clone(), fmu: table.name.clone(), values };
        let controller = Controller::of_table(&member, table)?;
        if controller.is_step_controller() {
            bail!("{} is a step controller, whose motor is integrating: {SENSITIVITY_UNKNOWN}", controller.member.fmu);
        }
        let linear = Linear { controller, period: None, step: job.system.step.unwrap_or_default() };
        linear.law(&Values::new())?;
        Ok(linear)
    }

    /// Adds the period of the pulse former to which the controller is connected, if there is one. `tables` contains the
    /// members' tables.
    ///
    /// # Errors
    /// A table is damaged.
    pub fn with_pulse_former(mut self, job: &Job, tables: &[Option<Table>]) -> Result<Linear> {
        let controller = &self.controller.member.name;
        for (member, table) in job.system.members.iter().zip(tables).skip(1) {
            let Some(table) = table else { continue };
            let is_connected = job
                .system
                .connections
                .iter()
                .any(|of| own_name(&of.from, controller).is_some() && own_name(&of.to, &member.name).is_some());
            let (roles, _) = dialog::read(table)?;
            let period = roles.pulse_former.first().and_then(|name| table.find(name));
            if let Some(row) = period.filter(|_| is_connected && roles.controller.is_empty()) {
                let row = &table.rows[row];
                let value = match of_member(job, &member.name).get(&row.name) {
                    Some(Value::Number(value)) => *value,
                    _ => row.start(),
                };
                self.period = Some((format!("{}.{}", member.name, row.name), value));
            }
        }
        Ok(self)
    }

    /// Whether a variable of the loop affects Ms directly, not only through the plant model.
    pub fn has(&self, variable: &str) -> bool {
        let Controller { table, roles, .. } = &self.controller;
        let is_period = || self.period.as_ref().is_some_and(|(name, _)| name == variable);
        let own = own_name(variable, &self.controller.member.name);
        let mut names = roles.controller.iter().chain(roles.pulse_former.first());
        is_period() || own.is_some_and(|own| own == table.rows[table.cycle].name || names.any(|name| name == own))
    }

    /// The loop in manual mode, for identifying the plants. Axes that set variables after the start are omitted from
    /// its points: see [`Identification::is_in_point`]. `start` and `stop` are those of the study's runs, in seconds.
    ///
    /// # Errors
    /// The controller has no manual value, its dialog names no process value, or the step is invalid.
    pub fn identification(&self, job: &Job, step: &Step, start: f64, stop: f64) -> Result<Identification> {
        let (name, fmu) = (&self.controller.member.name, &self.controller.member.fmu);
        let roles = &self.controller.roles;
        let Some((switch, manual)) = &roles.manual else {
            bail!("{fmu} has no manual value that can be stepped");
        };
        let process_value = roles
            .compared_process_value()
            .with_context(|| format!("{fmu} does not specify which variable is its process value"))?;
        let from = step.from.unwrap_or_else(|| self.controller.value(manual));
        let [switch, manual, process_value] = [switch, manual, process_value].map(|of| format!("{name}.{of}"));
        let to = step.to.unwrap_or(from + HEIGHT);
        let stop = step.stop.unwrap_or(stop);
        // The step coincides with a call of the controller and the start of a period.
        let (sampling, period) = (self.controller.sampling(), self.period(&Values::new()));
        let grid = sampling.max(period);
        let time = step.time.unwrap_or(start + SHARE * (stop - start));
        let time = start + ((time - start) / grid - 1e-9).ceil() * grid;
        if from == to || !from.is_finite() || !to.is_finite() {
            bail!("the manual value steps from {from} to {to}: they must be two different finite numbers");
        }
        if !(start < time && time < stop) {
            bail!("the step in the manual value is at {time} s: it must be between {start} and {stop} s");
        }
        let setting = |variable: &String, value: Value, time: Option<f64>| Setting {
            variable: variable.clone(),
            value,
            time,
            is_preliminary: false,
            place: None,
        };
        let mut job = job.clone();
        job.system.stop = Some(stop);
        let is_of_step = |variable: &String| [&switch, &manual].contains(&variable);
        job.system.settings.retain(|of| of.time.is_none() && !is_of_step(&of.variable));
        job.system.settings.extend([
            setting(&switch, Value::Boolean(true), None),
            setting(&manual, Value::Number(from), None),
            setting(&manual, Value::Number(to), Some(time)),
        ]);
        job.system.record = [&manual, &process_value].map(|of| system::Recorded::from(of.as_str())).into();
        job.study.axes.retain(|axis| axis.time.is_none());
        Ok(Identification { job, manual, process_value, is_integrating: step.is_integrating })
    }

    /// Ms of the loop with a plant; infinite if the loop is unstable. `settings` override those in the loop.
    ///
    /// # Errors
    /// These settings have no linear form; the message names the reason.
    pub fn sensitivity(&self, plant: &Plant, settings: &Values) -> Result<f64> {
        let margins = margins::compute(plant, &self.law(settings)?, self.delay_of_pulses(settings));
        Ok(margins.sensitivity.unwrap_or(f64::INFINITY))
    }

    /// The plant identified from the recorded step. `settings` override those in the loop.
    ///
    /// # Errors
    /// The recording does not reveal the plant; the message names the reason and the remedy.
    pub fn identified(&self, of: &Identification, recording: &Recording, settings: &Values) -> Result<Identified> {
        let place = |name: &String| {
            let place = recording.columns.iter().position(|column| column.name == *name);
            place.with_context(|| format!("{name} is not recorded"))
        };
        let (manual, process_value) = (place(&of.manual)?, place(&of.process_value)?);
        let seen = &recording.columns[process_value];
        // An input appears in the row of its call; an output may appear in the next row.
        let late = usize::from(seen.is_before_step || seen.is_unread);
        let output: Vec<f64> = recording.column(process_value).skip(late).collect();
        let input: Vec<f64> = recording.column(manual).take(output.len()).collect();
        let recorded = Recorded { times: &recording.times[..output.len()], input: &input, output: &output };
        let answer = Answer::new(&recorded, of.is_integrating)?;
        let delay = self.delay_of_pulses(settings);
        let answer = if delay > 0.0 { answer.averaged(self.period(settings)) } else { answer };
        if answer.uncertainty() > NOISE {
            let identified = identify::identify(&recorded, Method::LeastSquares, of.is_integrating)?;
            return Ok(Identified { plant: self.modelled(&identified.model), fit: Some(identified.fit) });
        }
        let sampling = self.with(settings).sampling();
        let answer = answer.every((sampling / answer.interval).round().max(1.0) as usize);
        let plant = Plant::of_step(&answer.values, answer.interval, of.is_integrating, delay);
        Ok(Identified { plant, fit: None })
    }

    /// The plant specified by a model.
    pub fn modelled(&self, model: &Model) -> Plant {
        Plant::of_model(model, self.controller.sampling().max(self.step))
    }

    /// The delay, in seconds, by which pulses transmit a manipulated value: half their period, or 0 if the controller
    /// is called only once per period.
    fn delay_of_pulses(&self, settings: &Values) -> f64 {
        let (period, sampling) = (self.period(settings), self.with(settings).sampling().max(self.step));
        if period > sampling * (1.0 + 1e-9) { period / 2.0 } else { 0.0 }
    }

    /// The period of the pulses in seconds; 0 without pulses.
    fn period(&self, settings: &Values) -> f64 {
        let period = self.period.as_ref().map(|(name, value)| match settings.get(name) {
            Some(Value::Number(value)) => *value,
            _ => *value,
        });
        period.or(self.with(settings).own_period()).unwrap_or_default()
    }

    /// The name under which [`sensitivity`](Linear::sensitivity) accepts a variable of the loop: the bare name for a
    /// variable of the controller, `FMU.NAME` for the pulse former's period, `None` otherwise.
    pub fn own_name<'a>(&self, variable: &'a str) -> Option<&'a str> {
        let is_period = self.period.as_ref().is_some_and(|(name, _)| name == variable);
        if is_period { Some(variable) } else { own_name(variable, &self.controller.member.name) }
    }

    /// The controller with settings overridden.
    fn with(&self, settings: &Values) -> Controller {
        let Controller { member, table, roles, groups } = &self.controller;
        let mut values = member.values.clone();
        values.extend(settings.iter().map(|(name, value)| (name.clone(), *value)));
        let member = Member { values, ..member.clone() };
        Controller { member, table: table.clone(), roles: roles.clone(), groups: groups.clone() }
    }

    /// The linear law that the block computes; `values` override the settings in the loop.
    fn law(&self, values: &Values) -> Result<Law> {
        let controller = self.with(values);
        let fmu = &controller.member.fmu;
        let is_on =
            |place: usize| controller.roles.structure.get(place).is_none_or(|name| controller.value(name) != 0.0);
        let number = |place: usize| controller.roles.controller.get(place).map(|name| controller.value(name));
        if !is_on(0) {
            bail!("the P action of {fmu} is off: {SENSITIVITY_UNKNOWN}");
        }
        let sampling = controller.sampling();
        let gain = number(0).unwrap_or_default();
        let ti = number(1).filter(|_| is_on(1)).map(|ti| ti.max(sampling / 2.0));
        let td = number(2).filter(|td| is_on(2) && *td > 0.0).map(|td| td.max(sampling));
        let tm_lag = td.map_or(0.0, |td| number(3).unwrap_or(td / FILTER).max(sampling / 2.0));
        let calls = (self.step / sampling).round().max(1.0) as u32;
        Ok(Law { settings: Settings { gain, ti, td, tm_lag }, cycle: sampling, calls })
    }
}

/// The end of a message about a controller without a linear form: the remedy.
const SENSITIVITY_UNKNOWN: &str = "Ms cannot be computed for it; constrain overshoot instead of ms";

impl Identification {
    /// For each coordinate of a study's point, whether the points of the identification contain it.
    pub fn is_in_point(job: &Job) -> Vec<bool> {
        job.study.axes.iter().flat_map(|axis| axis.variables.iter().map(|_| axis.time.is_none())).collect()
    }
}

/// The settings of a member at the start.
fn of_member(job: &Job, name: &str) -> Values {
    let own = |setting: &&Setting| setting.time.is_none();
    let mut values = Values::new();
    let mut settings: Vec<&Setting> = job.system.settings.iter().filter(own).collect();
    // Those from a parameter file come first, so that other settings override them.
    settings.sort_by_key(|setting| !setting.is_preliminary);
    for setting in settings {
        if let Some(variable) = own_name(&setting.variable, name) {
            values.insert(variable.into(), setting.value);
        }
    }
    values
}

#[cfg(test)]
mod tests;
