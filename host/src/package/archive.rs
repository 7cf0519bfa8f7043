//! ZIP files: reads untrusted ones and writes reproducible ones.
//!
//! The crate `zip` reads; this module determines what is accepted: bounded memory, no path outside the target folder,
//! no links, no overlapping entries, and a single table of contents. If that table is damaged, `zip` searches for
//! another and may then read a different archive than other tools; the end record and the lengths of the table's
//! entries are therefore checked here first.

use crate::package::temporary;
use anyhow::{Context, Result, anyhow, bail, ensure};
use std::collections::{BTreeMap, HashSet};
use std::io::{self, Cursor, Read, Seek, SeekFrom, Write};
use std::path::Path;
use zip::read::{ArchiveOffset, Config, ZipFileEntry};
use zip::{CompressionMethod, System, ZipArchive, ZipReadOptions};

/// The maximum number of files and folders in an archive.
const MOST_ENTRIES: u16 = 10_000;

/// The maximum size of the table of contents, in bytes.
const LONGEST_DIRECTORY: u32 = 1 << 24;

/// The maximum unpacked size of a file, in bytes.
const MOST_BYTES: u64 = 1 << 30;

/// The maximum total unpacked size of all files, in bytes.
const MOST_BYTES_IN_ALL: u64 = 1 << 32;

/// The maximum ratio of unpacked to packed size for files larger than [`LARGE`].
const HIGHEST_RATIO: u64 = 1000;

/// Files up to this size, in bytes, may have any compression ratio: a short run of zeros packs to almost nothing.
const LARGE: u64 = 1 << 24;

/// The maximum length of a name, in bytes.
const LONGEST_NAME: usize = 1000;

// The signatures and fixed lengths of the records.
const END: usize = 22;
const END_SIGNATURE: [u8; 4] = *b"PK\x05\x06";
const ENTRY: usize = 46;
const ENTRY_SIGNATURE: [u8; 4] = *b"PK\x01\x02";

/// A ZIP file whose table of contents has been checked.
#[derive(Debug)]
pub struct Archive<R> {
    archive: ZipArchive<R>,
    entries: Vec<Entry>,
}

/// A file or folder in a ZIP file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its path, with `/` between the parts, and at the end if it is a folder.
    pub name: String,
    /// Its unpacked size in bytes.
    pub size: u64,
}

impl Entry {
    /// Whether it is a folder.
    pub fn is_folder(&self) -> bool {
        self.name.ends_with('/')
    }
}

impl<R: Read + Seek> Archive<R> {
    /// Reads and checks the table of contents and each entry's header.
    ///
    /// # Errors
    /// The archive is not acceptable; the message is a sentence that calls it "it" or names an entry.
    pub fn open(mut reader: R) -> Result<Archive<R>> {
        let end = find_end(&mut reader)?;
        let names = read_names(&mut reader, &end)?;
        let config = Config { archive_offset: ArchiveOffset::Known(0) };
        let mut archive = ZipArchive::with_config(config, reader).context("its table of contents is damaged")?;
        // An extra field can give an entry a second name, which only some tools use.
        ensure!(
            archive.central_directory_start() == end.start
                && archive.file_names_raw().eq(names.iter().map(String::as_bytes)),
            "its table of contents is ambiguous"
        );
        let metadata = archive.metadata();
        let mut entries = Vec::new();
        for (index, name) in names.into_iter().enumerate() {
            entries.push(accept(&metadata.entry(index)?, name)?);
        }
        let sum: u64 = entries.iter().map(|entry| entry.size).sum();
        ensure!(sum <= MOST_BYTES_IN_ALL, "it unpacks to {sum} bytes; at most {MOST_BYTES_IN_ALL} are accepted");
        for (index, Entry { name, size }) in entries.iter().enumerate() {
            let options = ZipReadOptions::new().enforce_header_consistency(true);
            let packed = archive
                .by_index_with_options(index, options)
                .with_context(|| format!("the header of {name} is damaged"))?
                .compressed_size();
            ensure!(
                *size <= LARGE || *size <= packed.saturating_mul(HIGHEST_RATIO),
                "{name} unpacks from {packed} to {size} bytes; a ratio of at most {HIGHEST_RATIO} is accepted"
            );
        }
        // Overlapping entries would let a small archive unpack to a huge amount of data.
        ensure!(
            !archive.has_overlapping_entries()?,
            "two of its entries overlap, or one overlaps with the table of contents"
        );
        Ok(Archive { archive, entries })
    }

