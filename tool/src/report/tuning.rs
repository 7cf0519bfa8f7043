//! How the settings of a report were computed: the plant's model, the rule, and the margins of its result and of the
//! settings in force.

use super::{Report, Tuning, shown, three, with_unit};
use crate::home::Home;
use crate::message::Description;
use anyhow::Result;
use control::bode;
use control::identify::Model;
use control::rules;
use draw::escape::Text;
use modeldescription::units;
use run::fmus::{Member, Values, number_of};
use run::system::Value;
use std::fmt::Write;

/// Writes the plant's model, the rule and the margins; the settings in force that differ from the rule's; and the
/// compared rules.
///
/// # Errors
/// No such FMU.
pub(super) fn told(
    page: &mut String,
    home: &dyn Home,
    report: &Report,
    of: &Tuning,
    (fmu, description): (&str, &Description),
) -> Result<()> {
    let Model { gain, time_constant, second_time_constant, dead_time, is_integrating } = of.model;
    // For a step controller, the manipulated value is the travel of the actuator.
    let travel = report.units[1].or((!description.roles.pulses.is_empty()).then_some("%"));
    let [process_value, manipulated_value] = [report.units[0], travel].map(|unit| units::shown(unit.unwrap_or("1")));
    let of_gain = match (process_value.as_ref(), manipulated_value.as_ref(), is_integrating) {
        ("1", "1", false) => String::new(),
        (above, "1", true) => format!("{above}/s"),
        (above, "1", false) => above.to_string(),
        (above, below, true) => format!("{above}/({below}\u{b7}s)"),
        (above, below, false) => format!("{above}/{below}"),
    };
    let mut rows = vec![("K", three(gain), of_gain.as_str())];
    if !is_integrating {
        rows.push(("T", three(time_constant), "s"));
    }
    if second_time_constant != 0.0 {
        rows.push(("T2", three(second_time_constant), "s"));
    }
    rows.push(("L", three(dead_time), "s"));
    rows.extend(of.closed_loop.map(|lambda| ("\u{3bb}", three(lambda), "s")));
    rows.extend(margins([of.sensitivity, of.gain_margin, of.phase_margin]));
    let values: Vec<String> = of
        .values
        .iter()
        .filter_map(|(name, value)| match value {
            Value::Boolean(_) => None,
            value => Some(format!("{name} {}", three(number_of(*value)))),
        })
        .collect();
    let rule = rules::name(of.rule);
    writeln!(
        page,
        "<h2>Tuning</h2>\n<p class=\"about\">{} by {} for {} dead time L.</p>",
        Text(&values.join(", ")),
        Text(rule),
        if is_integrating {
            "an integrating plant with gain K and"
        } else {
            "a plant with gain K, time constant T and"
        }
    )?;
    facts(page, &rows)?;
    in_force(page, home, report, of, (fmu, description))?;
    super::rules::table(page, report, of, description)?;
    let mut part = String::new();
    match super::rules::before_and_after(&mut part, home, report, of, (fmu, description)) {
        Ok(()) => page.push_str(&part),
        Err(error) => {
            let why = format!("{error:#}");
            writeln!(page, "<p>The step before and after tuning is not predicted: {}.</p>", Text(&why))?;
        }
    }
    Ok(())
}

/// The controller's settings in force that differ from the rule's, with the margins that they result in.
fn in_force(
    page: &mut String,
    home: &dyn Home,
    report: &Report,
    of: &Tuning,
    (fmu, description): (&str, &Description),
) -> Result<()> {
    let mut values = Values::new();
    let mut others = Vec::new();
    for variable in &description.variables {
        let set = report.of.settings.iter().find(|setting| setting.name == variable.name);
        let value = set.map_or(variable.start, |setting| setting.value);
        if set.is_some() {
            values.insert(variable.name.clone(), value);
        }
        let Some(by_rule) = of.values.get(&variable.name) else { continue };
        let told = |value: Value| match value {
            Value::Boolean(_) => shown(variable, value),
            value => with_unit(number_of(value), variable.unit.as_deref()),
        };
        if told(value) != told(*by_rule) {
            others.push(format!("{} {} instead of {}", variable.name, told(value), told(*by_rule)));
        }
    }
    if others.is_empty() {
        writeln!(page, "<p>These settings are in force.</p>")?;
        return Ok(());
    }
    writeln!(page, "<p>The settings in force differ from those of the rule: {}.</p>", Text(&others.join(", ")))?;
    let controller = Member { name: report.of.name.clone(), fmu: fmu.into(), values };
    match bode::bode(home, &bode::BodeRequest { model: of.model, controller, others: Vec::new() }) {
        Ok(plot) => {
            let now = &plot.loops[0];
            if now.sensitivity.is_none() {
                writeln!(page, "<p>With these settings, the loop with this plant is unstable.</p>")?;
            }
            facts(page, &margins([now.sensitivity, now.gain_margin, now.phase_margin]))
        }
        Err(error) => {
            writeln!(page, "<p>Their margins cannot be computed: {}.</p>", Text(&format!("{error:#}")))?;
            Ok(())
        }
    }
}

/// Ms, gain margin and phase margin, as name, value and unit; those that do not exist are left out.
fn margins(of: [Option<f64>; 3]) -> Vec<(&'static str, String, &'static str)> {
    let names = [("Ms", ""), ("gain margin", ""), ("phase margin", "\u{b0}")];
    names.into_iter().zip(of).filter_map(|((name, unit), value)| Some((name, three(value?), unit))).collect()
}

/// A list of facts: name, value and unit.
fn facts(page: &mut String, rows: &[(&str, String, &str)]) -> Result<()> {
    writeln!(page, "<dl class=\"figures\">")?;
    for (name, value, unit) in rows {
        writeln!(page, "<div><dt>{name}</dt> <dd>{value} {}</dd></div>", Text(unit))?;
    }
    writeln!(page, "</dl>")?;
    Ok(())
}
