//! The typed program, between compiler and back ends. `lower` and the crate `laws` build it; [`machine`], [`c`] and
//! `print` process it.
//!
//! It is independent of SCL and FMI. Every operation names the type in which it is computed, there are no implicit
//! conversions, and all variables live in one block of bytes, so a saved state is a copy of these bytes:
//!
//! - [`Program::memory`] is a record with everything that persists between calls;
//! - a [`Function`] works on its parameters and temporaries ([`Function::locals`]) and, if it belongs to a function
//!   block, on an instance, which is a record somewhere in memory.
//!
//! [`machine`]: crate::machine
//! [`c`]: crate::c

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

/// A complete program: the layout of its data, its start values and its functions.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// The names of the source files, to which [`At::file`] refers.
    pub files: Vec<String>,
    /// All structures, to which [`Type::Record`] refers.
    pub records: Vec<Record>,
    /// The record of everything that persists between calls: instances and global data.
    pub memory: usize,
    /// The record of constants too large for an [`Expr::Const`], such as strings.
    pub constants: usize,
    /// All functions, to which [`Call::function`] refers.
    pub functions: Vec<Function>,
    /// Documentation of its parts.
    pub docs: Docs,
}

/// Documentation of a program's parts, for readers of the printed program. It does not affect execution.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Docs {
    /// The text at the start of the program.
    pub head: String,
    /// The text for each record, by index.
    pub records: BTreeMap<usize, String>,
    /// The text for each member, by record and member index.
    pub members: BTreeMap<(usize, usize), String>,
    /// The text for each function, by index.
    pub functions: BTreeMap<usize, String>,
    /// Functions of blocks not written in SCL: the budget does not count their statements.
    pub natives: BTreeSet<usize>,
    /// For each native function with an added law, the function with the law's statements ([`Program::add_law`]).
    pub laws: BTreeMap<usize, usize>,
    /// Declarations of members, by record and member index.
    pub declared: BTreeMap<(usize, usize), Declared>,
}

/// The declaration of a record's member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Declared {
    /// Its section: who sets and who reads it.
    pub section: Section,
    /// The elementary type of the member or its elements if it is more specific than [`Type`], such as TIME or WORD.
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
    /// It is internal to the block.
    Static,
    /// A value for an FMU's host, which the block in the PLC does not have.
    Host,
}

/// A source line, for messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct At {
    /// The file, as an index into [`Program::files`].
    pub file: u16,
    /// The 1-based line number; 0 if unknown.
    pub line: u32,
}

impl At {
    /// Marks a statement inserted for watching: it has no source line, and the budget does not count it.
    pub const NOTE: At = At { file: u16::MAX, line: 0 };
}

/// The type of a variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Type {
    /// A number or a truth value.
    Scalar(Scalar),
    /// A string: its length in characters as a `u16`, then space for `capacity` characters.
    Text {
        /// The maximum number of characters.
        capacity: u16,
        /// Whether characters have 16 bits instead of 8.
        wide: bool,
    },
    /// An array in row-major order: the last index varies fastest.
    Array {
        /// The type of its elements.
        of: Box<Type>,
        /// The lower and upper bound of each dimension.
        bounds: Vec<(i32, i32)>,
    },
    /// An array whose bounds the caller passes; only for a parameter passed by reference.
    Open {
        /// The type of its elements.
        of: Box<Type>,
        /// The number of dimensions.
        dimensions: usize,
    },
    /// A structure or function block instance: an index into [`Program::records`].
    Record(usize),
}

/// A structure and the layout of its members.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Record {
    /// Its name, for messages and printing.
    pub name: String,
    /// Its members, in the order of declaration.
    pub members: Vec<Member>,
    /// The start values of all members, as the bytes of the record.
    pub start: Vec<u8>,
    /// The alignment of its address, a power of 2.
    pub align: usize,
}

/// A member of a structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Its byte offset in the record.
    pub offset: usize,
}

/// Code with its parameters and temporaries.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Its name, for messages and printing.
    pub name: String,
    /// The record of its instance, if it belongs to a function block.
    pub instance: Option<usize>,
    /// Parameters, results and temporaries. All but the parameters have the start values of their types at the start of
    /// each call.
    pub locals: Vec<Local>,
    /// The number of parameters, which come first in [`Function::locals`].
    pub parameters: usize,
    /// Its statements, or the native block that it runs.
    pub body: Body,
}

