//! The table of compared rules, and the predicted step before and after one of them was applied.

use super::{Report, Tuning, step, three, with_unit};
use crate::home::Home;
use crate::message::Description;
use anyhow::{Context, Result};
use control::figures::{self, Unit};
use control::predict::{self, Forecast};
use control::tune::{Controller, RuleOutcome, TuneRequest, Tuned};
use draw::escape::Text;
use draw::plot::{Chart, Curve, Panel, svg};
use draw::response::Colors;
use modeldescription::digits::short;
use modeldescription::units;
use run::fmus::{Member, Values, number_of};
use run::system::{Exchange, Value};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// The content of an empty cell.
const NONE: &str = "\u{2013}";
/// The step is drawn for at most this many times the longer of the two settling times.
const LONGER: f64 = 1.5;

/// The metrics of the table: their titles, and their names in [`Tuned::absent`].
const METRICS: [(&str, &str); 9] = [
    ("Ms", "sensitivity"),
    ("overshoot", "overshoot"),
    ("settles", "settling"),
    ("travel", "travel"),
    ("load: deviation", "deviation"),
    ("recovers", "recovery"),
    ("load: IAE", "iae"),
    ("gain margin", "gain_margin"),
    ("phase margin", "phase_margin"),
];

/// The metrics without the margins, as named in a sentence.
const IN_WORDS: [&str; 7] =
    ["Ms", "overshoot", "settling time", "travel", "deviation after a load", "recovery time", "IAE after a load"];

/// The table of the rules, with the applied one marked.
pub(super) fn table(page: &mut String, report: &Report, of: &Tuning, description: &Description) -> Result<()> {
    let tuned: Vec<&Tuned> = of.rows.iter().filter_map(|row| row.tuned.as_ref()).collect();
    let Some(first) = tuned.first() else { return Ok(()) };
    // Settings that no rule computes, such as TD for PI, get no column.
    let is_set = |name: &&String| tuned.iter().any(|one| matches!(one.values.get(*name), Some(Value::Number(_))));
    let settings: Vec<&String> = description.roles.controller.iter().filter(is_set).collect();
    let [deviation, iae] = [Unit::ProcessValue, Unit::ProcessValueSeconds]
        .map(|unit| unit.text(report.units[0], None).unwrap_or_default().replace(' ', "\u{b7}"));
    let travel = units::shown(report.units[1].unwrap_or("%"));
    writeln!(page, "<p class=\"about\">{}</p>", Text(&about(first, report, &deviation)))?;
    writeln!(page, "<table class=\"rules\">\n<thead><tr><th>Rule</th>")?;
    let unit_of = |name: &String| description.variables.iter().find(|one| one.name == *name)?.unit.clone();
    let own = settings.iter().map(|name| {
        let unit = unit_of(name);
        ((*name).clone(), units::shown(unit.as_deref().unwrap_or_default()))
    });
    let units = ["", "%", "s", &*travel, &deviation, "s", &iae, "", "\u{b0}"];
    let metrics = METRICS.iter().zip(units).map(|((name, _), unit)| (name.to_string(), unit.to_string()));
    for (name, unit) in own.chain(metrics) {
        write!(page, "<th class=\"number\">{}<br>{}</th>", Text(&name), Text(&unit))?;
    }
    writeln!(page, "</tr></thead>\n<tbody>")?;
    for RuleOutcome { rule, name, tuned, refusal } in &of.rows {
        let (class, mark) = if *rule == of.rule { (" class=\"changed\"", " (applied)") } else { ("", "") };
        write!(page, "<tr{class}><td>{}{mark}</td>", Text(name))?;
        match tuned {
            Some(tuned) => {
                for value in settings.iter().map(|name| tuned.values.get(*name).map(|value| number_of(*value))) {
                    let told = value.map_or_else(|| NONE.to_string(), three);
                    write!(page, "<td class=\"number\">{told}</td>")?;
                }
                for (value, (_, key)) in metrics_of(tuned).into_iter().zip(METRICS) {
                    match (value, tuned.absent.get(key)) {
                        (Some(value), _) => write!(page, "<td class=\"number\">{}</td>", three(value))?,
                        (None, Some(why)) => write!(page, "<td class=\"number\" title=\"{}\">{NONE}</td>", Text(why))?,
                        (None, None) => write!(page, "<td class=\"number\">{NONE}</td>")?,
                    }
                }
            }
            None => {
                let width = settings.len() + METRICS.len();
                write!(page, "<td colspan=\"{width}\">{}</td>", Text(refusal.as_deref().unwrap_or_default()))?;
            }
        }
        writeln!(page, "</tr>")?;
    }
    writeln!(page, "</tbody>\n</table>")?;
    let missing = missing(&of.rows);
    if !missing.is_empty() {
        writeln!(page, "<ul class=\"rest\">")?;
        for line in missing {
            writeln!(page, "<li>{}</li>", Text(&line))?;
        }
        writeln!(page, "</ul>")?;
    }
    if let Some(applied) = of.rows.iter().find(|row| row.rule == of.rule) {
        let remarks = applied.tuned.iter().flat_map(|tuned| &tuned.remarks);
        let remarks: Vec<String> = remarks.map(|remark| format!("<li>{}</li>", Text(remark))).collect();
        if !remarks.is_empty() {
            writeln!(page, "<p>Remarks on {}:</p>\n<ul class=\"rest\">{}</ul>", Text(&applied.name), remarks.concat())?;
        }
        let best = best(applied, &of.rows);
        if !best.is_empty() {
            let best = best.join(", ");
            writeln!(page, "<p>Of these rules, {} has the lowest {}.</p>", Text(&applied.name), Text(&best))?;
        }
    }
    Ok(())
}

