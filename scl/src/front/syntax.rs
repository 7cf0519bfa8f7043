//! The syntax tree, which is the same for all source formats.

use crate::check::types::Elementary;
use crate::front::lexer::Span;
use crate::ladder::Network;
use std::collections::BTreeSet;

/// A name, without quotation marks.
#[derive(Clone, Debug)]
pub struct Name {
    /// As written in the source.
    pub text: String,
    /// The location, including `#` and quotation marks.
    pub span: Span,
}

impl Name {
    /// The key for looking up the name: names are case-insensitive.
    pub fn key(&self) -> String {
        key(&self.text)
    }
}

/// The key for looking up a name.
pub(crate) fn key(name: &str) -> String {
    name.to_uppercase()
}

/// The index of an expression in the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExpressionId(pub u32);

/// All expressions of a source, in an arena so that deep nesting does not exhaust the stack.
#[derive(Debug, Default)]
pub struct Expressions(Vec<Expression>);

impl Expressions {
    pub fn add(&mut self, kind: ExpressionKind, span: Span) -> ExpressionId {
        let depth = |id: &ExpressionId| self[*id].depth;
        let below = match &kind {
            ExpressionKind::Unary(_, inner)
            | ExpressionKind::Member(inner, _)
            | ExpressionKind::Pointer(inner)
            | ExpressionKind::As(_, inner) => depth(inner),
            ExpressionKind::Binary(_, left, right) => depth(left).max(depth(right)),
            ExpressionKind::Index(base, indices) => indices.iter().map(depth).fold(depth(base), u32::max),
            ExpressionKind::Call(callee, arguments) => {
                arguments.iter().map(|argument| depth(&argument.value)).fold(depth(callee), u32::max)
            }
            ExpressionKind::Literal(_)
            | ExpressionKind::Name(..)
            | ExpressionKind::Address(_)
            | ExpressionKind::Wrong => 0,
        };
        self.0.push(Expression { kind, span, depth: below + 1 });
        ExpressionId(self.0.len() as u32 - 1)
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }
}

impl std::ops::Index<ExpressionId> for Expressions {
    type Output = Expression;

    fn index(&self, id: ExpressionId) -> &Expression {
        &self.0[id.0 as usize]
    }
}

#[derive(Debug)]
pub struct Expression {
    pub kind: ExpressionKind,
    pub span: Span,
    /// The depth of its tree: 1 for an expression without operands.
    pub depth: u32,
}

#[derive(Debug)]
pub enum ExpressionKind {
    /// A number, a string or a typed literal, as written.
    Literal(String),
    /// `-a`, `NOT a`.
    Unary(Unary, ExpressionId),
    /// `a + b`.
    Binary(Binary, ExpressionId, ExpressionId),
    /// A variable, a block or a constant.
    Name(Scope, Name),
    /// `%I0.0`, as written.
    Address(String),
    /// `a.b`; also `a.%X3`, with the percent sign in the name.
    Member(ExpressionId, Name),
    /// `a[i, j]`.
    Index(ExpressionId, Vec<ExpressionId>),
    /// `a(x := 1, y => b)`.
    Call(ExpressionId, Vec<Argument>),
    /// `a^`, which is rejected.
    Pointer(ExpressionId),
    /// A value converted to the type of a box's pin, as in an assignment.
    As(Elementary, ExpressionId),
    /// A syntax error, which has been reported.
    Wrong,
}

/// The notation of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// `#name`.
    Local,
    /// `"name"`.
    Global,
    /// `name`.
    Bare,
}

