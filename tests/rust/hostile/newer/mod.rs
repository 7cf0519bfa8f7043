//! The same through the door of FMI 3.0, with its 75 functions, with and without Event Mode.
//!
//! - `model.rs`: what is allowed when, and what an instance holds
//! - `typed.rs`: the types and their functions
//! - `calls.rs`: each function with its arguments and its expected answer

mod calls;
mod foreign;
mod model;
mod typed;

use crate::host::{CATEGORIES, Saved};
use crate::model::Expected;
use crate::serialized::some_state;
use blocks::Types;
use host::library::Pointer;
use host::library::v3::Library;
use model::{ALLOWED, Model, STATES};
use modeldescription::v3::token;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr;
use tests::{Fmu, Random, all_fmus, fmu_of, setting};

pub(crate) const OK: c_int = 0;
pub(crate) const ERROR: c_int = 3;

/// Functions that bring an instance on are called more often than the others.
const OFTEN: [(&str, usize); 8] = [
    ("fmi3EnterInitializationMode", 20),
    ("fmi3ExitInitializationMode", 20),
    ("fmi3EnterStepMode", 20),
    ("fmi3EnterEventMode", 8),
    ("fmi3UpdateDiscreteStates", 10),
    ("fmi3DoStep", 40),
    ("fmi3GetFMUState", 8),
    ("fmi3SerializeFMUState", 8),
];

/// What was logged: status, category, message.
type Entries = RefCell<Vec<(c_int, String, String)>>;

unsafe extern "C" fn log(environment: Pointer, status: c_int, category: *const c_char, message: *const c_char) {
    // SAFETY: the library gives strings that end with NUL.
    let [category, message] = [category, message].map(|text| unsafe { CStr::from_ptr(text) }.to_string_lossy());
    // SAFETY: the environment outlives the instance.
    let entries = unsafe { &*environment.cast::<Entries>() };
    entries.borrow_mut().push((status, category.into_owned(), message.into_owned()));
}

/// A living instance.
pub(crate) struct Slot {
    pub instance: Pointer,
    entries: Box<Entries>,
    pub has_logger: bool,
    /// The categories that are on.
    pub logged: [bool; 4],
    /// Whether it has Event Mode, and steps may return early.
    pub events: Option<bool>,
    /// The last step was so short that it is advised on, once in the life of an instance.
    pub is_step_odd: bool,
    is_step_advised: bool,
    pub model: Model,
    /// The whole instance, serialized after the last call.
    pub bytes: Vec<u8>,
    pub saved: Vec<Saved<Model>>,
    probe: Pointer,
}

/// A call on an instance: what it is drawn from, and what it has to answer.
pub(crate) struct Turn<'a> {
    pub name: &'static str,
    /// Whether it may succeed in this state.
    pub allowed: bool,
    pub random: &'a mut Random,
    pub place: usize,
    /// NULL where there is none.
    pub instance: Pointer,
    /// What the model knows of the instance before the call.
    pub model: Model,
    /// As in [`Slot`].
    pub events: Option<bool>,
}

impl Turn<'_> {
    /// The answer to a call that leaves the model as it is.
    fn unchanged(&self, status: c_int, expected: Expected, arguments: String) -> Answer {
        Answer { status, expected, arguments, after: self.model.clone() }
    }
}

/// What came of a call.
pub(crate) struct Answer {
    pub status: c_int,
    pub expected: Expected,
    pub arguments: String,
    /// What the model knows afterwards, if the call succeeded.
    pub after: Model,
}

pub(crate) struct Host<'a> {
    pub fmu: &'static Fmu,
    pub library: Library,
    pub foreign: foreign::Functions,
    pub types: Types,
    token: CString,
    pub slots: [Option<Slot>; 2],
    /// Serialized states that are good.
    pub blobs: Vec<(Vec<u8>, Model)>,
    /// That of another FMU, and one of FMI 2.0.
    pub foreign_blobs: &'a [Vec<u8>],
    /// Addresses that once were states.
    pub freed: Vec<Pointer>,
    seen: &'a mut Seen,
}

/// How often each function succeeded, and was refused, by state.
type Seen = [[[u64; 2]; STATES.len()]; ALLOWED.len()];

