//! The tuning rules as formulas: from a plant model to GAIN, TI and TD of a controller in the ideal form
//!
//! ```text
//! LMN = GAIN (1 + 1 / (TI s) + TD s / (1 + TM_LAG s)) e
//! ```
//!
//! K, T and L are the model's gain, time constant and dead time; a = K L / T, or a = k' L for an integrating plant,
//! where k' is its gain per second. L is the dead time of the whole loop: [`tune`](crate::tune) lists what is added to
//! the plant's dead time.
//!
//! | rule | GAIN | TI | TD |
//! |---|---|---|---|
//! | Ziegler-Nichols, step: P / PI / PID | 1 / 0.9 / 1.2, each divided by a | - / 3.33 L / 2 L | - / - / 0.5 L |
//! | Ziegler-Nichols, ultimate | 0.5 / 0.45 / 0.6 Ku | - / Tu/1.2 / Tu/2 | - / - / Tu/8 |
//! | CHR, setpoint, 0 % | 0.3 / 0.35 / 0.6, each divided by a | - / 1.2 T / T | - / - / 0.5 L |
//! | CHR, setpoint, 20 % | 0.7 / 0.6 / 0.95, each divided by a | - / T / 1.35 T | - / - / 0.47 L |
//! | CHR, disturbance, 0 % | 0.3 / 0.6 / 0.95, each divided by a | - / 4 L / 2.4 L | - / - / 0.42 L |
//! | CHR, disturbance, 20 % | 0.7 / 0.7 / 1.2, each divided by a | - / 2.3 L / 2 L | - / - / 0.42 L |
//! | SIMC PI | T / (K (tc + L)) | min(T, 4 (tc + L)) | - |
//! | SIMC PI, integrating | 1 / (k' (tc + L)) | 4 (tc + L) | - |
//! | SIMC PID, second lag T2 | as PI in the series form with TD' = T2, converted | | |
//! | lambda PI | T / (K (lambda + L)) | T | - |
//! | lambda PI, integrating | (2 lambda + L) / (k' (lambda + L)^2) | 2 lambda + L | - |
//! | AMIGO PI | 0.15/K + (0.35 - L T/(L+T)^2) T/(K L) | 0.35 L + 13 L T^2/(T^2 + 12 L T + 7 L^2) | - |
//! | AMIGO PI, integrating | 0.35 / (k' L) | 13.35 L | - |
//! | AMIGO PID | (0.2 + 0.45 T/L)/K | L (0.4 L + 0.8 T)/(L + 0.1 T) | 0.5 L T/(0.3 L + T) |
//! | AMIGO PID, integrating | 0.45 / (k' L) | 8 L | 0.5 L |
//!
//! For a rule that does not support a second lag, the half rule simplifies the model: half of the second lag is added
//! to the time constant and half to the dead time; if the plant is integrating, all of it is added to the dead time.

use crate::identify::Model;
use crate::margins;
use anyhow::{Result, bail};
use serde::{Deserialize, Serialize};

/// The ratio of TD to TM_LAG.
pub const FILTER: f64 = 10.0;

/// A tuning rule.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Rule {
    /// Ziegler and Nichols, based on the step response.
    ZieglerNicholsStep,
    /// Ziegler and Nichols, based on the ultimate gain and period.
    ZieglerNicholsUltimate,
    /// Chien, Hrones and Reswick, for setpoint changes, with 0 % overshoot.
    ChrSetpoint0,
    /// Chien, Hrones and Reswick, for setpoint changes, with 20 % overshoot.
    ChrSetpoint20,
    /// Chien, Hrones and Reswick, for disturbances, with 0 % overshoot.
    ChrDisturbance0,
    /// Chien, Hrones and Reswick, for disturbances, with 20 % overshoot.
    ChrDisturbance20,
    /// SIMC, by Skogestad.
    Simc,
    /// Lambda: TI cancels the plant's lag, and the closed loop has the time constant lambda.
    Lambda,
    /// AMIGO, by Astroem and Haegglund.
    Amigo,
}

impl Rule {
    /// All rules, in display order.
    pub const ALL: [Rule; 9] = [
        Rule::Simc,
        Rule::Lambda,
        Rule::Amigo,
        Rule::ChrSetpoint0,
        Rule::ChrSetpoint20,
        Rule::ChrDisturbance0,
        Rule::ChrDisturbance20,
        Rule::ZieglerNicholsStep,
        Rule::ZieglerNicholsUltimate,
    ];
}

