//! The object behind a host's instance pointer: an instance, its selected log categories, and its saved states.

use crate::cyclic::{Cyclic, StartValues};
use crate::instance::{Events, Instance};
use crate::log::{Category, Selection};
use crate::messages;
use crate::preset::{Argument, Identity, Preset};
use crate::refusal::Refusal;
use crate::session::Reached;
use crate::state::State;
use crate::table::Fingerprint;
use blocks::Block;
use std::ffi::{CStr, CString, c_void};
use std::{mem, ptr};

/// The address of a saved instance. It is only compared, never dereferenced.
pub type StateAddress = *mut c_void;

/// The FMU from which instances are created: its identifier and its start values.
pub struct Origin<B: Cyclic> {
    /// The hash from which the identifier passed by the host is derived. Two FMUs have the same hash only if they have
    /// the same start values.
    pub hash: u128,
    /// The form of the identifier, as an index into [`Identity::forms`].
    pub form: usize,
    /// The block with its start values.
    pub start: B::StartValues,
}

/// A library that creates instances. Every [`Block`] is one.
pub trait Library: 'static {
    /// The block that an instance calls.
    type Block: Cyclic;

    /// Finds the FMU that has this identifier. `resources` is the URI or path of its resources folder.
    ///
    /// # Errors
    /// The identifier is missing or belongs to another FMU, or a resource is missing or damaged.
    fn open(identity: Identity, resources: Argument) -> Result<Origin<Self::Block>, Refusal>;
}

impl<B: Block> Library for B {
    type Block = B;

    /// A GUID other than the library's belongs to a preset, whose start values are read from the resources.
    fn open(identity: Identity, resources: Argument) -> Result<Origin<B>, Refusal> {
        if identity.value.is_none() {
            return Err(messages::other_library(identity.name, "NULL", &identity.text(Fingerprint::<B>::HASH)).into());
        }
        if let Some((form, hash)) = identity.own_form::<B>() {
            return Ok(Origin { hash, form, start: StartValues::Own });
        }
        let Preset { hash, form, block } = Preset::read(identity, resources)?;
        Ok(Origin { hash, form, start: StartValues::Preset(Box::new(block)) })
    }
}

/// An instance with its log and its saved states.
pub struct Component<B: Cyclic> {
    /// The instance.
    pub instance: Instance<B>,
    /// The selected log categories.
    pub logged: Selection,
    /// Advice on the current, successful call; logged at its end.
    pub advice: Vec<String>,
    /// The strings last returned to the host, which must copy them before its next call.
    pub texts: Vec<CString>,
    is_step_advised: bool,
    is_conversion_advised: bool,
    /// The states handed out to the host. They are freed with the component.
    saved: Vec<Box<Instance<B>>>,
    origin: Origin<B>,
}

impl<B: Cyclic> Component<B> {
    /// A new component that makes calls within steps. With logging off, it initially logs errors only.
    pub fn new(origin: Origin<B>, logging_on: bool) -> Component<B> {
        Component::with_events(origin, logging_on, None)
    }

    /// Like [`Component::new`], but if `events` is given, calls are events.
    pub fn with_events(origin: Origin<B>, logging_on: bool, events: Option<Events>) -> Component<B> {
        Component {
            instance: origin.instance().with(events),
            logged: if logging_on { Selection::ALL } else { Selection::ERRORS },
            advice: Vec::new(),
            texts: Vec::new(),
            is_step_advised: false,
            is_conversion_advised: false,
            saved: Vec::new(),
            origin,
        }
    }

