//! A block: a table of variables, written once, and a law.
//!
//! [`block!`](crate::block!) turns the table into a struct and everything that can be derived from it ([`Block`]); the
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

/// Defines an enum in which each variant has one name, used everywhere.
macro_rules! named {
    ($(#[$attribute:meta])* $Enum:ident { $( $(#[doc = $doc:literal])* $Value:ident $name:literal; )* }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $Enum { $( $(#[doc = $doc])* $Value, )* }

        impl $Enum {
            /// All variants.
            pub const ALL: &'static [$Enum] = &[$($Enum::$Value),*];

            /// Returns the name used in tables, documentation and messages.
            pub const fn name(self) -> &'static str {
                match self { $( $Enum::$Value => $name, )* }
            }

            /// Returns the variant with this name.
            pub fn named(name: &str) -> Option<$Enum> {
                $Enum::ALL.iter().copied().find(|value| value.name() == name)
            }
        }
    };
}
use std::fmt::{Debug, Display};
use std::ops::Deref;

pub mod abreast;
pub mod arrays;
mod block;
#[doc(hidden)]
pub mod docs;
pub mod fingerprint;
mod host;
mod kind;
pub mod number;
mod owned;
mod parts;
pub mod start;
mod stored;
#[cfg(test)]
mod tests;
mod types;

pub use host::Types;
pub use kind::{Class, Form, Kind};
#[doc(hidden)]
pub use parts::{
    check_restart_values, copy, cycle_row, help, inner_names, inner_rows, length, nest, short_text, text, tunable,
    upper,
};
pub use stored::Stored;
pub use types::{Bool, Int, LReal, Real, Time, Word, low_word, rnd};

/// The hand-written part of a block: its behaviour when it is called.
pub trait Law {
    /// The runs shown in the documentation. The FMU's reference results are a recording of the first one.
    const RESPONSES: &'static [Response] = &[Response::AT_REST];

    /// The characteristics shown in the documentation.
    const CHARACTERISTICS: &'static [Characteristic] = &[];

    /// The default unit of signals in the documentation's drawings. A controller works in any unit; with its start
    /// values, the unit is percent.
    const DRAWN_UNIT: Option<&'static str> = None;

    /// Whether a call computes the effect of inputs held until the next call, as in a plant: the outputs are then those
    /// at the next call, and nothing happens at the instant of the call itself. A controller responds immediately.
    const HOLDS_INPUTS: bool = false;

    /// Performs the complete restart, which a PLC runs once at power-up (OB 100), with the current inputs and
    /// parameters.
    fn restart(&mut self);

    /// Performs one call, as in a cyclic interrupt: reads inputs and parameters, writes outputs and memory.
    fn call(&mut self);

    /// Rejects parameters with which the block cannot run; called before each restart.
    ///
    /// # Errors
    /// A sentence that names the variable, its value and the remedy.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// Returns sentences, with names and numbers, about unexpected behaviour with the current settings.
    fn advice(&self) -> Vec<String> {
        Vec::new()
    }

    /// Returns the state of the actuating pulse: +1 positive or up, -1 negative or down, 0 none. Only for blocks with a
    /// `mean` row, which contains its mean over a communication step in percent.
    fn pulse(&self) -> i32 {
        0
    }
}

