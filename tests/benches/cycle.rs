//! The cost of the FMI interface: one control cycle of CONT_C in automatic mode with PI action (set two inputs, doStep,
//! get one output) through the C functions of its packed library.
//!
//! Measured alternately in the same run: the *floor*, the same law behind the same C functions without any checks
//! (tests/benches/floor), and the bare call of the block.
//!
//! `cargo bench --package tests`; `PLCFMU_BENCH_MEASUREMENTS` is the number of measurements from which the median is
//! taken.

// A host calls C functions.
#![allow(unsafe_code)]

use blocks::{ContC, Law, Types};
use fmu::table::Guid;
use fmu::v2::ffi;
use host::instance::Type;
use host::library::v3;
use libloading::Library;
use modeldescription::v3::token;
use std::ffi::{CString, c_int, c_void};
use std::hint::black_box;
use std::ptr;
use std::time::Instant;
use tests::{Counting, Fmu, Instance, Log, Random, fmu_of, logging_callbacks, plain_library, setting};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Cycles in one measurement.
const CYCLES: usize = 5_000;

type Component = *mut c_void;

/// The three functions of a control cycle, and their component.
#[derive(Clone, Copy)]
struct Functions {
    component: Component,
    set_real: unsafe extern "C" fn(Component, *const u32, usize, *const f64) -> c_int,
    do_step: unsafe extern "C" fn(Component, f64, f64, c_int) -> c_int,
    get_real: unsafe extern "C" fn(Component, *const u32, usize, *mut f64) -> c_int,
}

/// A controller in a library, driven by a host in consecutive steps of CYCLE = 1 s.
struct Driven<'a> {
    functions: Functions,
    inputs: [u32; 2],
    output: u32,
    signals: &'a [[f64; 2]],
    step: u64,
}

impl Driven<'_> {
    fn set(&self, k: usize) -> c_int {
        let values = &self.signals[k % self.signals.len()];
        // SAFETY: a living component; arrays as long as counted.
        unsafe { (self.functions.set_real)(self.functions.component, self.inputs.as_ptr(), 2, values.as_ptr()) }
    }

    fn do_step(&mut self) -> c_int {
        let tc = self.step as f64;
        self.step += 1;
        // SAFETY: a living component.
        unsafe { (self.functions.do_step)(self.functions.component, tc, 1.0, 1) }
    }

    fn get(&self, lmn: &mut f64) -> c_int {
        // SAFETY: a living component; arrays as long as counted.
        unsafe { (self.functions.get_real)(self.functions.component, &raw const self.output, 1, lmn) }
    }

    /// Runs whole control cycles; returns the last output.
    fn cycles(&mut self) -> f64 {
        let mut lmn = 0.0;
        for k in 0..CYCLES {
            let status = self.set(k) | self.do_step() | self.get(&mut lmn);
            assert!(status == 0);
            black_box(lmn);
        }
        lmn
    }

    /// Returns the nanoseconds for one call of each function alone, and for the whole cycle.
    fn measure(&mut self) -> [f64; 4] {
        let mut lmn = 0.0;
        let set = time(CYCLES, || (0..CYCLES).for_each(|k| assert!(self.set(k) == 0)));
        let step = time(CYCLES, || (0..CYCLES).for_each(|_| assert!(self.do_step() == 0)));
        let get = time(CYCLES, || (0..CYCLES).for_each(|_| assert!(black_box(self.get(&mut lmn)) == 0)));
        let cycle = time(CYCLES, || {
            self.cycles();
        });
        [set, step, get, cycle]
    }
}

/// The same controller through FMI 3.0, with its own types: calls within steps, or as events between them.
struct Newer<'a> {
    library: v3::Library,
    instance: Component,
    inputs: [u32; 2],
    output: u32,
    signals: &'a [[f32; 2]],
    has_events: bool,
    step: u64,
}

