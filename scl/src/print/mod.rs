//! From program to SCL: prints a typed program as sources for TIA Portal or STEP 7, with the program's names, order and
//! comments.
//!
//! A printed program, recompiled with [`compile`](crate::compile()), produces the same results to the last bit. Where
//! SCL has no notation for an operation, or the dialect lacks a type, the printer fails and names it instead of
//! printing something nearly equivalent.
//!
//! A record with a function that is called from outside its instance becomes a function block, any other record a type,
//! and a member of memory a data block. A function block in a PLC has no methods: other functions on a record become
//! functions that receive the members they read as inputs and the members they write as in-out parameters.

mod declaration;
mod expression;
mod facts;
mod literal;
mod place;
mod statement;
#[cfg(test)]
mod tests;

use crate::check::types::{Class, Elementary};
use crate::front::syntax::key;
use crate::ir::{Function, Kind, Program, Scalar, Type};
use facts::{Facts, Use};
use std::collections::{BTreeMap, BTreeSet, HashSet};

pub(crate) use literal::literal;

/// The target compiler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// TIA Portal, for S7-1200, S7-1500, S7-300 and S7-400.
    Tia,
    /// STEP 7 V5 with S7-SCL, for S7-300 and S7-400.
    Step7,
}

impl Dialect {
    /// Returns the type, or an error if the dialect does not have it.
    fn check(self, of: Elementary) -> Result<Elementary, String> {
        let is_there = self == Dialect::Tia
            || of.bits() <= 32
                && !matches!(
                    of,
                    Elementary::SInt
                        | Elementary::USInt
                        | Elementary::UInt
                        | Elementary::UDInt
                        | Elementary::LTime
                        | Elementary::WChar
                );
        if is_there {
            Ok(of)
        } else {
            Err(format!("STEP 7 has no type {}; print the program for TIA Portal", of.name()))
        }
    }
}

/// The maximum length of a symbol or variable name in STEP 7.
const STEP7_NAME: usize = 24;

/// The maximum width of a printed line, in bytes, unless the line cannot be broken.
const WIDTH: usize = 110;

/// The reserved words of SCL, in lower case.
const KEYWORDS: &str = "and any array at begin block_db block_fb block_fc block_sdb bool by byte case char const constant continue \
    counter data_block date date_and_time db dint div do dt dtl dword else elsif en end_case end_const end_data_block end_for \
    end_function end_function_block end_if end_label end_organization_block end_region end_repeat end_struct end_type end_var \
    end_while eno exit false fb fc for function function_block goto if int label lint lreal ltime lword mod nil not of ok or \
    organization_block pointer real region repeat ret_val return s5time sdb sfb sfc sint string struct then time time_of_day timer \
    to tod true type udint udt uint ulint until usint var var_in_out var_input var_output var_temp variant void wchar while with \
    word wstring xor";

/// Standard functions that a variable without `#` would shadow.
const STANDARD: &str = "abs acos asin atan ceil cos deco enco exp expd floor frac limit ln log max min move mux rol ror round sel shl \
    shr sin sqr sqrt swap tan trunc";

/// Prints the given functions, their dependencies, and the data blocks they use.
///
/// # Errors
/// The dialect cannot express a part of the program; the message names it.
pub fn print(program: &Program, roots: &[usize], dialect: Dialect) -> Result<String, String> {
    let (program, facts) = facts::prepared(program, roots, dialect)?;
    let mut printer = Printer::new(&program, &facts, dialect);
    printer.head();
    printer.types()?;
    for number in &facts.reached {
        printer.function(*number)?;
    }
    printer.data_blocks()?;
    Ok(printer.text)
}

struct Printer<'a> {
    program: &'a Program,
    facts: &'a Facts,
    dialect: Dialect,
    text: String,
    /// The printed names of records, functions and members of memory, each by number.
    records: Vec<String>,
    functions: Vec<String>,
    globals: Vec<String>,
    /// The name of the data block for members of memory that are not structures.
    loose: String,
    /// The printed names of each function's locals and of the parts of its instance.
    interfaces: BTreeMap<usize, Interface>,
    scope: Scope<'a>,
}

#[derive(Clone, Default)]
struct Interface {
    locals: Vec<String>,
    /// The names of the instance's parts, by path of member indices.
    members: BTreeMap<Vec<usize>, String>,
}

/// State of the function being printed.
#[derive(Default)]
struct Scope<'a> {
    function: Option<&'a Function>,
    number: usize,
    interface: Interface,
    /// The locals used so far.
    used: BTreeSet<usize>,
    /// Temporaries added by the printer: names and types.
    temporaries: Vec<(String, String)>,
    labels: BTreeSet<usize>,
    indent: usize,
    lines: Vec<String>,
}