/// A parameter, a result or a temporary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Local {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Whether it refers to a variable of the caller; only for parameters, always for a [`Type::Open`].
    pub by_reference: bool,
}

/// The body of a function.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// Statements.
    Code(Vec<Statement>),
    /// The law of the named block of [`blocks`].
    Native(&'static str),
}

/// A statement and its source line.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Its source line.
    pub at: At,
    /// Its effect.
    pub what: What,
}

/// The effect of a statement.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// Stores a number.
    Assign(Place, Expr),
    /// Copies a structure or array of the same size, or a string truncated to the capacity: target, source.
    Copy(Place, Place),
    /// Calls a function.
    Call(Call),
    /// Runs the first list if the condition is TRUE, else the second.
    If(Expr, Vec<Statement>, Vec<Statement>),
    /// Runs the first arm that matches an integer, or the last statements if none does.
    Case(Expr, Vec<Arm>, Vec<Statement>),
    /// A loop that tests its condition before each iteration.
    While(Expr, Vec<Statement>),
    /// A loop that ends after an iteration in which the condition becomes TRUE.
    Repeat(Vec<Statement>, Expr),
    /// A counting loop.
    For(Box<For>),
    /// Leaves the innermost loop.
    Break,
    /// Skips to the end of the innermost loop's body.
    Continue,
    /// Leaves the function.
    Return,
    /// The position of a label of this function.
    Label(usize),
    /// Jumps to a label of this function.
    Goto(usize),
    /// A comment from the source, for readers of the printed program. It is not a statement: the budget does not count
    /// it.
    Comment(String),
}

/// An arm of [`What::Case`].
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// The values, as inclusive ranges.
    pub values: Vec<(i64, i64)>,
    /// The statements to run.
    pub body: Vec<Statement>,
}

/// A counting loop. First, last and step are evaluated once, in this order, and the test precedes each iteration. A
/// step beyond the range of the variable wraps and ends the loop.
#[derive(Clone, Debug, PartialEq)]
pub struct For {
    /// The counter, an integer variable.
    pub variable: Place,
    /// Its first value.
    pub first: Expr,
    /// The last value; a step past it ends the loop.
    pub last: Expr,
    /// The increment, added after each iteration.
    pub step: Expr,
    /// The statements to repeat.
    pub body: Vec<Statement>,
}

/// A function call.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// The index of the function.
    pub function: usize,
    /// The instance, if the function belongs to a function block.
    pub instance: Option<Place>,
    /// The arguments, one for each parameter.
    pub arguments: Vec<Argument>,
    /// The outputs copied after the call, in order: a local of the function, and the target.
    pub outputs: Vec<(usize, Place)>,
}

/// An argument of a call.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// A number.
    Value(Expr),
    /// A copy of a structure, an array or a string.
    Copy(Place),
    /// A reference to a variable.
    Reference(Place),
    /// Nothing passed: the start value of the parameter's type.
    Start,
}

/// A variable or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The variable or record at which the path starts.
    pub base: Base,
    /// The path to the part; empty for the whole.
    pub steps: Vec<Step>,
}

/// The root of a [`Place`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// [`Program::memory`].
    Memory,
    /// [`Program::constants`]: read-only.
    Constants,
    /// The instance of the function.
    Instance,
    /// A local of the function.
    Local(usize),
}

/// A step to a part of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// To a member of a record, by index.
    Member(usize),
    /// To an element of an array, with an integer index for each dimension, or to a character of a string, with a
    /// 1-based index.
    Index(Vec<Expr>, At),
    /// To the length of a string, a `U16`. A length beyond the capacity counts as the capacity.
    Length,
}

/// An expression, whose value is a number.
#[derive(Clone, Debug, PartialEq)]
pub enum Expr {
    /// A constant number of any type.
    Const(Value),
    /// The value of a variable.
    Load(Scalar, Place),
    /// A unary operation, in the type of its operand.
    Unary(Unary, Scalar, Box<Expr>),
    /// A binary operation on two numbers of the same type, the left one evaluated first. The amount of a shift or
    /// rotation is a `U32`.
    Binary(Binary, Scalar, Box<Expr>, Box<Expr>, At),
    /// A conversion: mode, source type, target type.
    Convert(Convert, Scalar, Scalar, Box<Expr>, At),
    /// The second number if the first, a truth value, is TRUE, else the third. All are evaluated, in this order.
    Select(Scalar, Box<[Expr; 3]>),
    /// The median of `[lowest, number, highest]`; the number itself if lowest is above highest.
    Limit(Scalar, Box<[Expr; 3]>),
    /// A lexicographic comparison of two strings by character code.
    Texts(Binary, Place, Place),
    /// Whether two structures or arrays of the same type are equal.
    Same(Place, Place),
    /// The lower or upper bound of one dimension of an array whose bounds the caller passes; an `I32`.
    Bound {
        /// The index of the parameter among the function's locals.
        local: usize,
        /// The dimension, counted from 0.
        dimension: usize,
        /// Whether this is the upper bound.
        upper: bool,
    },
    /// The time of the call in nanoseconds since the start of the simulation; an `I64`.
    Now,
    /// A number evaluated after these statements, such as a call.
    After(Vec<Statement>, Box<Expr>),
}

