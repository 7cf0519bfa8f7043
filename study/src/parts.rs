//! The rows of an unfinished study in files called parts. When the study is resumed, runs contained in a part are not
//! repeated.
//!
//! A part is one file with the rows of consecutive runs: a line of text, a second line with a header in JSON, the rows
//! in postcard format, and the SHA-256 hash of everything before it. Parts of a study can be computed on any machine;
//! their runs may overlap.

use crate::Writer;
use crate::results::RunResult;
use anyhow::{Context, Result, bail, ensure};
use host::package::temporary;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Take, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::SpooledTempFile;

/// The first line of a part.
const MAGIC: &[u8] = b"plcfmu part 1\n";

/// The size of a SHA-256 hash in bytes.
const HASH: usize = 32;

/// The size of the rows, in bytes, at which a part is written.
const MOST_BYTES: u64 = 1 << 22;

/// The maximum size of rows kept in memory, in bytes; beyond it, all are kept in an unnamed file.
const MOST_IN_MEMORY: usize = 1 << 23;

/// The number of bytes of a part read at once.
const PIECE: u64 = 1 << 16;

/// The age at which rows are written as a part: this duration or, if longer, the study's elapsed time divided by this
/// number.
const LATEST: (Duration, u32) = (Duration::from_secs(1), 100);

/// The header of a part.
#[derive(Debug, Deserialize, Serialize, PartialEq)]
struct Header {
    /// The fingerprint of the job, see [`super::fingerprint`].
    fingerprint: String,
    /// The first run.
    first: u64,
    /// The run after the last.
    end: u64,
}

/// The rows of consecutive runs, encoded as in a part.
#[derive(Debug)]
pub struct Rows {
    count: u64,
    size: u64,
    encoded: SpooledTempFile,
}

impl Default for Rows {
    fn default() -> Rows {
        Rows { count: 0, size: 0, encoded: SpooledTempFile::new(MOST_IN_MEMORY) }
    }
}

impl Rows {
    /// Appends a row.
    ///
    /// # Errors
    /// The row cannot be written to the folder for temporary files, for instance because it is full.
    pub fn push(&mut self, row: &RunResult) -> Result<()> {
        let bytes = postcard::to_stdvec(row)?;
        self.encoded.write_all(&bytes).with_context(|| {
            let folder = std::env::temp_dir();
            format!("the rows of a part cannot be written to {}: free some space there", folder.display())
        })?;
        self.count += 1;
        self.size += bytes.len() as u64;
        Ok(())
    }
}

/// Writes a part at `path`, via a temporary file in the same folder that is then renamed. `first` is its first run.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, fingerprint: &str, first: u64, rows: &mut Rows) -> Result<()> {
    let header = Header { fingerprint: fingerprint.into(), first, end: first + rows.count };
    let mut head = MAGIC.to_vec();
    serde_json::to_writer(&mut head, &header)?;
    head.push(b'\n');
    // In postcard format, a list starts with its length.
    let head = postcard::to_extend(&rows.count, head)?;
    temporary::place(
        path,
        |to| {
            let mut digest = Sha256::new();
            rows.encoded.rewind()?;
            let mut from = head.chain(&mut rows.encoded);
            io::copy(&mut from, &mut Both(Writer(&mut digest), &mut *to))?;
            Ok(to.write_all(&digest.finalize())?)
        },
        |_| Ok(()),
    )
}

/// A writer that passes its input to two others.
struct Both<A, B>(A, B);

impl<A: Write, B: Write> Write for Both<A, B> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write_all(bytes)?;
        self.1.write_all(bytes)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()?;
        self.1.flush()
    }
}

/// A part of this study, checked to be intact.
struct Part {
    runs: Range<u64>,
    rows: Encoded,
}

/// A sequence of values in postcard format, read piece by piece.
struct Encoded {
    from: Take<File>,
    piece: Vec<u8>,
    /// The offset of the next value within the piece.
    next: usize,
}

impl Encoded {
    /// The next value, or `None` if the remaining bytes are incomplete or invalid.
    fn next<T: DeserializeOwned>(&mut self) -> Result<Option<T>> {
        loop {
            match postcard::take_from_bytes(&self.piece[self.next..]) {
                Ok((value, rest)) => {
                    self.next = self.piece.len() - rest.len();
                    return Ok(Some(value));
                }
                Err(postcard::Error::DeserializeUnexpectedEnd) => {
                    self.piece.drain(..self.next);
                    self.next = 0;
                    if Read::by_ref(&mut self.from).take(PIECE).read_to_end(&mut self.piece)? == 0 {
                        return Ok(None);
                    }
                }
                Err(_) => return Ok(None),
            }
        }
    }
}