/// An argument of a call.
#[derive(Clone, Debug)]
pub struct Argument {
    /// The parameter; `None` for a positional argument.
    pub name: Option<Name>,
    /// Whether it is passed with `=>`.
    pub is_output: bool,
    /// The argument's value.
    pub value: ExpressionId,
    /// The location of the whole argument.
    pub span: Span,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// `+a`
    Plus,
    /// `-a`
    Minus,
    /// `NOT a`
    Not,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Binary {
    Power,
    Multiply,
    Divide,
    Modulo,
    Add,
    Subtract,
    Less,
    Greater,
    LessOrEqual,
    GreaterOrEqual,
    Equal,
    NotEqual,
    And,
    Xor,
    Or,
}

#[derive(Debug)]
pub struct Statement {
    pub kind: StatementKind,
    pub span: Span,
}

#[derive(Debug)]
pub enum StatementKind {
    /// `a := b += c`: the targets from left to right, each with the operator after it.
    Assign(Vec<(ExpressionId, Option<Binary>)>, ExpressionId),
    /// A call of a block or function.
    Call(ExpressionId),
    /// The conditions with their statements, then the ELSE branch.
    If(Vec<(ExpressionId, Vec<Statement>)>, Vec<Statement>),
    /// The selector, the labels of each branch with its statements, then the ELSE branch.
    Case(ExpressionId, Vec<(Vec<Label>, Vec<Statement>)>, Vec<Statement>),
    /// A counting loop.
    For {
        /// The loop variable.
        variable: ExpressionId,
        /// Its first value.
        first: ExpressionId,
        /// Its last value.
        last: ExpressionId,
        /// The step; 1 if omitted.
        step: Option<ExpressionId>,
        /// The statements to repeat.
        body: Vec<Statement>,
    },
    /// WHILE: the condition and the body.
    While(ExpressionId, Vec<Statement>),
    /// REPEAT: the body and the condition that ends the loop.
    Repeat(Vec<Statement>, ExpressionId),
    /// Leaves the loop.
    Exit,
    /// Continues with the next iteration of the loop.
    Continue,
    /// Leaves the block; a value, if given, is assigned to ENO.
    Return(Option<ExpressionId>),
    /// Jumps to a label.
    Goto(Name),
    Label(Name),
    /// Declares a temporary for the rest of the block, with an optional type and value. Without a type, it has that of
    /// the value; without either, that of the output stored in it.
    Let(Name, Option<Elementary>, Option<ExpressionId>),
    /// A title or comment, kept in the program.
    Comment(String),
}

/// A label of CASE: a value or a range.
#[derive(Clone, Copy, Debug)]
pub struct Label {
    /// The value, or the lower bound.
    pub low: ExpressionId,
    /// The inclusive upper bound of a range.
    pub high: Option<ExpressionId>,
}

/// The kind of a block. PLC data types count as blocks, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum BlockKind {
    FunctionBlock,
    Function,
    DataBlock,
    Type,
    OrganizationBlock,
}

/// A block of a source.
#[derive(Debug)]
pub struct SourceBlock {
    pub kind: BlockKind,
    pub name: Name,
    /// The return type of a function, or the block or type of a data block.
    pub of: Option<Type>,
    pub attributes: Vec<Attribute>,
    /// The comment in its header.
    pub comment: String,
    pub sections: Vec<Section>,
    /// Its statements; in a data block, assignments of start values.
    pub body: Vec<Statement>,
}

impl SourceBlock {
    /// Creates a block that is empty except for its kind and name.
    pub fn new(kind: BlockKind, name: Name) -> SourceBlock {
        SourceBlock {
            kind,
            name,
            of: None,
            attributes: Vec::new(),
            comment: String::new(),
            sections: Vec::new(),
            body: Vec::new(),
        }
    }

    /// Its title in messages: `FB Motor`.
    pub fn title(&self) -> String {
        let kind = match self.kind {
            BlockKind::FunctionBlock => "FB",
            BlockKind::Function => "FC",
            BlockKind::OrganizationBlock => "OB",
            BlockKind::DataBlock => "DB",
            BlockKind::Type => "type",
        };
        format!("{kind} {}", self.name.text)
    }

