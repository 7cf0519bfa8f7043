//! The model that every answer is compared with, written from the standard's table of allowed calls and not from the
//! FMUs' code.

use blocks::Text;
use std::collections::BTreeMap;
use tests::{Class, Fmu, Kind, Random, Status};

/// The states of an instance that a host can see: instantiated, Initialization Mode, stepComplete, terminated. (A step
/// is never in progress after fmi2DoStep, none fails or is canceled, and refused calls lead to no error state.)
pub(crate) const STATES: &str = "INCT";

/// In which of them each function is allowed: the table of the standard, 4.2.4, with the two known exceptions that Get
/// works in state instantiated and that inputs may be set there.
pub(crate) const ALLOWED: [(&str, &str); 34] = [
    ("fmi2GetTypesPlatform", "INCT"),
    ("fmi2GetVersion", "INCT"),
    ("fmi2SetDebugLogging", "INCT"),
    ("fmi2Instantiate", "INCT"),
    ("fmi2FreeInstance", "INCT"),
    ("fmi2SetupExperiment", "I"),
    ("fmi2EnterInitializationMode", "I"),
    ("fmi2ExitInitializationMode", "N"),
    ("fmi2Terminate", "C"),
    ("fmi2Reset", "INCT"),
    ("fmi2GetReal", "INCT"),
    ("fmi2GetInteger", "INCT"),
    ("fmi2GetBoolean", "INCT"),
    ("fmi2GetString", "INCT"),
    ("fmi2SetReal", "INC"),
    ("fmi2SetInteger", "INC"),
    ("fmi2SetBoolean", "INC"),
    ("fmi2SetString", "INC"),
    ("fmi2GetFMUstate", "INCT"),
    ("fmi2SetFMUstate", "INCT"),
    ("fmi2FreeFMUstate", "INCT"),
    ("fmi2SerializedFMUstateSize", "INCT"),
    ("fmi2SerializeFMUstate", "INCT"),
    ("fmi2DeSerializeFMUstate", "INCT"),
    ("fmi2GetDirectionalDerivative", "NC"),
    ("fmi2SetRealInputDerivatives", "INC"),
    ("fmi2GetRealOutputDerivatives", "CT"),
    ("fmi2DoStep", "C"),
    ("fmi2CancelStep", ""),
    ("fmi2GetStatus", "CT"),
    ("fmi2GetRealStatus", "CT"),
    ("fmi2GetIntegerStatus", "CT"),
    ("fmi2GetBooleanStatus", "CT"),
    ("fmi2GetStringStatus", "CT"),
];

/// Where a function stands in [`ALLOWED`].
pub(crate) fn number(function: &str) -> usize {
    ALLOWED.iter().position(|(name, _)| *name == function).unwrap()
}

/// What the model knows of an instance.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// The place of its state in [`STATES`].
    pub state: usize,
    /// Start and stop time.
    pub experiment: Option<(f64, f64)>,
    /// Where the furthest of the steps ended: the next may begin before it, within the tolerance.
    pub end: f64,
    /// What was set, by value reference.
    pub values: Vec<f64>,
    /// The same of the texts.
    pub texts: Vec<String>,
    /// The derivatives that inputs have.
    pub derivatives: BTreeMap<u32, [f64; 4]>,
}

impl Model {
    /// A new instance.
    pub(crate) fn new(fmu: &Fmu) -> Model {
        let values = fmu.variables.iter().map(|variable| variable.start()).collect();
        let texts = fmu.texts.iter().map(|text| text.start.clone()).collect();
        Model { state: 0, experiment: None, end: 0.0, values, texts, derivatives: BTreeMap::new() }
    }

    /// Whether the standard allows a function, by its place in [`ALLOWED`], in this state.
    pub(crate) fn allows(&self, function: usize) -> bool {
        ALLOWED[function].1.contains(&STATES[self.state..=self.state])
    }
}

/// What an answer has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Expected {
    Exactly(Status),
    /// The model does not know: numbers too near to a bound, or a check that only this block makes.
    OkOrError,
}

pub(crate) fn ok_if(condition: bool) -> Expected {
    Expected::Exactly(if condition { Status::Ok } else { Status::Error })
}

/// Up to here a double tells whole numbers apart: 2^53.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// What a variable holds after it was set; `None` where that is refused.
pub(crate) fn held(kind: Kind, value: f64) -> Option<f64> {
    match kind {
        Kind::Real => Some(f64::from(value as f32)).filter(|held| held.is_finite()),
        Kind::LReal => Some(value).filter(|held| held.is_finite()),
        Kind::Time if (0.0..=2147483.647).contains(&value) => Some((value * 1000.0).round().abs() / 1000.0),
        Kind::Word if (-32768.0..=32767.0).contains(&value) => Some(value + 0.0),
        Kind::Word if (32768.0..=65535.0).contains(&value) => Some(value - 65536.0),
        Kind::Int if (-32768.0..=32767.0).contains(&value) => Some(value + 0.0),
        Kind::Time | Kind::Word | Kind::Int => None,
        Kind::Bool => Some(f64::from(u8::from(value != 0.0))),
        Kind::LTime => Some((value * 1e9).round()).filter(|whole| whole.abs() <= EXACT).map(|whole| whole / 1e9),
        // Read as the integer with its bits.
        Kind::DWord if (f64::from(i32::MIN)..=f64::from(u32::MAX)).contains(&value) => {
            Some(f64::from(value as i64 as i32))
        }
        kind => {
            let (low, high) = kind.whole()?;
            let is_in = (low as f64).max(-EXACT) <= value && value <= (high as f64).min(EXACT);
            Some(value + 0.0).filter(|_| is_in && value.fract() == 0.0)
        }
    }
}

/// Whether a STRING or WSTRING holds a text: a STRING has characters of one byte, a WSTRING such of two.
pub(crate) fn holds(text: &Text, given: &str) -> bool {
    let units = given.encode_utf16().count();
    units <= text.ty.most.into() && (text.ty.is_wide || given.chars().all(|it| it <= '\u{ff}'))
}

/// Whether a variable of this PLC type belongs to `fmi2GetReal`, `fmi2SetBoolean` and so on.
pub(crate) fn is_of(kind: Kind, function: &str) -> bool {
    match &function["fmi2Get".len()..] {
        "Real" => kind.class() == Class::Real,
        "Integer" => kind.class() == Class::Integer,
        _ => kind.class() == Class::Boolean,
    }
}

/// Whether a function has access to a variable of this PLC type: its own, and as Reals all of them.
pub(crate) fn has_access(kind: Kind, function: &str) -> bool {
    is_of(kind, function) || function.ends_with("Real")
}

/// Whether a function can set a variable to a value: as a Real, an integer is whole, and a truth value 0 or 1.
pub(crate) fn takes(kind: Kind, function: &str, value: f64) -> bool {
    let is_one = is_of(kind, function) || value.fract() == 0.0 && (kind != Kind::Bool || value == 0.0 || value == 1.0);
    has_access(kind, function) && is_one && held(kind, value).is_some()
}

/// The count that goes with an array of this length, and whether NULL stands for the array.
pub(crate) fn count_of(random: &mut Random, length: usize) -> (usize, bool) {
    let count = match random.below(24) {
        0 => 0,
        1 => random.pick(&[usize::MAX, isize::MAX as usize, usize::MAX / 2 + 1]),
        _ => length,
    };
    (count, random.once_in(16))
}

/// Whether a function may read an array: as many elements as counted, or none at all.
pub(crate) fn good_array(count: usize, length: usize, null: bool) -> bool {
    count == 0 || count <= length && !null
}
