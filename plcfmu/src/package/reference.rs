//! Reference results: the response of a freshly built library to its block's own example, recorded through the C
//! interface, as a co-simulation master would, and packed according to the layered standard fmi-ls-ref.

use crate::package::version::Version;
use anyhow::{Context, Error, Result};
use blocks::{Characteristic, Kind, Response, Role};
use draw::response::{Recording, Sweep};
use host::instance::{Instance, Type};
use host::library::Library;
use modeldescription::Interface;
use modeldescription::{Row, Table};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// The folder prescribed by the layered standard.
const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";

/// The file that describes the reference experiment.
const DESCRIPTION: &str = "documentation/fmi-ls-ref.txt";

/// Whether the file with this path in an FMU belongs to the reference experiment.
pub fn is_file(path: &str) -> bool {
    path == DESCRIPTION || path.strip_prefix(FOLDER).is_some_and(|rest| rest.starts_with('/'))
}

/// Runs one of the block's examples with the library: one communication step for each call.
///
/// `resources` is the URI of the FMU's resources, if it needs any.
///
/// # Errors
/// The library refuses a value; the error states its reason.
pub fn record(
    library: &Library,
    interface: &Interface,
    response: &Response<String>,
    resources: Option<&str>,
) -> Result<Recording> {
    let table = &interface.table;
    let rows = &table.rows;
    let shown = table.shown(response);
    let mut instance = Instance::instantiate(library, "plcfmu", &interface.guid, resources)?;
    let failed = |error: Error| error.context("the block's response");
    instance.setup(0.0, None)?;
    instance.enter_initialization()?;
    set(&mut instance, table, response, 0).map_err(failed)?;
    instance.exit_initialization().map_err(failed)?;

    let cycle = (instance.get(Type::Real, table.cycle as u32)? * 1000.0).round() as u32;
    let values = |instance: &mut Instance| -> Result<Vec<f64>> {
        shown.iter().map(|row| instance.get(Type::from_kind(rows[*row].kind), *row as u32)).collect()
    };
    let mut recording = Recording { cycle, restart: values(&mut instance)?, calls: Vec::new(), shown: shown.clone() };
    for call in 0..response.calls {
        if call > 0 {
            set(&mut instance, table, response, call).map_err(failed)?;
        }
        instance.step(recording.time(call as usize), recording.time(1)).map_err(failed)?;
        recording.calls.push(values(&mut instance)?);
    }
    instance.terminate()?;
    Ok(recording)
}

/// Sets the example's values for a call.
fn set(instance: &mut Instance, table: &Table, response: &Response<String>, call: u32) -> Result<()> {
    for (_, name, value) in response.set.iter().filter(|(before, ..)| *before == call) {
        let row = table.find(name).with_context(|| format!("{} has no variable {name}", table.name))?;
        instance
            .set(Type::from_kind(table.rows[row].kind), row as u32, *value)
            .with_context(|| format!("{name} = {value:?} before call {call}"))?;
    }
    Ok(())
}

/// Runs one of the block's characteristics with the library: a new instance for each point.
///
/// # Errors
/// The library refuses a value; the error states its reason.
pub fn sweep(library: &Library, interface: &Interface, characteristic: &Characteristic<String>) -> Result<Sweep> {
    let (table, (from, to)) = (&interface.table, characteristic.range);
    let last = f64::from(characteristic.points - 1);
    let over: Vec<f64> = (0..characteristic.points).map(|point| from + (to - from) * f64::from(point) / last).collect();
    let mut means: Vec<(usize, Vec<f64>)> =
        characteristic.show.iter().filter_map(|name| table.find(name)).map(|row| (row, Vec::new())).collect();
    for value in &over {
        let set = characteristic.set.iter().map(|(name, value)| (0, name.clone(), *value));
        let response = Response {
            title: characteristic.title.clone(),
            calls: characteristic.calls,
            set: set.chain([(0, characteristic.variable.clone(), *value)]).collect(),
            show: characteristic.show.clone(),
        };
        let recording = record(library, interface, &response, None)?;
        for (column, (_, means)) in means.iter_mut().enumerate() {
            let sum: f64 = recording.calls.iter().map(|values| values[column]).sum();
            means.push(sum / f64::from(characteristic.calls));
        }
    }
    Ok(Sweep { over, means })
}

