//! Prints the source for the PLC.

use super::outcome;
use super::tape::{Entry, Tape};
use crate::print::Dialect;
use blocks::{Kind, StaticRow};
use std::fmt::Write;

/// The names and numbers of the blocks in the PLC.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    /// The PLC's own block, such as `FB41` or a name.
    pub block: String,
    /// STEP 7: the number of the function block and of the first data block; the other data blocks follow.
    pub first: u16,
}

impl Names {
    /// The default names. The PLC's own block has the block's name in TIA Portal, and its FB number in STEP 7; `None`
    /// if it has no such number.
    pub fn new(tape: &Tape, dialect: Dialect) -> Option<Names> {
        let number = tape.table.aliases.iter().find(|alias| alias.starts_with("FB"));
        let block = match dialect {
            Dialect::Tia => tape.table.name.to_string(),
            Dialect::Step7 => number?.replace(' ', ""),
        };
        Some(Names { block, first: 400 })
    }
}

/// The maximum number of tape entries per data block: the oldest STEP 7 CPUs limit a data block to 16 KB.
const fn part(dialect: Dialect) -> usize {
    match dialect {
        Dialect::Tia => 8192,
        Dialect::Step7 => 2048,
    }
}

struct Source<'a> {
    tape: &'a Tape,
    names: &'a Names,
    dialect: Dialect,
    text: String,
}

/// Prints the source for the PLC: the tape, the result, and the function block with its instance data block, which a
/// cyclic organization block must call.
pub fn print(tape: &Tape, names: &Names, dialect: Dialect) -> String {
    let mut source = Source { tape, names, dialect, text: String::new() };
    source.head();
    source.result();
    for (number, entries) in tape.entries.chunks(part(dialect)).enumerate() {
        source.part(number, entries);
    }
    source.block();
    source.text
}

/// The size of an entry in the PLC, in bytes.
const ENTRY: usize = 5;

/// The size of the largest data block of a tape, in bytes.
pub const fn largest(dialect: Dialect) -> usize {
    ENTRY * part(dialect)
}

/// The SCL statement that calls the proof's function block.
pub fn call(tape: &Tape, names: &Names, dialect: Dialect) -> String {
    let source = Source { tape, names, dialect, text: String::new() };
    match dialect {
        Dialect::Tia => format!("{}();", source.name(1)),
        Dialect::Step7 => format!("{}.{}();", source.name(0), source.name(1)),
    }
}

/// The name of the result data block.
pub fn result(tape: &Tape, names: &Names, dialect: Dialect) -> String {
    Source { tape, names, dialect, text: String::new() }.name(2)
}

/// The size of the tape in the PLC's memory, in bytes, and the number of data blocks it needs.
fn size(tape: &Tape, dialect: Dialect) -> (usize, usize) {
    (ENTRY * tape.entries.len(), tape.entries.len().div_ceil(part(dialect)))
}

impl Tape {
    /// The size of the tape in bytes, which is needed in both load memory and work memory, and the number of data
    /// blocks.
    pub fn size(&self, dialect: Dialect) -> (usize, usize) {
        size(self, dialect)
    }
}

