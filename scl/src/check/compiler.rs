//! The state of a compilation: options, declarations, and names still undeclared.

use crate::check::types::{Elementary, Type};
use crate::check::undeclared::{Missing, Undeclared};
use crate::front::lexer::Span;
use crate::front::syntax::{BlockKind, ExpressionId, Expressions, Member, Section, SectionKind, SourceBlock, Tree};
use crate::ir::{self, At, Base, Expr, Place, Program};
use crate::report::Report;
use manifest::{Cpu, Manifest};
use parameters::Source;
use parameters::tags::{self, Area, Tag};
use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;
use std::rc::Rc;

/// A block: the index of its source, and its index there.
pub(crate) type BlockId = (usize, usize);

/// The state of a declaration that may depend on itself.
#[derive(Clone, Debug)]
pub enum State<T> {
    /// Being declared.
    Open,
    /// Declared.
    Known(T),
}

impl<T> State<T> {
    /// The declaration, if complete.
    pub fn known(&self) -> Option<&T> {
        match self {
            State::Open => None,
            State::Known(known) => Some(known),
        }
    }
}

/// The state of a compilation.
pub struct Compiler<'a> {
    pub sources: &'a [Source],
    pub trees: &'a [Tree],
    pub cpu: Cpu,
    pub options: &'a Manifest,
    pub report: Report,
    pub program: Program,
    /// The blocks of the sources, by name.
    pub names: HashMap<String, BlockId>,
    /// Blocks that an earlier source also declares, with different text.
    pub copies: Vec<Twin>,
    /// The blocks of the library, by name.
    pub library: HashMap<String, BlockId>,
    pub types: HashMap<BlockId, State<Type>>,
    /// The type DTL; `None` until its first use.
    pub dtl: Option<Type>,
    pub blocks: Vec<Interface>,
    pub block_of: HashMap<BlockId, State<usize>>,
    pub natives: HashMap<String, usize>,
    pub globals: HashMap<String, State<Global>>,
    /// The kind of timer or counter that each variable of a generic type is called as, by the last name of its path.
    pub kinds: HashMap<String, String>,
    /// The tags declared in the options, by name.
    pub declared: HashMap<String, &'a Tag>,
    /// The names of the tags that have an address, by area and bit range.
    pub by_address: OnceCell<HashMap<(char, Range<u64>), String>>,
    /// Declarations outside blocks, by name: source index, section and member.
    pub global_members: HashMap<String, (usize, &'a Section, &'a Member)>,
    /// Blocks to be compiled as stubs, by name.
    pub stubs: HashSet<String>,
    /// Whether system blocks that need PLC hardware are treated as undeclared, to be declared later, rather than as
    /// errors.
    pub assumes: bool,
    pub undeclared: BTreeMap<String, Undeclared>,
    /// The calls: the indices of the caller and the callee in `blocks`, and the location of the call.
    pub calls: Vec<(usize, usize, Span)>,
    /// The Boolean expressions to record when they are evaluated: source index and expression.
    pub watched: HashSet<(usize, ExpressionId)>,
    /// The locals in which the watched expressions are recorded.
    pub notes: Vec<Note>,
    /// The total size of all records in bytes, used to reject types that no CPU memory can hold.
    pub bytes: usize,
}

impl<'a> Compiler<'a> {
    /// The index of the library among the sources.
    pub fn library_file(&self) -> usize {
        self.trees.len() - 1
    }

    pub fn block(&self, (file, index): BlockId) -> &'a SourceBlock {
        &self.trees[file].blocks[index]
    }

    /// The expression arena of a source.
    pub fn expressions(&self, file: usize) -> &'a Expressions {
        &self.trees[file].expressions
    }

    /// The source line at which a span starts.
    pub fn at(&self, span: Span) -> At {
        let line = self.sources[span.file as usize].place(span.range()).line;
        At { file: span.file as u16, line: line as u32 }
    }

    /// The text covered by a span.
    pub fn text(&self, span: Span) -> &'a str {
        &self.sources[span.file as usize].text[span.range()]
    }

    /// The address (if it has one) and comment of a tag; `None` if no tag of this name is declared.
    pub fn tag(&self, name: &str) -> Option<(Option<Area>, &'a str)> {
        let comment = match self.global_members.get(name) {
            Some((_, _, member)) => &member.comment,
            None => &self.declared.get(name)?.comment,
        };
        Some((self.address(name).as_deref().and_then(tags::area), comment))
    }

    /// The address of a tag, by upper-case name; `None` if it has no address or is not declared.
    pub fn address(&self, name: &str) -> Option<String> {
        match self.global_members.get(name) {
            Some((_, _, member)) => tags::address(&member.at.as_ref()?.text),
            None => self.declared.get(name)?.address.clone(),
        }
    }

    /// The upper-case name of the tag at an address; `None` if no tag has this address or the string is not an address.
    pub fn tag_at(&self, address: &str) -> Option<&str> {
        let by_address = self.by_address.get_or_init(|| {
            let names = self.global_members.keys().chain(self.declared.keys());
            let placed = names.filter_map(|name| Some((tags::bits(&self.address(name)?)?, name.clone())));
            let mut all: Vec<_> = placed.collect();
            // If several tags share an address, the first by name wins.
            all.sort_unstable_by(|one, other| other.1.cmp(&one.1));
            all.into_iter().collect()
        });
        by_address.get(&tags::bits(&tags::address(address)?)?).map(String::as_str)
    }

    /// Reports a warning, except in the library.
    pub fn warn(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        if span.file as usize != self.library_file() {
            self.report.warning(span, message, help);
        }
    }

    pub fn error(&mut self, span: Span, message: impl Into<String>, help: Option<&str>) {
        self.report.error(span, message, help);
    }
}

