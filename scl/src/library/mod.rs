//! What every program may use without declaring it: timers, counters, edge detection and text functions, written in SCL.
//! Gives their source, their names, and the laws of the blocks of `blocks` by name.

use crate::check::compiler::{BlockId, Compiler, Global, Interface, Operand, Parameter, Slot, State, Symbol};
use crate::check::types::{Elementary, Type};
use crate::front::lexer::Span;
use crate::front::syntax::{BlockKind, ExpressionId, ExpressionKind, SectionKind, key};
use crate::ir::{Body, Function, Value};
use blocks::{Role, StaticTable};
use manifest::Cpu;
use parameters::Source;
use std::collections::HashMap;
use std::rc::Rc;

const TIMERS: [&str; 4] = ["TON", "TOF", "TP", "TONR"];
const COUNTERS: [&str; 3] = ["CTU", "CTD", "CTUD"];
const COUNTED: [&str; 8] = ["SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT"];

/// The file name of the library in a program.
pub const FILE: &str = "the library";

/// Text functions, each for STRING and for WSTRING.
pub const TEXTS: [&str; 9] = ["LEN", "LEFT", "MID", "RIGHT", "CONCAT", "FIND", "DELETE", "INSERT", "REPLACE"];

/// Functions of dates and bits, by their names in SCL.
pub const FUNCTIONS: [&str; 4] = ["LDT_TO_DTL", "DTL_TO_LDT", "ENCO", "BITSUM"];

/// Functions called like the user's own, with all parameters named. FC105 and FC106 are their STEP 7 numbers.
const BLOCKS: [&str; 4] = ["SCALE", "UNSCALE", "FC105", "FC106"];

/// Functions between a text and an array, by element type of the array, each with the text type of the same characters.
const ARRAYS: [&str; 2] = ["STRG_TO_CHARS", "CHARS_TO_STRG"];
const ELEMENTS: [(&str, &str, &str); 4] = [
    ("CHAR", "CHAR", "STRING"),
    ("BYTE", "CHAR", "STRING"),
    ("WCHAR", "WCHAR", "WSTRING"),
    ("WORD", "WCHAR", "WSTRING"),
];

/// Internal functions, used to implement others.
pub const INNER: [&str; 10] = [
    "__WHOLE_TO_TEXT",
    "__REAL_TO_TEXT",
    "__TEXT_TO_WHOLE",
    "__TEXT_TO_REAL",
    "__PLACED",
    "__VAL_STRG_WHOLE",
    "__VAL_STRG_REAL",
    "__STRG_VAL",
    "STRING_TO_WSTRING",
    "WSTRING_TO_STRING",
];

/// The library as a source: timers for TIME and LTIME, counters for all integer types, text functions for both widths.
pub fn source() -> Source {
    let texts = [include_str!("library.scl"), include_str!("texts.scl")];
    let mut all = String::new();
    let blocks = texts.iter().flat_map(|text| text.split("\n\n"));
    for block in blocks.filter(|block| block.contains("END_FUNCTION") || block.contains("END_TYPE")) {
        let name = block.split('"').nth(1).unwrap_or_default();
        if TEXTS.contains(&name) {
            all += block;
            all.push('\n');
            all += &block
                .replace(": STRING", ": WSTRING")
                .replace(&format!("\"{name}\""), &format!("\"{name}_WSTRING\""))
                .replace(&format!("#{name}"), &format!("#{name}_WSTRING"));
        } else if ARRAYS.contains(&name) {
            for (of, character, text) in ELEMENTS {
                all += &block
                    .replace("OF CHAR", &format!("OF {of}"))
                    .replace(": STRING", &format!(": {text}"))
                    .replace("CHAR_TO_CHAR(#STRG", &format!("{character}_TO_{of}(#STRG"))
                    .replace("CHAR_TO_CHAR(#CHARS", &format!("{of}_TO_{character}(#CHARS"))
                    .replace("CHAR_TO_WORD", &format!("{of}_TO_WORD"))
                    .replace(&format!("\"{name}\""), &format!("\"{name}_{of}\""))
                    .replace(&format!("#{name}"), &format!("#{name}_{of}"));
                all.push('\n');
            }
        } else if TIMERS.contains(&name) {
            all += block;
            all += &block.replace("TIME", "LTIME").replace(&format!("\"{name}\""), &format!("\"{name}_LTIME\""));
        } else if COUNTERS.contains(&name) {
            for of in COUNTED {
                all += &block
                    .replace(": INT", &format!(": {of}"))
                    .replace(&format!("\"{name}\""), &format!("\"{name}_{of}\""));
            }
        } else {
            all += block;
        }
        all.push('\n');
    }
    Source::new(FILE, all.into_bytes())
}

