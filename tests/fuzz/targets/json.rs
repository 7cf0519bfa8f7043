//! Reads any bytes as JSON.

#![no_main]

mod round_trip;

use libfuzzer_sys::fuzz_target;
use parameters::{Format, Options};

fuzz_target!(|bytes: &[u8]| round_trip::check(Format::Json, bytes, &Options::default()));
