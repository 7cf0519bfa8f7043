//! The step and the disturbance to which the figures of a report refer: predicted and measured. The step also gets a
//! chart of its own.

use super::{Tuning, three, with_unit};
use crate::describe::describe;
use crate::home::Home;
use crate::message::{Figure, Figures, FiguresRequest};
use crate::session::{Record, Session};
use crate::signals;
use anyhow::{Context, Result, bail};
use blocks::Kind;
use control::figures::{Cause, Happened, in_sentence};
use control::predict::{self, Forecast};
use control::rules::Structure;
use control::tune::{Controller, Step, TuneRequest, rounded};
use draw::escape::Text;
use modeldescription::digits::short;
use run::component::Type;
use run::dialog::Roles;
use run::fmus::{Fmus, Member, Values};
use run::system::{Exchange, Value, own_name};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A step that covers less than this fraction of the run gets its own chart even without a prediction.
const SMALL: f64 = 0.5;

/// The metrics by which a prediction is judged, and the allowed difference to the run: a fraction of the larger value;
/// for the overshoot, percentage points.
const JUDGED: [(&str, f64); 5] =
    [("rise", AGREES), ("overshoot", 2.0), ("settling", AGREES), ("iae", AGREES), ("travel", AGREES)];
const AGREES: f64 = 0.1;

/// The time shown before a step, as a fraction of the time shown after it.
const BEFORE: f64 = 0.05;

/// The prediction of a measured step by the identified model.
pub(super) struct Predicted {
    /// When the step began, in seconds.
    pub(super) start: f64,
    pub(super) forecast: Forecast,
    /// The controller's settings in force that have an effect, as a list.
    settings: String,
}

/// Predicts a step with the settings in force at that time. `None` unless it is a setpoint step in automatic mode, and
/// the call before it is still stored.
///
/// # Errors
/// Why the block cannot be simulated with the model.
pub(super) fn predicted(
    home: &dyn Fmus,
    record: &Record,
    (fmu, roles): (&str, &Roles),
    tuning: &Tuning,
    step: &Happened,
) -> Result<Option<Predicted>> {
    let Some(own) = record.setup().members.first().filter(|own| own.fmu == fmu) else { return Ok(None) };
    let call = record.calls_between(Some(step.start), None).start;
    let column = |name: &String| record.column(&format!("{}.{name}", own.name));
    let before = |name: &String| Some(record.trace().get(column(name).ok()?, call - 1));
    let is_held = call > 0 && record.trace().exact().contains(&(call - 1));
    let is_manual = || roles.manual_mode().and_then(before) == Some(1.0);
    if step.cause != Cause::Setpoint || !is_held || is_manual() {
        return Ok(None);
    }
    let (controller, values) = in_force(home, record, own, call)?;
    let manual = roles.manipulated_value.as_ref().and_then(|name| column(name).ok());
    let manual =
        manual.map(|column| manipulated(record, &controller, column, call - 1)).filter(|value| value.is_finite());
    let step_of = Step { from: Some(step.from), size: Some(step.to - step.from), manual };
    let request = request(&controller, tuning, step_of, record.setup().exchange);
    let forecast = predict::forecast(home, &controller, &request, &values, step.duration)?;
    let acts = |name: &&String| {
        let field = controller.groups.iter().flat_map(|group| &group.fields).find(|field| field.name == **name);
        field.is_none_or(|field| field.is_used(|name| controller.value(name) != 0.0))
    };
    let told = |name: &String| {
        let unit = if controller.kind(name) == Some(Kind::Time) { " s" } else { "" };
        format!("{name} {}{unit}", three(controller.value(name)))
    };
    let settings: Vec<String> = roles.controller.iter().filter(acts).map(told).collect();
    Ok(Some(Predicted { start: step.start, forecast, settings: settings.join(", ") }))
}

/// The manipulated value in a call; for pulses, the mean over the last period.
fn manipulated(record: &Record, controller: &Controller, column: usize, call: usize) -> f64 {
    record.trace().means(column, &[call], controller.period_in_calls(record.step()))[0]
}

/// A controller with the settings in force in a call.
fn in_force(home: &dyn Fmus, record: &Record, own: &Member, call: usize) -> Result<(Controller, Values)> {
    let mut controller = Controller::new(home, own)?;
    let mut values = own.values.clone();
    for variable in controller.table.rows.iter().filter(|variable| variable.role.is_settable()) {
        let column = record.column(&format!("{}.{}", own.name, variable.name))?;
        let value = record.trace().get(column, call);
        let value = match record.columns()[column].kind {
            Type::Boolean => Value::Boolean(value != 0.0),
            _ => Value::Number(value),
        };
        values.insert(variable.name.clone(), value);
    }
    controller.member = Member { values: values.clone(), ..own.clone() };
    Ok((controller, values))
}

