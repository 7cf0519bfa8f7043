//! What a study has run, for its page and its file for programs: the loop, its FMUs, and what all runs have in common.

use crate::experiment::Experiment;
use crate::hash;
use crate::read::Reading;
use anyhow::Result;
use host::package::Package;
use modeldescription::Description;
use modeldescription::digits::short;
use run::system::{Setting, System, Value, own_name};
use serde::Serialize;

/// What all runs of a study have in common.
#[derive(Clone, Debug, Default, Serialize, PartialEq)]
pub struct Ran {
    /// The version of this program.
    pub plcfmu: String,
    /// The file of the loop's description, without its folder.
    #[serde(rename = "loop")]
    pub description: String,
    /// When a run begins, in seconds.
    pub start: f64,
    /// When it ends.
    pub stop: f64,
    /// The time between two exchanges of values.
    pub step: f64,
    /// The FMUs.
    pub fmus: Vec<RanFmu>,
    /// The folder of the FMUs, from that of the study's file, if it was named.
    #[serde(skip)]
    pub folder: Option<String>,
    /// What is set at the start, where no axis sets it.
    pub settings: Vec<Set>,
    /// What is set later.
    pub events: Vec<Set>,
    /// From which output to which input.
    pub connections: Vec<(String, String)>,
}

/// An FMU of a loop.
#[derive(Clone, Debug, Default, Serialize, PartialEq, Eq)]
pub struct RanFmu {
    /// Its name in the loop.
    pub name: String,
    /// The model's name.
    pub model: String,
    /// The model's version, if it says one.
    pub version: Option<String>,
    /// The tool that made it, if it says one.
    pub tool: Option<String>,
    /// The SHA-256 of its file in hexadecimal digits.
    pub sha256: String,
}

/// A value that is set.
#[derive(Clone, Debug, Default, Serialize, PartialEq)]
pub struct Set {
    /// `FMU.VARIABLE`
    pub variable: String,
    /// The value as text.
    pub value: String,
    /// Its unit, if the FMU names one.
    pub unit: Option<String>,
    /// When, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
}

impl Ran {
    /// What a study that was read has run.
    ///
    /// # Errors
    /// An FMU cannot be read.
    pub fn of(reading: &Reading, experiment: &Experiment) -> Result<Ran> {
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
        let set = |of: &Setting| Set::of(of, system, &descriptions);
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
    fn of(setting: &Setting, system: &System, descriptions: &[Description]) -> Set {
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
