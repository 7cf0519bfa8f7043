//! The syntax tree.

use crate::lexer::Span;
use crate::network::Network;
use crate::types::Elementary;

/// A name without its quotation marks.
#[derive(Clone, Debug)]
pub struct Name {
    /// As it is written.
    pub text: String,
    /// Where, with `#` and quotation marks.
    pub span: Span,
}

impl Name {
    /// The name by which it is found: names are the same in capitals and in small letters.
    pub fn key(&self) -> String {
        key(&self.text)
    }
}

/// The name by which a name is found.
pub fn key(name: &str) -> String {
    name.to_uppercase()
}

/// An expression of the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExpressionId(pub u32);

/// All expressions of a source, so that a deep one needs no stack.
#[derive(Debug, Default)]
pub struct Expressions(Vec<Expression>);

impl Expressions {
    /// Adds one.
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
            ExpressionKind::Literal(_) | ExpressionKind::Name(..) | ExpressionKind::Address | ExpressionKind::Wrong => {
                0
            }
        };
        self.0.push(Expression { kind, span, depth: below + 1 });
        ExpressionId(self.0.len() as u32 - 1)
    }

    /// How many there are.
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

/// An expression.
#[derive(Debug)]
pub struct Expression {
    /// What it is.
    pub kind: ExpressionKind,
    /// Where.
    pub span: Span,
    /// How many levels there are, this one included.
    pub depth: u32,
}

/// What an expression is.
#[derive(Debug)]
pub enum ExpressionKind {
    /// A number, a text or a literal with a type, as it is written.
    Literal(String),
    /// `-a`, `NOT a`.
    Unary(Unary, ExpressionId),
    /// `a + b`.
    Binary(Binary, ExpressionId, ExpressionId),
    /// A variable, a block or a constant.
    Name(Scope, Name),
    /// `%I0.0`.
    Address,
    /// `a.b`; also `a.%X3`, with the percent sign in the name.
    Member(ExpressionId, Name),
    /// `a[i, j]`.
    Index(ExpressionId, Vec<ExpressionId>),
    /// `a(x := 1, y => b)`.
    Call(ExpressionId, Vec<Argument>),
    /// `a^`, which is refused.
    Pointer(ExpressionId),
    /// A value in the type of a box's pin, converted as in an assignment.
    As(Elementary, ExpressionId),
    /// What could not be read; a message says why.
    Wrong,
}

/// How a name is written.
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
    /// The formal parameter; `None` in a list by position.
    pub name: Option<Name>,
    /// Whether it is `=>`.
    pub is_output: bool,
    /// The actual one.
    pub value: ExpressionId,
    /// All of it.
    pub span: Span,
}

/// An operator with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// `+a`
    Plus,
    /// `-a`
    Minus,
    /// `NOT a`
    Not,
}

/// An operator with two operands.
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

/// A statement.
#[derive(Debug)]
pub struct Statement {
    /// What it is.
    pub kind: StatementKind,
    /// Where it begins, to the end of its head.
    pub span: Span,
}

/// What a statement is.
#[derive(Debug)]
pub enum StatementKind {
    /// `a := b += c`: the targets from left to right, each with the operator behind it.
    Assign(Vec<(ExpressionId, Option<Binary>)>, ExpressionId),
    /// A call.
    Call(ExpressionId),
    /// Conditions and what is done, then ELSE.
    If(Vec<(ExpressionId, Vec<Statement>)>, Vec<Statement>),
    /// The selector, labels and what is done, then ELSE.
    Case(ExpressionId, Vec<(Vec<Label>, Vec<Statement>)>, Vec<Statement>),
    /// Variable, start, end, step, body.
    For(ExpressionId, [ExpressionId; 2], Option<ExpressionId>, Vec<Statement>),
    /// Condition and body.
    While(ExpressionId, Vec<Statement>),
    /// Body and condition.
    Repeat(Vec<Statement>, ExpressionId),
    /// Leaves the loop.
    Exit,
    /// The next run of the loop.
    Continue,
    /// Leaves the block.
    Return(Option<ExpressionId>),
    /// Jumps to a label.
    Goto(Name),
    /// A label.
    Label(Name),
    /// Declares a temporary for the rest of the block: its type, or that of its value; without a value it keeps the one it has.
    Let(Name, Option<Elementary>, Option<ExpressionId>),
    /// A title or a comment that is kept.
    Comment(String),
}

