//! Hostile calls: long random sequences of all 34 functions, in any state, with any arguments that C lets a host pass by
//! mistake. Every answer is compared with a small model, written from the standard's table of allowed calls and not from
//! the FMUs' code: the right status, a refused call changes nothing and is logged with its name and a reason, a call
//! that only reads changes nothing either, and nothing crashes.
//!
//! `PLCFMU_HOSTILE_CALLS` is the number of calls (over all libraries), `PLCFMU_HOSTILE_SEED` begins another sequence.

// A hostile host calls C functions.
#![allow(unsafe_code)]

use plcfmu::host::library::{CallbackFunctions, FUNCTIONS, Pointer};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char, c_int};
use std::fmt;
use std::ptr;
use tests::{
    Fmu, Instance, Kind, Log, Random, Role, Status, all_fmus, call_harmlessly, fmu_of, logging_callbacks, sealed,
    setting,
};

/// The states of an instance that a host can see: instantiated, Initialization Mode, stepComplete, terminated. (A step
/// is never in progress after fmi2DoStep, none fails or is canceled, and refused calls lead to no error state.)
const STATES: &str = "INCT";

/// In which of them each function is allowed: the table of the standard, 4.2.4, with the two known exceptions that Get
/// works in state instantiated and that inputs may be set there.
const ALLOWED: [(&str, &str); 34] = [
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

/// One call: which function, and from what its arguments are drawn when its turn has come.
#[derive(Clone, Copy)]
struct Call {
    function: usize,
    seed: u64,
}

impl fmt::Debug for Call {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}#{:x}", ALLOWED[self.function].0, self.seed)
    }
}

/// Functions that bring an instance on are called more often than the others.
const OFTEN: [(&str, usize); 7] = [
    ("fmi2SetupExperiment", 10),
    ("fmi2EnterInitializationMode", 10),
    ("fmi2ExitInitializationMode", 10),
    ("fmi2DoStep", 20),
    ("fmi2SetReal", 10),
    ("fmi2GetFMUstate", 4),
    ("fmi2SerializeFMUstate", 4),
];

fn any_call() -> impl Strategy<Value = Call> {
    let mut functions: Vec<usize> = (0..ALLOWED.len()).flat_map(|function| [function; 4]).collect();
    for (name, times) in OFTEN {
        functions.extend(vec![number(name); times]);
    }
    any::<u64>().no_shrink().prop_map(move |seed| {
        let mut random = Random::new(seed);
        Call { function: random.pick(&functions), seed: random.bits() }
    })
}

fn number(function: &str) -> usize {
    ALLOWED.iter().position(|(name, _)| *name == function).unwrap()
}

/// What the model knows of an instance.
#[derive(Clone, Debug)]
struct Model {
    /// The place of its state in [`STATES`].
    state: usize,
    /// Start and stop time.
    experiment: Option<(f64, f64)>,
    /// Where the furthest of the steps ended: the next may begin before it, within the tolerance.
    end: f64,
    /// What was set, by value reference.
    values: Vec<f64>,
    /// The derivatives that inputs have.
    derivatives: BTreeMap<u32, [f64; 4]>,
}

impl Model {
    fn new(fmu: &Fmu) -> Model {
        let values = fmu.variables.iter().map(|variable| variable.start).collect();
        Model { state: 0, experiment: None, end: 0.0, values, derivatives: BTreeMap::new() }
    }

    fn allows(&self, function: usize) -> bool {
        ALLOWED[function].1.contains(&STATES[self.state..=self.state])
    }
}

/// An FMU state that the host holds.
struct Saved {
    pointer: Pointer,
    model: Model,
    bytes: Vec<u8>,
}

/// A living instance.
struct Slot {
    component: Pointer,
    name: CString,
    log: Box<Log>,
    /// The categories that are on.
    logged: [bool; 3],
    model: Model,
    /// The whole instance, serialized after the last call.
    bytes: Vec<u8>,
    saved: Vec<Saved>,
    /// An FMU state that the test itself uses, to see whether something changed.
    probe: Pointer,
}

const CATEGORIES: [&str; 3] = ["logStatusError", "logStatusDiscard", "logStatusFatal"];

/// What an answer has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Expected {
    Exactly(Status),
    /// The model does not know: numbers too near to a bound, or a check that only this block makes.
    OkOrError,
}

use Expected::{Exactly, OkOrError};

fn ok_if(condition: bool) -> Expected {
    Exactly(if condition { Status::Ok } else { Status::Error })
}

/// How often each function gave a status other than fmi2Error, and fmi2Error, by state.
type Seen = [[[u64; 2]; 4]; 34];

struct Host<'a> {
    fmu: &'static Fmu,
    slots: [Option<Slot>; 3],
    /// Serialized states that are good.
    blobs: Vec<(Vec<u8>, Model)>,
    /// A good one of another FMU.
    foreign_blob: &'a [u8],
    /// Addresses that once were FMU states.
    freed: Vec<Pointer>,
    seen: &'a mut Seen,
}

/// Reals that a host passes by mistake, or that lie at a bound.
const REALS: [f64; 36] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.1,
    2.5,
    20.0,
    100.0,
    -100.0,
    27648.0,
    0.001,
    0.0005,
    0.000499,
    0.01,
    60.0,
    1e5,
    1e-300,
    2147483.647,
    2147483.6475,
    2147483.648,
    -0.001,
    3.4028234663852886e38,
    3.4028235677973362e38,
    3.4028235677973366e38,
    -3.5e38,
    1e30,
    1e300,
    -1e300,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    f64::NAN,
    -f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];

const INTEGERS: [c_int; 14] =
    [0, 1, -1, 2, 100, 27648, 32767, 32768, -32768, -32769, 65535, 65536, c_int::MAX, c_int::MIN];

