//! One block as FMI sees it: which call is allowed when, which variable may be set, what a step does. Safe Rust.
//!
//! A refused call changes nothing, not even the state: it can be put right and made again.

use crate::clock::Clock;
use crate::interface::{Guid, checksum};
use crate::value::{FmiType, type_name};
use blocks::{Block, Kind, Role, Row, Stored};
use std::ffi::c_int;

/// The states of FMI 2.0 for co-simulation that an instance can be in. A step runs to its end or is refused before it
/// begins, so that it never is in progress, failed or canceled, and no error state is left behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
    /// After fmi2Instantiate or fmi2Reset.
    Instantiated = 1,
    /// Between fmi2EnterInitializationMode and fmi2ExitInitializationMode.
    InitializationMode = 2,
    /// Ready for a step.
    StepComplete = 4,
    /// After fmi2Terminate.
    Terminated = 8,
    /// After a panic the instance may be half changed: it can only be freed.
    Locked = 16,
}

impl State {
    fn name(self) -> &'static str {
        match self {
            State::Instantiated => "instantiated",
            State::InitializationMode => "Initialization Mode",
            State::StepComplete => "stepComplete",
            State::Terminated => "terminated",
            State::Locked => "locked",
        }
    }
}

/// A C function: its name and the states in which the standard allows it.
#[derive(Debug)]
pub struct Function {
    /// The name, as a log message begins with it.
    pub name: &'static str,
    allowed: u8,
}

const I: u8 = State::Instantiated as u8;
const N: u8 = State::InitializationMode as u8;
const C: u8 = State::StepComplete as u8;
const T: u8 = State::Terminated as u8;

macro_rules! functions {
    ($($constant:ident $name:literal $allowed:expr;)*) => {
        impl Function { $(
            #[doc = concat!("`", $name, "`")]
            pub const $constant: Function = Function { name: $name, allowed: $allowed };
        )* }
    };
}

// FMI 2.0, section 4.2.4, in its order. Two rows are more lenient, because real hosts need it: Get also works in state
// instantiated, where it gives the start values, and inputs may be set there.
functions! {
    SET_DEBUG_LOGGING "fmi2SetDebugLogging" I | N | C | T;
    INSTANTIATE "fmi2Instantiate" 0;
    FREE_INSTANCE "fmi2FreeInstance" I | N | C | T;
    SETUP_EXPERIMENT "fmi2SetupExperiment" I;
    ENTER_INITIALIZATION_MODE "fmi2EnterInitializationMode" I;
    EXIT_INITIALIZATION_MODE "fmi2ExitInitializationMode" N;
    TERMINATE "fmi2Terminate" C;
    RESET "fmi2Reset" I | N | C | T;
    GET_REAL "fmi2GetReal" I | N | C | T;
    GET_INTEGER "fmi2GetInteger" I | N | C | T;
    GET_BOOLEAN "fmi2GetBoolean" I | N | C | T;
    GET_STRING "fmi2GetString" I | N | C | T;
    SET_REAL "fmi2SetReal" I | N | C;
    SET_INTEGER "fmi2SetInteger" I | N | C;
    SET_BOOLEAN "fmi2SetBoolean" I | N | C;
    SET_STRING "fmi2SetString" I | N | C;
    GET_FMU_STATE "fmi2GetFMUstate" I | N | C | T;
    SET_FMU_STATE "fmi2SetFMUstate" I | N | C | T;
    FREE_FMU_STATE "fmi2FreeFMUstate" I | N | C | T;
    SERIALIZED_FMU_STATE_SIZE "fmi2SerializedFMUstateSize" I | N | C | T;
    SERIALIZE_FMU_STATE "fmi2SerializeFMUstate" I | N | C | T;
    DESERIALIZE_FMU_STATE "fmi2DeSerializeFMUstate" I | N | C | T;
    GET_DIRECTIONAL_DERIVATIVE "fmi2GetDirectionalDerivative" N | C;
    SET_REAL_INPUT_DERIVATIVES "fmi2SetRealInputDerivatives" I | N | C;
    GET_REAL_OUTPUT_DERIVATIVES "fmi2GetRealOutputDerivatives" C | T;
    DO_STEP "fmi2DoStep" C;
    CANCEL_STEP "fmi2CancelStep" 0;
    GET_STATUS "fmi2GetStatus" C | T;
    GET_REAL_STATUS "fmi2GetRealStatus" C | T;
    GET_INTEGER_STATUS "fmi2GetIntegerStatus" C | T;
    GET_BOOLEAN_STATUS "fmi2GetBooleanStatus" C | T;
    GET_STRING_STATUS "fmi2GetStringStatus" C | T;
}

