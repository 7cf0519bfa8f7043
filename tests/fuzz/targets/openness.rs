//! Reads any bytes as TIA Openness XML.

#![no_main]

mod round_trip;

use libfuzzer_sys::fuzz_target;
use parameters::{Format, Options};

fuzz_target!(|bytes: &[u8]| round_trip::check(Format::Openness, bytes, &Options::default()));
