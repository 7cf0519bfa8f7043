//! Everything a program may use without declaring it: timers, counters, edge detection and string functions, written in
//! SCL, and the blocks of the `blocks` crate. Provides the library source and looks blocks up by name.

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
use std::sync::LazyLock;

/// The file name of the library in a program.
pub(crate) const FILE: &str = "the library";

/// The groups of library blocks, as named in the library sources.
const TIMERS: &str = "TIMERS";
const COUNTERS: &str = "COUNTERS";
/// String functions, each for STRING and for WSTRING.
const TEXTS: &str = "TEXTS";
/// Clock, date and bit functions.
const FUNCTIONS: &str = "FUNCTIONS";
/// Functions that are called like the user's own: with all parameters named.
const FCS: &str = "FCS";
/// Internal functions, used to implement others.
const INNER: &str = "INNER";

/// A library function or function block.
struct LibraryBlock {
    name: String,
    /// The name without its variant: TON for TON_LTIME.
    family: &'static str,
    group: &'static str,
}

impl LibraryBlock {
    /// The suffix that distinguishes it within its family: `_LTIME` for TON_LTIME, empty for TON.
    fn variant(&self) -> &str {
        &self.name[self.family.len()..]
    }
}

/// The source text of the library, and its blocks.
static LIBRARY: LazyLock<(String, Vec<LibraryBlock>)> = LazyLock::new(|| {
    let (mut text, mut blocks) = (String::new(), Vec::new());
    let paragraphs =
        [include_str!("library.scl"), include_str!("texts.scl")].into_iter().flat_map(|it| it.split("\n\n"));
    let (mut group, mut placeholders, mut variants) = ("", "", "");
    for paragraph in paragraphs {
        if let Some(heading) = paragraph.strip_prefix("// GROUP ") {
            let (name, choice) = heading.split_once(" FOR ").unwrap_or((heading, ""));
            (placeholders, variants) = choice.split_once(" IN ").unwrap_or_default();
            group = name;
        } else if paragraph.contains("\nEND_") {
            let name = paragraph.split('"').nth(1).filter(|_| !paragraph.contains("\nEND_TYPE"));
            for words in variants.split(", ") {
                text += &(variant(paragraph, placeholders, words) + "\n");
                blocks.extend(name.map(|name| {
                    let family = name.split_once('$').map_or(name, |(family, _)| family.trim_end_matches('_'));
                    LibraryBlock { name: variant(name, placeholders, words), family, group }
                }));
            }
        }
    }
    (text, blocks)
});

/// The text with each placeholder replaced by the word at the same position, or removed if there is none.
fn variant(text: &str, placeholders: &str, words: &str) -> String {
    let words = words.split(' ').chain(std::iter::repeat(""));
    let pairs = placeholders.split_whitespace().zip(words);
    pairs.fold(text.to_string(), |text, (placeholder, word)| text.replace(placeholder, word))
}

/// The library as a source: timers for TIME and LTIME, counters for all integer types, string functions for both
/// widths.
pub(crate) fn source() -> Source {
    Source::new(FILE, LIBRARY.0.clone().into_bytes())
}

fn block(name: &str) -> Option<&'static LibraryBlock> {
    LIBRARY.1.iter().find(|block| block.name == name)
}

fn is_in(group: &str, name: &str) -> bool {
    block(name).is_some_and(|block| block.group == group)
}

/// Whether this is the name of a library timer.
pub(crate) fn is_timer(name: &str) -> bool {
    is_in(TIMERS, name)
}

/// Whether this is the name of a string function, for either character width.
pub(crate) fn is_text(name: &str) -> bool {
    LIBRARY.1.iter().any(|block| block.group == TEXTS && block.family == name)
}

/// Whether this is the name of a clock, date or bit function.
pub(crate) fn is_function(name: &str) -> bool {
    is_in(FUNCTIONS, name)
}

/// Whether only the library itself may call a function of this name.
pub(crate) fn is_inner(name: &str) -> bool {
    is_in(INNER, name)
}

/// Defines the constants that the source of this library block may use.
pub(crate) fn constants(cpu: Cpu, name: &str, symbols: &mut HashMap<String, Symbol>) {
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

/// The library name of a block that has another name in STEP 7 or as a generic type.
fn alias(name: &str) -> &str {
    match name {
        "IEC_TIMER" => "TON",
        "IEC_LTIMER" => "TON_LTIME",
        "IEC_COUNTER" => "CTU_INT",
        "IEC_SCOUNTER" => "CTU_SINT",
        "IEC_DCOUNTER" => "CTU_DINT",
        "IEC_LCOUNTER" => "CTU_LINT",
        "IEC_USCOUNTER" => "CTU_USINT",
        "IEC_UCOUNTER" => "CTU_UINT",
        "IEC_UDCOUNTER" => "CTU_UDINT",
        "IEC_ULCOUNTER" => "CTU_ULINT",
        // STEP 7 numbers.
        "SFB0" => "CTU_INT",
        "SFB1" => "CTD_INT",
        "SFB2" => "CTUD_INT",
        "SFB3" => "TP",
        "SFB4" => "TON",
        "SFB5" => "TOF",
        "FC105" => "SCALE",
        "FC106" => "UNSCALE",
        _ => name,
    }
}

/// The library block that a type name denotes.
fn named(name: &str) -> Option<&'static LibraryBlock> {
    let name = alias(name);
    let timer = name.strip_suffix("_TIME").and_then(block).filter(|of| of.group == TIMERS && of.variant().is_empty());
    timer.or_else(|| block(name)).or_else(|| block(&format!("{name}_INT")))
}