/// The actions of a controller.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Structure {
    /// Proportional.
    P,
    /// Proportional and integral.
    Pi,
    /// Proportional, integral and derivative.
    Pid,
}

/// Settings of a controller in the ideal form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// GAIN, in units of the manipulated value per unit of the process value.
    pub gain: f64,
    /// TI in seconds; `None` without I action.
    pub ti: Option<f64>,
    /// TD in seconds; `None` without D action.
    pub td: Option<f64>,
    /// TM_LAG in seconds; 0 without D action.
    pub tm_lag: f64,
}

impl Settings {
    /// Returns the settings equivalent to a controller in the series form `K' (1 + 1/(TI' s)) (1 + TD' s)`.
    pub fn of_series(gain: f64, ti: f64, td: f64) -> Settings {
        let factor = 1.0 + td / ti;
        Settings { gain: gain * factor, ti: Some(ti * factor), td: Some(td / factor), tm_lag: td / factor / FILTER }
    }
}

impl Model {
    /// Checks that the numbers can describe a plant.
    ///
    /// # Errors
    /// A number is impossible; the message names it.
    pub fn check(&self) -> Result<()> {
        let Model { gain, time_constant, second_time_constant, dead_time, is_integrating } = *self;
        if gain == 0.0 || !gain.is_finite() {
            bail!("the plant's gain is {gain}: it must be a number other than 0");
        }
        for (name, time) in
            [("time constant", time_constant), ("second time constant", second_time_constant), ("dead time", dead_time)]
        {
            if !(0.0..=1e9).contains(&time) {
                bail!("the plant's {name} is {time} s: it must be between 0 and 1e9 s");
            }
        }
        if is_integrating && time_constant > 0.0 {
            bail!(
                "the plant is integrating, but has a time constant of {time_constant} s: enter it as the second time \
                 constant, and 0 as the time constant"
            );
        }
        Ok(())
    }

    /// Returns the model without its second lag, by the half rule.
    pub fn without_second_lag(&self) -> Model {
        let (slow, fast) = if self.is_integrating || self.time_constant >= self.second_time_constant {
            (self.time_constant, self.second_time_constant)
        } else {
            (self.second_time_constant, self.time_constant)
        };
        Model {
            time_constant: if self.is_integrating { 0.0 } else { slow + fast / 2.0 },
            second_time_constant: 0.0,
            // A lag of an integrating plant acts entirely as a delay.
            dead_time: self.dead_time + if self.is_integrating { fast } else { fast / 2.0 },
            ..*self
        }
    }
}

/// Computes the settings for a plant by a rule. `closed_loop` is the desired closed-loop time constant in seconds, used
/// by SIMC and lambda; `ultimate` is the ultimate gain and the ultimate period in seconds, if an experiment has
/// determined them.
///
/// # Errors
/// The model, `closed_loop` or `ultimate` is invalid, or the rule has no formula for this plant or structure; in that
/// case, the error names a rule that has one.
pub fn settings(
    rule: Rule,
    structure: Structure,
    model: &Model,
    closed_loop: Option<f64>,
    ultimate: Option<(f64, f64)>,
) -> Result<Settings> {
    model.check()?;
    if let Some(closed_loop) = closed_loop
        && !(closed_loop > 0.0 && closed_loop.is_finite())
    {
        bail!("the closed-loop time constant is {closed_loop} s: it must be above 0");
    }
    let plain = model.without_second_lag();
    let needs_dead_time = !matches!(rule, Rule::ZieglerNicholsUltimate | Rule::Simc | Rule::Lambda);
    if needs_dead_time && plain.dead_time == 0.0 {
        bail!("{} divides by the dead time, which is 0: use SIMC and choose the closed-loop time constant", name(rule));
    }
    let settings = match rule {
        Rule::ZieglerNicholsUltimate => by_ultimate(structure, model, ultimate)?,
        Rule::Simc => simc(structure, model, closed_loop)?,
        Rule::Lambda => lambda(structure, &plain, closed_loop)?,
        Rule::Amigo => amigo(structure, &plain)?,
        _ => by_slope(rule, structure, &plain)?,
    };
    if !(settings.gain.is_finite() && settings.gain != 0.0) {
        bail!("{} yields a GAIN of {} for this plant: use AMIGO with PI", name(rule), settings.gain);
    }
    Ok(settings)
}

