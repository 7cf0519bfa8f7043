//! An FMU as one C file: the code it calls, its table, and the door. The parts of the door are handwritten C files,
//! next to this file and in the folders of the FMI versions.
//!
//! The code it calls is already C: `memory_t`, `call_t`, a function `start`, and one for a call. The door behaves like
//! the Rust library, and a self-test compares the two: the file contains the hash of the library's results in a fixed
//! sequence of calls, the tape.

use crate::cyclic::Cyclic;
use crate::layout::{Layout, Referent};
use crate::messages::{self, Message};
use crate::state::{Function, State};
use blocks::table::fingerprint::{self, BASIS};
use blocks::table::number::{number, to_value};
use blocks::{Class, Kind, Role, Row, Text};
use std::fmt::Write;

/// The functions that compose messages.
const PIECES: &str = include_str!("messages.c");

/// The parts of every door, in order, after a version's names, functions and messages.
const DOOR: [&str; 5] = [
    include_str!("calls.c"),
    include_str!("values.c"),
    include_str!("steps.c"),
    include_str!("states.c"),
    include_str!("variables.c"),
];

/// The door's data types, between a version's names and its functions.
const DATA: &str = include_str!("data.c");

/// The code for texts, or for their absence.
const TEXTS: [&str; 2] = [include_str!("texts.c"), include_str!("no_texts.c")];

/// What a host can request of an instance, in any version of the standard.
const INSTANCE: &str = include_str!("instance.c");

/// Calls as events, for versions that have them.
pub(crate) const EVENTS: &str = include_str!("events.c");

/// The door of one version of the standard, and how this version describes variables.
#[derive(Debug)]
pub struct Door {
    /// The standard with its version.
    pub standard: &'static str,
    /// The name of the standard's header in the `#include` line.
    pub header_name: &'static str,
    /// A header with the standard's declarations that the file needs, for users without the original. It is not packed
    /// into FMUs, where it would shadow the host's.
    pub header: &'static str,
    /// The macro that holds the function name prefix.
    pub(crate) prefix: &'static str,
    /// The version's definitions of names used in the rest of the file.
    pub(crate) names: &'static str,
    /// Its functions with the states in which they are allowed.
    pub(crate) table: &'static [Function],
    /// Its messages, in addition to the shared ones.
    pub(crate) messages: &'static [Message],
    /// The C source of its functions, the last part of the file.
    pub(crate) functions: [&'static str; 2],
    /// The names of its types, in the order of their numbers in the C file.
    pub(crate) types: &'static [&'static str],
    /// Returns the name of a variable's type.
    pub(crate) type_of: fn(&Row) -> &'static str,
    /// Whether an array is a single variable.
    pub(crate) has_arrays: bool,
    /// Whether a host can query the dependencies of a variable.
    pub(crate) has_dependencies: bool,
    /// Forms the FMU's identifier from the hash of the interface.
    pub(crate) token: fn(u128) -> u128,
}

/// The number of calls in the self-test.
const CALLS: u32 = 256;

/// When a value set by the host is passed to a variable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TakesEffect {
    /// Immediately.
    #[default]
    AtOnce,
    /// Before each call, because the program writes the variable, too.
    EachCall,
    /// At the start, because the variable retains its value during a power failure.
    AtStart,
}

/// The parts of an FMU in C.
#[derive(Debug)]
pub struct Parts<'a> {
    /// The version of the standard.
    pub door: &'static Door,
    /// The name of the block.
    pub name: &'a str,
    /// Its variables.
    pub variables: &'a [Row],
    /// The row number of the time between two calls, and its start value in milliseconds.
    pub cycle: (usize, f64),
    /// The hash of the interface.
    pub hash: u128,
    /// The code it calls, as C.
    pub law: &'a str,
    /// The name of the function that makes a call.
    pub call: &'a str,
    /// For each variable, its address in memory, in bytes, and when it receives the value set by the host. The entry
    /// for a program's cycle is not used.
    pub places: &'a [(usize, TakesEffect)],
    /// The arrays to which value references refer; `None` if there are none.
    pub layout: Option<&'a Layout>,
    /// Its texts, each with its address in memory and its size in bytes.
    pub texts: &'a [(Text, usize, usize)],
    /// The size of the memory in bytes.
    pub memory: usize,
    /// The number of calls in the self-test and the hash of their results: see [`tape`].
    pub tape: (u32, u128),
    /// The parts that depend on the kind of code.
    pub of: Of<'a>,
}

