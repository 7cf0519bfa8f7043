//! Settings of a controller for a plant model by the tuning rules, with the resulting margins and responses.
//!
//! The [`rules`] apply to a plant with gain, lag and dead time. This module converts their results into the settings of
//! a block:
//!
//! - The dead time passed to the rules is the plant's, plus half a CYCLE for the hold of the manipulated value, plus
//!   half a period of the pulse former if there is one. If a block runs its controller only in every n-th call, the
//!   period is n calls.
//! - GAIN is divided by the factor that the block applies internally to its manipulated value (LMN_FAC), which is
//!   measured in manual mode. The model's gain includes all other factors, see [`Model`].
//! - TI, TD and TM_LAG are whole milliseconds, and not below the values to which the block raises them: half the time
//!   between two calls of the controller, and for TD the whole of it. TM_LAG is a tenth of TD ([`rules::FILTER`]). They
//!   and GAIN are rounded to [`DIGITS`] significant digits.
//! - The switches of the actions are set for P, PI or PID. A step controller has PI only; its motor time is not a lag
//!   of the plant.
//!
//! The margins are those of these settings, with the control law computed in each call as in the block, and with the
//! plant's own dead time.

use crate::extremes;
use crate::figures::BAND;
use crate::identify::Model;
use crate::margins::{self, Law, Margins, Plant};
use crate::predict;
use crate::rules::{self, Rule, Settings, Structure};
use anyhow::{Context, Result, bail};
use blocks::{Kind, Role};
use modeldescription::Table;
use modeldescription::digits::short;
use run::dialog::{self, Group, Roles};
use run::fmus::Fmus;
use run::fmus::{Member, Values, number_of};
use run::system::{Exchange, Value};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The number of significant digits of a setting. A table shows all of them, so the displayed value is the one
/// applied. A step test is no more precise.
pub const DIGITS: i32 = 3;
/// The longest TIME of a PLC, in seconds.
const LONGEST: f64 = 2_147_483.647;
/// The Ms above which a loop is not very robust.
const USUAL_SENSITIVITY: f64 = 2.0;
/// If no speed has been chosen, SIMC makes the closed loop slower than the textbook value of one dead time by this
/// factor. A second lag counts fully as dead time here: if only half of it counted, as in the half rule, a furnace
/// would overshoot by 10 % instead of 3 %. A model with one lag does not reproduce the initial response of a plant with
/// more lags; with a closed-loop time constant of one dead time, such a plant overshoots by up to 9 %.
const CALMER: f64 = 1.5;
/// The permitted range of RATIOFAC.
const RATIOS: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// The controller to tune, the plant's model and the rule.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct TuneRequest {
    /// The plant model.
    pub model: Model,
    /// The tuning rule.
    pub rule: Rule,
    /// P, PI or PID.
    pub structure: Structure,
    /// The controller with its current settings. The rules use its timing and scaling; the prediction and the remarks
    /// use all settings.
    pub controller: Member,
    /// The closed-loop time constant in seconds, for the rules SIMC and lambda. By default, it is the dead time for
    /// SIMC (1.5 dead times in the table of all rules); for lambda, it is the plant's time constant or three dead
    /// times, whichever is longer.
    #[serde(default)]
    pub closed_loop: Option<f64>,
    /// This time constant as a position on a scale: 0 is calm, 1 is fast. `closed_loop` takes precedence.
    #[serde(default)]
    pub pace: Option<f64>,
    /// The setpoint step to predict.
    #[serde(default)]
    pub step: Step,
    /// Half the width of the band around the setpoint in which the loop counts as recovered from a load, in the unit of
    /// the process value, above 0; if there is a run, 2 % of its last step. By default, 2 % of the default predicted
    /// step.
    #[serde(default)]
    pub band: Option<f64>,
    /// Ultimate gain and period, for the ultimate rule; by default computed from the model.
    #[serde(default)]
    pub ultimate: Option<(f64, f64)>,
    /// When the loop exchanges its values; the prediction has the rows of a run with this exchange.
    #[serde(default)]
    pub exchange: Exchange,
}