/// A unary operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// `-x`; an integer wraps.
    Neg,
    /// Bitwise NOT, or the negation of a truth value.
    Not,
    /// The absolute value; an integer wraps.
    Abs,
    /// The number with its bytes in reverse order.
    Swap,
    /// The fractional part, with the sign of the number.
    Frac,
    /// The square root, correctly rounded.
    Sqrt,
    /// e to the power of x.
    Exp,
    /// The natural logarithm.
    Ln,
    /// The logarithm to base 10.
    Log,
    /// The sine of an angle in radians.
    Sin,
    /// The cosine of an angle in radians.
    Cos,
    /// The tangent of an angle in radians.
    Tan,
    /// The arc sine, in radians.
    Asin,
    /// The arc cosine, in radians.
    Acos,
    /// The arc tangent, in radians.
    Atan,
}

/// A binary operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// `a + b`; integers wrap.
    Add,
    /// `a - b`; integers wrap.
    Sub,
    /// `a * b`; integers wrap.
    Mul,
    /// `a / b`; an integer quotient is truncated, and 0 if b is 0.
    Div,
    /// The remainder of an integer division, with the sign of a, and 0 if b is 0.
    Rem,
    /// a to the power of b, for floating-point numbers.
    Pow,
    /// Bitwise AND; also of truth values.
    And,
    /// Bitwise OR; also of truth values.
    Or,
    /// Bitwise XOR; also of truth values.
    Xor,
    /// Shift to the left; 0 if the amount is at least the width.
    Shl,
    /// Shift to the right, filled with the sign bit; an amount of at least the width shifts out all bits.
    Shr,
    /// Rotation to the left by the amount modulo the width.
    Rol,
    /// Rotation to the right by the amount modulo the width.
    Ror,
    /// The minimum; a if neither is less.
    Min,
    /// The maximum; a if neither is greater.
    Max,
    /// `a = b`; like all comparisons, FALSE if an operand is NaN.
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

/// The mode of a conversion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convert {
    /// By value: an integer is extended according to its own signedness, then truncated to the low bits; a truth value
    /// becomes 0 or 1, and an integer's lowest bit becomes a truth value; a floating-point number is rounded once, to
    /// an integer with ties to even.
    Value,
    /// From floating point to an integer, rounding towards 0.
    Trunc,
    /// From floating point to an integer, rounding up.
    Ceil,
    /// From floating point to an integer, rounding down.
    Floor,
    /// By bit pattern, between a floating-point number and an integer of the same width.
    Bits,
}

impl Binary {
    /// Whether this is a comparison, which results in a truth value.
    pub fn compares(self) -> bool {
        matches!(self, Binary::Eq | Binary::Ne | Binary::Lt | Binary::Le | Binary::Gt | Binary::Ge)
    }

    /// Whether this is a shift or rotation, whose right operand is a number of bits as a `U32`.
    pub fn shifts(self) -> bool {
        matches!(self, Binary::Shl | Binary::Shr | Binary::Rol | Binary::Ror)
    }
}

impl Expr {
    /// The type of the value.
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

    /// The value of an integer constant within bounds, which needs no index check.
    pub(crate) fn constant_within(&self, (low, high): (i32, i32)) -> Option<i64> {
        let Expr::Const(value) = self else { return None };
        let number = value.bits() as i64;
        (value.ty().is_integer() && (i64::from(low)..=i64::from(high)).contains(&number)).then_some(number)
    }
}

impl Place {
    /// The whole variable or record at a base.
    pub fn new(base: Base) -> Place {
        Place { base, steps: Vec::new() }
    }

    /// A member of this place.
    pub fn member(mut self, number: usize) -> Place {
        self.steps.push(Step::Member(number));
        self
    }
}