/// The kind of code that is called.
#[derive(Debug)]
pub enum Of<'a> {
    /// A PLC program.
    Program {
        /// The name of the function called once at the start.
        startup: Option<&'a str>,
        /// The address of the program's own variable for the time between two calls, if any.
        own_cycle: Option<usize>,
        /// The source files, for messages.
        files: &'a [String],
        /// The maximum number of statements in a call.
        budget: u32,
    },
    /// A block, whose memory contains the time between two calls.
    Block {
        /// The name of the restart function.
        restart: &'a str,
        /// The addresses of the pulse's mean and of the pulse, and the name of the function that writes the pulse.
        mean: Option<(usize, usize, &'a str)>,
        /// The check of the settings.
        check: Option<Check<'a>>,
        /// The contents of a saved state, in order.
        fields: &'a [Field],
    },
}

/// The check by which a block rejects settings.
#[derive(Debug)]
pub struct Check<'a> {
    /// The name of the function that makes the check.
    pub call: &'a str,
    /// The address of the message number, counted from 1; the number is 0 if the settings are accepted.
    pub refusal: usize,
    /// The address of the numbers in the message, which are consecutive binary64 values.
    pub numbers: usize,
    /// The messages. The characters 1 (omits ".0" of whole numbers) and 2 are placeholders for numbers.
    pub messages: &'a [String],
}

/// A part of memory in a saved state: a number or, for a program, all memory.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its name, for human readers.
    pub name: String,
    /// Its address in memory, in bytes.
    pub offset: usize,
    /// Its size in bytes.
    pub size: usize,
    /// Whether it can only be 0 or 1.
    pub is_truth: bool,
}

