//! Studies: one loop, run many times with different values, in worker processes.
//!
//! A [`Job`] defines a study: a [`System`](run::system::System) and a [`Study`] of it. Its axes span the *points*, each
//! the set of values for one run. [`Experiment`](experiment::Experiment) checks the names and derives the point of
//! every run from the number of the run alone, so that the result does not depend on where, in which order or in how
//! many parts the runs are executed.
//!
//! ```text
//! study.toml --read--> Job --+                 +-- worker process (FMUs) --+
//! study.json --bundle--------+--> Pool --points+-- worker process (FMUs) --+rows--> parts --> output: runs.parquet, runs.csv
//! ```
//!
//! The main process loads no native code: a crash or an endless loop in an FMU costs one run.

mod axes;
pub mod bundle;
mod check;
mod columns;
mod correlation;
pub mod distribution;
pub mod each;
pub mod envelope;
pub mod expect;
pub mod experiment;
pub mod finished;
pub mod interval;
mod job;
pub mod junit;
mod measures;
pub mod output;
pub mod parts;
pub mod pictures;
pub mod pool;
pub mod process;
pub mod ran;
pub mod read;
pub mod report;
pub mod results;
pub mod sampling;
pub mod sobol;
pub mod summary;
pub mod table;
pub mod tune;
pub mod tuned;
pub mod tuning;
pub mod worker;

pub use job::{Along, Axis, Correlation, Job, Limit, Sampling, Signals, Study, Take, Taken, Window};

use anyhow::{Context, Result, ensure};
use host::hexadecimal;
use run::file::ReadParameters;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::error::Error;
use std::fmt;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// The job reduced to what affects its result: without the file positions of its parts and remarks on the files.
pub fn bare(job: &Job) -> Job {
    let mut job = job.clone();
    job.system.remarks.clear();
    job.system.settings.iter_mut().for_each(|of| of.place = None);
    job.system.connections.iter_mut().for_each(|of| of.place = None);
    job.system.record.iter_mut().for_each(|of| of.place = None);
    job
}

/// A SHA-256 hash, in hexadecimal, of everything that the rows of a job depend on: the job itself, the contents of its
/// FMUs and the version of this program, but not the paths of the FMUs.
///
/// # Errors
/// An FMU cannot be read.
pub fn fingerprint(job: &Job) -> Result<String> {
    #[derive(Serialize)]
    struct Content<'a> {
        version: &'a str,
        job: &'a Job,
    }
    let mut job = bare(job);
    for member in &mut job.system.members {
        member.path = PathBuf::from(hash(&member.path)?);
    }
    let content = serde_json::to_vec(&Content { version: env!("CARGO_PKG_VERSION"), job: &job })?;
    Ok(hexadecimal::digits(&Sha256::digest(content)))
}

/// The SHA-256 hash of a file in hexadecimal.
fn hash(path: &Path) -> Result<String> {
    let shown = || path.display().to_string();
    let mut digest = Sha256::new();
    io::copy(&mut File::open(path).with_context(shown)?, &mut Writer(&mut digest)).with_context(shown)?;
    Ok(hexadecimal::digits(&digest.finalize()))
}

/// A writer that hashes its input.
struct Writer<'a>(&'a mut Sha256);

impl io::Write for Writer<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The user interrupted a command; the string explains how to continue it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interrupted(pub String);

impl fmt::Display for Interrupted {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "interrupted: {}", self.0)
    }
}

impl Error for Interrupted {}

/// Opens a study by its path: a study.toml, or the study.json of a bundle.
///
/// # Errors
/// The file is faulty, or `fmus` is given for a bundle. For a study.toml, the message contains line and column.
pub fn open(path: &Path, fmus: Option<&Path>, parameters: ReadParameters) -> Result<read::Reading> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        ensure!(fmus.is_none(), "{} is a bundle, which contains its own FMUs: omit --fmus", path.display());
        return bundle::open(path);
    }
    read::read(path, fmus, parameters)
}

/// Removes the files of an older study, recognized by their names, from a folder, and the folder itself if it is then
/// empty.
///
/// # Errors
/// A file cannot be removed.
pub fn clear(folder: &Path, is_old: impl Fn(&str) -> bool) -> Result<()> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        entries => entries.with_context(|| folder.display().to_string())?,
    };
    for entry in entries {
        let path = entry?.path();
        if path.is_file() && path.file_name().and_then(|name| name.to_str()).is_some_and(&is_old) {
            fs::remove_file(&path).with_context(|| format!("{} cannot be removed", path.display()))?;
        }
    }
    // Fails if the folder also contains files of the user.
    let _ = fs::remove_dir(folder);
    Ok(())
}

/// Creates a folder and its parents.
fn make_folder(path: &Path) -> Result<()> {
    fs::create_dir_all(path).with_context(|| format!("the folder {} cannot be created", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_an_older_study_are_removed() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("pictures");
        fs::create_dir(&folder).unwrap();
        for name in ["scatter.svg", "holiday.png"] {
            fs::write(folder.join(name), name).unwrap();
        }
        clear(&folder, |name| name.starts_with("scatter")).unwrap();
        let left: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["holiday.png"]);
        clear(&folder, |_| true).unwrap();
        assert!(!folder.exists());
        clear(&folder, |_| true).unwrap();
    }
}
