//! The program interface that an FMU exposes.

use crate::check::compiler::{Compiler, Global, Interface, Slot, State};
use crate::check::types::{Elementary, Type, text_name};
use crate::front::syntax::{SectionKind, key};
use crate::ir::walk::{self, Look};
use crate::ir::{self, Argument, Base, Body, Call, Expr, Place, Program, Statement, Step, What};
use parameters::tags::Area;
use std::ops::Range;

/// The role of a variable for the user of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Read in every call.
    Input,
    /// Read in every call but rarely changed: a setting.
    Parameter,
    /// Written in every call.
    Output,
    /// Read and written: both an input and an output named with the suffix `_out`.
    InOut,
    /// Internal to the program.
    Local,
}

/// A scalar or string variable of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// The qualified name, with members and indices, in FMI's structured naming convention: `par.levelFull`,
    /// `feedback[1]`, `'V1.0'.x`. Identifiers are not quoted, even if they have non-ASCII letters.
    pub name: String,
    /// The name of its data type, such as REAL.
    pub of: &'static str,
    /// Its representation in memory: a number or a string.
    pub ty: ir::Type,
    /// Its byte offset in memory.
    pub offset: usize,
    /// Its role.
    pub role: Role,
    /// Whether the author hides it (`ExternalVisible := 'False'`); never true for inputs and outputs.
    pub is_hidden: bool,
    /// Whether it is retentive: a CPU keeps its value when it loses power.
    pub is_retained: bool,
    /// The author's comment on it.
    pub comment: Comment,
}

/// A parsed comment, such as `// level of the tank; unit: bar, min 0, max 10`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comment {
    /// The comment without its unit and range.
    pub text: String,
    /// The unit of measurement.
    pub unit: Option<String>,
    /// The lowest plausible value.
    pub min: Option<f64>,
    /// The highest plausible value.
    pub max: Option<f64>,
}

/// The maximum number of inputs, outputs and settings together, and likewise of locals; more locals are not shown.
const MOST: usize = 100_000;

/// Local arrays with more elements are not shown: a sample buffer is not a signal for a host to read.
const MOST_ELEMENTS: usize = 1000;

/// The advice given if some internal variables or data block members are not shown.
const COPY: &str = "add outputs to the block for the values that the host reads";

/// The exposed variables of a block, or the exposed globals.
#[derive(Debug, Default)]
pub struct Shown {
    /// The variables shown, in declaration order.
    pub variables: Vec<Variable>,
    /// Messages about variables that are left out, each with advice.
    pub notes: Vec<(String, &'static str)>,
    locals: usize,
}

impl Shown {
    /// Whether one more variable may be added. An interface may exceed the limit by one, which is then reported as an
    /// error.
    fn has_room(&self, role: Role) -> bool {
        match role {
            Role::Local => self.locals < MOST,
            _ => self.variables.len() - self.locals <= MOST,
        }
    }

    fn is_too_large(&self) -> bool {
        self.variables.len() - self.locals > MOST
    }
}

/// A variable being expanded into its scalars and strings.
#[derive(Clone, Copy)]
struct Part<'a> {
    name: &'a str,
    of: &'a Type,
    offset: usize,
    role: Role,
    is_hidden: bool,
    is_retained: bool,
    comment: &'a str,
}

/// A name as one component of a qualified name, in single quotes unless it is an identifier.
pub fn part(name: &str) -> String {
    let is_plain = name.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_alphanumeric() || c == '_');
    match is_plain {
        true => name.to_string(),
        false => format!("'{}'", name.replace('\\', "\\\\").replace('\'', "\\'")),
    }
}

