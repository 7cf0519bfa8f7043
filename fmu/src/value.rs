//! PLC values as FMI sees them: REAL, LREAL and TIME are Real, WORD and INT Integer, BOOL Boolean.

use blocks::{Kind, Time, Value, Word};
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

    /// The PLC value in this type; `None` if it is of another.
    fn from_plc(value: Value) -> Option<Self>;

    /// The value for a message.
    fn text(self) -> String;
}

/// The longest TIME in seconds.
const LONGEST_TIME: f64 = 2_147_483.647;

impl FmiType for f64 {
    const NAME: &'static str = "Real";

    fn holds(kind: Kind) -> bool {
        matches!(kind, Kind::Real | Kind::LReal | Kind::Time)
    }

    #[inline]
    fn to_plc(self, kind: Kind) -> Result<Value, &'static str> {
        match kind {
            Kind::Time if (0.0..=LONGEST_TIME).contains(&self) => {
                Ok(Value::Time(Time::ms((self * 1000.0).round() as i32)))
            }
            Kind::Time => Err("a TIME takes 0 ... 2147483.647 s"),
            Kind::LReal if self.is_finite() => Ok(Value::LReal(self)),
            Kind::LReal => Err("an LREAL takes finite numbers"),
            // Beyond the largest REAL, and with it NaN and infinity, the conversion gives no finite number.
            _ if (self as f32).is_finite() => Ok(Value::Real(self as f32)),
            _ => Err("a REAL takes finite numbers of at most 3.4028235e38"),
        }
    }

    #[inline]
    fn from_plc(value: Value) -> Option<f64> {
        match value {
            Value::Real(real) => Some(f64::from(real)),
            Value::LReal(lreal) => Some(lreal),
            Value::Time(time) => Some(f64::from(time.milliseconds()) / 1000.0),
            _ => None,
        }
    }

    fn text(self) -> String {
        format!("{self:?}")
    }
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

/// The value as a plain number: a TIME in seconds, TRUE as 1.
pub fn number(value: Value) -> f64 {
    match value {
        Value::Bool(bool) => f64::from(u8::from(bool)),
        Value::Word(word) => f64::from(word.value()),
        Value::Int(int) => f64::from(int),
        real => f64::from_plc(real).unwrap_or_default(),
    }
}