impl<'a> Host<'a> {
    fn new(fmu: &'static Fmu, types: Types, foreign_blobs: &'a [Vec<u8>], seen: &'a mut Seen) -> Host<'a> {
        let library = Library::open(&fmu.path).unwrap_or_else(|error| panic!("{error:#}"));
        let token = CString::new(token(&fmu.guid.to_string_lossy(), types)).unwrap();
        let slots = [const { None }; 2];
        let foreign = foreign::Functions::of(&fmu.path);
        Host { fmu, library, foreign, types, token, slots, blobs: Vec::new(), foreign_blobs, freed: Vec::new(), seen }
    }

    fn perform(&mut self, function: usize, seed: u64) {
        let random = &mut Random::new(seed);
        let place = random.below(self.slots.len());
        let (name, _) = ALLOWED[function];
        match name {
            "fmi3GetVersion" => {
                // SAFETY: it gives a string that ends with NUL.
                assert_eq!(unsafe { CStr::from_ptr((self.library.get_version)()) }, c"3.0");
            }
            "fmi3InstantiateCoSimulation" => self.instantiate(random, place),
            "fmi3InstantiateModelExchange" | "fmi3InstantiateScheduledExecution" => {
                self.foreign.instantiate(name, &self.token);
            }
            "fmi3FreeInstance" => self.free(place),
            _ if self.slots[place].is_none() && !random.once_in(4) => self.instantiate(random, place),
            _ => self.call(function, random, place),
        }
    }

    /// Frees all instances; none of them may have seen what was done to another.
    fn end(&mut self) {
        for slot in self.slots.iter().flatten() {
            assert!(self.snapshot(slot) == slot.bytes, "an instance has changed by calls on another");
        }
        (0..self.slots.len()).for_each(|place| self.free(place));
    }

    pub(crate) fn slot(&mut self, place: usize) -> &mut Slot {
        self.slots[place].as_mut().unwrap()
    }

    fn instantiate(&mut self, random: &mut Random, place: usize) {
        let entries = Box::<Entries>::default();
        let logger = random.below(12) != 0;
        let name =
            random.pick(&[Some(c"a"), Some(c"PID 1"), Some(c"Regler \u{e4} #%s%n"), Some(c"a"), Some(c""), None]);
        let wrong = [None, Some(c""), Some(c"{8c4e810f-3df3-4a00-8276-176fa3c9f000}"), Some(self.fmu.guid.as_c_str())];
        let token = if random.once_in(8) { random.pick(&wrong) } else { Some(self.token.as_c_str()) };
        let needed = self.fmu.location();
        let is_nowhere = random.once_in(12);
        let path = if needed.is_null() || is_nowhere {
            random.pick(&[ptr::null(), c"/nowhere".as_ptr(), c"\xff://%".as_ptr()])
        } else {
            needed
        };
        let (is_logging, has_events, early) = (!random.once_in(4), random.once_in(2), random.once_in(2));
        let accepted = name.is_some_and(|name| !name.is_empty())
            && token == Some(self.token.as_c_str())
            && (needed.is_null() || !is_nowhere);
        // SAFETY: every pointer is NULL or points to what the function takes.
        let instance = unsafe {
            (self.library.instantiate_co_simulation)(
                name.map_or(ptr::null(), CStr::as_ptr),
                token.map_or(ptr::null(), CStr::as_ptr),
                path,
                random.once_in(2),
                is_logging,
                has_events,
                early,
                ptr::null(),
                random.pick(&[0, 3]),
                ptr::from_ref(&*entries).cast_mut().cast(),
                logger.then_some(log as _),
                None,
            )
        };
        let told = entries.take();
        assert_eq!(!instance.is_null(), accepted, "fmi3InstantiateCoSimulation({name:?}, {token:?}): {told:?}");
        if !accepted {
            assert_eq!(told.len(), usize::from(logger), "{told:?}");
            for (status, category, message) in told {
                assert_eq!((status, category.as_str()), (ERROR, CATEGORIES[0]));
                assert!(message.len() > 35 && message.starts_with("fmi3InstantiateCoSimulation: "), "{message}");
            }
            return;
        }
        assert_eq!(told, []);
        self.free(place);
        let mut slot = Slot {
            instance,
            entries,
            has_logger: logger,
            logged: [true, is_logging, true, is_logging].map(|of| of && logger),
            events: has_events.then_some(early),
            is_step_odd: false,
            is_step_advised: false,
            model: Model::new(self.fmu, self.types),
            bytes: Vec::new(),
            saved: Vec::new(),
            probe: ptr::null_mut(),
        };
        // SAFETY: a living instance; NULL asks for a new state.
        assert_eq!(unsafe { (self.library.get_fmu_state)(instance, &raw mut slot.probe) }, OK);
        slot.bytes = self.snapshot(&slot);
        self.freed.retain(|address| *address != slot.probe);
        self.slots[place] = Some(slot);
    }

    fn free(&mut self, place: usize) {
        let slot = self.slots[place].take();
        // SAFETY: NULL, or a living instance that is not used again.
        unsafe { (self.library.free_instance)(slot.as_ref().map_or(ptr::null_mut(), |slot| slot.instance)) };
        if let Some(slot) = slot {
            self.freed.extend(slot.saved.iter().map(|saved| saved.pointer));
            self.freed.push(slot.probe);
            assert_eq!(slot.entries.take(), []);
        }
    }

    fn call(&mut self, function: usize, random: &mut Random, place: usize) {
        let (name, _) = ALLOWED[function];
        let slot = self.slots[place].as_ref();
        let instance = slot.map_or(ptr::null_mut(), |slot| slot.instance);
        let allowed = slot.is_some_and(|slot| slot.model.allows(function));
        let model = slot.map_or_else(|| Model::new(self.fmu, self.types), |slot| slot.model.clone());
        let events = slot.and_then(|slot| slot.events);
        let mut turn = Turn { name, allowed, random, place, instance, model, events };
        let answer = self.answer(&mut turn);
        let Some(mut slot) = self.slots[place].take() else {
            assert_eq!(answer.status, ERROR, "{name} without an instance");
            return;
        };
        self.check(&turn, &answer, &mut slot);
        self.seen[function][slot.model.state][usize::from(answer.status != OK)] += 1;
        if answer.status == OK {
            slot.model = answer.after;
        }
        self.slots[place] = Some(slot);
    }

    /// The right status; a reason where a call is refused, and nothing else logged; no change but what the call is for.
    fn check(&self, turn: &Turn, answer: &Answer, slot: &mut Slot) {
        let (name, status, state) = (turn.name, answer.status, &STATES[slot.model.state..=slot.model.state]);
        let what = format!("{name}({}) in state {state}, events {:?}", answer.arguments, slot.events);
        let told = slot.entries.take();
        let is_right = match answer.expected {
            Expected::Exactly(exactly) => status == exactly as c_int,
            Expected::OkOrError => status == OK || status == ERROR,
        };
        assert!(is_right, "{what}: {status}, expected {:?}; log: {told:?}; {:?}", answer.expected, slot.model);
        let advice = match name {
            _ if status != OK || !slot.logged[3] => 0..1,
            "fmi3ExitInitializationMode" => 0..usize::MAX,
            "fmi3DoStep" => {
                let is_due = slot.is_step_odd && !slot.is_step_advised;
                slot.is_step_advised |= is_due;
                usize::from(is_due)..usize::from(is_due) + 1
            }
            _ => 0..1,
        };
        let (expected, category) = match status {
            OK => (advice, 3),
            _ => (usize::from(slot.logged[0])..usize::from(slot.logged[0]) + 1, 0),
        };
        assert!(expected.contains(&told.len()), "{what}: {status}, {told:?}");
        for (of, name_of_category, message) in told {
            assert_eq!((of, name_of_category.as_str()), (status, CATEGORIES[category]), "{what}");
            let reason = message.strip_prefix(name).and_then(|rest| rest.strip_prefix(": "));
            assert!(reason.is_some_and(|reason| reason.len() > 5), "{what}: {message:?}");
        }
        let bytes = self.snapshot(slot);
        let may_change = name.starts_with("fmi3Set") && name != "fmi3SetFMUState" && name != "fmi3SetDebugLogging"
            || name.starts_with("fmi3Enter")
            || matches!(name, "fmi3ExitInitializationMode" | "fmi3Terminate" | "fmi3Reset")
            || matches!(name, "fmi3UpdateDiscreteStates" | "fmi3DoStep");
        assert!(status == OK && may_change || bytes == slot.bytes, "{what}: {status}, but something changed");
        slot.bytes = bytes;
        assert_eq!(slot.entries.take(), []);
    }

    /// The instance as bytes, taken without changing anything but the probe.
    fn snapshot(&self, slot: &Slot) -> Vec<u8> {
        let (mut probe, mut size) = (slot.probe, 0);
        // SAFETY: a living instance, a state of its own, a buffer of the size it asks for.
        unsafe {
            assert_eq!((self.library.get_fmu_state)(slot.instance, &raw mut probe), OK);
            assert_eq!((self.library.serialized_fmu_state_size)(slot.instance, probe, &raw mut size), OK);
            let mut bytes = vec![0; size];
            assert_eq!((self.library.serialize_fmu_state)(slot.instance, probe, bytes.as_mut_ptr(), size), OK);
            assert_eq!(probe, slot.probe, "fmi3GetFMUState into a state that is there gave another");
            bytes
        }
    }
}

#[test]
fn no_sequence_of_calls_breaks_a_library_of_fmi_3() {
    let all = all_fmus();
    let total = setting("PLCFMU_HOSTILE_CALLS", 1_200_000);
    let seed = setting("PLCFMU_HOSTILE_SEED", 1);
    let cases = (total / all.len() as u64 / 400).max(1) as u32;
    let mut functions: Vec<usize> = (0..ALLOWED.len()).flat_map(|function| [function; 4]).collect();
    for (name, times) in OFTEN {
        let place = ALLOWED.iter().position(|(of, _)| *of == name).unwrap();
        functions.extend(vec![place; times]);
    }
    let foreign = some_state(fmu_of("counter"));
    // A library in Rust has all types, one in C those of its FMU.
    let types = match std::env::var("PLCFMU_HOSTILE_TYPES") {
        Ok(name) => vec![Types::named(&name).expect("PLCFMU_HOSTILE_TYPES is native or wide")],
        Err(_) => Types::ALL.to_vec(),
    };
    for fmu in all {
        // With native types an array is one variable; the model knows single values.
        let names = fmu.variables.iter().map(|row| &row.name).chain(fmu.texts.iter().map(|text| &text.name));
        let has_arrays = names.into_iter().any(|name| name.ends_with(']'));
        for types in types.iter().copied().filter(|types| !(has_arrays && types.has_arrays())) {
            let foreign = [foreign.clone(), some_state(fmu)];
            let mut seen: Seen = [[[0; 2]; STATES.len()]; ALLOWED.len()];
            let config =
                Config { cases, rng_seed: RngSeed::Fixed(seed), failure_persistence: None, ..Config::default() };
            let seen_by_runner = RefCell::new(&mut seen);
            let call = (prop::sample::select(functions.clone()), any::<u64>().no_shrink());
            let result = TestRunner::new(config).run(&prop::collection::vec(call, 1..400), |calls| {
                let seen = &mut seen_by_runner.borrow_mut();
                let mut host = Host::new(fmu, types, &foreign, seen);
                calls.into_iter().for_each(|(function, seed)| host.perform(function, seed));
                host.end();
                Ok(())
            });
            if let Err(error) = result {
                panic!("{}, {types:?}, PLCFMU_HOSTILE_SEED={seed} PLCFMU_HOSTILE_CALLS={total}: {error}", fmu.package);
            }
            if total >= 1_000_000 {
                every_cell_was_tried(fmu, &seen);
            }
        }
    }
}

/// A test that never gets somewhere proves nothing there.
fn every_cell_was_tried(fmu: &Fmu, seen: &Seen) {
    for ((name, allowed), cells) in ALLOWED.iter().zip(seen) {
        if name.contains("Instantiate") || matches!(*name, "fmi3GetVersion" | "fmi3FreeInstance") {
            continue;
        }
        for (letter, [accepted, refused]) in STATES.chars().zip(cells) {
            let is_allowed = allowed.contains(letter);
            assert!(!is_allowed || *accepted > 0, "{}: {name} never succeeded in state {letter}", fmu.package);
            assert!(is_allowed || *refused > 0, "{}: {name} was never refused in state {letter}", fmu.package);
        }
    }
}
