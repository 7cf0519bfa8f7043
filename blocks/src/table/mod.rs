//! What a block is: a table of variables, written once, and a law.
//!
//! [`block!`](crate::block!) turns the table into a struct and everything that can be computed from it ([`Block`]); the
//! law is written by hand ([`Law`]). A new block is one file:
//!
//! ```
//! use blocks::{Block, Law, Value};
//!
//! blocks::block! {
//!     /// Counts the calls in which it is enabled.
//!     pub struct Counter as "COUNTER" {
//!         input {
//!             /// The call counts
//!             enable: Bool = true;
//!         }
//!         cycle {
//!             /// Time between two calls
//!             cycle: Time = Time::ms(100), min Time::ms(1);
//!         }
//!         output {
//!             /// Calls counted since the restart
//!             count: Int;
//!         }
//!     }
//! }
//!
//! impl Law for Counter {
//!     fn restart(&mut self) {
//!         self.clear();
//!     }
//!
//!     fn call(&mut self) {
//!         if self.enable {
//!             self.count = self.count.wrapping_add(1);
//!         }
//!     }
//! }
//!
//! let mut counter = Counter::default();
//! counter.call();
//! let count = Counter::TABLE.find("COUNT").unwrap();
//! assert_eq!(counter.get(count), Some(Value::Int(1)));
//! ```

/// Makes an enum whose values have one name each, by which they are written everywhere.
macro_rules! named {
    ($(#[$attribute:meta])* $Enum:ident { $( $(#[doc = $doc:literal])* $Value:ident $name:literal; )* }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $Enum { $( $(#[doc = $doc])* $Value, )* }

        impl $Enum {
            /// All of them.
            pub const ALL: &'static [$Enum] = &[$($Enum::$Value),*];

            /// The name by which it is written, in tables, documentation and messages.
            pub const fn name(self) -> &'static str {
                match self { $( $Enum::$Value => $name, )* }
            }

            /// The one of this name.
            pub fn named(name: &str) -> Option<$Enum> {
                $Enum::ALL.iter().copied().find(|value| value.name() == name)
            }
        }
    };
}
pub mod abreast;
pub mod arrays;
mod block;
#[doc(hidden)]
pub mod docs;
pub mod fingerprint;
mod host;
mod kind;
pub mod number;
mod parts;
pub mod start;
mod stored;
#[cfg(test)]
mod tests;
mod types;

pub use abreast::Abreast;
pub use host::Types;
pub use kind::{Class, Form, Kind};
#[doc(hidden)]
pub use parts::{check_restart_values, copy, cycle_row, help, inner_rows, nest, short_text, text, tunable, upper};
pub use stored::Stored;
pub use types::{Bool, Int, LReal, Real, Time, Word, low_word, rnd};

/// The part of a block that is written by hand: what it does when it is called.
pub trait Law {
    /// The runs that the documentation shows. The reference results of the FMU record the first one.
    const RESPONSES: &'static [Response] = &[Response::AT_REST];

    /// The characteristics that the documentation shows.
    const CHARACTERISTICS: &'static [Characteristic] = &[];

    /// The unit that signals without one of their own have in the documentation's drawings. A controller works in any unit; with
    /// its start values it is percent.
    const DRAWN_UNIT: Option<&'static str> = None;

    /// Whether a call computes what the inputs lead to that are held until the next call, as that of a plant does: its outputs
    /// are those at the next call then, and nothing happens at the instant of the call itself. A controller answers at once.
    const HOLDS_INPUTS: bool = false;

    /// The complete restart, which a PLC runs once at power-up (OB 100), with the present inputs and parameters.
    fn restart(&mut self);

    /// One call, as a cyclic interrupt makes it: reads inputs and parameters, writes outputs and memory.
    fn call(&mut self);

    /// Whether the next call is one that the compiler can make for several blocks at once, see [`abreast`]: it computes nothing
    /// again that it keeps. Asked in a lane only. There [`call`](Law::call) runs whatever this says, and what it has made of a block
    /// that is not steady is thrown away: it must not panic.
    fn is_steady(&self) -> bool {
        true
    }

