//! The setup of a study, for `summary.html` and `summary.json`: the loop, its FMUs, and the properties common to all
//! runs.

use crate::experiment::Experiment;
use crate::hash;
use crate::read::Reading;
use anyhow::Result;
use host::package::Package;
use modeldescription::Description;
use modeldescription::digits::short;
use run::system::{Setting, System, Value, own_name};
use serde::Serialize;

/// The properties common to all runs of a study.
#[derive(Clone, Debug, Default, Serialize, PartialEq)]
pub struct Ran {
    /// The version of this program.
    pub plcfmu: String,
    /// The file name of the loop's description.
    #[serde(rename = "loop")]
    pub description: String,
    /// The start time of a run, in seconds.
    pub start: f64,
    /// The end time of a run, in seconds.
    pub stop: f64,
    /// The communication step, in seconds.
    pub step: f64,
    /// The FMUs.
    pub fmus: Vec<RanFmu>,
    /// The folder of the FMUs, relative to the folder of the study's file, if one was given with `--fmus`.
    #[serde(skip)]
    pub folder: Option<String>,
    /// The settings at the start, except those that axes vary.
    pub settings: Vec<Set>,
    /// The settings at later times.
    pub events: Vec<Set>,
    /// The connections, from output to input.
    pub connections: Vec<(String, String)>,
}

/// An FMU of a loop.
#[derive(Clone, Debug, Default, Serialize, PartialEq, Eq)]
pub struct RanFmu {
    /// Its name in the loop.
    pub name: String,
    /// The model's name.
    pub model: String,
    /// The model's version, if declared.
    pub version: Option<String>,
    /// The tool that generated it, if declared.
    pub tool: Option<String>,
    /// The SHA-256 hash of its file in hexadecimal.
    pub sha256: String,
}

/// A setting of a variable.
#[derive(Clone, Debug, Default, Serialize, PartialEq)]
pub struct Set {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// The value as text.
    pub value: String,
    /// Its unit, if the FMU declares one.
    pub unit: Option<String>,
    /// The time in seconds; `None` for the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
}

impl Ran {
    /// Collects the properties common to all runs of a study.
    ///
    /// # Errors
    /// An FMU cannot be read.
    pub fn new(reading: &Reading, experiment: &Experiment) -> Result<Ran> {
        let (system, plan) = (&reading.job.system, &experiment.plan);
        let descriptions = system.members.iter().map(|member| Ok(Package::open(&member.path)?.description));
        let descriptions = descriptions.collect::<Result<Vec<Description>>>()?;
        let fmus = system.members.iter().zip(&descriptions).map(|(member, of)| {
            Ok(RanFmu {
                name: member.name.clone(),
                model: of.model_name.clone(),
                version: of.version.clone(),
                tool: of.generation_tool.clone(),
                sha256: hash(&member.path)?,
            })
        });
        let is_varied = |of: &Setting| experiment.coordinates.iter().any(|other| other.name == of.variable);
        let is_replaced = |of: &Setting| {
            let is_other = |other: &Setting| other.variable == of.variable && other.time.is_none();
            of.is_preliminary && system.settings.iter().any(|other| !other.is_preliminary && is_other(other))
        };
        let at_start = |of: &&Setting| of.time.is_none() && !is_varied(of) && !is_replaced(of);
        let set = |of: &Setting| Set::new(of, system, &descriptions);
        Ok(Ran {
            plcfmu: env!("CARGO_PKG_VERSION").into(),
            description: reading.description.clone(),
            start: plan.time(0),
            stop: plan.time(plan.steps),
            step: plan.step,
            fmus: fmus.collect::<Result<_>>()?,
            folder: reading.fmus.clone(),
            settings: system.settings.iter().filter(at_start).map(set).collect(),
            events: system.settings.iter().filter(|of| of.time.is_some()).map(set).collect(),
            connections: system.connections.iter().map(|of| (of.from.clone(), of.to.clone())).collect(),
        })
    }
}

impl Set {
    fn new(setting: &Setting, system: &System, descriptions: &[Description]) -> Set {
        let unit = system
            .members
            .iter()
            .zip(descriptions)
            .find_map(|(member, of)| of.variable(own_name(&setting.variable, &member.name)?)?.unit.clone());
        let value = match setting.value {
            Value::Boolean(value) => value.to_string(),
            Value::Whole(whole) => whole.to_string(),
            Value::Number(number) => short(number),
        };
        Set { variable: setting.variable.clone(), value, unit, time: setting.time }
    }

    /// `PUMP.SPEED = 60 1/min`
    pub fn text(&self) -> String {
        let Set { variable, value, .. } = self;
        match &self.unit {
            Some(unit) => format!("{variable} = {value} {unit}"),
            None => format!("{variable} = {value}"),
        }
    }
}
