//! Tunes each loop of a table separately: the study of a single loop, and the results for all.

use crate::read::Reading;
use crate::table::{Rows, Source};
use crate::tune::Constraint;
use crate::tuned::Found;
use crate::tuning::Tuning;
use crate::{Along, Axis};
use anyhow::{Context, Result, anyhow, ensure};
use blocks::table::number::to_value;
use parameters::{BlockType, Format, Options, Origin};
use run::fmus::number_of;
use run::subject::About;
use run::system::{Setting, Value, own_name};
use std::fmt::Write as _;
use std::path::Path;

/// The tuning result of one loop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tuned {
    /// The loop's name.
    pub name: String,
    /// The settings found, in the order of the search variables.
    pub found: Vec<f64>,
    /// The current settings.
    pub now: Vec<f64>,
    /// The minimized figure with the settings found and with the current ones; `None` if it has no value.
    pub figure: [Option<f64>; 2],
    /// The value of each constraint, with the settings found and with the current ones.
    pub constraints: Vec<[Option<f64>; 2]>,
    /// The constraints that are active or that the current settings violate, which may explain why the figure is worse
    /// than now; `None` if there are none.
    pub remark: Option<String>,
    /// Why the settings must not be used, or why there are none; `None` if they meet all constraints.
    pub problem: Option<String>,
}

impl Reading {
    /// Whether each loop is tuned separately.
    pub fn is_each(&self) -> bool {
        self.tune().is_ok_and(|tune| tune.each)
    }

    /// The names of the loops in the table, or their 1-based numbers.
    ///
    /// # Errors
    /// The study has no table, has several that do not belong together, or is faulty.
    pub fn loops(&self) -> Result<Vec<String>> {
        let study = &self.job.study;
        study.check()?;
        let (first, rows) = self
            .tables
            .first()
            .context("[tune]: each = true, but no axis has a file: write [[axes]] with file = \"LOOPS.csv\"")
            .at("each")
            .at("tune")?;
        let belongs = |(number, _): &&(usize, Rows)| study.leader(*number) == study.leader(*first);
        if let Some((other, _)) = self.tables.iter().find(|table| !belongs(table)) {
            let error = Err(anyhow!(
                "{}: its rows and those of {} span a grid, but each = true requires a single table of loops: put \
                 both axes in the same group",
                study.axes[*other].label(*other),
                study.axes[*first].label(*first)
            ));
            return error.at(*other).at("axes");
        }
        let named = self.tables.iter().map(|(_, rows)| &rows.axis.names).find(|names| !names.is_empty());
        Ok(named.cloned().unwrap_or_else(|| (1..=rows.axis.along.length()).map(|row| row.to_string()).collect()))
    }

    /// The study of one loop: the values in its row of the table, and of the axes in the same group, become settings of
    /// the loop or, if they are relative, axes with a single row. Other axes remain.
    pub fn alone(&self, row: usize) -> Reading {
        let mut alone = self.clone();
        let study = &self.job.study;
        let leaders: Vec<usize> = self.tables.iter().map(|(number, _)| study.leader(*number)).collect();
        let (own, others): (Vec<usize>, Vec<usize>) =
            (0..study.axes.len()).partition(|number| leaders.contains(&study.leader(*number)));
        alone.job.study.axes = others.into_iter().map(|number| study.axes[number].clone()).collect();
        for number in own {
            let axis = &study.axes[number];
            let values = values(axis, row);
            if axis.relative {
                alone.job.study.axes.push(Axis { along: Along::Rows(vec![values]), group: None, ..axis.clone() });
                continue;
            }
            let settings = &mut alone.job.system.settings;
            for (variable, value) in axis.variables.iter().zip(values) {
                settings.retain(|of| of.variable != *variable || of.time != axis.time);
                let (variable, time) = (variable.clone(), axis.time);
                settings.push(Setting { variable, value, time, is_preliminary: false, place: None });
            }
        }
        alone.tables.clear();
        alone
    }
}