/// The implementation generated from a table by [`block!`](crate::block!): its rows as data, and access to the values
/// by row number.
pub trait Block: Law + Stored + Clone + Default + Send + 'static {
    /// The table as data.
    const TABLE: &'static StaticTable;

    /// A hash of the sources of the crate that defines the block, see [`CODE`](crate::CODE).
    const CODE: Option<&'static str>;

    /// Returns the time between two calls.
    fn cycle(&self) -> Time;

    /// Returns the value in row `index`; `None` if there is no such row.
    fn get(&self, index: usize) -> Option<Value>;

    /// Writes row `index`, whatever its role. Returns false, with nothing changed, if there is no such row or `value`
    /// has a different type.
    fn set(&mut self, index: usize, value: Value) -> bool;

    /// Returns the REAL in row `index`, like [`Block::get`] but in fewer instructions; `None` if the row is not a REAL.
    fn real(&self, index: usize) -> Option<Real>;

    /// Returns a reference to the REAL in row `index`, whatever its role, for writing in fewer instructions than
    /// [`Block::set`]; `None` if the row is not a REAL.
    fn real_mut(&mut self, index: usize) -> Option<&mut Real>;

    /// Returns the LREAL in row `index`, like [`Block::real`].
    fn lreal(&self, index: usize) -> Option<LReal>;

    /// Returns a reference to the LREAL in row `index`, like [`Block::real_mut`].
    fn lreal_mut(&mut self, index: usize) -> Option<&mut LReal>;

    /// Writes the `mean` row, if there is one.
    fn set_mean(&mut self, percent: LReal);
}

/// The string type of a table: `&'static str` in a compiled table, `String` in one created at run time. Its lists are
/// slices or vectors accordingly.
pub trait TableText:
    Deref<Target = str> + From<&'static str> + Clone + Debug + Display + PartialEq + Send + Sync + 'static
{
    /// A list.
    type List<T: Clone + Debug + PartialEq + Send + Sync + 'static>: Deref<Target = [T]>
        + Clone
        + Debug
        + Default
        + PartialEq
        + Send
        + Sync;
}

impl TableText for &'static str {
    type List<T: Clone + Debug + PartialEq + Send + Sync + 'static> = &'static [T];
}

impl TableText for String {
    type List<T: Clone + Debug + PartialEq + Send + Sync + 'static> = Vec<T>;
}

/// The table of a compiled block.
pub type StaticTable = Table<&'static str>;

/// A row of a [`StaticTable`].
pub type StaticRow = Row<&'static str>;

/// A block's table as data.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<S: TableText = String> {
    /// The block's name, such as `CONT_C`.
    pub name: S,
    /// Other names for the block in a PLC project, such as `FB 41`.
    pub aliases: S::List<S>,
    /// The block's documentation (Markdown); its first paragraph summarizes the block.
    pub docs: S,
    /// All variables: the block's own, then those of its inner blocks, then the mean.
    pub rows: S::List<Row<S>>,
    /// The string variables of a program; empty for a block. Their value references follow those of the rows.
    pub texts: S::List<Text<S>>,
    /// For each row, whether it is a REAL that may be set at any time. Precomputed, because no other check is made as
    /// often for a host.
    pub tunable_reals: S::List<bool>,
    /// For each row, whether it is an LREAL that may be set at any time.
    pub tunable_lreals: S::List<bool>,
    /// The index of the row with the time between two calls.
    pub cycle: usize,
    /// The index of the row with the mean of the pulse, if there is one.
    pub mean: Option<usize>,
    /// The name and Rust type of each variable in the block's memory, in storage order.
    pub memory: S::List<(S, S)>,
    /// The tables of the inner blocks.
    pub instances: &'static [&'static StaticTable],
    /// The runs shown in the documentation, at least one.
    pub responses: S::List<Response<S>>,
    /// The characteristics shown in the documentation.
    pub characteristics: S::List<Characteristic<S>>,
    /// The default unit of signals in these drawings.
    pub drawn_unit: Option<S>,
}