/// A copy of a block whose text differs from that of the first one.
pub struct Twin {
    /// The first block of that name.
    pub first: BlockId,
    /// The copy.
    pub id: BlockId,
    /// The number of this copy, counted from 1.
    pub number: usize,
}

/// The interface of a callable block.
#[derive(Debug)]
pub struct Interface {
    pub name: String,
    pub kind: BlockKind,
    /// The block that declares it; `None` for a native block.
    pub source: Option<BlockId>,
    /// Its parameters and static variables, in declaration order.
    pub members: Vec<Parameter>,
    /// Its symbol table, by upper-case name.
    pub symbols: Rc<HashMap<String, Symbol>>,
    /// The type of its return value; `Void` if it has none.
    pub result: Type,
    /// The index of the record that each instance has; 0 if it has no instances.
    pub record: usize,
    /// Its index in the program's functions.
    pub function: usize,
    /// The local that holds ENO, if the block may set it.
    pub eno: Option<usize>,
    /// Its AT views, which overlay other variables.
    pub views: Vec<View>,
    /// Whether it is a stub: the FMU exposes its inputs as outputs, and its outputs as inputs.
    pub is_stub: bool,
}

/// A parameter or a static variable of a block.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name as written in the source.
    pub name: String,
    /// Its name in upper case.
    pub key: String,
    /// The section that declares it.
    pub section: SectionKind,
    pub of: Type,
    /// Where its value is stored.
    pub slot: Slot,
    /// The author's comment on it.
    pub comment: String,
    /// Whether it is marked as a setpoint (`S7_SETPOINT`), a value for the user to set.
    pub is_setting: bool,
    /// Whether it is hidden from the user.
    pub is_hidden: bool,
    pub is_retained: bool,
}

/// Where a variable of a block is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// A member of the instance.
    Member(usize),
    /// A local of the function.
    Local(usize),
}

/// The meaning of a name in a block.
#[derive(Clone, Debug)]
pub enum Symbol {
    Variable(SectionKind, Type, Slot),
    Constant(Operand),
}

#[derive(Clone, Debug)]
pub struct Global {
    /// Its index among the memory's members.
    pub member: usize,
    pub of: Type,
    /// The structured in-out parameter of the main block that it represents, if any.
    pub parameter: Option<String>,
}

impl Global {
    /// Its place in memory.
    pub fn place(&self) -> Place {
        Place::new(Base::Memory).member(self.member)
    }
}

/// Where a Boolean expression is recorded when it is evaluated: a local of a function, which is 0 until then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Note {
    /// The source index.
    pub file: usize,
    /// The index of the expression in that source.
    pub expression: u32,
    /// The index of the function.
    pub function: usize,
    /// The index of the local, a `U8`.
    pub local: usize,
}

impl Note {
    /// The expression was FALSE.
    pub const FALSE: u8 = 1;
    /// The expression was TRUE.
    pub const TRUE: u8 = 2;
}

/// The result of lowering an expression.
#[derive(Clone, Debug)]
pub enum Operand {
    /// An untyped integer.
    Whole(i128),
    /// An untyped floating-point literal, as LREAL and as REAL.
    Fraction(f64, f32),
    /// A string, and whether its characters are 16 bits wide, if known.
    Text(Vec<u16>, Option<bool>),
    /// A scalar of elementary type.
    Value(Elementary, Expr),
    /// A structure, array, string or instance.
    Variable(Type, Place),
    /// An expression already reported as an error, with the undeclared name if that is the cause.
    Wrong(Option<Missing>),
}

/// An AT view of another variable.
#[derive(Clone, Debug)]
pub struct View {
    pub name: String,
    /// The local in which the view itself is stored.
    pub local: usize,
    /// The upper-case name of the viewed variable.
    pub behind: String,
    /// The type of the view.
    pub of: Type,
    /// The location of the viewed variable's name in the declaration.
    pub span: Span,
}

impl From<SectionKind> for ir::Section {
    /// Maps a declaration section to the program's section, which specifies who writes a member and who reads it.
    fn from(section: SectionKind) -> ir::Section {
        match section {
            SectionKind::Input => ir::Section::Input,
            SectionKind::Output => ir::Section::Output,
            SectionKind::InOut => ir::Section::InOut,
            _ => ir::Section::Static,
        }
    }
}

/// An empty map, for blocks without symbols.
pub(crate) fn nothing<K, V>() -> Rc<HashMap<K, V>> {
    Rc::new(HashMap::new())
}