/// Defines the constants that a block of the library uses.
pub fn constants(cpu: Cpu, name: &str, symbols: &mut HashMap<String, Symbol>) {
    let mut add = |name: &str, of: Elementary, value: i128| {
        let value = Operand::Value(of, crate::ir::Expr::Const(Value::new(of.scalar(), value as u64)));
        symbols.insert(name.to_string(), Symbol::Constant(value));
    };
    add("__CLASSIC", Elementary::Bool, i128::from(cpu == Cpu::S7300));
    add("__UNIT", Elementary::LInt, if name.ends_with("_LTIME") { 1 } else { 1_000_000 });
    let counted = name.split_once('_').and_then(|(_, of)| Elementary::named(of)).filter(|of| of.is_whole());
    if let Some(of) = counted {
        let (low, high) = of.range();
        add("__MIN", of, low);
        add("__MAX", of, high);
    }
}

/// The block of the library that a type name denotes.
fn named(name: &str) -> Option<String> {
    let name = match name {
        "IEC_TIMER" => "TON",
        "IEC_LTIMER" => "TON_LTIME",
        "IEC_COUNTER" | "CTU" => "CTU_INT",
        "IEC_SCOUNTER" => "CTU_SINT",
        "IEC_DCOUNTER" => "CTU_DINT",
        "IEC_LCOUNTER" => "CTU_LINT",
        "IEC_USCOUNTER" => "CTU_USINT",
        "IEC_UCOUNTER" => "CTU_UINT",
        "IEC_UDCOUNTER" => "CTU_UDINT",
        "IEC_ULCOUNTER" => "CTU_ULINT",
        "CTD" => "CTD_INT",
        "CTUD" => "CTUD_INT",
        // STEP 7 numbers.
        "SFB0" => "CTU_INT",
        "SFB1" => "CTD_INT",
        "SFB2" => "CTUD_INT",
        "SFB3" => "TP",
        "SFB4" => "TON",
        "SFB5" => "TOF",
        "FC105" => "SCALE",
        "FC106" => "UNSCALE",
        _ => name.strip_suffix("_TIME").unwrap_or(name),
    };
    let timer = name.strip_suffix("_LTIME").unwrap_or(name);
    let is_timer = TIMERS.contains(&timer);
    let is_counter = name.split_once('_').is_some_and(|(kind, of)| COUNTERS.contains(&kind) && COUNTED.contains(&of));
    let is_other = ["R_TRIG", "F_TRIG", "SR", "RS", "RUNTIME", "RD_SYS_T"].contains(&name)
        || [&TEXTS[..], &FUNCTIONS, &BLOCKS, &INNER].iter().any(|names| names.contains(&name))
        || name.strip_suffix("_WSTRING").is_some_and(|name| TEXTS.contains(&name))
        || name.rsplit_once('_').is_some_and(|(name, _)| ARRAYS.contains(&name));
    (is_timer || is_counter || is_other).then(|| name.to_string())
}

/// Whether a name is a system block or type.
pub fn is_system(name: &str) -> bool {
    let name = key(name);
    named(&name).is_some() || natives().iter().any(|native| native.eq_ignore_ascii_case(&name))
}

/// Whether a name is a function called like the user's own.
pub fn is_block(name: &str) -> bool {
    BLOCKS.contains(&name)
}

/// Whether a name is a kind of timer or counter that a variable of a generic type may be called as.
pub fn is_method(name: &str) -> bool {
    let kind = name.split_once('_').map_or(name, |(kind, _)| kind);
    (TIMERS.contains(&kind) || COUNTERS.contains(&kind)) && named(name).is_some()
}

