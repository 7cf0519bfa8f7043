//! A block that panics: the call answers fmi2Fatal and says so, the instance is locked until it is freed, and the host
//! and all other instances go on.

// A host calls C functions.
#![allow(unsafe_code)]

use host::library::FUNCTIONS;
use std::ffi::c_int;
use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tests::{Instance, Log, Status, call_harmlessly, fmu_of, logging_callbacks};

/// A new block panics once, whoever asks for it, after an instance armed that: tests take turns.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner)
}

const CLONE: f64 = 1.0;
const DROP: f64 = 2.0;
const WRITE: f64 = 3.0;
const READ: f64 = 4.0;
const NEW: f64 = 5.0;

fn new() -> Instance {
    Instance::new(fmu_of("panicking"))
}

fn running() -> Instance {
    Instance::running(fmu_of("panicking"), 0.0, None)
}

/// Runs with a fuse in its memory, after one call.
fn armed(fuse: f64) -> Instance {
    let instance = running();
    instance.set("ARM", fuse);
    assert_eq!(instance.step(0.0, 1.0), Status::Ok);
    instance
}

/// The call has answered fmi2Fatal, and said why.
fn fatal(instance: &Instance, status: Status, function: &str, words: &str) {
    assert_eq!(status, Status::Fatal, "{function}");
    let log = instance.log.take();
    assert_eq!(log.len(), 1, "{function}: {log:?}");
    assert_eq!((log[0].status, log[0].category.as_str()), (Status::Fatal, "logStatusFatal"));
    assert!(log[0].text.starts_with(&format!("{function}: ")), "{log:?}");
    assert!(log[0].text.contains(words), "{:?} does not say {words:?}", log[0].text);
}

/// Every function but fmi2FreeInstance refuses.
fn locked(instance: &Instance) {
    let others = ["fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2Instantiate", "fmi2FreeInstance"];
    for function in FUNCTIONS.iter().filter(|function| !others.contains(function)) {
        let status = call_harmlessly(instance.fmu, function, instance.component);
        fatal(instance, status, function, "locked");
    }
}

#[test]
fn a_panic_in_the_law_is_fatal_and_locks_the_instance() {
    let _alone = alone();
    let instance = running();
    instance.set("AT_CALL", 3.0);
    assert_eq!(instance.step(0.0, 2.0), Status::Ok);
    fatal(&instance, instance.step(2.0, 1.0), "fmi2DoStep", "panic in the block: call");
    locked(&instance);
}

#[test]
fn a_panic_in_the_middle_of_a_long_step_is_no_different() {
    let _alone = alone();
    let instance = running();
    instance.set("AT_CALL", 500.0);
    fatal(&instance, instance.step(0.0, 1000.0), "fmi2DoStep", "panic in the block: call");
    locked(&instance);
}

#[test]
fn a_panic_in_the_restart_is_fatal_and_locks_the_instance() {
    let _alone = alone();
    let instance = new();
    instance.set("IN_RESTART", 1.0);
    instance.setup_experiment(0.0, None);
    instance.enter_initialization_mode();
    fatal(&instance, instance.exit_initialization_mode(), "fmi2ExitInitializationMode", "panic in the block: restart");
    locked(&instance);
}

#[test]
fn a_panic_in_the_check_of_the_parameters_is_fatal_and_locks_the_instance() {
    let _alone = alone();
    let instance = new();
    instance.set("IN_CHECK", 1.0);
    instance.setup_experiment(0.0, None);
    instance.enter_initialization_mode();
    fatal(&instance, instance.exit_initialization_mode(), "fmi2ExitInitializationMode", "panic in the block: check");
    locked(&instance);
}

#[test]
fn a_panic_in_the_restart_that_initialization_mode_reads_is_fatal_and_locks_the_instance() {
    let _alone = alone();
    for (input, words) in [("IN_RESTART", "panic in the block: restart"), ("IN_CHECK", "panic in the block: check")] {
        let instance = new();
        instance.set(input, 1.0);
        instance.setup_experiment(0.0, None);
        instance.enter_initialization_mode();
        assert_eq!(instance.get(input), 1.0, "an input is read without a restart");
        let (references, mut value) = ([instance.fmu.reference("CALLS")], 7.0);
        let get_real = instance.fmu.library.get_real;
        // SAFETY: a living component, one reference and one value.
        let status = unsafe { get_real(instance.component, references.as_ptr(), 1, &raw mut value) };
        fatal(&instance, status.into(), "fmi2GetReal", words);
        assert_eq!(value, 7.0);
        locked(&instance);
    }
}

