//! Reads a table with one row per loop: a CSV or Parquet file with variables as columns, or a PLC parameter file with
//! several loops.
//!
//! Every value in a column named after a variable must be a number: one that cannot be read is reported with its
//! location, never skipped.

mod parquet;

use crate::{Along, Axis};
use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use control::csv;
use host::package::Package;
use modeldescription::Description;
use parameters::{BlockType, Format, Loop, Options, Origin};
use run::file::{ReadParameters, remarks};
use run::system::{Setting, System, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rows of a file, converted to an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// The path of the file.
    pub path: PathBuf,
    /// The variables, their values in each row, and the names of the loops, if the file has them.
    pub axis: Axis,
    /// The contents of the parameter file, if the rows were read from one.
    pub source: Option<Source>,
    /// Remarks about the file for the user.
    pub remarks: Vec<String>,
}

/// The contents of a parameter file.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The name of the FMU that receives the values.
    pub fmu: String,
    /// The loops, one for each row.
    pub loops: Vec<Loop>,
}

/// The contents of a CSV or Parquet file.
#[derive(Debug, Default)]
struct Given {
    /// The variables, each with its 1-based column number.
    variables: Vec<(String, usize)>,
    /// For each row, a value for each variable.
    rows: Vec<Vec<Value>>,
    /// The name of each row's loop; empty if there are no names.
    names: Vec<String>,
    /// The location of each row.
    places: Vec<String>,
    remarks: Vec<String>,
}

/// Reads the rows of a file. `fmu` names the FMU that receives the values of a parameter file; by default, the first
/// one. Values for the variables in `fixed` or for connected inputs are ignored.
///
/// # Errors
/// The file cannot be read or is not a table; the message names the remedy.
pub fn read(
    path: &Path,
    fmu: Option<&str>,
    system: &System,
    fixed: &[String],
    parameters: ReadParameters,
) -> Result<Rows> {
    let shown = path.display().to_string();
    let of_columns = |given: Given| {
        ensure!(fmu.is_none(), "{shown}: the column names already name the FMUs: omit `fmu`");
        given.rows(&shown)
    };
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase).as_deref() {
        Some("csv" | "txt" | "tsv") => {
            let text = fs::read_to_string(path).with_context(|| format!("{shown} cannot be read as text"))?;
            of_columns(of_csv(&shown, &text)?)
        }
        Some("parquet") => of_columns(parquet::read(path, &shown)?),
        _ if Format::of_file(&shown).is_some() => of_parameters(path, fmu, system, fixed, parameters),
        _ => bail!("{shown} is neither a CSV or Parquet file nor a PLC parameter file, judging by its extension"),
    }
}

impl Given {
    /// Converts the rows to an axis; errors name the file `shown`.
    fn rows(self, shown: &str) -> Result<Rows> {
        let Given { variables, rows, names, places, remarks } = self;
        ensure!(
            !variables.is_empty(),
            "{shown}: no column contains a variable: use column names FMU.VARIABLE, such as PUMP.SPEED"
        );
        ensure!(!rows.is_empty(), "{shown}: the file has no rows: add a row for each loop");
        let mut columns = BTreeMap::new();
        for (name, number) in &variables {
            if let Some(before) = columns.insert(name, number) {
                bail!("{shown}: the columns {before} and {number} are both {name}: remove one of them");
            }
        }
        let mut known = BTreeMap::new();
        for (name, place) in names.iter().zip(&places) {
            if let Some(before) = known.insert(name, place) {
                bail!("{place}: {name:?} is also the name of the loop at {before}: give each loop a unique name");
            }
        }
        let variables = variables.into_iter().map(|(name, _)| name).collect();
        let axis = Axis { variables, names, along: Along::Rows(rows), ..Axis::default() };
        Ok(Rows { path: shown.into(), axis, source: None, remarks })
    }
}