impl Source<'_> {
    fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    /// A variable of the function block, in the dialect's notation.
    fn own(&self, name: &str) -> String {
        if self.dialect == Dialect::Tia { format!("#{name}") } else { name.to_string() }
    }

    /// The name of the function block (0), its instance data block (1), the result (2) and the parts of the tape (from
    /// 3).
    fn name(&self, of: usize) -> String {
        let block = self.tape.table.name;
        match (self.dialect, of) {
            (Dialect::Step7, 0) => format!("FB{}", self.names.first),
            (Dialect::Step7, of) => format!("DB{}", usize::from(self.names.first) + of - 1),
            (Dialect::Tia, 0) => format!("\"PROVE_{block}\""),
            (Dialect::Tia, 1) => format!("\"PROVE_{block}_DB\""),
            (Dialect::Tia, 2) => format!("\"PROVE_{block}_RESULT\""),
            (Dialect::Tia, of) => format!("\"PROVE_{block}_TAPE_{}\"", of - 2),
        }
    }

    fn attributes(&mut self, is_optimized: bool) {
        if self.dialect == Dialect::Tia {
            let optimized = if is_optimized { "TRUE" } else { "FALSE" };
            self.line(&format!("{{ S7_Optimized_Access := '{optimized}' }}\nVERSION : 0.1"));
        } else {
            self.line("VERSION : '0.1'");
        }
    }

    fn head(&mut self) {
        let Tape { table, calls, seed, entries, .. } = self.tape;
        let (bytes, parts) = size(self.tape, self.dialect);
        self.line(&format!(
            "// Compares {} of this PLC with the law of {}: {calls} calls, seed {seed}.",
            self.names.block, table.name
        ));
        self.line("//");
        let call = call(self.tape, self.names, self.dialect);
        self.line(&format!("// Load all blocks of this source and call the function block once per cycle: {call}"));
        self.line(&format!(
            "// It calls the tested block once per cycle and stops after {calls} calls or at the first difference."
        ));
        self.line(&format!("// Afterwards, {} contains the result; read it with plcfmu prove --read.", self.name(2)));
        self.line("// To run it again, reload its data blocks with their start values.");
        self.line(&format!("// The tape has {} changes: {bytes} bytes in {parts} data blocks.", entries.len()));
    }

    fn result(&mut self) {
        self.line(&format!("\nDATA_BLOCK {}", self.name(2)));
        self.attributes(false);
        self.line("    STRUCT");
        for field in outcome::FIELDS {
            self.line(&format!("        {:12} : {};  // {}", field.name, field.ty, field.docs));
        }
        self.line("    END_STRUCT;\nBEGIN");
        for (name, value) in outcome::starts(self.tape) {
            self.line(&format!("    {name} := {value};"));
        }
        self.line("END_DATA_BLOCK");
    }

    fn part(&mut self, number: usize, entries: &[Entry]) {
        self.line(&format!("\nDATA_BLOCK {}", self.name(3 + number)));
        self.attributes(true);
        self.line("    STRUCT");
        self.line(&format!("        value : ARRAY[0..{}] OF DWORD;", entries.len() - 1));
        self.line(&format!("        what : ARRAY[0..{}] OF BYTE;", entries.len() - 1));
        self.line("    END_STRUCT;\nBEGIN");
        for (index, entry) in entries.iter().enumerate() {
            let what = entry.what | if entry.is_last { 0x80 } else { 0 };
            if entry.bits != 0 {
                let _ = write!(self.text, "    value[{index}] := DW#16#{:X};", entry.bits);
            }
            let _ = writeln!(self.text, "    what[{index}] := B#16#{what:X};");
        }
        self.line("END_DATA_BLOCK");
    }

    fn block(&mut self) {
        let tape = self.tape;
        let rows = tape.table.rows;
        let outputs = tape.outputs.len();
        self.line(&format!("\nFUNCTION_BLOCK {}", self.name(0)));
        self.attributes(true);
        self.line("VAR");
        let attribute = match self.dialect {
            Dialect::Tia if self.names.block == tape.table.name && !tape.table.aliases.is_empty() => {
                format!(" {{InstructionName := '{}'; LibVersion := '1.1'}}", self.names.block)
            }
            _ => String::new(),
        };
        let block = match self.dialect {
            Dialect::Tia if attribute.is_empty() => format!("\"{}\"", self.names.block),
            _ => self.names.block.clone(),
        };
        self.line(&format!("    tested{attribute} : {block};  // the PLC's own block"));
        self.line("    given : STRUCT  // inputs of the tested block");
        for row in tape.inputs.iter().map(|row| &rows[*row]).filter(|row| !row.is_inner()) {
            let start = crate::ir::Value::of_plc(row.start);
            let of = crate::check::types::Elementary::named(row.kind.name());
            let of = of.unwrap_or(crate::check::types::Elementary::DWord);
            let start = crate::print::literal(start, of, true, self.dialect).unwrap_or_default();
            self.line(&format!("        {} : {} := {start};", row.name, row.kind.name()));
        }
        self.line("    END_STRUCT;");
        self.line(&format!(
            "    expected : ARRAY[1..{outputs}] OF DWORD;  // expected bits of its outputs, from the tape"
        ));
        self.line(&format!("    found : ARRAY[1..{outputs}] OF DWORD;  // actual bits of its outputs"));
        self.line("    place : DINT;  // number of tape changes applied");
        self.line("END_VAR\nVAR_TEMP");
        for variable in ["part : INT", "index : INT", "value : DWORD", "what : INT", "output : INT", "is_last : BOOL"] {
            self.line(&format!("    {variable};"));
        }
        self.line("END_VAR\nBEGIN");
        self.body();
        self.line("END_FUNCTION_BLOCK");
        self.line(&format!("\nDATA_BLOCK {}", self.name(1)));
        self.attributes(true);
        self.line(&format!("{}\nBEGIN\nEND_DATA_BLOCK", self.name(0)));
    }

    fn body(&mut self) {
        let tape = self.tape;
        let rows = tape.table.rows;
        let result = self.name(2);
        let [part_name, index, value, what, output, is_last, place, expected, found, given, tested] =
            ["part", "index", "value", "what", "output", "is_last", "place", "expected", "found", "given", "tested"]
                .map(|name| self.own(name));
        self.line(&format!("    IF {result}.state <> {} THEN", outcome::RUNNING));
        self.line("        RETURN;\n    END_IF;");
        self.line(&format!("    {value} := DW#16#0;\n    {what} := 0;"));
        self.line("    // Apply the changes on the tape up to this call.");
        self.line("    REPEAT");
        let size = part(self.dialect);
        self.line(&format!("        {part_name} := DINT_TO_INT({place} / {size});"));
        self.line(&format!("        {index} := DINT_TO_INT({place} MOD {size});"));
        self.line(&format!("        CASE {part_name} OF"));
        for number in 0..tape.entries.len().div_ceil(size) {
            let data = self.name(3 + number);
            self.line(&format!("            {number}:"));
            self.line(&format!("                {value} := {data}.value[{index}];"));
            self.line(&format!("                {what} := BYTE_TO_INT({data}.what[{index}]);"));
        }
        self.line("        END_CASE;");
        self.line(&format!("        {place} := {place} + 1;"));
        self.line(&format!("        {is_last} := {what} >= 128;"));
        self.line(&format!("        IF {is_last} THEN\n            {what} := {what} - 128;\n        END_IF;"));
        self.line("        // Set an input of this call, or the expected value of an output after it.");
        self.line(&format!("        CASE {what} OF"));
        for (number, row) in tape.inputs.iter().enumerate() {
            let row = &rows[*row];
            // Inputs of inner blocks are written to the instance.
            let to = format!("{}.{}", if row.is_inner() { &tested } else { &given }, row.name);
            self.line(&format!(
                "            {}:\n                {to} := {};",
                number + 1,
                from_bits(row.kind, &value)
            ));
        }
        let first = tape.inputs.len() + 1;
        self.line(&format!("            {first}..{}:", tape.inputs.len() + tape.outputs.len()));
        self.line(&format!("                {expected}[{what} - {}] := {value};", first - 1));
        self.line("        END_CASE;");
        self.line(&format!("    UNTIL {is_last}\n    END_REPEAT;"));
        self.line("    // Call the PLC's own block once and read the bits of its outputs.");
        let own: Vec<&StaticRow> = tape.inputs.iter().map(|row| &rows[*row]).filter(|row| !row.is_inner()).collect();
        for (number, row) in own.iter().enumerate() {
            let before = if number == 0 { format!("    {tested}(") } else { "        ".to_string() };
            let behind = if number + 1 == own.len() { ");" } else { "," };
            self.line(&format!("{before}{} := {given}.{}{behind}", row.name, row.name));
        }
        for (number, row) in tape.outputs.iter().enumerate() {
            let row = &rows[*row];
            let text = to_bits(row.kind, &format!("{tested}.{}", row.name));
            self.line(&format!("    {found}[{}] := {text};", number + 1));
        }
        self.line(&format!("    {result}.done := {result}.done + 1;"));
        self.line("    // The first output whose bits differ from the tape ends the proof.");
        self.line(&format!("    FOR {output} := 1 TO {} DO", tape.outputs.len()));
        self.line(&format!("        IF {found}[{output}] <> {expected}[{output}] THEN"));
        self.line(&format!("            {result}.state := {};", outcome::DIFFERS));
        self.line(&format!("            {result}.output := {output};"));
        self.line(&format!("            {result}.expected := {expected}[{output}];"));
        self.line(&format!("            {result}.found := {found}[{output}];"));
        self.line("            RETURN;\n        END_IF;\n    END_FOR;");
        self.line(&format!("    IF {result}.done >= {result}.calls THEN"));
        self.line(&format!("        {result}.state := {};\n    END_IF;", outcome::COMPLETE));
    }
}

/// Converts a DWORD of bits to a value of a type.
fn from_bits(kind: Kind, value: &str) -> String {
    match kind {
        Kind::Bool => format!("{value} <> DW#16#0"),
        Kind::Real => format!("DWORD_TO_REAL({value})"),
        Kind::Time => format!("DINT_TO_TIME(DWORD_TO_DINT({value}))"),
        Kind::Int => format!("WORD_TO_INT(DWORD_TO_WORD({value}))"),
        kind => format!("DWORD_TO_{}({value})", kind.name()),
    }
}

/// Converts a value to a DWORD of bits.
fn to_bits(kind: Kind, value: &str) -> String {
    match kind {
        Kind::Real => format!("REAL_TO_DWORD({value})"),
        Kind::Time => format!("DINT_TO_DWORD(TIME_TO_DINT({value}))"),
        Kind::Int => format!("WORD_TO_DWORD(INT_TO_WORD({value}))"),
        kind => format!("{}_TO_DWORD({value})", kind.name()),
    }
}