    /// The files and folders, in the order of the table of contents.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The entry with this name.
    pub fn find(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    /// Reads a file of at most `limit` bytes.
    ///
    /// # Errors
    /// The file is missing, too large or damaged.
    pub fn read(&mut self, name: &str, limit: u64) -> Result<Vec<u8>> {
        let entry = self.find(name).ok_or_else(|| anyhow!("{name} is missing"))?.clone();
        ensure!(entry.size <= limit, "{name} has {} bytes; at most {limit} are accepted", entry.size);
        let mut content = Vec::new();
        self.unpack_entry(&entry, &mut content)?;
        Ok(content)
    }

    /// Checks all entries by unpacking them without storing the result.
    ///
    /// # Errors
    /// An entry is damaged.
    pub fn verify(&mut self) -> Result<()> {
        self.entries
            .clone()
            .iter()
            .filter(|entry| !entry.is_folder())
            .try_for_each(|entry| self.unpack_entry(entry, &mut io::sink()))
    }

    /// Unpacks everything into a folder, which must be empty.
    ///
    /// # Errors
    /// An entry is damaged, or a file cannot be written.
    pub fn unpack(&mut self, folder: &Path) -> Result<()> {
        for entry in self.entries.clone() {
            // The name has been checked: it cannot lead outside the folder.
            let path = folder.join(&entry.name);
            let unwritable = || format!("{} cannot be unpacked", entry.name);
            if entry.is_folder() {
                temporary::make_folder(&path).with_context(unwritable)?;
                continue;
            }
            if let Some(parent) = path.parent() {
                temporary::make_folder(parent).with_context(unwritable)?;
            }
            // Fails if the file exists: on a case-insensitive file system, two names may denote the same file.
            let mut file = temporary::options().write(true).create_new(true).open(&path).with_context(unwritable)?;
            self.unpack_entry(&entry, &mut file)?;
        }
        Ok(())
    }

    /// Creates a ZIP file from `files` and those files of this archive for which `is_kept` returns true and that have
    /// no namesake in `files`. The latter are copied without recompression.
    ///
    /// # Errors
    /// As [`write()`], or a file cannot be copied.
    pub fn with(&mut self, files: &BTreeMap<String, Vec<u8>>, is_kept: impl Fn(&str) -> bool) -> Result<Vec<u8>> {
        let kept = self
            .entries
            .iter()
            .enumerate()
            .filter(|(_, entry)| !entry.is_folder() && !files.contains_key(&entry.name) && is_kept(&entry.name));
        // Sorted by name, like all archives written here.
        let mut sorted: BTreeMap<&str, Option<usize>> =
            kept.map(|(index, entry)| (entry.name.as_str(), Some(index))).collect();
        sorted.extend(files.keys().map(|name| (name.as_str(), None)));
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, place) in sorted {
            let cannot = || format!("{name} cannot be packed");
            match place {
                Some(index) => {
                    let packed = self.archive.by_index_raw(index).with_context(cannot)?;
                    writer.raw_copy_file(packed).with_context(cannot)?;
                }
                None => pack(&mut writer, name, &files[name])?,
            }
        }
        Ok(writer.finish().context("the archive cannot be finished")?.into_inner())
    }

    /// Unpacks a file; `zip` verifies the checksum and stops at the size given in the table of contents.
    fn unpack_entry(&mut self, entry: &Entry, to: &mut impl Write) -> Result<()> {
        let Entry { name, size } = entry;
        let mut file = self.archive.by_name(name)?;
        let unpacked = io::copy(&mut file, to).with_context(|| format!("{name} cannot be unpacked"))?;
        ensure!(unpacked == *size, "{name} is damaged: it unpacks to {unpacked} bytes instead of {size}");
        Ok(())
    }
}

/// What the record at the end of a ZIP file states about the table of contents: number of entries, position and size in
/// bytes.
struct End {
    count: u16,
    start: u64,
    size: u32,
}

