//! A one-page report on a loop with its settings, their effects, the events, and the results, as self-contained HTML.

mod metrics;
mod rules;
mod step;
mod tuning;

use crate::describe::{check, describe};
use crate::home::Home;
use crate::message::{Act, Description, Figures, Loop, LoopValue, Values, Variable, View};
use crate::session::Record;
use anyhow::{Context, Result, bail};
use control::identify::Model;
use control::replay::Change;
use control::rules::Rule;
use control::tune::{RuleOutcome, Step};
use draw::escape::Text;
use draw::plot::{Chart, Curve, Panel, svg};
use draw::response::Colors;
use modeldescription::digits::{rounded, short};
use modeldescription::units;
pub(crate) use rules::RulesTable;
use run::dialog::Roles;
use run::fmus::number_of;
use run::system::Value;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use step::Predicted;
pub(crate) use step::{Forecasted, forecast};

/// The maximum number of points of a curve.
const POINTS: usize = 1500;

/// The maximum number of events listed.
const MOST_EVENTS: usize = 100;

/// The maximum size of a picture, in bytes.
const LARGEST_PICTURE: usize = 16 << 20;

/// The origin of computed settings, and their predicted effects.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct Tuning {
    /// The plant.
    pub model: Model,
    /// The rule.
    pub rule: Rule,
    /// The resulting settings.
    pub values: Values,
    /// Lambda in seconds, for a rule that uses it.
    #[serde(default)]
    pub closed_loop: Option<f64>,
    /// The maximum sensitivity Ms.
    #[serde(default)]
    pub sensitivity: Option<f64>,
    /// The gain margin, as a factor.
    #[serde(default)]
    pub gain_margin: Option<f64>,
    /// The phase margin, in degrees.
    #[serde(default)]
    pub phase_margin: Option<f64>,
    /// The predicted setpoint step.
    #[serde(default)]
    pub step: Step,
    /// All compared rules with their predicted effects; of the curves, only the first and the last setpoint are needed.
    #[serde(default)]
    pub rows: Vec<RuleOutcome>,
    /// The previous values of the same settings.
    #[serde(default)]
    pub before: Values,
}

/// A run compared with others.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct ReportedRun {
    /// The 0-based number of the run.
    pub run: usize,
    /// The user's name for it.
    pub name: String,
    /// Its settings at its end, where they differ between the compared runs.
    #[serde(default)]
    pub values: Values,
    /// Its settings at its beginning, where they changed during the run.
    #[serde(default)]
    pub begun: Values,
}

/// A replay of a recording through the block.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields = nullable))]
pub struct ReportedReplay {
    /// The recording's file.
    pub file: String,
    /// The controller's settings used for the replay.
    pub values: Values,
    /// The conclusion, in a sentence.
    pub verdict: String,
    /// Remarks on the conclusion, a sentence each.
    #[serde(default)]
    pub remarks: Vec<String>,
    /// The settings in which the recording differed from the loop.
    #[serde(default)]
    pub settings: Vec<Change>,
}