/// The default type of a scalar. Unsigned integers become bit strings, because STEP 7 has no unsigned integers.
fn natural(ty: Scalar) -> Elementary {
    match ty {
        Scalar::Bool => Elementary::Bool,
        Scalar::F32 => Elementary::Real,
        Scalar::F64 => Elementary::LReal,
        Scalar::U8 => Elementary::Byte,
        Scalar::U16 => Elementary::Word,
        Scalar::U32 => Elementary::DWord,
        Scalar::U64 => Elementary::LWord,
        _ => number(ty),
    }
}

/// The type in which arithmetic on a scalar is done.
fn number(ty: Scalar) -> Elementary {
    match ty {
        Scalar::Bool | Scalar::F32 | Scalar::F64 => natural(ty),
        ty => Elementary::integer(8 * ty.size() as u32, ty.is_signed()),
    }
}

/// The bit string type for a scalar; BOOL for a truth value.
fn bits(ty: Scalar) -> Elementary {
    if ty == Scalar::Bool { Elementary::Bool } else { Elementary::bit_string(8 * ty.size() as u32) }
}

/// The declared type of a scalar: the source's type `of` unless it is a date or is stored as a different scalar,
/// otherwise the default type.
fn declared(ty: Scalar, of: Option<Kind>) -> Elementary {
    let of = of.and_then(|of| Elementary::named(of.name()));
    of.filter(|of| of.scalar() == ty && of.class() != Class::Date).unwrap_or(natural(ty))
}

/// Converts names to unique names (ignoring case) of at most `most` ASCII letters, digits and underscores, none of
/// which is in `taken`.
fn names<'a>(of: impl IntoIterator<Item = &'a str>, taken: &[String], most: usize) -> Vec<String> {
    names_of(of, taken, most, Notation::Bare)
}

/// How a name is written.
#[derive(Clone, Copy, PartialEq)]
enum Notation {
    /// Without quotation marks.
    Bare,
    /// In quotation marks: it may be a reserved word.
    Quoted,
    /// In TIA Portal's quotation marks, which allow any name.
    Any,
}

/// Converts names to unique names (ignoring case) of at most `most` bytes in this notation, none of which is in
/// `taken`.
fn names_of<'a>(
    of: impl IntoIterator<Item = &'a str>,
    taken: &[String],
    most: usize,
    notation: Notation,
) -> Vec<String> {
    let mut used: HashSet<String> = taken.iter().map(|name| key(name)).collect();
    let mut all: Vec<String> = Vec::new();
    for name in of {
        let keeps = notation == Notation::Any && !name.is_empty() && !name.contains(['"', '\n']) && name.len() <= most;
        let mut name = if keeps { name.to_string() } else { ascii(name, most, notation == Notation::Bare) };
        let is_taken = |name: &str| {
            let is_word = is_keyword(name) || STANDARD.split_whitespace().any(|word| word.eq_ignore_ascii_case(name));
            is_word && notation == Notation::Bare || used.contains(&key(name))
        };
        let mut own = name.clone();
        let mut count = 1;
        while is_taken(&own) {
            count += 1;
            let suffix = format!("_{count}");
            while name.len() > most - suffix.len() {
                name.pop();
            }
            own = format!("{name}{suffix}");
        }
        used.insert(key(&own));
        all.push(own);
    }
    all
}

/// Converts a name to at most `most` ASCII letters, digits and underscores.
fn ascii(name: &str, most: usize, is_bare: bool) -> String {
    let mut name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    name = name.trim_matches('_').replace("__", "_");
    if name.is_empty() || name.starts_with(|first: char| first.is_ascii_digit()) {
        name = format!("x_{name}");
    }
    // `m1` would be an address in STEP 7.
    let letters = name.len() - name.trim_start_matches(|c: char| c.is_ascii_alphabetic()).len();
    if is_bare && letters <= 2 && name.len() > letters && name[letters..].bytes().all(|byte| byte.is_ascii_digit()) {
        name.insert(letters, '_');
    }
    name.truncate(most);
    name
}

fn is_keyword(name: &str) -> bool {
    KEYWORDS.split_whitespace().any(|word| word.eq_ignore_ascii_case(name))
}

/// Whether a name in an interface needs no quotation marks.
fn is_plain(name: &str) -> bool {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    !name.is_empty() && name.chars().all(is_word) && !name.starts_with(|first: char| first.is_ascii_digit())
}

