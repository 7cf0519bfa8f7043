//! One instance: its state, the experiment, access to variables by value reference, and its serialized form.
//!
//! A refused call changes nothing, not even the state: the host can correct and repeat it.

use crate::cyclic::Cyclic;
use crate::host_type::{HostType, Version};
use crate::messages;
use crate::refusal::Refusal;
use crate::session::{Reached, Session};
use crate::state::{Function, State};
use crate::texts;
use blocks::table::fingerprint::checksum;
use blocks::{Role, Row, Stored, Table, TableText, Value};

/// One instance. A clone is a saved state.
#[derive(Clone, Debug)]
pub struct Instance<B> {
    pub(crate) session: Session<B>,
    pub(crate) state: State,
    /// Start and stop time in seconds; the stop time is infinite if undefined. `None` before they are set.
    experiment: Option<(f64, f64)>,
    /// The handling of calls as events; `None` if calls are made within steps.
    events: Option<Events>,
}

/// The settings for calls as events, which the host handles between steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Events {
    /// Whether a step may end early, at a call.
    pub may_return_early: bool,
}

impl<B: Cyclic> Instance<B> {
    /// A new instance with the start values of this block.
    #[inline(always)]
    pub fn new(block: B) -> Self {
        Instance { session: Session::new(block), state: State::Instantiated, experiment: None, events: None }
    }

    /// The same instance, with calls as events or made within steps.
    #[must_use]
    pub fn with(self, events: Option<Events>) -> Self {
        Instance { events, ..self }
    }

    /// The handling of calls as events; `None` if calls are made within steps.
    pub fn events(&self) -> Option<Events> {
        self.events
    }

    /// Like [`Instance::events`], but `None` for a block that holds its inputs until the next call: its calls are always
    /// made within steps, because no output jumps at them.
    pub(crate) fn handled(&self) -> Option<Events> {
        self.events.filter(|_| !B::HOLDS_INPUTS)
    }

    /// Checks that the function may be called in the current state.
    ///
    /// # Errors
    /// The function may not be called; the message states the current state and the permitted ones.
    #[inline(always)]
    pub fn may(&self, function: &Function) -> Result<(), Refusal> {
        self.state.may(function)
    }

    /// The block, with its current values.
    pub fn block(&self) -> &B {
        &self.session.block
    }

    /// Sets the start and stop times in seconds.
    ///
    /// # Errors
    /// The start time is not finite; the stop time is NaN or before the start.
    pub fn setup_experiment(&mut self, start: f64, stop: Option<f64>) -> Result<(), Refusal> {
        if !start.is_finite() {
            return Err(messages::start_time(start).into());
        }
        if let Some(stop) = stop
            && (stop.is_nan() || stop < start)
        {
            return Err(messages::stop_time(stop, start).into());
        }
        self.experiment = Some((start, stop.unwrap_or(f64::INFINITY)));
        Ok(())
    }

    /// Enters Initialization Mode. `setup` is the function that sets the start time, for the message.
    ///
    /// # Errors
    /// No start time has been set.
    pub fn enter_initialization_mode(&mut self, setup: &Function) -> Result<(), Refusal> {
        if self.experiment.is_none() {
            return Err(messages::no_start_time(setup.name).into());
        }
        self.state = State::InitializationMode;
        Ok(())
    }

    /// Exits Initialization Mode: restarts the block with the values that have been set. The first cyclic call is at
    /// the start time.
    ///
    /// # Errors
    /// CYCLE is below 1 ms, or the block rejects its settings.
    pub fn exit_initialization_mode(&mut self) -> Result<(), Refusal> {
        let (start, stop) = self.experiment.unwrap_or((0.0, f64::INFINITY));
        self.session.restart(start, stop)?;
        self.state = if self.events.is_some() { State::EventMode } else { State::StepComplete };
        Ok(())
    }

    /// Enters Event Mode after a step.
    ///
    /// # Errors
    /// The instance was created without Event Mode.
    pub fn enter_event_mode(&mut self) -> Result<(), Refusal> {
        if self.events.is_none() {
            return Err(messages::no_event_mode().into());
        }
        self.state = State::EventMode;
        Ok(())
    }