/// Returns the name of a rule for users.
pub fn name(rule: Rule) -> &'static str {
    match rule {
        Rule::ZieglerNicholsStep => "Ziegler-Nichols (step)",
        Rule::ZieglerNicholsUltimate => "Ziegler-Nichols (ultimate gain)",
        Rule::ChrSetpoint0 => "CHR (setpoint, 0 %)",
        Rule::ChrSetpoint20 => "CHR (setpoint, 20 %)",
        Rule::ChrDisturbance0 => "CHR (disturbance, 0 %)",
        Rule::ChrDisturbance20 => "CHR (disturbance, 20 %)",
        Rule::Simc => "SIMC",
        Rule::Lambda => "lambda",
        Rule::Amigo => "AMIGO",
    }
}

fn ideal(gain: f64, ti: Option<f64>, td: Option<f64>) -> Settings {
    Settings { gain, ti, td, tm_lag: td.unwrap_or_default() / FILTER }
}

/// Applies a rule whose GAIN is a constant divided by a, and whose times are multiples of L or T.
fn by_slope(rule: Rule, structure: Structure, model: &Model) -> Result<Settings> {
    let (t, l) = (model.time_constant, model.dead_time);
    let is_for_setpoint = matches!(rule, Rule::ChrSetpoint0 | Rule::ChrSetpoint20);
    if model.is_integrating && is_for_setpoint {
        bail!("{} needs a time constant, but the plant is integrating: use SIMC or AMIGO", name(rule));
    }
    if !model.is_integrating && t == 0.0 {
        bail!("{} divides by the time constant, which is 0: use AMIGO with PI", name(rule));
    }
    let a = if model.is_integrating { model.gain * l } else { model.gain * l / t };
    // The factors for P, PI and PID; TI for PI and PID; TD.
    let (factors, times, td) = match rule {
        Rule::ChrSetpoint0 => ([0.3, 0.35, 0.6], [1.2 * t, t], 0.5 * l),
        Rule::ChrSetpoint20 => ([0.7, 0.6, 0.95], [t, 1.35 * t], 0.47 * l),
        Rule::ChrDisturbance0 => ([0.3, 0.6, 0.95], [4.0 * l, 2.4 * l], 0.42 * l),
        Rule::ChrDisturbance20 => ([0.7, 0.7, 1.2], [2.3 * l, 2.0 * l], 0.42 * l),
        _ => ([1.0, 0.9, 1.2], [l / 0.3, 2.0 * l], 0.5 * l),
    };
    Ok(match structure {
        Structure::P => ideal(factors[0] / a, None, None),
        Structure::Pi => ideal(factors[1] / a, Some(times[0]), None),
        Structure::Pid => ideal(factors[2] / a, Some(times[1]), Some(td)),
    })
}

fn by_ultimate(structure: Structure, model: &Model, ultimate: Option<(f64, f64)>) -> Result<Settings> {
    let (gain, period) = match ultimate {
        Some((gain, period)) if gain.is_finite() && gain != 0.0 && period > 0.0 && period.is_finite() => (gain, period),
        Some((gain, period)) => {
            bail!(
                "the ultimate gain is {gain} and the ultimate period {period} s: the gain must be finite and not 0, the \
                 period finite and greater than 0"
            )
        }
        None => match margins::ultimate(model) {
            Some((gain, period)) => (gain.copysign(model.gain), period),
            None => bail!("the plant has no ultimate gain, since it has no dead time: use SIMC"),
        },
    };
    Ok(match structure {
        Structure::P => ideal(0.5 * gain, None, None),
        Structure::Pi => ideal(0.45 * gain, Some(period / 1.2), None),
        Structure::Pid => ideal(0.6 * gain, Some(period / 2.0), Some(period / 8.0)),
    })
}

fn simc(structure: Structure, model: &Model, closed_loop: Option<f64>) -> Result<Settings> {
    let pi = |model: &Model| {
        let Model { gain, time_constant: t, dead_time: l, .. } = *model;
        let slowness = closed_loop.unwrap_or(l) + l;
        if slowness == 0.0 {
            bail!("SIMC divides by the dead time, which is 0: choose the closed-loop time constant");
        }
        if model.is_integrating {
            return Ok((1.0 / (gain * slowness), 4.0 * slowness));
        }
        if t == 0.0 {
            bail!(
                "SIMC yields pure I action for a plant without a lag, but GAIN multiplies all actions: use AMIGO with \
                 PI"
            );
        }
        Ok((t / (gain * slowness), t.min(4.0 * slowness)))
    };
    match structure {
        Structure::P => bail!("SIMC has no rule for P: use Ziegler-Nichols (step) or CHR, or SIMC with PI"),
        Structure::Pi => pi(&model.without_second_lag()).map(|(gain, ti)| ideal(gain, Some(ti), None)),
        Structure::Pid => {
            let lags = [model.time_constant, model.second_time_constant];
            let (slow, fast) =
                if model.is_integrating { (0.0, lags[1]) } else { (lags[0].max(lags[1]), lags[0].min(lags[1])) };
            if fast == 0.0 {
                bail!(
                    "SIMC uses D action only for a second lag, but the model has none: use SIMC with PI, or AMIGO with \
                     PID"
                );
            }
            let (gain, ti) = pi(&Model { time_constant: slow, second_time_constant: 0.0, ..*model })?;
            Ok(Settings::of_series(gain, ti, fast))
        }
    }
}

