//! The functions that may be called in each state.

use crate::messages;
use crate::refusal::{Answer, Refusal};

/// The states of an instance. A step is either refused before it begins or runs to completion, so the standard's states
/// stepInProgress, stepFailed, stepCanceled and error do not occur.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
    /// After instantiation or a reset.
    Instantiated = 1,
    /// Between entering and leaving Initialization Mode.
    InitializationMode = 2,
    /// Ready for a step.
    StepComplete = 4,
    /// After the end of the simulation.
    Terminated = 8,
    /// After a panic. The block may be half changed, so the instance can only be freed.
    Locked = 16,
    /// At an event, in versions of the standard with Event Mode.
    EventMode = 32,
}

impl State {
    /// The states in which an instance can be saved.
    pub(crate) const LASTING: [State; 5] =
        [State::Instantiated, State::InitializationMode, State::EventMode, State::StepComplete, State::Terminated];

    /// The state with this number, if an instance can be saved in it.
    pub fn numbered(number: u8) -> Option<State> {
        State::LASTING.into_iter().find(|state| *state as u8 == number)
    }

    /// Its name in the function's version of the standard.
    pub(crate) fn name(self, function: &Function) -> &'static str {
        match self {
            State::Instantiated => "instantiated",
            State::InitializationMode => "Initialization Mode",
            State::EventMode => "Event Mode",
            State::StepComplete => function.step_name,
            State::Terminated => "terminated",
            State::Locked => "locked",
        }
    }

    /// Whether the function may be called in this state.
    #[inline(always)]
    fn allows(self, function: &Function) -> bool {
        function.allowed & self as u8 != 0
    }

    /// Checks that the function may be called in this state.
    ///
    /// # Errors
    /// The function may not be called; the message states the current state and the permitted ones.
    #[inline(always)]
    pub fn may(self, function: &Function) -> Result<(), Refusal> {
        if self.allows(function) { Ok(()) } else { Err(self.not_now(function)) }
    }

    #[cold]
    fn not_now(self, function: &Function) -> Refusal {
        if self == State::Locked {
            let reason = "the instance is locked after a panic; it can only be freed";
            return Refusal::new(Answer::Fatal, reason.into());
        }
        let allowed = State::LASTING.into_iter().filter(|state| function.allowed & *state as u8 != 0);
        let allowed: Vec<_> = allowed.map(|state| state.name(function)).collect();
        messages::not_now(self.name(function), &allowed.join(", ")).into()
    }
}

/// A C function: its name and the states in which the standard allows it.
#[derive(Debug)]
pub struct Function {
    /// The name, which begins each log message.
    pub name: &'static str,
    pub(crate) allowed: u8,
    /// The version's name for the state in which steps are made.
    step_name: &'static str,
}

impl Function {
    /// A function allowed in these states. `step_name` is the version's name for [`State::StepComplete`].
    pub const fn new(name: &'static str, states: &[State], step_name: &'static str) -> Function {
        let mut allowed = 0;
        let mut i = 0;
        while i < states.len() {
            allowed |= states[i] as u8;
            i += 1;
        }
        Function { name, allowed, step_name }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use State::{InitializationMode, Instantiated, StepComplete, Terminated};

    const STEP: Function = Function::new("step", &[StepComplete], "stepComplete");
    const SET: Function = Function::new("set", &[Instantiated, InitializationMode, StepComplete], "Step Mode");

    #[test]
    fn a_function_in_a_wrong_state_is_refused_with_the_states_it_is_for() {
        let reason = |result: Result<(), Refusal>| result.unwrap_err().reason().to_string();
        assert_eq!(reason(Instantiated.may(&STEP)), "not allowed in state instantiated, only in stepComplete");
        assert_eq!(
            reason(Terminated.may(&SET)),
            "not allowed in state terminated, only in instantiated, Initialization Mode, Step Mode"
        );
        assert_eq!(
            reason(State::EventMode.may(&SET)),
            "not allowed in state Event Mode, only in instantiated, Initialization Mode, Step Mode"
        );
        assert!(reason(State::Locked.may(&SET)).contains("locked"));
        StepComplete.may(&SET).unwrap();
    }

    #[test]
    fn every_state_but_locked_can_be_saved() {
        let numbers: Vec<u8> = (0..=255).filter(|number| State::numbered(*number).is_some()).collect();
        assert_eq!(
            numbers,
            [Instantiated, InitializationMode, StepComplete, Terminated, State::EventMode].map(|state| state as u8)
        );
    }
}