    /// Selects the named categories, or all if none are named; no category if logging is off. Replaces earlier
    /// selections.
    ///
    /// # Errors
    /// A category is NULL or unknown.
    pub fn set_debug_logging<'a>(
        &mut self,
        logging_on: bool,
        names: impl ExactSizeIterator<Item = Option<&'a CStr>>,
    ) -> Result<(), Refusal> {
        let named = Selection::named(names)?;
        self.logged = if logging_on { named } else { Selection::NONE };
        Ok(())
    }

    /// Exits Initialization Mode and adds advice on the settings.
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

    /// Makes a step, with advice on its length at most once in the component's lifetime.
    ///
    /// # Errors
    /// As [`Instance::do_step`].
    #[inline(always)]
    pub fn do_step(&mut self, tc: f64, h: f64) -> Result<Reached, Refusal> {
        match self.instance.make_ordinary_step(tc, h) {
            Some(reached) => Ok(reached),
            None => self.do_checked_step(tc, h),
        }
    }

    #[inline(never)]
    fn do_checked_step(&mut self, tc: f64, h: f64) -> Result<Reached, Refusal> {
        let done = self.instance.do_step(tc, h);
        self.take_warnings();
        let reached = done?;
        if !self.is_step_advised && self.logged.contains(&Category::ADVICE) {
            let advice = self.instance.advice_on_step(h);
            self.is_step_advised = advice.is_some();
            self.advice.extend(advice);
        }
        Ok(reached)
    }

    /// Advises the host, once in the component's lifetime, that a variable is accessed as a different type.
    pub fn advise_on_conversion(&mut self, advice: impl FnOnce() -> String) {
        if !self.is_conversion_advised && self.logged.contains(&Category::ADVICE) {
            self.advice.push(advice());
            self.is_conversion_advised = true;
        }
    }

    /// Makes the call that is due in Event Mode, if any, and returns the time of the next one in seconds; `None` if
    /// calls are not events.
    ///
    /// # Errors
    /// As [`Instance::update_discrete_states`].
    pub fn update_discrete_states(&mut self) -> Result<Option<f64>, Refusal> {
        let next = self.instance.update_discrete_states();
        self.take_warnings();
        next
    }

    /// Takes the program's warnings as advice, if advice is logged.
    fn take_warnings(&mut self) {
        if !B::IS_SURE && self.logged.contains(&Category::ADVICE) {
            self.advice = self.instance.take_warnings();
        }
    }

    /// The form in which the host passed the identifier, as an index into [`Identity::forms`].
    pub fn form(&self) -> usize {
        self.origin.form
    }

    /// Resets the instance to its initial state. Log categories and saved states are kept.
    pub fn reset(&mut self) {
        self.instance = self.origin.instance().with(self.instance.events());
    }

    /// Takes all saved states.
    pub fn take_saved(&mut self) -> Vec<Box<Instance<B>>> {
        mem::take(&mut self.saved)
    }

    /// Saves the instance in the host's existing state or, if `state` is NULL, in a new one.
    ///
    /// # Errors
    /// The state was not saved by this component, or has been freed.
    pub fn get_state(&mut self, state: &mut StateAddress) -> Result<(), Refusal> {
        self.keep(state, self.instance.clone())
    }

    /// Restores the instance from a saved state.
    ///
    /// # Errors
    /// As [`Component::get_state`].
    pub fn set_state(&mut self, state: StateAddress) -> Result<(), Refusal> {
        let saved = self.saved(state)?;
        let events = self.instance.events();
        if saved.state == State::EventMode && events.is_none() {
            return Err(messages::state_in_event_mode().into());
        }
        self.instance = saved.clone().with(events);
        Ok(())
    }

    /// Frees a saved state and sets the pointer to NULL. Does nothing for NULL.
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

    /// The size of a serialized state, in bytes.
    ///
    /// # Errors
    /// As [`Component::get_state`].
    pub fn serialized_size(&self, state: StateAddress) -> Result<usize, Refusal> {
        Ok(self.saved(state)?.to_bytes(self.origin.hash).len())
    }

    /// Writes a saved state to the front of `bytes`.
    ///
    /// # Errors
    /// As [`Component::get_state`]; the buffer is too small.
    pub fn serialize(&self, state: StateAddress, bytes: &mut [u8]) -> Result<(), Refusal> {
        let serialized = self.saved(state)?.to_bytes(self.origin.hash);
        let (size, length) = (bytes.len(), serialized.len());
        let room = bytes.get_mut(..length).ok_or_else(|| messages::small_buffer(size, length))?;
        room.copy_from_slice(&serialized);
        Ok(())
    }

    /// Deserializes a saved state into the host's existing state or, if `state` is NULL, into a new one.
    ///
    /// # Errors
    /// As [`Component::get_state`]; [`Instance::from_bytes`] rejects the bytes.
    pub fn deserialize(&mut self, bytes: &[u8], state: &mut StateAddress) -> Result<(), Refusal> {
        self.keep(state, Instance::from_bytes(self.instance.block(), bytes, self.origin.hash)?)
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

    /// The index of a state among the saved ones.
    fn find(&self, state: StateAddress) -> Result<usize, Refusal> {
        let place = self.saved.iter().position(|known| ptr::from_ref(&**known).cast() == state.cast_const());
        place.ok_or_else(|| messages::unknown_state().into())
    }
}

impl<B: Cyclic> Origin<B> {
    // This and what it calls are inlined so that the block is created in its component, not moved there.
    #[inline(always)]
    fn instance(&self) -> Instance<B> {
        Instance::new(B::new(&self.start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_block::{FIRST, SETUP, Sum};
    use crate::v2::Fmi2;

    fn component() -> Component<Sum> {
        Component::new(Origin { hash: Fingerprint::<Sum>::HASH, form: 0, start: StartValues::Own }, false)
    }

    #[test]
    fn a_library_opens_its_own_guid_and_no_other_without_resources() {
        let open = |value| {
            let identity = Identity { name: "guid", value, forms: Identity::GUID };
            let resources = Argument { name: "resources", value: None };
            Sum::open(identity, resources).map(|origin| origin.hash).map_err(|refusal| refusal.reason().to_string())
        };
        let own = std::ffi::CString::new(crate::table::Guid::<Sum>::TEXT).unwrap();
        assert_eq!(open(Some(&own)), Ok(Fingerprint::<Sum>::HASH));
        assert!(open(None).unwrap_err().starts_with("guid = NULL: this library is {"));
        let other = open(Some(c"{1}")).unwrap_err();
        assert!(
            other.starts_with("guid = \"{1}\": this library is {") && other.ends_with("but resources is NULL"),
            "{other}"
        );
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
        component.instance.enter_initialization_mode(&SETUP).unwrap();
        component
    }

    #[test]
    fn advice_on_the_settings_comes_with_the_restart_and_only_while_it_is_logged() {
        for (logged, expected) in [(Selection::ALL, 1), (Selection::ERRORS, 0), (Selection::NONE, 0)] {
            let mut component = initializing(logged);
            component.instance.set::<Fmi2, _>(&[FIRST], &[6]).unwrap();
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
        let expected = "communicationStepSize = 0.0005: CYCLE = 0.1 s is 200 times as long, and most steps make no \
                        call; is CYCLE given in ms instead of s?";
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
            component.keep(state, Instance::new(Sum::default())).unwrap();
        }
        assert_eq!(states.map(|state| component.find(state).unwrap()), [0, 1, 2]);
        assert!(component.find(ptr::null_mut()).unwrap_err().reason().contains("not saved by this instance"));
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
}
