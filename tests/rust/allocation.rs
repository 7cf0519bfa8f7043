//! What the FMUs ask of the heap: nothing in set, get and doStep, little for an instance, and everything is given back.
//!
//! The libraries have an allocator of their own that nobody outside can watch. So the code that they are made of is
//! linked into this test, with an allocator that counts.

#![allow(clippy::unwrap_used)]
// A host calls C functions.
#![allow(unsafe_code)]

use blocks::{Block, ContC, EachBlock, Law, Role, for_each_block};
use fmu::host_type::HostType;
use fmu::table::Guid;
use fmu::v2::Fmi2;
use fmu::v2::ffi::{self, Pointer};
use fmu::v2::value::Boolean;
use std::ffi::{CString, c_int};
use std::ptr;
use tests::{Counting, Log, Random, logging_callbacks};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

blocks::block! {
    /// A transport delay of 50 calls: a block whose memory lies on the heap.
    pub struct Delay as "DELAY" {
        cycle {
            /// Time between two calls
            cycle: Time = Time::ms(100);
        }
        input {
            /// Input
            u: LReal = 0.0;
        }
        output {
            /// Input of 50 calls ago
            y: LReal;
        }
    }
    memory Memory {
        /// The last inputs.
        line: Vec<f64>;
        /// The place of the oldest.
        oldest: u32;
    }
}

impl Law for Delay {
    fn restart(&mut self) {
        self.clear();
        self.memory.line = vec![self.u; 50];
    }

    fn call(&mut self) {
        let place = &mut self.memory.line[self.memory.oldest as usize];
        self.y = std::mem::replace(place, self.u);
        self.memory.oldest = (self.memory.oldest + 1) % 50;
    }
}

fn instantiate<B: Block>(log: &Log, name: &str) -> Pointer {
    let callbacks = logging_callbacks(log);
    let (name, guid) = (CString::new(name).unwrap(), CString::new(Guid::<B>::TEXT).unwrap());
    // SAFETY: both structs are fmi2CallbackFunctions; all pointers point to what the function takes.
    let component = unsafe {
        ffi::fmi2Instantiate::<B>(name.as_ptr(), 1, guid.as_ptr(), ptr::null(), (&raw const callbacks).cast(), 0, 1)
    };
    assert!(!component.is_null(), "{:?}", log.take());
    component
}