/// Opens a part and reads it once to check that it is complete.
///
/// # Errors
/// It cannot be read, is damaged or belongs to another study; for the last two, the message names the remedy.
fn open(path: &Path, fingerprint: &str) -> Result<Part> {
    let shown = path.display();
    let unread = || format!("{shown} cannot be read");
    let damaged = || damaged(path);
    let mut file = File::open(path).with_context(unread)?;
    let size = file.metadata().with_context(unread)?.len();
    let mut head = Vec::new();
    (&file).take(MAGIC.len() as u64).read_to_end(&mut head).with_context(unread)?;
    ensure!(
        head == MAGIC,
        "{shown} is not a part of a study written by this version of plcfmu: choose another folder with --out, or omit \
         --resume"
    );
    let content = size.saturating_sub((MAGIC.len() + HASH) as u64);
    let mut digest = Sha256::new_with_prefix(MAGIC);
    io::copy(&mut (&file).take(content), &mut Writer(&mut digest)).with_context(unread)?;
    let mut hash = Vec::new();
    file.read_to_end(&mut hash).with_context(unread)?;
    ensure!(content > 0 && digest.finalize()[..] == hash[..], damaged());
    file.seek(SeekFrom::Start(MAGIC.len() as u64)).with_context(unread)?;
    let mut line = Vec::new();
    let mut content = BufReader::new(file.take(content));
    content.read_until(b'\n', &mut line).with_context(unread)?;
    let header: Header = serde_json::from_slice(&line).with_context(damaged)?;
    if header.fingerprint != fingerprint {
        bail!(
            "{shown} belongs to another study, or the study, an FMU or plcfmu has changed since; choose another folder \
             with --out, or start over without --resume"
        );
    }
    let piece = content.buffer().to_vec();
    let mut rows = Encoded { from: content.into_inner(), piece, next: 0 };
    let count: u64 = rows.next().with_context(unread)?.with_context(damaged)?;
    ensure!(header.first.checked_add(count) == Some(header.end), damaged());
    Ok(Part { runs: header.first..header.end, rows })
}

/// The message and remedy for a damaged part.
fn damaged(path: &Path) -> String {
    format!("{} is damaged: delete it, and its runs will be repeated", path.display())
}

/// The parts of a study in a folder.
#[derive(Debug)]
pub struct Parts {
    folder: PathBuf,
    fingerprint: String,
    /// The files, by their first run and the run after their last.
    files: BTreeMap<(u64, u64), PathBuf>,
}

impl Parts {
    /// Opens the parts of a study whose results go to `out`. Unless the study is resumed, old parts are removed.
    ///
    /// # Errors
    /// A part is damaged or belongs to another study, or the folder cannot be read or written.
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
            let runs = open(&path, fingerprint)?.runs;
            parts.files.insert((runs.start, runs.end), path);
        }
        Ok(parts)
    }

    /// Whether there are no parts.
    pub fn are_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// The runs of a study with `count` runs that no part contains.
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
    pub fn add(&mut self, first: u64, rows: &mut Rows) -> Result<()> {
        let end = first + rows.count;
        let path = self.folder.join(format!("{first}-{end}.part"));
        write(&path, &self.fingerprint, first, rows)?;
        self.files.insert((first, end), path);
        Ok(())
    }

    /// Passes all rows to `each`, in run order and each once. Every run must be in a part.
    ///
    /// # Errors
    /// A part cannot be read, or `each` fails.
    pub fn rows(&self, mut each: impl FnMut(u64, RunResult) -> Result<()>) -> Result<()> {
        let mut next = 0;
        for ((first, end), path) in &self.files {
            if *end <= next {
                continue;
            }
            let mut rows = open(path, &self.fingerprint)?.rows;
            for run in *first..*end {
                let row = rows.next()?.with_context(|| damaged(path))?;
                if run == next {
                    each(run, row)?;
                    next += 1;
                }
            }
        }
        Ok(())
    }

    /// Deletes the files of the parts, and their folder if it is then empty.
    ///
    /// # Errors
    /// A part cannot be removed.
    pub fn remove(&mut self) -> Result<()> {
        self.files.clear();
        super::clear(&self.folder, |name| name.ends_with(".part"))
    }
}

/// Collects rows and periodically writes them as a part.
#[derive(Debug)]
pub struct Collector<'a> {
    parts: &'a mut Parts,
    first: u64,
    rows: Rows,
    began: Instant,
    written: Instant,
}

