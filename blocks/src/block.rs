//! What a block is: a table of variables, written once, and a law.
//!
//! [`block!`](crate::block!) turns the table into a struct and everything that can be computed from it ([`Block`]); the
//! law is written by hand ([`Law`]). Somebody who adds a block writes one file:
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

use crate::stored::Stored;
use crate::types::{Bool, Int, LReal, Real, Time, Word};

/// What a block does when it is called: the part of a block that is written by hand.
pub trait Law {
    /// What the documentation shows of the block and the reference results record.
    const RESPONSE: Response = Response::AT_REST;

    /// The complete restart, as a PLC makes it once at power up (OB 100), with the inputs and parameters as they are.
    fn restart(&mut self);

    /// One call, as a cyclic interrupt makes it: reads inputs and parameters, writes outputs and memory.
    fn call(&mut self);

    /// Refuses parameters with which the block cannot run; asked once, before the restart.
    ///
    /// # Errors
    /// A sentence that names the variable, its value and the remedy.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// The state of the actuating pulse: +1 positive or up, -1 negative or down, 0 none. Only for blocks with a `mean`
    /// row, which shows its mean over a communication step in percent.
    fn pulse(&self) -> i32 {
        0
    }
}

/// What [`block!`](crate::block!) makes of a table: its rows as data, and access to the values by row number.
pub trait Block: Law + Stored + Clone + Default + Send + 'static {
    /// The table as data.
    const TABLE: &'static Table;

    /// The time between two calls.
    fn cycle(&self) -> Time;

    /// The value in row `index`; `None` if there is no such row.
    fn get(&self, index: usize) -> Option<Value>;

    /// Writes row `index`, whatever its role; false, and nothing is changed, if there is no such row or `value` is of
    /// another type.
    fn set(&mut self, index: usize, value: Value) -> bool;

    /// Writes the `mean` row, if there is one.
    fn set_mean(&mut self, percent: LReal);
}

/// A block's table as data.
#[derive(Debug)]
pub struct Table {
    /// The block's name, such as `CONT_C`.
    pub name: &'static str,
    /// The block's documentation (Markdown); its first paragraph says what the block does.
    pub docs: &'static str,
    /// All variables: the block's own, then those of the blocks inside it, then the mean.
    pub rows: &'static [Row],
    /// The row that holds the time between two calls.
    pub cycle: usize,
    /// The row that holds the mean of the pulse, if there is one.
    pub mean: Option<usize>,
    /// Name and Rust type of each variable of the block's own memory, in the order in which it is stored.
    pub memory: &'static [(&'static str, &'static str)],
    /// The tables of the blocks inside it.
    pub instances: &'static [&'static Table],
    /// What the documentation shows of the block.
    pub response: Response,
}

impl Table {
    /// The row of the variable with this full name, such as `GAIN` or `DI_CONT_C.GAIN`.
    pub fn find(&self, full_name: &str) -> Option<usize> {
        self.rows.iter().position(|row| row.full_name() == full_name)
    }
}

/// How deep blocks may stand inside blocks.
pub const DEPTH: usize = 3;

/// One variable.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The instances that lead to it, outermost first; unused places are empty.
    pub path: [&'static str; DEPTH],
    /// Its name, in capitals.
    pub name: &'static str,
    /// A short text.
    pub description: &'static str,
    /// Its PLC type.
    pub kind: Kind,
    /// Who sets it, and when.
    pub role: Role,
    /// Its value in a new block.
    pub start: Value,
    /// The lowest value that makes sense. Nothing enforces it: the blocks check no parameter.
    pub min: Option<Value>,
    /// The highest value that makes sense; not enforced either.
    pub max: Option<Value>,
    /// Its unit, such as `%` or `degC`; a TIME has the unit second without saying so.
    pub unit: Option<&'static str>,
}

impl Row {
    /// A place in a table that is not filled yet.
    #[doc(hidden)]
    pub const EMPTY: Row = Row {
        path: [""; DEPTH],
        name: "",
        description: "",
        kind: Kind::Bool,
        role: Role::Local,
        start: Value::Bool(false),
        min: None,
        max: None,
        unit: None,
    };

