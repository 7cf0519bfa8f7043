//! What is known of a program while it is translated: what is asked for, what is declared, and what is still missing.

use crate::copies::Twin;
use crate::lexer::Span;
use crate::program::{self, At, Base, Expr, Place, Program};
use crate::report::Report;
use crate::syntax::{Block, BlockKind, ExpressionId, Expressions, Member, Section, SectionKind, Tree};
use crate::types::{Elementary, Type};
use crate::undeclared::{Missing, Undeclared};
use manifest::{Cpu, Manifest};
use parameters::Source;
use parameters::tags::{self, Area, Tag};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::rc::Rc;

/// A block of a source: the source, and its number there.
pub type BlockId = (usize, usize);

/// What is known of something that may depend on itself.
#[derive(Clone, Debug)]
pub enum State<T> {
    /// It is being declared.
    Open,
    /// It is declared.
    Known(T),
}

impl<T> State<T> {
    /// What is known.
    pub fn known(&self) -> Option<&T> {
        match self {
            State::Open => None,
            State::Known(known) => Some(known),
        }
    }
}

/// The state of a translation.
pub struct Compiler<'a> {
    pub sources: &'a [Source],
    pub trees: &'a [Tree],
    pub cpu: Cpu,
    pub options: &'a Manifest,
    pub report: Report,
    pub program: Program,
    /// The blocks of the sources, by name.
    pub names: HashMap<String, BlockId>,
    /// Blocks that an earlier source has, too, in other words.
    pub copies: Vec<Twin>,
    /// The blocks of the library, by name.
    pub library: HashMap<String, BlockId>,
    pub types: HashMap<BlockId, State<Type>>,
    pub blocks: Vec<Interface>,
    pub block_of: HashMap<BlockId, State<usize>>,
    pub natives: HashMap<String, usize>,
    pub globals: HashMap<String, State<Global>>,
    /// Which kind of timer or counter a variable of a general type is, by the last name of its path.
    pub kinds: HashMap<String, String>,
    /// What the options declare, by name.
    pub declared: HashMap<String, &'a Tag>,
    /// What sources declare outside of blocks, by name: the source, and the declaration.
    pub global_members: HashMap<String, (usize, &'a Section, &'a Member)>,
    /// Blocks of which the interface alone counts, by their names.
    pub stubs: HashSet<String>,
    /// Whether blocks of the system that need a PLC are missing, and not refused: they are declared later.
    pub assumes: bool,
    pub undeclared: BTreeMap<String, Undeclared>,
    /// Who calls whom, and where.
    pub calls: Vec<(usize, usize, Span)>,
    /// The truth values that are noted when they are calculated: the number of the source, and the expression.
    pub watched: HashSet<(usize, ExpressionId)>,
    /// Where that is.
    pub notes: Vec<Note>,
    /// Bytes of all records, against types that no memory holds.
    pub bytes: usize,
}

impl<'a> Compiler<'a> {
    /// The number of the library among the sources.
    pub fn library_file(&self) -> usize {
        self.trees.len() - 1
    }

    /// A block of a source.
    pub fn block(&self, (file, index): BlockId) -> &'a Block {
        &self.trees[file].blocks[index]
    }

    /// The expressions of a source.
    pub fn expressions(&self, file: usize) -> &'a Expressions {
        &self.trees[file].expressions
    }

    /// The line of a span.
    pub fn at(&self, span: Span) -> At {
        let line = self.sources[span.file as usize].place(span.range()).line;
        At { file: span.file as u16, line: line as u32 }
    }

    /// The text of a span.
    pub fn text(&self, span: Span) -> &'a str {
        &self.sources[span.file as usize].text[span.range()]
    }

    /// Where a tag lies, if its address says it, and its comment; `None` if nothing declares a tag of this name.
    pub fn tag(&self, name: &str) -> Option<(Option<Area>, &'a str)> {
        let comment = match self.global_members.get(name) {
            Some((_, _, member)) => &member.comment,
            None => &self.declared.get(name)?.comment,
        };
        Some((self.address(name).as_deref().and_then(tags::area), comment))
    }

    /// The address of a tag.
    pub fn address(&self, name: &str) -> Option<String> {
        match self.global_members.get(name) {
            Some((_, _, member)) => tags::address(&member.at.as_ref()?.text),
            None => self.declared.get(name)?.address.clone(),
        }
    }

    /// A warning; the library gets none.
    pub fn warn(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        if span.file as usize != self.library_file() {
            self.report.warning(span, message, help);
        }
    }

    /// An error.
    pub fn error(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        self.report.error(span, message, help);
    }
}

