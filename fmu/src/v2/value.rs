//! PLC values in FMI 2.0: floating-point numbers, durations, UDINT and 64-bit types are Real, all other integers and
//! bit strings Integer, and BOOL is Boolean.

use super::Fmi2;
use crate::cyclic::Cyclic;
use crate::host_type::HostType;
use crate::ordinary;
use blocks::table::number;
use blocks::{Class, Kind, Value, Word};
use std::ffi::c_int;

impl HostType<Fmi2> for f64 {
    fn holds(kind: Kind) -> bool {
        kind.class() == Class::Real
    }

    #[inline]
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
        number::to_value(self, kind)
    }

    #[inline(always)]
    fn set_ordinary<B: Cyclic>(block: &mut B, references: &[u32], values: &[f64]) -> bool {
        ordinary::set_numbers::<Fmi2, B>(block, references, values)
    }

    #[inline(always)]
    fn get_ordinary<B: Cyclic>(block: &B, references: &[u32], values: &mut [f64]) -> bool {
        ordinary::get_numbers::<Fmi2, B>(block, references, values)
    }

    #[inline]
    fn from_plc(value: Value) -> Option<f64> {
        match value {
            Value::Real(_) | Value::LReal(_) | Value::Time(_) => Some(number::number(value)),
            Value::Whole(kind, _) if kind.class() == Class::Real => Some(number::number(value)),
            _ => None,
        }
    }

    fn text(self) -> String {
        format!("{self:?}")
    }
}

impl HostType<Fmi2> for c_int {
    fn holds(kind: Kind) -> bool {
        kind.class() == Class::Integer
    }

    #[inline]
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
        match kind {
            // The upper half of an unsigned word is the negative half of a signed one.
            Kind::Word if (-32768..=65535).contains(&self) => Ok(Value::Word(Word::new(self as i16))),
            Kind::Word => Err("a WORD accepts -32768 ... 65535"),
            _ => number::to_value(f64::from(self), kind),
        }
    }

    #[inline]
    fn from_plc(value: Value) -> Option<c_int> {
        match value {
            Value::Word(word) => Some(c_int::from(word.value())),
            Value::Int(int) => Some(c_int::from(int)),
            // A DWORD becomes the signed integer with the same bits.
            Value::Whole(kind, whole) if kind.class() == Class::Integer => Some(whole as c_int),
            _ => None,
        }
    }

    fn text(self) -> String {
        self.to_string()
    }
}

/// A Real through which a host accesses a variable of any type, as some hosts do for all variables. TRUE is 1.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnyReal(pub f64);

impl HostType<Fmi2> for AnyReal {
    fn holds(_kind: Kind) -> bool {
        true
    }

    fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
        number::to_value(self.0, kind)
    }

    fn from_plc(value: Value) -> Option<AnyReal> {
        // An integer has the same value as when read as an Integer.
        let integer = <c_int as HostType<Fmi2>>::from_plc(value).map(f64::from);
        Some(AnyReal(integer.unwrap_or_else(|| number::number(value))))
    }

    fn text(self) -> String {
        format!("{:?}", self.0)
    }
}

/// FMI's Boolean: an int; any value other than 0 is true.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Boolean(pub c_int);

impl HostType<Fmi2> for Boolean {
    fn holds(kind: Kind) -> bool {
        matches!(kind, Kind::Bool)
    }

