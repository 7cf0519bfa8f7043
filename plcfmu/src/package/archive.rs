//! Reads ZIP files that anybody may have made, and trusts nothing in them: bounded memory, no file outside the folder, and
//! one sentence for everything that is wrong. Writes them, the same bytes for the same content.
//!
//! Read here and not by the crate that writes them, because that one looks for other tables of contents where the first
//! is damaged, and so reads another archive than other tools do.

use flate2::read::DeflateDecoder;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Cursor, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// An FMU with more files than this is none.
const MOST_ENTRIES: u16 = 10_000;

/// Nor does one have a table of contents of more bytes.
const LONGEST_DIRECTORY: u32 = 1 << 24;

/// A file may unpack to so many bytes, ...
const MOST_BYTES: u64 = 1 << 30;

/// ... and all of them together to so many.
const MOST_BYTES_IN_ALL: u64 = 1 << 32;

/// The longest name, in bytes.
const LONGEST_NAME: usize = 1000;

// Lengths without the variable parts, and what the records begin with.
const END: usize = 22;
const END_MAGIC: [u8; 4] = *b"PK\x05\x06";
const ENTRY: usize = 46;
const ENTRY_MAGIC: [u8; 4] = *b"PK\x01\x02";
const LOCAL: usize = 30;
const LOCAL_MAGIC: [u8; 4] = *b"PK\x03\x04";

/// A ZIP file: its table of contents, checked.
#[derive(Debug)]
pub struct Archive<R> {
    reader: R,
    entries: Vec<Entry>,
}

/// A file in a ZIP file.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its path, with `/`.
    pub name: String,
    /// Its unpacked size in bytes.
    pub size: u64,
    deflated: bool,
    compressed: u64,
    checksum: u32,
    /// Where its own header begins, and its data.
    header: u64,
    data: u64,
}

impl Entry {
    /// Whether it is a folder.
    pub fn is_folder(&self) -> bool {
        self.name.ends_with('/')
    }
}

impl<R: Read + Seek> Archive<R> {
    /// Reads and checks the table of contents.
    ///
    /// # Errors
    /// A sentence that says what is wrong with it.
    pub fn open(mut reader: R) -> Result<Archive<R>, String> {
        let length = reader.seek(SeekFrom::End(0)).map_err(unreadable)?;
        let end = find_end(&mut reader, length)?;
        if end.count > MOST_ENTRIES {
            return Err(format!("it has {} entries; more than {MOST_ENTRIES} are not taken", end.count));
        }
        if end.size > LONGEST_DIRECTORY {
            return Err(format!(
                "its table of contents has {} bytes; more than {LONGEST_DIRECTORY} are not taken",
                end.size
            ));
        }
        let mut directory = vec![0; end.size as usize];
        read_at(&mut reader, end.start, &mut directory)?;
        let mut entries = parse_directory(&directory, end.count)?;
        check_names(&entries)?;
        check_sizes(&entries)?;
        for entry in &mut entries {
            locate(&mut reader, entry)?;
        }
        check_places(&entries, end.start)?;
        Ok(Archive { reader, entries })
    }

