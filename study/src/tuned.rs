//! The result of a search, as text and in files.

use crate::expect::with_unit;
use crate::results::Quantity;
use crate::tune::{Candidate, Constraint, Outcome, Over};
use crate::tuning::Tuning;
use anyhow::{Result, anyhow};
use blocks::table::number::to_value;
use draw::picture;
use draw::plot::{self, Chart, Curve, Panel};
use host::package::temporary;
use modeldescription::digits::{short, within};
use modeldescription::units;
use parameters::{BlockType, Format, Loop, Origin};
use run::file;
use run::fmus::number_of;
use run::system::{System, own_name};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A search and its result.
#[derive(Clone, Copy, Debug)]
pub struct Found<'a> {
    /// The search.
    pub tuning: &'a Tuning,
    /// Its outcome.
    pub outcome: &'a Outcome,
    /// The result with the current settings.
    pub present: &'a Candidate,
}

impl Found<'_> {
    pub(crate) fn best(&self) -> &Candidate {
        &self.outcome.candidates[self.outcome.best]
    }

    /// Lists the constraints that prevent a better figure, and those that the current settings violate, which may be
    /// why the current figure is better; `None` if there are none.
    pub(crate) fn of_constraints(&self) -> Option<String> {
        let one = |constraint: &Constraint| {
            let text = &constraint.0.text;
            let value = constraint.value(&self.present.rows);
            let now = if value.is_nan() {
                "not known for every plant".into()
            } else {
                with_unit(value, &self.tuning.figures[constraint.0.figure])
            };
            match (constraint.is_active(&self.best().rows), constraint.holds(&self.present.rows)) {
                (true, true) => Some(format!("{text} is active")),
                (true, false) => Some(format!("{text} is active, but the current settings violate it ({now})")),
                (false, false) => Some(format!("the current settings violate {text} ({now})")),
                (false, true) => None,
            }
        };
        let all: Vec<String> = self.tuning.problem.constraints.iter().filter_map(one).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }

    /// Why there is no usable result; `None` if the best candidate is feasible.
    pub fn problem(&self) -> Option<String> {
        let best = self.best();
        if best.is_feasible() {
            return None;
        }
        let broken = self.tuning.problem.constraints.iter().filter(|constraint| !constraint.holds(&best.rows));
        let broken: Vec<String> = broken
            .map(|constraint| {
                let value = constraint.value(&best.rows);
                if value.is_nan() {
                    return format!("{} (not known for every plant)", constraint.0.text);
                }
                let unit = self.tuning.figures[constraint.0.figure].unit.as_deref().unwrap_or_default();
                format!("{} ({} {unit}", constraint.0.text, short(value)).trim_end().to_string() + ")"
            })
            .collect();
        let what = if broken.is_empty() {
            format!(
                "for the closest one, {} is not known for every plant",
                self.tuning.figures[self.tuning.problem.minimize].name
            )
        } else {
            format!("the closest one violates {}", broken.join(" and "))
        };
        Some(format!("no candidate meets all constraints; {what}. Relax them, or search wider ranges"))
    }

    /// Remarks on the result for the user.
    pub fn remarks(&self) -> Vec<String> {
        let search = self.tuning.problem.search.iter().zip(&self.best().values);
        let ends = search.filter_map(|(search, value)| {
            let end = search.end(*value)?;
            Some(format!(
                "{} = {} is at the {end} of its range: a wider range may yield a better result",
                search.variable,
                short(*value)
            ))
        });
        let front = (self.tuning.problem.front.is_some() && self.best().is_feasible() && self.outcome.front.len() == 1)
            .then(|| "the front is a single point: both figures are lowest with the same settings".to_string());
        ends.chain(front).collect()
    }

    /// The output of the command: settings, figures and constraints found, beside those of the current settings.
    pub fn text(&self) -> String {
        let (best, problem) = (self.best(), &self.tuning.problem);
        let found = if best.is_feasible() { "found" } else { "closest" };
        let (plants, candidates) = (self.tuning.plants(), self.outcome.candidates.len());
        let plural = if plants == 1 { "" } else { "s" };
        let mut text = format!("{plants} plant{plural}, {candidates} candidates\n\n");
        let mut settings = vec![["setting", found, "now", ""].map(String::from).to_vec()];
        for (place, search) in problem.search.iter().enumerate() {
            let unit = self.tuning.units[place].clone().unwrap_or_default();
            let [new, old] = [best, self.present].map(|of| short(of.values[place]));
            settings.push(vec![search.variable.clone(), new, old, unit]);
        }
        text += &table(&settings);
        let header = ["figure", found, "", "now", "", ""];
        let mut figures = vec![header.map(String::from).to_vec()];
        figures.push(
            [if plants == 1 { "" } else { "over all plants" }, "highest", "mean", "highest", "mean", ""]
                .map(String::from)
                .to_vec(),
        );
        for (place, Quantity { name, unit, .. }) in self.tuning.figures.iter().enumerate() {
            let values =
                [best, self.present].map(|of| of.rows.iter().map(|row| row.figures[place]).collect::<Vec<_>>());
            let cells =
                values.iter().flat_map(|values| [Over::Worst, Over::Mean].map(|over| known(over.combine(values))));
            let mut row = vec![name.clone()];
            row.extend(cells);
            row.push(unit.clone().unwrap_or_default());
            figures.push(row);
        }
        text += "\n";
        text += &table(&figures);
        if !problem.constraints.is_empty() {
            let mut constraints = vec![["constraint", found, "now", ""].map(String::from).to_vec()];
            for constraint in &problem.constraints {
                let [new, old] = [best, self.present].map(|of| known(Some(constraint.value(&of.rows))));
                let state = match (constraint.holds(&best.rows), constraint.holds(&self.present.rows)) {
                    (false, _) => "violated",
                    (true, _) if constraint.is_active(&best.rows) => "active",
                    (true, false) => "violated now",
                    (true, true) => "",
                };
                constraints.push(vec![constraint.0.text.clone(), new, old, state.into()]);
            }
            text += "\n";
            text += &table(&constraints);
        }
        if let Some(front) = self.front_text() {
            let _ = writeln!(text, "\n{front}");
        }
        text
    }

    fn front_text(&self) -> Option<String> {
        let second = &self.tuning.figures[self.tuning.problem.front?];
        let first = &self.tuning.figures[self.tuning.problem.minimize];
        let of = |number: &usize| {
            let candidate = &self.outcome.candidates[*number];
            let shown = |quantity: &Quantity, value: Option<f64>| {
                let unit = quantity.unit.as_deref().unwrap_or_default();
                format!("{} {} {unit}", quantity.name, known(value)).trim_end().to_string()
            };
            format!("{}, {}", shown(first, candidate.objective), shown(second, candidate.second))
        };
        let (from, to) = (self.outcome.front.first()?, self.outcome.front.last()?);
        Some(format!("front: {} settings, from {} to {}", self.outcome.front.len(), of(from), of(to)))
    }

    /// The front as CSV: the settings and, for each figure, the maximum and the mean over the plants.
    fn front_csv(&self) -> Result<Vec<u8>> {
        let search = self.tuning.problem.search.iter().map(|search| search.variable.clone());
        let figures =
            self.tuning.figures.iter().flat_map(|of| ["highest", "mean"].map(|what| format!("{}.{what}", of.name)));
        let mut csv = csv::Writer::from_writer(Vec::new());
        csv.write_record(search.chain(figures))?;
        for number in &self.outcome.front {
            let candidate = &self.outcome.candidates[*number];
            let values = candidate.values.iter().map(|value| format!("{value:?}"));
            let figures = (0..self.tuning.figures.len()).flat_map(|place| {
                let values: Vec<f64> = candidate.rows.iter().map(|row| row.figures[place]).collect();
                [Over::Worst, Over::Mean]
                    .map(|over| over.combine(&values).map_or_else(String::new, |value| format!("{value:?}")))
            });
            csv.write_record(values.chain(figures))?;
        }
        Ok(csv.into_inner()?)
    }

    /// The settings found and the current ones as CSV.
    fn settings_csv(&self) -> Result<Vec<u8>> {
        let mut csv = csv::Writer::from_writer(Vec::new());
        csv.write_record(["setting", "unit", "found", "now"])?;
        for (place, search) in self.tuning.problem.search.iter().enumerate() {
            let unit = self.tuning.units[place].as_deref().unwrap_or_default();
            let [new, old] = [self.best(), self.present].map(|of| of.values[place]);
            csv.write_record([&search.variable, unit, &format!("{new:?}"), &format!("{old:?}")])?;
        }
        Ok(csv.into_inner()?)
    }

    /// A chart of the second figure and the settings as functions of the first figure; `None` without a front of at
    /// least two points.
    fn chart(&self) -> Option<Chart> {
        let problem = &self.tuning.problem;
        let second = &self.tuning.figures[problem.front?];
        let candidates: Vec<&Candidate> =
            self.outcome.front.iter().map(|number| &self.outcome.candidates[*number]).collect();
        if candidates.len() < 2 {
            return None;
        }
        let labelled = |name: &str, unit: Option<&String>| match unit {
            Some(unit) => format!("{name} in {unit}"),
            None => name.to_string(),
        };
        let panel = |name: &str, unit: Option<&String>, values: Vec<f64>| Panel {
            label: labelled(name, unit),
            curves: vec![Curve { name: name.into(), values, is_input: false, color: None }],
            ..Panel::default()
        };
        let seconds = candidates.iter().map(|of| of.second.unwrap_or(f64::NAN)).collect();
        let mut panels = vec![panel(&second.name, second.unit.as_ref(), seconds)];
        for (place, search) in problem.search.iter().enumerate() {
            let values = candidates.iter().map(|of| of.values[place]).collect();
            panels.push(panel(&search.variable, self.tuning.units[place].as_ref(), values));
        }
        let first = &self.tuning.figures[problem.minimize];
        let over = match problem.over {
            Over::Worst => "of the worst plant",
            Over::Mean => "mean over the plants",
            Over::P95 => "95th percentile over the plants",
        };
        let ends = [candidates.first()?, candidates.last()?];
        Some(Chart {
            title: format!("{}, {over}", traded(first, second, ends.map(|of| (of.objective, of.second)))),
            time: candidates.iter().map(|of| of.objective.unwrap_or(f64::NAN)).collect(),
            over: Some(labelled(&first.name, first.unit.as_ref())),
            panels,
            has_dots: true,
            ..Chart::default()
        })
    }
}

