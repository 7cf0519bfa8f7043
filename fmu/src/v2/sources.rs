//! An FMU as one file of C: what it calls, its table, and the door, which is written once by hand in `c/`.
//!
//! What it calls comes as C already: with `memory_t`, `call_t`, a function `start`, and one for a call. The door keeps the same
//! promises as the library in Rust, and a self-test compares both: the hash of a tape of calls stands in the file.

use crate::cyclic::Cyclic;
use blocks::table::fingerprint::{self, BASIS};
use blocks::table::number::{number, to_value};
use blocks::{Class, Kind, Role, Row, Table};
use std::fmt::Write;

/// The parts of the door, in order.
const DOOR: [&str; 5] = [
    include_str!("c/messages.c"),
    include_str!("c/values.c"),
    include_str!("c/steps.c"),
    include_str!("c/states.c"),
    include_str!("c/functions.c"),
];

/// A header with what of FMI the file needs, for those who have none. It is not for FMUs, where it would stand before the host's.
pub const HEADER: &str = include_str!("c/fmi2Functions.h");

/// The name under which the file includes the header.
pub const HEADER_NAME: &str = "fmi2Functions.h";

/// The calls of the self-test.
const CALLS: u32 = 64;

/// When a variable is given what the host has set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Given {
    /// At once.
    #[default]
    AtOnce,
    /// Before each call, because the program writes it, too.
    EachCall,
    /// At the start, because it keeps its value in a power failure.
    AtStart,
}

/// What an FMU in C is made of.
#[derive(Debug)]
pub struct Parts<'a> {
    /// Its variables.
    pub table: &'a Table,
    /// What the GUID is made of.
    pub hash: u128,
    /// What it calls, as C.
    pub law: &'a str,
    /// The name of the function of a call.
    pub call: &'a str,
    /// The name of the function that is called once at the start.
    pub startup: Option<&'a str>,
    /// Where each variable lies in the memory, in bytes, and when it is given what the host has set; of the cycle, anything.
    pub places: &'a [(usize, Given)],
    /// The size of the memory in bytes.
    pub memory: usize,
    /// Where the program has the time between two calls for itself.
    pub own_cycle: Option<usize>,
    /// The sources, for messages.
    pub files: &'a [String],
    /// The most statements in a call.
    pub budget: u32,
    /// How many calls the self-test makes, and the hash of what they give: see [`tape`].
    pub tape: (u32, u128),
}

/// The file.
pub fn file(parts: &Parts) -> String {
    let name = parts.table.name;
    let version = env!("CARGO_PKG_VERSION");
    let mut text = format!(
        "/* {name}: an FMU for co-simulation (FMI 2.0) in one file of C99, which is C++, too. Made by plcfmu {version}.

   1. What is called: the types, the operations, the functions
   2. The table: the variables that a host sees
   3. The door: FMI 2.0 over both, the same in every FMU

   Compile it with FMI's header fmi2Functions.h, which a host has, and without options that change results: it says so itself. The
   names of its functions begin with {name}_ unless FMI2_FUNCTION_PREFIX is defined, or DISABLE_PREFIX for none, as in a shared
   library. Instances are allocated, or lie in a static pool of PLCFMU_MAX_INSTANCES. */

#if !defined(FMI2_FUNCTION_PREFIX) && !defined(DISABLE_PREFIX)
#define FMI2_FUNCTION_PREFIX {name}_
#endif
#include \"fmi2Functions.h\"

#include <stdlib.h>

#if defined(__GNUC__)
#define PROGRAM static __attribute__((unused))
#else
#define PROGRAM static
#endif

{}
",
        parts.law.trim_end()
    );
    text.push_str(&table(parts));
    DOOR.iter().for_each(|part| text.push_str(part));
    text
}

