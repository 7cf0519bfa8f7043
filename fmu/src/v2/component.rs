//! What a `fmi2Component` is: an instance, the log categories chosen for it, and the FMU states that it gave.

use crate::refusal::{Answer, Refusal};
use crate::table::Fingerprint;
use crate::v2::capabilities::{Capability, Setting};
use crate::v2::instance::{Instance, no_string};
use crate::v2::interface::Guid;
use crate::v2::log::{Category, Selection};
use crate::v2::preset::Preset;
use crate::v2::states::Function;
use crate::v2::value::Boolean;
use blocks::Block;
use std::ffi::{CStr, c_int, c_void};
use std::{iter, ptr};

/// What a component can do beyond its instance.
pub const CAPABILITIES: &[Capability] =
    &[("canGetAndSetFMUstate", Setting::Flag(true)), ("canSerializeFMUstate", Setting::Flag(true))];

/// `fmi2Type`: co-simulation.
const CO_SIMULATION: c_int = 1;

/// `fmi2StatusKind`s that have an answer.
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// `fmi2FMUstate`: the address of a saved instance. It is only compared, never followed.
pub type StateAddress = *mut c_void;

/// An instance with its log and its saved states.
#[derive(Debug)]
pub struct Component<B> {
    /// The instance.
    pub instance: Instance<B>,
    /// What is logged.
    pub logged: Selection,
    /// What the user should know of the present call although it succeeds; to be logged at its end.
    pub advice: Vec<String>,
    is_step_advised: bool,
    /// The states that fmi2GetFMUstate and fmi2DeSerializeFMUstate gave. They end with the component.
    saved: Vec<Box<Instance<B>>>,
    /// The start values, unless they are those of the library.
    preset: Option<Box<Preset<B>>>,
}

impl<B: Block> Component<B> {
    /// A new component with logging on or off; errors are logged in any case. With another GUID than the library's, it is that
    /// of a preset, whose start values are read from `resources`, the URI of a folder.
    ///
    /// # Errors
    /// No instance name, a type other than co-simulation, the GUID of another FMU. `None` stands for NULL.
    pub fn new(
        name: Option<&CStr>,
        fmu_type: c_int,
        guid: Option<&CStr>,
        resources: Option<&CStr>,
        logging_on: bool,
    ) -> Result<Component<B>, Refusal> {
        if name.is_none_or(CStr::is_empty) {
            return Err("instanceName is NULL or empty: give the instance a name".into());
        }
        if fmu_type != CO_SIMULATION {
            return Err(format!("fmuType = {fmu_type}: this FMU is for co-simulation (1) only").into());
        }
        let own = Guid::<B>::TEXT;
        let guid = guid.ok_or_else(|| {
            format!("fmuGUID = NULL: this library is {own}; take the modelDescription.xml that came with it")
        })?;
        let is_preset = guid.to_bytes() != own.as_bytes();
        let preset = if is_preset { Some(Box::new(Preset::read(guid, resources)?)) } else { None };
        Ok(Component {
            instance: as_instantiated(preset.as_deref()),
            logged: if logging_on { Selection::ALL } else { Selection::ERRORS },
            advice: Vec::new(),
            is_step_advised: false,
            saved: Vec::new(),
            preset,
        })
    }

