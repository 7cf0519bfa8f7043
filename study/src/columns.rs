//! Columns of numbers: small ones are kept in memory, large ones in an unnamed file, from which one column is read at a
//! time.

use anyhow::{Context, Result};
use std::borrow::Cow;
use std::cell::RefCell;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use tempfile::SpooledTempFile;

/// The number of values read at once.
const PIECE: usize = 1 << 13;

/// Numbers that are written once and read often. Up to a given size they are kept in memory, beyond it in an unnamed
/// file that disappears when the store is dropped.
#[derive(Debug)]
pub(crate) struct Spill {
    /// Reading moves the file position; the `RefCell` allows it through a shared reference.
    file: RefCell<SpooledTempFile>,
    end: u64,
    folder: PathBuf,
}

impl Spill {
    /// Creates an empty store that keeps up to `most` bytes in memory; beyond that, it uses a file in `folder`.
    pub(crate) fn new(most: usize, folder: &Path) -> Spill {
        Spill { file: RefCell::new(SpooledTempFile::new_in(most, folder)), end: 0, folder: folder.into() }
    }

    /// Appends numbers of `N` bytes each. Returns the byte position at which they start.
    ///
    /// # Errors
    /// The file cannot be written, for instance because the disk is full.
    pub(crate) fn append<const N: usize>(&mut self, numbers: impl Iterator<Item = [u8; N]>) -> Result<u64> {
        let (begin, file) = (self.end, self.file.get_mut());
        let append = || {
            file.seek(SeekFrom::Start(begin))?;
            let mut writer = BufWriter::new(&mut *file);
            for number in numbers {
                writer.write_all(&number)?;
            }
            writer.flush()?;
            drop(writer);
            file.stream_position()
        };
        self.end = append().with_context(|| self.failed("written"))?;
        Ok(begin)
    }

    /// Reads `count` numbers, starting at the byte position `at`, and appends them to a list.
    ///
    /// # Errors
    /// The numbers cannot be read.
    pub(crate) fn read<const N: usize, T>(
        &self,
        at: u64,
        count: usize,
        number: fn([u8; N]) -> T,
        to: &mut Vec<T>,
    ) -> Result<()> {
        let mut file = self.file.borrow_mut();
        let mut bytes = vec![[0; N]; count.min(PIECE)];
        let mut read = || {
            file.seek(SeekFrom::Start(at))?;
            let end = to.len() + count;
            while to.len() < end {
                let piece = &mut bytes[..(end - to.len()).min(PIECE)];
                file.read_exact(piece.as_flattened_mut())?;
                to.extend(piece.iter().map(|bytes| number(*bytes)));
            }
            Ok::<_, io::Error>(())
        };
        read().with_context(|| self.failed("read"))
    }

    fn failed(&self, done: &str) -> String {
        format!(
            "the results of the runs cannot be {done} in {}: free some space there; the runs are kept, and the same \
             command with --resume continues from them",
            self.folder.display()
        )
    }
}

/// Columns of equal length.
#[derive(Debug)]
pub(crate) struct Columns {
    /// The number of rows in a block.
    block: usize,
    /// The number of rows.
    count: u64,
    /// Blocks of rows, each stored column by column.
    blocks: Spill,
    /// The columns of the rows after the last block; contains all rows while they are few.
    last: Vec<Vec<f64>>,
}

impl Columns {
    /// Creates columns without rows. About `most` values are kept in memory, the others in a file in `folder`.
    pub(crate) fn new(width: usize, most: usize, folder: &Path) -> Columns {
        let block = (most / width.max(1)).max(1);
        Columns { block, count: 0, blocks: Spill::new(0, folder), last: vec![Vec::new(); width] }
    }

    /// The folder of the file.
    pub(crate) fn folder(&self) -> &Path {
        &self.blocks.folder
    }

    /// The number of rows.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// Appends a row, with one value per column.
    ///
    /// # Errors
    /// The file cannot be written, for instance because the disk is full.
    pub(crate) fn push(&mut self, row: impl Iterator<Item = f64>) -> Result<()> {
        if self.last.first().is_some_and(|column| column.len() == self.block) {
            self.blocks.append(self.last.iter().flatten().map(|value| value.to_le_bytes()))?;
            self.last.iter_mut().for_each(Vec::clear);
        }
        for (column, value) in self.last.iter_mut().zip(row) {
            column.push(value);
        }
        self.count += 1;
        Ok(())
    }

