//! The model of FMI 3.0, written from the standard's tables of allowed calls and not from the FMUs' code.

use crate::model::held as held_of_2;
use crate::newer::typed::Number;
use blocks::Types;
use blocks::table::number::exact;
use modeldescription::Row;
use tests::{Fmu, Kind, Role};

/// Instantiated, Initialization Mode, Event Mode, Step Mode, Terminated.
pub(super) const STATES: &str = "INEST";

/// In which of them each function may succeed: 2.3 and 4.2 of the standard, with the exceptions of FMI 2.0, and that inputs may be
/// set in Step Mode of an instance with Event Mode, too. What the FMUs do not have is allowed nowhere.
pub(super) const ALLOWED: [(&str, &str); 75] = [
    ("fmi3GetVersion", "INEST"),
    ("fmi3SetDebugLogging", "INEST"),
    ("fmi3InstantiateModelExchange", ""),
    ("fmi3InstantiateCoSimulation", "INEST"),
    ("fmi3InstantiateScheduledExecution", ""),
    ("fmi3FreeInstance", "INEST"),
    ("fmi3EnterInitializationMode", "I"),
    ("fmi3ExitInitializationMode", "N"),
    ("fmi3EnterEventMode", "S"),
    ("fmi3Terminate", "NES"),
    ("fmi3Reset", "INEST"),
    ("fmi3GetFloat32", "INEST"),
    ("fmi3GetFloat64", "INEST"),
    ("fmi3GetInt8", "INEST"),
    ("fmi3GetUInt8", "INEST"),
    ("fmi3GetInt16", "INEST"),
    ("fmi3GetUInt16", "INEST"),
    ("fmi3GetInt32", "INEST"),
    ("fmi3GetUInt32", "INEST"),
    ("fmi3GetInt64", "INEST"),
    ("fmi3GetUInt64", "INEST"),
    ("fmi3GetBoolean", "INEST"),
    ("fmi3GetString", "INEST"),
    ("fmi3GetBinary", "INEST"),
    ("fmi3GetClock", "INEST"),
    ("fmi3SetFloat32", "INES"),
    ("fmi3SetFloat64", "INES"),
    ("fmi3SetInt8", "INES"),
    ("fmi3SetUInt8", "INES"),
    ("fmi3SetInt16", "INES"),
    ("fmi3SetUInt16", "INES"),
    ("fmi3SetInt32", "INES"),
    ("fmi3SetUInt32", "INES"),
    ("fmi3SetInt64", "INES"),
    ("fmi3SetUInt64", "INES"),
    ("fmi3SetBoolean", "INES"),
    ("fmi3SetString", "INES"),
    ("fmi3SetBinary", "INES"),
    ("fmi3SetClock", "INES"),
    ("fmi3GetNumberOfVariableDependencies", "NEST"),
    ("fmi3GetVariableDependencies", "NEST"),
    ("fmi3GetFMUState", "INEST"),
    ("fmi3SetFMUState", "INEST"),
    ("fmi3FreeFMUState", "INEST"),
    ("fmi3SerializedFMUStateSize", "INEST"),
    ("fmi3SerializeFMUState", "INEST"),
    ("fmi3DeserializeFMUState", "INEST"),
    ("fmi3GetDirectionalDerivative", ""),
    ("fmi3GetAdjointDerivative", ""),
    ("fmi3EnterConfigurationMode", ""),
    ("fmi3ExitConfigurationMode", ""),
    ("fmi3GetIntervalDecimal", "INEST"),
    ("fmi3GetIntervalFraction", "INEST"),
    ("fmi3GetShiftDecimal", "INEST"),
    ("fmi3GetShiftFraction", "INEST"),
    ("fmi3SetIntervalDecimal", "INEST"),
    ("fmi3SetIntervalFraction", "INEST"),
    ("fmi3SetShiftDecimal", "INEST"),
    ("fmi3SetShiftFraction", "INEST"),
    ("fmi3EvaluateDiscreteStates", ""),
    ("fmi3UpdateDiscreteStates", "E"),
    ("fmi3EnterContinuousTimeMode", ""),
    ("fmi3CompletedIntegratorStep", ""),
    ("fmi3SetTime", ""),
    ("fmi3SetContinuousStates", ""),
    ("fmi3GetContinuousStateDerivatives", ""),
    ("fmi3GetEventIndicators", ""),
    ("fmi3GetContinuousStates", ""),
    ("fmi3GetNominalsOfContinuousStates", ""),
    ("fmi3GetNumberOfEventIndicators", ""),
    ("fmi3GetNumberOfContinuousStates", ""),
    ("fmi3EnterStepMode", "E"),
    ("fmi3GetOutputDerivatives", "ST"),
    ("fmi3DoStep", "S"),
    ("fmi3ActivateModelPartition", ""),
];

/// What the model knows of an instance.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// The place of its state in [`STATES`].
    pub state: usize,
    /// Start and stop time.
    pub experiment: (f64, f64),
    /// Where the furthest of the steps ended.
    pub end: f64,
    /// What was set, by value reference.
    pub values: Vec<Number>,
    /// The same of the texts.
    pub texts: Vec<String>,
}

impl Model {
    /// A new instance.
    pub(crate) fn new(fmu: &Fmu, types: Types) -> Model {
        let values = fmu.variables.iter().map(|row| start(row, types)).collect();
        let texts = fmu.texts.iter().map(|text| text.start.clone()).collect();
        Model { state: 0, experiment: (0.0, f64::INFINITY), end: 0.0, values, texts }
    }

    /// Whether a function may succeed in this state.
    pub(crate) fn allows(&self, function: usize) -> bool {
        ALLOWED[function].1.contains(&STATES[self.state..=self.state])
    }

    /// Whether a variable of this role may be set now.
    pub(crate) fn may_set(&self, role: Role) -> bool {
        match role {
            Role::Input | Role::Parameter => true,
            Role::Fixed | Role::Cycle => self.state < 2,
            Role::Output | Role::Local => false,
        }
    }
}

/// A start value in the variable's own type.
fn start(row: &Row, types: Types) -> Number {
    let whole = exact(row.start).unwrap_or(row.start() as i128);
    match (types, row.kind) {
        _ if types.host_type(row.kind, row.is_analog).starts_with("Float") => Number::Float(row.start()),
        // The start value of a word has a sign, as in FMI 2.0.
        (Types::Native, Kind::Word) if !row.is_analog => Number::Whole(i128::from(whole as u16)),
        (Types::Native, Kind::DWord) => Number::Whole(i128::from(whole as u32)),
        (_, Kind::LWord) => Number::Whole(i128::from(whole as u64)),
        _ => Number::Whole(whole),
    }
}

/// What a variable holds after it was set; `None` where that is refused.
pub(super) fn held(row: &Row, types: Types, given: Number) -> Option<Number> {
    match given {
        // The PLC's TIME may be negative.
        Number::Float(value) if row.kind == Kind::Time && (-2_147_483.648..0.0).contains(&value) => {
            Some(Number::Float((value * 1000.0).round() / 1000.0 + 0.0))
        }
        Number::Float(value) => held_of_2(row.kind, value).map(Number::Float),
        Number::Whole(whole) if row.kind == Kind::Bool => Some(Number::Whole(i128::from(whole != 0))),
        // A type of the PLC's width holds what the PLC holds.
        Number::Whole(_) if types == Types::Native || row.kind.width() == 8 => Some(given),
        Number::Whole(whole) => held_of_2(row.kind, whole as f64).map(|held| Number::Whole(held as i128)),
    }
}