    /// Selects the named categories, or all without a name; with logging off, none. Earlier selections do not count.
    ///
    /// # Errors
    /// A category that is NULL or unknown.
    pub fn set_debug_logging<'a>(
        &mut self,
        logging_on: bool,
        names: impl ExactSizeIterator<Item = Option<&'a CStr>>,
    ) -> Result<(), Refusal> {
        let named = Selection::named(names)?;
        self.logged = if logging_on { named } else { Selection::NONE };
        Ok(())
    }

    /// Ends Initialization Mode, with advice on the settings.
    ///
    /// # Errors
    /// As [`Instance::exit_initialization_mode`].
    pub fn exit_initialization_mode(&mut self) -> Result<(), Refusal> {
        self.instance.exit_initialization_mode()?;
        if self.logged.contains(&Category::ADVICE) {
            self.advice = self.instance.advice();
        }
        Ok(())
    }

    /// Makes a step, with advice on its length once in the component's life.
    ///
    /// # Errors
    /// As [`Instance::do_step`].
    pub fn do_step(&mut self, tc: f64, h: f64) -> Result<(), Refusal> {
        self.instance.do_step(tc, h)?;
        if !self.is_step_advised && self.logged.contains(&Category::ADVICE) {
            self.advice.extend(self.instance.advice_on_step(h));
            self.is_step_advised = !self.advice.is_empty();
        }
        Ok(())
    }

    /// Resets the instance to the state after fmi2Instantiate. Log categories and saved states stay.
    pub fn reset(&mut self) {
        self.instance = as_instantiated(self.preset.as_deref());
    }

    /// The instance and all saved states, to be dropped one by one.
    pub fn into_instances(self) -> impl Iterator<Item = Instance<B>> {
        iter::once(self.instance).chain(self.saved.into_iter().map(|saved| *saved))
    }

    /// Checks access to String variables, of which there are none.
    ///
    /// # Errors
    /// Any reference.
    pub fn strings(&self, references: &[u32]) -> Result<(), Refusal> {
        references.first().map_or(Ok(()), |reference| Err(no_string::<B>(*reference)))
    }

    /// Saves the instance: in the state that the host names or, if that is NULL, in a new one.
    ///
    /// # Errors
    /// A state that this component did not give, or that is freed.
    pub fn get_state(&mut self, state: &mut StateAddress) -> Result<(), Refusal> {
        self.keep(state, self.instance.clone())
    }

    /// Restores the instance from a saved state.
    ///
    /// # Errors
    /// As [`Component::get_state`].
    pub fn set_state(&mut self, state: StateAddress) -> Result<(), Refusal> {
        self.instance = self.saved(state)?.clone();
        Ok(())
    }

    /// Frees a saved state and sets it to NULL. NULL is left alone.
    ///
    /// # Errors
    /// As [`Component::get_state`].
    pub fn free_state(&mut self, state: &mut StateAddress) -> Result<(), Refusal> {
        if !state.is_null() {
            let place = self.find(*state)?;
            self.saved.swap_remove(place);
            *state = ptr::null_mut();
        }
        Ok(())
    }

    /// The number of bytes that a saved state takes.
    ///
    /// # Errors
    /// As [`Component::get_state`].
    pub fn serialized_size(&self, state: StateAddress) -> Result<usize, Refusal> {
        Ok(self.saved(state)?.to_bytes(self.hash()).len())
    }

    /// Writes a saved state to the front of `bytes`.
    ///
    /// # Errors
    /// As [`Component::get_state`]; too little room.
    pub fn serialize(&self, state: StateAddress, bytes: &mut [u8]) -> Result<(), Refusal> {
        let serialized = self.saved(state)?.to_bytes(self.hash());
        let (size, length) = (bytes.len(), serialized.len());
        let room = bytes.get_mut(..length).ok_or_else(|| {
            format!("size = {size}: the state takes {length} bytes, as fmi2SerializedFMUstateSize says")
        })?;
        room.copy_from_slice(&serialized);
        Ok(())
    }

    /// Makes a saved state of bytes: in the state that the host names or, if that is NULL, in a new one.
    ///
    /// # Errors
    /// As [`Component::get_state`]; bytes that [`Instance::from_bytes`] refuses.
    pub fn deserialize(&mut self, bytes: &[u8], state: &mut StateAddress) -> Result<(), Refusal> {
        self.keep(state, Instance::from_bytes(bytes, self.hash())?)
    }

    /// What the GUID is made of: two FMUs have the same only if they start from the same values.
    fn hash(&self) -> u128 {
        self.preset.as_ref().map_or(Fingerprint::<B>::HASH, |preset| preset.hash)
    }

    fn keep(&mut self, state: &mut StateAddress, instance: Instance<B>) -> Result<(), Refusal> {
        if state.is_null() {
            let mut instance = Box::new(instance);
            *state = ptr::from_mut(&mut *instance).cast();
            self.saved.push(instance);
        } else {
            let place = self.find(*state)?;
            *self.saved[place] = instance;
        }
        Ok(())
    }

    fn saved(&self, state: StateAddress) -> Result<&Instance<B>, Refusal> {
        self.find(state).map(|place| &*self.saved[place])
    }

    /// The place of a state among those that were given.
    fn find(&self, state: StateAddress) -> Result<usize, Refusal> {
        self.saved.iter().position(|known| ptr::from_ref(&**known).cast() == state.cast_const()).ok_or_else(|| {
            "FMUstate was not given by this instance, or is freed; to move a state to another instance, serialize it"
                .into()
        })
    }

    /// Checks fmi2GetDirectionalDerivative.
    ///
    /// # Errors
    /// Always.
    pub fn directional_derivative(&self) -> Result<(), Refusal> {
        Err("not provided (providesDirectionalDerivative = false)".into())
    }

    /// Checks fmi2GetRealOutputDerivatives of `count` outputs.
    ///
    /// # Errors
    /// Any output.
    pub fn output_derivatives(&self, count: usize) -> Result<(), Refusal> {
        match count {
            0 => Ok(()),
            _ => Err("outputs change in steps and have no derivatives (maxOutputDerivativeOrder = 0)".into()),
        }
    }

    /// Cancels a step.
    ///
    /// # Errors
    /// Always: no step is ever pending.
    pub fn cancel_step(&self) -> Result<(), Refusal> {
        self.instance.may(&Function::CANCEL_STEP)
    }

    /// fmi2GetRealStatus: fmi2LastSuccessfulTime, in seconds.
    ///
    /// # Errors
    /// Any other kind.
    pub fn real_status(&self, kind: c_int) -> Result<f64, Refusal> {
        if kind == LAST_SUCCESSFUL_TIME { Ok(self.instance.last_successful_time()) } else { Err(no_answer(kind)) }
    }

    /// fmi2GetBooleanStatus: fmi2Terminated, which is false because a block never ends the simulation.
    ///
    /// # Errors
    /// Any other kind.
    pub fn boolean_status(&self, kind: c_int) -> Result<Boolean, Refusal> {
        if kind == TERMINATED { Ok(Boolean(0)) } else { Err(no_answer(kind)) }
    }

    /// The other status functions: fmi2DoStepStatus, fmi2PendingStatus and the rest are only asked while a step is
    /// pending.
    ///
    /// # Errors
    /// Always.
    pub fn no_status<T>(&self, kind: c_int) -> Result<T, Refusal> {
        Err(no_answer(kind))
    }
}

