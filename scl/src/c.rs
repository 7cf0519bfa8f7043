//! Typed programs as C, common to C99 and C++: with the names and lines of the source, and the results of the machine to the last
//! bit.
//!
//! Structures have the layout of [`Program`]'s records on all usual platforms, so that the memory of a program is the same
//! bytes.

mod expr;
mod statement;

use crate::program::walk::{self, Look};
use crate::program::{At, Body, Call, Function, Place, Program, Scalar, Type};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// What every program begins with: the operations.
const PRELUDE: &str = include_str!("c/prelude.h");

/// Words that are no names in C or C++, or belong to the operations.
const RESERVED: [&str; 26] = [
    "auto", "break", "call", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "float",
    "for", "goto", "if", "int", "long", "memory", "return", "self", "short", "start", "static", "stop", "while",
];

/// The program as C, with a function `PROGRAM void NAME(call_t *call, memory_t *memory)` for each function that can be called
/// from outside ([`name`]), and `PROGRAM void start(memory_t *memory)`, which writes the start values. A host in the same file
/// defines `PROGRAM` before it, as `static` for example.
///
/// # Errors
/// What cannot be printed: blocks of [`blocks`], and functions such as EXP, which need an implementation of their own in C.
pub fn print(program: &Program) -> Result<String, String> {
    let mut printer = Printer::new(program);
    let reached = reached(program);
    for number in &reached {
        printer.prototype(*number)?;
    }
    for number in &reached {
        printer.function(*number)?;
    }
    let functions = std::mem::replace(&mut printer.text, PRELUDE.to_string());
    printer.types();
    printer.values(is_used(&functions, "constants"));
    printer.text.push_str(&functions);
    Ok(printer.text)
}

/// The name in C of a function that can be called from outside.
pub fn name(program: &Program, function: usize) -> String {
    Printer::new(program).functions.swap_remove(function)
}

/// A line as C has it: that of the first file as its number.
fn line(At { file, line }: At) -> String {
    if file == 0 { line.to_string() } else { format!("LINE({file}, {line})") }
}

/// The functions that can be called from outside, and all that they call.
fn reached(program: &Program) -> BTreeSet<usize> {
    struct Calls(Vec<usize>);
    impl Look for Calls {
        fn call(&mut self, call: &Call) {
            self.0.push(call.function);
        }
    }
    let is_callable = |number: &usize| {
        let function = &program.functions[*number];
        function.parameters == 0 && function.instance.is_none()
    };
    let mut open = Calls((0..program.functions.len()).filter(is_callable).collect());
    let mut reached = BTreeSet::new();
    while let Some(number) = open.0.pop() {
        if reached.insert(number)
            && let Body::Code(body) = &program.functions[number].body
        {
            walk::statements(body, &mut open);
        }
    }
    reached
}

struct Printer<'a> {
    program: &'a Program,
    /// The finished part, then the statements of a function.
    text: String,
    records: Vec<String>,
    functions: Vec<String>,
    /// Of each function, the locals that a call copies out.
    outputs: Vec<BTreeSet<usize>>,
    /// Which texts there are.
    texts: BTreeSet<(u16, bool)>,
    scope: Scope<'a>,
}

/// The function that is printed.
#[derive(Clone, Default)]
struct Scope<'a> {
    function: Option<&'a Function>,
    names: Vec<String>,
    /// Declarations of temporaries.
    temporaries: Vec<String>,
    indent: usize,
    /// The labels at the ends of the loops around, and whether they are used.
    loops: Vec<(usize, bool)>,
    labels: usize,
    leaves: bool,
    at: At,
}

/// The type of a number in C.
fn scalar(ty: Scalar) -> &'static str {
    match ty {
        Scalar::Bool | Scalar::U8 => "uint8_t",
        Scalar::I8 => "int8_t",
        Scalar::I16 => "int16_t",
        Scalar::I32 => "int32_t",
        Scalar::I64 => "int64_t",
        Scalar::U16 => "uint16_t",
        Scalar::U32 => "uint32_t",
        Scalar::U64 => "uint64_t",
        Scalar::F32 => "float",
        Scalar::F64 => "double",
    }
}

/// Names that differ, with letters, digits and underscores only.
fn names<'a>(of: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut taken: BTreeMap<String, usize> = RESERVED.iter().map(|word| (word.to_string(), 1)).collect();
    let mut all: Vec<String> = Vec::new();
    for name in of {
        let mut name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if name.starts_with(|first: char| first.is_ascii_digit()) || name.is_empty() {
            name.insert(0, 'n');
        }
        let mut count = *taken.get(&name).unwrap_or(&0);
        let mut own = name.clone();
        while taken.contains_key(&own) {
            count += 1;
            own = format!("{name}_{count}");
        }
        taken.insert(name, count);
        taken.insert(own.clone(), 1);
        all.push(own);
    }
    all
}