/// The recordings of a library.
#[derive(Clone, Debug, PartialEq)]
pub struct Recordings {
    /// One for each response of the table; the first is the reference.
    pub responses: Vec<Recording>,
    /// One for each characteristic.
    pub characteristics: Vec<Sweep>,
}

/// The files of the layered standard, by path in the FMU.
///
/// `version` determines the types of the values and the names of the variables.
pub fn files(table: &Table, recording: &Recording, version: Version) -> BTreeMap<String, Vec<u8>> {
    let name = &table.name;
    let mut files = BTreeMap::new();
    let mut add = |path: String, text: String| files.insert(path, text.into_bytes());
    add(format!("{FOLDER}/fmi-ls-manifest.xml"), manifest(name));
    add(format!("{FOLDER}/{name}_in.csv"), input(table, recording, version));
    add(format!("{FOLDER}/{name}_out.csv"), output(table, recording, version));
    add(DESCRIPTION.into(), description(table, recording, version));
    files
}

fn manifest(name: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
    fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref"
    fmi-ls:fmi-ls-version="1.0.0-alpha.1"
    fmi-ls:fmi-ls-description="Layered Standard providing information on related files included in an FMU.">
  <Related type="text/plain" source="../../documentation/fmi-ls-ref.txt" role="document" description="Description of the reference experiment"/>
  <Related type="text/csv" source="{name}_in.csv" role="testcase" description="Input of the reference experiment"/>
  <Related type="text/csv" source="{name}_out.csv" role="result" description="Output of the reference experiment"/>
</fmiReferences>
"#
    )
}

/// The inputs and the settings that the example changes: a row whenever a value changes.
///
/// They change half a CYCLE before the call that first uses them, so that rounding of a tool's communication points
/// cannot move them to another call. Each change has two rows with the same time, for tools that interpolate between
/// rows.
fn input(table: &Table, recording: &Recording, version: Version) -> String {
    let rows = &table.rows;
    let is_tuned =
        |row: &Row| row.role == Role::Parameter && table.responses[0].set.iter().any(|(_, name, _)| *name == row.name);
    let columns: Vec<usize> =
        (0..rows.len()).filter(|row| rows[*row].role == Role::Input || is_tuned(&rows[*row])).collect();
    let mut values: Vec<f64> = columns.iter().map(|row| rows[*row].start()).collect();
    let mut csv = header(table, &columns, version);
    let end = recording.time(recording.calls.len());
    let mut calls: Vec<u32> = table.responses[0].set.iter().map(|(call, ..)| *call).chain([0]).collect();
    calls.sort_unstable();
    calls.dedup();
    for call in calls {
        let time = (recording.time(call as usize) - recording.time(1) / 2.0).max(0.0);
        if call > 0 {
            line(&mut csv, table, &columns, version, time, &values);
        }
        for (_, name, value) in table.responses[0].set.iter().filter(|(before, ..)| *before == call) {
            for (column, row) in columns.iter().enumerate() {
                if rows[*row].name == *name {
                    values[column] = *value;
                }
            }
        }
        line(&mut csv, table, &columns, version, time, &values);
    }
    line(&mut csv, table, &columns, version, end, &values);
    csv
}

