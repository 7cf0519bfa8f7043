//! From program to C: prints a typed program as C that is valid in both C99 and C++, keeps the names and line numbers
//! of the source, and computes the same results as the machine to the last bit.
//!
//! Structures have the layout of [`Program`]'s records on all common platforms, so a program's memory has the same
//! bytes in C as in the machine.

mod expr;
mod facts;
mod operations;
mod statement;

use crate::ir::{At, Body, Function, Place, Program, Record, Scalar, Statement, Type, Value};
use facts::{Facts, Uses};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::sync::LazyLock;

/// The preamble of every printed program.
const HEAD: &str = include_str!("head.h");

/// The line width, in columns, above which an assignment takes two lines and a member's comment its own line.
const WIDTH: usize = 120;

/// Words reserved in C or C++, common macros of compilers and headers, and the macros and constants of printed code.
const KEYWORDS: &str = "alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl concept const \
    const_cast constexpr continue decltype default delete do double dynamic_cast else enum explicit export extern false float for \
    friend goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public \
    register reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast struct switch template \
    this thread_local throw true try typedef typeid typename typeof union unsigned using virtual void volatile wchar_t while xor \
    xor_eq NULL I64_MAX I64_MIN AT_8 LINE PROGRAM OUT_OF_BOUNDS OUT_OF_BUDGET STEP_OF_0 linux unix i386 near far interface small errno assert";

/// Variable and function names used by the printer or by the C library, whose functions compilers treat specially.
const TAKEN: &str = "call constants done memory self start stop abs acos acosh asin asinh atan atan2 atanh calloc cbrt ceil \
    copysign cos cosh erf erfc exit exp exp2 expm1 fabs fdim floor fma fmax fmin fmod free frexp gamma hypot ilogb index isalpha \
    isdigit isinf isnan j0 j1 jn labs ldexp lgamma log log10 log1p log2 logb lrint lround malloc memcmp memcpy memmove memset modf \
    nan nearbyint nextafter pow pow10 printf putchar puts remainder remquo rindex rint round scalbn signbit significand sin sincos \
    sinh sqrt strcat strchr strcmp strcpy strlen strncmp strncpy tan tanh tgamma toupper tolower trunc y0 y1 yn main";

/// Prints the program as C, with a function `PROGRAM void NAME(call_t *call, memory_t *memory)` for each function that
/// can be called from outside ([`name`]), and `PROGRAM void start(memory_t *memory)`, which writes the start values.
/// Everything else is static. A host in the same file defines `PROGRAM` first, for example as `static`. If calls of the
/// program can be stopped, its text contains a call of `stop`, `index_of` or `goes_on`.
///
/// # Errors
/// The program is inconsistent, or it uses blocks from [`blocks`] whose laws have not been added
/// ([`Program::add_law`]).
pub fn print(program: &Program) -> Result<String, String> {
    let mut printer = Printer::new(program);
    let functions = printer.functions()?;
    let (types, values) = printer.data();
    let mut text = String::new();
    if !program.docs.head.is_empty() {
        let _ = writeln!(text, "{}\n", comment(&program.docs.head, 0));
    }
    text.push_str(HEAD);
    text.push_str(&operations::used(&format!("call_t {types}{values}{functions}")));
    let _ = write!(text, "{types}{values}{functions}");
    Ok(text)
}

/// Whether a function or one of its callees contains a loop or a jump.
#[cfg(test)]
pub(crate) fn is_endless(program: &Program, function: usize) -> bool {
    crate::ir::walk::reached(program, &[function]).into_iter().any(|number| match &program.functions[number].body {
        Body::Code(body) => facts::may_not_end(body),
        Body::Native(_) => false,
    })
}

/// The C name of a function that can be called from outside.
pub fn name(program: &Program, function: usize) -> String {
    Printer::new(program).function_names.swap_remove(function)
}

/// A source line as a C expression; lines of the first file are plain numbers.
fn line(At { file, line }: At) -> String {
    if file == 0 { line.to_string() } else { format!("LINE({file}, {line})") }
}