impl Collector<'_> {
    /// Creates a collector for a study that starts or resumes now.
    pub fn new(parts: &mut Parts) -> Collector<'_> {
        let now = Instant::now();
        Collector { parts, first: 0, rows: Rows::default(), began: now, written: now }
    }

    /// Adds the row of a run.
    ///
    /// # Errors
    /// A part cannot be written.
    pub fn push(&mut self, run: u64, row: &RunResult) -> Result<()> {
        if self.is_due() || self.rows.size >= MOST_BYTES || self.first + self.rows.count != run {
            self.flush()?;
            self.first = run;
        }
        self.rows.push(row)
    }

    /// Writes the collected rows if a part is due, for use while no rows arrive.
    ///
    /// # Errors
    /// The part cannot be written.
    pub fn wait(&mut self) -> Result<()> {
        if self.is_due() { self.flush() } else { Ok(()) }
    }

    fn is_due(&self) -> bool {
        self.written.elapsed() > LATEST.0.max(self.began.elapsed() / LATEST.1)
    }

    /// Writes the collected rows.
    ///
    /// # Errors
    /// The part cannot be written.
    pub fn flush(&mut self) -> Result<()> {
        if self.rows.count > 0 {
            self.parts.add(self.first, &mut self.rows)?;
            self.rows = Rows::default();
        }
        self.written = Instant::now();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(run: u64) -> RunResult {
        RunResult { figures: vec![run as f64, f64::NAN], error: run.is_multiple_of(3).then(|| format!("run {run}")) }
    }

    fn rows(runs: Range<u64>) -> Rows {
        let mut rows = Rows::default();
        runs.for_each(|run| rows.push(&row(run)).unwrap());
        rows
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
            parts.add(runs.start, &mut rows(runs)).unwrap();
        }
        assert_eq!(parts.missing(10), [5..6, 9..10]);
        parts.add(5, &mut rows(5..10)).unwrap();
        let mut again = Parts::open(folder.path(), "f", true).unwrap();
        assert_eq!(again.missing(10), []);
        assert_eq!(collected(&again), (0..10).map(|run| (run, run as f64)).collect::<Vec<_>>());
        again.remove().unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_part_of_another_study_is_refused_unless_the_study_begins_anew() {
        let folder = tempfile::tempdir().unwrap();
        Parts::open(folder.path(), "one", false).unwrap().add(0, &mut rows(0..4)).unwrap();
        let error = Parts::open(folder.path(), "other", true).unwrap_err().to_string();
        assert!(error.contains("0-4.part belongs to another study") && error.contains("without --resume"), "{error}");
        assert_eq!(collected(&Parts::open(folder.path(), "other", false).unwrap()), []);
    }

    #[test]
    fn a_damaged_part_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("parts/0-4.part");
        write(&path, "f", 0, &mut rows(0..4)).unwrap();
        let whole = fs::read(&path).unwrap();
        let mut flipped = whole.clone();
        flipped[whole.len() - HASH - 1] ^= 1;
        for bytes in [&flipped[..], &whole[..whole.len() - 1], &whole[..MAGIC.len()]] {
            fs::write(&path, bytes).unwrap();
            let error = Parts::open(folder.path(), "f", true).unwrap_err().to_string();
            assert!(error.ends_with("0-4.part is damaged: delete it, and its runs will be repeated"), "{error}");
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
        for run in (0..3).chain(7..9) {
            collector.push(run, &row(run)).unwrap();
        }
        collector.flush().unwrap();
        assert_eq!(parts.missing(10), [3..7, 9..10]);
    }

    #[test]
    fn a_part_is_a_list_of_rows_in_the_format_of_postcard() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("6-8.part");
        write(&path, "f", 6, &mut rows(6..8)).unwrap();
        let mut expected = b"plcfmu part 1\n{\"fingerprint\":\"f\",\"first\":6,\"end\":8}\n".to_vec();
        expected.extend(postcard::to_stdvec(&vec![row(6), row(7)]).unwrap());
        expected.extend_from_slice(&Sha256::digest(&expected));
        assert_eq!(fs::read(&path).unwrap(), expected);
    }

    #[test]
    fn rows_across_the_pieces_in_which_a_part_is_read_are_whole() {
        let folder = tempfile::tempdir().unwrap();
        let mut parts = Parts::open(folder.path(), "f", false).unwrap();
        let long = "dry ".repeat(PIECE as usize);
        let given = |run: u64| RunResult { error: (run == 3000).then(|| long.clone()), ..row(run) };
        let mut rows = Rows::default();
        (0..9000).for_each(|run| rows.push(&given(run)).unwrap());
        parts.add(0, &mut rows).unwrap();
        let mut count = 0;
        Parts::open(folder.path(), "f", true)
            .unwrap()
            .rows(|run, row| {
                assert!(run == count && row.figures[0] == run as f64 && row.error == given(run).error, "{run}");
                count += 1;
                Ok(())
            })
            .unwrap();
        assert_eq!(count, 9000);
    }

    #[test]
    fn no_part_is_much_larger_than_what_may_wait() {
        let folder = tempfile::tempdir().unwrap();
        let mut parts = Parts::open(folder.path(), "f", false).unwrap();
        let mut collector = Collector::new(&mut parts);
        // 8 kB each.
        let row = RunResult { figures: vec![0.5; 1000], error: None };
        (0..600).for_each(|run| collector.push(run, &row).unwrap());
        collector.flush().unwrap();
        assert_eq!(parts.missing(600), []);
        let sizes: Vec<u64> = parts.files.values().map(|path| fs::metadata(path).unwrap().len()).collect();
        assert!(sizes.len() > 1 && sizes.iter().all(|size| *size < MOST_BYTES + 10_000), "{sizes:?}");
    }
}