    #[inline]
    fn to_plc(self, _kind: Kind) -> Result<Value, &'static str> {
        Ok(Value::Bool(self.0 != 0))
    }

    #[inline]
    fn from_plc(value: Value) -> Option<Boolean> {
        match value {
            Value::Bool(bool) => Some(Boolean(c_int::from(bool))),
            _ => None,
        }
    }

    fn text(self) -> String {
        self.0.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host_type::Version;
    use blocks::StaticRow;
    use blocks::Time;

    #[test]
    fn every_value_is_a_real_for_those_who_read_it_as_one() {
        let real = |value| <AnyReal as HostType<Fmi2>>::from_plc(value).map(|real| real.0);
        assert_eq!(real(Value::Bool(true)), Some(1.0));
        assert_eq!(real(Value::Int(-5)), Some(-5.0));
        assert_eq!(real(Value::Whole(Kind::DWord, 0xffff_ffff)), Some(-1.0));
        assert_eq!(real(Value::Time(Time::ms(1500))), Some(1.5));
        let plc = |real, kind| HostType::<Fmi2>::to_plc(AnyReal(real), kind).ok();
        assert_eq!([1.0, 0.0].map(|real| plc(real, Kind::Bool)), [true, false].map(|bool| Some(Value::Bool(bool))));
        assert_eq!(plc(-5.0, Kind::Int), Some(Value::Int(-5)));
        assert_eq!([plc(0.5, Kind::Int), plc(0.5, Kind::Bool), plc(f64::NAN, Kind::Word)], [None; 3]);
    }

    #[test]
    fn a_real_is_rounded_to_binary32_and_what_has_none_is_refused() {
        assert_eq!(HostType::<Fmi2>::to_plc(0.1, Kind::Real), Ok(Value::Real(0.1f32)));
        assert_eq!(<f64 as HostType<Fmi2>>::from_plc(Value::Real(0.1f32)), Some(0.10000000149011612));
        assert_eq!(HostType::<Fmi2>::to_plc(3.4028235e38, Kind::Real), Ok(Value::Real(f32::MAX)));
        for beyond in [3.41e38, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(HostType::<Fmi2>::to_plc(beyond, Kind::Real).is_err(), "{beyond}");
        }
    }

    #[test]
    fn an_lreal_takes_every_finite_number_as_it_is() {
        assert_eq!(HostType::<Fmi2>::to_plc(1e300, Kind::LReal), Ok(Value::LReal(1e300)));
        assert_eq!(HostType::<Fmi2>::to_plc(0.1, Kind::LReal), Ok(Value::LReal(0.1)));
        for endless in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(
                HostType::<Fmi2>::to_plc(endless, Kind::LReal),
                Err("an LREAL accepts finite numbers"),
                "{endless}"
            );
        }
    }

    #[test]
    fn a_time_is_rounded_to_the_nearest_millisecond_from_0_to_the_largest_32_bit_count() {
        assert_eq!(HostType::<Fmi2>::to_plc(0.0014999, Kind::Time), Ok(Value::Time(Time::ms(1))));
        assert_eq!(HostType::<Fmi2>::to_plc(0.0015001, Kind::Time), Ok(Value::Time(Time::ms(2))));
        assert_eq!(HostType::<Fmi2>::to_plc(2_147_483.647, Kind::Time), Ok(Value::Time(Time::ms(i32::MAX))));
        for outside in [-0.001, 2_147_483.648, f64::NAN] {
            assert!(HostType::<Fmi2>::to_plc(outside, Kind::Time).is_err(), "{outside}");
        }
        assert_eq!(<f64 as HostType<Fmi2>>::from_plc(Value::Time(Time::ms(20_001))), Some(20.001));
    }

    #[test]
    fn the_upper_half_of_a_word_is_its_negative_half() {
        assert_eq!(HostType::<Fmi2>::to_plc(65535, Kind::Word), Ok(Value::Word(Word::new(-1))));
        assert_eq!(HostType::<Fmi2>::to_plc(-32768, Kind::Word), Ok(Value::Word(Word::new(-32768))));
        assert_eq!(<c_int as HostType<Fmi2>>::from_plc(Value::Word(Word::new(-1))), Some(-1));
        for outside in [65536, -32769] {
            assert_eq!(
                HostType::<Fmi2>::to_plc(outside, Kind::Word),
                Err("a WORD accepts -32768 ... 65535"),
                "{outside}"
            );
        }
    }

    #[test]
    fn an_int_has_16_bits() {
        assert_eq!(HostType::<Fmi2>::to_plc(32767, Kind::Int), Ok(Value::Int(32767)));
        for outside in [32768, -32769] {
            assert_eq!(
                HostType::<Fmi2>::to_plc(outside, Kind::Int),
                Err("an INT accepts -32768 ... 32767"),
                "{outside}"
            );
        }
    }

    #[test]
    fn every_kind_is_held_by_the_one_type_that_is_named_for_it() {
        for kind in [Kind::Real, Kind::LReal, Kind::Time, Kind::Word, Kind::Int, Kind::Bool] {
            let types = [
                <f64 as HostType<Fmi2>>::holds(kind),
                <c_int as HostType<Fmi2>>::holds(kind),
                <Boolean as HostType<Fmi2>>::holds(kind),
            ];
            let expected = match Fmi2::name_of(&StaticRow { kind, ..StaticRow::EMPTY }) {
                "Real" => [true, false, false],
                "Integer" => [false, true, false],
                _ => [false, false, true],
            };
            assert_eq!(types, expected, "{kind:?}");
        }
    }

    #[test]
    fn a_message_shows_a_value_as_the_host_gave_it() {
        assert_eq!(HostType::<Fmi2>::text(0.1), "0.1");
        assert_eq!(HostType::<Fmi2>::text(-32769), "-32769");
        assert_eq!(HostType::<Fmi2>::text(Boolean(-7)), "-7");
    }

    #[test]
    fn every_boolean_but_0_is_true() {
        assert_eq!(HostType::<Fmi2>::to_plc(Boolean(-7), Kind::Bool), Ok(Value::Bool(true)));
        assert_eq!(HostType::<Fmi2>::to_plc(Boolean(0), Kind::Bool), Ok(Value::Bool(false)));
        assert_eq!(<Boolean as HostType<Fmi2>>::from_plc(Value::Bool(true)), Some(Boolean(1)));
    }
}
