//! Source texts designed to exhaust memory or time. Each has 100 kB, or the number of megabytes in
//! PLCFMU_HOSTILE_MEGABYTES; time and memory are printed, and the test only checks that each text results in a
//! sentence:
//!
//!     PLCFMU_HOSTILE_MEGABYTES=100 cargo test --release --package parameters --test hostile -- --nocapture

use blocks::{Kind, Role, Row, Time, Value};
use parameters::{BlockType, Format, Options, Source, problem, read};
use std::fs;
use std::sync::Arc;
use std::time::Instant;

fn pump() -> Arc<BlockType> {
    let members = vec![
        Row::new("CYCLE", Role::Cycle, Value::Time(Time::ms(1000))),
        Row::new("GAIN", Role::Parameter, Value::zero(Kind::Real)),
        Row::new("LMN", Role::Output, Value::zero(Kind::Real)),
    ];
    Arc::new(BlockType::new("PUMP".into(), vec!["FB 41".into()], members))
}

/// Returns the size of the texts.
fn bytes() -> usize {
    std::env::var("PLCFMU_HOSTILE_MEGABYTES")
        .map_or(100_000, |text| text.parse::<usize>().expect("a number") * 1_000_000)
}

/// Returns a text that repeats a part between a start and an end.
fn repeated(start: &str, part: &str, end: &str) -> String {
    let count = bytes().saturating_sub(start.len() + end.len()) / part.len();
    [start, &part.repeat(count), end].concat()
}

/// Like [`repeated`], with a number in each part.
fn numbered(start: &str, part: impl Fn(usize) -> String, end: &str) -> String {
    let mut text = start.to_string();
    for number in 0.. {
        if text.len() + end.len() >= bytes() {
            break;
        }
        text.push_str(&part(number));
    }
    text + end
}

/// Returns the peak memory of the process since the last call, in MB; Linux only.
fn peak_memory() -> Option<usize> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: usize = line.trim().strip_suffix(" kB")?.parse().ok()?;
    fs::write("/proc/self/clear_refs", "5").ok()?;
    Some(kilobytes / 1000)
}

/// Returns the processor time of this thread in seconds, which does not depend on other load; Linux only.
fn processor_time() -> Option<f64> {
    let statistics = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(statistics.split(' ').next()?.parse::<f64>().ok()? / 1e9)
}

#[track_caller]
fn assert_ends(what: &str, text: String, part: &str) {
    let length = text.len();
    peak_memory();
    let (start, processor_start) = (Instant::now(), processor_time());
    let source = Source::new("plant.awl", text.into_bytes());
    let told = match read(Format::Step7, &source, &[pump()], &Options::default()) {
        Ok(reading) => format!("{} loops", reading.loops.len()),
        Err(problems) => problem::drawn(&problems),
    };
    let memory = peak_memory().map_or(String::new(), |megabytes| format!(", {megabytes} MB of memory"));
    let seconds = match (processor_start, processor_time()) {
        (Some(start), Some(end)) => end - start,
        _ => start.elapsed().as_secs_f64(),
    };
    println!("{what}: {:.1} MB in {seconds:.2} s{memory}", length as f64 / 1e6);
    assert!(told.contains(part), "{what}: {told}");
    assert!(told.len() < 50_000, "{what}: {} bytes of messages", told.len());
}

#[test]
fn hostile_texts_end_in_a_sentence() {
    const BEGIN: &str = "DATA_BLOCK DB1 PUMP BEGIN ";
    const END: &str = "; END_DATA_BLOCK";
    assert_ends("one long line of values", repeated(BEGIN, "LNM:=2.0;", END), " more, not shown");
    assert_ends("a comment", repeated("(*", "x*", &format!("*){BEGIN}{END}")), "1 loops");
    assert_ends("a comment without end", repeated("(*", "(*", ""), "this comment is not closed");
    assert_ends("a name", repeated(BEGIN, "GAIN", &format!(":=1.0{END}")), "PUMP has no member");
    assert_ends("a name of a data block", repeated("DATA_BLOCK ", "TIC1", " PUMP BEGIN END_DATA_BLOCK"), "1 loops");
    assert_ends("a type", repeated("DATA_BLOCK DB1 ", "PUMP", " BEGIN END_DATA_BLOCK"), "which is not a known block");
    assert_ends("a name of many parts", repeated(BEGIN, "a.", &format!("a:=1.0{END}")), "at most 40 parts");
    assert_ends("a REAL of many digits", repeated(&format!("{BEGIN}GAIN:=0."), "3", END), "1 loops");
    assert_ends(
        "a TIME of many digits",
        repeated(&format!("{BEGIN}CYCLE:=T#"), "9", &format!("S{END}")),
        "a TIME from T#-24D",
    );
    assert_ends("a TIME of many units", repeated(&format!("{BEGIN}CYCLE:=T#"), "1S", END), "expected a TIME");
    assert_ends("braces", repeated(BEGIN, "{", END), "expected");
    assert_ends("quotes", repeated(BEGIN, "\"", END), "expected `:=` after");
    assert_ends("apostrophes in lines", repeated(BEGIN, "'\n", END), " more, not shown");
    assert_ends("titles", repeated(BEGIN, "TITLE\n", END), " more, not shown");
    assert_ends("blank lines", repeated(BEGIN, "\n", END), "1 loops");
    assert_ends(
        "nested structures",
        repeated("FUNCTION_BLOCK FB 1\nVAR a : ", "STRUCT ", "END_VAR END_FUNCTION_BLOCK"),
        "no instance data block",
    );
    assert_ends(
        "members of a function block",
        numbered(
            "FUNCTION_BLOCK FB 1\nVAR ",
            |number| format!("a{number}:PUMP;"),
            "\nEND_VAR\nEND_FUNCTION_BLOCK\nDATA_BLOCK DB1 FB1 BEGIN END_DATA_BLOCK",
        ),
        // 100 kB contain 9184 loops; a larger text has too many.
        if bytes() <= 100_000 { "9184 loops" } else { "split it" },
    );
    assert_ends(
        "function blocks that double their instances",
        numbered(
            "FUNCTION_BLOCK FB 0\nVAR a,b,c,d,e,f,g,h:PUMP; END_VAR END_FUNCTION_BLOCK\n",
            |number| {
                let (function, inner) = (number + 1, number);
                format!(
                    "FUNCTION_BLOCK FB {function}\nVAR a,b,c,d,e,f,g,h:FB {inner}; END_VAR END_FUNCTION_BLOCK\nDATA_BLOCK DB{function} FB{function} BEGIN END_DATA_BLOCK\n"
                )
            },
            "",
        ),
        "loops",
    );
    assert_ends(
        "loops",
        numbered("", |number| format!("DATA_BLOCK DB{number} PUMP BEGIN END_DATA_BLOCK\n"), ""),
        "loops",
    );
    assert_ends(
        "data blocks of another type",
        repeated("", "DATA_BLOCK A B BEGIN x:=1;y.z:=2; END_DATA_BLOCK\n", ""),
        "B",
    );
    assert_ends("a million errors", repeated("", "DATA_BLOCK ;\n", ""), " more, not shown");
    assert_ends(
        "groups of members",
        numbered(
            "",
            |number| {
                let values: String =
                    (0..500).map(|value| format!("a{value}.GAIN:=1.0;a{value}.CYCLE:=T#1S;")).collect();
                format!("DATA_BLOCK DB{number} FB900 BEGIN {values} END_DATA_BLOCK\n")
            },
            "",
        ),
        "FB900",
    );
}