/// The values in one row of an axis, one for each variable.
fn values(axis: &Axis, row: usize) -> Vec<Value> {
    match &axis.along {
        Along::Rows(rows) => rows[row].clone(),
        Along::Values(values) => vec![values[row]; axis.variables.len()],
        Along::Range { from, to, count, logarithmic } => {
            let value = crate::axes::between(*from, *to, row as u64, *count, *logarithmic);
            vec![Value::Number(value); axis.variables.len()]
        }
        // A distribution, which cannot belong to a group.
        _ => Vec::new(),
    }
}

impl Tuned {
    /// Summarizes the result of a loop's search.
    pub fn new(name: &str, found: &Found) -> Tuned {
        let both = [found.best(), found.present];
        let value = |of: &Constraint| both.map(|one| Some(of.value(&one.rows)).filter(|value| !value.is_nan()));
        Tuned {
            name: name.into(),
            found: both[0].values.clone(),
            now: both[1].values.clone(),
            figure: both.map(|one| one.objective),
            constraints: found.tuning.problem.constraints.iter().map(value).collect(),
            remark: found.of_constraints(),
            problem: found.problem(),
        }
    }

    /// The result for a loop that could not be tuned.
    pub fn failed(name: &str, problem: String) -> Tuned {
        Tuned { name: name.into(), problem: Some(problem), ..Tuned::default() }
    }
}

/// The column names of [`csv()`].
pub fn columns(tuning: &Tuning) -> Vec<String> {
    let search = tuning.problem.search.iter().flat_map(|of| [of.variable.clone(), format!("{}.now", of.variable)]);
    let figure = &tuning.figures[tuning.problem.minimize].name;
    let constraints = tuning.problem.constraints.iter().map(|of| &of.0.text);
    search
        .chain([figure].into_iter().chain(constraints).flat_map(|name| [name.clone(), format!("{name}.now")]))
        .collect()
}

/// The results as CSV, one row per loop.
pub fn csv(columns: &[String], loops: &[Tuned]) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let field = |text: &String| if text.contains([',', '"', '\n']) { quoted(text) } else { text.clone() };
    let columns: Vec<String> = columns.iter().map(field).collect();
    let mut csv = format!("loop,{},remark,problem\n", columns.join(","));
    for one in loops {
        let settings = one.found.iter().zip(&one.now).flat_map(|(found, now)| [Some(*found), Some(*now)]);
        let constrained = one.constraints.iter().flatten().copied();
        let mut cells: Vec<Option<f64>> = settings.chain(one.figure).chain(constrained).collect();
        // A loop that could not be tuned has only its problem.
        cells.resize(columns.len(), None);
        let cells: Vec<String> =
            cells.into_iter().map(|value| value.map_or_else(String::new, |value| format!("{value:?}"))).collect();
        let [remark, problem] =
            [&one.remark, &one.problem].map(|text| text.as_deref().map_or_else(String::new, quoted));
        let _ = writeln!(csv, "{},{},{remark},{problem}", quoted(&one.name), cells.join(","));
    }
    csv
}