    /// The name with the instances that lead to it: `GAIN`, `DI_CONT_C.GAIN`.
    pub fn full_name(&self) -> String {
        let mut name: String =
            self.path.iter().filter(|instance| !instance.is_empty()).flat_map(|i| [*i, "."]).collect();
        name.push_str(self.name);
        name
    }
}

/// The PLC type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 32-bit floating point.
    Real,
    /// 64-bit floating point.
    LReal,
    /// Milliseconds.
    Time,
    /// An analog value: 16 bits, two's complement.
    Word,
    /// A 16-bit integer.
    Int,
    /// One bit.
    Bool,
}

/// Who sets a variable, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A signal: what a process, an operator or another block changes while the loop runs.
    Input,
    /// A setting that may be tuned while the loop runs.
    Parameter,
    /// A setting that is fixed once the block runs.
    Fixed,
    /// The time between two calls: fixed too.
    Cycle,
    /// A result.
    Output,
    /// A signal inside the block that can be read but is none of its terminals.
    Local,
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
}

impl Value {
    /// 0 or FALSE of a type.
    pub const fn zero(kind: Kind) -> Value {
        match kind {
            Kind::Real => Value::Real(0.0),
            Kind::LReal => Value::LReal(0.0),
            Kind::Time => Value::Time(Time::ZERO),
            Kind::Word => Value::Word(Word::new(0)),
            Kind::Int => Value::Int(0),
            Kind::Bool => Value::Bool(false),
        }
    }
}

/// A short run of a block that shows what it does: signals are set before given calls, and some are drawn.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// What is to be seen, in one sentence.
    pub title: &'static str,
    /// How many calls it lasts.
    pub calls: u32,
    /// What is set: the number of the call before which (0 is before the restart), the variable, its value (a TIME in
    /// seconds, a BOOL as 0 or 1).
    pub set: &'static [(u32, &'static str, f64)],
    /// The variables that are drawn and recorded.
    pub show: &'static [&'static str],
}

impl Response {
    /// The block as it comes, for 60 calls, with all its inputs and outputs recorded.
    pub const AT_REST: Response = Response { title: "At rest, with all defaults", calls: 60, set: &[], show: &[] };
}

