//! A table with a row for each loop: a CSV file whose columns are variables, or a PLC parameter file with several loops.

use crate::{Along, Axis};
use anyhow::{Context, Result, anyhow, bail, ensure};
use control::csv;
use parameters::{Format, Loop, Options, Origin};
use run::file::{ReadParameters, remarks};
use run::system::{Setting, System, Value};
use std::fs;
use std::path::{Path, PathBuf};

/// The columns that may name the loops.
const NAMES: [&str; 3] = ["loop", "name", "tag"];

/// The rows of a file as the values of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// The variables, of each row a value for each of them, and the names of the loops, if the file has them.
    pub axis: Axis,
    /// The parameter file that they are from, for the FMU of this name in the loop.
    pub source: Option<Source>,
    /// What is to be said of the file.
    pub remarks: Vec<String>,
}

/// A parameter file.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Its path.
    pub path: PathBuf,
    /// The FMU's name.
    pub fmu: String,
    /// The loops, in the order of the rows.
    pub loops: Vec<Loop>,
}

/// Reads the rows of a file. `fmu` is the FMU that gets the values of a parameter file; variables of `fixed` are left out of these.
///
/// # Errors
/// The file cannot be read, or it is no table; what to do.
pub fn read(
    path: &Path,
    fmu: Option<&str>,
    system: &System,
    fixed: &[String],
    parameters: ReadParameters,
) -> Result<Rows> {
    let shown = path.display().to_string();
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase).as_deref() {
        Some("csv" | "txt" | "tsv") => {
            ensure!(fmu.is_none(), "{shown}: the header of a CSV file names FMUs with their variables: omit fmu");
            let text = fs::read_to_string(path).with_context(|| format!("{shown} cannot be read as text"))?;
            of_csv(&text).with_context(|| shown)
        }
        Some("parquet") => {
            bail!("{shown}: write the table as CSV: in Python, pandas.read_parquet({shown:?}).to_csv(...)")
        }
        _ if Format::of_file(&shown).is_some() => of_parameters(path, fmu, system, fixed, parameters),
        _ => bail!("{shown} is neither a CSV file nor a parameter file of a PLC: its extension says what it is"),
    }
}

fn of_csv(text: &str) -> Result<Rows> {
    let table = csv::Table::read(text)?;
    let columns: Vec<&csv::Column> = table.columns.iter().filter(|column| column.name.contains('.')).collect();
    ensure!(!columns.is_empty(), "no column is a variable: write FMU.VARIABLE in the header, such as PUMP.SPEED");
    let mut rows = Vec::new();
    for (row, line) in table.lines.iter().enumerate() {
        let value = |column: &&csv::Column| match column.values[row] {
            value if value.is_finite() && column.is_boolean => Ok(Value::Boolean(value != 0.0)),
            value if value.is_finite() => Ok(Value::Number(value)),
            _ => Err(anyhow!("line {line} has no number for {}: complete it, or remove the row", column.name)),
        };
        rows.push(columns.iter().map(value).collect::<Result<Vec<_>>>()?);
    }
    let names = csv::texts(text, &NAMES)?.unwrap_or_default();
    let variables = columns.iter().map(|column| column.name.clone()).collect();
    let axis = Axis { variables, names, along: Along::Rows(rows), ..Axis::default() };
    // The names are texts, and are not left out here.
    let is_of_names =
        |remark: &str| NAMES.iter().any(|name| remark.to_lowercase().starts_with(&format!("the column {name} ")));
    let remarks = table.remarks.into_iter().filter(|remark| !is_of_names(remark)).collect();
    Ok(Rows { axis, source: None, remarks })
}

fn of_parameters(
    path: &Path,
    fmu: Option<&str>,
    system: &System,
    fixed: &[String],
    parameters: ReadParameters,
) -> Result<Rows> {
    let shown = path.display().to_string();
    let names: Vec<&str> = system.members.iter().map(|member| member.name.as_str()).collect();
    let fmu = fmu.or(names.first().copied()).unwrap_or_default();
    ensure!(names.contains(&fmu), "fmu = {fmu:?}: there is no such FMU in the loop, only {}", names.join(", "));
    let reading = parameters(&shown, &Options::default())?;
    let block = reading.loops.first().map(|one| one.block.name.clone());
    let block = block.with_context(|| format!("{shown} has no loops"))?;
    // A file of a plant may have blocks of several kinds; those of the FMU are looked for by the plan.
    let is_own = |one: &&Loop| Some(&one.block.name) == of_fmu(system, fmu, &reading.loops).or(Some(&block));
    let loops: Vec<Loop> = reading.loops.iter().filter(is_own).cloned().collect();
    let is_given = |member: usize| loops.iter().any(|one| one.settings[member].origin != Origin::Default);
    let is_free = |of: &Setting| {
        !fixed.contains(&of.variable) && !system.connections.iter().any(|connection| connection.to == of.variable)
    };
    let first = loops.first().with_context(|| format!("{shown} has no loops for {fmu}"))?;
    let settings = |one: &Loop| Setting::of_loop(one, fmu, None);
    let all = settings(first);
    let kept: Vec<usize> = (0..all.len()).filter(|member| is_given(*member) && is_free(&all[*member])).collect();
    ensure!(!kept.is_empty(), "{shown} sets nothing that the study does not set itself");
    let row = |one: &Loop| {
        let all = settings(one);
        kept.iter().map(|member| all[*member].value).collect()
    };
    let variables = kept.iter().map(|member| all[*member].variable.clone()).collect();
    let names = loops.iter().map(|one| one.name.clone()).collect();
    let axis = Axis { variables, names, along: Along::Rows(loops.iter().map(row).collect()), ..Axis::default() };
    Ok(Rows { axis, remarks: remarks(&reading), source: Some(Source { path: path.into(), fmu: fmu.into(), loops }) })
}

/// The block of the loops that an FMU can have, by the name of its file.
fn of_fmu<'a>(system: &System, fmu: &str, loops: &'a [Loop]) -> Option<&'a String> {
    let path = &system.members.iter().find(|member| member.name == fmu)?.path;
    let stem = path.file_stem()?.to_str()?;
    loops.iter().map(|one| &one.block.name).find(|block| block.eq_ignore_ascii_case(stem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_csv_file_has_a_row_for_each_loop_with_its_name() {
        let rows = of_csv("loop;P.GAIN;P.ON;note\nTIC1;0,5;TRUE;a\nTIC2;2;FALSE;b\n").unwrap();
        assert_eq!(rows.axis.names, ["TIC1", "TIC2"]);
        assert_eq!(rows.axis.variables, ["P.GAIN", "P.ON"]);
        assert_eq!(rows.remarks, ["The column note has texts and is left out."]);
        let row = |gain, on| vec![Value::Number(gain), Value::Boolean(on)];
        assert_eq!(rows.axis.along, Along::Rows(vec![row(0.5, true), row(2.0, false)]));
        assert!(of_csv("P.GAIN,P.TI\n1,2\n3,4\n").unwrap().axis.names.is_empty());
    }

    #[test]
    fn a_table_without_variables_or_with_a_gap_is_refused() {
        let error = |text: &str| format!("{:#}", of_csv(text).unwrap_err());
        assert!(error("GAIN,TI\n1,2\n").starts_with("no column is a variable: write FMU.VARIABLE"));
        assert_eq!(error("P.GAIN,P.TI\n1,2\n,4\n"), "line 3 has no number for P.GAIN: complete it, or remove the row");
    }
}