    /// Refuses parameters with which the block cannot run; called once, before the restart.
    ///
    /// # Errors
    /// A sentence that names the variable, its value and the remedy.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// What the block will do with its present settings where a user may not expect it: sentences with names and numbers.
    fn advice(&self) -> Vec<String> {
        Vec::new()
    }

    /// The state of the actuating pulse: +1 positive or up, -1 negative or down, 0 none. Only for blocks with a `mean`
    /// row, which shows its mean over a communication step in percent.
    fn pulse(&self) -> i32 {
        0
    }
}

/// What gives a number of each of some blocks side by side, as [`Block::reader`] finds it.
pub type Reader<B> = fn(&<B as Block>::Abreast, &mut [f64]);

/// What writes a number to each of some blocks side by side, as [`Block::writer`] finds it; false if one of the numbers is out of range:
/// that block, and those behind it, may have any value then.
pub type Writer<B> = fn(&mut <B as Block>::Abreast, &[f64]) -> bool;

/// What [`block!`](crate::block!) makes of a table: its rows as data, and access to the values by row number.
pub trait Block: Law + Stored + Clone + Default + Send + 'static {
    /// The table as data.
    const TABLE: &'static Table;

    /// A hash of the sources of the crate that has the block, see [`CODE`](crate::CODE).
    const CODE: Option<&'static str>;

    /// Several blocks, which are called together.
    type Abreast: Abreast<Self>;

    /// The time between two calls.
    fn cycle(&self) -> Time;

    /// The value in row `index`; `None` if there is no such row.
    fn get(&self, index: usize) -> Option<Value>;

    /// Writes row `index`, whatever its role; false, and nothing is changed, if there is no such row or `value` is of
    /// another type.
    fn set(&mut self, index: usize, value: Value) -> bool;

    /// The REAL in row `index`, as [`Block::get`] gives it but in fewer instructions; `None` if the row is no REAL.
    fn real(&self, index: usize) -> Option<Real>;

    /// The place of the REAL in row `index`, whatever its role, to be written in fewer instructions than by
    /// [`Block::set`]; `None` if the row is no REAL.
    fn real_mut(&mut self, index: usize) -> Option<&mut Real>;

    /// The LREAL in row `index`, as [`Block::real`].
    fn lreal(&self, index: usize) -> Option<LReal>;

    /// The place of the LREAL in row `index`, as [`Block::real_mut`].
    fn lreal_mut(&mut self, index: usize) -> Option<&mut LReal>;

    /// What gives the numbers in row `index`, as [`number`](number::number) makes it of the value; `None` for a row of an inner block.
    fn reader(index: usize) -> Option<Reader<Self>>;

    /// What writes numbers to row `index`, whatever its role, as [`to_value`](number::to_value) makes a value of it; `None` for a row of
    /// an inner block.
    fn writer(index: usize) -> Option<Writer<Self>>;

    /// Writes the `mean` row, if there is one.
    fn set_mean(&mut self, percent: LReal);
}

/// A block's table as data.
#[derive(Debug)]
pub struct Table {
    /// The block's name, such as `CONT_C`.
    pub name: &'static str,
    /// The other names by which a PLC project may call the block, such as `FB 41`.
    pub aliases: &'static [&'static str],
    /// The block's documentation (Markdown); its first paragraph says what the block does.
    pub docs: &'static str,
    /// All variables: the block's own, then those of the blocks inside it, then the mean.
    pub rows: &'static [Row],
    /// The texts of a program; a block has none. Their value references follow those of the rows.
    pub texts: &'static [Text],
    /// Of each row, whether it is a REAL that may be set at any time: what a host does most. One byte a row.
    pub tunable_reals: &'static [bool],
    /// The same for LREALs.
    pub tunable_lreals: &'static [bool],
    /// The row that holds the time between two calls.
    pub cycle: usize,
    /// The row that holds the mean of the pulse, if there is one.
    pub mean: Option<usize>,
    /// Name and Rust type of each variable of the block's own memory, in the order in which it is stored.
    pub memory: &'static [(&'static str, &'static str)],
    /// The tables of the blocks inside it.
    pub instances: &'static [&'static Table],
    /// The runs that the documentation shows; there is at least one.
    pub responses: &'static [Response],
    /// The characteristics that the documentation shows.
    pub characteristics: &'static [Characteristic],
    /// The unit that signals without one of their own have in these drawings.
    pub drawn_unit: Option<&'static str>,
}