fn any_real(random: &mut Random) -> f64 {
    match random.below(4) {
        0 => f64::from_bits(random.bits()),
        1 => random.between(-150.0, 150.0),
        2 => random.between(0.0, 1.0),
        _ => random.pick(&REALS),
    }
}

/// What a variable holds after it was set; `None` where that is refused.
fn held(kind: Kind, value: f64) -> Option<f64> {
    match kind {
        Kind::Real => Some(f64::from(value as f32)).filter(|held| held.is_finite()),
        Kind::LReal => Some(value).filter(|held| held.is_finite()),
        Kind::Time if (0.0..=2147483.647).contains(&value) => Some((value * 1000.0).round().abs() / 1000.0),
        Kind::Word if (-32768.0..=32767.0).contains(&value) => Some(value),
        Kind::Word if (32768.0..=65535.0).contains(&value) => Some(value - 65536.0),
        Kind::Int if (-32768.0..=32767.0).contains(&value) => Some(value),
        Kind::Time | Kind::Word | Kind::Int => None,
        Kind::Bool => Some(f64::from(u8::from(value != 0.0))),
    }
}

fn is_of(kind: Kind, function: &str) -> bool {
    match &function["fmi2Get".len()..] {
        "Real" => matches!(kind, Kind::Real | Kind::LReal | Kind::Time),
        "Integer" => matches!(kind, Kind::Word | Kind::Int),
        _ => kind == Kind::Bool,
    }
}