/// The names of the files that [`write()`] may create.
pub const FILES: [&str; 6] = ["tuned.toml", "tuned.json", "settings.csv", "front.csv", "front.png", "front.svg"];

/// Writes the files of a result to a folder, each via a temporary file that is renamed. Returns their paths.
///
/// # Errors
/// A file cannot be written, or a setting does not fit the block's type.
pub fn write(folder: &Path, found: &Found) -> Result<Vec<PathBuf>> {
    let system = found.tuning.system(&found.best().values);
    std::fs::create_dir_all(folder).map_err(|error| anyhow!("{} cannot be created: {error}", folder.display()))?;
    let mut files: Vec<(&str, Vec<u8>)> = vec![("tuned.toml", file::write(&system.as_in(folder))?.into_bytes())];
    files.extend(parameter_file(found.tuning, &system)?.map(|content| ("tuned.json", content)));
    files.push(("settings.csv", found.settings_csv()?));
    if found.tuning.problem.front.is_some() {
        files.push(("front.csv", found.front_csv()?));
    }
    if let Some(chart) = found.chart() {
        let svg = plot::svg(&chart)?;
        files.push(("front.png", picture::png(&svg)?));
        files.push(("front.svg", svg.into_bytes()));
    }
    let mut paths = Vec::new();
    for (name, content) in files {
        let path = folder.join(name);
        temporary::place(&path, |to| Ok(to.write_all(&content)?), |_| Ok(()))?;
        paths.push(path);
    }
    Ok(paths)
}