/// A value of CASE, or a range.
#[derive(Clone, Copy, Debug)]
pub struct Label {
    /// The value, or the lowest.
    pub low: ExpressionId,
    /// The highest.
    pub high: Option<ExpressionId>,
}

/// What a block is.
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
pub struct Block {
    /// What it is.
    pub kind: BlockKind,
    /// Its name.
    pub name: Name,
    /// The type of a function's value, or the block or type of a data block.
    pub of: Option<Type>,
    /// Its attributes.
    pub attributes: Vec<Attribute>,
    /// Its comment: the lines of the head.
    pub comment: String,
    /// Its sections.
    pub sections: Vec<Section>,
    /// Its statements; in a data block the start values.
    pub body: Vec<Statement>,
}

impl Block {
    /// How messages name it: `FB Motor`.
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
}

/// What the members of a section are.
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
    /// What its members are.
    pub kind: SectionKind,
    /// Whether its members are retained.
    pub is_retained: bool,
    /// Its members.
    pub members: Vec<Member>,
}

/// Members of one type, declared together.
#[derive(Debug)]
pub struct Member {
    /// Their names.
    pub names: Vec<Name>,
    /// Their attributes.
    pub attributes: Vec<Attribute>,
    /// The variable at whose place they are.
    pub at: Option<Name>,
    /// Their type; `None` in CONST.
    pub of: Option<Type>,
    /// Their start value.
    pub start: Option<Start>,
    /// The comment behind them, in their line.
    pub comment: String,
}

/// An attribute in braces.
#[derive(Clone, Debug)]
pub struct Attribute {
    /// Its name, in capitals.
    pub key: String,
    /// Its value.
    pub value: String,
}

/// The attribute of an organization block that says what calls it, as SimaticML has it: `CyclicInterrupt`.
pub const EVENT: &str = "SECONDARYTYPE";

/// The value of an attribute, without regard to case.
pub fn attribute<'a>(attributes: &'a [Attribute], key: &str) -> Option<&'a str> {
    attributes.iter().find(|attribute| attribute.key == key).map(|attribute| attribute.value.as_str())
}

/// A type as it is written.
#[derive(Debug)]
pub struct Type {
    /// What it is.
    pub kind: TypeKind,
    /// Where.
    pub span: Span,
}

/// What a type is.
#[derive(Debug)]
pub enum TypeKind {
    /// A name, and whether it is in quotation marks.
    Name(String, bool),
    /// STRING, STRING[n]; WSTRING if `true`.
    Text(bool, Option<ExpressionId>),
    /// The bounds of each dimension; `None` is `*`.
    Array(Vec<Option<[ExpressionId; 2]>>, Box<Type>),
    /// The members.
    Struct(Vec<Member>),
    /// `REF_TO type`, which is refused.
    Reference,
    /// What could not be read; a message says why.
    Wrong,
}

/// A start value.
#[derive(Debug)]
pub enum Start {
    /// A constant expression.
    Value(ExpressionId),
    /// `[1, 2]`, `(1, 2)`, `1, 2`.
    List(Vec<Start>, Span),
    /// `3(0)`: how many times, and what.
    Repeat(ExpressionId, Vec<Start>),
    /// `(x := 1, y := 2)`.
    Members(Vec<(Name, Start)>, Span),
    /// The values of parts, by the paths to them; the others keep those of their types.
    Parts(Vec<(Vec<Part>, ExpressionId)>, Span),
}

/// A step of a path to a part of a variable.
#[derive(Clone, Debug)]
pub enum Part {
    /// A member of a structure or an instance.
    Member(Name),
    /// An element of an array.
    Element(Vec<i64>),
}

/// A source as a tree.
#[derive(Debug, Default)]
pub struct Tree {
    /// Its blocks.
    pub blocks: Vec<Block>,
    /// The networks of the blocks in LAD and FBD, each with the number of its block.
    pub networks: Vec<(usize, Network)>,
    /// Where each block stands, from its first word or element to its last.
    pub extents: Vec<Span>,
    /// Variables and constants that all blocks see.
    pub globals: Vec<Section>,
    /// The blocks of which there is an interface alone, by their numbers, and where the source says so.
    pub protected: Vec<(usize, Span)>,
    /// All expressions of them.
    pub expressions: Expressions,
    /// Whether it is in the dialect of TIA Portal.
    pub is_tia: bool,
    /// Whether a block of it may set ENO.
    pub may_set_eno: bool,
}