/// The outputs of the block at every communication point: after the restart, then after each step.
fn output(table: &Table, recording: &Recording, version: Version) -> String {
    let is_computed = |row: usize| matches!(table.rows[row].role, Role::Output | Role::Local);
    let columns: Vec<usize> = recording.shown.iter().copied().filter(|row| is_computed(*row)).collect();
    let mut csv = header(table, &columns, version);
    for (point, values) in std::iter::once(&recording.restart).chain(&recording.calls).enumerate() {
        let computed = recording.shown.iter().zip(values).filter(|(row, _)| is_computed(**row));
        let values: Vec<f64> = computed.map(|(_, value)| *value).collect();
        line(&mut csv, table, &columns, version, recording.time(point), &values);
    }
    csv
}

fn header(table: &Table, columns: &[usize], version: Version) -> String {
    let names = columns.iter().map(|row| format!(",{}", version.names.convert(&table.rows[*row].name)));
    format!("time{}\n", names.collect::<String>())
}

/// Writes numbers that read back bit-identical; Booleans as 0 and 1, which every reader accepts.
fn line(csv: &mut String, table: &Table, columns: &[usize], version: Version, time: f64, values: &[f64]) {
    let _ = write!(csv, "{time:?}");
    for (row, value) in columns.iter().zip(values) {
        let row = &table.rows[*row];
        let value = version.value(row, *value);
        let _ = if version.is_whole(row.kind) { write!(csv, ",{value}") } else { write!(csv, ",{value:?}") };
    }
    csv.push('\n');
}

/// A value in the form that a simulator's command line expects for its type: `0.5`, `20`, `true`.
fn start_value(row: &Row, value: f64, version: Version) -> String {
    match version.value(row, value) {
        value if row.kind == Kind::Bool => (value != 0.0).to_string(),
        value if version.is_whole(row.kind) => value.to_string(),
        value => format!("{value:?}"),
    }
}

fn description(table: &Table, recording: &Recording, version: Version) -> String {
    let name = &table.name;
    let (calls, cycle) = (recording.calls.len(), recording.time(1));
    let mut text = format!(
        "Reference results of {name}\n\n{title}\n\n{FOLDER}/{name}_in.csv\n  the inputs, held from row to row; they \
         change half a communication step before the call that first uses them\n{FOLDER}/{name}_out.csv\n  the outputs \
         after the initialization (first row) and after each communication step\n\nStart time 0 s, stop time {stop:?} s, \
         communication step {cycle:?} s: {calls} steps, one call of the block in each.\n",
        title = table.responses[0].title,
        stop = recording.time(calls),
    );
    for (_, variable, value) in table.responses[0].set.iter().filter(|(before, ..)| *before == 0) {
        let row = table.find(variable).map(|row| &table.rows[row]);
        if let Some(row) = row.filter(|row| row.role != Role::Input) {
            let _ = writeln!(
                text,
                "Set before the initialization ends: {} = {}",
                version.names.convert(variable),
                start_value(row, *value, version)
            );
        }
    }
    text.push_str(
        "\nRecorded from the library in this FMU. A block that uses only + - * / and sqrt, or the crate libm, returns the \
         same numbers to the last bit on every platform.\n",
    );
    text
}