/// Whether a name stands in a text, and not as that of a member.
fn is_used(text: &str, name: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.match_indices(name).any(|(at, _)| {
        let (before, behind) = (&text[..at], &text[at + name.len()..]);
        let is_member = before.ends_with("->") || before.ends_with('.');
        !is_member && !before.ends_with(is_letter) && !behind.starts_with(is_letter)
    })
}

/// The bytes of an image as C.
fn bytes(image: &[u8]) -> String {
    let bytes: Vec<String> = image.iter().map(u8::to_string).collect();
    if bytes.is_empty() { "0".to_string() } else { bytes.join(", ") }
}

impl<'a> Printer<'a> {
    fn new(program: &'a Program) -> Printer<'a> {
        struct Outputs(Vec<BTreeSet<usize>>);
        impl Look for Outputs {
            fn call(&mut self, call: &Call) {
                self.0[call.function].extend(call.outputs.iter().map(|(local, _)| *local));
            }
        }
        let mut outputs = Outputs(vec![BTreeSet::new(); program.functions.len()]);
        for function in &program.functions {
            if let Body::Code(body) = &function.body {
                walk::statements(body, &mut outputs);
            }
        }
        let record = |number: usize| match number {
            number if number == program.memory => "memory",
            number if number == program.constants => "constants",
            number => program.records[number].name.as_str(),
        };
        let mut records = names((0..program.records.len()).map(record));
        records[program.memory] = "memory".to_string();
        let functions = names(program.functions.iter().map(|function| function.name.as_str()));
        let mut texts = BTreeSet::new();
        let members = program.records.iter().flat_map(|record| record.members.iter().map(|member| &member.ty));
        let locals = program.functions.iter().flat_map(|function| function.locals.iter().map(|local| &local.ty));
        for mut ty in members.chain(locals) {
            while let Type::Array { of, .. } | Type::Open { of, .. } = ty {
                ty = of;
            }
            if let Type::Text { capacity, wide } = ty {
                texts.insert((*capacity, *wide));
            }
        }
        Printer { program, text: String::new(), records, functions, outputs: outputs.0, texts, scope: Scope::default() }
    }

    /// A variable of a type, as C declares it.
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

    /// A pointer to a variable of a type; to its first element, if it is an array.
    fn pointer(&self, ty: &Type, name: &str) -> String {
        match ty {
            Type::Array { of, .. } => self.declared(of, &format!("*{name}")),
            _ => self.declared(ty, &format!("*{name}")),
        }
    }

    fn types(&mut self) {
        for (capacity, wide) in self.texts.clone() {
            let (name, of) = if wide { ("wide", "uint16_t") } else { ("text", "uint8_t") };
            // The room is even, so that the next number lies at its place.
            let room = if wide { capacity.max(1) } else { capacity.max(1).next_multiple_of(2) };
            let _ = writeln!(
                self.text,
                "\ntypedef struct {{\n    uint16_t length;\n    {of} characters[{room}];\n}} {name}_{capacity}_t;"
            );
        }
        let mut done = vec![false; self.program.records.len()];
        for number in 0..self.program.records.len() {
            self.record(number, &mut done);
        }
    }

    fn record(&mut self, number: usize, done: &mut [bool]) {
        if std::mem::replace(&mut done[number], true) {
            return;
        }
        let record = &self.program.records[number];
        for member in &record.members {
            let mut ty = &member.ty;
            while let Type::Array { of, .. } = ty {
                ty = of;
            }
            if let Type::Record(inner) = ty {
                self.record(*inner, done);
            }
        }
        let _ = writeln!(self.text, "\ntypedef struct {{");
        for (member, name) in record.members.iter().zip(self.members(number)) {
            let mut of = &member.ty;
            while let Type::Array { of: inner, .. } = of {
                of = inner;
            }
            let at = if matches!(of, Type::Scalar(of) if of.size() == 8) { "AT_8 " } else { "" };
            let _ = writeln!(self.text, "    {at}{};", self.declared(&member.ty, &name));
        }
        if record.members.is_empty() {
            self.text.push_str("    uint8_t nothing;\n");
        }
        let _ = writeln!(self.text, "}} {}_t;", self.records[number]);
    }

    fn members(&self, record: usize) -> Vec<String> {
        names(self.program.records[record].members.iter().map(|member| member.name.as_str()))
    }

    /// The start values of the memory, and the constants if they are used.
    fn values(&mut self, with_constants: bool) {
        let start = |record: usize| bytes(&self.program.records[record].start);
        let (constants, memory) = (start(self.program.constants), start(self.program.memory));
        if with_constants {
            let name = &self.records[self.program.constants];
            let _ = writeln!(
                self.text,
                "\nstatic const union {{\n    uint8_t bytes[sizeof({name}_t)];\n    {name}_t value;\n}} constants = \
                {{{{{constants}}}}};"
            );
        }
        let _ = writeln!(
            self.text,
            "\nPROGRAM void start(memory_t *memory);\nPROGRAM void start(memory_t *memory) {{\n    \
            static const uint8_t bytes[] = {{{memory}}};\n    memcpy(memory, bytes, sizeof *memory);\n}}\n"
        );
    }

    /// The head of a function.
    fn head(&self, number: usize) -> String {
        let function = &self.program.functions[number];
        let mut parameters = vec!["call_t *call".to_string(), "memory_t *memory".to_string()];
        if let Some(record) = function.instance {
            parameters.push(format!("{}_t *self", self.records[record]));
        }
        let names = self.local_names(function);
        for (local, name) in function.locals.iter().zip(&names).take(function.parameters) {
            match (&local.ty, local.by_reference) {
                (Type::Open { .. }, _) => {
                    parameters.push(self.declared(&local.ty, name));
                    parameters.push(format!("const int32_t *{name}_bounds"));
                }
                (ty, true) => parameters.push(self.pointer(ty, name)),
                (Type::Scalar(ty), false) => parameters.push(format!("{} {name}", scalar(*ty))),
                (ty, false) => parameters.push(format!("const {}", self.pointer(ty, &format!("{name}_in")))),
            }
        }
        for output in &self.outputs[number] {
            parameters.push(self.pointer(&function.locals[*output].ty, &format!("{}_out", names[*output])));
        }
        let scope = if function.parameters == 0 && function.instance.is_none() { "PROGRAM " } else { "static " };
        format!("{scope}void {}({})", self.functions[number], parameters.join(", "))
    }

    fn local_names(&self, function: &Function) -> Vec<String> {
        names(function.locals.iter().map(|local| local.name.as_str()))
    }

    fn prototype(&mut self, number: usize) -> Result<(), String> {
        if let Body::Native(name) = &self.program.functions[number].body {
            return Err(format!("{name} cannot be printed as C"));
        }
        let head = self.head(number);
        let _ = writeln!(self.text, "{head};");
        Ok(())
    }

    fn function(&mut self, number: usize) -> Result<(), String> {
        let program = self.program;
        let function = &program.functions[number];
        let Body::Code(body) = &function.body else { return Ok(()) };
        let names = self.local_names(function);
        self.scope = Scope { function: Some(function), names: names.clone(), indent: 1, ..Scope::default() };
        let before = std::mem::take(&mut self.text);
        self.statements(body)?;
        let statements = std::mem::replace(&mut self.text, before);
        let head = self.head(number);
        let _ = writeln!(self.text, "\n{head} {{");
        let (mut declarations, mut starts) = (String::new(), String::new());
        for (index, (local, name)) in function.locals.iter().zip(&names).enumerate() {
            let is_parameter = index < function.parameters;
            match &local.ty {
                _ if local.by_reference => {}
                Type::Scalar(_) if is_parameter => {}
                Type::Scalar(_) => {
                    let _ = writeln!(declarations, "    {} = 0;", self.declared(&local.ty, name));
                }
                ty => {
                    let image = bytes(&program.start(ty));
                    let _ = writeln!(declarations, "    static const uint8_t {name}_start[] = {{{image}}};");
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
        let mut all: Vec<&str> = vec!["call", "memory"];
        all.extend(function.instance.map(|_| "self"));
        all.extend(names.iter().map(String::as_str));
        let bounds: Vec<String> = names.iter().map(|name| format!("{name}_bounds")).collect();
        let opens = function.locals.iter().zip(&bounds).filter(|(local, _)| matches!(local.ty, Type::Open { .. }));
        all.extend(opens.map(|(_, name)| name.as_str()));
        for name in all.into_iter().filter(|name| !is_used(&statements, name)) {
            let _ = writeln!(declarations, "    (void){name};");
        }
        let _ = write!(self.text, "{declarations}{starts}{statements}");
        if self.scope.leaves {
            self.text.push_str("done:;\n");
        }
        for output in &self.outputs[number] {
            let (name, ty) = (&names[*output], &function.locals[*output].ty);
            let copied = match ty {
                Type::Scalar(_) => format!("*{name}_out = {name};"),
                _ => format!("memcpy({name}_out, &{name}, sizeof {name});"),
            };
            let _ = writeln!(self.text, "    if ({name}_out) {{\n        {copied}\n    }}");
        }
        self.text.push_str("}\n");
        Ok(())
    }

    fn line(&mut self, text: &str) {
        let _ = writeln!(self.text, "{:width$}{text}", "", width = 4 * self.scope.indent);
    }

    /// The name of a new temporary.
    fn temporary(&mut self, declared: impl FnOnce(&Self, &str) -> String) -> String {
        let name = format!("t_{}", self.scope.temporaries.len());
        let declared = declared(self, &name);
        self.scope.temporaries.push(declared);
        name
    }

    fn type_of(&self, place: &Place) -> Result<Type, String> {
        let function = self.scope.function.ok_or("there is no function")?;
        self.program
            .type_of(function, place)
            .ok_or_else(|| format!("{} has a place that does not exist", function.name))
    }
}

#[cfg(test)]
mod tests;
