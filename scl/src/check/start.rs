//! Writes start values into the records of the program.

use crate::check::compiler::{Compiler, Operand, Parameter, Slot, Symbol};
use crate::check::types::Type;
use crate::front::lexer::Span;
use crate::front::syntax::{ExpressionId, Expressions, Name, PathStep, Start};
use crate::ir::{Base, Expr, Place, Step, Type as Lowered};
use crate::lower::Lowerer;
use parameters::problem::nearest;
use std::collections::HashMap;
use std::rc::Rc;

impl Compiler<'_> {
    /// Writes the start value of the record member with index `number`.
    pub fn start_member(
        &mut self,
        record: usize,
        number: usize,
        of: &Type,
        start: &Start,
        file: usize,
        symbols: &Rc<HashMap<String, Symbol>>,
    ) {
        let Some(member) = self.program.records[record].members.get(number) else { return };
        let offset = member.offset;
        self.start_at(record, offset, of, start, file, symbols);
    }

    /// Writes a start value into a record at a byte offset.
    pub fn start_at(
        &mut self,
        record: usize,
        offset: usize,
        of: &Type,
        start: &Start,
        file: usize,
        symbols: &Rc<HashMap<String, Symbol>>,
    ) {
        let mut bytes = std::mem::take(&mut self.program.records[record].start);
        let size = self.program.size(&self.lowered(of));
        if let Some(part) = bytes.get_mut(offset..offset + size) {
            let mut starting = Starting { compiler: self, file, symbols };
            starting.write(of, start, part);
        }
        self.program.records[record].start = bytes;
    }

    /// The byte offset of a place in memory; `None` if an index is computed or out of range.
    pub fn offset(&self, place: &Place) -> Option<usize> {
        if place.base != Base::Memory {
            return None;
        }
        let mut of = Lowered::Record(self.program.memory);
        let mut offset = 0;
        for step in &place.steps {
            (offset, of) = match (step, of) {
                (Step::Member(number), Lowered::Record(record)) => {
                    let member = &self.program.records[record].members[*number];
                    (offset + member.offset, member.ty.clone())
                }
                (Step::Index(indices, _), Lowered::Array { of, bounds }) => {
                    let mut number = 0usize;
                    for (index, (low, high)) in indices.iter().zip(&bounds) {
                        let Expr::Const(index) = index else { return None };
                        let index = index.bits() as i64;
                        if !(i64::from(*low)..=i64::from(*high)).contains(&index) {
                            return None;
                        }
                        let extent = (i64::from(*high) - i64::from(*low) + 1) as usize;
                        number = number * extent + (index - i64::from(*low)) as usize;
                    }
                    (offset + number * self.program.size(&of), *of)
                }
                _ => return None,
            };
        }
        Some(offset)
    }
}

struct Starting<'c, 'a> {
    compiler: &'c mut Compiler<'a>,
    file: usize,
    symbols: &'c Rc<HashMap<String, Symbol>>,
}

impl Starting<'_, '_> {
    fn expressions(&self) -> &Expressions {
        self.compiler.expressions(self.file)
    }

    fn span(&self, start: &Start) -> Span {
        match start {
            Start::Value(value) => self.expressions()[*value].span,
            Start::List(_, span) | Start::Members(_, span) | Start::Parts(_, span) => *span,
            Start::Repeat(count, _) => self.expressions()[*count].span,
        }
    }