/// A C comment of one or more lines.
fn comment(text: &str, indent: usize) -> String {
    let text = text.trim_end().replace("*/", "* /").replace("/*", "/ *");
    let space = " ".repeat(indent);
    let lines: Vec<&str> = text.lines().collect();
    if let [line] = lines[..] {
        return format!("{space}/* {line} */");
    }
    let lines: Vec<String> = lines.iter().map(|line| format!("{space} * {line}").trim_end().to_string()).collect();
    format!("{space}/*\n{}\n{space} */", lines.join("\n"))
}

struct Printer<'a> {
    program: &'a Program,
    /// The finished part of the output, followed by the statements of the function being printed.
    text: String,
    records: Vec<String>,
    /// The member names of each record.
    members: Vec<Vec<String>>,
    function_names: Vec<String>,
    /// The functions to print, in order: callees first.
    reached: Vec<usize>,
    facts: Vec<Facts>,
    /// Whether statements are counted, because a loop might not terminate.
    counts: bool,
    /// Whether the functions printed so far read constants.
    reads_constants: bool,
    /// The string types in use: capacity, and whether characters are 16 bits wide.
    texts: BTreeSet<(u16, bool)>,
    scope: Scope<'a>,
}

/// State of the function being printed.
#[derive(Default)]
struct Scope<'a> {
    function: Option<&'a Function>,
    number: usize,
    locals: Vec<PrintedLocal>,
    /// Those of the arguments `call`, `memory` and `self` that the statements printed so far use.
    named: BTreeSet<&'static str>,
    /// The declarations of temporaries.
    temporaries: Vec<String>,
    indent: usize,
    /// The end labels of the enclosing loops, and whether each is used.
    loops: Vec<(usize, bool)>,
    labels: usize,
    leaves: bool,
    at: At,
    /// The local that holds the function's value, if that value is returned where it is computed.
    direct: Option<usize>,
    /// Whether this function counts statements.
    counts: bool,
    /// Whether the next statement belongs to the last of `runs`.
    is_run: bool,
    /// The runs of statements started so far.
    runs: Vec<Run>,
    /// The local that the next assignment declares.
    declared: Option<usize>,
}

/// Statements whose budget is deducted together.
struct Run {
    /// The position in the text where the number of statements is inserted.
    at: usize,
    count: usize,
}

/// A local of the function being printed.
struct PrintedLocal {
    name: String,
    /// Whether it only carries a call's value to its use and is therefore not printed.
    is_elided: bool,
    /// Whether it is declared at the beginning of the function.
    is_first: bool,
    /// Whether its declaration is still to be printed, before or in its first assignment.
    is_pending: bool,
    /// Whether its value is read anywhere.
    is_read: bool,
    /// Whether the statements printed so far name it.
    is_named: bool,
    /// Whether the statements printed so far name the bounds of its array.
    has_named_bounds: bool,
}

/// The C type of a scalar.
fn scalar(ty: Scalar) -> &'static str {
    match ty {
        Scalar::Bool | Scalar::U8 => "u8_t",
        Scalar::I8 => "i8_t",
        Scalar::I16 => "i16_t",
        Scalar::I32 => "i32_t",
        Scalar::I64 => "i64_t",
        Scalar::U16 => "u16_t",
        Scalar::U32 => "u32_t",
        Scalar::U64 => "u64_t",
        Scalar::F32 => "float",
        Scalar::F64 => "double",
    }
}

/// Converts names to unique C identifiers of ASCII letters, digits and underscores, avoiding those that are taken.
fn names<'a>(of: impl IntoIterator<Item = &'a str>, is_taken: impl Fn(&str) -> bool) -> Vec<String> {
    let mut taken: BTreeMap<String, usize> = BTreeMap::new();
    let mut all: Vec<String> = Vec::new();
    for name in of {
        let mut name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if name.starts_with(|first: char| first.is_ascii_digit() || first == '_') || name.is_empty() {
            name.insert(0, 'n');
        }
        let mut count = *taken.get(&name).unwrap_or(&0);
        let mut own = name.clone();
        while taken.contains_key(&own) || is_taken(&own) {
            count += 1;
            own = format!("{name}_{count}");
        }
        taken.insert(name, count);
        taken.insert(own.clone(), 1);
        all.push(own);
    }
    all
}