impl<'a> Newer<'a> {
    fn new(fmu: &Fmu, signals: &'a [[f32; 2]], has_events: bool) -> Newer<'a> {
        let library = v3::Library::open(&fmu.path).unwrap_or_else(|error| panic!("{error:#}"));
        let token = CString::new(token(Guid::<ContC>::TEXT, Types::Native)).unwrap_or_default();
        let [inputs, output] = [["SP_INT", "PV_IN"], ["LMN"; 2]].map(|names| names.map(|name| fmu.reference(name)));
        let (name, none) = (c"CONT_C".as_ptr(), ptr::null_mut());
        // SAFETY: every pointer is NULL or points to what the function takes.
        let instance = unsafe {
            let instance = (library.instantiate_co_simulation)(
                name,
                token.as_ptr(),
                ptr::null(),
                false,
                false,
                has_events,
                true,
                ptr::null(),
                0,
                none,
                None,
                None,
            );
            let [manual, low] = ["MAN_ON", "LMN_LLM"].map(|name| fmu.reference(name));
            let mut status = (library.set_boolean)(instance, &raw const manual, 1, &0, 1);
            status |= (library.set_float32)(instance, &raw const low, 1, &-100.0, 1);
            status |= (library.enter_initialization_mode)(instance, false, 0.0, 0.0, false, 0.0);
            status |= (library.exit_initialization_mode)(instance);
            assert!(status == 0);
            instance
        };
        Newer { library, instance, inputs, output: output[0], signals, has_events, step: 0 }
    }

    /// Runs whole control cycles; returns the last output.
    fn cycles(&mut self) -> f64 {
        let (library, instance) = (&self.library, self.instance);
        let (mut lmn, [mut a, mut b, mut c, mut d, mut e], mut time) = (0.0_f32, [0_u8; 5], 0.0);
        let (inputs, output) = (self.inputs.as_ptr(), &raw const self.output);
        for k in 0..CYCLES {
            let values = self.signals[k % self.signals.len()].as_ptr();
            let tc = self.step as f64;
            self.step += 1;
            // SAFETY: a living instance; arrays as long as counted, and variables of this function.
            let status = unsafe {
                let mut status = (library.set_float32)(instance, inputs, 2, values, 2);
                if self.has_events {
                    status |= (library.update_discrete_states)(
                        instance,
                        &raw mut a,
                        &raw mut b,
                        &raw mut c,
                        &raw mut d,
                        &raw mut e,
                        &raw mut time,
                    );
                    status |= (library.get_float32)(instance, output, 1, &raw mut lmn, 1);
                    status |= (library.enter_step_mode)(instance);
                }
                status |= (library.do_step)(instance, tc, 1.0, true, &raw mut a, &raw mut b, &raw mut c, &raw mut time);
                match self.has_events {
                    true => status | (library.enter_event_mode)(instance),
                    false => status | (library.get_float32)(instance, output, 1, &raw mut lmn, 1),
                }
            };
            assert!(status == 0);
            black_box(lmn);
        }
        f64::from(lmn)
    }
}

impl Drop for Newer<'_> {
    fn drop(&mut self) {
        // SAFETY: a living instance, not used again.
        unsafe { (self.library.free_instance)(self.instance) };
    }
}

/// A C function that sets Integers or Booleans, and one that gets them.
type SetIntegers = unsafe extern "C" fn(Component, *const u32, usize, *const c_int) -> c_int;
type GetIntegers = unsafe extern "C" fn(Component, *const u32, usize, *mut c_int) -> c_int;