/// The table as C.
fn table(parts: &Parts) -> String {
    let Parts { table, hash, files, memory, budget, tape: (calls, test), .. } = parts;
    let (name, cycle) = (table.name, &table.rows[table.cycle]);
    let mut text = format!(
        "
/* ------------------------------------------------------------------------------------------------------------------------
   The table: what a host sees. */

#define PLCFMU_NAME {name:?}
#define PLCFMU_GUID {:?}
#define PLCFMU_ROWS {}u
#define PLCFMU_CYCLE_ROW {}u
#define PLCFMU_CYCLE_NAME {:?}
#define PLCFMU_CYCLE {} /* ms */
#define PLCFMU_MEMORY {memory}u /* bytes */
#define PLCFMU_BUDGET {budget} /* statements in a call */
#define PLCFMU_IN_OUTS {} /* whether there are variables that the host sets and the program writes */
#define PLCFMU_MAY_STOP {} /* whether a call can be stopped: by an index out of bounds, or a loop without end */
#define PLCFMU_CALL {}
#define PLCFMU_TEST_CALLS {calls}
#define PLCFMU_TEST_HIGH {:#x}u
#define PLCFMU_TEST_LOW {:#x}u
",
        String::from_utf8_lossy(&fingerprint::text(*hash)),
        table.rows.len(),
        table.cycle,
        cycle.full_name(),
        (number(cycle.start) * 1000.0).round(),
        u8::from(parts.places.iter().any(|(_, given)| *given == Given::EachCall)),
        u8::from(["index_of(", "goes_on(", "stop("].iter().any(|stop| parts.law.contains(stop))),
        parts.call,
        (test >> 64) as u64,
        *test as u64,
    );
    if let Some(startup) = parts.startup {
        let _ = writeln!(text, "#define PLCFMU_STARTUP {startup} /* called once at the start */");
    }
    if let Some(offset) = parts.own_cycle {
        let _ = writeln!(text, "#define PLCFMU_OWN_CYCLE {offset} /* where the program has it for itself */");
    }
    let fingerprint: Vec<String> = hash.to_be_bytes().iter().map(|byte| format!("{byte:#04x}")).collect();
    let _ = writeln!(text, "\n/* The GUID as bytes. */");
    let _ = writeln!(text, "static const unsigned char plcfmu_fingerprint[16] = {{{}}};", fingerprint.join(", "));
    let files: Vec<String> = files.iter().map(|file| quoted(file)).collect();
    let _ = writeln!(text, "\n/* The sources, for messages. */");
    let _ = writeln!(text, "static const char *const plcfmu_files[] = {{{}}};", files.join(", "));
    kinds(&mut text);
    rows(&mut text, parts);
    text
}

