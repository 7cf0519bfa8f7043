//! Reads any bytes as an FMU: a sentence, or a package of which every file can be read or is refused with a sentence.
//! Reads them as a library too.

#![no_main]

use libfuzzer_sys::fuzz_target;
use host::package::Package;
use host::package::archive::Archive;
use host::package::binary::Binary;
use std::io::Cursor;

/// The largest file that is unpacked here, in bytes, so that a run is short.
const LIMIT: u64 = 1 << 20;

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = Package::read(Cursor::new(bytes)) {
        assert!(!error.to_string().is_empty());
    }
    if let Err(error) = Binary::read(bytes) {
        assert!(!error.to_string().is_empty());
    }
    let Ok(mut archive) = Archive::open(Cursor::new(bytes)) else { return };
    for entry in archive.entries().to_vec() {
        assert!(!entry.name.starts_with('/') && !entry.name.split('/').any(|part| part == ".."), "{:?}", entry.name);
        if let Ok(content) = archive.read(&entry.name, LIMIT) {
            assert_eq!(content.len() as u64, entry.size, "{:?}", entry.name);
        }
    }
});