/// A setpoint step.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct Step {
    /// The setpoint before the step; by default the controller's current one.
    pub from: Option<f64>,
    /// The size of the step, negative for a step down; by default, the step after which the manipulated value is 10 %
    /// higher in steady state or, if the plant is integrating, initially.
    pub size: Option<f64>,
    /// The manual value at which the plant rests before the step, in percent; by default 50.
    pub manual: Option<f64>,
}

/// Settings and their predicted effects.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Tuned {
    /// The settings in the block's form, by the block's names, including the switches of the structure.
    pub values: Values,
    /// The dead time used, in seconds: the model's, plus half a cycle, plus half a pulse period.
    pub dead_time: f64,
    /// The closed-loop time constant used, in seconds, if the rule has one.
    pub closed_loop: Option<f64>,
    /// This time constant as a position on a scale from calm, 0, to fast, 1, as the request may specify it.
    pub pace: Option<f64>,
    /// Ms, the largest sensitivity; absent if the loop is unstable.
    pub sensitivity: Option<f64>,
    /// The gain margin, as a factor.
    pub gain_margin: Option<f64>,
    /// The phase margin in degrees.
    pub phase_margin: Option<f64>,
    /// The simulated setpoint step of the loop of the real block and the model.
    pub predicted: Predicted,
    /// The reasons for missing metrics, by the names of their fields: `sensitivity`, `gain_margin`, `phase_margin`,
    /// `overshoot`, `settling`, `travel`, and `deviation`, `recovery` and `iae` of the load.
    #[serde(default)]
    pub absent: BTreeMap<String, String>,
    /// Remarks for the user, one sentence each.
    pub remarks: Vec<String>,
}

/// A rule and its predicted effects.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct RuleOutcome {
    /// The rule.
    pub rule: Rule,
    /// The rule's name for users.
    pub name: String,
    /// The settings, and the prediction for the same step as in all other rows.
    pub tuned: Option<Tuned>,
    /// The reason why there are no settings, if there are none.
    pub refusal: Option<String>,
}

/// A heating and a cooling step.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct RatioRequest {
    /// The plant with the manipulated value above 0.
    pub heating: Model,
    /// The plant with the manipulated value below 0.
    pub cooling: Model,
}

/// The compensation of a three-step pulse former for heating and cooling of different strength.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Ratio {
    /// The value for RATIOFAC.
    pub ratio: f64,
    /// The model for tuning the controller: the one with the smaller gain, but with the longer of the two dead times.
    pub model: Model,
    /// Remarks for the user, one sentence each.
    pub remarks: Vec<String>,
}

/// The simulated response of a loop to a setpoint step and to a load.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Predicted {
    /// The times of the points in seconds.
    pub times: Vec<f64>,
    /// The setpoint at these times.
    pub setpoint: Vec<f64>,
    /// The process value at these times.
    pub process_value: Vec<f64>,
    /// The manipulated value at these times.
    pub manipulated_value: Vec<f64>,
    /// The overshoot of the process value in percent of the step.
    pub overshoot: Option<f64>,
    /// The settling time of the process value in seconds.
    pub settling: Option<f64>,
    /// The total travel of the manipulated value after the step, in its unit.
    pub travel: Option<f64>,
    /// The effect of a disturbance: a load of 10 % of the manipulated value at the plant's input, from the same steady
    /// state.
    pub load: Option<Load>,
}

/// The loop after a load step at the plant's input.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Load {
    /// The load at the plant's input, in percent of the manipulated value, with the sign that leaves the manipulated
    /// value more room to compensate for it.
    pub size: f64,
    /// The largest deviation from the setpoint, in the setpoint's unit.
    pub deviation: f64,
    /// The time in seconds from the load until the deviation stays within the band; `None` if it does not.
    pub recovery: Option<f64>,
    /// The integral of the absolute error, in the unit of the setpoint times seconds; absent if the loop does not
    /// recover.
    pub iae: Option<f64>,
    /// Half the width of the band around the setpoint in which the loop counts as recovered, in the setpoint's unit.
    pub band: f64,
}

