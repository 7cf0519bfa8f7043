//! Calls the C interface as the bytes say. A panic anywhere ends the run, whether the interface catches it or not; a
//! refused call has to leave the instance as it was.
//!
//! The functions are those that the libraries export, linked in, so that the fuzzer sees their branches.

#![no_main]

use blocks::{Block, ContC, ContS, Hlg, PulsCtr, Pulsegen};
use blocks::table::fingerprint::checksum;
use fmu::v2::ffi::{self, Pointer};
use fmu::table::Guid;
use fmu::v2::value::Boolean;
use libfuzzer_sys::fuzz_target;
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr;

/// The input, read from the front; behind its end all is 0.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut taken = [0; N];
        let length = N.min(self.0.len());
        taken[..length].copy_from_slice(&self.0[..length]);
        self.0 = &self.0[length..];
        taken
    }

    fn byte(&mut self) -> u8 {
        self.take::<1>()[0]
    }

    fn below(&mut self, end: usize) -> usize {
        usize::from(self.byte()) % end.max(1)
    }

    /// Mostly a simple number, or any.
    fn real(&mut self) -> f64 {
        match self.byte() {
            0 => f64::from_le_bytes(self.take()),
            1 => f64::from(f32::from_le_bytes(self.take())),
            2 => f64::from(i32::from_le_bytes(self.take())) / 1000.0,
            3 => [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 1e300, 5e-324, 3.5e38, 1e9][self.below(8)],
            small => f64::from(small) - 100.0,
        }
    }
}

/// `fmi2CallbackFunctions`, with a logger that takes everything.
#[repr(C)]
struct Callbacks {
    logger: unsafe extern "C" fn(),
    others: [*const c_void; 4],
}

unsafe extern "C" fn logger() {}

struct Slot {
    component: Pointer,
    states: Vec<Pointer>,
    /// What the test itself looks at the instance with.
    probe: Pointer,
    /// It was restored from bytes that no instance wrote: a step might be made of billions of calls.
    forged: bool,
}

fn snapshot<B: Block>(slot: &mut Slot) -> Vec<u8> {
    let mut size = 0;
    // SAFETY: a living component, a state of its own, a buffer as long as said.
    unsafe {
        assert_eq!(ffi::fmi2GetFMUstate::<B>(slot.component, &raw mut slot.probe), 0);
        assert_eq!(ffi::fmi2SerializedFMUstateSize::<B>(slot.component, slot.probe, &raw mut size), 0);
        let mut bytes = vec![0; size];
        assert_eq!(ffi::fmi2SerializeFMUstate::<B>(slot.component, slot.probe, bytes.as_mut_ptr(), size), 0);
        bytes
    }
}

fn instantiate<B: Block>() -> Slot {
    let callbacks = Callbacks { logger, others: [ptr::null(); 4] };
    let guid = CString::new(Guid::<B>::TEXT).unwrap_or_default();
    // SAFETY: all pointers point to what the function takes; a logger may leave its arguments alone.
    let component = unsafe { ffi::fmi2Instantiate::<B>(c"x".as_ptr(), 1, guid.as_ptr(), std::ptr::null(), (&raw const callbacks).cast(), 0, 1) };
    assert!(!component.is_null());
    Slot { component, states: Vec::new(), probe: ptr::null_mut(), forged: false }
}

fn state_of(slots: &[Slot], which: usize, input: &mut Bytes) -> Pointer {
    match input.byte() {
        0 => ptr::null_mut(),
        1 => 8 as Pointer,
        2 => slots[1 - which].states.first().copied().unwrap_or(ptr::null_mut()),
        place => {
            let own = &slots[which].states;
            if own.is_empty() { ptr::null_mut() } else { own[usize::from(place) % own.len()] }
        }
    }
}