/// An instance with the start values of a preset, or else those of the library.
fn as_instantiated<B: Block>(preset: Option<&Preset<B>>) -> Instance<B> {
    preset.map_or_else(Instance::default, |preset| Instance::new(preset.block.clone()))
}

fn no_answer(kind: c_int) -> Refusal {
    Refusal::new(Answer::Discard, format!("status kind {kind} has no answer here: no step is ever pending"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_block::{FIRST, Sum};
    use std::ffi::CString;

    fn new(name: Option<&CStr>, fmu_type: c_int, guid: Option<&CStr>) -> Result<Component<Sum>, Refusal> {
        Component::new(name, fmu_type, guid, None, false)
    }

    fn component() -> Component<Sum> {
        let guid = CString::new(Guid::<Sum>::TEXT).unwrap();
        new(Some(c"x"), CO_SIMULATION, Some(&guid)).unwrap()
    }

    #[test]
    fn an_instance_has_a_name_is_for_co_simulation_and_knows_its_guid() {
        let guid = CString::new(Guid::<Sum>::TEXT).unwrap();
        let reason = |result: Result<Component<Sum>, Refusal>| result.unwrap_err().reason().to_string();
        for name in [None, Some(c"")] {
            assert!(reason(new(name, 1, Some(&guid))).starts_with("instanceName is NULL or empty"));
        }
        assert_eq!(reason(new(Some(c"x"), 0, Some(&guid))), "fmuType = 0: this FMU is for co-simulation (1) only");
        assert!(reason(new(Some(c"x"), 1, None)).starts_with("fmuGUID = NULL: this library is {"));
        assert!(reason(new(Some(c"x"), 1, Some(c"{1}"))).starts_with("fmuGUID = \"{1}\": this library is {"));
    }

    #[test]
    fn logging_is_off_whatever_is_named_when_it_is_switched_off() {
        let mut component = component();
        assert_eq!(component.logged, Selection::ERRORS);
        component.set_debug_logging(true, [Some(c"logStatusFatal")].into_iter()).unwrap();
        assert!(component.logged != Selection::NONE && component.logged != Selection::ALL);
        component.set_debug_logging(true, [].into_iter()).unwrap();
        assert_eq!(component.logged, Selection::ALL);
        component.set_debug_logging(false, [Some(c"logStatusFatal")].into_iter()).unwrap();
        assert_eq!(component.logged, Selection::NONE);
    }

    /// A component in Initialization Mode that logs what `logged` selects.
    fn initializing(logged: Selection) -> Component<Sum> {
        let mut component = component();
        component.logged = logged;
        component.instance.setup_experiment(0.0, None).unwrap();
        component.instance.enter_initialization_mode().unwrap();
        component
    }

    #[test]
    fn advice_on_the_settings_comes_with_the_restart_and_only_while_it_is_logged() {
        for (logged, expected) in [(Selection::ALL, 1), (Selection::ERRORS, 0), (Selection::NONE, 0)] {
            let mut component = initializing(logged);
            component.instance.set(&[FIRST], &[6]).unwrap();
            component.exit_initialization_mode().unwrap();
            assert_eq!(component.advice.len(), expected);
            assert!(component.advice.iter().all(|advice| advice == "FIRST = 6: the count starts late"));
        }
    }

    #[test]
    fn a_step_below_a_hundredth_of_the_cycle_is_advised_on_once() {
        let mut component = initializing(Selection::ALL);
        component.exit_initialization_mode().unwrap();
        // CYCLE is 0.1 s: a step of a hundredth, one of nothing, one of what rounding leaves.
        for (tc, h) in [(0.0, 0.001), (0.001, 0.0), (0.001, 1e-16)] {
            component.do_step(tc, h).unwrap();
            assert_eq!(component.advice, Vec::<String>::new(), "{h:?}");
        }
        component.do_step(0.001, 0.0005).unwrap();
        let expected = "communicationStepSize = 0.0005: CYCLE = 0.1 s is 200 times as long, and only one step in so many \
                        makes a call; is CYCLE given in ms instead of s?";
        assert_eq!(std::mem::take(&mut component.advice), [expected]);
        component.do_step(0.0015, 0.0005).unwrap();
        assert_eq!(component.advice, Vec::<String>::new());
    }

    #[test]
    fn a_step_is_not_advised_on_while_advice_is_not_logged() {
        let mut component = initializing(Selection::ERRORS);
        component.exit_initialization_mode().unwrap();
        component.do_step(0.0, 0.0005).unwrap();
        assert_eq!(component.advice, Vec::<String>::new());
        component.logged = Selection::ALL;
        component.do_step(0.0005, 0.0005).unwrap();
        assert_eq!(component.advice.len(), 1);
    }

    #[test]
    fn a_state_is_found_by_the_address_that_was_given_and_by_no_other() {
        let mut component = component();
        let mut states = [ptr::null_mut(); 3];
        for state in &mut states {
            component.keep(state, Instance::default()).unwrap();
        }
        assert_eq!(states.map(|state| component.find(state).unwrap()), [0, 1, 2]);
        assert!(component.find(ptr::null_mut()).unwrap_err().reason().contains("not given by this instance"));
        component.free_state(&mut states[0].clone()).unwrap();
        assert_eq!(component.find(states[2]).unwrap(), 0, "the last one has taken the place of the first");
        assert!(component.find(states[0]).is_err(), "freed");
    }

    #[test]
    fn a_state_that_is_given_again_is_overwritten_where_it_is() {
        let mut component = component();
        let mut state = ptr::null_mut();
        component.get_state(&mut state).unwrap();
        let place = state;
        component.instance.terminate();
        component.get_state(&mut state).unwrap();
        assert_eq!((component.saved.len(), state), (1, place));
        let bytes = |instance: &Instance<Sum>| instance.to_bytes(Fingerprint::<Sum>::HASH);
        assert_eq!(bytes(&component.saved[0]), bytes(&component.instance));
    }

    #[test]
    fn of_the_inquiries_only_the_last_successful_time_and_terminated_have_an_answer() {
        let mut component = component();
        component.instance.setup_experiment(7.5, None).unwrap();
        component.instance.enter_initialization_mode().unwrap();
        component.instance.exit_initialization_mode().unwrap();
        // fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated
        let kinds = [0, 1, 2, 3];
        assert_eq!(kinds.map(|kind| component.real_status(kind).ok()), [None, None, Some(7.5), None]);
        assert_eq!(kinds.map(|kind| component.boolean_status(kind).ok()), [None, None, None, Some(Boolean(0))]);
        assert_eq!(kinds.map(|kind| component.no_status::<c_int>(kind).ok()), [None; 4]);
        assert_eq!(component.real_status(0).unwrap_err().answer(), Answer::Discard);
    }
}