impl Host<'_> {
    /// Value references, mostly good ones for this function, and sometimes too many to be true.
    fn references(&self, random: &mut Random, function: &str) -> Vec<u32> {
        let variables = &self.fmu.variables;
        let fitting: Vec<u32> = (0..variables.len() as u32)
            .filter(|reference| {
                let variable = &variables[*reference as usize];
                let settable = !matches!(variable.role, Role::Output | Role::Local);
                is_of(variable.kind, function) && (settable || function.starts_with("fmi2Get"))
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
    fn state_pointer(&self, random: &mut Random, slot: usize) -> Pointer {
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
    fn serialized(&self, random: &mut Random) -> (Vec<u8>, Option<Model>) {
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

    fn perform(&mut self, call: Call) {
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
        let location = random.pick(&[ptr::null(), c"file:///nowhere".as_ptr(), c"\xff://%".as_ptr()]);
        let logging_on = random.pick(&[0, 1, 1, 1, -7]);
        let accepted =
            !no_name && !null_name && fmu_type == 1 && guid == self.fmu.guid.as_c_str() && !null_guid && has_logger;

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
            logged: [logging_on != 0; 3],
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
        let name = ALLOWED[function].0;
        let mut slot = self.slots[place].take().unwrap();
        self.slots[place] = Some(slot);
        let answer = self.answer(name, function, random, place);
        slot = self.slots[place].take().unwrap();

        let Answer { status, expected, what } = answer;
        let entries = slot.log.take();
        let right = match expected {
            Exactly(exactly) => status == exactly,
            OkOrError => matches!(status, Status::Ok | Status::Error),
        };
        assert!(right, "{what}: {status:?}, expected {expected:?}; log: {entries:?}; {:?}", slot.model);
        self.seen[function][what.state][usize::from(status == Status::Error)] += 1;

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
        } else {
            assert_eq!(entries, [], "{what}");
        }

        let mut bytes = Vec::with_capacity(slot.bytes.len());
        self.snapshot(&slot, &mut bytes);
        match name {
            _ if status != Status::Ok => assert!(bytes == slot.bytes, "{what} was refused but changed something"),
            "fmi2SetupExperiment" | "fmi2EnterInitializationMode" | "fmi2ExitInitializationMode" | "fmi2Terminate" => {}
            "fmi2Reset" | "fmi2DoStep" | "fmi2SetReal" | "fmi2SetInteger" | "fmi2SetBoolean" => {}
            "fmi2SetFMUstate" => assert!(bytes == slot.bytes, "{what} restored another state"),
            "fmi2SetRealInputDerivatives" => {}
            _ => assert!(bytes == slot.bytes, "{what} changed something"),
        }
        if name == "fmi2Reset" {
            assert!(bytes == Instance::new(self.fmu).bytes(), "{what}: not as after fmi2Instantiate");
        }
        slot.bytes = bytes;
        assert_eq!(slot.log.take(), []);
        self.slots[place] = Some(slot);
    }

    /// Draws the arguments, calls, checks what the call wrote, and keeps the model up with it.
    fn answer(&mut self, name: &'static str, function: usize, random: &mut Random, place: usize) -> Answer {
        let slot = self.slots[place].as_ref().unwrap();
        let (library, component) = (&self.fmu.library, slot.component);
        let model = slot.model.clone();
        let allowed = model.allows(function);
        let mut after = model.clone();
        let mut what = What { name, state: model.state, arguments: String::new() };
        let expected;
        let status: Status;
        match name {
            "fmi2SetDebugLogging" => {
                let texts = [c"logStatusError", c"logStatusDiscard", c"logStatusFatal", c"logAll", c""];
                let chosen: Vec<usize> = (0..random.below(4)).map(|_| random.pick(&[0, 0, 1, 1, 2, 3, 4, 5])).collect();
                let pointers: Vec<*const c_char> =
                    chosen.iter().map(|choice| texts.get(*choice).map_or(ptr::null(), |text| text.as_ptr())).collect();
                let (count, null) = count_of(random, chosen.len());
                let on = random.pick(&[0, 1, 1, -1]);
                let categories = if null { ptr::null() } else { pointers.as_ptr() };
                expected = ok_if(
                    allowed
                        && good_array(count, chosen.len(), null)
                        && chosen[..count.min(chosen.len())].iter().all(|choice| *choice < 3),
                );
                // SAFETY: as many strings as counted, or counts and pointers that are to be refused.
                status = unsafe { (library.set_debug_logging)(component, on, count, categories) }.into();
                what.arguments = format!("{on}, {count}, {chosen:?}");
                if status == Status::Ok {
                    let slot = self.slots[place].as_mut().unwrap();
                    let named = |category: &usize| count == 0 || chosen[..count].contains(category);
                    for category in 0..3 {
                        slot.logged[category] = on != 0 && named(&category);
                    }
                }
            }
            "fmi2SetupExperiment" => {
                let start = match random.below(3) {
                    0 => any_real(random),
                    _ => random.pick(&[0.0, 0.0, 1234.5, -5.0, 1e5, 1e7, 1e9, -1e9, 1e12, 1e18, 1e300]),
                };
                let cycle = model.values[self.fmu.cycle as usize].max(0.001);
                let stop = match random.below(6) {
                    0 => any_real(random),
                    1 => start,
                    2 => start + 20.0 * cycle,
                    _ => start + 1e6 * cycle,
                };
                let defined = random.pick(&[0, 0, 1, -1]);
                let good_stop = defined == 0 || stop >= start;
                expected = ok_if(allowed && start.is_finite() && good_stop);
                let tolerance = any_real(random);
                // SAFETY: a living component.
                status = unsafe { (library.setup_experiment)(component, 1, tolerance, start, defined, stop) }.into();
                what.arguments = format!("{start:?}, {defined}, {stop:?}");
                after.experiment = Some((start, if defined != 0 { stop } else { f64::INFINITY }));
            }
            "fmi2EnterInitializationMode" => {
                expected = ok_if(allowed && model.experiment.is_some());
                // SAFETY: a living component.
                status = unsafe { (library.enter_initialization_mode)(component) }.into();
                after.state = 1;
            }
            "fmi2ExitInitializationMode" => {
                let whole_cycle = model.values[self.fmu.cycle as usize] >= 0.001;
                expected = if allowed && whole_cycle { OkOrError } else { Exactly(Status::Error) };
                // SAFETY: a living component.
                status = unsafe { (library.exit_initialization_mode)(component) }.into();
                after.state = 2;
                after.end = model.experiment.map_or(0.0, |experiment| experiment.0);
            }
            "fmi2Terminate" => {
                expected = ok_if(allowed);
                // SAFETY: a living component.
                status = unsafe { (library.terminate)(component) }.into();
                after.state = 3;
            }
            "fmi2Reset" => {
                expected = ok_if(allowed);
                // SAFETY: a living component.
                status = unsafe { (library.reset)(component) }.into();
                after = Model::new(self.fmu);
            }
            "fmi2GetReal" | "fmi2GetInteger" | "fmi2GetBoolean" => {
                let references = self.references(random, name);
                let (count, vr_null) = count_of(random, references.len());
                let value_null = random.once_in(16);
                let vr = if vr_null { ptr::null() } else { references.as_ptr() };
                let good = good_array(count, references.len(), vr_null || value_null);
                let variable = |reference: &u32| self.fmu.variables.get(*reference as usize);
                let fit = references[..count.min(references.len())]
                    .iter()
                    .all(|reference| variable(reference).is_some_and(|variable| is_of(variable.kind, name)));
                expected = ok_if(allowed && good && fit);
                let mut reals = [4711.5; 8];
                let mut integers = [-4711; 8];
                let to_real = if value_null { ptr::null_mut() } else { reals.as_mut_ptr() };
                let to_integer = if value_null { ptr::null_mut() } else { integers.as_mut_ptr() };
                // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
                status = unsafe {
                    match name {
                        "fmi2GetReal" => (library.get_real)(component, vr, count, to_real),
                        "fmi2GetInteger" => (library.get_integer)(component, vr, count, to_integer),
                        _ => (library.get_boolean)(component, vr, count, to_integer),
                    }
                }
                .into();
                what.arguments = format!("{references:?}, {count}");
                let written = if status == Status::Ok { count } else { 0 };
                assert!(reals[written..].iter().all(|real| *real == 4711.5), "{what} wrote behind its array");
                assert!(integers[written..].iter().all(|integer| *integer == -4711), "{what} wrote behind its array");
                for (place, reference) in references[..written].iter().enumerate() {
                    let variable = &self.fmu.variables[*reference as usize];
                    let got = if name == "fmi2GetReal" { reals[place] } else { f64::from(integers[place]) };
                    assert!(got != -4711.0 && got != 4711.5, "{what} has not written {}", variable.name);
                    if name == "fmi2GetBoolean" {
                        assert!(got == 0.0 || got == 1.0, "{what}: {} = {got}", variable.name);
                    }
                    if !matches!(variable.role, Role::Output | Role::Local) {
                        let held = model.values[*reference as usize];
                        assert!(got.to_bits() == held.to_bits(), "{what}: {} = {got:?}, not {held:?}", variable.name);
                    }
                }
            }
            "fmi2SetReal" | "fmi2SetInteger" | "fmi2SetBoolean" => {
                let references = self.references(random, name);
                let (count, vr_null) = count_of(random, references.len());
                let value_null = random.once_in(16);
                // Mostly values that fit, so that something is set.
                let start = |reference: &u32| self.fmu.variables.get(*reference as usize).map_or(0.0, |v| v.start);
                let reals: Vec<f64> = references
                    .iter()
                    .map(|reference| match random.below(4) {
                        0 => any_real(random),
                        1 => start(reference),
                        _ => random.between(0.0, 5.0),
                    })
                    .collect();
                let integers: Vec<c_int> = references
                    .iter()
                    .map(|_| match random.below(4) {
                        0 => random.pick(&INTEGERS),
                        1 => random.bits() as c_int,
                        _ => random.below(200) as c_int - 50,
                    })
                    .collect();
                let given =
                    |place: usize| if name == "fmi2SetReal" { reals[place] } else { f64::from(integers[place]) };
                let fit = (0..count.min(references.len())).all(|place| {
                    self.fmu.variables.get(references[place] as usize).is_some_and(|variable| {
                        is_of(variable.kind, name)
                            && match variable.role {
                                Role::Input | Role::Parameter => true,
                                Role::Fixed | Role::Cycle => model.state < 2,
                                Role::Output | Role::Local => false,
                            }
                            && held(variable.kind, given(place)).is_some()
                    })
                });
                expected = ok_if(allowed && good_array(count, references.len(), vr_null || value_null) && fit);
                let vr = if vr_null { ptr::null() } else { references.as_ptr() };
                let from_reals = if value_null { ptr::null() } else { reals.as_ptr() };
                let from_integers = if value_null { ptr::null() } else { integers.as_ptr() };
                // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
                status = unsafe {
                    match name {
                        "fmi2SetReal" => (library.set_real)(component, vr, count, from_reals),
                        "fmi2SetInteger" => (library.set_integer)(component, vr, count, from_integers),
                        _ => (library.set_boolean)(component, vr, count, from_integers),
                    }
                }
                .into();
                what.arguments = format!("{references:?}, {count}, {reals:?}, {integers:?}");
                if status == Status::Ok {
                    for (place, reference) in references[..count].iter().enumerate() {
                        let kind = self.fmu.variables[*reference as usize].kind;
                        after.values[*reference as usize] = held(kind, given(place)).unwrap();
                    }
                }
            }
            "fmi2GetString" | "fmi2SetString" => {
                let references = self.references(random, "fmi2GetReal");
                let (count, null) = count_of(random, references.len());
                let vr = if null { ptr::null() } else { references.as_ptr() };
                let mut texts = [c"text".as_ptr(); 8];
                expected = ok_if(allowed && count == 0);
                // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
                status = unsafe {
                    match name {
                        "fmi2GetString" => (library.get_string)(component, vr, count, texts.as_mut_ptr()),
                        _ => (library.set_string)(component, vr, count, texts.as_ptr()),
                    }
                }
                .into();
                assert!(texts.iter().all(|text| *text == c"text".as_ptr()), "{what} wrote a text");
                what.arguments = format!("{references:?}, {count}");
            }
            "fmi2GetFMUstate" => {
                let full = slot.saved.len() >= 12;
                let mut pointer =
                    if full || random.once_in(3) { self.state_pointer(random, place) } else { ptr::null_mut() };
                let before = pointer;
                let null = random.once_in(16);
                let known = slot.saved.iter().position(|saved| saved.pointer == pointer);
                expected = ok_if(allowed && !null && (pointer.is_null() || known.is_some()));
                let target = if null { ptr::null_mut() } else { &raw mut pointer };
                // SAFETY: NULL or a variable of the host; the address in it is only compared.
                status = unsafe { (library.get_fmu_state)(component, target) }.into();
                what.arguments = format!("{before:?}");
                if status == Status::Ok {
                    let slot = self.slots[place].as_mut().unwrap();
                    let state = Saved { pointer, model: model.clone(), bytes: slot.bytes.clone() };
                    assert!(!pointer.is_null() && (before.is_null() || before == pointer), "{what} gave {pointer:?}");
                    match known {
                        Some(known) => slot.saved[known] = state,
                        None => slot.saved.push(state),
                    }
                    self.freed.retain(|address| *address != pointer);
                } else {
                    assert_eq!(pointer, before, "{what} was refused but gave a state");
                }
            }
            "fmi2SetFMUstate" => {
                let pointer = self.state_pointer(random, place);
                let known = slot.saved.iter().position(|saved| saved.pointer == pointer);
                expected = ok_if(allowed && known.is_some());
                // SAFETY: the address is only compared.
                status = unsafe { (library.set_fmu_state)(component, pointer) }.into();
                what.arguments = format!("{pointer:?}");
                if let (Status::Ok, Some(known)) = (status, known) {
                    let slot = self.slots[place].as_mut().unwrap();
                    after = slot.saved[known].model.clone();
                    slot.bytes = slot.saved[known].bytes.clone();
                }
            }
            "fmi2FreeFMUstate" => {
                let mut pointer = self.state_pointer(random, place);
                let before = pointer;
                let null = random.once_in(16);
                let known = slot.saved.iter().position(|saved| saved.pointer == pointer);
                expected = ok_if(allowed && !null && (pointer.is_null() || known.is_some()));
                let target = if null { ptr::null_mut() } else { &raw mut pointer };
                // SAFETY: NULL or a variable of the host; the address in it is only compared.
                status = unsafe { (library.free_fmu_state)(component, target) }.into();
                what.arguments = format!("{before:?}");
                if status == Status::Ok {
                    assert!(pointer.is_null(), "{what} left the address of a freed state");
                    if let Some(known) = known {
                        self.slots[place].as_mut().unwrap().saved.remove(known);
                        self.freed.push(before);
                    }
                } else {
                    assert_eq!(pointer, before, "{what} was refused but changed the address");
                }
            }
            "fmi2SerializedFMUstateSize" | "fmi2SerializeFMUstate" => {
                let pointer = self.state_pointer(random, place);
                let known = slot.saved.iter().find(|saved| saved.pointer == pointer);
                let null = random.once_in(16);
                let length = known.map_or(300, |saved| saved.bytes.len());
                what.arguments = format!("{pointer:?}");
                if name == "fmi2SerializedFMUstateSize" {
                    let mut size = 4711;
                    let target = if null { ptr::null_mut() } else { &raw mut size };
                    expected = ok_if(allowed && known.is_some() && !null);
                    // SAFETY: NULL or a variable of the host; the address is only compared.
                    status = unsafe { (library.serialized_fmu_state_size)(component, pointer, target) }.into();
                    assert_eq!(size, if status == Status::Ok { length } else { 4711 }, "{what}");
                } else {
                    let size = match random.below(6) {
                        0 => random.below(length),
                        1 => length + random.below(9),
                        2 => usize::MAX,
                        _ => length,
                    };
                    let too_many = size > isize::MAX as usize;
                    let mut room = vec![0xAA; if too_many { 0 } else { size }];
                    let target = if null { ptr::null_mut() } else { room.as_mut_ptr() };
                    expected = ok_if(allowed && known.is_some() && !null && size >= length && !too_many);
                    // SAFETY: as many bytes as said, or counts and pointers that are to be refused.
                    status = unsafe { (library.serialize_fmu_state)(component, pointer, target, size) }.into();
                    what.arguments = format!("{pointer:?}, {size}");
                    if let (Status::Ok, Some(saved)) = (status, known) {
                        assert!(room[..length] == saved.bytes, "{what}: the state's bytes have changed");
                        assert!(room[length..].iter().all(|byte| *byte == 0xAA), "{what} wrote behind the state");
                        let blob = (saved.bytes.clone(), saved.model.clone());
                        if self.blobs.len() < 8 {
                            self.blobs.push(blob);
                        } else {
                            let place = random.below(8);
                            self.blobs[place] = blob;
                        }
                    } else {
                        assert!(room.iter().all(|byte| *byte == 0xAA), "{what} was refused but wrote");
                    }
                }
            }
            "fmi2DeSerializeFMUstate" => {
                let (bytes, good) = self.serialized(random);
                let full = slot.saved.len() >= 12;
                let mut pointer =
                    if full || random.once_in(3) { self.state_pointer(random, place) } else { ptr::null_mut() };
                let before = pointer;
                let (null, null_target) = (random.once_in(16), random.once_in(16));
                let size = if random.once_in(16) { usize::MAX } else { bytes.len() };
                let known = slot.saved.iter().position(|saved| saved.pointer == pointer);
                let good_target = !null_target && (pointer.is_null() || known.is_some());
                expected = ok_if(allowed && good.is_some() && !null && size == bytes.len() && good_target);
                let target = if null_target { ptr::null_mut() } else { &raw mut pointer };
                let from = if null { ptr::null() } else { bytes.as_ptr() };
                // SAFETY: as many bytes as said, or counts and pointers that are to be refused; the address in the
                // variable is only compared.
                status = unsafe { (library.deserialize_fmu_state)(component, from, size, target) }.into();
                what.arguments = format!("{bytes:?}, {size}, {before:?}");
                if let (Status::Ok, Some(good)) = (status, good) {
                    assert!(!pointer.is_null() && (before.is_null() || before == pointer), "{what} gave {pointer:?}");
                    let slot = self.slots[place].as_mut().unwrap();
                    let state = Saved { pointer, model: good, bytes };
                    match known {
                        Some(known) => slot.saved[known] = state,
                        None => slot.saved.push(state),
                    }
                    self.freed.retain(|address| *address != pointer);
                } else {
                    assert_eq!(pointer, before, "{what} was refused but gave a state");
                }
            }
            "fmi2GetDirectionalDerivative" => {
                let references = [0, 1, u32::MAX];
                let (known, mut unknown) = ([1.0; 3], [4711.5; 3]);
                let count = random.below(4);
                expected = Exactly(Status::Error);
                // SAFETY: as many elements as counted.
                status = unsafe {
                    (library.get_directional_derivative)(
                        component,
                        references.as_ptr(),
                        count,
                        references.as_ptr(),
                        count,
                        known.as_ptr(),
                        unknown.as_mut_ptr(),
                    )
                }
                .into();
                assert_eq!(unknown, [4711.5; 3], "{what} was refused but wrote");
            }
            "fmi2SetRealInputDerivatives" => {
                let references = self.references(random, "fmi2SetReal");
                let (count, vr_null) = count_of(random, references.len());
                let (orders_null, values_null) = (random.once_in(16), random.once_in(16));
                let orders: Vec<c_int> = references
                    .iter()
                    .map(|_| random.pick(&[1, 1, 1, 1, 2, 3, 4, 4, 0, 5, -1, c_int::MAX, c_int::MIN]))
                    .collect();
                let values: Vec<f64> =
                    references
                        .iter()
                        .map(|_| {
                            if random.once_in(4) {
                                any_real(random)
                            } else {
                                random.pick(&[0.0, -0.0, 0.5, -2.0, 10.0])
                            }
                        })
                        .collect();
                let used = count.min(references.len());
                let fit = (0..used).all(|place| {
                    let variable = self.fmu.variables.get(references[place] as usize);
                    variable.is_some_and(|variable| {
                        variable.role == Role::Input && matches!(variable.kind, Kind::Real | Kind::LReal)
                    }) && (1..=4).contains(&orders[place])
                        && values[place].is_finite()
                });
                let good = good_array(count, references.len(), vr_null || orders_null || values_null);
                expected = ok_if(allowed && good && fit);
                let or_null = |null: bool, pointer: *const c_int| if null { ptr::null() } else { pointer };
                let vr = if vr_null { ptr::null() } else { references.as_ptr() };
                let from = if values_null { ptr::null() } else { values.as_ptr() };
                // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
                status = unsafe {
                    let orders = or_null(orders_null, orders.as_ptr());
                    (library.set_real_input_derivatives)(component, vr, count, orders, from)
                }
                .into();
                what.arguments = format!("{references:?}, {count}, {orders:?}, {values:?}");
                if status == Status::Ok {
                    for place in 0..used {
                        let derivatives = after.derivatives.entry(references[place]).or_default();
                        derivatives[orders[place] as usize - 1] = values[place];
                    }
                    after.derivatives.retain(|_, derivatives| *derivatives != [0.0; 4]);
                }
            }
            "fmi2GetRealOutputDerivatives" => {
                let count = random.below(3);
                let (references, orders, mut values) = ([0; 3], [1; 3], [4711.5; 3]);
                expected = ok_if(allowed && count == 0);
                // SAFETY: as many elements as counted.
                status = unsafe {
                    let (vr, orders) = (references.as_ptr(), orders.as_ptr());
                    (library.get_real_output_derivatives)(component, vr, count, orders, values.as_mut_ptr())
                }
                .into();
                assert_eq!(values, [4711.5; 3], "{what} has nothing to write");
                what.arguments = format!("{count}");
            }
            "fmi2DoStep" => {
                let (tc, h) = self.time(random, &model);
                expected = if allowed { self.step(&model, tc, h) } else { Exactly(Status::Error) };
                // SAFETY: a living component.
                status = unsafe { (library.do_step)(component, tc, h, random.pick(&[0, 1])) }.into();
                what.arguments = format!("{tc:?}, {h:?}");
                after.end = after.end.max(tc + h);
            }
            "fmi2CancelStep" => {
                expected = Exactly(Status::Error);
                // SAFETY: a living component.
                status = unsafe { (library.cancel_step)(component) }.into();
            }
            _ => {
                let kind = random.pick(&[0, 1, 2, 2, 3, 3, 4, -1, c_int::MAX]);
                let null = random.once_in(8);
                let (mut real, mut integer, mut text) = (4711.5, -4711, ptr::null());
                let to_integer = if null { ptr::null_mut() } else { &raw mut integer };
                let to_real = if null { ptr::null_mut() } else { &raw mut real };
                let to_text = if null { ptr::null_mut() } else { &raw mut text };
                let answered = matches!((name, kind), ("fmi2GetRealStatus", 2) | ("fmi2GetBooleanStatus", 3));
                expected = Exactly(match (allowed && !null, answered) {
                    (false, _) => Status::Error,
                    (true, true) => Status::Ok,
                    (true, false) => Status::Discard,
                });
                // SAFETY: NULL, which is to be refused, or the host's variable.
                status = unsafe {
                    match name {
                        "fmi2GetStatus" => (library.get_status)(component, kind, to_integer),
                        "fmi2GetRealStatus" => (library.get_real_status)(component, kind, to_real),
                        "fmi2GetIntegerStatus" => (library.get_integer_status)(component, kind, to_integer),
                        "fmi2GetBooleanStatus" => (library.get_boolean_status)(component, kind, to_integer),
                        _ => (library.get_string_status)(component, kind, to_text),
                    }
                }
                .into();
                what.arguments = format!("{kind}");
                let is_ok = status == Status::Ok;
                let expected_real = if is_ok && name == "fmi2GetRealStatus" { model.end } else { 4711.5 };
                let expected_integer = if is_ok && name == "fmi2GetBooleanStatus" { 0 } else { -4711 };
                assert_eq!((real.to_bits(), integer), (expected_real.to_bits(), expected_integer), "{what}");
                assert!(text.is_null(), "{what} wrote a text");
            }
        }
        if status == Status::Ok {
            self.slots[place].as_mut().unwrap().model = after;
        }
        Answer { status, expected, what }
    }

    /// A point and a step: what a host would go on with, and what it gets wrong.
    fn time(&self, random: &mut Random, model: &Model) -> (f64, f64) {
        let cycle = model.values[self.fmu.cycle as usize].max(0.001);
        let end = model.end;
        let h = match random.below(12) {
            0 => random.pick(&[0.0, -0.0, -cycle, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, f64::MAX]),
            1 => random.pick(&[1e-16, 5e-324, cycle * 1e-9, cycle * 1e10]),
            2 => random.between(0.0, 5.0) * cycle,
            3 => cycle * 20.0,
            4 => any_real(random),
            _ => cycle * random.pick(&[1.0, 1.0, 1.0, 0.1, 1.0 / 3.0, 2.0]),
        };
        let tc = match random.below(12) {
            0 => random.pick(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 0.0, -1.0]),
            1 => end - cycle * random.pick(&[0.5, 1.0, 3.0, 1e6]),
            2 => end + cycle * random.pick(&[1.0, 0.25, 20.0, 1e10]),
            3 => end * (1.0 + f64::EPSILON),
            4 => any_real(random),
            _ => end,
        };
        // No step that would take long: few calls, or too many to be made at all.
        let calls = (tc + h - end) / cycle;
        if (100.0..1e10).contains(&calls) { (end, cycle) } else { (tc, h) }
    }

    /// What a step has to answer in state stepComplete.
    fn step(&self, model: &Model, tc: f64, h: f64) -> Expected {
        let (start, stop) = model.experiment.unwrap();
        let cycle = model.values[self.fmu.cycle as usize];
        if !(h > 0.0 && h.is_finite() && tc.is_finite()) {
            return Exactly(Status::Error);
        }
        // 2^47 CYCLEs from 0 a double no longer tells the calls apart.
        let far = start.abs().max(tc.abs()) / cycle / 2f64.powi(47);
        // How much two times may differ that are one.
        let same = 1e-6 * cycle + 4.0 * f64::EPSILON * start.abs().max(tc.abs());
        let behind = model.end - tc;
        let beyond = tc + h - stop;
        // `time` leaves out what lies in between.
        let too_many = (tc + h - model.end) / cycle >= 1e10;
        if far > 1.01 || behind > 2.0 * same || beyond > 2.0 * same + 0.26 * cycle || too_many {
            return Exactly(Status::Error);
        }
        let extreme = model.derivatives.iter().any(|(reference, derivatives)| {
            let largest = if self.fmu.variables[*reference as usize].kind == Kind::Real { 1e37 } else { 1e300 };
            model.values[*reference as usize].abs() > largest || derivatives.iter().any(|order| order.abs() > 1e4)
        });
        if far > 0.98 || behind > 0.5 * same || beyond > 0.5 * same || extreme {
            return OkOrError;
        }
        Exactly(Status::Ok)
    }
}

/// A call as it is shown where it was answered wrongly.
struct What {
    name: &'static str,
    state: usize,
    arguments: String,
}

impl fmt::Display for What {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}({}) in state {}", self.name, self.arguments, &STATES[self.state..=self.state])
    }
}