/// Whether a name denotes a system block or type.
pub(crate) fn is_system(name: &str) -> bool {
    let name = key(name);
    named(&name).is_some() || natives().iter().any(|native| native.eq_ignore_ascii_case(&name))
}

/// Whether a name denotes a library function that is called like the user's own.
pub(crate) fn is_block(name: &str) -> bool {
    is_in(FCS, alias(name))
}

/// Whether a name denotes a kind of timer or counter, such as TON: a variable of a generic type may be called as one.
pub(crate) fn is_method(name: &str) -> bool {
    let kind = name.split_once('_').map_or(name, |(kind, _)| kind);
    named(name).is_some_and(|block| [TIMERS, COUNTERS].contains(&block.group) && block.family == kind)
}

impl Compiler<'_> {
    /// The library block or native block that a type name denotes.
    pub fn system_block(&mut self, name: &str) -> Option<usize> {
        if let Some(id) = named(name).and_then(|block| self.library.get(&block.name).copied()) {
            return self.interface(id, self.block(id).name.span);
        }
        self.native(name)
    }

    /// The record that a timer or counter shares with all others of its variant, so that one variable may be called as
    /// any of them; `None` for other blocks and for the one that defines the record.
    pub fn shared_record(&mut self, id: BlockId) -> Option<usize> {
        if id.0 != self.library_file() {
            return None;
        }
        let own = block(&self.block(id).name.key()).filter(|own| [TIMERS, COUNTERS].contains(&own.group))?;
        let first = LIBRARY.1.iter().find(|first| first.group == own.group && first.variant() == own.variant())?;
        let id = self.library.get(&first.name).copied().filter(|_| first.family != own.family)?;
        self.interface(id, self.block(id).name.span).map(|block| self.blocks[block].record)
    }

    /// The block as which an instance of `of` is called or read, for a kind such as TON; `None` unless the instance may
    /// be of that kind.
    pub fn as_method(&mut self, of: usize, method: &str) -> Option<usize> {
        let id = self.blocks[of].source.filter(|(file, _)| *file == self.library_file())?;
        let variant =
            block(&self.block(id).name.key()).filter(|_| !method.contains('_')).map_or("", LibraryBlock::variant);
        let called = self.system_block(&format!("{method}{variant}"))?;
        (self.blocks[called].record == self.blocks[of].record).then_some(called)
    }

    /// Whether a block is a library timer, whose outputs are updated when they are read.
    pub fn is_timer(&self, of: usize) -> bool {
        let source = self.blocks[of].source.filter(|(file, _)| *file == self.library_file());
        source.is_some_and(|id| is_timer(&self.block(id).name.key()))
    }

    /// Collects, by the last name of its path, the kind of timer or counter as which each variable of a generic type is
    /// called.
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
                    self.report.error(name.1, message, Some("use a separate variable for each"));
                }
            }
        }
    }

    /// The native block with this name or alias, added to the program if necessary.
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

    /// A global instance that no source declares: it is created because its use determines its type.
    pub fn implied(&mut self, name: &str, of: usize) -> Global {
        match self.globals.get(&key(name)) {
            Some(State::Known(global)) => global.clone(),
            _ => self.add_global(name, Type::Instance(of)),
        }
    }
}

/// The last name of a path, in upper case.
pub(crate) fn last_name(tree: &crate::front::syntax::Tree, path: ExpressionId) -> Option<(String, Span)> {
    match &tree.expressions[path].kind {
        ExpressionKind::Name(_, name) | ExpressionKind::Member(_, name) => Some((name.key(), name.span)),
        ExpressionKind::Index(base, _) => last_name(tree, *base),
        _ => None,
    }
}

/// The tables of the native blocks, which the `blocks` crate implements.
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
pub(crate) fn natives() -> Vec<&'static str> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_timer_is_also_called_with_its_time() {
        assert!(["TON", "ton_time", "TONR_TIME", "TON_LTIME", "CTU_INT", "R_TRIG"].into_iter().all(is_system));
        let wrong = ["LEN_TIME", "R_TRIG_TIME", "CTU_INT_TIME", "TON_LTIME_TIME", "TON_TIME_TIME"];
        assert_eq!(wrong.into_iter().find(|name| is_system(name)), None);
    }
}