/// The contents of a report.
pub(crate) struct Report<'a> {
    /// The loop with its values.
    pub(crate) of: &'a Loop,
    /// The previous values; may be empty.
    pub(crate) before: &'a [LoopValue],
    /// The run, if there is one.
    pub(crate) record: Option<&'a Record>,
    /// The figures of the run.
    pub(crate) figures: Option<&'a Figures>,
    /// The runs of the same step with their figures, earliest first.
    pub(crate) compared: Vec<(&'a ReportedRun, Figures)>,
    /// A picture of the curves as displayed to the user; by default, they are drawn here.
    pub(crate) picture: Option<&'a str>,
    /// The date of the report, as displayed.
    pub(crate) date: Option<&'a str>,
    /// The origin of the settings.
    pub(crate) tuning: Option<&'a Tuning>,
    /// The replays of a recording, in order.
    pub(crate) replays: &'a [ReportedReplay],
    /// The units of process value and manipulated value, if their variables have none.
    pub(crate) units: [Option<&'a str>; 2],
}

/// The report as an HTML page.
///
/// # Errors
/// The block is unknown, or the picture is invalid.
pub(crate) fn page(home: &dyn Home, report: &Report) -> Result<String> {
    let fmu = fmu_of(home, &report.of.block)?;
    let description = describe(home, &fmu)?;
    let values = report.of.settings.iter().map(|setting| (setting.name.clone(), setting.value)).collect();
    let checked = check(home, &fmu, &values)?;
    let mut page = String::new();
    let (name, block) = (Text(&report.of.name), Text(&description.block));
    write!(
        page,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n\
         <title>{name}</title>\n<style>\n{}</style>\n</head>\n<body>\n<h1>{name}</h1>\n",
        include_str!("report.css")
    )?;
    write!(page, "<p class=\"about\">{block}: {}", Text(&description.summary))?;
    let cycle = report.of.cycle.or_else(|| {
        let name = description.cycle.as_ref()?;
        report.of.settings.iter().find(|setting| setting.name == *name).map(|setting| number_of(setting.value))
    });
    if let (Some(cycle), Some(name)) = (cycle, &description.cycle) {
        write!(page, " {} {cycle} s.", Text(name))?;
    }
    if let Some(date) = report.date {
        write!(page, " {}.", Text(date))?;
    }
    writeln!(page, "</p>")?;
    if !checked.remarks.is_empty() {
        writeln!(page, "<h2>Effects of the settings</h2>\n<ul>")?;
        for remark in &checked.remarks {
            writeln!(page, "<li>{}</li>", Text(&remark.text))?;
        }
        writeln!(page, "</ul>")?;
    }
    run(&mut page, home, report, (&fmu, &description.roles))?;
    compared(&mut page, &report.compared, report.units[0])?;
    replays(&mut page, report.replays, &description)?;
    if let Some(record) = report.record {
        plants(&mut page, home, record)?;
    }
    if let Some(of) = report.tuning {
        tuning::told(&mut page, home, report, of, (&fmu, &description))?;
    }
    settings(&mut page, report, &description, &checked.unused)?;
    if let Some(record) = report.record {
        events(&mut page, record, &report.compared)?;
    }
    for source in home.sources(&fmu) {
        write!(page, "<h2>{}</h2>\n<pre>{}</pre>\n", Text(&source.file), Text(&source.text))?;
    }
    page.push_str("</body>\n</html>\n");
    Ok(page)
}

/// The catalogue's FMU for this block.
fn fmu_of(home: &dyn Home, block: &str) -> Result<String> {
    let is = |name: &str| matches!(home.table(name), Ok(Some(table)) if table.name == block);
    let found = home.entries().into_iter().find(|entry| is(&entry.name));
    if let Some(entry) = found {
        return Ok(entry.name);
    }
    // The block may be given by another of its names, such as that in the PLC project.
    let known = home.blocks().into_iter().find(|known| known.is_called(block));
    let known = known.with_context(|| format!("no block {block:?} in the catalogue"))?;
    let is = |name: &str| matches!(home.table(name), Ok(Some(table)) if table.name == known.name);
    let found = home.entries().into_iter().find(|entry| is(&entry.name));
    Ok(found.with_context(|| format!("no FMU for the block {block:?} in the catalogue"))?.name)
}

/// Figures and curves of the controller, given as its FMU and the roles of its variables.
fn run(page: &mut String, home: &dyn Home, report: &Report, (fmu, roles): (&str, &Roles)) -> Result<()> {
    metrics::told(page, report, fmu, roles)?;
    faults(page, home, report.record)?;
    let predicted = predicted(page, home, report, (fmu, roles))?;
    if let Some(picture) = report.picture {
        let source = source(picture)?;
        writeln!(
            page,
            "<h2>Curves</h2>\n<figure><img src=\"{}\" alt=\"The curves of the run\"></figure>",
            Text(&source)
        )?;
    } else if let Some(record) = report.record
        && record.calls() > 1
        && let Some(drawing) = curves(record, roles, report.units, (None, None), None)?
    {
        writeln!(page, "<h2>Curves</h2>\n<figure>{drawing}</figure>")?;
    }
    if let (Some(record), Some(figures)) = (report.record, report.figures)
        && let Some((from, to)) = step::part(record, figures, predicted.is_some())
        && let Some(drawing) = curves(record, roles, report.units, (Some(from), Some(to)), predicted.as_ref())?
    {
        writeln!(page, "<h2>The measured step</h2>\n<figure>{drawing}</figure>")?;
    }
    Ok(())
}

/// Reports members whose fault output became TRUE during the run, such as a tripped drive.
fn faults(page: &mut String, home: &dyn Home, record: Option<&Record>) -> Result<()> {
    let Some(record) = record else { return Ok(()) };
    for member in record.members() {
        for output in describe(home, &member.fmu)?.roles.faults() {
            let name = format!("{}.{output}", member.name);
            let Ok(column) = record.column(&name) else { continue };
            let calls = record.trace().exact();
            let stopped =
                calls.start + record.trace().column(column, calls.clone()).take_while(|value| *value != 1.0).count();
            if stopped < calls.end {
                let since = short(record.time(stopped));
                writeln!(
                    page,
                    "<p><strong>{} has stopped: {name} has been TRUE since {since} s.</strong></p>",
                    Text(&member.name)
                )?;
            }
        }
    }
    Ok(())
}

/// The figures for the step and the disturbance as predicted by the identified plant, next to the measured ones.
fn predicted(
    page: &mut String,
    home: &dyn Home,
    report: &Report,
    (fmu, roles): (&str, &Roles),
) -> Result<Option<Predicted>> {
    let (Some(record), Some(figures), Some(tuning)) = (report.record, report.figures, report.tuning) else {
        return Ok(None);
    };
    let mut part = String::new();
    let refused = |page: &mut String, what: &str, error: anyhow::Error| -> Result<()> {
        writeln!(page, "<p>The {what} is not predicted: {}.</p>", Text(&format!("{error:#}")))?;
        Ok(())
    };
    let mut of_step = None;
    if let Some(happened) = &figures.step {
        match step::predicted(home, record, (fmu, roles), tuning, happened) {
            Ok(predicted) => of_step = predicted,
            Err(error) => refused(&mut part, "step", error)?,
        }
        if let Some(of) = &of_step {
            step::side_by_side(&mut part, of, figures, happened, report.units[0])?;
        }
    }
    match step::disturbance(home, record, (fmu, roles), tuning, figures) {
        Ok(None) => {}
        Ok(Some(of)) => {
            let by = figures.disturbance.as_ref().map(|of| metrics::disturbed_by(Some(record), of));
            step::disturbance_side_by_side(&mut part, &of, &by.unwrap_or_default(), figures, report.units[1])?;
        }
        Err(error) => refused(&mut part, "disturbance", error)?,
    }
    if !part.is_empty() {
        write!(page, "<h2>Predicted and measured</h2>\n{part}")?;
    }
    Ok(of_step)
}

/// The results of replayed recordings.
fn replays(page: &mut String, replays: &[ReportedReplay], description: &Description) -> Result<()> {
    if replays.is_empty() {
        return Ok(());
    }
    let told = |name: &str, value: Value| {
        let variable = description.variables.iter().find(|variable| variable.name == name);
        let unit = units::shown(variable.and_then(|variable| variable.unit.as_deref()).unwrap_or_default());
        let value = variable.map_or_else(|| shown_alone(value), |variable| shown(variable, value));
        format!("{value} {unit}").trim_end().to_string()
    };
    writeln!(page, "<h2>Replay</h2>")?;
    for ReportedReplay { file, values, verdict, remarks, settings } in replays {
        let with: Vec<String> = values.iter().map(|(name, value)| format!("{name} {}", told(name, *value))).collect();
        let with = if with.is_empty() { String::new() } else { format!(", replayed with {}", with.join(", ")) };
        writeln!(page, "<p class=\"about\">{}{}:</p>", Text(file), Text(&with))?;
        writeln!(page, "<p><strong>{}</strong> {}</p>", Text(verdict), Text(&remarks.join(" ")))?;
        if settings.is_empty() {
            continue;
        }
        writeln!(
            page,
            "<table>\n<thead><tr><th>Setting</th><th class=\"number\">In the recording</th><th class=\"number\">In the loop</th></tr></thead>\n<tbody>"
        )?;
        for change in settings {
            let Change::Setting { name, value, before, .. } = change else { continue };
            let [value, before] = [value, before].map(|value| told(name, *value));
            writeln!(
                page,
                "<tr><td class=\"name\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td></tr>",
                Text(name),
                Text(&value),
                Text(&before)
            )?;
        }
        writeln!(page, "</tbody>\n</table>")?;
    }
    Ok(())
}

/// A figure with three significant digits and its unit; `degC^2 s` becomes `°C²·s`.
fn with_unit(value: f64, unit: Option<&str>) -> String {
    let unit: Vec<_> = unit.unwrap_or_default().split(' ').map(units::shown).collect();
    format!("{} {}", three(value), unit.join("\u{b7}").replace("^2", "\u{b2}")).trim_end().to_string()
}

/// A number with three significant digits.
fn three(value: f64) -> String {
    rounded(value, f64::MIN_POSITIVE)
}

/// The figures of compared runs side by side.
fn compared(page: &mut String, runs: &[(&ReportedRun, Figures)], unit: Option<&str>) -> Result<()> {
    if runs.len() < 2 {
        return Ok(());
    }
    writeln!(page, "<h2>Before and after</h2>\n<table>\n<thead><tr><th>Metric</th>")?;
    for (run, _) in runs {
        let told = |(name, value): (&String, &Value)| {
            let all: Vec<Value> = runs.iter().filter_map(|(other, _)| other.values.get(name).copied()).collect();
            match run.begun.get(name) {
                Some(begun) => format!("{name} {}, then {}", brief(*begun, &[*value]), brief(*value, &all)),
                None => format!("{name} {}", brief(*value, &all)),
            }
        };
        let values: Vec<String> = run.values.iter().map(told).collect();
        write!(page, "<th class=\"number\">{}<br>{}</th>", Text(&run.name), Text(&values.join(", ")))?;
    }
    writeln!(page, "</tr></thead>\n<tbody>")?;
    if runs.iter().any(|(_, figures)| figures.step.is_some()) {
        write!(page, "<tr><td>Setpoint step</td>")?;
        for (_, figures) in runs {
            let step = figures.step.as_ref().map_or_else(String::new, |step| {
                format!("{} to {}, at {} s", three(step.from), with_unit(step.to, unit), short(step.start))
            });
            write!(page, "<td class=\"number\">{}</td>", Text(&step))?;
        }
        writeln!(page, "</tr>")?;
    }
    let (_, last) = &runs[runs.len() - 1];
    for figure in &last.figures {
        let values = runs.iter().map(|(_, figures)| {
            let of = figures.figures.iter().find(|one| one.key == figure.key)?;
            Some(with_unit(of.value?, of.unit.as_deref()))
        });
        let values: Vec<_> = values.collect();
        if values.iter().all(Option::is_none) {
            continue;
        }
        write!(page, "<tr><td>{}</td>", Text(&figure.title))?;
        for value in values {
            write!(page, "<td class=\"number\">{}</td>", Text(value.as_deref().unwrap_or("\u{2013}")))?;
        }
        writeln!(page, "</tr>")?;
    }
    writeln!(page, "</tbody>\n</table>")?;
    Ok(())
}

/// The other members of the run with their settings.
fn plants(page: &mut String, home: &dyn Home, record: &Record) -> Result<()> {
    for member in record.members().skip(1) {
        let Ok(description) = describe(home, &member.fmu) else { continue };
        write!(page, "<h2>{}: {}</h2>\n<p class=\"about\">", Text(&member.name), Text(&member.fmu))?;
        writeln!(page, "{}</p>", Text(&description.summary))?;
        let is_setting = |variable: &&Variable| {
            !variable.is_stimulus && matches!(variable.role.as_str(), "parameter" | "fixed")
                || member.values.contains_key(&variable.name)
        };
        let settings: Vec<_> = description.variables.iter().filter(is_setting).collect();
        if settings.is_empty() {
            continue;
        }
        writeln!(
            page,
            "<table>\n<thead><tr><th>Name</th><th class=\"number\">Value</th><th>Unit</th><th>Meaning</th></tr></thead>\n<tbody>"
        )?;
        for variable in settings {
            let value = member.values.get(&variable.name).copied().unwrap_or(variable.start);
            writeln!(
                page,
                "<tr><td class=\"name\">{}</td><td class=\"number\">{}</td><td>{}</td><td>{}</td></tr>",
                Text(&variable.name),
                Text(&shown(variable, value)),
                Text(&units::shown(variable.unit.as_deref().unwrap_or(""))),
                Text(&variable.description)
            )?;
        }
        writeln!(page, "</tbody>\n</table>")?;
    }
    Ok(())
}

/// A picture as a URL for the `src` of an image, where scripts in an SVG do not run.
fn source(picture: &str) -> Result<String> {
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;
    if picture.len() > LARGEST_PICTURE {
        bail!("the picture is larger than {} MiB", LARGEST_PICTURE >> 20);
    }
    if picture.trim_start().starts_with("<svg") {
        return Ok(format!("data:image/svg+xml;base64,{}", STANDARD.encode(picture.trim())));
    }
    let is_data = ["data:image/png;base64,", "data:image/svg+xml;base64,"].iter().any(|start| {
        picture.strip_prefix(start).is_some_and(|data| {
            data.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'/' | b'='))
        })
    });
    if !is_data {
        bail!("the picture is neither an <svg> nor a Base64 data: URL of a PNG or an SVG");
    }
    Ok(picture.into())
}

