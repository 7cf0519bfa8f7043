//! PLC values in FMI 3.0: in types of their own width, or in the few that every host supports.

use super::{Native, Wide};
use crate::cyclic::Cyclic;
use crate::host_type::HostType;
use crate::ordinary;
use blocks::table::number::{exact, number, of_exact, to_value};
use blocks::{Kind, Row, TableText, Time, Value};

/// FMI's Boolean: a byte; any value other than 0 is true.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Boolean(pub u8);

/// Implements integers as host types: each line lists the kinds of PLC values that a type holds under a choice of
/// types.
macro_rules! integers {
    ($($Integer:ident in $Version:ident: $($kind:ident)*;)*) => { $(
        impl HostType<$Version> for $Integer {
            #[inline]
            fn holds(kind: Kind) -> bool {
                matches!(kind, $(Kind::$kind)|*)
            }

            #[inline]
            fn is_of<S: TableText>(row: &Row<S>) -> bool {
                // Two 16-bit types can hold a WORD: the signed one is for analog values.
                let is_narrow = $Integer::BITS == 16;
                let is_other = row.kind == Kind::Word && is_narrow && row.is_analog != ($Integer::MIN != 0);
                <$Integer as HostType<$Version>>::holds(row.kind) && !is_other
            }

            #[inline]
            fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
                of_exact(i128::from(self), kind)
            }

            #[inline]
            fn from_plc(value: Value) -> Option<$Integer> {
                let kind = value.kind();
                if !<$Integer as HostType<$Version>>::holds(kind) {
                    return None;
                }
                // The cast keeps the bits: a DWORD may be read as a signed integer, and a WORD as an unsigned one.
                Some(exact(value)? as $Integer)
            }

            fn text(self) -> String {
                self.to_string()
            }
        }
    )* };
}

integers! {
    i8 in Native: SInt;
    u8 in Native: USInt Byte;
    i16 in Native: Word Int;
    u16 in Native: Word UInt;
    i32 in Native: Time DInt;
    u32 in Native: UDInt DWord;
    i64 in Native: LInt LTime;
    u64 in Native: ULInt LWord;
    i32 in Wide: SInt USInt Byte Int Word UInt DInt DWord;
    i64 in Wide: LInt UDInt;
    u64 in Wide: ULInt LWord;
}

/// Host types that are not used for any kind of value under a choice of types.
macro_rules! unused {
    ($($Type:ident in $Version:ident),*) => { $(
        impl HostType<$Version> for $Type {
            fn holds(_kind: Kind) -> bool {
                false
            }

            fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
                Err(kind.takes())
            }

            fn from_plc(_value: Value) -> Option<$Type> {
                None
            }

            fn text(self) -> String {
                self.to_string()
            }
        }
    )* };
}

unused!(f32 in Wide, i8 in Wide, u8 in Wide, i16 in Wide, u16 in Wide, u32 in Wide);

impl HostType<Native> for f32 {
    #[inline]
    fn holds(kind: Kind) -> bool {
        kind == Kind::Real
    }

    #[inline]
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
        if self.is_finite() { Ok(Value::Real(self)) } else { Err(kind.takes()) }
    }

    #[inline]
    fn from_plc(value: Value) -> Option<f32> {
        match value {
            Value::Real(real) => Some(real),
            _ => None,
        }
    }

    fn text(self) -> String {
        format!("{self:?}")
    }

    #[inline(always)]
    fn set_ordinary<B: Cyclic>(block: &mut B, references: &[u32], values: &[f32]) -> bool {
        ordinary::set_reals(block, references, values)
    }

    #[inline(always)]
    fn get_ordinary<B: Cyclic>(block: &B, references: &[u32], values: &mut [f32]) -> bool {
        ordinary::get_reals(block, references, values)
    }
}

impl HostType<Native> for f64 {
    #[inline]
    fn holds(kind: Kind) -> bool {
        kind == Kind::LReal
    }

    #[inline]
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
        to_value(self, kind)
    }

    #[inline]
    fn from_plc(value: Value) -> Option<f64> {
        match value {
            Value::LReal(lreal) => Some(lreal),
            _ => None,
        }
    }

    fn text(self) -> String {
        format!("{self:?}")
    }
}

impl HostType<Wide> for f64 {
    #[inline]
    fn holds(kind: Kind) -> bool {
        matches!(kind, Kind::Real | Kind::LReal | Kind::Time | Kind::LTime)
    }

    #[inline]
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
        match kind {
            // The PLC's TIME may be negative.
            Kind::Time if (-2_147_483.648..=2_147_483.647).contains(&self) => {
                Ok(Value::Time(Time::ms((self * 1000.0).round() as i32)))
            }
            _ => to_value(self, kind),
        }
    }

    #[inline]
    fn from_plc(value: Value) -> Option<f64> {
        <f64 as HostType<Wide>>::holds(value.kind()).then(|| number(value))
    }

    fn text(self) -> String {
        format!("{self:?}")
    }

    #[inline(always)]
    fn set_ordinary<B: Cyclic>(block: &mut B, references: &[u32], values: &[f64]) -> bool {
        ordinary::set_numbers::<Wide, B>(block, references, values)
    }

    #[inline(always)]
    fn get_ordinary<B: Cyclic>(block: &B, references: &[u32], values: &mut [f64]) -> bool {
        ordinary::get_numbers::<Wide, B>(block, references, values)
    }
}