/// The PLC types.
fn kinds(text: &mut String) {
    let constants: Vec<String> = Kind::ALL.iter().map(|kind| format!("PLCFMU_{}", kind.name())).collect();
    let _ = writeln!(text, "\n/* The PLC types, and what FMI takes them for: 0 Real, 1 Integer, 2 Boolean. */");
    let _ = writeln!(text, "enum {{\n    {}\n}};", constants.join(", "));
    text.push_str(
        "
typedef struct {
    int of;
    size_t size;    /* bytes */
    double lowest;  /* of an integer; an LTIME in nanoseconds */
    double highest;
    const char *takes;
} plcfmu_kind_t;

static const plcfmu_kind_t plcfmu_kinds[] = {
",
    );
    for kind in Kind::ALL {
        let of = match kind.class() {
            Class::Real => 0,
            Class::Integer => 1,
            Class::Boolean => 2,
        };
        // Up to here all integers are numbers of binary64.
        let exact = 1_i128 << 53;
        let (low, high) = match kind {
            Kind::Word => (-32768, 65535),
            Kind::Int => (-32768, 32767),
            Kind::Bool => (0, 1),
            // It may be given as a signed number, too.
            Kind::DWord => (i32::MIN.into(), u32::MAX.into()),
            kind => kind.whole().map_or((0, 0), |(low, high)| (low.max(-exact), high.min(exact))),
        };
        let (size, takes) = (kind.width().max(1), kind.takes());
        let _ = writeln!(text, "    {{{of}, {size}, {low}.0, {high}.0, {takes:?}}}, /* {} */", kind.name());
    }
    text.push_str("};\n");
}

/// The variables.
fn rows(text: &mut String, parts: &Parts) {
    text.push_str(
        "
/* When a variable is given what the host has set, if not at once. */
enum { PLCFMU_EACH_CALL = 1, PLCFMU_AT_START = 2 };

/* What the variables are for the host. */
enum { PLCFMU_INPUT, PLCFMU_PARAMETER, PLCFMU_FIXED, PLCFMU_CYCLE_TIME, PLCFMU_OUTPUT, PLCFMU_LOCAL };

/* A variable; its value reference is its place in the table. */
typedef struct {
    const char *name;
    int kind;
    int role;
    int held;      /* 0, PLCFMU_EACH_CALL or PLCFMU_AT_START */
    size_t offset; /* in the memory, bytes */
    double low;    /* what the self-test gives a floating-point input */
    double high;
} plcfmu_row_t;

static const plcfmu_row_t plcfmu_rows[] = {
",
    );
    for (index, row) in parts.table.rows.iter().enumerate() {
        let (offset, given) = parts.places.get(index).copied().unwrap_or_default();
        let role = match row.role {
            Role::Input => "INPUT",
            Role::Parameter => "PARAMETER",
            Role::Fixed => "FIXED",
            Role::Cycle => "CYCLE_TIME",
            Role::Output => "OUTPUT",
            Role::Local => "LOCAL",
        };
        let (low, high) = range(row);
        let _ = writeln!(
            text,
            "    {{{}, PLCFMU_{}, PLCFMU_{role}, {}, {offset}, {low:?}, {high:?}}}, /* {index} */",
            quoted(&row.full_name()),
            row.kind.name(),
            given as u8,
        );
    }
    text.push_str("};\n");
}

/// A text as C has it.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for byte in text.bytes() {
        match byte {
            b'"' | b'\\' => quoted.extend(['\\', char::from(byte)]),
            b' '..=b'~' => quoted.push(char::from(byte)),
            // Three digits, so that none behind it belongs to it.
            other => {
                let _ = write!(quoted, "\\{other:03o}");
            }
        }
    }
    quoted.push('"');
    quoted
}

/// Between which numbers the self-test draws a floating-point input.
fn range(row: &Row) -> (f64, f64) {
    match (row.least(), row.greatest()) {
        (Some(low), Some(high)) if row.kind.class() == Class::Real => (low, high),
        _ => (-100.0, 100.0),
    }
}

/// Makes the calls of the self-test, up to one that stops the program, with inputs that are drawn. Says how many they are, and the
/// hash of all variables after each.
pub fn tape<B: Cyclic>(mut block: B) -> (u32, u128) {
    let rows = block.table().rows.to_vec();
    let (mut seed, mut hash) = (1_u32, BASIS);
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        seed >> 8
    };
    block.restart();
    for call in 0..CALLS {
        for (index, row) in rows.iter().enumerate().filter(|(_, row)| row.role == Role::Input) {
            // Each input changes in one of four calls.
            if next() >= 1 << 22 && call > 0 {
                continue;
            }
            if let Ok(value) = to_value(drawn(row, f64::from(next())), row.kind) {
                block.set(index, value);
            }
        }
        block.call();
        if block.stopped().is_some() {
            return (call, hash);
        }
        for index in 0..rows.len() {
            let value = block.get(index).map_or(0.0, number);
            // Processors differ in the bits of what is not a number.
            let value = if value.is_nan() { f64::NAN } else { value };
            hash = fingerprint::hash(hash, &value.to_bits().to_le_bytes());
        }
    }
    (CALLS, hash)
}

/// An input of the tape, of a number from 0 to 2^24 - 1.
fn drawn(row: &Row, number: f64) -> f64 {
    match row.kind {
        Kind::Bool if number < 8_388_608.0 => 0.0,
        Kind::Bool => 1.0,
        Kind::Real | Kind::LReal => {
            let (low, high) = range(row);
            low + (high - low) * (number / 16_777_216.0)
        }
        Kind::Time | Kind::LTime => (number / 4096.0).floor() / 1000.0,
        _ => (number / 167_773.0).floor(),
    }
}