/// The request to predict a step with the controller's own settings; the rule in it is not applied.
pub(super) fn request(controller: &Controller, tuning: &Tuning, step: Step, exchange: Exchange) -> TuneRequest {
    TuneRequest {
        model: tuning.model,
        rule: tuning.rule,
        structure: Structure::Pi,
        controller: controller.member.clone(),
        closed_loop: None,
        pace: None,
        step,
        band: None,
        ultimate: None,
        exchange,
    }
}

/// A disturbance as predicted by the identified plant.
pub(super) struct Disturbance {
    /// The equivalent load at the plant's input, in the unit of the manipulated value.
    load: f64,
    /// The predicted figures, by key.
    figures: Vec<(&'static str, f64)>,
}

/// Predicts the last disturbance of a run with the settings in force at that time, as a load at the plant's input. If
/// the controller's own disturbance input was set, that is the load; otherwise, the change in the manipulated value
/// that compensated the disturbance.
///
/// # Errors
/// Why it cannot be predicted.
pub(super) fn disturbance(
    home: &dyn Fmus,
    record: &Record,
    (fmu, roles): (&str, &Roles),
    tuning: &Tuning,
    figures: &Figures,
) -> Result<Option<Disturbance>> {
    let Some(own) = record.setup().members.first().filter(|own| own.fmu == fmu) else { return Ok(None) };
    let Some(happened) = &figures.disturbance else { return Ok(None) };
    let calls = record.calls_between(Some(happened.start), Some(happened.start + happened.duration));
    let Some(before) = calls.start.checked_sub(1) else { return Ok(None) };
    let output = roles.manipulated_value.as_ref().context("the controller has no manipulated value")?;
    let output = record.column(&format!("{}.{output}", own.name))?;
    let band = happened.band.context("no setpoint step precedes it")?;
    if !record.trace().exact().contains(&before) || (happened.from - happened.to).abs() > band {
        bail!("the loop was not in steady state before it");
    }
    let (controller, values) = in_force(home, record, own, calls.start)?;
    let manipulated = |call: usize| manipulated(record, &controller, output, call);
    let is_own =
        |name: &str| own_name(name, &own.name).is_some_and(|name| roles.disturbances.iter().any(|of| of == name));
    let load = if happened.by.iter().all(|set| is_own(&set.variable)) {
        let sum: Option<f64> = happened.by.iter().map(|set| Some(set.value? - set.before?)).sum();
        let factor = predict::output_factor(home, &controller)?.unwrap_or(1.0);
        sum.context("its previous value is unknown")? * factor
    } else {
        let has_recovered = figures.figures.iter().any(|figure| figure.key == "recovery" && figure.value.is_some());
        if !has_recovered {
            bail!("the loop has not recovered, so the size of the load at the plant's input is unknown");
        }
        manipulated(before) - manipulated(calls.end - 1)
    };
    let at_rest = Step { from: Some(happened.to), size: None, manual: Some(manipulated(before)) };
    let request = TuneRequest { band: Some(band), ..request(&controller, tuning, at_rest, record.setup().exchange) };
    let figures = predict::forecast_load(home, &controller, &request, &values, (happened.duration, load))?;
    Ok(Some(Disturbance { load, figures }))
}

/// The figures of a disturbance, predicted and measured.
pub(super) fn disturbance_side_by_side(
    page: &mut String,
    of: &Disturbance,
    by: &str,
    figures: &Figures,
    unit: Option<&str>,
) -> Result<()> {
    let load = with_unit(of.load, unit);
    writeln!(
        page,
        "<p class=\"about\">The disturbance ({}): predicted as a load of {} at the plant\u{2019}s input, over the same time, and measured \
         in the run.</p>",
        Text(by),
        Text(&load)
    )?;
    table(page, &of.figures, figures)
}

/// A step as predicted by the identified plant.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Forecasted {
    /// The controller's settings in force that have an effect, as a list.
    pub settings: String,
    /// Its figures by key, for the same step and the same time as the run's figures.
    pub figures: BTreeMap<String, f64>,
    /// Whether the run agrees with the prediction, in a sentence or two.
    pub verdict: String,
}

/// The last setpoint step in a run as predicted by the identified plant with the settings in force at that time. `None`
/// if it was not a setpoint step in automatic mode.
///
/// # Errors
/// No such run; it has no controller or no figures; or the block cannot be simulated with the model.
pub(crate) fn forecast(
    home: &dyn Home,
    session: &Session,
    run: Option<usize>,
    tuning: &Tuning,
) -> Result<Option<Forecasted>> {
    let record = session.record(run)?;
    let fmu = &record.setup().members.first().context("no controller")?.fmu;
    let roles = describe(home, fmu)?.roles;
    let figures = signals::figures(home, session, &FiguresRequest { run, ..FiguresRequest::default() })?;
    let Some(step) = &figures.step else { return Ok(None) };
    let predicted = predicted(home, record, (fmu, &roles), tuning, step)?;
    Ok(predicted.map(|of| {
        let verdict = verdict(&of.forecast.figures, &figures);
        let figures = of.forecast.figures.iter().map(|(key, value)| (key.to_string(), *value)).collect();
        Forecasted { settings: of.settings, figures, verdict }
    }))
}

