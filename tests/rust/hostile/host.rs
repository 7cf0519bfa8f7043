//! The hostile host: three instances of one FMU, what it does to them, and what it checks after every call.

use crate::calls::{Answer, Turn, What};
use crate::model::{ALLOWED, Expected, Model, STATES, is_of};
use host::library::{CallbackFunctions, Pointer};
use std::ffi::{CStr, CString, c_char, c_int};
use std::fmt;
use std::ptr;
use tests::{Entry, Fmu, Instance, Log, Random, Status, call_harmlessly, logging_callbacks};

/// One call: which function, and from what its arguments are drawn when its turn has come.
#[derive(Clone, Copy)]
pub(crate) struct Call {
    pub function: usize,
    pub seed: u64,
}

impl fmt::Debug for Call {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}#{:x}", ALLOWED[self.function].0, self.seed)
    }
}

/// An FMU state that the host holds, with what a model knows of it.
pub(crate) struct Saved<M = Model> {
    pub pointer: Pointer,
    pub model: M,
    pub bytes: Vec<u8>,
}

/// A living instance.
pub(crate) struct Slot {
    pub component: Pointer,
    name: CString,
    log: Box<Log>,
    /// The categories that are on.
    pub logged: [bool; 4],
    /// The last step was so short that it is advised on, once in the life of an instance.
    pub is_step_odd: bool,
    is_step_advised: bool,
    /// Whether it was said that a variable of another type counts as a Real.
    is_conversion_advised: bool,
    pub model: Model,
    /// The whole instance, serialized after the last call.
    pub bytes: Vec<u8>,
    pub saved: Vec<Saved>,
    /// An FMU state that the test itself uses, to see whether something changed.
    probe: Pointer,
}

pub(crate) const CATEGORIES: [&str; 4] = ["logStatusError", "logStatusDiscard", "logStatusFatal", "logAdvice"];
const ADVICE: usize = 3;

/// How often each function gave a status other than fmi2Error, and fmi2Error, by state.
pub(crate) type Seen = [[[u64; 2]; STATES.len()]; 34];

pub(crate) struct Host<'a> {
    pub fmu: &'static Fmu,
    pub slots: [Option<Slot>; 3],
    /// Serialized states that are good.
    pub blobs: Vec<(Vec<u8>, Model)>,
    /// A good one of another FMU.
    foreign_blob: &'a [u8],
    /// Addresses that once were FMU states.
    pub freed: Vec<Pointer>,
    seen: &'a mut Seen,
}

