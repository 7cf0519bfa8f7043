//! Parameter files of a PLC as settings of FMUs.

use crate::host::system::{Place, Setting, Value};
use anyhow::{Context, Result, bail};
use blocks::table::number::number;
use parameters::{Block, Format, Loop, Origin, Reading, Source};
use std::fs;
use std::path::Path;

/// Reads a parameter file. Its format is known by the ending of its name.
///
/// # Errors
/// The file cannot be read, or all that is wrong with it, with file, line and column.
pub fn read(path: &Path, options: &parameters::Options) -> Result<Reading> {
    let shown = path.display().to_string();
    let Some(format) = Format::of_file(&shown) else {
        let endings: Vec<_> =
            Format::ALL.iter().flat_map(|format| format.extensions()).map(|of| format!(".{of}")).collect();
        bail!("{shown} is not a parameter file: its name should end with {}", endings.join(", "));
    };
    let bytes = fs::read(path).with_context(|| format!("{shown} cannot be read"))?;
    Ok(parameters::read(format, &Source::new(shown, bytes), &Block::all(), options)?)
}

/// The values of a loop as settings of an FMU that is called `member`. A value without a line of its own is said to be at
/// `place`.
pub fn settings(of: &Loop, member: &str, place: Option<&Place>) -> Vec<Setting> {
    let setting = |setting: &parameters::Setting| {
        let place = match &setting.origin {
            Origin::Text { file, line, column } => Some(Place { file: file.clone(), line: *line, column: *column }),
            Origin::Default | Origin::Data { .. } => place.cloned(),
        };
        Setting {
            variable: format!("{member}.{}", of.block.members[setting.member].name),
            value: match setting.value {
                blocks::Value::Bool(value) => Value::Boolean(value),
                value => Value::Number(number(value)),
            },
            time: None,
            is_preliminary: true,
            place,
        }
    };
    of.settings.iter().map(setting).collect()
}

/// What the user should know of a file that was read, a sentence each.
pub fn remarks(reading: &Reading) -> Vec<String> {
    reading.remarks.to_string().lines().map(str::to_string).collect()
}