/// Makes a block of its table: the struct, its start values, the table as data and the access by row number.
///
/// ```text
/// block! {
///     /// What it does. The law. Clauses. Sources.
///     pub struct Name as "NAME" {
///         input | parameter | fixed | cycle | output | local {
///             /// Short text
///             name: Real | LReal | Time | Word | Int | Bool = start, min a, max b, unit "u";
///         }
///     }
///     mean { /// Short text
///            q_mean; }
///     instances { /// Short text
///                 di_name: Name { wired: a b; start: c = Bool(true); } }
///     memory Memory { /// Text
///                     name: Type; }
/// }
/// ```
///
/// The sections of variables may be repeated and stand in any order, so that the rows can keep the order of an instance
/// data block; start, `min`, `max` and `unit` may be left out. A table has one `cycle` row. `mean`, `instances` and
/// `memory` may be left out. Of an instance, `wired` names the terminals that the law connects: they become locals;
/// settings and open inputs become tunable parameters, outputs locals.
#[macro_export]
macro_rules! block {
    (
        $(#[doc = $docs:literal])*
        pub struct $Block:ident as $NAME:literal {
            $( $section:ident {
                $(
                    $(#[doc = $doc:literal])*
                    $name:ident: $kind:ident $(= $start:expr)? $(, min $min:expr)? $(, max $max:expr)? $(, unit $unit:literal)?;
                )*
            } )*
        }
        $( mean {
            $(#[doc = $mean_doc:literal])*
            $mean:ident;
        } )?
        $( instances { $(
            $(#[doc = $instance_doc:literal])*
            $instance:ident: $Instance:ty {
                wired: $($wired:ident)*;
                $( start: $($started:ident = $started_kind:ident($started_value:expr)),+; )?
            }
        )* } )?
        $( memory $Memory:ident { $(
            $(#[doc = $memory_doc:literal])*
            $memory:ident: $memory_type:ty;
        )* } )?
    ) => {
        $(#[doc = $docs])*
        #[derive(Clone, Debug)]
        pub struct $Block {
            $($(
                $(#[doc = $doc])*
                pub $name: $crate::$kind,
            )*)*
            $($(
                $(#[doc = $instance_doc])*
                pub $instance: $Instance,
            )*)?
            $(
                $(#[doc = $mean_doc])*
                pub $mean: $crate::LReal,
            )?
            $(
                /// What the block keeps from call to call.
                pub memory: $Memory,
            )?
        }

        $(
            #[doc = concat!("What `", $NAME, "` keeps from call to call.")]
            #[derive(Clone, Debug, Default)]
            pub struct $Memory { $(
                $(#[doc = $memory_doc])*
                pub $memory: $memory_type,
            )* }
        )?

        impl Default for $Block {
            fn default() -> Self {
                #[allow(unused_imports)]
                use $crate::{Time, Word};
                $Block {
                    $($( $name: $crate::block!(@start $kind $($start)?), )*)*
                    $($(
                        $instance: {
                            #[allow(unused_mut)]
                            let mut instance = <$Instance>::default();
                            $($( instance.$started = $started_value; )+)?
                            instance
                        },
                    )*)?
                    $( $mean: 0.0, )?
                    $( memory: $Memory::default(), )?
                }
            }
        }

        impl $Block {
            /// Outputs, locals and memory back to 0 / FALSE; the blocks inside are left alone.
            pub fn clear(&mut self) {
                $($( $crate::block!(@clear $section self.$name); )*)*
                $( self.$mean = 0.0; )?
                $( self.memory = $Memory::default(); )?
            }
        }

        const _: () = {
            #[allow(unused_imports)]
            use $crate::{Time, Word};
            use $crate::block::{Block, Kind, Law, Role, Row, Table, Value};

            const OWN: &[Row] = &[ $($( Row {
                path: [""; $crate::block::DEPTH],
                name: $crate::block!(@upper $name),
                description: $crate::block::trimmed(concat!($($doc),*)),
                kind: Kind::$kind,
                role: $crate::block!(@role $section),
                start: $crate::block!(@value $kind $($start)?),
                min: $crate::block!(@limit $kind $($min)?),
                max: $crate::block!(@limit $kind $($max)?),
                unit: $crate::block!(@unit $($unit)?),
            }, )*)* ];

            const MEAN: &[Row] = &[ $( Row {
                name: $crate::block!(@upper $mean),
                description: $crate::block::trimmed(concat!($($mean_doc),*)),
                kind: Kind::LReal,
                role: Role::Output,
                start: Value::LReal(0.0),
                unit: Some("%"),
                ..Row::EMPTY
            }, )? ];

            const INSTANCES: &[&Table] = &[ $($( <$Instance as Block>::TABLE, )*)? ];

            const COUNT: usize = OWN.len() + $crate::block::inner_rows(INSTANCES) + MEAN.len();

            #[allow(unused_assignments, unused_mut)]
            const ROWS: [Row; COUNT] = {
                let mut rows = [Row::EMPTY; COUNT];
                let mut next = $crate::block::copy(OWN, &mut rows, 0);
                $($(
                    next = $crate::block::nest(
                        $crate::block!(@upper $instance),
                        <$Instance as Block>::TABLE,
                        &[$( stringify!($wired) ),*],
                        &[$($( (stringify!($started), Value::$started_kind($started_value)) ),+)?],
                        &mut rows,
                        next,
                    );
                )*)?
                $crate::block::copy(MEAN, &mut rows, next);
                rows
            };

            const CYCLE: usize = $crate::block::cycle_row(&ROWS);

            /// The number of each own row, by the name of its field.
            #[allow(non_camel_case_types)]
            enum Number { $($( $name, )*)* }
            struct At;
            #[allow(non_upper_case_globals)]
            impl At { $($( const $name: usize = Number::$name as usize; )*)* }

            impl Block for $Block {
                const TABLE: &'static Table = &Table {
                    name: $NAME,
                    docs: concat!($($docs, "\n"),*),
                    rows: &ROWS,
                    cycle: CYCLE,
                    mean: if MEAN.is_empty() { None } else { Some(COUNT - 1) },
                    memory: &[ $($( (stringify!($memory), stringify!($memory_type)), )*)? ],
                    instances: INSTANCES,
                    response: <$Block as Law>::RESPONSE,
                };

                #[inline]
                fn cycle(&self) -> $crate::Time {
                    match self.get(CYCLE) {
                        Some(Value::Time(cycle)) => cycle,
                        _ => $crate::Time::ZERO,
                    }
                }

                #[inline]
                #[allow(unused_assignments)]
                fn get(&self, index: usize) -> Option<Value> {
                    match index {
                        $($( At::$name => Some(Value::$kind(self.$name)), )*)*
                        _ => {
                            #[allow(unused_mut, unused_variables)]
                            let mut index = index - OWN.len();
                            $($(
                                let rows = <$Instance as Block>::TABLE.inner();
                                if index < rows {
                                    return self.$instance.get(index);
                                }
                                index -= rows;
                            )*)?
                            $( if index == 0 {
                                return Some(Value::LReal(self.$mean));
                            } )?
                            None
                        }
                    }
                }

                #[inline(always)]
                #[allow(unused_assignments)]
                fn set(&mut self, index: usize, value: Value) -> bool {
                    match (index, value) {
                        $($( (At::$name, Value::$kind(value)) => self.$name = value, )*)*
                        _ => {
                            if index < OWN.len() {
                                return false;
                            }
                            #[allow(unused_mut, unused_variables)]
                            let mut index = index - OWN.len();
                            $($(
                                let rows = <$Instance as Block>::TABLE.inner();
                                if index < rows {
                                    return self.$instance.set(index, value);
                                }
                                index -= rows;
                            )*)?
                            $( if let (0, Value::LReal(value)) = (index, value) {
                                self.$mean = value;
                                return true;
                            } )?
                            return false;
                        }
                    }
                    true
                }

                #[inline]
                fn set_mean(&mut self, percent: $crate::LReal) {
                    let _ = percent;
                    $( self.$mean = percent; )?
                }
            }

            impl $crate::Stored for $Block {
                fn write(&self, bytes: &mut Vec<u8>) {
                    $($( self.$name.write(bytes); )*)*
                    $($( self.$instance.write(bytes); )*)?
                    $( self.$mean.write(bytes); )?
                    $($( self.memory.$memory.write(bytes); )*)?
                }

                fn read(bytes: &mut &[u8]) -> Option<Self> {
                    // The order of the fields is that of `write`: struct fields are evaluated as they are written.
                    Some($Block {
                        $($( $name: $crate::Stored::read(bytes)?, )*)*
                        $($( $instance: $crate::Stored::read(bytes)?, )*)?
                        $( $mean: $crate::Stored::read(bytes)?, )?
                        $( memory: $Memory { $( $memory: $crate::Stored::read(bytes)?, )* }, )?
                    })
                }
            }
        };
    };

    (@start $kind:ident) => { <$crate::$kind>::default() };
    (@start $kind:ident $start:expr) => { $start };
    (@value $kind:ident) => { Value::zero(Kind::$kind) };
    (@value $kind:ident $start:expr) => { Value::$kind($start) };
    (@limit $kind:ident) => { None };
    (@limit $kind:ident $limit:expr) => { Some(Value::$kind($limit)) };
    (@unit) => { None };
    (@unit $unit:literal) => { Some($unit) };
    (@role input) => { Role::Input };
    (@role parameter) => { Role::Parameter };
    (@role fixed) => { Role::Fixed };
    (@role cycle) => { Role::Cycle };
    (@role output) => { Role::Output };
    (@role local) => { Role::Local };
    (@role $other:ident) => {
        compile_error!(concat!(
            "unknown section `", stringify!($other), "`: use input, parameter, fixed, cycle, output or local"
        ))
    };
    (@clear output $field:expr) => { $field = Default::default() };
    (@clear local $field:expr) => { $field = Default::default() };
    (@clear $other:ident $field:expr) => {};
    (@upper $name:ident) => { {
        const UPPER: [u8; stringify!($name).len()] = $crate::block::upper(stringify!($name));
        $crate::block::text(&UPPER)
    } };
}

/// The parts of the macro that are plain functions, evaluated at compile time.
impl Table {
    /// How many rows the block has inside another: all but the mean, which belongs to a communication step.
    #[doc(hidden)]
    pub const fn inner(&self) -> usize {
        self.rows.len() - self.mean.is_some() as usize
    }
}

#[doc(hidden)]
pub const fn upper<const N: usize>(name: &str) -> [u8; N] {
    let mut bytes = [0; N];
    let mut i = 0;
    while i < N {
        bytes[i] = name.as_bytes()[i].to_ascii_uppercase();
        i += 1;
    }
    bytes
}

#[doc(hidden)]
pub const fn text(bytes: &[u8]) -> &str {
    match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(_) => panic!("a name is UTF-8"),
    }
}

#[doc(hidden)]
pub const fn trimmed(doc: &str) -> &str {
    text(doc.as_bytes().trim_ascii())
}

#[doc(hidden)]
pub const fn inner_rows(instances: &[&Table]) -> usize {
    let mut rows = 0;
    let mut i = 0;
    while i < instances.len() {
        rows += instances[i].inner();
        i += 1;
    }
    rows
}

#[doc(hidden)]
pub const fn copy(from: &[Row], to: &mut [Row], mut next: usize) -> usize {
    let mut i = 0;
    while i < from.len() {
        to[next] = from[i];
        next += 1;
        i += 1;
    }
    next
}

/// Copies the rows of a block inside another, with their place, role and start there.
#[doc(hidden)]
pub const fn nest(
    instance: &'static str,
    table: &Table,
    wired: &[&str],
    starts: &[(&str, Value)],
    to: &mut [Row],
    mut next: usize,
) -> usize {
    let mut found = 0;
    let mut i = 0;
    while i < table.inner() {
        let mut row = table.rows[i];
        let is_own = row.path[0].is_empty();
        assert!(row.path[DEPTH - 1].is_empty(), "blocks stand too deep inside blocks");
        let mut depth = DEPTH - 1;
        while depth > 0 {
            row.path[depth] = row.path[depth - 1];
            depth -= 1;
        }
        row.path[0] = instance;
        row.role = match row.role {
            Role::Input => Role::Parameter,
            Role::Cycle => Role::Fixed,
            Role::Output => Role::Local,
            other => other,
        };
        let mut w = 0;
        while is_own && w < wired.len() {
            if row.name.eq_ignore_ascii_case(wired[w]) {
                row.role = Role::Local;
                found += 1;
            }
            w += 1;
        }
        let mut s = 0;
        while is_own && s < starts.len() {
            if row.name.eq_ignore_ascii_case(starts[s].0) {
                row.start = starts[s].1;
                found += 1;
            }
            s += 1;
        }
        to[next] = row;
        next += 1;
        i += 1;
    }
    assert!(found == wired.len() + starts.len(), "`wired` or `start` names no terminal of the block inside");
    next
}

#[doc(hidden)]
pub const fn cycle_row(rows: &[Row]) -> usize {
    let mut cycle = None;
    let mut i = 0;
    while i < rows.len() {
        if matches!(rows[i].role, Role::Cycle) {
            assert!(cycle.is_none(), "a table has one `cycle` row, not two");
            assert!(matches!(rows[i].kind, Kind::Time), "the `cycle` row is a Time");
            cycle = Some(i);
        }
        i += 1;
    }
    match cycle {
        Some(i) => i,
        None => panic!("a table needs a `cycle` row: the time between two calls"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::block! {
        /// Adds two words.
        ///
        /// More about it.
        pub struct Inner as "INNER" {
            input {
                /// First word
                first: Word = Word::new(3);
                /// Second word
                second: Word;
            }
            cycle {
                /// Time between calls
                cycle: Time = Time::ms(20);
            }
            fixed {
                /// Cannot be tuned
                order: Int = 2, min 1, max 9;
            }
            output {
                /// Sum
                sum: Int;
            }
        }
        mean {
            /// Mean of the pulse
            inner_mean;
        }
        memory InnerMemory {
            /// Calls since the restart.
            calls: u32;
        }
    }

    impl Law for Inner {
        fn restart(&mut self) {
            self.clear();
        }

        fn call(&mut self) {
            self.memory.calls += 1;
            self.sum = self.first.value() + self.second.value();
        }
    }

    crate::block! {
        /// Has one of everything.
        pub struct Outer as "OUTER" {
            parameter {
                /// A number
                gain: Real = 1.5, min 0.0, max 10.0, unit "degC";
            }
            cycle {
                /// Time between calls
                cycle: Time = Time::ms(10), min Time::ms(1);
            }
            output {
                /// A wide number
                state: LReal;
                /// A bit
                q: Bool;
            }
            local {
                /// In between
                between: Real;
            }
        }
        mean {
            /// Mean of the pulse
            outer_mean;
        }
        instances {
            /// One of two.
            di_a: Inner {
                wired: first cycle;
                start: second = Word(Word::new(7)), order = Int(4);
            }
            /// The other.
            di_b: Inner {
                wired: ;
            }
        }
        memory OuterMemory {
            /// A flag.
            started: bool;
            /// A table.
            history: [i16; 2];
        }
    }

    impl Law for Outer {
        fn restart(&mut self) {
            self.clear();
        }

        fn call(&mut self) {
            self.memory.started = true;
            self.di_a.call();
            self.di_b.call();
        }
    }

    crate::block! {
        /// Holds a block that holds blocks.
        pub struct Outermost as "OUTERMOST" {
            cycle {
                /// Time between calls
                cycle: Time = Time::ms(10);
            }
        }
        instances {
            /// Two levels.
            di_outer: Outer {
                wired: cycle;
                start: gain = Real(2.5);
            }
        }
    }

    impl Law for Outermost {
        fn restart(&mut self) {
            self.clear();
        }

        fn call(&mut self) {
            self.di_outer.call();
        }
    }

    fn row(name: &str) -> usize {
        Outer::TABLE.find(name).unwrap_or_else(|| panic!("no row {name}"))
    }

    #[test]
    fn rows_stand_in_the_order_of_the_table_then_the_instances_then_the_mean() {
        let names: Vec<_> = Outer::TABLE.rows.iter().map(Row::full_name).collect();
        let own = ["GAIN", "CYCLE", "STATE", "Q", "BETWEEN"];
        let inner = ["FIRST", "SECOND", "CYCLE", "ORDER", "SUM"];
        let mut expected: Vec<_> = own.map(String::from).to_vec();
        expected.extend(inner.map(|name| format!("DI_A.{name}")));
        expected.extend(inner.map(|name| format!("DI_B.{name}")));
        expected.push("OUTER_MEAN".into());
        assert_eq!(names, expected);
    }

    #[test]
    fn a_row_says_what_the_table_says() {
        let row = &Outer::TABLE.rows[row("GAIN")];
        assert_eq!((row.description, row.kind, row.role), ("A number", Kind::Real, Role::Parameter));
        assert_eq!((row.start, row.min, row.max), (Value::Real(1.5), Some(Value::Real(0.0)), Some(Value::Real(10.0))));
        assert_eq!(row.unit, Some("degC"));
    }

    #[test]
    fn what_a_table_leaves_out_is_0_or_nothing() {
        let row = &Outer::TABLE.rows[row("Q")];
        assert_eq!((row.start, row.min, row.max, row.unit), (Value::Bool(false), None, None, None));
    }

    #[test]
    fn the_table_has_name_docs_cycle_mean_memory_and_instances() {
        let table = Outer::TABLE;
        assert_eq!((table.name, table.docs), ("OUTER", " Has one of everything.\n"));
        assert_eq!((table.cycle, table.mean), (row("CYCLE"), Some(table.rows.len() - 1)));
        assert_eq!(table.memory, [("started", "bool"), ("history", "[i16; 2]")]);
        assert_eq!(table.instances.iter().map(|inner| inner.name).collect::<Vec<_>>(), ["INNER", "INNER"]);
        assert_eq!(Inner::TABLE.docs, " Adds two words.\n\n More about it.\n");
    }

    #[test]
    fn the_mean_row_is_an_output_in_percent() {
        let row = &Outer::TABLE.rows[row("OUTER_MEAN")];
        assert_eq!((row.kind, row.role, row.unit), (Kind::LReal, Role::Output, Some("%")));
    }

    #[test]
    fn inside_another_block_inputs_become_parameters_outputs_locals_and_the_cycle_fixed() {
        let role = |name| Outer::TABLE.rows[row(name)].role;
        assert_eq!(role("DI_B.FIRST"), Role::Parameter);
        assert_eq!(role("DI_B.CYCLE"), Role::Fixed);
        assert_eq!(role("DI_B.ORDER"), Role::Fixed);
        assert_eq!(role("DI_B.SUM"), Role::Local);
        assert_eq!(role("DI_A.SECOND"), Role::Parameter);
        assert_eq!([role("DI_A.FIRST"), role("DI_A.CYCLE")], [Role::Local; 2]);
    }

    #[test]
    fn inside_another_block_a_start_value_may_be_another() {
        let start = |name| Outer::TABLE.rows[row(name)].start;
        assert_eq!((start("DI_A.SECOND"), start("DI_A.ORDER")), (Value::Word(Word::new(7)), Value::Int(4)));
        assert_eq!((start("DI_B.SECOND"), start("DI_B.ORDER")), (Value::Word(Word::new(0)), Value::Int(2)));
    }

    #[test]
    fn instances_inside_instances_keep_their_path_role_and_values() {
        let find = |name| Outermost::TABLE.find(name).unwrap_or_else(|| panic!("no row {name}"));
        let role = |name| Outermost::TABLE.rows[find(name)].role;
        assert_eq!(Outermost::TABLE.rows.len(), 1 + 5 + 2 * 5);
        assert_eq!(Outermost::TABLE.rows[find("DI_OUTER.DI_B.SECOND")].path, ["DI_OUTER", "DI_B", ""]);
        // `wired` means the terminal of the block itself, not one of the same name further in.
        assert_eq!((role("DI_OUTER.CYCLE"), role("DI_OUTER.DI_B.CYCLE")), (Role::Local, Role::Fixed));
        assert_eq!((role("DI_OUTER.DI_A.SECOND"), role("DI_OUTER.DI_A.FIRST")), (Role::Parameter, Role::Local));

        let mut block = Outermost::default();
        assert_eq!(block.get(find("DI_OUTER.GAIN")), Some(Value::Real(2.5)));
        assert_eq!(block.get(find("DI_OUTER.DI_A.SECOND")), Some(Value::Word(Word::new(7))));
        assert!(block.set(find("DI_OUTER.DI_B.FIRST"), Value::Word(Word::new(40))));
        block.call();
        assert_eq!(block.get(find("DI_OUTER.DI_B.SUM")), Some(Value::Int(40)));
    }

    #[test]
    fn a_new_block_holds_the_start_values_of_its_table() {
        let block = Outer::default();
        for (index, row) in Outer::TABLE.rows.iter().enumerate() {
            assert_eq!(block.get(index), Some(row.start), "{}", row.full_name());
        }
    }

    #[test]
    fn every_row_can_be_written_and_read_back_and_changes_no_other() {
        let other = |kind| match kind {
            Kind::Real => Value::Real(-2.5),
            Kind::LReal => Value::LReal(-3.5),
            Kind::Time => Value::Time(Time::ms(1234)),
            Kind::Word => Value::Word(Word::new(-99)),
            Kind::Int => Value::Int(-77),
            Kind::Bool => Value::Bool(true),
        };
        for (index, row) in Outer::TABLE.rows.iter().enumerate() {
            let mut block = Outer::default();
            assert!(block.set(index, other(row.kind)));
            for (read, row) in Outer::TABLE.rows.iter().enumerate() {
                let expected = if read == index { other(row.kind) } else { row.start };
                assert_eq!(block.get(read), Some(expected), "{} after setting row {index}", row.full_name());
            }
        }
    }

    #[test]
    fn a_value_of_another_type_or_a_row_that_is_none_is_refused_and_changes_nothing() {
        let mut block = Outer::default();
        let before = format!("{block:?}");
        let rows = Outer::TABLE.rows.len();
        for (index, row) in Outer::TABLE.rows.iter().enumerate() {
            let wrong = if row.kind == Kind::Bool { Value::Int(1) } else { Value::Bool(true) };
            assert!(!block.set(index, wrong), "{}", row.full_name());
        }
        assert!(!block.set(rows, Value::LReal(1.0)));
        assert!(!block.set(usize::MAX, Value::LReal(1.0)));
        assert_eq!((block.get(rows), block.get(usize::MAX)), (None, None));
        assert_eq!(format!("{block:?}"), before);
    }

    #[test]
    fn the_mean_can_be_written() {
        let mut block = Outer::default();
        block.set_mean(12.5);
        assert_eq!(block.get(row("OUTER_MEAN")), Some(Value::LReal(12.5)));
    }

    #[test]
    fn the_cycle_is_the_value_of_its_row() {
        let mut block = Outer::default();
        assert_eq!(block.cycle(), Time::ms(10));
        block.set(Outer::TABLE.cycle, Value::Time(Time::ms(35)));
        assert_eq!(block.cycle(), Time::ms(35));
    }

    #[test]
    fn clear_takes_outputs_locals_mean_and_memory_back_and_leaves_settings_and_instances() {
        let mut block = Outer { gain: 2.0, state: 1.0, q: true, between: 3.0, outer_mean: 4.0, ..Outer::default() };
        block.call();
        block.memory.history = [1, 2];
        block.clear();
        assert_eq!((block.state, block.q, block.between, block.outer_mean), (0.0, false, 0.0, 0.0));
        assert_eq!((block.memory.started, block.memory.history), (false, [0, 0]));
        assert_eq!((block.gain, block.di_a.sum, block.di_a.memory.calls), (2.0, 10, 1));
    }

    #[test]
    fn a_stored_block_comes_back_with_instances_mean_and_memory() {
        let mut block = Outer { gain: 2.0, outer_mean: -4.0, ..Outer::default() };
        block.di_b.inner_mean = 9.0;
        block.memory.history = [1, -2];
        block.call();
        let mut bytes = Vec::new();
        block.write(&mut bytes);
        let mut rest = &bytes[..];
        let read = Outer::read(&mut rest).unwrap();
        assert_eq!((format!("{read:?}"), rest.len()), (format!("{block:?}"), 0));
        assert!(Outer::read(&mut &bytes[..bytes.len() - 1]).is_none());
    }

    #[test]
    fn find_knows_full_names_only() {
        assert_eq!(Outer::TABLE.find("DI_A.SUM"), Some(9));
        assert_eq!((Outer::TABLE.find("SUM"), Outer::TABLE.find("gain")), (None, None));
    }

    #[test]
    fn a_block_that_says_nothing_of_them_accepts_its_parameters_and_has_no_pulse() {
        assert_eq!((Outer::default().check(), Outer::default().pulse()), (Ok(()), 0));
    }
}
