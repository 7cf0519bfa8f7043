//! FMU states: fmi2GetFMUstate to fmi2DeSerializeFMUstate.

use crate::calls::{Answer, Turn};
use crate::host::{Host, Saved};
use crate::model::{Expected, ok_if};
use host::library::Pointer;
use std::ptr;
use tests::Status;

/// An instance holds this many states; then the host reuses them.
const MOST_STATES: usize = 12;
/// The host keeps this many serialized states.
const MOST_BLOBS: usize = 8;

impl Host<'_> {
    pub(crate) fn get_fmu_state(&mut self, turn: &mut Turn) -> Answer {
        let mut pointer = self.state_to_fill(turn);
        let before = pointer;
        let null = turn.random.once_in(16);
        let known = self.known(turn, pointer);
        let expected = ok_if(turn.allowed && is_fillable(null, pointer, known));
        let target = if null { ptr::null_mut() } else { &raw mut pointer };
        // SAFETY: NULL or a variable of the host; the address in it is only compared.
        let status = unsafe { (self.fmu.library.get_fmu_state)(turn.component, target) }.into();
        let arguments = format!("{before:?}");
        let bytes = self.slot(turn.place).bytes.clone();
        let state = Saved { pointer, model: turn.model.clone(), bytes };
        self.keep(turn, &arguments, status, before, state);
        turn.unchanged(status, expected, arguments)
    }

    pub(crate) fn set_fmu_state(&mut self, turn: &mut Turn) -> Answer {
        let pointer = self.state_pointer(turn.random, turn.place);
        let known = self.known(turn, pointer);
        let expected = ok_if(turn.allowed && known.is_some());
        // SAFETY: the address is only compared.
        let status = unsafe { (self.fmu.library.set_fmu_state)(turn.component, pointer) }.into();
        let mut after = turn.model.clone();
        if let (Status::Ok, Some(known)) = (status, known) {
            let slot = self.slot(turn.place);
            after = slot.saved[known].model.clone();
            slot.bytes = slot.saved[known].bytes.clone();
        }
        Answer { status, expected, arguments: format!("{pointer:?}"), after }
    }

    pub(crate) fn free_fmu_state(&mut self, turn: &mut Turn) -> Answer {
        let mut pointer = self.state_pointer(turn.random, turn.place);
        let before = pointer;
        let null = turn.random.once_in(16);
        let known = self.known(turn, pointer);
        let expected = ok_if(turn.allowed && is_fillable(null, pointer, known));
        let target = if null { ptr::null_mut() } else { &raw mut pointer };
        // SAFETY: NULL or a variable of the host; the address in it is only compared.
        let status = unsafe { (self.fmu.library.free_fmu_state)(turn.component, target) }.into();
        let arguments = format!("{before:?}");
        let what = turn.with(&arguments);
        if status == Status::Ok {
            assert!(pointer.is_null(), "{what} left the address of a freed state");
            if let Some(known) = known {
                self.slot(turn.place).saved.remove(known);
                self.freed.push(before);
            }
        } else {
            assert_eq!(pointer, before, "{what} was refused but changed the address");
        }
        turn.unchanged(status, expected, arguments)
    }

    pub(crate) fn serialized_fmu_state_size(&mut self, turn: &mut Turn) -> Answer {
        let pointer = self.state_pointer(turn.random, turn.place);
        let length = self.length_of(turn, pointer);
        let null = turn.random.once_in(16);
        let expected = ok_if(turn.allowed && length.is_some() && !null);
        let mut size = 4711;
        let target = if null { ptr::null_mut() } else { &raw mut size };
        // SAFETY: NULL or a variable of the host; the address is only compared.
        let status = unsafe { (self.fmu.library.serialized_fmu_state_size)(turn.component, pointer, target) }.into();
        let arguments = format!("{pointer:?}");
        let written = length.filter(|_| status == Status::Ok).unwrap_or(4711);
        assert_eq!(size, written, "{}", turn.with(&arguments));
        turn.unchanged(status, expected, arguments)
    }

    pub(crate) fn serialize_fmu_state(&mut self, turn: &mut Turn) -> Answer {
        let pointer = self.state_pointer(turn.random, turn.place);
        let known = self.length_of(turn, pointer);
        let null = turn.random.once_in(16);
        let length = known.unwrap_or(300);
        let size = match turn.random.below(6) {
            0 => turn.random.below(length),
            1 => length + turn.random.below(9),
            2 => usize::MAX,
            _ => length,
        };
        let expected = serialize_expected(turn, known, null, size);
        let mut room = vec![0xAA; if size > isize::MAX as usize { 0 } else { size }];
        let target = if null { ptr::null_mut() } else { room.as_mut_ptr() };
        let serialize = self.fmu.library.serialize_fmu_state;
        // SAFETY: as many bytes as said, or counts and pointers that are to be refused.
        let status = unsafe { serialize(turn.component, pointer, target, size) }.into();
        let arguments = format!("{pointer:?}, {size}");
        let what = turn.with(&arguments);
        if let (Status::Ok, Some(known)) = (status, self.known(turn, pointer)) {
            let saved = &self.slot(turn.place).saved[known];
            assert!(room[..length] == saved.bytes, "{what}: the state's bytes have changed");
            assert!(room[length..].iter().all(|byte| *byte == 0xAA), "{what} wrote behind the state");
            let blob = (saved.bytes.clone(), saved.model.clone());
            if self.blobs.len() < MOST_BLOBS {
                self.blobs.push(blob);
            } else {
                self.blobs[turn.random.below(MOST_BLOBS)] = blob;
            }
        } else {
            assert!(room.iter().all(|byte| *byte == 0xAA), "{what} was refused but wrote");
        }
        turn.unchanged(status, expected, arguments)
    }

    pub(crate) fn deserialize_fmu_state(&mut self, turn: &mut Turn) -> Answer {
        let (bytes, good) = self.serialized(turn.random);
        let mut pointer = self.state_to_fill(turn);
        let before = pointer;
        let (null, null_target) = (turn.random.once_in(16), turn.random.once_in(16));
        let size = if turn.random.once_in(16) { usize::MAX } else { bytes.len() };
        let good_bytes = good.is_some() && !null && size == bytes.len();
        let known = self.known(turn, pointer);
        let expected = ok_if(turn.allowed && good_bytes && is_fillable(null_target, pointer, known));
        let target = if null_target { ptr::null_mut() } else { &raw mut pointer };
        let from = if null { ptr::null() } else { bytes.as_ptr() };
        let deserialize = self.fmu.library.deserialize_fmu_state;
        // SAFETY: as many bytes as said, or counts and pointers that are to be refused; the address in the variable is
        // only compared.
        let status = unsafe { deserialize(turn.component, from, size, target) }.into();
        let arguments = format!("{bytes:?}, {size}, {before:?}");
        if let Some(model) = good {
            self.keep(turn, &arguments, status, before, Saved { pointer, model, bytes });
        } else {
            assert_eq!(pointer, before, "{} was refused but gave a state", turn.with(&arguments));
        }
        turn.unchanged(status, expected, arguments)
    }

    /// The address of a state that a function is to fill: NULL for a new one, as long as there are not too many.
    fn state_to_fill(&self, turn: &mut Turn) -> Pointer {
        let full = self.slots[turn.place].as_ref().unwrap().saved.len() >= MOST_STATES;
        if full || turn.random.once_in(3) { self.state_pointer(turn.random, turn.place) } else { ptr::null_mut() }
    }

    /// Where the instance's state at an address stands among its saved ones.
    fn known(&self, turn: &Turn, pointer: Pointer) -> Option<usize> {
        self.slots[turn.place].as_ref().unwrap().saved.iter().position(|saved| saved.pointer == pointer)
    }

    /// How many bytes the instance's state at an address has.
    fn length_of(&self, turn: &Turn, pointer: Pointer) -> Option<usize> {
        let known = self.known(turn, pointer)?;
        Some(self.slots[turn.place].as_ref().unwrap().saved[known].bytes.len())
    }

    /// Keeps a state that was filled, and checks its address; `before` is what stood in the host's variable.
    fn keep(&mut self, turn: &Turn, arguments: &str, status: Status, before: Pointer, state: Saved) {
        let (what, pointer) = (turn.with(arguments), state.pointer);
        if status != Status::Ok {
            assert_eq!(pointer, before, "{what} was refused but gave a state");
            return;
        }
        assert!(!pointer.is_null() && (before.is_null() || before == pointer), "{what} gave {pointer:?}");
        match self.known(turn, before) {
            Some(known) => self.slot(turn.place).saved[known] = state,
            None => self.slot(turn.place).saved.push(state),
        }
        self.freed.retain(|address| *address != pointer);
    }
}

/// A variable of the host with NULL or the address of one of the instance's own states in it.
fn is_fillable(null: bool, pointer: Pointer, known: Option<usize>) -> bool {
    !null && (pointer.is_null() || known.is_some())
}

/// A state of this instance, and room for its bytes.
fn serialize_expected(turn: &Turn, known: Option<usize>, null: bool, size: usize) -> Expected {
    let has_room = known.is_some_and(|length| (length..=isize::MAX as usize).contains(&size));
    ok_if(turn.allowed && has_room && !null)
}
