//! Blocks found in several sources, for example exported in two formats: copies that compile to the same program count
//! as one block.

use crate::check::compiler::{BlockId, Compiler, Twin};
use crate::front::lexer::{Token, tokens};
use crate::front::syntax::BlockKind;
use crate::ir::{Body, Program, Type};
use crate::report::Report;

/// The maximum number of differing copies of a block.
const MOST_COPIES: usize = 8;

impl Compiler<'_> {
    /// Records a block that an earlier source also declares. This compilation uses the copy numbered `copy`, or the
    /// last one if there are fewer; 0 is the first block.
    pub fn add_copy(&mut self, earlier: BlockId, id: BlockId, copy: usize) {
        let first = self.copies.iter().find(|copy| copy.id == earlier).map_or(earlier, |copy| copy.first);
        if self.has_same_words(first, id) {
            return;
        }
        let number = 1 + self.copies.iter().filter(|copy| copy.first == first).count();
        let is_other_kind = self.block(first).kind != self.block(id).kind;
        if first.0 == id.0 || is_other_kind || number > MOST_COPIES {
            return self.tell_twice(first, id);
        }
        self.copies.push(Twin { first, id, number });
        if number <= copy {
            self.names.insert(self.block(id).name.key(), id);
        }
    }

    /// Whether two blocks have the same tokens: TIA Portal includes the dependencies of each block in every source it
    /// generates.
    fn has_same_words(&self, one: BlockId, other: BlockId) -> bool {
        let words = |(file, index): BlockId| {
            // XML is not split into tokens: its copies are compared once compiled.
            if self.sources[file].text.trim_start_matches('\u{feff}').trim_start().starts_with('<') {
                return None;
            }
            let text = self.text(*self.trees[file].extents.get(index)?);
            let found = tokens(text, 0, 0);
            let word = |token: &Token| text[token.span.range()].to_string();
            Some((found.tokens.iter().map(word).collect::<Vec<_>>(), found.attributes.len()))
        };
        words(one).is_some_and(|found| words(other) == Some(found))
    }

    fn tell_twice(&mut self, first: BlockId, id: BlockId) {
        let place = self.at(self.block(first).name.span);
        let name = &self.block(id).name;
        let message =
            format!("{} is declared twice: first in {}:{}", name.text, self.sources[first.0].file, place.line);
        let help = match first.0 == id.0 {
            true => "rename or delete one of them",
            false => "rename one of them, or leave one file out; if there are several PLCs, specify the folder of one",
        };
        self.error(name.span, message, Some(help));
    }

    /// Reports copies that compile to different programs, unless there are errors.
    pub fn tell_different(&mut self) {
        if self.report.has_errors() {
            return;
        }
        let copies = std::mem::take(&mut self.copies);
        for number in 1..=copies.iter().map(|copy| copy.number).max().unwrap_or(0) {
            let mut other = Compiler::new(self.sources, self.trees, self.cpu, self.options, Report::default(), number);
            other.run();
            for copy in copies.iter().filter(|copy| copy.number == number) {
                let block = self.block(copy.id);
                if other.report.has_errors() || !is_same(&self.program, &other.program, block.kind, &block.name.text) {
                    self.tell_twice(copy.first, copy.id);
                }
            }
        }
    }
}

/// Whether a block is the same in two programs, apart from its comments.
fn is_same(one: &Program, other: &Program, kind: BlockKind, name: &str) -> bool {
    let programs = [one, other];
    let records = programs.map(|program| program.records.iter().position(|record| is_name(&record.name, name)));
    let globals = programs.map(|program| {
        let members = &program.records[program.memory].members;
        members.iter().find(|member| is_name(&member.name, name))
    });
    let is_same_global = match globals {
        [Some(a), Some(b)] => {
            let bytes = |program: &Program, offset: usize, of: &Type| {
                let size = program.size(of);
                program.records[program.memory].start.get(offset..offset + size).map(<[u8]>::to_vec)
            };
            is_same_type(one, &a.ty, other, &b.ty) && bytes(one, a.offset, &a.ty) == bytes(other, b.offset, &b.ty)
        }
        [None, None] => true,
        _ => false,
    };
    let is_same_record = match records {
        [Some(a), Some(b)] => is_same_record(one, a, other, b),
        [None, None] => true,
        _ => false,
    };
    let has_code = !matches!(kind, BlockKind::Type | BlockKind::DataBlock);
    is_same_global
        && is_same_record
        && (!has_code || code(one, name).is_some_and(|text| code(other, name) == Some(text)))
}

fn is_name(one: &str, other: &str) -> bool {
    one.eq_ignore_ascii_case(other)
}

fn is_same_record(one: &Program, a: usize, other: &Program, b: usize) -> bool {
    let (a, b) = (&one.records[a], &other.records[b]);
    let is_same_member = |(a, b): (&crate::ir::Member, &crate::ir::Member)| {
        is_name(&a.name, &b.name) && a.offset == b.offset && is_same_type(one, &a.ty, other, &b.ty)
    };
    a.start == b.start && a.members.len() == b.members.len() && a.members.iter().zip(&b.members).all(is_same_member)
}

fn is_same_type(one: &Program, a: &Type, other: &Program, b: &Type) -> bool {
    match (a, b) {
        (Type::Record(a), Type::Record(b)) => is_same_record(one, *a, other, *b),
        (Type::Array { of: a, bounds }, Type::Array { of: b, bounds: others }) => {
            bounds == others && is_same_type(one, a, other, b)
        }
        (Type::Open { of: a, dimensions }, Type::Open { of: b, dimensions: others }) => {
            dimensions == others && is_same_type(one, a, other, b)
        }
        (a, b) => a == b,
    }
}

/// The lines of a block after its header, without comments and in lower case, since names are case-insensitive.
fn code(program: &Program, name: &str) -> Option<Vec<String>> {
    let is_it =
        |function: &crate::ir::Function| is_name(&function.name, name) && matches!(function.body, Body::Code(_));
    let text = program.text(program.functions.iter().position(is_it)?);
    let lines = text.lines().skip(1).map(str::trim).filter(|line| !line.starts_with("//"));
    Some(lines.map(str::to_lowercase).collect())
}
