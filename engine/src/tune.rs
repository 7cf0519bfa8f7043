//! Settings of a controller for a plant's model, by the known rules, and what they lead to.

use crate::identify::Model;
use crate::message::Values;
use serde::{Deserialize, Serialize};

/// What to tune.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// The plant.
    pub model: Model,
    /// The rule.
    pub rule: Rule,
    /// P, PI or PID.
    pub structure: Structure,
    /// The controller with its present settings: CYCLE, the normalisation and the pulse former count.
    pub controller: crate::message::Member,
    /// The time constant of the closed loop that SIMC is given, in seconds; the dead time without it.
    #[serde(default)]
    pub closed_loop: Option<f64>,
    /// Ultimate gain and period, for the ultimate rule; computed from the model without it.
    #[serde(default)]
    pub ultimate: Option<(f64, f64)>,
    /// The period of a pulse former behind the controller, in seconds; that of the controller's own one without it.
    #[serde(default)]
    pub pulse_period: Option<f64>,
    /// How long the actuator of a step controller takes from stop to stop, in seconds; the controller's own setting without it.
    #[serde(default)]
    pub motor_time: Option<f64>,
    /// The step of the setpoint that is simulated, in units of the process value; by default the tenth of what the process value
    /// does over 100 % of the manipulated value, and of an integrating plant as much as moves it by 10 % at first.
    #[serde(default)]
    pub setpoint_step: Option<f64>,
}

/// A rule.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// Ziegler and Nichols, from the step answer.
    ZieglerNicholsStep,
    /// Ziegler and Nichols, from the ultimate gain.
    ZieglerNicholsUltimate,
    /// Chien, Hrones and Reswick, setpoint, 0 %.
    ChrSetpoint0,
    /// Chien, Hrones and Reswick, setpoint, 20 %.
    ChrSetpoint20,
    /// Chien, Hrones and Reswick, disturbance, 0 %.
    ChrDisturbance0,
    /// Chien, Hrones and Reswick, disturbance, 20 %.
    ChrDisturbance20,
    /// Skogestad.
    Simc,
    /// Astroem and Haegglund.
    Amigo,
}

/// Which actions the controller has.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// Proportional.
    P,
    /// Proportional and integral.
    Pi,
    /// Proportional, integral and derivative.
    Pid,
}

/// Settings and what they lead to.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Tuned {
    /// The settings in the block's form, by the block's names, the switches of the structure included.
    pub values: Values,
    /// The dead time that was used: the model's, half a cycle, half a pulse period.
    pub dead_time: f64,
    /// The largest sensitivity.
    pub sensitivity: Option<f64>,
    /// How much more gain the loop takes, as a factor.
    pub gain_margin: Option<f64>,
    /// The phase margin in degrees.
    pub phase_margin: Option<f64>,
    /// The simulated setpoint step of the real block with the model.
    pub predicted: Predicted,
    /// What the user should know, a sentence each.
    pub remarks: Vec<String>,
}

/// A heating and a cooling step.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RatioRequest {
    /// The plant with the manipulated value above 0.
    pub heating: Model,
    /// The plant with the manipulated value below 0.
    pub cooling: Model,
}

/// How a three-step pulse former makes up for heating and cooling of different strength.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Ratio {
    /// RATIOFAC.
    pub ratio: f64,
    /// The model to tune the controller with: the weaker gain, the longer dead time.
    pub model: Model,
    /// What the user should know, a sentence each.
    pub remarks: Vec<String>,
}

/// A simulated loop.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
pub struct Predicted {
    /// In seconds.
    pub times: Vec<f64>,
    /// The setpoint.
    pub setpoint: Vec<f64>,
    /// The process value.
    pub process_value: Vec<f64>,
    /// The manipulated value.
    pub manipulated_value: Vec<f64>,
    /// Its overshoot in percent of the step.
    pub overshoot: Option<f64>,
    /// When it has settled, in seconds.
    pub settled: Option<f64>,
}