/// A block that can be called.
#[derive(Debug)]
pub struct Interface {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: BlockKind,
    /// Where it is declared; `None` for a native one.
    pub source: Option<BlockId>,
    /// Its parameters and statics, in the order of declaration.
    pub members: Vec<Parameter>,
    /// Its names.
    pub symbols: Rc<HashMap<String, Symbol>>,
    /// The type of its value.
    pub result: Type,
    /// The record of an instance.
    pub record: usize,
    /// Its function in the program.
    pub function: usize,
    /// The local with its ENO, if the block may set it.
    pub eno: Option<usize>,
    /// Its variables that show the bytes of others.
    pub views: Vec<View>,
    /// Whether its interface alone counts: its inputs are outputs of an FMU, and its outputs inputs.
    pub is_stub: bool,
}

/// A parameter or a static variable of a block.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name as it is written.
    pub name: String,
    /// Its name in capitals.
    pub key: String,
    /// What it is.
    pub section: SectionKind,
    /// Its type.
    pub of: Type,
    /// Where it is.
    pub slot: Slot,
    /// What its author says of it.
    pub comment: String,
    /// Whether it is a setting.
    pub is_setting: bool,
    /// Whether it is hidden.
    pub is_hidden: bool,
    /// Whether its value survives a power failure.
    pub is_retained: bool,
}

/// Where a variable of a block is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// A member of the instance.
    Member(usize),
    /// A local of the function.
    Local(usize),
}

/// What a name stands for in a block.
#[derive(Clone, Debug)]
pub enum Symbol {
    /// A variable.
    Variable(SectionKind, Type, Slot),
    /// A constant.
    Constant(Operand),
}

/// A variable of the memory that all blocks see.
#[derive(Clone, Debug)]
pub struct Global {
    /// Its member of the memory.
    pub member: usize,
    /// Its type.
    pub of: Type,
    /// The structured in-out parameter of the block that is run for which it stands.
    pub parameter: Option<String>,
}

impl Global {
    /// Where it is.
    pub fn place(&self) -> Place {
        Place::of(Base::Memory).member(self.member)
    }
}

/// Where it is noted what a truth value was when it was calculated: in a local of a function, which is 0 until then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Note {
    /// The number of the source.
    pub file: usize,
    /// The number of the expression in it.
    pub expression: u32,
    /// The number of the function.
    pub function: usize,
    /// The number of the local, a `U8`.
    pub local: usize,
}

impl Note {
    /// It was FALSE.
    pub const FALSE: u8 = 1;
    /// It was TRUE.
    pub const TRUE: u8 = 2;
}

/// The result of an expression.
#[derive(Clone, Debug)]
pub enum Operand {
    /// A whole number without a type.
    Whole(i128),
    /// A number with a fraction without a type, as LREAL and as REAL.
    Fraction(f64, f32),
    /// A text, and whether its characters have 16 bits.
    Text(Vec<u16>, Option<bool>),
    /// A number.
    Value(Elementary, Expr),
    /// A structure, an array, a text or an instance.
    Variable(Type, Place),
    /// What a message has told already; what is missing if no source declares it.
    Wrong(Option<Missing>),
}

/// A view of a variable.
#[derive(Clone, Debug)]
pub struct View {
    /// Its name.
    pub name: String,
    /// The local that holds what it shows.
    pub local: usize,
    /// The variable behind it, in capitals.
    pub behind: String,
    /// Its type.
    pub of: Type,
    /// Where it is declared.
    pub span: Span,
}

impl From<SectionKind> for program::Section {
    /// Who sets a member of this section and who reads it.
    fn from(section: SectionKind) -> program::Section {
        match section {
            SectionKind::Input => program::Section::Input,
            SectionKind::Output => program::Section::Output,
            SectionKind::InOut => program::Section::InOut,
            _ => program::Section::Static,
        }
    }
}

/// Shared by all blocks without symbols.
pub fn nothing<K, V>() -> Rc<HashMap<K, V>> {
    Rc::new(HashMap::new())
}
