//! The rows of a study while it is under way, in files: what is in a part is not run again.
//!
//! A part is one file with the rows of runs that follow each other: a line of text, a header as JSON in a second line, the
//! rows in the format of postcard, and the SHA-256 of all that. Anyone can make parts of a study, on any machine; those of
//! one folder may overlap.

use crate::results::Row;
use anyhow::{Context, Result, bail, ensure};
use host::package::temporary;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What a part begins with.
const MAGIC: &[u8] = b"plcfmu part 1\n";

/// A SHA-256 in bytes.
const HASH: usize = 32;

/// This many rows a part has at most.
const MOST_ROWS: usize = 1 << 18;

/// A part is written after so much time at the latest, and in a long study after this share of its time.
const LATEST: (Duration, u32) = (Duration::from_secs(1), 100);

/// What a part says of itself.
#[derive(Debug, Deserialize, Serialize, PartialEq)]
struct Header {
    /// That of the job, see [`super::fingerprint`].
    fingerprint: String,
    /// The first run.
    first: u64,
    /// The run after the last.
    end: u64,
}

/// Writes a part beside its place, and renames it.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, fingerprint: &str, first: u64, rows: &[Row]) -> Result<()> {
    let header = Header { fingerprint: fingerprint.into(), first, end: first + rows.len() as u64 };
    let mut bytes = MAGIC.to_vec();
    serde_json::to_writer(&mut bytes, &header)?;
    bytes.push(b'\n');
    let mut bytes = postcard::to_extend(rows, bytes)?;
    let hash = Sha256::digest(&bytes);
    bytes.extend_from_slice(&hash);
    temporary::place(path, |to| Ok(to.write_all(&bytes)?), |_| Ok(()))
}

/// The content of a part: which runs, and their rows.
///
/// # Errors
/// It is damaged, or of another study; what to do.
pub fn read(path: &Path, fingerprint: &str) -> Result<(Range<u64>, Vec<Row>)> {
    let shown = path.display();
    let bytes = fs::read(path).with_context(|| format!("{shown} cannot be read"))?;
    let damaged = || format!("{shown} is damaged: delete it, and its runs are made again");
    let content = bytes.strip_prefix(MAGIC).with_context(|| {
        format!("{shown} is not a part of a study of this version of plcfmu: name another folder with --out, or omit --resume")
    })?;
    ensure!(
        content.len() > HASH && Sha256::digest(&bytes[..bytes.len() - HASH])[..] == bytes[bytes.len() - HASH..],
        damaged()
    );
    let content = &content[..content.len() - HASH];
    let line = content.iter().position(|byte| *byte == b'\n').with_context(damaged)?;
    let header: Header = serde_json::from_slice(&content[..line]).with_context(damaged)?;
    if header.fingerprint != fingerprint {
        bail!(
            "{shown} is of another study: the study, an FMU or plcfmu has changed since; name another folder with --out, or \
             start over without --resume"
        );
    }
    let rows: Vec<Row> = postcard::from_bytes(&content[line + 1..]).with_context(damaged)?;
    ensure!(header.first.checked_add(rows.len() as u64) == Some(header.end), damaged());
    Ok((header.first..header.end, rows))
}

/// The parts of a study in a folder.
#[derive(Debug)]
pub struct Parts {
    folder: PathBuf,
    fingerprint: String,
    /// Which runs are in which file, by the first.
    files: BTreeMap<(u64, u64), PathBuf>,
}

impl Parts {
    /// Those of a study whose results go to `out`. Unless it goes on, old parts are removed.
    ///
    /// # Errors
    /// A part is damaged or of another study; the folder cannot be read or written.
    pub fn open(out: &Path, fingerprint: &str, resumes: bool) -> Result<Parts> {
        let folder = out.join("parts");
        let mut parts = Parts { folder, fingerprint: fingerprint.into(), files: BTreeMap::new() };
        if !resumes {
            parts.remove()?;
        }
        super::make_folder(&parts.folder)?;
        let shown = || parts.folder.display().to_string();
        temporary::remove_left(&parts.folder).with_context(shown)?;
        let mut paths = fs::read_dir(&parts.folder)
            .with_context(shown)?
            .map(|entry| Ok(entry?.path()))
            .collect::<Result<Vec<_>>>()?;
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "part"));
        for path in paths {
            let (runs, _) = read(&path, fingerprint)?;
            parts.files.insert((runs.start, runs.end), path);
        }
        Ok(parts)
    }

    /// Whether there are no parts.
    pub fn are_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// The runs below `count` that no part has.
    pub fn missing(&self, count: u64) -> Vec<Range<u64>> {
        let (mut missing, mut next) = (Vec::new(), 0);
        for (first, end) in self.files.keys() {
            if *first > next {
                missing.push(next..(*first).min(count));
            }
            next = next.max(*end);
        }
        if next < count {
            missing.push(next..count);
        }
        missing.retain(|runs| !runs.is_empty());
        missing
    }

    /// Adds a part.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn add(&mut self, first: u64, rows: &[Row]) -> Result<()> {
        let end = first + rows.len() as u64;
        let path = self.folder.join(format!("{first}-{end}.part"));
        write(&path, &self.fingerprint, first, rows)?;
        self.files.insert((first, end), path);
        Ok(())
    }

    /// All rows in the order of the runs, each once. There is a part for each run.
    ///
    /// # Errors
    /// A part cannot be read, or an error of `each`.
    pub fn rows(&self, mut each: impl FnMut(u64, Row) -> Result<()>) -> Result<()> {
        let mut next = 0;
        for ((first, end), path) in &self.files {
            if *end <= next {
                continue;
            }
            let (_, rows) = read(path, &self.fingerprint)?;
            for (run, row) in (*first..).zip(rows) {
                if run == next {
                    each(run, row)?;
                    next += 1;
                }
            }
        }
        Ok(())
    }

    /// Removes the parts, and their folder if nothing else is in it.
    ///
    /// # Errors
    /// A part cannot be removed.
    pub fn remove(&mut self) -> Result<()> {
        self.files.clear();
        super::clear(&self.folder, |name| name.ends_with(".part"))
    }
}