    /// Leaves Event Mode for Step Mode.
    pub fn enter_step_mode(&mut self) {
        self.state = State::StepComplete;
    }

    /// Makes the call that is due at this instant, if it has not been made yet, and returns the time of the next call
    /// in seconds. If calls are not events, makes none and returns `None`.
    ///
    /// # Errors
    /// The program stops, or the time is so far from 0 that calls cannot be distinguished.
    pub fn update_discrete_states(&mut self) -> Result<Option<f64>, Refusal> {
        if self.handled().is_none() {
            return Ok(None);
        }
        let next = self.session.handle_event()?;
        self.check_running()?;
        Ok(Some(next))
    }

    /// Advice on possibly unexpected effects of the settings.
    pub fn advice(&self) -> Vec<String> {
        self.session.block.advice()
    }

    /// Advice on a completed step of `h` seconds, if it is suspiciously short compared with CYCLE.
    pub fn advice_on_step(&self, h: f64) -> Option<String> {
        self.session.advice_on_step(h)
    }

    /// Locks the instance after a panic: from now on every call is refused, and it can only be freed.
    pub fn lock(&mut self) {
        self.state = State::Locked;
    }

    /// Ends the simulation.
    pub fn terminate(&mut self) {
        self.state = State::Terminated;
    }

    /// Whether the simulation has not started, i.e. the block has not been restarted.
    pub fn is_before_start(&self) -> bool {
        matches!(self.state, State::Instantiated | State::InitializationMode)
    }

    /// The current time in seconds.
    pub fn time(&self) -> f64 {
        match self.experiment {
            Some((start, _)) if self.is_before_start() => start,
            _ => self.session.end(),
        }
    }

    /// The end of the last step in seconds. Never decreases, even if a step begins and ends slightly early.
    pub fn last_successful_time(&self) -> f64 {
        self.session.end()
    }

    /// Reads variables in the ordinary case (see [`ordinary`](crate::ordinary)) and returns whether it did.
    /// Initialization Mode is not ordinary: there, outputs are read from a restarted copy of the block.
    #[inline(always)]
    pub fn get_ordinary<V: Version, T: HostType<V>>(&self, references: &[u32], values: &mut [T]) -> bool {
        self.state != State::InitializationMode && T::get_ordinary(&self.session.block, references, values)
    }

    /// Writes variables in the ordinary case and returns whether it did.
    #[inline(always)]
    pub fn set_ordinary<V: Version, T: HostType<V>>(&mut self, references: &[u32], values: &[T]) -> bool {
        T::set_ordinary(&mut self.session.block, references, values)
    }

    /// Makes a step in the ordinary case: from one call to the next, whether calls are events or not. In every other
    /// case, returns `None` and changes nothing.
    #[inline(always)]
    pub fn make_ordinary_step(&mut self, tc: f64, h: f64) -> Option<Reached> {
        let is_event = self.handled().is_some();
        let is_made = match is_event {
            true => self.session.make_ordinary_step_between_events(tc, h),
            false => self.session.make_ordinary_step(tc, h),
        };
        is_made.then_some(Reached { end: tc + h, is_early: false, is_event })
    }

    /// Reads variables into `values`, which is as long as `references`. In Initialization Mode, computed variables have
    /// the values that a restart with the current settings would produce; if the restart would be refused, the
    /// block's current values.
    ///
    /// # Errors
    /// A reference is unknown or has a different type. In that case, nothing is written.
    #[inline(always)]
    pub fn get<V: Version, T: HostType<V>>(&self, references: &[u32], values: &mut [T]) -> Result<(), Refusal> {
        if self.get_ordinary(references, values) { Ok(()) } else { self.get_checked(references, values) }
    }

    #[inline(never)]
    fn get_checked<V: Version, T: HostType<V>>(&self, references: &[u32], values: &mut [T]) -> Result<(), Refusal> {
        let table = self.session.block.table();
        for reference in references {
            row::<V, T, _>(table, *reference, "Get")?;
        }
        let is_computed = |reference: &u32| !table.rows[*reference as usize].role.is_settable();
        let is_restart_read = self.state == State::InitializationMode && references.iter().any(is_computed);
        let restarted = if is_restart_read { self.session.restarted() } else { None };
        for (reference, value) in references.iter().zip(values) {
            let block = restarted.as_ref().filter(|_| is_computed(reference)).unwrap_or(&self.session.block);
            if let Some(got) = block.get(*reference as usize).and_then(T::from_plc) {
                *value = got;
            }
        }
        Ok(())
    }

