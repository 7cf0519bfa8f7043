//! The metrics of the run, with the step and the disturbance to which they belong.

use super::{Report, shown_alone, three, with_unit};
use crate::message::{Figure, Figures};
use crate::session::Record;
use anyhow::Result;
use control::figures::{BAND, Happened, Needs, Set, Unit, find};
use draw::escape::Text;
use modeldescription::digits::short;
use modeldescription::units;
use run::dialog::Roles;
use run::system::{Value, own_name};
use std::fmt::Write;

/// Writes the metrics of the last step and the last disturbance, and the events to which they belong. `fmu` is the
/// controller's FMU.
pub(super) fn told(page: &mut String, report: &Report, fmu: &str, roles: &Roles) -> Result<()> {
    let Some(figures) = report.figures else { return Ok(()) };
    let step = figures.step.as_ref().map_or_else(String::new, |step| {
        let unit = with_unit(step.to, report.units[0]);
        format!("Setpoint from {} to {unit}, ", three(step.from))
    });
    let settled = figures.step.as_ref().and_then(|step| band("Settled", "the step", step, figures, report.units[0]));
    let about = format!("{step}{} s to {} s.{}", short(figures.from), short(figures.to), settled.unwrap_or_default());
    writeln!(page, "<h2>Metrics</h2>\n<p class=\"about\">{}</p>", Text(&about))?;
    let is_of_disturbance = |figure: &&Figure| find(&figure.key).is_some_and(|of| of.needs == Needs::Disturbance);
    list(page, figures.figures.iter().filter(|figure| !is_of_disturbance(figure)))?;
    if let Some(happened) = &figures.disturbance {
        let by = disturbed_by(report.record, happened);
        let recovered = band("Recovered", "the last setpoint step", happened, figures, report.units[0]);
        let about = format!("Disturbance: {by}.{}", recovered.unwrap_or_default());
        writeln!(page, "<p class=\"about\">{}</p>", Text(&about))?;
        list(page, figures.figures.iter().filter(is_of_disturbance))?;
    }
    let later = report.record.map(|record| changed_after(record, figures.from, fmu, roles)).unwrap_or_default();
    if !later.is_empty() {
        let later = later.join(", ");
        writeln!(page, "<p>Settings changed after this step: {}.</p>", Text(&later))?;
    }
    if !figures.remarks.is_empty() {
        writeln!(page, "<ul>")?;
        for remark in &figures.remarks {
            writeln!(page, "<li>{}</li>", Text(remark))?;
        }
        writeln!(page, "</ul>")?;
    }
    Ok(())
}

fn list<'a>(page: &mut String, figures: impl Iterator<Item = &'a Figure>) -> Result<()> {
    writeln!(page, "<dl class=\"figures\">")?;
    for figure in figures {
        if let Some(value) = figure.value {
            let (title, value) = (Text(&figure.title), with_unit(value, figure.unit.as_deref()));
            writeln!(page, "<div><dt>{title}</dt> <dd>{}</dd></div>", Text(&value))?;
        }
    }
    writeln!(page, "</dl>")?;
    Ok(())
}

/// The settling or recovery criterion as a sentence with a leading space: ` Settled: the process value stays within
/// ±0.4 K of the setpoint, 2 % of the step.`
fn band(word: &str, of: &str, happened: &Happened, figures: &Figures, unit: Option<&str>) -> Option<String> {
    let own = figures.figures.iter().find(|figure| figure.key == "peak").and_then(|figure| figure.unit.clone());
    let unit = own.or_else(|| Unit::ProcessValue.text(unit, None));
    let half = with_unit(happened.band?, unit.as_deref());
    Some(format!(
        " {word}: the process value stays within \u{b1}{half} of the setpoint, {} % of {of}.",
        three(BAND * 100.0)
    ))
}

/// A disturbance and the end of its window: `TANK.DRAIN from 100 to 80 % at 600 s, until 900 s`.
pub(super) fn disturbed_by(record: Option<&Record>, happened: &Happened) -> String {
    let told = |set: &Set| {
        let column = record.and_then(|record| Some(&record.columns()[record.column(&set.variable).ok()?]));
        let unit = units::shown(column.and_then(|column| column.unit.as_deref()).unwrap_or_default());
        let is_switch = column.is_some_and(|column| column.kind == run::component::Type::Boolean);
        let value = |value: f64| if is_switch { shown_alone(Value::Boolean(value != 0.0)) } else { three(value) };
        let Set { time, variable, before, .. } = set;
        let what = match (set.value, before) {
            (None, _) => format!("another {variable}"),
            (Some(now), Some(before)) => format!("{variable} from {} to {} {unit}", value(*before), value(now)),
            (Some(now), None) => format!("{variable} {} {unit}", value(now)),
        };
        format!("{} at {} s", what.trim_end(), short(*time))
    };
    let by: Vec<String> = happened.by.iter().map(told).collect();
    format!("{}, until {} s", by.join(", "), short(happened.start + happened.duration))
}

/// The controller settings changed after `time`, with value and time; `fmu` is the controller's FMU.
fn changed_after(record: &Record, time: f64, fmu: &str, roles: &Roles) -> Vec<String> {
    let Some(member) = record.setup().members.iter().find(|member| member.fmu == fmu) else { return Vec::new() };
    let own = |variable: &str| -> Option<String> {
        let name = own_name(variable, &member.name)?;
        roles.controller.iter().chain(&roles.structure).find(|own| *own == name).cloned()
    };
    let events = record.events().events;
    let later = events.iter().filter(|event| event.time > time).filter_map(|event| {
        let name = own(&event.variable)?;
        Some(format!("{name} {} at {} s", shown_alone(event.value), short(event.time)))
    });
    later.collect()
}
