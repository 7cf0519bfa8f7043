//! Writes and reads the results of a study as a table with one row per run, as Parquet or CSV. The same results yield
//! the same bytes.
//!
//! The columns are `run`, `loop` if the study has a table of named loops, the coordinates of the run's point, its
//! figures, and `error`. A missing figure is null in Parquet and an empty field in CSV; true is 1.

use crate::results::{Loops, Quantity, Results, RunResult};
use anyhow::{Context, Result, bail};
use host::package::temporary;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::RowAccessor;
use parquet::schema::types::{PrimitiveTypeBuilder, Type, TypePtr};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The number of rows in a Parquet row group.
const ROW_GROUP: u64 = 1 << 17;

/// The number of CSV lines written at a time, for which a piece of each column is read.
const LINES: usize = 1 << 12;

/// The name of the column with loop names, distinct from those of coordinates, which contain a dot.
const LOOP: &str = "loop";

/// The format of the table.
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Apache Parquet
    #[default]
    Parquet,
    /// Comma-separated values
    Csv,
}

impl Format {
    /// The path of the table in the results folder.
    pub fn file(self, folder: &Path) -> PathBuf {
        folder.join(match self {
            Format::Parquet => "runs.parquet",
            Format::Csv => "runs.csv",
        })
    }
}

/// Writes the table at `path`, via a temporary file in the same folder that is then renamed.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, format: Format, results: &Results) -> Result<()> {
    match format {
        Format::Parquet => temporary::place(path, |to| write_parquet(to, results), |_| Ok(())),
        Format::Csv => temporary::place(path, |to| write_csv(to, results), |_| Ok(())),
    }
}

/// Writes CSV (RFC 4180) with a header. A number is printed as the shortest text that reads back bit-equal.
///
/// # Errors
/// Writing to `to` fails.
pub fn write_csv(to: &mut impl Write, results: &Results) -> Result<()> {
    let mut to = csv::Writer::from_writer(to);
    let names = results.coordinates.iter().chain(&results.figures).map(|of| of.name.as_str());
    to.write_record(["run"].into_iter().chain(results.loops.iter().map(|_| LOOP)).chain(names).chain(["error"]))?;
    for first in (0..results.count()).step_by(LINES) {
        let runs = first..(first + LINES as u64).min(results.count());
        let columns = (0..results.width()).map(|column| results.column(column, runs.clone()));
        let columns = columns.collect::<Result<Vec<_>>>()?;
        for (place, run) in runs.enumerate() {
            to.write_field(run.to_string())?;
            if let Some(loops) = &results.loops {
                to.write_field(loops.name(run))?;
            }
            for (number, column) in columns.iter().enumerate() {
                let value = column[place];
                let is_missing = number >= results.coordinates.len() && value.is_nan();
                to.write_field(if is_missing { String::new() } else { format!("{value:?}") })?;
            }
            to.write_field(results.errors.get(&run).map_or("", String::as_str))?;
            to.write_record(None::<&[u8]>)?;
        }
    }
    Ok(to.flush()?)
}

/// A callback for the next row of a table.
pub type Take<'a> = dyn FnMut(RunResult) -> Result<()> + 'a;

/// Reads a table written by [`write()`], with this many coordinates and figures, row by row.
///
/// # Errors
/// The file cannot be read or is damaged, or `each` fails.
pub fn read(path: &Path, format: Format, coordinates: usize, figures: usize, each: &mut Take) -> Result<()> {
    let shown = || path.display().to_string();
    let file = File::open(path).with_context(shown)?;
    let read = match format {
        Format::Parquet => read_parquet(file, coordinates, figures, each),
        Format::Csv => read_csv(file, coordinates, figures, each),
    };
    read.with_context(shown)
}

fn read_csv(from: File, coordinates: usize, figures: usize, each: &mut Take) -> Result<()> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(from);
    let leading = if reader.headers()?.get(1) == Some(LOOP) { 2 } else { 1 } + coordinates;
    let number = |field: &str| if field.is_empty() { Some(f64::NAN) } else { field.parse().ok() };
    let row = |record: &csv::StringRecord| -> Option<RunResult> {
        let error = record.get(leading + figures).filter(|_| record.len() == leading + figures + 1)?;
        let figures = record.iter().skip(leading).take(figures).map(number).collect::<Option<_>>()?;
        Some(RunResult { figures, error: Some(error.to_string()).filter(|error| !error.is_empty()) })
    };
    for record in reader.records() {
        let record = record?;
        let line = || format!("line {} is damaged", record.position().map_or(0, csv::Position::line));
        each(row(&record).with_context(line)?)?;
    }
    Ok(())
}

