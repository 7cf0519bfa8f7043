//! Reads any bytes as a modelDescription.xml: a sentence or a description, and what was read is written and read again
//! as the same.

#![no_main]

use libfuzzer_sys::fuzz_target;
use modeldescription::v2::{check, read, write};

fuzz_target!(|bytes: &[u8]| {
    match read(bytes) {
        Ok(description) => {
            check(&description);
            let xml = write(&description);
            let again = read(&xml).unwrap_or_else(|error| panic!("{error}:\n{}", String::from_utf8_lossy(&xml)));
            // Not the descriptions are compared: NaN, which XML has too, is not equal to itself.
            assert!(write(&again) == xml, "{}", String::from_utf8_lossy(&xml));
        }
        Err(error) => assert!(!error.to_string().is_empty() && error.to_string().len() < 2000),
    }
});
