//! FMU states as bytes: only those that this FMU has written are taken, and then it goes on as before.

use std::ffi::c_int;
use std::ptr;
use tests::{Fmu, Instance, Kind, Random, Role, Status, all_fmus, fmu_of, sealed};

/// A state of this library after some steps.
pub(crate) fn some_state(fmu: &'static Fmu) -> Vec<u8> {
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