struct Answer {
    status: Status,
    expected: Expected,
    what: What,
}

/// The count that goes with an array of this length, and whether NULL stands for the array.
fn count_of(random: &mut Random, length: usize) -> (usize, bool) {
    let count = match random.below(24) {
        0 => 0,
        1 => random.pick(&[usize::MAX, isize::MAX as usize, usize::MAX / 2 + 1]),
        _ => length,
    };
    (count, random.once_in(16))
}

fn good_array(count: usize, length: usize, null: bool) -> bool {
    count == 0 || count <= length && !null
}

/// A state of this library after some steps.
fn some_state(fmu: &'static Fmu) -> Vec<u8> {
    let instance = Instance::running(fmu, 1.0, Some(1e6));
    for reference in 0..fmu.variables.len() as u32 {
        instance.try_set(reference, 1.0);
    }
    let cycle = instance.value(fmu.cycle);
    for k in 0..5 {
        assert_eq!(instance.step(1.0 + f64::from(k) * cycle, cycle), Status::Ok, "{:?}", instance.log.take());
    }
    if let Some(input) =
        fmu.variables.iter().find(|variable| variable.role == Role::Input && variable.kind == Kind::Real)
    {
        assert_eq!(instance.set_derivative(&input.name, 1, 0.5), Status::Ok);
    }
    instance.bytes()
}

