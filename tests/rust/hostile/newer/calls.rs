//! The calls on a living instance.

use super::model::{Model, held};
use super::typed::{Typed, with_type};
use super::{Answer, Host, OK, Turn};
use crate::calls::lifecycle::{any_experiment, is_good_experiment};
use crate::calls::logging::any_categories;
use crate::calls::step::{any_step, step_expected};
use crate::calls::values::any_text;
use crate::host::Saved;
use crate::model::{Expected, count_of, good_array, holds, ok_if};
use host::library::Pointer;
use std::ffi::{CStr, c_char, c_int};
use std::ptr;
use tests::{Random, Role, Status};

/// An instance holds this many states, and the host this many as bytes.
const MOST: usize = 10;

impl Host<'_> {
    /// Makes a call.
    pub(crate) fn answer(&mut self, turn: &mut Turn) -> Answer {
        match turn.name {
            "fmi3SetDebugLogging" => self.set_debug_logging(turn),
            "fmi3EnterInitializationMode" => self.enter_initialization_mode(turn),
            "fmi3ExitInitializationMode" => self.exit_initialization_mode(turn),
            "fmi3EnterEventMode" | "fmi3EnterStepMode" | "fmi3Terminate" | "fmi3Reset" => self.go_to(turn),
            "fmi3UpdateDiscreteStates" => self.update_discrete_states(turn),
            "fmi3DoStep" => self.do_step(turn),
            "fmi3GetString" | "fmi3SetString" => self.string(turn),
            "fmi3GetFMUState" | "fmi3DeserializeFMUState" => self.fill_state(turn),
            "fmi3SetFMUState" => self.set_state(turn),
            "fmi3FreeFMUState" => self.free_state(turn),
            "fmi3SerializedFMUStateSize" => self.serialized_size(turn),
            "fmi3SerializeFMUState" => self.serialize(turn),
            "fmi3GetNumberOfVariableDependencies" | "fmi3GetVariableDependencies" => self.dependencies(turn),
            _ => self.other(turn),
        }
    }

    fn cycle(&self, model: &Model) -> f64 {
        model.values[self.fmu.cycle as usize].seconds()
    }

    fn set_debug_logging(&mut self, turn: &mut Turn) -> Answer {
        let (chosen, pointers) = any_categories(turn.random);
        let (count, null) = count_of(turn.random, chosen.len());
        let on = turn.random.once_in(2);
        let is_known = chosen.iter().take(count).all(|choice| *choice < 4);
        let expected = ok_if(turn.allowed && good_array(count, chosen.len(), null) && is_known);
        let categories = if null { ptr::null() } else { pointers.as_ptr() };
        // SAFETY: as many strings as counted, or counts and pointers that are to be refused.
        let status = unsafe { (self.library.set_debug_logging)(turn.instance, on, count, categories) };
        if status == OK {
            let slot = self.slot(turn.place);
            for category in 0..4 {
                slot.logged[category] = slot.has_logger && on && (count == 0 || chosen[..count].contains(&category));
            }
        }
        turn.unchanged(status, expected, format!("{on}, {count}, {chosen:?}"))
    }

    fn enter_initialization_mode(&self, turn: &mut Turn) -> Answer {
        let (start, stop) = any_experiment(turn.random, self.cycle(&turn.model));
        let has_stop = turn.random.once_in(2);
        let expected = ok_if(turn.allowed && is_good_experiment(start, c_int::from(has_stop), stop));
        // SAFETY: NULL or a living instance.
        let status =
            unsafe { (self.library.enter_initialization_mode)(turn.instance, true, f64::NAN, start, has_stop, stop) };
        let experiment = (start, if has_stop { stop } else { f64::INFINITY });
        let after = Model { state: 1, experiment, ..turn.model.clone() };
        Answer { status, expected, arguments: format!("{start:?}, {has_stop}, {stop:?}"), after }
    }

    fn exit_initialization_mode(&self, turn: &Turn) -> Answer {
        let has_cycle = self.cycle(&turn.model) >= 0.001;
        let expected = if turn.allowed && has_cycle { Expected::OkOrError } else { Expected::Exactly(Status::Error) };
        // SAFETY: NULL or a living instance.
        let status = unsafe { (self.library.exit_initialization_mode)(turn.instance) };
        let state = if turn.events.is_some() { 2 } else { 3 };
        let after = Model { state, end: turn.model.experiment.0, ..turn.model.clone() };
        Answer { status, expected, arguments: String::new(), after }
    }

    /// The functions that only lead to another state.
    fn go_to(&self, turn: &Turn) -> Answer {
        let library = &self.library;
        let (function, state) = match turn.name {
            "fmi3EnterEventMode" => (library.enter_event_mode, 2),
            "fmi3EnterStepMode" => (library.enter_step_mode, 3),
            "fmi3Terminate" => (library.terminate, 4),
            _ => (library.reset, 0),
        };
        let expected = ok_if(turn.allowed && (state != 2 || turn.events.is_some()));
        // SAFETY: NULL or a living instance.
        let status = unsafe { function(turn.instance) };
        let after = match state {
            0 => Model::new(self.fmu, self.types),
            _ => Model { state, ..turn.model.clone() },
        };
        Answer { status, expected, arguments: String::new(), after }
    }

    fn update_discrete_states(&self, turn: &mut Turn) -> Answer {
        // One of the six may be NULL.
        let missing = turn.random.below(24);
        let (mut flags, mut next) = ([47_u8; 5], f64::NAN);
        let base = flags.as_mut_ptr();
        // SAFETY: five flags.
        let flag = |place: usize| if place == missing { ptr::null_mut() } else { unsafe { base.add(place) } };
        let to_next = if missing == 5 { ptr::null_mut() } else { &raw mut next };
        // SAFETY: NULL or a living instance, and NULL or variables of the host.
        let status = unsafe {
            (self.library.update_discrete_states)(turn.instance, flag(0), flag(1), flag(2), flag(3), flag(4), to_next)
        };
        if status == OK {
            assert_eq!(flags[..4], [0; 4], "only nextEventTime is told");
            assert!(flags[4] <= 1 && (flags[4] == 0 || next > turn.model.end), "{flags:?}, {next}");
        } else {
            assert!(flags == [47; 5] && next.is_nan(), "refused, but wrote {flags:?}, {next}");
        }
        // 2^47 CYCLEs from 0 a double no longer tells the calls apart.
        let magnitude = turn.model.experiment.0.abs().max(turn.model.end.abs());
        let is_far = magnitude / self.cycle(&turn.model) > 0.98 * 2f64.powi(47);
        let expected = match ok_if(turn.allowed && missing > 5) {
            Expected::Exactly(Status::Ok) if is_far => Expected::OkOrError,
            expected => expected,
        };
        turn.unchanged(status, expected, format!("NULL at {missing}"))
    }

    fn do_step(&mut self, turn: &mut Turn) -> Answer {
        let cycle = self.cycle(&turn.model);
        let (tc, h) = any_step(turn.random, cycle, turn.model.end);
        let missing = turn.random.below(24);
        let expected = match step_expected(turn.model.experiment, cycle, turn.model.end, tc, h) {
            _ if !turn.allowed || missing < 4 || h == 0.0 => Expected::Exactly(Status::Error),
            // With events, a step may go to the next call alone.
            Expected::Exactly(Status::Error) if turn.events.is_some() && h > 0.0 => Expected::OkOrError,
            expected => expected,
        };
        let (mut flags, mut last) = ([47_u8; 3], f64::NAN);
        let base = flags.as_mut_ptr();
        // SAFETY: three flags.
        let flag = |place: usize| if place == missing { ptr::null_mut() } else { unsafe { base.add(place) } };
        let to_last = if missing == 3 { ptr::null_mut() } else { &raw mut last };
        let is_prior = turn.random.once_in(2);
        // SAFETY: NULL or a living instance, and NULL or variables of the host.
        let status =
            unsafe { (self.library.do_step)(turn.instance, tc, h, is_prior, flag(0), flag(1), flag(2), to_last) };
        let mut after = turn.model.clone();
        if status == OK {
            let [event, terminate, early] = flags;
            assert!(event <= 1 && terminate == 0 && early <= 1, "{flags:?}");
            assert!(turn.events.is_some() || event == 0, "an event for a host that handles none");
            assert!(turn.events == Some(true) || early == 0, "early, which it may not");
            assert!(if early == 1 { last < tc + h && event == 1 } else { last == tc + h }, "{tc}, {h}: {last}");
            after.end = after.end.max(last);
            self.slot(turn.place).is_step_odd = 1e-6 < h && h < cycle / 100.0;
        } else {
            assert!(flags == [47; 3] && last.is_nan(), "refused, but wrote {flags:?}, {last}");
        }
        Answer { status, expected, arguments: format!("{tc:?}, {h:?}, NULL at {missing}"), after }
    }

    /// Value references, mostly those of variables of this type.
    fn references(&self, random: &mut Random, fits: impl Fn(u32) -> bool) -> Vec<u32> {
        let count = (self.fmu.variables.len() + self.fmu.texts.len()) as u32;
        let fitting: Vec<u32> = (0..count).filter(|reference| fits(*reference)).collect();
        (0..random.below(6))
            .map(|_| match random.below(16) {
                0 => random.below(count as usize) as u32,
                1 => random.pick(&[count, count + 1, u32::MAX, 1 << 31]),
                _ if fitting.is_empty() => 0,
                _ => random.pick(&fitting),
            })
            .collect()
    }

    fn is_of(&self, reference: u32, name: &str) -> bool {
        let row = self.fmu.variables.get(reference as usize);
        row.is_some_and(|row| self.types.host_type(row.kind, row.is_analog) == &name["fmi3Get".len()..])
    }

    fn get<T: Typed>(&self, turn: &mut Turn) -> Answer {
        let time = (self.fmu.variables.len() + self.fmu.texts.len()) as u32;
        let is_time = |reference: u32| reference == time && turn.name == "fmi3GetFloat64";
        let fits = |reference: u32| self.is_of(reference, turn.name) || is_time(reference);
        let references = self.references(turn.random, fits);
        let (count, null_references) = count_of(turn.random, references.len());
        let (value_count, null_values) =
            if turn.random.once_in(12) { count_of(turn.random, 5) } else { (count, false) };
        let is_good = good_array(count, references.len(), null_references)
            && (value_count == 0 || !null_values && value_count <= 8)
            && value_count == count
            && references.iter().take(count).all(|reference| fits(*reference));
        let mut values = [T::UNTOUCHED; 8];
        let to = if null_values { ptr::null_mut() } else { values.as_mut_ptr() };
        let from = if null_references { ptr::null() } else { references.as_ptr() };
        // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
        let status = unsafe { T::get(&self.library)(turn.instance, from, count, to, value_count) };
        let written = if status == OK { count } else { 0 };
        assert!(values[written..].iter().all(|value| *value == T::UNTOUCHED), "{} wrote elsewhere", turn.name);
        for (reference, value) in references[..written].iter().zip(values) {
            let Some(row) = self.fmu.variables.get(*reference as usize) else { continue };
            let (got, held) = (T::number(value), turn.model.values[*reference as usize]);
            assert!(!row.role.is_settable() || got.is(held), "{}: {} = {got:?}, not {held:?}", turn.name, row.name);
        }
        turn.unchanged(status, ok_if(turn.allowed && is_good), format!("{references:?}, {count}, {value_count}"))
    }

    fn set<T: Typed>(&self, turn: &mut Turn) -> Answer {
        let settable =
            |reference: u32| self.fmu.variables.get(reference as usize).is_some_and(|row| row.role.is_settable());
        let references =
            self.references(turn.random, |reference| self.is_of(reference, turn.name) && settable(reference));
        let (count, null_references) = count_of(turn.random, references.len());
        let (value_count, null_values) =
            if turn.random.once_in(12) { count_of(turn.random, 5) } else { (count, false) };
        let values: Vec<T::C> = (0..8).map(|_| T::any(turn.random)).collect();
        let mut after = turn.model.clone();
        let mut is_good = good_array(count, references.len(), null_references)
            && (value_count == 0 || !null_values && value_count <= 8)
            && value_count == count;
        for (reference, value) in references.iter().take(count).zip(&values) {
            let row = self.fmu.variables.get(*reference as usize);
            let row = row.filter(|row| self.is_of(*reference, turn.name) && turn.model.may_set(row.role));
            match row.and_then(|row| held(row, self.types, T::number(*value))) {
                Some(held) => after.values[*reference as usize] = held,
                None => is_good = false,
            }
        }
        let to = if null_values { ptr::null() } else { values.as_ptr() };
        let from = if null_references { ptr::null() } else { references.as_ptr() };
        // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
        let status = unsafe { T::set(&self.library)(turn.instance, from, count, to, value_count) };
        let numbers: Vec<_> = values.iter().map(|value| T::number(*value)).collect();
        let arguments = format!("{references:?}, {count}, {numbers:?}, {value_count}");
        Answer { status, expected: ok_if(turn.allowed && is_good), arguments, after }
    }

    fn string(&self, turn: &mut Turn) -> Answer {
        let first = self.fmu.variables.len() as u32;
        let number = |reference: u32| reference.checked_sub(first).map(|number| number as usize);
        let text = |reference: u32| number(reference).and_then(|number| self.fmu.texts.get(number));
        let references = self.references(turn.random, |reference| text(reference).is_some());
        let (count, null_references) = count_of(turn.random, references.len());
        let null_values = turn.random.once_in(16);
        let is_get = turn.name == "fmi3GetString";
        let given: Vec<Option<&CStr>> = references.iter().map(|_| any_text(turn.random)).collect();
        let fits = |(reference, given): (&u32, &Option<&CStr>)| {
            let given = given.and_then(|given| given.to_str().ok());
            text(*reference).is_some_and(|text| {
                is_get || turn.model.may_set(text.role) && given.is_some_and(|given| holds(text, given))
            })
        };
        let is_good = good_array(count, references.len(), null_references || null_values)
            && references.iter().zip(&given).take(count).all(fits);
        let mut pointers = [ptr::null(); 8];
        if !is_get {
            pointers.iter_mut().zip(&given).for_each(|(to, given)| *to = given.map_or(ptr::null(), CStr::as_ptr));
        }
        let values: *mut *const c_char = if null_values { ptr::null_mut() } else { pointers.as_mut_ptr() };
        let from = if null_references { ptr::null() } else { references.as_ptr() };
        // SAFETY: as many elements as counted, or counts and pointers that are to be refused.
        let status = unsafe {
            if is_get {
                (self.library.get_string)(turn.instance, from, count, values, count)
            } else {
                (self.library.set_string)(turn.instance, from, count, values, count)
            }
        };
        let mut after = turn.model.clone();
        let done = if status == OK { count } else { 0 };
        for (place, reference) in references[..done].iter().enumerate() {
            let number = number(*reference).unwrap();
            if !is_get {
                after.texts[number] = given[place].unwrap().to_str().unwrap().into();
                continue;
            }
            // SAFETY: a text that the FMU gave, which lives until the next call on the instance.
            let got = unsafe { CStr::from_ptr(pointers[place]) }.to_str().unwrap();
            let is_set = self.fmu.texts[number].role.is_settable();
            assert!(!is_set || got == turn.model.texts[number], "{got:?}, not {:?}", turn.model.texts[number]);
        }
        let arguments = format!("{references:?}, {count}, {given:?}");
        Answer { status, expected: ok_if(turn.allowed && is_good), arguments, after }
    }

    fn saved(&self, turn: &Turn) -> &[Saved<Model>] {
        self.slots[turn.place].as_ref().map_or(&[], |slot| &slot.saved)
    }

    fn known(&self, turn: &Turn, pointer: Pointer) -> Option<usize> {
        self.saved(turn).iter().position(|saved| saved.pointer == pointer)
    }

    /// An address of a state: mostly a good one of this instance, or what else a host may mix it up with.
    fn any_state(&self, turn: &mut Turn) -> Pointer {
        let others: Vec<Pointer> =
            self.slots.iter().flatten().flat_map(|slot| slot.saved.iter().map(|saved| saved.pointer)).collect();
        let own: Vec<Pointer> = self.saved(turn).iter().map(|saved| saved.pointer).collect();
        match turn.random.below(8) {
            0 => ptr::null_mut(),
            1 => turn.random.pick(&[1, 8, 0x1000, usize::MAX, usize::MAX - 7]) as Pointer,
            2 if !self.freed.is_empty() => turn.random.pick(&self.freed),
            3 if !others.is_empty() => turn.random.pick(&others),
            _ if own.is_empty() => ptr::null_mut(),
            _ => turn.random.pick(&own),
        }
    }

    /// A state that is saved, or read from bytes.
    fn fill_state(&mut self, turn: &mut Turn) -> Answer {
        let is_full = self.saved(turn).len() >= MOST;
        let before = if is_full || turn.random.once_in(3) { self.any_state(turn) } else { ptr::null_mut() };
        let (mut pointer, null) = (before, turn.random.once_in(16));
        let known = self.known(turn, before);
        let is_fillable = !null && (before.is_null() || known.is_some());
        let target = if null { ptr::null_mut() } else { &raw mut pointer };
        let (status, saved) = if turn.name == "fmi3GetFMUState" {
            // SAFETY: NULL or a variable of the host; the address in it is only compared.
            let status = unsafe { (self.library.get_fmu_state)(turn.instance, target) };
            let bytes = self.slots[turn.place].as_ref().map(|slot| slot.bytes.clone()).unwrap_or_default();
            (status, Some((bytes, turn.model.clone())))
        } else {
            let (bytes, good) = self.any_bytes(turn.random);
            let from = if turn.random.once_in(16) { ptr::null() } else { bytes.as_ptr() };
            let is_good = good.is_some() && !from.is_null();
            // SAFETY: as many bytes as said, or NULL; the address in the variable is only compared.
            let status = unsafe { (self.library.deserialize_fmu_state)(turn.instance, from, bytes.len(), target) };
            (status, good.filter(|_| is_good).map(|model| (bytes, model)))
        };
        let expected = ok_if(turn.allowed && is_fillable && saved.is_some());
        if status == OK {
            assert!(!pointer.is_null() && (before.is_null() || before == pointer), "gave {pointer:?}");
            let (bytes, model) = saved.expect("bytes of a state");
            let saved = Saved { pointer, model, bytes };
            let slot = self.slot(turn.place);
            match known {
                Some(known) => slot.saved[known] = saved,
                None => slot.saved.push(saved),
            }
            self.freed.retain(|address| *address != pointer);
        } else {
            assert_eq!(pointer, before, "refused, but gave a state");
        }
        turn.unchanged(status, expected, format!("{before:?}"))
    }

    /// Bytes of a state, with the model that belongs to them if they are good.
    fn any_bytes(&self, random: &mut Random) -> (Vec<u8>, Option<Model>) {
        if self.blobs.is_empty() || random.once_in(8) {
            let [one, other] = [0, 1].map(|place| self.foreign_blobs[place].as_slice());
            return (random.pick(&[one, other, &[], &[0; 400], b"plcfmu"]).to_vec(), None);
        }
        let (mut bytes, model) = self.blobs[random.below(self.blobs.len())].clone();
        match random.below(5) {
            0 => {
                let place = random.below(bytes.len());
                bytes[place] ^= 1 + random.below(255) as u8;
                (bytes, None)
            }
            1 => {
                bytes.truncate(random.below(bytes.len()));
                (bytes, None)
            }
            _ => (bytes, Some(model)),
        }
    }

    fn set_state(&mut self, turn: &mut Turn) -> Answer {
        let pointer = self.any_state(turn);
        let known = self.known(turn, pointer);
        let mut after = turn.model.clone();
        let mut is_good = false;
        let mut bytes = None;
        if let Some(known) = known {
            let saved = &self.saved(turn)[known];
            after = saved.model.clone();
            // Of Event Mode, without which the instance was made.
            is_good = after.state != 2 || turn.events.is_some();
            bytes = Some(saved.bytes.clone());
        }
        // SAFETY: the address is only compared.
        let status = unsafe { (self.library.set_fmu_state)(turn.instance, pointer) };
        if let (OK, Some(bytes)) = (status, bytes) {
            self.slot(turn.place).bytes = bytes;
        }
        Answer { status, expected: ok_if(turn.allowed && is_good), arguments: format!("{pointer:?}"), after }
    }

    fn free_state(&mut self, turn: &mut Turn) -> Answer {
        let before = self.any_state(turn);
        let (mut pointer, null) = (before, turn.random.once_in(16));
        let known = self.known(turn, before);
        let expected = ok_if(turn.allowed && !null && (before.is_null() || known.is_some()));
        let target = if null { ptr::null_mut() } else { &raw mut pointer };
        // SAFETY: NULL or a variable of the host; the address in it is only compared.
        let status = unsafe { (self.library.free_fmu_state)(turn.instance, target) };
        assert_eq!(pointer, if status == OK { ptr::null_mut() } else { before }, "{status}");
        if let (OK, Some(known)) = (status, known) {
            self.slot(turn.place).saved.remove(known);
            self.freed.push(before);
        }
        turn.unchanged(status, expected, format!("{before:?}"))
    }

    fn serialized_size(&self, turn: &mut Turn) -> Answer {
        let pointer = self.any_state(turn);
        let length = self.known(turn, pointer).map(|known| self.saved(turn)[known].bytes.len());
        let (mut size, null) = (4711, turn.random.once_in(16));
        let target = if null { ptr::null_mut() } else { &raw mut size };
        // SAFETY: NULL or a variable of the host; the address is only compared.
        let status = unsafe { (self.library.serialized_fmu_state_size)(turn.instance, pointer, target) };
        assert_eq!(size, length.filter(|_| status == OK).unwrap_or(4711));
        turn.unchanged(status, ok_if(turn.allowed && length.is_some() && !null), format!("{pointer:?}"))
    }

    fn serialize(&mut self, turn: &mut Turn) -> Answer {
        let pointer = self.any_state(turn);
        let known = self.known(turn, pointer);
        let saved = known.map(|known| &self.saved(turn)[known]);
        let length = saved.map_or(300, |saved| saved.bytes.len());
        let size = match turn.random.below(6) {
            0 => turn.random.below(length),
            1 => usize::MAX,
            _ => length,
        };
        let null = turn.random.once_in(16);
        let expected = ok_if(turn.allowed && known.is_some() && !null && size == length);
        let mut room = vec![0xAA; if size == usize::MAX { 0 } else { size }];
        let target = if null { ptr::null_mut() } else { room.as_mut_ptr() };
        // SAFETY: as many bytes as said, or counts and pointers that are to be refused.
        let status = unsafe { (self.library.serialize_fmu_state)(turn.instance, pointer, target, size) };
        match saved.filter(|_| status == OK) {
            Some(saved) => {
                assert!(room == saved.bytes, "the state's bytes have changed");
                let blob = (saved.bytes.clone(), saved.model.clone());
                if self.blobs.len() == MOST {
                    self.blobs.remove(0);
                }
                self.blobs.push(blob);
            }
            None => assert!(room.iter().all(|byte| *byte == 0xAA), "refused, but wrote"),
        }
        turn.unchanged(status, expected, format!("{pointer:?}, {size}"))
    }

    fn dependencies(&self, turn: &mut Turn) -> Answer {
        let is_output = |reference: u32| {
            let row = self.fmu.variables.get(reference as usize).map(|row| row.role);
            let text = self.fmu.texts.get((reference as usize).wrapping_sub(self.fmu.variables.len()));
            row.or(text.map(|text| text.role)) == Some(Role::Output)
        };
        let references = self.references(turn.random, is_output);
        let reference = references.first().copied().unwrap_or_default();
        let null = turn.random.once_in(16);
        let from = self.fmu.variables.get(reference as usize).map_or(0, |row| row.from.len());
        // What the last call left depends on nothing; what a restart leaves, on settings.
        let known = if turn.model.state == 1 { from } else { 0 };
        let (mut found, library) = (4711, &self.library);
        let target = if null { ptr::null_mut() } else { &raw mut found };
        if turn.name == "fmi3GetNumberOfVariableDependencies" {
            // SAFETY: NULL or a variable of the host.
            let status = unsafe { (library.get_number_of_variable_dependencies)(turn.instance, reference, target) };
            assert_eq!(found, if status == OK { known } else { 4711 });
            let expected = ok_if(turn.allowed && is_output(reference) && !null);
            return turn.unchanged(status, expected, format!("{reference}"));
        }
        let count = if turn.random.once_in(4) { turn.random.below(9) } else { known };
        let [mut one, mut two] = [[47_usize; 64], [47_usize; 64]];
        let (mut variables, mut kinds) = ([47_u32; 64], [47; 64]);
        let to_kinds = if null { ptr::null_mut() } else { kinds.as_mut_ptr() };
        let function = library.get_variable_dependencies;
        let (one_of, two_of) = (one.as_mut_ptr(), two.as_mut_ptr());
        // SAFETY: room for 64, and counts far below that.
        let status =
            unsafe { function(turn.instance, reference, one_of, variables.as_mut_ptr(), two_of, to_kinds, count) };
        let written = if status == OK { count } else { 0 };
        assert!(variables[written..].iter().all(|of| *of == 47) && kinds[written..].iter().all(|of| *of == 47));
        assert!(variables[..written].iter().all(|of| (*of as usize) < self.fmu.variables.len()));
        let is_good = is_output(reference) && count == known && (count == 0 || !null);
        turn.unchanged(status, ok_if(turn.allowed && is_good), format!("{reference}, {count}"))
    }

    /// What hosts of co-simulation do not call, or to no end.
    fn other(&self, turn: &mut Turn) -> Answer {
        let count = turn.random.pick(&[0, 0, 1, 5, usize::MAX]);
        let (library, instance, vr) = (&self.library, turn.instance, [0_u32; 8].as_ptr());
        let (null, sizes) = (ptr::null_mut(), ptr::null_mut());
        let (seed, orders) = (ptr::null(), ptr::null());
        // SAFETY: NULL or a living instance, and counts of 0 or that are to be refused.
        let status = unsafe {
            match turn.name {
                "fmi3GetBinary" => (library.get_binary)(instance, vr, count, sizes, ptr::null_mut(), count),
                "fmi3SetBinary" => (library.set_binary)(instance, vr, count, ptr::null(), ptr::null(), count),
                "fmi3GetDirectionalDerivative" => {
                    (library.get_directional_derivative)(instance, vr, count, vr, count, seed, count, null, count)
                }
                "fmi3GetAdjointDerivative" => {
                    (library.get_adjoint_derivative)(instance, vr, count, vr, count, seed, count, null, count)
                }
                "fmi3EnterConfigurationMode" => (library.enter_configuration_mode)(instance),
                "fmi3ExitConfigurationMode" => (library.exit_configuration_mode)(instance),
                "fmi3GetOutputDerivatives" => {
                    (library.get_output_derivatives)(instance, vr, count, orders, null, count)
                }
                name => match self.foreign.call(name, instance, count) {
                    Some(status) => status,
                    None if name.starts_with("fmi3Get") => return with_type!(name, self.get(turn)),
                    None => return with_type!(name, self.set(turn)),
                },
            }
        };
        let expected = ok_if(turn.allowed && count == 0);
        turn.unchanged(status, expected, format!("{count}"))
    }
}
