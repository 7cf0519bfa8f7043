//! The code shared by the C functions of all versions of the standard: pointers become slices and references, values
//! are read and written, and `functions!` generates the functions of a table. The `ffi` module of each version states
//! what the host must guarantee and what is detected.

#![allow(unsafe_code)]
// The contract in the `ffi` modules is the safety section of every function here.
#![allow(clippy::missing_safety_doc)]

use crate::component::{Component, Library};
use crate::cyclic::Cyclic;
use crate::door::{Door, Host};
use crate::host_type::{HostType, Version};
use crate::messages;
use crate::refusal::{Answer, Refusal};
use crate::state::Function;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::{ptr, slice};

/// The status that a function returns, a C enum.
pub type Status = c_int;
pub(crate) const OK: Status = 0;
pub(crate) const DISCARD: Status = 2;
pub(crate) const ERROR: Status = 3;
pub(crate) const FATAL: Status = 4;

/// The status for a result.
pub(crate) fn status(answer: Result<(), Answer>) -> Status {
    match answer {
        Ok(()) => OK,
        Err(Answer::Error) => ERROR,
        Err(Answer::Discard) => DISCARD,
        Err(Answer::Fatal) => FATAL,
    }
}

/// The door behind a host's instance pointer; `None` if it is NULL.
#[inline(always)]
unsafe fn door<'a, L: Library, H: Host>(instance: *mut c_void) -> Option<&'a mut Door<L::Block, H>> {
    // SAFETY: if it is not NULL, the library created it, by the host's contract.
    unsafe { instance.cast::<Door<L::Block, H>>().as_mut() }
}

/// Runs a function on an instance through its door and returns its status; an error if the instance is NULL.
#[inline(always)]
pub(crate) unsafe fn enter<L: Library, H: Host>(
    instance: *mut c_void,
    function: &'static Function,
    body: impl FnOnce(&mut Component<L::Block>) -> Result<(), Refusal>,
) -> Status {
    // SAFETY: the host's contract.
    unsafe { door::<L, H>(instance) }.map_or(ERROR, |door| status(door.enter(function, body)))
}

/// The array of `length` elements at `pointer`; NULL is allowed for length 0.
#[inline(always)]
pub(crate) unsafe fn array<'a, T>(pointer: *const T, length: usize, name: &str) -> Result<&'a [T], Refusal> {
    let pointer = elements(pointer.cast_mut(), length, name)?;
    // SAFETY: not NULL, no longer than an allocation can be, and as long as the host states.
    Ok(unsafe { slice::from_raw_parts(pointer, length) })
}

/// Like [`array`], but writable.
#[inline(always)]
pub(crate) unsafe fn array_mut<'a, T>(pointer: *mut T, length: usize, name: &str) -> Result<&'a mut [T], Refusal> {
    let pointer = elements(pointer, length, name)?;
    // SAFETY: as in `array`, and nothing else uses it during the call.
    Ok(unsafe { slice::from_raw_parts_mut(pointer, length) })
}

#[inline(always)]
fn elements<T>(pointer: *mut T, length: usize, name: &str) -> Result<*mut T, Refusal> {
    if pointer.is_null() || length > isize::MAX as usize / size_of::<T>() {
        no_array(pointer.is_null(), length, name)?;
        return Ok(ptr::dangling_mut());
    }
    Ok(pointer)
}

/// Accepts NULL for an array without elements. Otherwise, rejects the array because it is NULL or too long.
#[cold]
fn no_array(is_null: bool, length: usize, name: &str) -> Result<(), Refusal> {
    match is_null {
        true if length == 0 => Ok(()),
        true => Err(messages::no_elements(name, length).into()),
        false => Err(messages::too_many_elements(name, length).into()),
    }
}

/// The host's variable for a result.
#[inline(always)]
pub(crate) unsafe fn target<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Refusal> {
    // SAFETY: if it is not NULL, it points to the host's variable.
    match unsafe { pointer.as_mut() } {
        Some(target) => Ok(target),
        None => Err(messages::no_target(name).into()),
    }
}

pub(crate) unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not NULL, and a C string by the host's contract.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// Reads texts. The component owns the strings, which remain valid until its next call.
pub(crate) unsafe fn get_strings<V: Version, B: Cyclic>(
    component: &mut Component<B>,
    references: *const u32,
    count: usize,
    values: *mut *const c_char,
) -> Result<(), Refusal> {
    // SAFETY: the host's contract.
    let (references, values) = unsafe { (array(references, count, "vr")?, array_mut(values, count, "value")?) };
    let texts = component.instance.get_texts::<V>(references)?;
    component.texts = texts.into_iter().map(terminated).collect();
    for (value, text) in values.iter_mut().zip(&component.texts) {
        *value = text.as_ptr();
    }
    Ok(())
}

/// The text as a C string, truncated before its first NUL.
fn terminated(text: String) -> CString {
    let end = text.find('\0').unwrap_or(text.len());
    CString::new(&text[..end]).unwrap_or_default()
}