/// A control block with its current settings.
pub struct Controller {
    /// The block's name, its FMU and its current settings.
    pub member: Member,
    /// The table of its variables.
    pub table: Arc<Table>,
    /// The roles of its variables.
    pub roles: Roles,
    /// Its settings in the groups of the parameter dialog.
    pub groups: Vec<Group>,
}

impl Controller {
    /// Returns the controller of a request.
    ///
    /// # Errors
    /// The FMU does not exist or is not a controller with known settings, or a setting does not exist.
    pub fn new(home: &dyn Fmus, member: &Member) -> Result<Controller> {
        let fmu = &member.fmu;
        let table = home.table(fmu)?.with_context(|| {
            format!("{fmu} is a foreign FMU: the meaning of its settings is unknown, so it cannot be tuned")
        })?;
        Controller::of_table(member, &table)
    }

    /// Like [`Controller::new`], for an FMU with a known table.
    ///
    /// # Errors
    /// As in [`Controller::new`].
    pub fn of_table(member: &Member, table: &Arc<Table>) -> Result<Controller> {
        let (fmu, table) = (&member.fmu, table.clone());
        let (roles, groups) = dialog::read(&table)?;
        if roles.controller.is_empty() {
            bail!("{fmu} is not a controller with a GAIN: choose the FMU that has GAIN and TI");
        }
        if let Some(unknown) = member.values.keys().find(|name| table.find(name).is_none()) {
            bail!("{fmu} has no variable {unknown}");
        }
        let controller = Controller { member: member.clone(), table, roles, groups };
        let cycle = controller.cycle();
        if !(0.001..=LONGEST).contains(&cycle) {
            bail!("the time between two calls is {cycle} s: it must be between 0.001 s and {LONGEST} s");
        }
        Ok(controller)
    }

    /// Returns the value set for a variable, or its start value if it is not set; TRUE is 1.
    pub fn value(&self, name: &str) -> f64 {
        let start = || self.table.find(name).map_or(0.0, |row| self.table.rows[row].start());
        self.member.values.get(name).map_or_else(start, |value| number_of(*value))
    }

    /// Returns the PLC type of a variable.
    pub fn kind(&self, name: &str) -> Option<Kind> {
        self.table.find(name).map(|row| self.table.rows[row].kind)
    }

    /// Returns the role of a variable: who sets it, and when.
    pub fn role(&self, name: &str) -> Option<Role> {
        self.table.find(name).map(|row| self.table.rows[row].role)
    }

    /// Returns the time between two calls in seconds.
    pub fn cycle(&self) -> f64 {
        self.value(self.cycle_setting())
    }

    /// Returns the name of the setting for the time between two calls.
    pub fn cycle_setting(&self) -> &str {
        &self.table.rows[self.table.cycle].name
    }

    /// Whether the block drives an actuator by pulses up and down, without position feedback.
    pub fn is_step_controller(&self) -> bool {
        self.roles.manipulated_value.is_none() && !self.roles.pulses.is_empty() && self.roles.pulse_former.is_empty()
    }

    /// Returns the period of the controller's own pulse former in seconds. It is set as a time, or as the number of
    /// calls per call of the controller.
    pub fn own_period(&self) -> Option<f64> {
        let name = self.roles.pulse_former.first().filter(|_| !self.roles.pulses.is_empty())?;
        let value = self.value(name);
        Some(if self.kind(name) == Some(Kind::Time) { value } else { value.max(1.0) * self.cycle() })
    }

    /// Returns the number of calls in a period of the controller's own pulses, with `step` seconds between calls; 1
    /// without pulses.
    pub fn period_in_calls(&self, step: f64) -> usize {
        self.own_period().map_or(1, |period| (period / step).round().max(1.0) as usize)
    }