/// Links to the contents of [`files`], for the documentation page, relative to `documentation/`.
pub fn links(name: &str) -> [(String, &'static str); 2] {
    [(format!("../{FOLDER}/{name}_in.csv"), "inputs"), (format!("../{FOLDER}/{name}_out.csv"), "recorded results")]
}

/// Loads the library and records everything that its documentation shows.
///
/// # Errors
/// As for [`record`].
pub fn run(library: &Path, interface: &Interface) -> Result<Recordings> {
    let (library, table) = (&Library::open(library)?, &interface.table);
    Ok(Recordings {
        responses: table.responses.iter().map(|one| record(library, interface, one, None)).collect::<Result<_>>()?,
        characteristics: table
            .characteristics
            .iter()
            .map(|one| sweep(library, interface, one))
            .collect::<Result<_>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let json = r#"{"name":"PUMP","docs":"x","cycle":2,"variables":[
            {"name":"ON","description":"x","kind":"BOOL","role":"input","start":0.0,"min":null,"max":null,"unit":null},
            {"name":"GAIN","description":"x","kind":"REAL","role":"parameter","start":2.0,"min":null,"max":null,"unit":null},
            {"name":"CYCLE","description":"x","kind":"TIME","role":"cycle","start":1.0,"min":0.001,"max":null,"unit":null},
            {"name":"SPEED","description":"x","kind":"INT","role":"parameter","start":7.0,"min":null,"max":null,"unit":null},
            {"name":"STEPS","description":"x","kind":"INT","role":"fixed","start":7.0,"min":null,"max":null,"unit":null},
            {"name":"LOCKED","description":"x","kind":"BOOL","role":"fixed","start":0.0,"min":null,"max":null,"unit":null},
            {"name":"Q","description":"x","kind":"BOOL","role":"output","start":0.0,"min":null,"max":null,"unit":null},
            {"name":"LEVEL","description":"x","kind":"LREAL","role":"output","start":0.0,"min":null,"max":null,"unit":"m"}],
            "responses":[{"title":"It runs","calls":3,
            "set":[[0,"GAIN",0.5],[0,"CYCLE",0.1],[0,"STEPS",20.0],[0,"LOCKED",1.0],[2,"ON",1.0]],
            "show":["ON","LEVEL","Q"]}]}"#;
        modeldescription::read_table(json).unwrap()
    }

    fn recording() -> Recording {
        Recording {
            cycle: 100,
            shown: vec![0, 7, 6],
            restart: vec![0.0, 0.0, 0.0],
            calls: vec![vec![0.0, 0.1, 0.0], vec![0.0, 1e-7, 0.0], vec![1.0, 0.30000000000000004, 1.0]],
        }
    }

    fn file(name: &str) -> String {
        String::from_utf8(files(&table(), &recording(), Version::default()).remove(name).unwrap()).unwrap()
    }

    #[test]
    fn inputs_change_half_a_cycle_before_the_call_that_first_sees_them() {
        // Call 2 is at 0.2 s. GAIN is tuned, SPEED is not, CYCLE cannot be changed while it runs.
        assert_eq!(
            file("extra/org.fmi-standard.fmi-ls-ref/PUMP_in.csv"),
            "time,ON,GAIN\n0.0,0,0.5\n0.15000000000000002,0,0.5\n0.15000000000000002,1,0.5\n0.3,1,0.5\n"
        );
    }

    #[test]
    fn results_are_those_at_each_communication_point_and_read_back_bit_equal() {
        assert_eq!(
            file("extra/org.fmi-standard.fmi-ls-ref/PUMP_out.csv"),
            "time,LEVEL,Q\n0.0,0.0,0\n0.1,0.1,0\n0.2,1e-7,0\n0.3,0.30000000000000004,1\n"
        );
    }

    #[test]
    fn the_manifest_names_the_files() {
        let manifest = file("extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml");
        assert!(manifest.contains(r#"fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref""#));
        assert!(manifest.contains(r#"source="PUMP_in.csv" role="testcase""#));
        assert!(manifest.contains(r#"source="PUMP_out.csv" role="result""#));
        assert!(manifest.contains(r#"source="../../documentation/fmi-ls-ref.txt""#));
    }

    #[test]
    fn the_experiment_is_described() {
        let text = file("documentation/fmi-ls-ref.txt");
        assert!(text.contains("stop time 0.3 s, communication step 0.1 s: 3 steps"));
        assert!(text.contains("Set before the initialization ends: GAIN = 0.5\n"));
        assert!(text.contains("Set before the initialization ends: CYCLE = 0.1\n"));
        assert!(text.contains("Set before the initialization ends: STEPS = 20\n"));
        assert!(text.contains("Set before the initialization ends: LOCKED = true\n"));
        assert!(!text.contains("ON = "));
    }
}