impl<S: TableText> Table<S> {
    /// Returns the index of the row with this name, such as `GAIN` or `DI_CONT_C.GAIN`.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.rows.iter().position(|row| &*row.name == name)
    }

    /// Returns the indices of the rows with these names.
    pub fn find_all(&self, names: &[S]) -> Vec<usize> {
        names.iter().filter_map(|name| self.find(name)).collect()
    }

    /// Returns the indices of the rows drawn for a response: all inputs and outputs if it names none.
    pub fn shown(&self, response: &Response<S>) -> Vec<usize> {
        let is_terminal = |row: &usize| matches!(self.rows[*row].role, Role::Input | Role::Output);
        match &*response.show {
            [] => (0..self.rows.len()).filter(is_terminal).collect(),
            names => self.find_all(names),
        }
    }

    /// Returns a summary in one sentence: the first paragraph of the documentation, on one line.
    pub fn summary(&self) -> String {
        let lines = self.docs.lines().map(str::trim).skip_while(|line| line.is_empty());
        lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

/// A string visible to a host: a STRING or WSTRING of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct Text<S: TableText = String> {
    /// The full name, including the instances that contain it.
    pub name: S,
    /// A one-line description.
    pub description: S,
    /// The role: who sets it, and when.
    pub role: Role,
    /// The value in a new program.
    pub start: S,
    /// Its type.
    pub ty: TextType,
}

/// The type of a string.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextType {
    /// The maximum number of characters.
    pub most: u16,
    /// Whether it is a WSTRING, with UTF-16 code units, rather than a STRING, with one byte per character (ISO 8859-1).
    pub is_wide: bool,
}

impl TextType {
    /// Returns the type name with the length, such as `STRING[20]`.
    pub fn name(self) -> String {
        format!("{}[{}]", if self.is_wide { "WSTRING" } else { "STRING" }, self.most)
    }

    /// Returns the type with this name.
    pub fn named(name: &str) -> Option<TextType> {
        let (name, most) = name.strip_suffix(']')?.split_once('[')?;
        let is_wide = name == "WSTRING";
        (is_wide || name == "STRING").then_some(TextType { most: most.parse().ok()?, is_wide })
    }

    /// Encodes a string as the PLC does.
    ///
    /// # Errors
    /// It is longer than the variable, or contains a character that a STRING cannot represent.
    pub fn units(self, text: &str) -> Result<Vec<u16>, String> {
        let units: Vec<u16> = text.encode_utf16().collect();
        if units.len() > self.most.into() {
            return Err(format!("{} holds at most {} characters, not {}", self.name(), self.most, units.len()));
        }
        match text.chars().find(|character| !self.is_wide && u32::from(*character) > 0xFF) {
            Some(other) => Err(format!("a STRING holds only ISO 8859-1 characters, and {other:?} is not one of them")),
            None => Ok(units),
        }
    }
}

/// A variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<S: TableText = String> {
    /// The name in upper case, preceded by the names of the instances that contain it: `GAIN`, `DI_CONT_C.GAIN`.
    pub name: S,
    /// A one-line description.
    pub description: S,
    /// The help for users (Markdown): what the variable acts on, what happens at the edges, how to choose it. May be
    /// empty.
    pub help: S,
    /// Its PLC type.
    pub kind: Kind,
    /// For a WORD, whether it is an analog value (a signed number), as in a block, rather than a bit string, as in a
    /// program.
    pub is_analog: bool,
    /// The role: who sets the variable, and when.
    pub role: Role,
    /// The value in a new block.
    pub start: Value,
    /// The lowest sensible value. Not enforced, except for the few settings that [`Law::check`] or a host's restart
    /// rejects.
    pub min: Option<Value>,
    /// The highest sensible value; likewise not enforced.
    pub max: Option<Value>,
    /// The unit, such as `%` or `degC`; `None` for a TIME, which is in seconds.
    pub unit: Option<S>,
    /// For an output, the indices of the settings on which its value after a restart depends.
    pub from: S::List<usize>,
}

impl StaticRow {
    /// An unfilled element of a table.
    #[doc(hidden)]
    pub const EMPTY: StaticRow = StaticRow {
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
}

impl<S: TableText> Row<S> {
    /// A variable without a description, range or unit; it has the type of the start value.
    pub fn new(name: impl Into<S>, role: Role, start: Value) -> Row<S> {
        Row {
            name: name.into(),
            description: "".into(),
            help: "".into(),
            kind: start.kind(),
            is_analog: false,
            role,
            start,
            min: None,
            max: None,
            unit: None,
            from: Default::default(),
        }
    }