    /// The files and folders, in the order in which they stand there.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The file of this name.
    pub fn find(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    /// The content of a file of at most `limit` bytes.
    ///
    /// # Errors
    /// It is not there, too large or damaged.
    pub fn read(&mut self, name: &str, limit: u64) -> Result<Vec<u8>, String> {
        let entry = self.find(name).ok_or_else(|| format!("{name} is missing"))?.clone();
        if entry.size > limit {
            return Err(format!("{name} has {} bytes; more than {limit} are not taken", entry.size));
        }
        let mut content = Vec::new();
        self.unpack_entry(&entry, &mut content)?;
        Ok(content)
    }

    /// Unpacks everything into a folder, which has to be empty.
    ///
    /// # Errors
    /// An entry is damaged, or a file cannot be written.
    pub fn unpack(&mut self, folder: &Path) -> Result<(), String> {
        for entry in self.entries.clone() {
            // The name has been checked: it leads nowhere else.
            let path = folder.join(&entry.name);
            let unwritable = |error: io::Error| format!("{} cannot be unpacked: {error}", entry.name);
            if entry.is_folder() {
                fs::create_dir_all(&path).map_err(unwritable)?;
                continue;
            }
            if let Some(parent) = path.parent() {
                fs::create_dir_all(parent).map_err(unwritable)?;
            }
            // Two names may be one where capitals do not count.
            let mut file = File::create_new(&path).map_err(unwritable)?;
            self.unpack_entry(&entry, &mut file)?;
        }
        Ok(())
    }

    /// Unpacks a file and compares size and checksum.
    fn unpack_entry(&mut self, entry: &Entry, to: &mut impl Write) -> Result<(), String> {
        self.reader.seek(SeekFrom::Start(entry.data)).map_err(unreadable)?;
        let packed = (&mut self.reader).take(entry.compressed);
        let mut checked = Checked { to, checksum: crc32fast::Hasher::new() };
        // One byte more than announced is enough to know.
        let limit = entry.size + 1;
        let copied = if entry.deflated {
            io::copy(&mut DeflateDecoder::new(packed).take(limit), &mut checked)
        } else {
            io::copy(&mut packed.take(limit), &mut checked)
        };
        let copied = copied.map_err(|error| format!("{} cannot be unpacked: {error}", entry.name))?;
        if copied != entry.size || checked.checksum.finalize() != entry.checksum {
            return Err(format!("{} is damaged: its size or checksum is not what the archive says", entry.name));
        }
        Ok(())
    }
}

/// Passes bytes on and adds them up.
struct Checked<'a, W> {
    to: &'a mut W,
    checksum: crc32fast::Hasher,
}

impl<W: Write> Write for Checked<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.to.write(bytes)?;
        self.checksum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// The record at the end of a ZIP file: where the table of contents is.
struct End {
    count: u16,
    start: u64,
    size: u32,
}

fn find_end(reader: &mut (impl Read + Seek), length: u64) -> Result<End, String> {
    // A comment of up to 65535 bytes may follow it.
    let tail_length = length.min((END + usize::from(u16::MAX)) as u64);
    let mut tail = vec![0; tail_length as usize];
    read_at(reader, length - tail_length, &mut tail)?;
    let place = (0..(tail.len() + 1).saturating_sub(END))
        .rev()
        .find(|place| tail[*place..].starts_with(&END_MAGIC))
        .ok_or("it is no ZIP file, or its end is missing")?;
    let record = &tail[place..];
    if usize::from(u16_at(record, 20)) != record.len() - END {
        return Err("its end is damaged: bytes follow the archive".into());
    }
    let (count, size, start) = (u16_at(record, 10), u32_at(record, 12), u32_at(record, 16));
    if count == u16::MAX || size == u32::MAX || start == u32::MAX {
        return Err("it is a ZIP64 file, for archives beyond 4 GiB; such are not taken".into());
    }
    if u16_at(record, 4) != 0 || u16_at(record, 6) != 0 || u16_at(record, 8) != count {
        return Err("it is one of several parts; such are not taken".into());
    }
    let end = length - tail_length + place as u64;
    if u64::from(start) + u64::from(size) != end {
        return Err("its table of contents is not where the archive's end says; bytes are missing or added".into());
    }
    Ok(End { count, start: u64::from(start), size })
}

fn parse_directory(mut directory: &[u8], count: u16) -> Result<Vec<Entry>, String> {
    let mut entries = Vec::new();
    for number in 1..=count {
        let damaged = || format!("entry {number} of its table of contents is damaged");
        if directory.len() < ENTRY || !directory.starts_with(&ENTRY_MAGIC) {
            return Err(damaged());
        }
        let (header, rest) = directory.split_at(ENTRY);
        let name_length = usize::from(u16_at(header, 28));
        let length = name_length + usize::from(u16_at(header, 30)) + usize::from(u16_at(header, 32));
        let (Some(name), Some(rest)) = (rest.get(..name_length), rest.get(length..)) else {
            return Err(damaged());
        };
        let name = std::str::from_utf8(name).map_err(|_| format!("the name of entry {number} is no UTF-8"))?;
        check_name(name)?;
        entries.push(parse_entry(header, name)?);
        directory = rest;
    }
    if !directory.is_empty() {
        return Err(format!("its table of contents does not end after the {count} entries it announces"));
    }
    Ok(entries)
}