/// Draws the curves of the first member between two times: setpoint and process value, manipulated value, pulses and
/// mode.
fn curves(
    record: &Record,
    roles: &Roles,
    units: [Option<&str>; 2],
    (from, to): (Option<f64>, Option<f64>),
    predicted: Option<&Predicted>,
) -> Result<Option<String>> {
    let Some(member) = record.setup().members.first() else { return Ok(None) };
    let [setpoint, process_value, manipulated_value] = roles.signals();
    let manual = roles.manual_switch();
    let mut panels = [
        Vec::from_iter([setpoint, process_value].into_iter().flatten()),
        Vec::from_iter(manipulated_value),
        Vec::from_iter(roles.pulses.iter().chain(manual)),
    ];
    let full = |name: &str| format!("{}.{name}", member.name);
    panels.iter_mut().for_each(|names| names.retain(|name| record.column(&full(name)).is_ok()));
    let variables: Vec<String> = panels.iter().flatten().map(|name| full(name)).collect();
    if variables.is_empty() {
        return Ok(None);
    }
    let view = record.view(&View { run: None, variables, from, to, points: POINTS, means: None })?;
    // The same colours as on the FMUs' documentation pages.
    let mut lanes = Vec::new();
    let mut color = |name: &String| {
        let role = roles.signals().iter().position(|role| *role == Some(name));
        role.map(|role| Colors::OF_ROLES[role]).unwrap_or_else(|| {
            lanes.push(Colors::free(true, &lanes));
            lanes[lanes.len() - 1]
        })
    };
    let mut columns = view.values.into_iter().zip(view.units);
    let [mut controlled, mut manipulated, mut switches] = panels.map(|names| {
        let curve = |(name, (values, unit)): (&String, (Vec<f64>, Option<String>))| {
            let is_input = setpoint == Some(name);
            (Curve { name: name.clone(), values, is_input, color: Some(color(name)) }, unit)
        };
        let (curves, units): (Vec<_>, Vec<_>) = names.into_iter().zip(&mut columns).map(curve).unzip();
        Panel { label: units.into_iter().flatten().next().unwrap_or_default(), curves, ..Panel::default() }
    });
    switches.curves.iter_mut().for_each(|lane| lane.name.push_str(", filled where TRUE"));
    // If the controller's variables have no unit, use the plant's.
    for (panel, unit) in [(&mut controlled, units[0]), (&mut manipulated, units[1])] {
        if panel.label.is_empty() {
            panel.label = unit.unwrap_or_default().into();
        }
    }
    if let Some(of) = predicted {
        let values = step::curve(of, &view.times);
        let name = format!("{} predicted", process_value.map_or("process value", String::as_str));
        let color = Some(Colors::free(false, &Colors::OF_ROLES));
        controlled.curves.push(Curve { name, values, is_input: true, color });
    }
    let panels = [controlled, manipulated].into_iter().filter(|panel| !panel.curves.is_empty()).collect();
    let chart =
        Chart { title: member.name.clone(), time: view.times, panels, lanes: switches.curves, ..Chart::default() };
    Ok(Some(svg(&chart)?))
}