/// The controller's settings as a parameter file; `None` if its block is not a type that parameter files support.
fn parameter_file(tuning: &Tuning, system: &System) -> Result<Option<Vec<u8>>> {
    let known =
        |table: &modeldescription::Table| BlockType::all().into_iter().find(|block| block.is_called(&table.name));
    let Some(block) = tuning.table().and_then(known) else { return Ok(None) };
    let Some(controller) = system.members.first() else { return Ok(None) };
    let mut one = Loop::new(controller.name.as_str(), block.clone());
    let mut settings: Vec<_> = system.settings.iter().filter(|of| of.time.is_none()).collect();
    // Those from a parameter file come first, so that other settings override them.
    settings.sort_by_key(|of| !of.is_preliminary);
    for setting in settings {
        let own = own_name(&setting.variable, &controller.name);
        if let Some(member) = own.and_then(|own| block.find(own)) {
            let value = to_value(number_of(setting.value), block.members[member].kind);
            let value = value.map_err(|why| anyhow!("{}: {why}", setting.variable))?;
            one.set(member, value, Origin::Default);
        }
    }
    let content = parameters::write(Format::Json, &[one], "plcfmu tune-study").map_err(anyhow::Error::msg)?;
    Ok(Some(content))
}

/// A sentence on the two ends of a front: the values of both figures at each.
fn traded(first: &Quantity, second: &Quantity, ends: [(Option<f64>, Option<f64>); 2]) -> String {
    let of = |quantity: &Quantity, values: [Option<f64>; 2]| {
        let [from, to] = values.map(|value| value.unwrap_or(f64::NAN));
        let unit = quantity.unit.as_ref().map_or_else(String::new, |unit| format!(" {unit}"));
        [from, to].map(|value| units::shown(&format!("{}{unit}", within(value, (to - from).abs()))))
    };
    let [[least, most], [at_least, at_most]] = [of(first, ends.map(|end| end.0)), of(second, ends.map(|end| end.1))];
    format!("From {} {least} with {} {at_least} to {most} with {at_most}", first.name, second.name)
}