fn read_parquet(from: File, coordinates: usize, figures: usize, each: &mut Take) -> Result<()> {
    let reader = SerializedFileReader::new(from)?;
    // The number of columns before the coordinates: the run number and, for a table of loops, the name.
    let columns = reader.metadata().file_metadata().schema_descr().columns();
    let leading = if columns.get(1).is_some_and(|column| column.name() == LOOP) { 2 } else { 1 };
    let row = |row: &parquet::record::Row| RunResult {
        // Null represents NaN.
        figures: (0..figures)
            .map(|figure| row.get_double(leading + coordinates + figure).unwrap_or(f64::NAN))
            .collect(),
        error: row.get_string(leading + coordinates + figures).ok().cloned(),
    };
    for read in reader.get_row_iter(None)? {
        each(row(&read?))?;
    }
    Ok(())
}

/// Writes uncompressed Parquet. The metadata key `units` is a JSON object with the unit of each column that has one.
///
/// # Errors
/// Writing to `to` fails.
pub fn write_parquet(to: &mut (impl Write + Send), results: &Results) -> Result<()> {
    let quantities = results.coordinates.iter().chain(&results.figures);
    let units: BTreeMap<_, _> = quantities.filter_map(|of| Some((&of.name, of.unit.as_ref()?))).collect();
    let units = KeyValue::new("units".into(), serde_json::to_string(&units)?);
    let properties = WriterProperties::builder()
        .set_created_by(concat!("plcfmu ", env!("CARGO_PKG_VERSION")).into())
        .set_key_value_metadata(Some(vec![units]))
        .build();
    let mut writer = SerializedFileWriter::new(to, schema(results)?, Arc::new(properties))?;
    let mut first = 0;
    while first < results.count() {
        let runs = first..(first + ROW_GROUP).min(results.count());
        first = runs.end;
        let mut group = writer.next_row_group()?;
        for place in 0.. {
            let Some(mut column) = group.next_column()? else { break };
            match (&results.loops, place) {
                (Some(loops), 1) => write_loops(column.untyped(), loops, runs.clone())?,
                (Some(_), 2..) => write_column(column.untyped(), place - 1, results, runs.clone())?,
                _ => write_column(column.untyped(), place, results, runs.clone())?,
            }
            column.close()?;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}

fn schema(results: &Results) -> Result<TypePtr> {
    fn column(name: &str, physical: Physical, repetition: Repetition) -> PrimitiveTypeBuilder<'_> {
        Type::primitive_type_builder(name, physical).with_repetition(repetition)
    }
    let mut columns = vec![column("run", Physical::INT64, Repetition::REQUIRED).build()?];
    if results.loops.is_some() {
        let name = column(LOOP, Physical::BYTE_ARRAY, Repetition::REQUIRED);
        columns.push(name.with_logical_type(Some(LogicalType::String)).build()?);
    }
    for Quantity { name, .. } in &results.coordinates {
        columns.push(column(name, Physical::DOUBLE, Repetition::REQUIRED).build()?);
    }
    for Quantity { name, .. } in &results.figures {
        columns.push(column(name, Physical::DOUBLE, Repetition::OPTIONAL).build()?);
    }
    let error = column("error", Physical::BYTE_ARRAY, Repetition::OPTIONAL);
    columns.push(error.with_logical_type(Some(LogicalType::String)).build()?);
    let columns = columns.into_iter().map(Arc::new).collect();
    Ok(Arc::new(Type::group_type_builder("runs").with_fields(columns).build()?))
}

/// Writes a range of rows of the column with loop names.
fn write_loops(to: &mut ColumnWriter, loops: &Loops, runs: Range<u64>) -> Result<()> {
    let ColumnWriter::ByteArrayColumnWriter(to) = to else { bail!("the schema has different columns") };
    let names: Vec<ByteArray> = runs.map(|run| ByteArray::from(loops.name(run))).collect();
    to.write_batch(&names, None, None)?;
    Ok(())
}

/// Writes a range of rows of column `place`, not counting the column with loop names.
fn write_column(to: &mut ColumnWriter, place: usize, results: &Results, runs: Range<u64>) -> Result<()> {
    let coordinates = results.coordinates.len();
    // Parquet expects the definition levels, which mark null values, and the values that are not null.
    match to {
        ColumnWriter::Int64ColumnWriter(to) => {
            let numbers = runs.map(i64::try_from).collect::<Result<Vec<_>, _>>()?;
            to.write_batch(&numbers, None, None)?;
        }
        ColumnWriter::DoubleColumnWriter(to) if place <= coordinates => {
            to.write_batch(&results.column(place - 1, runs)?, None, None)?;
        }
        ColumnWriter::DoubleColumnWriter(to) => {
            let values = results.column(place - 1, runs)?;
            let is_there: Vec<i16> = values.iter().map(|value| i16::from(!value.is_nan())).collect();
            let values: Vec<f64> = values.iter().copied().filter(|value| !value.is_nan()).collect();
            to.write_batch(&values, Some(&is_there), None)?;
        }
        ColumnWriter::ByteArrayColumnWriter(to) => {
            let errors: Vec<_> = runs.map(|run| results.errors.get(&run)).collect();
            let is_there: Vec<i16> = errors.iter().map(|error| i16::from(error.is_some())).collect();
            let errors: Vec<ByteArray> =
                errors.into_iter().flatten().map(|error| ByteArray::from(error.as_str())).collect();
            to.write_batch(&errors, Some(&is_there), None)?;
        }
        _ => return Err(anyhow::anyhow!("the schema has different columns")).context("runs.parquet"),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn results() -> Results {
        let quantity = Quantity::new;
        let mut results = Results::new(
            vec![quantity("C.GAIN", None), quantity("P.LAG", Some("s"))],
            vec![quantity("rise", Some("s")), quantity("overshoot", Some("%"))],
        );
        results.push(&[0.1, 30.0], &RunResult { figures: vec![1.0 / 3.0, f64::NAN], error: None }).unwrap();
        let error = Some("P: \"dry\", twice".into());
        results.push(&[1e-300, -0.0], &RunResult { figures: vec![f64::NAN, f64::NAN], error }).unwrap();
        results.push(&[2.0, 5.0], &RunResult { figures: vec![f64::INFINITY, 4.0], error: None }).unwrap();
        results
    }

    #[test]
    fn csv_has_the_shortest_numbers_and_empty_fields() {
        let mut csv = Vec::new();
        write_csv(&mut csv, &results()).unwrap();
        assert_eq!(
            String::from_utf8(csv).unwrap(),
            "run,C.GAIN,P.LAG,rise,overshoot,error\n\
             0,0.1,30.0,0.3333333333333333,,\n\
             1,1e-300,-0.0,,,\"P: \"\"dry\"\", twice\"\n\
             2,2.0,5.0,inf,4.0,\n"
        );
    }

    #[test]
    fn parquet_reads_back_with_the_values_of_the_csv() {
        let (mut csv, mut bytes) = (Vec::new(), Vec::new());
        write_csv(&mut csv, &results()).unwrap();
        write_parquet(&mut bytes, &results()).unwrap();
        let mut again = Vec::new();
        write_parquet(&mut again, &results()).unwrap();
        assert_eq!(bytes, again, "the bytes are the same");

        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let metadata = reader.metadata().file_metadata().key_value_metadata().unwrap();
        assert_eq!(metadata[0].value.as_deref(), Some(r#"{"P.LAG":"s","overshoot":"%","rise":"s"}"#));
        let mut read = results();
        read = Results::new(read.coordinates, read.figures);
        for (run, row) in reader.get_row_iter(None).unwrap().enumerate() {
            let row = row.unwrap();
            assert_eq!(row.get_long(0).unwrap(), run as i64);
            let value = |column| row.get_double(column).unwrap_or(f64::NAN);
            let error = row.get_string(5).ok().cloned();
            read.push(&[value(1), value(2)], &RunResult { figures: vec![value(3), value(4)], error }).unwrap();
        }
        let mut from_parquet = Vec::new();
        write_csv(&mut from_parquet, &read).unwrap();
        assert_eq!(from_parquet, csv);
    }

    /// The same results for two loops, the first with a comma and quotation marks in its name.
    fn of_loops() -> Results {
        let names = vec!["TIC \"1\", left".into(), "TIC2".into()];
        let mut results = results();
        results.loops = Some(Loops { names, runs: 2 });
        results
    }

    #[test]
    fn a_table_of_loops_has_their_names_beside_the_runs() {
        let mut csv = Vec::new();
        write_csv(&mut csv, &of_loops()).unwrap();
        let csv = String::from_utf8(csv).unwrap();
        let starts =
            |line: &str| line.split(",").take(if line.contains('"') { 3 } else { 2 }).collect::<Vec<_>>().join(",");
        let expected = ["run,loop", "0,\"TIC \"\"1\"\", left\"", "1,\"TIC \"\"1\"\", left\"", "2,TIC2"];
        assert_eq!(csv.lines().map(starts).collect::<Vec<_>>(), expected);
        let mut bytes = Vec::new();
        write_parquet(&mut bytes, &of_loops()).unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let rows = reader.get_row_iter(None).unwrap().map(|row| row.unwrap());
        let names: Vec<String> = rows.map(|row| row.get_string(1).unwrap().clone()).collect();
        assert_eq!(names, ["TIC \"1\", left", "TIC \"1\", left", "TIC2"]);
    }

    #[test]
    fn both_formats_read_back_with_the_rows_that_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let cases = [Format::Parquet, Format::Csv].map(|format| [(format, results()), (format, of_loops())]);
        for (format, results) in cases.into_iter().flatten() {
            let path = format.file(folder.path());
            write(&path, format, &results).unwrap();
            let mut read_back = Results::new(results.coordinates.clone(), results.figures.clone());
            read_back.loops = results.loops.clone();
            let mut each = |row: RunResult| read_back.push(&results.point(read_back.count())?, &row);
            read(&path, format, 2, 2, &mut each).unwrap();
            let csv = |results: &Results| {
                let mut csv = Vec::new();
                write_csv(&mut csv, results).unwrap();
                String::from_utf8(csv).unwrap()
            };
            assert_eq!(csv(&read_back), csv(&results), "{format:?}");
        }
    }
}