/// Finds the end record, which must directly follow the table of contents; only its own comment may follow it.
fn find_end(reader: &mut (impl Read + Seek)) -> Result<End> {
    let length = reader.seek(SeekFrom::End(0)).context("it cannot be read")?;
    // A comment of up to 65535 bytes may follow the record.
    let tail_start = length.saturating_sub((END + usize::from(u16::MAX)) as u64);
    let tail = read_at(reader, tail_start, length - tail_start)?;
    let place = (0..(tail.len() + 1).saturating_sub(END))
        .rev()
        .find(|place| tail[*place..].starts_with(&END_SIGNATURE))
        .context("it is not a ZIP file, or its end is missing")?;
    let record = &tail[place..];
    ensure!(usize::from(u16_at(record, 20)) == record.len() - END, "its end is damaged: bytes follow the archive");
    let (count, size, start) = (u16_at(record, 10), u32_at(record, 12), u32_at(record, 16));
    ensure!(
        count != u16::MAX && size != u32::MAX && start != u32::MAX,
        "it is a ZIP64 archive, the format for more than 4 GiB, which is not accepted"
    );
    ensure!(
        u16_at(record, 4) == 0 && u16_at(record, 6) == 0 && u16_at(record, 8) == count,
        "it is part of a multi-file archive, which is not accepted"
    );
    ensure!(
        u64::from(start) + u64::from(size) == tail_start + place as u64,
        "its table of contents is not where the end record states: bytes are missing or were added"
    );
    ensure!(count <= MOST_ENTRIES, "it has {count} entries; at most {MOST_ENTRIES} are accepted");
    ensure!(
        size <= LONGEST_DIRECTORY,
        "its table of contents has {size} bytes; at most {LONGEST_DIRECTORY} are accepted"
    );
    Ok(End { count, start: u64::from(start), size })
}

/// The names in the table of contents, after checking that its entries fill it exactly.
fn read_names(reader: &mut (impl Read + Seek), end: &End) -> Result<Vec<String>> {
    let directory = read_at(reader, end.start, u64::from(end.size))?;
    let mut rest = directory.as_slice();
    let mut names = Vec::new();
    let mut seen = HashSet::new();
    for number in 1..=end.count {
        let damaged = || format!("entry {number} of its table of contents is damaged");
        let header = rest.get(..ENTRY).filter(|header| header.starts_with(&ENTRY_SIGNATURE)).with_context(damaged)?;
        let [name_length, extra, comment] = [28, 30, 32].map(|place| usize::from(u16_at(header, place)));
        let name = rest.get(ENTRY..ENTRY + name_length).with_context(damaged)?;
        rest = rest.get(ENTRY + name_length + extra + comment..).with_context(damaged)?;
        let name =
            std::str::from_utf8(name).ok().with_context(|| format!("the name of entry {number} is not UTF-8"))?;
        check_name(name)?;
        ensure!(seen.insert(name), "{name} occurs twice");
        names.push(name.to_string());
    }
    ensure!(
        rest.is_empty(),
        "its table of contents has data after its last entry; declared number of entries: {}",
        end.count
    );
    Ok(names)
}

/// Checks an entry of the table of contents.
fn accept(entry: &ZipFileEntry<'_>, name: String) -> Result<Entry> {
    let size = entry.size();
    ensure!(!entry.encrypted(), "{name} is encrypted, which is not accepted");
    match entry.compression() {
        CompressionMethod::Stored => ensure!(
            entry.compressed_size() == size,
            "{name} is not compressed, but its packed and unpacked sizes differ ({} and {size})",
            entry.compressed_size()
        ),
        CompressionMethod::Deflated => {}
        _ => bail!("{name} is compressed with a method other than deflate, which FMI does not allow"),
    }
    // If the entry was created on Unix, the upper 16 bits of the attributes contain the file type.
    let file_type = (entry.external_attributes() >> 16) & 0o170_000;
    let is_unix = matches!(entry.system(), System::Unix | System::OsDarwin);
    ensure!(
        !is_unix || matches!(file_type, 0 | 0o100_000 | 0o040_000),
        "{name} is a link or a device; only files and folders are accepted"
    );
    ensure!(size <= MOST_BYTES, "{name} unpacks to {size} bytes; at most {MOST_BYTES} are accepted");
    ensure!(!name.ends_with('/') || size == 0, "{name} is a folder, but has content");
    Ok(Entry { name, size })
}