/// The conditions to which the numbers in the table apply.
fn about(first: &Tuned, report: &Report, deviation: &str) -> String {
    let unit = units::shown(report.units[0].unwrap_or_default());
    let step = match first.predicted.setpoint.as_slice() {
        [from, .., to] => format!("the setpoint step from {} to {} {unit}", three(*from), three(*to)),
        _ => "the setpoint step".to_string(),
    };
    let load = first.predicted.load.as_ref();
    let size = load.map_or(10.0, |load| load.size);
    let recovered = load.map(|load| {
        let half = format!("{} {deviation}", three(load.band));
        format!(" It recovers when the process value stays within \u{b1}{} of the setpoint.", half.trim_end())
    });
    format!(
        "The compared rules, with their effects as predicted by the plant model: {}, settled within 2 % of the step, and \
         a load of {size:+} % at the plant\u{2019}s input.{}",
        step.trim_end(),
        recovered.unwrap_or_default()
    )
}

/// The metrics of a rule in the order of the table.
fn metrics_of(tuned: &Tuned) -> [Option<f64>; 9] {
    let Tuned { sensitivity, gain_margin, phase_margin, predicted, .. } = tuned;
    let load = predicted.load.as_ref();
    [
        *sensitivity,
        predicted.overshoot,
        predicted.settling,
        predicted.travel,
        load.map(|load| load.deviation),
        load.and_then(|load| load.recovery),
        load.and_then(|load| load.iae),
        *gain_margin,
        *phase_margin,
    ]
}

/// All rules with their predicted effects.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct RulesTable {
    /// The rules, one per row.
    pub rows: Vec<RuleOutcome>,
    /// The reasons for missing metrics, one per line.
    pub missing: Vec<String>,
}

impl From<Vec<RuleOutcome>> for RulesTable {
    fn from(rows: Vec<RuleOutcome>) -> RulesTable {
        RulesTable { missing: missing(&rows), rows }
    }
}

/// The reasons for missing metrics, one per line, with the metrics and rules concerned.
fn missing(rows: &[RuleOutcome]) -> Vec<String> {
    let mut all: Vec<(&str, Vec<&str>, Vec<&str>)> = Vec::new();
    let tuned = || rows.iter().filter_map(|row| Some((&*row.name, &row.tuned.as_ref()?.absent)));
    for (name, absent) in tuned() {
        let mut own: Vec<(&str, Vec<&str>)> = Vec::new();
        for (title, why) in METRICS.iter().filter_map(|(title, key)| Some((*title, &**absent.get(*key)?))) {
            match own.iter_mut().find(|(other, _)| *other == why) {
                Some((_, metrics)) => metrics.push(title),
                None => own.push((why, vec![title])),
            }
        }
        for (why, metrics) in own {
            match all.iter_mut().find(|(other, same, _)| *other == why && *same == metrics) {
                Some((_, _, rules)) => rules.push(name),
                None => all.push((why, metrics, vec![name])),
            }
        }
    }
    let line = |(why, metrics, rules): (&str, Vec<&str>, Vec<&str>)| {
        let rules = if rules.len() == tuned().count() { "all rules".to_string() } else { rules.join(", ") };
        format!("{NONE} under {} for {rules}: {why}.", metrics.join(", "))
    };
    all.into_iter().map(line).collect()
}

/// The metrics, margins aside, in which the applied rule is better than all others with a stable loop.
fn best(applied: &RuleOutcome, rows: &[RuleOutcome]) -> Vec<&'static str> {
    let Some(own) = applied.tuned.as_ref().map(metrics_of) else { return Vec::new() };
    let others = || rows.iter().filter(|row| row.rule != applied.rule).filter_map(|row| row.tuned.as_ref());
    let others: Vec<_> = others().filter(|tuned| tuned.sensitivity.is_some()).map(metrics_of).collect();
    let is_best =
        |at: &usize| own[*at].is_some_and(|value| others.iter().all(|of| of[*at].is_none_or(|one| value < one)));
    if others.is_empty() { Vec::new() } else { (0..IN_WORDS.len()).filter(is_best).map(|at| IN_WORDS[at]).collect() }
}