/// Writes texts.
pub(crate) unsafe fn set_strings<V: Version, B: Cyclic>(
    component: &mut Component<B>,
    references: *const u32,
    count: usize,
    values: *const *const c_char,
) -> Result<(), Refusal> {
    // SAFETY: the host's contract.
    let (references, values) = unsafe { (array(references, count, "vr")?, array(values, count, "value")?) };
    // SAFETY: the host's contract.
    let texts: Vec<Option<&CStr>> = values.iter().map(|value| unsafe { text(*value) }).collect();
    component.instance.set_texts::<V>(references, &texts)
}

/// Reads variables.
#[inline(always)]
pub(crate) unsafe fn get<V: Version, B: Cyclic, T: HostType<V>>(
    component: &Component<B>,
    references: *const u32,
    count: usize,
    values: *mut T,
) -> Result<(), Refusal> {
    // SAFETY: the host's contract.
    unsafe { component.instance.get(array(references, count, "vr")?, array_mut(values, count, "value")?) }
}

/// Writes variables.
#[inline(always)]
pub(crate) unsafe fn set<V: Version, B: Cyclic, T: HostType<V>>(
    component: &mut Component<B>,
    references: *const u32,
    count: usize,
    values: *const T,
) -> Result<(), Refusal> {
    // SAFETY: the host's contract.
    unsafe { component.instance.set(array(references, count, "vr")?, array(values, count, "value")?) }
}

/// Generates from each line of the table
///
/// - a [`Function`]: its name and the states in which the standard allows it;
/// - a Rust function for any [`Library`], whose first argument is a component and which runs the code after `=>`
///   through its door; or, with `{ }`, only runs that code;
/// - a C function of an FMU's library, exported by `export!`. `$d` is a `$` of that macro.
macro_rules! functions {
    (($d:tt) $export:ident: $version:ident, in $step:literal, with $($used:ident),*; $(
        $name:ident $([$($state:ident)*])? ($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)?
            $({ $($plain:tt)* })?
            $(=> |$c:ident| $body:expr)?;
    )*) => {
        impl Function { $(
            #[doc = concat!("`", stringify!($name), "`")]
            pub const $name: Function = Function::new(stringify!($name), &[$($(State::$state),*)?], $step);
        )* }

        /// The names of the functions.
        pub const FUNCTIONS: &[&str] = &[$(stringify!($name)),*];

        /// The functions.
        pub(crate) static TABLE: &[Function] = &[$(Function::$name),*];

        $( functions! { @function $name ($($argument: $type),*) ($($result)?)
            $({ $($plain)* })? $(=> |$c| $body)? } )*

        #[doc = concat!("Adds to an FMU's library the C functions of ", stringify!($version), ".")]
        #[macro_export]
        macro_rules! $export {
            ($d Library:ty) => {
                // The exported C functions. They are unsafe because the host must honour the contract of `ffi`.
                #[allow(unsafe_code, missing_docs, non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]
                mod $version {
                    use super::*;
                    use $crate::$version::ffi::{$($used),*};

                    type TheLibrary = $d Library;

                    $(
                        #[unsafe(no_mangle)]
                        pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
                            // SAFETY: the obligation is passed on to the host.
                            unsafe { $crate::$version::ffi::$name::<TheLibrary>($($argument),*) }
                        }
                    )*
                }
            };
        }
    };

    (@function $name:ident ($($argument:ident: $type:ty),*) ($($result:ty)?) { $($plain:tt)* }) => {
        pub unsafe fn $name<L: Library>($($argument: $type),*) $(-> $result)? {
            $($plain)*
        }
    };
    (@function $name:ident ($component:ident: $Pointer:ty $(, $argument:ident: $type:ty)*) ($result:ty) => |$c:ident| $body:expr) => {
        pub unsafe fn $name<L: Library>($component: $Pointer $(, $argument: $type)*) -> $result {
            // SAFETY: the host's contract.
            #[allow(unused_unsafe)]
            unsafe { enter::<L, Caller>($component, &Function::$name, |$c| $body) }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_is_null_only_with_length_0() {
        // SAFETY: NULL, which is recognized before it is read.
        let of = |length| unsafe { array::<f64>(ptr::null(), length, "value") };
        assert!(of(0).unwrap().is_empty());
        assert_eq!(of(3).unwrap_err().reason(), "value is NULL; an array of length 3 is required");
        let value = 1.5;
        // SAFETY: one element is there; the other lengths are refused before anything is read.
        let of = |length| unsafe { array(&raw const value, length, "value") };
        assert_eq!(of(1).unwrap(), [1.5]);
        let longest = isize::MAX as usize / 8;
        for length in [longest + 1, usize::MAX] {
            assert_eq!(
                of(length).unwrap_err().reason(),
                format!("value cannot have {length} elements: they would not fit in memory")
            );
        }
    }
}