/// The table of settings by group, without those that have no effect and are at their start values.
fn settings(page: &mut String, report: &Report, description: &Description, unused: &[String]) -> Result<()> {
    let has_before = !report.before.is_empty();
    writeln!(page, "<h2>Settings</h2>\n<table>\n<thead><tr><th>Name</th><th class=\"number\">Value</th><th>Unit</th>")?;
    if has_before {
        let run = report.compared.first().filter(|_| report.compared.len() > 1);
        let name = run.map_or_else(String::new, |(run, _)| format!(" ({})", run.name));
        writeln!(page, "<th class=\"number\">Before{}</th>", Text(&name))?;
    }
    writeln!(page, "<th class=\"number\">Start</th><th>From</th><th>Meaning</th></tr></thead>\n<tbody>")?;
    let width = if has_before { 7 } else { 6 };
    let is_start = |variable: &Variable, value: Value| shown(variable, value) == shown(variable, variable.start);
    let is_shown = |name: &str| {
        let set = report.of.settings.iter().find(|setting| setting.name == name);
        let variable = description.variables.iter().find(|variable| variable.name == name);
        let is_at_start = set.zip(variable).is_none_or(|(set, variable)| is_start(variable, set.value));
        let before = report.before.iter().find(|setting| setting.name == name);
        let was_at_start = before.zip(variable).is_none_or(|(before, variable)| is_start(variable, before.value));
        !(unused.iter().any(|unused| unused == name) && is_at_start && was_at_start)
    };
    for group in &description.groups {
        if !group.fields.iter().any(|field| is_shown(&field.name)) {
            continue;
        }
        writeln!(page, "<tr><th colspan=\"{width}\" scope=\"rowgroup\">{}</th></tr>", Text(&group.title))?;
        for field in group.fields.iter().filter(|field| is_shown(&field.name)) {
            let Some(variable) = description.variables.iter().find(|variable| variable.name == field.name) else {
                continue;
            };
            let set = report.of.settings.iter().find(|setting| setting.name == field.name);
            let value = set.map_or(variable.start, |setting| setting.value);
            let before = report.before.iter().find(|setting| setting.name == field.name).map(|setting| setting.value);
            // A setting without a previous value had its start value.
            let before = before.or_else(|| has_before.then_some(variable.start));
            let reference = before.unwrap_or(variable.start);
            let source = report.record.and_then(|record| record.source_of_own(&field.name));
            let is_changed = source.is_none() && shown(variable, value) != shown(variable, reference);
            let is_unused = unused.contains(&field.name);
            let class = match (is_changed, is_unused) {
                (true, _) => " class=\"changed\"",
                (_, true) => " class=\"unused\"",
                _ => "",
            };
            let mut from = match (source, set.and_then(|setting| setting.origin.as_deref())) {
                (Some(source), _) => format!("connected to {source}"),
                _ if is_changed && before.is_some() => "changed".to_string(),
                (None, Some(origin)) => origin.to_string(),
                (None, None) if is_start(variable, value) => "start value".into(),
                (None, None) => "set".into(),
            };
            if is_unused {
                from.push_str(", no effect");
            }
            let in_force = |variable: &Variable, value: Value| match source {
                Some(_) => "\u{2013}".to_string(),
                None => shown(variable, value),
            };
            write!(
                page,
                "<tr{class}><td class=\"name\">{}</td><td class=\"number\">{}</td><td>{}</td>",
                Text(&field.name),
                Text(&in_force(variable, value)),
                Text(&units::shown(unit_of(variable, &description.roles, report.units)))
            )?;
            if has_before {
                let before = before.map_or_else(String::new, |value| in_force(variable, value));
                write!(page, "<td class=\"number\">{}</td>", Text(&before))?;
            }
            writeln!(
                page,
                "<td class=\"number\">{}</td><td class=\"from\">{}</td><td>{}</td></tr>",
                Text(&shown(variable, variable.start)),
                Text(&from),
                Text(&variable.description)
            )?;
        }
    }
    writeln!(page, "</tbody>\n</table>")?;
    let fields = description.groups.iter().flat_map(|group| &group.fields).map(|field| field.name.as_str());
    let rest: Vec<_> = fields.filter(|name| !is_shown(name)).collect();
    if !rest.is_empty() {
        let are = if rest.len() == 1 { "its start value" } else { "their start values" };
        writeln!(page, "<p class=\"rest\">Without effect, and at {are}: {}.</p>", Text(&rest.join(", ")))?;
    }
    Ok(())
}