impl Table {
    /// The row of the variable with this full name, such as `GAIN` or `DI_CONT_C.GAIN`.
    pub fn find(&self, full_name: &str) -> Option<usize> {
        self.rows.iter().position(|row| row.full_name() == full_name)
    }
}

/// A text that a host sees: a STRING or WSTRING of a program.
#[derive(Clone, Copy, Debug)]
pub struct Text {
    /// Its name with what leads to it.
    pub name: &'static str,
    /// A short text, on one line.
    pub description: &'static str,
    /// Who sets it, and when.
    pub role: Role,
    /// Its value in a new program.
    pub start: &'static str,
    /// Its type.
    pub ty: TextType,
}

/// The type of a text.
#[derive(Clone, Copy, Debug)]
pub struct TextType {
    /// The most characters that it holds.
    pub most: u16,
    /// A WSTRING, whose characters are those of UTF-16; else a STRING, whose characters are those of ISO 8859-1, a byte each.
    pub is_wide: bool,
}

impl TextType {
    /// Its name with the length, such as `STRING[20]`.
    pub fn name(self) -> String {
        format!("{}[{}]", if self.is_wide { "WSTRING" } else { "STRING" }, self.most)
    }

    /// The characters of a text as the PLC holds them.
    ///
    /// # Errors
    /// It is longer than the variable, or has a character that a STRING does not have.
    pub fn units(self, text: &str) -> Result<Vec<u16>, String> {
        let units: Vec<u16> = text.encode_utf16().collect();
        if units.len() > self.most.into() {
            return Err(format!("{} takes {} characters, not {}", self.name(), self.most, units.len()));
        }
        match text.chars().find(|character| !self.is_wide && u32::from(*character) > 0xFF) {
            Some(other) => Err(format!("a STRING has the characters of ISO 8859-1, and {other:?} is not one of them")),
            None => Ok(units),
        }
    }
}

/// How deep blocks may be nested.
pub const DEPTH: usize = 3;

/// One variable.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The instances that lead to it, outermost first; unused places are empty.
    pub path: [&'static str; DEPTH],
    /// Its name, in capitals.
    pub name: &'static str,
    /// A short text, on one line.
    pub description: &'static str,
    /// What one has to know to use it (Markdown): what it acts on, what happens at the edges, how to choose it. May be empty.
    pub help: &'static str,
    /// Its PLC type.
    pub kind: Kind,
    /// Whether a WORD is an analog value, a number with sign, as in a block; in a program it is bits.
    pub is_analog: bool,
    /// Who sets it, and when.
    pub role: Role,
    /// Its value in a new block.
    pub start: Value,
    /// The lowest sensible value; not enforced: the blocks check no parameter.
    pub min: Option<Value>,
    /// The highest sensible value; not enforced either.
    pub max: Option<Value>,
    /// Its unit, such as `%` or `degC`; `None` for a TIME, which is in seconds.
    pub unit: Option<&'static str>,
    /// Of an output: the rows of the settings on which its value after a restart depends.
    pub from: &'static [usize],
}

impl Row {
    /// A place in a table that is not yet filled.
    #[doc(hidden)]
    pub const EMPTY: Row = Row {
        path: [""; DEPTH],
        name: "",
        description: "",
        help: "",
        kind: Kind::Bool,
        is_analog: false,
        role: Role::Local,
        start: Value::Bool(false),
        min: None,
        max: None,
        unit: None,
        from: &[],
    };

    /// The lowest value that makes sense, as a number. It is not above the REAL nor above its decimals, so that neither a host
    /// that computes in doubles nor the REAL itself falls below it.
    pub fn least(&self) -> Option<f64> {
        self.min.map(|min| number::number(min).min(number::decimal(min)))
    }