/// Why a call is refused. It fits in a register, so that calls that are not refused do not carry it along.
#[derive(Debug)]
pub struct Refusal(Box<(Answer, String)>);

/// What a refused call answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// fmi2Error.
    Error,
    /// fmi2Discard: an inquiry that has no answer here.
    Discard,
    /// fmi2Fatal: the instance is lost.
    Fatal,
}

impl Refusal {
    /// A refusal with this answer.
    pub fn new(answer: Answer, reason: String) -> Refusal {
        Refusal(Box::new((answer, reason)))
    }

    /// What the call answers.
    pub fn answer(&self) -> Answer {
        self.0.0
    }

    /// The reason, for the log.
    pub fn reason(&self) -> &str {
        &self.0.1
    }
}

impl From<String> for Refusal {
    #[cold]
    fn from(reason: String) -> Refusal {
        Refusal::new(Answer::Error, reason)
    }
}

impl From<&str> for Refusal {
    #[cold]
    fn from(reason: &str) -> Refusal {
        Refusal::new(Answer::Error, reason.into())
    }
}

/// How many time derivatives of an input can be given.
const ORDERS: usize = 4;

/// A Real input that is extrapolated within a step.
#[derive(Clone, Debug)]
struct Extrapolation {
    row: u32,
    /// The input's own value, while a step replaces it by the extrapolated ones; of no meaning between steps.
    value: f64,
    /// First to fourth derivative.
    derivatives: [f64; ORDERS],
}

impl Extrapolation {
    /// The value `t` seconds after the start of the step.
    fn at(&self, t: f64) -> f64 {
        let mut sum = self.value;
        let mut factor = 1.0;
        for (order, derivative) in (1u32..).zip(self.derivatives) {
            factor *= t / f64::from(order);
            sum += derivative * factor;
        }
        sum
    }
}

/// One block with its time and state. A clone is a saved FMU state: there are no pointers in it.
#[derive(Clone, Debug)]
pub struct Instance<B> {
    block: B,
    state: State,
    /// Start and stop time; there is none before fmi2SetupExperiment, and an infinite stop time if none is defined.
    experiment: Option<(f64, f64)>,
    clock: Clock,
    extrapolations: Vec<Extrapolation>,
}

impl<B: Block> Default for Instance<B> {
    /// As right after fmi2Instantiate.
    fn default() -> Self {
        let block = B::default();
        let clock = Clock::new(0.0, f64::INFINITY, block.cycle());
        Instance { block, state: State::Instantiated, experiment: None, clock, extrapolations: Vec::new() }
    }
}

impl<B: Block> Instance<B> {
    /// May the function be called in the present state?
    ///
    /// # Errors
    /// The state, and what to call instead.
    #[inline]
    pub fn may(&self, function: &Function) -> Result<(), Refusal> {
        if function.allowed & self.state as u8 != 0 {
            return Ok(());
        }
        Err(self.not_now(function))
    }

    #[cold]
    fn not_now(&self, function: &Function) -> Refusal {
        if self.state == State::Locked {
            let reason = "the instance is locked after a panic; only fmi2FreeInstance is left";
            return Refusal::new(Answer::Fatal, reason.into());
        }
        if function.allowed == 0 {
            return "steps are complete when fmi2DoStep returns: there is none to cancel".into();
        }
        let allowed: Vec<_> = [State::Instantiated, State::InitializationMode, State::StepComplete, State::Terminated]
            .into_iter()
            .filter(|state| function.allowed & *state as u8 != 0)
            .map(State::name)
            .collect();
        format!("not allowed in state {}, only in {}", self.state.name(), allowed.join(", ")).into()
    }

    /// The time of the experiment.
    ///
    /// # Errors
    /// A start time that is not finite, a stop time that is NaN or before it.
    pub fn setup_experiment(&mut self, start: f64, stop: Option<f64>) -> Result<(), Refusal> {
        if !start.is_finite() {
            return Err(format!("startTime = {start:?}: must be finite").into());
        }
        if let Some(stop) = stop
            && (stop.is_nan() || stop < start)
        {
            return Err(format!("stopTime = {stop:?}: must not lie before startTime = {start:?}").into());
        }
        self.experiment = Some((start, stop.unwrap_or(f64::INFINITY)));
        Ok(())
    }

    /// To Initialization Mode.
    ///
    /// # Errors
    /// There is no start time yet.
    pub fn enter_initialization_mode(&mut self) -> Result<(), Refusal> {
        if self.experiment.is_none() {
            return Err("the start time is unknown: call fmi2SetupExperiment before".into());
        }
        self.state = State::InitializationMode;
        Ok(())
    }