/// Draws the predicted steps with the settings before and after the rule was applied, and compares their metrics.
///
/// # Errors
/// Why the block cannot be simulated with the model.
pub(super) fn before_and_after(
    page: &mut String,
    home: &dyn Home,
    report: &Report,
    of: &Tuning,
    (fmu, description): (&str, &Description),
) -> Result<()> {
    let differs = |(name, value): (&String, &Value)| of.before.get(name).is_some_and(|before| before != value);
    if !of.values.iter().any(differs) {
        return Ok(());
    }
    let base: Values = report.of.settings.iter().map(|setting| (setting.name.clone(), setting.value)).collect();
    let pair = [&of.before, &of.values]
        .map(|values| -> Values { base.iter().chain(values).map(|(name, value)| (name.clone(), *value)).collect() });
    let exchange = report.record.map_or(Exchange::default(), |record| record.setup().exchange);
    let mut sides = Vec::new();
    let (mut duration, mut settled) = (0.0_f64, 0.0_f64);
    for values in pair {
        let member = Member { name: report.of.name.clone(), fmu: fmu.into(), values };
        let controller = Controller::new(home, &member)?;
        let request = step::request(&controller, of, of.step, exchange);
        let (predicted, _) = predict::predict(home, &controller, &request, &member.values)?;
        let begin = predicted.setpoint.iter().position(|setpoint| Some(setpoint) == predicted.setpoint.last());
        let begin = begin.context("no step")?;
        duration = duration.max(predicted.times[predicted.times.len() - 1] - predicted.times[begin]);
        settled = settled.max(predicted.settling.unwrap_or_default());
        sides.push((controller, request));
    }
    let duration = if settled > 0.0 { duration.min(LONGER * settled) } else { duration };
    let cycle = sides[0].0.cycle();
    let duration = (duration / cycle).ceil() * cycle;
    let forecast = |(controller, request): &(Controller, TuneRequest)| {
        predict::forecast(home, controller, request, &controller.member.values, duration)
    };
    let forecasts = sides.iter().map(forecast).collect::<Result<Vec<_>>>()?;
    let told = |values: &Values| -> String {
        let numbers = description.roles.controller.iter().filter_map(|name| match values.get(name)? {
            Value::Boolean(_) => None,
            value => {
                let unit = description.variables.iter().find(|one| one.name == *name)?.unit.as_deref();
                Some(format!("{name} {}", with_unit(number_of(*value), unit)))
            }
        });
        numbers.collect::<Vec<_>>().join(", ")
    };
    let names =
        [("before", told(&of.before)), ("after", told(&of.values))].map(|(when, told)| format!("{when}: {told}"));
    let drawing = svg(&drawn(report, description, &forecasts, names))?;
    writeln!(
        page,
        "<h2>The step before and after tuning</h2>\n<p class=\"about\">Predicted with the plant model, over {} s.</p>\n<figure>{drawing}</figure>",
        short(duration)
    )?;
    let row = |figure: &figures::Figure| {
        let value = |side: &Forecast| side.figures.iter().find(|(key, _)| *key == figure.key).map(|(_, value)| *value);
        let values = [value(&forecasts[0]), value(&forecasts[1])];
        let unit = figure.unit.text(report.units[0], report.units[1]);
        values.iter().any(Option::is_some).then(|| (figure.title.to_string(), values, unit))
    };
    step::beside(page, ["Before", "After"], figures::FIGURES.into_iter().filter_map(row))
}

/// Both predictions: process values with the setpoint, and manipulated values.
fn drawn(report: &Report, description: &Description, of: &[Forecast], names: [String; 2]) -> Chart {
    let cycle = of[0].cycle;
    let count = of.iter().map(|one| one.process_value.len()).min().unwrap_or_default();
    let stride = count.div_ceil(super::POINTS).max(1);
    let calls: Vec<usize> = (0..count).step_by(stride).collect();
    let pick = |values: &[f64]| calls.iter().map(|call| values[*call]).collect::<Vec<f64>>();
    let [_, process_value, manipulated_value] = description.roles.signals();
    let own = |name: Option<&String>, else_: &str| name.map_or_else(|| else_.to_string(), Clone::clone);
    // The previous curve is dashed.
    let colors = [Colors::free(false, &Colors::OF_ROLES), Colors::OF_ROLES[1]];
    let curves = |name: &str, values: fn(&Forecast) -> &[f64], colors: [usize; 2]| -> Vec<Curve> {
        let both = of.iter().zip(&names).zip(colors).enumerate();
        let curve = |(at, ((one, when), color)): (usize, ((&Forecast, &String), usize))| Curve {
            name: format!("{name} {when}"),
            values: pick(values(one)),
            is_input: at == 0,
            color: Some(color),
        };
        both.map(curve).collect()
    };
    let label = |unit: Option<&str>| unit.unwrap_or_default().to_string();
    let controlled = curves(&own(process_value, "process value"), |one| &one.process_value, colors);
    let mut panels = vec![Panel { label: label(report.units[0]), curves: controlled, ..Panel::default() }];
    if of.iter().all(|one| !one.manipulated_value.is_empty()) {
        let colors = [colors[0], Colors::OF_ROLES[2]];
        let moved = curves(&own(manipulated_value, "manipulated value"), |one| &one.manipulated_value, colors);
        panels.push(Panel { label: label(report.units[1]), curves: moved, ..Panel::default() });
    }
    let time = calls.iter().map(|call| *call as f64 * cycle).collect();
    Chart { title: report.of.name.clone(), time, panels, ..Chart::default() }
}