    /// The highest value that makes sense, as a number, likewise.
    pub fn greatest(&self) -> Option<f64> {
        self.max.map(|max| number::number(max).max(number::decimal(max)))
    }

    /// The name with the instances that lead to it: `GAIN`, `DI_CONT_C.GAIN`.
    pub fn full_name(&self) -> String {
        let mut name: String =
            self.path.iter().filter(|instance| !instance.is_empty()).flat_map(|i| [*i, "."]).collect();
        name.push_str(self.name);
        name
    }
}

named! {
    /// Who sets a variable, and when: the sections of [`block!`](crate::block!).
    Role {
        /// A signal: what a process, an operator or another block changes while the loop runs.
        Input "input";
        /// A setting that may be tuned while the loop runs.
        Parameter "parameter";
        /// A setting that is fixed once the block runs.
        Fixed "fixed";
        /// The time between two calls: fixed too.
        Cycle "cycle";
        /// A result.
        Output "output";
        /// A signal inside the block, which can be read but is not one of its terminals.
        Local "local";
    }
}

impl Role {
    /// Whether a host may set it, at least before the block runs.
    pub const fn is_settable(self) -> bool {
        !matches!(self, Role::Output | Role::Local)
    }
}

/// A value with its PLC type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// 32-bit floating point.
    Real(Real),
    /// 64-bit floating point.
    LReal(LReal),
    /// Milliseconds.
    Time(Time),
    /// An analog value.
    Word(Word),
    /// A 16-bit integer.
    Int(Int),
    /// One bit.
    Bool(Bool),
    /// An integer of a type that only programs have, see [`Kind::whole`]; the bits of an unsigned one of 64 bits.
    Whole(Kind, i64),
}

impl Value {
    /// Its type.
    pub const fn kind(self) -> Kind {
        match self {
            Value::Real(_) => Kind::Real,
            Value::LReal(_) => Kind::LReal,
            Value::Time(_) => Kind::Time,
            Value::Word(_) => Kind::Word,
            Value::Int(_) => Kind::Int,
            Value::Bool(_) => Kind::Bool,
            Value::Whole(kind, _) => kind,
        }
    }

    /// 0 or FALSE of a type.
    pub const fn zero(kind: Kind) -> Value {
        match kind {
            Kind::Real => Value::Real(0.0),
            Kind::LReal => Value::LReal(0.0),
            Kind::Time => Value::Time(Time::ZERO),
            Kind::Word => Value::Word(Word::new(0)),
            Kind::Int => Value::Int(0),
            Kind::Bool => Value::Bool(false),
            _ => Value::Whole(kind, 0),
        }
    }
}

/// A short run of a block that shows what it does: signals are set before given calls, and some are drawn.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// What the run shows, in one sentence.
    pub title: &'static str,
    /// How many calls it lasts.
    pub calls: u32,
    /// What is set: the number of the call before which, from 0 on (0 is before the restart), the variable, its value (a TIME
    /// in seconds, a BOOL as 0 or 1).
    pub set: &'static [(u32, &'static str, f64)],
    /// The variables that are drawn and recorded.
    pub show: &'static [&'static str],
}

impl Response {
    /// The block with its defaults, for 60 calls, with all inputs and outputs recorded.
    pub const AT_REST: Response = Response { title: "At rest, with all defaults", calls: 60, set: &[], show: &[] };
}

/// What a block does at each value of a variable: for each of `points` values, evenly spaced, a new block makes `calls` calls,
/// and the mean of each shown variable over these calls is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Characteristic {
    /// What it shows, in one sentence.
    pub title: &'static str,
    /// The variable of the horizontal axis, a number.
    pub variable: &'static str,
    /// Its lowest and its highest value.
    pub range: (f64, f64),
    /// How many values it takes, both ends included.
    pub points: u32,
    /// The calls for each value.
    pub calls: u32,
    /// What is set before the restart, as in a [`Response`].
    pub set: &'static [(&'static str, f64)],
    /// The variables that are drawn; a BOOL as the share of the calls in which it was TRUE, 0 ... 1.
    pub show: &'static [&'static str],
}
