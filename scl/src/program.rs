//! The typed program: what SCL is translated to, and what is run or printed.
//!
//! It knows neither SCL nor FMI. Every operation names the type in which it is calculated, nothing is converted implicitly, and
//! every variable has its place in one block of bytes, so that a saved state is a copy of these bytes:
//!
//! - [`Program::memory`] is a record with everything that lives from call to call;
//! - a [`Function`] works on its parameters and temporaries ([`Function::locals`]) and, if it belongs to a function block, on an
//!   instance, which is a record somewhere in the memory.

mod law;
mod layout;
pub(crate) mod mathematics;
pub(crate) mod operations;
mod print;
mod value;
pub(crate) mod walk;

pub use blocks::Kind;
pub(crate) use layout::extent;
pub use layout::{align, scalar};
pub use value::{Scalar, Value};

use std::collections::{BTreeMap, BTreeSet};

/// A program.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// The names of the source files, to which [`At::file`] refers.
    pub files: Vec<String>,
    /// All structures, to which [`Type::Record`] refers.
    pub records: Vec<Record>,
    /// The record of everything that lives from call to call: instances and global data.
    pub memory: usize,
    /// The record of constants that are too large for an [`Expr::Const`]: texts, for example.
    pub constants: usize,
    /// All functions, to which [`Call::function`] refers.
    pub functions: Vec<Function>,
    /// What the source says about them.
    pub docs: Docs,
}

/// What a source says about the parts of a program: lines of text for those who read it printed. Nothing is calculated from it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Docs {
    /// What stands before the program.
    pub head: String,
    /// Of records, by number.
    pub records: BTreeMap<usize, String>,
    /// Of members, by the numbers of record and member.
    pub members: BTreeMap<(usize, usize), String>,
    /// Of functions, by number.
    pub functions: BTreeMap<usize, String>,
    /// The functions of blocks that were not written in SCL: the budget does not count their statements.
    pub natives: BTreeSet<usize>,
    /// Of functions that are the law of a block, the function that has the law as statements ([`Program::add_law`]).
    pub laws: BTreeMap<usize, usize>,
    /// How members are declared, by the numbers of record and member.
    pub declared: BTreeMap<(usize, usize), Declared>,
}

/// How a source declares a member of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Declared {
    /// Who sets it and who reads it.
    pub section: Section,
    /// The elementary type, or that of its elements, if it tells more than [`Type`] does: TIME or WORD, for example.
    pub of: Option<Kind>,
}

/// Who sets a member and who reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// The caller sets it.
    Input,
    /// The caller reads it.
    Output,
    /// The caller sets and reads it.
    InOut,
    /// It belongs to the block.
    Static,
    /// A value for the host of an FMU, which the block of a PLC does not have.
    Host,
}

/// A line of a source, for messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct At {
    /// The number of the file in [`Program::files`].
    pub file: u16,
    /// The line, from 1; 0 if the statement has none.
    pub line: u32,
}

impl At {
    /// Of a statement that a program has only for who watches it: it is not counted, and has no line.
    pub const NOTE: At = At { file: u16::MAX, line: 0 };
}

/// The type of a variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Type {
    /// A number or a truth value.
    Scalar(Scalar),
    /// A string: its length in characters as a `u16`, then room for `capacity` characters.
    Text {
        /// The most characters that it holds.
        capacity: u16,
        /// Characters have 16 bits instead of 8.
        wide: bool,
    },
    /// An array, row by row: the last index runs fastest.
    Array {
        /// The type of its elements.
        of: Box<Type>,
        /// The lowest and the highest index of each dimension.
        bounds: Vec<(i32, i32)>,
    },
    /// An array whose bounds come from the caller; only of a parameter that is passed by reference.
    Open {
        /// The type of its elements.
        of: Box<Type>,
        /// The number of its dimensions.
        dimensions: usize,
    },
    /// A structure, or the instance of a function block: a number in [`Program::records`].
    Record(usize),
}

/// A structure with the places of its members.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Record {
    /// Its name, for messages and printing.
    pub name: String,
    /// Its members, in the order of declaration.
    pub members: Vec<Member>,
    /// The start values of all members as bytes; as long as the record.
    pub start: Vec<u8>,
    /// The power of 2 of which its address is a multiple.
    pub align: usize,
}

/// A member of a structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// The number of bytes before it.
    pub offset: usize,
}

/// Code with its parameters and temporaries.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Its name, for messages and printing.
    pub name: String,
    /// The record of the instance on which it works, if it belongs to a function block.
    pub instance: Option<usize>,
    /// Parameters, results and temporaries. All but the parameters have the start values of their types in every call.
    pub locals: Vec<Local>,
    /// How many of [`Function::locals`], from the first one on, a call passes.
    pub parameters: usize,
    /// What it does.
    pub body: Body,
}

