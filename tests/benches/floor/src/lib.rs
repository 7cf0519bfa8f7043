//! The minimum cost of one control cycle through C functions: the law of CONT_C, its values in an array, and no checks.
//! The benchmark `cycle` compares it with the FMU.
//!
//! This is not an FMU: it has only the functions that a control cycle needs, and wrong arguments are undefined
//! behavior.

// The functions are called through C.
#![allow(unsafe_code)]

use blocks::{Block, ContC, Law};
use std::ffi::c_int;
use std::ptr;

/// The controller and its values by value reference.
#[derive(Debug)]
pub struct Floor {
    values: [f64; COUNT],
    /// Integers and Booleans. They are only stored: their effect in the law is not part of the cost of the functions.
    integers: [c_int; COUNT],
    block: ContC,
}

const COUNT: usize = ContC::TABLE.rows.len();
const SP_INT: usize = reference("SP_INT");
const PV_IN: usize = reference("PV_IN");
const LMN: usize = reference("LMN");

const fn reference(name: &str) -> usize {
    let mut row = 0;
    while !ContC::TABLE.rows[row].name.eq_ignore_ascii_case(name) {
        row += 1;
    }
    row
}

/// A PI controller in automatic mode, restarted.
#[unsafe(no_mangle)]
pub extern "C" fn floor_instantiate() -> *mut Floor {
    let mut block = ContC { man_on: false, lmn_llm: -100.0, ..ContC::default() };
    block.restart();
    Box::into_raw(Box::new(Floor { values: [0.0; COUNT], integers: [0; COUNT], block }))
}

/// Sets `count` values.
///
/// # Safety
/// `floor` is an instance; the arrays have `count` elements, the references are those of variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn floor_set_real(
    floor: *mut Floor,
    references: *const u32,
    count: usize,
    values: *const f64,
) -> c_int {
    for i in 0..count {
        // SAFETY: the caller's contract.
        unsafe { *(*floor).values.get_unchecked_mut(*references.add(i) as usize) = *values.add(i) };
    }
    0
}

/// Calls the controller once.
///
/// # Safety
/// `floor` is an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn floor_do_step(floor: *mut Floor, _tc: f64, _h: f64, _no_state_prior: c_int) -> c_int {
    // SAFETY: the caller's contract.
    let Floor { values, block, .. } = unsafe { &mut *floor };
    // Loaded one by one: a single load of both would have to wait until both stores of `floor_set_real` have completed.
    // SAFETY: references to values.
    let [sp_int, pv_in] = [SP_INT, PV_IN].map(|place| unsafe { ptr::read_volatile(&raw const values[place]) });
    block.sp_int = sp_int as f32;
    block.pv_in = pv_in as f32;
    block.call();
    values[LMN] = f64::from(block.lmn);
    0
}

/// Gets `count` values.
///
/// # Safety
/// As `floor_set_real`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn floor_get_real(
    floor: *const Floor,
    references: *const u32,
    count: usize,
    values: *mut f64,
) -> c_int {
    for i in 0..count {
        // SAFETY: the caller's contract.
        unsafe { *values.add(i) = *(*floor).values.get_unchecked(*references.add(i) as usize) };
    }
    0
}

/// Sets `count` integers or Booleans.
///
/// # Safety
/// As `floor_set_real`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn floor_set_integer(
    floor: *mut Floor,
    references: *const u32,
    count: usize,
    values: *const c_int,
) -> c_int {
    for i in 0..count {
        // SAFETY: the caller's contract.
        unsafe { *(*floor).integers.get_unchecked_mut(*references.add(i) as usize) = *values.add(i) };
    }
    0
}

/// Gets `count` integers or Booleans.
///
/// # Safety
/// As `floor_set_real`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn floor_get_integer(
    floor: *const Floor,
    references: *const u32,
    count: usize,
    values: *mut c_int,
) -> c_int {
    for i in 0..count {
        // SAFETY: the caller's contract.
        unsafe { *values.add(i) = *(*floor).integers.get_unchecked(*references.add(i) as usize) };
    }
    0
}

/// Frees an instance.
///
/// # Safety
/// `floor` is an instance, not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn floor_free(floor: *mut Floor) {
    // SAFETY: the caller's contract: `floor_instantiate` made it.
    drop(unsafe { Box::from_raw(floor) });
}