/// What else a host may set and get in a cycle: one call per type of variable.
struct Shape {
    name: &'static str,
    set: &'static [(Type, &'static [&'static str])],
    get: &'static [(Type, &'static [&'static str])],
}

const SHAPES: &[Shape] = &[
    Shape { name: "set 2, get 1", set: &[(Type::Real, &["SP_INT", "PV_IN"])], get: &[(Type::Real, &["LMN"])] },
    Shape { name: "set 3, get 1", set: &[(Type::Real, &["SP_INT", "PV_IN", "DISV"])], get: &[(Type::Real, &["LMN"])] },
    Shape {
        name: "set 5, get 1",
        set: &[(Type::Real, &["SP_INT", "PV_IN", "DISV", "GAIN", "MAN"])],
        get: &[(Type::Real, &["LMN"])],
    },
    Shape { name: "set 2, get 2", set: &[(Type::Real, &["SP_INT", "PV_IN"])], get: &[(Type::Real, &["LMN", "PV"])] },
    Shape {
        name: "set 2, get 5",
        set: &[(Type::Real, &["SP_INT", "PV_IN"])],
        get: &[(Type::Real, &["LMN", "PV", "ER", "LMN_P", "LMN_I"])],
    },
    Shape { name: "set a TIME, get it", set: &[(Type::Real, &["TI"])], get: &[(Type::Real, &["TI"])] },
    Shape { name: "set a WORD, get one", set: &[(Type::Integer, &["PV_PER"])], get: &[(Type::Integer, &["LMN_PER"])] },
    Shape {
        name: "set 2 REALs and a BOOL, get 1",
        set: &[(Type::Real, &["SP_INT", "PV_IN"]), (Type::Boolean, &["MAN_ON"])],
        get: &[(Type::Real, &["LMN"])],
    },
    Shape {
        name: "set 2, get 2 BOOLs",
        set: &[(Type::Real, &["SP_INT", "PV_IN"])],
        get: &[(Type::Boolean, &["QLMN_HLM", "QLMN_LLM"])],
    },
];

/// The functions of a library for each type of [`Shape`].
#[derive(Clone, Copy)]
struct All {
    functions: Functions,
    integers: (SetIntegers, GetIntegers),
    booleans: (SetIntegers, GetIntegers),
}

/// A host that runs cycles of one shape.
struct Shaped<'a> {
    of: All,
    set: Vec<(Type, Vec<u32>)>,
    get: Vec<(Type, Vec<u32>)>,
    signals: &'a [[f64; 2]],
    step: &'a mut u64,
}

impl<'a> Shaped<'a> {
    fn new(of: All, shape: &Shape, fmu: &Fmu, signals: &'a [[f64; 2]], step: &'a mut u64) -> Shaped<'a> {
        let references = |groups: &[(Type, &[&str])]| {
            let group = |(kind, names): &(Type, &[&str])| (*kind, names.iter().map(|of| fmu.reference(of)).collect());
            groups.iter().map(group).collect()
        };
        Shaped { of, set: references(shape.set), get: references(shape.get), signals, step }
    }

    /// Returns the nanoseconds for a cycle.
    fn measure(&mut self) -> f64 {
        let Functions { component, set_real, do_step, get_real } = self.of.functions;
        let (mut reals, mut integers) = ([0.5; 8], [0; 8]);
        time(CYCLES, || {
            for k in 0..CYCLES {
                reals[..2].copy_from_slice(&self.signals[k % self.signals.len()]);
                let mut status = 0;
                for (kind, of) in &self.set {
                    // SAFETY: a living component; arrays at least as long as counted.
                    status |= unsafe {
                        match kind {
                            Type::Real => set_real(component, of.as_ptr(), of.len(), reals.as_ptr()),
                            Type::Integer => self.of.integers.0(component, of.as_ptr(), of.len(), integers.as_ptr()),
                            _ => self.of.booleans.0(component, of.as_ptr(), of.len(), [0; 8].as_ptr()),
                        }
                    };
                }
                let tc = *self.step as f64;
                *self.step += 1;
                // SAFETY: a living component.
                status |= unsafe { do_step(component, tc, 1.0, 1) };
                for (kind, of) in &self.get {
                    // SAFETY: as above.
                    status |= unsafe {
                        match kind {
                            Type::Real => get_real(component, of.as_ptr(), of.len(), reals[2..].as_mut_ptr()),
                            Type::Integer => {
                                self.of.integers.1(component, of.as_ptr(), of.len(), integers.as_mut_ptr())
                            }
                            _ => self.of.booleans.1(component, of.as_ptr(), of.len(), integers.as_mut_ptr()),
                        }
                    };
                }
                assert!(status == 0);
                black_box((&reals, &integers));
            }
        })
    }
}

/// Measures one cycle of each shape through the FMU and through the floor, alternately.
fn shapes(fmu: &Fmu, [ours, floor]: [All; 2], steps: &mut [u64; 2], signals: &[[f64; 2]], measurements: u64) {
    println!("one cycle by what is set and got          FMU   floor  ratio of the fastest");
    for shape in SHAPES {
        let [ours_step, floor_step] = &mut *steps;
        let mut ours = Shaped::new(ours, shape, fmu, signals, ours_step);
        let mut floor = Shaped::new(floor, shape, fmu, signals, floor_step);
        let (with, without): (Vec<_>, Vec<_>) = (0..measurements).map(|_| (ours.measure(), floor.measure())).unzip();
        let [with, without] = [with, without].map(|times| summary(times).fastest);
        println!("{:38}{with:6.2}ns{without:6.2}ns{:6.2}", shape.name, with / without);
    }
}