fn parse_entry(header: &[u8], name: &str) -> Result<Entry, String> {
    if u16_at(header, 8) & 1 != 0 {
        return Err(format!("{name} is encrypted; such are not taken"));
    }
    let deflated = match u16_at(header, 10) {
        0 => false,
        8 => true,
        method => {
            return Err(format!("{name} is packed by method {method}; FMI allows stored (0) and deflate (8) only"));
        }
    };
    // The upper half of the attributes is that of Unix, if its maker was (3), or macOS (19).
    let unix = matches!(header[5], 3 | 19);
    let file_type = (u32_at(header, 38) >> 16) & 0o170_000;
    if unix && !matches!(file_type, 0 | 0o100_000 | 0o040_000) {
        return Err(format!("{name} is a link or a device; only files and folders are taken"));
    }
    let (compressed, size) = (u32_at(header, 20), u32_at(header, 24));
    if compressed == u32::MAX || size == u32::MAX {
        return Err(format!("{name} is larger than 4 GiB; such are not taken"));
    }
    if !deflated && compressed != size {
        return Err(format!("{name} is stored, but its two sizes differ ({compressed} and {size})"));
    }
    if name.ends_with('/') && size != 0 {
        return Err(format!("{name} is a folder with content"));
    }
    Ok(Entry {
        name: name.into(),
        size: size.into(),
        deflated,
        compressed: compressed.into(),
        checksum: u32_at(header, 16),
        header: u32_at(header, 42).into(),
        data: 0,
    })
}

/// A name must be a path downwards from the folder that the archive is unpacked to, on every system.
fn check_name(name: &str) -> Result<(), String> {
    if name.is_empty() || name.len() > LONGEST_NAME {
        return Err(format!("an entry's name has {} bytes; 1 ... {LONGEST_NAME} are taken", name.len()));
    }
    let refused = |why: &str| Err(format!("the name {name:?} {why}"));
    if name.chars().any(char::is_control) {
        return refused("has control characters");
    }
    if name.contains('\\') {
        return refused("has a backslash; FMI asks for /");
    }
    if name.starts_with('/') {
        return refused("is an absolute path");
    }
    if name.contains(':') {
        return refused("has a colon, as a Windows drive");
    }
    let path = name.strip_suffix('/').unwrap_or(name);
    if path.split('/').any(|part| matches!(part, "" | "." | "..")) {
        return refused("has an empty part, '.' or '..'");
    }
    Ok(())
}

fn check_names(entries: &[Entry]) -> Result<(), String> {
    let mut names = BTreeSet::new();
    match entries.iter().find(|entry| !names.insert(&entry.name)) {
        Some(entry) => Err(format!("{} is there twice", entry.name)),
        None => Ok(()),
    }
}

fn check_sizes(entries: &[Entry]) -> Result<(), String> {
    if let Some(entry) = entries.iter().find(|entry| entry.size > MOST_BYTES) {
        return Err(format!("{} unpacks to {} bytes; more than {MOST_BYTES} are not taken", entry.name, entry.size));
    }
    let sum: u64 = entries.iter().map(|entry| entry.size).sum();
    if sum > MOST_BYTES_IN_ALL {
        return Err(format!("it unpacks to {sum} bytes; more than {MOST_BYTES_IN_ALL} are not taken"));
    }
    Ok(())
}

/// Finds the data behind the entry's own header, which must agree with the table of contents.
fn locate(reader: &mut (impl Read + Seek), entry: &mut Entry) -> Result<(), String> {
    let damaged = |_| format!("the header of {} is damaged", entry.name);
    let mut header = [0; LOCAL];
    read_at(reader, entry.header, &mut header).map_err(damaged)?;
    let mut name = vec![0; usize::from(u16_at(&header, 26))];
    reader.read_exact(&mut name).map_err(unreadable).map_err(damaged)?;
    let method = if entry.deflated { 8 } else { 0 };
    if !header.starts_with(&LOCAL_MAGIC) || name != entry.name.as_bytes() || u16_at(&header, 8) != method {
        return Err(damaged(String::new()));
    }
    entry.data = entry.header + (LOCAL + name.len() + usize::from(u16_at(&header, 28))) as u64;
    Ok(())
}

