//! Hostile calls: long random sequences of all 34 functions, in any state, with any arguments that C lets a host pass by
//! mistake. Every answer is compared with a small model: the right status, a refused call changes nothing and is logged
//! with its name and a reason, a call that only reads changes nothing either, and nothing crashes.
//!
//! - `model.rs`: what is allowed when, and what an instance holds
//! - `host.rs`: three instances, and what is checked after every call
//! - `calls/`: each function with its arguments and its expected answer
//! - `serialized.rs`: damaged, foreign and forged FMU states
//! - `newer/`: the same for the 75 functions of FMI 3.0
//!
//! `PLCFMU_HOSTILE_CALLS` is the number of calls (over all libraries), `PLCFMU_HOSTILE_SEED` begins another sequence, `PLCFMU_HOSTILE_TYPES` names
//! the types that the libraries have in FMI 3.0, if they have one choice.

#![allow(clippy::unwrap_used)]
// A hostile host calls C functions.
#![allow(unsafe_code)]

mod calls;
mod host;
mod model;
mod newer;
mod numbers;
mod serialized;

use ::host::library::FUNCTIONS;
use host::{Call, Host, Seen};
use model::{ALLOWED, STATES, is_of, number};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use serialized::some_state;
use tests::{Fmu, Random, all_fmus, fmu_of, setting};

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
        let mut seen: Seen = [[[0; 2]; STATES.len()]; 34];
        let config = Config {
            cases,
            rng_seed: RngSeed::Fixed(seed),
            failure_persistence: None,
            max_shrink_iters: 20_000,
            ..Config::default()
        };
        let seen_by_runner = std::cell::RefCell::new(&mut seen);
        let result = TestRunner::new(config).run(&prop::collection::vec(any_call(), 1..400), |calls| {
            let seen = &mut seen_by_runner.borrow_mut();
            let mut host = Host::new(fmu, &foreign_blob, seen);
            for call in calls {
                host.perform(call);
            }
            host.end();
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