    /// Makes the restart call, with the values then set. The first cyclic call is at the start time.
    ///
    /// # Errors
    /// CYCLE below 1 ms, or what the block itself refuses.
    pub fn exit_initialization_mode(&mut self) -> Result<(), Refusal> {
        let cycle = self.block.cycle();
        if cycle.milliseconds() < 1 {
            return Err(format!(
                "{} = {:?} s: the time between two calls must be at least 0.001 s",
                B::TABLE.rows[B::TABLE.cycle].name,
                f64::from(cycle.milliseconds()) / 1000.0
            )
            .into());
        }
        self.block.check()?;
        let (start, stop) = self.experiment.unwrap_or((0.0, f64::INFINITY));
        self.clock = Clock::new(start, stop, cycle);
        self.block.restart();
        self.show_mean(0, 0);
        self.state = State::StepComplete;
        Ok(())
    }

    /// After a panic: every call but fmi2FreeInstance is refused from now on.
    pub fn lock(&mut self) {
        self.state = State::Locked;
    }

    /// The simulation has ended.
    pub fn terminate(&mut self) {
        self.state = State::Terminated;
    }

    /// The end of the last step in seconds, or of the furthest where the last one began a little before its end.
    pub fn last_successful_time(&self) -> f64 {
        self.clock.end()
    }

    /// Reads variables into `values`.
    ///
    /// # Errors
    /// A reference that is unknown or of another type; nothing is written then.
    #[inline]
    pub fn get<T: FmiType>(&self, references: &[u32], values: &mut [T]) -> Result<(), Refusal> {
        for reference in references {
            row::<B, T>(*reference, "Get")?;
        }
        for (reference, value) in references.iter().zip(values) {
            if let Some(got) = self.block.get(*reference as usize).and_then(T::from_plc) {
                *value = got;
            }
        }
        Ok(())
    }

    /// Writes variables.
    ///
    /// # Errors
    /// A reference that is unknown, of another type or must not be set now, or a value outside its type's range;
    /// nothing is written then.
    #[inline]
    pub fn set<T: FmiType>(&mut self, references: &[u32], values: &[T]) -> Result<(), Refusal> {
        for (reference, value) in references.iter().zip(values) {
            let row = row::<B, T>(*reference, "Set")?;
            self.may_set(row)?;
            if let Err(range) = value.to_plc(row.kind) {
                return Err(out_of_range(row, *value, range));
            }
        }
        for (reference, value) in references.iter().zip(values) {
            let row = *reference as usize;
            value.put(&mut self.block, row, B::TABLE.rows[row].kind);
        }
        Ok(())
    }

    #[inline]
    fn may_set(&self, row: &Row) -> Result<(), Refusal> {
        match row.role {
            Role::Input | Role::Parameter => Ok(()),
            Role::Fixed | Role::Cycle if self.state != State::StepComplete => Ok(()),
            _ => Err(read_only(row)),
        }
    }

