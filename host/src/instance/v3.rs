//! Calls an FMI 3.0 instance.

use super::{Failed, Message, Messages, Start, Stopped, Type, Unset, WARNING, cut, done, said};
use crate::library::Pointer;
use crate::library::v3::Library;
use modeldescription::Array;
use run::component::{MOST_UPDATES, Update};
use std::ffi::{CStr, c_char, c_int};
use std::ptr;

/// The maximum number of consecutive early returns from a step at the same simulation time.
const MOST_ENDS: usize = 1000;

/// The fraction of a step's size that is ignored as a rounding error.
const ROUNDING: f64 = 1e-9;

/// An FMI 3.0 instance.
#[derive(Debug)]
pub(super) struct Instance {
    pub library: Library,
    component: Pointer,
    has_events: bool,
    is_in_event_mode: bool,
    /// The start and, if known, the end of the simulation in seconds.
    times: (f64, Option<f64>),
    /// The arrays, ordered by their first references.
    arrays: Vec<Elements>,
    /// A buffer for values of any type, kept so that a step does not allocate.
    buffer: Vec<u64>,
    /// A buffer for the elements of an array being read or written.
    elements: Vec<f64>,
}

/// An array variable. FMI sets all elements in one call: to set one of them, the values of the others are kept here.
#[derive(Debug)]
struct Elements {
    array: Array,
    /// The start values, restored by a reset.
    starts: Vec<f64>,
    /// The values set last, initially the start values.
    set: Vec<f64>,
}

/// A C type whose values are converted to and from the engine's cells.
trait Plain: Copy {
    fn cell(self) -> f64;
    fn from_cell(cell: f64) -> Option<Self>;
}

macro_rules! plain {
    ($($of:ident)*) => {$(
        impl Plain for $of {
            fn cell(self) -> f64 {
                f64::from(self)
            }

            fn from_cell(cell: f64) -> Option<$of> {
                let value = cell as $of;
                (f64::from(value) == cell).then_some(value)
            }
        }
    )*};
}

plain! { i8 u8 i16 u16 i32 u32 }

impl Plain for f32 {
    fn cell(self) -> f64 {
        f64::from(self)
    }

    /// Rounds, as a connection from a Float64 requires.
    fn from_cell(cell: f64) -> Option<f32> {
        let value = cell as f32;
        (value.is_finite() || !cell.is_finite()).then_some(value)
    }
}

impl Plain for i64 {
    fn cell(self) -> f64 {
        f64::from_bits(self as u64)
    }

    fn from_cell(cell: f64) -> Option<i64> {
        Some(cell.to_bits() as i64)
    }
}

impl Plain for u64 {
    fn cell(self) -> f64 {
        f64::from_bits(self)
    }

    fn from_cell(cell: f64) -> Option<u64> {
        Some(cell.to_bits())
    }
}

/// The `bool` of C.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Boolean(u8);

impl Plain for Boolean {
    fn cell(self) -> f64 {
        f64::from(u8::from(self.0 != 0))
    }

    fn from_cell(cell: f64) -> Option<Boolean> {
        Some(Boolean(u8::from(cell != 0.0)))
    }
}

impl Instance {
    /// Calls `fmi3InstantiateCoSimulation`; `None` if the FMU refuses. The messages must outlive the instance.
    pub(super) fn new(
        library: &Library,
        name: &CStr,
        token: &CStr,
        resources: Option<&CStr>,
        messages: &Messages,
        start: &Start,
    ) -> Option<Instance> {
        // SAFETY: the strings are NUL-terminated and outlive the call; the messages live as long as the instance.
        let component = unsafe {
            (library.instantiate_co_simulation)(
                name.as_ptr(),
                token.as_ptr(),
                resources.map_or(ptr::null(), CStr::as_ptr),
                false,
                true,
                start.has_events,
                start.has_events,
                ptr::null(),
                0,
                ptr::from_ref(messages).cast_mut().cast(),
                Some(log),
                None,
            )
        };
        if component.is_null() {
            return None;
        }
        let elements = |(array, starts): &(Array, Vec<f64>)| Elements {
            array: array.clone(),
            starts: starts.clone(),
            set: starts.clone(),
        };
        let mut arrays: Vec<Elements> = start.arrays.iter().map(elements).collect();
        arrays.sort_by_key(|of| of.array.first_reference);
        Some(Instance {
            library: library.clone(),
            component,
            has_events: start.has_events,
            is_in_event_mode: false,
            times: (0.0, None),
            arrays,
            buffer: Vec::new(),
            elements: Vec::new(),
        })
    }