    /// Returns the dead time in seconds that calls and pulses add: half a cycle plus half a pulse period.
    pub fn delay_of_calls(&self) -> f64 {
        self.cycle() / 2.0 + self.own_period().unwrap_or_default() / 2.0
    }

    /// Returns the time between two calls of the controller inside the block, in seconds.
    pub fn sampling(&self) -> f64 {
        let is_count = |name: &&String| self.kind(name) != Some(Kind::Time);
        let has_count =
            !self.roles.pulses.is_empty() && self.roles.pulse_former.first().is_some_and(|name| is_count(&name));
        self.own_period().filter(|_| has_count).unwrap_or_else(|| self.cycle())
    }

    /// Returns the delay in seconds that the block's own pulse former adds to a manipulated value: half a period; none
    /// if the controller is called once per period, because the hold between its calls already includes it.
    pub fn delay_of_pulses(&self) -> f64 {
        let sampling = self.sampling();
        self.own_period().filter(|period| *period > sampling).map_or(0.0, |period| period / 2.0)
    }

    /// Returns the control law with settings in the block's form, if the block finally multiplies its manipulated value
    /// by `factor`.
    pub fn law(&self, settings: &Settings, factor: f64) -> Law {
        Law { settings: Settings { gain: settings.gain * factor, ..*settings }, cycle: self.sampling(), calls: 1 }
    }

    /// Returns the time in seconds that a step controller's actuator takes from stop to stop: the setting of type TIME
    /// in the group that contains its end stops.
    pub fn motor_time(&self) -> Option<f64> {
        self.motor_time_setting().filter(|_| self.is_step_controller()).map(|name| self.value(name))
    }

    /// Returns the name of the setting for the actuator's travel time.
    pub fn motor_time_setting(&self) -> Option<&str> {
        let is_stop = |name: &str| self.roles.stops().any(|stop| stop == name);
        let group = self.groups.iter().find(|group| group.fields.iter().any(|field| is_stop(&field.name)))?;
        let time = group.fields.iter().find(|field| self.kind(&field.name) == Some(Kind::Time))?;
        Some(&time.name)
    }

    /// Rejects a structure that the controller does not have.
    fn require(&self, structure: Structure) -> Result<()> {
        let (fmu, actions) = (&self.member.fmu, self.roles.controller.len());
        match structure {
            Structure::P | Structure::Pid if self.is_step_controller() => {
                bail!("{fmu} is a step controller, which has PI only: use PI")
            }
            Structure::Pid if actions < 3 => bail!("{fmu} has no D action: use PI"),
            Structure::Pi | Structure::Pid if actions < 2 => bail!("{fmu} has no I action: use P"),
            Structure::P if actions > 1 && self.roles.structure.len() < 2 => {
                bail!("the I action of {fmu} cannot be switched off: use PI")
            }
            Structure::Pi if actions > 2 && self.roles.structure.len() < 3 => {
                bail!("the D action of {fmu} cannot be switched off: use PID")
            }
            _ => Ok(()),
        }
    }
}

/// A GAIN that is more than this many times the current one causes a warning.
const MOST_TIMES: f64 = 10.0;
/// So does a GAIN at which a deviation below this fraction of the step moves the manipulated value by 100 %.
const LEAST_DEVIATION: f64 = 0.1;
/// With a λ that the user did not choose, the initial movement of the manipulated value is at most this many times the
/// final one.
const MOST_AT_FIRST: f64 = 10.0;
/// Travel of the manipulated value beyond 0 counts if it is at least this fraction of its range.
const CROSSED: f64 = 0.05;

/// Computes the block's settings by a rule, with the resulting margins and responses.
///
/// # Errors
/// The FMU is not a controller, or the rule has no formula for the plant or the structure; the error names a rule that
/// works.
pub fn tune(home: &dyn Fmus, request: &TuneRequest) -> Result<Tuned> {
    tune_calmer(home, request, None)
}