    /// Gives time derivatives of Real inputs: within the following steps the block sees the input extrapolated from the
    /// start of the step. They hold until they are changed; 0 takes one back.
    ///
    /// # Errors
    /// A reference that is no Real input, an order other than 1 to 4, a derivative that is not finite; nothing is
    /// changed then.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[c_int],
        derivatives: &[f64],
    ) -> Result<(), Refusal> {
        for ((reference, order), derivative) in references.iter().zip(orders).zip(derivatives) {
            let row = row::<B, f64>(*reference, "Set")?;
            if row.role != Role::Input || row.kind == Kind::Time {
                return Err(format!("{} is no Real input: only such have derivatives", row.full_name()).into());
            }
            if !(1..=ORDERS as c_int).contains(order) {
                return Err(
                    format!("{}: order {order}: derivatives go from order 1 to {ORDERS}", row.full_name()).into()
                );
            }
            if !derivative.is_finite() {
                return Err(format!("{}: derivative {derivative:?}: must be finite", row.full_name()).into());
            }
        }
        for ((reference, order), derivative) in references.iter().zip(orders).zip(derivatives) {
            let place = self.extrapolations.iter().position(|known| known.row == *reference).unwrap_or_else(|| {
                self.extrapolations.push(Extrapolation { row: *reference, value: 0.0, derivatives: [0.0; ORDERS] });
                self.extrapolations.len() - 1
            });
            self.extrapolations[place].derivatives[*order as usize - 1] = *derivative;
        }
        self.extrapolations.retain(|known| known.derivatives != [0.0; ORDERS]);
        Ok(())
    }

    /// Makes every call from `tc` on before `tc + h`.
    ///
    /// # Errors
    /// What the [`Clock`] refuses; an extrapolated input beyond its type. No call is made then.
    #[inline]
    pub fn do_step(&mut self, tc: f64, h: f64) -> Result<(), Refusal> {
        if !self.extrapolations.is_empty() {
            return self.do_step_extrapolated(tc, h);
        }
        let calls = self.clock.advance(tc, h)?;
        let mut pulses = 0;
        for _ in 0..calls.count {
            self.block.call();
            if B::TABLE.mean.is_some() {
                pulses += i64::from(self.block.pulse());
            }
        }
        self.show_mean(pulses, calls.count);
        Ok(())
    }

    fn do_step_extrapolated(&mut self, tc: f64, h: f64) -> Result<(), Refusal> {
        let mut clock = self.clock.clone();
        let calls = clock.advance(tc, h)?;
        let cycle = clock.period();
        for input in &mut self.extrapolations {
            let row = &B::TABLE.rows[input.row as usize];
            input.value = self.block.get(input.row as usize).and_then(f64::from_plc).unwrap_or_default();
            // The largest amount that the value can reach within the step; if that fits, every value does.
            let last = (calls.lead + calls.count as f64 * cycle).max(0.0);
            let bound =
                Extrapolation { value: input.value.abs(), derivatives: input.derivatives.map(f64::abs), row: 0 };
            if let Err(range) = bound.at(last).to_plc(row.kind) {
                return Err(
                    format!("{}, extrapolated over {last:?} s, may leave its range: {range}", row.full_name()).into()
                );
            }
        }
        self.clock = clock;
        let mut pulses = 0;
        for call in 0..calls.count {
            let t = (calls.lead + call as f64 * cycle).max(0.0);
            for input in &self.extrapolations {
                write_input(&mut self.block, input.row, input.at(t));
            }
            self.block.call();
            pulses += i64::from(self.block.pulse());
        }
        for input in &self.extrapolations {
            write_input(&mut self.block, input.row, input.value);
        }
        self.show_mean(pulses, calls.count);
        Ok(())
    }

    /// Shows the mean of the pulse over the calls of a step; without a call, the pulse that is held.
    fn show_mean(&mut self, pulses: i64, calls: u64) {
        if B::TABLE.mean.is_some() {
            let (pulses, calls) = if calls == 0 { (i64::from(self.block.pulse()), 1) } else { (pulses, calls) };
            self.block.set_mean(100.0 * pulses as f64 / calls as f64);
        }
    }

    /// The instance as bytes: magic and version, GUID, length, content, checksum; little endian.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut content = Vec::new();
        (self.state as u8).write(&mut content);
        self.experiment.is_some().write(&mut content);
        let (start, stop) = self.experiment.unwrap_or_default();
        start.write(&mut content);
        stop.write(&mut content);
        self.clock.write(&mut content);
        self.extrapolations.write(&mut content);
        self.block.write(&mut content);

        let mut bytes = MAGIC.to_vec();
        bytes.extend_from_slice(&Guid::<B>::BYTES);
        (content.len() as u64).write(&mut bytes);
        bytes.extend_from_slice(&content);
        let checksum = checksum(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// The instance that [`Instance::to_bytes`] made these bytes of, here or in another process.
    ///
    /// # Errors
    /// The bytes are of something else, of another FMU, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Refusal> {
        let rest = bytes.strip_prefix(MAGIC).ok_or("the bytes are no serialized state of this format")?;
        let rest = rest
            .strip_prefix(&Guid::<B>::BYTES)
            .ok_or_else(|| format!("the state is of another FMU or version; this is {}", B::TABLE.name))?;
        let damaged = || Refusal::from("the serialized state is damaged");
        let (mut rest, checksum_bytes) = rest.split_last_chunk().ok_or_else(damaged)?;
        if checksum(&bytes[..bytes.len() - checksum_bytes.len()]) != u128::from_le_bytes(*checksum_bytes) {
            return Err(damaged());
        }
        let content = &mut rest;
        let length = u64::read(content).ok_or_else(damaged)?;
        if length != content.len() as u64 {
            return Err(damaged());
        }
        let instance = Self::read(content).filter(|_| content.is_empty()).ok_or_else(damaged)?;
        Ok(instance)
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let state = match u8::read(bytes)? {
            I => State::Instantiated,
            N => State::InitializationMode,
            C => State::StepComplete,
            T => State::Terminated,
            _ => return None,
        };
        let has_experiment = bool::read(bytes)?;
        let times = (f64::read(bytes)?, f64::read(bytes)?);
        let experiment = has_experiment.then_some(times);
        let clock = Clock::read(bytes)?;
        let extrapolations = Vec::<Extrapolation>::read(bytes)?;
        if extrapolations.iter().any(|input| input.row as usize >= B::TABLE.rows.len()) {
            return None;
        }
        Some(Instance { block: B::read(bytes)?, state, experiment, clock, extrapolations })
    }
}

