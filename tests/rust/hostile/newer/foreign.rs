//! The functions that a host of co-simulation without Clocks never calls. They refuse, or have nothing to do; but they are there.

use host::library::Pointer;
use libloading::Library;
use std::ffi::{CStr, c_char, c_int};
use std::path::Path;
use std::ptr;

/// The library once more: functions are looked for where they are called.
pub(crate) struct Functions(Library);

/// Calls a function by its name, whose arguments after the instance have these types.
macro_rules! call {
    ($self:ident $name:ident ($($argument:expr => $Type:ty),*)) => {{
        type Function = unsafe extern "C" fn($($Type),*) -> c_int;
        // SAFETY: the standard gives the function this type.
        let function = unsafe { $self.0.get::<Function>($name) }.unwrap_or_else(|error| panic!("{error}"));
        // SAFETY: NULL or a living instance; a count of 0 or more that is to be refused.
        unsafe { function($($argument),*) }
    }};
}

impl Functions {
    pub(crate) fn of(path: &Path) -> Functions {
        // SAFETY: a library of ours.
        Functions(unsafe { Library::new(path) }.unwrap_or_else(|error| panic!("{error}")))
    }

    /// Asks for an instance of another kind of simulation: there is none.
    pub(crate) fn instantiate(&self, name: &str, token: &CStr) {
        let (name_of, token, none) = (c"a".as_ptr(), token.as_ptr(), ptr::null());
        type Exchange =
            unsafe extern "C" fn(*const c_char, *const c_char, *const c_char, bool, bool, Pointer, Pointer) -> Pointer;
        type Scheduled = unsafe extern "C" fn(
            *const c_char,
            *const c_char,
            *const c_char,
            bool,
            bool,
            Pointer,
            Pointer,
            Pointer,
            Pointer,
            Pointer,
        ) -> Pointer;
        let null = ptr::null_mut();
        // SAFETY: the standard gives the functions these types; there is no logger.
        let instance = unsafe {
            match name {
                "fmi3InstantiateModelExchange" => {
                    let function = self.0.get::<Exchange>(name).unwrap_or_else(|error| panic!("{error}"));
                    function(name_of, token, none, true, true, null, null)
                }
                _ => {
                    let function = self.0.get::<Scheduled>(name).unwrap_or_else(|error| panic!("{error}"));
                    function(name_of, token, none, true, true, null, null, null, null, null)
                }
            }
        };
        assert!(instance.is_null(), "{name} gave an instance");
    }

    /// What a function answers that has `count` of something to do.
    pub(crate) fn call(&self, name: &str, instance: Pointer, count: usize) -> Option<c_int> {
        let (null, vr) = (ptr::null_mut::<u8>(), [0_u32; 8].as_ptr());
        Some(match name {
            "fmi3GetClock"
            | "fmi3SetClock"
            | "fmi3GetShiftDecimal"
            | "fmi3SetShiftDecimal"
            | "fmi3SetIntervalDecimal" => {
                call!(self name (instance => Pointer, vr => *const u32, count => usize, null => *mut u8))
            }
            "fmi3GetIntervalDecimal" | "fmi3GetShiftFraction" | "fmi3SetIntervalFraction" | "fmi3SetShiftFraction" => {
                call!(self name (instance => Pointer, vr => *const u32, count => usize, null => *mut u8, null => *mut u8))
            }
            "fmi3GetIntervalFraction" => {
                call!(self name (
                    instance => Pointer, vr => *const u32, count => usize, null => *mut u8, null => *mut u8, null => *mut u8
                ))
            }
            "fmi3EvaluateDiscreteStates" | "fmi3EnterContinuousTimeMode" => call!(self name (instance => Pointer)),
            "fmi3CompletedIntegratorStep" => {
                call!(self name (instance => Pointer, true => bool, null => *mut u8, null => *mut u8))
            }
            "fmi3SetTime" => call!(self name (instance => Pointer, 1.0 => f64)),
            "fmi3SetContinuousStates"
            | "fmi3GetContinuousStateDerivatives"
            | "fmi3GetEventIndicators"
            | "fmi3GetContinuousStates"
            | "fmi3GetNominalsOfContinuousStates" => {
                call!(self name (instance => Pointer, null => *mut u8, count => usize))
            }
            "fmi3GetNumberOfEventIndicators" | "fmi3GetNumberOfContinuousStates" => {
                call!(self name (instance => Pointer, null => *mut u8))
            }
            "fmi3ActivateModelPartition" => call!(self name (instance => Pointer, 0 => u32, 1.0 => f64)),
            _ => return None,
        })
    }
}