/// A figure for display; `-` if it has no value.
fn known(value: Option<f64>) -> String {
    value.filter(|value| !value.is_nan()).map_or_else(|| "-".into(), short)
}

/// A text table: the first and last column are left-aligned, the others right-aligned.
fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, width))| match column {
            0 => format!("{cell:width$}"),
            _ if column + 1 == columns => cell.clone(),
            _ => format!("{cell:>width$}"),
        });
        text += cells.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_end_below_each_other_and_a_line_has_no_spaces_at_its_end() {
        let rows = [["setting", "found", "now", ""], ["C.GAIN", "1.5", "0.25", ""], ["C.TI", "80", "100", "s"]];
        assert_eq!(
            table(&rows.map(|row| row.map(String::from).to_vec())),
            "setting  found   now\nC.GAIN     1.5  0.25\nC.TI        80   100  s\n"
        );
    }

    #[test]
    fn a_front_says_what_is_traded_for_what() {
        let quantity = |name: &str, unit: &str| Quantity::new(name, Some(unit));
        let ends = [(Some(1203.4), Some(45.26)), (Some(2311.9), Some(20.51))];
        assert_eq!(
            traded(&quantity("iae", "K s"), &quantity("travel", "%"), ends),
            "From iae 1200 K s with travel 45.3 % to 2310 K s with 20.5 %"
        );
    }

    #[test]
    fn a_figure_that_cannot_be_said_is_a_dash() {
        assert_eq!([None, Some(f64::NAN), Some(f64::INFINITY), Some(0.5)].map(known), ["-", "-", "inf", "0.5"]);
    }
}
