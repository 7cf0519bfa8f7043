//! The types of FMI 3.0: their functions, and numbers of them.

use crate::numbers::{any_integer, any_real};
use host::library::Pointer;
use host::library::v3::Library;
use std::ffi::c_int;
use tests::Random;

/// A number of any type.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Number {
    Float(f64),
    Whole(i128),
}

impl Number {
    /// In seconds, if it is the TIME of a block; the number itself otherwise.
    pub(crate) fn seconds(self) -> f64 {
        match self {
            Number::Float(value) => value,
            Number::Whole(milliseconds) => milliseconds as f64 / 1000.0,
        }
    }

    /// Whether both are one number, bit for bit.
    pub(crate) fn is(self, other: Number) -> bool {
        match (self, other) {
            (Number::Float(one), Number::Float(other)) => one.to_bits() == other.to_bits(),
            (Number::Whole(one), Number::Whole(other)) => one == other,
            _ => false,
        }
    }
}

type Get<C> = unsafe extern "C" fn(Pointer, *const u32, usize, *mut C, usize) -> c_int;
type Set<C> = unsafe extern "C" fn(Pointer, *const u32, usize, *const C, usize) -> c_int;

/// A type with its two functions.
pub(super) trait Typed {
    /// What stands for it in C.
    type C: Copy + PartialEq;
    /// What stands in the host's arrays before a call.
    const UNTOUCHED: Self::C;

    fn get(library: &Library) -> Get<Self::C>;
    fn set(library: &Library) -> Set<Self::C>;
    /// Any value, mostly one that fits.
    fn any(random: &mut Random) -> Self::C;
    fn number(value: Self::C) -> Number;
}

macro_rules! types {
    ($($name:ident $C:ty, $get:ident $set:ident, $untouched:literal, $any:expr, $Number:ident;)*) => {
        $(
            #[derive(Clone, Copy)]
            pub(super) struct $name;

            impl Typed for $name {
                type C = $C;
                const UNTOUCHED: $C = $untouched;

                fn get(library: &Library) -> Get<$C> {
                    library.$get
                }

                fn set(library: &Library) -> Set<$C> {
                    library.$set
                }

                fn any(random: &mut Random) -> $C {
                    let any: fn(&mut Random) -> $C = $any;
                    if random.once_in(4) { any(random) } else { random.below(100) as $C }
                }

                fn number(value: $C) -> Number {
                    Number::$Number(value.into())
                }
            }
        )*

        /// Calls a method of a host with the type of a function, which ends with its name.
        macro_rules! with_type {
            ($function:expr, $host:ident.$method:ident($turn:expr)) => {
                match &$function["fmi3Get".len()..] {
                    $(stringify!($name) => $host.$method::<$crate::newer::typed::$name>($turn),)*
                    other => panic!("there is no type {other}"),
                }
            };
        }
        pub(crate) use with_type;
    };
}

types! {
    Float32 f32, get_float32 set_float32, 4711.5, |random| any_real(random) as f32, Float;
    Float64 f64, get_float64 set_float64, 4711.5, any_real, Float;
    Int8 i8, get_int8 set_int8, 47, |random| any_integer(random) as i8, Whole;
    UInt8 u8, get_uint8 set_uint8, 47, |random| any_integer(random) as u8, Whole;
    Int16 i16, get_int16 set_int16, 4711, |random| any_integer(random) as i16, Whole;
    UInt16 u16, get_uint16 set_uint16, 4711, |random| any_integer(random) as u16, Whole;
    Int32 i32, get_int32 set_int32, 4711, any_integer, Whole;
    UInt32 u32, get_uint32 set_uint32, 4711, |random| any_integer(random) as u32, Whole;
    Int64 i64, get_int64 set_int64, 4711, |random| i64::from(any_integer(random)) << random.pick(&[0, 31]), Whole;
    UInt64 u64, get_uint64 set_uint64, 4711, |random| random.bits(), Whole;
    Boolean u8, get_boolean set_boolean, 47, |random| random.pick(&[0, 1, 1, 255]), Whole;
}
