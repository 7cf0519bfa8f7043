//! Describes how a process ended.

use std::io::Read;
use std::process::ExitStatus;

/// The maximum amount of FMU output that is kept, in bytes.
const MOST_PRINTED: usize = 4096;

/// Reads a stream to its end and returns the last [`MOST_PRINTED`] bytes, or all if there are fewer.
pub(super) fn last_bytes(mut from: impl Read) -> Vec<u8> {
    let (mut last, mut read) = (Vec::new(), [0; MOST_PRINTED]);
    while let Ok(count @ 1..) = from.read(&mut read) {
        last.extend_from_slice(&read[..count]);
        last.drain(..last.len().saturating_sub(MOST_PRINTED));
    }
    last
}

/// A description of how a process ended, worded to follow the name of the FMU.
pub(super) fn how(status: Option<ExitStatus>) -> String {
    let Some(status) = status else { return "ended its process".into() };
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("crashed: signal {signal} ({})", signal_name(signal));
    }
    match status.code() {
        // The exit code after a crash is the status code of the exception: negative, because its severity is "error".
        Some(code) if cfg!(windows) && code < 0 => format!("crashed: exception {:#010x}", code as u32),
        Some(code) => format!("ended its process with exit code {code}"),
        None => format!("ended its process with {status}"),
    }
}

#[cfg(unix)]
fn signal_name(signal: i32) -> &'static str {
    match signal {
        4 => "illegal instruction",
        5 => "trap",
        6 => "abort",
        8 => "arithmetic error",
        9 => "kill",
        11 => "segmentation fault",
        15 => "termination",
        7 | 10 => "bus error",
        _ => "see kill -l",
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::process::ExitStatusExt;

    #[test]
    fn the_end_of_a_process_is_said_in_words() {
        let how = |raw| how(Some(ExitStatus::from_raw(raw)));
        assert_eq!(how(11), "crashed: signal 11 (segmentation fault)");
        assert_eq!(how(3 << 8), "ended its process with exit code 3");
    }

    #[test]
    fn the_last_bytes_of_a_long_text_are_kept() {
        let text: Vec<u8> = (0..3 * MOST_PRINTED + 7).map(|place| place as u8).collect();
        assert_eq!(last_bytes(&text[..]), text[text.len() - MOST_PRINTED..]);
        assert_eq!(last_bytes(&text[..5]), text[..5]);
    }
}
