//! PLC values as FMI sees them: REAL, LREAL and TIME are Real, WORD and INT Integer, BOOL Boolean.

use blocks::table::number;
use blocks::{Block, Kind, Value, Word};
use std::ffi::c_int;

/// An FMI type, as C passes it.
pub trait FmiType: Copy {
    /// FMI's name of the type, as in `fmi2SetReal`.
    const NAME: &'static str;

    /// Whether PLC values of this kind are values of this type.
    fn holds(kind: Kind) -> bool;

    /// The PLC value of a kind that this type holds.
    ///
    /// # Errors
    /// The range, as a text, if the value lies outside.
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str>;

    /// Writes variables in the most frequent cases: one or two REAL inputs or parameters, or one LREAL, with values in range.
    /// False, and nothing is changed, in every other case.
    #[inline(always)]
    fn set_common<B: Block>(_block: &mut B, _references: &[u32], _values: &[Self]) -> bool {
        false
    }

    /// Reads variables in the most frequent case: all are REALs or LREALs. False, and nothing is written, in every other case.
    #[inline(always)]
    fn get_common<B: Block>(_block: &B, _references: &[u32], _values: &mut [Self]) -> bool {
        false
    }

    /// The PLC value in this type; `None` if it is of another.
    fn from_plc(value: Value) -> Option<Self>;

    /// The value for a message.
    fn text(self) -> String;
}

impl FmiType for f64 {
    const NAME: &'static str = "Real";

    fn holds(kind: Kind) -> bool {
        matches!(kind, Kind::Real | Kind::LReal | Kind::Time)
    }

    #[inline]
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
        number::to_value(self, kind)
    }

    #[inline(always)]
    fn set_common<B: Block>(block: &mut B, references: &[u32], values: &[f64]) -> bool {
        let fits = |reference: &u32, value: &f64| {
            B::TABLE.tunable_reals.get(*reference as usize) == Some(&true) && number::is_real(*value)
        };
        let mut put = |reference: &u32, value: &f64| {
            if let Some(real) = block.real_mut(*reference as usize) {
                *real = *value as f32;
            }
        };
        // No loop: in one the compiler would compute the addresses of all REALs first.
        match (references, values) {
            ([reference], [value]) if fits(reference, value) => put(reference, value),
            ([reference], [value]) => return set_lreal(block, *reference, *value),
            ([first, second], [one, other]) if fits(first, one) && fits(second, other) => {
                put(first, one);
                put(second, other);
            }
            _ => return false,
        }
        true
    }

    #[inline(always)]
    fn get_common<B: Block>(block: &B, references: &[u32], values: &mut [f64]) -> bool {
        if let ([reference], [value]) = (references, &mut *values)
            && let Some(real) = block.real(*reference as usize)
        {
            *value = f64::from(real);
            return true;
        }
        get_numbers(block, references, values)
    }

    #[inline]
    fn from_plc(value: Value) -> Option<f64> {
        match value {
            Value::Real(_) | Value::LReal(_) | Value::Time(_) => Some(number::number(value)),
            _ => None,
        }
    }

    fn text(self) -> String {
        format!("{self:?}")
    }
}

/// Writes an LREAL that may be set at any time; false, and nothing is changed, if it is none, or the value is not in range.
#[inline]
fn set_lreal<B: Block>(block: &mut B, reference: u32, value: f64) -> bool {
    let fits = B::TABLE.tunable_lreals.get(reference as usize) == Some(&true) && value.is_finite();
    if fits && let Some(lreal) = block.lreal_mut(reference as usize) {
        *lreal = value;
    }
    fits
}

/// Reads REALs and LREALs; false, and nothing is written, if one is neither.
#[inline]
fn get_numbers<B: Block>(block: &B, references: &[u32], values: &mut [f64]) -> bool {
    let is_number = |reference: &u32| {
        B::TABLE.rows.get(*reference as usize).is_some_and(|row| matches!(row.kind, Kind::Real | Kind::LReal))
    };
    let are_numbers = references.iter().all(is_number);
    if are_numbers {
        for (value, reference) in values.iter_mut().zip(references) {
            *value = real_or_lreal(block, *reference as usize).unwrap_or_default();
        }
    }
    are_numbers
}

/// A function of its own: in a loop the compiler would compute the addresses of all variables first.
#[inline(never)]
fn real_or_lreal<B: Block>(block: &B, row: usize) -> Option<f64> {
    block.real(row).map(f64::from).or_else(|| block.lreal(row))
}

impl FmiType for c_int {
    const NAME: &'static str = "Integer";

    fn holds(kind: Kind) -> bool {
        matches!(kind, Kind::Word | Kind::Int)
    }

    #[inline]
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
        match kind {
            // The upper half of an unsigned word is the negative half of a signed one.
            Kind::Word if (-32768..=65535).contains(&self) => Ok(Value::Word(Word::new(self as i16))),
            Kind::Word => Err("a WORD takes -32768 ... 65535"),
            _ => i16::try_from(self).map(Value::Int).map_err(|_| "an INT takes -32768 ... 32767"),
        }
    }

    #[inline]
    fn from_plc(value: Value) -> Option<c_int> {
        match value {
            Value::Word(word) => Some(c_int::from(word.value())),
            Value::Int(int) => Some(c_int::from(int)),
            _ => None,
        }
    }

    fn text(self) -> String {
        self.to_string()
    }
}

/// FMI's Boolean: an int, not 0 is true.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Boolean(pub c_int);

impl FmiType for Boolean {
    const NAME: &'static str = "Boolean";

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
            Value::Bool(bool) => Some(Boolean(c_int::from(bool))),
            _ => None,
        }
    }

    fn text(self) -> String {
        self.0.to_string()
    }
}