/// Whether a name is a reserved word or a macro.
fn is_keyword(name: &str) -> bool {
    static WORDS: LazyLock<BTreeSet<&str>> = LazyLock::new(|| KEYWORDS.split_whitespace().collect());
    WORDS.contains(name)
}

/// Whether this name is not allowed for a variable or function.
fn is_taken(name: &str) -> bool {
    static WORDS: LazyLock<BTreeSet<&str>> = LazyLock::new(|| TAKEN.split_whitespace().collect());
    is_keyword(name) || WORDS.contains(name) || operations::exists(name)
}

/// Names that a record cannot have because, with the suffix `_t`, they denote other types.
const TYPES: &str = "memory constants call twofold twofolds digits turn size ptrdiff wchar intmax uintmax intptr";

/// Whether this name is not allowed for a record.
fn is_type(name: &str) -> bool {
    let is_number = ["i", "u", "text_", "wide_"].iter().any(|prefix| {
        name.strip_prefix(prefix).is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit()))
    });
    is_number || TYPES.split(' ').any(|word| word == name)
}

/// The bytes of a memory image as a C initializer list.
fn bytes(image: &[u8]) -> String {
    let bytes: Vec<String> = image.iter().map(u8::to_string).collect();
    if bytes.is_empty() { "0".to_string() } else { bytes.join(", ") }
}

