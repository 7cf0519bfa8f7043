//! Presets through the C interface: where the library finds its start values, and what it makes of odd ones.

#![allow(clippy::unwrap_used)]
// A host calls C functions.
#![allow(unsafe_code)]

use blocks::table::fingerprint;
use blocks::table::start::{self, Start};
use blocks::{Block, ContC, Value};
use fmu::table::Guid;
use fmu::v2::ffi;
use std::ffi::CString;
use std::fs;
use std::path::Path;
use tests::{Log, Random, Status, logging_callbacks};

/// Start values of CONT_C in which GAIN is 3.
fn start_text() -> String {
    let rows = ContC::TABLE.rows.iter().filter(|row| row.role.is_settable());
    let value = |name: &str, value| start::text(if name == "GAIN" { Value::Real(3.0) } else { value });
    Start {
        preset: "TIC101".into(),
        block: ContC::TABLE.name.into(),
        library: Guid::<ContC>::TEXT.into(),
        values: rows.map(|row| (row.name.to_string(), value(row.name, row.start))).collect(),
    }
    .to_string()
}

fn guid(text: &[u8]) -> CString {
    CString::new(fingerprint::text(start::fingerprint(text))).unwrap()
}

/// GAIN of a new instance, or what the library says instead.
fn gain(guid: &CString, location: &[u8]) -> Result<f64, String> {
    let log = Log::default();
    let callbacks = logging_callbacks(&log);
    let location = CString::new(location).unwrap();
    // SAFETY: all pointers point to what the functions take; the instance is freed.
    unsafe {
        let component = ffi::fmi2Instantiate::<ContC>(
            c"x".as_ptr(),
            1,
            guid.as_ptr(),
            location.as_ptr(),
            (&raw const callbacks).cast(),
            0,
            0,
        );
        if component.is_null() {
            let [entry] = log.take().try_into().unwrap();
            assert_eq!((entry.status, entry.category.as_str()), (Status::Error, "logStatusError"));
            return Err(entry.text);
        }
        let (reference, mut gain) = (ContC::TABLE.find("GAIN").unwrap() as u32, 0.0);
        let status = ffi::fmi2GetReal::<ContC>(component, &raw const reference, 1, &raw mut gain);
        assert_eq!(status, 0);
        ffi::fmi2FreeInstance::<ContC>(component);
        Ok(gain)
    }
}

fn uri(folder: &Path) -> Vec<u8> {
    format!("file:///{}", folder.display().to_string().trim_start_matches('/')).into_bytes()
}

#[test]
fn an_instance_starts_from_the_values_that_belong_to_its_guid() {
    let folder = tempfile::tempdir().unwrap();
    let text = start_text();
    fs::write(folder.path().join(start::FILE), &text).unwrap();
    assert_eq!(gain(&guid(text.as_bytes()), &uri(folder.path())), Ok(3.0));
    let own = CString::new(Guid::<ContC>::TEXT).unwrap();
    assert_eq!(gain(&own, &uri(folder.path())), Ok(2.0), "the library's own GUID needs no file");
}

#[test]
fn start_values_that_do_not_fit_the_block_are_refused_though_the_guid_is_right() {
    let folder = tempfile::tempdir().unwrap();
    for (from, to, reason) in [
        ("GAIN = 3.0", "GAINS = 3.0", "CONT_C has no setting \"GAINS\""),
        ("GAIN = 3.0", "GAIN = NaN", "GAIN = NaN: a REAL accepts finite numbers"),
        ("GAIN = 3.0\n", "", "GAIN is missing"),
        ("GAIN = 3.0", "TI = 3.0", "occurs twice"),
        ("CYCLE = 1.0", "CYCLE = 0.0", "must be at least 0.001 s"),
        ("preset = TIC101\n", "", "line 1 is"),
        (Guid::<ContC>::TEXT, "{00000000-0000-0000-0000-000000000000}", "the start values are for CONT_C {00000000"),
    ] {
        let text = start_text().replace(from, to);
        assert_ne!(text, start_text(), "{from}");
        fs::write(folder.path().join(start::FILE), &text).unwrap();
        let refusal = gain(&guid(text.as_bytes()), &uri(folder.path())).unwrap_err();
        assert!(refusal.contains(reason), "{refusal}");
    }
}

#[test]
fn any_start_values_are_refused_or_right() {
    let folder = tempfile::tempdir().unwrap();
    let text = start_text().into_bytes();
    let guid = guid(&text);
    let mut random = Random::new(1);
    for _ in 0..500 {
        let mut bytes = text.clone();
        for _ in 0..=random.below(3) {
            let place = random.below(bytes.len());
            match random.below(3) {
                0 => bytes[place] = random.below(256) as u8,
                1 => bytes.truncate(place + 1),
                _ => bytes.insert(place, random.below(256) as u8),
            }
        }
        fs::write(folder.path().join(start::FILE), &bytes).unwrap();
        let gain = gain(&guid, &uri(folder.path()));
        assert_eq!(gain.is_ok(), bytes == text, "{:?}", String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn any_location_is_answered_with_a_refusal_of_one_line() {
    let guid = guid(start_text().as_bytes());
    let pieces: [&[u8]; 12] =
        [b"file:", b"//", b"/", b"\\", b"%", b"%00", b"%ff", b"\xff", b"C:", b"localhost", b"../", b"http://"];
    let mut random = Random::new(2);
    for _ in 0..2000 {
        let location: Vec<u8> = (0..random.below(12)).flat_map(|_| random.pick(&pieces).to_vec()).collect();
        let refusal = gain(&guid, &location).unwrap_err();
        assert!(refusal.starts_with("fmi2Instantiate: fmuGUID = ") && !refusal.contains('\n'), "{refusal}");
        assert!(refusal.len() < 2000, "{refusal}");
    }
    assert!(gain(&guid, &vec![b'%'; 1 << 20]).unwrap_err().contains("at most 32768 are accepted"));
    assert!(gain(&guid, &vec![b'/'; 32_000]).is_err());
}