macro_rules! booleans {
    ($($Version:ident),*) => { $(
        impl HostType<$Version> for Boolean {
            #[inline]
            fn holds(kind: Kind) -> bool {
                kind == Kind::Bool
            }

            #[inline]
            fn to_plc(self, _kind: Kind) -> Result<Value, &'static str> {
                Ok(Value::Bool(self.0 != 0))
            }

            #[inline]
            fn from_plc(value: Value) -> Option<Boolean> {
                match value {
                    Value::Bool(bool) => Some(Boolean(u8::from(bool))),
                    _ => None,
                }
            }

            fn text(self) -> String {
                self.0.to_string()
            }
        }
    )* };
}

booleans!(Native, Wide);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host_type::Version;
    use blocks::table::number::is_real;
    use blocks::{StaticRow, Word};

    /// The names of the types that hold a row's values.
    fn holders<V: Version>(row: &StaticRow) -> Vec<&'static str>
    where
        f32: HostType<V>,
        f64: HostType<V>,
        i8: HostType<V>,
        u8: HostType<V>,
        i16: HostType<V>,
        u16: HostType<V>,
        i32: HostType<V>,
        u32: HostType<V>,
        i64: HostType<V>,
        u64: HostType<V>,
        Boolean: HostType<V>,
    {
        let all = [
            ("Float32", <f32 as HostType<V>>::is_of(row)),
            ("Float64", <f64 as HostType<V>>::is_of(row)),
            ("Int8", <i8 as HostType<V>>::is_of(row)),
            ("UInt8", <u8 as HostType<V>>::is_of(row)),
            ("Int16", <i16 as HostType<V>>::is_of(row)),
            ("UInt16", <u16 as HostType<V>>::is_of(row)),
            ("Int32", <i32 as HostType<V>>::is_of(row)),
            ("UInt32", <u32 as HostType<V>>::is_of(row)),
            ("Int64", <i64 as HostType<V>>::is_of(row)),
            ("UInt64", <u64 as HostType<V>>::is_of(row)),
            ("Boolean", <Boolean as HostType<V>>::is_of(row)),
        ];
        all.into_iter().filter(|(_, holds)| *holds).map(|(name, _)| name).collect()
    }

    #[test]
    fn every_kind_is_held_by_the_one_type_that_is_named_for_it() {
        for kind in Kind::ALL {
            for is_analog in [false, true] {
                let row = StaticRow { kind: *kind, is_analog, ..StaticRow::EMPTY };
                assert_eq!(holders::<Native>(&row), [Native::name_of(&row)], "{kind:?}");
                assert_eq!(holders::<Wide>(&row), [Wide::name_of(&row)], "{kind:?}");
            }
        }
    }

    #[test]
    fn integers_keep_all_their_bits() {
        for whole in [i64::MIN, -1, 9_007_199_254_740_993, i64::MAX] {
            let plc = HostType::<Native>::to_plc(whole, Kind::LInt).unwrap();
            assert_eq!(<i64 as HostType<Native>>::from_plc(plc), Some(whole));
        }
        let plc = HostType::<Native>::to_plc(u64::MAX, Kind::LWord).unwrap();
        assert_eq!(<u64 as HostType<Native>>::from_plc(plc), Some(u64::MAX));
        let plc = HostType::<Native>::to_plc(0xfffe_u16, Kind::Word).unwrap();
        assert_eq!((plc, <u16 as HostType<Native>>::from_plc(plc)), (Value::Word(Word::new(-2)), Some(0xfffe)));
        let plc = HostType::<Native>::to_plc(0x8000_0001_u32, Kind::DWord).unwrap();
        assert_eq!(<u32 as HostType<Native>>::from_plc(plc), Some(0x8000_0001));
        assert_eq!(<i32 as HostType<Wide>>::from_plc(plc), Some(-0x7fff_ffff));
        assert_eq!(HostType::<Wide>::to_plc(-0x7fff_ffff_i32, Kind::DWord), Ok(plc));
    }

    #[test]
    fn a_time_is_milliseconds_and_may_be_negative_and_seconds_in_a_double() {
        let time = |ms| Ok(Value::Time(Time::ms(ms)));
        assert_eq!(HostType::<Native>::to_plc(-1, Kind::Time), time(-1));
        assert_eq!(<i32 as HostType<Native>>::from_plc(Value::Time(Time::ms(-1))), Some(-1));
        assert_eq!(HostType::<Wide>::to_plc(-0.001, Kind::Time), time(-1));
        assert_eq!(HostType::<Wide>::to_plc(0.0015001, Kind::Time), time(2));
        assert_eq!(HostType::<Native>::to_plc(-5_i64, Kind::LTime), Ok(Value::Whole(Kind::LTime, -5)));
    }

    #[test]
    fn what_is_no_number_of_the_plc_is_refused() {
        for endless in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(HostType::<Native>::to_plc(endless, Kind::Real).is_err(), "{endless}");
        }
        assert!(HostType::<Native>::to_plc(f64::NAN, Kind::LReal).is_err());
        assert!(HostType::<Wide>::to_plc(3.5e38, Kind::Real).is_err() && !is_real(3.5e38));
        assert!(HostType::<Wide>::to_plc(32_768, Kind::Int).is_err());
        assert!(HostType::<Wide>::to_plc(-1_i64, Kind::UDInt).is_err());
    }
}