/// Returns the nanoseconds for one of `count`.
fn time(count: usize, body: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    body();
    begin.elapsed().as_nanos() as f64 / count as f64
}

/// The median of the measurements, and the fastest, which is the one to compare on a busy machine.
struct Measured {
    median: f64,
    fastest: f64,
}

fn summary(mut times: Vec<f64>) -> Measured {
    times.sort_by(f64::total_cmp);
    Measured { median: times[times.len() / 2], fastest: times[0] }
}

/// Returns the bytes that one instance of CONT_C allocates, counted in the code that the library is built from.
fn bytes_of_an_instance() -> isize {
    let log = Log::default();
    let callbacks = logging_callbacks(&log);
    let guid = CString::new(Guid::<ContC>::TEXT).unwrap_or_default();
    let before = Counting::bytes();
    // SAFETY: both structs are fmi2CallbackFunctions; all pointers point to what the function takes.
    unsafe {
        let callbacks = (&raw const callbacks).cast();
        let component =
            ffi::fmi2Instantiate::<ContC>(c"CONT_C".as_ptr(), 1, guid.as_ptr(), std::ptr::null(), callbacks, 0, 1);
        let bytes = Counting::bytes() - before;
        ffi::fmi2FreeInstance::<ContC>(component);
        bytes
    }
}

/// Returns the floor's functions with an instance of it, and the function that frees it.
fn floor(library: &Library) -> (Functions, unsafe extern "C" fn(Component)) {
    let missing = |error| panic!("the floor: {error}");
    // SAFETY: the package `floor` gives these symbols these types.
    unsafe {
        let instantiate =
            library.get::<unsafe extern "C" fn() -> Component>("floor_instantiate").unwrap_or_else(missing);
        let functions = Functions {
            component: instantiate(),
            set_real: *library.get("floor_set_real").unwrap_or_else(|error| panic!("the floor: {error}")),
            do_step: *library.get("floor_do_step").unwrap_or_else(|error| panic!("the floor: {error}")),
            get_real: *library.get("floor_get_real").unwrap_or_else(|error| panic!("the floor: {error}")),
        };
        (functions, *library.get("floor_free").unwrap_or_else(|error| panic!("the floor: {error}")))
    }
}

/// Measures the nanoseconds for instantiating and freeing once.
fn life(fmu: &Fmu, measurements: u64) -> Measured {
    let log = Log::default();
    let callbacks = logging_callbacks(&log);
    let library = &fmu.library;
    let lives = (0..measurements).map(|_| {
        time(1000, || {
            for _ in 0..1000 {
                // SAFETY: all pointers point to what the functions take; each component is freed once.
                unsafe {
                    let callbacks = &raw const callbacks;
                    let (name, guid) = (c"CONT_C".as_ptr(), fmu.guid.as_ptr());
                    (library.free_instance)((library.instantiate)(name, 1, guid, ptr::null(), callbacks, 0, 1));
                }
            }
        })
    });
    summary(lives.collect())
}

