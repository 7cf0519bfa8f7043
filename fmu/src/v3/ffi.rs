//! The 75 FMI 3.0 functions, as a table that specifies each one once, as for FMI 2.0: its states, its arguments, and
//! the call of the [`Component`]. Calls of the Model Exchange and Scheduled Execution functions are always refused;
//! these functions exist because hosts look up all functions when they load a library.
//!
//! The standard requires the following of the host: a `fmi3Instance` comes from `fmi3InstantiateCoSimulation`, has not
//! been freed and is used by one thread at a time; an array has the length passed with it. NULL is detected everywhere.

#![allow(unsafe_code, non_snake_case, non_upper_case_globals)]
// The contract above is the safety section of every function here.
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use super::access::{self, dependencies};
use super::messages;
pub use super::value::Boolean;
use super::{FORMS, Native, Wide};
pub use crate::component::StateAddress;
use crate::component::{Component, Library};
use crate::cyclic::Cyclic;
use crate::door::{Door, Host};
use crate::host_type::HostType;
use crate::instance::Events;
use crate::log::{self, Category};
pub use crate::pointers::Status;
use crate::pointers::{self, array, array_mut, enter, status, target, text};
use crate::preset::{Argument, Identity};
use crate::refusal::{Answer, Refusal};
use crate::state::{Function, State};
use std::ffi::CStr;
pub use std::ffi::{c_char, c_int, c_void};
use std::ptr;

/// `fmi3DependencyKind`: dependent, without further structure.
const DEPENDENT: c_int = 5;

/// `fmi3Instance`.
pub type Pointer = *mut c_void;

/// `fmi3LogMessageCallback`.
pub type Logger = Option<
    unsafe extern "C" fn(environment: *mut c_void, status: Status, category: *const c_char, message: *const c_char),
>;

/// A callback that this FMU never calls.
pub type Callback = *const c_void;

struct Caller {
    logger: Logger,
    environment: *mut c_void,
}

impl Host for Caller {
    fn tell(&self, function: &Function, answer: Result<(), Answer>, category: &Category, message: &str) {
        let Some(logger) = self.logger else { return };
        let text = log::text(function, message);
        // SAFETY: the host passed the logger and its environment for this purpose, and all strings end with NUL.
        unsafe { logger(self.environment, status(answer), category.name.as_ptr(), text.as_ptr()) }
    }
}

/// Evaluates an expression with `$V` bound to a component's choice of types: the PLC's, or the wide ones.
macro_rules! with_types {
    ($component:expr, $V:ident => $of:expr) => {
        if $component.form() == 0 {
            type $V = Native;
            $of
        } else {
            type $V = Wide;
            $of
        }
    };
}

#[inline(always)]
unsafe fn get<B: Cyclic, T: HostType<Native> + HostType<Wide>>(
    c: &Component<B>,
    vr: *const u32,
    count: usize,
    values: *mut T,
    value_count: usize,
) -> Result<(), Refusal> {
    // SAFETY: the host's contract.
    let (vr, values) = unsafe { (array(vr, count, VR)?, array_mut(values, value_count, VALUES)?) };
    with_types!(c, V => access::get::<V, _, _>(c, vr, values))
}

#[inline(always)]
unsafe fn set<B: Cyclic, T: HostType<Native> + HostType<Wide>>(
    c: &mut Component<B>,
    vr: *const u32,
    count: usize,
    values: *const T,
    value_count: usize,
) -> Result<(), Refusal> {
    // SAFETY: the host's contract.
    let (vr, values) = unsafe { (array(vr, count, VR)?, array(values, value_count, VALUES)?) };
    with_types!(c, V => access::set::<V, _, _>(c, vr, values))
}

/// The value references of the elements of text variables.
unsafe fn texts<B: Cyclic>(
    c: &Component<B>,
    vr: *const u32,
    count: usize,
    value_count: usize,
    access: &str,
) -> Result<Vec<u32>, Refusal> {
    // SAFETY: the host's contract.
    let vr = unsafe { array(vr, count, VR) }?;
    Ok(with_types!(c, V => access::texts::<V, _>(c, vr, value_count, access))?.into_owned())
}

const VR: &str = "valueReferences";
const VALUES: &str = "values";