fn initialize<B: Block>(component: Pointer) {
    // SAFETY: a living component.
    unsafe {
        assert_eq!(ffi::fmi2SetupExperiment::<B>(component, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!(ffi::fmi2EnterInitializationMode::<B>(component), 0);
        assert_eq!(ffi::fmi2ExitInitializationMode::<B>(component), 0);
    }
}

/// The rows of a type with a role.
fn rows<B: Block, T: HostType<Fmi2>>(role: impl Fn(Role) -> bool) -> Vec<u32> {
    let fits = |place: &u32| {
        let row = &B::TABLE.rows[*place as usize];
        T::holds(row.kind) && role(row.role)
    };
    (0..B::TABLE.rows.len() as u32).filter(fits).collect()
}

/// Sets, steps and gets at random, and says how many allocations that took.
fn allocations_of_a_run<B: Block>(component: Pointer, cycle: f64) -> u64 {
    let settable = |role| matches!(role, Role::Input | Role::Parameter);
    let (real, integer, boolean) = (rows::<B, f64>(settable), rows::<B, c_int>(settable), rows::<B, Boolean>(settable));
    let (all_real, all_integer, all_boolean) =
        (rows::<B, f64>(|_| true), rows::<B, c_int>(|_| true), rows::<B, Boolean>(|_| true));
    let (mut reals, mut integers, mut booleans) =
        (vec![0.0; all_real.len()], vec![0; all_integer.len()], vec![Boolean(0); all_boolean.len()]);
    let mut random = Random::new(1);
    let mut now = 0.0;

    let before = Counting::allocations();
    for _ in 0..2000 {
        reals.fill_with(|| random.between(0.0, 90.0));
        integers.fill_with(|| random.below(30_000) as c_int);
        booleans.fill_with(|| Boolean(random.below(2) as c_int));
        let h = cycle * random.pick(&[0.3, 1.0, 7.0]);
        // SAFETY: a living component, arrays at least as long as counted.
        unsafe {
            assert_eq!(ffi::fmi2SetReal::<B>(component, real.as_ptr(), real.len(), reals.as_ptr()), 0);
            assert_eq!(ffi::fmi2SetInteger::<B>(component, integer.as_ptr(), integer.len(), integers.as_ptr()), 0);
            assert_eq!(ffi::fmi2SetBoolean::<B>(component, boolean.as_ptr(), boolean.len(), booleans.as_ptr()), 0);
            assert_eq!(ffi::fmi2DoStep::<B>(component, now, h, 1), 0);
            assert_eq!(ffi::fmi2GetReal::<B>(component, all_real.as_ptr(), all_real.len(), reals.as_mut_ptr()), 0);
            assert_eq!(
                ffi::fmi2GetInteger::<B>(component, all_integer.as_ptr(), all_integer.len(), integers.as_mut_ptr()),
                0
            );
            assert_eq!(
                ffi::fmi2GetBoolean::<B>(component, all_boolean.as_ptr(), all_boolean.len(), booleans.as_mut_ptr()),
                0
            );
        }
        now += h;
    }
    Counting::allocations() - before
}

/// The same, with all Real inputs extrapolated, and without.
fn runs_without_allocation<B: Block>() {
    let log = Log::default();
    let component = instantiate::<B>(&log, "x");
    let cycle = f64::from(B::default().cycle().milliseconds()) / 1000.0;
    initialize::<B>(component);
    assert_eq!(allocations_of_a_run::<B>(component, cycle), 0, "{}", B::TABLE.name);

    // SAFETY: a living component.
    unsafe { assert_eq!(ffi::fmi2Reset::<B>(component), 0) };
    initialize::<B>(component);
    let inputs: Vec<u32> = rows::<B, f64>(|role| role == Role::Input);
    for input in inputs {
        let (order, derivative) = (1, 0.25);
        // SAFETY: a living component, arrays of one element.
        let status = unsafe {
            ffi::fmi2SetRealInputDerivatives::<B>(
                component,
                &raw const input,
                1,
                &raw const order,
                &raw const derivative,
            )
        };
        assert_eq!(status, 0, "{:?}", log.take());
    }
    assert_eq!(allocations_of_a_run::<B>(component, cycle), 0, "{}, extrapolated", B::TABLE.name);
    // SAFETY: a living component.
    unsafe { ffi::fmi2FreeInstance::<B>(component) };
}

#[test]
fn set_get_and_do_step_allocate_nothing() {
    struct RunsWithoutAllocation;
    impl EachBlock for RunsWithoutAllocation {
        fn block<B: Block>(&mut self) {
            runs_without_allocation::<B>();
        }
    }
    for_each_block(&mut RunsWithoutAllocation);
    runs_without_allocation::<Delay>();
}

#[test]
fn the_counter_counts() {
    let before = (Counting::allocations(), Counting::bytes());
    let boxed = std::hint::black_box(Box::new([0u8; 100]));
    assert_eq!((Counting::allocations(), Counting::bytes()), (before.0 + 1, before.1 + 100));
    drop(boxed);
    assert_eq!((Counting::allocations(), Counting::bytes()), (before.0 + 1, before.1));
}

#[test]
fn an_instance_of_cont_c_takes_at_most_512_bytes() {
    let log = Log::default();
    let before = Counting::bytes();
    let component = instantiate::<ContC>(&log, "a name of 20 letters");
    initialize::<ContC>(component);
    assert_eq!(log.take().len(), 1, "the advice that MAN_ON is TRUE");
    allocations_of_a_run::<ContC>(component, 1.0);
    let bytes = Counting::bytes() - before;
    // SAFETY: a living component.
    unsafe { ffi::fmi2FreeInstance::<ContC>(component) };
    assert_eq!(Counting::bytes(), before);
    println!("{bytes} bytes an instance");
    assert!((200..=512).contains(&bytes), "{bytes} bytes");
}

/// Everything that takes memory: states, serialized ones, derivatives, refusals.
fn gives_everything_back<B: Block>() {
    let log = Log::default();
    let session = || {
        let component = instantiate::<B>(&log, "x");
        initialize::<B>(component);
        let mut states = [ptr::null_mut(); 10];
        // SAFETY: a living component, states of its own, the host's variables.
        unsafe {
            for state in &mut states {
                assert_eq!(ffi::fmi2GetFMUstate::<B>(component, state), 0);
            }
            let (mut size, mut again) = (0, ptr::null_mut());
            assert_eq!(ffi::fmi2SerializedFMUstateSize::<B>(component, states[0], &raw mut size), 0);
            let mut bytes = vec![0; size];
            assert_eq!(ffi::fmi2SerializeFMUstate::<B>(component, states[0], bytes.as_mut_ptr(), size), 0);
            assert_eq!(ffi::fmi2DeSerializeFMUstate::<B>(component, bytes.as_ptr(), size, &raw mut again), 0);
            bytes[size / 2] ^= 1;
            assert_eq!(ffi::fmi2DeSerializeFMUstate::<B>(component, bytes.as_ptr(), size, &raw mut again), 3);
            assert_eq!(ffi::fmi2SetFMUstate::<B>(component, again), 0);
            assert_eq!(ffi::fmi2FreeFMUstate::<B>(component, &raw mut states[3]), 0);
            assert_eq!(ffi::fmi2DoStep::<B>(component, -1.0, 0.0, 1), 3);
            assert_eq!(ffi::fmi2Reset::<B>(component), 0);
            // Nine states go with the instance.
            ffi::fmi2FreeInstance::<B>(component);
            // And one that is refused.
            let callbacks = logging_callbacks(&log);
            assert!(
                ffi::fmi2Instantiate::<B>(
                    c"x".as_ptr(),
                    1,
                    c"?".as_ptr(),
                    ptr::null(),
                    (&raw const callbacks).cast(),
                    0,
                    1
                )
                .is_null()
            );
            ffi::fmi2FreeInstance::<B>(ptr::null_mut());
        }
        log.take();
    };
    session();
    let before = Counting::bytes();
    session();
    assert_eq!(Counting::bytes() - before, 0, "{}", B::TABLE.name);
}

#[test]
fn an_instance_gives_everything_back_when_it_is_freed() {
    struct GivesEverythingBack;
    impl EachBlock for GivesEverythingBack {
        fn block<B: Block>(&mut self) {
            gives_everything_back::<B>();
        }
    }
    for_each_block(&mut GivesEverythingBack);
    gives_everything_back::<Delay>();
}