/// The FMI type that holds PLC values of a kind.
pub fn type_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Real | Kind::LReal | Kind::Time => f64::NAME,
        Kind::Word | Kind::Int => c_int::NAME,
        Kind::Bool => Boolean::NAME,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_block::{COUNT, CYCLE, FIRST, ON, SUM, Sum, U, V};
    use blocks::Time;

    #[test]
    fn reals_and_lreals_are_read_at_once_and_nothing_is_if_one_is_of_another_type() {
        let block = Sum { u: 0.5, v: 0.1, sum: -3.0, ..Sum::default() };
        let mut values = [9.0; 3];
        assert!(f64::get_common(&block, &[V, U, SUM], &mut values));
        assert_eq!(values, [0.1, 0.5, -3.0]);
        let mut values = [9.0; 2];
        for other in [ON, FIRST, CYCLE, COUNT, 1000, u32::MAX] {
            assert!(!f64::get_common(&block, &[V, other], &mut values), "{other}");
            assert_eq!(values, [9.0; 2]);
        }
    }

    #[test]
    fn an_lreal_is_set_at_once_if_it_is_an_input_and_the_value_a_number() {
        let mut block = Sum::default();
        assert!(f64::set_common(&mut block, &[V], &[0.1]));
        assert_eq!(block.v, 0.1);
        for (reference, value) in [(V, f64::NAN), (V, f64::INFINITY), (SUM, 1.0), (CYCLE, 1.0), (ON, 1.0), (1000, 1.0)]
        {
            assert!(!f64::set_common(&mut block, &[reference], &[value]), "{reference}");
        }
        assert_eq!((block.v, block.sum), (0.1, 0.0));
    }

    #[test]
    fn a_real_is_rounded_to_binary32_and_what_has_none_is_refused() {
        assert_eq!(0.1.to_plc(Kind::Real), Ok(Value::Real(0.1f32)));
        assert_eq!(f64::from_plc(Value::Real(0.1f32)), Some(0.10000000149011612));
        assert_eq!(3.4028235e38.to_plc(Kind::Real), Ok(Value::Real(f32::MAX)));
        for beyond in [3.41e38, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(beyond.to_plc(Kind::Real).is_err(), "{beyond}");
        }
    }

    #[test]
    fn an_lreal_takes_every_finite_number_as_it_is() {
        assert_eq!(1e300.to_plc(Kind::LReal), Ok(Value::LReal(1e300)));
        assert_eq!(0.1.to_plc(Kind::LReal), Ok(Value::LReal(0.1)));
        for endless in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(endless.to_plc(Kind::LReal), Err("an LREAL takes finite numbers"), "{endless}");
        }
    }

    #[test]
    fn a_time_is_rounded_to_the_nearest_millisecond_from_0_to_the_largest_32_bit_count() {
        assert_eq!(0.0014999.to_plc(Kind::Time), Ok(Value::Time(Time::ms(1))));
        assert_eq!(0.0015001.to_plc(Kind::Time), Ok(Value::Time(Time::ms(2))));
        assert_eq!(2_147_483.647.to_plc(Kind::Time), Ok(Value::Time(Time::ms(i32::MAX))));
        for outside in [-0.001, 2_147_483.648, f64::NAN] {
            assert!(outside.to_plc(Kind::Time).is_err(), "{outside}");
        }
        assert_eq!(f64::from_plc(Value::Time(Time::ms(20_001))), Some(20.001));
    }

    #[test]
    fn the_upper_half_of_a_word_is_its_negative_half() {
        assert_eq!(65535.to_plc(Kind::Word), Ok(Value::Word(Word::new(-1))));
        assert_eq!((-32768).to_plc(Kind::Word), Ok(Value::Word(Word::new(-32768))));
        assert_eq!(c_int::from_plc(Value::Word(Word::new(-1))), Some(-1));
        for outside in [65536, -32769] {
            assert_eq!(outside.to_plc(Kind::Word), Err("a WORD takes -32768 ... 65535"), "{outside}");
        }
    }

    #[test]
    fn an_int_has_16_bits() {
        assert_eq!(32767.to_plc(Kind::Int), Ok(Value::Int(32767)));
        for outside in [32768, -32769] {
            assert_eq!(outside.to_plc(Kind::Int), Err("an INT takes -32768 ... 32767"), "{outside}");
        }
    }

    #[test]
    fn every_kind_is_held_by_the_one_type_that_is_named_for_it() {
        for kind in [Kind::Real, Kind::LReal, Kind::Time, Kind::Word, Kind::Int, Kind::Bool] {
            let types = [f64::holds(kind), c_int::holds(kind), Boolean::holds(kind)];
            let expected = match type_name(kind) {
                "Real" => [true, false, false],
                "Integer" => [false, true, false],
                _ => [false, false, true],
            };
            assert_eq!(types, expected, "{kind:?}");
        }
    }

    #[test]
    fn a_message_shows_a_value_as_the_host_gave_it() {
        assert_eq!(0.1.text(), "0.1");
        assert_eq!((-32769).text(), "-32769");
        assert_eq!(Boolean(-7).text(), "-7");
    }

    #[test]
    fn every_boolean_but_0_is_true() {
        assert_eq!(Boolean(-7).to_plc(Kind::Bool), Ok(Value::Bool(true)));
        assert_eq!(Boolean(0).to_plc(Kind::Bool), Ok(Value::Bool(false)));
        assert_eq!(Boolean::from_plc(Value::Bool(true)), Some(Boolean(1)));
    }
}