#[test]
fn a_block_that_panics_in_its_restart_and_again_when_it_is_dropped_does_not_end_the_host() {
    let _alone = alone();
    let bytes = {
        let instance = new();
        instance.setup_experiment(0.0, None);
        instance.enter_initialization_mode();
        instance.set("IN_RESTART", 1.0);
        instance.bytes()
    };
    let (instance, mut state) = (running(), ptr::null_mut());
    assert_eq!(instance.deserialize(&with_fuse(&bytes, DROP), &mut state), Status::Ok);
    assert_eq!(instance.restore(state), Status::Ok);
    let (references, mut value) = ([instance.fmu.reference("CALLS")], 7.0);
    let get_real = instance.fmu.library.get_real;
    // SAFETY: a living component, one reference and one value.
    let status = unsafe { get_real(instance.component, references.as_ptr(), 1, &raw mut value) };
    fatal(&instance, status.into(), "fmi2GetReal", "panic in the block: restart");
    locked(&instance);
}

#[test]
fn a_panic_while_a_state_is_saved_is_fatal_and_locks_the_instance() {
    let _alone = alone();
    let instance = armed(CLONE);
    let mut state = ptr::null_mut();
    // SAFETY: a living component and the host's variable.
    let status = unsafe { (instance.fmu.library.get_fmu_state)(instance.component, &raw mut state) };
    fatal(&instance, status.into(), "fmi2GetFMUstate", "panic in the block: clone");
    assert!(state.is_null(), "a state was given");
    locked(&instance);
}

#[test]
fn a_panic_while_a_state_is_restored_is_fatal_and_locks_the_instance() {
    let _alone = alone();
    // Deserialized: a state that was saved by cloning would have panicked then.
    let (plain, instance) = (armed(0.0).bytes(), running());
    let mut state = ptr::null_mut();
    assert_eq!(instance.deserialize(&with_fuse(&plain, CLONE), &mut state), Status::Ok);
    fatal(&instance, instance.restore(state), "fmi2SetFMUstate", "panic in the block: clone");
    locked(&instance);
}

#[test]
fn a_panic_while_a_state_is_serialized_is_fatal_and_locks_the_instance() {
    let _alone = alone();
    for function in ["fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate"] {
        let instance = armed(WRITE);
        let (mut state, mut size, mut bytes) = (ptr::null_mut(), 0, [0xAA; 1000]);
        instance.save(&mut state);
        let (library, component) = (&instance.fmu.library, instance.component);
        // SAFETY: a living component, a state of its own, the host's variables.
        let status = unsafe {
            if function == "fmi2SerializeFMUstate" {
                (library.serialize_fmu_state)(component, state, bytes.as_mut_ptr(), bytes.len())
            } else {
                (library.serialized_fmu_state_size)(component, state, &raw mut size)
            }
        };
        fatal(&instance, status.into(), function, "panic in the block: write");
        assert!(bytes == [0xAA; 1000] && size == 0, "{function} wrote");
        locked(&instance);
    }
}

#[test]
fn a_panic_while_a_state_is_deserialized_is_fatal_and_locks_the_instance() {
    let _alone = alone();
    let bytes = armed(READ).bytes();
    let instance = running();
    let mut state = ptr::null_mut();
    fatal(&instance, instance.deserialize(&bytes, &mut state), "fmi2DeSerializeFMUstate", "panic in the block: read");
    assert!(state.is_null(), "a state was given");
    locked(&instance);
}

#[test]
fn a_panic_while_an_old_state_is_dropped_is_fatal_and_locks_the_instance() {
    let _alone = alone();
    let instance = armed(DROP);
    fatal(&instance, instance.reset(), "fmi2Reset", "panic in the block: drop");
    locked(&instance);

    let instance = armed(DROP);
    let mut state = ptr::null_mut();
    instance.save(&mut state);
    // SAFETY: a living component and a state of its own.
    let status = unsafe { (instance.fmu.library.free_fmu_state)(instance.component, &raw mut state) };
    fatal(&instance, status.into(), "fmi2FreeFMUstate", "panic in the block: drop");
    locked(&instance);

    let (instance, bytes) = (running(), with_fuse(&armed(0.0).bytes(), DROP));
    let mut state = ptr::null_mut();
    instance.save(&mut state);
    assert_eq!(instance.deserialize(&bytes, &mut state), Status::Ok, "into the place of a good one");
    fatal(&instance, instance.deserialize(&bytes, &mut state), "fmi2DeSerializeFMUstate", "block: drop");
    locked(&instance);
}

#[test]
fn freeing_an_instance_all_of_whose_states_panic_when_they_are_dropped_leaves_the_host_alive() {
    let _alone = alone();
    let instance = armed(DROP);
    for _ in 0..5 {
        instance.save(&mut ptr::null_mut());
    }
    drop(instance);
}