/// The unit of a setting: its own, or that of the process value or manipulated value to which it refers.
fn unit_of<'a>(variable: &'a Variable, roles: &Roles, units: [Option<&'a str>; 2]) -> &'a str {
    let is = |role: Option<&String>| role == Some(&variable.name);
    // Without a process value, as in a ramp, the setpoint need not have the plant's unit.
    let is_controlled = roles.process_value.is_some()
        && [&roles.setpoint, &roles.process_value].into_iter().any(|role| is(role.as_ref()));
    let is_manipulated = is(roles.manual.as_ref().map(|(_, value)| value))
        || roles.limits.iter().any(|(high, low)| [high, low].contains(&&variable.name))
        || roles.disturbances.contains(&variable.name);
    let of_loop = match (is_controlled, is_manipulated) {
        (true, _) => units[0],
        (_, true) => units[1],
        _ => None,
    };
    let own = variable.unit.as_deref();
    own.filter(|unit| *unit != "1").or(of_loop).or(own).unwrap_or_default()
}

/// A value with three significant digits, or in full if one of `others` would look the same.
fn brief(value: Value, others: &[Value]) -> String {
    let Value::Number(number) = value else { return shown_alone(value) };
    let is_alike = |other: &Value| *other != value && three(number_of(*other)) == three(number);
    if others.iter().any(is_alike) { short(number) } else { three(number) }
}

/// A value formatted according to its PLC type.
fn shown(variable: &Variable, value: Value) -> String {
    match (variable.kind.as_str(), value) {
        ("BOOL" | "Boolean", value) => if number_of(value) == 0.0 { "FALSE" } else { "TRUE" }.into(),
        ("REAL", value) => format!("{}", number_of(value) as f32),
        (_, value) => format!("{}", number_of(value)),
    }
}

/// A value without its variable.
fn shown_alone(value: Value) -> String {
    match value {
        Value::Boolean(value) => if value { "TRUE" } else { "FALSE" }.to_string(),
        Value::Whole(value) => value.to_string(),
        Value::Number(value) => short(value),
    }
}

/// How a value was set, as appended to it in the table of events.
fn told(act: Act) -> &'static str {
    match act {
        Act::Set => "",
        Act::Write => ", written once",
        Act::Force => ", forced",
        Act::Release => ", released",
    }
}

