//! What an FMU shows of a program.

use crate::compiler::{Compiler, Global, Slot, State};
use crate::program::walk::{self, Look};
use crate::program::{self, Argument, Base, Body, Call, Place, Program, Scalar, Statement, Step, What};
use crate::syntax::{SectionKind, key};
use crate::types::{Elementary, Type};
use std::collections::BTreeSet;

/// What a variable is for the one who uses the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Read in each call.
    Input,
    /// Read in each call, and changed rarely: a setting.
    Parameter,
    /// Written in each call.
    Output,
    /// Read and written: an input, and an output with `_out` behind its name.
    InOut,
    /// Inside.
    Local,
}

/// A variable of a program: a number, or a text.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name as it is written, with the members and indices that lead to it: `par.levelFull`, `feedback[1]`.
    pub name: String,
    /// The name of its type: REAL, for example.
    pub of: &'static str,
    /// What it is in the memory; `None` for a text.
    pub scalar: Option<Scalar>,
    /// What it is.
    pub role: Role,
    /// Whether its value survives a power failure.
    pub is_retained: bool,
    /// What its author says of it.
    pub comment: Comment,
}

/// A comment such as `// level of the tank; unit: bar, min 0, max 10`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comment {
    /// What remains without unit and range.
    pub text: String,
    /// The unit.
    pub unit: Option<String>,
    /// The lowest sensible value.
    pub min: Option<f64>,
    /// The highest sensible value.
    pub max: Option<f64>,
}

/// An interface has at most this many variables, and as many locals are shown; what is beyond is inside.
const MOST: usize = 100_000;

/// A local array with more elements is inside: a buffer of samples is no signal that a host reads.
const MOST_ELEMENTS: usize = 1000;

/// What is found, with what bounds it.
#[derive(Default)]
struct Found {
    variables: Vec<Variable>,
    locals: usize,
}

impl Found {
    /// Whether there is room for one more. An interface may have one too many, which is told as an error.
    fn has_room(&self, role: Role) -> bool {
        match role {
            Role::Local => self.locals < MOST,
            _ => self.variables.len() - self.locals <= MOST,
        }
    }

    fn push(&mut self, variable: Variable) {
        self.locals += usize::from(variable.role == Role::Local);
        self.variables.push(variable);
    }
}

/// Reads a comment: `unit: bar`, `min 0` and `max 10` may stand anywhere in it, between commas or semicolons.
pub fn comment(text: &str) -> Comment {
    let mut comment = Comment::default();
    let mut rest = Vec::new();
    for part in text.split([',', ';', '\n']) {
        let part = part.trim();
        let (word, value) = part.split_once([':', ' ', '=']).unwrap_or((part, ""));
        let value = value.trim().trim_start_matches([':', '=']).trim();
        let number = value.parse::<f64>().ok();
        match (word.to_ascii_lowercase().as_str(), number) {
            ("unit", _) if !value.is_empty() => comment.unit = Some(value.to_string()),
            ("min", Some(number)) => comment.min = Some(number),
            ("max", Some(number)) => comment.max = Some(number),
            _ if part.is_empty() => {}
            _ => rest.push(part),
        }
    }
    comment.text = rest.join(", ");
    comment
}

/// The variables of a block.
///
/// # Errors
/// Its interface has more variables than an FMU shows.
pub fn variables(compiler: &Compiler, block: usize) -> Result<Vec<Variable>, String> {
    let mut found = Found::default();
    for member in &compiler.blocks[block].members {
        let Slot::Member(_) = member.slot else { continue };
        let role = match member.section {
            SectionKind::Input if member.is_setting => Role::Parameter,
            SectionKind::Input => Role::Input,
            SectionKind::Output => Role::Output,
            SectionKind::InOut => Role::InOut,
            _ if member.is_setting => Role::Parameter,
            _ => Role::Local,
        };
        if !member.is_hidden {
            add(compiler, &member.name, &member.of, role, member.is_retained, &member.comment, &mut found);
        }
    }
    if found.variables.len() - found.locals > MOST {
        return Err(format!("{} has more than {MOST} inputs, outputs and settings", compiler.blocks[block].name));
    }
    Ok(found.variables)
}