/// The parameter file at `path` with the settings found; loops with a problem keep their settings. `variables` are the
/// search variables.
///
/// # Errors
/// The file can no longer be read, it has no place for a value, or a setting does not fit the block's type.
pub fn written_back(path: &Path, source: &Source, variables: &[String], tuned: &[Tuned]) -> Result<Vec<u8>> {
    let shown = path.display().to_string();
    let format = Format::of_file(&shown).with_context(|| format!("{shown} is not a parameter file"))?;
    let mut loops = Vec::new();
    for (one, tuned) in source.loops.iter().zip(tuned).filter(|(_, tuned)| tuned.problem.is_none()) {
        ensure!(one.name == tuned.name, "{shown}: found the loop {} instead of {}", tuned.name, one.name);
        let mut one = one.clone();
        for (variable, value) in variables.iter().zip(&tuned.found) {
            let member = own_name(variable, &source.fmu).and_then(|own| one.block.find(own));
            // The search may include settings of another FMU, which the file does not contain.
            let Some(member) = member else { continue };
            let value = to_value(number_of(Value::Number(*value)), one.block.members[member].kind);
            one.set(member, value.map_err(|why| anyhow!("{variable} of {}: {why}", tuned.name))?, Origin::Default);
        }
        loops.push(one);
    }
    let text = parameters::Source::read(path, None).map_err(anyhow::Error::msg)?;
    let rewritten = parameters::rewrite(format, &text, &BlockType::all(), &Options::default(), &loops);
    Ok(rewritten.map_err(anyhow::Error::msg)?.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Job, Study};

    fn axis(variable: &str, along: Along, group: Option<&str>) -> Axis {
        Axis { variables: vec![variable.into()], along, group: group.map(Into::into), ..Axis::default() }
    }

    #[test]
    fn a_loop_alone_has_its_row_of_the_table_and_of_the_axes_of_its_group_as_settings() {
        let numbers = |list: &[f64]| list.iter().map(|value| Value::Number(*value)).collect::<Vec<_>>();
        let rows = Along::Rows(vec![numbers(&[1.0]), numbers(&[2.0])]);
        let names = vec!["TIC1".to_string(), "TIC2".to_string()];
        let of_file = Axis { names, ..axis("C.GAIN", rows, Some("loops")) };
        let axes = vec![
            axis("P.LAG", Along::Values(numbers(&[5.0, 6.0])), Some("loops")),
            of_file.clone(),
            axis("P.NOISE", Along::Values(numbers(&[0.0, 1.0])), None),
        ];
        let table = Rows { path: "loops.csv".into(), axis: of_file, source: None, remarks: Vec::new() };
        let reading = Reading {
            name: "all".into(),
            description: String::new(),
            fmus: None,
            job: Job { study: Study { axes, ..Study::default() }, ..Job::default() },
            tables: vec![(1, table)],
            renews: None,
            source: Some(parameters::Source::new("study.toml", "[tune]\nminimize = \"iae\"\neach = true\n".into())),
        };
        assert!(reading.is_each());
        assert_eq!(reading.loops().unwrap(), ["TIC1", "TIC2"]);
        let alone = reading.alone(1).job;
        let settings: Vec<_> = alone.system.settings.iter().map(|of| (of.variable.as_str(), of.value)).collect();
        assert_eq!(settings, [("P.LAG", Value::Number(6.0)), ("C.GAIN", Value::Number(2.0))]);
        assert_eq!(alone.study.axes.len(), 1);
        assert_eq!(alone.study.axes[0].variables, ["P.NOISE"]);
    }

    #[test]
    fn the_table_of_results_has_a_row_for_each_loop_those_that_failed_too() {
        let figure = [Some(10.0), None];
        let tuned = Tuned {
            name: "A".into(),
            found: vec![2.0],
            now: vec![1.0],
            figure,
            constraints: vec![[Some(1.7), Some(2.5)]],
            remark: Some("ms < 1.8 is active".into()),
            problem: None,
        };
        let failed = Tuned::failed("B", "no \"plant\"".into());
        let columns = ["C.GAIN", "C.GAIN.now", "iae", "iae.now", "ms < 1.8", "ms < 1.8.now"].map(String::from);
        assert_eq!(
            csv(&columns, &[tuned, failed]),
            "loop,C.GAIN,C.GAIN.now,iae,iae.now,ms < 1.8,ms < 1.8.now,remark,problem\n\
             \"A\",2.0,1.0,10.0,,1.7,2.5,\"ms < 1.8 is active\",\n\
             \"B\",,,,,,,,\"no \"\"plant\"\"\"\n"
        );
    }
}
