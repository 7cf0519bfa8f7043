//! The calls on a living instance, one function each: it draws the arguments, says what the answer has to be, calls,
//! checks what the call wrote, and says what the model knows afterwards.

mod derivatives;
pub(crate) mod lifecycle;
pub(crate) mod logging;
mod states;
mod status;
pub(crate) mod step;
pub(crate) mod values;

use crate::host::Host;
use crate::model::{Expected, Model, STATES};
use host::library::Pointer;
use std::fmt;
use tests::{Random, Status};

/// A call that is about to be made.
pub(crate) struct Turn<'a> {
    /// The function.
    pub name: &'static str,
    /// Whether the standard allows it in this state.
    pub allowed: bool,
    /// What its arguments are drawn from.
    pub random: &'a mut Random,
    /// Which of the host's instances it is called on.
    pub place: usize,
    pub component: Pointer,
    /// What the model knows of the instance before the call.
    pub model: Model,
}

impl Turn<'_> {
    /// The call as it is shown where it is answered wrongly.
    pub(crate) fn with<'a>(&self, arguments: &'a str) -> What<'a> {
        What { name: self.name, state: self.model.state, arguments }
    }

    /// The answer to a call that leaves the model as it is.
    fn unchanged(&self, status: Status, expected: Expected, arguments: String) -> Answer {
        Answer { status, expected, arguments, after: self.model.clone() }
    }
}

/// A call as it is shown where it is answered wrongly.
pub(crate) struct What<'a> {
    name: &'static str,
    state: usize,
    arguments: &'a str,
}

impl fmt::Display for What<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}({}) in state {}", self.name, self.arguments, &STATES[self.state..=self.state])
    }
}

/// What came of a call.
pub(crate) struct Answer {
    pub status: Status,
    pub expected: Expected,
    /// The arguments, for messages.
    pub arguments: String,
    /// What the model knows of the instance if the call succeeded.
    pub after: Model,
}

impl Host<'_> {
    /// Makes a call. `fmi2GetTypesPlatform`, `fmi2GetVersion`, `fmi2Instantiate` and `fmi2FreeInstance` are not among
    /// them: the host calls them itself.
    pub(crate) fn answer(&mut self, turn: &mut Turn) -> Answer {
        match turn.name {
            "fmi2SetDebugLogging" => self.set_debug_logging(turn),
            "fmi2SetupExperiment" => self.setup_experiment(turn),
            "fmi2EnterInitializationMode" => self.enter_initialization_mode(turn),
            "fmi2ExitInitializationMode" => self.exit_initialization_mode(turn),
            "fmi2Terminate" => self.terminate(turn),
            "fmi2Reset" => self.reset(turn),
            "fmi2GetReal" | "fmi2GetInteger" | "fmi2GetBoolean" => self.get(turn),
            "fmi2SetReal" | "fmi2SetInteger" | "fmi2SetBoolean" => self.set(turn),
            "fmi2GetString" | "fmi2SetString" => self.string(turn),
            "fmi2GetFMUstate" => self.get_fmu_state(turn),
            "fmi2SetFMUstate" => self.set_fmu_state(turn),
            "fmi2FreeFMUstate" => self.free_fmu_state(turn),
            "fmi2SerializedFMUstateSize" => self.serialized_fmu_state_size(turn),
            "fmi2SerializeFMUstate" => self.serialize_fmu_state(turn),
            "fmi2DeSerializeFMUstate" => self.deserialize_fmu_state(turn),
            "fmi2GetDirectionalDerivative" => self.get_directional_derivative(turn),
            "fmi2SetRealInputDerivatives" => self.set_real_input_derivatives(turn),
            "fmi2GetRealOutputDerivatives" => self.get_real_output_derivatives(turn),
            "fmi2DoStep" => self.do_step(turn),
            "fmi2CancelStep" => self.cancel_step(turn),
            name if name.ends_with("Status") => self.get_status(turn),
            other => panic!("the model knows no call of {other} on an instance"),
        }
    }
}