/// The behaviour of functions for variable types that the FMU does not have.
fn nothing(count: usize, what: &str) -> Result<(), Refusal> {
    match count {
        0 => Ok(()),
        _ => Err(messages::none_of_this_type(what).into()),
    }
}

fn only_co_simulation(kind: &str) -> Result<(), Refusal> {
    Err(messages::function_of_another_kind(kind).into())
}

const EXCHANGE: &str = "Model Exchange";

// FMI 3.0, sections 2.3 and 4.2, in the order of the header. The table is more lenient than the standard because real
// hosts need it: in state Instantiated, Get also works and returns the start values, and inputs may be set; in Step
// Mode, discrete inputs may also be set in an instance with Event Mode.
functions! {
    ($) export_fmi3: v3, in "Step Mode", with Boolean, Callback, Logger, Pointer, StateAddress, Status, c_char, c_int, c_void;
    fmi3GetVersion() -> *const c_char { c"3.0".as_ptr() };
    fmi3SetDebugLogging[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, logging_on: Boolean, count: usize, categories: *const *const c_char,
    ) -> Status => |c| {
        let categories = array(categories, count, "categories")?;
        c.set_debug_logging(logging_on.0 != 0, categories.iter().map(|name| text(*name)))
    };

    fmi3InstantiateModelExchange(
        _instance_name: *const c_char, _token: *const c_char, _resources: *const c_char, _visible: Boolean, _logging_on: Boolean,
        environment: *mut c_void, logger: Logger,
    ) -> Pointer { refuse::<L>(&Function::fmi3InstantiateModelExchange, environment, logger) };
    fmi3InstantiateCoSimulation(
        instance_name: *const c_char, token: *const c_char, resources: *const c_char, _visible: Boolean, logging_on: Boolean,
        event_mode_used: Boolean, early_return_allowed: Boolean, _intermediate_variables: *const u32, _intermediate_count: usize,
        environment: *mut c_void, logger: Logger, _intermediate_update: Callback,
    ) -> Pointer {
        let events = (event_mode_used.0 != 0).then_some(Events { may_return_early: early_return_allowed.0 != 0 });
        // SAFETY: the host's contract.
        unsafe { instantiate::<L>(instance_name, token, resources, logging_on.0 != 0, events, environment, logger) }
    };
    fmi3InstantiateScheduledExecution(
        _instance_name: *const c_char, _token: *const c_char, _resources: *const c_char, _visible: Boolean, _logging_on: Boolean,
        environment: *mut c_void, logger: Logger, _clock_update: Callback, _lock_preemption: Callback, _unlock_preemption: Callback,
    ) -> Pointer { refuse::<L>(&Function::fmi3InstantiateScheduledExecution, environment, logger) };
    fmi3FreeInstance(instance: Pointer) {
        if !instance.is_null() {
            // SAFETY: created by `fmi3InstantiateCoSimulation`, and not used again, by the host's contract.
            unsafe { Box::from_raw(instance.cast::<Door<L::Block, Caller>>()) }.close();
        }
    };

    fmi3EnterInitializationMode[Instantiated](
        instance: Pointer, _tolerance_defined: Boolean, _tolerance: f64, start_time: f64, stop_time_defined: Boolean, stop_time: f64,
    ) -> Status => |c| {
        c.instance.setup_experiment(start_time, (stop_time_defined.0 != 0).then_some(stop_time))?;
        c.instance.enter_initialization_mode(&Function::fmi3EnterInitializationMode)
    };
    fmi3ExitInitializationMode[InitializationMode](instance: Pointer) -> Status => |c| c.exit_initialization_mode();
    fmi3EnterEventMode[StepComplete](instance: Pointer) -> Status => |c| c.instance.enter_event_mode();
    fmi3Terminate[InitializationMode EventMode StepComplete](instance: Pointer) -> Status => |c| {
        c.instance.terminate();
        Ok(())
    };
    fmi3Reset[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer) -> Status => |c| {
        c.reset();
        Ok(())
    };

    fmi3GetFloat32[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut f32, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetFloat64[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut f64, value_count: usize,
    ) -> Status => |c| get_float64(c, vr, count, values, value_count);
    fmi3GetInt8[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut i8, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetUInt8[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut u8, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetInt16[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut i16, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetUInt16[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut u16, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetInt32[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut i32, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetUInt32[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut u32, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetInt64[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut i64, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetUInt64[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut u64, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetBoolean[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut Boolean, value_count: usize,
    ) -> Status => |c| get(c, vr, count, values, value_count);
    fmi3GetString[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: *const u32, count: usize, values: *mut *const c_char, value_count: usize,
    ) -> Status => |c| {
        let all = texts(c, vr, count, value_count, "Get")?;
        with_types!(c, V => pointers::get_strings::<V, _>(c, all.as_ptr(), all.len(), values))
    };
    fmi3GetBinary[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, _vr: *const u32, count: usize, _sizes: *mut usize, _values: *mut *const u8, _value_count: usize,
    ) -> Status => |_c| nothing(count, "Binary");
    fmi3GetClock[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _vr: *const u32, count: usize, _values: *mut Boolean) -> Status
        => |_c| nothing(count, "Clock");
    fmi3SetFloat32[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const f32, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetFloat64[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const f64, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetInt8[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const i8, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetUInt8[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const u8, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetInt16[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const i16, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetUInt16[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const u16, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetInt32[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const i32, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetUInt32[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const u32, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetInt64[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const i64, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetUInt64[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const u64, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetBoolean[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const Boolean, value_count: usize,
    ) -> Status => |c| set(c, vr, count, values, value_count);
    fmi3SetString[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, vr: *const u32, count: usize, values: *const *const c_char, value_count: usize,
    ) -> Status => |c| {
        let all = texts(c, vr, count, value_count, "Set")?;
        with_types!(c, V => pointers::set_strings::<V, _>(c, all.as_ptr(), all.len(), values))
    };
    fmi3SetBinary[Instantiated InitializationMode EventMode StepComplete](
        instance: Pointer, _vr: *const u32, count: usize, _sizes: *const usize, _values: *const *const u8, _value_count: usize,
    ) -> Status => |_c| nothing(count, "Binary");
    fmi3SetClock[Instantiated InitializationMode EventMode StepComplete](instance: Pointer, _vr: *const u32, count: usize, _values: *const Boolean) -> Status
        => |_c| nothing(count, "Clock");

    fmi3GetNumberOfVariableDependencies[InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, vr: u32, count: *mut usize,
    ) -> Status => |c| {
        let count = target(count, "nDependencies")?;
        *count = dependencies_of(c, vr)?.len();
        Ok(())
    };
    fmi3GetVariableDependencies[InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, dependent: u32, dependent_elements: *mut usize, independents: *mut u32,
        independent_elements: *mut usize, kinds: *mut c_int, count: usize,
    ) -> Status => |c| {
        let all = dependencies_of(c, dependent)?;
        if all.len() != count {
            return Err(messages::wrong_dependency_count(count, all.len()).into());
        }
        let dependent_elements = array_mut(dependent_elements, count, "elementIndicesOfDependent")?;
        let independents = array_mut(independents, count, "independents")?;
        let independent_elements = array_mut(independent_elements, count, "elementIndicesOfIndependents")?;
        let kinds = array_mut(kinds, count, "dependencyKinds")?;
        // 0 means all elements.
        dependent_elements.fill(0);
        independent_elements.fill(0);
        kinds.fill(DEPENDENT);
        independents.copy_from_slice(&all);
        Ok(())
    };

    fmi3GetFMUState[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, state: *mut StateAddress) -> Status
        => |c| c.get_state(target(state, "FMUState")?);
    fmi3SetFMUState[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, state: StateAddress) -> Status => |c| c.set_state(state);
    fmi3FreeFMUState[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, state: *mut StateAddress) -> Status
        => |c| c.free_state(target(state, "FMUState")?);
    fmi3SerializedFMUStateSize[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, state: StateAddress, size: *mut usize) -> Status => |c| {
        *target(size, "size")? = c.serialized_size(state)?;
        Ok(())
    };
    fmi3SerializeFMUState[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, state: StateAddress, bytes: *mut u8, size: usize) -> Status
        => |c| c.serialize(state, array_mut(bytes, size, "serializedState")?);
    fmi3DeserializeFMUState[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, bytes: *const u8, size: usize, state: *mut StateAddress) -> Status
        => |c| c.deserialize(array(bytes, size, "serializedState")?, target(state, "FMUState")?);

    fmi3GetDirectionalDerivative[InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, _unknowns: *const u32, _unknown_count: usize, _knowns: *const u32, _known_count: usize,
        _seed: *const f64, _seed_count: usize, _sensitivity: *mut f64, _sensitivity_count: usize,
    ) -> Status => |_c| Err(messages::not_provided("providesDirectionalDerivatives").into());
    fmi3GetAdjointDerivative[InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, _unknowns: *const u32, _unknown_count: usize, _knowns: *const u32, _known_count: usize,
        _seed: *const f64, _seed_count: usize, _sensitivity: *mut f64, _sensitivity_count: usize,
    ) -> Status => |_c| Err(messages::not_provided("providesAdjointDerivatives").into());

    fmi3EnterConfigurationMode[Instantiated EventMode StepComplete](instance: Pointer) -> Status
        => |_c| Err(messages::no_structural_parameters().into());
    fmi3ExitConfigurationMode[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer) -> Status
        => |_c| Err(messages::no_configuration_mode().into());
    fmi3GetIntervalDecimal[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, _vr: *const u32, count: usize, _intervals: *mut f64, _qualifiers: *mut c_int,
    ) -> Status => |_c| nothing(count, "Clock");
    fmi3GetIntervalFraction[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, _vr: *const u32, count: usize, _counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut c_int,
    ) -> Status => |_c| nothing(count, "Clock");
    fmi3GetShiftDecimal[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _vr: *const u32, count: usize, _shifts: *mut f64) -> Status
        => |_c| nothing(count, "Clock");
    fmi3GetShiftFraction[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, _vr: *const u32, count: usize, _counters: *mut u64, _resolutions: *mut u64,
    ) -> Status => |_c| nothing(count, "Clock");
    fmi3SetIntervalDecimal[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _vr: *const u32, count: usize, _intervals: *const f64) -> Status
        => |_c| nothing(count, "Clock");
    fmi3SetIntervalFraction[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, _vr: *const u32, count: usize, _counters: *const u64, _resolutions: *const u64,
    ) -> Status => |_c| nothing(count, "Clock");
    fmi3SetShiftDecimal[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _vr: *const u32, count: usize, _shifts: *const f64) -> Status
        => |_c| nothing(count, "Clock");
    fmi3SetShiftFraction[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, _vr: *const u32, count: usize, _counters: *const u64, _resolutions: *const u64,
    ) -> Status => |_c| nothing(count, "Clock");
    fmi3EvaluateDiscreteStates[InitializationMode EventMode](instance: Pointer) -> Status
        => |_c| Err(messages::not_provided("providesEvaluateDiscreteStates").into());
    fmi3UpdateDiscreteStates[EventMode](
        instance: Pointer, needs_update: *mut Boolean, terminate: *mut Boolean, nominals_changed: *mut Boolean,
        states_changed: *mut Boolean, is_next_defined: *mut Boolean, next: *mut f64,
    ) -> Status => |c| {
        let flags = [
            target(needs_update, "discreteStatesNeedUpdate")?,
            target(terminate, "terminateSimulation")?,
            target(nominals_changed, "nominalsOfContinuousStatesChanged")?,
            target(states_changed, "valuesOfContinuousStatesChanged")?,
        ];
        let (is_next_defined, next) =
            (target(is_next_defined, "nextEventTimeDefined")?, target(next, "nextEventTime")?);
        let event = c.update_discrete_states()?;
        flags.into_iter().for_each(|flag| *flag = Boolean(0));
        *is_next_defined = Boolean(u8::from(event.is_some()));
        *next = event.unwrap_or_default();
        Ok(())
    };

    fmi3EnterContinuousTimeMode[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer) -> Status => |_c| only_co_simulation(EXCHANGE);
    fmi3CompletedIntegratorStep[Instantiated InitializationMode EventMode StepComplete Terminated](
        instance: Pointer, _no_set_fmu_state_prior: Boolean, _enter_event_mode: *mut Boolean, _terminate: *mut Boolean,
    ) -> Status => |_c| only_co_simulation(EXCHANGE);
    fmi3SetTime[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _time: f64) -> Status => |_c| only_co_simulation(EXCHANGE);
    fmi3SetContinuousStates[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _states: *const f64, _count: usize) -> Status
        => |_c| only_co_simulation(EXCHANGE);
    fmi3GetContinuousStateDerivatives[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _derivatives: *mut f64, _count: usize) -> Status
        => |_c| only_co_simulation(EXCHANGE);
    fmi3GetEventIndicators[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _indicators: *mut f64, _count: usize) -> Status
        => |_c| only_co_simulation(EXCHANGE);
    fmi3GetContinuousStates[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _states: *mut f64, _count: usize) -> Status
        => |_c| only_co_simulation(EXCHANGE);
    fmi3GetNominalsOfContinuousStates[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _nominals: *mut f64, _count: usize) -> Status
        => |_c| only_co_simulation(EXCHANGE);
    fmi3GetNumberOfEventIndicators[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _count: *mut usize) -> Status
        => |_c| only_co_simulation(EXCHANGE);
    fmi3GetNumberOfContinuousStates[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _count: *mut usize) -> Status
        => |_c| only_co_simulation(EXCHANGE);

    fmi3EnterStepMode[EventMode](instance: Pointer) -> Status => |c| {
        c.instance.enter_step_mode();
        Ok(())
    };
    fmi3GetOutputDerivatives[StepComplete Terminated](
        instance: Pointer, _vr: *const u32, count: usize, _orders: *const c_int, _values: *mut f64, _value_count: usize,
    ) -> Status => |_c| match count {
        0 => Ok(()),
        _ => Err(messages::no_output_derivatives().into()),
    };
    fmi3DoStep[StepComplete](
        instance: Pointer, tc: f64, h: f64, _no_set_fmu_state_prior: Boolean, event: *mut Boolean, terminate: *mut Boolean,
        early: *mut Boolean, last: *mut f64,
    ) -> Status => |c| {
        let (event, terminate) = (target(event, "eventHandlingNeeded")?, target(terminate, "terminateSimulation")?);
        let (early, last) = (target(early, "earlyReturn")?, target(last, "lastSuccessfulTime")?);
        if h == 0.0 {
            return Err(messages::step_of_zero().into());
        }
        let reached = c.do_step(tc, h)?;
        *event = Boolean(u8::from(reached.is_event));
        *terminate = Boolean(0);
        *early = Boolean(u8::from(reached.is_early));
        *last = reached.end;
        Ok(())
    };
    fmi3ActivateModelPartition[Instantiated InitializationMode EventMode StepComplete Terminated](instance: Pointer, _clock: u32, _time: f64) -> Status
        => |_c| only_co_simulation("Scheduled Execution");
}

fn dependencies_of<B: Cyclic>(c: &Component<B>, reference: u32) -> Result<Vec<u32>, Refusal> {
    with_types!(c, V => dependencies::<V, _>(c, reference))
}

#[inline(always)]
unsafe fn get_float64<B: Cyclic>(
    c: &Component<B>,
    vr: *const u32,
    count: usize,
    values: *mut f64,
    value_count: usize,
) -> Result<(), Refusal> {
    // SAFETY: the host's contract.
    let (vr, values) = unsafe { (array(vr, count, VR)?, array_mut(values, value_count, VALUES)?) };
    with_types!(c, V => access::get_with_time::<V, _>(c, vr, values))
}

/// Logs that the FMU does not support this kind of simulation and returns NULL.
fn refuse<L: Library>(function: &'static Function, environment: *mut c_void, logger: Logger) -> Pointer {
    let reason = messages::no_simulation_of_this_kind();
    Door::<L::Block, Caller>::new(Caller { logger, environment }, function, || Err(reason.into()));
    ptr::null_mut()
}

unsafe fn instantiate<L: Library>(
    instance_name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    logging_on: bool,
    events: Option<Events>,
    environment: *mut c_void,
    logger: Logger,
) -> Pointer {
    // SAFETY: the host's contract.
    let (name, token, resources) = unsafe { (text(instance_name), text(token), text(resources)) };
    let door = Door::new(Caller { logger, environment }, &Function::fmi3InstantiateCoSimulation, || {
        if name.is_none_or(CStr::is_empty) {
            return Err(messages::no_name().into());
        }
        let identity = Identity { name: "instantiationToken", value: token, forms: FORMS };
        let origin = L::open(identity, Argument { name: "resourcePath", value: resources })?;
        Ok(Component::with_events(origin, logging_on, events))
    });
    door.map_or(ptr::null_mut(), |door| Box::into_raw(Box::new(door)).cast())
}