    /// Whether its attribute `STUB` is true.
    pub fn is_stub(&self) -> bool {
        attribute(&self.attributes, STUB).is_some_and(|value| value.eq_ignore_ascii_case("true"))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum SectionKind {
    Input,
    Output,
    InOut,
    Static,
    Temp,
    Constant,
}

/// A section of a declaration.
#[derive(Debug)]
pub struct Section {
    /// The kind of its members.
    pub kind: SectionKind,
    /// Whether its members are retentive.
    pub is_retained: bool,
    pub members: Vec<Member>,
}

/// Members of one type, declared together.
#[derive(Debug)]
pub struct Member {
    pub names: Vec<Name>,
    pub attributes: Vec<Attribute>,
    /// The variable that they overlay (`AT`).
    pub at: Option<Name>,
    /// Their type; `None` in CONST.
    pub of: Option<Type>,
    /// Their start value.
    pub start: Option<Start>,
    /// Their comment, on the same line.
    pub comment: String,
}

/// An attribute in braces.
#[derive(Clone, Debug)]
pub struct Attribute {
    /// Its upper-case name.
    pub key: String,
    pub value: String,
}

/// The attribute that marks a stub.
pub(crate) const STUB: &str = "STUB";

/// The attribute that specifies what triggers an organization block, with SimaticML's values: `CyclicInterrupt`.
pub(crate) const EVENT: &str = "SECONDARYTYPE";

/// The value of an attribute, by its upper-case name.
pub(crate) fn attribute<'a>(attributes: &'a [Attribute], key: &str) -> Option<&'a str> {
    attributes.iter().find(|attribute| attribute.key == key).map(|attribute| attribute.value.as_str())
}

/// A type as written in the source.
#[derive(Debug)]
pub struct Type {
    pub kind: TypeKind,
    pub span: Span,
}

#[derive(Debug)]
pub enum TypeKind {
    /// The name of a type or block.
    Name {
        /// The name, as written.
        name: String,
        /// Whether it is in quotation marks.
        is_quoted: bool,
    },
    /// STRING, STRING[n], WSTRING.
    Text {
        /// Whether its characters are 16 bits wide.
        is_wide: bool,
        /// The declared maximum number of characters.
        length: Option<ExpressionId>,
    },
    /// The bounds of each dimension (`None` for `*`), and the element type.
    Array(Vec<Option<[ExpressionId; 2]>>, Box<Type>),
    Struct(Vec<Member>),
    /// `REF_TO type`, which is rejected.
    Reference,
    /// A syntax error, which has been reported.
    Wrong,
}

#[derive(Debug)]
pub enum Start {
    /// A constant expression.
    Value(ExpressionId),
    /// `[1, 2]`, `(1, 2)`, `1, 2`.
    List(Vec<Start>, Span),
    /// `3(0)`: the count, and the values to repeat.
    Repeat(ExpressionId, Vec<Start>),
    /// `(x := 1, y := 2)`.
    Members(Vec<(Name, Start)>, Span),
    /// The values of individual parts, by path; other parts keep the defaults of their types.
    Parts(Vec<(Vec<PathStep>, ExpressionId)>, Span),
}

/// A step in the path to a part of a variable.
#[derive(Clone, Debug)]
pub enum PathStep {
    /// A member of a structure or an instance.
    Member(Name),
    /// An element of an array.
    Element(Vec<i64>),
}

/// The syntax tree of a source.
#[derive(Debug, Default)]
pub struct Tree {
    pub blocks: Vec<SourceBlock>,
    /// The networks in LAD and FBD, each with the index of its block.
    pub networks: Vec<(usize, Network)>,
    /// The extent of each block, from its first word or element to its last.
    pub extents: Vec<Span>,
    /// Global variables and constants.
    pub globals: Vec<Section>,
    /// The indices of blocks with an interface but no statements, each with the location from which this is known.
    pub protected: Vec<(usize, Span)>,
    /// The indices of blocks whose interface is taken from an instance's data block. Such a block is used only if no
    /// source declares it.
    pub instantiated: Vec<usize>,
    /// The upper-case names of the tag table constants used in SimaticML networks.
    pub constants: BTreeSet<String>,
    /// The expressions of the blocks.
    pub expressions: Expressions,
    /// Whether the source is in TIA Portal's dialect.
    pub is_tia: bool,
    /// Whether any of its blocks may set ENO.
    pub may_set_eno: bool,
}