    /// The number of rows stored in blocks.
    fn spilled(&self) -> u64 {
        self.count - self.last.first().map_or(self.count, |column| column.len() as u64)
    }

    /// The byte position in the file of a value stored in a block.
    fn place(&self, row: u64, column: usize) -> u64 {
        let (width, block) = (self.last.len() as u64, self.block as u64);
        ((row / block * width + column as u64) * block + row % block) * size_of::<f64>() as u64
    }

    /// Returns a range of rows of one column.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn column(&self, column: usize, rows: Range<u64>) -> Result<Cow<'_, [f64]>> {
        let (spilled, block) = (self.spilled(), self.block as u64);
        let in_memory =
            |rows: Range<u64>| &self.last[column][(rows.start - spilled) as usize..(rows.end - spilled) as usize];
        if rows.start >= spilled {
            return Ok(Cow::Borrowed(in_memory(rows)));
        }
        let mut values = Vec::with_capacity((rows.end - rows.start) as usize);
        let mut next = rows.start;
        while next < rows.end.min(spilled) {
            let end = ((next / block + 1) * block).min(rows.end);
            self.blocks.read(self.place(next, column), (end - next) as usize, f64::from_le_bytes, &mut values)?;
            next = end;
        }
        if next < rows.end {
            values.extend_from_slice(in_memory(next..rows.end));
        }
        Ok(Cow::Owned(values))
    }

    /// Returns the values of one row in a range of columns.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn row(&self, row: u64, columns: Range<usize>) -> Result<Vec<f64>> {
        let mut values = Vec::with_capacity(columns.len());
        for column in columns {
            values.extend_from_slice(&self.column(column, row..row + 1)?);
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten rows of three columns: the value at row 7 and column 2 is 72.
    fn columns(most: usize, folder: &Path) -> Result<Columns> {
        let mut columns = Columns::new(3, most, folder);
        for row in 0..10 {
            columns.push((0..3).map(|column| f64::from(10 * row + column)))?;
        }
        Ok(columns)
    }

    #[test]
    fn columns_of_which_blocks_are_in_a_file_are_those_in_memory() {
        let folder = tempfile::tempdir().unwrap();
        // Blocks of 4 rows: two in the file, and two rows in memory; blocks of 5 rows, the last one full; blocks of one
        // row; all rows in memory.
        for (most, spilled) in [(12, 8), (15, 5), (1, 9), (30, 0)] {
            let columns = columns(most, folder.path()).unwrap();
            assert_eq!((columns.count(), columns.spilled()), (10, spilled), "{most}");
            for column in 0..3 {
                for (from, to) in (0..=10).flat_map(|from| (from..=10).map(move |to| (from, to))) {
                    let expected: Vec<f64> = (from..to).map(|row| (10 * row + column) as f64).collect();
                    assert_eq!(
                        *columns.column(column, from as u64..to as u64).unwrap(),
                        expected,
                        "{most}: {from}..{to}"
                    );
                }
            }
            assert_eq!(columns.row(7, 1..3).unwrap(), [71.0, 72.0]);
            assert_eq!(columns.row(9, 0..1).unwrap(), [90.0]);
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "the file has no name");
    }

    #[test]
    fn numbers_of_any_size_are_read_back_from_where_they_begin() {
        let folder = tempfile::tempdir().unwrap();
        for most in [0, 1 << 20] {
            let mut spill = Spill::new(most, folder.path());
            let many = PIECE as u32 + 3;
            let places = [
                spill.append((0..many).map(u32::to_le_bytes)),
                spill.append([0.5_f64].map(f64::to_le_bytes).into_iter()),
            ];
            let [first, second] = places.map(Result::unwrap);
            assert_eq!((first, second), (0, 4 * u64::from(many)));
            let (mut whole, mut number) = (vec![7], Vec::new());
            spill.read(first + 8, many as usize - 2, u32::from_le_bytes, &mut whole).unwrap();
            spill.read(second, 1, f64::from_le_bytes, &mut number).unwrap();
            assert_eq!((whole[..3].to_vec(), whole.last(), number), (vec![7, 2, 3], Some(&(many - 1)), vec![0.5]));
        }
    }

    #[test]
    fn a_file_that_cannot_be_written_is_named_with_what_to_do() {
        let folder = tempfile::tempdir().unwrap().path().join("gone");
        let error = format!("{:#}", columns(12, &folder).unwrap_err());
        let said = format!(
            "the results of the runs cannot be written in {}: free some space there; the runs are kept",
            folder.display()
        );
        assert!(error.starts_with(&said), "{error}");
    }
}
