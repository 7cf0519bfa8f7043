//! Many instances on many threads: each computes bit for bit what it computes alone.

// FMU states are addresses, which Rust does not let go to another thread unasked.
#![allow(unsafe_code)]

use host::library::Pointer;
use std::ptr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use tests::{Fmu, Instance, Kind, Random, Role, Status, all_fmus, fmu_of, setting};

const INSTANCES: usize = 64;
const THREADS: usize = 8;

/// The life of one instance after another: everything in it is drawn from one seed, so that it can be lived again.
struct Life {
    fmu: &'static Fmu,
    random: Random,
    instance: Option<Instance>,
    now: f64,
    /// FMU states with the time that belongs to them.
    saved: Vec<(Pointer, f64)>,
    /// A hash of every value that was seen.
    seen: u64,
    steps: u64,
}

// SAFETY: the states belong to the instance, which goes to the other thread with them.
unsafe impl Send for Life {}

impl Life {
    fn new(fmu: &'static Fmu, seed: u64) -> Life {
        Life { fmu, random: Random::new(seed), instance: None, now: 0.0, saved: Vec::new(), seen: seed, steps: 0 }
    }

    /// A little of it.
    fn go_on(&mut self, events: usize) {
        for _ in 0..events {
            self.event();
        }
    }

    fn event(&mut self) {
        let random = &mut self.random;
        let Some(instance) = &self.instance else {
            let instance = Instance::new(self.fmu);
            self.now = random.pick(&[0.0, 1234.5, 1e5]);
            instance.initialize(self.now, None);
            self.instance = Some(instance);
            return;
        };
        match random.below(40) {
            0 => {
                self.saved.clear();
                self.instance = None;
            }
            1 => {
                assert_eq!(instance.reset(), Status::Ok);
                self.now = 0.0;
                instance.initialize(self.now, None);
            }
            2 | 3 if self.saved.len() < 4 => {
                let mut state: Pointer = ptr::null_mut();
                instance.save(&mut state);
                self.saved.push((state, self.now));
            }
            4 | 5 if !self.saved.is_empty() => {
                let (state, then) = self.saved[random.below(self.saved.len())];
                assert_eq!(instance.restore(state), Status::Ok);
                self.now = then;
            }
            6 if !self.saved.is_empty() => {
                let (mut state, _) = self.saved.swap_remove(random.below(self.saved.len()));
                instance.forget(&mut state);
            }
            7 => {
                let (bytes, mut state) = (instance.bytes(), ptr::null_mut());
                assert_eq!(instance.deserialize(&bytes, &mut state), Status::Ok);
                assert_eq!(instance.restore(state), Status::Ok);
                instance.forget(&mut state);
            }
            8..20 => {
                let reference = random.below(self.fmu.variables.len());
                let variable = &self.fmu.variables[reference];
                let value = match variable.kind {
                    Kind::Real | Kind::LReal => random.between(-120.0, 120.0),
                    Kind::Time => random.between(0.001, 60.0),
                    Kind::Word | Kind::Int => random.between(-30000.0, 30000.0),
                    Kind::Bool => random.below(2) as f64,
                    // What each integer of programs takes.
                    _ => random.below(100) as f64,
                };
                if matches!(variable.role, Role::Input | Role::Parameter) {
                    assert_eq!(instance.try_set(reference as u32, value), Status::Ok);
                }
            }
            _ => {
                let cycle = instance.value(self.fmu.cycle);
                let h = cycle * random.pick(&[1.0, 1.0, 0.5, 3.0, 20.0]);
                assert_eq!(instance.step(self.now, h), Status::Ok, "{:?}", instance.log.take());
                self.now += h;
                self.steps += 1;
                for value in instance.values() {
                    self.seen = (self.seen ^ value).wrapping_mul(0x0000_0100_0000_01B3).rotate_left(23);
                }
            }
        }
    }
}

#[test]
fn instances_on_many_threads_compute_bit_for_bit_what_they_compute_alone() {
    let rounds = setting("PLCFMU_THREADS_ROUNDS", 200) as usize;
    let mut all_fmus = all_fmus();
    all_fmus.push(fmu_of("counter"));
    let lives = || (0..INSTANCES).map(|seed| Life::new(all_fmus[seed % all_fmus.len()], seed as u64));

    let alone: Vec<(u64, u64)> = lives()
        .map(|mut life| {
            life.go_on(rounds * 20);
            (life.seen, life.steps)
        })
        .collect();

    // Each thread takes an instance, lives a little of its life, and puts it back for another thread.
    let together: Vec<Mutex<(Life, usize)>> = lives().map(|life| Mutex::new((life, 0))).collect();
    let ended = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for thread in 0..THREADS {
            let (together, ended) = (&together, &ended);
            scope.spawn(move || {
                let mut random = Random::new(thread as u64);
                while ended.load(Ordering::Relaxed) < INSTANCES {
                    if let Ok(mut life) = together[random.below(INSTANCES)].try_lock()
                        && life.1 < rounds
                    {
                        life.0.go_on(20);
                        life.1 += 1;
                        if life.1 == rounds {
                            ended.fetch_add(1, Ordering::Relaxed);
                        }
                    }
                    // A failed thread must not leave the others waiting.
                    if together.iter().any(Mutex::is_poisoned) {
                        return;
                    }
                }
            });
        }
    });

    let steps: u64 = alone.iter().map(|(_, steps)| steps).sum();
    println!("{steps} steps of {INSTANCES} instances");
    assert!(steps > (INSTANCES * rounds) as u64, "{steps} steps are too few to prove anything");
    for (seed, (life, alone)) in together.into_iter().zip(alone).enumerate() {
        let (life, _) = life.into_inner().unwrap();
        assert_eq!((life.seen, life.steps), alone, "instance {seed}, of {}", life.fmu.name);
    }
}