impl<'a> Host<'a> {
    /// A host without instances.
    pub(crate) fn new(fmu: &'static Fmu, foreign_blob: &'a [u8], seen: &'a mut Seen) -> Host<'a> {
        Host { fmu, slots: [const { None }; 3], blobs: Vec::new(), foreign_blob, freed: Vec::new(), seen }
    }

    /// Calls, and checks the answer.
    pub(crate) fn perform(&mut self, call: Call) {
        let random = &mut Random::new(call.seed);
        let place = random.below(self.slots.len());
        match ALLOWED[call.function].0 {
            "fmi2GetTypesPlatform" | "fmi2GetVersion" => self.versions(),
            "fmi2Instantiate" => self.instantiate(random, place),
            "fmi2FreeInstance" => self.free(place),
            _ if self.slots[place].is_none() && !random.once_in(4) => self.instantiate(random, place),
            _ if self.slots[place].is_none() => self.null_component(call.function),
            _ => self.call(call.function, random, place),
        }
    }

    /// Frees all instances; none of them may have seen what was done to another.
    pub(crate) fn end(&mut self) {
        for slot in self.slots.iter().flatten() {
            let mut bytes = Vec::new();
            self.snapshot(slot, &mut bytes);
            assert!(bytes == slot.bytes, "an instance has changed by calls on another");
        }
        (0..self.slots.len()).for_each(|place| self.free(place));
    }

    /// The living instance at a place.
    pub(crate) fn slot(&mut self, place: usize) -> &mut Slot {
        self.slots[place].as_mut().unwrap()
    }

    fn versions(&self) {
        // SAFETY: both give a string that ends with NUL.
        unsafe {
            assert_eq!(CStr::from_ptr((self.fmu.library.get_types_platform)()), c"default");
            assert_eq!(CStr::from_ptr((self.fmu.library.get_version)()), c"2.0");
        }
    }

    fn instantiate(&mut self, random: &mut Random, place: usize) {
        let log = Box::<Log>::default();
        let good = logging_callbacks(&log);
        let without_logger = CallbackFunctions { logger: None, ..good };
        let no_name = random.once_in(12);
        let name = CString::new(if no_name { "" } else { random.pick(&["a", "PID 1", "Regler äöü #%s%n"]) }).unwrap();
        let null_name = random.once_in(12);
        let fmu_type = if random.once_in(12) { random.pick(&[0, 2, -1, c_int::MAX]) } else { 1 };
        let guid = if random.once_in(12) {
            random.pick(&[c"", c"{8c4e810f-3df3-4a00-8276-176fa3c9f000}"])
        } else {
            &self.fmu.guid
        };
        let null_guid = random.once_in(12);
        let (callbacks, has_logger) = match random.below(12) {
            0 => (ptr::null(), false),
            1 => (&raw const without_logger, false),
            _ => (&raw const good, true),
        };
        // A block needs no resources.
        let needed = self.fmu.location();
        let wrong_location = random.once_in(12);
        let location = if needed.is_null() || wrong_location {
            random.pick(&[ptr::null(), c"file:///nowhere".as_ptr(), c"\xff://%".as_ptr()])
        } else {
            needed
        };
        let logging_on = random.pick(&[0, 1, 1, 1, -7]);
        let accepted = !no_name
            && !null_name
            && fmu_type == 1
            && guid == self.fmu.guid.as_c_str()
            && !null_guid
            && has_logger
            && (needed.is_null() || !wrong_location);

        let or_null = |null: bool, text: *const c_char| if null { ptr::null() } else { text };
        // SAFETY: every pointer is NULL or points to what the function takes.
        let component = unsafe {
            (self.fmu.library.instantiate)(
                or_null(null_name, name.as_ptr()),
                fmu_type,
                or_null(null_guid, guid.as_ptr()),
                location,
                callbacks,
                random.pick(&[0, 1]),
                logging_on,
            )
        };
        assert_eq!(!component.is_null(), accepted, "fmi2Instantiate({name:?}, {fmu_type}, {guid:?})");
        let entries = log.take();
        if !accepted {
            assert_eq!(entries.len(), usize::from(has_logger), "fmi2Instantiate: {entries:?}");
            for entry in entries {
                assert_eq!((entry.status, entry.category.as_str()), (Status::Error, "logStatusError"));
                assert!(entry.text.len() > "fmi2Instantiate: ".len() && entry.text.starts_with("fmi2Instantiate: "));
            }
            return;
        }
        assert_eq!(entries, []);
        self.free(place);
        let mut slot = Slot {
            component,
            name,
            log,
            // Errors and fatal ones are logged in any case.
            logged: [true, logging_on != 0, true, logging_on != 0],
            is_step_odd: false,
            is_step_advised: false,
            is_conversion_advised: false,
            model: Model::new(self.fmu),
            bytes: Vec::new(),
            saved: Vec::new(),
            probe: ptr::null_mut(),
        };
        // SAFETY: a living component; NULL asks for a new state.
        assert_eq!(unsafe { (self.fmu.library.get_fmu_state)(component, &raw mut slot.probe) }, 0);
        let mut bytes = Vec::new();
        self.snapshot(&slot, &mut bytes);
        slot.bytes = bytes;
        self.freed.retain(|address| *address != slot.probe);
        self.slots[place] = Some(slot);
    }

    fn free(&mut self, place: usize) {
        let slot = self.slots[place].take();
        let component = slot.as_ref().map_or(ptr::null_mut(), |slot| slot.component);
        // SAFETY: NULL, or a living component that is not used again.
        unsafe { (self.fmu.library.free_instance)(component) };
        if let Some(slot) = slot {
            self.freed.extend(slot.saved.iter().map(|saved| saved.pointer));
            self.freed.push(slot.probe);
            assert_eq!(slot.log.take(), []);
        }
    }

    /// The functions without an instance: they refuse, and have nothing to log to.
    fn null_component(&self, function: usize) {
        let name = ALLOWED[function].0;
        assert_eq!(call_harmlessly(self.fmu, name, ptr::null_mut()), Status::Error, "{name} with a NULL component");
    }

    /// A call on a living instance.
    fn call(&mut self, function: usize, random: &mut Random, place: usize) {
        let slot = self.slot(place);
        let model = slot.model.clone();
        let (name, allowed) = (ALLOWED[function].0, model.allows(function));
        let mut turn = Turn { name, allowed, random, place, component: slot.component, model };
        let answer = self.answer(&mut turn);
        let mut slot = self.slots[place].take().unwrap();
        self.check(&turn, &answer, &mut slot);
        self.seen[function][turn.model.state][usize::from(answer.status == Status::Error)] += 1;
        if answer.status == Status::Ok {
            slot.model = answer.after;
        }
        self.slots[place] = Some(slot);
    }

    /// The right status; a reason where a call is refused, and nothing else logged; no change but what the call is for.
    fn check(&self, turn: &Turn, answer: &Answer, slot: &mut Slot) {
        let (name, status, what) = (turn.name, answer.status, turn.with(&answer.arguments));
        let entries = slot.log.take();
        let right = match answer.expected {
            Expected::Exactly(exactly) => status == exactly,
            Expected::OkOrError => matches!(status, Status::Ok | Status::Error),
        };
        assert!(right, "{what}: {status:?}, expected {:?}; log: {entries:?}; {:?}", answer.expected, turn.model);

        if status == Status::Ok {
            check_advice(name, slot, &entries, &what);
        }
        let category = match status {
            Status::Ok => None,
            Status::Discard => Some(1),
            _ => Some(0),
        };
        if let Some(category) = category.filter(|category| slot.logged[*category]) {
            assert_eq!(entries.len(), 1, "{what}: {entries:?}");
            let entry = &entries[0];
            assert_eq!((entry.status, entry.category.as_str()), (status, CATEGORIES[category]), "{what}");
            assert_eq!((entry.instance.as_bytes(), entry.format.as_str()), (slot.name.as_bytes(), "%s"), "{what}");
            let reason = entry.text.strip_prefix(name).and_then(|rest| rest.strip_prefix(": "));
            assert!(reason.is_some_and(|reason| reason.len() > 5), "{what}: {entry:?}");
        } else if status != Status::Ok {
            assert_eq!(entries, [], "{what}");
        }

        let mut bytes = Vec::with_capacity(slot.bytes.len());
        self.snapshot(slot, &mut bytes);
        match name {
            _ if status != Status::Ok => assert!(bytes == slot.bytes, "{what} was refused but changed something"),
            "fmi2SetupExperiment" | "fmi2EnterInitializationMode" | "fmi2ExitInitializationMode" | "fmi2Terminate" => {}
            "fmi2Reset" | "fmi2DoStep" | "fmi2SetReal" | "fmi2SetInteger" | "fmi2SetBoolean" => {}
            "fmi2SetString" => {}
            "fmi2SetFMUstate" => assert!(bytes == slot.bytes, "{what} restored another state"),
            "fmi2SetRealInputDerivatives" => {}
            _ => assert!(bytes == slot.bytes, "{what} changed something"),
        }
        if name == "fmi2Reset" {
            assert!(bytes == Instance::new(self.fmu).bytes(), "{what}: not as after fmi2Instantiate");
        }
        slot.bytes = bytes;
        assert_eq!(slot.log.take(), []);
    }

    /// The instance as bytes, taken without changing anything but the probe.
    fn snapshot(&self, slot: &Slot, bytes: &mut Vec<u8>) {
        let (library, mut probe, mut size) = (&self.fmu.library, slot.probe, 0);
        // SAFETY: a living component, a state of its own, a buffer of the size it asks for.
        unsafe {
            assert_eq!((library.get_fmu_state)(slot.component, &raw mut probe), 0);
            assert_eq!((library.serialized_fmu_state_size)(slot.component, probe, &raw mut size), 0);
            bytes.resize(size, 0);
            assert_eq!((library.serialize_fmu_state)(slot.component, probe, bytes.as_mut_ptr(), size), 0);
        }
        assert_eq!(probe, slot.probe, "fmi2GetFMUstate into a state that is there gave another");
    }

    /// Value references, mostly good ones for this function, and sometimes too many to be true.
    pub(crate) fn references(&self, random: &mut Random, function: &str) -> Vec<u32> {
        let variables = &self.fmu.variables;
        let fitting: Vec<u32> = (0..variables.len() as u32)
            .filter(|reference| {
                let variable = &variables[*reference as usize];
                is_of(variable.kind, function) && (variable.role.is_settable() || function.starts_with("fmi2Get"))
            })
            .collect();
        let length = random.below(6);
        (0..length)
            .map(|_| match random.below(12) {
                0 => random.below(variables.len()) as u32,
                1 => [variables.len() as u32, u32::MAX, 1 << 31, random.bits() as u32][random.below(4)],
                _ if fitting.is_empty() => 0,
                _ => random.pick(&fitting),
            })
            .collect()
    }

    /// An address for an FMU state: a good one of this instance, and what else a host may mix it up with.
    pub(crate) fn state_pointer(&self, random: &mut Random, slot: usize) -> Pointer {
        let own = &self.slots[slot].as_ref().unwrap().saved;
        let others: Vec<Pointer> =
            self.slots.iter().flatten().flat_map(|other| other.saved.iter().map(|saved| saved.pointer)).collect();
        match random.below(8) {
            0 => ptr::null_mut(),
            1 => random.pick(&[1, 8, 0x1000, usize::MAX, usize::MAX - 7]) as Pointer,
            2 if !self.freed.is_empty() => random.pick(&self.freed),
            3 if !others.is_empty() => random.pick(&others),
            _ if own.is_empty() => ptr::null_mut(),
            _ => own[random.below(own.len())].pointer,
        }
    }

    /// Bytes to restore from, with the model that belongs to them if they are good.
    pub(crate) fn serialized(&self, random: &mut Random) -> (Vec<u8>, Option<Model>) {
        if self.blobs.is_empty() || random.once_in(16) {
            return (random.pick(&[self.foreign_blob, &[], &[0; 400], b"plcfmu"]).to_vec(), None);
        }
        let (mut bytes, model) = self.blobs[random.below(self.blobs.len())].clone();
        match random.below(6) {
            0 => {
                for _ in 0..=random.below(4) {
                    let place = random.below(bytes.len());
                    bytes[place] ^= 1 + random.below(255) as u8;
                }
                // Two changes may have taken each other back.
                let good = self.blobs.iter().any(|(good, _)| *good == bytes);
                (bytes, good.then_some(model))
            }
            1 => {
                bytes.truncate(random.below(bytes.len()));
                (bytes, None)
            }
            2 => {
                bytes.extend(vec![random.bits() as u8; 1 + random.below(9)]);
                (bytes, None)
            }
            _ => (bytes, Some(model)),
        }
    }
}

/// Advice comes with the restart, as often as the block likes, once with an odd step, and once with a variable that is converted to
/// or from a Real; nothing else is logged where a call succeeds.
fn check_advice(name: &str, slot: &mut Slot, entries: &[Entry], what: &What) {
    let is_due = name == "fmi2DoStep" && slot.is_step_odd && !slot.is_step_advised && slot.logged[ADVICE];
    let may_advise = name == "fmi2ExitInitializationMode" && slot.logged[ADVICE];
    let may_convert = name.ends_with("Real") && !slot.is_conversion_advised && slot.logged[ADVICE];
    let is_converted = may_convert && entries.len() == 1;
    assert!(may_advise || is_converted || entries.len() == usize::from(is_due), "{what}: {entries:?}");
    slot.is_step_advised |= is_due;
    slot.is_conversion_advised |= is_converted;
    for entry in entries {
        assert_eq!((entry.status, entry.category.as_str()), (Status::Ok, CATEGORIES[ADVICE]), "{what}");
        let advice = entry.text.strip_prefix(name).and_then(|rest| rest.strip_prefix(": "));
        assert!(advice.is_some_and(|advice| advice.len() > 5), "{what}: {entry:?}");
    }
}