/// Parses a comment: `unit: bar`, `min 0` and `max 10` may occur anywhere, separated by commas or semicolons. A comma
/// between two digits is a decimal comma.
pub fn comment(text: &str) -> Comment {
    let mut comment = Comment::default();
    let mut rest = Vec::new();
    let is_digit = |at: usize| text.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
    let is_decimal = |at: usize| at > 0 && is_digit(at - 1) && is_digit(at + 1);
    let separators = text.match_indices([',', ';', '\n']).filter(|(at, of)| *of != "," || !is_decimal(*at));
    let mut start = 0;
    for (at, separator) in separators.chain([(text.len(), "")]) {
        let part = text[start..at].trim();
        start = at + separator.len();
        let (word, value) = part.split_once([':', ' ', '=']).unwrap_or((part, ""));
        let value = value.trim().trim_start_matches([':', '=']).trim();
        let number = value.replace(',', ".").parse::<f64>().ok();
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

/// The variables of a block whose instance starts at byte `offset` of memory.
///
/// # Errors
/// The interface has more variables than an FMU may expose.
pub fn variables(compiler: &Compiler, block: usize, offset: usize) -> Result<Shown, String> {
    let mut found = Shown::default();
    let Interface { members, record, name, .. } = &compiler.blocks[block];
    for member in members {
        let Slot::Member(number) = member.slot else { continue };
        let role = match member.section {
            SectionKind::Input if member.is_setting => Role::Parameter,
            SectionKind::Input => Role::Input,
            SectionKind::Output => Role::Output,
            SectionKind::InOut => Role::InOut,
            _ if member.is_setting => Role::Parameter,
            _ => Role::Local,
        };
        // The attribute controls visibility on an operator panel; inputs and outputs are shown regardless.
        let is_inside = !matches!(member.section, SectionKind::Input | SectionKind::Output | SectionKind::InOut);
        let part = Part {
            name: &part(&member.name),
            of: &member.of,
            offset: offset + compiler.program.records[*record].members[number].offset,
            role,
            is_hidden: is_inside && member.is_hidden,
            is_retained: member.is_retained,
            comment: &member.comment,
        };
        add(compiler, part, &mut found);
    }
    if found.is_too_large() {
        return Err(format!("{name} has more than {MOST} inputs, outputs and settings"));
    }
    if found.locals == MOST {
        found
            .notes
            .push((format!("{name} has more than {MOST} internal variables: only the first {MOST} are shown"), COPY));
    }
    Ok(found)
}

fn add(compiler: &Compiler, part: Part, found: &mut Shown) {
    let Part { name, of, offset, role, .. } = part;
    if !found.has_room(role) {
        return;
    }
    let mut push = |of: &'static str, ty: ir::Type| {
        let Part { is_hidden, is_retained, .. } = part;
        let (name, comment) = (name.to_string(), comment(part.comment));
        found.locals += usize::from(role == Role::Local);
        found.variables.push(Variable { name, of, ty, offset, role, is_hidden, is_retained, comment });
    };
    match of {
        Type::Elementary(elementary @ (Elementary::Ldt | Elementary::Dt)) => {
            if role != Role::Local {
                let of = elementary.name();
                let message =
                    format!("{name} is of type {of}, which FMI numbers cannot represent exactly, so it is not shown");
                found.notes.push((message, "use a DTL, whose members are shown"));
            }
        }
        Type::Elementary(elementary) => push(elementary.name(), ir::Type::Scalar(elementary.scalar())),
        Type::Text { wide, capacity } => {
            let (wide, capacity) = (*wide, *capacity);
            push(text_name(wide), ir::Type::Text { capacity, wide });
        }
        Type::Array(array) if role == Role::Local && array.elements() > MOST_ELEMENTS => {}
        Type::Array(array) => {
            let size = compiler.program.size(&compiler.lowered(&array.of));
            let mut index: Vec<i32> = array.bounds.iter().map(|(low, _)| *low).collect();
            let mut offset = offset;
            loop {
                let indices: Vec<String> = index.iter().map(i32::to_string).collect();
                let name = format!("{name}[{}]", indices.join(","));
                add(compiler, Part { name: &name, of: &array.of, offset, ..part }, found);
                offset += size;
                if !found.has_room(role) || !next(&mut index, &array.bounds) {
                    return;
                }
            }
        }
        Type::Structure(structure) => {
            let members = &compiler.program.records[structure.record].members;
            for (field, member) in structure.fields.iter().zip(members) {
                let inner = Part {
                    name: &format!("{name}.{}", self::part(&field.name)),
                    of: &field.of,
                    offset: offset + member.offset,
                    role: if role == Role::Local && field.is_setting { Role::Parameter } else { role },
                    is_hidden: part.is_hidden || field.is_hidden && role == Role::Local,
                    is_retained: part.is_retained || field.is_retained,
                    comment: &field.comment,
                };
                add(compiler, inner, found);
            }
        }
        Type::Instance(block) => {
            let Interface { members, record, source, is_stub, .. } = &compiler.blocks[*block];
            for inner in members {
                let Slot::Member(number) = inner.slot else { continue };
                // The members of a native block already have qualified names.
                let last = if source.is_some() { self::part(&inner.name) } else { inner.name.clone() };
                let inner = Part {
                    name: &format!("{name}.{last}"),
                    of: &inner.of,
                    offset: offset + compiler.program.records[*record].members[number].offset,
                    // The host simulates the device that the stub replaces.
                    role: match (is_stub, inner.section) {
                        (true, SectionKind::Input) => Role::Output,
                        (true, SectionKind::Output) => Role::Input,
                        (true, SectionKind::InOut) => Role::InOut,
                        _ => Role::Local,
                    },
                    is_hidden: part.is_hidden || inner.is_hidden,
                    is_retained: part.is_retained || inner.is_retained,
                    comment: &inner.comment,
                };
                add(compiler, inner, found);
            }
        }
        Type::Open(..) | Type::Void | Type::Missing(_) | Type::Wrong => {}
    }
}

/// The global variables, except the instance being run. A tag with an address is an input, an output or, in bit memory,
/// a local; a tag without one is an input if it is only read, else an output. A member of a data block is a parameter
/// if it is only read, else a local. Members of instances are locals, except the parameters of stubs.
///
/// # Errors
/// The program has more tags than an FMU may expose.
pub fn globals(compiler: &Compiler, instance: &str) -> Result<Shown, String> {
    let written = written(compiler);
    let mut known: Vec<&Global> = compiler.globals.values().filter_map(State::known).collect();
    // Parameters take precedence over data blocks of the same name.
    known.sort_unstable_by_key(|global| (global.parameter.is_none(), global.member));
    let mut found = Shown::default();
    for global in known {
        let member = &compiler.program.records[compiler.program.memory].members[global.member];
        let own = key(&member.name);
        if own == key(instance) {
            continue;
        }
        let is_instance = matches!(global.of, Type::Instance(_));
        let tag = compiler.tag(&own).filter(|_| !is_instance);
        let first = found.variables.len();
        let part = Part {
            name: &part(global.parameter.as_ref().unwrap_or(&member.name)),
            of: &global.of,
            offset: member.offset,
            // Tags and parameters are never left out.
            role: if tag.is_some() || global.parameter.is_some() { Role::InOut } else { Role::Local },
            is_hidden: false,
            is_retained: false,
            comment: tag.map_or("", |(_, comment)| comment),
        };
        add(compiler, part, &mut found);
        for variable in &mut found.variables[first..] {
            let is_written = written.contains(variable.offset);
            variable.role = match tag {
                // In an instance, the role is already final: that of a stub's parameter, or local.
                _ if is_instance => variable.role,
                Some((area, _)) => role_of(area, is_written),
                None if is_written => Role::Local,
                None => Role::Parameter,
            };
        }
    }
    if found.is_too_large() {
        return Err(format!("the program has more than {MOST} tags"));
    }
    if found.locals == MOST {
        found
            .notes
            .push((format!("the data blocks have more than {MOST} members: only the first {MOST} are shown"), COPY));
    }
    Ok(found)
}

/// The role of a tag for a host. An input that the program also writes is an in-out: on a CPU, the next process image
/// overwrites it.
fn role_of(area: Option<Area>, is_written: bool) -> Role {
    match (area, is_written) {
        (Some(Area::Input), true) => Role::InOut,
        (Some(Area::Input), false) | (None, false) => Role::Input,
        (Some(Area::Output), _) | (None, true) => Role::Output,
        (Some(Area::Memory), _) => Role::Local,
    }
}

/// The byte ranges of memory that a program writes. A write with a computed index covers the whole array.
pub struct Written<'c, 'a> {
    compiler: &'c Compiler<'a>,
    ranges: Vec<Range<usize>>,
}

/// Collects the byte ranges of memory that the program writes.
pub fn written<'c, 'a>(compiler: &'c Compiler<'a>) -> Written<'c, 'a> {
    let mut written = Written { compiler, ranges: Vec::new() };
    for function in &compiler.program.functions {
        if let Body::Code(code) = &function.body {
            walk::statements(code, &mut written);
        }
    }
    written.ranges.sort_unstable_by_key(|range| range.start);
    let mut end = 0;
    for range in &mut written.ranges {
        end = end.max(range.end);
        range.end = end;
    }
    written
}

impl Written<'_, '_> {
    /// Whether a byte of memory is written.
    pub fn contains(&self, offset: usize) -> bool {
        let before = self.ranges.partition_point(|range| range.start <= offset);
        before.checked_sub(1).is_some_and(|last| offset < self.ranges[last].end)
    }

    fn write(&mut self, place: &Place) {
        self.ranges.extend(range(&self.compiler.program, place));
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

fn range(program: &Program, place: &Place) -> Option<Range<usize>> {
    if place.base != Base::Memory {
        return None;
    }
    let mut of = &ir::Type::Record(program.memory);
    let mut start = 0;
    for step in &place.steps {
        match (step, of) {
            (Step::Member(number), ir::Type::Record(record)) => {
                let member = program.records[*record].members.get(*number)?;
                (start, of) = (start + member.offset, &member.ty);
            }
            // One element, or the whole array if an index is computed.
            (Step::Index(indices, _), ir::Type::Array { of: element, bounds }) => {
                let Some(number) = number_of(indices, bounds) else { break };
                (start, of) = (start + number * program.size(element), element);
            }
            _ => break,
        }
    }
    Some(start..start + program.size(of))
}

/// The flat index of an element; `None` if an index is computed or out of range.
fn number_of(indices: &[Expr], bounds: &[(i32, i32)]) -> Option<usize> {
    let mut number = 0;
    for (index, (low, high)) in indices.iter().zip(bounds) {
        let Expr::Const(index) = index else { return None };
        let index = index.bits() as i64;
        let is_inside = (i64::from(*low)..=i64::from(*high)).contains(&index);
        let length = usize::try_from(i64::from(*high) - i64::from(*low) + 1).ok()?;
        let at = usize::try_from(index - i64::from(*low)).ok().filter(|_| is_inside)?;
        number = number * length + at;
    }
    Some(number)
}

/// Advances to the next index, the last dimension fastest. Returns whether there is one.
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

/// Whether a data type is represented as an FMU integer: integers and bit strings of up to 32 bits, except UDINT.
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
        let found = comment("gain; unit: bar, min 0,5,max 10,25");
        assert_eq!((found.text.as_str(), found.unit.as_deref()), ("gain", Some("bar")));
        assert_eq!((found.min, found.max), (Some(0.5), Some(10.25)));
    }
}