#[test]
fn the_model_knows_all_34_functions() {
    let names: Vec<&str> = ALLOWED.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, FUNCTIONS);
}

#[test]
fn no_sequence_of_calls_breaks_a_library() {
    let all_fmus = all_fmus();
    let total = setting("PLCFMU_HOSTILE_CALLS", 1_200_000);
    let seed = setting("PLCFMU_HOSTILE_SEED", 1);
    // Sequences are 1 to 400 calls long.
    let cases = (total / all_fmus.len() as u64 / 200).max(1) as u32;
    let foreign_blob = some_state(fmu_of("counter"));
    for fmu in all_fmus {
        let mut seen: Seen = [[[0; 2]; 4]; 34];
        let config = Config {
            cases,
            rng_seed: RngSeed::Fixed(seed),
            failure_persistence: None,
            max_shrink_iters: 20_000,
            ..Config::default()
        };
        let seen_by_runner = std::cell::RefCell::new(&mut seen);
        let result = TestRunner::new(config).run(&prop::collection::vec(any_call(), 1..400), |calls| {
            let mut host = Host {
                fmu,
                slots: [const { None }; 3],
                blobs: Vec::new(),
                foreign_blob: &foreign_blob,
                freed: Vec::new(),
                seen: &mut seen_by_runner.borrow_mut(),
            };
            for call in calls {
                host.perform(call);
            }
            // No instance has seen what was done to another.
            for slot in host.slots.iter().flatten() {
                let mut bytes = Vec::new();
                host.snapshot(slot, &mut bytes);
                assert!(bytes == slot.bytes, "an instance has changed by calls on another");
            }
            (0..host.slots.len()).for_each(|place| host.free(place));
            Ok(())
        });
        if let Err(error) = result {
            panic!("{}, PLCFMU_HOSTILE_SEED={seed} PLCFMU_HOSTILE_CALLS={total}: {error}", fmu.package);
        }
        let calls: u64 = seen.iter().flatten().flatten().sum();
        println!("{}: {calls} calls on instances", fmu.package);
        if total >= 1_000_000 {
            every_cell_was_tried(fmu, &seen);
        }
    }
}

