//! The types of SCL.

use crate::ir::extent;
use crate::ir::{self, Scalar};
use std::collections::HashMap;
use std::fmt;
use std::rc::Rc;

macro_rules! elementary {
    ($($Name:ident $name:literal $Scalar:ident $class:ident;)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)]
        pub enum Elementary { $($Name,)* }

        impl Elementary {
            pub const ALL: &'static [Elementary] = &[$(Elementary::$Name),*];

            pub const fn name(self) -> &'static str {
                match self { $(Elementary::$Name => $name,)* }
            }

            /// The scalar that represents it in the program.
            pub const fn scalar(self) -> Scalar {
                match self { $(Elementary::$Name => Scalar::$Scalar,)* }
            }

            pub const fn class(self) -> Class {
                match self { $(Elementary::$Name => Class::$class,)* }
            }
        }
    };
}

/// A class of elementary types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    Bool,
    /// A bit string of more than one bit.
    Bits,
    Integer,
    /// A floating-point number.
    Real,
    /// A duration.
    Time,
    Character,
    /// A date or a time of day.
    Date,
}

elementary! {
    Bool "BOOL" Bool Bool;
    Byte "BYTE" U8 Bits;
    Word "WORD" U16 Bits;
    DWord "DWORD" U32 Bits;
    LWord "LWORD" U64 Bits;
    SInt "SINT" I8 Integer;
    Int "INT" I16 Integer;
    DInt "DINT" I32 Integer;
    LInt "LINT" I64 Integer;
    USInt "USINT" U8 Integer;
    UInt "UINT" U16 Integer;
    UDInt "UDINT" U32 Integer;
    ULInt "ULINT" U64 Integer;
    Real "REAL" F32 Real;
    LReal "LREAL" F64 Real;
    Time "TIME" I32 Time;
    LTime "LTIME" I64 Time;
    Char "CHAR" U8 Character;
    WChar "WCHAR" U16 Character;
    Date "DATE" U16 Date;
    Tod "TOD" U32 Date;
    LTod "LTOD" U64 Date;
    Ldt "LDT" I64 Date;
    Dt "DATE_AND_TIME" I64 Date;
}

impl Elementary {
    /// The elementary type with this upper-case name.
    pub fn named(name: &str) -> Option<Elementary> {
        match name {
            "TIME_OF_DAY" => Some(Elementary::Tod),
            "LTIME_OF_DAY" => Some(Elementary::LTod),
            "DT" => Some(Elementary::Dt),
            _ => Elementary::ALL.iter().copied().find(|elementary| elementary.name() == name),
        }
    }

    /// Whether it is an integer or a bit string, as required of indices, selectors and slices.
    pub fn is_whole(self) -> bool {
        matches!(self.class(), Class::Bits | Class::Integer)
    }

    /// Whether it is an integer, a bit string or a floating-point number.
    pub fn is_number(self) -> bool {
        self.is_whole() || self.class() == Class::Real
    }

    /// Its size in bits.
    pub fn bits(self) -> u32 {
        if self == Elementary::Bool { 1 } else { self.scalar().size() as u32 * 8 }
    }

    /// The bit string with this number of bits.
    pub fn bit_string(bits: u32) -> Elementary {
        match bits {
            1 => Elementary::Bool,
            8 => Elementary::Byte,
            16 => Elementary::Word,
            32 => Elementary::DWord,
            _ => Elementary::LWord,
        }
    }

    /// The integer type with this number of bits.
    pub fn integer(bits: u32, is_signed: bool) -> Elementary {
        match (bits, is_signed) {
            (8, true) => Elementary::SInt,
            (16, true) => Elementary::Int,
            (32, true) => Elementary::DInt,
            (_, true) => Elementary::LInt,
            (8, false) => Elementary::USInt,
            (16, false) => Elementary::UInt,
            (32, false) => Elementary::UDInt,
            (_, false) => Elementary::ULInt,
        }
    }

    /// The lowest and highest value of an integer or bit string.
    pub fn range(self) -> (i128, i128) {
        let bits = self.bits();
        if self.scalar().is_signed() { (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) } else { (0, (1 << bits) - 1) }
    }