/// Like [`tune`], but with a closed loop slower than the rule's by the factor `calmer`, unless the request specifies
/// its speed.
fn tune_calmer(home: &dyn Fmus, request: &TuneRequest, calmer: Option<f64>) -> Result<Tuned> {
    let controller = Controller::new(home, &request.controller)?;
    controller.require(request.structure)?;
    request.model.check()?;
    let mut remarks = Vec::new();
    let added = controller.delay_of_calls();
    let model = Model { dead_time: request.model.dead_time + added, ..request.model };
    let has_period = controller.own_period().is_some_and(|period| period > 0.0);
    let what = if has_period { "half of CYCLE and half of the pulse period" } else { "half of CYCLE" };
    if added > request.model.dead_time {
        remarks.push(format!(
            "Sampling adds more delay than the plant's dead time: {} s ({what}) in addition to {} s. Shorter times \
             allow a higher GAIN.",
            short(added),
            short(rounded(request.model.dead_time, 3))
        ));
    }
    remarks.extend(half_rule(request, &model, what));
    if let Some(pace) = request.pace.filter(|pace| !(0.0..=1.0).contains(pace)) {
        bail!("the pace is {pace}: it must be between 0 (calm) and 1 (fast)");
    }
    let usual = rules::closed_loop(request.rule, &model);
    let paced = || request.pace.map(|pace| rules::paced(pace, &model));
    // The D action of PID compensates for the second lag.
    let delay = match request.structure {
        Structure::Pid => usual,
        _ => Some(model.dead_time + model.second_time_constant.min(model.time_constant)),
    };
    let delay = if model.is_integrating { usual } else { delay };
    let plain = model.without_second_lag();
    let least = if model.is_integrating { 0.0 } else { plain.time_constant / MOST_AT_FIRST - plain.dead_time };
    let chosen = request.closed_loop.or_else(paced).or_else(|| Some((calmer? * delay?).max(least)));
    let closed_loop = usual.map(|usual| chosen.unwrap_or(usual));
    let ideal = rules::settings(request.rule, request.structure, &model, closed_loop.and(chosen), request.ultimate)?;
    let factor = predict::output_factor(home, &controller)?.unwrap_or(1.0);
    if factor != 1.0 {
        remarks.push(format!(
            "{} finally multiplies its manipulated value by {}: GAIN is {} times the rule's value.",
            controller.member.fmu,
            short(factor),
            short(1.0 / factor)
        ));
    }
    let settings = in_form_of(&controller, &Settings { gain: ideal.gain / factor, ..ideal }, &mut remarks)?;
    let law = controller.law(&settings, factor);
    let plant = Plant::of_model(&request.model, controller.sampling());
    let margins = margins::compute(&plant, &law, controller.delay_of_pulses());
    remarks.extend(robustness(&margins));
    remarks.extend(coarseness(&controller, request));
    let values = values(&controller, request.structure, &settings);
    let mut absent = unknown(&margins);
    let predicted = match predict::predict(home, &controller, request, &values) {
        Ok((predicted, told)) => {
            remarks.extend(told.remarks);
            remarks.extend(crossing(&controller, &predicted));
            remarks.extend(looseness(&controller, request, &predicted));
            absent.extend(told.absent);
            predicted
        }
        Err(error) => {
            remarks.push(format!("No curve can be predicted: {error:#}."));
            let all = ["overshoot", "settling", "travel", "deviation", "recovery", "iae"];
            absent.extend(all.map(|metric| (metric.to_string(), format!("{error:#}"))));
            Predicted::default()
        }
    };
    // Without a predicted step, the height is 0, and only a GAIN far above the current one is reported.
    let height = predicted.setpoint.last().zip(predicted.setpoint.first()).map_or(0.0, |(to, from)| to - from);
    remarks.extend(nervousness(&controller, &settings, (factor, height), closed_loop.is_some()));
    Ok(Tuned {
        values,
        dead_time: model.dead_time,
        closed_loop,
        pace: closed_loop.and_then(|closed_loop| rules::pace(closed_loop, &model)),
        sensitivity: margins.sensitivity,
        gain_margin: margins.gain_margin,
        phase_margin: margins.phase_margin,
        predicted,
        absent,
        remarks,
    })
}