impl Compiler<'_> {
    /// A block of the library, or a native block.
    pub fn system_block(&mut self, name: &str) -> Option<usize> {
        if let Some(id) = named(name).and_then(|name| self.library.get(&name).copied()) {
            return self.interface(id, self.block(id).name.span);
        }
        self.native(name)
    }

    /// The record shared by library blocks with the same members, so that one variable may be called as any of them.
    pub fn shared_record(&mut self, id: BlockId) -> Option<usize> {
        if id.0 != self.library_file() {
            return None;
        }
        let name = self.block(id).name.key();
        let (kind, of) = name.split_once('_').map_or((name.as_str(), ""), |(kind, of)| (kind, of));
        let first = if TIMERS.contains(&kind) {
            TIMERS[0]
        } else if COUNTERS.contains(&kind) {
            COUNTERS[0]
        } else {
            return None;
        };
        if kind == first {
            return None;
        }
        let first = if of.is_empty() { first.to_string() } else { format!("{first}_{of}") };
        let id = self.library.get(&first).copied()?;
        self.interface(id, self.block(id).name.span).map(|block| self.blocks[block].record)
    }

    /// The block that a variable is called or read as, if its type allows several.
    pub fn as_method(&mut self, of: usize, method: &str) -> Option<usize> {
        let id = self.blocks[of].source.filter(|(file, _)| *file == self.library_file())?;
        let own = self.block(id).name.key();
        let suffix = own.split_once('_').map_or("", |(_, of)| of);
        let name = match (method.contains('_'), suffix) {
            (false, "") => method.to_string(),
            (false, of) => format!("{method}_{of}"),
            (true, _) => method.to_string(),
        };
        let called = self.system_block(&name)?;
        (self.blocks[called].record == self.blocks[of].record).then_some(called)
    }

    /// Whether a block is a timer, whose outputs are updated when they are read.
    pub fn is_timer(&self, of: usize) -> bool {
        let Some(id) = self.blocks[of].source.filter(|(file, _)| *file == self.library_file()) else { return false };
        let name = self.block(id).name.key();
        TIMERS.contains(&name.strip_suffix("_LTIME").unwrap_or(&name))
    }

    /// Collects the kinds that variables of generic types are called as, by the last name of their paths.
    pub fn collect_kinds(&mut self) {
        for tree in &self.trees[..self.library_file()] {
            for number in 0..tree.expressions.len() {
                let ExpressionKind::Call(callee, _) = &tree.expressions[ExpressionId(number as u32)].kind else {
                    continue;
                };
                let ExpressionKind::Member(base, method) = &tree.expressions[*callee].kind else { continue };
                let method = method.key();
                let Some(name) = last_name(tree, *base).filter(|_| is_method(&method)) else { continue };
                let earlier = self.kinds.entry(name.0.clone()).or_insert_with(|| method.clone());
                if *earlier != method {
                    let message = format!("{} is called both as {earlier} and as {method}", name.0);
                    self.report.error(name.1, message, Some("use one variable for each"));
                }
            }
        }
    }

    /// The native block of that name.
    fn native(&mut self, name: &str) -> Option<usize> {
        if let Some(block) = self.natives.get(name) {
            return Some(*block);
        }
        let table = table(name)?;
        let record = self.program.add_native(table.name)?;
        self.program.functions.push(Function {
            name: table.name.to_string(),
            instance: Some(record),
            locals: Vec::new(),
            parameters: 0,
            body: Body::Native(table.name),
        });
        let members = table.rows.iter().enumerate().map(|(number, row)| Parameter {
            name: row.name.to_string(),
            key: row.name.to_string(),
            section: match row.role {
                Role::Input | Role::Parameter | Role::Fixed | Role::Cycle => SectionKind::Input,
                Role::Output => SectionKind::Output,
                Role::Local => SectionKind::Static,
            },
            of: Elementary::named(row.kind.name()).map_or(Type::Wrong, Type::Elementary),
            slot: Slot::Member(number),
            comment: row.description.to_string(),
            is_setting: false,
            is_hidden: false,
            is_retained: false,
        });
        let members: Vec<Parameter> = members.collect();
        for (number, member) in members.iter().enumerate() {
            self.declare_member(record, number, member.section.into(), &member.of);
        }
        let symbols = members
            .iter()
            .map(|member| (member.key.clone(), Symbol::Variable(member.section, member.of.clone(), member.slot)));
        self.blocks.push(Interface {
            name: table.name.to_string(),
            kind: BlockKind::FunctionBlock,
            source: None,
            symbols: Rc::new(symbols.collect()),
            members,
            result: Type::Void,
            record,
            function: self.program.functions.len() - 1,
            eno: None,
            views: Vec::new(),
            is_stub: false,
        });
        self.natives.insert(name.to_string(), self.blocks.len() - 1);
        Some(self.blocks.len() - 1)
    }

    /// An instance that no source declares, created because its use determines its type.
    pub fn implied(&mut self, name: &str, of: usize) -> Global {
        match self.globals.get(&key(name)) {
            Some(State::Known(global)) => global.clone(),
            _ => self.add_global(name, Type::Instance(of)),
        }
    }
}

/// The last name of a path, in upper case.
pub fn last_name(tree: &crate::front::syntax::Tree, path: ExpressionId) -> Option<(String, Span)> {
    match &tree.expressions[path].kind {
        ExpressionKind::Name(_, name) | ExpressionKind::Member(_, name) => Some((name.key(), name.span)),
        ExpressionKind::Index(base, _) => last_name(tree, *base),
        _ => None,
    }
}

/// The tables of the native blocks.
fn tables() -> Vec<&'static StaticTable> {
    struct Tables(Vec<&'static StaticTable>);
    impl blocks::EachBlock for Tables {
        fn block<B: blocks::Block>(&mut self) {
            self.0.push(B::TABLE);
        }
    }
    let mut tables = Tables(Vec::new());
    blocks::for_each_block(&mut tables);
    tables.0
}

/// The names of the native blocks.
pub fn natives() -> Vec<&'static str> {
    tables().into_iter().map(|table| table.name).collect()
}

/// The table of a native block, by its name or an alias such as `FB41`.
fn table(name: &str) -> Option<&'static StaticTable> {
    let is_it = |table: &&StaticTable| {
        let mut names = table.aliases.iter().chain([&table.name]);
        names.any(|alias| alias.replace(' ', "").eq_ignore_ascii_case(name))
    };
    tables().into_iter().find(is_it)
}