/// The events of the run.
fn events(page: &mut String, record: &Record, runs: &[(&ReportedRun, Figures)]) -> Result<()> {
    let events = record.events();
    writeln!(page, "<h2>Events</h2>")?;
    let named = runs.iter().find(|(run, _)| run.run == record.number());
    let name = named.map_or_else(|| format!("Run {}", record.number() + 1), |(run, _)| run.name.clone());
    write!(page, "<p>{}: {} calls, {} s apart.", Text(&name), events.calls, short(record.step()))?;
    for (from, to) in &record.setup().connections {
        write!(page, " {} is connected to {}.", Text(from), Text(to))?;
    }
    if let Some(failure) = record.failure() {
        write!(page, " It ended with an error: {}", Text(failure))?;
    }
    writeln!(page, "</p>")?;
    if !events.events.is_empty() {
        writeln!(
            page,
            "<table>\n<thead><tr><th class=\"number\">Time</th><th>Variable</th><th class=\"number\">Value</th></tr></thead>\n<tbody>"
        )?;
        for event in events.events.iter().take(MOST_EVENTS) {
            writeln!(
                page,
                "<tr><td class=\"number\">{} s</td><td>{}</td><td class=\"number\">{}</td></tr>",
                short(event.time),
                Text(&event.variable),
                Text(&(shown_alone(event.value) + told(event.act)))
            )?;
        }
        writeln!(page, "</tbody>\n</table>")?;
        if events.events.len() > MOST_EVENTS {
            writeln!(page, "<p>And {} more.</p>", events.events.len() - MOST_EVENTS)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