/// A parameter, a result or a temporary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Local {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Whether it stands for a variable of the caller; only of a parameter, and always of a [`Type::Open`].
    pub by_reference: bool,
}

/// What a function does.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// Statements.
    Code(Vec<Statement>),
    /// The law of a block of [`blocks`], by its name.
    Native(&'static str),
}

/// A statement and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Its line.
    pub at: At,
    /// What it does.
    pub what: What,
}

/// What a statement does.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// Stores a number.
    Assign(Place, Expr),
    /// Copies a structure or an array of the same size, or a text, which is cut to the capacity: to, from.
    Copy(Place, Place),
    /// Calls a function.
    Call(Call),
    /// Runs the first list if the condition is TRUE, else the second one.
    If(Expr, Vec<Statement>, Vec<Statement>),
    /// Runs the first arm with the value of an integer, or the statements behind the arms.
    Case(Expr, Vec<Arm>, Vec<Statement>),
    /// Tests, runs, and begins again.
    While(Expr, Vec<Statement>),
    /// Runs, tests, and begins again if the condition is FALSE.
    Repeat(Vec<Statement>, Expr),
    /// Counts.
    For(Box<For>),
    /// Leaves the innermost loop.
    Break,
    /// Goes to the end of the innermost loop's body.
    Continue,
    /// Leaves the function.
    Return,
    /// The place of a label of this function.
    Label(usize),
    /// Goes to a label of this function.
    Goto(usize),
    /// A comment of the source, for those who read the program printed. It is no statement: the budget does not count it.
    Comment(String),
}

/// One arm of [`What::Case`].
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// The values, as ranges: lowest and highest.
    pub values: Vec<(i64, i64)>,
    /// What is done.
    pub body: Vec<Statement>,
}

/// A loop that counts. First, last and step are calculated once, in this order; the test comes before each run. A step beyond the
/// range of the variable wraps and ends the loop.
#[derive(Clone, Debug, PartialEq)]
pub struct For {
    /// The variable, an integer.
    pub variable: Place,
    /// Its first value.
    pub first: Expr,
    /// Its last value; a step that passes it ends the loop.
    pub last: Expr,
    /// What is added after each run.
    pub step: Expr,
    /// What is run.
    pub body: Vec<Statement>,
}

/// A call.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// The number of the function.
    pub function: usize,
    /// The instance, if the function belongs to a function block.
    pub instance: Option<Place>,
    /// One for each parameter.
    pub arguments: Vec<Argument>,
    /// What is copied out behind the body, in this order: a local of the function, and where it is copied to.
    pub outputs: Vec<(usize, Place)>,
}

/// What is passed for a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// A number.
    Value(Expr),
    /// A copy of a structure, an array or a text.
    Copy(Place),
    /// The variable itself.
    Reference(Place),
    /// Nothing: the start value of its type.
    Start,
}

/// A variable, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Where it begins.
    pub base: Base,
    /// How it goes on from there.
    pub steps: Vec<Step>,
}

/// Where a [`Place`] begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// [`Program::memory`].
    Memory,
    /// [`Program::constants`]: only to be read.
    Constants,
    /// The instance on which the function works.
    Instance,
    /// A local of the function.
    Local(usize),
}

/// A step to a part of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// To a member of a record, by number.
    Member(usize),
    /// To an element of an array, with an integer for each dimension, or to a character of a text, from 1 on.
    Index(Vec<Expr>, At),
    /// To the length of a text, a `U16`. What is beyond the capacity counts as the capacity.
    Length,
}

/// A number that is calculated.
#[derive(Clone, Debug, PartialEq)]
pub enum Expr {
    /// A constant.
    Const(Value),
    /// The value of a variable.
    Load(Scalar, Place),
    /// An operation on one number, in its type.
    Unary(Unary, Scalar, Box<Expr>),
    /// An operation on two numbers of the same type, the left one first. The amount of a shift or rotation is a `U32`.
    Binary(Binary, Scalar, Box<Expr>, Box<Expr>, At),
    /// A conversion: how, from which type, to which type.
    Convert(Convert, Scalar, Scalar, Box<Expr>, At),
    /// The second number if the first one, a truth value, is TRUE, else the third. All are calculated, in this order.
    Select(Scalar, Box<[Expr; 3]>),
    /// The number in the middle of `[lowest, number, highest]`; the number itself if the lowest is above the highest.
    Limit(Scalar, Box<[Expr; 3]>),
    /// A comparison of two texts by the codes of their characters; the shorter one is less.
    Texts(Binary, Place, Place),
    /// Whether two structures or arrays of the same type have equal members.
    Same(Place, Place),
    /// The lowest or highest index of a dimension, from 0, of an array whose bounds come from the caller; an `I32`.
    Bound {
        /// The parameter.
        local: usize,
        /// The dimension.
        dimension: usize,
        /// The highest index.
        upper: bool,
    },
    /// The time of the call in nanoseconds since the start; an `I64`.
    Now,
    /// A number that is calculated after these statements, a call for example.
    After(Vec<Statement>, Box<Expr>),
}