/// A test that never gets somewhere proves nothing there.
fn every_cell_was_tried(fmu: &Fmu, seen: &Seen) {
    for (function, (name, allowed)) in ALLOWED.iter().enumerate() {
        if matches!(*name, "fmi2GetTypesPlatform" | "fmi2GetVersion" | "fmi2Instantiate" | "fmi2FreeInstance") {
            continue;
        }
        for (state, letter) in STATES.chars().enumerate() {
            let [accepted, refused] = seen[function][state];
            let accepts = allowed.contains(letter) && *name != "fmi2GetDirectionalDerivative";
            let has =
                |suffix: &str| fmu.variables.iter().any(|variable| is_of(variable.kind, &format!("fmi2Get{suffix}")));
            assert!(!accepts || accepted > 0, "{}: {name} never succeeded in state {letter}", fmu.package);
            let never_fails = matches!(*name, "fmi2Reset" | "fmi2Terminate") && allowed.contains(letter);
            assert!(
                never_fails || refused > 0 || !has("Real"),
                "{}: {name} never failed in state {letter}",
                fmu.package
            );
        }
    }
}

#[test]
fn a_serialized_state_with_any_byte_changed_is_refused_and_changes_nothing() {
    for fmu in all_fmus() {
        let good = some_state(fmu);
        let instance = Instance::running(fmu, 0.0, None);
        let before = instance.bytes();
        let mut damaged = good.clone();
        for place in 0..good.len() {
            for change in [0x01, 0x02, 0x04, 0x08, 0x10, 0x20, 0x40, 0x80, 0xFF] {
                damaged[place] = good[place] ^ change;
                refused(&instance, &damaged, &format!("byte {place} of {}, changed by {change:#x}", good.len()));
            }
            damaged[place] = good[place];
        }
        assert!(instance.bytes() == before, "{}: a refused state changed something", fmu.package);
        let mut state = ptr::null_mut();
        assert_eq!(instance.deserialize(&good, &mut state), Status::Ok);
    }
}