    /// Returns the start value as a number: a TIME in seconds, TRUE as 1.
    pub fn start(&self) -> f64 {
        number::number(self.start)
    }

    /// Returns the unit in which people and hosts read its values: seconds for a duration, otherwise its own.
    pub fn shown_unit(&self) -> Option<&str> {
        self.kind.shown_unit(self.unit.as_deref())
    }

    /// Returns the lowest sensible value as a number. It exceeds neither the REAL nor its decimal form, so that neither
    /// a host that computes in doubles nor the REAL itself falls below it.
    pub fn least(&self) -> Option<f64> {
        self.min.map(|min| number::number(min).min(number::decimal(min)))
    }

    /// Returns the highest sensible value as a number, which falls below neither the REAL nor its decimal form.
    pub fn greatest(&self) -> Option<f64> {
        self.max.map(|max| number::number(max).max(number::decimal(max)))
    }

    /// Whether the variable belongs to an inner block.
    pub fn is_inner(&self) -> bool {
        self.name.contains('.')
    }
}

named! {
    /// Who sets a variable, and when: the sections of [`block!`](crate::block!).
    Role {
        /// A signal that a process, an operator or another block changes while the loop runs.
        Input "input";
        /// A setting that may be tuned while the loop runs.
        Parameter "parameter";
        /// A setting that is fixed once the block runs.
        Fixed "fixed";
        /// The time between two calls; also fixed.
        Cycle "cycle";
        /// A result.
        Output "output";
        /// A signal inside the block, which can be read but is not one of its terminals.
        Local "local";
    }
}

impl Role {
    /// Whether a host may set the variable, at least before the block runs.
    pub const fn is_settable(self) -> bool {
        !matches!(self, Role::Output | Role::Local)
    }
}

/// A value with its PLC type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A 32-bit floating-point number.
    Real(Real),
    /// A 64-bit floating-point number.
    LReal(LReal),
    /// A duration in milliseconds.
    Time(Time),
    /// An analog value.
    Word(Word),
    /// A 16-bit integer.
    Int(Int),
    /// A bit.
    Bool(Bool),
    /// An integer of a type that exists only in programs, see [`Kind::whole`]; an unsigned 64-bit integer is stored as
    /// its bits.
    Whole(Kind, i64),
}

impl Value {
    /// Returns the PLC type of the value.
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

    /// Returns the 0 or FALSE of a type.
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

/// A short run that demonstrates a block: signals are set before given calls, and some are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response<S: TableText = &'static str> {
    /// The title: one sentence about what the run shows.
    pub title: S,
    /// The number of calls.
    pub calls: u32,
    /// The settings during the run: the number of the call before which a variable is set (0 is before the restart),
    /// the variable, and its value (a TIME in seconds, a BOOL as 0 or 1).
    pub set: S::List<(u32, S, f64)>,
    /// The variables that are drawn and recorded.
    pub show: S::List<S>,
}

impl Response {
    /// A run of the block with its defaults for 60 calls, with all inputs and outputs recorded.
    pub const AT_REST: Response = Response { title: "At rest, with all defaults", calls: 60, set: &[], show: &[] };
}

/// A characteristic of a block as a function of a variable: for each of `points` evenly spaced values, a new block
/// makes `calls` calls, and the mean of each shown variable over these calls is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Characteristic<S: TableText = &'static str> {
    /// The title: one sentence about what the characteristic shows.
    pub title: S,
    /// The variable on the horizontal axis, a number.
    pub variable: S,
    /// The lowest and highest value of the variable.
    pub range: (f64, f64),
    /// The number of values, including both ends.
    pub points: u32,
    /// The number of calls for each value.
    pub calls: u32,
    /// The settings before the restart, as in a [`Response`].
    pub set: S::List<(S, f64)>,
    /// The variables drawn; a BOOL is drawn as the fraction of the calls in which it was TRUE, 0 ... 1.
    pub show: S::List<S>,
}
