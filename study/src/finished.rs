//! The results of a finished study in its folder, which `--resume` reads instead of repeating the runs.

use super::hash;
use super::output::{self, Format, Take};
use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// The entry in `summary.json` about the table of runs.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq, Eq)]
pub struct RunsTable {
    /// The file name.
    pub file: String,
    /// The SHA-256 hash of the file in hexadecimal.
    pub sha256: String,
}

impl RunsTable {
    /// Finds and hashes the table in a folder.
    ///
    /// # Errors
    /// There is no such table, or it cannot be read.
    pub fn new(out: &Path, format: Format) -> Result<RunsTable> {
        let path = format.file(out);
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(RunsTable { file, sha256: hash(&path)? })
    }
}

/// The parts of `summary.json` that are needed here.
#[derive(Deserialize)]
struct Summary {
    fingerprint: String,
    table: RunsTable,
}

/// Reads the rows of a finished study one by one from its folder; returns `false` if the folder has no results.
/// `coordinates` and `figures` are the numbers of these columns in the table.
///
/// # Errors
/// The results belong to another study, or the table has changed since the study wrote it (the message names the
/// remedy), or `each` fails.
pub fn rows(out: &Path, fingerprint: &str, coordinates: usize, figures: usize, each: &mut Take) -> Result<bool> {
    const REMEDY: &str = "choose another folder with --out, or start over without --resume";
    let path = out.join("summary.json");
    if !path.exists() {
        return Ok(false);
    }
    let text = fs::read(&path).with_context(|| format!("{} cannot be read", path.display()))?;
    let Some(summary) = serde_json::from_slice::<Summary>(&text).ok().filter(|of| of.fingerprint == fingerprint) else {
        bail!(
            "{} contains the results of another study, or the study, an FMU or plcfmu has changed since; {REMEDY}",
            out.display()
        );
    };
    let mut formats = Format::value_variants().iter().copied();
    let format = formats.find(|format| format.file(out).ends_with(&summary.table.file));
    let format = format.with_context(|| format!("{} is damaged: {REMEDY}", path.display()))?;
    let table = format.file(out);
    ensure!(table.is_file(), "{} is missing: {REMEDY}", table.display());
    ensure!(
        RunsTable::new(out, format)? == summary.table,
        "{} has changed since the study wrote it: {REMEDY}",
        table.display()
    );
    output::read(&table, format, coordinates, figures, each)?;
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{Quantity, Results, RunResult};

    #[test]
    fn results_of_another_study_and_a_changed_table_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let rows = |fingerprint: &str| {
            let mut rows = Vec::new();
            let mut each = |row| {
                rows.push(row);
                Ok(())
            };
            super::rows(out, fingerprint, 1, 1, &mut each).map(|is_there| is_there.then_some(rows))
        };
        assert_eq!(rows("f").unwrap(), None);
        let quantity = |name: &str| vec![Quantity::new(name, None)];
        let mut results = Results::new(quantity("C.GAIN"), quantity("iae"));
        let row = RunResult { figures: vec![0.1], error: None };
        results.push(&[2.0], &row).unwrap();
        output::write(&Format::Csv.file(out), Format::Csv, &results).unwrap();
        let table = RunsTable::new(out, Format::Csv).unwrap();
        let summary = serde_json::json!({ "fingerprint": "f", "table": table });
        fs::write(out.join("summary.json"), summary.to_string()).unwrap();
        assert_eq!(rows("f").unwrap(), Some(vec![row]));

        let error = |fingerprint: &str| rows(fingerprint).unwrap_err().to_string();
        assert!(error("g").contains("contains the results of another study"), "{}", error("g"));
        fs::write(Format::Csv.file(out), "run,C.GAIN,iae,error\n0,2.0,0.2,\n").unwrap();
        assert!(error("f").contains("runs.csv has changed since the study wrote it"), "{}", error("f"));
        fs::remove_file(Format::Csv.file(out)).unwrap();
        assert!(error("f").contains("runs.csv is missing"), "{}", error("f"));
    }
}