/// What a serialized state begins with; the last byte is the version of the format.
const MAGIC: &[u8] = b"plcfmu\0\x01";

impl Stored for Extrapolation {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.row.write(bytes);
        self.derivatives.write(bytes);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        Some(Extrapolation { row: Stored::read(bytes)?, value: 0.0, derivatives: Stored::read(bytes)? })
    }
}

fn write_input<B: Block>(block: &mut B, row: u32, value: f64) {
    if let Ok(value) = value.to_plc(B::TABLE.rows[row as usize].kind) {
        block.set(row as usize, value);
    }
}

/// The row behind a value reference, if it is of the FMI type `T`. `access` is Get or Set, for the message.
#[inline]
fn row<B: Block, T: FmiType>(reference: u32, access: &str) -> Result<&'static Row, Refusal> {
    let rows = B::TABLE.rows;
    match rows.get(reference as usize) {
        Some(row) if T::holds(row.kind) => Ok(row),
        row => Err(no_variable(reference, row, rows.len(), access)),
    }
}

// The sentences stand apart: a call that is not refused should not carry them along.

#[cold]
fn no_variable(reference: u32, row: Option<&Row>, count: usize, access: &str) -> Refusal {
    match row {
        Some(row) => {
            let (name, kind) = (row.full_name(), type_name(row.kind));
            format!("value reference {reference} is {name}, a {kind}: use fmi2{access}{kind}")
        }
        None => format!("value reference {reference} is unknown: they go from 0 to {}", count - 1),
    }
    .into()
}

#[cold]
fn out_of_range<T: FmiType>(row: &Row, value: T, range: &str) -> Refusal {
    format!("{} = {}: {range}", row.full_name(), value.text()).into()
}

#[cold]
fn read_only(row: &Row) -> Refusal {
    match row.role {
        Role::Fixed | Role::Cycle => format!(
            "{} is a fixed parameter: set it before fmi2ExitInitializationMode, or call fmi2Reset first",
            row.full_name()
        ),
        _ => format!("{} is computed by the block and can only be read", row.full_name()),
    }
    .into()
}

