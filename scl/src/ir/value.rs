//! Numbers and their types.

use blocks::{Kind, Time, Word};
use std::fmt;

macro_rules! scalars {
    ($($Scalar:ident $size:literal $name:literal;)*) => {
        /// The type of a number.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Scalar { $(
            #[doc = concat!("`", $name, "`.")]
            $Scalar,
        )* }

        impl Scalar {
            /// All scalar types.
            pub const ALL: &'static [Scalar] = &[$(Scalar::$Scalar),*];

            /// The size in bytes.
            pub const fn size(self) -> usize {
                match self { $(Scalar::$Scalar => $size,)* }
            }
        }

        impl fmt::Display for Scalar {
            fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str(match self { $(Scalar::$Scalar => $name,)* })
            }
        }
    };
}

scalars! {
    Bool 1 "bool";
    I8 1 "i8";
    I16 2 "i16";
    I32 4 "i32";
    I64 8 "i64";
    U8 1 "u8";
    U16 2 "u16";
    U32 4 "u32";
    U64 8 "u64";
    F32 4 "f32";
    F64 8 "f64";
}

impl Scalar {
    /// Whether it is an integer.
    pub const fn is_integer(self) -> bool {
        !matches!(self, Scalar::Bool | Scalar::F32 | Scalar::F64)
    }

    /// Whether it is a floating-point number.
    pub const fn is_float(self) -> bool {
        matches!(self, Scalar::F32 | Scalar::F64)
    }

    /// Whether it is a signed integer.
    pub const fn is_signed(self) -> bool {
        matches!(self, Scalar::I8 | Scalar::I16 | Scalar::I32 | Scalar::I64)
    }

    /// Normalizes 64 bits to a number of this type: the low bits of an integer, sign-extended if it is signed; for a
    /// truth value, whether any bit is set.
    #[inline(always)]
    pub const fn of_bits(self, bits: u64) -> u64 {
        match self {
            Scalar::Bool => (bits != 0) as u64,
            Scalar::I8 => bits as i8 as u64,
            Scalar::I16 => bits as i16 as u64,
            Scalar::I32 => bits as i32 as u64,
            Scalar::U8 => bits as u8 as u64,
            Scalar::U16 => bits as u16 as u64,
            Scalar::U32 | Scalar::F32 => bits as u32 as u64,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => bits,
        }
    }
}

/// A number and its type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Value {
    ty: Scalar,
    bits: u64,
}

macro_rules! values_of {
    ($($number:ty, $Scalar:ident, |$value:ident| $bits:expr;)*) => { $(
        impl From<$number> for Value {
            fn from($value: $number) -> Value {
                Value { ty: Scalar::$Scalar, bits: $bits }
            }
        }
    )* };
}

values_of! {
    bool, Bool, |value| value as u64;
    i8, I8, |value| value as u64;
    i16, I16, |value| value as u64;
    i32, I32, |value| value as u64;
    i64, I64, |value| value as u64;
    u8, U8, |value| value as u64;
    u16, U16, |value| value as u64;
    u32, U32, |value| value as u64;
    u64, U64, |value| value;
    f32, F32, |value| u64::from(value.to_bits());
    f64, F64, |value| value.to_bits();
}

impl Value {
    /// Converts a value of a block: TIME in milliseconds, LTIME in nanoseconds.
    pub fn of_plc(value: blocks::Value) -> Value {
        use blocks::Value as Plc;
        match value {
            Plc::Real(real) => real.into(),
            Plc::LReal(lreal) => lreal.into(),
            Plc::Time(time) => time.milliseconds().into(),
            Plc::Word(word) => (word.value() as u16).into(),
            Plc::Int(int) => int.into(),
            Plc::Bool(bool) => bool.into(),
            Plc::Whole(kind, bits) => Value::new(super::scalar(kind), bits as u64),
        }
    }

    /// Converts to a block's value of type `kind`; this number must have the type [`scalar`](super::scalar) of `kind`.
    pub fn to_plc(self, kind: Kind) -> blocks::Value {
        use blocks::Value as Plc;
        let bits = self.bits;
        match kind {
            Kind::Real => Plc::Real(f32::from_bits(bits as u32)),
            Kind::LReal => Plc::LReal(f64::from_bits(bits)),
            Kind::Time => Plc::Time(Time::ms(bits as i32)),
            Kind::Word => Plc::Word(Word::new(bits as i16)),
            Kind::Int => Plc::Int(bits as i16),
            Kind::Bool => Plc::Bool(bits != 0),
            _ => Plc::Whole(kind, bits as i64),
        }
    }

    /// Creates a number from 64 bits, which [`Scalar::of_bits`] normalizes.
    pub const fn new(ty: Scalar, bits: u64) -> Value {
        Value { ty, bits: ty.of_bits(bits) }
    }

    /// Its type.
    pub const fn ty(self) -> Scalar {
        self.ty
    }

    /// Its 64 bits ([`Scalar::of_bits`]).
    pub const fn bits(self) -> u64 {
        self.bits
    }

    /// The number as an `f64`: exact except for integers of a magnitude above 2^53; a truth value is 0 or 1.
    pub fn number(self) -> f64 {
        match self.ty {
            Scalar::F32 => f64::from(f32::from_bits(self.bits as u32)),
            Scalar::F64 => f64::from_bits(self.bits),
            Scalar::U64 => self.bits as f64,
            _ => self.bits as i64 as f64,
        }
    }

    /// Reads a number from the first bytes, in little-endian order.
    ///
    /// # Panics
    /// There are fewer bytes than the type needs.
    pub fn read(ty: Scalar, bytes: &[u8]) -> Value {
        let mut all = [0; 8];
        all[..ty.size()].copy_from_slice(&bytes[..ty.size()]);
        Value::new(ty, u64::from_le_bytes(all))
    }

    /// Writes the number to the first bytes, in little-endian order.
    ///
    /// # Panics
    /// There are fewer bytes than the type needs.
    pub fn write(self, bytes: &mut [u8]) {
        let size = self.ty.size();
        bytes[..size].copy_from_slice(&self.bits.to_le_bytes()[..size]);
    }
}

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self.ty {
            Scalar::Bool => write!(formatter, "{}", self.bits != 0),
            Scalar::F32 => write!(formatter, "{:?}", f32::from_bits(self.bits as u32)),
            Scalar::F64 => write!(formatter, "{:?}", f64::from_bits(self.bits)),
            Scalar::U64 => write!(formatter, "{}", self.bits),
            _ => write!(formatter, "{}", self.bits as i64),
        }
    }
}
