//! The PLC types of variables, with the properties that each layer needs.

/// The host's class of a PLC type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// A floating-point number.
    Real,
    /// A 32-bit integer.
    Integer,
    /// TRUE or FALSE.
    Boolean,
}

/// The literal format of a PLC type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A number with decimal places: `2.5`, `1.0e-3`.
    Decimal,
    /// A duration: `T#20S`.
    Duration,
    /// Bits: `W#16#6C00`.
    Bits,
    /// An integer: `200`.
    Integer,
    /// `TRUE` or `FALSE`.
    Switch,
}

macro_rules! kinds {
    ($( $Kind:ident $name:literal $tia:literal $width:literal $Class:ident $Form:ident $([$low:expr, $high:expr])?, $takes:literal, $doc:literal; )*) => {
        named! {
            /// The PLC type of a variable.
            Kind { $( #[doc = $doc] $Kind $name; )* }
        }

        impl Kind {
            /// Returns the name in TIA Portal.
            pub const fn tia_name(self) -> &'static str {
                match self { $( Kind::$Kind => $tia, )* }
            }

            /// Returns the size of a value in a data block in bytes; 0 for a BOOL, which occupies one bit.
            pub const fn width(self) -> usize {
                match self { $( Kind::$Kind => $width, )* }
            }

            /// Returns the host's class. An integer type that does not fit into a signed 32-bit integer is a
            /// floating-point number in the host; a DWORD is the integer with the same bits.
            pub const fn class(self) -> Class {
                match self { $( Kind::$Kind => Class::$Class, )* }
            }

            /// Returns the literal format.
            pub const fn form(self) -> Form {
                match self { $( Kind::$Kind => Form::$Form, )* }
            }

            /// Returns the inclusive bounds of an integer type that exists only in programs, not in blocks: one stored
            /// in a [`Value::Whole`](super::Value::Whole).
            pub const fn whole(self) -> Option<(i128, i128)> {
                match self { $( Kind::$Kind => kinds!(@whole $($low, $high)?), )* }
            }

            /// Returns the unit in which values are shown: seconds for a duration, otherwise the variable's `own` unit.
            pub const fn shown_unit(self, own: Option<&str>) -> Option<&str> {
                match self.form() {
                    Form::Duration => Some("s"),
                    _ => own,
                }
            }

            /// Describes the accepted numbers in a sentence.
            pub const fn takes(self) -> &'static str {
                match self { $( Kind::$Kind => $takes, )* }
            }
        }
    };
    (@whole) => { None };
    (@whole $low:expr, $high:expr) => { Some(($low as i128, $high as i128)) };
}

// Name, name in TIA Portal, size in a data block in bytes, host class, literal format, range of an integer type of
// programs, accepted numbers, description.
kinds! {
    Real  "REAL"  "Real"  4 Real Decimal, "a REAL accepts finite numbers with a magnitude of at most 3.4028235e38", "32-bit floating point.";
    LReal "LREAL" "LReal" 8 Real Decimal, "an LREAL accepts finite numbers", "64-bit floating point.";
    Time  "TIME"  "Time"  4 Real Duration, "a TIME accepts 0 ... 2147483.647 s", "Milliseconds.";
    Word  "WORD"  "Word"  2 Integer Bits, "a WORD accepts -32768 ... 65535", "16 bits; in a block, an analog value in two's complement.";
    Int   "INT"   "Int"   2 Integer Integer, "an INT accepts -32768 ... 32767", "A 16-bit integer.";
    Bool  "BOOL"  "Bool"  0 Boolean Switch, "a BOOL accepts 0 and 1", "One bit.";
    SInt  "SINT"  "SInt"  1 Integer Integer [i8::MIN, i8::MAX], "an SINT accepts -128 ... 127", "An 8-bit integer.";
    USInt "USINT" "USInt" 1 Integer Integer [0, u8::MAX], "a USINT accepts 0 ... 255", "An unsigned 8-bit integer.";
    Byte  "BYTE"  "Byte"  1 Integer Bits [0, u8::MAX], "a BYTE accepts 0 ... 255", "8 bits.";
    UInt  "UINT"  "UInt"  2 Integer Integer [0, u16::MAX], "a UINT accepts 0 ... 65535", "An unsigned 16-bit integer.";
    DInt  "DINT"  "DInt"  4 Integer Integer [i32::MIN, i32::MAX], "a DINT accepts -2147483648 ... 2147483647", "A 32-bit integer.";
    UDInt "UDINT" "UDInt" 4 Real Integer [0, u32::MAX], "a UDINT accepts 0 ... 4294967295", "An unsigned 32-bit integer.";
    DWord "DWORD" "DWord" 4 Integer Bits [0, u32::MAX], "a DWORD accepts -2147483648 ... 4294967295", "32 bits.";
    LInt  "LINT"  "LInt"  8 Real Integer [i64::MIN, i64::MAX], "an LINT passed as a double accepts integers from -9007199254740992 to 9007199254740992", "A 64-bit integer.";
    ULInt "ULINT" "ULInt" 8 Real Integer [0, u64::MAX], "a ULINT passed as a double accepts integers from 0 to 9007199254740992", "An unsigned 64-bit integer.";
    LWord "LWORD" "LWord" 8 Real Bits [0, u64::MAX], "an LWORD passed as a double accepts integers from 0 to 9007199254740992", "64 bits.";
    LTime "LTIME" "LTime" 8 Real Duration [i64::MIN, i64::MAX], "an LTIME passed as a double accepts -9007199.254740992 ... 9007199.254740992 s", "Nanoseconds.";
}