/// Collects rows, and writes a part from time to time.
#[derive(Debug)]
pub struct Collector<'a> {
    parts: &'a mut Parts,
    first: u64,
    rows: Vec<Row>,
    began: Instant,
    written: Instant,
}

impl Collector<'_> {
    /// For rows of a study that begins or goes on now.
    pub fn new(parts: &mut Parts) -> Collector<'_> {
        let now = Instant::now();
        Collector { parts, first: 0, rows: Vec::new(), began: now, written: now }
    }

    /// Adds the row of a run.
    ///
    /// # Errors
    /// A part cannot be written.
    pub fn push(&mut self, run: u64, row: Row) -> Result<()> {
        if self.is_due() || self.rows.len() >= MOST_ROWS || self.first + self.rows.len() as u64 != run {
            self.flush()?;
            self.first = run;
        }
        self.rows.push(row);
        Ok(())
    }

    /// Writes what there is if it has waited long enough.
    ///
    /// # Errors
    /// The part cannot be written.
    pub fn wait(&mut self) -> Result<()> {
        if self.is_due() { self.flush() } else { Ok(()) }
    }

    fn is_due(&self) -> bool {
        self.written.elapsed() > LATEST.0.max(self.began.elapsed() / LATEST.1)
    }

    /// Writes what there is.
    ///
    /// # Errors
    /// The part cannot be written.
    pub fn flush(&mut self) -> Result<()> {
        if !self.rows.is_empty() {
            self.parts.add(self.first, &self.rows)?;
            self.rows.clear();
        }
        self.written = Instant::now();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(runs: Range<u64>) -> Vec<Row> {
        let error = |run| (run % 3 == 0).then(|| format!("run {run}"));
        runs.map(|run| Row { figures: vec![run as f64, f64::NAN], error: error(run) }).collect()
    }

    fn collected(parts: &Parts) -> Vec<(u64, f64)> {
        let mut all = Vec::new();
        parts
            .rows(|run, row| {
                all.push((run, row.figures[0]));
                Ok(())
            })
            .unwrap();
        all
    }

    #[test]
    fn parts_that_overlap_give_each_row_once() {
        let folder = tempfile::tempdir().unwrap();
        let mut parts = Parts::open(folder.path(), "f", false).unwrap();
        for runs in [6..9, 0..4, 2..5] {
            parts.add(runs.start, &rows(runs)).unwrap();
        }
        assert_eq!(parts.missing(10), [5..6, 9..10]);
        parts.add(5, &rows(5..10)).unwrap();
        let mut again = Parts::open(folder.path(), "f", true).unwrap();
        assert_eq!(again.missing(10), []);
        assert_eq!(collected(&again), (0..10).map(|run| (run, run as f64)).collect::<Vec<_>>());
        again.remove().unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_part_of_another_study_is_refused_unless_the_study_begins_anew() {
        let folder = tempfile::tempdir().unwrap();
        Parts::open(folder.path(), "one", false).unwrap().add(0, &rows(0..4)).unwrap();
        let error = Parts::open(folder.path(), "other", true).unwrap_err().to_string();
        assert!(error.contains("0-4.part is of another study") && error.contains("without --resume"), "{error}");
        assert_eq!(collected(&Parts::open(folder.path(), "other", false).unwrap()), []);
    }

    #[test]
    fn a_damaged_part_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("parts/0-4.part");
        write(&path, "f", 0, &rows(0..4)).unwrap();
        let whole = fs::read(&path).unwrap();
        let mut flipped = whole.clone();
        flipped[whole.len() - HASH - 1] ^= 1;
        for bytes in [&flipped[..], &whole[..whole.len() - 1], &whole[..MAGIC.len()]] {
            fs::write(&path, bytes).unwrap();
            let error = Parts::open(folder.path(), "f", true).unwrap_err().to_string();
            assert!(error.ends_with("0-4.part is damaged: delete it, and its runs are made again"), "{error}");
        }
        fs::write(&path, "rows").unwrap();
        let error = Parts::open(folder.path(), "f", true).unwrap_err().to_string();
        assert!(error.contains("is not a part of a study"), "{error}");
    }

    #[test]
    fn rows_that_do_not_follow_each_other_are_in_several_parts() {
        let folder = tempfile::tempdir().unwrap();
        let mut parts = Parts::open(folder.path(), "f", false).unwrap();
        let mut collector = Collector::new(&mut parts);
        for (run, row) in (0..3).zip(rows(0..3)).chain((7..9).zip(rows(7..9))) {
            collector.push(run, row).unwrap();
        }
        collector.flush().unwrap();
        assert_eq!(parts.missing(10), [3..7, 9..10]);
    }
}