/// No two entries may share bytes: that is how a small file unpacks to a huge one.
fn check_places(entries: &[Entry], directory: u64) -> Result<(), String> {
    let mut places: Vec<&Entry> = entries.iter().collect();
    places.sort_by_key(|entry| entry.header);
    let ends = places.iter().skip(1).map(|entry| entry.header).chain([directory]);
    for (entry, end) in places.iter().zip(ends) {
        if entry.data + entry.compressed > end {
            return Err(format!("{} overlaps with what follows it", entry.name));
        }
    }
    Ok(())
}

fn read_at(reader: &mut (impl Read + Seek), place: u64, bytes: &mut [u8]) -> Result<(), String> {
    reader.seek(SeekFrom::Start(place)).and_then(|_| reader.read_exact(bytes)).map_err(unreadable)
}

fn unreadable(error: io::Error) -> String {
    format!("it cannot be read: {error}")
}

/// The numbers of a header, little endian.
fn u16_at(header: &[u8], place: usize) -> u16 {
    u16::from_le_bytes([header[place], header[place + 1]])
}

fn u32_at(header: &[u8], place: usize) -> u32 {
    u32::from(u16_at(header, place)) | u32::from(u16_at(header, place + 2)) << 16
}

/// A ZIP file of these files, by name: sorted, deflated, dated 1980, so that the same files give the same bytes.
///
/// # Errors
/// A name that [`Archive::open`] would refuse; too many bytes.
pub fn write(files: &BTreeMap<String, Vec<u8>>) -> Result<Vec<u8>, String> {
    let options = zip::write::SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated)
        .compression_level(Some(9))
        .last_modified_time(zip::DateTime::default());
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        check_name(name)?;
        let permissions = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        archive
            .start_file(name.as_str(), options.unix_permissions(permissions))
            .and_then(|()| Ok(archive.write_all(content)?))
            .map_err(|error| format!("{name} cannot be packed: {error}"))?;
    }
    let cursor = archive.finish().map_err(|error| format!("the archive cannot be finished: {error}"))?;
    Ok(cursor.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stored file as it stands in an archive, to be spoilt.
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
            bytes.extend(LOCAL_MAGIC);
            common(&mut bytes, file);
            numbers(&mut bytes, &[file.local_name.len() as u16, 0]);
            bytes.extend(&file.local_name);
            bytes.extend(&file.content);

            directory.extend(ENTRY_MAGIC);
            numbers(&mut directory, &[(3 << 8) | 20]);
            common(&mut directory, file);
            numbers(&mut directory, &[file.name.len() as u16, 0, 0, 0, 0]);
            directory.extend(file.attributes.to_le_bytes());
            directory.extend(header.to_le_bytes());
            directory.extend(&file.name);
        }
        let start = bytes.len() as u32;
        bytes.extend(&directory);
        bytes.extend(END_MAGIC);
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

    fn open(bytes: &[u8]) -> Result<Archive<Cursor<&[u8]>>, String> {
        Archive::open(Cursor::new(bytes))
    }

    fn refusal(files: &[Stored]) -> String {
        open(&archive(files)).map(|_| ()).unwrap_err()
    }

    /// Two files, packed as FMUs are.
    fn sample() -> BTreeMap<String, Vec<u8>> {
        [("a.txt", "text text text text text"), ("b/c.bin", "\0\x01")]
            .map(|(name, content)| (name.to_string(), content.as_bytes().to_vec()))
            .into()
    }

    fn contents(bytes: &[u8]) -> Result<BTreeMap<String, Vec<u8>>, String> {
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
        let error = write(&[("../x".to_string(), vec![])].into()).unwrap_err();
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
            ("C:/x", "has a colon, as a Windows drive"),
            ("C:x", "has a colon, as a Windows drive"),
            ("a\\x", "has a backslash; FMI asks for /"),
            ("..\\x", "has a backslash; FMI asks for /"),
            ("a\0x", "has control characters"),
            ("a\nx", "has control characters"),
        ] {
            assert_eq!(refusal(&[stored(name, b"")]), format!("the name {name:?} {reason}"));
        }
        assert_eq!(refusal(&[stored("", b"")]), "an entry's name has 0 bytes; 1 ... 1000 are taken");
        assert_eq!(refusal(&[stored(&"x".repeat(1001), b"")]), "an entry's name has 1001 bytes; 1 ... 1000 are taken");
        let no_text = Stored { name: vec![0xff, 0xfe], ..stored("xx", b"") };
        assert_eq!(refusal(&[no_text]), "the name of entry 1 is no UTF-8");
    }

    #[test]
    fn two_entries_of_one_name_are_refused() {
        assert_eq!(refusal(&[stored("x", b"1"), stored("y", b""), stored("x", b"2")]), "x is there twice");
    }

    #[test]
    fn links_and_devices_are_refused() {
        for file_type in [0o120_777, 0o020_666, 0o060_666, 0o010_644, 0o140_644] {
            let file = Stored { attributes: file_type << 16, ..stored("x", b"/etc/passwd") };
            assert_eq!(refusal(&[file]), "x is a link or a device; only files and folders are taken");
        }
    }

    #[test]
    fn what_fmi_does_not_allow_is_refused() {
        let encrypted = Stored { flags: 1, ..stored("x", b"1") };
        assert_eq!(refusal(&[encrypted]), "x is encrypted; such are not taken");
        let bzip2 = Stored { method: 12, ..stored("x", b"1") };
        assert_eq!(refusal(&[bzip2]), "x is packed by method 12; FMI allows stored (0) and deflate (8) only");
        assert_eq!(refusal(&[stored("x/", b"1")]), "x/ is a folder with content");
    }

    #[test]
    fn huge_counts_and_sizes_are_refused_before_anything_is_unpacked() {
        let many: Vec<Stored> = (0..10_001).map(|number| stored(&format!("{number}"), b"")).collect();
        assert_eq!(refusal(&many), "it has 10001 entries; more than 10000 are not taken");
        assert!(open(&archive(&many[..10_000])).is_ok());
        let huge = Stored { method: 8, size: (1 << 30) + 1, ..stored("x", b"1") };
        assert_eq!(refusal(&[huge]), "x unpacks to 1073741825 bytes; more than 1073741824 are not taken");
        let large = |name: &str| Stored { method: 8, size: 1 << 30, ..stored(name, b"1") };
        let all = ["a", "b", "c", "d", "e"].map(large);
        assert_eq!(refusal(&all), "it unpacks to 5368709120 bytes; more than 4294967296 are not taken");
        let long: Vec<Stored> = (0..9).map(|number| stored(&format!("{number}"), b"")).collect();
        assert!(open(&with_comments(&long)).is_ok());
        let long: Vec<Stored> = (0..300).map(|number| stored(&format!("{number}"), b"")).collect();
        let error = open(&with_comments(&long)).unwrap_err();
        assert_eq!(error, "its table of contents has 19675090 bytes; more than 16777216 are not taken");
        let zip64 = Stored { method: 8, size: u32::MAX, ..stored("x", b"1") };
        assert_eq!(refusal(&[zip64]), "x is larger than 4 GiB; such are not taken");
    }

    #[test]
    fn a_file_that_unpacks_to_more_than_it_says_ends_where_it_says() {
        let zeros = write(&[("x".to_string(), vec![0; 1 << 20])].into()).unwrap();
        let mut archive = open(&zeros).unwrap();
        let mut entry = archive.entries()[0].clone();
        entry.size = 100;
        let mut unpacked = Vec::new();
        let error = archive.unpack_entry(&entry, &mut unpacked).unwrap_err();
        assert_eq!(error, "x is damaged: its size or checksum is not what the archive says");
        assert_eq!(unpacked.len(), 101);
    }

    #[test]
    fn entries_that_share_bytes_are_refused() {
        // b stands inside the content of a, so that its bytes would be unpacked twice.
        let b = archive(&[stored("b", b"1")]);
        let a = stored("a", &b[..LOCAL + 2]);
        let inside = Stored { header: Some(LOCAL as u32 + 1), ..stored("b", b"1") };
        assert_eq!(refusal(&[a, inside]), "a overlaps with what follows it");
        // The content would reach into the table of contents.
        let mut bytes = archive(&[stored("x", b"1")]);
        let entry = LOCAL + 2;
        bytes[entry + 20] = 5;
        bytes[entry + 24] = 5;
        assert_eq!(open(&bytes).unwrap_err(), "x overlaps with what follows it");
        let same = Stored { header: Some(0), ..stored("b", b"1") };
        assert_eq!(refusal(&[stored("a", b"1"), same]), "the header of b is damaged");
    }

    #[test]
    fn a_header_that_contradicts_the_table_of_contents_is_refused() {
        let other_name = Stored { local_name: b"y".to_vec(), ..stored("x", b"1") };
        assert_eq!(refusal(&[other_name]), "the header of x is damaged");
        let nowhere = Stored { header: Some(1 << 31), ..stored("x", b"1") };
        assert_eq!(refusal(&[nowhere]), "the header of x is damaged");
        let two_sizes = Stored { size: 2, ..stored("x", b"1") };
        assert_eq!(refusal(&[two_sizes]), "x is stored, but its two sizes differ (1 and 2)");
    }

    #[test]
    fn a_wrong_checksum_is_told() {
        let bytes = archive(&[Stored { checksum: 1, ..stored("x", b"1") }]);
        let error = open(&bytes).unwrap().read("x", 10).unwrap_err();
        assert_eq!(error, "x is damaged: its size or checksum is not what the archive says");
    }

    #[test]
    fn a_missing_or_too_large_file_is_told() {
        let bytes = archive(&[stored("x", b"12345")]);
        let mut archive = open(&bytes).unwrap();
        assert_eq!(archive.read("y", 10).unwrap_err(), "y is missing");
        assert_eq!(archive.read("x", 4).unwrap_err(), "x has 5 bytes; more than 4 are not taken");
        assert_eq!(archive.read("x", 5).unwrap(), b"12345");
    }

    #[test]
    fn what_is_no_archive_is_refused() {
        for bytes in [&b""[..], b"PK", b"hello, this is no archive at all", &[0; 100_000]] {
            assert_eq!(open(bytes).unwrap_err(), "it is no ZIP file, or its end is missing");
        }
    }

    #[test]
    fn an_end_that_is_not_the_end_is_refused() {
        let good = archive(&[stored("x", b"1")]);
        let end = good.len() - END;
        let spoilt = |place: usize, value: u8| {
            let mut bytes = good.clone();
            bytes[end + place] = value;
            open(&bytes).map(|_| ()).unwrap_err()
        };
        assert_eq!(spoilt(20, 1), "its end is damaged: bytes follow the archive");
        assert_eq!(spoilt(4, 1), "it is one of several parts; such are not taken");
        assert_eq!(spoilt(8, 2), "it is one of several parts; such are not taken");
        assert!(spoilt(16, 0).starts_with("its table of contents is not where the archive's end says"));
        let zip64: Vec<u8> = good[..end + 16].iter().copied().chain([0xff; 4]).chain([0, 0]).collect();
        assert_eq!(open(&zip64).unwrap_err(), "it is a ZIP64 file, for archives beyond 4 GiB; such are not taken");
        let mut two = good.clone();
        two[end + 8] = 2;
        two[end + 10] = 2;
        assert_eq!(open(&two).unwrap_err(), "entry 2 of its table of contents is damaged");
        let mut none = good.clone();
        none[end + 8] = 0;
        none[end + 10] = 0;
        assert_eq!(open(&none).unwrap_err(), "its table of contents does not end after the 0 entries it announces");
        let prefixed: Vec<u8> = b"x".iter().copied().chain(good).collect();
        assert!(open(&prefixed).unwrap_err().starts_with("its table of contents is not where the archive's end says"));
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
        let error = open(&archive(&files)).unwrap().unpack(folder.path()).unwrap_err();
        assert!(error.starts_with("a.txt cannot be unpacked: "), "{error}");
        // A file where another entry needs a folder.
        files = vec![stored("f", b"1"), stored("f/g", b"2")];
        let error = open(&archive(&files)).unwrap().unpack(folder.path()).unwrap_err();
        assert!(error.starts_with("f/g cannot be unpacked: "), "{error}");
    }
}
