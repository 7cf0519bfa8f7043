//! What the FMI interface costs: one control cycle (set two inputs, doStep, get one output) of CONT_C through the C
//! functions of its library, beside the bare call of the block, measured in turns in the same run.
//!
//! `cargo bench --package tests`; `PLCFMU_BENCH_MEASUREMENTS` is the number of measurements of which the median is taken.

// A host calls C functions.
#![allow(unsafe_code)]

use blocks::{ContC, Law};
use fmu::v2::ffi;
use fmu::v2::interface::Guid;
use std::ffi::CString;
use std::hint::black_box;
use std::ptr;
use std::time::Instant;
use tests::{Counting, Instance, Log, Random, logging_callbacks, setting, unit};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Cycles in one measurement.
const CYCLES: usize = 20_000;

/// A PID controller in automatic mode.
fn controller() -> ContC {
    ContC { man_on: false, d_sel: true, lmn_llm: -100.0, ..ContC::default() }
}

/// Nanoseconds for one of `count`.
fn time(count: usize, body: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    body();
    begin.elapsed().as_nanos() as f64 / count as f64
}

/// The median of measurements, and the fastest: on a busy machine that is the one to compare.
struct Measured {
    median: f64,
    fastest: f64,
}

fn summary(mut times: Vec<f64>) -> Measured {
    times.sort_by(f64::total_cmp);
    Measured { median: times[times.len() / 2], fastest: times[0] }
}

/// Bytes that one instance of CONT_C asks for, counted in the code that the library is made of.
fn bytes_of_an_instance() -> isize {
    let log = Log::default();
    let callbacks = logging_callbacks(&log);
    let guid = CString::new(Guid::<ContC>::TEXT).unwrap_or_default();
    let before = Counting::bytes();
    // SAFETY: both structs are fmi2CallbackFunctions; all pointers point to what the function takes.
    unsafe {
        let callbacks = (&raw const callbacks).cast();
        let component = ffi::instantiate::<ContC>(c"CONT_C".as_ptr(), 1, guid.as_ptr(), callbacks, 1);
        let bytes = Counting::bytes() - before;
        ffi::free_instance::<ContC>(component);
        bytes
    }
}

fn main() {
    let unit = unit("cont_c");
    let instance = Instance::new(unit);
    for (name, value) in [("MAN_ON", 0.0), ("D_SEL", 1.0), ("LMN_LLM", -100.0)] {
        instance.set(name, value);
    }
    instance.initialize(0.0, None);
    let mut block = controller();
    block.restart();

    // A slow wave with some noise, small enough that no limit is reached: the signals of a loop at work.
    let mut random = Random::new(1);
    let wave = |k: u32| (f64::from(k) * std::f64::consts::TAU / 1024.0).sin();
    let signals: Vec<[f64; 2]> = (0..1024)
        .map(|k| [1.0, 1.0 - 2.0 * wave(k) + random.between(-0.05, 0.05)].map(|signal| f64::from(signal as f32)))
        .collect();
    let reals: Vec<[f32; 2]> = signals.iter().map(|pair| pair.map(|signal| signal as f32)).collect();
    let inputs = [unit.reference("SP_INT"), unit.reference("PV_IN")];
    let output = unit.reference("LMN");
    let (library, component) = (&unit.library, instance.component);

    let (mut step, mut lmn) = (0u64, 0.0);
    let mut interface = || {
        for k in 0..CYCLES {
            let values = &signals[k % signals.len()];
            // SAFETY: a living component; arrays as long as counted.
            let status = unsafe {
                (library.set_real)(component, inputs.as_ptr(), 2, values.as_ptr())
                    | (library.do_step)(component, step as f64, 1.0, 1)
                    | (library.get_real)(component, &raw const output, 1, &raw mut lmn)
            };
            assert!(status == 0);
            step += 1;
            black_box(lmn);
        }
        lmn
    };
    let mut bare = || {
        for k in 0..CYCLES {
            [block.sp_int, block.pv_in] = reals[k % reals.len()];
            black_box(&mut block).call();
            black_box(block.lmn);
        }
        f64::from(block.lmn)
    };

    let (mut through_interface, mut alone) = (Vec::new(), Vec::new());
    let measurements = setting("PLCFMU_BENCH_MEASUREMENTS", 301);
    for _ in 0..measurements {
        let (mut with, mut without) = (0.0, 0.0);
        through_interface.push(time(CYCLES, || with = interface()));
        alone.push(time(CYCLES, || without = bare()));
        assert!(with.to_bits() == without.to_bits(), "both compute the same: {with:?} and {without:?}");
    }

    let log = Log::default();
    let callbacks = logging_callbacks(&log);
    let lives = (0..measurements).map(|_| {
        time(1000, || {
            for _ in 0..1000 {
                // SAFETY: all pointers point to what the functions take; each component is freed once.
                unsafe {
                    let callbacks = &raw const callbacks;
                    let (name, guid) = (c"CONT_C".as_ptr(), unit.guid.as_ptr());
                    (library.free_instance)((library.instantiate)(name, 1, guid, ptr::null(), callbacks, 0, 1));
                }
            }
        })
    });
    let life = summary(lives.collect());

    let (through_interface, alone) = (summary(through_interface), summary(alone));
    println!("one cycle of CONT_C: set 2 inputs, doStep, get 1 output; {measurements} measurements of {CYCLES} cycles");
    println!("                              median   fastest");
    let row = |name: &str, measured: &Measured| {
        println!("{name:26}{:7.2} ns{:7.2} ns", measured.median, measured.fastest);
    };
    row("through the C interface", &through_interface);
    row("bare call of the block", &alone);
    let (median, fastest) = (through_interface.median / alone.median, through_interface.fastest / alone.fastest);
    println!("{:26}{median:7.2}   {fastest:7.2}", "ratio");
    row("instantiate and free", &life);
    println!("{:26}{:4} bytes", "heap of an instance", bytes_of_an_instance());
}