#[test]
fn a_serialized_state_of_any_other_length_is_refused() {
    for fmu in all_fmus() {
        let good = some_state(fmu);
        let instance = Instance::running(fmu, 0.0, None);
        for length in 0..good.len() {
            refused(&instance, &good[..length], &format!("{length} bytes of {}", good.len()));
        }
        for more in 1..64 {
            for filler in [0, 0xFF, good[0]] {
                let mut longer = good.clone();
                longer.extend(vec![filler; more]);
                refused(&instance, &longer, &format!("{more} bytes more than {}", good.len()));
            }
        }
        refused(&instance, &[good.as_slice(), &good].concat(), "twice the state");
    }
}

#[test]
fn a_serialized_state_of_another_fmu_is_refused_by_name() {
    let states: Vec<_> = all_fmus().into_iter().map(|fmu| (fmu, some_state(fmu))).collect();
    let counter = fmu_of("counter");
    for (of, state) in states.iter().chain(&[(counter, some_state(counter))]) {
        for (fmu, _) in states.iter().filter(|(fmu, _)| fmu.package != of.package) {
            let instance = Instance::new(fmu);
            let text = refused(&instance, state, &format!("a state of {}", of.name));
            assert!(text.contains(&fmu.name), "{text}");
        }
    }
}

fn refused(instance: &Instance, bytes: &[u8], what: &str) -> String {
    let mut state = ptr::null_mut();
    let status = instance.deserialize(bytes, &mut state);
    let log = instance.log.take();
    assert!(status == Status::Error && state.is_null(), "{}: {what}: {status:?}", instance.fmu.package);
    assert_eq!(log.len(), 1, "{}: {what}: {log:?}", instance.fmu.package);
    assert!(log[0].text.starts_with("fmi2DeSerializeFMUstate: "), "{what}: {log:?}");
    log[0].text.clone()
}