/// Returns the default closed-loop time constant of a rule; `None` if the rule does not use one.
pub fn closed_loop(rule: Rule, model: &Model) -> Option<f64> {
    let plain = model.without_second_lag();
    match rule {
        Rule::Simc => Some(plain.dead_time),
        Rule::Lambda => Some(plain.time_constant.max(3.0 * plain.dead_time)),
        _ => None,
    }
}

/// Maps a position on a scale from 0, calm, to 1, fast, to a closed-loop time constant: geometrically, from the larger
/// of the plant's time constant and four dead times to one dead time.
pub fn paced(pace: f64, model: &Model) -> f64 {
    let [calm, fast] = paces(model);
    calm.powf(1.0 - pace) * fast.powf(pace)
}

/// Returns the position of a closed-loop time constant on the scale of [`paced`], between 0 and 1; `None` without a
/// dead time.
pub fn pace(closed_loop: f64, model: &Model) -> Option<f64> {
    let [calm, fast] = paces(model);
    let pace = (calm / closed_loop).ln() / (calm / fast).ln();
    (fast > 0.0 && pace.is_finite()).then_some(pace.clamp(0.0, 1.0))
}

/// Returns the time constants at the calm and the fast end of the scale.
fn paces(model: &Model) -> [f64; 2] {
    let plain = model.without_second_lag();
    [plain.time_constant.max(4.0 * plain.dead_time), plain.dead_time]
}

fn lambda(structure: Structure, model: &Model, closed_loop: Option<f64>) -> Result<Settings> {
    let Model { gain: k, time_constant: t, dead_time: l, is_integrating, .. } = *model;
    if structure != Structure::Pi {
        bail!("lambda is a rule for PI: use PI, or AMIGO with PID");
    }
    let lambda = closed_loop.or(self::closed_loop(Rule::Lambda, model)).unwrap_or_default();
    if lambda + l == 0.0 {
        bail!("lambda divides by the dead time, which is 0: choose the closed-loop time constant");
    }
    if is_integrating {
        let ti = 2.0 * lambda + l;
        return Ok(ideal(ti / (k * (lambda + l) * (lambda + l)), Some(ti), None));
    }
    if t == 0.0 {
        bail!(
            "lambda yields pure I action for a plant without a lag, but GAIN multiplies all actions: use AMIGO with PI"
        );
    }
    Ok(ideal(t / (k * (lambda + l)), Some(t), None))
}

fn amigo(structure: Structure, model: &Model) -> Result<Settings> {
    let Model { gain: k, time_constant: t, dead_time: l, is_integrating, .. } = *model;
    Ok(match structure {
        Structure::P => bail!("AMIGO has no rule for P: use Ziegler-Nichols (step) or CHR, or AMIGO with PI"),
        Structure::Pi if is_integrating => ideal(0.35 / (k * l), Some(13.35 * l), None),
        Structure::Pid if is_integrating => ideal(0.45 / (k * l), Some(8.0 * l), Some(0.5 * l)),
        Structure::Pi => {
            let gain = 0.15 / k + (0.35 - l * t / ((l + t) * (l + t))) * t / (k * l);
            ideal(gain, Some(0.35 * l + 13.0 * l * t * t / (t * t + 12.0 * l * t + 7.0 * l * l)), None)
        }
        Structure::Pid => {
            if t == 0.0 {
                bail!("AMIGO with PID yields a TD of 0 for a plant without a lag: use AMIGO with PI");
            }
            let ti = l * (0.4 * l + 0.8 * t) / (l + 0.1 * t);
            ideal((0.2 + 0.45 * t / l) / k, Some(ti), Some(0.5 * l * t / (0.3 * l + t)))
        }
    })
}

#[cfg(test)]
mod tests;