/// The FMU as the text of a C file.
pub fn file(parts: &Parts) -> String {
    let Parts { name, door, .. } = parts;
    let Door { standard, header_name, prefix, .. } = door;
    let version = env!("CARGO_PKG_VERSION");
    let mut text = format!(
        "/* {name}: an FMU for co-simulation ({standard}) in one C99 file, which is also valid C++. Made by plcfmu {version}.

   1. The code that is called: the types, the operations, the functions
   2. The table: the variables seen by the host
   3. The door: {standard} for both, identical in every FMU

   Compile it with FMI's header {header_name}, which the host provides, and without options that change results: the
   self-test detects them. Function names begin with {name}_ unless {prefix} is defined, or DISABLE_PREFIX for
   no prefix, as in a shared library. Instances are allocated on the heap, or in a static pool of PLCFMU_MAX_INSTANCES. */

#if !defined({prefix}) && !defined(DISABLE_PREFIX)
#define {prefix} {name}_
#endif
#include \"{header_name}\"

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
    text.push_str(door.names);
    text.push_str(DATA);
    functions(&mut text, door.table);
    text.push_str(PIECES);
    let texts = TEXTS[usize::from(parts.texts.is_empty())];
    let rest = [DOOR.concat().as_str(), texts, INSTANCE, &door.functions.concat()].concat();
    messages(&mut text, door.messages, &rest);
    text.push_str(&rest);
    text
}

/// Appends the functions with the states in which they are allowed, from the library's table.
fn functions(text: &mut String, functions: &[Function]) {
    let names: Vec<String> = functions.iter().map(|function| format!("PLCFMU_OF_{}", &function.name[4..])).collect();
    let states = |function: &Function| {
        let allowed =
            State::LASTING.iter().zip("INECT".chars()).filter(|(state, _)| function.allowed & **state as u8 != 0);
        let all: Vec<String> = allowed.map(|(_, letter)| format!("PLCFMU_{letter}")).collect();
        if all.is_empty() { "0".to_string() } else { all.join(" | ") }
    };
    text.push_str("\n/* The functions and the states in which they are allowed. These are more lenient than the standard because hosts\n   need it: in state instantiated, Get works and returns the start values, and inputs may be set. */\n");
    text.push_str("static const plcfmu_function_t plcfmu_functions[] = {\n");
    for function in functions {
        let _ = writeln!(text, "    {{\"{}\", {}}},", function.name, states(function));
    }
    let lines: Vec<String> = names.chunks(4).map(|line| line.join(", ")).collect();
    let _ = writeln!(text, "}};\n\nenum {{\n    {}\n}};", lines.join(",\n    "));
    text.push_str("\nstatic const plcfmu_state_name_t plcfmu_state_names[] = {\n");
    for (state, letter) in State::LASTING.iter().zip("INECT".chars()) {
        let name = functions.first().map_or("", |function| state.name(function));
        let _ = writeln!(text, "    {{PLCFMU_{letter}, {name:?}}},");
    }
    text.push_str("};\n");
}

/// Appends the messages used in the rest of the file, each as a function that returns the status of a refused call.
fn messages(text: &mut String, own: &[Message], rest: &str) {
    for Message { name, arguments, text: sentence } in messages::ALL.iter().chain(own) {
        if !rest.contains(&format!("plcfmu_say_{name}(")) {
            continue;
        }
        let c_type = |of: &str| match of {
            "f64" => "double ",
            "&str" => "const char *",
            "usize" => "size_t ",
            _ => "i64_t ",
        };
        let given: String = arguments.iter().map(|(argument, of)| format!(", {}{argument}", c_type(of))).collect();
        let _ = writeln!(text, "\nPROGRAM plcfmu_status_t plcfmu_say_{name}(plcfmu_text_t *text{given}) {{");
        for (place, piece) in sentence.split(['{', '}']).enumerate().filter(|(_, piece)| !piece.is_empty()) {
            let argument = piece.trim_end_matches(":?");
            let of = arguments.iter().find(|(known, _)| *known == argument).map_or("", |(_, of)| of);
            let _ = match of {
                _ if place % 2 == 0 => writeln!(text, "    plcfmu_say(text, {});", quoted(piece)),
                "f64" => writeln!(text, "    plcfmu_say_number(text, {argument}, {});", u8::from(argument == piece)),
                "usize" => writeln!(text, "    plcfmu_say_size(text, {argument});"),
                "&str" if argument == piece => writeln!(text, "    plcfmu_say(text, {argument});"),
                "&str" => writeln!(text, "    plcfmu_say_quoted(text, {argument});"),
                _ => writeln!(text, "    plcfmu_say_whole(text, {argument});"),
            };
        }
        text.push_str("    return PLCFMU_REFUSED;\n}\n");
    }
}

/// The table as C.
fn table(parts: &Parts) -> String {
    let Parts { name, variables, cycle: (cycle, period), memory, tape: (calls, test), .. } = parts;
    let hash = (parts.door.token)(parts.hash);
    let budget = match parts.of {
        Of::Program { budget, .. } => budget,
        Of::Block { .. } => u32::MAX,
    };
    let mut text = format!(
        "
/* ------------------------------------------------------------------------------------------------------------------------
   The table: the host's view. */

#define PLCFMU_NAME {name:?}
#define PLCFMU_GUID {:?}
#define PLCFMU_ROWS {}u
#define PLCFMU_CYCLE_ROW {cycle}u
#define PLCFMU_CYCLE_NAME {:?}
#define PLCFMU_CYCLE {period} /* ms */
#define PLCFMU_MEMORY {memory}u /* bytes */
#define PLCFMU_BUDGET {budget} /* statements in a call */
#define PLCFMU_IS_BLOCK {} /* 1: a block, whose memory contains its cycle; 0: a program */
#define PLCFMU_IN_OUTS {} /* whether there are variables that both the host and the program write */
#define PLCFMU_MAY_STOP {} /* whether a call can be stopped: by an index out of bounds or an endless loop */
#define PLCFMU_CALL {}
#define PLCFMU_TEST_CALLS {calls}
#define PLCFMU_TEST_HIGH {:#x}ull
#define PLCFMU_TEST_LOW {:#x}ull
",
        String::from_utf8_lossy(&fingerprint::text(hash)),
        variables.len(),
        variables[*cycle].name,
        u8::from(matches!(parts.of, Of::Block { .. })),
        u8::from(parts.places.iter().any(|(_, given)| *given == TakesEffect::EachCall)),
        u8::from(["index_of(", "goes_on(", "stop("].iter().any(|stop| parts.law.contains(stop))),
        parts.call,
        (test >> 64) as u64,
        *test as u64,
    );
    let fingerprint: Vec<String> = hash.to_be_bytes().iter().map(|byte| format!("{byte:#04x}")).collect();
    let whole = [Field { name: "memory".into(), offset: 0, size: *memory, is_truth: false }];
    let (fields, files): (&[Field], _) = match &parts.of {
        Of::Program { startup, own_cycle, files, .. } => {
            if let Some(startup) = startup {
                let _ = writeln!(text, "#define PLCFMU_STARTUP {startup} /* called once at the start */");
            }
            if let Some(offset) = own_cycle {
                let _ =
                    writeln!(text, "#define PLCFMU_OWN_CYCLE {offset} /* the address of the program's own variable */");
            }
            (&whole, files.iter().map(|file| quoted(file)).collect())
        }
        Of::Block { restart, mean, check, fields } => {
            let _ = writeln!(text, "#define PLCFMU_RESTART {restart}");
            if let Some((mean, pulse, call)) = mean {
                let _ = writeln!(text, "#define PLCFMU_MEAN {mean} /* the address of the pulse's mean in memory */");
                let _ = writeln!(text, "#define PLCFMU_PULSE {pulse}");
                let _ = writeln!(text, "#define PLCFMU_PULSE_CALL {call} /* recomputes the pulse */");
            }
            if let Some(check) = check {
                refusals(&mut text, check);
            }
            (fields, vec![quoted("")])
        }
    };
    let _ = writeln!(text, "\n/* The GUID as bytes. */");
    let _ = writeln!(text, "static const unsigned char plcfmu_fingerprint[16] = {{{}}};", fingerprint.join(", "));
    let _ = writeln!(text, "\n/* The sources, for messages. */");
    let _ = writeln!(text, "static const char *const plcfmu_files[] = {{{}}};", files.join(", "));
    kinds(&mut text);
    rows(&mut text, parts);
    texts(&mut text, parts.texts);
    references(&mut text, parts);
    saved(&mut text, fields);
    text
}

/// Appends the reasons why a block rejects settings.
fn refusals(text: &mut String, check: &Check) {
    let _ =
        writeln!(text, "#define PLCFMU_CHECK {} /* rejects settings with which the block cannot run */", check.call);
    let _ =
        writeln!(text, "#define PLCFMU_REFUSAL {} /* the address of the message number, 0 for none */", check.refusal);
    let _ = writeln!(
        text,
        "#define PLCFMU_REFUSAL_NUMBERS {} /* the address of the numbers in the message */",
        check.numbers
    );
    let _ = writeln!(text, "\n/* The messages; \\001 and \\002 stand for the numbers. */");
    let messages: Vec<String> = check.messages.iter().map(|message| format!("    {},\n", quoted(message))).collect();
    let _ = writeln!(text, "static const char *const plcfmu_refusals[] = {{\n{}}};", messages.concat());
}

/// Appends the contents of a saved state.
fn saved(text: &mut String, fields: &[Field]) {
    text.push_str(
        "
/* The parts of memory in a saved state, in this order. */
typedef struct {
    size_t offset; /* bytes */
    size_t size;
    int is_truth;  /* whether it can only be 0 or 1 */
} plcfmu_field_t;

static const plcfmu_field_t plcfmu_fields[] = {
",
    );
    for Field { name, offset, size, is_truth } in fields {
        let _ = writeln!(text, "    {{{offset}, {size}, {}}}, /* {name} */", u8::from(*is_truth));
    }
    text.push_str("};\n");
}

/// Appends the PLC types.
fn kinds(text: &mut String) {
    let constants: Vec<String> = Kind::ALL.iter().map(|kind| format!("PLCFMU_{}", kind.name())).collect();
    let _ = writeln!(text, "\n/* The PLC types. */");
    let _ = writeln!(text, "enum {{\n    {}\n}};", constants.join(", "));
    text.push_str(
        "
typedef struct {
    size_t size;    /* bytes */
    double lowest;  /* range of an integer or, in nanoseconds, of an LTIME */
    double highest;
    const char *takes;
} plcfmu_kind_t;

static const plcfmu_kind_t plcfmu_kinds[] = {
",
    );
    for kind in Kind::ALL {
        // Up to this value, binary64 represents every integer exactly.
        let exact = 1_i128 << 53;
        let (low, high) = match kind {
            Kind::Word => (-32768, 65535),
            Kind::Int => (-32768, 32767),
            Kind::Bool => (0, 1),
            // A host may also pass a DWORD as a signed number.
            Kind::DWord => (i32::MIN.into(), u32::MAX.into()),
            kind => kind.whole().map_or((0, 0), |(low, high)| (low.max(-exact), high.min(exact))),
        };
        let (size, takes) = (kind.width().max(1), kind.takes());
        let _ = writeln!(text, "    {{{size}, {low}.0, {high}.0, {takes:?}}}, /* {} */", kind.name());
    }
    text.push_str("};\n");
}

/// Appends the variables.
fn rows(text: &mut String, parts: &Parts) {
    text.push_str(
        "
/* When a variable receives the value set by the host, if not immediately. */
enum { PLCFMU_EACH_CALL = 1, PLCFMU_AT_START = 2 };

/* The roles of variables for the host. */
enum { PLCFMU_INPUT, PLCFMU_PARAMETER, PLCFMU_FIXED, PLCFMU_CYCLE_TIME, PLCFMU_OUTPUT, PLCFMU_LOCAL };

/* A variable; its value reference is its index in the table. */
typedef struct {
    const char *name;
    int kind;
    int type;      /* the host's type: its index in plcfmu_types */
    int role;
    int held;      /* 0, PLCFMU_EACH_CALL or PLCFMU_AT_START */
    size_t offset; /* in memory, bytes */
    double low;    /* the self-test's range for a floating-point number or a time parameter */
    double high;
} plcfmu_row_t;

static const plcfmu_row_t plcfmu_rows[] = {
",
    );
    let door = parts.door;
    for (index, row) in parts.variables.iter().enumerate() {
        let (offset, given) = parts.places.get(index).copied().unwrap_or_default();
        let role = word(row.role);
        let type_name = (door.type_of)(row);
        let place = door.types.iter().position(|known| *known == type_name).unwrap_or_default();
        let (low, high) = range(row);
        let _ = writeln!(
            text,
            "    {{{}, PLCFMU_{}, {place}, PLCFMU_{role}, {}, {offset}, {low:?}, {high:?}}}, /* {index} */",
            quoted(&row.name),
            row.kind.name(),
            given as u8,
        );
    }
    text.push_str("};\n");
    let types: Vec<String> = door.types.iter().map(|name| format!("{name:?}")).collect();
    let _ = writeln!(
        text,
        "\n/* The host's types. */\nstatic const char *const plcfmu_types[] = {{{}}};",
        types.join(", ")
    );
}

/// Appends the array elements to which value references refer, and the dependencies of outputs.
fn references(text: &mut String, parts: &Parts) {
    let Parts { door, variables, layout, .. } = parts;
    let layout = layout.filter(|_| door.has_arrays);
    let count = variables.len() + parts.texts.len();
    let _ = writeln!(text, "\n#define PLCFMU_HAS_ARRAYS {}", u8::from(layout.is_some()));
    if door.has_arrays || door.has_dependencies {
        let _ = write!(
            text,
            "#define PLCFMU_REFERENCES {count}u /* of variables and texts */

/* A range of list entries. */
typedef struct {{
    size_t count;
    u32_t first;
}} plcfmu_part_t;
"
        );
    }
    let one = |reference: u32| match layout.map(|layout| layout.part(reference)) {
        Some(Referent::Array(elements)) => elements.clone(),
        Some(Referent::Inside(_)) => Vec::new(),
        _ => vec![reference],
    };
    let array = |reference: u32| match layout.map(|layout| layout.part(reference)) {
        Some(Referent::Inside(first)) => *first,
        _ => reference,
    };
    let all: Vec<Vec<u32>> = (0..count as u32).map(one).collect();
    if layout.is_some() {
        let of = "The elements of each variable; any element but the first has count 0 and its array's reference";
        lists(text, of, ("plcfmu_parts", "plcfmu_elements"), &all, |reference| Some(array(reference as u32)));
    }
    if door.has_dependencies {
        let is_output = |reference: usize| match variables.get(reference) {
            Some(row) => row.role == Role::Output,
            None => parts.texts[reference - variables.len()].0.role == Role::Output,
        };
        let outputs: Vec<String> =
            all.iter().enumerate().map(|(at, of)| u8::from(!of.is_empty() && is_output(at)).to_string()).collect();
        let _ = writeln!(text, "\n/* Whether a variable is an output. */");
        let _ = writeln!(text, "static const unsigned char plcfmu_is_output[] = {{{}}};", outputs.join(", "));
        let depends = |of: &Vec<u32>| {
            let settings = of.iter().filter_map(|element| variables.get(*element as usize)).flat_map(|row| &row.from);
            let mut found: Vec<u32> = settings.map(|setting| array(*setting as u32)).collect();
            found.sort_unstable();
            found.dedup();
            found
        };
        let depends: Vec<Vec<u32>> = all.iter().map(depends).collect();
        let of = "The settings on which the value of each output after a restart depends";
        lists(text, of, ("plcfmu_depends", "plcfmu_independents"), &depends, |_| None);
    }
}

/// Appends lists of numbers, concatenated, with the position of each; `instead` returns the position for an empty list.
fn lists(
    text: &mut String,
    of: &str,
    (places, list): (&str, &str),
    lists: &[Vec<u32>],
    instead: impl Fn(usize) -> Option<u32>,
) {
    let mut first = 0;
    let _ = writeln!(text, "\n/* {of}. */\nstatic const plcfmu_part_t {places}[] = {{");
    for (at, one) in lists.iter().enumerate() {
        let place = if one.is_empty() { instead(at).unwrap_or(0) } else { first };
        let _ = writeln!(text, "    {{{}, {place}}}, /* {at} */", one.len());
        first += one.len() as u32;
    }
    let mut all: Vec<String> = lists.iter().flatten().map(u32::to_string).collect();
    if all.is_empty() {
        // C has no empty arrays.
        all.push("0".into());
    }
    let lines: Vec<String> = all.chunks(24).map(|line| line.join(", ")).collect();
    let _ = writeln!(text, "}};\nstatic const u32_t {list}[] = {{\n    {}\n}};", lines.join(",\n    "));
}

/// Appends the texts.
fn texts(text: &mut String, texts: &[(Text, usize, usize)]) {
    let _ = writeln!(text, "\n#define PLCFMU_TEXT_COUNT {}u", texts.len());
    if texts.is_empty() {
        return;
    }
    let mut given = 0;
    let mut rows = String::new();
    for (index, (of, offset, size)) in texts.iter().enumerate() {
        let _ = writeln!(
            rows,
            "    {{{}, {}, PLCFMU_{}, {offset}, {size}, {}, {}, {given}}}, /* {index} */",
            quoted(&of.name),
            quoted(&of.ty.name()),
            word(of.role),
            of.ty.most,
            u8::from(of.ty.is_wide),
        );
        // In UTF-8, a UTF-16 code unit needs at most three bytes, and an ISO 8859-1 character at most two.
        given += usize::from(of.ty.most) * (2 + usize::from(of.ty.is_wide)) + 1;
    }
    let _ = write!(
        text,
        "#define PLCFMU_TEXTS PLCFMU_TEXT_COUNT
#define PLCFMU_TEXT_BYTES {given} /* of all texts in UTF-8 */

/* A text; its value reference is its index in this table plus the number of variables. */
typedef struct {{
    const char *name;
    const char *type;
    int role;
    size_t offset; /* in memory, bytes: a 16-bit number of characters, then the characters */
    size_t size;   /* in memory, bytes */
    u32_t most;    /* characters */
    int is_wide;   /* characters have 16 bits */
    size_t given;  /* offset of the copy that is returned to the host */
}} plcfmu_text_row_t;

static const plcfmu_text_row_t plcfmu_text_rows[] = {{
{rows}}};
"
    );
}

/// The role as spelled in C.
fn word(role: Role) -> &'static str {
    match role {
        Role::Input => "INPUT",
        Role::Parameter => "PARAMETER",
        Role::Fixed => "FIXED",
        Role::Cycle => "CYCLE_TIME",
        Role::Output => "OUTPUT",
        Role::Local => "LOCAL",
    }
}

/// The text as a C string literal.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for byte in text.bytes() {
        match byte {
            b'"' | b'\\' => quoted.extend(['\\', char::from(byte)]),
            b' '..=b'~' => quoted.push(char::from(byte)),
            // Three octal digits, so that a following digit is not taken as part of the escape.
            other => {
                let _ = write!(quoted, "\\{other:03o}");
            }
        }
    }
    quoted.push('"');
    quoted
}

/// Whether the self-test draws random values for a variable.
fn is_drawn(of: &Row) -> bool {
    let is_setting = of.role == Role::Parameter;
    of.role == Role::Input || is_setting && matches!(of.kind, Kind::Real | Kind::LReal | Kind::Time | Kind::Bool)
}

/// The range from which the self-test draws a floating-point number or a time parameter. Parameters stay near their
/// start values, with which the block produces some output.
fn range(of: &Row) -> (f64, f64) {
    match (of.least(), of.greatest()) {
        _ if of.role == Role::Parameter && of.kind == Kind::Time => (0.5 * of.start(), 1.5 * of.start()),
        _ if of.role == Role::Parameter => (of.start() - 1.0, of.start() + 1.0),
        (Some(low), Some(high)) if of.kind.class() == Class::Real => (low, high),
        _ => (-100.0, 100.0),
    }
}

/// The subject of the self-test, restarted, with start values for its inputs and parameters.
pub trait Subject {
    /// The reason why a value or a call is refused.
    type Error;
    /// Writes an input.
    ///
    /// # Errors
    /// The input does not accept the value.
    fn set(&mut self, row: usize, number: f64) -> Result<(), Self::Error>;
    /// Makes a call and returns whether it completed.
    ///
    /// # Errors
    /// The call cannot be made.
    fn call(&mut self) -> Result<bool, Self::Error>;
    /// Reads a variable as a number: times in seconds, TRUE as 1.
    ///
    /// # Errors
    /// The variable cannot be read.
    fn get(&mut self, row: usize) -> Result<f64, Self::Error>;
}

impl<B: Cyclic> Subject for B {
    type Error = std::convert::Infallible;

    fn set(&mut self, row: usize, number: f64) -> Result<(), Self::Error> {
        if let Ok(value) = to_value(number, self.table().rows[row].kind) {
            Cyclic::set(self, row, value);
        }
        Ok(())
    }

    fn call(&mut self) -> Result<bool, Self::Error> {
        Cyclic::call(self);
        Ok(self.stopped().is_none())
    }

    fn get(&mut self, row: usize) -> Result<f64, Self::Error> {
        Ok(Cyclic::get(self, row).map_or(0.0, number))
    }
}

/// Makes the calls of the self-test with pseudo-random inputs, up to a call that stops the program. Returns the number
/// of completed calls and the hash of the values of all variables after each of them.
///
/// # Errors
/// The subject refuses a value or a call.
pub fn tape<S: Subject>(variables: &[Row], subject: &mut S) -> Result<(u32, u128), S::Error> {
    let (mut seed, mut hash) = (1_u32, BASIS);
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        seed >> 8
    };
    for call in 0..CALLS {
        for (index, of) in variables.iter().enumerate().filter(|(_, of)| is_drawn(of)) {
            // On average, each variable changes in one of four calls.
            if next() >= 1 << 22 && call > 0 {
                continue;
            }
            subject.set(index, drawn(of, f64::from(next())))?;
        }
        if !subject.call()? {
            return Ok((call, hash));
        }
        for index in 0..variables.len() {
            let value = subject.get(index)?;
            // The bits of NaN differ between processors.
            let value = if value.is_nan() { f64::NAN } else { value };
            hash = fingerprint::hash(hash, &value.to_bits().to_le_bytes());
        }
    }
    Ok((CALLS, hash))
}

/// A value for the tape, derived from a number from 0 to 2^24 - 1. On average, one in four BOOLs is TRUE and half of
/// the floating-point inputs are small, so that a controller is not constantly being restarted or at a limit.
fn drawn(of: &Row, number: f64) -> f64 {
    let (low, high) = range(of);
    let between = low + (high - low) * (number / 16_777_216.0);
    match of.kind {
        Kind::Bool => f64::from(number < 4_194_304.0),
        Kind::Real | Kind::LReal if of.role == Role::Input => {
            between * [1.0, 1.0, 0.0625, 0.00390625][number as usize % 4]
        }
        Kind::Real | Kind::LReal => between,
        Kind::Time if of.role == Role::Parameter => (between * 1000.0).floor() / 1000.0,
        Kind::Time | Kind::LTime => (number / 4096.0).floor() / 1000.0,
        _ => (number / 167_773.0).floor(),
    }
}