#[test]
fn a_forged_state_with_a_right_checksum_is_refused_or_runs_without_harm() {
    for fmu in all_fmus() {
        let good = some_state(fmu);
        let content = &good[..good.len() - 16];
        assert!(sealed(content.to_vec()) == good, "{}: this is not the checksum", fmu.package);
        let instance = Instance::running(fmu, 0.0, None);
        for place in 0..content.len() {
            for change in [0x01, 0x80, 0xFF, 0x40, 0x7F] {
                let mut forged = content.to_vec();
                forged[place] ^= change;
                let mut state = ptr::null_mut();
                match instance.deserialize(&sealed(forged), &mut state) {
                    // Magic, version, GUID and length have one right value each.
                    Status::Ok => {
                        assert!(place >= 8 + 16 + 8, "{}: byte {place} ^ {change:#x} is accepted", fmu.package);
                        assert_eq!(instance.restore(state), Status::Ok);
                        instance.forget(&mut state);
                        use_up(&instance);
                    }
                    status => assert_eq!(status, Status::Error, "{}: byte {place} ^ {change:#x}", fmu.package),
                }
                instance.log.take();
            }
        }
        for length in 0..content.len() {
            refused(&instance, &sealed(content[..length].to_vec()), &format!("the first {length} bytes, sealed"));
        }
        let longer = sealed([content, &[0]].concat());
        refused(&instance, &longer, "one byte more, sealed");
    }
}

/// Sets, extrapolates and steps at random, and gives all values after each step.
fn random_steps(instance: &Instance, random: &mut Random, tc: &mut f64, steps: usize) -> Vec<Vec<u64>> {
    let fmu = instance.fmu;
    let cycle = instance.value(fmu.cycle);
    (0..steps)
        .map(|_| {
            for _ in 0..3 {
                let reference = random.below(fmu.variables.len());
                let variable = &fmu.variables[reference];
                // What cannot be set is refused, here as there.
                instance.try_set(reference as u32, random.between(0.0, 90.0));
                if variable.role == Role::Input && variable.kind == Kind::Real {
                    let order = 1 + random.below(4) as c_int;
                    assert_eq!(instance.set_derivative(&variable.name, order, random.between(-1.0, 1.0)), Status::Ok);
                }
            }
            let h = cycle * random.pick(&[1.0, 1.0, 0.1, 1.0 / 3.0, 6.0]);
            assert_eq!(instance.step(*tc, h), Status::Ok, "{:?}", instance.log.take());
            *tc += h;
            instance.values()
        })
        .collect()
}

#[test]
fn a_restored_state_goes_on_bit_for_bit_as_the_one_it_was_saved_from() {
    for fmu in all_fmus() {
        for seed in 0..20 {
            let random = &mut Random::new(seed);
            let start = random.pick(&[0.0, 1234.5, 1e7, -3.0]);
            let instance = Instance::running(fmu, start, Some(start + 1e9));
            let mut tc = start;
            random_steps(&instance, random, &mut tc, 30);
            let mut state = ptr::null_mut();
            instance.save(&mut state);
            let bytes = instance.serialize(state);

            let run = |instance: &Instance| {
                let values = random_steps(instance, &mut random.clone(), &mut tc.clone(), 30);
                (values, instance.bytes())
            };
            let went_on = run(&instance);
            assert_eq!(instance.restore(state), Status::Ok);
            assert!(run(&instance) == went_on, "{}, seed {seed}: restored", fmu.package);
            let other = Instance::new(fmu);
            let mut elsewhere = ptr::null_mut();
            assert_eq!(other.deserialize(&bytes, &mut elsewhere), Status::Ok);
            assert_eq!(other.restore(elsewhere), Status::Ok);
            assert!(run(&other) == went_on, "{}, seed {seed}: restored in another instance", fmu.package);
        }
    }
}

/// Uses an instance in whatever state it is. What it answers is its own matter; that it answers is the point.
fn use_up(instance: &Instance) {
    instance.enter_initialization_mode();
    instance.exit_initialization_mode();
    let cycle = instance.value(instance.fmu.cycle);
    let mut end = 0.0;
    // SAFETY: a living component and the host's variable.
    unsafe { (instance.fmu.library.get_real_status)(instance.component, 2, &raw mut end) };
    for k in 0..3 {
        let status = instance.step(end + f64::from(k) * cycle, cycle);
        assert!(matches!(status, Status::Ok | Status::Error), "{:?}", instance.log.take());
    }
    instance.values();
    instance.bytes();
}