/// The refusal of a String variable: there are none.
pub fn no_string<B: Block>(reference: u32) -> Refusal {
    match B::TABLE.rows.get(reference as usize) {
        Some(row) => {
            let (name, kind) = (row.full_name(), type_name(row.kind));
            format!("value reference {reference} is {name}, a {kind}: use fmi2Get{kind} or fmi2Set{kind}")
        }
        None => format!("value reference {reference} is unknown: they go from 0 to {}", B::TABLE.rows.len() - 1),
    }
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::Boolean;
    use blocks::Law;

    blocks::block! {
        /// Adds its input up, call by call, and pulses in every fourth call.
        pub struct Sum as "SUM" {
            input {
                /// Summand
                u: Real = 0.0;
                /// Exact summand
                v: LReal = 0.0;
                /// Unused
                on: Bool = false;
            }
            parameter {
                /// Factor
                factor: Real = 1.0;
            }
            fixed {
                /// Refused below 0
                first: Int = 0;
            }
            cycle {
                /// Time between two calls
                cycle: Time = Time::ms(100), min Time::ms(1);
            }
            output {
                /// Sum of u times factor, and v
                sum: LReal;
                /// Calls since the restart
                count: Int;
            }
        }
        mean {
            /// Mean of the pulse
            q_mean;
        }
    }

    impl Law for Sum {
        fn restart(&mut self) {
            self.clear();
            self.count = self.first;
        }

        fn call(&mut self) {
            self.sum += f64::from(self.u * self.factor) + self.v;
            self.count = self.count.wrapping_add(1);
        }

        fn check(&self) -> Result<(), String> {
            if self.first < 0 { Err(format!("FIRST = {}: must not be below 0", self.first)) } else { Ok(()) }
        }

        fn pulse(&self) -> i32 {
            i32::from(self.count % 4 == 1)
        }
    }

    const U: u32 = 0;
    const V: u32 = 1;
    const ON: u32 = 2;
    const FACTOR: u32 = 3;
    const FIRST: u32 = 4;
    const CYCLE: u32 = 5;
    const SUM: u32 = 6;
    const COUNT: u32 = 7;
    const Q_MEAN: u32 = 8;

    fn initialized(setup: impl FnOnce(&mut Instance<Sum>)) -> Instance<Sum> {
        let mut instance = Instance::default();
        instance.setup_experiment(0.0, None).unwrap();
        instance.enter_initialization_mode().unwrap();
        setup(&mut instance);
        instance.exit_initialization_mode().unwrap();
        instance
    }

    fn real(instance: &Instance<Sum>, reference: u32) -> f64 {
        let mut value = [f64::NAN];
        instance.get(&[reference], &mut value).unwrap();
        value[0]
    }

    fn integer(instance: &Instance<Sum>, reference: u32) -> c_int {
        let mut value = [-1];
        instance.get(&[reference], &mut value).unwrap();
        value[0]
    }

    fn reason(result: Result<(), Refusal>) -> String {
        result.unwrap_err().reason().to_string()
    }

    #[test]
    fn the_restart_takes_the_values_then_set_and_the_first_call_is_at_the_start_time() {
        let mut instance = initialized(|instance| instance.set(&[FIRST], &[5]).unwrap());
        assert_eq!(integer(&instance, COUNT), 5);
        instance.do_step(0.0, 0.1).unwrap();
        assert_eq!(integer(&instance, COUNT), 6);
    }

    #[test]
    fn a_cycle_of_0_and_what_the_block_refuses_keep_the_instance_in_initialization_mode() {
        let mut instance = Instance::<Sum>::default();
        instance.setup_experiment(0.0, None).unwrap();
        instance.enter_initialization_mode().unwrap();
        instance.set(&[CYCLE], &[0.0]).unwrap();
        assert_eq!(
            reason(instance.exit_initialization_mode()),
            "CYCLE = 0.0 s: the time between two calls must be at least 0.001 s"
        );
        instance.set(&[CYCLE], &[0.001]).unwrap();
        instance.set(&[FIRST], &[-1]).unwrap();
        assert_eq!(reason(instance.exit_initialization_mode()), "FIRST = -1: must not be below 0");
        instance.set(&[FIRST], &[0]).unwrap();
        instance.exit_initialization_mode().unwrap();
    }

    #[test]
    fn one_wrong_value_among_several_changes_none() {
        let mut instance = Instance::<Sum>::default();
        assert_eq!(
            reason(instance.set(&[U, FACTOR, V], &[1.0, f64::NAN, 3.0])),
            "FACTOR = NaN: a REAL takes finite numbers of at most 3.4028235e38"
        );
        assert_eq!([real(&instance, U), real(&instance, FACTOR), real(&instance, V)], [0.0, 1.0, 0.0]);
    }

    #[test]
    fn a_refused_reference_is_named_with_what_to_use_instead() {
        let mut instance = initialized(|_| ());
        assert_eq!(reason(instance.set(&[9], &[0.0])), "value reference 9 is unknown: they go from 0 to 8");
        assert_eq!(reason(instance.set(&[ON], &[1.0])), "value reference 2 is ON, a Boolean: use fmi2SetBoolean");
        assert_eq!(reason(instance.get(&[U], &mut [0])), "value reference 0 is U, a Real: use fmi2GetReal");
        assert_eq!(reason(instance.set(&[SUM], &[1.0])), "SUM is computed by the block and can only be read");
        assert_eq!(
            reason(instance.set(&[CYCLE], &[1.0])),
            "CYCLE is a fixed parameter: set it before fmi2ExitInitializationMode, or call fmi2Reset first"
        );
        assert!(reason(instance.set(&[FIRST], &[1])).starts_with("FIRST is a fixed parameter"));
        instance.set(&[FACTOR], &[2.0]).unwrap();
    }

    #[test]
    fn inputs_with_derivatives_are_extrapolated_to_each_call_and_keep_their_own_value() {
        // u(t) = 1 + 10 t, v(t) = 5 t^2 / 2 + t^3 at t = 0, 0.1, 0.2, 0.3, 0.4.
        let mut instance = initialized(|instance| {
            instance.set(&[U], &[1.0]).unwrap();
            instance.set_input_derivatives(&[U, V, V], &[1, 2, 3], &[10.0, 5.0, 6.0]).unwrap();
        });
        instance.do_step(0.0, 0.5).unwrap();
        let u: f64 = 1.0 + 2.0 + 3.0 + 4.0 + 5.0;
        let v = 2.5 * (0.01 + 0.04 + 0.09 + 0.16) + (0.001 + 0.008 + 0.027 + 0.064);
        assert!((real(&instance, SUM) - u - v).abs() < 1e-6);
        assert_eq!([real(&instance, U), real(&instance, V)], [1.0, 0.0]);
    }

    #[test]
    fn a_derivative_of_0_takes_the_extrapolation_back() {
        let mut instance = initialized(|_| ());
        instance.set_input_derivatives(&[U], &[1], &[10.0]).unwrap();
        instance.set_input_derivatives(&[U], &[1], &[0.0]).unwrap();
        assert!(instance.extrapolations.is_empty());
    }

    #[test]
    fn an_extrapolation_begins_at_the_step_and_calls_made_up_for_see_its_first_value() {
        let mut instance = initialized(|_| ());
        instance.do_step(0.0, 0.1).unwrap();
        instance.set_input_derivatives(&[U], &[1], &[10.0]).unwrap();
        // tc = 0.35: the calls at 0.1, 0.2 and 0.3 see u = 0, the one at 0.4 sees 0.5.
        instance.do_step(0.35, 0.1).unwrap();
        assert_eq!(integer(&instance, COUNT), 5);
        assert!((real(&instance, SUM) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn an_extrapolation_out_of_range_is_refused_before_any_call() {
        let mut instance = initialized(|_| ());
        instance.set_input_derivatives(&[U], &[1], &[1e38]).unwrap();
        instance.do_step(0.0, 1.0).unwrap();
        let before = instance.to_bytes();
        assert!(reason(instance.do_step(1.0, 100.0)).starts_with("U, extrapolated over 100.0 s, may leave its range"));
        assert_eq!(instance.to_bytes(), before);
    }

    #[test]
    fn only_real_inputs_have_derivatives_of_order_1_to_4() {
        let mut instance = Instance::<Sum>::default();
        assert!(reason(instance.set_input_derivatives(&[FACTOR], &[1], &[1.0])).contains("FACTOR is no Real input"));
        assert!(reason(instance.set_input_derivatives(&[ON], &[1], &[1.0])).contains("Boolean"));
        for order in [0, 5, -1] {
            assert!(reason(instance.set_input_derivatives(&[U], &[order], &[1.0])).contains(&format!("order {order}")));
        }
        assert!(reason(instance.set_input_derivatives(&[U], &[1], &[f64::NAN])).contains("NaN"));
        instance.set_input_derivatives(&[U], &[4], &[1.0]).unwrap();
    }

    #[test]
    fn the_mean_is_that_of_the_last_step_and_the_held_state_in_a_step_without_a_call() {
        let mut instance = initialized(|_| ());
        assert_eq!(real(&instance, Q_MEAN), 0.0);
        instance.do_step(0.0, 0.8).unwrap();
        assert_eq!(real(&instance, Q_MEAN), 25.0, "calls 1 and 5 of 8");
        instance.do_step(0.8, 0.15).unwrap();
        assert_eq!(real(&instance, Q_MEAN), 50.0, "call 9 of 9 and 10");
        instance.do_step(0.95, 0.05).unwrap();
        assert_eq!(real(&instance, Q_MEAN), 0.0, "no call; call 10 left no pulse");
    }

    #[test]
    fn the_mean_counts_the_pulses_of_a_step_with_extrapolated_inputs_too() {
        let mut instance = initialized(|_| ());
        instance.set_input_derivatives(&[U], &[1], &[10.0]).unwrap();
        instance.do_step(0.0, 0.5).unwrap();
        assert_eq!(real(&instance, Q_MEAN), 40.0, "calls 1 and 5 of 5");
    }

    #[test]
    fn a_boolean_input_takes_what_is_set() {
        let mut instance = initialized(|_| ());
        for (set, got) in [(1, 1), (0, 0), (-7, 1)] {
            instance.set(&[ON], &[Boolean(set)]).unwrap();
            let mut value = [Boolean(9)];
            instance.get(&[ON], &mut value).unwrap();
            assert_eq!(value, [Boolean(got)]);
        }
    }

    #[test]
    fn the_last_successful_time_is_the_end_of_the_last_step() {
        let mut instance = initialized(|_| ());
        instance.do_step(0.0, 2.5).unwrap();
        assert_eq!(instance.last_successful_time(), 2.5);
        instance.do_step(2.5, -1.0).unwrap_err();
        assert_eq!(instance.last_successful_time(), 2.5, "a refused step is none");
    }

    #[test]
    fn a_terminated_instance_makes_no_step_but_can_be_read() {
        let mut instance = initialized(|_| ());
        instance.terminate();
        assert_eq!(reason(instance.may(&Function::DO_STEP)), "not allowed in state terminated, only in stepComplete");
        instance.may(&Function::GET_REAL).unwrap();
    }

    #[test]
    fn a_locked_instance_refuses_every_function_for_good() {
        let mut instance = initialized(|_| ());
        instance.lock();
        for function in [Function::GET_REAL, Function::RESET, Function::CANCEL_STEP] {
            let refusal = instance.may(&function).unwrap_err();
            assert_eq!(refusal.answer(), Answer::Fatal, "{}", function.name);
            assert!(refusal.reason().contains("locked"), "{}: {}", function.name, refusal.reason());
        }
    }

    #[test]
    fn reset_is_a_fresh_instance() {
        assert_eq!(Instance::<Sum>::default().to_bytes(), Instance::<Sum>::default().to_bytes());
        assert_ne!(initialized(|_| ()).to_bytes(), Instance::<Sum>::default().to_bytes());
    }

    #[test]
    fn a_serialized_state_goes_on_bit_for_bit() {
        let mut instance = initialized(|instance| {
            instance.set(&[U], &[0.1]).unwrap();
            instance.set_input_derivatives(&[V], &[1], &[0.3]).unwrap();
        });
        instance.do_step(0.0, 0.25).unwrap();
        let mut restored = Instance::<Sum>::from_bytes(&instance.to_bytes()).unwrap();
        for instance in [&mut instance, &mut restored] {
            instance.do_step(0.25, 1.0).unwrap();
        }
        assert_eq!(real(&instance, SUM).to_bits(), real(&restored, SUM).to_bits());
        assert_eq!(instance.to_bytes(), restored.to_bytes());
    }

    #[test]
    fn a_serialized_state_keeps_the_state_it_was_made_in() {
        let kept = |instance: &Instance<Sum>| Instance::<Sum>::from_bytes(&instance.to_bytes()).unwrap().state;
        let mut instance = Instance::default();
        assert_eq!(kept(&instance), State::Instantiated);
        instance.setup_experiment(0.0, None).unwrap();
        instance.enter_initialization_mode().unwrap();
        assert_eq!(kept(&instance), State::InitializationMode);
        instance.exit_initialization_mode().unwrap();
        assert_eq!(kept(&instance), State::StepComplete);
        instance.terminate();
        assert_eq!(kept(&instance), State::Terminated);
    }

    #[test]
    fn no_damage_to_a_serialized_state_goes_unnoticed() {
        let bytes = initialized(|_| ()).to_bytes();
        for place in 0..bytes.len() {
            for bit in 0..8 {
                let mut damaged = bytes.clone();
                damaged[place] ^= 1 << bit;
                assert!(Instance::<Sum>::from_bytes(&damaged).is_err(), "byte {place}, bit {bit}");
            }
            assert!(Instance::<Sum>::from_bytes(&bytes[..place]).is_err(), "cut to {place} bytes");
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(Instance::<Sum>::from_bytes(&longer).is_err());
    }

    #[test]
    fn a_state_of_another_fmu_is_refused_by_name() {
        blocks::block! {
            /// The same in all but a start value.
            pub struct Other as "SUM" {
                input {
                    /// Summand
                    u: Real = 1.0;
                }
                cycle {
                    /// Time between two calls
                    cycle: Time = Time::ms(100), min Time::ms(1);
                }
            }
        }
        impl Law for Other {
            fn restart(&mut self) {}
            fn call(&mut self) {}
        }
        let reason = Instance::<Other>::from_bytes(&initialized(|_| ()).to_bytes()).unwrap_err();
        assert!(reason.reason().contains("another FMU"), "{}", reason.reason());
    }

    #[test]
    fn a_function_in_a_wrong_state_is_refused_with_the_states_it_is_for() {
        let instance = Instance::<Sum>::default();
        assert_eq!(reason(instance.may(&Function::DO_STEP)), "not allowed in state instantiated, only in stepComplete");
        assert!(reason(instance.may(&Function::CANCEL_STEP)).contains("none to cancel"));
    }

    #[test]
    fn without_a_start_time_there_is_no_initialization_mode() {
        let mut instance = Instance::<Sum>::default();
        assert!(reason(instance.enter_initialization_mode()).contains("fmi2SetupExperiment"));
        for (start, stop) in [(f64::NAN, None), (f64::INFINITY, None), (1.0, Some(0.5)), (1.0, Some(f64::NAN))] {
            assert!(instance.setup_experiment(start, stop).is_err(), "{start} {stop:?}");
        }
        instance.setup_experiment(1.0, Some(1.0)).unwrap();
    }
}