/// Bytes to restore from: those of an instance with some changed, and mostly with the checksum that belongs to them.
fn forge(mut bytes: Vec<u8>, input: &mut Bytes) -> Vec<u8> {
    for _ in 0..input.below(4) {
        let place = usize::from(u16::from_le_bytes(input.take())) % bytes.len();
        bytes[place] = input.byte();
    }
    if input.below(8) == 1 {
        bytes.truncate(usize::from(u16::from_le_bytes(input.take())) % bytes.len());
    }
    if bytes.len() > 16 && input.below(8) != 1 {
        let content = bytes.len() - 16;
        let sum = checksum(&bytes[..content]);
        bytes[content..].copy_from_slice(&sum.to_le_bytes());
    }
    bytes
}

fn run<B: Block>(mut input: Bytes) {
    let mut slots = [instantiate::<B>(), instantiate::<B>()];
    let cycle = B::TABLE.cycle as u32;
    for _ in 0..300 {
        if input.0.is_empty() {
            break;
        }
        let which = input.below(2);
        let before = snapshot::<B>(&mut slots[which]);
        let component = slots[which].component;
        let count = input.below(4);
        let references: [u32; 3] = std::array::from_fn(|_| match input.byte() {
            255 => u32::MAX,
            reference => u32::from(reference) % (B::TABLE.rows.len() as u32 + 1),
        });
        let vr = if input.byte() == 255 { ptr::null() } else { references.as_ptr() };
        // SAFETY: living components; arrays of at least as many elements as counted, or NULL; addresses of states are
        // only compared.
        let status = unsafe {
            match input.below(25) {
                0 => {
                    let (start, stop) = (input.real(), input.real());
                    ffi::fmi2SetupExperiment::<B>(component, 0, 0.0, start, c_int::from(input.byte() & 1), stop)
                }
                1 => ffi::fmi2EnterInitializationMode::<B>(component),
                2 => ffi::fmi2ExitInitializationMode::<B>(component),
                3 => ffi::fmi2Terminate::<B>(component),
                4 => {
                    slots[which].forged = false;
                    ffi::fmi2Reset::<B>(component)
                }
                5 | 6 => {
                    let values: [f64; 3] = std::array::from_fn(|_| input.real());
                    ffi::fmi2SetReal::<B>(component, vr, count, values.as_ptr())
                }
                7 => {
                    let values: [c_int; 3] = std::array::from_fn(|_| c_int::from_le_bytes(input.take()));
                    ffi::fmi2SetInteger::<B>(component, vr, count, values.as_ptr())
                }
                8 => {
                    let values: [Boolean; 3] = std::array::from_fn(|_| Boolean(c_int::from(input.byte())));
                    ffi::fmi2SetBoolean::<B>(component, vr, count, values.as_ptr())
                }
                9 => ffi::fmi2GetReal::<B>(component, vr, count, [0.0; 3].as_mut_ptr()),
                10 => ffi::fmi2GetInteger::<B>(component, vr, count, [0; 3].as_mut_ptr()),
                11 => {
                    ffi::fmi2GetBoolean::<B>(component, vr, count, [Boolean(0); 3].as_mut_ptr())
                }
                12..15 if !slots[which].forged => {
                    let (mut period, mut end) = (0.0, 0.0);
                    ffi::fmi2GetReal::<B>(component, &raw const cycle, 1, &raw mut period);
                    let real = &raw mut end;
                    ffi::fmi2GetRealStatus::<B>(component, 2, real);
                    let h = period * [1.0, 0.1, 1.0 / 3.0, 7.0, 1e-9, 1e13][input.below(6)];
                    let (tc, h) = match input.byte() {
                        0 => (input.real(), h),
                        1 => (end, input.real()),
                        2 => (end + 0.5 * h, h),
                        3 => (end - 0.5 * h, h),
                        _ => (end, h),
                    };
                    // A step that would take long is left out.
                    let calls = (tc + h - end) / period;
                    if (1000.0..1e10).contains(&calls) { 0 } else { ffi::fmi2DoStep::<B>(component, tc, h, 1) }
                }
                15 => {
                    let mut state = if slots[which].states.len() < 5 {
                        ptr::null_mut()
                    } else {
                        state_of(&slots, which, &mut input)
                    };
                    let status = ffi::fmi2GetFMUstate::<B>(component, &raw mut state);
                    if status == 0 && !slots[which].states.contains(&state) {
                        slots[which].states.push(state);
                    }
                    status
                }
                16 => {
                    let state = state_of(&slots, which, &mut input);
                    ffi::fmi2SetFMUstate::<B>(component, state)
                }
                17 => {
                    let mut state = state_of(&slots, which, &mut input);
                    let freed = state;
                    let status = ffi::fmi2FreeFMUstate::<B>(component, &raw mut state);
                    if status == 0 {
                        slots[which].states.retain(|known| *known != freed);
                    }
                    status
                }
                18 => {
                    let (state, mut size) = (state_of(&slots, which, &mut input), 0);
                    ffi::fmi2SerializedFMUstateSize::<B>(component, state, &raw mut size)
                }
                19 => {
                    let (state, mut bytes) = (state_of(&slots, which, &mut input), [0; 2000]);
                    let size = usize::from(u16::from_le_bytes(input.take())) % 2000;
                    ffi::fmi2SerializeFMUstate::<B>(component, state, bytes.as_mut_ptr(), size)
                }
                20 => {
                    let bytes = forge(before.clone(), &mut input);
                    let mut state = ptr::null_mut();
                    let status =
                        ffi::fmi2DeSerializeFMUstate::<B>(component, bytes.as_ptr(), bytes.len(), &raw mut state);
                    if status == 0 {
                        slots[which].forged |= bytes != before;
                        assert_eq!(ffi::fmi2SetFMUstate::<B>(component, state), 0);
                        assert_eq!(ffi::fmi2FreeFMUstate::<B>(component, &raw mut state), 0);
                        // What was restored can be saved and restored again.
                        let again = snapshot::<B>(&mut slots[which]);
                        let from = again.as_ptr();
                        assert_eq!(ffi::fmi2DeSerializeFMUstate::<B>(component, from, again.len(), &raw mut state), 0);
                        assert_eq!(ffi::fmi2SetFMUstate::<B>(component, state), 0);
                        assert_eq!(ffi::fmi2FreeFMUstate::<B>(component, &raw mut state), 0);
                        assert!(snapshot::<B>(&mut slots[which]) == again, "a restored state is another one");
                    }
                    status
                }
                21 => {
                    let orders: [c_int; 3] = std::array::from_fn(|_| c_int::from(input.byte()) - 1);
                    let values: [f64; 3] = std::array::from_fn(|_| input.real());
                    ffi::fmi2SetRealInputDerivatives::<B>(component, vr, count, orders.as_ptr(), values.as_ptr())
                }
                22 => {
                    let texts = [c"logStatusError", c"logStatusDiscard", c"?"];
                    let names: [*const c_char; 3] =
                        std::array::from_fn(|_| texts.get(input.below(4)).map_or(ptr::null(), |text| text.as_ptr()));
                    ffi::fmi2SetDebugLogging::<B>(component, c_int::from(input.byte() & 1), count, names.as_ptr())
                }
                23 => {
                    let kind = c_int::from(input.byte()) - 1;
                    let mut boolean = Boolean(0);
                    ffi::fmi2GetBooleanStatus::<B>(component, kind, &raw mut boolean)
                }
                _ => ffi::fmi2SetString::<B>(component, vr, count, std::ptr::null()),
            }
        };
        assert!((0..=3).contains(&status), "status {status}");
        if status != 0 {
            assert!(snapshot::<B>(&mut slots[which]) == before, "a refused call changed something");
        }
    }
    for slot in slots {
        // SAFETY: a living component, freed once.
        unsafe { ffi::fmi2FreeInstance::<B>(slot.component) };
    }
}

fuzz_target!(|bytes: &[u8]| {
    let mut input = Bytes(bytes);
    match input.below(5) {
        0 => run::<ContC>(input),
        1 => run::<ContS>(input),
        2 => run::<Pulsegen>(input),
        3 => run::<PulsCtr>(input),
        _ => run::<Hlg>(input),
    }
});