    /// Writes variables. `values` is as long as `references`.
    ///
    /// # Errors
    /// A reference is unknown, has a different type or cannot be set now, or a value is outside the range of its type.
    /// In these cases, nothing is written.
    #[inline(always)]
    pub fn set<V: Version, T: HostType<V>>(&mut self, references: &[u32], values: &[T]) -> Result<(), Refusal> {
        if self.set_ordinary(references, values) { Ok(()) } else { self.set_checked(references, values) }
    }

    #[inline(never)]
    fn set_checked<V: Version, T: HostType<V>>(&mut self, references: &[u32], values: &[T]) -> Result<(), Refusal> {
        for (reference, value) in references.iter().zip(values) {
            let row = row::<V, T, _>(self.session.block.table(), *reference, "Set")?;
            if !self.may_set(row.role) {
                return Err(read_only(&row.name, row.role, V::PREFIX));
            }
            if let Err(range) = value.to_plc(row.kind) {
                return Err(messages::out_of_range(&row.name, &value.text(), range).into());
            }
        }
        for (reference, value) in references.iter().zip(values) {
            let row = *reference as usize;
            if let Ok(value) = value.to_plc(self.session.block.table().rows[row].kind) {
                self.session.block.set(row, value);
            }
        }
        Ok(())
    }

    /// Writes a variable by its row, regardless of its role and the state of the instance.
    pub fn overwrite(&mut self, row: usize, value: Value) {
        self.session.block.set(row, value);
    }

    pub(crate) fn may_set(&self, role: Role) -> bool {
        match role {
            Role::Input | Role::Parameter => true,
            Role::Fixed | Role::Cycle => !matches!(self.state, State::StepComplete | State::EventMode),
            Role::Output | Role::Local => false,
        }
    }

    /// Sets time derivatives of Real inputs: in all subsequent steps, the block sees the input extrapolated from the
    /// start of the step. A derivative holds until it is changed; 0 removes it. All slices have the same length.
    ///
    /// # Errors
    /// A reference is not a Real input, an order is not 1 to 4, or a derivative is not finite. In these cases, nothing
    /// is changed.
    pub fn set_input_derivatives<V: Version>(
        &mut self,
        references: &[u32],
        orders: &[i32],
        derivatives: &[f64],
    ) -> Result<(), Refusal>
    where
        f64: HostType<V>,
    {
        let given = || references.iter().zip(orders).zip(derivatives).map(|((row, order), by)| (*row, *order, *by));
        for (reference, order, derivative) in given() {
            let row = row::<V, f64, _>(self.session.block.table(), reference, "Set")?;
            Session::<B>::check_derivative(row, order, derivative)?;
        }
        self.session.set_derivatives(given());
        Ok(())
    }

    /// Makes a step from `tc` to `tc + h`, in seconds, with every call in it. If calls are events and steps may end
    /// early, it ends at the next call.
    ///
    /// # Errors
    /// The clock rejects a time, or an extrapolated input may leave its range; in these cases, no call is made. Or the
    /// program stops; its values are then those before the call in which it stopped.
    pub fn do_step(&mut self, tc: f64, h: f64) -> Result<Reached, Refusal> {
        let reached = match self.handled() {
            Some(Events { may_return_early }) => self.session.step_between_events(tc, h, may_return_early)?,
            None => {
                self.session.step(tc, h)?;
                Reached { end: tc + h, is_early: false, is_event: false }
            }
        };
        self.check_running()?;
        Ok(reached)
    }

    /// Checks that the program has not stopped.
    fn check_running(&self) -> Result<(), Refusal> {
        match self.session.block.stopped() {
            Some(reason) => Err(reason.to_string().into()),
            None => Ok(()),
        }
    }