/// Reads CSV text; errors name the file `shown`.
fn of_csv(shown: &str, text: &str) -> Result<Given> {
    let placed = |error: Error| match error.downcast_ref::<csv::Fault>() {
        Some(fault) => anyhow!("{}", fault.in_file(shown)),
        None => error.context(shown.to_string()),
    };
    let table = csv::CsvTable::of_loops(text).map_err(placed)?;
    let names = csv::loop_names(text)?.unwrap_or_default();
    let columns: Vec<&csv::Column> = table.columns.iter().filter(|column| column.name.contains('.')).collect();
    let value = |column: &&csv::Column, row: usize| match column.values[row] {
        value if value.is_finite() && column.is_boolean => Ok(Value::Boolean(value != 0.0)),
        value if value.is_finite() => Ok(Value::Number(value)),
        _ => Err(anyhow!(
            "{shown}:{}:{}: {}: missing number: complete the row, or remove it",
            table.lines[row],
            column.number,
            column.name
        )),
    };
    let rows = 0..table.rows();
    let rows = rows.map(|row| columns.iter().map(|column| value(column, row)).collect::<Result<Vec<_>>>());
    Ok(Given {
        variables: columns.iter().map(|column| (column.name.clone(), column.number)).collect(),
        rows: rows.collect::<Result<_>>()?,
        names,
        places: table.lines.iter().map(|line| format!("{shown}:{line}:1")).collect(),
        remarks: table.remarks,
    })
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
    ensure!(names.contains(&fmu), "fmu = {fmu:?}: no such FMU in the loop; available: {}", names.join(", "));
    let reading = parameters(&shown, &Options::default())?;
    ensure!(!reading.loops.is_empty(), "{shown} has no loops: use another file");
    let block = of_fmu(system, fmu, &reading.loops);
    let (loops, others): (Vec<Loop>, Vec<Loop>) =
        reading.loops.iter().cloned().partition(|one| Some(&one.block.name) == block.as_ref());
    let blocks: BTreeSet<&str> = others.iter().map(|one| one.block.name.as_str()).collect();
    let blocks = blocks.into_iter().collect::<Vec<_>>().join(", ");
    let Some(first) = loops.first() else {
        bail!(
            "{shown} has loops of {blocks}, but none for the FMU {fmu}: specify the FMU of these loops with fmu = \
             \"NAME\", or use another file"
        )
    };
    let mut remarks = remarks(&reading);
    if !others.is_empty() {
        let (count, are) = (others.len(), if others.len() == 1 { "loop of {} is" } else { "loops of {} are" });
        remarks.push(format!(
            "{shown}: {count} {} left out: the FMU {fmu} contains the block {}",
            are.replace("{}", &blocks),
            first.block.name
        ));
    }
    let mut known = BTreeSet::new();
    if let Some(twice) = loops.iter().find(|one| !known.insert(&one.name)) {
        bail!("{shown}: two loops are named {}: give each a unique name", twice.name);
    }
    let is_given = |member: usize| loops.iter().any(|one| one.settings[member].origin != Origin::Default);
    let is_free = |of: &Setting| {
        !fixed.contains(&of.variable) && !system.connections.iter().any(|connection| connection.to == of.variable)
    };
    let settings = |one: &Loop| Setting::of_loop(one, fmu, None);
    let all = settings(first);
    let kept: Vec<usize> = (0..all.len()).filter(|member| is_given(*member) && is_free(&all[*member])).collect();
    ensure!(
        !kept.is_empty(),
        "{shown} adds no values: the study or a connection already sets them all; use another file"
    );
    let row = |one: &Loop| {
        let all = settings(one);
        kept.iter().map(|member| all[*member].value).collect()
    };
    let variables = kept.iter().map(|member| all[*member].variable.clone()).collect();
    let names = loops.iter().map(|one| one.name.clone()).collect();
    let axis = Axis { variables, names, along: Along::Rows(loops.iter().map(row).collect()), ..Axis::default() };
    Ok(Rows { path: path.into(), axis, remarks, source: Some(Source { fmu: fmu.into(), loops }) })
}

/// The block whose loops fit an FMU: the one named like the FMU's model or file, else one whose settings are all
/// variables of the FMU. `None` if there is none.
fn of_fmu(system: &System, fmu: &str, loops: &[Loop]) -> Option<String> {
    let path = &system.members.iter().find(|member| member.name == fmu)?.path;
    // Problems with an FMU are reported when it is loaded. A program has no description yet.
    let description = Package::open(path).ok().map(|package| package.description);
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    let named = [description.as_ref().and_then(Description::model_identifier), stem];
    let is_named = |block: &BlockType| named.into_iter().flatten().any(|name| block.name.eq_ignore_ascii_case(name));
    let fits = |block: &BlockType| {
        let mut settable = block.members.iter().filter(|member| member.role.is_settable());
        description.as_ref().is_some_and(|of| settable.all(|member| of.variable(&member.name).is_some()))
    };
    let mut blocks = loops.iter().map(|one| &one.block);
    let found = blocks.clone().find(|block| is_named(block)).or_else(|| blocks.find(|block| fits(block)));
    found.map(|block| block.name.clone())
}

#[cfg(test)]
mod tests;