    /// The common type in which values of two types are computed or compared, if any.
    pub fn common(self, other: Elementary) -> Option<Elementary> {
        use Class::{Bits, Integer, Real};
        if self == other {
            return Some(self);
        }
        match (self.class(), other.class()) {
            (Real, Real) => Some(Elementary::LReal),
            (Real, Bits | Integer) => Some(self),
            (Bits | Integer, Real) => Some(other),
            (Bits, Bits) => Some(Elementary::bit_string(self.bits().max(other.bits()))),
            (Bits | Integer, Bits | Integer) => {
                let (signed, unsigned) = if self.scalar().is_signed() { (self, other) } else { (other, self) };
                let bits = match (signed.scalar().is_signed(), unsigned.scalar().is_signed()) {
                    (true, false) if signed.bits() <= unsigned.bits() => unsigned.bits() * 2,
                    _ => self.bits().max(other.bits()),
                };
                Some(Elementary::integer(bits.min(64), signed.scalar().is_signed()))
            }
            (Class::Time, Class::Time) => Some(Elementary::LTime),
            (Class::Character, Class::Character) => Some(Elementary::WChar),
            _ => None,
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub enum Type {
    Elementary(Elementary),
    Text {
        /// The maximum number of characters.
        capacity: u16,
        /// Whether characters have 16 bits.
        wide: bool,
    },
    Array(Rc<Array>),
    /// `ARRAY[*]`: the element type and the number of dimensions.
    Open(Rc<Type>, usize),
    Structure(Rc<Structure>),
    /// A function block instance: the index of the block.
    Instance(usize),
    /// The type of a function without a return value.
    Void,
    /// An undeclared type, by its lookup key.
    Missing(Rc<str>),
    /// A type already reported as an error.
    Wrong,
}

#[derive(Debug, PartialEq)]
pub struct Array {
    /// The lower and upper bound of each dimension.
    pub bounds: Vec<(i32, i32)>,
    /// The type of its elements.
    pub of: Type,
}

impl Array {
    pub fn elements(&self) -> usize {
        self.bounds.iter().fold(1, |count, (low, high)| count.saturating_mul(extent(*low, *high)))
    }
}

#[derive(Debug)]
pub struct Structure {
    /// The name of the type; empty if anonymous.
    pub name: String,
    pub fields: Vec<Field>,
    /// The index of its record in the program.
    pub record: usize,
    /// The indices of the members, by upper-case name.
    numbers: HashMap<String, usize>,
}

impl Structure {
    pub fn new(name: &str, fields: Vec<Field>, record: usize) -> Structure {
        let numbers = fields.iter().enumerate().map(|(number, field)| (field.key.clone(), number)).collect();
        Structure { name: name.to_string(), fields, record, numbers }
    }

    /// The index of the member with this upper-case name.
    pub fn number(&self, key: &str) -> Option<usize> {
        self.numbers.get(key).copied()
    }
}

impl PartialEq for Structure {
    /// Compares the names and types of the members; equal structures have the same layout in the program.
    fn eq(&self, other: &Structure) -> bool {
        let are_equal = |(one, two): (&Field, &Field)| one.key == two.key && one.of == two.of;
        self.record == other.record
            || self.fields.len() == other.fields.len() && self.fields.iter().zip(&other.fields).all(are_equal)
    }
}

/// A member of a structure.
#[derive(Debug)]
pub struct Field {
    /// Its name as written in the source.
    pub name: String,
    /// Its name in upper case.
    pub key: String,
    pub of: Type,
    /// The author's comment on it.
    pub comment: String,
    /// Whether it is marked as a setpoint.
    pub is_setting: bool,
    /// Whether it is hidden from the user.
    pub is_hidden: bool,
    pub is_retained: bool,
}

/// The name of the string type, with wide characters or without.
pub(crate) fn text_name(wide: bool) -> &'static str {
    if wide { "WSTRING" } else { "STRING" }
}

impl Type {
    /// The elementary type, if it is one.
    pub fn elementary(&self) -> Option<Elementary> {
        match self {
            Type::Elementary(elementary) => Some(*elementary),
            _ => None,
        }
    }

    /// Whether an error in it has been reported, or will be.
    pub fn is_wrong(&self) -> bool {
        matches!(self, Type::Wrong | Type::Missing(_))
    }

    /// Whether a variable of one type may be assigned to a variable of the other: strings of any capacity, arrays of
    /// equal size in each dimension, structures with equal members.
    pub fn is_like(&self, other: &Type) -> bool {
        match (self, other) {
            (Type::Text { wide: one, .. }, Type::Text { wide: other, .. }) => one == other,
            (Type::Array(one), Type::Array(other)) => {
                let extents = |array: &Array| {
                    array.bounds.iter().map(|(low, high)| i64::from(*high) - i64::from(*low)).collect::<Vec<_>>()
                };
                extents(one) == extents(other) && one.of.is_like(&other.of)
            }
            _ => self == other,
        }
    }

    /// Whether it is elementary, and therefore passed as a value rather than as a variable.
    pub fn is_elementary(&self) -> bool {
        matches!(self, Type::Elementary(_))
    }

    /// The representation in the program; `instance` returns the record of a block.
    pub fn lowered(&self, instance: &dyn Fn(usize) -> usize) -> ir::Type {
        match self {
            Type::Elementary(elementary) => ir::Type::Scalar(elementary.scalar()),
            Type::Text { capacity, wide } => ir::Type::Text { capacity: *capacity, wide: *wide },
            Type::Array(array) => {
                ir::Type::Array { of: Box::new(array.of.lowered(instance)), bounds: array.bounds.clone() }
            }
            Type::Open(of, dimensions) => {
                ir::Type::Open { of: Box::new(of.lowered(instance)), dimensions: *dimensions }
            }
            Type::Structure(structure) => ir::Type::Record(structure.record),
            Type::Instance(block) => ir::Type::Record(instance(*block)),
            Type::Void | Type::Missing(_) | Type::Wrong => ir::Type::Scalar(Scalar::Bool),
        }
    }
}

impl fmt::Display for Type {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Type::Elementary(elementary) => formatter.write_str(elementary.name()),
            Type::Text { wide, .. } => formatter.write_str(text_name(*wide)),
            Type::Array(array) => {
                let bounds: Vec<String> = array.bounds.iter().map(|(low, high)| format!("{low}..{high}")).collect();
                write!(formatter, "ARRAY[{}] OF {}", bounds.join(", "), array.of)
            }
            Type::Open(of, _) => write!(formatter, "ARRAY[*] OF {of}"),
            Type::Structure(structure) if structure.name.is_empty() => formatter.write_str("STRUCT"),
            Type::Structure(structure) => write!(formatter, "\"{}\"", structure.name),
            Type::Instance(_) => formatter.write_str("an instance"),
            Type::Void => formatter.write_str("VOID"),
            Type::Missing(name) => write!(formatter, "\"{name}\""),
            Type::Wrong => formatter.write_str("unknown"),
        }
    }
}
