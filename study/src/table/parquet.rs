//! Reads a table of loops from Apache Parquet.

use super::Given;
use anyhow::{Context, Result, bail, ensure};
use control::csv;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use run::system::Value;
use std::fs::File;
use std::path::Path;

/// Reads the rows of a file; errors name it `shown`.
pub(super) fn read(path: &Path, shown: &str) -> Result<Given> {
    let file = File::open(path).with_context(|| format!("{shown} cannot be read"))?;
    let reader = SerializedFileReader::new(file).with_context(|| format!("{shown} is not a Parquet file"))?;
    let schema = reader.metadata().file_metadata().schema().get_fields();
    let is_variable = |name: &str| name.contains('.');
    let all: Vec<&str> = schema.iter().map(|field| field.name()).collect();
    let variables: Vec<usize> = (0..all.len()).filter(|column| is_variable(all[*column])).collect();
    let names = all.iter().position(|name| csv::LOOP_NAMES.contains(&name.to_lowercase().as_str()));
    let mut given = Given {
        variables: variables.iter().map(|column| (all[*column].to_string(), column + 1)).collect(),
        ..Given::default()
    };
    let hint = "rewrite it with compression=\"snappy\" or without compression";
    for (row, read) in (1..).zip(reader.get_row_iter(None).with_context(|| format!("{shown}: {hint}"))?) {
        let read = read.with_context(|| format!("{shown}: row {row} cannot be read: {hint}"))?;
        let fields: Vec<(&String, &Field)> = read.get_column_iter().collect();
        ensure!(fields.len() == all.len(), "{shown}: row {row} has {} of {} columns", fields.len(), all.len());
        let place = |column: usize| format!("{shown}: row {row}, column {}", all[column]);
        let value = |column: &usize| value(fields[*column].1).with_context(|| place(*column));
        given.rows.push(variables.iter().map(value).collect::<Result<_>>()?);
        if let Some(column) = names {
            given.names.push(name(fields[column].1).with_context(|| place(column))?);
        }
        given.places.push(format!("{shown}: row {row}"));
    }
    Ok(given)
}

/// Converts a field to the value of a variable.
fn value(field: &Field) -> Result<Value> {
    let number = match field {
        Field::Bool(value) => return Ok(Value::Boolean(*value)),
        Field::Byte(value) => f64::from(*value),
        Field::Short(value) => f64::from(*value),
        Field::Int(value) => f64::from(*value),
        Field::Long(value) => *value as f64,
        Field::UByte(value) => f64::from(*value),
        Field::UShort(value) => f64::from(*value),
        Field::UInt(value) => f64::from(*value),
        Field::ULong(value) => *value as f64,
        Field::Float(value) => f64::from(*value),
        Field::Double(value) => *value,
        Field::Null => bail!("missing number: complete the row, or remove it"),
        other => bail!(
            "{other} is neither a number nor true or false: write the column as DOUBLE, FLOAT, INT32, INT64 or BOOLEAN, numbers \
             without a unit"
        ),
    };
    ensure!(number.is_finite(), "{number} is not a finite number: correct it, or remove the row");
    Ok(Value::Number(number))
}

/// Converts a field to the name of a loop.
fn name(field: &Field) -> Result<String> {
    match field {
        Field::Str(text) => Ok(text.clone()),
        Field::Bytes(bytes) => Ok(bytes.as_utf8().context("the name is not UTF-8 text: correct it")?.to_string()),
        Field::Null => bail!("missing name: complete the row, or remove it"),
        other => bail!("{other} is not a string: write loop names as strings (BYTE_ARRAY)"),
    }
}