    fn write(&mut self, of: &Type, start: &Start, bytes: &mut [u8]) {
        match (of, start) {
            (Type::Wrong | Type::Missing(_), _) => {}
            // `()` keeps the default of the type.
            (_, Start::List(list, _)) if list.is_empty() => {}
            (_, Start::Parts(parts, span)) => {
                for (path, value) in parts {
                    self.part(of, path, *value, *span, bytes);
                }
            }
            (Type::Array(array), _) => {
                let size = self.compiler.program.size(&self.compiler.lowered(&array.of));
                let mut at = 0;
                self.fill(&array.of, size, start, bytes, &mut at);
            }
            (Type::Structure(structure), Start::Members(members, _)) => {
                for (name, start) in members {
                    let number = structure.number(&name.key());
                    let Some(number) = number else {
                        let help = did_you_mean(name, structure.fields.iter().map(|field| field.name.as_str()));
                        let message = format!("{of} has no member {}", name.text);
                        self.compiler.error(name.span, message, help.as_deref());
                        continue;
                    };
                    self.member(structure.record, number, &structure.fields[number].of, start, bytes);
                }
            }
            (Type::Structure(structure), Start::List(list, span)) => {
                if list.len() > structure.fields.len() {
                    self.compiler.error(
                        *span,
                        format!("more start values than members: {of} has {}", structure.fields.len()),
                        None,
                    );
                }
                for (number, (start, field)) in list.iter().zip(&structure.fields).enumerate() {
                    self.member(structure.record, number, &field.of, start, bytes);
                }
            }
            (Type::Instance(block), Start::Members(members, _)) => {
                for (name, start) in members {
                    let interface = &self.compiler.blocks[*block];
                    let found = interface.members.iter().find(|member| member.key == name.key()).cloned();
                    let record = interface.record;
                    match found {
                        Some(Parameter { of, slot: Slot::Member(number), .. }) => {
                            self.member(record, number, &of, start, bytes);
                        }
                        _ => {
                            let stored = interface.members.iter().filter(|one| matches!(one.slot, Slot::Member(_)));
                            let help = did_you_mean(name, stored.map(|one| one.name.as_str()));
                            let message = format!("the instance has no member {}", name.text);
                            self.compiler.error(name.span, message, help.as_deref());
                        }
                    }
                }
            }
            (Type::Text { .. }, Start::Value(value)) => {
                let mut lowerer = Lowerer::of_constants(self.compiler, self.file, self.symbols.clone());
                let text = lowerer.constant(*value, Some(of));
                if let Operand::Text(text, _) = text {
                    write_text(of, &text, bytes);
                }
            }
            (Type::Elementary(elementary), Start::Value(value)) => {
                let mut lowerer = Lowerer::of_constants(self.compiler, self.file, self.symbols.clone());
                if let Operand::Value(_, Expr::Const(value)) =
                    lowerer.constant(*value, Some(&Type::Elementary(*elementary)))
                {
                    value.write(bytes);
                }
            }
            // A single value in brackets: `(5)` or `[5]`.
            (_, Start::List(list, _)) if list.len() == 1 => self.write(of, &list[0], bytes),
            (Type::Structure(structure), Start::Value(value)) if structure.name == "DTL" => {
                let mut lowerer = Lowerer::of_constants(self.compiler, self.file, self.symbols.clone());
                if let Some(moment) = lowerer.moment(*value) {
                    bytes[..crate::lower::DTL_BYTES].copy_from_slice(&moment);
                }
            }
            _ => {
                let span = self.span(start);
                self.compiler.error(span, format!("this is not a valid start value for {of}"), None);
            }
        }
    }