    pub(super) fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<(), Failed> {
        self.times = (start, stop);
        Ok(())
    }

    pub(super) fn enter_initialization(&mut self) -> Result<(), Failed> {
        let (start, stop) = self.times;
        let (is_defined, stop) = (stop.is_some(), stop.unwrap_or(0.0));
        let enter = self.library.enter_initialization_mode;
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { enter(self.component, false, 0.0, start, is_defined, stop) };
        done("fmi3EnterInitializationMode", status)
    }

    pub(super) fn exit_initialization(&mut self) -> Result<(), Failed> {
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.exit_initialization_mode)(self.component) };
        self.is_in_event_mode = self.has_events;
        done("fmi3ExitInitializationMode", status)
    }

    pub(super) fn enter_events(&mut self) -> Result<(), Failed> {
        if self.is_in_event_mode {
            return Ok(());
        }
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.enter_event_mode)(self.component) };
        done("fmi3EnterEventMode", status)?;
        self.is_in_event_mode = true;
        Ok(())
    }

    pub(super) fn update(&mut self) -> Result<Update, Stopped> {
        let (mut again, mut ends, mut nominals, mut values, mut is_next, mut next) = (0, 0, 0, 0, 0, 0.0);
        // SAFETY: the component belongs to this instance and is alive; there is space for each value.
        let status = unsafe {
            (self.library.update_discrete_states)(
                self.component,
                &mut again,
                &mut ends,
                &mut nominals,
                &mut values,
                &mut is_next,
                &mut next,
            )
        };
        done("fmi3UpdateDiscreteStates", status).map_err(Stopped::Failed)?;
        if ends != 0 {
            return Err(Stopped::Terminated);
        }
        if is_next != 0 && next.is_nan() {
            return Err(Stopped::Astray("fmi3UpdateDiscreteStates returned NaN as the time of the next event".into()));
        }
        Ok(Update { is_needed: again != 0, next: (is_next != 0).then_some(next) })
    }

    pub(super) fn leave_events(&mut self) -> Result<(), Failed> {
        if !self.is_in_event_mode {
            return Ok(());
        }
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.enter_step_mode)(self.component) };
        done("fmi3EnterStepMode", status)?;
        self.is_in_event_mode = false;
        Ok(())
    }

    #[inline]
    pub(super) fn step(&mut self, time: f64, size: f64) -> Result<(), Stopped> {
        let end = time + size;
        let (mut at, mut left) = (time, size);
        let mut ends = 0;
        loop {
            let (mut event, mut terminates, mut is_early, mut last) = (0, 0, 0, f64::NAN);
            // SAFETY: the component belongs to this instance and is alive; there is space for each value.
            let status = unsafe {
                (self.library.do_step)(
                    self.component,
                    at,
                    left,
                    true,
                    &mut event,
                    &mut terminates,
                    &mut is_early,
                    &mut last,
                )
            };
            if status != 0 && status != WARNING {
                return Err(Stopped::Failed(("fmi3DoStep", status)));
            }
            if terminates != 0 {
                return Err(Stopped::Terminated);
            }
            if is_early == 0 {
                return Ok(());
            }
            if !self.has_events {
                return Err(Stopped::Astray(format!(
                    "fmi3DoStep returned early at {last:?} s although early return was not allowed"
                )));
            }
            if !(last >= at - ROUNDING * size && last <= end + ROUNDING * size) {
                return Err(Stopped::Astray(format!(
                    "fmi3DoStep returned early at {last:?} s, which is outside the step"
                )));
            }
            ends = if last > at { 0 } else { ends + 1 };
            if ends > MOST_ENDS {
                return Err(Stopped::Astray(format!("fmi3DoStep repeatedly returned early at {last:?} s")));
            }
            (at, left) = (last, end - last);
            // The caller handles an event at the end of the step, together with the events of other FMUs.
            if left <= ROUNDING * size {
                return Ok(());
            }
            self.handle_event()?;
        }
    }

    /// Handles an event within a step, with unchanged inputs.
    fn handle_event(&mut self) -> Result<(), Stopped> {
        self.enter_events().map_err(Stopped::Failed)?;
        for _ in 0..MOST_UPDATES {
            if !self.update()?.is_needed {
                return self.leave_events().map_err(Stopped::Failed);
            }
        }
        Err(Stopped::Astray(format!(
            "fmi3UpdateDiscreteStates still requested another call after {MOST_UPDATES} calls"
        )))
    }

    pub(super) fn terminate(&mut self) -> Result<(), Failed> {
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.terminate)(self.component) };
        done("fmi3Terminate", status)
    }

    pub(super) fn reset(&mut self) -> Result<(), Failed> {
        // SAFETY: the component belongs to this instance and is alive.
        let status = unsafe { (self.library.reset)(self.component) };
        self.is_in_event_mode = false;
        for of in &mut self.arrays {
            of.set.clone_from(&of.starts);
        }
        done("fmi3Reset", status)
    }

    /// Frees the instance, which must not be called afterwards.
    pub(super) fn free(&mut self) {
        // SAFETY: the component belongs to this instance and is not used afterwards.
        unsafe { (self.library.free_instance)(self.component) }
    }

    #[inline]
    pub(super) fn get_all(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<(), Failed> {
        if self.arrays.is_empty() {
            return self.get(kind, references, values);
        }
        let mut at = 0;
        while at < references.len() {
            let (of, end) = self.group(references, at);
            match of {
                None => self.get(kind, &references[at..end], &mut values[at..end])?,
                Some(of) => {
                    let Array { value_reference, first_reference, count, .. } = self.arrays[of].array;
                    let mut all = std::mem::take(&mut self.elements);
                    all.clear();
                    all.resize(count, 0.0);
                    let done = self.get(kind, &[value_reference], &mut all);
                    for (value, reference) in values[at..end].iter_mut().zip(&references[at..end]) {
                        *value = all[(reference - first_reference) as usize];
                    }
                    self.elements = all;
                    done?;
                }
            }
            at = end;
        }
        Ok(())
    }

    #[inline]
    pub(super) fn set_all(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<(), Unset> {
        if self.arrays.is_empty() {
            return self.set(kind, references, values);
        }
        let mut at = 0;
        while at < references.len() {
            let (of, end) = self.group(references, at);
            match of {
                None => self.set(kind, &references[at..end], &values[at..end])?,
                Some(of) => {
                    let Array { value_reference, first_reference, .. } = self.arrays[of].array;
                    let mut all = std::mem::take(&mut self.elements);
                    all.clone_from(&self.arrays[of].set);
                    for (value, reference) in values[at..end].iter().zip(&references[at..end]) {
                        all[(reference - first_reference) as usize] = *value;
                    }
                    let done = self.set(kind, &[value_reference], &all);
                    if done.is_ok() {
                        std::mem::swap(&mut self.arrays[of].set, &mut all);
                    }
                    self.elements = all;
                    done?;
                }
            }
            at = end;
        }
        Ok(())
    }

    /// The index of the array to which the reference at position `at` belongs (`None` for a scalar), and the end of the
    /// consecutive references for which it is the same.
    fn group(&self, references: &[u32], at: usize) -> (Option<usize>, usize) {
        let array = |reference: u32| {
            let after = self.arrays.partition_point(|of| of.array.first_reference <= reference);
            let of = after.checked_sub(1)?;
            let Array { first_reference, count, .. } = self.arrays[of].array;
            ((reference - first_reference) as usize).lt(&count).then_some(of)
        };
        let of = array(references[at]);
        let end = references[at..].iter().position(|reference| array(*reference) != of);
        (of, end.map_or(references.len(), |end| at + end))
    }

    /// Reads variables by references known to the FMU: several scalars, or one array.
    #[inline]
    fn get(&mut self, kind: Type, references: &[u32], values: &mut [f64]) -> Result<(), Failed> {
        let Instance { library, component, buffer, .. } = self;
        let (from, count, values_count) = (references.as_ptr(), references.len(), values.len());
        macro_rules! get {
            ($function:ident, $name:literal, $of:ty, $as:ty) => {{
                buffer.clear();
                buffer.resize(values_count, 0);
                let room = buffer.as_mut_ptr().cast::<$of>();
                // SAFETY: the component belongs to this instance and is alive; there are `count` references and space
                // for `values_count` values of at most 64 bits each.
                done($name, unsafe { (library.$function)(*component, from, count, room.cast::<$as>(), values_count) })?;
                // SAFETY: there are as many values of the type, and all bit patterns are valid.
                let got = unsafe { std::slice::from_raw_parts(room, values_count) };
                for (value, got) in values.iter_mut().zip(got) {
                    *value = got.cell();
                }
                Ok(())
            }};
        }
        match kind {
            Type::Real => {
                // SAFETY: the component belongs to this instance and is alive; there are `count` references and space
                // for the values.
                let status =
                    unsafe { (library.get_float64)(*component, from, count, values.as_mut_ptr(), values_count) };
                done("fmi3GetFloat64", status)
            }
            Type::Float32 => get!(get_float32, "fmi3GetFloat32", f32, f32),
            Type::Int8 => get!(get_int8, "fmi3GetInt8", i8, i8),
            Type::UInt8 => get!(get_uint8, "fmi3GetUInt8", u8, u8),
            Type::Int16 => get!(get_int16, "fmi3GetInt16", i16, i16),
            Type::UInt16 => get!(get_uint16, "fmi3GetUInt16", u16, u16),
            Type::Integer => get!(get_int32, "fmi3GetInt32", i32, i32),
            Type::UInt32 => get!(get_uint32, "fmi3GetUInt32", u32, u32),
            Type::Int64 => get!(get_int64, "fmi3GetInt64", i64, i64),
            Type::UInt64 => get!(get_uint64, "fmi3GetUInt64", u64, u64),
            Type::Boolean => get!(get_boolean, "fmi3GetBoolean", Boolean, u8),
        }
    }

    /// Sets variables by references known to the FMU: several scalars, or one array.
    #[inline]
    fn set(&mut self, kind: Type, references: &[u32], values: &[f64]) -> Result<(), Unset> {
        let Instance { library, component, buffer, .. } = self;
        let (to, count, values_count) = (references.as_ptr(), references.len(), values.len());
        macro_rules! set {
            ($function:ident, $name:literal, $of:ty, $as:ty) => {{
                buffer.clear();
                buffer.resize(values_count, 0);
                let room = buffer.as_mut_ptr().cast::<$of>();
                for (place, value) in values.iter().enumerate() {
                    let Some(converted) = <$of>::from_cell(*value) else { return Err(Unset::Value(*value)) };
                    // SAFETY: there is space for as many values of at most 64 bits each.
                    unsafe { room.add(place).write(converted) };
                }
                // SAFETY: the component belongs to this instance and is alive; there are `count` references and
                // `values_count` values.
                done($name, unsafe { (library.$function)(*component, to, count, room.cast::<$as>(), values_count) })
            }};
        }
        let set = match kind {
            Type::Real => {
                // SAFETY: the component belongs to this instance and is alive; there are `count` references and the
                // values.
                let status = unsafe { (library.set_float64)(*component, to, count, values.as_ptr(), values_count) };
                done("fmi3SetFloat64", status)
            }
            Type::Float32 => set!(set_float32, "fmi3SetFloat32", f32, f32),
            Type::Int8 => set!(set_int8, "fmi3SetInt8", i8, i8),
            Type::UInt8 => set!(set_uint8, "fmi3SetUInt8", u8, u8),
            Type::Int16 => set!(set_int16, "fmi3SetInt16", i16, i16),
            Type::UInt16 => set!(set_uint16, "fmi3SetUInt16", u16, u16),
            Type::Integer => set!(set_int32, "fmi3SetInt32", i32, i32),
            Type::UInt32 => set!(set_uint32, "fmi3SetUInt32", u32, u32),
            Type::Int64 => set!(set_int64, "fmi3SetInt64", i64, i64),
            Type::UInt64 => set!(set_uint64, "fmi3SetUInt64", u64, u64),
            Type::Boolean => set!(set_boolean, "fmi3SetBoolean", Boolean, u8),
        };
        set.map_err(Unset::Failed)
    }
}

unsafe extern "C" fn log(environment: Pointer, status: c_int, _category: *const c_char, text: *const c_char) {
    // SAFETY: this is the environment passed by `new`, which lives as long as the instance.
    let Some(messages) = (unsafe { environment.cast::<Messages>().as_ref() }) else { return };
    // SAFETY: NULL or a C string according to FMI.
    let Some(text) = (unsafe { said(text) }) else { return };
    messages.add(Message { is_error: status > WARNING, text: cut(text.trim_end().to_string()) });
}