/// Returns the reasons for missing margins.
pub(crate) fn unknown(margins: &Margins) -> BTreeMap<String, String> {
    let no_gain = if margins.is_stable() { "no higher gain makes the loop unstable" } else { "the loop is unstable" };
    let all = [
        ("sensitivity", margins.sensitivity, "the loop is unstable"),
        ("gain_margin", margins.gain_margin, no_gain),
        ("phase_margin", margins.phase_margin, "the open-loop gain is not 1 at any frequency"),
    ];
    all.into_iter().filter(|(_, value, _)| value.is_none()).map(|(name, _, why)| (name.into(), why.into())).collect()
}

/// Computes all rules with the structure of the request, for the user to choose from. The request's own rule is
/// ignored.
///
/// # Errors
/// The FMU is not a controller or does not have this structure, or the model is not a valid plant.
pub fn table(home: &dyn Fmus, request: &TuneRequest) -> Result<Vec<RuleOutcome>> {
    Controller::new(home, &request.controller)?.require(request.structure)?;
    request.model.check()?;
    let row = |rule: Rule| {
        let calmer = (rule == Rule::Simc).then_some(CALMER);
        let tuned = tune_calmer(home, &TuneRequest { rule, ..request.clone() }, calmer);
        let refusal = tuned.as_ref().err().map(|error| format!("{error:#}"));
        RuleOutcome { rule, name: rules::name(rule).into(), tuned: tuned.ok(), refusal }
    };
    Ok(Rule::ALL.map(row).into())
}

/// Computes RATIOFAC, the ratio of the strengths of negative and positive pulses: the heating gain divided by the
/// cooling gain.
///
/// # Errors
/// A model is not a valid plant, or only one of the two is integrating.
pub fn ratio(heating: &Model, cooling: &Model) -> Result<Ratio> {
    heating.check().context("heating")?;
    cooling.check().context("cooling")?;
    if heating.is_integrating != cooling.is_integrating {
        bail!("one of the two plants is integrating, but the other is not: identify both in the same way");
    }
    let ratio = rounded((heating.gain / cooling.gain).abs(), DIGITS);
    let mut remarks = Vec::new();
    if !RATIOS.contains(&ratio) {
        remarks.push(format!(
            "RATIOFAC = {ratio} is outside {} ... {}: heating and cooling are too different for one controller.",
            RATIOS.start(),
            RATIOS.end()
        ));
    }
    let weaker = if ratio > 1.0 { cooling } else { heating };
    let (slow, fast) = if heating.dead_time >= cooling.dead_time { (heating, cooling) } else { (cooling, heating) };
    if slow.dead_time > 1.5 * fast.dead_time {
        remarks.push(format!(
            "The dead times differ, {} and {} s: tune the controller for the longer one.",
            heating.dead_time, cooling.dead_time
        ));
    }
    let gain = weaker.gain.abs().copysign(heating.gain);
    Ok(Ratio { ratio, model: Model { gain, dead_time: slow.dead_time, ..*weaker }, remarks })
}

/// Returns the remark about a second lag that the rule does not support. The dead time of `model` includes the delay of
/// sampling, which `sampling` describes in words.
fn half_rule(request: &TuneRequest, model: &Model, sampling: &str) -> Option<String> {
    let knows_two = request.rule == Rule::ZieglerNicholsUltimate
        || request.rule == Rule::Simc && request.structure == Structure::Pid;
    if request.model.second_time_constant == 0.0 || knows_two {
        return None;
    }
    let Model { time_constant, dead_time, .. } = model.without_second_lag();
    let rule = rules::name(request.rule);
    let dead_time = short(rounded(dead_time, 4));
    Some(if model.is_integrating {
        format!(
            "{rule} supports no lag of an integrating plant: the lag is added to the dead time, so that, with {sampling}, \
             L = {dead_time} s. The margins take the lag into account."
        )
    } else {
        format!(
            "{rule} supports only one lag: half of the smaller one is added to the time constant and half to the dead \
             time, so that T = {} s and, with {sampling}, L = {dead_time} s. The margins take both lags into account.",
            short(rounded(time_constant, 4))
        )
    })
}