fn main() {
    let fmu = fmu_of("cont_c");
    let instance = Instance::new(fmu);
    for (name, value) in [("MAN_ON", 0.0), ("LMN_LLM", -100.0)] {
        instance.set(name, value);
    }
    instance.initialize(0.0, None);
    let mut block = ContC { man_on: false, lmn_llm: -100.0, ..ContC::default() };
    block.restart();
    // SAFETY: a library of ours, whose initializers are those of Rust's standard library.
    let floor_library = unsafe { Library::new(plain_library("floor")) }.unwrap_or_else(|error| panic!("{error}"));
    let (floor, free_floor) = floor(&floor_library);

    // A slow wave with some noise, small enough that no limit is reached: the signals of a loop in operation.
    let mut random = Random::new(1);
    let wave = |k: u32| (f64::from(k) * std::f64::consts::TAU / 1024.0).sin();
    let signals: Vec<[f64; 2]> = (0..1024)
        .map(|k| [1.0, 1.0 - 2.0 * wave(k) + random.between(-0.05, 0.05)].map(|signal| f64::from(signal as f32)))
        .collect();
    let reals: Vec<[f32; 2]> = signals.iter().map(|pair| pair.map(|signal| signal as f32)).collect();
    let library = &fmu.library;
    let ours = Functions {
        component: instance.component,
        set_real: library.set_real,
        do_step: library.do_step,
        get_real: library.get_real,
    };
    let inputs = [fmu.reference("SP_INT"), fmu.reference("PV_IN")];
    let output = fmu.reference("LMN");
    let [mut ours, mut floor] =
        [ours, floor].map(|functions| Driven { functions, inputs, output, signals: &signals, step: 0 });
    let mut bare = || {
        for k in 0..CYCLES {
            [block.sp_int, block.pv_in] = reals[k % reals.len()];
            black_box(&mut block).call();
            black_box(block.lmn);
        }
        f64::from(block.lmn)
    };

    let same = [ours.cycles(), floor.cycles(), bare()].map(f64::to_bits);
    assert!(same == [same[0]; 3], "all three compute the same: {same:x?}");

    let measurements = setting("PLCFMU_BENCH_MEASUREMENTS", 1001);
    let (mut with, mut without, mut alone) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..measurements {
        with.push(ours.measure());
        without.push(floor.measure());
        alone.push(time(CYCLES, || {
            bare();
        }));
    }
    let mut newer = [false, true].map(|has_events| Newer::new(fmu, &reals, has_events));
    let firsts = newer.each_mut().map(|newer| newer.cycles().to_bits());
    assert!(firsts == [same[0]; 2], "FMI 3.0 computes the same: {firsts:x?}");
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..measurements {
        times[0].push(time(CYCLES, || {
            black_box(ours.cycles());
        }));
        for (newer, times) in newer.iter_mut().zip(&mut times[1..]) {
            times.push(time(CYCLES, || {
                black_box(newer.cycles());
            }));
        }
    }
    let [of_2, rest @ ..] = times.map(|times| summary(times).fastest);
    println!("one cycle of CONT_C in FMI 3.0           FMU  FMI 2.0  ratio of the fastest");
    for (name, of_3) in ["calls within steps", "calls as events"].into_iter().zip(rest) {
        println!("{name:38}{of_3:6.2}ns{of_2:6.2}ns{:6.2}", of_3 / of_2);
    }
    println!("one cycle of CONT_C: set 2 inputs, doStep, get 1 output; {measurements} measurements of {CYCLES} cycles");
    println!("                              median             fastest");
    println!("                       FMU   floor  ratio    FMU   floor  ratio");
    for (part, name) in ["set 2 inputs", "doStep", "get 1 output", "one cycle"].into_iter().enumerate() {
        let of = |measured: &[[f64; 4]]| summary(measured.iter().map(|parts| parts[part]).collect());
        let (ours, floor) = (of(&with), of(&without));
        let ratios = with.iter().zip(&without).map(|(ours, floor)| ours[part] / floor[part]).collect();
        println!(
            "{name:18}{:6.2}ns{:6.2}ns{:6.2} {:6.2}ns{:6.2}ns{:6.2}",
            ours.median,
            floor.median,
            summary(ratios).median,
            ours.fastest,
            floor.fastest,
            ours.fastest / floor.fastest
        );
    }
    let of_fmu = (library.set_integer, library.get_integer);
    let booleans = (library.set_boolean, library.get_boolean);
    let ours_all = All { functions: ours.functions, integers: of_fmu, booleans };
    // SAFETY: the package `floor` gives these symbols these types.
    let of_floor = unsafe {
        let set: SetIntegers =
            *floor_library.get("floor_set_integer").unwrap_or_else(|error| panic!("the floor: {error}"));
        let get: GetIntegers =
            *floor_library.get("floor_get_integer").unwrap_or_else(|error| panic!("the floor: {error}"));
        (set, get)
    };
    let floor_all = All { functions: floor.functions, integers: of_floor, booleans: of_floor };
    shapes(fmu, [ours_all, floor_all], &mut [ours.step, floor.step], &signals, measurements);
    // SAFETY: a living instance, not used again.
    unsafe { free_floor(floor.functions.component) };
    let row = |name: &str, measured: &Measured| {
        println!("{name:24}{:7.2} ns{:17.2} ns", measured.median, measured.fastest);
    };
    row("bare call of the block", &summary(alone));
    row("instantiate and free", &life(fmu, measurements.min(301)));
    println!("{:24}{:4} bytes", "heap of an instance", bytes_of_an_instance());
}
