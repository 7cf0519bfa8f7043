//! Which function may be called in which state.

use crate::refusal::{Answer, Refusal};

/// The states of FMI 2.0 for co-simulation that an instance can be in. A step is either refused before it begins or runs
/// to its end, so the standard's states stepInProgress, stepFailed, stepCanceled and error do not occur.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
    /// After fmi2Instantiate or fmi2Reset.
    Instantiated = 1,
    /// Between fmi2EnterInitializationMode and fmi2ExitInitializationMode.
    InitializationMode = 2,
    /// Ready for a step.
    StepComplete = 4,
    /// After fmi2Terminate.
    Terminated = 8,
    /// After a panic. The block may be half changed, so the instance can only be freed.
    Locked = 16,
}

impl State {
    /// The states that last: an instance can be saved in them.
    const LASTING: [State; 4] =
        [State::Instantiated, State::InitializationMode, State::StepComplete, State::Terminated];

    /// The lasting state with this number.
    pub fn numbered(number: u8) -> Option<State> {
        State::LASTING.into_iter().find(|state| *state as u8 == number)
    }

    fn name(self) -> &'static str {
        match self {
            State::Instantiated => "instantiated",
            State::InitializationMode => "Initialization Mode",
            State::StepComplete => "stepComplete",
            State::Terminated => "terminated",
            State::Locked => "locked",
        }
    }

    /// Whether the function may be called in this state.
    #[inline(always)]
    pub fn allows(self, function: &Function) -> bool {
        function.allowed & self as u8 != 0
    }

    /// Checks that the function may be called in this state.
    ///
    /// # Errors
    /// The state, and the states in which the function may be called.
    pub fn may(self, function: &Function) -> Result<(), Refusal> {
        if self.allows(function) { Ok(()) } else { Err(self.not_now(function)) }
    }

    fn not_now(self, function: &Function) -> Refusal {
        if self == State::Locked {
            let reason = "the instance is locked after a panic; only fmi2FreeInstance is left";
            return Refusal::new(Answer::Fatal, reason.into());
        }
        if function.allowed == 0 {
            return "a step is complete when fmi2DoStep returns, so there is never one to cancel".into();
        }
        let allowed: Vec<_> =
            State::LASTING.into_iter().filter(|state| function.allowed & *state as u8 != 0).map(State::name).collect();
        format!("not allowed in state {}, only in {}", self.name(), allowed.join(", ")).into()
    }
}

/// A C function: its name and the states in which the standard allows it.
#[derive(Debug)]
pub struct Function {
    /// The name, with which a log message begins.
    pub name: &'static str,
    allowed: u8,
}

const I: u8 = State::Instantiated as u8;
const N: u8 = State::InitializationMode as u8;
const C: u8 = State::StepComplete as u8;
const T: u8 = State::Terminated as u8;

macro_rules! functions {
    ($($constant:ident $name:literal $allowed:expr;)*) => {
        impl Function { $(
            #[doc = concat!("`", $name, "`")]
            pub const $constant: Function = Function { name: $name, allowed: $allowed };
        )* }
    };
}

// FMI 2.0, section 4.2.4, in its order. Two rows are more lenient because real hosts need it: in state instantiated, Get
// works too and gives the start values, and inputs may be set.
functions! {
    SET_DEBUG_LOGGING "fmi2SetDebugLogging" I | N | C | T;
    INSTANTIATE "fmi2Instantiate" 0;
    FREE_INSTANCE "fmi2FreeInstance" I | N | C | T;
    SETUP_EXPERIMENT "fmi2SetupExperiment" I;
    ENTER_INITIALIZATION_MODE "fmi2EnterInitializationMode" I;
    EXIT_INITIALIZATION_MODE "fmi2ExitInitializationMode" N;
    TERMINATE "fmi2Terminate" C;
    RESET "fmi2Reset" I | N | C | T;
    GET_REAL "fmi2GetReal" I | N | C | T;
    GET_INTEGER "fmi2GetInteger" I | N | C | T;
    GET_BOOLEAN "fmi2GetBoolean" I | N | C | T;
    GET_STRING "fmi2GetString" I | N | C | T;
    SET_REAL "fmi2SetReal" I | N | C;
    SET_INTEGER "fmi2SetInteger" I | N | C;
    SET_BOOLEAN "fmi2SetBoolean" I | N | C;
    SET_STRING "fmi2SetString" I | N | C;
    GET_FMU_STATE "fmi2GetFMUstate" I | N | C | T;
    SET_FMU_STATE "fmi2SetFMUstate" I | N | C | T;
    FREE_FMU_STATE "fmi2FreeFMUstate" I | N | C | T;
    SERIALIZED_FMU_STATE_SIZE "fmi2SerializedFMUstateSize" I | N | C | T;
    SERIALIZE_FMU_STATE "fmi2SerializeFMUstate" I | N | C | T;
    DESERIALIZE_FMU_STATE "fmi2DeSerializeFMUstate" I | N | C | T;
    GET_DIRECTIONAL_DERIVATIVE "fmi2GetDirectionalDerivative" N | C;
    SET_REAL_INPUT_DERIVATIVES "fmi2SetRealInputDerivatives" I | N | C;
    GET_REAL_OUTPUT_DERIVATIVES "fmi2GetRealOutputDerivatives" C | T;
    DO_STEP "fmi2DoStep" C;
    CANCEL_STEP "fmi2CancelStep" 0;
    GET_STATUS "fmi2GetStatus" C | T;
    GET_REAL_STATUS "fmi2GetRealStatus" C | T;
    GET_INTEGER_STATUS "fmi2GetIntegerStatus" C | T;
    GET_BOOLEAN_STATUS "fmi2GetBooleanStatus" C | T;
    GET_STRING_STATUS "fmi2GetStringStatus" C | T;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reason(result: Result<(), Refusal>) -> String {
        result.unwrap_err().reason().to_string()
    }

    #[test]
    fn a_function_in_a_wrong_state_is_refused_with_the_states_it_is_for() {
        let state = State::Instantiated;
        assert_eq!(reason(state.may(&Function::DO_STEP)), "not allowed in state instantiated, only in stepComplete");
        assert!(reason(state.may(&Function::CANCEL_STEP)).contains("never one to cancel"));
        assert_eq!(
            reason(State::Terminated.may(&Function::SET_REAL)),
            "not allowed in state terminated, only in instantiated, Initialization Mode, stepComplete"
        );
    }

    #[test]
    fn every_state_but_locked_can_be_saved() {
        let numbers: Vec<u8> = (0..=255).filter(|number| State::numbered(*number).is_some()).collect();
        assert_eq!(numbers, [I, N, C, T]);
    }
}