/// Rounds the settings to values that the block can hold. A time that the block would raise is raised, with a remark.
fn in_form_of(controller: &Controller, ideal: &Settings, remarks: &mut Vec<String>) -> Result<Settings> {
    let sampling = controller.sampling();
    let time = |place: usize, time: f64, lowest: f64, remarks: &mut Vec<String>| {
        let Some(name) = controller.roles.controller.get(place) else { return Ok(time) };
        if time > LONGEST {
            bail!(
                "{name} would be {time:.0} s, but the longest TIME is {LONGEST} s: choose another rule or a \
                 faster closed loop"
            );
        }
        let whole = (rounded(time, DIGITS) * 1000.0).round() / 1000.0;
        if whole >= lowest {
            return Ok(whole);
        }
        let advice =
            if place == 2 { ": the D action is slower than the rule intends; use PI or a shorter CYCLE" } else { "" };
        let bound = if place == 2 { "the time between two calls" } else { "half the time between two calls" };
        remarks.push(format!(
            "{name} = {whole} s is below {bound}: the block would use {lowest} s, so {name} is set to that{advice}."
        ));
        Ok((lowest * 1000.0).ceil() / 1000.0)
    };
    let ti = ideal.ti.map(|ti| time(1, ti, sampling / 2.0, remarks)).transpose()?;
    let td = ideal.td.map(|td| time(2, td, sampling, remarks)).transpose()?;
    let tm_lag = if td.is_some() { time(3, ideal.tm_lag, sampling / 2.0, remarks)? } else { 0.0 };
    Ok(Settings { gain: rounded(ideal.gain, DIGITS), ti, td, tm_lag })
}

fn robustness(margins: &margins::Margins) -> Option<String> {
    match margins.sensitivity {
        None => Some("The loop would be unstable with these settings: use another rule.".into()),
        Some(sensitivity) if sensitivity > USUAL_SENSITIVITY => Some(format!(
            "Ms = {sensitivity:.2}: the loop overshoots and tolerates little change in the plant; {USUAL_SENSITIVITY} \
             or less is usual."
        )),
        Some(_) => None,
    }
}

/// Returns the remark that a GAIN is far above the one in force, or that a small fraction of the step moves the
/// manipulated value from limit to limit: noise and unmodelled dynamics then move it, too.
fn nervousness(
    controller: &Controller,
    settings: &Settings,
    (factor, height): (f64, f64),
    has_speed: bool,
) -> Option<String> {
    let name = controller.roles.controller.first()?;
    let times = (settings.gain / controller.value(name)).abs();
    let is_far = times.is_finite() && times > MOST_TIMES;
    let whole = (100.0 / (settings.gain * factor)).abs();
    (is_far || whole < LEAST_DEVIATION * height.abs()).then(|| {
        let far =
            if is_far { format!(" is {} times the current one", short(rounded(times, 2))) } else { String::new() };
        format!(
            "{name} = {}{far}: a deviation of {} moves the manipulated value by 100 %; noise and the resolution of the \
             input are amplified likewise.{}",
            short(settings.gain),
            short(rounded(whole, 2)),
            if has_speed { " A larger λ results in a lower gain." } else { "" }
        )
    })
}