    /// Writes the start value of the part at `path`.
    fn part(&mut self, of: &Type, path: &[PathStep], value: ExpressionId, span: Span, bytes: &mut [u8]) {
        let Some((part, rest)) = path.split_first() else {
            return self.write(of, &Start::Value(value), bytes);
        };
        let found = match (of, part) {
            (Type::Wrong, _) => return,
            (Type::Structure(structure), PathStep::Member(name)) => structure
                .number(&name.key())
                .map(|number| (structure.record, number, structure.fields[number].of.clone())),
            (Type::Instance(block), PathStep::Member(name)) => {
                let interface = &self.compiler.blocks[*block];
                let found = interface.members.iter().find(|member| member.key == name.key());
                found.and_then(|member| match member.slot {
                    Slot::Member(number) => Some((interface.record, number, member.of.clone())),
                    Slot::Local(_) => None,
                })
            }
            (Type::Array(array), PathStep::Element(indices)) if indices.len() == array.bounds.len() => {
                let size = self.compiler.program.size(&self.compiler.lowered(&array.of));
                let mut number = 0i64;
                for (index, (low, high)) in indices.iter().zip(&array.bounds) {
                    let (low, high) = (i64::from(*low), i64::from(*high));
                    if !(low..=high).contains(index) {
                        let message = format!("the start value index {index} is outside {low}..{high}");
                        self.compiler.error(span, message, None);
                        return;
                    }
                    number = number * (high - low + 1) + index - low;
                }
                let at = number as usize * size;
                if let Some(bytes) = bytes.get_mut(at..at + size) {
                    self.part(&array.of, rest, value, span, bytes);
                }
                return;
            }
            _ => None,
        };
        match found {
            Some((record, number, of)) => {
                let offset = self.compiler.program.records[record].members[number].offset;
                let size = self.compiler.program.size(&self.compiler.lowered(&of));
                self.part(&of, rest, value, span, &mut bytes[offset..offset + size]);
            }
            None => {
                let name = if let PathStep::Member(name) = part { name.text.as_str() } else { "an element" };
                let message = format!("this is a start value for {name}, which {of} does not have");
                self.compiler.error(span, message, Some("export the block again"));
            }
        }
    }

    fn member(&mut self, record: usize, number: usize, of: &Type, start: &Start, bytes: &mut [u8]) {
        let offset = self.compiler.program.records[record].members[number].offset;
        let size = self.compiler.program.size(&self.compiler.lowered(of));
        self.write(of, start, &mut bytes[offset..offset + size]);
    }

    /// Writes consecutive elements of an array; `at` is the number of bytes written so far.
    fn fill(&mut self, of: &Type, size: usize, start: &Start, bytes: &mut [u8], at: &mut usize) {
        match start {
            Start::List(list, _) => {
                // In an array of structures, a parenthesized list is a single element.
                let is_element = matches!(of, Type::Structure(_) | Type::Instance(_))
                    && self.compiler.text(self.span(start)).starts_with('(');
                if is_element {
                    return self.element(of, size, start, bytes, at);
                }
                for start in list {
                    if *at > bytes.len() {
                        return;
                    }
                    self.fill(of, size, start, bytes, at);
                }
            }
            Start::Repeat(count, list) => {
                let count = self.compiler.constant_whole(*count, self.file, self.symbols).unwrap_or(0);
                for _ in 0..count.clamp(0, (bytes.len() / size.max(1) + 1) as i128) {
                    for start in list {
                        if *at > bytes.len() {
                            return;
                        }
                        self.fill(of, size, start, bytes, at);
                    }
                }
            }
            _ => self.element(of, size, start, bytes, at),
        }
    }

    fn element(&mut self, of: &Type, size: usize, start: &Start, bytes: &mut [u8], at: &mut usize) {
        let end = *at + size;
        match bytes.get_mut(*at..end).filter(|_| size > 0) {
            Some(part) => self.write(of, start, part),
            None => {
                let span = self.span(start);
                let count = bytes.len() / size.max(1);
                let message = format!("more start values than elements: the array has {count}");
                self.compiler.error(span, message, None);
            }
        }
        // Report the first excess value only.
        *at = if end > bytes.len() { bytes.len() + 1 } else { end };
    }
}

/// Writes a string, truncated to its capacity.
pub(crate) fn write_text(of: &Type, text: &[u16], bytes: &mut [u8]) {
    let Type::Text { capacity, wide } = of else { return };
    let length = text.len().min(usize::from(*capacity));
    bytes[..2].copy_from_slice(&(length as u16).to_le_bytes());
    for (number, unit) in text[..length].iter().enumerate() {
        if *wide {
            bytes[2 + number * 2..][..2].copy_from_slice(&unit.to_le_bytes());
        } else {
            bytes[2 + number] = u8::try_from(*unit).unwrap_or(b'?');
        }
    }
}

/// A suggestion: the name most similar to a wrong one, if any.
fn did_you_mean<'n>(wrong: &Name, names: impl Iterator<Item = &'n str>) -> Option<String> {
    nearest(&wrong.text, names).map(|like| format!("did you mean {like}?"))
}