    /// Takes the warnings accumulated since this was last called.
    pub fn take_warnings(&mut self) -> Vec<String> {
        self.session.block.take_warnings()
    }

    /// The instance as bytes: magic and version, fingerprint of the FMU, length, content, checksum. All numbers are
    /// little endian, except the fingerprint.
    pub fn to_bytes(&self, fingerprint: u128) -> Vec<u8> {
        let mut content = Vec::new();
        (self.state as u8).write(&mut content);
        self.experiment.is_some().write(&mut content);
        let (start, stop) = self.experiment.unwrap_or_default();
        start.write(&mut content);
        stop.write(&mut content);
        self.session.store(&mut content);

        let mut bytes = MAGIC.to_vec();
        bytes.extend_from_slice(&fingerprint.to_be_bytes());
        (content.len() as u64).write(&mut bytes);
        bytes.extend_from_slice(&content);
        let checksum = checksum(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// Restores an instance of the FMU with this fingerprint that [`Instance::to_bytes`] serialized in this or another
    /// process. `block` is any block with the FMU's table.
    ///
    /// # Errors
    /// The bytes are not a serialized state, belong to another FMU, or are damaged.
    pub fn from_bytes(block: &B, bytes: &[u8], fingerprint: u128) -> Result<Self, Refusal> {
        let rest = bytes.strip_prefix(MAGIC).ok_or_else(messages::no_serialized_state)?;
        let rest = rest
            .strip_prefix(&fingerprint.to_be_bytes())
            .ok_or_else(|| messages::state_of_another_fmu(&block.table().name))?;
        let damaged = || Refusal::from(messages::damaged_state());
        let (mut rest, checksum_bytes) = rest.split_last_chunk().ok_or_else(damaged)?;
        if checksum(&bytes[..bytes.len() - checksum_bytes.len()]) != u128::from_le_bytes(*checksum_bytes) {
            return Err(damaged());
        }
        let content = &mut rest;
        let length = u64::read(content).ok_or_else(damaged)?;
        if length != content.len() as u64 {
            return Err(damaged());
        }
        Self::read(block, content).filter(|_| content.is_empty()).ok_or_else(damaged)
    }

    fn read(block: &B, bytes: &mut &[u8]) -> Option<Self> {
        let state = State::numbered(u8::read(bytes)?)?;
        let has_experiment = bool::read(bytes)?;
        let times = (f64::read(bytes)?, f64::read(bytes)?);
        let experiment = has_experiment.then_some(times);
        Some(Instance { session: Session::restored(block, bytes)?, state, experiment, events: None })
    }
}

/// The first bytes of a serialized state; the last byte is the version of the format.
const MAGIC: &[u8] = b"plcfmu\0\x01";

/// The row of the variable with this value reference, which must have type `T`. `access` is Get or Set, for the
/// message.
fn row<'a, V: Version, T: HostType<V>, S: TableText>(
    table: &'a Table<S>,
    reference: u32,
    access: &str,
) -> Result<&'a Row<S>, Refusal> {
    match table.rows.get(reference as usize) {
        Some(row) if T::is_of(row) => Ok(row),
        _ => Err(no_variable::<V, _>(table, reference, access)),
    }
}

/// The refusal of a reference that does not refer to a variable of the right type.
pub fn no_variable<V: Version, S: TableText>(table: &Table<S>, reference: u32, access: &str) -> Refusal {
    let row = table.rows.get(reference as usize).map(|row| (&*row.name, V::name_of(row)));
    let text = texts::text(table, reference).map(|(_, text)| (&*text.name, texts::TYPE));
    match row.or(text) {
        Some((name, kind)) => messages::other_type(reference, name, kind, V::PREFIX, access),
        None => messages::unknown_reference(reference, table.rows.len() + table.texts.len() - 1),
    }
    .into()
}