impl<'a> Printer<'a> {
    fn new(program: &'a Program) -> Printer<'a> {
        let reached = facts::reached(program);
        let counts = reached.iter().any(|number| match &program.functions[*number].body {
            Body::Code(body) => !program.docs.natives.contains(number) && facts::may_not_end(body),
            Body::Native(_) => false,
        });
        let facts = facts::facts(program, &reached, counts);
        let mut records = names(program.records.iter().map(|record| record.name.as_str()), is_type);
        let members = |record: &Record| names(record.members.iter().map(|member| member.name.as_str()), is_keyword);
        let members = program.records.iter().map(members).collect();
        records[program.memory] = "memory".to_string();
        records[program.constants] = "constants".to_string();
        let function_names = names(program.functions.iter().map(|function| function.name.as_str()), is_taken);
        let mut texts = BTreeSet::new();
        let types = program.records.iter().flat_map(|record| record.members.iter().map(|member| &member.ty));
        let locals = program.functions.iter().flat_map(|function| function.locals.iter().map(|local| &local.ty));
        for mut ty in types.chain(locals) {
            while let Type::Array { of, .. } | Type::Open { of, .. } = ty {
                ty = of;
            }
            if let Type::Text { capacity, wide } = ty {
                texts.insert((*capacity, *wide));
            }
        }
        let (text, scope, reads_constants) = (String::new(), Scope::default(), false);
        Printer {
            program,
            text,
            records,
            members,
            function_names,
            reached,
            facts,
            counts,
            reads_constants,
            texts,
            scope,
        }
    }

    /// Prints the reached functions.
    fn functions(&mut self) -> Result<String, String> {
        for number in self.reached.clone() {
            self.function(number)?;
        }
        Ok(std::mem::take(&mut self.text))
    }

    /// Prints the types, the start values and the constants.
    fn data(&mut self) -> (String, String) {
        self.types();
        let types = std::mem::take(&mut self.text);
        self.values();
        (types, std::mem::take(&mut self.text))
    }

    /// The C declaration of a variable.
    fn declared(&self, ty: &Type, name: &str) -> String {
        match ty {
            Type::Scalar(ty) => format!("{} {name}", scalar(*ty)),
            Type::Text { capacity, wide } => format!("{}_{capacity}_t {name}", if *wide { "wide" } else { "text" }),
            Type::Array { of, .. } => {
                let count = self.program.size(ty) / self.program.size(of).max(1);
                self.declared(of, &format!("{name}[{count}]"))
            }
            Type::Open { of, .. } => self.declared(of, &format!("*{name}")),
            Type::Record(record) => format!("{}_t {name}", self.records[*record]),
        }
    }

    /// The C declaration of a pointer to a variable or, for an array, to its first element.
    fn pointer(&self, ty: &Type, name: &str) -> String {
        match ty {
            Type::Array { of, .. } => self.declared(of, &format!("*{name}")),
            _ => self.declared(ty, &format!("*{name}")),
        }
    }

    fn types(&mut self) {
        for (capacity, wide) in self.texts.clone() {
            let (name, of) = if wide { ("wide", "u16_t") } else { ("text", "u8_t") };
            // An even size keeps the next number aligned.
            let room = if wide { capacity.max(1) } else { capacity.max(1).next_multiple_of(2) };
            let _ = writeln!(
                self.text,
                "\ntypedef struct {{\n    u16_t length;\n    {of} characters[{room}];\n}} {name}_{capacity}_t;"
            );
        }
        let mut done = vec![false; self.program.records.len()];
        done[self.program.constants] = !self.reads_constants;
        for number in 0..self.program.records.len() {
            self.record(number, &mut done);
        }
    }

    fn record(&mut self, number: usize, done: &mut [bool]) {
        if std::mem::replace(&mut done[number], true) {
            return;
        }
        let program = self.program;
        let record = &program.records[number];
        for member in &record.members {
            let mut ty = &member.ty;
            while let Type::Array { of, .. } = ty {
                ty = of;
            }
            if let Type::Record(inner) = ty {
                self.record(*inner, done);
            }
        }
        self.text.push('\n');
        if program.is_packed(number) {
            return self.packed(number);
        }
        if let Some(docs) = program.docs.records.get(&number) {
            let _ = writeln!(self.text, "{}", comment(docs, 0));
        }
        self.text.push_str("typedef struct {\n");
        let declared = |(member, name): (&crate::ir::Member, &String)| {
            let mut of = &member.ty;
            while let Type::Array { of: inner, .. } = of {
                of = inner;
            }
            let at = if matches!(of, Type::Scalar(of) if of.size() == 8) { "AT_8 " } else { "" };
            format!("    {at}{};", self.declared(&member.ty, name))
        };
        let all: Vec<String> = record.members.iter().zip(&self.members[number]).map(declared).collect();
        let column = all.iter().map(String::len).filter(|length| *length <= 40).max().unwrap_or(0);
        for (index, declared) in all.into_iter().enumerate() {
            let Some(docs) = program.docs.members.get(&(number, index)) else {
                let _ = writeln!(self.text, "{declared}");
                continue;
            };
            let behind = format!("{declared:column$} {}", comment(docs, 0));
            if behind.len() <= WIDTH && !behind.contains('\n') {
                let _ = writeln!(self.text, "{behind}");
            } else {
                let _ = writeln!(self.text, "{}\n{declared}", comment(docs, 4));
            }
        }
        if record.members.is_empty() {
            self.text.push_str("    u8_t nothing;\n");
        }
        let _ = writeln!(self.text, "}} {}_t;", self.records[number]);
    }

    /// Prints the type of a block's instance inside a program, packed like the block's stored state: variables,
    /// internal state, memory.
    fn packed(&mut self, number: usize) {
        let record = &self.program.records[number];
        let mut members: Vec<_> = record.members.iter().zip(&self.members[number]).collect();
        members.sort_by_key(|(member, _)| member.offset);
        self.text.push_str("#pragma pack(push, 1)\ntypedef struct {\n");
        let mut end = 0;
        let gap = |text: &mut String, from: usize, to: usize| {
            if to > from {
                let _ = writeln!(text, "    u8_t bytes_{from}[{}];", to - from);
            }
        };
        for (member, name) in members {
            gap(&mut self.text, end, member.offset);
            let declared = self.declared(&member.ty, name);
            let _ = writeln!(self.text, "    {declared};");
            end = member.offset + self.program.size(&member.ty);
        }
        gap(&mut self.text, end, record.start.len());
        let _ = writeln!(self.text, "}} {}_t;\n#pragma pack(pop)", self.records[number]);
    }

    /// Prints the start values of memory, and the constants if they are used.
    fn values(&mut self) {
        if self.reads_constants {
            let name = &self.records[self.program.constants];
            let constants = bytes(&self.program.records[self.program.constants].start);
            let _ = writeln!(
                self.text,
                "\nstatic const union {{\n    u8_t bytes[sizeof({name}_t)];\n    {name}_t value;\n}} constants = \
                {{{{{constants}}}}};"
            );
        }
        let image = &self.program.records[self.program.memory].start;
        let mut lines = Vec::new();
        self.starts(&Type::Record(self.program.memory), image, "memory->", &mut lines);
        let _ = writeln!(
            self.text,
            "\n/* Writes the start values. */\nPROGRAM void start(memory_t *memory);\nPROGRAM void start(memory_t *memory) {{"
        );
        // With more assignments than that, the start values are copied as bytes.
        if lines.len() > 1000 {
            let _ = writeln!(
                self.text,
                "    static const u8_t bytes[] = {{{}}};\n    memcpy(memory, bytes, sizeof *memory);\n}}",
                bytes(image)
            );
            return;
        }
        self.text.push_str("    memset(memory, 0, sizeof *memory);\n");
        for line in lines {
            let _ = writeln!(self.text, "    {line}");
        }
        self.text.push_str("}\n");
    }

    /// Appends assignments for all start values other than 0.
    fn starts(&self, ty: &Type, image: &[u8], path: &str, lines: &mut Vec<String>) {
        if image.iter().all(|byte| *byte == 0) || lines.len() > 1000 {
            return;
        }
        let whole = path.trim_end_matches("->").trim_end_matches('.');
        match ty {
            Type::Scalar(ty) => lines.push(format!("{whole} = {};", expr::constant(Value::read(*ty, image)))),
            Type::Text { .. } => {
                for (index, byte) in image.iter().enumerate().filter(|(_, byte)| **byte != 0) {
                    lines.push(format!("((u8_t *)&{whole})[{index}] = {byte};"));
                }
            }
            Type::Array { of, .. } => {
                let size = self.program.size(of).max(1);
                for (index, part) in image.chunks(size).enumerate().take(self.program.size(ty) / size) {
                    self.starts(of, part, &format!("{whole}[{index}]."), lines);
                }
            }
            Type::Record(record) => {
                for (member, name) in self.program.records[*record].members.iter().zip(&self.members[*record]) {
                    let part = &image[member.offset..member.offset + self.program.size(&member.ty)];
                    self.starts(&member.ty, part, &format!("{path}{name}."), lines);
                }
            }
            Type::Open { .. } => {}
        }
    }

    /// The C signature of a function.
    fn head(&self, number: usize) -> String {
        let function = &self.program.functions[number];
        let facts = &self.facts[number];
        let is_entry = facts::is_entry(function);
        let mut parameters = Vec::new();
        if is_entry || facts.needs_call {
            parameters.push("call_t *call".to_string());
        }
        if is_entry || facts.needs_memory {
            parameters.push("memory_t *memory".to_string());
        }
        if let Some(record) = function.instance {
            let constant = if facts.is_pure { "const " } else { "" };
            parameters.push(format!("{constant}{}_t *self", self.records[record]));
        }
        let names = self.local_names(function);
        for (local, name) in function.locals.iter().zip(&names).take(function.parameters) {
            match (&local.ty, local.by_reference) {
                (Type::Open { .. }, _) => {
                    parameters.push(self.declared(&local.ty, name));
                    parameters.push(format!("const i32_t *{name}_bounds"));
                }
                (ty, true) => parameters.push(self.pointer(ty, name)),
                (Type::Scalar(ty), false) => parameters.push(format!("{} {name}", scalar(*ty))),
                (ty, false) => parameters.push(format!("const {}", self.pointer(ty, &format!("{name}_in")))),
            }
        }
        for output in &facts.outs {
            parameters.push(self.pointer(&function.locals[*output].ty, &format!("{}_out", names[*output])));
        }
        if parameters.is_empty() {
            parameters.push("void".to_string());
        }
        let result = match facts.returns.map(|local| &function.locals[local].ty) {
            Some(Type::Scalar(ty)) => scalar(*ty),
            _ => "void",
        };
        let scope = if is_entry { "PROGRAM" } else { "static" };
        format!("{scope} {result} {}({})", self.function_names[number], parameters.join(", "))
    }

    fn local_names(&self, function: &Function) -> Vec<String> {
        names(function.locals.iter().map(|local| local.name.as_str()), |name| {
            is_taken(name) || self.function_names.iter().any(|function| function == name)
        })
    }

    fn function(&mut self, number: usize) -> Result<(), String> {
        let program = self.program;
        let function = &program.functions[number];
        let body = match &function.body {
            Body::Code(body) => body,
            Body::Native(name) => return self.law(number, name),
        };
        let counts = self.counts && !program.docs.natives.contains(&number);
        // Simplifying would change the number of statements.
        let simplified = if counts { Vec::new() } else { facts::simplified(body, &self.facts) };
        let body = if counts { &body[..] } else { &simplified[..] };
        let has_jumps = counts || facts::may_not_end(body);
        let direct = self.facts[number].returns.filter(|result| !has_jumps && statement::is_direct(body, *result));
        self.scope = Scope { function: Some(function), number, indent: 1, direct, counts, ..Scope::default() };
        self.scope.locals = self.locals(function, body, has_jumps);
        let before = std::mem::take(&mut self.text);
        self.body(body)?;
        let mut statements = std::mem::replace(&mut self.text, before);
        for run in self.scope.runs.iter().rev() {
            statements.insert_str(run.at, &run.count.to_string());
        }
        let head = self.head(number);
        self.text.push('\n');
        if let Some(docs) = program.docs.functions.get(&number) {
            let _ = writeln!(self.text, "{}", comment(docs, 0));
        }
        if facts::is_entry(function) {
            let _ = writeln!(self.text, "{head};");
        }
        let _ = writeln!(self.text, "{head} {{");
        let (mut declarations, mut starts) = (String::new(), String::new());
        for (index, (local, printed)) in function.locals.iter().zip(&self.scope.locals).enumerate() {
            let (is_parameter, name) = (index < function.parameters, &printed.name);
            match &local.ty {
                _ if local.by_reference => {}
                _ if !is_parameter && !printed.is_first => {}
                Type::Scalar(_) if is_parameter => {}
                Type::Scalar(ty) => {
                    let zero = expr::constant(Value::new(*ty, 0));
                    let _ = writeln!(declarations, "    {} = {zero};", self.declared(&local.ty, name));
                }
                ty => {
                    let image = bytes(&program.start(ty));
                    let _ = writeln!(declarations, "    static const u8_t {name}_start[] = {{{image}}};");
                    let _ = writeln!(declarations, "    {};", self.declared(ty, name));
                    let from = if is_parameter {
                        format!("{name}_in ? (const void *){name}_in : {name}_start")
                    } else {
                        format!("{name}_start")
                    };
                    let _ = writeln!(starts, "    memcpy(&{name}, {from}, sizeof {name});");
                }
            }
        }
        for temporary in &self.scope.temporaries {
            let _ = writeln!(declarations, "    {temporary};");
        }
        let facts = &self.facts[number];
        let is_entry = facts::is_entry(function);
        let arguments = [
            ("call", is_entry || facts.needs_call),
            ("memory", is_entry || facts.needs_memory),
            ("self", function.instance.is_some()),
        ];
        for (name, _) in arguments.iter().filter(|(name, exists)| *exists && !self.scope.named.contains(name)) {
            let _ = writeln!(declarations, "    (void){name};");
        }
        for (index, (local, printed)) in function.locals.iter().zip(&self.scope.locals).enumerate() {
            let (is_parameter, name) = (index < function.parameters, &printed.name);
            if (is_parameter || printed.is_first) && !(printed.is_read && printed.is_named) {
                let _ = writeln!(declarations, "    (void){name};");
            }
            if is_parameter && matches!(local.ty, Type::Open { .. }) && !printed.has_named_bounds {
                let _ = writeln!(declarations, "    (void){name}_bounds;");
            }
        }
        let _ = write!(self.text, "{declarations}{starts}{statements}");
        if self.scope.leaves {
            self.text.push_str("done:;\n");
        }
        for output in &self.facts[number].outs {
            let (name, ty) = (&self.scope.locals[*output].name, &function.locals[*output].ty);
            let copied = match ty {
                Type::Scalar(_) => format!("*{name}_out = {name};"),
                _ => format!("memcpy({name}_out, &{name}, sizeof {name});"),
            };
            let _ = writeln!(self.text, "    if ({name}_out) {{\n        {copied}\n    }}");
        }
        if let Some(result) = self.facts[number].returns.filter(|_| self.scope.direct.is_none()) {
            let _ = writeln!(self.text, "    return {};", self.scope.locals[result].name);
        }
        self.text.push_str("}\n");
        Ok(())
    }

    /// How the locals of a function are to be printed, before any of its statements has been printed.
    fn locals(&self, function: &Function, body: &[Statement], has_jumps: bool) -> Vec<PrintedLocal> {
        let Scope { number, direct, counts, .. } = self.scope;
        let facts = &self.facts[number];
        let uses = Uses::new(&self.facts, number, body);
        let named = self.local_names(function).into_iter().enumerate();
        let printed = named.map(|(index, name)| {
            let is_output = facts.outs.contains(&index) || facts.returns == Some(index);
            let is_elided = !counts && uses.is_elided(index);
            let is_used = (uses.is_named(index) && !is_elided || is_output) && direct != Some(index);
            let is_number = matches!(function.locals[index].ty, Type::Scalar(_));
            let may_be_late = !has_jumps && facts.outs.is_empty() && index >= function.parameters && is_number;
            let is_pending = is_used && may_be_late && (direct.is_some() || facts.returns != Some(index));
            let (is_first, is_read) = (is_used && !is_pending, is_output || uses.is_read(index));
            PrintedLocal { name, is_elided, is_first, is_pending, is_read, is_named: false, has_named_bounds: false }
        });
        printed.collect()
    }

    /// Prints the function that runs the law of a block ([`Program::add_law`]). The block's instance has the layout of
    /// a saved state, without padding, so the function copies it to a record of the law and back.
    fn law(&mut self, number: usize, name: &str) -> Result<(), String> {
        let law = self.program.docs.laws.get(&number).copied();
        let (Some(law), Some(record)) = (law, law.and_then(|law| self.program.functions[law].instance)) else {
            return Err(format!("{name} cannot be printed as C"));
        };
        if self.facts[law].needs_call || self.facts[law].needs_memory {
            return Err(format!("{name} has a loop and cannot be printed as C in a program"));
        }
        let runs = self.program.runs(number);
        let parts: Vec<String> =
            runs.iter().map(|run| format!("{{{}, {}, {}}}", run.at, run.packed, run.size)).collect();
        let (head, count, parts) = (self.head(number), parts.len(), parts.join(", "));
        let (record, law) = (&self.records[record], &self.function_names[law]);
        let _ = write!(
            self.text,
            "
/* Calls {name}. Like a saved state, an instance in a program has no padding between its members. */
{head} {{
    /* For consecutive members: their offset in a {record}_t, their offset in *self, and their size in bytes. */
    static const u16_t parts[{count}][3] = {{{parts}}};
    {record}_t block;
    size_t i;
    memset(&block, 0, sizeof block);
    for (i = 0; i < {count}; i += 1) {{
        memcpy((char *)&block + parts[i][0], (const char *)self + parts[i][1], parts[i][2]);
    }}
    {law}(&block);
    for (i = 0; i < {count}; i += 1) {{
        memcpy((char *)self + parts[i][1], (const char *)&block + parts[i][0], parts[i][2]);
    }}
}}
"
        );
        Ok(())
    }

    fn line(&mut self, text: &str) {
        let _ = writeln!(self.text, "{:width$}{text}", "", width = 4 * self.scope.indent);
    }

    /// Returns the name of the argument `call`, `memory` or `self`, and notes that it is used.
    fn argument(&mut self, name: &'static str) -> String {
        self.scope.named.insert(name);
        name.to_string()
    }

    /// Returns the name of a local, and notes that a statement uses it.
    fn local(&mut self, local: usize) -> String {
        self.scope.locals[local].is_named = true;
        self.scope.locals[local].name.clone()
    }

    /// Declares a new temporary and returns its name; `declared` returns the declaration of a variable with that name.
    fn temporary(&mut self, declared: impl FnOnce(&Self, &str) -> String) -> String {
        let name = format!("t_{}", self.scope.temporaries.len());
        let declared = declared(self, &name);
        self.scope.temporaries.push(declared);
        name
    }

    fn type_of(&self, place: &Place) -> Result<Type, String> {
        let function = self.scope.function.ok_or("no function")?;
        self.program
            .type_of(function, place)
            .ok_or_else(|| format!("{} uses a variable that does not exist", function.name))
    }
}

#[cfg(test)]
mod tests;