/// Returns the remark that the manipulated value changes sign in the predicted step, if it may be below 0: most plants
/// respond differently to heating and cooling, and the model covers only one of them.
fn crossing(controller: &Controller, predicted: &Predicted) -> Option<String> {
    let (_, low) = controller.roles.limits.as_ref()?;
    let (lowest, highest) = extremes(&predicted.manipulated_value);
    let is_crossed = (-lowest).min(highest) > CROSSED * (highest - lowest);
    (controller.value(low) < 0.0 && is_crossed).then(|| {
        format!(
            "In this step, the manipulated value goes from {} to {}: a plant that responds differently below 0, such \
             as one that is heated and cooled, does not follow a prediction based on one model.",
            short(rounded(highest, 2)),
            short(rounded(lowest, 2))
        )
    })
}

/// Returns the duration of a step controller's shortest pulse, in seconds, and how far it moves the process value.
fn shortest_pulse(controller: &Controller, model: &Model) -> Option<(f64, f64)> {
    let pulse = controller.roles.shortest_pulse.as_ref().filter(|_| controller.is_step_controller())?;
    let seconds = controller.value(pulse).max(controller.cycle());
    let motor_time = controller.motor_time().filter(|time| *time > 0.0 && !model.is_integrating)?;
    Some((seconds, (model.gain * 100.0 * seconds / motor_time).abs()))
}

/// Returns the remark that a step controller never comes to rest, if its shortest pulse moves the process value by more
/// than twice the dead band.
fn coarseness(controller: &Controller, request: &TuneRequest) -> Option<String> {
    let (seconds, moved) = shortest_pulse(controller, &request.model)?;
    let (pulse, dead_band) = (controller.roles.shortest_pulse.as_ref()?, controller.roles.dead_band.as_ref()?);
    (controller.value(dead_band) < moved / 2.0).then(|| {
        format!(
            "The shortest pulse of {} s moves the process value by {}, and {dead_band} = {} is less than half of it: \
             the loop will not settle. Shorten {pulse} or CYCLE, or set {dead_band} to {}.",
            short(seconds),
            short(moved),
            short(controller.value(dead_band)),
            short(rounded(moved / 2.0, 3))
        )
    })
}

/// Returns the remark that the settling time of the step is a matter of chance: the process value can stop anywhere in
/// the dead band or, after a shortest pulse, slightly outside, and this range is wider than the settling band.
fn looseness(controller: &Controller, request: &TuneRequest, predicted: &Predicted) -> Option<String> {
    let name = controller.roles.dead_band.as_ref()?;
    let width = controller.value(name);
    let (first, last) = (predicted.setpoint.first()?, predicted.setpoint.last()?);
    let band = BAND * (last - first).abs();
    let pulse = shortest_pulse(controller, &request.model).map_or(0.0, |(_, moved)| moved / 2.0);
    let reach = width + pulse;
    let number = |number: f64| short(rounded(number, 3));
    let half_a_pulse = || format!(" plus half the effect of the shortest pulse ({})", number(pulse));
    (width > 0.0 && reach > band).then(|| {
        format!(
            "{name} = {}{} is wider than the band of {} on either side of the setpoint in which this step counts as \
             settled: the process value can stay anywhere in it, so a run may settle earlier or later than predicted. \
             A step of more than {} shows the settling time.",
            short(width),
            if pulse > 0.0 { half_a_pulse() } else { String::new() },
            number(band),
            number(reach / BAND)
        )
    })
}

/// Returns the settings under the block's names, including the switches of the actions.
fn values(controller: &Controller, structure: Structure, settings: &Settings) -> Values {
    let numbers = [Some(settings.gain), settings.ti, settings.td, settings.td.map(|_| settings.tm_lag)];
    let numbers = controller.roles.controller.iter().zip(numbers);
    let numbers = numbers.filter_map(|(name, number)| Some((name.clone(), Value::Number(number?))));
    let is_on = [true, structure != Structure::P, structure == Structure::Pid];
    let switches =
        controller.roles.structure.iter().zip(is_on).map(|(name, is_on)| (name.clone(), Value::Boolean(is_on)));
    numbers.chain(switches).collect()
}

/// Rounds a number to this many significant digits.
pub fn rounded(number: f64, digits: i32) -> f64 {
    format!("{number:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(number)
}

#[cfg(test)]
mod tests;