/// Checks that a name is a path within the target folder on every system.
fn check_name(name: &str) -> Result<()> {
    if name.is_empty() || name.len() > LONGEST_NAME {
        bail!("an entry's name has {} bytes; 1 to {LONGEST_NAME} are accepted", name.len());
    }
    let path = name.strip_suffix('/').unwrap_or(name);
    let fault = if name.chars().any(char::is_control) {
        "has control characters"
    } else if name.contains('\\') {
        "has a backslash; FMI requires /"
    } else if name.starts_with('/') {
        "is an absolute path"
    } else if name.contains(':') {
        "has a colon, which Windows interprets as a drive"
    } else if path.split('/').any(|part| matches!(part, "" | "." | "..")) {
        "has an empty part, '.' or '..'"
    } else {
        return Ok(());
    };
    bail!("the name {name:?} {fault}")
}

fn read_at(reader: &mut (impl Read + Seek), start: u64, length: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.seek(SeekFrom::Start(start)).context("it cannot be read")?;
    reader.take(length).read_to_end(&mut bytes).context("it cannot be read")?;
    Ok(bytes)
}

/// Reads a little-endian number from a record.
fn u16_at(record: &[u8], place: usize) -> u16 {
    u16::from_le_bytes([record[place], record[place + 1]])
}

fn u32_at(record: &[u8], place: usize) -> u32 {
    u32::from(u16_at(record, place)) | u32::from(u16_at(record, place + 2)) << 16
}

/// Creates a ZIP file with these files: sorted by name and dated 1980, so that the same files always yield the same
/// bytes. All are deflated except FMUs, which are already compressed.
///
/// # Errors
/// A name would be rejected by [`Archive::open`], or a file is too large to be packed.
pub fn write(files: &BTreeMap<String, Vec<u8>>) -> Result<Vec<u8>> {
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        pack(&mut writer, name, content)?;
    }
    Ok(writer.finish().context("the archive cannot be finished")?.into_inner())
}