fn add(compiler: &Compiler, name: &str, of: &Type, role: Role, is_retained: bool, text: &str, found: &mut Found) {
    if !found.has_room(role) {
        return;
    }
    let mut push = |of: &'static str, scalar: Option<Scalar>| {
        found.push(Variable { name: name.to_string(), of, scalar, role, is_retained, comment: comment(text) });
    };
    match of {
        // Nanoseconds since 1970 or 1990 are more than a host's number has digits for.
        Type::Elementary(Elementary::Ldt | Elementary::Dt) => {}
        Type::Elementary(elementary) => push(elementary.name(), Some(elementary.scalar())),
        Type::Text { wide: false, .. } => push("STRING", None),
        Type::Text { wide: true, .. } => push("WSTRING", None),
        Type::Array(array) if role == Role::Local && array.elements() > MOST_ELEMENTS => {}
        Type::Array(array) => {
            let mut index: Vec<i32> = array.bounds.iter().map(|(low, _)| *low).collect();
            loop {
                let indices: Vec<String> = index.iter().map(i32::to_string).collect();
                add(compiler, &format!("{name}[{}]", indices.join(",")), &array.of, role, is_retained, text, found);
                if !found.has_room(role) || !next(&mut index, &array.bounds) {
                    return;
                }
            }
        }
        Type::Structure(structure) => {
            for field in structure.fields.iter().filter(|field| !field.is_hidden) {
                let role = if role == Role::Local && field.is_setting { Role::Parameter } else { role };
                let is_retained = is_retained || field.is_retained;
                add(compiler, &format!("{name}.{}", field.name), &field.of, role, is_retained, &field.comment, found);
            }
        }
        Type::Instance(block) => {
            for inner in &compiler.blocks[*block].members {
                if let (Slot::Member(_), false) = (inner.slot, inner.is_hidden) {
                    add(
                        compiler,
                        &format!("{name}.{}", inner.name),
                        &inner.of,
                        Role::Local,
                        is_retained || inner.is_retained,
                        &inner.comment,
                        found,
                    );
                }
            }
        }
        Type::Open(..) | Type::Void | Type::Wrong => {}
    }
}

/// The variables that all blocks see: a tag that is only read is an input, another one an output; a member of a data block that
/// is only read is a parameter, another one a local. What belongs to instances is local.
pub fn globals(compiler: &Compiler) -> Vec<Variable> {
    let mut written = Written { compiler, paths: BTreeSet::new() };
    for function in &compiler.program.functions {
        if let Body::Code(code) = &function.body {
            walk::statements(code, &mut written);
        }
    }
    let paths = written.paths;
    let mut known: Vec<&Global> = compiler.globals.values().filter_map(State::known).collect();
    known.sort_unstable_by_key(|global| global.member);
    let mut found = Found::default();
    for global in known {
        let name = &compiler.program.records[compiler.program.memory].members[global.member].name;
        let is_tag = compiler.options.declared.iter().any(|(declared, _)| key(declared) == key(name));
        let first = found.variables.len();
        add(compiler, name, &global.of, Role::Local, false, "", &mut found);
        if matches!(global.of, Type::Instance(_)) {
            continue;
        }
        for variable in &mut found.variables[first..] {
            let name = key(&variable.name);
            let is_part = |path: &String| {
                name.strip_prefix(path.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
            };
            variable.role = match (is_tag, paths.iter().any(is_part)) {
                (true, false) => Role::Input,
                (true, true) => Role::Output,
                (false, false) => Role::Parameter,
                (false, true) => Role::Local,
            };
        }
    }
    found.variables
}

/// The paths of what a program writes in its memory, in capitals, up to the first index.
struct Written<'c, 'a> {
    compiler: &'c Compiler<'a>,
    paths: BTreeSet<String>,
}

impl Written<'_, '_> {
    fn write(&mut self, place: &Place) {
        self.paths.extend(path(&self.compiler.program, place));
    }
}

impl Look for Written<'_, '_> {
    fn statement(&mut self, statement: &Statement) {
        match &statement.what {
            What::Assign(place, _) | What::Copy(place, _) => self.write(place),
            What::For(counting) => self.write(&counting.variable),
            _ => {}
        }
    }

    fn call(&mut self, call: &Call) {
        call.instance.iter().chain(call.outputs.iter().map(|(_, place)| place)).for_each(|place| self.write(place));
        let block = self.compiler.blocks.iter().find(|block| block.function == call.function);
        for (number, argument) in call.arguments.iter().enumerate() {
            let is_input = block.is_some_and(|block| {
                let mut members = block.members.iter();
                members.any(|member| member.slot == Slot::Local(number) && member.section == SectionKind::Input)
            });
            if let (Argument::Reference(place), false) = (argument, is_input) {
                self.write(place);
            }
        }
    }
}

fn path(program: &Program, place: &Place) -> Option<String> {
    if place.base != Base::Memory {
        return None;
    }
    let mut of = program::Type::Record(program.memory);
    let mut names = Vec::new();
    for step in &place.steps {
        let (Step::Member(number), program::Type::Record(record)) = (step, of) else { break };
        let member = program.records[record].members.get(*number)?;
        names.push(key(&member.name));
        of = member.ty.clone();
    }
    Some(names.join("."))
}

/// The next index, the last one fastest.
fn next(index: &mut [i32], bounds: &[(i32, i32)]) -> bool {
    for (index, (low, high)) in index.iter_mut().zip(bounds).rev() {
        if *index < *high {
            *index += 1;
            return true;
        }
        *index = *low;
    }
    false
}

/// Whether a type is shown as a whole number of an FMU: integers and bit strings up to 32 bits but UDINT.
pub fn is_integer(of: &str) -> bool {
    Elementary::named(of).is_some_and(|of| of.is_whole() && of.bits() <= 32 && of != Elementary::UDInt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_may_give_unit_and_range() {
        let found = comment("level of the tank; unit: bar, min 0, max 10");
        assert_eq!((found.text.as_str(), found.unit.as_deref()), ("level of the tank", Some("bar")));
        assert_eq!((found.min, found.max), (Some(0.0), Some(10.0)));
        assert_eq!(comment("minimum level").text, "minimum level");
    }
}