pub(crate) fn read_only(name: &str, role: Role, prefix: &str) -> Refusal {
    match role {
        Role::Fixed | Role::Cycle => messages::fixed_parameter(name, prefix),
        _ => messages::computed(name),
    }
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refusal::Answer;
    use crate::table::Fingerprint;
    use crate::test_block::{COUNT, CYCLE, FACTOR, FIRST, ON, Other, SETUP, SUM, Sum, U, V};
    use crate::v2::Fmi2;
    use crate::v2::value::Boolean;

    const HASH: u128 = Fingerprint::<Sum>::HASH;

    fn initialized(setup: impl FnOnce(&mut Instance<Sum>)) -> Instance<Sum> {
        let mut instance = Instance::new(Sum::default());
        instance.setup_experiment(0.0, None).unwrap();
        instance.enter_initialization_mode(&SETUP).unwrap();
        setup(&mut instance);
        instance.exit_initialization_mode().unwrap();
        instance
    }

    fn real(instance: &Instance<Sum>, reference: u32) -> f64 {
        let mut value = [f64::NAN];
        instance.get::<Fmi2, _>(&[reference], &mut value).unwrap();
        value[0]
    }

    fn integer(instance: &Instance<Sum>, reference: u32) -> i32 {
        let mut value = [-1];
        instance.get::<Fmi2, _>(&[reference], &mut value).unwrap();
        value[0]
    }

    fn reason(result: Result<(), Refusal>) -> String {
        result.unwrap_err().reason().to_string()
    }

    #[test]
    fn the_restart_takes_the_values_then_set_and_the_first_call_is_at_the_start_time() {
        let mut instance = initialized(|instance| instance.set::<Fmi2, _>(&[FIRST], &[5]).unwrap());
        assert_eq!(integer(&instance, COUNT), 5);
        instance.do_step(0.0, 0.1).unwrap();
        assert_eq!(integer(&instance, COUNT), 6);
    }

    #[test]
    fn in_initialization_mode_outputs_have_what_the_restart_gives_with_the_values_set_so_far() {
        let mut instance = Instance::new(Sum::default());
        instance.setup_experiment(0.0, None).unwrap();
        instance.set::<Fmi2, _>(&[FIRST], &[5]).unwrap();
        assert_eq!(integer(&instance, COUNT), 0, "the start value");
        instance.enter_initialization_mode(&SETUP).unwrap();
        assert_eq!(integer(&instance, COUNT), 5);
        instance.set::<Fmi2, _>(&[FIRST], &[7]).unwrap();
        let before = instance.to_bytes(HASH);
        let mut values = [0; 3];
        instance.get::<Fmi2, _>(&[COUNT, FIRST, COUNT], &mut values).unwrap();
        assert_eq!(values, [7, 7, 7]);
        assert_eq!(instance.to_bytes(HASH), before, "reading changes nothing");
        instance.exit_initialization_mode().unwrap();
        assert_eq!(integer(&instance, COUNT), 7);
    }

    #[test]
    fn in_initialization_mode_outputs_are_0_where_the_restart_would_be_refused() {
        let mut instance = Instance::new(Sum::default());
        instance.setup_experiment(0.0, None).unwrap();
        instance.enter_initialization_mode(&SETUP).unwrap();
        instance.set::<Fmi2, _>(&[FIRST], &[-1]).unwrap();
        assert_eq!(integer(&instance, COUNT), 0);
        instance.set::<Fmi2, _>(&[FIRST], &[3]).unwrap();
        instance.set::<Fmi2, _>(&[CYCLE], &[0.0]).unwrap();
        assert_eq!(integer(&instance, COUNT), 0);
        instance.set::<Fmi2, _>(&[CYCLE], &[0.001]).unwrap();
        assert_eq!(integer(&instance, COUNT), 3);
    }

    #[test]
    fn a_cycle_of_0_and_what_the_block_refuses_keep_the_instance_in_initialization_mode() {
        let mut instance = Instance::new(Sum::default());
        instance.setup_experiment(0.0, None).unwrap();
        instance.enter_initialization_mode(&SETUP).unwrap();
        instance.set::<Fmi2, _>(&[CYCLE], &[0.0]).unwrap();
        assert_eq!(
            reason(instance.exit_initialization_mode()),
            "CYCLE = 0.0 s: the time between two calls must be at least 0.001 s"
        );
        instance.set::<Fmi2, _>(&[CYCLE], &[0.001]).unwrap();
        instance.set::<Fmi2, _>(&[FIRST], &[-1]).unwrap();
        assert_eq!(reason(instance.exit_initialization_mode()), "FIRST = -1: must not be below 0");
        instance.set::<Fmi2, _>(&[FIRST], &[0]).unwrap();
        instance.exit_initialization_mode().unwrap();
    }

    #[test]
    fn one_wrong_value_among_several_changes_none() {
        let mut instance = Instance::new(Sum::default());
        assert_eq!(
            reason(instance.set::<Fmi2, _>(&[U, FACTOR, V], &[1.0, f64::NAN, 3.0])),
            "FACTOR = NaN: a REAL accepts finite numbers with a magnitude of at most 3.4028235e38"
        );
        assert_eq!([real(&instance, U), real(&instance, FACTOR), real(&instance, V)], [0.0, 1.0, 0.0]);
    }

    #[test]
    fn a_refused_reference_is_named_with_what_to_use_instead() {
        let mut instance = initialized(|_| ());
        assert_eq!(
            reason(instance.set::<Fmi2, _>(&[9], &[0.0])),
            "value reference 9 is unknown: valid ones are 0 to 8"
        );
        assert_eq!(
            reason(instance.set::<Fmi2, _>(&[ON], &[1.0])),
            "value reference 2 is ON, of type Boolean: use fmi2SetBoolean"
        );
        assert_eq!(
            reason(instance.get::<Fmi2, _>(&[U], &mut [0])),
            "value reference 0 is U, of type Real: use fmi2GetReal"
        );
        assert_eq!(
            reason(instance.set::<Fmi2, _>(&[SUM], &[1.0])),
            "SUM is computed by the block and can only be read"
        );
        assert_eq!(
            reason(instance.set::<Fmi2, _>(&[CYCLE], &[1.0])),
            "CYCLE is a fixed parameter: set it before fmi2ExitInitializationMode, or call fmi2Reset first"
        );
        assert!(reason(instance.set::<Fmi2, _>(&[FIRST], &[1])).starts_with("FIRST is a fixed parameter"));
        instance.set::<Fmi2, _>(&[FACTOR], &[2.0]).unwrap();
    }

    #[test]
    fn only_real_inputs_have_derivatives_of_order_1_to_4() {
        let mut instance = Instance::new(Sum::default());
        assert!(
            reason(instance.set_input_derivatives::<Fmi2>(&[FACTOR], &[1], &[1.0]))
                .contains("FACTOR is not a Real input")
        );
        assert!(reason(instance.set_input_derivatives::<Fmi2>(&[ON], &[1], &[1.0])).contains("Boolean"));
        for order in [0, 5, -1] {
            assert!(
                reason(instance.set_input_derivatives::<Fmi2>(&[U], &[order], &[1.0]))
                    .contains(&format!("not {order}"))
            );
        }
        assert!(reason(instance.set_input_derivatives::<Fmi2>(&[U], &[1], &[f64::NAN])).contains("NaN"));
        instance.set_input_derivatives::<Fmi2>(&[U], &[4], &[1.0]).unwrap();
    }

    #[test]
    fn a_boolean_input_takes_what_is_set() {
        let mut instance = initialized(|_| ());
        for (set, got) in [(1, 1), (0, 0), (-7, 1)] {
            instance.set::<Fmi2, _>(&[ON], &[Boolean(set)]).unwrap();
            let mut value = [Boolean(9)];
            instance.get::<Fmi2, _>(&[ON], &mut value).unwrap();
            assert_eq!(value, [Boolean(got)]);
        }
    }

    #[test]
    fn the_last_successful_time_is_the_end_of_the_last_step() {
        let mut instance = initialized(|_| ());
        instance.do_step(0.0, 2.5).unwrap();
        assert_eq!(instance.last_successful_time(), 2.5);
        instance.do_step(2.5, -1.0).unwrap_err();
        assert_eq!(instance.last_successful_time(), 2.5, "a refused step does not count");
    }

    #[test]
    fn a_terminated_instance_makes_no_step_but_can_be_read() {
        let mut instance = initialized(|_| ());
        instance.terminate();
        assert_eq!(
            reason(instance.may(&Function::fmi2DoStep)),
            "not allowed in state terminated, only in stepComplete"
        );
        instance.may(&Function::fmi2GetReal).unwrap();
    }

    #[test]
    fn a_locked_instance_refuses_every_function_for_good() {
        let mut instance = initialized(|_| ());
        instance.lock();
        for function in [Function::fmi2GetReal, Function::fmi2Reset, Function::fmi2CancelStep] {
            let refusal = instance.may(&function).unwrap_err();
            assert_eq!(refusal.answer(), Answer::Fatal, "{}", function.name);
            assert!(refusal.reason().contains("locked"), "{}: {}", function.name, refusal.reason());
        }
    }

    #[test]
    fn reset_is_a_fresh_instance() {
        assert_eq!(Instance::new(Sum::default()).to_bytes(HASH), Instance::new(Sum::default()).to_bytes(HASH));
        assert_ne!(initialized(|_| ()).to_bytes(HASH), Instance::new(Sum::default()).to_bytes(HASH));
    }

    #[test]
    fn a_serialized_state_goes_on_bit_for_bit() {
        let mut instance = initialized(|instance| {
            instance.set::<Fmi2, _>(&[U], &[0.1]).unwrap();
            instance.set_input_derivatives::<Fmi2>(&[V], &[1], &[0.3]).unwrap();
        });
        instance.do_step(0.0, 0.25).unwrap();
        let mut restored = Instance::from_bytes(&Sum::default(), &instance.to_bytes(HASH), HASH).unwrap();
        for instance in [&mut instance, &mut restored] {
            instance.do_step(0.25, 1.0).unwrap();
        }
        assert_eq!(real(&instance, SUM).to_bits(), real(&restored, SUM).to_bits());
        assert_eq!(instance.to_bytes(HASH), restored.to_bytes(HASH));
    }

    #[test]
    fn a_serialized_state_keeps_the_state_it_was_made_in() {
        let kept = |instance: &Instance<Sum>| {
            Instance::from_bytes(&Sum::default(), &instance.to_bytes(HASH), HASH).unwrap().state
        };
        let mut instance = Instance::new(Sum::default());
        assert_eq!(kept(&instance), State::Instantiated);
        instance.setup_experiment(0.0, None).unwrap();
        instance.enter_initialization_mode(&SETUP).unwrap();
        assert_eq!(kept(&instance), State::InitializationMode);
        instance.exit_initialization_mode().unwrap();
        assert_eq!(kept(&instance), State::StepComplete);
        instance.terminate();
        assert_eq!(kept(&instance), State::Terminated);
    }

    #[test]
    fn no_damage_to_a_serialized_state_goes_unnoticed() {
        let bytes = initialized(|_| ()).to_bytes(HASH);
        for place in 0..bytes.len() {
            for bit in 0..8 {
                let mut damaged = bytes.clone();
                damaged[place] ^= 1 << bit;
                assert!(Instance::from_bytes(&Sum::default(), &damaged, HASH).is_err(), "byte {place}, bit {bit}");
            }
            assert!(Instance::from_bytes(&Sum::default(), &bytes[..place], HASH).is_err(), "cut to {place} bytes");
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(Instance::from_bytes(&Sum::default(), &longer, HASH).is_err());
    }

    #[test]
    fn a_state_of_another_fmu_is_refused_by_name() {
        let reason =
            Instance::from_bytes(&Other::default(), &initialized(|_| ()).to_bytes(HASH), Fingerprint::<Other>::HASH)
                .unwrap_err();
        assert!(reason.reason().contains("another FMU"), "{}", reason.reason());
    }

    #[test]
    fn without_a_start_time_there_is_no_initialization_mode() {
        let mut instance = Instance::new(Sum::default());
        assert!(reason(instance.enter_initialization_mode(&SETUP)).contains("call setup first"));
        for (start, stop) in [(f64::NAN, None), (f64::INFINITY, None), (1.0, Some(0.5)), (1.0, Some(f64::NAN))] {
            assert!(instance.setup_experiment(start, stop).is_err(), "{start} {stop:?}");
        }
        instance.setup_experiment(1.0, Some(1.0)).unwrap();
    }
}