/// An operation on one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// `-x`; an integer wraps.
    Neg,
    /// All bits inverted, or the opposite of a truth value.
    Not,
    /// The absolute value; an integer wraps.
    Abs,
    /// The bytes in reverse order.
    Swap,
    /// The part behind the decimal point, with the sign of the number.
    Frac,
    /// The square root, rounded once.
    Sqrt,
    /// e to the power of x.
    Exp,
    /// The natural logarithm.
    Ln,
    /// The logarithm to base 10.
    Log,
    /// The sine of an angle in radians.
    Sin,
    /// The cosine.
    Cos,
    /// The tangent.
    Tan,
    /// The angle in radians of which this is the sine.
    Asin,
    /// The angle of which this is the cosine.
    Acos,
    /// The angle of which this is the tangent.
    Atan,
}

/// An operation on two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// `a + b`; integers wrap.
    Add,
    /// `a - b`; integers wrap.
    Sub,
    /// `a * b`; integers wrap.
    Mul,
    /// `a / b`; an integer is truncated, and 0 if b is 0.
    Div,
    /// The remainder of an integer division, with the sign of a, and 0 if b is 0.
    Rem,
    /// a to the power of b, of floating-point numbers.
    Pow,
    /// Bit by bit; also of truth values.
    And,
    /// Bit by bit; also of truth values.
    Or,
    /// Bit by bit; also of truth values.
    Xor,
    /// Bits shifted to the left; all of them out from the width on.
    Shl,
    /// Bits shifted to the right, filled with the sign; all of them out from the width on.
    Shr,
    /// Bits rotated to the left.
    Rol,
    /// Bits rotated to the right.
    Ror,
    /// The lesser one; a if neither is less.
    Min,
    /// The greater one; a if neither is greater.
    Max,
    /// `a = b`: FALSE if one is not a number, as all comparisons.
    Eq,
    /// `a <> b`.
    Ne,
    /// `a < b`.
    Lt,
    /// `a <= b`.
    Le,
    /// `a > b`.
    Gt,
    /// `a >= b`.
    Ge,
}

/// How a number is converted to another type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convert {
    /// The value: integers are extended by their own sign, then the low bits are taken; a truth value is 0 or 1, or the lowest
    /// bit; a floating-point number is rounded once, and to an integer with ties to even.
    Value,
    /// A floating-point number to an integer, towards 0.
    Trunc,
    /// A floating-point number to an integer, upwards.
    Ceil,
    /// A floating-point number to an integer, downwards.
    Floor,
    /// The bits, between a floating-point number and an integer of the same width.
    Bits,
}

impl Binary {
    /// Whether the result is a truth value.
    pub fn compares(self) -> bool {
        matches!(self, Binary::Eq | Binary::Ne | Binary::Lt | Binary::Le | Binary::Gt | Binary::Ge)
    }

    /// Whether the right side is the number of bits, a `U32`.
    pub fn shifts(self) -> bool {
        matches!(self, Binary::Shl | Binary::Shr | Binary::Rol | Binary::Ror)
    }
}

impl Expr {
    /// The type of the number.
    pub fn ty(&self) -> Scalar {
        match self {
            Expr::Const(value) => value.ty(),
            Expr::Binary(op, ..) if op.compares() => Scalar::Bool,
            Expr::Load(ty, _) | Expr::Unary(_, ty, _) | Expr::Binary(_, ty, ..) => *ty,
            Expr::Convert(_, _, to, ..) => *to,
            Expr::Select(ty, _) | Expr::Limit(ty, _) => *ty,
            Expr::Texts(..) | Expr::Same(..) => Scalar::Bool,
            Expr::Bound { .. } => Scalar::I32,
            Expr::Now => Scalar::I64,
            Expr::After(_, value) => value.ty(),
        }
    }

    /// The value of an integer constant within bounds: as an index it needs no check.
    pub(crate) fn constant_within(&self, (low, high): (i32, i32)) -> Option<i64> {
        let Expr::Const(value) = self else { return None };
        let number = value.bits() as i64;
        (value.ty().is_integer() && (i64::from(low)..=i64::from(high)).contains(&number)).then_some(number)
    }
}

impl Place {
    /// A whole variable.
    pub fn of(base: Base) -> Place {
        Place { base, steps: Vec::new() }
    }

    /// One of its members.
    pub fn member(mut self, number: usize) -> Place {
        self.steps.push(Step::Member(number));
        self
    }
}