impl<'a> Printer<'a> {
    fn new(program: &'a Program, facts: &'a Facts, dialect: Dialect) -> Printer<'a> {
        let most = if dialect == Dialect::Step7 { STEP7_NAME } else { 120 };
        // A function block and the record of its instance share a name.
        let blocks = facts.blocks.keys().copied().filter(|record| !facts.systems.contains_key(record));
        let own: Vec<usize> = blocks.collect();
        let notation = if dialect == Dialect::Tia { Notation::Any } else { Notation::Quoted };
        let mut taken = names_of(own.iter().map(|record| program.records[*record].name.as_str()), &[], most, notation);
        let mut records = vec![String::new(); program.records.len()];
        for (record, name) in own.iter().zip(&taken) {
            records[*record].clone_from(name);
        }
        let mut functions = vec![String::new(); program.functions.len()];
        let named: Vec<usize> =
            facts.reached.iter().copied().filter(|number| facts.uses[number] != Use::Block).collect();
        let own = names_of(named.iter().map(|number| program.functions[*number].name.as_str()), &taken, most, notation);
        for (number, name) in named.iter().zip(&own) {
            functions[*number].clone_from(name);
        }
        taken.extend(own);
        let members = program.records[program.memory].members.iter().map(|member| member.name.as_str());
        let globals = names_of(members, &taken, most, notation);
        taken.extend(globals.iter().cloned());
        // Named last: in the program, the type of a data block's own members has the same name as the data block.
        let rest: Vec<usize> = (0..program.records.len()).filter(|record| records[*record].is_empty()).collect();
        let more = names_of(rest.iter().map(|record| program.records[*record].name.as_str()), &taken, most, notation);
        for (record, name) in rest.iter().zip(&more) {
            records[*record].clone_from(name);
        }
        taken.extend(more);
        let loose = names(["globals"], &taken, most).swap_remove(0);
        for (record, system) in &facts.systems {
            records[*record].clone_from(system);
        }
        let (text, scope, interfaces) = (String::new(), Scope::default(), BTreeMap::new());
        let mut printer =
            Printer { program, facts, dialect, text, records, functions, globals, loose, interfaces, scope };
        for number in &facts.reached {
            printer.interfaces.insert(*number, printer.interface(*number));
        }
        printer
    }

    /// The name of a part of a record: the names of the members on its path, joined.
    fn path_name(&self, record: usize, path: &[usize]) -> String {
        let mut ty = Type::Record(record);
        let mut parts = Vec::new();
        for number in path {
            let Type::Record(record) = ty else { break };
            let member = &self.program.records[record].members[*number];
            parts.push(member.name.clone());
            ty = member.ty.clone();
        }
        parts.join("_")
    }

    /// Chooses the printed names of a function's locals and of the parts of its instance.
    fn interface(&self, number: usize) -> Interface {
        let function = &self.program.functions[number];
        let mut members = BTreeMap::new();
        if let Some(record) = function.instance {
            let all = &self.program.records[record].members;
            match self.facts.members.get(&number) {
                Some(used) => {
                    let paths = used.keys().map(|path| (path, self.path_name(record, path)));
                    let (paths, names_of): (Vec<&Vec<usize>>, Vec<String>) = paths.unzip();
                    let most = if self.dialect == Dialect::Step7 { STEP7_NAME } else { 120 };
                    let short = if names_of.iter().all(|name| name.len() <= most && is_plain(name)) {
                        names_of
                    } else {
                        names(names_of.iter().map(String::as_str), &[], most)
                    };
                    members.extend(paths.into_iter().cloned().zip(short));
                }
                None => members.extend(all.iter().enumerate().map(|(at, member)| (vec![at], member.name.clone()))),
            }
        }
        let mut taken: Vec<String> = members.values().cloned().collect();
        taken.push(self.functions[number].clone());
        let most = if self.dialect == Dialect::Step7 { STEP7_NAME } else { 120 };
        let mut locals = names(function.locals.iter().map(|local| local.name.as_str()), &taken, most);
        if let Some(value) = self.facts.values.get(&number) {
            locals[*value].clone_from(&self.functions[number]);
        }
        Interface { locals, members }
    }

    /// A local variable or member of the block, as written in a statement.
    fn own(&self, name: &str) -> String {
        match self.dialect {
            Dialect::Tia if is_plain(name) => format!("#{name}"),
            Dialect::Tia => format!("#\"{name}\""),
            Dialect::Step7 => name.to_string(),
        }
    }

    /// The name of a member as written in a path or declaration.
    fn member(&self, name: &str) -> Result<String, String> {
        match self.dialect {
            _ if is_plain(name) && !is_keyword(name) => Ok(name.to_string()),
            Dialect::Tia => Ok(format!("\"{name}\"")),
            Dialect::Step7 => Err(format!("STEP 7 does not allow the name {name:?}; print the program for TIA Portal")),
        }
    }

    /// The type of a local.
    fn local_type(&self, number: usize) -> &'a Type {
        &self.program.functions[self.scope.number].locals[number].ty
    }
}