fn pack(writer: &mut zip::ZipWriter<Cursor<Vec<u8>>>, name: &str, content: &[u8]) -> Result<()> {
    check_name(name)?;
    // The highest level takes more than twice as long, to save half a percent of a library's size.
    let (method, level) = match name.ends_with(".fmu") {
        true => (CompressionMethod::Stored, None),
        false => (CompressionMethod::Deflated, Some(6)),
    };
    let options = zip::write::SimpleFileOptions::default()
        .compression_method(method)
        .compression_level(level)
        .last_modified_time(zip::DateTime::default())
        .unix_permissions(if name.starts_with("binaries/") { 0o755 } else { 0o644 });
    writer
        .start_file(name, options)
        .and_then(|()| Ok(writer.write_all(content)?))
        .with_context(|| format!("{name} cannot be packed"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const LOCAL: usize = 30;
    const LOCAL_SIGNATURE: [u8; 4] = *b"PK\x03\x04";

    /// A stored file as it is in an archive, to be corrupted.
    #[derive(Clone)]
    struct Stored {
        name: Vec<u8>,
        local_name: Vec<u8>,
        content: Vec<u8>,
        flags: u16,
        method: u16,
        checksum: u32,
        size: u32,
        attributes: u32,
        /// Extra fields of both headers.
        extra: Vec<u8>,
        /// Where its header is said to be, if that is not where it is.
        header: Option<u32>,
    }

    fn stored(name: &str, content: &[u8]) -> Stored {
        Stored {
            name: name.into(),
            local_name: name.into(),
            content: content.to_vec(),
            flags: 0,
            method: 0,
            checksum: crc32fast::hash(content),
            size: content.len() as u32,
            attributes: 0o100_644 << 16,
            extra: Vec::new(),
            header: None,
        }
    }

    fn numbers(bytes: &mut Vec<u8>, numbers: &[u16]) {
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    /// The parts that a file's own header and its entry share: version needed to checksum and sizes.
    fn common(bytes: &mut Vec<u8>, file: &Stored) {
        numbers(bytes, &[20, file.flags, file.method, 0, 33]);
        for number in [file.checksum, file.content.len() as u32, file.size] {
            bytes.extend(number.to_le_bytes());
        }
    }

    fn archive(files: &[Stored]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut directory = Vec::new();
        for file in files {
            let header = file.header.unwrap_or(bytes.len() as u32);
            bytes.extend(LOCAL_SIGNATURE);
            common(&mut bytes, file);
            numbers(&mut bytes, &[file.local_name.len() as u16, file.extra.len() as u16]);
            bytes.extend(&file.local_name);
            bytes.extend(&file.extra);
            bytes.extend(&file.content);

            directory.extend(ENTRY_SIGNATURE);
            numbers(&mut directory, &[(3 << 8) | 20]);
            common(&mut directory, file);
            numbers(&mut directory, &[file.name.len() as u16, file.extra.len() as u16, 0, 0, 0]);
            directory.extend(file.attributes.to_le_bytes());
            directory.extend(header.to_le_bytes());
            directory.extend(&file.name);
            directory.extend(&file.extra);
        }
        let start = bytes.len() as u32;
        bytes.extend(&directory);
        bytes.extend(END_SIGNATURE);
        numbers(&mut bytes, &[0, 0, files.len() as u16, files.len() as u16]);
        bytes.extend((directory.len() as u32).to_le_bytes());
        bytes.extend(start.to_le_bytes());
        numbers(&mut bytes, &[0]);
        bytes
    }

    /// An archive whose entries have the longest comments that there can be.
    fn with_comments(files: &[Stored]) -> Vec<u8> {
        let bytes = archive(files);
        let start = u32_at(&bytes, bytes.len() - 6) as usize;
        let (before, directory) = bytes.split_at(start);
        let (mut directory, end) = directory.split_at(directory.len() - END);
        let mut commented = before.to_vec();
        while !directory.is_empty() {
            let length = ENTRY + usize::from(u16_at(directory, 28));
            let (entry, rest) = directory.split_at(length);
            commented.extend(&entry[..32]);
            commented.extend(u16::MAX.to_le_bytes());
            commented.extend(&entry[34..]);
            commented.resize(commented.len() + usize::from(u16::MAX), 0);
            directory = rest;
        }
        let size = (commented.len() - start) as u32;
        commented.extend(&end[..12]);
        commented.extend(size.to_le_bytes());
        commented.extend(&end[16..]);
        commented
    }

    fn open(bytes: &[u8]) -> Result<Archive<Cursor<&[u8]>>> {
        Archive::open(Cursor::new(bytes))
    }

    /// The sentence that a user reads.
    fn sentence<T>(result: Result<T>) -> String {
        format!("{:#}", result.map(|_| ()).unwrap_err())
    }

    fn refusal(files: &[Stored]) -> String {
        sentence(open(&archive(files)))
    }

    /// Two files, packed as FMUs are.
    fn sample() -> BTreeMap<String, Vec<u8>> {
        [("a.txt", "text text text text text"), ("b/c.bin", "\0\x01")]
            .map(|(name, content)| (name.to_string(), content.as_bytes().to_vec()))
            .into()
    }

    fn contents(bytes: &[u8]) -> Result<BTreeMap<String, Vec<u8>>> {
        let mut archive = open(bytes)?;
        let names: Vec<String> = archive.entries().iter().map(|entry| entry.name.clone()).collect();
        names.into_iter().map(|name| archive.read(&name, 1000).map(|content| (name, content))).collect()
    }

    #[test]
    fn what_is_written_reads_back() {
        assert_eq!(contents(&write(&sample()).unwrap()).unwrap(), sample());
        assert_eq!(contents(&write(&BTreeMap::new()).unwrap()).unwrap(), BTreeMap::new());
        let file = stored("x", b"hello");
        assert_eq!(contents(&archive(&[file])).unwrap()["x"], b"hello");
    }

    #[test]
    fn the_same_files_give_the_same_bytes_sorted_by_name_and_dated_1980() {
        let bytes = write(&sample()).unwrap();
        assert_eq!(bytes, write(&sample()).unwrap());
        let archive = open(&bytes).unwrap();
        assert_eq!(archive.entries().iter().map(|entry| entry.name.as_str()).collect::<Vec<_>>(), ["a.txt", "b/c.bin"]);
        // Time 00:00:00 and date 1980-01-01 (0 0 and day 1, month 1) of the first file.
        assert_eq!(bytes[10..14], [0, 0, 0b0010_0001, 0]);
    }

    #[test]
    fn names_that_lead_elsewhere_are_not_written() {
        let error = sentence(write(&[("../x".to_string(), vec![])].into()));
        assert_eq!(error, "the name \"../x\" has an empty part, '.' or '..'");
    }

    #[test]
    fn names_that_lead_elsewhere_or_differ_between_systems_are_refused() {
        for (name, reason) in [
            ("../x", "has an empty part, '.' or '..'"),
            ("a/../../x", "has an empty part, '.' or '..'"),
            ("a/..", "has an empty part, '.' or '..'"),
            ("./x", "has an empty part, '.' or '..'"),
            ("a//x", "has an empty part, '.' or '..'"),
            ("a//", "has an empty part, '.' or '..'"),
            ("/etc/x", "is an absolute path"),
            ("/", "is an absolute path"),
            ("C:/x", "has a colon, which Windows interprets as a drive"),
            ("C:x", "has a colon, which Windows interprets as a drive"),
            ("a\\x", "has a backslash; FMI requires /"),
            ("..\\x", "has a backslash; FMI requires /"),
            ("a\0x", "has control characters"),
            ("a\nx", "has control characters"),
        ] {
            assert_eq!(refusal(&[stored(name, b"")]), format!("the name {name:?} {reason}"));
        }
        assert_eq!(refusal(&[stored("", b"")]), "an entry's name has 0 bytes; 1 to 1000 are accepted");
        assert_eq!(
            refusal(&[stored(&"x".repeat(1001), b"")]),
            "an entry's name has 1001 bytes; 1 to 1000 are accepted"
        );
        let no_text = Stored { name: vec![0xff, 0xfe], ..stored("xx", b"") };
        assert_eq!(refusal(&[no_text]), "the name of entry 1 is not UTF-8");
    }

    #[test]
    fn two_entries_of_one_name_are_refused() {
        assert_eq!(refusal(&[stored("x", b"1"), stored("y", b""), stored("x", b"2")]), "x occurs twice");
    }

    #[test]
    fn links_and_devices_are_refused() {
        for file_type in [0o120_777, 0o020_666, 0o060_666, 0o010_644, 0o140_644] {
            let file = Stored { attributes: file_type << 16, ..stored("x", b"/etc/passwd") };
            assert_eq!(refusal(&[file]), "x is a link or a device; only files and folders are accepted");
        }
    }

    #[test]
    fn what_fmi_does_not_allow_is_refused() {
        let encrypted = Stored { flags: 1, ..stored("x", b"1") };
        assert_eq!(refusal(&[encrypted]), "x is encrypted, which is not accepted");
        let bzip2 = Stored { method: 12, ..stored("x", b"1") };
        assert_eq!(refusal(&[bzip2]), "x is compressed with a method other than deflate, which FMI does not allow");
        assert_eq!(refusal(&[stored("x/", b"1")]), "x/ is a folder, but has content");
    }

    #[test]
    fn huge_counts_and_sizes_are_refused_before_anything_is_unpacked() {
        let many: Vec<Stored> = (0..10_001).map(|number| stored(&format!("{number}"), b"")).collect();
        assert_eq!(refusal(&many), "it has 10001 entries; at most 10000 are accepted");
        assert!(open(&archive(&many[..10_000])).is_ok());
        let huge = Stored { method: 8, size: (1 << 30) + 1, ..stored("x", b"1") };
        assert_eq!(refusal(&[huge]), "x unpacks to 1073741825 bytes; at most 1073741824 are accepted");
        let large = |name: &str| Stored { method: 8, size: 1 << 30, ..stored(name, b"1") };
        let all = ["a", "b", "c", "d", "e"].map(large);
        assert_eq!(refusal(&all), "it unpacks to 5368709120 bytes; at most 4294967296 are accepted");
        let long: Vec<Stored> = (0..9).map(|number| stored(&format!("{number}"), b"")).collect();
        assert!(open(&with_comments(&long)).is_ok());
        let long: Vec<Stored> = (0..300).map(|number| stored(&format!("{number}"), b"")).collect();
        assert_eq!(
            sentence(open(&with_comments(&long))),
            "its table of contents has 19675090 bytes; at most 16777216 are accepted"
        );
        let zip64 = Stored { method: 8, size: u32::MAX, ..stored("x", b"1") };
        assert_eq!(refusal(&[zip64]), "x unpacks to 4294967295 bytes; at most 1073741824 are accepted");
    }

    /// What `content` deflates to.
    fn deflated(content: &[u8]) -> Vec<u8> {
        let bytes = write(&[("x".to_string(), content.to_vec())].into()).unwrap();
        let length = u32_at(&bytes, 18) as usize;
        bytes[LOCAL + 1..][..length].to_vec()
    }

    #[test]
    fn a_file_that_unpacks_to_more_or_less_than_it_says_is_damaged() {
        let zeros = Stored { method: 8, checksum: crc32fast::hash(&[0; 100]), ..stored("x", &deflated(&[0; 1 << 20])) };
        let bytes = archive(&[Stored { size: 100, ..zeros.clone() }]);
        let mut unpacked = Vec::new();
        let mut opened = open(&bytes).unwrap();
        let entry = opened.entries()[0].clone();
        let error = sentence(opened.unpack_entry(&entry, &mut unpacked));
        assert_eq!(error, "x cannot be unpacked: File is larger than its declared uncompressed size");
        // Not far beyond: a bomb does not fill the memory first.
        assert!(unpacked.len() <= 101, "{}", unpacked.len());
        let bytes = archive(&[Stored { size: (1 << 20) + 1, checksum: crc32fast::hash(&[0; 1 << 20]), ..zeros }]);
        let error = sentence(open(&bytes).unwrap().read("x", u64::MAX));
        assert_eq!(error, "x is damaged: it unpacks to 1048576 bytes instead of 1048577");
    }

    #[test]
    fn a_large_file_that_packs_to_almost_nothing_is_refused() {
        let file = |size: u32| Stored { method: 8, size, ..stored("x", b"123") };
        assert!(open(&archive(&[file(1 << 24)])).is_ok());
        assert_eq!(
            refusal(&[file((1 << 24) + 1)]),
            "x unpacks from 3 to 16777217 bytes; a ratio of at most 1000 is accepted"
        );
        let content = vec![0; 16_778];
        let file = |size: u32| Stored { method: 8, size, ..stored("x", &content) };
        assert!(open(&archive(&[file(16_778_000)])).is_ok());
        assert_eq!(
            refusal(&[file(16_778_001)]),
            "x unpacks from 16778 to 16778001 bytes; a ratio of at most 1000 is accepted"
        );
    }

    #[test]
    fn an_entry_with_a_second_name_is_refused() {
        // The field 0x7075 of Info-ZIP: version, checksum of the name in the header, the name to use instead.
        let mut extra = vec![0x75, 0x70, 6, 0, 1];
        extra.extend(crc32fast::hash(b"x").to_le_bytes());
        extra.push(b'y');
        assert_eq!(refusal(&[Stored { extra, ..stored("x", b"1") }]), "its table of contents is ambiguous");
    }

    #[test]
    fn entries_that_share_bytes_are_refused() {
        // b is inside the content of a, so its bytes would be unpacked twice.
        let b = archive(&[stored("b", b"1")]);
        let a = stored("a", &b[..LOCAL + 2]);
        let inside = Stored { header: Some(LOCAL as u32 + 1), ..stored("b", b"1") };
        let overlap = "two of its entries overlap, or one overlaps with the table of contents";
        assert_eq!(refusal(&[a, inside]), overlap);
        // The content would reach into the table of contents.
        let mut bytes = archive(&[stored("x", b"1")]);
        let entry = LOCAL + 2;
        for size in [18, 22, entry + 20, entry + 24] {
            bytes[size] = 5;
        }
        assert_eq!(sentence(open(&bytes)), overlap);
        let same = Stored { header: Some(0), ..stored("b", b"1") };
        assert!(refusal(&[stored("a", b"1"), same]).starts_with("the header of b is damaged: "));
    }

    #[test]
    fn a_header_that_contradicts_the_table_of_contents_is_refused() {
        let other_name = Stored { local_name: b"y".to_vec(), ..stored("x", b"1") };
        assert!(refusal(&[other_name]).starts_with("the header of x is damaged: "));
        let nowhere = Stored { header: Some(1 << 31), ..stored("x", b"1") };
        assert!(refusal(&[nowhere]).starts_with("the header of x is damaged: "));
        let mut bytes = archive(&[stored("x", b"1")]);
        bytes[14] ^= 1;
        assert!(sentence(open(&bytes)).starts_with("the header of x is damaged: "), "another checksum");
        let two_sizes = Stored { size: 2, ..stored("x", b"1") };
        assert_eq!(refusal(&[two_sizes]), "x is not compressed, but its packed and unpacked sizes differ (1 and 2)");
    }

    #[test]
    fn a_wrong_checksum_is_told() {
        let bytes = archive(&[Stored { checksum: 1, ..stored("x", b"1") }]);
        let error = sentence(open(&bytes).unwrap().read("x", 10));
        assert_eq!(error, "x cannot be unpacked: Invalid checksum");
    }

    #[test]
    fn a_missing_or_too_large_file_is_told() {
        let bytes = archive(&[stored("x", b"12345")]);
        let mut archive = open(&bytes).unwrap();
        assert_eq!(sentence(archive.read("y", 10)), "y is missing");
        assert_eq!(sentence(archive.read("x", 4)), "x has 5 bytes; at most 4 are accepted");
        assert_eq!(archive.read("x", 5).unwrap(), b"12345");
    }

    #[test]
    fn what_is_no_archive_is_refused() {
        for bytes in [&b""[..], b"PK", b"hello, this is no archive at all", &[0; 100_000]] {
            assert_eq!(sentence(open(bytes)), "it is not a ZIP file, or its end is missing");
        }
    }

    #[test]
    fn an_end_that_is_not_the_end_is_refused() {
        let good = archive(&[stored("x", b"1")]);
        let end = good.len() - END;
        let spoilt = |place: usize, value: u8| {
            let mut bytes = good.clone();
            bytes[end + place] = value;
            sentence(open(&bytes))
        };
        assert_eq!(spoilt(20, 1), "its end is damaged: bytes follow the archive");
        assert_eq!(spoilt(4, 1), "it is part of a multi-file archive, which is not accepted");
        assert_eq!(spoilt(8, 2), "it is part of a multi-file archive, which is not accepted");
        assert!(spoilt(16, 0).starts_with("its table of contents is not where the end record states"));
        let zip64: Vec<u8> = good[..end + 16].iter().copied().chain([0xff; 4]).chain([0, 0]).collect();
        assert_eq!(
            sentence(open(&zip64)),
            "it is a ZIP64 archive, the format for more than 4 GiB, which is not accepted"
        );
        let mut two = good.clone();
        two[end + 8] = 2;
        two[end + 10] = 2;
        assert_eq!(sentence(open(&two)), "entry 2 of its table of contents is damaged");
        let mut none = good.clone();
        none[end + 8] = 0;
        none[end + 10] = 0;
        assert_eq!(
            sentence(open(&none)),
            "its table of contents has data after its last entry; declared number of entries: 0"
        );
        let prefixed: Vec<u8> = b"x".iter().copied().chain(good).collect();
        assert!(sentence(open(&prefixed)).starts_with("its table of contents is not where the end record states"));
    }

    #[test]
    fn a_damaged_or_shortened_archive_never_reads_as_another() {
        let good = write(&sample()).unwrap();
        for length in 0..good.len() {
            assert!(contents(&good[..length]).is_err(), "shortened to {length} bytes");
        }
        let mut survived = 0;
        for place in 0..good.len() {
            for bit in 0..8 {
                let mut bytes = good.clone();
                bytes[place] ^= 1 << bit;
                if let Ok(contents) = contents(&bytes) {
                    // Dates, permissions and versions do not matter; a name may change, a content never.
                    assert!(contents.values().eq(sample().values()), "bit {bit} of byte {place}");
                    survived += 1;
                }
            }
        }
        assert!(survived < good.len() * 8 / 2);
    }

    #[test]
    fn everything_is_unpacked_into_the_folder_and_nothing_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let mut files = vec![stored("a.txt", b"A"), stored("b/", b""), stored("c/d/e.txt", b"E")];
        open(&archive(&files)).unwrap().unpack(folder.path()).unwrap();
        assert_eq!(fs::read(folder.path().join("a.txt")).unwrap(), b"A");
        assert_eq!(fs::read(folder.path().join("c/d/e.txt")).unwrap(), b"E");
        assert!(folder.path().join("b").is_dir());
        let error = sentence(open(&archive(&files)).unwrap().unpack(folder.path()));
        assert!(error.starts_with("a.txt cannot be unpacked: "), "{error}");
        // A file where another entry needs a folder.
        files = vec![stored("f", b"1"), stored("f/g", b"2")];
        let error = sentence(open(&archive(&files)).unwrap().unpack(folder.path()));
        assert!(error.starts_with("f/g cannot be unpacked: "), "{error}");
    }
}