/// Says whether a run agrees with the prediction, or which metrics differ and by how much.
fn verdict(predicted: &[(&'static str, f64)], run: &Figures) -> String {
    let off = |(key, allowed): &(&str, f64)| {
        let (_, predicted) = predicted.iter().find(|(name, _)| name == key)?;
        let figure = run.figures.iter().find(|figure| figure.key == *key)?;
        let title = in_sentence(&figure.title);
        let Some(came) = figure.value else { return Some(format!("the run has no {title}")) };
        let difference = came - predicted;
        match *key {
            "overshoot" if difference.abs() <= *allowed => None,
            "overshoot" => Some(format!("{title} {} percentage points", signed(difference))),
            _ if difference.abs() <= allowed * came.abs().max(predicted.abs()) => None,
            _ => Some(format!("{title} {} %", signed(100.0 * difference / predicted.abs()))),
        }
    };
    if run.figures.iter().any(|figure| figure.key == "settling" && figure.value.is_none()) {
        return "The step has not settled yet.".into();
    }
    let off: Vec<String> = JUDGED.iter().filter_map(off).collect();
    if off.is_empty() {
        return "The run agrees with the prediction.".into();
    }
    format!(
        "The run differs from the prediction: {}. The model does not hold for this step. Possible \
         causes are limits, the dead band, short pulses, noise, or a plant that responds differently here. Identify the plant \
         again with a step of this size around this setpoint.",
        off.join(", ")
    )
}

/// A difference with its sign and two digits.
fn signed(value: f64) -> String {
    let digits = rounded(value, 2);
    if digits > 0.0 { format!("+{}", short(digits)) } else { short(digits) }
}

/// The predicted and measured figures side by side.
pub(super) fn side_by_side(
    page: &mut String,
    of: &Predicted,
    figures: &Figures,
    step: &Happened,
    unit: Option<&str>,
) -> Result<()> {
    let to = with_unit(step.to, unit);
    writeln!(
        page,
        "<p class=\"about\">The setpoint step from {} to {} with {}, over the same {} s: predicted with \
         the identified plant, and measured in the run.</p>",
        three(step.from),
        Text(&to),
        Text(&of.settings),
        short(step.duration)
    )?;
    table(page, &of.forecast.figures, figures)?;
    writeln!(page, "<p>{}</p>", Text(&verdict(&of.forecast.figures, figures)))?;
    Ok(())
}

/// The table of predicted figures next to the run's figures.
fn table(page: &mut String, predicted: &[(&'static str, f64)], figures: &Figures) -> Result<()> {
    let row = |figure: &Figure| {
        let (_, predicted) = predicted.iter().find(|(key, _)| *key == figure.key)?;
        Some((figure.title.clone(), [Some(*predicted), figure.value], figure.unit.clone()))
    };
    beside(page, ["Predicted", "Measured"], figures.figures.iter().filter_map(row))
}

/// A table of metrics. Each row has a title, two values, and their unit.
pub(super) fn beside(
    page: &mut String,
    columns: [&str; 2],
    rows: impl Iterator<Item = (String, [Option<f64>; 2], Option<String>)>,
) -> Result<()> {
    let [one, other] = columns.map(|column| format!("<th class=\"number\">{column}</th>"));
    writeln!(page, "<table>\n<thead><tr><th>Metric</th>{one}{other}</tr></thead>\n<tbody>")?;
    for (title, values, unit) in rows {
        write!(page, "<tr><td>{}</td>", Text(&title))?;
        for value in values {
            let value = value.map_or_else(|| "\u{2013}".into(), |value| with_unit(value, unit.as_deref()));
            write!(page, "<td class=\"number\">{}</td>", Text(&value))?;
        }
        writeln!(page, "</tr>")?;
    }
    writeln!(page, "</tbody>\n</table>")?;
    Ok(())
}

/// The beginning and end of the step's own chart, which includes a short time before the step; `None` if the step
/// covers most of the run and has no prediction.
pub(super) fn part(record: &Record, figures: &Figures, is_predicted: bool) -> Option<(f64, f64)> {
    let (from, to) = (figures.from, figures.to);
    let run = record.time(record.calls().checked_sub(1)?) - record.time(0);
    let is_drawn = figures.step.is_some() && to > from && (is_predicted || to - from < SMALL * run);
    is_drawn.then_some((from - BEFORE * (to - from), to))
}

/// The predicted process value at the times of a chart; NaN, drawn as a gap, before the step and after the prediction.
pub(super) fn curve(of: &Predicted, times: &[f64]) -> Vec<f64> {
    let Forecast { process_value, cycle, .. } = &of.forecast;
    let value = |time: &f64| {
        let call = ((time - of.start) / cycle + 1e-6).floor();
        if call < 0.0 { f64::NAN } else { process_value.get(call as usize).copied().unwrap_or(f64::NAN) }
    };
    times.iter().map(value).collect()
}