#[test]
fn a_panic_while_an_instance_is_made_gives_none_and_is_logged() {
    let _alone = alone();
    armed(NEW);
    let fmu = fmu_of("panicking");
    let log = Log::default();
    let callbacks = logging_callbacks(&log);
    // Logging is off: why there is no instance is logged all the same.
    let instantiate = || {
        let callbacks = &raw const callbacks;
        // SAFETY: all pointers point to what the function takes.
        unsafe { (fmu.library.instantiate)(c"x".as_ptr(), 1, fmu.guid.as_ptr(), ptr::null(), callbacks, 0, 0) }
    };
    assert!(instantiate().is_null());
    let entries = log.take();
    assert_eq!(entries.len(), 1, "{entries:?}");
    assert_eq!((entries[0].status, entries[0].category.as_str()), (Status::Fatal, "logStatusFatal"));
    assert!(entries[0].text.starts_with("fmi2Instantiate: panic in the block: a new block"), "{entries:?}");

    let component = instantiate();
    assert!(!component.is_null(), "and the next one is made");
    // SAFETY: a living component.
    unsafe { (fmu.library.free_instance)(component) };
}

#[test]
fn a_panic_while_an_instance_is_reset_is_fatal_and_locks_it() {
    let _alone = alone();
    let instance = armed(NEW);
    fatal(&instance, instance.reset(), "fmi2Reset", "panic in the block: a new block");
    locked(&instance);
}

#[test]
fn whatever_a_block_panics_with_the_message_can_be_logged() {
    let _alone = alone();
    let messages = [
        (0.0, "panic in the block: call;"),
        // `#` would refer to a variable, a NUL would end the text.
        (1.0, "panic in the block: call ##1  %s;"),
        (2.0, "panic in the block: no message;"),
        (3.0, "panic in the block: no message;"),
    ];
    for (payload, message) in messages {
        let instance = running();
        instance.set("AT_CALL", 1.0);
        instance.set("PAYLOAD", payload);
        fatal(&instance, instance.step(0.0, 1.0), "fmi2DoStep", message);
        locked(&instance);
    }
}

#[test]
fn with_logging_off_a_panic_is_fatal_and_silent() {
    let _alone = alone();
    let instance = running();
    instance.set("AT_CALL", 1.0);
    // SAFETY: a living component.
    let status = unsafe { (instance.fmu.library.set_debug_logging)(instance.component, 0, 0, ptr::null()) };
    assert_eq!(Status::from(status), Status::Ok);
    assert_eq!(instance.step(0.0, 1.0), Status::Fatal);
    assert_eq!(instance.step(1.0, 1.0), Status::Fatal);
    assert_eq!(instance.log.take(), []);
}

#[test]
fn what_a_locked_instance_was_asked_for_is_not_written() {
    let _alone = alone();
    let instance = running();
    instance.set("AT_CALL", 1.0);
    fatal(&instance, instance.step(0.0, 1.0), "fmi2DoStep", "panic");
    let reference = instance.fmu.reference("CALLS");
    let (mut value, mut status): (f64, c_int) = (4711.5, -4711);
    // SAFETY: a living component, one reference, one value.
    unsafe {
        (instance.fmu.library.get_real)(instance.component, &raw const reference, 1, &raw mut value);
        (instance.fmu.library.get_status)(instance.component, 0, &raw mut status);
    }
    assert_eq!((value, status), (4711.5, -4711));
}

#[test]
fn other_instances_of_the_library_do_not_notice() {
    let _alone = alone();
    let (other, never) = (running(), running());
    for k in 0..10 {
        let panicking = running();
        panicking.set("AT_CALL", 1.0);
        assert_eq!(panicking.step(0.0, 1.0), Status::Fatal);
        assert_eq!(other.step(f64::from(k), 1.0), Status::Ok);
        assert_eq!(panicking.step(1.0, 1.0), Status::Fatal);
    }
    assert_eq!(never.step(0.0, 10.0), Status::Ok);
    assert_eq!(other.values(), never.values());
    assert_eq!(other.log.take(), []);
}

#[test]
fn panics_on_several_threads_at_once_stay_where_they_are() {
    let _alone = alone();
    std::thread::scope(|scope| {
        for thread in 0..8 {
            scope.spawn(move || {
                let good = running();
                for k in 0..200 {
                    let panicking = running();
                    panicking.set("AT_CALL", f64::from(1 + (k + thread) % 5));
                    panicking.set("PAYLOAD", f64::from(k % 4));
                    fatal(&panicking, panicking.step(0.0, 5.0), "fmi2DoStep", "panic in the block");
                    assert_eq!(good.step(f64::from(k), 1.0), Status::Ok);
                }
                assert_eq!(good.get("CALLS"), 200.0);
                assert_eq!(good.log.take(), []);
            });
        }
    });
}

/// The same state with another fuse in its memory: it is the last thing before the checksum.
fn with_fuse(state: &[u8], fuse: f64) -> Vec<u8> {
    let mut content = state[..state.len() - 16].to_vec();
    let place = content.len() - 2;
    content[place..].copy_from_slice(&(fuse as i16).to_le_bytes());
    tests::sealed(content)
}
